//! Lines that begin with `$`.
//!
//! In: a line. Out: Grbl's answer. Those that Grbl refuses during motion are refused here too.
use crate::errors;
use crate::report::{length, point};
use crate::session::{PLANNER_BLOCKS, RECEIVE_BYTES, Session};
use crate::settings::Settings;
use client::Error;

/// Characters of a line that a message shows.
const SHOWN_CHARACTERS: usize = 24;

impl Session<'_> {
    /// Does such a line, and answers it.
    pub(crate) fn dollar(&mut self, line: &str) -> Result<(), Error> {
        let bare: String = line.chars().filter(|letter| !letter.is_whitespace()).collect();
        let bare = bare.to_ascii_uppercase();
        let stands = self.feed.idle();
        let alarmed = self.alarm.is_some();
        let number = match bare.as_str() {
            "$" => {
                self.say("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]");
                0
            }
            "$G" => {
                self.modes();
                0
            }
            "$C" if self.checks => {
                self.message("Disabled");
                self.answer(0);
                return self.restart();
            }
            "$C" if alarmed || !stands => errors::NOT_IDLE,
            "$C" => {
                self.checks = true;
                self.message("Enabled");
                0
            }
            "$X" if alarmed => return self.unlock(false),
            "$X" => 0,
            text if text.starts_with("$J=") => return self.jog(&bare["$J=".len()..]),
            _ if !stands => errors::NOT_IDLE,
            "$H" if self.checks => errors::NOT_IDLE,
            "$H" if alarmed => return self.unlock(true),
            "$H" => return self.home(),
            "$$" => {
                for (number, value) in self.settings.list(self.machine) {
                    self.say(&format!("${number}={value}"));
                }
                0
            }
            "$#" => {
                self.parameters();
                0
            }
            "$I" => {
                self.say("[VER:1.1h.20190825:Beamtick]");
                self.say(&format!("[OPT:VL,{PLANNER_BLOCKS},{RECEIVE_BYTES}]"));
                0
            }
            "$N" => {
                for (place, line) in self.settings.startup.clone().iter().enumerate() {
                    self.say(&format!("$N{place}={line}"));
                }
                0
            }
            "$SLP" => {
                self.sleeps = true;
                self.message("Sleeping");
                0
            }
            "$RST=$" | "$RST=*" | "$RST=#" => {
                if bare != "$RST=#" {
                    self.settings = Settings::new();
                }
                if bare != "$RST=$" {
                    self.stream.forget_offsets();
                }
                self.message("Restoring defaults");
                self.answer(0);
                return self.restart();
            }
            _ => match self.set(&bare) {
                Ok(()) => 0,
                Err((number, why)) => {
                    self.message(&why);
                    number
                }
            },
        };
        if number == errors::NOT_IDLE {
            self.message(self.not_now());
        }
        self.answer(number);
        Ok(())
    }

    /// `$x=val` and `$Nx=line`.
    fn set(&mut self, bare: &str) -> Result<(), (u8, String)> {
        let bad = |why: String| (errors::BAD_STATEMENT, why);
        let shown: String = bare.chars().take(SHOWN_CHARACTERS).collect();
        let unknown = || bad(format!("{shown} is no command; $ lists them"));
        let (name, value) = bare[1..].split_once('=').ok_or_else(unknown)?;
        if name == "RST" {
            return Err(bad("$RST= takes $, # or *".to_owned()));
        }
        if let Some(place) = name.strip_prefix('N') {
            let place = place.parse().ok().filter(|place: &usize| *place < 2);
            let place = place.ok_or_else(|| bad(format!("${name}: there are $N0 and $N1")))?;
            // It runs whenever somebody connects: nobody asks for light then.
            match self.stream.tried(value) {
                Ok(false) => self.settings.startup[place] = value.to_owned(),
                Ok(true) => return Err((errors::UNSUPPORTED, "a start-up line switches no laser on".to_owned())),
                Err(why) => return Err((errors::number(&why), why)),
            }
            return Ok(());
        }
        if name.is_empty() || !name.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(unknown());
        }
        self.settings.set(name, value, self.machine).map_err(bad)
    }

    /// `$G`.
    fn modes(&mut self) {
        let modes = self.stream.modes();
        let coolant = match self.coolant {
            [true, true] => "M7 M8",
            [true, false] => "M7",
            [false, true] => "M8",
            [false, false] => "M9",
        };
        let feed = if self.settings.inches { modes.feed / 25.4 } else { modes.feed };
        let words = modes.words.join(" ");
        self.say(&format!("[GC:{words} {coolant} T0 F{feed:.0} S{:.0}]", modes.power));
    }

    /// `$#`.
    fn parameters(&mut self) {
        let (offsets, inches) = (self.stream.offsets(), self.settings.inches);
        for (place, at) in offsets.systems.iter().enumerate() {
            self.say(&format!("[G{}:{}]", 54 + place, point(*at, inches)));
        }
        for (name, at) in [("G28", offsets.homes[0]), ("G30", offsets.homes[1]), ("G92", offsets.offset)] {
            self.say(&format!("[{name}:{}]", point(at, inches)));
        }
        self.say(&format!("[TLO:{}]", length(offsets.tool[2], inches)));
        self.say(&format!("[PRB:{}:0]", point([0.0; 3], inches)));
    }
}
