//! A timer's registers (RM0433 38.4, 39.4, 40.4, 41.4), and its advance in time as a device.
//!
//! In: reads and writes, instants. Out: values, signals. Owns nothing: the timer does. Fails:
//! `None` for a register that does not exist.
use super::*;

impl Device for Timer {
    fn read(&mut self, offset: u32, at: Time, _: &mut Vec<Signal>) -> Option<u32> {
        Some(match offset {
            CR1 => self.cr1,
            CR2 => self.cr2,
            SMCR => self.smcr,
            DIER => self.dier,
            SR => self.sr,
            EGR => 0,
            CCMR1 | CCMR2 => {
                let first = if offset == CCMR1 { 0 } else { 2 };
                self.channels[first].mode_bits() | self.channels[first + 1].mode_bits() << 8
            }
            CCER => (0..4).fold(0, |all, n| all | self.channels[n].enables << (4 * n)),
            // UIFCPY.
            CNT if self.cr1 & 1 << 11 != 0 => self.count(at) & 0x7fff_ffff | (self.sr & UIF) << 31,
            CNT => self.count(at),
            PSC => self.psc,
            ARR => self.arr,
            RCR => self.rcr,
            CCR1..=CCR4 => {
                let n = (offset - CCR1) as usize / 4;
                // Fetching what was captured takes its flag away (RM0433 39.4.5).
                if self.channels[n].captures() {
                    self.sr &= !(2 << n);
                }
                self.channels[n].preload
            }
            BDTR => self.brake.bdtr,
            DCR => self.dcr,
            DMAR => {
                let target = self.burst_target();
                return self.read(target, at, &mut Vec::new());
            }
            AF1..=TISEL => self.others[(offset - AF1) as usize / 4],
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, out: &mut Vec<Signal>) -> Option<()> {
        let before = match offset {
            SR | EGR | DMAR | CNT => 0,
            _ => self.read(offset, at, out)?,
        };
        let value = before & !mask | value & mask;
        match offset {
            CR1 => self.set_control(value, at, out),
            CR2 => {
                if value & 1 != 0 {
                    self.complain("preload of the channels' control (CCPC)");
                }
                if !matches!(value >> 4 & 7, 0..=2) {
                    self.complain("a trigger output but of reset, enable and update");
                }
                self.cr2 = value;
            }
            SMCR => {
                let (count, counted) = (self.count(at), self.counts());
                self.smcr = value;
                if value & (7 | 1 << 16) != 0 && !self.is_encoder() && !self.is_triggered() || value & 1 << 14 != 0 {
                    self.complain("a slave mode but the encoder's and the trigger mode");
                }
                if matches!(value & 7, 1 | 2) {
                    self.complain("an encoder that counts on the edges of one input");
                }
                if counted != self.counts() {
                    self.hold(count, at);
                }
            }
            DIER => {
                for (bit, request) in [9, 10, 11, 12, 8].into_iter().zip(self.kind.requests) {
                    if before & !value & 1 << bit != 0 && request != 0 {
                        out.push(Signal::Withdraw(request));
                    }
                }
                self.dier = value;
            }
            // Flags are cleared by writing 0 to them.
            SR => self.sr &= value | !mask,
            EGR => self.generate(value, at, out),
            CCMR1 | CCMR2 => {
                let first = if offset == CCMR1 { 0 } else { 2 };
                for n in 0..2 {
                    let channel = &mut self.channels[first + n];
                    channel.set_mode(value >> (8 * n));
                    if !channel.is_modelled() {
                        self.complain("a mode of a channel");
                    }
                }
                self.look_at_captures();
            }
            CCER => {
                (0..4).for_each(|n| self.channels[n].enables = value >> (4 * n) & 0xf);
                self.look_at_captures();
            }
            CNT => self.hold(value & self.widest(), at),
            PSC => self.psc = value & 0xffff,
            ARR => {
                self.arr = value & self.widest();
                if self.cr1 & ARPE == 0 {
                    let (count, counted) = (self.count(at), self.counts());
                    self.held = count;
                    self.top = self.arr;
                    if counted != self.counts() {
                        self.hold(count, at);
                    }
                }
            }
            // RM0433 41.5.12: those of 15 to 17 have eight bits.
            RCR => {
                let is_short = self.kind.number >= 15 || self.quirks.short_repeat;
                self.rcr = value & if is_short { 0xff } else { 0xffff };
            }
            CCR1..=CCR4 => {
                let widest = self.widest();
                let count = self.count(at);
                let channel = &mut self.channels[(offset - CCR1) as usize / 4];
                channel.preload = value & widest;
                if !channel.is_preloaded() {
                    channel.compare = channel.preload;
                    channel.matched = count > channel.compare;
                }
            }
            BDTR if self.kind.advanced => {
                if value & 0xff != 0 {
                    self.complain("dead time");
                }
                if value & 0xff << 16 != 0 {
                    self.complain("the filter of a break input, which would hold it up");
                }
                if value & 1 << 24 != 0 {
                    self.complain("a second break input");
                }
                self.brake.bdtr = value & if self.quirks.no_ossi { !(1 << 10) } else { u32::MAX };
                if before & Break::MOE == 0 && value & Break::MOE != 0 {
                    if self.is_kept_dark() {
                        self.brake.bdtr &= !Break::MOE;
                    } else {
                        self.settles = None;
                    }
                } else if before & !value & Break::MOE != 0 {
                    self.brake.bdtr |= Break::MOE;
                    self.disable(at);
                }
            }
            BDTR => {}
            // It does not report the position in a burst, and no source says that this resets it
            // (RM0433 38.4.20). DBL and DBA have five bits each.
            DCR => self.dcr = value & 0x1f1f,
            DMAR => {
                let target = self.burst_target();
                if self.burst != 0 && self.burst_asks != 0 {
                    out.push(Signal::Request(self.burst_asks));
                }
                return self.write(target, value, mask, at, out);
            }
            AF1 if self.quirks.no_af1 => {}
            AF1..=TISEL => self.others[(offset - AF1) as usize / 4] = value,
            _ => return None,
        }
        let is_held = self.quirks.by_edge && self.brake.bdtr & Break::MOE != 0;
        if !is_held {
            self.look_at_break(out, at);
        }
        self.await_edge(at);
        self.publish(at, out);
        self.add_interrupts(out);
        Some(())
    }

    fn next(&self) -> Time {
        let settles = self.settles.unwrap_or(NEVER).min(self.starts).min(self.breaks.0).min(self.edge);
        if !self.counts() {
            return settles;
        }
        // The count at the epoch is enough: past the top it is only where a write left it so.
        let top = if self.held > self.top { self.widest() } else { self.top };
        let wrap = self.after(Time::from(top) + 1);
        (0..4).map(|n| self.meeting(n)).min().unwrap_or(NEVER).min(wrap).min(settles)
    }

    fn advance(&mut self, to: Time, out: &mut Vec<Signal>) {
        loop {
            let due = self.next();
            if due > to {
                break;
            }
            if self.starts <= due {
                self.starts = NEVER;
                self.set_control(self.cr1 | CEN, due, out);
            }
            if self.settles.is_some_and(|at| at <= due) {
                self.settles = None;
            }
            if self.breaks.0 <= due {
                self.breaks.0 = NEVER;
                self.brake.input = self.breaks.1;
                self.look_at_break(out, due);
            }
            if self.edge <= due {
                self.edge = self.edges().map_or(NEVER, |period| due + period);
                self.capture(0, due, out);
            }
            for n in 0..4 {
                if self.meeting(n) == due {
                    self.compare(n, out);
                }
            }
            if self.counts() && self.wrap(due - 1) == due {
                self.held = 0;
                self.overflow(due, out);
                // A channel at 0 meets the counter as it begins.
                for n in 0..4 {
                    if self.counts() && self.meeting(n) == due {
                        self.compare(n, out);
                    }
                }
            }
            self.publish(due, out);
            self.add_interrupts(out);
        }
    }

    fn reset(&mut self, at: Time, out: &mut Vec<Signal>) {
        let (brake, kernel, levels, inputs) = (self.brake, self.kernel, self.levels, self.inputs);
        let (is_odd, quirks, breaks, mco1) = (self.is_odd, self.quirks, self.breaks, self.mco1);
        let burst = if quirks.keeps_burst { (self.burst, self.burst_asks) } else { (0, 0) };
        let complaint = self.complaint.take();
        *self = Timer::new(self.kind);
        (self.brake.input, self.brake.of_chip) = (brake.input, brake.of_chip);
        self.kernel = kernel;
        self.levels = levels;
        self.inputs = inputs;
        (self.is_odd, self.quirks, self.breaks, self.mco1) = (is_odd, quirks, breaks, mco1);
        (self.burst, self.burst_asks) = burst;
        self.complaint = complaint;
        self.publish(at, out);
        self.add_interrupts(out);
    }

    fn clocks(&mut self, clocks: &Clocks, at: Time) {
        let kernel = if self.kind.fast { clocks.timers2 } else { clocks.timers1 };
        if kernel != self.kernel {
            let count = self.count(at);
            self.kernel = kernel;
            self.hold(count, at);
        }
        self.mco1 = clocks.mco1;
        self.await_edge(at);
    }
}
