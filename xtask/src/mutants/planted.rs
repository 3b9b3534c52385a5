//! Faults that random programs must find alone, each planted in a build of its own, and in how many
//! of them they do.
//!
//! In: the list below and [`FOUND`]. Out: a table, also in `target/mutants/planted.md`; an error if
//! one is not found, does not compile, or if its text is not in its place. Those below programs
//! from outside found before the rules of SPEC 6 and 9 were revised.
use super::found::FOUND;
use super::timing::TIMING;
use super::{copy, replaced, write};
use crate::shell::{self, Outcome, cargo, target};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Which random programs find it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// The judge of light.
    Light,
    /// The reference controller, in exact arithmetic.
    Reference,
    /// The same program as a job, in C, in Python and as records.
    Doors,
    /// The exact model of a laser channel's edges.
    Lasers,
}

impl By {
    fn name(self) -> &'static str {
        match self {
            By::Light => "judge of light",
            By::Reference => "reference",
            By::Doors => "doors",
            By::Lasers => "laser model",
        }
    }

    /// Package, test file, its test, the variable of the number of programs, and within how many it
    /// must be found.
    fn test(self) -> [&'static str; 5] {
        match self {
            By::Light => ["beamtick-host-tests", "light_judge", "", "LIGHT_PROGRAMS", "20000"],
            By::Reference => ["beamtick-host-tests", "reference", "programs_agree", "REFERENCE_PROGRAMS", "50000"],
            By::Doors => ["beamtick", "doors", "random_programs", "DOORS_PROGRAMS", "50000"],
            By::Lasers => ["beamtick-host-tests", "laser_random", "every_edge", "LASER_JOBS", "50000"],
        }
    }

    /// The test in a tree, built in a folder.
    fn command(self, tree: &Path, folder: &Path) -> Command {
        let [package, file, test, variable, programs] = self.test();
        let mut command = cargo();
        command.current_dir(tree).env("CARGO_TARGET_DIR", folder);
        command.args(["test", "--release", "-p", package, "--test", file, "--", "--nocapture", test]);
        command.envs([("LIGHT_PLANTED", "1"), ("LIGHT_SEED", "1"), (variable, programs)]);
        command
    }
}

/// A fault, who finds it, and the places in which it is planted: file, text, and what stands there
/// instead.
pub struct Planted {
    pub name: &'static str,
    pub by: By,
    pub places: &'static [(&'static str, &'static str, &'static str)],
}

const OWNER: &str = "servo/src/laser/light_owner.rs";
const EXECUTE: &str = "servo/src/tick/execute.rs";
const COMMAND_HANDLER: &str = "dispatcher/src/session/commands.rs";
const SHADOW: &str = "dispatcher/src/shadow.rs";

const LIGHT: &[Planted] = &[
    Planted {
        name: "on entries live on through an Abort",
        by: By::Light,
        places: &[(OWNER, "self.dead.0 |= self.running.0;", "self.dead.0 |= 0;")],
    },
    Planted {
        name: "an immediate off does not hold while the path brakes",
        by: By::Light,
        places: &[(OWNER, " || self.vetoed && self.stopping.has(crd)", "")],
    },
    Planted {
        name: "an entry lights a channel that is not mapped",
        by: By::Light,
        places: &[(
            OWNER,
            "LightEvent::Entry { run, .. } if !self.map.has(run.crd) =>",
            "LightEvent::Entry { .. } if false =>",
        )],
    },
    Planted {
        name: "a map may be changed during a mark",
        by: By::Light,
        places: &[(
            "dispatcher/src/admit/laser/mod.rs",
            "if ahead || context.crd_may_run(crd) || sampled.owners.has(crd) {",
            "if ahead && sampled.owners.0 == u8::MAX {",
        )],
    },
    Planted {
        name: "a redundant on command takes the light over",
        by: By::Light,
        places: &[(
            OWNER,
            "            Light::On(LitBy::Path(_)) => GateOrder::Keep,\n            Light::Off | Light::On(LitBy::Call)",
            "            Light::Off | Light::On(_)",
        )],
    },
    Planted {
        name: "light under a velocity follow lights at rest",
        by: By::Light,
        places: &[(OWNER, "if self.follow.is_some_and(|crd| !self.running.has(crd)) {", "if false {")],
    },
    Planted {
        name: "a Stop shuts off the light of its own path only",
        by: By::Light,
        places: &[(
            OWNER,
            "(Light::On(who), StandstillCause::Stopped) if is_mapped => {",
            "(Light::On(who), StandstillCause::Stopped) if is_mapped && who == LitBy::Path(crd) => {",
        )],
    },
    Planted {
        name: "an on command without an output is remembered",
        by: By::Light,
        places: &[
            (OWNER, "_ if !self.output => GateOrder::Ignored(Ignored::NoOutput),", "_ if false => GateOrder::Keep,"),
            (OWNER, "        if !self.output {\n            return", "        if false {\n            return"),
        ],
    },
    Planted {
        name: "an Abort, and so GT_Close, leaves light at rest",
        by: By::Light,
        places: &[(EXECUTE, "                self.lasers.abort(next);\n", "")],
    },
    Planted {
        name: "a new session inherits light",
        by: By::Light,
        places: &[(EXECUTE, "                self.lasers.new_session(next);\n", "")],
    },
    Planted {
        name: "the link-loss time outlives Reset and session",
        by: By::Light,
        places: &[
            (SHADOW, "                self.watch = Watch::DEFAULT;\n", ""),
            (
                COMMAND_HANDLER,
                "        let watch = Watch::DEFAULT;\n",
                "        let watch = self.admission.admitted.watch;\n",
            ),
        ],
    },
    Planted {
        name: "the link-loss time outlives the session",
        by: By::Light,
        places: &[(
            COMMAND_HANDLER,
            "        let watch = Watch::DEFAULT;\n",
            "        let watch = self.admission.admitted.watch;\n",
        )],
    },
];

fn all() -> impl Iterator<Item = &'static Planted> {
    FOUND.iter().chain(LIGHT).chain(TIMING)
}

/// Every place is still there.
pub fn check(root: &Path) -> Vec<String> {
    all()
        .flat_map(|fault| fault.places.iter().map(move |place| (fault, place)))
        .filter_map(|(fault, &(file, text, broken))| replaced(root, fault.name, file, (text, broken)).err())
        .collect()
}

/// Plants those whose name holds `only`, one at a time, and asks the judge.
pub fn run(only: &str) -> Outcome {
    let chosen: Vec<&Planted> = all().filter(|fault| fault.name.contains(only)).collect();
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
        let mut test = fault.by.command(&tree, &folder);
        let output = test.output().map_err(|e| format!("`{}`: {e}", shell::line(&test)));
        for (path, text) in &before {
            write(path, text)?;
        }
        let output = output?;
        let said = [output.stdout, output.stderr].concat();
        let found = within(&String::from_utf8_lossy(&said));
        let row = format!("| {} | {} | {} |", fault.name, fault.by.name(), found.as_deref().unwrap_or("NOT FOUND"));
        println!("{row}");
        write(&target().join("mutants").join("said.txt"), &String::from_utf8_lossy(&said))?;
        rows.push((found.is_some(), row));
        let table: Vec<&str> = rows.iter().map(|(_, row)| row.as_str()).collect();
        write(&target().join("mutants").join("planted.md"), &(table.join("\n") + "\n"))?;
    }
    println!("\n| planted | found by | in program |\n| --- | --- | --- |");
    rows.iter().for_each(|(_, row)| println!("{row}"));
    let found = rows.iter().filter(|(found, _)| *found).count();
    println!("{found} of {} found by random programs alone", rows.len());
    if found == rows.len() { Ok(()) } else { Err("a planted fault is not found".into()) }
}

/// The least number of programs after which a finding is reported: `found after 12 programs`.
fn within(said: &str) -> Option<String> {
    let reported = said.lines().filter_map(|line| {
        let (_, rest) = line.split_once("found after ")?;
        rest.split(' ').next()?.parse::<u64>().ok()
    });
    reported.min().map(|programs| programs.to_string())
}
