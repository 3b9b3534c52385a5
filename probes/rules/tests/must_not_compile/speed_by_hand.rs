//! A speed that no check has seen.
use servo::segment::piece::Scaled;

fn main() {
    let _ = servo::segment::ramp::Speed(Scaled { m: i64::MAX, e: -900 });
}
