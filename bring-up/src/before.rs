//! What only a reset shows: the words that it leaves, and the breaks of a low supply, which keep
//! their detector as it is until the next one (RM0433 12.3.5, PVDL).
//!
//! [`leave`] writes to the memory that start-up leaves as it is, and resets. [`Before::read`] finds
//! what is left, breaks the timers, writes what they did, and resets again. Then the core is locked
//! up ([`crate::lock_up`]) until the watchdog resets, and all is found. LSEDRV, in the backup
//! domain, counts these resets: the words may be lost, and then no fourth one follows. In: jumper
//! 9. Out: lines. Owns the kept memory and LSEDRV. Nothing else has run in the second step: no pin
//! is driven, and the core runs at 64 MHz.
use crate::chip::{LASERS, SYSCFG_CFGR};
use crate::lock_up;
use crate::report::Report;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::SCB;
use stm32_metapac::rcc::vals::Lsedrv;
use stm32_metapac::timer::vals::{Bkp, Ossi};
use stm32_metapac::{PWR, RCC, SYSCFG};

/// Words that are left, and what they hold.
const WORDS: usize = 8;
const PATTERN: u32 = 0x5a00_a5c3;

#[unsafe(link_section = ".kept.words")]
static LEFT: [AtomicU32; WORDS] = [const { AtomicU32::new(0) }; WORDS];
/// Why the chip had started before (RCC_RSR).
#[unsafe(link_section = ".kept.cause")]
static CAUSE: AtomicU32 = AtomicU32::new(0);
/// One byte of it is written last: less than an ECC word.
#[unsafe(link_section = ".kept.last")]
static LAST: AtomicU32 = AtomicU32::new(0);
/// How they were found, and what the timers did.
#[unsafe(link_section = ".kept.found")]
static FOUND: [AtomicU32; FIGURES] = [const { AtomicU32::new(0) }; FIGURES];
/// A mark; the cause; whether the words and the byte are as written; whether the supply was low; of
/// each timer MOE before, its flags, MOE after.
const FIGURES: usize = 5 + 9;
/// That byte.
const BYTE: u8 = 0xa5;

/// The level that is a voltage at PVD_IN, PB7.
const PVD_IN: u8 = 0b111;
/// SYSCFG_CFGR.PVDL.
const PVDL: u32 = 1 << 2;

/// The steps, in LSEDRV: words are left; the supply was low; the core was locked up.
const LEAVES: u8 = 1;
const BREAKS: u8 = 2;
const LOCKS_UP: u8 = 3;

/// What was found.
pub struct Before {
    found: [u32; FIGURES],
    /// All three resets are over.
    is_whole: bool,
}

fn step() -> u8 {
    RCC.bdcr().read().lsedrv().to_bits()
}

fn set_step(step: u8) {
    RCC.bdcr().modify(|w| w.set_lsedrv(Lsedrv::from_bits(step)));
}

/// The last write of less than an ECC word may be lost, so it repeats the first one, as the board's
/// own image does it (`firmware/src/fault.rs`).
fn keep<const N: usize>(words: &[AtomicU32; N], values: [u32; N]) {
    words.iter().zip(values).for_each(|(word, value)| word.store(value, Relaxed));
    words[0].store(values[0], Relaxed);
    cortex_m::asm::dsb();
}

/// What the words hold.
fn pattern() -> [u32; WORDS] {
    core::array::from_fn(|n| PATTERN + n as u32)
}

/// Leaves the words, then a byte that nothing follows, and resets. It returns where LSEDRV cannot
/// be written: nothing would end the resets.
pub fn leave() {
    set_step(LEAVES);
    if step() != LEAVES {
        return;
    }
    CAUSE.store(RCC.rsr().read().0, Relaxed);
    RCC.rsr().modify(|w| w.set_rmvf(true));
    LAST.store(0, Relaxed);
    keep(&LEFT, pattern());
    // SAFETY: a byte of the word, which nobody else uses.
    unsafe { LAST.as_ptr().cast::<u8>().write_volatile(BYTE) };
    SCB::sys_reset()
}

/// The next order begins with [`leave`].
pub fn forget() {
    set_step(0);
}

impl Before {
    /// See the module text. The words are read after a reset by [`leave`] only: memory with ECC may
    /// fault where nobody has written since power-on.
    pub fn read() -> Option<Before> {
        match step() {
            _ if RCC.rsr().read().porrstf() => None,
            LEAVES => {
                let is_left = LEFT.iter().zip(pattern()).all(|(word, value)| word.load(Relaxed) == value);
                let is_whole = LAST.load(Relaxed) == BYTE.into();
                set_step(BREAKS);
                let mut found = [0; FIGURES];
                found[..4].copy_from_slice(&[PATTERN, CAUSE.load(Relaxed), is_left.into(), is_whole.into()]);
                low_supply(&mut found[4..]);
                keep(&FOUND, found);
                SCB::sys_reset()
            }
            step @ (BREAKS | LOCKS_UP) => {
                let mut found = [0; FIGURES];
                found.iter_mut().zip(&FOUND).for_each(|(to, from)| *to = from.load(Relaxed));
                Some(Before { found, is_whole: step == LOCKS_UP })
            }
            _ => None,
        }
    }

    /// Whether the core is to be locked up now: it has not been, and LSEDRV says so from now on.
    pub fn goes_on(&self) -> bool {
        if !self.is_whole {
            set_step(LOCKS_UP);
        }
        !self.is_whole && step() == LOCKS_UP
    }

    /// Reports it.
    pub fn report_to(&self, report: &mut Report) {
        if self.is_whole {
            lock_up::report_to(report);
        }
        let [mark, cause, is_left, is_whole, supply @ ..] = self.found.map(i64::from);
        if mark != PATTERN.into() {
            // Of the second reset nothing is left either.
            return report.line("left", &[0, 0]);
        }
        report.line("cause", &[cause]);
        report.line("left", &[is_left, is_whole]);
        report.line("low-supply", &supply);
    }
}

/// Whether the detector finds PVD_IN low; of each timer MOE, then flags and MOE once that is led to
/// it. No pin follows a timer yet.
fn low_supply(found: &mut [u32]) {
    RCC.apb2enr().modify(|w| {
        w.set_tim1en(true);
        w.set_tim8en(true);
        w.set_tim15en(true);
    });
    RCC.apb4enr().modify(|w| w.set_syscfgen(true));
    // Read back, so that the clocks are on (RM0433 8.5.8).
    RCC.apb2enr().read();
    RCC.apb4enr().read();
    PWR.cr1().modify(|w| {
        w.set_pls(PVD_IN);
        w.set_pvde(true);
    });
    for (_, timer) in LASERS {
        // Its input is not connected.
        timer.af1().write(|_| {});
        timer.bdtr().write(|w| {
            w.set_ossi(Ossi::IDLE_LEVEL);
            w.set_bkp(0, Bkp::ACTIVE_HIGH);
            w.set_bke(0, true);
        });
        timer.bdtr().modify(|w| w.set_moe(true));
    }
    // The comparator has settled by then: 0.1 ms.
    cortex_m::asm::delay(6_400);
    let is_lit = LASERS.map(|(_, timer)| timer.bdtr().read().moe());
    let is_low = PWR.csr1().read().pvdo();
    // SAFETY: the register is there; the databases lack it.
    unsafe { SYSCFG.as_ptr().cast::<u8>().add(SYSCFG_CFGR).cast::<u32>().write_volatile(PVDL) };
    cortex_m::asm::delay(640);
    let figures = LASERS
        .into_iter()
        .zip(is_lit)
        .flat_map(|((_, timer), is_lit)| [is_lit.into(), timer.sr().read().0, timer.bdtr().read().moe().into()]);
    found.iter_mut().zip([u32::from(is_low)].into_iter().chain(figures)).for_each(|(to, from)| *to = from);
}
