//! The trapezoid of one motion.
use super::{Frame, Rates};

/// A time of constant acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phase {
    /// pulse/ms².
    pub acc: f64,
    /// ms.
    pub ms: f64,
}

/// From a speed over a length to an end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    /// Up or down to the peak, at the peak, to the end.
    pub phases: [Phase; 3],
    /// Speed at the end, pulse/ms.
    pub end: f64,
}

/// What limits a motion: SPEC 5, first sentences of "Coordinate systems", and the override.
pub fn limits(frame: &Frame, rates: &Rates, rate: f64) -> Rates {
    let speed = rates.speed.min(frame.speed) * rate;
    Rates { speed, acc: rates.acc.min(frame.acc), end: rates.end.min(frame.speed).min(speed) }
}

/// The motion that begins with `begin` and has `length` still before it. `even_ms` is the least
/// time at constant speed.
pub fn profile(begin: f64, length: f64, limits: &Rates, even_ms: f64) -> Profile {
    let Rates { speed, acc, end } = *limits;
    let gain = 2.0 * acc * length;
    // The nearest speed that can be reached.
    let most = (begin * begin + gain).sqrt();
    let least = (begin * begin - gain).max(0.0).sqrt();
    // The square root of what rounding leaves over is no speed.
    let beyond = begin * begin - gain - end * end > 1e-11 * begin * begin;
    let end = if beyond { least } else { end.min(most) };
    // Without a cruise, the peak is where the ramps meet.
    let meet = ((gain + begin * begin + end * end) / 2.0).sqrt();
    let mut peak = meet.min(speed).max(end);
    if even_ms > 0.0 && begin <= peak {
        // Cruise (length − ramps)/peak = even: peak²/acc + even·peak − (length + (begin² +
        // end²)/2acc) = 0.
        let rest = length + (begin * begin + end * end) / (2.0 * acc);
        let lowered = 2.0 * rest / (even_ms + (even_ms * even_ms + 4.0 * rest / acc).sqrt());
        peak = lowered.min(peak).max(begin.max(end));
    }
    let ramp = |from: f64, to: f64| (from - to).abs() * (from + to) / (2.0 * acc);
    let cruise = (length - ramp(begin, peak) - ramp(peak, end)).max(0.0);
    let cruise_ms = if peak > 0.0 { cruise / peak } else { 0.0 };
    // What rounding leaves over is no cruise, where the ramps meet.
    let cruise_ms = if peak == meet && peak != speed { 0.0 } else { cruise_ms };
    let phase = |from: f64, to: f64| Phase { acc: if to > from { acc } else { -acc }, ms: (to - from).abs() / acc };
    Profile { phases: [phase(begin, peak), Phase { acc: 0.0, ms: cruise_ms }, phase(peak, end)], end }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::chance::Chance;

    fn rates(speed: f64, acc: f64, end: f64) -> Rates {
        Rates { speed, acc, end }
    }

    fn times(begin: f64, length: f64, limits: Rates, even: f64) -> ([f64; 3], f64) {
        let profile = profile(begin, length, &limits, even);
        (profile.phases.map(|phase| (phase.ms * 1e9).round() / 1e9), (profile.end * 1e9).round() / 1e9)
    }

    /// Worked out by hand.
    #[test]
    fn trapezoids() {
        // 10 up in 5 ms over 25, down the same, 450 at 10.
        assert_eq!(times(0.0, 500.0, rates(10.0, 2.0, 0.0), 0.0), ([5.0, 45.0, 5.0], 0.0));
        // Too short: 2·v²/(2·2) = 32 → v = 8.
        assert_eq!(times(0.0, 32.0, rates(10.0, 2.0, 0.0), 0.0), ([4.0, 0.0, 4.0], 0.0));
        // The end cannot be reached: √(2·2·4) = 4.
        assert_eq!(times(0.0, 4.0, rates(10.0, 2.0, 9.0), 0.0), ([2.0, 0.0, 0.0], 4.0));
        // Too fast to stop: √(100 − 2·2·16) = 6.
        assert_eq!(times(10.0, 16.0, rates(10.0, 2.0, 0.0), 0.0), ([0.0, 0.0, 2.0], 6.0));
        // Entered above its speed: 10 to 6 over 16, then 84 at 6, then 6 to 2 over 8.
        assert_eq!(times(10.0, 108.0, rates(6.0, 2.0, 2.0), 0.0), ([2.0, 14.0, 2.0], 2.0));
        // 10 ms at constant speed: p²/2 + 10 p = 100 + 0 → p = √300 − 10, ramps of p/2 ms.
        let p = (300f64.sqrt() - 10.0) / 2.0;
        let round = (p * 1e9).round() / 1e9;
        assert_eq!(times(0.0, 100.0, rates(20.0, 2.0, 0.0), 10.0), ([round, 10.0, round], 0.0));
        // Only as far as the end allows.
        assert_eq!(times(0.0, 25.0, rates(20.0, 2.0, 10.0), 10.0), ([5.0, 0.0, 0.0], 10.0));
    }

    #[test]
    fn length_and_speed_add_up() {
        let mut chance = Chance::new(1);
        let mut chance = || chance.unit();
        for _ in 0..100_000 {
            let limits = rates(0.1 + 100.0 * chance(), 0.01 + 10.0 * chance(), 0.0);
            let limits = Rates { end: limits.speed * (2.0 * chance() - 1.0).max(0.0), ..limits };
            let begin = limits.speed * (3.0 * chance() - 1.0).max(0.0);
            let (length, even) = (1.0 + 1000.0 * chance() * chance(), (10.0 * chance() - 5.0).max(0.0));
            let profile = profile(begin, length, &limits, even);
            let (mut distance, mut speed) = (0.0, begin);
            for phase in profile.phases {
                assert!(phase.ms >= 0.0);
                distance += speed * phase.ms + phase.acc * phase.ms * phase.ms / 2.0;
                speed += phase.acc * phase.ms;
                assert!(speed <= limits.speed.max(begin) + 1e-9);
            }
            assert!((distance - length).abs() < 1e-9 * (1.0 + length), "{distance} {length}");
            assert!((speed - profile.end).abs() < 1e-9);
        }
    }
}
