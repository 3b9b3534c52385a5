//! A ratio of a velocity follow that no check has seen.
fn main() {
    let _ = servo::laser::Ratio { bits: u64::MAX };
}
