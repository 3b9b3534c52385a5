//! The words of a line to what they ask for: one word of a modal group, each letter once.
//!
//! In: words. Out: a [`Block`]. Fails with the rule that the words break.
use crate::words::Word;
use strokes::exact::ONE;

/// What moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// G0.
    Rapid,
    /// G1.
    Line,
    /// G2 and G3.
    Arc {
        /// Counterclockwise, G3.
        ccw: bool,
    },
    /// G80: none.
    Off,
}

/// What is done once, with the axis words of its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Once {
    /// G10.
    Data,
    /// G28 (0) and G30 (1).
    Home(usize),
    /// G28.1 and G30.1.
    SetHome(usize),
    /// G92.
    Offset,
    /// G92.1.
    OffsetReset,
    /// G92.2.
    OffsetOff,
    /// G92.3.
    OffsetOn,
}

/// M0 to M2 and M30.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// M0.
    Pause,
    /// M1.
    Optional,
    /// M2, M30.
    End,
}

/// The spindle, which is the laser.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spindle {
    /// M5.
    Off,
    /// M3: constant power.
    Constant,
    /// M4: power follows the speed.
    Follow,
}

/// A line.
#[derive(Debug, Clone, Default)]
pub struct Block {
    pub motion: Option<Motion>,
    pub once: Option<Once>,
    pub dwell: bool,
    pub machine: bool,
    /// 0 XY, 1 YZ, 2 ZX.
    pub plane: Option<usize>,
    pub inch: Option<bool>,
    pub incremental: Option<bool>,
    pub centre_absolute: Option<bool>,
    pub inverse: Option<bool>,
    /// G43.1 (true) or G49.
    pub tool: Option<bool>,
    /// G54 to G59: 0 to 5.
    pub system: Option<usize>,
    /// G61 (false) or G64.
    pub control: Option<bool>,
    pub cutter: bool,
    pub stop: Option<Stop>,
    pub spindle: Option<Spindle>,
    pub mist: bool,
    pub flood: bool,
    pub coolant_off: bool,
    pub xyz: [Option<i128>; 3],
    pub ijk: [Option<i128>; 3],
    pub f: Option<i128>,
    pub s: Option<i128>,
    pub p: Option<i128>,
    pub l: Option<i128>,
    pub r: Option<i128>,
    pub t: bool,
}

fn put<T>(slot: &mut Option<T>, value: T, what: &str) -> Result<(), String> {
    if slot.replace(value).is_some() {
        return Err(format!("two words of one modal group ({what}) in a line"));
    }
    Ok(())
}

fn once(flag: &mut bool, what: &str) -> Result<(), String> {
    if std::mem::replace(flag, true) {
        return Err(format!("{what} is twice in a line"));
    }
    Ok(())
}

impl Block {
    /// Reads the words of a line.
    pub fn of(words: &[Word]) -> Result<Block, String> {
        let mut block = Block::default();
        let mut number_seen = false;
        for word in words {
            let name = char::from(word.letter);
            let letter = |slot: &mut Option<i128>| match slot.replace(word.number) {
                Some(_) => Err(format!("{name} is twice in a line")),
                None => Ok(()),
            };
            match word.letter {
                b'G' => block.g(word.number)?,
                b'M' => block.m(word.number)?,
                b'X' => letter(&mut block.xyz[0])?,
                b'Y' => letter(&mut block.xyz[1])?,
                b'Z' => letter(&mut block.xyz[2])?,
                b'I' => letter(&mut block.ijk[0])?,
                b'J' => letter(&mut block.ijk[1])?,
                b'K' => letter(&mut block.ijk[2])?,
                b'F' => letter(&mut block.f)?,
                b'S' => letter(&mut block.s)?,
                b'P' => letter(&mut block.p)?,
                b'L' => letter(&mut block.l)?,
                b'R' => letter(&mut block.r)?,
                b'T' if word.number < 0 => return Err("a tool number is 0 or above".to_owned()),
                b'T' => once(&mut block.t, "T")?,
                b'N' if word.number < 0 => return Err("a line number is 0 or above".to_owned()),
                b'N' => once(&mut number_seen, "N")?,
                _ => return Err(format!("the word {name} is not supported")),
            }
        }
        block.check()?;
        Ok(block)
    }

    fn g(&mut self, number: i128) -> Result<(), String> {
        let tenth = ONE / 10;
        let code = if number % tenth == 0 { number / tenth } else { -1 };
        match code {
            0 => put(&mut self.motion, Motion::Rapid, "motion"),
            10 => put(&mut self.motion, Motion::Line, "motion"),
            20 => put(&mut self.motion, Motion::Arc { ccw: false }, "motion"),
            30 => put(&mut self.motion, Motion::Arc { ccw: true }, "motion"),
            800 => put(&mut self.motion, Motion::Off, "motion"),
            40 => once(&mut self.dwell, "G4"),
            530 => once(&mut self.machine, "G53"),
            100 => put(&mut self.once, Once::Data, "not modal"),
            280 => put(&mut self.once, Once::Home(0), "not modal"),
            281 => put(&mut self.once, Once::SetHome(0), "not modal"),
            300 => put(&mut self.once, Once::Home(1), "not modal"),
            301 => put(&mut self.once, Once::SetHome(1), "not modal"),
            920 => put(&mut self.once, Once::Offset, "not modal"),
            921 => put(&mut self.once, Once::OffsetReset, "not modal"),
            922 => put(&mut self.once, Once::OffsetOff, "not modal"),
            923 => put(&mut self.once, Once::OffsetOn, "not modal"),
            170 => put(&mut self.plane, 0, "plane"),
            180 => put(&mut self.plane, 2, "plane"),
            190 => put(&mut self.plane, 1, "plane"),
            200 => put(&mut self.inch, true, "units"),
            210 => put(&mut self.inch, false, "units"),
            400 => once(&mut self.cutter, "G40"),
            431 => put(&mut self.tool, true, "tool length"),
            490 => put(&mut self.tool, false, "tool length"),
            540 | 550 | 560 | 570 | 580 | 590 => put(&mut self.system, (code / 10 - 54) as usize, "coordinate system"),
            610 => put(&mut self.control, false, "path control"),
            640 => put(&mut self.control, true, "path control"),
            900 => put(&mut self.incremental, false, "distance"),
            910 => put(&mut self.incremental, true, "distance"),
            901 => put(&mut self.centre_absolute, true, "arc distance"),
            911 => put(&mut self.centre_absolute, false, "arc distance"),
            930 => put(&mut self.inverse, true, "feed mode"),
            940 => put(&mut self.inverse, false, "feed mode"),
            // Of these some have decimals.
            280..290 | 300..310 | 900..930 => Err(unknown('G', number, |_| false)),
            _ => Err(unknown('G', number, |whole| Block::default().g(whole).is_ok())),
        }
    }

    fn m(&mut self, number: i128) -> Result<(), String> {
        let code = if number % ONE == 0 { number / ONE } else { -1 };
        match code {
            0 => put(&mut self.stop, Stop::Pause, "stop"),
            1 => put(&mut self.stop, Stop::Optional, "stop"),
            2 | 30 => put(&mut self.stop, Stop::End, "stop"),
            3 => put(&mut self.spindle, Spindle::Constant, "spindle"),
            4 => put(&mut self.spindle, Spindle::Follow, "spindle"),
            5 => put(&mut self.spindle, Spindle::Off, "spindle"),
            7 => once(&mut self.mist, "M7"),
            8 => once(&mut self.flood, "M8"),
            9 => once(&mut self.coolant_off, "M9"),
            _ => Err(unknown('M', number, |_| true)),
        }
    }

    /// Some axis is named.
    pub fn names_axes(&self) -> bool {
        self.xyz.iter().any(Option::is_some)
    }

    /// What is done once uses the axis words.
    pub fn takes_axes(&self) -> bool {
        matches!(self.once, Some(Once::Data | Once::Home(_) | Once::Offset))
    }

    /// Some centre is named.
    pub fn names_centre(&self) -> bool {
        self.ijk.iter().any(Option::is_some)
    }

    fn check(&self) -> Result<(), String> {
        let moves = self.motion.is_some_and(|motion| motion != Motion::Off);
        let takes_axes = self.takes_axes();
        let users = [moves, takes_axes, self.tool == Some(true)];
        if users.iter().filter(|user| **user).count() > 1 {
            return Err("two commands of this line use its axis words; give each its own line".to_owned());
        }
        let alone = matches!(self.once, Some(one) if !takes_axes && one != Once::Data);
        if alone && self.names_axes() {
            return Err("G28.1, G30.1 and G92.1 to G92.3 take no axis words".to_owned());
        }
        if self.coolant_off && (self.mist || self.flood) {
            return Err("two words of one modal group (coolant) in a line".to_owned());
        }
        let wants_p = [self.dwell, self.once == Some(Once::Data), self.control == Some(true)];
        match (self.p, wants_p.iter().filter(|wants| **wants).count()) {
            (Some(_), 0) => return Err("P belongs to no word of this line".to_owned()),
            (Some(_), 2..) => return Err("P belongs to two words of this line; give each its own line".to_owned()),
            _ => {}
        }
        if self.l.is_some() && self.once != Some(Once::Data) {
            return Err("L belongs to no word of this line".to_owned());
        }
        if self.machine && takes_axes {
            return Err("G53 goes with G0 or G1".to_owned());
        }
        Ok(())
    }
}

/// A code that is none, as people write it. One with decimals is told from an unknown one, if
/// without them it is `known`.
fn unknown(letter: char, number: i128, known: impl Fn(i128) -> bool) -> String {
    let name = format!("{letter}{}", number as f64 / ONE as f64);
    let whole = number - number % ONE;
    if whole != number && known(whole) {
        return format!("{name} is not supported: {letter}{} has no decimals", whole / ONE);
    }
    format!("{name} is not supported")
}
