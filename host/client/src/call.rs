//! One call as bytes, and its reply back as fields.
use crate::error::{self, Error, Result};
use protocol::command::{CommandInfo, CommandKind, Request, class, info, opcode};
use protocol::reason::{Refusal, describe_opcode};
use zerocopy::{FromBytes, IntoBytes};

/// A request with its items, as it travels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Call {
    /// Number of the command.
    pub opcode: u16,
    /// The request's fields and items.
    pub payload: Vec<u8>,
    /// As an entry of a program: the program continues after it if it is refused.
    pub may_fail: bool,
}

impl Call {
    /// A request without items.
    pub fn of<R: Request>(request: R) -> Self {
        Self::with_items::<R>(request, &[])
    }

    /// A request and its items.
    pub fn with_items<R: Request>(request: R, items: &[R::Item]) -> Self {
        let mut payload = request.as_bytes().to_vec();
        payload.extend_from_slice(items.as_bytes());
        Call { opcode: R::OPCODE, payload, may_fail: false }
    }

    /// Whether a controller that got nothing but such calls has nothing lit or moving by them.
    pub(crate) fn is_harmless(&self) -> bool {
        self.opcode == opcode::Abort || class(self.opcode).is_some_and(|class| class.kind.is_harmless())
    }

    /// Whether it reads a state, and nothing else.
    pub fn is_read(&self) -> bool {
        class(self.opcode).is_some_and(|class| matches!(class.kind, CommandKind::Read(_)))
    }

    /// Its row in the command table, if the client knows the command.
    pub fn info(&self) -> Option<&'static CommandInfo> {
        info(self.opcode)
    }
}

/// What a person calls the command.
pub(crate) fn name(opcode: u16) -> String {
    info(opcode).map_or_else(|| format!("command {opcode:#06x}"), |c| c.name.to_owned())
}

/// The fixed part and the items of a reply with code 0.
pub fn decode<R: Request>(payload: &[u8]) -> Result<(R::Reply, Vec<R::ReplyItem>)> {
    let wrong = || {
        Error::new(
            error::LINK_PROTOCOL,
            format!("the reply to {} has {} bytes, which is not its length", R::NAME, payload.len()),
        )
    };
    let (reply, rest) = R::Reply::read_from_prefix(payload).map_err(|_| wrong())?;
    let size = size_of::<R::ReplyItem>();
    if size == 0 {
        return if rest.is_empty() { Ok((reply, Vec::new())) } else { Err(wrong()) };
    }
    if rest.len() % size != 0 {
        return Err(wrong());
    }
    let items = rest.chunks_exact(size).map(|c| R::ReplyItem::read_from_bytes(c).map_err(|_| wrong()));
    Ok((reply, items.collect::<Result<_>>()?))
}

/// The error for a reply whose code is not 0.
pub fn refused(opcode: u16, code: i16, payload: &[u8]) -> Error {
    // In a PathMany the reply to the calls before it follows.
    let own = if opcode == opcode::PathMany { payload.get(..size_of::<Refusal>()) } else { None };
    match Refusal::read_from_bytes(own.unwrap_or(payload)) {
        Ok(refusal) => Error { code, reason: describe_opcode(opcode, refusal).to_string(), refusal: Some(refusal) },
        Err(_) => Error::new(code, format!("{}: refused with code {code}, without a reason", name(opcode))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::command::{GetPrfPos, PtData, PtDataMany, PtItem, PtSpace};
    use protocol::reason::Reason;

    fn refusal(reason: Reason, field: u8, item: u16) -> Vec<u8> {
        Refusal {
            reason: (reason as u16).into(),
            field,
            item: item.into(),
            axis: 3.into(),
            got: 99.0.into(),
            low: 1.0.into(),
            high: 48.5.into(),
        }
        .as_bytes()
        .to_vec()
    }

    #[test]
    fn a_reason_names_command_parameter_and_limits() {
        let e = refused(PtSpace::OPCODE, 7, &refusal(Reason::OutOfRange, 1, 65535));
        assert_eq!(e.reason, "PtSpace: profile is 99; it must be from 1 to 48.5");
        assert_eq!(e.code, 7);
        let e = refused(PtData::OPCODE, 1, &refusal(Reason::FifoFull, 255, 65535));
        assert_eq!(e.reason, "PtData: axis 3: the FIFO is full; 48.5 segments fit");
        let e = refused(0x7777, 8, &refusal(Reason::UnknownCommand, 255, 65535));
        assert_eq!(e.reason, "the firmware does not know command number 99");
        let e = refused(PtDataMany::OPCODE, 7, &refusal(Reason::NotIncreasing, 5, 4));
        assert!(e.reason.contains("time_ms") && e.reason.ends_with("(item 5)"), "{}", e.reason);
        let e = refused(PtData::OPCODE, 7, &[]);
        assert!(e.reason.contains("without a reason"));
    }

    #[test]
    fn what_may_light_or_move_is_no_read() {
        for row in protocol::command::COMMANDS {
            let call = Call { opcode: row.opcode, payload: Vec::new(), may_fail: false };
            let changes = ["Set", "Clr", "Prf", "Laser", "Buf", "Ln", "Arc", "Ena", "Dis"]
                .iter()
                .any(|p| row.name.starts_with(p))
                || ["On", "Off", "Start", "Data", "Update", "Reset", "Stop", "Abort", "Choose", "Switch"]
                    .iter()
                    .any(|part| row.name.contains(part));
            let status = row.name.ends_with("Status")
                || row.name.starts_with("Get")
                || ["Abort", "WaitStop", "ProgramStart"].contains(&row.name);
            assert!(!call.is_harmless() || status || !changes, "{}", row.name);
        }
        assert!(Call::of(protocol::command::GetClock {}).is_harmless());
        assert!(!Call { opcode: 0x7777, payload: Vec::new(), may_fail: false }.is_harmless());
    }

    #[test]
    fn replies_of_wrong_length_are_refused() {
        let mut bytes = vec![0; 6];
        assert!(decode::<GetPrfPos>(&bytes).unwrap().1.is_empty());
        bytes.extend([0; 16]);
        assert_eq!(decode::<GetPrfPos>(&bytes).unwrap().1.len(), 2);
        bytes.push(0);
        assert_eq!(decode::<GetPrfPos>(&bytes).unwrap_err().code, error::LINK_PROTOCOL);
        assert_eq!(decode::<GetPrfPos>(&bytes[..3]).unwrap_err().code, error::LINK_PROTOCOL);
    }

    #[test]
    fn items_follow_the_request() {
        let call = Call::with_items(PtDataMany::default(), &[PtItem::default(); 3]);
        assert_eq!(call.payload.len(), 8 + 3 * 13);
        assert_eq!(call.info().unwrap().name, "PtDataMany");
    }
}
