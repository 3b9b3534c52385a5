//! The store of entries between admission and the tick.
//!
//! In: admitted entries from the thread, by running counter. Out: the same, to the tick. Owns: the
//! memory of one FIFO of one coordinate system. Fails: never; a counter counts modulo [`ENTRIES`].
use super::entry::PathEntry;
use crate::units::Crd;
use ring::Store;

/// Where a path reads its entries.
pub trait PathEntries {
    /// Entry `counter` of a FIFO, counted since it was cleared.
    fn entry(&self, fifo: u8, counter: u32) -> PathEntry;
}

/// Entries of one FIFO.
pub const ENTRIES: usize = 1024;

/// One FIFO. The thread writes a slot only while the tick does not read it; the commit that follows
/// makes it visible.
pub struct EntryStore(Store<8, ENTRIES>);

/// The FIFOs of every coordinate system, wherever a board has room for each pair; a missing pair is
/// `None`.
#[derive(Clone, Copy)]
pub struct PathStores<'a>([Option<&'a [EntryStore; 2]>; Crd::MAX]);

impl<'a> PathStores<'a> {
    /// A board without coordinate systems.
    pub const NONE: PathStores<'static> = PathStores([None; Crd::MAX]);

    /// Each pair by itself.
    pub const fn new(pairs: [Option<&'a [EntryStore; 2]>; Crd::MAX]) -> PathStores<'a> {
        PathStores(pairs)
    }

    /// Pairs in one array.
    pub const fn of<const N: usize>(pairs: &'a [[EntryStore; 2]; N]) -> PathStores<'a> {
        const { assert!(N <= Crd::MAX) };
        let mut stores = [None; Crd::MAX];
        let mut index = 0;
        while index < N {
            stores[index] = Some(&pairs[index]);
            index += 1;
        }
        PathStores(stores)
    }

    /// Those of a coordinate system.
    #[inline(always)]
    pub fn get(self, index: usize) -> Option<&'a [EntryStore; 2]> {
        *self.0.get(index)?
    }

    /// How many coordinate systems there are.
    pub fn count(self) -> usize {
        self.0.iter().flatten().count()
    }
}

impl EntryStore {
    /// All slots hold the entry of zeros, which does nothing.
    pub const fn new() -> EntryStore {
        EntryStore(Store::new())
    }

    /// The slot of an entry.
    #[inline]
    pub fn entry(&self, counter: u32) -> PathEntry {
        PathEntry::from_words(self.0.read(counter))
    }

    /// Fills the slot of an entry.
    pub fn write(&self, counter: u32, entry: PathEntry) {
        self.0.write(counter, entry.words());
    }
}

/// Both FIFOs of a coordinate system.
impl PathEntries for [EntryStore; 2] {
    #[inline]
    fn entry(&self, fifo: u8, counter: u32) -> PathEntry {
        let [first, second] = self;
        let store = if fifo == 0 { first } else { second };
        store.entry(counter)
    }
}
