//! The content of a FIFO of a coordinate system.
use super::*;

/// What lies in a FIFO.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// With the end, and the coordinates that have a target there, a bit each: the others stay.
    Motion(Geometry, Rates, [f64; 4], u8),
    Delay(f64),
    /// BufIO: these bits, and their levels.
    Outputs(u32, u32),
    /// BufDA: channel from 0.
    Analog(usize, i16),
    /// A change of a laser channel.
    Laser(usize, super::super::light::Command),
    /// BufMove.
    Move(Move),
    /// BufGear: this axis goes so many pulses along with the next motion.
    Gear(usize, i32),
}

/// BufMove: an axis goes to a place, and the path may wait for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    pub axis: usize,
    pub to: i32,
    pub vel: f64,
    pub acc: f64,
    pub waits: bool,
}

impl Entry {
    /// Whether the path does not stand still for it.
    pub(super) fn takes_no_time(&self) -> bool {
        !matches!(self, Entry::Motion(..) | Entry::Delay(_) | Entry::Move(Move { waits: true, .. }))
    }
}

/// An axis that goes along with a motion.
#[derive(Debug, Clone, Copy)]
pub struct Gear {
    pub axis: usize,
    pub(super) pulses: i32,
    /// Where it would have been at the motion's begin.
    pub(super) base: Option<super::super::Fix>,
}

impl Gear {
    /// Whether its motion is in progress.
    pub fn is_engaged(&self) -> bool {
        self.base.is_some()
    }

    pub(super) fn at(&self, share: f64) -> Option<super::super::Fix> {
        Some(self.base? + super::super::Fix::of_f64(f64::from(self.pulses) * share))
    }
}

/// What SetCrdPrm said.
#[derive(Debug, Clone)]
pub struct Set {
    pub frame: Frame,
    /// The axis of each coordinate, and where it has the coordinate 0.
    pub axes: [Option<usize>; 4],
    /// The name that each axis has there.
    pub zero: [super::super::Fix; 4],
}

/// A FIFO.
#[derive(Debug, Clone, Default)]
pub struct Fifo {
    pub entries: Vec<Entry>,
    /// The entry in progress, and how much of it is done: pulses or ms.
    pub next: usize,
    pub(super) done: f64,
    /// Axes geared to the motion in progress, or to the next one.
    pub gears: Vec<Gear>,
    /// The entries before this one have been executed.
    pub(super) reported: usize,
    /// A Stop ended the wait for the move in progress.
    pub(super) waited: bool,
    /// So many entries were there at the tick before.
    pub(super) seen: usize,
    /// So many entries were there at the last Stop.
    pub(super) stopped: usize,
    /// Where it was left, if it was left within its data.
    pub left: Option<[f64; 4]>,
    /// An interlock stopped it within its data, and its path ran with the other FIFO since.
    pub lost: bool,
}

impl Fifo {
    /// A Stop: whether motions are left is not known ahead.
    pub fn stop(&mut self) {
        self.stopped = self.entries.len();
    }

    /// Whether the end of what it holds is known, though it was stopped.
    pub fn ends_anew(&self) -> bool {
        self.entries.iter().skip(self.stopped).any(|entry| matches!(entry, Entry::Motion(..)))
    }

    /// Axes that go along with the next motion that will be given.
    pub fn geared_to_next(&self) -> Vec<usize> {
        let mut axes = Vec::new();
        for entry in self.entries.iter().rev() {
            match entry {
                Entry::Motion(..) => break,
                Entry::Gear(axis, _) => axes.push(*axis),
                _ => {}
            }
        }
        axes
    }

    /// Whether all that is left of the first so many entries takes no time.
    pub(super) fn takes_no_time(&self, held: usize) -> bool {
        // The axis of a move that was waited for may be there by now.
        let over = |index: usize, entry: &Entry| {
            let waited = self.waited && index == self.next;
            entry.takes_no_time() || *entry == Entry::Delay(0.0) || waited
        };
        (self.next..held).all(|index| over(index, &self.entries[index]))
    }

    /// Axes that go along with a motion in which it was left.
    pub fn geared_within(&self) -> Vec<usize> {
        let within = self.done > 0.0 && matches!(self.entries.get(self.next), Some(Entry::Motion(..)));
        self.gears.iter().filter(|_| within).map(|gear| gear.axis).collect()
    }

    /// The axes that its entries move.
    pub fn moves(&self) -> u32 {
        let of = |entry: &Entry| match entry {
            Entry::Move(Move { axis, .. }) | Entry::Gear(axis, _) => 1 << axis,
            _ => 0,
        };
        self.entries.iter().map(of).fold(0, |mask, axis| mask | axis)
    }

    pub fn waiting(&self) -> usize {
        self.entries.len() - self.next
    }

    /// Of those, the ones that take time.
    pub fn lasting(&self) -> usize {
        let lasts = |entry: &&Entry| !entry.takes_no_time() && **entry != Entry::Delay(0.0);
        self.entries[self.next..].iter().filter(lasts).count()
    }

    /// Where the first remaining motion continues.
    pub fn begins(&self) -> Option<[f64; 4]> {
        let motion = self.entries[self.next..].iter().position(|entry| matches!(entry, Entry::Motion(..)))?;
        let Entry::Motion(geometry, ..) = &self.entries[self.next + motion] else { return None };
        Some(geometry.at(if motion == 0 { self.done } else { 0.0 }))
    }

    /// The same of the first so many entries.
    pub fn waiting_of(&self, held: usize) -> usize {
        held.saturating_sub(self.next)
    }

    /// Motions completed, and left of the first so many entries.
    pub fn segments(&self, held: usize) -> [i64; 2] {
        let count = |entries: &[Entry]| entries.iter().filter(|entry| matches!(entry, Entry::Motion(..))).count();
        let held = held.clamp(self.next, self.entries.len());
        [count(&self.entries[..self.next]) as i64, count(&self.entries[self.next..held]) as i64]
    }
}
