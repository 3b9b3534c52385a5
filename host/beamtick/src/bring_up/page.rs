//! The page: a table of rows, then what to change, then what is left to do by hand; and its file.
//!
//! In: figures, the name of a file. Out: Markdown. Owns the file: it gets its name once it is
//! whole. Fails: a file that cannot be written, before anything is measured.
use super::lines::Figures;
use super::rows::{ByHand, Row, Verdict, by_hand, rows};
use crate::Failure;
use crate::output::{self, Output};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// What of a page was there before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Older {
    /// It is another run's: it gets its other name first, so that nobody takes it for this one's.
    Aside,
    /// What it says goes on: it stays until the new one is whole.
    GoesOn,
}

/// Writes the page that `make` returns to the file, or prints it without one, and says the second
/// text. `make` gets what the page says so far.
pub fn write(
    name: Option<&Path>,
    older: Older,
    make: impl FnOnce(&str) -> Result<(String, String), Failure>,
) -> Result<(), Failure> {
    let Some(name) = name else {
        let (text, _) = make("")?;
        say!("{}", text.trim_end());
        return Ok(());
    };
    let named = |failure| match failure {
        Failure::Input(text) => Failure::Input(format!("--page {text}")),
        other => other,
    };
    output::check(&[], &[("--page", name, false)])?;
    let is_file = name.is_file() && older == Older::GoesOn;
    let before = if is_file { std::fs::read_to_string(name) } else { Ok(String::new()) };
    let before = before.map_err(|e| Failure::Input(format!("--page {}: cannot be read: {e}", name.display())))?;
    let (mut output, mut file) = Output::stream(name).map_err(named)?;
    let made = (|| {
        if older == Older::Aside {
            output.set_older_aside().map_err(named)?;
        }
        let (text, said) = make(&before)?;
        let failed = |e| Failure::Job(format!("--page {}: cannot be written: {e}", name.display()));
        file.write_all(text.as_bytes()).map_err(failed)?;
        if older == Older::GoesOn {
            output.set_older_aside().map_err(named)?;
        }
        Ok(said)
    })();
    match made {
        Ok(said) => {
            output.whole()?;
            say!("{}: {said}", name.display());
            Ok(())
        }
        Err(failure) => {
            let kept = output.cut_off().to_string();
            Err(match failure {
                Failure::Job(text) => Failure::Job(text + &kept),
                Failure::Input(text) => Failure::Input(text + &kept),
                Failure::Interrupted(signal, text) => Failure::Interrupted(signal, text + &kept),
            })
        }
    }
}

/// A line that says of what, by which program, and when.
pub fn dated(of: &str) -> String {
    let date = time::OffsetDateTime::now_utc().date();
    format!("{of}, by `beamtick bring-up` {} on {date}.", env!("CARGO_PKG_VERSION"))
}

/// A judged run.
pub struct Report {
    judged: Vec<(&'static Row, Verdict)>,
    /// Which board, image and chip it was.
    of: String,
}

impl Report {
    /// Judges the figures.
    pub fn of(figures: &Figures) -> Report {
        let judged = rows().into_iter().map(|row| (row, (row.judge)(figures))).collect();
        let unknown = || "unknown".to_owned();
        let unique = figures.only::<3>("unique").map(|words| words.map(|word| format!("{word:08x}")).join("-"));
        let image = figures.only::<3>("version").map(|parts| parts.map(|part| part.to_string()).join("."));
        let board = figures.all("board").first().map(|bytes| bytes.iter().filter_map(letter).collect());
        let of = format!(
            "Board {}, bring-up image {}, chip {}",
            board.unwrap_or_else(unknown),
            image.unwrap_or_else(unknown),
            unique.unwrap_or_else(unknown)
        );
        Report { judged, of }
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
        put(format!("{}\n", dated(&self.of)));
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

/// A letter of a name, as a number.
fn letter(number: &i64) -> Option<char> {
    u8::try_from(*number).ok().map(char::from).filter(char::is_ascii_graphic)
}

fn numbers(assumptions: &[u8]) -> String {
    assumptions.iter().map(u8::to_string).collect::<Vec<_>>().join(", ")
}
