//! The board: core, memories and peripherals together, and the loop that runs them.
//!
//! In: an image, time to pass, bytes of the host, levels at pins. Out: what the pins did, bytes of
//! the board, how each run ended. An instruction takes one cycle of the core's clock, entering and
//! leaving an exception [`ENTRY`] and [`EXIT`] cycles; a core that waits for an interrupt takes no
//! time of the host's. So instants are those of an ideal core with no cache misses: exact for what
//! timers do, an estimate for what instructions do.
use crate::accesses::Accesses;
use crate::board::{Board, NUCLEO};
use crate::bus::Bus;
use crate::counted::Counted;
use crate::device::Cause;
use crate::dwt::Dwt;
use crate::engine::{Engine, Exit, Guest, Register};
use crate::exceptions::{BUS_FAULT, HARD_FAULT, MEMORY_FAULT, Masks, SUPERVISOR_CALL, USAGE_FAULT};
use crate::memory::{Memory, PAGE};
use crate::scs::{Identity, Scs};
use crate::time::{NEVER, Time};
use std::sync::Arc;

/// Cycles from an exception to its first instruction, and back (Cortex-M7 TRM: 12 without stalls).
pub const ENTRY: Time = 12;
/// See [`ENTRY`].
pub const EXIT: Time = 12;

/// The private peripheral bus begins here; the system control space is its part at +0xE000.
const PRIVATE: u32 = 0xe000_0000;
const SCS: u32 = 0xe000_e000;
/// Among its registers, but of debugging.
const DEMCR: u32 = 0xe000_edfc;
/// RCC_AHB2ENR and AHB4ENR, PWR_CR1.
const MEMORY_SWITCHES: [u32; 3] = [0x5802_44dc, 0x5802_44e0, 0x5802_4800];
/// Registers of the streams of DMA1 and DMA2.
const DMA_STREAMS: std::ops::Range<u32> = 0x4002_0000..0x4002_0800;
/// What start-up leaves as it is: KEPT of `memory.x`, 256 bytes.
const LEFT: u32 = 0x3004_7f00;
/// Registers of the MPU.
const MPU: std::ops::Range<u32> = 0xe000_ed94..0xe000_edbc;

/// What surrounds the core, while it runs.
pub struct Chip {
    /// Memories.
    pub memory: Arc<Memory>,
    /// The core's system block.
    pub scs: Scs,
    /// Peripherals.
    pub bus: Bus,
    /// What the core is and says of itself, from every reset on.
    pub identity: Identity,
    dwt: Dwt,
    /// Time.
    pub now: Time,
    /// Instructions executed.
    pub instructions: u64,
    /// An exception whose handler's instructions are counted.
    pub counted: Option<Counted>,
    /// An exception whose handler's data are counted, in a machine that [`Machine::watch`]es.
    pub accesses: Option<Accesses>,
    cycle: Time,
    limit: Time,
    /// The machine has to look before the next instruction.
    attention: bool,
    waits: bool,
    /// It does nothing until a reset.
    locked_up: bool,
    /// An IT block: the core does not stop inside it.
    block: std::ops::Range<u32>,
    /// The address of the instruction that runs.
    at: u32,
    /// The exception that runs.
    running: usize,
    /// Spans that the MPU forbids to everybody: first address and bytes.
    forbidden: Vec<(u32, u64)>,
    /// The instruction that runs touched what is forbidden in the first page.
    failed: bool,
    /// A reset clears [`LEFT`].
    pub forgets: bool,
}

impl Chip {
    pub(crate) fn settle(&mut self) {
        if self.scs.next() <= self.now {
            self.scs.advance(self.now);
            self.attention = true;
        }
        if self.bus.next() <= self.now {
            self.bus.settle(self.now, &mut self.scs.exceptions);
            self.attention = true;
        }
    }

    /// Marks what the machine has to look at after an access.
    fn after_access(&mut self) {
        self.cycle = self.bus.clocks().core;
        self.attention |= self.bus.reset.is_some() || self.scs.wants_reset || self.scs.exceptions.is_any_pending();
    }

    /// Handles an instruction that the engine does not report.
    fn decode(&mut self, address: u32) {
        match self.memory.code(address) {
            // WFI; WFE ends at once, as after an event.
            0xbf30 => {
                self.waits = true;
            }
            0xbf00 | 0xbf10 | 0xbf20 | 0xbf40 => {}
            it @ 0xbf00..=0xbfff => {
                let count = 4 - (it & 0xf).trailing_zeros();
                let mut end = address + 2;
                for _ in 0..count {
                    end += if self.memory.code(end) >= 0xe800 { 4 } else { 2 };
                }
                self.block = address + 1..end;
            }
            // CPS and MSR may let an exception in.
            0xb660..=0xb67f | 0xf380..=0xf38f => self.attention |= self.scs.exceptions.is_any_pending(),
            _ => {}
        }
    }

    /// Whether the MPU forbids it.
    pub(crate) fn is_forbidden(&self, address: u32, length: u32) -> bool {
        let (first, end) = (u64::from(address), u64::from(address) + u64::from(length));
        let meets = |&(base, size): &(u32, u64)| u64::from(base) < end && first < u64::from(base) + size;
        self.forbidden.iter().any(meets)
    }

    /// Whether an access to the first page is forbidden; then the fault comes before the next
    /// instruction.
    fn fails(&mut self, address: u32, size: u32) -> bool {
        let fails = self.is_forbidden(address, size);
        self.failed |= fails;
        self.attention |= fails;
        fails
    }

    /// An exception begins, or ends.
    pub(crate) fn note(&mut self, exception: usize, begins: bool) {
        if let Some(counted) = &mut self.counted {
            counted.note(exception, begins, self.instructions);
        }
        if let Some(accesses) = &mut self.accesses {
            accesses.note(exception, begins);
        }
    }

    fn complain(&mut self, complaint: String) {
        if !self.bus.complaints.contains(&complaint) {
            self.bus.complaints.push(complaint);
        }
    }
}

impl Guest for Chip {
    fn before(&mut self, address: u32) -> bool {
        if !self.block.contains(&address) {
            if self.now >= self.bus.next().min(self.scs.next()) {
                self.settle();
            }
            if self.attention || self.waits || self.now >= self.limit {
                return true;
            }
        }
        self.at = address;
        self.now += self.cycle * self.identity.instruction_cycles;
        self.instructions += 1;
        self.decode(address);
        false
    }

    fn read(&mut self, address: u32, size: u32) -> u32 {
        if address < PAGE as u32 {
            return if self.fails(address, size) { 0 } else { self.memory.number(address, size).unwrap_or(0) };
        }
        let aligned = address & !3;
        let value = if aligned & 0xffff_f000 == SCS && aligned != DEMCR {
            self.settle();
            self.scs.read(aligned - SCS, self.running, self.now, self.cycle)
        } else if aligned >= PRIVATE {
            self.dwt.read(aligned, self.now, self.cycle)
        } else {
            self.bus.read(aligned, self.now, &mut self.scs.exceptions)
        };
        self.after_access();
        let Some(value) = value else {
            self.complain(format!("{address:#010x} is read at {:#010x}: not modelled", self.at));
            return 0;
        };
        let value = value >> (8 * (address & 3));
        if size < 4 { value & ((1 << (8 * size)) - 1) } else { value }
    }

    fn write(&mut self, address: u32, size: u32, value: u32) {
        if address < PAGE as u32 {
            if !self.fails(address, size) {
                self.memory.load(address, &value.to_le_bytes()[..size.min(4) as usize]);
            }
            return;
        }
        let (aligned, shift) = (address & !3, 8 * (address & 3));
        let mask = if size < 4 { ((1 << (8 * size)) - 1) << shift } else { u32::MAX };
        let value = value << shift;
        let done = if aligned & 0xffff_f000 == SCS && aligned != DEMCR {
            self.settle();
            self.scs.write(aligned - SCS, value, mask, self.now, self.cycle)
        } else if aligned >= PRIVATE {
            self.dwt.write(aligned, value, self.now, self.cycle)
        } else {
            self.bus.write(aligned, value, mask, self.now, &mut self.scs.exceptions)
        };
        if done.is_none() {
            self.complain(format!("{address:#010x} is written at {:#010x}: not modelled", self.at));
        }
        self.after_access();
        if DMA_STREAMS.contains(&aligned) {
            for (base, size) in self.bus.dma.spans() {
                if self.scs.holds_back(base) || self.scs.holds_back(base + size.max(1) - 1) {
                    self.complain(format!(
                        "a DMA uses {size} bytes at {base:#010x}, which the core's cache holds back"
                    ));
                }
            }
        }
        // Memories may have come or gone, by their clocks or by the MPU.
        self.attention |= MEMORY_SWITCHES.contains(&aligned) || MPU.contains(&aligned);
    }

    fn touched(&mut self, address: u32, size: u32, is_write: bool) {
        if let Some(accesses) = &mut self.accesses {
            accesses.touch(self.running, address, size, is_write);
        }
    }
}

/// Why [`Machine::run`] came back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// The time is over.
    Time,
    /// The chip was reset, and has not begun anew yet.
    Reset(Cause),
    /// BKPT at this address.
    Breakpoint(u32),
    /// A fault while a fault was handled: the core stops until a reset.
    Lockup,
}

/// See the module text.
pub struct Machine {
    engine: Engine<Chip>,
    /// Everything but the core's registers.
    pub chip: Chip,
    mapped: Vec<u32>,
    mpu_seen: u32,
    /// Resets since power-on, with their instants.
    pub resets: Vec<(Time, Cause)>,
}

impl Machine {
    /// A Nucleo without an image.
    pub fn new() -> Result<Machine, String> {
        Machine::on(NUCLEO)
    }

    /// A board without an image.
    pub fn on(board: Board) -> Result<Machine, String> {
        let memory = Arc::new(Memory::new());
        let engine = Engine::new(memory.clone())?;
        let mut chip = Chip {
            bus: Bus::new(memory.clone()),
            memory,
            scs: Scs::default(),
            identity: Identity::default(),
            dwt: Dwt::default(),
            now: 0,
            instructions: 0,
            counted: None,
            accesses: None,
            cycle: crate::clocks::Clocks::RESET.core,
            limit: NEVER,
            attention: false,
            waits: false,
            locked_up: false,
            block: 0..0,
            at: 0,
            running: 0,
            forbidden: Vec::new(),
            failed: false,
            forgets: false,
        };
        chip.bus.mount(board);
        let mut machine = Machine { engine, chip, mapped: Vec::new(), mpu_seen: 0, resets: Vec::new() };
        machine.begin();
        Ok(machine)
    }

    /// The core fetches stack and entry from the vector table, at the address that the boot option
    /// gives (RM0433 2.6: flash).
    fn begin(&mut self) {
        let chip = &mut self.chip;
        (chip.attention, chip.waits, chip.block, chip.running, chip.failed) = (false, false, 0..0, 0, false);
        chip.locked_up = false;
        let base = chip.scs.vectors;
        let stack = chip.memory.word(base).unwrap_or(0);
        let entry = chip.memory.word(base + 4).unwrap_or(0);
        for (register, value) in [
            (Register::Xpsr, 1 << 24),
            (Register::Control, 0),
            (Register::Primask, 0),
            (Register::Faultmask, 0),
            (Register::Basepri, 0),
            (Register::Msp, stack),
            (Register::Sp, stack),
            (Register::Lr, u32::MAX),
            (Register::Pc, entry),
        ] {
            self.engine.set(register, value);
        }
    }

    /// Accesses to data are counted from now on, as [`Chip::accesses`] says; before an image boots.
    pub fn watch(&mut self) -> Result<(), String> {
        self.engine.watch()
    }

    /// Loads an image and starts it, as after power has come.
    pub fn boot(&mut self, elf: &[u8]) -> Result<(), String> {
        crate::image::load(elf, &self.chip.memory)?;
        self.begin();
        Ok(())
    }

    /// Resets the chip; memories keep what they hold.
    pub fn reset(&mut self, cause: Cause) {
        let chip = &mut self.chip;
        self.resets.push((chip.now, cause));
        if chip.forgets {
            chip.memory.load(LEFT, &[0; 0x100]);
        }
        chip.scs = Scs::default();
        chip.scs.identity = chip.identity;
        (chip.scs.fpccr, chip.dwt) = (chip.identity.fpccr, Dwt::default());
        chip.bus.reset_all(cause, chip.now, &mut chip.scs.exceptions);
        chip.cycle = chip.bus.clocks().core;
        self.mpu_seen = u32::MAX;
        self.arrange();
        self.begin();
    }

    /// Memories without a clock are not there; regions of the MPU without a right neither.
    fn arrange(&mut self) {
        for region in self.chip.memory.regions() {
            if region.clock.is_none() {
                continue;
            }
            let (is, shall) = (self.mapped.contains(&region.base), self.chip.bus.has_memory(region));
            if is != shall && self.engine.map(region.base, shall).is_ok() {
                if shall { self.mapped.push(region.base) } else { self.mapped.retain(|&base| base != region.base) }
            }
        }
        if self.chip.scs.mpu_writes != self.mpu_seen {
            self.mpu_seen = self.chip.scs.mpu_writes;
            let before = std::mem::take(&mut self.chip.forbidden);
            self.forbid(&before, false);
            if self.chip.scs.mpu_control & 1 == 0 {
                return;
            }
            let spans: Vec<_> = self.chip.scs.mpu.iter().filter_map(|region| region.forbidden()).collect();
            self.forbid(&spans, true);
            self.chip.forbidden = spans;
        }
    }

    /// Takes all rights from the core where these spans meet memory, or gives them back.
    fn forbid(&mut self, spans: &[(u32, u64)], forbidden: bool) {
        let memories = self.chip.memory.clone();
        for &(base, size) in spans {
            for memory in memories.regions().iter().filter(|memory| memory.writable) {
                // The first page is guarded by the chip itself.
                let first = u64::from(base).max(memory.base.into()).max(PAGE as u64);
                let end = (u64::from(base) + size).min(u64::from(memory.base) + u64::from(memory.size));
                if first >= end {
                    continue;
                }
                // The engine guards whole pages. A memory that has lost its clock meanwhile has
                // nothing to give back.
                let done = self.engine.forbid(first as u32, (end - first) as u32, forbidden);
                if forbidden && done.is_err() {
                    self.chip.complain(format!("the MPU's guard of {size} bytes at {base:#010x} is no whole page"));
                }
            }
        }
    }

    /// The core says of itself what it is set to.
    pub(crate) fn identify(&mut self) {
        let chip = &mut self.chip;
        (chip.scs.identity, chip.scs.fpccr) = (chip.identity, chip.identity.fpccr);
    }

    fn masks(&self) -> Masks {
        Masks {
            primask: self.engine.register(Register::Primask) & 1 != 0,
            faultmask: self.engine.register(Register::Faultmask) & 1 != 0,
            basepri: self.engine.register(Register::Basepri) as u8,
        }
    }

    /// A register of the core.
    pub fn register(&self, register: Register) -> u32 {
        self.engine.register(register)
    }

    /// Sets one.
    pub fn set_register(&mut self, register: Register, value: u32) {
        self.engine.set(register, value);
    }

    /// Lets `time` pass.
    pub fn run(&mut self, time: Time) -> Stop {
        let end = self.chip.now.saturating_add(time);
        loop {
            self.chip.settle();
            self.arrange();
            if let Some(cause) = self.asked_reset() {
                self.reset(cause);
                return Stop::Reset(cause);
            }
            self.chip.attention = false;
            if self.chip.locked_up {
                if self.chip.now >= end {
                    return Stop::Time;
                }
                self.chip.now = self.chip.bus.next().min(end).max(self.chip.now);
                continue;
            }
            let masks = self.masks();
            if self.chip.waits {
                if self.chip.scs.exceptions.wakes(masks) {
                    self.chip.waits = false;
                } else if self.chip.now >= end {
                    return Stop::Time;
                } else {
                    let next = self.chip.bus.next().min(self.chip.scs.next());
                    self.chip.now = next.min(end).max(self.chip.now);
                    continue;
                }
            }
            if let Some(exception) = self.chip.scs.exceptions.next(masks) {
                if let Err(stop) = self.enter(exception) {
                    return self.stopped(stop);
                }
                continue;
            }
            if self.chip.now >= end {
                return Stop::Time;
            }
            self.chip.limit = end;
            let pc = self.engine.register(Register::Pc);
            let exit = self.engine.run(&mut self.chip, pc);
            if let Err(stop) = self.leave(exit) {
                return self.stopped(stop);
            }
        }
    }

    /// A core that is locked up says so to the bus.
    fn stopped(&mut self, stop: Stop) -> Stop {
        if stop == Stop::Lockup {
            let chip = &mut self.chip;
            chip.locked_up = true;
            chip.bus.lock_up(chip.now, &mut chip.scs.exceptions);
        }
        stop
    }

    pub(crate) fn asked_reset(&mut self) -> Option<Cause> {
        if self.chip.scs.wants_reset { Some(Cause::Software) } else { self.chip.bus.reset }
    }

    /// What to do after the core has stopped.
    fn leave(&mut self, exit: Exit) -> Result<(), Stop> {
        if std::mem::take(&mut self.chip.failed) {
            // The access has been made already as far as registers go; what counts is where it was.
            let at = self.chip.at;
            self.engine.set(Register::Pc, at | 1);
            // DACCVIOL.
            return self.fault(MEMORY_FAULT, 1 << 1);
        }
        let pc = self.engine.register(Register::Pc);
        match exit {
            Exit::Asked => Ok(()),
            Exit::Call => {
                self.chip.scs.exceptions.pending.set(SUPERVISOR_CALL, true);
                Ok(())
            }
            Exit::Breakpoint => Err(Stop::Breakpoint(pc)),
            Exit::Return => self.return_from(pc),
            _ if self.chip.running != 0 && is_return(pc) => self.return_from(pc),
            // UNDEFINSTR, INVSTATE.
            Exit::Undefined => self.fault(USAGE_FAULT, 1 << 16),
            // PRECISERR; what the MPU forbids looks the same here.
            Exit::Data => self.fault(BUS_FAULT, 1 << 9),
            Exit::Fetch => self.fault(BUS_FAULT, 1 << 8),
            Exit::Other(_) => self.fault(USAGE_FAULT, 1 << 17),
        }
    }

    /// A fault of the instruction at the program counter (B1.5.14): its own exception, or
    /// HardFault.
    fn fault(&mut self, exception: usize, flags: u32) -> Result<(), Stop> {
        let scs = &mut self.chip.scs;
        scs.cfsr |= flags;
        let masks = self.masks();
        let exceptions = &mut self.chip.scs.exceptions;
        let execution = exceptions.execution(masks);
        let taken = if exceptions.enabled[exception] && exceptions.urgency(exception) < execution {
            exception
        } else {
            self.chip.scs.hfsr |= 1 << 30;
            HARD_FAULT
        };
        if taken == HARD_FAULT && execution <= -1 {
            return Err(Stop::Lockup);
        }
        self.enter(taken)
    }

    /// The exception that runs.
    pub fn running(&self) -> usize {
        self.chip.running
    }

    /// Whether the core waits for an interrupt: it takes no instruction until one comes.
    pub fn waits(&self) -> bool {
        self.chip.waits
    }
}

/// EXC_RETURN.
pub(crate) fn is_return(address: u32) -> bool {
    address >= 0xffff_ff00
}

/// The parts of the machine that exceptions need (`frames`).
impl Machine {
    pub(crate) fn engine(&mut self) -> &mut Engine<Chip> {
        &mut self.engine
    }

    pub(crate) fn set_running(&mut self, exception: usize) {
        self.chip.running = exception;
    }

    pub(crate) fn spend(&mut self, cycles: Time) {
        self.chip.now += cycles * self.chip.cycle;
    }

    /// Whether the core may write there now.
    pub(crate) fn may_write(&self, address: u32, length: u32) -> bool {
        let end = u64::from(address) + u64::from(length);
        let memory = &self.chip.memory;
        memory.regions().iter().any(|region| {
            region.writable
                && (region.clock.is_none() || self.mapped.contains(&region.base))
                && region.base <= address
                && end <= u64::from(region.base) + u64::from(region.size)
        }) && !self.chip.is_forbidden(address, length)
    }

    /// The ST-LINK gives its clock, or stops.
    pub fn give_clock(&mut self, source: bool) {
        let chip = &mut self.chip;
        chip.bus.give_clock(source, chip.now, &mut chip.scs.exceptions);
        chip.cycle = chip.bus.clocks().core;
    }
}
