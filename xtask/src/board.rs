//! Images of the boards with an STM32H743: their files, their use of the chip's memories, and
//! flashing of the reference board.
//!
//! In: the workspace. Out: ELF, BIN and Intel HEX in `out/`, named with the version, with their
//! checksums; tables of regions; a flashed board. Owns nothing. Fails: with a sentence that says
//! what is missing.
use crate::floats;
use crate::setup::compiler;
use crate::shell::{self, Outcome, program, root, run, target, works};
use object::Endianness;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// What probe-rs calls the chip.
const CHIP: &str = "STM32H743ZITx";
/// The image's program.
pub const BIN: &str = "beamtick-h743";
/// The program by which the board measures itself.
const BRING_UP: &str = "beamtick-bring-up";
/// The board's map of memories.
const MEMORY: &str = "memory.x";

/// Cargo's arguments for the reference board.
pub const FEATURES: [&str; 3] = REFERENCE.features;

/// An image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// Its program.
    program: &'static str,
    /// Cargo's arguments for it.
    pub features: [&'static str; 3],
    /// What its files' names have after the program's.
    suffix: &'static str,
}

const fn variant(program: &'static str, features: &'static str, suffix: &'static str) -> Variant {
    Variant { program, features: ["--no-default-features", "--features", features], suffix }
}

/// NUCLEO-H743ZI2.
pub const REFERENCE: Variant = variant(BIN, "nucleo_h743zi2", "");
/// The same with another DAC.
pub const REFERENCE_DAC: Variant = variant(BIN, "nucleo_h743zi2,external_dac", "-external-dac");
/// A module with an STM32H743VI.
pub const MODULE: Variant = variant("beamtick-h743vi", "h743vi_module", "");
/// The same with another DAC.
pub const MODULE_DAC: Variant = variant("beamtick-h743vi", "h743vi_module,external_dac", "-external-dac");
/// Each image of `cargo xtask image`. The plain one of the reference board comes last: what later
/// commands find under its program's name is that.
pub const VARIANTS: [Variant; 4] = [MODULE_DAC, MODULE, REFERENCE_DAC, REFERENCE];

impl Variant {
    /// Builds it and returns its path, which no other one has.
    pub fn build(self) -> Outcome<PathBuf> {
        let compiler = compiler()?;
        let mut cargo = compiler.cargo();
        cargo.args(["build", "--package", "beamtick-firmware", "--bin", self.program, "--profile", "image"]);
        run(cargo.args(self.features).args(compiler.arguments()))?;
        let built = target().join(crate::setup::TARGET).join("image").join(self.program);
        if self.suffix.is_empty() {
            return Ok(built);
        }
        let copy = built.with_file_name(format!("{}{}", self.program, self.suffix));
        fs::copy(&built, &copy).map_err(|e| format!("{}: {e}", copy.display()))?;
        Ok(copy)
    }
}

/// Builds the reference board's image and returns its path.
pub fn build() -> Outcome<PathBuf> {
    REFERENCE.build()
}

/// Builds the bring-up image and returns its path.
pub fn build_bring_up() -> Outcome<PathBuf> {
    crate::image::build_bin("beamtick-bring-up", BRING_UP)
}

/// Writes the files of the bring-up image; flashes it if that is wanted and probe-rs finds a board;
/// measures over this link, if one is named.
pub fn bring_up(link: Option<&str>, flashes: bool) -> Outcome {
    // Before anything is flashed.
    link.map_or(Ok(()), check_link)?;
    let elf = build_bring_up()?;
    write(&elf, BRING_UP, "")?;
    let has_probe = flashes && has_probe();
    if has_probe {
        flash_this(&elf)?;
    }
    let Some(link) = link else {
        let next = "then unplug CN1, put the jumpers in, plug it in: `cargo bring-up serial:/dev/ttyACM0:3000000 --no-flash` (the ST-LINK's port)";
        println!("{}{next}", if has_probe { "" } else { "copy the HEX onto the board's drive, press B2; " });
        return Ok(());
    };
    measure(link, &[])
}

/// Rates of a serial port, as the client has them.
const BAUDS: std::ops::RangeInclusive<u32> = 50..=20_000_000;

/// Whether it is the form of a link to a board. A serial port has its rate: the ST-LINK's hears
/// nothing at another one than 3000000.
fn check_link(link: &str) -> Outcome {
    let rate = |port: &str| port.rsplit_once(':').and_then(|(_, rate)| rate.parse::<u32>().ok());
    let has_rate = |port: &str| rate(port).is_some_and(|rate| BAUDS.contains(&rate));
    if link.starts_with("tcp:") || link.strip_prefix("serial:").is_some_and(has_rate) {
        return Ok(());
    }
    let rate = link.strip_prefix("serial:").map(|port| match port.rsplit_once(':') {
        Some((_, rate)) => format!("{rate:?} is no rate"),
        None => "the rate is missing".to_owned(),
    });
    Err(format!(
        "{link} is no link to a board{}. It is\n  cargo bring-up                                       builds and flashes the image\n  \
         cargo bring-up serial:/dev/ttyACM0:3000000           measures over the ST-LINK's port, and writes out/bring-up.md\n  \
         cargo bring-up serial:/dev/ttyACM0:3000000 loads     measures ticks of the board's own image\n  \
         cargo bring-up ... --no-flash                        the same, with the image that the board has\n\
         The port with its rate is serial:/dev/cu.usbmodemNNN:3000000 on macOS, serial:COM5:3000000 on Windows. A rate is {} to {}. \
         See docs/bring-up.md",
        rate.map(|what| format!(": {what}")).unwrap_or_default(),
        BAUDS.start(),
        BAUDS.end()
    ))
}

fn has_probe() -> bool {
    works(program("probe-rs").arg("--version"))
}

/// Flashes the board's own image if that is wanted and probe-rs is there, and measures its ticks
/// over this link.
pub fn loads(link: &str, flashes: bool) -> Outcome {
    check_link(link)?;
    if flashes && has_probe() {
        flash_this(&build()?)?;
    }
    measure(link, &["--loads"])
}

/// Runs `beamtick bring-up`.
fn measure(link: &str, words: &[&str]) -> Outcome {
    let page = root().join("out").join("bring-up.md");
    let mut command = shell::cargo();
    command.args(["run", "--release", "--package", "beamtick", "--", "bring-up", "--link", link]).args(words);
    run(command.arg("--page").arg(&page))
}

/// Builds every variant, writes their files, and prints what each takes of the chip. Returns the
/// files.
pub fn image() -> Outcome<Vec<PathBuf>> {
    let mut files = Vec::new();
    for variant in VARIANTS {
        let elf = variant.build()?;
        files.extend(write(&elf, variant.program, variant.suffix)?);
        let bytes = read(&elf)?;
        let free = regions(&bytes, &loaded(&bytes)?)?;
        if variant == REFERENCE {
            compare_with_page(&free)?;
        }
        hot(&bytes)?;
        floats::check(&bytes)?;
    }
    files.extend(write(&build_bring_up()?, BRING_UP, "")?);
    Ok(files)
}

/// Writes the files of a variant of a program; returns them.
fn write(elf: &Path, program: &str, variant: &str) -> Outcome<Vec<PathBuf>> {
    let bytes = read(elf)?;
    let loaded = loaded(&bytes)?;
    let folder = root().join("out");
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let name = format!("{program}{variant}-{}", env!("CARGO_PKG_VERSION"));
    let hex = hex(&loaded);
    let mut files = Vec::new();
    for (ending, content) in [("elf", &bytes), ("bin", &loaded.bytes), ("hex", &hex.into_bytes())] {
        let path = folder.join(format!("{name}.{ending}"));
        fs::write(&path, content).map_err(|e| format!("{}: {e}", path.display()))?;
        println!("{}: {} bytes, CRC-32 {:08x}", path.display(), content.len(), crc32(content));
        files.push(path);
    }
    Ok(files)
}

/// Prints what the reference board's image takes of each region, and what runs from ITCM. The
/// linker has refused what does not fit; less that is free than the page says is an error.
pub fn size() -> Outcome {
    let bytes = read(&build()?)?;
    compare_with_page(&regions(&bytes, &loaded(&bytes)?)?)?;
    hot(&bytes)?;
    floats::check(&bytes)
}

/// Flashes the board that is connected with the reference board's image, or with its variant.
pub fn flash(variant: Variant) -> Outcome {
    if !has_probe() {
        return Err(
            "probe-rs is missing: `cargo install probe-rs-tools --locked` (https://probe.rs); or copy the HEX that \
                    `cargo xtask image` writes onto the board's drive"
                .into(),
        );
    }
    flash_this(&variant.build()?)
}

/// Flashes an image with probe-rs, which is there.
fn flash_this(elf: &Path) -> Outcome {
    let found = shell::read(program("probe-rs").arg("list"))?;
    if !found.to_ascii_lowercase().contains("stlink") && !found.to_ascii_lowercase().contains("st-link") {
        return Err(format!("no ST-LINK is connected; probe-rs says: {}", found.trim()));
    }
    run(program("probe-rs").args(["download", "--verify", "--chip", CHIP]).arg(elf))?;
    run(program("probe-rs").args(["reset", "--chip", CHIP]))
}

fn read(path: &Path) -> Outcome<Vec<u8>> {
    fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}

/// What lies in flash, from its first byte to its last.
struct Loaded {
    base: u32,
    bytes: Vec<u8>,
}

fn loaded(elf: &[u8]) -> Outcome<Loaded> {
    let failed = |e: object::Error| format!("the image: {e}");
    let file = ElfFile32::<Endianness>::parse(elf).map_err(failed)?;
    let endian = file.endian();
    let mut parts = Vec::new();
    for segment in file.elf_program_headers() {
        if segment.p_type(endian) == object::elf::PT_LOAD && segment.p_filesz(endian) > 0 {
            let data =
                segment.data(endian, elf).map_err(|()| "the image: a segment lies outside the file".to_owned())?;
            parts.push((segment.p_paddr(endian), data));
        }
    }
    parts.sort_by_key(|(at, _)| *at);
    let base = parts.first().ok_or("the image loads nothing")?.0;
    let mut bytes = Vec::new();
    for (at, data) in parts {
        let at = (at - base) as usize;
        if at < bytes.len() {
            return Err(format!("the image: segments overlap at {:#010x}", base as usize + at));
        }
        // Flash that nothing is written to reads as ones.
        bytes.resize(at, 0xff);
        bytes.extend_from_slice(data);
    }
    Ok(Loaded { base, bytes })
}

/// Intel HEX: 16 bytes a line, an address line for each 64 KiB.
fn hex(loaded: &Loaded) -> String {
    let mut text = String::new();
    let mut upper = None;
    for (index, chunk) in loaded.bytes.chunks(16).enumerate() {
        let at = loaded.base + index as u32 * 16;
        if upper != Some(at >> 16) {
            upper = Some(at >> 16);
            line(&mut text, 0, 4, &((at >> 16) as u16).to_be_bytes());
        }
        line(&mut text, at as u16, 0, chunk);
    }
    line(&mut text, 0, 1, &[]);
    text
}

fn line(text: &mut String, at: u16, kind: u8, data: &[u8]) {
    let head = [data.len() as u8, (at >> 8) as u8, at as u8, kind];
    let sum = head.iter().chain(data).fold(0u8, |sum, byte| sum.wrapping_add(*byte));
    text.push(':');
    for byte in head.iter().chain(data).chain([&sum.wrapping_neg()]) {
        // Writing into a String never fails.
        let _ = write!(text, "{byte:02X}");
    }
    text.push('\n');
}

/// The CRC-32 of zip and Ethernet.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 })
    })
}

/// A region of the map.
#[derive(Debug, PartialEq, Eq)]
struct Region {
    name: String,
    origin: u64,
    length: u64,
}

impl Region {
    fn holds(&self, address: u64) -> bool {
        (self.origin..self.origin + self.length).contains(&address)
    }
}

/// The regions that a linker script's MEMORY names.
fn map(script: &str) -> Vec<Region> {
    let of = |line: &str| {
        let (name, rest) = line.split_once(':')?;
        let (origin, length) = rest.split_once(',')?;
        Some(Region {
            name: name.trim().to_owned(),
            origin: number(origin.split_once("ORIGIN =")?.1)?,
            length: number(length.split_once("LENGTH =")?.1)?,
        })
    };
    script.lines().filter_map(of).collect()
}

/// `0x400`, `64K`, `64K - 19K`, `48K + 0x20`.
fn number(text: &str) -> Option<u64> {
    text.split('+').map(difference).sum()
}

/// Without a sum.
fn difference(text: &str) -> Option<u64> {
    text.split('-')
        .map(|term| {
            let term = term.trim();
            if let Some(hex) = term.strip_prefix("0x") {
                return u64::from_str_radix(hex, 16).ok();
            }
            let (digits, factor) = match (term.strip_suffix('K'), term.strip_suffix('M')) {
                (Some(digits), _) => (digits, 1 << 10),
                (_, Some(digits)) => (digits, 1 << 20),
                _ => (term, 1),
            };
            Some(digits.trim().parse::<u64>().ok()? * factor)
        })
        .reduce(|left, right| Some(left? - right?))?
}

fn script() -> Outcome<String> {
    fs::read_to_string(root().join(MEMORY)).map_err(|e| format!("{MEMORY}: {e}"))
}

/// The functions that a linker script names for ITCM, as patterns of their symbols.
fn named(script: &str) -> Vec<&str> {
    script.lines().filter_map(|line| line.trim().strip_prefix("*(.text.")?.strip_suffix(')')).collect()
}

/// Whether a name is what a pattern means; `*` is any part.
fn matches(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == name,
        Some((first, rest)) => name
            .strip_prefix(first)
            .is_some_and(|tail| (0..=tail.len()).any(|at| tail.is_char_boundary(at) && matches(rest, &tail[at..]))),
    }
}

/// Prints the functions that run from ITCM. A name of the linker script that is none of them is an
/// error: a function that was renamed, or is no function of its own any more, would go back to
/// flash unseen.
fn hot(elf: &[u8]) -> Outcome {
    let script = script()?;
    let code = map(&script).into_iter().find(|region| region.name == "CODE").ok_or("there is no region CODE")?;
    let file = object::File::parse(elf).map_err(|e| format!("the image: {e}"))?;
    let is_hot = |symbol: &object::Symbol| {
        symbol.kind() == object::SymbolKind::Text && symbol.size() > 0 && code.holds(symbol.address())
    };
    let mut functions: Vec<(u64, u64, &str)> = file
        .symbols()
        .filter(is_hot)
        .map(|symbol| (symbol.address(), symbol.size(), symbol.name().unwrap_or_default()))
        .collect();
    functions.sort_unstable();
    if let Some(missing) = named(&script).iter().find(|name| !functions.iter().any(|(.., of)| matches(name, of))) {
        return Err(format!("{MEMORY} puts {missing} into CODE, and there is no such function"));
    }
    println!("CODE:");
    // Jumps into flash, which the linker adds.
    let (jumps, functions): (Vec<_>, Vec<_>) = functions.into_iter().partition(|(.., name)| name.contains("LongThunk"));
    for (_, size, name) in functions {
        println!("{size:>8} {name}");
    }
    println!("{:>8} {} jumps into flash", jumps.iter().map(|(_, size, _)| size).sum::<u64>(), jumps.len());
    Ok(())
}

/// The page that says what is free in each region of the reference board.
const PAGE: &str = "docs/board-h743-registers.md";

/// Fails where the page says that more is free than there is.
fn compare_with_page(free: &[(String, u64)]) -> Outcome {
    let page = fs::read_to_string(root().join(PAGE)).map_err(|e| format!("{PAGE}: {e}"))?;
    for (name, is) in free {
        let states = stated(&page, name).ok_or_else(|| format!("{PAGE} does not say what is free in {name}"))?;
        if states > *is {
            return Err(format!("{PAGE}: {states} bytes of {name} are free, it says; there are {is}"));
        }
    }
    Ok(())
}

/// The last cell of a region's row, in bytes.
fn stated(page: &str, region: &str) -> Option<u64> {
    let row = page.lines().find(|line| line.starts_with(&format!("| {region} |")))?;
    let cell = row.trim_end_matches('|').rsplit('|').next()?;
    cell.chars().filter(char::is_ascii_digit).collect::<String>().parse().ok()
}

/// Prints the regions of an image; returns what is free in each.
fn regions(elf: &[u8], loaded: &Loaded) -> Outcome<Vec<(String, u64)>> {
    const ALLOC: u64 = 2;
    let script = script()?;
    let file = object::File::parse(elf).map_err(|e| format!("the image: {e}"))?;
    println!("{:<8}{:>12}{:>10}{:>10}{:>8}", "region", "from", "bytes", "used", "free");
    let mut all = Vec::new();
    let map = map(&script);
    if map.len() != script.matches("ORIGIN =").count() {
        return Err(format!("{MEMORY} has a region whose numbers cannot be read"));
    }
    for region in map {
        let Region { name, origin, length } = &region;
        let holds_image = region.holds(loaded.base.into());
        let mut used = match name.as_str() {
            "STACK" => *length,
            _ if holds_image => loaded.bytes.len() as u64,
            _ => 0,
        };
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
            if used < *length && sh_flags & ALLOC != 0 && region.holds(section.address()) && !holds_image {
                used += section.size();
            }
        }
        let free = length.checked_sub(used).ok_or_else(|| format!("{name} holds {used} bytes of {length}"))?;
        println!("{name:<8}{origin:>#12x}{length:>10}{used:>10}{free:>8}");
        all.push((name.clone(), free));
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_is_read() {
        let script = "MEMORY\n{\n  A : ORIGIN = 0x00000400, LENGTH = 18K\n  B  : ORIGIN = 0x4c00, LENGTH = 64K - 19K\n  C : ORIGIN = 0x10, LENGTH = 1K - 0x10 + 4\n}";
        let region = |name: &str, origin, length| Region { name: name.into(), origin, length };
        assert_eq!(map(script), [region("A", 0x400, 18432), region("B", 0x4c00, 46080), region("C", 0x10, 1012)]);
    }

    #[test]
    fn the_page_is_read() {
        let page = "| region | what | free |\n| --- | --- | --- |\n| RAM | 46.5 KiB, small things | 1,160 |\n";
        assert_eq!((stated(page, "RAM"), stated(page, "CODE")), (Some(1160), None));
    }

    #[test]
    fn names_of_the_script_are_found() {
        let script = "  .hot : ALIGN(8)\n  {\n    *(.text.TIM2)\n    *(.text.*5steps*4fill*)\n  } > CODE AT>FLASH\n";
        assert_eq!(named(script), ["TIM2", "*5steps*4fill*"]);
        assert!(matches("TIM2", "TIM2") && !matches("TIM2", "TIM20"));
        let name = "_ZN5servo5steps6output19StepOutput4fill17hee72b53175f0f72eE";
        assert!(
            matches("*5steps*4fill*", name) && !matches("*5steps*4file*", name) && !matches("*4fill*5steps*", name)
        );
    }

    #[test]
    fn a_link_that_is_none_ends_before_anything_is_built_or_flashed() {
        for link in
            ["/dev/ttyACM0:3000000", "COM5", "virtual", "loads", "serial:COM5", "serial:/dev/null:abc", "serial:COM5:0"]
        {
            for outcome in
                [bring_up(Some(link), true), loads(link, true), bring_up(Some(link), false), loads(link, false)]
            {
                let why = outcome.unwrap_err();
                assert!(why.starts_with(&format!("{link} is no link to a board")), "{why}");
                assert!(why.contains(". It is\n  cargo bring-up"), "{why}");
            }
        }
        let why = ["serial:COM5", "serial:/dev/null:abc"].map(|link| check_link(link).unwrap_err());
        assert!(
            why[0].contains(" a board: the rate is missing. ") && why[1].contains(": \"abc\" is no rate. "),
            "{why:?}"
        );
        assert_eq!(["serial:COM5:3000000", "tcp:127.0.0.1:5000"].map(check_link), [Ok(()), Ok(())]);
    }

    /// The example of Intel's specification, and the check value that CRC-32 is published with.
    #[test]
    fn hex_and_checksum_are_the_published_ones() {
        let mut text = String::new();
        line(
            &mut text,
            0x0100,
            0,
            &[0x21, 0x46, 0x01, 0x36, 0x01, 0x21, 0x47, 0x01, 0x36, 0x00, 0x7e, 0xfe, 0x09, 0xd2, 0x19, 0x01],
        );
        assert_eq!(text, ":10010000214601360121470136007EFE09D2190140\n");
        let loaded = Loaded { base: 0x0801_fff0, bytes: vec![0; 32] };
        let hex = hex(&loaded);
        let lines: Vec<&str> = hex.lines().collect();
        assert_eq!(lines[0], ":020000040801F1");
        assert_eq!(lines[2], ":020000040802F0");
        assert_eq!(lines.last(), Some(&":00000001FF"));
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }
}
