//! A PT segment put together by hand.
fn main() {
    let _ = servo::segment::pt::Segment([1, 2, 3]);
}
