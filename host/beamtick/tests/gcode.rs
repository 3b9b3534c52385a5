//! G-code in the virtual controller, against an exact model: where it ends, where it has light, and
//! its power.
mod judge;
#[path = "gcode/model.rs"]
mod model;
#[path = "gcode/programs.rs"]
mod programs;

use judge::{Row, beamtick, off, rows};
use model::{Axis, Model, decimal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::fs;

/// Steps a mm, direction, home of X, Y, Z.
type Axes = [(&'static str, i32, &'static str); 3];

const MACHINES: [Axes; 3] = [
    [("100", 1, "0"), ("100", 1, "0"), ("400", 1, "0")],
    [("80", -1, "12.5"), ("80", 1, "-3.005"), ("80", -1, "0.1")],
    [("80.5", 1, "0"), ("126.666666667", -1, "7"), ("200", 1, "-1")],
];
/// Lines of a long program: more than are compiled at a time.
const LONG_PROGRAM_LINES: u32 = 30_000;
/// Of all axes, mm/min.
const RATE_MM_PER_MIN: f64 = 30_000.0;

/// The usual powers of the laser.
const FULL: &str = "power = [0, 80]\n";

fn machine(axes: &Axes, family: &str, more: &str) -> String {
    let mut text = format!("family = \"{family}\"\n");
    for (place, (letter, (steps, direction, home))) in ["X", "Y", "Z"].iter().zip(axes).enumerate() {
        let (letter, invert) = (letter.to_lowercase(), *direction < 0);
        text += &format!(
            "[axes.{letter}]\nnumber = {}\nsteps_per_mm = {steps}\ninvert = {invert}\ntravel = [-9000, 9000]\n\
             max_rate = {RATE_MM_PER_MIN}\nacceleration = 4000\nhome = {home}\n",
            [2, 1, 5][place]
        );
    }
    text + "[laser]\nchannel = 0\nmode = \"duty\"\ncarrier_khz = 10\ns_max = 1000\n" + more
}

fn model(axes: &Axes) -> Model {
    let axis = |(steps, direction, home): &(&str, i32, &str)| {
        let sign = decimal(&direction.to_string());
        Axis { steps: decimal(steps) * sign, home: decimal(home) }
    };
    Model::new(axes.iter().map(axis).collect())
}

/// Changes of the light: where, and to what.
fn changes(model: &Model) -> Vec<([f64; 3], bool)> {
    let (mut lit, mut found) = (false, Vec::new());
    let mut last = None;
    for piece in &model.pieces {
        if piece.lit != lit {
            lit = piece.lit;
            found.push((piece.points[0], lit));
        }
        last = piece.points.last();
    }
    if lit {
        found.push((*last.unwrap(), false));
    }
    found
}

/// What differs between a trace and the model.
fn differs(model: &Model, rows: &[Row]) -> Result<(), String> {
    let zero = [0, 1, 2].map(|axis: usize| model.axes[axis].pulse(&model.axes[axis].home) as f64);
    let steps = [0, 1, 2].map(|axis: usize| num_traits::ToPrimitive::to_f64(&model.axes[axis].steps).unwrap());
    let pulses = |mm: [f64; 3]| [0, 1, 2].map(|axis| mm[axis] * steps[axis] - zero[axis]);
    let end = model.pulses();
    let at = rows.last().unwrap().at;
    for axis in 0..3 {
        if at[axis] != end[axis] as f64 - zero[axis] {
            return Err(format!("it ends at {at:?} and not at {end:?} less {zero:?}"));
        }
    }
    // In a tick an axis goes no farther than this, in pulses; what is rounded comes to it.
    let far = steps.map(|steps| RATE_MM_PER_MIN / 60_000.0 * 0.25 * steps.abs() * 2.0 + 2.0);
    let expected = changes(model);
    let mut found = rows.windows(2).filter(|pair| pair[0].lit != pair[1].lit);
    for (point, lit) in &expected {
        let Some(pair) = found.next() else { return Err(format!("there is no change of light at {point:?}")) };
        let point = pulses(*point);
        let near = (0..3).all(|axis| (pair[0].at[axis] - point[axis]).abs() <= far[axis]);
        if !near || pair[1].lit != *lit {
            return Err(format!("light becomes {} at {:?}, not {lit} at {point:?}", pair[1].lit, pair[0].at));
        }
    }
    if let Some(pair) = found.next() {
        return Err(format!("light becomes {} at {:?}, which no mark says", pair[1].lit, pair[0].at));
    }
    // What is lit lies on marks: within a pulse, the tolerance of curves, and what the model's
    // chords leave out.
    let marks: Vec<Vec<[f64; 3]>> =
        model.pieces.iter().filter(|piece| piece.lit).map(|piece| piece.points.clone()).collect();
    let lines = |points: &Vec<[f64; 3]>| points.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>();
    let mut lines: Vec<[[f64; 3]; 2]> = marks.iter().flat_map(lines).collect();
    lines.extend(marks.iter().filter(|points| points.len() == 1).map(|points| [points[0], points[0]]));
    let mm = |at: [f64; 3]| [0, 1, 2].map(|axis| (at[axis] + zero[axis]) / steps[axis]);
    for pair in rows.windows(2).step_by(16).filter(|pair| pair[0].lit && pair[1].lit) {
        let point = mm(pair[0].at);
        let least = lines.iter().map(|line| off(point, *line)).fold(f64::INFINITY, f64::min);
        if least > 0.03 {
            return Err(format!("it is lit at {point:?} mm, {least} mm beside all marks"));
        }
    }
    Ok(())
}

#[test]
fn a_thousand_programs_are_the_models() {
    let count: u64 = 1000;
    let work = |part: u64| {
        let folder = tempfile::tempdir().unwrap();
        let mut marks = 0;
        for seed in (part..count).step_by(2) {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
            let axes = &MACHINES[seed as usize % 3];
            let family = ["gus", "lsr"][seed as usize / 3 % 2];
            let program = programs::program(&mut random);
            let mut model = model(axes);
            programs::run(&program, &mut model);
            fs::write(folder.path().join("p.nc"), &program.text).unwrap();
            fs::write(
                folder.path().join("m.toml"),
                machine(axes, family, &format!("{FULL}[outputs]\nmist = 1\nflood = 2\n")),
            )
            .unwrap();
            let words = ["sim", "p.nc", "--machine", "m.toml", "--pass-stops", "--trace", "t.csv", "--strict"];
            let (said, code) = beamtick(folder.path(), &words);
            assert_eq!(code, 0, "seed {seed}: {said}\n{}", program.text);
            assert!(said.contains("no late entries"), "seed {seed}: {said}");
            if let Err(why) = differs(&model, &rows(&folder.path().join("t.csv"))) {
                panic!("seed {seed}: {why}\n{}", program.text);
            }
            marks += changes(&model).len();
        }
        marks
    };
    let marks: usize = std::thread::scope(|scope| {
        let parts = [0, 1].map(|part| scope.spawn(move || work(part)));
        parts.into_iter().map(|part| part.join().unwrap()).sum()
    });
    assert!(marks > 4000, "only {marks} changes of light were seen");
}

/// M4: power per mm is S over F everywhere, through sharp and blunt corners and arcs, also where
/// the feed is not reached.
#[test]
fn power_per_mm_is_even_through_corners() {
    let folder = tempfile::tempdir().unwrap();
    let program =
        "G21 G90 F6000 M4 S500\nG1 X20\nY20\nX0 Y5\nX-10 Y5.5\nG2 X-20 Y15.5 I0 J10\nG1 X-19.5\nX-20 Y15\nX0 Y0\nM2\n";
    fs::write(folder.path().join("p.nc"), program).unwrap();
    for family in ["gus", "lsr"] {
        let axes: Axes = [("100", 1, "0"), ("100", -1, "0"), ("400", 1, "0")];
        fs::write(folder.path().join("m.toml"), machine(&axes, family, FULL)).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "p.nc", "--machine", "m.toml", "--trace", "t.csv"]);
        assert_eq!(code, 0, "{said}");
        let rows = rows(&folder.path().join("t.csv"));
        // 40 % at 100 mm/s, which are 10 pulse/ms.
        let (per_pulse, mut sum, mut seen) = (4.0, 0.0, [0; 2]);
        for pair in rows.windows(2) {
            sum += pair[0].power * 0.25;
            let [a, b] = [pair[0].at, pair[1].at];
            let way = (a[0] - b[0]).hypot(a[1] - b[1]);
            // A tick with a corner in it is cut short here, and counted in the sum.
            let steady = (pair[0].vel - pair[1].vel).abs() < 0.2 && way > 0.2;
            let bent = (way - (pair[0].vel + pair[1].vel) / 2.0 * 0.25).abs() > 2e-4 * way;
            if steady && !bent {
                assert!(
                    (pair[0].power * 0.25 / way / per_pulse - 1.0).abs() < 1e-3,
                    "{family}: {} % over {way}",
                    pair[0].power
                );
                seen[usize::from(pair[0].vel < 9.0)] += 1;
            }
        }
        assert!(seen[0] > 500 && seen[1] > 100, "{seen:?}");
        let mm = 20.0
            + 20.0
            + 20f64.hypot(15.0)
            + 10f64.hypot(0.5)
            + std::f64::consts::PI * 5.0
            + 0.5
            + 0.5f64.hypot(0.5)
            + 20f64.hypot(15.0);
        let expected = mm * 100.0 * per_pulse;
        assert!((sum / expected - 1.0).abs() < 1e-3, "{family}: {sum} and not {expected}");
    }
}

/// M3: the same power whatever the speed is, also at standstill in a dwell.
#[test]
fn m3_is_constant_power() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(&MACHINES[0], "gus", "power = [8, 80]\n")).unwrap();
    fs::write(folder.path().join("p.nc"), "G1 F6000 M3 S500\nX10\nG4 P0.1\nY10\nG0 X0\nG4 P0.1\nM2\n").unwrap();
    let (said, code) = beamtick(folder.path(), &["sim", "p.nc", "--machine", "m.toml", "--trace", "t.csv"]);
    assert_eq!(code, 0, "{said}");
    let rows = rows(&folder.path().join("t.csv"));
    // 8 % and half of what is left to 80 %.
    assert!(rows.iter().all(|row| if row.lit { row.power == 44.0 } else { row.power == 0.0 }));
    let standing = rows.iter().filter(|row| row.lit && row.vel == 0.0).count();
    assert!((390..=420).contains(&standing), "{standing} ticks of 250 us");
}

#[test]
fn what_is_wrong_has_line_and_reason_and_nothing_moves() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(&MACHINES[0], "gus", FULL)).unwrap();
    let flat = machine(&MACHINES[0], "gus", FULL).replace("[axes.z]", "[axes.q]");
    let flat = flat.split("[axes.q]").next().unwrap().to_owned();
    fs::write(folder.path().join("flat.toml"), flat).unwrap();
    let cases: &[(&str, &str)] = &[
        ("N-1 G1 X1 F100", "p.nc:2: a line number is 0 or above"),
        ("T-1 G1 X1 F100", "p.nc:2: a tool number is 0 or above"),
        ("G1.5 X1 F100", "p.nc:2: G1.5 is not supported: G1 has no decimals"),
        ("G2 R4 F100", "p.nc:2: an arc by R needs axis words"),
        ("G91.2", "p.nc:2: G91.2 is not supported"),
        ("G1 XNAN F100", "p.nc:2: `XNANF100`: a letter must have a number"),
        ("G1 X1e3 F100", "p.nc:2: the word E is not supported"),
        ("G1 X1 X2 F100", "p.nc:2: X is twice in a line"),
        ("G0 G1 X1 F100", "p.nc:2: two words of one modal group (motion)"),
        ("M3 M5", "p.nc:2: two words of one modal group (spindle)"),
        ("G1 X1", "p.nc:2: no feed rate was given"),
        ("G93\nG1 X1 F3\nX2", "p.nc:4: in inverse time (G93) each"),
        ("G2 X10 Y0 I4 F100", "p.nc:2: the radius does not fit: it is 4.0000 mm at the start and 6.0000 mm at the end"),
        ("G2 X10 Y0 I5.0026 F100", "p.nc:2: the radius does not fit"),
        ("G2 X10 R4 F100", "p.nc:2: the radius does not fit: R is 4.0000 mm"),
        ("G2 X0 Y0 R4 F100", "p.nc:2: an arc by R needs an end"),
        ("G2 X1 Y1 F100", "p.nc:2: an arc needs R or a centre"),
        ("G2 X2 I1 K1 F100", "p.nc:2: K is no centre"),
        ("G1 X1 I1 F100", "p.nc:2: I, J, K and R belong to G2 and G3"),
        ("G0 X9000.001", "p.nc:2: X goes to 9000.001 mm in the machine; its travel is -9000 to 9000 mm"),
        ("G0 X8999\nG2 X8999 I3 F100", "p.nc:3: X goes to 9005 mm in the machine"),
        ("G80 X1", "p.nc:2: axis words after G80"),
        ("G28 G1 X1 F1", "p.nc:2: two commands of this line use its axis words"),
        ("G53 X1 G2 I1", "p.nc:2: G53 goes with G0 or G1"),
        ("G4", "p.nc:2: G4 needs P"),
        ("G4 P-1", "p.nc:2: G4 P is 0 to 86400 seconds"),
        ("G10 L2 P7 X1", "p.nc:2: G10 P is 0"),
        ("G10 L3 P1 X1", "p.nc:2: G10 is supported with L2 and L20 only"),
        ("G41 D1", "p.nc:2: G41 is not supported"),
        ("G33 X1 K1", "p.nc:2: G33 is not supported"),
        ("M6 T1", "p.nc:2: M6 is not supported"),
        ("G1 A5 F1", "p.nc:2: the word A is not supported"),
        ("#1 = 5", "p.nc:2: variables and expressions are not supported"),
        ("O100 sub", "p.nc:2: `O100SUB`: O words are not supported"),
        ("M0", "p.nc:2: M0 waits for an operator"),
        ("G1 X1 (open", "p.nc:2: a comment is not closed"),
        ("G1 X1 F-5", "p.nc:2: F is below 0"),
        ("M3 S-5", "p.nc:2: S is below 0"),
        ("P5", "p.nc:2: P belongs to no word"),
        ("\u{0}\u{1}\u{7f}", "the file may be no text"),
    ];
    for (line, says) in cases {
        fs::write(folder.path().join("p.nc"), format!("G21\n{line}\nG0 X5\n")).unwrap();
        let words = ["sim", "p.nc", "--machine", "m.toml", "--trace", "t.csv"];
        let (said, code) = beamtick(folder.path(), &words);
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{line}: {code} {said}");
        assert!(!folder.path().join("t.csv").exists() && !folder.path().join("t.csv.partial").exists(), "{line}");
    }
    let wide = |letters: &str, big: bool| -> Vec<u8> {
        letters.encode_utf16().flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect()
    };
    for (bytes, says) in [
        (wide("\u{feff}G21\nG0 X5\n", false), "p.nc: the file is UTF-16 text; save it as UTF-8"),
        (wide("\u{feff}G21\nG0 X5\n", true), "p.nc: the file is UTF-16 text; save it as UTF-8"),
        (wide("G21\nG0 X5\n", false), "p.nc: the file is UTF-16 text; save it as UTF-8"),
        (wide("G21\nG0 X5\n", true), "p.nc: the file is UTF-16 text; save it as UTF-8"),
        (b"G21\nG0 X5 \xe9\n".to_vec(), "p.nc:2: what is not UTF-8 text is no G-code; save the file as UTF-8"),
        ("G21\nG0 X5 \u{e9}\n".into(), "p.nc:2: `\u{e9}` is no G-code"),
    ] {
        fs::write(folder.path().join("p.nc"), bytes).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "p.nc", "--machine", "m.toml", "--trace", "t.csv"]);
        assert!(code == 2 && said.contains(says) && said.contains("nothing was run"), "{says}: {code} {said}");
        assert!(!folder.path().join("t.csv").exists(), "{says}");
    }
    for (line, says) in [("G0 Z1", "p.nc:2: Z is moved"), ("G18 G2 X1 I1 F100", "p.nc:2: an arc of this plane moves Z")]
    {
        fs::write(folder.path().join("p.nc"), format!("G21\n{line}\n")).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "p.nc", "--machine", "flat.toml"]);
        assert!(code == 2 && said.contains(says), "{line}: {said}");
    }
    fs::create_dir(folder.path().join("d.nc")).unwrap();
    fs::write(folder.path().join("j.gts"), "GT_AxisOn(1);\n").unwrap();
    for (words, says) in [
        (&["sim", "d.nc", "--machine", "m.toml"][..], "d.nc: the program cannot be read"),
        (&["sim", "none.nc", "--machine", "m.toml"], "none.nc: the program cannot be read"),
        (&["sim", "p.nc"], "p.nc: G-code and drawings need --machine FILE"),
        (&["sim", "p.nc", "--machine", "none.toml"], "none.toml: the machine file cannot be read"),
        (
            &["sim", "j.gts", "--machine", "m.toml"],
            "j.gts: --machine, --laser, --layer, --at and --pass-stops are for G-code and drawings",
        ),
        (&["run", "j.gts"], "--link is missing"),
        (&["import", "p.nc", "--machine", "m.toml", "-o", "m.toml"], "would overwrite a file"),
        (&["import", "j.gts", "--machine", "m.toml", "-o", "o.gts"], "G-code is named .nc"),
    ] {
        fs::write(folder.path().join("p.nc"), "G0 X1\n").unwrap();
        let (said, code) = beamtick(folder.path(), words);
        assert!(code == 2 && said.contains(says), "{words:?}: {said}");
    }
}

/// F is mm/min (or 1/min of a motion) along the path, whatever the axes count a mm; no axis passes
/// its rate.
/// The slowest motion of the controller is 2⁻²⁰ pulse/ms.
/// The controller takes arcs of less than 2³¹ pulses: a flatter one becomes lines.
#[test]
fn an_arc_of_any_radius_runs() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("m.toml", &machine(&MACHINES[0], "gus", FULL));
    for radius in ["10000000", "10737418", "10737419", "21474837", "999999999"] {
        write("a.nc", &format!("M3 S500 F1000\nG1 X100 Y100\nG2 X110 Y110 R{radius}\nG3 X100 Y110 R{radius}\nM2\n"));
        let (said, code) = beamtick(folder.path(), &["sim", "a.nc", "--machine", "m.toml"]);
        assert_eq!(code, 0, "{radius}: {said}");
        assert!(said.contains("X 100.000 mm") && said.contains("Y 110.000 mm"), "{radius}: {said}");
    }
}

#[test]
fn what_is_slower_than_the_controller_moves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("m.toml", &machine(&[("1", 1, "0"), ("1", 1, "0"), ("1", 1, "0")], "gus", FULL));
    let page = "<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm'><path d='M0 0h9' stroke='red'/></svg>";
    write("d.svg", page);
    // 60,000 · 2⁻²⁰ mm/min are 0.0572.
    for (speed, taken) in [("0.0573", true), ("0.0572", false), ("0.01", false)] {
        write("p.nc", &format!("M3 S500\nG1 X5 F6000\nG1 X6 F{speed}"));
        let layer = format!("power=10,speed={speed}");
        let says = format!("{speed} mm/min are asked for; the slowest motion is 0.057220 mm/min, at 1 pulses a mm");
        for (words, place) in [(&["p.nc"][..], "p.nc:3: "), (&["d.svg", "--layer", &layer], "d.svg: layer ")] {
            let (said, code) = beamtick(folder.path(), &[&["check"], words, &["--machine", "m.toml"]].concat());
            assert_eq!(code, if taken { 0 } else { 2 }, "{words:?}: {said}");
            assert!(taken || said.contains(place) && said.contains(&says), "{words:?}: {said}");
        }
    }
    // A motion without length has no speed.
    write("p.nc", "G93 G1 X0 F0.001\nG94 G1 X5 F60");
    let (said, code) = beamtick(folder.path(), &["check", "p.nc", "--machine", "m.toml"]);
    assert_eq!(code, 0, "{said}");
}

#[test]
fn light_that_is_weaker_than_asked_is_noted() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("m.toml", &machine(&MACHINES[0], "gus", FULL));
    // The axes go at 30,000 mm/min: along one of them, and 3 : 4 between two of them.
    for (program, says) in [
        ("M4 S500\nG1 X-30 F30000", None),
        ("M4 S500\nG1 X-30 F30001", Some("p.nc:2: note: 30001 mm/min are asked for, and the machine reaches 30000")),
        ("G91\nM4 S500\nG1 X-30 Y-40 F37500\nX-30 F45000", Some("p.nc:4: note: 45000 mm/min are asked for")),
        (
            "G91\nM4 S500\nG1 X-30 Y-40 F37501",
            Some("p.nc:3: note: 37501 mm/min are asked for, and the machine reaches 37500"),
        ),
        ("M3 S500\nG1 X-30 F45000", None),
        ("M4 S0\nG1 X-30 F45000", None),
    ] {
        write("p.nc", program);
        let (said, code) = beamtick(folder.path(), &["check", "p.nc", "--machine", "m.toml"]);
        assert!(code == 0 && said.contains("are asked for") == says.is_some(), "{program}: {said}");
        assert!(says.is_none_or(|says| said.contains(says)), "{program}: {said}");
    }
    let page = "<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm'><path d='M0 0h9' stroke='red'/></svg>";
    write("d.svg", page);
    for (speed, noted) in [("30000", false), ("30001", true)] {
        let layer = format!("power=20,speed={speed}");
        let words = ["check", "d.svg", "--machine", "m.toml", "--layer", &layer];
        let (said, code) = beamtick(folder.path(), &words);
        assert!(code == 0 && said.contains("the path of line 1: 30001 mm/min are asked for") == noted, "{said}");
    }
}

#[test]
fn speeds_are_in_mm() {
    let folder = tempfile::tempdir().unwrap();
    let axes = &MACHINES[2];
    fs::write(folder.path().join("m.toml"), machine(axes, "gus", FULL)).unwrap();
    // From home, (0, 7, -1); the fastest in mm/s.
    for (program, expected) in [
        ("G91 G1 X300 Y400 F6000", 100.0),
        ("G91 G1 X300 Z-300 F9000", 150.0),
        ("G91 G93 G1 X300 Y400 F12", 100.0),
        ("G91 G93 G2 X200 I100 F30", std::f64::consts::PI * 100.0 * 30.0 / 60.0),
        ("G91 G0 X300 Y400", 625.0),
        ("G91 G1 X300 Y400 F60000", 625.0),
        ("G91 G20 G1 X10 F120", 50.8),
    ] {
        fs::write(folder.path().join("p.nc"), format!("M3 S5\n{program}\n")).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "p.nc", "--machine", "m.toml", "--trace", "t.csv"]);
        assert_eq!(code, 0, "{said}");
        let rows = rows(&folder.path().join("t.csv"));
        let steps = [80.5, 126.666666667, 200.0];
        let mut most = 0.0f64;
        for pair in rows.windows(41) {
            let way = [0, 1, 2].map(|axis: usize| (pair[40].at[axis] - pair[0].at[axis]) / steps[axis]);
            most = most.max((way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt() * 100.0);
        }
        assert!((most / expected - 1.0).abs() < 1e-3, "{program}: {most} and not {expected} mm/s");
    }
}

/// G92.1 forgets the offset, G92.2 keeps it for G92.3.
#[test]
fn g92_is_kept_or_forgotten() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(&MACHINES[0], "gus", FULL)).unwrap();
    for (words, end) in [("G92.1\nG92.3", 1000), ("G92.2\nG92.3", 500), ("G92.2", 1000), ("", 500)] {
        fs::write(folder.path().join("p.nc"), format!("G92 X5\n{words}\nG0 X10\n")).unwrap();
        let (said, code) = beamtick(folder.path(), &["sim", "p.nc", "--machine", "m.toml"]);
        assert!(code == 0 && said.contains(&format!("axis 2: planned {end}.000000")), "{words}: {said}");
    }
}

#[test]
fn the_extent_is_in_mm() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(&MACHINES[1], "gus", FULL)).unwrap();
    fs::write(folder.path().join("p.nc"), "G0 X20 Y0 Z0\nM4 S9 F600\nG3 X10 Y10 I-10\nG0 X-1\n").unwrap();
    let (said, code) = beamtick(folder.path(), &["check", "p.nc", "--machine", "m.toml"]);
    assert_eq!(code, 0, "{said}");
    let marks = "marks of 15.708 mm, X 10.000 to 20.000, Y 0.000 to 10.000, Z 0.000 to 0.000 mm";
    assert!(
        said.contains("X -1.000 to 20.000, Y -3.005 to 10.000, Z 0.000 to 0.100 mm") && said.contains(marks),
        "{said}"
    );
}

/// A program that is longer than every FIFO runs as one motion.
#[test]
fn a_long_program_runs_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(&MACHINES[0], "gus", FULL)).unwrap();
    let mut program = "G21 G91 F20000 M4 S0\n".to_owned();
    for k in 0..LONG_PROGRAM_LINES {
        program += &format!("G1 X0.2 Y{} S{}\n", if k % 2 == 0 { "0.01" } else { "-0.01" }, 100 + k % 7 * 100);
    }
    fs::write(folder.path().join("p.nc"), program).unwrap();
    let (said, code) = beamtick(folder.path(), &["sim", "p.nc", "--machine", "m.toml", "--strict"]);
    assert_eq!(code, 0, "{said}");
    assert!(
        said.contains(&format!("{LONG_PROGRAM_LINES} segments"))
            && said.contains(&format!("axis 2: planned {}.000000", LONG_PROGRAM_LINES * 20)),
        "{said}"
    );
    assert!(said.contains("no late entries") && !said.contains("underrun"), "{said}");
}

#[test]
fn the_commands_of_the_page_work() {
    let folder = tempfile::tempdir().unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    fs::create_dir(folder.path().join("examples")).unwrap();
    for file in ["examples/machine.toml", "examples/square.nc"] {
        fs::copy(format!("{root}/{file}"), folder.path().join(file)).unwrap();
    }
    let page = fs::read_to_string(format!("{root}/docs/gcode.md")).unwrap();
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("    beamtick ")).collect();
    assert_eq!(commands.len(), 4);
    let mut ends = Vec::new();
    for command in commands {
        let words: Vec<&str> = command.split_whitespace().collect();
        let (said, code) = beamtick(folder.path(), &words);
        assert_eq!(code, 0, "{command}: {said}");
        ends.extend(said.lines().filter(|line| line.contains("light of")).map(str::to_owned));
    }
    assert!(!ends.is_empty(), "no command of the page runs the program");
    assert!(fs::read(folder.path().join("square.png")).unwrap().len() > 5000);
    // The job that was written runs to the same end.
    let (said, code) = beamtick(folder.path(), &["sim", "square.gts"]);
    assert!(code == 0 && ends.iter().all(|end| said.contains(end)), "{ends:?} {said}");
}
