//! ADC3 (RM0433 25): calibration, then a regular conversion and injected ones after it,
//! continuously.
//!
//! In: registers, voltages at its inputs ([`Adc::apply`]). Out: data registers. Owns the state of
//! the converter. The instant of a read determines what is ready, and what has been converted. A
//! conversion holds the voltage at the end of its sampling.
//!
//! Fails with complaints about settings and starts against the manual, such as a conversion without
//! both calibrations or a clock that BOOST does not allow. Not modelled, and a complaint:
//! interrupts, DMA, triggers, other resolutions than 16 bits, sequences of several regular
//! conversions, single sequences, oversampling.
use crate::clocks::Clocks;
use crate::device::{Device, Signal};
use crate::time::{MICROSECOND, NEVER, Time};

const ISR: u32 = 0x00;
const CR: u32 = 0x08;
const CFGR: u32 = 0x0c;
const SMPR1: u32 = 0x14;
const PCSEL: u32 = 0x1c;
const SQR1: u32 = 0x30;
const DR: u32 = 0x40;
const JSQR: u32 = 0x4c;
const JDR1: u32 = 0x80;
/// Offset of the common block.
const CCR: u32 = 0x308;

const ADEN: u32 = 1 << 0;
const ADDIS: u32 = 1 << 1;
const ADSTART: u32 = 1 << 2;
const BOOST: u32 = 3 << 8;
const ADCALLIN: u32 = 1 << 16;
const ADVREGEN: u32 = 1 << 28;
const DEEPPWD: u32 = 1 << 29;
const ADCALDIF: u32 = 1 << 30;
const ADCAL: u32 = 1 << 31;

const ADRDY: u32 = 1 << 0;
const JEOS: u32 = 1 << 6;

/// CONT, JAUTO, JQDIS, OVRMOD; 16 bits.
const WANTED: u32 = 1 << 13 | 1 << 25 | 1 << 31 | 1 << 12;

/// The regulator's start (data sheet, ADC characteristics: 10 µs), and both calibrations in cycles.
const REGULATOR: Time = 10 * MICROSECOND;
const LINEARITY: Time = 165_010;
const OFFSET: Time = 1_280;

/// Halves of a cycle that sampling takes, by SMP; the conversion of 16 bits takes 17 more.
const SAMPLING: [Time; 8] = [3, 5, 17, 33, 65, 129, 775, 1621];
const CONVERSION: Time = 17;

/// Reference and full scale.
pub const REFERENCE: f64 = 3.3;

/// Inputs that are modelled.
const INPUTS: usize = 20;

/// See the module text.
#[derive(Debug, Clone)]
pub struct Adc {
    isr: u32,
    cr: u32,
    cfgr: u32,
    smpr: u32,
    pcsel: u32,
    sqr: u32,
    jsqr: u32,
    ccr: u32,
    kernel: Option<Time>,
    regulated: Time,
    calibrated: Time,
    /// How often ADEN is taken back, as within four cycles after a calibration (RM0433 25.4.9).
    pub withdraws: u32,
    linear: bool,
    ready: Time,
    started: Time,
    /// What it says of a voltage, for tests: 1 is the truth.
    pub gain: f64,
    /// Voltages of each input, and since when.
    applied: Vec<(Time, usize, f64)>,
    /// What was done against the manual, or is not modelled.
    pub complaint: Option<String>,
}

impl Default for Adc {
    fn default() -> Self {
        Adc {
            isr: 0,
            cr: DEEPPWD,
            cfgr: 1 << 31,
            smpr: 0,
            pcsel: 0,
            sqr: 0,
            jsqr: 0,
            ccr: 0,
            kernel: None,
            regulated: NEVER,
            calibrated: NEVER,
            withdraws: 0,
            linear: false,
            ready: NEVER,
            started: NEVER,
            gain: 1.0,
            applied: Vec::new(),
            complaint: None,
        }
    }
}

impl Adc {
    /// A voltage at a pin, by its number as an input of ADC3: PC2_C 0, PC3_C 1.
    pub fn apply(&mut self, input: usize, volts: f64, at: Time) {
        self.applied.push((at, input, volts));
    }

    fn complain(&mut self, what: &str) {
        self.complaint.get_or_insert_with(|| format!("ADC3: {what}"));
    }

    /// A cycle of the converter: the kernel clock by PRESC, and by 2 in revision V.
    fn cycle(&mut self) -> Time {
        const PRESCALERS: [Time; 12] = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
        if self.ccr & 3 << 16 != 0 {
            self.complain("a clock from the bus is not modelled");
        }
        let Some(kernel) = self.kernel else {
            self.complain("it has no kernel clock");
            return 1;
        };
        2 * kernel * PRESCALERS[(self.ccr >> 18 & 0xf).min(11) as usize]
    }

    fn check_boost(&mut self) {
        let khz = 960_000 / self.cycle();
        let allowed = [0..=6_250, 6_251..=12_500, 12_501..=25_000, 25_001..=50_000];
        if !allowed[(self.cr >> 8 & 3) as usize].contains(&khz) {
            self.complain(&format!("{khz} kHz are not what BOOST says"));
        }
    }

    /// Channels of a sequence: the regular one and the injected ones, each with the halves of a
    /// cycle that it takes.
    fn round(&self) -> Vec<(usize, Time)> {
        let injected = (self.jsqr & 3) + 1;
        let channels =
            std::iter::once(self.sqr >> 6 & 0x1f).chain((0..injected).map(|n| self.jsqr >> (9 + 6 * n) & 0x1f));
        channels
            .map(|channel| (channel as usize, SAMPLING[(self.smpr >> (3 * channel.min(9)) & 7) as usize] + CONVERSION))
            .collect()
    }

    /// Content of the `n`-th data register of a sequence.
    fn data(&mut self, n: usize, at: Time) -> u32 {
        let (cycle, round) = (self.cycle(), self.round());
        let Some(&(channel, _)) = round.get(n) else { return 0 };
        let length: Time = round.iter().map(|(_, halves)| halves * cycle / 2).sum();
        let end: Time = round.iter().take(n + 1).map(|(_, halves)| halves * cycle / 2).sum();
        let Some(since) = at.checked_sub(self.started).and_then(|since| since.checked_sub(end)) else { return 0 };
        let sampled = self.started + since / length * length + end - CONVERSION * cycle / 2;
        let volts = self.applied.iter().rev().find(|&&(from, input, _)| input == channel && from <= sampled);
        let volts = volts.map_or(0.0, |&(_, _, volts)| volts);
        (volts * self.gain / REFERENCE * 65536.0).floor().clamp(0.0, 65535.0) as u32
    }

    fn set_control(&mut self, new: u32, at: Time) {
        let rises = new & !self.cr;
        if rises & ADVREGEN != 0 {
            self.regulated = at + REGULATOR;
        }
        if new & DEEPPWD != 0 && self.cr & DEEPPWD == 0 {
            (self.calibrated, self.linear) = (NEVER, false);
        }
        let powered = new & (DEEPPWD | ADVREGEN) == ADVREGEN && at >= self.regulated;
        let settings = BOOST | ADCALLIN | ADVREGEN | DEEPPWD | ADCALDIF;
        self.cr = self.cr & !settings | new & settings;
        if new & ADCAL != 0 {
            if !powered || self.cr & ADEN != 0 {
                self.complain("it is calibrated before its regulator stands, or while it is on");
            }
            self.check_boost();
            self.linear |= new & ADCALLIN != 0;
            let cycles = OFFSET + if new & ADCALLIN != 0 { LINEARITY } else { 0 };
            self.calibrated = at + cycles * self.cycle();
        }
        if new & ADEN != 0 && self.withdraws > 0 {
            self.withdraws -= 1;
        } else if new & ADEN != 0 && self.cr & ADEN == 0 {
            if !powered || self.calibrated > at || !self.linear {
                self.complain("it is switched on before it is calibrated");
            }
            self.cr |= ADEN;
            // A start-up of some conversions.
            self.ready = at + 5 * MICROSECOND;
        }
        if new & ADSTART != 0 && self.cr & ADSTART == 0 {
            if self.cr & ADEN == 0 || at < self.ready {
                self.complain("it is started before it is ready");
            }
            let other = self.cfgr & !WANTED != 0 || self.cfgr & WANTED != WANTED;
            if other || self.sqr & 0xf != 0 || self.jsqr & 0x1fc != 0 {
                self.complain("it is set to what is not modelled");
            }
            if self.round().iter().any(|(channel, _)| self.pcsel >> channel & 1 == 0) {
                self.complain("a channel is converted that is not preselected");
            }
            if self.round().iter().any(|(channel, _)| *channel >= INPUTS.min(10)) {
                self.complain("channels above 9 are not modelled");
            }
            self.check_boost();
            self.cr |= ADSTART;
            self.started = at;
        }
        if new & ADDIS != 0 && self.cr & (ADEN | ADSTART) == ADEN {
            self.cr &= !ADEN;
            self.ready = NEVER;
        }
        if new & 0x38 != 0 {
            self.complain("stopping and triggered injection are not modelled");
        }
    }
}

impl Device for Adc {
    fn read(&mut self, offset: u32, at: Time, _: &mut Vec<Signal>) -> Option<u32> {
        Some(match offset {
            ISR => {
                if at >= self.ready {
                    self.isr |= ADRDY;
                }
                let (cycle, round) = (self.cycle(), self.round());
                let length: Time = round.iter().map(|(_, halves)| halves * cycle / 2).sum();
                if at.checked_sub(self.started).is_some_and(|since| since >= length) {
                    self.isr |= JEOS;
                }
                self.isr
            }
            CR => self.cr | if self.calibrated != NEVER && at < self.calibrated { ADCAL } else { 0 },
            CFGR => self.cfgr,
            SMPR1 => self.smpr,
            PCSEL => self.pcsel,
            SQR1 => self.sqr,
            JSQR => self.jsqr,
            DR => self.data(0, at),
            JDR1..=0x8c => self.data(1 + (offset - JDR1) as usize / 4, at),
            CCR => self.ccr,
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, out: &mut Vec<Signal>) -> Option<()> {
        let new = self.read(offset, at, out)? & !mask | value & mask;
        let runs = self.cr & ADSTART != 0;
        match offset {
            ISR => self.isr &= !(value & mask),
            CR => self.set_control(new, at),
            _ if runs => self.complain("its settings are written while it runs"),
            CFGR => self.cfgr = new,
            SMPR1 => self.smpr = new,
            PCSEL => self.pcsel = new,
            SQR1 => self.sqr = new,
            JSQR => self.jsqr = new,
            CCR if self.cr & ADEN != 0 => self.complain("its clock is changed while it is on"),
            CCR => self.ccr = new,
            _ => return None,
        }
        Some(())
    }

    fn next(&self) -> Time {
        NEVER
    }

    fn advance(&mut self, _: Time, _: &mut Vec<Signal>) {}

    fn reset(&mut self, _: Time, _: &mut Vec<Signal>) {
        let kept = std::mem::take(self);
        *self = Adc {
            kernel: kept.kernel,
            gain: kept.gain,
            applied: kept.applied,
            complaint: kept.complaint,
            ..Adc::default()
        };
    }

    fn clocks(&mut self, clocks: &Clocks, _: Time) {
        self.kernel = clocks.adc;
    }
}
