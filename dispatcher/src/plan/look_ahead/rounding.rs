//! Rounding is no turn: what half a pulse at each point explains of a corner does not slow a path.
//!
//! In: the last motions as chords, a junction between two of them, limits. Out: the junction
//! without what rounding explains. Owns: [`CHORDS`] chords, so that a junction sees as far back as
//! forwards.
//! Fails: never. Both arms are as long as the shorter one.
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
//! speed in it is the highest at which no arm changes the velocity by more than L·T, or at which
//! arms that last longer than T, but for the shortest, keep L. Neither is more than the corner alone would have it with the turn that
//! rounding may hide there ([`turn`]). That is what a junction counts until enough motions have come
//! after it: so more data can only raise speeds. What a trace shows is in decision 25.
use super::Limits;
use super::junction::Junction;
use libm::fabs;

/// Chords that are kept: as many as both arms of a junction take.
pub(super) const CHORDS: usize = 128;
/// The most chords of an arm.
const ARM: u32 = CHORDS as u32 / 2;
/// From arm to arm.
const GROWTH: f64 = core::f64::consts::SQRT_2;

/// A motion, as a corner sees it.
#[derive(Debug, Clone, Copy)]
struct Chord {
    direction: [f32; 4],
    /// Negative if the path stands still at its start; 0 of an arc, which no arm goes along.
    length: f32,
}

servo::state! {
    /// The last motions of a path, by their numbers.
    #[derive(Debug, Clone)]
    pub(super) struct Chords {
        ring: [Chord; CHORDS] = [Chord { direction: [0.0; 4], length: 0.0 }; CHORDS],
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
        if let Some(chord) = self.ring.get_mut(self.next as usize % CHORDS) {
            *chord = Chord { direction, length };
        }
        self.next = self.next.wrapping_add(1);
    }

    fn chord(&self, number: u32) -> &Chord {
        const NONE: Chord = Chord { direction: [0.0; 4], length: 0.0 };
        self.ring.get(number as usize % CHORDS).unwrap_or(&NONE)
    }

    /// From the start of a motion to one side.
    fn arm(&self, number: u32, forwards: bool) -> Arm<'_> {
        let number = if forwards { number } else { number.wrapping_sub(1) };
        let left = if forwards { self.next.wrapping_sub(number).min(ARM) } else { ARM };
        Arm { chords: self, number, forwards, left, passed: 0.0, at: [0.0; 4] }
    }

    /// Whether an arm from the start of this motion takes more motions than came since.
    pub(super) fn has_room(&self, number: u32) -> bool {
        self.next.wrapping_sub(number) < ARM
    }

    /// The junction at the start of this motion, without what rounding explains. `vel` is the lower
    /// of the highest speeds of the motions at it.
    pub(super) fn without_rounding(
        &self,
        junction: &Junction,
        number: u32,
        vel: f64,
        limits: &Limits,
    ) -> (Junction, bool) {
        let own = [number.wrapping_sub(1), number].map(|number| fabs(self.chord(number).length.into()));
        let [mut forwards, mut back] = [true, false].map(|forwards| self.arm(number, forwards));
        let wanted = vel * limits.corner;
        let longest = [true, false].iter().fold(wanted, |most, side| self.arm(number, *side).length(most));
        let (mut bends, mut cap) = ([[0.0f64; 2]; 4], vel * vel);
        let (shortest, mean) = (own[0].min(own[1]).min(longest), (own[0] + own[1]) / 2.0);
        let mut arm = shortest;
        loop {
            let (to, from) = (forwards.reach(arm), back.reach(arm));
            // Two pulses, but for an arm that ends within the first motions.
            let hidden = (arm * turn(own)).min(2.0);
            for (((bend, to), from), acc) in bends.iter_mut().zip(to).zip(from).zip(limits.acc) {
                let (second, slow) = (to - from, acc * limits.corner * limits.corner);
                let rounded = if arm >= longest || fabs(second) >= slow { 0.0 } else { hidden };
                let counts = fabs(second) - rounded;
                if counts > 0.0 {
                    let sharp = counts / (arm * arm.max(mean));
                    let [left, right] = bend;
                    let side = if second < 0.0 { left } else { right };
                    *side = side.max(sharp);
                    let speed = acc * limits.corner * arm / counts;
                    // With the shortest arms all of it is the corner.
                    let longer = if arm > shortest { arm / limits.corner } else { 0.0 };
                    cap = cap.min(speed * speed.max(longer));
                }
            }
            if arm >= longest {
                break;
            }
            arm = (arm * GROWTH).min(longest);
        }
        let mut either = false;
        let mut sure = Junction { cap: junction.cap.max(cap), ..*junction };
        for (bend, [left, right]) in sure.bend.iter_mut().zip(bends) {
            either |= left > 0.0 && right > 0.0;
            let most = fabs(f64::from(*bend));
            *bend = left.max(right).min(most).copysign(right - left) as f32;
        }
        (sure, either)
    }
}

/// The turn that rounding may hide between motions of these lengths.
pub(super) fn turn(lengths: [f64; 2]) -> f64 {
    let [before, after] = lengths;
    1.0 / before + 1.0 / after
}

/// From a junction along the chords to one side.
struct Arm<'x> {
    chords: &'x Chords,
    /// The chord in which it ends.
    number: u32,
    forwards: bool,
    /// Chords that it may still take, this one included.
    left: u32,
    /// The length up to that chord, and the displacement along the path.
    passed: f64,
    at: [f64; 4],
}

impl Arm<'_> {
    /// The chord in which it ends, if there is one.
    fn chord(&self) -> Option<(&[f32; 4], f64)> {
        let chord = self.chords.chord(self.number);
        // No arm passes a standstill: backwards it ends with the chord that begins there.
        let before = self.chords.chord(self.number.wrapping_add(1));
        let stands = self.passed > 0.0 && if self.forwards { chord } else { before }.length < 0.0;
        (self.left != 0 && chord.length != 0.0 && !stands).then(|| (&chord.direction, fabs(chord.length.into())))
    }

    fn step(&mut self, own: f64) {
        self.number = if self.forwards { self.number.wrapping_add(1) } else { self.number.wrapping_sub(1) };
        (self.passed, self.left) = (self.passed + own, self.left - 1);
    }

    /// How long it can be, at most this long.
    fn length(mut self, most: f64) -> f64 {
        while let Some((_, own)) = self.chord().filter(|_| self.passed < most) {
            self.step(own);
        }
        self.passed.min(most)
    }

    /// The displacement along the path at this length. Lengths rise from call to call.
    fn reach(&mut self, length: f64) -> [f64; 4] {
        loop {
            let mut at = self.at;
            let Some((direction, own)) = self.chord() else { return at };
            let within = own.min(length - self.passed);
            at.iter_mut().zip(direction).for_each(|(at, share)| *at += f64::from(*share) * within);
            if own >= length - self.passed {
                return at;
            }
            self.at = at;
            self.step(own);
        }
    }
}
