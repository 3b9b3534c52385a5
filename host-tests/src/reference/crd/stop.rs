//! Stops of a path, and how well its place is known after them.
//!
//! In: the path as it was shown at the tick before. Out: where it stands or brakes; a start that is
//! known too badly to be compared. Owns nothing.
use super::{Crd, Entry, Rest};
use crate::path_model::speed::limits;

impl Crd {
    /// At once, where it was shown at the tick before. Outputs that it has reached since have been
    /// set, and are not set again.
    pub fn halt(&mut self, published: &Crd) {
        if !self.runs {
            return;
        }
        let (was, of) = (&published.fifos[self.fifo], &mut self.fifos[self.fifo]);
        of.reported = of.reported.max(of.next);
        // What stood at that tick's own instant had been reached.
        let passed = |entry: &&Entry| entry.takes_no_time() || **entry == Entry::Delay(0.0);
        let outputs = was.entries[was.next..].iter().take_while(passed).count();
        let next = was.next + outputs;
        let moves = |entry: &Entry| matches!(entry, Entry::Move(_) | Entry::Gear(..) | Entry::Laser(..));
        if of.next != was.next
            && (!was.gears.is_empty() || of.entries[was.next..=of.next.min(of.entries.len() - 1)].iter().any(moves))
        {
            self.unsaid = Some("an abrupt Stop just after an entry of a laser or of an axis");
        }
        if of.next != next {
            // A delay that has ended since is over.
            let waited = matches!(was.entries.get(next), Some(Entry::Delay(_)));
            (of.next, of.done) = if waited { (next + 1, 0.0) } else { (next, was.done) };
        } else if matches!(of.entries[of.next], Entry::Motion(..)) {
            of.done = was.done;
        }
        if let Some(Entry::Motion(geometry, rates, ..)) = of.entries.get(of.next) {
            // From where it is shown, to 2⁻²² pulse, it takes so much more or less to the end.
            let left = (geometry.length() - of.done).abs().max(1e-9);
            let blur = 2f64.powi(-23) / (left * rates.acc).sqrt();
            self.blur = self.blur.max(blur);
            if blur > 1e-6 {
                self.unsaid = Some("an abrupt Stop just before the end of a motion");
            }
        }
        self.resumed = true;
        self.held = self.speed.max(published.speed);
        self.position = published.position;
        self.knots.clear();
        self.is_straight = true;
        self.come_to_standstill(Rest::Stopped);
    }

    /// A smooth Stop, at the instant up to which it has run.
    pub fn brake(&mut self) {
        if self.runs && self.speed <= 0.0 {
            self.come_to_standstill(Rest::Stopped);
        } else if self.runs {
            if !self.brakes {
                self.held = self.speed;
            }
            self.brakes = true;
            self.plan = None;
        }
    }

    /// Its place is known to `apart` pulses at a start, and so is the length of a motion that
    /// begins there.
    pub fn blur_length(&mut self, apart: f64) {
        let (Some(set), of) = (&self.set, &self.fifos[self.fifo]) else { return };
        let Some(index) = of.entries[of.next..].iter().position(|entry| matches!(entry, Entry::Motion(..))) else {
            return;
        };
        let Entry::Motion(geometry, rates, ..) = &of.entries[of.next + index] else { return };
        let limits = limits(&set.frame, rates, self.rate);
        if index == 0 && of.done > 0.0 {
            // A Stop found it there 5 ns earlier or later for every wait, and as it sped up, at
            // another speed, too.
            let steady = self.held >= limits.speed * (1.0 - 1e-9);
            let longer = if steady { 1.0 } else { 1.0 + limits.acc / self.stop_dec };
            let apart = 5e-6 * f64::from(self.waited) * self.held * longer;
            let top = limits.speed.min(((geometry.length() - of.done) * limits.acc).sqrt());
            if apart > 5.001e-6 * top {
                self.unsaid =
                    Some("a path that was stopped after a wait for an axis, and goes on for a short distance");
            }
            return;
        }
        if apart == 0.0 {
            return;
        }
        // Its greatest speed takes so much longer for it; the way from there to the end follows.
        let top = limits.speed.min((geometry.length() * limits.acc).sqrt());
        self.blur += 2.0 * apart / top.max(1e-9);
        if self.blur > 1e-6 {
            self.unsaid = Some("a path that begins where an axis is not known well");
        }
    }
}
