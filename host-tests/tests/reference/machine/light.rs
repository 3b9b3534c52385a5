//! Laser channels, as calls travel, and what they read.
use super::Got;
use client::{Answer, Call as Wire};
use host_tests::reference::{Command, LightCall, LightOf, LightTable};
use protocol::command::*;

pub fn call(of: &LightCall) -> Wire {
    let (core, channel) = (1.into(), of.channel.into());
    let bit = |on: bool| u16::from(on);
    match of.what {
        LightOf::Connector(on) => Wire::of(SetAxisMode { core, axis: of.axis().into(), mode: i16::from(on).into() }),
        LightOf::Mode { mode, max, min, delayed } => {
            let (mode, delay_mode) = (mode.into(), i16::from(delayed).into());
            Wire::of(LaserPowerMode { core, mode, max: max.into(), min: min.into(), channel, delay_mode })
        }
        LightOf::Carrier(khz) => Wire::of(LaserOutFrq { core, frequency: khz.into(), channel }),
        LightOf::Width(us) => Wire::of(SetPulseWidth { core, width_us: us.into(), channel }),
        LightOf::Gate(true) => Wire::of(LaserOn { core, channel }),
        LightOf::Gate(false) => Wire::of(LaserOff { core, channel }),
        LightOf::Switch(value) => Wire::of(SetHSIOOpt { core, value: value.into(), channel }),
        LightOf::Power(power) => Wire::of(LaserPrfCmd { core, power: power.into(), channel }),
        LightOf::Map(map) => Wire::of(SetLaserCrdMap { core, channel, map: map.into() }),
        LightOf::Delays { off, on } => {
            Wire::of(SetLevelDelay { core, off_delay_us: off.into(), on_delay_us: on.into(), channel })
        }
        LightOf::Fpk([time1, time2, off]) => {
            let (time1_us, time2_us, laser_off_delay_us) = (time1.into(), time2.into(), off.into());
            Wire::of(EnaFPK { core, time1_us, time2_us, laser_off_delay_us, channel })
        }
        LightOf::NoFpk => Wire::of(DisFPK { core, channel }),
        LightOf::Standby { on, khz, duty } => {
            let (mode, frequency, duty) = (bit(on).into(), khz.into(), duty.into());
            Wire::of(SetWaitPulse { core, mode, frequency, duty, channel })
        }
        LightOf::StandbyBoth { on, khz, duty } => {
            let (mode, frequency, duty) = (bit(on).into(), khz.into(), duty.into());
            Wire::of(SetWaitPulseEx { core, mode, frequency, duty })
        }
        LightOf::Resolution(mode) => Wire::of(SetLaserMode { core, mode: mode.into() }),
        LightOf::PreVoltage { on, volts } => {
            Wire::of(SetPreVltg { core, mode: bit(on).into(), voltage: volts.into(), channel })
        }
        LightOf::Distance(given) => {
            let (source, from, scale) = given.unwrap_or((0, [0; 4], [1.0; 4]));
            let (mode, source) = (i16::from(given.is_some()).into(), source.into());
            let (pos, scale) = (from.map(Into::into), scale.map(Into::into));
            Wire::of(SetLaserDisMode { core, mode, source, pos, scale, channel })
        }
        LightOf::Ratios(ratio, [min, max]) => {
            let (ratio, min, max) = (ratio.map(Into::into), min.into(), max.into());
            Wire::of(SetLaserDisRatio { core, ratio, min, max, channel, bounds_given: 1 })
        }
        LightOf::EndFollow(crds) => Wire::of(Stop { core, mask: (crds << 10).into(), option: 0.into(), form: 1 }),
        LightOf::ZeroOnTime => Wire::of(ZeroLaserOnTime { core, channel }),
        LightOf::ClearFault => Wire::of(ClrLaserFault { core, channel }),
        LightOf::GetGate => Wire::of(GetHSIOOpt { core, channel }),
        LightOf::GetSwitched => Wire::of(LaserOnStatus { core, channel }),
        LightOf::GetMap => Wire::of(GetLaserCrdMap { core, channel }),
        LightOf::GetPower => Wire::of(GetLaserPower { core, channel }),
        LightOf::GetOnTime => Wire::of(GetLaserOnTime { core, channel }),
        LightOf::GetFault => Wire::of(GetLaserFault { core, channel }),
    }
}

/// A table, which fits in a message.
pub fn table(of: &LightTable) -> Wire {
    let (core, channel, first) = (1.into(), of.channel().into(), 0.into());
    match of {
        LightTable::Powers { table, points, .. } => {
            let item = |&[vel, power]: &[f64; 2]| LaserFollowPoint { vel: vel.into(), power: power.into() };
            let items: Vec<LaserFollowPoint> = points.iter().map(item).collect();
            let (table, count) = ((*table).into(), (points.len() as i32).into());
            Wire::with_items(SetLaserFollowTable { core, table, count, channel, first }, &items)
        }
        LightTable::Lines { points, bounds: [min, max], limits, .. } => {
            let item = |&(pos, ratio): &(i32, f64)| LaserDisPoint { ratio: ratio.into(), pos: pos.into() };
            let items: Vec<LaserDisPoint> = points.iter().flatten().map(item).collect();
            let (count, limits_given) = ((points[0].len() as i16).into(), u8::from(limits.is_some()));
            let (min, max, limit) = ((*min).into(), (*max).into(), limits.unwrap_or_default().map(Into::into));
            let request = SetLaserDisTable1D { core, count, min, max, limit, channel, limits_given, first };
            Wire::with_items(request, &items)
        }
        LightTable::Plane { axes, x, y, ratios, bounds: [min, max], limits, .. } => {
            let positions = x.iter().chain(y).map(|at| f64::from(*at));
            let items: Vec<LaserDisValue> =
                positions.chain(ratios.iter().copied()).map(|value| LaserDisValue { value: value.into() }).collect();
            let (axis, count) = (axes.map(Into::into), [x.len(), y.len()].map(|count| (count as i16).into()));
            let (min, max, limit) = ((*min).into(), (*max).into(), limits.unwrap_or_default().map(Into::into));
            let limits_given = u8::from(limits.is_some());
            let request = SetLaserDisTable2D { core, axis, count, min, max, limit, channel, limits_given, first };
            Wire::with_items(request, &items)
        }
    }
}

/// An entry of a path.
pub fn entry(core: i16, crd: i16, fifo: i16, channel: i16, command: &Command) -> Wire {
    let (core, crd, fifo, channel) = (core.into(), crd.into(), fifo.into(), channel.into());
    match *command {
        Command::Gate(true) => Wire::of(BufLaserOn { core, crd, fifo, channel }),
        Command::Gate(false) => Wire::of(BufLaserOff { core, crd, fifo, channel }),
        Command::Power(power) => Wire::of(BufLaserPrfCmd { core, crd, power: power.into(), fifo, channel }),
        Command::Source { encoder, start } => {
            let (source, start_given) = (i16::from(encoder).into(), u8::from(start.is_some()));
            let start_power = start.unwrap_or(0.0).into();
            Wire::of(BufLaserFollowMode { core, crd, source, fifo, channel, start_power, start_given })
        }
        Command::Ratio([ratio, min, max]) => {
            let (ratio, min, max) = (ratio.into(), min.into(), max.into());
            Wire::of(BufLaserFollowRatio { core, crd, ratio, min, max, fifo, channel })
        }
        Command::Follow(ratio, [min, max]) => {
            let (ratio, min, max) = (ratio.into(), min.into(), max.into());
            Wire::of(BufLaserPrfFollow { core, crd, ratio, min, max, fifo, channel })
        }
        Command::Table(table, [min, max]) => {
            let (table, min, max) = (table.into(), min.into(), max.into());
            Wire::of(BufLaserFollowTable { core, crd, table, min, max, fifo, channel })
        }
        Command::FollowOff => Wire::of(BufLaserFollowOff { core, crd, fifo, channel }),
    }
}

pub fn got(of: &LightCall, answer: &Answer) -> Option<Got> {
    match of.what {
        LightOf::GetGate => answer.reply::<GetHSIOOpt>().map(|(reply, _)| Got::Whole(reply.value.get().into())),
        LightOf::GetSwitched => answer.reply::<LaserOnStatus>().map(|(reply, _)| Got::Whole(reply.value.get().into())),
        LightOf::GetMap => answer.reply::<GetLaserCrdMap>().map(|(reply, _)| Got::Whole(reply.value.get().into())),
        LightOf::GetFault => answer.reply::<GetLaserFault>().map(|(reply, _)| Got::Whole(reply.value.get().into())),
        LightOf::GetOnTime => answer.reply::<GetLaserOnTime>().map(|(reply, _)| Got::Whole(reply.value.get().into())),
        LightOf::GetPower => answer.reply::<GetLaserPower>().map(|(reply, _)| Got::Real(reply.value.get())),
        _ => None,
    }
}
