//! The board's machine in ticks of 50 µs, without the servo tick: plans and set-points by hand.
//!
//! In: plans of both lasers, targets of the axes. Out: what the pins do, one tick later. Owns the
//! machine and TIM2. It counts the ticks that came too late for an output.
use crate::chip::LASERS;
use cortex_m::peripheral::NVIC;
use hal::board::{AXES, machine::Machine, timer, timer::TickTimer, watchdog};
use servo::laser::{Action, Count, LaserPlan, Train};
use servo::port::Port;
use servo::units::{Axis, Pos};
use stm32_metapac::{Interrupt, TIM2};

/// Length of a tick.
pub const TICK_NS: u32 = 50_000;

/// See the module text.
pub struct Bench {
    machine: Machine,
    timer: TickTimer,
    plans: [LaserPlan; 2],
    /// Pulses that each axis makes in a tick.
    pub rate: i32,
    target: i32,
    /// Which timers of the lasers counted at the beginning of some tick.
    pub ran: [bool; 3],
    /// Ticks that were too late for an output.
    pub late: i64,
}

/// A train of whole counts of 240 MHz, and `parts` 2nds more of period and width.
pub fn train(period: u64, width: u64, parts: u32) -> Train {
    let count = |whole| Count { whole, part: parts, of: 2 };
    Train { period: count(period), width: count(width) }
}

impl Bench {
    /// Ticks begin.
    pub fn begin(machine: Machine, mut timer: TickTimer) -> Bench {
        timer.run_at(TICK_NS);
        timer::start();
        // Wakes the core; interrupts are masked, so no handler runs.
        // SAFETY: nothing depends on the mask.
        unsafe { NVIC::unmask(Interrupt::TIM2) };
        Bench { machine, timer, plans: [const { LaserPlan::EMPTY }; 2], rate: 0, target: 0, ran: [false; 3], late: 0 }
    }

    /// Plans an action of a channel for the next tick that is computed.
    pub fn plan(&mut self, channel: usize, at: u32, action: Action) {
        self.plans[channel].add(at, action);
    }

    /// The safe state of a channel, in the next tick.
    pub fn shut_off(&mut self, channel: usize) {
        self.plans[channel].safe_state = true;
    }

    /// A code of an analog output.
    pub fn volts(&mut self, channel: usize, code: i16) {
        self.machine.analog_out(0, channel, code);
    }

    /// The code of an analog input.
    pub fn analog(&mut self, channel: usize) -> i64 {
        self.machine.analog(channel).into()
    }

    /// The next tick.
    pub fn tick(&mut self) {
        watchdog::feed();
        while !TIM2.sr().read().uif() {
            cortex_m::asm::wfi();
        }
        // Before the machine stops them all, because one has not started.
        for (ran, (_, timer)) in self.ran.iter_mut().zip(LASERS) {
            *ran |= timer.cr1().read().cen();
        }
        self.machine.advance(TICK_NS);
        self.timer.begin();
        NVIC::unpend(Interrupt::TIM2);
        self.target += self.rate;
        for axis in (0..AXES).filter_map(Axis::new) {
            self.machine.set_point(axis, Pos::pulses(self.target));
        }
        for (channel, plan) in self.plans.iter_mut().enumerate() {
            plan.lasts = TICK_NS;
            self.machine.laser(channel, plan);
            *plan = LaserPlan::EMPTY;
        }
        self.late += i64::from(!self.machine.emit());
    }

    /// So many ticks.
    pub fn ticks(&mut self, count: u32) {
        (0..count).for_each(|_| self.tick());
    }

    /// Time in which no tick is served.
    pub fn miss(&mut self, ticks: u32) {
        for _ in 0..ticks {
            watchdog::feed();
            while !TIM2.sr().read().uif() {
                cortex_m::asm::wfi();
            }
            TIM2.sr().write(|w| {
                w.0 = !0;
                w.set_uif(false);
            });
            NVIC::unpend(Interrupt::TIM2);
        }
    }
}
