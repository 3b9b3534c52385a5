//! What a FIFO does in the course of time.
use super::geometry::Position;
use super::speed::{Profile, limits, profile};
use super::{Entry, Frame};

/// External commands. Each acts at the instant of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// CrdStart: begins, or continues.
    Start,
    /// A smooth Stop.
    Stop,
    /// An abrupt one: its tick has the position of the tick so many ms before (SPEC 4). Effects
    /// reached in between have been executed.
    Abrupt(f64),
    /// SetOverride.
    Rate(f64),
    /// SetCrdStopDec, pulse/ms².
    StopDec(f64),
}

/// Why a coordinate system is at standstill.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// Its entries have run out.
    Done,
    /// The same at speed, or it has come to a delay at speed.
    Underrun,
    /// A Stop.
    Stopped,
}

/// It came to standstill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// ms.
    pub at: f64,
    /// Why.
    pub why: Why,
}

/// An interval of constant acceleration along a path, or of standstill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// ms.
    pub begin: f64,
    /// ms.
    pub ms: f64,
    /// Which entry it is a part of.
    pub entry: usize,
    /// Pulses of the path before it, at its begin.
    pub distance: f64,
    /// pulse/ms at its begin.
    pub speed: f64,
    /// pulse/ms².
    pub acc: f64,
}

/// All of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Course {
    /// In order, without overlap; between them it is at standstill.
    pub pieces: Vec<Piece>,
    /// When each effect was reached, ms, and which one it was.
    pub effects: Vec<(f64, usize)>,
    /// When each motion ended, ms.
    pub ends: Vec<f64>,
    /// Starts, ms, and whether they went on after a Stop.
    pub starts: Vec<(f64, bool)>,
    /// Rests.
    pub rests: Vec<Rest>,
}

impl Course {
    /// The piece in force; at a boundary the one that begins.
    fn piece(&self, at: f64) -> Option<&Piece> {
        let after = self.pieces.partition_point(|piece| piece.begin <= at);
        self.pieces[..after].last().filter(|piece| at < piece.begin + piece.ms)
    }

    /// Whether it runs: from a start to its standstill.
    pub fn runs(&self, at: f64) -> bool {
        let last = |instants: &mut dyn Iterator<Item = f64>| instants.filter(|instant| *instant <= at).last();
        let start = last(&mut self.starts.iter().map(|start| start.0));
        let rest = last(&mut self.rests.iter().map(|rest| rest.at));
        start.is_some_and(|start| rest.is_none_or(|rest| rest < start))
    }

    /// Path speed, pulse/ms.
    pub fn speed(&self, at: f64) -> f64 {
        self.piece(at).map_or(0.0, |piece| (piece.speed + piece.acc * (at - piece.begin)).max(0.0))
    }

    /// Pulses along the path up to an instant.
    pub fn distance(&self, at: f64) -> f64 {
        let begun = self.pieces.iter().take_while(|piece| piece.begin < at);
        begun.fold(0.0, |sum, piece| {
            let t = (at - piece.begin).min(piece.ms);
            sum + piece.speed * t + piece.acc * t * t / 2.0
        })
    }

    /// Where it is, if it has ever moved.
    pub fn position(&self, entries: &[Entry], at: f64) -> Option<Position> {
        let after = self.pieces.partition_point(|piece| piece.begin <= at);
        let piece = self.pieces[..after].iter().rfind(|piece| matches!(entries[piece.entry], Entry::Motion(..)))?;
        let Entry::Motion(geometry, _) = &entries[piece.entry] else { unreachable!() };
        let t = (at - piece.begin).min(piece.ms);
        let distance = piece.distance + piece.speed * t + piece.acc * t * t / 2.0;
        Some(geometry.at(distance.clamp(0.0, geometry.length())))
    }
}

/// State of a run.
struct Run<'a> {
    frame: &'a Frame,
    entries: &'a [Entry],
    course: Course,
    /// ms.
    now: f64,
    /// The entry in progress, and how much of it is done: pulses or ms.
    entry: usize,
    distance: f64,
    speed: f64,
    rate: f64,
    stop_dec: f64,
    runs: bool,
    /// After a Stop that was not the end.
    stopped: bool,
    /// A smooth Stop is in progress.
    brakes: bool,
    /// Effects before this entry have been executed.
    reported: usize,
}

impl Run<'_> {
    /// Whether a motion follows this entry before a delay does.
    fn goes_on(&self) -> bool {
        let next = self.entries[self.entry + 1..].iter().find(|entry| !entry.is_effect());
        matches!(next, Some(Entry::Motion(..)))
    }

    fn rest(&mut self, why: Why) {
        (self.runs, self.brakes, self.speed) = (false, false, 0.0);
        self.stopped = why == Why::Stopped;
        self.course.rests.push(Rest { at: self.now, why });
    }

    /// Goes on for up to `ms`; less where it ends. Pieces of the motion in progress.
    fn pieces(&mut self, profile: &Profile, until: f64) {
        for phase in profile.phases {
            if phase.ms == 0.0 {
                continue;
            }
            let ms = phase.ms.min(until - self.now);
            if ms <= 0.0 {
                return;
            }
            let (begin, distance, speed) = (self.now, self.distance, self.speed);
            self.course.pieces.push(Piece { begin, ms, entry: self.entry, distance, speed, acc: phase.acc });
            self.distance += speed * ms + phase.acc * ms * ms / 2.0;
            self.speed += phase.acc * ms;
            self.now += ms;
            if ms < phase.ms {
                return;
            }
        }
    }

    /// Until an instant, or until it is at standstill.
    fn run(&mut self, until: f64) {
        // An external command at an instant acts before the effects that the path reaches there.
        while self.runs && self.now < until {
            match self.entries.get(self.entry) {
                None => {
                    let why = if self.speed > 0.0 { Why::Underrun } else { Why::Done };
                    return self.rest(why);
                }
                Some(Entry::Effect(number) | Entry::Laser(number)) => {
                    let number = *number;
                    self.effect(number);
                }
                // What is before it was too short to brake in.
                Some(Entry::Delay(_)) if self.speed > 0.0 && !self.brakes => return self.rest(Why::Underrun),
                Some(Entry::Delay(ms)) => {
                    let left = f64::from(*ms) - self.distance;
                    let some = left.min(until - self.now);
                    let (begin, entry) = (self.now, self.entry);
                    let still = Piece { begin, ms: some, entry, distance: self.distance, speed: 0.0, acc: 0.0 };
                    self.course.pieces.push(still);
                    self.now += some;
                    self.speed = 0.0;
                    if some < left {
                        self.distance += some;
                        return;
                    }
                    (self.entry, self.distance) = (self.entry + 1, 0.0);
                }
                Some(Entry::Motion(geometry, rates)) => {
                    let left = geometry.length() - self.distance;
                    let mut limits = limits(self.frame, rates, self.rate);
                    if !self.goes_on() {
                        limits.end = 0.0;
                    }
                    let mut even = self.frame.even_ms;
                    if self.brakes {
                        // Down to 0 and no further, over whatever follows.
                        (limits.speed, limits.acc, limits.end, even) = (0.0, self.stop_dec, 0.0, 0.0);
                        let ms = self.speed / self.stop_dec;
                        if self.speed * ms / 2.0 < left {
                            let phase = super::speed::Phase { acc: -self.stop_dec, ms };
                            let none = super::speed::Phase { acc: 0.0, ms: 0.0 };
                            let from = self.now;
                            self.pieces(&Profile { phases: [phase, none, none], end: 0.0 }, until);
                            if until >= from + ms {
                                self.now = from + ms;
                                return self.rest(Why::Stopped);
                            }
                            return;
                        }
                    }
                    let profile = profile(self.speed, left, &limits, even);
                    let ends: f64 = self.now + profile.phases.iter().map(|phase| phase.ms).sum::<f64>();
                    self.pieces(&profile, until);
                    if ends > until {
                        return;
                    }
                    self.speed = profile.end;
                    self.course.ends.push(self.now);
                    (self.entry, self.distance) = (self.entry + 1, 0.0);
                }
            }
        }
    }

    /// What is reached at this instant without any time.
    fn reach(&mut self) {
        while let Some(Entry::Effect(number) | Entry::Laser(number)) =
            self.entries.get(self.entry).filter(|_| self.runs)
        {
            let number = *number;
            self.effect(number);
        }
    }

    /// Passes an effect. After a fall back only those of a laser are made again.
    fn effect(&mut self, number: usize) {
        if self.entry >= self.reported || matches!(self.entries[self.entry], Entry::Laser(_)) {
            self.course.effects.push((self.now, number));
        }
        self.entry += 1;
    }

    /// It is where it was when as many motions had ended, so far in that entry.
    fn fall_back(&mut self, (entry, distance, ends): (usize, f64, usize)) {
        self.reported = self.reported.max(self.entry);
        // In a delay it is at standstill anyway; one that has ended since is over.
        let waited = matches!(self.entries.get(entry), Some(Entry::Delay(_)));
        if !waited || self.entry != entry {
            (self.entry, self.distance) = if waited { (entry + 1, 0.0) } else { (entry, distance) };
            let is_motion = |entry: &Entry| matches!(entry, Entry::Motion(..));
            if let Some(ahead) = self.entries[self.entry..].iter().position(is_motion) {
                let (entry, distance) = (self.entry + ahead, if ahead == 0 { self.distance } else { 0.0 });
                self.course.pieces.push(Piece { begin: self.now, ms: 0.0, entry, distance, speed: 0.0, acc: 0.0 });
            }
        }
        self.course.ends.truncate(ends);
        self.rest(Why::Stopped);
    }

    fn command(&mut self, command: Command) {
        match command {
            Command::Start => {
                if !self.runs {
                    self.course.starts.push((self.now, self.stopped));
                    (self.runs, self.stopped) = (true, false);
                }
                self.brakes = false;
            }
            Command::Stop if self.runs && self.speed > 0.0 => self.brakes = true,
            Command::Stop => {
                if self.runs {
                    self.rest(Why::Stopped);
                }
            }
            Command::Abrupt(_) => unreachable!("it needs to know where it was"),
            Command::Rate(rate) => self.rate = rate,
            Command::StopDec(dec) => self.stop_dec = dec,
        }
    }
}

/// The course of entries under commands, whose instants are in ms and never decrease, until
/// `horizon`.
///
/// Everything is in the FIFO before the first start. A Stop in a BufDelay acts at once, and the
/// remainder of the delay is waited for after the next start.
pub fn course(frame: &Frame, entries: &[Entry], commands: &[(f64, Command)], horizon: f64) -> Course {
    let course = Course::default();
    let mut run = Run {
        frame,
        entries,
        course,
        now: 0.0,
        entry: 0,
        distance: 0.0,
        speed: 0.0,
        rate: 1.0,
        stop_dec: frame.acc,
        runs: false,
        stopped: false,
        brakes: false,
        reported: 0,
    };
    for &(at, command) in commands {
        if let Command::Abrupt(tick) = command {
            run.run(at - tick);
            run.reach();
            let published = (run.entry, run.distance, run.course.ends.len());
            run.run(at);
            run.now = at;
            if run.runs {
                run.fall_back(published);
            }
            continue;
        }
        run.run(at);
        run.now = at;
        run.command(command);
    }
    run.run(horizon);
    run.course
}

#[cfg(test)]
mod tests {
    use super::super::{Geometry, Rates};
    use super::*;

    fn line(from: f64, to: f64, speed: f64, acc: f64, end: f64) -> Entry {
        let geometry = Geometry::line([from, 0.0, 0.0, 0.0], [to, 0.0, 0.0, 0.0]);
        Entry::Motion(geometry, Rates { speed, acc, end })
    }

    const FRAME: Frame = Frame { speed: 100.0, acc: 100.0, even_ms: 0.0 };

    /// 10 ms up over 50, 95 ms at 10; then 10 pulses down from 10 to √80, in 10 − √80 ms.
    #[test]
    fn a_delay_that_is_reached_at_speed() {
        let fast = |from, to| line(from, to, 10.0, 1.0, 10.0);
        let entries = [fast(0.0, 1000.0), fast(1000.0, 1010.0), Entry::Effect(0), Entry::Delay(5), Entry::Effect(1)];
        let course = course(&FRAME, &entries, &[(0.0, Command::Start)], 1e9);
        let [Rest { at, why: Why::Underrun }] = course.rests[..] else { panic!("{:?}", course.rests) };
        assert!((at - (115.0 - 80f64.sqrt())).abs() < 1e-9, "{at}");
        assert_eq!(course.effects, [(at, 0)]);
    }

    /// Worked out by hand.
    #[test]
    fn a_corner_at_speed_a_delay_and_a_stop() {
        let entries = [
            Entry::Effect(0),
            line(0.0, 100.0, 10.0, 1.0, 10.0),
            Entry::Effect(1),
            line(100.0, 200.0, 10.0, 1.0, 10.0),
            Entry::Effect(2),
            Entry::Delay(7),
            line(200.0, 232.0, 10.0, 2.0, 0.0),
            Entry::Effect(3),
        ];
        // 10 ms up over 50, 5 ms at 10; 5 ms at 10, 10 ms down; 7 ms; 32 = 2·4²: 8 ms.
        let still = course(&FRAME, &entries, &[(1.0, Command::Start)], 100.0);
        assert_eq!(still.effects, [(1.0, 0), (16.0, 1), (31.0, 2), (46.0, 3)]);
        assert_eq!(still.rests, [Rest { at: 46.0, why: Why::Done }]);
        assert_eq!(still.ends, [16.0, 31.0, 46.0]);
        assert_eq!([still.speed(6.0), still.speed(13.0), still.speed(24.0), still.speed(35.0)], [5.0, 10.0, 7.0, 0.0]);
        assert_eq!(still.position(&entries, 16.0).unwrap()[0], 100.0);
        assert_eq!(still.position(&entries, 50.0).unwrap()[0], 232.0);
        // A Stop at 14 ms with 2 pulse/ms²: 20 pulses to the corner take 10 − √(100 − 80) over 2,
        // rest 5 ms after it.
        let commands =
            [(0.0, Command::StopDec(2.0)), (1.0, Command::Start), (14.0, Command::Stop), (30.0, Command::Start)];
        let stopped = course(&FRAME, &entries, &commands, 100.0);
        assert_eq!(stopped.rests[0], Rest { at: 19.0, why: Why::Stopped });
        assert!((stopped.effects[1].0 - (14.0 + (10.0 - 20f64.sqrt()) / 2.0)).abs() < 1e-12);
        // 5 pulses into the second: 95 left, with 1 pulse/ms² up and down: 2·√95.
        assert!((stopped.effects[2].0 - (30.0 + 2.0 * 95f64.sqrt())).abs() < 1e-12);
        assert_eq!(stopped.starts, [(1.0, false), (30.0, true)]);
        // An abrupt one at 18 ms, whose tick shows the place of 14: 20 pulses before the corner,
        // whose effect has been reached.
        let commands = [(1.0, Command::Start), (18.0, Command::Abrupt(4.0)), (30.0, Command::Start)];
        let stopped = course(&FRAME, &entries, &commands, 100.0);
        assert_eq!((stopped.rests[0].at, stopped.speed(17.0), stopped.speed(18.0)), (18.0, 10.0, 0.0));
        assert_eq!(
            (stopped.position(&entries, 18.0).unwrap()[0], stopped.position(&entries, 30.0).unwrap()[0]),
            (80.0, 80.0)
        );
        // From rest over 20 pulses it reaches √40 at the corner, and there the speeds of the second
        // line hold.
        let corner = 30.0 + 40f64.sqrt();
        assert_eq!(stopped.effects[..2], [(1.0, 0), (16.0, 1)]);
        assert!(stopped.ends.len() == 3 && (stopped.ends[0] - corner).abs() < 1e-9);
    }
}
