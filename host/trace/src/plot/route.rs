//! The path of two axes, with the light on it.
//!
//! In: points in the order of time, and whether light is on from each of them on. Out: the same,
//! without details too small to see. Owns at most [`MAX_NODES`] nodes. Beyond that, points closer
//! together than a fraction of the extent become one, and a mark shorter than that is lost. Fails
//! never.
use crate::row::PowerUnit;

/// Most nodes.
const MAX_NODES: usize = 1 << 17;
/// Nodes closer together than this share of the extent may become one.
const NODE_GAP_SHARE: f64 = 1.0 / 8192.0;

/// Light, and how much.
pub(super) type Power = (PowerUnit, f64);

/// A point that was passed, or of a standstill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node<L> {
    pub x: f64,
    pub y: f64,
    /// It is reached at this time, ns.
    pub from: u64,
    /// It is left at this time.
    pub until: u64,
    /// Light from here to the next one.
    pub light: Option<L>,
}

/// See the module text.
#[derive(Debug, Clone)]
pub(super) struct Route<L> {
    nodes: Vec<Node<L>>,
    /// Points closer together than this (pulses, in x and in y) are one.
    apart: f64,
}

impl<L> Default for Route<L> {
    fn default() -> Self {
        Route { nodes: Vec::new(), apart: 0.0 }
    }
}

impl<L: Copy> Route<L> {
    /// At `t` it was here, and from here on there is this light.
    pub fn push(&mut self, t: u64, (x, y): (f64, f64), light: Option<L>) {
        add(&mut self.nodes, self.apart, Node { x, y, from: t, until: t, light }, false);
        if self.nodes.len() == MAX_NODES {
            self.thin();
        }
    }

    /// Half of the nodes at most are left.
    fn thin(&mut self) {
        let Some(((left, right), (low, high))) = self.extent() else { return };
        let least = (right - left).max(high - low) * NODE_GAP_SHARE;
        while self.nodes.len() > MAX_NODES / 2 {
            self.apart = (self.apart * 2.0).max(least);
            for node in std::mem::take(&mut self.nodes) {
                add(&mut self.nodes, self.apart, node, true);
            }
        }
    }

    /// The path.
    pub fn nodes(&self) -> &[Node<L>] {
        &self.nodes
    }

    /// Least and greatest x, least and greatest y.
    pub fn extent(&self) -> Option<((f64, f64), (f64, f64))> {
        self.nodes
            .iter()
            .map(|n| ((n.x, n.x), (n.y, n.y)))
            .reduce(|(x, y), (u, v)| ((x.0.min(u.0), x.1.max(u.1)), (y.0.min(v.0), y.1.max(v.1))))
    }
}

/// Adds a node, or extends the time of the last one. A change of light keeps a node of its own,
/// unless `coarse`.
fn add<L>(nodes: &mut Vec<Node<L>>, apart: f64, node: Node<L>, coarse: bool) {
    if let Some(last) = nodes.last_mut()
        && (node.x - last.x).abs().max((node.y - last.y).abs()) <= apart
        && (coarse || last.light.is_some() == node.light.is_some() || last.from == node.from)
    {
        last.until = node.until;
        last.light = node.light;
        return;
    }
    nodes.push(node);
}
