//! Which exception comes next (Armv7-M Architecture Reference Manual, B1.5 and B3.4).
//!
//! In: what is pending, enabled, active, at which priority, and the core's masks. Out: the
//! exception to take, if one is more urgent than what runs. Owns these four sets. Of a priority the
//! STM32H743 has four bits (PM0253 4.2.7).

/// Exceptions: 16 of the core, 150 of the chip (RM0433 table 148).
pub const COUNT: usize = 16 + 150;

/// Numbers of the core's own.
pub const NMI: usize = 2;
/// Exceptions without a field of their own.
pub const HARD_FAULT: usize = 3;
/// A right of the MPU is missing.
pub const MEMORY_FAULT: usize = 4;
/// Nothing answers at an address.
pub const BUS_FAULT: usize = 5;
/// An instruction that cannot be.
pub const USAGE_FAULT: usize = 6;
/// SVC.
pub const SUPERVISOR_CALL: usize = 11;
/// The bell that software rings.
pub const PEND_SV: usize = 14;
/// The core's timer.
pub const SYS_TICK: usize = 15;

/// Priority of code that no exception runs.
pub const THREAD: i16 = 256;

/// Exceptions, a bit each: the model looks for the first one at every turn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Set([u64; COUNT.div_ceil(64)]);

impl Set {
    /// Puts one in, or takes it out.
    pub fn set(&mut self, exception: usize, holds: bool) {
        assert!(exception < COUNT, "exception {exception}");
        let bit = 1 << (exception % 64);
        let word = &mut self.0[exception / 64];
        *word = if holds { *word | bit } else { *word & !bit };
    }

    /// Those that are in both.
    pub fn and(self, other: Set) -> Set {
        Set(std::array::from_fn(|n| self.0[n] & other.0[n]))
    }

    /// By their numbers.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        self.0.into_iter().enumerate().flat_map(|(n, mut word)| {
            std::iter::from_fn(move || {
                let bit = word.trailing_zeros();
                word &= word.wrapping_sub(1);
                (bit < 64).then_some(64 * n + bit as usize)
            })
        })
    }
}

impl std::ops::Index<usize> for Set {
    type Output = bool;

    fn index(&self, exception: usize) -> &bool {
        if self.0[exception / 64] >> (exception % 64) & 1 == 1 { &true } else { &false }
    }
}

/// The masks, as the core's registers hold them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Masks {
    /// PRIMASK.
    pub primask: bool,
    /// FAULTMASK.
    pub faultmask: bool,
    /// BASEPRI.
    pub basepri: u8,
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Exceptions {
    /// Is waiting.
    pub pending: Set,
    /// Runs, or was interrupted.
    pub active: Set,
    /// May be taken.
    pub enabled: Set,
    /// Priority registers.
    pub priority: [u8; COUNT],
    /// The line of an interrupt is high.
    line: Set,
    /// AIRCR.PRIGROUP.
    pub group: u32,
}

impl Default for Exceptions {
    fn default() -> Self {
        let mut enabled = Set::default();
        for always in [NMI, HARD_FAULT, SUPERVISOR_CALL, PEND_SV, SYS_TICK] {
            enabled.set(always, true);
        }
        let none = Set::default();
        Exceptions { pending: none, active: none, enabled, priority: [0; COUNT], line: none, group: 0 }
    }
}

impl Exceptions {
    /// Sets a priority register; the chip has the top four bits of it.
    pub fn set_priority(&mut self, exception: usize, value: u8) {
        self.priority[exception] = value & 0xf0;
    }

    /// How urgent an exception is, the bits that only order equals included.
    fn full_priority(&self, exception: usize) -> i16 {
        match exception {
            0 | 1 => -3,
            NMI => -2,
            HARD_FAULT => -1,
            _ => self.priority[exception].into(),
        }
    }

    /// The part of a priority that preempts (B1.5.4).
    fn preempting(&self, priority: i16) -> i16 {
        if priority < 0 { priority } else { priority >> (self.group + 1) << (self.group + 1) }
    }

    /// Priority of an exception for preemption.
    pub fn urgency(&self, exception: usize) -> i16 {
        self.preempting(self.full_priority(exception))
    }

    /// How urgent what runs is, with the masks.
    pub fn execution(&self, masks: Masks) -> i16 {
        let active = self.active.iter().map(|n| self.urgency(n)).min().unwrap_or(THREAD);
        let base = if masks.basepri == 0 { THREAD } else { self.preempting(i16::from(masks.basepri & 0xf0)) };
        let prime = if masks.primask { 0 } else { THREAD };
        let fault = if masks.faultmask { -1 } else { THREAD };
        active.min(base).min(prime).min(fault)
    }

    /// Those that wait and are enabled.
    pub fn waiting(&self) -> impl Iterator<Item = usize> {
        self.pending.and(self.enabled).iter().filter(|&n| n >= NMI)
    }

    /// The most urgent that waits and is enabled; of equals the lowest number.
    fn first(&self) -> Option<usize> {
        self.waiting().min_by_key(|&n| (self.full_priority(n), n))
    }

    /// Whether anything waits that is enabled.
    pub fn is_any_pending(&self) -> bool {
        self.waiting().next().is_some()
    }

    /// What is to be taken now.
    pub fn next(&self, masks: Masks) -> Option<usize> {
        self.first().filter(|&n| self.urgency(n) < self.execution(masks))
    }

    /// Whether WFI ends: as for [`Exceptions::next`], but PRIMASK does not count (B1.5.19).
    pub fn wakes(&self, masks: Masks) -> bool {
        self.next(Masks { primask: false, ..masks }).is_some()
    }

    /// An exception begins.
    pub fn begin(&mut self, exception: usize) {
        self.pending.set(exception, false);
        self.active.set(exception, true);
    }

    /// An exception has ended; an interrupt whose line is still high waits again.
    pub fn end(&mut self, exception: usize) {
        self.active.set(exception, false);
        self.pending.set(exception, self.pending[exception] || self.line[exception]);
    }

    /// The line of an interrupt; a rising line makes it pending. True if it is pending now and was
    /// not.
    pub fn set_line(&mut self, interrupt: usize, high: bool) -> bool {
        let exception = 16 + interrupt;
        let rises = high && !self.line[exception];
        self.line.set(exception, high);
        let new = rises && !self.pending[exception];
        self.pending.set(exception, self.pending[exception] || rises);
        new
    }

    /// Clears what is pending; while the line is high it is pending at once again, unless it runs.
    pub fn clear_pending(&mut self, exception: usize) {
        self.pending.set(exception, self.line[exception] && !self.active[exception]);
    }
}
