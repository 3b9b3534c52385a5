//! One entry of a FIFO: checked, packed into 32 bytes, and what is read from it.
//!
//! In: targets in pulses of the coordinate system, the bits of the user's doubles. Out: an
//! [`PathEntry`], which only the constructors here can make. Fails: with the rule that the datum
//! breaks, [`Refused`].
//!
//! Word 7 begins with the kind in its top byte. A line in X and Y has both targets in words 0 and 1
//! and the user's doubles after them; of velEnd, the top byte (one of four) is kept in two bits.
//! Other motions have their geometry in words 0–3. A line has four targets; an arc has two and the
//! bits of its sweep; a full circle has the centre from the start, twice 64 bits. Their speeds are
//! in the remaining bits: synVel in 44, synAcc and velEnd in 38. So the relative errors are 2⁻³⁹
//! and 2⁻³³: less than a ns over 10 min of path, 2⁻¹⁶ pulse on ramps of 2¹⁷ pulses. A line in all
//! coordinates has its [`FixedRamp`] above the kind.
use super::pack::{float, pack, unpack};
use crate::math::float::Float;
use crate::segment::ramp::{Accel, Speed};
use crate::units::{Axis, DoGroup, StepLimit};

/// An admitted entry, 32 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PathEntry([u32; 8]);

/// Why an entry is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// NaN or infinite.
    NotFinite,
    /// Below 0.
    Negative,
    /// A speed or acceleration of 0, or too small to be distinguished from it (below 2⁻²⁰).
    TooSmall,
    /// A speed or acceleration above 32768 (pulse/ms, pulse/ms²).
    BeyondRange,
    /// Not more than 0 or more than half a turn, or less than 2⁻⁵⁰ turn.
    Sweep,
    /// A centre on the start, nearer than 2⁻¹⁰ pulse, or 2³¹ pulses away.
    Centre,
}

/// The plane of an arc: its first and second coordinate. Counterclockwise is from the first to the
/// second.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plane {
    /// X, Y, seen from +Z.
    Xy,
    /// Y, Z, seen from +X.
    Yz,
    /// Z, X, seen from +Y.
    Zx,
}

impl Plane {
    /// Indices of its coordinates among X, Y, Z, A.
    pub const fn coordinates(self) -> [usize; 2] {
        match self {
            Plane::Xy => [0, 1],
            Plane::Yz => [1, 2],
            Plane::Zx => [2, 0],
        }
    }
}

/// Whether a plan needs the acceleration of a line all along it: the corners at its ends have room
/// only because it changes its speed so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FixedRamp {
    /// It does not: both directions have room.
    None,
    /// It accelerates.
    Up,
    /// It brakes.
    Down,
}

/// Speeds along a motion, as the bits of doubles. None is negative: the sign of `vel` tells a
/// [`FixedRamp`], that of `acc` one down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MotionSpeeds {
    vel: u64,
    acc: u64,
    end: u64,
}

/// The sign of a double.
const SIGN: u64 = 1 << 63;

/// Mantissas of synVel, and of synAcc and velEnd.
const VEL_BITS: u32 = 38;
const RATE_BITS: u32 = 32;

/// A double from `least` to 2¹⁵.
fn within(bits: u64, least: i32) -> Result<u64, Refused> {
    const SPEED_MAX_BITS: u64 = (1023 + 15) << 52;
    if bits << 1 == 0 {
        return if least < SPEED_MIN_LOG2 { Ok(0) } else { Err(Refused::TooSmall) };
    }
    if bits & 0x7ff << 52 == 0x7ff << 52 {
        return Err(Refused::NotFinite);
    }
    if bits >> 63 == 1 {
        return Err(Refused::Negative);
    }
    if bits > SPEED_MAX_BITS {
        return Err(Refused::BeyondRange);
    }
    if bits >= ((1023 + least) as u64) << 52 {
        return Ok(bits);
    }
    if least < SPEED_MIN_LOG2 { Ok(0) } else { Err(Refused::TooSmall) }
}

/// The lowest speed and acceleration, and the lowest velEnd that is not 0, as powers of two.
const SPEED_MIN_LOG2: i32 = -20;
const END_SPEED_MIN_LOG2: i32 = -31;
/// Top bytes of doubles from 2⁻³¹ to 2¹⁵, and of 0.
const END_TOP_BYTES: [u64; 4] = [0, 0x3e, 0x3f, 0x40];

impl MotionSpeeds {
    /// No motion.
    pub const NONE: MotionSpeeds = MotionSpeeds { vel: 0, acc: 0, end: 0 };

    /// From the bits of synVel and velEnd (pulse/ms) and synAcc (pulse/ms²): 2⁻²⁰ ≤ synVel, synAcc
    /// ≤ 2¹⁵, velEnd from 0 to 2¹⁵; below 2⁻³¹ it is 0.
    pub fn admit(vel: u64, acc: u64, end: u64) -> Result<MotionSpeeds, Refused> {
        Ok(MotionSpeeds {
            vel: within(vel, SPEED_MIN_LOG2)?,
            acc: within(acc, SPEED_MIN_LOG2)?,
            end: within(end, END_SPEED_MIN_LOG2)?,
        })
    }

    /// The same with a ramp; only lines keep it.
    pub fn with_ramp(self, ramp: FixedRamp) -> MotionSpeeds {
        let (is_fixed, is_down) = match ramp {
            FixedRamp::None => (0, 0),
            FixedRamp::Up => (SIGN, 0),
            FixedRamp::Down => (SIGN, SIGN),
        };
        MotionSpeeds { vel: self.vel & !SIGN | is_fixed, acc: self.acc & !SIGN | is_down, end: self.end }
    }

    /// See [`FixedRamp`].
    pub(super) fn ramp(self) -> FixedRamp {
        match (self.vel >= SIGN, self.acc >= SIGN) {
            (false, _) => FixedRamp::None,
            (true, false) => FixedRamp::Up,
            (true, true) => FixedRamp::Down,
        }
    }

    /// Speed, pulse/ms, as the bits of a double.
    pub fn vel_bits(self) -> u64 {
        self.vel & !SIGN
    }

    /// Speed, pulse/ms.
    pub(super) fn vel(self) -> Float {
        float(self.vel & !SIGN)
    }

    /// Acceleration, pulse/ms².
    pub(super) fn acc(self) -> Float {
        float(self.acc & !SIGN)
    }

    /// Speed at the end, pulse/ms.
    pub(super) fn end(self) -> Float {
        float(self.end)
    }
}

/// The sweep of an arc.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sweep {
    turns: u64,
    /// It is more than half a turn by its long form.
    pub(super) long: bool,
    /// Counterclockwise.
    pub(super) ccw: bool,
}

impl Sweep {
    /// `turns` are the bits of a double in (0, ½]: the sweep; for a `long` arc the remainder to the
    /// full turn.
    pub fn admit(turns: u64, long: bool, ccw: bool) -> Result<Sweep, Refused> {
        const SWEEP_MAX_BITS: u64 = 0x3FE0_0000_0000_0000;
        const SWEEP_MIN_BITS: u64 = (1023 - 50) << 52;
        if (SWEEP_MIN_BITS..=SWEEP_MAX_BITS).contains(&turns) {
            Ok(Sweep { turns, long, ccw })
        } else {
            Err(Refused::Sweep)
        }
    }

    /// Half the turns given to the constructor: the angle between chord and tangent, or its
    /// supplement.
    pub(super) fn half(self) -> Float {
        float(self.turns).scale(-1)
    }

    /// The whole sweep in turns.
    pub(super) fn turns(self) -> Float {
        let turns = float(self.turns);
        if self.long { Float::ONE.sub(turns) } else { turns }
    }
}

/// Words that a laser entry carries for the laser.
pub const LASER_WORDS: usize = 6;

/// The effect of an entry on something else than the path, at its exact instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EntryEffect {
    /// BufIO: sets the masked outputs of a group.
    Output {
        /// Which outputs.
        group: DoGroup,
        /// Those that change.
        mask: u64,
        /// To these levels.
        value: u64,
    },
    /// BufDA.
    Analog {
        /// From 0.
        channel: u8,
        /// −32768…32767 is −10…10 V.
        value: i16,
    },
    /// BufMove: another axis moves to a target.
    Move {
        /// Which axis.
        axis: Axis,
        /// Target, pulses.
        target: i32,
        /// Speed along its displacement.
        speed: Speed,
        /// Acceleration and deceleration.
        acc: Accel,
        /// Whether the path waits until it is there.
        modal: bool,
    },
    /// A change of a laser channel. The path does not read it.
    Laser {
        /// Channel.
        channel: u8,
        /// What changes, in the laser's own code.
        code: u8,
        /// Its numbers.
        words: [u32; LASER_WORDS],
    },
}

/// What an entry is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EntryContent {
    /// Nothing.
    Nothing,
    /// A straight line to these targets, pulses; coordinates after the first `dimensions` stay.
    Line {
        /// X, Y, Z, A.
        to: [i32; 4],
        /// 2 or 4.
        dimensions: usize,
        /// Its speeds.
        along: MotionSpeeds,
    },
    /// An arc in a plane; the other coordinates stay.
    Arc {
        /// Its plane.
        plane: Plane,
        /// Target, pulses.
        to: [i32; 2],
        /// Its sweep.
        sweep: Sweep,
        /// Its speeds.
        along: MotionSpeeds,
    },
    /// A full circle.
    Circle {
        /// Its plane.
        plane: Plane,
        /// Centre from the start in 2⁻³⁰ pulse.
        centre: [i64; 2],
        /// Counterclockwise.
        ccw: bool,
        /// Its speeds.
        along: MotionSpeeds,
    },
    /// BufDelay.
    Delay {
        /// Milliseconds.
        ms: u16,
    },
    /// BufGear: an axis is geared to the next motion.
    Gear {
        /// Which axis.
        axis: Axis,
        /// By this much.
        pulses: i32,
    },
    /// Something else than the path changes.
    Change(EntryEffect),
}

mod kind {
    pub const PLANAR: u32 = 1;
    pub const LINE: u32 = 2;
    pub const ARC: u32 = 3;
    pub const CIRCLE: u32 = 4;
    pub const DELAY: u32 = 5;
    pub const GEAR: u32 = 6;
    pub const OUTPUT: u32 = 7;
    pub const ANALOG: u32 = 8;
    pub const MOVE: u32 = 9;
    pub const LASER: u32 = 10;
    /// The bit of word 7 at which the kind begins.
    pub const SHIFT: u32 = 24;
    /// Above the kind: of an arc its plane, then these; of a line its ramp; of a planar one, after
    /// two bits, velEnd's top byte.
    pub const PLANE_SHIFT: u32 = 4;
    pub const RAMP_SHIFT: u32 = 4;
    pub const CCW: u32 = 1 << 6;
    pub const LONG_ARC: u32 = 1 << 7;
    pub const MODAL: u32 = 1 << 6;
    pub const TOP_SHIFT: u32 = 6;
}

fn low(x: u64) -> u32 {
    x as u32
}
fn high(x: u64) -> u32 {
    (x >> 32) as u32
}
fn wide(low: u32, high: u32) -> u64 {
    (high as u64) << 32 | low as u64
}

/// Geometry and speeds of a motion.
fn motion([a, b, c, d]: [u32; 4], along: MotionSpeeds, kind: u32) -> PathEntry {
    // 44 bits of vel, 38 of acc, 38 of end, 8 of kind.
    let (vel, acc) = (pack(along.vel & !SIGN, VEL_BITS), pack(along.acc & !SIGN, RATE_BITS));
    let end = pack(along.end, RATE_BITS);
    let first = vel << 20 | acc & 0xf_ffff;
    let second = (acc >> 20) << 38 | end | (kind as u64) << 56;
    PathEntry([a, b, c, d, low(first), high(first), low(second), high(second)])
}

/// An entry that is no motion.
fn other(kind: u32, words: [u32; 7]) -> PathEntry {
    let [a, b, c, d, e, f, g] = words;
    PathEntry([a, b, c, d, e, f, g, kind << kind::SHIFT])
}

impl PathEntry {
    /// A line in X and Y, pulses. Its start decides whether it has a length.
    pub fn planar(to: [i32; 2], along: MotionSpeeds) -> PathEntry {
        let [x, y] = to.map(|x| x as u32);
        let MotionSpeeds { vel, acc, end } = along;
        let top = END_TOP_BYTES.iter().position(|top| *top == end >> 56).unwrap_or(0) as u32;
        let last = high(end) & 0xff_ffff | (kind::PLANAR | top << kind::TOP_SHIFT) << kind::SHIFT;
        PathEntry([x, y, low(vel), high(vel), low(acc), high(acc), low(end), last])
    }

    /// A line in all coordinates, pulses.
    pub fn line(to: [i32; 4], along: MotionSpeeds) -> PathEntry {
        motion(to.map(|x| x as u32), along, kind::LINE | (along.ramp() as u32) << kind::RAMP_SHIFT)
    }

    /// An arc, see [`EntryContent::Arc`].
    pub fn arc(plane: Plane, to: [i32; 2], sweep: Sweep, along: MotionSpeeds) -> PathEntry {
        let [a, b] = to.map(|x| x as u32);
        let Sweep { turns, long, ccw } = sweep;
        let flags = if long { kind::LONG_ARC } else { 0 } | if ccw { kind::CCW } else { 0 };
        let kind = kind::ARC | (plane as u32) << kind::PLANE_SHIFT | flags;
        motion([a, b, low(turns), high(turns)], along, kind)
    }

    /// A full circle; centre from the start in 2⁻³⁰ pulse, 2⁻¹⁰ to 2³¹ pulses away.
    pub fn circle(plane: Plane, centre: [i64; 2], ccw: bool, along: MotionSpeeds) -> Result<PathEntry, Refused> {
        let [a, b] = centre;
        let most = a.unsigned_abs().max(b.unsigned_abs());
        if !(1 << 20..1 << 61).contains(&most) {
            return Err(Refused::Centre);
        }
        let kind = kind::CIRCLE | (plane as u32) << kind::PLANE_SHIFT | if ccw { kind::CCW } else { 0 };
        let [a, b] = [a as u64, b as u64];
        Ok(motion([low(a), high(a), low(b), high(b)], along, kind))
    }

    /// A wait of `ms` at standstill.
    pub fn delay(ms: u16) -> PathEntry {
        other(kind::DELAY, [ms as u32, 0, 0, 0, 0, 0, 0])
    }

    /// An axis is geared to the next motion, for a displacement of `pulses`.
    pub fn gear(axis: Axis, pulses: i32) -> PathEntry {
        other(kind::GEAR, [axis.index() as u32, pulses as u32, 0, 0, 0, 0, 0])
    }

    /// Sets the masked outputs of a group.
    pub fn output(group: DoGroup, mask: u64, value: u64) -> PathEntry {
        other(kind::OUTPUT, [group as u32, low(mask), high(mask), low(value), high(value), 0, 0])
    }

    /// Sets an analog output.
    pub fn analog(channel: u8, value: i16) -> PathEntry {
        other(kind::ANALOG, [channel as u32, value as u16 as u32, 0, 0, 0, 0, 0])
    }

    /// Another axis moves to a target; the path waits for it if it is `modal`. Speed and
    /// acceleration as the bits of doubles, admitted as [`Speed`] and [`Accel`].
    pub fn travel(
        axis: Axis,
        target: i32,
        (speed, limit): (u64, StepLimit),
        acc: u64,
        modal: bool,
    ) -> Result<PathEntry, crate::segment::ramp::Refused> {
        Speed::admit(speed, limit)?;
        Accel::admit(acc)?;
        let kind = kind::MOVE | if modal { kind::MODAL } else { 0 };
        let axis = axis.index() as u32;
        Ok(other(kind, [target as u32, low(speed), high(speed), low(acc), high(acc), axis, 0]))
    }

    /// A change of a laser channel.
    pub fn laser(channel: u8, code: u8, words: [u32; LASER_WORDS]) -> PathEntry {
        let [a, b, c, d, e, f] = words;
        other(kind::LASER, [a, b, c, d, e, f, (channel as u32) << 8 | code as u32])
    }

    /// The same motion with these speeds; an entry that is no motion stays.
    pub fn with_speeds(self, along: MotionSpeeds) -> PathEntry {
        let [a, b, c, d, ..] = self.0;
        match self.kind() & 15 {
            kind::PLANAR => PathEntry::planar([a, b].map(|x| x as i32), along),
            kind::LINE => PathEntry::line([a, b, c, d].map(|x| x as i32), along),
            kind::ARC | kind::CIRCLE => motion([a, b, c, d], along, self.kind()),
            _ => self,
        }
    }

    /// The words as stored.
    pub(super) fn words(self) -> [u32; 8] {
        self.0
    }

    /// From stored words; all bit patterns are valid.
    pub(super) fn from_words(words: [u32; 8]) -> PathEntry {
        PathEntry(words)
    }

    /// Kind and flags.
    #[inline(always)]
    fn kind(&self) -> u32 {
        let [.., last] = self.0;
        last >> kind::SHIFT
    }

    /// Whether it is a line, an arc or a circle.
    pub fn is_motion(&self) -> bool {
        (kind::PLANAR..=kind::CIRCLE).contains(&(self.kind() & 15))
    }

    /// Whether the path stops at it for a time.
    pub fn is_wait(&self) -> bool {
        let kind = self.kind();
        kind & 15 == kind::DELAY || kind & 15 == kind::MOVE && kind & kind::MODAL != 0
    }

    /// How many effects of a tick it counts as, if it is no motion: a move of another axis is
    /// planned when it begins.
    pub fn load(&self) -> u32 {
        if self.kind() & 15 == kind::MOVE { 4 } else { 1 }
    }

    /// What it is.
    pub fn item(&self) -> EntryContent {
        let [a, b, c, d, e, f, g, h] = self.0;
        let kind = self.kind();
        let along = || {
            let (first, second) = (wide(e, f), wide(g, h));
            let acc = first & 0xf_ffff | second << 8 >> 46 << 20;
            let (vel, end) = (unpack(first >> 20, VEL_BITS), second & ((1 << 38) - 1));
            // A motion that ends at its own speed keeps it in spite of the bits that are left out:
            // else it would have one more phase.
            let end = if end == pack(vel, RATE_BITS) { vel } else { unpack(end, RATE_BITS) };
            MotionSpeeds { vel, acc: unpack(acc, RATE_BITS), end }
        };
        let plane = match kind >> kind::PLANE_SHIFT & 3 {
            0 => Plane::Xy,
            1 => Plane::Yz,
            _ => Plane::Zx,
        };
        let axis = |index: u32| Axis::new(index as usize).unwrap_or_default();
        match kind & 15 {
            kind::PLANAR => {
                let top = END_TOP_BYTES.get((kind >> kind::TOP_SHIFT) as usize & 3).copied().unwrap_or(0);
                let end = wide(g, h) & ((1 << 56) - 1) | top << 56;
                let along = MotionSpeeds { vel: wide(c, d), acc: wide(e, f), end };
                EntryContent::Line { to: [a as i32, b as i32, 0, 0], dimensions: 2, along }
            }
            kind::LINE => {
                let to = [a, b, c, d].map(|x| x as i32);
                let ramp = match kind >> kind::RAMP_SHIFT & 3 {
                    1 => FixedRamp::Up,
                    2 => FixedRamp::Down,
                    _ => FixedRamp::None,
                };
                EntryContent::Line { to, dimensions: 4, along: along().with_ramp(ramp) }
            }
            kind::ARC => {
                let sweep = Sweep { turns: wide(c, d), long: kind & kind::LONG_ARC != 0, ccw: kind & kind::CCW != 0 };
                EntryContent::Arc { plane, to: [a as i32, b as i32], sweep, along: along() }
            }
            kind::CIRCLE => {
                let centre = [wide(a, b) as i64, wide(c, d) as i64];
                EntryContent::Circle { plane, centre, ccw: kind & kind::CCW != 0, along: along() }
            }
            kind::DELAY => EntryContent::Delay { ms: a as u16 },
            kind::GEAR => EntryContent::Gear { axis: axis(a), pulses: b as i32 },
            kind::OUTPUT => {
                EntryContent::Change(EntryEffect::Output { group: DoGroup::of(a), mask: wide(b, c), value: wide(d, e) })
            }
            kind::ANALOG => EntryContent::Change(EntryEffect::Analog { channel: a as u8, value: b as i16 }),
            kind::MOVE => match (Speed::admit(wide(b, c), StepLimit::FULL_SCALE), Accel::admit(wide(d, e))) {
                (Ok(speed), Ok(acc)) => {
                    let modal = kind & kind::MODAL != 0;
                    EntryContent::Change(EntryEffect::Move { axis: axis(f), target: a as i32, speed, acc, modal })
                }
                _ => EntryContent::Nothing,
            },
            kind::LASER => {
                let words = [a, b, c, d, e, f];
                EntryContent::Change(EntryEffect::Laser { channel: (g >> 8) as u8, code: g as u8, words })
            }
            _ => EntryContent::Nothing,
        }
    }
}
