//! An entry of a Follow FIFO put together by hand.
fn main() {
    let _ = servo::segment::follow::FollowEntry([0; 6]);
}
