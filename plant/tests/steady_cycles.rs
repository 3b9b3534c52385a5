//! Ticks in which nothing changes queue their cycles by a shorter way: [`PwmCycles::queue`] and
//! [`GateCycles::queue`] beside the way of ticks with actions.
mod pwm_plans;

use pwm_plans::{BEGIN_COUNTS, Random, SCALE, counts, held};
use servo::laser::{Action, LaserPlan, Train};
use servo::output::{CycleRing, GateCycles, PwmCycles, RingSlots};
use std::sync::atomic::{AtomicU16, Ordering};

/// Slots of the rings below: few, so that three in a row are often not left.
const SLOTS: usize = 1024;

/// What a ring got since a slot: the half-words of each.
fn taken<const WORDS: usize>(slots: &RingSlots<SLOTS, WORDS>, from: usize, until: usize) -> Vec<[u16; WORDS]> {
    let count = (until + SLOTS - from) % SLOTS;
    (0..count).map(|n| slots[(from + n) % SLOTS].each_ref().map(|word| word.load(Ordering::Relaxed))).collect()
}

fn ring<const WORDS: usize>(dark: [u16; WORDS]) -> (&'static RingSlots<SLOTS, WORDS>, CycleRing<SLOTS, WORDS>) {
    let slots: &RingSlots<SLOTS, WORDS> =
        Box::leak(Box::new(std::array::from_fn(|_| std::array::from_fn(|_| AtomicU16::new(7)))));
    let mut ring = CycleRing::new(slots, dark);
    while !ring.clear() {}
    ring.begin(168);
    (slots, ring)
}

/// A tick in which nothing changes queues by a shorter way: the cycles are those of
/// [`PwmCycles::take`] and [`GateCycles::take`], in rings that turn, also where a ring ends.
#[test]
fn what_goes_on_is_queued_as_by_actions() {
    let (mut quiet, mut compared, mut lit) = (0, 0, 0);
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (slots, mut energy) = ring([0; 3]);
        let (switch_slots, mut switch) = ring([0, 0, u16::MAX, 0, 0, u16::MAX]);
        let (mut pwm, mut by_actions) = (PwmCycles::from(BEGIN_COUNTS, SCALE), PwmCycles::from(BEGIN_COUNTS, SCALE));
        let (mut gates, mut gates_by_actions) =
            (GateCycles::from(BEGIN_COUNTS, SCALE), GateCycles::from(BEGIN_COUNTS, SCALE));
        let (mut at, mut switch_at) = (0, 0);
        let (mut line, mut other) = (held(), held());
        // Light, then none for long: what goes on in the dark, and what in the light of a switch.
        let mut from = counts(10_000);
        for tick in 0..400u32 {
            let lasts = if tick % 50 < 25 { 10_000 } else { 250_000 };
            let plan = if tick % 8 == 0 && tick < 200 { random.plan(lasts) } else { LaserPlan::EMPTY };
            let plan = if tick % 40 == 20 {
                let mut off = LaserPlan::EMPTY;
                off.add(0, Action::Dark { standby: Train::NONE, cut: true });
                off.add(0, Action::Switch(random.below(2) == 0));
                off
            } else {
                plan
            };
            // The second channel often has no action where the first one has some.
            let second = if random.below(2) == 0 { LaserPlan::EMPTY } else { plan.clone() };
            assert!(line.put(&plan) && other.put(&second));
            let to = from + counts(lasts);
            assert!(energy.renew(at * 3) && switch.renew(switch_at * 6));
            let mut expected = Vec::new();
            by_actions.take(from, to, line.actions(), &mut |length, light, times| {
                expected.push([length - 1, times - 1, light].map(|word| word as u16));
            });
            pwm.queue(from, to, &line, &mut energy);
            let end = (at + expected.len()) % SLOTS;
            assert_eq!(taken(slots, at, end), expected, "seed {seed}, tick {tick}");
            at = end;
            let mut expected = Vec::new();
            gates.hold(line.actions());
            gates_by_actions.hold(line.actions());
            gates_by_actions.take(from, to, other.actions(), &mut |cycle| {
                let ([fall_0, fall_1], [rise_0, rise_1]) = (cycle.falls, cycle.rises);
                expected.push([cycle.length - 1, 0, rise_0, fall_0, fall_1, rise_1].map(|word| word as u16));
            });
            gates.queue(from, to, &other, &mut switch);
            let end = (switch_at + expected.len()) % SLOTS;
            lit += usize::from(plan.actions().is_empty() && expected.iter().all(|cycle| cycle[3] != 0));
            assert_eq!(taken(switch_slots, switch_at, end), expected, "seed {seed}, tick {tick}");
            switch_at = end;
            assert_eq!((pwm.queued(), gates.queued()), (by_actions.queued(), gates_by_actions.queued()));
            compared += 1;
            quiet += usize::from(plan.actions().is_empty());
            from = to;
        }
    }
    println!("{compared} ticks, {quiet} without an action, {lit} of them in light");
    assert!(quiet > 10_000 && lit > 500, "{quiet}, {lit}");
}
