//! The bring-up image on the emulated chip: every row passes, and each planted wrong fact fails in
//! the row that names it. The image that BEAMTICK_H743_BRING_UP names.
use beamtick::{Failure, bring_up_over};
use h743::facts::Wrong;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{MILLISECOND, Machine, Pin};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// Jumpers of docs/bring-up.md: number, the pin that drives, the end.
const JUMPERS: [(u8, &str, &str); 9] = [
    (1, "PE9", "PA0"),
    (2, "PE5", "PB3"),
    (3, "PC7", "PB10"),
    (4, "PF8", "PA3"),
    (5, "PE8", "PB11"),
    (6, "PG14", "PE15"),
    (6, "PG14", "PE3"),
    (6, "PG14", "PG2"),
    (6, "PG14", "PA15"),
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
        .take_while(|line| *line != "## By hand")
        .filter_map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            let &[what, _, result, figure] = cells.as_slice() else { return None };
            matches!(result, "pass" | "**FAIL**" | "figure" | "not measured").then_some((what, (result, figure)))
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
    assert_eq!((failed(&page), outcome.is_ok()), (vec![], true), "{page}");
    let rows_of_first = rows(&page);
    let not_measured = rows_of_first.iter().find(|(_, (result, _))| *result == "not measured");
    assert_eq!(not_measured, None);
    // Figures worked out by hand: the plan of bring-up/src/light.rs, and the model's 21 counts of
    // DMA.
    for (row, figure) in [
        ("jumpers", "all nine"),
        ("laser lines at rest", "+ high, − low"),
        (
            "floating-point registers are saved lazily",
            "FPCCR 0xc0000000, an exception takes 0 cycles more with floating point",
        ),
        ("break flag and level of each timer", "flag as the pin, low and high"),
        ("first edges after their tick", "laser 0 0, laser 1 0, switch 0 counts"),
        ("each step is played once", "100 of 100"),
        ("energy − after + at a break", "2 counts (8 ns)"),
        ("analog inputs by analog outputs", "8 of 65536 at output 1 and 2, of 400"),
        ("light after a burst that was broken off", "both lasers and the switch to the count, before and after"),
        ("words written before a reset", "kept; a byte that nothing follows is kept"),
        ("a low supply breaks each timer", "TIM1 SBIF, TIM15 BIF, TIM8 SBIF"),
        ("VBUS at the connector of USB, PD10 low", "PA9 is low"),
        ("HSI48 by the board's clock", "+0 ppm, of ±2500"),
        ("ADEN right after a calibration", "kept"),
        // Power-on, as it was before the run's own resets.
        ("cause of the reset", "RCC_RSR 0x00fa0000"),
    ] {
        assert_eq!(rows_of_first[row].1, figure, "{row}");
    }
    assert_eq!(lock(&board).chip.bus.complaints, Vec::<String>::new());
    // The chip resets itself: another run begins like the first one.
    let (again, second) = measure(&board);
    assert!(again.is_ok());
    assert_eq!(rows(&second).len(), rows_of_first.len());
}

/// The board's own image, with jumper 6, which keeps the interlock closed, and without.
#[test]
fn ticks_of_the_boards_own_image_are_measured_under_loads() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return;
    };
    let elf = std::fs::read(path).unwrap();
    for without in [&[][..], &[6]] {
        let mut machine = Machine::new().unwrap();
        machine.boot(&elf).unwrap();
        wire(&mut machine, without);
        machine.run(20 * MILLISECOND);
        let board = Arc::new(Mutex::new(machine));
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        let words = ["--loads", "--page", page.to_str().unwrap()];
        let outcome = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &words);
        let page = std::fs::read_to_string(page).unwrap_or_default();
        assert!(outcome.is_ok(), "{outcome:?}\n{page}");
        let rows = rows(&page);
        let result = |name: &str| rows[name].0;
        assert_eq!((rows.len(), result("nothing runs"), result("eight axes in PVT")), (6, "pass", "pass"));
        let lit = if without.is_empty() { "pass" } else { "not measured" };
        for name in [
            "two lasers at 10 kHz",
            "two lasers at 2 MHz",
            "eight axes in PVT, two lasers at 2 MHz",
            "two paths, two axes in PVT, two lasers at 2 MHz that follow",
        ] {
            assert_eq!(result(name), lit, "{page}");
        }
        println!("{page}");
        if without.is_empty() {
            // The axes of the paths and those in PVT have moved.
            let machine = lock(&board);
            let mut steps = ["PF8", "PF9", "PF10", "PF11", "PF12", "PF13"].map(|name| (Pin::named(name).unwrap(), 0));
            for change in &machine.chip.bus.gpio.changes {
                steps.iter_mut().filter(|(pin, _)| *pin == change.pin).for_each(|(_, edges)| *edges += 1);
            }
            assert!(steps.iter().all(|(_, edges)| *edges > 1000), "{steps:?}");
        }
        assert_eq!(lock(&board).chip.bus.complaints, Vec::<String>::new());
    }
}

#[test]
fn without_jumpers_rows_are_not_measured_and_none_fails() {
    let Some(board) = board(&[], &[1, 2, 3, 4, 5, 6, 7, 8, 9]) else { return };
    let (outcome, page) = measure(&board);
    assert_eq!((failed(&page), outcome.is_ok()), (vec![], true), "{page}");
    let rows = rows(&page);
    assert!(rows["jumpers"].1.starts_with("missing: 1 (D6–D32), 2 (D58–D23)"), "{page}");
    assert_eq!(rows["first edges after their tick"], ("not measured", "jumper 1 (D6–D32) is missing"));
    assert_eq!(rows["break flag and level of each timer"], ("pass", "flag as the pin, high"));
    assert_eq!(rows["analog inputs by analog outputs"].0, "not measured");
    assert_eq!(rows["a low supply breaks each timer"], ("not measured", "jumper 9 (D0–GND) is missing"));
    assert!(rows.values().filter(|(result, _)| *result == "pass").count() >= 16, "{page}");
}

/// Its lines may be wired to anything: what registers tell is reported, the rest is not measured.
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

const BREAKS: &str = "break flag and level of each timer";
const LEVEL: &str = "a break acts by its level";

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
        (Wrong::NoFreeze, "a debugger freezes the watchdog", "WDGLSD1 reads 0"),
        (Wrong::Revision(0x3003), "revision of the chip", "device 0x450, revision 0x3003 (unknown)"),
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
        (Wrong::FiveVolts, "VBUS at the connector of USB, PD10 low", "PA9 is high"),
        (Wrong::SlowHsi48, "HSI48 by the board's clock", "-9901 ppm, of ±2500"),
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
    facts.iter().for_each(|(wrong, row, figure)| assert_eq!(rows(&page)[row].1, *figure, "{wrong:?}"));
}

/// Bursts, streams, the interlock's time, the clock that counts.
#[test]
fn a_wrong_fact_of_dma_or_of_a_timer_fails_in_its_row() {
    let broken_off: &[&str] = &["light after a burst that was broken off"];
    check([
        (Wrong::HalfTimers, &["cycles of the core in a count of the timers"], "4.0003, of 2"),
        (Wrong::SlowBreak, &["from the interlock to dark"], "28 counts, MOE 0 and 0 after it"),
        (Wrong::BusyDma, &["steps of 1 MHz, all streams busy"], ""),
        (Wrong::LostClears, &["each step is played once"], ""),
        (Wrong::StreamRewinds, &["a stream keeps its place while its timer stands"], ""),
        (Wrong::KeepsBurst(1), broken_off, ""),
        (Wrong::KeepsBurst(15), broken_off, ""),
        (Wrong::KeepsBurst(8), broken_off, ""),
        (Wrong::SlowDma, &["cycles of 2 MHz, all streams busy", "a step after its slot"], ""),
    ]);
}

#[test]
fn a_wrong_fact_that_edges_tell_fails_in_its_row() {
    check([
        (Wrong::StartsLate(15), &["first edges after their tick"], "laser 0 0, laser 1 12, switch 0 counts"),
        (Wrong::Deaf(15), &["TIM1, TIM15 and TIM8 start by their triggers"], "TIM1 1, TIM15 0, TIM8 1"),
        (Wrong::CountsToZero, &["a slot that nobody has filled is dark and stops the timer"], ""),
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
    assert!(text.starts_with("the board does not answer.") && text.contains("revision Y or Z"), "{text}");
    assert_eq!(page, "");
}

/// Revisions Y and Z are refused: LD3 is the only pin that the image drives.
#[test]
fn an_old_chip_lights_ld3_and_drives_nothing_else() {
    for revision in [0x1001, 0x1003] {
        let Some(board) = board(&[Wrong::Revision(revision)], &[]) else { return };
        let mut machine = lock(&board);
        machine.run(200 * MILLISECOND);
        let led = Pin::named("PB14").unwrap();
        assert_eq!(machine.chip.bus.gpio.level(led), h743::Level::Driven(true), "{revision:#x}");
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
