//! G-code that comes line by line, from a sender.
//!
//! In: lines, one at a time. Out: the calls of each. Owns the modal state between them. A line that
//! fails changes nothing, and the next one goes on without it. Within a line, and in what lines do,
//! it is the interpreter of files.
use crate::Options;
use crate::block::{Block, Motion, Spindle, Stop};
use crate::interpreter::{Point, State};
use crate::words::{self, Word};
use machine::Machine;
use strokes::exact::{ONE, to_f64};
use strokes::{Light, Shape, Writer};

/// What a line asks for beside its calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// Nothing.
    No,
    /// M0: until the operator goes on.
    Pause,
    /// M2 or M30.
    Program,
}

/// What a line has done.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The calls that it makes, in the notation of jobs.
    pub calls: String,
    /// What else it asks for.
    pub ended: Ended,
    /// M7, M8, M9, as the line says it.
    pub coolant: Coolant,
}

/// Which outputs of M7 and M8 a line switches, and to what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Coolant {
    /// M7 and M9.
    pub mist: Option<bool>,
    /// M8 and M9.
    pub flood: Option<bool>,
}

/// The modal words in force.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// As Grbl lists them, without coolant: `G0 G54 G17 …`.
    pub words: [&'static str; 7],
    /// F in mm/min, or 1/min.
    pub feed: f64,
    /// S.
    pub power: f64,
    /// G20 is in force.
    pub inch: bool,
}

/// The offsets in force, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Offsets {
    /// G54 to G59.
    pub systems: [[f64; 3]; 6],
    /// G28 and G30.
    pub homes: [[f64; 3]; 2],
    /// G92.
    pub offset: [f64; 3],
    /// G43.1.
    pub tool: [f64; 3],
    /// All that are in force together: a work position is so much less than that of the machine.
    pub zero: [f64; 3],
}

/// See the module text.
pub struct Stream<'a> {
    state: State<'a>,
    writer: Writer<'a>,
    machine: &'a Machine,
    bare: Vec<u8>,
    found: Vec<Word>,
}

fn mm(point: Point) -> [f64; 3] {
    point.map(to_f64)
}

impl<'a> Stream<'a> {
    /// The axes stand at home; [`Self::setup`] are the calls that come first.
    pub fn new(machine: &'a Machine) -> Stream<'a> {
        let mut writer = Writer::new("lines of a sender", "line", machine);
        writer.stream();
        writer.untimed();
        Stream { state: State::new(machine), writer, machine, bare: Vec::new(), found: Vec::new() }
    }

    /// The calls that set the controller up, once.
    pub fn setup(&mut self) -> String {
        self.writer.taken()
    }

    /// A line of G-code.
    ///
    /// # Errors
    /// Why nothing of it is done.
    pub fn line(&mut self, text: &str) -> Result<Line, String> {
        let block = self.block(text)?;
        let mut state = self.state.clone();
        let checkpoint = self.writer.checkpoint();
        let stop = block.stop;
        // The sender's operator goes on after M0: nothing of a pause is in the path.
        let run = Block { stop: stop.filter(|stop| *stop == Stop::End), ..block };
        match state.line(&run, 0, Options::default(), &mut self.writer, &mut |_| ()) {
            Ok(_) => self.state = state,
            Err(why) => {
                self.writer.restore(&checkpoint);
                return Err(why);
            }
        }
        let ended = match stop {
            None | Some(Stop::Optional) => Ended::No,
            Some(Stop::Pause) => Ended::Pause,
            Some(Stop::End) => {
                self.end();
                Ended::Program
            }
        };
        let off = run.coolant_off || run.stop == Some(Stop::End);
        let switched = |on: bool| if off { Some(false) } else { on.then_some(true) };
        let coolant = Coolant { mist: switched(run.mist), flood: switched(run.flood) };
        Ok(Line { calls: self.writer.taken(), ended, coolant })
    }

    /// `$J=`: a dark motion that leaves the modal state as it is.
    ///
    /// # Errors
    /// Why there is none.
    pub fn jog(&mut self, text: &str) -> Result<String, String> {
        let block = self.block(text)?;
        let plain = Block {
            inch: block.inch,
            incremental: block.incremental,
            machine: block.machine,
            xyz: block.xyz,
            f: block.f,
            ..Block::default()
        };
        let others = self.found.iter().any(|word| match word.letter {
            b'X' | b'Y' | b'Z' | b'F' | b'N' => false,
            b'G' => ![20, 21, 53, 90, 91].contains(&(word.number / ONE)) || word.number % ONE != 0,
            _ => true,
        });
        if others || !block.names_axes() {
            return Err("a jog has axis words, F, G20, G21, G53, G90 and G91".to_owned());
        }
        if block.f.is_none_or(|feed| feed <= 0) {
            return Err("no feed rate was given: a jog needs F above 0".to_owned());
        }
        let mut state = self.state.clone();
        state.motion = Motion::Line;
        (state.spindle, state.inverse) = (Spindle::Off, false);
        let checkpoint = self.writer.checkpoint();
        match state.line(&plain, 0, Options::default(), &mut self.writer, &mut |_| ()) {
            Ok(_) => self.state.at = state.at,
            Err(why) => {
                self.writer.restore(&checkpoint);
                return Err(why);
            }
        }
        Ok(self.writer.taken())
    }

    /// `$H`: to the machine's home, in the dark.
    ///
    /// # Errors
    /// None, as home lies in the travel.
    pub fn home(&mut self) -> Result<String, String> {
        let home = State::new(self.machine).at;
        self.state.go(0, home, Shape::Line, None, Light::Dark, &mut self.writer)?;
        Ok(self.writer.taken())
    }

    /// What M2 and M30 leave, as in Grbl: coordinates and offsets stay, and F and S.
    fn end(&mut self) {
        let state = &mut self.state;
        state.motion = Motion::Line;
        (state.plane, state.system) = (0, 0);
        if state.inverse {
            // That F was the time of a line.
            state.feed = 0;
        }
        (state.incremental, state.inverse) = (false, false);
        state.spindle = Spindle::Off;
    }

    /// After a reset: the modal state of the beginning. Coordinate systems and the positions of G28
    /// and G30 stay, the offset of G92 goes.
    pub fn reset(&mut self) {
        let at = self.state.at;
        let (systems, homes) = (self.state.systems, self.state.homes);
        let power_override = self.state.power_override;
        let mut new = State::new(self.machine);
        (new.systems, new.homes, new.at, new.power_override) = (systems, homes, at, power_override);
        self.state = new;
    }

    /// As M5: what an alarm leaves.
    pub fn laser_off(&mut self) {
        self.state.spindle = Spindle::Off;
    }

    /// What a line would leave on after a reset: whether the laser is on after it.
    ///
    /// # Errors
    /// Why nothing of it would be done.
    pub fn tried(&mut self, text: &str) -> Result<bool, String> {
        let (state, checkpoint) = (self.state.clone(), self.writer.checkpoint());
        self.reset();
        let done = self.line(text);
        let on = self.state.spindle != Spindle::Off;
        self.state = state;
        self.writer.restore(&checkpoint);
        let ended = done?.ended;
        if ended == Ended::No { Ok(on) } else { Err("a start-up line has no M0, M2 and M30".to_owned()) }
    }

    /// Coordinate systems, offsets and the positions of G28 and G30 as at the beginning.
    pub fn forget_offsets(&mut self) {
        let new = State::new(self.machine);
        let state = &mut self.state;
        (state.systems, state.homes) = (new.systems, new.homes);
        (state.offset, state.offset_stored, state.tool) = (new.offset, new.offset_stored, new.tool);
    }

    /// The path was emptied, is dark, and stands at these pulses of the coordinate system.
    pub fn restart_at(&mut self, pulses: [f64; 3]) {
        let mut at = self.writer.restart_at(pulses);
        for (place, at) in at.iter_mut().enumerate() {
            let Some((least, most)) = self.state.travel(place) else { continue };
            // A stop ends between two pulses: that is no place outside the travel.
            let pulse = (ONE as f64 / self.machine.axes[place].steps_per_mm) as i128 + 1;
            if *at < least && least - *at <= pulse {
                *at = least;
            } else if *at > most && *at - most <= pulse {
                *at = most;
            }
        }
        self.state.at = at;
    }

    /// What a sender makes of F, of rapid motions and of S, from the next line on; 1 as they are.
    pub fn overrides(&mut self, feed: f64, rapid: f64, power: f64) {
        self.writer.factors(feed, rapid);
        self.state.power_override = power;
    }

    /// The modal words in force.
    pub fn modes(&self) -> Modes {
        let state = &self.state;
        let motion = match state.motion {
            Motion::Rapid => "G0",
            Motion::Line => "G1",
            Motion::Arc { ccw: false } => "G2",
            Motion::Arc { ccw: true } => "G3",
            Motion::Off => "G80",
        };
        let spindle = match state.spindle {
            Spindle::Off => "M5",
            Spindle::Constant => "M3",
            Spindle::Follow => "M4",
        };
        let words = [
            motion,
            ["G54", "G55", "G56", "G57", "G58", "G59"][state.system],
            ["G17", "G19", "G18"][state.plane],
            if state.inch { "G20" } else { "G21" },
            if state.incremental { "G91" } else { "G90" },
            if state.inverse { "G93" } else { "G94" },
            spindle,
        ];
        Modes { words, feed: to_f64(state.feed), power: to_f64(state.speed), inch: state.inch }
    }

    /// The offsets in force.
    pub fn offsets(&self) -> Offsets {
        let state = &self.state;
        Offsets {
            systems: state.systems.map(mm),
            homes: state.homes.map(mm),
            offset: mm(state.offset),
            tool: mm(state.tool),
            zero: [0, 1, 2].map(|axis| to_f64(state.zero(axis))),
        }
    }

    fn block(&mut self, text: &str) -> Result<Block, String> {
        words::read(text, &mut self.bare, &mut self.found)?;
        Block::of(&self.found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine() -> Machine {
        let axis = |letter: char, number: u8| {
            format!(
                "[axes.{letter}]\nnumber = {number}\nsteps_per_mm = 100\ntravel = [0, 300]\n\
                 max_rate = 6000\nacceleration = 500\nhome = 10\n"
            )
        };
        let laser = "[laser]\nchannel = 0\nmode = \"duty\"\ncarrier_khz = 1\npower = [0, 80]\ns_max = 1000\n";
        Machine::read("m.toml", &(axis('x', 1) + &axis('y', 2) + laser)).unwrap()
    }

    fn calls(stream: &mut Stream<'_>, line: &str) -> Vec<String> {
        let calls = stream.line(line).unwrap().calls;
        calls.lines().map(|call| call.split("; //").next().unwrap().to_owned()).collect()
    }

    #[test]
    fn state_lives_from_line_to_line_and_a_wrong_line_changes_nothing() {
        let machine = machine();
        let mut stream = Stream::new(&machine);
        assert!(stream.setup().contains("GT_SetCrdPrm"));
        assert_eq!(calls(&mut stream, "G1 X20 F600"), ["GT_LnXY(1, 2000, 1000, 1, 0.05)"]);
        let before = (stream.modes(), stream.offsets());
        // G91 and G55 come before what fails.
        for wrong in ["G91 G55 F300 X-400", "M3 S500 Y1 Y2", "G91 G28 X5 X"] {
            assert!(stream.line(wrong).is_err(), "{wrong}");
            assert_eq!((stream.modes(), stream.offsets()), before, "{wrong}");
        }
        assert_eq!(calls(&mut stream, "M3 S500 Y20").last().unwrap(), "GT_LnXY(1, 2000, 2000, 1, 0.05)");
        assert_eq!(calls(&mut stream, "G0 X0")[0], "GT_BufLaserOff(1, 0, 0);");
    }

    #[test]
    fn a_jog_is_dark_and_leaves_the_modes() {
        let machine = machine();
        let mut stream = Stream::new(&machine);
        stream.setup();
        stream.line("G1 F100 M3 S900 G55").unwrap();
        let modes = stream.modes();
        let jog = stream.jog("G91 X-2.5 F1200").unwrap();
        assert!(jog.starts_with("GT_LnXY(1, 750, 1000, 2, ") && jog.lines().count() == 1, "{jog}");
        assert_eq!(stream.modes(), modes);
        assert!(stream.jog("X1").unwrap_err().contains("feed"));
        assert!(stream.jog("X1 S5 F1").unwrap_err().contains("a jog has"));
        assert!(stream.jog("G2 X1 F1").unwrap_err().contains("a jog has"));
        assert!(stream.jog("X-1 F1").unwrap_err().contains("its travel is"));
        assert!(calls(&mut stream, "X8").last().unwrap().starts_with("GT_LnXY(1, 800, 1000, "));
    }

    #[test]
    fn a_stop_between_pulses_is_where_lines_go_on() {
        let machine = machine();
        let mut stream = Stream::new(&machine);
        stream.setup();
        stream.line("G1 F100 M3 S900 X20").unwrap();
        stream.restart_at([-0.4, 1234.25, 0.0]);
        assert_eq!(calls(&mut stream, "G91 G1 Y0.01 F60 M5"), ["GT_LnXY(1, 0, 1235, 0.1, 0.05)"]);
        stream.restart_at([0.0, 1235.0, 0.0]);
        // The light is set anew.
        assert!(calls(&mut stream, "M3 S900 X1").contains(&"GT_BufLaserOn(1, 0, 0);".to_owned()));
    }

    #[test]
    fn overrides_act_on_what_comes() {
        let machine = machine();
        let mut stream = Stream::new(&machine);
        stream.setup();
        stream.overrides(1.5, 0.25, 0.5);
        assert!(calls(&mut stream, "G1 F600 X20")[0].contains("2000, 1000, 1.5, "));
        assert!(calls(&mut stream, "G0 X10")[0].contains("1000, 1000, 2.5, "));
        // M4: a mm gets what it would get at F; the bound goes with the speed.
        let follow = calls(&mut stream, "M4 S1000 G1 X20");
        assert_eq!(follow[0], "GT_BufLaserFollowRatio(1, 40, 0, 60, 0, 0);");
    }

    #[test]
    fn the_end_of_a_program_and_a_reset_leave_what_grbl_leaves() {
        let machine = machine();
        let mut stream = Stream::new(&machine);
        stream.setup();
        stream.line("G10 L2 P2 X5").unwrap();
        stream.line("G55 G91 G93 M3 S7 G92 X0").unwrap();
        assert_eq!(stream.line("M30").unwrap().ended, Ended::Program);
        assert_eq!(stream.modes().words, ["G1", "G54", "G17", "G21", "G90", "G94", "M5"]);
        assert_eq!((stream.offsets().systems[1][0], stream.offsets().offset[0]), (5.0, 5.0));
        stream.reset();
        assert_eq!(stream.modes().words[0], "G0");
        assert_eq!((stream.offsets().systems[1][0], stream.offsets().offset[0]), (5.0, 0.0));
        assert_eq!(stream.line("M0").unwrap().ended, Ended::Pause);
        assert_eq!(stream.line("M8").unwrap().coolant, Coolant { mist: None, flood: Some(true) });
        // M2 is M9 too, and keeps F.
        stream.line("G94 F600").unwrap();
        assert_eq!(stream.line("M2").unwrap().coolant, Coolant { mist: Some(false), flood: Some(false) });
        assert_eq!(stream.modes().feed, 600.0);
        stream.forget_offsets();
        assert_eq!(stream.offsets().systems[1][0], 0.0);
    }

    #[test]
    fn lines_may_end_with_any_line_end() {
        let machine = machine();
        let job = |end: &str| {
            let text = ["; made by hand", "%", "G91 F600 G1", "X10", "M3 S500", "Y10", "M2"].join(end) + end;
            crate::import("a.nc", &text, &machine, Options::default()).unwrap()
        };
        let expected = job("\n");
        assert!(expected.job.matches("GT_LnXY(").count() >= 2 && expected.job.contains("// 6"));
        for end in ["\r\n", "\r", "\r\r\n"] {
            assert_eq!(job(end), expected, "{end:?}");
        }
        let wrong = crate::import("a.nc", "G1 F100\rX5\rX999\r", &machine, Options::default()).unwrap_err();
        assert!(wrong.starts_with("a.nc:3: "), "{wrong}");
    }
}
