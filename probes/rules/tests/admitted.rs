//! The right way round: everything that enters a lane has passed servo's checks.
use ring::Ring;
use servo::laser::{ChannelChange, Power};
use servo::segment::ramp::{Accel, Speed};
use servo::tick_command::{LaneEntry, TickCommand};
use servo::units::{Axis, Ns, StepLimit};

fn main() {
    let axis = Axis::new(3).expect("below the capacity");
    let acc = Accel::admit(0.25f64.to_bits()).expect("positive");
    let speed = Speed::admit(50f64.to_bits(), StepLimit::FULL_SCALE).expect("below full scale");
    let lane: Ring<LaneEntry, 4> = Ring::new();
    let (mut producer, _consumer) = lane.split_once().expect("once");
    let power = Power::admit(37.5f64.to_bits()).expect("in range");
    let laser = TickCommand::Laser { channel: 0, change: ChannelChange::Direct { power, fixed: None } };
    for command in
        [TickCommand::TargetSpeed { axis, speed }, TickCommand::JogPrm { axis, acc, dec: acc, smooth: 0 }, laser]
    {
        assert!(producer.push(LaneEntry { seq: 0, delay: Ns(0), command }).is_ok());
    }
}
