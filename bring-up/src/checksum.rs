//! A checksum of the image, by which two builds of one release differ.
//!
//! In: code and constants as the linker has placed them. Out: a number. Owns nothing. It only tells
//! builds apart: no error of flash is looked for. Fails never.

unsafe extern "C" {
    /// The first word of code in flash, and the address after the constants (cortex-m-rt's script).
    static __stext: u32;
    static __erodata: u32;
    /// The first word of code in ITCM, and the address after it (memory.x).
    static __shot: u32;
    static __ehot: u32;
}

/// FNV-1a over words (its offset and prime for 32 bits).
pub fn of_image() -> u32 {
    let flash = (&raw const __stext as usize)..(&raw const __erodata as usize);
    let fast = (&raw const __shot as usize)..(&raw const __ehot as usize);
    flash.chain(fast).step_by(4).fold(0x811c_9dc5, |sum: u32, at| {
        // SAFETY: whole words of the image, which nobody writes.
        (sum ^ unsafe { (at as *const u32).read_volatile() }).wrapping_mul(0x0100_0193)
    })
}
