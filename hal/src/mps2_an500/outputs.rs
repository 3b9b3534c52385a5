//! The output registers that this board does not have.
//!
//! In: levels, from the tick, or the safe state, from the fault path. Out: the same levels for
//! readers (the view carries them over the link; a debugger reads the symbols). Owns words of RAM
//! in place of a real board's registers, so that the fault path can write the safe state without
//! locks. Fails never.
//!
//! A laser's registers hold what is in force after the last plan. The instants of its edges are in
//! the trace, as the actions of the plans.
use core::sync::atomic::{AtomicBool, AtomicI16, AtomicU32, Ordering};
use servo::laser::{Action, CHANNELS, LaserPlan, Train};
use servo::port::GeneralOutputs;

/// Analog inputs of the board, and as many outputs.
pub const ANALOG_OUTPUTS: usize = 8;

// Relaxed throughout: registers that only the tick writes, until the fault path has stopped it.
// `used`: no code of the image reads them, a debugger does.
#[used]
static ENABLE: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];
static CLEAR: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];
#[used]
static GENERAL: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];
static DAC: [AtomicI16; ANALOG_OUTPUTS] = [const { AtomicI16::new(0) }; ANALOG_OUTPUTS];
#[used]
static LASERS: [Laser; CHANNELS] = [const { Laser::at_standstill() }; CHANNELS];

/// Registers of a laser channel.
struct Laser {
    /// The switch output.
    switch: AtomicBool,
    /// Whole counts of the period, 0 without pulses, and of the width.
    period: AtomicU32,
    width: AtomicU32,
    /// The analog output.
    dac: AtomicI16,
}

impl Laser {
    const fn at_standstill() -> Laser {
        Laser {
            switch: AtomicBool::new(false),
            period: AtomicU32::new(0),
            width: AtomicU32::new(0),
            dac: AtomicI16::new(0),
        }
    }

    fn pulses(&self, train: &Train) {
        self.period.store(u32::try_from(train.period.whole).unwrap_or(u32::MAX), Ordering::Relaxed);
        self.width.store(u32::try_from(train.width.whole).unwrap_or(u32::MAX), Ordering::Relaxed);
    }

    fn safe_state(&self) {
        self.switch.store(false, Ordering::Relaxed);
        self.pulses(&Train::NONE);
        self.dac.store(0, Ordering::Relaxed);
    }
}

/// Executes the plan of a laser channel. A channel that the board lacks is not written.
pub fn set_laser(channel: usize, plan: &LaserPlan) {
    let Some(laser) = LASERS.get(channel) else { return };
    if plan.safe_state {
        laser.safe_state();
    }
    for (_, action) in plan.actions() {
        match action {
            Action::Switch(level) => laser.switch.store(*level, Ordering::Relaxed),
            Action::Light(train) | Action::Change(train) | Action::Dark { standby: train, .. } => laser.pulses(train),
            Action::Rate(rate) => laser.pulses(&rate.train()),
            Action::Volts(code) => laser.dac.store(*code, Ordering::Relaxed),
        }
    }
}

/// Servo-enable and alarm-clear lines, a bit an axis, and general outputs.
pub fn set(enable: u64, clear: u64, general: GeneralOutputs) {
    for (register, value) in ENABLE.iter().zip(halves(enable)) {
        register.store(value, Ordering::Relaxed);
    }
    for (register, value) in CLEAR.iter().zip(halves(clear)) {
        register.store(value, Ordering::Relaxed);
    }
    for (register, value) in GENERAL.iter().zip(halves(general)) {
        register.store(value, Ordering::Relaxed);
    }
}

/// An analog output, −32768…32767 is −10…10 V. A channel that the board lacks is not written.
pub fn set_analog(channel: usize, value: i16) {
    if let Some(register) = DAC.get(channel) {
        register.store(value, Ordering::Relaxed);
    }
}

/// Servos off, outputs low, lasers dark, 0 V.
pub fn safe_state() {
    LASERS.iter().for_each(Laser::safe_state);
    set(0, 0, 0);
    for channel in 0..ANALOG_OUTPUTS {
        set_analog(channel, 0);
    }
}

fn halves(bits: u64) -> [u32; 2] {
    [bits as u32, (bits >> 32) as u32]
}
