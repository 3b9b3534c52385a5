//! Numbers that fields of requests and replies hold: bits, modes, states, types. Controller and
//! clients take them from here.

/// Bits of the status word of GetSts and AxisStatus (SPEC 4).
pub mod status {
    /// Drive alarm.
    pub const ALARM: u32 = 1 << 1;
    /// Following error beyond its limit.
    pub const FOLLOWING_ERROR: u32 = 1 << 4;
    /// Positive limit.
    pub const LIMIT_POSITIVE: u32 = 1 << 5;
    /// Negative limit.
    pub const LIMIT_NEGATIVE: u32 = 1 << 6;
    /// Smooth stop by an input.
    pub const STOP_SMOOTH: u32 = 1 << 7;
    /// Abrupt stop by an input.
    pub const STOP_ABRUPT: u32 = 1 << 8;
    /// Servo on.
    pub const SERVO_ON: u32 = 1 << 9;
    /// The profile runs.
    pub const RUNNING: u32 = 1 << 10;
    /// At standstill, and the encoder inside the band for the band's time.
    pub const IN_POSITION: u32 = 1 << 11;
    /// Both limits.
    pub const LIMITS: u32 = LIMIT_POSITIVE | LIMIT_NEGATIVE;
    /// Everything that stops an axis without a command.
    pub const FAULTS: u32 = ALARM | FOLLOWING_ERROR | LIMITS | STOP_SMOOTH | STOP_ABRUPT;
    /// Each bit of [`FAULTS`], and what a user reads of it.
    const FAULT_TEXTS: [(u32, &str); 6] = [
        (ALARM, "drive alarm"),
        (FOLLOWING_ERROR, "following error"),
        (LIMIT_POSITIVE, "positive limit"),
        (LIMIT_NEGATIVE, "negative limit"),
        (STOP_SMOOTH, "smooth stop by input"),
        (STOP_ABRUPT, "abrupt stop by input"),
    ];

    /// The texts of the faults of a status word.
    pub fn faults(word: u32) -> impl Iterator<Item = &'static str> {
        FAULT_TEXTS.iter().filter(move |(bit, _)| word & bit != 0).map(|(_, text)| *text)
    }
}

/// How a path came to standstill (`CrdState::path_stop`).
pub mod path_stop {
    /// It never moved.
    pub const NEVER: u8 = 0;
    /// Its entries have run out.
    pub const COMPLETED: u8 = 1;
    /// Its entries have run out at speed.
    pub const UNDERRUN: u8 = 2;
    /// A Stop; CrdStart continues it.
    pub const STOPPED: u8 = 3;
}

/// Causes of a dark laser channel (GetLaserFault); [`crate::reason::laser_cause`] says them all.
pub mod laser_fault {
    /// A servo tick began late.
    pub const OVERRUN: i16 = 3;
    /// An axis of a coordinate system that gates it hit a limit.
    pub const LIMIT: i16 = 8;
}

/// Bits of `ConfigItem::given`.
pub mod given {
    /// Which limits count.
    pub const LIMITS: u16 = 1;
    /// The sense of the limit inputs.
    pub const LIMIT_SENSE: u16 = 1 << 1;
    /// Whether the drive alarm counts.
    pub const ALARM: u16 = 1 << 2;
    /// The sense of its input.
    pub const ALARM_SENSE: u16 = 1 << 3;
    /// Soft limits.
    pub const SOFT_LIMITS: u16 = 1 << 4;
    /// Stop decelerations.
    pub const STOP_DEC: u16 = 1 << 5;
    /// The limit of the following error.
    pub const POS_ERR: u16 = 1 << 6;
    /// The in-position band and its time.
    pub const BAND: u16 = 1 << 7;
    /// The sense of the home input.
    pub const HOME_SENSE: u16 = 1 << 8;
    /// All of them.
    pub const ALL: u16 = (1 << 9) - 1;
}

/// Profile modes, as GetPrfMode and AxisStatus report them.
pub mod mode {
    /// Trap.
    pub const TRAP: i16 = 0;
    /// Jog.
    pub const JOG: i16 = 1;
    /// PT, static or dynamic.
    pub const PT: i16 = 2;
    /// Gear.
    pub const GEAR: i16 = 3;
    /// Follow.
    pub const FOLLOW: i16 = 4;
    /// A coordinate system drives the axis.
    pub const CRD: i16 = 5;
    /// PVT.
    pub const PVT: i16 = 6;
    /// FollowEx.
    pub const FOLLOW_EX: i16 = 10;
}

/// States of a PT axis, as GetPtState reports them; 0 if it never ran.
pub mod pt_state {
    /// It runs.
    pub const RUNNING: u8 = 1;
    /// It has ended.
    pub const ENDED: u8 = 2;
    /// It ran dry at speed.
    pub const UNDERRUN: u8 = 3;
    /// A Stop or a fault has ended it.
    pub const STOPPED: u8 = 4;
}

/// Types of inputs and outputs (SPEC 3).
pub mod io {
    /// Positive limit switch.
    pub const LIMIT_POSITIVE: i16 = 0;
    /// Negative limit switch.
    pub const LIMIT_NEGATIVE: i16 = 1;
    /// Drive alarm.
    pub const ALARM: i16 = 2;
    /// Home switch.
    pub const HOME: i16 = 3;
    /// General input.
    pub const GPI: i16 = 4;
    /// In-position signal of the drive.
    pub const ARRIVE: i16 = 5;
    /// Servo enable.
    pub const ENABLE: i16 = 10;
    /// Alarm clear.
    pub const CLEAR: i16 = 11;
    /// General output.
    pub const GPO: i16 = 12;
    /// Analog input.
    pub const ADC: i16 = 24;
    /// The interlock (or emergency-stop) input, of SimInput and SimPlan: the manuals have none.
    pub const INTERLOCK: i16 = 90;
}

/// The upper end of what a double of a speed, an acceleration or a ratio may say: 2³².
pub const FULL_SCALE: f64 = 4_294_967_296.0;

/// Entries of a FIFO of a coordinate system.
pub const CRD_FIFO_ENTRIES: u16 = 1024;

/// Entries between two motions that a path passes at speed; those of a servo tick (SPEC 5).
pub const PATH_EFFECTS: u32 = 32;

/// Analog inputs read ± this many volts.
pub const ANALOG_INPUT_VOLTS: f64 = 12.5;

/// Types of masters (SPEC 3).
pub mod master {
    /// An encoder of the axis's own core.
    pub const ENCODER: i16 = 1;
    /// A profile of it.
    pub const PROFILE: i16 = 2;
    /// An axis of it.
    pub const AXIS: i16 = 3;
    /// An encoder of the other core.
    pub const ENCODER_OTHER: i16 = 101;
    /// An axis of it.
    pub const AXIS_OTHER: i16 = 103;
}

/// What an axis in FollowEx waits for (`WaitReply`); 0 for nothing.
pub mod wait {
    /// An input.
    pub const INPUT: u8 = 1;
    /// The master's crossing of a position.
    pub const PASS: u8 = 2;
}

/// States of the program queue (`ProgramReply::state`).
pub mod program {
    /// No entries.
    pub const EMPTY: u8 = 0;
    /// Its clock does not run yet.
    pub const HELD: u8 = 1;
    /// Its clock runs.
    pub const RUNNING: u8 = 2;
    /// A failure has stopped it.
    pub const FAILED: u8 = 3;
    /// A Stop, an Abort or the loss of the link has stopped it.
    pub const STOPPED: u8 = 4;
}

/// Bits of `ProgramReply::reported`.
pub mod reported {
    /// `late_tag` is valid.
    pub const LATE: u8 = 1;
    /// `overran_tag` is valid.
    pub const OVERRAN: u8 = 2;
    /// A laser command that changes light was late.
    pub const LATE_LIGHT: u8 = 4;
    /// Laser channel 0 went dark because a tick took too long, or another fault took its light;
    /// channel 1 has the next bit.
    pub const DARK: u8 = 1 << DARK_SHIFT;
    /// The number of that bit.
    pub const DARK_SHIFT: u32 = 4;
}

/// Kinds of events (`EventItem`).
pub mod event {
    /// An axis came to standstill.
    pub const AXIS_STOPPED: u8 = 1;
    /// A coordinate system did.
    pub const CRD_STOPPED: u8 = 2;
    /// A laser went dark, or was cleared: reason 0.
    pub const LASER: u8 = 3;
    /// The link was lost (1) or came back (0).
    pub const LINK: u8 = 4;
    /// Servo ticks took too long: how many.
    pub const OVERRUN: u8 = 5;
    /// Events were lost: how many.
    pub const LOST: u8 = 6;
    /// An admitted laser command did nothing.
    pub const IGNORED: u8 = 7;
    /// An abort (1) or a new session (2) shut off the lasers.
    pub const SHUT_OFF: u8 = 8;
    /// A pulse width was limited: how often.
    pub const LIMITED: u8 = 9;
}

#[cfg(test)]
mod tests {
    use super::status;

    #[test]
    fn every_fault_of_a_status_word_has_one_text() {
        let mut bits = (0..32).map(|bit| 1 << bit);
        assert!(bits.all(|bit| status::faults(bit).count() == usize::from(bit & status::FAULTS != 0)));
        let faults = status::faults(status::LIMIT_NEGATIVE | status::RUNNING | status::ALARM);
        assert!(faults.eq(["drive alarm", "negative limit"]));
    }
}
