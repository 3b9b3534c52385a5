//! What the thread does when it has nothing to do: it sleeps.

/// Waits for something to happen. Any interrupt ends the wait; at the latest the next tick does.
#[derive(Debug, Default)]
pub struct Idle(());

impl Idle {
    /// Nothing has happened yet.
    pub const fn new() -> Self {
        Idle(())
    }

    /// A byte has arrived.
    pub fn wake(&mut self) {}

    /// Sleeps. An interrupt that comes between the caller's last look and the sleep is served, and its news are seen
    /// after the next tick at the latest.
    pub fn wait(&mut self) {
        cortex_m::asm::wfi();
    }
}
