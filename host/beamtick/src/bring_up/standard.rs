//! The loads of SPEC 11 that a board sets up by itself, and what they do to it.
//!
//! In: a link to the board's own image, on a bench. Out: a load that runs. Owns nothing. What
//! begins takes longer than what goes on: so axes begin first, then paths or light, once what that
//! made dark is cleared. Fails: a call that is refused.
use super::loads::{Check, wait};
use super::ticks;
use crate::Failure;
use client::Client;
use protocol::command::{
    AlarmOff, AxisOn, BufLaserFollowRatio, BufLaserOn, ClrLaserFault, ClrSts, CrdClear, CrdStart, LaserOutFrq,
    LaserPrfCmd, LmtsOff, LnXY, PrfPvt, PvtPoint, PvtStart, PvtTable, PvtTableSelect, Reset, SetAxisMode, SetCrdPrm,
    SetHSIOOpt, SetLinkLoss, SetPvtLoop, SetStopDec,
};
use std::ops::Range;

/// Axes, all of them enabled.
const AXES: i16 = 8;
/// The axis connector and the channel of each laser.
const LASERS: [(i16, i16); 2] = [(7, 0), (8, 1)];
/// After so much silence all stops.
const LINK_LOSS_MS: i32 = 500;
/// What has begun goes on after this time.
const BEGINS_MS: u32 = 5;

/// A load: its name, the axes that run in PVT, the frequency of both lasers in kHz, and whether two
/// coordinate systems of the axes 1 to 4 run, whose speeds the lasers follow.
pub struct Load {
    /// What it is called.
    pub name: &'static str,
    axes: Range<i16>,
    light_khz: Option<f64>,
    paths: bool,
}

const NO_AXES: Range<i16> = 1..1;
const ALL: Range<i16> = 1..AXES + 1;
/// All streams are busy.
pub const BUSIEST: Load =
    Load { name: "eight axes in PVT, two lasers at 2 MHz", axes: ALL, light_khz: Some(2000.0), paths: false };
/// The longer ones come last: the running median follows them in small steps.
pub const LOADS: [Load; 7] = [
    Load { name: "eight axes at standstill", axes: NO_AXES, light_khz: None, paths: false },
    Load { name: "two lasers at 10 kHz", axes: NO_AXES, light_khz: Some(10.0), paths: false },
    Load { name: "two lasers at 2 MHz", axes: NO_AXES, light_khz: Some(2000.0), paths: false },
    Load { name: "four axes in PVT, two lasers at 2 MHz", axes: 1..5, light_khz: Some(2000.0), paths: false },
    Load { name: "eight axes in PVT", axes: ALL, light_khz: None, paths: false },
    BUSIEST,
    Load {
        name: "two paths, four axes in PVT, two lasers at 2 MHz that follow",
        axes: 5..9,
        light_khz: Some(2000.0),
        paths: true,
    },
];

impl Load {
    /// Whether it has light.
    pub fn is_lit(&self) -> bool {
        self.light_khz.is_some()
    }
}

/// A load begins, from the state after power-on. Returns the overruns before what may go dark by
/// one.
pub fn begin(client: &Client, load: &Load, check: Check<'_>) -> Result<u32, Failure> {
    let core = 1.into();
    client.call(Reset { core })?;
    // A program that is killed, or a cable that is pulled, ends motion in PVT, too. A Reset puts
    // this back.
    client.call(SetLinkLoss { time_ms: LINK_LOSS_MS.into(), stop_all: 1.into() })?;
    for axis in 1..=AXES {
        enable(client, axis)?;
    }
    for (axis, channel) in LASERS {
        let Some(khz) = load.light_khz else { break };
        let channel = channel.into();
        client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() })?;
        client.call(LaserOutFrq { core, frequency: khz.into(), channel })?;
        client.call(LaserPrfCmd { core, power: 33.3.into(), channel })?;
    }
    if !load.axes.is_empty() {
        run_axes(client, load.axes.clone())?;
    }
    if load.paths {
        fill_paths(client, check)?;
    }
    wait(client, BEGINS_MS, check)?;
    let before = ticks::overruns(client)?;
    for (_, channel) in LASERS {
        client.call(ClrLaserFault { core, channel: channel.into() })?;
    }
    if load.paths {
        for crd in [1, 2] {
            client.call(CrdStart { core, mask: crd.into(), option: 0.into() })?;
            wait(client, BEGINS_MS, check)?;
        }
    } else if load.is_lit() {
        for (_, channel) in LASERS {
            match client.call(SetHSIOOpt { core, value: 1.into(), channel: channel.into() }) {
                // A tick that overran keeps it dark.
                Err(error) if ticks::overruns(client)? == before => return Err(error.into()),
                _ => wait(client, BEGINS_MS, check)?,
            }
        }
    }
    Ok(before)
}

fn enable(client: &Client, axis: i16) -> Result<(), Failure> {
    let (core, axis) = (1.into(), axis.into());
    // The ends of jumpers are alarms and limits here.
    client.call(AlarmOff { core, axis })?;
    client.call(LmtsOff { core, axis, limit_type: (-1).into() })?;
    client.call(ClrSts { core, axis, count: 1.into() })?;
    // At the end it is at standstill in 10 ms.
    client.call(SetStopDec { core, profile: axis, smooth: 100.0.into(), abrupt: 100.0.into() })?;
    client.call(AxisOn { core, axis })?;
    Ok(())
}

/// Both coordinate systems get lines of 2 ms, at 400 to 500 pulse/ms, and so of 0.7 s. The duty of
/// each laser changes in every tick.
fn fill_paths(client: &Client, check: Check<'_>) -> Result<(), Failure> {
    const LINES: i32 = 350;
    let (core, fifo) = (1.into(), 0.into());
    for (crd, channel, axes) in [(1i16, 0i16, 0), (2, 1, 2)] {
        let (crd, channel) = (crd.into(), channel.into());
        let mut profile = [0.into(); 8];
        (profile[axes], profile[axes + 1]) = (1.into(), 2.into());
        client.call(SetCrdPrm {
            core,
            crd,
            dimension: 2.into(),
            profile,
            syn_vel_max: 500.0.into(),
            syn_acc_max: 1000.0.into(),
            even_time_ms: 0.into(),
            set_origin_flag: 1.into(),
            origin_pos: [0.into(); 8],
        })?;
        client.call(CrdClear { core, crd, fifo })?;
        let (ratio, min, max) = (0.1.into(), 0.0.into(), 100.0.into());
        client.call(BufLaserFollowRatio { core, crd, ratio, min, max, fifo, channel })?;
        client.call(BufLaserOn { core, crd, fifo, channel })?;
        for line in 1..=LINES {
            check()?;
            let vel_end = if line == LINES { 0.0 } else { 500.0 - 100.0 * f64::from((line + 1) % 2) }.into();
            let (x, y) = ((720 * line).into(), (540 * line).into());
            client.call(LnXY { core, crd, x, y, syn_vel: 500.0.into(), syn_acc: 50.0.into(), vel_end, fifo })?;
        }
    }
    Ok(())
}

/// These axes go to and fro between 0 and 8000 pulses, at 1 MHz at most. All enter a segment at the
/// same time, each 4 ms.
fn run_axes(client: &Client, axes: Range<i16>) -> Result<(), Failure> {
    let (core, table) = (1.into(), 1.into());
    let points: Vec<PvtPoint> = [
        (0.0, 0.0, 0.0),
        (4.0, 2000.0, 1000.0),
        (8.0, 6000.0, 1000.0),
        (12.0, 8000.0, 0.0),
        (16.0, 6000.0, -1000.0),
        (20.0, 2000.0, -1000.0),
        (24.0, 0.0, 0.0),
    ]
    .map(|(time, pos, vel): (f64, f64, f64)| PvtPoint { time: time.into(), pos: pos.into(), vel: vel.into() })
    .to_vec();
    client.call_items(PvtTable { core, table, count: (points.len() as i32).into(), first: 0.into() }, &points)?;
    for axis in axes.clone() {
        let profile = axis.into();
        client.call(PrfPvt { core, profile })?;
        client.call(SetPvtLoop { core, profile, loop_count: 0.into() })?;
        client.call(PvtTableSelect { core, profile, table })?;
    }
    client.call(PvtStart { core, mask: axes.fold(0, |mask, axis| mask | 1 << (axis - 1)).into() })?;
    Ok(())
}
