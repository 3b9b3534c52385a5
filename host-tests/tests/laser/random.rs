//! Random jobs for a laser channel: a setting of the table, then commands at random ticks.
use super::chance::Chance;
use host_tests::laser_model::{Command, Exact, Family, Fpk, Mode, Ns};

/// A row of the table.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    pub family: Family,
    pub mode: Mode,
    /// Off and on delay, µs.
    pub delays: (i64, i64),
    pub fpk: Option<Fpk>,
    /// Standby and pre-voltage.
    pub waiting: bool,
    /// Periods and widths need not be whole ns.
    pub wild: bool,
}

pub const MODES: [Mode; 4] = [Mode::Duty, Mode::Frequency, Mode::Analog, Mode::Open];
/// Off and on, µs: none, either the longer, on and beside the ticks, more than many marks, the
/// greatest.
pub const DELAYS: [(i64, i64); 10] =
    [(0, 0), (0, 30), (30, 0), (50, 50), (49, 51), (101, 7), (7, 101), (333, 250), (250, 999), (65535, 65535)];
const FPKS: [(i64, i64, i64); 7] =
    [(40, 60, 70), (1, 0, 0), (190, 60, 105), (60, 190, 30), (400, 0, 250), (50, 50, 50), (65535, 65535, 65535)];

pub fn table() -> impl Iterator<Item = Setup> {
    let families = [Family::Gus, Family::Lsr];
    families.into_iter().flat_map(|family| {
        MODES.into_iter().flat_map(move |mode| {
            DELAYS.into_iter().flat_map(move |delays| {
                [None, Some(0)].into_iter().flat_map(move |fpk: Option<usize>| {
                    [false, true].into_iter().map(move |waiting| Setup {
                        family,
                        mode,
                        delays,
                        fpk: fpk.map(|index| suppression(FPKS[index])),
                        waiting,
                        wild: false,
                    })
                })
            })
        })
    })
}

fn suppression((time1, time2, off): (i64, i64, i64)) -> Fpk {
    Fpk { time1: time1 * 1000, time2: time2 * 1000, off: off * 1000 }
}

fn whole(value: i128) -> Exact {
    Exact::from_integer(value)
}

fn pick<T: Copy>(chance: &mut Chance, from: &[T]) -> T {
    from[chance.below(from.len() as u64) as usize]
}

/// Frequencies whose period is a whole number of ns, kHz; with every duty below, the width is one
/// too.
const KHZ: [i128; 9] = [1, 2, 5, 10, 20, 50, 100, 250, 500];

/// Set where periods and widths need not be whole.
const WILD: [(i128, i128); 8] = [(1, 3), (7, 1), (30, 7), (33, 1), (107, 3), (300, 1), (1999, 1), (1234567, 1000)];

fn khz(chance: &mut Chance, wild: bool) -> Exact {
    if wild {
        let (n, d) = pick(chance, &WILD);
        return Exact::new(n, d);
    }
    whole(pick(chance, &KHZ))
}

/// Duties in %.
fn percent(chance: &mut Chance, wild: bool) -> Exact {
    if wild && chance.below(2) == 0 {
        return Exact::new(chance.below(1_000_001) as i128, 10_000);
    }
    let some =
        [whole(0), whole(1), whole(10), whole(25), Exact::new(25, 2), whole(50), whole(75), whole(99), whole(100)];
    pick(chance, &some)
}

fn power(chance: &mut Chance, mode: Mode, wild: bool) -> Exact {
    match mode {
        Mode::Duty | Mode::Open => percent(chance, wild),
        Mode::Frequency if chance.below(6) == 0 => whole(0),
        Mode::Frequency => khz(chance, wild),
        Mode::Analog => Exact::new(chance.below(41) as i128, 4),
    }
}

fn power_mode(chance: &mut Chance, mode: Mode) -> Command {
    let (max, low) = match mode {
        Mode::Duty | Mode::Open => (pick(chance, &[100, 100, 50]), 10),
        Mode::Frequency => (pick(chance, &[2000, 1000, 50]), 1),
        Mode::Analog => (pick(chance, &[10, 10, 5]), 1),
    };
    let min = whole(if chance.below(3) == 0 { low } else { 0 });
    Command::PowerMode { mode, max: whole(max), min, delayed: chance.below(3) != 0 }
}

fn width(chance: &mut Chance) -> Command {
    Command::Width(pick(chance, &[1, 2, 7, 10, 100, 150, 4000]) * 1000)
}

fn standby(chance: &mut Chance, wild: bool) -> Command {
    Command::Standby(Some((khz(chance, wild), percent(chance, wild))))
}

fn delays((off, on): (i64, i64)) -> Command {
    Command::Delays { off: off * 1000, on: on * 1000 }
}

/// A job for each channel; faults are common to both.
pub fn jobs(chance: &mut Chance, setup: &Setup, period: Ns, ticks: i64) -> [Vec<(Ns, Command)>; 2] {
    let first = job(chance, setup, period, ticks);
    let mut second = job(chance, setup, period, ticks);
    second.retain(|(_, command)| !matches!(command, Command::Fault | Command::Clear));
    // A Reset would clear a fault that has just come: the job ends before it.
    let near =
        |at: Ns| first.iter().any(|(fault, it)| *it == Command::Fault && (0..3 * period).contains(&(at - fault)));
    if let Some(reset) = second.iter().position(|(at, command)| *command == Command::Reset && near(*at)) {
        second.truncate(reset);
    }
    for (at, command) in &first {
        let place = match command {
            Command::Fault => second.partition_point(|(other, _)| other <= at),
            Command::Clear => second.partition_point(|(other, _)| other < at),
            _ => continue,
        };
        second.insert(place, (*at, command.clone()));
    }
    [first, second]
}

/// A job of so many ticks of `period`, with commands at ticks from 1 on.
pub fn job(chance: &mut Chance, setup: &Setup, period: Ns, ticks: i64) -> Vec<(Ns, Command)> {
    let mut at = period;
    let mut job = Vec::new();
    let mut mode = setup.mode;
    let mut faulty = false;
    let delayed = chance.below(4) != 0;
    if let Command::PowerMode { mode, max, min, .. } = power_mode(chance, mode) {
        job.push((at, Command::PowerMode { mode, max, min, delayed }));
    }
    job.push((at, delays(setup.delays)));
    job.push((at, Command::Fpk(setup.fpk)));
    if setup.waiting {
        job.push((at, standby(chance, setup.wild)));
        job.push((at, Command::PreVoltage(Some(whole(1)))));
    }
    if chance.below(16) != 0 {
        job.push((at, Command::Carrier(khz(chance, setup.wild))));
        job.push((at, width(chance)));
    }
    job.push((at, Command::Power(power(chance, mode, setup.wild))));
    while at < ticks * period {
        let command = match chance.below(100) {
            0..56 => Command::Gate(chance.below(2) == 0),
            56..70 => Command::Power(power(chance, mode, setup.wild)),
            70..75 => delays(pick(chance, &DELAYS)),
            75..79 => Command::Fpk(Some(suppression(pick(chance, &FPKS)))),
            79..82 => Command::Fpk(None),
            82..84 => standby(chance, setup.wild),
            84..86 => Command::Standby(None),
            86 => Command::PreVoltage(Some(Exact::new(chance.below(5) as i128, 2))),
            87 => Command::PreVoltage(None),
            88..90 => Command::Carrier(khz(chance, setup.wild)),
            90..92 => width(chance),
            92 => Command::ZeroOnTime,
            93 => Command::Connector(chance.below(3) != 0),
            94..97 => power_mode(chance, mode),
            97 if chance.below(4) == 0 => {
                mode = Mode::Duty;
                Command::Reset
            }
            97 => {
                mode = pick(chance, &MODES);
                power_mode(chance, mode)
            }
            _ => {
                // Nothing else comes at the instant of a fault. Some causes pass by themselves (see
                // `Bench`).
                faulty = !faulty;
                at += period;
                if !faulty && chance.below(2) == 0 {
                    // Too early, if by nothing but its place.
                    job.push((at, Command::Gate(true)));
                }
                let command = if faulty { Command::Fault } else { Command::Clear };
                job.push((at, command));
                if faulty && at / period % 3 != 0 && chance.below(2) == 0 {
                    faulty = false;
                    job.push((at + 2 * period, Command::Clear));
                }
                at += 3 * period;
                continue;
            }
        };
        job.push((at, command));
        // Often on the same tick, else a few ticks on.
        if chance.below(4) != 0 {
            at += period * (1 + chance.below(4) as i64);
        }
    }
    job.retain(|&(at, _)| at <= ticks * period);
    job
}
