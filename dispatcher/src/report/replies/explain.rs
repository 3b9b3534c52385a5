//! Why the tick refused a start: the reason that the view shows.
use super::Reading;
use crate::plan::geometry::pulses;
use crate::refuse::{Refused, latched};
use crate::report::answer::Refuser;
use protocol::command::opcode;
use protocol::reason::Reason;
use servo::output::TIMED_OUTPUTS;
use servo::status::{FAULTS, LIMIT_NEGATIVE, LIMIT_POSITIVE, RUNNING, SERVO_ON};
use servo::tick_command::MotionMode;
use servo::units::{Axis, Crd};

impl<const AXES: usize> Reading<'_, AXES> {
    /// The reason of a start, or of another command, that the tick refused.
    pub fn explain(&self, command: u16, refuser: Refuser) -> Refused {
        let switches = matches!(command, opcode::FollowSwitch | opcode::FollowSwitchEx | opcode::FollowSwitchNowEx);
        let (axis, status) = match refuser {
            Refuser::Axis(axis, status) => (axis, status),
            Refuser::Crd(crd) => return self.explain_crd(crd),
            Refuser::Laser(channel) => {
                let fault = self.view.lasers.get(usize::from(channel)).map_or(0, |laser| laser.fault as u8);
                return Refused::new(Reason::LaserFault).got(channel.into()).limits(0.0, fault.into());
            }
            Refuser::Outputs => {
                return Refused::new(Reason::TimedOutputs).limits(0.0, TIMED_OUTPUTS as f64);
            }
            Refuser::Nobody => return Refused::new(Reason::Late),
        };
        let causes = self.view.axes.get(axis.index()).map_or(0, |sampled| sampled.blocked);
        let blocked = causes != 0;
        let limit = self.limit_ahead(axis, status);
        let (reason, got) = match limit.filter(|_| !blocked) {
            _ if status & SERVO_ON == 0 => (Reason::ServoOff, status.into()),
            Some(limit) => limit,
            None if blocked => (latched(causes), status.into()),
            None if switches && status & RUNNING != 0 => (Reason::NotRunning, 0.0),
            None if status & RUNNING != 0 => (Reason::Moving, status.into()),
            // A ClrSts has come between: it was latched then.
            None if status & (FAULTS | LIMIT_POSITIVE | LIMIT_NEGATIVE) != 0 => (latched(status), status.into()),
            None if switches => (Reason::NotRunning, 0.0),
            None => (Reason::StateChanged, status.into()),
        };
        Refused::new(reason).axis(self.configuration.number_of(axis)).got(got)
    }

    /// The limit at which an axis in Jog or Trap stands still, if its target lies beyond: nothing
    /// is latched then.
    fn limit_ahead(&self, axis: Axis, status: u32) -> Option<(Reason, f64)> {
        let (shadow, at) = (self.executed.axis(axis), pulses(self.view.axes.get(axis.index())?.pos));
        let direction = match shadow.mode {
            MotionMode::Jog => shadow.vel,
            MotionMode::Trap => f64::from(shadow.pos) - at,
            _ => 0.0,
        };
        let (soft, beyond, switch) = match direction {
            direction if direction > 0.0 => {
                (shadow.soft.0, shadow.soft.0 != i32::MAX && at >= shadow.soft.0.into(), LIMIT_POSITIVE)
            }
            direction if direction < 0.0 => {
                (shadow.soft.1, shadow.soft.1 != i32::MIN && at <= shadow.soft.1.into(), LIMIT_NEGATIVE)
            }
            _ => return None,
        };
        if beyond {
            Some((Reason::AtSoftLimit, soft.into()))
        } else {
            (status & switch != 0).then_some((Reason::AtLimitSwitch, 0.0))
        }
    }

    /// A coordinate system that could not start.
    fn explain_crd(&self, crd: Crd) -> Refused {
        let (sampled, shadow) = (&self.view.crds[crd.index().min(Crd::MAX - 1)], self.executed.crd(crd));
        let number = self.configuration.crd_number(crd);
        let index = usize::from(shadow.fifo & 1);
        let empty = sampled.ends[index] == sampled.released[index];
        let left = |axis: &Axis| self.view.axes.get(axis.index()).is_some_and(|axis| axis.mode != MotionMode::Crd);
        let reason = match sampled.frame {
            None => Reason::CrdNotSet,
            Some(_) if sampled.runs => Reason::CrdRuns,
            Some(frame) => match frame.mask().axes().find(left) {
                Some(axis) => {
                    let refused = Refused::new(Reason::AxisLeftCrd).axis(self.configuration.number_of(axis));
                    return refused.got(number.into());
                }
                None if empty => Reason::CrdEmpty,
                None => Reason::CrdElsewhere,
            },
        };
        Refused::new(reason).axis(number).got(shadow.fifo.into())
    }
}
