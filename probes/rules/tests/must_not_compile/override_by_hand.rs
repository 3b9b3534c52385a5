//! An override that no check has seen.
fn main() {
    let _ = servo::path::Rate(u64::MAX);
}
