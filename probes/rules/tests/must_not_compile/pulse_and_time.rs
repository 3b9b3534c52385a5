//! A position added to a time.
use servo::units::{Ns, Pos};

fn main() {
    let _ = Pos::pulses(1) + Ns(1);
}
