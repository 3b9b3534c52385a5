//! Outputs that change at instants inside the coming interval.
//!
//! In: changes with their instants, in the order of time for each coordinate system. Out: the same
//! in the order of time, to the machine. Owns: those of one tick; of an instant one for each group
//! and each analog output. Fails: never; a path holds where there is no room for more.
use crate::capacity::GeneralOutputs;
use crate::path::INSTANTS;
use crate::port::Port;
use crate::units::{Crd, DoGroup};

/// One at each instant at which a path may carry out something.
const OUTPUT_SLOTS: usize = Crd::MAX * INSTANTS as usize;

/// What changes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum OutputChange {
    /// Outputs of a group get the levels of `value` where `mask` is set.
    Digital { group: DoGroup, mask: u64, value: u64 },
    /// An analog output.
    Analog { channel: u8, value: i16 },
}

impl OutputChange {
    /// Whether a later change of the same instant is a part of this one from now on.
    fn takes(&mut self, later: OutputChange) -> bool {
        match (self, later) {
            (
                OutputChange::Digital { group, mask, value },
                OutputChange::Digital { group: of, mask: also, value: levels },
            ) if *group == of => {
                *value = *value & !also | levels & also;
                *mask |= also;
                true
            }
            (OutputChange::Analog { channel, value }, OutputChange::Analog { channel: of, value: level })
                if *channel == of =>
            {
                *value = level;
                true
            }
            _ => false,
        }
    }
}

/// What a change has set.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Set {
    /// The general outputs.
    General(GeneralOutputs),
    /// An analog output.
    Analog { channel: u8, value: i16 },
}

/// The changes of one tick.
#[derive(Debug)]
pub(crate) struct OutputEdges {
    list: [(u32, OutputChange); OUTPUT_SLOTS],
    count: usize,
}

/// Levels of the digital outputs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OutputLevels {
    pub(crate) enable: u64,
    pub(crate) clear: u64,
    pub(crate) general: GeneralOutputs,
}

impl OutputEdges {
    pub(crate) const NONE: OutputEdges =
        OutputEdges { list: [(0, OutputChange::Analog { channel: 0, value: 0 }); OUTPUT_SLOTS], count: 0 };

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether there is room for one more change.
    pub(crate) fn has_room(&self) -> bool {
        self.count < OUTPUT_SLOTS
    }

    /// A change `at` ns after the tick computed; after those of the same instant, of which it may
    /// be a part.
    pub(crate) fn add(&mut self, at: u32, change: OutputChange) {
        let list = self.list.get_mut(..self.count).unwrap_or_default();
        if list
            .iter_mut()
            .rev()
            .take_while(|before| before.0 >= at)
            .any(|before| before.0 == at && before.1.takes(change))
        {
            return;
        }
        let mut slot = self.count.min(OUTPUT_SLOTS - 1);
        self.count = slot + 1;
        while slot > 0
            && let Some(&before) = self.list.get(slot - 1)
            && before.0 > at
        {
            if let Some(here) = self.list.get_mut(slot) {
                *here = before;
            }
            slot -= 1;
        }
        if let Some(here) = self.list.get_mut(slot) {
            *here = (at, change);
        }
    }

    /// Hands them to the machine, whose outputs have these levels at the tick computed, and the
    /// general and analog outputs with their instants to `queued`; returns the levels at the end.
    #[inline(never)]
    pub(crate) fn flush(
        &mut self,
        mut levels: OutputLevels,
        port: &mut impl Port,
        mut queued: impl FnMut(u32, Set),
    ) -> OutputLevels {
        for &(at, change) in self.list.iter().take(self.count) {
            match change {
                OutputChange::Digital { group, mask, value } => {
                    let set = |word: u64| word & !mask | value & mask;
                    match group {
                        DoGroup::Enable => levels.enable = set(levels.enable),
                        DoGroup::Clear => levels.clear = set(levels.clear),
                        DoGroup::General => {
                            let (mask, value) = (mask as GeneralOutputs, value as GeneralOutputs);
                            levels.general = levels.general & !mask | value & mask;
                        }
                    }
                    port.outputs(at, levels.enable, levels.clear, levels.general);
                    queued(at, Set::General(levels.general));
                }
                OutputChange::Analog { channel, value } => {
                    port.analog_out(at, channel as usize, value);
                    queued(at, Set::Analog { channel, value });
                }
            }
        }
        self.count = 0;
        levels
    }
}
