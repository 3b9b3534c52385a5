//! Jobs that join a path and a laser: as calls, and as the models take them.
use super::chance::Chance;
use super::random::{Random, fits, is_undecided, random, set_up};
use host_tests::laser_model::{Command, Exact, Family, Fpk, Mode, Ns};
use host_tests::light_model::{Act, Bounds, Buffered, Distance, Law, Ratios, Source};
use host_tests::path_model::{self, Course, Entry, Why, course};
use std::fmt::Write;

/// What the power hangs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Velocity {
    Direct,
    Planned,
    Encoder,
    Table,
}

/// What distance adds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    None,
    Planned,
    Actual,
    Each,
    Plane,
}

/// A row of the table of combinations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    pub family: Family,
    pub mode: Mode,
    pub velocity: Velocity,
    pub way: Way,
    pub delays: bool,
    pub fpk: bool,
    /// Standby and pre-voltage.
    pub waiting: bool,
}

/// All of them.
pub fn table() -> Vec<Setup> {
    let mut setups = Vec::new();
    for family in [Family::Gus, Family::Lsr] {
        for mode in [Mode::Duty, Mode::Frequency, Mode::Analog, Mode::Open] {
            for velocity in [Velocity::Direct, Velocity::Planned, Velocity::Encoder, Velocity::Table] {
                for way in [Way::None, Way::Planned, Way::Actual, Way::Each, Way::Plane] {
                    for bits in 0..8 {
                        let (delays, fpk, waiting) = (bits & 1 != 0, bits & 2 != 0, bits & 4 != 0);
                        setups.push(Setup { family, mode, velocity, way, delays, fpk, waiting });
                    }
                }
            }
        }
    }
    setups
}

/// A job.
pub struct Made {
    pub text: String,
    pub acts: Vec<(Ns, Act)>,
    pub course: Course,
    pub path: Random,
    /// Carrier or pulse rate is a whole number of ns; ns.
    pub carrier: Ns,
    /// Pulse width of frequency mode, ns.
    pub width: Ns,
    pub horizon: Ns,
}

const MS: Ns = 1_000_000;
/// The script clock at which the coordinate system is started.
const START_NS: Ns = 4 * MS;

fn real(value: f64) -> String {
    format!("{value:?}")
}

/// A fraction of a mode's full range, in steps that a double has exactly.
fn share(mode: Mode, part: f64) -> f64 {
    let full = match mode {
        Mode::Duty | Mode::Open => 100.0,
        Mode::Frequency => 40.0,
        Mode::Analog => 10.0,
    };
    (full * part * 64.0).round() / 64.0
}

fn exact(value: f64) -> Exact {
    Exact::new((value * 1024.0).round() as i128, 1024)
}

fn array(name: &str, kind: &str, values: &[f64]) -> String {
    let whole = kind == "long";
    let values: Vec<String> =
        values.iter().map(|value| if whole { format!("{value}") } else { real(*value) }).collect();
    format!("{kind} {name}[{}] = {{{}}};\n", values.len(), values.join(","))
}

struct Maker<'a> {
    chance: &'a mut Chance,
    setup: &'a Setup,
    tick: Ns,
    text: String,
    acts: Vec<(Ns, Act)>,
    clock: Ns,
    arrays: u32,
}

impl Maker<'_> {
    fn below(&mut self, n: u64) -> u64 {
        self.chance.below(n)
    }

    fn sleep_to(&mut self, at: Ns) {
        if at > self.clock {
            writeln!(self.text, "Sleep({});", (at - self.clock) / MS).unwrap();
            self.clock = at;
        }
    }

    /// The tick on which a call made now acts.
    fn acts_at(&self) -> Ns {
        self.clock + self.tick
    }

    fn own(&mut self, text: &str, command: Command) {
        self.text += text;
        self.acts.push((self.acts_at(), Act::Own(command)));
    }

    fn part(&mut self) -> f64 {
        share(self.setup.mode, 0.05 + 0.9 * self.chance.unit())
    }

    /// Everything that is set before the start. Returns carrier and width.
    fn set_up(&mut self) -> (Ns, Ns) {
        let mode = self.setup.mode;
        let number = [Mode::Duty, Mode::Frequency, Mode::Analog, Mode::Open].iter().position(|it| *it == mode).unwrap();
        if self.setup.family == Family::Gus {
            self.text += "GT_SetAxisMode(7,1);\n";
        } else {
            self.text += "GT_SetLaserMode(0);\n";
        }
        let (max, min) =
            (share(mode, [1.0, 0.75][self.below(2) as usize]), share(mode, [0.0, 0.05][self.below(2) as usize]));
        let delayed = self.setup.delays;
        let text = format!("GT_LaserPowerMode({number},{},{},0,{});\n", real(max), real(min), u8::from(delayed));
        self.own(&text, Command::PowerMode { mode, max: exact(max), min: exact(min), delayed });
        // Whole periods: 10, 20 and 50 kHz.
        let khz = [10, 20, 50][self.below(3) as usize];
        self.own(&format!("GT_LaserOutFrq({khz},0);\n"), Command::Carrier(Exact::from_integer(khz)));
        let us = [2, 7, 10][self.below(3) as usize];
        self.own(&format!("GT_SetPulseWidth({us},0);\n"), Command::Width(us * 1000));
        if self.setup.delays {
            let (off, on) = [(130, 77), (20, 90), (50, 50), (700, 0)][self.below(4) as usize];
            self.own(&format!("GT_SetLevelDelay({off},{on},0);\n"), Command::Delays { off: off * 1000, on: on * 1000 });
        }
        if self.setup.fpk {
            let (a, b, c) = [(40, 60, 70), (190, 60, 105), (60, 190, 30)][self.below(3) as usize];
            let fpk = Fpk { time1: a * 1000, time2: b * 1000, off: c * 1000 };
            self.own(&format!("GT_EnaFPK({a},{b},{c},0);\n"), Command::Fpk(Some(fpk)));
        }
        if self.setup.waiting {
            let text = "GT_SetWaitPulse(1,5,8,0);\n";
            self.own(text, Command::Standby(Some((Exact::from_integer(5), Exact::from_integer(8)))));
            self.own("GT_SetPreVltg(1,1.5,0);\n", Command::PreVoltage(Some(Exact::new(3, 2))));
        }
        let power = self.part();
        self.own(&format!("GT_LaserPrfCmd({},0);\n", real(power)), Command::Power(exact(power)));
        (1_000_000 / khz as Ns, us * 1000)
    }

    /// Distance follow, over ways of some thousand pulses.
    fn distance(&mut self, scale: f64) {
        let way = self.setup.way;
        if way == Way::None {
            return;
        }
        let mode = self.setup.mode;
        let gus = self.setup.family == Family::Gus;
        self.arrays += 1;
        let n = self.arrays;
        let reference: [f64; 4] = std::array::from_fn(|_| (self.chance.below(200) as f64) - 100.0);
        let scales = [1000.0, 500.0, 2000.0, 1000.0];
        let source = match way {
            Way::Actual => Source::Encoder,
            Way::Each | Way::Plane if self.below(2) == 0 => Source::Encoder,
            _ => Source::Planned,
        };
        // Across the path, about a third of the range.
        let most = share(mode, 0.33) * 500.0 / scale.max(50.0);
        let mut ratio = || ((self.chance.unit() * 2.0 - 1.0) * most * 4096.0).round() / 4096.0;
        let fixed: [f64; 4] = std::array::from_fn(|_| ratio());
        let own = Bounds { min: share(mode, 0.1), max: share(mode, 0.9) };
        let mut text = array(&format!("p{n}"), "long", &reference) + &array(&format!("s{n}"), "double", &scales);
        writeln!(text, "GT_SetLaserDisMode(1,{},p{n},s{n},0);", u8::from(source == Source::Encoder)).unwrap();
        let (min, max) = (real(own.min), real(own.max));
        let ratios = match way {
            Way::None => unreachable!(),
            Way::Planned | Way::Actual => {
                text += &array(&format!("r{n}"), "double", &fixed);
                if gus {
                    writeln!(text, "GT_SetLaserDisRatio(r{n},{min},{max},0);").unwrap();
                } else {
                    writeln!(text, "GT_SetLaserDisRatio(r{n},0);").unwrap();
                }
                Ratios::Fixed(fixed)
            }
            Way::Each => {
                let places = [-scale, 0.0, scale].map(f64::round);
                let points: Vec<(f64, [f64; 4])> =
                    places.iter().map(|place| (*place, std::array::from_fn(|_| ratio()))).collect();
                // Points of axis 1 first, then those of the others.
                let all: Vec<f64> = (0..4).flat_map(|axis| points.iter().map(move |point| point.1[axis])).collect();
                text += &array(&format!("r{n}"), "double", &all);
                text += &array(&format!("q{n}"), "long", &places.repeat(4));
                writeln!(text, "GT_SetLaserDisTable1D(3,r{n},q{n},{min},{max},NULL,0);").unwrap();
                Ratios::Each(points)
            }
            Way::Plane => {
                let x = [-scale, 0.0, scale].map(f64::round).to_vec();
                let y = [-scale, scale].map(f64::round).to_vec();
                let rows: Vec<Vec<f64>> = (0..2).map(|_| (0..3).map(|_| ratio()).collect()).collect();
                text += &array(&format!("r{n}"), "double", &rows.concat());
                text += &(array(&format!("x{n}"), "long", &x) + &array(&format!("y{n}"), "long", &y));
                writeln!(text, "short a{n}[2] = {{1,2}};\nshort c{n}[2] = {{3,2}};").unwrap();
                writeln!(text, "GT_SetLaserDisTable2D(a{n},c{n},r{n},x{n},y{n},{min},{max},NULL,0);").unwrap();
                Ratios::Plane { x, y, ratios: rows }
            }
        };
        let bounds = gus.then_some(own);
        self.text += &text;
        let distance = Distance { source, reference, scale: scales, ratios, bounds };
        self.acts.push((self.acts_at(), Act::Distance(Some(distance))));
    }

    /// The entry that chooses whose speed is followed, half of the time with a start power.
    fn source(&mut self, source: Source) -> (String, Buffered) {
        let start = (self.below(2) == 0).then(|| self.part());
        let power = start.map_or(String::new(), |power| format!(",{}", real(power)));
        let number = u8::from(source == Source::Encoder);
        (format!("GT_BufLaserFollowMode(1,{number},0,0{power});\n"), Buffered::Mode { source, start })
    }

    /// The entries that begin a follow.
    fn follow(&mut self, speed: f64) -> (String, Vec<Buffered>) {
        let mode = self.setup.mode;
        let bounds = Bounds { min: share(mode, 0.1).floor(), max: share(mode, 0.8).floor() };
        let ratio = share(mode, 0.5 + 0.6 * self.chance.unit()) / speed;
        let (min, max) = (bounds.min, bounds.max);
        let follow = |law: Law, source: Option<Source>| Buffered::Follow { law, bounds, source };
        let velocity = self.setup.velocity;
        match velocity {
            Velocity::Direct => (String::new(), Vec::new()),
            Velocity::Planned if self.below(2) == 0 => {
                let text = format!("GT_BufLaserPrfFollow(1,{},{min},{max},0,0);\n", real(ratio));
                (text, vec![follow(Law::Ratio(ratio), Some(Source::Planned))])
            }
            Velocity::Planned | Velocity::Encoder => {
                let source = if velocity == Velocity::Encoder { Source::Encoder } else { Source::Planned };
                let (mut text, chosen) = self.source(source);
                text += &format!("GT_BufLaserFollowRatio(1,{},{},{},0,0);\n", real(ratio), real(min), real(max));
                (text, vec![chosen, follow(Law::Ratio(ratio), None)])
            }
            Velocity::Table => {
                let begun = follow(Law::Table(points(mode, speed)), None);
                let call = format!("GT_BufLaserFollowTable(1,3,{},{},0,0);\n", real(min), real(max));
                match self.below(3) {
                    0 => (call, vec![begun]),
                    other => {
                        let source = if other == 1 { Source::Encoder } else { Source::Planned };
                        let (text, chosen) = self.source(source);
                        (text + &call, vec![chosen, begun])
                    }
                }
            }
        }
    }
}

/// The follow table of a speed scale.
fn points(mode: Mode, speed: f64) -> Vec<(f64, f64)> {
    [(0.1, 0.15), (0.3, 0.5), (0.7, 0.4), (1.1, 0.95)].iter().map(|(v, p)| (v * speed, share(mode, *p))).collect()
}

/// Job number so much.
pub fn made(number: u64, setup: &Setup, tick: Ns) -> Made {
    let chance = &mut Chance::new(number);
    loop {
        if let Some(made) = attempt(chance, setup, tick) {
            return made;
        }
    }
}

fn attempt(chance: &mut Chance, setup: &Setup, tick: Ns) -> Option<Made> {
    let mut path = random(chance, [0.0; 4], 9, 0);
    path.entries.retain(|entry| !entry.is_effect());
    path.text = path
        .text
        .lines()
        .filter(|line| !line.contains("BufLaser") && !line.contains("BufIO"))
        .map(|line| line.to_owned() + "\n")
        .collect();
    let lines: Vec<String> = path.text.lines().map(str::to_owned).collect();
    let motions = std::mem::take(&mut path.entries);
    let mut maker = Maker {
        chance,
        setup,
        tick,
        text: String::from("TCrdPrm crd;memset(&crd,0,sizeof(crd));\n"),
        acts: Vec::new(),
        clock: 0,
        arrays: 0,
    };
    let (carrier, width) = maker.set_up();
    for axis in 1..=4 {
        writeln!(maker.text, "GT_AxisOn({axis});\nGT_LmtsOff({axis});").unwrap();
    }
    let length: f64 =
        motions.iter().map(|entry| if let Entry::Motion(geometry, _) = entry { geometry.length() } else { 0.0 }).sum();
    maker.distance(length / 3.0 + 10.0);
    if setup.velocity == Velocity::Table {
        let points = points(setup.mode, path.frame.speed);
        let (vel, power): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        maker.text += &(array("tv", "double", &vel) + &array("tp", "double", &power));
        maker.text += "GT_SetLaserFollowTable(3,4,tv,tp,0);\n";
    }
    maker.text += &set_up(&path.frame, path.dimensions, 0);
    // Above what the motions brake with: a Stop never ends on a boundary by itself.
    let stop_dec = path.frame.acc * (1.3 + 3.0 * maker.chance.unit());
    maker.text += &format!("GT_CrdClear(1,0);\nGT_SetCrdStopDec(1,{},30000);\n", real(stop_dec));
    maker.sleep_to(2 * MS);
    // Entries: what begins a follow, then light and what changes it between the motions.
    let mut buffered: Vec<Buffered> = Vec::new();
    let mut entries: Vec<Entry> = Vec::new();
    let push =
        |text: &str, list: Vec<Buffered>, maker: &mut Maker, buffered: &mut Vec<Buffered>, entries: &mut Vec<Entry>| {
            maker.text += text;
            for one in list {
                entries.push(Entry::Laser(buffered.len()));
                buffered.push(one);
            }
        };
    let (text, list) = maker.follow(path.frame.speed);
    push(&text, list, &mut maker, &mut buffered, &mut entries);
    push("GT_BufLaserOn(1,0,0);\n", vec![Buffered::Gate(true)], &mut maker, &mut buffered, &mut entries);
    for (motion, line) in motions.iter().zip(&lines) {
        maker.text += &format!("{line}\n");
        entries.push(motion.clone());
        let (text, list) = match maker.below(12) {
            0..2 => ("GT_BufLaserOff(1,0,0);\n".into(), vec![Buffered::Gate(false)]),
            2..5 => ("GT_BufLaserOn(1,0,0);\n".into(), vec![Buffered::Gate(true)]),
            5..7 => {
                let power = maker.part();
                (format!("GT_BufLaserPrfCmd(1,{},0,0);\n", real(power)), vec![Buffered::Power(power)])
            }
            7 => ("GT_BufLaserFollowOff(1,0,0);\n".into(), vec![Buffered::FollowOff]),
            8..10 => maker.follow(path.frame.speed),
            _ => (String::new(), vec![]),
        };
        push(&text, list, &mut maker, &mut buffered, &mut entries);
    }
    path.entries = entries;
    maker.sleep_to(START_NS);
    maker.text += "GT_CrdStart(1,0);\n";
    // What comes from outside, at whole ms.
    let at = |clock: Ns| (clock + tick) as f64 / 1e6;
    let mut commands = vec![(0.0, path_model::Command::StopDec(stop_dec)), (at(START_NS), path_model::Command::Start)];
    let free = course(&path.frame, &path.entries, &commands, 1e9);
    if !fits(&free, at(START_NS), 64) || free.rests[0].why != Why::Done {
        return None;
    }
    let runs = (free.rests[0].at - at(START_NS)).ceil() as u64;
    let mut clock = START_NS;
    let mut stopped = false;
    for _ in 0..maker.below(6) {
        clock += (1 + maker.below(runs.max(2))) as Ns * MS;
        maker.sleep_to(clock);
        match maker.below(8) {
            0..3 if !stopped => {
                let abrupt = maker.below(3) == 0;
                maker.text += if abrupt { "GT_Stop(256,256);\n" } else { "GT_Stop(256,0);\n" };
                maker.acts.push((maker.acts_at(), Act::Stops { crd: 0 }));
                commands.push((
                    at(clock),
                    if abrupt { path_model::Command::Abrupt(tick as f64 / 1e6) } else { path_model::Command::Stop },
                ));
                stopped = true;
            }
            // One that finds it at rest.
            0..3 if course(&path.frame, &path.entries, &commands, 1e9).rests[0].at + 1e-3 < at(clock) => {
                maker.text += "GT_Stop(256,0);\n";
                maker.acts.push((maker.acts_at(), Act::Stops { crd: 0 }));
            }
            0..3 => {}
            3 => {
                let on = maker.below(2) == 0;
                maker.own(&format!("GT_SetHSIOOpt({},0);\n", u8::from(on)), Command::Gate(on));
            }
            4 => {
                let power = maker.part();
                maker.own(&format!("GT_LaserPrfCmd({},0);\n", real(power)), Command::Power(exact(power)));
            }
            5 => {
                maker.text += "GT_Stop(1024,0);\n";
                let end = Act::EndFollow { crds: 1 };
                maker.acts.push((maker.acts_at(), end));
            }
            6 => maker.distance(length / 3.0 + 10.0),
            _ => {
                maker.text += "GT_SetLaserDisMode(0,0,NULL,NULL,0);\n";
                maker.acts.push((maker.acts_at(), Act::Distance(None)));
            }
        }
    }
    if stopped {
        // After the longest braking.
        let rest = course(&path.frame, &path.entries, &commands, 1e9).rests[0].at;
        clock = clock.max((rest.ceil() as Ns + 1) * MS) + MS;
        maker.sleep_to(clock);
        // If it had ended by itself, there is nothing to go on with.
        let ended = course(&path.frame, &path.entries, &commands, 1e9).rests[0].why == Why::Done;
        if !ended {
            maker.text += "GT_CrdStart(1,0);\n";
            commands.push((at(clock), path_model::Command::Start));
        }
    }
    let done = course(&path.frame, &path.entries, &commands, 1e9);
    if !fits(&done, at(START_NS), 64) || is_undecided(&done) || done.rests.iter().any(|rest| rest.why == Why::Underrun)
    {
        return None;
    }
    let end = (done.rests.last()?.at.ceil() as Ns + 3) * MS;
    maker.sleep_to(end.max(clock + 3 * MS));
    let horizon = maker.clock;
    maker.text += "unsigned long lit;\nGT_GetLaserOnTime(0,&lit);\n";
    let ns = |ms: f64| (ms * 1e6).round() as Ns;
    let mut acts = maker.acts;
    acts.extend(done.starts.iter().map(|&(at, resumes)| (ns(at), Act::Starts { crd: 0, resumes })));
    acts.extend(done.effects.iter().map(|&(at, effect)| (ns(at), Act::Entry(0, buffered[effect].clone()))));
    acts.extend(done.rests.iter().map(|rest| (ns(rest.at), Act::Rests { crd: 0, stopped: rest.why == Why::Stopped })));
    acts.sort_by_key(|(at, _)| *at);
    Some(Made { text: maker.text, acts, course: done, path, carrier, width, horizon })
}
