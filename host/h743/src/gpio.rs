//! The pins: GPIO A to K (RM0433 11).
//!
//! In: registers, what peripherals give to alternate functions, what the world outside drives. Out:
//! the level of each pin, and a record of every change with its time. Which alternate function
//! shows which signal is the data sheet's table, as far as the board's page uses it; a function
//! that is not in it shows nothing, so the pin counts as not driven.
use crate::board::Board;
use crate::device::{Device, Signal, Source};
use crate::time::{NEVER, Time};
use std::collections::HashMap;

/// Ports A to K.
pub const PORTS: usize = 11;

/// A pin: port and number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pin(pub u8, pub u8);

impl Pin {
    /// By its name: `PE9`.
    pub fn named(name: &str) -> Option<Pin> {
        let rest = name.strip_prefix('P')?;
        let (port, number) = rest.split_at_checked(1)?;
        let port = port.bytes().next()?.checked_sub(b'A')?;
        let number = number.parse().ok()?;
        (usize::from(port) < PORTS && number < 16).then_some(Pin(port, number))
    }
}

impl std::fmt::Display for Pin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "P{}{}", char::from(b'A' + self.0), self.1)
    }
}

/// What a pin does to its wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Level {
    /// Nothing: high impedance.
    Floating,
    /// A pull resistor of the chip, up if true.
    Pulled(bool),
    /// Driven.
    Driven(bool),
}

/// A pin began to do something else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Change {
    /// When.
    pub at: Time,
    /// Which.
    pub pin: Pin,
    /// What it does now.
    pub level: Level,
}

/// Signals of alternate functions (data sheet DS12110, tables 10 to 20), for the pins of
/// docs/board-h743.md and docs/board-h743vi.md.
pub const FUNCTIONS: [(Pin, u32, Source); 21] = {
    const A: u8 = 0;
    const B: u8 = 1;
    const C: u8 = 2;
    const D: u8 = 3;
    const E: u8 = 4;
    use Source::{SpiClock, SpiData, Timer, UsartTx};
    [
        (Pin(E, 9), 1, Timer(1, 1, false)),
        (Pin(E, 8), 1, Timer(1, 1, true)),
        (Pin(E, 11), 1, Timer(1, 2, false)),
        (Pin(E, 10), 1, Timer(1, 2, true)),
        (Pin(E, 5), 4, Timer(15, 1, false)),
        (Pin(E, 4), 4, Timer(15, 1, true)),
        (Pin(C, 7), 3, Timer(8, 2, false)),
        (Pin(B, 0), 3, Timer(8, 2, true)),
        (Pin(C, 8), 3, Timer(8, 3, false)),
        (Pin(B, 15), 3, Timer(8, 3, true)),
        (Pin(C, 6), 3, Timer(8, 1, false)),
        (Pin(A, 5), 3, Timer(8, 1, true)),
        (Pin(A, 8), 1, Timer(1, 1, false)),
        (Pin(B, 13), 1, Timer(1, 1, true)),
        (Pin(A, 2), 4, Timer(15, 1, false)),
        (Pin(A, 1), 4, Timer(15, 1, true)),
        (Pin(B, 1), 3, Timer(8, 3, true)),
        (Pin(D, 8), 7, UsartTx(3)),
        (Pin(B, 10), 7, UsartTx(3)),
        (Pin(C, 10), 6, SpiClock(3)),
        (Pin(C, 12), 6, SpiData(3)),
    ]
};

fn function(pin: Pin, number: u32) -> Option<Source> {
    FUNCTIONS.iter().find(|(of, function, _)| (*of, *function) == (pin, number)).map(|(_, _, source)| *source)
}

#[derive(Debug, Clone, Copy, Default)]
struct Port {
    mode: u32,
    kind: u32,
    speed: u32,
    pull: u32,
    output: u32,
    lock: u32,
    functions: [u32; 2],
}

impl Port {
    /// As after a reset (RM0433 11.4): analog, but for the pins of the debug port.
    fn initial(port: usize) -> Port {
        let (mode, speed, pull) = match port {
            0 => (0xabff_ffff, 0x0c00_0000, 0x6400_0000),
            1 => (0xffff_febf, 0x0000_00c0, 0x0000_0100),
            _ => (0xffff_ffff, 0, 0),
        };
        Port { mode, speed, pull, ..Port::default() }
    }
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Gpio {
    ports: [Port; PORTS],
    signals: HashMap<Source, Option<bool>>,
    /// What the world drives.
    outside: HashMap<Pin, bool>,
    levels: [[Level; 16]; PORTS],
    driven_at_reset: bool,
    /// Ports that the package has.
    package: usize,
    /// Every change since power-on.
    pub changes: Vec<Change>,
    /// A pin that the package does not have is used.
    pub complaint: Option<String>,
}

impl Default for Gpio {
    fn default() -> Self {
        let mut gpio = Gpio {
            ports: std::array::from_fn(Port::initial),
            signals: HashMap::new(),
            outside: HashMap::new(),
            levels: [[Level::Floating; 16]; PORTS],
            driven_at_reset: false,
            package: PORTS,
            changes: Vec::new(),
            complaint: None,
        };
        (0..PORTS).for_each(|port| gpio.look(port, 0));
        // That is how the pins are, not what became of them.
        gpio.changes.clear();
        gpio
    }
}

impl Gpio {
    /// What a pin does.
    pub fn level(&self, pin: Pin) -> Level {
        self.levels[usize::from(pin.0)][usize::from(pin.1)]
    }

    /// What is read at a pin: what the world drives wins over a pull, what the chip drives over the
    /// world.
    pub fn reads(&self, pin: Pin) -> bool {
        match (self.level(pin), self.outside.get(&pin)) {
            (Level::Driven(level), _) => level,
            (_, Some(&level)) => level,
            (Level::Pulled(up), None) => up,
            (Level::Floating, None) => false,
        }
    }

    /// The world drives a pin, or lets it go.
    pub fn drive(&mut self, pin: Pin, level: Option<bool>) {
        match level {
            Some(level) => self.outside.insert(pin, level),
            None => self.outside.remove(&pin),
        };
    }

    /// The chip is on this board from now on.
    pub fn mount(&mut self, board: Board) {
        self.package = board.ports;
    }

    /// PB0 is an output after every reset, this one included.
    pub fn drive_at_reset(&mut self) {
        self.driven_at_reset = true;
        self.ports[1].mode = self.ports[1].mode & !3 | 1;
    }

    /// The level that the world drives at a pin.
    pub fn outside(&self, pin: Pin) -> Option<bool> {
        self.outside.get(&pin).copied()
    }

    /// The alternate function that a pin is switched to, if it is.
    pub fn alternate(&self, pin: Pin) -> Option<u32> {
        let port = &self.ports[usize::from(pin.0)];
        let n = usize::from(pin.1);
        (port.mode >> (2 * n) & 3 == 2).then(|| port.functions[n / 8] >> (4 * (n % 8)) & 0xf)
    }

    /// A peripheral's output has changed.
    pub fn publish(&mut self, source: Source, level: Option<bool>, at: Time) {
        if self.signals.insert(source, level) != Some(level) {
            for (pin, _, _) in FUNCTIONS.iter().filter(|(_, _, of)| *of == source) {
                self.look_at(pin.0.into(), 1 << pin.1, at);
            }
        }
    }

    fn look(&mut self, port: usize, at: Time) {
        self.look_at(port, 0xffff, at);
    }

    /// Works out the levels of some pins of a port and notes what has changed.
    fn look_at(&mut self, port: usize, pins: u32, at: Time) {
        let registers = self.ports[port];
        for n in (0..16).filter(|n| pins >> n & 1 != 0) {
            let pin = Pin(port as u8, n as u8);
            let pulled = match registers.pull >> (2 * n) & 3 {
                1 => Level::Pulled(true),
                2 => Level::Pulled(false),
                _ => Level::Floating,
            };
            let drives = |level: bool| {
                let open = registers.kind >> n & 1 != 0;
                if open && level { pulled } else { Level::Driven(level) }
            };
            let level = match registers.mode >> (2 * n) & 3 {
                0 => pulled,
                1 => drives(registers.output >> n & 1 != 0),
                2 => {
                    let number = registers.functions[n / 8] >> (4 * (n % 8)) & 0xf;
                    let source = function(pin, number).and_then(|source| self.signals.get(&source).copied().flatten());
                    source.map_or(pulled, drives)
                }
                _ => Level::Floating,
            };
            if level != self.levels[port][n] {
                self.levels[port][n] = level;
                self.changes.push(Change { at, pin, level });
            }
        }
    }
}

impl Device for Gpio {
    fn read(&mut self, offset: u32, _: Time, _: &mut Vec<Signal>) -> Option<u32> {
        let number = (offset / 0x400) as usize;
        let port = *self.ports.get(number)?;
        Some(match offset % 0x400 {
            0x00 => port.mode,
            0x04 => port.kind,
            0x08 => port.speed,
            0x0c => port.pull,
            // An analog pin reads as 0 (RM0433 11.3.12).
            0x10 => (0..16).fold(0, |all, n| {
                let high = port.mode >> (2 * n) & 3 != 3 && self.reads(Pin(number as u8, n));
                all | u32::from(high) << n
            }),
            0x14 => port.output,
            0x18 => 0,
            0x1c => port.lock,
            0x20 => port.functions[0],
            0x24 => port.functions[1],
            _ => return None,
        })
    }

    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, _: &mut Vec<Signal>) -> Option<()> {
        let number = (offset / 0x400) as usize;
        if number >= self.package {
            let port = char::from(b'A' + number as u8);
            self.complaint.get_or_insert_with(|| format!("port {port} is written, and the package has no pin of it"));
        }
        let port = self.ports.get_mut(number)?;
        let new = |before: &mut u32| *before = *before & !mask | value & mask;
        let before = port.output;
        match offset % 0x400 {
            0x00 => new(&mut port.mode),
            0x04 => new(&mut port.kind),
            0x08 => new(&mut port.speed),
            0x0c => new(&mut port.pull),
            0x10 => {}
            0x14 => new(&mut port.output),
            // Where both are written, setting wins (RM0433 11.4.7).
            0x18 => {
                let (set, clear) = (value & mask & 0xffff, (value & mask) >> 16);
                port.output = port.output & !clear | set;
            }
            0x1c => new(&mut port.lock),
            0x20 => new(&mut port.functions[0]),
            0x24 => new(&mut port.functions[1]),
            _ => return None,
        }
        let pins = if matches!(offset % 0x400, 0x14 | 0x18) { before ^ port.output } else { u32::MAX };
        self.look_at(number, pins, at);
        Some(())
    }

    fn next(&self) -> Time {
        NEVER
    }

    fn advance(&mut self, _: Time, _: &mut Vec<Signal>) {}

    fn reset(&mut self, at: Time, _: &mut Vec<Signal>) {
        self.ports = std::array::from_fn(Port::initial);
        if self.driven_at_reset {
            self.drive_at_reset();
        }
        (0..PORTS).for_each(|port| self.look(port, at));
    }
}
