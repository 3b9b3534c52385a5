//! The command line.
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Runs motion jobs in the virtual controller or on a Beamtick board.
///
/// A job is a text file (.gts) in the notation of the controller manuals; docs/jobs.md describes it.
#[derive(Debug, Parser)]
#[command(version, after_help = EXAMPLES)]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  beamtick check examples/pt_static.gts
  beamtick sim examples/pt_static.gts --trace t.csv --plot t.png
  beamtick sim examples/pt_dynamic.gts --tick-us 50 --plot zoom.svg --from 900 --to 1100
  beamtick sim examples/laser_duty.gts --plot pulses.png --from 10 --to 12
  beamtick run examples/pt_static.gts --link qemu --vcd t.vcd
  beamtick run examples/jog_trap.gts --link tcp:192.168.1.20:5000 --strict
  beamtick run examples/jog_trap.gts --link serial:/dev/ttyACM0:921600
  beamtick serve --listen 127.0.0.1:5000
  beamtick info --link qemu

Exit codes: 0 done; 1 a call, the link or the trace failed; 2 the command line or the job file is wrong.";

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Runs a job in the virtual controller, in virtual time.
    Sim(Sim),
    /// Runs a job on a board, real or emulated.
    Run(Run),
    /// Reads a job and shows what it would do, without a controller.
    Check(Check),
    /// Runs the virtual controller in real time and serves it over TCP to other clients.
    Serve(Serve),
    /// Shows version, board, profile and limits of a controller; without --link, of the virtual one.
    Info(Info),
}

/// Families of the laser manuals.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum FamilyName {
    /// The GUS controllers.
    Gus,
    /// The earlier series.
    Lsr,
}

/// The controller's settings.
#[derive(Debug, Clone, Args)]
pub struct Settings {
    /// Servo tick in µs.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=1000))]
    pub tick_us: Option<u32>,
    /// Family, which decides where the two laser manuals differ. Without it a job runs in gus, and `info` leaves the
    /// controller in its own.
    #[arg(long, value_enum)]
    pub family: Option<FamilyName>,
    /// Product profile: gus, gtn-016, gtn-024, gsn-008-lt, gsn-024, gsn-048, r688c-024, r688s-016, r688s-032.
    /// Without it, the first of these that has every core and axis of the job.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
}

/// What is recorded and shown.
#[derive(Debug, Clone, Args)]
pub struct Outputs {
    /// Writes position and velocity of the axes used, gate, power and frequency of the lasers used, a row each tick.
    #[arg(long, value_name = "FILE.csv")]
    pub trace: Option<PathBuf>,
    /// Writes step, direction, digital and laser outputs, timescale 1 ns.
    #[arg(long, value_name = "FILE.vcd")]
    pub vcd: Option<PathBuf>,
    /// Draws the trace; the extension chooses SVG or PNG.
    #[arg(long, value_name = "FILE.svg|png")]
    pub plot: Option<PathBuf>,
    /// A row every N ticks. A link without a stream for the trace may need more; the summary shows it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: u32,
    /// The plot begins at this time.
    #[arg(long, value_name = "MS", allow_negative_numbers = true, requires = "plot")]
    pub from: Option<f64>,
    /// The plot ends at this time.
    #[arg(long, value_name = "MS", allow_negative_numbers = true, requires = "plot")]
    pub to: Option<f64>,
    /// A late entry stops the job.
    #[arg(long)]
    pub strict: bool,
    /// Does not print what the job reads.
    #[arg(long, short)]
    pub quiet: bool,
}

impl Outputs {
    /// Some file needs a trace.
    pub fn traces(&self) -> bool {
        self.trace.is_some() || self.vcd.is_some() || self.plot.is_some()
    }
}

/// `beamtick sim`.
#[derive(Debug, Args)]
pub struct Sim {
    /// The job file.
    pub job: PathBuf,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub settings: Settings,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub outputs: Outputs,
}

/// The way to a controller.
#[derive(Debug, Clone, Args)]
pub struct Way {
    /// Image for --link qemu; else the environment's BEAMTICK_IMAGE, else
    /// target/thumbv7em-none-eabihf/image/beamtick-mps2 here or in a folder above.
    #[arg(long, value_name = "FILE", env = "BEAMTICK_IMAGE")]
    pub image: Option<PathBuf>,
}

/// `beamtick run`.
#[derive(Debug, Args)]
pub struct Run {
    /// The job file.
    pub job: PathBuf,
    /// tcp:HOST:PORT, serial:PATH[:BAUD], or qemu.
    #[arg(long)]
    pub link: String,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub way: Way,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub settings: Settings,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub outputs: Outputs,
}

/// `beamtick check`.
#[derive(Debug, Args)]
pub struct Check {
    /// The job file.
    pub job: PathBuf,
}

/// `beamtick info`.
#[derive(Debug, Args)]
pub struct Info {
    /// tcp:HOST:PORT, serial:PATH[:BAUD], or qemu; without it, the virtual controller.
    #[arg(long)]
    pub link: Option<String>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub way: Way,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub settings: Settings,
}

/// `beamtick serve`.
#[derive(Debug, Args)]
pub struct Serve {
    /// Where to listen; port 0 takes a free one.
    #[arg(long, value_name = "HOST:PORT", default_value = "127.0.0.1:5000")]
    pub listen: String,
    /// Servo tick at power-on in µs.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=1000))]
    pub tick_us: Option<u32>,
    /// Profile at power-on. Without it the board has room for every profile; with one of 8 axes, for 8 axes only.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<String>,
}
