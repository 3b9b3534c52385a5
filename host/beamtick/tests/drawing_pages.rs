//! Plans and pictures of drawings; the commands of docs/drawings.md and docs/first-engraving.md.
mod judge;

use judge::beamtick;
use std::fs;

/// docs/first-engraving.md, from nothing to two pictures.
#[test]
fn the_first_engraving_works() {
    let folder = tempfile::tempdir().unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    fs::create_dir(folder.path().join("examples")).unwrap();
    fs::copy(format!("{root}/examples/badge.svg"), folder.path().join("examples/badge.svg")).unwrap();
    let page = fs::read_to_string(format!("{root}/docs/first-engraving.md")).unwrap();
    let commands: Vec<&str> = page.lines().filter_map(|line| line.trim_start().strip_prefix("beamtick ")).collect();
    let [commands @ .., dark] = commands.as_slice() else { panic!("no commands") };
    assert_eq!(commands.len(), 3);
    let mut said = String::new();
    for command in commands {
        let words: Vec<&str> = command.split_whitespace().collect();
        let (text, code) = beamtick(folder.path(), &words);
        assert_eq!(code, 0, "{command}: {text}");
        said = text;
    }
    assert!(said.contains("no late entries") && said.contains("axis 1: planned 0.000000"), "{said}");
    for picture in ["plan.png", "engraving.png"] {
        assert!(fs::read(folder.path().join(picture)).unwrap().len() > 5000, "{picture}");
    }
    // In the dark.
    let (said, code) = beamtick(folder.path(), &dark.split_whitespace().collect::<Vec<_>>());
    assert!(code == 0 && said.contains("no late entries") && said.contains("light of 0.000 ms"), "{said}");
    // What the page says of a place outside the travel, and of layers in the machine file.
    let words: Vec<&str> = commands[1].split_whitespace().chain(["--at", "250,0"]).collect();
    let (said, code) = beamtick(folder.path(), &words);
    assert!(code == 2 && said.contains("the travel is 0 to 300 mm"), "{said}");
    let machine = fs::read_to_string(folder.path().join("machine.toml")).unwrap();
    let from = machine.find("# [[layers]]").unwrap();
    let layers = machine[from..].replace("# [[", "[[").replace("\n# ", "\n").replace("colour = \"#ff0000\"", "");
    fs::write(folder.path().join("machine.toml"), machine[..from].to_owned() + &layers).unwrap();
    let (said, code) = beamtick(folder.path(), &["check", "examples/badge.svg", "--machine", "machine.toml"]);
    assert_eq!(code, 0, "{said}");
}

#[test]
fn the_commands_of_the_page_work() {
    let folder = tempfile::tempdir().unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    fs::create_dir(folder.path().join("examples")).unwrap();
    for file in ["examples/machine.toml", "examples/badge.svg"] {
        fs::copy(format!("{root}/{file}"), folder.path().join(file)).unwrap();
    }
    let page = fs::read_to_string(format!("{root}/docs/drawings.md")).unwrap();
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("    beamtick ")).collect();
    assert_eq!(commands.len(), 4);
    for command in commands {
        let words: Vec<&str> = command.split_whitespace().collect();
        let (said, code) = beamtick(folder.path(), &words);
        assert_eq!(code, 0, "{command}: {said}");
    }
    assert!(fs::read(folder.path().join("badge.png")).unwrap().len() > 5000);
    // The job that was written is the one that runs.
    let light = |words: &[&str]| -> f64 {
        let (said, code) = beamtick(folder.path(), words);
        assert_eq!(code, 0, "{said}");
        said.split("light of ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
    };
    let drawing = light(&["sim", "examples/badge.svg", "--machine", "examples/machine.toml"]);
    assert!((light(&["sim", "badge.gts"]) - drawing).abs() < 1.0 && drawing > 70_000.0, "{drawing}");
}

/// The time that is said before is the time that it takes; a picture is drawn of what leaves the
/// travel, too.
#[test]
fn a_plan_says_the_time_and_draws_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    for file in ["examples/machine.toml", "examples/badge.svg", "examples/square.nc"] {
        fs::copy(format!("{root}/{file}"), folder.path().join(file.split('/').next_back().unwrap())).unwrap();
    }
    let figure = |said: &str, after: &str| -> f64 {
        said.split(after).nth(1).unwrap().split_whitespace().next().unwrap().parse().unwrap()
    };
    for file in ["badge.svg", "square.nc"] {
        let (said, code) = beamtick(folder.path(), &["check", file, "--machine", "machine.toml", "--plot", "p.png"]);
        assert!(code == 0 && !said.contains("GT_"), "{said}");
        let planned = figure(&said, "about ");
        assert!(fs::read(folder.path().join("p.png")).unwrap().len() > 5000);
        let (said, code) = beamtick(folder.path(), &["sim", file, "--machine", "machine.toml"]);
        assert_eq!(code, 0, "{said}");
        let took = figure(&said, "script clock ") / 1000.0;
        assert!((planned - took).abs() < 0.01 * took + 0.06, "{file}: {planned} s planned, {took} s taken");
    }
    let svg = |words: &[&str]| {
        let (said, code) = beamtick(folder.path(), words);
        (said, code, fs::read_to_string(folder.path().join("p.svg")).unwrap_or_default())
    };
    let words = ["check", "badge.svg", "--machine", "machine.toml", "--plot", "p.svg"];
    let (_, code, inside) = svg(&words);
    // The colours of marks, of the dark, of what leaves the travel.
    let has = |text: &str| ["#C42F6B", "#9AA4AE", "#F28C00"].map(|colour| text.contains(colour));
    assert!(code == 0 && has(&inside) == [true, true, false], "{:?}", has(&inside));
    let (said, code, outside) = svg(&[&words[..], &["--at", "150,170"]].concat());
    assert!(code == 2 && said.contains("16 shapes leave the travel"), "{said}");
    assert!(has(&outside) == [true, true, true] && outside.contains("outside the travel"), "{:?}", has(&outside));
    // A program, up to where it leaves the travel.
    fs::write(folder.path().join("far.nc"), "G0 X10\nM4 S500\nG1 X300 F600\n").unwrap();
    let (said, code, outside) = svg(&["check", "far.nc", "--machine", "machine.toml", "--plot", "p.svg"]);
    assert!(code == 2 && said.contains("far.nc:3: X goes to 300 mm"), "{said}");
    assert_eq!(has(&outside), [true, true, true]);
    for (words, says) in [
        (&["check", "badge.svg", "--machine", "machine.toml", "--plot", "badge.svg"][..], "would overwrite a file"),
        (
            &["check", "badge.svg", "--machine", "machine.toml", "--plot", "p.txt"],
            "a plot's name ends with .svg or .png",
        ),
        (
            &["import", "badge.svg", "--machine", "machine.toml", "-o", "b.svg", "--plot", "b.svg"],
            "would overwrite a file",
        ),
    ] {
        let (said, code) = beamtick(folder.path(), words);
        assert!(code == 2 && said.contains(says), "{words:?}: {said}");
    }
    // What ran, in mm.
    let words = ["sim", "square.nc", "--machine", "machine.toml", "--plot", "r.svg"];
    let (said, code) = beamtick(folder.path(), &words);
    let drawn = fs::read_to_string(folder.path().join("r.svg")).unwrap();
    assert!(code == 0 && drawn.contains("X position (mm)") && drawn.contains("Y velocity (mm/min)"), "{said}");
    assert!(!drawn.contains("position (pulse)"));
}
