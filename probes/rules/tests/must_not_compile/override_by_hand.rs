//! An override that no check has seen.
fn main() {
    let _ = servo::path::FeedOverride(u64::MAX);
}
