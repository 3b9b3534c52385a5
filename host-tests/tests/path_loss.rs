//! The link is lost while a path runs and its look-ahead holds entries: light goes off, the path
//! brakes along its way to rest, nothing more is executed, and the reason can be read. With the
//! fault cleared a start goes on to the end, and every entry has had its effect once. `LOSSES` sets
//! how many random paths there are.
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
#[path = "path/machine.rs"]
mod machine;

use chance::Chance;
use client::{Client, Link, Options};
use host_tests::laser_model::Family;
use machine::{Machine, numbered};
use plant::beam::SignalChange;
use protocol::command::{ClrLaserFault, CrdInfo, CrdStart, GetEvents, GetLaserFault, SetLinkLoss};
use std::fmt::Write;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use virtual_board::{Output, Shared, VirtualLink};

const TICK_NS: u64 = 50_000;
const MS: u64 = 1_000_000;
/// After the loss, ms: longer than any braking.
const DARK_AFTER_MS: u64 = 400;

struct Path {
    /// The set-up, and the entries of each motion.
    text: String,
    lines: Vec<String>,
    points: Vec<[f64; 2]>,
    /// Edges of the output that the entries make.
    edges: usize,
    stop_dec: f64,
}

/// A way that wanders, now and then with a sharp corner; light from the first line on.
fn path(chance: &mut Chance, motions: usize) -> Path {
    let acc = chance.log(1.0, 5.0);
    let stop_dec = acc * (1.0 + 2.0 * chance.unit());
    let mut text = String::from("TCrdPrm crd;memset(&crd,0,sizeof(crd));\n");
    text += "GT_AxisOn(1);\nGT_AxisOn(2);\nGT_LmtsOff(1);\nGT_LmtsOff(2);\nGT_LaserPowerMode(2,10,0,0,1);\nGT_LaserPrfCmd(5,0);\n";
    text += "crd.dimension=2;\ncrd.profile[0]=1;\ncrd.profile[1]=2;\ncrd.setOriginFlag=1;\ncrd.synVelMax=300;\n";
    write!(text, "crd.synAccMax={acc:?};\nGT_SetCrdPrm(1,&crd);\nGT_CrdClear(1,0);\n").unwrap();
    write!(text, "GT_SetCrdStopDec(1,{stop_dec:?},30000);\nGT_InitLookAhead(1,0,5,{acc:?},200);\n").unwrap();
    text += "GT_BufLaserOn(1,0,0);\n";
    let mut points = vec![[0.0, 0.0]];
    let (mut x, mut y, mut angle, mut bend) = (0.0f64, 0.0f64, chance.unit() * 6.0, 0.0f64);
    let (mut on, mut edges, mut lines) = (false, 0, Vec::new());
    for _ in 0..motions {
        bend = 0.9 * bend + 0.02 * (chance.unit() - 0.5);
        angle += bend + if chance.below(40) == 0 { 2.0 * chance.unit() } else { 0.0 };
        let length = chance.log(60.0, 200.0);
        (x, y) = ((x + length * angle.cos()).round(), (y + length * angle.sin()).round());
        points.push([x, y]);
        let mut line = format!("GT_LnXY(1,{x},{y},300,{acc:?},0,0);\n");
        if chance.below(10) == 0 {
            on = !on;
            edges += 1;
            writeln!(line, "GT_BufIO(1,12,1,{},0);", u8::from(on)).unwrap();
        }
        lines.push(line);
    }
    Path { text, lines, points, edges, stop_dec }
}

/// How far along the points each place is, and that it is on the way there.
fn ways(points: &[[f64; 2]], places: &[[f64; 2]]) -> Result<Vec<f64>, String> {
    let (mut index, mut before) = (0, 0.0);
    let mut ways = Vec::new();
    for place in places {
        loop {
            let Some([from, to]) = points.get(index..index + 2) else {
                return Err(format!("{place:?} is on no motion"));
            };
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let length = dx.hypot(dy);
            let (px, py) = (place[0] - from[0], place[1] - from[1]);
            let (along, across) = ((px * dx + py * dy) / length, (px * dy - py * dx) / length);
            if across.abs() <= 1e-3 && (-1e-3..=length + 1e-3).contains(&along) {
                ways.push(before + along);
                break;
            }
            before += length;
            index += 1;
        }
    }
    Ok(ways)
}

/// What happens on the link between client and controller.
#[derive(Default)]
struct LinkRecord {
    /// From this instant on nothing comes through.
    cut: Option<u64>,
    /// When something did last.
    heard: u64,
    /// Where the axes were at each tick from the cut on.
    places: Vec<[f64; 2]>,
}

struct Over {
    link: VirtualLink,
    board: Shared,
    record: Arc<Mutex<LinkRecord>>,
}

impl Over {
    fn is_cut(&self) -> bool {
        let now = self.board.lock().unwrap().now();
        self.record.lock().unwrap().cut.is_some_and(|cut| now >= cut)
    }
}

impl Link for Over {
    fn name(&self) -> &str {
        "a link that is cut"
    }

    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        if self.is_cut() {
            return Ok(());
        }
        self.record.lock().unwrap().heard = self.board.lock().unwrap().now();
        self.link.send(bytes)
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        if !self.is_cut() {
            let now = self.board.lock().unwrap().now();
            let until = self.record.lock().unwrap().cut.map_or(wait, |cut| wait.min(Duration::from_nanos(cut - now)));
            return self.link.receive(buf, until);
        }
        let mut board = self.board.lock().unwrap();
        let mut nowhere = Vec::new();
        let end = board.now() + wait.as_nanos().max(1) as u64;
        while board.now() < end {
            let tick = board.now();
            while board.now() == tick {
                board.advance(TICK_NS, &mut nowhere);
            }
            let place = [0, 1].map(|axis| board.set_point(axis) as f64 / f64::from(1 << 22));
            self.record.lock().unwrap().places.push(place);
        }
        Ok(0)
    }

    fn now(&mut self) -> u64 {
        self.link.now()
    }

    fn real_time(&self) -> bool {
        false
    }

    fn has_trace(&self) -> bool {
        true
    }

    fn take_trace(&mut self, out: &mut Vec<u8>) -> client::Result<()> {
        self.link.take_trace(out)
    }
}

/// What the outputs did: edges of the switch, of the voltage being there; how many of general
/// outputs.
fn take(board: &Shared, lit: &mut Vec<(u64, bool)>) -> usize {
    let mut board = board.lock().unwrap();
    for beam in board.take_beam() {
        match beam.change {
            SignalChange::Switch { at, level } => lit.push((at, level)),
            SignalChange::Dac { at, code } => lit.push((at, code != 0)),
            SignalChange::Energy { at, level } => lit.push((at, level)),
            SignalChange::Pulses(_) => lit.push((u64::MAX, true)),
        }
    }
    board.take_edges().iter().filter(|edge| matches!(edge.output, Output::General(_))).count()
}

/// Both outputs go off at the loss and stay so: within the tick that learns of it.
fn dark(before: &[(u64, bool)], after: &[(u64, bool)], lost: u64) -> Result<(), String> {
    let reported = || format!("lost at {lost}: light {before:?}, then {after:?}");
    let good = before.last().is_some_and(|edge| edge.1)
        && after.len() == 2
        && after.iter().all(|&(at, on)| !on && (lost..=lost + 2 * TICK_NS).contains(&at));
    if good { Ok(()) } else { Err(reported()) }
}

/// It brakes along its way from tick `lost` on, no harder than a Stop does and no longer. The
/// hardest, as a part of that.
fn brakes(path: &Path, places: &[[f64; 2]], lost: usize) -> Result<f64, String> {
    let tick = TICK_NS as f64 / 1e6;
    let ways = ways(&path.points, places)?;
    let speed = |k: usize| (ways[k + 1] - ways[k]) / tick;
    let rest = (0..places.len()).rev().find(|&k| places[k] != places[places.len() - 1]).map_or(0, |k| k + 1);
    let v = speed(lost);
    // Constant braking takes the longest, but for corners that are nearer.
    let most = (v / path.stop_dec / tick) as usize + 4;
    if rest <= lost || rest - lost > most || rest + 1000 > places.len() {
        return Err(format!(
            "lost at tick {lost} at {v} pulse/ms, at rest at {rest}, {most} ticks with {}",
            path.stop_dec
        ));
    }
    let second = |k: usize| (speed(k + 1) - speed(k)) / tick / path.stop_dec;
    let hardest = (lost..rest).map(|k| -second(k)).fold(0.0, f64::max);
    let fastest = (lost + 3..rest).map(second).fold(0.0, f64::max);
    if hardest > 1.001 || fastest > 1e-3 {
        return Err(format!("it brakes with {hardest} and speeds up with {fastest} of {}", path.stop_dec));
    }
    Ok(hardest)
}

fn info(client: &Client) -> protocol::command::CrdState {
    client.call(CrdInfo { core: 1.into(), crd: 1.into() }).unwrap()
}

/// What can be read when the link is there again; and that nothing goes on by itself.
fn readable(client: &Client, at: [f64; 2]) -> Result<(), String> {
    let after = info(client);
    let fault = client.call(GetLaserFault { core: 1.into(), channel: 0.into() }).unwrap().value.get();
    if ({ after.run }, { after.path_stop }, { after.reason }.get(), fault) != (0, 3, 13, 2) {
        return Err(format!("{after:?}, fault {fault}"));
    }
    client.sleep(Duration::from_millis(100)).unwrap();
    let still = info(client);
    let moved = [0, 1].map(|axis| ({ still.pos }[axis].get() - at[axis]).abs() > 1e-6) != [false; 2];
    if moved || { still.segments }[0] != { after.segments }[0] {
        return Err(format!("it goes on by itself: {at:?}, {after:?}, {still:?}"));
    }
    let (_, events) = client.call_items(GetEvents {}, &[]).unwrap();
    // A coordinate system that rests otherwise than by reaching its end, and a laser that goes
    // dark.
    let reported = |reason: u16| events.iter().any(|event| event.reason.get() == reason);
    if reported(13) && reported(2) { Ok(()) } else { Err(format!("no event tells it: {events:?}")) }
}

fn machine(limit: u64) -> (Machine, Arc<Mutex<LinkRecord>>) {
    let record: Arc<Mutex<LinkRecord>> = Arc::default();
    let machine = Machine::over(Family::Gus, TICK_NS as i64, |board| {
        Box::new(Over { link: VirtualLink::new(board.clone()), board, record: Arc::clone(&record) })
    });
    machine.client.call(SetLinkLoss { time_ms: (limit as i32).into(), stop_all: 0.into() }).unwrap();
    (machine, record)
}

/// Everything is given before the start; the program is over when the link goes.
fn left(chance: &mut Chance, path: &Path) -> Result<f64, String> {
    let limit = 20 + chance.below(60);
    let (machine, record) = machine(limit);
    let client = &machine.client;
    let ran = machine.run(&(path.text.clone() + &path.lines.concat() + "GT_CrdStart(1,0);\n"));
    let mut done = ran.outputs.len();
    let mut lit: Vec<_> = ran.lasers[0].switch.clone().into_iter().map(|(at, on)| (at as u64, on)).collect();
    let runs = 5 + chance.below(150);
    for _ in 0..runs {
        client.sleep(Duration::from_millis(1)).unwrap();
        info(client);
    }
    done += take(&machine.board, &mut lit);
    let before = info(client);
    if before.run != 1 || { before.space }[0].get() > 1024 - 60 {
        return Err(format!("nothing is held at the loss, after {runs} ms: {before:?}"));
    }
    let cut = machine.board.lock().unwrap().now();
    record.lock().unwrap().cut = Some(cut);
    client.sleep(Duration::from_millis(limit + DARK_AFTER_MS)).unwrap();
    let LinkRecord { heard, places, .. } = std::mem::take(&mut *record.lock().unwrap());
    let mut after = Vec::new();
    done += take(&machine.board, &mut after);
    dark(&lit, &after, heard + limit * MS)?;
    let hardest = brakes(path, &places, ((heard + limit * MS).saturating_sub(cut) / TICK_NS) as usize)?;
    readable(client, places[places.len() - 1])?;
    // On to the end.
    client.call(ClrLaserFault { core: 1.into(), channel: 0.into() }).unwrap();
    client.call(CrdStart { core: 1.into(), mask: 1.into(), option: 0.into() }).unwrap();
    for _ in 0..4000 {
        client.sleep(Duration::from_millis(1)).unwrap();
        if info(client).run == 0 {
            break;
        }
    }
    let end = info(client);
    let mut again: Vec<(u64, bool)> = Vec::new();
    done += take(&machine.board, &mut again);
    let to = path.points[path.lines.len()];
    if { end.path_stop } != 1
        || { end.segments }[0].get() != path.lines.len() as i32
        || [0, 1].map(|k| { end.pos }[k].get()) != to
    {
        return Err(format!("it does not go on: {end:?}"));
    }
    if !again.first().is_some_and(|edge| edge.1) || again.last().is_some_and(|edge| edge.1) || done != path.edges {
        return Err(format!("{done} edges of {}, light {again:?}", path.edges));
    }
    Ok(hardest)
}

/// A program streams while the link goes.
fn streaming(chance: &mut Chance, path: &Path) -> Result<f64, String> {
    let limit = 200 + chance.below(100);
    let (machine, record) = machine(limit);
    let mut text = path.text.clone();
    for (index, line) in path.lines.iter().enumerate() {
        text += line;
        if index == 250 {
            text += "GT_CrdStart(1,0);\nSleep(30);\n";
        } else if index > 250 && index % 20 == 0 {
            text += "Sleep(5);\n";
        }
    }
    // Longer than any loss.
    text += "Sleep(1000);\nGT_BufIO(1,12,2,2,0);\nGT_SetDoBit(12,2,0);\nWaitStop(256);\n";
    machine.board.lock().unwrap().take_beam();
    let cut = machine.board.lock().unwrap().now() + (80 + chance.below(100)) * MS;
    record.lock().unwrap().cut = Some(cut);
    let failed = machine.try_run(&text).err().ok_or("nothing failed")?;
    let heard = record.lock().unwrap().heard;
    let lost = heard + limit * MS;
    let mut all = Vec::new();
    take(&machine.board, &mut all);
    let (before, after): (Vec<_>, Vec<_>) = all.into_iter().partition(|edge| edge.0 < lost);
    dark(&before, &after, lost).map_err(|reported| format!("{failed}: {reported}"))?;
    let places = std::mem::take(&mut record.lock().unwrap().places);
    let hardest = brakes(path, &places, (lost.saturating_sub(cut) / TICK_NS) as usize)?;
    // The host ends its session and opens another one.
    record.lock().unwrap().cut = None;
    let Machine { board, client: gone, .. } = machine;
    drop(gone);
    let client = &Client::open(Box::new(VirtualLink::new(board.clone())), Options::default()).unwrap();
    readable(client, places[places.len() - 1])?;
    client.sleep(Duration::from_millis(1500)).unwrap();
    let mut late = Vec::new();
    let edges = take(&board, &mut late);
    if edges != 0 || !late.is_empty() || info(client).run != 0 {
        return Err(format!("the program goes on: {edges} edges, light {late:?}"));
    }
    Ok(hardest)
}

fn losses(motions: usize, check: impl Fn(&mut Chance, &Path) -> Result<f64, String>) {
    let count: u64 = std::env::var("LOSSES").map_or(30, |text| text.parse().expect("a number"));
    let mut hardest = 0.0f64;
    for number in 0..count {
        let chance = &mut Chance::new(number);
        let path = path(chance, motions);
        let seen = check(chance, &path).unwrap_or_else(|reason| {
            panic!("path {number}: {reason}\n{}", numbered(&(path.text.clone() + &path.lines.concat())))
        });
        hardest = hardest.max(seen);
    }
    println!("{count} losses; braking with at most {hardest:.4} of the deceleration of Stops");
    assert!(hardest > 0.99);
}

#[test]
fn a_path_with_a_look_ahead_ends_dark_and_at_rest_and_goes_on() {
    losses(500, left);
}

#[test]
fn a_program_with_a_look_ahead_ends_dark_and_at_rest() {
    losses(1000, streaming);
}
