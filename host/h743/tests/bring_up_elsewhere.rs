//! Rows of the bring-up page that the boards' own images measure, or a hand: each passes, and each
//! planted wrong fact fails in its row. The images that BEAMTICK_H743_IMAGE, BEAMTICK_H743VI_IMAGE,
//! BEAMTICK_H743_DAC_IMAGE and BEAMTICK_H743_BRING_UP name; the hands are scripts.
use beamtick::{Failure, Hands, bring_up_by_hand, bring_up_over};
use client::Link;
use h743::board::{Board, MODULE, NUCLEO};
use h743::dac8563::{MID_SCALE, shown_up_to};
use h743::facts::Wrong;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{Level, MILLISECOND, Machine, Pin};
use std::sync::{Arc, Mutex};

/// Jumper 6, and the ends of jumpers that loads use.
const INTERLOCK: [&str; 4] = ["PE15", "PE3", "PG2", "PA15"];

fn pin(name: &str) -> Pin {
    Pin::named(name).unwrap()
}

/// A board with the image that a variable names, which has started, with this wrong fact from
/// before its first instruction; `None` without an image.
fn started(variable: &str, on: Board, wrong: Option<Wrong>) -> Option<Shared> {
    let Some(path) = std::env::var_os(variable) else {
        println!("skipped: {variable} names no image");
        return None;
    };
    let mut machine = Machine::on(on).unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    machine.chip.bus.jumpers = INTERLOCK.map(|end| (pin("PG14"), pin(end))).to_vec();
    wrong.into_iter().for_each(|wrong| machine.plant(wrong));
    machine.run(20 * MILLISECOND);
    Some(Arc::new(Mutex::new(machine)))
}

/// The cable of USB is in; its host has found a port, or none comes.
fn plugged(board: &Shared) {
    let mut machine = lock(board);
    machine.plug_usb(true);
    for _ in 0..200 {
        if machine.chip.bus.usb.host.is_open {
            break;
        }
        machine.run(MILLISECOND);
    }
}

/// What is done to the board at a prompt, and what is typed then.
struct Script<F> {
    board: Shared,
    does: F,
    /// For so many ms the cable is out once a prompt wants that, and when it is in again.
    out_ms: i64,
    is_in_at: i64,
}

impl<F> Script<F> {
    fn new(board: &Shared, does: F) -> Script<F> {
        Script { board: board.clone(), does, out_ms: 0, is_in_at: 0 }
    }
}

impl<F: FnMut(&mut Machine, &str) -> String> Hands for Script<F> {
    fn link(&mut self) -> Result<Box<dyn Link>, Failure> {
        if self.now_ms() < self.is_in_at {
            return Err(Failure::Job("cannot open it".to_owned()));
        }
        // The ST-LINK's clock comes with its cable, and a chip that was reset waits for that.
        if self.is_in_at > 0 {
            lock(&self.board).give_clock(true);
            lock(&self.board).run(20 * MILLISECOND);
        }
        Ok(Box::new(EmulatedLink::new(self.board.clone())))
    }
    fn ask(&mut self, what: &str) -> Result<String, Failure> {
        let typed = (self.does)(&mut lock(&self.board), what);
        if what.contains("Unplug CN1 now") {
            self.is_in_at = self.now_ms() + self.out_ms;
        }
        Ok(typed)
    }
    fn pause(&mut self, ms: u64) {
        lock(&self.board).run(ms * MILLISECOND);
    }
    fn now_ms(&mut self) -> i64 {
        (lock(&self.board).chip.now / MILLISECOND) as i64
    }
}

/// Result and figure of a row of the page that this writes, and whether it gives advice for it.
fn row_of(what: &str, run: impl FnOnce(&str) -> Result<(), Failure>) -> (String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("page.md");
    let outcome = run(path.to_str().unwrap());
    let page = std::fs::read_to_string(&path).unwrap_or_default();
    let line = page.lines().find(|line| line.starts_with(&format!("| {what} | ")));
    let Some(line) = line else { panic!("no row {what}: {outcome:?}\n{page}") };
    let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
    let has_failed = cells[2] == "**FAIL**";
    // A run that settles nothing fails too, and says why.
    match &outcome {
        Err(Failure::Job(text)) if text.starts_with("nothing was measured. ") => {
            assert!(text.contains(&format!(". {what}: {}. Give the command again", cells[3])), "{text}");
            assert_eq!(cells[2], "not measured");
        }
        Err(Failure::Job(_)) => assert!(page.contains(" | **FAIL** | "), "{outcome:?}\n{page}"),
        other => assert!(
            cells[2] != "not measured" && other.is_ok() && !page.contains(" | **FAIL** | "),
            "{other:?}\n{page}"
        ),
    }
    assert_eq!(page.contains(&format!("- {what}: ")), has_failed, "advice\n{page}");
    // The counts follow.
    let table = page.split("\n## ").next().unwrap();
    let [passed, failed] = [" | pass | ", " | **FAIL** | "].map(|result| table.matches(result).count());
    let rows = if passed == 1 { "row" } else { "rows" };
    assert!(page.contains(&format!("\n{passed} {rows} passed, {failed} failed, ")), "{page}");
    println!("{line}");
    if cells[2] == "not measured" {
        return (cells[2].to_owned(), cells[3].to_owned());
    }
    // The row outlasts other runs: it has its day, and its image where that has answered.
    let (figure, when) = cells[3].rsplit_once(" (").unwrap();
    let day = when.strip_prefix("image 0.1.0-").and_then(|rest| Some(rest.split_once(", ")?.1));
    assert!(day.unwrap_or(when).starts_with("20"), "{line}");
    (cells[2].to_owned(), figure.to_owned())
}

fn by_hand(board: &Shared, what: &str, row: &str, does: impl FnMut(&mut Machine, &str) -> String) -> (String, String) {
    let mut hands = Script::new(board, does);
    row_of(row, |page| bring_up_by_hand(&mut hands, &["--hands", what, "--page", page]))
}

#[test]
fn a_debuggers_halt_is_judged_by_the_boards_clock() {
    const ROW: &str = "the watchdog while a debugger halts the core";
    for (wrong, halted, result) in
        [(None, true, "pass"), (None, false, "not measured"), (Some(Wrong::NotFrozen), true, "**FAIL**")]
    {
        let Some(board) = started("BEAMTICK_H743_IMAGE", NUCLEO, wrong) else { return };
        // Longer than the halt: else a clock that began anew could not be told.
        lock(&board).run(2200 * MILLISECOND);
        let (is, figure) = by_hand(&board, "halt", ROW, |machine, prompt| {
            assert!(prompt.contains("Halt the core") && prompt.contains("press Enter"), "{prompt}");
            if halted {
                machine.halt(2000 * MILLISECOND)
            } else {
                machine.run(10 * MILLISECOND);
            }
            String::new()
        });
        assert_eq!(is, result, "{wrong:?}: {figure}");
        let said = if wrong.is_some() { "the chip was reset" } else { figure.as_str() };
        assert_eq!(figure, said);
    }
}

#[test]
fn a_cable_that_is_unplugged_is_judged_by_the_boards_clock_and_fault() {
    const ROW: &str = "the ST-LINK's clock without a host";
    // In ms: what a hand takes before it has unplugged, and how long the cable is out.
    for (before, out, stops, result, said) in [
        (0, 10_300, false, "pass", "CN1 was out for 10.2 s, and the board's clock went on"),
        (
            9_000,
            2_000,
            false,
            "not measured",
            "`bring-up --hands unplug` saw CN1 out for 1.8 s: leave it out for 10.0 s or more",
        ),
        (0, 1_000, true, "**FAIL**", "the board was reset or had no supply"),
        // The cable was in all the time.
        (0, 0, false, "not measured", "`bring-up --hands unplug` opened its port all the same: the cable was not out"),
    ] {
        let Some(board) = started("BEAMTICK_H743_IMAGE", NUCLEO, None) else { return };
        lock(&board).run(200 * MILLISECOND);
        let mut hands = Script::new(&board, |machine: &mut Machine, prompt: &str| {
            assert!(prompt.contains("Unplug CN1 now"), "{prompt}");
            machine.run(before * MILLISECOND);
            machine.give_clock(!stops);
            String::new()
        });
        hands.out_ms = out;
        let row = row_of(ROW, |page| bring_up_by_hand(&mut hands, &["--hands", "unplug", "--page", page]));
        assert_eq!(row, (result.to_owned(), said.to_owned()));
    }
}

#[test]
fn the_clocks_guard_is_judged_by_the_first_instructions_after_it() {
    const ROW: &str = "the clock's guard breaks the timers";
    for (wrong, result, figure) in [
        (None, "pass", "MOE of TIM1 0, TIM15 0, TIM8 0 in the first instructions after it"),
        (Some(Wrong::NoClockBreak), "**FAIL**", "MOE of TIM1 1, TIM15 1, TIM8 1 in the first instructions after it"),
    ] {
        let Some(board) = started("BEAMTICK_H743_BRING_UP", NUCLEO, wrong) else { return };
        let row = by_hand(&board, "clock", ROW, |machine, prompt| {
            if prompt.contains("Enter makes both laser outputs active") {
                return String::new();
            }
            assert!(prompt.contains("Hold the ST-LINK in reset"), "{prompt}");
            machine.give_clock(false);
            machine.run(10 * MILLISECOND);
            machine.give_clock(true);
            machine.run(20 * MILLISECOND);
            String::new()
        });
        assert_eq!(row, (result.to_owned(), figure.to_owned()));
        assert_eq!(lock(&board).chip.bus.complaints, Vec::<String>::new());
    }
}

/// What the board has sent since the last call.
fn said_by(machine: &mut Machine) -> String {
    machine.take_sent().into_iter().map(|(_, byte)| char::from(byte)).collect()
}

/// A byte ends the light that waits for the clock, as B2 does. An order that was repeated before
/// there was light does not.
#[test]
fn a_byte_ends_the_light_that_waits_for_the_clock() {
    let Some(board) = started("BEAMTICK_H743_BRING_UP", NUCLEO, None) else { return };
    let mut machine = lock(&board);
    let is_lit = |change: &h743::gpio::Change, name| change.pin == pin(name) && change.level == Level::Driven(false);
    // Lines + are lit while they are low.
    let lights = |machine: &mut Machine, ms: u64| {
        let from = machine.chip.now;
        machine.run(ms * MILLISECOND);
        let all = &machine.chip.bus.gpio.changes;
        ["PE9", "PE5"].map(|name| all.iter().filter(|change| is_lit(change, name) && change.at >= from).count())
    };
    machine.send(b"lit\n");
    machine.run(20 * MILLISECOND);
    machine.send(b"lit\n");
    machine.run(100 * MILLISECOND);
    // 200 kHz.
    let [zero, one] = lights(&mut machine, 10);
    assert!((1_950..2_050).contains(&zero) && (1_950..2_050).contains(&one), "{zero} and {one} pulses");
    let resets = machine.resets.len();
    machine.take_sent();
    machine.send(&[0]);
    // To the end of the tick that sees it.
    machine.run(MILLISECOND / 5);
    assert_eq!(lights(&mut machine, 30), [0, 0]);
    assert_eq!(machine.resets.len(), resets + 1);
    let said = said_by(&mut machine);
    assert!(said.contains("# a byte has ended the light\r\n"), "{said}");
    // Nothing is said of a clock that has not stopped.
    machine.send(b"why\n");
    machine.run(20 * MILLISECOND);
    let said = said_by(&mut machine);
    assert!(said.contains("format 2*") && said.contains("end ") && !said.contains("clock-lost"), "{said}");
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
}

/// The unique number of the chip (RM0433 61.1).
const UNIQUE: u32 = 0x1ff1_e800;

#[test]
fn a_row_that_a_hand_has_settled_outlasts_the_next_run_on_the_same_chip() {
    let Some(board) = started("BEAMTICK_H743_BRING_UP", NUCLEO, None) else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("page.md");
    let words = ["--page", path.to_str().unwrap()];
    let row = || {
        let page = std::fs::read_to_string(&path).unwrap();
        page.lines().find(|line| line.starts_with("| the clock's guard breaks the timers | ")).unwrap().to_owned()
    };
    let measured = || {
        bring_up_over(Box::new(EmulatedLink::new(board.clone())), &words).unwrap();
        row()
    };
    assert!(measured().contains(" | not measured | "));
    let does = |machine: &mut Machine, prompt: &str| {
        if !prompt.contains("Hold the ST-LINK in reset") {
            return String::new();
        }
        machine.give_clock(false);
        machine.run(10 * MILLISECOND);
        machine.give_clock(true);
        machine.run(20 * MILLISECOND);
        String::new()
    };
    let mut hands = Script::new(&board, does);
    bring_up_by_hand(&mut hands, &["--hands", "clock", "--page", words[1]]).unwrap();
    let settled = row();
    assert!(settled.contains(" | pass | "), "{settled}");
    assert_eq!(measured(), settled);
    // Another chip's page is not replaced.
    assert!(lock(&board).chip.memory.load(UNIQUE, &7u32.to_le_bytes()));
    let Err(Failure::Input(text)) = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &words) else { panic!() };
    assert!(text.contains(" is of another board: nucleo-h743zi2, chip ") && text.contains("--page "), "{text}");
    assert_eq!(row(), settled);
}

/// A part for 20 MHz takes no frame of 32 MHz.
#[test]
fn voltages_of_an_external_dac_are_typed_and_judged() {
    const ROW: &str = "voltages of an external DAC";
    for (mhz, result, figure) in [
        (50, "pass", "6 voltages within 100 mV"),
        (
            20,
            "**FAIL**",
            "output 1: 0 V for 5 V; output 1: 0 V for 10 V; output 2: 0 V for 5 V; output 2: 0 V for 10 V",
        ),
    ] {
        let Some(board) = started("BEAMTICK_H743_DAC_IMAGE", NUCLEO, None) else { return };
        let row = by_hand(&board, "dac", ROW, |machine, prompt| {
            machine.run(5 * MILLISECOND);
            let of = usize::from(prompt.contains("output 2"));
            let shown = shown_up_to(&machine.chip, pin("PC11"), mhz);
            let code = shown.iter().rev().find(|(_, output, _)| *output == of).map_or(MID_SCALE, |(.., code)| *code);
            format!("{:.2} V", (f64::from(code) - f64::from(MID_SCALE)) / 3276.7)
        });
        assert_eq!(row, (result.to_owned(), figure.to_owned()));
    }
}

/// An answer that is no voltage ends the program, and leaves none.
#[test]
fn an_answer_that_is_no_voltage_leaves_the_outputs_at_0() {
    for (answer, why) in [("much", "is no voltage"), ("nan", "is beyond 100 V"), ("-1e30", "is beyond 100 V")] {
        answered_with(answer, why);
    }
}

fn answered_with(answer: &'static str, why: &str) {
    let Some(board) = started("BEAMTICK_H743_DAC_IMAGE", NUCLEO, None) else { return };
    let does = |machine: &mut Machine, _: &str| {
        machine.run(5 * MILLISECOND);
        let high = shown_up_to(&machine.chip, pin("PC11"), 50).iter().any(|(.., code)| *code > MID_SCALE);
        if high { answer.to_owned() } else { "0 V".to_owned() }
    };
    let mut hands = Script::new(&board, does);
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let failed = bring_up_by_hand(&mut hands, &["--hands", "dac", "--page", page.to_str().unwrap()]).unwrap_err();
    assert!(matches!(failed, Failure::Input(said) if said == format!("--hands: {answer} {why}")));
    let mut board = lock(&board);
    board.run(5 * MILLISECOND);
    let shown = shown_up_to(&board.chip, pin("PC11"), 50);
    let last =
        |of: usize| shown.iter().rev().find(|(_, output, _)| *output == of).map_or(MID_SCALE, |(.., code)| *code);
    assert_eq!([last(0), last(1)], [MID_SCALE; 2]);
}

/// `--answers` of this board over USB, or over its UART.
fn answers(board: &Shared, of: &str, usb: bool, row: &str) -> (String, String) {
    let link = if usb { EmulatedLink::over_usb(board.clone()) } else { EmulatedLink::new(board.clone()) };
    row_of(row, |page| bring_up_over(Box::new(link), &["--answers", of, "--page", page]))
}

#[test]
fn a_board_that_answers_settles_its_rows_and_a_silent_one_fails_them() {
    let answered = || ("pass".to_owned(), "100 calls answered".to_owned());
    let silent = || ("**FAIL**".to_owned(), "no answer".to_owned());
    const NUCLEO_ROW: &str = "USB of the Nucleo answers";
    const CRYSTAL: &str = "the module's crystal starts";
    const SESSION: &str = "USB of the module answers without VBUS";
    for (variable, on, name, row, wrong) in [
        ("BEAMTICK_H743_IMAGE", NUCLEO, "nucleo", NUCLEO_ROW, Wrong::NoDevice),
        ("BEAMTICK_H743VI_IMAGE", MODULE, "module", SESSION, Wrong::NoSession),
    ] {
        for (wrong, expected) in [(None, answered()), (Some(wrong), silent())] {
            let Some(board) = started(variable, on, wrong) else { return };
            plugged(&board);
            assert_eq!(answers(&board, name, true, row), expected, "{wrong:?}");
        }
    }
    let Some(board) = started("BEAMTICK_H743VI_IMAGE", MODULE, None) else { return };
    assert_eq!(answers(&board, "module", false, CRYSTAL), answered());
    // Over its USB a silent module may have a crystal.
    let Some(board) = started("BEAMTICK_H743VI_IMAGE", MODULE, Some(Wrong::NoSession)) else { return };
    plugged(&board);
    assert_eq!(answers(&board, "module", true, CRYSTAL).0, "not measured");
    // The bring-up image answers no call: the message names the image that is wanted, and the other
    // way round.
    let Some(board) = started("BEAMTICK_H743_BRING_UP", NUCLEO, None) else { return };
    let outcome = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &["--loads"]);
    let Err(Failure::Job(text)) = outcome else { panic!("{outcome:?}") };
    assert!(text.contains("This wants the board's own image") && text.contains("`cargo flash-board`"), "{text}");
    let Some(board) = started("BEAMTICK_H743_IMAGE", NUCLEO, None) else { return };
    let outcome = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &[]);
    let Err(Failure::Job(text)) = outcome else { panic!("{outcome:?}") };
    assert!(text.contains("Flash the bring-up image: `cargo bring-up`"), "{text}");
    // The ST-LINK's port is not CN13's, and a Nucleo is no module.
    let Some(board) = started("BEAMTICK_H743_IMAGE", NUCLEO, None) else { return };
    for (name, why) in [("nucleo", "is not CN13's"), ("module", "this board is nucleo-h743zi2")] {
        let outcome = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &["--answers", name]);
        let Err(Failure::Input(text)) = outcome else { panic!("{outcome:?}") };
        assert!(text.contains(why), "{text}");
    }
}

/// A UART's port may be another one: silence at it blames no row.
#[test]
fn a_module_whose_crystal_is_silent_is_reported_and_blames_no_row() {
    let Some(board) = started("BEAMTICK_H743VI_IMAGE", MODULE, Some(Wrong::NoSource)) else { return };
    let outcome = bring_up_over(Box::new(EmulatedLink::new(board)), &["--answers", "module"]);
    let Err(Failure::Job(text)) = outcome else { panic!("{outcome:?}") };
    assert!(text.contains("No row of the page is settled by that. Look whether this is the board's port"), "{text}");
}

const STREAM: &str = "the link's stream beside all others";
const ENDPOINTS: &str = "endpoints of USB that are set again";

/// The result of a soak's row, of a second over this link. A test for each, so that they run side
/// by side: each measures all loads before.
fn soaked(usb: bool, row: &str, wrong: Option<Wrong>, result: &str) {
    let Some(board) = started("BEAMTICK_H743_IMAGE", NUCLEO, wrong) else { return };
    if usb {
        plugged(&board);
    }
    let link = if usb { EmulatedLink::over_usb(board.clone()) } else { EmulatedLink::new(board.clone()) };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let words = ["--loads", "--soak", "1s", "--page", page.to_str().unwrap()];
    let outcome = bring_up_over(Box::new(link), &words);
    assert_eq!(outcome.is_err(), result == "**FAIL**", "{outcome:?}");
    let page = std::fs::read_to_string(&page).unwrap();
    let line = page.lines().find_map(|line| line.strip_prefix(&format!("| {row} | "))).unwrap();
    let cells: Vec<&str> = line.split(" | ").collect();
    let (is, figure) = (cells[1], cells[2]);
    assert_eq!(is, result, "{wrong:?}: {figure}");
    assert!(figure.starts_with("1 s, "), "{figure}");
}

/// A short run without any lost frame proves nothing.
#[test]
fn a_link_that_loses_no_frame_in_a_second_is_not_measured() {
    soaked(false, STREAM, None, "not measured");
}

/// Frames that a link loses under load fail the row of that link.
#[test]
fn a_link_that_loses_frames_under_load_fails_its_row() {
    soaked(false, STREAM, Some(Wrong::SpoiltBytes), "**FAIL**");
}

#[test]
fn usb_that_loses_packets_under_load_fails_its_row() {
    soaked(true, ENDPOINTS, Some(Wrong::SpoiltPackets), "**FAIL**");
}
