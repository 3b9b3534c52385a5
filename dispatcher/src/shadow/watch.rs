//! What stops motion when the link is lost or the interlock opens, in the user's terms.
use servo::op::{Brake, Supervision};

/// What binds safety to a user: it lasts for the session and falls back on Reset (SPEC 9).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Watch {
    /// Link-loss time, ms; 0: the link is not supervised.
    pub link_loss_ms: u32,
    /// Where the link is lost PT, PVT and Follow stop, too.
    pub stop_all: bool,
    /// What motion does where the interlock opens: 0 goes on, 1 as where the link is lost, 2 stops abruptly.
    pub interlock: u8,
}

impl Watch {
    /// At power-on, after a Reset, and for a new session.
    pub const DEFAULT: Watch = Watch { link_loss_ms: 500, stop_all: false, interlock: 1 };

    /// The same for the tick.
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
