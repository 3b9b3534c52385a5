//! Bounds whose maximum is below their minimum.
use servo::laser::{Bounds, Power};

fn main() {
    let _ = Bounds { min: Power::MAX, max: Power::ZERO };
}
