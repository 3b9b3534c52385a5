//! The output registers that this board does not have.
//!
//! In: levels, from the tick, or rest, from the fault path. Out: the same to whoever looks (the view
//! carries them over the link; a debugger reads the symbols). Owns words of RAM that stand for the
//! registers of a real board, so that the fault path can put them at rest without asking anybody.
use core::sync::atomic::{AtomicI16, AtomicU32, Ordering};

/// Analog channels of the board, each way.
pub const ANALOG: usize = 8;

// Relaxed throughout: registers that only the tick writes, until the fault path has stopped it.
static ENABLE: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];
static CLEAR: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];
static GENERAL: AtomicU32 = AtomicU32::new(0);
static DAC: [AtomicI16; ANALOG] = [const { AtomicI16::new(0) }; ANALOG];

/// Servo-enable and alarm-clear lines, a bit an axis, and general outputs.
pub fn set(enable: u64, clear: u64, general: u32) {
    for (register, value) in ENABLE.iter().zip(halves(enable)) {
        register.store(value, Ordering::Relaxed);
    }
    for (register, value) in CLEAR.iter().zip(halves(clear)) {
        register.store(value, Ordering::Relaxed);
    }
    GENERAL.store(general, Ordering::Relaxed);
}

/// An analog output, −32768…32767 is −10…10 V. A channel that the board lacks is not written.
pub fn set_analog(channel: usize, value: i16) {
    if let Some(register) = DAC.get(channel) {
        register.store(value, Ordering::Relaxed);
    }
}

/// Servos off, outputs low, 0 V.
pub fn rest() {
    set(0, 0, 0);
    for channel in 0..ANALOG {
        set_analog(channel, 0);
    }
}

fn halves(bits: u64) -> [u32; 2] {
    [bits as u32, (bits >> 32) as u32]
}
