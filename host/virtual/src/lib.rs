#![forbid(unsafe_code)]
//! The virtual controller: the same dispatcher and servo as the firmware, on this machine.
//!
//! In: bytes of the host link, input levels that a test sets. Out: bytes of the host link and of
//! the trace stream, output edges, edges of the lasers. Owns its time: [`Board::advance`] runs
//! ticks, and nothing else moves the clock, so the same calls give the same bytes. Encoders are
//! those of `plant`.
//!
//! * [`Board`]: the controller in virtual time; [`Controller`] on [`Memory`] is one that can end.
//! * [`VirtualLink`]: a client's link to it; time passes only while the client waits.
//! * [`PacedLink`]: the same in step with the wall clock.
//! * [`serve`]: the controller in real time over TCP.
mod board;
mod link;
mod machine;
mod paced;
mod serve;

pub use board::{Board, Config, Controller, Memory, TICKS_US};
pub use link::{Shared, VirtualLink, share};
pub use machine::{Beam, Edge, Inputs, Output, Outputs};
pub use paced::{Pace, PacedLink};
pub use serve::{Served, serve, serve_board};

#[cfg(test)]
mod tests {
    #[test]
    fn client_and_dispatcher_have_the_same_profiles() {
        assert_eq!(client::ProductProfile::ALL.len(), dispatcher::PROFILES.len());
        for ((profile, name), row) in client::ProductProfile::ALL.iter().zip(dispatcher::PROFILES) {
            assert_eq!((*name, profile.counts()), (row.name, (row.cores, row.axes_per_core)));
        }
    }
}
