//! `beamtick import`, and G-code or a drawing where a job is expected: a file and a machine file
//! become a job.
//!
//! In: two files. Out: the text of a job; notes on the error stream. Fails with file, line and
//! reason, before anything moves.
use crate::Failure;
use crate::command_line::{Drawing, Import};
use crate::{machine_file, output};
use ::drawing::Format;
use std::io::Write;
use std::path::{Path, PathBuf};
use trace::{AxisName, Millimetres};

/// What becomes a job, by the end of its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Program,
    Drawing(Format),
}

const KINDS: [(&str, Kind); 5] = [
    ("nc", Kind::Program),
    ("gcode", Kind::Program),
    ("ngc", Kind::Program),
    ("tap", Kind::Program),
    ("svg", Kind::Drawing(Format::Svg)),
];
/// The same in words.
pub const NAMED: &str = "G-code is named .nc, .gcode, .ngc or .tap, a drawing .svg";

fn kind(path: &Path) -> Option<Kind> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    KINDS.into_iter().find_map(|(name, kind)| (name == extension).then_some(kind))
}

/// Whether a file becomes a job, by its name.
pub fn is_imported(path: &Path) -> bool {
    kind(path).is_some()
}

/// A program or a drawing as a job.
pub struct Found {
    /// The text of the job.
    pub job: String,
    /// The machine file.
    pub file: PathBuf,
    /// The machine's axes, X first.
    pub millimetres: Vec<Millimetres>,
}

/// The job that a program or a drawing is; notes and the extent go to the error stream.
pub fn job(path: &Path, drawing: &Drawing) -> Result<Found, Failure> {
    let name = path.display().to_string();
    let Some(file) = &drawing.machine else {
        return Err(Failure::Input(format!(
            "{name}: G-code and drawings need --machine FILE; `beamtick machine new FILE` writes one"
        )));
    };
    let mut machine = machine_file::open(file)?;
    let kind = kind(path).unwrap_or(Kind::Program);
    let what = match kind {
        Kind::Program => "program",
        Kind::Drawing(_) => "drawing",
    };
    let bytes =
        std::fs::read(path).map_err(|error| Failure::Input(format!("{name}: the {what} cannot be read: {error}")))?;
    let found = match kind {
        Kind::Program if !drawing.layers.is_empty() || drawing.at.is_some() => {
            Err(format!("{name}: --layer and --at are for drawings; a program says both itself"))
        }
        Kind::Program => {
            let options = gcode::Options { pass_stops: drawing.pass_stops };
            gcode::import(&name, &String::from_utf8_lossy(&bytes), &machine, options)
        }
        Kind::Drawing(_) if drawing.pass_stops => Err(format!("{name}: --pass-stops is for G-code")),
        Kind::Drawing(format) => machine.add_layers(&drawing.layers).and_then(|()| {
            let at = drawing.at.map_or([0.0; 2], |place| place.0);
            ::drawing::import(&name, &bytes, format, &machine, ::drawing::Options { at })
        }),
    }
    .map_err(Failure::Input)?;
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
    if !is_imported(&arguments.program) {
        return Err(Failure::Input(format!("{name}: {NAMED}")));
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
