//! The switch outputs of both channels as cycles of one timer. In each cycle an output may fall
//! once and then rise once.
//!
//! In: the actions of the plans of a tick. Out: cycles ([`Cycle`]). Owns levels, and the cycle that
//! is not queued yet. Fails never.
//!
//! An active pulse shorter than [`MIN_COUNTS`] may be missing, if there was no room for the cycle
//! that would begin with its end; the shortest pulse that a command asks for is 1 µs. Gaps are
//! exact, whatever their length.
use super::cycle_ring::CycleRing;
use super::cycles::{LATE_MIN_CYCLES, Lengths, Scale, long_and_two_short};
use super::delay_line::DelayLine;
use crate::laser::{Action, CHANNELS, PLAN_ACTIONS};

/// The shortest cycle, in counts: 500 ns at 240 MHz, in which DMA brings six half-words.
pub const MIN_COUNTS: u32 = 120;

/// After the end of any cycle.
const NEVER_COUNTS: u32 = 65_535;
/// After the end of the known interval.
const NO_EDGE_COUNTS: u32 = u32::MAX;

/// A cycle: its length in counts, and for each output the count at which it falls, if it begins
/// active, and the one at which it rises. It is active below the first one and from the second one
/// on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cycle {
    /// Counts, at most 65 535.
    pub length: u32,
    /// 0: it begins inactive.
    pub falls: [u32; CHANNELS],
    /// The length or more: it does not rise.
    pub rises: [u32; CHANNELS],
}

/// An output in the cycle that is not queued yet, in counts from its beginning.
#[derive(Debug, Clone, Copy)]
struct GateEdges {
    /// It is active until then; [`NO_EDGE_COUNTS`]: so far.
    falls: u32,
    /// And again from then on; [`NO_EDGE_COUNTS`]: not so far.
    rises: u32,
}

impl GateEdges {
    const INACTIVE: GateEdges = GateEdges { falls: 0, rises: NO_EDGE_COUNTS };
    const ACTIVE: GateEdges = GateEdges { falls: NO_EDGE_COUNTS, rises: NO_EDGE_COUNTS };

    #[inline(always)]
    fn is_steady(&self) -> bool {
        matches!(self.falls, 0 | NO_EDGE_COUNTS) && self.rises == NO_EDGE_COUNTS
    }

    /// The cycle ends after this many counts, and the next one begins.
    #[inline(always)]
    fn renew(&mut self, length: u32) {
        if self.rises <= length {
            *self = GateEdges::ACTIVE;
            return;
        }
        for edge in [&mut self.falls, &mut self.rises] {
            if *edge != NO_EDGE_COUNTS {
                *edge = edge.saturating_sub(length);
            }
        }
    }
}

state! {
    /// See the module text. Instants are counts of the timer since it began.
    #[derive(Debug, Clone)]
    pub struct GateCycles {
        scale: Scale = scale,
        begin: u64 = begin,
        lines: [GateEdges; CHANNELS] = [GateEdges::INACTIVE; CHANNELS],
        known: u64 = begin,
        /// Edges of the first channel, until the second one's are known too: counts from the
        /// interval's beginning, twice, and the level in the last bit.
        edges: [u32; PLAN_ACTIONS] = [0; PLAN_ACTIONS],
        waiting: usize = 0,
    }
    /// Inactive; the first cycle begins at this count.
    pub const fn from(begin: u64, scale: Scale);
}

impl GateCycles {
    /// The end of the queued cycles.
    pub const fn queued(&self) -> u64 {
        self.begin
    }

    /// The part of an output that is not queued yet becomes inactive.
    pub fn shut_off(&mut self, channel: usize) {
        if let Some(line) = self.lines.get_mut(channel) {
            *line = GateEdges::INACTIVE;
        }
        if channel == 0 {
            self.waiting = 0;
        }
    }

    /// The first channel's actions of the interval; those of the second one come to
    /// [`GateCycles::take`].
    #[inline]
    pub fn hold(&mut self, actions: impl Iterator<Item = (u32, Action)>) {
        self.waiting = 0;
        for (at, action) in actions {
            if let Action::Switch(level) = action
                && let Some(slot) = self.edges.get_mut(self.waiting)
            {
                *slot = self.scale.counts(at) << 1 | u32::from(level);
                self.waiting = self.waiting.wrapping_add(1);
            }
        }
    }

    /// The second channel's actions of the interval from `from` to `to`, in counts: `sink` gets the
    /// cycles that are certain with both. An action beyond the interval takes place at its end.
    #[inline]
    pub fn take(
        &mut self,
        from: u64,
        to: u64,
        actions: impl Iterator<Item = (u32, Action)>,
        sink: &mut impl FnMut(Cycle),
    ) {
        self.known = to;
        let mut held = 0;
        for (at, action) in actions {
            if let Action::Switch(level) = action {
                let at = self.scale.counts(at);
                held = self.held_to(at, from, held, sink);
                self.edge(1, from.wrapping_add(at.into()), level, sink);
            }
        }
        self.held_to(u32::MAX >> 1, from, held, sink);
        self.waiting = 0;
        let certain = self.counts_to(to).saturating_sub(MIN_COUNTS);
        if certain >= MIN_COUNTS {
            self.close(certain, sink);
        }
    }

    /// The cycles of the second channel's plan that was delayed, in a ring: those of
    /// [`GateCycles::take`].
    #[inline(always)]
    pub fn queue<const SLOTS: usize>(&mut self, from: u64, to: u64, plan: &DelayLine, ring: &mut CycleRing<SLOTS, 6>) {
        if !(plan.is_empty() && self.go_on(to, ring)) {
            self.take(from, to, plan.actions(), &mut |cycle| {
                let ([fall_0, fall_1], [rise_0, rise_1]) = (cycle.falls, cycle.rises);
                ring.put(cycle.length, 1, [rise_0, fall_0, fall_1, rise_1]);
            });
        }
    }

    /// The outputs stay as they are up to `to`. False, and nothing has changed, if one changes, or
    /// if that takes other cycles than a long one and two short ones.
    #[inline(always)]
    fn go_on<const SLOTS: usize>(&mut self, to: u64, ring: &mut CycleRing<SLOTS, 6>) -> bool {
        let counts = self.counts_to(to).saturating_sub(MIN_COUNTS);
        let is_steady = self.waiting == 0 && self.lines.iter().all(GateEdges::is_steady);
        let Some(lengths) = long_and_two_short(counts, MIN_COUNTS).filter(|_| is_steady) else { return false };
        let [falls_0, falls_1] = self.lines.each_ref().map(|line| line.falls);
        let compare = |length: u32| [NEVER_COUNTS, falls_0.min(length), falls_1.min(length), NEVER_COUNTS];
        if !ring.put_three(lengths, compare) {
            return false;
        }
        (self.begin, self.known) = (self.begin.wrapping_add(counts.into()), to);
        true
    }

    /// From the beginning of the cycle that is not queued yet; the known interval is far below 2³²
    /// counts.
    #[inline(always)]
    fn counts_to(&self, at: u64) -> u32 {
        at.saturating_sub(self.begin) as u32
    }

    /// The first channel's edges up to `to`, included; `held` of them are done, and the result
    /// after it.
    fn held_to(&mut self, to: u32, from: u64, held: usize, sink: &mut impl FnMut(Cycle)) -> usize {
        let mut held = held;
        while let Some(edge) = self.edges.get(held).copied().filter(|edge| held < self.waiting && edge >> 1 <= to) {
            self.edge(0, from.wrapping_add((edge >> 1).into()), edge & 1 == 1, sink);
            held = held.wrapping_add(1);
        }
        held
    }

    /// An output changes to a level.
    fn edge(&mut self, channel: usize, at: u64, level: bool, sink: &mut impl FnMut(Cycle)) {
        let at = self.counts_to(at.min(self.known));
        let Some(line) = self.lines.get_mut(channel) else { return };
        match (level, line.rises == NO_EDGE_COUNTS) {
            // It is active.
            (true, false) => {}
            (true, true) if line.falls == NO_EDGE_COUNTS => {}
            // It fell in this instant.
            (true, true) if line.falls == at => line.falls = NO_EDGE_COUNTS,
            (true, true) => line.rises = at,
            (false, true) => line.falls = line.falls.min(at),
            (false, false) if at == line.rises || at < MIN_COUNTS => line.rises = NO_EDGE_COUNTS,
            (false, false) => {
                self.close(at, sink);
                if let Some(line) = self.lines.get_mut(channel) {
                    *line = GateEdges::INACTIVE;
                }
            }
        }
    }

    /// Queues everything for this many counts, after which a cycle begins.
    fn close(&mut self, counts: u32, sink: &mut impl FnMut(Cycle)) {
        let is_late = counts.wrapping_add(LATE_MIN_CYCLES * MIN_COUNTS) > self.counts_to(self.known);
        for length in Lengths::of(counts, MIN_COUNTS, is_late) {
            let mut cycle = Cycle { length, ..Cycle::default() };
            for ((line, falls), rises) in self.lines.iter_mut().zip(&mut cycle.falls).zip(&mut cycle.rises) {
                *falls = line.falls.min(length);
                *rises = if line.rises < length { line.rises } else { NEVER_COUNTS };
                line.renew(length);
            }
            sink(cycle);
        }
        self.begin = self.begin.wrapping_add(counts.into());
    }
}
