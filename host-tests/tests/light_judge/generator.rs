//! Random programs: every way to light, every way to end, and a tail that tries to go on.
use super::chance::Chance;
use super::program::{Act, Buf, Device, Do, Program};
use host_tests::light_judge::fact::Laser;
use host_tests::light_judge::{Channel, Fpk, Ns, Output, Settings, Switch, Timing};

/// Code of the pre-voltage, 1.5 V.
const PRE_VOLTAGE_CODE: i16 = 4915;

struct Maker {
    chance: Chance,
    is_gus: bool,
    tick: Ns,
    program: Program,
}

fn channel(chance: &mut Chance, is_gus: bool, set_up: u8) -> (Channel, Device) {
    let mode = [0, 0, 1, 2, 3][chance.below(5) as usize];
    let khz = [10.0, 20.0][chance.below(2) as usize];
    let power = match mode {
        1 => 15.0,
        2 => 3.0,
        _ => 40.0,
    };
    let (off, on) = [(0, 0), (130, 77), (20, 90), (700, 0)][chance.below(4) as usize];
    let fpk = Fpk { time1: 40_000, time2: 60_000, off: 70_000 };
    let held = is_gus && mode == 3;
    let has_fpk = chance.below(5) == 0 && mode != 2 && !held;
    let timing = Timing { on: on * 1000, off: off * 1000, fpk: has_fpk.then_some(fpk) };
    let waiting = chance.below(3) == 0;
    let output = match mode {
        2 => Output::Volts { waiting: if waiting { PRE_VOLTAGE_CODE } else { 0 }, least: 9800 },
        1 => Output::Pulses { period: (1e6 / power) as Ns + 3, standby: if waiting { 16_000 } else { 0 } },
        _ => Output::Pulses { period: (1e6 / khz) as Ns + 3, standby: if waiting && !held { 16_000 } else { 0 } },
    };
    let map = match chance.below(6) {
        0..4 => 3,
        4 => 1 + chance.below(2) as u8,
        _ => set_up,
    };
    let connector = !is_gus || mode == 2 || chance.below(20) != 0;
    let device = Device { mode, power, khz, waiting, switch: if held { Switch::Held } else { Switch::Gate } };
    (Channel { map, connector, timing, output }, device)
}

/// Program number so much.
pub fn program(seed: u64, is_gus: bool, tick: Ns) -> Program {
    // Numbers that follow each other must not give streams that overlap.
    let mut chance = Chance::new(Chance::new(seed).next());
    let set_up = [1, 2, 3, 3, 3][chance.below(5) as usize];
    let made = [channel(&mut chance, is_gus, set_up), channel(&mut chance, is_gus, set_up)];
    let mut channels = made.map(|made| made.0);
    let devices = made.map(|made| made.1);
    if !is_gus && devices.iter().any(|device| device.waiting) {
        // In LSR the standby pulse is set for both.
        for of in &mut channels {
            if let Output::Pulses { standby, .. } = &mut of.output {
                *standby = 16_000;
            }
        }
    }
    let look_ahead = if chance.below(6) == 0 { chance.below(4) as u8 & set_up } else { 0 };
    let settings = Settings { is_gus, set_up, channels };
    let braking = [20.0, 20.0, 3.0][chance.below(3) as usize];
    let program =
        Program { settings, devices, braking, look_ahead, entries: vec![], acts: vec![], length: 0, endings: vec![] };
    let mut maker = Maker { chance, is_gus, tick, program };
    maker.make();
    maker.program
}

impl Maker {
    fn below(&mut self, count: u64) -> u64 {
        self.chance.below(count)
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.chance.below(list.len() as u64) as usize]
    }

    fn ticks(&self, ms: f64) -> u32 {
        (ms * 1e6 / self.tick as f64).ceil() as u32
    }

    fn crd(&mut self) -> usize {
        match self.program.settings.set_up {
            1 => 0,
            2 => 1,
            _ => self.below(2) as usize,
        }
    }

    /// Laser entries of a coordinate system at a boundary.
    fn group(&mut self, crd: usize) -> Vec<Buf> {
        let mut group = vec![Buf::Mark];
        for _ in 0..self.of(&[0, 1, 1, 1, 2]) {
            let channel = self.below(2) as usize;
            let of = self.program.settings.channels[channel];
            if of.map >> crd & 1 == 0 || !of.connector {
                continue;
            }
            let laser = match self.below(13) {
                0..5 => Laser::On,
                5..8 => Laser::Off,
                8 => Laser::Power,
                9..11 => Laser::Follow,
                11 => Laser::Source,
                _ => Laser::FollowOff,
            };
            let power = self.program.devices[channel].power;
            let ratio = self.below(2) == 0;
            group.push(Buf::Laser { channel, laser, power, ratio });
        }
        group
    }

    /// Entries of a FIFO and about how long they take, ms.
    fn path(&mut self, crd: usize, fifo: usize, motions: u64) -> (Vec<Do>, f64) {
        let (mut entries, mut ms) = (Vec::new(), 0.0);
        let mut at = [0i32; 2];
        for motion in 0..motions {
            entries.extend(self.group(crd));
            if fifo == 1 || self.below(8) == 0 {
                let delay = 1 + self.below(6) as u16;
                ms += f64::from(delay);
                entries.push(Buf::Delay(delay));
                continue;
            }
            let (speed, acc) = (5.0 + 35.0 * self.chance.unit(), 2.0 + 10.0 * self.chance.unit());
            let length = self.chance.log(20.0, 200.0);
            let angle = self.chance.unit() * 6.3;
            at = [at[0] + (length * angle.cos()) as i32 + 1, at[1] + (length * angle.sin()) as i32];
            let ends = motion + 1 < motions && self.below(3) != 0;
            let end = if ends { speed } else { 0.0 };
            entries.push(Buf::Line { to: at, speed, acc, end });
            ms += length / speed + if ends { 0.3 } else { 1.0 } * speed / acc;
        }
        if fifo == 0 && self.program.look_ahead >> crd & 1 == 0 && self.below(10) == 0 {
            // At speed into what is too short to brake in.
            entries.extend(self.group(crd));
            at[0] += 100;
            entries.push(Buf::Line { to: at, speed: 20.0, acc: 5.0, end: 20.0 });
            at[0] += 2;
            entries.push(Buf::Line { to: at, speed: 20.0, acc: 5.0, end: 0.0 });
        }
        entries.extend(self.group(crd));
        let mut calls: Vec<Do> = entries.iter().map(|buf| Do::Entry { crd, fifo, buf: *buf }).collect();
        if fifo == 0 && self.program.look_ahead >> crd & 1 == 1 {
            calls.push(Do::Flush { crd, fifo });
        }
        (calls, ms)
    }

    fn call(&mut self, at: u32, call: Do) {
        self.program.acts.push((at, Act::Call(call)));
    }

    fn make(&mut self) {
        let mut longest: f64 = 5.0;
        for crd in 0..2 {
            if self.program.settings.set_up >> crd & 1 == 1 {
                let motions = 2 + self.below(6);
                let (entries, ms) = self.path(crd, 0, motions);
                self.program.entries.extend(entries);
                longest = longest.max(ms);
                if self.below(2) == 0 {
                    let motions = 1 + self.below(3);
                    let (entries, _) = self.path(crd, 1, motions);
                    self.program.entries.extend(entries);
                }
            }
        }
        let mut at = 1;
        if self.below(3) == 0 {
            let channel = self.below(2) as usize;
            let on = Do::On { channel, hsio: false };
            self.call(at, on);
            at += self.below(4) as u32;
        }
        if self.below(6) == 0 {
            let vel = [20.0, -5.0][self.below(2) as usize];
            self.call(1, Do::Jog { vel });
        }
        let set_up = self.program.settings.set_up;
        if self.below(4) == 0 && set_up == 3 {
            let first = 1 + self.below(2) as u8;
            self.call(at, Do::CrdStart { mask: first, option: 0 });
            at += 1 + self.below(20) as u32;
            self.call(at, Do::CrdStart { mask: 3 - first, option: 0 });
        } else {
            self.call(at, Do::CrdStart { mask: set_up, option: 0 });
        }
        let runs = self.ticks(longest * 1.1);
        let mut some: Vec<u32> = (0..self.below(5)).map(|_| at + 1 + self.chance.below(runs.into()) as u32).collect();
        some.sort_unstable();
        for when in &some {
            self.interim(*when);
        }
        let ended = at + 1 + self.below(runs.into()) as u32;
        let mut at = self.ending(ended);
        for _ in 0..2 + self.below(7) {
            at += 1 + self.chance.log(1.0, f64::from(self.ticks(12.0))) as u32;
            self.goes_on(at);
        }
        if self.below(3) == 0 {
            let again = at + 1 + self.below(self.ticks(6.0).into()) as u32;
            at = self.ending(again);
        }
        self.program.acts.sort_by_key(|act| act.0);
        // Beside a start nobody can tell whether what was cleared was a mark to come.
        let starts = |act: &&(u32, Act)| matches!(act.1, Act::Call(Do::CrdStart { .. }));
        let starts: Vec<u32> = self.program.acts.iter().filter(starts).map(|act| act.0).collect();
        self.program.acts.retain(|(at, act)| !matches!(act, Act::Call(Do::CrdClear { .. })) || !starts.contains(at));
        self.program.length = at + self.ticks(6.0);
    }

    /// What comes while paths run.
    fn interim(&mut self, at: u32) {
        let channel = self.below(2) as usize;
        let hsio = self.below(2) == 0;
        let call = match self.below(16) {
            0..4 => Do::On { channel, hsio },
            4..7 => Do::Off { channel, hsio },
            7 => Do::Power { channel, power: self.program.devices[channel].power + 1.0 },
            8 => Do::Map { channel, map: self.below(4) as u8 },
            9..13 => self.stop(),
            13 => Do::CrdStart { mask: self.program.settings.set_up, option: 0 },
            _ => {
                let stop = self.stop();
                self.call(at, stop);
                self.program.endings.push("stop, an off while it brakes");
                self.call(at + 1, Do::Off { channel, hsio });
                return;
            }
        };
        self.call(at, call);
        if matches!(call, Do::Stop { .. } | Do::CrdStop { .. } | Do::AxisStop { .. }) && self.below(3) != 0 {
            let again = at + 2 + self.chance.below(self.ticks(12.0).into()) as u32;
            let set_up = self.program.settings.set_up;
            if self.below(2) == 0 {
                self.call((at + again) / 2, Do::CrdStart { mask: set_up, option: set_up });
            }
            self.call(again, Do::CrdStart { mask: set_up, option: 0 });
            if self.below(3) == 0 {
                let on = self.below(2) == 0;
                let call = if on { Do::On { channel, hsio } } else { Do::Off { channel, hsio } };
                self.call((at + again) / 2, call);
            }
        }
    }

    fn stop(&mut self) -> Do {
        let set_up = self.program.settings.set_up;
        let crds = self.of(&[1, 2, 3, set_up, set_up, set_up]);
        let abrupt = self.of(&[0, 0, 3]);
        match self.below(5) {
            0 => Do::CrdStop { crds, abrupt },
            1 => Do::AxisStop { axis: self.below(4) as usize },
            2 => {
                let ends_follow = self.below(4) as u8;
                let crds = self.of(&[0, crds]);
                Do::Stop { crds, abrupt, ends_follow }
            }
            _ => Do::Stop { crds, abrupt, ends_follow: 0 },
        }
    }

    /// One way to end; the tick at which it is over.
    fn ending(&mut self, at: u32) -> u32 {
        let axis = 2 * self.crd() + self.below(2) as usize;
        let kind = self.below(18);
        let name = [
            "abort",
            "refused call, abort",
            "close",
            "killed client",
            "killed client",
            "second session",
            "stop",
            "stop twice",
            "interlock",
            "interlock",
            "alarm",
            "limit",
            "servo off",
            "overrun",
            "following error",
            "two causes",
            "link loss, client back",
            "end of the entries",
        ][kind as usize];
        self.program.endings.push(name);
        let act = |acts: &mut Vec<(u32, Act)>, at: u32, act: Act| acts.push((at, act));
        match kind {
            0 => {
                if self.below(3) == 0 {
                    let stop = self.stop();
                    let before = 1 + self.below(3) as u32;
                    self.call(at.saturating_sub(before), stop);
                }
                self.call(at, Do::Abort);
            }
            1 => {
                self.call(at, Do::Connector { channel: 0, there: false });
                self.call(at + 2, Do::Abort);
            }
            2 => {
                self.call(at, Do::Abort);
                act(&mut self.program.acts, at + 3, Act::Close);
                let back = at + 5 + self.below(20) as u32;
                act(&mut self.program.acts, back, Act::Session);
                return back + 2;
            }
            3 | 4 | 16 => {
                let ms = 3 + self.below(12) as i32;
                self.call(at, Do::LinkLoss { ms });
                let silent = at + 3;
                act(&mut self.program.acts, silent, Act::Silence);
                let back = silent + self.ticks(f64::from(ms)) + 8 + self.below(20) as u32;
                if kind == 4 {
                    act(&mut self.program.acts, back, Act::Session);
                    if self.below(2) == 0 {
                        // With the time of a new session this is no loss.
                        self.program.endings.push("silence within the time");
                        let on = Do::On { channel: self.below(2) as usize, hsio: false };
                        self.call(back + 3, on);
                        act(&mut self.program.acts, back + 6, Act::Silence);
                        let speaks = back + 6 + self.ticks(f64::from(ms)) + 8;
                        act(&mut self.program.acts, speaks, Act::Speaks);
                        return speaks + 2;
                    }
                    return back + 2;
                }
                act(&mut self.program.acts, back, Act::Speaks);
                self.call(back, Do::LinkLoss { ms: 500 });
                if self.below(2) == 0 {
                    self.call(back + 2, Do::ClearFault { channel: 0 });
                    self.call(back + 2, Do::ClearFault { channel: 1 });
                    let mask = self.program.settings.set_up;
                    self.call(back + 5, Do::CrdStart { mask, option: 0 });
                    return back + 6;
                }
                return back + 2;
            }
            5 => {
                act(&mut self.program.acts, at, Act::Session);
                return at + 2;
            }
            6 | 7 => {
                let stop = self.stop();
                self.call(at, stop);
                if kind == 7 {
                    let again = at + 1 + self.below(20) as u32;
                    let stop = self.stop();
                    self.call(again, stop);
                    return again;
                }
            }
            8 | 9 => {
                let motion = self.below(3) as i16;
                self.call(at.saturating_sub(2), Do::Interlock { motion });
                let after = self.chance.below(self.tick as u64);
                act(&mut self.program.acts, at, Act::Interlock { after });
                let gone = at + 3 + self.below(20) as u32;
                act(&mut self.program.acts, gone, Act::InterlockGone);
                return gone;
            }
            10 => self.input(at, axis, true),
            11 => self.input(at, axis, false),
            12 => {
                self.call(at, Do::AxisOff { axis });
                let on = at + 3 + self.below(20) as u32;
                self.call(on, Do::AxisOn { axis });
                return on;
            }
            13 => act(&mut self.program.acts, at, Act::Overrun),
            14 => {
                self.call(at, Do::PosErr { axis, pulses: 2 });
                let off = at + 3 + self.below(20) as u32;
                self.call(off, Do::PosErr { axis, pulses: 0x7fff_ffff });
                return off;
            }
            15 => {
                self.input(at, axis, true);
                let other = 2 * self.crd();
                match self.below(3) {
                    0 => act(&mut self.program.acts, at, Act::Overrun),
                    1 => self.input(at, other, false),
                    _ => self.call(at, Do::Abort),
                }
            }
            _ => return at + self.ticks(15.0),
        }
        at
    }

    fn input(&mut self, at: u32, axis: usize, alarm: bool) {
        let gone = at + 3 + self.below(30) as u32;
        let positive = self.below(2) == 0;
        for (at, level) in [(at, true), (gone, false)] {
            let act = if alarm { Act::Alarm { axis, level } } else { Act::Limit { axis, positive, level } };
            self.program.acts.push((at, act));
        }
    }

    /// The program tries to go on.
    fn goes_on(&mut self, at: u32) {
        let channel = self.below(2) as usize;
        let hsio = self.below(2) == 0;
        let crd = self.crd();
        let set_up = self.program.settings.set_up;
        let call = match self.below(30) {
            0..3 => Do::ClearFault { channel },
            3..5 => Do::ClearStatus { axis: 0, count: 4 },
            5..7 => {
                self.call(at, Do::ClearFault { channel: 0 });
                self.call(at, Do::ClearFault { channel: 1 });
                Do::ClearStatus { axis: 0, count: 4 }
            }
            7..14 => {
                let mask = self.of(&[set_up, set_up, 1 << crd]);
                Do::CrdStart { mask, option: if self.below(6) == 0 { mask } else { 0 } }
            }
            14..17 => Do::On { channel, hsio },
            17 => Do::Off { channel, hsio },
            18 => self.stop(),
            19 => {
                let fifo = self.below(2) as usize;
                self.call(at, Do::CrdClear { crd, fifo: 0 });
                if self.program.look_ahead >> crd & 1 == 0 {
                    let (entries, _) = self.path(crd, fifo, 1);
                    // Exclusive from the last mark before it.
                    let apart = Do::Entry { crd, fifo, buf: Buf::Delay(1) };
                    for entry in [apart].into_iter().chain(entries) {
                        self.call(at + 2, entry);
                    }
                }
                return;
            }
            20 => Do::Map { channel, map: self.below(4) as u8 },
            21 if self.is_gus => {
                self.call(at, Do::Connector { channel: 0, there: false });
                Do::Connector { channel: 0, there: true }
            }
            24 => {
                let (on, off) = self.of(&[(0, 0), (110, 40), (30, 400)]);
                Do::Delays { channel, on, off }
            }
            25 if self.program.devices[channel].switch == Switch::Gate => {
                // There and back in one tick.
                let device = self.program.devices[channel];
                self.call(at, Do::Mode { channel, mode: if device.mode == 1 { 2 } else { 1 } });
                self.call(at, Do::Mode { channel, mode: device.mode });
                Do::Power { channel, power: device.power }
            }
            26 => Do::LinkLoss { ms: self.of(&[0, 20, 200, 500]) },
            27..29 => {
                // An on at rest, and what it may wait for.
                self.call(at, Do::On { channel, hsio });
                self.call(at + 3, Do::CrdStart { mask: set_up, option: 0 });
                return;
            }
            22 => Do::Power { channel, power: self.program.devices[channel].power + 1.0 },
            _ => Do::AxisOn { axis: 2 * crd },
        };
        self.call(at, call);
    }
}
