//! Two ends of a link, joined by hand.
#![allow(dead_code)]
use protocol::Ns;
use protocol::frame::{self, FrameKind, Header, MAX_WIRE};
use protocol::link::{Endpoint, Identity, LinkState, Role};

pub const MS: Ns = 1_000_000;

pub type End = Endpoint<4>;

pub fn out(end: &mut End, now: Ns) -> Vec<u8> {
    let mut wire = vec![0; 8 * MAX_WIRE];
    let length = end.take_tx(now, &mut wire);
    wire.truncate(length);
    wire
}

pub fn pump(now: Ns, client: &mut End, controller: &mut End) {
    loop {
        let (up, down) = (out(client, now), out(controller, now));
        if up.is_empty() && down.is_empty() {
            return;
        }
        controller.feed(now, &up);
        client.feed(now, &down);
    }
}

pub fn ends() -> (End, End) {
    (End::new(Role::Client, Identity::OURS), End::new(Role::Controller, Identity::OURS))
}

pub fn opened() -> (End, End) {
    let (mut client, mut controller) = ends();
    client.open(0, 1);
    pump(0, &mut client, &mut controller);
    assert_eq!((client.state(), controller.state()), (LinkState::Open, LinkState::Open));
    assert_eq!(client.session(), controller.session());
    (client, controller)
}

/// A sealed frame of the session that is open there.
pub fn sealed(end: &End, kind: FrameKind, acknowledgement: u16, payload: &[u8]) -> Vec<u8> {
    encoded(kind, end.session().unwrap(), (0, acknowledgement), payload)
}

pub fn encoded(kind: FrameKind, session: u32, (sequence, acknowledgement): (u16, u16), payload: &[u8]) -> Vec<u8> {
    let header = Header {
        version: protocol::VERSION,
        kind: kind as u8,
        flags: 0,
        credit: 4,
        session: session.into(),
        sequence: sequence.into(),
        acknowledgement: acknowledgement.into(),
        length: 0.into(),
    };
    let mut wire = vec![0; MAX_WIRE];
    let length = frame::encode(header, payload, &mut wire).unwrap();
    wire.truncate(length);
    wire
}
