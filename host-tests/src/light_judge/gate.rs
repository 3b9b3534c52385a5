//! From gate commands to spans of light.
//!
//! In: gate commands in the order in which they were given. Out: spans that light may at most fill,
//! or must at least fill. The rule is SPEC 6's: a later command cancels every pending edge that
//! would take effect at or after its own.
use super::Ns;

/// What a gate command asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Darkness.
    Off,
    /// Either.
    Doubt,
    /// Light.
    On,
}

/// A gate command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gate {
    /// Not before.
    pub lo: Ns,
    /// Not after.
    pub hi: Ns,
    /// What it asks for.
    pub level: Level,
    /// Without delays, and the pulse in progress is cut.
    pub cut: bool,
    /// The delays in force, of on and off.
    pub delays: (Ns, Ns),
}

/// FPK times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fpk {
    /// Length of the pulse at the switch output.
    pub time1: Ns,
    /// From the gate to the energy.
    pub time2: Ns,
    /// From the gate's end to that of the energy.
    pub off: Ns,
}

/// Delays of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// onDelay.
    pub on: Ns,
    /// offDelay.
    pub off: Ns,
    /// FPK, if enabled.
    pub fpk: Option<Fpk>,
}

/// A span of light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lit {
    /// From.
    pub begin: Ns,
    /// To, not included.
    pub end: Ns,
    /// It ends without a last pulse.
    pub cut: bool,
}

#[derive(Debug, Clone, Copy)]
struct Edge {
    at: Ns,
    level: bool,
    cut: bool,
}

/// An edge cancels what would come at or after it; it stays where it changes the level, or ends
/// what is to come.
fn put(edges: &mut Vec<Edge>, mut edge: Edge, keeps_cuts: bool) {
    while let Some(last) = edges.pop_if(|last| last.at >= edge.at) {
        edge.cut |= last.cut && last.at == edge.at && !edge.level;
    }
    let level = edges.last().is_some_and(|last| last.level);
    if level != edge.level || keeps_cuts && edge.cut {
        edges.push(edge);
    }
}

/// The gate after its delays: the most that these commands may make of it, or the least.
fn gate_edges(gates: &[Gate], most: bool) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(gates.len());
    for gate in gates {
        let level = gate.level == Level::On || most && gate.level == Level::Doubt;
        let at = if level == most { gate.lo } else { gate.hi };
        let delay = match (gate.cut, level) {
            (true, _) => 0,
            (false, true) => gate.delays.0,
            (false, false) => gate.delays.1,
        };
        put(&mut edges, Edge { at: at + delay, level, cut: gate.cut }, true);
    }
    edges
}

/// Spans that edges make which come so much after those of the gate.
fn spans(gate: &[Edge], on: Ns, off: Ns, until: Ns) -> Vec<Lit> {
    let mut edges = Vec::with_capacity(gate.len());
    for edge in gate {
        let delay = match (edge.cut, edge.level) {
            (true, _) => 0,
            (false, true) => on,
            (false, false) => off,
        };
        put(&mut edges, Edge { at: edge.at + delay, ..*edge }, false);
    }
    let span = |pair: &[Edge]| {
        let (end, cut) = pair.get(1).map_or((until, false), |off| (off.at, off.cut));
        Lit { begin: pair[0].at, end, cut }
    };
    edges.chunks(2).map(span).filter(|lit| lit.begin < lit.end).collect()
}

/// Spans of the gate up to `until`: the most, or the least.
pub fn gate_spans(gates: &[Gate], most: bool, until: Ns) -> Vec<Lit> {
    spans(&gate_edges(gates, most), 0, 0, until)
}

/// Spans of light: the most, or the least.
pub fn light_spans(gates: &[Gate], timing: &Timing, most: bool, until: Ns) -> Vec<Lit> {
    let (on, off) = timing.fpk.map_or((0, 0), |fpk| (fpk.time2, fpk.off));
    spans(&gate_edges(gates, most), on, off, until)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gate(at: Ns, on: bool) -> Gate {
        Gate { lo: at, hi: at, level: if on { Level::On } else { Level::Off }, cut: false, delays: (0, 0) }
    }

    fn found(gates: &[Gate], on: Ns, off: Ns, fpk: Option<Fpk>) -> Vec<(Ns, Ns)> {
        let timing = Timing { on, off, fpk };
        let gates: Vec<Gate> = gates.iter().map(|gate| Gate { delays: (on, off), ..*gate }).collect();
        let of = |most| light_spans(&gates, &timing, most, 1000).iter().map(|lit| (lit.begin, lit.end)).collect();
        let (most, least): (Vec<_>, Vec<_>) = (of(true), of(false));
        assert_eq!(most, least);
        most
    }

    /// SPEC 6, "Gate", by hand.
    #[test]
    fn the_rule_of_delays() {
        assert_eq!(found(&[gate(0, true), gate(100, false)], 10, 20, None), [(10, 120)]);
        assert_eq!(found(&[gate(0, true), gate(100, false)], 20, 10, None), [(20, 110)]);
        // Shorter than onDelay − offDelay: no light.
        assert_eq!(found(&[gate(0, true), gate(10, false)], 20, 10, None), []);
        // Length 0 with the longer offDelay.
        assert_eq!(found(&[gate(0, true), gate(0, false)], 10, 30, None), [(10, 30)]);
        // An on within the off delay: no gap.
        assert_eq!(
            found(&[gate(0, true), gate(100, false), gate(105, true), gate(200, false)], 10, 30, None),
            [(10, 230)]
        );
        let fpk = Some(Fpk { time1: 5, time2: 7, off: 40 });
        assert_eq!(found(&[gate(0, true), gate(100, false)], 10, 20, fpk), [(17, 160)]);
    }

    #[test]
    fn a_cut_waits_for_nothing() {
        let cut = Gate { cut: true, ..gate(100, false) };
        assert_eq!(found(&[gate(0, true), cut], 10, 20, None), [(10, 100)]);
        assert_eq!(found(&[gate(95, true), cut], 10, 20, None), []);
        assert_eq!(found(&[gate(0, true), gate(90, false), cut], 10, 20, None), [(10, 100)]);
        let fpk = Some(Fpk { time1: 5, time2: 7, off: 40 });
        assert_eq!(found(&[gate(0, true), gate(70, false), cut], 10, 20, fpk), [(17, 100)]);
        assert_eq!(found(&[gate(0, true), cut, gate(110, true)], 10, 20, fpk), [(17, 100), (127, 1000)]);
    }

    #[test]
    fn doubt_asks_for_nothing() {
        let doubt = Gate { level: Level::Doubt, ..gate(50, true) };
        let timing = Timing { on: 0, off: 0, fpk: None };
        let spans = |most| light_spans(&[gate(0, true), doubt, gate(80, false)], &timing, most, 1000);
        assert_eq!((spans(true)[0].end, spans(false)[0].end), (80, 50));
        let wide = Gate { lo: 50, hi: 60, ..gate(0, false) };
        let spans = |most| light_spans(&[gate(0, true), wide], &timing, most, 1000);
        assert_eq!((spans(true)[0].end, spans(false)[0].end), (60, 50));
    }
}
