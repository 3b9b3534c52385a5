//! Ticks of the board's own image under loads, and what has to be so before anything lights or
//! moves. The image that BEAMTICK_H743_IMAGE names.
use super::{Meddling, rows, wire};
use beamtick::{Failure, bring_up_over};
use client::{Client, Options};
use h743::facts::Wrong;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{Level, MICROSECOND, MILLISECOND, Machine, Pin};
use protocol::command::{GetSts, GetTickTime};
use protocol::values::status;
use std::sync::{Arc, Mutex};

/// The board's own image, which has started, with these jumpers; `None` without one.
fn own_image(without: &[u8], before: impl FnOnce(&mut Machine)) -> Option<Shared> {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return None;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    wire(&mut machine, without);
    before(&mut machine);
    machine.run(20 * MILLISECOND);
    Some(Arc::new(Mutex::new(machine)))
}

/// How often each of these pins has changed.
fn changes<const N: usize>(board: &Shared, names: [&str; N]) -> [usize; N] {
    let machine = lock(board);
    names.map(|name| {
        let pin = Pin::named(name).unwrap();
        machine.chip.bus.gpio.changes.iter().filter(|change| change.pin == pin).count()
    })
}

/// Steps of six axes, servo enables of two, the + lines of both lasers.
const MOVES_AND_LIGHTS: [&str; 12] =
    ["PF8", "PF9", "PF10", "PF11", "PF12", "PF13", "PG0", "PG1", "PE9", "PE5", "PC7", "PC8"];

#[test]
fn ticks_of_the_boards_own_image_are_measured_under_loads() {
    let Some(board) = own_image(&[], |_| {}) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let words = ["--loads", "--page", page.to_str().unwrap()];
    let outcome = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &words);
    let page = std::fs::read_to_string(page).unwrap_or_default();
    assert!(outcome.is_ok(), "{outcome:?}\n{page}");
    println!("{page}");
    let rows = rows(page.split("## Ticks under load").nth(1).unwrap());
    // And the stack.
    assert_eq!(rows.len(), 28 + 1);
    let (result, used) = rows["stack of this image, after all loads"];
    assert!(result == "pass" && used.ends_with(" bytes of 16352"), "{used}");
    // Here an instruction is a cycle: what docs/numbers.md says of the whole interrupt.
    let result = |load: &str, us: u32| rows[format!("{load}, tick of {us} us").as_str()].0;
    for load in ["eight axes at standstill", "two lasers at 10 kHz", "two lasers at 2 MHz", "eight axes in PVT"] {
        assert_eq!([250, 50, 20].map(|us| result(load, us)), ["pass"; 3], "{page}");
    }
    assert_eq!(result("eight axes at standstill", 10), "pass");
    assert_eq!(result("two paths, four axes in PVT, two lasers at 2 MHz that follow", 10), "does not fit");
    assert_eq!(result("eight axes in PVT, two lasers at 2 MHz", 10), "does not fit");
    assert!(rows.values().all(|(result, _)| matches!(*result, "pass" | "does not fit")), "{page}");
    assert!(page.contains("\n\nAll loads fit from 50 us on.\n"), "{page}");
    let of = format!("Board nucleo-h743zi2, image 0.1.0-{:08x}, over h743, by", protocol::SCHEMA);
    assert!(page.contains(&of) && page.contains(" by `beamtick bring-up` 0.1.0 on 2"), "{page}");
    // The axes of the paths and those in PVT have moved, and light was there.
    let moved = changes(&board, MOVES_AND_LIGHTS);
    assert!(moved[..6].iter().all(|count| *count > 1000), "{moved:?}");
    assert!(moved[8..10].iter().all(|count| *count > 1000), "{moved:?}");
    // All is as after power-on: axes are off, a limit and an alarm count.
    let client = Client::open(Box::new(EmulatedLink::new(board.clone())), Options::default()).unwrap();
    let status = |axis: i16| {
        let request = GetSts { core: 1.into(), axis: axis.into(), count: 1.into() };
        client.call_items(request, &[]).unwrap().1[0].value.get() as u32
    };
    for (axis, pin, flag) in [(5i16, "PE10", status::LIMIT_POSITIVE), (5, "PC0", status::ALARM)] {
        assert_eq!(status(axis) & (flag | status::SERVO_ON), 0, "{pin}");
        lock(&board).drive(Pin::named(pin).unwrap(), Some(true));
        lock(&board).run(2 * MILLISECOND);
        assert_eq!(status(axis) & flag, flag, "{pin}");
    }
    assert_eq!(lock(&board).chip.bus.complaints, Vec::<String>::new());
}

/// A core that takes three cycles an instruction: what does not fit a tick is not run, which fails
/// at 50 us and is no fault at 20 and 10. One tick of the first load is made longer than its
/// period: its row shows that overrun, and how long the tick was.
#[test]
fn a_tick_longer_than_its_period_is_shown_and_a_load_that_does_not_fit_is_not_run() {
    /// The interrupt of TIM2, as an exception; TIM2_ARR in ticks of 250 us.
    const TICK: usize = 16 + 28;
    const ARR: (u32, u32) = (0x4000_002c, 59_999);
    let Some(board) = own_image(&[], |machine| machine.plant(Wrong::SlowCore(3))) else { return };
    let (mut began, mut is_done) = (None, false);
    let meddle = move |machine: &mut Machine, _: u32| {
        let now = machine.chip.now;
        if machine.chip.bus.read(ARR.0, now, &mut machine.chip.scs.exceptions) == Some(ARR.1) {
            // The load has begun by then, and is still measured.
            let began = *began.get_or_insert(now);
            if !is_done && now > began + 50 * MILLISECOND {
                while machine.running() != TICK {
                    machine.run(1);
                }
                // It has acknowledged its timer's event by then, and takes 15 us.
                machine.run(10 * MICROSECOND);
                assert_eq!(machine.running(), TICK);
                machine.chip.now += 260 * MICROSECOND;
                is_done = true;
            }
        }
    };
    let link =
        Meddling { link: EmulatedLink::new(board.clone()), board: board.clone(), meddle, steps: 0, heard: Vec::new() };
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let outcome = bring_up_over(Box::new(link), &["--loads", "--page", page.to_str().unwrap()]);
    let page = std::fs::read_to_string(page).unwrap_or_default();
    println!("{outcome:?}\n{page}");
    assert!(matches!(outcome, Err(Failure::Job(_))), "{outcome:?}\n{page}");
    let rows = rows(page.split("## Ticks under load").nth(1).unwrap());
    let row = |load: &str, us: u32| rows[format!("{load}, tick of {us} us").as_str()];
    let (result, figure) = row("eight axes at standstill", 250);
    assert_eq!(result, "**FAIL**", "{page}");
    assert!(figure.starts_with("overrun: 1 tick took too long or came too late; median "), "{figure}");
    let worst: f64 = figure.split("worst ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((260.0..300.0).contains(&worst), "{figure}");
    // The others at that tick ran, and passed.
    const LONGEST: &str = "two paths, four axes in PVT, two lasers at 2 MHz that follow";
    assert_eq!(row(LONGEST, 250).0, "pass", "{page}");
    assert_eq!(row("eight axes at standstill", 50).0, "pass", "{page}");
    for (us, result) in [(50, "**FAIL**"), (20, "does not fit"), (10, "does not fit")] {
        let (is, figure) = row(LONGEST, us);
        assert_eq!(is, result, "{page}");
        assert!(figure.starts_with("not run: about "), "{figure}");
    }
    let (is, figure) = row("eight axes at standstill", 10);
    assert!(is == "does not fit" && figure.starts_with("not run: about 1"), "{figure}");
    assert!(page.contains("give that load a longer tick (`GT_SetTick`)"), "{page}");
    // The tick is as it was.
    let client = Client::open(Box::new(EmulatedLink::new(board.clone())), Options::default()).unwrap();
    assert_eq!(client.call(GetTickTime {}).unwrap().period_ns.get(), 50_000);
}

/// A board whose interlock is no jumper at output 5 may be in a machine: nothing lights or moves
/// there, and a page of before stays.
#[test]
fn without_jumper_6_nothing_lights_or_moves() {
    const BEFORE: &str = "# Bring-up\n\n\
        Board a, bring-up image b, chip c, by `beamtick bring-up` 0.1.0 on 2026-01-01.\n\n\
        1 row passed, 0 failed, 0 figures, 0 not measured. A number in the second column is a row of \
        docs/board-assumptions.md.\n\n| row | assumption | result | figure |\n| --- | --- | --- | --- |\n\
        | package of the chip | 30 | pass | PKG 2 |\n";
    let ground = |machine: &mut Machine| {
        ["PE15", "PE3", "PG2"].iter().for_each(|name| machine.drive(Pin::named(name).unwrap(), Some(false)));
    };
    let stays = "the interlock stays closed while output 5 is high: something else than jumper 6 closes it";
    let open = "the lasers are kept dark: the interlock is open";
    for (tie, found) in [(&ground as &dyn Fn(&mut Machine), stays), (&|_: &mut Machine| {}, open)] {
        let Some(board) = own_image(&[6], tie) else { return };
        let before = changes(&board, MOVES_AND_LIGHTS);
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        std::fs::write(&page, BEFORE).unwrap();
        let words = ["--loads", "--page", page.to_str().unwrap()];
        let outcome = bring_up_over(Box::new(EmulatedLink::new(board.clone())), &words);
        let Err(Failure::Job(text)) = &outcome else { panic!("{outcome:?}") };
        assert!(text.starts_with(found) && text.contains("Nothing was moved or lit. Take this board off"), "{text}");
        assert_eq!(changes(&board, MOVES_AND_LIGHTS), before, "{found}");
        // Output 5 is low, as it was.
        assert_eq!(lock(&board).chip.bus.gpio.level(Pin::named("PG14").unwrap()), Level::Driven(false));
        assert_eq!(std::fs::read_to_string(&page).unwrap(), BEFORE);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
