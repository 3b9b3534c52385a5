//! A channel made live again past its latch.
use servo::tick::Tick;

fn clear(tick: &mut Tick<8>) {
    let _ = &mut tick.lasers;
}

fn main() {}
