//! Programs as users write them: set up, move, stop, zero, change the mode, go again, and now and
//! then any call anywhere.
use super::chance::Chance;
use super::{Call, Kind, Setup};

mod anywhere;
mod follow;
mod follow_ex;
mod inputs;
mod light;
mod light_tables;
mod marks;
mod outputs;
mod paths;
mod pt;
mod pvt;

const MS: i64 = 1_000_000;

pub struct Program {
    pub calls: Vec<Call>,
}

struct Making<'a> {
    chance: Chance,
    setup: &'a Setup,
    calls: Vec<Call>,
    /// What each axis was last set up for, and its master.
    does: Vec<Does>,
    masters: Vec<Option<usize>>,
    /// Last time and position given to each FIFO of PT, last positions of Follow.
    pt: Vec<[(i32, f64); 2]>,
    follow: Vec<[(f64, f64); 2]>,
    /// It follows an encoder: how fast it is then depends on the tick, so that it is stopped
    /// abruptly.
    counted: Vec<bool>,
    /// Coordinate systems by core and number.
    crds: Vec<paths::Made>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Does {
    Trap,
    Jog,
    Pt,
    Stream,
    Follow(i16),
    FollowEx(i16),
    Pvt,
    Path,
}

/// The program of a number.
pub fn program(seed: u64, setup: &Setup, calls: usize) -> Program {
    let axes = setup.axes.len();
    let mut making = Making {
        chance: Chance::new(seed),
        setup,
        calls: Vec::new(),
        does: vec![Does::Trap; axes],
        masters: vec![None; axes],
        pt: vec![[(0, 0.0); 2]; axes],
        follow: vec![[(0.0, 0.0); 2]; axes],
        counted: vec![false; axes],
        crds: Vec::new(),
    };
    for axis in 0..axes {
        making.plain(Kind::AxisOn, axis);
        // Else ends of Stops fall on ticks often, where rounding decides.
        if !making.one_in(8) {
            let smooth = making.chance.log(0.7, 9.0);
            making.calls.push(Call::SetStopDec { axis, smooth });
        }
    }
    let wanted = 10 + making.below(calls as u64) as usize;
    while making.calls.len() < wanted {
        making.phrase();
    }
    making.sleep(40);
    Program { calls: making.calls }
}

impl Making<'_> {
    fn below(&mut self, n: u64) -> u64 {
        self.chance.below(n)
    }

    fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    fn axis(&mut self) -> usize {
        self.below(self.setup.axes.len() as u64) as usize
    }

    fn plain(&mut self, kind: Kind, axis: usize) {
        self.calls.push(Call::Axis { kind, axis });
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len() as u64) as usize]
    }

    /// A whole number of ms, of ticks, or any ns.
    fn sleep(&mut self, ms: u64) {
        let ms = 1 + self.below(ms) as i64;
        let ns = match self.below(4) {
            0 => ms * MS,
            1 => ms * MS / 4,
            _ => ms * MS - self.below(MS as u64) as i64,
        };
        self.calls.push(Call::Sleep { ns });
    }

    /// Mostly so long that it is known where everything rests.
    fn settle(&mut self) {
        if self.one_in(3) {
            return self.sleep(3);
        }
        let ns = 3 * MS + self.below(3_000_000) as i64;
        self.calls.push(Call::Sleep { ns });
    }

    fn number(&mut self, most: u64) -> f64 {
        let whole = 1 + self.below(most);
        match self.below(3) {
            0 => whole as f64,
            1 => whole as f64 / 8.0,
            _ => self.chance.log(0.01, 1.0) * whole as f64,
        }
    }

    fn speed(&mut self) -> f64 {
        self.number(150) + 0.5
    }

    fn rate(&mut self) -> f64 {
        self.number(8) + 0.4
    }

    /// At rest, mostly.
    fn rest(&mut self, axis: usize) {
        if self.one_in(6) {
            return;
        }
        let mask = 1 << axis;
        let abrupt = if self.counted[axis] || self.one_in(2) { mask } else { 0 };
        self.calls.push(Call::Stop { mask, abrupt });
        self.calls.push(Call::WaitStop { mask });
        if !self.one_in(5) {
            self.settle();
        }
    }

    fn phrase(&mut self) {
        let axis = self.axis();
        match self.below(39) {
            29 => self.lights(),
            30..33 => self.marks(axis),
            33 => self.abort_or_reset(),
            25..28 => self.paths(axis),
            28 => self.during_paths(axis),
            20 | 21 => self.slave_ex(axis),
            22 => self.outputs(),
            23 => self.by_encoder(axis),
            24 => self.entries(axis),
            0..3 => self.trap(axis),
            3..5 => self.jog(axis),
            5..7 => self.pt_static(axis),
            7 => self.pt_stream(axis),
            19 => self.pvt(axis),
            8..11 => self.slave(axis),
            11 if self.one_in(2) => self.again(axis),
            11 if self.one_in(2) => self.chain(axis),
            11 => self.braking(axis),
            12 | 13 => self.during(axis),
            14 => self.zero(axis),
            34 => self.tick(),
            35 | 36 | 38 => self.switches(axis),
            15 => self.stop(),
            16 | 37 => self.read(axis),
            17 => self.any(axis),
            18 if self.one_in(4) => self.burst(),
            18 => self.soft(axis),
            _ => {}
        }
        match self.below(16) {
            0 => {}
            1..5 => self.sleep(4),
            _ => self.sleep(25),
        }
    }

    /// After a Reset.
    fn forget(&mut self, axis: usize) {
        self.does[axis] = Does::Trap;
        self.masters[axis] = None;
        (self.pt[axis], self.follow[axis], self.counted[axis]) = ([(0, 0.0); 2], [(0.0, 0.0); 2], false);
        let core = self.setup.axes[axis].0;
        self.forget_paths(core);
    }

    fn trap(&mut self, axis: usize) {
        self.rest(axis);
        self.plain(Kind::PrfTrap, axis);
        let (acc, dec) = (self.rate(), self.rate());
        self.calls.push(Call::SetTrapPrm { axis, acc, dec });
        self.does[axis] = Does::Trap;
        self.target(axis);
    }

    fn target(&mut self, axis: usize) {
        let most = self.pick(&[10, 200, 3000]);
        let pos = (self.below(most) as i32 + 1) * self.chance.sign() as i32;
        let vel = self.speed();
        self.calls.push(Call::SetPos { axis, pos });
        self.calls.push(Call::SetVel { axis, vel });
        self.calls.push(Call::Update { mask: 1 << axis });
    }

    fn jog(&mut self, axis: usize) {
        self.rest(axis);
        self.plain(Kind::PrfJog, axis);
        let (acc, dec) = (self.rate(), self.rate());
        self.calls.push(Call::SetJogPrm { axis, acc, dec });
        self.does[axis] = Does::Jog;
        self.velocity(axis);
    }

    fn velocity(&mut self, axis: usize) {
        let vel = if self.one_in(16) { 0.0 } else { self.speed() * self.chance.sign() };
        self.calls.push(Call::SetVel { axis, vel });
        self.calls.push(Call::Update { mask: 1 << axis });
    }

    /// As much set-up as a tick of 100 µs carries out, and starts side by side at its end.
    fn burst(&mut self) {
        let axes = [0, 1];
        for axis in axes {
            self.calls.push(Call::Stop { mask: 1 << axis, abrupt: 1 << axis });
            self.calls.push(Call::WaitStop { mask: 1 << axis });
        }
        self.sleep(3);
        for axis in axes {
            self.plain(Kind::PrfTrap, axis);
            let (acc, dec, vel) = (self.rate(), self.rate(), self.speed());
            self.calls.push(Call::SetTrapPrm { axis, acc, dec });
            self.calls.push(Call::SetVel { axis, vel });
            self.does[axis] = Does::Trap;
        }
        for number in 0..20 + self.below(16) as usize {
            let pos = 1 + self.below(900) as i32;
            self.calls.push(Call::SetPos { axis: axes[number & 1], pos });
        }
        for axis in axes {
            self.calls.push(Call::Update { mask: 1 << axis });
        }
        self.sleep(9);
        if self.one_in(4) {
            self.calls.push(Call::PrfPt { axis: 0, mode: 2 });
        }
    }
}
