//! The settings of an axis for following, and the contents of its FIFOs.
use super::entry::{FifoTail, STOPS};
use super::gear::GearRatio;
use super::{Direction, FollowEntries, Master, StartEvent};

crate::state! {
    /// The committed part of a FIFO.
    #[derive(Debug, Clone, Copy)]
    pub struct CommittedFifo {
        /// Entries.
        pub(super) end: u32 = 0,
        pub(super) tail: FifoTail = FifoTail { ratio: 0, down: false, continues: 0, last_stop: 0 },
        /// Indices of those that are no segments, in order.
        pub(super) stops: [u16; STOPS] = [0; STOPS],
        /// How many.
        pub(super) count: u8 = 0,
    }
    const EMPTY;
}

crate::state! {
    /// The settings of one axis and its FIFOs.
    #[derive(Debug, Clone, Copy)]
    pub struct Setup {
        /// Which of the master's motion counts.
        pub direction: Direction = Direction::Both,
        /// The axis or encoder that it follows.
        pub master: Option<Master> = None,
        /// What begins the motion.
        pub event: StartEvent = StartEvent::Start,
        /// Passes to run, 0 for ever.
        pub passes: u32 = 1,
        /// Ratio of the next start in gear; none in another mode, or while none is set.
        pub gear: Option<GearRatio> = None,
        pub(super) fifos: [CommittedFifo; 2] = [CommittedFifo::EMPTY; 2],
    }
    /// Nothing set, both FIFOs empty.
    pub const POWER_ON;
}

impl CommittedFifo {
    /// The first entry from `index` on that is no segment.
    #[inline]
    pub(super) fn stop_from(&self, index: u32) -> Option<u32> {
        self.stops.iter().take(self.count as usize).map(|stop| *stop as u32).find(|stop| *stop >= index)
    }
}

impl Setup {
    /// A FIFO.
    #[inline(always)]
    pub(super) fn fifo(&self, fifo: u8) -> &CommittedFifo {
        let [first, second] = &self.fifos;
        if fifo == 0 { first } else { second }
    }

    fn fifo_mut(&mut self, fifo: u8) -> &mut CommittedFifo {
        let [first, second] = &mut self.fifos;
        if fifo == 0 { first } else { second }
    }

    /// Whether a FIFO holds nothing.
    pub fn is_empty(&self, fifo: u8) -> bool {
        self.fifo(fifo).end == 0
    }

    /// Both FIFOs are empty.
    pub fn clear_all(&mut self) {
        self.clear(0);
        self.clear(1);
    }

    /// A FIFO is empty.
    pub fn clear(&mut self, fifo: u8) {
        // Stops beyond their count are unused.
        let CommittedFifo { end, tail, count, stops: _ } = self.fifo_mut(fifo);
        (*end, *tail, *count) = (0, CommittedFifo::EMPTY.tail, 0);
    }

    /// As at power-on.
    pub(crate) fn reset(&mut self) {
        *self = Setup { fifos: self.fifos, ..Setup::POWER_ON };
        self.clear_all();
    }

    /// Its entries below `end` count from now on. The new ones that are no segments are found by
    /// their links.
    pub fn commit(&mut self, fifo: u8, end: u32, tail: FifoTail, source: &impl FollowEntries) {
        let to = self.fifo_mut(fifo);
        let old = to.end;
        (to.end, to.tail) = (end, tail);
        let mut found = [0; STOPS];
        let mut link = tail.last_stop as u32;
        let mut changed = 0;
        for slot in &mut found {
            if link <= old {
                break;
            }
            *slot = link.wrapping_sub(1) as u16;
            changed += 1;
            link = source.entry(fifo, link.wrapping_sub(1)).stop_before();
        }
        for stop in found.iter().take(changed).rev() {
            if let Some(slot) = to.stops.get_mut(to.count as usize) {
                (*slot, to.count) = (*stop, to.count.wrapping_add(1));
            }
        }
    }
}
