//! The words of the step output, output slot by slot at eight pairs of pins, against the planned
//! pulses in exact integers.
use crate::chance;
use chance::Chance;
use servo::output::step_generator::{AXES, RING_SLOTS, StepOutput};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// The model: spreads `count` steps over `slots` equal slots of a tick: one answer per slot.
#[derive(Debug, Clone, Copy)]
struct StepSlots {
    count: u32,
    slots: u32,
    phase: u32,
}

impl StepSlots {
    /// `count` steps in `slots` slots. More steps than slots do not fit: `None`.
    fn new(count: u32, slots: u32) -> Option<StepSlots> {
        if slots == 0 || slots > 1 << 30 || count > slots {
            return None;
        }
        Some(StepSlots { count, slots, phase: slots >> 1 })
    }

    /// Whether the next slot carries a step. After `slots` calls `count` of them were true.
    fn advance(&mut self) -> bool {
        self.phase = self.phase.wrapping_add(self.count);
        if self.phase >= self.slots {
            self.phase = self.phase.wrapping_sub(self.slots);
            true
        } else {
            false
        }
    }
}

/// Against the closed form of `servo::output::step_generator`, in exact integers.
#[test]
fn slots_agree_with_the_closed_form() {
    for slots in [1u32, 2, 7, 100, 1000] {
        for count in 0..=slots {
            let mut walker = StepSlots::new(count, slots).unwrap();
            let at: Vec<u32> = (0..slots).filter(|_| walker.advance()).collect();
            let closed: Vec<u32> = (0..count).map(|k| (((k + 1) * slots - slots / 2).div_ceil(count)) - 1).collect();
            assert_eq!(at, closed, "{count} in {slots}");
        }
    }
    assert!(StepSlots::new(8, 7).is_none());
    assert!(StepSlots::new(0, 0).is_none());
}

/// The port after the ring, and the levels recorded at it.
struct Bench<const WIDTH: usize> {
    output: StepOutput<WIDTH>,
    ring: [AtomicU32; RING_SLOTS],
    set_up: u64,
    at: usize,
    /// Slots played.
    now: u64,
    /// Levels of the port.
    levels: u32,
    /// Net steps, and the last edges of each axis: rise, fall, change of direction.
    stands: [i64; AXES],
    rose: [Option<u64>; AXES],
    fell: [Option<u64>; AXES],
    turned: [Option<u64>; AXES],
}

impl<const WIDTH: usize> Bench<WIDTH> {
    fn new(set_up: u32) -> Self {
        Bench {
            output: StepOutput::new(set_up),
            ring: [const { AtomicU32::new(0) }; RING_SLOTS],
            set_up: set_up.into(),
            at: 0,
            now: 0,
            levels: 0,
            stands: [0; AXES],
            rose: [None; AXES],
            fell: [None; AXES],
            turned: [None; AXES],
        }
    }

    /// A tick: filled, played and cleared; the slots of the steps of each axis, from its beginning.
    fn tick(&mut self, goes_to: &[i64; AXES], slots: u32) -> [Vec<u32>; AXES] {
        let written = self.output.fill(goes_to, slots, &self.ring, self.at);
        let mut steps = [const { Vec::new() }; AXES];
        for slot in 0..slots {
            let word = self.ring[self.at].swap(0, Relaxed);
            assert!(written || word == 0);
            self.at = (self.at + 1) % RING_SLOTS;
            self.play(word, |axis| steps[axis].push(slot));
            self.now += 1;
        }
        assert_eq!(self.levels & 0xff00, 0, "a step is over before its tick is");
        assert!(self.ring.iter().all(|word| word.load(Relaxed) == 0), "nothing is written outside the tick");
        steps
    }

    fn play(&mut self, word: u32, mut step: impl FnMut(usize)) {
        assert_eq!(word & word >> 16, 0, "no pin is set and reset at once");
        let (before, width) = (self.levels, WIDTH as u64);
        self.levels = before & !(word >> 16) | word & 0xffff;
        for axis in 0..AXES {
            let (high, back) = (self.levels >> (8 + axis) & 1 == 1, self.levels >> axis & 1 == 1);
            if back != (before >> axis & 1 == 1) {
                assert!(before >> (8 + axis) & 1 == 0, "the direction holds while the step is high");
                self.turned[axis] = Some(self.now);
            }
            if high == (before >> (8 + axis) & 1 == 1) {
                continue;
            }
            if high {
                let since = |edge: Option<u64>| edge.map_or(u64::MAX, |edge| self.now - edge);
                assert!(since(self.fell[axis]) >= width, "low for {WIDTH} slots");
                assert!(since(self.turned[axis]) >= self.set_up, "set-up time of {} slots", self.set_up);
                self.rose[axis] = Some(self.now);
                self.stands[axis] += if back { -1 } else { 1 };
                step(axis);
            } else {
                assert_eq!(self.rose[axis].map(|rose| self.now - rose), Some(width), "high for {WIDTH} slots");
                self.fell[axis] = Some(self.now);
            }
        }
    }
}

/// Each step at most a slot before its ideal instant, the middle of its share of the available
/// slots.
fn is_even(steps: &[u32], from: u32, slots: u32) {
    let (n, of) = (steps.len() as u64, u64::from(slots - from));
    for (k, slot) in (0..).zip(steps) {
        let slot = u64::from(slot - from);
        // (k + ½)·of/n, with the half of an odd number of slots rounded down.
        let ideal = (k + 1) * of - of / 2;
        assert!(slot * n < ideal && ideal <= (slot + 1) * n, "step {k} of {n} in slot {slot} of {of}");
    }
}

/// Velocities that change at random: standstill, constant, sudden and up to `most` steps a tick.
fn profile<const WIDTH: usize>(seed: u64, us: u32, set_up: u32, ticks: u32) {
    let slots = 2 * us;
    let most = i64::from(StepOutput::<WIDTH>::most(slots));
    let mut chance = Chance::new(seed);
    let mut bench = Bench::<WIDTH>::new(set_up);
    let (mut planned, mut fraction, mut speed) = ([0i64; AXES], [0i64; AXES], [0i64; AXES]);
    let mut behind = 0u32;
    for _ in 0..ticks {
        for axis in 0..AXES {
            // In 2⁻¹⁶ pulse a tick.
            match chance.below(12) {
                0 => speed[axis] = 0,
                1 => speed[axis] = (most << 16) * if chance.below(2) == 0 { 1 } else { -1 },
                2 | 3 => speed[axis] = (chance.unit() * chance.unit() * (most << 16) as f64 * chance.sign()) as i64,
                4 => speed[axis] = (chance.unit() * chance.sign() * f64::from(1 << 16)) as i64,
                _ => {}
            }
            fraction[axis] += speed[axis];
            planned[axis] = (fraction[axis] + (1 << 15)) >> 16;
        }
        let before = bench.stands;
        let steps = bench.tick(&planned, slots);
        for axis in 0..AXES {
            let count = bench.stands[axis] - before[axis];
            assert_eq!(count.unsigned_abs() as usize, steps[axis].len(), "one direction in a tick");
            assert_eq!(bench.stands[axis], bench.output.stands(axis));
            // The remainder of a set-up time at the begin of the tick.
            let begin = bench.now - u64::from(slots);
            let from = bench.turned[axis].map_or(0, |at| (at + bench.set_up).saturating_sub(begin));
            let from = from.min(slots.into()) as u32;
            is_even(&steps[axis], from, slots);
            let displacement = (planned[axis] - before[axis]).unsigned_abs();
            let room = StepOutput::<WIDTH>::most(slots - from).into();
            assert_eq!(count.unsigned_abs(), displacement.min(room), "all that have room");
            behind += u32::from(bench.stands[axis] != planned[axis]);
        }
    }
    if set_up == 0 {
        assert_eq!(behind, 0, "planned pulses within their tick");
    }
    // At rest nothing is missing.
    let left = ticks * 4;
    for _ in 0..left {
        bench.tick(&planned, slots);
    }
    assert_eq!(bench.stands, planned);
}

#[test]
fn steps_are_the_planned_pulses_evenly_spaced() {
    let rounds = std::env::var("BEAMTICK_LONG").map_or(1, |_| 200);
    for seed in 0..rounds {
        for (us, ticks) in [(10, 600), (50, 150), (250, 40), (11, 300), (249, 30)] {
            profile::<1>(seed, us, 0, ticks);
            profile::<1>(seed, us, 1, ticks);
            profile::<1>(seed, us, 10, ticks);
            profile::<2>(seed, us, 7, ticks);
            profile::<5>(seed, us, 10, ticks);
            // Longer than a tick.
            profile::<1>(seed, us, 47, ticks);
        }
    }
}

/// Every count in every length of a tick, all in their own slots: on eight axes with different
/// counts, and on one alone, whose steps are written one by one.
#[test]
fn every_count_lies_where_the_closed_form_has_it() {
    for us in (10..=250).chain([256]) {
        let slots = 2 * us;
        let most = slots / 2;
        let mut bench = Bench::<1>::new(0);
        let mut planned = [0; AXES];
        for first in (0..=most).step_by(if us % 10 == 0 { 1 } else { 7 }) {
            // A different count on each axis.
            let of_all = std::array::from_fn::<u32, AXES, _>(|axis| (first + axis as u32 * 31) % (most + 1));
            let of_one = std::array::from_fn::<u32, AXES, _>(|axis| if axis as u32 == first % 8 { first } else { 0 });
            for counts in [of_all, of_one] {
                planned.iter_mut().zip(counts).for_each(|(planned, count)| *planned += i64::from(count));
                let steps = bench.tick(&planned, slots);
                for (count, steps) in counts.into_iter().zip(steps) {
                    let mut walker = StepSlots::new(count, slots).unwrap();
                    let expected: Vec<u32> = (0..slots).filter(|_| walker.advance()).collect();
                    assert_eq!(steps, expected, "{count} steps in {slots} slots");
                }
            }
        }
    }
}

/// All eight axes at 1 MHz without a pause, at each tick period: a step in every other slot.
#[test]
fn eight_axes_at_a_megahertz() {
    for us in [10, 50, 250] {
        let mut bench = Bench::<1>::new(0);
        for tick in 1..=40i64 {
            let steps = bench.tick(&[tick * i64::from(us); AXES], 2 * us);
            for steps in steps {
                assert_eq!(steps, (0..us).map(|k| 2 * k).collect::<Vec<_>>());
            }
        }
        assert_eq!(bench.stands, [40 * i64::from(us); AXES]);
    }
}

/// Steps for which there is no room come later, and none is lost; directions change where they
/// should.
#[test]
fn what_has_no_room_comes_later() {
    let mut bench = Bench::<2>::new(6);
    let mut goes_to = [0; AXES];
    goes_to[3] = 23;
    let counts: Vec<usize> = (0..6).map(|_| bench.tick(&goes_to, 20)[3].len()).collect();
    assert_eq!(counts, [5, 5, 5, 5, 3, 0]);
    goes_to[3] = 20;
    // Six slots of set-up: three steps in the 14 after them.
    assert_eq!(bench.tick(&goes_to, 20)[3], [8, 12, 17]);
    assert_eq!(bench.turned[3], Some(bench.now - 20));
    assert_eq!(bench.stands[3], 20);
}
