//! What a digital signal did over time: every change while they are few, else its share of time.
//!
//! In: times at which it was high, pulse trains, in ns and in order. Out: highs, or [`Bin`]s. Owns
//! a bounded number of highs and [`MAX_BINS`] bins, however long the signal is and however fast.
use super::window::Window;
use plant::pulses::Burst;

/// So many highs are kept one by one for a picture, and for a page, which can be enlarged.
pub(super) const PICTURE_HIGHS: usize = 2_000;
pub(super) const PAGE_HIGHS: usize = 50_000;
/// Most bins.
const MAX_BINS: usize = 4096;
/// Width of the first bins, ns, where the end is not known.
const FIRST_NS: u64 = 1_000;

/// An interval of time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Bin {
    /// Time during which it was high, ns.
    pub on: f64,
    /// Edges in it.
    pub edges: f64,
}

/// See the module text.
#[derive(Debug, Clone)]
pub(super) struct Activity {
    window: Window,
    /// Most highs.
    most: usize,
    /// Beginnings and ends, ns, while they are few.
    highs: Vec<(u64, u64)>,
    many: bool,
    bins: Vec<Bin>,
    width: u64,
    /// High since.
    since: Option<u64>,
}

impl Activity {
    /// Of a signal that is low, for what lies in `window`; at most so many highs one by one.
    pub fn new(window: Window, most: usize) -> Self {
        let width = match window.to {
            u64::MAX => FIRST_NS,
            to => (to.saturating_sub(window.from) / (MAX_BINS as u64 - 1)).max(1),
        };
        Activity { window, most, highs: Vec::new(), many: false, bins: Vec::new(), width, since: None }
    }

    /// It changes its level.
    pub fn level(&mut self, t: u64, level: bool) {
        if self.since.is_some() == level {
            return;
        }
        self.until(t);
        self.since = level.then_some(t);
        if (self.window.from..self.window.to).contains(&t) {
            self.fill(t, t + 1, Bin { on: 0.0, edges: 1.0 });
        }
    }

    /// It has been followed up to `t`; a high level continues.
    pub fn until(&mut self, t: u64) {
        let Some(since) = self.since else { return };
        self.since = Some(t);
        let (from, to) = (since.max(self.window.from), t.min(self.window.to));
        if from >= to {
            return;
        }
        if !self.many {
            match self.highs.last_mut() {
                // Without a gap it is the same one.
                Some(last) if last.1 >= from => last.1 = last.1.max(to),
                _ => self.highs.push((from, to)),
            }
            self.many = self.highs.len() > self.most;
        }
        self.fill(from, to, Bin { on: (to - from) as f64, edges: 0.0 });
    }

    /// Pulses.
    pub fn burst(&mut self, burst: &Burst) {
        if burst.at >= self.window.to || burst.start(burst.count) < self.window.from {
            return;
        }
        // The last pulse that begins before the window may reach into it.
        let first = burst.first_from(self.window.from).saturating_sub(1);
        let burst = burst.skip(first);
        let burst = Burst { count: burst.first_from(self.window.to), ..burst };
        let (begin, end) = (burst.at.max(self.window.from), burst.start(burst.count).min(self.window.to));
        if begin >= end {
            return;
        }
        self.widen(end);
        let span = burst.start(burst.count).saturating_sub(burst.at) as f64;
        let pulses = burst.count as f64;
        let has_room = !self.many && burst.count + self.highs.len() as u64 <= self.most as u64;
        if has_room || span / pulses > self.width as f64 / 2.0 {
            for (from, to) in burst.pulses().filter(|(from, to)| from < to) {
                self.level(from, true);
                self.level(to, false);
            }
        } else {
            // Several in each bin.
            let share = (end - begin) as f64 / span;
            self.many = true;
            self.fill(begin, end, Bin { on: burst.on() as f64 * share, edges: 2.0 * pulses * share });
        }
    }

    /// Spreads time and edges evenly over the bins from one instant to a later one.
    fn fill(&mut self, from: u64, to: u64, sum: Bin) {
        self.widen(to);
        let base = self.window.from;
        let (first, last) = ((from - base) / self.width, (to - 1 - base) / self.width);
        if self.bins.len() <= last as usize {
            self.bins.resize(last as usize + 1, Bin::default());
        }
        for (index, bin) in (first..=last).zip(&mut self.bins[first as usize..]) {
            let (left, right) = ((base + index * self.width).max(from), (base + (index + 1) * self.width).min(to));
            let part = (right - left) as f64 / (to - from) as f64;
            bin.on += sum.on * part;
            bin.edges += sum.edges * part;
        }
    }

    /// Makes bins wide enough for `t`.
    fn widen(&mut self, t: u64) {
        while (t - self.window.from.min(t)) / self.width >= MAX_BINS as u64 {
            self.bins = self
                .bins
                .chunks(2)
                .map(|pair| {
                    pair.iter()
                        .fold(Bin::default(), |sum, bin| Bin { on: sum.on + bin.on, edges: sum.edges + bin.edges })
                })
                .collect();
            self.width *= 2;
        }
    }

    /// The highs, where they are few: beginnings and ends in ns.
    pub fn highs(&self) -> Option<&[(u64, u64)]> {
        (!self.many).then_some(self.highs.as_slice())
    }

    /// Sum of the bins between two instants, ns.
    pub fn between(&self, from: f64, to: f64) -> Bin {
        let place = |t: f64| (t - self.window.from as f64) / self.width as f64;
        let (first, last) = (place(from).max(0.0), place(to).max(0.0));
        let mut sum = Bin::default();
        for (index, bin) in self.bins.iter().enumerate().take(last.ceil() as usize).skip(first as usize) {
            let part = (last.min(index as f64 + 1.0) - first.max(index as f64)).clamp(0.0, 1.0);
            sum.on += bin.on * part;
            sum.edges += bin.edges * part;
        }
        sum
    }
}
