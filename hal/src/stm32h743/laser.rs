//! Laser outputs (RM0433 38, 41): TIM1 makes the energy of laser 0, TIM15 that of laser 1, TIM8
//! both switches. Each line has its complement. A break input disables them without an instruction.
//!
//! In: a [`LaserPlan`] a channel and tick. Out: light, one tick after the plan, as the steps
//! ([`DelayLine`]); the safe state at once. Owns TIM1, TIM8, TIM15 and their streams. A timer
//! counts PWM cycles ([`super::pwm_dma`]) that [`PwmCycles`] and [`GateCycles`] make of the plans;
//! all three begin at the same tick. In the safe state the main output is disabled (`BDTR.MOE`),
//! and the pins have their idle levels. Fails to the safe state if a cycle was queued too late for
//! DMA: it reports that to the tick ([`Lasers::was_late`]), and everything starts anew.
use super::boards::BOARD;
use super::clocks::{self, TIMER_MHZ};
use super::pwm_dma::{LASER_0, LASER_1, RING_BEGIN_COUNTS, SWITCHES, TIM15, Timer, empty_slots};
use super::wiring::Break;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering::Relaxed};
use servo::laser::{CHANNELS, LaserPlan};
use servo::output::{DELAY_LINE_WORDS, DelayLine, GateCycles, PwmCycles, RingSlots, Scale};
use stm32_metapac::timer::TimAdv;
use stm32_metapac::timer::vals::{Bkinp, Bkp, Mms, Msm, OcmGp, Ossi, Ossr, Sms, Ts, Urs};
use stm32_metapac::{RCC, TIM1, TIM2, TIM8};

const SCALE: Scale = Scale::of_mhz(TIMER_MHZ);

/// Two ticks of 250 µs with cycles of 0.5 µs; 64 actions a tick, each of which may take one more;
/// and the ends of ticks.
pub const ENERGY_SLOTS: usize = 1152;
/// Two ticks with 64 edges of either channel.
pub const SWITCH_SLOTS: usize = 272;
/// Time that the start takes, in counts of the timers, with reserve.
const START_COUNTS: u64 = 480;
/// A compare value that no cycle reaches.
const NEVER_COMPARE: u16 = u16::MAX;

#[unsafe(link_section = ".dma.laser_0")]
static RING_0: RingSlots<ENERGY_SLOTS, 3> = empty_slots();
#[unsafe(link_section = ".dma.laser_1")]
static RING_1: RingSlots<ENERGY_SLOTS, 3> = empty_slots();
#[unsafe(link_section = ".dma.switches")]
static RING_SWITCHES: RingSlots<SWITCH_SLOTS, 6> = empty_slots();

/// Plans of a tick, in the delay lines.
#[unsafe(link_section = ".state.held_0")]
static DELAY_0: [AtomicU32; DELAY_LINE_WORDS] = [const { AtomicU32::new(0) }; DELAY_LINE_WORDS];
#[unsafe(link_section = ".state.held_1")]
static DELAY_1: [AtomicU32; DELAY_LINE_WORDS] = [const { AtomicU32::new(0) }; DELAY_LINE_WORDS];

/// What the timers do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Stopped; their rings are made dark.
    Stopped,
    /// Set up. That and the first cycles take too long for one tick of 10 µs.
    Ready,
    /// Their first cycles are queued in this tick.
    Begins,
    /// They start with the next tick.
    Armed,
    /// They count.
    Runs,
}

/// See the module text.
#[derive(Debug)]
pub struct Lasers {
    state: State,
    /// The next tick, in counts of the timers.
    next: u64,
    /// Counts of the tick in force.
    lasts: u64,
    /// Plans whose cycles are queued in the next tick.
    delay_lines: [DelayLine; CHANNELS],
    energies: [PwmCycles; CHANNELS],
    energy_timers: [Timer<ENERGY_SLOTS, 3>; CHANNELS],
    switches: GateCycles,
    switch_timer: Timer<SWITCH_SLOTS, 6>,
    /// The channel's outputs follow their timers.
    is_live: [bool; CHANNELS],
    was_late: bool,
    /// The timers have counted: a burst may be incomplete.
    is_used: bool,
}

/// Timers with their outputs in the safe state, before any pin outputs them.
///
/// # Safety
/// At most once.
pub unsafe fn open() -> Lasers {
    RCC.apb2enr().modify(|w| {
        w.set_tim1en(true);
        w.set_tim8en(true);
        w.set_tim15en(true);
    });
    RCC.ahb1enr().modify(|w| {
        w.set_dma1en(true);
        w.set_dma2en(true);
    });
    // Read back, so that the clock is on (RM0433 8.5.8).
    RCC.apb2enr().read();
    RCC.ahb1enr().read();
    set_up();
    // SAFETY: the caller's promise.
    let energy_timers = unsafe { [Timer::new(LASER_0, &RING_0, [0; 3]), Timer::new(LASER_1, &RING_1, [0; 3])] };
    // SAFETY: the caller's promise.
    let switch_timer = unsafe { Timer::new(SWITCHES, &RING_SWITCHES, [0, 0, NEVER_COMPARE, 0, 0, NEVER_COMPARE]) };
    Lasers {
        state: State::Stopped,
        next: 0,
        lasts: 0,
        delay_lines: [DelayLine::new(&DELAY_0), DelayLine::new(&DELAY_1)],
        energies: [const { PwmCycles::from(RING_BEGIN_COUNTS, SCALE) }; CHANNELS],
        energy_timers,
        switches: GateCycles::from(RING_BEGIN_COUNTS, SCALE),
        switch_timer,
        is_live: [false; CHANNELS],
        was_late: false,
        is_used: false,
    }
}

/// Resets the timers: the remainder of a burst is dropped. Their outputs are released meanwhile. A
/// break that the tick has not read yet stays one.
#[cold]
#[inline(never)]
pub fn reset() {
    let breaks = [TIM1, TIM15, TIM8].map(|timer| (timer, is_broken(timer)));
    RCC.apb2rstr().modify(|w| {
        w.set_tim1rst(true);
        w.set_tim8rst(true);
        w.set_tim15rst(true);
    });
    RCC.apb2rstr().modify(|w| {
        w.set_tim1rst(false);
        w.set_tim8rst(false);
        w.set_tim15rst(false);
    });
    RCC.apb2rstr().read();
    set_up();
    for (timer, was_broken) in breaks {
        if was_broken {
            timer.egr().write(|w| w.set_bg(0, true));
        }
    }
}

/// Settings that do not change while the timers count: idle levels, the break input.
#[cold]
#[inline(never)]
fn set_up() {
    for timer in [TIM1, TIM8, TIM15] {
        timer.cr1().write(|w| {
            w.set_arpe(true);
            w.set_urs(Urs::COUNTER_ONLY);
        });
        // The pin, not inverted; sources differ on the register's value after a reset.
        timer.af1().write(|w| {
            w.set_bkine(true);
            w.set_bkinp(Bkinp::NOT_INVERTED);
        });
        // Outputs have idle levels while they are disabled; a high level at the break input
        // disables them.
        timer.bdtr().write(|w| {
            w.set_ossi(Ossi::IDLE_LEVEL);
            w.set_ossr(Ossr::IDLE_LEVEL);
            w.set_bkp(0, Bkp::ACTIVE_HIGH);
            w.set_bke(0, true);
        });
    }
    for timer in [TIM1, TIM15] {
        timer.cr2().write(|w| {
            // TIM15 starts with TIM1.
            w.set_mms(Mms::ENABLE);
            w.set_ois(0, true);
        });
        timer.ccmr_output(0).write(|w| {
            w.set_ocm(0, OcmGp::PWM_MODE1);
            w.set_ocpe(0, true);
        });
        lines(timer, &[0]);
    }
    TIM8.cr2().write(|w| {
        w.set_ois(1, true);
        w.set_ois(2, true);
    });
    for (half, [own, other]) in [[1, 0], [0, 1]].into_iter().enumerate() {
        TIM8.ccmr_output(half).write(|w| {
            w.set_ocm(own, OcmGp::FORCE_INACTIVE);
            w.set_ocm(other, OcmGp::PWM_MODE2);
            w.set_ocpe(own, true);
            w.set_ocpe(other, true);
        });
    }
    lines(TIM8, &[1, 2]);
}

/// A sentence on the first timer whose break flag differs from the level of its pin (RM0433 38.4.5:
/// the flag is set again while the input is active). Call it once, after the timers have their
/// pins. While the supply is low all timers break, and nothing is said of their inputs: ticks
/// compare them later ([`Breaks`]).
pub fn contradiction(levels: [bool; 3]) -> Option<&'static str> {
    let mut inputs = [TIM1, TIM15, TIM8].into_iter().zip(levels).zip(BOARD.breaks);
    let found = inputs.find_map(|((timer, level), Break { texts: [low, high, _], .. })| {
        clear_break(timer);
        // The input passes a synchronizer.
        cortex_m::asm::delay(64);
        let text = if level { high } else { low };
        (is_broken(timer) != level).then_some(text)
    });
    found.filter(|_| !clocks::supply_is_low())
}

/// Zeros clear, ones leave.
fn clear_break(timer: TimAdv) {
    timer.sr().write(|w| {
        w.0 = !0;
        w.set_bif(0, false);
        w.set_sbif(false);
    });
}

/// The flag of the input, and that of the chip's own breaks: sources differ on which of the two a
/// low supply sets, and TIM15 has the first one only (RM0433 38.4.5, 41.5.5).
fn is_broken(timer: TimAdv) -> bool {
    let flags = timer.sr().read();
    flags.bif(0) || flags.sbif()
}

/// Enables both lines of these channels as outputs; active is low at +, high at −.
fn lines(timer: TimAdv, channels: &[usize]) {
    timer.ccer().write(|w| {
        for &channel in channels {
            w.set_ccp(channel, true);
            w.set_ccnp(channel, true);
            w.set_cce(channel, true);
            w.set_ccne(channel, true);
        }
    });
}

/// Whether a timer's outputs follow it.
fn enable(timer: TimAdv, enabled: bool) {
    timer.bdtr().modify(|w| w.set_moe(enabled));
}

/// Whether a switch follows the timer; else it is inactive.
fn follow(channel: usize, follows: bool) {
    let mode = if follows { OcmGp::COMBINED_PWM_MODE_1 } else { OcmGp::FORCE_INACTIVE };
    // Channel 2 of the timer, and channel 3.
    match channel {
        0 => TIM8.ccmr_output(0).modify(|w| w.set_ocm(1, mode)),
        _ => TIM8.ccmr_output(1).modify(|w| w.set_ocm(0, mode)),
    }
}

fn energy_timer(channel: usize) -> TimAdv {
    if channel == 0 { TIM1 } else { TIM15 }
}

/// Sets all laser outputs to the safe state, in any state of the timers.
pub fn safe_state() {
    let clocks = RCC.apb2enr().read();
    for (timer, has_clock) in [(TIM1, clocks.tim1en()), (TIM15, clocks.tim15en()), (TIM8, clocks.tim8en())] {
        if has_clock {
            enable(timer, false);
        }
    }
}

/// Which timers were broken since the last call, a bit each, in the order of [`BOARD`]'s break
/// inputs. An input that is active breaks its timer again at once.
pub fn was_broken() -> u8 {
    let mut broken = 0;
    for (timer, bit) in [(TIM1, 1), (TIM15, 2), (TIM8, 4)] {
        if is_broken(timer) {
            broken |= bit;
            clear_break(timer);
        }
    }
    broken
}

/// What contradicts: 0 nothing, else one more than its text's index among those of all inputs.
/// Relaxed: written once in the tick, read by the thread.
static CONTRADICTS: AtomicU8 = AtomicU8::new(0);

/// What [`Breaks`] has found.
pub fn found() -> Option<&'static str> {
    let index = usize::from(CONTRADICTS.load(Relaxed)).checked_sub(1)?;
    BOARD.breaks.get(index / 3)?.texts.get(index % 3).copied()
}

/// Ticks in a row in which the pins of the interlock differ, until that is a contradiction: they
/// are wired together, and a contact that bounces between the readings of two ports is over by
/// then.
const MAX_TICKS_APART: u8 = 16;

/// Compares the flags of the timers with the levels of their pins, and the pins with each other, in
/// each tick in which one is set.
#[derive(Debug)]
pub struct Breaks {
    /// Timers whose flag and level differed in the tick before, a bit each.
    suspects: u8,
    /// Ticks in a row in which the pins differed.
    apart: u8,
    /// A timer contradicts its pin, or a pin the others: treated as an interlock that stays open.
    contradicts: bool,
}

impl Breaks {
    /// Nothing was compared yet.
    pub const fn new(contradicts: bool) -> Breaks {
        Breaks { suspects: 0, apart: 0, contradicts }
    }

    /// Whether the interlock is open, by the levels and the flags, a bit a timer. A break that is
    /// over has disabled the outputs too.
    #[inline]
    pub fn is_open(&mut self, levels: u8, flags: u8) -> bool {
        if levels | flags == 0 {
            (self.suspects, self.apart) = (0, 0);
            return self.contradicts;
        }
        self.compare(levels, flags);
        true
    }

    /// The levels were read before the flags, so a pin that is high has set its flag. A flag alone
    /// is a break that is over, or one of the chip, which sets all. In two ticks it is neither.
    #[cold]
    #[inline(never)]
    fn compare(&mut self, levels: u8, flags: u8) {
        let of_chip = flags == 0b111 || clocks::supply_is_low();
        let differ = levels & !flags | if of_chip { 0 } else { flags & !levels };
        let found = core::mem::replace(&mut self.suspects, differ) & differ;
        // The one that is not as the two others.
        let odd = if levels.count_ones() == 2 { !levels & 0b111 } else { levels };
        self.apart = if matches!(levels, 0 | 0b111) { 0 } else { self.apart.saturating_add(1) };
        if found != 0 {
            let input = found.trailing_zeros() as u8;
            self.report(input, levels >> input & 1);
        } else if self.apart >= MAX_TICKS_APART {
            self.report(odd.trailing_zeros() as u8, 2);
        }
    }

    /// Reports a text of an input. The first one stays.
    fn report(&mut self, input: u8, text: u8) {
        if !core::mem::replace(&mut self.contradicts, true) {
            CONTRADICTS.store(1 + 3 * input + text, Relaxed);
        }
    }
}

impl Lasers {
    /// A tick of `period_ns` begins.
    pub fn begin(&mut self, period_ns: u32) {
        self.lasts = SCALE.counts(period_ns).into();
        self.next = self.next.wrapping_add(self.lasts);
        match self.state {
            State::Runs => {
                let [first, second] = &mut self.energy_timers;
                let is_read = [first.renew(), second.renew(), self.switch_timer.renew()];
                if is_read.contains(&false) {
                    self.stop();
                }
            }
            _ => self.begin_apart(),
        }
    }

    /// The same while the timers do not run yet. Cold code stays in flash
    /// (docs/decisions/016-hot-code-in-itcm.md).
    #[cold]
    #[inline(never)]
    fn begin_apart(&mut self) {
        match self.state {
            State::Runs => {}
            State::Armed => {
                if [TIM1, TIM8, TIM15].iter().all(|timer| timer.cr1().read().cen()) {
                    self.state = State::Runs;
                } else {
                    self.stop();
                }
            }
            State::Ready => (self.next, self.state) = (0, State::Begins),
            State::Begins => self.stop(),
            State::Stopped => {
                let [first, second] = &mut self.energy_timers;
                let is_clear = [first.clear(), second.clear(), self.switch_timer.clear()];
                if !is_clear.contains(&false) {
                    self.arm();
                }
            }
        }
    }

    /// Sets the timers up: their first cycles are queued in the next tick.
    #[cold]
    fn arm(&mut self) {
        // Their streams have stopped: no more of a burst comes.
        if core::mem::replace(&mut self.is_used, true) {
            reset();
        }
        self.energies = [const { PwmCycles::from(RING_BEGIN_COUNTS, SCALE) }; CHANNELS];
        self.switches = GateCycles::from(RING_BEGIN_COUNTS, SCALE);
        self.energy_timers.iter_mut().for_each(Timer::arm);
        self.switch_timer.arm();
        self.state = State::Ready;
    }

    /// Arms the timers to start with the next tick, unless that is due already.
    #[cold]
    #[inline(never)]
    fn launch(&mut self) {
        // After what was written to the rings.
        cortex_m::asm::dsb();
        self.energy_timers.iter_mut().for_each(Timer::launch);
        self.switch_timer.launch();
        let is_late = TIM2.sr().read().uif() || u64::from(TIM2.cnt().read()) + START_COUNTS > self.lasts;
        if is_late {
            return;
        }
        // Each timer before the one that triggers it. TS changes while SMS is 0 (RM0433 38.4.3).
        for (timer, from) in [(TIM15, Ts::ITR0), (TIM8, Ts::ITR1), (TIM1, Ts::ITR1)] {
            timer.smcr().write(|w| {
                w.set_ts(from);
                w.set_msm(Msm::SYNC);
            });
            timer.smcr().modify(|w| w.set_sms(Sms::TRIGGER_MODE));
        }
        self.state = State::Armed;
    }

    #[cold]
    #[inline(never)]
    fn stop(&mut self) {
        safe_state();
        for timer in [TIM1, TIM8, TIM15] {
            timer.smcr().write(|_| {});
        }
        self.energy_timers.iter_mut().for_each(Timer::stop);
        self.switch_timer.stop();
        self.delay_lines.iter_mut().for_each(DelayLine::clear);
        for channel in 0..CHANNELS {
            follow(channel, false);
        }
        self.is_live = [false; CHANNELS];
        self.was_late |= self.state == State::Runs;
        self.state = State::Stopped;
    }

    /// Whether a cycle came too late since the last call: all outputs are in the safe state then.
    pub fn was_late(&mut self) -> bool {
        core::mem::take(&mut self.was_late)
    }

    /// Takes the plan of a channel for the interval that begins with the next tick; it is output
    /// one tick later. Now the cycles of the plan before it are queued. The safe state comes at
    /// once.
    #[inline]
    pub fn plan(&mut self, channel: usize, plan: &LaserPlan) {
        if plan.safe_state {
            self.safe_state(channel);
        }
        if !matches!(self.state, State::Stopped | State::Ready) {
            self.queue(channel, SCALE.counts(plan.lasts).into());
        }
        if !plan.safe_state && !self.delay_lines.get_mut(channel).is_some_and(|delayed| delayed.put(plan)) {
            self.stop();
        }
    }

    /// Queues the cycles of a channel's delayed plan for the next tick, which lasts so many counts.
    #[inline(never)]
    fn queue(&mut self, channel: usize, lasts: u64) {
        let (from, to) = (self.next, self.next.wrapping_add(lasts));
        let (Some(energy), Some(timer), Some(delayed), Some(is_live)) = (
            self.energies.get_mut(channel),
            self.energy_timers.get_mut(channel),
            self.delay_lines.get(channel),
            self.is_live.get_mut(channel),
        ) else {
            return;
        };
        if !*is_live && self.state == State::Runs && delayed.makes_light() {
            // All cycles queued so far are dark: at least one tick has passed since the safe state.
            *is_live = revive(channel);
        }
        let mut read_by = energy.queued().wrapping_sub(timer.ring.ahead().into());
        energy.queue(from, to, delayed, &mut timer.ring);
        if channel == 0 {
            self.switches.hold(delayed.actions());
        } else {
            let ring = &mut self.switch_timer.ring;
            read_by = read_by.min(self.switches.queued().wrapping_sub(ring.ahead().into()));
            self.switches.queue(from, to, delayed, ring);
        }
        if self.state == State::Begins && channel + 1 == CHANNELS {
            self.launch();
        }
        // The ring is written before DMA may read it.
        cortex_m::asm::dmb();
        let left = read_by.wrapping_sub(from.wrapping_sub(self.lasts)) as i64;
        let is_late = TIM2.sr().read().uif() || i64::from(TIM2.cnt().read()) >= left;
        if is_late && self.state == State::Runs {
            self.stop();
        }
    }

    /// The safe state at once; drops what was planned.
    #[cold]
    #[inline(never)]
    fn safe_state(&mut self, channel: usize) {
        enable(energy_timer(channel), false);
        follow(channel, false);
        if let Some(live) = self.is_live.get_mut(channel) {
            *live = false;
        }
        if let Some(delayed) = self.delay_lines.get_mut(channel) {
            delayed.clear();
        }
        if let Some(energy) = self.energies.get_mut(channel) {
            energy.shut_off();
        }
        self.switches.shut_off(channel);
    }
}

/// Enables a channel's outputs: they follow their timers. False, and they stay in the safe state,
/// if a break came after the tick had read the flags and is over: enabling would undo it. The flag
/// stays, so the next tick reads an open interlock.
#[cold]
#[inline(never)]
fn revive(channel: usize) -> bool {
    let timers = [energy_timer(channel), TIM8];
    let is_dark = || timers.into_iter().any(is_broken);
    if is_dark() {
        return false;
    }
    timers.into_iter().for_each(|timer| enable(timer, true));
    // One that came in between was undone; one that comes from now on disables them by itself.
    if is_dark() {
        timers.into_iter().for_each(|timer| enable(timer, false));
        return false;
    }
    follow(channel, true);
    true
}
