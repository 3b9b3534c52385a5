//! Velocities of axes in one tick, each computed once, whoever follows whom.
//!
//! In: axes in one tick. Out: velocities; integers only, so every machine derives the same bits.
//! Owns: those that were requested, and those of their masters. Work: a product for each link of a
//! chain. Cannot fail.
use super::axis_motion::share_speed;
use super::{AxisView, CrdView};
use crate::math::float::Float;
use crate::segment::follow::{motion_of, slave_velocity, straight};
use crate::segment::piece::Motion;
use crate::units::{Axis, AxisMask, Crd, Ns};

/// Velocities, pulse/ms.
pub(crate) struct AxisSpeeds<const AXES: usize> {
    speeds: [Float; AXES],
    known: AxisMask,
}

impl<const AXES: usize> AxisSpeeds<AXES> {
    /// None is known.
    pub(crate) const NONE: AxisSpeeds<AXES> = AxisSpeeds { speeds: [Float::ZERO; AXES], known: AxisMask(0) };

    fn known(&self, axis: Axis) -> Option<Float> {
        self.speeds.get(axis.index()).copied().filter(|_| self.known.has(axis))
    }

    fn record_speed(&mut self, axis: Axis, speed: Float) {
        if let Some(slot) = self.speeds.get_mut(axis.index()) {
            *slot = speed;
            self.known.0 |= axis.mask().0;
        }
    }

    /// A motion with the velocity of an axis that has a leader, and no acceleration.
    #[inline(never)]
    pub(crate) fn motion<'v>(
        &mut self,
        axis: Option<Axis>,
        view: &'v AxisView,
        axes: impl Fn(Axis) -> Option<&'v AxisView>,
        crd: impl Fn(Crd) -> Option<&'v CrdView>,
        period: Ns,
    ) -> Motion {
        // Masters, the nearest first, up to one whose velocity is at hand.
        let mut masters = [Axis::FIRST; Axis::MAX];
        let (mut depth, mut at) = (0usize, view);
        let mut speed = loop {
            let Some(lead) = at.lead else {
                break match at.drive {
                    Some(drive) => crd(drive.crd()).map_or(Float::ZERO, |crd| share_speed(drive, crd)),
                    None => Float::from_scaled(at.motion.velocity()),
                };
            };
            let Some(master) = lead.axis else {
                let displacement = Float::from_scaled(straight(at.master_displacement, period.0).velocity());
                break slave_velocity(&at.motion, lead, displacement);
            };
            let (Some(slot), Some(next)) = (masters.get_mut(depth), axes(master)) else { break Float::ZERO };
            *slot = master;
            depth = depth.wrapping_add(1);
            if let Some(speed) = self.known(master) {
                break speed;
            }
            at = next;
        };
        while let Some(&master) = depth.checked_sub(1).and_then(|last| masters.get(last)) {
            self.record_speed(master, speed);
            depth = depth.wrapping_sub(1);
            let slave = match depth.checked_sub(1) {
                Some(before) => masters.get(before).and_then(|axis| axes(*axis)),
                None => Some(view),
            };
            let Some((slave, lead)) = slave.and_then(|slave| Some((slave, slave.lead?))) else { break };
            speed = slave_velocity(&slave.motion, lead, speed);
        }
        if let Some(axis) = axis {
            self.record_speed(axis, speed);
        }
        motion_of(speed, Float::ZERO)
    }
}
