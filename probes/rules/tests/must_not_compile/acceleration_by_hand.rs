//! An acceleration whose reciprocal is not its own.
use servo::piece::Scaled;
use servo::ramp::Accel;

fn main() {
    let one = Scaled { m: 1, e: 0 };
    let _ = Accel { value: one, recip: Scaled { m: 7, e: 0 } };
}
