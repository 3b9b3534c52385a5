//! FIFOs with data that the tick does not know of yet: the commits of one instant.
//!
//! In: FIFOs that were given data. Out: one commit for each. Owns their masks.
use servo::units::{Axis, AxisMask, Crd, CrdMask};

/// See the module text.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Gathered {
    /// Axes with such data in FIFO 0, FIFO 1.
    axes: [AxisMask; 2],
    /// Coordinate systems, the same.
    crds: [CrdMask; 2],
}

impl Gathered {
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

    /// A FIFO of an axis has got data.
    pub fn add_axis(&mut self, axis: Axis, fifo: u8) {
        self.axes[usize::from(fifo & 1)].0 |= axis.mask().0;
    }

    /// A FIFO of a coordinate system has got data.
    pub fn add_crd(&mut self, crd: Crd, fifo: u8) {
        self.crds[usize::from(fifo & 1)].0 |= crd.mask().0;
    }

    /// FIFOs of axes, in the order of their commits; those of coordinate systems follow.
    pub fn axes(&self) -> impl Iterator<Item = (Axis, u8)> {
        (0..).zip(self.axes).flat_map(|(fifo, axes)| axes.axes().map(move |axis| (axis, fifo)))
    }

    /// FIFOs of coordinate systems, in the order of their commits.
    pub fn crds(&self) -> impl Iterator<Item = (Crd, u8)> {
        (0..).zip(self.crds).flat_map(|(fifo, crds)| crds.crds().map(move |crd| (crd, fifo)))
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
