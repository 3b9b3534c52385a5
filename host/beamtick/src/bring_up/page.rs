//! The page: a table of rows, then what to change, then what is left to do by hand.
//!
//! In: figures. Out: Markdown. Owns nothing. Fails never.
use super::lines::Figures;
use super::rows::{ByHand, Row, Verdict, by_hand, rows};
use std::fmt::Write as _;

/// A judged run.
pub struct Report {
    judged: Vec<(&'static Row, Verdict)>,
    unique: String,
}

impl Report {
    /// Judges the figures.
    pub fn of(figures: &Figures) -> Report {
        let judged = rows().into_iter().map(|row| (row, (row.judge)(figures))).collect();
        let unique = match figures.only::<3>("unique") {
            Some(words) => words.map(|word| format!("{word:08x}")).join("-"),
            None => "unknown".to_owned(),
        };
        Report { judged, unique }
    }

    fn count(&self, is: impl Fn(&Verdict) -> bool) -> usize {
        self.judged.iter().filter(|(_, verdict)| is(verdict)).count()
    }

    /// Rows that failed.
    pub fn failed(&self) -> usize {
        self.count(|verdict| matches!(verdict, Verdict::Fail(_)))
    }

    /// One line.
    pub fn summary(&self) -> String {
        format!(
            "{} rows passed, {} failed, {} figures, {} not measured",
            self.count(|verdict| matches!(verdict, Verdict::Pass(_))),
            self.failed(),
            self.count(|verdict| matches!(verdict, Verdict::Figure(_))),
            self.count(|verdict| matches!(verdict, Verdict::NotMeasured(_)))
        )
    }

    /// The page.
    pub fn text(&self) -> String {
        let mut text = String::from("# Bring-up\n\n");
        let mut put = |line: String| {
            // Writing to a string never fails.
            let _ = writeln!(text, "{line}");
        };
        put(format!("Chip {}, by `beamtick bring-up` {}.", self.unique, env!("CARGO_PKG_VERSION")));
        put(format!("{}. A number in the second column is a row of docs/board-assumptions.md.\n", self.summary()));
        put("| row | assumption | result | figure |\n| --- | --- | --- | --- |".to_owned());
        for (row, verdict) in &self.judged {
            let (result, figure) = match verdict {
                Verdict::Pass(figure) => ("pass", figure),
                Verdict::Fail(figure) => ("**FAIL**", figure),
                Verdict::Figure(figure) => ("figure", figure),
                Verdict::NotMeasured(why) => ("not measured", why),
            };
            put(format!("| {} | {} | {result} | {figure} |", row.what, numbers(row.assumptions)));
        }
        if self.failed() > 0 {
            put("\n## What to change\n".to_owned());
            let failed = self.judged.iter().filter(|(_, verdict)| matches!(verdict, Verdict::Fail(_)));
            failed.for_each(|(row, _)| put(format!("- {}: {}", row.what, row.remedy)));
        }
        put("\n## By hand\n\nThese the board cannot measure by itself.\n".to_owned());
        put("| assumption | what | how |\n| --- | --- | --- |".to_owned());
        for ByHand { assumption, what, how } in by_hand() {
            put(format!("| {assumption} | {what} | {how} |"));
        }
        text
    }
}

fn numbers(assumptions: &[u8]) -> String {
    assumptions.iter().map(u8::to_string).collect::<Vec<_>>().join(", ")
}
