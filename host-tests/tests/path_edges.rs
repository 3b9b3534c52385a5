//! Edges at the boundaries of segments, through the whole machine: random paths against the model,
//! at ticks of 10 µs, 250 µs and 1 ms; and the model's instants against exact arithmetic. `PATHS`
//! sets how many, `PATHS_FROM` how many are left out before, `PATH_TICKS` another list of ticks in
//! µs; a long run says every 1000 paths how far it is.
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
#[path = "path/exact.rs"]
mod exact;
#[path = "path/machine.rs"]
mod machine;
#[path = "path/random.rs"]
mod random;

use chance::Chance;
use host_tests::laser_model::{Family, Ns};
use host_tests::path_model::{Course, Entry, Why};
use machine::{Machine, Reported, numbered};
use random::{Effect, Random, fits, random, set_up, undisturbed};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Paths of a program.
const GROUP_PATHS: u64 = 20;
/// What an edge may be off, ns.
const EDGE_TOLERANCE_NS: f64 = 5.0;

/// A channel in analog mode, and axes that may move.
fn begin(family: Family) -> String {
    let mut text = String::from("TCrdPrm crd;memset(&crd,0,sizeof(crd));\nGT_LaserPowerMode(2,10,0,0,1);\n");
    if family == Family::Lsr {
        text += "GT_SetLevelDelay(0,0,0);\n";
    }
    for axis in 1..=4 {
        text += &format!("GT_AxisOn({axis});\nGT_LmtsOff({axis});\n");
    }
    text
}

/// The edges that the model has: instant in ns, how much later it may be, output, level.
type Expected = Vec<(f64, f64, Output, i64)>;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Output {
    Switch,
    Volts,
    General,
}

/// What lasts from path to path.
#[derive(Default)]
struct State {
    gate: bool,
    code: i64,
    mv: u32,
    output: bool,
}

impl State {
    fn expect(&mut self, path: &Random, start: Ns, tick: Ns, edges: &mut Expected) {
        let course = undisturbed(path);
        let volts = |gate: bool, mv: u32| if gate { (i64::from(mv) * 32767 + 5000) / 10_000 } else { 0 };
        let mut change = |state: &mut State, at: f64, late: f64, gate: bool, mv: u32| {
            let at = start as f64 + at * 1e6;
            if gate != state.gate {
                edges.push((at, late, Output::Switch, gate.into()));
            }
            if volts(gate, mv) != state.code {
                edges.push((at, late, Output::Volts, volts(gate, mv)));
            }
            (state.gate, state.mv, state.code) = (gate, mv, volts(gate, mv));
        };
        let mut general = Vec::new();
        for &(at, effect) in &course.effects {
            match path.effects[effect] {
                Effect::Gate(on) => {
                    let mv = self.mv;
                    change(self, at, 0.0, on, mv);
                }
                Effect::Power(mv) => {
                    let gate = self.gate;
                    change(self, at, 0.0, gate, mv);
                }
                Effect::Output(on) if on != self.output => {
                    self.output = on;
                    general.push((start as f64 + at * 1e6, 0.0, Output::General, on.into()));
                }
                Effect::Output(_) => {}
            }
        }
        // SPEC 6: what entries lit goes off when they have run out; an underrun is dark within a
        // tick.
        let rest = course.rests[0];
        let late = if rest.why == Why::Underrun { tick as f64 } else { 0.0 };
        let mv = self.mv;
        change(self, rest.at, late, false, mv);
        edges.extend(general);
    }
}

fn reported(reported: &Reported) -> Vec<(Ns, Output, i64)> {
    let [beams, _] = &reported.lasers;
    let switch = beams.switch.iter().map(|&(at, on)| (at, Output::Switch, on.into()));
    let volts = beams.volts.iter().map(|&(at, code)| (at, Output::Volts, code.into()));
    let general = reported.outputs.iter().map(|&(at, _, on)| (at, Output::General, on.into()));
    switch.chain(volts).chain(general).collect()
}

/// How many entries there are up to the last motion that has ended.
fn passed(path: &Random, course: &Course) -> usize {
    let motions = path.entries.iter().enumerate().filter(|(_, entry)| matches!(entry, Entry::Motion(..)));
    motions.take(course.ends.len()).last().map_or(0, |(index, _)| index + 1)
}

/// Paths from where the axes stand.
fn group(number: u64) -> Vec<Random> {
    let chance = &mut Chance::new(number);
    let mut from = [0.0; 4];
    let mut paths = Vec::new();
    while paths.len() < GROUP_PATHS as usize {
        let path = random(chance, from, 30, 0);
        let course = undisturbed(&path);
        let waits = |entry: &Entry| matches!(entry, Entry::Delay(_));
        // One that comes to a delay at speed does not get to its end.
        let stops = course.rests[0].why == Why::Underrun && path.entries[passed(&path, &course)..].iter().any(waits);
        if fits(&course, 0.0, 64) && !stops {
            from = path.end;
            paths.push(path);
        }
    }
    paths
}

/// Runs a group; the greatest distance of an edge, and how many there were.
fn check(machine: &Machine, number: u64) -> (f64, usize) {
    let mut text = begin(machine.family);
    let mut expected: Expected = Vec::new();
    let mut state = State::default();
    let mut clock = 0;
    for path in group(number) {
        text += &set_up(&path.frame, path.dimensions, 0);
        text += "GT_CrdClear(1,0);\nSleep(2);\n";
        text += &path.text;
        text += "Sleep(2);\nGT_CrdStart(1,0);\n";
        clock += 4;
        let start = clock * 1_000_000 + machine.tick_ns;
        state.expect(&path, start, machine.tick_ns, &mut expected);
        let rest = undisturbed(&path).rests[0];
        let ms = rest.at.ceil() as Ns + 3;
        text += &format!("Sleep({ms});\n");
        clock += ms;
        if rest.why == Why::Underrun {
            text += "GT_ClrLaserFault(0);\nSleep(1);\n";
            clock += 1;
        }
    }
    machine.reset();
    let done = reported(&machine.run(&text));
    let mut worst = 0.0f64;
    let reported = || format!("group {number}, tick {} ns, {:?}\n{}", machine.tick_ns, machine.family, numbered(&text));
    for output in [Output::Switch, Output::Volts, Output::General] {
        let mine: Vec<_> = expected.iter().filter(|edge| edge.2 == output).collect();
        let theirs: Vec<_> = done.iter().filter(|edge| edge.1 == output).collect();
        for (index, (mine, theirs)) in mine.iter().zip(&theirs).enumerate() {
            let off = theirs.0 as f64 - mine.0;
            let good = off >= -EDGE_TOLERANCE_NS && off <= EDGE_TOLERANCE_NS + mine.1 && mine.3 == theirs.2;
            assert!(good, "{output:?} edge {index} is {off} ns off: {mine:?}, the machine {theirs:?}; {}", reported());
            if mine.1 == 0.0 {
                worst = worst.max(off.abs());
            }
        }
        assert_eq!(mine.len(), theirs.len(), "{output:?}: {}", reported());
    }
    (worst, expected.len())
}

fn paths() -> u64 {
    std::env::var("PATHS").map_or(600, |text| text.parse().expect("a number"))
}

/// The model is off by less than half a ns, and by so much only where a motion ends as good as at
/// rest: the root of what rounding leaves of 0. So what an edge is off from the model, it is nearly
/// off from the exact instant.
#[test]
fn the_models_instants_are_exact() {
    let (mut worst, mut seen) = (0.0f64, 0);
    for number in 0..paths().div_ceil(GROUP_PATHS) {
        for path in group(number) {
            let course = undisturbed(&path);
            let (effects, end) = exact::instants(&path.frame, &path.entries);
            assert_eq!(effects.len(), course.effects.len());
            let pairs = effects.iter().zip(&course.effects).map(|(exact, (at, _))| (*at, exact));
            for (at, exact) in pairs.chain([(course.rests[0].at, &end)]) {
                let off = exact::apart(at, exact) * 1e6;
                assert!(off < 0.5, "{off} ns at {at} ms in group {number}: {:?} {:?}", path.frame, path.entries);
                worst = worst.max(off);
                seen += 1;
            }
        }
    }
    println!("{seen} instants, the model at most {worst:.3} ns off");
}

#[test]
fn edges_at_boundaries_are_where_the_model_has_them() {
    let paths = paths();
    let ticks: Vec<Ns> = std::env::var("PATH_TICKS")
        .unwrap_or("10,250,1000".into())
        .split(',')
        .map(|us| us.parse::<Ns>().expect("a number of µs") * 1000)
        .collect();
    let from = std::env::var("PATHS_FROM").map_or(0, |text| text.parse().expect("a number")) / GROUP_PATHS;
    let groups = from + paths.div_ceil(GROUP_PATHS);
    let next = AtomicU64::new(from);
    let found = std::sync::Mutex::new((0.0f64, 0));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                let machine = |family: Family| ticks.iter().map(|tick| Machine::new(family, *tick)).collect::<Vec<_>>();
                let machines = [Family::Gus, Family::Lsr].map(machine);
                loop {
                    let number = next.fetch_add(1, Relaxed);
                    if number >= groups {
                        break;
                    }
                    for machine in &machines[number as usize % 2] {
                        let (worst, edges) = check(machine, number);
                        let mut found = found.lock().unwrap();
                        *found = (found.0.max(worst), found.1 + edges);
                    }
                    if (number + 1).is_multiple_of(1000 / GROUP_PATHS) {
                        let (worst, edges) = *found.lock().unwrap();
                        println!("up to path {}: {edges} edges, at most {worst:.3} ns off", (number + 1) * GROUP_PATHS);
                    }
                }
            });
        }
    });
    let (worst, edges) = *found.lock().unwrap();
    let paths = (groups - from) * GROUP_PATHS;
    println!("{paths} paths at ticks of {ticks:?} ns: {edges} edges, at most {worst:.3} ns off");
    assert!(edges as u64 > paths * ticks.len() as u64 * 4);
}
