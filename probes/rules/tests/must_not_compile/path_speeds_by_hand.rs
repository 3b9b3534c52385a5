//! Speeds along a path that nobody checked.
fn main() {
    let _ = servo::path::MotionSpeeds { vel: 0, acc: 0, end: 0 };
}
