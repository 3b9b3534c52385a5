//! Complete: the clamped cubic spline (SPEC 5, GXN 4.2).
//!
//! Continuous acceleration at point i means
//! λ·v(i−1) + 2·v(i) + μ·v(i+1) = 3·(λ·s(i−1) + μ·s(i)), with the slopes s = Δp/Δt of the segments
//! before and behind, λ = Δt behind/(both), μ = 1 − λ. The matrix is diagonally dominant by a
//! factor of 2, so elimination without pivots keeps every velocity within a few 2⁻⁵² of the
//! largest slope. Each place holds d in its third and c in its fourth word: v(i) = d(i) − c(i)·v(i+1).

/// One row, when the point behind it is known: its (d, c), from those of the place `before` and the two
/// segments at the point, each its time and displacement. These are differences of the user's own numbers:
/// of places, which are rounded from the first point, a short segment late in the table would have lost its end.
pub fn eliminate(before: &[f64; 4], (h0, p0): (f64, f64), (h1, p1): (f64, f64)) -> (f64, f64) {
    let (s0, s1) = (p0 / h0, p1 / h1);
    let (lambda, mu) = (h1 / (h0 + h1), h0 / (h0 + h1));
    let right = 3.0 * (lambda * s0 + mu * s1);
    let pivot = 2.0 - lambda * before[3];
    ((right - lambda * before[2]) / pivot, mu / pivot)
}

/// Puts the velocities into the third words, from the last place, which has its own, backwards.
pub fn substitute(places: &mut [[f64; 4]]) {
    let mut next = 0.0;
    for place in places.iter_mut().rev() {
        place[2] -= place[3] * next;
        place[3] = 0.0;
        next = place[2];
    }
}
