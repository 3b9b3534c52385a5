//! Two coordinate systems at once through the whole machine, each on four axes, with lines, arcs,
//! light and an output of its own, and with starts, Stops and overrides of its own; and arcs of any
//! size. Positions of every axis are held to the model at every tick, arcs to their circle, edges
//! of light and outputs to 5 ns. `PAIRS` and `ARCS` set how many jobs there are.
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
#[path = "path/machine.rs"]
mod machine;
#[path = "path/random.rs"]
mod random;

use chance::Chance;
use host_tests::laser_model::{Command, Edge, Exact, Family, Mode, Ns, outcome};
use host_tests::light_model::{Act, Buffered, light};
use host_tests::path_model::{self, Course, Entry, Geometry, Why, course};
use machine::{Beams, Machine, Reported, numbered};
use random::{Effect, Random, arcs, fits, is_undecided, random, set_up};
use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

const MS: Ns = 1_000_000;
const TICKS: [Ns; 4] = [100_000, 250_000, 500_000, MS];
/// What an edge may be off, ns.
const SLACK: Ns = 5;
/// What a place may be off, pulses; and what its instant may be, ms.
const OFF: (f64, f64) = (1e-3, 1.1e-6);

/// A path and what it does.
struct Half {
    path: Random,
    stop_dec: f64,
    /// Instants in ms.
    commands: Vec<(f64, path_model::Command)>,
    course: Course,
}

impl Half {
    fn of(path: Random, chance: &mut Chance) -> Half {
        // Above what the motions brake with: a Stop never ends on a boundary by itself.
        let stop_dec = path.frame.acc * (1.3 + 3.0 * chance.unit());
        let commands = vec![(0.0, path_model::Command::StopDec(stop_dec))];
        Half { path, stop_dec, commands, course: Course::default() }
    }

    fn command(&mut self, at: f64, command: path_model::Command) {
        self.commands.push((at, command));
        self.course = course(&self.path.frame, &self.path.entries, &self.commands, 1e9);
    }
}

struct Made {
    text: String,
    halves: Vec<Half>,
    /// What acts on each channel.
    acts: [Vec<(Ns, Act)>; 2],
    /// Buffered laser entries that name a channel whose map does not hold their coordinate system.
    refused: usize,
    horizon: Ns,
}

fn begin(halves: &[Half]) -> String {
    let mut text = String::from("TCrdPrm crd;memset(&crd,0,sizeof(crd));\n");
    for axis in 1..=8 {
        writeln!(text, "GT_AxisOn({axis});\nGT_LmtsOff({axis});").unwrap();
    }
    for (crd, half) in halves.iter().enumerate() {
        text += &set_up(&half.path.frame, half.path.dimensions, crd);
        writeln!(text, "GT_CrdClear({},0);\nGT_SetCrdStopDec({},{:?},30000);", crd + 1, crd + 1, half.stop_dec)
            .unwrap();
    }
    text
}

/// What happens to a path from outside.
#[derive(Debug, Clone, Copy)]
enum Outside {
    Start,
    Stop {
        abrupt: bool,
    },
    Override(f64),
    /// An immediate on or off for the channel with its number.
    Light(bool),
}

/// Where a path may be stopped and when it goes on: ms of the script clock.
fn outside(chance: &mut Chance, half: &mut Half, start: Ns, tick: Ns) -> Vec<(Ns, Outside)> {
    let at = |clock: Ns| (clock + tick) as f64 / 1e6;
    let mut events = vec![(start, Outside::Start)];
    half.command(at(start), path_model::Command::Start);
    let runs = |half: &Half| (half.course.rests.last().unwrap().at - at(start)).ceil().max(2.0) as u64;
    let mut clock = start;
    if half.path.frame.even_ms == 0.0 && chance.below(3) == 0 {
        clock += (1 + chance.below(runs(half))) as Ns * MS;
        let rate = [0.3, 0.5, 0.75][chance.below(3) as usize];
        half.command(at(clock), path_model::Command::Rate(rate));
        events.push((clock, Outside::Override(rate)));
    }
    if chance.below(2) == 0 {
        clock += (1 + chance.below(runs(half))) as Ns * MS;
        let abrupt = chance.below(3) == 0;
        half.command(
            at(clock),
            if abrupt { path_model::Command::Abrupt(tick as f64 / 1e6) } else { path_model::Command::Stop },
        );
        events.push((clock, Outside::Stop { abrupt }));
        let rest = half.course.rests.last().unwrap();
        if rest.why == Why::Stopped {
            clock = (rest.at.ceil() as Ns + 1 + chance.below(5) as Ns) * MS;
            half.command(at(clock), path_model::Command::Start);
            events.push((clock, Outside::Start));
        }
    }
    events
}

fn ns(ms: f64) -> Ns {
    (ms * 1e6).round() as Ns
}

fn attempt(chance: &mut Chance, tick: Ns) -> Option<Made> {
    let mut halves: Vec<Half> = (0..2)
        .map(|crd| random(chance, [0.0; 4], 12, crd))
        .collect::<Vec<_>>()
        .into_iter()
        .map(|path| Half::of(path, chance))
        .collect();
    let mut text = String::from("#pragma continue\nshort rtn;\n") + &begin(&halves);
    let mut acts: [Vec<(Ns, Act)>; 2] = Default::default();
    let mut refused = 0;
    let mut later = String::new();
    for (channel, acts) in acts.iter_mut().enumerate() {
        let (own, other) = (1 << channel, 2 >> channel);
        let (map, then) = match chance.below(8) {
            0..3 => (own, None),
            3..6 => (own | other, None),
            // The entries come when the map no longer holds their coordinate system.
            6 => (own | other, Some(other)),
            _ => (other, None),
        };
        write!(text, "GT_LaserPowerMode(2,10,0,{channel},1);\nGT_SetLevelDelay(0,0,{channel});\n").unwrap();
        writeln!(text, "GT_SetLaserCrdMap({channel},{map});").unwrap();
        let (max, min) = (Exact::from_integer(10), Exact::from_integer(0));
        for act in [
            Act::Own(Command::PowerMode { mode: Mode::Analog, max, min, delayed: true }),
            Act::Own(Command::Delays { off: 0, on: 0 }),
            Act::Map(map),
        ] {
            acts.push((tick, act));
        }
        if let Some(map) = then {
            writeln!(later, "GT_SetLaserCrdMap({channel},{map});").unwrap();
            acts.push((2 * MS + tick, Act::Map(map)));
        }
        if map == other {
            let path = &mut halves[channel].path;
            refused += path.text.matches("GT_BufLaser").count();
            path.text = path.text.replace("GT_BufLaser", "rtn = GT_BufLaser");
        }
    }
    // Data for both, mixed.
    text += "Sleep(2);\n";
    let mut lines = halves.iter().map(|half| half.path.text.lines()).collect::<Vec<_>>();
    while let Some(line) = {
        let first = chance.below(2) as usize;
        lines[first].next().or_else(|| lines[1 - first].next())
    } {
        text += line;
        text += "\n";
    }
    text += &later;
    let starts = [4, [4, 4, 5, 9][chance.below(4) as usize]];
    let mut events: Vec<(Ns, usize, Outside)> = Vec::new();
    for (crd, half) in halves.iter_mut().enumerate() {
        let own = outside(chance, half, starts[crd] * MS, tick);
        events.extend(own.into_iter().map(|(at, event)| (at, crd, event)));
        let good = |why: Why| why != Why::Underrun;
        let free = course(&half.path.frame, &half.path.entries, &half.commands[..2], 1e9);
        if !half.course.rests.iter().chain(&free.rests).all(|rest| good(rest.why))
            || !fits(&half.course, half.commands[1].0, 64)
            || is_undecided(&half.course)
        {
            return None;
        }
    }
    let last = events.iter().map(|event| event.0).max()? / MS + 10;
    for channel in 0..2 {
        for _ in 0..chance.below(8).saturating_sub(4) {
            let at = (3 + chance.below(last as u64)) as Ns * MS;
            // Two of an instant would be in an order that the models do not tell.
            if events.iter().all(|event| event.0 != at) {
                events.push((at, channel, Outside::Light(chance.below(2) == 0)));
            }
        }
    }
    events.sort_by_key(|event| event.0);
    let mut clock = 2 * MS;
    let mut index = 0;
    while let Some(&(at, crd, event)) = events.get(index) {
        if at > clock {
            writeln!(text, "Sleep({});", (at - clock) / MS).unwrap();
            clock = at;
        }
        index += 1;
        let number = crd + 1;
        match event {
            // Both by one call.
            Outside::Start if matches!(events.get(index), Some(&(same, 1, Outside::Start)) if same == at && crd == 0) =>
            {
                text += "GT_CrdStart(3,0);\n";
                index += 1;
            }
            Outside::Start => writeln!(text, "GT_CrdStart({number},0);").unwrap(),
            Outside::Stop { abrupt } => {
                let mask = 256 << crd;
                writeln!(text, "GT_Stop({mask},{});", if abrupt { mask } else { 0 }).unwrap();
                let rests = halves[crd].course.rests.iter().any(|rest| ns(rest.at) == at + tick);
                for acts in &mut acts {
                    acts.push((at + tick, Act::Stops { crd: crd as u8 }));
                    // At once, before what else comes at this instant.
                    acts.extend(rests.then_some((at + tick, Act::Rests { crd: crd as u8, stopped: true })));
                }
            }
            Outside::Light(on) => {
                writeln!(text, "GT_SetHSIOOpt({},{crd});", u8::from(on)).unwrap();
                acts[crd].push((at + tick, Act::Own(Command::Gate(on))));
            }
            Outside::Override(rate) => writeln!(text, "GT_SetOverride({number},{rate:?});").unwrap(),
        }
    }
    for (crd, half) in halves.iter().enumerate() {
        for acts in &mut acts {
            let starts = half.course.starts.iter();
            acts.extend(starts.map(|&(at, resumes)| (ns(at), Act::Starts { crd: crd as u8, resumes })));
        }
        for &(at, effect) in &half.course.effects {
            let act = match half.path.effects[effect] {
                Effect::Gate(on) => Buffered::Gate(on),
                Effect::Power(mv) => Buffered::Power(f64::from(mv) / 1000.0),
                Effect::Output(_) => continue,
            };
            acts[crd].push((ns(at), Act::Entry(crd as u8, act)));
        }
    }
    for acts in &mut acts {
        for (crd, half) in halves.iter().enumerate() {
            for rest in &half.course.rests {
                let act = Act::Rests { crd: crd as u8, stopped: rest.why == Why::Stopped };
                if !acts.contains(&(ns(rest.at), act.clone())) {
                    acts.push((ns(rest.at), act));
                }
            }
        }
        acts.sort_by_key(|(at, _)| *at);
    }
    let last = halves.iter().map(|half| half.course.rests.last().unwrap().at).fold(0.0, f64::max);
    let horizon = ((last.ceil() as Ns + 3) * MS).max(clock + 3 * MS);
    writeln!(text, "Sleep({});", (horizon - clock) / MS).unwrap();
    Some(Made { text, halves, acts, refused, horizon })
}

/// Edges equal to 5 ns.
fn same<T: Copy + PartialEq + std::fmt::Debug>(
    what: &str,
    mine: &[Edge<T>],
    theirs: &[Edge<T>],
) -> Result<usize, String> {
    let differ = (0..mine.len().max(theirs.len())).find(|&index| match (mine.get(index), theirs.get(index)) {
        (Some(a), Some(b)) => (a.0 - b.0).abs() > SLACK || a.1 != b.1,
        _ => true,
    });
    differ.map_or(Ok(mine.len()), |index| {
        Err(format!("{what}, edge {index}: {:?}, the model {:?}", theirs.get(index), mine.get(index)))
    })
}

fn laser(family: Family, channel: usize, made: &Made, beams: &Beams) -> Result<usize, String> {
    let light = light(family, &made.acts[channel]);
    let outcome = outcome(family, &light.job, made.horizon);
    let mut instants: Vec<Ns> = outcome.light.iter().flat_map(|span| [span.begin, span.end]).collect();
    instants.extend(light.powers.iter().map(|(at, _)| *at).filter(|at| *at > 0));
    instants.retain(|at| *at < made.horizon);
    instants.sort_unstable();
    let mut volts: Vec<Edge<i16>> = Vec::new();
    for at in instants {
        let lit = outcome.light.iter().any(|span| span.begin <= at && at < span.end);
        let code = if lit { (light.power(at).direct * 3276.7 + 0.5).floor() as i16 } else { 0 };
        if volts.last().map_or(0, |last| last.1) != code {
            volts.push((at, code));
        }
    }
    let all = |edges: &[Edge<bool>]| edges.iter().copied().filter(|edge| edge.0 < made.horizon).collect::<Vec<_>>();
    Ok(same(&format!("switch {channel}"), &all(&outcome.switch), &all(&beams.switch))?
        + same(&format!("voltage {channel}"), &volts, &beams.volts)?)
}

fn outputs(made: &Made, reported: &Reported) -> Result<usize, String> {
    let mut seen = 0;
    for (crd, half) in made.halves.iter().enumerate() {
        let mut mine: Vec<Edge<bool>> = Vec::new();
        for &(at, effect) in &half.course.effects {
            if let Effect::Output(on) = half.path.effects[effect]
                && mine.last().is_some_and(|last| last.1) != on
            {
                mine.push((ns(at), on));
            }
        }
        // Two edges of an instant are none.
        let mut left: Vec<Edge<bool>> = Vec::new();
        for edge in mine {
            if left.pop_if(|last| last.0 == edge.0).is_none() {
                left.push(edge);
            }
        }
        let theirs: Vec<_> = reported
            .outputs
            .iter()
            .filter(|edge| usize::from(edge.1) == crd + 1)
            .map(|edge| (edge.0, edge.2))
            .collect();
        seen += same(&format!("output {}", crd + 1), &left, &theirs)?;
    }
    Ok(seen)
}

/// The motion in force.
fn geometry(half: &Half, ms: f64) -> Option<&Geometry> {
    let mut motions = half
        .path
        .entries
        .iter()
        .filter_map(|entry| if let Entry::Motion(geometry, _) = entry { Some(geometry) } else { None });
    motions.nth(half.course.ends.partition_point(|end| *end <= ms))
}

/// The greatest distances from the model and from the circles of arcs, pulses.
fn places(made: &Made, reported: &Reported) -> Result<[f64; 2], String> {
    let mut worst = [0.0f64; 2];
    for row in reported.rows.iter().filter(|row| (row.t_ns as Ns) < made.horizon) {
        let ms = row.t_ns as f64 / 1e6;
        for (crd, half) in made.halves.iter().enumerate() {
            let expected = half.course.position(&half.path.entries, ms).unwrap_or([0.0; 4]);
            let found: [f64; 4] =
                std::array::from_fn(|axis| row.axes[crd * 4 + axis].pos.0 as f64 / f64::from(1 << 22));
            let speed = half.course.speed(ms).max(half.course.speed(ms - OFF.1));
            for axis in 0..4 {
                let off = (found[axis] - expected[axis]).abs();
                if off > OFF.0 + speed * OFF.1 {
                    return Err(format!("crd {}, axis {axis} at {ms} ms: {found:?}, the model {expected:?}", crd + 1));
                }
                worst[0] = worst[0].max(off);
            }
            let Some(Geometry::Arc { plane, centre, radius, .. }) = geometry(half, ms) else { continue };
            let (first, second) = plane.axes();
            // Before it begins it may stand anywhere on the one before.
            if half.course.speed(ms) > 0.0 && half.course.speed(ms - OFF.1) > 0.0 && half.course.speed(ms + OFF.1) > 0.0
            {
                let off = ((found[first] - centre.0).hypot(found[second] - centre.1) - radius).abs();
                if off > OFF.0 {
                    return Err(format!("crd {} is {off} off its circle at {ms} ms: {found:?}", crd + 1));
                }
                worst[1] = worst[1].max(off);
            }
        }
    }
    Ok(worst)
}

fn check(machine: &Machine, made: &Made) -> Result<(usize, [f64; 2]), String> {
    machine.reset();
    let reported = machine.try_run(&made.text)?;
    if reported.rows.len() < (made.horizon / machine.tick_ns) as usize {
        return Err(format!("{} rows", reported.rows.len()));
    }
    let codes: Vec<i16> = reported.answers.iter().map(|(_, answer)| answer.code).filter(|code| *code != 0).collect();
    if codes != vec![1; made.refused] {
        return Err(format!("refused: {codes:?}, the model {}", made.refused));
    }
    let mut edges = outputs(made, &reported)?;
    for (channel, beams) in reported.lasers.iter().enumerate() {
        edges += laser(machine.family, channel, made, beams)?;
    }
    Ok((edges, places(made, &reported)?))
}

/// Jobs below `count`, shared among the cores: edges, and the greatest distances.
fn run(count: u64, make: impl Fn(&mut Chance, Ns) -> Option<Made> + Sync) -> (usize, [f64; 2]) {
    let next = AtomicU64::new(0);
    let found = std::sync::Mutex::new((0, [0.0f64; 2]));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                let machines = [Family::Gus, Family::Lsr].map(|family| {
                    TICKS.map(|tick| Machine::new(family, tick).traced(0xff, 0)).into_iter().collect::<Vec<_>>()
                });
                loop {
                    let number = next.fetch_add(1, Relaxed);
                    if number >= count {
                        break;
                    }
                    let chance = &mut Chance::new(number);
                    let machine = &machines[chance.below(2) as usize][chance.below(4) as usize];
                    let made = loop {
                        if let Some(made) = make(chance, machine.tick_ns) {
                            break made;
                        }
                    };
                    let (edges, off) = check(machine, &made).unwrap_or_else(|reason| {
                        let tick = machine.tick_ns;
                        panic!("job {number}, tick {tick}, {:?}: {reason}\n{}", machine.family, numbered(&made.text))
                    });
                    let mut found = found.lock().unwrap();
                    *found = (found.0 + edges, [0, 1].map(|index: usize| found.1[index].max(off[index])));
                }
            });
        }
    });
    found.into_inner().unwrap()
}

fn jobs(name: &str, usual: u64) -> u64 {
    std::env::var(name).map_or(usual, |text| text.parse().expect("a number"))
}

#[test]
fn two_coordinate_systems_at_once_are_the_models() {
    let count = jobs("PAIRS", 60);
    let (edges, off) = run(count, attempt);
    println!("{count} jobs: {edges} edges, places at most {off:?} pulses off the model and off arcs");
    assert!(edges as u64 > count * 2);
}

/// SPEC 5, issue 5: arcs hold their radius to 10⁻³ pulse.
#[test]
fn arcs_of_any_size_hold_their_circle() {
    let count = jobs("ARCS", 20);
    let (_, off) = run(count, |chance, tick| {
        let paths = [0, 1].map(|crd| arcs(chance, [0.0; 4], 4, crd));
        let mut halves: Vec<Half> = paths.into_iter().map(|path| Half::of(path, chance)).collect();
        let mut text = begin(&halves);
        text += "Sleep(2);\n";
        for half in &mut halves {
            text += &half.path.text;
            half.command((4 * MS + tick) as f64 / 1e6, path_model::Command::Start);
            if half.course.rests[0].why == Why::Underrun {
                return None;
            }
        }
        text += "Sleep(2);\nGT_CrdStart(3,0);\n";
        let last = halves.iter().map(|half| half.course.rests[0].at).fold(0.0, f64::max);
        let horizon = (last.ceil() as Ns + 3) * MS;
        writeln!(text, "Sleep({});", horizon / MS - 4).unwrap();
        Some(Made { text, halves, acts: Default::default(), refused: 0, horizon })
    });
    println!("{count} jobs: at most {off:?} pulses off the model and off the circle");
    assert!(off[1] > 0.0, "no arc was seen");
}
