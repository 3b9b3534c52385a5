//! Follows and tables against exact rationals, the law against cases worked out by hand.
extern crate std;
#[path = "../../tests/chance/mod.rs"]
mod chance;
use super::buffered::{ChannelEvent, EventQueue};
use super::distance_follow::Displacements;
use super::light_owner::StandstillCause;
use super::power_law::PowerLaw;
use super::power_tables::{DISTANCES, Interval};
use super::*;
use crate::axis::AxisState;
use chance::Chance;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};
use std::{vec, vec::Vec};

fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).unwrap()
}
fn fixed(x: i128, bits: u32) -> BigRational {
    BigRational::new(x.into(), BigInt::from(1) << bits)
}
/// In units of 2^-44.
fn units(x: BigRational) -> f64 {
    (x * BigRational::from_integer(BigInt::from(1u64 << 44))).to_f64().unwrap()
}
fn power(x: f64) -> Power {
    Power::admit(x.to_bits()).unwrap()
}
fn speed(x: f64) -> PathSpeed {
    PathSpeed((x * (1u64 << 30) as f64) as u64)
}
fn ratio(x: f64) -> Ratio {
    Ratio::admit(x.to_bits()).unwrap()
}
fn follow(max: f64, min: f64) -> PowerBounds {
    PowerBounds::admit_follow(PowerMode::Frequency, power(max), power(min)).unwrap()
}

#[test]
fn the_power_of_a_speed_is_the_nearest_that_there_is() {
    let mut chance = Chance::new(1);
    for _ in 0..20_000 {
        let (r, v) = (chance.log(1e-9, 4e9), chance.next() >> (chance.next() % 64));
        let got = ratio(r).gain().power(PathSpeed(v));
        let want = units(exact(r) * fixed(v as i128, 30));
        if want > 2f64.powi(60) {
            assert!(got >= 1 << 60, "{r} · {v}: {got}");
            continue;
        }
        let off = units(exact(r) * fixed(v as i128, 30) - fixed(got as i128, 44)).abs();
        assert!(off <= 0.5 + want * 2f64.powi(-62), "{r} · {v}: {off}");
    }
    assert_eq!(ratio(f64::MIN_POSITIVE).gain().power(PathSpeed(u64::MAX)), 0);
    assert_eq!(ratio(0.1).gain().power(PathSpeed::STANDSTILL), 0);
}

#[test]
fn a_ratio_is_above_0_and_a_number() {
    let admit = |x: f64| Ratio::admit(x.to_bits());
    assert_eq!(admit(0.0), Err(Refused::Zero));
    assert_eq!(admit(-0.0), Err(Refused::Negative));
    assert_eq!(admit(-0.1), Err(Refused::Negative));
    assert_eq!(admit(f64::NAN), Err(Refused::NotFinite));
    assert_eq!(admit(f64::NEG_INFINITY), Err(Refused::NotFinite));
    assert_eq!(admit(4_294_967_297.0), Err(Refused::BeyondRange));
    assert!(admit(4_294_967_296.0).is_ok() && admit(5e-324).is_ok());
    let bounds = |max, min| PowerBounds::admit_follow(PowerMode::Duty, power(max), power(min));
    assert_eq!(bounds(10.0, 10.0), Err(Refused::MaxNotAboveMin));
    assert_eq!(bounds(9.0, 10.0), Err(Refused::MaxBelowMin));
    assert_eq!(bounds(101.0, 10.0), Err(Refused::BeyondRange));
}

#[test]
fn buffered_changes_are_what_was_packed() {
    let bounds = follow(1999.5, 0.25);
    let table = Curve::power(1, 7).unwrap();
    let source = SpeedSource::Encoder;
    for change in [
        Buffered::Gate { on: true },
        Buffered::Gate { on: false },
        Buffered::Direct { power: power(30.1) },
        Buffered::FollowMode { source, start: None },
        Buffered::FollowMode { source: SpeedSource::Planned, start: Some(power(2000.0)) },
        Buffered::FollowMode { source, start: Some(Power::ZERO) },
        Buffered::FollowRatio { ratio: ratio(0.1), bounds },
        Buffered::PrfFollow { ratio: ratio(4e9), bounds },
        Buffered::FollowTable { table, bounds },
        Buffered::FollowOff,
    ] {
        let (code, words) = change.pack();
        assert_eq!(Buffered::unpack(code, &words), Some(change));
    }
    // Words that were never packed: nothing, or something that is admitted.
    assert_eq!(Buffered::unpack(0, &[u32::MAX; 6]), None);
    assert_eq!(Buffered::unpack(5, &[u32::MAX; 6]), None);
    assert_eq!(Buffered::unpack(7, &[255; 6]), None);
    let wild = Buffered::unpack(3, &[u32::MAX, i32::MAX as u32, 0, 0, 0, 0]);
    assert_eq!(wild, Some(Buffered::Direct { power: Power::MAX }));
}

#[test]
fn events_are_in_the_order_of_time_and_of_their_coming() {
    let mut event_queue = EventQueue::EMPTY;
    let run = |index| PathRun { crd: Crd::new(index).unwrap(), fifo: 0 };
    let order = [(50, 0), (20, 1), (50, 2), (10, 3), (20, 0)];
    for (at, index) in order {
        event_queue.put(Ns(at), ChannelEvent::Standstill(run(index), StandstillCause::RanOut, Cause::None)).unwrap();
    }
    assert_eq!(event_queue.next, Ns(10));
    assert!(event_queue.take(Ns(9)).is_none());
    let mut seen = vec![];
    while let Some(ChannelEvent::Standstill(run, ..)) = event_queue.take(Ns(60)) {
        seen.push(run.crd.index());
    }
    assert_eq!(seen, [3, 1, 0, 0, 2]);
    assert_eq!(event_queue.next, NEVER);
    for at in 0..48 {
        event_queue.put(Ns(at), ChannelEvent::Standstill(run(0), StandstillCause::RanOut, Cause::None)).unwrap();
    }
    assert!(event_queue.put(Ns(1), ChannelEvent::Standstill(run(0), StandstillCause::RanOut, Cause::None)).is_err());
}

fn none() -> Interval {
    Interval::NONE
}

/// A table of powers with these points.
fn power_table(tables: &PowerTables, points: &[(f64, f64)]) -> Curve {
    let curve = Curve::power(1, 3).unwrap();
    for (index, (v, p)) in points.iter().enumerate() {
        tables.power_point(curve, index, v.to_bits(), power(*p)).unwrap();
    }
    tables.finish(curve, points.len());
    curve
}

#[test]
fn a_table_is_linear_between_its_points_and_its_border_outside() {
    let mut chance = Chance::new(2);
    let tables = PowerTables::new();
    for count in 1..=POINTS {
        let mut v = chance.log(1e-6, 1.0);
        let points: Vec<(f64, f64)> = (0..count)
            .map(|_| {
                v = (v + chance.log(1e-6, 300.0)) * 2f64.powi(30);
                v = v.round() / 2f64.powi(30);
                (v, chance.within(0.0, 2000.0))
            })
            .collect();
        let curve = power_table(&tables, &points);
        let mut interval = Interval::NONE;
        for _ in 0..300 {
            let x = (chance.within(0.0, v * 1.2) * 2f64.powi(30)) as i64;
            let got = fixed(tables.at(curve, x, &mut interval) as i128, 44);
            let x = fixed(x as i128, 30);
            let at = points.iter().filter(|point| exact(point.0) <= x).count();
            let y = |index: usize| fixed(power(points[index].1).raw() as i128, 44);
            let (want, step) = match at {
                0 => (y(0), exact(0.0)),
                at if at == count => (y(count - 1), exact(0.0)),
                at => {
                    let (from, to) = (exact(points[at - 1].0), exact(points[at].0));
                    let step = y(at) - y(at - 1);
                    (y(at - 1) + step.clone() * (x - from.clone()) / (to - from), step)
                }
            };
            let off = units((got - want).abs());
            assert!(off <= 0.5 + units(step.abs()) * 2f64.powi(-53), "{count} points: off by {off}");
        }
        // Every point itself.
        for (x, y) in &points {
            let got = tables.at(curve, (x * 2f64.powi(30)) as i64, &mut interval);
            assert_eq!(got, power(*y).raw());
        }
    }
    tables.finish(Curve::power(0, 0).unwrap(), 0);
    assert_eq!(tables.at(Curve::power(0, 0).unwrap(), 77, &mut none()), 0);
}

#[test]
fn a_table_refuses_what_breaks_its_rules() {
    let tables = PowerTables::new();
    let curve = Curve::power(0, 0).unwrap();
    let put = |index, v: f64| tables.power_point(curve, index, v.to_bits(), power(1.0));
    assert_eq!(put(0, -1.0), Err(Refused::Negative));
    assert_eq!(put(0, f64::NAN), Err(Refused::NotFinite));
    assert_eq!(put(0, 5e9), Err(Refused::BeyondRange));
    assert_eq!((put(0, 0.0), put(1, 4e9)), (Ok(()), Ok(())));
    assert_eq!(put(1, 0.0), Err(Refused::NotIncreasing));
    assert_eq!(put(1, 2f64.powi(-29)), Err(Refused::NotIncreasing));
    assert_eq!(put(1, 2f64.powi(-28)), Ok(()));
    assert_eq!(put(POINTS, 1e9), Err(Refused::Count));
    let line = Curve::ratio(1, 1, 3).unwrap();
    assert_eq!(tables.ratio_point(line, 0, 5, (-131_072.0f64).to_bits()), Ok(()));
    assert_eq!(tables.ratio_point(line, 0, 5, 131_072.5f64.to_bits()), Err(Refused::BeyondRange));
    assert_eq!(tables.ratio_point(line, 1, 5, 1.0f64.to_bits()), Err(Refused::NotIncreasing));
    assert_eq!(tables.ratio_point(line, 1, i32::MIN, 1.0f64.to_bits()), Err(Refused::NotIncreasing));
    assert_eq!(tables.plane_node(0, 0, NODES, 0), Err(Refused::Count));
    assert_eq!((Curve::power(0, 8), Curve::power(2, 0), Curve::ratio(0, 2, 0)), (None, None, None));
    assert_eq!(Curve::ratio(0, 0, 4), None);
}

/// No two tables share their memory.
#[test]
fn tables_lie_apart() {
    let tables = PowerTables::new();
    let mut all = vec![];
    for channel in 0..CHANNELS as u8 {
        all.extend((0..POWER_TABLES as u8).map(|table| Curve::power(channel, table).unwrap()));
        for bank in 0..BANKS as u8 {
            all.extend((0..DISTANCES as u8).map(|axis| Curve::ratio(channel, bank, axis).unwrap()));
            for node in 0..NODES {
                let mark = (channel * 2 + bank) as f64 * 1000.0 + node as f64;
                tables.plane_node(channel, bank, node, mark.to_bits()).unwrap();
            }
        }
    }
    for (mark, curve) in all.iter().enumerate() {
        for point in 0..POINTS {
            tables.plane_line(*curve, point, (mark * POINTS + point) as i32).unwrap();
        }
        tables.finish(*curve, mark % POINTS + 1);
    }
    for (mark, curve) in all.iter().enumerate() {
        assert_eq!(tables.count(*curve), mark % POINTS + 1);
        for point in 0..=mark % POINTS {
            let x = Pos::pulses((mark * POINTS + point) as i32).0;
            assert_eq!(tables.at(*curve, x, &mut none()), (point as i64) << 44);
        }
    }
    for (channel, bank) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mark = (channel * 2 + bank) as i64 * 1000;
        assert_eq!(tables.plane(channel, bank, 16, 3 << 44, 5 << 44), (mark + 3 + 5 * 16) << 44);
    }
}

/// Axes at these positions, encoders at other ones.
fn axes(positions: [f64; 4]) -> [AxisState; 4] {
    let mut axes = [AxisState::POWER_ON; 4];
    for (axis, position) in axes.iter_mut().zip(positions) {
        axis.published.pos = Pos((position * (1 << 22) as f64) as i64);
        axis.published.encoder = position as i64 + 1000;
    }
    axes
}

fn mapped() -> [Axis; 4] {
    [0, 1, 2, 3].map(|index| Axis::new(index).unwrap())
}

fn bits(x: [f64; 4]) -> [u64; 4] {
    x.map(f64::to_bits)
}

/// What an admitted distance follow adds, in 2^-44.
fn added(distance: &Distance, tables: &PowerTables, axes: &[AxisState]) -> i64 {
    let speeds = PathSpeeds::STANDSTILL;
    let around =
        FollowInputs { clock: Clock::GHZ, speeds: &speeds, tables, axes, displacements: &Displacements::OF_NOBODY };
    if distance.ratios.bank().is_none() {
        // The same wherever it was before: further away than one displacement holds, and within
        // one.
        let (mut terms, mut displacements) = (distance.terms(), Displacements::begin(0));
        for off in [i64::MAX >> 2, 1 << 40, (1 << 31) + 5, -(1 << 31), 5 - (1 << 31), 12_345_678, -1, 0] {
            let mut before = [AxisState::POWER_ON; 4];
            for (to, axis) in before.iter_mut().zip(axes) {
                to.published.pos = Pos(axis.published.pos.0.wrapping_add(off));
                to.published.encoder = axis.published.encoder.wrapping_add(off >> 20);
            }
            displacements.look(terms.key, &before);
            terms.advance(&displacements, &Some(*distance));
        }
        displacements.look(terms.key, axes);
        terms.advance(&displacements, &Some(*distance));
        let mut afresh = distance.terms();
        afresh.advance(&displacements, &Some(*distance));
        assert_eq!(terms.power, afresh.power);
        return terms.power;
    }
    distance.tabled(0, |axis, source| around.position(axis, source), tables, &mut [Interval::NONE; DISTANCES])
}

#[test]
fn four_displacements_of_one_length_add_up_with_the_largest_lower_halves_of_factors() {
    // 60 bits of a factor, of which the lower half is as far from 0 as it can be.
    let ratio = 0x1f_ffff_feff_ffff_i64 as f64 / 2f64.powi(52);
    let (scales, ratios) = (bits([1.0; 4]), bits([ratio; 4]));
    let distance =
        Distance::admit(SpeedSource::Planned, mapped(), [0; 4], scales, ratios, Ratios::Fixed, None).unwrap();
    let (mut terms, mut displacements) = (distance.terms(), Displacements::begin(0));
    let within = [0.0, 255.0, -0.5, 511.0, 0.0, -255.0, 0.0, -511.0, 0.0];
    // Displacements of which the bits above the lowest 31 are all alike, but not the sign.
    let across = [1280.0, 0.0, -1280.5, 0.0, 1535.5, 0.0, -1535.0, 4.0, 1400.25];
    for pulses in within.into_iter().chain(across) {
        displacements.look(terms.key, &axes([pulses; 4]));
        terms.advance(&displacements, &Some(distance));
        let mut afresh = distance.terms();
        afresh.advance(&displacements, &Some(distance));
        assert_eq!(terms.power, afresh.power, "{pulses}");
    }
}

#[test]
fn a_distance_adds_what_it_should() {
    let (mut chance, tables) = (Chance::new(3), PowerTables::new());
    for _ in 0..3000 {
        let positions = [(); 4].map(|()| {
            let far = chance.log(1.0, 1e9);
            chance.within(-far, far)
        });
        let scales = [(); 4].map(|()| chance.log(1.0, 65536.0));
        let ratios = [(); 4].map(|()| chance.within(-1.0, 1.0) * chance.log(1e-6, 1e3));
        let reference = [(); 4].map(|()| chance.within(-1e6, 1e6) as i32);
        let axes = axes(positions);
        for source in [SpeedSource::Planned, SpeedSource::Encoder] {
            let distance =
                Distance::admit(source, mapped(), reference, bits(scales), bits(ratios), Ratios::Fixed, None).unwrap();
            let (mut want, mut most) = (exact(0.0), [0f64; 2]);
            for index in 0..4 {
                let position = match source {
                    SpeedSource::Planned => fixed(axes[index].published.pos.0 as i128, 22),
                    SpeedSource::Encoder => BigRational::from_integer(axes[index].published.encoder.into()),
                };
                let by = position - BigRational::from_integer(reference[index].into());
                most[0] = most[0].max(by.abs().to_f64().unwrap());
                most[1] = most[1].max((ratios[index] / scales[index]).abs());
                want += by / exact(scales[index]) * exact(ratios[index]);
            }
            let end = fixed(1 << 61, 44);
            let want = if want.abs() > end { end * want.signum() } else { want };
            let off = units(want - fixed(added(&distance, &tables, &axes) as i128, 44)).abs();
            let bound = 0.5 + most[0] * most[1] * 2f64.powi(44 - 58);
            assert!(off <= bound, "off by {off}, bound {bound}");
        }
    }
}

#[test]
fn a_distance_refuses_what_is_out_of_range() {
    let admit = |scale: f64, ratio: f64| {
        let (scales, ratios) = (bits([scale, 1.0, 1.0, 1.0]), bits([0.0, 0.0, ratio, 0.0]));
        Distance::admit(SpeedSource::Planned, mapped(), [0; 4], scales, ratios, Ratios::Fixed, None).err()
    };
    assert_eq!(admit(0.0, 1.0), Some(Refused::Zero));
    assert_eq!(admit(-1.0, 1.0), Some(Refused::Negative));
    assert_eq!(admit(f64::NAN, 1.0), Some(Refused::NotFinite));
    assert_eq!(admit(1.0, f64::INFINITY), Some(Refused::NotFinite));
    assert_eq!(admit(1.0, 262_144.0), Some(Refused::BeyondRange));
    assert_eq!(admit(1e10, 1.0), Some(Refused::BeyondRange));
    assert_eq!((admit(1.0, -131_072.0), admit(2f64.powi(-18), 0.0)), (None, None));
}

/// 1-D: each axis has its own table; 2-D: two axes share the ratio of their position.
#[test]
fn ratios_of_tables_are_those_of_the_position() {
    let tables = PowerTables::new();
    let put = |axis, points: &[(i32, f64)]| {
        let curve = Curve::ratio(0, 1, axis).unwrap();
        for (index, (x, r)) in points.iter().enumerate() {
            tables.ratio_point(curve, index, *x, r.to_bits()).unwrap();
        }
        tables.finish(curve, points.len());
    };
    put(0, &[(0, 0.0), (1000, 0.5), (3000, 0.25)]);
    put(1, &[(-500, -0.125)]);
    put(2, &[]);
    put(3, &[(0, 1.0), (10, 2.0)]);
    let scales = bits([1000.0, 500.0, 1.0, 1.0]);
    let lines = Ratios::Lines { bank: 1 };
    let distance =
        Distance::admit(SpeedSource::Planned, mapped(), [0, 100, 0, 5], scales, [0; 4], lines, None).unwrap();
    // Axis 0 half way from 0.5 to 0.25 at 2000: 2 · 0.375; axis 1 anywhere −0.125: (600 − 100)/500
    // · −0.125; axis 2 has no points; axis 3 beyond its last: (25 − 5) · 2.
    let got = added(&distance, &tables, &axes([2000.0, 600.0, 9e6, 25.0]));
    assert_eq!(got, ((0.75 - 0.125 + 40.0) * 2f64.powi(44)) as i64);
    // Before the first point of axis 0 its ratio is 0; axis 3 between its points: (7.5 − 5) · 1.75.
    let got = added(&distance, &tables, &axes([-7000.0, 100.0, 0.0, 7.5]));
    assert_eq!(got, (4.375 * 2f64.powi(44)) as i64);

    // A plane of 3 lines along axis 2 and 2 along axis 0.
    for (index, x) in [-100, 0, 300].iter().enumerate() {
        tables.plane_line(Curve::ratio(0, 0, 0).unwrap(), index, *x).unwrap();
    }
    for (index, y) in [0, 1000].iter().enumerate() {
        tables.plane_line(Curve::ratio(0, 0, 1).unwrap(), index, *y).unwrap();
    }
    tables.finish(Curve::ratio(0, 0, 0).unwrap(), 3);
    tables.finish(Curve::ratio(0, 0, 1).unwrap(), 2);
    for (index, r) in [1.0, 2.0, 4.0, 3.0, -1.0, 0.0f64].iter().enumerate() {
        tables.plane_node(0, 0, index, r.to_bits()).unwrap();
    }
    let plane = Ratios::Plane { bank: 0, axes: [2, 0] };
    let distance =
        Distance::admit(SpeedSource::Planned, mapped(), [0; 4], bits([1.0; 4]), [0; 4], plane, None).unwrap();
    let at = |x: f64, y: f64| added(&distance, &tables, &axes([y, 7e7, x, 3e8])) as f64 / 2f64.powi(44);
    // On a node, between two, in the middle of four, and outside.
    assert_eq!(at(300.0, 1000.0), 0.0);
    assert_eq!(at(0.0, 1000.0), -1000.0);
    assert_eq!(at(150.0, 0.0), 450.0);
    assert_eq!(at(-50.0, 500.0), 450.0 * 1.25);
    assert_eq!(at(150.0, 250.0), 400.0 * (3.0 * 0.75 - 0.5 * 0.25));
    assert_eq!(at(-5000.0, 0.0), -5000.0);
    assert_eq!(at(1000.0, -1000.0), 0.0);
    assert_eq!(at(1000.0, -500.0), 500.0 * 4.0);
    // Random positions within: bilinear to 2^-40 of the corners.
    let mut chance = Chance::new(9);
    for _ in 0..500 {
        let (x, y) = (chance.within(0.0, 300.0), chance.within(0.0, 1000.0));
        let fixed = |x: f64| (x * (1 << 22) as f64).floor() / (1 << 22) as f64;
        let (u, v) = (fixed(x) / 300.0, fixed(y) / 1000.0);
        let ratio = (2.0 * (1.0 - u) + 4.0 * u) * (1.0 - v) + -(1.0 - u) * v;
        let want = (fixed(x) + fixed(y)) * ratio;
        assert!((at(x, y) - want).abs() <= 1300.0 * 2f64.powi(-31), "{x} {y}: {} {want}", at(x, y));
    }
}

/// The power of a law at a speed, of crd 1, and a distance of axis 0.
fn power_of(law: &mut PowerLaw, v: f64, x: f64) -> f64 {
    let mut speeds = PathSpeeds::STANDSTILL;
    let [first, second] = [0, 1].map(|index| Crd::new(index).unwrap());
    speeds.put(PathSpeeds::index(first, false), speed(v));
    speeds.put(PathSpeeds::index(first, true), speed(2.0 * v));
    speeds.put(PathSpeeds::index(second, false), speed(1e6));
    let (tables, axes) = (PowerTables::new(), axes([x, 0.0, 0.0, 0.0]));
    power_table(&tables, &[(10.0, 20.0), (50.0, 60.0)]);
    let mut displacements = Displacements::begin(0);
    law.skip();
    if let Some(key) = law.followed_axes() {
        displacements.look(key, &axes);
    }
    let around = FollowInputs {
        clock: Clock::GHZ,
        speeds: &speeds,
        tables: &tables,
        axes: &axes,
        displacements: &displacements,
    };
    let raw = law.power(&around).raw();
    (raw as f64 / 2f64.powi(44) * 1e9).round() / 1e9
}

fn law(family: Family, max: f64, min: f64) -> PowerLaw {
    let mut law = PowerLaw::power_on(0, family);
    law.set_bounds(PowerBounds::admit(PowerMode::Duty, power(max), power(min)).unwrap());
    law
}

fn begin(law: &mut PowerLaw, r: f64, min: f64, max: f64) {
    let bounds = PowerBounds::admit_follow(PowerMode::Duty, power(max), power(min)).unwrap();
    law.change(Crd::new(0).unwrap(), &Buffered::FollowRatio { ratio: ratio(r), bounds });
}

/// 0.01 of the unit a pulse of axis 0.
fn distance(law: &mut PowerLaw, bounds: Option<(f64, f64)>) {
    let bounds = bounds.map(|(max, min)| PowerBounds::admit(PowerMode::Duty, power(max), power(min)).unwrap());
    let (scales, ratios) = (bits([1000.0; 4]), bits([10.0, 0.0, 0.0, 0.0]));
    let source = SpeedSource::Planned;
    law.set_distance(Some(Distance::admit(source, mapped(), [0; 4], scales, ratios, Ratios::Fixed, bounds).unwrap()));
}

#[test]
fn the_law_of_gus() {
    let mut law = law(Family::Gus, 100.0, 0.0);
    law.set_direct(power(50.0));
    assert_eq!(power_of(&mut law, 30.0, 0.0), 50.0);
    // x = 0.1·v + 10, held in 10 to 14.
    begin(&mut law, 0.1, 10.0, 14.0);
    assert_eq!([0.0, 25.0, 40.0, 50.0].map(|v| power_of(&mut law, v, 0.0)), [10.0, 12.5, 14.0, 14.0]);
    // The velocity part is held, then the distance is added: 14 + 3, 10 − 3.
    distance(&mut law, None);
    assert_eq!(power_of(&mut law, 90.0, 300.0), 17.0);
    assert_eq!(power_of(&mut law, 0.0, -300.0), 7.0);
    // The sum is held in the distance's own bounds, and in those of the mode.
    distance(&mut law, Some((16.0, 8.0)));
    assert_eq!([300.0, -300.0].map(|x| power_of(&mut law, 90.0, x)), [16.0, 11.0]);
    assert_eq!(power_of(&mut law, 0.0, -300.0), 8.0);
    assert_eq!([1e6, -1e6].map(|x| power_of(&mut law, 0.0, x)), [16.0, 8.0]);
    // Without a velocity follow the distance adds to the direct power, which ends it.
    law.set_direct(power(11.0));
    assert_eq!(law.follows(), None);
    assert_eq!(power_of(&mut law, 90.0, 100.0), 12.0);
    law.set_distance(None);
    assert_eq!(power_of(&mut law, 90.0, 100.0), 11.0);
}

#[test]
fn the_law_of_lsr() {
    let mut law = law(Family::Lsr, 100.0, 0.0);
    law.set_direct(power(5.0));
    begin(&mut law, 0.1, 10.0, 18.0);
    // 0.1·v + 10 + 5, held in 10 to 18.
    assert_eq!([0.0, 20.0, 30.0, 90.0].map(|v| power_of(&mut law, v, 0.0)), [15.0, 17.0, 18.0, 18.0]);
    // Direct power does not end it, and adds.
    law.change(Crd::new(1).unwrap(), &Buffered::Direct { power: power(1.0) });
    assert_eq!(power_of(&mut law, 20.0, 0.0), 13.0);
    // The sum of all is held in the follow's bounds: 13 + 3, 13 − 4 → 10, 13 + 9 → 18.
    distance(&mut law, Some((12.0, 11.0)));
    assert_eq!([300.0, -400.0, 900.0].map(|x| power_of(&mut law, 20.0, x)), [16.0, 10.0, 18.0]);
    // Bounds given with the distance are ignored; those of the mode hold.
    law.set_bounds(PowerBounds::admit(PowerMode::Duty, power(17.0), power(15.0)).unwrap());
    assert_eq!([300.0, -400.0, 900.0].map(|x| power_of(&mut law, 20.0, x)), [16.0, 15.0, 17.0]);
    law.change(Crd::new(2).unwrap(), &Buffered::FollowOff);
    assert_eq!((law.follows(), power_of(&mut law, 20.0, 1500.0)), (None, 16.0));
}

/// "If bounds exclude each other, the lowest of the upper bounds is output."
#[test]
fn of_bounds_that_exclude_each_other_the_lowest_upper_one() {
    for family in [Family::Gus, Family::Lsr] {
        let mut law = law(family, 100.0, 40.0);
        begin(&mut law, 1.0, 10.0, 30.0);
        assert_eq!([0.0, 90.0].map(|v| power_of(&mut law, v, 0.0)), [30.0, 30.0]);
        law.set_bounds(PowerBounds::admit(PowerMode::Duty, power(5.0), power(1.0)).unwrap());
        assert_eq!([0.0, 90.0].map(|v| power_of(&mut law, v, 0.0)), [5.0, 5.0]);
    }
    let mut law = law(Family::Gus, 100.0, 40.0);
    law.set_direct(power(90.0));
    distance(&mut law, Some((20.0, 10.0)));
    assert_eq!([1e4, -1e4].map(|x| power_of(&mut law, 0.0, x)), [20.0, 20.0]);
}

#[test]
fn sources_start_powers_and_tables() {
    let mut law = law(Family::Lsr, 100.0, 0.0);
    let crd = Crd::new(0).unwrap();
    begin(&mut law, 1.0, 0.0, 100.0);
    assert_eq!(power_of(&mut law, 20.0, 0.0), 20.0);
    // The encoder's speed, from then on; the direct power stays.
    law.set_direct(power(3.0));
    law.change(crd, &Buffered::FollowMode { source: SpeedSource::Encoder, start: None });
    assert_eq!(power_of(&mut law, 20.0, 0.0), 43.0);
    law.change(crd, &Buffered::FollowMode { source: SpeedSource::Encoder, start: Some(power(7.0)) });
    assert_eq!(power_of(&mut law, 20.0, 0.0), 47.0);
    // BufLaserPrfFollow is of the planned speed.
    let bounds = follow(90.0, 1.0);
    law.change(crd, &Buffered::PrfFollow { ratio: ratio(2.0), bounds });
    assert_eq!(power_of(&mut law, 20.0, 0.0), 48.0);
    // A table: 20 at 10, 60 at 50 pulse/ms, nothing added but the direct power.
    law.change(crd, &Buffered::FollowTable { table: Curve::power(1, 3).unwrap(), bounds });
    assert_eq!([0.0, 10.0, 35.0, 90.0].map(|v| power_of(&mut law, v, 0.0)), [27.0, 27.0, 52.0, 67.0]);
    law.change(crd, &Buffered::FollowTable { table: Curve::power(1, 3).unwrap(), bounds: follow(40.0, 30.0) });
    assert_eq!([0.0, 20.0, 90.0].map(|v| power_of(&mut law, v, 0.0)), [30.0, 37.0, 40.0]);
    // A follow of another crd is of its path.
    law.change(Crd::new(1).unwrap(), &Buffered::PrfFollow { ratio: ratio(1e-5), bounds });
    assert_eq!(power_of(&mut law, 20.0, 0.0), 18.0);
    law.end_follow(CrdMask(0b1101));
    assert_eq!(law.follows(), Crd::new(1));
    law.end_follow(CrdMask(0b10));
    assert_eq!(power_of(&mut law, 20.0, 0.0), 7.0);
    begin(&mut law, 1.0, 0.0, 100.0);
    law.leave_mode();
    assert_eq!(power_of(&mut law, 20.0, 0.0), 0.0);
}
