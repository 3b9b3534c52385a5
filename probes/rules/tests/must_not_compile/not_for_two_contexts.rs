//! A value that is not for another context, in a lane that both share.
use ring::Ring;
use std::cell::Cell;

fn shared<T: Sync>(_: &T) {}

fn main() {
    shared(&Ring::<&'static Cell<u8>, 4>::new());
}
