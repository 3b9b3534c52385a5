//! A client's link to a virtual controller whose time keeps step with the wall clock, times a
//! factor.
//!
//! In: a board, a factor. Out: a link whose waits are real ones, and a [`Pace`] that reports the
//! controller's due time. Its time passes in two cases: in a wait for a reply, and when the owner
//! lets the client continue to [`Pace::due`]. The owner must do that often enough for the link's
//! keep-alives. That makes nothing late: the controller catches up in its own time, tick by tick.
//!
//! Fails: when this machine is too slow, or the process was delayed, time beyond [`LAG_MAX`] or
//! [`CATCH_UP_MAX`] is dropped. The controller's clock then lags behind the wall clock, and calls
//! are still answered.
use crate::link::{Shared, VirtualLink};
use client::Link;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The most wall-clock time that is caught up.
const LAG_MAX: Duration = Duration::from_millis(100);
/// The most wall-clock time that catching up takes in one go.
const CATCH_UP_MAX: Duration = Duration::from_millis(4);
/// Controller time that is caught up between two looks at the wall clock.
const STRIDE_NS: u64 = 5_000_000;
/// The longest sleep between two looks.
const SLEEP_MAX: Duration = Duration::from_micros(500);

/// How far a board's time may have come.
#[derive(Clone)]
pub struct Pace {
    factor: f64,
    state: Arc<Mutex<(Instant, f64)>>,
}

impl Pace {
    /// `factor` is controller time over wall-clock time; `now` is the board's time.
    fn new(factor: f64, now: u64) -> Self {
        Pace { factor, state: Arc::new(Mutex::new((Instant::now(), now as f64))) }
    }

    /// Controller time in ns that should have passed by now, for a board whose time is `now`.
    pub fn due(&self, now: u64) -> u64 {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let (before, due) = *state;
        let wall = Instant::now();
        let passed = (wall - before).as_nanos() as f64 * self.factor;
        let due = (due + passed).min(now as f64 + LAG_MAX.as_nanos() as f64 * self.factor);
        *state = (wall, due);
        due as u64
    }

    /// Lets a board catch up with `run`, which advances it by ns; `now` returns its time.
    pub fn catch_up(&self, mut now: impl FnMut() -> u64, mut run: impl FnMut(u64)) {
        let began = Instant::now();
        loop {
            let at = now();
            let behind = self.due(at).saturating_sub(at);
            if behind == 0 {
                return;
            }
            if began.elapsed() > CATCH_UP_MAX {
                let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
                state.1 = state.1.min(at as f64);
                return;
            }
            run(behind.min(STRIDE_NS));
        }
    }

    /// The wall-clock time in which so many ns of controller time pass.
    pub fn wall(&self, ns: u64) -> Duration {
        Duration::from_nanos((ns as f64 / self.factor) as u64)
    }
}

/// See the module text.
pub struct PacedLink {
    inner: VirtualLink,
    board: Shared,
    pace: Pace,
}

impl PacedLink {
    /// A link to this board; the pace is for its owner.
    pub fn new(board: Shared, factor: f64) -> (Self, Pace) {
        let now = board.lock().unwrap_or_else(PoisonError::into_inner).now();
        let pace = Pace::new(factor, now);
        (PacedLink { inner: VirtualLink::new(board.clone()), board, pace: pace.clone() }, pace)
    }
}

impl Link for PacedLink {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        // Bytes sent now act now, not at the tick of the last receive.
        let PacedLink { inner, board, pace } = self;
        let now = || board.lock().unwrap_or_else(PoisonError::into_inner).now();
        pace.catch_up(now, |ns| inner.run(Duration::from_nanos(ns)));
        self.inner.send(bytes)
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        let end = self.now().saturating_add(u64::try_from(wait.as_nanos()).unwrap_or(u64::MAX));
        loop {
            let now = self.now();
            let allowed = self.pace.due(now).min(end);
            let n = self.inner.receive(buf, Duration::from_nanos(allowed.saturating_sub(now)))?;
            if n > 0 || self.now() >= end {
                return Ok(n);
            }
            let period = self.board.lock().unwrap_or_else(PoisonError::into_inner).period_ns();
            std::thread::sleep(self.pace.wall(period).min(SLEEP_MAX));
        }
    }

    fn now(&mut self) -> u64 {
        self.inner.now()
    }

    fn real_time(&self) -> bool {
        false
    }

    fn has_trace(&self) -> bool {
        self.inner.has_trace()
    }

    fn take_trace(&mut self, out: &mut Vec<u8>) -> client::Result<()> {
        self.inner.take_trace(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Board, Config, share};
    use client::{Client, Options};
    use protocol::command::{AxisOn, GetClock};

    #[test]
    fn a_wait_of_the_controller_takes_its_share_of_the_wall_clock() {
        let (link, _) = PacedLink::new(share(Board::new(Config::default())), 20.0);
        let client = Client::open(Box::new(link), Options::default()).unwrap();
        let began = Instant::now();
        let (clock, woken) = (client.call(GetClock {}).unwrap().clock_ms.get(), client.now());
        client.sleep(Duration::from_secs(2)).unwrap();
        // Whatever this machine does besides: the wait ends when it shall, and controller time is
        // never ahead of the wall clock.
        let slept = client.now() - woken;
        assert!(
            (Duration::from_secs(2)..=Duration::from_millis(2001)).contains(&slept),
            "{slept:?} of controller time"
        );
        let clock = client.call(GetClock {}).unwrap().clock_ms.get() - clock;
        let wall = began.elapsed();
        assert!(clock >= 1999, "{clock} ms of controller time");
        assert!(f64::from(clock) <= wall.as_secs_f64() * 20e3 + 1.0, "{clock} ms of controller time in {wall:?}");
        assert!(wall >= Duration::from_millis(99), "2 s at 20 times the speed take 100 ms: {wall:?}");
    }

    #[test]
    fn time_that_nobody_looked_at_is_caught_up_to_the_lag() {
        let (link, pace) = PacedLink::new(share(Board::new(Config::default())), 1.0);
        let client = Client::open(Box::new(link), Options::default()).unwrap();
        let now = |client: &Client| client.now().as_nanos() as u64;
        let before = now(&client);
        std::thread::sleep(Duration::from_millis(300));
        let behind = pace.due(now(&client)) - before;
        assert!((99_000_000..=101_000_000).contains(&behind), "{behind} ns");
        // The call is executed at the time that the wall clock shows.
        client.call(AxisOn { core: 1.into(), axis: 1.into() }).unwrap();
        assert!(now(&client) >= before + 99_000_000);
    }
}
