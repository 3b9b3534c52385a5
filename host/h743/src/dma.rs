//! DMA1, DMA2 and the request multiplexer before them, DMAMUX1 (RM0433 15 and 17).
//!
//! In: registers, requests of peripherals. Out: data to and from peripherals ([`Signal::Store`];
//! [`Signal::Fetch`] and [`Dma::take`]), interrupts. Owns the streams and the data that they have
//! read ahead. In direct mode a stream to a peripheral holds the next item before its request, with
//! the FIFO on up to 16 bytes. So data that is written to memory too late is not sent.
//!
//! A controller serves one stream at a time: [`ANSWER`] bus cycles from a request to its transfer,
//! [`TRANSFER`] until the next one; the more urgent stream first, of equals the lower. A request
//! that comes while the one before still waits is lost, as in the chip, and reported. Not modelled,
//! and complaints: memory to memory, bursts of several items a request, the peripheral as flow
//! controller, synchronised and generated requests.
use crate::clocks::Clocks;
use crate::device::{Device, Signal};
use crate::memory::Memory;
use crate::time::{NEVER, Time};
use std::collections::VecDeque;
use std::sync::Arc;

/// Bus cycles from a request to its transfer: synchronisation in DMAMUX and the peripheral,
/// arbitration, the bridge to an APB at half the clock. The manual gives no number; this is of the
/// order of AN4031's.
pub const ANSWER: Time = 12;
/// Bus cycles that a transfer keeps a controller busy.
pub const TRANSFER: Time = 8;

/// Streams of both controllers; DMAMUX1 channel n feeds the n-th.
const STREAMS: usize = 16;
/// Interrupts (RM0433 table 148).
const LINES: [usize; STREAMS] = [11, 12, 13, 14, 15, 16, 17, 47, 56, 57, 58, 59, 60, 68, 69, 70];

const EN: u32 = 1 << 0;
const PFCTRL: u32 = 1 << 5;
const TO_PERIPHERAL: u32 = 1;
const CIRC: u32 = 1 << 8;
const PINC: u32 = 1 << 9;
const MINC: u32 = 1 << 10;
const DBM: u32 = 1 << 18;
const CT: u32 = 1 << 19;
/// PBURST, MBURST. The memory's side makes no difference here.
const PBURST: u32 = 3 << 21;
const DMDIS: u32 = 1 << 2;
/// Requests of UARTs, the first and the last of each group (RM0433 table 121), whose streams want
/// TRBUFF (15.5.5, ES0392).
const UARTS: [(u8, u8); 4] = [(41, 46), (63, 66), (71, 72), (79, 82)];
const TRBUFF: u32 = 1 << 20;
/// Bytes of a stream's FIFO.
const FIFO: usize = 16;

const DMEIF: u32 = 1 << 2;
const TEIF: u32 = 1 << 3;
const HTIF: u32 = 1 << 4;
const TCIF: u32 = 1 << 5;

/// A stream.
#[derive(Debug, Clone, Default)]
struct Stream {
    cr: u32,
    /// Items as written, and those left of this pass.
    count: u32,
    left: u32,
    par: u32,
    memory: [u32; 2],
    fcr: u32,
    flags: u32,
    /// When it was asked.
    asked: Option<Time>,
    /// Bytes read ahead.
    ahead: VecDeque<u8>,
    /// Bytes of this pass that have been read ahead, and the buffer they come from.
    read: u32,
    target: usize,
}

impl Stream {
    /// As after a reset: FTH is 1 (RM0433 15.5.10).
    fn initial() -> Stream {
        Stream { fcr: 1, ..Stream::default() }
    }

    fn direction(&self) -> u32 {
        self.cr >> 6 & 3
    }

    /// Bytes of an item on the peripheral's side.
    fn size(&self) -> u32 {
        1 << (self.cr >> 11 & 3)
    }

    /// Bytes of an access to memory: in direct mode that of the peripheral's side.
    fn memory_size(&self) -> u32 {
        if self.is_direct() { self.size() } else { 1 << (self.cr >> 13 & 3) }
    }

    fn is_direct(&self) -> bool {
        self.fcr & DMDIS == 0
    }

    fn is_endless(&self) -> bool {
        self.cr & (CIRC | DBM) != 0
    }

    /// The value that `left` counts down from: NDTR as it was written, in every pass.
    fn round(&self) -> u32 {
        self.count * self.size()
    }

    fn line(&self) -> bool {
        // DMEIE, TEIE, HTIE, TCIE lie a bit lower than their flags.
        self.flags & self.cr << 1 & (DMEIF | TEIF | HTIF | TCIF) != 0
    }

    /// Reads from memory as far as there is room. False where a DMA reaches none.
    fn read_ahead(&mut self, memory: &Memory) -> bool {
        let step = self.memory_size();
        let room = if self.is_direct() { self.size() as usize } else { FIFO };
        while self.ahead.len() + step as usize <= room {
            if self.read >= self.round() {
                if !self.is_endless() {
                    return true;
                }
                self.read = 0;
                self.target ^= usize::from(self.cr & DBM != 0);
            }
            let offset = if self.cr & MINC != 0 { self.read } else { 0 };
            let address = self.memory[self.target] + offset;
            match memory.bytes(address, step).filter(|_| memory.is_reached_by_dma(address)) {
                Some(bytes) => self.ahead.extend(bytes),
                None => return false,
            }
            self.read += step;
        }
        true
    }

    /// An item has passed on the peripheral's side.
    fn pass(&mut self) {
        self.left -= 1;
        if self.left == self.count / 2 {
            self.flags |= HTIF;
        }
        if self.left == 0 {
            self.flags |= TCIF;
            if self.is_endless() {
                self.left = self.count;
                if self.cr & DBM != 0 {
                    self.cr ^= CT;
                }
            } else {
                self.cr &= !EN;
            }
        }
    }
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Dma {
    memory: Arc<Memory>,
    streams: [Stream; STREAMS],
    mux: [u32; STREAMS],
    /// Requests that no stream has taken, by their numbers.
    standing: u128,
    cycle: Time,
    /// Bus cycles from a request to its transfer: [`ANSWER`], unless a test wants others.
    pub answer: Time,
    /// Bus cycles until the next one: [`TRANSFER`] likewise.
    pub busy: Time,
    /// A request whose transfers come later, and the time from it to each of them.
    pub slow: Option<(u8, Time)>,
    /// A request whose data never reach memory.
    pub loses: Option<u8>,
    /// TRBUFF reads as 0.
    pub lacks_buffer: bool,
    /// When each controller is free again.
    free: [Time; 2],
    /// Requests that came while the one before still waited.
    pub lost: u64,
    /// Items that passed.
    pub passed: u64,
    /// What was set or happened against the manual, or is not modelled.
    pub complaint: Option<String>,
}

impl Dma {
    /// As after a reset.
    pub fn new(memory: Arc<Memory>) -> Dma {
        Dma {
            memory,
            streams: std::array::from_fn(|_| Stream::initial()),
            mux: [0; STREAMS],
            standing: 0,
            cycle: Clocks::RESET.bus,
            answer: ANSWER,
            busy: TRANSFER,
            slow: None,
            loses: None,
            lacks_buffer: false,
            free: [0; 2],
            lost: 0,
            passed: 0,
            complaint: None,
        }
    }

    fn name(n: usize) -> String {
        format!("DMA{} stream {}", n / 8 + 1, n % 8)
    }

    fn complain(&mut self, n: usize, what: &str) {
        self.complaint.get_or_insert_with(|| format!("{}: {what}", Dma::name(n)));
    }

    /// What streams that are on read or write of memory: first address and bytes.
    pub fn spans(&self) -> Vec<(u32, u32)> {
        let on = self.streams.iter().filter(|stream| stream.cr & EN != 0);
        let of = |stream: &Stream| {
            let buffers = if stream.cr & DBM != 0 { 2 } else { 1 };
            let size = if stream.cr & MINC != 0 { stream.round() } else { stream.size() };
            stream.memory.into_iter().take(buffers).map(move |base| (base, size)).collect::<Vec<_>>()
        };
        on.flat_map(of).collect()
    }

    /// A peripheral makes a request. If no stream is on for it, the request stays pending until one
    /// is.
    pub fn request(&mut self, number: u8, at: Time) {
        let mut heard = false;
        for n in 0..STREAMS {
            if self.mux[n] & 0x7f != u32::from(number) || self.streams[n].cr & EN == 0 {
                continue;
            }
            heard = true;
            let is_uart = UARTS.iter().any(|(first, last)| (*first..=*last).contains(&number));
            if is_uart != (self.streams[n].cr & TRBUFF != 0) {
                self.complain(n, "TRBUFF is for UARTs, and for them alone");
            }
            if self.streams[n].asked.is_some() {
                self.lost += 1;
                self.complain(n, "a request came while the one before still waited");
            } else {
                self.streams[n].asked = Some(at);
            }
        }
        self.standing |= u128::from(!heard) << (number & 0x7f);
    }

    /// It does not ask any more.
    pub fn withdraw(&mut self, number: u8) {
        self.standing &= !(1 << (number & 0x7f));
        for n in 0..STREAMS {
            if self.mux[n] & 0x7f == u32::from(number) {
                self.streams[n].asked = None;
            }
        }
    }

    /// The stream of this request begins anew with its first item.
    pub fn rewind(&mut self, number: u8) {
        let memory = self.memory.clone();
        for (stream, mux) in self.streams.iter_mut().zip(self.mux) {
            if mux & 0x7f == u32::from(number) && stream.cr & EN != 0 && stream.direction() == TO_PERIPHERAL {
                (stream.left, stream.read) = (stream.count, 0);
                stream.ahead.clear();
                stream.read_ahead(&memory);
            }
        }
    }

    /// A stream that is on takes a pending request.
    fn hear(&mut self, n: usize, at: Time) {
        let bit = 1u128 << (self.mux[n] & 0x7f);
        let stream = &mut self.streams[n];
        if stream.cr & EN != 0 && self.standing & bit != 0 && stream.asked.is_none() {
            self.standing &= !bit;
            stream.asked = Some(at);
        }
    }

    /// Time from a request of a stream to its transfer.
    fn answer_of(&self, n: usize) -> Time {
        let slow = self.slow.filter(|(request, _)| self.mux[n] & 0x7f == u32::from(*request));
        slow.map_or(self.answer * self.cycle, |(_, answer)| answer)
    }

    /// When a controller serves the next stream, and which.
    fn due(&self, controller: usize) -> Option<(Time, usize)> {
        let of = controller * 8..controller * 8 + 8;
        let ready = |n: usize| self.streams[n].asked.map(|at| (at + self.answer_of(n)).max(self.free[controller]));
        let first = of.clone().filter_map(ready).min()?;
        let urgency = |&n: &usize| (3 - (self.streams[n].cr >> 16 & 3), n);
        let chosen = of.filter(|&n| ready(n).is_some_and(|at| at <= first)).min_by_key(urgency)?;
        Some((first, chosen))
    }

    fn serve(&mut self, n: usize, at: Time, out: &mut Vec<Signal>) {
        self.free[n / 8] = at + self.busy * self.cycle;
        self.passed += 1;
        let memory = self.memory.clone();
        let stream = &mut self.streams[n];
        stream.asked = None;
        let size = stream.size();
        let step = if stream.cr & PINC != 0 { (stream.count - stream.left) * size } else { 0 };
        let address = stream.par + step;
        if stream.direction() == TO_PERIPHERAL {
            let item = stream.ahead.drain(..(size as usize).min(stream.ahead.len()));
            let value = item.rev().fold(0, |value, byte| value << 8 | u32::from(byte));
            out.push(Signal::Store { address, size, value });
            stream.pass();
            if stream.cr & EN != 0 && !stream.read_ahead(&memory) {
                self.fail(n);
            }
        } else {
            out.push(Signal::Fetch { address, size, stream: n as u8 });
        }
        self.report(n, out);
    }

    /// Data that a stream has fetched from its peripheral is written to memory.
    pub fn take(&mut self, n: u8, value: u32, out: &mut Vec<Signal>) {
        let n = usize::from(n);
        let stream = &mut self.streams[n];
        let size = stream.size();
        let offset = if stream.cr & MINC != 0 { (stream.count - stream.left) * size } else { 0 };
        let address = stream.memory[usize::from(stream.cr & DBM != 0 && stream.cr & CT != 0)] + offset;
        stream.pass();
        let bytes = &value.to_le_bytes()[..size as usize];
        let is_lost = self.loses.is_some_and(|number| self.mux[n] & 0x7f == number.into());
        if !self.memory.is_reached_by_dma(address) || !is_lost && !self.memory.load(address, bytes) {
            self.fail(n);
        }
        self.report(n, out);
    }

    /// A bus error: the stream is switched off (RM0433 15.3.19).
    fn fail(&mut self, n: usize) {
        let stream = &mut self.streams[n];
        stream.flags |= TEIF;
        stream.cr &= !EN;
        stream.asked = None;
        self.complain(n, "it reaches no memory at its address");
    }

    fn report(&self, n: usize, out: &mut Vec<Signal>) {
        out.push(Signal::Line(LINES[n], self.streams[n].line()));
    }

    fn control(&mut self, n: usize, value: u32) {
        let memory = self.memory.clone();
        let stream = &mut self.streams[n];
        let was_on = stream.cr & EN != 0;
        // While it is on, only EN and the interrupts' enables can be written (RM0433 15.5.5).
        let fixed = if was_on { !0x1f } else { 0 };
        let refused = was_on && (stream.cr ^ value) & fixed & !CT != 0 && value & EN != 0;
        stream.cr = stream.cr & fixed | value & !fixed & 0x01ff_ffff;
        if value & EN == 0 {
            stream.asked = None;
            if was_on {
                // Its end is signalled, also when software ends it (RM0433 15.3.15).
                stream.flags |= TCIF;
            }
            return;
        }
        if was_on {
            if refused {
                self.complain(n, "its settings are written while it is on");
            }
            return;
        }
        if stream.count == 0 {
            stream.cr &= !EN;
            return self.complain(n, "it is switched on without items");
        }
        if stream.flags != 0 {
            self.complain(n, "it is switched on with flags that were not cleared");
        }
        let stream = &mut self.streams[n];
        stream.left = stream.count;
        stream.read = 0;
        stream.target = usize::from(stream.cr & DBM != 0 && stream.cr & CT != 0);
        stream.ahead.clear();
        stream.asked = None;
        let other = stream.cr & (PFCTRL | PBURST) != 0 || stream.direction() > TO_PERIPHERAL;
        let aligned = stream.memory[0].is_multiple_of(stream.memory_size()) && stream.par.is_multiple_of(stream.size());
        let reaches = stream.direction() != TO_PERIPHERAL || stream.read_ahead(&memory);
        if other {
            self.complain(n, "it is set to what is not modelled");
        }
        if !aligned {
            self.complain(n, "its addresses are no multiples of its items' sizes");
        }
        if !reaches {
            self.fail(n);
        }
    }

    fn controller_read(&self, controller: usize, offset: u32) -> Option<u32> {
        let first = controller * 8;
        if let 0x00 | 0x04 = offset {
            let half = first + offset as usize;
            return Some((0..4).fold(0, |all, n| all | self.streams[half + n].flags << SHIFTS[n]));
        }
        let place = offset.checked_sub(0x10).filter(|place| *place < 8 * 24);
        let Some(place) = place else { return matches!(offset, 0x08 | 0x0c).then_some(0) };
        let stream = &self.streams[first + place as usize / 24];
        Some(match place % 24 {
            0x00 => stream.cr,
            0x04 => stream.left,
            0x08 => stream.par,
            0x0c => stream.memory[0],
            0x10 => stream.memory[1],
            // FS says how full it is.
            _ => stream.fcr | if stream.ahead.is_empty() { 4 << 3 } else { 0 },
        })
    }

    fn controller_write(
        &mut self,
        controller: usize,
        offset: u32,
        value: u32,
        at: Time,
        out: &mut Vec<Signal>,
    ) -> Option<()> {
        let first = controller * 8;
        match offset {
            0x00 | 0x04 => return Some(()),
            0x08 | 0x0c => {
                let half = first + (offset - 0x08) as usize;
                for (n, shift) in SHIFTS.into_iter().enumerate() {
                    self.streams[half + n].flags &= !(value >> shift);
                    self.report(half + n, out);
                }
                return Some(());
            }
            _ => {}
        }
        let place = offset.checked_sub(0x10).filter(|place| *place < 8 * 24)?;
        let n = first + place as usize / 24;
        if place % 24 == 0 {
            self.control(n, value);
            self.hear(n, at);
            self.report(n, out);
            return Some(());
        }
        let stream = &mut self.streams[n];
        let (on, other) = (stream.cr & EN != 0, usize::from(stream.cr & CT == 0));
        let register = place % 24;
        // The buffer that is not in use may be changed (RM0433 15.3.13).
        let is_other =
            matches!(register, 0x0c | 0x10) && stream.cr & DBM != 0 && (register as usize - 0x0c) / 4 == other;
        if on && !is_other {
            self.complain(n, "its settings are written while it is on");
            return Some(());
        }
        match register {
            0x04 => {
                stream.count = value & 0xffff;
                stream.left = stream.count;
            }
            0x08 => stream.par = value,
            0x0c => stream.memory[0] = value,
            0x10 => stream.memory[1] = value,
            _ => stream.fcr = value & 0x87,
        }
        Some(())
    }
}

/// Where the flags of four streams lie in their register.
const SHIFTS: [u32; 4] = [0, 6, 16, 22];

impl Device for Dma {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        match offset {
            0x000..0x800 => {
                let value = self.controller_read((offset / 0x400) as usize, offset % 0x400);
                let is_control = offset % 0x400 >= 0x10 && (offset % 0x400 - 0x10).is_multiple_of(0x18);
                value.map(|value| if self.lacks_buffer && is_control { value & !TRBUFF } else { value })
            }
            0x800..0x840 => Some(self.mux[(offset - 0x800) as usize / 4]),
            // Overruns of synchronised requests.
            0x880 | 0x884 => Some(0),
            _ => None,
        }
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, out: &mut Vec<Signal>) -> Option<()> {
        let before = self.read(offset, at, out)?;
        let value = before & !mask | value & mask;
        match offset {
            0x000..0x800 => self.controller_write((offset / 0x400) as usize, offset % 0x400, value, at, out),
            0x800..0x840 => {
                let n = (offset - 0x800) as usize / 4;
                self.mux[n] = value;
                if value & !0x7f != 0 {
                    self.complain(n, "synchronised requests are not modelled");
                }
                self.hear(n, at);
                Some(())
            }
            _ => Some(()),
        }
    }

    fn next(&self) -> Time {
        (0..2).filter_map(|controller| self.due(controller)).map(|(at, _)| at).min().unwrap_or(NEVER)
    }

    fn advance(&mut self, to: Time, out: &mut Vec<Signal>) {
        for controller in 0..2 {
            if let Some((at, n)) = self.due(controller)
                && at <= to
            {
                self.serve(n, at, out);
            }
        }
    }

    fn reset(&mut self, _: Time, out: &mut Vec<Signal>) {
        let (complaint, lost) = (self.complaint.take(), self.lost);
        let kept = (self.loses, self.lacks_buffer, self.slow);
        let (cycle, answer, busy, passed) = (self.cycle, self.answer, self.busy, self.passed);
        *self = Dma { cycle, answer, busy, passed, ..Dma::new(self.memory.clone()) };
        (self.loses, self.lacks_buffer, self.slow) = kept;
        (self.complaint, self.lost) = (complaint, lost);
        (0..STREAMS).for_each(|n| self.report(n, out));
    }

    fn clocks(&mut self, clocks: &Clocks, _: Time) {
        self.cycle = clocks.bus;
    }
}
