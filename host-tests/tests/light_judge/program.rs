//! A program as readable calls at ticks. Coordinate systems, channels and FIFOs count from 0.
use host_tests::light_judge::fact::Laser;
use host_tests::light_judge::{Settings, Switch};
use std::fmt::{self, Display, Formatter};

/// What lies in a FIFO.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Buf {
    /// A line to X, Y (of the coordinate system's own axes): speed, acceleration, end speed.
    Line { to: [i32; 2], speed: f64, acc: f64, end: f64 },
    /// BufDelay, ms.
    Delay(u16),
    /// The mark of a boundary: an output that changes there.
    Mark,
    /// A laser entry of a channel, with the least power; a follow as BufLaserFollowRatio.
    Laser { channel: usize, laser: Laser, power: f64, ratio: bool },
}

/// What a call is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Do {
    Entry {
        crd: usize,
        fifo: usize,
        buf: Buf,
    },
    Flush {
        crd: usize,
        fifo: usize,
    },
    On {
        channel: usize,
        hsio: bool,
    },
    Off {
        channel: usize,
        hsio: bool,
    },
    Power {
        channel: usize,
        power: f64,
    },
    Map {
        channel: usize,
        map: u8,
    },
    /// Of the gate, µs.
    Delays {
        channel: usize,
        on: u32,
        off: u32,
    },
    Mode {
        channel: usize,
        mode: i16,
    },
    /// The velocity of the axis beside the paths, pulse/ms.
    Jog {
        vel: f64,
    },
    Connector {
        channel: usize,
        there: bool,
    },
    ClearFault {
        channel: usize,
    },
    ClearStatus {
        axis: usize,
        count: usize,
    },
    CrdStart {
        mask: u8,
        option: u8,
    },
    /// GT form: bits 8 and 9 name coordinate systems, 10 and 11 whose follow ends.
    Stop {
        crds: u8,
        abrupt: u8,
        ends_follow: u8,
    },
    /// GTN form.
    CrdStop {
        crds: u8,
        abrupt: u8,
    },
    /// An axis bit of Stop.
    AxisStop {
        axis: usize,
    },
    CrdClear {
        crd: usize,
        fifo: usize,
    },
    AxisOff {
        axis: usize,
    },
    AxisOn {
        axis: usize,
    },
    Abort,
    LinkLoss {
        ms: i32,
    },
    Interlock {
        motion: i16,
    },
    PosErr {
        axis: usize,
        pulses: i32,
    },
}

impl Do {
    /// Whether it sets what lasts, beyond light and motion.
    pub fn sets(&self) -> bool {
        match self {
            Do::Map { .. } | Do::Delays { .. } | Do::Mode { .. } | Do::Jog { .. } => true,
            Do::Connector { .. } | Do::Power { .. } | Do::Entry { .. } => true,
            Do::Stop { ends_follow, .. } => *ends_follow != 0,
            _ => false,
        }
    }
}

/// What happens at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Act {
    Call(Do),
    /// A drive alarm's input.
    Alarm {
        axis: usize,
        level: bool,
    },
    /// A limit switch.
    Limit {
        axis: usize,
        positive: bool,
        level: bool,
    },
    /// The interlock becomes active so many ns after the tick.
    Interlock {
        after: u64,
    },
    InterlockGone,
    Overrun,
    /// Nothing is sent any more.
    Silence,
    /// The client speaks again.
    Speaks,
    /// A new client's Hello.
    Session,
    /// The session is closed; a new one is opened by `Session`.
    Close,
}

/// Of a channel, beyond what the judge needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Device {
    pub mode: i16,
    pub power: f64,
    pub khz: f64,
    pub waiting: bool,
    pub switch: Switch,
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Program {
    pub settings: Settings,
    pub devices: [Device; 2],
    /// With which deceleration a smooth Stop brakes, pulse/ms².
    pub braking: f64,
    /// Which coordinate systems have a look-ahead.
    pub look_ahead: u8,
    /// Entries before anything runs.
    pub entries: Vec<Do>,
    /// At which ticks what happens, in order.
    pub acts: Vec<(u32, Act)>,
    /// Ticks.
    pub length: u32,
    /// How it ends, for the count.
    pub endings: Vec<&'static str>,
}

impl Program {
    /// Readable, with the instants of its calls.
    pub fn reported(&self, tick_us: u32) -> String {
        let mut text = format!("{self}");
        for (number, (at, act)) in self.acts.iter().enumerate() {
            let us = u64::from(*at) * u64::from(tick_us);
            text += &format!("{:4} {:>10.3} ms  {act:?}\n", number + 1, us as f64 / 1000.0);
        }
        text
    }
}

impl Display for Program {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        writeln!(
            f,
            "GUS {}, set up {:02b}, look-ahead {:02b}",
            self.settings.is_gus, self.settings.set_up, self.look_ahead
        )?;
        for (channel, (of, device)) in self.settings.channels.iter().zip(&self.devices).enumerate() {
            writeln!(f, "channel {channel}: {of:?} {device:?}")?;
        }
        for entry in &self.entries {
            writeln!(f, "     {entry:?}")?;
        }
        Ok(())
    }
}
