//! Follow data from bytes to the axis's store: segments, and what FollowEx queues between them.
//!
//! In: a data command. Out: entries in the store, and the FIFO's new shadow state.
//! Fails: with the parameter and the limit. Entries written by then lie after the end of the FIFO,
//! where nobody reads.
use super::context::{Context, TRAVEL_PULSES};
use super::follow::{direction, method, mode_of};
use super::one;
use super::written::{SegmentStores, Stored, Written};
use crate::plan::asymmetric_s;
use crate::refuse::{Admitted, FifoOf, Refused, choice, finite, real, within};
use crate::report::answer::Answer;
use crate::shadow::{FollowFifoShadow, ShadowChange};
use protocol::command::{
    FollowData, FollowDataPercent2Ex, FollowDataPercentEx, FollowDelayEx, FollowDiBitEx, FollowDoBitEx,
    FollowSwitchNowEx, opcode,
};
use protocol::reason::Reason;
use servo::segment::follow::{self, Direction, FollowChain, FollowEntry, Input, Method, SCurvePart};
use servo::segment::pt::SegmentStore;
use servo::tick_command::{DoGroup, MotionMode};
use servo::units::Axis;

/// Furthest master position, pulses.
const MASTER_MAX_PULSES: f64 = 2_147_483_648.0;
/// The shortest part of a segment, pulses of the master.
const PART_MIN_PULSES: f64 = 1.0 / 65536.0;
/// The largest ratio.
const SLAVE_RATIO_MAX: f64 = 17_592_186_044_416.0;

/// An entry as it was given. The fields of a segment are 2, 3, 4, 5 of its request; all other
/// entries are checked already.
#[derive(Debug, Clone, Copy)]
enum FollowItem {
    /// Master, slave, type, percent.
    Segment(f64, f64, i16, i16),
    Output(DoGroup, u8, bool),
    Delay(u32),
    Wait(Input, u8, bool, u32),
    Switch(Method),
    /// A part of an asymmetric S: master, slave, which, and the ratio at its start where it is the
    /// first.
    Part(f64, f64, SCurvePart, Option<f64>),
}

/// One FIFO that is being filled.
struct FollowFifoWrite<'x> {
    store: &'x SegmentStore,
    axis: Axis,
    fifo: u8,
    cleared: u32,
    field: u8,
    direction: Direction,
    capacity: u32,
    shadow: FollowFifoShadow,
}

impl FollowFifoWrite<'_> {
    /// The entry after the end, and the state from which the next one continues.
    fn check(&self, given: FollowItem) -> Admitted<(FollowEntry, FollowChain)> {
        if self.shadow.chain.entries() >= self.capacity {
            return Err(Refused::new(Reason::FifoFull).field(self.field).limits(0.0, self.capacity.into()));
        }
        let before = &self.shadow.chain;
        let admitted = match given {
            FollowItem::Segment(master, slave, kind, percent) => {
                FollowEntry::segment(master.to_bits(), slave.to_bits(), kind, percent, self.direction, before)
            }
            FollowItem::Output(group, bit, high) => FollowEntry::output(group, bit, high, before),
            FollowItem::Delay(cycles) => FollowEntry::delay(cycles, before),
            FollowItem::Wait(input, index, high, ms) => FollowEntry::wait_input(input, index, high, ms, before),
            FollowItem::Switch(method) => FollowEntry::switch(method, before),
            FollowItem::Part(master, slave, part, begin) => {
                let begin = begin.map(f64::to_bits);
                FollowEntry::part(master.to_bits(), slave.to_bits(), part, begin, self.direction, before)
            }
        };
        admitted.map_err(|refused| self.explain(refused, given))
    }

    /// Writes one entry after the end.
    fn add(&mut self, given: FollowItem) -> Admitted<()> {
        let (entry, chain) = self.check(given)?;
        self.store.write_entry(self.fifo, self.shadow.chain.entries(), entry);
        self.shadow.chain = chain;
        if let FollowItem::Segment(master, slave, ..) | FollowItem::Part(master, slave, ..) = given {
            (self.shadow.master, self.shadow.slave) = (master, slave);
        }
        self.shadow.switches |= matches!(given, FollowItem::Switch(Method::Table));
        Ok(())
    }

    /// What was written to this FIFO.
    fn written(&self, percent1: i16) -> (Written, ShadowChange) {
        let FollowFifoWrite { axis, fifo, cleared, shadow, .. } = *self;
        let answer = Answer::Entered { axis, fifo, percent1 };
        (Written::new(FifoOf::Axis(axis), fifo, answer), ShadowChange::FollowData { axis, fifo, cleared, data: shadow })
    }

    #[cold]
    fn explain(&self, refused: follow::Refused, given: FollowItem) -> Refused {
        let (master, slave, kind, percent) = match given {
            FollowItem::Segment(master, slave, kind, percent) => (master, slave, kind, percent),
            FollowItem::Part(master, slave, ..) => (master, slave, 0, 0),
            _ => (0.0, 0.0, 0, 0),
        };
        let before = &self.shadow;
        let ratio = (slave - before.slave) / (master - before.master);
        let most = TRAVEL_PULSES / (master - before.master).abs();
        let (field, limits) = (self.field, (0.0, self.capacity.into()));
        let (reason, field, got, (low, high)) = match refused {
            follow::Refused::MasterNotFinite => (Reason::NotFinite, 2, master, (0.0, 0.0)),
            follow::Refused::SlaveNotFinite => (Reason::NotFinite, 3, slave, (0.0, 0.0)),
            follow::Refused::MasterBeyondRange => {
                (Reason::OutOfRange, 2, master, (-MASTER_MAX_PULSES, MASTER_MAX_PULSES))
            }
            follow::Refused::SlaveBeyondTravel => (Reason::BeyondTravel, 3, slave, (-TRAVEL_PULSES, TRAVEL_PULSES)),
            follow::Refused::NotAdvancing => {
                let mixed = master * before.master < 0.0;
                let reason = if mixed { Reason::MixedSigns } else { Reason::MasterOrder };
                (reason, 2, master, (before.master, before.master))
            }
            follow::Refused::Negative => (Reason::NegativeProgress, 2, master, (0.0, 0.0)),
            follow::Refused::Kind => (Reason::Selector, 4, kind.into(), (0.0, 3.0)),
            follow::Refused::Percent => (Reason::OutOfRange, 5, percent.into(), (0.0, 100.0)),
            follow::Refused::TooSteep => (Reason::RatioTooLarge, 3, ratio, (-SLAVE_RATIO_MAX, SLAVE_RATIO_MAX)),
            follow::Refused::TooFar => (Reason::RatioTooLarge, 3, ratio, (-most, most)),
            follow::Refused::StopsFull => (Reason::QueueEntries, field, 0.0, (0.0, follow::STOPS as f64)),
            follow::Refused::Full => (Reason::FifoFull, field, 0.0, limits),
        };
        Refused::new(reason).field(field).got(got).limits(low, high)
    }
}

impl<const AXES: usize> Context<'_, AXES> {
    /// Admits a data command of either mode.
    /// A function of its own: else a path's data would have its memory on the stack too.
    #[inline(never)]
    pub fn follow_data(&self, stores: &SegmentStores<AXES>, number: u16, body: &[u8]) -> Stored {
        if number == opcode::FollowDataPercent2Ex {
            return self.asymmetric_data(stores, &one(body)?);
        }
        let (core, profile, fifo, field, given) = match number {
            opcode::FollowData => {
                let r = one::<FollowData>(body)?;
                let given = FollowItem::Segment(r.master_segment.get().into(), r.slave_segment.get(), r.kind.get(), 0);
                (r.core, r.profile, r.fifo, 5, given)
            }
            opcode::FollowDataPercentEx => {
                let r = one::<FollowDataPercentEx>(body)?;
                let given =
                    FollowItem::Segment(r.master_segment.get(), r.slave_segment.get(), r.kind.get(), r.percent.get());
                (r.core, r.profile, r.fifo, 6, given)
            }
            opcode::FollowDoBitEx => {
                let r = one::<FollowDoBitEx>(body)?;
                let (group, bit, high) =
                    self.output_bit(r.core.get(), 2, (r.do_type.get(), r.index.get(), r.value.get()))?;
                (r.core, r.profile, r.fifo, 5, FollowItem::Output(group, bit, high))
            }
            opcode::FollowDelayEx => {
                let r = one::<FollowDelayEx>(body)?;
                (r.core, r.profile, r.fifo, 3, FollowItem::Delay(r.delay_cycles.get()))
            }
            opcode::FollowDiBitEx => {
                let r = one::<FollowDiBitEx>(body)?;
                let (input, index, high) =
                    self.input_bit(r.core.get(), 2, (r.di_type.get(), r.index.get(), r.value.get()))?;
                (r.core, r.profile, r.fifo, 6, FollowItem::Wait(input, index, high, r.time_ms.get()))
            }
            _ => {
                let r = one::<FollowSwitchNowEx>(body)?;
                choice(3, r.buffer.get(), 0, 1)?;
                (r.core, r.profile, r.fifo, 4, FollowItem::Switch(method(r.method.get())?))
            }
        };
        let axis = self.axis_in(mode_of(number), core.get(), profile.get())?;
        let stands = self.knows_fifos(axis);
        let mut filling =
            self.open_follow(stores, axis, fifo.get(), field).map_err(|refused| refused.stands(stands))?;
        let named = |refused: Refused| refused.axis(self.configuration.number_of(axis)).stands(stands);
        filling.add(given).map_err(named)?;
        Ok(filling.written(0))
    }

    /// FollowDataPercent2Ex: up to three slots, for the rising, the constant and the falling part
    /// of the ratio.
    fn asymmetric_data(&self, stores: &SegmentStores<AXES>, r: &FollowDataPercent2Ex) -> Stored {
        let axis = self.axis_in(MotionMode::FollowEx, r.core.get(), r.profile.get())?;
        let (master, slave) = (r.master_segment.get(), r.slave_segment.get());
        let (begin, end) = (r.vel_begin_ratio.get(), r.vel_end_ratio.get());
        for (field, number) in (2..).zip([master, slave, begin, end]) {
            finite(field, number)?;
        }
        for (field, ratio) in [(4, begin), (5, end)] {
            real(field, ratio, -SLAVE_RATIO_MAX, SLAVE_RATIO_MAX)?;
        }
        let q = f64::from(within(6, r.percent.get(), 0, 100)?) / 100.0;
        let stands = self.knows_fifos(axis);
        let mut filling = self.open_follow(stores, axis, r.fifo.get(), 7).map_err(|refused| refused.stands(stands))?;
        let named = |refused: Refused| refused.axis(self.configuration.number_of(axis)).stands(stands);
        // An error of its ends alone is reported as for any segment.
        filling.check(FollowItem::Segment(master, slave, 1, 0)).map_err(named)?;
        let (from, origin) = (filling.shadow.master, filling.shadow.slave);
        let length = master - from;
        let progress = length.abs();
        let x = asymmetric_s::share(begin, end, q, (slave - origin) / progress).map_err(|(low, high)| {
            let (low, high) = (origin + low * progress, origin + high * progress);
            named(Refused::range(3, slave, low, high))
        })?;
        // A part that is too short to be a segment is left out.
        let x = if x * progress < PART_MIN_PULSES {
            0.0
        } else if (q - x) * progress < PART_MIN_PULSES {
            q
        } else {
            x
        };
        let [rise, constant] = asymmetric_s::corners(begin, end, q, x);
        let corner = |(at, mean): (f64, f64)| (from + length * at, origin + progress * mean);
        let parts = [
            (x > 0.0).then(|| (corner(rise), SCurvePart::Rise)),
            (q < 1.0).then(|| (corner(constant), SCurvePart::Constant)),
            (x < q).then_some(((master, slave), SCurvePart::Fall)),
        ];
        // The last one ends where the user gave it.
        let last = parts.iter().rposition(Option::is_some);
        let mut first = Some(begin);
        for (index, ((at, to), part)) in parts.into_iter().enumerate().filter_map(|(i, part)| Some((i, part?))) {
            let (at, to) = if Some(index) == last { (master, slave) } else { (at, to) };
            filling.add(FollowItem::Part(at, to, part, first.take())).map_err(named)?;
        }
        Ok(filling.written((x * 100.0 + 0.5) as i16))
    }

    /// The FIFO, if its content is known and its slots are free for data.
    fn open_follow<'x>(
        &self,
        stores: &'x SegmentStores<AXES>,
        axis: Axis,
        fifo: i16,
        field: u8,
    ) -> Admitted<FollowFifoWrite<'x>> {
        let fifo = choice(field, fifo, 0, 1)? as u8;
        self.knows_follow_fifo(axis, field)?;
        let shadow = self.shadow(axis);
        // The slots of data that is over in the program are free only when the tick has released
        // them.
        if self.is_outgoing(axis, fifo) {
            return Err(self.no(Reason::FifoInUse, axis).field(field).got(fifo.into()));
        }
        let Some(store) = stores.get(axis.index()) else { return Err(self.no(Reason::NotInitialised, axis)) };
        let direction = direction(shadow.follow.direction);
        let (capacity, data) = (shadow.follow.capacity(), *shadow.follow.fifo(fifo));
        let cleared = shadow.follow.cleared[usize::from(fifo & 1)];
        Ok(FollowFifoWrite { store, axis, fifo, cleared, field, direction, capacity, shadow: data })
    }
}
