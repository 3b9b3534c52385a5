//! What the outputs did against what they may and must do.
//!
//! In: a [`Verdict`], the outputs' edges. Out: the first difference, in words. Where light must be,
//! it is asked for with a pulse in every period; where it may not be, nothing but the standby pulse
//! and the pre-voltage is allowed.
use super::Ns;
use super::gate::{Fpk, Lit, Timing, gate_spans, light_spans};
use super::rules::Verdict;

/// An edge may be off by this, ns: both the mark of a boundary and the edge are rounded.
pub const SLACK: Ns = 12;
/// A last pulse is finished if it ends within this after the gate.
const FINISH: Ns = 100_000;

/// What a channel's outputs show.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Output {
    /// Pulses: the longest distance of two that are light, the longest that is standby (0: none is
    /// set).
    Pulses { period: Ns, standby: Ns },
    /// A voltage, as codes: pre-voltage, and the least that is light.
    Volts { waiting: i16, least: i16 },
}

/// What the outputs of a channel did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Recorded {
    /// Energy pulses, begin and end.
    pub pulses: Vec<(Ns, Ns)>,
    /// Edges of the switch.
    pub switch: Vec<(Ns, bool)>,
    /// Changes of the analog output.
    pub volts: Vec<(Ns, i16)>,
}

/// How a channel's switch is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switch {
    /// It is the gate, or the FPK pulse.
    Gate,
    /// GUS mode 3: held.
    Held,
}

/// What the comparison needs to know.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// Delays and FPK.
    pub timing: &'a Timing,
    /// What the outputs show.
    pub output: Output,
    /// How the switch is used.
    pub switch: Switch,
    /// From here on.
    pub from: Ns,
    /// To here.
    pub until: Ns,
}

/// Compares; the first difference, and how many spans of required light there were.
pub fn compare(given: &Given, verdict: &Verdict, recorded: &Recorded) -> Result<usize, String> {
    let spans = |most| light_spans(&verdict.gates, given.timing, most, given.until);
    let (allowed, required) = (spans(true), spans(false));
    match given.output {
        Output::Pulses { period, standby } => {
            dark(given, verdict, &allowed, &recorded.pulses, standby)?;
            lit(given, &required, &recorded.pulses, period)?;
        }
        Output::Volts { waiting, least } => {
            volts(given, verdict, &allowed, &required, &recorded.volts, waiting, least)?
        }
    }
    switch(given, verdict, &recorded.switch)?;
    Ok(required.iter().filter(|span| span.begin >= given.from && span.end - span.begin > SLACK).count())
}

/// The span that may hold an instant.
fn around(spans: &[Lit], at: Ns) -> Option<&Lit> {
    let after = spans.partition_point(|span| span.begin - SLACK <= at);
    spans[..after].last().filter(|span| at < span.end + SLACK)
}

fn is_safe(verdict: &Verdict, begin: Ns, end: Ns) -> bool {
    verdict.safe.iter().any(|&(from, to)| begin < to - SLACK && from + SLACK < end)
}

fn dark(given: &Given, verdict: &Verdict, allowed: &[Lit], pulses: &[(Ns, Ns)], standby: Ns) -> Result<(), String> {
    for &(begin, end) in pulses.iter().filter(|pulse| pulse.0 >= given.from && pulse.0 < given.until) {
        if is_safe(verdict, begin, end) {
            return Err(format!("a pulse from {begin} to {end}, where nothing at all may be output"));
        }
        if end - begin <= standby + 2 {
            continue;
        }
        let Some(span) = around(allowed, begin) else {
            return Err(format!("a pulse from {begin} to {end} in the dark; light may be in {allowed:?}"));
        };
        let last = span.end + SLACK + if span.cut { 0 } else { FINISH };
        if end > last {
            return Err(format!("a pulse from {begin} to {end}, which is longer than the light {span:?}"));
        }
    }
    Ok(())
}

fn lit(given: &Given, required: &[Lit], pulses: &[(Ns, Ns)], period: Ns) -> Result<(), String> {
    for span in required {
        let (from, to) = (span.begin.max(given.from), span.end.min(given.until));
        let most = period + SLACK;
        let first = pulses.partition_point(|pulse| pulse.1 <= from);
        let mut dark_since = from;
        for &(begin, end) in pulses[first..].iter().take_while(|pulse| pulse.0 < to) {
            if begin - dark_since > most {
                return Err(format!("no light from {dark_since} to {begin}; there must be in {span:?}"));
            }
            dark_since = end.max(dark_since);
        }
        if to - dark_since > most {
            return Err(format!("no light from {dark_since} to {to}; there must be in {span:?}"));
        }
    }
    Ok(())
}

/// Spans between changes, with their values.
fn steps<T: Copy>(edges: &[(Ns, T)], first: T, until: Ns) -> impl Iterator<Item = (Ns, Ns, T)> + '_ {
    let begin = std::iter::once((Ns::MIN / 2, first)).chain(edges.iter().copied());
    let ends = edges.iter().map(|edge| edge.0).chain([until]);
    begin.zip(ends).map(|((begin, value), end)| (begin, end, value)).filter(|step| step.0 < step.1)
}

/// Whether a span lies in one of the others, but for their slack.
fn inside(spans: &[Lit], begin: Ns, end: Ns) -> bool {
    around(spans, begin).is_some_and(|span| end <= span.end + SLACK)
}

fn volts(
    given: &Given,
    verdict: &Verdict,
    allowed: &[Lit],
    required: &[Lit],
    edges: &[(Ns, i16)],
    waiting: i16,
    least: i16,
) -> Result<(), String> {
    for (begin, end, code) in steps(edges, 0, given.until) {
        let (begin, end) = (begin.max(given.from), end.min(given.until));
        if begin >= end {
            continue;
        }
        if code != 0 && is_safe(verdict, begin, end) {
            return Err(format!("code {code} from {begin} to {end}, where nothing at all may be output"));
        }
        if code > waiting + 2 && !inside(allowed, begin, end) {
            return Err(format!("code {code} from {begin} to {end} in the dark; light may be in {allowed:?}"));
        }
        let missed = |span: &&Lit| begin < span.end - SLACK && span.begin + SLACK < end;
        if let Some(span) = required.iter().find(missed).filter(|_| code < least - 2) {
            return Err(format!("code {code} from {begin} to {end}; there must be light in {span:?}"));
        }
    }
    Ok(())
}

fn switch(given: &Given, verdict: &Verdict, edges: &[(Ns, bool)]) -> Result<(), String> {
    let spans = |most| gate_spans(&verdict.gates, most, given.until);
    let allowed = spans(true);
    for (begin, end, level) in steps(edges, given.switch == Switch::Held, given.until) {
        let (begin, end) = (begin.max(given.from), end.min(given.until));
        if begin >= end {
            continue;
        }
        if level && is_safe(verdict, begin, end) {
            return Err(format!("the switch is on from {begin} to {end}, where nothing at all may be output"));
        }
        if given.switch == Switch::Held {
            continue;
        }
        if let Some(Fpk { time1, .. }) = given.timing.fpk {
            // A pulse that begins with light may outlast it.
            let good = |span: &Lit| {
                let last = span.end + SLACK + if span.cut { 0 } else { time1 };
                begin >= span.begin - SLACK && begin < span.end + SLACK && end <= last
            };
            if level && !allowed.iter().any(good) {
                return Err(format!("an FPK pulse from {begin} to {end}; the gate may be open in {allowed:?}"));
            }
            continue;
        }
        if level && !inside(&allowed, begin, end) {
            return Err(format!("the switch is on from {begin} to {end}; it may be in {allowed:?}"));
        }
        let required = spans(false);
        let missed = |span: &&Lit| begin < span.end - SLACK && span.begin + SLACK < end;
        if let Some(span) = required.iter().find(missed).filter(|_| !level) {
            return Err(format!("the switch is off from {begin} to {end}; it must be on in {span:?}"));
        }
    }
    Ok(())
}
