//! Gear commands: ratio, event, start. Mode and master are those of Follow ([`super::follow`]).
//!
//! In: a command. Out: tick commands. Fails: with the parameter and the limit. An axis in gear runs
//! until a Stop, so a start of one that runs is a new ratio.
use super::context::Context;
use crate::refuse::{Admitted, Refused, choice};
use crate::report::answer::Answer;
use crate::shadow::ShadowChange;
use protocol::command::{GearStart, SetGearEvent, SetGearRatio};
use protocol::reason::Reason;
use servo::segment::follow::{GearRatio, GearRefused, StartEvent};
use servo::tick_command::{MotionMode, TickCommand};
use servo::units::AxisMask;

/// Has effect from the next GearStart on.
pub fn set_ratio<const AXES: usize>(context: &mut Context<AXES>, r: &SetGearRatio) -> Admitted<Answer> {
    let axis = context.axis_in(MotionMode::Gear, r.core.get(), r.profile.get())?;
    let given @ [master, slave, slope] = [r.master_even.get(), r.slave_even.get(), r.master_slope.get()];
    let ratio = GearRatio::of(master, slave, slope).map_err(|wrong| match wrong {
        GearRefused::Master => Refused::new(Reason::GearPart).field(2),
        GearRefused::TooSteep => {
            let high = f64::from(master).abs() * GearRatio::MAX as f64;
            Refused::range(3, slave.into(), -high, high)
        }
        GearRefused::Slope | GearRefused::TooFar => {
            let high = libm::floor(super::context::TRAVEL_PULSES * f64::from(master).abs() / f64::from(slave).abs());
            let refused = Refused::new(Reason::GearSlope).field(4).got(slope.into());
            refused.limits(2.0, high.min(i32::MAX.into()))
        }
    })?;
    context.only(TickCommand::GearRatio { axis, ratio }, ShadowChange::GearRatio { axis, given })
}

/// START 1; PASS 2 with the direction in which the master crosses, and the position. AREA 5 is not
/// there.
pub fn set_event<const AXES: usize>(context: &mut Context<AXES>, r: &SetGearEvent) -> Admitted<Answer> {
    let axis = context.axis_in(MotionMode::Gear, r.core.get(), r.profile.get())?;
    let (which, direction, pos) = (r.event.get(), r.start_para0.get(), r.start_para1.get());
    if which == 5 {
        return Err(Refused::new(Reason::GearArea).field(2).got(5.0));
    }
    let event = match (choice(2, which, 1, 2)?, direction) {
        (1, _) => StartEvent::Start,
        (_, 1 | -1) => StartEvent::Pass { up: direction > 0, pos },
        _ => return Err(Refused::new(Reason::CrossingDirection).field(3).got(direction.into())),
    };
    let given = (which, i16::try_from(direction).unwrap_or(0), pos);
    context.only(TickCommand::FollowEvent { axis, event }, ShadowChange::FollowEvent { axis, given })
}

/// Starts all axes of the mask on one tick, or none; those that are in gear take their new ratio.
pub fn start<const AXES: usize>(context: &mut Context<AXES>, r: &GearStart) -> Admitted<Answer> {
    let axes = context.mask(r.core.get(), r.mask.get(), 1)?;
    for axis in context.each(axes) {
        let shadow = context.shadow(axis);
        context.in_mode(axis, shadow.mode == MotionMode::Gear)?;
        if shadow.follow.master.is_none() {
            return Err(context.no(Reason::NoMaster, axis));
        }
        if shadow.follow.ratio.is_none() {
            return Err(context.no(Reason::NoRatio, axis));
        }
    }
    let fifo1 = AxisMask(0);
    context.start(axes, TickCommand::FollowStart { axes, fifo1 }, ShadowChange::Started { axes, fifo1, script_ns: 0 })
}
