//! Whatever an axis runs, the tick asks it the same question.
use crate::piece::{Motion, Piece};
use crate::pt::{Feed, PtRun, Segments};
use crate::pvt::{PvtRun, Tables};
use crate::ramp::RampRun;
use crate::units::{Exact, Ns, Pos};

/// Whether the motion goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It does.
    Running,
    /// It has ended as told, here.
    Ended {
        /// Where exactly.
        at: Exact,
    },
    /// Dynamic PT: the ring ran dry at speed; the profile stopped here.
    Underrun {
        /// Where exactly.
        at: Exact,
    },
}

/// The motion at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Planned position.
    pub pos: Pos,
    /// The place in its piece; at rest after the end.
    pub motion: Motion,
    /// Whether it goes on.
    pub state: State,
}

/// A motion that runs. There is no heap to box the larger kind on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, Copy)]
pub enum Profile {
    /// Positions and times.
    Pt(PtRun),
    /// A table of positions, velocities and times.
    Pvt(PvtRun),
    /// Jog, Trap or Stop.
    Ramp(RampRun),
}

impl Profile {
    /// The motion at `now`, which must not go back between calls. `feed` and `source` are for PT and PVT.
    #[inline]
    pub fn step(&mut self, now: Ns, feed: Feed, source: &(impl Segments + Tables)) -> Step {
        match self {
            Profile::Pt(run) => run.step(now, feed, source),
            Profile::Pvt(run) => run.step(now, feed.passes, source),
            Profile::Ramp(run) => run.step(now),
        }
    }

    /// The piece in force, as far as the last step or turn saw.
    #[inline(always)]
    pub fn piece(&self) -> &Piece {
        match self {
            Profile::Pt(run) => run.piece(),
            Profile::Pvt(run) => run.piece(),
            Profile::Ramp(run) => run.piece(),
        }
    }

    /// Computes what follows the piece in force, if that is laborious and was not done; whether it did.
    #[inline]
    pub fn prepare(&mut self, feed: Feed, source: &(impl Segments + Tables)) -> bool {
        match self {
            Profile::Pt(run) => run.prepare(feed, source),
            Profile::Pvt(run) => run.prepare(source),
            Profile::Ramp(_) => false,
        }
    }

    /// The piece is over at `now`: on to the one that holds it, or to the end.
    #[inline]
    pub fn turn(&mut self, now: Ns, feed: Feed, source: &(impl Segments + Tables)) -> State {
        match self {
            Profile::Pt(run) => run.turn(now, feed, source),
            Profile::Pvt(run) => run.turn(now, feed.passes, source),
            Profile::Ramp(run) => run.turn(now),
        }
    }
}
