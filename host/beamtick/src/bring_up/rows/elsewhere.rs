//! Rows that another run measures than that of the bring-up image: with the board's own image, or
//! with a hand. Before it each says which option does.
use super::{Row, Verdict, all_parts};
use crate::bring_up::answers::CALLS;
use crate::bring_up::lines::Figures;

pub const ROWS: &[Row] = &[
    Row {
        what: "the link's stream beside all others",
        assumptions: &[16],
        judge: stream,
        remedy: "compare TRBUFF of DMA1_S2CR with RM0433 15.5.5 and ES0392 2.8; if it is set, give the link a stream of DMA2, `open` in hal/src/stm32h743/uart.rs",
    },
    Row {
        what: "USB of the Nucleo answers",
        assumptions: &[27],
        judge: nucleo,
        remedy: "is the port's name right? If there is no device at CN13: compare GCCFG.PWRDWN and VBDEN, GUSBCFG.PHYSEL and FDMOD with RM0433 57, `open` in hal/src/stm32h743/usb.rs",
    },
    Row {
        what: "the module's crystal starts",
        assumptions: &[28],
        judge: crystal,
        remedy: "compare RCC_CR.HSEBYP with RM0433 8.5.1, the crystal's load with AN2867; `Source` in hal/src/stm32h743/wiring.rs and hal/src/stm32h743/boards/h743vi_module",
    },
    Row {
        what: "USB of the module answers without VBUS",
        assumptions: &[29],
        judge: module,
        remedy: "compare GOTGCTL.BVALOEN and BVALOVAL with RM0433 57, `open` in hal/src/stm32h743/usb.rs; or lead the connector's 5 V to PA9",
    },
    Row {
        what: "endpoints of USB that are set again",
        assumptions: &[39],
        judge: endpoints,
        remedy: "set DOEPCTL.EPENA only after OUT_DONE of the packet before: `read` in hal/src/stm32h743/usb.rs",
    },
    Row {
        what: "the watchdog while a debugger halts the core",
        assumptions: &[8],
        judge: halt,
        remedy: "a debugger's halt resets the board: compare WDGLSD1 of DBGMCU_APB4FZ1 with RM0433 60.5.8, `freeze_watchdog_in_debug` in \
            hal/src/stm32h743/clocks.rs",
    },
    Row {
        what: "the ST-LINK's clock without a host",
        assumptions: &[26],
        judge: unplug,
        remedy: "the board needs its host's cable: say so in docs/board-h743.md, or fit X3 and its solder bridges (UM2407)",
    },
    Row {
        what: "the clock's guard breaks the timers",
        assumptions: &[33],
        judge: clock,
        remedy: "light would go on for two ticks when the ST-LINK stops: clear MOE first in the NMI's handler (firmware/src/fault.rs), and say so in \
            docs/safety.md",
    },
    Row {
        what: "voltages of an external DAC",
        assumptions: &[38],
        judge: dac,
        remedy: "halve SCK (SPI_CFG1.MBR in hal/src/stm32h743/spi.rs), or raise `BETWEEN_NS` in hal/src/dac8563.rs; then the stages behind the DAC",
    },
];

/// What measures a row that has no figure.
fn option(words: &str, with: &str) -> Verdict {
    Verdict::NotMeasured(format!("`bring-up {words}` does, with {with}"))
}

const OWN: &str = "the board's own image";

/// A run that is shorter, in s, proves nothing: the errata name no condition.
const PROVES_S: i64 = 600;
/// Nor does one with fewer calls a second: its link was not kept busy. One that waits for its
/// adapter at each call, 16 ms as some do, has 60.
const BUSY_CALLS_PER_S: i64 = 20;

/// What a link did: over a UART or over USB, as is asked.
fn soak(figures: &Figures, by_usb: i64, with: &str) -> Verdict {
    let lines = figures.each::<5>("soak").unwrap_or_default();
    let Some([seconds, calls, lost, _, ended]) = lines.into_iter().find(|[.., is_usb, _]| *is_usb == by_usb) else {
        return option("--loads --soak 60", with);
    };
    let figure = format!("{seconds} s, {calls} calls, {lost} frames lost or damaged");
    match lost {
        _ if ended != 0 => Verdict::Fail(format!("the link ended (error {ended}) after {figure}")),
        0 if seconds < PROVES_S => Verdict::NotMeasured(format!("{figure}: less than {PROVES_S} s prove nothing")),
        0 if calls < seconds * BUSY_CALLS_PER_S => {
            Verdict::NotMeasured(format!("{figure}: less than {BUSY_CALLS_PER_S} calls a second prove nothing"))
        }
        lost => Verdict::of(lost == 0, figure),
    }
}

fn stream(figures: &Figures) -> Verdict {
    soak(figures, 0, OWN)
}

fn endpoints(figures: &Figures) -> Verdict {
    soak(figures, 1, "the board's own image, over CN13")
}

/// Of the line `answers` for this board: whether it was over USB, and calls that were answered.
fn answers(figures: &Figures, board: i64) -> Option<(bool, i64)> {
    let [of, is_usb, calls] = figures.only("answers")?;
    (of == board).then_some((is_usb == 1, calls))
}

fn answered(calls: i64) -> Verdict {
    let all = i64::from(CALLS);
    match calls {
        0 => Verdict::Fail("no answer".to_owned()),
        calls => {
            Verdict::of(calls == all, format!("{calls} calls answered") + if calls == all { "" } else { ", then none" })
        }
    }
}

fn nucleo(figures: &Figures) -> Verdict {
    match answers(figures, 0) {
        Some((true, calls)) => answered(calls),
        _ => option("--answers nucleo", "its own image, over CN13"),
    }
}

fn crystal(figures: &Figures) -> Verdict {
    match answers(figures, 1) {
        // Its USB may be what is silent.
        Some((true, 0)) => {
            Verdict::NotMeasured("no answer over USB: `bring-up --answers module` over the UART tells".into())
        }
        Some((_, calls)) => answered(calls),
        None => option("--answers module", "the module's own image"),
    }
}

fn module(figures: &Figures) -> Verdict {
    match answers(figures, 1) {
        Some((true, calls)) => answered(calls),
        _ => option("--answers module", "the module's own image, over its USB"),
    }
}

/// The watchdog has ended the run before (GetFault).
const BY_WATCHDOG: i64 = 4;
/// For so long the core stands at least, in ms.
const STANDS_MS: i64 = 500;

fn halt(figures: &Figures) -> Verdict {
    let Some([passed, advanced, fault]) = figures.only("halt") else { return option("--hands halt", OWN) };
    if advanced < 0 || fault == BY_WATCHDOG {
        return Verdict::Fail("the chip was reset".to_owned());
    }
    if passed - advanced < STANDS_MS {
        return Verdict::NotMeasured(format!(
            "the core did not stand: `bring-up --hands halt` saw it go on for {advanced} ms"
        ));
    }
    Verdict::Pass(format!("it stood for {:.1} s and went on", (passed - advanced) as f64 / 1e3))
}

/// For so long the cable is out at least, in ms.
const UNPLUGGED_MS: i64 = 10_000;

/// The cable's own time decides, and the clock is compared over all of the dialogue: what it lost
/// meanwhile, it lost while the cable was out.
fn unplug(figures: &Figures) -> Verdict {
    let Some([passed, advanced, fault, out]) = figures.only("unplug") else { return option("--hands unplug", OWN) };
    let seconds = |ms: i64| format!("{}.{} s", ms / 1000, ms % 1000 / 100);
    if out == 0 {
        return Verdict::NotMeasured(
            "`bring-up --hands unplug` opened its port all the same: the cable was not out".to_owned(),
        );
    }
    if advanced < 0 {
        return Verdict::Fail("the board was reset or had no supply".to_owned());
    }
    if fault != 0 {
        return Verdict::Fail(format!("fault {fault}: `beamtick info` names it"));
    }
    // The host's clock and the delays of two calls.
    let off = advanced - passed;
    if off.abs() > 1000 + passed / 100 {
        let [advanced, passed, out] = [advanced, passed, out].map(seconds);
        return Verdict::Fail(format!("the board's clock went on for {advanced} of {passed}; CN1 was out for {out}"));
    }
    if out < UNPLUGGED_MS {
        return Verdict::NotMeasured(format!(
            "`bring-up --hands unplug` saw CN1 out for {}: leave it out for {} or more",
            seconds(out),
            seconds(UNPLUGGED_MS)
        ));
    }
    Verdict::Pass(format!("CN1 was out for {}, and the board's clock went on", seconds(out)))
}

fn clock(figures: &Figures) -> Verdict {
    let Some([lit @ .., one, fifteen, eight]) = figures.only::<6>("clock-lost") else {
        return option("--hands clock", "the bring-up image and jumper 6");
    };
    if lit != [1; 3] {
        return Verdict::NotMeasured("there was no light: `bring-up --hands clock` wants jumper 6".to_owned());
    }
    let figure = format!("MOE of TIM1 {one}, TIM15 {fifteen}, TIM8 {eight} in the first instructions after it");
    Verdict::of([one, fifteen, eight] == [0; 3], figure)
}

/// A voltage may be off by so much, in mV: 1 % of 10 V, of the DAC's stage and the meter.
const OFF_MV: i64 = 100;
/// Voltages at each of two outputs: zero, half and full scale show offset, gain and a code that is
/// shifted by a bit.
const VOLTAGES_MV: [i64; 3] = [0, 5000, 10_000];

fn dac(figures: &Figures) -> Verdict {
    let Some(lines) = figures.each::<3>("dac") else {
        return option("--hands dac", "the image for an external DAC");
    };
    let volts = |mv: i64| mv as f64 / 1e3;
    let wrong = lines.iter().filter(|[_, set, is]| (set - is).abs() > OFF_MV);
    let wrong =
        wrong.map(|[output, set, is]| format!("output {output}: {} V for {} V", volts(*is), volts(*set))).collect();
    let asked = [1, 2].into_iter().flat_map(|output| VOLTAGES_MV.map(|mv| (output, mv)));
    let is_missing = |(output, mv): &(i64, i64)| !lines.iter().any(|line| line[..2] == [*output, *mv]);
    let missing = asked.filter(is_missing).map(|(output, mv)| {
        (format!("output {output}, {} V", volts(mv)), Verdict::NotMeasured("`bring-up --hands dac` asks for it".into()))
    });
    all_parts(wrong, &format!("{} voltages within {OFF_MV} mV", lines.len()), missing.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, lines: &[&[i64]]) -> Figures {
        let mut figures = Figures::default();
        lines.iter().for_each(|line| figures.add(name, line.to_vec()));
        figures
    }

    /// Voltages that nobody has measured are no good ones; a wrong one fails all the same.
    #[test]
    fn a_dac_passes_with_all_its_voltages_only() {
        let all: [&[i64]; 6] =
            [&[1, 0, 9], &[1, 5000, 4900], &[1, 10_000, 10_100], &[2, 0, -9], &[2, 5000, 5000], &[2, 10_000, 9900]];
        assert_eq!(dac(&of("dac", &all)), Verdict::Pass("6 voltages within 100 mV".into()));
        let why = "output 2, 10 V: `bring-up --hands dac` asks for it; measured: 5 voltages within 100 mV";
        assert_eq!(dac(&of("dac", &all[..5])), Verdict::NotMeasured(why.into()));
        // One that is measured twice is no other one.
        assert!(matches!(dac(&of("dac", &[all[0]; 6])), Verdict::NotMeasured(_)));
        let wrong = dac(&of("dac", &[&[1, 5000, 4899]]));
        assert_eq!(wrong, Verdict::Fail("output 1: 4.899 V for 5 V".into()));
    }

    /// A crystal that stops, or a link that does, is no good one.
    #[test]
    fn a_board_that_answers_for_a_while_fails() {
        let of = |calls| crystal(&of("answers", &[&[1, 0, calls]]));
        assert_eq!(of(100), Verdict::Pass("100 calls answered".into()));
        assert_eq!(of(99), Verdict::Fail("99 calls answered, then none".into()));
    }

    /// A soak that is short, or of few calls, proves nothing, unless it has lost frames.
    #[test]
    fn a_soak_passes_if_it_was_long_and_busy() {
        let of = |seconds, calls, lost| stream(&of("soak", &[&[seconds, calls, lost, 0, 0]]));
        assert_eq!(of(600, 12_000, 0), Verdict::Pass("600 s, 12000 calls, 0 frames lost or damaged".into()));
        let short = "599 s, 90000 calls, 0 frames lost or damaged: less than 600 s prove nothing";
        assert_eq!(of(599, 90_000, 0), Verdict::NotMeasured(short.into()));
        let idle = "600 s, 11999 calls, 0 frames lost or damaged: less than 20 calls a second prove nothing";
        assert_eq!(of(600, 11_999, 0), Verdict::NotMeasured(idle.into()));
        assert_eq!(of(1, 2, 1), Verdict::Fail("1 s, 2 calls, 1 frames lost or damaged".into()));
    }
}
