//! Analog inputs: ADC3 converts both continuously (RM0433 25).
//!
//! In: voltages at PC3_C and PC2_C, after the divider of docs/board-h743.md. Out: codes,
//! −32768…32767 for −12.5…12.5 V at the terminal, not older than 10 µs. Owns ADC3. Its offset and
//! linearity are calibrated in the ticks after power-on, which takes 10 ms; until then an input is
//! 0. Fails never; an input that does not become ready stays at 0.
//!
//! A sequence is a regular conversion and an injected one after it (JAUTO), each with a data
//! register of its own, so the tick only reads: 16 MHz, (64.5 + 8.5) cycles a conversion, 9.1 µs a
//! sequence.
use stm32_metapac::adc::regs::Cr;
use stm32_metapac::adc::vals::{Adcaldif, Boost, Ovrmod, Pcsel, Res, SampleTime};
use stm32_metapac::adccommon::vals::{Ckmode, Presc};
use stm32_metapac::rcc::vals::Adcsel;
use stm32_metapac::{ADC3, ADC3_COMMON, RCC};

/// Inputs.
pub const INPUTS: usize = 2;

/// Their channels: PC3_C (A2), PC2_C (A4).
const CHANNELS: [usize; INPUTS] = [1, 0];

/// What the start-up of the converter waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AdcStage {
    /// Its regulator, for 10 µs: the first tick comes later.
    Regulator,
    Calibration,
    Ready,
    FirstSequence,
    /// Nothing.
    Runs,
}

/// ADC3.
#[derive(Debug)]
pub struct Adc {
    stage: AdcStage,
}

/// Writes CR with ADEN and ADSTART at 0: written back as 1 they would be requested again.
fn command(change: impl FnOnce(&mut Cr)) {
    ADC3.cr().modify(|w| {
        w.set_aden(false);
        w.set_adstart(false);
        change(w);
    });
}

impl Adc {
    /// Powers it up.
    ///
    /// # Safety
    /// At most once, a tick at least before the first [`Adc::advance`].
    pub unsafe fn open() -> Adc {
        // per_ck is the HSI, 64 MHz, as after reset (RM0433 8.7.19).
        RCC.d3ccipr().modify(|w| w.set_adcsel(Adcsel::PER));
        RCC.ahb4enr().modify(|w| w.set_adc3en(true));
        // Read back, so that the clock is on (RM0433 8.5.8).
        RCC.ahb4enr().read();
        // Divided by 2 here, and by 2 again in the converter (revision V).
        ADC3_COMMON.ccr().write(|w| {
            w.set_ckmode(Ckmode::ASYNCHRONOUS);
            w.set_presc(Presc::DIV2);
        });
        ADC3.cr().modify(|w| {
            w.set_deeppwd(false);
            w.set_boost(Boost::LT25);
        });
        ADC3.cr().modify(|w| w.set_advregen(true));
        Adc { stage: AdcStage::Regulator }
    }

    /// A tick begins: starts the next stage once the last one is ready.
    pub fn advance(&mut self) {
        self.stage = match self.stage {
            AdcStage::Runs => return,
            AdcStage::Regulator => {
                command(|w| {
                    w.set_adcaldif(Adcaldif::SINGLE_ENDED);
                    w.set_adcallin(true);
                    w.set_adcal(true);
                });
                AdcStage::Calibration
            }
            AdcStage::Calibration if !ADC3.cr().read().adcal() => {
                arrange();
                ADC3.isr().write(|w| w.set_adrdy(true));
                command(|w| w.set_aden(true));
                AdcStage::Ready
            }
            AdcStage::Ready if ADC3.isr().read().adrdy() => {
                command(|w| w.set_adstart(true));
                AdcStage::FirstSequence
            }
            // Within four of its clocks after a calibration the chip clears ADEN (RM0433 25.4.9):
            // set it again.
            AdcStage::Ready => {
                command(|w| w.set_aden(true));
                AdcStage::Ready
            }
            AdcStage::FirstSequence if ADC3.isr().read().jeos() => AdcStage::Runs,
            waits => waits,
        };
    }

    /// The code of an input, from 0.
    pub fn code(&self, input: usize) -> i16 {
        if self.stage != AdcStage::Runs {
            return 0;
        }
        let raw = match input {
            0 => ADC3.dr().read().0,
            1 => ADC3.jdr(0).read().0,
            _ => return 0,
        };
        (raw as u16 ^ 0x8000).cast_signed()
    }
}

/// What is converted, and how.
fn arrange() {
    ADC3.cfgr().write(|w| {
        w.set_res(Res::BITS16);
        w.set_cont(true);
        w.set_jauto(true);
        w.set_jqdis(true);
        // The newest one counts.
        w.set_ovrmod(Ovrmod::OVERWRITE);
    });
    let [regular, injected] = CHANNELS;
    ADC3.pcsel().write(|w| CHANNELS.iter().for_each(|channel| w.set_pcsel(*channel, Pcsel::PRESELECTED)));
    ADC3.smpr(0).write(|w| CHANNELS.iter().for_each(|channel| w.set_smp(*channel, SampleTime::CYCLES64_5)));
    ADC3.sqr1().write(|w| w.set_sq(0, regular as u8));
    ADC3.jsqr().write(|w| w.set_jsq(0, injected as u8));
}
