//! Mixed work for as long as asked: nothing drifts, no counter overflows, nothing grows.
//!
//! `LONG_RUN_TICKS` says how far it goes (`cargo xtask long-run`); a plain test run goes four
//! rounds. A round is 250 000 ticks of 250 µs of what `life/work.rs` has. Checkpoints are whole
//! passes apart, so what an axis has gone since the first one is known in exact rationals.
#[path = "life/work.rs"]
mod work;

use num_rational::BigRational;
use std::time::{Duration, Instant};
use virtual_board::{Board, Config, Shared, share};
use work::{ROUND_TICKS, SETUP, STREAM_PULSES, TICK_US, round, run};

const ROUND: Duration = Duration::from_micros(ROUND_TICKS * TICK_US);
const PT_PASS_PULSES: f64 = 400.1;
const PVT_PASS_PULSES: f64 = 12.7;
const JOG_PULSES_PER_MS: f64 = 0.7;

/// What is compared from checkpoint to checkpoint.
#[derive(Debug, Clone, PartialEq)]
struct Seen {
    ticks: u64,
    pos: [i64; 8],
    on_time: [u32; 2],
    fault: [servo::laser::Cause; 2],
    /// Bytes that the process has of memory, if the system reports it.
    memory: Option<u64>,
}

fn seen(board: &Shared) -> Seen {
    let mut board = board.lock().unwrap();
    // Edges are kept for who asks for them.
    board.take_edges();
    Seen {
        ticks: board.now() / (TICK_US * 1000),
        pos: std::array::from_fn(|axis| board.axis(axis).pos.0),
        on_time: std::array::from_fn(|channel| board.laser_view(channel).on_time),
        fault: std::array::from_fn(|channel| board.laser_view(channel).fault),
        memory: std::fs::read_to_string("/proc/self/statm")
            .ok()
            .and_then(|text| text.split(' ').nth(1)?.parse::<u64>().ok())
            .map(|pages| pages * 4096),
    }
}

/// How far from `rounds` times `way`, in 2⁻²² pulse, rounded away from zero.
fn off(gone: i64, rounds: u64, displacement: f64) -> i64 {
    let exact = BigRational::from_float(displacement).unwrap() * BigRational::from_integer(rounds.into());
    let off = BigRational::from_integer(gone.into()) - exact * BigRational::from_integer((1i64 << 22).into());
    let off = if off < BigRational::from_integer(0.into()) { off.floor() } else { off.ceil() };
    i64::try_from(off.to_integer()).unwrap()
}

#[test]
fn nothing_drifts_overflows_or_grows() {
    let ticks: u64 = std::env::var("LONG_RUN_TICKS").ok().map_or(4 * ROUND_TICKS, |text| text.parse().unwrap());
    let rounds = ticks.div_ceil(ROUND_TICKS).max(3);
    let board = share(Board::new(Config { tick_us: TICK_US as u32, ..Config::default() }));
    let client = work::client(&board);
    run(&client, SETUP);
    client.sleep(Duration::from_millis(100)).unwrap();
    let (began, start) = (Instant::now(), client.now());
    let first = seen(&board);
    let mut settled = None;
    let mut reported = Instant::now();
    for number in 0..rounds {
        run(&client, &round(number));
        let end = start + ROUND * (number as u32 + 1);
        client.sleep(end.checked_sub(client.now()).expect("a round's work is over before the round")).unwrap();
        let now = seen(&board);
        let done = number + 1;
        assert_eq!(now.ticks - first.ticks, done * ROUND_TICKS, "every checkpoint is on its tick");
        let gone: [i64; 8] = std::array::from_fn(|axis| now.pos[axis] - first.pos[axis]);
        // A knot is rounded to 2⁻²² pulse, once here and once at the first checkpoint; nothing is
        // added from pass to pass.
        assert!(off(gone[0], done * 125, PT_PASS_PULSES).abs() <= 2, "PT after {done} rounds: {now:?}");
        assert!(off(gone[1], done * 200, PVT_PASS_PULSES).abs() <= 2, "PVT after {done} rounds: {now:?}");
        // Speeds of a Jog have 2⁻⁶⁴ and better; a bound that a drift of 10⁻¹² of the way would
        // break.
        let jog = off(gone[2], done * 62_500, JOG_PULSES_PER_MS);
        assert!(jog.abs() <= 2 + (done as i64 >> 6), "Jog after {done} rounds is {jog} off: {now:?}");
        assert!((gone[3] - gone[0] * 3 / 8).abs() <= 4, "Follow after {done} rounds: {now:?}");
        assert_eq!(now.pos[4..7], [0, 0, 0], "the square and the Trap moves are closed");
        assert_eq!(off(gone[7], done, STREAM_PULSES), 0, "the stream after {done} rounds");
        assert_eq!(u64::from(now.on_time[1].wrapping_sub(first.on_time[1])), done * ROUND_TICKS, "on-time");
        assert!(now.on_time[0] > 0 && now.fault == [servo::laser::Cause::None; 2], "{now:?}");
        if done == 2 {
            settled = now.memory;
        }
        if let (Some(settled), Some(memory)) = (settled, now.memory) {
            assert!(memory <= settled + (2 << 20), "memory grew from {settled} to {memory} in {done} rounds");
        }
        if reported.elapsed() > Duration::from_secs(20) || done == rounds {
            reported = Instant::now();
            let (ticks, seconds) = (done * ROUND_TICKS, began.elapsed().as_secs_f64());
            println!("{ticks} ticks in {seconds:.0} s, Jog {jog} off, memory {:?}", now.memory);
        }
    }
}
