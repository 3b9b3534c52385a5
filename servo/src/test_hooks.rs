//! A long life in one step: a hook for tests, in no image (feature `test-hooks`).
//!
//! In: how many entries, how much time. Out: every count of the tick as it would be then. Counts
//! wrap; their comparisons are right across that, or a test that begins just before it fails.
use crate::laser::LaserView;
use crate::tick::Tick;
use crate::tick_command::Lane;
use crate::units::Ns;
use crate::view::{AxisView, CrdView};

/// Entry numbers of a lane have 31 bits; the bit above says which lane.
const NUMBER: u32 = u32::MAX >> 1;

fn later(seq: u32, entries: u32, lane: Lane) -> u32 {
    let flag = if lane == Lane::Program { !NUMBER } else { 0 };
    flag | seq.wrapping_add(entries) & NUMBER
}

impl<const AXES: usize> Tick<AXES> {
    /// As if each lane had executed so many entries more, every other count had risen by as many,
    /// and `time` had passed. Nothing may run or be in flight; the thread's side must advance
    /// alike.
    pub fn advance_counters(&mut self, entries: u32, time: Ns) {
        self.now = Ns(self.now.0.wrapping_add(time.0));
        self.done_immediate = later(self.done_immediate, entries, Lane::Immediate);
        self.done_program = later(self.done_program, entries, Lane::Program);
        self.ticks = self.ticks.wrapping_add(entries);
        let add = |count: &mut u32| *count = count.wrapping_add(entries);
        for axis in &mut self.axes {
            let AxisView { moves, turns, counts, changes, epoch, cleared: [first, second], .. } = &mut axis.published;
            [moves, turns, counts, changes, epoch, first, second].into_iter().for_each(add);
        }
        for crd in &mut self.crds.states {
            let CrdView { moves, changes, cleared: [first, second], .. } = &mut crd.published;
            [moves, changes, first, second].into_iter().for_each(add);
        }
        add(&mut self.crds.moves);
        for channel in &mut self.lasers.channels {
            let LaserView { moves, turns, changes, .. } = &mut channel.published;
            [moves, turns, changes].into_iter().for_each(add);
        }
    }

    /// As if each FIFO of a path had got and executed so many entries and motions more since it was
    /// cleared. Each laser is as if it had been on for so many units of its on-time more. Nothing
    /// may be in a FIFO; the thread's side must advance alike.
    pub fn advance_fifo_counters(&mut self, by: u32) {
        let add = |count: &mut u32| *count = count.wrapping_add(by);
        for crd in &mut self.crds.states {
            let CrdView { ends, released, done, .. } = &mut crd.published;
            [ends, released, done].into_iter().flatten().for_each(add);
            crd.path.discard_prepared();
            for cursor in &mut crd.path.cursors {
                [&mut cursor.next, &mut cursor.done, &mut cursor.left_at].into_iter().for_each(add);
            }
            crd.mark_changed();
        }
        self.crds.moves = self.crds.moves.wrapping_add(1);
        self.lasers.channels.iter_mut().for_each(|channel| add(&mut channel.on_time.units));
    }
}
