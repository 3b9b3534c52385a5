//! The step generator: steps of eight axes as words, one for each slot of a tick, which DMA copies
//! to the set/reset register of one port.
//!
//! In: the pulses that the outputs reach at the end of a tick. Out: words in a ring: bit 8 + a
//! raises the step output of axis a, bit 24 + a lowers it, bit a says backwards, bit 16 + a
//! forwards. Owns the pulse counts of the outputs. Budget: some 70 instructions an axis; 19 a step
//! where there are few, and 23 a slot otherwise (`cargo xtask ticks`). It cannot fail: steps that
//! do not fit into a tick come in the next.
//!
//! The step output is at the planned position rounded to the nearest pulse (halves upwards). So
//! both directions are alike, and an axis at standstill on a knot is half a pulse away from the
//! next edge. The pulses of a tick are spread evenly and centred: with n pulses in a tick of S
//! slots, pulse k comes in slot `ceil(((k + 1)·S − floor(S/2)) / n) − 1`. So each is at most a slot
//! before its ideal instant, and the last one of a tick is over before the next tick. Code that may
//! divide (the VCD writer) uses the closed form. A direction changes at the beginning of a tick;
//! the steps after it are spread over the remainder of the tick after the set-up time.
//!
//! Few steps are written one by one. Of many, eight phases are counted at once, two in a word, in
//! 2⁻¹⁵ of a step and rounded up. A phase is a multiple of 1/slots, and is set anew before the
//! rounding errors add up to that ([`block`]): so every step comes in its own slot.
use crate::units::Pos;
pub use crate::units::whole;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Axes of a word.
pub const AXES: usize = 8;
/// Slots of the ring. Two ticks lie in it: the one that is output, and the one that is filled.
pub const RING_SLOTS: usize = 1024;
/// Slots of the longest tick.
pub const SLOTS_MAX: u32 = RING_SLOTS as u32 / 2;

/// Steps from one set-point to the next; negative is backwards.
pub const fn between(from: Pos, to: Pos) -> i64 {
    whole(to).wrapping_sub(whole(from))
}

/// Slots between two roundings. Each slot adds less than 1 + 2⁻⁷ units, as does the beginning;
/// 1/slots are 256 units, or 64.
const fn block(slots: u32) -> u32 {
    if slots <= 128 { 128 } else { 60 }
}

/// Carries of the two phases of a word.
const CARRIES: u32 = 0x8000_8000;

/// 2³¹/n, rounded up.
const RECIPROCALS: [u32; SLOTS_MAX as usize + 1] = {
    let mut table = [0; SLOTS_MAX as usize + 1];
    let mut n = 1;
    while n < table.len() {
        table[n] = (1u32 << 31).div_ceil(n as u32);
        n += 1;
    }
    table
};

/// The step outputs of eight axes. A step is high for `WIDTH` slots, and low for as many at least.
#[derive(Debug, Clone)]
pub struct StepOutput<const WIDTH: usize> {
    /// Slots from a change of direction to the step after it.
    set_up: u32,
    /// Pulse counts of the outputs.
    stands: [i64; AXES],
    /// Axes whose direction is backwards.
    backwards: u32,
    /// Slots of the coming tick that set-up times still take.
    waits: [u32; AXES],
}

/// In 2⁻¹⁵ and rounded up; 0 stays 0. Both factors are at most [`SLOTS_MAX`] and 2³¹ over it.
#[inline(always)]
const fn scaled(phase: u32, reciprocal: u32) -> u32 {
    (phase.wrapping_mul(reciprocal) >> 16).wrapping_add(if phase == 0 { 0 } else { 1 })
}

/// 2³¹/`slots`, rounded up.
#[inline(always)]
fn reciprocal(slots: u32) -> u32 {
    RECIPROCALS.get(slots as usize).copied().unwrap_or(0)
}

impl<const WIDTH: usize> StepOutput<WIDTH> {
    const WIDTH_OK: () = assert!(WIDTH > 0 && WIDTH <= 16, "a step is at most 16 slots wide");

    /// At zero, forwards, with `set_up` slots from a change of direction to the next step.
    pub const fn new(set_up: u32) -> Self {
        let () = Self::WIDTH_OK;
        StepOutput { set_up, stands: [0; AXES], backwards: 0, waits: [0; AXES] }
    }

    /// Most steps of a tick.
    pub const fn most(slots: u32) -> u32 {
        (slots >> 1) / WIDTH as u32
    }

    /// The pulse count of an axis's output after the last tick that was filled.
    pub fn stands(&self, axis: usize) -> i64 {
        self.stands.get(axis).copied().unwrap_or(0)
    }

    /// Fills a tick of `slots` slots from slot `at` of the ring on, at whose end the outputs are at
    /// `goes_to`, as far as the steps have room. All words there are zero before; if all stay zero,
    /// nothing is written. Returns whether anything was.
    #[inline(never)]
    pub fn fill(&mut self, goes_to: &[i64; AXES], slots: u32, ring: &[AtomicU32; RING_SLOTS], at: usize) -> bool {
        let slots = slots.min(SLOTS_MAX);
        let (mut counts, mut from) = ([0u32; AXES], [0u32; AXES]);
        let (mut steps, mut total, mut turned, mut waits) = (0u32, 0u32, 0, 0);
        let axes = goes_to.iter().zip(&mut self.stands).zip(&mut self.waits).zip(counts.iter_mut().zip(&mut from));
        for (bit, (((goes_to, stands), wait), (count, from))) in (0..AXES as u32).zip(axes) {
            let displacement = goes_to.wrapping_sub(*stands);
            // Further than a word is as good as any for one tick.
            let displacement =
                i32::try_from(displacement).unwrap_or(if displacement < 0 { -i32::MAX } else { i32::MAX });
            let backwards = displacement < 0;
            if displacement != 0 && backwards != (self.backwards >> bit & 1 == 1) {
                self.backwards ^= 1 << bit;
                turned |= 1 << bit;
                *wait = self.set_up;
            }
            let mut of = slots;
            if *wait != 0 {
                *from = *wait;
                of = slots.saturating_sub(*wait);
                *wait = wait.saturating_sub(slots);
                waits |= displacement;
            }
            *count = displacement.unsigned_abs().min(Self::most(of));
            let done = if backwards { (*count as i32).wrapping_neg() } else { *count as i32 };
            *stands = stands.wrapping_add(done.into());
            (steps, total) = (steps | *count, total.wrapping_add(*count));
        }
        if steps != 0 {
            if total.wrapping_mul(STEP_CYCLES) < slots.wrapping_mul(SLOT_CYCLES) {
                write_edges::<WIDTH>(&counts, &from, slots, ring, at);
            } else if waits == 0 && slots <= block(slots) {
                spread::<WIDTH>(&counts, slots, ring, at);
            } else {
                spread_late::<WIDTH>(&counts, &from, slots, ring, at);
            }
        }
        if turned != 0
            && let Some(first) = ring.get(at)
        {
            let word = turned & self.backwards | (turned & !self.backwards) << 16;
            first.store(first.load(Relaxed) | word, Relaxed);
        }
        steps | turned != 0
    }
}

/// Cycles of a step that is written alone, of which two loads from memory that is not cached take
/// half, and of a slot in which all axes are counted.
const STEP_CYCLES: u32 = 40;
const SLOT_CYCLES: u32 = 23;

/// Writes the words of a tick in which few slots have a step: the closed form of the module text,
/// from step to step. The steps of an axis lie after slot `from`.
#[inline(never)]
fn write_edges<const WIDTH: usize>(
    counts: &[u32; AXES],
    from: &[u32; AXES],
    slots: u32,
    ring: &[AtomicU32; RING_SLOTS],
    at: usize,
) {
    for (bit, (&count, &from)) in (0..AXES as u32).zip(counts.iter().zip(from)) {
        if count == 0 {
            continue;
        }
        let of = slots.saturating_sub(from);
        let by = reciprocal(count);
        // Of numbers below 2¹⁶ it is exact.
        let divided = |x: u32| {
            let quotient = ((x as u64).wrapping_mul(by as u64) >> 31) as u32;
            (quotient, x.wrapping_sub(quotient.wrapping_mul(count)))
        };
        let (pace, rest) = divided(of);
        let (first, mut part) = divided(of.div_ceil(2).saturating_sub(1));
        let begin = at.wrapping_add(from as usize);
        let (mut slot, end) = (begin.wrapping_add(first as usize), begin.wrapping_add(of as usize));
        // The step after the last one would lie after the tick. No count, so that the compiler does
        // not write the loop four times: memory for the tick's code is scarce.
        while slot < end {
            for (slot, edge) in [(slot, 8), (slot.wrapping_add(WIDTH), 24)] {
                if let Some(word) = ring.get(slot & (RING_SLOTS - 1)) {
                    word.store(word.load(Relaxed) | 1 << (edge | bit), Relaxed);
                }
            }
            part = part.wrapping_add(rest);
            let more = part >= count;
            part = if more { part.wrapping_sub(count) } else { part };
            slot = slot.wrapping_add(pace as usize).wrapping_add(more as usize);
        }
    }
}

/// Two axes of a word, the first in its upper half.
#[inline(always)]
fn pair(axes: &[u32]) -> u32 {
    match axes {
        [first, second] => first << 16 | second,
        _ => 0,
    }
}

/// Words of phases or paces; the last axes in the first one.
#[inline(always)]
fn pairs(axes: [u32; AXES]) -> [u32; AXES / 2] {
    let mut words = [0; AXES / 2];
    for (word, axes) in words.iter_mut().zip(axes.chunks_exact(2).rev()) {
        *word = pair(axes);
    }
    words
}

/// Writes the words of a tick that is one block, in which every axis has all slots.
fn spread<const WIDTH: usize>(counts: &[u32; AXES], slots: u32, ring: &[AtomicU32; RING_SLOTS], at: usize) {
    let reciprocal = reciprocal(slots);
    let pace = pairs(counts.map(|count| scaled(count, reciprocal)));
    let phase = pairs([scaled(slots >> 1, reciprocal); AXES]);
    let mut high = [0; WIDTH];
    let end = at.wrapping_add(slots as usize);
    let first = ring.get(at..end.min(RING_SLOTS)).unwrap_or_default();
    let phase = write(first, phase, pace, &mut high);
    if let Some(remainder @ 1..) = end.checked_sub(RING_SLOTS) {
        write(ring.get(..remainder).unwrap_or_default(), phase, pace, &mut high);
    }
}

/// Writes the words of any tick: the steps of an axis lie after slot `from`.
#[inline(never)]
fn spread_late<const WIDTH: usize>(
    counts: &[u32; AXES],
    from: &[u32; AXES],
    slots: u32,
    ring: &[AtomicU32; RING_SLOTS],
    mut at: usize,
) {
    let mut done = 0u32;
    // In 1/of of a step, where the axis has this many slots.
    let mut phases = from.map(|from| slots.saturating_sub(from) >> 1);
    // Steps whose end is still to come, the newest first.
    let mut high = [0; WIDTH];
    while done < slots {
        let mut length = slots.wrapping_sub(done).min(block(slots)).min((RING_SLOTS as u32).wrapping_sub(at as u32));
        let (mut phase, mut pace) = ([0; AXES], [0; AXES]);
        let scales = phase.iter_mut().zip(&mut pace);
        for (((count, from), now), (phase, pace)) in counts.iter().zip(from).zip(&phases).zip(scales) {
            if done >= *from {
                let reciprocal = reciprocal(slots.wrapping_sub(*from));
                (*phase, *pace) = (scaled(*now, reciprocal), scaled(*count, reciprocal));
            } else if *count != 0 {
                length = length.min(from.wrapping_sub(done));
            }
        }
        let run = ring.get(at..at.wrapping_add(length as usize)).unwrap_or_default();
        write(run, pairs(phase), pairs(pace), &mut high);
        for ((count, from), phase) in counts.iter().zip(from).zip(&mut phases) {
            if done >= *from {
                let of = slots.wrapping_sub(*from);
                // Below 2¹⁶, so the quotient is exact.
                let now = phase.wrapping_add(count.wrapping_mul(length));
                let steps = (u64::from(now).wrapping_mul(reciprocal(of).into()) >> 31) as u32;
                *phase = now.wrapping_sub(steps.wrapping_mul(of));
            }
        }
        done = done.wrapping_add(length);
        at = at.wrapping_add(length as usize) & (RING_SLOTS - 1);
    }
}

/// Writes the words of a block; returns the phases after it. A function of its own, so that the
/// eight numbers stay in registers.
#[inline(never)]
fn write<const WIDTH: usize>(run: &[AtomicU32], phase: [u32; 4], pace: [u32; 4], high: &mut [u32; WIDTH]) -> [u32; 4] {
    let [mut p0, mut p1, mut p2, mut p3] = phase;
    let [k0, k1, k2, k3] = pace;
    let mut pending = *high;
    for slot in run {
        p0 = (p0 & !CARRIES).wrapping_add(k0);
        p1 = (p1 & !CARRIES).wrapping_add(k1);
        p2 = (p2 & !CARRIES).wrapping_add(k2);
        p3 = (p3 & !CARRIES).wrapping_add(k3);
        // The carries of a word two bits below those of the word before. By rotation, for a
        // compiler that would take the four masks apart and run out of registers.
        let mut both = p3 & CARRIES;
        for p in [p2, p1, p0] {
            both = both.rotate_right(2) | p & CARRIES;
        }
        // The odd bits from 9 to 15, and above them those between.
        let rises = both & 0xffff | both >> 17;
        let mut falls = rises;
        for later in &mut pending {
            core::mem::swap(later, &mut falls);
        }
        slot.store(rises | falls << 16, Relaxed);
    }
    *high = pending;
    [p0, p1, p2, p3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_to_the_nearest_pulse_in_both_directions() {
        let one = 1i64 << Pos::FRAC_BITS;
        for (pos, pulse) in [
            (0, 0),
            (one / 2 - 1, 0),
            (one / 2, 1),
            (one, 1),
            (-one / 2, 0),
            (-one / 2 - 1, -1),
            (-one, -1),
            (4096 * one, 4096),
            (-4096 * one, -4096),
        ] {
            assert_eq!(whole(Pos(pos)), pulse, "{pos}");
        }
        assert_eq!(between(Pos(-one), Pos(2 * one)), 3);
        assert_eq!(between(Pos(2 * one), Pos(-one)), -3);
    }
}
