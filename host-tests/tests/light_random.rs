//! Light on a path through the whole machine. First come all combinations of direct power, velocity
//! follow and distance follow with delays, FPK, standby and pre-voltage, in both families and every
//! mode; then random ones. The model holds every edge and, at every tick, the power. `LIGHT_JOBS`
//! sets how many random jobs there are.
//!
//! Tolerances: an edge of the switch 5 ns. A power that depends on planned values: 2·10⁻⁴ of the
//! mode's range (a step of the trace's and the DAC's numbers is less). A power that depends on
//! encoders: the change by a pulse and a tick of theirs.
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
#[path = "laser/dark.rs"]
mod dark;
#[path = "light/job.rs"]
mod job;
#[path = "path/machine.rs"]
mod machine;
#[path = "path/random.rs"]
mod random;

use chance::Chance;
use dark::in_the_dark;
use host_tests::laser_model::{Edge, Exact, Family, Mode, Ns, Outcome, level_at, outcome};
use host_tests::light_model::{Law, Light, Source, light};
use job::{Made, Setup, made, table};
use machine::{Machine, Reported, numbered};
use protocol::command::GetLaserOnTime;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

const SLACK: Ns = 5;
const TICKS: [Ns; 4] = [50_000, 125_000, 250_000, 1_000_000];

fn range(mode: Mode) -> f64 {
    match mode {
        Mode::Duty | Mode::Open => 100.0,
        Mode::Frequency => 40.0,
        Mode::Analog => 10.0,
    }
}

/// The model's view of a job.
struct Model<'a> {
    setup: &'a Setup,
    made: &'a Made,
    tick: Ns,
    light: Light,
    outcome: Outcome,
    /// Shafts of axes 1 to 4 at each row: what the encoders round.
    shafts: Vec<[f64; 4]>,
    /// Their velocities at each row after the filter of 1 ms, for each row at which it may have
    /// begun.
    filtered: Vec<Vec<[f64; 4]>>,
}

impl<'a> Model<'a> {
    fn new(setup: &'a Setup, made: &'a Made, tick: Ns) -> Model<'a> {
        let light = light(setup.family, &made.acts);
        // The script's last call, a read, is answered a tick after it.
        let mut outcome = outcome(setup.family, &light.job, made.horizon + tick);
        outcome.switch.retain(|edge| edge.0 < made.horizon);
        let mut model = Model { setup, made, tick, light, outcome, shafts: vec![[0.0; 4]], filtered: Vec::new() };
        // The plant: a lag of 1 ms behind a set-point that is held from tick to tick.
        let gain = 1.0 - (-(tick as f64) / 1e6).exp();
        for row in 0..made.horizon / tick + 2 {
            let planned = model.planned(row * tick);
            let last = model.shafts[row as usize];
            model.shafts.push(std::array::from_fn(|axis| last[axis] + (planned[axis] - last[axis]) * gain));
        }
        let follows = |row: &usize| {
            let power = model.light.power(*row as Ns * tick);
            power.source == Source::Encoder && power.follow.is_some()
        };
        let first = (0..model.shafts.len()).find(follows).unwrap_or(0);
        model.filtered = [first, first.saturating_sub(1), first + 1, 0].map(|from| model.filter(from)).into();
        model
    }

    /// Velocities after the filter, which takes the first one of the row `from` as it is and rests
    /// with the path.
    fn filter(&self, from: usize) -> Vec<[f64; 4]> {
        let ms = self.tick as f64 / 1e6;
        let (share, mut state) = (-(-ms).exp_m1(), [0.0; 4]);
        let mut all = vec![state];
        for (row, pair) in self.shafts.windows(2).enumerate().map(|(row, pair)| (row + 1, pair)) {
            let now: [f64; 4] = std::array::from_fn(|axis| (pair[1][axis] - pair[0][axis]) / ms);
            let runs = self.made.course.runs(row as f64 * ms);
            state = match row {
                _ if row < from || !runs => [0.0; 4],
                _ if row == from => now,
                _ => std::array::from_fn(|axis| state[axis] + (now[axis] - state[axis]) * share),
            };
            all.push(state);
        }
        all
    }

    fn planned(&self, at: Ns) -> [f64; 4] {
        self.made.course.position(&self.made.path.entries, at as f64 / 1e6).unwrap_or([0.0; 4])
    }

    /// Least and greatest speed of the coordinate system that the tick may have seen at a row.
    fn speeds(&self, at: Ns, source: Source) -> [f64; 3] {
        let row = (at / self.tick) as usize;
        if source == Source::Planned {
            // The mean of the interval that begins there.
            let way = |at: Ns| self.made.course.distance(at as f64 / 1e6);
            let row = row as Ns * self.tick;
            return [(way(row + self.tick) - way(row)) / (self.tick as f64 / 1e6); 3];
        }
        let ms = self.tick as f64 / 1e6;
        // Of the sample in force or of the one before, in whole pulses.
        let rows = [row, row.saturating_sub(1), (row + 1).min(self.shafts.len() - 1)];
        let norm = |velocity: [f64; 4]| velocity.iter().map(|part| part.powi(2)).sum::<f64>().sqrt();
        let near: Vec<f64> = self.filtered.iter().flat_map(|filtered| rows.map(|row| norm(filtered[row]))).collect();
        let pulse = 2.0 / ms;
        let least = near.iter().copied().fold(f64::MAX, f64::min) - pulse;
        // A coordinate system that rests has no speed, though its axes still settle.
        let least = if self.made.course.runs((at + self.tick) as f64 / 1e6) { least } else { 0.0 };
        [least.max(0.0), near[0], near.iter().copied().fold(0.0, f64::max) + pulse]
    }

    /// Bounds of the power that light has in the interval of a row, at an instant in it.
    fn powers(&self, at: Ns) -> (f64, f64) {
        let row = at / self.tick * self.tick;
        let power = self.light.power(at);
        let planned = self.planned(row);
        let actual = self.shafts[(row / self.tick) as usize];
        let positions = |source: Source| if source == Source::Planned { planned } else { actual };
        let speeds = self.speeds(row, power.source);
        let value = |speed: f64| power.value(self.setup.family, |_, _| speed, positions);
        let between = (0..=8).map(|step| speeds[0] + (speeds[2] - speeds[0]) * f64::from(step) / 8.0);
        // The points of a table, where the power may be the greatest or least.
        let points = match power.follow.as_ref().map(|follow| &follow.law) {
            Some(Law::Table(points)) => points.as_slice(),
            _ => &[],
        };
        let points = points.iter().map(|point| point.0).filter(|speed| (speeds[0]..=speeds[2]).contains(speed));
        let values: Vec<f64> = speeds.into_iter().chain(between).chain(points).map(value).collect();
        let mut slack = range(self.setup.mode) * 2e-4;
        if let Some(distance) = power.distance.as_ref().filter(|distance| distance.source == Source::Encoder) {
            let behind = self.shafts[(row / self.tick).max(1) as usize - 1];
            let off = std::array::from_fn(|axis| 1.0 + (actual[axis] - behind[axis]).abs());
            slack += distance.turns(actual, off);
        }
        let low = values.iter().copied().fold(f64::MAX, f64::min);
        let high = values.iter().copied().fold(f64::MIN, f64::max);
        ((low - slack).max(0.0), high + slack)
    }

    fn lit(&self, at: Ns) -> bool {
        self.outcome.light.iter().any(|span| span.begin <= at && at < span.end)
    }

    /// An edge of light so near that a row might see either.
    fn is_edge(&self, at: Ns) -> bool {
        let ends = self.outcome.light.iter().flat_map(|span| [span.begin, span.end]);
        ends.chain(self.outcome.switch.iter().map(|edge| edge.0)).any(|edge| (edge - at).abs() <= SLACK)
    }

    fn rows(&self, reported: &Reported) -> Result<(), String> {
        let full = range(self.setup.mode);
        for row in &reported.rows {
            let at = row.t_ns as Ns;
            if at >= self.made.horizon || self.is_edge(at) {
                continue;
            }
            let point = row.lasers[0];
            let gate = level_at(&self.outcome.switch, at, false);
            if point.gate != gate {
                return Err(format!("row at {at}: the switch is {}, the model has {gate}", point.gate));
            }
            let found = point.power.m as f64 * 2f64.powi(-i32::from(point.power.e));
            let (low, high) = if self.lit(at) {
                self.powers(at)
            } else {
                let waiting = match self.setup.mode {
                    _ if !self.setup.waiting || at < self.tick => 0.0,
                    Mode::Open if self.setup.family == Family::Gus => 0.0,
                    Mode::Duty | Mode::Open => 8.0,
                    Mode::Frequency => 5.0,
                    Mode::Analog => 1.5,
                };
                (waiting - full * 2e-4, waiting + full * 2e-4)
            };
            if !(low..=high).contains(&found) {
                let light = self.lit(at);
                return Err(format!(
                    "row at {at}: power {found}, the model has {low} to {high} (light {light}, speed {:?}, {:?})",
                    self.speeds(at, self.light.power(at).source),
                    self.light.power(at)
                ));
            }
        }
        Ok(())
    }

    fn switch(&self, theirs: &[Edge<bool>]) -> Result<(), String> {
        let mine = &self.outcome.switch;
        let theirs: Vec<_> = theirs.iter().filter(|edge| edge.0 < self.made.horizon).collect();
        let differ = (0..mine.len().max(theirs.len())).find(|&index| match (mine.get(index), theirs.get(index)) {
            (Some(a), Some(b)) => (a.0 - b.0).abs() > SLACK || a.1 != b.1,
            _ => true,
        });
        differ.map_or(Ok(()), |index| {
            Err(format!("switch, edge {index}: {:?}, the model {:?} of {mine:?}", theirs.get(index), mine.get(index)))
        })
    }

    /// Pulses of light have the width, or the distance, of the power at their begin.
    fn pulses(&self, energy: &[Edge<bool>]) -> Result<usize, String> {
        let mut seen = 0;
        for span in &self.outcome.light {
            let inside = |at: Ns| span.begin - SLACK <= at && at < span.end - SLACK;
            let pulses: Vec<(Ns, Ns)> = energy
                .windows(2)
                .filter(|pair| pair[0].1 && inside(pair[0].0))
                .map(|pair| (pair[0].0, pair[1].0))
                .collect();
            for (index, &(begin, end)) in pulses.iter().enumerate() {
                let (low, high) = self.around(begin);
                let next = pulses.get(index + 1).map_or(Ns::MAX, |next| next.0);
                // The last one may be cut, and pulses without a gap are one.
                let unbroken = self.setup.mode != Mode::Frequency && self.most(begin, end).1 >= 99.95;
                if end >= span.end - SLACK || end >= next || unbroken {
                    continue;
                }
                let width = (end - begin) as f64;
                let good = if self.setup.mode == Mode::Frequency {
                    (width - self.made.width as f64).abs() < 1.5
                        && (next >= span.end || {
                            let gap = (next - begin) as f64;
                            let (least, most) = self.most(begin, next);
                            gap >= 1e6 / most - 3.0 && (least <= 0.0 || gap <= 1e6 / least + 3.0)
                        })
                } else {
                    let carrier = self.made.carrier as f64;
                    // Above 100 % of the carrier nothing ends.
                    (width >= carrier * low / 100.0 - 3.0 && width <= carrier * high / 100.0 + 3.0)
                        && (next >= span.end || self.nearly_whole(next - begin))
                };
                if !good {
                    return Err(format!(
                        "a pulse at {begin} of {width} ns, the next at {next}: power {low} to {high} in {span:?}, {:?}",
                        self.light.power(begin)
                    ));
                }
                seen += 1;
            }
        }
        Ok(seen)
    }

    /// A whole number of carrier periods: power 0 leaves some without a pulse.
    fn nearly_whole(&self, gap: Ns) -> bool {
        let rest = gap % self.made.carrier;
        rest.min(self.made.carrier - rest) <= 3
    }

    /// Powers just before and after an instant: an action is within some ns of the model's.
    fn around(&self, at: Ns) -> (f64, f64) {
        let (a, b) = (self.powers(at - SLACK), self.powers(at + SLACK));
        (a.0.min(b.0), a.1.max(b.1))
    }

    /// The least and greatest power of a time.
    fn most(&self, from: Ns, to: Ns) -> (f64, f64) {
        let ticks = (from / self.tick..=to / self.tick).map(|tick| tick * self.tick);
        let changes = self.light.powers.iter().map(|(at, _)| *at).filter(|at| (from..=to).contains(at));
        ticks.chain(changes).chain([from, to]).filter(|at| (from..=to).contains(at)).fold(
            (f64::MAX, 0.0),
            |range, at| {
                let (low, high) = self.around(at);
                (range.0.min(low), range.1.max(high))
            },
        )
    }

    fn volts(&self, volts: &[Edge<i16>]) -> Result<(), String> {
        for at in (1..self.made.horizon / self.tick).map(|row| row * self.tick).filter(|at| !self.is_edge(*at)) {
            let (low, high) = match self.lit(at) {
                true => self.powers(at),
                false if self.setup.waiting => (1.4995, 1.5005),
                false => (0.0, 0.0),
            };
            let found = f64::from(level_at(volts, at, 0)) / 3276.7;
            if found < low - 2e-4 || found > high + 2e-4 {
                return Err(format!("{found} V at {at}, the model has {low} to {high}, {:?}", self.light.power(at)));
            }
        }
        let ends = self.outcome.light.iter().flat_map(|span| [span.begin, span.end]);
        let mut instants: Vec<Ns> = ends.chain(self.light.powers.iter().map(|(at, _)| *at)).collect();
        instants.sort_unstable();
        for (at, _) in volts.iter().filter(|(at, _)| at % self.tick != 0) {
            let after = instants.partition_point(|instant| *instant < at - SLACK);
            if instants.get(after).is_none_or(|instant| *instant > at + SLACK) {
                return Err(format!("the voltage changes at {at}, where nothing happens"));
            }
        }
        Ok(())
    }

    fn check(&self, reported: &Reported) -> Result<usize, String> {
        let beams = &reported.lasers[0];
        self.switch(&beams.switch)?;
        self.rows(reported)?;
        let mut seen = beams.switch.len();
        if self.setup.mode == Mode::Analog {
            self.volts(&beams.volts)?;
            seen += beams.volts.len();
        } else {
            in_the_dark(&self.outcome, &beams.energy, self.made.horizon + self.tick, SLACK)?;
            seen += self.pulses(&beams.energy)?;
        }
        if !(reported.lasers[1].energy.is_empty()
            && reported.lasers[1].switch.is_empty()
            && reported.lasers[1].volts.is_empty())
        {
            return Err("the other channel does something".into());
        }
        let lit = reported.replies::<GetLaserOnTime>()[0].value.get();
        let mine = self.outcome.on_time(self.made.horizon + self.tick);
        let unit = 250_000;
        if !(mine - 100..=mine + 100).any(|mine| mine / unit == Ns::from(lit)) {
            return Err(format!("on-time {lit} of 250 µs, the model has {mine} ns"));
        }
        Ok(seen)
    }
}

fn run(machine: &Machine, setup: &Setup, number: u64) -> usize {
    let made = made(number, setup, machine.tick_ns);
    machine.reset();
    let reported = machine.try_run(&made.text);
    let outcome = reported.and_then(|reported| Model::new(setup, &made, machine.tick_ns).check(&reported));
    outcome.unwrap_or_else(|reason| {
        let acts: String = made.acts.iter().map(|(at, act)| format!("{at:>10} {act:?}\n")).collect();
        panic!("job {number}, {setup:?}, tick {}: {reason}\n{}\n{acts}", machine.tick_ns, numbered(&made.text))
    })
}

/// Shares the numbers below `count` among the cores; each has its machines.
fn shared(count: u64, each: impl Fn(&[Vec<Machine>; 2], u64) -> usize + Sync) -> u64 {
    let (next, seen) = (AtomicU64::new(0), AtomicU64::new(0));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                let machines = [Family::Gus, Family::Lsr]
                    .map(|family| TICKS.map(|tick| Machine::new(family, tick).traced(0, 1)).into_iter().collect());
                loop {
                    let number = next.fetch_add(1, Relaxed);
                    if number >= count {
                        break;
                    }
                    seen.fetch_add(each(&machines, number) as u64, Relaxed);
                }
            });
        }
    });
    seen.into_inner()
}

#[test]
fn every_combination_is_the_models() {
    let setups = table();
    let seen = shared(setups.len() as u64, |machines, number| {
        let setup = &setups[number as usize];
        let machine = &machines[usize::from(setup.family == Family::Lsr)][number as usize % TICKS.len()];
        run(machine, setup, number)
    });
    println!("{} combinations, {seen} edges", setups.len());
    assert!(seen > 20 * setups.len() as u64);
}

#[test]
fn random_jobs_are_the_models() {
    let jobs: u64 = std::env::var("LIGHT_JOBS").map_or(300, |text| text.parse().expect("a number"));
    let setups = table();
    let seen = shared(jobs, |machines, number| {
        let chance = &mut Chance::new(1 << 32 | number);
        let setup = &setups[chance.below(setups.len() as u64) as usize];
        let machine = &machines[usize::from(setup.family == Family::Lsr)][chance.below(TICKS.len() as u64) as usize];
        run(machine, setup, 1 << 32 | number)
    });
    println!("{jobs} jobs, {seen} edges");
    assert!(seen > 20 * jobs);
}

/// What the check of dark times must find.
#[test]
fn a_pulse_in_the_dark_is_found() {
    use host_tests::laser_model::Command;
    let whole = Exact::from_integer;
    let job = [
        (0, Command::PowerMode { mode: Mode::Duty, max: whole(100), min: whole(0), delayed: true }),
        (0, Command::Carrier(whole(10))),
        (0, Command::Power(whole(50))),
        (100_000, Command::Gate(true)),
        (1_000_000, Command::Gate(false)),
    ];
    let dark = outcome(Family::Gus, &job, 3_000_000);
    let check = |energy: &[Edge<bool>]| in_the_dark(&dark, energy, 3_000_000, 0);
    let energy = dark.energy.clone();
    assert_eq!(check(&energy), Ok(()));
    let with = |pulse: [Edge<bool>; 2]| {
        let mut energy = energy.clone();
        energy.extend(pulse);
        energy.sort_unstable();
        check(&energy)
    };
    assert!(with([(50_000, true), (50_010, false)]).is_err(), "before the light");
    assert!(with([(2_000_000, true), (2_000_001, false)]).is_err(), "after it");
    let mut late = energy.clone();
    late.last_mut().unwrap().0 = 1_100_001;
    assert!(check(&late).is_err(), "a last pulse of more than 100 µs");
    // Standby that comes too often, too rarely, too long.
    let job = [&job[..3], &[(0, Command::Standby(Some((whole(10), whole(10)))))], &job[3..]].concat();
    let dark = outcome(Family::Gus, &job, 3_000_000);
    let check = |energy: &[Edge<bool>]| in_the_dark(&dark, energy, 3_000_000, 0);
    assert_eq!(check(&dark.energy), Ok(()));
    let behind = dark.energy.iter().position(|edge| edge.0 > 2_000_000 && edge.1).unwrap();
    for (shift, end) in [(-50, -50), (50, 50), (0, 50), (0, -50)] {
        let mut energy = dark.energy.clone();
        energy[behind].0 += shift;
        energy[behind + 1].0 += end;
        assert!(check(&energy).is_err(), "{shift} {end}");
    }
}
