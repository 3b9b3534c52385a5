//! Calls of laser channels, Stops as they see them, and what their power follows.
use super::super::call::{Call, members};
use super::super::crd::Crd;
use super::super::light::{
    Act, Channel, Command, Distance, Family, INTERLOCK, Law, LightCall, LightOf, Mode, Scaled, Setting, Standby,
    TABLES, crds,
};
use super::answer::{Answer, DONE, check, either, range};
use super::{Controller, Reply, Value};

/// The lowest frequency, kHz.
const FREQUENCY_MIN_KHZ: f64 = 0.001;
/// The longest delay, µs.
const DELAY_MAX_US: f64 = 65535.0;
/// The most of a ratio of the distance follow, and the scales of the two families.
pub(super) const DISTANCE_RATIO_MAX: f64 = 131072.0;
const SCALES: [[f64; 2]; 2] = [[1.0 / 262144.0, 4294967296.0], [1.0, 65536.0]];

/// A value outside its range: GUS refuses it, LSR takes the nearest bound.
pub(super) fn take(family: Family, x: f64, [low, high]: [f64; 2]) -> Result<f64, i16> {
    range(family == Family::Lsr || (low..=high).contains(&x))?;
    Ok(x.clamp(low, high))
}

/// A power: pulses of less than 1 Hz are refused in both families.
pub(super) fn take_power(of: &Channel, x: f64) -> Result<f64, i16> {
    range(of.law.mode != Mode::Frequency || x <= 0.0 || x >= FREQUENCY_MIN_KHZ)?;
    take(of.law.family, x, [0.0, of.law.most()])
}

/// A frequency other than that of pulses of light.
fn take_frequency(law: &Law, khz: f64) -> Result<f64, i16> {
    range(khz >= FREQUENCY_MIN_KHZ)?;
    take(law.family, khz, [FREQUENCY_MIN_KHZ, law.highest()])
}

/// Bounds with min ≤ max, as given and as taken.
pub(super) fn take_bounds(law: &Law, mode: Mode, [min, max]: [f64; 2]) -> Result<[f64; 2], i16> {
    range(min <= max)?;
    let full = [0.0, mode.most(law.highest())];
    Ok([take(law.family, min, full)?, take(law.family, max, full)?])
}

/// Of LaserPowerMode: LSR takes a minimum outside its range as the range's.
fn mode_bounds(law: &Law, mode: Mode, [min, max]: [f64; 2]) -> Result<[f64; 2], i16> {
    range(max >= 0.0)?;
    if law.family == Family::Gus {
        return take_bounds(law, mode, [min, max]);
    }
    let most = mode.most(law.highest());
    let (min, max) = (if (0.0..=most).contains(&min) { min } else { 0.0 }, max.min(most));
    range(min <= max)?;
    Ok([min, max])
}

impl Controller {
    fn path_runs(&self, crds_of: u8) -> bool {
        crds(crds_of.into()).any(|crd| self.crds.get(&(1, crd as i16 + 1)).is_some_and(|of| of.runs))
    }

    /// A call needs these to be at standstill.
    fn contest(&mut self, crds_of: u8) {
        let axes = self.path_axes(1, crds_of.into());
        if members(axes).any(|axis| self.axes[axis].ended) {
            self.open = Some("a call that needs standstill, right after its axis came to rest");
        }
        let named = |act: &Act| matches!(act, Act::Stop(named, _) if named & crds_of != 0);
        let rests = self.path_then.iter().any(|((core, crd), _)| *core == 1 && crds_of >> (crd - 1) & 1 == 1);
        if rests || self.light.calls.iter().any(named) {
            self.open = Some("a call that needs a path at standstill, at the instant of its Stop");
        }
        self.contested[0] |=
            members(axes).filter(|axis| self.axes[*axis].driven).fold(0, |mask, axis| mask | 1 << axis);
    }

    pub(super) fn light(&mut self, index: usize, call: &Call, of: &LightCall, now: i64) -> Answer {
        if let LightOf::EndFollow(mask) = of.what {
            self.light.calls.push(Act::EndFollow(mask as u8));
            return DONE;
        }
        if matches!(of.what, LightOf::Connector(_)) && self.setup.family == Family::Lsr {
            return Err(8);
        }
        if matches!(of.what, LightOf::StandbyBoth { .. } | LightOf::Resolution(_)) {
            return self.both_lasers(of.what);
        }
        range((0..2).contains(&of.channel))?;
        self.is_settled_for_light();
        let number = of.channel as usize;
        let after = self.light.after_calls(number);
        let setting = match of.what {
            LightOf::Gate(on) => return self.switch(number, on, &after),
            LightOf::ClearFault if self.interlock.is_cause() => return Err(self.interlock.refusal()),
            LightOf::ClearFault if self.interlock.is_just_closed() => {
                self.open = Some("a clear of light just after the interlock closes");
                return DONE;
            }
            LightOf::Switch(value) => {
                range(value < 2)?;
                return self.switch(number, value == 1, &after);
            }
            LightOf::EndFollow(_) => return DONE,
            LightOf::GetMap => return Ok(Reply::Done(Value::Whole(after.owner.map.into()))),
            LightOf::GetGate | LightOf::GetSwitched | LightOf::GetPower | LightOf::GetOnTime | LightOf::GetFault => {
                if self.path_runs(3) {
                    return Ok(Reply::Open);
                }
                return Ok(self.read(index, call, 0));
            }
            LightOf::Mode { mode, max, min, delayed } => {
                self.contest(3);
                let kind = Mode::of(mode, self.setup.family);
                let bounds = mode_bounds(&after.law, kind, [min, max]);
                either(!self.path_runs(3), (0..4).contains(&mode) && bounds.is_ok())?;
                if kind == Mode::Analog {
                    // From here on it is the laser's, which leaves it at 0 V.
                    self.analog.push((now as f64 / 1e6, number, 0));
                }
                Setting::Mode(kind, bounds?, delayed || self.setup.family == Family::Gus)
            }
            LightOf::Map(map) => {
                range((0..4).contains(&map))?;
                let both = map as u8 | after.owner.map;
                self.contest(both);
                let stopped = |(name, crd): (&(i16, i16), &Crd)| {
                    name.0 == 1 && both >> (name.1 - 1) & 1 == 1 && crd.stopped && crd.ran
                };
                if (self.unsettled != 0 || self.switched_off_ns > 0) && self.crds.iter().any(stopped) {
                    // Whether its light would come back is known at the instant: docs/laser.md.
                    self.open = Some("a map right after a Stop of its path");
                }
                if self.light.channels[number].owner.is_of_path(both) != after.owner.is_of_path(both) {
                    // That is known a tick later.
                    self.open = Some("a map at the instant at which light of a path is withdrawn");
                }
                if self.axes.iter().any(|axis| axis.is_alarmed() && axis.light_crd().is_some()) {
                    // It is dark from the tick on from which the map holds, or a tick later.
                    self.open = Some("a map of a path that has an alarm");
                }
                check(!self.path_runs(both) && !after.owner.is_of_path(both))?;
                self.axes.iter_mut().for_each(|axis| axis.alarms = None);
                Setting::Map(map as u8)
            }
            what => self.setting_of(what, &after, of.channel)?,
        };
        self.light.calls.push(Act::Set(number, setting));
        *self.used.entry(kind(&setting)).or_default() += 1;
        DONE
    }

    /// A call of a laser comes to a channel that is known.
    pub(super) fn is_settled_for_light(&mut self) {
        if self.light.calls.contains(&Act::Abort) {
            // The tick that shuts everything off comes between.
            self.open = Some("a call of a laser at the instant of an Abort");
        }
        if self.crds.values().any(|crd| crd.fed_here) {
            // Such data is late by a tick at times, and what comes after it too.
            self.open = Some("a call of a laser at the instant of a start of a path and of data after it");
        }
        if self.axes.iter().any(|axis| axis.is_alarmed() && axis.joined) {
            self.open =
                Some("a call of a laser at the instant at which a coordinate system gets an axis with an alarm");
        }
        if self.interlock.open != self.interlock.sampled {
            self.open = Some("a call of a laser in the tick in which the interlock changes");
        }
    }

    pub(super) fn setting_of(&mut self, what: LightOf, after: &Channel, channel: i16) -> Result<Setting, i16> {
        let family = self.setup.family;
        let us = |us: u32, least: f64| take(family, us.into(), [least, DELAY_MAX_US]).map(|us| us / 1000.0);
        Ok(match what {
            LightOf::Connector(on) => {
                // That of axis 8 cannot be given back.
                range(on || channel == 0)?;
                Setting::Connector(on)
            }
            LightOf::Carrier(khz) => {
                take_frequency(&after.law, khz)?;
                Setting::Carrier
            }
            LightOf::Width(us) => {
                let most = if family == Family::Gus { 65535.0 } else { 4000.0 };
                take(family, us.into(), [1.0, most])?;
                Setting::Width
            }
            LightOf::Power(power) => Setting::Power(take_power(after, power)?),
            LightOf::Delays { off, on } => Setting::Delays([us(off, 0.0)?, us(on, 0.0)?]),
            LightOf::Fpk([time1, time2, off]) => Setting::Fpk(Some([us(time1, 1.0)?, us(time2, 0.0)?, us(off, 0.0)?])),
            LightOf::NoFpk => Setting::Fpk(None),
            LightOf::Standby { on, khz, duty } | LightOf::StandbyBoth { on, khz, duty } => {
                let khz = if on || khz != 0.0 { take_frequency(&after.law, khz)? } else { 0.0 };
                let duty = take(family, duty, [0.0, 100.0])?;
                let paired = matches!(what, LightOf::StandbyBoth { .. }) && family == Family::Lsr;
                Setting::Standby(on.then_some(Standby { khz, duty, paired }))
            }
            LightOf::PreVoltage { on, volts } => {
                let volts = take(family, volts, [0.0, 10.0])?;
                Setting::PreVoltage(on.then_some(volts))
            }
            LightOf::Distance(None) => Setting::Distance(None),
            LightOf::Distance(Some((source, from, scale))) => {
                range((0..2).contains(&source))?;
                let scales = SCALES[usize::from(family == Family::Lsr)];
                let mut taken = [0.0; 4];
                for (taken, scale) in taken.iter_mut().zip(scale) {
                    *taken = take(family, scale, scales)?;
                }
                let distance =
                    Distance { encoder: source == 1, from, scale: taken, ratio: Scaled::Same([0.0; 4]), bounds: None };
                Setting::Distance(Some(distance))
            }
            LightOf::Ratios(ratio, bounds) => {
                let good = ratio.iter().all(|ratio| ratio.abs() <= DISTANCE_RATIO_MAX);
                let bounds = match family {
                    Family::Gus => take_bounds(&after.law, after.law.mode, bounds).map(Some),
                    Family::Lsr => Ok(None),
                };
                either(after.law.distance.is_some(), good && bounds.is_ok())?;
                Setting::Ratios(Scaled::Same(ratio), bounds?)
            }
            LightOf::ClearFault => {
                if self.axes.iter().any(|axis| axis.is_alarmed() && axis.light_crd().is_some()) {
                    self.open = Some("a clear of light while an alarm is there");
                }
                Setting::ClearFault
            }
            _ => Setting::ZeroOnTime,
        })
    }

    /// Whether all comes to rest after an Abort in this tick, or has just done so.
    fn is_about_to_rest(&self) -> bool {
        let tick = self.tick_ns as f64 / 1e6;
        let rests = |axis: usize| {
            let axis = &self.axes[axis];
            let path = axis.crd.filter(|_| axis.driven).map(|name| &self.crds[&name]);
            let (speed, dec) = match path {
                Some(path) => (path.speed, path.stop_dec.max(path.set.as_ref().map_or(0.0, |set| set.frame.acc))),
                None => (axis.v.to_f64().abs(), axis.stop_dec),
            };
            speed <= dec * tick + 1e-6
        };
        self.rested > 0 || self.aborted != 0 && members(self.aborted).all(rests)
    }

    fn switch(&mut self, number: usize, on: bool, after: &Channel) -> Answer {
        if on && self.is_about_to_rest() {
            self.open = Some("light at the end of an Abort");
        }
        if on && after.owner.fault == INTERLOCK {
            return Err(self.interlock.refusal());
        }
        check(!on || after.owner.output && after.owner.fault == 0 && self.aborted == 0)?;
        self.light.calls.push(Act::Gate(number, on));
        *self.used.entry("lasers switched by calls").or_default() += 1;
        DONE
    }

    /// The values of an entry as they are taken.
    pub(super) fn laser_entry(&self, of: &Channel, command: Command) -> Result<Command, i16> {
        let family = self.setup.family;
        let bounds = |ratio: f64, [min, max]: [f64; 2]| -> Result<[f64; 2], i16> {
            range(ratio > 0.0 && ratio <= 4294967296.0 && min < max)?;
            let full = [0.0, of.law.most()];
            Ok([take(family, min, full)?, take(family, max, full)?])
        };
        Ok(match command {
            Command::Power(power) => Command::Power(take_power(of, power)?),
            Command::Source { encoder, start: Some(start) } => {
                Command::Source { encoder, start: Some(take_power(of, start)?) }
            }
            Command::Ratio([ratio, min, max]) => {
                let [min, max] = bounds(ratio, [min, max])?;
                Command::Ratio([ratio, min, max])
            }
            Command::Follow(ratio, [min, max]) => {
                let taken = bounds(ratio, [min.into(), max.into()])?;
                Command::Follow(ratio, taken.map(|bound| bound as i32))
            }
            Command::Table(table, of_table) => {
                range((1..=TABLES).contains(&table))?;
                // One without points is a matter of the state.
                let taken = bounds(1.0, of_table);
                either(of.law.tables[table as usize - 1].is_some(), taken.is_ok())?;
                Command::Table(table, taken?)
            }
            _ => command,
        })
    }

    /// A Stop names these coordinate systems of core 1, bit 0 is crd 1.
    pub(super) fn stop_light(&mut self, named: u8) {
        let set =
            crds(named.into()).filter(|crd| self.crds.get(&(1, *crd as i16 + 1)).is_some_and(|of| of.set.is_some()));
        let known = set.fold(0, |mask, crd| mask | 1 << crd);
        if known != 0 {
            self.light.calls.push(Act::Stop(known, 0));
        }
    }

    /// Channels, from the tick before to this one.
    pub(super) fn step_light(&mut self, before: i64, now: i64) {
        let on = |(_, act): &(f64, Act)| matches!(act, Act::Entry(_, _, Command::Gate(true), _));
        if self.is_about_to_rest() && self.light.between.iter().any(on) {
            self.open = Some("light at the end of an Abort");
        }
        self.rested = self.rested.saturating_sub(1);
        self.light.step(before as f64 / 1e6, now as f64 / 1e6);
        self.open = self.open.or(self.light.open);
        let (mut at, mut apart) = ([[0.0; 4]; 2], [0.0; 4]);
        for (axis_index, axis) in self.axes.iter().enumerate() {
            let (core, number) = self.setup.axes[axis_index];
            if core == 1 && (1..=4).contains(&number) {
                at[0][number as usize - 1] = axis.name().to_f64();
                apart[number as usize - 1] = (axis.slack + axis.late + self.rounding(axis)).to_f64();
                at[1][number as usize - 1] = (axis.encoder[1] - axis.encoder_zero).to_f64();
            }
        }
        (self.light.around.at, self.light.around.apart) = (at, apart);
        self.count_speeds(before, now);
    }
}

/// What a setting is counted as.
fn kind(setting: &Setting) -> &'static str {
    match setting {
        Setting::Mode(Mode::Duty, ..) => "duty modes set",
        Setting::Mode(..) => "other power modes set",
        Setting::Delays(_) => "gate delays set",
        Setting::Fpk(_) => "first-pulse killers set",
        Setting::Standby(_) | Setting::PreVoltage(_) => "standby pulses and pre-voltages set",
        Setting::Distance(_) | Setting::Ratios(..) => "distance follows set",
        Setting::Table(..) => "tables of lasers set",
        _ => "other settings of lasers",
    }
}
