//! `beamtick import`, and G-code or a drawing where a job is expected: a file and a machine file
//! become a job. What the standard input is says its text.
//!
//! In: two files. Out: the text of a job; notes on the error stream. Fails with file, line and
//! reason, before anything moves.
use crate::Failure;
use crate::command_line::{Drawing, Import};
use crate::imported::ImportedText;
use crate::input::{self, Role};
use crate::output::Output;
use crate::parts::{Broken, Compiled};
use crate::script::Script;
use crate::summary::counted;
use crate::{json, machine_file, output, record};
use ::drawing::Format;
use job::Folder;
use machine::Machine;
use std::io::{self, BufRead, Read, Write};
use std::path::{Path, PathBuf};
use strokes::{Extent, Imported, Watch};
use trace::{Millimetres, PlotOptions, Preview};

/// What becomes a job, by the end of its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// G-code.
    Program,
    /// An SVG or a DXF.
    Drawing(Format),
}

const KINDS: [(&str, Kind); 6] = [
    ("nc", Kind::Program),
    ("gcode", Kind::Program),
    ("ngc", Kind::Program),
    ("tap", Kind::Program),
    ("svg", Kind::Drawing(Format::Svg)),
    ("dxf", Kind::Drawing(Format::Dxf)),
];
/// The same in words.
pub const NAMED: &str = "G-code is named .nc, .gcode, .ngc or .tap, a drawing .svg or .dxf";

/// What a file is that becomes a job: by its name, the standard input by its text.
///
/// # Errors
/// The standard input cannot be read.
pub fn kind(path: &Path) -> io::Result<Option<Kind>> {
    if input::is_standard(path) {
        return input::standard(Role::Job, |bytes| looks_like(bytes).map(|(kind, _)| kind));
    }
    let Some(extension) = path.extension() else { return Ok(None) };
    let extension = extension.to_string_lossy().to_lowercase();
    Ok(KINDS.into_iter().find_map(|(name, kind)| (name == extension).then_some(kind)))
}

/// Whether it is a file of G-code, by its name.
pub fn is_program(path: &Path) -> bool {
    !input::is_standard(path) && matches!(kind(path), Ok(Some(Kind::Program)))
}

/// Lines of a file that are looked at, to see what it is.
const SNIFFED_LINES: usize = 60;

/// G-code or a drawing, which no job looks like: what it is, and a sentence that says so.
pub fn looks_like(bytes: &[u8]) -> Option<(Kind, String)> {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 14)]);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if text.starts_with("<svg") || text.starts_with("<?xml") && text.contains("<svg") {
        return Some((Kind::Drawing(Format::Svg), "this is an SVG".to_owned()));
    }
    let mut pairs = text.lines().map(str::trim);
    if (pairs.next(), pairs.next()) == (Some("0"), Some("SECTION")) {
        return Some((Kind::Drawing(Format::Dxf), "this is a DXF".to_owned()));
    }
    let named = |block: &str| block.starts_with(['G', 'M', 'N']) && is_block(block);
    let mut lines = text.lines().take(SNIFFED_LINES).enumerate().map(|(number, line)| (number, line, bare(line)));
    // Words of other letters stand in lists of a job, too, but no job begins with them.
    let first = lines.clone().find(|(.., block)| !matches!(block.as_str(), "" | "%"));
    let first = first.filter(|(.., block)| is_block(block));
    let found = first.or_else(|| lines.find(|(.., block)| named(block)));
    found.map(|(number, line, _)| {
        let shown: String = line.trim().chars().take(40).collect();
        (Kind::Program, format!("line {} is G-code (`{shown}`)", number + 1))
    })
}

/// A line of G-code without blanks, comments and the mark of a line that may be left out.
fn bare(line: &str) -> String {
    let line = line.split(';').next().unwrap_or("").trim();
    let line = line.strip_prefix('/').filter(|rest| !rest.starts_with(['/', '*'])).unwrap_or(line);
    let mut in_comment = false;
    let outside = |letter: &char| {
        in_comment |= *letter == '(';
        let is_outside = !in_comment && !letter.is_whitespace();
        in_comment &= *letter != ')';
        is_outside
    };
    line.chars().filter(outside).collect::<String>().to_ascii_uppercase()
}

/// Whether a line that [`bare`] has made is words of G-code and nothing else.
fn is_block(block: &str) -> bool {
    let mut rest = block;
    if rest.is_empty() {
        return false;
    }
    while rest.starts_with(|letter: char| letter.is_ascii_uppercase()) {
        let number = &rest[1..];
        let end = number.find(|c: char| !(c.is_ascii_digit() || "+-.".contains(c))).unwrap_or(number.len());
        if number[..end].parse::<f64>().is_err() {
            return false;
        }
        rest = &number[end..];
    }
    rest.is_empty()
}

/// A program or a drawing as a job.
pub struct Found {
    /// The text of the job.
    pub script: Script,
    /// What that compiles to, if it is compiled already.
    pub compiled: Option<Result<Compiled, Broken>>,
    /// The machine file.
    pub file: PathBuf,
    /// The machine's axes, X first.
    pub millimetres: Vec<Millimetres>,
    /// Channels of lasers that have a name.
    pub lasers: Vec<(u8, String)>,
    /// What the path covers, and how long it takes.
    pub extent: Extent,
}

/// The job that a program or a drawing is; notes go to the error stream. `plot` is a
/// picture of its path, drawn also where the path leaves the travel. Without
/// `timed` it is not told how long it takes.
pub fn job(path: &Path, drawing: &Drawing, plot: Option<&Path>, timed: bool) -> Result<Found, Failure> {
    let name = path.display().to_string();
    let Some(file) = &drawing.machine else {
        return Err(Failure::Input(format!(
            "{name}: G-code and drawings need --machine FILE; `beamtick machine new FILE` writes one"
        )));
    };
    let mut machine = machine_file::open(file, drawing.laser.as_deref())?;
    machine.add_layers(&drawing.layers).map_err(Failure::Input)?;
    let picture = match plot {
        None => None,
        Some(to) => {
            output::check(&[path.to_owned(), file.clone()], &[("--plot", to, true)])?;
            record::picture(to)?;
            Some((Output::picture(to)?, preview(&name, &machine)))
        }
    };
    let unread = |error: io::Error| Failure::Input(format!("{name}: it cannot be read: {error}"));
    let kind = kind(path).map_err(unread)?.unwrap_or(Kind::Program);
    let found = match picture {
        None => made((&name, kind), path, &machine, (drawing, timed), None),
        Some((output, mut preview)) => {
            let mut show = |[x, y, _]: [f64; 3], lit: Option<usize>| preview.line((x, y), lit);
            let found = made((&name, kind), path, &machine, (drawing, timed), Some(&mut show));
            draw(output, preview, found.as_ref())?;
            found
        }
    }
    .map_err(Failure::Input)?;
    for note in &found.notes {
        json::note(note);
        complain!("{note}");
    }
    let millimetres = machine_file::millimetres(&machine);
    let named = |laser: machine::Laser| laser.name.map(|name| (laser.channel, name));
    let lasers = machine.lasers.into_iter().filter_map(named).collect();
    let Made { script, compiled, extent, .. } = found;
    Ok(Found { script, compiled, file: file.clone(), millimetres, lasers, extent })
}

/// What a program or a drawing says.
struct Made {
    script: Script,
    compiled: Option<Result<Compiled, Broken>>,
    notes: Vec<String>,
    extent: Extent,
}

fn made(
    (name, kind): (&str, Kind),
    path: &Path,
    machine: &Machine,
    (drawing, timed): (&Drawing, bool),
    watch: Option<Watch<'_>>,
) -> Result<Made, String> {
    let what = if kind == Kind::Program { "program" } else { "drawing" };
    let unread = |error| format!("{name}: the {what} cannot be read: {error}");
    match kind {
        Kind::Drawing(_) if drawing.pass_stops => Err(format!("{name}: --pass-stops is for G-code")),
        Kind::Drawing(format) => {
            let at = drawing.at.map_or([0.0; 2], |place| place.0);
            let bytes = input::read(path, Role::Job).map_err(unread)?;
            let Imported { job, notes, extent } =
                ::drawing::import(name, &bytes, format, machine, ::drawing::Options { at, untimed: !timed }, watch)?;
            Ok(Made { script: Script::Whole(job), compiled: None, notes, extent })
        }
        _ if !drawing.layers.is_empty() || drawing.at.is_some() => {
            Err(format!("{name}: --layer and --at are for drawings; a program says both itself"))
        }
        _ => {
            let options = gcode::Options { pass_stops: drawing.pass_stops, untimed: !timed };
            let mut lines = input::open(path, Role::Job).map_err(unread)?;
            let unkept = |error| format!("{name}: the job cannot be kept: {error}");
            let mut text = ImportedText::new(Folder::of(path)).map_err(unkept)?;
            let (notes, extent) = gcode::import_to(name, &mut lines, machine, options, watch, &mut text)?;
            let (script, compiled) = text.finish().map_err(unkept)?;
            Ok(Made { script, compiled: Some(compiled), notes, extent })
        }
    }
}

/// An empty picture of X and Y of a machine.
fn preview(name: &str, machine: &Machine) -> Preview {
    let travel = ['X', 'Y'].map(|letter| machine.axis(letter).map_or((0.0, 0.0), |axis| axis.travel));
    let options = PlotOptions { title: name.to_owned(), ..PlotOptions::default() };
    let marks = [0, 1].map(|laser| match machine.lasers.get(laser).and_then(|laser| laser.name.as_ref()) {
        Some(name) => format!("marked by {name}"),
        None => "marked".to_owned(),
    });
    Preview::new(options, ['X', 'Y'], travel, marks)
}

/// Writes the picture of a path; of one that is refused too, if there is anything of it.
fn draw(output: Output, mut preview: Preview, found: Result<&Made, &String>) -> Result<(), Failure> {
    match found {
        Ok(found) => {
            // The legend names the lasers.
            let mut extent = Extent { lasers: Vec::new(), ..found.extent.clone() };
            extent.all.retain(|(letter, ..)| *letter != 'Z');
            extent.marks.retain(|(letter, ..)| *letter != 'Z');
            preview.subtitle(extent.to_string());
        }
        Err(_) => preview.subtitle("refused: nothing was run".to_owned()),
    }
    match preview.save(output.path()) {
        Ok(()) => output.whole(),
        Err(_) if found.is_err() => {
            output.cut_off();
            Ok(())
        }
        Err(error) => {
            output.cut_off();
            Err(error.into())
        }
    }
}

/// The link of the command line, else that of the machine file.
pub fn link(given: Option<&str>, drawing: &Drawing) -> Result<String, Failure> {
    match (given, &drawing.machine) {
        (Some(link), _) => Ok(link.to_owned()),
        (None, Some(file)) => {
            let machine = machine_file::open(file, drawing.laser.as_deref())?;
            Ok(machine.link.unwrap_or_else(|| "virtual".to_owned()))
        }
        (None, None) => Err(Failure::Input(
            "--link is missing: tcp:HOST:PORT, serial:PATH[:BAUD], qemu, or virtual; or --machine FILE, which names one"
                .to_owned(),
        )),
    }
}

/// Writes the job.
pub fn import(arguments: &Import) -> Result<(), Failure> {
    let name = arguments.program.display().to_string();
    let unread = |error: io::Error| Failure::Input(format!("{name}: it cannot be read: {error}"));
    input::is_for_one(&arguments.program, arguments.drawing.machine.as_deref()).map_err(unread)?;
    if kind(&arguments.program).map_err(unread)?.is_none() {
        let seen = if input::is_standard(&arguments.program) { "it is neither G-code nor a drawing" } else { NAMED };
        return Err(Failure::Input(format!("{name}: {seen}")));
    }
    let to = &arguments.output;
    let read = [Some(arguments.program.clone()), arguments.drawing.machine.clone()];
    let read: Vec<PathBuf> = read.into_iter().flatten().collect();
    let plot = arguments.plot.as_deref();
    let to_file = (!input::is_standard(to)).then_some(("--output", to.as_path(), false));
    let outputs = plot.map(|plot| ("--plot", plot, true)).into_iter().chain(to_file);
    output::check(&read, &outputs.collect::<Vec<_>>())?;
    let found = job(&arguments.program, &arguments.drawing, plot, true)?;
    complain!("{name}: {}", found.extent);
    let mut reader = found.script.reader();
    let failed = |error: io::Error| Failure::Job(format!("{}: cannot be written: {error}", to.display()));
    if input::is_standard(to) {
        let mut text = String::new();
        reader.read_to_string(&mut text).map_err(failed)?;
        say!("{}", text.trim_end());
        return Ok(());
    }
    let (staged, mut file) = output::Output::stream(to)?;
    let lines = match copy(&mut reader, &mut file) {
        Ok(lines) => lines,
        Err(error) => {
            staged.cut_off();
            return Err(failed(error));
        }
    };
    drop(file);
    staged.whole()?;
    say!("{}: {}, from {name}", to.display(), counted(lines as i64, "line", "lines"));
    Ok(())
}

/// Copies a text, and counts its lines, of which each has an end.
fn copy(from: &mut impl BufRead, to: &mut impl Write) -> io::Result<usize> {
    let mut lines = 0;
    loop {
        let block = from.fill_buf()?;
        if block.is_empty() {
            return Ok(lines);
        }
        lines += block.iter().filter(|byte| **byte == b'\n').count();
        to.write_all(block)?;
        let count = block.len();
        from.consume(count);
    }
}
