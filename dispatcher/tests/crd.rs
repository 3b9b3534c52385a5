//! Coordinate systems through the whole controller: from calls to positions.
mod bench;

use bench::crd::*;
use bench::*;
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;

/// A line of 10000 pulses at 50 pulse/ms and 2 pulse/ms²: 25 ms up, 175 ms along, 25 ms down.
#[test]
fn a_line_takes_its_trapezoid() {
    let mut bench = Bench::gus();
    plane(&mut bench);
    bench.done(line(10_000, 0, 50.0, 2.0));
    assert_eq!(status(&mut bench, 0), (0, 0));
    bench.done(start_crd(1));
    assert_eq!(status(&mut bench, 0).0, 1);
    assert_ne!(bench.status_word(1) & 1 << 10, 0);
    let begun = bench.now().0;
    while status(&mut bench, 0).0 == 1 {
        bench.step();
    }
    let took = (bench.now().0 - begun) as f64 / 1e6;
    assert!((224.0..227.0).contains(&took), "{took}");
    assert_eq!((bench.pos(1), bench.pos(2)), (10_000.0, 0.0));
    assert_eq!(status(&mut bench, 0), (0, 1));
    assert_eq!(bench.status_word(1) & 1 << 10, 0);
    assert_eq!(crd_pos(&mut bench), [10_000.0, 0.0]);
}
