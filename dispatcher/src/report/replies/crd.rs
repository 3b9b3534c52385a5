//! Reads of coordinate systems.
use super::{Reading, number};
use crate::plan::geometry::position_of;
use crate::report::answer::Query;
use crate::shadow::CrdShadow;
use protocol::command::{self, opcode};
use protocol::record::{Full, ReplyWriter};
use servo::path::{DIMENSIONS, PathStop};
use servo::units::Crd;
use servo::view::CrdView;
use zerocopy::IntoBytes;

/// Whether a command reads a coordinate system.
pub fn is_crd(number: u16) -> bool {
    matches!(
        number,
        opcode::GetCrdPrm
            | opcode::CrdSpace
            | opcode::CrdStatus
            | opcode::GetCrdPos
            | opcode::GetCrdVel
            | opcode::GetRemainderSegNum
            | opcode::GetCrdLimit
            | opcode::GetLaserFollowFilter
            | opcode::CrdInfo
    )
}

fn whole(count: u32) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}

impl<const AXES: usize> Reading<'_, AXES> {
    fn crd(&self, crd: Crd) -> (&CrdShadow, &CrdView) {
        let [first, ..] = &self.view.crds;
        (self.executed.crd(crd), self.view.crds.get(crd.index()).unwrap_or(first))
    }

    /// A read of the coordinate system `first`; `which` is the FIFO, or the coordinate.
    pub(super) fn crd_reply(&self, tag: u16, query: &Query, out: &mut ReplyWriter) -> Result<(), Full> {
        let crd = Crd::new(usize::from(query.first)).unwrap_or_default();
        let (shadow, sampled) = self.crd(crd);
        let fifo = query.which;
        match query.opcode {
            opcode::GetCrdPrm => {
                let reply = shadow.frame.map_or_else(Default::default, |frame| frame.wire());
                out.done::<command::GetCrdPrm>(tag, &reply, &[])
            }
            opcode::CrdStatus => {
                let reply = command::CrdStatusReply {
                    run: i16::from(sampled.runs).into(),
                    segment: whole(shadow.segments(sampled, fifo).0).into(),
                };
                out.done::<command::CrdStatus>(tag, &reply, &[])
            }
            opcode::GetCrdPos => {
                let count = shadow.frame.map_or(0, |frame| usize::from(frame.dimension)).min(DIMENSIONS);
                let items = position_of(&sampled.position).map(|value| command::Real { value: value.into() });
                let head = command::Count { count: (count as u16).into() };
                out.done::<command::GetCrdPos>(tag, &head, items.get(..count).unwrap_or(&[]))
            }
            opcode::GetCrdVel => {
                let value = number(sampled.motion.velocity()).into();
                out.done::<command::GetCrdVel>(tag, &command::Real { value }, &[])
            }
            opcode::GetLaserFollowFilter => {
                let value = shadow.lag_ms.into();
                out.done::<command::GetLaserFollowFilter>(tag, &command::Real { value }, &[])
            }
            opcode::GetCrdLimit => {
                let (vel, acc) = shadow.limits.get(usize::from(fifo)).copied().unwrap_or_default();
                let reply = command::CrdLimit { vel_max: vel.into(), acc_max: acc.into() };
                out.done::<command::GetCrdLimit>(tag, &reply, &[])
            }
            opcode::CrdInfo => {
                let both = |of: &dyn Fn(u8) -> u32| [0, 1].map(|fifo| whole(of(fifo)).into());
                let axes = shadow.frame.map_or([None; DIMENSIONS], |frame| frame.axes());
                let reply = command::CrdState {
                    run: sampled.runs.into(),
                    fifo: sampled.fifo,
                    rest: rest(sampled.rest),
                    reason: (sampled.stop as u16).into(),
                    axes: axes.map(|axis| axis.map_or(0, |axis| self.configuration.number_of(axis)).into()),
                    pos: position_of(&sampled.position).map(Into::into),
                    vel: number(sampled.motion.velocity()).into(),
                    segments: both(&|fifo| shadow.segments(sampled, fifo).0),
                    remainder: both(&|fifo| shadow.segments(sampled, fifo).1),
                    space: both(&|fifo| shadow.space(sampled, fifo)),
                };
                out.done::<command::CrdInfo>(tag, &reply, &[])
            }
            opcode::GetRemainderSegNum => self.long(query.opcode, tag, whole(shadow.segments(sampled, fifo).1), out),
            // CrdSpace.
            other => self.long(other, tag, whole(shadow.space(sampled, fifo)), out),
        }
    }

    /// The reply with one whole number.
    pub fn long(&self, opcode: u16, tag: u16, value: i32, out: &mut ReplyWriter) -> Result<(), Full> {
        out.push_raw(opcode, tag, 0, &[command::Long { value: value.into() }.as_bytes()])
    }

    /// The reply to data of a path.
    pub fn path_taken(
        &self,
        opcode: u16,
        tag: u16,
        (crd, fifo): (Crd, u8),
        (count, lasts_ms): (u16, u32),
        out: &mut ReplyWriter,
    ) -> Result<(), Full> {
        let (shadow, sampled) = self.crd(crd);
        let space = (shadow.space(sampled, fifo) as u16).into();
        let reply = command::CrdTaken { taken: count.into(), space, lasts_ms: lasts_ms.into() };
        out.push_raw(opcode, tag, 0, &[reply.as_bytes()])
    }
}

/// As CrdInfo reports it.
fn rest(rest: PathStop) -> u8 {
    match rest {
        PathStop::Never => 0,
        PathStop::Completed => 1,
        PathStop::Underrun => 2,
        PathStop::Stopped => 3,
        PathStop::Obstructed => 4,
    }
}
