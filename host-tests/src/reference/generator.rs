//! Programs as users write them: set up, move, stop, zero, change the mode, go again, and now and then any call anywhere.
use super::chance::Chance;
use super::{Call, Datum, Kind, Site};

mod follow_ex;
mod outputs;
mod paths;
mod pvt;

const MS: i64 = 1_000_000;

pub struct Program {
    pub calls: Vec<Call>,
}

struct Making<'a> {
    chance: Chance,
    site: &'a Site,
    calls: Vec<Call>,
    /// What each axis was last set up for, and its master.
    does: Vec<Does>,
    masters: Vec<Option<usize>>,
    /// Last time and position given to each FIFO of PT, last positions of Follow.
    pt: Vec<[(i32, f64); 2]>,
    follow: Vec<[(f64, f64); 2]>,
    /// It follows an encoder: how fast it is then depends on the tick, so that it is stopped abruptly.
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
pub fn program(seed: u64, site: &Site, calls: usize) -> Program {
    let axes = site.axes.len();
    let mut making = Making {
        chance: Chance::new(seed),
        site,
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
        self.below(self.site.axes.len() as u64) as usize
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
        if !self.one_in(3) {
            self.sleep(3);
        }
    }

    fn phrase(&mut self) {
        let axis = self.axis();
        match self.below(29) {
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
            15 => self.stop(),
            16 => self.read(axis),
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

    fn pt_data(&mut self, axis: usize, fifo: usize) {
        let (time, pos) = self.pt[axis][fifo];
        let length = 1 + self.below(12) as i32;
        let step = self.number(60) * self.chance.sign() * f64::from(length).sqrt();
        let pos = if self.one_in(3) { (pos + step).round() } else { pos + step };
        let kind = self.pick(&[0, 0, 0, 1, 2]);
        self.pt[axis][fifo] = (time + length, pos);
        self.calls.push(Call::PtData { axis, pos, time_ms: time + length, kind, fifo: fifo as i16 });
    }

    fn pt_static(&mut self, axis: usize) {
        self.rest(axis);
        self.calls.push(Call::PrfPt { axis, mode: 0 });
        self.does[axis] = Does::Pt;
        if self.one_in(12) {
            let memory = self.below(2) as i16;
            self.calls.push(Call::SetPtMemory { axis, memory });
            self.pt[axis] = Default::default();
        }
        let fifo = self.below(2) as usize;
        if !self.one_in(4) {
            self.calls.push(Call::PtClear { axis, fifo: fifo as i16 });
            self.pt[axis][fifo] = (0, 0.0);
        }
        let exactly_full = self.one_in(25);
        let count = if exactly_full { 31 + self.below(3) } else { 1 + self.below(5) };
        for _ in 0..count {
            self.pt_data(axis, fifo);
        }
        if self.one_in(3) {
            self.calls.push(Call::PtSpace { axis, fifo: fifo as i16 });
        }
        if self.one_in(2) {
            let loops = self.pick(&[0, 1, 2, 3, 7]);
            self.calls.push(Call::SetPtLoop { axis, loops });
        }
        self.calls.push(Call::PtStart { mask: 1 << axis, option: (fifo as u32) << axis });
    }

    fn pt_stream(&mut self, axis: usize) {
        self.rest(axis);
        self.calls.push(Call::PrfPt { axis, mode: 1 });
        self.does[axis] = Does::Stream;
        self.calls.push(Call::PtClear { axis, fifo: 0 });
        self.pt[axis][0] = (0, 0.0);
        for _ in 0..2 + self.below(4) {
            self.pt_data(axis, 0);
        }
        self.calls.push(Call::PtStart { mask: 1 << axis, option: 0 });
        for _ in 0..self.below(4) {
            self.sleep(6);
            if self.one_in(2) {
                self.calls.push(Call::PtSpace { axis, fifo: 0 });
            }
            self.pt_data(axis, 0);
        }
    }

    fn follow_data(&mut self, axis: usize, fifo: usize, sign: f64) {
        let (master, slave) = self.follow[axis][fifo];
        let length = 1.0 + self.below(400) as f64;
        let ratio = self.pick(&[0.25, 0.5, 1.0, 1.5]) * if self.one_in(4) { -1.0 } else { 1.0 };
        let slave = slave + length * ratio * if self.one_in(2) { 1.0 } else { self.chance.unit() };
        let kind = self.pick(&[0, 0, 0, 1, 2, 3]);
        self.follow[axis][fifo] = (master + length, slave);
        let datum = Datum { master: sign * (master + length), slave, kind, percent: 0 };
        self.calls.push(Call::FollowData { axis, datum, fifo: fifo as i16 });
    }

    /// A slave of a slave, run twice with ZeroPos in between.
    fn chain(&mut self, first: usize) {
        let count = self.site.axes.len();
        let (middle, last) = ((first + 1) % count, (first + 2) % count);
        for axis in [last, middle, first] {
            self.calls.push(Call::Stop { mask: 1 << axis, abrupt: 1 << axis });
            self.calls.push(Call::WaitStop { mask: 1 << axis });
        }
        self.sleep(2);
        for (axis, master) in [(middle, first), (last, middle)] {
            self.follow_master(axis, master);
        }
        for _ in 0..2 {
            for axis in [last, middle] {
                self.calls.push(Call::FollowStart { mask: 1 << axis, option: 0 });
            }
            self.jog(first);
            self.sleep(30);
            if self.one_in(2) {
                self.velocity(first);
                self.sleep(30);
            }
            for axis in [first, middle, last] {
                self.calls.push(Call::Stop { mask: 1 << axis, abrupt: 0 });
                self.calls.push(Call::WaitStop { mask: 1 << axis });
            }
            for axis in [first, middle, last] {
                if self.one_in(2) {
                    self.plain(Kind::ZeroPos, axis);
                }
            }
            self.sleep(2);
        }
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
        for number in 0..50 + self.below(30) as usize {
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

    /// A master that is planned again while it brakes.
    fn braking(&mut self, master: usize) {
        let slave = (master + 1) % self.site.axes.len();
        for axis in [slave, master] {
            self.calls.push(Call::Stop { mask: 1 << axis, abrupt: 1 << axis });
            self.calls.push(Call::WaitStop { mask: 1 << axis });
        }
        self.sleep(2);
        self.follow_master(slave, master);
        self.calls.push(Call::FollowStart { mask: 1 << slave, option: 0 });
        match self.below(3) {
            0 => self.trap(master),
            _ => self.jog(master),
        }
        for _ in 0..2 + self.below(3) {
            self.sleep(20);
            self.calls.push(Call::Stop { mask: 1 << master, abrupt: 0 });
            self.sleep(6);
            match self.below(3) {
                0 => {
                    if self.one_in(8) {
                        let smooth = self.rate();
                        self.calls.push(Call::SetStopDec { axis: master, smooth });
                    }
                    self.calls.push(Call::Stop { mask: 1 << master, abrupt: 0 });
                }
                _ => self.during(master),
            }
        }
    }

    fn follow_master(&mut self, axis: usize, master: usize) {
        let dir = self.pick(&[0, 0, 1, -1]);
        self.plain(Kind::PrfTrap, axis);
        self.calls.push(Call::PrfFollow { axis, dir });
        self.calls.push(Call::SetFollowMaster { axis, master, kind: 2 });
        self.calls.push(Call::SetFollowLoop { axis, loops: 0 });
        self.does[axis] = Does::Follow(dir);
        self.masters[axis] = Some(master);
        self.follow[axis] = Default::default();
        let sign = if dir < 0 { -1.0 } else { 1.0 };
        for _ in 0..1 + self.below(3) {
            self.follow_data(axis, 0, sign);
        }
    }

    fn slave(&mut self, axis: usize) {
        let mut master = self.axis();
        // A chain now and then: an axis that follows already.
        if self.one_in(2)
            && let Some(other) =
                (0..self.does.len()).find(|other| matches!(self.does[*other], Does::Follow(_) | Does::FollowEx(_)))
        {
            master = other;
        }
        if master == axis {
            master = (axis + 1) % self.site.axes.len();
        }
        self.rest(axis);
        let dir = self.pick(&[0, 0, 1, -1]);
        if self.does[axis] != Does::Follow(dir) {
            self.plain(Kind::PrfTrap, axis);
        }
        self.calls.push(Call::PrfFollow { axis, dir });
        self.calls.push(Call::SetFollowMaster { axis, master, kind: 2 });
        self.does[axis] = Does::Follow(dir);
        self.masters[axis] = Some(master);
        if self.one_in(15) {
            self.calls.push(Call::SetFollowMemory { axis, memory: 1 });
        }
        let fifo = self.below(2) as usize;
        let sign = if dir <= 0 && self.one_in(3) { -1.0 } else { 1.0 };
        self.calls.push(Call::FollowClear { axis, fifo: fifo as i16 });
        self.follow[axis][fifo] = (0.0, 0.0);
        let count = if self.one_in(30) { 15 + self.below(3) } else { 1 + self.below(4) };
        for _ in 0..count {
            self.follow_data(axis, fifo, sign);
        }
        if self.one_in(2) {
            let loops = self.pick(&[0, 0, 1, 2, 3]);
            self.calls.push(Call::SetFollowLoop { axis, loops });
        }
        if self.one_in(4) {
            let (pos, up) = (self.below(600) as i32 - 300, self.one_in(2));
            self.calls.push(Call::SetFollowEvent { axis, event: 2, dir: if up { 1 } else { -1 }, pos });
        } else if self.one_in(2) {
            self.calls.push(Call::SetFollowEvent { axis, event: 1, dir: 1, pos: 0 });
        }
        self.calls.push(Call::FollowStart { mask: 1 << axis, option: (fifo as u32) << axis });
        if self.one_in(3) {
            if !self.one_in(8) {
                self.sleep(5);
            }
            let other = fifo ^ 1;
            self.calls.push(Call::FollowClear { axis, fifo: other as i16 });
            self.follow[axis][other] = (0.0, 0.0);
            for _ in 0..1 + self.below(3) {
                self.follow_data(axis, other, sign);
            }
            if self.one_in(2) {
                self.calls.push(Call::FollowSwitch { mask: 1 << axis });
            }
        }
        // Something to follow.
        if self.one_in(2) {
            let root = self.root(master);
            let does = self.does[root];
            match does {
                Does::Jog => self.velocity(root),
                Does::Trap => self.target(root),
                _ if self.one_in(2) => self.jog(root),
                _ => {}
            }
        }
    }

    fn root(&self, axis: usize) -> usize {
        let mut root = axis;
        for _ in 0..self.does.len() {
            match (self.does[root], self.masters[root]) {
                (Does::Follow(_) | Does::FollowEx(_), Some(master)) => root = master,
                _ => break,
            }
        }
        root
    }

    /// The same once more.
    fn again(&mut self, axis: usize) {
        self.rest(axis);
        if self.one_in(2) {
            self.plain(Kind::ZeroPos, axis);
        }
        self.start(axis);
    }

    fn start(&mut self, axis: usize) {
        let mask = 1 << axis;
        let option = if self.one_in(2) { mask } else { 0 };
        match self.does[axis] {
            Does::Trap => self.target(axis),
            Does::Jog => self.velocity(axis),
            Does::Pt | Does::Stream => self.calls.push(Call::PtStart { mask, option }),
            Does::Follow(_) => self.calls.push(Call::FollowStart { mask, option }),
            Does::FollowEx(_) => self.ex(Call::FollowStart { mask, option }),
            Does::Pvt => self.calls.push(Call::PvtStart { mask }),
            Does::Path => self.during_paths(axis),
        }
    }

    /// What may be done while it runs.
    fn during(&mut self, axis: usize) {
        match self.does[axis] {
            Does::Trap => self.target(axis),
            Does::Jog => self.velocity(axis),
            Does::Pt => {
                let fifo = self.below(2) as usize;
                self.pt_data(axis, fifo);
            }
            Does::Stream => self.pt_data(axis, 0),
            Does::Pvt => match self.below(3) {
                0 => {
                    let loops = self.pick(&[0, 1, 2, 3, 5]);
                    self.calls.push(Call::SetPvtLoop { axis, loops });
                }
                1 => {
                    let table = self.table(axis);
                    self.calls.push(Call::PvtTableSelect { axis, table });
                }
                _ => self.plain(Kind::GetPvtLoop, axis),
            },
            Does::FollowEx(_) => self.during_ex(axis),
            Does::Path => self.during_paths(axis),
            Does::Follow(_) => {
                let root = self.root(axis);
                match self.below(4) {
                    0 => self.calls.push(Call::FollowSwitch { mask: 1 << axis }),
                    1 => {
                        let fifo = self.below(2) as usize;
                        self.follow_data(axis, fifo, 1.0);
                    }
                    2 => {
                        let abrupt = if self.one_in(3) { 1 << root } else { 0 };
                        self.calls.push(Call::Stop { mask: 1 << root, abrupt });
                    }
                    _ => self.start(root),
                }
            }
        }
    }

    fn zero(&mut self, axis: usize) {
        self.rest(axis);
        if self.one_in(2) {
            self.plain(Kind::ZeroPos, axis);
        } else {
            let pos = self.below(2000) as i32 - 1000;
            self.calls.push(Call::SetPrfPos { axis, pos });
        }
        self.start(axis);
    }

    /// Soft limits around where it stands, mostly, and a way out of them.
    fn soft(&mut self, axis: usize) {
        if self.one_in(3) {
            self.plain(Kind::ClrSts, axis);
            self.calls.push(Call::SetSoftLimit { axis, positive: i32::MAX, negative: i32::MIN });
            return;
        }
        self.rest(axis);
        if self.one_in(2) {
            self.plain(Kind::ZeroPos, axis);
        }
        let (top, bottom) = (self.below(400) as i32 + 1, -(self.below(400) as i32) - 1);
        let positive = if self.one_in(4) { i32::MAX } else { top };
        let negative = if self.one_in(4) { i32::MIN } else { bottom };
        self.calls.push(Call::SetSoftLimit { axis, positive, negative });
        self.start(axis);
        self.sleep(40);
        self.plain(Kind::GetSts, axis);
        if !self.one_in(4) {
            self.plain(Kind::ClrSts, axis);
        }
        self.start(axis);
    }

    fn stop(&mut self) {
        let core = self.pick(&[1, self.site.axes.last().map_or(1, |axis| axis.0)]);
        let own: u32 =
            (0..self.site.axes.len()).filter(|axis| self.site.axes[*axis].0 == core).map(|axis| 1 << axis).sum();
        let mask = self.chance.next() as u32 & own;
        let abrupt = self.chance.next() as u32 & mask;
        if mask != 0 {
            self.calls.push(Call::Stop { mask, abrupt });
        }
    }

    fn read(&mut self, axis: usize) {
        let kinds = [
            Kind::GetSts,
            Kind::GetPrfPos,
            Kind::GetPrfVel,
            Kind::GetPrfMode,
            Kind::GetPtLoop,
            Kind::GetFollowLoop,
            Kind::GetFollowStatus,
            Kind::GetFollowLoopEx,
            Kind::GetFollowStatusEx,
            Kind::GetFollowMemory,
            Kind::GetFollowMemoryEx,
            Kind::GetFollowEvent,
            Kind::GetFollowEventEx,
            Kind::GetFollowMaster,
            Kind::GetFollowMasterEx,
            Kind::GetEncPos,
        ];
        let kind = self.pick(&kinds);
        self.plain(kind, axis);
    }

    /// Any call in any state.
    fn any(&mut self, axis: usize) {
        let fifo = self.pick(&[0, 1, 0, 1, 2, -1]);
        let call = match self.below(15) {
            0 => Call::Axis { kind: Kind::AxisOff, axis },
            1 => Call::Axis { kind: Kind::ClrSts, axis },
            2 => Call::Axis { kind: self.pick(&[Kind::PrfTrap, Kind::PrfJog]), axis },
            3 => Call::PrfPt { axis, mode: self.pick(&[0, 1, 2]) },
            4 => Call::PtClear { axis, fifo },
            5 => Call::PtSpace { axis, fifo },
            6 => Call::SetPtMemory { axis, memory: self.pick(&[0, 1, 2]) },
            7 => Call::FollowClear { axis, fifo },
            8 => Call::FollowSpace { axis, fifo },
            9 => Call::SetFollowLoop { axis, loops: self.pick(&[0, 1, 2, 3]) },
            10 => Call::SetPtLoop { axis, loops: self.pick(&[-1, 0, 1, 2, 3]) },
            11 => Call::SetStopDec { axis, smooth: self.rate() },
            12 => Call::FollowSwitch { mask: 1 << axis },
            13 => Call::PrfFollow { axis, dir: self.pick(&[-1, 0, 1]) },
            _ => Call::Update { mask: 1 << axis },
        };
        let off = call == Call::Axis { kind: Kind::AxisOff, axis };
        self.calls.push(call);
        if off && self.one_in(2) {
            self.start(axis);
        }
        if off {
            self.plain(Kind::AxisOn, axis);
        }
    }
}
