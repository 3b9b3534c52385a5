//! The motion of an axis that a coordinate system drives, for those who read it.
//!
//! In: the path at one tick, how the axis depends on it. Out: a motion in time. Integers only, so
//! every machine derives the same bits. Cannot fail.
use crate::math::float::Float;
use crate::path::Curvature;
use crate::segment::follow::motion_of;
use crate::segment::piece::Motion;
use crate::view::{CrdView, DrivenBy};

/// A number in 2⁻³⁰.
fn part(x: i32) -> Float {
    Float::new(x < 0, x.unsigned_abs() as u64, -30)
}

/// The motion of an axis of a coordinate system in its present state.
pub(crate) fn share(drive: DrivenBy, crd: &CrdView) -> Motion {
    let (speed, change) = (Float::from_scaled(crd.motion.velocity()), Float::from_scaled(crd.motion.acceleration()));
    match drive {
        DrivenBy::Gear { ratio, .. } => {
            let ratio = Float::from_scaled(ratio);
            motion_of(ratio.mul(speed), ratio.mul(change))
        }
        DrivenBy::Coordinate { index, .. } => {
            let index = index as usize;
            let heading = part(crd.heading.get(index).copied().unwrap_or(0));
            let turning = turning(&crd.bend, &crd.heading, index).mul(speed).mul(speed);
            motion_of(heading.mul(speed), heading.mul(change).add(turning))
        }
    }
}

/// The velocity alone, pulse/ms.
pub(crate) fn share_speed(drive: DrivenBy, crd: &CrdView) -> Float {
    let speed = Float::from_scaled(crd.motion.velocity());
    match drive {
        DrivenBy::Gear { ratio, .. } => Float::from_scaled(ratio).mul(speed),
        DrivenBy::Coordinate { index, .. } => part(crd.heading.get(index as usize).copied().unwrap_or(0)).mul(speed),
    }
}

/// How a coordinate of the direction changes per pulse of path length.
fn turning(bend: &Curvature, heading: &[i32], index: usize) -> Float {
    let [first, second] = bend.plane.coordinates();
    // A quarter turn on from the direction.
    let (across, minus) = match index {
        _ if index == first => (second, bend.ccw),
        _ if index == second => (first, !bend.ccw),
        _ => return Float::ZERO,
    };
    let across = part(heading.get(across).copied().unwrap_or(0));
    let across = if minus { across.negate() } else { across };
    Float::new(false, bend.turns, bend.shift - 98).mul(Float::TAU).mul(across)
}
