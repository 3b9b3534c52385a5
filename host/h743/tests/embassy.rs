//! What a link costs by hal and by embassy-stm32, in instructions, and what the emulated chip
//! reports of each: the figures of docs/decisions/024-embassy-stm32.md. `cargo xtask embassy`
//! builds the programs, and names their folder by BEAMTICK_EMBASSY.
use h743::image::symbol;
use h743::{MILLISECOND, Machine};
use std::path::PathBuf;

/// Lengths of a message.
const LENGTHS: [u32; 5] = [1, 8, 16, 64, 256];
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/decisions/024-embassy-stm32.md");
/// The head of the table of instructions.
const HEAD: &str = "| bytes | ours | embassy-stm32 |\n| ---: | ---: | ---: |\n";

fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("BEAMTICK_EMBASSY").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: BEAMTICK_EMBASSY names no folder of programs");
    }
    folder
}

/// A machine in which a program has started, and waits.
fn started(elf: &[u8]) -> Machine {
    let mut machine = Machine::new().unwrap();
    machine.boot(elf).unwrap();
    machine.run(100 * MILLISECOND);
    machine
}

/// Instructions from a message's first byte until the program waits again and has read them all.
fn instructions(elf: &[u8], length: u32) -> u64 {
    let mut machine = started(elf);
    assert!(machine.waits(), "it does not wait");
    let read_at = symbol(elf, "LINK_HAS_READ").unwrap();
    let has_read = |machine: &Machine| machine.chip.memory.word(read_at).unwrap();
    let (before, none) = (machine.chip.instructions, has_read(&machine));
    machine.run(MILLISECOND);
    assert_eq!((machine.chip.instructions, none), (before, 0), "it does something where nothing comes");
    let message: Vec<u8> = (0..length).map(|n| n as u8 ^ 0x5a).collect();
    machine.send(&message);
    machine.run(2 * MILLISECOND);
    let sum: u32 = message.iter().map(|byte| u32::from(*byte)).sum();
    assert_eq!((machine.waits(), has_read(&machine)), (true, 0x1_0000 * length + sum), "{length} bytes");
    machine.chip.instructions - before
}

/// `BEAMTICK_WRITE=1` writes the table into the decision.
#[test]
fn a_link_takes_the_instructions_that_the_decision_states() {
    let Some(folder) = folder() else { return };
    let [ours, theirs] = ["link-hal", "link-embassy"].map(|name| std::fs::read(folder.join(name)).unwrap());
    let row = |length| format!("| {length} | {} | {} |\n", instructions(&ours, length), instructions(&theirs, length));
    let rows: String = LENGTHS.into_iter().map(row).collect();
    println!("{HEAD}{rows}");
    let page = std::fs::read_to_string(PAGE).unwrap();
    let (before, table) = page.split_once(HEAD).unwrap();
    let (stated, after) = table.split_at(table.find("\n\n").unwrap() + 1);
    if std::env::var_os("BEAMTICK_WRITE").is_some() {
        std::fs::write(PAGE, format!("{before}{HEAD}{rows}{after}")).unwrap();
        return;
    }
    assert_eq!(stated, rows);
}

/// What the decision says that the chip reports of embassy-stm32's programs, and of none of ours.
#[test]
fn the_chip_reports_what_the_decision_says_of_these_programs() {
    let Some(folder) = folder() else { return };
    for part in ["clocks", "adc", "usart", "spi", "watchdog"] {
        for by in ["hal", "embassy"] {
            let machine = started(&std::fs::read(folder.join(format!("{part}-{by}"))).unwrap());
            let complaints = &machine.chip.bus.complaints;
            println!("{part}-{by}: {complaints:?}");
            let has = |word: &str| complaints.iter().any(|text| text.contains(word));
            let expected = (by == "embassy" && part != "watchdog", by == "embassy" && part == "adc");
            assert_eq!(
                (has("PLL1 was changed while it runs"), has("are not what BOOST says")),
                expected,
                "{part}-{by}: {complaints:?}"
            );
            assert!(by == "embassy" || complaints.is_empty(), "{part}-{by}: {complaints:?}");
        }
    }
}
