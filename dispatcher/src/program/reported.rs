//! What `ProgramReply` reports: counts of records, and what was late, took too long or lost light.
//!
//! In: views while the program runs, the replies that wait. Out: the numbers and bits of
//! `ProgramReply`. Owns them.
use crate::shadow::PROGRAM_FLAG;
use protocol::values::reported;
use servo::laser::{CHANNELS, Cause, Ignored};
use servo::view::View;

/// The last entry of a record, and its tag.
type Tagged = (u32, u16);

/// See the module text.
#[derive(Debug, Default)]
pub(super) struct Reported {
    pub accepted: u32,
    pub executed: u32,
    /// Ticks that took too long: in the last view, and before the program.
    pub overruns: [u32; 2],
    /// Tags of two records: of the first late entry, and of the last one executed when a tick took
    /// too long.
    pub late_tag: u16,
    pub overran_tag: u16,
    /// The record that was answered last: an overrun is reported a tick later.
    pub answered: Tagged,
    /// Laser channels that are lit or are to be, a bit each, and how many on commands of each were
    /// ignored.
    lit: u8,
    ignored: [u8; CHANNELS],
    /// Which of the tags are valid, and which light was shut off; the bits are those of
    /// `ProgramReply`.
    pub bits: u8,
}

impl Reported {
    /// The counts of a new program.
    pub fn begin(&mut self) {
        (self.accepted, self.executed, self.bits) = (0, 0, 0);
        self.overruns[1] = self.overruns[0];
    }

    /// Notes light that a fault shut off, or kept from coming, while the program runs.
    pub fn note_light<const AXES: usize>(&mut self, view: &View<AXES>, runs: bool) {
        for ((channel, laser), before) in (0..).zip(&view.lasers).zip(&mut self.ignored) {
            let bit = 1 << channel;
            let kept = *before != laser.ignored_count && laser.ignored == Ignored::Fault;
            if runs && laser.fault != Cause::None && (kept || self.lit & bit != 0) {
                self.bits |= reported::DARK << channel;
            }
            let lit = laser.fault == Cause::None && (laser.commanded || laser.light);
            self.lit = self.lit & !bit | if lit { bit } else { 0 };
            *before = laser.ignored_count;
        }
    }

    /// Notes what was late or took too long, while the replies of these records wait, in
    /// order.
    pub fn note<const AXES: usize>(&mut self, view: &View<AXES>, waiting: impl Iterator<Item = Tagged> + Clone) {
        let (last, last_tag) = self.answered;
        // The record of an entry is the first one whose last entry is that one or a later one.
        let tag = |seq: u32| {
            let reaches =
                |last: u32| last & PROGRAM_FLAG != 0 && last.wrapping_sub(seq) & !PROGRAM_FLAG < PROGRAM_FLAG >> 1;
            if reaches(last) { Some(last_tag) } else { waiting.clone().find(|item| reaches(item.0)).map(|item| item.1) }
        };
        let (late, overran) = (tag(view.first_late), tag(view.overran));
        if let Some(tag) = late.filter(|_| view.first_late != 0 && self.bits & reported::LATE == 0) {
            (self.late_tag, self.bits) = (tag, self.bits | reported::LATE);
        }
        if let Some(tag) = overran.filter(|_| view.overran != 0 && self.bits & reported::OVERRAN == 0) {
            (self.overran_tag, self.bits) = (tag, self.bits | reported::OVERRAN);
        }
        if view.late_light {
            self.bits |= reported::LATE_LIGHT;
        }
        if self.overruns[0] != self.overruns[1] {
            for (channel, laser) in view.lasers.iter().enumerate().take(4) {
                self.bits |= if laser.fault == Cause::Overrun { reported::DARK << channel } else { 0 };
            }
        }
    }
}
