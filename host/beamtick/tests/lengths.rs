//! Calls with arrays, of every length at and beyond the limits, as job scripts.

#[path = "../../job/tests/lengths/mod.rs"]
mod lengths;

use beamtick::Failure;
use lengths::Length;
use std::fmt::Write;

/// The job of these calls, in a file of its own; the variables of each have a number.
fn sim(all: &[&Length]) -> Result<(), String> {
    let mut text = String::new();
    for (number, Length { data, before, call, after, .. }) in all.iter().enumerate() {
        let named = |part: &str| {
            let names = [
                "t", "p", "v", "w", "c", "out", "value", "axis", "option", "vel", "power", "ratio", "pos", "axes",
                "counts", "x", "y", "origin", "scale",
            ];
            let word = |word: &str| if names.contains(&word) { format!("{word}{number}") } else { word.to_owned() };
            let mut out = String::new();
            let mut rest = part;
            while let Some(first) = rest.chars().next() {
                let is_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
                let end = rest.find(|letter| is_word(letter) != is_word(first)).unwrap_or(rest.len());
                out += &word(&rest[..end]);
                rest = &rest[end..];
            }
            out
        };
        let _ = write!(text, "{}{}{};\n{after}", named(data), named(before), named(call));
    }
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("lengths.gts");
    std::fs::write(&job, &text).unwrap();
    match beamtick::call(&["sim", job.to_str().unwrap()]) {
        Ok(()) => Ok(()),
        Err(Failure::Job(text) | Failure::Input(text)) => Err(text),
        Err(Failure::Interrupted(..)) => panic!("interrupted"),
    }
}

#[test]
fn every_length_is_taken_or_refused() {
    let mut wrong = Vec::new();
    for function in lengths::all() {
        let taken: Vec<&Length> = function.iter().filter(|length| length.code == 0).collect();
        if let Err(text) = sim(&taken) {
            wrong.push(text);
        }
        for length in function.iter().filter(|length| length.code != 0) {
            match sim(&[length]) {
                Err(text)
                    if (text.contains("returned 7") || text.contains("return value 7"))
                        && text.contains("count")
                        && !text.contains("bytes") => {}
                other => wrong.push(format!("{}: {other:?}", length.name)),
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// A job of more lines than compile as a whole is compiled in parts, if nothing in it reaches over
/// its lines; its axes and coordinate systems are those of all parts.
#[test]
fn a_plain_job_may_have_any_number_of_lines() {
    let folder = tempfile::tempdir().unwrap();
    let check = |text: &str| {
        std::fs::write(folder.path().join("j.gts"), text).unwrap();
        let said = std::fs::File::create(folder.path().join("said.txt")).unwrap();
        let mut check = std::process::Command::new(env!("CARGO_BIN_EXE_beamtick"));
        let out = check.args(["check", "j.gts"]).current_dir(folder.path()).stdout(said).output().unwrap();
        let said = std::fs::read_to_string(folder.path().join("said.txt")).unwrap();
        (out.status.code(), said, String::from_utf8_lossy(&out.stderr).into_owned())
    };
    let lines = 650_000;
    let begin = "TTrapPrm prm = {1, 1, 0, 0};\nGT_PrfTrap(1);\nGT_SetTrapPrm(1,&prm);\n";
    let job = format!("{begin}{}GT_PrfJog(2);\nSleep(5);\n", "GT_SetVel(1,5);\n".repeat(lines));
    let (code, said, errors) = check(&job);
    assert_eq!(code, Some(0), "{errors}");
    let last = said.lines().rev().nth(1).unwrap();
    assert_eq!(last, format!("j.gts: {} steps, 0 warnings; axes used (core.axis): 1.1 1.2", lines + 4));
    // The line of a step is its own.
    let sleep = said.lines().rev().nth(2).unwrap();
    assert!(sleep.trim_start().starts_with(&format!("{} ", lines + 5)) && sleep.ends_with("sleep 5 ms"), "{sleep}");
    // What ends the script in its middle makes parts something else.
    let (code, _, errors) = check(&job.replacen("Sleep(5);", "return;", 1));
    assert!(code == Some(2) && errors.contains("too long"), "{errors}");
}
