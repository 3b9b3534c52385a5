//! The emulated core against what the Armv7-M manual says, by the program of `probes/h743`, where
//! BEAMTICK_H743_PROBE names it (`cargo xtask check-all` does).
use h743::{Cause, MILLISECOND, Machine, Stop};

/// The sum that the probe's conditional blocks make, computed here.
fn sum() -> u32 {
    (0..2000u32).fold(1u32, |sum, n| {
        let half = sum >> 1;
        if sum & 1 != 0 { (half ^ 0xedb8_8320).wrapping_add(n) } else { half.wrapping_add(n << 3) }
    })
}

#[test]
fn exceptions_are_taken_and_left_as_the_manual_says() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_PROBE") else {
        println!("skipped: BEAMTICK_H743_PROBE names no program");
        return;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    let mut stops = vec![machine.run(100 * MILLISECOND)];
    stops.push(machine.run(100 * MILLISECOND));
    let memory = &machine.chip.memory;
    let count = memory.word(0x3800_0000).unwrap();
    let words: Vec<u32> = (0..count).map(|n| memory.word(0x3800_0004 + 4 * n).unwrap()).collect();
    #[rustfmt::skip]
    let expected = [
        // 1 preempts 0 that pends it, 2 waits for its end, the bell comes after both; the call
        // comes at once.
        1, 0x100, 0x110, 0x101, 0x120, 0x130, 0x140, 2,
        // 2 is held by BASEPRI, 1 is not; 2 comes when the mask goes; WFI ends after PRIMASK, 1
        // comes when that goes.
        3, 4, 0x110, 5, 0x120, 6, 7, 8, 0x110, 9,
        // Floating-point registers and FPSCR survive.
        0x110, 0x300, 0x4048_f5c3, 0xc020_0000, 0x4048_f5c3, 0x0180_0000,
        // The process stack, inside and after; the main stack again.
        0x120, 0x310, 2, 0, 0,
        0x320, 10,
        0x330, sum(), 1,
        // UNDEFINSTR, forced to a hard fault; then as the usage fault that it is.
        0x150, 1 << 16, 1 << 30, 0x150, 1 << 16, 0, 0x340,
        // The stack's end: MSTKERR, a reset by software; the flags say so beside those of power-on,
        // until they are cleared.
        0x1ff, 0x160, 1 << 4,
        0x200, 1 << 24 | 0x00fa_0000, 0,
    ];
    let hex = |words: &[u32]| words.iter().map(|word| format!("{word:x}")).collect::<Vec<_>>().join(" ");
    assert_eq!(hex(&words), hex(&expected));
    assert!(matches!(stops[..], [Stop::Reset(Cause::Software), Stop::Breakpoint(_)]), "{stops:?}");
    assert!(machine.chip.bus.complaints.is_empty(), "{:?}", machine.chip.bus.complaints);
}
