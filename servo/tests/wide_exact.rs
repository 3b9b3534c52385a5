//! Wide arithmetic against big integers, at the edges and over a seeded million.
use crate::chance;
use num_bigint::BigUint;
use servo::math::float::Float;
use servo::math::wide::{Divisor, Recip, mulhi_near, mulhi_su, narrow, recip32, recip64, recip64_below, scale16, umul};
use servo::units::Exact;

use chance::Chance;

fn edges() -> Vec<u64> {
    let mut all = vec![0, 1, 2, 3, u64::MAX, u64::MAX - 1];
    for k in 1..64 {
        let p = 1u64 << k;
        all.extend([p - 1, p, p + 1, p | p >> 1, !p]);
    }
    all
}

#[test]
fn products_are_exact() {
    let mut chance = Chance::new(1);
    let mut pairs: Vec<(u64, u64)> = edges().iter().flat_map(|&a| edges().into_iter().map(move |b| (a, b))).collect();
    pairs.extend((0..300_000).map(|_| (chance.any_width(), chance.any_width())));
    for (a, b) in pairs {
        let exact = a as u128 * b as u128;
        assert_eq!(umul(a, b), ((exact >> 64) as u64, exact as u64));
        let signed = ((a as i64 as i128) * b as i128) >> 64;
        assert_eq!(mulhi_su(a as i64, b) as i128, signed, "{a} {b}");
        let scaled = (BigUint::from(exact) * (b as u32)) >> 16;
        assert_eq!(BigUint::from(scale16(exact, b as u32)), scaled % (BigUint::from(1u8) << 128));
    }
}

#[test]
fn products_of_three_are_nearly_exact() {
    let mut chance = Chance::new(9);
    let mut pairs: Vec<(u64, u64)> = edges().iter().flat_map(|&a| edges().into_iter().map(move |b| (a, b))).collect();
    pairs.extend((0..300_000).map(|_| (chance.any_width(), chance.any_width())));
    for (a, b) in pairs {
        // The first of any size, the second of at most 2^62.
        for (a, b) in [(a as i64, b as i64 >> 1), (!a as i64, b as i64 >> 1)] {
            let short = ((a as i128 * b as i128) >> 64) - mulhi_near(a, b) as i128;
            assert!((-1..=2).contains(&short), "{a} {b}: {short}");
            assert_eq!(mulhi_near(b, a), mulhi_near(a, b));
        }
    }
}

#[test]
fn reciprocals_are_exact_floors() {
    let mut chance = Chance::new(2);
    let mut numbers = edges();
    numbers.extend((0..1_000_000).map(|_| chance.any_width()));
    for n in numbers.into_iter().filter(|&n| n > 0) {
        let d = n << n.leading_zeros();
        assert_eq!(recip64(d) as u128, u128::MAX / d as u128 - (1 << 64), "{d}");
        assert!(recip64(d).wrapping_sub(recip64_below(d)) <= 1 && recip64_below(d) <= recip64(d), "{d}");
        let d32 = ((d >> 32) as u32) | 1 << 31;
        assert_eq!(recip32(d32) as u64, u64::MAX / d32 as u64 - (1 << 32), "{d32}");
        let t = chance.next() % n;
        let exact = ((t as u128) << 64) / n as u128;
        let ratio = Recip::of(n).ratio(t) as u128;
        assert!(ratio <= exact && exact - ratio <= 2, "{t}/{n}: {ratio} {exact}");
    }
}

#[test]
fn quotients_are_exact() {
    let mut chance = Chance::new(3);
    for i in 0..1_000_000u32 {
        let n = ((chance.any_width() >> 33) as u32).max(1);
        let n = if i < 31 { (1u32 << i).max(1) } else { n };
        let x = (chance.any_width() as u128) << 64 | chance.any_width() as u128;
        let (q, r) = (x / n as u128, (x % n as u128) as u32);
        // n = 1 cannot round and the largest quotient cannot overflow.
        let nearest = q + (2 * r as u64 > n as u64) as u128;
        let (got, even) = Divisor::new(n).quotient(x);
        assert!(got == nearest || 2 * r as u64 == n as u64 && got == q, "{x} / {n}: {got} {nearest}");
        assert_eq!(even, r == 0);
        let y = chance.any_width();
        assert_eq!(Divisor::new(n).quotient64(y), y / n as u64);
    }
}

#[test]
fn narrowing_rounds_to_nearest() {
    let mut chance = Chance::new(4);
    for _ in 0..300_000 {
        let width = chance.next() % 126 + 1;
        let x = ((chance.next() as i128) << 64 | chance.next() as i128) >> (127 - width);
        let k = width as i32 - 62 + (chance.next() % 40) as i32 - 20;
        if !(-63..=127).contains(&k) || width as i32 - k > 62 {
            continue;
        }
        let exact = if k <= 0 { x << -k } else { ((x >> (k - 1)) + 1) >> 1 };
        assert_eq!(narrow(x, k) as i128, exact, "{x} {k}");
    }
}

/// Relative error of `got` against p/q, in units of 2⁻⁶⁰, must not exceed 1.
fn near(got: Float, p: &BigUint, q: &BigUint, what: &str) {
    // got = m·2^e with m from the fixed form at a scale that keeps 64 bits
    let shift = 64 - got.width();
    let m = got.to_fixed(shift).unsigned_abs();
    let (mut a, mut b) = (BigUint::from(m) * q, p.clone());
    if shift >= 0 {
        b <<= shift as usize
    } else {
        a <<= (-shift) as usize
    };
    let gap = if a > b { &a - &b } else { &b - &a };
    assert!(gap << 60 <= b, "{what}: {m} 2^-{shift}");
}

#[test]
fn reals_keep_sixty_bits() {
    let mut chance = Chance::new(5);
    let one = BigUint::from(1u8);
    for _ in 0..200_000 {
        let (a, b) = (chance.any_width().max(1), chance.any_width().max(1));
        let (x, y) = (Float::new(false, a, 0), Float::new(false, b, 0));
        near(x.mul(y), &(BigUint::from(a) * b), &one, "mul");
        near(x.add(y), &(BigUint::from(a) + b), &one, "add");
        near(x.div(y), &BigUint::from(a), &BigUint::from(b), "div");
        near(x.sub(y).abs(), &BigUint::from(a.abs_diff(b)), &one, "sub");
        // sqrt(a·2^120) as a whole number is good to 2^-60
        let root = (BigUint::from(a) << 128usize).sqrt();
        near(x.scale(128).sqrt(), &root, &one, "sqrt");
        near(x.scale(129).sqrt(), &(BigUint::from(a) << 129usize).sqrt(), &one, "sqrt, odd");
        // 1/sqrt: its square times x is 1.
        for x in [x, x.scale(1)] {
            let inverse = x.rsqrt();
            assert!(inverse.mul(inverse).mul(x).sub(Float::ONE).width() <= -55, "{x:?}");
        }
        let signed = Exact(((chance.next() as i128) << 40) >> (chance.next() % 100));
        if signed.0.unsigned_abs() >> 64 == 0 {
            assert_eq!(Float::from_exact(signed).to_exact(), signed);
        }
    }
    assert!(Float::ZERO.recip().is_zero() && Float::ONE.sub(Float::ONE).is_zero());
}
