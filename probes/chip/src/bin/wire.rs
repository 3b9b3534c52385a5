#![no_std]
#![no_main]
//! Must link, as `no-panic` must: what comes over the wire meets no panic. The link with all its
//! states, records of both directions, requests and replies with and without items, on bytes of
//! which the optimiser knows nothing.
use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m as _;
use hal as _;
use protocol::command::{GetEvents, LaserStatus, LoadConfig, PtDataMany, Stop, Version};
use protocol::link::{Endpoint, Identity, Role};
use protocol::record::{Lane, ReplyWriter, RequestRecord, RequestWriter, replies, requests};
use static_cell::ConstStaticCell;

unsafe extern "C" {
    fn something_reached_a_panic() -> !;
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    // SAFETY: there is no such function; the linker says so if this is reachable.
    unsafe { something_reached_a_panic() }
}

static LINK: ConstStaticCell<Option<Endpoint<8>>> = ConstStaticCell::new(None);

/// The link's end, as the server uses it.
#[inline(never)]
fn link(link: &mut Endpoint<8>, now: u64, bytes: &[u8], out: &mut [u8]) {
    link.feed(now, bytes);
    link.poll(now);
    if let Some(message) = link.message() {
        read(message, out);
        link.done_with_message();
    }
    black_box(link.send(bytes).is_ok());
    if let Some(draft) = link.draft() {
        draft.fill(0);
        black_box(link.send_draft(now as usize).is_ok());
    }
    black_box(link.take_tx(now, out));
    black_box((link.next_deadline(), link.last_valid(), link.silence(now), link.counters(), link.free_slots()));
    link.open(now, now as u32);
    link.close();
}

/// Records of a message.
#[inline(never)]
fn read(message: &[u8], out: &mut [u8]) {
    let mut writer = ReplyWriter::new(out);
    for record in requests(message) {
        match record {
            Ok(record) => {
                black_box(records(&record));
                black_box(writer.push_raw(record.opcode, record.tag, 0, &[record.body]).is_ok());
            }
            Err(malformed) => {
                let (opcode, tag) = malformed.head.unwrap_or((0, 0));
                black_box(writer.refused(opcode, tag, &malformed.refusal()).is_ok());
            }
        }
    }
    for record in replies(message).flatten() {
        black_box(record.refusal());
        if let Ok((reply, items)) = record.parse::<GetEvents>() {
            black_box((reply, items.iter().last(), items.len()));
        }
        black_box(record.parse::<LaserStatus>().is_ok());
    }
    black_box(writer.len());
}

fn records(record: &RequestRecord<'_>) -> bool {
    let items = record.parse::<PtDataMany>().is_ok_and(|(_, items)| items.iter().count() == items.len());
    let config = record.parse::<LoadConfig>().is_ok_and(|(_, items)| !items.is_empty());
    items | config | record.parse::<Stop>().is_ok() | record.parse::<Version>().is_ok()
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut bytes = [0; 64];
    let mut out = [0; 512];
    if let Some(state) = LINK.try_take() {
        let state = state.insert(Endpoint::new(Role::Controller, Identity::OURS));
        loop {
            link(black_box(state), black_box(0), black_box(&bytes), black_box(&mut out));
            let mut writer = RequestWriter::new(black_box(&mut bytes));
            black_box(writer.push(Lane::Immediate, 0, &Version {}, &[]).is_ok());
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}
