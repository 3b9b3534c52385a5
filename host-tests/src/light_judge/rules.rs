//! What acts on a channel, and what follows from it: SPEC 6 ("Whose light it is", "Rest") and 9.
//!
//! In: [`Fact`]s in the order of time. Out: for each channel its gate commands, the times in which
//! nothing at all may be output, and answers that contradict the rules. What is in doubt stays so
//! until an event that settles it.
use super::Ns;
use super::fact::{Fact, Settings, What};
use super::gate::{Gate, Level};
use state::{Channel, Commanded, Crd, Maybe, members, set};

mod calls;
mod causes;
mod motion;
mod state;

/// Two exact instants so near may be one.
const SAME_INSTANT_NS: Ns = 20;

/// What follows for a channel.
#[derive(Debug, Clone, Default)]
pub struct Verdict {
    /// In the order in which they were given.
    pub gates: Vec<Gate>,
    /// When nothing at all may be output: no standby, no pre-voltage.
    pub safe: Vec<(Ns, Ns)>,
}

/// See the module text.
pub struct Judge {
    settings: Settings,
    channels: [Channel; 2],
    crds: [Crd; 2],
    /// Calls within this time of an event may have been answered before it or after it.
    near: Ns,
    now: (Ns, Ns),
    /// An axis beside the paths moves, and it did at an abort.
    jog: bool,
    jog_aborted: bool,
    /// When what was aborted rested last.
    rested: Ns,
    /// Answers that contradict the rules.
    pub wrong: Vec<String>,
    /// Which rules were needed.
    pub used: Vec<&'static str>,
}

impl Judge {
    /// Everything is dark and at standstill. A call within `near` of an event may have been
    /// answered before or after it.
    pub fn new(settings: Settings, near: Ns) -> Judge {
        let channel = |index: usize| Channel {
            map: settings.channels[index].map,
            connector: settings.channels[index].connector,
            commanded: Commanded::Off,
            kept: [None; 2],
            kept_doubt: false,
            veto: Maybe::No,
            follow: None,
            follow_open: false,
            withdrawn: None,
            old_map: (0, Ns::MIN / 2),
            fault: Maybe::No,
            fault_since: Ns::MIN / 2,
            clears_until: Ns::MIN / 2,
            lost: None,
            quiet: false,
            safe_since: None,
            level: Level::Off,
            delays: (settings.channels[index].timing.on, settings.channels[index].timing.off),
            verdict: Verdict::default(),
        };
        let rest =
            Crd { runs: false, fifo: 0, stopping: false, resumable: [false; 2], dead: Maybe::No, aborted: Maybe::No };
        Judge {
            settings,
            channels: [channel(0), channel(1)],
            crds: [rest; 2],
            near,
            now: (0, 0),
            jog: false,
            jog_aborted: false,
            rested: Ns::MIN / 2,
            wrong: Vec::new(),
            used: Vec::new(),
        }
    }

    /// One fact more; its instants do not go back.
    pub fn take(&mut self, fact: &Fact) {
        self.now = (fact.lo, fact.hi);
        match fact.what {
            What::On { channel, code, sure } => self.on(channel, code, sure),
            What::Off { channel } => {
                let of = &mut self.channels[channel];
                of.mark_changed();
                of.off();
                of.veto = Maybe::Yes;
            }
            What::Power { channel } => {
                self.channels[channel].mark_changed();
                if self.settings.is_gus {
                    self.end_follow(channel);
                }
            }
            What::Delays { channel, on, off } => {
                self.used.push("other delays");
                self.other_delays(channel, on, off);
            }
            What::Mode { channel } => {
                self.used.push("another mode");
                let of = &mut self.channels[channel];
                of.mark_changed();
                (of.follow, of.follow_open) = (None, false);
                of.cut(self.now);
            }
            What::Jog { runs } => {
                if !runs && self.jog_aborted {
                    self.used.push("abort of a jog axis");
                    (self.jog_aborted, self.rested) = (false, self.now.1);
                }
                self.jog = runs;
            }
            What::Map { channel, map, code, sure } => self.map(channel, map, code, sure),
            What::Connector { channel, there } => {
                let of = &mut self.channels[channel];
                of.mark_changed();
                of.connector = there;
                if !there {
                    self.used.push("connector taken away");
                    of.cut(self.now);
                }
            }
            What::Cleared { channels, gone, by_name } => {
                for channel in members(channels) {
                    let of = &mut self.channels[channel];
                    of.quiet &= !by_name;
                    if self.now.1 > self.now.0 {
                        of.clears_until = self.now.1;
                    }
                    // One that came just now may have come after it.
                    let gone = gone && self.now.0 - of.fault_since > 3 * self.near;
                    of.fault = if gone || of.fault == Maybe::No { Maybe::No } else { Maybe::Doubt };
                    if let Some(lost) = &mut of.lost {
                        lost.cleared = true;
                    }
                }
            }
            What::CrdClear { crd, fifo } => self.crd_clear(crd, fifo),
            What::Start { crd, fifo } => self.start(crd, fifo),
            What::Stop { crds, ends_follow } => self.stop(crds, ends_follow),
            What::Entry { crd, channel, laser } => self.entry(crd, channel, laser),
            What::Rest { crd, why } => self.rest(crd, why),
            What::Fault { crds, sure: true } => {
                let lo = self.now.0;
                // The map that the cause met.
                let old = |of: &Channel| if of.old_map.1 >= lo { of.old_map.0 } else { of.map };
                for of in &mut self.channels {
                    if (of.map & crds != 0) != (old(of) & crds != 0) {
                        of.perhaps_cut(self.now);
                    }
                }
                self.fault(|of| of.map & crds != 0 && old(of) & crds != 0);
            }
            What::Fault { crds, .. } => {
                for of in self.channels.iter_mut().filter(|of| of.map & crds != 0 || crds == u8::MAX) {
                    of.perhaps_cut(self.now);
                }
            }
            What::FaultOfAll => self.fault(|_| true),
            What::LinkLoss => self.link_loss(),
            What::Abort => {
                self.used.push("abort");
                self.jog_aborted |= self.jog;
                if self.crds.iter().any(|crd| crd.runs && crd.stopping) {
                    self.used.push("abort while it brakes");
                }
                self.abandon(true);
            }
            What::Session => {
                self.used.push("new session");
                self.abandon(false);
            }
            What::Unanswered => {
                for of in &mut self.channels {
                    of.mark_changed();
                    of.off();
                    of.commanded = Commanded::Doubt;
                    of.fault = if of.fault == Maybe::No { Maybe::No } else { Maybe::Doubt };
                }
            }
            What::Doubt { crds, follows } => {
                for of in &mut self.channels {
                    of.doubt(crds);
                }
                for channel in members(follows) {
                    self.channels[channel].follow_open = true;
                }
                for crd in members(crds) {
                    let crd = &mut self.crds[crd];
                    crd.dead = if crd.runs && crd.dead != Maybe::No { Maybe::Doubt } else { crd.dead };
                }
            }
        }
        for channel in 0..2 {
            self.settle(channel);
        }
    }

    /// What follows for the channels, up to `until`.
    pub fn finish(mut self, until: Ns) -> ([Verdict; 2], Vec<String>, Vec<&'static str>) {
        for of in &mut self.channels {
            if let Some(since) = of.safe_since.take() {
                of.verdict.safe.push((since, until));
            }
        }
        (self.channels.map(|of| of.verdict), self.wrong, self.used)
    }

    /// The gate command that follows, if another one does.
    fn settle(&mut self, channel: usize) {
        let of = &mut self.channels[channel];
        if of.follow_open && matches!(of.commanded, Commanded::On(_)) {
            // Whether it waits for the path that it follows is open.
            of.commanded = Commanded::Doubt;
        }
        let of = &self.channels[channel];
        let waits = !of.follow_open && of.follow.is_some_and(|crd| !self.crds[crd].runs);
        let dark = of.fault == Maybe::Yes || !of.connector || of.kept.iter().any(Option::is_some) || waits;
        if waits && matches!(of.commanded, Commanded::On(_)) && of.kept == [None; 2] {
            self.used.push("light waits under a follow");
        }
        let level = match of.commanded {
            _ if dark => Level::Off,
            Commanded::Off => Level::Off,
            Commanded::On(_) => Level::On,
            Commanded::Doubt => Level::Doubt,
        };
        let (lo, hi) = self.now;
        let of = &mut self.channels[channel];
        if level != of.level {
            of.level = level;
            // What was commanded within the doubt was perhaps never in force.
            while level == Level::Doubt && of.verdict.gates.pop_if(|last| last.lo >= lo && !last.cut).is_some() {}
            of.verdict.gates.push(Gate { lo, hi, level, cut: false, delays: of.delays });
        }
        let safe = of.fault == Maybe::Yes || of.quiet;
        match of.safe_since {
            None if safe => of.safe_since = Some(hi),
            Some(since) if !safe => {
                of.safe_since = None;
                if since < lo {
                    of.verdict.safe.push((since, lo));
                }
            }
            _ => {}
        }
    }

    fn runs(&self) -> u8 {
        (0..2).filter(|crd| self.crds[*crd].runs).map(set).sum()
    }
}
