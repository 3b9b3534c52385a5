//! A DAC8563 on SPI3 (data sheet SLAS719E): the outputs that follow from what the chip has sent.
//!
//! In: words of the SPI, the pin of the select line (SYNC, active low). Out: codes with the
//! instants of the last falling edge of the clock of their frames. Owns nothing. Power-on leaves
//! both outputs at mid-scale (8.3.3.2), with an external reference: its own is off until a command.
//! LDAC and CLR are taken as tied (LDAC low, CLR high). Fails: with the first frame that is no
//! write of one output (8.5.2).
use crate::gpio::{Level, Pin};
use crate::machine::Chip;
use crate::time::{Time, from_nanoseconds};

/// Of both outputs from power-on.
pub const MID_SCALE: u16 = 0x8000;

/// 50 MHz, in units of time.
const SHORTEST_BIT: Time = 20;

/// The least time for which the select line is high between two frames (7.6, "minimum SYNC high
/// time").
const BETWEEN_NS: u64 = 80;

/// Write to a DAC's input register and update that DAC (table 17).
const WRITE: u32 = 0b011;

/// An output got a code: when, which (from 0), the code.
pub type Write = (Time, usize, u16);

/// What the part does with all that it gets: a frame that a rising select line breaks off changes
/// nothing (8.5.1), and neither does a byte outside of a frame. While the chip does not drive the
/// select line, the board's resistor pulls it up.
pub fn shown(chip: &Chip, select: Pin) -> Vec<Write> {
    shown_up_to(chip, select, 50)
}

/// The same of a part whose clock may have so many MHz: it takes no frame of a faster one.
pub fn shown_up_to(chip: &Chip, select: Pin, mhz: u64) -> Vec<Write> {
    let (mut from, mut writes) = (None, Vec::new());
    if chip.bus.spi.bit().is_some_and(|bit| bit < from_nanoseconds(1000) / mhz) {
        return writes;
    }
    for change in chip.bus.gpio.changes.iter().filter(|change| change.pin == select) {
        if change.level == Level::Driven(false) {
            from.get_or_insert(change.at);
        } else if let Some(begin) = from.take() {
            let within = |(at, _): &&(Time, u32)| (begin + 1..=change.at).contains(at);
            let frame: Vec<_> = chip.bus.spi.sent.iter().filter(within).collect();
            if let [(_, head), (_, high), (at, low), ..] = frame[..]
                && head >> 3 == WRITE
                && head & 7 <= 1
            {
                writes.push((*at, (head & 7) as usize, (high << 8 | low) as u16));
            }
        }
    }
    writes
}

/// Commands to the part on this select line since power-on.
pub fn writes(chip: &Chip, select: Pin) -> Result<Vec<Write>, String> {
    let spi = &chip.bus.spi;
    if spi.sent.is_empty() {
        return Ok(Vec::new());
    }
    // Data is taken with the falling edge.
    if spi.mode() != (false, true) || spi.bit().is_none_or(|bit| bit < SHORTEST_BIT) {
        return Err(format!("mode {:?} with bits of {:?} units", spi.mode(), spi.bit()));
    }
    let mut frames: Vec<(Time, Time)> = Vec::new();
    let mut from = None;
    for change in chip.bus.gpio.changes.iter().filter(|change| change.pin == select) {
        match (change.level, from) {
            (Level::Driven(false), None) => from = Some(change.at),
            (Level::Driven(true), Some(begin)) => {
                let high = frames.last().map(|(_, end)| begin - end);
                if let Some(high) = high.filter(|high| *high < from_nanoseconds(BETWEEN_NS)) {
                    return Err(format!("the select line is high for {high} units only before {begin}"));
                }
                frames.push((begin, change.at));
                from = None;
            }
            (Level::Driven(true), None) => {}
            (level, _) => return Err(format!("the select line is {level:?}")),
        }
    }
    let mut words = spi.sent.iter().peekable();
    let mut writes = Vec::new();
    for (begin, end) in frames {
        let mut frame = Vec::new();
        while let Some((at, byte)) = words.next_if(|(at, _)| *at <= end) {
            if *at <= begin {
                return Err(format!("a byte at {at} that is in no frame"));
            }
            frame.push((*at, *byte));
        }
        let [(_, head), (_, high), (at, low)] = frame[..] else {
            return Err(format!("a frame of {} bytes at {begin}", frame.len()));
        };
        let (command, address) = (head >> 3, head & 7);
        if command != WRITE || address > 1 {
            return Err(format!("command {command:#05b} to {address} at {begin}"));
        }
        writes.push((at, address as usize, (high << 8 | low) as u16));
    }
    match words.next() {
        Some((at, _)) => Err(format!("a byte at {at} that is in no frame")),
        None => Ok(writes),
    }
}
