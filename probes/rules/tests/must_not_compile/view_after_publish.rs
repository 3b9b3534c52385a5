//! A view that is filled after it was handed over.
use ring::Latest;

fn main() {
    let latest = Latest::new(0);
    let (mut writer, _reader) = latest.split_once().unwrap();
    let buffer = writer.buffer();
    writer.publish();
    *buffer = 1;
}
