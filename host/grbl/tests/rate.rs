//! How many lines a second the port takes, in real time, from a sender that counts characters.
mod common;

use client::{Client, Options};
use common::{MACHINE, Rig};
use grbl::Pace;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

/// Lines of the test that always runs, and of the one that measures.
const SOME: usize = 4000;
const MANY: usize = 200_000;
/// mm/min, at which a line of 0.05 mm lasts 50 µs.
const FEED: u32 = 60_000;

/// Streams a zigzag of lines, each with its own S: seconds that it took, and starts of the path.
fn run(lines: usize, feed: u32) -> (f64, u64) {
    let served =
        virtual_board::serve(TcpListener::bind("127.0.0.1:0").unwrap(), None, virtual_board::Config::default())
            .unwrap();
    let link = client::link::open(&format!("tcp:{}", served.address())).unwrap();
    let client = Client::open(link, Options::default()).unwrap();
    let machine = MACHINE.replace("max_rate = 12000", "max_rate = 120000").replace("acceleration = 1000", "acceleration = 20000");
    let rig = Rig::over(served.board().clone(), client, &machine, false, Pace::Real);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok(&format!("G21 G90 M4 G1 F{feed}"));
    let stream = sender.stream.try_clone().unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let began = Instant::now();
    count_characters(stream, lines);
    let took = began.elapsed().as_secs_f64();
    sender.idle();
    let last = lines - 1;
    let expected = [f64::from(x(last) as u32), f64::from((last % 3) as u32)];
    assert_eq!(rig.at(), [expected[0], -expected[1]]);
    drop(sender);
    (took, rig.end().starts)
}

/// Position of a line along X in hundredths of a mm: steps of 0.05 mm, to and fro.
fn x(line: usize) -> usize {
    let (row, column) = (line / 4000, line % 4000);
    if row % 2 == 0 { column * 5 } else { (3999 - column) * 5 }
}

/// As senders do that count: 128 bytes are on the way at most.
fn count_characters(mut stream: TcpStream, lines: usize) {
    let (mut sizes, mut bytes) = (std::collections::VecDeque::new(), 0);
    let (mut read, mut block, mut out) = ([0; 4096], Vec::new(), Vec::new());
    let mut line = 0;
    while line < lines || !sizes.is_empty() {
        out.clear();
        while line < lines {
            let text = format!("X{}.{:02}Y.0{}S{}\n", x(line) / 100, x(line) % 100, line % 3, 100 + line % 700);
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
    let (took, starts) = run(SOME, 6000);
    println!("{:.0} lines a second, {starts} starts", SOME as f64 / took);
}

#[test]
#[ignore = "measures; docs/grbl.md has the command"]
fn how_many_lines_a_second() {
    let (took, starts) = run(MANY, FEED);
    println!("{MANY} lines in {took:.2} s: {:.0} a second, {starts} starts of the path", MANY as f64 / took);
}
