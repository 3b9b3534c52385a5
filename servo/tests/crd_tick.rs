//! Coordinate systems in the tick: where mapped axes are, what stops them, what starts.
use servo::op::Mode;
use servo::path::{Along, Entry, Rest};
use servo::status;
use servo::units::Pos;
use servo::view::{Event, StopReason, View};

mod tick_bench;
use tick_bench::*;

fn speeds(vel: f64, acc: f64, end: f64) -> Along {
    Along::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap()
}

fn line(x: i32, y: i32) -> Entry {
    Entry::planar([x, y], speeds(10.0, 1.0, 0.0))
}

/// A coordinate system on axes 2 and 5 with these entries in FIFO 0.
fn ready(period_us: u32, entries: &[Entry]) -> Bench {
    let mut bench = Bench::ready(period_us, Mode::Trap);
    bench.frame(0, &[2, 5], Some([100, -50, 0, 0]));
    bench.tick();
    bench.path(0, 0, entries);
    bench.tick();
    bench
}

fn place(view: &View<AXES>, axes: [usize; 2]) -> [f64; 2] {
    axes.map(|axis| pulses(view.axes[axis].pos))
}

#[test]
fn a_line_moves_both_axes_by_their_share() {
    let mut bench = ready(250, &[]);
    let view = bench.tick();
    // Its zero is at 100, -50; the axes are at 0.
    assert_eq!(view.crds[0].place[..2], [Pos::pulses(-100), Pos::pulses(50)]);
    assert_eq!((view.axes[2].mode, view.axes[5].mode, view.axes[0].mode), (Mode::Crd, Mode::Crd, Mode::Trap));
    bench.path(0, 0, &[line(200, 450)]);
    bench.start_path(&[0]);
    let begin = bench.tick();
    assert!(begin.crds[0].runs && has(&begin.axes[2], status::RUNNING) && has(&begin.axes[5], status::RUNNING));
    assert_eq!(place(&begin, [2, 5]), [0.0, 0.0]);
    // 300 and 400 pulses: 500 along, 10 ms up to 10 pulse/ms in 50 pulses, 60 ms in all.
    let (zero, t) = (begin.now.0, |ms: f64| (ms * 1e6) as u64);
    for (ms, way) in [(5.0, 12.5), (10.0, 50.0), (30.0, 250.0), (50.0, 450.0), (55.0, 487.5)] {
        let view = bench.until(zero + t(ms));
        let [x, y] = place(&view, [2, 5]);
        assert!((x - 0.6 * way).abs() < 1e-6 && (y - 0.8 * way).abs() < 1e-6, "{ms}: {x} {y}");
        let v = if ms < 10.0 {
            ms
        } else if ms > 50.0 {
            60.0 - ms
        } else {
            10.0
        };
        let a = if ms < 10.0 {
            1.0
        } else if ms >= 50.0 {
            -1.0
        } else {
            0.0
        };
        for (axis, share) in [(2, 0.6), (5, 0.8)] {
            let motion = view.motion(&view.axes[axis]);
            assert!((real(motion.velocity()) - share * v).abs() < 1e-8, "{ms} {}", real(motion.velocity()));
            if ms != 10.0 {
                assert!((real(motion.acceleration()) - share * a).abs() < 1e-8, "{ms}");
            }
        }
    }
    let end = bench.until(zero + t(60.0) + 250_000);
    assert_eq!(place(&end, [2, 5]), [300.0, 400.0]);
    assert!(!end.crds[0].runs && end.axes[2].status & status::RUNNING == 0);
    assert_eq!(
        (end.crds[0].stop, end.crds[0].rest, end.crds[0].done),
        (StopReason::Completed, Rest::Completed, [1, 0])
    );
    assert!(
        matches!(bench.event(), Some(Event::CrdStopped { crd: of, reason: StopReason::Completed, .. }) if of == crd(0))
    );
    assert!(bench.event().is_none());
}
