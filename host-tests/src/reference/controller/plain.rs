//! Calls of every axis: names, modes, settings, Trap and Jog, Stop.
use std::collections::BTreeMap;

use super::super::axis::{Mode, Motion, Rates, Why};
use super::super::call::{Call, Kind, members};
use super::super::light::{Act, SERVO_OFF};
use super::super::number::Fix;
use super::answer::{Answer, DONE, check, either, range};
use super::{Controller, Reply, STANDSTILL_KNOWN_NS, Then, Value};

/// 2⁻²⁰ pulse: a way that may be rounding.
const ROUNDING_PULSES: Fix = Fix(1 << 44);

impl Controller {
    pub(super) fn plain(&mut self, index: usize, call: &Call, kind: Kind, axis_index: usize) -> Answer {
        let crd = self.axes[axis_index].light_crd();
        // A channel may be mapped to the coordinate system of another axis, whose alarm is there
        // yet.
        let alarmed = crd.is_some()
            && self.axes.iter().any(|axis| axis.is_alarmed() && (axis.light_crd().is_some() || axis.alarms.is_some()));
        let axis = &mut self.axes[axis_index];
        match kind {
            Kind::AxisOn => axis.servo = true,
            Kind::AxisOff => {
                let of = |crd: &super::super::crd::Crd| crd.started_here && crd.moves() >> axis_index & 1 == 1;
                if axis.driven || self.crds.values().any(of) {
                    self.open = Some("AxisOff of an axis on a path");
                }
                let fault = axis.light_crd().filter(|_| axis.servo).map(|crd| Act::Fault(crd, SERVO_OFF));
                axis.servo = false;
                axis.halt(Why::ServoOff);
                self.then[axis_index] = None;
                self.light.calls.extend(fault);
                if let Some(of) = crd.and_then(|crd| self.crds.get_mut(&(1, crd as i16 + 1))) {
                    of.stopped |= !of.awaited;
                    self.switched_off_ns = STANDSTILL_KNOWN_NS;
                }
            }
            Kind::ZeroPos => {
                check(!axis.runs())?;
                axis.rename(Fix::ZERO);
                axis.encoder_zero = axis.encoder[1];
                axis.is_lost = false;
                self.renamed(axis_index);
            }
            Kind::ClrSts => {
                if alarmed {
                    self.open = Some("a clear of light while an alarm is there");
                }
                axis.clear();
                if axis.light_crd().is_some() && self.interlock.is_just_closed() {
                    self.open = Some("a clear of light just after the interlock closes");
                }
                let clears = axis.light_crd().filter(|_| !self.interlock.is_cause());
                self.light.calls.extend(clears.map(Act::Clear));
            }
            Kind::PrfTrap | Kind::PrfJog | Kind::PrfPvt => {
                check(!axis.runs())?;
                if axis.joined && axis.is_alarmed() {
                    self.open = Some("an axis with an alarm that a coordinate system has for no time");
                }
                axis.set_mode(match kind {
                    Kind::PrfJog => Mode::Jog,
                    Kind::PrfPvt => Mode::Pvt,
                    _ => Mode::Trap,
                });
            }
            Kind::GetStopReason if axis.why.is_none() || axis.mode == Mode::Crd => return Ok(Reply::Open),
            Kind::GetTrapPrm | Kind::GetJogPrm => {
                check(axis.mode == if kind == Kind::GetTrapPrm { Mode::Trap } else { Mode::Jog })?;
                return Ok(self.read(index, call, 0));
            }
            Kind::GetPtMemory => {
                check(axis.mode == Mode::Pt)?;
                return Ok(self.read(index, call, 0));
            }
            Kind::GetPtLoop => {
                check(axis.mode == Mode::Pt && !axis.pt.dynamic)?;
                return Ok(self.read(index, call, 0));
            }
            Kind::GetPvtLoop | Kind::PvtStatus => {
                check(axis.mode == Mode::Pvt)?;
                return Ok(self.read(index, call, 0));
            }
            Kind::GetFollowLoop | Kind::GetFollowStatus | Kind::GetFollowMemory | Kind::GetFollowEvent => {
                check(axis.mode == Mode::Follow)?;
                return Ok(self.read(index, call, 0));
            }
            Kind::GetFollowLoopEx | Kind::GetFollowStatusEx | Kind::GetFollowMemoryEx | Kind::GetFollowEventEx => {
                check(axis.mode == Mode::FollowEx)?;
                return Ok(self.read(index, call, 0));
            }
            Kind::GetFollowMaster | Kind::GetFollowMasterEx => {
                check(axis.mode == if kind == Kind::GetFollowMaster { Mode::Follow } else { Mode::FollowEx })?;
                return Ok(self.master_of(axis_index));
            }
            _ => return Ok(self.read(index, call, 0)),
        }
        DONE
    }

    /// GetFollowMaster: axis of its core, type, item. Before SetFollowMaster it is axis 0 with type
    /// 2.
    fn master_of(&self, axis_index: usize) -> Reply {
        let Some(master) = self.axes[axis_index].follow.master else { return Reply::Done(Value::Three(0, 2, 0)) };
        let (index, kind) = self.setup.master(axis_index, master.axis, master.kind);
        Reply::Done(Value::Three(index.into(), kind.into(), master.item.into()))
    }

    pub(super) fn setting(&mut self, call: &Call) -> Answer {
        match *call {
            Call::SetPrfPos { axis, pos } => {
                check(!self.axes[axis].runs())?;
                self.axes[axis].rename(Fix::whole(pos.into()));
                self.renamed(axis);
            }
            Call::SetEncPos { axis, pos } => {
                let axis = &mut self.axes[axis];
                axis.encoder_zero = axis.encoder[1] - Fix::whole(pos.into());
            }
            // Nothing stands between what an axis reads and its profile and encoder.
            Call::SynchAxisPos { .. } => {}
            Call::SetAxisBand { axis, band, time } => {
                range(band >= 0 && time >= 0)?;
                self.axes[axis].band = (band, time);
            }
            Call::SetPosErr { axis, error } => {
                range(error > 0)?;
                self.axes[axis].pos_err = error;
            }
            Call::SetStopDec { axis, smooth } => {
                range(smooth > 0.0)?;
                let is_slave = matches!(self.axes[axis].motion, Some(Motion::Slave(_)));
                if is_slave && matches!(self.then[axis], Some(Then::Brake(..))) {
                    // A slave leaves its master at the end of the tick (docs/follow.md).
                    self.open = Some("SetStopDec at the instant of a Stop of a slave");
                }
                self.axes[axis].stop_dec = smooth;
            }
            Call::SetSoftLimit { axis, positive, negative } => self.axes[axis].soft = (positive, negative),
            Call::SetTrapPrm { axis, acc, dec } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Trap, acc >= 0.0 && dec >= 0.0)?;
                axis.trap = Rates { acc, dec };
            }
            Call::SetJogPrm { axis, acc, dec } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Jog, acc >= 0.0 && dec >= 0.0)?;
                axis.jog = Rates { acc, dec };
            }
            Call::SetPos { axis, pos } => {
                let axis = &mut self.axes[axis];
                check(axis.mode == Mode::Trap)?;
                axis.target = pos;
            }
            Call::SetVel { axis, vel } => {
                let axis = &mut self.axes[axis];
                check(matches!(axis.mode, Mode::Trap | Mode::Jog))?;
                axis.speed = vel;
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }

    pub(super) fn stop(&mut self, mask: u32, abrupt: u32) -> Answer {
        let of = |axis_index: usize| self.axes[axis_index].light_crd().or(self.axes[axis_index].geared_crd());
        let named = members(mask).filter_map(of).fold(0, |mask, crd| mask | 1 << crd);
        self.unsettle(named);
        self.stop_light(named);
        // A call stops a path once: abruptly, if it stops one of its axes so.
        let mut paths = BTreeMap::new();
        for axis_index in members(mask) {
            let (axis, abrupt) = (&mut self.axes[axis_index], abrupt >> axis_index & 1 == 1);
            match axis.crd.filter(|_| axis.driven) {
                Some(name) => {
                    axis.stopped = true;
                    *paths.entry(name).or_insert(false) |= abrupt;
                }
                None => self.stop_axis(axis_index, abrupt, Why::Smooth),
            }
        }
        paths.into_iter().for_each(|(name, abrupt)| self.stop_path(name, abrupt, Why::Smooth));
        DONE
    }

    /// Stops an axis, or the path that it belongs to.
    pub(super) fn stop_axis(&mut self, axis_index: usize, abrupt: bool, why: Why) {
        let axis = &mut self.axes[axis_index];
        axis.stopped = true;
        if axis.driven {
            if let Some(name) = axis.crd {
                self.stop_path(name, abrupt, why);
            }
            return;
        }
        if self.crds.values().any(|crd| crd.started_here && crd.moves() >> axis_index & 1 == 1) {
            self.open = Some("a Stop of an axis at the instant of a start of a path that moves it");
        }
        let axis = &mut self.axes[axis_index];
        if !axis.runs() {
            return;
        }
        // What begins at this instant does not move.
        if abrupt || axis.began {
            let rounding = self.rounding(&self.axes[axis_index]);
            let axis = &mut self.axes[axis_index];
            axis.slack += rounding;
            axis.halt(if abrupt && why == Why::Smooth { Why::Abrupt } else { why });
            self.then[axis_index] = None;
            return;
        }
        let brakes = match self.then[axis_index] {
            Some(then) => matches!(then, Then::Brake(..)),
            None => axis.braking.is_some(),
        };
        // A braking axis keeps the deceleration of its first Stop.
        if !brakes {
            self.then[axis_index] = Some(Then::Brake(axis.stop_dec, why));
        }
    }

    pub(super) fn update(&mut self, mask: u32, now: i64) -> Answer {
        for axis_index in members(mask) {
            let axis = &self.axes[axis_index];
            check(match axis.mode {
                Mode::Trap => axis.trap.acc > 0.0 && axis.trap.dec > 0.0,
                Mode::Jog => axis.jog.acc > 0.0,
                _ => false,
            })?;
            let displacement = Fix::whole(axis.target.into()) - axis.name();
            if axis.mode == Mode::Trap && displacement != Fix::ZERO && displacement.abs() < ROUNDING_PULSES {
                self.open = Some("an Update without a displacement");
                return DONE;
            }
            check(!axis.blocked() && !axis.obstructed() && !axis.driven)?;
        }
        // What is read at this instant is read at its tick (docs/jobs.md).
        let starts = |call: &Call| matches!(call, Call::Axis { kind: Kind::GetSts, axis } if mask >> axis & 1 == 1);
        self.reads.retain(|(_, call, _)| !starts(call));
        for axis_index in members(mask) {
            let aim = self.axes[axis_index].aim();
            // What begins at this instant has no velocity yet, and is replaced.
            if self.axes[axis_index].runs() && !self.axes[axis_index].began {
                self.then[axis_index] = Some(Then::Update(aim));
            } else {
                self.axes[axis_index].update(now, aim);
            }
        }
        DONE
    }

    /// An axis got another name. In the tick in which a coordinate system takes it, the program
    /// does not know where that stands until it is done: docs/crd.md.
    fn renamed(&mut self, axis_index: usize) {
        if self.axes[axis_index].joined {
            (self.unsettled, self.still_ns) = (self.unsettled.max(1), 0);
        }
    }
}
