//! Complete: the clamped cubic spline (SPEC 5, GXN 4.2).
//!
//! Continuous acceleration at point i means λ·v(i−1) + 2·v(i) + μ·v(i+1) = 3·(λ·s(i−1) + μ·s(i)).
//! The slopes are s = Δp/Δt of the segments before and after the point, λ = Δt after/(both), μ = 1
//! − λ. The matrix is diagonally dominant by a factor of 2. So elimination without pivots keeps
//! every velocity within a few 2⁻⁵² of the largest slope.
//! Each point first holds d as its velocity: v(i) = d(i) − c(i)·v(i+1). c depends on the times
//! alone. Only every [`STRIDE_POINTS`]th is kept. The back substitution computes those between
//! again, by the same operations on the same numbers, so to the same bits.
use super::scratch::{STRIDE_POINTS, Scratch};

/// What the elimination carries from point to point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EliminationRow {
    /// d of the point before.
    pub d: f64,
    /// Its c.
    pub c: f64,
}

/// λ and μ where a segment of duration `h0` meets one of `h1`.
fn weights(h0: f64, h1: f64) -> (f64, f64) {
    (h1 / (h0 + h1), h0 / (h0 + h1))
}

/// λ·c of the point before makes the pivot of this one.
fn pivot(lambda: f64, c: f64) -> f64 {
    2.0 - lambda * c
}

/// One row, once the point after it is known: from the row `before` and the two segments at the
/// point, each its time and displacement. These are differences of the user's own numbers.
/// Positions are rounded from the first point, so a short segment late in the table would lose its
/// last digits.
pub fn eliminate(before: EliminationRow, (h0, p0): (f64, f64), (h1, p1): (f64, f64)) -> EliminationRow {
    let (s0, s1) = (p0 / h0, p1 / h1);
    let (lambda, mu) = weights(h0, h1);
    let right = 3.0 * (lambda * s0 + mu * s1);
    let pivot = pivot(lambda, before.c);
    EliminationRow { d: (right - lambda * before.d) / pivot, c: mu / pivot }
}

/// Replaces d by the velocities, backwards from the last point, which has its own. The times are
/// still the user's.
pub fn substitute(scratch: &mut Scratch<'_>) {
    let count = scratch.used();
    let mut next = 0.0;
    let mut cs = [0.0; STRIDE_POINTS];
    for block in (0..count.div_ceil(STRIDE_POINTS)).rev() {
        let start = block * STRIDE_POINTS;
        let mut c = scratch.kept(block);
        for (index, point) in (start..count).zip(&mut cs) {
            let time = |index: usize| scratch.knot(index).map(|knot| knot.time);
            if index + 1 == count {
                // The last point has its velocity.
                c = 0.0;
            } else if index > start
                && let (Some(before), Some(here), Some(after)) = (time(index - 1), time(index), time(index + 1))
            {
                let (lambda, mu) = weights(here - before, after - here);
                c = mu / pivot(lambda, c);
            }
            *point = c;
        }
        for (point, c) in cs.iter().enumerate().take(count.saturating_sub(start)).rev() {
            if let Some(mut knot) = scratch.knot(start + point) {
                knot.vel -= c * next;
                next = knot.vel;
                scratch.set(start + point, knot);
            }
        }
    }
}
