//! The bring-up image on the emulated chip: every row passes, and each planted wrong fact fails in
//! the row that names it. The image that BEAMTICK_H743_BRING_UP names.
#[path = "bring_up/bench.rs"]
mod bench;
#[path = "bring_up/loads.rs"]
mod loads;

use beamtick::{Failure, bring_up_over};
use client::Link;
use h743::facts::Wrong;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{MILLISECOND, Machine, Pin};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Jumpers of docs/bring-up.md: number, the pin that drives, the end.
const JUMPERS: [(u8, &str, &str); 15] = [
    (1, "PE9", "PA0"),
    (2, "PE5", "PB3"),
    (3, "PC7", "PB10"),
    (4, "PF8", "PA3"),
    (5, "PE8", "PB11"),
    (6, "PG14", "PE15"),
    (6, "PG14", "PE3"),
    (6, "PG14", "PG2"),
    (6, "PG14", "PA15"),
    (10, "PG0", "PB4"),
    (10, "PG0", "PD12"),
    (11, "PG1", "PB5"),
    (11, "PG1", "PD13"),
    (12, "PG3", "PB1"),
    (12, "PG3", "PD14"),
];
/// Those of the converters: number, output of DAC1, input of ADC3 (PC3_C, PC2_C).
const LOOPS: [(u8, usize, usize); 2] = [(7, 0, 1), (8, 1, 0)];

/// Puts all jumpers in but these.
fn wire(machine: &mut Machine, without: &[u8]) {
    let pin = |name| Pin::named(name).unwrap();
    let there = |number: &u8| !without.contains(number);
    machine.chip.bus.jumpers =
        JUMPERS.iter().filter(|(number, ..)| there(number)).map(|&(_, from, to)| (pin(from), pin(to))).collect();
    machine.chip.bus.analog_jumpers =
        LOOPS.iter().filter(|(number, ..)| there(number)).map(|&(_, from, to)| (from, to)).collect();
    // The ninth leads PVD_IN to ground.
    machine.drive(pin("PB7"), there(&9).then_some(false));
}

/// A board with the bring-up image that has started, these wrong facts, and all jumpers but these.
/// `None` without an image.
fn board(wrong: &[Wrong], without: &[u8]) -> Option<Shared> {
    let Some(path) = std::env::var_os("BEAMTICK_H743_BRING_UP") else {
        println!("skipped: BEAMTICK_H743_BRING_UP names no image");
        return None;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    wire(&mut machine, without);
    // They hold from before the first instruction.
    wrong.iter().for_each(|wrong| machine.plant(*wrong));
    machine.run(20 * MILLISECOND);
    Some(Arc::new(Mutex::new(machine)))
}

/// Runs the measurement: how it ended, and the page.
fn measure(board: &Shared) -> (Result<(), Failure>, String) {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let outcome = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &["--page", page.to_str().unwrap()]);
    (outcome, std::fs::read_to_string(page).unwrap_or_default())
}

/// Rows of the page: result and figure by what is measured.
fn rows(page: &str) -> BTreeMap<&str, (&str, &str)> {
    page.lines()
        .filter_map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            let &[what, _, result, figure] = cells.as_slice() else { return None };
            matches!(result, "pass" | "**FAIL**" | "does not fit" | "figure" | "not measured")
                .then_some((what, (result, figure)))
        })
        .collect()
}

fn failed(page: &str) -> Vec<&str> {
    rows(page).into_iter().filter(|(_, (result, _))| *result == "**FAIL**").map(|(what, _)| what).collect()
}

#[test]
fn a_chip_as_assumed_passes_every_row() {
    let Some(board) = board(&[], &[]) else { return };
    let (outcome, page) = measure(&board);
    println!("{page}");
    assert_eq!((failed(&page), outcome.is_ok()), (vec![], true), "{outcome:?}\n{page}");
    let rows_of_first = rows(&page);
    // What the board's own image or a hand measures names the option that does.
    let not_measured = rows_of_first.values().filter(|(result, _)| *result == "not measured");
    let options: Vec<_> = not_measured.filter_map(|(_, why)| why.split_once(" --")).map(|(head, _)| head).collect();
    assert_eq!(options, ["`bring-up"; 9]);
    // Figures worked out by hand: the plan of bring-up/src/light.rs, and the model's 21 counts of
    // DMA.
    for (row, figure) in [
        ("jumpers", "all twelve"),
        ("laser lines at rest", "+ high, − low"),
        (
            "floating-point registers are saved lazily",
            "FPCCR 0xc0000000, an exception takes 0 cycles more with floating point",
        ),
        ("break flag and level of each timer", "flag as the pin, low and high"),
        ("first edges after their tick", "laser 0 0, laser 1 0, switch 0 counts"),
        ("each step is played once", "100 of 100"),
        (
            "shortest cycles of the energies, all streams busy",
            "1600 edges of cycles of 84 and 90 counts, 0 counts off at most; the link's stream busy",
        ),
        (
            "shortest cycles of the switches, all streams busy",
            "800 edges of cycles of 120 and 126 counts, 0 counts off at most; the link's stream busy",
        ),
        ("energy − after + at a break", "2 counts (8 ns)"),
        ("analog inputs by analog outputs", "output 1 8, output 2 8, of 400 in 65536"),
        ("light after a burst that was broken off", "both lasers and the switch to the count, before and after"),
        ("words written before a reset", "kept; a byte that nothing follows is kept"),
        ("a low supply breaks each timer", "TIM1 SBIF, TIM15 BIF, TIM8 SBIF"),
        ("VBUS at the connector of USB, PD10 low", "PA9 is low"),
        ("HSI48 by the board's clock", "+0.00 %, of ±0.25 for USB and ±5 for HSI48"),
        ("ADEN right after a calibration", "kept"),
        // Power-on, as it was before the run's own resets.
        ("cause of the reset", "RCC_RSR 0x00fa0000"),
        ("the first start after power-on", "no other reset since"),
        ("DBGMCU_APB4FZ1.WDGLSD1 read back", "1"),
        ("the watchdog's time", "100.0 ms, of 94.9 to 107.8: LSI 32.0 kHz"),
        (
            "encoders count four a line, to and fro",
            "TIM3 40, then -40, of 40 and -40; TIM4 40, then -40, of 40 and -40",
        ),
    ] {
        assert_eq!(rows_of_first[row].1, figure, "{row}");
    }
    assert_eq!(lock(&board).chip.bus.complaints, Vec::<String>::new());
    // The chip resets itself: another run begins like the first one.
    let (again, second) = measure(&board);
    assert!(again.is_ok());
    assert_eq!(rows(&second).len(), rows_of_first.len());
}

/// Each end is found by the pin that drives it: crossed jumpers are none.
#[test]
fn crossed_jumpers_are_named_and_measure_nothing() {
    for (crossed, named, row, why) in [
        (
            [1, 3],
            "jumper 1 ends at D36; jumper 3 ends at D32",
            "first edges after their tick",
            "jumper 1 ends at D36, not at D32",
        ),
        (
            [1, 2],
            "jumper 1 ends at D23; jumper 2 ends at D32",
            "cycles of 2 MHz, all streams busy",
            "jumper 1 ends at D23, not at D32",
        ),
    ] {
        let Some(board) = board(&[], &crossed) else { return };
        {
            let mut machine = lock(&board);
            let ends = crossed.map(|number| JUMPERS.iter().find(|jumper| jumper.0 == number).unwrap());
            let pin = |name| Pin::named(name).unwrap();
            machine.chip.bus.jumpers.extend([(pin(ends[0].1), pin(ends[1].2)), (pin(ends[1].1), pin(ends[0].2))]);
        }
        let (outcome, page) = measure(&board);
        assert_eq!(failed(&page), ["jumpers"], "{page}");
        assert!(matches!(outcome, Err(Failure::Job(_))));
        assert_eq!(rows(&page)["jumpers"], ("**FAIL**", named));
        assert_eq!(rows(&page)[row], ("not measured", why));
        assert_eq!(lock(&board).chip.bus.complaints, Vec::<String>::new());
    }
}

/// What happens to the board once the run has begun.
struct Meddling<F> {
    link: EmulatedLink,
    board: Shared,
    meddle: F,
    steps: u32,
    heard: Vec<u8>,
}

impl<F: FnMut(&mut Machine, u32) + Send> Link for Meddling<F> {
    fn name(&self) -> &str {
        self.link.name()
    }
    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        self.link.send(bytes)
    }
    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        let count = self.link.receive(buf, wait)?;
        // Steps count from the first figures on. The word may come in two parts.
        self.heard.extend_from_slice(&buf[..count]);
        self.steps += u32::from(self.steps > 0 || self.heard.windows(6).any(|text| text == b"format"));
        (self.meddle)(&mut lock(&self.board), self.steps);
        Ok(count)
    }
    fn now(&mut self) -> u64 {
        self.link.now()
    }
    fn real_time(&self) -> bool {
        false
    }
}

/// Runs the measurement while somebody meddles.
fn meddled(board: &Shared, meddle: impl FnMut(&mut Machine, u32) + Send + 'static) -> (Result<(), Failure>, String) {
    let link =
        Meddling { link: EmulatedLink::new(board.clone()), board: board.clone(), meddle, steps: 0, heard: Vec::new() };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let outcome = bring_up_over(Box::new(link), &["--page", page.to_str().unwrap()]);
    (outcome, std::fs::read_to_string(page).unwrap_or_default())
}

/// A supply that was low for a while sets the flag of the chip's breaks, which is no fault of a
/// pin's break.
#[test]
fn a_supply_that_was_low_before_is_no_wrong_break() {
    let Some(board) = board(&[], &[]) else { return };
    let (outcome, page) = meddled(&board, |machine, step| match step {
        1 => machine.supply(2600),
        2 => machine.supply(3300),
        _ => {}
    });
    assert_eq!((failed(&page), outcome.is_ok()), (vec![], true), "{page}");
}

/// The ST-LINK's clock stops within a run: the reason arrives, and the next run begins like the
/// first one, with words of its own.
#[test]
fn a_run_that_ends_early_leaves_nothing_to_the_next_one() {
    let Some(board) = board(&[], &[]) else { return };
    let (outcome, page) = meddled(&board, |machine, step| {
        if step == 2 {
            machine.give_clock(false);
        }
    });
    let Err(Failure::Job(text)) = outcome else { panic!("{outcome:?}") };
    // Within a line or after one, the reason arrives.
    assert!(text.contains("clock has stopped"), "{text}");
    assert_eq!(page, "");
    lock(&board).give_clock(true);
    lock(&board).run(300 * MILLISECOND);
    let (outcome, page) = measure(&board);
    assert!(outcome.is_ok(), "{outcome:?}\n{page}");
    // The resets of the run itself, and the watchdog after its early end; none of the run before.
    assert_eq!(rows(&page)["cause of the reset"].1, "RCC_RSR 0x05420000", "{page}");
}

/// A page of before is never lost: it stays where the new one cannot be written, and until that is
/// whole.
#[test]
fn a_page_that_cannot_be_written_is_found_before_the_measurement() {
    let Some(board) = board(&[], &[]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("missing").join("page.md");
    let began = lock(&board).chip.now;
    let words = ["--page", page.to_str().unwrap()];
    let outcome = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &words);
    let Err(Failure::Input(text)) = outcome else { panic!("{outcome:?}") };
    assert!(text.starts_with("--page ") && text.contains("page.md: cannot be written"), "{text}");
    assert_eq!(lock(&board).chip.now, began);
    // A run that is cut short leaves the page of before.
    let page = folder.path().join("page.md");
    let before = include_str!("../../../docs/bring-up-page.md");
    std::fs::write(&page, before).unwrap();
    let words = ["--page", page.to_str().unwrap()];
    lock(&board).plant(Wrong::Revision(0x1003));
    lock(&board).reset(h743::Cause::Pin);
    let outcome = bring_up_over(Box::new(EmulatedLink::new(board)), &words);
    let Err(Failure::Job(text)) = outcome else { panic!("{outcome:?}") };
    assert!(text.ends_with("page.md is as it was."), "{text}");
    assert_eq!(std::fs::read_to_string(&page).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn without_jumpers_rows_are_not_measured_and_none_fails() {
    let Some(board) = board(&[], &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]) else { return };
    let (outcome, page) = measure(&board);
    assert_eq!((failed(&page), outcome.is_ok()), (vec![], true), "{page}");
    let rows = rows(&page);
    assert!(rows["jumpers"].1.starts_with("missing: 1 (D6–D32), 2 (D58–D23)"), "{page}");
    assert!(rows["jumpers"].1.ends_with("; without jumper 6 the first five are not looked for"), "{page}");
    assert_eq!(rows["first edges after their tick"], ("not measured", "jumper 1 (D6–D32) is missing"));
    // Half of what it takes: a flag that is always set looks the same.
    let both = "; jumper 6 shows both levels of TIM1, TIM15 and TIM8";
    let flag = format!("flag as the pin, high{both}");
    assert_eq!(rows["break flag and level of each timer"], ("not measured", flag.as_str()));
    let level = format!("MOE 0 while the pin is high, measured high{both}");
    assert_eq!(rows["a break acts by its level"], ("not measured", level.as_str()));
    assert_eq!(rows["analog inputs by analog outputs"].0, "not measured");
    assert_eq!(rows["a low supply breaks each timer"], ("not measured", "jumper 9 (D0–GND) is missing"));
    assert!(rows.values().filter(|(result, _)| *result == "pass").count() >= 16, "{page}");
}

/// Its lines may be wired to anything: what registers show is reported, the rest is not measured.
#[test]
fn on_another_package_no_line_is_driven_but_the_links() {
    let Some(board) = board(&[Wrong::Package(0)], &[]) else { return };
    let (_, page) = measure(&board);
    assert_eq!(failed(&page), ["package of the chip"], "{page}");
    assert_eq!(rows(&page)["first edges after their tick"].0, "not measured");
    let link = Pin::named("PD8").unwrap();
    let machine = lock(&board);
    let driven = |change: &&h743::gpio::Change| matches!(change.level, h743::Level::Driven(_)) && change.pin != link;
    let driven: Vec<_> = machine.chip.bus.gpio.changes.iter().filter(driven).collect();
    assert!(driven.is_empty(), "{driven:?}");
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
}

/// What a fault of memory at its first write comes to. After any other reset nobody knows.
#[test]
fn a_start_that_the_watchdog_ended_is_no_good_first_one() {
    for (cause, result, figure) in [
        (h743::Cause::Watchdog, "**FAIL**", "the watchdog has ended a start since"),
        (h743::Cause::Software, "not measured", "the chip was reset since (`cause`): switch the power off and on"),
    ] {
        let Some(board) = board(&[Wrong::Package(0)], &[]) else { return };
        lock(&board).reset(cause);
        let (_, page) = measure(&board);
        assert_eq!(rows(&page)["the first start after power-on"], (result, figure));
    }
}

const BREAKS: &str = "break flag and level of each timer";
const LEVEL: &str = "a break acts by its level";

const STARVED: &[&str] = &["a slot that nobody has filled is dark and stops the timer"];

/// A wrong fact, the rows that must fail, and the figure of the first of them if it is certain.
/// What else fails is a consequence.
type Case = (Wrong, &'static [&'static str], &'static str);

#[test]
fn a_wrong_fact_that_registers_tell_fails_in_its_row() {
    check([
        (Wrong::BreakPolarity(1), &[BREAKS, LEVEL], "TIM1: pin 1, flag 0; TIM1: pin 0, flag 1"),
        (Wrong::BreakPolarity(15), &[BREAKS, LEVEL], "TIM15: pin 1, flag 0; TIM15: pin 0, flag 1"),
        (Wrong::BreakPolarity(8), &[BREAKS, LEVEL], "TIM8: pin 1, flag 0; TIM8: pin 0, flag 1"),
        (Wrong::BreakByEdge, &[LEVEL], "TIM1: pin 1, MOE 1; TIM15: pin 1, MOE 1; TIM8: pin 1, MOE 1"),
        (Wrong::StuckBreak(15), &[BREAKS, LEVEL], "TIM15: pin 0, flag 1"),
        (Wrong::OtherRest(1), &["laser lines at rest"], "energy + of laser 0 is low; energy − of laser 0 is high"),
        (Wrong::NoIdleLevels(8), &["break register read back"], "TIM1 0x3c00, TIM15 0x3c00, TIM8 0x3800"),
        (Wrong::LowSupply, &["the supply"], "PVDE 1, PLS 5, below 2.7 V"),
        (Wrong::NoAf1(15), &["AF1 of TIM1, TIM15, TIM8 read back"], "TIM1 0x1, TIM15 0x0, TIM8 0x1"),
    ]);
}

/// Facts that have nothing to do with each other: each fails in its row, and no other row does.
#[test]
fn wrong_facts_together_fail_in_their_rows_alone() {
    let facts = [
        (Wrong::ShortRepeat, "width of the timers' registers", "TIM8 RCR holds 0xff of 0xffff"),
        (Wrong::NoBreakSources, "lock-up and low supply break the lasers", "SYSCFG_CFGR 0x0"),
        (Wrong::Forgets, "words written before a reset", "lost"),
        (Wrong::NoCaches, "caches and wait states", "instruction cache 0, data cache 0, 4 wait states, WRHIGHFREQ 2"),
        (Wrong::SlowLink, "rate of the link", "823 counts a byte, of 800"),
        (Wrong::NoBuffer, "the link's stream is buffered", "DMA1_S2CR: EN 1, TRBUFF 0"),
        (Wrong::EarlyCore, "revision of the core", "CPUID 0x410fc270: r0p0"),
        (
            Wrong::EagerStacking,
            "floating-point registers are saved lazily",
            "FPCCR 0x80000000, an exception takes 17 cycles more with floating point",
        ),
        (Wrong::Package(0), "package of the chip", "PKG 0"),
        (Wrong::DrivenAtReset, "pins after a reset", "PB0"),
    ];
    together(&facts);
}

/// The same on the board's own package, whose lines are measured too.
#[test]
fn wrong_facts_of_supplies_and_clocks_fail_in_their_rows_alone() {
    together(&[
        (Wrong::NoBreakSources, "lock-up and low supply break the lasers", "SYSCFG_CFGR 0x0"),
        (
            Wrong::NoBreakSources,
            "a low supply breaks each timer",
            "TIM1: MOE 1, then 1, SR 0x0; TIM15: MOE 1, then 1, SR 0x0; TIM8: MOE 1, then 1, SR 0x0",
        ),
        (Wrong::NoBreakSources, "a locked-up core ends light", "laser 0: 7 edges after it; laser 1: 7 edges after it"),
        (Wrong::FiveVolts, "VBUS at the connector of USB, PD10 low", "PA9 is high"),
        (Wrong::SlowHsi48, "HSI48 by the board's clock", "-5.66 %, of ±0.25 for USB and ±5 for HSI48"),
    ]);
}

/// All of them at once: their rows fail, and no other row does.
fn together(facts: &[(Wrong, &str, &str)]) {
    let wrong: Vec<Wrong> = facts.iter().map(|(wrong, ..)| *wrong).collect();
    let Some(board) = board(&wrong, &[]) else { return };
    lock(&board).reset(h743::Cause::Pin);
    let (_, page) = measure(&board);
    let mut rows_of_facts: Vec<&str> = facts.iter().map(|(_, row, _)| *row).collect();
    rows_of_facts.sort_unstable();
    assert_eq!(failed(&page), rows_of_facts, "{page}");
    for (wrong, row, figure) in facts {
        println!("{wrong:?}: {row}: {}", rows(&page)[row].1);
        assert!(figure.is_empty() || rows(&page)[row].1 == *figure, "{wrong:?}: {}", rows(&page)[row].1);
    }
    let advice = page.split("## What to change").nth(1).unwrap();
    assert!(facts.iter().all(|(_, what, _)| advice.contains(&format!("- {what}: "))), "no advice");
}

/// Bursts, streams, the interlock's time, the clock that counts.
#[test]
fn a_wrong_fact_of_dma_or_of_a_timer_fails_in_its_row() {
    let broken_off: &[&str] = &["light after a burst that was broken off"];
    check([
        (Wrong::HalfTimers, &["cycles of the core in a count of the timers"], "4.0001, of 2"),
        (Wrong::SlowBreak, &["from the interlock to dark"], "28 counts, MOE of TIM1 0, TIM15 0, TIM8 0 after it"),
        (Wrong::Unconnected(8), &["from the interlock to dark", BREAKS], ""),
        (Wrong::BusyDma, &["steps of 1 MHz, all streams busy", "cycles of 2 MHz, all streams busy"], ""),
        (Wrong::LostClears, &["each step is played once"], ""),
        (Wrong::StreamRewinds, &["a stream keeps its position while its timer is stopped"], ""),
        (Wrong::KeepsBurst(1), broken_off, ""),
        (Wrong::KeepsBurst(15), broken_off, ""),
        (Wrong::KeepsBurst(8), broken_off, ""),
        (Wrong::SlowDma, &["cycles of 2 MHz, all streams busy", "a step after its slot"], ""),
    ]);
}

/// A burst that takes 10 ns more than the shortest cycle: its row fails, says where, and names what
/// to raise; the other timers' row does not. What else fails is a consequence: the firmware's own
/// ticks end with shortest cycles.
#[test]
fn a_burst_longer_than_the_shortest_cycle_fails_with_what_to_raise() {
    const ENERGIES: &str = "shortest cycles of the energies, all streams busy";
    const SWITCHES: &str = "shortest cycles of the switches, all streams busy";
    for (timer, row, line, constant) in [
        (1, ENERGIES, "laser 0 ", "servo/src/output/pwm_cycles.rs"),
        (15, ENERGIES, "laser 1 ", "servo/src/output/pwm_cycles.rs"),
        (8, SWITCHES, "switch 0 ", "servo/src/output/gate_cycles.rs"),
    ] {
        let Some(board) = board(&[Wrong::SlowBurst(timer)], &[]) else { return };
        let (outcome, page) = measure(&board);
        assert!(matches!(outcome, Err(Failure::Job(_))), "{outcome:?}\n{page}");
        let figure = rows(&page)[row].1;
        let results = [ENERGIES, SWITCHES].map(|row| rows(&page)[row].0);
        assert_eq!(results, if row == ENERGIES { ["**FAIL**", "pass"] } else { ["pass", "**FAIL**"] }, "{page}");
        println!("TIM{timer}: {figure}");
        assert!(figure.split("; ").all(|wrong| wrong.starts_with(line) && wrong.ends_with(" counts off")), "{figure}");
        let advice = page.lines().find(|text| text.starts_with(&format!("- {row}: "))).unwrap();
        assert!(advice.contains(&format!("raise `MIN_COUNTS` in {constant}")), "{advice}");
    }
}

/// Facts of the watchdog, a locked-up core, encoders and SPI3: each fails its row, and no other
/// one.
#[test]
fn a_wrong_fact_of_a_peripheral_fails_in_its_row_alone() {
    const COUNTS: &str = "encoders count four a line, to and fro";
    const INDEX: &str = "an index is latched at the delay of A and B";
    together(&[(Wrong::SlowLsi, "the watchdog's time", "115.0 ms, of 94.9 to 107.8: LSI 27.8 kHz")]);
    together(&[(
        Wrong::NoLockUpBreak,
        "a locked-up core ends light",
        "laser 0: 7 edges after it; laser 1: 7 edges after it",
    )]);
    together(&[(Wrong::EarlyIndex(4), INDEX, "")]);
    together(&[(Wrong::SlowSpi, "a byte of SPI3", "")]);
    check([
        (Wrong::SwappedEncoder(3), &[COUNTS], "TIM3 -40, then 40, of 40 and -40"),
        (Wrong::HalfEncoder(4), &[COUNTS], "TIM4 20, then -20, of 40 and -40"),
    ]);
}

#[test]
fn a_wrong_fact_that_edges_tell_fails_in_its_row() {
    check([
        (Wrong::StartsLate(15), &["first edges after their tick"], "laser 0 0, laser 1 12, switch 0 counts"),
        (Wrong::Deaf(15), &["TIM1, TIM15 and TIM8 start by their triggers"], "TIM1 1, TIM15 0, TIM8 1"),
        (Wrong::CountsToZero(1), STARVED, ""),
        (Wrong::CountsToZero(15), STARVED, ""),
        (Wrong::CountsToZero(8), STARVED, ""),
        (
            Wrong::SettlesLong,
            &["energy − after + at a break", "energy − after + at a safe state"],
            "200 counts (833 ns)",
        ),
        (Wrong::SlowDac, &["analog outputs within a tick"], ""),
        (Wrong::LowAdc, &["analog inputs by analog outputs"], ""),
    ]);
}

/// Runs them one at a time.
fn check<const N: usize>(cases: [Case; N]) {
    for (wrong, must_fail, figure) in cases {
        let Some(board) = board(&[wrong], &[]) else { return };
        // It is reported from the next reset on, as on a chip that has it from the first.
        lock(&board).reset(h743::Cause::Pin);
        let (outcome, page) = measure(&board);
        let fails = failed(&page);
        println!("{wrong:?}: {fails:?}");
        let first = must_fail.first().unwrap();
        assert!(must_fail.iter().all(|row| fails.contains(row)), "{wrong:?}: {outcome:?}\n{page}");
        assert!(figure.is_empty() || rows(&page)[first].1 == figure, "{wrong:?}\n{page}");
        assert!(matches!(outcome, Err(Failure::Job(_))), "{wrong:?} {outcome:?}");
        let advice = page.split("## What to change").nth(1).unwrap();
        assert!(fails.iter().all(|what| advice.contains(&format!("- {what}: "))), "{wrong:?}: no advice");
    }
}

#[test]
fn a_board_that_does_not_answer_is_reported_with_what_to_do() {
    let Some(board) = board(&[Wrong::Revision(0x1003)], &[]) else { return };
    lock(&board).reset(h743::Cause::Pin);
    let (outcome, page) = measure(&board);
    let Err(Failure::Job(text)) = outcome else { panic!("{outcome:?}") };
    assert!(text.starts_with("the board does not answer.") && text.contains("revision X or V"), "{text}");
    assert_eq!(page, "");
}

/// All revisions but X and V, and all other chips, are refused: LD3 is the only pin that the image
/// drives.
#[test]
fn another_chip_lights_ld3_and_drives_nothing_else() {
    for other in
        [0x1001, 0x1003, 0x2002, 0x3003].map(Wrong::Revision).into_iter().chain([0x480, 0x483].map(Wrong::Chip))
    {
        let Some(board) = board(&[other], &[]) else { return };
        let mut machine = lock(&board);
        machine.run(200 * MILLISECOND);
        let led = Pin::named("PB14").unwrap();
        assert_eq!(machine.chip.bus.gpio.level(led), h743::Level::Driven(true), "{other:?}");
        let changes = &machine.chip.bus.gpio.changes;
        let driven: Vec<_> = changes.iter().filter(|change| matches!(change.level, h743::Level::Driven(_))).collect();
        assert!(
            driven.iter().all(|change| change.pin == led && change.level == h743::Level::Driven(true)),
            "{driven:?}"
        );
        // No watchdog ends it.
        assert_eq!((machine.resets.len(), &machine.chip.bus.complaints), (0, &Vec::<String>::new()));
    }
}
