#![no_std]
#![no_main]
//! Prints the hashes of the thread's arithmetic in doubles (`probes/doubles`), by semihosting: one
//! line a kind, `NAME HASH COUNT`. `host/h743/tests/doubles.rs` compares them with an x86's.
use cortex_m_semihosting::hprintln;
use doubles::{NAMES, Room, hashes};
use hal as _; // the vector table
use static_cell::ConstStaticCell;

static ROOM: ConstStaticCell<Room> = ConstStaticCell::new(Room::new());

probes::exit_on_panic!();

#[cortex_m_rt::entry]
fn main() -> ! {
    for (name, hash) in NAMES.iter().zip(hashes(ROOM.take())) {
        hprintln!("{} {:016x} {}", name, hash.value, hash.count);
    }
    probes::exit()
}
