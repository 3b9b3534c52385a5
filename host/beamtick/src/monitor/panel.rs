//! The side that commands: keys to what a Grbl port does, and a program to lines of it.
//!
//! In: keys, the lines of a program. Out: bytes to a port of this program (`grbl::Port::local`),
//! and what it says. So a hold, a jog, a stop and an alarm are those of `beamtick grbl`: dark where
//! it is dark. Owns the port's thread. Fails: with the link's error, after which nothing is
//! commanded any more.
use super::screen::{Key, Says};
use super::state::JobNow;
use crate::command_line::{Drawing, Monitor};
use crate::{Failure, import, input};
use client::{Client, Error};
use grbl::{Local, Pace, Port, Served};
use machine::Machine;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Bytes of lines that are not answered, at most: Grbl's receive buffer.
const UNANSWERED_BYTES: usize = 128;
/// Time between two questions what the machine does.
const STATUS_PERIOD: Duration = Duration::from_millis(200);
/// Lengths of a jog, mm.
const STEPS_MM: [f64; 5] = [0.1, 1.0, 5.0, 10.0, 50.0];
/// Reset, as Grbl has it.
const RESET: u8 = 0x18;

/// A program that a key starts.
pub struct Program {
    name: String,
    lines: Vec<String>,
    /// What it marks, mm: least and greatest X and Y.
    marks: Option<[(f64, f64); 2]>,
    /// How long its path takes.
    seconds: f64,
}

impl Program {
    /// Reads it, and checks it as `beamtick check` does.
    pub fn open(path: &Path, arguments: &Monitor) -> Result<Program, Failure> {
        let name = path.display().to_string();
        if !import::is_program(path) {
            return Err(Failure::Input(format!(
                "{name}: monitor runs G-code, named .nc, .gcode, .ngc or .tap; `beamtick run` runs drawings and jobs"
            )));
        }
        let drawing = Drawing {
            machine: arguments.machine.clone(),
            laser: arguments.laser.clone(),
            pass_stops: true,
            ..Drawing::default()
        };
        let found = import::job(path, &drawing, None, true)?;
        let bytes = input::read(path, input::Role::Job)
            .map_err(|error| Failure::Input(format!("{name}: the program cannot be read: {error}")))?;
        let lines = String::from_utf8_lossy(&bytes).lines().map(str::to_owned).collect();
        let side = |letter| {
            let of = |(_, least, most): &(char, f64, f64)| (*least, *most);
            found.extent.marks.iter().find(|row| row.0 == letter).map(of)
        };
        let marks = side('X').zip(side('Y')).map(|(x, y)| [x, y]);
        Ok(Program { name, lines, marks, seconds: found.extent.seconds.unwrap_or_default() })
    }
}

/// A line that is not answered yet.
struct SentLine {
    bytes: usize,
    /// Of the program, from 0.
    line: Option<usize>,
}

/// A run of the program.
struct ProgramRun {
    /// Lines that were sent, and that were answered.
    sent: usize,
    done: usize,
    /// Time for which the machine ran.
    ran: Duration,
}

/// See the module text.
pub struct Panel {
    local: Option<Local>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<Served, Error>>>,
    program: Option<Program>,
    run: Option<ProgramRun>,
    sent: VecDeque<SentLine>,
    /// Lines of keys that wait to be sent.
    waiting: VecDeque<String>,
    /// A reset was sent, whose banner has not come.
    resets: bool,
    received: Vec<u8>,
    asked: Instant,
    turned: Instant,
    state: String,
    /// It is younger than the last answer.
    fresh: bool,
    message: String,
    /// The message says why there is an alarm.
    is_alarm: bool,
    step: usize,
    /// Greatest rate at which all axes can go, mm/min, and how many there are.
    rate: f64,
    axes: usize,
}

impl Panel {
    /// A port in front of this client, whose axes stand at home, and its only sender.
    pub fn new(client: Arc<Client>, machine: &Machine, program: Option<Program>) -> Panel {
        let (port, local) = Port::local();
        let ends = Arc::new(AtomicBool::new(false));
        let (theirs, own) = (Arc::clone(&ends), machine.clone());
        let thread = std::thread::spawn(move || {
            grbl::serve(port, client, &own, false, Pace::Real, &|| theirs.load(Ordering::Relaxed))
        });
        Panel {
            local: Some(local),
            ends,
            thread: Some(thread),
            program,
            run: None,
            sent: VecDeque::new(),
            waiting: VecDeque::new(),
            // The banner comes first.
            resets: true,
            received: Vec::new(),
            asked: Instant::now(),
            turned: Instant::now(),
            state: "starts".to_owned(),
            fresh: false,
            message: String::new(),
            is_alarm: false,
            step: 3,
            rate: machine.axes.iter().map(|axis| axis.max_rate).fold(f64::INFINITY, f64::min),
            axes: machine.axes.len(),
        }
    }

    /// What it says.
    pub fn says(&self) -> Says {
        Says { state: self.state.clone(), message: self.message.clone(), step: format!("{} mm", STEPS_MM[self.step]) }
    }

    /// The program that runs.
    pub fn job(&self) -> Option<JobNow> {
        let (program, run) = self.program.as_ref().zip(self.run.as_ref())?;
        let count = |lines: usize| u32::try_from(lines).unwrap_or(u32::MAX);
        let left_s = Some((program.seconds - run.ran.as_secs_f64()).max(0.0));
        Some(JobNow { name: program.name.clone(), done: count(run.done), entries: count(program.lines.len()), left_s })
    }

    /// Does what a key asks for; what there is to say to it.
    pub fn press(&mut self, key: Key) -> String {
        // What was said before is not of this.
        let keeps = matches!(key, Key::Step(_) | Key::Quit | Key::Unknown) || self.is_alarm && key != Key::Unlock;
        if !keeps {
            self.message.clear();
        }
        match key {
            Key::Hold => self.at_once(b"!"),
            Key::GoOn => self.at_once(b"~"),
            Key::Stop => {
                self.at_once(&[RESET]);
                self.forget();
                self.resets = true;
                "stopped: dark, everything brakes; the position stays known".clone_into(&mut self.message);
            }
            Key::Unlock => {
                self.is_alarm = false;
                self.waiting.push_back("$X".to_owned());
            }
            Key::Step(longer) => {
                self.step = if longer { (self.step + 1).min(STEPS_MM.len() - 1) } else { self.step.saturating_sub(1) };
            }
            Key::Jog(..) | Key::Frame | Key::Zero | Key::Start if self.run.is_some() => {
                return "the program runs; x stops it".to_owned();
            }
            Key::Jog(axis, _) if axis >= self.axes => return "the machine has no such axis".to_owned(),
            Key::Jog(axis, up) => {
                let letter = machine::LETTERS[axis];
                let way = if up { STEPS_MM[self.step] } else { -STEPS_MM[self.step] };
                self.waiting.push_back(format!("$J=G91 G21 {letter}{way} F{:.1}", self.rate));
            }
            Key::Zero => self.waiting.push_back("G10 L20 P1 X0 Y0".to_owned()),
            Key::Frame => return self.frame(),
            Key::Start => match &self.program {
                None => return "there is no program: beamtick monitor PROGRAM --command".to_owned(),
                Some(_) => self.run = Some(ProgramRun { sent: 0, done: 0, ran: Duration::ZERO }),
            },
            Key::Quit | Key::Unknown => {}
        }
        String::new()
    }

    /// Walks round what the program marks, in jogs, which are dark.
    fn frame(&mut self) -> String {
        let Some(program) = &self.program else {
            return "there is no program: beamtick monitor PROGRAM --command".to_owned();
        };
        let Some([(left, right), (lower, upper)]) = program.marks else {
            return "the program marks nothing".to_owned();
        };
        for (x, y) in [(left, lower), (right, lower), (right, upper), (left, upper), (left, lower)] {
            self.waiting.push_back(format!("$J=G90 G21 X{x:.3} Y{y:.3} F{:.1}", self.rate));
        }
        String::new()
    }

    fn forget(&mut self) {
        self.sent.clear();
        self.waiting.clear();
        self.run = None;
    }

    fn at_once(&self, bytes: &[u8]) {
        if let Some(local) = &self.local {
            local.send(bytes);
        }
    }

    /// Takes answers, and sends what fits.
    ///
    /// # Errors
    /// The port has ended: the link's error.
    pub fn turn(&mut self) -> Result<(), Error> {
        let Some(answers) = self.local.as_ref().and_then(Local::answers) else {
            self.end()?;
            return Err(Error::new(client::error::LINK_CLOSED, "the port of the keys has ended"));
        };
        self.received.extend_from_slice(&answers);
        while let Some(end) = self.received.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.received.drain(..=end).collect();
            self.hear(String::from_utf8_lossy(&line).trim());
        }
        let passed = self.turned.elapsed();
        self.turned = Instant::now();
        if let Some(run) = self.run.as_mut().filter(|_| self.state == "Run") {
            run.ran += passed;
        }
        if self.asked.elapsed() >= STATUS_PERIOD {
            self.asked = Instant::now();
            self.at_once(b"?");
        }
        if !self.resets {
            self.feed();
        }
        let is_over = |run: &ProgramRun, program: &Program| run.done >= program.lines.len();
        if self.run.as_ref().zip(self.program.as_ref()).is_some_and(|(run, program)| is_over(run, program))
            && self.fresh
            && self.state == "Idle"
        {
            self.run = None;
            "the program is done".clone_into(&mut self.message);
        }
        Ok(())
    }

    /// Sends lines as far as they fit.
    fn feed(&mut self) {
        loop {
            let of_program = self.run.as_ref().map(|run| run.sent);
            let (text, line) = match (self.waiting.front(), of_program) {
                (Some(text), _) => (text.clone(), None),
                (None, Some(number)) => {
                    let text = self.program.as_ref().and_then(|program| program.lines.get(number));
                    let Some(text) = text else { return };
                    (text.clone(), Some(number))
                }
                (None, None) => return,
            };
            let bytes = text.len() + 1;
            let under_way: usize = self.sent.iter().map(|sent| sent.bytes).sum();
            // A line that is longer than the buffer goes alone.
            if under_way > 0 && under_way + bytes > UNANSWERED_BYTES {
                return;
            }
            self.at_once(format!("{text}\n").as_bytes());
            self.sent.push_back(SentLine { bytes, line });
            match line {
                None => drop(self.waiting.pop_front()),
                Some(_) => {
                    if let Some(run) = &mut self.run {
                        run.sent += 1;
                    }
                }
            }
        }
    }

    /// A line of the port.
    fn hear(&mut self, line: &str) {
        if let Some(report) = line.strip_prefix('<') {
            self.fresh = true;
            report.split(['|', '>']).next().unwrap_or_default().clone_into(&mut self.state);
        } else if line.starts_with("Grbl ") {
            self.resets = false;
            self.is_alarm = false;
            self.sent.clear();
        } else if self.resets {
            // Answers to what the reset has thrown away.
        } else if line == "ok" {
            self.fresh = false;
            let of_program = self.sent.pop_front().and_then(|sent| sent.line);
            if let Some(run) = self.run.as_mut().filter(|_| of_program.is_some()) {
                run.done += 1;
            }
        } else if line.starts_with("error:") {
            self.refused(line);
        } else if let Some(text) = line.strip_prefix("[MSG:") {
            let text = text.trim_end_matches(']');
            match (self.is_alarm, self.message.starts_with("ALARM:")) {
                (false, _) => text.clone_into(&mut self.message),
                (true, true) => self.message = format!("{text} ({}); u unlocks", self.message),
                // Lines that were under way when the alarm came are refused for it.
                (true, false) => {}
            }
        } else if line.starts_with("ALARM:") {
            self.waiting.clear();
            self.run = None;
            self.is_alarm = true;
            line.clone_into(&mut self.message);
        }
    }

    /// A line was refused. One of the program stops it.
    fn refused(&mut self, answer: &str) {
        let line = self.sent.pop_front().and_then(|sent| sent.line);
        if let Some(number) = line.filter(|_| self.run.is_some()) {
            let name = self.program.as_ref().map_or("", |program| &program.name);
            let why = format!("{name}:{}: {} ({answer}); stopped", number + 1, self.message);
            self.press(Key::Stop);
            self.message = why;
        }
        // What was to follow it makes no sense without it.
        self.waiting.clear();
    }

    /// The sender goes: dark at once, everything comes to rest.
    ///
    /// # Errors
    /// The link's.
    pub fn end(&mut self) -> Result<(), Error> {
        self.local = None;
        self.ends.store(true, Ordering::Relaxed);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(served)) => served.map(drop),
            _ => Ok(()),
        }
    }
}

impl Drop for Panel {
    fn drop(&mut self) {
        let _ = self.end();
    }
}
