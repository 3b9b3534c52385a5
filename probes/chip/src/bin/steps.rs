#![no_std]
#![no_main]
//! Counts the instructions with which the reference board fills the slots of its step output, in
//! QEMU as `ticks.rs` does and with the same lines out: `AXES steps-PERIOD COUNT`, for axes that
//! step at 1 MHz.
use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m_semihosting::hprintln;
use hal as _; // the vector table
use probes::clock;
use servo::output::step_generator::{AXES, RING_SLOTS, StepOutput};

/// Ticks counted of each kind.
const TICKS: usize = 100;

static WORDS: [AtomicU32; RING_SLOTS] = [const { AtomicU32::new(0) }; RING_SLOTS];

probes::exit_on_panic!();

#[cortex_m_rt::entry]
fn main() -> ! {
    clock::start();
    let fill = black_box(StepOutput::<1>::fill);
    let kinds = [(10, 1, "steps-10"), (20, 1, "steps-20"), (50, 1, "steps-50"), (250, 1, "steps-250")];
    for (us, slower, mark) in kinds.into_iter().chain([(50, 10, "steps-slow-50"), (250, 10, "steps-slow-250")]) {
        for axes in [1, AXES] {
            let (mut output, mut goes_to, mut at) = (StepOutput::new(4), [0i64; AXES], 0);
            for tick in 0..TICKS {
                goes_to.iter_mut().take(axes).for_each(|place| *place += us / slower);
                let slots = 2 * us as u32;
                let before = clock::read();
                let filled = fill(&mut output, &goes_to, slots, &WORDS, at);
                let count = before.passed();
                assert!(filled && output.stands(0) == us / slower * (tick as i64 + 1), "every step is there");
                hprintln!("{} {} {}", axes, mark, count);
                at = (at + slots as usize) % RING_SLOTS;
                WORDS.iter().for_each(|word| word.store(0, Relaxed));
            }
        }
    }
    probes::exit()
}
