//! An acceleration whose reciprocal is not its own.
use servo::segment::ramp::Accel;

fn main() {
    let _ = Accel((1, 7));
}
