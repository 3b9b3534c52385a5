//! Machines with two lasers: each lights what is its own, and the other one is dark.
mod judge;

use judge::{beamtick, off};
use std::fs;
use std::path::Path;

/// Pulses a mm of X and Y.
const PULSES_PER_MM: f64 = 1000.0;
/// An arc's tolerance, a pulse, and a little, mm.
const NEAR_MM: f64 = 0.004;
/// mm in the row at an end.
const ROW_MM: f64 = 0.03;

fn axes() -> String {
    let axis = |(letter, number): (&str, u8)| {
        format!(
            "[axes.{letter}]\nnumber = {number}\nsteps_per_mm = {PULSES_PER_MM}\ntravel = [-10, 200]\nmax_rate = 15000\n\
             acceleration = 5000\nhome = 0\n"
        )
    };
    [("x", 2), ("y", 1)].map(axis).concat()
}

const LASERS: &str = "[lasers.engrave]\nchannel = 1\nmode = \"duty\"\ncarrier_khz = 10\npower = [0, 60]\ns_max = 1000\n\
                      [lasers.cut]\nchannel = 0\nmode = \"analog\"\npower = [0, 10]\ns_max = 255\non_delay_us = 0\n";

const LAYERS: &str = "[[layers]]\ncolour = \"#0000ff\"\npower = 20\nspeed = 3000\nlight = \"constant\"\npasses = 2\n\
                      [[layers]]\nname = \"out\"\ncolour = \"#f00\"\nlaser = \"cut\"\npower = 8\nspeed = 1200\n\
                      light = \"constant\"\norder = 1\n";

/// The second layer begins where the first one ends.
const DRAWING: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100mm\" height=\"100mm\" viewBox=\"0 0 100 100\">\n\
                       <path id=\"a\" d=\"M10 90H30\" stroke=\"#00f\" fill=\"none\"/>\n\
                       <path id=\"b\" d=\"M30 90V60H60\" stroke=\"#f00\" fill=\"none\"/>\n\
                       <circle cx=\"70\" cy=\"30\" r=\"5\" stroke=\"#f00\" fill=\"none\"/>\n</svg>\n";

/// A row: where it is, mm, and gate and power of both lasers.
struct TwoLasers {
    at: [f64; 3],
    gates: [bool; 2],
    powers: [f64; 2],
}

fn rows(file: &Path) -> Vec<TwoLasers> {
    let text = fs::read_to_string(file).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column =
        |name: &str| names.iter().position(|other| *other == name).unwrap_or_else(|| panic!("{name}: {names:?}"));
    let [x, y] = ["axis2_pos", "axis1_pos"].map(column);
    let (gates, powers) = (["laser0_gate", "laser1_gate"].map(column), ["laser0_power", "laser1_power"].map(column));
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let at = [cells[x] / PULSES_PER_MM, cells[y] / PULSES_PER_MM, 0.0];
        TwoLasers { at, gates: gates.map(|at| cells[at] > 0.5), powers: powers.map(|at| cells[at]) }
    };
    lines.map(row).collect()
}

/// Lines of a shape: a list of points in mm.
fn lines(points: &[[f64; 2]]) -> Vec<[[f64; 3]; 2]> {
    points.windows(2).map(|pair| [[pair[0][0], pair[0][1], 0.0], [pair[1][0], pair[1][1], 0.0]]).collect()
}

fn circle([x, y]: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let at = |part: i32| f64::from(part) / 720.0 * std::f64::consts::TAU;
    (0..=720).map(|part| [x + radius * at(part).cos(), y + radius * at(part).sin()]).collect()
}

/// The laser of this channel is lit along its own marks, with its power, all of their length
/// `passes` times, and nowhere else. Says in how many parts.
fn judged(rows: &[TwoLasers], channel: usize, marks: &[Vec<[[f64; 3]; 2]>], power: f64, passes: f64) -> usize {
    let all: Vec<[[f64; 3]; 2]> = marks.concat();
    let beside = |point: [f64; 3]| all.iter().map(|line| off(point, *line)).fold(f64::INFINITY, f64::min);
    let size = |[a, b]: [[f64; 3]; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let (mut length, mut begun) = (0.0, 0);
    for pair in rows.windows(2) {
        begun += usize::from(!pair[0].gates[channel] && pair[1].gates[channel]);
        if pair[0].gates[channel] && pair[1].gates[channel] {
            assert!(beside(pair[0].at) < NEAR_MM, "laser {channel} at {:?}", pair[0].at);
            assert_eq!(pair[0].powers[channel], power, "laser {channel}");
            length += size([pair[0].at, pair[1].at]);
        } else if !pair[0].gates[channel] {
            assert_eq!(pair[0].powers[channel], 0.0, "laser {channel} at {:?}", pair[0].at);
        }
        assert!(!(pair[0].gates[0] && pair[0].gates[1]), "both are lit at {:?}", pair[0].at);
    }
    let expected: f64 = all.iter().map(|line| size(*line)).sum::<f64>() * passes;
    assert!((length - expected).abs() < 2.0 * ROW_MM * begun as f64, "laser {channel}: {length} mm for {expected} mm");
    begun
}

#[test]
fn each_layer_is_lit_by_its_own_laser_and_the_other_one_is_dark() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("d.svg"), DRAWING).unwrap();
    for family in ["gus", "lsr"] {
        let machine = format!("family = \"{family}\"\n{}{LASERS}{LAYERS}", axes());
        fs::write(folder.path().join("m.toml"), machine).unwrap();
        let sim = ["sim", "d.svg", "--machine", "m.toml", "--trace", "t.csv", "--xy", "xy.svg", "--strict"];
        let (said, code) = beamtick(folder.path(), &sim);
        assert_eq!(code, 0, "{said}");
        // The picture has the light of both: the bar's and that of the other one.
        let picture = fs::read_to_string(folder.path().join("xy.svg")).unwrap();
        assert!(picture.contains("light of laser 0, ") && picture.contains("light of laser 1\n"), "{family}");
        assert!(picture.matches("#0B7D6E").count() > 1, "{family}: a legend without light");
        for part in
            ["laser 0 (cut): analog mode, dark", "laser 1 (engrave): duty mode, dark", "laser engrave 40.000 mm"]
        {
            assert!(said.contains(part), "{family}: {part}: {said}");
        }
        let run = rows(&folder.path().join("t.csv"));
        let blue = [lines(&[[10.0, 10.0], [30.0, 10.0]])];
        let red = [lines(&[[30.0, 10.0], [30.0, 40.0], [60.0, 40.0]]), lines(&circle([70.0, 70.0], 5.0))];
        assert_eq!(judged(&run, 1, &blue, 20.0, 2.0), 2, "{family}");
        assert_eq!(judged(&run, 0, &red, 8.0, 1.0), 2, "{family}");
        // `--laser` is for layers that name none.
        let words = ["check", "d.svg", "--machine", "m.toml", "--laser", "cut"];
        let (said, code) = beamtick(folder.path(), &words);
        assert!(code == 2 && said.contains("layers.power is 20; it is 0 to 10 V (lasers.cut.power)"), "{said}");
        // Unless it has nothing to mark.
        let other = [&words[..], &["--layer", "colour=#00f,power=3,speed=600"]].concat();
        let (said, code) = beamtick(folder.path(), &other);
        assert!(code == 0 && said.contains("laser cut"), "{said}");
        let machine = fs::read_to_string(folder.path().join("m.toml")).unwrap().replace("power = 20", "power = 6");
        fs::write(folder.path().join("m.toml"), machine).unwrap();
        let (said, code) = beamtick(folder.path(), &[&sim[..], &["--laser", "cut"]].concat());
        assert_eq!(code, 0, "{said}");
        let rows = rows(&folder.path().join("t.csv"));
        assert!(rows.iter().all(|row| !row.gates[1]), "{family}: laser 1 stays dark");
        assert!(rows.iter().any(|row| row.gates[0] && row.powers[0] == 6.0), "{family}");
    }
    // The job says it explicitly at both ends, and the plan names the lasers.
    let (said, code) =
        beamtick(folder.path(), &["import", "d.svg", "--machine", "m.toml", "-o", "d.gts", "--plot", "p.svg"]);
    assert_eq!(code, 0, "{said}");
    let job = fs::read_to_string(folder.path().join("d.gts")).unwrap();
    let (begin, path) = job.split_once("GT_LnXY").unwrap();
    let end = path.rsplit_once("GT_LnXY").unwrap().1;
    for channel in [0, 1] {
        assert!(begin.contains(&format!("GT_LaserOff({channel});")), "{begin}");
        assert!(end.contains(&format!("GT_BufLaserOff(1, 0, {channel});")), "{end}");
    }
    let drawn = fs::read_to_string(folder.path().join("p.svg")).unwrap();
    assert!(drawn.contains("marked by cut") && drawn.contains("marked by engrave"));
}

#[test]
fn s_of_a_program_sets_the_laser_that_is_named() {
    let folder = tempfile::tempdir().unwrap();
    // A layer whose power the other laser has not is no matter of a program.
    fs::write(folder.path().join("m.toml"), axes() + LASERS + LAYERS).unwrap();
    fs::write(folder.path().join("p.nc"), "M3 S100 F1200\nG1 X10\nG0 Y5\nG1 X20 S255\nM5\n").unwrap();
    let first = lines(&[[0.0, 0.0], [10.0, 0.0]]);
    let sim = ["sim", "p.nc", "--machine", "m.toml", "--trace", "t.csv", "--strict"];
    for (laser, channel, full) in [(None, 1, 60.0), (Some("engrave"), 1, 60.0), (Some("cut"), 0, 10.0)] {
        let s_max = if channel == 0 { 255.0 } else { 1000.0 };
        let given: Vec<&str> = laser.into_iter().flat_map(|name| ["--laser", name]).collect();
        let (said, code) = beamtick(folder.path(), &[&sim[..], &given].concat());
        assert_eq!(code, 0, "{said}");
        let rows = rows(&folder.path().join("t.csv"));
        assert!(rows.iter().all(|row| !row.gates[1 - channel] && row.powers[1 - channel] == 0.0), "{laser:?}");
        let cut = rows.iter().position(|row| row.at[1] > 1.0).unwrap();
        let power = full / s_max * 100.0;
        let near = |row: &TwoLasers| (row.powers[channel] - power).abs() < 0.001;
        assert!(rows[..cut].iter().filter(|row| row.gates[channel]).all(near), "{laser:?}");
        let first = [first.clone()];
        let exact = rows[..cut].iter().find(|row| row.gates[channel]).unwrap().powers[channel];
        assert_eq!(judged(&rows[..cut], channel, &first, exact, 1.0), 1, "{laser:?}");
    }
    for (words, says) in [
        (&["--laser", "mark"][..], "m.toml: --laser is \"mark\"; lasers are \"engrave\" and \"cut\""),
        (&["--laser", ""], "m.toml: --laser is \"\"; lasers are"),
    ] {
        for command in ["sim", "check", "run"] {
            let (said, code) = beamtick(folder.path(), &[&[command, "p.nc", "--machine", "m.toml"], words].concat());
            assert!(code == 2 && said.contains(says), "{command}: {said}");
        }
        let grbl = [&["grbl", "--machine", "m.toml", "--listen", "127.0.0.1:0"], words].concat();
        let (said, code) = beamtick(folder.path(), &grbl);
        assert!(code == 2 && said.contains(says), "{said}");
    }
    let one = axes() + "[laser]\nchannel = 1\nmode = \"analog\"\npower = [0, 10]\ns_max = 255\n";
    for (machine, says) in [
        (one, "--laser is \"cut\"; the machine file has one laser, [laser], which has no name: leave this out"),
        (axes(), "--laser is \"cut\"; the machine file has no laser"),
    ] {
        fs::write(folder.path().join("m.toml"), machine).unwrap();
        let (said, code) = beamtick(folder.path(), &["check", "p.nc", "--machine", "m.toml", "--laser", "cut"]);
        assert!(code == 2 && said.contains(says), "{said}");
    }
    let (said, code) = beamtick(folder.path(), &["check", "p.nc", "--laser", "cut"]);
    assert!(code == 2 && said.contains("need --machine FILE"), "{said}");
    fs::write(folder.path().join("j.gts"), "Sleep(1);\n").unwrap();
    let (said, code) = beamtick(folder.path(), &["sim", "j.gts", "--laser", "cut"]);
    assert!(code == 2 && said.contains("--laser, --layer, --at and --pass-stops are for G-code"), "{said}");
}
