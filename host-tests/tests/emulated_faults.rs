//! The released image in QEMU, where BEAMTICK_IMAGE names one (`cargo xtask check-all` does):
//! faults of the program, of the link and of the order of things. Each ends dark, with the reason
//! readable afterwards.
//!
//! Faults of the program are provoked by a debugger: the image has no way of its own to do so.
#![cfg(unix)]
#[path = "faults/board.rs"]
mod board;
#[path = "faults/debugger.rs"]
mod debugger;

use board::{Board, assert_dark_until_cleared, fault, image, reason, shine, state, wait_until};
use client::Client;
use debugger::{Debugger, PC, SP, Symbols};
use protocol::command::*;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Memory of the stack that nothing uses after the start.
const SCRATCH: u32 = 0x2000_1000;

/// Where things lie in an image.
struct Map {
    symbols: Symbols,
    /// The laser's outputs: words that are all 0 at rest.
    outputs: (u32, u32),
    /// The record that outlives the reset.
    record: u32,
    /// The board's time when the last tick ended.
    time: u32,
    /// In the tick, when it has entries to execute.
    tick: u32,
    /// In the link task.
    task: u32,
}

impl Map {
    fn of(image: &Path) -> Map {
        let symbols = Symbols::of(image);
        let outputs = symbols.find(&["7outputs6LASERS"]);
        let record = symbols.find(&["5fault4KEPT"]).0;
        let tick = symbols.find(&["4tick", "Tick", "11execute_due"]).0;
        let task = symbols.find(&["6server", "Server", "4poll"]).0;
        let time = symbols.find(&["11supervision6TICKED"]).0;
        Map { symbols, outputs, record, time, tick, task }
    }

    /// Lets so much of the board's time pass, however slowly the emulator goes.
    fn pass(&self, board: &Board, ms: u64) {
        let time = || {
            let mut debugger = board.socket.attach();
            let units = debugger.read(self.time, 4);
            debugger.detach();
            u32::from_le_bytes(units.try_into().unwrap())
        };
        let begin = time();
        // Units of 2²⁰ ns, the first and the last of them in part.
        let units = (ms * 1_000_000).div_ceil(1 << 20) as u32 + 1;
        wait_until("the board's time passes", || time().wrapping_sub(begin) >= units);
    }

    fn is_dark(&self, debugger: &mut Debugger) -> bool {
        debugger.read(self.outputs.0, self.outputs.1).iter().all(|&byte| byte == 0)
    }
}

/// Where a fault is provoked.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Level {
    Tick,
    Task,
}
use Level::{Task, Tick};

/// Sets the core on a fault.
type Provoke = fn(&mut Debugger, &Map);

/// Instructions to be executed next.
fn execute(debugger: &mut Debugger, code: &[u16]) {
    debugger.write_halfwords(SCRATCH, code);
    debugger.set(PC, SCRATCH);
}

/// As if an `Option` were empty that never is. The optimiser may have left the only caller's words
/// in the function itself.
fn panic(debugger: &mut Debugger, map: &Map) {
    const TEXT: &[u8] = b"provoked";
    let (text, place) = (SCRATCH, SCRATCH + 0x100);
    debugger.write(text, TEXT);
    // A `Location`: its file's name, line, column.
    let words = [text, TEXT.len() as u32, 7, 7];
    debugger.write(place, &words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>());
    for (register, value) in (0..).zip([text, TEXT.len() as u32, place]) {
        debugger.set(register, value);
    }
    debugger.set(PC, map.symbols.find(&["6option", "13expect_failed"]).0);
}

fn undefined_instruction(debugger: &mut Debugger, _: &Map) {
    execute(debugger, &[0xde00]);
}

/// `ldr r0, [pc]; ldr r0, [r0]`: from the memory that the stack's guard forbids.
fn forbidden_access(debugger: &mut Debugger, _: &Map) {
    execute(debugger, &[0x4800, 0x6800, 0xff00, 0x1fff]);
}

/// 64 bytes are left.
fn little_stack(debugger: &mut Debugger, map: &Map) {
    debugger.set(SP, map.symbols.named("_stack_end") + 64);
}

/// Interrupt 20 is let in and made pending; then nothing.
fn unclaimed_interrupt(debugger: &mut Debugger, _: &Map) {
    // ldr r0, [pc, #12]; ldr r1, [pc, #16]; str r1, [r0]; adds r0, #255; adds r0, #1; str r1, [r0];
    // b .; nop
    let code = [0x4803, 0x4904, 0x6001, 0x30ff, 0x3001, 0x6001, 0xe7fe, 0xbf00];
    // ISER at 0xe000e100, ISPR 256 above it.
    let data = [0xe100, 0xe000, 0x0000, 0x0010];
    execute(debugger, &[&code[..], &data].concat());
}

fn endless_loop(debugger: &mut Debugger, _: &Map) {
    execute(debugger, &[0xe7fe]);
}

/// `cpsid i`, then nothing.
fn masked_interrupts(debugger: &mut Debugger, _: &Map) {
    execute(debugger, &[0xb672, 0xe7fe]);
}

/// What is provoked where, the kind that is reported, and how its text begins.
const FAULTS: [(&str, Level, Provoke, u8, &str); 12] = [
    ("panic in the tick", Tick, panic, 1, "panicked at "),
    ("panic in the link task", Task, panic, 1, "panicked at "),
    ("undefined instruction in the tick", Tick, undefined_instruction, 2, "hard fault at 0x20001000"),
    ("undefined instruction in the link task", Task, undefined_instruction, 2, "hard fault at 0x20001000"),
    ("forbidden access", Task, forbidden_access, 2, "hard fault at 0x20001002"),
    ("stack overflow in the tick", Tick, little_stack, 2, "stack overflow"),
    ("stack overflow in the link task", Task, little_stack, 2, "stack overflow"),
    ("unclaimed interrupt", Task, unclaimed_interrupt, 3, "interrupt 20 without a handler"),
    ("stuck link task", Task, endless_loop, 4, "the link task stood still"),
    ("stuck tick", Tick, endless_loop, 4, "the servo tick did not end"),
    ("masked interrupts", Task, masked_interrupts, 4, "no servo tick came"),
    ("masked interrupts in the tick", Tick, masked_interrupts, 4, "the servo tick did not end"),
];

#[test]
fn every_fault_of_the_program_ends_dark_and_reports_its_reason() {
    let Some(image) = image() else { return };
    let map = Map::of(&image);
    let board = Board::start(image, false);
    for (name, place, provoke, kind, text) in FAULTS {
        println!("{name}");
        let client = board.open();
        shine(&client);
        let mut debugger = board.socket.attach();
        assert!(!map.is_dark(&mut debugger), "{name}: light is seen in the outputs");
        std::thread::spawn(move || {
            // Something to do for tick and task; nobody answers when the board starts over.
            let _ = client.call(ZeroLaserOnTime { core: 1.into(), channel: 0.into() });
        });
        debugger.run_to(if place == Tick { map.tick } else { map.task });
        assert_eq!(debugger.in_handler(), place == Tick, "{name}");
        provoke(&mut debugger, &map);
        // Outputs rest before anything else is done, so before the record is written; start-up
        // would clear them too.
        debugger.run_until_written(map.record);
        assert!(map.is_dark(&mut debugger), "{name}: dark before the restart");
        debugger.detach();
        let client = board.open();
        let reported = reason(&client);
        assert!(reported.0 == kind && reported.1.starts_with(text), "{name}: {reported:?}");
        assert_dark_until_cleared(&client, 4);
    }
}

#[test]
fn a_tick_that_takes_too_long_shuts_off_the_light() {
    let Some(image) = image() else { return };
    let map = Map::of(&image);
    let board = Board::start(image, false);
    let client = board.open();
    shine(&client);
    let mut debugger = board.socket.attach();
    let client = std::thread::spawn(move || {
        let _ = client.call(ZeroLaserOnTime { core: 1.into(), channel: 0.into() });
        client
    });
    debugger.run_to(map.tick);
    // push {r0}; ldr r0, [pc, #12]; subs r0, #1; bne; pop {r0}; ldr.w pc, [pc, #8]: to where it
    // was. 200 000 times two instructions of 2 ns: 800 µs of a tick of 250 µs.
    let (count, back) = (200_000_u32, map.tick | 1);
    let data = [count as u16, (count >> 16) as u16, back as u16, (back >> 16) as u16];
    let code = [0xb401, 0x4803, 0x3801, 0xd1fd, 0xbc01, 0xf8df, 0xf008, 0xbf00];
    execute(&mut debugger, &[&code[..], &data].concat());
    debugger.detach();
    let client = client.join().unwrap();
    wait_until("the overrun is seen", || fault(&client, 0) == 3 && fault(&client, 1) == 3);
    assert_eq!(reason(&client).0, 0, "it did not start over");
    assert_dark_until_cleared(&client, 3);
}

#[test]
fn an_idle_client_keeps_the_link_alive_by_itself() {
    let Some(image) = image() else { return };
    let map = Map::of(&image);
    let board = Board::start(image, false);
    let client = board.open();
    shine(&client);
    map.pass(&board, 1500);
    assert_eq!((state(&client, 0).light, fault(&client, 0)), (1, 0));
}

/// The commands of a small job, whatever becomes of each. True if the second to last, the on
/// command, was answered.
fn job(client: &Client) -> bool {
    let (core, channel) = (1.into(), 0.into());
    let _ = client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() });
    let _ = client.call(LaserOutFrq { core, frequency: 20.0.into(), channel });
    let _ = client.call(LaserPrfCmd { core, power: 50.0.into(), channel });
    let lit = client.call(LaserOn { core, channel }).is_ok();
    let _ = client.call(LaserPrfCmd { core, power: 60.0.into(), channel });
    lit
}

/// The link-loss time of the cuts, ms.
const LOSS_MS: u64 = 60;

/// Opens a session over a link that is cut after so many bytes of the job.
fn cut_job(board: &Board, bytes: usize) -> (bool, Vec<u8>) {
    let mut link = board.client_link();
    let left = Arc::new(Mutex::new(usize::MAX));
    link.left = Some(Arc::clone(&left));
    let sent = Arc::clone(&link.sent);
    let client = board.open_over(link);
    client.call(SetLinkLoss { time_ms: (LOSS_MS as i32).into(), stop_all: 0.into() }).unwrap();
    sent.lock().unwrap().clear();
    *left.lock().unwrap() = bytes;
    let lit = job(&client);
    let sent = sent.lock().unwrap().clone();
    (lit, sent)
}

/// A frame ends with a zero. Cut within each frame and after it; with BEAMTICK_EVERY_BYTE set,
/// after every byte.
#[test]
fn a_link_that_is_cut_anywhere_in_a_job_ends_dark() {
    let Some(image) = image() else { return };
    let map = Map::of(&image);
    let board = Board::start(image, false);
    let (lit, sent) = cut_job(&board, usize::MAX);
    assert!(lit);
    let ends: Vec<usize> = (1..=sent.len()).filter(|&n| sent[n - 1] == 0).collect();
    assert!(ends.len() >= 5, "a frame a command: {sent:?}");
    let cuts: Vec<usize> = if std::env::var_os("BEAMTICK_EVERY_BYTE").is_some() {
        (0..=sent.len()).collect()
    } else {
        ends.iter().flat_map(|&end| [end - 3, end]).collect()
    };
    let (mut dark, mut never) = (0, 0);
    for &cut in &cuts {
        let client = board.open();
        client.call(LaserOff { core: 1.into(), channel: 0.into() }).unwrap();
        wait_until("off", || state(&client, 0).light == 0);
        if fault(&client, 0) != 0 {
            client.call(ClrLaserFault { core: 1.into(), channel: 0.into() }).unwrap();
        }
        wait_until("no fault", || fault(&client, 0) == 0);
        drop(client);
        let (lit, passed) = cut_job(&board, cut);
        if passed.len() < cut {
            // The job is over before: without a cut a frame had been sent again.
            continue;
        }
        map.pass(&board, LOSS_MS);
        let client = board.open();
        let now = state(&client, 0);
        assert_eq!((now.light, now.gate), (0, 0), "cut after {cut} bytes");
        match now.fault.get() {
            // The on command came through, and the lost link shut off its light.
            2 => dark += 1,
            // It did not, and nobody reported that it did.
            0 => {
                assert!(!lit && now.commanded == 0, "cut after {cut} bytes");
                never += 1;
            }
            other => panic!("cut after {cut} bytes: cause {other}"),
        }
    }
    println!("{} cuts in {} bytes: {dark} shut light off, {never} before light", cuts.len(), sent.len());
    assert!(dark > 0 && never > 0 && dark + never >= 6, "{dark} and {never} of {}", cuts.len());
}

#[test]
fn power_on_in_every_order_is_dark_and_then_works() {
    let Some(image) = image() else { return };
    let map = Map::of(&image);
    // The board first, the host later than the link-loss time.
    let board = Board::start(image.clone(), false);
    map.pass(&board, 800);
    let client = board.open();
    assert_eq!((state(&client, 0).light, fault(&client, 0), reason(&client).0), (0, 0, 0));
    shine(&client);

    // The host is cut off without a word, and another one comes.
    let link = board.client_link();
    drop(client);
    map.pass(&board, 500);
    let client = board.open_over(link);
    assert_eq!(reason(&client).0, 0);
    assert_dark_until_cleared(&client, 2);

    // The host takes its leave: dark at once, and the lost link finds no light to shut off.
    drop(client);
    map.pass(&board, 500);
    let client = board.open();
    assert_eq!((state(&client, 0).light, fault(&client, 0), reason(&client).0), (0, 0, 0));
    shine(&client);

    // The board is reset from outside under a host that goes on.
    let mut debugger = board.socket.attach();
    debugger.reset();
    debugger.detach();
    drop(client);
    let client = board.open();
    assert_eq!((state(&client, 0).light, fault(&client, 0), reason(&client).0), (0, 0, 0));
    shine(&client);
    drop(client);
    drop(board);

    // The host first; the interlock is active before there is power.
    let board = Board::start(image, true);
    board.switchboard().interlock(true).unwrap();
    let client = std::thread::scope(|scope| {
        let client = scope.spawn(|| board.open());
        std::thread::sleep(Duration::from_millis(300));
        assert!(!client.is_finished(), "nobody answers without power");
        board.socket.attach().detach();
        client.join().unwrap()
    });
    wait_until("the interlock is seen", || fault(&client, 0) == 1 && fault(&client, 1) == 1);
    assert!(client.call(ClrLaserFault { core: 1.into(), channel: 0.into() }).is_err());
    board.switchboard().interlock(false).unwrap();
    wait_until("it can be cleared", || client.call(ClrLaserFault { core: 1.into(), channel: 0.into() }).is_ok());
    client.call(ClrLaserFault { core: 1.into(), channel: 1.into() }).unwrap();
    assert_eq!(state(&client, 0).light, 0);
    wait_until("no fault", || fault(&client, 0) == 0 && fault(&client, 1) == 0);
    shine(&client);
}
