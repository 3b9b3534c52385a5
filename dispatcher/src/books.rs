//! The books: what the thread knows of every axis without asking the tick.
//!
//! In: [`Change`]s, one beside every operation that is pushed into a lane. Out: the figures that
//! admissions and getters need. There are two sets: *ahead* is the state after everything that was
//! admitted, *now* the state after everything that the tick has executed. If the rest of a program is
//! discarded, *ahead* is set back to *now*, so that what was never executed leaves no trace.
mod follow;

pub use follow::{Fifo, FollowBook};
use protocol::command::{JogPrm, TrapPrm};
use servo::laser::{self, Bounds, CHANNELS, Carrier, Power};
use servo::op::{Mode, Op};
use servo::pt::Chain;
use servo::pvt::TABLES;
use servo::status::RUNNING;
use servo::units::{Axis, AxisMask};
use servo::view::{AxisView, View};

/// Set in the numbers of the program lane, so that a number tells its lane.
pub const PROGRAM_FLAG: u32 = 1 << 31;
/// Software limits at these values are off.
pub const SOFT_OFF: (i32, i32) = (i32::MAX, i32::MIN);

/// The place after `seq` in its lane.
pub const fn seq_after(seq: u32) -> u32 {
    seq & PROGRAM_FLAG | seq.wrapping_add(1) & !PROGRAM_FLAG
}

/// Whether the tick that `view` shows has executed entry `seq`.
pub fn executed<const AXES: usize>(view: &View<AXES>, seq: u32) -> bool {
    let done = if seq & PROGRAM_FLAG == 0 { view.done_immediate } else { view.done_program };
    // Numbers have 31 bits; shifted up, their difference has a sign. A lane that has done nothing yet
    // shows 0, which has no flag.
    done & PROGRAM_FLAG == seq & PROGRAM_FLAG && (done.wrapping_sub(seq) << 1).cast_signed() >= 0
}

/// One FIFO of PT data.
#[derive(Debug, Clone, Copy, Default)]
pub struct FifoBook {
    /// Segments pushed since it was cleared.
    pub end: u32,
    /// End position, time and velocity of the last one.
    pub chain: Chain,
}

/// One axis.
#[derive(Debug, Clone, Copy)]
pub struct AxisBook {
    /// Profile mode.
    pub mode: Mode,
    /// PT memory selector, 0 or 1.
    pub memory: u8,
    /// FIFO of the last PtStart.
    pub fifo: u8,
    /// PT data; dynamic mode uses the first only.
    pub fifos: [FifoBook; 2],
    /// PT stream number of the view that these books follow.
    pub epoch: u32,
    /// The last start, until the axis is known to be at rest at this place of its lane.
    pub started: Option<u32>,
    /// The last start, until the axis has been seen at rest.
    pub busy: Option<u32>,
    /// The last AxisOn or AxisOff, until it is executed.
    pub servo: Option<(u32, bool)>,
    /// The last ClrSts or Reset, until it is executed.
    pub cleared: Option<u32>,
    /// The last entry that emptied a FIFO, until it is executed.
    pub emptied: Option<u32>,
    /// FIFOs (a bit each) whose data is being overwritten, though what emptied them is not executed.
    pub spoiled: u8,
    /// The start whose data that entry may have given up, until the axis has been seen at rest.
    pub leaving: Option<u32>,
    /// Stop decelerations, pulse/ms².
    pub dec: (f64, f64),
    /// In-position band (pulses) and time (250 µs cycles).
    pub band: (i32, i32),
    /// Software limits, pulses.
    pub soft: (i32, i32),
    /// Following-error limit, pulses; `i32::MAX` is off.
    pub pos_err: i32,
    /// Trap parameters.
    pub trap: TrapPrm,
    /// Jog parameters.
    pub jog: JogPrm,
    /// PVT table that was selected, by its index over all cores.
    pub table: Option<u8>,
    /// PVT passes to run, 0 for ever.
    pub table_passes: i32,
    /// Follow and FollowEx.
    pub follow: FollowBook,
    /// Target velocity, pulse/ms.
    pub vel: f64,
    /// Target position, pulses.
    pub pos: i32,
}

impl Default for AxisBook {
    /// Power-on (SPEC 5).
    fn default() -> Self {
        AxisBook {
            mode: Mode::Trap,
            memory: 0,
            fifo: 0,
            fifos: [FifoBook::default(); 2],
            epoch: 0,
            started: None,
            busy: None,
            servo: None,
            cleared: None,
            emptied: None,
            spoiled: 0,
            leaving: None,
            dec: (1.0, 1000.0),
            band: (0, 0),
            soft: SOFT_OFF,
            pos_err: i32::MAX,
            trap: TrapPrm::default(),
            jog: JogPrm::default(),
            table: None,
            table_passes: 1,
            follow: FollowBook::default(),
            vel: 0.0,
            pos: 0,
        }
    }
}

impl AxisBook {
    /// Whether PT data of this axis forms one ring.
    pub fn is_dynamic(&self) -> bool {
        self.mode == Mode::PtDynamic
    }
    /// Whether the axis is in a PT mode.
    pub fn is_pt(&self) -> bool {
        matches!(self.mode, Mode::PtStatic | Mode::PtDynamic)
    }
    /// Whether the axis is in Follow or FollowEx mode.
    pub fn is_follow(&self) -> bool {
        matches!(self.mode, Mode::Follow | Mode::FollowEx)
    }
    /// The FIFO of Follow that runs when the next entry acts, if the axis does and does not switch.
    pub fn running_fifo<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> u8 {
        if self.busy.is_some_and(|seq| !executed(view, seq)) { self.fifo } else { axis.fifo }
    }
    /// Whether only the instant at which a command acts can tell what it does to the FIFOs of Follow.
    pub fn may_switch<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        self.follow.may_switch(view, axis, self.is_busy(view, axis))
    }
    /// As [`AxisBook::is_outgoing`], of a FIFO of Follow.
    pub fn is_follow_outgoing<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView, fifo: u8) -> bool {
        let busy = self.is_busy(view, axis);
        // With a start on its way, one before it may be, too.
        let idle = self.busy.is_none_or(|seq| executed(view, seq)) && axis.fifo != fifo && !self.may_switch(view, axis);
        self.is_outgoing(view, axis) || self.follow.is_outgoing(view, fifo, busy, idle)
    }
    /// Whether a PT or ramp motion may be running when the next entry acts.
    pub fn may_run<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        self.started.is_some_and(|seq| !executed(view, seq) || axis.status & RUNNING != 0)
    }
    /// Whether the tick itself may still be working through data of an earlier start.
    pub fn is_busy<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        axis.status & RUNNING != 0 || self.busy.is_some_and(|seq| !executed(view, seq))
    }
    /// Whether the data of a FIFO belongs to what is over at this place of the lane, while the tick may
    /// still be at it: a stream that a WaitStop waits for, or a FIFO that is going to be emptied.
    pub fn is_outgoing<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView) -> bool {
        let runs = axis.status & RUNNING != 0;
        let emptied = self.emptied.is_some_and(|seq| !executed(view, seq))
            && (runs || self.leaving.is_some_and(|seq| !executed(view, seq)));
        let ended = self.is_dynamic() && self.started.is_none() && self.is_busy(view, axis);
        emptied || ended
    }
    /// Segments that one FIFO (in dynamic mode, the ring) holds.
    pub fn capacity(&self) -> u32 {
        match (self.is_dynamic(), self.memory) {
            (false, 0) => 32,
            (false, _) => 1024,
            (true, 0) => 64,
            (true, _) => 2048,
        }
    }
    /// Places free in a FIFO, as far as the tick has told.
    pub fn space<const AXES: usize>(&self, view: &View<AXES>, axis: &AxisView, fifo: usize) -> u32 {
        if self.is_dynamic() && self.is_outgoing(view, axis) {
            return self.capacity();
        }
        let end = self.fifos.get(fifo).map_or(0, |fifo| fifo.end);
        // A ring that is going to be emptied has released nothing of what follows.
        let emptied = self.emptied.is_some_and(|seq| !executed(view, seq));
        let released = if self.is_dynamic() && !emptied { axis.released } else { 0 };
        self.capacity().saturating_sub(end.wrapping_sub(released))
    }
    /// Entry `seq` empties the FIFOs of these bits.
    fn empty(&mut self, seq: u32, fifos: u8) {
        self.emptied = Some(seq);
        self.leaving = self.busy;
        self.spoiled &= !fifos;
    }
    /// Whether a FIFO holds data, in the present mode.
    fn holds(&self, fifo: u8) -> bool {
        if self.is_follow() {
            !self.follow.fifo(fifo).is_empty()
        } else {
            self.fifos
                .iter()
                .enumerate()
                .any(|(index, data)| data.end != 0 && (self.is_dynamic() || index == usize::from(fifo)))
        }
    }
    /// Follows the tick: a stream that ended is cleared, an axis that came to rest is at rest.
    pub fn follow<const AXES: usize>(&mut self, view: &View<AXES>, axis: &AxisView) {
        if self.epoch != axis.epoch {
            self.epoch = axis.epoch;
            if self.is_dynamic() {
                self.fifos = [FifoBook::default(); 2];
            }
        }
        self.follow.follow(axis);
        let over = |start: Option<u32>| start.filter(|&seq| !executed(view, seq) || axis.status & RUNNING != 0);
        self.started = over(self.started);
        self.busy = over(self.busy);
        self.leaving = over(self.leaving);
    }
}

/// One laser channel.
#[derive(Debug, Clone, Copy)]
pub struct LaserBook {
    /// Power mode.
    pub mode: laser::Mode,
    /// Bounds of the power.
    pub bounds: Bounds,
    /// The gate's delays apply.
    pub delayed: bool,
    /// Direct power.
    pub power: Power,
    /// Carrier of the duty modes.
    pub carrier: Option<Carrier>,
    /// Pulse width of the frequency mode, µs; 0 is none set.
    pub width_us: u16,
    /// Standby pulses: kHz and %.
    pub standby: Option<(Power, Power)>,
    /// The axis connector carries the laser.
    pub connector: bool,
    /// Crds over all cores, bit 0 is crd 1 of core 1.
    pub map: u8,
    /// The last entry that clears the channel's fault, until it is executed.
    pub cleared: Option<u32>,
}

impl LaserBook {
    /// A channel at power-on (SPEC 6).
    pub const fn power_on(delayed: bool, connector: bool) -> LaserBook {
        LaserBook {
            mode: laser::Mode::Duty,
            bounds: Bounds::full(laser::Mode::Duty),
            delayed,
            power: Power::ZERO,
            carrier: None,
            width_us: 0,
            standby: None,
            connector,
            map: u8::MAX,
            cleared: None,
        }
    }

    /// Another mode sets the power to 0; the same one changes only what is given with it.
    pub fn set_mode(&mut self, mode: laser::Mode, bounds: Bounds, delayed: bool) {
        if self.mode != mode {
            self.power = Power::ZERO;
        }
        (self.mode, self.bounds, self.delayed) = (mode, bounds, delayed);
    }

    fn enter(&mut self, change: LaserChange, seq: u32) {
        match change {
            LaserChange::PowerOn { delayed, connector } => {
                *self = LaserBook { cleared: Some(seq), ..LaserBook::power_on(delayed, connector) };
            }
            LaserChange::Mode { mode, bounds, delayed } => self.set_mode(mode, bounds, delayed),
            LaserChange::Power(power) => self.power = power,
            LaserChange::Carrier(carrier) => self.carrier = Some(carrier),
            LaserChange::Width(width_us) => self.width_us = width_us,
            LaserChange::Standby(standby) => self.standby = standby,
            LaserChange::Connector(laser) => self.connector = laser,
            LaserChange::Map(map) => self.map = map,
            LaserChange::Cleared => self.cleared = Some(seq),
        }
    }
}

/// What a laser operation changes in the book of its channel.
#[derive(Debug, Clone, Copy)]
pub enum LaserChange {
    /// Power-on state of a family.
    PowerOn { delayed: bool, connector: bool },
    /// LaserPowerMode.
    Mode { mode: laser::Mode, bounds: Bounds, delayed: bool },
    /// Direct power.
    Power(Power),
    /// Carrier.
    Carrier(Carrier),
    /// Pulse width, µs.
    Width(u16),
    /// Standby pulses: kHz and %.
    Standby(Option<(Power, Power)>),
    /// What the axis connector carries.
    Connector(bool),
    /// Crd map.
    Map(u8),
    /// The fault is cleared.
    Cleared,
}

/// What a pushed operation changes in the books.
#[derive(Debug, Clone, Copy)]
pub enum Change {
    /// Nothing.
    None,
    /// Power-on state.
    Reset { axes: AxisMask, tables: u64 },
    /// Servo on or off.
    Servo { axis: Axis, on: bool },
    /// Latched bits are cleared.
    Cleared { axes: AxisMask },
    /// The axes start.
    Started { axes: AxisMask, fifo1: AxisMask },
    /// PVT starts with the tables that are selected.
    PvtStarted { axes: AxisMask },
    /// A PVT table is selected; `pending` if the axis may be running and go on with it.
    Table { axis: Axis, table: u8, pending: bool },
    /// PVT passes.
    TablePasses { axis: Axis, passes: i32 },
    /// A PVT table is there.
    TableFilled { table: u8 },
    /// The axes are at rest for what follows.
    Rest { axes: AxisMask },
    /// A mode, with empty FIFOs.
    Mode { axis: Axis, mode: Mode },
    /// A memory size.
    Memory { axis: Axis, memory: u8 },
    /// A FIFO is emptied (both in dynamic mode).
    Emptied { axis: Axis, fifo: u8 },
    /// A FIFO's data now ends here, if its stream is still that of `epoch`.
    Data { axis: Axis, fifo: u8, epoch: u32, book: FifoBook },
    /// A master of Follow, and how it was given.
    FollowMaster { axis: Axis, master: Axis, given: [i16; 3] },
    /// A start condition of Follow as it was given.
    FollowEvent { axis: Axis, given: (i16, i16, i32) },
    /// A direction of Follow.
    FollowDirection { axis: Axis, direction: i8 },
    /// A memory size of Follow.
    FollowMemory { axis: Axis, memory: u8 },
    /// A FIFO of Follow is emptied.
    FollowEmptied { axis: Axis, fifo: u8 },
    /// A FIFO of Follow now ends here, if no switch has emptied it meanwhile.
    FollowData { axis: Axis, fifo: u8, cleared: u32, book: Fifo },
    /// The axes go to their other FIFO, now or at the end of the pass.
    Switched { axes: AxisMask },
    /// Stop decelerations.
    Dec { axis: Axis, dec: (f64, f64) },
    /// Band.
    Band { axis: Axis, band: (i32, i32) },
    /// Software limits.
    Soft { axis: Axis, soft: (i32, i32) },
    /// Following-error limit.
    PosErr { axis: Axis, pos_err: i32 },
    /// Trap parameters.
    Trap { axis: Axis, prm: TrapPrm },
    /// Jog parameters.
    Jog { axis: Axis, prm: JogPrm },
    /// Target velocity.
    Vel { axis: Axis, vel: f64 },
    /// Target position.
    Pos { axis: Axis, pos: i32 },
    /// An analog output, from 0.
    Analog { channel: u8, value: i16 },
    /// A laser channel, from 0.
    Laser { channel: u8, change: LaserChange },
    /// Resolution of the lasers' frequencies (LSR): high (SetLaserMode 1) or low.
    LaserFine(bool),
}

/// One set of books.
#[derive(Debug, Clone, Copy)]
pub struct Books<const AXES: usize> {
    /// The axes.
    pub axes: [AxisBook; AXES],
    /// The analog outputs.
    pub analog: [i16; 8],
    /// The laser channels.
    pub lasers: [LaserBook; CHANNELS],
    /// Resolution of their frequencies.
    pub laser_fine: bool,
    /// PVT tables that hold data, a bit a table.
    filled: u64,
    /// The last entry that named a PVT table.
    named: [Option<u32>; TABLES],
}

impl<const AXES: usize> Books<AXES> {
    /// Books at power-on.
    pub fn new() -> Self {
        Books {
            axes: [AxisBook::default(); AXES],
            analog: [0; 8],
            lasers: [LaserBook::power_on(true, false); CHANNELS],
            laser_fine: true,
            filled: 0,
            named: [None; TABLES],
        }
    }

    /// Book of one axis; the last one for an axis beyond the capacity, which no admission lets through.
    pub fn axis(&self, axis: Axis) -> &AxisBook {
        &self.axes[axis.index().min(AXES - 1)]
    }

    /// Whether a PVT table holds data.
    pub fn is_filled(&self, table: u8) -> bool {
        self.filled.checked_shr(table.into()).unwrap_or(0) & 1 == 1
    }

    /// A PVT table is being overwritten: until the entry that goes with it has been executed, what it holds
    /// belongs to nothing executed.
    pub fn spoil(&mut self, table: u8) {
        self.filled &= !1u64.checked_shl(table.into()).unwrap_or(0);
    }

    /// Whether data that is written to a FIFO now takes the place of what the tick has not emptied yet.
    pub fn overwrites(&self, view: &View<AXES>, axis: Axis, fifo: u8) -> bool {
        let book = self.axis(axis);
        book.emptied.is_some_and(|seq| !executed(view, seq)) || book.is_follow() && book.follow.is_spoiled(view, fifo)
    }

    /// FIFOs (a bit each) are being overwritten: if what emptied them is never executed, they have to be emptied
    /// then.
    pub fn spoil_fifos(&mut self, axis: Axis, fifos: u8) {
        if let Some(book) = self.axes.get_mut(axis.index()) {
            book.spoiled |= fifos & (u8::from(book.holds(0)) | u8::from(book.holds(1)) << 1);
        }
    }

    /// What empties one of the FIFOs that were overwritten, of the first axis that has some.
    pub fn unspoil(&self) -> Option<(Op, Change)> {
        let (index, book) = self.axes.iter().enumerate().find(|(_, book)| book.spoiled != 0)?;
        let (axis, fifo) = (Axis::new(index)?, book.spoiled.trailing_zeros() as u8);
        Some(if book.is_follow() {
            (Op::FollowClear { axis, fifo }, Change::FollowEmptied { axis, fifo })
        } else {
            (Op::PtClear { axis, fifo }, Change::Emptied { axis, fifo })
        })
    }

    /// Whether an entry that was not executed names a PVT table.
    pub fn is_named(&self, view: &View<AXES>, table: u8) -> bool {
        self.named.get(usize::from(table)).copied().flatten().is_some_and(|seq| !executed(view, seq))
    }

    fn name(&mut self, table: Option<u8>, seq: u32) {
        if let Some(named) = table.and_then(|table| self.named.get_mut(usize::from(table))) {
            *named = Some(seq);
        }
    }

    fn with(&mut self, axes: AxisMask, change: impl Fn(Axis, &mut AxisBook)) {
        for (index, book) in self.axes.iter_mut().enumerate() {
            if let Some(axis) = Axis::new(index).filter(|&axis| axes.has(axis)) {
                change(axis, book);
            }
        }
    }

    /// Enters the change that goes with entry `seq`.
    pub fn enter(&mut self, change: &Change, seq: u32) {
        let mut one = |axis: Axis, change: &dyn Fn(&mut AxisBook)| {
            if let Some(book) = self.axes.get_mut(axis.index()) {
                change(book);
            }
        };
        match *change {
            Change::None => {}
            Change::Reset { axes, tables } => {
                self.filled &= !tables;
                self.with(axes, |_, book| {
                    // The start is kept: the axis runs until the Reset has been executed.
                    let AxisBook { epoch, started, busy, mut follow, .. } = *book;
                    follow.reset(seq);
                    *book = AxisBook {
                        epoch,
                        started,
                        busy,
                        follow,
                        cleared: Some(seq),
                        servo: Some((seq, false)),
                        ..AxisBook::default()
                    };
                    book.empty(seq, 3);
                });
            }
            Change::Servo { axis, on } => one(axis, &|book| book.servo = Some((seq, on))),
            Change::Cleared { axes } => self.with(axes, |_, book| book.cleared = Some(seq)),
            Change::Started { axes, fifo1 } => self.with(axes, |axis, book| {
                book.started = Some(seq);
                book.busy = Some(seq);
                book.fifo = u8::from(fifo1.has(axis));
            }),
            Change::PvtStarted { axes } => {
                for index in 0..AXES {
                    if axes.0.checked_shr(index as u32).unwrap_or(0) & 1 == 1 {
                        self.name(self.axes[index].table, seq);
                    }
                }
                self.with(axes, |_, book| {
                    book.started = Some(seq);
                    book.busy = Some(seq);
                });
            }
            Change::Table { axis, table, pending } => {
                one(axis, &|book| book.table = Some(table));
                self.name(Some(table).filter(|_| pending), seq);
            }
            Change::TablePasses { axis, passes } => one(axis, &|book| book.table_passes = passes),
            Change::TableFilled { table } => self.filled |= 1u64.checked_shl(table.into()).unwrap_or(0),
            Change::Rest { axes } => self.with(axes, |_, book| book.started = None),
            Change::Mode { axis, mode } => one(axis, &|book| {
                book.mode = mode;
                book.follow.forget(seq);
                book.fifos = [FifoBook::default(); 2];
                book.empty(seq, 3);
            }),
            Change::Memory { axis, memory } => one(axis, &|book| {
                book.memory = memory;
                book.fifos = [FifoBook::default(); 2];
                book.empty(seq, 3);
            }),
            Change::Emptied { axis, fifo } => one(axis, &|book| {
                if let Some(fifo) = book.fifos.get_mut(usize::from(fifo)) {
                    *fifo = FifoBook::default();
                }
                book.empty(seq, if book.is_dynamic() { 3 } else { 1 << (fifo & 1) });
            }),
            Change::Data { axis, fifo, epoch, book: data } => one(axis, &|book| {
                if book.is_dynamic() && book.epoch != epoch {
                    return;
                }
                if let Some(fifo) = book.fifos.get_mut(usize::from(fifo)) {
                    *fifo = data;
                }
            }),
            Change::FollowMaster { axis, master, given } => {
                one(axis, &|book| book.follow.master = Some((master, given)));
            }
            Change::FollowEvent { axis, given } => one(axis, &|book| book.follow.event = given),
            Change::FollowDirection { axis, direction } => one(axis, &|book| book.follow.direction = direction),
            Change::FollowMemory { axis, memory } => one(axis, &|book| {
                book.follow.memory = memory;
                book.follow.empty_both(seq);
                book.spoiled = 0;
            }),
            Change::FollowEmptied { axis, fifo } => one(axis, &|book| {
                book.follow.empty(fifo, seq);
                book.spoiled &= !(1 << (fifo & 1));
            }),
            Change::FollowData { axis, fifo, cleared, book: data } => one(axis, &|book| {
                let place = usize::from(fifo & 1);
                if book.follow.cleared[place] == cleared {
                    book.follow.fifos[place] = data;
                }
            }),
            Change::Switched { axes } => self.with(axes, |_, book| book.follow.switched(seq)),
            Change::Dec { axis, dec } => one(axis, &|book| book.dec = dec),
            Change::Band { axis, band } => one(axis, &|book| book.band = band),
            Change::Soft { axis, soft } => one(axis, &|book| book.soft = soft),
            Change::PosErr { axis, pos_err } => one(axis, &|book| book.pos_err = pos_err),
            Change::Trap { axis, prm } => one(axis, &|book| book.trap = prm),
            Change::Jog { axis, prm } => one(axis, &|book| book.jog = prm),
            Change::Vel { axis, vel } => one(axis, &|book| book.vel = vel),
            Change::Pos { axis, pos } => one(axis, &|book| book.pos = pos),
            Change::Laser { channel, change } => {
                if let Some(laser) = self.lasers.get_mut(usize::from(channel)) {
                    laser.enter(change, seq);
                }
            }
            Change::LaserFine(fine) => self.laser_fine = fine,
            Change::Analog { channel, value } => {
                if let Some(output) = self.analog.get_mut(usize::from(channel)) {
                    *output = value;
                }
            }
        }
    }
}
