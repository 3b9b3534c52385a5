//! What parts of embassy-stm32 would take in place of those of `hal` (decision 24).
//!
//! In: the programs of `probes/embassy`, which is no member of the workspace. Out: a row for each
//! part, with the bytes that it takes beyond a program that does nothing; then what the emulated
//! chip counts and reports of them (`host/h743/tests/embassy.rs`). Fails: with the compiler's
//! errors, and where the decision states other instructions.
use crate::setup::{TARGET, compiler};
use crate::shell::{self, Outcome, root, target};
use object::{Object, ObjectSection, SectionFlags};
use std::path::Path;

/// Parts; each has a program by `hal` and one by embassy-stm32.
const PARTS: [&str; 5] = ["clocks", "watchdog", "usart", "spi", "adc"];
/// The region RAM of `memory.x`.
const RAM: std::ops::Range<u64> = 0x200..0xbc00;

/// Bytes of flash and of the region RAM.
type Sizes = [u64; 2];

/// Builds the programs and prints the table.
pub fn report() -> Outcome {
    let compiler = compiler()?;
    let folder = target().join("embassy");
    let mut command = compiler.cargo();
    command.args(["build", "--release", "--bins"]).args(compiler.arguments());
    shell::run(command.current_dir(root().join("probes").join("embassy")).env("CARGO_TARGET_DIR", &folder))?;
    let of = |program: &str| sizes(&folder.join(TARGET).join("release").join(program));
    let nothing = of("nothing")?;
    println!("| part | flash, ours | flash, theirs | RAM, ours | RAM, theirs |\n| --- | ---: | ---: | ---: | ---: |");
    for part in PARTS {
        let [ours, theirs] = [of(&format!("{part}-hal"))?, of(&format!("{part}-embassy"))?];
        let more = |sizes: Sizes, which: usize| sizes[which].saturating_sub(nothing[which]);
        let [flash, ram] = [0, 1].map(|which| [more(ours, which), more(theirs, which)]);
        println!("| {part} | {} | {} | {} | {} |", flash[0], flash[1], ram[0], ram[1]);
    }
    let mut command = shell::cargo();
    command.args(["test", "--package", "beamtick-h743", "--test", "embassy", "--", "--nocapture"]);
    shell::run(command.env("BEAMTICK_EMBASSY", folder.join(TARGET).join("release")))
}

fn sizes(path: &Path) -> Outcome<Sizes> {
    const ALLOC: u64 = 2;
    let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let bytes = std::fs::read(path).map_err(|e| failed(&e))?;
    let file = object::File::parse(&*bytes).map_err(|e| failed(&e))?;
    let [mut flash, mut ram] = [0; 2];
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        if sh_flags & ALLOC == 0 {
            continue;
        }
        if section.file_range().is_some() {
            flash += section.size();
        }
        if RAM.contains(&section.address()) {
            ram += section.size();
        }
    }
    Ok([flash, ram])
}
