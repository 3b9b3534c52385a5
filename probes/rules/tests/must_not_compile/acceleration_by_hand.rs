//! An acceleration whose reciprocal is not its own.
use servo::ramp::Accel;

fn main() {
    let _ = Accel((1, 7));
}
