//! What makes everything dark at once: SPEC 9.
//!
//! In: a cause, a lost link, an abort or a new session. Out: the state after it.
use super::super::gate::Level;
use super::Judge;
use super::state::{Channel, Commanded, Lost, Maybe, members, set};

impl Judge {
    pub(super) fn fault(&mut self, hit: impl Fn(&Channel) -> bool) {
        self.used.push("cause of SPEC 9");
        let now = self.now;
        for of in self.channels.iter_mut().filter(|of| hit(of)) {
            of.cut(now);
            // A clear that acts late may come after it.
            let fault = if of.clears_until > now.0 { Maybe::Doubt } else { Maybe::Yes };
            (of.fault, of.fault_since) = (fault, now.0);
        }
    }

    pub(super) fn link_loss(&mut self) {
        let (now, running) = (self.now, self.runs());
        let fifos = self.crds.map(|crd| crd.fifo);
        for of in &mut self.channels {
            let owner = match of.commanded {
                Commanded::On(owner) if of.level == Level::On => Some(owner),
                _ => None,
            };
            let open = of.commanded == Commanded::Doubt;
            let crds = running & of.map;
            let is_lit = of.level == Level::On;
            let lights = members(crds).any(|crd| self.crds[crd].dead == Maybe::No);
            if !is_lit && !open && !lights {
                // Nothing that a loss would take, but of what went dark just now, or of a path
                // whose on entries are dead: whether it is a fault is open.
                of.perhaps_cut(now);
                continue;
            }
            if of.fault == Maybe::Yes {
                // It is dark already: what the first loss took waits for those that this one stops,
                // too.
                if let Some(lost) = &mut of.lost {
                    self.used.push("lost again");
                    lost.waits_for(crds, fifos);
                }
                continue;
            }
            let (kept, before) = (of.kept, of.lost);
            of.cut(now);
            if let Some(mut lost) = before {
                // Whether it was lost before is open, or it was cleared and did not go on yet.
                lost.waits_for(crds, fifos);
                lost.doubt = true;
                of.lost = Some(lost);
            }
            if crds != 0 && kept != [None; 2] {
                // Whether light that a Stop kept dark returns after it is open.
                let fifos = [0, 1].map(|crd| kept[crd].unwrap_or(fifos[crd]));
                let all = crds | members(3).filter(|crd| kept[*crd].is_some()).map(set).sum::<u8>();
                of.lost = Some(Lost { crds: all, fifos, owner: None, cleared: false, doubt: true });
            }
            (of.fault, of.fault_since) = (Maybe::Yes, now.0);
            if open && !lights {
                // Lit, or kept dark by a Stop that the loss does not concern.
                of.fault = Maybe::Doubt;
                of.commanded = Commanded::Doubt;
            }
            if crds != 0 && (is_lit || open) {
                self.used.push("lost link took light");
                let braked = members(crds).any(|crd| self.crds[crd].stopping);
                of.lost = Some(Lost { crds, fifos, owner, cleared: false, doubt: open || braked });
            }
        }
        for crd in members(running) {
            // It brakes for the lost link, whatever braked it before.
            self.crds[crd].stopping = false;
        }
    }

    /// An abort, or a new session.
    pub(super) fn abandon(&mut self, abort: bool) {
        let now = self.now;
        for of in &mut self.channels {
            of.cut(now);
            of.quiet = true;
            if !abort {
                (of.follow, of.follow_open) = (None, false);
            }
        }
        for crd in self.crds.iter_mut().filter(|crd| crd.runs) {
            crd.stopping &= !abort;
            crd.dead = Maybe::Yes;
            crd.aborted = match crd.aborted {
                Maybe::Yes => Maybe::Yes,
                _ if abort => Maybe::Yes,
                _ => Maybe::Doubt,
            };
        }
    }
}
