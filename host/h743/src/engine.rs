//! The core's instructions, by Unicorn (the instruction translator of QEMU as a library).
//!
//! In: a [`Guest`], which is asked before every instruction and answers for everything that is no
//! memory. Out: why the core stopped. Owns the registers. Everything of the core that is no
//! instruction (exceptions, priorities, sleep) is the guest's: Unicorn knows none of it. The
//! floating-point unit is always on: CPACR has no effect on it.
use crate::memory::{Memory, PAGE};
use std::ffi::{c_int, c_void};
use std::ptr::null_mut;
use std::sync::Arc;

/// What surrounds the core.
pub trait Guest {
    /// Asked before the instruction at `address`; true stops the core in front of it.
    fn before(&mut self, address: u32) -> bool;
    /// The core reads a register of a peripheral or of its own system block, or the first page.
    fn read(&mut self, address: u32, size: u32) -> u32;
    /// The core writes there.
    fn write(&mut self, address: u32, size: u32, value: u32);
    /// The core reads or writes anywhere, where [`Engine::watch`] asks for it.
    fn touched(&mut self, address: u32, size: u32, is_write: bool);
}

/// A register of the core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Register {
    /// R0 to R12.
    R(u8),
    /// The stack pointer in use.
    Sp,
    /// Link register.
    Lr,
    /// Program counter.
    Pc,
    /// Main stack pointer.
    Msp,
    /// Process stack pointer.
    Psp,
    /// CONTROL.
    Control,
    /// All of the program status.
    Xpsr,
    /// PRIMASK.
    Primask,
    /// BASEPRI.
    Basepri,
    /// FAULTMASK.
    Faultmask,
    /// FPSCR.
    Fpscr,
    /// S0 to S31.
    S(u8),
}

impl Register {
    /// Its number in `unicorn/arm.h`.
    fn number(self) -> c_int {
        match self {
            Register::R(n) => 66 + c_int::from(n),
            Register::Sp => 12,
            Register::Lr => 10,
            Register::Pc => 11,
            Register::Msp => 115,
            Register::Psp => 116,
            Register::Control => 117,
            Register::Xpsr => 120,
            Register::Primask => 123,
            Register::Basepri => 124,
            Register::Faultmask => 126,
            Register::Fpscr => 6,
            Register::S(n) => 79 + c_int::from(n),
        }
    }
}

/// Why the core stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// The guest asked for it, or the core waits for an interrupt.
    Asked,
    /// SVC, with the program counter after it.
    Call,
    /// BKPT.
    Breakpoint,
    /// A return from an exception: the program counter holds EXC_RETURN.
    Return,
    /// No such instruction.
    Undefined,
    /// No memory there, or no right to it: data.
    Data,
    /// The same for an instruction.
    Fetch,
    /// Something that a Cortex-M7 of ours never does, with the engine's number.
    Other(i32),
}

#[repr(C)]
struct Uc([u8; 0]);

#[link(name = "unicorn")]
unsafe extern "C" {
    fn uc_open(arch: c_int, mode: c_int, uc: *mut *mut Uc) -> c_int;
    fn uc_close(uc: *mut Uc) -> c_int;
    fn uc_ctl(uc: *mut Uc, control: c_int, ...) -> c_int;
    fn uc_mem_map_ptr(uc: *mut Uc, address: u64, size: usize, rights: u32, bytes: *mut c_void) -> c_int;
    fn uc_mem_unmap(uc: *mut Uc, address: u64, size: usize) -> c_int;
    fn uc_mem_protect(uc: *mut Uc, address: u64, size: usize, rights: u32) -> c_int;
    fn uc_mmio_map(
        uc: *mut Uc,
        address: u64,
        size: usize,
        read: *mut c_void,
        read_data: *mut c_void,
        write: *mut c_void,
        write_data: *mut c_void,
    ) -> c_int;
    fn uc_reg_read(uc: *mut Uc, register: c_int, value: *mut c_void) -> c_int;
    fn uc_reg_write(uc: *mut Uc, register: c_int, value: *const c_void) -> c_int;
    fn uc_hook_add(
        uc: *mut Uc,
        hook: *mut usize,
        kind: c_int,
        callback: *mut c_void,
        data: *mut c_void,
        begin: u64,
        end: u64,
        ...
    ) -> c_int;
    fn uc_emu_start(uc: *mut Uc, begin: u64, until: u64, timeout: u64, count: usize) -> c_int;
    fn uc_emu_stop(uc: *mut Uc) -> c_int;
}

const ARM: c_int = 1;
const THUMB: c_int = 1 << 4;
/// `UC_CTL_WRITE(UC_CTL_CPU_MODEL, 1)`.
const SET_MODEL: c_int = 1 << 30 | 1 << 26 | 7;
/// With M-profile asked for by mode, Unicorn 2.0.1 takes a Cortex-M33; a model named is what it
/// says.
const CORTEX_M7: c_int = 10;
const HOOK_INTERRUPT: c_int = 1;
const HOOK_CODE: c_int = 4;
/// UC_HOOK_MEM_READ, UC_HOOK_MEM_WRITE.
const HOOK_DATA: c_int = 1 << 10 | 1 << 11;
/// UC_MEM_WRITE.
const DATA_WRITE: c_int = 17;
const READ: u32 = 1;
const WRITE: u32 = 2;
const EXECUTE: u32 = 4;
/// Nothing lies here, so the core never stops by itself.
const NOWHERE: u64 = 0xffff_fffe;

/// What the guest answers for: addresses and bytes. Peripherals (RM0433 2.3.2), the private
/// peripheral bus, and the first page of ITCM, in which the MPU may guard less than a page (null).
const ASKED: [(u32, usize); 3] = [(0x4000_0000, 0x2000_0000), (0xe000_0000, 0x10_0000), (0, PAGE)];

/// Who is asked while the core runs, and what interrupted it.
struct Callbacks<G> {
    guest: *mut G,
    interrupt: Option<u32>,
    /// First address of each space, for the callbacks, which get offsets.
    spaces: [Space<G>; ASKED.len()],
}

struct Space<G> {
    base: u32,
    callbacks: *mut Callbacks<G>,
}

/// The core.
pub struct Engine<G: Guest> {
    uc: *mut Uc,
    callbacks: *mut Callbacks<G>,
    memory: Arc<Memory>,
}

// SAFETY: Unicorn 2 keeps everything of an instance in the instance; it is used through `&mut` by
// one thread at a time.
unsafe impl<G: Guest + Send> Send for Engine<G> {}

impl<G: Guest> Engine<G> {
    /// A core with these memories; those that need a clock are not there yet.
    pub fn new(memory: Arc<Memory>) -> Result<Self, String> {
        let mut uc = null_mut();
        // SAFETY: `uc` is the address for the instance.
        check("open", unsafe { uc_open(ARM, THUMB, &raw mut uc) })?;
        let callbacks = Box::into_raw(Box::new(Callbacks {
            guest: null_mut(),
            interrupt: None,
            spaces: ASKED.map(|(base, _)| Space { base, callbacks: null_mut() }),
        }));
        let engine = Engine { uc, callbacks, memory };
        // SAFETY: the instance is open, the model is one of its numbers.
        check("model", unsafe { uc_ctl(uc, SET_MODEL, CORTEX_M7) })?;
        for region in engine.memory.regions().iter().filter(|region| region.clock.is_none()) {
            engine.map(region.base, true)?;
        }
        for (n, (base, size)) in ASKED.into_iter().enumerate() {
            // SAFETY: `callbacks` lives as long as the instance; the functions have the signatures
            // of unicorn.h.
            let done = unsafe {
                (*callbacks).spaces[n].callbacks = callbacks;
                let data = (&raw mut (*callbacks).spaces[n]).cast();
                uc_mmio_map(uc, base.into(), size, read::<G> as *mut c_void, data, write::<G> as *mut c_void, data)
            };
            check("registers", done)?;
        }
        engine.hook(HOOK_CODE, before::<G> as *mut c_void)?;
        engine.hook(HOOK_INTERRUPT, interrupted::<G> as *mut c_void)?;
        Ok(engine)
    }

    fn hook(&self, kind: c_int, callback: *mut c_void) -> Result<(), String> {
        let mut hook = 0;
        // SAFETY: begin after end means everywhere; the callback's signature is that of its kind;
        // `callbacks` outlives the hook.
        check("hook", unsafe { uc_hook_add(self.uc, &raw mut hook, kind, callback, self.callbacks.cast(), 1, 0) })
    }

    /// The guest is told of every access to data from now on. Before the first instruction: code
    /// that is translated already does not tell.
    pub fn watch(&mut self) -> Result<(), String> {
        self.hook(HOOK_DATA, touched::<G> as *mut c_void)
    }

    /// Makes the memory that begins at `base` there or not there for the core.
    pub fn map(&self, base: u32, there: bool) -> Result<(), String> {
        let region = self.memory.regions().iter().find(|region| region.base == base).ok_or("no such memory")?;
        let rights = if region.writable { READ | WRITE | EXECUTE } else { READ | EXECUTE };
        let skipped = if base == 0 { PAGE } else { 0 };
        let (first, size) = (u64::from(base) + skipped as u64, region.size as usize - skipped);
        // SAFETY: the bytes belong to `memory`, which the engine keeps alive; both are pages.
        let done = unsafe {
            if there {
                uc_mem_map_ptr(self.uc, first, size, rights, region.host().add(skipped).cast())
            } else {
                uc_mem_unmap(self.uc, first, size)
            }
        };
        check(region.name, done)
    }

    /// Takes all rights from whole pages that are memory, or gives them back.
    pub fn forbid(&self, base: u32, size: u32, forbidden: bool) -> Result<(), String> {
        let rights = if forbidden { 0 } else { READ | WRITE | EXECUTE };
        // SAFETY: changes rights only.
        check("rights", unsafe { uc_mem_protect(self.uc, base.into(), size as usize, rights) })
    }

    /// A register's value.
    pub fn register(&self, register: Register) -> u32 {
        let mut value = 0u64;
        // SAFETY: no register asked for is wider than eight bytes.
        unsafe { uc_reg_read(self.uc, register.number(), (&raw mut value).cast()) };
        value as u32
    }

    /// Sets one.
    pub fn set(&mut self, register: Register, value: u32) {
        // The writable part of the status has a register of its own: the flags and GE with
        // everything else.
        let number = if register == Register::Xpsr { 138 } else { register.number() };
        let value = u64::from(value);
        // SAFETY: no register set is wider than eight bytes.
        unsafe { uc_reg_write(self.uc, number, (&raw const value).cast()) };
    }

    /// Runs from `pc` until something stops the core.
    pub fn run(&mut self, guest: &mut G, pc: u32) -> Exit {
        // SAFETY: `callbacks` is ours; the pointer to the guest is used only inside the call below,
        // during which no other reference to it exists.
        let (error, interrupt) = unsafe {
            (*self.callbacks).guest = guest;
            (*self.callbacks).interrupt = None;
            let error = uc_emu_start(self.uc, u64::from(pc | 1), NOWHERE, 0, 0);
            (*self.callbacks).guest = null_mut();
            (error, (*self.callbacks).interrupt)
        };
        match (interrupt, error) {
            (Some(2), _) => Exit::Call,
            (Some(7), _) => Exit::Breakpoint,
            (Some(8), _) => Exit::Return,
            (Some(3), _) => Exit::Fetch,
            (Some(4), _) => Exit::Data,
            (Some(n), _) => Exit::Other(n as i32),
            (None, 0) => Exit::Asked,
            (None, 10) => Exit::Undefined,
            (None, 8 | 14) => Exit::Fetch,
            (None, 6 | 7 | 12 | 13) => Exit::Data,
            (None, n) => Exit::Other(n),
        }
    }
}

impl<G: Guest> Drop for Engine<G> {
    fn drop(&mut self) {
        // SAFETY: opened and allocated by `new`, and closed once; the instance is closed before
        // what its callbacks use.
        unsafe {
            uc_close(self.uc);
            drop(Box::from_raw(self.callbacks));
        }
    }
}

fn check(what: &str, error: c_int) -> Result<(), String> {
    if error == 0 { Ok(()) } else { Err(format!("the emulator's library refuses: {what}: error {error}")) }
}

// In the callbacks the guest is there: `run` has set it, and they are called only inside of it.

unsafe extern "C" fn before<G: Guest>(uc: *mut Uc, address: u64, _: u32, callbacks: *mut Callbacks<G>) {
    // SAFETY: see above.
    if unsafe { (*(*callbacks).guest).before(address as u32) } {
        // SAFETY: inside a run of this instance.
        unsafe { uc_emu_stop(uc) };
    }
}

unsafe extern "C" fn interrupted<G: Guest>(uc: *mut Uc, number: u32, callbacks: *mut Callbacks<G>) {
    // SAFETY: see above; inside a run of this instance.
    unsafe {
        (*callbacks).interrupt = Some(number);
        uc_emu_stop(uc);
    }
}

unsafe extern "C" fn touched<G: Guest>(
    _: *mut Uc,
    kind: c_int,
    address: u64,
    size: c_int,
    _: i64,
    callbacks: *mut Callbacks<G>,
) {
    // SAFETY: see above.
    unsafe { (*(*callbacks).guest).touched(address as u32, size as u32, kind == DATA_WRITE) }
}

unsafe extern "C" fn read<G: Guest>(_: *mut Uc, offset: u64, size: u32, space: *mut Space<G>) -> u64 {
    // SAFETY: see above.
    unsafe { (*(*(*space).callbacks).guest).read((*space).base + offset as u32, size).into() }
}

unsafe extern "C" fn write<G: Guest>(_: *mut Uc, offset: u64, size: u32, value: u64, space: *mut Space<G>) {
    // SAFETY: see above.
    unsafe { (*(*(*space).callbacks).guest).write((*space).base + offset as u32, size, value as u32) }
}
