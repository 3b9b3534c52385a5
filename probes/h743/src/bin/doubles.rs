#![no_std]
#![no_main]
//! The hashes of the thread's arithmetic in doubles (`probes/doubles`), on the H743.
//!
//! In: nothing. Out: words in SRAM 4, from 0x3800_0000: how many kinds are done, then for each the
//! low and the high word of its hash, and the count. `host/h743/tests/doubles.rs` compares them
//! with an x86's. It ends with a breakpoint.
use core::panic::PanicInfo;
use core::ptr::write_volatile;
use cortex_m_rt::entry;
use doubles::{Room, hashes};
use static_cell::ConstStaticCell;

/// Where the words go.
const LOG: *mut u32 = 0x3800_0000 as *mut u32;

static ROOM: ConstStaticCell<Room> = ConstStaticCell::new(Room::new());

/// One entry of the vector table.
type Vector = unsafe extern "C" fn();

unsafe extern "C" {
    fn DefaultHandler();
}

/// No interrupt is let in.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [Vector; 150] = [DefaultHandler as Vector; 150];

fn note(index: usize, word: u32) {
    // SAFETY: SRAM 4 is there from reset on, and nothing else lies in it.
    unsafe { write_volatile(LOG.add(index), word) };
}

#[entry]
fn main() -> ! {
    for (n, hash) in hashes(ROOM.take()).into_iter().enumerate() {
        for (k, word) in [hash.value as u32, (hash.value >> 32) as u32, hash.count].into_iter().enumerate() {
            note(1 + 3 * n + k, word);
        }
        note(0, n as u32 + 1);
    }
    loop {
        cortex_m::asm::bkpt();
    }
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    note(0, 0xdead);
    loop {
        cortex_m::asm::bkpt();
    }
}
