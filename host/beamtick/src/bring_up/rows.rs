//! The rows of the page: what is measured, which assumption it settles, its limits, and what to
//! change on a fail.
//!
//! In: figures. Out: verdicts. Owns the limits. Numbers of assumptions are rows of
//! docs/board-assumptions.md; sections are those of RM0433.
mod captures;
mod peripherals;
mod registers;

use super::lines::Figures;

/// What a row comes to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// As assumed, with the figure.
    Pass(String),
    /// Otherwise.
    Fail(String),
    /// There is no limit.
    Figure(String),
    /// The board has not measured it, and why.
    NotMeasured(String),
}

impl Verdict {
    fn of(holds: bool, figure: impl Into<String>) -> Verdict {
        if holds { Verdict::Pass(figure.into()) } else { Verdict::Fail(figure.into()) }
    }

    /// No line of this name, or not with as many numbers.
    fn missing(name: &str) -> Verdict {
        Verdict::NotMeasured(format!("the board sent no `{name}`"))
    }
}

/// A row.
#[derive(Debug)]
pub struct Row {
    /// What is measured; unique.
    pub what: &'static str,
    /// Rows of docs/board-assumptions.md that it settles.
    pub assumptions: &'static [u8],
    /// The verdict.
    pub judge: fn(&Figures) -> Verdict,
    /// What to change on a fail.
    pub remedy: &'static str,
}

/// What the board cannot measure.
#[derive(Debug)]
pub struct ByHand {
    /// Row of docs/board-assumptions.md.
    pub assumption: u8,
    /// What.
    pub what: &'static str,
    /// How it is measured.
    pub how: &'static str,
}

/// What fails, a sentence each, or what all have.
fn all_of(wrong: Vec<String>, good: &str) -> Verdict {
    if wrong.is_empty() { Verdict::Pass(good.to_owned()) } else { Verdict::Fail(wrong.join("; ")) }
}

/// All rows, in the order of the page.
pub fn rows() -> Vec<&'static Row> {
    registers::ROWS.iter().chain(captures::ROWS).chain(peripherals::ROWS).collect()
}

/// All that is left.
pub fn by_hand() -> &'static [ByHand] {
    BY_HAND
}

/// What a page about a board calls an assumption: the first cell of its row.
#[cfg(test)]
fn listed(page: &str) -> Vec<u8> {
    let first = |line: &str| line.strip_prefix("| ")?.split('|').next()?.trim().parse().ok();
    page.lines().filter_map(first).collect()
}

const BY_HAND: &[ByHand] = &[
    by(8, "the watchdog under a debugger", "halt for a second, go on: no reset. A program cannot halt its own core so"),
    by(
        16,
        "the link's stream beside others",
        "`bring-up --loads --soak 60` with the board's own image: a short run proves nothing",
    ),
    by(
        26,
        "the ST-LINK's clock without a host",
        "supply by VIN (JP2), unplug the host for a minute, plug it in: `beamtick info` shows a clock that ran on, and no \
         fault. A program cannot unplug it",
    ),
    by(
        27,
        "USB",
        "`bring-up --loads` over CN13 with the board's own image; its section names the link. The bring-up image has no USB",
    ),
    by(
        33,
        "the clock's guard breaks the timers",
        "an LED at energy −, light on, hold the ST-LINK in reset: no program can stop its clock",
    ),
    by(
        28,
        "the crystal of the module starts",
        "`beamtick info` over USB answers, with the module's own image. The bring-up image drives the Nucleo's pins alone",
    ),
    by(29, "USB of the module without VBUS", "the same"),
    by(
        38,
        "the external DAC",
        "with its image, GT_SetDac of 0, 5 and 10 V on both channels, a voltmeter at the terminals",
    ),
    by(39, "endpoints of USB that are set again", "`bring-up --loads --soak 60` over CN13 with the board's own image"),
];

const fn by(assumption: u8, what: &'static str, how: &'static str) -> ByHand {
    ByHand { assumption, what, how }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// Each row of docs/board-assumptions.md is measured, or listed as left to do by hand; not
    /// both, and nothing else is.
    #[test]
    fn no_assumption_is_left_out() {
        let page = include_str!("../../../../docs/board-assumptions.md");
        let mut should = listed(page);
        should.sort_unstable();
        assert!(should.len() >= 27, "{should:?}");
        let measured: HashSet<u8> = rows().into_iter().flat_map(|row| row.assumptions).copied().collect();
        let by_hand: Vec<u8> = by_hand().iter().map(|row| row.assumption).collect();
        assert_eq!(by_hand.iter().find(|number| measured.contains(number)), None, "both");
        let mut is: Vec<u8> = measured.into_iter().chain(by_hand).collect();
        is.sort_unstable();
        assert_eq!(is, should);
    }

    #[test]
    fn rows_have_names_of_their_own_and_say_what_is_missing() {
        let names: HashSet<&str> = rows().into_iter().map(|row| row.what).collect();
        assert_eq!(names.len(), rows().len());
        for row in rows() {
            let verdict = (row.judge)(&Figures::default());
            assert!(matches!(&verdict, Verdict::NotMeasured(why) if why.contains('`')), "{}: {verdict:?}", row.what);
        }
    }
}
