//! How many lines a second the port takes, in real time, from a sender that counts characters.
mod common;

use client::{Client, Options};
use common::{MACHINE, Rig};
use grbl::Pace;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

/// Lines of the test that always runs, and of the one that measures.
const SHORT_RUN_LINES: usize = 4000;
const LONG_RUN_LINES: usize = 100_000;
/// Of a row.
const ROW_LINES: usize = 10_000;

/// What a sender streams: lines of so many hundredths of a mm at F in mm/min, with so many powers
/// in turns.
#[derive(Clone, Copy)]
struct Rows {
    step: usize,
    feed: u32,
    powers: usize,
}

/// A line lasts 40 µs at F.
const ONE_POWER: Rows = Rows { step: 2, feed: 30_000, powers: 1 };
/// A change of S is an entry of its own: what the FIFO holds is half as long.
const POWERS: Rows = Rows { step: 2, feed: 30_000, powers: 100 };
/// A line lasts 45 µs at F.
const FINE: Rows = Rows { step: 1, feed: 13_200, powers: 100 };

/// How fast the port alone takes lines: `$C`, nothing moves.
fn check(lines: usize) -> f64 {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok("$C");
    sender.ok("G21 G90 M4 G1 F1000");
    let began = Instant::now();
    count_characters(sender.stream.try_clone().unwrap(), lines, ONE_POWER);
    began.elapsed().as_secs_f64()
}

/// Streams so many lines: seconds that it took, and starts of the path.
fn run(lines: usize, rows: Rows) -> (f64, u64) {
    let served =
        virtual_board::serve(TcpListener::bind("127.0.0.1:0").unwrap(), None, virtual_board::Config::default())
            .unwrap();
    let link = client::link::open(&format!("tcp:{}", served.address())).unwrap();
    let client = Client::open(link, Options::default()).unwrap();
    let machine =
        MACHINE.replace("max_rate = 12000", "max_rate = 120000").replace("acceleration = 1000", "acceleration = 50000");
    let rig = Rig::over(served.board().clone(), client, &machine, false, Pace::Real);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok(&format!("G21 G90 M4 G1 F{}", rows.feed));
    let stream = sender.stream.try_clone().unwrap();
    let began = Instant::now();
    count_characters(stream, lines, rows);
    let took = began.elapsed().as_secs_f64();
    sender.idle();
    let last = lines - 1;
    assert_eq!(rig.at(), [f64::from(x(last, rows.step) as u32), 0.0]);
    drop(sender);
    (took, rig.end().starts)
}

/// Position of a line along X in hundredths of a mm, to and fro.
fn x(line: usize, step: usize) -> usize {
    let (row, column) = (line / ROW_LINES, line % ROW_LINES);
    if row % 2 == 0 { (column + 1) * step } else { (ROW_LINES - 1 - column) * step }
}

/// As senders do that count: 128 bytes are on the way at most.
fn count_characters(mut stream: TcpStream, lines: usize, rows: Rows) {
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let (mut sizes, mut bytes) = (std::collections::VecDeque::new(), 0);
    let (mut read, mut block, mut out) = ([0; 4096], Vec::new(), Vec::new());
    let mut line = 0;
    while line < lines || !sizes.is_empty() {
        out.clear();
        while line < lines {
            let x = x(line, rows.step);
            let text = format!("G1X{}.{:02}Y0S{}\n", x / 100, x % 100, 500 + line % rows.powers);
            if bytes + text.len() > 128 {
                break;
            }
            bytes += text.len();
            sizes.push_back(text.len());
            out.extend_from_slice(text.as_bytes());
            line += 1;
        }
        stream.write_all(&out).unwrap();
        let count = stream.read(&mut read).unwrap();
        block.extend_from_slice(&read[..count]);
        while let Some(end) = block.iter().position(|byte| *byte == b'\n') {
            let answer: Vec<u8> = block.drain(..=end).collect();
            assert_eq!(answer, b"ok\r\n", "{}", String::from_utf8_lossy(&answer));
            bytes -= sizes.pop_front().unwrap();
        }
    }
}

/// On a machine that is busy otherwise the rate counts for nothing; that all arrives does.
#[test]
fn lines_that_are_counted_all_arrive() {
    let (took, starts) = run(SHORT_RUN_LINES, Rows { step: 2, feed: 6000, powers: 100 });
    println!("{:.0} lines a second, {starts} starts", SHORT_RUN_LINES as f64 / took);
}

#[test]
#[ignore = "measures; docs/grbl.md has the command"]
fn how_many_lines_a_second() {
    println!("{:.0} lines a second are read in $C", LONG_RUN_LINES as f64 / check(LONG_RUN_LINES));
    // Each change of S is an entry of the path between two motions.
    for rows in [ONE_POWER, POWERS, FINE] {
        let (took, starts) = run(LONG_RUN_LINES, rows);
        let (rate, Rows { step, feed, powers }) = (LONG_RUN_LINES as f64 / took, rows);
        println!(
            "0.0{step} mm at F{feed}, {powers} powers: {LONG_RUN_LINES} lines in {took:.2} s: {rate:.0} a second, {starts} starts of the path"
        );
    }
}
