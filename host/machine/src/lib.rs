#![forbid(unsafe_code)]
//! The machine file: what a drawing or a G-code program must know about the machine, in mm.
//!
//! In: a TOML text. Out: a [`Machine`], whose values all lie within their limits. Owns nothing.
//! Fails with a text that names file, line, key and limit. [`questions`] and [`write`] make a new
//! file from answers. `docs/machine.md` is the user's page.

mod file;
mod layers;
mod show;
mod template;

pub use layers::{Colour, Layer, LightMode};
pub use show::show;
pub use template::{Question, is_value, questions, suit_laser, write};

/// Letters that an axis may have, in the order of coordinates.
pub const LETTERS: [char; 3] = ['X', 'Y', 'Z'];
/// Decimals of `steps_per_mm` that count.
pub const STEP_DECIMALS: u32 = 9;

/// A machine: all in mm, as people measure it.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Laser family: where the two manuals differ.
    pub family: Family,
    /// Link of `beamtick run`, where the command line names none; none is the virtual board.
    pub link: Option<String>,
    /// X, Y and, where the machine has it, Z.
    pub axes: Vec<Axis>,
    /// Its lasers, in the order of the file: none, one, or two.
    pub lasers: Vec<Laser>,
    /// The laser of G-code, and of layers that name none: an index of `lasers`.
    pub chosen: usize,
    /// How corners and curves are run.
    pub path: Path,
    /// General outputs for M7 and M8.
    pub outputs: Outputs,
    /// How strokes of drawings are marked; the first that takes a stroke counts.
    pub layers: Vec<Layer>,
}

/// Where the two laser manuals differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// The GUS controllers.
    #[default]
    Gus,
    /// The earlier series.
    Lsr,
}

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// `X`, `Y` or `Z`.
    pub letter: char,
    /// Axis of the controller, 1 to 8: a path moves no other one (SPEC 5).
    pub number: u8,
    /// Pulses a mm, above 0.
    pub steps_per_mm: f64,
    /// The axis counts down where the letter counts up.
    pub reversed: bool,
    /// Least and greatest machine position, mm.
    pub travel: (f64, f64),
    /// Greatest speed, mm/min.
    pub max_rate: f64,
    /// Greatest acceleration, mm/s².
    pub acceleration: f64,
    /// Machine position where the axis stands when a job begins, mm.
    pub home: f64,
    /// Limit inputs in use.
    pub limits: Limits,
    /// The drive's alarm input is in use.
    pub alarm: bool,
}

/// Limit inputs in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Limits {
    /// None.
    #[default]
    None,
    /// The one that the axis meets going up.
    Positive,
    /// The one that it meets going down.
    Negative,
    /// Both.
    Both,
}

/// How the laser's energy is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// The duty of a carrier, %.
    Duty,
    /// The rate of pulses of one width, kHz.
    Frequency,
    /// A voltage, V.
    Analog,
}

/// The laser.
#[derive(Debug, Clone, PartialEq)]
pub struct Laser {
    /// Its name, if the file gives it one: `cut` of `[lasers.cut]`.
    pub name: Option<String>,
    /// Channel of the controller, 0 or 1.
    pub channel: u8,
    /// How its energy is set.
    pub mode: Mode,
    /// Carrier of the duty mode, kHz; 0 in others.
    pub carrier_khz: f64,
    /// Pulse width of the frequency mode, µs; 0 in others.
    pub pulse_width_us: u16,
    /// Power at S = 0 and at S = `s_max`: %, kHz or V. S0 itself is dark.
    pub power: (f64, f64),
    /// The S of full power.
    pub s_max: f64,
    /// The light begins so much after the path's boundary, µs.
    pub on_delay_us: u16,
    /// The light ends so much after the path's boundary, µs.
    pub off_delay_us: u16,
}

/// How corners and curves are run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    /// By so much the machine may round a corner, mm: it decides the speed there.
    pub junction_deviation: f64,
    /// Curves that are no arcs of the controller become lines that are so near, mm.
    pub arc_tolerance: f64,
}

impl Default for Path {
    fn default() -> Self {
        Path { junction_deviation: 0.02, arc_tolerance: 0.002 }
    }
}

/// General outputs that M codes switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outputs {
    /// M7, from 1.
    pub mist: Option<u8>,
    /// M8, from 1.
    pub flood: Option<u8>,
}

impl Machine {
    /// Reads the text of the file `name`.
    ///
    /// # Errors
    /// What is wrong: file, line, key, limit, and what to do.
    pub fn read(name: &str, text: &str) -> Result<Machine, String> {
        file::read(name, text, None)
    }

    /// The same. G-code, and layers that name no laser, take `laser` instead of the first one.
    ///
    /// # Errors
    /// As [`Machine::read`]; there is no laser of that name.
    pub fn read_for(name: &str, text: &str, laser: Option<&str>) -> Result<Machine, String> {
        file::read(name, text, laser)
    }

    /// Layers from `KEY=VALUE,KEY=VALUE` go before those of the file.
    ///
    /// # Errors
    /// What is wrong with one: its key, the limit.
    pub fn add_layers(&mut self, given: &[String]) -> Result<(), String> {
        let mut all = given.iter().map(|text| layers::given(text, self)).collect::<Result<Vec<Layer>, String>>()?;
        all.append(&mut self.layers);
        self.layers = all;
        Ok(())
    }

    /// The laser of G-code, and of layers that name none.
    pub fn laser(&self) -> Option<&Laser> {
        self.lasers.get(self.chosen)
    }

    /// The axis of this letter.
    pub fn axis(&self, letter: char) -> Option<&Axis> {
        self.axes.iter().find(|axis| axis.letter == letter)
    }
}

impl Axis {
    /// Greatest speed, pulse/ms.
    pub fn rate(&self) -> f64 {
        self.max_rate / 60_000.0 * self.steps_per_mm
    }

    /// Greatest acceleration, pulse/ms².
    pub fn pulse_acceleration(&self) -> f64 {
        self.acceleration / 1e6 * self.steps_per_mm
    }
}

impl Laser {
    /// Its table of the file.
    pub fn table(&self) -> String {
        self.name.as_ref().map_or_else(|| "laser".to_owned(), |name| format!("lasers.{name}"))
    }

    /// The unit of its powers.
    pub fn unit(&self) -> &'static str {
        match self.mode {
            Mode::Duty => "%",
            Mode::Frequency => "kHz",
            Mode::Analog => "V",
        }
    }
}
