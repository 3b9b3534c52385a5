//! Mutants of the reference board's image, found in emulation.
use super::list::{Mutant, mutant};

const H743_FIRST_TICK: &[&str] = &["-p", "beamtick-h743", "--test", "image", "--", "the_first_tick"];
const H743_STUCK: &[&str] = &["-p", "beamtick-h743", "--test", "image", "--", "a_link_task_that_stands_still"];
const H743_PANIC: &[&str] = &["-p", "beamtick-h743", "--test", "image", "--", "a_panic_rests"];
const H743_STACK: &[&str] = &["-p", "beamtick-h743", "--test", "image", "--", "a_stack_that_is_full"];
const H743_BREAKS: &[&str] = &["-p", "beamtick-h743", "--test", "facts", "--", "break"];
const H743_VOLTAGES: &[&str] = &["-p", "beamtick-h743", "--test", "inputs", "--", "voltages"];
const H743_ENCODERS: &[&str] = &["-p", "beamtick-h743", "--test", "inputs", "--", "edges_of_encoders"];
const H743_PT: &[&str] = &["-p", "beamtick-h743", "--test", "jobs", "--", "a_listing_of_pt"];
const H743_ALARMS: &[&str] = &["-p", "beamtick-h743", "--test", "inputs", "--", "alarms"];
const PWM_CYCLES: &[&str] = &["-p", "beamtick-plant", "--test", "pwm_cycles"];
const STEADY_CYCLES: &[&str] = &["-p", "beamtick-plant", "--test", "steady_cycles"];
const STEPS: &[&str] = &["-p", "beamtick-servo", "--test", "all", "--", "step_output::"];
const H743_LASERS: &[&str] = &["-p", "beamtick-h743", "--test", "jobs", "--", "listings_of_lasers"];

/// Those of one crate together.
pub const REFERENCE_BOARD: &[Mutant] = &[
    // -- the reference board's image, in emulation ---------------------------------------------
    mutant(
        "H743: the tick's timer runs before its interrupt is let in",
        "hal/src/stm32h743/mod.rs",
        "    for interrupt in [Interrupt::TIM2, Interrupt::USART3, Interrupt::OTG_FS] {\n        // SAFETY: the caller's promise.",
        "    timer::start();\n    cortex_m::asm::delay(30_000);\n    for interrupt in [Interrupt::TIM2, Interrupt::USART3, Interrupt::OTG_FS] {\n        \
         // SAFETY: the caller's promise.",
        H743_FIRST_TICK,
    ),
    mutant(
        "H743: the watchdog is fed although the link task stands still",
        "firmware/src/supervision.rs",
        "    if !is_late(now) {",
        "    if !is_late(now) || TICKED.load(Relaxed) == now {",
        H743_STUCK,
    ),
    mutant(
        "H743: a panic leaves the outputs as they are",
        "firmware/src/fault.rs",
        "    board::safe_state();\n    let mut report",
        "    let mut report",
        H743_PANIC,
    ),
    mutant(
        "H743: nothing guards the end of the stack",
        "hal/src/stm32h743/mod.rs",
        "    guard::below(&mut core.MPU, STACK, 1);",
        "",
        H743_STACK,
    ),
    mutant(
        "H743: a break flag is not compared with its pin in ticks",
        "hal/src/stm32h743/laser.rs",
        "            CONTRADICTS.store(1 + 3 * input + text, Relaxed);",
        "",
        H743_BREAKS,
    ),
    mutant(
        "H743: a break of the chip is taken for one of a pin",
        "hal/src/stm32h743/laser.rs",
        "let of_chip = flags == 0b111 || clocks::supply_is_low();",
        "let of_chip = false;",
        &["-p", "beamtick-h743", "--test", "facts", "--", "a_supply"],
    ),
    mutant(
        "H743: a low supply at the start is blamed on the wiring",
        "hal/src/stm32h743/laser.rs",
        "found.filter(|_| !clocks::supply_is_low())",
        "found",
        &["-p", "beamtick-h743", "--test", "facts", "--", "a_supply"],
    ),
    mutant(
        "H743: the interlock's inputs are not compared with each other",
        "hal/src/stm32h743/laser.rs",
        "self.apart >= MAX_TICKS_APART",
        "self.apart == 0 && levels == MAX_TICKS_APART",
        &["-p", "beamtick-h743", "--test", "facts", "--", "an_input"],
    ),
    mutant(
        "H743: a start of light undoes a break that is over",
        "hal/src/stm32h743/laser.rs",
        "let is_dark = || timers.into_iter().any(is_broken);",
        "let is_dark = || false;",
        &["-p", "beamtick-h743", "--test", "restarts", "--", "a_loop"],
    ),
    mutant(
        "H743: outputs are enabled before breaks are read",
        "hal/src/stm32h743/laser.rs",
        "    if is_dark() {\n        return false;\n    }\n    timers",
        "    timers",
        &["-p", "beamtick-h743", "--test", "restarts", "--", "a_loop"],
    ),
    mutant(
        "H743: a reset of the timers drops a break",
        "hal/src/stm32h743/laser.rs",
        "        if was_broken {",
        "        if was_broken && false {",
        H743_BREAKS,
    ),
    mutant(
        "H743: a fault within a frame of an external DAC leaves its voltage",
        "hal/src/stm32h743/analog.rs",
        "    spi::restart();\n    for channel",
        "    for channel",
        &["-p", "beamtick-h743", "--test", "external_dac", "--", "a_fault"],
    ),
    mutant(
        "H743: a late byte shifts the frames of an external DAC",
        "hal/src/stm32h743/analog.rs",
        "                    spi::restart();\n",
        "",
        &["-p", "beamtick-h743", "--test", "external_dac", "--", "a_frame"],
    ),
    mutant(
        "H743: an external DAC keeps its voltage until the clock comes",
        "hal/src/stm32h743/mod.rs",
        "        unsafe { analog::zero_external() };\n        clocks::await_source();",
        "        clocks::await_source();\n        unsafe { analog::zero_external() };",
        &["-p", "beamtick-h743", "--test", "external_dac", "--", "a_reset"],
    ),
    mutant(
        "H743: any revision of the chip is a good one",
        "hal/src/stm32h743/clocks.rs",
        "    code.dev_id() == DEVICE && REVISIONS.contains(&code.rev_id())",
        "    code.dev_id() == DEVICE",
        &["-p", "beamtick-h743", "--test", "facts", "--", "other_chips"],
    ),
    mutant(
        "H743: the switch of USB's 5 V floats",
        "hal/src/stm32h743/boards/nucleo_h743zi2/mod.rs",
        "    driven_low: &[(GPIOD, 10)],",
        "    driven_low: &[],",
        &["-p", "beamtick-h743", "--test", "image", "--", "start_up"],
    ),
    mutant(
        "H743: analog inputs are exchanged",
        "hal/src/stm32h743/adc.rs",
        "const CHANNELS: [usize; INPUTS] = [1, 0];",
        "const CHANNELS: [usize; INPUTS] = [0, 1];",
        H743_VOLTAGES,
    ),
    mutant(
        "H743: encoders count backwards",
        "hal/src/stm32h743/encoders.rs",
        "*count = count.wrapping_add(distance(now, *last));",
        "*count = count.wrapping_sub(distance(now, *last));",
        H743_ENCODERS,
    ),
    mutant(
        "H743: voltages are half of what they shall be",
        "hal/src/stm32h743/analog.rs",
        "w.set_dhr((code as u16 ^ 0x8000) >> 4)",
        "w.set_dhr(((code >> 1) as u16 ^ 0x8000) >> 4)",
        H743_LASERS,
    ),
    mutant(
        "H743: the tick needs 8000 bytes more of the stack",
        "firmware/src/interrupts.rs",
        "    supervision::tick_begins();",
        "    supervision::tick_begins();\n    core::hint::black_box([0u8; 8000]);",
        H743_PT,
    ),
    mutant(
        "H743: inputs of axes are unpacked once",
        "hal/src/stm32h743/machine.rs",
        "if levels.differ(&self.levels) {",
        "if self.reached == [i64::MIN; AXES] {",
        H743_ALARMS,
    ),
    // -- what its timers and DMA are given -----------------------------------------------------
    mutant(
        "a group of periods is as long as without its long ones",
        "servo/src/laser/dither.rs",
        "n.wrapping_mul(period).wrapping_add(long)",
        "n.wrapping_mul(period).wrapping_add(long & 1)",
        PWM_CYCLES,
    ),
    mutant(
        "a train after a pause that was resumed begins with the remainder of the pause",
        "servo/src/output/pwm_cycles.rs",
        "self.begins = if self.runs { at } else { next };",
        "self.begins = if self.runs { self.begins } else { next };",
        PWM_CYCLES,
    ),
    mutant(
        "a tick without an action is dark although a pulse of before lasts",
        "servo/src/output/pwm_cycles.rs",
        " && self.next.is_none() && self.until <= self.begin;",
        " && self.next.is_none();",
        STEADY_CYCLES,
    ),
    mutant(
        "a tick without an action leaves out the edges of the channel before",
        "servo/src/output/gate_cycles.rs",
        "let is_steady = self.waiting == 0 && ",
        "let is_steady = ",
        STEADY_CYCLES,
    ),
    mutant(
        "steps that are written one by one lose a slot now and then",
        "servo/src/output/step_generator.rs",
        "let more = part >= count;",
        "let more = part > count;",
        STEPS,
    ),
];
