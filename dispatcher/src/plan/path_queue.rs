//! The queue of one FIFO of a coordinate system before the tick: through the look-ahead, if it has
//! one, into the store.
//!
//! In: motions and other entries in the order of their calls. Out: entries in the store, and how
//! many of them the tick may read ([`PathQueue::end`]). Owns: the look-ahead's memory, how long
//! each entry lasts. An entry lies in its slot of the store from its call on. What waits in the
//! look-ahead gets its speeds there before the tick may read it.
//! Fails: never; the caller has checked that the FIFO has a free slot.
//!
//! An entry leaves the look-ahead in four cases: its speeds are final, the look-ahead is full, at a
//! flush, or the tick's data does not last long enough ([`PathQueue::feed`]). Then it is as fast as
//! the present data allows, and safe.
use super::geometry::Geometry;
use super::look_ahead::{Limits, LookAhead};
use servo::path::{ENTRIES, EntryContent, EntryStore, MotionSpeeds, PathEntry};
use servo::view::CrdView;

pub use crate::capacity::LOOK_AHEAD_MOTIONS;
use crate::capacity::LOOK_AHEAD_STEPS;

/// The tick's data of a running path lasts at least this long, if there is more, ms. That is longer
/// than the thread is ever away.
pub const LASTS_MS: f64 = 10.0;
/// A motion of which the tick's data holds several, ms.
const SHORT_MS: f32 = LASTS_MS as f32 / 4.0;
/// Units of a time per millisecond.
const UNITS_PER_MS: f64 = 1024.0;

/// How long an entry lasts, to 1 in 2048 and up to two minutes, rounded down.
#[derive(Debug, Clone, Copy)]
struct PackedDuration(u16);

impl PackedDuration {
    const NONE: PackedDuration = PackedDuration(0);
    /// Bits of the mantissa; the bits above are its shift to the left.
    const BITS: u32 = 12;

    fn of(ms: f64) -> PackedDuration {
        let units = (ms * UNITS_PER_MS).max(0.0).min(f64::from(((1u32 << Self::BITS) - 1) << 15)) as u32;
        let shift = (u32::BITS - units.leading_zeros()).saturating_sub(Self::BITS);
        PackedDuration((units >> shift) as u16 | (shift as u16) << Self::BITS)
    }

    fn units(self) -> u64 {
        u64::from(self.0 & ((1 << Self::BITS) - 1)) << (self.0 >> Self::BITS)
    }
}

/// What a call gives to a FIFO.
pub enum Queued {
    /// A motion whose speeds the look-ahead decides; `stops`: the path stops at its end.
    Motion { geometry: Geometry, vel: f64, acc: f64, stops: bool },
    /// Any other entry, or a motion that ends at the speed of its call, and how long it lasts, ms.
    /// Entries before it in the look-ahead go before it.
    Entry(PathEntry, f64),
    /// Nothing follows for now: all of the look-ahead goes to the tick.
    Flush,
}

/// Where that goes.
pub struct Destination<'x> {
    /// How many times the FIFO was cleared.
    pub cleared: u32,
    /// The limits of its look-ahead, and how many motions that may hold.
    pub look: Option<(Limits, u16)>,
    /// Both FIFOs of its coordinate system.
    pub stores: &'x [EntryStore; 2],
    /// What the tick shows of that.
    pub sampled: &'x CrdView,
    /// Which FIFO.
    pub fifo: u8,
}

servo::state! {
    /// The data of one FIFO before the tick. All its bytes are zero at the beginning.
    pub struct PathQueue {
        pub(crate) look: LookAhead<LOOK_AHEAD_MOTIONS, LOOK_AHEAD_STEPS> =
            LookAhead::new(Limits { vel: [0.0; 4], acc: [0.0; 4], corner: 0.0 }),
        /// How long each entry lasts, by its counter.
        times: [PackedDuration; ENTRIES] = [PackedDuration::NONE; ENTRIES],
        /// The sum of those that are not over.
        sum: u64 = 0,
        pub(crate) first: u32 = 0,
        pub(crate) end: u32 = 0,
        /// After those that wait.
        pub(crate) next: u32 = 0,
        cleared: u32 = 0,
        /// Motions that the look-ahead may hold.
        count: usize = 0,
        /// How long the last motion lasts that left it, ms.
        last_ms: f32 = 0.0,
    }
    /// Empty.
    pub const fn new();
}

impl PathQueue {
    /// Forgets all that was given before the FIFO was cleared for this time.
    pub fn update_cleared(&mut self, cleared: u32) {
        if self.cleared != cleared {
            self.look.clear();
            (self.sum, self.first, self.end, self.next, self.cleared) = (0, 0, 0, 0, cleared);
        }
    }

    /// Forgets the look-ahead and all entries from this one on.
    pub fn cut(&mut self, end: u32) {
        self.look.clear();
        while self.end != end && self.end != self.first {
            self.end = self.end.wrapping_sub(1);
            self.sum = self.sum.saturating_sub(self.time(self.end));
        }
        (self.end, self.next) = (end, end);
    }

    /// Entries for the tick, counted since the FIFO was cleared.
    pub fn end(&self) -> u32 {
        self.end
    }

    /// Entries that wait in the look-ahead.
    pub fn waiting(&self) -> u32 {
        self.next.wrapping_sub(self.end)
    }

    /// Takes what calls give to a FIFO, in their order. Returns how long the tick's data lasts, ms.
    pub fn put(&mut self, to: &Destination<'_>, given: impl IntoIterator<Item = Queued>) -> f64 {
        self.prepare(to.cleared, to.look);
        // The times of what is over lie where those of new entries go.
        self.release(to.sampled, to.fifo);
        let store = &to.stores[usize::from(to.fifo & 1)];
        for given in given {
            match given {
                Queued::Motion { geometry, vel, acc, stops } => {
                    let Some(entry) = geometry.entry(MotionSpeeds::NONE) else { continue };
                    self.make_room(store);
                    self.look.push_motion(&geometry, vel, acc);
                    if stops {
                        self.look.stop();
                    }
                    self.append(store, entry, 0.0);
                }
                Queued::Entry(entry, ms) => {
                    self.append(store, entry, ms);
                    if self.look.is_empty() {
                        // The entry handed over last ends at standstill.
                        self.hand_over(1);
                    } else {
                        self.look.push_other(&entry);
                    }
                }
                Queued::Flush => self.flush(store),
            }
        }
        self.lasts(to.stores, to.sampled, to.fifo)
    }

    /// Prepares for data of a FIFO that was cleared so many times, with the limits of its
    /// look-ahead and how many motions that may hold.
    fn prepare(&mut self, cleared: u32, look: Option<(Limits, u16)>) {
        self.update_cleared(cleared);
        if let Some((limits, count)) = look {
            self.count = usize::from(count).clamp(1, LOOK_AHEAD_MOTIONS);
            if self.look.is_empty() {
                self.look.set_limits(limits);
            }
        }
    }

    /// The limits of a motion after [`PathQueue::put`] with these limits, for a FIFO that was
    /// cleared so many times.
    pub fn limits(&self, cleared: u32, limits: Limits) -> Limits {
        if self.cleared != cleared || self.look.is_empty() { limits } else { *self.look.limits() }
    }

    /// Whether the look-ahead is full after the final motions have left it.
    fn is_full(&mut self, store: &EntryStore) -> bool {
        if self.look.len() >= self.count {
            self.release_final(store);
        }
        self.look.len() >= self.count
    }

    fn make_room(&mut self, store: &EntryStore) {
        if self.is_full(store) {
            self.take_batch(store);
            while self.look.len() >= self.count && self.take(store, true) {}
        }
    }

    /// The first motions under one plan, whose speeds are not final. False if none left.
    fn take_batch(&mut self, store: &EntryStore) -> bool {
        let batch = self.look.hold_level();
        let taken = (0..batch).take_while(|_| self.take(store, true)).count();
        self.look.release_level();
        taken > 0
    }

    /// An entry into the next slot of the store.
    fn append(&mut self, store: &EntryStore, entry: PathEntry, ms: f64) {
        self.set_time(self.next, ms);
        store.write(self.next, entry);
        self.next = self.next.wrapping_add(1);
    }

    fn set_time(&mut self, counter: u32, ms: f64) {
        if let Some(time) = self.times.get_mut(counter as usize % ENTRIES) {
            *time = PackedDuration::of(ms);
        }
    }

    fn time(&self, counter: u32) -> u64 {
        self.times.get(counter as usize % ENTRIES).map_or(0, |time| time.units())
    }

    /// The next entries are the tick's.
    fn hand_over(&mut self, entries: u32) {
        for _ in 0..entries {
            self.sum = self.sum.saturating_add(self.time(self.end));
            self.end = self.end.wrapping_add(1);
        }
    }

    /// The first motion with its speeds, and the entries that follow it.
    fn take(&mut self, store: &EntryStore, now: bool) -> bool {
        let Some(planned) = self.look.take(now) else { return false };
        store.write(self.end, store.entry(self.end).with_speeds(planned.along));
        self.set_time(self.end, planned.ms);
        self.last_ms = planned.ms as f32;
        self.hand_over(1 + u32::from(planned.entries_after));
        true
    }

    /// The tick's entries end here after data of a call. Final motions leave the look-ahead when a
    /// plan is due. [`PathQueue::feed`] does not wait for that: it comes before the tick begins the
    /// last motion that it has, if that is short. After a long one nothing waits.
    pub fn release_final_when_due(&mut self, store: &EntryStore) -> u32 {
        let may_wait = self.end != self.first && self.last_ms < SHORT_MS;
        if may_wait && !self.look.is_plan_due() { self.end } else { self.release_final(store) }
    }

    /// Final motions leave the look-ahead. Returns where the tick's entries end.
    pub fn release_final(&mut self, store: &EntryStore) -> u32 {
        while self.take(store, false) {}
        self.end
    }

    /// All motions leave the look-ahead: the path stops at the end.
    pub fn flush(&mut self, store: &EntryStore) {
        self.look.stop();
        while self.take(store, true) {}
    }

    /// Entries that the tick has released are over.
    fn release(&mut self, sampled: &CrdView, fifo: u8) {
        let index = usize::from(fifo & 1);
        let over = sampled.released[index].wrapping_sub(self.first);
        if sampled.cleared[index] != self.cleared || over > self.end.wrapping_sub(self.first) {
            return;
        }
        for _ in 0..over {
            self.sum = self.sum.saturating_sub(self.time(self.first));
            self.first = self.first.wrapping_add(1);
        }
    }

    /// How long the motions for the tick last, ms. At standstill all of them count. Of a running
    /// path those after the present one count, and the least remaining time of that one.
    pub fn lasts(&mut self, store: &[EntryStore; 2], sampled: &CrdView, fifo: u8) -> f64 {
        self.release(sampled, fifo);
        self.remaining(store, sampled, fifo)
    }

    /// The same of a display, which changes nothing.
    pub fn remaining(&self, store: &[EntryStore; 2], sampled: &CrdView, fifo: u8) -> f64 {
        let index = usize::from(fifo & 1);
        let (mut first, mut sum) = (self.first, self.sum);
        if sampled.cleared[index] != self.cleared {
            return sum as f64 / UNITS_PER_MS;
        }
        let over = sampled.released[index].wrapping_sub(first);
        if over <= self.end.wrapping_sub(first) {
            for _ in 0..over {
                sum = sum.saturating_sub(self.time(first));
                first = first.wrapping_add(1);
            }
        }
        if !(sampled.runs && sampled.fifo == fifo) || first == self.end {
            return sum as f64 / UNITS_PER_MS;
        }
        let following = sum.saturating_sub(self.time(first)) as f64 / UNITS_PER_MS;
        following + left(store[index].entry(first), sampled)
    }

    /// At a start: as [`PathQueue::feed`]. The path may not be done with an earlier start, whose
    /// entries do not count; `first` is the first of the new ones.
    pub fn begin(&mut self, store: &[EntryStore; 2], sampled: &CrdView, fifo: u8) {
        let before = if sampled.runs { self.lasts(store, sampled, fifo) } else { 0.0 };
        self.fill(store, sampled, fifo, before + LASTS_MS);
    }

    /// Takes entries from the look-ahead until the tick's data lasts long enough. True if there
    /// were any.
    pub fn feed(&mut self, store: &[EntryStore; 2], sampled: &CrdView, fifo: u8) -> bool {
        self.fill(store, sampled, fifo, LASTS_MS)
    }

    fn fill(&mut self, stores: &[EntryStore; 2], sampled: &CrdView, fifo: u8, until_ms: f64) -> bool {
        let (before, store) = (self.end, &stores[usize::from(fifo != 0)]);
        let mut more = true;
        while more && !self.look.is_empty() && self.lasts(stores, sampled, fifo) < until_ms {
            let end = self.end;
            more = self.release_final(store) != end || self.take_batch(store);
        }
        self.end != before
    }
}

impl Default for PathQueue {
    fn default() -> Self {
        PathQueue::new()
    }
}

/// The least remaining time of a running motion: straight to its end, at its full speed.
fn left(entry: PathEntry, sampled: &CrdView) -> f64 {
    let position = super::geometry::position_of(&sampled.position);
    let (square, along) = match entry.item() {
        EntryContent::Line { to, dimensions, along } => {
            let parts = to.iter().zip(position).take(dimensions);
            (parts.fold(0.0, |sum, (to, at)| sum + (f64::from(*to) - at) * (f64::from(*to) - at)), along)
        }
        EntryContent::Arc { plane, to, along, .. } => {
            let [i, j] = plane.coordinates();
            let (a, b) = (f64::from(to[0]) - position[i], f64::from(to[1]) - position[j]);
            (a * a + b * b, along)
        }
        _ => return 0.0,
    };
    libm::sqrt(square) / f64::from_bits(along.vel_bits()).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entrys_time_is_kept_to_1_in_2048() {
        for ms in [0.0, 1.0 / 1024.0, 0.5, 3.9, 4.0, 10.0, 63.99, 64.0, 1000.1, 60_000.0, 131_000.0] {
            let kept = PackedDuration::of(ms).units() as f64 / UNITS_PER_MS;
            assert!(kept <= ms && kept > ms * (1.0 - 1.0 / 2048.0) - 1.0 / 1024.0, "{ms}: {kept}");
        }
        assert_eq!(PackedDuration::of(1e9).units(), 4095 << 15);
        assert_eq!(PackedDuration::of(f64::NAN).units(), 0);
    }
}
