//! Numbers of a job, quickly: long programs are made of them.
//!
//! In: a number. Out: the shortest digits that read back as it, without an exponent, as `Display`
//! of f64 writes them; of two that are as near the last digit may be the other one.
use std::fmt::{Display, Formatter, Result};

/// A number of a job.
pub struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, out: &mut Formatter<'_>) -> Result {
        let mut buffer = zmij::Buffer::new();
        let text = buffer.format(self.0);
        // Exponents, and what is no number.
        if !text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.' || byte == b'-') {
            return Display::fmt(&self.0, out);
        }
        out.write_str(text.strip_suffix(".0").unwrap_or(text))
    }
}

#[cfg(test)]
mod tests {
    use super::Number;
    use rand_xoshiro::SplitMix64;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    #[test]
    fn numbers_are_as_short_as_display_writes_them_and_read_back() {
        let mut chance = SplitMix64::seed_from_u64(0);
        let random = std::iter::repeat_with(|| chance.next_u64());
        let edges = [0.0, -0.0, 0.1, 50.0, -2.5, 1e-5, 9.9e-6, 1e15, 1e16, 1e17, 1e21, f64::MIN_POSITIVE, f64::MAX];
        let special = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        let all = edges.into_iter().chain(special);
        let common = random.take(100_000).flat_map(|bits| [f64::from_bits(bits), (bits >> 20) as f64 / 1e6]);
        for value in all.chain(common) {
            let text = Number(value).to_string();
            assert_eq!(text.len(), value.to_string().len(), "{text} {value}");
            let same = text.parse::<f64>().unwrap().to_bits() == value.to_bits();
            assert!(same || value.is_nan(), "{text} {value}");
        }
    }
}
