//! The virtual controller under a program: every call is an entry of the program queue that may
//! fail, and every tick's set-points and status words are kept.
use client::{Answer, Client, Link, Options, ProductProfile};
use host_tests::reference::{Call, Family, Fix, Kind, Points, Session, Setup};
use protocol::command::*;
use std::sync::{Arc, Mutex};
use std::time::Duration;

#[path = "machine/answers.rs"]
mod answers;
#[path = "machine/effects.rs"]
mod effects;
#[path = "machine/light.rs"]
mod light;
#[path = "machine/paths.rs"]
mod paths;
#[path = "machine/sessions.rs"]
mod sessions;

pub use answers::{Got, got};
use plant::beam::SignalChange;
use virtual_board::{Beam, Board, Config, Edge, Output, Shared, share};

/// One axis in one tick: set-point in 2⁻²² pulse, status word.
pub type Seen = (i64, u32);

struct Record {
    /// Places of the axes over all cores.
    axes: Vec<usize>,
    rows: Vec<(u64, Vec<Seen>)>,
    /// Encoder counts, general and analog outputs, of the same ticks.
    more: Vec<More>,
}

/// What a tick has beside its axes.
#[derive(Debug, Clone, Default)]
pub struct More {
    pub encoders: Vec<i64>,
    pub general: u32,
    pub analog: [i16; 8],
    /// Powers of the lasers, %.
    pub powers: [f64; 2],
}

/// In lockstep, a tick at a time.
struct Watched {
    board: Shared,
    received: Vec<u8>,
    taken: usize,
    record: Arc<Mutex<Record>>,
}

/// Ticks that a program may last.
const MAX_ROWS: usize = 100_000;

impl Watched {
    fn advance(&mut self, wait: Duration) {
        let mut board = self.board.lock().unwrap();
        let mut record = self.record.lock().unwrap();
        let record = &mut *record;
        let end = board.now() + wait.as_nanos() as u64;
        while board.now() < end {
            let period = board.period_ns();
            let came = board.advance(period, &mut self.received);
            let at = board.now();
            let row = record.axes.iter().map(|&axis| (board.set_point(axis), board.axis(axis).status)).collect();
            record.rows.push((at, row));
            let encoders = record.axes.iter().map(|&axis| board.encoder(axis)).collect();
            let outputs = board.outputs();
            let (general, analog) = (outputs.general as u32, outputs.analog);
            let powers = [0, 1].map(|channel| board.laser_view(channel).power.raw() as f64 / 2f64.powi(44));
            record.more.push(More { encoders, general, analog, powers });
            if came {
                return;
            }
        }
    }
}

impl Link for Watched {
    fn name(&self) -> &str {
        "virtual"
    }

    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        self.board.lock().unwrap().feed(bytes);
        Ok(())
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        if self.taken == self.received.len() {
            self.received.clear();
            self.taken = 0;
            self.board.lock().unwrap().take_tx(&mut self.received);
            if self.received.is_empty() {
                if self.record.lock().unwrap().rows.len() > MAX_ROWS {
                    return Err(client::Error::new(client::error::NO_ANSWER, "the program goes on for ever"));
                }
                self.advance(wait);
            }
        }
        let left = &self.received[self.taken..];
        let n = left.len().min(buf.len());
        buf[..n].copy_from_slice(&left[..n]);
        self.taken += n;
        Ok(n)
    }

    fn now(&mut self) -> u64 {
        self.board.lock().unwrap().now()
    }

    fn real_time(&self) -> bool {
        false
    }
}

/// What a program gave.
pub struct Reported {
    /// Positions before the program.
    pub begin: Vec<i64>,
    pub answers: Vec<Answer>,
    /// Entries whose tick had passed.
    pub late: u32,
    /// From tick 0 of the program on.
    pub rows: Vec<Vec<Seen>>,
    /// Instants of the rows, ns from the first program's zero, and what lay between programs.
    pub times: Vec<i64>,
    pub sessions: Vec<Session>,
    pub more: Vec<More>,
    /// Changes of general outputs: ns of the program, from 0, level.
    pub edges: Vec<(i64, u8, bool)>,
    /// The same of the switches of lasers.
    pub gates: Vec<(i64, u8, bool)>,
}

pub struct Rig {
    board: Shared,
    client: Client,
    record: Arc<Mutex<Record>>,
    pub setup: Setup,
    pub tick_us: u32,
}

impl Rig {
    pub fn new(setup: Setup, tick_us: u32) -> Rig {
        let (profile, number, per_core) = match setup.profile {
            "gus" => (ProductProfile::Gus, 0, 8),
            _ => (ProductProfile::Gtn016, 1, 8),
        };
        let board = share(Board::new(Config { tick_us, profile: number, ..Config::default() }));
        board.lock().unwrap().record_beam(true);
        let axes = setup.axes.iter().map(|&(core, axis)| (core as usize - 1) * per_core + axis as usize - 1).collect();
        let record = Arc::new(Mutex::new(Record { axes, rows: Vec::new(), more: Vec::new() }));
        let link = Watched { board: board.clone(), received: Vec::new(), taken: 0, record: Arc::clone(&record) };
        let family = if setup.family == Family::Lsr { client::Family::Lsr } else { client::Family::Gus };
        let options = Options { profile: Some(profile), family: Some(family), ..Options::default() };
        let client = Client::open(Box::new(link), options).unwrap();
        Rig { board, client, record, setup, tick_us }
    }

    fn cores(&self) -> i16 {
        self.setup.axes.iter().map(|axis| axis.0).max().unwrap_or(1)
    }

    /// Runs it from power-on settings; positions of the machine stay.
    pub fn run(&mut self, calls: &[Call]) -> Result<Reported, String> {
        self.client.call(SetTick { tick_us: (self.tick_us as i32).into() }).map_err(|e| format!("{e:?}"))?;
        {
            let mut board = self.board.lock().unwrap();
            board.inputs_mut().general = 0;
            board.inputs_mut().interlock = false;
            board.inputs_mut().analog = [0; 8];
            board.inputs_mut().axes.iter_mut().for_each(|axis| *axis = Default::default());
        }
        // Encoders come to rest, so that Reset names the place of the set-point.
        self.client.sleep(Duration::from_millis(25)).map_err(|error| format!("{error:?}"))?;
        for core in 1..=self.cores() {
            self.client.call(Reset { core: core.into() }).map_err(|error| format!("{error:?}"))?;
        }
        for &(core, axis) in &self.setup.axes {
            let all = LmtsOff { core: core.into(), axis: axis.into(), limit_type: (-1).into() };
            self.client.call(all).map_err(|error| format!("{error:?}"))?;
        }
        self.client.sleep(Duration::from_millis(3)).map_err(|error| format!("{error:?}"))?;
        self.board.lock().unwrap().take_edges();
        self.board.lock().unwrap().take_beam();
        {
            // The tick in force may be the program's first.
            let mut record = self.record.lock().unwrap();
            let before = record.rows.len().saturating_sub(1);
            record.rows.drain(..before);
            record.more.drain(..before);
        }
        let ran = sessions::run(self, calls)?;
        self.client.sleep(Duration::from_millis(12)).map_err(|error| format!("{error:?}"))?;
        let zero = ran.zero;
        // Nothing may run on into the next program.
        for core in 1..=self.cores() {
            self.client.call(Reset { core: core.into() }).map_err(|error| format!("{error:?}"))?;
        }
        let taken = self.board.lock().unwrap().take_edges();
        let edge = |edge: &Edge| match edge.output {
            Output::General(bit) => Some((edge.at_ns as i64 - zero as i64, bit, edge.level)),
            _ => None,
        };
        let edges = taken.iter().filter_map(edge).collect();
        let beam = self.board.lock().unwrap().take_beam();
        let gate = |beam: &Beam| match beam.change {
            SignalChange::Switch { at, level } => Some((at as i64 - zero as i64, beam.channel, level)),
            _ => None,
        };
        let gates = beam.iter().filter_map(gate).collect();
        let mut record = self.record.lock().unwrap();
        let (rows, mut more) = (std::mem::take(&mut record.rows), std::mem::take(&mut record.more));
        drop(record);
        more.drain(..rows.iter().take_while(|row| row.0 < zero).count());
        let rows: Vec<_> = rows.into_iter().filter(|row| row.0 >= zero).collect();
        let times: Vec<i64> = rows.iter().map(|row| (row.0 - zero) as i64).collect();
        let sessions = ran.sessions(&times);
        let rows: Vec<_> = rows.into_iter().map(|row| row.1).collect();
        let begin = rows.first().map(|row| row.iter().map(|seen| seen.0).collect()).unwrap_or_default();
        Ok(Reported { begin, answers: ran.answers, rows, times, sessions, more, edges, gates, late: ran.late })
    }
}

/// A call as it travels.
pub fn wire(setup: &Setup, call: &Call) -> client::Call {
    if let Call::PvtTable { axis, table, points } = call {
        return table_of(setup.axes[*axis].0, *table, points);
    }
    if let Call::PvtCalculate { core, points } = call {
        return computed(*core, points);
    }
    match call {
        Call::Ex(of) => return effects::ex(setup, of),
        Call::FollowEntry { axis, item, fifo } => return effects::entry(setup, *axis, item, *fifo),
        Call::FollowSwitchNow { axis, table } => return effects::switch_now(setup, *axis, *table, 0, 0.into()),
        Call::Effect(effect) => return effects::effect(effect),
        Call::Light(of) => return light::call(of),
        Call::LightTable(of) => return light::table(of),
        Call::Path(of) => return paths::wire(setup, of),
        &Call::Abort { core } => return client::Call::of(Abort { core: core.into() }),
        &Call::Reset { core } => return client::Call::of(Reset { core: core.into() }),
        &Call::Terminal { .. } | &Call::Guard { .. } | &Call::Sense { .. } | &Call::SetCapture { .. } => {
            return effects::terminal(setup, call);
        }
        &Call::AsymmetricWay { core, master, ratios, shares } => {
            return client::Call::of(GetFollowDataPercent2Ex {
                core: core.into(),
                master_pos: master.into(),
                vel_begin_ratio: ratios[0].into(),
                vel_end_ratio: ratios[1].into(),
                percent: shares[0].into(),
                percent1: shares[1].into(),
            });
        }
        &Call::SetTick { us } => return client::Call::of(SetTick { tick_us: us.into() }),
        _ => {}
    }
    use client::Call as Wire;
    let at = |axis: usize| (setup.axes[axis].0.into(), setup.axes[axis].1.into());
    let of = |mask: u32| {
        let (core, mask) = setup.mask(mask);
        (core.into(), mask.cast_signed().into())
    };
    let option = |mask: u32, option: u32| setup.mask(option & mask).1.cast_signed().into();
    match *call {
        Call::Sleep { ns } => Wire::of(Sleep { ns: (ns as u64).into() }),
        Call::WaitStop { mask } => {
            let (core, axes) = of(mask);
            Wire::of(WaitStop { core, axes, crds: 0.into() })
        }
        Call::Axis { kind, axis } => plain(kind, at(axis)),
        Call::Stop { mask, abrupt } => {
            let (core, bits) = of(mask);
            Wire::of(Stop { core, mask: bits, option: option(mask, abrupt), form: 0 })
        }
        Call::SetPrfPos { axis, pos } => {
            let (core, profile) = at(axis);
            Wire::of(SetPrfPos { core, profile, pos: pos.into() })
        }
        Call::SetStopDec { axis, smooth } => {
            let (core, profile) = at(axis);
            Wire::of(SetStopDec { core, profile, smooth: smooth.into(), abrupt: 1000.0.into() })
        }
        Call::SetEncPos { axis, pos } => {
            let (core, encoder) = at(axis);
            Wire::of(SetEncPos { core, encoder, pos: pos.into() })
        }
        Call::SynchAxisPos { mask } => {
            let (core, mask) = of(mask);
            Wire::of(SynchAxisPos { core, mask })
        }
        Call::SetAxisBand { axis, band, time } => {
            let (core, axis) = at(axis);
            Wire::of(SetAxisBand { core, axis, band: band.into(), time_cycles: time.into() })
        }
        Call::SetPosErr { axis, error } => {
            let (core, control) = at(axis);
            Wire::of(SetPosErr { core, control, error: error.into() })
        }
        Call::SetSoftLimit { axis, positive, negative } => {
            let (core, axis) = at(axis);
            Wire::of(SetSoftLimit { core, axis, positive: positive.into(), negative: negative.into() })
        }
        Call::SetTrapPrm { axis, acc, dec } => {
            let (core, profile) = at(axis);
            let (acc, dec) = (acc.into(), dec.into());
            Wire::of(SetTrapPrm { core, profile, acc, dec, vel_start: 0.0.into(), smooth_time_ms: 0.into() })
        }
        Call::SetJogPrm { axis, acc, dec } => {
            let (core, profile) = at(axis);
            Wire::of(SetJogPrm { core, profile, acc: acc.into(), dec: dec.into(), smooth: 0.0.into() })
        }
        Call::SetPos { axis, pos } => {
            let (core, profile) = at(axis);
            Wire::of(SetPos { core, profile, pos: pos.into() })
        }
        Call::SetVel { axis, vel } => {
            let (core, profile) = at(axis);
            Wire::of(SetVel { core, profile, vel: vel.into() })
        }
        Call::Update { mask } => {
            let (core, mask) = of(mask);
            Wire::of(Update { core, mask })
        }
        Call::PrfPt { axis, mode } => {
            let (core, profile) = at(axis);
            Wire::of(PrfPt { core, profile, mode: mode.into() })
        }
        Call::PtData { axis, pos, time_ms, kind, fifo } => {
            let (core, profile) = at(axis);
            let (pos, time_ms) = (pos.into(), time_ms.into());
            Wire::of(PtData { core, profile, pos, time_ms, kind: kind.into(), fifo: fifo.into() })
        }
        Call::PtClear { axis, fifo } => {
            let (core, profile) = at(axis);
            Wire::of(PtClear { core, profile, fifo: fifo.into() })
        }
        Call::PtSpace { axis, fifo } => {
            let (core, profile) = at(axis);
            Wire::of(PtSpace { core, profile, fifo: fifo.into() })
        }
        Call::SetPtLoop { axis, loops } => {
            let (core, profile) = at(axis);
            Wire::of(SetPtLoop { core, profile, loop_count: loops.into() })
        }
        Call::SetPtMemory { axis, memory } => {
            let (core, profile) = at(axis);
            Wire::of(SetPtMemory { core, profile, memory: memory.into() })
        }
        Call::PtStart { mask, option: fifos } => {
            let (core, bits) = of(mask);
            Wire::of(PtStart { core, mask: bits, option: option(mask, fifos) })
        }
        Call::PrfFollow { axis, dir } => {
            let (core, profile) = at(axis);
            Wire::of(PrfFollow { core, profile, dir: dir.into() })
        }
        Call::SetFollowMaster { axis, master, kind, item } => {
            let (core, profile) = at(axis);
            let (index, kind) = setup.master(axis, master, kind);
            let (master_index, master_type) = (index.into(), kind.into());
            Wire::of(SetFollowMaster { core, profile, master_index, master_type, master_item: item.into() })
        }
        Call::SetFollowLoop { axis, loops } => {
            let (core, profile) = at(axis);
            Wire::of(SetFollowLoop { core, profile, loop_count: loops.into() })
        }
        Call::SetFollowEvent { axis, event, dir, pos } => {
            let (core, profile) = at(axis);
            Wire::of(SetFollowEvent { core, profile, event: event.into(), master_dir: dir.into(), pos: pos.into() })
        }
        Call::FollowData { axis, datum, fifo } => {
            let (core, profile) = at(axis);
            let (master_segment, slave_segment) = ((datum.master as i32).into(), datum.slave.into());
            let (kind, fifo) = (datum.kind.into(), fifo.into());
            Wire::of(FollowData { core, profile, master_segment, slave_segment, kind, fifo })
        }
        Call::FollowClear { axis, fifo } => {
            let (core, profile) = at(axis);
            Wire::of(FollowClear { core, profile, fifo: fifo.into() })
        }
        Call::FollowSpace { axis, fifo } => {
            let (core, profile) = at(axis);
            Wire::of(FollowSpace { core, profile, fifo: fifo.into() })
        }
        Call::FollowStart { mask, option: fifos } => {
            let (core, bits) = of(mask);
            Wire::of(FollowStart { core, mask: bits, option: option(mask, fifos) })
        }
        Call::FollowSwitch { mask } => {
            let (core, mask) = of(mask);
            Wire::of(FollowSwitch { core, mask })
        }
        Call::SetFollowMemory { axis, memory } => {
            let (core, profile) = at(axis);
            Wire::of(SetFollowMemory { core, profile, memory: memory.into() })
        }
        Call::PvtTable { .. }
        | Call::Ex(_)
        | Call::FollowEntry { .. }
        | Call::FollowSwitchNow { .. }
        | Call::Path(_)
        | Call::Light(_)
        | Call::LightTable(_)
        | Call::Sense { .. }
        | Call::PvtCalculate { .. }
        | Call::AsymmetricWay { .. }
        | Call::Abort { .. }
        | Call::Reset { .. }
        | Call::SetTick { .. }
        | Call::Terminal { .. }
        | Call::Guard { .. }
        | Call::SetCapture { .. }
        | Call::Effect(_) => unreachable!("done above"),
        Call::PvtTableSelect { axis, table } => {
            let (core, profile) = at(axis);
            Wire::of(PvtTableSelect { core, profile, table: table.into() })
        }
        Call::SetPvtLoop { axis, loops } => {
            let (core, profile) = at(axis);
            Wire::of(SetPvtLoop { core, profile, loop_count: loops.into() })
        }
        Call::PvtStart { mask } => {
            let (core, mask) = of(mask);
            Wire::of(PvtStart { core, mask })
        }
    }
}

/// A whole table in one message.
/// PvtPercentCalculate or PvtContinuousCalculate of the points of a table.
fn computed(core: i16, points: &Points) -> client::Call {
    let (core, count, first) = (core.into(), (points.count() as i32).into(), 0.into());
    match points {
        Points::Percent(points, begin) => {
            let head = PvtPercentCalculate { core, count, first, vel_begin: (*begin).into() };
            client::Call::with_items(head, &percents(points))
        }
        Points::Continuous(points, _) => {
            client::Call::with_items(PvtContinuousCalculate { core, count, first }, &ramps(points))
        }
        _ => panic!("nothing is computed of {points:?}"),
    }
}

fn percents(points: &[[f64; 3]]) -> Vec<PvtPercentPoint> {
    let item = |&[time, pos, percent]: &[f64; 3]| PvtPercentPoint {
        time: time.into(),
        pos: pos.into(),
        percent: percent.into(),
    };
    points.iter().map(item).collect()
}

fn ramps(points: &[[f64; 6]]) -> Vec<PvtContinuousPoint> {
    let item = |&[pos, vel, percent, vel_max, acc, dec]: &[f64; 6]| PvtContinuousPoint {
        pos: pos.into(),
        vel: vel.into(),
        percent: percent.into(),
        vel_max: vel_max.into(),
        acc: acc.into(),
        dec: dec.into(),
    };
    points.iter().map(item).collect()
}

fn table_of(core: i16, table: i16, points: &Points) -> client::Call {
    use client::Call as Wire;
    let (core, table, count, first) = (core.into(), table.into(), (points.count() as i32).into(), 0.into());
    match points {
        Points::Pvt(points) => {
            let items: Vec<PvtPoint> = points
                .iter()
                .map(|&[time, pos, vel]| PvtPoint { time: time.into(), pos: pos.into(), vel: vel.into() })
                .collect();
            Wire::with_items(PvtTable { core, table, count, first }, &items)
        }
        Points::Ex(points) => {
            let item = |&[time, pos, begin, end]: &[f64; 4]| PvtExPoint {
                time: time.into(),
                pos: pos.into(),
                vel_begin: begin.into(),
                vel_end: end.into(),
            };
            let items: Vec<PvtExPoint> = points.iter().map(item).collect();
            Wire::with_items(PvtTableEx { core, table, count, first }, &items)
        }
        Points::Complete(points, begin, end) => {
            let items: Vec<PvtKnot> =
                points.iter().map(|&[time, pos]| PvtKnot { time: time.into(), pos: pos.into() }).collect();
            let (vel_begin, vel_end) = ((*begin).into(), (*end).into());
            Wire::with_items(PvtTableComplete { core, table, count, first, vel_begin, vel_end }, &items)
        }
        Points::Percent(points, begin) => {
            let head = PvtTablePercent { core, table, count, first, vel_begin: (*begin).into() };
            Wire::with_items(head, &percents(points))
        }
        Points::Continuous(points, begin) => {
            let head = PvtTableContinuous { core, table, count, first, time_begin: (*begin).into() };
            Wire::with_items(head, &ramps(points))
        }
    }
}

type I16 = zerocopy::little_endian::I16;

fn plain(kind: Kind, (core, axis): (I16, I16)) -> client::Call {
    use client::Call as Wire;
    let (profile, count) = (axis, 1.into());
    match kind {
        Kind::AxisOn => Wire::of(AxisOn { core, axis }),
        Kind::AxisOff => Wire::of(AxisOff { core, axis }),
        Kind::ZeroPos => Wire::of(ZeroPos { core, axis, count }),
        Kind::ClrSts => Wire::of(ClrSts { core, axis, count }),
        Kind::PrfTrap => Wire::of(PrfTrap { core, profile }),
        Kind::PrfJog => Wire::of(PrfJog { core, profile }),
        Kind::PrfPvt => Wire::of(PrfPvt { core, profile }),
        Kind::GetPvtLoop => Wire::of(GetPvtLoop { core, profile }),
        Kind::GetPtLoop => Wire::of(GetPtLoop { core, profile }),
        Kind::GetFollowLoop => Wire::of(GetFollowLoop { core, profile }),
        Kind::GetFollowStatus => Wire::of(GetFollowStatus { core, profile }),
        Kind::GetFollowLoopEx => Wire::of(GetFollowLoopEx { core, profile }),
        Kind::GetFollowStatusEx => Wire::of(GetFollowStatusEx { core, profile }),
        Kind::GetFollowMemory => Wire::of(GetFollowMemory { core, profile }),
        Kind::GetFollowMemoryEx => Wire::of(GetFollowMemoryEx { core, profile }),
        Kind::GetFollowEvent => Wire::of(GetFollowEvent { core, profile }),
        Kind::GetFollowEventEx => Wire::of(GetFollowEventEx { core, profile }),
        Kind::GetFollowMaster => Wire::of(GetFollowMaster { core, profile }),
        Kind::GetFollowMasterEx => Wire::of(GetFollowMasterEx { core, profile }),
        Kind::GetEncPos => Wire::of(GetEncPos { core, encoder: profile, count }),
        Kind::GetSts => Wire::of(GetSts { core, axis, count }),
        Kind::GetStopReason => Wire::of(AxisStatus { core, axis, count }),
        Kind::GetCaptureStatus => Wire::of(GetCaptureStatus { core, encoder: profile, count }),
        Kind::GetPrfPos => Wire::of(GetPrfPos { core, profile, count }),
        Kind::GetPrfVel => Wire::of(GetPrfVel { core, profile, count }),
        Kind::GetPrfMode => Wire::of(GetPrfMode { core, profile, count }),
        Kind::GetPrfAcc => Wire::of(GetPrfAcc { core, profile, count }),
        Kind::GetEncVel => Wire::of(GetEncVel { core, encoder: profile, count }),
        Kind::GetTrapPrm => Wire::of(GetTrapPrm { core, profile }),
        Kind::GetJogPrm => Wire::of(GetJogPrm { core, profile }),
        Kind::GetPos => Wire::of(GetPos { core, profile }),
        Kind::GetVel => Wire::of(GetVel { core, profile }),
        Kind::GetSoftLimit => Wire::of(GetSoftLimit { core, axis }),
        Kind::GetStopDec => Wire::of(GetStopDec { core, profile }),
        Kind::GetAxisBand => Wire::of(GetAxisBand { core, axis }),
        Kind::GetPosErr => Wire::of(GetPosErr { core, control: profile }),
        Kind::GetPtMemory => Wire::of(GetPtMemory { core, profile }),
        Kind::PvtStatus => Wire::of(PvtStatus { core, profile, count }),
    }
}

/// A set-point as the reference has it.
pub fn fixed(units: i64) -> Fix {
    Fix::of_position(units)
}
