//! FIFOs with data that the tick does not know of yet: the commits of one instant.
//!
//! In: FIFOs that were given data. Out: one commit for each. Owns their masks.
use crate::refuse::FifoOf;
use servo::units::{Axis, AxisMask, CrdMask};

/// See the module text.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PendingCommits {
    /// Axes with such data in FIFO 0, FIFO 1.
    axes: [AxisMask; 2],
    /// Coordinate systems, the same.
    crds: [CrdMask; 2],
}

impl PendingCommits {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        let ([first, second], [third, fourth]) = (self.axes, self.crds);
        first.0 | second.0 == 0 && third.0 | fourth.0 == 0
    }

    /// How many commits that makes.
    pub fn count(&self) -> usize {
        let axes = self.axes.iter().map(|axes| axes.0.count_ones());
        axes.chain(self.crds.iter().map(|crds| crds.0.count_ones())).sum::<u32>() as usize
    }

    /// A FIFO has got data.
    pub fn add(&mut self, of: FifoOf, fifo: u8) {
        let index = usize::from(fifo & 1);
        match of {
            FifoOf::Axis(axis) => self.axes[index].0 |= axis.mask().0,
            FifoOf::Crd(crd) => self.crds[index].0 |= crd.mask().0,
        }
    }

    /// The FIFOs in the order of their commits: those of axes, then those of coordinate systems.
    pub fn fifos(&self) -> impl Iterator<Item = (FifoOf, u8)> {
        let axes = (0..).zip(self.axes).flat_map(|(fifo, of)| of.axes().map(move |of| (FifoOf::Axis(of), fifo)));
        axes.chain((0..).zip(self.crds).flat_map(|(fifo, of)| of.crds().map(move |of| (FifoOf::Crd(of), fifo))))
    }

    /// How many commits precede that of this FIFO of an axis.
    pub fn before(&self, axis: Axis, fifo: u8) -> u32 {
        let [first, second] = self.axes;
        let below = axis.mask().0 - 1;
        if fifo & 1 == 0 {
            (first.0 & below).count_ones()
        } else {
            first.0.count_ones() + (second.0 & below).count_ones()
        }
    }
}
