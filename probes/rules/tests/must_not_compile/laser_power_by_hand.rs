//! A laser power that has not passed the range check.
use servo::laser::{ChannelChange, Power};

fn main() {
    let _ = ChannelChange::Direct { power: Power(1 << 62), fixed: None };
}
