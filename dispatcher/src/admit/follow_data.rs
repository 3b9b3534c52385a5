//! Follow data from bytes to the axis's store: segments, and what FollowEx queues between them.
//!
//! In: a data command. Out: entries in the store, and the FIFO's new shadow state.
//! Fails: with the parameter and the limit. Entries written by then lie after the end of the FIFO,
//! where nobody reads.
use super::context::{Context, TRAVEL_PULSES};
use super::follow::{following, known, method, mode_of};
use super::written::{SegmentStores, Stored, Written};
use super::{io, one};
use crate::plan::asymmetric_s;
use crate::refuse::{Admitted, FifoOf, Refused, choice, real, within};
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
enum Given {
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
struct Filling<'x> {
    store: &'x SegmentStore,
    axis: Axis,
    fifo: u8,
    cleared: u32,
    field: u8,
    direction: Direction,
    capacity: u32,
    shadow: FollowFifoShadow,
}

impl Filling<'_> {
    /// The entry after the end, and the state from which the next one continues.
    fn check(&self, given: Given) -> Admitted<(FollowEntry, FollowChain)> {
        if self.shadow.chain.entries() >= self.capacity {
            return Err(Refused::new(Reason::FifoFull).field(self.field).limits(0.0, self.capacity.into()));
        }
        let before = &self.shadow.chain;
        let admitted = match given {
            Given::Segment(master, slave, kind, percent) => {
                FollowEntry::segment(master.to_bits(), slave.to_bits(), kind, percent, self.direction, before)
            }
            Given::Output(group, bit, high) => FollowEntry::output(group, bit, high, before),
            Given::Delay(cycles) => FollowEntry::delay(cycles, before),
            Given::Wait(input, index, high, ms) => FollowEntry::wait_input(input, index, high, ms, before),
            Given::Switch(method) => FollowEntry::switch(method, before),
            Given::Part(master, slave, part, begin) => {
                let begin = begin.map(f64::to_bits);
                FollowEntry::part(master.to_bits(), slave.to_bits(), part, begin, self.direction, before)
            }
        };
        admitted.map_err(|refused| self.explain(refused, given))
    }

    /// Writes one entry after the end.
    fn add(&mut self, given: Given) -> Admitted<()> {
        let (entry, chain) = self.check(given)?;
        self.store.write_entry(self.fifo, self.shadow.chain.entries(), entry);
        self.shadow.chain = chain;
        if let Given::Segment(master, slave, ..) | Given::Part(master, slave, ..) = given {
            (self.shadow.master, self.shadow.slave) = (master, slave);
        }
        self.shadow.switches |= matches!(given, Given::Switch(Method::Table));
        Ok(())
    }

    /// What was written to this FIFO.
    fn written(&self, percent1: i16) -> (Written, ShadowChange) {
        let Filling { axis, fifo, cleared, shadow, .. } = *self;
        let answer = Answer::Entered { axis, fifo, percent1 };
        (Written::new(FifoOf::Axis(axis), fifo, answer), ShadowChange::FollowData { axis, fifo, cleared, shadow })
    }

    #[cold]
    fn explain(&self, refused: follow::Refused, given: Given) -> Refused {
        let (master, slave, kind, percent) = match given {
            Given::Segment(master, slave, kind, percent) => (master, slave, kind, percent),
            Given::Part(master, slave, ..) => (master, slave, 0, 0),
            _ => (0.0, 0.0, 0, 0),
        };
        let before = &self.shadow;
        let ratio = (slave - before.slave) / (master - before.master);
        match refused {
            follow::Refused::MasterNotFinite => Refused::new(Reason::NotFinite).field(2).got(master),
            follow::Refused::SlaveNotFinite => Refused::new(Reason::NotFinite).field(3).got(slave),
            follow::Refused::MasterBeyondRange => {
                Refused::new(Reason::OutOfRange).field(2).got(master).limits(-MASTER_MAX_PULSES, MASTER_MAX_PULSES)
            }
            follow::Refused::SlaveBeyondTravel => {
                Refused::new(Reason::BeyondTravel).field(3).got(slave).limits(-TRAVEL_PULSES, TRAVEL_PULSES)
            }
            follow::Refused::NotAdvancing if master * before.master < 0.0 => {
                Refused::new(Reason::MixedSigns).field(2).got(master).limits(before.master, before.master)
            }
            follow::Refused::NotAdvancing => {
                Refused::new(Reason::MasterOrder).field(2).got(master).limits(before.master, before.master)
            }
            follow::Refused::Negative => Refused::new(Reason::NegativeProgress).field(2).got(master),
            follow::Refused::Kind => Refused::new(Reason::Selector).field(4).got(kind.into()).limits(0.0, 3.0),
            follow::Refused::Percent => {
                Refused::new(Reason::OutOfRange).field(5).got(percent.into()).limits(0.0, 100.0)
            }
            follow::Refused::TooSteep => {
                Refused::new(Reason::RatioTooLarge).field(3).got(ratio).limits(-SLAVE_RATIO_MAX, SLAVE_RATIO_MAX)
            }
            follow::Refused::TooFar => {
                let most = TRAVEL_PULSES / (master - before.master).abs();
                Refused::new(Reason::RatioTooLarge).field(3).got(ratio).limits(-most, most)
            }
            follow::Refused::StopsFull => {
                Refused::new(Reason::QueueEntries).field(self.field).limits(0.0, follow::STOPS as f64)
            }
            follow::Refused::Full => Refused::new(Reason::FifoFull).field(self.field).limits(0.0, self.capacity.into()),
        }
    }
}

/// Admits a data command of either mode.
pub fn data<const AXES: usize>(
    context: &Context<AXES>,
    stores: &SegmentStores<AXES>,
    number: u16,
    body: &[u8],
) -> Stored {
    if number == opcode::FollowDataPercent2Ex {
        return asymmetric_data(context, stores, &one(body)?);
    }
    let (core, profile, fifo, field, given) = match number {
        opcode::FollowData => {
            let r = one::<FollowData>(body)?;
            let given = Given::Segment(r.master_segment.get().into(), r.slave_segment.get(), r.kind.get(), 0);
            (r.core, r.profile, r.fifo, 5, given)
        }
        opcode::FollowDataPercentEx => {
            let r = one::<FollowDataPercentEx>(body)?;
            let given = Given::Segment(r.master_segment.get(), r.slave_segment.get(), r.kind.get(), r.percent.get());
            (r.core, r.profile, r.fifo, 6, given)
        }
        opcode::FollowDoBitEx => {
            let r = one::<FollowDoBitEx>(body)?;
            let (group, bit, high) =
                io::output(context, r.core.get(), 2, (r.do_type.get(), r.index.get(), r.value.get()))?;
            (r.core, r.profile, r.fifo, 5, Given::Output(group, bit, high))
        }
        opcode::FollowDelayEx => {
            let r = one::<FollowDelayEx>(body)?;
            (r.core, r.profile, r.fifo, 3, Given::Delay(r.delay_cycles.get()))
        }
        opcode::FollowDiBitEx => {
            let r = one::<FollowDiBitEx>(body)?;
            let (input, index, high) =
                io::input(context, r.core.get(), 2, (r.di_type.get(), r.index.get(), r.value.get()))?;
            (r.core, r.profile, r.fifo, 6, Given::Wait(input, index, high, r.time_ms.get()))
        }
        _ => {
            let r = one::<FollowSwitchNowEx>(body)?;
            choice(3, r.buffer.get(), 0, 1)?;
            (r.core, r.profile, r.fifo, 4, Given::Switch(method(r.method.get())?))
        }
    };
    let axis = following(context, mode_of(number), core.get(), profile.get())?;
    let stands = context.knows_fifos(axis);
    let mut filling = open(context, stores, axis, fifo.get(), field).map_err(|refused| refused.stands(stands))?;
    let named = |refused: Refused| refused.axis(context.configuration.number_of(axis)).stands(stands);
    filling.add(given).map_err(named)?;
    Ok(filling.written(0))
}

/// FollowDataPercent2Ex: up to three slots, for the rising, the constant and the falling part of
/// the ratio.
fn asymmetric_data<const AXES: usize>(
    context: &Context<AXES>,
    stores: &SegmentStores<AXES>,
    r: &FollowDataPercent2Ex,
) -> Stored {
    let axis = following(context, MotionMode::FollowEx, r.core.get(), r.profile.get())?;
    let (master, slave) = (r.master_segment.get(), r.slave_segment.get());
    let (begin, end) = (r.vel_begin_ratio.get(), r.vel_end_ratio.get());
    for (field, number) in (2..).zip([master, slave, begin, end]) {
        if !number.is_finite() {
            return Err(Refused::new(Reason::NotFinite).field(field).got(number));
        }
    }
    for (field, ratio) in [(4, begin), (5, end)] {
        real(field, ratio, -SLAVE_RATIO_MAX, SLAVE_RATIO_MAX)?;
    }
    let q = f64::from(within(6, r.percent.get(), 0, 100)?) / 100.0;
    let stands = context.knows_fifos(axis);
    let mut filling = open(context, stores, axis, r.fifo.get(), 7).map_err(|refused| refused.stands(stands))?;
    let named = |refused: Refused| refused.axis(context.configuration.number_of(axis)).stands(stands);
    // An error of its ends alone is reported as for any segment.
    filling.check(Given::Segment(master, slave, 1, 0)).map_err(named)?;
    let (from, origin) = (filling.shadow.master, filling.shadow.slave);
    let length = master - from;
    let progress = length.abs();
    let x = asymmetric_s::share(begin, end, q, (slave - origin) / progress).map_err(|(low, high)| {
        let (low, high) = (origin + low * progress, origin + high * progress);
        named(Refused::new(Reason::OutOfRange).field(3).got(slave).limits(low, high))
    })?;
    // A part that is too short to be a segment is left out.
    let x = if x * progress < PART_MIN_PULSES {
        0.0
    } else if (q - x) * progress < PART_MIN_PULSES {
        q
    } else {
        x
    };
    let [rise, held] = asymmetric_s::corners(begin, end, q, x);
    let corner = |(at, mean): (f64, f64)| (from + length * at, origin + progress * mean);
    let parts = [
        (x > 0.0).then(|| (corner(rise), SCurvePart::Rise)),
        (q < 1.0).then(|| (corner(held), SCurvePart::Held)),
        (x < q).then_some(((master, slave), SCurvePart::Fall)),
    ];
    // The last one ends where the user gave it.
    let last = parts.iter().rposition(Option::is_some);
    let mut first = Some(begin);
    for (index, ((at, to), part)) in parts.into_iter().enumerate().filter_map(|(i, part)| Some((i, part?))) {
        let (at, to) = if Some(index) == last { (master, slave) } else { (at, to) };
        filling.add(Given::Part(at, to, part, first.take())).map_err(named)?;
    }
    Ok(filling.written((x * 100.0 + 0.5) as i16))
}

/// The FIFO, if its content is known and its slots are free for data.
fn open<'x, const AXES: usize>(
    context: &Context<'_, AXES>,
    stores: &'x SegmentStores<AXES>,
    axis: Axis,
    fifo: i16,
    field: u8,
) -> Admitted<Filling<'x>> {
    let fifo = choice(field, fifo, 0, 1)? as u8;
    known(context, axis, field)?;
    let shadow = context.shadow(axis);
    // The slots of data that is over in the program are free only when the tick has released them.
    if context.is_outgoing(axis, fifo) {
        return Err(context.no(Reason::FifoInUse, axis).field(field).got(fifo.into()));
    }
    let Some(store) = stores.get(axis.index()) else { return Err(context.no(Reason::NotInitialised, axis)) };
    let direction = match shadow.follow.direction {
        0 => Direction::Both,
        1 => Direction::Up,
        _ => Direction::Down,
    };
    let (capacity, data) = (shadow.follow.capacity(), *shadow.follow.fifo(fifo));
    let cleared = shadow.follow.cleared[usize::from(fifo & 1)];
    Ok(Filling { store, axis, fifo, cleared, field, direction, capacity, shadow: data })
}
