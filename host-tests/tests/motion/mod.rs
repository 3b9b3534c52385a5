//! Programs run through the client and the virtual controller under a trace, and what they must
//! give, in exact rational numbers.
#![allow(dead_code, reason = "each test file takes what it needs")]
use client::{Answer, Call, Client, Observer, Options};
use num_rational::Ratio;
use protocol::command::*;
use servo::units::Pos;
use std::sync::{Arc, Mutex};
use trace::{Item, Reader, Row};
use virtual_board::{Board, Config, VirtualLink, share};

/// An exact number.
pub type Rational = Ratio<i128>;

/// A whole number.
pub fn whole(x: i64) -> Rational {
    Rational::from_integer(x.into())
}

/// A double, exactly.
pub fn of(x: f64) -> Rational {
    let (bits, sign) = (x.abs().to_bits(), if x < 0.0 { -1 } else { 1 });
    if bits == 0 {
        return whole(0);
    }
    let (exponent, mantissa) = ((bits >> 52) as i32 - 1075, (bits & ((1 << 52) - 1) | 1 << 52) as i128);
    let power = Rational::from_integer(2).pow(exponent);
    Rational::from_integer(sign * mantissa) * power
}

struct Watch(Vec<Answer>);

impl Observer for Watch {
    fn answered(&mut self, answer: Answer) -> client::Result<()> {
        self.0.push(answer);
        Ok(())
    }
}

/// A program that has run.
pub struct Run {
    pub tick_us: u32,
    pub rows: Vec<Row>,
    pub answers: Vec<Answer>,
}

/// The rounding of a knot's position to the fixed point, 2⁻²² pulse.
pub fn rounded(x: Rational) -> i64 {
    let scaled = x * Rational::from_integer(1 << Pos::FRAC_BITS);
    let half = Rational::new(1, 2);
    (if scaled >= whole(0) { (scaled + half).floor() } else { (scaled - half).ceil() }).to_integer() as i64
}

impl Run {
    /// The place of the instant `ms` after a start at script time 0, whose motion begins at row 1.
    fn place(&self, ms: f64) -> usize {
        let ticks = ms * 1000.0 / f64::from(self.tick_us);
        assert!((ticks - ticks.round()).abs() < 1e-9, "{ms} ms is no tick");
        ticks.round() as usize + 1
    }

    /// Planned position of the traced axis with this index.
    pub fn pos(&self, axis: usize, ms: f64) -> Pos {
        self.rows[self.place(ms)].axes[axis].pos
    }

    /// Planned velocity, pulse/ms.
    pub fn vel(&self, axis: usize, ms: f64) -> f64 {
        let v = self.rows[self.place(ms)].axes[axis].vel;
        v.m as f64 * 2f64.powi(-i32::from(v.e))
    }

    /// The tick before the one at `ms`: there an abrupt Stop at that time leaves an axis.
    pub fn before(&self, ms: i64) -> Rational {
        whole(ms) - Rational::new(self.tick_us.into(), 1000)
    }

    /// Where the axis ended.
    pub fn end(&self, axis: usize) -> Pos {
        self.rows.last().unwrap().axes[axis].pos
    }

    /// Instants of the rows from a start at script time 0 on, ms.
    pub fn instants(&self) -> impl Iterator<Item = (usize, Rational)> + '_ {
        (1..self.rows.len()).map(|row| (row, Rational::new((row as i128 - 1) * i128::from(self.tick_us), 1000)))
    }

    /// Every row of an axis is where `expected` says, within 2⁻¹⁶ pulse.
    pub fn is(&self, axis: usize, what: &str, expected: impl Fn(Rational) -> Rational) {
        let bound = Rational::new(1, 65536);
        for (row, ms) in self.instants() {
            let found = exact(self.rows[row].axes[axis].pos);
            let expected = expected(ms);
            let off = if found > expected { found - expected } else { expected - found };
            assert!(off <= bound, "{what}: at {ms} ms {found} instead of {expected}");
        }
    }

    /// Replies to a command, in order.
    pub fn replies<R: Request>(&self) -> Vec<R::Reply> {
        self.answers.iter().filter_map(|answer| answer.reply::<R>()).map(|(reply, _)| reply).collect()
    }

    /// Items of the replies to a command, in order.
    pub fn items<R: Request>(&self) -> Vec<R::ReplyItem> {
        self.answers.iter().filter_map(|answer| answer.reply::<R>()).flat_map(|(_, items)| items).collect()
    }
}

/// A position, exactly.
pub fn exact(pos: Pos) -> Rational {
    Rational::new(pos.0.into(), 1 << Pos::FRAC_BITS)
}

/// Runs a program at this tick under a trace of the first axes, which have their servos on. Nothing
/// may be refused and nothing may be late.
pub fn run(tick_us: u32, axes: u32, calls: Vec<Call>) -> Run {
    run_on(0, tick_us, axes, calls)
}

/// The same in a profile of another number.
pub fn run_on(profile: u8, tick_us: u32, axes: u32, calls: Vec<Call>) -> Run {
    let board = share(Board::new(Config { tick_us, profile, ..Config::default() }));
    let client = Client::open(Box::new(VirtualLink::new(board)), Options::default()).unwrap();
    let rows = Arc::new(Mutex::new(Vec::new()));
    let theirs = Arc::clone(&rows);
    let mut reader = Reader::new();
    client.trace_to(move |bytes| {
        let mut kept = theirs.lock().unwrap();
        reader
            .feed(bytes, |item| {
                if let Item::Row(row) = item {
                    kept.push(row);
                }
                Ok(())
            })
            .unwrap();
    });
    let traced = (1u64 << axes) - 1;
    let mut all =
        vec![Call::of(Trace { every: 1.into(), axes: traced.into(), lasers: 0, crds: 0, over_link: 0, edges: 0 })];
    for axis in 1..=axes as i16 {
        all.push(Call::of(AxisOn { core: 1.into(), axis: axis.into() }));
        all.push(Call::of(LmtsOff { core: 1.into(), axis: axis.into(), limit_type: (-1).into() }));
    }
    all.extend(calls);
    all.extend([sleep(2.0), Call::of(Trace::default())]);
    let mut watch = Watch(Vec::new());
    let summary = client.run(all, true, &mut watch).unwrap();
    assert_eq!(summary.failed, None);
    client.sleep(std::time::Duration::from_millis(50)).unwrap();
    let rows = rows.lock().unwrap().clone();
    Run { tick_us, rows, answers: watch.0 }
}

pub fn sleep(ms: f64) -> Call {
    Call::of(Sleep { ns: ((ms * 1e6).round() as u64).into() })
}

pub fn wait(mask: i32) -> Call {
    Call::of(WaitStop { core: 1.into(), axes: mask.into(), crds: 0.into() })
}

/// Stops these axes, those in `abrupt` at once.
pub fn stop(mask: i32, abrupt: i32) -> Call {
    Call::of(Stop { core: 1.into(), mask: mask.into(), option: abrupt.into(), form: 0 })
}

/// An axis jogs at `vel` pulse/ms, reached with `acc` pulse/ms².
pub fn jog(axis: i16, vel: f64, acc: f64) -> Vec<Call> {
    let (core, profile) = (1.into(), axis.into());
    vec![
        Call::of(PrfJog { core, profile }),
        Call::of(SetJogPrm { core, profile, acc: acc.into(), dec: acc.into(), smooth: 0.0.into() }),
        Call::of(SetVel { core, profile, vel: vel.into() }),
        update(1 << (axis - 1)),
    ]
}

/// Another velocity of a jog.
pub fn speed(axis: i16, vel: f64) -> Vec<Call> {
    vec![Call::of(SetVel { core: 1.into(), profile: axis.into(), vel: vel.into() }), update(1 << (axis - 1))]
}

pub fn update(mask: i32) -> Call {
    Call::of(Update { core: 1.into(), mask: mask.into() })
}

/// Where a jog that starts at 0 is.
pub fn jogged(vel: f64, acc: f64) -> impl Fn(Rational) -> Rational {
    let (v, a) = (of(vel), of(acc));
    move |t| {
        let ramp = v / a;
        if t < whole(0) {
            whole(0)
        } else if t < ramp {
            a * t * t / whole(2)
        } else {
            v * v / (a * whole(2)) + v * (t - ramp)
        }
    }
}

pub fn follow(axis: i16, master: i16, dir: i16) -> Vec<Call> {
    let (core, profile) = (1.into(), axis.into());
    vec![
        Call::of(PrfFollow { core, profile, dir: dir.into() }),
        Call::of(SetFollowMaster {
            core,
            profile,
            master_index: master.into(),
            master_type: 2.into(),
            master_item: 0.into(),
        }),
    ]
}

/// A datum of Follow: end of the master, end of the slave, type.
pub type Datum = (i32, f64, i16);

pub fn follow_data(axis: i16, fifo: i16, of: &[Datum]) -> Vec<Call> {
    let entry = |&(master, slave, kind): &Datum| {
        Call::of(FollowData {
            core: 1.into(),
            profile: axis.into(),
            master_segment: master.into(),
            slave_segment: slave.into(),
            kind: kind.into(),
            fifo: fifo.into(),
        })
    };
    of.iter().map(entry).collect()
}

pub fn follow_ex(axis: i16, master: i16, dir: i16) -> Vec<Call> {
    let (core, profile) = (1.into(), axis.into());
    vec![
        Call::of(PrfFollowEx { core, profile, dir: dir.into() }),
        Call::of(SetFollowMasterEx {
            core,
            profile,
            master_index: master.into(),
            master_type: 2.into(),
            master_item: 0.into(),
        }),
    ]
}

/// A datum of FollowEx: end of the master, end of the slave, type, percent.
pub type Shaped = (f64, f64, i16, i16);

pub fn shaped_data(axis: i16, fifo: i16, of: &[Shaped]) -> Vec<Call> {
    let entry = |&(master, slave, kind, percent): &Shaped| {
        Call::of(FollowDataPercentEx {
            core: 1.into(),
            profile: axis.into(),
            master_segment: master.into(),
            slave_segment: slave.into(),
            kind: kind.into(),
            percent: percent.into(),
            fifo: fifo.into(),
        })
    };
    of.iter().map(entry).collect()
}

pub fn follow_loops(axis: i16, count: i32) -> Call {
    Call::of(SetFollowLoop { core: 1.into(), profile: axis.into(), loop_count: count.into() })
}

pub fn follow_start(mask: i32, option: i32) -> Call {
    Call::of(FollowStart { core: 1.into(), mask: mask.into(), option: option.into() })
}

pub fn follow_switch(mask: i32) -> Call {
    Call::of(FollowSwitch { core: 1.into(), mask: mask.into() })
}

pub fn follow_event(axis: i16, event: i16, way: i16, pos: i32) -> Call {
    Call::of(SetFollowEvent {
        core: 1.into(),
        profile: axis.into(),
        event: event.into(),
        master_dir: way.into(),
        pos: pos.into(),
    })
}

pub fn follow_space(axis: i16, fifo: i16) -> Call {
    Call::of(FollowSpace { core: 1.into(), profile: axis.into(), fifo: fifo.into() })
}

/// One pass of a FIFO: the slave over the master's progress (SPEC 5: segment types as in PT,
/// percent as in PVT).
pub struct Curve {
    segments: Vec<Segment>,
}

struct Segment {
    from: (Rational, Rational),
    to: (Rational, Rational),
    ratios: (Rational, Rational),
    percent: Rational,
}

impl Curve {
    /// From data as it was sent, and the ratio at which a first CONTINUE segment starts.
    pub fn new(of_data: &[Shaped], continued: Rational) -> Curve {
        let mut from = (whole(0), whole(0));
        let mut ratio = whole(0);
        let mut segments = Vec::new();
        for (index, &(master, slave, kind, percent)) in of_data.iter().enumerate() {
            let to = (of(master), of(slave));
            let mean = (to.1 - from.1) / (to.0 - from.0);
            if index == 0 && kind == 3 {
                ratio = continued;
            }
            let ratios = match kind {
                1 => (mean, mean),
                2 => (whole(2) * mean, whole(0)),
                _ => (ratio, whole(2) * mean - ratio),
            };
            segments.push(Segment { from, to, ratios, percent: whole(percent.into()) });
            (from, ratio) = (to, ratios.1);
        }
        Curve { segments }
    }

    /// Data of Follow.
    pub fn plain(of_data: &[Datum], continued: Rational) -> Curve {
        let shaped: Vec<Shaped> = of_data.iter().map(|&(m, s, kind)| (f64::from(m), s, kind, 0)).collect();
        Curve::new(&shaped, continued)
    }

    /// Displacements of a pass.
    pub fn ends(&self) -> (Rational, Rational) {
        self.segments.last().unwrap().to
    }

    /// Ratio at the end of a pass.
    pub fn end_ratio(&self) -> Rational {
        self.segments.last().unwrap().ratios.1
    }

    /// Where the slave is, and its ratio, at a progress inside the pass.
    pub fn at(&self, progress: Rational) -> (Rational, Rational) {
        let segment = self.segments.iter().find(|s| progress < s.to.0).or(self.segments.last()).unwrap();
        let Segment { from, to, ratios: (r0, r1), percent } = segment;
        let length = to.0 - from.0;
        let (tau, k) = ((progress - from.0) / length, percent / whole(200));
        let rest = whole(1) - tau;
        let slope = (r1 - r0) / (whole(1) - k);
        let (slave, ratio) = if tau < k {
            (r0 * tau + slope * tau * tau * tau / (whole(6) * k), r0 + slope * tau * tau / (whole(2) * k))
        } else if rest < k {
            let mean = (to.1 - from.1) / length;
            (mean - r1 * rest + slope * rest * rest * rest / (whole(6) * k), r1 - slope * rest * rest / (whole(2) * k))
        } else {
            let held = tau - k;
            let begin = r0 + slope * k / whole(2);
            let first = r0 * k + slope * k * k / whole(6);
            (first + begin * held + slope * held * held / whole(2), begin + slope * held)
        };
        (from.1 + slave * length, ratio)
    }

    /// Where the slave is after a progress of so many passes and a part, at most `passes` (0: for
    /// ever).
    pub fn looped(&self, progress: Rational, passes: i128) -> Rational {
        if progress < whole(0) {
            return whole(0);
        }
        let (length, way) = self.ends();
        let done = (progress / length).floor();
        if passes != 0 && done >= Rational::from_integer(passes) {
            return way * Rational::from_integer(passes);
        }
        way * done + self.at(progress - done * length).0
    }
}
