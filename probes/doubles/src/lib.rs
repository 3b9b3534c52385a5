#![no_std]
#![forbid(unsafe_code)]
//! The thread's arithmetic in doubles, on random numbers of a fixed seed.
//!
//! In: nothing. Out: for each kind of arithmetic a hash of the bits of all its results
//! ([`hashes`]), and how many there were. Owns nothing; [`Room`] is the caller's. Cannot fail.
//!
//! `host/h743/tests/doubles.rs` compares the hashes of an x86 with those of the emulated board and
//! of the STM32H743 in emulation. A unit that rounds otherwise, a compiler that fuses a product
//! with a sum, or another library of functions gives others.
use core::fmt::Write;
use dispatcher::plan::asymmetric_s;
use dispatcher::plan::geometry::{Geometry, Position, pulses};
use dispatcher::plan::look_ahead::{Limits, LookAhead, Planned};
use dispatcher::plan::pvt::{DoubleDouble, FieldIndices, POINT_VALUES, Scratch, SplineScratch, TableDraft, TableKind};
use servo::laser::Power;
use servo::path::{MotionSpeeds, Plane};
use servo::segment::pvt::PointStore;
use servo::units::{Pos, StepLimit};

/// Kinds of arithmetic.
pub const NAMES: [&str; 6] = ["functions", "units", "geometry", "look-ahead", "tables", "S-curve"];

/// Motions that the look-ahead holds.
const MOTIONS: usize = 64;

/// Memory of the arithmetic.
pub struct Room {
    look: LookAhead<MOTIONS, MOTIONS>,
    spline: SplineScratch,
    points: PointStore,
}

impl Room {
    /// Empty.
    pub const fn new() -> Room {
        let limits = Limits { vel: [0.0; 4], acc: [0.0; 4], corner: 0.0 };
        Room { look: LookAhead::new(limits), spline: SplineScratch::new(), points: PointStore::new() }
    }
}

impl Default for Room {
    fn default() -> Room {
        Room::new()
    }
}

/// The hash of a kind's results, and how many words went into it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hash {
    /// FNV-1a over their bytes.
    pub value: u64,
    /// Results.
    pub count: u32,
}

impl Hash {
    const EMPTY: Hash = Hash { value: 0xcbf2_9ce4_8422_2325, count: 0 };

    fn byte(&mut self, byte: u8) {
        self.value = (self.value ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
    }

    fn word(&mut self, word: u64) {
        word.to_le_bytes().into_iter().for_each(|byte| self.byte(byte));
        self.count += 1;
    }

    fn double(&mut self, x: f64) {
        self.word(x.to_bits());
    }

    fn doubles<'a>(&mut self, all: impl IntoIterator<Item = &'a f64>) {
        all.into_iter().for_each(|x| self.double(*x));
    }

    /// What has no number of its own: its fields as text, of which doubles have as many digits as
    /// their bits need.
    fn text(&mut self, what: &impl core::fmt::Debug) {
        let _ = write!(self, "{what:?}");
        self.count += 1;
    }
}

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        text.bytes().for_each(|byte| self.byte(byte));
        Ok(())
    }
}

/// Random numbers: xorshift64*, in whole numbers alone.
struct Chance(u64);

impl Chance {
    fn word(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// From 0 to 1, with all 53 bits.
    fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A whole number below a bound, of either sign.
    fn whole(&mut self, below: i32) -> i32 {
        (self.word() % (2 * below as u64)) as i32 - below
    }

    /// A double of any size between 2⁻³⁰ and 2³⁰, of either sign.
    fn any(&mut self) -> f64 {
        let exponent = 1023 - 30 + self.word() % 60;
        const SIGN_AND_FRACTION: u64 = 0x800f_ffff_ffff_ffff;
        f64::from_bits(self.word() & SIGN_AND_FRACTION | exponent << 52)
    }
}

/// All kinds, in the order of [`NAMES`].
pub fn hashes(room: &mut Room) -> [Hash; NAMES.len()] {
    [functions(), units(), geometry(), look_ahead(room), tables(room), s_curve()]
}

/// The functions that the thread calls, and the four operations.
fn functions() -> Hash {
    let (mut chance, mut hash) = (Chance(0x5eed_0001), Hash::EMPTY);
    for _ in 0..2000 {
        let (a, b, c) = (chance.any(), chance.any(), chance.any());
        hash.doubles(&[a + b, a - b, a * b, a / b, a * b + c, a % b]);
        hash.doubles(&[libm::sqrt(libm::fabs(a)), libm::hypot(a, b), libm::atan2(a, b), libm::fma(a, b, c)]);
        hash.doubles(&[libm::floor(a), libm::ceil(a), libm::rint(a), libm::sin(a), libm::cos(b)]);
        let (x, y) = (a as f32, b as f32);
        hash.doubles(&[x.into(), (x * y).into(), libm::sqrtf(libm::fabsf(x)).into(), (x / y).into()]);
        let (d, e) = (DoubleDouble::between(a, b), DoubleDouble::between(b, c));
        hash.text(&[d.plus(e), d.minus(e), d.times(e), d.over(e), d.times(d).sqrt()]);
    }
    hash
}

/// Users' units to the tick's, and back.
fn units() -> Hash {
    let (mut chance, mut hash) = (Chance(0x5eed_0002), Hash::EMPTY);
    for _ in 0..2000 {
        let x = chance.any();
        hash.double(pulses(Pos(chance.word().cast_signed() >> (chance.word() % 40))));
        hash.word(x as i64 as u64);
        hash.word((x as u32).into());
        hash.double(chance.word().cast_signed() as f64);
        let power = Power::admit(chance.between(0.0, 2000.0).to_bits());
        hash.text(&power.map(|power| power.raw() as f64 / 1024.0));
        let (vel, acc, end) = (chance.between(1e-6, 3e4), chance.between(1e-6, 3e4), chance.between(0.0, 3e4));
        hash.text(&MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()));
    }
    hash
}

fn position(chance: &mut Chance) -> Position {
    [0; 4].map(|_| f64::from(chance.whole(1 << 20)) + chance.unit())
}

/// A motion of any kind from a position; a refusal has numbers too.
fn motion(chance: &mut Chance, from: &Position, reach: i32) -> Result<Geometry, dispatcher::plan::geometry::Refused> {
    let plane = [Plane::Xy, Plane::Yz, Plane::Zx][(chance.word() % 3) as usize];
    let axes = plane.coordinates();
    let at = axes.map(|axis| from.get(axis).copied().unwrap_or(0.0));
    let ccw = chance.word() & 1 == 0;
    let to = at.map(|x| libm::rint(x) as i32 + chance.whole(reach));
    match chance.word() % 6 {
        0 => Geometry::planar(from, to),
        1 => Geometry::line(from, from.map(|x| libm::rint(x) as i32 + chance.whole(reach))),
        // A full circle, from a target that is the start.
        2 => {
            let start = axes.map(|axis| from.get(axis).map_or(0, |x| *x as i32));
            Geometry::arc_centre(from, plane, start, [chance.between(-9e3, 9e3), chance.between(-9e3, 9e3)], ccw)
        }
        // The centre left or right of the middle of the chord.
        3 => {
            let chord = [0, 1].map(|n| f64::from(to[n]) - at[n]);
            let by = chance.between(-2.0, 2.0);
            let centre = [chord[0] / 2.0 - by * chord[1], chord[1] / 2.0 + by * chord[0]];
            Geometry::arc_centre(from, plane, to, centre, ccw)
        }
        4 => Geometry::arc_centre(from, plane, to, [chance.any(), chance.any()], ccw),
        _ => {
            let half = libm::hypot(f64::from(to[0]) - at[0], f64::from(to[1]) - at[1]) / 2.0;
            let sign = if chance.word() & 1 == 0 { 1.0 } else { -1.0 };
            Geometry::arc_radius(from, plane, to, sign * half * chance.between(0.98, 4.0), ccw)
        }
    }
}

/// Lines and arcs.
fn geometry() -> Hash {
    let (mut chance, mut hash) = (Chance(0x5eed_0003), Hash::EMPTY);
    for _ in 0..1500 {
        let from = position(&mut chance);
        let reach = 1 << (2 + chance.word() % 18);
        match motion(&mut chance, &from, reach) {
            Ok(geometry) => {
                hash.double(geometry.length);
                hash.doubles(geometry.tangents.iter().flatten().chain(&geometry.end));
                hash.double(geometry.round.map_or(0.0, |(radius, _)| radius));
                (0..4).for_each(|coordinate| hash.double(geometry.share(coordinate)));
                hash.text(&geometry.entry(MotionSpeeds::NONE));
            }
            Err(refused) => hash.text(&refused),
        }
    }
    hash
}

/// Paths through the look-ahead.
fn look_ahead(room: &mut Room) -> Hash {
    let (mut chance, mut hash) = (Chance(0x5eed_0004), Hash::EMPTY);
    let taken = |hash: &mut Hash, Planned { along, ms, entries_after }: Planned| {
        hash.double(ms);
        hash.word(along.vel_bits());
        hash.word(entries_after.into());
        hash.text(&along);
    };
    for _ in 0..12 {
        room.look.clear();
        room.look.set_limits(Limits {
            vel: [0; 4].map(|_| chance.between(10.0, 900.0)),
            acc: [0; 4].map(|_| chance.between(0.1, 20.0)),
            corner: chance.between(0.1, 10.0),
        });
        let mut from = [0.0; 4];
        let reach = 1 << (5 + chance.word() % 8);
        for _ in 0..150 {
            let Ok(geometry) = motion(&mut chance, &from, reach) else { continue };
            from = geometry.end;
            if room.look.is_full()
                && let Some(planned) = room.look.take(true)
            {
                taken(&mut hash, planned);
            }
            room.look.push_motion(&geometry, chance.between(1.0, 1000.0), chance.between(0.1, 30.0));
            if chance.word().is_multiple_of(40) {
                room.look.stop();
            }
            while let Some(planned) = room.look.take(false) {
                taken(&mut hash, planned);
            }
        }
        while let Some(planned) = room.look.take(true) {
            taken(&mut hash, planned);
        }
    }
    hash
}

/// PVT tables of all five descriptions.
fn tables(room: &mut Room) -> Hash {
    const FIELDS: FieldIndices = FieldIndices { count: 2, whole: 4, point: 10 };
    const POINTS: i32 = 60;
    let (mut chance, mut hash) = (Chance(0x5eed_0005), Hash::EMPTY);
    for table in 0..50 {
        let kind = match table % 5 {
            0 => TableKind::Pvt,
            1 => TableKind::PvtEx,
            2 => TableKind::Complete { vel_begin: chance.between(-5.0, 5.0), vel_end: chance.between(-5.0, 5.0) },
            3 => TableKind::Percent { vel_begin: 0.0 },
            _ => TableKind::Continuous { time_begin: chance.between(0.0, 50.0) },
        };
        let mut scratch = Scratch::new(&mut room.spline, &room.points);
        let Ok(mut draft) = TableDraft::begin(kind, POINTS, FIELDS, StepLimit::FULL_SCALE, true, &mut scratch) else {
            continue;
        };
        let (mut time, mut pos) = (chance.between(0.0, 10.0), chance.between(-1e6, 1e6));
        for _ in 0..POINTS {
            let vel = chance.between(-20.0, 20.0);
            let values: [f64; POINT_VALUES] = match kind {
                TableKind::Continuous { .. } => {
                    let rate = chance.between(0.5, 5.0);
                    [pos, 0.0, chance.between(0.0, 100.0), chance.between(5.0, 90.0), rate, rate * 1.5]
                }
                TableKind::Percent { .. } => [time, pos, chance.between(0.0, 100.0), 0.0, 0.0, 0.0],
                _ => [time, pos, vel, vel + chance.between(-1.0, 1.0), 0.0, 0.0],
            };
            match draft.point(&values, &mut scratch) {
                Ok(answer) => hash.double(answer),
                Err(refused) => hash.text(&refused),
            }
            time += chance.between(5.0, 90.0);
            pos += chance.between(20.0, 900.0);
        }
        let Some(Ok(sealed)) = draft.finish(&mut scratch) else { continue };
        if let Some(words) = sealed.header().admit() {
            words.into_iter().for_each(|word| hash.word(word.into()));
        }
        for index in 0..sealed.points() {
            let words = sealed.point(&scratch, index).unwrap_or_default();
            words.into_iter().for_each(|word| hash.word(word.into()));
        }
    }
    hash
}

/// Segments of FollowEx.
fn s_curve() -> Hash {
    let (mut chance, mut hash) = (Chance(0x5eed_0006), Hash::EMPTY);
    for _ in 0..2000 {
        let (begin, end, q) = (chance.between(-4.0, 4.0), chance.between(-4.0, 4.0), chance.unit());
        let wanted = chance.between(begin.min(end), begin.max(end));
        match asymmetric_s::share(begin, end, q, wanted) {
            Ok(x) => {
                hash.doubles(&[x, asymmetric_s::mean(begin, end, q, x)]);
                asymmetric_s::corners(begin, end, q, x).iter().for_each(|(at, mean)| hash.doubles([at, mean]));
            }
            Err((low, high)) => hash.doubles(&[low, high]),
        }
    }
    hash
}
