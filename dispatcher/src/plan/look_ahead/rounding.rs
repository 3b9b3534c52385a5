//! Rounding is no turn: what half a pulse at each point explains of a corner does not slow a path.
//!
//! In: the last motions as chords, a junction between two of them, limits. Out: the junction
//! without what rounding explains. Owns: [`CHORDS_MAX`] chords, so that a junction sees as far back
//! as forwards. Fails: never. Where one arm ends, both do.
//!
//! **The rule.** With arms of the length W to both sides a corner shows the second difference
//! D(W) = P(+W) − 2·P(0) + P(−W) of a coordinate. Targets are whole pulses, so D is right to
//! 4 · ½ = 2 pulses. The arms begin with the shorter motion and grow by √2, up to the length that
//! the path passes in the corner time T. Of a coordinate with the limit L counts
//!
//! - |D|, where it is at least L·T²: at the highest speed that it allows the arm takes T or longer;
//!   and of the longest arms,
//! - |D| − 2, and at least 0, of others.
//!
//! The bend of the junction is the greatest D/W² of its arms, to the left and to the right. The
//! speed in it is the highest at which no arm changes the velocity by more than L·T. Of arms that
//! last longer than T, but for the first, it is enough that they keep L. Neither is more than the
//! corner alone would have it with the turn that rounding may hide there ([`hidden_turn`]). So much
//! a junction counts until enough motions have come after it, and more data can only raise speeds.
//! What a trace shows is in decision 25.
use super::Limits;
use super::junction::{Junction, hidden_turn};
use crate::capacity::LOOK_AHEAD_CHORDS as CHORDS_MAX;
use libm::{fabsf, rintf};

/// The most chords of an arm.
const ARM_CHORDS: u32 = CHORDS_MAX as u32 / 2;
/// From arm to arm.
const ARM_GROWTH_RATIO: f32 = core::f32::consts::SQRT_2;
/// Parts of a direction of 1.
const DIRECTION_UNITS: f32 = 32767.0;

/// A motion, as a corner sees it: to 1/100 pulse in the arms of a path of 1000 pulse/ms.
#[derive(Debug, Clone, Copy)]
struct Chord {
    direction: [i16; 4],
    /// Negative if the path stands still at its start; 0 of an arc, which no arm goes along.
    length: f32,
}

servo::state! {
    /// The last motions of a path, by their numbers.
    #[derive(Debug, Clone)]
    pub(super) struct Chords {
        ring: [Chord; CHORDS_MAX] = [Chord { direction: [0; 4], length: 0.0 }; CHORDS_MAX],
        /// The number of the motion to come.
        next: u32 = 0,
    }
    /// None.
    pub(super) const fn new();
}

impl Chords {
    /// The number of the motion to come.
    pub(super) fn next(&self) -> u32 {
        self.next
    }

    /// A motion; `length` is 0 of an arc; `stands`: it begins at standstill.
    pub(super) fn push(&mut self, direction: [f32; 4], length: f64, stands: bool) {
        let length = if stands { -length } else { length } as f32;
        if let Some(chord) = self.ring.get_mut(self.next as usize % CHORDS_MAX) {
            *chord = Chord { direction: direction.map(|part| rintf(part * DIRECTION_UNITS) as i16), length };
        }
        self.next = self.next.wrapping_add(1);
    }

    fn chord(&self, number: u32) -> Chord {
        const NONE: Chord = Chord { direction: [0; 4], length: 0.0 };
        self.ring.get(number as usize % CHORDS_MAX).copied().unwrap_or(NONE)
    }

    /// From the start of a motion to one side.
    fn arm(&self, number: u32, forwards: bool) -> Arm<'_> {
        let left = if forwards { self.next.wrapping_sub(number).min(ARM_CHORDS) } else { ARM_CHORDS };
        Arm { chords: self, number, forwards, left, passed: 0.0, base: [0.0; 4], at: [0.0; 4] }
    }

    /// Whether an arm from the start of this motion takes more motions than came since.
    pub(super) fn has_room(&self, number: u32) -> bool {
        self.next.wrapping_sub(number) < ARM_CHORDS
    }

    /// The junction at the start of this motion without what rounding explains, and whether it may
    /// turn to either side. `vel` is the lower of the highest speeds of the motions at it.
    pub(super) fn without_rounding(
        &self,
        junction: &Junction,
        number: u32,
        vel: f64,
        limits: &Limits,
    ) -> (Junction, bool) {
        let [before, after] = [number.wrapping_sub(1), number].map(|number| fabsf(self.chord(number).length));
        let [mut forwards, mut back] = [self.arm(number, true), self.arm(number.wrapping_sub(1), false)];
        let (shortest, mean) = (before.min(after), (before + after) / 2.0);
        let (wanted, corner) = ((vel * limits.corner) as f32, limits.corner as f32);
        let jumps = limits.acc.map(|acc| acc as f32 * corner);
        let turn = hidden_turn([before.into(), after.into()]) as f32;
        // The first arms see the junction alone, which counts its turn and what it hides.
        let mut seconds = junction.bend.map(|bend| (fabsf(bend) * mean - turn).copysign(bend) * shortest);
        let (mut bends, mut square, mut arm) = ([[0.0f32; 2]; 4], f32::INFINITY, shortest);
        loop {
            let next = (arm * ARM_GROWTH_RATIO).min(wanted);
            let ends = next <= arm || !forwards.reach(next) || !back.reach(next);
            // Two pulses, but for an arm that ends within the first motions.
            let hidden = if ends { 0.0 } else { (arm * turn).min(2.0) };
            // The bend of a pulse; the speed at which the arm takes T. With the first arms all of
            // it is the corner.
            let (sharp, lasts) = (1.0 / (arm * arm.max(mean)), if arm > shortest { arm / corner } else { 0.0 });
            for ((bend, second), jump) in bends.iter_mut().zip(&seconds).zip(&jumps) {
                let size = fabsf(*second);
                let counts = if size >= jump * corner { size } else { size - hidden };
                if counts > 0.0 {
                    let [left, right] = bend;
                    let side = if *second < 0.0 { left } else { right };
                    *side = side.max(counts * sharp);
                    let most = jump * arm / counts;
                    square = square.min(most * most.max(lasts));
                }
            }
            if ends {
                break;
            }
            arm = next;
            seconds
                .iter_mut()
                .zip(forwards.at.iter().zip(&back.at))
                .for_each(|(second, (to, from))| *second = (to - from) / DIRECTION_UNITS);
        }
        let mut either = false;
        let mut sure = Junction { cap: junction.cap.max(f64::from(square).min(vel * vel)), ..*junction };
        for (bend, [left, right]) in sure.bend.iter_mut().zip(bends) {
            either |= left > 0.0 && right > 0.0;
            *bend = left.max(right).min(fabsf(*bend)).copysign(right - left);
        }
        (sure, either)
    }
}

/// From a junction along the chords to one side.
struct Arm<'x> {
    chords: &'x Chords,
    /// The chord in which it ends.
    number: u32,
    forwards: bool,
    /// Chords that it may still take, this one included.
    left: u32,
    /// Up to that chord: the length, and the displacement along the path in units of a direction.
    passed: f32,
    base: [f32; 4],
    /// The displacement where it ends, in the same units.
    at: [f32; 4],
}

impl Arm<'_> {
    /// Goes to this length, if there are chords for it. Lengths rise from call to call. No arm
    /// passes a standstill: backwards it ends with the chord that begins there.
    fn reach(&mut self, length: f32) -> bool {
        let Arm { chords, forwards, mut number, mut left, mut passed, mut base, .. } = *self;
        let along = |base: [f32; 4], direction: [i16; 4], part: f32| {
            let [a, b, c, d] = direction.map(|direction| f32::from(direction) * part);
            [base[0] + a, base[1] + b, base[2] + c, base[3] + d]
        };
        let to_next = if forwards { 1 } else { u32::MAX };
        let mut reached = false;
        while left != 0 {
            let Chord { direction, length: signed } = chords.chord(number);
            if signed <= 0.0 && (signed == 0.0 || forwards && passed > 0.0) {
                left = 0;
                break;
            }
            let end = passed + fabsf(signed);
            if end >= length {
                self.at = along(base, direction, length - passed);
                reached = true;
                break;
            }
            base = along(base, direction, fabsf(signed));
            (passed, number, left) = (end, number.wrapping_add(to_next), left - 1);
            if signed < 0.0 && !forwards {
                left = 0;
            }
        }
        (self.number, self.left, self.passed, self.base) = (number, left, passed, base);
        reached
    }
}
