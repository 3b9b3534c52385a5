//! How the FIFOs of coordinate systems are fed: commits, look-aheads of running paths, what a
//! dropped program gave them.
//!
//! In: the view, the shadow state. Out: commits, through either lane. Owns nothing.
//! Fails: if the lane has no room, nothing is pushed and the caller tries again.
use super::admission::Admission;
use super::staged::STAGED_MAX;
use crate::plan::path_queue::LASTS_MS;
use crate::refuse::FifoOf;
use crate::shadow::{PROGRAM_FLAG, executed};
use servo::units::Crd;
use servo::view::View;

impl<const AXES: usize> Admission<'_, AXES> {
    /// Running paths whose entries do not last long enough get more from their look-aheads.
    pub fn feed_paths(&mut self, view: &View<AXES>) {
        self.feed_due = u64::MAX;
        for crd in Crd::all().take(self.entries.count()) {
            let (sampled, shadow) = (&view.crds[crd.index()], self.admitted.crd(crd));
            // Data after a WaitStop does not feed the path before it.
            let started = shadow.started.is_some_and(|seq| executed(view, seq));
            let (fifo, index) = (sampled.fifo, usize::from(sampled.fifo & 1));
            let Some(queues) = self.queues.get_mut(crd.index()).filter(|_| sampled.runs && started) else { continue };
            let queue = &mut queues[index];
            queue.update_cleared(shadow.path(fifo).cleared);
            let Some(stores) = self.entries.get(crd.index()).filter(|_| queue.waiting() > 0) else { continue };
            if self.lane.room() > STAGED_MAX && queue.feed(stores, sampled, fifo) {
                self.commit_now(FifoOf::Crd(crd), fifo);
            }
            let Some(queue) = self.queues.get_mut(crd.index()).map(|queues| &mut queues[index]) else { continue };
            let margin_ns = (queue.lasts(stores, sampled, fifo) - LASTS_MS).max(0.0) * 1e6;
            let due = view.now.0.saturating_add(margin_ns as u64);
            if queue.waiting() > 0 {
                self.feed_due = self.feed_due.min(due);
            }
        }
    }

    /// Hands all of a look-ahead to a running path, before a WaitStop for it. False if that cannot
    /// be now.
    pub fn flush_path(&mut self, view: &View<AXES>, crd: Crd, soon: bool) -> bool {
        let shadow = self.admitted.crd(crd);
        let (fifo, index) = (shadow.fifo, usize::from(shadow.fifo & 1));
        if !shadow.may_run(view, &view.crds[crd.index()]) {
            return true;
        }
        let cleared = shadow.path(fifo).cleared;
        let Some((queues, stores)) = self.queues.get_mut(crd.index()).zip(self.entries.get(crd.index())) else {
            return true;
        };
        queues[index].update_cleared(cleared);
        if queues[index].waiting() == 0 {
            return true;
        }
        if !soon || self.lane.room() <= STAGED_MAX {
            return false;
        }
        queues[index].flush(&stores[index]);
        self.commit_now(FifoOf::Crd(crd), fifo);
        true
    }

    /// After a program was dropped: forgets what it gave to FIFOs and was not executed. A FIFO is
    /// emptied if its slots were overwritten, or if executed and dropped entries waited together in
    /// a look-ahead.
    pub fn forget_paths(&mut self, view: &View<AXES>) {
        for crd in Crd::all().take(self.entries.count()) {
            for fifo in 0..2u8 {
                let ahead = self.admitted.crd(crd).path(fifo);
                let pending = ahead.last.is_some_and(|seq| seq & PROGRAM_FLAG != 0 && !executed(view, seq));
                if !pending && !ahead.loose {
                    continue;
                }
                let (now, sampled) = (self.executed.crd(crd).path(fifo), &view.crds[crd.index()]);
                let overwritten = ahead.cleared != now.cleared && ahead.data.given != 0;
                let mixed = ahead.look.is_some() && now.data.given != sampled.ends[usize::from(fifo)];
                let given = now.data.given;
                if given != 0 && !sampled.runs && (overwritten || mixed) {
                    self.executed.invalidate_path(crd, fifo);
                } else if let Some(queues) = self.queues.get_mut(crd.index()) {
                    let queue = &mut queues[usize::from(fifo)];
                    queue.update_cleared(now.cleared);
                    queue.cut(given);
                }
            }
        }
    }
}
