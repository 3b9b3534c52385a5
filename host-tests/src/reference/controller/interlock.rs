//! The interlock: what its opening does to light and motion (SPEC 9, docs/safety.md).
use super::super::axis::{Mode, Motion, Why};
use super::super::light::{Act, INTERLOCK};
use super::Controller;
use super::answer::EITHER;

/// See the module text.
pub struct Interlock {
    /// The input, and as the tick has sampled it.
    pub open: bool,
    pub sampled: bool,
    /// It opens in this tick, before or after its calls act.
    opens: bool,
    /// SetInterlock: 0 motion goes on, 1 as where the link is lost, 2 it stops abruptly.
    pub motion: i16,
    /// Ticks since it was open.
    closed: u32,
}

impl Default for Interlock {
    fn default() -> Interlock {
        Interlock { open: false, sampled: false, opens: false, motion: 1, closed: u32::MAX }
    }
}

impl Interlock {
    /// It keeps lasers dark, also in the tick that samples that it is over.
    pub fn is_cause(&self) -> bool {
        self.open || self.sampled
    }

    /// It opens in this tick, and all motion stops abruptly.
    pub fn halts_all(&self) -> bool {
        self.opens && self.motion == 2
    }

    /// The answer to a clear or an on command while it is a cause.
    pub fn refusal(&self) -> i16 {
        if self.opens { EITHER } else { 1 }
    }

    /// The contract has a tick from an input to what it does.
    pub fn is_just_closed(&self) -> bool {
        self.closed < 3
    }
}

impl Controller {
    /// The input of a tick, before its calls. Motion brakes in the tick in which it opens, and not
    /// after that.
    pub(super) fn sample_interlock(&mut self) {
        let opens = self.interlock.open && !self.interlock.sampled;
        self.interlock.sampled = self.interlock.open;
        self.interlock.opens = opens;
        self.interlock.closed = if self.interlock.open { 0 } else { self.interlock.closed.saturating_add(1) };
        if !opens {
            return;
        }
        if self.light.channels.iter().any(|channel| channel.owner.fault != 0) {
            self.open = Some("an interlock that opens beside another fault");
        }
        self.light.calls.push(Act::Dark(INTERLOCK));
        *self.used.entry("interlocks opened").or_default() += 1;
        let abrupt = match self.interlock.motion {
            0 => return,
            motion => motion == 2,
        };
        self.unsettle(u8::MAX);
        // PT, PVT, Follow and a Trap move come to their end; Jog has none.
        for axis_index in 0..self.axes.len() {
            let axis = &self.axes[axis_index];
            if axis.runs() && !axis.driven && (abrupt || axis.mode == Mode::Jog) {
                *self.used.entry("motions that an interlock ends").or_default() += 1;
                // A program knows nothing of it: docs/motion.md.
                self.axes[axis_index].broken |= matches!(self.axes[axis_index].motion, Some(Motion::Stream(..)));
                self.stop_axis(axis_index, abrupt, Why::Interlock);
            }
        }
        let running: Vec<_> = self.crds.iter().filter(|(_, crd)| crd.runs).map(|(name, _)| *name).collect();
        for name in running {
            *self.used.entry("motions that an interlock ends").or_default() += 1;
            self.stop_path(name, abrupt, Why::Interlock);
        }
    }
}
