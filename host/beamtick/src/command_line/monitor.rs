//! The arguments of `beamtick monitor`.
use super::LinkOptions;
use clap::Args;
use std::path::PathBuf;

/// `beamtick monitor`.
#[derive(Debug, Args)]
#[command(after_help = MONITOR_KEYS)]
pub struct Monitor {
    /// With --command: a G-code program (.nc, .gcode, .ngc, .tap), which `s` starts.
    #[arg(requires = "command")]
    pub program: Option<PathBuf>,
    /// To look: tcp:HOST:PORT, of `beamtick serve` or of a --share. With --command also
    /// serial:PATH[:BAUD] (without BAUD 921600), qemu or virtual. Without it tcp:127.0.0.1:5000;
    /// with --command the link of the machine file, and if that names none, virtual.
    #[arg(long)]
    pub link: Option<String>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub link_options: LinkOptions,
    /// The machine: positions and speeds are shown in mm. Without it, in pulses.
    #[arg(long, value_name = "FILE.toml")]
    pub machine: Option<PathBuf>,
    /// With --command, of a machine with named lasers: the one that S sets. Without it, the first
    /// of the file.
    #[arg(long, value_name = "NAME", requires = "command")]
    pub laser: Option<String>,
    /// Takes the controller, so that the keys act. Its axes stand at home when this begins. Without
    /// it this only looks, in a read-only session.
    #[arg(long, requires = "machine")]
    pub command: bool,
    /// Prints the block once as text, and ends.
    #[arg(long, conflicts_with = "command")]
    pub once: bool,
    /// Prints one JSON object in a line, and ends; docs/json.md says what is in it.
    #[arg(long, conflicts_with = "command")]
    pub json: bool,
}

const MONITOR_KEYS: &str = "\
Keys: q ends. With --command:
  space         hold: the path comes to rest on itself, dark; ends a jog
  g             go on after a hold
  x             stop: dark at once, everything brakes
  s             start the program from its first line
  f             frame: walk round what the program marks, in the dark
  z             set zero: X0 Y0 of the program are here
  arrows        jog X and Y; PageUp and PageDown: Z; in the dark
  + -           a longer or a shorter jog
  u             unlock after an alarm
With --command, the end of the monitor stops everything.";
