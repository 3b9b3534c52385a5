//! PVT through the client and the virtual controller: knots exact, loops accumulate, the switch at
//! the end of a pass, the start delay, stop and restart. Expected values are the points as given,
//! or follow from them by hand; a motion that begins at 0 has its time 0 at row 1 of the trace.
mod motion;
use client::{Answer, Call};
use motion::{sleep, stop, wait};
use protocol::command::*;
use trace::Row;
use trace::decimal::position;

fn mode(axis: i16) -> Call {
    Call::of(PrfPvt { core: 1.into(), profile: axis.into() })
}

fn table(number: i16, points: &[(f64, f64, f64)]) -> Call {
    let head = PvtTable { core: 1.into(), table: number.into(), count: (points.len() as i32).into(), first: 0.into() };
    let items: Vec<PvtPoint> = points
        .iter()
        .map(|&(time, pos, vel)| PvtPoint { time: time.into(), pos: pos.into(), vel: vel.into() })
        .collect();
    Call::with_items(head, &items)
}

fn select(axis: i16, number: i16) -> Call {
    Call::of(PvtTableSelect { core: 1.into(), profile: axis.into(), table: number.into() })
}

fn loops(axis: i16, count: i32) -> Call {
    Call::of(SetPvtLoop { core: 1.into(), profile: axis.into(), loop_count: count.into() })
}

fn start(mask: i32) -> Call {
    Call::of(PvtStart { core: 1.into(), mask: mask.into() })
}

fn status(axis: i16) -> Call {
    Call::of(PvtStatus { core: 1.into(), profile: axis.into(), count: 1.into() })
}

/// Runs a program of axes 1 and 2 in PVT mode at this tick under a trace of both. Nothing may be
/// late.
fn run(tick_us: u32, calls: Vec<Call>) -> (Vec<Row>, Vec<Answer>) {
    let ran = motion::run(tick_us, 2, [vec![mode(1), mode(2)], calls].concat());
    (ran.rows, ran.answers)
}

/// The place of the row at `ms` after the start of a motion that began at `from` ms.
fn row(rows: &[Row], tick_us: u32, ms: f64) -> &Row {
    &rows[(ms * 1000.0 / f64::from(tick_us)).round() as usize + 1]
}

fn published(pos: f64) -> String {
    format!("{pos:.6}")
}

/// Table 4-2.
const DELAYED: [(f64, f64, f64); 4] =
    [(1000.0, 0.0, 0.0), (2000.0, 5000.0, 10.0), (3000.0, 15000.0, 10.0), (4000.0, 20000.0, 0.0)];

#[test]
fn table_4_2_starts_late_and_loops_without_its_delay() {
    for tick_us in [250, 1000] {
        let program = vec![table(1, &DELAYED), loops(1, 3), start(1), wait(1)];
        let (rows, _) = run(tick_us, program);
        for ms in [0.0, 500.0, 999.0, 1000.0] {
            assert_eq!(position(row(&rows, tick_us, ms).axes[0].pos), published(0.0), "rests until its first point");
        }
        for pass in 0..3 {
            for (time, pos, _) in &DELAYED[1..] {
                let at = row(&rows, tick_us, time + 3000.0 * f64::from(pass));
                assert_eq!(
                    position(at.axes[0].pos),
                    published(pos + 20000.0 * f64::from(pass)),
                    "{time} in pass {pass}"
                );
            }
            // The middle of the constant acceleration of the first segment: ½·0.01·500².
            let at = row(&rows, tick_us, 1500.0 + 3000.0 * f64::from(pass));
            assert_eq!(position(at.axes[0].pos), published(1250.0 + 20000.0 * f64::from(pass)));
        }
        assert_eq!(position(rows.last().unwrap().axes[0].pos), published(60000.0));
    }
}

#[test]
fn a_switch_waits_for_the_end_of_the_pass_and_begins_without_a_delay() {
    let ten = [(0.0, 0.0, 1.0), (10.0, 10.0, 1.0)];
    // Begins anywhere, with a time of its own: neither counts when it is switched to.
    let five = [(7.0, 1234.5, -0.5), (17.0, 1229.5, -0.5)];
    let program = vec![
        table(1, &ten),
        table(2, &five),
        loops(1, 0),
        start(1),
        sleep(34.0),
        select(1, 2),
        status(1),
        sleep(16.0),
        status(1),
        loops(1, 3),
        wait(1),
    ];
    let (rows, answers) = run(250, program);
    let at = |ms: f64| position(row(&rows, 250, ms).axes[0].pos);
    assert_eq!([at(34.0), at(39.0), at(40.0)], [published(34.0), published(39.0), published(40.0)]);
    assert_eq!([at(42.0), at(50.0), at(60.0)], [published(39.0), published(35.0), published(30.0)]);
    // Three passes of the new table, counted from its beginning.
    assert_eq!([at(69.0), at(70.0)], [published(25.5), published(25.0)]);
    assert_eq!(position(rows.last().unwrap().axes[0].pos), published(25.0));
    let found: Vec<(i16, f64)> = answers
        .iter()
        .filter_map(|answer| answer.reply::<PvtStatus>())
        .map(|(_, items)| (items[0].table.get(), items[0].time.get()))
        .collect();
    // At 50 ms the first pass of the new table is over: the time is again that of its first point.
    assert_eq!(found, [(1, 4.0), (2, 7.0)]);
}

#[test]
fn stop_brakes_and_the_next_start_begins_the_table_anew() {
    let ten = [(0.0, 5.0, 1.0), (10.0, 15.0, 1.0)];
    let program = vec![
        table(3, &ten),
        select(1, 3),
        select(2, 3),
        loops(1, 0),
        start(3),
        sleep(4.0),
        // Smooth, 1 pulse/ms²: half a pulse further.
        stop(1, 0),
        sleep(20.0),
        loops(1, 1),
        start(1),
        wait(3),
    ];
    let (rows, _) = run(250, program);
    let last = rows.last().unwrap();
    let rest = row(&rows, 250, 10.0).axes[0].pos;
    assert_eq!(position(last.axes[1].pos), published(10.0), "one table, two axes");
    let stopped: f64 = position(rest).parse().unwrap();
    assert!((stopped - 4.5).abs() < 0.3, "{stopped}");
    assert_eq!(position(last.axes[0].pos), published(stopped + 10.0), "its displacement from where it stood");
}
