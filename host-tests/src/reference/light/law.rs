//! The power of a channel: SPEC 6, "Energy".
//!
//! In: settings, the speed of the path that it follows, positions of the axes. Out: what is in
//! force in light and out of it, in the mode's unit.
use super::call::Family;
use super::tables::{Line, Ratio, TABLES};

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

    /// The most of its power: %, kHz, V; where this is the highest frequency.
    pub fn most(self, highest: f64) -> f64 {
        match self {
            Mode::Duty | Mode::Open => 100.0,
            Mode::Frequency => highest,
            Mode::Analog => 10.0,
        }
    }
}

/// What gives the power of a velocity follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rule {
    /// x = ratio·v + min.
    Ratio(f64),
    /// One of [`Around::powers`].
    Table(usize),
}

/// A velocity follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follow {
    pub crd: usize,
    pub rule: Rule,
    pub bounds: [f64; 2],
}

/// Ratios of a distance follow: the same everywhere, or one of [`Around::ratios`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scaled {
    Same([f64; 4]),
    Table(usize),
}

/// A distance follow over axes 1 to 4 of the core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Positions of encoders.
    pub encoder: bool,
    pub from: [i32; 4],
    pub scale: [f64; 4],
    pub ratio: Scaled,
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
    /// No channel is analog.
    pub is_pwm: bool,
    /// Tables of power against speed and of ratios as they were set; none is changed.
    pub powers: Vec<Line>,
    pub ratios: Vec<Ratio>,
    /// What planned ones may be off beyond SPEC 11.
    pub apart: [f64; 4],
}

/// Pulses without light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standby {
    pub khz: f64,
    pub duty: f64,
    /// Only while no channel is analog (LSR, SetWaitPulseEx).
    pub paired: bool,
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
    pub standby: Option<Standby>,
    pub pre_voltage: Option<f64>,
    /// SetLaserMode: resolution mode 0 of LSR, which has the wide range of frequencies.
    pub is_wide: bool,
    /// Tables of power against speed, as [`Around::powers`] has them.
    pub tables: [Option<usize>; TABLES as usize],
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
            is_wide: false,
            tables: [None; TABLES as usize],
        }
    }

    /// The highest frequency, kHz.
    pub fn highest(&self) -> f64 {
        match (self.family, self.is_wide) {
            (Family::Gus, _) => 2000.0,
            (Family::Lsr, false) => 24.0,
            (Family::Lsr, true) => 96.0,
        }
    }

    /// The most of a power in the mode in force.
    pub fn most(&self) -> f64 {
        self.mode.most(self.highest())
    }

    /// Whether the follow in force has the speed of this path's encoders.
    pub fn counts(&self, crd: usize) -> bool {
        self.encoder && self.follow.is_some_and(|follow| follow.crd == crd)
    }

    /// Whether the follow in force reads a table, from 1.
    pub fn reads(&self, table: i16) -> bool {
        let lies = self.tables[table as usize - 1];
        self.follow.is_some_and(|follow| lies.is_some_and(|lies| follow.rule == Rule::Table(lies)))
    }

    /// SetLaserMode: what lies above a new range is held at its bound.
    pub fn set_resolution(&mut self, is_wide: bool) {
        self.is_wide = is_wide;
        let highest = self.highest();
        if let Some(standby) = &mut self.standby {
            standby.khz = standby.khz.min(highest);
        }
        if self.mode == Mode::Frequency {
            self.direct = self.direct.min(highest);
            self.bounds = self.bounds.map(|bound| bound.min(highest));
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
        if let Some(Follow { crd, rule, bounds: [min, max] }) = self.follow {
            let speed = if self.encoder { around.counted[crd] } else { around.speed[crd] };
            let (part, steepest) = match rule {
                Rule::Ratio(ratio) => (ratio * speed + min, ratio),
                Rule::Table(table) => (around.powers[table].at(speed), around.powers[table].steepest()),
            };
            // SPEC 11: 2⁻¹⁶ of the motion's own peak.
            slack = steepest * around.most[crd] * 2f64.powi(-16);
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
            let (ratios, limits) = match ratio {
                Scaled::Same(ratio) => (ratio.map(|ratio| [ratio, 0.0]), [f64::INFINITY; 4]),
                Scaled::Table(table) => (around.ratios[table].ratios.at(&at), around.ratios[table].limits),
            };
            for axis in 0..4 {
                let ([ratio, steep], displacement) = (ratios[axis], (at[axis] - f64::from(from[axis])) / scale[axis]);
                sum += (displacement * ratio).clamp(-limits[axis], limits[axis]);
                // 2⁻¹⁶ pulse.
                let apart = if encoder { 0.0 } else { around.apart[axis] };
                slack += ((ratio / scale[axis]).abs() + (displacement * steep).abs()) * (2f64.powi(-16) + apart);
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
    pub fn in_dark(&self, around: &Around) -> f64 {
        let standby = self.standby.filter(|standby| !standby.paired || around.is_pwm);
        match (self.mode, standby) {
            (Mode::Analog, _) => self.pre_voltage.unwrap_or(0.0),
            (Mode::Duty, Some(Standby { duty, .. })) if self.connector => duty,
            (Mode::Frequency, Some(Standby { khz, duty, .. })) if self.connector && duty > 0.0 => khz,
            _ => 0.0,
        }
    }
}
