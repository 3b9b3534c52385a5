//! The facts that the judge gets. Coordinate systems, channels and FIFOs count from 0; a set of
//! coordinate systems is a bit mask.
use super::Ns;
use super::gate::Timing;

/// Something that happened between two instants (the same one, where it is exact).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fact {
    /// Not before.
    pub lo: Ns,
    /// Not after.
    pub hi: Ns,
    /// What.
    pub what: What,
}

impl Fact {
    /// At an exact instant.
    pub fn at(at: Ns, what: What) -> Fact {
        Fact { lo: at, hi: at, what }
    }
}

/// A buffered laser entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Laser {
    /// BufLaserOn.
    On,
    /// BufLaserOff.
    Off,
    /// BufLaserPrfCmd.
    Power,
    /// BufLaserPrfFollow, BufLaserFollowRatio.
    Follow,
    /// BufLaserFollowOff.
    FollowOff,
    /// BufLaserFollowMode without a start power.
    Source,
}

/// How a coordinate system came to standstill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// Its entries ran out.
    Done,
    /// They ran out at speed.
    Underrun,
    /// It was stopped, by whatever it was.
    Stopped,
}

/// What happened. `code` is what the controller answered; where that is `sure`, it must fit the
/// rules.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum What {
    /// LaserOn, SetHSIOOpt(1).
    On { channel: usize, code: i16, sure: bool },
    /// LaserOff, SetHSIOOpt(0).
    Off { channel: usize },
    /// LaserPrfCmd.
    Power { channel: usize },
    /// SetLaserCrdMap.
    Map { channel: usize, map: u8, code: i16, sure: bool },
    /// SetLevelDelay.
    Delays { channel: usize, on: Ns, off: Ns },
    /// LaserPowerMode with another mode.
    Mode { channel: usize },
    /// An axis apart from the paths begins to move, or has come to standstill.
    Jog { runs: bool },
    /// SetAxisMode of the channel's connector, where the output needs one.
    Connector { channel: usize, there: bool },
    /// ClrLaserFault (`by_name`) or ClrSts was done, and whether the cause was gone by then.
    Cleared { channels: u8, gone: bool, by_name: bool },
    /// CrdClear.
    CrdClear { crd: usize, fifo: usize },
    /// CrdStart was done.
    Start { crd: usize, fifo: usize },
    /// One Stop command: those it names, and whose power follow it ends.
    Stop { crds: u8, ends_follow: u8 },
    /// A buffered laser entry was reached.
    Entry { crd: usize, channel: usize, laser: Laser },
    /// A coordinate system came to standstill.
    Rest { crd: usize, why: Why },
    /// A cause of SPEC 9 in the channels whose map holds one of these; not `sure`: perhaps one.
    Fault { crds: u8, sure: bool },
    /// A cause of SPEC 9 in every channel.
    FaultOfAll,
    /// The link is lost.
    LinkLoss,
    /// Abort.
    Abort,
    /// A new session.
    Session,
    /// A laser command was sent and never answered.
    Unanswered,
    /// The order of two events is unknown: effects on these coordinate systems are in doubt, and
    /// which path the power of these channels follows.
    Doubt { crds: u8, follows: u8 },
}

/// What a program sets before anything runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// GUS: a direct power ends a follow.
    pub is_gus: bool,
    /// Coordinate systems that SetCrdPrm has set up.
    pub set_up: u8,
    /// Of each channel.
    pub channels: [Channel; 2],
}

/// Of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Which coordinate systems may light it.
    pub map: u8,
    /// Its output is there.
    pub connector: bool,
    /// Delays and FPK.
    pub timing: Timing,
    /// What its outputs show.
    pub output: super::outputs::Output,
}
