//! An entry of a path put together by hand.
fn main() {
    let _ = servo::path::PathEntry([0; 8]);
}
