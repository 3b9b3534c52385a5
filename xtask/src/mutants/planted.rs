//! Faults that the judge of light must find alone, each planted in a build of its own, and in how many random programs it does.
//!
//! In: the list below. Out: a table; an error if one is not found, does not compile, or if its text is not in its place.
//! They are those faults that programs from outside found, before the rules of SPEC 6 and 9 were revised.
use super::{copy, replaced, write};
use crate::shell::{self, Outcome, cargo, target};
use std::fs;
use std::path::Path;

/// Within so many programs.
const PROGRAMS: u32 = 20_000;

/// A fault, and the places in which it is planted: file, text, and what stands there instead.
struct Planted {
    name: &'static str,
    places: &'static [(&'static str, &'static str, &'static str)],
}

const OWNER: &str = "servo/src/laser/owner.rs";
const EXECUTE: &str = "servo/src/execute.rs";
const DESK: &str = "dispatcher/src/desk.rs";
const BOOKS: &str = "dispatcher/src/books.rs";

const PLANTED: &[Planted] = &[
    Planted {
        name: "on entries live on through an Abort",
        places: &[(OWNER, "self.dead.0 |= self.running.0;", "self.dead.0 |= 0;")],
    },
    Planted {
        name: "an immediate off does not hold while the path brakes",
        places: &[(OWNER, " || self.vetoed && self.stopping.has(crd)", "")],
    },
    Planted {
        name: "an entry lights a channel that is not mapped",
        places: &[(OWNER, "Fact::Entry { run, .. } if !self.map.has(run.crd) =>", "Fact::Entry { .. } if false =>")],
    },
    Planted {
        name: "a map may be changed during a mark",
        places: &[(
            "dispatcher/src/admit/laser/mod.rs",
            "if ahead || case.crd_may_run(crd) || seen.owners.has(crd) {",
            "if ahead && seen.owners.0 == u8::MAX {",
        )],
    },
    Planted {
        name: "a redundant on command takes the light over",
        places: &[(
            OWNER,
            "            Light::On(Who::Path(_)) => Order::Keep,\n            Light::Off | Light::On(Who::Call)",
            "            Light::Off | Light::On(_)",
        )],
    },
    Planted {
        name: "light under a velocity follow lights at rest",
        places: &[(OWNER, "if self.follow.is_some_and(|crd| !self.running.has(crd)) {", "if false {")],
    },
    Planted {
        name: "a Stop shuts off the light of its own path only",
        places: &[(
            OWNER,
            "(Light::On(who), End::Stopped) if is_mapped => {",
            "(Light::On(who), End::Stopped) if is_mapped && who == Who::Path(crd) => {",
        )],
    },
    Planted {
        name: "an on command without an output is remembered",
        places: &[
            (OWNER, "_ if !self.output => Order::Ignored(Ignored::NoOutput),", "_ if false => Order::Keep,"),
            (OWNER, "        if !self.output {\n            return", "        if false {\n            return"),
        ],
    },
    Planted {
        name: "an Abort, and so GT_Close, leaves light at rest",
        places: &[(EXECUTE, "                self.lasers.abort(next);\n", "")],
    },
    Planted {
        name: "a new session inherits light",
        places: &[(EXECUTE, "                self.lasers.new_session(next);\n", "")],
    },
    Planted {
        name: "the link-loss time outlives Reset and session",
        places: &[
            (BOOKS, "                self.watch = Watch::DEFAULT;\n", ""),
            (DESK, "        let watch = Watch::DEFAULT;\n", "        let watch = self.ahead.watch;\n"),
        ],
    },
    Planted {
        name: "the link-loss time outlives the session",
        places: &[(DESK, "        let watch = Watch::DEFAULT;\n", "        let watch = self.ahead.watch;\n")],
    },
];

/// Every place is still there.
pub fn check(root: &Path) -> Vec<String> {
    PLANTED
        .iter()
        .flat_map(|fault| fault.places.iter().map(move |place| (fault, place)))
        .filter_map(|(fault, &(file, text, broken))| replaced(root, fault.name, file, (text, broken)).err())
        .collect()
}

/// Plants those whose name holds `only`, one at a time, and asks the judge.
pub fn run(only: &str) -> Outcome {
    let chosen: Vec<&Planted> = PLANTED.iter().filter(|fault| fault.name.contains(only)).collect();
    if chosen.is_empty() {
        return Err(format!("no planted fault is called {only}"));
    }
    let tree = copy()?;
    let folder = target().join("mutants").join("judge");
    let mut rows = Vec::new();
    for fault in &chosen {
        let mut before = Vec::new();
        for &(file, text, broken) in fault.places {
            let path = tree.join(file);
            before.push((path.clone(), fs::read_to_string(&path).map_err(|e| format!("{file}: {e}"))?));
            write(&path, &replaced(&tree, fault.name, file, (text, broken))?)?;
        }
        let mut test = cargo();
        test.current_dir(&tree).env("CARGO_TARGET_DIR", &folder);
        test.args(["test", "--release", "-p", "beamtick-host-tests", "--test", "light_judge", "--", "--nocapture"]);
        test.envs([("LIGHT_PLANTED", "1"), ("LIGHT_PROGRAMS", &PROGRAMS.to_string()), ("LIGHT_SEED", "1")]);
        let output = test.output().map_err(|e| format!("`{}`: {e}", shell::line(&test)));
        for (path, text) in &before {
            write(path, text)?;
        }
        let said = String::from_utf8_lossy(&output?.stdout).into_owned();
        let found = said.lines().find_map(|line| line.strip_prefix("found after ")?.strip_suffix(" programs:"));
        let row = format!("| {} | {} |", fault.name, found.unwrap_or("NOT FOUND"));
        println!("{row}");
        rows.push((found.is_some(), row));
    }
    println!("\n| planted | found in program |\n| --- | --- |");
    rows.iter().for_each(|(_, row)| println!("{row}"));
    let found = rows.iter().filter(|(found, _)| *found).count();
    println!("{found} of {} found by the judge alone", rows.len());
    if found == rows.len() { Ok(()) } else { Err("the judge does not find a planted fault".into()) }
}
