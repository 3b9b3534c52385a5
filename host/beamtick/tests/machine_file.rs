//! The machine file from the command line: the commands of docs/machine.md, answers, and what is
//! refused.
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// Runs `beamtick` in `folder`: what it prints, and its code.
fn beamtick(folder: &Path, words: &[&str], input: &str) -> (String, i32) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_beamtick"))
        .args(words)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that asks nothing has closed its input.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    let out = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    (said, out.status.code().unwrap())
}

#[test]
fn the_commands_of_the_page_work() {
    let folder = tempfile::tempdir().unwrap();
    let page = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/machine.md")).unwrap();
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("    beamtick ")).collect();
    assert_eq!(commands.len(), 4);
    for command in commands {
        let words: Vec<&str> = command.split_whitespace().collect();
        let (said, code) = beamtick(folder.path(), &words, &"\n".repeat(60));
        assert_eq!(code, 0, "{command}: {said}");
    }
    let text = fs::read_to_string(folder.path().join("laser.toml")).unwrap();
    assert!(text.contains("\nsteps_per_mm = 160 ") && text.contains("\n[axes.z]\n"), "{text}");
    let plotter = fs::read_to_string(folder.path().join("plotter.toml")).unwrap();
    assert!(!plotter.contains("[laser]") && !plotter.contains("[axes.z]"), "{plotter}");
    // Every key that a file may have is on the page.
    for line in text.lines().filter(|line| line.contains('=') && !line.starts_with("# The")) {
        let key = line.trim_start_matches('#').split('=').next().unwrap().trim();
        assert!(page.contains(&format!("`{key}`")) || page.contains(&format!(".{key}`")), "{key}");
    }
    // Nothing is replaced.
    let (said, code) = beamtick(folder.path(), &["machine", "new", "laser.toml", "--yes"], "");
    assert!(code == 2 && said.contains("laser.toml: the file exists"), "{said}");
    assert_eq!(fs::read_to_string(folder.path().join("laser.toml")).unwrap(), text);
}

#[test]
fn answers_are_taken_and_wrong_ones_asked_again() {
    let folder = tempfile::tempdir().unwrap();
    // family, board, number, steps (wrong, then right), invert, travel, rate; usual answers for
    // all others.
    let answers = ["lsr", "serial:/dev/ttyACM0:921600", "", "-3", "12.5", "true", "[-10, 90]", "600"].join("\n");
    let (said, code) = beamtick(folder.path(), &["machine", "new", "m.toml"], &(answers + &"\n".repeat(60)));
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("axes.x.steps_per_mm is -3; it is 0.001 to 100000 pulses a mm"), "{said}");
    let (shown, code) = beamtick(folder.path(), &["machine", "check", "m.toml"], "");
    assert_eq!(code, 0, "{shown}");
    for part in [
        "X: axis 1, reversed, 12.5 pulses/mm (0.080000 mm a pulse), travel -10 to 90 mm",
        "600 mm/min (0.1250 pulse/ms)",
    ] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    assert!(shown.contains("family lsr; board serial:/dev/ttyACM0:921600"), "{shown}");
    // An input that ends leaves nothing.
    let (said, code) = beamtick(folder.path(), &["machine", "new", "cut.toml"], "gus\n");
    assert!(code == 2 && said.contains("link.board: the input ended here; --yes"), "{said}");
    assert!(!folder.path().join("cut.toml").exists());
    for (set, why) in [
        ("axes.x.steps=3", "there is no key `axes.x.steps`; keys are family, link.board, axes.x.number"),
        ("axes.x.travel", "it is KEY=VALUE"),
        ("laser.s_max=0", "laser.s_max is 0; it is 0.001 to 1000000"),
    ] {
        let (said, code) = beamtick(folder.path(), &["machine", "new", "set.toml", "--yes", "--set", set], "");
        assert!(code == 2 && said.contains(why), "{set}: {said}");
        assert!(!folder.path().join("set.toml").exists(), "{set}");
    }
}

/// An answer that is no value is asked again at once, one that a later answer makes wrong at the
/// end: no answer is lost, and no line of a file is named that is not there.
#[test]
fn no_answer_is_lost() {
    let folder = tempfile::tempdir().unwrap();
    let blank = |count: usize| "\n".repeat(count);
    // family, board, then number, steps, invert and travel of X.
    let answers = format!("{}[0\n[0, \"x\"\n1 2\n[0, 200]\n{}", blank(5), blank(60));
    let (said, code) = beamtick(folder.path(), &["machine", "new", "m.toml"], &answers);
    assert_eq!(code, 0, "{said}");
    assert_eq!(said.matches("axes.x.travel: least and greatest").count(), 4, "{said}");
    for part in ["axes.x.travel is `[0`: ", "axes.x.travel is `1 2`: ", "X: axis 1, 100 pulses/mm"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(said.contains("travel 0 to 200 mm"), "{said}");
    assert!(!(0..10).any(|line| said.contains(&format!("m.toml:{line}"))), "{said}");
    // Axis 7 is the connector of laser 0: said after the last answer, and asked again.
    let answers = format!("{}7\n{}", blank(2), blank(29));
    let questions = beamtick(folder.path(), &["machine", "new", "q.toml"], &answers).0;
    assert!(questions.contains("laser.channel is 0: in family gus it uses the connector of axis 7"), "{questions}");
    assert!(questions.contains("laser.channel: the input ended here; --yes"), "{questions}");
    assert!(!folder.path().join("q.toml").exists());
    let at = questions.lines().filter(|line| line.ends_with(']')).position(|line| line.starts_with("laser.channel:"));
    let answers = format!("{}7\n{}1\n{}", blank(2), blank(at.unwrap() - 3), blank(60));
    let (said, code) = beamtick(folder.path(), &["machine", "new", "q.toml"], &answers);
    assert_eq!(code, 0, "{said}");
    // The mode of the laser decides what is usual after it.
    for (mode, shown) in [("analog", "V"), ("frequency", "kHz"), ("duty", "%")] {
        let set = format!("laser.mode={mode}");
        let file = format!("{mode}.toml");
        let (said, code) = beamtick(folder.path(), &["machine", "new", &file, "--yes", "--set", &set], "");
        assert!(code == 0 && said.contains(shown), "{mode}: {said}");
    }
    let (said, code) = beamtick(folder.path(), &["machine", "new", "s.toml", "--yes", "--set", "laser.power=[0"], "");
    assert!(code == 2 && said.starts_with("--set laser.power=[0: ") && !said.contains("s.toml"), "{said}");
}

#[test]
fn what_is_no_machine_file_is_refused_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("b.toml"), [0xff, 0xfe, 0, 1]).unwrap();
    fs::create_dir(folder.path().join("d.toml")).unwrap();
    for (file, why) in [
        ("none.toml", "none.toml: the machine file cannot be read"),
        ("d.toml", "d.toml: the machine file cannot be read"),
        ("b.toml", "b.toml: the machine file is not UTF-8 text"),
    ] {
        let (said, code) = beamtick(folder.path(), &["machine", "check", file], "");
        assert!(code == 2 && said.contains(why), "{file}: {said}");
    }
}
