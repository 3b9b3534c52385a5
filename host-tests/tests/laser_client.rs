//! Laser jobs through everything: calls of a program over the link, the dispatcher with its family
//! rules and its planning ahead, the tick, the virtual controller's output stages; every edge is
//! the model's.
#[path = "laser/cases.rs"]
#[allow(dead_code, reason = "each test file uses its part")]
mod cases;
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
#[path = "laser/random.rs"]
#[allow(dead_code, reason = "each test file uses its part")]
mod random;

use cases::{CASE_END_US, cases};
use chance::Chance;
use client::{Answer, Call, Client, Observer, Options};
use host_tests::laser_model::{Command, Edge, Exact, Family, Job, Mode, Ns, Outcome, outcome};
use plant::beam::SignalChange;
use protocol::command::*;
use random::{Setup, job, table};
use virtual_board::{Board, Config, Shared, VirtualLink, share};
use zerocopy::little_endian::{F64, U32};

struct Nothing;

impl Observer for Nothing {
    fn answered(&mut self, answer: Answer) -> client::Result<()> {
        assert_eq!(answer.code, 0, "{answer:?}");
        Ok(())
    }
}

fn real(value: Exact) -> F64 {
    (*value.numer() as f64 / *value.denom() as f64).into()
}

fn us(ns: Ns) -> U32 {
    u32::try_from(ns / 1000).unwrap().into()
}

fn call(command: &Command, channel: i16) -> Call {
    let (core, channel) = (1.into(), channel.into());
    match *command {
        Command::Gate(on) => Call::of(SetHSIOOpt { core, value: u16::from(on).into(), channel }),
        Command::PowerMode { mode, max, min, delayed } => {
            let mode: i16 = match mode {
                Mode::Duty => 0,
                Mode::Frequency => 1,
                Mode::Analog => 2,
                Mode::Open => 3,
            };
            let delay_mode = i16::from(delayed).into();
            Call::of(LaserPowerMode { core, mode: mode.into(), max: real(max), min: real(min), channel, delay_mode })
        }
        Command::Power(power) => Call::of(LaserPrfCmd { core, power: real(power), channel }),
        Command::Carrier(khz) => Call::of(LaserOutFrq { core, frequency: real(khz), channel }),
        Command::Width(width) => Call::of(SetPulseWidth { core, width_us: us(width), channel }),
        Command::Delays { off, on } => {
            Call::of(SetLevelDelay { core, off_delay_us: us(off), on_delay_us: us(on), channel })
        }
        Command::Fpk(Some(fpk)) => Call::of(EnaFPK {
            core,
            time1_us: us(fpk.time1),
            time2_us: us(fpk.time2),
            laser_off_delay_us: us(fpk.off),
            channel,
        }),
        Command::Fpk(None) => Call::of(DisFPK { core, channel }),
        Command::Standby(standby) => {
            let (khz, percent) = standby.unwrap_or((Exact::from_integer(1), Exact::from_integer(0)));
            let mode = u16::from(standby.is_some()).into();
            Call::of(SetWaitPulse { core, mode, frequency: real(khz), duty: real(percent), channel })
        }
        Command::PreVoltage(volts) => Call::of(SetPreVltg {
            core,
            mode: u16::from(volts.is_some()).into(),
            voltage: real(volts.unwrap_or(Exact::from_integer(0))),
            channel,
        }),
        Command::ZeroOnTime => Call::of(ZeroLaserOnTime { core, channel }),
        Command::Connector(_) | Command::Reset | Command::Fault | Command::Clear => {
            unreachable!("not of a program here")
        }
    }
}

fn belongs(command: &Command) -> bool {
    !matches!(command, Command::Connector(_) | Command::Reset | Command::Fault | Command::Clear)
}

/// Edges of a channel's outputs.
struct Edges {
    energy: Vec<Edge<bool>>,
    switch: Vec<Edge<bool>>,
    volts: Vec<Edge<i16>>,
}

/// A controller and a client of a family.
struct Rig {
    board: Shared,
    client: Client,
    family: Family,
    tick: Ns,
}

impl Rig {
    fn new(family: Family, tick: Ns) -> Rig {
        let board = share(Board::new(Config { tick_us: (tick / 1000) as u32, ..Config::default() }));
        let client_family = match family {
            Family::Gus => client::Family::Gus,
            Family::Lsr => client::Family::Lsr,
        };
        let options = Options { family: Some(client_family), ..Options::default() };
        let client = Client::open(Box::new(VirtualLink::new(board.clone())), options).unwrap();
        board.lock().unwrap().record_beam(true);
        Rig { board, client, family, tick }
    }

    /// Runs a job on a channel from power-on; edges in times of the job.
    fn run(&self, job: &Job, channel: i16, horizon: Ns) -> Edges {
        self.client.call(Reset { core: 1.into() }).unwrap();
        self.client.sleep(std::time::Duration::from_millis(2)).unwrap();
        self.board.lock().unwrap().take_beam();
        let axis = (7 + channel).into();
        let mut calls = match self.family {
            Family::Gus => vec![Call::of(SetAxisMode { core: 1.into(), axis, mode: 1.into() })],
            Family::Lsr => vec![Call::of(SetLaserMode { core: 1.into(), mode: 0.into() })],
        };
        // A call at s acts on the first tick after s.
        let mut clock = 0;
        for (at, command) in job {
            if *at - self.tick > clock {
                calls.push(Call::of(Sleep { ns: ((at - self.tick - clock) as u64).into() }));
                clock = at - self.tick;
            }
            calls.push(call(command, channel));
        }
        calls.push(Call::of(Sleep { ns: ((horizon - clock) as u64).into() }));
        let summary = self.client.run(calls, true, &mut Nothing).unwrap();
        assert_eq!(summary.failed, None);
        let mut board = self.board.lock().unwrap();
        let zero = board.program_zero_ns() as Ns;
        let (mut energy, mut switch, mut volts) = (Vec::new(), Vec::new(), Vec::new());
        for beam in board.take_beam() {
            assert_eq!(i16::from(beam.channel), channel, "the other channel rests");
            match beam.change {
                SignalChange::Switch { at, level } => switch.push((at as Ns - zero, level)),
                SignalChange::Energy { at, level } => energy.push((at as Ns - zero, level)),
                SignalChange::Dac { at, code } => volts.push((at as Ns - zero, code)),
                SignalChange::Pulses(burst) => {
                    for (begin, end) in burst.pulses().filter(|(begin, end)| begin < end) {
                        energy.extend([(begin as Ns - zero, true), (end as Ns - zero, false)]);
                    }
                }
            }
        }
        fn before<T: Copy + PartialEq>(edges: Vec<Edge<T>>, rest: T, horizon: Ns) -> Vec<Edge<T>> {
            let mut left: Vec<Edge<T>> = Vec::new();
            for (at, level) in edges.into_iter().filter(|&(at, _)| at < horizon) {
                left.pop_if(|last| last.0 == at);
                if left.last().map_or(rest, |&(_, level)| level) != level {
                    left.push((at, level));
                }
            }
            left
        }
        Edges {
            energy: before(energy, false, horizon),
            switch: before(switch, false, horizon),
            volts: before(volts, 0, horizon),
        }
    }

    /// Compares; returns how many edges there were.
    fn check(&self, name: &str, job: &Job, channel: i16, horizon: Ns) -> usize {
        let Edges { energy, switch, volts } = self.run(job, channel, horizon);
        let Outcome { energy: e, switch: s, analog, .. } = outcome(self.family, job, horizon);
        let listed = || job.iter().map(|(at, command)| format!("{at:>12} {command:?}\n")).collect::<String>();
        assert_eq!(switch, s, "{name}: switch, {:?}\n{}", self.family, listed());
        assert_eq!(energy, e, "{name}: energy, {:?}\n{}", self.family, listed());
        // 32767 is 10 V; to half a step.
        let half = Exact::new(1, 2);
        let near = |code: i16, volts: Exact| {
            let off = Exact::from_integer(code.into()) - volts * Exact::new(32767, 10);
            -half <= off && off <= half
        };
        let same = volts.len() == analog.len() && volts.iter().zip(&analog).all(|(a, b)| a.0 == b.0 && near(a.1, b.1));
        assert!(same, "{name}: {volts:?} for {analog:?}");
        switch.len() + energy.len() + volts.len()
    }
}

#[test]
fn the_rules_hold_over_the_link() {
    let rigs = [Rig::new(Family::Gus, 10_000), Rig::new(Family::Lsr, 10_000)];
    let (mut count, mut edges) = (0, 0);
    for case in cases() {
        if case.job.iter().all(|(_, command)| belongs(command)) {
            let rig = rigs.iter().find(|rig| rig.family == case.family).unwrap();
            edges += rig.check(case.name, &case.job, count % 2, CASE_END_US * 1000);
            count += 1;
        }
    }
    assert!(count > 30 && edges > 250, "{count} rules, {edges} edges");
}

/// What LSR would hold in its own range is brought there for the model too.
fn fit(family: Family, command: &mut Command) {
    if family == Family::Lsr {
        let most = Exact::from_integer(50);
        match command {
            Command::PowerMode { mode: Mode::Frequency, max, .. } => *max = (*max).min(most),
            Command::Carrier(khz) | Command::Standby(Some((khz, _))) => *khz = (*khz).min(most),
            _ => {}
        }
    }
}

#[test]
fn random_jobs_over_the_link_are_the_models() {
    let chance = &mut Chance::new(7);
    let mut edges = 0;
    let setups: Vec<Setup> = table().collect();
    for (family, tick) in
        [(Family::Gus, 10_000), (Family::Lsr, 50_000), (Family::Gus, 250_000), (Family::Lsr, 1_000_000)]
    {
        let rig = Rig::new(family, tick);
        let setups: Vec<&Setup> = setups.iter().filter(|setup| setup.family == family).collect();
        for number in 0..100 {
            let setup = setups[chance.below(setups.len() as u64) as usize];
            let ticks = 4 + chance.below(30) as i64;
            let mut job = job(chance, setup, tick, ticks);
            job.retain(|(_, command)| belongs(command));
            job.iter_mut().for_each(|(_, command)| fit(family, command));
            edges += rig.check(&format!("job {number}"), &job, number % 2, (ticks + 20) * tick);
        }
    }
    assert!(edges > 10_000, "{edges} edges");
}
