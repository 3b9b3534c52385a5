//! `beamtick plot` on a trace that was kept, a job from the standard input, completions.
use assert_cmd::Command;
use std::fs;
use std::path::Path;

const JOB: &str = "GT_AxisOn(2); GT_PrfTrap(2); TTrapPrm trap; trap.acc = 1; trap.dec = 1; trap.velStart = 0; trap.smoothTime = 0; GT_SetTrapPrm(2, &trap);\n\
                   GT_AxisOn(1); GT_PrfTrap(1); GT_SetPos(2, 500); GT_SetVel(2, 10); GT_Update(2); WaitStop(2);\n";

fn beamtick(words: &[&str], input: &str) -> (String, String, i32) {
    let mut command = Command::cargo_bin("beamtick").unwrap();
    let output = command.args(words).write_stdin(input).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

#[test]
fn a_trace_is_drawn_as_the_job_was() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, first, again, used) = (at("t.csv"), at("first.svg"), at("again.svg"), at("used.svg"));
    let (out, errors, code) = beamtick(&["sim", "-", "--trace", &csv, "--plot", &first], JOB);
    assert_eq!(code, 0, "{out}{errors}");
    let (_, errors, code) = beamtick(&["plot", &csv, "-o", &again, "--xy", &at("xy.png")], "");
    assert_eq!(code, 0, "{errors}");
    // The curves are the same; the headings are not.
    let curves = |name: &str| -> Vec<String> {
        let text = fs::read_to_string(name).unwrap();
        text.lines().filter(|line| line.contains("<polyline")).map(str::to_owned).collect()
    };
    assert!(!curves(&first).is_empty());
    assert_eq!(curves(&first), curves(&again));
    assert!(fs::read(at("xy.png")).unwrap().starts_with(b"\x89PNG"));
    // Of the standard input, only what moved, a part, and a file that was cut off.
    let whole = fs::read_to_string(&csv).unwrap();
    let cut = &whole[..whole.len() - 7];
    let (_, errors, code) = beamtick(&["plot", "-", "--used", "-o", &used, "--from", "5", "--to", "40"], cut);
    assert_eq!(code, 0, "{errors}");
    let picture = fs::read_to_string(&used).unwrap();
    assert!(picture.contains("axis 2 position") && !picture.contains("axis 1 position"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5);
}

#[test]
fn what_cannot_be_drawn_is_said_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(at("t.csv"), "t_ms,axis1_pos\n0,0\n1,x\n").unwrap();
    for (words, part) in [
        (vec!["plot", &at("t.csv"), "-o", &at("t.png")], "t.csv: line 3: `x` is no number"),
        (vec!["plot", &at("t.csv"), "-o", &at("t.gif")], ".png or .svg"),
        (vec!["plot", &at("t.csv"), "-o", &at("a.png"), "--xy", &at("a.png")], "would overwrite a file"),
        (vec!["plot", &at("none.csv"), "-o", &at("t.png")], "cannot be read"),
        (vec!["plot", &at("t.csv")], "--output"),
    ] {
        let (_, errors, code) = beamtick(&words, "");
        assert!(code == 2 && errors.contains(part), "{words:?} = {code}: {errors}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(Path::new(&at("t.csv")).exists());
}

/// A disk that is full, by a limit on the length of files.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_empty_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let limited = |blocks: u32, words: &str| {
        let beamtick = assert_cmd::cargo::cargo_bin("beamtick");
        let line = format!("ulimit -f {blocks}; exec {} {words}", beamtick.display());
        let output = Command::new("sh").current_dir(folder.path()).args(["-c", &line]).output().unwrap();
        (String::from_utf8(output.stderr).unwrap(), output.status.code())
    };
    fs::write(at("job.gts"), JOB).unwrap();
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    let (_, errors, code) = beamtick(&["sim", &at("job.gts"), "--trace", &at("t.csv")], "");
    assert_eq!(code, 0, "{errors}");
    for words in [
        "plot t.csv -o p.png",
        "plot t.csv -o p.svg",
        "plot t.csv --html p.html",
        &format!("import {examples}/square.nc --machine {examples}/machine.toml -o p.gts"),
    ] {
        let (errors, code) = limited(0, words);
        assert!(code == Some(1) && errors.contains("File too large"), "{words} = {code:?}: {errors}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "{words}");
    }
    // What there is of a trace is named.
    let (errors, code) = limited(1, "sim job.gts --trace u.csv");
    assert!(code == Some(1) && errors.contains("What was recorded until then is in u.csv.partial."), "{errors}");
}

#[test]
fn shells_get_their_completions() {
    for shell in ["bash", "zsh", "fish"] {
        let (out, _, code) = beamtick(&["completions", shell], "");
        assert!(code == 0 && out.contains("beamtick") && out.contains("step-limit"), "{shell}");
    }
}
