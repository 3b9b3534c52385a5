//! What a job says while it runs: reads, failures, progress.
//!
//! In: the answers to its entries. Out: lines on the standard output, a progress bar where the
//! error stream is a terminal. It remembers which axes the script left moving, and which lasers on.
use crate::entries::From;
use crate::json::{self, Read};
use crate::ledger::Ledger;
use crate::source::Source;
use crate::{interrupt, printer, profile, reply};
use client::{Answer, Dry, Error, Observer, Progress};
use indicatif::{ProgressBar, ProgressStyle};
use job::api::{self, Function};
use job::{Action, Severity, Step};
use protocol::command::{AxisStatus, LaserStatus, VersionReply};
use protocol::reason::{Reason, Refusal};
use protocol::values::status::RUNNING;

/// Code of the error that ends the waiting when the user interrupts; not one of SPEC 3.
pub const INTERRUPTED: i16 = i16::MIN;

/// See the module text.
pub struct Report<'a, 's> {
    source: &'a Source,
    ledger: &'a Ledger<'s>,
    version: VersionReply,
    quiet: bool,
    bar: ProgressBar,
    /// What the machine does, below the bar.
    block: String,
    /// Axes that still moved when the script ended: core and axis.
    pub left: Vec<(i16, i16)>,
    /// Laser channels that were on in the last tick of the script.
    pub lit: Vec<u8>,
    /// Calls that failed and were allowed to.
    pub warned: u32,
    /// The step of the last one. A table goes in several messages, and each of them fails.
    warned_of: Option<usize>,
    /// The PT streams at the last report, and the shortest time to dry of each since it first
    /// decreased: until then the axis is at standstill and its data only grows.
    pub streams: Vec<(Dry, Option<u32>)>,
}

impl<'a, 's> Report<'a, 's> {
    /// A report on a job's entries.
    pub fn new(source: &'a Source, ledger: &'a Ledger<'s>, version: VersionReply, quiet: bool) -> Self {
        // Drawn only where the error stream is a terminal.
        let bar = ProgressBar::with_draw_target(None, printer::bars());
        if !bar.is_hidden() {
            bar.set_length(ledger.total().into());
        }
        if let Ok(style) = ProgressStyle::with_template("{elapsed:>5} [{bar:30}] {pos}/{len} {msg}") {
            bar.set_style(style);
        }
        let (left, lit, streams) = (Vec::new(), Vec::new(), Vec::new());
        let (block, warned, warned_of) = (String::new(), 0, None);
        Report { source, ledger, version, quiet, bar, block, left, lit, warned, warned_of, streams }
    }

    /// The job's name.
    pub fn job(&self) -> &str {
        &self.source.name
    }

    /// Entries of the job.
    pub fn total(&self) -> u32 {
        self.ledger.total()
    }

    /// Whether the bar is seen.
    pub fn is_visible(&self) -> bool {
        !self.bar.is_hidden()
    }

    /// Shows these lines below the bar.
    pub fn show(&mut self, block: String) {
        self.block = block;
    }

    /// Says something beside the bar.
    pub fn aside(&self, say: impl FnOnce()) {
        self.bar.suspend(say);
    }

    /// Takes the bar away.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }

    /// The message for a refused entry, with the script's line.
    pub fn failure(&self, answer: &Answer, severity: Severity) -> String {
        let item = answer.refusal().map_or(u16::MAX, |refusal| refusal.item.get());
        let reason = answer.error.as_ref().map_or("refused without a reason", |error| error.reason.as_str());
        // The text begins with the protocol's name of the command, which for merged data is not the
        // script's.
        let reason = reason.split_once(": ").map_or(reason, |(_, reason)| reason);
        let step = self.ledger.with_step(answer.index, item, Step::clone);
        let Some(step) = step else {
            return format!("{}: at the end of the script: returned {}: {reason}\n", self.source.name, answer.code);
        };
        // The item is the line's own place in data that travels together.
        let together = matches!(self.ledger.from(answer.index), Some(From::Items(_)));
        let reason =
            reason.strip_suffix(&format!(" (item {})", u32::from(item) + 1)).filter(|_| together).unwrap_or(reason);
        let name = name(&step);
        let reason_of = answer.refusal().and_then(Refusal::reason);
        let beyond = answer.refusal().and_then(|refusal| profile::help(&self.version, answer.opcode, refusal));
        let help = match answer.code {
            _ if severity == Severity::Warning => "the job continues after it (#pragma continue)",
            _ if beyond.is_some() => beyond.as_deref().unwrap_or_default(),
            // What the tick refuses is known a tick later.
            1 if ["Start", "Update"].iter().any(|start| bare(name).contains(start)) => {
                "the call is right, but not in the present state; calls of its instant may have acted, later ones did not"
            }
            1 if reason_of == Some(Reason::CrdFull) => {
                "start the path before this line, and go on with its data: a FIFO that runs makes room; later calls were not executed"
            }
            1 => "the call is right, but not in the present state; later calls were not executed",
            7 => "correct the parameter; later calls were not executed",
            8 if answer.refusal().is_none() || reason_of == Some(Reason::UnknownCommand) => {
                "this firmware is older than the client; load the one of the same version"
            }
            _ => "",
        };
        self.source.show(&step, severity, format!("{name} returned {}: {reason}", answer.code), help)
    }

    /// Whether an entry is of the script, and not of its end.
    pub fn is_scripted(&self, entry: u32) -> bool {
        self.ledger.with_step(entry, u16::MAX, |_| ()).is_some()
    }

    /// The call of an entry and its line, as a sentence has them.
    pub fn location(&self, entry: u32) -> String {
        let place = self.ledger.with_step(entry, u16::MAX, |step| format!("{} (line {})", name(step), step.line));
        place.unwrap_or_else(|| "the end of the script".to_owned())
    }

    /// What a laser call did not take as it was given is shown at its line.
    fn report_limited(&self, answer: &Answer) {
        let texts = reply::limited(answer.opcode, &answer.reply);
        if texts.is_empty() {
            return;
        }
        let Some(step) = self.ledger.with_step(answer.index, u16::MAX, Step::clone) else { return };
        let name = if let Action::Call(call) = &step.action { &*call.function } else { "" };
        let text = self.source.show(&step, Severity::Warning, format!("{name}: {}", texts.join(", ")), "");
        self.bar.suspend(|| complain!("{}", text.trim_end()));
    }

    fn read(&self, answer: &Answer) {
        let reads = |step: &Step| matches!(&step.action, Action::Call(call) if !call.outs.is_empty());
        let step = self.ledger.with_step(answer.index, u16::MAX, |step| reads(step).then(|| step.clone())).flatten();
        let Some(step) = step.filter(|_| !self.quiet) else { return };
        let Action::Call(call) = &step.action else { return };
        let reports_stop = api::function(bare(&call.function)).is_some_and(Function::reports_stop);
        let stop = reply::stop(answer.opcode, &answer.reply).filter(|_| reports_stop);
        let names: Vec<String> = call.outs.iter().map(|out| job::tidy(&format!("`{}`", out.variable))).collect();
        let names: Vec<&str> = names.iter().map(|name| name.trim_matches('`')).collect();
        let values = stop.unwrap_or_else(|| reply::reply(answer.opcode, &call.body, &answer.reply));
        let text = format!("{}:{}: {} {} = {values}", self.source.name, step.line, call.function, names.join(", "));
        let found = json::read(Read {
            file: self.source.name.clone(),
            line: step.line,
            call: call.function.to_string(),
            variables: names.into_iter().map(str::to_owned).collect(),
            values,
        });
        if !found {
            self.bar.suspend(|| say!("{text}"));
        }
    }
}

/// A function's name without its prefix.
fn bare(name: &str) -> &str {
    name.strip_prefix("GTN_").or(name.strip_prefix("GT_")).unwrap_or(name)
}

/// What the script calls a step.
fn name(step: &Step) -> &str {
    match &step.action {
        Action::Call(call) => &call.function,
        Action::Sleep { .. } => "Sleep",
        Action::WaitStop { .. } | Action::WaitAll => "WaitStop",
    }
}

/// Ends the waiting for the program once a signal has come.
fn attentive() -> client::Result<()> {
    interrupt::came().map_or(Ok(()), |signal| Err(Error::new(INTERRUPTED, signal.name())))
}

impl Observer for Report<'_, '_> {
    fn answered(&mut self, answer: Answer) -> client::Result<()> {
        attentive()?;
        if answer.code != 0 {
            let reason = answer.refusal().and_then(Refusal::reason);
            let discarded = matches!(reason, Some(Reason::Discarded | Reason::LinkLost));
            let step = match self.ledger.from(answer.index) {
                Some(From::Step(step)) => Some(step),
                _ => None,
            };
            let is_known = step.is_some() && step == self.warned_of;
            if !discarded && !is_known && self.ledger.may_fail(answer.index) {
                (self.warned, self.warned_of) = (self.warned + 1, step);
                let warning = self.failure(&answer, Severity::Warning);
                self.bar.suspend(|| complain!("{}", warning.trim_end()));
            }
            return Ok(());
        }
        match self.ledger.from(answer.index) {
            Some(From::Left { core, axis }) => {
                let status =
                    answer.reply::<AxisStatus>().and_then(|(_, items)| items.first().map(|item| item.status.get()));
                if status.is_some_and(|status| status & RUNNING != 0) {
                    self.left.push((core, axis));
                }
            }
            Some(From::Light { channel })
                if answer.reply::<LaserStatus>().is_some_and(|(state, _)| state.light != 0 || state.commanded != 0) =>
            {
                self.lit.push(channel);
            }
            Some(From::Step(_)) => {
                self.read(&answer);
                self.report_limited(&answer);
            }
            _ => {}
        }
        Ok(())
    }

    fn polled(&mut self) -> client::Result<()> {
        attentive()
    }

    fn progress(&mut self, progress: &Progress) -> client::Result<()> {
        let mut message = format!("script clock {:.3} s", progress.clock().as_secs_f64());
        for dry in &progress.streams {
            match self.streams.iter_mut().find(|(known, _)| (known.core, known.axis) == (dry.core, dry.axis)) {
                Some((known, least)) => {
                    if least.is_some() || dry.dry_ms < known.dry_ms {
                        *least = Some(least.map_or(dry.dry_ms, |least| least.min(dry.dry_ms)));
                    }
                    *known = *dry;
                }
                None => self.streams.push((*dry, None)),
            }
        }
        if let Some(first) = progress.streams.iter().min_by_key(|dry| dry.dry_ms) {
            message.push_str(&format!(
                ", PT data of {} axes: axis {} is dry first, in {} ms, {} slots free",
                progress.streams.len(),
                first.axis,
                first.dry_ms,
                first.space
            ));
        }
        if !self.block.is_empty() {
            message.push('\n');
            message.push_str(&self.block);
        }
        self.bar.set_position(progress.queue.executed.get().min(progress.entries).into());
        self.bar.set_message(message);
        Ok(())
    }
}
