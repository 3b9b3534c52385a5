//! `beamtick import`, and G-code where a job is expected: a program and a machine file become a
//! job.
//!
//! In: two files. Out: the text of a job; notes on the error stream. Fails with file, line and
//! reason, before anything moves.
use crate::Failure;
use crate::command_line::{Drawing, Import};
use crate::{machine_file, output};
use std::io::Write;
use std::path::{Path, PathBuf};
use trace::{AxisName, Millimetres};

/// Extensions of G-code.
const EXTENSIONS: [&str; 4] = ["nc", "gcode", "ngc", "tap"];

/// Whether a file is G-code by its name.
pub fn is_program(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
}

/// A program as a job.
pub struct Found {
    /// The text of the job.
    pub job: String,
    /// The machine file.
    pub file: PathBuf,
    /// The machine's axes, X first.
    pub millimetres: Vec<Millimetres>,
}

/// The job that a program is; notes and the extent go to the error stream.
pub fn job(path: &Path, drawing: &Drawing) -> Result<Found, Failure> {
    let name = path.display().to_string();
    let Some(file) = &drawing.machine else {
        return Err(Failure::Input(format!(
            "{name}: G-code needs --machine FILE; `beamtick machine new FILE` writes one"
        )));
    };
    let machine = machine_file::open(file)?;
    let bytes =
        std::fs::read(path).map_err(|error| Failure::Input(format!("{name}: the program cannot be read: {error}")))?;
    let text = String::from_utf8_lossy(&bytes);
    let options = gcode::Options { pass_stops: drawing.pass_stops };
    let found = gcode::import(&name, &text, &machine, options).map_err(Failure::Input)?;
    for note in &found.notes {
        complain!("{note}");
    }
    complain!("{name}: {}", found.extent);
    let millimetres = machine.axes.iter().map(|axis| Millimetres {
        axis: AxisName { core: 1, axis: axis.number },
        letter: axis.letter,
        per_mm: if axis.reversed { -axis.steps_per_mm } else { axis.steps_per_mm },
        zero: axis.home,
    });
    Ok(Found { job: found.job, file: file.clone(), millimetres: millimetres.collect() })
}

/// The link of the command line, else that of the machine file.
pub fn link(given: Option<&str>, drawing: &Drawing) -> Result<String, Failure> {
    let of_file = match (given, &drawing.machine) {
        (None, Some(file)) => machine_file::open(file)?.link,
        _ => None,
    };
    match given {
        Some(link) => Ok(link.to_owned()),
        None => of_file.ok_or_else(|| {
            Failure::Input(
                "--link is missing: tcp:HOST:PORT, serial:PATH[:BAUD] or qemu. No machine file names one; `beamtick sim` is for the virtual board".to_owned(),
            )
        }),
    }
}

/// Writes the job.
pub fn import(arguments: &Import) -> Result<(), Failure> {
    let name = arguments.program.display().to_string();
    if !is_program(&arguments.program) {
        return Err(Failure::Input(format!("{name}: G-code is named .nc, .gcode, .ngc or .tap")));
    }
    let found = job(&arguments.program, &arguments.drawing)?;
    let text = found.job;
    let to = &arguments.output;
    output::check(&[arguments.program.clone(), found.file], &[("--output", to, false)])?;
    let (staged, mut file) = output::Output::stream(to)?;
    file.write_all(text.as_bytes())
        .map_err(|error| Failure::Job(format!("{}: cannot be written: {error}", to.display())))?;
    drop(file);
    staged.whole()?;
    say!("{}: {} lines, from {name}", to.display(), text.lines().count());
    Ok(())
}
