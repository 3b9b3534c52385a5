//! The modal state of a program, and what each line does with it.
//!
//! In: lines. Out: strokes, dwells and outputs for the writer, notes. Owns the state of RS274:
//! offsets, modes, the exact position in the machine. Within a line things are done in the order of
//! RS274; units count for the whole line, as in Grbl.
use crate::Options;
use crate::block::{Block, Motion, Once, Spindle, Stop};
use crate::words;
use machine::{LETTERS, Machine};
use std::io::{self, BufRead, Write};
use strokes::arc::Arc;
use strokes::exact::{ONE, inches, of_f64, rounded, to_f64};
use strokes::{Light, Shape, Stroke, Writer};

/// A machine position.
pub type Point = [i128; 3];

/// Axes of a plane, first and second, and the one across it.
const PLANES: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];
/// The longest dwell, s.
const DWELL_MAX_S: i128 = 86_400 * ONE;

/// The state of RS274.
#[derive(Clone)]
pub struct State<'a> {
    machine: &'a Machine,
    /// Least and greatest machine position of X, Y, Z; none where there is no axis.
    travel: [Option<(i128, i128)>; 3],
    pub motion: Motion,
    pub plane: usize,
    pub inch: bool,
    pub incremental: bool,
    pub centre_absolute: bool,
    pub inverse: bool,
    /// mm/min, or 1/min in inverse time; 0 where it was not given.
    pub feed: i128,
    pub speed: i128,
    pub spindle: Spindle,
    pub system: usize,
    pub systems: [Point; 6],
    /// G92: in force, and stored.
    pub offset: Point,
    pub offset_stored: Point,
    pub tool: Point,
    pub homes: [Point; 2],
    pub at: Point,
    /// What a sender makes of S: 1 as it is.
    pub power_override: f64,
}

/// Bytes of a job that are written together.
const BLOCK_BYTES: usize = 1 << 16;

/// The job cannot be written.
pub fn unkept(name: &str, error: &io::Error) -> String {
    format!("{name}: the job cannot be kept: {error}; nothing was run")
}

/// Whether a file that begins so is UTF-16: by its byte order mark, or by a letter of two bytes.
fn is_utf16(row: &[u8]) -> bool {
    matches!(row, [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [b'\t'..=b'~', 0, ..] | [0, b'\t'..=b'~', ..])
}

/// Runs a program; the job goes to `to`, but for the end of it, which the writer has.
pub fn run(
    name: &str,
    program: &mut dyn BufRead,
    machine: &Machine,
    options: Options,
    writer: &mut Writer<'_>,
    to: &mut dyn Write,
) -> Result<Vec<String>, String> {
    let mut state = State::new(machine);
    let mut notes: Vec<(usize, String)> = Vec::new();
    let (mut bare, mut found) = (Vec::new(), Vec::new());
    let (mut begun, mut ended) = (false, false);
    let (mut row, mut number) = (Vec::new(), 0);
    'program: loop {
        row.clear();
        let count = program.read_until(b'\n', &mut row);
        if count.map_err(|error| format!("{name}: the program cannot be read: {error}"))? == 0 {
            break;
        }
        if number == 0 && is_utf16(&row) {
            return Err(format!("{name}: the file is UTF-16 text; save it as UTF-8; nothing was run"));
        }
        if writer.size() >= BLOCK_BYTES {
            to.write_all(writer.taken().as_bytes()).map_err(|error| unkept(name, &error))?;
        }
        // Some files end their lines with CR alone.
        let lines = String::from_utf8_lossy(&row);
        for line in lines.trim_matches(['\r', '\n']).split('\r') {
            number += 1;
            let mut note = |text: &str| {
                if !notes.iter().any(|(_, other)| other == text) {
                    notes.push((number, text.to_owned()));
                }
            };
            let trimmed = line.trim_matches(|letter: char| letter.is_whitespace() || letter == '\u{feff}');
            if trimmed.is_empty() {
                continue;
            }
            if ended && trimmed.starts_with('%') {
                break 'program;
            }
            if ended {
                note("the program has ended; this line and those after it are not run");
                break 'program;
            }
            if trimmed.starts_with('%') {
                ended = begun;
                begun = true;
                continue;
            }
            if trimmed.starts_with('$') {
                note("lines that begin with $ are for a sender and are passed over");
                continue;
            }
            let done = words::read(trimmed, &mut bare, &mut found)
                .and_then(|()| Block::of(&found))
                .and_then(|block| state.line(&block, number, options, writer, &mut note));
            ended = done.map_err(|why| format!("{name}:{number}: {why}; nothing was run"))?;
            // Comments may stand before the first `%`.
            begun |= !found.is_empty();
        }
    }
    Ok(notes.into_iter().map(|(number, note)| format!("{name}:{number}: note: {note}")).collect())
}

impl<'a> State<'a> {
    pub fn new(machine: &'a Machine) -> State<'a> {
        let of = |letter: char| machine.axis(letter);
        let home = LETTERS.map(|letter| of(letter).map_or(0, |axis| of_f64(axis.home)));
        let travel = LETTERS.map(|letter| of(letter).map(|axis| (of_f64(axis.travel.0), of_f64(axis.travel.1))));
        State {
            machine,
            travel,
            motion: Motion::Rapid,
            plane: 0,
            inch: false,
            incremental: false,
            centre_absolute: false,
            inverse: false,
            feed: 0,
            speed: 0,
            spindle: Spindle::Off,
            system: 0,
            systems: [[0; 3]; 6],
            offset: [0; 3],
            offset_stored: [0; 3],
            tool: [0; 3],
            homes: [home; 2],
            at: home,
            power_override: 1.0,
        }
    }

    /// Least and greatest machine position of an axis that there is.
    pub fn travel(&self, axis: usize) -> Option<(i128, i128)> {
        self.travel[axis]
    }

    /// A length of the program in mm.
    fn mm(&self, number: i128) -> i128 {
        if self.inch { inches(number) } else { number }
    }

    /// Does a line; true where the program ends.
    pub fn line(
        &mut self,
        block: &Block,
        number: usize,
        options: Options,
        writer: &mut Writer<'_>,
        note: &mut dyn FnMut(&str),
    ) -> Result<bool, String> {
        for (word, (travel, letter)) in block.xyz.iter().zip(self.travel.iter().zip(LETTERS)) {
            if word.is_some() && travel.is_none() {
                return Err(format!(
                    "{letter} is moved, and the machine file has no [axes.{}]",
                    letter.to_ascii_lowercase()
                ));
            }
        }
        if let Some(inch) = block.inch {
            self.inch = inch;
        }
        self.feeds(block)?;
        self.light_words(block, note)?;
        if let Some(motion) = block.motion {
            self.motion = motion;
        }
        self.coolant(block, writer, note);
        if block.dwell {
            self.dwell(block, number, writer)?;
        }
        if let Some(plane) = block.plane {
            self.plane = plane;
        }
        self.offsets(block, note)?;
        if let Some(incremental) = block.incremental {
            self.incremental = incremental;
        }
        if let Some(absolute) = block.centre_absolute {
            self.centre_absolute = absolute;
        }
        if let Some(once) = block.once {
            self.once(once, block, number, writer)?;
        }
        self.motion(block, number, writer)?;
        match block.stop {
            Some(Stop::Pause) if !options.pass_stops => {
                Err("M0 waits for an operator, and a job asks nobody; --pass-stops goes on by itself".to_owned())
            }
            Some(Stop::Pause | Stop::Optional) => {
                if block.stop == Some(Stop::Optional) {
                    note("M1 does nothing: the switch for optional stops is off");
                } else {
                    note("M0 goes on by itself, in the dark");
                    writer.dwell(number, 1, Light::Dark);
                }
                Ok(false)
            }
            Some(Stop::End) => {
                self.coolant_off(writer);
                Ok(true)
            }
            None => Ok(false),
        }
    }

    fn feeds(&mut self, block: &Block) -> Result<(), String> {
        if let Some(inverse) = block.inverse {
            if inverse != self.inverse {
                self.feed = 0;
            }
            self.inverse = inverse;
        }
        if let Some(feed) = block.f {
            if feed < 0 {
                return Err("F is below 0".to_owned());
            }
            self.feed = if self.inverse { feed } else { self.mm(feed) };
        }
        Ok(())
    }

    fn light_words(&mut self, block: &Block, note: &mut dyn FnMut(&str)) -> Result<(), String> {
        if let Some(speed) = block.s {
            if speed < 0 {
                return Err("S is below 0".to_owned());
            }
            self.speed = speed;
        }
        if block.t {
            note("T is passed over: there are no tools");
        }
        if let Some(spindle) = block.spindle {
            if spindle != Spindle::Off && self.machine.laser().is_none() {
                return Err("M3 and M4 switch the laser, and the machine file has no [laser]".to_owned());
            }
            self.spindle = spindle;
        }
        let most = self.machine.laser().map_or(f64::INFINITY, |laser| laser.s_max);
        if self.spindle != Spindle::Off && to_f64(self.speed) > most {
            note("S is above s_max of the machine file; it is taken as s_max");
        }
        Ok(())
    }

    fn coolant(&self, block: &Block, writer: &mut Writer<'_>, note: &mut dyn FnMut(&str)) {
        let outputs = self.machine.outputs;
        for (asked, output, name) in [(block.mist, outputs.mist, "M7"), (block.flood, outputs.flood, "M8")] {
            match output {
                Some(output) if asked => writer.output(output, true),
                None if asked => note(&format!("{name} does nothing: the machine file has no output for it")),
                _ => {}
            }
        }
        if block.coolant_off {
            self.coolant_off(writer);
        }
    }

    /// M9, which M2 and M30 do too.
    fn coolant_off(&self, writer: &mut Writer<'_>) {
        for output in [self.machine.outputs.mist, self.machine.outputs.flood].into_iter().flatten() {
            writer.output(output, false);
        }
    }

    fn dwell(&self, block: &Block, number: usize, writer: &mut Writer<'_>) -> Result<(), String> {
        let Some(seconds) = block.p else { return Err("G4 needs P, in seconds".to_owned()) };
        if !(0..=DWELL_MAX_S).contains(&seconds) {
            return Err("G4 P is 0 to 86400 seconds".to_owned());
        }
        // Constant light stays on at standstill while a feed motion is modal; light that follows
        // the speed does not.
        let light = if self.spindle == Spindle::Constant { self.light() } else { Light::Dark };
        writer.dwell(number, rounded(seconds * 1000, ONE) as u64, light);
        Ok(())
    }

    /// The light of the modal motion.
    fn light(&self) -> Light {
        let Some(laser) = self.machine.laser() else { return Light::Dark };
        if self.speed == 0 || matches!(self.motion, Motion::Rapid | Motion::Off) {
            return Light::Dark;
        }
        let part = (to_f64(self.speed) / laser.s_max * self.power_override).min(1.0);
        let power = laser.power.0 + (laser.power.1 - laser.power.0) * part;
        match self.spindle {
            Spindle::Off => Light::Dark,
            Spindle::Constant => Light::Constant(power),
            Spindle::Follow => Light::Follow(power),
        }
    }

    fn offsets(&mut self, block: &Block, note: &mut dyn FnMut(&str)) -> Result<(), String> {
        match block.tool {
            Some(true) if !block.names_axes() => return Err("G43.1 needs an axis word".to_owned()),
            Some(true) => {
                for axis in 0..3 {
                    if let Some(word) = block.xyz[axis] {
                        self.tool[axis] = self.mm(word);
                    }
                }
            }
            Some(false) => self.tool = [0; 3],
            None => {}
        }
        if let Some(system) = block.system {
            self.system = system;
        }
        if block.control == Some(true) && block.p.is_some() {
            note("G64 P does nothing: a path goes through its corners exactly, as fast as junction_deviation says");
        }
        Ok(())
    }

    fn once(&mut self, once: Once, block: &Block, number: usize, writer: &mut Writer<'_>) -> Result<(), String> {
        match once {
            Once::Data => self.data(block)?,
            Once::SetHome(place) => self.homes[place] = self.at,
            Once::Home(place) => {
                let named = block.xyz.map(|word| word.is_some());
                let all = !block.names_axes();
                if !all {
                    let between = self.target(block);
                    self.go(number, between, Shape::Line, None, Light::Dark, writer)?;
                }
                let mut to = self.at;
                for axis in 0..3 {
                    if all || named[axis] {
                        to[axis] = self.homes[place][axis];
                    }
                }
                self.go(number, to, Shape::Line, None, Light::Dark, writer)?;
            }
            Once::Offset => {
                if !block.names_axes() {
                    return Err("G92 needs an axis word".to_owned());
                }
                for axis in 0..3 {
                    if let Some(word) = block.xyz[axis] {
                        let others = self.systems[self.system][axis] + self.tool[axis];
                        self.offset[axis] = self.at[axis] - others - self.mm(word);
                    }
                }
                self.offset_stored = self.offset;
            }
            Once::OffsetReset => (self.offset, self.offset_stored) = ([0; 3], [0; 3]),
            Once::OffsetOff => self.offset = [0; 3],
            Once::OffsetOn => self.offset = self.offset_stored,
        }
        Ok(())
    }

    /// G10 L2 and L20.
    fn data(&mut self, block: &Block) -> Result<(), String> {
        let (Some(kind), Some(system)) = (block.l, block.p) else { return Err("G10 needs L and P".to_owned()) };
        let system = match system / ONE {
            _ if system % ONE != 0 => usize::MAX,
            0 => self.system,
            other => usize::try_from(other - 1).unwrap_or(usize::MAX),
        };
        if system >= self.systems.len() {
            return Err("G10 P is 0 (the coordinate system in force) or 1 to 6 (G54 to G59)".to_owned());
        }
        if !block.names_axes() {
            return Err("G10 needs an axis word".to_owned());
        }
        if block.r.is_some() {
            return Err("a rotated coordinate system (G10 R) is not supported".to_owned());
        }
        let here = match kind {
            2_000_000_000_000_000 => false,
            20_000_000_000_000_000 => true,
            _ => return Err("G10 is supported with L2 and L20 only".to_owned()),
        };
        for axis in 0..3 {
            if let Some(word) = block.xyz[axis] {
                let word = self.mm(word);
                let at = self.at[axis] - self.offset[axis] - self.tool[axis];
                self.systems[system][axis] = if here { at - word } else { word };
            }
        }
        Ok(())
    }

    /// What the program's zero is in the machine.
    pub fn zero(&self, axis: usize) -> i128 {
        self.systems[self.system][axis] + self.offset[axis] + self.tool[axis]
    }

    /// Where the axis words lead.
    fn target(&self, block: &Block) -> Point {
        let mut to = self.at;
        for (axis, to) in to.iter_mut().enumerate() {
            if let Some(word) = block.xyz[axis] {
                let word = self.mm(word);
                *to = match (block.machine, self.incremental) {
                    (true, _) => word,
                    (false, true) => self.at[axis] + word,
                    (false, false) => self.zero(axis) + word,
                };
            }
        }
        to
    }

    fn motion(&mut self, block: &Block, number: usize, writer: &mut Writer<'_>) -> Result<(), String> {
        let taken = block.tool == Some(true) || block.takes_axes();
        let named = block.names_axes() && !taken;
        let round = matches!(self.motion, Motion::Arc { .. });
        let curved = block.names_centre() || block.r.is_some();
        if curved && (!round || taken) {
            return Err("I, J, K and R belong to G2 and G3".to_owned());
        }
        if round && block.motion.is_some() && !named && !curved {
            return Err("G2 and G3 need axis words or a centre".to_owned());
        }
        if block.machine && (!named || round || self.motion == Motion::Off) {
            return Err("G53 goes with G0 or G1 and axis words".to_owned());
        }
        if !named && !curved {
            return Ok(());
        }
        let to = self.target(block);
        let feed = match self.motion {
            Motion::Off => return Err("axis words after G80: give G0, G1, G2 or G3".to_owned()),
            Motion::Rapid => None,
            _ if self.inverse && block.f.is_none() => {
                return Err("in inverse time (G93) each G1, G2 and G3 needs F".to_owned());
            }
            _ if self.feed == 0 => return Err("no feed rate was given: F is missing, or 0".to_owned()),
            _ => Some(to_f64(self.feed)),
        };
        let shape = match self.motion {
            Motion::Arc { ccw } => self.arc(block, to, ccw)?,
            _ => Shape::Line,
        };
        self.go(number, to, shape, feed, self.light(), writer)
    }

    fn arc(&self, block: &Block, to: Point, ccw: bool) -> Result<Shape, String> {
        let [a, b, across] = PLANES[self.plane];
        if self.travel[a].is_none() || self.travel[b].is_none() {
            return Err("an arc of this plane moves Z, and the machine file has no [axes.z]".to_owned());
        }
        let end = [to_f64(to[a] - self.at[a]), to_f64(to[b] - self.at[b])];
        let closed = to[a] == self.at[a] && to[b] == self.at[b];
        let names_plane = block.xyz[a].is_some() || block.xyz[b].is_some();
        let arc = match block.r {
            Some(_) if block.names_centre() => return Err("an arc has either R or I, J, K".to_owned()),
            Some(_) if !block.names_axes() => return Err("an arc by R needs axis words".to_owned()),
            Some(_) if !names_plane => return Err("an arc by R needs an axis word of its plane".to_owned()),
            Some(radius) => Arc::by_radius(to_f64(self.mm(radius)), end, ccw)?,
            None => {
                if block.ijk[across].is_some() {
                    return Err(format!("{} is no centre of an arc of this plane", ['I', 'J', 'K'][across]));
                }
                let centre = [a, b].map(|axis| match (block.ijk[axis], self.centre_absolute) {
                    (Some(word), true) => Some(to_f64(self.zero(axis) + self.mm(word) - self.at[axis])),
                    (None, true) => None,
                    (word, false) => Some(to_f64(self.mm(word.unwrap_or(0)))),
                });
                let [Some(x), Some(y)] = centre else {
                    return Err("with G90.1 an arc needs both words of its centre".to_owned());
                };
                if !block.names_centre() {
                    return Err("an arc needs R or a centre".to_owned());
                }
                Arc::by_centre([x, y], end, closed, ccw)?
            }
        };
        for (axis, extent) in [a, b].into_iter().zip(arc.extent()) {
            let here = to_f64(self.at[axis]);
            for far in [extent.0, extent.1] {
                self.within(axis, of_f64(here + far), 1_000_000)?;
            }
        }
        Ok(Shape::Arc { axes: [a, b, across], arc })
    }

    /// Refuses a machine position outside the travel by more than `slack`.
    fn within(&self, axis: usize, at: i128, slack: i128) -> Result<(), String> {
        match self.travel[axis] {
            Some((least, most)) if at < least - slack || at > most + slack => Err(format!(
                "{} goes to {} mm in the machine; its travel is {} to {} mm",
                LETTERS[axis],
                to_f64(at),
                to_f64(least),
                to_f64(most)
            )),
            _ => Ok(()),
        }
    }

    /// Moves to a machine position.
    pub fn go(
        &mut self,
        number: usize,
        to: Point,
        shape: Shape,
        feed: Option<f64>,
        light: Light,
        writer: &mut Writer<'_>,
    ) -> Result<(), String> {
        let length = shape.length(self.at, to);
        let speed = feed.map(|feed| if self.inverse { feed * length } else { feed });
        let stroke = Stroke { line: number, from: self.at, to, shape, speed, light };
        for (axis, at) in to.iter().enumerate() {
            // A picture shows what leaves the travel.
            self.within(axis, *at, 0).inspect_err(|_| writer.show(&stroke))?;
        }
        if let Some(speed) = speed.filter(|_| length > 0.0) {
            writer.check_speed(speed)?;
        }
        writer.stroke(&stroke);
        self.at = to;
        Ok(())
    }
}
