//! Entering and leaving exceptions: frames on the stack (Armv7-M Architecture Reference Manual,
//! B1.5.6 to B1.5.8).
//!
//! In: the exception. Out: the core at its handler, or back where it was. Floating-point registers
//! are stored at once, as with FPCCR.LSPEN 0: but for the time, which counts only then, a program
//! sees the same as with lazy stores.
use crate::engine::Register;
use crate::exceptions::{BUS_FAULT, HARD_FAULT, MEMORY_FAULT, NMI, THREAD};
use crate::machine::{ENTRY, EXIT, Machine, Stop, is_return};

/// R0 to R3, R12, LR, PC, xPSR.
const BASIC: u32 = 0x20;
/// And S0 to S15, FPSCR, a reserved word.
const EXTENDED: u32 = 0x68;
const FPCA: u32 = 1 << 2;
/// FPCCR: floating-point registers are stored only once the handler uses them.
const LSPEN: u32 = 1 << 30;
const SPSEL: u32 = 1 << 1;
/// xPSR: the stack was aligned.
const ALIGNED: u32 = 1 << 9;

impl Machine {
    /// Takes an exception.
    pub(crate) fn enter(&mut self, exception: usize) -> Result<(), Stop> {
        let before = self.running();
        let engine = self.engine();
        let control = engine.register(Register::Control);
        let sp = engine.register(Register::Sp);
        let status = engine.register(Register::Xpsr);
        let floating = control & FPCA != 0;
        let size = if floating { EXTENDED } else { BASIC };
        let misaligned = sp & 4 != 0;
        let frame = sp.wrapping_sub(size) & !7;
        let pc = engine.register(Register::Pc);
        let mut words: Vec<u32> = (0..4).map(|n| engine.register(Register::R(n))).collect();
        words.push(engine.register(Register::R(12)));
        words.push(engine.register(Register::Lr));
        words.push(pc);
        words.push(status & !ALIGNED | 1 << 24 | if misaligned { ALIGNED } else { 0 });
        if floating {
            words.extend((0..16).map(|n| engine.register(Register::S(n))));
            words.push(engine.register(Register::Fpscr));
            words.push(0);
        }
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        // The frame is written at the stack pointer, with or without memory there; if it cannot be
        // written, that is a fault of its own.
        let stored = self.may_write(frame, size) && self.chip.memory.load(frame, &bytes);
        let process = before == 0 && control & SPSEL != 0;
        let engine = self.engine();
        engine.set(Register::Control, control & !(FPCA | SPSEL));
        engine.set(if process { Register::Psp } else { Register::Sp }, frame);
        let kind = if before != 0 {
            0x1
        } else if process {
            0xd
        } else {
            0x9
        };
        let lr = 0xffff_ffe0 | u32::from(!floating) << 4 | kind;
        let taken = if stored { exception } else { self.unstacked(exception, frame, size)? };
        let vector = self.chip.scs.vectors + 4 * taken as u32;
        let handler = self.chip.memory.word(vector).unwrap_or(0);
        let engine = self.engine();
        engine.set(Register::Lr, lr);
        engine.set(Register::Xpsr, taken as u32 | 1 << 24);
        engine.set(Register::Pc, handler);
        self.chip.scs.exceptions.begin(taken);
        self.chip.note(taken, true);
        self.set_running(taken);
        let is_eager = floating && self.chip.scs.fpccr & LSPEN == 0;
        self.spend(ENTRY + if is_eager { u64::from(EXTENDED - BASIC - 4) / 4 } else { 0 });
        Ok(())
    }

    /// The frame could not be written: MSTKERR where the MPU forbids it, else STKERR, and the fault
    /// is taken instead (a HardFault, unless it is one already).
    fn unstacked(&mut self, exception: usize, frame: u32, size: u32) -> Result<usize, Stop> {
        let forbidden = self.chip.is_forbidden(frame, size);
        let scs = &mut self.chip.scs;
        scs.cfsr |= if forbidden { 1 << 4 } else { 1 << 12 };
        if exception == HARD_FAULT || exception == NMI {
            // The handler begins all the same; what it stacks next decides.
            return Ok(exception);
        }
        let fault = if forbidden { MEMORY_FAULT } else { BUS_FAULT };
        if scs.exceptions.enabled[fault] && scs.exceptions.urgency(fault) < scs.exceptions.urgency(exception) {
            return Ok(fault);
        }
        scs.hfsr |= 1 << 30;
        Ok(HARD_FAULT)
    }

    /// Leaves the exception that runs, as EXC_RETURN in `value` says.
    pub(crate) fn return_from(&mut self, value: u32) -> Result<(), Stop> {
        let running = self.running();
        debug_assert!(is_return(value) && running != 0);
        // The engine clears the lowest bit of an address.
        let kind = value & 0xf | 1;
        let floating = value & 1 << 4 == 0;
        let process = kind == 0xd;
        if running != NMI {
            self.engine().set(Register::Faultmask, 0);
        }
        self.chip.scs.exceptions.end(running);
        self.chip.note(running, false);
        let engine = self.engine();
        let frame = engine.register(if process { Register::Psp } else { Register::Sp });
        let size = if floating { EXTENDED } else { BASIC };
        let word = |machine: &Machine, n: u32| machine.chip.memory.word(frame.wrapping_add(4 * n));
        let Some(words) = (0..size / 4).map(|n| word(self, n)).collect::<Option<Vec<u32>>>() else {
            // UNSTKERR.
            self.chip.scs.cfsr |= 1 << 11;
            self.chip.scs.hfsr |= 1 << 30;
            return Err(Stop::Lockup);
        };
        let status = words[7];
        let sp = frame.wrapping_add(size).wrapping_add(if status & ALIGNED != 0 { 4 } else { 0 });
        let returns_to = (status & 0x1ff) as usize;
        let engine = self.engine();
        for n in 0..4 {
            engine.set(Register::R(n), words[usize::from(n)]);
        }
        engine.set(Register::R(12), words[4]);
        if floating {
            for n in 0..16 {
                engine.set(Register::S(n), words[8 + usize::from(n)]);
            }
            engine.set(Register::Fpscr, words[24]);
        }
        // Thread mode again before CONTROL: handlers have the main stack.
        engine.set(Register::Xpsr, status & !ALIGNED | 1 << 24);
        if process {
            engine.set(Register::Psp, sp);
        } else {
            engine.set(Register::Sp, sp);
        }
        let control = engine.register(Register::Control) & !(FPCA | SPSEL);
        engine.set(Register::Control, control | if floating { FPCA } else { 0 } | if process { SPSEL } else { 0 });
        engine.set(Register::Lr, words[5]);
        engine.set(Register::Pc, words[6] | 1);
        self.set_running(returns_to);
        self.spend(EXIT);
        debug_assert!(self.chip.scs.exceptions.execution(Default::default()) <= THREAD);
        Ok(())
    }
}
