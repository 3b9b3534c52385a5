//! The server: one end of the host link and everything behind it.
use ring::{Consumer, Producer, Reader, Store};
use servo::op::Entry;
use servo::units::Ns;
use servo::view::{Event, Sample, View};

/// Entries of the immediate lane's ring.
pub const IMMEDIATE: usize = 128;
/// Entries of the program lane's ring.
pub const PROGRAM: usize = 256;
/// Events the tick can leave before the thread looks.
pub const EVENTS: usize = 64;
/// Trace samples the tick can leave before the thread looks.
pub const SAMPLES: usize = 1024;
/// Segments of an axis's store.
pub const SEGMENTS: usize = 2048;

/// What a board is: constants that its integrator states.
#[derive(Debug, Clone, Copy)]
pub struct Board {
    /// Name, at most 16 bytes are shown.
    pub name: &'static str,
    /// Number of the profile it shows at power-on (see [`crate::PROFILES`]).
    pub profile: u8,
    /// Tick periods it can run, in µs.
    pub tick_us: core::ops::RangeInclusive<u32>,
    /// Analog outputs (at most 8).
    pub analog_outputs: u8,
    /// Analog inputs (at most 8).
    pub analog_inputs: u8,
    /// General outputs (at most 32).
    pub general_outputs: u8,
}

/// The hand-overs between the thread and the tick: the thread's halves.
pub struct Channels<'a, const AXES: usize> {
    /// Operations for the next tick.
    pub immediate: Producer<'a, Entry, IMMEDIATE>,
    /// Timed operations of a program.
    pub program: Producer<'a, Entry, PROGRAM>,
    /// The newest view.
    pub view: Reader<'a, View<AXES>>,
    /// News.
    pub events: Consumer<'a, Event, EVENTS>,
    /// Trace samples.
    pub samples: Consumer<'a, Sample, SAMPLES>,
    /// PT segments of every axis.
    pub stores: &'a [Store<3, SEGMENTS>; AXES],
}

/// The thread's side of a controller. `AXES` is the capacity of the build.
pub struct Server<'a, const AXES: usize> {
    board: Board,
    channels: Channels<'a, AXES>,
}

impl<'a, const AXES: usize> Server<'a, AXES> {
    /// A server at power-on: no session, every axis in its power-on state.
    pub fn new(board: Board, channels: Channels<'a, AXES>) -> Self {
        Server { board, channels }
    }
    /// Takes bytes from the wire; always takes all of them.
    pub fn feed(&mut self, now: Ns, bytes: &[u8]) {
        let _ = (now, bytes);
    }
    /// Does what can be done now: timers, messages, records, waiting program entries, replies.
    pub fn poll(&mut self, now: Ns) {
        let _ = now;
    }
    /// Bytes for the wire; returns how many were put into `out`.
    pub fn take_tx(&mut self, out: &mut [u8]) -> usize {
        let _ = out;
        0
    }
    /// Bytes of the trace stream; returns how many were put into `out`.
    pub fn take_trace(&mut self, out: &mut [u8]) -> usize {
        let _ = out;
        0
    }
    /// When `poll` wants to be called next, if nothing comes from the wire and no tick happens.
    pub fn next_deadline(&self) -> Option<Ns> {
        None
    }
    /// The newest view, for displays and tests.
    pub fn view(&mut self) -> &View<AXES> {
        self.channels.view.read()
    }
    /// What the board is.
    pub fn board(&self) -> &Board {
        &self.board
    }
}
