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
