//! Bounds of rounding, proved by Gappa from the scripts of `proofs/`.
//!
//! In: scripts, and the code that they are about. Out: a table of the bounds; an error where one is
//! not proved, where the code is not what a script says, where a smaller bound is proved too, or
//! where docs/evidence.md has another number. Lines of a script:
//!
//! * `#: NAME FILE | TEXT {} TEXT`: the number that stands there in the code, once; it replaces
//!   `@NAME@`.
//! * `#= FILE | TEXT`: what stands in the code, once.
//! * `#! NAME BOUND SMALLER`: replaces `@NAME@`; with the smaller bound there must be no proof.
use crate::setup;
use crate::shell::{Outcome, program, root};
use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Gappa's program.
pub const GAPPA: &str = "gappa";
/// A bound that takes longer than this is not proved.
const WAIT_MAX: Duration = Duration::from_secs(15);
/// Page with the bounds next to the measured values.
const PAGE: &str = "docs/evidence.md";

/// A bound and one that is too small.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Bound {
    name: String,
    proved: String,
    smaller: String,
}

/// A script with the numbers of the code in it.
#[derive(Debug, Default)]
struct Script {
    text: String,
    bounds: Vec<Bound>,
}

/// What Gappa makes of a script.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Verdict {
    Proved,
    Open,
    Broken(String),
}

/// Proves every bound, if Gappa is here or can be installed.
pub fn where_gappa_is() -> Outcome {
    if let Err(reason) = setup::gappa() {
        println!("skipped: the bounds of rounding are not proved: {reason}");
        return Ok(());
    }
    run()
}

/// Proves every bound.
pub fn run() -> Outcome {
    setup::gappa()?;
    let folder = root().join("proofs");
    let mut files: Vec<_> = fs::read_dir(&folder)
        .map_err(|e| format!("{}: {e}", folder.display()))?
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "gappa"))
        .collect();
    files.sort();
    if files.is_empty() {
        return Err(format!("{}: no scripts", folder.display()));
    }
    let page = read(&root().join(PAGE))?;
    println!("| script | bound | proved | not proved |\n| --- | --- | --- | --- |");
    for file in files {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let script = script(&read(&file)?, |path| read(&root().join(path))).map_err(|e| format!("{name}: {e}"))?;
        match verdict(&filled(&script, None))? {
            Verdict::Proved => {}
            Verdict::Open => return Err(format!("{name}: its bounds are not proved")),
            Verdict::Broken(why) => return Err(format!("{name}: {why}")),
        }
        for bound in &script.bounds {
            match verdict(&filled(&script, Some(&bound.name)))? {
                Verdict::Open => {}
                Verdict::Proved => return Err(format!("{name}: {} is proved too: {}", bound.smaller, bound.name)),
                Verdict::Broken(why) => return Err(format!("{name}: {why}")),
            }
            let row = format!("`{name}` {} {}", bound.name, bound.proved);
            if !page.contains(&row) {
                return Err(format!("{PAGE} does not say: {row}"));
            }
            println!("| `{name}` | {} | {} | {} |", bound.name, bound.proved, bound.smaller);
        }
    }
    Ok(())
}

fn read(path: &Path) -> Outcome<String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// A script with its numbers, which `code` gives the files for.
fn script(text: &str, code: impl Fn(&str) -> Outcome<String>) -> Outcome<Script> {
    let mut script = Script { text: text.to_owned(), bounds: Vec::new() };
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("#: ") {
            let (name, rest) = rest.split_once(' ').ok_or_else(|| format!("a name is missing: {line}"))?;
            let (file, place) = rest.split_once(" | ").ok_or_else(|| format!("a text is missing: {line}"))?;
            let (before, after) = place.split_once("{}").ok_or_else(|| format!("{{}} is missing: {line}"))?;
            let code = code(file)?;
            let mut found = code.match_indices(before).filter_map(|(at, _)| {
                let (number, _) = code.get(at + before.len()..)?.split_once(after)?;
                number.parse::<u64>().ok()
            });
            let (Some(number), None) = (found.next(), found.next()) else {
                return Err(format!("{file} has not one number in `{place}`"));
            };
            script.text = script.text.replace(&format!("@{name}@"), &number.to_string());
        } else if let Some(rest) = line.strip_prefix("#= ") {
            let (file, place) = rest.split_once(" | ").ok_or_else(|| format!("a text is missing: {line}"))?;
            match code(file)?.matches(place).count() {
                1 => {}
                count => return Err(format!("{file} has {count} times `{place}`")),
            }
        } else if let Some(rest) = line.strip_prefix("#! ") {
            let words: Vec<&str> = rest.split_whitespace().collect();
            let [name, proved, smaller] = words[..] else { return Err(format!("a bound is missing: {line}")) };
            let [name, proved, smaller] = [name, proved, smaller].map(str::to_owned);
            script.bounds.push(Bound { name, proved, smaller });
        }
    }
    if script.bounds.is_empty() {
        return Err("it has no bound".into());
    }
    Ok(script)
}

/// The script with its bounds; the one of this name is the smaller one.
fn filled(script: &Script, smaller: Option<&str>) -> String {
    script.bounds.iter().fold(script.text.clone(), |text, bound| {
        let value = if smaller == Some(bound.name.as_str()) { &bound.smaller } else { &bound.proved };
        text.replace(&format!("@{}@", bound.name), value)
    })
}

fn verdict(script: &str) -> Outcome<Verdict> {
    let mut gappa = program(GAPPA);
    gappa.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = gappa.spawn().map_err(|e| format!("{GAPPA}: {e}"))?;
    if let Some(mut input) = child.stdin.take() {
        input.write_all(script.as_bytes()).map_err(|e| format!("{GAPPA}: {e}"))?;
    }
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
            break status;
        }
        if began.elapsed() > WAIT_MAX {
            let _ = child.kill();
            let _ = child.wait();
            return Ok(Verdict::Open);
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let mut said = String::new();
    if let Some(mut errors) = child.stderr.take() {
        errors.read_to_string(&mut said).map_err(|e| format!("{GAPPA}: {e}"))?;
    }
    Ok(match (status.success(), said.contains("properties were not satisfied")) {
        (true, _) => Verdict::Proved,
        (false, true) => Verdict::Open,
        (false, false) => Verdict::Broken(said),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(text: &str, code: &str) -> Outcome<Script> {
        script(text, |_| Ok(code.to_owned()))
    }

    #[test]
    fn numbers_come_from_the_code() {
        let text = "#: BITS a.rs | const BITS: u32 = {};\n#= a.rs | x >> BITS\n#! BOUND 2 1\n{ x in [0,1b@BITS@] -> x in [0,@BOUND@] }\n";
        let code = "const BITS: u32 = 22;\nfn f(x: u32) -> u32 { x >> BITS }\n";
        let found = made(text, code).unwrap();
        assert!(filled(&found, None).ends_with("{ x in [0,1b22] -> x in [0,2] }\n"));
        assert!(filled(&found, Some("BOUND")).ends_with("{ x in [0,1b22] -> x in [0,1] }\n"));
    }

    #[test]
    fn a_script_that_is_not_of_the_code_is_refused() {
        let number = "#: BITS a.rs | const BITS: u32 = {};\n#! BOUND 2 1\n";
        for code in ["", "const BITS: u32 = N;", "const BITS: u32 = 1;\nconst BITS: u32 = 2;"] {
            assert!(made(number, code).unwrap_err().contains("not one number"), "{code}");
        }
        let line = "#= a.rs | x >> 3\n#! BOUND 2 1\n";
        assert!(made(line, "x >> 4").unwrap_err().contains("0 times"));
        assert!(made(line, "x >> 3; x >> 3").unwrap_err().contains("2 times"));
        assert_eq!(made("# nothing\n", "").unwrap_err(), "it has no bound");
    }

    /// The scripts' numbers and texts are those of the code. The bounds themselves are proved where
    /// Gappa is installed.
    #[test]
    fn every_script_is_of_the_code() {
        let mut scripts = 0;
        for entry in fs::read_dir(root().join("proofs")).unwrap().flatten() {
            let text = read(&entry.path()).unwrap();
            let found = script(&text, |path| read(&root().join(path)));
            let found = found.unwrap_or_else(|why| panic!("{}: {why}", entry.path().display()));
            let left = filled(&found, None);
            let open = left.lines().filter(|line| !line.starts_with('#')).find(|line| line.matches('@').count() > 1);
            assert!(open.is_none_or(|line| line.contains("@FIX") || line.starts_with('@')), "{open:?}");
            scripts += 1;
        }
        assert!(scripts >= 8, "{scripts}");
    }
}
