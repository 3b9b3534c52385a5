//! What paths do to light.
//!
//! In: an entry that was reached, or a standstill. Out: the state after it.
use super::super::fact::{Laser, Why};
use super::Judge;
use super::state::{Commanded, Lost, Maybe, Owner, set};

impl Judge {
    pub(super) fn entry(&mut self, crd: usize, channel: usize, laser: Laser) {
        let mut state = self.crds[crd];
        // Until everything is at standstill an abort refuses every on.
        let lives = state.dead == Maybe::No;
        let aborting = self.jog_aborted || self.crds.iter().any(|crd| crd.runs && crd.aborted == Maybe::Yes);
        if aborting && state.dead != Maybe::Yes {
            (state.dead, state.aborted) = (Maybe::Yes, Maybe::Yes);
            self.used.push("entry before an abort is over");
        } else if (self.now.0 - self.rested).abs() <= 2 * self.near && state.dead == Maybe::No {
            state.dead = Maybe::Doubt;
        }
        let of = &mut self.channels[channel];
        if of.map & set(crd) == 0 {
            self.used.push("entry outside the map");
            return;
        }
        let dead = state.dead == Maybe::Yes || of.fault == Maybe::Yes || !of.connector;
        if lives {
            // An on entry without effect leaves standby and pre-voltage as they were.
            let quiet = of.quiet && laser == Laser::On && dead;
            of.mark_changed();
            of.quiet = quiet;
        }
        match laser {
            Laser::On => {
                if dead {
                    self.used.push(match state.aborted {
                        _ if !of.connector => "on entry without a connector",
                        _ if state.dead != Maybe::Yes => "on entry under a fault",
                        Maybe::Yes => "on entry ahead of an abort",
                        _ => "on entry ahead of a new session",
                    });
                    return;
                }
                if state.stopping && of.veto == Maybe::Yes {
                    self.used.push("on entry after an off, braking");
                    return;
                }
                let vetoed = state.stopping && of.veto == Maybe::Doubt;
                if of.fault == Maybe::Doubt || state.dead == Maybe::Doubt || vetoed {
                    of.doubt(3);
                    of.commanded = Commanded::Doubt;
                    return;
                }
                of.off();
                of.veto = Maybe::No;
                of.commanded = Commanded::On(Owner::Crd(crd));
            }
            Laser::Off => of.off(),
            Laser::Follow if of.follow == Some(crd) && !of.follow_open => {}
            Laser::Follow => {
                self.end_follow(channel);
                self.channels[channel].follow = Some(crd);
            }
            Laser::Source => {}
            Laser::FollowOff => self.end_follow(channel),
            Laser::Power if self.settings.is_gus => self.end_follow(channel),
            Laser::Power => {}
        }
    }

    pub(super) fn rest(&mut self, crd: usize, why: Why) {
        let now = self.now.0;
        let state = &mut self.crds[crd];
        let (stopped, fifo) = (std::mem::take(&mut state.stopping), state.fifo);
        let (aborted, by_abort) = (state.aborted != Maybe::No, state.aborted == Maybe::Yes);
        if aborted {
            self.rested = self.now.1;
        }
        (state.runs, state.dead, state.aborted) = (false, Maybe::No, Maybe::No);
        state.resumable[fifo] = why == Why::Stopped;
        if why == Why::Underrun {
            self.used.push("underrun");
            self.fault(|of| of.map & set(crd) != 0);
        }
        for of in &mut self.channels {
            let mapped = of.map & set(crd) != 0;
            let follows = of.follow == Some(crd);
            // What a lost link took ends with the entries that lit it.
            let ended = |lost: &Lost| why != Why::Stopped && lost.owner == Some(Owner::Crd(crd));
            if let Some(lost) = of.lost.as_mut().filter(|lost| stopped && mapped || ended(lost)) {
                lost.doubt = true;
            }
            match why {
                Why::Stopped if stopped && mapped => {
                    if of.withdrawn.is_some_and(|at| now - at <= self.near) {
                        // One Stop ends the follow under which it waits, and shuts it off: which is
                        // first is open.
                        self.used.push("stop ends a follow and shuts off its light");
                        of.withdrawn = None;
                        of.commanded = Commanded::Doubt;
                    }
                    if of.commanded != Commanded::Off {
                        self.used.push("stop shut off light");
                        if of.commanded == Commanded::On(Owner::Call) {
                            self.used.push("stop shut off light of a call");
                        }
                        if of.kept[1 - crd].is_some() {
                            self.used.push("two hold one light");
                        }
                        // What another FIFO's Stop shut off stays its own.
                        of.kept[crd].get_or_insert(fifo);
                    }
                }
                // It braked for a cause: whether that keeps dark what a call has lit since is open.
                Why::Stopped if mapped && !by_abort && matches!(of.commanded, Commanded::On(_)) => {
                    of.commanded = Commanded::Doubt
                }
                Why::Stopped => {}
                _ if stopped && mapped && of.kept[crd].is_none_or(|kept| kept == fifo) => of.off(),
                _ => match of.commanded {
                    Commanded::Off => {}
                    // Light that another FIFO's Stop shut off returns with that FIFO.
                    _ if of.kept[crd].is_some_and(|kept| kept != fifo) => {}
                    Commanded::On(Owner::Crd(owner)) if owner == crd => {
                        self.used.push("the end of a path shut off its light");
                        of.off();
                    }
                    Commanded::On(_) if follows => {
                        self.used.push("the end of a path shut off light that followed it");
                        of.off();
                    }
                    Commanded::On(Owner::Open(owners)) if owners & set(crd) != 0 => of.commanded = Commanded::Doubt,
                    _ => {}
                },
            }
        }
    }
}
