//! What calls do to light.
//!
//! In: a call that was made, with what was answered. Out: the state after it, and an answer that
//! contradicts the rules.
use super::super::Ns;
use super::super::gate::{Gate, Level};
use super::state::{Commanded, Lost, Maybe, Owner, members, set};
use super::{Judge, SAME_INSTANT_NS};

impl Judge {
    pub(super) fn answered(&mut self, call: &str, code: i16, refused: Maybe) {
        let good = match refused {
            Maybe::Yes => code == 1,
            Maybe::No => code == 0,
            Maybe::Doubt => code == 0 || code == 1,
        };
        if !good {
            self.wrong.push(format!("at {}: {call} was answered {code}; refused ought to be: {refused:?}", self.now.0));
        }
    }

    pub(super) fn on(&mut self, channel: usize, code: i16, sure: bool) {
        let now = self.now.0;
        let aborted = self.crds.iter().filter(|crd| crd.runs).map(|crd| crd.aborted);
        let jog = if self.jog_aborted { Maybe::Yes } else { Maybe::No };
        let aborted = aborted.fold(jog, |all, one| match (all, one) {
            (Maybe::Yes, _) | (_, Maybe::Yes) => Maybe::Yes,
            (Maybe::Doubt, _) | (_, Maybe::Doubt) => Maybe::Doubt,
            _ => Maybe::No,
        });
        let of = &self.channels[channel];
        let refused = match (of.fault, aborted) {
            _ if !sure => Maybe::Doubt,
            _ if (now - of.fault_since).abs() <= 2 * self.near || (now - self.rested).abs() <= 2 * self.near => {
                Maybe::Doubt
            }
            _ if !of.connector => Maybe::Yes,
            (Maybe::Yes, _) | (_, Maybe::Yes) => Maybe::Yes,
            (Maybe::Doubt, _) | (_, Maybe::Doubt) => Maybe::Doubt,
            _ => Maybe::No,
        };
        self.answered(&format!("on of channel {channel}"), code, refused);
        self.used.push(match refused {
            Maybe::Yes => "on refused",
            _ => "on done",
        });
        let of = &mut self.channels[channel];
        if code != 0 {
            if of.fault == Maybe::Doubt && of.connector && aborted == Maybe::No && sure {
                of.fault = Maybe::Yes;
            }
            return;
        }
        of.mark_changed();
        if of.fault == Maybe::Yes {
            // It was answered before the cause was sampled.
            return;
        }
        if of.fault == Maybe::Doubt && !sure {
            of.off();
            of.commanded = Commanded::Doubt;
            of.veto = if of.veto == Maybe::No { Maybe::No } else { Maybe::Doubt };
            return;
        }
        of.fault = Maybe::No;
        of.veto = Maybe::No;
        of.lost = None;
        if (now - self.rested).abs() <= 2 * self.near || !sure && aborted != Maybe::No {
            // Perhaps it waited for the abort's end.
            of.off();
            of.commanded = Commanded::Doubt;
            return;
        }
        if of.kept.iter().any(Option::is_some) {
            self.used.push("on instead of kept light");
            (of.kept, of.kept_doubt) = ([None; 2], false);
            of.commanded = Commanded::On(Owner::Call);
            return;
        }
        of.commanded = match of.commanded {
            Commanded::On(Owner::Crd(crd)) if of.level != Level::On => Commanded::On(Owner::Open(set(crd))),
            Commanded::On(owner) => {
                if owner != Owner::Call {
                    self.used.push("on in vain, a path's light is on");
                }
                Commanded::On(owner)
            }
            // Lit for sure; whose it is, is open.
            Commanded::Doubt => Commanded::On(Owner::Open(3)),
            Commanded::Off => Commanded::On(Owner::Call),
        };
    }

    /// The follow is over, whatever ended it: light that waited for it is withdrawn.
    pub(super) fn end_follow(&mut self, channel: usize) {
        let open = std::mem::take(&mut self.channels[channel].follow_open);
        let follow = self.channels[channel].follow.take();
        let of = &mut self.channels[channel];
        if open {
            // Whether light waited for it is open, too.
            of.kept_doubt |= of.kept.iter().any(Option::is_some);
            of.commanded = if of.commanded == Commanded::Off { Commanded::Off } else { Commanded::Doubt };
            return;
        }
        let Some(crd) = follow else { return };
        let waits = !self.crds[crd].runs;
        if !waits || of.kept[crd].is_some() {
            // Light that a Stop keeps dark returns without the follow.
        } else if of.kept.iter().any(Option::is_some) {
            of.kept_doubt = true;
        } else if matches!(of.commanded, Commanded::On(_)) {
            self.used.push("follow ended before its start");
            of.off();
        }
    }

    pub(super) fn map(&mut self, channel: usize, map: u8, code: i16, sure: bool) {
        let of = &self.channels[channel];
        let both = of.map | map;
        let lit_by = |crd: usize| both & set(crd) != 0;
        let refused = match of.commanded {
            _ if !sure => Maybe::Doubt,
            _ if both & self.runs() != 0 => Maybe::Yes,
            Commanded::On(Owner::Crd(crd)) if lit_by(crd) => Maybe::Yes,
            Commanded::Doubt | Commanded::On(Owner::Open(_)) => Maybe::Doubt,
            _ => match of.lost {
                Some(Lost { owner: Some(Owner::Crd(crd)), doubt: false, .. }) if lit_by(crd) => Maybe::Yes,
                Some(_) => Maybe::Doubt,
                None => Maybe::No,
            },
        };
        self.answered(&format!("the map {map} of channel {channel}"), code, refused);
        self.used.push(match code {
            0 => "map done",
            _ if both & self.runs() == 0 => "map refused for light",
            _ => "map refused",
        });
        if code == 0 {
            let of = &mut self.channels[channel];
            of.mark_changed();
            of.old_map = (of.map, self.now.1 + self.near);
            of.map = map;
            if of.kept.iter().any(Option::is_some) {
                of.kept_doubt = true;
            }
            if of.follow.is_some_and(|crd| map & set(crd) == 0) {
                self.used.push("map ends a follow");
                self.end_follow(channel);
            }
        }
    }

    pub(super) fn other_delays(&mut self, channel: usize, on: Ns, off: Ns) {
        let (lo, hi) = self.now;
        let of = &mut self.channels[channel];
        of.mark_changed();
        of.delays = (on, off);
        let mut open = None;
        for gate in of.verdict.gates.iter_mut().rev().take_while(|gate| gate.hi + SAME_INSTANT_NS >= lo) {
            gate.delays = (gate.delays.0.min(on), gate.delays.1.max(off));
            open = Some(gate.lo);
        }
        if let Some(from) = open {
            // Which delays the command of this instant has is open.
            of.verdict.gates.push(Gate {
                lo: from.min(hi),
                hi: Ns::MAX / 4,
                level: Level::Off,
                cut: true,
                delays: of.delays,
            });
            of.commanded = if of.level == Level::Off { of.commanded } else { Commanded::Doubt };
        }
    }

    pub(super) fn crd_clear(&mut self, crd: usize, fifo: usize) {
        self.crds[crd].resumable[fifo] = false;
        for of in &mut self.channels {
            if of.kept[crd] == Some(fifo) {
                self.used.push("cleared instead of going on");
                of.off();
            }
            if of.lost.is_some_and(|lost| lost.crds & set(crd) != 0 && lost.fifos[crd] == fifo) {
                of.lost = None;
            }
        }
    }

    pub(super) fn start(&mut self, crd: usize, fifo: usize) {
        let of = &mut self.crds[crd];
        if of.runs {
            // It continues instead of coming to standstill.
            of.stopping = false;
            of.dead = if of.dead == Maybe::No { Maybe::No } else { Maybe::Doubt };
            of.aborted = if of.aborted == Maybe::No { Maybe::No } else { Maybe::Doubt };
            self.used.push("start while it brakes");
            return;
        }
        let resumes = of.resumable[fifo];
        of.resumable[fifo] = false;
        (of.runs, of.fifo, of.stopping, of.dead, of.aborted) = (true, fifo, false, Maybe::No, Maybe::No);
        for of in &mut self.channels {
            match of.kept[crd] {
                Some(kept) if kept == fifo && resumes => {
                    of.kept[crd] = None;
                    self.used.push("light came back with a start");
                    if of.kept_doubt && of.kept == [None; 2] {
                        of.kept_doubt = false;
                        of.commanded = Commanded::Doubt;
                    }
                }
                Some(kept) if kept == fifo => of.off(),
                // Whose Stop keeps it dark is open.
                Some(_) if of.commanded == Commanded::Doubt => of.kept[crd] = None,
                Some(_) => self.used.push("another FIFO in between"),
                None => {}
            }
            let Some(lost) = of.lost.as_mut().filter(|lost| lost.crds & set(crd) != 0 && lost.fifos[crd] == fifo)
            else {
                continue;
            };
            if !lost.cleared {
                self.used.push("start before the lost link was cleared");
                of.lost = None;
                continue;
            }
            lost.doubt |= !resumes;
            lost.crds &= !set(crd);
            if lost.crds == 0 {
                self.used.push("light came back after a lost link");
                of.commanded = match lost.owner.filter(|_| !lost.doubt) {
                    Some(owner) => Commanded::On(owner),
                    None => Commanded::Doubt,
                };
                of.lost = None;
            }
        }
    }

    pub(super) fn stop(&mut self, crds: u8, ends_follow: u8) {
        for channel in 0..2 {
            if self.channels[channel].follow.is_some_and(|crd| ends_follow & set(crd) != 0) {
                self.used.push("stop ends a follow");
                let waited = self.channels[channel].commanded != Commanded::Off;
                self.end_follow(channel);
                let of = &mut self.channels[channel];
                if waited && of.commanded == Commanded::Off && crds & of.map != 0 {
                    of.withdrawn = Some(self.now.1);
                }
            }
        }
        let running = crds & self.runs();
        for crd in members(running) {
            self.crds[crd].stopping = true;
        }
        for of in &mut self.channels {
            let named = crds & of.map;
            if named & running == 0 && named & self.settings.set_up != 0 {
                if of.commanded != Commanded::Off {
                    self.used.push("stop at rest shut off light");
                }
                of.off();
            }
        }
    }
}
