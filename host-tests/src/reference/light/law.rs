//! The power of a channel: SPEC 6, "Energy".
//!
//! In: settings, the speed of the path that it follows, positions of the axes. Out: what is in
//! force in light and out of it, in the mode's unit.
use super::call::Family;

/// Power mode: mode 3 of the LSR family is mode 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    #[default]
    Duty,
    Frequency,
    Analog,
    /// GUS mode 3: the switch is held at its enabled level.
    Open,
}

impl Mode {
    pub fn of(number: i16, family: Family) -> Mode {
        match number {
            1 => Mode::Frequency,
            2 => Mode::Analog,
            3 if family == Family::Gus => Mode::Open,
            _ => Mode::Duty,
        }
    }

    /// The most of its power: %, kHz, V.
    pub fn most(self, family: Family) -> f64 {
        match self {
            Mode::Duty | Mode::Open => 100.0,
            Mode::Frequency => carriers(family),
            Mode::Analog => 10.0,
        }
    }
}

/// The highest frequency, kHz; LSR: resolution mode 1.
pub fn carriers(family: Family) -> f64 {
    if family == Family::Gus { 2000.0 } else { 24.0 }
}

/// A velocity follow: x = ratio·v + min.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follow {
    pub crd: usize,
    pub ratio: f64,
    pub bounds: [f64; 2],
}

/// A distance follow over axes 1 to 4 of the core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Positions of encoders.
    pub encoder: bool,
    pub from: [i32; 4],
    pub scale: [f64; 4],
    pub ratio: [f64; 4],
    /// GUS.
    pub bounds: Option<[f64; 2]>,
}

/// What the power depends on at a tick.
#[derive(Debug, Clone, Default)]
pub struct Around {
    /// Mean planned speed of the coming tick, and the most that there may be; by coordinate system.
    pub speed: [f64; 2],
    pub most: [f64; 2],
    /// Speed of the encoders, filtered.
    pub counted: [f64; 2],
    /// Positions of axes 1 to 4, planned and of encoders.
    pub at: [[f64; 4]; 2],
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Law {
    pub family: Family,
    pub mode: Mode,
    pub connector: bool,
    pub carrier: bool,
    pub width: bool,
    pub bounds: [f64; 2],
    pub direct: f64,
    /// BufLaserFollowMode: the encoders' speed.
    pub encoder: bool,
    pub follow: Option<Follow>,
    pub distance: Option<Distance>,
    /// kHz and %.
    pub standby: Option<[f64; 2]>,
    pub pre_voltage: Option<f64>,
}

impl Law {
    pub fn power_on(family: Family) -> Law {
        Law {
            family,
            mode: Mode::Duty,
            connector: family == Family::Lsr,
            carrier: false,
            width: false,
            bounds: [0.0, 100.0],
            direct: 0.0,
            encoder: false,
            follow: None,
            distance: None,
            standby: None,
            pre_voltage: None,
        }
    }

    /// Whether the energy has an output.
    pub fn has_output(&self) -> bool {
        self.connector || self.mode == Mode::Analog
    }

    /// A direct power ends a follow of the GUS family.
    pub fn take_direct(&mut self, power: f64) {
        self.direct = power;
        if self.family == Family::Gus {
            self.follow = None;
        }
    }

    /// Whether bounds exclude each other in a way that the contract does not say.
    pub fn is_unsaid(&self) -> bool {
        let Some(follow) = self.follow.filter(|_| self.family == Family::Gus && self.distance.is_some()) else {
            return false;
        };
        let [low, high] = self.bounds;
        follow.bounds[1] < low || follow.bounds[0] > high
    }

    /// The power that the sum gives, in its bounds, and how well that is known.
    fn sum(&self, around: &Around) -> [f64; 2] {
        let [mut low, mut high] = self.bounds;
        let (mut sum, mut slack) = (self.direct, 0.0);
        if let Some(Follow { crd, ratio, bounds: [min, max] }) = self.follow {
            let speed = if self.encoder { around.counted[crd] } else { around.speed[crd] };
            // SPEC 11: 2⁻¹⁶ of the motion's own peak.
            slack = ratio * around.most[crd] * 2f64.powi(-16);
            let part = ratio * speed + min;
            match self.family {
                Family::Gus => {
                    sum = part.max(min).min(max);
                    if self.distance.is_none() {
                        (low, high) = (low.max(min), high.min(max));
                    }
                }
                Family::Lsr => {
                    sum += part;
                    (low, high) = (low.max(min), high.min(max));
                }
            }
        }
        if let Some(Distance { encoder, from, scale, ratio, bounds }) = self.distance {
            let at = around.at[usize::from(encoder)];
            for axis in 0..4 {
                sum += (at[axis] - f64::from(from[axis])) / scale[axis] * ratio[axis];
                // 2⁻¹⁶ pulse.
                slack += (ratio[axis] / scale[axis]).abs() * 2f64.powi(-16);
            }
            if let Some([min, max]) = bounds.filter(|_| self.family == Family::Gus) {
                (low, high) = (low.max(min), high.min(max));
            }
        }
        [sum.max(low).min(high), slack]
    }

    /// What is output in light, and how well that is known.
    pub fn in_light(&self, around: &Around) -> [f64; 2] {
        let pulses = match self.mode {
            Mode::Analog => true,
            Mode::Frequency => self.connector && self.width,
            Mode::Duty | Mode::Open => self.connector && self.carrier,
        };
        if pulses { self.sum(around) } else { [0.0; 2] }
    }

    /// What is output in the dark: standby pulses or the pre-voltage.
    pub fn in_dark(&self) -> f64 {
        match (self.mode, self.standby) {
            (Mode::Analog, _) => self.pre_voltage.unwrap_or(0.0),
            (Mode::Duty, Some([_, duty])) if self.connector => duty,
            (Mode::Frequency, Some([khz, duty])) if self.connector && duty > 0.0 => khz,
            _ => 0.0,
        }
    }
}
