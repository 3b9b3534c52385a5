//! Gear against exact rational arithmetic on the whole numbers as given: random ratios, slopes,
//! reversals and new ratios, over 10⁹ pulses and more. GEARS asks for the long run.
use crate::chance::Chance;
use num_bigint::BigInt;
use num_rational::BigRational as Rational;
use num_traits::{Signed, ToPrimitive, Zero};
use servo::segment::follow::{
    Direction, FollowContext, FollowRun, FollowState, GearRatio, MasterPath, OutputActions, Setup, StartEvent,
};
use servo::segment::pt::SegmentStore;
use servo::units::{Exact, Ns, Pos};

const TICK: Ns = Ns(250_000);

fn of(x: impl Into<BigInt>) -> Rational {
    Rational::from_integer(x.into())
}

/// A position in pulses.
fn pulses(x: i64) -> Rational {
    Rational::new(x.into(), BigInt::from(1 << Pos::FRAC_BITS))
}

fn power(bits: i32) -> Rational {
    Rational::new(1.into(), BigInt::from(1) << bits)
}

/// The closed form.
struct Truth {
    /// Where the gear counts from: master's progress, and slave.
    master: Rational,
    slave: Rational,
    before: Rational,
    after: Rational,
    /// Length, until the master has been that far away.
    slope: Option<Rational>,
    both: bool,
    /// The furthest progress, of one direction.
    furthest: Option<Rational>,
}

impl Truth {
    fn progress(&mut self, to: &Rational) -> Rational {
        let furthest = match &self.furthest {
            Some(furthest) if !self.both && furthest > to => furthest.clone(),
            _ => to.clone(),
        };
        self.furthest = Some(furthest.clone());
        furthest
    }

    /// Slave and ratio with the master at `to`.
    fn go(&mut self, to: &Rational) -> (Rational, Rational) {
        let to = self.progress(to);
        let x = &to - &self.master;
        if let Some(slope) = self.slope.clone() {
            let change = (&self.after - &self.before) / (of(2) * &slope);
            if x.abs() < slope {
                let moved = &self.before * x.abs() + &change * &x * &x;
                let moved = if x.is_negative() { -moved } else { moved };
                return (&self.slave + moved, &self.before + change * of(2) * x.abs());
            }
            let moved = &self.before * &slope + &change * &slope * &slope;
            let (master, slave) = if x.is_negative() { (-slope, -moved) } else { (slope, moved) };
            self.master += master;
            self.slave += slave;
            self.slope = None;
        }
        (&self.slave + &self.after * (to - &self.master), self.after.clone())
    }

    fn again(&mut self, at: &Rational, (master, slave, slope): (i32, i32, i32)) {
        let (position, ratio) = self.go(at);
        let at = self.progress(at);
        (self.master, self.slave, self.before) = (at, position, ratio);
        self.after = Rational::new(slave.into(), master.into());
        self.slope = (slope != 0).then(|| of(slope));
    }
}

struct Bench {
    run: FollowRun,
    setup: Setup,
    store: SegmentStore,
    master: i64,
    now: Ns,
}

impl Bench {
    fn new(given: (i32, i32, i32), direction: Direction, origin: Exact, master: i64) -> Bench {
        let mut setup = Setup::POWER_ON;
        setup.direction = direction;
        setup.gear = Some(GearRatio::of(given.0, given.1, given.2).unwrap());
        let run = FollowRun::begin(&setup, origin, 0);
        let mut bench = Bench { run, setup, store: SegmentStore::new(), master, now: Ns(0) };
        assert_eq!(bench.go(master, false), FollowState::Running);
        bench
    }

    fn go(&mut self, to: i64, fast: bool) -> FollowState {
        assert!(!self.run.is_open(), "nothing is made ahead in gear");
        if !fast || self.run.fast_step(Pos(to)).is_none() {
            let path = MasterPath::line(self.now, TICK, Pos(self.master), Pos(to));
            let mut actions = OutputActions::default();
            let mut context = FollowContext::new(&mut self.setup, &self.store, |_, _| false, &mut actions);
            let state = self.run.step(&path, 0, &mut context, None);
            if state != FollowState::Running {
                return state;
            }
        }
        (self.master, self.now) = (to, Ns(self.now.0 + TICK.0));
        FollowState::Running
    }

    fn pos(&self) -> Rational {
        pulses(self.run.position().0.0)
    }

    fn again(&mut self, given: (i32, i32, i32)) {
        self.setup.gear = Some(GearRatio::of(given.0, given.1, given.2).unwrap());
        self.run.take_ratio();
        assert_eq!(self.go(self.master, true), FollowState::Running);
    }
}

fn draw(chance: &mut Chance) -> (i32, i32, i32) {
    loop {
        let number = |chance: &mut Chance| {
            let size = [10.0, 1e4, 2f64.powi(31)][chance.below(3) as usize];
            (chance.log(1.0, size) * chance.sign()) as i32
        };
        let slope = if chance.below(3) == 0 { 0 } else { chance.log(2.0, 1e6) as i32 };
        let given = (number(chance), if chance.below(20) == 0 { 0 } else { number(chance) }, slope);
        if given.0 != 0
            && given.1.unsigned_abs() / given.0.unsigned_abs() < 1000
            && GearRatio::of(given.0, given.1, slope).is_ok()
        {
            return given;
        }
    }
}

#[test]
fn random_gears_are_exact() {
    let gears: u32 = std::env::var("GEARS").map_or(400, |n| n.parse().unwrap());
    let mut chance = Chance::new(23);
    let (mut worst, mut engaged, mut on_slopes) = (0f64, 0, 0);
    for _ in 0..gears {
        let mut given = draw(&mut chance);
        let direction = [Direction::Both, Direction::Both, Direction::Up, Direction::Down][chance.below(4) as usize];
        let down = direction == Direction::Down;
        let start = (chance.below(1 << 40) as i64 - (1 << 39)) << 10;
        let origin = Exact(((chance.below(1 << 40) as i128) << 40) - (1 << 79));
        let mut bench = Bench::new(given, direction, origin, start);
        // Progress downwards is the position with its sign changed, on both sides of the gear.
        let sign = of(if down { -1 } else { 1 });
        let mut truth = Truth {
            master: pulses(start) * &sign,
            slave: Rational::new(origin.0.into(), BigInt::from(1) << 64) * &sign,
            before: Rational::zero(),
            after: Rational::new(given.1.into(), given.0.into()),
            slope: (given.2 != 0).then(|| of(given.2)),
            both: direction == Direction::Both,
            furthest: Some(pulses(start) * &sign),
        };
        // New ratios; what stays of them.
        let mut stays = Rational::zero();
        for _ in 0..60 {
            if chance.below(10) == 0 {
                stays += if truth.slope.is_some() { power(22) } else { power(47) };
                let at = pulses(bench.master) * &sign;
                given = draw(&mut chance);
                truth.again(&at, given);
                bench.again(given);
            }
            let far = [f64::from(given.2.max(2)), 1e3, 1e9][chance.below(3) as usize];
            let to = bench.master + (chance.log(1e-6, far) * chance.sign() * 2f64.powi(22)) as i64;
            if to.abs() > 1 << 60 || bench.run.position().0.0.abs() > 1 << 60 {
                break;
            }
            let fast = chance.below(2) == 0;
            let state = bench.go(to, fast);
            let (slave, ratio) = truth.go(&(pulses(to) * &sign));
            if slave.abs() > of(1i64 << 38) {
                break;
            }
            assert_eq!(state, FollowState::Running, "{given:?}");
            let error = (slave * &sign - bench.pos()).abs();
            let bound = if truth.slope.is_some() { power(16) } else { power(21) } + &stays;
            assert!(error <= bound, "{} off with {given:?}, {direction:?}", error.to_f64().unwrap());
            worst = worst.max(error.to_f64().unwrap());
            if truth.slope.is_some() {
                on_slopes += 1;
                assert!(ratio <= truth.before.clone().max(truth.after.clone()));
            } else {
                engaged += 1;
            }
        }
    }
    assert!(engaged > gears * 10 && on_slopes > gears * 5, "{engaged} {on_slopes}");
    eprintln!("worst {worst:e} pulse; {engaged} engaged, {on_slopes} on slopes");
}

/// 10⁹ pulses up and 2·10⁹ down in uneven steps, at a ratio without end: back at the start the
/// slave is where it began, to the bit, and at every multiple of the ratio it is on a whole pulse.
#[test]
fn nothing_drifts_over_a_billion_pulses() {
    let mut chance = Chance::new(5);
    let mut bench = Bench::new((7, 3, 0), Direction::Both, Exact(0), 0);
    for (to, count) in [(1_000_000_000i64, 20_000), (-1_000_000_000, 20_000), (0, 20_000)] {
        let from = bench.master;
        let by = (to << 22) - from;
        for step in 1..=count {
            let at = from + (by as i128 * step / count) as i64;
            let at = if step == count { at } else { at + (chance.below(1 << 24) as i64) };
            assert_eq!(bench.go(at, true), FollowState::Running);
        }
        let whole = to / 7 * 7;
        assert_eq!(bench.go(whole << 22, true), FollowState::Running);
        assert_eq!(bench.run.position().0, Pos((whole / 7 * 3) << 22), "at {whole}");
    }
    assert_eq!(bench.go(0, true), FollowState::Running);
    assert_eq!(bench.run.position().0, Pos(0));
}

/// At the end of the slope, on either side, it is over: a master that comes back moves the slave
/// with the whole ratio.
#[test]
fn a_slope_is_over_once_the_master_has_been_at_its_end() {
    for sign in [1, -1] {
        let mut bench = Bench::new((2, 1, 100), Direction::Both, Exact(0), 0);
        assert_eq!(bench.go(sign * (60 << 22), true), FollowState::Running);
        assert_eq!(bench.pos(), Rational::new((sign * 9).into(), 1.into()), "60²/400");
        assert_eq!(bench.go(sign * (100 << 22), true), FollowState::Running);
        assert_eq!(bench.pos(), of(sign * 25));
        // Back over the start and beyond: the whole ratio.
        assert_eq!(bench.go(sign * (-100 << 22), true), FollowState::Running);
        assert_eq!(bench.pos(), of(sign * (25 - 100)));
    }
}

/// GearStart waits for the crossing, with the ratio that was in force at GearStart.
#[test]
fn a_crossing_starts_it_exactly_there() {
    let mut setup = Setup::POWER_ON;
    setup.gear = Some(GearRatio::of(1, 3, 0).unwrap());
    setup.event = StartEvent::Pass { up: true, pos: 10 };
    let run = FollowRun::begin(&setup, Exact(0), 0);
    let mut bench = Bench { run, setup, store: SegmentStore::new(), master: 0, now: Ns(0) };
    bench.go(0, false);
    bench.go(9 << 22, true);
    assert_eq!(bench.pos(), of(0));
    bench.setup.gear = Some(GearRatio::of(1, 5, 0).unwrap());
    bench.go(14 << 22, true);
    assert_eq!(bench.pos(), of(12), "the crossing is at 10, between two ticks");
    bench.again((1, 5, 0));
    bench.go(15 << 22, true);
    assert_eq!(bench.pos(), of(17));
}
