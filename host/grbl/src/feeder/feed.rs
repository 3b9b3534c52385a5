//! The sender's side of the feeder: queues entries, holds and stops the path, reads the view.
//!
//! In: entries, holds, resets. Out: the newest [`View`]. Owns the feeder's thread and ends it.
//! Fails: with the link's error.
use super::{CORE, Fault, Feeder, Gate, Inbox, Light, Pace, Shared, View, locked};
use crate::entry::{Entry, Kind};
use client::{Client, Error};
use protocol::command::{Abort, ClrLaserFault, ClrSts, CrdStop};
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

/// The sender's side of the feeder.
pub struct Feed {
    client: Arc<Client>,
    shared: Arc<Shared>,
    thread: Option<std::thread::JoinHandle<()>>,
    /// Entries and motions that were queued.
    queued: (u64, u64),
    laser: Option<u8>,
    released: u64,
}

impl Feed {
    /// Feeds the controller of this client, which is set up and stands. `axes` are the numbers of
    /// X, Y and Z.
    pub fn new(client: Arc<Client>, axes: &[u8], laser: Option<u8>, pace: Pace) -> Result<Feed, Error> {
        let shared = Arc::new(Shared {
            inbox: Mutex::new(Inbox { feed: 100, ..Inbox::default() }),
            wake: Condvar::new(),
            gate: Mutex::new(Gate::default()),
            view: Mutex::new(View::default()),
            fresh: Condvar::new(),
        });
        let mut feeder = Feeder {
            client: Arc::clone(&client),
            shared: Arc::clone(&shared),
            pace,
            axes: axes.iter().map(|axis| i16::from(*axis)).collect(),
            laser: laser.map(i16::from),
            room: 0,
            sent: VecDeque::new(),
            motions: 0,
            light: Light::default(),
            started: false,
            fast: 0,
            feed: 1.0,
            lasted: (Duration::ZERO, 0),
            slow: None,
            known_limits: [0; 3],
            dark: 0,
            view: View::default(),
        };
        feeder.begin()?;
        feeder.cycle()?;
        let thread = std::thread::spawn(move || feeder.run());
        Ok(Feed { client, shared, thread: Some(thread), queued: (0, 0), laser, released: 0 })
    }

    /// Queues entries for the path.
    pub fn queue(&mut self, entries: Vec<Entry>) {
        if entries.is_empty() {
            return;
        }
        self.queued.0 += entries.len() as u64;
        self.queued.1 += entries.iter().filter(|entry| entry.kind == Kind::Motion).count() as u64;
        let mut inbox = locked(&self.shared.inbox);
        inbox.entries.extend(entries);
        inbox.newest = Some(Instant::now());
        inbox.queued = self.queued;
        self.shared.wake.notify_one();
    }

    /// Entries and motions that are not over.
    pub fn waiting(&self, view: &View) -> (u64, u64) {
        (self.queued.0.saturating_sub(view.done.0), self.queued.1.saturating_sub(view.done.1))
    }

    /// Entries that have not reached the controller.
    pub fn unknown(&self, view: &View) -> u64 {
        self.queued.0.saturating_sub(view.entered)
    }

    /// Whether nothing moves, and nothing waits to.
    pub fn idle(&self) -> bool {
        self.is_idle(&self.view())
    }

    /// As [`Self::idle`], at the time of a view.
    pub fn is_idle(&self, view: &View) -> bool {
        !view.runs && !view.goes_on && self.waiting(view).0 == 0
    }

    /// What the machine does.
    pub fn view(&self) -> View {
        let mut view = locked(&self.shared.view).clone();
        // What was wrong before the last release was reported, and is over.
        if view.released != self.released {
            view.fault = None;
        }
        view
    }

    /// Waits for news of the machine, at most so long.
    pub fn wait_for_change(&self, wait: Duration) {
        let view = locked(&self.shared.view);
        drop(self.shared.fresh.wait_timeout(view, wait));
    }

    /// The path starts without waiting for more lines, or waits again.
    pub fn hurry(&self, on: bool) {
        let mut inbox = locked(&self.shared.inbox);
        if inbox.hurry != on {
            inbox.hurry = on;
            self.shared.wake.notify_one();
        }
    }

    /// F is run at so much, %, from now on.
    pub fn feed(&self, percent: u8) {
        locked(&self.shared.inbox).feed = percent;
        self.shared.wake.notify_one();
    }

    /// The path comes to rest on itself, dark, and may go on.
    pub fn hold(&self) -> Result<(), Error> {
        let mut gate = locked(&self.shared.gate);
        gate.held = true;
        if gate.halts {
            return Ok(());
        }
        gate.asked = true;
        let stop = CrdStop { core: CORE.into(), mask: 1.into(), option: 0.into() };
        let stopped = self.client.call(stop).map(drop);
        // One that failed has stopped nothing: the next hold sends another.
        gate.halts = stopped.is_ok();
        stopped
    }

    /// The path goes on, once it stands.
    pub fn go_on(&self) {
        locked(&self.shared.gate).held = false;
        self.shared.wake.notify_one();
    }

    /// Every laser is dark at once, and everything comes to rest. Nothing starts before
    /// [`Self::release`].
    pub fn abort(&self) -> Result<(), Error> {
        let mut gate = locked(&self.shared.gate);
        (gate.stopped, gate.held) = (true, false);
        self.client.call(Abort { core: CORE.into() }).map(drop)
    }

    /// Throws away what waits, once the path stands; [`View::emptied`] counts it.
    pub fn empty(&mut self) {
        let mut inbox = locked(&self.shared.inbox);
        inbox.entries.clear();
        inbox.empty = true;
        inbox.hurry = false;
        self.shared.wake.notify_one();
    }

    /// Lines may come again.
    pub fn release(&mut self) {
        self.released += 1;
        locked(&self.shared.inbox).released = self.released;
        let mut gate = locked(&self.shared.gate);
        *gate = Gate::default();
        self.shared.wake.notify_one();
    }

    /// Clears what latched; a fault that is still there is returned.
    pub fn clear_faults(&self) -> Result<Option<Fault>, Error> {
        let clear = ClrSts { core: CORE.into(), axis: 1.into(), count: 8.into() };
        let _ = self.client.call(clear);
        if let Some(channel) = self.laser {
            let clear = ClrLaserFault { core: CORE.into(), channel: i16::from(channel).into() };
            if let Err(error) = self.client.call(clear) {
                return if error.code > 0 {
                    Ok(Some(Fault { limit: false, reason: error.reason }))
                } else {
                    Err(error)
                };
            }
        }
        Ok(None)
    }

    /// Makes a call of the sender's side.
    pub fn client(&self) -> &Client {
        &self.client
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        locked(&self.shared.inbox).ends = true;
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
