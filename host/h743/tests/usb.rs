//! USB of the released image: what a host finds at the cable, and the link over it, where
//! BEAMTICK_H743_IMAGE names the image.
//!
//! What descriptors must be is from the tables of USB 2.0 (chapter 9), of CDC 1.2 and of PSTN 1.2;
//! sizes and places are those of the tables, not the image's.
mod images;

use client::{Call, Client, Options};
use h743::link::{EmulatedLink, Shared, lock};
use h743::usb_host::{Transfer, request};
use h743::{Level, MILLISECOND, Machine, Pin, Stop};
use protocol::command::{
    AxisOn, ClrLaserFault, GetEvents, GetJogPrm, GetLaserFault, LaserOutFrq, LaserPrfCmd, PrfJog, SetAxisMode,
    SetHSIOOpt, SetJogPrm, SetTick, SetVel, Update,
};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// The image, if there is one.
fn image() -> Option<Vec<u8>> {
    images::named("BEAMTICK_H743_IMAGE")
}

/// The unique id of this chip (RM0433 61.1): three words.
const ID: [u32; 3] = [0x0012_3456, 0x89ab_cdef, 0x0f1e_2d3c];

/// The board with its interlock closed and its cable in, and the port open.
fn plugged(elf: &[u8]) -> Shared {
    plugged_into(elf, false)
}

/// The same; `lenient`, with a core that takes packets without being enabled for them.
fn plugged_into(elf: &[u8], lenient: bool) -> Shared {
    let mut machine = Machine::new().unwrap();
    machine.chip.bus.usb.core.lenient = lenient;
    for (n, word) in (0..).zip(ID) {
        assert!(machine.chip.memory.load(0x1ff1_e800 + 4 * n, &word.to_le_bytes()));
    }
    machine.boot(elf).unwrap();
    for pin in ["PE15", "PE3", "PG2"] {
        machine.drive(Pin::named(pin).unwrap(), Some(false));
    }
    machine.run(20 * MILLISECOND);
    machine.plug_usb(true);
    until_open(&mut machine);
    Arc::new(Mutex::new(machine))
}

fn until_open(machine: &mut Machine) {
    let begin = machine.chip.now;
    while !machine.chip.bus.usb.host.is_open {
        assert_eq!(machine.run(MILLISECOND), Stop::Time);
        let host = &machine.chip.bus.usb.host;
        assert!(
            machine.chip.now < begin + 200 * MILLISECOND,
            "the host finds no port: {}; before: {:x?}; {:?}",
            host.state(),
            host.transfers.last(),
            machine.chip.bus.complaints
        );
    }
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
}

/// The answer to the first request that begins like this.
fn answer<'a>(transfers: &'a [Transfer], setup: &[u8]) -> &'a [u8] {
    let found = transfers.iter().rev().find(|transfer| transfer.setup.starts_with(setup));
    let found = found.unwrap_or_else(|| panic!("no request {setup:x?}"));
    assert!(found.is_done, "{setup:x?} was refused");
    &found.data
}

fn word(bytes: &[u8]) -> u16 {
    u16::from_le_bytes([bytes[0], bytes[1]])
}

/// The text of a string descriptor (USB 2.0 table 9-16).
fn text(descriptor: &[u8]) -> String {
    assert_eq!((usize::from(descriptor[0]), descriptor[1]), (descriptor.len(), 3));
    String::from_utf16(&descriptor[2..].chunks(2).map(word).collect::<Vec<_>>()).unwrap()
}

#[test]
fn a_host_finds_a_serial_port() {
    let Some(elf) = image() else { return };
    let shared = plugged(&elf);
    let machine = lock(&shared);
    let transfers = &machine.chip.bus.usb.host.transfers;
    assert!(transfers.iter().all(|transfer| transfer.is_done), "{transfers:x?}");

    // USB 2.0 table 9-8; the class is in the device (CDC 1.2 table 2): 2, 0, 0.
    let device = answer(transfers, &[0x80, 6, 0, 1, 0, 0, 18]);
    assert_eq!((device.len(), device[0], device[1], word(&device[2..])), (18, 18, 1, 0x0200));
    assert_eq!((&device[4..7], device[7]), (&[2, 0, 0][..], 64));
    // pid.codes, its number for tests.
    assert_eq!((word(&device[8..]), word(&device[10..])), (0x1209, 0x0001));
    assert_eq!((&device[14..17], device[17]), (&[1, 2, 3][..], 1));

    let language = answer(transfers, &[0x80, 6, 0, 3]);
    assert_eq!(language, [4, 3, 0x09, 0x04]);
    let string = |index: u8| text(answer(transfers, &[0x80, 6, index, 3, 9, 4]));
    assert_eq!((string(1), string(2)), ("Beamtick".into(), "Beamtick".into()));
    assert_eq!(string(3), "0012345689ABCDEF0F1E2D3C");

    // USB 2.0 table 9-10: two interfaces, the only configuration, self-powered, no current from the
    // bus.
    let all = answer(transfers, &[0x80, 6, 0, 2, 0, 0, transfers[4].setup[6]]);
    assert_eq!((all[0], all[1], usize::from(word(&all[2..]))), (9, 2, all.len()));
    assert_eq!((all[4], all[5], all[7], all[8]), (2, 1, 0xc0, 0));
    let mut rest = &all[9..];
    let mut parts = Vec::new();
    while let Some(&length) = rest.first() {
        let (part, behind) = rest.split_at(length.into());
        parts.push(part);
        rest = behind;
    }
    // USB 2.0 table 9-12: communications interface of the abstract control model (CDC 1.2 tables 14
    // to 16), one endpoint.
    assert_eq!(parts[0], [9, 4, 0, 0, 1, 2, 2, 0, 0]);
    // CDC 1.2 table 15 (header, release 1.10), PSTN 1.2 table 4 (line coding and state), CDC 1.2
    // table 16 (union of 0 and 1).
    assert_eq!(parts[1], [5, 0x24, 0x00, 0x10, 0x01]);
    assert_eq!(parts[2], [4, 0x24, 0x02, 0x02]);
    assert_eq!(parts[3], [5, 0x24, 0x06, 0, 1]);
    // USB 2.0 table 9-13: notifications come by an interrupt endpoint.
    assert_eq!((&parts[4][..2], parts[4][2] & 0x80, parts[4][3]), (&[7, 5][..], 0x80, 3));
    // Data interface (CDC 1.2 table 6), two bulk endpoints of 64 bytes, one each way.
    assert_eq!(parts[5], [9, 4, 1, 0, 2, 0x0a, 0, 0, 0]);
    let ends: Vec<_> = parts[6..].iter().map(|end| (end[0], end[1], end[2] & 0x80, end[3], word(&end[4..]))).collect();
    assert_eq!(ends, [(7, 5, 0, 2, 64), (7, 5, 0x80, 2, 64)]);

    // PSTN 1.2 table 17: what was set is what is read, 115200 8N1.
    assert_eq!(
        answer(transfers, &[0xa1, 0x21]),
        115_200u32.to_le_bytes().iter().chain(&[0, 0, 8]).copied().collect::<Vec<_>>()
    );
    assert_eq!(machine.resets, []);
}

/// A client over USB.
fn client(machine: &Shared) -> Client {
    let open = Client::open(Box::new(EmulatedLink::over_usb(machine.clone())), Options::default());
    open.unwrap_or_else(|error| panic!("no session over USB: {error}"))
}

/// Nothing was sent again, and nothing was damaged: what the client counts.
fn assert_smooth(client: &Client) {
    let counters = client.counters();
    let again = [counters.timeouts, counters.fast_retransmits, counters.duplicates, counters.beyond_window];
    let damaged =
        [counters.short, counters.checksum, counters.length, counters.deframe.too_long, counters.deframe.truncated];
    assert_eq!(again, [0; 4], "messages were sent again: timeouts, fast ones, duplicates, beyond the window");
    assert_eq!(damaged, [0; 5], "frames were damaged: too short, checksum, length, too long, cut off");
    assert!(counters.received > 0);
}

/// One over the USART, which does not wait long.
fn over_usart(machine: &Shared) -> Client {
    let options = Options { timeout: Duration::from_millis(300), ..Options::default() };
    Client::open(Box::new(EmulatedLink::new(machine.clone())), options).unwrap()
}

fn version(client: &Client) -> Vec<u8> {
    client.version().board.to_vec()
}

#[test]
fn the_other_wire_gets_the_link_once_the_first_client_is_silent() {
    let Some(elf) = image() else { return };
    let machine = plugged(&elf);
    // Over the USART first.
    let uart = over_usart(&machine);
    // While its client is alive, one over USB learns where it is.
    let second = Client::open(Box::new(EmulatedLink::over_usb(machine.clone())), Options::default());
    let reported = second.err().expect("two clients have a board");
    assert!(reported.code == -6 && reported.reason.contains("a client at the UART"), "{reported}");
    uart.call_items(GetEvents {}, &[]).unwrap();
    lock(&machine).run(501 * MILLISECOND);
    let usb = client(&machine);
    assert_eq!(version(&usb), version(&uart));
    assert!(version(&usb).starts_with(images::reference().0));
    // Nothing was on: nothing went dark by it.
    let (_, events) = usb.call_items(GetEvents {}, &[]).unwrap();
    assert!(events.iter().all(|event| event.kind != LASER_EVENT), "{events:?}");
    assert_smooth(&usb);
    // The other one's frames are none of the session any more.
    lock(&machine).take_sent();
    assert!(uart.call_items(GetEvents {}, &[]).is_err(), "two clients share a board");
    assert_eq!(lock(&machine).take_sent(), []);
    usb.call_items(GetEvents {}, &[]).unwrap();
    drop((uart, usb));
    let uart = over_usart(&machine);
    uart.call_items(GetEvents {}, &[]).unwrap();
    assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new());
}

#[test]
fn a_host_that_reads_and_writes_when_it_likes_loses_no_byte() {
    let Some(elf) = image() else { return };
    let machine = plugged(&elf);
    let usb = client(&machine);
    usb.call(PrfJog { core: 1.into(), profile: 1.into() }).unwrap();
    // The shortest tick leaves the thread little time, so that it is behind.
    usb.call(SetTick { tick_us: 10.into() }).unwrap();
    // It fetches packets for a millisecond in four, and sends as fast as the wire goes: both sides
    // wait.
    lock(&machine).chip.bus.usb.host.reads_for = Some((MILLISECOND, 4 * MILLISECOND));
    let calls: Vec<_> = (0..300)
        .map(|n| {
            Call::of(SetJogPrm {
                core: 1.into(),
                profile: 1.into(),
                acc: (1.0 + f64::from(n)).into(),
                dec: 1.0.into(),
                smooth: 0.5.into(),
            })
        })
        .collect();
    client_calls(&usb, &calls);
    let last = usb.call(GetJogPrm { core: 1.into(), profile: 1.into() }).unwrap();
    assert_eq!(last.acc.get(), 300.0);
    assert_smooth(&usb);
    let machine = lock(&machine);
    let host = &machine.chip.bus.usb.host;
    println!("{} packets taken, {} answered NAK, {} not fetched at once", host.taken, host.naks, host.unread);
    assert!(host.naks > 0 && host.unread > 0, "nobody had to wait");
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
}

#[test]
fn answers_of_whole_packets_arrive_at_once() {
    let Some(elf) = image() else { return };
    for lenient in [false, true] {
        answers_arrive_at_once(&plugged_into(&elf, lenient));
    }
}

fn answers_arrive_at_once(machine: &Shared) {
    let usb = client(machine);
    // Ten bytes each, in one message: 30 of them with 20 around make five packets.
    for count in 1..=32 {
        client_calls(&usb, &vec![Call::of(GetLaserFault { core: 1.into(), channel: 0.into() }); count]);
    }
    assert_smooth(&usb);
    let machine = lock(machine);
    assert!(machine.chip.bus.usb.host.empty > 0, "no answer was as long as that");
    assert_eq!(machine.chip.bus.complaints, Vec::<String>::new());
}

fn client_calls(client: &Client, calls: &[Call]) {
    let answers = client.call_all(calls).unwrap();
    assert_eq!(answers.len(), calls.len());
    assert!(answers.iter().all(Result::is_ok), "{answers:?}");
}

#[test]
fn a_pulled_cable_ends_the_light_and_says_so_when_it_is_back() {
    let Some(elf) = image() else { return };
    let shared = plugged(&elf);
    let usb = client(&shared);
    let (core, channel) = (1.into(), 0.into());
    usb.call(AxisOn { core, axis: 1.into() }).unwrap();
    usb.call(PrfJog { core, profile: 1.into() }).unwrap();
    let (acc, dec, smooth) = (10.0.into(), 10.0.into(), 0.0.into());
    usb.call(SetJogPrm { core, profile: 1.into(), acc, dec, smooth }).unwrap();
    usb.call(SetVel { core, profile: 1.into(), vel: 10.0.into() }).unwrap();
    usb.call(Update { core, mask: 1.into() }).unwrap();
    usb.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
    usb.call(LaserOutFrq { core, frequency: 10.0.into(), channel }).unwrap();
    usb.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
    usb.call(SetHSIOOpt { core, value: 1.into(), channel }).unwrap();
    lock(&shared).run(10 * MILLISECOND);
    let count = |machine: &Machine, name, level, since| {
        let (pin, level) = (Pin::named(name).unwrap(), Level::Driven(level));
        machine.chip.bus.gpio.changes.iter().filter(|c| c.pin == pin && c.at > since && c.level == level).count()
    };
    let lit_since = |machine: &Machine, since| count(machine, "PE9", false, since);
    let steps_since = |machine: &Machine, since| count(machine, "PF8", true, since);
    let pulled = {
        let mut machine = lock(&shared);
        let begin = machine.chip.now;
        machine.run(10 * MILLISECOND);
        assert!(lit_since(&machine, begin) > 90, "no light to begin with");
        machine.plug_usb(false);
        machine.chip.now
    };
    // 500 ms without a frame (SPEC 9), and the two ticks by which lasers lag.
    let mut machine = lock(&shared);
    machine.run(502 * MILLISECOND);
    let dark = machine.chip.now;
    machine.run(20 * MILLISECOND);
    assert_eq!(lit_since(&machine, dark), 0, "light without a host");
    assert_eq!(steps_since(&machine, dark), 0, "steps without a host");
    assert!(lit_since(&machine, pulled) > 4000, "the light goes on until the time is over");
    assert!(steps_since(&machine, pulled) > 4000, "the axis goes on until the time is over");
    assert_eq!(machine.resets, [], "a missing host is no reason to bite");
    machine.plug_usb(true);
    until_open(&mut machine);
    drop(machine);
    drop(usb);
    let usb = client(&shared);
    assert_eq!(usb.call(GetLaserFault { core, channel }).unwrap().value.get(), LINK_LOST);
    let (_, events) = usb.call_items(GetEvents {}, &[]).unwrap();
    assert!(events.iter().any(|event| (event.kind, event.reason.get()) == (LINK_EVENT, 1)), "{events:?}");
    assert!(
        events.iter().any(|event| event.kind == LASER_EVENT && event.reason.get() == LINK_LOST as u16),
        "{events:?}"
    );
    usb.call(ClrLaserFault { core, channel }).unwrap();
    assert_smooth(&usb);
    assert_eq!(lock(&shared).chip.bus.complaints, Vec::<String>::new());
}

/// What keeps a laser dark (docs/laser.md): the link was lost.
const LINK_LOST: i16 = 2;
/// Kinds of events (docs/protocol.md): a laser channel, the link.
const LASER_EVENT: u8 = 3;
const LINK_EVENT: u8 = 4;

#[test]
fn what_a_host_should_not_ask_for_does_no_harm() {
    let Some(elf) = image() else { return };
    let shared = plugged(&elf);
    {
        let mut machine = lock(&shared);
        let host = &mut machine.chip.bus.usb.host;
        let asked = [
            // Endpoints that are not there: status, and halt set and cleared (USB 2.0 9.4.5, 9.4.9,
            // 9.4.1).
            request(0x82, 0, 0, 0x0f, &[], 2),
            request(0x02, 3, 0, 0x8f, &[], 0),
            request(0x02, 1, 0, 0x07, &[], 0),
            // An interface, a descriptor, a string and a request that are not there; more bytes
            // than there is room for.
            request(0x81, 0, 0, 9, &[], 2),
            request(0x80, 6, 0x4200, 0, &[], 255),
            request(0x80, 6, 0x03ee, 0x0409, &[], 255),
            request(0xc0, 0x77, 1, 2, &[], 64),
            request(0x21, 0x20, 0, 0, &[0xff; 512], 512),
            // Status of the device (USB 2.0 figure 9-4): self-powered or not, no wake-up.
            request(0x80, 0, 0, 0, &[], 2),
        ];
        let before = host.transfers.len();
        asked.iter().for_each(|transfer| host.ask(transfer.clone()));
        machine.run(50 * MILLISECOND);
        let transfers = &machine.chip.bus.usb.host.transfers[before..];
        assert_eq!(transfers.len(), asked.len(), "{transfers:x?}");
        let done: Vec<_> = transfers[3..].iter().map(|transfer| transfer.is_done).collect();
        assert_eq!(done, [false, false, false, false, false, true]);
        assert_eq!(transfers[8].data.len(), 2);
        assert_eq!(machine.resets, [], "a host has stopped the board");
    }
    // The bus is reset while a packet waits that nobody has fetched.
    let usb = client(&shared);
    lock(&shared).chip.bus.usb.host.reads = false;
    drop(usb);
    {
        let mut machine = lock(&shared);
        let frame = hello();
        machine.send_usb(&frame);
        machine.run(5 * MILLISECOND);
        let now = machine.chip.now;
        machine.chip.bus.usb.host.reset(now);
        machine.chip.bus.usb.host.reads = true;
        until_open(&mut machine);
    }
    let usb = client(&shared);
    assert!(version(&usb).starts_with(images::reference().0));
    assert_eq!(lock(&shared).chip.bus.complaints, Vec::<String>::new());
}

/// A Hello of protocol.md, section 2, with the schema of this build.
fn hello() -> Vec<u8> {
    let mut end = protocol::link::Endpoint::<2>::new(protocol::link::Role::Client, protocol::link::Identity::OURS);
    end.open(0, 0x1234_5678);
    let mut out = [0; 64];
    let length = end.take_tx(0, &mut out);
    out[..length].to_vec()
}
