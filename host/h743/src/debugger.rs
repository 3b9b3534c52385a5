//! A debugger at the chip, which halts the core.
//!
//! In: a time. Out: a core that has stood for so long. Owns nothing. Fails never: a reset ends it.
use crate::machine::Machine;
use crate::time::Time;

impl Machine {
    /// A debugger halts the core for so long; everything else goes on, but what DBGMCU freezes. A
    /// reset ends it.
    pub fn halt(&mut self, time: Time) {
        if self.chip.bus.dbgmcu.freezes_watchdog() {
            self.chip.bus.watchdog.shift_by_freeze(time);
        }
        // The halt is over by then, as far as the next event goes.
        let chip = &mut self.chip;
        chip.bus.stir(chip.now, &mut chip.scs.exceptions);
        let end = self.chip.now.saturating_add(time);
        while self.chip.now < end {
            self.chip.now = self.chip.bus.next().min(end).max(self.chip.now);
            self.chip.settle();
            if let Some(cause) = self.asked_reset() {
                return self.reset(cause);
            }
        }
    }
}
