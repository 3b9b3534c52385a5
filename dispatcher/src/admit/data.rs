//! Data of FIFOs: PT segments, entries of Follow, entries of paths. Admission writes it to its
//! store, after the part that the tick knows. A commit publishes it at its instant.
//!
//! In: a data command. Out: what was [`Written`], and the tick command that commits all data of a
//! FIFO.
//! Fails: with a refusal, and then nothing has changed. A commit cannot fail.
use super::admission::{Admission, context};
use super::context::{Context, DueInstant, Effect};
use super::written::Written;
use super::{buffered, crd_data, kind, one};
use crate::refuse::{Admitted, FifoOf};
use crate::shadow::{CAPACITY, ShadowChange, executed};
use protocol::command::{CommandKind, DataStore, FollowSwitchNowEx, opcode};
use protocol::values::pt_state;
use servo::tick_command::TickCommand;
use servo::view::View;

/// Whether a command is data. A PathMany holds such commands.
pub fn is_data(number: u16, body: &[u8]) -> bool {
    match number {
        // A switch that is queued.
        opcode::FollowSwitchNowEx => one::<FollowSwitchNowEx>(body).is_ok_and(|r| r.buffer.get() != 0),
        _ => matches!(kind(number), Some(CommandKind::Data(fifo)) if fifo != DataStore::Joined),
    }
}

impl<const AXES: usize> Admission<'_, AXES> {
    /// Admits data and commits it through the immediate lane; the caller has checked that there is
    /// room. None if the command is no data.
    pub fn publish(
        &mut self,
        view: &View<AXES>,
        due: DueInstant,
        number: u16,
        body: &[u8],
    ) -> Option<Admitted<Written>> {
        is_data(number, body).then(|| {
            let written = self.admit_data(view, due, number, body)?;
            self.commit_now(written.of, written.fifo);
            Ok(written)
        })
    }

    /// Admits a data command, all of it or nothing: writes it to the store and enters it into the
    /// admitted state. Its commit follows.
    pub fn admit_data(&mut self, view: &View<AXES>, due: DueInstant, number: u16, body: &[u8]) -> Admitted<Written> {
        let context = context!(self, view, due, self.staged);
        let paths = (&mut *self.queues, self.entries);
        let (written, change) = match kind(number) {
            Some(CommandKind::Data(DataStore::Pt)) => context.pt_data(self.stores, number, body)?,
            Some(CommandKind::Data(DataStore::Path | DataStore::Lines)) => {
                crd_data::data(&context, paths, number, body)?
            }
            Some(CommandKind::Data(DataStore::Light)) => buffered::data(&context, paths, number, body)?,
            _ => context.follow_data(self.stores, number, body)?,
        };
        if let FifoOf::Axis(axis) = written.of
            && self.admitted.overwrites(view, axis, written.fifo)
        {
            let (now, ahead) = (self.executed.axis(axis), self.admitted.axis(axis));
            let all = now.mode != ahead.mode || ahead.is_dynamic();
            self.executed.invalidate_fifos(axis, if all { 3 } else { 1 << (written.fifo & 1) });
        }
        self.admitted.enter(&change, 0);
        if let (FifoOf::Crd(crd), Some((channel, table))) = (written.of, written.named) {
            // Also if the program is dropped before its commit: the table counts as named until the
            // FIFO is empty.
            for shadows in [&mut self.executed, &mut self.admitted] {
                shadows.name_follow_table(channel, table, crd, written.fifo);
            }
        }
        Ok(written)
    }

    /// Whether the motion of a FIFO makes room in it: it runs, or will when all is executed.
    pub fn drains(&self, view: &View<AXES>, (of, fifo): (FifoOf, u8)) -> bool {
        match of {
            FifoOf::Axis(axis) => {
                let runs = view.axes.get(axis.index()).is_some_and(|sampled| sampled.pt_state == pt_state::RUNNING);
                let shadow = self.admitted.axis(axis);
                shadow.is_dynamic() && shadow.started.is_some_and(|start| runs || !executed(view, start))
            }
            FifoOf::Crd(crd) => {
                let shadow = self.admitted.crd(crd);
                shadow.fifo == fifo && view.crds.get(crd.index()).is_some_and(|sampled| shadow.may_run(view, sampled))
            }
        }
    }

    /// How many quarters of a FIFO are free.
    pub fn free_quarters(&self, view: &View<AXES>, (of, fifo): (FifoOf, u8)) -> u32 {
        let (space, capacity) = match of {
            FifoOf::Axis(axis) => {
                let (shadow, sampled) = (self.admitted.axis(axis), view.axes.get(axis.index()));
                let space = sampled.map_or(0, |sampled| shadow.space(view, sampled, fifo.into()));
                (space, shadow.capacity())
            }
            FifoOf::Crd(crd) => {
                let sampled = view.crds.get(crd.index());
                (sampled.map_or(0, |sampled| self.admitted.crd(crd).space(sampled, fifo)), CAPACITY)
            }
        };
        space.saturating_mul(4) / capacity.max(1)
    }

    /// The commit of all admitted data of a FIFO; of a path, what has left its look-ahead or never
    /// went there.
    pub fn commit(&mut self, of: FifoOf, fifo: u8) -> (TickCommand, ShadowChange) {
        let index = usize::from(fifo & 1);
        match of {
            FifoOf::Crd(crd) => {
                let queues = self.queues.get_mut(crd.index()).zip(self.entries.get(crd.index()));
                let end = queues.map_or(0, |(queues, stores)| queues[index].release_final_when_due(&stores[index]));
                self.admitted.commit_of_path(crd, fifo, end)
            }
            FifoOf::Axis(axis) => self.admitted.commit_of_axis(axis, fifo),
        }
    }

    /// Pushes that commit into the immediate lane; the caller has checked that there is room.
    pub fn commit_now(&mut self, of: FifoOf, fifo: u8) {
        let (command, change) = self.commit(of, fifo);
        self.lane.push(command, change, 0, &mut self.admitted);
    }
}
