//! The instants of a path that is started and left alone, in exact arithmetic: what the model's
//! doubles are held to. Numbers have 160 bits after the point and any number before it; the
//! lengths of arcs, which have π in them, are the model's.
use host_tests::path_model::{Entry, Frame, Geometry};
use num_bigint::BigInt;

/// Units of a number.
const BITS: u32 = 160;

fn number(value: f64) -> BigInt {
    let bits = value.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as i32;
    let mantissa = BigInt::from(bits & ((1 << 52) - 1) | if exponent == 0 { 0 } else { 1 << 52 });
    let shift = BITS as i32 + exponent.max(1) - 1075;
    assert!(value >= 0.0 && (value == 0.0 || shift >= 0), "{value} is not a whole number of units");
    if value == 0.0 { BigInt::ZERO } else { mantissa << shift }
}

fn mul(a: &BigInt, b: &BigInt) -> BigInt {
    (a * b) >> BITS
}

fn div(a: &BigInt, b: &BigInt) -> BigInt {
    (a << BITS) / b
}

fn root(a: &BigInt) -> BigInt {
    (a << BITS).sqrt()
}

fn length(geometry: &Geometry) -> BigInt {
    match geometry {
        Geometry::Line { from, to } => {
            let square = |axis: usize| number((to[axis] - from[axis]).abs()).pow(2) >> BITS;
            root(&(0..4).map(square).sum())
        }
        Geometry::Arc { .. } => number(geometry.length()),
    }
}

/// The time of a motion, and the speed at its end: SPEC 5, first sentences of "Coordinate systems".
fn motion(begin: &BigInt, length: &BigInt, limits: [&BigInt; 3], even: &BigInt) -> (BigInt, BigInt) {
    let [speed, acc, end] = limits;
    let (from, gain) = (mul(begin, begin), mul(acc, length) * 2);
    let low = &from - &gain;
    let end = if low > mul(end, end) { root(&low) } else { end.min(&root(&(&from + &gain))).clone() };
    let to = mul(&end, &end);
    let mut peak = root(&((&gain + &from + &to) / 2)).min(speed.clone()).max(end.clone());
    if *even > BigInt::ZERO && *begin <= peak {
        // The peak of which a cruise of that time is left: peak²/acc + even·peak = length + (from +
        // to)/2acc.
        let rest = length + div(&((&from + &to) / 2), acc);
        let lowered = div(&(&rest * 2), &(even + root(&(mul(even, even) + div(&(&rest * 4), acc)))));
        peak = lowered.min(peak).max(begin.max(&end).clone());
    }
    let change = |a: &BigInt, b: &BigInt| if a > b { a - b } else { b - a };
    let ramps = change(begin, &peak) + change(&peak, &end);
    let square = mul(&peak, &peak);
    let ways = div(&((change(&from, &square) + change(&square, &to)) / 2), acc);
    let cruise = if ways < *length { div(&(length - ways), &peak) } else { BigInt::ZERO };
    (div(&ramps, acc) + cruise, end)
}

/// When each effect is reached, and the end, ms from the start.
pub fn instants(frame: &Frame, entries: &[Entry]) -> (Vec<BigInt>, BigInt) {
    let (mut now, mut speed) = (BigInt::ZERO, BigInt::ZERO);
    let mut effects = Vec::new();
    for (index, entry) in entries.iter().enumerate() {
        match entry {
            Entry::Effect(_) | Entry::Laser(_) => effects.push(now.clone()),
            Entry::Delay(ms) => (now, speed) = (now + number((*ms).into()), BigInt::ZERO),
            Entry::Motion(geometry, rates) => {
                let next = entries[index + 1..].iter().find(|entry| !entry.is_effect());
                let most = number(rates.speed.min(frame.speed));
                let end = match next {
                    Some(Entry::Motion(..)) => number(rates.end).min(most.clone()),
                    _ => BigInt::ZERO,
                };
                let acc = number(rates.acc.min(frame.acc));
                let (ms, end) = motion(&speed, &length(geometry), [&most, &acc, &end], &number(frame.even_ms));
                (now, speed) = (now + ms, end);
            }
        }
    }
    (effects, now)
}

/// How far a double is from a number, as parts of 1.
pub fn apart(double: f64, exact: &BigInt) -> f64 {
    let off = number(double) - exact;
    let parts = (off >> (BITS - 80)).to_string().parse::<f64>().expect("a number");
    parts.abs() / 2f64.powi(80)
}
