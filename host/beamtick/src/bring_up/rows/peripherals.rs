//! Rows of what a locked-up core leaves to the chip, of encoders, and of SPI3.
//!
//! The plans of `bring-up/src/lock_up.rs`, `turns.rs` and `spi3.rs`: light has an edge every 1200
//! counts of 240 MHz, encoders turn by ten lines and back, bytes are 8 bits of 32 MHz.
use super::captures::{self, JUMPERS, TICK};
use super::{Row, Verdict, all_parts};
use crate::bring_up::lines::Figures;
use crate::summary::counted;

pub const ROWS: &[Row] = &[
    Row {
        what: "the watchdog's time",
        assumptions: &[35],
        judge: watchdog,
        remedy: "LSI or the divider is another one: compare PR, RLR and SR of IWDG1 with RM0433 44.4, set BITES_AFTER_MS in hal/src/stm32h743/watchdog.rs \
            and the times in docs/safety.md",
    },
    Row {
        what: "a locked-up core ends light",
        assumptions: &[5],
        judge: lock_up,
        remedy: "light lasts until what is queued is over: compare SYSCFG_CFGR.CM7L with RM0433 12.3.5, `BREAKS` in hal/src/stm32h743/clocks.rs, and say so in \
            docs/safety.md",
    },
    Row {
        what: "encoders count four a line, to and fro",
        assumptions: &[36],
        judge: counts,
        remedy: "compare SMCR.SMS, CCMR1 and the pins' alternate functions with RM0433 39.3.19, `open` in hal/src/stm32h743/encoders.rs",
    },
    Row {
        what: "an index is latched at the delay of A and B",
        assumptions: &[36],
        judge: index,
        remedy: "first the gap, which is a guess: D50 and D65 by a scope, 10 to 30 ns between their edges. Another gap: change the count \
            of `nop` in `index_beside` of bring-up/src/turns.rs, measure anew. That gap: homes differ by a count by direction; \
            give the index the filter of A and B (ICxF, RM0433 39.3.5), `open` in hal/src/stm32h743/encoders.rs",
    },
    Row {
        what: "a byte of SPI3",
        assumptions: &[37],
        judge: spi3,
        remedy: "the external DAC would get another clock: compare RCC_D2CCIP1R.SPI123SEL and CKPERSEL with RM0433 8.7.19, SPI_CFG1.MBR and \
            CFG2 with RM0433 50.11, `open` in hal/src/stm32h743/spi.rs",
    },
];

/// The watchdog counts 800 cycles of LSI / 4. LSI is within these limits over all temperatures, in
/// kHz (DS12110).
const LSI_KHZ: std::ops::RangeInclusive<f64> = 29.76..=33.6;
/// The last mark is up to a tick before the reset, and the feeding takes some cycles of LSI.
const SLACK_MS: f64 = 0.3;

fn watchdog(figures: &Figures) -> Verdict {
    let Some([counts]) = figures.only("watchdog") else { return Verdict::missing("watchdog") };
    let ms = counts as f64 / 240e3;
    let (least, most) = (3200.0 / LSI_KHZ.end() - SLACK_MS, 3200.0 / LSI_KHZ.start() + SLACK_MS);
    let holds = (least..=most).contains(&ms);
    Verdict::of(holds, format!("{ms:.1} ms, of {least:.1} to {most:.1}: LSI {:.1} kHz", 3200.0 / ms.max(0.1)))
}

/// In this time after the lock-up it is dark, in counts: the next edge of light is later.
const DARK_COUNTS: i64 = 240;

fn lock_up(figures: &Figures) -> Verdict {
    let (mut wrong, mut good, mut missing) = (Vec::new(), Vec::new(), Vec::new());
    for (name, laser, jumper) in [("lock-up-0", 0, 1), ("lock-up-1", 1, 2)] {
        let [numbers] = figures.all(name) else { return Verdict::missing(name) };
        let [at, before, edges @ ..] = numbers.as_slice() else { return Verdict::missing(name) };
        if *before == 0 || captures::not_right(figures, jumper).is_some() {
            match captures::no_edges(figures, name, jumper) {
                Verdict::Fail(how) => wrong.push(format!("laser {laser}: {how}")),
                verdict => missing.push((format!("laser {laser}"), verdict)),
            }
            continue;
        }
        match edges.get(*before as usize..).unwrap_or_default() {
            [] => wrong.push(format!("laser {laser}: stays lit")),
            [edge] if (edge - at).rem_euclid(TICK) <= DARK_COUNTS => {
                good.push(format!("laser {laser} dark {} counts after it", (edge - at).rem_euclid(TICK)));
            }
            more => wrong.push(format!("laser {laser}: {} after it", counted(more.len() as i64, "edge", "edges"))),
        }
    }
    all_parts(wrong, &good.join(", "), missing)
}

/// Jumpers of A, B and the index.
const ENCODER_JUMPERS: [usize; 3] = [10, 11, 12];

/// Those of the three that do not end where they should: both timers' ends must follow.
pub fn missing_jumpers(figures: &Figures) -> Vec<usize> {
    let lines = figures.each::<4>("encoder").unwrap_or_default();
    let is_there = |n: usize| !lines.is_empty() && lines.iter().all(|[_, follow, ..]| follow >> n & 1 == 1);
    ENCODER_JUMPERS.into_iter().enumerate().filter(|(n, _)| !is_there(*n)).map(|(_, jumper)| jumper).collect()
}

/// Both timers, if the ends of this mask follow, by `judge`: whether it holds, and the figure.
fn of_timers<const N: usize>(
    figures: &Figures,
    name: &str,
    mask: i64,
    judge: impl Fn([i64; N]) -> (bool, String),
) -> Verdict {
    let (Some(ends), Some(lines)) = (figures.each::<4>("encoder"), figures.each::<N>(name)) else {
        return Verdict::missing(name);
    };
    let (mut wrong, mut good, mut missing) = (Vec::new(), Vec::new(), Vec::new());
    for ([timer, follow, ..], line) in ends.into_iter().zip(lines) {
        if follow & mask == mask {
            let (holds, figure) = judge(line);
            if holds { good.push(figure) } else { wrong.push(figure) }
        } else {
            let jumpers = ENCODER_JUMPERS.into_iter().enumerate().filter(|(n, _)| (mask & !follow) >> n & 1 == 1);
            let named: Vec<String> = jumpers.map(|(_, jumper)| format!("{jumper} ({})", JUMPERS[jumper - 1])).collect();
            let why = Verdict::NotMeasured(format!("its end of jumper {} is missing", named.join(", ")));
            missing.push((format!("TIM{timer}"), why));
        }
    }
    all_parts(wrong, &good.join("; "), missing)
}

fn counts(figures: &Figures) -> Verdict {
    of_timers(figures, "encoder", 0b011, |[timer, _, forward, back]| {
        ((forward, back) == (40, -40), format!("TIM{timer} {forward}, then {back}, of 40 and -40"))
    })
}

/// What the row says of the time between an index and the edge beside it. It must be longer than a
/// sample of the filters (4.2 ns) and shorter than their delay (33 ns); `index_beside` of the image
/// counts instructions, and no timer sees both edges.
const GAP: &str = "10 to 30 ns between index and edge are assumed, not measured";

fn index(figures: &Figures) -> Verdict {
    let with_gap = |figure: String| format!("{figure}; {GAP}");
    match indexes(figures) {
        Verdict::Pass(figure) => Verdict::Pass(with_gap(figure)),
        Verdict::Fail(figure) => Verdict::Fail(with_gap(figure)),
        other => other,
    }
}

fn indexes(figures: &Figures) -> Verdict {
    of_timers(figures, "index", 0b111, |[timer, standing, before, after, back_before, back_after]| {
        let is = [standing, before, after, back_before, back_after];
        let named = is.map(|count| if count == 9999 { "none".to_owned() } else { count.to_string() });
        let [standing, before, after, back_before, back_after] = named;
        let holds = is == [0, 0, 1, 0, -1];
        (
            holds,
            format!(
                "TIM{timer} {standing} at standstill, {before} before and {after} after an edge, back {back_before} and {back_after}"
            ),
        )
    })
}

/// Cycles of the core in a byte: 8 bits of 32 MHz.
const BYTE_CYCLES: f64 = 120.0;

fn spi3(figures: &Figures) -> Verdict {
    let Some([one, nine, phase, polarity]) = figures.only("spi3") else { return Verdict::missing("spi3") };
    if one == 0 || nine == 0 {
        return Verdict::Fail("RXP does not come".to_owned());
    }
    let byte = (nine - one) as f64 / 8.0;
    // The HSI is off by 1 %, and DWT is read between two looks at a flag.
    let is_timed = (byte / BYTE_CYCLES - 1.0).abs() <= 0.1 && (BYTE_CYCLES..4.0 * BYTE_CYCLES).contains(&(one as f64));
    let holds = is_timed && (phase, polarity) == (1, 0);
    Verdict::of(
        holds,
        format!("{byte:.0} cycles, of {BYTE_CYCLES}; the first comes after {one}; CPHA {phase}, CPOL {polarity}"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A locked-up core at laser 0 alone, or at both: the row passes for both only.
    #[test]
    fn a_laser_that_was_not_measured_leaves_the_row_unsettled() {
        let mut figures = Figures::default();
        for line in [[1, 1], [2, 0], [6, 32]] {
            figures.add("wire", line.to_vec());
        }
        figures.add("lock-up-0", vec![100, 1, 50, 120]);
        figures.add("lock-up-1", vec![100, 0]);
        let why = "laser 1: jumper 2 (D58–D23) is missing; measured: laser 0 dark 20 counts after it";
        assert_eq!(lock_up(&figures), Verdict::NotMeasured(why.to_owned()));
    }

    #[test]
    fn an_encoder_that_was_not_measured_leaves_the_row_unsettled() {
        let mut figures = Figures::default();
        figures.add("encoder", vec![3, 0b111, 40, -40]);
        figures.add("encoder", vec![4, 0b001, 0, 0]);
        let why = "TIM4: its end of jumper 11 (D64–D11, D28) is missing; measured: TIM3 40, then -40, of 40 and -40";
        assert_eq!(counts(&figures), Verdict::NotMeasured(why.to_owned()));
        // What is wrong counts all the same.
        let mut figures = Figures::default();
        figures.add("encoder", vec![3, 0b111, 20, -40]);
        figures.add("encoder", vec![4, 0b001, 0, 0]);
        assert!(matches!(counts(&figures), Verdict::Fail(_)));
    }
}
