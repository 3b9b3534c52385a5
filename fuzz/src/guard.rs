//! What holds in every tick, whatever was sent: a second opinion that keeps its own record.
//!
//! In: every request sent, every answer, every cause, the controller after each tick. Fails: by a
//! panic that says what was seen. Held (SPEC 5, 6, 9):
//!
//! * no output of a laser is active before anything was sent that may make it so;
//! * while the interlock input is active, switch and energy are at rest at once, the analog output
//!   within a tick;
//! * after an overrun or a restart everything is at rest until something was sent that may clear
//!   it; after an alarm, a limit or servo-off of an axis, so is every channel whose map holds the
//!   axis's coordinate system;
//! * while nothing has come over the line for longer than the link-loss time, no channel has light,
//!   nor its switch on but in mode 3 of GUS;
//! * a channel that shows a fault is at rest;
//! * after an Abort after which nothing was sent everything is at rest, standby, pre-voltage and
//!   the switch of mode 3 too;
//! * a set-point never goes further in a tick than the step limit, never beyond the edge of travel,
//!   and stands still while its axis does not run.
use crate::bench::Sent;
use plant::beam::ChannelLevels;
use protocol::command::opcode;
use servo::laser::{self, Cause};
use servo::status::{ALARM, LIMITS, RUNNING, SERVO_ON};
use servo::tick_command::MotionMode;
use servo::view::AxisView;
use std::collections::VecDeque;
use virtual_board::Controller;

const AXES: usize = 8;
const CHANNELS: usize = 2;
/// 2³² pulse/ms, in 2⁻²² pulse a ns, rounded up.
const STEP_PER_NS: u64 = (1u64 << 54).div_ceil(1_000_000);
/// ±2⁴⁰ pulses.
const TRAVEL: u64 = 1 << 62;
/// The link-loss time until somebody changes it, ns.
const LINK_LOSS_NS: u64 = 500_000_000;
/// Ticks until what a tick sees has reached the outputs: one to act, one that the machine had been
/// reported already.
const REACTION: u32 = 2;

/// Why a channel must be at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Hold {
    None,
    /// So many ticks ago, for this.
    Since(u32, &'static str),
}

/// See the module text.
pub struct Guard {
    set_points: [i64; AXES],
    axes: [AxisView; AXES],
    /// Something that may output energy was sent.
    may_light: bool,
    /// Requests that may clear a fault and are not answered.
    clears: u32,
    /// Ticks since one may have been under way.
    quiet: u32,
    interlock: u32,
    /// Ticks since the controller was fed for the last time longer ago than the link-loss time,
    /// which nobody has changed.
    silent: Option<u32>,
    heard: u64,
    holds: [Hold; CHANNELS],
    faults: [u32; CHANNELS],
    /// Ticks since an Abort was carried out, if nothing was sent since.
    aborted: Option<u32>,
    /// Ticks looked at.
    pub ticks: u64,
}

fn lights(number: u16, body: &[u8]) -> bool {
    match number {
        opcode::LaserOn | opcode::BufLaserOn => true,
        opcode::SetWaitPulse | opcode::SetWaitPulseEx | opcode::SetPreVltg => true,
        // Mode 3 of GUS holds the switch where it is enabled.
        opcode::LaserPowerMode => body.get(2..4) == Some(&[3, 0]),
        opcode::SetHSIOOpt => body.get(2..4) != Some(&[0, 0]),
        _ => false,
    }
}

fn clears(number: u16) -> bool {
    matches!(number, opcode::ClrSts | opcode::ClrLaserFault | opcode::Reset | opcode::Choose)
}

fn at_standstill(levels: ChannelLevels) -> bool {
    !levels.switch && !levels.energy && levels.dac == 0
}

impl Guard {
    /// Of a controller at power-on.
    pub fn new(board: &mut Controller) -> Guard {
        Guard {
            set_points: std::array::from_fn(|axis| board.set_point(axis)),
            axes: std::array::from_fn(|axis| board.axis(axis)),
            may_light: false,
            clears: 0,
            quiet: u32::MAX / 2,
            interlock: 0,
            silent: Some(0),
            heard: board.now(),
            holds: [Hold::None; CHANNELS],
            faults: [0; CHANNELS],
            aborted: None,
            ticks: 0,
        }
    }

    /// A request was sent.
    pub fn sent(&mut self, number: u16, body: &[u8]) {
        self.may_light |= lights(number, body);
        self.aborted = None;
        if number == opcode::SetLinkLoss {
            self.silent = None;
        }
        if clears(number) {
            self.clears += 1;
            self.holds = [Hold::None; CHANNELS];
        }
    }

    /// A request was answered, or its answer will not come; then it may have been carried out a
    /// little later.
    pub fn answered(&mut self, number: u16) {
        if clears(number) {
            self.clears = self.clears.saturating_sub(1);
            self.quiet = 0;
        }
    }

    /// An Abort was carried out, and everything sent before it is answered.
    pub fn aborts(&mut self) {
        self.aborted = Some(0);
    }

    /// Whether no request that clears may still act.
    fn is_quiet(&self) -> bool {
        self.clears == 0 && self.quiet > 64
    }

    /// Something has reached the controller.
    pub fn fed(&mut self, now: u64) {
        self.heard = now;
    }

    /// An overrun or a restart was reported to the controller.
    pub fn cause(&mut self, awaiting: &[VecDeque<Sent>; 3]) {
        let under_way = awaiting.iter().flatten().any(|sent| clears(sent.opcode));
        if !under_way && self.is_quiet() {
            self.hold(u32::MAX, "an overrun or a restart");
        }
    }

    fn hold(&mut self, channels: u32, why: &'static str) {
        for (channel, hold) in self.holds.iter_mut().enumerate() {
            if channels >> channel & 1 == 1 && *hold == Hold::None {
                *hold = Hold::Since(0, why);
            }
        }
    }

    /// After a tick.
    pub fn look(&mut self, board: &mut Controller) {
        self.ticks += 1;
        self.aborted = self.aborted.map(|ticks| ticks + 1);
        self.quiet = self.quiet.saturating_add(1);
        self.interlock = if board.inputs_mut().interlock { self.interlock + 1 } else { 0 };
        let quiet = board.now().saturating_sub(self.heard) > LINK_LOSS_NS;
        self.silent = self.silent.map(|ticks| if quiet { ticks + 1 } else { 0 });
        let limit = board.period_ns().saturating_mul(STEP_PER_NS);
        for axis in 0..AXES {
            let (set_point, view) = (board.set_point(axis), board.axis(axis));
            let (before, seen) = (self.set_points[axis], self.axes[axis]);
            let step = set_point.abs_diff(before);
            assert!(step <= limit, "axis {} steps from {before} to {set_point}: {view:?}", axis + 1);
            assert!(view.pos.0.unsigned_abs() <= TRAVEL, "axis {}: {view:?}", axis + 1);
            let runs = |view: &AxisView| view.status & RUNNING != 0 || view.lead.is_some() || view.drive.is_some();
            assert!(
                step == 0 || runs(&view) || runs(&seen),
                "axis {} is at rest and goes from {before} to {set_point}: {view:?}",
                axis + 1
            );
            self.axis(board, axis, &seen, &view);
            (self.set_points[axis], self.axes[axis]) = (set_point, view);
        }
        for channel in 0..CHANNELS {
            self.channel(board, channel);
        }
    }

    /// What an axis does to the lasers.
    fn axis(&mut self, board: &mut Controller, axis: usize, before: &AxisView, now: &AxisView) {
        let set = now.status & !before.status;
        let why = if set & ALARM != 0 {
            "an alarm"
        } else if set & LIMITS != 0 {
            "a limit"
        } else if before.status & !now.status & SERVO_ON != 0 {
            "servo-off"
        } else {
            return;
        };
        if now.mode != MotionMode::Crd || before.mode != MotionMode::Crd || !self.is_quiet() {
            return;
        }
        for crd in 0..4 {
            let Some(frame) = board.crd(crd).frame else { continue };
            if frame.axes.iter().flatten().any(|of| of.index() == axis) {
                let mapped = (0..CHANNELS).filter(|channel| board.laser_view(*channel).crd_map >> crd & 1 == 1);
                let mapped = mapped.fold(0, |all, channel| all | 1 << channel);
                self.hold(mapped, why);
            }
        }
    }

    fn channel(&mut self, board: &mut Controller, channel: usize) {
        let (levels, view) = (board.laser(channel), board.laser_view(channel));
        let resting = at_standstill(levels);
        assert!(resting || self.may_light, "channel {channel} outputs {levels:?}, and nothing asked for it: {view:?}");
        assert!(
            self.aborted.is_none_or(|ticks| ticks <= REACTION) || resting,
            "channel {channel} after an abort: {levels:?}, {view:?}"
        );
        if self.interlock > 0 {
            assert!(!levels.switch && !levels.energy, "channel {channel} under interlock: {levels:?}");
        }
        assert!(self.interlock <= REACTION || levels.dac == 0, "channel {channel} under interlock: {levels:?}");
        // A lost link rests what has light (SPEC 9); mode 3 of GUS holds the switch where it is
        // enabled, without light too (SPEC 2).
        let open = view.mode == laser::PowerMode::DutyOpen && !levels.energy;
        // A tick to notice it and one to tell the servo, before it acts.
        assert!(
            self.silent.is_none_or(|ticks| ticks <= REACTION + 2) || !view.light && (!levels.switch || open),
            "channel {channel} is lit without a host: {levels:?}, {view:?}"
        );
        if let Hold::Since(ticks, why) = &mut self.holds[channel] {
            *ticks += 1;
            assert!(
                *ticks <= REACTION || resting,
                "channel {channel}, {ticks} ticks after {why}: {levels:?}, {view:?}"
            );
            assert!(
                *ticks <= REACTION || view.fault != Cause::None,
                "channel {channel}, {ticks} ticks after {why}: {view:?}"
            );
        }
        self.faults[channel] = if view.fault == Cause::None { 0 } else { self.faults[channel] + 1 };
        // A fault within an interval lets two plans pass, which end in the dark.
        assert!(
            self.faults[channel] <= REACTION + 2 || resting,
            "channel {channel} with a fault: {levels:?}, {view:?}"
        );
    }
}
