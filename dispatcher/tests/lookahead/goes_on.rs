//! A path goes on after a Stop wherever it came to rest: arcs have a reserve of acceleration.
use super::{Call, Heard, LIMITS, Script, plan, spiral, wander};
use dispatcher::plan::geometry::{Geometry, Position};
use servo::path::{FifoEnds, Path, PathEntry, Plane};
use servo::units::Ns;

/// ns.
const TICK_NS: u64 = 20_000;

/// How long the path takes, ms, with an abrupt Stop after this time and a start at once.
fn time(entries: &[PathEntry], stop: Option<u64>) -> f64 {
    let script = Script(entries.to_vec());
    let feed = FifoEnds { ends: [entries.len() as u32, 0] };
    let (mut path, mut heard, mut now) = (Box::new(Path::IDLE), Heard::default(), 1_000_000);
    path.start(Ns(now), 0, feed, &script);
    loop {
        if stop.is_some_and(|stop| now == 1_000_000 + stop) {
            path.stop(Ns(now), true, feed, &script, &mut heard);
            path.start(Ns(now), 0, feed, &script);
        }
        if !path.step(Ns(now), Ns(TICK_NS), feed, &script, &mut heard).runs {
            return (now - 1_000_000) as f64 / 1e6;
        }
        now += TICK_NS;
    }
}

/// What Stops at instants all over the path cost at most, ms.
fn worst(calls: &[Call]) -> f64 {
    let entries = plan::<256>(calls);
    let whole = time(&entries, None);
    let stops = (1..60).map(|part| (whole * 1e6) as u64 * part / 60 / TICK_NS * TICK_NS);
    stops.map(|stop| time(&entries, Some(stop)) - whole).fold(0.0, f64::max)
}

/// On an arc that takes all of its limit L = 1 across it, a start has L/16 along it, so that it
/// costs half of v·16/L. Without the reserve it took minutes.
#[test]
fn a_start_on_an_arc_at_its_limit_costs_what_a_sixteenth_of_the_limit_takes() {
    let from: Position = [0.0; 4];
    let circle = Geometry::arc_centre(&from, Plane::Xy, [0, 0], [0.0, 1000.0], true).unwrap();
    let calls = [Call { geometry: circle, vel: 100.0, acc: 5.0 }; 6];
    let speed = (1000.0f64 * (1.0 - 1.0 / 256.0f64).sqrt()).sqrt();
    let exact = speed * 16.0 / 2.0;
    let worst = worst(&calls);
    assert!((worst - exact).abs() < 0.001 * exact, "{worst} {exact}");
}

/// Where corners take all of a coordinate's limit, not many such lines follow each other: a start
/// costs no more than on an arc.
#[test]
fn a_start_on_fine_lines_costs_no_more() {
    for calls in [&spiral()[..2000], &wander(false)[..1000], &wander(true)[..1000]] {
        let fastest = LIMITS.vel[0].hypot(LIMITS.vel[1]);
        let worst = worst(calls);
        println!("{worst:.1} ms");
        assert!(worst > 10.0 && worst < fastest * 16.0 / 2.0, "{worst}");
    }
}
