//! The command line.
mod monitor;

pub use monitor::Monitor;

use crate::bring_up::BringUp;
use crate::json::Json;
use clap::builder::RangedI64ValueParser;
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use trace::{AxisName, Panels};

/// Runs motion jobs in the virtual controller or on a Beamtick board.
///
/// A job is a text file (.gts) in the notation of the controller manuals; docs/jobs.md describes
/// it.
#[derive(Debug, Parser)]
#[command(version, after_help = EXAMPLES, max_term_width = 80)]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples, with the files of examples/:
  beamtick check pt_static.gts
  beamtick sim pt_static.gts --trace t.csv --plot t.png
  beamtick sim pt_dynamic.gts --tick-us 50 --plot z.svg --from 900 --to 1100
  beamtick sim laser_duty.gts --plot pulses.png --from 1 --to 2
  beamtick sim pvt_percent.gts --xy path.png
  beamtick sim pvt_percent.gts --html t.html --panels acceleration,error
  beamtick sim pt_static.gts --step-limit 1000
  beamtick sim inputs.gts --inputs inputs.csv --plot inputs.png
  beamtick plot t.csv -o t.png --from 900 --to 1100
  beamtick run pt_static.gts --link qemu --vcd t.vcd
  beamtick run jog_trap.gts --link tcp:192.168.1.20:5000 --strict
  beamtick run jog_trap.gts --link serial:/dev/ttyACM0:3000000
  beamtick machine new mine.toml
  beamtick sim square.nc --machine machine.toml --xy square.png
  beamtick check badge.svg --machine machine.toml --plot plan.png
  beamtick sim badge.svg --machine machine.toml --xy badge.png
  beamtick import square.nc --machine machine.toml -o square.gts
  beamtick serve --listen 127.0.0.1:5000
  beamtick grbl --machine machine.toml --listen 127.0.0.1:5001
  beamtick run square.nc --machine machine.toml --share 127.0.0.1:5002
  beamtick monitor --link tcp:127.0.0.1:5002 --machine machine.toml
  beamtick info --link qemu
  beamtick bring-up --link serial:/dev/ttyACM0:3000000 --page bring-up.md
  beamtick completions bash > ~/.local/share/bash-completion/completions/beamtick

Exit codes: 0 done; 1 a call, the link or the trace failed; 2 the command line
or the job file is wrong; 130, 143, 129 ended by INT, TERM, HUP. However a job
ends, every laser is shut off and what moves is stopped smoothly.";

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Runs a job in the virtual controller, in virtual time.
    Sim(Sim),
    /// Runs a job on a board, real or emulated.
    Run(Run),
    /// Reads a job and shows what it would do, without a controller.
    ///
    /// It finds what is wrong with the text: names, numbers of parameters, values that their types
    /// do not hold, configuration files. Of G-code and drawings it also finds what leaves the
    /// travel of the machine. Limits of the controller and states are what `sim` finds: a power
    /// beyond its range, an axis that is off, a full FIFO, a soft limit.
    Check(Check),
    /// Runs the virtual controller in real time and serves it over TCP to other clients.
    Serve(Serve),
    /// Shows version, board, profile and limits of a controller; without --link, of the virtual
    /// one.
    Info(Info),
    /// Has a reference board with the bring-up image measure itself, and writes a page; with
    /// `--loads` adds how long the ticks of the board's own image take. Outputs
    /// move: connect no drive and no laser. docs/bring-up.md names the jumpers.
    BringUp(BringUp),
    /// Writes the job that a G-code program or a drawing is.
    Import(Import),
    /// Is a Grbl 1.1 controller for G-code senders, in front of the virtual controller or a board.
    Grbl(Grbl),
    /// Shows live what a controller does; with --command also moves it and runs G-code, by keys.
    Monitor(Monitor),
    /// Writes a machine file, or shows what one says.
    Machine(MachineFile),
    /// Draws a trace that was kept as a CSV.
    Plot(PlotFile),
    /// Prints the completions of a shell.
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
    /// Writes the manual pages, beamtick.1 and one for each command, into a folder.
    Man {
        /// The folder.
        folder: PathBuf,
    },
}

/// Servo ticks of the boards, us.
pub const TICKS_US: RangeInclusive<u32> = virtual_board::TICKS_US;

fn tick_parser() -> RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(i64::from(*TICKS_US.start())..=i64::from(*TICKS_US.end()))
}

/// Families of the laser manuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FamilyName {
    /// The GUS controllers.
    Gus,
    /// The earlier series.
    Lsr,
}

/// The controller's settings.
#[derive(Debug, Clone, Args)]
pub struct Settings {
    /// Servo tick in µs. A job may say it by `#pragma tick`, family and profile likewise.
    #[arg(long, value_name = "N", value_parser = tick_parser())]
    pub tick_us: Option<u32>,
    /// Family, which decides where the two laser manuals differ. Without it a job runs in gus, and
    /// `info` leaves the controller in its own.
    #[arg(long, value_enum)]
    pub family: Option<FamilyName>,
    /// Product profile: gus, gtn-016, gtn-024, gsn-008-lt, gsn-024, gsn-048, r688c-024, r688s-016,
    /// r688s-032. Without it, the first of these that has every core and axis of the job.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
}

/// What board the virtual controller is, as far as steps go.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Steps {
    /// What the virtual controller's step outputs make of an axis, pulse/ms: data that is faster is
    /// refused, an axis that follows and would be faster stops. The STM32H743 board has 1000.
    /// Without it, full scale.
    #[arg(long = "step-limit", value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 32))]
    pub limit: Option<u64>,
}

/// What the inputs do.
#[derive(Debug, Clone, Default, Args)]
pub struct InputFile {
    /// Sets the inputs of the virtual or the emulated board: a CSV with the columns t_ms, input,
    /// level. t_ms counts from the zero of the script clock (`serve`: from power-on) and never goes
    /// back. Inputs are gpi1, home1, limit_positive1, limit_negative1, alarm1, arrive1 with their
    /// numbers (core2_home1 on another core) and interlock, levels 0 and 1 at the terminal, before
    /// sense; and adc1, level in V. A board with wires refuses it. - is the standard input.
    #[arg(long, value_name = "FILE.csv")]
    pub inputs: Option<PathBuf>,
}

/// Panels on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PanelName {
    /// The mean acceleration from row to row.
    Acceleration,
    /// Planned position less encoder, on boards without wires (virtual, emulated).
    Error,
}

/// The panels that are asked for.
pub fn panels(names: &[PanelName]) -> Panels {
    Panels { acceleration: names.contains(&PanelName::Acceleration), error: names.contains(&PanelName::Error) }
}

/// What is recorded and shown.
#[derive(Debug, Clone, Args)]
#[command(group = ArgGroup::new("picture").args(["plot", "html", "xy"]).multiple(true))]
#[command(group = ArgGroup::new("path").args(["html", "xy"]).multiple(true))]
pub struct Outputs {
    /// Writes position and velocity of the axes used, gate, power and frequency of the lasers used,
    /// a row each tick.
    #[arg(long, value_name = "FILE.csv")]
    pub trace: Option<PathBuf>,
    /// Writes step, direction, digital and laser outputs, timescale 1 ns.
    #[arg(long, value_name = "FILE.vcd")]
    pub vcd: Option<PathBuf>,
    /// Draws the trace; the extension chooses SVG or PNG.
    #[arg(long, value_name = "FILE.svg|png")]
    pub plot: Option<PathBuf>,
    /// Writes the same as one page of HTML, in which time and path can be enlarged.
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// More panels of --plot and --html, with a comma between them.
    #[arg(long, value_name = "PANEL", value_enum, value_delimiter = ',', requires = "picture")]
    pub panels: Vec<PanelName>,
    /// Draws one axis over another, what a laser lit in the colour of its power; the extension
    /// chooses SVG or PNG.
    #[arg(long, value_name = "FILE.svg|png")]
    pub xy: Option<PathBuf>,
    /// The axes of --xy and of the page: across, then up. N is an axis of core 1; others are named
    /// as in a CSV, core2_axis1. Without it, the first two axes of the trace.
    #[arg(long, value_name = "X,Y", value_parser = axis_pair, requires = "path")]
    pub xy_axes: Option<(AxisName, AxisName)>,
    /// A row every N ticks. A link without a stream for the trace may need more; the summary shows
    /// it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: u32,
    /// The pictures begin at this time.
    #[arg(long, value_name = "MS", allow_negative_numbers = true, requires = "picture")]
    pub from: Option<f64>,
    /// The pictures end at this time.
    #[arg(long, value_name = "MS", allow_negative_numbers = true, requires = "picture")]
    pub to: Option<f64>,
    /// A late entry stops the job.
    #[arg(long)]
    pub strict: bool,
    /// Does not print what the job reads.
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub json: Json,
}

impl Outputs {
    /// Every file that is written: its option, its name, whether it is a picture.
    pub fn files(&self) -> Vec<(&str, &Path, bool)> {
        let all = [
            ("--trace", &self.trace, false),
            ("--vcd", &self.vcd, false),
            ("--plot", &self.plot, true),
            ("--html", &self.html, true),
            ("--xy", &self.xy, true),
        ];
        all.into_iter().filter_map(|(option, name, drawn)| Some((option, name.as_deref()?, drawn))).collect()
    }

    /// Some file needs a trace.
    pub fn traces(&self) -> bool {
        self.trace.is_some() || self.shows_edges()
    }

    /// Some file shows what lasers do between rows.
    pub fn shows_edges(&self) -> bool {
        self.vcd.is_some() || self.plot.is_some() || self.html.is_some() || self.xy.is_some()
    }
}

/// `beamtick plot`.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("drawn").args(["output", "html", "xy"]).multiple(true).required(true))]
#[command(override_usage = "beamtick plot [OPTIONS] <--output|--html|--xy FILE>... <TRACE>")]
pub struct PlotFile {
    /// The trace (docs/jobs.md), also one that was cut off; - is the standard input.
    pub trace: PathBuf,
    /// Draws it over time; the extension chooses SVG or PNG.
    #[arg(long, short, value_name = "FILE.svg|png")]
    pub output: Option<PathBuf>,
    /// Writes the same as one page of HTML, in which time and path can be enlarged.
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// More panels of --output and --html, with a comma between them.
    #[arg(long, value_name = "PANEL", value_enum, value_delimiter = ',')]
    pub panels: Vec<PanelName>,
    /// Draws one axis over another; the extension chooses SVG or PNG.
    #[arg(long, value_name = "FILE.svg|png")]
    pub xy: Option<PathBuf>,
    /// The axes of --xy and of the page: across, then up, as in `beamtick sim`.
    #[arg(long, value_name = "X,Y", value_parser = axis_pair)]
    pub xy_axes: Option<(AxisName, AxisName)>,
    /// The pictures begin at this time.
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// The pictures end at this time.
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Leaves out axes, lasers and paths that did nothing.
    #[arg(long)]
    pub used: bool,
}

/// How a G-code program or a drawing becomes a job.
#[derive(Debug, Clone, Default, Args)]
pub struct Drawing {
    /// The machine that a G-code program or a drawing is for; `beamtick machine new FILE` writes
    /// such a file. - is the standard input.
    #[arg(long, value_name = "FILE.toml")]
    pub machine: Option<PathBuf>,
    /// Of a machine with named lasers, [lasers.NAME]: the one that S of G-code sets, and that marks
    /// layers which name none. Without it, the first of the file.
    #[arg(long, value_name = "NAME")]
    pub laser: Option<String>,
    /// How strokes of a drawing are marked, with the keys of a [[layers]] of the machine file,
    /// before which it goes: power=80,speed=600, or
    /// colour=#ff0000,power=80,speed=600,passes=2,order=1, or colour=#0000ff,skip=true.
    #[arg(long = "layer", value_name = "KEY=VALUE,…")]
    pub layers: Vec<String>,
    /// Machine position of the lower left corner of a drawing's page (SVG) or of its origin (DXF),
    /// mm. Without it 0,0.
    #[arg(long, value_name = "X,Y", value_parser = point_mm, allow_hyphen_values = true)]
    pub at: Option<PointMm>,
    /// M0 of a G-code program goes on by itself, in the dark. Without it M0 is refused: a job asks
    /// nobody.
    #[arg(long)]
    pub pass_stops: bool,
}

impl Drawing {
    /// Some option of it is given.
    pub fn is_given(&self) -> bool {
        self.machine.is_some()
            || self.laser.is_some()
            || self.pass_stops
            || !self.layers.is_empty()
            || self.at.is_some()
    }
}

/// A point_mm, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMm(pub [f64; 2]);

fn point_mm(text: &str) -> Result<PointMm, String> {
    let number = |text: &str| text.trim().parse().ok().filter(|mm: &f64| mm.abs() <= 1e5);
    let pair = text.split_once(',').and_then(|(x, y)| Some(PointMm([number(x)?, number(y)?])));
    pair.ok_or_else(|| "it is X,Y in mm, each within ±100000".to_owned())
}

/// `beamtick import`.
#[derive(Debug, Args)]
pub struct Import {
    /// The G-code program (.nc, .gcode, .ngc, .tap) or the drawing (.svg, .dxf); - is the standard
    /// input.
    pub program: PathBuf,
    /// The job to write; - is the standard output.
    #[arg(long, short, value_name = "FILE.gts")]
    pub output: PathBuf,
    /// Draws the path in mm: travel, marks, and what leaves the travel of the machine; the
    /// extension chooses SVG or PNG.
    #[arg(long, value_name = "FILE.svg|png")]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub drawing: Drawing,
}

/// `beamtick sim`.
#[derive(Debug, Args)]
pub struct Sim {
    /// The job file, a G-code program (.nc, .gcode, .ngc, .tap) or a drawing (.svg, .dxf);
    /// - is the standard input, whatever its text is.
    pub job: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub drawing: Drawing,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub settings: Settings,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub steps: Steps,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub inputs: InputFile,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub outputs: Outputs,
}

/// A port for viewers.
#[derive(Debug, Clone, Default, Args)]
pub struct ShareOptions {
    /// Lets others look meanwhile, as `beamtick monitor --link tcp:HOST:PORT` does: reads are
    /// answered there, and nothing else. Port 0 takes a free one.
    #[arg(long, value_name = "HOST:PORT")]
    pub share: Option<String>,
}

/// The link to a controller.
#[derive(Debug, Clone, Args)]
pub struct LinkOptions {
    /// Image for --link qemu; else the environment's BEAMTICK_IMAGE, else
    /// target/thumbv7em-none-eabihf/image/beamtick-mps2 here or in a folder above,
    /// else the one in images/ of the unpacked release.
    #[arg(long, value_name = "FILE", env = "BEAMTICK_IMAGE")]
    pub image: Option<PathBuf>,
}

/// `beamtick run`.
#[derive(Debug, Args)]
pub struct Run {
    /// The job file, a G-code program (.nc, .gcode, .ngc, .tap) or a drawing (.svg, .dxf);
    /// - is the standard input, whatever its text is.
    pub job: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub drawing: Drawing,
    /// tcp:HOST:PORT, serial:PATH[:BAUD] (without BAUD 921600), qemu, or virtual: a virtual
    /// controller in real time.
    /// Without it, the link of the machine file; if that names none, virtual.
    #[arg(long)]
    pub link: Option<String>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub link_options: LinkOptions,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub share: ShareOptions,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub settings: Settings,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub inputs: InputFile,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub outputs: Outputs,
}

/// `beamtick grbl`.
#[derive(Debug, Args)]
pub struct Grbl {
    /// The machine; `beamtick machine new FILE` writes such a file. Its axes stand at home when
    /// this begins.
    #[arg(long, value_name = "FILE.toml")]
    pub machine: PathBuf,
    /// Of a machine with named lasers, [lasers.NAME]: the one that S sets; the other one stays
    /// dark. Without it, the first of the file.
    #[arg(long, value_name = "NAME")]
    pub laser: Option<String>,
    /// tcp:HOST:PORT, serial:PATH[:BAUD] (without BAUD 921600), qemu, or virtual: a virtual
    /// controller in real time.
    /// Without it, the link of the machine file; if that names none, virtual.
    #[arg(long)]
    pub link: Option<String>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub link_options: LinkOptions,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub share: ShareOptions,
    /// Where senders connect; port 0 takes a free one.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:5001")]
    pub listen: String,
    /// Senders open a pseudo-terminal instead, whose name is shown.
    #[arg(long, conflicts_with = "listen")]
    pub pty: bool,
    /// M0 goes on by itself, in the dark. Without it M0 waits for `~`.
    #[arg(long)]
    pub pass_stops: bool,
    /// Servo tick in µs.
    #[arg(long, value_name = "N", value_parser = tick_parser())]
    pub tick_us: Option<u32>,
}

/// `beamtick check`.
#[derive(Debug, Args)]
pub struct Check {
    /// The job file, a G-code program (.nc, .gcode, .ngc, .tap) or a drawing (.svg, .dxf);
    /// - is the standard input, whatever its text is.
    pub job: PathBuf,
    /// Draws the path of a program or a drawing in mm: travel, marks, and what leaves the travel of
    /// the machine; the extension chooses SVG or PNG.
    #[arg(long, value_name = "FILE.svg|png")]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub drawing: Drawing,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub json: Json,
}

/// `beamtick info`.
#[derive(Debug, Args)]
pub struct Info {
    /// tcp:HOST:PORT, serial:PATH[:BAUD] (without BAUD 921600), or qemu; without it, the virtual
    /// controller.
    #[arg(long)]
    pub link: Option<String>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub link_options: LinkOptions,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub settings: Settings,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub json: Json,
}

/// `beamtick machine`.
#[derive(Debug, Args)]
pub struct MachineFile {
    /// What to do.
    #[command(subcommand)]
    pub action: MachineAction,
}

/// What to do with a machine file.
#[derive(Debug, Subcommand)]
pub enum MachineAction {
    /// Asks what the machine is, and writes a file with comments.
    New(NewMachine),
    /// Reads a file, and shows what it says in mm.
    Check {
        /// The machine file; - is the standard input.
        file: PathBuf,
    },
}

/// `beamtick machine new`.
#[derive(Debug, Args)]
pub struct NewMachine {
    /// The file to write, which must not exist; - is the standard output, with --yes.
    pub file: PathBuf,
    /// Asks nothing and takes the usual answers, but for those of --set.
    #[arg(long)]
    pub yes: bool,
    /// The axes: XY or XYZ.
    #[arg(long, value_name = "LETTERS", default_value = "XY", value_parser = ["XY", "XYZ"])]
    pub axes: String,
    /// The machine has no laser.
    #[arg(long)]
    pub no_laser: bool,
    /// An answer, as axes.x.steps_per_mm=160. It is not asked for then.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// `beamtick serve`.
#[derive(Debug, Args)]
pub struct Serve {
    /// Where to listen; port 0 takes a free one.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:5000")]
    pub listen: String,
    /// Servo tick at power-on in µs.
    #[arg(long, value_name = "N", value_parser = tick_parser())]
    pub tick_us: Option<u32>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub steps: Steps,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub inputs: InputFile,
    /// Profile at power-on. Without it the board has room for every profile; with one of 8 axes,
    /// for 8 axes only.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
}

/// Two names of axes.
fn axis_pair(text: &str) -> Result<(AxisName, AxisName), String> {
    let wrong = || "two axes are 1,2, or as the columns of a CSV name them: axis1,core2_axis1".to_owned();
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    let pair = (axis_name(x).ok_or_else(wrong)?, axis_name(y).ok_or_else(wrong)?);
    if pair.0 == pair.1 { Err("both are the same axis; two axes are 1,2".to_owned()) } else { Ok(pair) }
}

/// `N`, `axisN` or `coreM_axisN`, from 1.
fn axis_name(text: &str) -> Option<AxisName> {
    let text = text.trim();
    let (core, axis) = match text.strip_prefix("core") {
        None => ("1", text.strip_prefix("axis").unwrap_or(text)),
        Some(named) => named.split_once("_axis")?,
    };
    let number = |text: &str| text.parse().ok().filter(|&number: &u8| number > 0);
    Some(AxisName { core: number(core)?, axis: number(axis)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_named_as_in_a_csv_or_by_a_number() {
        let axis = |core, axis| AxisName { core, axis };
        assert_eq!(axis_pair("1,2"), Ok((axis(1, 1), axis(1, 2))));
        assert_eq!(axis_pair("axis3, core2_axis1"), Ok((axis(1, 3), axis(2, 1))));
        for wrong in ["", "1", "1,", "1,2,3", "0,1", "1,x", "core_axis1,1", "core2axis1,1", "300,1", "-1,2", "2,2"] {
            assert!(axis_pair(wrong).is_err(), "{wrong}");
        }
    }
}
