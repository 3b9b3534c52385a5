//! The gate after its delays, the first-pulse killer, the switch and the light: SPEC 6, "Gate".
//!
//! In: commands at their instants (ms), which act before the edges of their instant. Out: edges of
//! the switch, and whether there is light.

/// Closer instants, ms, are one; instants further apart, but closer than the other, may fall either
/// way.
const SAME_INSTANT_MS: f64 = 1e-9;
const NEAR_MS: f64 = 6e-6;

/// EnaFPK, ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fpk {
    pub time1: f64,
    pub time2: f64,
    pub off: f64,
}

/// A level, and its changes to come.
#[derive(Debug, Clone, Default)]
struct Pending {
    level: bool,
    edges: Vec<(f64, bool)>,
    /// The last one that the level has taken.
    taken: Option<f64>,
    /// Two of them fell so near to each other that rounding decides.
    tie: bool,
}

impl Pending {
    /// A later command cancels what is pending at or after its own effect.
    fn command(&mut self, at: f64, level: bool) {
        let near = |edge: f64| (edge - at).abs() < NEAR_MS && (edge - at).abs() > SAME_INSTANT_MS;
        self.tie |= self.edges.iter().any(|edge| near(edge.0)) || self.taken.is_some_and(near);
        self.edges.retain(|edge| edge.0 < at - SAME_INSTANT_MS);
        self.edges.push((at, level));
    }

    fn next(&self) -> f64 {
        self.edges.first().map_or(f64::INFINITY, |edge| edge.0)
    }

    /// The first one; whether the level changes.
    fn take(&mut self) -> Option<bool> {
        let (at, level) = self.edges.remove(0);
        self.taken = Some(at);
        (std::mem::replace(&mut self.level, level) != level).then_some(level)
    }
}

/// See the module text.
#[derive(Debug, Clone, Default)]
pub struct Gate {
    gate: Pending,
    light: Pending,
    fpk: Option<Fpk>,
    /// laserOffDelay of the mark in progress.
    tail: f64,
    /// End of the suppression pulse in progress.
    pulse: Option<f64>,
    /// The switch is held at its enabled level; nothing is output.
    pub held: bool,
    pub quiet: bool,
    switch: bool,
    /// Light since this instant, and before it.
    since: f64,
    lasted: f64,
    /// Edges of light, of which each is known to a few ns.
    count: u32,
    pub edges: Vec<(f64, bool)>,
}

impl Gate {
    /// Whether rounding decides something.
    pub fn tie(&mut self) -> bool {
        std::mem::take(&mut self.gate.tie) | std::mem::take(&mut self.light.tie)
    }

    /// Whether an edge is pending so near to an instant that rounding may decide which comes first.
    pub fn is_near(&self, at: f64) -> bool {
        let near = |edge: &(f64, bool)| (edge.0 - at).abs() < NEAR_MS && (edge.0 - at).abs() > SAME_INSTANT_MS;
        self.gate.edges.iter().chain(&self.light.edges).any(near)
    }

    pub fn is_light(&self) -> bool {
        self.light.level && !self.quiet
    }

    /// An edge is pending, or a suppression pulse in progress.
    pub fn is_busy(&self) -> bool {
        !self.gate.edges.is_empty() || !self.light.edges.is_empty() || self.pulse.is_some()
    }

    fn settle(&mut self, at: f64) {
        let level =
            !self.quiet && (self.held || if self.fpk.is_some() { self.pulse.is_some() } else { self.gate.level });
        if level != self.switch {
            self.switch = level;
            self.edges.push((at, level));
        }
    }

    fn lights(&mut self, at: f64, level: bool) {
        self.count += 1;
        if level {
            self.since = at;
        } else {
            self.lasted += at - self.since;
        }
    }

    /// Edges up to an instant; those of the instant itself where it is `through`.
    pub fn advance(&mut self, to: f64, through: bool) {
        let until = if through { to + SAME_INSTANT_MS } else { to - SAME_INSTANT_MS };
        while self.is_busy() {
            let pulse = self.pulse.unwrap_or(f64::INFINITY);
            let (gate, light) = (self.gate.next(), self.light.next());
            let at = gate.min(light).min(pulse);
            if at > until {
                return;
            }
            if gate == at {
                match self.gate.take() {
                    Some(true) => {
                        let shift = self.fpk.map_or(0.0, |fpk| fpk.time2);
                        self.tail = self.fpk.map_or(0.0, |fpk| fpk.off);
                        self.light.command(at + shift, true);
                        self.pulse = self.fpk.map(|fpk| at + fpk.time1);
                    }
                    Some(false) => self.light.command(at + self.tail, false),
                    None => {}
                }
            } else if pulse == at {
                self.pulse = None;
            } else if let Some(level) = self.light.take() {
                self.lights(at, level);
            }
            self.settle(at);
        }
    }

    /// An on or off command that takes effect at an instant.
    pub fn command(&mut self, effect: f64, on: bool) {
        self.gate.command(effect, on);
    }

    /// Dark at once; nothing pends.
    pub fn cut(&mut self, at: f64) {
        if self.light.level {
            self.lights(at, false);
        }
        (self.gate.level, self.light.level, self.pulse) = (false, false, None);
        self.gate.edges.clear();
        self.light.edges.clear();
        self.settle(at);
    }

    /// EnaFPK or DisFPK.
    pub fn suppress(&mut self, at: f64, fpk: Option<Fpk>) {
        self.fpk = fpk;
        if fpk.is_none() {
            self.pulse = None;
        }
        self.settle(at);
    }

    /// The switch may be held at its enabled level, or everything be off.
    pub fn hold(&mut self, at: f64, held: bool, quiet: bool) {
        (self.held, self.quiet) = (held, quiet);
        self.settle(at);
    }

    /// Light since the counter was set to zero, ms, and how well it is known.
    pub fn on_time(&self, now: f64) -> (f64, f64) {
        let lit = if self.light.level { now - self.since } else { 0.0 };
        (self.lasted + lit, NEAR_MS * f64::from(self.count + 1))
    }

    /// ZeroLaserOnTime.
    pub fn zero(&mut self, at: f64) {
        (self.lasted, self.count, self.since) = (0.0, 0, at);
    }
}
