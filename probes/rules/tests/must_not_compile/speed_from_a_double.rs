//! A double that has not passed the range check.
use servo::tick_command::TickCommand;
use servo::units::Axis;

fn main() {
    let axis = Axis::new(0).unwrap();
    let _ = TickCommand::TargetSpeed { axis, speed: 1e300 };
}
