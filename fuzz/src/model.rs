//! What must have been executed, and what was: the model of [`crate::machine`].
//!
//! In: numbers of requests and what became of them; what the controller reports of its FIFOs; what
//! its path does. Fails: by a panic where a request is lost, doubled or out of order.
//!
//! Entries of the path have their numbers in what they do. Even ones are marks: analog output 8
//! takes the number, negative in FIFO 1. Odd ones take time: in FIFO 0 each is 1 ms, which an
//! output shows to the tick; in FIFO 1, which has a look-ahead, each is a motion to the place of
//! its number, which the axis shows. So an entry that is missing, doubled or at another place is
//! another time, another place or another mark.
use protocol::command::{BufDA, BufDelay, LnXY, PtData, Request};
use zerocopy::IntoBytes;

/// Requests that the model sends at most in a row, so that all fit.
pub const ENTRIES_MAX: u32 = 500;
/// Rows: segments by the immediate lane (FIFO 0) and by the program lane (FIFO 1).
pub const SEGMENTS: [usize; 2] = [0, 1];
/// Rows: entries of a path, likewise.
pub const PATHS: [usize; 2] = [2, 3];
/// Speed of the motions, pulse/ms.
const SPEED: f64 = 1.0;

/// What the model knows of one row of its requests.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Numbers given out so far.
    pub sent: u32,
    /// Answered with 0, or found in the controller.
    pub done: Vec<u32>,
    /// Of a session that ended.
    pub unknown: Vec<u32>,
    /// Some were reported as not executed since the last look.
    pub dropped: bool,
}

/// The analog output has changed.
#[derive(Debug, Clone, Copy)]
pub struct Mark {
    /// In this tick.
    pub at: u32,
    /// To this.
    pub value: i16,
    /// Where the path was then, pulses.
    pub place: f64,
}

/// What a path did.
#[derive(Debug)]
pub struct Ran {
    /// What the output was before it, and every change.
    pub marks: Vec<Mark>,
    /// How long it ran, ticks.
    pub ticks: u32,
    /// Motions that it has counted.
    pub motions: u32,
    /// Ticks of a millisecond.
    pub ticks_of_ms: u32,
    /// Where it came to rest, pulses.
    pub place: f64,
}

/// The segment of a number: PT, at the place and the time of it.
pub fn segment(fifo: usize, number: i32) -> PtData {
    PtData {
        core: 1.into(),
        profile: 8.into(),
        pos: f64::from(number).into(),
        time_ms: number.into(),
        kind: 1.into(),
        fifo: (fifo as i16).into(),
    }
}

/// The entry of a number: see the module text.
pub fn path_entry(fifo: usize, number: u32) -> (u16, Vec<u8>) {
    let (core, crd) = (1.into(), 2.into());
    match (number % 2, fifo) {
        (0, _) => {
            let (channel, value, fifo) = (8.into(), mark(fifo, number).into(), (fifo as i16).into());
            (BufDA::OPCODE, BufDA { core, crd, channel, value, fifo }.as_bytes().to_vec())
        }
        (_, 0) => (BufDelay::OPCODE, BufDelay { core, crd, delay_ms: 1.into(), fifo: 0.into() }.as_bytes().to_vec()),
        _ => {
            let (x, y, syn_vel, syn_acc) = ((number as i32).into(), 0.into(), SPEED.into(), 1.0.into());
            let line = LnXY { core, crd, x, y, syn_vel, syn_acc, vel_end: 0.0.into(), fifo: 1.into() };
            (LnXY::OPCODE, line.as_bytes().to_vec())
        }
    }
}

fn mark(fifo: usize, number: u32) -> i16 {
    if fifo == 0 { number as i16 } else { -(number as i16) }
}

fn steps(numbers: &[u32]) -> usize {
    numbers.iter().filter(|number| *number % 2 == 1).count()
}

impl Row {
    /// So many are there, and the last of them is this, if that is known.
    pub fn settle(&mut self, there: usize, last: Option<u32>) {
        let least = self.done.len();
        assert!(self.done.is_sorted(), "answered in order: {self:?}");
        assert!((least..=least + self.unknown.len()).contains(&there), "{there} are there: {self:?}");
        if let Some(last) = last {
            let all = self.all();
            assert!(last == 0 || all.contains(&last), "{last} is the last one there: {self:?}");
            assert!(last >= self.done.last().copied().unwrap_or(0), "{last} is the last one there: {self:?}");
            let before = all.iter().filter(|number| **number <= last).count();
            assert!(there <= before, "{there} are there up to {last}: {self:?}");
        }
        // What was unknown is decided now; which of it is there is known by its number only where
        // all of it is.
        let found = there - least;
        let mut done = std::mem::take(&mut self.unknown);
        done.truncate(found);
        self.done.append(&mut done);
        self.done.sort_unstable();
    }

    /// What may be there, in order.
    fn all(&self) -> Vec<u32> {
        let mut all: Vec<u32> = self.done.iter().chain(&self.unknown).copied().collect();
        all.sort_unstable();
        all
    }

    /// Everything was executed: nothing is there.
    pub fn forget(&mut self) {
        self.done.clear();
        self.unknown.clear();
        self.dropped = false;
    }

    /// Whether a FIFO with a look-ahead may have been emptied: the rest of a program was dropped
    /// (`docs/crd.md`).
    pub fn may_be_emptied(&self) -> bool {
        self.dropped || !self.unknown.is_empty()
    }

    /// Compares what the path of a FIFO did with what must have been in it, `there` entries, from a
    /// place. Out: the place where it must rest.
    pub fn compare(&self, fifo: usize, there: usize, ran: &Ran, from: u32) -> u32 {
        let all = self.all();
        assert!(self.done.is_sorted(), "answered in order: {self:?}");
        assert!((self.done.len()..=all.len()).contains(&there), "{there} are there: {self:?}");
        // How many took time, and how many marks are left.
        let (spent, rest) = (ran.ticks / ran.ticks_of_ms, ran.ticks % ran.ticks_of_ms);
        let stepped = if fifo == 0 { spent as usize } else { ran.motions as usize };
        assert!(fifo == 1 || rest <= 2, "whole ms: {ran:?}, {self:?}");
        let [least, most] = [&self.done, &all].map(|numbers| steps(numbers));
        assert!((least..=most).contains(&stepped), "{stepped} of {least} to {most}: {ran:?}, {self:?}");
        let marked = there.checked_sub(stepped);
        let [least, most] = [self.done.len() - least, all.len() - most];
        assert!(
            marked.is_some_and(|count| (least..=most).contains(&count)),
            "{marked:?} marks of {least} to {most}: {ran:?}, {self:?}"
        );
        // Each mark once and in order; a mark stays if an entry after it takes time.
        let mut numbers = all.iter();
        for shown in ran.marks.iter().skip(1) {
            let number = numbers.find(|number| *number % 2 == 0 && mark(fifo, **number) == shown.value);
            let Some(&number) = number else { panic!("mark {}: {ran:?}, {self:?}", shown.value) };
            if fifo == 1 {
                let end =
                    |numbers: &[u32]| numbers.iter().copied().rfind(|n| n % 2 == 1 && *n < number).unwrap_or(from);
                let (low, high) = (f64::from(end(&self.done).max(from)), f64::from(end(&all)));
                // The output is looked at once a tick, and shows what comes before the next.
                let tick = SPEED / f64::from(ran.ticks_of_ms) + 0.001;
                assert!((low - tick..=high + tick).contains(&shown.place), "mark {number}: {ran:?}, {self:?}");
            }
        }
        for pair in self.done.windows(2) {
            if pair[0] % 2 == 0 && pair[1] == pair[0] + 1 {
                let value = mark(fifo, pair[0]);
                assert!(ran.marks.iter().any(|shown| shown.value == value), "mark {value}: {ran:?}, {self:?}");
            }
        }
        if fifo == 0 {
            self.compare_times(ran);
            return from;
        }
        let end = |numbers: &[u32]| numbers.iter().copied().rfind(|n| n % 2 == 1).unwrap_or(from);
        let place = ran.place.round() as u32;
        assert!((ran.place - f64::from(place)).abs() < 0.001, "rests at a whole pulse: {ran:?}");
        assert!((end(&self.done)..=end(&all)).contains(&place), "rests at {place}: {ran:?}, {self:?}");
        place
    }

    /// Where nothing is unknown, every mark of FIFO 0 has its tick.
    fn compare_times(&self, ran: &Ran) {
        if !self.unknown.is_empty() {
            return;
        }
        let mut due: Vec<(u32, i16)> = Vec::new();
        let mut at = 0;
        for &number in &self.done {
            if number % 2 == 1 {
                at += ran.ticks_of_ms;
                continue;
            }
            // Of two in one instant the second stays.
            due.retain(|(before, _)| *before != at);
            due.push((at, mark(0, number)));
        }
        let since = |marks: Vec<(u32, i16)>| -> Vec<(u32, i16)> {
            let first = marks.first().map_or(0, |(at, _)| *at);
            marks.into_iter().map(|(at, value)| (at - first, value)).collect()
        };
        let seen = ran.marks.iter().skip(1).map(|mark| (mark.at, mark.value)).collect();
        assert_eq!(since(seen), since(due), "{ran:?}, {self:?}");
    }
}
