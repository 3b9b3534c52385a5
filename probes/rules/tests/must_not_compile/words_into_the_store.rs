//! Words that are no admitted segment, on their way to the tick.
use servo::segment::pt::{Segment, SegmentStore};

fn main() {
    let store = SegmentStore::new();
    store.write(0, [1, 2, 3]);
    store.write(1, Segment::from_words([1, 2, 3]));
}
