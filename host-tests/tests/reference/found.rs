//! Programs that differed once, as short as they could be made: what was wrong is said at each.
use super::judge::{Tally, finding};
use host_tests::reference::{Call, Datum, Item, Kind, Path, PathCall, Site};

const MS: i64 = 1_000_000;

fn gus() -> Site {
    Site { profile: "gus", axes: vec![(1, 1), (1, 2), (1, 3), (1, 6)] }
}

fn plain(kind: Kind, axis: usize) -> Call {
    Call::Axis { kind, axis }
}

fn ex(of: Call) -> Call {
    Call::Ex(Box::new(of))
}

fn segment(axis: usize, master: f64, slave: f64, kind: i16, percent: i16) -> Call {
    let datum = Datum { master, slave, kind, percent };
    Call::FollowEntry { axis, item: Item::Segment(datum), fifo: 0 }
}

fn agrees(tick_us: u32, calls: &[Call]) {
    let mut tally = Tally::new();
    if let Some(report) = finding(&mut None, &gus(), tick_us, calls, &mut tally) {
        panic!("{report}");
    }
    let open: Vec<&String> = tally.keys().filter(|what| what.starts_with("cut short")).collect();
    assert!(open.is_empty(), "{open:?}");
}

/// A slave of a slave jumped to a turning point far ahead where a delay of the one in the middle ended: the way inside the
/// tick was taken from a progress of before the wait.
#[test]
fn a_slave_of_a_slave_that_a_delay_held() {
    agrees(
        1000,
        &[
            plain(Kind::AxisOn, 0),
            plain(Kind::AxisOn, 1),
            plain(Kind::AxisOn, 3),
            ex(Call::PrfFollow { axis: 3, dir: 1 }),
            ex(Call::SetFollowMaster { axis: 3, master: 0, kind: 2 }),
            segment(3, 456.0, 456.0, 0, 100),
            ex(Call::FollowStart { mask: 8, option: 0 }),
            ex(Call::PrfFollow { axis: 0, dir: 1 }),
            ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2 }),
            segment(0, 28.25, 42.375, 1, 20),
            Call::FollowEntry { axis: 0, item: Item::Delay { cycles: 4 }, fifo: 0 },
            segment(0, 393.5, 149.0, 0, 0),
            ex(Call::FollowStart { mask: 1, option: 0 }),
            plain(Kind::PrfJog, 1),
            Call::SetJogPrm { axis: 1, acc: 5.4, dec: 0.9 },
            Call::SetVel { axis: 1, vel: -12.625 },
            Call::Update { mask: 2 },
            Call::Sleep { ns: 21 * MS - 85_870 },
            Call::FollowSwitchNow { axis: 0, table: false },
            Call::Sleep { ns: 10 * MS },
        ],
    );
}

/// A WaitStop of one axis of a coordinate system made another one, which had left it and ran, count as waited for: its mode
/// could be set while it ran.
#[test]
fn a_wait_for_an_axis_says_nothing_of_one_that_left_its_coordinate_system() {
    let set = Path::Set { crd: 1, axes: vec![2, 1, 0], vel: 15.0, acc: 2.0, even_ms: 0, origin: None };
    let datum = Datum { master: 478.0, slave: 324.0, kind: 3, percent: 0 };
    agrees(
        250,
        &[
            plain(Kind::AxisOn, 2),
            Call::Path(PathCall { core: 1, what: set }),
            Call::PrfFollow { axis: 2, dir: 0 },
            Call::SetFollowMaster { axis: 2, master: 3, kind: 1 },
            Call::FollowData { axis: 2, datum, fifo: 0 },
            Call::FollowStart { mask: 4, option: 0 },
            Call::WaitStop { mask: 1 },
            plain(Kind::PrfTrap, 2),
            plain(Kind::GetPrfMode, 2),
            plain(Kind::GetSts, 2),
        ],
    );
}
