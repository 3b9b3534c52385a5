//! The mean speed of an interval, which a laser's power follows: times the period it is the length
//! covered, whatever happens within the interval.
use crate::{chance, paths};
use chance::Chance;
use paths::{Heard, Script, speeds};
use servo::laser::PathSpeed;
use servo::path::{FifoEnds, Path, PathEntry};
use servo::segment::piece::{Motion, Recip};
use servo::units::Ns;

const BEGIN_NS: u64 = 1_000_000;
/// Rounding of a position, twice, and of what comes with it.
const TOLERANCE_PULSES: f64 = 1.01 / (1u64 << 22) as f64;

fn per_ms(speed: PathSpeed) -> f64 {
    speed.raw() as f64 / (1u64 << PathSpeed::FRAC_BITS) as f64
}

/// Lines along X, some entered at speed, some after a standstill or a wait.
fn lines(chance: &mut Chance) -> Vec<PathEntry> {
    let mut to = 0;
    let mut entries = vec![];
    for _ in 0..chance.below(12) + 2 {
        let vel = [0.4, 3.0, 50.0, 700.0][chance.below(4) as usize];
        let acc = [0.3, 2.0, 90.0][chance.below(3) as usize];
        let longest = [5, 300, 20_000][chance.below(3) as usize];
        to += 1 + chance.below(longest) as i32;
        let end = if chance.below(2) == 0 { 0.0 } else { vel };
        entries.push(PathEntry::planar([to, 0], speeds(vel, acc, end)));
        if chance.below(3) == 0 {
            entries.push(PathEntry::delay(chance.below(3) as u16));
        }
    }
    entries
}

/// Runs entries and compares each mean with the length of its interval; where `stop` is given, a
/// Stop comes there.
fn run(entries: Vec<PathEntry>, period: u64, stop: Option<u64>) -> u64 {
    let feed = FifoEnds { ends: [entries.len() as u32, 0] };
    let (script, mut heard, mut path) = (Script(entries), Heard::default(), Path::IDLE);
    path.start(Ns(BEGIN_NS), 0, feed, &script);
    let (mut now, mut before) = (BEGIN_NS, None);
    loop {
        if stop.is_some_and(|at| now >= at) && !path.stops() {
            path.stop(Ns(now), false, feed, &script, &mut heard);
        }
        let step = path.step(Ns(now), Ns(period), feed, &script, &mut heard);
        let x = step.position[0].0 as f64 / (1u64 << 22) as f64;
        if let Some((from, mean)) = before {
            let travelled: f64 = x - from;
            let off: f64 = mean * period as f64 / 1e6 - travelled;
            // Besides the rounding: of the speed over the period, and of the mean itself.
            assert!(
                off.abs() <= TOLERANCE_PULSES + travelled * 1e-9,
                "{period} ns at {}: {mean} over {travelled}, off {off:e}",
                now - BEGIN_NS
            );
        }
        before = Some((x, per_ms(path.mean(&step.motion, Ns(now), Ns(period)))));
        if !step.runs {
            return now;
        }
        now += period;
    }
}

#[test]
fn the_mean_speed_is_the_path_length_of_the_interval() {
    let mut chance = Chance::new(5);
    for _ in 0..12 {
        let entries = lines(&mut chance);
        for period in [10_000, 50_000, 250_000, 1_000_000] {
            run(entries.clone(), period, None);
        }
    }
}

#[test]
fn a_stop_is_followed_too() {
    let entries = vec![
        PathEntry::planar([400_000, 0], speeds(50.0, 2.0, 0.0)),
        PathEntry::planar([400_500, 0], speeds(3.0, 2.0, 0.0)),
    ];
    let over = run(entries.clone(), 250_000, Some(BEGIN_NS + 60_000_000));
    // 50 pulse/ms are braked at 1 pulse/ms².
    assert_eq!(over, BEGIN_NS + 110_000_000);
}

#[test]
fn at_rest_there_is_no_speed() {
    assert_eq!(PathSpeed::ahead(&Motion::STANDSTILL, Ns(1_000_000)), PathSpeed::STANDSTILL);
    assert_eq!(PathSpeed::measured([0; 4], Ns(10_000)), PathSpeed::STANDSTILL);
}

/// A piece of 2¹⁷ ns that speeds up from 1 to 3 pulse/ms: beyond its end, the end counts.
#[test]
fn a_piece_is_not_left() {
    // Over 2^17 ns at 1 pulse/ms it is 0.131072 pulses; so much more at the end is twice that.
    let by = (0.131072 * 2f64.powi(50)) as i64;
    let motion = Motion { tau: 0, c: [by, 2 * by, 0], recip: Recip { m: 0, shift: 47 }, frac: 50, t: 0 };
    let at = |period: u64| per_ms(PathSpeed::ahead(&motion, Ns(period)));
    for (period, speed) in [(0, 1.0), (1 << 16, 1.5), (1 << 17, 2.0), (1 << 18, 3.0), (1 << 20, 3.0), (1 << 40, 3.0)] {
        assert!((at(period) - speed).abs() < 1e-8, "{period}: {}", at(period));
    }
}

#[test]
fn encoders_are_the_norm_of_their_velocities() {
    let one = 1u64 << PathSpeed::FRAC_BITS;
    let measured =
        |pulses: [i64; 4], period: Ns| PathSpeed::measured(pulses.map(|by| by << PathSpeed::COUNT_BITS), period);
    assert_eq!(measured([3, -4, 0, 0], Ns(1_000_000)).raw(), 5 * one);
    assert_eq!(measured([1, 1, -1, 1], Ns(250_000)).raw(), 8 * one);
    assert_eq!(measured([0, 7, 0, 0], Ns(10_000)).raw(), 700 * one);
    // sqrt(2)·20 to the nearest 2^-30.
    let diagonal = measured([1, 0, 0, 1], Ns(50_000)).raw();
    assert_eq!(diagonal, (20.0 * 2f64.sqrt() * one as f64).round() as u64);
    // Far beyond what an axis can do it saturates.
    assert_eq!(PathSpeed::measured([i64::MIN; 4], Ns(10_000)).raw(), u64::MAX);
}
