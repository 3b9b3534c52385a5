//! Analog outputs, one a laser channel: the chip's DAC1 (RM0433 26), or a DAC8563 on SPI3, as
//! [`settings`](super::settings) say.
//!
//! In: codes, −32768…32767 for −10…10 V after the output stage (docs/board-h743.md), and their
//! instants. Out: voltages, which change at the beginning of a tick, one tick after the plan, as
//! the steps do. A code planned for the beginning of a tick comes with the tick after it. A code
//! planned for a later instant comes one tick later still. The safe state comes at once. Owns DAC1
//! or SPI3. Before [`Analog::open`] and after [`safe_state`] the chip's DAC drives nothing. An
//! external one keeps its voltage through a reset: so it gets 0 V first of all
//! ([`zero_external`]). Fails: a frame that an external DAC did not get is sent again in the next
//! tick.
use super::settings::EXTERNAL_DAC;
use super::{pins, spi};
use crate::dac8563::Dac8563;
use servo::laser::{Action, LaserPlan};
use stm32_metapac::{DAC1, RCC};

/// Outputs.
pub const OUTPUTS: usize = 2;

/// A code, and whether it is a laser's.
#[derive(Debug, Clone, Copy, Default)]
struct DacCode {
    code: i16,
    of_laser: bool,
}

/// An output.
#[derive(Debug, Clone, Copy, Default)]
struct Output {
    /// The code in force.
    in_force: DacCode,
    /// Codes of the next tick, and of the two after it.
    queued: [Option<DacCode>; 3],
    /// The last code of a laser.
    of_laser: i16,
}

impl Output {
    /// Queues a code from `at` ns after the next tick on, by the plan.
    fn plan(&mut self, at: u32, code: DacCode) {
        let [_, next, later] = &mut self.queued;
        *(if at == 0 { next } else { later }) = Some(code);
    }

    /// Whether a laser drives it, or is about to.
    fn is_lasers(&self) -> bool {
        let in_force = self.in_force.of_laser && self.in_force.code != 0;
        in_force || self.of_laser != 0 || self.queued.iter().flatten().any(|queued| queued.of_laser)
    }
}

/// The external DAC, as [`zero_external`] has opened it.
type External = Dac8563<spi::Bus, spi::Select, spi::Pause>;

fn external() -> External {
    let (bus, select, pause) = spi::again();
    Dac8563 { bus, select, pause }
}

/// Outputs 0 V on both outputs of an external DAC; a frame under way is dropped. A failure cannot
/// be reported here: its frame is sent a second time.
#[cold]
fn zero(mut dac: External) {
    spi::restart();
    for channel in 0..OUTPUTS as u8 {
        if dac.write(channel, 0).is_err() {
            spi::restart();
            let _ = dac.write(channel, 0);
        }
    }
}

/// An external DAC keeps its voltage through a reset of the chip: this ends it. Call it before
/// anything is waited for; the chip's own clock is enough.
///
/// # Safety
/// At most once, on the board's package, before anything else drives the DAC's pins.
pub unsafe fn zero_external() {
    if EXTERNAL_DAC {
        // SAFETY: the caller's promise.
        unsafe {
            pins::open_dac();
            spi::open();
        }
        zero(external());
    }
}

/// The outputs.
#[derive(Debug)]
pub struct Analog {
    outputs: [Output; OUTPUTS],
    external: Option<External>,
}

impl Analog {
    /// Takes the converter that is fitted; the chip's outputs 0 V, or nothing unless it `drives`.
    ///
    /// # Safety
    /// At most once, after [`zero_external`], with the pins of DAC1 as the reset has left them.
    pub unsafe fn open(drives: bool) -> Analog {
        let external = (EXTERNAL_DAC && drives).then(external);
        if !EXTERNAL_DAC {
            RCC.apb1lenr().modify(|w| w.set_dac12en(true));
            // Read back, so that the clock is on (RM0433 8.5.8).
            RCC.apb1lenr().read();
        }
        let mut analog = Analog { outputs: [Output::default(); OUTPUTS], external };
        if !EXTERNAL_DAC {
            (0..OUTPUTS).for_each(|channel| analog.put(channel, 0));
        }
        if drives && !EXTERNAL_DAC {
            // The values before the outputs: reading back takes the cycle that they need (RM0433
            // 26.4.5). Buffered to the pin, as `DAC_MCR` is after reset.
            DAC1.dor(OUTPUTS - 1).read();
            DAC1.cr().modify(|w| (0..OUTPUTS).for_each(|channel| w.set_en(channel, true)));
        }
        analog
    }

    /// Outputs a code now.
    #[cold]
    #[inline(never)]
    fn put(&mut self, channel: usize, code: i16) {
        match &mut self.external {
            Some(dac) => {
                if dac.write(channel as u8, code).is_err()
                    && let Some(output) = self.outputs.get_mut(channel)
                {
                    spi::restart();
                    // Again in the next tick.
                    let Output { in_force, queued: [next, ..], .. } = output;
                    next.get_or_insert(DacCode { code, ..*in_force });
                    in_force.code = !code;
                }
            }
            // On another package than the board's the external one has no pins.
            None if EXTERNAL_DAC => {}
            None => DAC1.dhr12r(channel).write(|w| w.set_dhr((code as u16 ^ 0x8000) >> 4)),
        }
    }

    /// A tick begins: what was planned for it is output.
    pub fn advance(&mut self) {
        for channel in 0..OUTPUTS {
            let Some(output) = self.outputs.get_mut(channel) else { continue };
            let [now, next, later] = output.queued;
            output.queued = [next, later, None];
            if let Some(now) = now {
                let before = core::mem::replace(&mut output.in_force, now);
                if before.code != now.code {
                    self.put(channel, now.code);
                }
            }
        }
    }

    /// Queues a code that is not a laser's, from `at` ns after the next tick on.
    pub fn plan(&mut self, at: u32, channel: usize, code: i16) {
        if let Some(output) = self.outputs.get_mut(channel) {
            output.plan(at, DacCode { code, of_laser: false });
        }
    }

    /// Queues the voltages of a laser channel's next tick.
    pub fn follow(&mut self, channel: usize, plan: &LaserPlan) {
        if plan.safe_state {
            self.safe_state(channel);
        }
        for (at, action) in plan.actions() {
            if let Action::Volts(code) = action
                && let Some(output) = self.outputs.get_mut(channel)
            {
                output.plan(*at, DacCode { code: *code, of_laser: true });
                output.of_laser = *code;
            }
        }
    }

    /// Outputs 0 V now, if a laser drives the output, and drops all queued codes.
    #[cold]
    #[inline(never)]
    fn safe_state(&mut self, channel: usize) {
        let Some(output) = self.outputs.get_mut(channel).filter(|output| output.is_lasers()) else { return };
        *output = Output::default();
        self.put(channel, 0);
    }
}

/// Before a reset: disables the chip's DAC, sets an external one to 0 V.
pub fn safe_state() {
    if EXTERNAL_DAC {
        // Off before start-up, and on another package than the board's.
        if RCC.apb1lenr().read().spi3en() {
            zero(external());
        }
    } else if RCC.apb1lenr().read().dac12en() {
        DAC1.cr().write(|_| {});
    }
}
