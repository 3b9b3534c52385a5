//! The entries of a job between the script and their answers.
//!
//! In: entries as the client asks for them, and which are answered. Out: the step that an entry
//! came from, and script time before it. Owns the entries that wait for their answer, and their
//! steps; what is asked of an earlier entry is found by going through the script again.
use crate::entries::{Entries, From};
use crate::source::Source;
use client::Call;
use job::Step;
use protocol::command::{Request, Sleep, VersionReply, WaitStop};
use std::cell::{OnceCell, RefCell};
use std::collections::VecDeque;
use zerocopy::FromBytes;

/// See the module text.
pub struct Ledger<'s> {
    source: &'s Source,
    version: VersionReply,
    traced: bool,
    state: RefCell<LedgerState<'s>>,
    total: OnceCell<u32>,
}

struct LedgerState<'s> {
    entries: Entries<'s>,
    /// Entries that the client has, from this number on.
    first: u32,
    window: VecDeque<SentEntry>,
    before: Before,
    /// An entry failed: nothing is forgotten from then on.
    failed: bool,
}

/// An entry as far as somebody asks for it.
struct SentEntry {
    from: From,
    opcode: u16,
    may_fail: bool,
    /// The time of a Sleep, ns.
    sleep_ns: Option<u64>,
}

/// What the entries before a number add up to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Before {
    /// Script time of the sleeps right before, ns.
    pub slept_ns: u64,
    /// Script time of all sleeps, ns.
    pub sleeps_ns: u64,
    /// One of them waits for motion.
    pub waited: bool,
}

impl Before {
    fn add(&mut self, entry: &SentEntry) {
        self.slept_ns = entry.sleep_ns.map_or(0, |ns| self.slept_ns + ns);
        self.sleeps_ns += entry.sleep_ns.unwrap_or(0);
        self.waited |= entry.opcode == WaitStop::OPCODE;
    }
}

impl<'s> Ledger<'s> {
    /// Of a job, with a trace or without.
    pub fn new(source: &'s Source, version: VersionReply, traced: bool) -> Self {
        let entries = source.entries(version, traced);
        let (window, before) = (VecDeque::new(), Before::default());
        let state = LedgerState { entries, first: 0, window, before, failed: false };
        Ledger { source, version, traced, state: RefCell::new(state), total: OnceCell::new() }
    }

    /// The call of the next entry.
    pub fn next_call(&self) -> Option<Call> {
        let mut state = self.state.borrow_mut();
        let entry = state.entries.next()?;
        let sleep = entry.call.opcode == Sleep::OPCODE;
        let sleep_ns = sleep.then(|| Sleep::read_from_bytes(&entry.call.payload).map_or(0, |sleep| sleep.ns.get()));
        let (opcode, may_fail) = (entry.call.opcode, entry.call.may_fail);
        state.window.push_back(SentEntry { from: entry.from, opcode, may_fail, sleep_ns });
        Some(entry.call)
    }

    /// Why the script ended early, if it did.
    pub fn broken(&self) -> Option<String> {
        self.state.borrow().entries.broken().map(str::to_owned)
    }

    /// Entries of the whole job.
    pub fn total(&self) -> u32 {
        *self.total.get_or_init(|| {
            let mut entries = self.source.entries(self.version, self.traced);
            let mut count = 0u32;
            while let Some(entry) = entries.next() {
                count = count.saturating_add(1);
                entries.forget_before(entry.from.first_step().unwrap_or(0));
            }
            count
        })
    }

    /// An entry is answered, and nothing more is asked of it unless it failed.
    pub fn answered(&self, index: u32, failed: bool) {
        let mut state = self.state.borrow_mut();
        state.failed |= failed;
        while !state.failed && state.first <= index {
            let Some(entry) = state.window.pop_front() else { return };
            state.before.add(&entry);
            state.first += 1;
            if let Some(step) = entry.from.first_step() {
                state.entries.forget_before(step);
            }
        }
    }

    /// What comes before the first entry that is not answered, if this is it.
    pub fn before(&self, index: u32) -> Option<Before> {
        let state = self.state.borrow();
        (index == state.first).then_some(state.before)
    }

    /// Whether the job goes on after an entry that fails.
    pub fn may_fail(&self, index: u32) -> bool {
        self.state.borrow().noted(index).is_some_and(|entry| entry.may_fail)
    }

    /// Where an entry that is not answered came from.
    pub fn from(&self, index: u32) -> Option<From> {
        self.state.borrow().noted(index).map(|entry| entry.from.clone())
    }

    /// What `with_step` finds at the step of an entry, by the number of an item of it.
    pub fn with_step<T>(&self, index: u32, item: u16, look: impl FnOnce(&Step) -> T) -> Option<T> {
        let state = self.state.borrow();
        if index >= state.first {
            let number = state.noted(index)?.from.step(item)?;
            return state.entries.step(number).map(look);
        }
        let mut entries = self.source.entries(self.version, self.traced);
        for _ in 0..index {
            let entry = entries.next()?;
            entries.forget_before(entry.from.first_step().unwrap_or(0));
        }
        let number = entries.next()?.from.step(item)?;
        entries.step(number).map(look)
    }
}

impl LedgerState<'_> {
    fn noted(&self, index: u32) -> Option<&SentEntry> {
        self.window.get(index.checked_sub(self.first)? as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command_line::Drawing;
    use crate::script::IN_MEMORY_BYTES;
    use protocol::command::{Abort, LnXY};
    use std::path::PathBuf;

    fn version() -> VersionReply {
        VersionReply {
            cores: 1,
            axes_per_core: 8,
            lasers: 2,
            crds_per_core: 2,
            tick_us: 50.into(),
            ..VersionReply::default()
        }
    }

    /// A job as `import` writes it, which is not kept in memory.
    fn long(folder: &tempfile::TempDir) -> PathBuf {
        let mut text = format!("{}: a.nc\nGT_CrdClear(1, 0);\nSleep(2);\n", strokes::MARK);
        for x in 1.. {
            text += &format!("GT_LnXY(1, {x}, 0, 50, 2); // {x}\nGT_BufLaserPrfCmd(1, {}.5, 0, 1);\n", x % 50);
            if text.len() > IN_MEMORY_BYTES {
                break;
            }
        }
        let path = folder.path().join("a.gts");
        std::fs::write(&path, text + "WaitStop(1, 0, 1);\nSleep(3);\nSleep(4);\nGT_CrdClear(1, 0);\n").unwrap();
        path
    }

    fn opened(path: &std::path::Path) -> Source {
        Source::open(path, &Drawing::default(), true).unwrap()
    }

    /// An entry that was answered long ago has the step that it had when it was sent.
    #[test]
    fn what_is_forgotten_is_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let source = opened(&long(&folder));
        let ledger = Ledger::new(&source, version(), false);
        let steps: Vec<Step> = source.steps().map(Result::unwrap).collect();
        let mut count = 0u32;
        while ledger.next_call().is_some() {
            let line = |step: &Step| step.line;
            let found = ledger.with_step(count, u16::MAX, line);
            // Each step is an entry; what follows them is none of the script.
            assert_eq!(found, steps.get(count as usize).map(line), "{count}");
            ledger.answered(count, false);
            count += 1;
        }
        assert_eq!((ledger.total(), ledger.broken()), (count, None));
        assert!(steps.len() > 20_000 && ledger.state.borrow().window.is_empty());
        for index in [0, 1, 777, steps.len() as u32 - 1] {
            let found = ledger.with_step(index, u16::MAX, Step::clone);
            assert_eq!(found.as_ref(), steps.get(index as usize), "{index}");
        }
        assert_eq!(ledger.with_step(steps.len() as u32, u16::MAX, Step::clone), None);
    }

    #[test]
    fn time_before_an_entry_adds_up() {
        let folder = tempfile::tempdir().unwrap();
        let source = opened(&long(&folder));
        let ledger = Ledger::new(&source, version(), false);
        while ledger.next_call().is_some() {}
        let last = source.totals.steps as u32;
        let before = |slept_ns, sleeps_ns, waited| Some(Before { slept_ns, sleeps_ns, waited });
        for (index, expected) in [
            (2, before(2_000_000, 2_000_000, false)),
            (3, before(0, 2_000_000, false)),
            (last - 3, before(0, 2_000_000, true)),
            (last - 1, before(7_000_000, 9_000_000, true)),
        ] {
            ledger.answered(index - 1, false);
            assert_eq!(ledger.before(index), expected, "{index}");
            assert_eq!(ledger.before(index + 1), None);
        }
    }

    /// From a failure on everything can be asked for.
    #[test]
    fn what_failed_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let source = opened(&long(&folder));
        let ledger = Ledger::new(&source, version(), false);
        for index in 0..300 {
            ledger.next_call().unwrap();
            ledger.answered(index, index == 200);
        }
        assert_eq!((ledger.state.borrow().first, ledger.state.borrow().window.len()), (200, 100));
    }

    /// A job file that is overwritten while it runs ends the script, and the job with an Abort.
    #[test]
    fn a_file_that_changes_ends_the_script() {
        let folder = tempfile::tempdir().unwrap();
        let path = long(&folder);
        let text = std::fs::read_to_string(&path).unwrap();
        for changed in
            [text[..text.len() / 2].to_owned(), text.replace("WaitStop", "GT_LnXY(1, 1, 1, 50, 2); WaitStop")]
        {
            std::fs::write(&path, &text).unwrap();
            let source = opened(&path);
            let ledger = Ledger::new(&source, version(), false);
            let mut calls: Vec<Call> = (0..1000).map(|_| ledger.next_call().unwrap()).collect();
            std::fs::write(&path, changed).unwrap();
            calls.extend(std::iter::from_fn(|| ledger.next_call()));
            assert!(ledger.broken().is_some_and(|why| why.contains("has changed")), "{:?}", ledger.broken());
            // What was read by then is run: a block of the file.
            let count = calls.iter().filter(|call| call.opcode == LnXY::OPCODE).count();
            assert!((499..2500).contains(&count), "{count}");
            assert_eq!(calls.iter().filter(|call| call.opcode == Abort::OPCODE).count(), 1);
        }
    }

    /// So does one that is shorter than it was, or longer, however that came about.
    #[test]
    fn steps_are_as_many_as_were_checked() {
        let folder = tempfile::tempdir().unwrap();
        for more in [-1, 1] {
            let mut source = opened(&long(&folder));
            let steps = source.totals.steps;
            source.totals.steps = steps.saturating_add_signed(more);
            let found: Vec<bool> = source.steps().take(steps + 2).map(|step| step.is_ok()).collect();
            let good = steps.min(source.totals.steps);
            assert!(found[..good].iter().all(|is_ok| *is_ok) && !found[good], "{more}");
        }
    }
}
