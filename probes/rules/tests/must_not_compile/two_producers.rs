//! Two contexts that push into one lane.
use ring::Ring;

fn main() {
    let lane: Ring<u8, 4> = Ring::new();
    let (producer, _consumer) = lane.split_once().unwrap();
    let mut first = producer;
    let mut second = producer;
    let _ = (first.push(1), second.push(2));
}
