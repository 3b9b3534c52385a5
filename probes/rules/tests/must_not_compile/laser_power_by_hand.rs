//! A laser power that has not passed the range check.
use servo::laser::{Change, Power};

fn main() {
    let _ = Change::Direct { power: Power(1 << 62), fine: None };
}
