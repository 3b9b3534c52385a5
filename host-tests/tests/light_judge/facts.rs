//! From what a program did to the judge's facts.
//!
//! Boundaries of paths are known by the outputs that BufDoBit changes beside the laser entries,
//! standstills and the axes' causes by what the axes and coordinate systems show in each tick:
//! nothing is taken from the lasers.
use super::lateness::late;
use super::machine::{Reported, Seen, Sent};
use super::program::{Act, Buf, Do, Program};
use host_tests::light_judge::fact::Laser;
use host_tests::light_judge::{Fact, Ns, Output, What, Why};
use servo::path::PathStop;
use std::collections::VecDeque;
use virtual_board::Output as Digital;

/// Two exact instants so near may be one.
const SAME_INSTANT_NS: Ns = 20;
/// Status bits: alarm, following error, limits.
const CAUSES: u32 = 1 << 1 | 1 << 4 | 1 << 5 | 1 << 6;
const SERVO: u32 = 1 << 9;

/// Where a fact comes from, for what may have come first.
#[derive(Debug, Clone, Copy, PartialEq)]
enum From {
    Call(Do),
    Entry(usize),
    Rest { crd: usize, exact: bool },
    Cause,
}

struct Noted {
    /// Where it stands in the order.
    key: Ns,
    rank: u8,
    from: From,
    fact: Fact,
}

struct Builder<'a> {
    program: &'a Program,
    reported: &'a Reported,
    tick: Ns,
    noted: Vec<Noted>,
    /// Between these instants it is open what a coordinate system does, and what these channels
    /// follow.
    open: Vec<(Ns, Ns, u8, u8)>,
}

/// The facts of a program, in order.
pub fn facts(program: &Program, reported: &Reported, tick: Ns) -> Vec<Fact> {
    let mut builder = Builder { program, reported, tick, noted: Vec::new(), open: Vec::new() };
    builder.entries();
    builder.made_again();
    builder.sights();
    builder.calls();
    builder.acts();
    builder.ordered()
}

/// The channels whose follow an event begins or ends.
fn changes_follow(noted: &Noted) -> u8 {
    match noted.fact.what {
        What::Entry { channel, laser: Laser::Follow | Laser::FollowOff | Laser::Power, .. } => 1 << channel,
        What::Power { channel } | What::Mode { channel } | What::Map { channel, .. } => 1 << channel,
        What::Stop { ends_follow, .. } if ends_follow != 0 => 3,
        _ => 0,
    }
}

impl Builder<'_> {
    fn note(&mut self, key: Ns, rank: u8, from: From, lo: Ns, hi: Ns, what: What) {
        self.noted.push(Noted { key, rank, from, fact: Fact { lo, hi, what } });
    }

    /// Groups of entries, each after a mark, and when they were reached.
    fn entries(&mut self) {
        let mut queues: [VecDeque<Vec<(usize, Laser)>>; 4] = Default::default();
        let set_up = self.program.entries.iter().map(|call| Sent { at: 0, call: *call, code: Some(0) });
        let sent: Vec<Sent> = set_up.chain(self.reported.sent.iter().copied()).collect();
        let mut sent = sent.iter().peekable();
        for edge in &self.reported.edges {
            let Digital::General(bit @ 0..4) = edge.output else { continue };
            let at = edge.at_ns as Ns;
            // What stands after a mark that is passed before a CrdClear acts is passed, too.
            let acts = |one: &Sent| one.at + if matches!(one.call, Do::CrdClear { .. }) { self.tick } else { 0 };
            while let Some(one) = sent.next_if(|one| acts(one) < at) {
                Self::queue(&mut queues, one);
            }
            let crd = usize::from(bit) / 2;
            let Some(group) = queues[usize::from(bit)].pop_front() else { continue };
            for (channel, laser) in group {
                self.note(at, 1, From::Entry(crd), at, at, What::Entry { crd, channel, laser });
            }
        }
    }

    /// An abrupt Stop sets a path back to where it was a tick before. The entries of a laser that
    /// it had reached in that tick are made again when it comes there; their marks are not, so it
    /// is open when.
    fn made_again(&mut self) {
        for crd in 0..2 {
            let turns = |from: bool| {
                let turned = move |pair: &&[Seen]| pair[0].runs[crd] == from && pair[1].runs[crd] != from;
                self.reported.seen.windows(2).filter(turned).map(|pair| &pair[1])
            };
            let reached = |lo: Ns, hi: Ns| {
                let of = |noted: &&Noted| noted.from == From::Entry(crd) && noted.fact.lo >= lo && noted.fact.lo <= hi;
                self.noted.iter().filter(of).map(|noted| noted.fact.lo).min()
            };
            let (mut open, mut again) = (Vec::new(), Vec::new());
            for stop in turns(true) {
                let stopped = !matches!(stop.rest[crd], PathStop::Completed | PathStop::Underrun);
                if !stopped || !self.stopped_abruptly(crd, stop) || reached(stop.at - self.tick, stop.at).is_none() {
                    continue;
                }
                let goes_on = |start: &&Seen| start.at > stop.at && start.fifo[crd] == stop.fifo[crd];
                let Some(start) = turns(false).find(goes_on) else { continue };
                // Another Stop may come before them.
                let over = |end: &&Seen| {
                    end.at > start.at && matches!(end.rest[crd], PathStop::Completed | PathStop::Underrun)
                };
                let ends = turns(true).find(over).map(|end| end.at);
                let next = reached(start.at + 1, Ns::MAX);
                let until = ends.into_iter().chain(next).min().unwrap_or(self.reported.end);
                let within = |fact: &Fact| fact.lo >= stop.at - self.tick && fact.lo <= stop.at;
                let made: Vec<&Noted> =
                    self.noted.iter().filter(|noted| noted.from == From::Entry(crd) && within(&noted.fact)).collect();
                let follows = made.iter().fold(0, |channels, noted| channels | changes_follow(noted));
                open.push((start.at - self.tick, until, 1 << crd, follows));
                let starts = turns(false).filter(|again| goes_on(again) && again.at < until);
                for start in starts {
                    again.extend(made.iter().map(|noted| (start.at, until, noted.fact.what)));
                }
            }
            self.open.extend(open);
            for (at, until, what) in again {
                self.note(at + 1, 1, From::Entry(crd), at, until, what);
            }
        }
        for (lo, hi, crds, follows) in self.open.clone() {
            self.note(lo, 0, From::Cause, lo, lo, What::Doubt { crds, follows });
            self.note(hi, 4, From::Cause, hi, hi, What::Doubt { crds, follows });
        }
    }

    /// Whether something stopped this coordinate system at once: a smooth Stop does not set it
    /// back.
    fn stopped_abruptly(&self, crd: usize, stop: &Seen) -> bool {
        let about = stop.at - 2 * self.tick..=stop.at;
        let called = self.reported.sent.iter().filter(|sent| about.contains(&sent.at)).any(|sent| match sent.call {
            Do::Stop { abrupt, .. } | Do::CrdStop { abrupt, .. } => abrupt != 0,
            Do::AxisOff { .. } | Do::AxisStop { .. } => true,
            _ => false,
        });
        let caused = stop.status[2 * crd..2 * crd + 2].iter().any(|status| status & CAUSES != 0 || status & SERVO == 0);
        let interlock = |(at, act): &(Ns, Act)| about.contains(at) && matches!(act, Act::Interlock { .. });
        called || caused || self.reported.acts.iter().any(interlock)
    }

    fn queue(queues: &mut [VecDeque<Vec<(usize, Laser)>>; 4], sent: &Sent) {
        if sent.code != Some(0) {
            return;
        }
        match sent.call {
            Do::Entry { crd, fifo, buf: Buf::Mark } => queues[2 * crd + fifo].push_back(Vec::new()),
            Do::Entry { crd, fifo, buf: Buf::Laser { channel, laser, .. } } => {
                if let Some(group) = queues[2 * crd + fifo].back_mut() {
                    group.push((channel, laser));
                }
            }
            Do::CrdClear { crd, fifo } => queues[2 * crd + fifo].clear(),
            _ => {}
        }
    }

    /// Standstills and causes that the axes show.
    fn sights(&mut self) {
        for pair in self.reported.seen.windows(2) {
            let [before, now] = pair else { continue };
            for crd in 0..2 {
                if before.runs[crd] && !now.runs[crd] {
                    self.rest(crd, now);
                }
            }
            self.causes(before, now);
            if before.jog != now.jog {
                let (lo, hi) = (now.at - self.tick, now.at + self.tick);
                self.note(now.at, 0, From::Cause, lo, hi, What::Jog { runs: now.jog });
            }
        }
        // A path that ran for less than a tick is not seen to run.
        for sent in self.reported.sent.iter().filter(|sent| sent.code.is_none_or(|code| code == 0)) {
            let Do::CrdStart { mask, .. } = sent.call else { continue };
            let at = sent.at + self.tick;
            for crd in (0..2).filter(|crd| mask >> crd & 1 == 1) {
                let seen = self.reported.view(at);
                let acted = sent.code.is_some() || self.entered(crd, sent);
                if acted && !seen.runs[crd] && self.began(crd, sent).is_none() {
                    let at = if self.stopped_at(crd, at) { at + self.tick } else { at };
                    self.rest(crd, &Seen { at, ..seen });
                }
            }
        }
    }

    /// Whether a Stop was seen to have brought a coordinate system to rest in the tick that ends
    /// here.
    fn stopped_at(&self, crd: usize, at: Ns) -> bool {
        let rests = |pair: &[Seen]| pair[1].at == at && pair[0].runs[crd] && !pair[1].runs[crd];
        let stopped = |seen: &Seen| !matches!(seen.rest[crd], PathStop::Completed | PathStop::Underrun);
        self.reported.seen.windows(2).any(|pair| rests(pair) && stopped(&pair[1]))
    }

    /// Whether entries of a coordinate system acted about when this start did.
    fn entered(&self, crd: usize, sent: &Sent) -> bool {
        let about = sent.at..=sent.at + 2 * self.tick;
        self.noted.iter().any(|noted| noted.from == From::Entry(crd) && about.contains(&noted.fact.lo))
    }

    /// When a coordinate system was seen to begin to run for this start: what came with much else
    /// may act later.
    fn began(&self, crd: usize, sent: &Sent) -> Option<Ns> {
        let at = if sent.code.is_some() { sent.at + self.tick } else { sent.at };
        let is_next = |other: &&Sent| {
            let Do::CrdStart { mask, .. } = other.call else { return false };
            other.code == Some(0) && mask >> crd & 1 == 1
        };
        let mut after = self.reported.sent.iter().skip_while(|other| !std::ptr::eq(*other, sent)).skip(1);
        let next = after.find(is_next).map_or(self.reported.end, |next| next.at + self.tick);
        let last = (at + 3 * self.tick).min(next - 1);
        let from = self.reported.seen.partition_point(|seen| seen.at < at).max(1);
        let near = self.reported.seen[from - 1..].windows(2).take_while(|pair| pair[1].at <= last);
        near.filter(|pair| !pair[0].runs[crd] && pair[1].runs[crd]).map(|pair| pair[1].at).next()
    }

    fn rest(&mut self, crd: usize, now: &Seen) {
        let why = match now.rest[crd] {
            PathStop::Completed => Why::Done,
            PathStop::Underrun => Why::Underrun,
            _ => Why::Stopped,
        };
        let (lo, hi) = (now.at - self.tick, now.at);
        if why == Why::Stopped {
            self.again(crd, now.at);
        }
        let bit = 2 * crd as u8 + now.fifo[crd];
        let marks = self.reported.edges.iter().filter(|edge| edge.output == Digital::General(bit));
        let last = marks.map(|edge| edge.at_ns as Ns).take_while(|at| *at <= hi).last();
        match last.filter(|at| *at >= lo && why != Why::Stopped) {
            Some(at) => {
                let late = if why == Why::Underrun { at + self.tick } else { at };
                self.note(at, 2, From::Rest { crd, exact: true }, at, late, What::Rest { crd, why });
            }
            None => self.note(now.at, 2, From::Rest { crd, exact: false }, lo, hi, What::Rest { crd, why }),
        }
    }

    fn causes(&mut self, before: &Seen, now: &Seen) {
        for axis in 0..4 {
            let crds = 1u8 << (axis / 2) & self.program.settings.set_up;
            let (was, is) = (before.status[axis], now.status[axis]);
            if crds != 0 && (!was & is & CAUSES | was & !is & SERVO) != 0 {
                let (lo, hi) = (now.at - 2 * self.tick, now.at + self.tick);
                self.note(hi, 0, From::Cause, lo, hi, What::Fault { crds, sure: true });
            }
        }
    }

    /// Whether every cause is over.
    fn is_over(&self, at: Ns) -> bool {
        let seen = self.reported.view(at);
        let mut inputs = 0i32;
        for (_, act) in self.reported.acts.iter().take_while(|(when, _)| *when <= at) {
            inputs += match act {
                Act::Alarm { level, .. } | Act::Limit { level, .. } => {
                    if *level {
                        1
                    } else {
                        -1
                    }
                }
                Act::Interlock { .. } => 1,
                Act::InterlockGone => -1,
                _ => 0,
            };
        }
        inputs <= 0 && seen.status.iter().all(|status| status & CAUSES == 0 && status & SERVO != 0)
    }

    fn calls(&mut self) {
        let mut maps = self.program.settings.channels.map(|channel| channel.map);
        let mut again = Vec::new();
        for sent in &self.reported.sent {
            let at = sent.at + self.tick;
            let from = From::Call(sent.call);
            let Some(code) = sent.code else {
                self.note(at, 0, from, sent.at, at, What::Unanswered);
                self.start(sent, sent.at);
                continue;
            };
            let sure = true;
            let what = match sent.call {
                Do::On { channel, .. } => What::On { channel, code, sure },
                Do::Map { channel, map } => {
                    if code == 0 {
                        maps[channel] = map;
                        let near = |noted: &Noted| {
                            noted.from == From::Cause
                                && noted.fact.lo <= at + self.tick
                                && noted.fact.hi + self.tick >= at
                        };
                        if self.noted.iter().any(near) {
                            // Which of the maps the cause met is open.
                            let fact = What::Fault { crds: u8::MAX, sure: false };
                            self.note(at, 0, From::Cause, at - self.tick, at + self.tick, fact);
                        }
                        for crd in (0..2).filter(|crd| map >> crd & 1 == 1) {
                            again.push((crd, at));
                        }
                    }
                    What::Map { channel, map, code, sure }
                }
                Do::Abort => {
                    self.note(at, 0, from, sent.at, at, What::Abort);
                    continue;
                }
                _ if code != 0 => continue,
                Do::Off { channel, .. } => What::Off { channel },
                Do::Power { channel, .. } => What::Power { channel },
                Do::Delays { channel, on, off } => {
                    What::Delays { channel, on: Ns::from(on) * 1000, off: Ns::from(off) * 1000 }
                }
                Do::Mode { channel, mode } if mode != self.program.devices[channel].mode => {
                    self.note(at, 0, from, sent.at, at + late(self.reported, sent, self.tick), What::Mode { channel });
                    continue;
                }
                Do::Connector { channel, there } => {
                    // Analog light needs none.
                    let there = there || matches!(self.program.settings.channels[channel].output, Output::Volts { .. });
                    let lo = if there { at } else { sent.at };
                    self.note(
                        at,
                        0,
                        from,
                        lo,
                        at + late(self.reported, sent, self.tick),
                        What::Connector { channel, there },
                    );
                    continue;
                }
                Do::ClearFault { channel } => {
                    What::Cleared { channels: 1 << channel, gone: self.is_over(at), by_name: true }
                }
                Do::ClearStatus { axis, count } => {
                    let crds = (axis..axis + count).fold(0u8, |crds, axis| crds | 1 << (axis / 2));
                    let crds = crds & self.program.settings.set_up;
                    let channels =
                        (0..2).filter(|channel| maps[*channel] & crds != 0).map(|channel| 1 << channel).sum();
                    What::Cleared { channels, gone: self.is_over(at), by_name: false }
                }
                Do::CrdStart { .. } => {
                    self.start(sent, at);
                    continue;
                }
                Do::Stop { crds, ends_follow, .. } => What::Stop { crds, ends_follow },
                Do::CrdStop { crds, .. } => What::Stop { crds, ends_follow: 0 },
                Do::AxisStop { axis } => What::Stop { crds: 1 << (axis / 2), ends_follow: 0 },
                Do::CrdClear { crd, fifo } => What::CrdClear { crd, fifo },
                Do::PosErr { axis, .. } => {
                    // An error that a lower limit finds shows nothing new where one is latched.
                    self.again(axis / 2, at);
                    continue;
                }
                _ => continue,
            };
            let late = late(self.reported, sent, self.tick);
            // What rests in the tick before goes by the delays before.
            let rank = if matches!(what, What::Delays { .. }) { 3 } else { 0 };
            self.note(at, rank, from, at, at + late, what);
        }
        for (crd, at) in again {
            self.again(crd, at);
        }
    }

    /// A start that acts at this instant, or when it was seen to; one that was not answered, only
    /// where it was seen to.
    fn start(&mut self, sent: &Sent, at: Ns) {
        let Do::CrdStart { mask, option } = sent.call else { return };
        for crd in (0..2).filter(|crd| mask >> crd & 1 == 1) {
            let fifo = usize::from(option >> crd & 1);
            let began = self.began(crd, sent);
            if began.is_some() || sent.code.is_some() || self.entered(crd, sent) {
                // One that is not seen to run goes on from where a Stop of the same tick brought it
                // to rest.
                let goes_on = began.is_none() && self.stopped_at(crd, at);
                let (key, late) = if goes_on { (1, self.tick) } else { (0, 0) };
                let at = began.unwrap_or(at);
                self.note(at + key, 0, From::Call(sent.call), at, at + late, What::Start { crd, fifo });
                self.again(crd, at);
            }
        }
    }

    /// What may meet an old cause: it may be one again.
    fn again(&mut self, crd: usize, at: Ns) {
        let status = self.reported.view(at).status;
        if (2 * crd..2 * crd + 2).any(|axis| status[axis] & CAUSES != 0) {
            let fact = What::Fault { crds: 1 << crd, sure: false };
            self.note(at, 0, From::Cause, at - self.tick, at + 2 * self.tick, fact);
        }
    }

    fn acts(&mut self) {
        let analog = self.program.settings.channels.iter().any(|of| matches!(of.output, Output::Volts { .. }));
        let tick = self.tick;
        for &(at, act) in &self.reported.acts {
            match act {
                Act::Interlock { after } => {
                    let lo = at + after as Ns;
                    let hi = lo + if analog { 2 * tick } else { 0 };
                    self.note(hi, 0, From::Cause, lo, hi, What::FaultOfAll);
                }
                Act::Overrun => self.note(at + 2 * tick, 0, From::Cause, at, at + 2 * tick, What::FaultOfAll),
                Act::Alarm { axis, level: true } | Act::Limit { axis, level: true, .. } => {
                    // Where the last one still shows, nothing new does.
                    self.again(axis / 2, at + tick);
                }
                Act::Session => self.note(at + tick, 0, From::Cause, at, at + 2 * tick, What::Session),
                _ => {}
            }
        }
        for &at in &self.reported.losses {
            let hi = at + 2 * tick;
            let between = |noted: &Noted| noted.fact.hi >= at - SAME_INSTANT_NS && noted.fact.lo <= hi;
            if self.noted.iter().any(between) {
                self.note(
                    at - SAME_INSTANT_NS,
                    0,
                    From::Cause,
                    at - SAME_INSTANT_NS,
                    at - SAME_INSTANT_NS,
                    What::Doubt { crds: 3, follows: 0 },
                );
            }
            // Whether a path that rests about now still ran is open.
            let rests = |noted: &Noted| {
                matches!(noted.fact.what, What::Rest { .. }) && noted.fact.lo <= hi && noted.fact.hi >= at
            };
            let open = self.noted.iter().any(rests);
            let what = if open { What::Fault { crds: u8::MAX, sure: false } } else { What::LinkLoss };
            self.note(if open { at } else { hi }, 3, From::Cause, at, hi, what);
        }
    }

    /// In order, and a doubt around what may have come in another one.
    fn ordered(mut self) -> Vec<Fact> {
        self.noted.sort_by_key(|noted| (noted.key, noted.rank));
        // Before the earlier one, and after each one from there to the later one.
        let mut doubts: Vec<(usize, usize, u8, u8)> = Vec::new();
        let near = 4 * self.tick;
        for later in 0..self.noted.len() {
            for earlier in
                (0..later).rev().take_while(|earlier| self.noted[*earlier].key + near >= self.noted[later].key)
            {
                let crds = self.doubt(&self.noted[earlier], &self.noted[later]);
                if crds != 0 {
                    let follows = changes_follow(&self.noted[earlier]) & changes_follow(&self.noted[later]);
                    doubts.push((earlier, later, crds, follows));
                }
            }
            self.unsure(later);
        }
        for &(lo, hi, crds, follows) in &self.open {
            let within = |noted: &Noted| (lo..=hi).contains(&noted.key);
            let first = self.noted.iter().position(within);
            let last = self.noted.iter().rposition(within);
            doubts.extend(first.zip(last).map(|(first, last)| (first, last, crds, follows)));
        }
        let mut facts = Vec::with_capacity(self.noted.len() + doubts.len());
        for (index, noted) in self.noted.iter().enumerate() {
            let begins = doubts.iter().filter(|(at, ..)| *at == index);
            let mut begins: Vec<Fact> = begins
                .map(|&(_, later, crds, follows)| {
                    Fact::at(noted.fact.lo.min(self.noted[later].fact.lo), What::Doubt { crds, follows })
                })
                .collect();
            begins.sort_by_key(|doubt| doubt.lo);
            facts.extend(begins);
            facts.push(noted.fact);
            for &(.., crds, follows) in doubts.iter().filter(|(from, to, ..)| (*from..=*to).contains(&index)) {
                facts.push(Fact { what: What::Doubt { crds, follows }, ..noted.fact });
            }
        }
        facts
    }

    /// Answers near a standstill or a cause may be those of either side.
    fn unsure(&mut self, index: usize) {
        let at = self.noted[index].fact.lo;
        if !matches!(self.noted[index].fact.what, What::On { .. } | What::Map { .. }) {
            return;
        }
        let tick = self.tick;
        let unsure = self.noted.iter().any(|other| {
            !matches!(other.from, From::Entry(_))
                && !matches!(other.fact.what, What::On { .. } | What::Off { .. } | What::Power { .. })
                && other.fact.lo - 2 * tick <= at
                && at <= other.fact.hi + 3 * tick
        });
        if let What::On { sure, .. } | What::Map { sure, .. } = &mut self.noted[index].fact.what {
            *sure = !unsure;
        }
    }

    fn same_channel(&self, a: &Noted, b: &Noted) -> bool {
        let of = |noted: &Noted| if let What::Entry { channel, .. } = noted.fact.what { Some(channel) } else { None };
        of(a) == of(b)
    }

    /// Whether a Stop was sent not long before the call that is one of these, or with it.
    fn at_once(&self, sent: &Sent, a: &Noted, b: &Noted) -> bool {
        let at = if matches!(a.from, From::Call(_)) { a.fact.lo } else { b.fact.lo };
        let stops = matches!(sent.call, Do::Stop { .. } | Do::CrdStop { .. } | Do::AxisStop { .. });
        stops && (at - 60 * self.tick..=at).contains(&(sent.at + self.tick))
    }

    /// Of which coordinate systems nobody knows which of two came first.
    fn doubt(&self, a: &Noted, b: &Noted) -> u8 {
        let set = |crd: usize| 1u8 << crd;
        let mark_changed = |slack: Ns| a.fact.lo <= b.fact.hi + slack && b.fact.lo <= a.fact.hi + slack;
        let names = |call: &Do, crd: usize| match call {
            // What one Stop keeps dark another may, too.
            Do::CrdStart { .. } => true,
            Do::Stop { crds, ends_follow, .. } => (crds | ends_follow) & set(crd) != 0,
            Do::CrdStop { crds, .. } => crds & set(crd) != 0,
            Do::AxisStop { axis } => axis / 2 == crd,
            Do::On { .. } | Do::Off { .. } | Do::Power { .. } | Do::Map { .. } | Do::Delays { .. } => true,
            _ => false,
        };
        let abrupt = |call: &Do, crd: usize| match call {
            Do::Stop { crds, abrupt, .. } | Do::CrdStop { crds, abrupt } => crds & abrupt & set(crd) != 0,
            _ => false,
        };
        match (a.from, b.from) {
            (From::Call(call), From::Rest { crd, .. }) | (From::Rest { crd, .. }, From::Call(call)) => {
                let stopped = matches!(a.fact.what, What::Rest { why: Why::Stopped, .. })
                    || matches!(b.fact.what, What::Rest { why: Why::Stopped, .. });
                // Of two Stops the second may find it at rest.
                let alone = || {
                    self.reported.sent.iter().filter(|sent| self.at_once(sent, a, b) && names(&sent.call, crd)).count()
                        < 2
                };
                let stops = matches!(call, Do::Stop { .. } | Do::CrdStop { .. } | Do::AxisStop { .. });
                if !mark_changed(self.tick) || !(stops || names(&call, crd)) || stopped && abrupt(&call, crd) && alone()
                {
                    0
                } else {
                    set(crd)
                }
            }
            (From::Cause, From::Rest { crd, .. }) | (From::Rest { crd, .. }, From::Cause) if mark_changed(0) => {
                set(crd)
            }
            (From::Rest { crd, .. }, From::Rest { crd: other, .. }) if crd != other && mark_changed(0) => {
                let stopped = |noted: &Noted| matches!(noted.fact.what, What::Rest { why: Why::Stopped, .. });
                if stopped(a) && stopped(b) { 0 } else { set(crd) | set(other) }
            }
            (From::Cause, From::Entry(crd)) | (From::Entry(crd), From::Cause)
                if mark_changed(SAME_INSTANT_NS) && (a.fact.what == What::Session || b.fact.what == What::Session) =>
            {
                set(crd)
            }
            // With nothing to bring to rest an on may wait for the abort's end.
            (From::Call(Do::Abort), From::Entry(crd)) if mark_changed(self.tick) => set(crd),
            (From::Call(call), From::Entry(crd)) | (From::Entry(crd), From::Call(call)) => {
                let start = matches!(call, Do::CrdStart { .. });
                let clears = matches!(call, Do::ClearFault { .. } | Do::ClearStatus { .. });
                if mark_changed(SAME_INSTANT_NS) && (clears || names(&call, crd) && !start) { set(crd) } else { 0 }
            }
            (From::Rest { crd, exact }, From::Entry(other)) | (From::Entry(other), From::Rest { crd, exact }) => {
                let slack = if exact { SAME_INSTANT_NS } else { self.tick };
                if crd != other && mark_changed(slack) { set(crd) | set(other) } else { 0 }
            }
            (From::Entry(one), From::Entry(other))
                if one != other && mark_changed(SAME_INSTANT_NS) && self.same_channel(a, b) =>
            {
                3
            }
            _ => 0,
        }
    }
}
