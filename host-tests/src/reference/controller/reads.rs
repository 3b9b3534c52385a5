//! Reads: what they answer at the end of the tick in which they act.
use super::super::axis::{Master, Motion};
use super::super::call::{Call, Kind};
use super::super::effect::Effect;
use super::super::light::{LightCall, LightOf};
use super::super::number::Fix;
use super::super::slave::Begin;
use super::{Controller, Program, Reply, Value};

impl Controller {
    pub(super) fn answer(&mut self, program: &mut Program, now: i64) {
        for (index, call, free) in std::mem::take(&mut self.reads) {
            if let Call::Path(of) = &call {
                if !self.crds.contains_key(&(of.core, of.what.crd())) {
                    // A Reset of its instant.
                    continue;
                }
                let (value, open) = self.read_path(of, free, now);
                program.replies[index] = if open { Reply::Open } else { Reply::Done(value) };
                continue;
            }
            let value = match call {
                Call::Axis { kind, axis } => {
                    let axis = &self.axes[axis];
                    match kind {
                        Kind::GetPtLoop => Value::Whole(axis.pt.passes),
                        Kind::GetPvtLoop => Value::Two(axis.pvt.2, free as i64),
                        Kind::GetFollowLoop | Kind::GetFollowLoopEx => Value::Whole(axis.follow.passes),
                        Kind::GetEncPos => Value::Position(axis.encoder[1] - axis.encoder_zero, Fix::ZERO),
                        Kind::GetFollowStatus | Kind::GetFollowStatusEx => {
                            let pending = matches!(&axis.motion, Some(Motion::Slave(slave)) if slave.switching);
                            Value::Two(axis.follow.fifo as i64, pending.into())
                        }
                        Kind::GetSts => Value::Whole(axis.status().into()),
                        Kind::GetStopReason => {
                            if axis.why.is_some() {
                                *self.used.entry("why axes stopped").or_default() += 1;
                            }
                            Value::Whole(axis.why.map_or(0, |why| why as i64))
                        }
                        Kind::GetCaptureStatus => {
                            let of = axis.terminals.captured;
                            if of.is_some() {
                                *self.used.entry("captures read").or_default() += 1;
                            }
                            Value::Two(of.is_some().into(), of.map_or(0, |at| at.to_f64() as i64))
                        }
                        Kind::GetPrfPos => Value::Position(axis.name(), axis.slack + axis.late),
                        Kind::GetPrfVel => Value::Velocity(axis.v),
                        Kind::GetPrfAcc => Value::Velocity(axis.acceleration(Fix::ms(now)).unwrap_or(Fix::ZERO)),
                        Kind::GetEncVel => {
                            let displacement = axis.encoder[1] - axis.encoder[0];
                            Value::Velocity(displacement.over(Fix::ms(self.tick_ns)))
                        }
                        Kind::PvtStatus => Value::Table(axis.table.into(), axis.table_time(Fix::ms(now)).to_f64()),
                        // Settings have been answered at the call.
                        _ => Value::None,
                    }
                }
                Call::PtSpace { axis, .. } => {
                    // What was given before the call; while it runs, what is over at the tick is
                    // free again.
                    let axis = &self.axes[axis];
                    let ran = if matches!(axis.motion, Some(Motion::Stream(..))) { axis.pt.ran } else { axis.pt.over };
                    Value::Whole(free.wrapping_add(ran) as i64)
                }
                Call::Light(LightCall { channel, what }) => {
                    let ms = now as f64 / 1e6;
                    match (self.light.read(channel as usize, what, [ms, self.tick_ns as f64 / 1e6]), what) {
                        (None, _) => Value::None,
                        (Some(power), LightOf::GetPower) => Value::Velocity(Fix::of_f64(power)),
                        (Some(of), _) => Value::Whole(of as i64),
                    }
                }
                Call::Effect(Effect::GetDac { dac, .. }) => match self.levels.driven >> (dac - 1) & 1 {
                    0 => Value::Whole(self.levels.analog[dac as usize - 1].into()),
                    // What it reads is compared as the power.
                    _ => Value::None,
                },
                Call::Effect(Effect::GetAdc { adc, .. }) => Value::Volts(self.levels.volts[adc as usize - 1]),
                Call::Effect(Effect::GetDi { core, kind } | Effect::GetDiEx { core, kind, .. }) => {
                    Value::Whole(self.inputs_of(core, kind))
                }
                Call::Effect(_) => Value::Whole(self.levels.general.cast_signed().into()),
                _ => Value::Whole(free as i64),
            };
            let open = match call {
                Call::Axis { axis, .. } if self.axes[axis].resets > 0 => true,
                // In the tick in which its stream ends.
                Call::PtSpace { axis, .. } if self.axes[axis].pt.over > 0 => true,
                // An entry of a path may set one in the tick that follows.
                Call::Light(of) => {
                    let runs = self.crds.values().any(|crd| crd.runs);
                    let pends = of.what != LightOf::GetGate && self.light.is_busy(of.channel as usize);
                    runs || pends || value == Value::None
                }
                // An entry of a path may set one in the tick that follows.
                Call::Effect(Effect::GetDac { .. }) => value == Value::None || self.crds.values().any(|crd| crd.runs),
                Call::Effect(Effect::GetDo { .. } | Effect::GetDoEx { .. }) => self.crds.values().any(|crd| crd.runs),
                Call::Axis { kind, axis } => {
                    let axis_of = &self.axes[axis];
                    let tick = [Fix::ZERO, Fix::ONE];
                    let by_encoder = axis_of.follow.master.is_some_and(Master::is_sampled);
                    let lead = axis_of
                        .follow
                        .master
                        .map(|master| self.lead(axis_of.filter.as_ref(), master, &tick, &|_| None));
                    let knot = match (&axis_of.motion, &lead) {
                        (Some(Motion::Slave(slave)), Some(lead)) => by_encoder || slave.is_near_knot(lead),
                        _ => false,
                    };
                    match kind {
                        Kind::GetPrfPos | Kind::GetPrfMode => false,
                        Kind::GetEncPos | Kind::GetEncVel => axis_of.is_lost,
                        Kind::GetStopReason => axis_of.why.is_none() || axis_of.open.is_some(),
                        Kind::GetCaptureStatus => axis_of.is_lost,
                        Kind::GetPrfAcc => axis_of.acceleration(Fix::ms(now)).is_none() || axis_of.open.is_some(),
                        Kind::PvtStatus => !axis_of.is_in_table() || axis_of.open.is_some(),
                        Kind::GetPrfVel => knot || axis_of.open.is_some(),
                        _ => self.axes[axis].open.is_some(),
                    }
                }
                _ => false,
            };
            program.replies[index] = if open { Reply::Open } else { Reply::Done(value) };
        }
    }

    /// A setting is what it is at the call, whatever is set after it at its instant.
    fn setting_read(&self, call: &Call) -> Option<Value> {
        let Call::Axis { kind, axis } = call else { return None };
        let axis = &self.axes[*axis];
        Some(match kind {
            Kind::GetFollowMemory | Kind::GetFollowMemoryEx => Value::Whole(axis.follow.memory.into()),
            Kind::GetFollowEvent | Kind::GetFollowEventEx => match axis.follow.begin {
                Begin::Start => Value::Whole(1),
                Begin::Pass { up, name } => Value::Three(2, if up { 1 } else { -1 }, name),
            },
            Kind::GetPrfMode => Value::Whole(axis.mode as i64),
            Kind::GetTrapPrm => Value::Reals([axis.trap.acc, axis.trap.dec, 0.0, 0.0]),
            Kind::GetJogPrm => Value::Reals([axis.jog.acc, axis.jog.dec, 0.0, 0.0]),
            Kind::GetPos => Value::Whole(axis.target.into()),
            Kind::GetVel => Value::Reals([axis.speed, 0.0, 0.0, 0.0]),
            Kind::GetSoftLimit => Value::Two(axis.soft.0.into(), axis.soft.1.into()),
            Kind::GetStopDec => Value::Reals([axis.stop_dec, 1000.0, 0.0, 0.0]),
            Kind::GetAxisBand => Value::Two(axis.band.0.into(), axis.band.1.into()),
            Kind::GetPosErr => Value::Whole(axis.pos_err.into()),
            Kind::GetPtMemory => Value::Whole(axis.pt.memory.into()),
            _ => return None,
        })
    }

    pub(super) fn read(&mut self, index: usize, call: &Call, free: usize) -> Reply {
        if let Some(value) = self.setting_read(call) {
            return Reply::Done(value);
        }
        let free = match call {
            Call::Axis { kind: Kind::GetPvtLoop, axis } => self.axes[*axis].pvt.0 as usize,
            _ => free,
        };
        self.reads.push((index, call.clone(), free));
        Reply::Open
    }
}
