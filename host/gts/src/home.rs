//! Automatic homing: `GoHome`, `GetHomePrm`, `GetHomeStatus`.
//!
//! In: what `GoHome` was given, reads of the controller. Out: moves in Trap mode, captures, and at
//! the end new names of planned position and encoder. Owns the homing of each axis. The
//! controller's own captures and limits give the exact positions; which leg comes next is decided
//! here, when a call or a wait of the program passes, or by the thread that drives the card. Fails:
//! what the controller refuses ends the homing and is its error, as is an axis that stops for
//! another reason. A program that dies leaves a move that ends by itself, or at its limit.

use crate::boundary::Arg;
use crate::reason;
use client::{Client, Error, Result};
use protocol::command::{
    AxisItem, AxisStatus, ClrSts, ConfigItem, GetCaptureStatus, LoadConfig, PrfTrap, SetCaptureMode, SetEncPos, SetPos,
    SetPrfPos, SetTrapPrm, SetVel, Stop, Update,
};
use protocol::reason::Reason;
use protocol::values::status::{LIMIT_NEGATIVE, LIMIT_POSITIVE, RUNNING, SERVO_ON};
use protocol::values::{FULL_SCALE, given};
use std::collections::HashMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// What a function does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HomeCall {
    /// GoHome.
    Go,
    /// GetHomePrm.
    Prm,
    /// GetHomeStatus.
    Status,
}

/// Between two looks at an axis, of the controller's time: each is some hundred bytes of a link.
const POLL_PERIOD: Duration = Duration::from_millis(2);
/// A search without a limit goes so far, pulses.
const UNLIMITED_SEARCH_PULSES: i64 = 0x3000_0000;
/// Away from the limit, where `escapeStep` is 0.
const ESCAPE_PULSES: i64 = 1000;
/// Captures, as SetCaptureMode counts.
const HOME: i16 = 1;
const INDEX: i16 = 2;

/// Stages, as the vendor's header numbers them.
mod stage {
    pub const START: i16 = 1;
    pub const SEARCH_LIMIT: i16 = 10;
    pub const ESCAPE_LIMIT: i16 = 13;
    pub const RETURN_TO_LIMIT: i16 = 15;
    pub const SEARCH_HOME: i16 = 20;
    pub const STOP_AFTER_HOME: i16 = 22;
    pub const RETURN_TO_HOME: i16 = 25;
    pub const SEARCH_INDEX: i16 = 30;
    pub const GO_HOME: i16 = 80;
    pub const END: i16 = 100;
}

/// Errors of a homing, numbered in the same way.
mod fault {
    pub const NONE: i16 = 0;
    pub const DISABLED: i16 = 2;
    pub const STOPPED: i16 = 4;
    pub const REFUSED: i16 = 5;
    pub const NO_HOME: i16 = 8;
    pub const NO_INDEX: i16 = 10;
}

/// What GoHome is given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Parameters {
    mode: i16,
    move_dir: i16,
    index_dir: i16,
    edge: i16,
    trigger: i16,
    high: f64,
    low: f64,
    acc: f64,
    dec: f64,
    smooth_ms: i16,
    offset: i64,
    home_distance: i64,
    index_distance: i64,
    escape: i64,
}

/// A part of the way.
#[derive(Debug, Clone, Copy, PartialEq)]
enum HomePhase {
    /// Into the limit of this direction; `slowly`: its end is the origin.
    Limit { direction: i64, slowly: bool },
    /// Away from it.
    Escape { direction: i64 },
    /// Until a capture comes, which is the origin; `slowly`: at the low velocity.
    Capture { kind: i16, direction: i64, distance: i64, slowly: bool },
    /// Back to the origin.
    Return,
    /// To the offset from the origin; the end.
    Offset,
}

/// The homing of an axis.
#[derive(Debug, Clone)]
struct Homing {
    parameters: Parameters,
    legs: Vec<HomePhase>,
    /// The leg that is run, if it was begun.
    at: usize,
    begun: bool,
    /// A Stop was sent after the capture.
    stopping: bool,
    run: bool,
    stage: i16,
    error: i16,
    /// Encoder position of the origin.
    origin: i64,
    target: i64,
    polled: Duration,
}

/// The homings of a card.
#[derive(Debug, Default)]
pub struct Homes {
    axes: Mutex<HashMap<(i16, i16), Homing>>,
    running: AtomicU32,
}

impl Homes {
    fn lock(&self) -> MutexGuard<'_, HashMap<(i16, i16), Homing>> {
        self.axes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether any axis is on its way.
    pub fn run(&self) -> bool {
        self.running.load(Ordering::Relaxed) != 0
    }

    /// A Reset ends those of its core.
    pub fn reset(&self, core: i16) {
        let mut axes = self.lock();
        axes.retain(|(of, _), _| *of != core);
        self.count(&axes);
    }

    fn count(&self, axes: &HashMap<(i16, i16), Homing>) {
        let running = axes.values().filter(|homing| homing.run).count();
        self.running.store(running as u32, Ordering::Relaxed);
    }

    /// Time has passed: takes every homing on. The time between two looks, if one runs.
    pub fn step(&self, client: &Client) -> Option<Duration> {
        if !self.run() {
            return None;
        }
        let now = client.now();
        let mut axes = self.lock();
        for ((core, axis), homing) in axes.iter_mut().filter(|(_, homing)| homing.run) {
            if now.saturating_sub(homing.polled) >= POLL_PERIOD {
                homing.polled = now;
                let mut controller = Controller { client, core: *core, axis: *axis };
                if let Err(code) = homing.step(&mut controller) {
                    (homing.run, homing.error) = (false, code);
                }
            }
        }
        self.count(&axes);
        Some(POLL_PERIOD)
    }

    /// Does a call of the program. `given` are the values that go in.
    pub fn call(
        &self,
        client: &Client,
        what: HomeCall,
        (function, core): (&'static str, i16),
        given: &[(&'static str, Arg)],
    ) -> Result<Vec<f64>> {
        let axis = match given.first() {
            Some((_, Arg::Int(axis))) => *axis,
            _ => 0,
        };
        let most = client.version().axes_per_core;
        if !(1..=i64::from(most)).contains(&axis) {
            return Err(reason::wrong(function, "axis", Reason::OutOfRange, axis as f64, 1.0, most.into()));
        }
        let axis = axis as i16;
        match what {
            HomeCall::Go => {
                let parameters = Parameters::read(function, axis, given)?;
                let homing = Homing::new(parameters, client.now());
                if self.lock().get(&(core, axis)).is_some_and(|homing| homing.run) {
                    return Err(Error::new(
                        1,
                        format!("{function}: axis {axis} is on its way home already; Stop ends that"),
                    ));
                }
                let mut controller = Controller { client, core, axis };
                let status = controller.status()?.status.get();
                if status & SERVO_ON == 0 {
                    return Err(Error::new(
                        1,
                        format!("{function}: the servo of axis {axis} is off; call GT_AxisOn first"),
                    ));
                }
                if status & RUNNING != 0 {
                    return Err(Error::new(1, format!("{function}: axis {axis} moves; homing begins at standstill")));
                }
                let named = |error: Error| Error { reason: format!("{function}: {}", error.reason), ..error };
                controller.prepare(&parameters, &homing.legs).map_err(named)?;
                let mut axes = self.lock();
                axes.insert((core, axis), homing);
                self.count(&axes);
                drop(axes);
                self.step(client);
                Ok(Vec::new())
            }
            HomeCall::Prm => {
                let axes = self.lock();
                Ok(axes.get(&(core, axis)).map_or(Parameters::default(), |homing| homing.parameters).values())
            }
            HomeCall::Status => {
                self.step(client);
                let axes = self.lock();
                let Some(homing) = axes.get(&(core, axis)) else { return Ok(vec![0.0; 6]) };
                let (stage, error) = (homing.stage.into(), homing.error.into());
                Ok(vec![f64::from(homing.run), stage, error, 0.0, homing.origin as f64, homing.target as f64])
            }
        }
    }
}

impl Parameters {
    /// From the members of THomePrm, one by one.
    fn read(function: &'static str, axis: i16, given: &[(&'static str, Arg)]) -> Result<Parameters> {
        let value = |wanted: &str| {
            let found = given.iter().find(|(name, _)| *name == wanted).map(|(_, arg)| *arg);
            match found {
                Some(Arg::Int(whole)) => whole as f64,
                Some(Arg::Real(real)) => real,
                _ => 0.0,
            }
        };
        let within = |name: &'static str, low: f64, high: f64| {
            let got = value(name);
            match (low..=high).contains(&got) {
                true => Ok(got),
                false => Err(reason::wrong(function, name, Reason::OutOfRange, got, low, high)),
            }
        };
        let whole = |name, low: i32, high: i32| within(name, low.into(), high.into()).map(|got| got as i64);
        // Above 0 and within what Trap takes; the controller has the last word.
        let above = |name| within(name, f64::MIN_POSITIVE, FULL_SCALE);
        let mode = value("mode");
        if !MODES.iter().any(|known| f64::from(*known) == mode) {
            let known: Vec<String> = MODES.iter().map(i16::to_string).collect();
            return Err(Error::new(7, format!("{function}: mode is {mode}; modes are {}", known.join(", "))));
        }
        let trigger = value("triggerIndex");
        if ![-1.0, 0.0, f64::from(axis)].contains(&trigger) {
            let text = format!("{function}: triggerIndex is {trigger}; it is the axis itself ({axis}), 0 or -1");
            return Err(Error::new(7, text));
        }
        Ok(Parameters {
            mode: mode as i16,
            move_dir: whole("moveDir", -1, 1)? as i16,
            index_dir: whole("indexDir", -1, 1)? as i16,
            edge: whole("edge", 0, 1)? as i16,
            trigger: trigger as i16,
            high: above("velHigh")?,
            low: above("velLow")?,
            acc: above("acc")?,
            dec: above("dec")?,
            smooth_ms: whole("smoothTime", 0, 50)? as i16,
            offset: whole("homeOffset", -(UNLIMITED_SEARCH_PULSES as i32), UNLIMITED_SEARCH_PULSES as i32)?,
            home_distance: whole("searchHomeDistance", 0, UNLIMITED_SEARCH_PULSES as i32)?,
            index_distance: whole("searchIndexDistance", 0, UNLIMITED_SEARCH_PULSES as i32)?,
            escape: whole("escapeStep", 0, UNLIMITED_SEARCH_PULSES as i32)?,
        })
    }

    /// The members of THomePrm in their order, with what fills the gaps.
    fn values(&self) -> Vec<f64> {
        let shorts = [self.mode, self.move_dir, self.index_dir, self.edge, self.trigger, 0, 0, 0];
        let longs = [self.offset, self.home_distance, self.index_distance, self.escape, 0, 0];
        let head = shorts.iter().map(|short| f64::from(*short)).chain([self.high, self.low, self.acc, self.dec]);
        head.chain([f64::from(self.smooth_ms), 0.0, 0.0, 0.0]).chain(longs.iter().map(|long| *long as f64)).collect()
    }

    /// The way, leg by leg.
    fn phases(&self) -> Vec<HomePhase> {
        let sign = |direction: i16| if direction < 0 { -1 } else { 1 };
        let (forth, index) = (sign(self.move_dir), sign(self.index_dir));
        let far = |distance: i64| if distance == 0 { UNLIMITED_SEARCH_PULSES } else { distance };
        let home =
            |direction| HomePhase::Capture { kind: HOME, direction, distance: far(self.home_distance), slowly: false };
        let index =
            HomePhase::Capture { kind: INDEX, direction: index, distance: far(self.index_distance), slowly: true };
        let limit = HomePhase::Limit { direction: forth, slowly: false };
        let mut legs = match self.mode {
            10 => vec![
                limit,
                HomePhase::Escape { direction: -forth },
                HomePhase::Limit { direction: forth, slowly: true },
            ],
            11 => vec![limit, home(-forth)],
            12 => vec![limit, index],
            13 => vec![limit, home(-forth), HomePhase::Return, index],
            20 => vec![home(forth)],
            22 => vec![home(forth), HomePhase::Return, index],
            _ => vec![index],
        };
        legs.push(HomePhase::Offset);
        legs
    }
}

/// The modes of THomePrm: limit, limit and home, limit and index, limit, home and index; home, home
/// and index; index.
const MODES: [i16; 7] = [10, 11, 12, 13, 20, 22, 30];

impl Homing {
    fn new(parameters: Parameters, now: Duration) -> Homing {
        Homing {
            legs: parameters.phases(),
            parameters,
            at: 0,
            begun: false,
            stopping: false,
            run: true,
            stage: stage::START,
            error: fault::NONE,
            origin: 0,
            target: 0,
            polled: now.saturating_sub(POLL_PERIOD),
        }
    }

    /// Takes it on; an error ends it.
    fn step(&mut self, axis: &mut Controller<'_>) -> std::result::Result<(), i16> {
        let Some(leg) = self.legs.get(self.at).copied() else { return Ok(()) };
        let item = axis.status().map_err(|_| fault::REFUSED)?;
        if item.status.get() & SERVO_ON == 0 {
            return Err(fault::DISABLED);
        }
        let done = if self.begun { self.go_on(leg, axis, &item) } else { self.begin(leg, axis, &item) }?;
        if done {
            (self.at, self.begun, self.stopping) = (self.at + 1, false, false);
            if self.at == self.legs.len() {
                (self.run, self.stage) = (false, stage::END);
            }
        }
        Ok(())
    }

    /// Begins a leg; whether it is done already.
    fn begin(&mut self, leg: HomePhase, axis: &mut Controller<'_>, item: &AxisItem) -> std::result::Result<bool, i16> {
        let here = item.prf_pos.get().round() as i64;
        let Parameters { high, low, .. } = self.parameters;
        self.begun = true;
        let refused = |_| fault::REFUSED;
        match leg {
            HomePhase::Limit { direction, slowly } => {
                self.stage = if slowly { stage::RETURN_TO_LIMIT } else { stage::SEARCH_LIMIT };
                self.target = here + direction * UNLIMITED_SEARCH_PULSES;
                axis.clear().map_err(refused)?;
                // At a limit already, the move is refused.
                match axis.go(self.target, if slowly { low } else { high }) {
                    Err(_) if !slowly => Ok(true),
                    outcome => outcome.map(|()| false).map_err(refused),
                }
            }
            HomePhase::Escape { direction } => {
                self.stage = stage::ESCAPE_LIMIT;
                let step = if self.parameters.escape == 0 { ESCAPE_PULSES } else { self.parameters.escape };
                self.target = here + direction * step;
                axis.go(self.target, high).map(|()| false).map_err(refused)
            }
            HomePhase::Capture { kind, direction, distance, slowly } => {
                self.stage = if kind == HOME { stage::SEARCH_HOME } else { stage::SEARCH_INDEX };
                self.target = here + direction * distance;
                axis.arm(kind).map_err(refused)?;
                axis.go(self.target, if slowly { low } else { high }).map(|()| false).map_err(refused)
            }
            HomePhase::Return | HomePhase::Offset => {
                let end = leg == HomePhase::Offset;
                self.stage = if end { stage::GO_HOME } else { stage::RETURN_TO_HOME };
                self.target = self.origin + if end { self.parameters.offset } else { 0 };
                axis.go(self.target, low).map(|()| false).map_err(refused)
            }
        }
    }

    /// A leg goes on; whether it is done.
    fn go_on(&mut self, leg: HomePhase, axis: &mut Controller<'_>, item: &AxisItem) -> std::result::Result<bool, i16> {
        let status = item.status.get();
        let runs = status & RUNNING != 0;
        let refused = |_| fault::REFUSED;
        let limit = |direction: i64| status & if direction > 0 { LIMIT_POSITIVE } else { LIMIT_NEGATIVE } != 0;
        match leg {
            _ if runs && !matches!(leg, HomePhase::Capture { .. }) => Ok(false),
            HomePhase::Limit { direction, .. } => {
                if !limit(direction) {
                    return Err(fault::STOPPED);
                }
                self.origin = item.prf_pos.get().round() as i64;
                axis.clear().map_err(refused)?;
                Ok(true)
            }
            HomePhase::Capture { kind, .. } => {
                if !self.stopping {
                    match axis.captured().map_err(refused)? {
                        Some(at) => {
                            self.origin = at;
                            self.stopping = true;
                            if kind == HOME {
                                self.stage = stage::STOP_AFTER_HOME;
                            }
                            axis.stop().map_err(refused)?;
                        }
                        None if runs => {}
                        None => return Err(if kind == HOME { fault::NO_HOME } else { fault::NO_INDEX }),
                    }
                    return Ok(false);
                }
                if runs {
                    return Ok(false);
                }
                // It may have braked into a limit, away from which it goes now.
                axis.clear().map_err(refused)?;
                Ok(true)
            }
            HomePhase::Escape { .. } | HomePhase::Return | HomePhase::Offset => {
                if item.prf_pos.get() != self.target as f64 {
                    return Err(fault::STOPPED);
                }
                if leg == HomePhase::Offset {
                    axis.rename(item, self.origin).map_err(refused)?;
                }
                Ok(true)
            }
        }
    }
}

/// An axis of the controller.
struct Controller<'a> {
    client: &'a Client,
    core: i16,
    axis: i16,
}

impl Controller<'_> {
    fn status(&mut self) -> Result<AxisItem> {
        let request = AxisStatus { core: self.core.into(), axis: self.axis.into(), count: 1.into() };
        let (_, items) = self.client.call_items(request, &[])?;
        items
            .first()
            .copied()
            .ok_or_else(|| Error::new(client::error::LINK_PROTOCOL, "AxisStatus: no axis in the reply"))
    }

    /// Trap, with the parameters of the moves; the edge of the home input. A board without an index
    /// refuses the ways that need it.
    fn prepare(&mut self, parameters: &Parameters, legs: &[HomePhase]) -> Result<()> {
        let (core, profile) = (self.core.into(), self.axis.into());
        if legs.iter().any(|leg| matches!(leg, HomePhase::Capture { kind: INDEX, .. })) {
            self.arm(INDEX)?;
        }
        self.client.call(PrfTrap { core, profile })?;
        let Parameters { acc, dec, smooth_ms, edge, .. } = *parameters;
        let smooth_time_ms = smooth_ms.into();
        self.client.call(SetTrapPrm {
            core,
            profile,
            acc: acc.into(),
            dec: dec.into(),
            vel_start: 0.0.into(),
            smooth_time_ms,
        })?;
        let item = ConfigItem {
            axis: self.axis.into(),
            given: given::HOME_SENSE.into(),
            home_sense: u8::from(edge == 0),
            ..zerocopy::FromZeros::new_zeroed()
        };
        self.client.call_items(LoadConfig { core, count: 1.into() }, &[item])?;
        Ok(())
    }

    fn clear(&mut self) -> Result<()> {
        self.client.call(ClrSts { core: self.core.into(), axis: self.axis.into(), count: 1.into() }).map(drop)
    }

    /// Moves to a position.
    fn go(&mut self, to: i64, velocity: f64) -> Result<()> {
        let (core, profile) = (self.core.into(), self.axis.into());
        let pos = i32::try_from(to.clamp(i32::MIN.into(), i32::MAX.into())).unwrap_or(0);
        self.client.call(SetPos { core, profile, pos: pos.into() })?;
        self.client.call(SetVel { core, profile, vel: velocity.into() })?;
        let mask = 1i32.wrapping_shl(self.axis as u32 - 1);
        self.client.call(Update { core, mask: mask.into() }).map(drop)
    }

    fn arm(&mut self, kind: i16) -> Result<()> {
        let (core, encoder) = (self.core.into(), self.axis.into());
        self.client.call(SetCaptureMode { core, encoder, mode: kind.into() }).map(drop)
    }

    /// Where the capture came, if it has.
    fn captured(&mut self) -> Result<Option<i64>> {
        let request = GetCaptureStatus { core: self.core.into(), encoder: self.axis.into(), count: 1.into() };
        let (_, items) = self.client.call_items(request, &[])?;
        Ok(items.first().filter(|item| item.status.get() != 0).map(|item| item.value.get().into()))
    }

    fn stop(&mut self) -> Result<()> {
        // The form whose bits are axes alone.
        let mask = 1i32.wrapping_shl(self.axis as u32 - 1);
        self.client.call(Stop { core: self.core.into(), mask: mask.into(), option: 0.into(), form: 0 }).map(drop)
    }

    /// At standstill: the origin is 0 from now on, of the planned position and of the encoder.
    fn rename(&mut self, item: &AxisItem, origin: i64) -> Result<()> {
        let short = |pulses: f64| (pulses - origin as f64).round() as i32;
        let (core, axis) = (self.core.into(), self.axis.into());
        self.client.call(SetPrfPos { core, profile: axis, pos: short(item.prf_pos.get()).into() })?;
        let enc_pos = self.status()?.enc_pos.get();
        self.client.call(SetEncPos { core, encoder: axis, pos: short(enc_pos).into() }).map(drop)
    }
}
