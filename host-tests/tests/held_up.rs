//! A client whose machine is busy with other things: that nothing comes counts only while it
//! listens.
use client::{Client, Link, Options, error};
use protocol::command::GetPrfPos;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Duration;
use virtual_board::{Board, Config, VirtualLink, share};

/// How long the machine does not run the client at a time.
const AWAY: Duration = Duration::from_secs(5);

/// What the machine does to the client.
#[derive(Default)]
struct Machine {
    /// Looks at the link until it next holds the client up, and how often it does.
    looks: AtomicU64,
    times: AtomicU64,
    /// Nothing passes either way.
    cut: AtomicBool,
}

/// A link whose client is away now and then, and finds nothing when it comes back: board and client
/// run on that machine.
struct Busy {
    link: VirtualLink,
    machine: Arc<Machine>,
    away: u64,
}

impl Link for Busy {
    fn name(&self) -> &str {
        "busy"
    }

    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        if self.machine.cut.load(Relaxed) { Ok(()) } else { self.link.send(bytes) }
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        let Machine { looks, times, .. } = &*self.machine;
        if times.load(Relaxed) > 0 && looks.fetch_sub(1, Relaxed) == 1 {
            times.fetch_sub(1, Relaxed);
            looks.store(2, Relaxed);
            self.away += AWAY.as_nanos() as u64;
            return Ok(0);
        }
        if self.machine.cut.load(Relaxed) {
            self.link.run(wait);
            return Ok(0);
        }
        self.link.receive(buf, wait)
    }

    fn now(&mut self) -> u64 {
        self.link.now() + self.away
    }

    fn real_time(&self) -> bool {
        false
    }
}

fn busy(looks: u64, times: u64) -> (Busy, Arc<Machine>) {
    let machine = Arc::new(Machine { looks: looks.into(), times: times.into(), cut: false.into() });
    let link = VirtualLink::new(share(Board::new(Config::default())));
    (Busy { link, machine: machine.clone(), away: 0 }, machine)
}

#[test]
fn a_client_that_was_held_up_does_not_give_up() {
    for looks in 1..4 {
        // While it opens, too.
        let (link, machine) = busy(looks, 2);
        let client = Client::open(Box::new(link), Options::default()).unwrap();
        assert!(machine.times.load(Relaxed) < 2);
        for looks in 1..8 {
            machine.looks.store(looks, Relaxed);
            machine.times.store(2, Relaxed);
            while machine.times.load(Relaxed) > 0 {
                client.call(GetPrfPos { core: 1.into(), profile: 1.into(), count: 1.into() }).unwrap();
            }
        }
        assert!((AWAY..AWAY * 2).contains(&client.held_up()), "{:?}", client.held_up());
    }
}

#[test]
fn a_controller_that_is_gone_is_missed_in_time() {
    let (link, machine) = busy(1, 0);
    let client = Client::open(Box::new(link), Options::default()).unwrap();
    machine.cut.store(true, Relaxed);
    let began = client.now();
    let e = client.call(GetPrfPos { core: 1.into(), profile: 1.into(), count: 1.into() }).unwrap_err();
    assert_eq!(e.code, error::NO_ANSWER, "{e}");
    let waited = client.now() - began;
    assert!((Duration::from_secs(2)..Duration::from_millis(2100)).contains(&waited), "{waited:?}");
    // Times away are no patience.
    let (link, machine) = busy(1, 20);
    machine.cut.store(true, Relaxed);
    let Err(e) = Client::open(Box::new(link), Options::default()) else { panic!("nobody is there") };
    assert_eq!((e.code, machine.times.load(Relaxed)), (error::NO_ANSWER, 0), "{e}");
}
