//! An axis number that nobody compared with the capacity.
fn main() {
    let _ = servo::tick_command::TickCommand::Servo { axis: servo::units::Axis(99), on: true };
}
