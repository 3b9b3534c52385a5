//! Speeds along a path that nobody checked.
fn main() {
    let _ = servo::path::Along { vel: 0, acc: 0, end: 0 };
}
