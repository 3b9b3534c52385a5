//! What programs have tried, so that a generator cannot rot unseen.
use super::super::axis::{Axis, Mode, Motion};
use super::Controller;

impl Controller {
    /// What the programs tried.
    pub(super) fn count(&mut self, axis: &Axis, was_slave: bool) {
        let moves = axis.track.iter().any(|at| *at != axis.track[0]);
        let Some(master) = axis.follow.master.filter(|_| was_slave && moves) else { return };
        let (by_encoder, filtered) = (master.is_counted(), master.is_filtered());
        let master = &self.axes[master.axis];
        let mut used = |what| *self.used.entry(what).or_default() += 1;
        used("ticks in which a slave moves");
        if by_encoder {
            used("ticks in which a slave of an encoder moves");
        }
        if filtered {
            used("ticks in which a slave of a filtered master moves");
        }
        if axis.mode == Mode::FollowEx {
            used("ticks in which a slave of FollowEx moves");
        }
        if matches!(master.motion, Some(Motion::Slave(_))) {
            used("ticks in which a slave of a slave moves");
            if master.renamed {
                used("ticks in which a slave of a slave moves that was renamed");
            }
        }
        if axis.follow.dir < 0 {
            used("ticks in which a slave of direction -1 moves");
        }
    }
}
