//! Random paths, as calls and as the model takes them.
#![allow(dead_code, reason = "each test file takes what it needs")]
use super::chance::Chance;
use host_tests::path_model::geometry::Position;
use host_tests::path_model::{Command, Course, Entry, Frame, Geometry, Plane, Rates, Why, course};
use std::fmt::Write;

/// What an entry that takes no time does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    /// BufLaserOn, BufLaserOff of the channel with the number of the coordinate system (from 0).
    Gate(bool),
    /// BufLaserPrfCmd of that channel, in mV: it is in analog mode.
    Power(u32),
    /// BufIO of the general output with its number (from 1).
    Output(bool),
}

/// A path.
#[derive(Debug, Clone)]
pub struct Random {
    pub frame: Frame,
    pub dimensions: usize,
    pub entries: Vec<Entry>,
    pub effects: Vec<Effect>,
    /// The calls of its entries.
    pub text: String,
    /// Where it ends.
    pub end: Position,
}

/// The number as a script may write it.
fn real(value: f64) -> String {
    format!("{value:?}")
}

/// The way that a motion takes of the speed scale, ms.
const TIMES_MS: (f64, f64) = (0.02, 4.0);

/// Speeds about this.
struct Scale {
    speed: f64,
    acc: f64,
}

fn rates(chance: &mut Chance, scale: &Scale) -> Rates {
    let speed = scale.speed * (0.3 + 1.2 * chance.unit());
    let end = if chance.below(3) == 0 { 0.0 } else { scale.speed * 1.3 * chance.unit() };
    Rates { speed, acc: scale.acc * (0.5 + 1.5 * chance.unit()), end }
}

fn tail(rates: &Rates) -> String {
    format!("{},{},{},0", real(rates.speed), real(rates.acc), real(rates.end))
}

/// The calls of a coordinate system with its origin at 0, the first over axes 1 to 4, the second
/// over 5 to 8.
pub fn set_up(frame: &Frame, dimensions: usize, crd: usize) -> String {
    let mut text = format!("crd.dimension = {dimensions};\n");
    for axis in 0..8 {
        let coordinate = (axis / 4 == crd && axis % 4 < dimensions).then_some(axis % 4 + 1);
        writeln!(text, "crd.profile[{axis}] = {};", coordinate.unwrap_or(0)).unwrap();
    }
    writeln!(text, "crd.synVelMax = {};\ncrd.synAccMax = {};", real(frame.speed), real(frame.acc)).unwrap();
    writeln!(text, "crd.evenTime = {};\ncrd.setOriginFlag = 1;", frame.even_ms).unwrap();
    writeln!(text, "GT_SetCrdPrm({},&crd);", crd + 1).unwrap();
    text
}

fn line(chance: &mut Chance, from: &mut Position, dimensions: usize, length: f64, scale: &Scale) -> (Entry, String) {
    let begin = *from;
    while *from == begin {
        let way: [f64; 4] = std::array::from_fn(|_| chance.unit() - 0.5);
        let norm = way[..dimensions].iter().map(|x| x * x).sum::<f64>().sqrt();
        for axis in 0..dimensions {
            // Often along an axis.
            let part = if chance.below(6) == 0 { 0.0 } else { way[axis] / norm };
            from[axis] = begin[axis] + (part * length.max(2.0)).round();
        }
    }
    let rates = rates(chance, scale);
    let name = ["XY", "XYZ", "XYZA"][dimensions - 2];
    let to: String = from[..dimensions].iter().map(|x| format!("{x},")).collect();
    (Entry::Motion(Geometry::line(begin, *from), rates), format!("GT_Ln{name}(CRD,{to}{});\n", tail(&rates)))
}

/// An arc of up to so many radians; a line where the target's whole pulses leave no arc.
fn arc(
    chance: &mut Chance,
    from: &mut Position,
    dimensions: usize,
    length: f64,
    sweeps: (f64, f64),
    scale: &Scale,
) -> (Entry, String) {
    let planes = [(Plane::XY, "XY"), (Plane::YZ, "YZ"), (Plane::ZX, "ZX")];
    let (plane, name) = planes[if dimensions == 2 { 0 } else { chance.below(3) as usize }];
    let (first, second) = plane.axes();
    let begin = *from;
    let ccw = chance.below(2) == 0;
    let sweep = chance.log(sweeps.0, sweeps.1);
    let radius = (length / sweep).max(4.0);
    let turn = chance.unit() * std::f64::consts::TAU;
    let rates = rates(chance, scale);
    let direction = u8::from(ccw);
    // From the start to the centre.
    let arm = (radius * turn.cos(), radius * turn.sin());
    let kind = chance.below(4);
    if kind == 0 {
        let geometry = Geometry::arc_by_centre(begin, plane, (begin[first], begin[second]), arm, ccw).unwrap();
        let centre = format!("{},{}", real(arm.0), real(arm.1));
        let text =
            format!("GT_Arc{name}C(CRD,{},{},{centre},{direction},{});\n", begin[first], begin[second], tail(&rates));
        return (Entry::Motion(geometry, rates), text);
    }
    let (sin, cos) = (if ccw { sweep } else { -sweep }).sin_cos();
    let back = (-arm.0 * cos + arm.1 * sin, -arm.0 * sin - arm.1 * cos);
    let to = ((begin[first] + arm.0 + back.0).round(), (begin[second] + arm.1 + back.1).round());
    if to == (begin[first], begin[second]) {
        return line(chance, from, dimensions, length, scale);
    }
    (from[first], from[second]) = to;
    let half = (to.0 - begin[first]).hypot(to.1 - begin[second]) / 2.0;
    let reach = radius.max(half * 1.000_001);
    let radius = if sweep > std::f64::consts::PI { -reach } else { reach };
    if kind == 1 {
        let geometry = Geometry::arc_by_radius(begin, plane, to, radius, ccw).unwrap();
        let text = format!("GT_Arc{name}R(CRD,{},{},{},{direction},{});\n", to.0, to.1, real(radius), tail(&rates));
        return (Entry::Motion(geometry, rates), text);
    }
    // The rounded target moves the centre along the chord; so much that the path leaves the arc is
    // refused.
    let chord = (to.0 - begin[first], to.1 - begin[second]);
    let off = half - (arm.0 * chord.0 + arm.1 * chord.1) / (2.0 * half);
    if off.abs() > 0.7 {
        *from = begin;
        return line(chance, from, dimensions, length, scale);
    }
    let geometry = Geometry::arc_by_centre(begin, plane, to, arm, ccw).unwrap();
    let centre = format!("{},{}", real(arm.0), real(arm.1));
    let text = format!("GT_Arc{name}C(CRD,{},{},{centre},{direction},{});\n", to.0, to.1, tail(&rates));
    (Entry::Motion(geometry, rates), text)
}

fn effect(chance: &mut Chance) -> (Effect, String) {
    match chance.below(8) {
        0..3 => (Effect::Gate(true), "GT_BufLaserOn(CRD,0,CHANNEL);\n".into()),
        3..5 => (Effect::Gate(false), "GT_BufLaserOff(CRD,0,CHANNEL);\n".into()),
        5..7 => {
            let mv = chance.below(9) as u32 * 1000 + 500;
            (Effect::Power(mv), format!("GT_BufLaserPrfCmd(CRD,{},0,CHANNEL);\n", real(f64::from(mv) / 1000.0)))
        }
        _ => {
            let on = chance.below(2) == 0;
            (Effect::Output(on), format!("GT_BufIO(CRD,12,CRD,{},0);\n", if on { "CRD" } else { "0" }))
        }
    }
}

/// Up to so many entries of a coordinate system (from 0) from a place on.
pub fn random(chance: &mut Chance, from: Position, most: u64, crd: usize) -> Random {
    let speed = chance.log(0.5, 200.0);
    let scale = Scale { speed, acc: speed / chance.log(0.3, 15.0) };
    let frame = Frame {
        speed: speed * (0.8 + chance.unit()),
        acc: scale.acc * (0.8 + 1.5 * chance.unit()),
        even_ms: if chance.below(4) == 0 { 1.0 + chance.below(3) as f64 } else { 0.0 },
    };
    let dimensions = 2 + chance.below(3) as usize;
    let mut made =
        Random { frame, dimensions, entries: Vec::new(), effects: Vec::new(), text: String::new(), end: from };
    // At most 6 effects may fall into a ms.
    let often = chance.below(5);
    for _ in 0..1 + chance.below(most) {
        if chance.below(5) < often {
            let (effect, text) = effect(chance);
            let number = made.effects.len();
            let of_laser = !matches!(effect, Effect::Output(_));
            made.entries.push(if of_laser { Entry::Laser(number) } else { Entry::Effect(number) });
            made.effects.push(effect);
            made.text += &text;
        }
        let length = scale.speed * chance.log(TIMES_MS.0, TIMES_MS.1);
        let (entry, text) = match chance.below(12) {
            0 => {
                let ms = 1 + chance.below(3) as u16;
                (Entry::Delay(ms), format!("GT_BufDelay(CRD,{ms},0);\n"))
            }
            1..5 => arc(chance, &mut made.end, dimensions, length, (0.05, 6.2), &scale),
            _ => line(chance, &mut made.end, dimensions, length, &scale),
        };
        made.entries.push(entry);
        made.text += &text;
    }
    made.text = calls_of(&made.text, crd);
    made
}

/// As outputs are the bits of a mask, CRD is that of its own as well.
fn calls_of(text: &str, crd: usize) -> String {
    text.replace("CRD", &format!("{}", crd + 1)).replace("CHANNEL", &format!("{crd}"))
}

/// So many arcs of any size, one after another from a place on.
pub fn arcs(chance: &mut Chance, from: Position, count: usize, crd: usize) -> Random {
    let speed = chance.log(1.0, 3000.0);
    let scale = Scale { speed, acc: speed / chance.log(0.3, 15.0) };
    let frame = Frame { speed: speed * 2.0, acc: scale.acc * 2.0, even_ms: 0.0 };
    let dimensions = 2 + chance.below(3) as usize;
    let mut made =
        Random { frame, dimensions, entries: Vec::new(), effects: Vec::new(), text: String::new(), end: from };
    for _ in 0..count {
        let length = speed * chance.log(0.5, 40.0);
        let (entry, text) = arc(chance, &mut made.end, dimensions, length, (1e-4, 6.27), &scale);
        made.entries.push(entry);
        made.text += &text;
    }
    made.text = calls_of(&made.text, crd);
    made
}

/// Whether no more effects than a tick runs fall into any ms from the start on, and no more motions
/// end in it than this.
pub fn fits(course: &Course, start: f64, motions: usize) -> bool {
    let fits = |instants: Vec<f64>, most: usize| {
        let mut counts = std::collections::HashMap::new();
        instants.iter().all(|at| {
            let count = counts.entry((at - start + 1e-9).floor() as i64).or_insert(0);
            *count += 1;
            *count <= most
        })
    };
    fits(course.effects.iter().map(|(at, _)| *at).collect(), 6) && fits(course.ends.clone(), motions)
}

/// Whether two events come at one instant and SPEC 5 does not say which is first. One case is the
/// standstill of a Stop with an entry, or with the end of a BufDelay into which it braked. The
/// other is a Stop with the end of the entries, so that nothing is left to continue.
pub fn is_undecided(course: &Course) -> bool {
    let same = |a: f64, b: f64| (a - b).abs() < 1e-6;
    let waits_out = |at: f64| {
        let ends = course.pieces.iter().position(|piece| same(piece.begin + piece.ms, at));
        let goes_on = |index: usize| course.pieces.get(index + 1).map(|piece| piece.entry);
        ends.is_some_and(|index| {
            let piece = &course.pieces[index];
            (piece.speed, piece.acc) == (0.0, 0.0) && goes_on(index) != Some(piece.entry)
        })
    };
    let mut stops = course.rests.iter().filter(|rest| rest.why == Why::Stopped).map(|rest| rest.at);
    stops.any(|rest| waits_out(rest) || course.effects.iter().any(|(at, _)| same(*at, rest)))
        || course.starts.iter().any(|(at, _)| course.rests.iter().any(|rest| same(*at, rest.at)))
        || goes_on_to_the_end_at_hand(course)
}

/// After an abrupt Stop it goes on from the place that was shown, to 2⁻¹⁶ pulse. When it ends
/// depends on that, where hardly anything of the motion is left.
fn goes_on_to_the_end_at_hand(course: &Course) -> bool {
    (0..course.pieces.len()).filter(|index| course.pieces[*index].ms == 0.0).any(|index| {
        let rest = course.pieces[index + 1..].iter().take_while(|piece| piece.entry == course.pieces[index].entry);
        let way: f64 = rest.map(|piece| piece.speed * piece.ms + piece.acc * piece.ms * piece.ms / 2.0).sum();
        way > 0.0 && way < 0.01
    })
}

/// The course of a path that is started at 0 and left alone.
pub fn undisturbed(path: &Random) -> Course {
    course(&path.frame, &path.entries, &[(0.0, Command::Start)], 1e9)
}
