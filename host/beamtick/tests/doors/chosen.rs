//! Programs for all doors: those of the reference's generator, with calls of the whole API between
//! them.
//!
//! What the reference does not hold (paths, outputs, lasers, FollowEx, long tables, reads of
//! several axes) comes from the descriptions of this folder: whole pieces of them, single calls
//! with other values, arrays of other lengths.

use crate::PROGRAMS;
use crate::listing::Listing;
use crate::player::Programme;
use crate::program::{Call, Step, Value, read};
use gts::prototype::{Form, prototype};
use host_tests::reference::chance::Chance;
use host_tests::reference::{Family, Setup, generator};
use job::api::{Pass, Type};

/// What is about time, the session or the file system, and not about what is called.
const LEFT_OUT: &[&str] = &["SetTick", "SetLinkLoss", "GetLinkLoss", "GetVersion", "GetClock"];
/// The longest pause of a description here, ms.
const PAUSE_MS: u32 = 60;
/// Points of a table, and values of an array.
const LENGTHS: [usize; 17] = [0, 1, 2, 3, 8, 9, 31, 32, 33, 40, 41, 42, 43, 60, 61, 300, 1024];

/// The program of a number.
pub fn programme(seed: u64, calls: usize) -> Programme {
    let mut chance = Chance::new(seed ^ 0x000D_0025);
    let cores = chance.below(4) == 0;
    let mut setup = match cores {
        false => Setup { profile: "gus", family: Family::Gus, axes: vec![(1, 1), (1, 2), (1, 3), (1, 6)] },
        true => Setup { profile: "gtn-016", family: Family::Gus, axes: vec![(1, 1), (1, 2), (2, 1), (2, 7)] },
    };
    let tick_us = [250, 1000, 500, 100, 250][chance.below(5) as usize];
    let family = ["gus", "lsr"][chance.below(2) as usize];
    setup.family = [Family::Gus, Family::Lsr][usize::from(family == "lsr")];
    let descriptions: Vec<Vec<Step>> = PROGRAMS.iter().map(|(_, text)| read(text)).collect();
    let mut steps = Vec::new();
    for (core, axis) in &setup.axes {
        with_core(&mut steps, read(&format!("LmtsOff {axis} -1\nPrfTrap {axis}")), cores.then_some(*core));
    }
    let mut listing = Listing::new(cores);
    let base = generator::program(seed, &setup, calls);
    // A job has one tick.
    let in_jobs = base.calls.iter().filter(|call| !matches!(call, host_tests::reference::Call::SetTick { .. }));
    for (number, call) in in_jobs.enumerate() {
        steps.extend(listing.read(&setup.text(number, call)));
        if chance.below(6) == 0 {
            let core = cores.then(|| 1 + chance.below(2) as i16);
            let extra = extra(&mut chance, &descriptions);
            with_core(&mut steps, extra, core);
        }
        if chance.below(60) == 0 {
            with_core(&mut steps, stream(&mut chance), cores.then_some(1));
        }
    }
    steps.push(Step::Sleep(25));
    // Some end as they began.
    if chance.below(12) == 0 {
        with_core(&mut steps, read("Reset\nsleep 30"), cores.then_some(1));
    }
    let batches = !appends(&steps);
    Programme { steps, tick_us, profile: setup.profile, family, cores, batches, rests: false }
}

fn with_core(steps: &mut Vec<Step>, more: Vec<Step>, core: Option<i16>) {
    steps.extend(more.into_iter().map(|step| match step {
        Step::Call(call) if core.is_some() => Step::Call(in_gtn(Call { core, ..call })),
        other => other,
    }));
}

/// What the form with a core has no parameter for is the default.
fn in_gtn(mut call: Call) -> Call {
    let form = prototype(call.function, Form::Gtn);
    for (param, value) in call.function.params.iter().zip(&mut call.values) {
        if let (Pass::In(_), Some(default)) = (param.pass, param.default)
            && !form.arguments.iter().any(|argument| argument.name == param.name)
        {
            *value = Value::Number(default.to_string());
        }
    }
    call
}

/// An axis, of the first core, whose streams do not run dry.
const STREAMED: i64 = 7;

/// A stream whose data lasts, to which more is added while it runs.
fn stream(chance: &mut Chance) -> Vec<Step> {
    let axis = STREAMED;
    let first = 40 + chance.below(20);
    let mut text = format!(
        "LmtsOff {axis} -1\nAxisOn {axis}\nPrfTrap {axis}\nPrfPt {axis} 1\nPtClear {axis} 0\nPtData {axis} 30 {first} 0 0\n\
         PtStart {} 0\n",
        1 << (axis - 1)
    );
    for more in 1..4 {
        let (time, kind) = (first + 40 * more, [0, 1, 2][chance.below(3) as usize]);
        text += &format!("PtSpace {axis} * 0\nPtData {axis} {} {time} {kind} 0\n", 30 + chance.below(50));
        text += &format!("PrfPt {axis} 1\nsleep {}\n", 1 + chance.below(4));
    }
    text += &format!("GetPrfPos {axis} * 1 _\nsleep 200\nGetSts {axis} * 1 _");
    read(&text)
}

/// Whether PT data may come to a FIFO that runs, or be counted while some of it waits: then it
/// matters when it arrives.
fn appends(steps: &[Step]) -> bool {
    let names =
        steps.iter().filter_map(|step| if let Step::Call(call) = step { Some(call.function.name) } else { None });
    let (mut started, mut appended) = (false, false);
    for name in names {
        started |= matches!(name, "PtStart" | "PtStartPro");
        appended |= name == "PtSpace" || started && name == "PtData";
    }
    appended
}

fn extra(chance: &mut Chance, descriptions: &[Vec<Step>]) -> Vec<Step> {
    let description = &descriptions[chance.below(descriptions.len() as u64) as usize];
    let at = chance.below(description.len() as u64) as usize;
    let mut steps = match chance.below(8) {
        // As it stands, up to a path or a motion that runs.
        0..3 => {
            let piece = &description[at..(at + 1 + chance.below(14) as usize).min(description.len())];
            let shorter = |step: &Step| match step {
                Step::Sleep(ms) => Step::Sleep((*ms).min(PAUSE_MS)),
                other => other.clone(),
            };
            piece.iter().map(shorter).collect()
        }
        3 => lengths(chance, descriptions),
        4 if chance.below(3) == 0 => laser(chance),
        4 if chance.below(3) == 0 => vertex(chance),
        4 => outputs(chance),
        _ => vec![other(chance, &description[at])],
    };
    if chance.below(4) == 0 {
        let place = chance.below(steps.len() as u64) as usize;
        steps[place] = other(chance, &steps[place]);
    }
    steps.retain(|step| !matches!(step, Step::Call(call) if LEFT_OUT.contains(&call.function.name)));
    steps
}

/// The same call with one other value.
fn other(chance: &mut Chance, step: &Step) -> Step {
    let Step::Call(call) = step else { return step.clone() };
    let places: Vec<usize> = (0..call.values.len())
        .filter(|place| matches!(call.values[*place], Value::Number(_)))
        .filter(|place| !["count", "size"].contains(&call.function.params[*place].name))
        .collect();
    let Some(place) = places.get(chance.below(places.len().max(1) as u64) as usize) else { return step.clone() };
    let Value::Number(text) = &call.values[*place] else { return step.clone() };
    let number: f64 = text.parse().unwrap();
    let value = match call.function.params[*place].pass {
        Pass::In(Type::Double) => (number * [0.0, -1.0, 0.5, 1.25, 2.0][chance.below(5) as usize]).to_string(),
        Pass::In(Type::UShort | Type::ULong) => [0, 1, 2, 3, 8, 100][chance.below(6) as usize].to_string(),
        _ => [0, 1, 2, 3, 4, 5, 6, 8, 9, -1][chance.below(10) as usize].to_string(),
    };
    Step::Call(call.with(*place, Value::Number(value)))
}

/// A call with arrays, or a count, of another length.
fn lengths(chance: &mut Chance, descriptions: &[Vec<Step>]) -> Vec<Step> {
    let all: Vec<&Call> = descriptions
        .iter()
        .flatten()
        .filter_map(|step| if let Step::Call(call) = step { Some(call) } else { None })
        .filter(|call| call.function.has("count"))
        .collect();
    let call = all[chance.below(all.len() as u64) as usize];
    let lists = call.function.params.iter().any(|param| matches!(param.pass, Pass::Many(..)));
    let most = if lists { LENGTHS.len() as u64 } else { 6 };
    let mut length = LENGTHS[chance.below(most) as usize];
    // What has room for 32 need not be given a thousand.
    if !call.function.name.starts_with("Pvt") {
        length = length.min(if call.function.name == "SetLaserDisTable2D" { 33 } else { 61 });
    }
    // A job with a list of no axes is refused before it runs.
    if call.function.name == "PtStartPro" {
        length = length.clamp(1, 9);
    }
    // Long ones need several messages.
    vec![Step::Call(call.of_length(length)), Step::Sleep(4 + length as u32 / 2)]
}

/// What a channel outputs by calls alone; [`crate::rules`] says what that is.
fn laser(chance: &mut Chance) -> Vec<Step> {
    let (min, max, power) = (chance.below(180) as i64 - 40, 60 + chance.below(40), chance.below(60));
    let (first, second) = [(0, 2), (2, 0), (0, 0)][chance.below(3) as usize];
    let text = match chance.below(2) {
        0 => format!(
            "LaserPowerMode 2 10 0 0 0\nLaserPowerMode 0 {max} {min} 0 0\nLaserOutFrq 10 0\nLaserPrfCmd {power} 0\nLaserOn 0\n\
             sleep 8\nGetLaserFault 0 *\nGetLaserPower 0 *\nLaserOff 0"
        ),
        _ => format!(
            "LaserPowerMode 2 10 0 0 0\nLaserPowerMode {first} 10 0 0 0\nLaserPowerMode 2 10 0 1 0\n\
             LaserPowerMode {second} 10 0 1 0\nLaserOff 0\nLaserOff 1\nSetWaitPulseEx 1 5 8\nsleep 8\n\
             GetLaserFault 0 *\nGetLaserPower 0 *"
        ),
    };
    read(&format!("SetAxisMode 7 1\n{text}\nSetWaitPulseEx 0 0 0"))
}

/// Two lines of 400 pulses, 60 ms without a stop, and as many entries between them as a tick
/// carries out.
fn vertex(chance: &mut Chance) -> Vec<Step> {
    let mut text = String::from(
        "CrdClear 1 0\nSetCrdPrm 1 {dimension=2 profile=1,2 synVelMax=100 synAccMax=1}\nCrdClear 1 0\nSetOverride 1 1\n\
         LnXY 1 400 0 20 1 20 0\n",
    );
    for _ in 0..9 + chance.below(22) {
        text += &format!("BufIO 1 12 255 {} 0\n", chance.below(256));
    }
    text += "LnXY 1 800 0 20 1 0 0\nCrdStart 1 0\nsleep 66\nCrdStatus 1 * * 0";
    read(&text)
}

/// Outputs by calls and from a path, and what is read of them.
fn outputs(chance: &mut Chance) -> Vec<Step> {
    let (dac, value) = (1 + chance.below(8), chance.below(40_000) as i64 - 20_000);
    let text = match chance.below(3) {
        0 => format!("SetDac {dac} [{value}] 1\nGetDac {dac} * 1"),
        1 => format!("SetDoBit 12 {dac} {}\nGetDo 12 *", chance.below(2)),
        _ => format!(
            "CrdClear 1 0\nSetCrdPrm 1 {{dimension=2 profile=1,2 synVelMax=100 synAccMax=1}}\nCrdClear 1 0\n\
             BufDA 1 {dac} {value} 0\nBufIO 1 12 255 {} 0\nBufDelay 1 4 0\nBufDA 1 {dac} {} 0\nCrdStart 1 0\nsleep 3\n\
             GetDac {dac} * 1\nGetDo 12 *\nsleep 8\nGetDac {dac} * 1\nCrdStatus 1 * * 0",
            chance.below(256),
            -value
        ),
    };
    read(&text)
}
