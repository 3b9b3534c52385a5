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
