//! The bring-up image off its bench, and after a lock-up that did not come; the page that docs
//! show. The image that BEAMTICK_H743_BRING_UP names.
use super::{board, failed, measure, meddled, rows};
use h743::facts::Wrong;
use h743::link::lock;
use h743::{MILLISECOND, Pin};

/// Other wires close the interlock, as in a machine: no laser line goes to light, and no axis
/// steps, not even while jumpers are looked for.
#[test]
fn off_its_bench_nothing_lights_or_steps() {
    let Some(board) = board(&[], &[6]) else { return };
    let pin = |name: &str| Pin::named(name).unwrap();
    for name in ["PE15", "PE3", "PG2"] {
        lock(&board).drive(pin(name), Some(false));
    }
    let (outcome, page) = measure(&board);
    assert!(outcome.is_ok(), "{outcome:?}\n{page}");
    let low = "flag as the pin, low; jumper 6 shows both levels of TIM1, TIM15 and TIM8";
    assert_eq!(rows(&page)["break flag and level of each timer"], ("not measured", low));
    assert_eq!(rows(&page)["first edges after their tick"].0, "not measured");
    // Lines + are lit while they are low. Lines − show 8 ns of that at each break, as
    // docs/safety.md says; steps are high.
    let lit = ["PE9", "PE5", "PC7", "PC8"].map(|name| (name, false));
    let steps = ["PF8", "PF9", "PF10", "PF11", "PF12", "PF13"].map(|name| (name, true));
    let active: Vec<_> = lit.into_iter().chain(steps).map(|(name, level)| (pin(name), level)).collect();
    let machine = lock(&board);
    let changes = machine.chip.bus.gpio.changes.iter();
    let wrong: Vec<_> = changes
        .filter(|change| {
            active.iter().any(|(pin, level)| change.pin == *pin && change.level == h743::Level::Driven(*level))
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
}

/// What a lock-up has left is not taken for that of a later one which did not come.
#[test]
fn a_lock_up_that_did_not_come_shows_nothing_of_the_one_before() {
    let Some(board) = board(&[], &[]) else { return };
    let (_, page) = measure(&board);
    assert_eq!(rows(&page)["the watchdog's time"].0, "pass");
    {
        let mut machine = lock(&board);
        machine.run(50 * MILLISECOND);
        let resets = machine.resets.len();
        machine.send(b"go\n");
        while machine.resets.len() < resets + 2 {
            machine.run(MILLISECOND);
        }
        machine.run(50 * MILLISECOND);
        // The words are cleared by then; the core locks up once it has seen 24 ticks.
        machine.send(b"go\n");
        machine.run(MILLISECOND);
        assert_eq!(machine.resets.len(), resets + 2);
        machine.reset(h743::Cause::Software);
        machine.run(50 * MILLISECOND);
    }
    let (_, page) = measure(&board);
    for (row, line) in [("the watchdog's time", "watchdog"), ("a locked-up core ends light", "lock-up-0")] {
        let why = format!("the board sent no `{line}`");
        assert_eq!(rows(&page)[row], ("not measured", why.as_str()));
    }
}

/// The row of ADEN has no limit, since the image converts either way.
#[test]
fn a_converter_that_withdraws_aden_is_a_figure_and_converts() {
    let Some(board) = board(&[], &[]) else { return };
    let (outcome, page) = meddled(&board, |machine, _| machine.chip.bus.adc.withdraws = 1);
    assert_eq!((failed(&page), outcome.is_ok()), (vec![], true), "{page}");
    assert_eq!(rows(&page)["ADEN right after a calibration"], ("figure", "withdrawn"));
    assert_eq!(rows(&page)["analog inputs by analog outputs"].0, "pass");
}

/// What the example says of the page of a board that is not as assumed.
const FAILS: &str = "## Where a row fails\n\n\
    The same chip, but TIM15 starts 12 counts late: the test that writes this page plants that. The counts, the row and the\n\
    advice of that page:\n\n";

/// The lines of a page that a failed row changes, as a quotation: the counts, the row, and what to
/// change.
fn of_fails(page: &str) -> String {
    let (table, advice) = page.split_once("\n## What to change").unwrap();
    let line = |of: &str| table.lines().filter(|line| line.contains(of)).map(|line| format!("{line}\n")).collect();
    let [counts, head, failed]: [String; 3] = [" passed, ", "| row |", " **FAIL** "].map(line);
    let quoted = format!("{counts}\n{head}| --- | --- | --- | --- |\n{failed}\n**What to change**{advice}");
    quoted.lines().map(|line| format!("> {line}").trim_end().to_owned() + "\n").collect()
}

/// The page that docs show, and what of it a planted wrong fact changes: `BEAMTICK_WRITE=1` writes
/// it. Its rows and results are those of now; figures that depend on the build are not compared.
#[test]
fn the_example_page_is_what_the_emulated_chip_gives() {
    let (Some(good), Some(late)) = (board(&[], &[]), board(&[Wrong::StartsLate(15)], &[])) else { return };
    let (_, page) = measure(&good);
    println!("{} ms of the chip", lock(&good).chip.now / MILLISECOND);
    lock(&late).reset(h743::Cause::Pin);
    let (_, bad) = measure(&late);
    assert_eq!(failed(&bad), ["first edges after their tick"], "{bad}");
    let fails = of_fails(&bad);
    let name = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/bring-up-page.md");
    if std::env::var_os("BEAMTICK_WRITE").is_some() {
        let (title, rest) = page.split_once("\n\n").unwrap();
        let note =
            "An example of [bring-up](bring-up.md): the emulated chip with all jumpers. No board has been measured.";
        std::fs::write(name, format!("{title}\n\n{note}\n\n{rest}\n{FAILS}{fails}")).unwrap();
    }
    let example = std::fs::read_to_string(name).unwrap();
    let (example, example_fails) = example.split_once(FAILS).unwrap();
    let results =
        |page: &str| rows(page).into_iter().map(|(row, (result, _))| format!("{row}: {result}")).collect::<Vec<_>>();
    assert_eq!(results(example), results(&page));
    assert_eq!(example_fails, fails);
}
