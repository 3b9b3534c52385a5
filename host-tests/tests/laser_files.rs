//! Laser channels in trace files against what a person can work out by hand.
use plant::beam::SignalChange;
use plant::pulses::Burst;
use servo::laser::{Count, Train};
use servo::segment::piece::Scaled;
use servo::units::Pos;
use std::path::PathBuf;
use trace::{
    AxisName, AxisPoint, CsvWriter, Header, LaserName, LaserPoint, Plot, PlotOptions, PowerUnit, Row, TraceError,
    VcdWriter,
};

const TICK_NS: u64 = 250_000;

fn header(lasers: &[u8]) -> Header {
    Header {
        axes: vec![AxisName { core: 1, axis: 1 }],
        lasers: lasers.iter().map(|k| LaserName(*k)).collect(),
        crds: vec![],
        period_ns: TICK_NS,
        every: 1,
    }
}

fn row(index: u32, pulses: f64, lasers: Vec<LaserPoint>) -> Row {
    let axis = AxisPoint { pos: Pos((pulses * f64::from(1 << 22)) as i64), vel: Scaled::default() };
    Row { index, t_ns: u64::from(index) * TICK_NS, axes: vec![axis], lasers, crds: vec![] }
}

fn point(gate: bool, power: f64, unit: PowerUnit, khz: f64) -> LaserPoint {
    let scaled = |value: f64| Scaled { m: (value * 1048576.0) as i64, e: 20 };
    LaserPoint { gate, power: scaled(power), unit, frequency: scaled(khz) }
}

#[test]
fn csv_has_three_columns_for_each_laser() {
    let mut out = Vec::new();
    let mut csv = CsvWriter::new(&mut out, &header(&[0, 1])).unwrap();
    let dark = LaserPoint::default();
    csv.row(&row(0, 0.0, vec![dark, dark])).unwrap();
    let lit = point(true, 25.0, PowerUnit::Percent, 10.0);
    csv.row(&row(1, 2.5, vec![lit, point(false, 0.0625, PowerUnit::Kilohertz, 0.0625)])).unwrap();
    csv.finish().unwrap();
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "t_ms,axis1_pos,axis1_vel,laser0_gate,laser0_power,laser0_freq_khz,laser1_gate,laser1_power,laser1_freq_khz\n\
         0.000000,0.000000,0.000000,0,0.000000,0.000000,0,0.000000,0.000000\n\
         0.250000,2.500000,0.000000,1,25.000000,10.000000,0,0.062500,0.062500\n"
    );
}

/// Two pulses of 40 µs every 100 µs, a finished one, one that is cut; FPK-like switch edges between
/// ticks.
#[test]
fn vcd_shows_pulses_switch_and_voltage_to_the_nanosecond() {
    let mut out = Vec::new();
    let mut vcd = VcdWriter::new(&mut out, &header(&[0, 1]), &[(2, false)], &[]).unwrap();
    let lasers = || vec![LaserPoint::default(); 2];
    vcd.row(&row(0, 0.0, lasers())).unwrap();
    vcd.change(0, &SignalChange::Switch { at: 3, level: true });
    // 100 µs and a half ns: the first period is the shorter one.
    let train = Train { period: Count { whole: 100_000, part: 1, of: 2 }, width: whole(40_000) };
    vcd.change(0, &SignalChange::Pulses(Burst::new(100_007, 2, train)));
    vcd.change(1, &SignalChange::Dac { at: 100_007, code: 8_192 });
    vcd.change(1, &SignalChange::Dac { at: 249_999, code: -32_767 });
    // Begins before the row and ends after it.
    vcd.change(0, &SignalChange::Energy { at: 249_000, level: true });
    vcd.row(&row(1, 0.0, lasers())).unwrap();
    vcd.change(0, &SignalChange::Energy { at: 250_100, level: false });
    vcd.change(0, &SignalChange::Switch { at: 250_000, level: false });
    // A full duty has no edges between its pulses, a duty of 0 none at all.
    let full = Train { period: whole(500), width: whole(500) };
    vcd.change(1, &SignalChange::Pulses(Burst::new(300_000, 3, full)));
    vcd.change(1, &SignalChange::Pulses(Burst::new(400_000, 3, Train { width: whole(0), ..full })));
    vcd.row(&row(2, 0.0, lasers())).unwrap();
    vcd.finish().unwrap();
    assert_eq!(
        String::from_utf8(out).unwrap(),
        "$timescale 1 ns $end\n$scope module beamtick $end\n\
         $var wire 1 ! axis1_step $end\n$var wire 1 \" axis1_dir $end\n$var wire 1 # do2 $end\n\
         $var wire 1 $ laser0_energy $end\n$var wire 1 % laser0_switch $end\n$var real 64 & laser0_dac_mv $end\n\
         $var wire 1 ' laser1_energy $end\n$var wire 1 ( laser1_switch $end\n$var real 64 ) laser1_dac_mv $end\n\
         $upscope $end\n$enddefinitions $end\n\
         #0\n0!\n0\"\n0#\n0$\n0%\nr0 &\n0'\n0(\nr0 )\n\
         #3\n1%\n\
         #100007\n1$\nr2500.076 )\n\
         #140007\n0$\n\
         #200007\n1$\n\
         #240007\n0$\n\
         #249000\n1$\n\
         #249999\nr-10000 )\n\
         #250000\n0%\n\
         #250100\n0$\n\
         #300000\n1'\n\
         #301500\n0'\n\
         #500000\n"
    );
}

fn whole(whole: u64) -> Count {
    Count { whole, part: 0, of: 0 }
}

/// A laser that marks: 20 ms on and 10 ms off, 20 kHz with a duty that rises with time.
fn marks(options: PlotOptions, rows: u32, period: u32, unit: PowerUnit) -> Plot {
    let mut plot = Plot::new(&header(&[0]), options).unwrap();
    for index in 0..rows {
        let t_ns = u64::from(index) * TICK_NS;
        let on = t_ns % 30_000_000 < 20_000_000 && index > 0;
        let duty = 10.0 + 70.0 * f64::from(index) / f64::from(rows);
        if index > 0 {
            let begin = t_ns - TICK_NS;
            plot.change(0, &SignalChange::Switch { at: begin + 1_000, level: on });
            if on {
                let width = whole((f64::from(period) * duty / 100.0) as u64);
                let train = Train { period: whole(period.into()), width };
                plot.change(0, &SignalChange::Pulses(Burst::new(begin + 1_000, TICK_NS / u64::from(period), train)));
            }
        }
        let khz = 1e6 / f64::from(period);
        let power = if on { duty } else { 0.0 };
        plot.row(&row(index, f64::from(index), vec![point(on, power, unit, if on { khz } else { 0.0 })]));
    }
    plot
}

fn saved(name: &str, plot: &Plot) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("laser_plots");
    std::fs::create_dir_all(&folder).unwrap();
    plot.save(&folder.join(format!("{name}.png"))).unwrap();
    let svg = folder.join(format!("{name}.svg"));
    plot.save(&svg).unwrap();
    std::fs::read_to_string(svg).unwrap()
}

fn window(from: Option<f64>, to: Option<f64>) -> PlotOptions {
    PlotOptions {
        title: "marks".into(),
        subtitle: "virtual".into(),
        from_ms: from,
        to_ms: to,
        ..PlotOptions::default()
    }
}

#[test]
fn dense_pulses_are_shares_and_single_ones_are_edges() {
    // 400 ms of 20 kHz are thousands of pulses.
    let dense = saved("dense", &marks(window(None, None), 1600, 50_000, PowerUnit::Percent));
    for part in
        ["laser 0 gate", "laser 0 pulses, share of time", "laser 0 power: duty (%), per tick", "100 %", "time (ms)"]
    {
        assert!(dense.contains(part), "no {part:?}");
    }
    // 1 ms of them are twenty.
    let single = saved("single", &marks(window(Some(100.0), Some(101.0)), 1600, 50_000, PowerUnit::Percent));
    assert!(single.contains("laser 0 pulses<") || single.contains("laser 0 pulses\n"), "{single}");
    assert!(!single.contains("share of time") && single.contains("on"));
    // 10 µs of a 2 MHz train lie within one tick; the motion is drawn all the same.
    let within = saved("within", &marks(window(Some(100.01), Some(100.02)), 1600, 500, PowerUnit::Percent));
    assert!(within.contains("time (µs)") && !within.contains("share of time"));
    let khz = saved("khz", &marks(window(Some(0.0), Some(60.0)), 1600, 50_000, PowerUnit::Kilohertz));
    assert!(khz.contains("laser 0 power: pulse rate (kHz), per tick") && !khz.contains("duty (%)"));
}

#[test]
fn times_that_are_no_window_are_refused_with_the_reason() {
    let refused = |from: Option<f64>, to: Option<f64>| match Plot::new(&header(&[0]), window(from, to)) {
        Err(TraceError::Window(text)) => text,
        other => panic!("{from:?} {to:?}: {:?}", other.map(|_| ())),
    };
    assert!(refused(Some(-1.0), None).contains("from is -1 ms; it must be from 0"));
    assert!(refused(None, Some(f64::NAN)).contains("to is NaN ms"));
    assert!(refused(None, Some(0.0)).contains("later than from"));
    assert!(refused(Some(20.0), Some(10.0)).contains("to is 10 ms; it must be later than from, which is 20 ms"));
    assert!(refused(Some(f64::INFINITY), None).contains("from is inf ms"));
}
