//! Timers TIM1 to TIM8 and TIM15 to TIM17 (RM0433 38 to 41): up-counting, output compare,
//! complementary outputs with break, repetition, preload, DMA requests with bursts. Of the slave
//! modes they have the encoder's and the start by a trigger; captures take edges of a channel's own
//! input.
//!
//! In: registers, instants, the break input, an encoder's levels, triggers. Out: the levels of
//! outputs at exact instants, interrupts, DMA requests, triggers. Owns the state of a timer. The
//! counter is not stepped: its value follows from when it was 0, so a period costs its events only.
//! Fails: what is not modelled (down-counting, other triggers, other captures, dead time) is a
//! complaint.
mod output;
mod registers;

use crate::clocks::Clocks;
use crate::device::{Device, Signal, Source};
use crate::facts::Quirks;
use crate::time::{NEVER, Time};
use output::{Break, Channel};

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const SMCR: u32 = 0x08;
const DIER: u32 = 0x0c;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const CCMR1: u32 = 0x18;
const CCMR2: u32 = 0x1c;
const CCER: u32 = 0x20;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2c;
const RCR: u32 = 0x30;
const CCR1: u32 = 0x34;
const CCR4: u32 = 0x40;
const BDTR: u32 = 0x44;
const DCR: u32 = 0x48;
const DMAR: u32 = 0x4c;
const AF1: u32 = 0x60;
const TISEL: u32 = 0x68;

const CEN: u32 = 1 << 0;
const UDIS: u32 = 1 << 1;
const URS: u32 = 1 << 2;
const OPM: u32 = 1 << 3;
const ARPE: u32 = 1 << 7;
/// Down-counting, centre alignment: not modelled.
const CR1_OTHER: u32 = 1 << 4 | 3 << 5;
/// CR2.MMS: source of the trigger output.
const MMS_ENABLE: u32 = 1;
const MMS_UPDATE: u32 = 2;
const UIF: u32 = 1 << 0;
const BIF: u32 = 1 << 7;
/// The chip breaks: TIM1 and TIM8 have it.
const SBIF: u32 = 1 << 13;

/// Counts by which a filter of eight samples delays an input.
const FILTER_COUNTS: Time = 8;

/// What of a timer differs from the others.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Its number.
    pub number: u8,
    /// Interrupts: update, compare, break. One line may serve several.
    pub lines: [usize; 3],
    /// DMAMUX requests: channels 1 to 4, update; 0 where there is none.
    pub requests: [u8; 5],
    /// Whether it has BDTR and RCR.
    pub advanced: bool,
    /// Whether it counts in 32 bits.
    pub wide: bool,
    /// Whether it is clocked by APB 2.
    pub fast: bool,
}

/// The timers (RM0433 tables 148 and 121).
pub const KINDS: [Kind; 11] = {
    const fn kind(number: u8, lines: [usize; 3], requests: [u8; 5]) -> Kind {
        let advanced = matches!(number, 1 | 8 | 15..);
        Kind { number, lines, requests, advanced, wide: matches!(number, 2 | 5), fast: advanced }
    }
    [
        kind(1, [25, 27, 24], [11, 12, 13, 14, 15]),
        kind(2, [28; 3], [18, 19, 20, 21, 22]),
        kind(3, [29; 3], [23, 24, 25, 26, 27]),
        kind(4, [30; 3], [29, 30, 31, 0, 32]),
        kind(5, [50; 3], [55, 56, 57, 58, 59]),
        kind(6, [54; 3], [0, 0, 0, 0, 69]),
        kind(7, [55; 3], [0, 0, 0, 0, 70]),
        kind(8, [44, 46, 43], [47, 48, 49, 50, 51]),
        kind(15, [116; 3], [105, 0, 0, 0, 106]),
        kind(16, [117; 3], [109, 0, 0, 0, 110]),
        kind(17, [118; 3], [111, 0, 0, 0, 112]),
    ]
};

/// Masters at the inputs ITR0 to ITR3 of a timer (RM0433 tables 331, 338, 345); those of TIM15 but
/// the first two are channels.
pub const TRIGGERS: [(u8, &[u8]); 6] = [
    (1, &[15, 2, 3, 4]),
    (2, &[1, 8, 3, 4]),
    (3, &[1, 2, 15, 4]),
    (4, &[1, 2, 3, 8]),
    (8, &[1, 2, 4, 5]),
    (15, &[1, 3]),
];

/// See the module text.
#[derive(Debug, Clone)]
pub struct Timer {
    /// Which one it is.
    pub kind: Kind,
    cr1: u32,
    cr2: u32,
    smcr: u32,
    dier: u32,
    sr: u32,
    psc: u32,
    arr: u32,
    rcr: u32,
    dcr: u32,
    others: [u32; 3],
    /// In force: prescaler, reload value, repetitions left.
    divider: u32,
    top: u32,
    repeat: u32,
    channels: [Channel; 4],
    brake: Break,
    kernel: Time,
    /// While it counts: when it was 0.
    epoch: i64,
    /// While it does not count: its value. While it counts: the value at the last write, or 0 in a
    /// new cycle.
    held: u32,
    /// The next transfer of a burst through DMAR.
    burst: u32,
    /// The request that a burst repeats until its last transfer.
    burst_asks: u8,
    levels: [[Option<bool>; 2]; 4],
    /// Levels at the inputs.
    inputs: [bool; 4],
    /// When an encoder moved last, and the count before that.
    moved: (Time, u32),
    /// Until when outputs that were disabled have their inactive levels.
    settles: Option<Time>,
    /// When it starts after a trigger, if it starts late.
    starts: Time,
    /// When the break input takes a level, and which, if it is late.
    breaks: (Time, bool),
    /// 1000 cycles of MCO1, if it is on, and when the next edge of it is captured.
    mco1: Option<Time>,
    edge: Time,
    /// BKINP means the opposite: sources differ on it.
    pub is_odd: bool,
    /// What is planted.
    pub quirks: Quirks,
    /// What was set that is not modelled.
    pub complaint: Option<String>,
}

impl Timer {
    /// As after a reset.
    pub fn new(kind: Kind) -> Timer {
        let top = if kind.wide { u32::MAX } else { 0xffff };
        Timer {
            kind,
            cr1: 0,
            cr2: 0,
            smcr: 0,
            dier: 0,
            sr: 0,
            psc: 0,
            arr: top,
            rcr: 0,
            dcr: 0,
            others: [0; 3],
            divider: 0,
            top,
            repeat: 0,
            channels: [Channel::default(); 4],
            brake: Break::default(),
            kernel: 15,
            epoch: 0,
            held: 0,
            burst: 0,
            burst_asks: 0,
            levels: [[None; 2]; 4],
            inputs: [false; 4],
            moved: (0, 0),
            settles: None,
            starts: NEVER,
            breaks: (NEVER, false),
            mco1: None,
            edge: NEVER,
            is_odd: false,
            quirks: Quirks::default(),
            complaint: None,
        }
    }

    /// A reload value of 0 in force blocks it (RM0433 38.3.1).
    fn counts(&self) -> bool {
        self.cr1 & CEN != 0 && !self.is_encoder() && (self.top != 0 || self.quirks.counts_to_zero)
    }

    fn is_encoder(&self) -> bool {
        matches!(self.smcr & 7, 1..=3)
    }

    fn widest(&self) -> u32 {
        if self.kind.wide { u32::MAX } else { 0xffff }
    }

    /// Time a count takes.
    fn step(&self) -> Time {
        self.kernel * (Time::from(self.divider) + 1)
    }

    /// The counter.
    pub fn count(&self, at: Time) -> u32 {
        if self.counts() { ((at as i64 - self.epoch) / self.step() as i64) as u32 } else { self.held }
    }

    /// The instant at which the counter wraps to 0: after the reload value, or after the largest
    /// value if it is past that.
    fn wrap(&self, at: Time) -> Time {
        let top = if self.count(at) > self.top { self.widest() } else { self.top };
        self.after(Time::from(top) + 1)
    }

    /// The instant so many counts after the counter was 0.
    fn after(&self, counts: Time) -> Time {
        (self.epoch + (counts * self.step()) as i64) as Time
    }

    fn hold(&mut self, count: u32, at: Time) {
        self.held = count;
        // In whole counts from now on.
        self.epoch = at as i64 - (Time::from(count) * self.step()) as i64;
        for channel in &mut self.channels {
            channel.matched = count > channel.compare;
        }
    }

    /// The encoder moved by so many counts.
    pub fn turn(&mut self, steps: i64) {
        if self.cr1 & CEN != 0 && self.is_encoder() {
            let span = i64::from(self.top) + 1;
            self.held = (i64::from(self.held) + steps).rem_euclid(span) as u32;
        }
    }

    /// The levels at its inputs (RM0433 table 337, counting on both edges; filters are not
    /// modelled).
    pub fn inputs(&mut self, mut levels: [bool; 4], at: Time, out: &mut Vec<Signal>) {
        if self.quirks.swapped {
            levels.swap(0, 1);
        }
        let before = std::mem::replace(&mut self.inputs, levels);
        let inverted = |n: usize| self.channels[n].enables & 2 != 0;
        let [one, two] = [levels[0] != inverted(0), levels[1] != inverted(1)];
        for n in 0..4 {
            if self.channels[n].takes(before[n], levels[n]) {
                self.capture(n, at, out);
            }
        }
        if !self.is_encoder() {
            return;
        }
        let held = self.held;
        // A change of the first counts up where the second is at its former level, one of the
        // second where it is at the first's.
        if before[0] != self.inputs[0] {
            self.turn(if one != two { 1 } else { -1 });
        }
        if before[1] != self.inputs[1] && !self.quirks.halves {
            self.turn(if one == two { 1 } else { -1 });
        }
        if held != self.held {
            self.moved = (at, held);
        }
    }

    /// An edge at the input of a channel latches the count; one that was not read before is lost
    /// (RM0433 39.3.5). The chip takes some counts to synchronise, all channels alike.
    fn capture(&mut self, n: usize, at: Time, out: &mut Vec<Signal>) {
        let (moved, before) = self.moved;
        let is_early = self.quirks.early_index && at < moved + FILTER_COUNTS * self.kernel;
        self.channels[n].preload = if is_early { before } else { self.count(at) };
        self.sr |= if self.sr & 2 << n != 0 { 0x202 << n } else { 2 << n };
        if self.dier & 1 << (9 + n) != 0 {
            self.request(self.kind.requests[n], out);
        }
    }

    /// MOE: its outputs follow it.
    pub fn is_enabled(&self) -> bool {
        self.brake.bdtr & Break::MOE != 0
    }

    /// The break input's pin has this level.
    pub fn break_input(&mut self, high: bool, out: &mut Vec<Signal>, at: Time) {
        let high = (high || self.quirks.stuck) && !self.quirks.unconnected;
        if self.quirks.break_delay == 0 {
            self.brake.input = high;
        } else if self.breaks.1 != high {
            self.breaks = (at + self.quirks.break_delay * self.kernel, high);
        }
        self.look_at_break(out, at);
    }

    /// The supply is low or the core is locked up, as far as SYSCFG_CFGR leads that to the timers.
    pub fn break_of_chip(&mut self, active: bool, out: &mut Vec<Signal>, at: Time) {
        self.brake.of_chip = active;
        self.look_at_break(out, at);
    }

    /// The clock's guard breaks.
    pub fn lose_clock(&mut self, out: &mut Vec<Signal>, at: Time) {
        self.brake.clock_lost = !self.quirks.no_clock_break;
        self.look_at_break(out, at);
    }

    fn look_at_break(&mut self, out: &mut Vec<Signal>, at: Time) {
        let by_chip = self.brake.is_broken_by_chip();
        if by_chip {
            let has_both = !self.quirks.one_flag && matches!(self.kind.number, 1 | 8);
            self.sr |= if has_both { SBIF } else { BIF };
        }
        let by_input = self.brake.is_broken(self.others[0], self.is_odd);
        if by_input {
            self.sr |= BIF;
        }
        if by_chip || by_input {
            self.disable(at);
        }
        self.publish(at, out);
        self.add_interrupts(out);
    }

    /// Whether MOE cannot be set: the break is active, or the flag of the chip's breaks is set
    /// (RM0433 38.4.5: it must be cleared before).
    fn is_kept_dark(&self) -> bool {
        let is_broken = self.brake.is_broken_by_chip() || self.brake.is_broken(self.others[0], self.is_odd);
        is_broken && !self.quirks.by_edge || self.sr & SBIF != 0
    }

    /// The main output is disabled, by a break or by software. Lines are inactive first, which the
    /// complement's idle level is not (RM0433 38.3.16: for the dead time and what the two clocks'
    /// synchronization takes). No source says that software does not do so.
    fn disable(&mut self, at: Time) {
        if self.brake.bdtr & Break::MOE != 0 {
            self.brake.bdtr &= !Break::MOE;
            self.settles = Some(at + (2 + self.quirks.settles_more) * self.kernel);
        }
    }

    /// Computes the outputs and signals the changes.
    fn publish(&mut self, at: Time, out: &mut Vec<Signal>) {
        let count = self.count(at);
        self.channels.iter_mut().for_each(|channel| channel.look(count));
        let references = self.channels.map(|channel| channel.reference);
        for (n, channel) in self.channels.iter().enumerate() {
            let other_rest = if self.quirks.other_rest { 3 } else { 0 };
            let (reference, idle) = (channel.combined(references[n ^ 1]), self.cr2 >> (8 + 2 * n) ^ other_rest);
            // An input drives nothing.
            let enables = if channel.captures() { 0 } else { channel.enables };
            let levels = self.brake.levels(enables, reference, self.kind.advanced, idle, self.settles.is_some());
            for (level, complementary) in levels.into_iter().zip([false, true]) {
                let place = &mut self.levels[n][usize::from(complementary)];
                if *place != level {
                    *place = level;
                    out.push(Signal::Output(Source::Timer(self.kind.number, n as u8 + 1, complementary), level));
                }
            }
        }
    }

    /// The lines of the interrupts.
    fn add_interrupts(&self, out: &mut Vec<Signal>) {
        let active = self.sr & self.dier;
        let [update, compare, brake] = self.kind.lines;
        if update == compare {
            out.push(Signal::Line(update, active & 0xff != 0));
        } else {
            out.push(Signal::Line(update, active & UIF != 0));
            out.push(Signal::Line(compare, active & 0x1e != 0));
            out.push(Signal::Line(brake, active & BIF != 0));
        }
    }

    fn request(&mut self, number: u8, out: &mut Vec<Signal>) {
        if number != 0 {
            if self.burst == 0 {
                self.burst_asks = number;
            }
            out.push(Signal::Request(number));
        }
    }

    /// Takes over everything preloaded (an update event).
    fn take_over(&mut self) {
        self.divider = self.psc;
        self.top = self.arr;
        self.repeat = self.rcr;
        for channel in &mut self.channels {
            channel.compare = channel.preload;
        }
    }

    /// The counter has wrapped.
    fn overflow(&mut self, at: Time, out: &mut Vec<Signal>) {
        self.epoch = at as i64;
        for channel in &mut self.channels {
            channel.matched = false;
        }
        if self.repeat > 0 {
            self.repeat -= 1;
        } else if self.cr1 & UDIS == 0 {
            self.take_over();
            self.sr |= UIF;
            self.master(MMS_UPDATE, out);
            if self.dier & 1 << 8 != 0 {
                self.request(self.kind.requests[4], out);
            }
            if self.cr2 & 1 << 3 != 0 {
                for n in 0..4 {
                    if self.dier & 1 << (9 + n) != 0 {
                        self.request(self.kind.requests[n], out);
                    }
                }
            }
            // AOE: outputs come back by themselves at an update, if the break is over.
            if self.brake.bdtr & 1 << 14 != 0 && !self.is_kept_dark() {
                self.brake.bdtr |= Break::MOE;
            }
            if self.cr1 & OPM != 0 {
                self.cr1 &= !CEN;
            }
            if !self.counts() {
                self.hold(0, at);
            }
        }
    }

    /// The counter has come to a channel's compare value.
    fn compare(&mut self, n: usize, out: &mut Vec<Signal>) {
        let flag = 2 << n;
        self.channels[n].matched = true;
        self.channels[n].meet();
        self.sr |= flag;
        if self.dier & 1 << (9 + n) != 0 && self.cr2 & 1 << 3 == 0 {
            self.request(self.kind.requests[n], out);
        }
    }

    /// The instant at which a channel meets the counter, in this cycle.
    fn meeting(&self, n: usize) -> Time {
        let channel = &self.channels[n];
        if channel.is_input() || channel.matched || channel.compare > self.top {
            return NEVER;
        }
        self.after(Time::from(channel.compare))
    }

    /// The register that a burst reaches next through DMAR.
    fn burst_target(&mut self) -> u32 {
        let (first, length) = (self.dcr & 0x1f, self.dcr >> 8 & 0x1f);
        let target = 4 * (first + self.burst);
        self.burst = if self.burst >= length { 0 } else { self.burst + 1 };
        target
    }

    fn generate(&mut self, value: u32, at: Time, out: &mut Vec<Signal>) {
        if value & 1 != 0 {
            self.take_over();
            self.hold(0, at);
            self.master(MMS_UPDATE, out);
            if self.cr1 & URS == 0 {
                self.sr |= UIF;
                if self.dier & 1 << 8 != 0 {
                    self.request(self.kind.requests[4], out);
                }
            }
        }
        for n in 0..4 {
            if value & 2 << n != 0 {
                self.compare(n, out);
            }
        }
        if value & BIF != 0 {
            self.sr |= BIF;
            self.disable(at);
        }
    }

    /// Triggers its slaves, if this is their trigger.
    fn master(&self, mode: u32, out: &mut Vec<Signal>) {
        if self.cr2 >> 4 & 7 == mode {
            out.push(Signal::Trigger(self.kind.number));
        }
    }

    /// Whether the trigger of this master starts it: SMCR.TS, and the trigger mode.
    fn follows(&self, master: u8) -> bool {
        let input = (self.smcr >> 4 & 7 | self.smcr >> 17 & 0x18) as usize;
        let masters = TRIGGERS.iter().find(|(slave, _)| *slave == self.kind.number);
        !self.quirks.is_deaf
            && self.is_triggered()
            && masters.is_some_and(|(_, masters)| masters.get(input) == Some(&master))
    }

    fn is_triggered(&self) -> bool {
        self.smcr & 7 == 6 && self.smcr & 1 << 16 == 0
    }

    /// A master's trigger: in trigger mode it starts to count. The chip takes some counts to
    /// synchronise, all slaves alike.
    pub fn trigger(&mut self, master: u8, at: Time, out: &mut Vec<Signal>) {
        if self.follows(master) && self.cr1 & CEN == 0 && self.quirks.start_delay > 0 {
            self.starts = at + self.quirks.start_delay * self.kernel;
        } else if self.follows(master) && self.cr1 & CEN == 0 {
            self.set_control(self.cr1 | CEN, at, out);
            self.publish(at, out);
        }
    }

    /// What is captured: edges of a channel's own input of TIM2, whose pins are wired; MCO1 at
    /// TIM17's first (RM0433 41.5.22, TI1SEL); of the others, which are encoders' timers, rising
    /// ones at the third and fourth.
    fn look_at_captures(&mut self) {
        let captures = |n: usize| self.channels[n].captures();
        let is_modelled = |n: usize| {
            let channel = &self.channels[n];
            n >= 2 && channel.captures_rising()
                || self.kind.number == 2 && channel.captures_own()
                || n == 0 && self.taps_mco1()
        };
        if (0..4).any(|n| captures(n) && !is_modelled(n)) {
            self.complain("such a capture");
        }
    }

    fn taps_mco1(&self) -> bool {
        const MCO1: u32 = 3;
        self.kind.number == 17 && self.others[2] & 0xf == MCO1 && self.channels[0].captures()
    }

    /// Time from a captured edge of MCO1 to the next one, by the channel's prescaler.
    fn edges(&self) -> Option<Time> {
        let cycles = self.mco1.filter(|_| self.taps_mco1() && self.counts())?;
        Some((cycles << (self.channels[0].mode_bits() >> 2 & 3)) / 1000)
    }

    /// The next edge comes, once there are edges.
    fn await_edge(&mut self, at: Time) {
        self.edge = match self.edges() {
            None => NEVER,
            Some(period) if self.edge == NEVER => at + period,
            Some(_) => self.edge,
        };
    }

    fn complain(&mut self, what: &str) {
        let number = self.kind.number;
        self.complaint.get_or_insert_with(|| format!("TIM{number}: {what} is not modelled"));
    }

    fn set_control(&mut self, value: u32, at: Time, out: &mut Vec<Signal>) {
        let count = self.count(at);
        let counted = self.counts();
        self.cr1 = value;
        if value & CR1_OTHER != 0 {
            self.complain("down-counting");
        }
        if counted != self.counts() {
            self.hold(count, at);
            if !counted {
                if self.quirks.rewinds {
                    out.push(Signal::Rewind(self.kind.requests[4]));
                }
                self.master(MMS_ENABLE, out);
            }
        }
    }
}
