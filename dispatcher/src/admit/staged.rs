//! Tick commands of a command that is being admitted.
use crate::shadow::ShadowChange;
use heapless::Vec;
use servo::tick_command::TickCommand;

/// Most tick commands that one command, or one item of LoadConfig, becomes: Reset with both lasers.
pub const STAGED_MAX: usize = 12;
/// The same for every command but Reset: LmtSns over 8 axes and SetDac of 8 outputs are the
/// largest.
pub const STAGED_MAX_BUT_RESET: usize = 8;

/// Tick commands of one admitted command, not yet pushed: a command that is refused half-way has
/// changed nothing.
#[derive(Debug, Default)]
pub struct Staged(Vec<(TickCommand, ShadowChange), STAGED_MAX>);

impl Staged {
    /// Forgets what is staged.
    pub fn clear(&mut self) {
        self.0.clear();
    }
    /// Adds a tick command.
    pub fn add(&mut self, command: TickCommand, change: ShadowChange) {
        let fits = self.0.push((command, change)).is_ok();
        debug_assert!(fits, "a command of more than {STAGED_MAX} tick commands");
    }
    /// What is staged, in order.
    pub fn commands(&self) -> &[(TickCommand, ShadowChange)] {
        &self.0
    }
}
