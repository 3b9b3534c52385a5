//! The rows of the page: what is measured, which assumption it settles, its limits, and what to
//! change on a fail.
//!
//! In: figures. Out: verdicts. Owns the limits. Numbers of assumptions are rows of
//! docs/board-assumptions.md; sections are those of RM0433.
mod captures;
mod elsewhere;
mod peripherals;
mod registers;
mod shortest;

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

/// What fails, a sentence each, or what all have.
fn all_of(wrong: Vec<String>, good: &str) -> Verdict {
    if wrong.is_empty() { Verdict::Pass(good.to_owned()) } else { Verdict::Fail(wrong.join("; ")) }
}

/// The same of parts that are measured one by one. Where nothing is wrong, a part that was not
/// measured leaves the row unsettled: its name and its verdict say which.
fn all_parts(wrong: Vec<String>, good: &str, missing: Vec<(String, Verdict)>) -> Verdict {
    if !wrong.is_empty() || missing.is_empty() {
        return all_of(wrong, good);
    }
    let named = missing.into_iter().map(|(part, verdict)| match verdict {
        Verdict::NotMeasured(why) => format!("{part}: {why}"),
        other => format!("{part}: {other:?}"),
    });
    let measured = if good.is_empty() { String::new() } else { format!("; measured: {good}") };
    Verdict::NotMeasured(named.collect::<Vec<_>>().join("; ") + &measured)
}

/// All rows, in the order of the page.
pub fn rows() -> Vec<&'static Row> {
    let of_image = registers::ROWS.iter().chain(captures::ROWS).chain(shortest::ROWS).chain(peripherals::ROWS);
    of_image.chain(elsewhere::ROWS).collect()
}

/// Those of them that other runs measure than that of the bring-up image.
pub fn elsewhere() -> &'static [Row] {
    elsewhere::ROWS
}

/// What a page about a board calls an assumption: the first cell of its row.
#[cfg(test)]
fn listed(page: &str) -> Vec<u8> {
    let first = |line: &str| line.strip_prefix("| ")?.split('|').next()?.trim().parse().ok();
    page.lines().filter_map(first).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// Each row of docs/board-assumptions.md is settled by a row of the page, and no other one is:
    /// nothing is left to do without the program. One that wants a hand is asked for by it.
    #[test]
    fn no_assumption_is_left_out() {
        let page = include_str!("../../../../docs/board-assumptions.md");
        let mut should = listed(page);
        should.sort_unstable();
        assert_eq!(should, (1..=39).collect::<Vec<u8>>());
        let measured: HashSet<u8> = rows().into_iter().flat_map(|row| row.assumptions).copied().collect();
        let mut is: Vec<u8> = measured.into_iter().collect();
        is.sort_unstable();
        assert_eq!(is, should);
        // A row that the bring-up image does not measure names the option that does.
        for row in elsewhere() {
            let Verdict::NotMeasured(why) = (row.judge)(&Figures::default()) else { panic!("{}", row.what) };
            assert!(["--loads --soak", "--answers", "--hands"].iter().any(|option| why.contains(option)), "{why}");
        }
        assert!(!page.contains("by hand"), "every row is measured");
    }

    /// A file by its whole path, a section with its manual.
    #[test]
    fn a_remedy_names_files_that_exist_and_the_manual_of_a_section() {
        let root = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        for Row { what, remedy, .. } in rows() {
            let words = remedy.split(|c: char| !(c.is_ascii_alphanumeric() || "./_-".contains(c)));
            let mut manual = false;
            for word in words.map(|word| word.trim_matches('.')) {
                if [".rs", ".md", ".x"].iter().any(|ending| word.ends_with(ending)) {
                    assert!(root.join(word).is_file(), "{what}: {word}");
                }
                manual |= ["RM0433", "ES0392"].contains(&word);
                let parts: Vec<&str> = word.split('.').collect();
                let is_section = parts.len() > 1 && parts.iter().all(|part| part.parse::<u8>().is_ok());
                // A voltage or a current has its unit after it.
                assert!(!is_section || manual || remedy.contains(&format!("{word} V")), "{what}: {word}");
            }
        }
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
