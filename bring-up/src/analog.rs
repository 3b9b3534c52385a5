//! Analog outputs read back by analog inputs, through jumpers 7 and 8.
//!
//! In: a bench. Out: lines `loop OUTPUT CODE FIRST SETTLED`, in the tick's codes: what the input
//! says in the second tick after the step, and 12 ticks later. Owns nothing. The converter has been
//! calibrated in the ticks before.
use crate::bench::Bench;
use crate::pause;
use crate::report::Report;
use stm32_metapac::ADC3;
use stm32_metapac::adc::regs::Cr;
use stm32_metapac::adc::vals::Adcaldif;

/// Longer than the calibration of linearity, 165,010 clocks of 16 MHz (RM0433 25.4.8), in cycles of
/// the core.
const LINEARITY_CYCLES: u32 = 7_200_000;
/// Longer than the converter takes to start and to stop.
const STARTS_CYCLES: u32 = 48_000;
/// Looks at the short calibration, 1,280 clocks.
const LOOKS: u32 = 100_000;
/// Ticks in which a voltage settles.
const SETTLE: u32 = 12;
/// Codes of the output that the buffered pin reaches: 20 to 80 % of the reference.
const CODES: [i16; 4] = [-19_000, 19_000, -8_000, 8_000];

/// Writes CR with what is requested by a 1 at 0.
fn command(change: impl FnOnce(&mut Cr)) {
    ADC3.cr().modify(|w| {
        w.set_aden(false);
        change(w);
    });
}

/// Starts a calibration, of offset or of linearity too.
fn calibrate(linearity: bool) {
    command(|w| {
        w.set_adcaldif(Adcaldif::SINGLE_ENDED);
        w.set_adcallin(linearity);
        w.set_adcal(true);
    });
}

/// Whether the converter keeps ADEN that is set right after a calibration, before four of its
/// clocks. It is off again then, and the ticks begin with it as they always do.
pub fn enable_at_once(report: &mut Report) {
    calibrate(true);
    pause::cycles(LINEARITY_CYCLES);
    // The short one, watched: ADEN follows within a few cycles of the core.
    calibrate(false);
    for _ in 0..LOOKS {
        if !ADC3.cr().read().adcal() {
            break;
        }
    }
    command(|w| w.set_aden(true));
    // Ten of its clocks of 16 MHz, and some.
    cortex_m::asm::delay(480);
    let is_kept = ADC3.cr().read().aden();
    pause::cycles(STARTS_CYCLES);
    if is_kept {
        command(|w| w.set_addis(true));
        pause::cycles(STARTS_CYCLES);
    }
    report.line("aden", &[is_kept.into()]);
}

/// Both loops.
pub fn report_to(bench: &mut Bench, report: &mut Report) {
    for output in 0..2 {
        for code in CODES {
            bench.volts(output, code);
            // Out at the second tick, sampled until the fourth.
            bench.ticks(4);
            let first = bench.analog(output);
            bench.ticks(SETTLE);
            report.line("loop", &[output as i64 + 1, code.into(), first, bench.analog(output)]);
        }
        bench.volts(output, 0);
        bench.ticks(2);
    }
}
