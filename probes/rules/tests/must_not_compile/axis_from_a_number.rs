//! An axis number that nobody compared with the capacity.
fn main() {
    let _ = servo::op::Op::Servo { axis: servo::units::Axis(99), on: true };
}
