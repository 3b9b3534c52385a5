//! A long life in one step, the thread's half: a hook for tests, in no image (feature
//! `test-hooks`).
//!
//! In: how many entries. Out: every count of the thread as it would be then. The tick's half is
//! [`Tick::advance_counters`](servo::tick::Tick::advance_counters); both advance alike.
use crate::plan::look_ahead::LookAhead;
use crate::plan::path_queue::PathQueue;
use crate::session::server::Server;
use crate::shadow::{PathData, seq_from};
use crate::tick_queue::TickQueue;

impl<const AXES: usize> Server<'_, AXES> {
    /// Advances the numbers of each lane by `entries`, before the next tick. Nothing may be in
    /// flight.
    pub fn advance_counters(&mut self, entries: u32) {
        self.handler.admission.lane.advance_counters(entries);
        self.program.lane.advance_counters(entries);
    }

    /// Advances the counts of entries and motions of each FIFO of a path, with
    /// [`Tick::advance_fifo_counters`](servo::tick::Tick::advance_fifo_counters). The FIFOs must be
    /// empty.
    pub fn advance_fifo_counters(&mut self, by: u32) {
        let admission = &mut self.handler.admission;
        let paths = admission.admitted.crds.iter().flat_map(|crd| &crd.fifos);
        for (queue, path) in admission.queues.iter_mut().flatten().zip(paths) {
            queue.update_cleared(path.cleared);
            queue.advance_counters(by);
        }
        for shadows in [&mut admission.executed, &mut admission.admitted] {
            for path in shadows.crds.iter_mut().flat_map(|crd| &mut crd.fifos) {
                let PathData { given, over, motions, .. } = &mut path.data;
                [given, over, motions].into_iter().for_each(|count| *count = count.wrapping_add(by));
            }
        }
    }
}

impl<const N: usize> TickQueue<'_, N> {
    /// Nothing may be in flight, or nothing changes.
    fn advance_counters(&mut self, entries: u32) {
        if !self.in_flight() {
            self.last = seq_from(self.last, entries);
        }
    }
}

impl PathQueue {
    /// The queue must be empty.
    fn advance_counters(&mut self, by: u32) {
        for counter in [&mut self.first, &mut self.end, &mut self.next] {
            *counter = counter.wrapping_add(by);
        }
        self.look.advance_counters(by);
    }
}

impl<const N: usize, const STEPS: usize> LookAhead<N, STEPS> {
    /// The queue must be empty. Its counters are as wide as an address: `by` counts with its sign,
    /// so that counters of any width are equally far from wrapping.
    fn advance_counters(&mut self, by: u32) {
        let by = by.cast_signed() as isize as usize;
        (self.first, self.end) = (self.first.wrapping_add(by), self.end.wrapping_add(by));
        self.undecided.slot = self.undecided.slot.wrapping_add(by);
    }
}
