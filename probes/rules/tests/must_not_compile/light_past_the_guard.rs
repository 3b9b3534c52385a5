//! Light given to a port by somebody else than the tick, whose plans pass the safety state machine
//! last.
use servo::laser::{Action, LaserPlan, Train};
use servo::port::Port;

fn shine(port: &mut impl Port, train: Train) {
    let mut plan = LaserPlan::EMPTY;
    plan.push(0, Action::Light(train));
    port.laser(0, &plan);
}

fn main() {}
