//! Waits of a job that last: what waits, for what, since when, and what ends it.
//!
//! In: the position of the program, reads of the controller. Out: a warning at the wait's line once
//! it has lasted a second, or an error when nothing can end it any more. That is so when an axis in
//! FollowEx waits for an input without a time limit, and no client is left that could set it. It
//! owns no file and sends only reads.
use crate::entries::From;
use crate::ledger::Ledger;
use crate::monitor::Live;
use crate::report::Report;
use crate::source::Source;
use client::inputs::{Inputs, name};
use client::{Answer, Client, Error, Observer, Progress};
use job::{Action, Severity, Step};
use protocol::command::{
    AxisItem, AxisStatus, CommandKind, CrdStatus, DataStore, GetVel, GetWait, VersionReply, WaitReply, class,
};
use protocol::values::status::RUNNING;
use protocol::values::{mode, wait};
use std::time::{Duration, Instant};

/// A wait is named after this time.
const NAMED_AFTER: Duration = Duration::from_secs(1);
/// On a board the controller is asked again after this time at the latest; in virtual time after as
/// long again.
const LONGEST_POLL_PERIOD: Duration = Duration::from_secs(10);
/// Code of the error that ends a job whose wait nothing ends; not one of SPEC 3.
pub const ENDLESS: i16 = i16::MIN + 1;
/// Axes of an AxisStatus.
const AXES: i16 = 16;

/// What can set the controller's inputs.
#[derive(Debug, Clone, Copy)]
pub struct Knowledge<'a> {
    /// Only the job and the file of inputs: the controller has no wires.
    pub all_known: bool,
    /// Its time is not the wall clock's.
    pub virtual_time: bool,
    /// The file.
    pub inputs: Option<&'a Inputs>,
}

/// A wait that has been looked at.
struct PolledWait {
    /// Entries that were answered then.
    answered: u32,
    /// The script clock then.
    clock_ns: u64,
    wall: Instant,
    /// How long the wait lasts when the controller is asked next.
    due: Duration,
    /// What has been said of it.
    said: Vec<String>,
}

/// The little-endian `i16` at `at`.
fn i16_at(bytes: &[u8], at: usize) -> Option<i16> {
    bytes.get(at..at + 2)?.try_into().ok().map(i16::from_le_bytes)
}

/// Watches the program of a job, and reports.
pub struct Watch<'r, 'a, 's> {
    report: &'r mut Report<'a, 's>,
    source: &'a Source,
    ledger: &'a Ledger<'s>,
    client: &'a Client,
    knowledge: Knowledge<'a>,
    polled: Option<PolledWait>,
    /// What is shown of the machine meanwhile.
    live: Option<Live<'a>>,
    /// Answered entries at the progress before.
    before: u32,
}

/// An axis that is waited for.
struct Axis {
    core: i16,
    axis: i16,
    item: AxisItem,
    wait: WaitReply,
}

impl Axis {
    fn is_running(&self) -> bool {
        self.item.status.get() & RUNNING != 0
    }

    /// It is at standstill until an input has a level, however long that takes.
    fn is_held(&self) -> bool {
        self.is_running() && self.wait.kind == wait::INPUT && self.wait.limited == 0
    }

    /// It may switch outputs by entries of its own, some time.
    fn may_act(&self) -> bool {
        self.is_running() && self.item.mode.get() == mode::FOLLOW_EX && !self.is_held()
    }

    fn name(&self) -> String {
        if self.core == 1 { format!("axis {}", self.axis) } else { format!("axis {} of core {}", self.axis, self.core) }
    }

    /// What it does that does not end by itself.
    fn says(&self, client: &Client) -> client::Result<Option<String>> {
        let axis = self.name();
        Ok(match self.wait.kind {
            _ if !self.is_running() => None,
            wait::INPUT => {
                let WaitReply { di_type, index, level, limited, .. } = self.wait;
                let input = name(self.core, di_type.get(), index.get());
                let level = if level.get() == 0 { "0 (low)" } else { "1 (high)" };
                let limit = if limited == 0 { ", without a time limit" } else { ", or its time is over" };
                Some(format!("{axis} waits until {input} is {level}{limit} (FollowDiBitEx)"))
            }
            wait::PASS => Some(format!("{axis} waits until its master passes the position of its PASS event")),
            _ if self.item.mode.get() == mode::JOG => {
                let vel = client.call(GetVel { core: self.core.into(), profile: self.axis.into() })?.value.get();
                Some(format!("{axis} runs in Jog mode at {vel} pulse/ms, which a Stop, a limit or a fault ends"))
            }
            _ => None,
        })
    }
}

impl<'r, 'a, 's> Watch<'r, 'a, 's> {
    /// Of a job's entries.
    pub fn new(
        report: &'r mut Report<'a, 's>,
        source: &'a Source,
        ledger: &'a Ledger<'s>,
        client: &'a Client,
        knowledge: Knowledge<'a>,
    ) -> Self {
        Watch { report, source, ledger, client, knowledge, polled: None, live: None, before: u32::MAX }
    }

    /// Shows the machine as well.
    pub fn with(self, live: Option<Live<'a>>) -> Self {
        Watch { live, ..self }
    }

    /// What it reports to.
    pub fn report(self) -> &'r mut Report<'a, 's> {
        self.report
    }

    /// The wait that the program may be in: its step, and core, axes and coordinate systems.
    fn waits(&self, answered: u32) -> Option<(Step, Vec<(i16, u32)>)> {
        let From::Step(_) = self.ledger.from(answered)? else { return None };
        let step = self.ledger.with_step(answered, u16::MAX, Step::clone)?;
        let version = self.client.version();
        let cores = 1..=i16::from(version.cores);
        let masks = match &step.action {
            Action::WaitStop { core, axes, .. } => vec![(*core, *axes)],
            Action::WaitAll => cores.map(|core| (core, u32::MAX)).collect(),
            // Data that finds no room waits for its motion. Core and axis come first.
            Action::Call(call)
                if class(call.opcode).is_some_and(|of| of.kind == CommandKind::Data(DataStore::Follow)) =>
            {
                let (core, axis) = (i16_at(&call.body, 0)?, i16_at(&call.body, 2)?);
                vec![(core, 1u32.checked_shl(u32::try_from(axis - 1).ok()?)?)]
            }
            Action::Call(_) => return None,
            Action::Sleep { .. } => return None,
        };
        Some((step, masks))
    }

    fn axes(&self) -> client::Result<Vec<Axis>> {
        let VersionReply { cores, axes_per_core, .. } = *self.client.version();
        let mut axes = Vec::new();
        for core in 1..=i16::from(cores) {
            for first in (1..=i16::from(axes_per_core)).step_by(AXES as usize) {
                let count = AXES.min(i16::from(axes_per_core) - first + 1);
                let read = AxisStatus { core: core.into(), axis: first.into(), count: count.into() };
                for (axis, item) in (first..).zip(self.client.call_items(read, &[])?.1) {
                    let follows =
                        matches!(item.mode.get(), mode::FOLLOW | mode::FOLLOW_EX) && item.status.get() & RUNNING != 0;
                    let wait = match follows {
                        false => WaitReply::default(),
                        true => self.client.call(GetWait { core: core.into(), axis: axis.into() })?,
                    };
                    axes.push(Axis { core, axis, item, wait });
                }
            }
        }
        Ok(axes)
    }

    /// Whether a coordinate system runs, whose entries may switch outputs.
    fn paths_run(&self) -> client::Result<bool> {
        let VersionReply { cores, crds_per_core, .. } = *self.client.version();
        for core in 1..=i16::from(cores) {
            for crd in 1..=i16::from(crds_per_core) {
                let fifo = 0.into();
                // One that the board has no memory for does not run.
                let state = self.client.call(CrdStatus { core: core.into(), crd: crd.into(), fifo });
                match state {
                    Ok(state) if state.run.get() != 0 => return Ok(true),
                    Err(error) if error.refusal.is_none() => return Err(error),
                    _ => {}
                }
            }
        }
        Ok(false)
    }

    fn poll(&mut self, progress: &Progress) -> client::Result<()> {
        let answered = progress.answered;
        if self.before != answered {
            (self.before, self.polled) = (answered, None);
            return Ok(());
        }
        let Some((step, masks)) = self.waits(answered) else { return Ok(()) };
        let clock_ns = progress.queue.clock_ns.get();
        // Sleeps are answered when they begin.
        let Some(before) = self.ledger.before(answered) else { return Ok(()) };
        let slept = before.slept_ns;
        let Some(looked) = self.polled.as_mut().filter(|looked| looked.answered == answered) else {
            self.polled =
                Some(PolledWait { answered, clock_ns, wall: Instant::now(), due: NAMED_AFTER, said: Vec::new() });
            return Ok(());
        };
        let (begun_ns, wall) = (looked.clock_ns, looked.wall.elapsed());
        let lasts = Duration::from_nanos(clock_ns.saturating_sub(begun_ns).saturating_sub(slept));
        if lasts < looked.due {
            return Ok(());
        }
        // Long waits are ordinary: they cost few looks.
        looked.due = lasts + if self.knowledge.virtual_time { lasts } else { lasts.min(LONGEST_POLL_PERIOD) };
        let axes = self.axes()?;
        let named = |axis: &&Axis| {
            let bit = 1u32.checked_shl(axis.axis as u32 - 1).unwrap_or(0);
            masks.iter().any(|(core, mask)| *core == axis.core && mask & bit != 0)
        };
        let mut says = Vec::new();
        for axis in axes.iter().filter(named) {
            says.extend(axis.says(self.client)?);
        }
        if says.is_empty() {
            return Ok(());
        }
        let rows = self.knowledge.inputs.map_or(&[][..], Inputs::rows);
        let over = rows.last().is_none_or(|row| row.at_ns < clock_ns);
        let held = axes.iter().any(|axis| named(&axis) && axis.is_held());
        let ends = self.knowledge.all_known && held && over && !axes.iter().any(Axis::may_act) && !self.paths_run()?;
        let since = match before.waited {
            false => format!("{:.3}", before.sleeps_ns as f64 / 1e6),
            true => format!("about {:.0}", begun_ns.saturating_add(slept) as f64 / 1e6),
        };
        let what = format!("waits since {since} ms of the script clock: {}", says.join("; "));
        if ends {
            let left = match self.knowledge.inputs {
                None => "no file of inputs is given (--inputs)".to_owned(),
                Some(inputs) => match rows.last() {
                    Some(row) => format!("the last row of {} was at {} ms", inputs.name(), row.at_ns as f64 / 1e6),
                    None => format!("{} has no rows", inputs.name()),
                },
            };
            let help = "a row of --inputs, a GT_SimInput before the wait, or a time limit of GT_FollowDiBitEx ends it";
            let text = format!("this {what}; nothing will end that: {left}");
            return Err(Error::new(ENDLESS, self.source.show(&step, Severity::Error, text, help)));
        }
        let due = if self.knowledge.virtual_time { wall >= NAMED_AFTER } else { true };
        if let Some(looked) = self.polled.as_mut().filter(|looked| due && looked.said != says) {
            looked.said = says;
            let text = self.source.show(&step, Severity::Warning, format!("this {what}"), "");
            self.report.aside(|| complain!("{}", text.trim_end()));
        }
        Ok(())
    }
}

impl Observer for Watch<'_, '_, '_> {
    fn answered(&mut self, answer: Answer) -> client::Result<()> {
        let (index, failed) = (answer.index, answer.code != 0);
        self.report.answered(answer)?;
        self.ledger.answered(index, failed && !self.ledger.may_fail(index));
        Ok(())
    }

    fn polled(&mut self) -> client::Result<()> {
        self.report.polled()
    }

    fn progress(&mut self, progress: &Progress) -> client::Result<()> {
        if let Some(live) = &mut self.live {
            live.follow(self.client, self.report, progress)?;
        }
        self.report.progress(progress)?;
        self.poll(progress)
    }
}
