//! Reads of axes that follow.
use super::Reading;
use crate::report::answer::{Query, Sent};
use protocol::command::{self, opcode};
use protocol::record::ReplyWriter;
use servo::units::Axis;
use zerocopy::IntoBytes;

/// What GetFollowMaster reports before SetFollowMaster: no axis, and the default type and item
/// (PROFILE, 0).
const NO_MASTER: [i16; 3] = [0, 2, 0];

impl<const AXES: usize> Reading<'_, AXES> {
    /// Reads of an axis that follows.
    pub(super) fn follow(&self, tag: u16, query: &Query, out: &mut ReplyWriter) -> Sent {
        let axis = Axis::new(usize::from(query.first)).unwrap_or_default();
        let sampled = &self.view.axes[axis.index().min(AXES - 1)];
        let follow = &self.executed.axis(axis).follow;
        let mut say = |reply: &[u8]| out.push_raw(query.opcode, tag, 0, &[reply]);
        match query.opcode {
            opcode::GetFollowMaster | opcode::GetFollowMasterEx | opcode::GetGearMaster => {
                let [index, kind, item] = follow.master.map_or(NO_MASTER, |(_, given)| given);
                let (master_index, master_type, master_item) = (index.into(), kind.into(), item.into());
                say(command::FollowMasterReply { master_index, master_type, master_item }.as_bytes())
            }
            opcode::GetFollowLoop | opcode::GetFollowLoopEx => {
                let done = i32::try_from(sampled.passes).unwrap_or(i32::MAX);
                say(command::Long { value: done.into() }.as_bytes())
            }
            opcode::GetFollowEvent | opcode::GetFollowEventEx => {
                let (event, dir, pos) = follow.event;
                let (event, master_dir, pos) = (event.into(), dir.into(), pos.into());
                say(command::FollowEventReply { event, master_dir, pos }.as_bytes())
            }
            opcode::GetGearRatio => {
                let [master_even, slave_even, master_slope] = follow.ratio.unwrap_or_default().map(Into::into);
                say(command::GearRatioReply { master_even, slave_even, master_slope }.as_bytes())
            }
            opcode::GetGearEvent => {
                let (event, dir, pos) = follow.event;
                let (event, start_para0, start_para1) = (event.into(), i32::from(dir).into(), pos.into());
                say(command::GearEventReply { event, start_para0, start_para1 }.as_bytes())
            }
            opcode::GetFollowMemory | opcode::GetFollowMemoryEx => {
                say(command::Short { value: i16::from(follow.memory).into() }.as_bytes())
            }
            opcode::GetFollowStatus | opcode::GetFollowStatusEx => {
                let (fifo, switching) = (i16::from(sampled.fifo).into(), i16::from(sampled.switching));
                say(command::FollowStatusReply { fifo, switch_status: switching.into() }.as_bytes())
            }
            _ => say(&[]),
        }
    }

    /// The free slots after an entry of Follow.
    pub fn entered(&self, axis: Axis, fifo: u8) -> command::FollowTaken {
        command::FollowTaken { space: (self.executed.axis(axis).follow.space(fifo) as u16).into() }
    }
}
