//! The thread's arithmetic in doubles has the same bits on an x86, on the emulated board and on the
//! STM32H743 in emulation: hashes of `probes/doubles`, by programs that BEAMTICK_MPS2_DOUBLES and
//! BEAMTICK_H743_DOUBLES name (`cargo xtask check-all` does).
use doubles::{Hash, NAMES, Room, hashes};
use h743::{MILLISECOND, Machine, Stop};
use std::process::{Command, Stdio};

fn of_this_machine() -> Vec<Hash> {
    hashes(&mut Box::new(Room::new())).to_vec()
}

/// Every kind has results, and they are not all refusals: the counts are those of the seeds.
#[test]
fn each_kind_has_results() {
    for (name, hash) in NAMES.iter().zip(of_this_machine()) {
        println!("{name}: {:016x}, {} results", hash.value, hash.count);
        assert!(hash.count >= 3000, "{name}: {}", hash.count);
    }
}

#[test]
fn the_h743_computes_the_bits_of_an_x86() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_DOUBLES") else {
        println!("skipped: BEAMTICK_H743_DOUBLES names no program");
        return;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    let stop = machine.run(60_000 * MILLISECOND);
    assert!(matches!(stop, Stop::Breakpoint(_)), "{stop:?}");
    let word = |index: usize| machine.chip.memory.word(0x3800_0000 + 4 * index as u32).unwrap();
    assert_eq!(word(0), NAMES.len() as u32);
    for (n, (name, expected)) in NAMES.iter().zip(of_this_machine()).enumerate() {
        let [low, high, count] = [0, 1, 2].map(|k| word(1 + 3 * n + k));
        assert_eq!(Hash { value: u64::from(high) << 32 | u64::from(low), count }, expected, "{name}");
    }
    println!("{} million instructions", machine.chip.instructions / 1_000_000);
}

#[test]
fn the_emulated_board_computes_the_bits_of_an_x86() {
    let Some(path) = std::env::var_os("BEAMTICK_MPS2_DOUBLES") else {
        println!("skipped: BEAMTICK_MPS2_DOUBLES names no program");
        return;
    };
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", "null"]);
    qemu.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(path).stdin(Stdio::null());
    let output = qemu.output().unwrap();
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = |(name, hash): (&&str, Hash)| format!("{name} {:016x} {}\n", hash.value, hash.count);
    assert_eq!(printed, NAMES.iter().zip(of_this_machine()).map(line).collect::<String>());
}
