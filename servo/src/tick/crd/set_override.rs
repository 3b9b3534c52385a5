//! The feed override of a coordinate system (`SetOverride`).
//!
//! In: an admitted factor. Out: the motion in force, planned anew from the coming tick on. Owns
//! nothing. Cannot fail. How the factor acts on speeds: `path/evaluator/feed_override.rs`.
use crate::path::FeedOverride;
use crate::tick::Tick;
use crate::tick::hand_overs::HandOvers;
use crate::units::{Crd, Ns};

impl<const AXES: usize> Tick<AXES> {
    /// Override.
    pub(crate) fn set_override(&mut self, crd: Crd, rate: FeedOverride, next: Ns, hand_overs: &mut HandOvers<AXES>) {
        self.with_path(crd, next, hand_overs, |path, _, feed, source, _| {
            path.rules.set_override(rate);
            path.replan(next, feed, source);
        });
        self.crds.get_mut(crd);
    }
}
