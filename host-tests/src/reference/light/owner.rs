//! Whose light it is, and what takes it away: SPEC 6, "Whose light it is" and "Rest", and SPEC 9.
//!
//! In: what happens to a channel, in the order of time. Out: the order to the gate.

/// Who lit it. Coordinate systems are those of core 1, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Who {
    Call,
    Path(usize),
}

/// A coordinate system and one of its FIFOs.
pub type Run = (usize, usize);

/// How a path ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// By a Stop, within its FIFO.
    Stopped,
    /// Its entries have run out; whether it braked for a Stop.
    Done { braked: bool },
}

/// The order to the gate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    Nothing,
    /// An on or off command, with its delay.
    Gate(bool),
    /// Dark at once.
    Cut,
}

#[derive(Debug, Clone, PartialEq)]
enum Light {
    Off,
    On(Who),
    /// Stops of these keep it dark.
    Held(Who, Vec<Run>),
    /// The power follows the speed of a coordinate system at rest.
    Waits(Who),
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Owner {
    light: Light,
    /// An off by a call, and no on command since.
    off: bool,
    /// Coordinate systems that may light it, that run, and whose on entries an Abort has killed;
    /// bit 0 is crd 1.
    pub map: u8,
    running: u8,
    dead: u8,
    /// The coordinate system whose speed the power follows.
    pub follow: Option<usize>,
    /// The cause that keeps it dark, as GetLaserFault numbers it; 0 is none.
    pub fault: i16,
    /// When it came, ms; that of the first other cause since.
    pub failed_at: f64,
    pub other_at: f64,
    /// An Abort is in progress.
    pub aborting: bool,
    /// The energy has an output.
    pub output: bool,
}

impl Owner {
    pub fn power_on(output: bool) -> Owner {
        Owner {
            light: Light::Off,
            off: false,
            map: 3,
            running: 0,
            dead: 0,
            follow: None,
            fault: 0,
            failed_at: 0.0,
            other_at: f64::INFINITY,
            aborting: false,
            output,
        }
    }

    /// GetHSIOOpt.
    pub fn is_commanded(&self) -> bool {
        matches!(self.light, Light::On(_) | Light::Waits(_))
    }

    /// Whether light of a path is on, or would come back with a start of one of these.
    pub fn is_of_path(&self, crds: u8) -> bool {
        let of = |who: &Who| matches!(who, Who::Path(crd) if crds >> crd & 1 == 1);
        match &self.light {
            Light::Off => false,
            Light::On(who) | Light::Waits(who) => of(who),
            Light::Held(who, by) => of(who) || by.iter().any(|(crd, _)| crds >> crd & 1 == 1),
        }
    }

    pub fn maps(&self, crd: usize) -> bool {
        self.map >> crd & 1 == 1
    }

    fn runs(&self, crd: usize) -> bool {
        self.running >> crd & 1 == 1
    }

    /// Whether its on entries have no effect.
    pub fn is_dead(&self, crd: usize) -> bool {
        self.dead >> crd & 1 == 1
    }

    fn shut(&mut self) -> Order {
        self.light = Light::Off;
        Order::Gate(false)
    }

    fn light(&mut self, who: Who) -> Order {
        if self.follow.is_some_and(|crd| !self.runs(crd)) {
            self.light = Light::Waits(who);
            return Order::Nothing;
        }
        self.light = Light::On(who);
        Order::Gate(true)
    }

    /// On or off by a call. None: it was an on command that nothing comes of.
    pub fn call(&mut self, on: bool) -> Option<Order> {
        if !on {
            self.off = true;
            return Some(self.shut());
        }
        if self.fault != 0 || self.aborting || !self.output {
            return None;
        }
        if matches!(self.light, Light::On(Who::Path(_))) {
            return Some(Order::Nothing);
        }
        self.off = false;
        Some(self.light(Who::Call))
    }

    /// On or off by an entry of a mapped path; whether it brakes for a Stop there.
    pub fn entry(&mut self, crd: usize, on: bool, brakes: bool) -> Option<Order> {
        if !on {
            return Some(self.shut());
        }
        let barred = self.is_dead(crd) || brakes && self.off;
        if barred || self.fault != 0 || self.aborting || !self.output {
            return None;
        }
        self.off = false;
        Some(self.light(Who::Path(crd)))
    }

    /// A path starts; whether it goes on with what lies in its FIFO.
    pub fn start(&mut self, run: Run, goes_on: bool) -> Order {
        self.running |= 1 << run.0;
        match self.light.clone() {
            Light::Held(who, mut by) if by.contains(&run) => {
                by.retain(|other| *other != run);
                if !goes_on {
                    self.light = Light::Off;
                } else if by.is_empty() {
                    return self.light(who);
                } else {
                    self.light = Light::Held(who, by);
                }
                Order::Nothing
            }
            Light::Waits(who) if self.follow == Some(run.0) => self.light(who),
            _ => Order::Nothing,
        }
    }

    /// A path comes to rest.
    pub fn rest(&mut self, run: Run, end: End) -> Order {
        let (crd, mapped) = (run.0, self.maps(run.0));
        self.running &= !(1 << crd);
        self.dead &= !(1 << crd);
        match (self.light.clone(), end) {
            (Light::Off, _) => Order::Nothing,
            (Light::On(who), End::Stopped) if mapped => {
                self.light = Light::Held(who, vec![run]);
                Order::Gate(false)
            }
            (Light::Waits(who), End::Stopped) if mapped => {
                self.light = Light::Held(who, vec![run]);
                Order::Nothing
            }
            (Light::Held(who, mut by), End::Stopped) if mapped => {
                if !by.iter().any(|other| other.0 == crd) {
                    by.push(run);
                }
                self.light = Light::Held(who, by);
                Order::Nothing
            }
            (_, End::Stopped) => Order::Nothing,
            (Light::Held(_, by), End::Done { .. }) if by.iter().any(|other| other.0 == crd && *other != run) => {
                Order::Nothing
            }
            (Light::On(who) | Light::Held(who, _) | Light::Waits(who), End::Done { braked }) => {
                let its = who == Who::Path(crd) || self.follow == Some(crd);
                if its || braked && mapped { self.shut() } else { Order::Nothing }
            }
        }
    }

    /// A Stop names these. It shuts off now if those that count are at rest.
    pub fn stop(&mut self, named: u8, running: u8) -> Order {
        let counts = named & self.map;
        let later = counts == 0 || counts & running != 0;
        if later || self.light == Light::Off { Order::Nothing } else { self.shut() }
    }

    /// A FIFO is cleared.
    pub fn empty(&mut self, run: Run) {
        if matches!(&self.light, Light::Held(_, by) if by.contains(&run)) {
            self.light = Light::Off;
        }
    }

    /// The follow changes; None: it is over. That never lights.
    pub fn follows(&mut self, crd: Option<usize>) {
        if matches!(self.light, Light::Waits(_)) && (crd.is_some() || self.follow.is_some()) {
            self.light = Light::Off;
        }
        self.follow = crd;
    }

    /// A cause of SPEC 9 of a mapped path, which has come to rest by it if it ran.
    pub fn fail(&mut self, crd: usize, cause: i16, at: f64) -> Order {
        self.running &= !(1 << crd);
        self.dead &= !(1 << crd);
        self.hit(crd, cause, at)
    }

    /// The same of a cause that lets it run on.
    pub fn hit(&mut self, crd: usize, cause: i16, at: f64) -> Order {
        if self.maps(crd) { self.darken(cause, at) } else { Order::Nothing }
    }

    /// The same whatever the map holds.
    pub fn darken(&mut self, cause: i16, at: f64) -> Order {
        self.light = Light::Off;
        if self.fault == 0 {
            (self.fault, self.failed_at, self.other_at) = (cause, at, f64::INFINITY);
        } else if self.fault != cause {
            self.other_at = self.other_at.min(at);
        }
        Order::Cut
    }

    /// ClrSts or ClrLaserFault.
    pub fn clear_fault(&mut self, _at: f64) {
        self.fault = 0;
    }

    /// Abort: on entries of what runs have no effect any more.
    pub fn abort(&mut self) -> Order {
        self.dead |= self.running;
        self.light = Light::Off;
        Order::Cut
    }

    /// Another mode, or no output.
    pub fn withdraw(&mut self) -> Order {
        self.light = Light::Off;
        Order::Cut
    }
}
