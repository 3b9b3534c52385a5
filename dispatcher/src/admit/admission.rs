//! Admission for both lanes: configuration, shadow state, stores and the immediate lane.
//!
//! In: records, the view. Out: staged tick commands; data and points in the stores. Owns: both
//! copies of the shadow state, the configuration, the immediate lane, the trace and the event log.
//! Fails: with a refusal, and then nothing has changed.
use super::context::{Context, DueInstant, Effect};
use super::pvt_table::PvtUpload;
use super::staged::Staged;
use super::{admit, config_item, crd, kind, many, one, power_on, tables};
use crate::board::BoardConstants;
use crate::configuration::Configuration;
use crate::plan::path_queue::PathQueue;
use crate::refuse::{Admitted, Refused};
use crate::report::answer::{Answer, Sent};
use crate::report::event_log::Log;
use crate::report::pending_replies::Awaiting;
use crate::report::replies::Reading;
use crate::report::trace::TraceOut;
use crate::shadow::{ShadowChange, Shadows};
use crate::tick_queue::TickQueue;
use protocol::command::{CommandKind, LoadConfig, Table, WaitStop, class, opcode};
use protocol::reason::Reason;
use protocol::record::{ReplyWriter, RequestRecord};
use ring::{Consumer, Producer};
use servo::laser::CHANNELS;
use servo::path::PathStores;
use servo::segment::pt::SegmentStore;
use servo::tables::TableStores;
use servo::tick::IMMEDIATE_ENTRIES;
use servo::tick_command::{LaneEntry, TickCommand};
use servo::units::CrdMask;
use servo::view::{Sample, View};

/// A [`Context`] from the fields of an [`Admission`], of which only `$staged` is borrowed mutably.
macro_rules! context {
    ($admission:ident, $view:expr, $due:expr, $staged:expr) => {
        Context {
            view: $view,
            shadows: &$admission.admitted,
            configuration: &$admission.configuration,
            board: &$admission.board,
            executed: &$admission.executed,
            due: $due,
            crds: $admission.entries.count(),
            staged: &mut $staged,
            effect: Effect::None,
        }
    };
}

pub(super) use context;

/// See the module text.
pub struct Admission<'a, const AXES: usize> {
    /// Constants of the board.
    pub board: BoardConstants,
    /// What the client chose.
    pub configuration: Configuration,
    /// PT segments.
    pub stores: &'a [SegmentStore; AXES],
    /// FIFOs of coordinate systems.
    pub entries: PathStores<'a>,
    /// The look-aheads that feed them.
    pub queues: &'a mut [[PathQueue; 2]],
    /// When a path that runs needs more entries, controller time in ns; `u64::MAX` if none does.
    pub feed_due: u64,
    /// PVT tables.
    pub tables: TableStores<'a>,
    /// The PVT table that is being sent.
    pub loading: PvtUpload,
    /// The table of a laser channel that is being sent.
    pub laser_loading: tables::TableUpload,
    /// State after everything executed.
    pub executed: Shadows<AXES>,
    /// State after everything admitted.
    pub admitted: Shadows<AXES>,
    /// Tick commands of the command in hand.
    pub staged: Staged,
    /// The immediate lane.
    pub lane: TickQueue<'a, IMMEDIATE_ENTRIES>,
    /// The trace.
    pub trace: TraceOut<AXES>,
    /// Events that no command caused.
    pub log: Log,
}

impl<'a, const AXES: usize> Admission<'a, AXES> {
    /// At power-on.
    pub fn new(
        board: BoardConstants,
        stores: &'a [SegmentStore; AXES],
        paths: (PathStores<'a>, &'a mut [[PathQueue; 2]]),
        tables: TableStores<'a>,
        ring: Producer<'a, LaneEntry, IMMEDIATE_ENTRIES>,
    ) -> Self {
        let mut admission = Admission {
            configuration: Configuration::new(board.profile, 0),
            board,
            stores,
            entries: paths.0,
            queues: paths.1,
            feed_due: u64::MAX,
            tables,
            loading: PvtUpload::new(),
            laser_loading: tables::TableUpload::new(),
            executed: Shadows::new(),
            admitted: Shadows::new(),
            staged: Staged::default(),
            lane: TickQueue::new(ring, 0),
            trace: TraceOut::new(),
            log: Log::default(),
        };
        // The tick does not know families.
        for channel in 0..CHANNELS as u8 {
            for (change, entered) in power_on(admission.configuration.family) {
                let entered = ShadowChange::Laser { channel, change: entered };
                admission.push(TickCommand::Laser { channel, change }, entered);
            }
        }
        admission
    }

    /// Pushes a tick command into the immediate lane; false if it has no room.
    pub fn push(&mut self, command: TickCommand, change: ShadowChange) -> bool {
        self.lane.push(command, change, 0, &mut self.admitted)
    }

    /// Pushes what is staged; the caller has checked that there is room.
    pub fn push_staged(&mut self) {
        for &(command, change) in self.staged.commands() {
            self.lane.push(command, change, 0, &mut self.admitted);
        }
    }

    /// Admits a command on the admitted state; its tick commands are staged.
    pub fn admit(
        &mut self,
        view: &View<AXES>,
        due: DueInstant,
        number: u16,
        body: &[u8],
    ) -> Admitted<(Answer, Effect)> {
        self.staged.clear();
        let mut context = context!(self, view, due, self.staged);
        if number == opcode::CrdStart {
            let request = one(body)?;
            let answer = crd::start(&mut context, self.queues, self.entries, &request)?;
            return Ok((answer, Effect::None));
        }
        if kind(number) == Some(CommandKind::Table(Table::Pvt)) {
            let filled = self.loading.table(&context, self.tables, number, body);
            if let Ok(Some(table)) = filled {
                context.stage_with(TickCommand::Mark, ShadowChange::TableFilled { table });
                self.executed.invalidate(table);
            }
            if let Some(table) = self.loading.emptied() {
                self.executed.invalidate(table);
                self.admitted.invalidate(table);
            }
            return filled.map(|_| (Answer::Done, Effect::None));
        }
        if kind(number) == Some(CommandKind::Table(Table::Laser)) {
            let (answer, filled) = self.laser_loading.chunk(&mut context, self.tables.lasers, number, body)?;
            let effect = context.effect;
            if let Some((channel, table)) = filled {
                self.executed.invalidate_follow_table(channel, table);
            }
            return Ok((answer, effect));
        }
        let answer = admit(&mut context, number, body)?;
        Ok((answer, context.effect))
    }

    /// Answers a Calculate command of `lane` through `sent`, which returns whether it had room.
    pub fn calculate(
        &mut self,
        view: &View<AXES>,
        lane: usize,
        number: u16,
        body: &[u8],
        sent: impl FnOnce(&[f64]) -> bool,
    ) -> Admitted<bool> {
        let context = context!(self, view, DueInstant::UNKNOWN, self.staged);
        self.loading.calculate(&context, self.tables.points, lane, number, body, sent)
    }

    /// Stages one item of a LoadConfig that was admitted; false after the last.
    pub fn stage_config(&mut self, view: &View<AXES>, body: &[u8], item: u16) -> bool {
        self.staged.clear();
        let Ok((request, items)) = many::<LoadConfig>(body, |r| r.count.get()) else { return false };
        let Some(item) = items.get(usize::from(item)) else { return false };
        let mut context = context!(self, view, DueInstant::UNKNOWN, self.staged);
        // It was checked when the command was admitted.
        config_item(&mut context, request.core.get(), item).is_ok()
    }

    /// Applies what a command does besides its tick commands; `seq` is its last entry.
    pub fn apply(&mut self, effect: Effect, seq: u32) {
        match effect {
            Effect::None | Effect::Config | Effect::Took(_) => {}
            Effect::Choose(configuration) => self.configuration = configuration,
            Effect::Trace { every, columns, over_link } => self.trace.announce(every, columns, over_link, seq),
        }
    }

    /// Empties the FIFOs that a dropped program has overwritten. False if the lane has no room for
    /// it now.
    pub fn empty_invalid(&mut self) -> bool {
        while let Some((command, change)) = self.admitted.revalidate() {
            if !self.push(command, change) {
                return false;
            }
        }
        true
    }

    /// Stages a WaitStop; false if it cannot be now. The wait for a coordinate system ends with the
    /// data given so far, so all of it leaves the look-ahead.
    pub fn wait_stop(&mut self, view: &View<AXES>, due: DueInstant, wait: &WaitStop) -> Admitted<bool> {
        self.staged.clear();
        let mut staged = Staged::default();
        let context = context!(self, view, due, staged);
        let axes = context.mask(wait.core.get(), wait.axes.get(), 1)?;
        let crds = context.crds_waited_for(wait.core.get(), wait.crds.get(), 2)?;
        let all = CrdMask(crds.0 | self.admitted.drivers(axes).0);
        // Otherwise nothing that it names runs at its instant, which is yet to come.
        let runs = due.until_ns == 0
            || all.crds().any(|crd| context.crd_may_run(crd))
            || context.each(axes).any(|axis| context.may_run(axis));
        if !all.crds().all(|crd| self.flush_path(view, crd, due.soon)) {
            return Ok(false);
        }
        if runs {
            self.staged.add(TickCommand::WaitStandstill { axes, crds }, ShadowChange::Standstill { axes, crds });
        }
        Ok(true)
    }

    /// Moves samples to the trace, as far as it has room.
    pub fn drain_trace<const N: usize>(&mut self, samples: &mut Consumer<Sample, N>, view: &View<AXES>) {
        self.trace.drain(samples, view, &self.configuration);
    }

    /// The view and the state that replies are built from.
    pub fn reading<'d>(&'d self, view: &'d View<AXES>) -> Reading<'d, AXES> {
        let Admission { executed, configuration, board, log, .. } = self;
        let paths = (self.entries, &*self.queues);
        Reading { view, executed, configuration, board, log, tables: self.tables, paths }
    }

    /// Answers a read of a viewer, on the state of now: nothing changes.
    pub fn answer_viewer(&self, view: &View<AXES>, record: &RequestRecord, out: &mut ReplyWriter) -> Sent {
        let mut staged = Staged::default();
        let mut context = context!(self, view, DueInstant::UNKNOWN, staged);
        let admitted = match class(record.opcode).map(|class| class.kind) {
            Some(CommandKind::Read(_)) => admit(&mut context, record.opcode, record.body),
            _ => Err(Refused::new(Reason::ReadOnly)),
        };
        match admitted {
            Ok(answer) => {
                let item = Awaiting { opcode: record.opcode, tag: record.tag, answer, ..Awaiting::BLANK };
                self.reading(view).answer(&item, core::iter::empty(), out)
            }
            Err(refused) => out.refused(record.opcode, record.tag, &refused.wire),
        }
    }
}
