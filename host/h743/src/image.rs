//! An ELF image: what it loads into flash, and where its symbols are.
use crate::memory::Memory;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{LittleEndian, Object, ObjectSymbol};

type Elf<'a> = ElfFile32<'a, LittleEndian>;

fn parse(elf: &[u8]) -> Result<Elf<'_>, String> {
    Elf::parse(elf).map_err(|e| format!("the image is no ELF file: {e}"))
}

/// Puts every segment where a programmer would: at its load address.
pub fn load(elf: &[u8], memory: &Memory) -> Result<(), String> {
    for segment in parse(elf)?.elf_program_headers() {
        let bytes = segment.data(LittleEndian, elf).map_err(|()| "a segment lies outside of the image")?;
        let address = segment.p_paddr(LittleEndian);
        if segment.p_type(LittleEndian) != object::elf::PT_LOAD || bytes.is_empty() {
            continue;
        }
        if !memory.load(address, bytes) {
            return Err(format!("a segment of {} bytes at {address:#010x} fits into no memory", bytes.len()));
        }
    }
    Ok(())
}

/// The address of the first symbol whose name holds `part`.
pub fn symbol(elf: &[u8], part: &str) -> Result<u32, String> {
    let file = parse(elf)?;
    let found = file.symbols().find(|symbol| symbol.name().is_ok_and(|name| name.contains(part)));
    found.map(|symbol| symbol.address() as u32).ok_or(format!("the image has no symbol like {part}"))
}
