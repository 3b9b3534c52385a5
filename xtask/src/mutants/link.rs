//! Mutants of the ring between thread and tick, and of the host link.
use super::list::{Mutant, mutant};

const ENDPOINT: &[&str] =
    &["-p", "beamtick-protocol", "--test", "endpoint", "--", "an_acknowledgement_of", "a_lost_message", "a_frame_with"];
const DELIVERIES: &[&str] = &["-p", "beamtick-protocol", "--lib", "--", "every_delivery"];
const PROPERTIES: &[&str] = &["-p", "beamtick-protocol", "--test", "properties", "--", "frames_of_every_length"];
const LINK: &[&str] = &["-p", "beamtick-host-tests", "--test", "link", "--", "a_restart_in_mid_stream", "every_seed"];
const RING: &[&str] = &["-p", "beamtick-ring", "--lib"];

const RECEIVE: &str = "protocol/src/link/receive.rs";
const TRANSMIT: &str = "protocol/src/link/transmit.rs";
const QUEUE: &str = "ring/src/queue.rs";

/// Those of one crate together.
pub const RING_AND_LINK: &[Mutant] = &[
    // -- ring ----------------------------------------------------------------------------------
    mutant(
        "a full ring takes one more",
        QUEUE,
        "if self.pushed.wrapping_sub(popped) >= N as u32 {",
        "if self.pushed.wrapping_sub(popped) > N as u32 {",
        RING,
    ),
    mutant(
        "a cleared ring is not empty",
        QUEUE,
        "self.free_to(self.ring.pushed.load(Ordering::Relaxed));",
        "self.free_to(self.popped);",
        RING,
    ),
    mutant(
        "a reader does not take the newest",
        "ring/src/latest.rs",
        "        if self.is_new() {",
        "        if !self.is_new() {",
        RING,
    ),
    // -- link ----------------------------------------------------------------------------------
    mutant(
        "an acknowledgement of what was never sent is taken",
        TRANSMIT,
        "if step > outstanding {",
        "if step > u16::MAX - 1 {",
        ENDPOINT,
    ),
    mutant(
        "a message that is lost is not sent again",
        TRANSMIT,
        "        self.resend = true;\n        self.recover = Some(self.sent);\n        self.retry =",
        "        self.recover = Some(self.sent);\n        self.retry =",
        ENDPOINT,
    ),
    mutant(
        "a checksum is not compared",
        "protocol/src/frame.rs",
        "(checksum(&[body]) == u32::from_le_bytes(*crc)).then_some(body)",
        "(crc.len() == 4).then_some(body)",
        ENDPOINT,
    ),
    mutant(
        "a full block is followed by a zero",
        "protocol/src/deframe.rs",
        "let full = code == 0xFF;",
        "let full = code == 0x00;",
        PROPERTIES,
    ),
    // -- link, both ends -----------------------------------------------------------------------
    mutant(
        "a message that comes twice is taken twice",
        RECEIVE,
        "let Some(distance) = ahead(sequence, self.take) else { return Accepted::Duplicate };",
        "let distance = ahead(sequence, self.take).unwrap_or(0);",
        LINK,
    ),
    mutant(
        "a message of any session is taken",
        RECEIVE,
        "let known = self.session != 0 && session == self.session;",
        "let known = self.session != 0;",
        LINK,
    ),
    // -- every delivery of the first frames of the link ---------------------------------------
    mutant(
        "deliveries: a frame of any session is taken",
        RECEIVE,
        "let known = self.session != 0 && session == self.session;",
        "let known = self.session != 0;",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a message that comes late is another one",
        RECEIVE,
        "let Some(distance) = ahead(sequence, self.take) else { return Accepted::Duplicate };",
        "let distance = ahead(sequence, self.take).unwrap_or(0);",
        DELIVERIES,
    ),
    mutant(
        "deliveries: numbers do not begin anew",
        TRANSMIT,
        "(distance < 0x8000).then_some(distance)",
        "(a >= b).then_some(distance)",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a message that is lost is not sent again",
        TRANSMIT,
        "        self.resend = true;\n        self.recover = Some(self.sent);\n        self.retry =",
        "        self.recover = Some(self.sent);\n        self.retry =",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a KeepAlive is not answered",
        RECEIVE,
        "FrameKind::KeepAlive => self.receiver.ask_acknowledgement(),",
        "FrameKind::KeepAlive => {}",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a new session keeps the messages of the old one",
        "protocol/src/link.rs",
        "        self.transmitter.reset(window);\n        self.receiver.reset();",
        "        self.transmitter.reset(window);",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a client is open before the controller is",
        RECEIVE,
        "        self.phase = SessionPhase::Confirming(1);",
        "        self.phase = SessionPhase::Confirming(1);\n        self.state = LinkState::Open;",
        DELIVERIES,
    ),
    mutant(
        "deliveries: what is missing is acknowledged",
        TRANSMIT,
        "acknowledgement: self.receiver.next().into(),",
        "acknowledgement: self.receiver.next().wrapping_add(u16::from(gap)).into(),",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a client confirms for ever",
        "protocol/src/link.rs",
        "SessionPhase::Confirming(count) if count < 3 =>",
        "SessionPhase::Confirming(count) =>",
        DELIVERIES,
    ),
    mutant(
        "deliveries: an answer to another Hello is taken up",
        RECEIVE,
        "|| self.phase != SessionPhase::Asking || !ours {",
        "|| self.phase != SessionPhase::Asking || !ours && header.session.get() == 0 {",
        DELIVERIES,
    ),
    mutant(
        "deliveries: a checksum is not compared",
        "protocol/src/frame.rs",
        "(checksum(&[body]) == u32::from_le_bytes(*crc)).then_some(body)",
        "(crc.len() == 4).then_some(body)",
        DELIVERIES,
    ),
    mutant(
        "deliveries: the timer of the message after an acknowledged one is not set",
        TRANSMIT,
        "self.retry_at = (self.base != self.sent).then(|| now.saturating_add(self.retry));",
        "self.retry_at = None;",
        DELIVERIES,
    ),
];
