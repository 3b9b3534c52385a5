//! A speed that no check has seen.
use servo::piece::Scaled;

fn main() {
    let _ = servo::ramp::Speed(Scaled { m: i64::MAX, e: -900 });
}
