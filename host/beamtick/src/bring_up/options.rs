//! The command line of `beamtick bring-up`.
//!
//! In: words. Out: [`BringUp`]. Owns nothing. Fails as clap does, and with a time of `--soak` that
//! is none.
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// A time of `--soak`, in seconds: minutes, or seconds with an s.
fn soak_parser(text: &str) -> Result<u32, String> {
    let (number, unit) = text.strip_suffix('s').map_or((text, 60), |number| (number, 1));
    let seconds = number.parse::<u32>().ok().and_then(|number| number.checked_mul(unit));
    seconds
        .filter(|seconds| (1..=86_400).contains(seconds))
        .ok_or_else(|| "1 to 1440 minutes, or 1s to 86400s".to_owned())
}

/// A board with an image of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AnsweringBoard {
    /// NUCLEO-H743ZI2, over CN13.
    Nucleo,
    /// A module with an STM32H743VI, over its USB or over its UART.
    Module,
}

/// What a hand does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ByHand {
    /// A debugger halts the core for two seconds; the board's own image.
    Halt,
    /// The Nucleo is supplied by VIN, and CN1 is unplugged for 10 s or more; the board's own image.
    Unplug,
    /// The ST-LINK is held in reset under light; the bring-up image.
    Clock,
    /// A voltmeter at the analog outputs; the image for an external DAC.
    Dac,
}

/// `beamtick bring-up`.
#[derive(Debug, Args)]
pub struct BringUp {
    /// serial:PATH:3000000, the ST-LINK's port. Without a rate it is opened at 921600, at which
    /// that port hears no image.
    #[arg(long)]
    pub link: String,
    /// The board runs its own image: measures how long its servo ticks take under loads.
    #[arg(long)]
    pub loads: bool,
    /// Then keeps all streams and the link busy for so many minutes (60) or seconds (30s), and
    /// counts what the link lost.
    #[arg(long, value_name = "TIME", requires = "loads", value_parser = soak_parser)]
    pub soak: Option<u32>,
    /// The board, which runs its own image: does it answer over this link? Nothing moves.
    #[arg(long, value_name = "BOARD", conflicts_with_all = ["loads", "hands", "soak"])]
    pub answers: Option<AnsweringBoard>,
    /// Says what a hand has to do, waits for Enter, and judges; docs/bring-up.md names the image.
    #[arg(long, value_name = "WHAT", conflicts_with_all = ["loads", "soak"])]
    pub hands: Option<ByHand>,
    /// Writes the page to this file instead of the standard output.
    #[arg(long, value_name = "FILE.md")]
    pub page: Option<PathBuf>,
}
