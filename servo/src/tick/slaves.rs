//! The part of a tick for axes that follow others.
//!
//! In: the tick in which all other axes have taken their step, entries, inputs. Out: the steps of
//! the slaves, masters before their slaves; the effects of their entries on outputs. Owns: nothing.
//! Work: as of any axis; a tick without slaves does not come here.
use super::hand_overs::HandOvers;
use crate::axis::AxisState;
use crate::capacity::{GeneralInputs, GeneralOutputs};
use crate::port::{AxisInputs, Port};
use crate::segment::follow::{Input, MasterPosition, OutputActions};
use crate::segment::piece::Motion;
use crate::tick::{MotionSource, Tick, TickHalves, report_event};
use crate::units::{Axis, AxisMask, Crd, Ns};
use crate::view::{Event, View};

/// The state of an axis: one before or after the slave, or the slave itself.
struct MasterAxes<'a> {
    before: &'a [AxisState],
    after: &'a [AxisState],
}

impl MasterAxes<'_> {
    fn at(&self, index: usize) -> Option<&AxisState> {
        let count = self.before.len();
        if index < count { self.before.get(index) } else { self.after.get(index.wrapping_sub(count).wrapping_sub(1)) }
    }
}

/// Servos that entries switch in one tick.
pub(crate) struct Switched {
    pub(crate) on: u64,
    pub(crate) off: u64,
}

impl Switched {
    /// The last one counts.
    fn take(&mut self, mask: u64, high: bool) {
        (self.on, self.off) =
            if high { (self.on | mask, self.off & !mask) } else { (self.on & !mask, self.off | mask) };
    }
}

/// The level of an input.
fn level(inputs: AxisInputs, input: Input) -> bool {
    match input {
        Input::LimitPositive => inputs.limit_positive,
        Input::LimitNegative => inputs.limit_negative,
        Input::Alarm => inputs.alarm,
        Input::Home => inputs.home,
        Input::Arrive => inputs.arrive,
        Input::General => false,
    }
}

impl<const AXES: usize> Tick<AXES> {
    /// Every slave takes its step, after its master.
    #[inline(never)]
    pub(crate) fn step_slaves(&mut self, next: Ns, port: &mut impl Port, halves: &mut TickHalves<AXES>) {
        let (period, limit) = (self.period, self.step_limit);
        let mut all_follow = true;
        // A shaped segment is three pieces of one slave: more than other axes enter in the same
        // time.
        let mut left = 1u32.wrapping_add((self.period.0 >> 16) as u32);
        let mut switched = Switched { on: 0, off: 0 };
        for turn in 0..AXES {
            let Some(axis) = self.order.at(turn) else { break };
            let index = axis.index();
            let has_slaves = self.order.leaders.has(axis);
            let straight = self.axes.get(index).and_then(|state| {
                let follower = state.follower().filter(|follower| follower.braking.is_none())?;
                self.axes.get(follower.master.axis.index())?.straight(follower)
            });
            let Some(state) = self.axes.get_mut(index) else { break };
            if left > 0
                && state.is_open_run()
                && let Some(store) = halves.segments.get(index)
            {
                state.prepare_run(store);
                left = left.wrapping_sub(1);
            }
            if !straight.is_some_and(|to| state.fast_step(to, period, has_slaves, limit)) {
                all_follow &= self.step_slave(axis, next, &mut switched, port, halves);
            }
            let Some(state) = self.axes.get_mut(index) else { break };
            if state.changed {
                state.update_status();
            }
            port.set_point(axis, state.set_point());
            self.catch_up(axis, halves.view.buffer());
        }
        if switched.on | switched.off != 0 {
            self.switch_servos(switched, next, halves);
            all_follow = false;
        }
        if !all_follow {
            self.renew_order();
        }
    }

    /// One slave takes its step, whatever that is; whether it still follows.
    #[inline(never)]
    fn step_slave(
        &mut self,
        axis: Axis,
        next: Ns,
        switched: &mut Switched,
        port: &mut impl Port,
        halves: &mut TickHalves<AXES>,
    ) -> bool {
        let (now, period, limit, index) = (self.now, self.period, self.step_limit, axis.index());
        let has_slaves = self.order.leaders.has(axis);
        let general = port.general_inputs();
        let Some((before, others)) = self.axes.split_at_mut_checked(index) else { return false };
        let (Some((state, after)), Some(store)) = (others.split_first_mut(), halves.segments.get(index)) else {
            return false;
        };
        let others = MasterAxes { before, after };
        let mut actions = OutputActions::default();
        let raw = state.raw;
        let master_sample =
            state.master().and_then(|(axis, value)| Some(others.at(axis.index())?.master_sample(value, now, period)));
        let stopped = if let Some(master_sample) = master_sample {
            let levels = |input: Input, index: u8| match input {
                Input::General => general >> (index as u32 & GeneralInputs::BITS.wrapping_sub(1)) & 1 == 1,
                _ => level(others.at(index as usize).map_or(raw, |other| other.raw), input),
            };
            state.step_follow(&master_sample, has_slaves, limit, (store, levels, &mut actions))
        } else if state.runs() {
            // A stop came meanwhile.
            state.step(next, &MotionSource { segments: store, tables: halves.tables })
        } else {
            None
        };
        let follows = state.follows();
        if let Some(reason) = stopped {
            report_event(&mut halves.events, &mut self.events_lost, Event::Stopped { axis, reason, now: next });
        }
        let brakes = state.follower().and_then(|follower| follower.braking);
        if let Some(cause) = brakes {
            let motion = self.motion(axis);
            if let Some(state) = self.axes.get_mut(index)
                && let Some(reason) = state.brake(next, motion, cause, self.steps)
            {
                report_event(&mut halves.events, &mut self.events_lost, Event::Stopped { axis, reason, now: next });
            }
        }
        for (group, bit, high) in actions.outputs.into_iter().flatten() {
            let mask = 1u64 << (bit & 63);
            let set = |word: u64| if high { word | mask } else { word & !mask };
            match group {
                0 => switched.take(mask, high),
                1 => self.clear = set(self.clear),
                _ => {
                    let mask = mask as GeneralOutputs;
                    self.general = if high { self.general | mask } else { self.general & !mask };
                }
            }
        }
        follows && brakes.is_none()
    }

    /// Entries have switched servos on or off.
    #[inline(never)]
    pub(crate) fn switch_servos(&mut self, switched: Switched, next: Ns, halves: &mut TickHalves<AXES>) {
        let TickHalves { events, samples, segments, tables, paths, view, .. } = halves;
        let mut reach = HandOvers { events, samples, segments, tables: *tables, paths: *paths };
        self.servo(AxisMask(switched.on), true, next, &mut reach);
        self.servo(AxisMask(switched.off), false, next, &mut reach);
        for axis in AxisMask(switched.on | switched.off).axes() {
            if let Some(state) = self.axes.get_mut(axis.index()) {
                state.update_status();
            }
            self.catch_up(axis, view.buffer());
        }
    }

    /// The view of an axis becomes that of its state.
    #[inline(always)]
    fn catch_up(&self, axis: Axis, view: &mut View<AXES>) {
        let index = axis.index();
        if let (Some(state), Some(published), Some(inputs)) =
            (self.axes.get(index), view.axes.get_mut(index), view.inputs.get_mut(index))
            && published.version != state.published.version
        {
            if published.state_version != state.published.state_version {
                *inputs = state.raw;
            }
            state.publish(published);
        }
    }

    /// A slave was added or has left.
    #[inline(never)]
    pub(crate) fn renew_order(&mut self) {
        let axes = &self.axes;
        self.order.renew(self.used, |axis| {
            let (master, value) = axes.get(axis.index())?.master()?;
            Some(if matches!(value, MasterPosition::Planned | MasterPosition::PlannedFiltered) { master } else { axis })
        });
    }

    /// The present motion of an axis in time.
    #[inline(never)]
    pub(crate) fn motion(&self, axis: Axis) -> Motion {
        let of = |axis: Axis| Some(&self.axes.get(axis.index())?.published);
        let crd = |crd: Crd| Some(&self.crds.get(crd)?.published);
        of(axis).map_or(Motion::STANDSTILL, |published| crate::view::motion(of, crd, published, self.period))
    }
}
