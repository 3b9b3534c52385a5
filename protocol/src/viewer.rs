//! The controller's end of a read-only session: what a viewer asks, and the answers.
//!
//! In: bytes of a viewer's connection, and a function that answers a read. Out: bytes. Owns a link
//! of its own; the session of the client that commands is not reachable from here.
//! Budget: [`Viewer::answer`] handles at most a window of messages.
//! Fails: whatever is no read is refused with [`Reason::ReadOnly`] and reaches nobody.
use crate::Ns;
use crate::command::{CommandKind, class, opcode};
use crate::frame::MAX_PAYLOAD;
use crate::link::{Endpoint, Identity, LinkState, Role};
use crate::reason::{Reason, Refusal};
use crate::record::{Full, JOB_RECORD, JobState, Lane, ReplyHead, ReplyWriter, RequestRecord, requests};
use zerocopy::IntoBytes;
use zerocopy::little_endian::F64;

/// Messages on the way in each direction.
const WINDOW: usize = 4;
/// Longest name of a job that is shown, bytes.
pub const NAME_MAX: usize = MAX_PAYLOAD - size_of::<ReplyHead>() - size_of::<JobState>();

/// Whether a read was answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answered {
    /// It was.
    Now,
    /// Not yet: it is asked for again, and what follows it waits.
    Later,
}

impl From<Result<(), Full>> for Answered {
    fn from(written: Result<(), Full>) -> Self {
        if written.is_ok() { Answered::Now } else { Answered::Later }
    }
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Viewer {
    link: Endpoint<WINDOW>,
    /// Records of the message in hand that are done.
    at: usize,
}

/// Why a viewer does not get this.
fn refusal(record: &RequestRecord<'_>) -> Option<Refusal> {
    let Some(class) = class(record.opcode) else {
        return Some(Refusal { got: F64::new(record.opcode.into()), ..Refusal::new(Reason::UnknownCommand) });
    };
    let reads = matches!(class.kind, CommandKind::Read(_)) || record.opcode == opcode::ProgramStatus;
    (!reads || record.lane != Lane::Immediate).then(|| Refusal::new(Reason::ReadOnly))
}

impl Viewer {
    /// Nobody has asked.
    pub const fn new() -> Self {
        Viewer { link: Endpoint::new(Role::ReadOnly, Identity::OURS), at: 0 }
    }

    /// Takes received bytes, in any portions.
    pub fn feed(&mut self, now: Ns, bytes: &[u8]) {
        let session = self.link.session();
        self.link.feed(now, bytes);
        if self.link.session() != session {
            self.at = 0;
        }
    }

    /// A Hello for a read-only session has come, which is not open yet.
    pub fn is_asked(&self) -> bool {
        self.link.is_asked()
    }

    /// Answers that Hello with Busy: there are enough viewers.
    pub fn turn_away(&mut self) {
        self.link.turn_away();
    }

    /// Whether the session is open.
    pub fn is_open(&self) -> bool {
        self.link.state() == LinkState::Open
    }

    /// The session was open and is over.
    pub fn has_ended(&self) -> bool {
        self.link.state() == LinkState::Ended
    }

    /// Time since the last valid frame of the open session.
    pub fn silence(&self, now: Ns) -> Option<Ns> {
        self.link.silence(now)
    }

    /// Answers what has come, as far as there is room. `reply` answers a read.
    pub fn answer(&mut self, mut reply: impl FnMut(&RequestRecord<'_>, &mut ReplyWriter<'_>) -> Answered) {
        while let Some((message, draft)) = self.link.message_and_draft() {
            let mut writer = ReplyWriter::new(draft);
            let mut over = true;
            for record in requests(message).skip(self.at) {
                let answered = match record {
                    Ok(record) => match refusal(&record) {
                        None => reply(&record, &mut writer),
                        Some(refusal) => writer.refused(record.opcode, record.tag, &refusal).into(),
                    },
                    Err(malformed) => {
                        let (opcode, tag) = malformed.head.unwrap_or((0, 0));
                        writer.refused(opcode, tag, &malformed.refusal()).into()
                    }
                };
                if answered == Answered::Later {
                    over = false;
                    break;
                }
                self.at = self.at.saturating_add(1);
            }
            let length = writer.len();
            if over {
                self.link.done_with_message();
                self.at = 0;
            }
            let sent = length > 0 && self.link.send_draft(length).is_ok();
            if !(over || sent) {
                return;
            }
        }
    }

    /// Says what job runs, if there is room. `name` is cut where it is too long.
    pub fn show_job(&mut self, job: &JobState, name: &str) {
        let Some(draft) = self.link.draft() else { return };
        let mut end = name.len().min(NAME_MAX);
        while !name.is_char_boundary(end) {
            end = end.saturating_sub(1);
        }
        let mut writer = ReplyWriter::new(draft);
        let name = name.get(..end).unwrap_or("").as_bytes();
        if writer.push_raw(JOB_RECORD, 0, 0, &[job.as_bytes(), name]).is_ok() {
            let length = writer.len();
            self.link.send_draft(length).ok();
        }
    }

    /// Nothing sent waits for its acknowledgement.
    pub fn is_idle(&self) -> bool {
        self.link.all_acknowledged()
    }

    /// Bytes for the wire; returns how many were written into `out`.
    pub fn take_tx(&mut self, now: Ns, out: &mut [u8]) -> usize {
        self.link.take_tx(now, out)
    }
}

impl Default for Viewer {
    fn default() -> Self {
        Viewer::new()
    }
}
