//! A program on both, and what differs; a program that differs is made as short as it can be.
use super::machine::{Got, Reported, Rig, fixed, got};
use host_tests::reference::{Call, Controller, Fix, Levels, Path, PathCall, Program, Reply, Setup, Value};
use servo::output::step_generator;
use servo::units::Pos;
use std::collections::BTreeMap;

/// How often what.
pub type Tally = BTreeMap<String, u64>;

/// Bits of the status word that are compared: alarm, following error, limits, stops by inputs,
/// servo, profile running.
const BITS: u32 = 0b0111_1111_0010;
/// SPEC 11: 2⁻¹⁶ pulse.
const BOUND_PULSES: Fix = Fix(1 << 48);
/// Half a pulse: a step output stands no further from where the axis is to be.
const HALF_PULSE: Fix = Fix(1 << 63);
/// Ticks after the last call that are compared.
const TAIL_TICKS: usize = 8;
/// No program lasts longer.
const MAX_TICKS: usize = 60_000;

fn reference(setup: &Setup, tick_us: u32, begin: &[i64], calls: &[Call]) -> Program {
    Controller::new(setup, i64::from(tick_us) * 1000, begin).run(calls, TAIL_TICKS, MAX_TICKS)
}

/// Beside a program that has run: encoder counts and levels before it are those of the machine.
fn beside(setup: &Setup, tick_us: u32, reported: &Reported, calls: &[Call]) -> Program {
    let levels = reported.more.first().map_or_else(Levels::default, |first| {
        let mut levels = Levels { general: first.general, ..Levels::default() };
        levels.analog[..8].copy_from_slice(&first.analog);
        levels
    });
    Controller::new(setup, i64::from(tick_us) * 1000, &reported.begin)
        .with_encoders(reported.more.iter().map(|more| more.encoders.clone()).collect())
        .with_outputs(levels)
        .with_sessions(reported.sessions.clone())
        .run(calls, TAIL_TICKS, MAX_TICKS)
}

fn same(value: &Value, got: Got, peak: f64) -> bool {
    match (value, got) {
        (Value::None, Got::Nothing) => true,
        (Value::Whole(a), Got::Whole(b)) => {
            // A status word counts by the bits that are compared.
            *a == b
        }
        // A start condition that has no direction and position.
        (Value::Whole(a), Got::Three(b, ..)) => *a == b,
        (Value::Two(a, b), Got::Two(c, d)) => (*a, *b) == (c, d),
        (Value::Three(a, b, c), Got::Three(d, e, f)) => (*a, *b, *c) == (d, e, f),
        (Value::CrdPosition(a, slack), Got::CrdPosition(b)) => {
            a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 2f64.powi(-16) + slack)
        }
        (Value::Reals(a), Got::Reals(b)) => *a == b,
        (Value::Computed(a), Got::Reals(b)) => {
            let scale = a.iter().fold(1.0, |most: f64, a| most.max(a.abs()));
            a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-11 * scale)
        }
        (Value::Percent(a), Got::Whole(b)) => (a - b as f64).abs() <= 0.5 + 1e-6,
        // ±12.5 V in 16 bits.
        (Value::Volts(a), Got::Real(b)) => (a - b).abs() <= 0.5 * 25.0 / 65536.0 + 1e-9,
        (Value::Table(a, time), Got::Table(b, at)) => *a == b && (time - at).abs() < 2e-6,
        (Value::Position(a, slack), Got::Real(b)) => (a.to_f64() - b).abs() <= 2f64.powi(-16) + slack.to_f64(),
        // SPEC 11: 2⁻¹⁶ of the motion's peak.
        (Value::Velocity(a), Got::Real(b)) => (a.to_f64() - b).abs() <= 2f64.powi(-16) * peak.max(1.0),
        _ => false,
    }
}

/// The first disagreement.
fn compare(program: &Program, reported: &Reported, calls: &[Call]) -> Result<(), String> {
    if std::env::var("REFERENCE_LATE").is_ok()
        && program.open.is_none()
        && reported.late != 0
        && reported.answers.iter().all(|answer| answer.code == 0)
    {
        return Err(format!("{} entries were late", reported.late));
    }
    if program.open.is_none() && reported.answers.len() != calls.len() {
        return Err(format!("{} answers to {} calls", reported.answers.len(), calls.len()));
    }
    for ((index, call), reply) in calls.iter().enumerate().zip(&program.replies) {
        let Some(answer) = reported.answers.get(index) else { break };
        let good = match reply {
            Reply::Open => true,
            Reply::Code(code) => *code == answer.code,
            Reply::Done(_) if answer.code != 0 => false,
            Reply::Done(Value::Whole(word))
                if matches!(call, Call::Axis { kind: host_tests::reference::Kind::GetSts, .. }) =>
            {
                matches!(got(call, answer), Got::Whole(theirs) if (theirs as u32 ^ *word as u32) & BITS == 0)
            }
            // Not what is read, but what is set.
            Reply::Done(_) if matches!(call, Call::Path(PathCall { what: Path::GetPrm { .. }, .. })) => true,
            Reply::Done(value) => same(value, got(call, answer), 1000.0),
        };
        if !good {
            return Err(format!(
                "call {index}, {call:?}, answers {} {:?} ({}), the reference {reply:?}",
                answer.code,
                got(call, answer),
                answer.error.as_ref().map_or("", |error| &error.reason)
            ));
        }
    }
    let ticks = program.rows.len().min(reported.rows.len());
    let end = program.open.map_or(ticks, |(tick, _)| tick.min(ticks));
    if program.open.is_none() && ticks < program.rows.len() {
        return Err(format!("the program lasted {ticks} ticks, the reference {}", program.rows.len()));
    }
    if let Some(tick) = (0..end).find(|tick| program.times[*tick] != reported.times[*tick]) {
        let at = |times: &[i64]| times[tick] as f64 / 1e6;
        return Err(format!("tick {tick} is at {} ms, the reference's at {}", at(&reported.times), at(&program.times)));
    }
    let ms = |tick: usize| program.times[tick] as f64 / 1e6;
    // Positions from where the program began, theirs and the reference's, around a tick.
    let around = |tick: usize, axis: usize| -> String {
        let from = fixed(reported.begin[axis]);
        let reach = reach();
        (tick.saturating_sub(reach)..(tick + reach).min(end))
            .map(|tick| {
                let ((theirs, status), mine) = (reported.rows[tick][axis], program.rows[tick][axis]);
                let positions = [fixed(theirs), mine.x].map(|x| (x - from).to_f64());
                format!("\n// {:>10} ms {positions:?} {:#x} {:#x}", ms(tick), status & BITS, mine.status)
            })
            .collect()
    };
    // Where the step outputs stand: whole pulses.
    let mut stands: Vec<i64> = reported
        .rows
        .first()
        .map(|row| row.iter().map(|seen| step_generator::whole(Pos(seen.0))).collect())
        .unwrap_or_default();
    for tick in 0..end {
        // An entry of a path acts from its tick on or from the one after, by where in the tick it
        // lies.
        let (mine, theirs) = (&program.outputs[tick].analog, &reported.more[tick].analog);
        let Levels { analog: next, passed, .. } = &program.outputs[(tick + 1).min(program.outputs.len() - 1)];
        let driven = program.outputs[tick].driven;
        let differs = |channel: usize| {
            driven >> channel & 1 == 0
                && theirs[channel] != mine[channel]
                && theirs[channel] != next[channel]
                && !passed.contains(&(channel, theirs[channel]))
        };
        // What is open may have begun in the tick before.
        let is_known = program.open.is_none() || tick + 2 < end;
        if is_known && (0..8).any(differs) {
            return Err(format!("at {} ms analog outputs are {theirs:?}, the reference's {mine:?}", ms(tick)));
        }
        let theirs_of = reported.more[tick].powers;
        let near = |tick: usize, channel: usize| {
            // The power after the last tick is not known.
            let Some([power, slack]) = program.powers.get(tick).map(|powers| powers[channel]) else { return true };
            (power - theirs_of[channel]).abs() < 2f64.powi(-20) + slack
        };
        if is_known && (0..2).any(|channel| !near(tick, channel) && !near(tick + 1, channel)) {
            let reach = reach();
            let beside = (tick.saturating_sub(reach)..(tick + reach).min(end)).map(|tick| {
                let mine = program.powers[tick].map(|[power, _]| power);
                format!("\n// {:>10} ms {:?} {mine:?}", ms(tick), reported.more[tick].powers)
            });
            return Err(format!(
                "at {} ms powers are {theirs_of:?}, the reference's {:?}{}",
                ms(tick),
                program.powers[tick].map(|[power, _]| power),
                beside.collect::<String>()
            ));
        }
        for (axis, row) in program.rows[tick].iter().enumerate() {
            let (position, status) = reported.rows[tick][axis];
            stands[axis] += step_generator::between(Pos(reported.rows[tick.max(1) - 1][axis].0), Pos(position));
            if (Fix::whole(stands[axis]) - row.x).abs() > HALF_PULSE + BOUND_PULSES + row.slack {
                return Err(format!(
                    "at {} ms the step output of axis {axis} stands at {}, further than half a pulse from the reference's {}{}",
                    ms(tick),
                    stands[axis],
                    row.x.to_f64(),
                    around(tick, axis)
                ));
            }
            let apart = fixed(position) - row.x;
            if apart.abs() > BOUND_PULSES + row.slack {
                return Err(format!(
                    "at {} ms axis {axis} is {} pulses from the reference{}",
                    ms(tick),
                    apart.to_f64(),
                    around(tick, axis)
                ));
            }
            let went = (fixed(position) - fixed(reported.rows[tick.max(1) - 1][axis].0)).abs();
            if went > row.most + BOUND_PULSES + BOUND_PULSES {
                return Err(format!(
                    "at {} ms axis {axis} jumps by {} pulses in a tick, its data allow {}{}",
                    ms(tick),
                    went.to_f64(),
                    row.most.to_f64(),
                    around(tick, axis)
                ));
            }
            if !row.open && (status ^ row.status) & BITS != 0 {
                return Err(format!(
                    "at {} ms the status of axis {axis} is {:#x}, the reference's {:#x}{}",
                    ms(tick),
                    status & BITS,
                    row.status & BITS,
                    around(tick, axis)
                ));
            }
        }
    }
    // The last row is the last instant of which the reference knows.
    // What is open may have begun within the tick, and a fault takes light a tick before.
    let last = end.min(program.rows.len() - 1).saturating_sub(if program.open.is_some() { 2 } else { 0 });
    let last = ms(last);
    let mine = program.edges.iter().map(|edge| (edge.ms, edge.bit, edge.level)).collect();
    edges("an output", mine, &reported.edges, last)?;
    let mine = program.gates.iter().map(|&(ms, channel, level)| (ms, channel as u8, level)).collect();
    edges("a laser's switch", mine, &reported.gates, last)?;
    if let Some((tick, axis, apart)) = program.astray.filter(|(tick, ..)| *tick < end) {
        return Err(format!("at {} ms the encoder of axis {axis} is {apart} from where the machine is", ms(tick)));
    }
    Ok(())
}

/// Ticks before and after a difference that are shown.
fn reach() -> usize {
    std::env::var("REFERENCE_AROUND").ok().and_then(|text| text.parse().ok()).unwrap_or(3)
}

/// Changes of outputs before an instant, ms: each is where the reference has it, to 5 ns.
fn edges(what: &str, mine: Vec<(f64, u8, bool)>, theirs: &[(i64, u8, bool)], end: f64) -> Result<(), String> {
    let settled = |edges: Vec<(f64, u8, bool)>| {
        let mut left: Vec<(f64, u8, bool)> = Vec::new();
        // No edge falls on a bound like this, and so on either side of it by rounding.
        for edge in edges.into_iter().filter(|edge| edge.0 >= 0.0 && edge.0 < end - 0.001_003_7) {
            // One that another takes back at its instant is none.
            let twin = left.iter().rposition(|last| last.1 == edge.1).filter(|at| (left[*at].0 - edge.0).abs() < 1e-9);
            match twin {
                Some(at) => drop(left.remove(at)),
                None => left.push(edge),
            }
        }
        left.sort_by(|a, b| a.1.cmp(&b.1).then(a.0.total_cmp(&b.0)));
        left
    };
    let mine = settled(mine);
    let theirs = settled(theirs.iter().map(|edge| (edge.0 as f64 / 1e6, edge.1, edge.2)).collect());
    for (mine, theirs) in mine.iter().zip(&theirs) {
        if (mine.1, mine.2) != (theirs.1, theirs.2) || (mine.0 - theirs.0).abs() > 6e-6 {
            return Err(format!("{what} changes {theirs:?} (ms, from 0, level), the reference's {mine:?}"));
        }
    }
    if mine.len() != theirs.len() {
        return Err(format!("{what} changes {theirs:?}, the reference's {mine:?}"));
    }
    Ok(())
}

/// The program with some ms after every call that is refused: a refused entry makes others of its
/// instant late by a tick (docs/jobs.md). `REFERENCE_TOGETHER=1` leaves them together.
pub fn apart(setup: &Setup, tick_us: u32, calls: &[Call]) -> Option<Vec<Call>> {
    Controller::new(setup, i64::from(tick_us) * 1000, &vec![0; setup.axes.len()]).apart(calls, TAIL_TICKS, MAX_TICKS)
}

/// What differs, if anything.
fn differs(rig: &mut Option<Rig>, setup: &Setup, tick_us: u32, calls: &[Call], tally: &mut Tally) -> Option<String> {
    if !is_program(setup, tick_us, calls) {
        *tally.entry("programs without an end".into()).or_default() += 1;
        return None;
    }
    differs_here(rig, setup, tick_us, calls, tally)
}

/// It has an end, and its refusals stand alone.
fn is_program(setup: &Setup, tick_us: u32, calls: &[Call]) -> bool {
    let together = std::env::var("REFERENCE_TOGETHER").is_ok();
    if together {
        reference(setup, tick_us, &vec![0; setup.axes.len()], calls).complete
    } else {
        apart(setup, tick_us, calls).is_some_and(|spread| spread == calls)
    }
}

/// The same of a program that is one.
fn differs_here(
    rig: &mut Option<Rig>,
    setup: &Setup,
    tick_us: u32,
    calls: &[Call],
    tally: &mut Tally,
) -> Option<String> {
    let together = std::env::var("REFERENCE_TOGETHER").is_ok();
    let mine = rig.get_or_insert_with(|| Rig::new(setup.clone(), tick_us));
    let reported = match mine.run(calls) {
        Ok(reported) => reported,
        Err(reason) => {
            *rig = None;
            // What the contract leaves open may go on for ever.
            let alone = reference(setup, tick_us, &vec![0; setup.axes.len()], calls);
            return alone.open.is_none().then_some(reason);
        }
    };
    let program = beside(setup, tick_us, &reported, calls);
    // A refused entry makes others of its instant late by a tick, and only the run knows of this
    // one.
    if !together && program.refused.iter().any(|index| Controller::is_near(calls, *index)) {
        *tally.entry("programs with a refusal that encoders decide".into()).or_default() += 1;
        return None;
    }
    for (rule, count) in &program.used {
        *tally.entry((*rule).into()).or_default() += count;
    }
    let mut count = |what: &str, count: u64| *tally.entry(what.into()).or_default() += count;
    count("programs", 1);
    count("calls", calls.len() as u64);
    count("ticks", program.rows.len() as u64);
    if reported.late != 0 && reported.answers.iter().all(|answer| answer.code == 0) {
        count("programs with late entries, though none was refused", 1);
    }
    if std::env::var_os("REFERENCE_TABLE").is_some() {
        for (call, reply) in calls.iter().zip(&program.replies) {
            let text = setup.text(0, call);
            // The form without a core where there is no other.
            let call = text.split("GTN_").nth(1).or_else(|| text.split("GT_").nth(1));
            let Some(name) = call.and_then(|rest| rest.split('(').next()) else { continue };
            count(&format!("tried {name}"), 1);
            count(&format!("done {name}"), matches!(reply, Reply::Done(_)).into());
        }
    }
    for reply in &program.replies {
        match reply {
            Reply::Done(Value::None) => count("calls done", 1),
            Reply::Done(_) => count("values read", 1),
            Reply::Code(code) => count(&format!("calls refused with {code}"), 1),
            Reply::Open => count("answers left open", 1),
        }
    }
    if let Some((_, why)) = program.open {
        count(&format!("cut short: {why}"), 1);
    }
    compare(&program, &reported, calls).err()
}

/// What a reason speaks of: its first words, without figures.
fn kind(reason: &str) -> String {
    if ["pulses from the reference", "step output", "jumps by"].iter().any(|words| reason.contains(words)) {
        return "a position".into();
    }
    reason.chars().filter(|letter| letter.is_ascii_alphabetic()).take(20).collect()
}

/// A report of a program that differs.
pub fn finding(
    rig: &mut Option<Rig>,
    setup: &Setup,
    tick_us: u32,
    calls: &[Call],
    tally: &mut Tally,
) -> Option<String> {
    let (mut calls, first) = match std::env::var("REFERENCE_TOGETHER") {
        Ok(_) => (calls.to_vec(), differs(rig, setup, tick_us, calls, tally)?),
        Err(_) => {
            let calls = apart(setup, tick_us, calls)?;
            let first = differs_here(rig, setup, tick_us, &calls, tally)?;
            (calls, first)
        }
    };
    let mut scratch = Tally::new();
    let mut reason = format!("not the same when it ran again: {first}");
    if let Some(again) = differs(rig, setup, tick_us, &calls, &mut scratch) {
        reason = again;
    }
    // Another fault that shows in a shorter program is not this one.
    let what = kind(&reason);
    let mut width = calls.len() / 2;
    let mut tries = 0;
    while width > 0 && tries < 1500 {
        let mut at = 0;
        let mut less = false;
        while at < calls.len() && tries < 1500 {
            let mut shorter = calls.clone();
            shorter.drain(at..(at + width).min(calls.len()));
            tries += 1;
            match differs(rig, setup, tick_us, &shorter, &mut scratch) {
                Some(again) if kind(&again) == what => (calls, reason, less) = (shorter, again, true),
                _ => at += width,
            }
        }
        if !less || width > 1 {
            width = if less { width } else { width / 2 };
        }
    }
    Some(format!("tick {tick_us} µs, {reason}\n{}", setup.job(tick_us, calls.iter())))
}
