//! The bring-up image on the emulated chip: every row passes, and each planted wrong fact fails in the row that names it. The image
//! that BEAMTICK_H743_BRING_UP names.
use beamtick::{Failure, bring_up_over};
use h743::facts::Wrong;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{MILLISECOND, Machine, Pin};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// A board with the bring-up image that has started, and these wrong facts. `None` without an image.
fn board(wrong: &[Wrong], open: bool) -> Option<Shared> {
    let Some(path) = std::env::var_os("BEAMTICK_H743_BRING_UP") else {
        println!("skipped: BEAMTICK_H743_BRING_UP names no image");
        return None;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    for name in ["PE15", "PE3", "PG2"] {
        machine.drive(Pin::named(name).unwrap(), Some(open));
    }
    wrong.iter().for_each(|wrong| machine.plant(*wrong));
    machine.run(MILLISECOND);
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
    for open in [false, true] {
        let Some(board) = board(&[], open) else { return };
        let (outcome, page) = measure(&board);
        println!("{page}");
        assert_eq!((failed(&page), outcome.is_ok()), (vec![], true), "interlock open: {open}");
        assert_eq!(
            rows(&page)["break flag and level of each timer"].1,
            format!("flag as the pin, {}", if open { "high" } else { "low" })
        );
        assert_eq!(lock(&board).chip.bus.complaints, Vec::<String>::new());
        // The chip resets itself: another run begins like the first one.
        let (again, second) = measure(&board);
        assert!(again.is_ok());
        let of = |page: &str| rows(page).len();
        assert_eq!(of(&second), of(&page));
    }
}

#[test]
fn each_wrong_fact_fails_in_its_row() {
    const BREAKS: &str = "break flag and level of each timer";
    const LEVEL: &str = "a break acts by its level";
    // What fails beside the row itself is a consequence of the same fact.
    let cases: [(Wrong, bool, &[&str], &str); 12] = [
        (Wrong::BreakPolarity(1), false, &[LEVEL, BREAKS], "TIM1: pin 0, flag 1"),
        (Wrong::BreakPolarity(15), true, &[LEVEL, BREAKS], "TIM15: pin 1, flag 0"),
        (Wrong::BreakPolarity(8), false, &[LEVEL, BREAKS], "TIM8: pin 0, flag 1"),
        (Wrong::BreakByEdge, true, &[LEVEL], "TIM1: pin 1, MOE 1; TIM15: pin 1, MOE 1; TIM8: pin 1, MOE 1"),
        (Wrong::NoAf1(15), false, &["AF1 of TIM1, TIM15, TIM8 read back"], "TIM1 0x1, TIM15 0x0, TIM8 0x1"),
        (Wrong::ShortRepeat, false, &["width of the timers' registers"], "TIM8 RCR holds 0xff of 0xffff"),
        (Wrong::NoBreakSources, false, &["lock-up and low supply break the lasers"], "SYSCFG_CFGR 0x0"),
        (Wrong::NoFreeze, false, &["a debugger freezes the watchdog"], "WDGLSD1 reads 0"),
        (Wrong::Revision(0x3003), false, &["revision of the chip"], "device 0x450, revision 0x3003 (unknown)"),
        (Wrong::EarlyCore, false, &["revision of the core"], "CPUID 0x410fc270: r0p0"),
        (Wrong::EagerStacking, false, &["floating-point registers are saved lazily"], "FPCCR 0x80000000"),
        (Wrong::DrivenAtReset, false, &["pins after a reset"], "PB0"),
    ];
    for (wrong, open, fail, figure) in cases {
        let Some(board) = board(&[wrong], open) else { return };
        // It is told from the next reset on, as on a chip that has it from the first.
        lock(&board).reset(h743::Cause::Pin);
        let (outcome, page) = measure(&board);
        assert_eq!(failed(&page), fail, "{wrong:?}\n{page}");
        let row = fail.last().unwrap();
        assert_eq!(rows(&page)[row].1, figure, "{wrong:?}");
        assert!(matches!(outcome, Err(Failure::Job(_))), "{wrong:?} {outcome:?}");
        let advice = page.split("## What to change").nth(1).unwrap();
        assert!(fail.iter().all(|what| advice.contains(&format!("- {what}: "))), "{wrong:?}: no advice");
    }
}

#[test]
fn a_board_that_does_not_answer_is_told_with_what_to_do() {
    let Some(board) = board(&[Wrong::Revision(0x1003)], false) else { return };
    lock(&board).reset(h743::Cause::Pin);
    let (outcome, page) = measure(&board);
    let Err(Failure::Job(text)) = outcome else { panic!("{outcome:?}") };
    assert!(text.starts_with("the board does not answer.") && text.contains("revision Y or Z"), "{text}");
    assert_eq!(page, "");
}
