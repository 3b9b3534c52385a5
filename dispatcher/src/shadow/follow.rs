//! Shadow state of an axis that follows: its settings as given, its FIFOs, and whether the tick may
//! be about to change them by itself.
//!
//! The tick empties a FIFO that a switch leaves, at a time that only the master decides. So the
//! effect of a command on the FIFOs of an axis that may switch is known only at its instant
//! ([`super::AxisShadow::may_switch`]).
use super::is_in_flight;
use servo::segment::follow::FollowChain;
use servo::units::Axis;
use servo::view::{AxisView, View};

/// One FIFO of entries.
#[derive(Debug, Clone, Copy, Default)]
pub struct FollowFifoShadow {
    /// The state from which the next entry continues.
    pub chain: FollowChain,
    /// The master's position at its end as the user gave it, pulses.
    pub master: f64,
    /// The slave's.
    pub slave: f64,
    /// One of its entries switches to the other FIFO.
    pub switches: bool,
}

impl FollowFifoShadow {
    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        self.chain.entries() == 0
    }
}

/// Follow, FollowEx and Gear of one axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct FollowShadow {
    /// −1, 0 or +1.
    pub direction: i8,
    /// Memory selector, 0 or 1.
    pub memory: u8,
    /// The master, and index, type and item as they were given.
    pub master: Option<(Axis, [i16; 3])>,
    /// Event, direction and position as they were given.
    pub event: (i16, i16, i32),
    /// Ratio of Gear: master, slave and slope as they were given.
    pub ratio: Option<[i32; 3]>,
    /// The data.
    pub fifos: [FollowFifoShadow; 2],
    /// Times the tick has emptied each, by the view that this state follows.
    pub cleared: [u32; 2],
    /// The last entry that emptied each while it held something, until it is executed.
    emptied: [Option<u32>; 2],
    /// The last entry that switches, until it is executed.
    switch: Option<u32>,
}

impl FollowShadow {
    /// At power-on (SPEC 5); its default is all zero.
    pub fn power_on() -> Self {
        FollowShadow { event: (1, 1, 0), ..FollowShadow::default() }
    }

    /// One FIFO.
    pub fn fifo(&self, fifo: u8) -> &FollowFifoShadow {
        &self.fifos[usize::from(fifo & 1)]
    }
    /// Entries that a FIFO holds.
    pub fn capacity(&self) -> u32 {
        if self.memory == 0 { 16 } else { 512 }
    }
    /// Free slots of a FIFO.
    pub fn space(&self, fifo: u8) -> u32 {
        self.capacity().saturating_sub(self.fifo(fifo).chain.entries())
    }
    /// Whether an entry of a FIFO switches to the other one.
    pub fn has_switches(&self) -> bool {
        self.fifos.iter().any(|fifo| fifo.switches)
    }
    /// Whether an entry that switches is in flight.
    pub fn is_to_switch<const AXES: usize>(&self, view: &View<AXES>) -> bool {
        is_in_flight(view, self.switch)
    }
    /// The entry that emptied this FIFO last.
    pub fn emptied(&self, fifo: u8) -> Option<u32> {
        self.emptied[usize::from(fifo & 1)]
    }
    /// Whether the tick has still to execute the entry that empties this FIFO.
    pub fn is_invalid<const AXES: usize>(&self, view: &View<AXES>, fifo: u8) -> bool {
        is_in_flight(view, self.emptied[usize::from(fifo & 1)])
    }

    /// Calls `young` with every entry number.
    pub(super) fn renew(&mut self, young: &mut impl FnMut(&mut u32)) {
        self.emptied.iter_mut().chain([&mut self.switch]).flatten().for_each(young);
    }

    /// Entry `seq` empties a FIFO.
    pub fn empty(&mut self, fifo: u8, seq: u32) {
        let slot = usize::from(fifo & 1);
        if !self.fifos[slot].is_empty() {
            self.emptied[slot] = Some(seq);
        }
        self.fifos[slot] = FollowFifoShadow::default();
    }
    /// Entry `seq` empties both.
    pub fn empty_both(&mut self, seq: u32) {
        self.empty(0, seq);
        self.empty(1, seq);
    }
    /// Entry `seq` switches.
    pub fn switched(&mut self, seq: u32) {
        self.switch = Some(seq);
    }
    /// Another mode has been set: only the settings of Set…Loop and Set…Memory stay.
    pub fn forget(&mut self, seq: u32) {
        self.empty_both(seq);
        (self.direction, self.master, self.event) = (0, None, FollowShadow::power_on().event);
        self.ratio = None;
    }
    /// Reset. The tick's counts continue.
    pub fn reset(&mut self, seq: u32) {
        self.empty_both(seq);
        let FollowShadow { cleared, emptied, .. } = *self;
        *self = FollowShadow { cleared, emptied, ..FollowShadow::power_on() };
    }
    /// Follows the tick: a FIFO that was left is empty.
    pub fn update_from(&mut self, sampled: &AxisView) {
        for ((fifo, known), now) in self.fifos.iter_mut().zip(&mut self.cleared).zip(sampled.cleared) {
            if *known != now {
                (*known, *fifo) = (now, FollowFifoShadow::default());
            }
        }
    }
}
