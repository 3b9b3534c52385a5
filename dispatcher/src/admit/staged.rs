//! Operations of a command that is being admitted.
use crate::shadow::Change;
use servo::op::Op;

/// Most operations that one command, or one item of LoadConfig, becomes: Reset with both lasers.
pub const STAGED: usize = 12;
/// The same for every command but Reset: LmtSns over 8 axes and SetDac of 8 outputs are the
/// largest.
pub const FEW: usize = 8;

/// Operations of one admitted command, not yet pushed: a command that is refused half-way has
/// changed nothing.
#[derive(Debug)]
pub struct Staged {
    ops: [(Op, Change); STAGED],
    len: usize,
}

impl Staged {
    /// Nothing staged.
    pub fn new() -> Self {
        Staged { ops: [(Op::Mark, Change::None); STAGED], len: 0 }
    }
    /// Forgets what is staged.
    pub fn clear(&mut self) {
        self.len = 0;
    }
    /// Adds an operation.
    pub fn add(&mut self, op: Op, change: Change) {
        debug_assert!(self.len < STAGED, "a command of more than {STAGED} operations");
        if let Some(slot) = self.ops.get_mut(self.len) {
            *slot = (op, change);
            self.len += 1;
        }
    }
    /// What is staged, in order.
    pub fn ops(&self) -> &[(Op, Change)] {
        self.ops.get(..self.len).unwrap_or(&[])
    }
}
