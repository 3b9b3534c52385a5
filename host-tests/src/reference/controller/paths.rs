//! Coordinate systems: what their calls answer, and how they take their axes along.
mod step;

use super::super::axis::Axis;
use super::super::axis::{Mode, Why};
use super::super::call::{Call, members};
use super::super::crd::{CAPACITY, Crd, Entry, Fifo, Move, Rest, Set, World};
use super::super::light::{Act, Command, OTHER, UNDERRUN};
use super::super::number::Fix;
use super::super::path::{Cycle, Path, PathCall, Speeds};
use super::answer::{Answer, DONE, check, either, range};
use super::{Controller, Reply, Value};
use crate::path_model::{Frame, Geometry, Rates};

/// Core and number.
pub type Name = (i16, i16);
/// To a core.
const CRDS: i16 = 2;
/// Analog outputs of the virtual controller.
const ANALOG_OUTPUTS: i16 = 8;
/// Speeds and accelerations of SetCrdPrm are below this.
const PATH_SPEED_MAX_PULSES_PER_MS: f64 = 32767.0;
/// The lowest speed and acceleration.
const PATH_SPEED_MIN_PULSES_PER_MS: f64 = 1.0 / 1048576.0;

/// What a Stop or an override does at the instant of a tick. An abrupt Stop shows the set-points of
/// the tick before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathThen {
    Brake,
    Halt,
    Rate(f64),
}

fn ms(ns: i64) -> f64 {
    ns as f64 / 1e6
}

/// The axes that a path moves beside its own, in a tick.
struct Others<'a> {
    name: Name,
    before: Fix,
    /// synVelMax.
    speed: f64,
    /// By how many ms the path may be from here, beside its waits.
    late: f64,
    axes: &'a mut [Box<Axis>],
    /// Those that set off in this tick.
    early: &'a mut Vec<usize>,
    /// What it must not try.
    open: &'a mut Option<&'static str>,
}

impl World for Others<'_> {
    fn travel(&mut self, at: f64, to: &Move) -> Option<f64> {
        // Also where a call of just now keeps it from moving.
        self.early.push(to.axis);
        if self.axes[to.axis].mode != Mode::Trap {
            // And those of the entries after it.
            self.early.extend(0..self.axes.len());
        }
        let axis = &mut self.axes[to.axis];
        if axis.geared && axis.crd == Some(self.name) && !axis.driven {
            // The motion that took it along is over: it sets off from the end of that.
            axis.head.extend(axis.carried.take().unwrap_or_default().into_iter().skip(1));
            (axis.geared, axis.crd, axis.bent, axis.path_ended) = (false, None, true, false);
            axis.led = true;
            axis.head_most = axis.head_most.max(axis.path_most);
        }
        if axis.mode != Mode::Trap || axis.driven || axis.blocked() {
            return None;
        }
        let is_there = axis.goes_until().is_some_and(|end| end.to_f64() < at + 1e-9);
        if to.waits && axis.runs() && !is_there {
            // Where it brakes already, a rounding of its place is much of its time.
            *self.open = Some("a path that waits for a move begun at speed");
        }
        let ends = axis.travel(self.before, Fix::of_f64(at), to.to, [to.vel, to.acc]);
        if to.waits && axis.end_is_doubtful {
            *self.open = Some("a path that waits for a move whose end depends on rounding");
        }
        Some(ends.to_f64())
    }

    fn may_move(&mut self, axis: usize) {
        self.early.push(axis);
    }

    fn engage(&mut self, axis: usize, ratio: f64, waited: u32) -> Option<Fix> {
        // The end of a move that it waits for is known to 5 ns.
        let slack = self.speed * (self.late + 5e-6 * f64::from(waited));
        let of = &mut self.axes[axis];
        if !of.geared {
            // Also where a call of just now keeps it from moving.
            self.early.push(axis);
            if of.mode == Mode::Crd || of.runs() || of.blocked() {
                return None;
            }
            of.path_most = Fix::ZERO;
        } else if of.crd != Some(self.name) {
            return None;
        }
        of.path_most = of.path_most.max(Fix::of_f64(ratio * self.speed));
        // The way along the path has 2⁻²² pulse: an axis that is geared up by more than 64 is not
        // known to 2⁻¹⁶ pulse.
        of.late = Fix::of_f64(ratio * (2f64.powi(-22) + slack));
        (of.geared, of.driven, of.crd) = (true, true, Some(self.name));
        let track = of.carried.get_or_insert_with(|| vec![(self.before, of.x)]);
        track.last().map(|last| last.1)
    }

    fn carry(&mut self, at: f64, axis: usize, x: Fix, ends: bool) {
        let of = &mut self.axes[axis];
        if let Some(track) = &mut of.carried {
            track.push((Fix::of_f64(at), x));
        }
        // Before the next motion takes it along it is at standstill.
        (of.driven, of.path_ended) = (!ends, ends);
    }
}

impl Controller {
    pub(super) fn crd(&mut self, core: i16, crd: i16) -> Result<&mut Crd, i16> {
        range((1..=CRDS).contains(&crd))?;
        let crd = self.crds.entry((core, crd)).or_default();
        let Some(set) = &crd.set else { return Err(1) };
        if !crd.runs {
            // Coordinates are names: ZeroPos and SetPrfPos change them.
            for (coordinate, axis) in set.axes.iter().enumerate() {
                let Some(axis) = *axis else { continue };
                crd.position[coordinate] = (self.axes[axis].name() - set.zero[coordinate]).to_f64();
            }
        }
        Ok(crd)
    }

    pub(super) fn path(&mut self, index: usize, call: &Call, of: &PathCall, now: i64) -> Answer {
        let core = of.core;
        match &of.what {
            Path::Set { crd, axes, vel, acc, even_ms, origin } => {
                return self.set_frame((core, *crd), axes, (*vel, *acc), *even_ms, origin.as_deref());
            }
            Path::Clear { crd, fifo } => {
                let moved = self.may_have_moved((core, *crd));
                let of = self.crd(core, *crd)?;
                of.contested[0] = of.runs;
                either(!of.runs, (0..2).contains(fifo))?;
                of.moved = moved;
                of.fifos[*fifo as usize] = Default::default();
                if core == 1 {
                    self.light.calls.push(Act::Cleared(*crd as usize - 1, *fifo as usize));
                }
            }
            Path::Start { mask, option } => return self.start_paths(core, *mask, *option, now),
            Path::Stop { mask, option } => {
                range(*mask >> CRDS == 0 && *mask >= 0)?;
                self.unsettle(if core == 1 { *mask as u8 } else { 0 });
                if core == 1 {
                    self.stop_light(*mask as u8);
                }
                for crd in 1..=CRDS {
                    if mask >> (crd - 1) & 1 == 1 {
                        self.stop_path((core, crd), option >> (crd - 1) & 1 == 1, Why::Smooth);
                    }
                }
            }
            Path::StopDec { crd, smooth } => {
                let of = self.crd(core, *crd)?;
                range(*smooth > 0.0 && *smooth < PATH_SPEED_MAX_PULSES_PER_MS)?;
                if of.brakes {
                    self.open = Some("SetCrdStopDec while it brakes");
                }
                self.crd(core, *crd)?.stop_dec = *smooth;
            }
            Path::Override { crd, ratio } => {
                self.crd(core, *crd)?;
                range(*ratio >= PATH_SPEED_MIN_PULSES_PER_MS && *ratio <= 1.0)?;
                self.path_then.push(((core, *crd), PathThen::Rate(*ratio)));
            }
            Path::Line { crd, to, speeds, fifo } => return self.line((core, *crd), to, speeds, *fifo),
            Path::Arc { crd, plane, to, round, ccw, speeds, fifo } => {
                let of = self.crd(core, *crd)?;
                range((0..2).contains(fifo))?;
                let dimension = of.set.as_ref().map_or(0, |set| set.axes.iter().flatten().count());
                let (first, second) = plane.axes();
                range(first < dimension && second < dimension)?;
                let begin = self.begin((core, *crd), *fifo as usize, true);
                let end = (f64::from(to[0]), f64::from(to[1]));
                let chord = (end.0 - begin[first], end.1 - begin[second]);
                let half = chord.0.hypot(chord.1) / 2.0;
                let geometry = match *round {
                    Cycle::Radius(radius) => {
                        if half > 0.0 && (0.0..2.0).contains(&(half - radius.abs())) {
                            self.open = Some("a radius a little too small");
                        }
                        Geometry::arc_by_radius(begin, *plane, end, radius, *ccw)
                    }
                    Cycle::Centre(x, y) => {
                        // So much that the path leaves the arc is refused; how much that is depends
                        // on the arc.
                        if half > 0.0 && (half - (x * chord.0 + y * chord.1) / (2.0 * half)).abs() > 0.7 {
                            self.open = Some("a centre that is not equally far from both ends");
                        }
                        Geometry::arc_by_centre(begin, *plane, end, (x, y), *ccw)
                    }
                };
                let Some(geometry) = geometry else { return Err(7) };
                let mut target = begin;
                (target[first], target[second]) = end;
                return self.motion((core, *crd), *fifo as usize, geometry, (target, 1 << first | 1 << second), speeds);
            }
            Path::Delay { crd, ms, fifo } => {
                self.crd(core, *crd)?;
                range((0..2).contains(fifo))?;
                return self.put((core, *crd), *fifo as usize, Entry::Delay(f64::from(*ms)));
            }
            Path::Outputs { crd, mask, value, fifo } => {
                self.crd(core, *crd)?;
                range((0..2).contains(fifo))?;
                let entry = Entry::Outputs((*mask).into(), (*value).into());
                return self.put((core, *crd), *fifo as usize, entry);
            }
            Path::Output { crd, index, level, fifo } => {
                let set = self.crd(core, *crd).map(|_| ());
                let known = (1..=CRDS).contains(crd) && (0..2).contains(fifo) && (1..=32).contains(index);
                either(set.is_ok(), known)?;
                let bit = 1 << (index - 1);
                return self.put((core, *crd), *fifo as usize, Entry::Outputs(bit, if *level { bit } else { 0 }));
            }
            Path::Jump { crd, to, vel, acc, fifo } => {
                let speeds = Speeds { vel: *vel, acc: *acc, end: 0.0 };
                return self.line((core, *crd), to, &speeds, *fifo);
            }
            Path::Laser { crd, channel, command, fifo } => {
                let set = self.crd(core, *crd).map(|_| ());
                let known = (1..=CRDS).contains(crd) && (0..2).contains(fifo) && (0..2).contains(channel);
                if !known || core != 1 {
                    return either(set.is_ok(), false).map(|()| Reply::Open);
                }
                let of = self.light.after_calls(*channel as usize);
                let outputs = of.owner.output || *command != Command::Gate(true);
                let taken = self.laser_entry(&of, *command);
                let (empty, wrong) = (taken == Err(1), taken.is_err_and(|code| code != 1));
                either(set.is_ok() && of.owner.maps(*crd as usize - 1) && outputs && !empty, !wrong)?;
                return self.put((core, *crd), *fifo as usize, Entry::Laser(*channel as usize, taken?));
            }
            Path::Analog { crd, dac, value, fifo } => {
                let set = self.crd(core, *crd).map(|_| ());
                let known = (1..=CRDS).contains(crd) && (0..2).contains(fifo) && (1..=ANALOG_OUTPUTS).contains(dac);
                either(set.is_ok() && !self.is_of_laser(*dac), known)?;
                return self.put((core, *crd), *fifo as usize, Entry::Analog(*dac as usize - 1, *value));
            }
            Path::Move { crd, axis, to, vel, acc, modal, fifo } => {
                let set = self.crd(core, *crd).map(|_| ());
                let known = |x: f64| (PATH_SPEED_MIN_PULSES_PER_MS..=PATH_SPEED_MAX_PULSES_PER_MS).contains(&x);
                let good = (0..2).contains(fifo) && known(*vel) && known(*acc) && (0..2).contains(modal);
                either(self.axes[*axis].mode == Mode::Trap && set.is_ok(), good && (1..=CRDS).contains(crd))?;
                let entry = Move { axis: *axis, to: *to, vel: *vel, acc: *acc, waits: *modal == 1 };
                return self.put((core, *crd), *fifo as usize, Entry::Move(entry));
            }
            Path::Gear { crd, axis, pulses, fifo } => {
                self.crd(core, *crd)?;
                either(self.axes[*axis].mode == Mode::Trap, (0..2).contains(fifo))?;
                let of = &self.crds[&(core, *crd)].fifos[*fifo as usize];
                // Four go along with a motion, none twice.
                let geared = of.geared_to_next();
                check(geared.len() < 4 && !geared.contains(axis))?;
                return self.put((core, *crd), *fifo as usize, Entry::Gear(*axis, *pulses));
            }
            Path::GetPrm { crd } | Path::Pos { crd } | Path::Vel { crd } => {
                self.crd(core, *crd)?;
                return Ok(self.read(index, call, 0));
            }
            Path::Space { crd, fifo } | Path::Status { crd, fifo } | Path::Remainder { crd, fifo } => {
                self.crd(core, *crd)?;
                range((0..2).contains(fifo))?;
                let of = self.crd(core, *crd)?;
                let held = of.fifos[*fifo as usize].entries.len();
                return Ok(self.read(index, call, held));
            }
            Path::Filter { .. } | Path::GetFilter { .. } | Path::Why { .. } => {
                return self.path_setting(index, call, of);
            }
            Path::Wait { .. } => return Ok(Reply::Open),
            Path::LookAhead { .. } | Path::Limit { .. } | Path::Flush { .. } => {
                // Held by its properties: host-tests/tests/reference/ahead.rs.
                self.open = Some("a path with look-ahead");
            }
        }
        DONE
    }

    fn begin(&mut self, name: Name, fifo: usize, is_arc: bool) -> [f64; 4] {
        let (of, begin) = (&self.crds[&name], self.crds[&name].begin(fifo));
        let left = |axis: &usize| {
            let axis = &self.axes[*axis];
            axis.mode != Mode::Crd || axis.crd != Some(name) || is_arc && axis.stopped
        };
        if of.set.as_ref().is_some_and(|set| set.axes.iter().flatten().any(left)) {
            self.open = Some("a motion whose begin an axis has left, or a Stop of this instant decides");
        }
        let goes_on = of.started_here && of.goes_on;
        if is_arc && (self.unsettled != 0 || goes_on) && !of.fifos[fifo].ends_anew() {
            // An arc needs to know where it begins, motions may be left or not: docs/crd.md.
            self.open = Some("an arc that begins a path after a Stop or directly after a WaitStop");
        } else if is_arc && of.started_here && !of.fifos[fifo].ends_anew() {
            self.open = Some("an arc that comes first after a start of its instant");
        }
        let ended = (of.hidden || of.why == Some(Why::Interlock)) && of.fifos[fifo].begins().is_none();
        if is_arc && (ended || of.fifos[fifo].lost) {
            // A program is admitted ahead, by where the path would have ended: docs/crd.md.
            self.open = Some("an arc that begins where an interlock has stopped a path");
        }
        if begin.is_none() {
            self.open = Some("a motion whose begin is not known yet");
        }
        begin.unwrap_or(of.position)
    }

    fn line(&mut self, name: Name, to: &[i32], speeds: &Speeds, fifo: i16) -> Answer {
        let of = self.crd(name.0, name.1)?;
        range((0..2).contains(&fifo))?;
        let dimension = of.set.as_ref().map_or(0, |set| set.axes.iter().flatten().count());
        let begin = self.begin(name, fifo as usize, false);
        let mut target = begin;
        for (position, to) in target.iter_mut().zip(to) {
            *position = f64::from(*to);
        }
        range(to.iter().enumerate().all(|(index, to)| *to == 0 || index < dimension))?;
        if target == begin {
            // Refused where its begin is known ahead of its instant (docs/crd.md).
            self.open = Some("a line without length");
        }
        let sets = (1 << to.len()) - 1;
        self.motion(name, fifo as usize, Geometry::line(begin, target), (target, sets), speeds)
    }

    fn motion(
        &mut self,
        name: Name,
        fifo: usize,
        geometry: Geometry,
        (to, sets): ([f64; 4], u8),
        speeds: &Speeds,
    ) -> Answer {
        let Speeds { vel, acc, end } = *speeds;
        range(vel >= PATH_SPEED_MIN_PULSES_PER_MS && acc >= PATH_SPEED_MIN_PULSES_PER_MS && end >= 0.0)?;
        self.put(name, fifo, Entry::Motion(geometry, Rates { speed: vel, acc, end }, to, sets))
    }

    fn put(&mut self, name: Name, fifo: usize, entry: Entry) -> Answer {
        let of = self.crds.get_mut(&name).ok_or(1i16)?;
        if of.runs && of.fifo == fifo && of.fifos[fifo].waiting() >= CAPACITY {
            // It waits for room, which moves the clock (SPEC 7).
            self.open = Some("data that waits for room");
            return DONE;
        }
        check(of.fifos[fifo].waiting() < CAPACITY)?;
        if of.runs && of.fifo == fifo && of.fifos[fifo].lasting() <= 1 {
            of.late = true;
        }
        of.fed_here |= of.started_here;
        of.fifos[fifo].entries.push(entry);
        DONE
    }

    fn set_frame(
        &mut self,
        name: Name,
        axes: &[usize],
        (speed, acc): (f64, f64),
        even_ms: i16,
        origin: Option<&[i32]>,
    ) -> Answer {
        let (core, number) = name;
        range((1..=CRDS).contains(&number) && (1..=4).contains(&axes.len()))?;
        let limits = |x: f64| (PATH_SPEED_MIN_PULSES_PER_MS..PATH_SPEED_MAX_PULSES_PER_MS).contains(&x);
        range(limits(speed) && limits(acc) && even_ms >= 0)?;
        range(axes.iter().all(|axis| self.cores[*axis] == core))?;
        range(axes.iter().enumerate().all(|(index, axis)| !axes[..index].contains(axis)))?;
        if let Some(crd) = self.crds.get_mut(&name) {
            crd.contested[0] = crd.runs;
            check(!crd.runs)?;
        }
        for &axis in axes {
            check(!self.axes[axis].runs())?;
            let other = self.axes[axis].crd.filter(|other| *other != name && self.axes[axis].mode == Mode::Crd);
            let drives = |crd: &Crd| crd.set.as_ref().is_some_and(|set| set.axes.contains(&Some(axis)));
            check(!other.is_some_and(|other| drives(&self.crds[&other])))?;
        }
        // An axis that it drove and no longer drives is one without a mode of its own: Trap, as at
        // power-on.
        let before = self.crds.get(&name).and_then(|crd| crd.set.as_ref()).map_or([None; 4], |set| set.axes);
        for axis in before.into_iter().flatten().filter(|axis| !axes.contains(axis)) {
            if self.axes[axis].mode == Mode::Crd && self.axes[axis].crd == Some(name) {
                self.axes[axis].set_mode(Mode::Trap);
            }
        }
        let (mut zero, mut position, mut of) = ([Fix::ZERO; 4], [0.0; 4], [None; 4]);
        for (index, &axis) in axes.iter().enumerate() {
            let axis_of = &mut self.axes[axis];
            axis_of.set_mode(Mode::Crd);
            axis_of.crd = Some(name);
            axis_of.joined = true;
            zero[index] = match origin {
                Some(origin) => Fix::whole(origin[index].into()),
                None => axis_of.name(),
            };
            position[index] = (axis_of.name() - zero[index]).to_f64();
            of[index] = Some(axis);
        }
        let frame = Frame { speed, acc, even_ms: f64::from(even_ms) };
        let set = Some(Set { frame, axes: of, zero });
        let moved = self.may_have_moved(name);
        let crd = Crd {
            set,
            position,
            moved,
            stop_dec: acc,
            certain: self.unsettled == 0 && origin.is_none(),
            ..Crd::default()
        };
        self.crds.insert(name, crd);
        if core == 1 {
            // Both FIFOs are empty: what they would bring back does not come.
            let cleared = |fifo| Act::Cleared(number as usize - 1, fifo);
            self.light.calls.extend([0, 1].map(cleared));
        }
        DONE
    }

    fn start_paths(&mut self, core: i16, mask: i16, option: i16, now: i64) -> Answer {
        range(mask >= 0 && mask >> CRDS == 0)?;
        let named = || (1..=CRDS).filter(move |crd| mask >> (crd - 1) & 1 == 1);
        let fifo = |crd: i16| (option >> (crd - 1) & 1) as usize;
        for crd in named() {
            if self.path_then.iter().any(|(of, _)| *of == (core, crd)) {
                self.open = Some("a start of a path at the instant of a Stop");
            }
            let of = self.crd(core, crd)?;
            of.contested[0] = of.runs;
            check(!of.runs)?;
            let (axes, waiting) = (of.set.as_ref().map_or([None; 4], |set| set.axes), of.fifos[fifo(crd)].waiting());
            for axis in axes.into_iter().flatten() {
                let axis = &self.axes[axis];
                check(axis.mode == Mode::Crd && axis.crd == Some((core, crd)) && !axis.runs() && !axis.blocked())?;
            }
            // A motion that was interrupted takes its geared axes along again.
            let geared = self.crd(core, crd)?.fifos[fifo(crd)].geared_within();
            for axis in geared {
                let axis = &self.axes[axis];
                check(axis.mode != Mode::Crd && !axis.runs() && !axis.blocked())?;
            }
            check(waiting > 0)?;
        }
        for crd in named() {
            let fifo = fifo(crd);
            let of = self.crd(core, crd)?;
            let begins = of.fifos[fifo].begins();
            let position = of.position;
            let apart = |begin: [f64; 4]| begin.iter().zip(position).any(|(a, b)| (a - b).abs() > 1e-6);
            let elsewhere = begins.is_some_and(apart) || of.fifos[fifo].left.is_some_and(apart);
            let goes_on = of.fifos[fifo].left.is_some();
            let comes_back = of.comes_back(fifo);
            of.start(fifo, ms(now));
            let mapped = of.set.as_ref().map_or([None; 4], |set| set.axes).into_iter().zip(position);
            // One whose coordinate is whole has come to where data ended.
            let apart = |(axis, position): (Option<usize>, f64)| {
                axis.filter(|_| position.fract() != 0.0).map_or(0.0, |axis: usize| self.axes[axis].slack.to_f64())
            };
            let apart = mapped.map(apart).sum();
            self.crd(core, crd)?.blur_length(apart);
            if core == 1 {
                self.light.calls.push(Act::Starts(crd as usize - 1, fifo, goes_on));
            }
            let of = self.crd(core, crd)?;
            let axes = of.set.as_ref().map_or([None; 4], |set| set.axes);
            if elsewhere {
                self.open = Some("a FIFO that begins elsewhere");
            }
            if comes_back {
                self.open = Some("a motion of FIFO 1 that comes back to where FIFO 0 was left");
            }
            axes.into_iter().flatten().for_each(|axis| (self.axes[axis].driven, self.axes[axis].began) = (true, true));
            *self.used.entry("paths started").or_default() += 1;
        }
        DONE
    }

    /// Whether a path that runs has entries that move some of these axes.
    pub(super) fn may_set_off(&self, axes: u32) -> bool {
        self.crds.values().filter(|of| of.runs).any(|of| (of.moved | of.moves()) & axes != 0)
    }

    /// The axes that data which is cleared now may have moved, as far as a program knows.
    fn may_have_moved(&self, name: Name) -> u32 {
        self.crds.get(&name).filter(|_| self.unsettled != 0).map_or(0, |of| of.moved | of.moves())
    }

    /// A Stop that names these of core 1: where paths are may be known later than it is so.
    pub(super) fn unsettle(&mut self, named: u8) {
        (self.unsettled, self.still_ns) = (2, 0);
        for ((core, number), crd) in &mut self.crds {
            crd.certain = false;
            crd.fifos.iter_mut().for_each(Fifo::stop);
            crd.stopped |= *core == 1 && named >> (number - 1) & 1 == 1 && !crd.awaited;
        }
    }

    /// A program has waited for these paths: from then on they are known to be at standstill.
    pub(super) fn await_paths(&mut self, axes: u32) {
        for crd in self.crds.values_mut() {
            let mapped = crd.set.iter().flat_map(|set| set.axes.into_iter().flatten());
            crd.awaited |= mapped.into_iter().any(|axis| axes >> axis & 1 == 1);
        }
    }

    /// A Stop of a coordinate system.
    pub(super) fn stop_path(&mut self, name: Name, abrupt: bool, why: Why) {
        let Some(of) = self.crds.get_mut(&name).filter(|of| of.runs) else { return };
        if of.started_here {
            self.open = Some("a Stop at the instant of a start");
        }
        if self.path_then.contains(&(name, PathThen::Halt)) {
            self.open = Some("a Stop of a path after an abrupt one of its instant");
        }
        let axes = of.set.as_ref().map_or([None; 4], |set| set.axes);
        // Whether they count as resting for what follows at this instant.
        axes.into_iter().flatten().for_each(|axis| self.axes[axis].doubt = true);
        let then = if abrupt { PathThen::Halt } else { PathThen::Brake };
        let why = if abrupt && why == Why::Smooth { Why::Abrupt } else { why };
        // Two of them: which of their reasons counts is open, also after a third one.
        let stops = |(of, then): &(Name, PathThen)| *of == name && !matches!(then, PathThen::Rate(_));
        let before = self.path_then.iter().any(stops);
        of.ending = if of.brakes || before && of.ending != Some(why) { None } else { Some(why) };
        self.path_then.push((name, then));
    }

    /// The axes of coordinate systems of a core.
    pub(super) fn path_axes(&self, core: i16, mask: u32) -> u32 {
        let of = |crd: usize| self.crds.get(&(core, crd as i16 + 1)).and_then(|of| of.set.as_ref());
        let sets = members(mask).filter_map(of);
        sets.flat_map(|set| set.axes.into_iter().flatten()).fold(0, |mask, axis| mask | 1 << axis)
    }

    /// Whether WaitStop still waits for these of a core.
    pub(super) fn paths_run(&self, core: i16, mask: u32) -> bool {
        let of = |crd: usize| self.crds.get(&(core, crd as i16 + 1));
        members(mask).any(|crd| of(crd).is_some_and(|of| of.runs))
    }

    /// Of what lies in a FIFO a call says how much was there when it was made. A path is ahead of
    /// the tick: what ends in the tick that follows may count already.
    pub(super) fn read_path(&self, of: &PathCall, held: usize, now: i64) -> (Value, bool) {
        let of_core = of.core;
        let crd = |crd: i16| &self.crds[&(of_core, crd)];
        let soon = |of: &Crd| of.open || of.changes_by(ms(now + self.tick_ns) + 1e-6);
        match of.what {
            Path::Space { crd: number, fifo } => {
                let of = crd(number);
                let waiting = of.fifos[fifo as usize].waiting_of(held);
                // What is entered after it at its instant may count already: an open finding.
                let more = of.fifos[fifo as usize].entries.len() != held;
                (Value::Whole((CAPACITY - waiting) as i64), more || !of.certain || soon(of))
            }
            Path::Status { crd: number, fifo } => {
                let of = crd(number);
                (Value::Two(of.runs.into(), of.fifos[fifo as usize].segments(held)[0]), soon(of))
            }
            Path::Remainder { crd: number, fifo } => {
                let of = crd(number);
                // What is entered after it at its instant may count already: an open finding.
                let more = of.fifos[fifo as usize].entries.len() != held;
                (Value::Whole(of.fifos[fifo as usize].segments(held)[1]), more || soon(of))
            }
            Path::Why { crd: number } => Self::why_of(crd(number), soon(crd(number))),
            Path::Vel { crd: number } => {
                let of = crd(number);
                (Value::Velocity(Fix::of_f64(of.speed)), of.open)
            }
            Path::Pos { crd: number } => {
                let of = crd(number);
                let set = of.set.as_ref();
                let position = |coordinate: usize| {
                    let axis = set.and_then(|set| set.axes[coordinate]);
                    let zero = set.map_or(Fix::ZERO, |set| set.zero[coordinate]);
                    axis.map_or(0.0, |axis| (self.axes[axis].name() - zero).to_f64())
                };
                let name = Some((of_core, number));
                let left = |axis: &usize| self.axes[*axis].mode != Mode::Crd || self.axes[*axis].crd != name;
                let has_left = set.is_some_and(|set| set.axes.iter().flatten().any(left));
                let slack = |axis: &usize| (self.axes[*axis].slack + self.axes[*axis].late).to_f64();
                let slack = set.map_or(0.0, |set| set.axes.iter().flatten().map(slack).fold(0.0, f64::max));
                (Value::CrdPosition(std::array::from_fn(position), slack), has_left)
            }
            _ => (Value::None, true),
        }
    }
}
