//! Look-ahead through the whole machine: 10,000 motions of 0.1 mm (100 pulses) and a spiral, fed over the link. Limits are
//! checked on the trace, the time is held against an optimum computed offline, and a host that stalls for 50 ms now and
//! then must not be noticed.
#[path = "path/machine.rs"]
mod machine;

use host_tests::laser_model::Family;
use host_tests::optimum::{Limits, Point, Turn, plan};
use machine::Machine;
use protocol::command::{CrdSpace, LnXYMany, PathXY};
use std::time::Duration;

const TICK_US: u64 = 250;
const LIMITS: Limits = Limits { speed: 300.0, acc: 4.0, axis_speed: [250.0, 200.0], axis_acc: [3.0, 2.0], corner: 5.0 };

/// Points about 100 pulses apart along a curve, in whole pulses; the first is the origin.
fn points(count: usize, curve: impl Fn(f64) -> Point) -> Vec<Point> {
    let origin = curve(0.0);
    let mut points = vec![[0.0, 0.0]];
    let mut at = 0.0;
    while points.len() <= count {
        let from = curve(at);
        let mut step = 1e-7;
        let distance = |step: f64| {
            let to = curve(at + step);
            (to[0] - from[0]).hypot(to[1] - from[1])
        };
        while distance(step) < 100.0 {
            step *= 1.2;
        }
        at += step * 100.0 / distance(step);
        let to = curve(at);
        points.push([(to[0] - origin[0]).round(), (to[1] - origin[1]).round()]);
    }
    points
}

/// Wide arcs, narrow ones and corners: a contour.
fn contour() -> Vec<Point> {
    points(10_000, |t| {
        let radius = 60_000.0 + 12_000.0 * (7.0 * t).sin() + 600.0 * (31.0 * t).cos();
        [radius * t.cos(), radius * t.sin()]
    })
}

fn spiral() -> Vec<Point> {
    points(6_000, |t| {
        let radius = 200.0 + 800.0 * t;
        [radius * t.cos(), radius * t.sin()]
    })
}

/// Positions of both axes at every tick of the motion.
struct Ran {
    places: Vec<Point>,
    ms: f64,
}

/// Feeds the points; before every `every`th batch the host stalls.
fn run(points: &[Point], every: usize, stall: Duration) -> Ran {
    let machine = Machine::new(Family::Gus, TICK_US as i64 * 1000).traced(0b11, 0);
    let Limits { speed, acc, axis_speed, axis_acc, corner } = LIMITS;
    machine.run(&format!(
        "TCrdPrm crd;memset(&crd,0,sizeof(crd));\nGT_AxisOn(1);\nGT_AxisOn(2);\nGT_LmtsOff(1);\nGT_LmtsOff(2);\ncrd.dimension=2;\ncrd.profile[0]=1;\ncrd.profile[1]=2;\n\
         crd.synVelMax={speed:?};\ncrd.synAccMax={acc:?};\nGT_SetCrdPrm(1,&crd);\nGT_CrdClear(1,0);\n\
         GT_SetCrdLimit(1,1,{:?},{:?});\nGT_SetCrdLimit(1,2,{:?},{:?});\nGT_InitLookAhead(1,0,{corner:?},{:?},200);\n",
        axis_speed[0], axis_acc[0], axis_speed[1], axis_acc[1], axis_acc[0].max(axis_acc[1])
    ));
    machine.trace();
    let client = &machine.client;
    let mut begun = false;
    let start = || {
        let start = protocol::command::CrdStart { core: 1.into(), mask: 1.into(), option: 0.into() };
        machine.client.call(start).unwrap();
    };
    for (number, batch) in points[1..].chunks(32).enumerate() {
        let items: Vec<PathXY> =
            batch.iter().map(|point| PathXY { x: (point[0] as i32).into(), y: (point[1] as i32).into() }).collect();
        let space = || client.call(CrdSpace { core: 1.into(), crd: 1.into(), fifo: 0.into() }).unwrap().value.get();
        while space() < 32 {
            if !begun {
                start();
                begun = true;
            }
            client.sleep(Duration::from_millis(4)).unwrap();
        }
        if begun && number % every == 0 {
            client.sleep(stall).unwrap();
        }
        let request = LnXYMany {
            core: 1.into(),
            crd: 1.into(),
            fifo: 0.into(),
            count: (items.len() as u16).into(),
            syn_vel: speed.into(),
            syn_acc: acc.into(),
            vel_end: 0.0.into(),
        };
        client.call_items(request, &items).unwrap();
    }
    machine
        .client
        .call_items(protocol::command::CrdData { core: 1.into(), crd: 1.into(), fifo: 0.into() }, &[])
        .unwrap();
    if !begun {
        start();
    }
    let end = *points.last().unwrap();
    let mut rows = Vec::new();
    for _ in 0..400 {
        client.sleep(Duration::from_millis(100)).unwrap();
        let info = protocol::command::CrdInfo { core: 1.into(), crd: 1.into() };
        if client.call(info).unwrap().run == 0 {
            rows = machine.take_rows();
            break;
        }
    }
    assert!(!rows.is_empty(), "it does not end");
    let place = |row: &trace::Row| [0, 1].map(|axis: usize| row.axes[axis].pos.0 as f64 / f64::from(1 << 22));
    let places: Vec<Point> = rows.iter().map(place).collect();
    let first = places.iter().position(|place| *place != [0.0, 0.0]).unwrap() - 1;
    let last = places.iter().position(|place| *place == end).unwrap();
    let ms = (last - first) as f64 * TICK_US as f64 / 1000.0;
    Ran { places: places[first..=last].to_vec(), ms }
}

/// No axis beyond its limits: velocity from tick to tick, acceleration as the second difference over `half` ticks to each side,
/// which is a mean of the acceleration over twice that time. Tells the greatest shares.
fn shares(places: &[Point], half: usize) -> [f64; 2] {
    let ms = TICK_US as f64 / 1000.0;
    let mut shares = [0.0f64; 2];
    for axis in 0..2 {
        for pair in places.windows(2) {
            let speed = (pair[1][axis] - pair[0][axis]).abs() / ms;
            shares[0] = shares[0].max(speed / LIMITS.axis_speed[axis]);
        }
        let h = half as f64 * ms;
        for middle in half..places.len() - half {
            let second = places[middle + half][axis] - 2.0 * places[middle][axis] + places[middle - half][axis];
            let share = second.abs() / (h * h) / LIMITS.axis_acc[axis];
            shares[1] = shares[1].max(share);
        }
    }
    shares
}

fn judge(name: &str, points: &[Point]) {
    let free = run(points, usize::MAX, Duration::ZERO);
    let stalled = run(points, 3, Duration::from_millis(50));
    let (_, best) = plan(points, &LIMITS, Turn::Adds);
    let (_, least) = plan(points, &LIMITS, Turn::Cancels);
    // Over twice the corner time: corners change velocities at once.
    let [speed, acc] = shares(&free.places, (2.0 * LIMITS.corner * 1000.0) as usize / TICK_US as usize);
    println!(
        "{name}: {} motions, {:.2} ms, {:.2} % above the optimum of {best:.2} ms, {:.2} % above what no rule for corners allows; \
         {:.2} ms with stalls; \
         {:.2} % of an axis's velocity, {:.2} % of its acceleration",
        points.len() - 1,
        free.ms,
        (free.ms / best - 1.0) * 100.0,
        (free.ms / least - 1.0) * 100.0,
        stalled.ms,
        speed * 100.0,
        acc * 100.0
    );
    assert!(speed <= 1.0 && acc <= 1.0, "{name}: {speed} {acc}");
    assert!(free.ms <= best * 1.03, "{name}");
    assert_eq!(free.ms, stalled.ms, "{name}: the stalls are seen");
    assert_eq!(free.places, stalled.places, "{name}");
}

#[test]
fn a_polyline_of_ten_thousand_motions() {
    judge("contour", &contour());
}

#[test]
fn a_spiral() {
    judge("spiral", &spiral());
}
