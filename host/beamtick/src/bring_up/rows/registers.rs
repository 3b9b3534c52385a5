//! Rows that registers alone decide.
use super::{Row, Verdict, all_of};
use crate::bring_up::lines::Figures;

/// MODER after a reset, ports A to G (11.4.1): analog, but PA13–PA15, PB3 and PB4 of the debug
/// port.
const MODES: [i64; 7] = [0xabff_ffff, 0xffff_febf, 0xffff_ffff, 0xffff_ffff, 0xffff_ffff, 0xffff_ffff, 0xffff_ffff];
/// PUPDR likewise.
const PULLS: [i64; 7] = [0x6400_0000, 0x0000_0100, 0, 0, 0, 0, 0];

pub const ROWS: &[Row] = &[
    Row {
        what: "revision of the chip",
        assumptions: &[6],
        judge: revision,
        remedy: "compare with DBGMCU_IDC in the chip's errata sheet (ES0392); `is_fit` in hal/src/stm32h743/clocks.rs decides",
    },
    Row {
        what: "package of the chip",
        assumptions: &[30],
        judge: package,
        remedy: "the image would drive no pin: compare SYSCFG_PKGR with RM0433 12.3.13, `Package` in hal/src/stm32h743/wiring.rs",
    },
    Row {
        what: "revision of the core",
        assumptions: &[17],
        judge: core,
        remedy: "read Arm's errata notice for this revision: before r1p1 BASEPRI needs a work-around in hal/src/mask.rs",
    },
    Row {
        what: "pins after a reset",
        assumptions: &[7],
        judge: pins,
        remedy: "do not connect a laser: find out which pin is driven, and move its function in hal/src/stm32h743/pins.rs",
    },
    Row {
        what: "laser lines at rest",
        assumptions: &[32],
        judge: rest,
        remedy: "keep the lasers off: compare OISx of CR2, OSSI of BDTR and the polarities of CCER with RM0433 38.4, `set_up` in hal/src/stm32h743/laser.rs",
    },
    Row {
        what: "AF1 of TIM1, TIM15, TIM8 after a reset",
        assumptions: &[1],
        judge: af1_at_reset,
        remedy: "none: start-up writes it",
    },
    Row {
        what: "AF1 of TIM1, TIM15, TIM8 read back",
        assumptions: &[1],
        judge: af1,
        remedy: "the break input is not connected to its pin: compare AF1 with RM0433 38.4.24, `set_up` in hal/src/stm32h743/laser.rs",
    },
    Row {
        what: "break register read back",
        assumptions: &[1, 2],
        judge: bdtr,
        remedy: "LOCK bits or a reset came between: compare BDTR with RM0433 38.4.18, `set_up` in hal/src/stm32h743/laser.rs",
    },
    Row {
        what: "break flag and level of each timer",
        assumptions: &[1],
        judge: flags,
        remedy: "the timer's BKINP has the other meaning, or the pin is not its input: no light before `set_up` in hal/src/stm32h743/laser.rs suits",
    },
    Row {
        what: "a break acts by its level",
        assumptions: &[2],
        judge: by_level,
        remedy: "light could return with an open interlock: keep the lasers off; `was_broken` in hal/src/stm32h743/laser.rs must poll the pin too",
    },
    Row {
        what: "width of the timers' registers",
        assumptions: &[],
        judge: widths,
        remedy: "change `CYCLE_MAX_COUNTS` in servo/src/output/cycles.rs to what the registers hold",
    },
    Row {
        what: "lock-up and low supply break the lasers",
        assumptions: &[5],
        judge: sources,
        remedy: "SYSCFG_CFGR is not at 0x5800_0418 or has other bits: compare with RM0433 12.3.5, `BREAKS` in hal/src/stm32h743/clocks.rs",
    },
    Row {
        what: "the supply",
        assumptions: &[5],
        judge: supply,
        remedy: "the supply is below 2.7 V, or PLS has another meaning: measure VDD, then compare PWR_CR1 with RM0433 6.8.1 (hal/src/stm32h743/clocks.rs)",
    },
    Row { what: "DBGMCU_APB4FZ1.WDGLSD1 read back", assumptions: &[], judge: frozen, remedy: "none: it is a figure" },
    Row {
        what: "floating-point registers are saved lazily",
        assumptions: &[20],
        judge: lazy,
        remedy: "set FPCCR.LSPEN and ASPEN at start-up in hal/src/stm32h743/mod.rs, or add 17 cycles to each tick",
    },
    Row {
        what: "cycles of the core in a count of the timers",
        assumptions: &[21],
        judge: clocks,
        remedy: "the dividers are not those of the manual: compare RCC_D1CFGR, D2CFGR and CFGR.TIMPRE with RM0433 8.7",
    },
    Row {
        what: "caches and wait states",
        assumptions: &[21],
        judge: memory,
        remedy: "start-up did not enable the caches, or FLASH_ACR was not taken: `take` in hal/src/stm32h743/mod.rs, `raise` in hal/src/stm32h743/clocks.rs",
    },
    Row {
        what: "code from flash, not cached and cached",
        assumptions: &[21],
        judge: fetch,
        remedy: "none: it is a figure",
    },
    Row {
        what: "rate of the link",
        assumptions: &[],
        judge: link,
        remedy: "the UART's clock is not 120 MHz: compare RCC_D2CCIP2R with RM0433 8.7.21, `BAUD` in hal/src/stm32h743/uart.rs",
    },
    Row {
        what: "the link's stream is buffered",
        assumptions: &[],
        judge: receiving,
        remedy: "DMA1_S2CR has another bit: compare TRBUFF with RM0433 15.5.5, `open` in hal/src/stm32h743/uart.rs; the link may stop under load",
    },
    Row {
        what: "words written before a reset",
        assumptions: &[19],
        judge: left,
        remedy: "the reason of a fault would be lost: move KEPT in memory.x to another memory, DTCM for instance",
    },
    Row {
        what: "a low supply breaks each timer",
        assumptions: &[5, 34],
        judge: low_supply,
        remedy: "light would outlast the supply: compare SYSCFG_CFGR.PVDL with RM0433 12.3.5, BDTR.BKE with RM0433 38.3.16",
    },
    Row {
        what: "VBUS at the connector of USB, PD10 low",
        assumptions: &[25],
        judge: vbus,
        remedy: "unplug what is in CN13 and measure again; if that changes nothing, PD10 does not switch it off (UM2407, schematic MB1364)",
    },
    Row {
        what: "HSI48 by the board's clock",
        assumptions: &[31],
        judge: hsi48,
        remedy: "HSI48 is off by more than a good chip's (DS12110, HSI48 characteristics; AN6202), or it is not what TIM17 counts: \
            compare RCC_CFGR.MCO1SEL (RM0433 8.7.6) and TIM17_TISEL (RM0433 41.5.22) in bring-up/src/hsi48.rs. Only an image on \
            the wrong board uses it, whose reason no host reads then (`give_usb` in hal/src/stm32h743/clocks.rs)",
    },
    Row {
        what: "ADEN right after a calibration",
        assumptions: &[23],
        judge: aden,
        remedy: "none: hal/src/stm32h743/adc.rs sets it until ADRDY",
    },
    Row { what: "stack of the bring-up image", assumptions: &[], judge: stack, remedy: "enlarge STACK in memory.x" },
    Row { what: "cause of the reset", assumptions: &[], judge: cause, remedy: "none: it is a figure" },
    Row {
        what: "the first start after power-on",
        assumptions: &[18],
        judge: power_on,
        remedy: "a start before this one failed: memory with ECC may fault at its first write; switch on again, compare with RM0433 3.2",
    },
];

/// The lines of TIM1, TIM15 and TIM8, each with its number first.
fn of_timers<const N: usize>(figures: &Figures, name: &str) -> Option<Vec<[i64; N]>> {
    figures.each::<N>(name).filter(|lines| lines.iter().map(|line| line[0]).eq([1, 15, 8]))
}

fn revision(figures: &Figures) -> Verdict {
    let Some([device, revision]) = figures.only("idc") else { return Verdict::missing("idc") };
    let name = match revision {
        0x2001 => "X",
        0x2003 => "V",
        _ => "unknown",
    };
    Verdict::of(device == 0x450 && name != "unknown", format!("device {device:#x}, revision {revision:#x} ({name})"))
}

fn package(figures: &Figures) -> Verdict {
    let Some([code]) = figures.only("package") else { return Verdict::missing("package") };
    Verdict::of(code == 2, format!("PKG {code}"))
}

/// Lines of the lasers in the order of the line `rest`: a + line rests high, a − line low.
const LINES: [&str; 8] = [
    "energy + of laser 0",
    "energy − of laser 0",
    "energy + of laser 1",
    "energy − of laser 1",
    "switch + of laser 0",
    "switch − of laser 0",
    "switch + of laser 1",
    "switch − of laser 1",
];

fn rest(figures: &Figures) -> Verdict {
    let Some(levels) = figures.only::<8>("rest") else { return Verdict::missing("rest") };
    let wrong = LINES.iter().zip(levels).enumerate().filter(|(n, (_, level))| (*level == 1) == (n % 2 == 1));
    let wrong = wrong.map(|(n, (line, _))| format!("{line} is {}", if n % 2 == 0 { "low" } else { "high" })).collect();
    all_of(wrong, "+ high, − low")
}

fn core(figures: &Figures) -> Verdict {
    let Some([cpuid]) = figures.only("cpuid") else { return Verdict::missing("cpuid") };
    let (variant, patch) = (cpuid >> 20 & 0xf, cpuid & 0xf);
    let is_m7 = cpuid & 0xff0f_fff0 == 0x410f_c270;
    Verdict::of(is_m7 && (variant, patch) >= (1, 1), format!("CPUID {cpuid:#010x}: r{variant}p{patch}"))
}

fn pins(figures: &Figures) -> Verdict {
    let (Some(modes), Some(pulls)) = (figures.only::<7>("modes-at-reset"), figures.only::<7>("pulls-at-reset")) else {
        return Verdict::missing("modes-at-reset");
    };
    let mut wrong = Vec::new();
    for (port, letter) in ('A'..='G').enumerate() {
        for pin in 0..16 {
            let differs = |is: &[i64; 7], should: &[i64; 7]| (is[port] ^ should[port]) >> (2 * pin) & 3 != 0;
            if differs(&modes, &MODES) || differs(&pulls, &PULLS) {
                wrong.push(format!("P{letter}{pin}"));
            }
        }
    }
    all_of(wrong, "analog, but the debug port")
}

fn af1_at_reset(figures: &Figures) -> Verdict {
    match of_timers::<2>(figures, "af1-at-reset") {
        None => Verdict::missing("af1-at-reset"),
        Some(lines) => Verdict::Figure(listed(&lines, |[timer, value]| format!("TIM{timer} {value:#x}"))),
    }
}

fn af1(figures: &Figures) -> Verdict {
    let Some(lines) = of_timers::<2>(figures, "af1") else { return Verdict::missing("af1") };
    // BKINE alone.
    Verdict::of(
        lines.iter().all(|[_, value]| *value == 1),
        listed(&lines, |[timer, value]| format!("TIM{timer} {value:#x}")),
    )
}

fn bdtr(figures: &Figures) -> Verdict {
    let Some(lines) = of_timers::<2>(figures, "bdtr") else { return Verdict::missing("bdtr") };
    // BKP, BKE, OSSR, OSSI; MOE is 0.
    const WANTED: i64 = 1 << 13 | 1 << 12 | 1 << 11 | 1 << 10;
    Verdict::of(
        lines.iter().all(|[_, value]| *value == WANTED),
        listed(&lines, |[timer, value]| format!("TIM{timer} {value:#x}")),
    )
}

/// Of the lines `break`: the levels that were measured.
fn levels(lines: &[[i64; 4]]) -> &'static str {
    match (lines.iter().any(|line| line[1] == 0), lines.iter().any(|line| line[1] == 1)) {
        (true, true) => "low and high",
        (true, false) => "low",
        _ => "high",
    }
}

fn flags(figures: &Figures) -> Verdict {
    let Some(lines) = figures.each::<4>("break") else { return Verdict::missing("break") };
    let wrong = lines.iter().filter(|[_, level, flag, _]| level != flag);
    let wrong = wrong.map(|[timer, level, flag, _]| format!("TIM{timer}: pin {level}, flag {flag}")).collect();
    at_both_levels(&lines, wrong, &format!("flag as the pin, {}", levels(&lines)))
}

/// Whoever has not seen both levels of each timer's break input knows half of it: a flag that is
/// always set looks right while the pin is high.
fn at_both_levels(lines: &[[i64; 4]], wrong: Vec<String>, right: &str) -> Verdict {
    let has = |timer, level| lines.iter().any(|line| line[..2] == [timer, level]);
    if wrong.is_empty() && ![1, 15, 8].iter().all(|timer| has(*timer, 0) && has(*timer, 1)) {
        return Verdict::NotMeasured(format!("{right}; jumper 6 shows both levels of TIM1, TIM15 and TIM8"));
    }
    all_of(wrong, right)
}

fn by_level(figures: &Figures) -> Verdict {
    let Some(lines) = figures.each::<4>("break") else { return Verdict::missing("break") };
    let wrong = lines.iter().filter(|[_, level, _, enabled]| *enabled == *level);
    let wrong = wrong.map(|[timer, level, _, enabled]| format!("TIM{timer}: pin {level}, MOE {enabled}")).collect();
    at_both_levels(&lines, wrong, &format!("MOE 0 while the pin is high, measured {}", levels(&lines)))
}

fn widths(figures: &Figures) -> Verdict {
    let (Some(lines), Some([tick])) = (of_timers::<4>(figures, "widths"), figures.only("tick-width")) else {
        return Verdict::missing("widths");
    };
    let mut wrong = Vec::new();
    for [timer, arr, rcr, ccr] in lines {
        let repeats = if timer == 15 { 0xff } else { 0xffff };
        for (name, is, should) in [("ARR", arr, 0xffff), ("RCR", rcr, repeats), ("CCR1", ccr, 0xffff)] {
            if is != should {
                wrong.push(format!("TIM{timer} {name} holds {is:#x} of {should:#x}"));
            }
        }
    }
    if tick != 0xffff_ffff {
        wrong.push(format!("TIM2 ARR holds {tick:#x}"));
    }
    all_of(wrong, "as in the manual")
}

fn sources(figures: &Figures) -> Verdict {
    let Some([value]) = figures.only("break-sources") else { return Verdict::missing("break-sources") };
    Verdict::of(value == (1 << 2 | 1 << 6), format!("SYSCFG_CFGR {value:#x}"))
}

fn supply(figures: &Figures) -> Verdict {
    let Some([enabled, level, low]) = figures.only("supply") else { return Verdict::missing("supply") };
    let holds = (enabled, level, low) == (1, 5, 0);
    Verdict::of(holds, format!("PVDE {enabled}, PLS {level}, {}", if low == 0 { "above 2.7 V" } else { "below 2.7 V" }))
}

fn frozen(figures: &Figures) -> Verdict {
    let Some([bit]) = figures.only("frozen") else { return Verdict::missing("frozen") };
    Verdict::Figure(format!("{bit}"))
}

fn lazy(figures: &Figures) -> Verdict {
    let Some([fpccr]) = figures.only("fpccr") else { return Verdict::missing("fpccr") };
    let Some([plain, floating]) = figures.only("entry") else { return Verdict::missing("entry") };
    let more = floating - plain;
    // Eager stacking writes 17 words more.
    let holds = fpccr >> 30 & 3 == 3 && (-7..8).contains(&more);
    Verdict::of(holds, format!("FPCCR {fpccr:#010x}, an exception takes {more} cycles more with floating point"))
}

fn clocks(figures: &Figures) -> Verdict {
    let Some([counts, cycles]) = figures.only("clocks") else { return Verdict::missing("clocks") };
    let ratio = cycles as f64 / counts.max(1) as f64;
    Verdict::of((1.999..2.001).contains(&ratio), format!("{ratio:.4}, of 2"))
}

fn memory(figures: &Figures) -> Verdict {
    let (Some([instructions, data]), Some([states, delay])) = (figures.only("caches"), figures.only("flash")) else {
        return Verdict::missing("caches");
    };
    Verdict::of(
        (instructions, data, states, delay) == (1, 1, 4, 2),
        format!("instruction cache {instructions}, data cache {data}, {states} wait states, WRHIGHFREQ {delay}"),
    )
}

fn fetch(figures: &Figures) -> Verdict {
    match figures.only("fetch") {
        None => Verdict::missing("fetch"),
        Some([cold, warm]) => Verdict::Figure(format!("{cold} and {warm} cycles")),
    }
}

fn link(figures: &Figures) -> Verdict {
    let Some([bytes, counts]) = figures.only("link") else { return Verdict::missing("link") };
    // Ten bits at 3 Mbaud take 800 counts of 240 MHz.
    let each = counts as f64 / bytes.max(1) as f64;
    Verdict::of((792.0..816.0).contains(&each), format!("{each:.0} counts a byte, of 800"))
}

fn left(figures: &Figures) -> Verdict {
    let Some([is_left, is_whole]) = figures.only("left") else { return Verdict::missing("left") };
    let last = if is_whole == 1 { "kept" } else { "lost, as assumed" };
    Verdict::of(
        is_left == 1,
        if is_left == 1 { format!("kept; a byte that nothing follows is {last}") } else { "lost".into() },
    )
}

fn low_supply(figures: &Figures) -> Verdict {
    let Some([is_low, timers @ ..]) = figures.only::<10>("low-supply") else { return Verdict::missing("low-supply") };
    if is_low == 0 {
        return Verdict::NotMeasured("jumper 9 (D0–GND) is missing".to_owned());
    }
    let (mut wrong, mut flags) = (Vec::new(), Vec::new());
    for (number, timer) in [1, 15, 8].into_iter().zip(timers.chunks_exact(3)) {
        let &[before, status, after] = timer else { continue };
        let named = [(1 << 7, "BIF"), (1 << 13, "SBIF")].into_iter().filter(|(bit, _)| status & bit != 0);
        let named: Vec<&str> = named.map(|(_, name)| name).collect();
        if (before, after) != (1, 0) || named.is_empty() {
            wrong.push(format!("TIM{number}: MOE {before}, then {after}, SR {status:#x}"));
        }
        flags.push(format!("TIM{number} {}", named.join(" ")));
    }
    all_of(wrong, &flags.join(", "))
}

fn vbus(figures: &Figures) -> Verdict {
    let Some([level]) = figures.only("vbus") else { return Verdict::missing("vbus") };
    Verdict::of(level == 0, if level == 0 { "PA9 is low" } else { "PA9 is high" })
}

fn hsi48(figures: &Figures) -> Verdict {
    let Some([cycles, counts]) = figures.only("hsi48") else { return Verdict::missing("hsi48") };
    if counts == 0 {
        return Verdict::Fail("no edges at TIM17 by MCO1".to_owned());
    }
    // 48 and 240 MHz.
    let percent = ((cycles * 5) as f64 / counts as f64 - 1.0) * 100.0;
    let figure = format!("{percent:+.2} %, of ±{USB_PERCENT} for USB and ±{HSI48_PERCENT} for HSI48");
    match percent.abs() {
        off if off <= USB_PERCENT => Verdict::Pass(figure),
        off if off <= HSI48_PERCENT => Verdict::Figure(figure + ": a good chip, which a host of USB may not read"),
        _ => Verdict::Fail(figure),
    }
}

/// A full-speed device is so exact (USB 2.0, 7.1.11).
const USB_PERCENT: f64 = 0.25;
/// HSI48 without its trimming is within this: ±1 % at 30 °C and −4.5 to +4 % over all temperatures
/// (DS12110, HSI48 characteristics, from memory); ±4 % in AN6202, of the STM32H5.
const HSI48_PERCENT: f64 = 5.0;

/// No limit: the image sets ADEN until ADRDY, so it converts whatever the chip does here. That it
/// converts is judged by the loop of the analog inputs.
fn aden(figures: &Figures) -> Verdict {
    match figures.only("aden") {
        None => Verdict::missing("aden"),
        Some([kept]) => Verdict::Figure(if kept == 1 { "kept" } else { "withdrawn" }.to_owned()),
    }
}

fn stack(figures: &Figures) -> Verdict {
    let Some([total, used]) = figures.only("stack") else { return Verdict::missing("stack") };
    Verdict::of(total - used >= 1024, format!("{used} bytes of {total}"))
}

fn cause(figures: &Figures) -> Verdict {
    match figures.only("cause") {
        None => Verdict::missing("cause"),
        Some([flags]) => Verdict::Figure(format!("RCC_RSR {flags:#010x}")),
    }
}

/// RCC_RSR (8.7.39): power-on; a reset by software, the debugger's too; one by the watchdog.
const POWER_ON: i64 = 1 << 23;
const BY_SOFTWARE: i64 = 1 << 24;
const BY_WATCHDOG: i64 = 1 << 26;

fn power_on(figures: &Figures) -> Verdict {
    let Some([flags]) = figures.only("cause") else { return Verdict::missing("cause") };
    if flags & POWER_ON == 0 || flags & BY_SOFTWARE != 0 {
        return Verdict::NotMeasured("the chip was reset since (`cause`): switch the power off and on".to_owned());
    }
    let holds = flags & BY_WATCHDOG == 0;
    Verdict::of(holds, if holds { "no other reset since" } else { "the watchdog has ended a start since" })
}

fn receiving(figures: &Figures) -> Verdict {
    let Some([enabled, buffered]) = figures.only("receiving") else { return Verdict::missing("receiving") };
    Verdict::of((enabled, buffered) == (1, 1), format!("DMA1_S2CR: EN {enabled}, TRBUFF {buffered}"))
}

/// Each line by `text`, with commas.
fn listed<const N: usize>(lines: &[[i64; N]], text: fn(&[i64; N]) -> String) -> String {
    lines.iter().map(text).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The data sheet's limits are no fault of a chip, and say what a host makes of them.
    #[test]
    fn hsi48_has_limits_of_its_own_beside_those_of_usb() {
        let judged = |counts: i64| {
            let mut figures = Figures::default();
            figures.add("hsi48", vec![48_000, counts]);
            hsi48(&figures)
        };
        assert!(matches!(judged(240_500), Verdict::Pass(text) if text.starts_with("-0.21 %")));
        assert!(
            matches!(judged(238_000), Verdict::Figure(text) if text.starts_with("+0.84 %") && text.contains("a good chip"))
        );
        assert!(matches!(judged(254_000), Verdict::Fail(text) if text.starts_with("-5.51 %")));
        assert!(matches!(judged(0), Verdict::Fail(_)));
    }
}
