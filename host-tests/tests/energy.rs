//! Energy per distance under velocity follow, from the pulses that the machine outputs.
//!
//! A bin lasts from the begin of one carrier period to the begin of another, both at ticks, and
//! holds at least 200 periods. So no pulse is cut in two, and dither spreads the odd counts of 200
//! widths. Its distance is the model's, so a bin may be very short in pulses of the path.
#[path = "path/machine.rs"]
mod machine;

use host_tests::laser_model::{Family, Ns};
use host_tests::path_model::{Command, Course, Entry, Frame, Geometry, Rates, course};
use machine::Machine;

const MS: Ns = 1_000_000;
/// ns of full power a pulse of the path gets: 0.1937 % for each pulse/ms.
const RATIO: f64 = 0.1937;

/// Lit ns of each bin for what they should be, with its speed.
fn bins(course: &Course, start: Ns, tick: Ns, energy: &[(Ns, bool)]) -> Vec<(f64, f64)> {
    let end = course.rests[0].at;
    let length = (2 * MS / tick).max(1) * tick;
    let mut bins = Vec::new();
    let mut from = start;
    while ((from + length) as f64) < end * 1e6 {
        let to = from + length;
        let after = energy.partition_point(|edge| edge.0 < from);
        let until = energy.partition_point(|edge| edge.0 < to);
        let edges = &energy[after..until];
        assert!(edges.is_empty() || edges[0].1, "no pulse is cut by a bin");
        let lit: Ns = edges.chunks(2).map(|pulse| pulse[1].0 - pulse[0].0).sum();
        let distance = course.distance(to as f64 / 1e6) - course.distance(from as f64 / 1e6);
        bins.push((distance / (length as f64 / 1e6), lit as f64 / (distance * RATIO / 100.0 * 1e6)));
        from = to;
    }
    bins
}

#[test]
fn a_pulse_of_the_path_gets_the_same_energy_at_any_speed() {
    for (tick, acc) in [(10_000, 0.7331), (50_000, 0.7331), (250_000, 0.7331), (1_000_000, 0.3313)] {
        let machine = Machine::new(Family::Gus, tick);
        let (speed, distance) = (512.0, 700_000);
        let text = format!(
            "TCrdPrm crd;memset(&crd,0,sizeof(crd));\nGT_SetAxisMode(7,1);\nGT_LaserPowerMode(0,100,0,0);\nGT_LaserOutFrq(100,0);\nGT_AxisOn(1);\nGT_AxisOn(2);\nGT_LmtsOff(1);\nGT_LmtsOff(2);\n\
             crd.dimension=2;\ncrd.profile[0]=1;\ncrd.profile[1]=2;\ncrd.synVelMax=1000;\ncrd.synAccMax=100;\nGT_SetCrdPrm(1,&crd);\nGT_CrdClear(1,0);\n\
             GT_BufLaserPrfFollow(1,{RATIO},0,100,0,0);\nGT_BufLaserOn(1,0,0);\nGT_LnXY(1,{distance},0,{speed},{acc},0,0);\nGT_BufLaserOff(1,0,0);\n\
             Sleep(4);\nGT_CrdStart(1,0);\nWaitStop(1<<8);\nSleep(2);\n"
        );
        let reported = machine.run(&text);
        let frame = Frame { speed: 1000.0, acc: 100.0, even_ms: 0.0 };
        let geometry = Geometry::line([0.0; 4], [f64::from(distance), 0.0, 0.0, 0.0]);
        let entries = [Entry::Motion(geometry, Rates { speed, acc, end: 0.0 })];
        let start = 4 * MS + tick;
        let course = course(&frame, &entries, &[(start as f64 / 1e6, Command::Start)], 1e9);
        let bins = bins(&course, start, tick, &reported.lasers[0].energy);
        let judged = bins.iter().filter(|bin| bin.0 >= speed / 100.0);
        let worst = judged.clone().map(|bin| (bin.1 - 1.0).abs()).fold(0.0, f64::max);
        let slowest = judged.clone().map(|bin| bin.0).fold(f64::MAX, f64::min);
        println!(
            "tick {tick} ns: {} bins from {slowest:.2} pulse/ms on, energy within {:.5} %",
            bins.len(),
            worst * 100.0
        );
        assert!(judged.count() > 200 && slowest < speed / 95.0);
        assert!(worst < 1e-3, "tick {tick}: {worst}");
    }
}
