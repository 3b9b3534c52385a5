//! Rows that edges at the ends of jumpers decide, in counts of 240 MHz.
//!
//! The plan of `bring-up/src/light.rs`: light begins 2400 counts after a tick, in pulses of 240
//! counts every 1200; under load two lasers have periods of 120 and 121 counts in turn, and eight
//! axes a step every 240. A tick is 12,000 counts.
use super::{Row, Verdict, all_parts, peripherals};
use crate::bring_up::lines::Figures;

/// Counts of a tick of 50 µs.
pub const TICK: i64 = 12_000;
/// Where light begins in its tick, its period and its pulse.
const BEGIN: i64 = 2400;
const PERIOD: i64 = 1200;
const PULSE: i64 = 240;

/// Jumpers by their numbers (docs/bring-up.md).
pub const JUMPERS: [&str; 12] = [
    "D6–D32",
    "D58–D23",
    "D21–D36",
    "D61–A0",
    "D42–D35",
    "D2–D37, D60, D49, D20",
    "D24–A2",
    "D13–A4",
    "D0–GND",
    "D65–D25, D29",
    "D64–D11, D28",
    "D50–A3, D10",
];

pub const ROWS: &[Row] = &[
    Row {
        what: "jumpers",
        assumptions: &[],
        judge: jumpers,
        remedy: "put each jumper where docs/bring-up.md says, and measure again",
    },
    Row {
        what: "TIM1, TIM15 and TIM8 start by their triggers",
        assumptions: &[15],
        judge: running,
        remedy: "compare TS of each with the tables of internal triggers (RM0433 38.4.3, 41.5.3), `launch` in hal/src/stm32h743/laser.rs",
    },
    Row {
        what: "first edges after their tick",
        assumptions: &[11],
        judge: first_edges,
        remedy: "one offset for all is harmless; if they differ, set each timer's CNT at `arm` in hal/src/stm32h743/pwm_dma.rs to the difference",
    },
    Row {
        what: "a step after its slot",
        assumptions: &[11],
        judge: first_step,
        remedy: "DMA takes longer than half a slot: enlarge `MARGIN_SLOTS` and the phase of TIM17 in hal/src/stm32h743/steps.rs",
    },
    Row {
        what: "cycles of 2 MHz, all streams busy",
        assumptions: &[10],
        judge: load,
        remedy: "a burst came late (one count may be the capture's): raise `MIN_COUNTS` in servo/src/output/pwm_cycles.rs",
    },
    Row {
        what: "steps of 1 MHz, all streams busy",
        assumptions: &[10],
        judge: load_steps,
        remedy: "DMA2 has no time left: set STEP_WIDTH_NS to 1000 in hal/src/stm32h743/settings.rs",
    },
    Row {
        what: "each step is played once",
        assumptions: &[14],
        judge: steps,
        remedy: "clear later: raise TIM17's CCR1 to half a slot in `start` of hal/src/stm32h743/steps.rs",
    },
    Row {
        what: "a stream keeps its position while its timer is stopped",
        assumptions: &[13],
        judge: stream,
        remedy: "`locate` in hal/src/stm32h743/steps.rs must find the slot anew after each overrun",
    },
    Row {
        what: "a slot that nobody has filled is dark and stops the timer",
        assumptions: &[12],
        judge: starved,
        remedy: "keep the lasers off: ARR 0 does not block that timer; `safe_state` in hal/src/stm32h743/laser.rs must come from a timer's interrupt instead",
    },
    Row {
        what: "light after a burst that was broken off",
        assumptions: &[9],
        judge: again,
        remedy: "RCC does not reset the burst: finish it by writes to DMAR before `reset` in hal/src/stm32h743/laser.rs",
    },
    Row {
        what: "from the interlock to dark",
        assumptions: &[2],
        judge: break_time,
        remedy: "keep the lasers off: compare AF1, BDTR and the pin's alternate function with RM0433 38.3.16 (`set_up` in hal/src/stm32h743/laser.rs)",
    },
    Row {
        what: "energy − after + at a break",
        assumptions: &[3],
        judge: break_minus,
        remedy: "a device on the − line alone gets light for so long: use + and −, or a buffer that needs both",
    },
    Row {
        what: "energy − after + at a safe state",
        assumptions: &[4],
        judge: off_minus,
        remedy: "a device on the − line alone gets light for so long: use + and −, or a buffer that needs both",
    },
    Row {
        what: "analog outputs within a tick",
        assumptions: &[24],
        judge: settling,
        remedy: "light by voltage lags: compare DAC_MCR with RM0433 26.7.16 (`open` in hal/src/stm32h743/analog.rs), measure the load at the pin",
    },
    Row {
        what: "analog inputs by analog outputs",
        assumptions: &[22],
        judge: analog,
        remedy: "lengthen SMPR in hal/src/stm32h743/adc.rs to 387.5 cycles; if that changes nothing, compare ADC's clock and calibration with RM0433 25.4",
    },
];

/// Jumpers at which TIM2 captures, and the ends of each.
const ENDS: [&str; 6] = ["D32", "D23", "D36", "A0", "D35", "D37, D60, D49 and D20"];

/// Where a jumper is.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Place {
    Right,
    Missing,
    /// What follows its pin instead.
    Wrong(String),
}

/// Where this one of the first six jumpers is: each line has the ends that follow its pin, a bit
/// each. `None` where the board has not looked.
fn place(figures: &Figures, jumper: usize) -> Option<Place> {
    let wires = figures.each::<2>("wire")?;
    let [_, follow] = wires.into_iter().find(|[number, _]| *number == jumper as i64)?;
    Some(match follow {
        0 => Place::Missing,
        _ if follow == 1 << (jumper - 1) => Place::Right,
        _ => {
            let ends = ENDS.iter().enumerate().filter(|(n, _)| follow >> n & 1 != 0).map(|(_, end)| *end);
            Place::Wrong(format!("jumper {jumper} ends at {}", ends.collect::<Vec<_>>().join(", ")))
        }
    })
}

/// Why what a jumper measures is not measured, if it is not right.
pub fn not_right(figures: &Figures, jumper: usize) -> Option<Verdict> {
    match place(figures, jumper) {
        Some(Place::Right) => None,
        Some(Place::Wrong(how)) => Some(Verdict::NotMeasured(format!("{how}, not at {}", ENDS[jumper - 1]))),
        _ => Some(Verdict::NotMeasured(format!("jumper {jumper} ({}) is missing", JUMPERS[jumper - 1]))),
    }
}

/// Why a line has no edges: without the jumper nobody knows.
pub fn no_edges(figures: &Figures, name: &str, jumper: usize) -> Verdict {
    let is_closed = figures.each::<4>("break").is_some_and(|lines| lines.iter().any(|[_, level, ..]| *level == 0));
    if figures.all(name).is_empty() {
        // Without the sixth jumper nothing lights or steps.
        let looked = figures.each::<2>("wire").is_some();
        let why = [jumper, 6].into_iter().filter(|_| looked).find_map(|jumper| not_right(figures, jumper));
        why.unwrap_or_else(|| Verdict::missing(name))
    } else if let Some(verdict) = not_right(figures, jumper) {
        verdict
    } else if !is_closed {
        Verdict::NotMeasured("the interlock is open: jumper 6 is missing".to_owned())
    } else {
        Verdict::Fail("no edge".to_owned())
    }
}

/// Edges of a line, each after the one before: what comes at a smaller count comes in the next
/// tick.
fn edges(figures: &Figures, name: &str, jumper: usize) -> Result<Vec<i64>, Verdict> {
    let counts = match figures.all(name) {
        [counts] if !counts.is_empty() && not_right(figures, jumper).is_none() => counts,
        _ => return Err(no_edges(figures, name, jumper)),
    };
    Ok(edges_of(counts))
}

/// Edges of these counts, likewise.
pub fn edges_of(counts: &[i64]) -> Vec<i64> {
    let (mut ticks, mut before) = (0, -1);
    let edge = |&count: &i64| {
        ticks += i64::from(count <= before);
        before = count;
        ticks * TICK + count
    };
    counts.iter().map(edge).collect()
}

/// The verdict of a judgement that may lack its edges.
fn judged(judgement: Result<Verdict, Verdict>) -> Verdict {
    judgement.unwrap_or_else(|verdict| verdict)
}

fn jumpers(figures: &Figures) -> Verdict {
    let places: Option<Vec<Place>> = (1..=ENDS.len()).map(|number| place(figures, number)).collect();
    let Some(places) = places else { return Verdict::missing("wire") };
    let wrong: Vec<&str> = places
        .iter()
        .filter_map(|place| if let Place::Wrong(how) = place { Some(how.as_str()) } else { None })
        .collect();
    if !wrong.is_empty() {
        return Verdict::Fail(wrong.join("; "));
    }
    let missing = (1..).zip(&places).filter(|(_, place)| **place == Place::Missing).map(|(number, _)| number);
    let is_low = figures.only::<10>("low-supply").is_some_and(|[is_low, ..]| is_low == 1);
    let rest = (7..=8)
        .filter(|number| !has_loop(figures, *number))
        .chain((!is_low).then_some(9))
        .chain(peripherals::missing_jumpers(figures));
    let missing: Vec<usize> = missing.chain(rest).collect();
    let named = |number: &usize| format!("{number} ({})", JUMPERS.get(number - 1).copied().unwrap_or("unknown"));
    Verdict::Figure(match missing.as_slice() {
        [] => "all twelve".to_owned(),
        missing => {
            let others = if missing.contains(&6) { "; without jumper 6 the first five are not looked for" } else { "" };
            format!("missing: {}{others}", missing.iter().map(named).collect::<Vec<_>>().join(", "))
        }
    })
}

fn running(figures: &Figures) -> Verdict {
    let Some(on @ [one, fifteen, eight]) = figures.only("running") else { return Verdict::missing("running") };
    Verdict::of(on == [1; 3], format!("TIM1 {one}, TIM15 {fifteen}, TIM8 {eight}"))
}

fn first_edges(figures: &Figures) -> Verdict {
    judged((|| {
        let mut offsets = [0; 3];
        for (offset, (name, jumper)) in offsets.iter_mut().zip([("first-0", 1), ("first-1", 2), ("first-switch", 3)]) {
            *offset = edges(figures, name, jumper)?[0] - BEGIN;
        }
        let (least, most) = (offsets.iter().min().unwrap_or(&0), offsets.iter().max().unwrap_or(&0));
        let [zero, one, switch] = offsets;
        // A capture is late by some counts itself.
        let holds = *least >= -2 && *most <= 32 && most - least <= 8;
        Ok(Verdict::of(holds, format!("laser 0 {zero}, laser 1 {one}, switch {switch} counts")))
    })())
}

fn first_step(figures: &Figures) -> Verdict {
    if let Some(verdict) = other_width(figures) {
        return verdict;
    }
    judged(edges(figures, "first-steps", 4).map(|edges| {
        // Slots are 120 counts; their requests come in the middle between two multiples.
        let late = (edges[0] - 60).rem_euclid(120);
        Verdict::of(late < 60, format!("{late} counts"))
    }))
}

/// The width of a step pulse for which steps are planned.
const STEP_WIDTH_NS: i64 = 500;

/// Why steps are not measured: their pulses have another width.
pub fn other_width(figures: &Figures) -> Option<Verdict> {
    let [width] = figures.only("step-width").filter(|width| *width != [STEP_WIDTH_NS])?;
    Some(Verdict::NotMeasured(format!("STEP_WIDTH_NS is {width} in settings.rs, this row wants {STEP_WIDTH_NS}")))
}

/// How far edges spread about a line of equal steps, in counts.
pub fn spread(edges: &[i64], step: f64) -> f64 {
    let off = edges.iter().enumerate().map(|(n, edge)| *edge as f64 - step * n as f64);
    let (least, most) = off.fold((f64::MAX, f64::MIN), |(least, most), off| (least.min(off), most.max(off)));
    most - least
}

/// Half of the periods of a tick of 50 µs are a count longer, and come first: so far is one from
/// the line of the mean.
const LOAD_SPREAD: f64 = 25.0;
/// Two falling edges in turn: a period of 120 or 121 counts, and a width that changes by one.
const LOAD_GAPS: std::ops::RangeInclusive<i64> = 119..=122;

fn load(figures: &Figures) -> Verdict {
    judged((|| {
        let Some([late]) = figures.only("load-late") else { return Ok(Verdict::missing("load-late")) };
        let (zero, one) = (edges(figures, "load-0", 1)?, edges(figures, "load-1", 2)?);
        let spreads = [spread(&zero, 120.5), spread(&one, 120.5)];
        let follows =
            |edges: &[i64]| edges.len() == 100 && edges.windows(2).all(|pair| LOAD_GAPS.contains(&(pair[1] - pair[0])));
        let is_near = spreads.iter().all(|spread| *spread <= LOAD_SPREAD);
        let holds = late == 0 && follows(&zero) && follows(&one) && is_near;
        let [zero_spread, one_spread] = spreads;
        Ok(Verdict::of(
            holds,
            format!(
                "{} and {} edges, {zero_spread} and {one_spread} counts about their line, of {LOAD_SPREAD}; {late} ticks late",
                zero.len(),
                one.len()
            ),
        ))
    })())
}

fn load_steps(figures: &Figures) -> Verdict {
    if let Some(verdict) = other_width(figures) {
        return verdict;
    }
    // Steps alone are no load. A laser whose jumper is missing is not seen.
    let is_dark = [("load-0", 1), ("load-1", 2)].into_iter().any(|(name, jumper)| match edges(figures, name, jumper) {
        Ok(edges) => edges.len() < 100,
        Err(verdict) => matches!(verdict, Verdict::Fail(_)),
    });
    judged(edges(figures, "load-steps", 4).map(|edges| {
        let (spread, count) = (spread(&edges, 240.0), edges.len());
        let light = if is_dark { "; light beside them ended" } else { "" };
        let holds = spread < 60.0 && count == 100 && !is_dark;
        Verdict::of(holds, format!("{count} steps, jitter {spread} counts{light}"))
    }))
}

fn steps(figures: &Figures) -> Verdict {
    if let Some(verdict) = other_width(figures) {
        return verdict;
    }
    let Some([planned, captured]) = figures.only("steps") else { return Verdict::missing("steps") };
    if let Some(verdict) = not_right(figures, 4) {
        return verdict;
    }
    Verdict::of(planned == captured, format!("{captured} of {planned}"))
}

fn stream(figures: &Figures) -> Verdict {
    let Some([running, stopped, later, resumed]) = figures.only("stream") else { return Verdict::missing("stream") };
    // Of a ring of 1024 slots: until it stands, and after it goes on.
    let (before, after) = ((running - stopped).rem_euclid(1024), (later - resumed).rem_euclid(1024));
    let holds = stopped == later && before <= 8 && (1..=64).contains(&after);
    Verdict::of(holds, format!("NDTR {running}, {stopped} and later {later}, {after} slots after it goes on"))
}

/// Items of the rings of TIM1, TIM15 and TIM8, and the jumper of a line of each.
const RINGS: [(i64, i64, usize); 3] = [(1, 3456, 1), (15, 3456, 2), (8, 1632, 3)];

fn starved(figures: &Figures) -> Verdict {
    let Some(lines) = figures.each::<6>("starved") else { return Verdict::missing("starved") };
    let (mut wrong, mut good, mut missing) = (Vec::new(), Vec::new(), Vec::new());
    for ([timer, lit, before, after, edges, level], (_, items, jumper)) in lines.into_iter().zip(RINGS) {
        if lit == 0 || not_right(figures, jumper).is_some() {
            match no_edges(figures, "starved", jumper) {
                Verdict::Fail(how) => wrong.push(format!("TIM{timer}: {how}")),
                verdict => missing.push((format!("TIM{timer}"), verdict)),
            }
            continue;
        }
        let read = (before - after).rem_euclid(items);
        let text = format!("TIM{timer} {lit} edges before, {edges} after, {read} items read, level {level}");
        // A + line is dark while it is high.
        let holds = (read, edges, level) == (0, 0, 1);
        if holds { good.push(text) } else { wrong.push(text) }
    }
    all_parts(wrong, &good.join("; "), missing)
}

fn again(figures: &Figures) -> Verdict {
    judged((|| {
        let mut wrong = Vec::new();
        // TIM8's: the switch has one edge.
        let switches = [edges(figures, "first-switch", 3)?, edges(figures, "again-switch", 3)?];
        if switches[0] != switches[1] {
            wrong.push(format!("switch: {:?}, then {:?}", switches[0], switches[1]));
        }
        for (name, jumper) in [("first-0", 1), ("first-1", 2), ("again-0", 1), ("again-1", 2)] {
            let edges = edges(figures, name, jumper)?;
            let expected = (0..24).map(|n| n / 2 * PERIOD + n % 2 * PULSE);
            let is_planned = edges.len() == 24 && edges.iter().map(|edge| edge - edges[0]).eq(expected);
            if !is_planned {
                wrong.push(format!("{name}: {:?} …", &edges[..edges.len().min(4)]));
            }
        }
        Ok(if wrong.is_empty() {
            Verdict::Pass("both lasers and the switch to the count, before and after".to_owned())
        } else {
            Verdict::Fail(wrong.join("; "))
        })
    })())
}

fn break_time(figures: &Figures) -> Verdict {
    judged((|| {
        let Some(left) = figures.only::<3>("break-left") else {
            return Err(Verdict::NotMeasured(format!(
                "jumper 6 ({}) is missing, the board sent no `break-left`",
                JUMPERS[5]
            )));
        };
        let (input, plus) = (edges(figures, "break-input", 6)?, edges(figures, "break-plus", 2)?);
        let counts = plus[0] - input[0];
        let holds = (-2..=24).contains(&counts) && plus.len() == 1 && left == [0; 3];
        let [one, fifteen, eight] = left;
        Ok(Verdict::of(holds, format!("{counts} counts, MOE of TIM1 {one}, TIM15 {fifteen}, TIM8 {eight} after it")))
    })())
}

fn break_minus(figures: &Figures) -> Verdict {
    judged((|| {
        if figures.all("break-left").is_empty() {
            return Err(Verdict::NotMeasured(format!(
                "jumper 6 ({}) is missing, the board sent no `break-left`",
                JUMPERS[5]
            )));
        }
        minus(edges(figures, "break-plus", 2)?[0], &edges(figures, "break-minus", 5)?)
    })())
}

fn off_minus(figures: &Figures) -> Verdict {
    judged((|| minus(edges(figures, "off-plus", 1)?[0], &edges(figures, "off-minus", 5)?))())
}

/// Lines of two timers of one clock: − may be lit for some counts more.
fn minus(plus: i64, minus: &[i64]) -> Result<Verdict, Verdict> {
    let more = minus[0] - plus;
    Ok(Verdict::of((-2..=6).contains(&more), format!("{more} counts ({:.0} ns)", more as f64 * 25.0 / 6.0)))
}

/// Lines of a loop: code of the output, of the input after a tick, and settled.
fn loops(figures: &Figures, output: i64) -> Vec<[i64; 3]> {
    let all = figures.each::<4>("loop").unwrap_or_default();
    all.into_iter().filter(|line| line[0] == output).map(|[_, code, first, settled]| [code, first, settled]).collect()
}

/// Whether the input follows the output at all.
fn has_loop(figures: &Figures, number: usize) -> bool {
    let settled = loops(figures, number as i64 - 6).into_iter().map(|[.., settled]| settled);
    let (least, most) = settled.fold((i64::MAX, i64::MIN), |(least, most), code| (least.min(code), most.max(code)));
    most.saturating_sub(least) > 5000 && least < most
}

/// The largest difference in all loops that are there, in codes of 65536.
fn largest(figures: &Figures, limit: i64, difference: fn(&[i64; 3]) -> i64) -> Verdict {
    if figures.all("loop").is_empty() {
        return Verdict::missing("loop");
    }
    let (mut wrong, mut good, mut missing) = (Vec::new(), Vec::new(), Vec::new());
    for number in 7..=8 {
        let output = number - 6;
        if !has_loop(figures, number) {
            let why = Verdict::NotMeasured(format!("jumper {number} ({}) is missing", JUMPERS[number - 1]));
            missing.push((format!("output {output}"), why));
            continue;
        }
        let most = loops(figures, output as i64).iter().map(|line| difference(line).abs()).max().unwrap_or(0);
        let figure = format!("output {output} {most}");
        if most <= limit { good.push(figure) } else { wrong.push(figure) }
    }
    let of = |all: &[String]| {
        if all.is_empty() { String::new() } else { format!("{}, of {limit} in 65536", all.join(", ")) }
    };
    all_parts(if wrong.is_empty() { wrong } else { vec![of(&wrong)] }, &of(&good), missing)
}

fn settling(figures: &Figures) -> Verdict {
    // A quarter of a ‰.
    largest(figures, 64, |[_, first, settled]| first - settled)
}

fn analog(figures: &Figures) -> Verdict {
    // The converter's own offset is up to 10 of its 4096 codes, and its gain 0.5 % (DS12110, DAC
    // characteristics).
    largest(figures, 400, |[code, _, settled]| settled - code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_go_on_over_ticks_and_a_lost_edge_spreads() {
        let mut figures = Figures::default();
        figures.add("wire", vec![1, 1]);
        figures.add("a", vec![11_000, 11_120, 41, 161, 161]);
        assert_eq!(edges(&figures, "a", 1), Ok(vec![11_000, 11_120, 12_041, 12_161, 24_161]));
        assert_eq!(spread(&[7, 128, 248, 369], 120.5), 0.5);
        // A cycle that repeats the one before it.
        assert_eq!(spread(&[7, 128, 249, 369, 490], 120.5), 1.0);
    }

    #[test]
    fn steps_of_another_width_are_not_measured() {
        let mut figures = Figures::default();
        figures.add("step-width", vec![2500]);
        figures.add("steps", vec![100, 50]);
        let why = "STEP_WIDTH_NS is 2500 in settings.rs, this row wants 500".to_owned();
        for judge in [first_step, load_steps, steps] {
            assert_eq!(judge(&figures), Verdict::NotMeasured(why.clone()));
        }
        let mut figures = Figures::default();
        figures.add("step-width", vec![500]);
        figures.add("wire", vec![4, 8]);
        figures.add("steps", vec![100, 50]);
        assert!(matches!(steps(&figures), Verdict::Fail(_)));
    }

    /// One timer, or one output, was not measured: the row says which, and passes for none.
    #[test]
    fn a_part_that_was_not_measured_leaves_the_row_unsettled() {
        let mut figures = Figures::default();
        for line in [[1, 1], [2, 0], [3, 4], [6, 32]] {
            figures.add("wire", line.to_vec());
        }
        for line in [[1, 12, 9, 9, 0, 1], [15, 0, 9, 9, 0, 1], [8, 12, 9, 9, 0, 1]] {
            figures.add("starved", line.to_vec());
        }
        let Verdict::NotMeasured(why) = starved(&figures) else { panic!() };
        let good = "; measured: TIM1 12 edges before, 0 after, 0 items read, level 1; TIM8 12 ";
        assert!(why.starts_with(&format!("TIM15: jumper 2 (D58–D23) is missing{good}")), "{why}");
        for line in [[1, 0, 0, 0], [1, 60_000, 60_000, 60_000], [2, 0, 0, 0], [2, 60_000, 0, 0]] {
            figures.add("loop", line.to_vec());
        }
        let why = "output 2: jumper 8 (D13–A4) is missing; measured: output 1 0, of 400 in 65536";
        assert_eq!(analog(&figures), Verdict::NotMeasured(why.to_owned()));
    }

    #[test]
    fn a_missing_jumper_is_named_and_is_no_fail() {
        let mut figures = Figures::default();
        figures.add("first-0", vec![]);
        let missing = Verdict::NotMeasured("jumper 1 (D6–D32) is missing".to_owned());
        assert_eq!(edges(&figures, "first-0", 1), Err(missing));
        figures.add("wire", vec![1, 1]);
        let open = Verdict::NotMeasured("the interlock is open: jumper 6 is missing".to_owned());
        assert_eq!(edges(&figures, "first-0", 1), Err(open));
        figures.add("break", vec![1, 0, 0, 1]);
        assert_eq!(edges(&figures, "first-0", 1), Err(Verdict::Fail("no edge".to_owned())));
    }
}
