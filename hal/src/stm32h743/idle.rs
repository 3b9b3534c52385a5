//! The idle loop of the thread: it sleeps.
//!
//! In: nothing. Out: the thread's wait. Owns nothing. Fails never.

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

    /// Sleeps. An interrupt that comes between the caller's last check and the sleep is served;
    /// the caller finds what it brought after the next tick at the latest.
    pub fn wait(&mut self) {
        cortex_m::asm::wfi();
    }
}
