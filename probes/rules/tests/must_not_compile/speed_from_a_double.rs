//! A double that has not passed the range check.
use servo::op::Op;
use servo::units::Axis;

fn main() {
    let axis = Axis::new(0).unwrap();
    let _ = Op::TargetSpeed { axis, speed: 1e300 };
}
