//! The geometry of one motion: its length, and the position at a path length.
//!
//! In: the position where it starts, its entry. Out: its length; the position at a path length from
//! its start. Cannot fail: a motion without length has length 0, and an arc that would not fit
//! (which admission has excluded) goes straight.
//!
//! A line is start + s·unit vector for a path length s. An arc turns the vector from its centre to
//! its start: S + (cos α − 1)·V ± sin α·V⊥ with α = s/R. Centre and radius follow from both ends
//! and the sweep θ: R = c/(2·sin(θ/2)) for a chord of length c, and V = −d/2 ∓ d⊥/2·cot(θ/2) for a
//! chord d. So an arc ends on its target whatever the rounding.
use super::entry::{EntryContent, Plane, Sweep};
use super::{DIMENSIONS, PathPos};
use crate::math::float::Float;
use crate::math::sine::{sin_cos, sinc};
use crate::math::wide::{mulhi_near, mulhi_su, umulhi};
use crate::segment::piece::Scaled;
use crate::units::{Exact, Pos, whole};

/// The gearing of an axis to a motion.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct GearMotion {
    /// Displacement of the axis per path length, in 2^(w − 62).
    ratio: i64,
    /// |ratio| < 2^width.
    width: i32,
}

impl GearMotion {
    pub(super) const NONE: GearMotion = GearMotion { ratio: 0, width: 0 };

    /// `pulses` over a path of this length.
    pub(super) fn over(pulses: i32, inverse: Float) -> GearMotion {
        let ratio = Float::new(pulses < 0, pulses.unsigned_abs() as u64, 0).mul(inverse);
        let width = ratio.width().clamp(-40, 60);
        GearMotion { ratio: ratio.to_i64(62 - width), width }
    }

    /// Displacement of the axis per path length.
    pub(super) fn ratio(self) -> Scaled {
        Scaled { m: self.ratio, e: (62 - self.width) as i16 }
    }

    /// Displacement after `distance`.
    pub(super) fn at(self, distance: Exact) -> Pos {
        // The larger the ratio, the shorter the path: a displacement is below 2³¹ pulses.
        let more = self.width.clamp(0, 32);
        let distance = (distance.0.max(0) >> (34 - more)) as u64;
        // In 2^-(28 - width + more).
        let x = mulhi_su(self.ratio, distance);
        let down = 6 - self.width + more;
        if down > 0 {
            let twice = x >> ((down - 1) as u32).min(63);
            Pos((twice >> 1) + (twice & 1))
        } else {
            Pos(x << ((-down) as u32 & 63))
        }
    }
}

/// The path length in 2⁻³⁰ pulse; it is never negative and below 2³⁴ pulses.
#[inline(always)]
fn long(distance: Pos) -> u64 {
    (distance.0.max(0) as u64) << 8
}

/// How the direction of a motion turns along the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Curvature {
    /// The plane in which it turns.
    pub plane: Plane,
    /// From the first of its coordinates to the second.
    pub ccw: bool,
    /// Turns per pulse in 2^(`shift` − 98); 0 on a line.
    pub turns: u64,
    /// See `turns`.
    pub shift: i32,
}

impl Curvature {
    /// It does not turn.
    pub const STRAIGHT: Curvature = Curvature { plane: Plane::Xy, ccw: false, turns: 0, shift: 0 };
}

#[derive(Debug, Clone, Copy)]
enum ShapeKind {
    /// Unit vector in 2⁻⁶¹, plus [`ONE_Q61`]: no factor is negative. All but the first
    /// `coordinates` of it are 0.
    Line { unit: [u64; DIMENSIONS], heading: [i32; DIMENSIONS], coordinates: u8 },
    /// V and R in 2⁻³⁰ pulse, V/R in 2⁻³⁰; turns per pulse in 2^-(64 + shift).
    Arc { plane: Plane, ccw: bool, vector: [i64; 2], radius: i64, radial: [i32; 2], rate: u64, shift: i32 },
}

/// 1 in 2⁻⁶¹.
const ONE_Q61: u64 = 1 << 61;

impl ShapeKind {
    fn arc(plane: Plane, ccw: bool, vector: [i64; 2], radius: Float, turns: Float) -> ShapeKind {
        let inverse = radius.recip();
        let radial = vector.map(|x| Float::new(x < 0, x.unsigned_abs(), -30).mul(inverse).to_i64(30) as i32);
        let (rate, shift) = rate(turns);
        ShapeKind::Arc { plane, ccw, vector, radius: radius.to_i64(30), radial, rate, shift }
    }
}

/// The part of a motion's geometry that is made next.
#[derive(Debug, Clone, Copy)]
pub(super) enum GeometryStep {
    Nothing,
    Line,
    Unit { distance: [i64; DIMENSIONS] },
    Chord { plane: Plane, sweep: Sweep },
    Angle { plane: Plane, sweep: Sweep, chord: Float },
    Radius { plane: Plane, sweep: Sweep, radius: Float, cot: Float },
    Cycle { plane: Plane, ccw: bool, vector: [i64; 2], radius: Float, turns: Float },
}

crate::state! {
    /// The geometry of one motion.
    #[derive(Debug, Clone, Copy)]
    pub(super) struct MotionGeometry {
        /// Where it starts, and where it ends, exactly.
        pub(super) start: PathPos = [Pos(0); DIMENSIONS],
        pub(super) end: PathPos = [Pos(0); DIMENSIONS],
        /// Pulses.
        pub(super) length: Float = Float::ZERO,
        geometry: ShapeKind = ShapeKind::Line { unit: [ONE_Q61; DIMENSIONS], heading: [0; DIMENSIONS], coordinates: 0 },
    }
    pub(super) const NONE;
}

/// Half of a number with 22 fraction bits.
fn half(x: i64) -> Float {
    Float::new(x < 0, x.unsigned_abs(), -(Pos::FRAC_BITS as i32) - 1)
}

/// Sum of squares.
fn norm(parts: &[i64]) -> u128 {
    parts.iter().fold(0, |sum, x| {
        let x = x.unsigned_abs() as u128;
        sum.wrapping_add(x * x)
    })
}

impl MotionGeometry {
    /// Sets where it starts and ends, and what is to be made next. `exact` replaces the target of a
    /// line that does not start there, where it is the pulse nearest to it.
    #[inline(always)]
    pub(super) fn begin(&mut self, start: PathPos, item: &EntryContent, exact: Option<PathPos>) -> GeometryStep {
        (self.start, self.end, self.length) = (start, start, Float::ZERO);
        match *item {
            EntryContent::Line { to, dimensions, .. } => {
                let mut end = start;
                for (end, to) in end.iter_mut().zip(to).take(dimensions) {
                    *end = Pos::pulses(to);
                }
                let back = |exact: &PathPos| exact.map(whole) == end.map(whole) && *exact != start;
                self.end = exact.filter(back).unwrap_or(end);
                GeometryStep::Line
            }
            EntryContent::Arc { plane, to, sweep, .. } => {
                for (position, to) in plane.coordinates().into_iter().zip(to) {
                    if let Some(x) = self.end.get_mut(position) {
                        *x = Pos::pulses(to);
                    }
                }
                GeometryStep::Chord { plane, sweep }
            }
            EntryContent::Circle { plane, centre, ccw, .. } => {
                let radius = Float::from_fixed(norm(&centre), 60).sqrt();
                self.length = radius.mul(Float::TAU);
                let [a, b] = centre;
                GeometryStep::Cycle {
                    plane,
                    ccw,
                    vector: [a.wrapping_neg(), b.wrapping_neg()],
                    radius,
                    turns: Float::ONE,
                }
            }
            _ => GeometryStep::Nothing,
        }
    }

    /// Makes a part of it, a few hundred instructions. Returns whether that was the last.
    #[inline(never)]
    pub(super) fn advance(&mut self, draft: &mut GeometryStep) -> bool {
        *draft = match *draft {
            GeometryStep::Nothing => GeometryStep::Nothing,
            GeometryStep::Line => self.line(),
            GeometryStep::Unit { distance } => self.unit(distance),
            GeometryStep::Chord { plane, sweep } => self.chord(plane, sweep),
            GeometryStep::Angle { plane, sweep, chord } => self.angle(plane, sweep, chord),
            GeometryStep::Radius { plane, sweep, radius, cot } => self.radius(plane, sweep, radius, cot),
            GeometryStep::Cycle { plane, ccw, vector, radius, turns } => {
                self.geometry = ShapeKind::arc(plane, ccw, vector, radius, turns.div(self.length));
                GeometryStep::Nothing
            }
        };
        matches!(draft, GeometryStep::Nothing)
    }

    fn line(&mut self) -> GeometryStep {
        let distance = [0, 1, 2, 3].map(|i: usize| difference(&self.start, &self.end, i));
        self.length = Float::from_fixed(norm(&distance), 2 * Pos::FRAC_BITS as i32).sqrt();
        GeometryStep::Unit { distance }
    }

    fn unit(&mut self, distance: [i64; DIMENSIONS]) -> GeometryStep {
        let inverse = self.length.recip();
        let unit = distance.map(|x| if x == 0 { 0 } else { half(x).scale(1).mul(inverse).to_i64(61) });
        let coordinates = distance.iter().rposition(|x| *x != 0).map_or(0, |last| last as u8 + 1);
        let (heading, unit) = (unit.map(|x| (x >> 31) as i32), unit.map(|x| ONE_Q61.wrapping_add_signed(x)));
        self.geometry = ShapeKind::Line { unit, heading, coordinates };
        GeometryStep::Nothing
    }

    fn across(&self, plane: Plane) -> [i64; 2] {
        plane.coordinates().map(|i| difference(&self.start, &self.end, i))
    }

    fn chord(&mut self, plane: Plane, sweep: Sweep) -> GeometryStep {
        let chord = Float::from_fixed(norm(&self.across(plane)), 2 * Pos::FRAC_BITS as i32).sqrt();
        GeometryStep::Angle { plane, sweep, chord }
    }

    fn angle(&mut self, plane: Plane, sweep: Sweep, chord: Float) -> GeometryStep {
        // sin(θ/2) = sin x with x = π·turns, in (0, π/2]
        let x = sweep.half().mul(Float::TAU);
        let sine = x.mul(Float::from_fixed(sinc(x.to_fixed(63) as u64) as u128, 63));
        let (_, cosine) = sin_cos(sweep.half().to_fixed(64) as u64);
        let inverse = sine.recip();
        let radius = chord.mul(inverse).scale(-1);
        if chord.is_zero() || radius.width() > 32 {
            return GeometryStep::Line;
        }
        let cot = Float::new(false, cosine.max(0) as u64, -62).mul(inverse);
        GeometryStep::Radius { plane, sweep, radius, cot }
    }

    fn radius(&mut self, plane: Plane, sweep: Sweep, radius: Float, cot: Float) -> GeometryStep {
        let [a, b] = self.across(plane);
        let turns = sweep.turns();
        self.length = radius.mul(Float::TAU).mul(turns);
        // Left of the chord for a short counterclockwise arc.
        let right = sweep.ccw == sweep.long;
        let tilt = if right { cot.negate() } else { cot };
        let vector = [half(b).mul(tilt).sub(half(a)).to_i64(30), half(a).mul(tilt).add(half(b)).negate().to_i64(30)];
        GeometryStep::Cycle { plane, ccw: sweep.ccw, vector, radius, turns }
    }

    /// Two corners of a box that holds it, with a pulse to spare.
    pub(super) fn hull(&self) -> [PathPos; 2] {
        let [mut low, mut high] = [self.start, self.start];
        for ((low, high), end) in low.iter_mut().zip(&mut high).zip(&self.end) {
            (*low, *high) = ((*low).min(*end), (*high).max(*end));
        }
        // An arc is never further from its start than the diameter of its circle.
        let wide = match self.geometry {
            ShapeKind::Line { .. } => 0,
            ShapeKind::Arc { radius, .. } => radius >> 7,
        };
        let room = wide.saturating_add(1 << Pos::FRAC_BITS);
        [low.map(|x| Pos(x.0.saturating_sub(room))), high.map(|x| Pos(x.0.saturating_add(room)))]
    }

    /// How its direction turns.
    #[inline(always)]
    pub(super) fn bend(&self) -> Curvature {
        match &self.geometry {
            ShapeKind::Line { .. } => Curvature::STRAIGHT,
            ShapeKind::Arc { plane, ccw, rate, shift, .. } => {
                Curvature { plane: *plane, ccw: *ccw, turns: *rate, shift: *shift }
            }
        }
    }

    /// Publishes what of its position, direction and bend is constant along it.
    #[inline(always)]
    pub(super) fn publish(&self, position: &mut PathPos, heading: &mut [i32; DIMENSIONS], bend: &mut Curvature) {
        if let ShapeKind::Line { heading: straight, .. } = &self.geometry {
            // A step publishes at least two coordinates of the position in any case.
            let ([_, _, z, a], [_, _, z0, a0]) = (position, &self.start);
            (*z, *a) = (*z0, *a0);
            *heading = *straight;
            *bend = Curvature::STRAIGHT;
        } else {
            *position = self.start;
            *heading = [0; DIMENSIONS];
            *bend = self.bend();
        }
    }

    /// The position at `distance` along it, within 2⁻²¹ pulse, and the direction there, a unit
    /// vector in 2⁻³⁰, into what has been published.
    #[inline(always)]
    pub(super) fn follow(&self, distance: Pos, position: &mut PathPos, heading: &mut [i32; DIMENSIONS]) {
        match &self.geometry {
            ShapeKind::Line { unit, coordinates, .. } => {
                // In 2^-25, below 2^59: times 2^-61, over 2^64, it is a position; the bias adds the
                // path length itself.
                let distance = distance.0.max(0) as u64;
                let (w0, w1) = ((distance << 3) as u32, (distance >> 29) as u32);
                let on = |position: &mut Pos, start: &Pos, unit: &u64| {
                    let (u0, u1) = (*unit as u32, (unit >> 32) as u32);
                    let cross = product(u0, w1).wrapping_add(product(u1, w0)).wrapping_add(1 << 31);
                    let by = product(u1, w1).wrapping_add(cross >> 32).wrapping_sub(distance);
                    *position = Pos(start.0.wrapping_add_unsigned(by));
                };
                let ([x, y, z, a], [x0, y0, z0, a0], [ux, uy, uz, ua]) = (position, &self.start, unit);
                // Unrolled, as a loop costs as much as its body.
                on(x, x0, ux);
                on(y, y0, uy);
                if *coordinates > 2 {
                    on(z, z0, uz);
                    on(a, a0, ua);
                }
            }
            ShapeKind::Arc { plane, ccw, vector: [a, b], radial: [p, q], rate, shift, .. } => {
                let turn = umulhi(*rate, long(distance)).wrapping_shl(*shift as u32);
                let (sin, cos) = sin_cos(turn);
                let (near, far) = (short(sin), short(cos));
                let fall = cos - (1 << 62);
                // Counterclockwise, both after a quarter turn more.
                let (by, to) = if *ccw {
                    let by = [
                        mulhi_near(*a, fall).wrapping_sub(mulhi_near(*b, sin)),
                        mulhi_near(*b, fall).wrapping_add(mulhi_near(*a, sin)),
                    ];
                    (by, [-(near(*p) + far(*q)), far(*p) - near(*q)])
                } else {
                    let by = [
                        mulhi_near(*a, fall).wrapping_add(mulhi_near(*b, sin)),
                        mulhi_near(*b, fall).wrapping_sub(mulhi_near(*a, sin)),
                    ];
                    (by, [far(*q) - near(*p), -(near(*q) + far(*p))])
                };
                for ((index, by), to) in plane.coordinates().into_iter().zip(by).zip(to) {
                    if let (Some(position), Some(start), Some(heading)) =
                        (position.get_mut(index), self.start.get(index), heading.get_mut(index))
                    {
                        (*position, *heading) = (moved(*start, by), to);
                    }
                }
            }
        }
    }

    /// The direction at its start.
    pub(super) fn start_heading(&self) -> [i32; DIMENSIONS] {
        let mut heading = [0; DIMENSIONS];
        self.follow(Pos(0), &mut [Pos(0); DIMENSIONS], &mut heading);
        if let ShapeKind::Line { heading: straight, .. } = &self.geometry {
            heading = *straight;
        }
        heading
    }

    /// The furthest that a coordinate goes upwards, or downwards, on the whole circle of an arc.
    pub(super) fn extreme(&self, index: usize, up: bool) -> Option<Pos> {
        let ShapeKind::Arc { plane, vector, radius, .. } = &self.geometry else { return None };
        let position = plane.coordinates().iter().position(|of| *of == index)?;
        let radius = if up { *radius } else { radius.wrapping_neg() };
        Some(moved(*self.start.get(index)?, radius.wrapping_sub(*vector.get(position)?) >> 2))
    }

    /// The position at `distance` along it.
    pub(super) fn at(&self, distance: Pos) -> PathPos {
        let mut position = self.start;
        self.follow(distance, &mut position, &mut [0; DIMENSIONS]);
        position
    }
}

/// A factor in 2⁻⁶² for numbers in 2⁻³⁰, each of which is at most 1.
#[inline(always)]
fn short(factor: i64) -> impl Fn(i32) -> i32 {
    let factor = (factor >> 32) as i32;
    move |x| ((x as i64 * factor as i64) >> 30) as i32
}

/// A position and a displacement in 2⁻²⁸ pulse.
#[inline(always)]
fn moved(from: Pos, by: i64) -> Pos {
    Pos(from.0.wrapping_add((by >> 5).wrapping_add(1) >> 1))
}

#[inline(always)]
fn product(a: u32, b: u32) -> u64 {
    a as u64 * b as u64
}

fn difference(start: &PathPos, end: &PathPos, i: usize) -> i64 {
    let of = |position: &PathPos| position.get(i).copied().unwrap_or_default().0;
    of(end).wrapping_sub(of(start))
}

/// Turns per pulse, such that a path length in 2⁻³⁰ times it, high half, shifted up, is turns in
/// 2⁻⁶⁴.
fn rate(turns: Float) -> (u64, i32) {
    // turns·2^64·2^-30 = (high half)·2^shift with the mantissa in 2^-64
    let width = turns.width();
    let mantissa = turns.to_fixed(64 - width).unsigned_abs();
    // 2^64·2^-30·2^width per 2^-64·2^64
    (mantissa.min(u64::MAX as u128) as u64, (34 + width).clamp(0, 63))
}
