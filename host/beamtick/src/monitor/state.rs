//! What a controller does now: the facts of the block and of `--json`.
//!
//! In: a client, the axes in mm. Out: a [`State`], all reads of which travel together. Owns nothing
//! and changes nothing. Fails: with the link's error; a read that is refused is left out.
use client::{Call, Client, Error, decode};
use protocol::command::{
    AxisItem, AxisStatus, CrdInfo, CrdState, GetClock, GetPtState, LaserState, LaserStatus, ProgramReply,
    ProgramStatus, VersionReply,
};
use protocol::reason::{laser_cause, stop_reason};
use protocol::record::JobState;
use protocol::values::{CRD_FIFO_ENTRIES, mode, path_stop, program, status};
use serde::Serialize;
use trace::Millimetres;

/// Axes of an AxisStatus.
const AXES: i16 = 16;
/// In [`JobState`]: nobody knows.
pub const UNKNOWN_MS: u32 = u32::MAX;

/// See the module text.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct State {
    /// The board's name.
    pub board: String,
    /// The link.
    pub link: String,
    /// Time since power-on, s.
    pub clock_s: f64,
    /// Axes of the machine file; without one those that are on, moved, or have a fault.
    pub axes: Vec<AxisNow>,
    /// Coordinate systems that drive axes.
    pub paths: Vec<PathNow>,
    /// Every channel.
    pub lasers: Vec<LaserNow>,
    /// The program queue.
    pub program: ProgramNow,
    /// The job, where the program that shares its link says so.
    pub job: Option<JobNow>,
    /// What is wrong, with its reason.
    pub faults: Vec<String>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AxisNow {
    /// Its letter, or `axis 1`.
    pub name: String,
    /// Position.
    pub position_pulse: f64,
    /// The same in mm, with a machine file.
    pub position_mm: Option<f64>,
    /// Velocity.
    pub velocity_pulse_ms: f64,
    /// The same.
    pub velocity_mm_min: Option<f64>,
    /// Its servo is on.
    pub on: bool,
    /// It moves.
    pub moves: bool,
    /// Its PT stream, while that runs.
    pub stream: Option<StreamNow>,
}

/// A stream of an axis in PT.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StreamNow {
    /// Free slots.
    pub space: u16,
    /// Its data lasts so long, ms.
    pub dry_ms: u32,
}

/// A coordinate system.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PathNow {
    /// Its core, from 1.
    pub core: u8,
    /// Its number, from 1.
    pub number: u8,
    /// It runs.
    pub runs: bool,
    /// Speed along it.
    pub speed_pulse_ms: f64,
    /// The same in mm, if all its axes are.
    pub speed_mm_min: Option<f64>,
    /// Segments of the present FIFO that are done, and that are left.
    pub segments_done: i32,
    /// See there.
    pub segments_left: i32,
    /// Entries that the FIFO holds.
    pub entries: i32,
    /// Entries that fit.
    pub capacity: i32,
    /// Its motions last so long, ms, without override.
    pub dry_ms: u32,
}

/// A laser channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LaserNow {
    /// From 0.
    pub channel: u8,
    /// There is light.
    pub light: bool,
    /// An on command holds.
    pub commanded: bool,
    /// Power that is output, in the unit of the mode.
    pub power: f64,
    /// `%`, `kHz` or `V`.
    pub unit: &'static str,
    /// Carrier or pulse rate.
    pub frequency_khz: f64,
}

/// The program queue.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProgramNow {
    /// `empty`, `held`, `running`, `failed` or `stopped`.
    pub state: &'static str,
    /// Entries that were executed.
    pub executed: u32,
    /// Entries that were accepted.
    pub accepted: u32,
    /// Entries that came too late.
    pub late: u32,
    /// The script clock, s.
    pub script_s: f64,
}

/// The job that runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct JobNow {
    /// Its file.
    pub name: String,
    /// Entries or lines that are done.
    pub done: u32,
    /// All of them.
    pub entries: u32,
    /// Time left, s; null where it is not known.
    pub left_s: Option<f64>,
}

impl JobNow {
    /// From what a program says of its job.
    pub fn of((job, name): &(JobState, String)) -> JobNow {
        let left = job.left_ms.get();
        let left_s = (left != UNKNOWN_MS).then(|| f64::from(left) / 1e3);
        JobNow { name: name.clone(), done: job.done.get(), entries: job.entries.get(), left_s }
    }
}

impl ProgramNow {
    fn of(reply: &ProgramReply) -> ProgramNow {
        let state = match reply.state {
            program::EMPTY => "empty",
            program::HELD => "held",
            program::RUNNING => "running",
            program::FAILED => "failed",
            _ => "stopped",
        };
        let script_s = reply.clock_ns.get() as f64 / 1e9;
        let (executed, accepted, late) = (reply.executed.get(), reply.accepted.get(), reply.late.get());
        ProgramNow { state, executed, accepted, late, script_s }
    }
}

/// A call, and what its reply is of.
#[derive(Clone, Copy)]
enum Of {
    Clock,
    Axes { core: u8, first: i16 },
    Laser(u8),
    Path { core: u8, crd: u8 },
    Program,
}

fn calls(version: &VersionReply, with_program: bool) -> Vec<(Of, Call)> {
    let mut calls = vec![(Of::Clock, Call::of(GetClock {}))];
    let axes = i16::from(version.axes_per_core);
    for core in 1..=version.cores {
        let number = i16::from(core).into();
        for first in (1..=axes).step_by(AXES as usize) {
            let count = AXES.min(axes - first + 1).into();
            calls.push((Of::Axes { core, first }, Call::of(AxisStatus { core: number, axis: first.into(), count })));
        }
        for crd in 1..=version.crds_per_core {
            calls.push((Of::Path { core, crd }, Call::of(CrdInfo { core: number, crd: i16::from(crd).into() })));
        }
    }
    for channel in 0..version.lasers {
        let status = LaserStatus { core: 1.into(), channel: i16::from(channel).into() };
        calls.push((Of::Laser(channel), Call::of(status)));
    }
    if with_program {
        calls.push((Of::Program, Call::of(ProgramStatus {})));
    }
    calls
}

/// The unit of a laser's mode (LaserPowerMode).
const fn unit(mode: i16) -> &'static str {
    match mode {
        1 => "kHz",
        2 => "V",
        _ => "%",
    }
}

impl State {
    /// Reads all of it. `program` is what the caller knows of its own program; without it the
    /// controller is asked.
    pub fn read(client: &Client, millimetres: &[Millimetres], program: Option<&ProgramReply>) -> Result<State, Error> {
        let asked = calls(client.version(), program.is_none());
        let sent: Vec<Call> = asked.iter().map(|(_, call)| call.clone()).collect();
        let replies = client.call_all(&sent)?;
        let mut state = State {
            board: client.board(),
            link: client.name().to_owned(),
            clock_s: 0.0,
            axes: Vec::new(),
            paths: Vec::new(),
            lasers: Vec::new(),
            program: ProgramNow::of(program.unwrap_or(&ProgramReply::default())),
            job: client.job().as_ref().map(JobNow::of),
            faults: Vec::new(),
        };
        let mut in_pt = Vec::new();
        for ((of, _), reply) in asked.iter().zip(replies) {
            // A board without memory for a coordinate system refuses to read it.
            let Ok(reply) = reply else { continue };
            match *of {
                Of::Clock => state.clock_s = f64::from(decode::<GetClock>(&reply)?.0.clock_ms.get()) / 1e3,
                Of::Program => state.program = ProgramNow::of(&decode::<ProgramStatus>(&reply)?.0),
                Of::Laser(channel) => state.laser(channel, &decode::<LaserStatus>(&reply)?.0),
                Of::Path { core, crd } => state.path(core, crd, &decode::<CrdInfo>(&reply)?.0),
                Of::Axes { core, first } => {
                    for (axis, item) in (first..).zip(decode::<AxisStatus>(&reply)?.1) {
                        let is_new = state.axis((core, axis as u8), &item, millimetres);
                        let runs = item.mode.get() == mode::PT && item.status.get() & status::RUNNING != 0;
                        if is_new && runs {
                            in_pt.push((state.axes.len() - 1, i16::from(core), axis));
                        }
                    }
                }
            }
        }
        state.streams(client, &in_pt)?;
        state.speeds(millimetres);
        if state.program.state == "failed" || state.program.state == "stopped" {
            let why = if state.program.state == "failed" { "a failure" } else { "a Stop, an Abort or a lost link" };
            state.faults.push(format!("the program was ended by {why}"));
        }
        Ok(state)
    }

    /// Whether it is shown.
    fn axis(&mut self, (core, number): (u8, u8), item: &AxisItem, millimetres: &[Millimetres]) -> bool {
        let bits = item.status.get();
        let found: Vec<&str> = status::faults(bits).collect();
        let name = if core == 1 { format!("axis {number}") } else { format!("axis {number} of core {core}") };
        let mm = millimetres.iter().find(|mm| (mm.axis.core, mm.axis.axis) == (core, number));
        let on = bits & status::SERVO_ON != 0;
        let (position, velocity) = (item.prf_pos.get(), item.prf_vel.get());
        let moves = bits & status::RUNNING != 0;
        if !found.is_empty() && (on || mm.is_some() || moves || item.reason.get() > 1) {
            self.faults.push(format!("{name}: {}; {}", found.join(", "), stop_reason(item.reason.get())));
        }
        let shown = if millimetres.is_empty() { on || moves || position != 0.0 } else { mm.is_some() };
        if shown {
            self.axes.push(AxisNow {
                name: mm.map_or(name, |mm| mm.letter.to_string()),
                position_pulse: position,
                position_mm: mm.map(|mm| mm.zero + position / mm.per_mm),
                velocity_pulse_ms: velocity,
                velocity_mm_min: mm.map(|mm| velocity / mm.per_mm * 60_000.0 + 0.0),
                on,
                moves,
                stream: None,
            });
        }
        shown
    }

    fn laser(&mut self, channel: u8, laser: &LaserState) {
        let cause = laser.fault.get();
        if cause != 0 {
            self.faults.push(format!("laser {channel} is kept dark: {}", laser_cause(cause)));
        }
        let light = laser.light != 0;
        self.lasers.push(LaserNow {
            channel,
            light,
            commanded: laser.commanded != 0,
            power: if light { laser.power.get() } else { 0.0 },
            unit: unit(laser.mode.get()),
            frequency_khz: if light { laser.frequency.get() } else { 0.0 },
        });
    }

    fn path(&mut self, core: u8, number: u8, crd: &CrdState) {
        if { crd.axes }.iter().all(|axis| axis.get() == 0) {
            return;
        }
        if crd.run == 0 && crd.path_stop == path_stop::UNDERRUN {
            self.faults.push(format!("path {number}: {}", stop_reason(crd.reason.get())));
        }
        let fifo = usize::from(crd.fifo & 1);
        self.paths.push(PathNow {
            core,
            number,
            runs: crd.run != 0,
            speed_pulse_ms: crd.vel.get(),
            speed_mm_min: None,
            segments_done: { crd.segments }[fifo].get(),
            segments_left: { crd.remainder }[fifo].get(),
            entries: i32::from(CRD_FIFO_ENTRIES) - { crd.space }[fifo].get(),
            capacity: CRD_FIFO_ENTRIES.into(),
            dry_ms: { crd.lasts_ms }[fifo].get(),
        });
    }

    fn streams(&mut self, client: &Client, axes: &[(usize, i16, i16)]) -> Result<(), Error> {
        let reads: Vec<Call> = axes
            .iter()
            .map(|&(_, core, axis)| Call::of(GetPtState { core: core.into(), profile: axis.into() }))
            .collect();
        if reads.is_empty() {
            return Ok(());
        }
        for (&(place, ..), reply) in axes.iter().zip(client.call_all(&reads)?) {
            // It may have ended meanwhile.
            let Ok(reply) = reply else { continue };
            let pt = decode::<GetPtState>(&reply)?.0;
            self.axes[place].stream = Some(StreamNow { space: pt.space0.get(), dry_ms: pt.dry_ms.get() });
        }
        Ok(())
    }

    /// The speed of a path in mm is that of the machine's axes.
    fn speeds(&mut self, millimetres: &[Millimetres]) {
        if millimetres.is_empty() {
            return;
        }
        let squares = self.axes.iter().filter_map(|axis| axis.velocity_mm_min).map(|speed| speed * speed);
        let speed = squares.sum::<f64>().sqrt();
        for path in &mut self.paths {
            path.speed_mm_min = Some(if path.runs { speed } else { 0.0 });
        }
    }
}
