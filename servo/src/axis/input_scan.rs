//! The scan of an axis's inputs in each tick, and the status bits that it latches.
//!
//! In: levels and encoder at the tick in force. Out: latched causes, captures, whether the axis may
//! start. Owns nothing. Cannot fail: a motion that must not go on stops.
use super::{AxisState, InputScan};
use crate::port::AxisInputs;
use crate::status;
use crate::units::Ns;
use crate::view::StopReason;

/// Causes of latched status bits, and those bits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Causes {
    /// Present now.
    pub(super) present: u32,
    /// Switches active now.
    pub(super) switches: u32,
    pub(super) latched: u32,
    /// Those that have appeared since the coordinate system took them.
    pub(super) fresh: u32,
}

impl Causes {
    pub(super) const NONE: Causes = Causes { present: 0, switches: 0, latched: 0, fresh: 0 };
}

impl AxisState {
    /// Takes the inputs of the tick in force, levels as [`AxisInputs::bits`]. Returns false where
    /// more is to be done: [`AxisState::take`]. An axis at standstill of which nothing changed
    /// costs two comparisons, and a running one little more.
    #[inline(always)]
    pub(crate) fn sample(&mut self, levels: u8, count: i64) -> bool {
        if levels != self.levels {
            return false;
        }
        let encoder = self.inputs.encoder(count);
        match self.scan {
            InputScan::Runs | InputScan::Steady | InputScan::Carried => {
                self.published.encoder_before = self.published.encoder;
                self.published.encoder = encoder;
                true
            }
            InputScan::AtRest => encoder == self.published.encoder,
            InputScan::None => false,
        }
    }

    /// Takes the inputs of the tick in force at `now` with all their effects. Returns whether
    /// levels or causes of latched bits have changed.
    #[inline(never)]
    pub(crate) fn take(&mut self, now: Ns, levels: u8, count: i64) -> bool {
        let before = self.causes.present;
        let mut at_rest = true;
        let encoder = self.inputs.encoder(count);
        if encoder != self.published.encoder_before || encoder != self.published.encoder {
            self.published.version = self.published.version.wrapping_add(1);
            at_rest = false;
        }
        if levels != self.levels {
            self.flips = levels ^ self.levels;
            (self.raw, self.levels) = (AxisInputs::of_bits(levels), levels);
            self.mark_changed();
            at_rest = false;
        }
        self.published.encoder_before = self.published.encoder;
        self.published.encoder = encoder;
        let switches = self.inputs.switches(levels);
        if switches != self.causes.switches {
            self.causes.switches = switches;
            self.set_bounds();
        }
        let runs = self.runs();
        let mut causes = self.causes.switches;
        if self.servo_on {
            causes |= self.inputs.following_error(self.published.pos, encoder);
        }
        if !runs {
            // While it runs, every step checks the soft limits.
            causes |= self.inputs.beyond(self.published.pos);
        }
        let watched = causes | self.causes.present != 0 || self.inputs.error_limit.is_some();
        if causes | self.causes.present != 0 {
            self.latch(causes);
            at_rest = false;
        }
        if runs {
            self.inputs.leave_position();
            self.in_position = false;
        } else {
            let (inside, waits) = self.inputs.in_position(now, self.published.pos, encoder);
            at_rest &= !waits && inside == self.in_position;
            self.in_position = inside;
        }
        if let Some(encoder) = self.inputs.captured(levels, encoder) {
            self.published.captured = Some(encoder);
            self.mark_changed();
            at_rest = false;
        }
        self.changed = true;
        self.scan = match (runs, at_rest) {
            (true, _) if !watched => InputScan::Runs,
            (false, true) => InputScan::AtRest,
            _ => InputScan::None,
        };
        self.causes.present != before || self.flips != 0
    }

    /// Causes of latched bits that are present, and those that have appeared since the last call.
    pub(crate) fn take_causes(&mut self) -> (u32, u32) {
        (self.causes.present, core::mem::take(&mut self.causes.fresh))
    }

    /// A limit blocks starts from when it becomes active until ClearStatus. A fault also does as
    /// long as its cause lasts.
    #[inline(never)]
    fn latch(&mut self, causes: u32) {
        let blocked = self.published.blocked | causes & (!self.causes.present | status::FAULTS);
        self.causes.fresh |= causes & !self.causes.present;
        self.causes.present = causes;
        self.causes.latched |= causes;
        self.block(blocked);
    }

    pub(super) fn block(&mut self, blocked: u32) {
        if blocked != self.published.blocked {
            self.published.blocked = blocked;
            self.mark_changed();
        }
    }

    /// ClearStatus: limits no longer block; bits whose cause is gone are cleared.
    pub(crate) fn clear_status(&mut self) {
        self.causes.latched = self.causes.present;
        self.block(self.causes.present & status::FAULTS);
    }

    /// Whether it must not start: servo off or a latched fault.
    pub(crate) fn refuses_start(&self) -> bool {
        !self.servo_on || self.published.blocked != 0
    }

    #[inline(never)]
    pub(super) fn stopped_by_fault(&mut self, next: Ns) -> StopReason {
        let alarm = self.causes.present & status::ALARM != 0;
        self.stopped_by(next, if alarm { StopReason::Alarm } else { StopReason::FollowingError })
    }

    pub(super) fn stopped_by(&mut self, next: Ns, reason: StopReason) -> StopReason {
        self.latch_limit(reason);
        self.halt(next, reason);
        reason
    }
}
