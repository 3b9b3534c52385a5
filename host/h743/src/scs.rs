//! The system control space of the core: NVIC, SCB, SysTick, MPU, caches (Armv7-M Architecture
//! Reference Manual, B3).
//!
//! In: reads and writes of 0xE000_E000 to 0xE000_EFFF. Out: the pending exceptions, a requested
//! reset, the state of the MPU. Owns those registers. Fails: a register that is not here is `None`,
//! and the machine reports it. Caches and MPU hold what was written. Of the MPU, the machine
//! enforces regions without any right, in whole pages.
use crate::exceptions::{COUNT, Exceptions, MEMORY_FAULT, NMI, PEND_SV, SYS_TICK, Set, USAGE_FAULT};
use crate::time::{NEVER, Time};

/// Lines of interrupts that the implementation has, in words of 32.
const WORDS: u32 = 5;

/// A region of the MPU.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MpuRegion {
    /// RBAR without its number.
    pub base: u32,
    /// RASR.
    pub attributes: u32,
}

impl MpuRegion {
    /// Its span, if it is on and gives no right.
    pub fn forbidden(self) -> Option<(u32, u64)> {
        let on = self.attributes & 1 != 0;
        let rights = self.attributes >> 24 & 7;
        let size = 1u64 << ((self.attributes >> 1 & 0x1f) + 1);
        (on && rights == 0).then_some((self.base, size))
    }
}

/// What a core says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// CPUID.
    pub cpuid: u32,
    /// FPCCR after a reset.
    pub fpccr: u32,
    /// CCR.IC and CCR.DC stay 0.
    pub lacks_caches: bool,
    /// Cycles of an instruction.
    pub instruction_cycles: Time,
}

impl Default for Identity {
    /// A Cortex-M7 r1p1; floating-point registers are stacked lazily.
    fn default() -> Self {
        Identity { cpuid: 0x411f_c271, fpccr: 0xc000_0000, lacks_caches: false, instruction_cycles: 1 }
    }
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Scs {
    /// Which core it is.
    pub identity: Identity,
    /// What waits and what runs.
    pub exceptions: Exceptions,
    /// VTOR.
    pub vectors: u32,
    /// CFSR: why a fault came.
    pub cfsr: u32,
    /// HFSR.
    pub hfsr: u32,
    /// Where a fault of the MPU was.
    pub mmfar: u32,
    /// Where a fault of the bus was.
    pub bfar: u32,
    /// CCR.
    pub ccr: u32,
    /// SCR.
    pub scr: u32,
    /// CPACR.
    pub cpacr: u32,
    /// Somebody asked for a reset.
    pub wants_reset: bool,
    /// MPU_CTRL.
    pub mpu_control: u32,
    /// The MPU's regions.
    pub mpu: [MpuRegion; 16],
    mpu_number: u32,
    /// Counts writes to the MPU, so that the machine notices a change.
    pub mpu_writes: u32,
    /// FPCCR.
    pub fpccr: u32,
    cache_size: u32,
    systick: SysTick,
}

impl Default for Scs {
    fn default() -> Self {
        let identity = Identity::default();
        Scs {
            identity,
            exceptions: Exceptions::default(),
            vectors: 0x0800_0000,
            cfsr: 0,
            hfsr: 0,
            mmfar: 0,
            bfar: 0,
            // STKALIGN.
            ccr: 1 << 9,
            scr: 0,
            cpacr: 0,
            wants_reset: false,
            mpu_control: 0,
            mpu: [MpuRegion::default(); 16],
            mpu_number: 0,
            mpu_writes: 0,
            fpccr: identity.fpccr,
            cache_size: 0,
            systick: SysTick { due: NEVER, ..SysTick::default() },
        }
    }
}

impl Scs {
    /// What a read of a word gives; `None` where no register is modelled. `running` is the
    /// exception that runs.
    pub fn read(&mut self, offset: u32, running: usize, at: Time, cycle: Time) -> Option<u32> {
        let exceptions = &self.exceptions;
        Some(match offset {
            0x004 => WORDS - 1,
            0x010 => self.systick.control(),
            0x014 => self.systick.reload,
            0x018 => self.systick.value(at, cycle),
            // CALIB: no reference.
            0x01c => 0x8000_0000,
            0x100..0x114 | 0x180..0x194 => word(offset, exceptions.enabled),
            0x200..0x214 | 0x280..0x294 => word(offset, exceptions.pending),
            0x300..0x314 => word(offset, exceptions.active),
            0x400..0x496 => {
                let first = 16 + (offset - 0x400) as usize;
                (0..4).rev().fold(0, |value, n| {
                    value << 8 | u32::from(exceptions.priority.get(first + n).copied().unwrap_or(0))
                })
            }
            0xd00 => self.identity.cpuid,
            0xd04 => self.icsr(running),
            0xd08 => self.vectors,
            0xd0c => 0xfa05_0000 | exceptions.group << 8,
            0xd10 => self.scr,
            0xd14 => self.ccr,
            0xd18 | 0xd1c | 0xd20 => {
                let first = 4 + (offset - 0xd18) as usize;
                (0..4).rev().fold(0, |value, n| value << 8 | u32::from(exceptions.priority[first + n]))
            }
            0xd24 => self.shcsr(),
            0xd28 => self.cfsr,
            0xd2c => self.hfsr,
            0xd30 => 0,
            0xd34 => self.mmfar,
            0xd38 => self.bfar,
            // CLIDR, CTR, CCSIDR of 16 KiB data (4 ways of 128 lines) and instructions (2 ways of
            // 256 lines).
            0xd78 => 0x0900_0003,
            0xd7c => 0x8303_c003,
            0xd80 if self.cache_size & 1 == 0 => 0xf00f_e019,
            0xd80 => 0xf01f_e009,
            0xd84 => self.cache_size,
            0xd88 => self.cpacr,
            0xd90 => 16 << 8,
            0xd94 => self.mpu_control,
            0xd98 => self.mpu_number,
            0xd9c | 0xda4 | 0xdac | 0xdb4 => self.mpu[self.mpu_number as usize].base | self.mpu_number,
            0xda0 | 0xda8 | 0xdb0 | 0xdb8 => self.mpu[self.mpu_number as usize].attributes,
            0xf34 => self.fpccr,
            // ITCMCR, DTCMCR: on, 64 and 128 KiB (PM0253 4.8.1); AHBPCR; CACR.
            0xf90 => 7 << 3 | 1,
            0xf94 => 8 << 3 | 1,
            0xf98 | 0xf9c => 0,
            _ => return None,
        })
    }

    /// A write of a word, or of a byte where `mask` says so. `None` where no register is modelled.
    pub fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, cycle: Time) -> Option<()> {
        match offset {
            0x010 => self.systick.set_control(value, at, cycle),
            0x014 => self.systick.reload = value & 0xff_ffff,
            0x018 => self.systick.clear(at),
            0x100..0x114 => each(offset, value, |n| self.exceptions.enabled.set(n, true)),
            0x180..0x194 => each(offset, value, |n| self.exceptions.enabled.set(n, false)),
            0x200..0x214 => each(offset, value, |n| self.exceptions.pending.set(n, true)),
            0x280..0x294 => each(offset, value, |n| self.exceptions.clear_pending(n)),
            0x400..0x496 => self.set_priorities(16 + (offset - 0x400) as usize, value, mask),
            0xd04 => self.set_icsr(value),
            0xd08 => self.vectors = value & 0xffff_ff80,
            0xd0c => {
                if value >> 16 == 0x05fa {
                    self.exceptions.group = value >> 8 & 7;
                    self.wants_reset |= value & 1 << 2 != 0;
                }
            }
            0xd10 => self.scr = value,
            0xd14 => {
                let absent = if self.identity.lacks_caches { 3 << 16 } else { 0 };
                self.ccr = value & !absent | 1 << 9;
            }
            0xd18 | 0xd1c | 0xd20 => self.set_priorities(4 + (offset - 0xd18) as usize, value, mask),
            0xd24 => {
                for (bit, exception) in (16..).zip(MEMORY_FAULT..=USAGE_FAULT) {
                    self.exceptions.enabled.set(exception, value & 1 << bit != 0);
                }
            }
            0xd28 => self.cfsr &= !value,
            0xd2c => self.hfsr &= !value,
            0xd30 => {}
            0xd84 => self.cache_size = value & 0xf,
            0xd88 => self.cpacr = value,
            0xd94..=0xdb8 => self.write_mpu(offset, value),
            0xf00 => {
                let exception = 16 + (value & 0x1ff) as usize;
                if exception < COUNT {
                    self.exceptions.pending.set(exception, true);
                }
            }
            0xf34 => self.fpccr = value,
            // Cache maintenance: there is no cache.
            0xf50..=0xf78 => {}
            _ => return None,
        }
        Some(())
    }

    /// Whether the core's writes to this address may stay in its data cache (Armv7-M B3.5, table
    /// B3-15 for what no region covers): a DMA would read what was there before.
    pub fn holds_back(&self, address: u32) -> bool {
        let cached = self.ccr & 1 << 16 != 0;
        let covers = |region: &&MpuRegion| {
            let size = 1u64 << ((region.attributes >> 1 & 0x1f) + 1);
            let offset = u64::from(address).checked_sub(u64::from(region.base));
            let part = offset.filter(|&offset| offset < size).map(|offset| offset * 8 / size);
            region.attributes & 1 != 0 && part.is_some_and(|part| region.attributes >> (8 + part) & 1 == 0)
        };
        let region = self.mpu.iter().rev().find(covers).filter(|_| self.mpu_control & 1 != 0);
        let writes_back = match region {
            // TEX, C, B: write-back is 0 1 1, 1 1 1, and an outer policy with an inner one of
            // write-back.
            Some(region) => match (region.attributes >> 19 & 7, region.attributes >> 16 & 3) {
                (0 | 1, 3) => true,
                (4..=7, inner) => inner & 1 != 0,
                _ => false,
            },
            None => (0x2000_0000..0x4000_0000).contains(&address),
        };
        cached && writes_back
    }

    fn write_mpu(&mut self, offset: u32, value: u32) {
        self.mpu_writes += 1;
        match offset {
            0xd94 => self.mpu_control = value & 7,
            0xd98 => self.mpu_number = value & 0xf,
            0xd9c | 0xda4 | 0xdac | 0xdb4 => {
                if value & 1 << 4 != 0 {
                    self.mpu_number = value & 0xf;
                }
                self.mpu[self.mpu_number as usize].base = value & 0xffff_ffe0;
            }
            _ => self.mpu[self.mpu_number as usize].attributes = value,
        }
    }

    fn set_priorities(&mut self, first: usize, value: u32, mask: u32) {
        for n in 0..4 {
            if mask >> (8 * n) & 0xff != 0 && first + n < COUNT {
                self.exceptions.set_priority(first + n, (value >> (8 * n)) as u8);
            }
        }
    }

    fn icsr(&self, running: usize) -> u32 {
        let e = &self.exceptions;
        let next = e.waiting().next().unwrap_or(0) as u32;
        let others = e.active.iter().any(|n| n != running);
        running as u32
            | u32::from(!others) << 11
            | next << 12
            | u32::from(e.pending.iter().any(|n| n >= 16)) << 22
            | u32::from(e.pending[SYS_TICK]) << 26
            | u32::from(e.pending[PEND_SV]) << 28
            | u32::from(e.pending[NMI]) << 31
    }

    fn set_icsr(&mut self, value: u32) {
        let pending = &mut self.exceptions.pending;
        let bit = |n: u32| value & 1 << n != 0;
        pending.set(SYS_TICK, (pending[SYS_TICK] || bit(26)) && !bit(25));
        pending.set(PEND_SV, (pending[PEND_SV] || bit(28)) && !bit(27));
        pending.set(NMI, pending[NMI] || bit(31));
    }

    fn shcsr(&self) -> u32 {
        let e = &self.exceptions;
        (16..).zip(MEMORY_FAULT..=USAGE_FAULT).fold(0, |value, (bit, n)| value | u32::from(e.enabled[n]) << bit)
    }

    /// When SysTick wants to be looked at.
    pub fn next(&self) -> Time {
        self.systick.due
    }

    /// SysTick has come to zero, if it has.
    pub fn advance(&mut self, to: Time) {
        if self.systick.passes(to) {
            self.exceptions.pending.set(SYS_TICK, true);
        }
    }
}

/// Sixteen words after the set's first offset begins the next one; a word holds 32 interrupts.
fn word(offset: u32, set: Set) -> u32 {
    let first = 16 + 8 * (offset & 0x7f) as usize;
    (0..32).filter(|n| first + n < COUNT).fold(0, |value, n| value | u32::from(set[first + n]) << n)
}

fn each(offset: u32, value: u32, mut what: impl FnMut(usize)) {
    let first = 16 + 8 * (offset & 0x7f) as usize;
    (0..32).filter(|n| value & 1 << n != 0 && first + n < COUNT).for_each(|n| what(first + n));
}

/// The core's timer, clocked by the core.
#[derive(Debug, Clone, Default)]
struct SysTick {
    enabled: bool,
    interrupts: bool,
    reload: u32,
    /// When it reaches zero next, while it counts.
    due: Time,
    cycle: Time,
    /// Where it stood when it did not count.
    held: u32,
    passed: bool,
}

impl SysTick {
    fn control(&mut self) -> u32 {
        let value = u32::from(self.enabled) | u32::from(self.interrupts) << 1 | 1 << 2 | u32::from(self.passed) << 16;
        self.passed = false;
        value
    }

    fn set_control(&mut self, value: u32, at: Time, cycle: Time) {
        let enabled = value & 1 != 0;
        if enabled && !self.enabled {
            self.cycle = cycle;
            let left = if self.held == 0 { self.reload + 1 } else { self.held };
            self.due = at + Time::from(left) * cycle;
        } else if !enabled {
            self.held = self.value(at, cycle);
            self.due = NEVER;
        }
        self.enabled = enabled;
        self.interrupts = value & 2 != 0;
    }

    fn value(&self, at: Time, cycle: Time) -> u32 {
        if !self.enabled {
            return self.held;
        }
        let left = self.due.saturating_sub(at).div_ceil(cycle.max(1)) as u32;
        // At its end it is zero for a cycle.
        if left > self.reload { 0 } else { left }
    }

    fn clear(&mut self, at: Time) {
        self.held = 0;
        self.passed = false;
        if self.enabled {
            self.due = at + Time::from(self.reload + 1) * self.cycle;
        }
    }

    /// Whether it passed zero, with its interrupt on.
    fn passes(&mut self, to: Time) -> bool {
        if !self.enabled || self.due > to || self.reload == 0 {
            return false;
        }
        self.passed = true;
        self.due += Time::from(self.reload + 1) * self.cycle;
        self.interrupts
    }
}
