//! Steps of eight axes as words, one a slot, which DMA copies to the set/reset register of one port.
//!
//! In: the pulses at which the outputs are to stand at the end of a tick. Out: words in a ring: bit 8 + a raises the step output
//! of axis a, bit 24 + a lowers it, bit a says backwards, bit 16 + a forwards. Owns where the outputs stand. Budget: some twenty
//! instructions a slot, however many steps there are (`cargo xtask ticks`). It cannot fail: what does not fit into a tick comes in the next.
//!
//! The steps of a tick lie where [`super::Slots`] has them, so each is at most a slot before its ideal instant, and the last one of a tick
//! is over before the next tick. A direction changes at the beginning of a tick; the steps behind it are spread
//! over what the set-up time leaves of the tick.
//!
//! Eight phases are counted at once, two in a word, in 2⁻¹⁵ of a step and rounded up. A phase is a multiple of 1/slots, 64 of
//! these units or more, and is set anew each [`BLOCK`] slots, in which the rounding gathers less than 34 of them: so every
//! step comes in its own slot.
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Axes of a word.
pub const AXES: usize = 8;
/// Slots of the ring. Two ticks lie in it: the one that is played, and the one that is filled.
pub const RING: usize = 1024;
/// Slots of the longest tick.
pub const SLOTS_MAX: u32 = RING as u32 / 2;
/// Slots between two roundings.
pub const BLOCK: u32 = 32;

/// Carries of the two phases of a word, and the phases.
const CARRIES: u32 = 0x8000_8000;
const PHASES: u32 = !CARRIES;

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
    /// Slots from a change of direction to the step behind it.
    set_up: u32,
    /// Pulses at which the outputs stand.
    stands: [i64; AXES],
    /// Axes whose direction is backwards.
    backwards: u32,
    /// Slots of the coming tick that set-up times still take.
    waits: [u32; AXES],
}

/// An axis in a tick.
#[derive(Debug, Clone, Copy, Default)]
struct Lane {
    /// Steps.
    count: u32,
    /// They lie in so many slots from this one on.
    from: u32,
    of: u32,
    reciprocal: u32,
    /// In 1/`of` of a step.
    phase: u32,
}

impl Lane {
    /// In 2⁻¹⁵, rounded up; both factors are at most [`SLOTS_MAX`] and 2³¹ over it.
    #[inline(always)]
    fn scaled(&self, phase: u32) -> u32 {
        (phase.wrapping_mul(self.reciprocal) >> 16).wrapping_add(1)
    }

    /// So many slots later.
    #[inline(always)]
    fn advance(&mut self, slots: u32) {
        let phase = self.phase.wrapping_add(self.count.wrapping_mul(slots));
        // Below 2¹⁴, so the quotient is exact.
        let steps = (u64::from(phase).wrapping_mul(self.reciprocal.into()) >> 31) as u32;
        self.phase = phase.wrapping_sub(steps.wrapping_mul(self.of));
    }
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

    /// The pulse at which the output of an axis stands behind the last tick that was filled.
    pub fn stands(&self, axis: usize) -> i64 {
        self.stands.get(axis).copied().unwrap_or(0)
    }

    /// Fills a tick of `slots` slots from slot `at` of the ring on, at whose end the outputs stand at `goes_to`, as far as the
    /// steps have room. All words there are zero before; if none is to be another, nothing is written. Whether it was.
    pub fn fill(&mut self, goes_to: &[i64; AXES], slots: u32, ring: &[AtomicU32; RING], at: usize) -> bool {
        let slots = slots.min(SLOTS_MAX);
        let mut lanes = [Lane::default(); AXES];
        let (mut steps, mut turned) = (0u32, 0);
        let axes = goes_to.iter().zip(&mut self.stands).zip(&mut self.waits).zip(&mut lanes);
        for (bit, (((goes_to, stands), wait), lane)) in (0..AXES as u32).zip(axes) {
            let way = goes_to.wrapping_sub(*stands);
            if way == 0 {
                *wait = wait.saturating_sub(slots);
                continue;
            }
            let backwards = way < 0;
            if backwards != (self.backwards >> bit & 1 == 1) {
                self.backwards ^= 1 << bit;
                turned |= 1 << bit;
                *wait = self.set_up;
            }
            let of = slots.saturating_sub(*wait);
            let count = way.unsigned_abs().min(Self::most(of).into()) as u32;
            let reciprocal = RECIPROCALS.get(of as usize).copied().unwrap_or(0);
            *lane = Lane { count, from: *wait, of, reciprocal, phase: of >> 1 };
            *stands = stands.wrapping_add(if backwards { -i64::from(count) } else { count.into() });
            *wait = wait.saturating_sub(slots);
            steps |= count;
        }
        if steps != 0 {
            spread::<WIDTH>(&mut lanes, slots, ring, at);
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

/// Writes the words of a tick.
fn spread<const WIDTH: usize>(lanes: &mut [Lane; AXES], slots: u32, ring: &[AtomicU32; RING], mut at: usize) {
    let mut done = 0u32;
    // Steps whose end is still to come, the newest first.
    let mut high = [0u32; WIDTH];
    while done < slots {
        let mut length = slots.wrapping_sub(done).min(BLOCK).min((RING as u32).wrapping_sub(at as u32));
        let (mut phase, mut pace) = ([0u32; AXES / 2], [0u32; AXES / 2]);
        for ((pair, phase), pace) in lanes.chunks_exact(2).zip(&mut phase).zip(&mut pace) {
            for (lane, shift) in pair.iter().zip([0, 16]) {
                if lane.count == 0 {
                    continue;
                }
                if done < lane.from {
                    length = length.min(lane.from.wrapping_sub(done));
                    continue;
                }
                *phase |= lane.scaled(lane.phase) << shift;
                *pace |= lane.scaled(lane.count) << shift;
            }
        }
        let [mut p0, mut p1, mut p2, mut p3] = phase;
        let [k0, k1, k2, k3] = pace;
        for place in ring.get(at..at.wrapping_add(length as usize)).unwrap_or_default() {
            p0 = (p0 & PHASES).wrapping_add(k0);
            p1 = (p1 & PHASES).wrapping_add(k1);
            p2 = (p2 & PHASES).wrapping_add(k2);
            p3 = (p3 & PHASES).wrapping_add(k3);
            // Axes 1, 3, 5, 7 to bits 8, 10, 12, 14, the others to 24, 26, 28, 30; then these between those.
            let both = (p0 & CARRIES) >> 7 | (p1 & CARRIES) >> 5 | (p2 & CARRIES) >> 3 | (p3 & CARRIES) >> 1;
            let rises = both & 0xffff | both >> 15;
            let mut falls = rises;
            for later in &mut high {
                core::mem::swap(later, &mut falls);
            }
            place.store(rises | falls << 16, Relaxed);
        }
        let from = done;
        done = done.wrapping_add(length);
        if done < slots {
            lanes.iter_mut().filter(|lane| from >= lane.from).for_each(|lane| lane.advance(length));
        }
        at = at.wrapping_add(length as usize) & (RING - 1);
    }
}
