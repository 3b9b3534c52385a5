//! Rows of the shortest cycles, one after the other, with all streams busy: every edge is compared
//! with its place.
//!
//! The plan of `bring-up/src/shortest.rs`: cycles have the least length or six counts more, by a
//! pattern of 16; pulses begin with them and last 24 or 44 counts in turn; all axes step every 240
//! counts.
use super::captures::{edges_of, no_edges, not_right, other_width, spread};
use super::{Row, Verdict, all_of};
use crate::bring_up::lines::Figures;

const PATTERN: u16 = 0b1111_0101_1001_0000;
const MORE: i64 = 6;
const WIDTHS: [i64; 2] = [24, 44];
/// Edges of a line.
const EDGES: usize = 100;
/// A capture may take a count more or less.
const LIMIT: i64 = 1;
/// Steps come every so many counts; half a slot early or late they are still steps.
const STEP: f64 = 240.0;
const STEP_JITTER: f64 = 60.0;

pub const ROWS: &[Row] = &[
    Row {
        what: "shortest cycles of the energies, all streams busy",
        assumptions: &[10],
        judge: energies,
        remedy: "a burst of three half-words takes longer than 350 ns: raise `MIN_COUNTS` in servo/src/output/pwm_cycles.rs \
            by what is missing, and measure again",
    },
    Row {
        what: "shortest cycles of the switches, all streams busy",
        assumptions: &[10],
        judge: switches,
        remedy: "a burst of six half-words takes longer than 500 ns: raise `MIN_COUNTS` in servo/src/output/gate_cycles.rs \
            by what is missing, and measure again",
    },
    Row {
        what: "steps of 1 MHz beside the shortest cycles",
        assumptions: &[10],
        judge: steps,
        remedy: "DMA2 has no time left: set STEP_WIDTH_NS to 1000 in hal/src/stm32h743/settings.rs",
    },
];

/// Where the edges of 16 cycles and more lie that begin with this one of the pattern: the pulses'
/// beginnings, or their ends.
fn planned(first: usize, least: i64, ends: bool) -> impl Iterator<Item = i64> {
    let mut begin = 0;
    (first..).map(move |n| {
        let edge = begin + if ends { WIDTHS[n % 2] } else { 0 };
        begin += least + MORE * i64::from(PATTERN >> (n % 16) & 1);
        edge
    })
}

/// How many of these edges are where they should be, the first of them included, and by how much
/// the next one is not; else the most that one is off.
fn followed(edges: &[i64], least: i64, ends: bool) -> (usize, i64) {
    let from = |first: usize| {
        let planned: Vec<i64> = planned(first, least, ends).take(edges.len()).collect();
        let off = |n: usize| (edges[n] - edges[0]) - (planned[n] - planned[0]);
        let wrong = (0..edges.len()).find(|&n| off(n).abs() > LIMIT);
        match wrong {
            Some(n) => (n, off(n)),
            None => (edges.len(), (0..edges.len()).map(|n| off(n).abs()).max().unwrap_or(0)),
        }
    };
    // Of equal ones the nearest.
    (0..16).map(from).max_by_key(|&(right, off)| (right, -off.abs())).unwrap_or((0, 0))
}

/// Captures of a line, each of so many edges.
fn captures(figures: &Figures, name: &str, jumper: usize) -> Result<Vec<Vec<i64>>, Verdict> {
    let lines = figures.all(name);
    if let Some(verdict) = not_right(figures, jumper).filter(|_| !lines.is_empty()) {
        return Err(verdict);
    }
    if lines.iter().all(|counts| counts.is_empty()) {
        return Err(no_edges(figures, name, jumper));
    }
    Ok(lines.iter().map(|counts| edges_of(counts)).collect())
}

/// What is wrong with these lines, or how near all edges are.
fn judged(figures: &Figures, which: usize, lines: &[(&str, &str, usize)]) -> Verdict {
    let Some(least) = figures.only::<2>("short-least") else { return Verdict::missing("short-least") };
    let (mut wrong, mut count, mut most) = (Vec::new(), 0, 0);
    let mut missing = None;
    for (line, of, jumper) in lines {
        for (ends, edge) in [(false, "begins"), (true, "ends")] {
            let all = match captures(figures, &format!("{line}-{edge}"), *jumper) {
                Ok(all) => all,
                Err(verdict) => {
                    missing = missing.or(Some(verdict));
                    continue;
                }
            };
            for edges in all {
                let (right, off) = followed(&edges, least[which], ends);
                if edges.len() < EDGES {
                    wrong.push(format!("{of} {edge}: {} edges of {EDGES}", edges.len()));
                } else if right < edges.len() {
                    wrong.push(format!("{of} {edge}: edge {right} is {off:+} counts off"));
                }
                (count, most) = (count + right, most.max(off));
            }
        }
    }
    // The first of a line says enough.
    wrong.dedup_by_key(|text| text.split(':').next().map(str::to_owned));
    // What is wrong of one laser counts, also where the other one was not measured.
    if let Some(missing) = missing.filter(|_| wrong.is_empty()) {
        return missing;
    }
    let [least, more] = [least[which], least[which] + MORE];
    let link = if figures.only("short-link") == Some([1]) { "busy" } else { "idle" };
    let good = format!(
        "{count} edges of cycles of {least} and {more} counts, {most} counts off at most; the link's stream {link}"
    );
    all_of(wrong, &good)
}

fn energies(figures: &Figures) -> Verdict {
    judged(figures, 0, &[("short-0", "laser 0", 1), ("short-1", "laser 1", 2)])
}

fn switches(figures: &Figures) -> Verdict {
    judged(figures, 1, &[("short-switch", "switch 0", 3)])
}

fn steps(figures: &Figures) -> Verdict {
    if let Some(verdict) = other_width(figures) {
        return verdict;
    }
    let all = match captures(figures, "short-steps", 4) {
        Ok(all) => all,
        Err(verdict) => return verdict,
    };
    let jitter = all.iter().map(|edges| spread(edges, STEP)).fold(0.0, f64::max);
    let count: usize = all.iter().map(Vec::len).sum();
    let holds = jitter < STEP_JITTER && all.iter().all(|edges| edges.len() == EDGES);
    Verdict::of(holds, format!("{count} steps, jitter {jitter} counts"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wherever in the pattern a capture begins, one wrong length or width is found.
    #[test]
    fn an_edge_that_is_not_where_it_should_be_is_found() {
        for (first, ends) in (0..16).flat_map(|first| [(first, false), (first, true)]) {
            let good: Vec<i64> = planned(first, 84, ends).take(EDGES).map(|edge| edge + 777).collect();
            assert_eq!(followed(&good, 84, ends), (EDGES, 0));
            for late in 1..EDGES {
                // This cycle repeats the length of the one before it, where that is another one.
                let length = |n: usize| 84 + MORE * i64::from(PATTERN >> (n % 16) & 1);
                let more = length(first + late - 1) - length(first + late);
                let bad: Vec<i64> = (0..EDGES).map(|n| good[n] + if n > late { more } else { 0 }).collect();
                assert_eq!(followed(&bad, 84, ends).0 == EDGES, more == 0 || late + 1 == EDGES, "{first} {late}");
                // Its pulse is as wide as the one before it.
                let more = if ends { WIDTHS[(first + late - 1) % 2] - WIDTHS[(first + late) % 2] } else { 2 };
                let bad: Vec<i64> = (0..EDGES).map(|n| good[n] + if n == late { more } else { 0 }).collect();
                assert!(followed(&bad, 84, ends).0 < EDGES, "{first} {late}");
            }
        }
        let mut near: Vec<i64> = planned(3, 84, false).take(EDGES).collect();
        near[50] += 1;
        assert_eq!(followed(&near, 84, false), (EDGES, 1));
    }

    #[test]
    fn edges_that_are_missing_fail() {
        let mut figures = Figures::default();
        figures.add("short-least", vec![84, 120]);
        figures.add("wire", vec![3, 4]);
        let edges: Vec<i64> = planned(0, 120, false).take(EDGES).collect();
        let ends: Vec<i64> = planned(0, 120, true).take(EDGES - 1).collect();
        let counts = |edges: &[i64]| edges.iter().map(|edge| edge % 12_000).collect::<Vec<i64>>();
        figures.add("short-switch-begins", counts(&edges));
        figures.add("short-switch-ends", counts(&ends));
        assert_eq!(switches(&figures), Verdict::Fail("switch 0 ends: 99 edges of 100".to_owned()));
    }
}
