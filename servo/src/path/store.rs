//! Where entries lie between admission and the tick.
//!
//! In: admitted entries from the thread, by running counter. Out: the same, to the tick. Owns: the memory of one
//! FIFO of one coordinate system. Fails: never; a counter counts modulo [`ENTRIES`].
use super::entry::Entry;
use ring::Store;

/// Where a path reads its entries.
pub trait Entries {
    /// Entry `counter` of a FIFO, counted since it was cleared.
    fn entry(&self, fifo: u8, counter: u32) -> Entry;
}

/// Entries of one FIFO.
pub const ENTRIES: usize = 1024;

/// One FIFO. The thread writes a slot only while the tick does not read it; the commit that follows makes it
/// visible.
pub struct EntryStore(Store<8, ENTRIES>);

impl EntryStore {
    /// All slots hold the entry of zeros, which does nothing.
    pub const fn new() -> EntryStore {
        EntryStore(Store::new())
    }

    /// Fills the slot of an entry.
    pub fn write(&self, counter: u32, entry: Entry) {
        self.0.write(counter, entry.words());
    }
}

impl Default for EntryStore {
    fn default() -> Self {
        EntryStore::new()
    }
}

/// Both FIFOs of a coordinate system.
impl Entries for [EntryStore; 2] {
    #[inline]
    fn entry(&self, fifo: u8, counter: u32) -> Entry {
        let [first, second] = self;
        let EntryStore(store) = if fifo == 0 { first } else { second };
        Entry::from_words(store.read(counter))
    }
}
