//! Shadow state of one coordinate system: its parameters, both FIFOs, the start of the next motion.
use super::path_data::PathData;
use super::{PROGRAM_FLAG, entries_from, executed, is_in_flight, seq_from};
use crate::plan::geometry::{Position, position_of};
use protocol::command::CrdPrm;
use servo::path::{DIMENSIONS, PathStop};
use servo::units::{Axis, AxisMask};
use servo::view::{CrdView, View};

/// Parameters of a coordinate system as SetCrdPrm gave them.
#[derive(Debug, Clone, Copy)]
pub struct CrdParameters {
    /// Coordinates in use, 1 to 4.
    pub dimension: u8,
    /// The coordinate that each axis of the core drives, from 1; 0 none.
    pub profile: [u8; 8],
    /// Index of the core's first axis.
    pub first: u8,
    /// Highest speed, pulse/ms.
    pub vel_max: f64,
    /// Highest acceleration, pulse/ms².
    pub acc_max: f64,
    /// Least time at constant speed, ms.
    pub even_ms: u16,
    /// Whether the origin was given.
    pub set_origin: bool,
    /// The origin, by axis.
    pub origin: [i32; 8],
}

impl CrdParameters {
    /// Axis of each coordinate.
    pub fn axes(&self) -> [Option<Axis>; DIMENSIONS] {
        let mut axes = [None; DIMENSIONS];
        for (number, coordinate) in self.profile.iter().enumerate() {
            if let Some(position) = usize::from(*coordinate).checked_sub(1).and_then(|index| axes.get_mut(index)) {
                *position = Axis::new(usize::from(self.first) + number);
            }
        }
        axes
    }
    /// The same as a set.
    pub fn mask(&self) -> AxisMask {
        AxisMask(self.axes().iter().flatten().fold(0, |mask, axis| mask | axis.mask().0))
    }
    /// As GetCrdPrm reports it.
    pub fn wire(&self) -> CrdPrm {
        CrdPrm {
            dimension: i16::from(self.dimension).into(),
            profile: self.profile.map(|coordinate| i16::from(coordinate).into()),
            syn_vel_max: self.vel_max.into(),
            syn_acc_max: self.acc_max.into(),
            even_time_ms: (self.even_ms as i16).into(),
            set_origin_flag: i16::from(self.set_origin).into(),
            origin_pos: self.origin.map(Into::into),
        }
    }
}

/// Look-ahead of a FIFO.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookAheadSettings {
    /// Corner time, ms.
    pub corner: f64,
    /// Acceleration of every coordinate that has no limit of its own, pulse/ms².
    pub acc: f64,
    /// Motions that wait at most.
    pub count: u16,
}

/// One FIFO.
#[derive(Debug, Clone, Copy, Default)]
pub struct PathShadow {
    /// What it was given.
    pub data: PathData,
    /// Times it was cleared, as a view shows it once this data is in the tick.
    pub cleared: u32,
    /// Its look-ahead.
    pub look: Option<LookAheadSettings>,
    /// The last entry that emptied it, until it is executed.
    pub emptied: Option<u32>,
    /// The last entry that concerns it.
    pub last: Option<u32>,
    /// It was given data that no entry has published yet.
    pub loose: bool,
    /// Its slots were overwritten by data that was dropped.
    pub invalid: bool,
    /// After a Stop, or with data that came after its start, its path was renamed or ran with the
    /// other FIFO. Where its next motion begins depends on which of its motions were over then.
    pub left: bool,
    /// The entry that renamed its path, or started it with the other FIFO, while it held data; none
    /// once it has run after that.
    passed: Option<u32>,
    /// Entries from the last start before it was emptied to that: 0 is none,
    /// [`START_DISTANCE_MAX_ENTRIES`] many, or they are of two lanes.
    start_distance: u8,
}

/// See [`PathShadow`].
const START_DISTANCE_MAX_ENTRIES: u8 = u8::MAX;

impl PathShadow {
    /// An emptied FIFO, by entry `seq`, after the last start.
    fn emptied(cleared: u32, busy: Option<u32>, seq: u32) -> PathShadow {
        let entries = |start| (start & PROGRAM_FLAG == seq & PROGRAM_FLAG).then(|| entries_from(start, seq));
        let far =
            |start| entries(start).and_then(|entries| u8::try_from(entries).ok()).unwrap_or(START_DISTANCE_MAX_ENTRIES);
        PathShadow {
            cleared,
            emptied: Some(seq),
            start_distance: busy.map_or(0, far),
            last: Some(seq),
            ..Self::default()
        }
    }
    /// Whether the tick may still read what was in its slots before it was emptied: it runs, or a
    /// start that precedes the emptying is in flight.
    pub fn is_outgoing<const AXES: usize>(&self, view: &View<AXES>, sampled: &CrdView) -> bool {
        let start = |emptied| seq_from(emptied, 0u32.wrapping_sub(self.start_distance.into()));
        let in_flight = |emptied| match self.start_distance {
            0 => false,
            START_DISTANCE_MAX_ENTRIES => true,
            _ => !executed(view, start(emptied)),
        };
        self.emptied.is_some_and(|seq| !executed(view, seq) && (sampled.runs || in_flight(seq)))
    }
    /// Whether all that concerns it is executed.
    fn is_executed<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        !self.loose && self.last.is_none_or(|seq| executed(view, seq))
    }
    /// So many of its motions were over when its path came to standstill.
    fn note_standstill(&mut self, over: u32) {
        if !self.data.is_open() {
            self.left = false;
            return;
        }
        let (ages, sure) = self.data.ages.ahead(self.data.motions.wrapping_sub(over));
        self.data.ages = ages;
        if self.left {
            self.data.forget_position();
        }
        self.left &= !sure;
    }
}

/// One coordinate system.
#[derive(Debug, Clone, Copy, Default)]
pub struct CrdShadow {
    /// Its parameters.
    pub frame: Option<CrdParameters>,
    /// Limits of each coordinate for look-ahead: pulse/ms, pulse/ms²; 0 is none of its own.
    pub limits: [(f64, f64); DIMENSIONS],
    /// FIFO of the last start.
    pub fifo: u8,
    /// The last start, until a view shows it at standstill or a wait for it is admitted.
    pub started: Option<u32>,
    /// The last start, until the tick is done with it.
    pub busy: Option<u32>,
    /// The last Stop that it got since; 0 is none.
    pub stop: u32,
    /// The FIFO of that start got data since. The path may have ended before it.
    pub fed: bool,
    /// That start has not been executed, and what follows it acts also where the tick refuses it.
    pub may_fail: bool,
    /// Its position, if that is known ahead of the tick.
    pub here: Option<Position>,
    /// The last entry that concerns it.
    pub last: Option<u32>,
    /// Stop decelerations as given, pulse/ms².
    pub dec: (f64, f64),
    /// Axes beside its own that its entries may move, also those of data that was cleared since it
    /// ran.
    pub extra_axes: AxisMask,
    /// Override.
    pub rate: f64,
    /// Time constant of the filter of its encoders' speed, ms.
    pub lag_ms: f64,
    /// The FIFOs.
    pub fifos: [PathShadow; 2],
}

impl CrdShadow {
    /// At power-on (SPEC 5); its default is all zero.
    pub fn power_on() -> Self {
        CrdShadow { rate: 1.0, lag_ms: 1.0, ..CrdShadow::default() }
    }

    /// One FIFO.
    pub fn path(&self, fifo: u8) -> &PathShadow {
        &self.fifos[usize::from(fifo != 0)]
    }
    fn path_mut(&mut self, fifo: u8) -> &mut PathShadow {
        &mut self.fifos[usize::from(fifo != 0)]
    }
    /// Whether it may be running when the next entry acts.
    pub fn may_run<const AXES: usize>(&self, view: &View<AXES>, sampled: &CrdView) -> bool {
        self.started.is_some_and(|seq| !executed(view, seq) || sampled.runs)
    }
    /// Whether a Stop may yet leave it stopped within its data.
    pub fn may_be_stopped<const AXES: usize>(&self, view: &View<AXES>, sampled: &CrdView) -> bool {
        self.stopped() && (sampled.runs || !executed(view, self.stop))
    }
    fn stopped(&self) -> bool {
        self.stop != 0
    }
    /// Whether it may stop before the end of the data that the FIFO of its start has.
    fn may_stop_within(&self) -> bool {
        self.stopped() || self.fed || self.may_fail || self.path(self.fifo).data.may_stop_at_wait()
    }
    /// Whether the tick itself may still be at work for an earlier start.
    pub fn is_busy<const AXES: usize>(&self, view: &View<AXES>, sampled: &CrdView) -> bool {
        sampled.runs || is_in_flight(view, self.busy)
    }
    /// Whether a start is in flight that may find the path elsewhere than its FIFO was left. Then
    /// the tick refuses it.
    pub fn may_start_elsewhere<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        is_in_flight(view, self.started) && self.path(self.fifo).passed.is_some()
    }
    /// Motions of a FIFO that are done, and those that remain.
    pub fn segments(&self, sampled: &CrdView, fifo: u8) -> (u32, u32) {
        let index = usize::from(fifo & 1);
        let done = if sampled.cleared[index] == self.path(fifo).cleared { sampled.done[index] } else { 0 };
        (done, self.path(fifo).data.motions.wrapping_sub(done))
    }
    /// Start of the next motion in a FIFO of a coordinate system that is at standstill there for
    /// what follows. None while only the tick knows.
    pub fn begin(&self, standstill: impl Fn() -> Option<Position>, fifo: u8) -> Option<Position> {
        let data = &self.path(fifo).data;
        if !data.is_open() {
            return standstill();
        }
        if self.path(fifo).left {
            return None;
        }
        // Coordinates given before the position was known are not those of the path, which stands
        // still where it is.
        let mut position = data.position;
        if position.iter().any(|at| at.is_nan())
            && let Some(standstill) = standstill()
        {
            for (at, here) in position.iter_mut().zip(standstill) {
                *at = if at.is_nan() { here } else { *at };
            }
        }
        Some(position)
    }

    /// Its position at standstill for what follows, if it is known without its axes.
    pub fn position_at_standstill<const AXES: usize>(&self, view: &View<AXES>, sampled: &CrdView) -> Option<Position> {
        let known = !self.is_busy(view, sampled) && self.last.is_none_or(|seq| executed(view, seq));
        self.here.or_else(|| known.then(|| position_of(&sampled.position)))
    }

    /// The path moves beside a FIFO, or is renamed.
    fn leave(&mut self, fifo: u8, seq: u32) {
        // Else a view has shown what is over.
        let within = fifo == self.fifo && self.busy.is_some() && self.may_stop_within();
        let path = self.path_mut(fifo);
        path.left |= path.data.is_open() && within;
        if path.data.is_open() {
            path.passed = Some(seq);
        }
        path.data.forget_position();
    }

    /// Everything of an earlier frame is over.
    pub(super) fn renew(&mut self, frame: Option<CrdParameters>, here: Option<Position>, seq: u32) {
        let CrdShadow { started, busy, extra_axes, fifos, .. } = *self;
        let dec = frame.map_or((0.0, 0.0), |frame| (frame.acc_max, frame.acc_max));
        *self = CrdShadow { frame, here, dec, started, busy, extra_axes, last: Some(seq), ..CrdShadow::power_on() };
        for (path, before) in self.fifos.iter_mut().zip(fifos) {
            let cleared = before.cleared.wrapping_add(1);
            *path = PathShadow::emptied(cleared, busy, seq);
        }
        self.forget_moved();
    }

    /// Axes of data that was cleared before it ran, or whose clear is executed, are not moved by it
    /// any more.
    fn forget_moved(&mut self) {
        if self.busy.is_none() || self.fifos.iter().all(|path| path.emptied.is_none()) {
            self.extra_axes = AxisMask(self.fifos.iter().fold(0, |mask, path| mask | path.data.extra_axes.0));
        }
    }

    /// Calls `young` with every entry number.
    pub(super) fn renew_numbers(&mut self, young: &mut impl FnMut(&mut u32)) {
        [&mut self.started, &mut self.busy, &mut self.last].into_iter().flatten().for_each(&mut *young);
        if self.stopped() {
            young(&mut self.stop);
        }
        self.fifos
            .iter_mut()
            .flat_map(|path| [&mut path.emptied, &mut path.last, &mut path.passed])
            .flatten()
            .for_each(young);
    }

    /// Enters a change that goes with entry `seq`.
    pub(super) fn enter(&mut self, change: &CrdChange, seq: u32) {
        // Data that is given moves nothing.
        if seq != 0 && !matches!(change, CrdChange::Data { .. }) {
            self.last = Some(seq);
        }
        match *change {
            CrdChange::Frame { frame, here } => self.renew(Some(frame), here, seq),
            CrdChange::Emptied { fifo, here } => {
                self.here = here;
                let busy = self.busy;
                let path = self.path_mut(fifo);
                *path = PathShadow { look: path.look, ..PathShadow::emptied(path.cleared.wrapping_add(1), busy, seq) };
                self.forget_moved();
            }
            CrdChange::Data { fifo, cleared, data } => {
                let path = self.path_mut(fifo);
                // Of two entries for the same FIFO, the one pushed later may act first.
                let newer = data.given.wrapping_sub(path.data.given).cast_signed() >= 0;
                if path.cleared == cleared && newer {
                    let moves = data.motions != path.data.motions;
                    path.data = data;
                    path.loose = seq == 0;
                    // The end of a motion is known, whatever was before it.
                    path.left &= !moves || data.position.iter().any(|at| at.is_nan());
                    if seq != 0 {
                        path.last = Some(seq);
                    }
                    self.extra_axes.0 |= data.extra_axes.0;
                    self.fed |= fifo == self.fifo && self.started.is_some();
                }
            }
            CrdChange::Look { fifo, look } => self.path_mut(fifo).look = look,
            CrdChange::Limit { coordinate, limit } => {
                if let Some(position) = self.limits.get_mut(usize::from(coordinate)) {
                    *position = limit;
                }
            }
            CrdChange::Dec(dec) => self.dec = dec,
            CrdChange::Override(rate) => self.rate = rate,
            CrdChange::Lag(ms) => self.lag_ms = ms,
            CrdChange::Started { fifo, may_fail } => {
                if let Some(here) = self.here.take() {
                    self.path_mut(fifo).data.set_known_position(&here);
                }
                self.leave(fifo ^ 1, seq);
                (self.fifo, self.started, self.busy) = (fifo, Some(seq), Some(seq));
                (self.stop, self.fed, self.may_fail) = (0, false, may_fail);
            }
            CrdChange::Placed => {
                self.here = None;
                (0..2).for_each(|fifo| self.leave(fifo, seq));
            }
            // One that is at standstill is not stopped within its data. A Stop beside the program
            // may come before a wait of the program.
            CrdChange::Stopped if seq & PROGRAM_FLAG != 0 && self.started.is_none() => {}
            CrdChange::Stopped if self.busy.is_some() => self.stop = seq,
            CrdChange::Stopped => {}
            CrdChange::Standstill => {
                let ended = self.started.is_some() && !self.may_stop_within();
                self.started = None;
                if ended {
                    let path = self.path_mut(self.fifo);
                    path.data.close();
                    path.data.over = path.data.given;
                    self.here = Some(path.data.position);
                }
            }
        }
    }

    /// What a view says of where motions begin while the path runs; `quiet` if nothing is in
    /// flight.
    fn follow_running<const AXES: usize>(&mut self, view: &View<AXES>, sampled: &CrdView, quiet: bool) {
        for (((path, cleared), motions), fifo) in
            self.fifos.iter_mut().zip(sampled.cleared).zip(sampled.done).zip(0u8..)
        {
            // Motions of the FIFO that runs may still come to their end.
            let settled = fifo != sampled.fifo || path.data.motions == motions;
            if path.cleared == cleared && path.is_executed(view) && settled {
                path.note_standstill(motions);
            }
            // What has no target stays where the path is.
            if quiet && fifo == sampled.fifo && !path.left {
                path.data.set_known_position(&position_of(&sampled.position));
            }
        }
    }

    /// Follows the tick: what came to standstill is at standstill, at the position that the view
    /// shows.
    pub fn update_from<const AXES: usize>(&mut self, view: &View<AXES>, sampled: &CrdView) {
        // Most of them are not in use.
        let cleared = [0, 1].map(|fifo: usize| self.fifos[fifo].cleared);
        if self.frame.is_none() && self.last.is_none() && self.busy.is_none() && cleared == sampled.cleared {
            return;
        }
        let over = |start: Option<u32>| start.filter(|&seq| !executed(view, seq) || sampled.runs);
        self.may_fail &= is_in_flight(view, self.busy);
        self.started = over(self.started);
        self.busy = over(self.busy);
        let done = |seq: Option<u32>| seq.is_none_or(|seq| executed(view, seq));
        let quiet = done(self.last);
        for path in &mut self.fifos {
            path.emptied = path.emptied.filter(|&seq| !executed(view, seq));
        }
        self.forget_moved();
        if self.busy.is_some() || sampled.runs {
            if sampled.runs {
                let path = self.path_mut(sampled.fifo);
                path.passed = path.passed.filter(|&seq| !executed(view, seq));
            }
            if done(self.busy) && sampled.fifo == self.fifo {
                self.follow_running(view, sampled, quiet);
            }
            return;
        }
        if quiet {
            (self.here, self.last, self.stop) = (None, None, 0);
        }
        for ((((path, cleared), released), motions), fifo) in
            self.fifos.iter_mut().zip(sampled.cleared).zip(sampled.released).zip(sampled.done).zip(0u8..)
        {
            if path.cleared != cleared {
                if quiet {
                    // The tick has cleared it for another reason, or has not done what it was asked
                    // to.
                    let look = path.look;
                    *path = PathShadow { cleared, look, ..PathShadow::default() };
                }
                continue;
            }
            // What is in flight changes nothing of that at standstill.
            path.note_standstill(motions);
            if quiet && !path.loose || path.is_executed(view) {
                // Entries in flight, as a Stop, change nothing of it at standstill. A wait that a
                // Stop has ended is over for the tick, but not for the path.
                let waits = sampled.path_stop == PathStop::Stopped && sampled.fifo == fifo && path.data.given != 0;
                if path.data.given == released && !waits {
                    path.data.close();
                } else if !path.data.is_open() {
                    path.data.open();
                }
                if quiet {
                    path.data.set_known_position(&position_of(&sampled.position));
                }
                self.fed &= fifo != self.fifo;
            }
        }
    }
}

/// What a tick command changes in the shadow state of its coordinate system.
#[derive(Debug, Clone, Copy)]
pub enum CrdChange {
    /// SetCrdPrm; `here` is the position, if it is known.
    Frame { frame: CrdParameters, here: Option<Position> },
    /// A FIFO is emptied; `here` is the position, if it is known.
    Emptied { fifo: u8, here: Option<Position> },
    /// What a FIFO was given, if it was cleared so many times.
    Data { fifo: u8, cleared: u32, data: PathData },
    /// Look-ahead of a FIFO.
    Look { fifo: u8, look: Option<LookAheadSettings> },
    /// Limits of a coordinate.
    Limit { coordinate: u8, limit: (f64, f64) },
    /// Stop decelerations.
    Dec((f64, f64)),
    /// Override.
    Override(f64),
    /// Time constant of the filter of its encoders' speed, ms.
    Lag(f64),
    /// Only the tick knows its position.
    Placed,
    /// It starts; what follows acts also where the tick refuses that.
    Started { fifo: u8, may_fail: bool },
    /// It gets a Stop.
    Stopped,
    /// It is at standstill for what follows.
    Standstill,
}
