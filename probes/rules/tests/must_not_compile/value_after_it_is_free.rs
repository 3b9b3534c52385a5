//! A value looked at where it lies, after its place was given back.
use ring::Ring;

fn main() {
    let lane: Ring<u8, 4> = Ring::new();
    let (_producer, mut consumer) = lane.split_once().unwrap();
    let value = consumer.peek();
    consumer.skip();
    let _ = value;
    assert!(value.is_none());
}
