//! The programs of `examples/c` compile without a warning, run in the virtual controller, and do
//! what the manual says: asserted on the trace.

mod csv;
mod toolchain;

use csv::Trace;
use std::path::PathBuf;
use toolchain::{Language, build_file, output, root, scratch};

/// Builds and runs an example; its output and its trace.
fn traced(name: &str, variables: &[(&str, &str)], words: &[&str]) -> Option<(String, Trace)> {
    let source = root().join(format!("examples/c/{name}.cpp"));
    let built = build_file(Language::Cpp, name, &source, &["-Wpedantic"])?;
    let trace = scratch().join(format!("{name}{}.csv", words.concat()));
    let trace_name = trace.to_string_lossy().into_owned();
    let mut all = vec![("BEAMTICK_LINK", "virtual:max"), ("BEAMTICK_TRACE", trace_name.as_str())];
    all.extend(variables);
    let text = toolchain::output_of(toolchain::command(&built, &all).args(words));
    Some((text, Trace::read(&trace)))
}

fn near(found: f64, wanted: f64, within: f64, what: &str) {
    assert!((found - wanted).abs() <= within, "{what}: {found}, wanted {wanted}");
}

/// A program that changes the servo tick: every row stands at the time of its tick, and a motion of
/// 100 ms takes 100 ms in it.
#[test]
fn a_trace_keeps_time_when_the_tick_changes() {
    let text = "#include \"gts.h\"\n#include <windows.h>\nint main(void)\n{\n    if (GT_Open(0, 1) || GT_AxisOn(1) || GT_PrfPt(1, 0)) return 1;\n\
                Sleep(10);\n    if (GT_SetTick(50) || GT_PtData(1, 100, 50, 0, 0) || GT_PtData(1, 200, 100, 2, 0) || GT_PtStart(1, 0)) return 2;\n\
                Sleep(150);\n    if (GT_SetTick(1000)) return 3;\n    Sleep(20);\n    return GT_Close();\n}\n";
    let Some(built) = toolchain::build(Language::C, "set_tick", text) else { return };
    let trace = scratch().join("set_tick.csv");
    let name = trace.to_string_lossy().into_owned();
    output(&built, &[("BEAMTICK_LINK", "virtual:max"), ("BEAMTICK_TRACE", name.as_str())]);
    let trace = Trace::read(&trace);
    let times = trace.column("t_ms");
    let steps: Vec<f64> = times.windows(2).map(|pair| ((pair[1] - pair[0]) * 1e6).round() / 1e6).collect();
    let mut runs: Vec<(f64, usize)> = Vec::new();
    for step in steps {
        match runs.last_mut() {
            Some((last, count)) if *last == step => *count += 1,
            _ => runs.push((step, 1)),
        }
    }
    let [(0.25, before), (0.05, between), (1.0, after)] = runs[..] else { panic!("{runs:?}") };
    assert!(before >= 40 && between >= 3000 && after >= 20, "{runs:?}");
    let start = trace.start("axis1");
    near(trace.at(start + 50.0, "axis1_pos"), 100.0, 1e-6, "position");
    near(trace.at(start + 100.0, "axis1_pos"), 200.0, 1e-6, "position");
    near(trace.at(start + 75.0, "axis1_vel"), 2.0, 1e-6, "velocity");
}

/// A trace holds what the program used; what a program that dies leaves holds everything.
#[test]
fn a_trace_holds_what_was_used() {
    let text = "#include \"gts.h\"\n#include <windows.h>\n#include <stdlib.h>\nint main(int n, char **words)\n{\n    TCrdPrm prm = {0}; (void)words;\n\
                prm.dimension = 1; prm.profile[3] = 1; prm.synVelMax = 10; prm.synAccMax = 1;\n\
                if (GT_Open(0, 1) || GT_AxisOn(2) || GT_PrfPt(2, 0)) return 1;\n\
                if (GT_PtData(2, 100, 50, 0, 0) || GT_PtData(2, 200, 100, 2, 0) || GT_PtStart(1 << 1, 0)) return 2;\n\
                if (GT_SetCrdPrm(1, &prm) || GT_LaserOff(1) || GT_SetDoBit(MC_GPO, 3, 1)) return 3;\n\
                Sleep(150);\n    if (n > 1) _Exit(0);\n    return GT_Close();\n}\n";
    let Some(built) = toolchain::build(Language::C, "uses", text) else { return };
    let (csv, vcd) = (scratch().join("uses.csv"), scratch().join("uses.vcd"));
    let names = [csv.to_string_lossy().into_owned(), vcd.to_string_lossy().into_owned()];
    let variables =
        [("BEAMTICK_LINK", "virtual:max"), ("BEAMTICK_TRACE", names[0].as_str()), ("BEAMTICK_VCD", names[1].as_str())];
    output(&built, &variables);
    let rows = std::fs::read_to_string(&csv).unwrap();
    let columns = "t_ms,axis2_pos,axis2_vel,axis4_pos,axis4_vel,laser1_gate,laser1_power,laser1_freq_khz,crd1_vel";
    assert_eq!(rows.lines().next(), Some(columns));
    let trace = Trace::read(&csv);
    near(trace.last("axis2_pos"), 200.0, 0.0, "the end");
    let signals = std::fs::read_to_string(&vcd).unwrap();
    let declared = signals.lines().filter(|line| line.starts_with("$var"));
    let declared: Vec<&str> = declared.map(|line| line.split(' ').nth(4).unwrap()).collect();
    let wanted = ["axis2_step", "axis2_dir", "axis4_step", "axis4_dir", "do3", "laser1_energy", "laser1_switch"];
    assert_eq!(declared, [&wanted[..], &["laser1_dac_mv"]].concat());
    let step = signals.lines().find(|line| line.ends_with(" axis2_step $end")).unwrap().split(' ').nth(3).unwrap();
    assert_eq!(signals.lines().filter(|line| *line == format!("1{step}")).count(), 200, "pulses of axis 2");
    assert!(!csv.with_extension("csv.partial").exists() && !vcd.with_extension("vcd.partial").exists());
    toolchain::output_of(toolchain::command(&built, &variables).arg("dies"));
    let left = std::fs::read_to_string(csv.with_extension("csv.partial")).unwrap();
    assert!(left.is_empty() || left.starts_with("t_ms,axis1_pos,axis1_vel,axis2_pos"), "{left}");
}

#[test]
fn pt_static() {
    let Some((text, trace)) = traced("pt_static", &[], &[]) else { return };
    assert_eq!(text, "32 free segments\n29 free segments after three\nat 4096.0 with 0.00 pulse/ms\n");
    let start = trace.start("axis1");
    for (t, pos, vel) in [
        (0.0, 0.0, 0.0),
        (512.0, 256.0, 1.0),
        (1024.0, 1024.0, 2.0),
        (1536.0, 2048.0, 2.0),
        (2048.0, 3072.0, 2.0),
        (2560.0, 3840.0, 1.0),
        (3072.0, 4096.0, 0.0),
    ] {
        near(trace.at(start + t, "axis1_pos"), pos, 1e-6, "position");
        near(trace.at(start + t, "axis1_vel"), vel, 1e-6, "velocity");
    }
    near(trace.last("axis1_pos"), 4096.0, 0.0, "the end");
}

#[test]
fn pt_dynamic() {
    let Some((text, trace)) = traced("pt_dynamic", &[], &[]) else { return };
    assert_eq!(text, "126 segments, at 0.0\n");
    let start = trace.start("axis1");
    // The knots of the sine, 16 ms apart, have its velocity but for the cut to whole ms and the
    // trapezoid's sum.
    for n in 1..62 {
        let t = 16.0 * f64::from(n);
        let wanted = 10.0 * (std::f64::consts::TAU * t / 1000.0).sin();
        near(trace.at(start + t, "axis1_vel"), wanted, 0.02, "velocity");
        near(trace.at(start + t + 1000.0, "axis1_vel"), wanted, 0.05, "velocity of the second period");
    }
    near(trace.at(start + 500.0, "axis1_pos"), 10_000.0 / std::f64::consts::PI, 10.0, "the far end");
    near(trace.at(start + 2000.0, "axis1_pos"), 0.0, 1e-6, "the end");
}

#[test]
fn follow_single() {
    let Some((text, trace)) = traced("follow_single", &[("BEAMTICK_KEYS", "3600")], &[]) else { return };
    assert!(text.starts_with("2 passes, master 50.00, slave "), "{text}");
    // The master passes 50000 pulses; from there the slave repeats 60000 master pulses, 40000 of
    // its own.
    let (master, slave) = (trace.column("axis1_pos"), trace.column("axis2_pos"));
    for (master, slave) in master.iter().zip(slave) {
        let way = master - 50_000.0;
        let (pass, rest) = ((way / 60_000.0).floor().max(0.0), way.rem_euclid(60_000.0));
        let wanted = match rest {
            _ if way <= 0.0 => 0.0,
            rest if rest < 20_000.0 => rest * rest / 40_000.0,
            rest if rest < 40_000.0 => rest - 10_000.0,
            rest => 40_000.0 - (60_000.0 - rest).powi(2) / 40_000.0,
        };
        // AxisOff at the end stops master and slave a call apart.
        if trace.time() - 10.0 > 0.0 && way < 120_000.0 {
            near(*slave, pass * 40_000.0 + wanted, 0.01, "slave");
        }
    }
}

#[test]
fn follow_shear() {
    let Some((text, trace)) = traced("follow_shear", &[], &[]) else { return };
    assert!(text.starts_with("FIFO 1, 3 cuts after the first\nbelt "), "{text}");
    let (belt, knife) = (trace.column("axis1_pos"), trace.column("axis2_pos"));
    let ratios: Vec<f64> =
        trace.column("axis2_vel").iter().zip(trace.column("axis1_vel")).map(|(knife, belt)| knife / belt).collect();
    // Place and ratio of the knife where the belt is at this position, between two ticks.
    let when = |at: f64| {
        let row = belt.iter().position(|pos| *pos >= at).unwrap_or_else(|| panic!("the belt never reaches {at}"));
        let part = (at - belt[row - 1]) / (belt[row] - belt[row - 1]);
        (knife[row - 1] + part * (knife[row] - knife[row - 1]), ratios[row])
    };
    let (to_first, ratio) = when(5000.0);
    near(to_first, 2500.0, 0.5, "table 3-2");
    near(ratio, 1.0, 0.01, "the ratio at the first cut");
    for cut in 0..3 {
        let (first_belt, first_knife) = (5000.0 + 10_000.0 * f64::from(cut), 2500.0 + 8000.0 * f64::from(cut));
        for (way, wanted, ratio) in [
            (500.0, 500.0, 1.0),
            (1000.0, 1000.0, 1.0),
            (4000.0, 3400.0, 0.6),
            (5000.0, 4000.0, 0.6),
            (6000.0, 4600.0, 0.6),
            (9000.0, 7000.0, 1.0),
            (9500.0, 7500.0, 1.0),
            (10_000.0, 8000.0, 1.0),
        ] {
            let (place, found) = when(first_belt + way);
            near(place, first_knife + wanted, 0.5, &format!("table 3-3, cut {cut}, {way}"));
            near(found, ratio, 0.01, &format!("the ratio of cut {cut} at {way}"));
        }
    }
    // Both are at rest in the end, the knife where the curve has it.
    let (end, speeds) = (trace.last("axis1_pos"), (trace.last("axis1_vel"), trace.last("axis2_vel")));
    assert_eq!(speeds, (0.0, 0.0));
    assert!(text.contains(&format!("belt {end:.1}, knife {:.1}\n", trace.last("axis2_pos"))), "{text}");
}

#[test]
fn follow_switch() {
    let Some((text, trace)) = traced("follow_switch", &[("BEAMTICK_KEYS", "1800,5800")], &[]) else { return };
    assert!(text.starts_with("master 50.00, slave "), "{text}");
    let vel = trace.column("axis2_vel");
    let ratio: Vec<f64> = vel.iter().map(|vel| vel / 50.0).collect();
    // The old curve comes to rest; the new one never goes below 0.6 again.
    let least = |from: f64, to: f64| trace.rows(from, to).map(|row| ratio[row]).fold(f64::MAX, f64::min);
    assert!(least(600.0, 2000.0) < 0.01, "the old curve: {}", least(600.0, 2000.0));
    near(least(4200.0, 5700.0), 0.6, 0.01, "the new curve");
    let most = trace.rows(4200.0, 5700.0).map(|row| ratio[row]).fold(0.0, f64::max);
    near(most, 1.0, 1e-6, "its plateau");
}

#[test]
fn pvt_points() {
    let Some((text, trace)) = traced("pvt_points", &[], &[]) else { return };
    assert!(text.starts_with("table 1 at ") && text.trim_end().ends_with(": 68966.0"), "{text}");
    let start = trace.start("axis1");
    for (t, pos, vel) in [
        (1200.0, 9750.0, 15.25),
        (2000.0, 24483.0, 20.0),
        (2500.0, 34483.0, 20.0),
        (3000.0, 44483.0, 20.0),
        (3800.0, 59216.0, 15.25),
    ] {
        near(trace.at(start + t, "axis1_pos"), pos, 1e-6, "position");
        near(trace.at(start + t, "axis1_vel"), vel, 1e-6, "velocity");
    }
}

#[test]
fn pvt_complete() {
    let Some((text, trace)) = traced("pvt_complete", &[("BEAMTICK_KEYS", "5600A,9600B,13850Q")], &[]) else { return };
    assert_eq!(text, "key A: amplitude 60000\nkey B: amplitude 30000\n");
    let start = trace.start("axis1");
    // At whole passes it is back at the begin; the tables take over there.
    for (t, pos) in [
        (1000.0, 40_000.0),
        (2000.0, 0.0),
        (5000.0, 40_000.0),
        (6000.0, 0.0),
        (7000.0, 60_000.0),
        (9000.0, 60_000.0),
        (10_000.0, 0.0),
        (11_000.0, 30_000.0),
        (12_000.0, 0.0),
    ] {
        near(trace.at(start + t, "axis1_pos"), pos, 1e-3, "position");
    }
    // Between the points it is the function, but for the spline's error (figure 4-6).
    for (t, share) in [(250.0, 0.146_447), (750.0, 0.853_553)] {
        near(trace.at(start + t, "axis1_pos"), 40_000.0 * share, 400.0, "between the points");
    }
}

#[test]
fn pvt_percent() {
    let Some((text, trace)) = traced("pvt_percent", &[], &[]) else { return };
    assert_eq!(text, "velocities of X: 0 10 10 0 -10 -10 0\nX 0.0, Y 45000.0\n");
    let start = trace.start("axis1");
    near(trace.start("axis2") - start, 2000.0, 0.51, "Y's delay");
    for (t, x, y) in [
        (1000.0, 5000.0, 0.0),
        (2000.0, 15_000.0, 0.0),
        (3000.0, 20_000.0, 7500.0),
        (4000.0, 15_000.0, 15_000.0),
        (5000.0, 5000.0, 15_000.0),
        (6000.0, 0.0, 22_500.0),
        (12_000.0, 0.0, 45_000.0),
    ] {
        // A ramp's first ticks show no motion yet: the start is known to two ticks.
        near(trace.at(start + t, "axis1_pos"), x, 5.1, "X");
        near(trace.at(start + t, "axis2_pos"), y, 5.1, "Y");
    }
}

#[test]
fn pvt_continuous() {
    let Some((text, trace)) = traced("pvt_continuous", &[], &[]) else { return };
    assert_eq!(text, "4000 ms\n3000 ms\nX 30000.0, Y 20000.0\n");
    let start = trace.start("axis1");
    near(trace.start("axis2") - start, 1000.0, 0.26, "Y's delay");
    // Both are at 10 pulse/ms in between, and arrive together.
    for t in [1500.0, 2500.0] {
        near(trace.at(start + t, "axis1_vel"), 10.0, 1e-6, "X");
    }
    near(trace.at(start + 2500.0, "axis2_vel"), 10.0, 1e-6, "Y");
    assert!(trace.at(start + 3999.0, "axis1_pos") < 30_000.0 && trace.at(start + 3999.0, "axis2_pos") < 20_000.0);
    near(trace.at(start + 4001.0, "axis1_pos"), 30_000.0, 1e-3, "X");
    near(trace.at(start + 4001.0, "axis2_pos"), 20_000.0, 1e-3, "Y");
}

/// Gate, power and carrier of the first laser while it is on.
fn lit(trace: &Trace) -> (f64, f64, f64) {
    let row = trace.column("laser0_gate").iter().position(|gate| *gate == 1.0).expect("the laser is on once") + 20;
    let value = |name: &str| trace.column(name)[row];
    (value("laser0_gate"), value("laser0_power"), value("laser0_freq_khz"))
}

#[test]
fn laser_powers() {
    for (family, word) in [("gus", "g"), ("lsr", "l")] {
        let run = |name| traced(name, &[("BEAMTICK_FAMILY", family)], &[word]);
        let Some((text, trace)) = run("laser_duty") else { return };
        assert_eq!(text, "25.00 %\n", "{family}");
        assert_eq!(lit(&trace), (1.0, 25.0, 10.0), "{family}");
        let (text, trace) = run("laser_frequency").unwrap();
        assert_eq!(text, "20.00 kHz\n", "{family}");
        assert_eq!(lit(&trace), (1.0, 20.0, 20.0), "{family}");
        let (text, trace) = run("laser_analog").unwrap();
        assert_eq!(text, "2.50 V\n", "{family}");
        let (gate, power, _) = lit(&trace);
        assert_eq!((gate, power), (1.0, 2.5), "{family}");
        assert_eq!(trace.last("laser0_gate"), 0.0, "off at the end");
    }
}

/// Gate and power of the first laser when X comes by 75000 pulses, on the way out and back.
fn powers(trace: &Trace) -> [(f64, f64); 2] {
    let x = trace.column("axis1_pos");
    let out = x.iter().position(|x| *x >= 75_000.0).expect("the way out");
    let back = x.iter().rposition(|x| *x >= 75_000.0).expect("the way back");
    [out, back].map(|row| (trace.column("laser0_gate")[row], trace.column("laser0_power")[row]))
}

#[test]
fn laser_along_a_path() {
    // What the two laws of SPEC 2 and the bounds of SPEC 6 give at 50 pulse/ms, 75000 pulses away
    // (the way back is at y = 2500).
    let cases = [
        ("laser_path_power", "gus", [50.0, 30.0], 1e-6),
        ("laser_path_power", "lsr", [50.0, 30.0], 1e-6),
        ("laser_path_follow", "gus", [15.0, 15.0], 1e-3),
        // The encoders' speed comes in whole pulses a tick.
        ("laser_path_follow", "lsr", [15.0, 15.0], 0.5),
        ("laser_path_distance", "gus", [12.5, 12.75], 0.01),
        ("laser_path_distance", "lsr", [10.0, 10.0], 1e-6),
    ];
    for (name, family, wanted, within) in cases {
        let Some((text, trace)) = traced(name, &[("BEAMTICK_FAMILY", family)], &[&family[..1]]) else { return };
        assert_eq!(text, "2 segments\n", "{name} {family}");
        for ((gate, power), wanted) in powers(&trace).into_iter().zip(wanted) {
            assert_eq!(gate, 1.0, "{name} {family}");
            near(power, wanted, within, &format!("{name} {family}"));
        }
        let fastest = trace.column("crd1_vel").iter().copied().fold(0.0, f64::max);
        near(fastest, 50.0, 1e-3, "speed along the path");
        assert_eq!(trace.last("laser0_gate"), 0.0, "{name} {family}: dark at the end");
        assert_eq!((trace.last("axis1_pos"), trace.last("axis2_pos")), (0.0, 10_000.0), "{name} {family}");
    }
}

/// Every example of the folder has a test here.
#[test]
fn no_example_is_left_out() {
    let tested = include_str!("programs.rs");
    for file in std::fs::read_dir(root().join("examples/c")).unwrap().flatten() {
        let path: PathBuf = file.path();
        if path.extension().is_some_and(|extension| extension == "cpp") {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            assert!(tested.contains(&format!("\"{name}\"")), "{name}");
        }
    }
}

/// In real time the same program does the same.
#[test]
fn real_time_and_as_fast_as_it_can_agree() {
    let source = root().join("examples/c/pt_static.cpp");
    let Some(built) = build_file(Language::Cpp, "pt_static", &source, &[]) else { return };
    let text = output(&built, &[("BEAMTICK_LINK", "virtual:20")]);
    assert!(text.ends_with("at 4096.0 with 0.00 pulse/ms\n"), "{text}");
}

/// A gear of both kinds of masters, counts of edges, an output for a time.
#[test]
fn an_axis_goes_in_gear_with_another() {
    let source = root().join("host/gts/tests/programs/gear.cpp");
    let Some(built) = build_file(Language::Cpp, "gear", &source, &["-Wpedantic"]) else { return };
    for link in ["virtual:max", "virtual:20"] {
        assert_eq!(output(&built, &[("BEAMTICK_LINK", link)]), "all checks passed\n", "{link}");
    }
}

/// Automatic homing by home switch, limits and index, what it ends with, and its errors.
#[test]
fn homing_ends_at_its_offset() {
    let source = root().join("host/gts/tests/programs/homing.cpp");
    let Some(built) = build_file(Language::Cpp, "homing", &source, &["-Wpedantic"]) else { return };
    assert_eq!(output(&built, &[("BEAMTICK_LINK", "virtual:max")]), "all checks passed\n");
    for link in ["virtual:max", "virtual:20"] {
        let text = toolchain::output_of(toolchain::command(&built, &[("BEAMTICK_LINK", link)]).arg("alone"));
        assert_eq!(text, "all checks passed\n", "{link}");
    }
    let text = toolchain::output_of(toolchain::command(&built, &[("BEAMTICK_LINK", "virtual:max")]).arg("index"));
    assert_eq!(text, "all checks passed\n");
}
