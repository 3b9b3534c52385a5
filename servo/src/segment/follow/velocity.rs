//! The motion of a slave in time, for readers: velocity and acceleration from those of its master.
//!
//! In: the motion in the slave's piece, whose parameter is the master's progress, and the motion of
//! the master. Out: a motion in time. Integers only, so every machine derives the same bits. Cannot
//! fail.
use crate::math::float::Float;
use crate::segment::piece::{Motion, Recip, Scaled};
use crate::units::Axis;

/// The master of an axis that follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lead {
    /// The axis whose planned motion it follows; none for an encoder or a filtered position, which
    /// moves evenly within the tick.
    pub axis: Option<Axis>,
    /// Progress is the master's position with its sign changed.
    pub down: bool,
    /// Progress backwards has no effect.
    pub one_way: bool,
}

/// 10⁶ has 44 leading zeros: 1/ms in ns.
const PER_MS: Recip = Recip { m: (u128::MAX / (1_000_000 << 44) - (1 << 64)) as u64, shift: 44 };
/// 2²²/10⁶: [`Motion::velocity`] takes the 10⁶ units of a ms for a million units of Pos.
const PULSE_PER_MS: Float = Float::new(false, (1 << 63) / 15625, -47);

/// A motion of this velocity, pulse/ms, and acceleration, pulse/ms².
pub fn of(velocity: Float, acceleration: Float) -> Motion {
    let half = acceleration.scale(-1);
    let frac = (60 - velocity.width().max(half.width())).clamp(0, 118);
    if velocity.is_zero() && half.is_zero() {
        return Motion::STANDSTILL;
    }
    let c = [velocity.to_i64(frac), half.to_i64(frac + 1), 0];
    Motion { c, frac, tau: 0, recip: PER_MS, t: 0 }
}

/// The ratio of a slave, pulse per pulse of its master. `down`: its progress is the master's
/// position with its sign changed.
fn ratio(slave: &Motion, down: bool) -> Float {
    let ratio = Float::from_scaled(slave.velocity()).mul(PULSE_PER_MS);
    if down { ratio.negate() } else { ratio }
}

/// The velocity of a slave whose master moves at `speed`; 0 if a motion backwards has no effect.
pub fn slave_velocity(slave: &Motion, lead: Lead, speed: Float) -> Float {
    if is_back(lead, speed) { Float::ZERO } else { ratio(slave, lead.down).mul(speed) }
}

/// Whether such a speed has no effect.
fn is_back(lead: Lead, speed: Float) -> bool {
    lead.one_way && !speed.is_zero() && speed.is_negative() != lead.down
}

/// The motion of a slave in time.
pub fn compose(slave: Motion, lead: Lead, master: Motion) -> Motion {
    let real = |x: Scaled| Float::from_scaled(x);
    let (speed, change) = (real(master.velocity()), real(master.acceleration()));
    if is_back(lead, if speed.is_zero() { change } else { speed }) {
        return Motion::STANDSTILL;
    }
    let ratio = ratio(&slave, lead.down);
    let bend = real(slave.acceleration()).mul(PULSE_PER_MS).mul(PULSE_PER_MS);
    of(ratio.mul(speed), bend.mul(speed).mul(speed).add(ratio.mul(change)))
}

/// A master that has moved `displacement` units of Pos in `period` ns.
pub fn straight(displacement: i64, period: u64) -> Motion {
    Motion {
        c: [displacement, 0, 0],
        frac: crate::units::Pos::FRAC_BITS as i32,
        tau: 0,
        recip: Recip::of(period),
        t: 0,
    }
}
