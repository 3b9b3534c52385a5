//! Bounds whose maximum is below their minimum.
use servo::laser::{PowerBounds, Power};

fn main() {
    let _ = PowerBounds { min: Power::MAX, max: Power::ZERO };
}
