//! The peripherals at their addresses (RM0433 2.3.2), and their effects on each other.
//!
//! In: reads, writes, time. Out: values, the lines of interrupts, resets. Owns every model and goes
//! from event to event. Fails with notes ([`Bus::complaints`]): an access that no model answers,
//! and one to a peripheral without a clock. A test that finds a note has found a fault of the image
//! or a gap of the emulation.
use crate::adc::Adc;
use crate::board::Board;
use crate::clocks::{AHB1ENR, AHB2ENR, AHB4ENR, Clocks, Rcc};
use crate::dac::Dac;
use crate::device::{Cause, Device, Signal};
use crate::dma::Dma;
use crate::exceptions::{Exceptions, NMI};
use crate::gpio::{Gpio, Pin};
use crate::memory::{BACKUP, Memory, Region};
use crate::spi::Spi;
use crate::supply::{Dbgmcu, Flash, Pwr, Syscfg};
use crate::time::{NEVER, Time};
use crate::timer::{KINDS, Timer};
use crate::usart::Usart;
use crate::usb::Usb;
use crate::watchdog::Watchdog;
use std::sync::Arc;

const APB1LENR: u32 = 0xe8;
const APB2ENR: u32 = 0xf0;
const APB4ENR: u32 = 0xf4;

/// Where a peripheral is, and what gives it a clock.
#[derive(Debug, Clone, Copy)]
pub struct Peripheral {
    /// Its name; the first one's, where a model is several in a row.
    pub name: &'static str,
    /// Its first address.
    pub base: u32,
    /// Bytes that it answers to.
    pub size: u32,
    /// Which bit of which enable register of RCC lets it run; `None` where the model runs without.
    pub clock: Option<(u32, u32)>,
}

/// Each peripheral, in the order of [`Bus::device`].
pub const PERIPHERALS: [Peripheral; 13 + KINDS.len()] = [
    Peripheral { name: "RCC", base: 0x5802_4400, size: 0x400, clock: None },
    Peripheral { name: "PWR", base: 0x5802_4800, size: 0x400, clock: None },
    Peripheral { name: "FLASH", base: 0x5200_2000, size: 0x400, clock: None },
    Peripheral { name: "SYSCFG", base: 0x5800_0400, size: 0x400, clock: Some((APB4ENR, 1)) },
    Peripheral { name: "GPIOA", base: 0x5802_0000, size: 0x2c00, clock: Some((AHB4ENR, 0)) },
    Peripheral { name: "USART3", base: 0x4000_4800, size: 0x400, clock: Some((APB1LENR, 18)) },
    Peripheral { name: "IWDG1", base: 0x5800_4800, size: 0x400, clock: None },
    Peripheral { name: "DMA1", base: 0x4002_0000, size: 0xc00, clock: None },
    Peripheral { name: "DAC1", base: 0x4000_7400, size: 0x400, clock: Some((APB1LENR, 29)) },
    Peripheral { name: "SPI3", base: 0x4000_3c00, size: 0x400, clock: Some((APB1LENR, 15)) },
    Peripheral { name: "ADC3", base: 0x5802_6000, size: 0x400, clock: Some((AHB4ENR, 24)) },
    Peripheral { name: "USB_OTG_FS", base: 0x4008_0000, size: 0x2_0000, clock: Some((AHB1ENR, 27)) },
    Peripheral { name: "DBGMCU", base: 0x5c00_1000, size: 0x400, clock: None },
    Peripheral { name: "TIM1", base: 0x4001_0000, size: 0x400, clock: Some((APB2ENR, 0)) },
    Peripheral { name: "TIM2", base: 0x4000_0000, size: 0x400, clock: Some((APB1LENR, 0)) },
    Peripheral { name: "TIM3", base: 0x4000_0400, size: 0x400, clock: Some((APB1LENR, 1)) },
    Peripheral { name: "TIM4", base: 0x4000_0800, size: 0x400, clock: Some((APB1LENR, 2)) },
    Peripheral { name: "TIM5", base: 0x4000_0c00, size: 0x400, clock: Some((APB1LENR, 3)) },
    Peripheral { name: "TIM6", base: 0x4000_1000, size: 0x400, clock: Some((APB1LENR, 4)) },
    Peripheral { name: "TIM7", base: 0x4000_1400, size: 0x400, clock: Some((APB1LENR, 5)) },
    Peripheral { name: "TIM8", base: 0x4001_0400, size: 0x400, clock: Some((APB2ENR, 1)) },
    Peripheral { name: "TIM15", base: 0x4001_4000, size: 0x400, clock: Some((APB2ENR, 16)) },
    Peripheral { name: "TIM16", base: 0x4001_4400, size: 0x400, clock: Some((APB2ENR, 17)) },
    Peripheral { name: "TIM17", base: 0x4001_4800, size: 0x400, clock: Some((APB2ENR, 18)) },
];
const RCC: usize = 0;
const PWR: usize = 1;
const FLASH: usize = 2;
const SYSCFG: usize = 3;
const GPIO: usize = 4;
const USART3: usize = 5;
const WATCHDOG: usize = 6;
const DMA: usize = 7;
const DAC1: usize = 8;
const SPI3: usize = 9;
const ADC3: usize = 10;
const USB: usize = 11;
const DBGMCU: usize = 12;
const TIMERS: usize = 13;

/// The interrupt of USART3 (RM0433 table 148).
const USART3_LINE: usize = 39;

/// Voltage at this pin for the supply's detector (data sheet, pin table).
const PVD_IN: Pin = Pin(1, 7);

/// D− and D+.
const USB_PINS: [Pin; 2] = [Pin(0, 11), Pin(0, 12)];
const USB_FUNCTION: u32 = 10;

/// Break inputs: the timer, the pin, its alternate function (docs/board-h743.md, and then
/// docs/board-h743vi.md). Pins of a timer that are switched to it act together.
pub const BREAKS: [(u8, &str, u32); 6] =
    [(1, "PE15", 1), (15, "PE3", 4), (8, "PG2", 3), (1, "PB12", 1), (15, "PA0", 4), (8, "PA6", 3)];

/// See the module text.
#[derive(Debug, Clone)]
pub struct Bus {
    /// Clocks.
    pub rcc: Rcc,
    /// Supply.
    pub pwr: Pwr,
    /// Flash interface.
    pub flash: Flash,
    /// System configuration.
    pub syscfg: Syscfg,
    /// Pins.
    pub gpio: Gpio,
    /// The link.
    pub usart: Usart,
    /// The watchdog.
    pub watchdog: Watchdog,
    /// Both DMAs with their multiplexer.
    pub dma: Dma,
    /// The chip's own DAC.
    pub dac: Dac,
    /// To the external DAC.
    pub spi: Spi,
    /// Analog inputs.
    pub adc: Adc,
    /// USB, with the host at its cable.
    pub usb: Usb,
    /// Revision of the chip, and what a debugger stops.
    pub dbgmcu: Dbgmcu,
    /// Timers, in the order of [`KINDS`].
    pub timers: [Timer; KINDS.len()],
    /// Jumpers between pins: the second takes the level that the first is driven to.
    pub jumpers: Vec<(Pin, Pin)>,
    /// Jumpers from outputs of DAC1 to inputs of ADC3, by their numbers.
    pub analog_jumpers: Vec<(usize, usize)>,
    /// Changes of pins and of DAC1 that jumpers have followed.
    followed: [usize; 2],
    clocks: Clocks,
    is_locked_up: bool,
    next: Time,
    /// A reset that a peripheral asks for.
    pub reset: Option<Cause>,
    /// What the image did that no model covers, or that the manual forbids, each once.
    pub complaints: Vec<String>,
    signals: Vec<Signal>,
}

/// An input of a timer, from 0, and its pin.
pub type Input = (usize, &'static str);
/// Pins at an encoder's first two inputs and at the one that latches its index: the timer, its
/// inputs, the alternate function.
pub const ENCODERS: [(u8, &[Input], u32); 2] =
    [(3, &[(0, "PB4"), (1, "PB5"), (3, "PB1"), (3, "PC9")], 2), (4, &[(0, "PD12"), (1, "PD13"), (2, "PD14")], 2)];
/// Pins at TIM2's inputs, alternate function 1; those of docs/bring-up.md.
pub const CAPTURES: [Input; 6] = [(0, "PA0"), (0, "PA15"), (1, "PB3"), (2, "PB10"), (3, "PA3"), (3, "PB11")];
const CAPTURE_FUNCTION: u32 = 1;

impl Bus {
    /// After power has come; the DMAs reach this memory.
    pub fn new(memory: Arc<Memory>) -> Self {
        Bus {
            rcc: Rcc::default(),
            pwr: Pwr::default(),
            flash: Flash::default(),
            syscfg: Syscfg::default(),
            gpio: Gpio::default(),
            usart: Usart::new(USART3_LINE),
            watchdog: Watchdog::default(),
            dma: Dma::new(memory),
            dac: Dac::default(),
            spi: Spi::default(),
            adc: Adc::default(),
            usb: Usb::default(),
            dbgmcu: Dbgmcu::default(),
            timers: KINDS.map(Timer::new),
            jumpers: Vec::new(),
            analog_jumpers: Vec::new(),
            followed: [0; 2],
            clocks: Clocks::RESET,
            is_locked_up: false,
            next: NEVER,
            reset: None,
            complaints: Vec::new(),
            signals: Vec::new(),
        }
    }

    /// The chip is on this board, and not on a Nucleo.
    pub fn mount(&mut self, board: Board) {
        self.rcc.mount(board);
        self.gpio.mount(board);
        self.syscfg.package = board.package;
        self.usb.core.lacks_vbus = !board.leads_vbus;
    }

    fn device(&mut self, n: usize) -> &mut dyn Device {
        match n {
            RCC => &mut self.rcc,
            PWR => &mut self.pwr,
            FLASH => &mut self.flash,
            SYSCFG => &mut self.syscfg,
            GPIO => &mut self.gpio,
            USART3 => &mut self.usart,
            WATCHDOG => &mut self.watchdog,
            DMA => &mut self.dma,
            DAC1 => &mut self.dac,
            SPI3 => &mut self.spi,
            ADC3 => &mut self.adc,
            USB => &mut self.usb,
            DBGMCU => &mut self.dbgmcu,
            _ => &mut self.timers[n - TIMERS],
        }
    }

    /// A timer by its number.
    pub fn timer(&mut self, number: u8) -> Option<&mut Timer> {
        self.timers.iter_mut().find(|timer| timer.kind.number == number)
    }

    /// The same, as an iterator of one or none.
    pub fn timers_named(&mut self, number: u8) -> impl Iterator<Item = &mut Timer> {
        self.timers.iter_mut().filter(move |timer| timer.kind.number == number)
    }

    /// The clocks in force.
    pub fn clocks(&self) -> Clocks {
        self.clocks
    }

    /// When a peripheral does something by itself next.
    pub fn next(&self) -> Time {
        self.next
    }

    /// Whether a memory is there: it has its clock, and the backup domain is open.
    pub fn has_memory(&self, memory: &Region) -> bool {
        memory.clock.is_none_or(|(register, bit)| self.rcc.is_on(register, bit))
            && (memory.base != BACKUP || self.pwr.opens_backup())
    }

    fn note(&mut self, complaint: String) {
        if !self.complaints.contains(&complaint) {
            self.complaints.push(complaint);
        }
    }

    /// Which peripheral an address belongs to, with the offset in it; notes what has no clock.
    fn find(&mut self, address: u32) -> Option<(usize, u32)> {
        let n = PERIPHERALS.iter().position(|place| (place.base..place.base + place.size).contains(&address))?;
        let place = PERIPHERALS[n];
        let offset = address - place.base;
        // Each port has a bit of its own.
        let port = if n == GPIO { offset / 0x400 } else { 0 };
        if let Some((register, bit)) = place.clock
            && !self.rcc.is_on(register, bit + port)
        {
            self.note(format!("{address:#010x} is touched before its peripheral has a clock"));
            return None;
        }
        // Each controller has a bit; the multiplexer runs with either.
        let clocked = |bit| self.rcc.is_on(AHB1ENR, bit);
        if n == DMA && !if offset < 0x800 { clocked(offset / 0x400) } else { clocked(0) || clocked(1) } {
            self.note(format!("{address:#010x} is touched before its peripheral has a clock"));
            return None;
        }
        Some((n, offset))
    }

    /// A read of a register.
    pub fn read(&mut self, address: u32, at: Time, exceptions: &mut Exceptions) -> Option<u32> {
        self.settle(at, exceptions);
        let (n, offset) = self.find(address)?;
        let mut signals = std::mem::take(&mut self.signals);
        let value = self.device(n).read(offset, at, &mut signals);
        self.signals = signals;
        self.after(at, exceptions);
        value
    }

    /// A write of the bits of `mask`.
    pub fn write(&mut self, address: u32, value: u32, mask: u32, at: Time, exceptions: &mut Exceptions) -> Option<()> {
        self.settle(at, exceptions);
        let (n, offset) = self.find(address)?;
        let mut signals = std::mem::take(&mut self.signals);
        let done = self.device(n).write(offset, value, mask, at, &mut signals);
        self.signals = signals;
        match n {
            RCC => self.reclock(offset, at),
            SYSCFG => {
                let overdrive = self.syscfg.pwrcr & 1 != 0;
                self.pwr.set_overdrive(overdrive, at);
                self.look_at_chip(at);
            }
            PWR => self.look_at_chip(at),
            // A level that the chip drives itself is no input of it.
            GPIO if offset % 0x400 < 0x10 || offset % 0x400 >= 0x20 => {
                self.look_at_inputs(at);
            }
            _ => {}
        }
        self.after(at, exceptions);
        done
    }

    /// What a write to RCC does to the others.
    fn reclock(&mut self, offset: u32, at: Time) {
        let clocks = self.rcc.now();
        if clocks != self.clocks {
            self.clocks = clocks;
            (0..PERIPHERALS.len()).for_each(|n| self.device(n).clocks(&clocks, at));
            if clocks.bus < self.flash.fastest_bus() {
                self.note(format!(
                    "flash has {} wait states at a bus of {} MHz",
                    self.flash.wait_states(),
                    960 / clocks.bus.max(1)
                ));
            }
        }
        if offset < AHB2ENR {
            for (n, place) in PERIPHERALS.iter().enumerate() {
                if place.clock.is_some_and(|(register, bit)| n != GPIO && self.rcc.is_reset(register, bit)) {
                    let mut signals = std::mem::take(&mut self.signals);
                    self.device(n).reset(at, &mut signals);
                    self.signals = signals;
                }
            }
        }
    }

    /// The world drives a pin, or lets it go.
    pub fn drive(&mut self, pin: Pin, level: Option<bool>, at: Time, exceptions: &mut Exceptions) {
        self.settle(at, exceptions);
        self.gpio.drive(pin, level);
        self.look_at_inputs(at);
        self.after(at, exceptions);
    }

    /// The ST-LINK gives its clock, or stops.
    pub fn give_clock(&mut self, source: bool, at: Time, exceptions: &mut Exceptions) {
        self.settle(at, exceptions);
        if self.rcc.give(source, at) {
            let mut signals = std::mem::take(&mut self.signals);
            self.timers.iter_mut().for_each(|timer| timer.lose_clock(&mut signals, at));
            self.signals = signals;
            self.reclock(AHB2ENR, at);
            exceptions.pending.set(NMI, true);
        }
        self.after(at, exceptions);
    }

    /// The supply has this voltage.
    pub fn supply(&mut self, supply_mv: u32, at: Time, exceptions: &mut Exceptions) {
        self.settle(at, exceptions);
        self.pwr.supply_mv = supply_mv;
        self.look_at_chip(at);
        self.after(at, exceptions);
    }

    /// The core is locked up until a reset.
    pub fn lock_up(&mut self, at: Time, exceptions: &mut Exceptions) {
        self.settle(at, exceptions);
        self.is_locked_up = true;
        self.look_at_chip(at);
        self.after(at, exceptions);
    }

    /// Breaks of the chip follow its state.
    fn look_at_chip(&mut self, at: Time) {
        self.pwr.is_locked = self.syscfg.locks_detector();
        self.pwr.pin_is_low = self.gpio.outside(PVD_IN) == Some(false);
        let active = self.syscfg.breaks(self.pwr.is_low(), self.is_locked_up);
        let mut signals = std::mem::take(&mut self.signals);
        self.timers.iter_mut().for_each(|timer| timer.break_of_chip(active, &mut signals, at));
        self.signals = signals;
    }

    /// Break inputs follow their pins.
    fn look_at_breaks(&mut self, at: Time) {
        let mut signals = std::mem::take(&mut self.signals);
        for (number, ..) in BREAKS {
            let is_high = |&(of, name, function): &(u8, &str, u32)| {
                let connected = |pin: &Pin| self.gpio.alternate(*pin) == Some(function);
                of == number && Pin::named(name).filter(connected).is_some_and(|pin| self.gpio.reads(pin))
            };
            let high = BREAKS.iter().any(is_high);
            if let Some(timer) = self.timer(number) {
                timer.break_input(high, &mut signals, at);
            }
        }
        self.signals = signals;
    }

    fn look_at_inputs(&mut self, at: Time) {
        self.look_at_breaks(at);
        self.look_at_encoders(at);
    }

    /// Encoder timers and captures follow their pins.
    fn look_at_encoders(&mut self, at: Time) {
        let mut signals = std::mem::take(&mut self.signals);
        for (number, inputs, function) in ENCODERS {
            let mut levels = [false; 4];
            for &(input, name) in inputs {
                let connected = |pin: &Pin| self.gpio.alternate(*pin) == Some(function);
                levels[input] |= Pin::named(name).filter(connected).is_some_and(|pin| self.gpio.reads(pin));
            }
            if let Some(timer) = self.timer(number) {
                timer.inputs(levels, at, &mut signals);
            }
        }
        let mut levels = [false; 4];
        for (input, name) in CAPTURES {
            let connected = |pin: &Pin| self.gpio.alternate(*pin) == Some(CAPTURE_FUNCTION);
            levels[input] |= Pin::named(name).filter(connected).is_some_and(|pin| self.gpio.reads(pin));
        }
        if let Some(timer) = self.timer(2) {
            timer.inputs(levels, at, &mut signals);
        }
        self.signals = signals;
    }

    /// Lets everything happen that is due until `to`.
    pub fn settle(&mut self, to: Time, exceptions: &mut Exceptions) {
        while self.next <= to {
            let at = self.next;
            for n in 0..PERIPHERALS.len() {
                if self.device(n).next() <= at {
                    let mut signals = std::mem::take(&mut self.signals);
                    self.device(n).advance(at, &mut signals);
                    self.signals = signals;
                }
            }
            self.after(at, exceptions);
        }
    }

    /// Executes the signals of peripherals, and finds the next event.
    fn after(&mut self, at: Time, exceptions: &mut Exceptions) {
        let mut n = 0;
        while n < self.signals.len() || self.follow_jumpers(at) {
            let Some(&signal) = self.signals.get(n) else { continue };
            n += 1;
            match signal {
                Signal::Line(interrupt, high) => {
                    exceptions.set_line(interrupt, high);
                }
                Signal::Output(source, level) => self.gpio.publish(source, level, at),
                Signal::Reset(cause) => self.reset = Some(cause),
                Signal::Request(number) => self.dma.request(number, at),
                Signal::Trigger(master) => {
                    let mut signals = std::mem::take(&mut self.signals);
                    self.timers.iter_mut().for_each(|timer| timer.trigger(master, at, &mut signals));
                    self.signals = signals;
                }
                Signal::Withdraw(number) => self.dma.withdraw(number),
                Signal::Rewind(number) => self.dma.rewind(number),
                Signal::Store { address, size, value } => self.store(address, size, value, at),
                Signal::Fetch { address, size, stream } => {
                    let value = self.fetch(address, size, at);
                    let mut signals = std::mem::take(&mut self.signals);
                    self.dma.take(stream, value, &mut signals);
                    self.signals = signals;
                }
            }
        }
        self.signals.clear();
        self.rcc.fastest = self.pwr.fastest();
        let lines = USB_PINS.map(|pin| self.gpio.alternate(pin) == Some(USB_FUNCTION));
        self.usb.connect(self.pwr.has_usb() && lines == [true; 2]);
        let complaints = [
            self.rcc.complaint.take(),
            self.gpio.complaint.take(),
            self.usart.complaint.take(),
            self.dma.complaint.take(),
            self.dac.complaint.take(),
            self.spi.complaint.take(),
            self.adc.complaint.take(),
            self.usb.core.complaint.take(),
            self.usb.host.complaint.take(),
        ];
        let of_timers: Vec<_> = self.timers.iter_mut().filter_map(|timer| timer.complaint.take()).collect();
        complaints.into_iter().flatten().chain(of_timers).for_each(|complaint| self.note(complaint));
        self.next = (0..PERIPHERALS.len()).map(|n| self.device(n).next()).min().unwrap_or(NEVER);
    }

    /// Ends of jumpers take the levels of the pins that drive them. True if one has changed.
    fn follow_jumpers(&mut self, at: Time) -> bool {
        let changes = [self.gpio.changes.len(), self.dac.changes.len()];
        let before = std::mem::replace(&mut self.followed, changes);
        if before[1] != changes[1] {
            for &(output, input) in &self.analog_jumpers {
                let value = self.dac.output(output).unwrap_or(0);
                self.adc.apply(input, f64::from(value) / 4096.0 * crate::adc::REFERENCE, at);
            }
        }
        if before[0] == changes[0] || self.jumpers.is_empty() {
            return false;
        }
        let mut changed = false;
        for &(from, to) in &self.jumpers {
            let level = match self.gpio.level(from) {
                crate::gpio::Level::Driven(level) => Some(level),
                _ => None,
            };
            if self.gpio.outside(to) != level {
                self.gpio.drive(to, level);
                changed = true;
            }
        }
        if changed {
            self.look_at_inputs(at);
        }
        changed
    }

    /// A DMA writes a register.
    fn store(&mut self, address: u32, size: u32, value: u32, at: Time) {
        let (mask, shift) = (u32::MAX >> (32 - 8 * size), 8 * (address & 3));
        let mut signals = std::mem::take(&mut self.signals);
        let found = self.find(address & !3);
        let done =
            found.and_then(|(n, offset)| self.device(n).write(offset, value << shift, mask << shift, at, &mut signals));
        self.signals = signals;
        if done.is_none() || found.is_some_and(|(n, _)| matches!(n, RCC | PWR | FLASH | SYSCFG)) {
            self.note(format!("a DMA writes {address:#010x}: not modelled"));
        }
    }

    /// A DMA reads one.
    fn fetch(&mut self, address: u32, size: u32, at: Time) -> u32 {
        let mut signals = std::mem::take(&mut self.signals);
        let value = self.find(address & !3).and_then(|(n, offset)| self.device(n).read(offset, at, &mut signals));
        self.signals = signals;
        if value.is_none() {
            self.note(format!("a DMA reads {address:#010x}: not modelled"));
        }
        value.unwrap_or(0) >> (8 * (address & 3)) & (u32::MAX >> (32 - 8 * size))
    }

    /// Everything is as after a reset, but the record of what caused it, the pins' record and the
    /// wires.
    pub fn reset_all(&mut self, cause: Cause, at: Time, exceptions: &mut Exceptions) {
        self.reset = None;
        let mut signals = Vec::new();
        (0..PERIPHERALS.len()).for_each(|n| self.device(n).reset(at, &mut signals));
        self.rcc.restarted(cause);
        self.is_locked_up = false;
        self.clocks = Clocks::RESET;
        let clocks = self.clocks;
        (0..PERIPHERALS.len()).for_each(|n| self.device(n).clocks(&clocks, at));
        self.signals = signals;
        self.look_at_chip(at);
        self.after(at, exceptions);
    }

    /// Something outside of a peripheral has changed what it has to do (the host sent bytes, a
    /// cable was pulled).
    pub fn stir(&mut self, at: Time, exceptions: &mut Exceptions) {
        self.usb.stir(&mut self.signals);
        self.after(at, exceptions);
    }
}
