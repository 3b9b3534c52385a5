//! A sender's connection: bytes to lines and real-time commands, and their answers.
//!
//! In: bytes. Out: bytes. Owns the modal state, the alarm, the holds, and what waits for
//! standstill.
//! A line is answered when its motions are in the planner, as in Grbl. Fails with the link's error.
mod jogs;
mod overrides;
mod status;

use crate::entry;
use crate::errors;
use crate::feeder::Feed;
use crate::report::Turns;
use crate::settings::Settings;
use client::Error;
use gcode::{Ended, Stream};
use machine::Machine;
use protocol::command::AxisOn;
use std::collections::VecDeque;

/// Blocks of the planner that are reported, and bytes of the receive buffer.
pub const PLANNER_BLOCKS: u64 = 15;
/// See there.
pub const RECEIVE_BYTES: usize = 128;
/// More blocks are taken while those that wait last shorter than this, ms, …
const AHEAD_MS: u32 = 500;
/// … up to so many entries, …
const AHEAD_ENTRIES: u64 = 1200;
/// … of which so many may not have reached the controller: only it knows how long they last. …
const UNREPORTED_ENTRIES: u64 = 64;
/// … More of them are taken if they last shorter than this, as long each as those that it has, ms.
const UNKNOWN_MS: u64 = 50;
/// Characters of a line without blanks. Grbl has 80.
const LINE_CHARACTERS: usize = 255;
/// What is kept of bytes that nobody counted.
const KEPT_BYTES: usize = 1 << 16;

/// What ends an alarm, in Grbl's words.
const UNLOCK: &str = "'$H'|'$X' to unlock";

/// What comes once everything stands and the path is empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum After {
    /// The banner.
    Reset,
    /// The jog is over.
    Jog,
    /// The alarm is in force.
    Alarm,
    /// `$X`, and then `$H`.
    Unlock { home: bool },
    /// The sender has gone.
    Gone,
}

/// What a line waits for, that is answered at standstill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wait {
    /// `$H`.
    Home,
    /// M0.
    Pause,
    /// M2, M30.
    Program,
}

/// See the module text.
pub struct Session<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) stream: Stream<'a>,
    pub(crate) feed: Feed,
    pub(crate) settings: Settings,
    pass_stops: bool,
    out: Vec<u8>,
    received: VecDeque<u8>,
    line: Vec<u8>,
    overflow: bool,
    /// Feed, rapid, power, %.
    overrides: [u8; 3],
    turns: Turns,
    /// M7, M8.
    pub(crate) coolant: [bool; 2],
    pub(crate) alarm: Option<u8>,
    pub(crate) checks: bool,
    pub(crate) sleeps: bool,
    held: bool,
    door: bool,
    /// `~` answers the line with M0.
    owes: bool,
    pub(crate) jogs: bool,
    settles: Option<(u64, After)>,
    waits: Option<Wait>,
    lines: u64,
}

impl<'a> Session<'a> {
    /// A port without a sender. The controller was set up by the stream's calls.
    pub fn new(machine: &'a Machine, stream: Stream<'a>, feed: Feed, pass_stops: bool) -> Session<'a> {
        Session {
            machine,
            stream,
            feed,
            settings: Settings::new(),
            pass_stops,
            out: Vec::new(),
            received: VecDeque::new(),
            line: Vec::new(),
            overflow: false,
            overrides: [100; 3],
            turns: Turns::default(),
            coolant: [false; 2],
            alarm: None,
            checks: false,
            sleeps: false,
            held: false,
            door: false,
            owes: false,
            jogs: false,
            settles: None,
            waits: None,
            lines: 0,
        }
    }

    /// A sender has come.
    pub fn come(&mut self) -> Result<(), Error> {
        self.out.clear();
        self.greet()
    }

    /// The sender has gone: dark at once, and everything comes to rest.
    pub fn go(&mut self) -> Result<(), Error> {
        self.stop(After::Gone)
    }

    /// Whether the machine is still coming to rest.
    pub fn settles(&self) -> bool {
        self.settles.is_some()
    }

    /// Lines that were answered, and starts of the path.
    pub fn counts(&self) -> (u64, u64) {
        (self.lines, self.feed.view().starts)
    }

    /// What is to be sent.
    pub fn take_out(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    /// Something waits that only time moves on.
    pub fn busy(&self) -> bool {
        self.settles.is_some() || self.waits.is_some() || self.received.iter().any(|byte| is_end(*byte))
    }

    /// Whether bytes are taken: a sender that counts them never fills this.
    pub fn takes(&self) -> bool {
        self.received.len() < KEPT_BYTES
    }

    pub(crate) fn say(&mut self, text: &str) {
        self.out.extend_from_slice(text.as_bytes());
        self.out.extend_from_slice(b"\r\n");
    }

    pub(crate) fn message(&mut self, text: &str) {
        let text: String = text.chars().filter(|letter| !letter.is_control() && !"[]".contains(*letter)).collect();
        self.say(&format!("[MSG:{text}]"));
    }

    pub(crate) fn answer(&mut self, number: u8) {
        match number {
            0 => self.say("ok"),
            _ => self.say(&format!("error:{number}")),
        }
    }

    /// Takes bytes: what is real-time acts now.
    pub fn receive(&mut self, bytes: &[u8]) -> Result<(), Error> {
        for &byte in bytes {
            match byte {
                b'?' => self.report(),
                b'!' => self.hold(false)?,
                b'~' => self.go_on(),
                0x18 => self.reset()?,
                0x84 => self.hold(true)?,
                0x85 => drop(self.cancel_jog()?),
                0x90..=0x9d => self.override_by(byte),
                0xa0 => self.toggle(1)?,
                0xa1 => self.toggle(0)?,
                // In a hold the laser is dark already; what else is above ASCII means nothing.
                0x80..=0xff => {}
                _ => self.received.push_back(byte),
            }
        }
        Ok(())
    }

    /// Does lines as far as the planner takes them, and what has come to its end.
    pub fn turn(&mut self) -> Result<(), Error> {
        loop {
            self.watch()?;
            if self.settles.is_some() || self.waits.is_some() || self.held || self.sleeps || !self.has_room() {
                return Ok(());
            }
            let Some(line) = self.next_line() else { return Ok(()) };
            self.lines += 1;
            match line {
                Some(line) => self.obey(&line)?,
                None => {
                    self.message(&format!("a line has at most {LINE_CHARACTERS} characters"));
                    self.answer(errors::OVERFLOW);
                }
            }
        }
    }

    /// The next whole line; within, none for one that is too long.
    fn next_line(&mut self) -> Option<Option<String>> {
        while let Some(byte) = self.received.pop_front() {
            if is_end(byte) {
                let line = String::from_utf8_lossy(&self.line).into_owned();
                self.line.clear();
                return Some((!std::mem::take(&mut self.overflow)).then_some(line));
            }
            if self.line.len() < LINE_CHARACTERS {
                self.line.push(byte);
            } else {
                self.overflow |= byte != b' ';
            }
        }
        None
    }

    fn has_room(&self) -> bool {
        let view = self.feed.view();
        let (entries, motions) = self.feed.waiting(&view);
        let unknown = self.feed.unknown(&view);
        let known = entries.saturating_sub(unknown);
        let is_short = known > 0 && unknown * u64::from(view.lasts_ms) < UNKNOWN_MS * known;
        let few = unknown < UNREPORTED_ENTRIES || is_short;
        motions < PLANNER_BLOCKS || (entries < AHEAD_ENTRIES && view.lasts_ms < AHEAD_MS && few)
    }

    /// What has come to its end by itself.
    fn watch(&mut self) -> Result<(), Error> {
        let view = self.feed.view();
        if let Some(error) = view.failed {
            return Err(error);
        }
        if let Some((before, after)) = self.settles {
            if view.emptied > before && !view.runs {
                self.settles = None;
                self.stream.restart_at(view.at);
                self.settled(after)?;
            }
            return Ok(());
        }
        if let Some(fault) = view.fault
            && self.alarm.is_none()
        {
            return self.raise(if fault.limit { 1 } else { 3 }, &fault.reason);
        }
        let idle = self.feed.idle();
        self.jogs &= !idle;
        if let Some(wait) = self.waits
            && idle
        {
            self.waits = None;
            self.feed.hurry(false);
            match wait {
                Wait::Home => self.answer(0),
                Wait::Program => {
                    self.set_overrides([100; 3]);
                    self.message("Pgm End");
                    self.answer(0);
                }
                Wait::Pause => {
                    self.owes = true;
                    self.hold(false)?;
                }
            }
        }
        Ok(())
    }

    /// Dark at once, everything comes to rest, the path is emptied.
    fn stop(&mut self, after: After) -> Result<(), Error> {
        self.received.clear();
        self.line.clear();
        self.overflow = false;
        (self.held, self.door, self.owes, self.checks, self.sleeps) = (false, false, false, false, false);
        self.waits = None;
        self.feed.abort()?;
        self.settle(after);
        Ok(())
    }

    fn settle(&mut self, after: After) {
        self.settles = Some((self.feed.view().emptied, after));
        self.feed.empty();
    }

    fn settled(&mut self, after: After) -> Result<(), Error> {
        self.jogs = false;
        match after {
            After::Jog => {
                self.held = self.door;
                self.feed.release();
                if self.held {
                    self.feed.hold()?;
                }
            }
            After::Alarm => self.stream.laser_off(),
            After::Unlock { home } => {
                self.alarm = None;
                self.feed.release();
                if home {
                    return self.home();
                }
                self.message("Caution: Unlocked");
                self.answer(0);
            }
            After::Reset | After::Gone => {
                self.stream.reset();
                self.set_overrides([100; 3]);
                self.coolant_off()?;
                if self.alarm.is_none() {
                    self.feed.release();
                }
                if after == After::Reset {
                    self.greet()?;
                }
            }
        }
        Ok(())
    }

    /// The banner, and the lines that run after it.
    fn greet(&mut self) -> Result<(), Error> {
        self.turns.anew();
        self.say("");
        self.say("Grbl 1.1h ['$' for help]");
        if self.alarm.is_some() {
            self.message(UNLOCK);
            return Ok(());
        }
        for line in self.settings.startup.clone() {
            if !line.is_empty() {
                self.out.extend_from_slice(format!(">{line}:").as_bytes());
                self.obey(&line)?;
            }
        }
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Error> {
        self.stop(After::Reset)
    }

    /// An alarm: nothing moves before `$X`.
    fn raise(&mut self, number: u8, reason: &str) -> Result<(), Error> {
        self.say(&format!("ALARM:{number}"));
        self.message(reason);
        self.alarm = Some(number);
        self.feed.abort()?;
        if self.waits.take().is_some() || std::mem::take(&mut self.owes) {
            self.answer(errors::LOCKED);
        }
        (self.held, self.door) = (false, false);
        self.settle(After::Alarm);
        Ok(())
    }

    /// `$X`, or `$H` in an alarm.
    pub(crate) fn unlock(&mut self, home: bool) -> Result<(), Error> {
        if let Some(fault) = self.feed.clear_faults()? {
            self.message(&fault.reason);
            self.answer(errors::DOOR);
            return Ok(());
        }
        for axis in &self.machine.axes {
            let on = AxisOn { core: 1.into(), axis: i16::from(axis.number).into() };
            if let Err(error) = self.feed.client().call(on) {
                if error.code < 0 {
                    return Err(error);
                }
                self.message(&error.reason);
                self.answer(errors::DOOR);
                return Ok(());
            }
        }
        self.settle(After::Unlock { home });
        Ok(())
    }

    fn hold(&mut self, door: bool) -> Result<(), Error> {
        let settles = self.settles.is_some_and(|(_, after)| after != After::Jog);
        if settles || self.alarm.is_some() || self.sleeps || self.checks {
            return Ok(());
        }
        let jogged = self.cancel_jog()?;
        // A door holds also what comes after the jog.
        self.door |= door;
        if !self.held && self.settles.is_none() && (door || !jogged) {
            self.held = true;
            self.feed.hold()?;
        }
        Ok(())
    }

    fn go_on(&mut self) {
        if !self.held || self.settles.is_some() {
            return;
        }
        (self.held, self.door) = (false, false);
        self.feed.go_on();
        if std::mem::take(&mut self.owes) {
            self.answer(0);
        }
    }

    /// A line, answered.
    fn obey(&mut self, line: &str) -> Result<(), Error> {
        let trimmed = line.trim();
        if trimmed.is_empty() || trimmed == "%" {
            self.answer(0);
            return Ok(());
        }
        if trimmed.starts_with('$') {
            return self.dollar(trimmed);
        }
        if self.alarm.is_some() || self.jogs {
            self.message(if self.alarm.is_some() {
                UNLOCK
            } else {
                "a jog runs; 0x85 ends it (in the monitor the space bar)"
            });
            self.answer(errors::LOCKED);
            return Ok(());
        }
        // Grbl drops a comment to the end of its line, closed or not.
        let closed = if ends_in_comment(trimmed) { format!("{trimmed})") } else { String::new() };
        let text = if closed.is_empty() { trimmed } else { &closed };
        let done = match self.stream.line(text) {
            Ok(done) => done,
            Err(why) if errors::leaves_travel(&why) => {
                if self.checks {
                    self.message(&why);
                    self.answer(errors::LOCKED);
                    return Ok(());
                }
                self.raise(2, &why)?;
                self.answer(errors::LOCKED);
                return Ok(());
            }
            Err(why) => {
                self.message(&why);
                self.answer(errors::number(&why));
                return Ok(());
            }
        };
        if self.checks {
            self.answer(0);
            return Ok(());
        }
        self.enter(&done.calls)?;
        for (which, said) in [done.coolant.mist, done.coolant.flood].into_iter().enumerate() {
            self.coolant[which] = said.unwrap_or(self.coolant[which]);
        }
        match done.ended {
            Ended::Pause if !self.pass_stops => self.wait(Wait::Pause),
            Ended::Program => self.wait(Wait::Program),
            Ended::No | Ended::Pause => self.answer(0),
        }
        Ok(())
    }

    fn wait(&mut self, wait: Wait) {
        self.waits = Some(wait);
        self.feed.hurry(true);
    }

    /// Calls of a line go to the path.
    fn enter(&mut self, calls: &str) -> Result<(), Error> {
        let entries = entry::entries(calls, self.overrides[0].max(100));
        self.feed.queue(entries.map_err(|why| Error::new(1, why))?);
        Ok(())
    }

    /// Why a command that waits for standstill is refused.
    pub(crate) fn not_now(&self) -> &'static str {
        if !self.feed.idle() {
            "not before everything stands"
        } else if self.alarm.is_some() {
            UNLOCK
        } else {
            "not in check mode, which $C ends"
        }
    }

    /// `$H`: to home, dark; answered when it stands there.
    pub(crate) fn home(&mut self) -> Result<(), Error> {
        match self.stream.home() {
            Ok(calls) => {
                self.enter(&calls)?;
                self.wait(Wait::Home);
            }
            Err(why) => {
                self.message(&why);
                self.answer(errors::number(&why));
            }
        }
        Ok(())
    }

    /// `$C` off and `$RST=`, which are resets in Grbl too. What has come is kept.
    pub(crate) fn restart(&mut self) -> Result<(), Error> {
        let kept = std::mem::take(&mut self.received);
        self.stop(After::Reset)?;
        self.received = kept;
        Ok(())
    }
}

fn is_end(byte: u8) -> bool {
    byte == b'\r' || byte == b'\n'
}

/// Whether a line ends within parentheses.
fn ends_in_comment(line: &str) -> bool {
    let mut open = false;
    for byte in line.bytes() {
        match byte {
            b';' if !open => return false,
            b'(' => open = true,
            b')' => open = false,
            _ => {}
        }
    }
    open
}
