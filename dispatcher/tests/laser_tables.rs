//! Follow tables and distance follow in both families: refusals with their texts, tables that are
//! in use. A command that fails leaves everything as it was.
use crate::laser_channel::{prepared, units};
use crate::{bench, laser_path};
use bench::{body, entry, sleep};
use laser_path::*;
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;

#[test]
fn follow_tables_are_checked_point_by_point() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        let two = points(&[(0.0, 1.0), (10.0, 2.0)]);
        refused(b, table(0, 2, 0, 0), &two, 7, "SetLaserFollowTable: table is 0; allowed are 1 to 8");
        refused(b, table(9, 2, 0, 0), &two, 7, "SetLaserFollowTable: table is 9; allowed are 1 to 8");
        refused(b, table(1, 2, 2, 0), &two, 7, "SetLaserFollowTable: channel is 2; allowed are 0 to 1");
        refused(b, table(1, 0, 0, 0), &[], 7, "SetLaserFollowTable: count is 0; it must be from 1 to 32");
        refused(b, table(1, 33, 0, 0), &two, 7, "SetLaserFollowTable: count is 33; it must be from 1 to 32");
        refused(b, table(1, -1, 0, 0), &[], 7, "SetLaserFollowTable: count is -1; it must be from 1 to 32");
        for (given, text) in [
            ([(0.0, 1.0), (0.0, 2.0)], "vel is 0; it must be greater than 0, that of the point before (item 2)"),
            ([(10.0, 1.0), (9.5, 2.0)], "vel is 9.5; it must be greater than 10, that of the point before (item 2)"),
            ([(-1.0, 1.0), (9.5, 2.0)], "vel is -1; it must be from 0 to 4294967296 (item 1)"),
            ([(0.0, 1.0), (f64::NAN, 2.0)], "vel is not a finite number (item 2)"),
            ([(0.0, f64::NAN), (1.0, 2.0)], "power is not a finite number (item 1)"),
        ] {
            refused(b, table(1, 2, 0, 0), &points(&given), 7, &format!("SetLaserFollowTable: {text}"));
        }
        if family == GUS {
            let text = "SetLaserFollowTable: power is 101; it must be from 0 to 100 (item 2)";
            refused(b, table(1, 2, 0, 0), &points(&[(0.0, 1.0), (1.0, 101.0)]), 7, text);
        }
        // They are not stored.
        let text = "BufLaserFollowTable: follow table 1 of laser channel 0 is empty; call SetLaserFollowTable first";
        refused(b, table_follow(1, 0.0, 1.0), &[], 1, text);
        // Chunks in order; one that does not continue the one before is refused.
        let text = "SetLaserFollowTable: first is 1; it must be from 0 to 0";
        refused(b, table(1, 2, 0, 1), &two[1..], 7, text);
        b.call_items(table(1, 2, 0, 0), &two[..1]).reply::<SetLaserFollowTable>();
        b.call_items(table(1, 2, 0, 1), &two[1..]).reply::<SetLaserFollowTable>();
        b.done(table_follow(1, 0.0, 1.0));
        // Channel 1 has tables of its own.
        let text = "BufLaserFollowTable: follow table 1 of laser channel 1 is empty; call SetLaserFollowTable first";
        refused(b, BufLaserFollowTable { channel: 1.into(), ..table_follow(1, 0.0, 1.0) }, &[], 1, text);
    }
}

#[test]
fn a_follow_table_in_use_is_not_replaced() {
    let mut bench = bench(GUS);
    let b = &mut bench;
    let points = points(&[(0.0, 1.0), (10.0, 2.0)]);
    for number in [1, 2] {
        b.call_items(table(number, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
    }
    // No entry names it: it may be replaced.
    b.call_items(table(1, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
    b.done(table_follow(1, 0.0, 50.0));
    b.done(line(1000, 0, 10.0));
    let text = "SetLaserFollowTable: follow table 1 of laser channel 0 is named by an entry of a path or by the follow in force; it can be replaced when neither is there";
    refused(b, table(1, 2, 0, 0), &points, 1, text);
    b.call_items(table(2, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
    b.done(start());
    b.run_ms(20);
    refused_running(b, table(1, 2, 0, 0), &points, text);
    b.run_ms(200);
    // The path is over, its follow is not.
    refused(b, table(1, 2, 0, 0), &points, 1, text);
    b.done(Stop { core: 1.into(), mask: (1 << 10).into(), option: 0.into(), form: 1 });
    b.run_ms(1);
    b.call_items(table(1, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
    // A cleared FIFO names nothing.
    b.done(table_follow(1, 0.0, 50.0));
    refused(b, table(1, 2, 0, 0), &points, 1, text);
    b.done(CrdClear { core: 1.into(), crd: 1.into(), fifo: 0.into() });
    b.call_items(table(1, 2, 0, 0), &points).reply::<SetLaserFollowTable>();
}

#[test]
fn distance_follow_is_checked() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        let scale = [1000.0; 4];
        refused(b, distance(2, 0, scale), &[], 7, "SetLaserDisMode: mode is 2; allowed are 0 to 1");
        refused(b, distance(1, 2, scale), &[], 7, "SetLaserDisMode: source is 2; allowed are 0 to 1");
        refused(
            b,
            SetLaserDisMode { channel: 2.into(), ..distance(1, 0, scale) },
            &[],
            7,
            "SetLaserDisMode: channel is 2; allowed are 0 to 1",
        );
        let text = "SetLaserDisMode: scale[2] is not a finite number";
        refused(b, distance(1, 0, [1.0, 1.0, f64::NAN, 1.0]), &[], 7, text);
        if family == GUS {
            let text = "SetLaserDisMode: scale[1] is 0; it must be from 3.815e-6 to 4294967296";
            refused(b, distance(1, 0, [1.0, 0.0, 1.0, 1.0]), &[], 7, text);
            let text = "SetLaserDisMode: scale[3] is -5; it must be from 3.815e-6 to 4294967296";
            refused(b, distance(1, 0, [1.0, 1.0, 1.0, -5.0]), &[], 7, text);
        }
        // Ratios need a follow that is on.
        let off = "laser channel 0: distance follow is off; call SetLaserDisMode(1, ...) first";
        refused(b, ratios([0.1; 4], None), &[], 1, &format!("SetLaserDisRatio: {off}"));
        refused(b, lines(1, None, 0), &on_lines(&[(0.1, 0); 4]), 1, &format!("SetLaserDisTable1D: {off}"));
        refused(b, plane([1, 2], [1, 1], 0), &in_plane(&[0.0, 0.0, 0.1]), 1, &format!("SetLaserDisTable2D: {off}"));
        b.done(distance(1, 0, scale));
        let text = "SetLaserDisRatio: ratio[1] is not a finite number";
        refused(b, ratios([0.1, f64::NAN, 0.1, 0.1], None), &[], 7, text);
        let text = "SetLaserDisRatio: ratio[3] is 131073; it must be from -131072 to 131072";
        refused(b, ratios([0.1, 0.1, 0.1, 131_073.0], None), &[], 7, text);
        let bounds = Some((20.0, 10.0));
        if family == GUS {
            let text = "SetLaserDisRatio: max is 10; it must not be below the minimum, 20";
            refused(b, ratios([0.1; 4], bounds), &[], 7, text);
            let text = "SetLaserDisRatio: max is 101; it must be from 0 to 100";
            refused(b, ratios([0.1; 4], Some((0.0, 101.0))), &[], 7, text);
            // Equal ones are bounds too. Those that are not given stay.
            let reported = b.done(ratios([0.0, -1.0, 131_072.0, 0.1], Some((10.0, 10.0))));
            assert_eq!((reported.max.get(), reported.min.get(), reported.held), (10.0, 10.0, 0));
            let reported = b.done(ratios([0.1; 4], None));
            assert_eq!((reported.max.get(), reported.min.get()), (10.0, 10.0));
            // On again: without bounds of its own, those of the mode hold.
            b.done(distance(1, 0, scale));
            let reported = b.done(ratios([0.1; 4], None));
            assert_eq!((reported.max.get(), reported.min.get()), (100.0, 0.0));
        } else {
            // LSR ignores them.
            let reported = b.done(ratios([0.1; 4], bounds));
            assert_eq!((reported.max.get(), reported.min.get(), reported.held), (100.0, 0.0, 0));
        }
        b.done(distance(0, 0, [f64::NAN; 4]));
        refused(b, ratios([0.1; 4], None), &[], 1, &format!("SetLaserDisRatio: {off}"));
    }
}

#[test]
fn tables_of_ratios_are_checked_point_by_point() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        let b = &mut bench;
        b.done(distance(1, 0, [1000.0; 4]));
        let eight = [(0.1, 0), (0.2, 10), (0.1, 0), (0.2, 10), (0.1, 0), (0.2, 10), (0.1, 0), (0.2, 10)];
        let with = |index: usize, point: (f64, i32)| {
            let mut points = eight;
            points[index] = point;
            on_lines(&points)
        };
        let is = |text: &str| format!("SetLaserDisTable1D: {text}");
        refused(b, lines(0, None, 0), &[], 7, &is("count is 0; it must be from 1 to 32"));
        refused(b, lines(33, None, 0), &with(0, (0.1, 0)), 7, &is("count is 33; it must be from 1 to 32"));
        let text = is("pos of axis 3 is 0; it must be greater than 0, that of the point before (item 2)");
        refused(b, lines(2, None, 0), &with(5, (0.1, 0)), 7, &text);
        let text = is("ratio is not a finite number (item 1)");
        refused(b, lines(2, None, 0), &with(4, (f64::NAN, 0)), 7, &text);
        let text = is("ratio is -200000; it must be from -131072 to 131072 (item 2)");
        refused(b, lines(2, None, 0), &with(7, (-2e5, 10)), 7, &text);
        let text = is("limit[1] is not a finite number");
        refused(b, lines(2, Some([1.0, f64::NAN, 1.0, 1.0]), 0), &on_lines(&eight), 7, &text);
        let text = is("the command's length is wrong: 165 bytes came, 153 were expected");
        let nine: Vec<(f64, i32)> = eight.iter().copied().chain([(0.1, 50)]).collect();
        refused(b, lines(2, None, 0), &on_lines(&nine), 7, &text);
        if family == GUS {
            let text = is("limit[0] is 101; it must be from 0 to 100");
            refused(b, lines(2, Some([101.0, 1.0, 1.0, 1.0]), 0), &on_lines(&eight), 7, &text);
        }
        b.call_items(lines(2, None, 0), &on_lines(&eight)).reply::<SetLaserDisTable1D>();
        // A few at a time; then another order.
        b.call_items(lines(2, None, 0), &on_lines(&eight[..3])).reply::<SetLaserDisTable1D>();
        let text = is("first is 4; it must be from 0 to 3");
        refused(b, lines(2, None, 4), &on_lines(&eight[4..]), 7, &text);
        b.call_items(lines(2, None, 3), &on_lines(&eight[3..])).reply::<SetLaserDisTable1D>();

        let is = |text: &str| format!("SetLaserDisTable2D: {text}");
        let good = [0.0, 10.0, -5.0, 5.0, 0.1, 0.2, 0.3, 0.4];
        let with = |index: usize, value: f64| {
            let mut values = good;
            values[index] = value;
            in_plane(&values)
        };
        let (all, one) = (in_plane(&good), [2, 2]);
        refused(b, plane([0, 2], one, 0), &all, 7, &is("axis[0] is 0; allowed are 1 to 4"));
        refused(b, plane([1, 5], one, 0), &all, 7, &is("axis[1] is 5; allowed are 1 to 4"));
        refused(b, plane([2, 2], one, 0), &all, 7, &is("axis names axis 2 twice; a plane has two"));
        refused(b, plane([1, 2], [0, 2], 0), &all, 7, &is("count[0] is 0; it must be from 1 to 32"));
        refused(b, plane([1, 2], [2, 33], 0), &all, 7, &is("count[1] is 33; it must be from 1 to 32"));
        refused(b, plane([1, 2], [32, 9], 0), &all, 7, &is("count is 288; at most 256 fit"));
        let text = "must be a whole number of pulses, greater than";
        let x = format!("a position of X is 0; it {text} 0, that of the point before (item 2)");
        refused(b, plane([1, 2], one, 0), &with(1, 0.0), 7, &is(&x));
        let y = format!("a position of Y is -6; it {text} -5, that of the point before (item 2)");
        refused(b, plane([1, 2], one, 0), &with(3, -6.0), 7, &is(&y));
        let half = format!("a position of X is 10.5; it {text} 0, that of the point before (item 2)");
        refused(b, plane([1, 2], one, 0), &with(1, 10.5), 7, &is(&half));
        refused(b, plane([1, 2], one, 0), &with(6, f64::INFINITY), 7, &is("value is not a finite number (item 3)"));
        b.call_items(plane([1, 2], one, 0), &all).reply::<SetLaserDisTable2D>();
    }
}

#[test]
fn ratios_change_while_they_are_in_force() {
    // Two banks: the third change of one instant has to wait for the first, which acts at that
    // instant.
    let mut bench = bench(GUS);
    let b = &mut bench;
    b.done(distance(1, 0, [1000.0; 4]));
    let table = |ratio: f64| on_lines(&[(ratio, 0); 4]);
    for ratio in [1.0, 2.0, 3.0, 4.0, 5.0] {
        b.call_items(lines(1, None, 0), &table(ratio)).reply::<SetLaserDisTable1D>();
    }
    let mut entries: Vec<_> = [1.0, 2.0, 3.0, 4.0]
        .map(|ratio| {
            (SetLaserDisTable1D::OPCODE, Lane::Program, body::<SetLaserDisTable1D>(lines(1, None, 0), &table(ratio)))
        })
        .to_vec();
    entries.push(bench::entry(ProgramEnd {}));
    let tags = b.post_all(&entries);
    b.done(ProgramStart { strict: 0 });
    for tag in tags {
        assert_eq!(b.wait(tag).code, 0);
    }
    b.run_ms(1);
    assert!(b.server.view().lasers[0].bank.is_some());
}

/// A program is admitted ahead of its ticks: its FIFO holds new data before the tick has cleared
/// it.
#[test]
fn a_program_replaces_the_follow_table_of_entries_that_it_cleared() {
    let mut bench = bench(GUS);
    let points = points(&[(0.0, 1.0), (10.0, 2.0)]);
    let set = || (SetLaserFollowTable::OPCODE, Lane::Program, body(table(1, 2, 0, 0), &points));
    let clear = CrdClear { core: 1.into(), crd: 1.into(), fifo: 0.into() };
    let named = entry(table_follow(1, 0.0, 50.0));
    let cleared = [set(), named.clone(), entry(clear), entry(line(1000, 0, 10.0)), set(), entry(ProgramEnd {})];
    let tags = bench.post_all(&cleared);
    bench.done(ProgramStart { strict: 1 });
    for (index, tag) in tags.into_iter().enumerate() {
        assert_eq!(bench.wait(tag).code, 0, "entry {index}");
    }
    assert_eq!(bench.done(ProgramStatus {}).late.get(), 0);
    // Named again.
    let tags = bench.post_all(&[named, set(), entry(ProgramEnd {})]);
    bench.done(ProgramStart { strict: 0 });
    assert_eq!(bench.wait(tags[1]).reason(), Reason::FollowTableInUse);
}

/// All of it is admitted ahead: while the path that names the table has not even begun, what takes
/// it away is in flight. It goes on with the table that it named; it had the later one.
#[test]
fn a_table_set_after_a_reset_is_not_that_of_the_path_before() {
    let core = 1.into();
    let crd = 1.into();
    let clear =
        [entry(CrdStop { core, mask: 1.into(), option: 1.into() }), entry(CrdClear { core, crd, fifo: 0.into() })];
    // After a Reset nothing follows; after a clear the follow is still in force.
    for (away, taken) in [(vec![entry(Reset { core })], true), (clear.to_vec(), false)] {
        let mut bench = bench(GUS);
        prepared(&mut bench, GUS, 0);
        let set = |power: f64| {
            let points = points(&[(0.0, power), (1000.0, power)]);
            (SetLaserFollowTable::OPCODE, Lane::Program, body(table(1, 2, 0, 0), &points))
        };
        let path = [
            entry(table_follow(1, 0.0, 100.0)),
            entry(buf_on(1, 0, 0)),
            entry(line(10_000, 0, 10.0)),
            entry(start()),
            entry(sleep(20)),
        ];
        let calls = [vec![set(30.0)], path.to_vec(), away, vec![set(70.0), entry(ProgramEnd {})]].concat();
        let tags = bench.post_all(&calls);
        bench.done(ProgramStart { strict: 0 });
        bench.run_ms(15);
        let view = bench.server.view().lasers[0];
        assert_eq!((units(view.power), view.light), (30.0, true));
        let last = bench.wait(tags[tags.len() - 2]);
        assert_eq!(last.code, i16::from(!taken));
        assert!(taken || last.reason() == Reason::FollowTableInUse);
    }
}
