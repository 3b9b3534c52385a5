//! What stops motion when the link is lost or the interlock opens, in the user's terms.
use servo::tick_command::{Brake, Supervision};

/// Reactions to a lost link and an open interlock. They last for the session; a Reset sets the
/// default (SPEC 9).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Watch {
    /// Link-loss time, ms; 0: the link is not supervised.
    pub link_loss_ms: u32,
    /// PT, PVT and Follow stop, too, when the link is lost.
    pub stop_all: bool,
    /// Motion when the interlock opens: 0 goes on, 1 as when the link is lost, 2 stops abruptly.
    pub interlock: u8,
}

impl Watch {
    /// At power-on, after a Reset, and for a new session.
    pub const DEFAULT: Watch = Watch { link_loss_ms: 500, stop_all: false, interlock: 1 };

    /// The same in the tick's terms.
    pub fn supervision(self) -> Supervision {
        let link = if self.stop_all { Brake::All } else { Brake::JogAndPaths };
        let interlock = match self.interlock {
            0 => Brake::None,
            1 => link,
            _ => Brake::AbruptAll,
        };
        Supervision { link, interlock }
    }
}
