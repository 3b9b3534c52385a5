//! The chip's memories, which the core, the DMA and the tests look at alike (RM0433 2.3, memory
//! map).
//!
//! In: addresses. Out: bytes. Owns the storage; the engine maps the same bytes, so the core's
//! accesses cost nothing here. Caches are not modelled: every master sees every write at once.
use crate::clocks::{AHB2ENR, AHB4ENR};
use std::alloc::{Layout, alloc_zeroed, dealloc, handle_alloc_error};
use std::ptr::NonNull;

/// Which masters reach a memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// The core alone (and MDMA, which no image of ours uses): ITCM and DTCM.
    Core,
    /// The core and every DMA.
    All,
}

/// One memory.
#[derive(Debug)]
pub struct Region {
    /// Its name in the manual.
    pub name: &'static str,
    /// First address.
    pub base: u32,
    /// Bytes.
    pub size: u32,
    /// Whether the core may write.
    pub writable: bool,
    /// Who reaches it.
    pub reach: Reach,
    /// The register of RCC, and its bit, that gives it a clock, where it is not on from reset.
    pub clock: Option<(u32, u32)>,
    bytes: NonNull<u8>,
}

/// The backup SRAM, which PWR guards too.
pub const BACKUP: u32 = 0x3880_0000;

type Clock = Option<(u32, u32)>;

/// The page of the engine, and the alignment of what it maps.
pub const PAGE: usize = 4096;

impl Region {
    fn new(name: &'static str, base: u32, size: u32, writable: bool, reach: Reach, clock: Clock) -> Region {
        let layout = Region::layout(size);
        // SAFETY: the size is not zero.
        let Some(bytes) = NonNull::new(unsafe { alloc_zeroed(layout) }) else { handle_alloc_error(layout) };
        Region { name, base, size, writable, reach, clock, bytes }
    }

    fn layout(size: u32) -> Layout {
        Layout::from_size_align(size as usize, PAGE).expect("a memory's size fits")
    }

    /// Where the bytes lie in this process.
    pub fn host(&self) -> *mut u8 {
        self.bytes.as_ptr()
    }

    fn place(&self, address: u32, length: u32) -> Option<*mut u8> {
        let offset = address.checked_sub(self.base)?;
        if offset.checked_add(length)? > self.size {
            return None;
        }
        // SAFETY: inside the allocation, as just checked.
        Some(unsafe { self.bytes.as_ptr().add(offset as usize) })
    }
}

impl Drop for Region {
    fn drop(&mut self) {
        // SAFETY: allocated by `new` with this layout.
        unsafe { dealloc(self.bytes.as_ptr(), Region::layout(self.size)) }
    }
}

/// All of them.
#[derive(Debug)]
pub struct Memory {
    regions: Vec<Region>,
}

// SAFETY: the bytes are reached through `&mut Machine` only, which one thread holds at a time; no
// byte belongs to a thread.
unsafe impl Send for Memory {}
// SAFETY: as above; the engine and the machine that share it are one value, never used from two
// threads at once.
unsafe impl Sync for Memory {}

impl Memory {
    /// The memories of the STM32H743xI, all zero; flash is erased.
    pub fn new() -> Memory {
        use Reach::{All, Core};
        let regions = vec![
            Region::new("flash", 0x0800_0000, 2 << 20, false, All, None),
            Region::new("ITCM", 0x0000_0000, 64 << 10, true, Core, None),
            Region::new("DTCM", 0x2000_0000, 128 << 10, true, Core, None),
            Region::new("AXI SRAM", 0x2400_0000, 512 << 10, true, All, None),
            Region::new("SRAM 1", 0x3000_0000, 128 << 10, true, All, Some((AHB2ENR, 29))),
            Region::new("SRAM 2", 0x3002_0000, 128 << 10, true, All, Some((AHB2ENR, 30))),
            Region::new("SRAM 3", 0x3004_0000, 32 << 10, true, All, Some((AHB2ENR, 31))),
            Region::new("SRAM 4", 0x3800_0000, 64 << 10, true, All, None),
            Region::new("backup SRAM", BACKUP, 4 << 10, true, All, Some((AHB4ENR, 28))),
            Region::new("unique id and flash size", 0x1ff1_e000, 4 << 10, false, All, None),
        ];
        let memory = Memory { regions };
        memory.fill(0x0800_0000, 2 << 20, 0xff);
        memory
    }

    /// Every one.
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    fn find(&self, address: u32, length: u32) -> Option<(&Region, *mut u8)> {
        self.regions.iter().find_map(|region| Some((region, region.place(address, length)?)))
    }

    /// Copies bytes in, flash included: what a programmer does, or a DMA. False where there is no
    /// memory.
    pub fn load(&self, address: u32, bytes: &[u8]) -> bool {
        let Some((_, place)) = self.find(address, bytes.len() as u32) else { return false };
        // SAFETY: the span lies in the allocation, and `bytes` is no part of it.
        unsafe { place.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len()) };
        true
    }

    fn fill(&self, address: u32, length: u32, value: u8) {
        if let Some((_, place)) = self.find(address, length) {
            // SAFETY: the span lies in the allocation.
            unsafe { place.write_bytes(value, length as usize) };
        }
    }

    /// Copies bytes out; `None` where there is no memory.
    pub fn bytes(&self, address: u32, length: u32) -> Option<Vec<u8>> {
        let (_, place) = self.find(address, length)?;
        // SAFETY: the span lies in the allocation, and nothing writes during the copy.
        Some(unsafe { std::slice::from_raw_parts(place, length as usize) }.to_vec())
    }

    /// A little-endian number of `size` bytes (1, 2 or 4).
    pub fn number(&self, address: u32, size: u32) -> Option<u32> {
        let (_, place) = self.find(address, size)?;
        let mut bytes = [0; 4];
        // SAFETY: `size` bytes of the allocation, at most four.
        unsafe { place.copy_to_nonoverlapping(bytes.as_mut_ptr(), size.min(4) as usize) };
        Some(u32::from_le_bytes(bytes))
    }

    /// A word.
    pub fn word(&self, address: u32) -> Option<u32> {
        self.number(address, 4)
    }

    /// The halfword of an instruction, 0 where there is no memory. Flash lies first: this is asked
    /// for each instruction.
    pub fn code(&self, address: u32) -> u16 {
        self.number(address, 2).unwrap_or(0) as u16
    }

    /// Whether a DMA of domain D2 reaches this (RM0433 2.1.3: the TCMs belong to the core and to
    /// MDMA).
    pub fn is_reached_by_dma(&self, address: u32) -> bool {
        self.find(address, 1).is_some_and(|(region, _)| region.reach == Reach::All)
    }
}

impl Default for Memory {
    fn default() -> Self {
        Memory::new()
    }
}
