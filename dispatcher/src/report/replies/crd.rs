//! Reads of coordinate systems.
use super::{Reading, fixed, number};
use crate::plan::geometry::position_of;
use crate::report::answer::{Query, Sent};
use crate::shadow::{CAPACITY, CrdShadow};
use protocol::command;
use protocol::record::ReplyWriter;
use servo::path::DIMENSIONS;
use servo::units::Crd;
use servo::view::CrdView;

fn whole(count: u32) -> i32 {
    i32::try_from(count).unwrap_or(i32::MAX)
}

impl<const AXES: usize> Reading<'_, AXES> {
    fn crd(&self, crd: Crd) -> (&CrdShadow, &CrdView) {
        let [first, ..] = &self.view.crds;
        (self.executed.crd(crd), self.view.crds.get(crd.index()).unwrap_or(first))
    }

    /// How long the motions that a FIFO holds last, ms.
    fn lasts_ms(&self, crd: Crd, fifo: u8) -> u32 {
        let (shadow, sampled) = self.crd(crd);
        let (stores, queues) = self.paths;
        let Some((stores, queues)) = stores.get(crd.index()).zip(queues.get(crd.index())) else { return 0 };
        // What was cleared may still be known to the look-ahead.
        if shadow.space(sampled, fifo) == CAPACITY {
            return 0;
        }
        queues[usize::from(fifo != 0)].remaining(stores, sampled, fifo) as u32
    }

    /// A read of the coordinate system `first`; `which` is the FIFO, or the coordinate.
    pub(super) fn crd_reply(&self, tag: u16, query: &Query, out: &mut ReplyWriter) -> Sent {
        let crd = Crd::new(usize::from(query.first)).unwrap_or_default();
        let (shadow, sampled) = self.crd(crd);
        let fifo = query.which;
        let real = |value: f64| command::Real { value: value.into() };
        let long = |count: u32| command::Long { value: whole(count).into() };
        let both = |of: &dyn Fn(u8) -> u32| [0, 1].map(|fifo| whole(of(fifo)).into());
        fixed! { (query, tag, out)
            GetCrdPrm => shadow.frame.map_or_else(Default::default, |frame| frame.wire());
            CrdStatus => command::CrdStatusReply {
                run: i16::from(sampled.runs).into(),
                segment: whole(shadow.segments(sampled, fifo).0).into(),
            };
            GetCrdVel => real(number(sampled.motion.velocity()));
            GetLaserFollowFilter => real(shadow.lag_ms);
            GetCrdLimit => {
                let (vel, acc) = shadow.limits.get(usize::from(fifo)).copied().unwrap_or_default();
                command::CrdLimit { vel_max: vel.into(), acc_max: acc.into() }
            };
            CrdInfo => command::CrdState {
                run: sampled.runs.into(),
                fifo: sampled.fifo,
                path_stop: sampled.path_stop as u8,
                reason: (sampled.stop as u16).into(),
                axes: shadow.frame.map_or([None; DIMENSIONS], |frame| frame.axes())
                    .map(|axis| axis.map_or(0, |axis| self.configuration.number_of(axis)).into()),
                pos: position_of(&sampled.position).map(Into::into),
                vel: number(sampled.motion.velocity()).into(),
                segments: both(&|fifo| shadow.segments(sampled, fifo).0),
                remainder: both(&|fifo| shadow.segments(sampled, fifo).1),
                space: both(&|fifo| shadow.space(sampled, fifo)),
                lasts_ms: [0, 1].map(|fifo| self.lasts_ms(crd, fifo).into()),
            };
            GetRemainderSegNum => long(shadow.segments(sampled, fifo).1);
            CrdSpace => long(shadow.space(sampled, fifo));
            _ => {
                let count = shadow.frame.map_or(0, |frame| usize::from(frame.dimension)).min(DIMENSIONS);
                let items = position_of(&sampled.position).map(real);
                let head = command::Count { count: (count as u16).into() };
                out.done::<command::GetCrdPos>(tag, &head, items.get(..count).unwrap_or(&[]))
            }
        }
    }

    /// The reply to data of a path.
    pub fn path_taken(&self, (crd, fifo): (Crd, u8), count: u16, lasts_ms: u32) -> command::CrdTaken {
        let (shadow, sampled) = self.crd(crd);
        let space = (shadow.space(sampled, fifo) as u16).into();
        command::CrdTaken { taken: count.into(), space, lasts_ms: lasts_ms.into() }
    }
}
