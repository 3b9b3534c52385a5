//! The page: a table of rows, then what to change; and its file. Rows that another run measures are
//! settled in it later.
//!
//! In: figures, the name of a file. Out: Markdown. Owns the file: it gets its name once it is
//! whole. Fails: a file that cannot be written, before anything is measured.
use super::lines::Figures;
use super::rows::{Row, Verdict, elsewhere, rows};
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
        counted([
            self.count(|verdict| matches!(verdict, Verdict::Pass(_))),
            self.failed(),
            self.count(|verdict| matches!(verdict, Verdict::Figure(_))),
            self.count(|verdict| matches!(verdict, Verdict::NotMeasured(_))),
        ])
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
        self.judged.iter().for_each(|(row, verdict)| put(cells(row, verdict)));
        if self.failed() > 0 {
            put(format!("\n{ADVICE}\n"));
            let failed = self.judged.iter().filter(|(_, verdict)| matches!(verdict, Verdict::Fail(_)));
            failed.for_each(|(row, _)| put(advice(row)));
        }
        text
    }
}

/// The section of advice.
const ADVICE: &str = "## What to change";

/// A row of the table.
fn cells(row: &Row, verdict: &Verdict) -> String {
    let (result, figure) = match verdict {
        Verdict::Pass(figure) => ("pass", figure),
        Verdict::Fail(figure) => ("**FAIL**", figure),
        Verdict::Figure(figure) => ("figure", figure),
        Verdict::NotMeasured(why) => ("not measured", why),
    };
    format!("{}{result} | {figure} |", head(row))
}

/// What the line of a row begins with.
fn head(row: &Row) -> String {
    format!("| {} | {} | ", row.what, numbers(row.assumptions))
}

fn advice(row: &Row) -> String {
    format!("- {}: {}", row.what, row.remedy)
}

/// The page with the rows that these figures settle, and how many of them failed. Where there was
/// no page, it has all other rows too, as not measured.
pub fn settled(before: &str, figures: &Figures) -> Result<(String, usize), Failure> {
    let mut text = if before.contains("\n| row |") && before.contains(" rows passed, ") {
        before.to_owned()
    } else {
        format!("{}\n{before}", Report::of(&Figures::default()).text()).trim_end().to_owned() + "\n"
    };
    let mut failed = 0;
    for row in elsewhere() {
        let (verdict, default) = ((row.judge)(figures), (row.judge)(&Figures::default()));
        if verdict == default {
            continue;
        }
        let Some(line) = text.lines().find(|line| line.starts_with(&head(row))).map(str::to_owned) else {
            return Err(Failure::Input(format!(
                "--page has no row \"{}\": measure by the bring-up image anew",
                row.what
            )));
        };
        text = text.replacen(&line, &cells(row, &verdict), 1).replacen(&format!("{}\n", advice(row)), "", 1);
        if matches!(verdict, Verdict::Fail(_)) {
            failed += 1;
            text = advised(&text, row);
        }
    }
    Ok((recounted(&text), failed))
}

/// With the advice of a row that failed.
fn advised(text: &str, row: &Row) -> String {
    let more = format!("{}\n", advice(row));
    match text.split_once(&format!("{ADVICE}\n\n")) {
        Some((head, rest)) => format!("{head}{ADVICE}\n\n{more}{rest}"),
        // After the table.
        None => {
            let end = text.rfind("\n|").and_then(|last| text[last + 1..].find('\n').map(|line| last + 1 + line));
            let (head, rest) = text.split_at(text.find("\n\n## ").or(end).unwrap_or(text.len()));
            format!("{head}\n\n{ADVICE}\n\n{more}{rest}")
        }
    }
}

/// With the counts of the first table's results.
fn recounted(text: &str) -> String {
    let table = text.lines().skip_while(|line| !line.starts_with("| row |")).take_while(|line| line.starts_with('|'));
    let results: Vec<&str> = table.filter_map(|line| line.split(" | ").nth(2)).collect();
    let count = |of: &str| results.iter().filter(|result| **result == of).count();
    let counts = [count("pass"), count("**FAIL**"), count("figure"), count("not measured")];
    let line = |line: &str| match line.split_once(". A number") {
        Some((head, rest)) if head.contains(" rows passed, ") => format!("{}. A number{rest}\n", counted(counts)),
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

/// One line.
fn counted([passed, failed, figures, not_measured]: [usize; 4]) -> String {
    format!("{passed} rows passed, {failed} failed, {figures} figures, {not_measured} not measured")
}

/// Settles rows of the page by the figures of another run than that of the bring-up image.
pub fn settle(name: Option<&Path>, measure: impl FnOnce() -> Result<Figures, Failure>) -> Result<(), Failure> {
    let mut count = 0;
    write(name, Older::GoesOn, |before| {
        let (text, failed) = settled(before, &measure()?)?;
        count = failed;
        Ok((text, format!("{failed} of these rows failed")))
    })?;
    failure(count)
}

/// What rows that failed end with.
pub fn failure(failed: usize) -> Result<(), Failure> {
    match failed {
        0 => Ok(()),
        failed => Err(Failure::Job(format!("{failed} rows failed; the page says what to change"))),
    }
}

/// A letter of a name, as a number.
fn letter(number: &i64) -> Option<char> {
    u8::try_from(*number).ok().map(char::from).filter(char::is_ascii_graphic)
}

fn numbers(assumptions: &[u8]) -> String {
    assumptions.iter().map(u8::to_string).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(name: &str, numbers: &[i64]) -> Figures {
        let mut figures = Figures::default();
        figures.add(name, numbers.to_vec());
        figures
    }

    fn line<'a>(page: &'a str, what: &str) -> &'a str {
        page.lines().find(|line| line.starts_with(&format!("| {what} | "))).unwrap()
    }

    /// A row that is settled leaves all others as they are; one that is settled anew takes its
    /// advice away.
    #[test]
    fn a_row_is_settled_in_the_page_that_is_there() {
        const CLOCK: &str = "the clock's guard breaks the timers";
        const WATCHDOG: &str = "the watchdog's time";
        let page = Report::of(&figures("watchdog", &[24_000_000])).text();
        let before = line(&page, WATCHDOG).to_owned();
        let (bad, failed) = settled(&page, &figures("clock-lost", &[1, 1, 1, 0, 1, 0])).unwrap();
        assert_eq!((failed, line(&bad, WATCHDOG)), (1, before.as_str()));
        assert!(line(&bad, CLOCK).contains("| **FAIL** | MOE of TIM1 0, TIM15 1, TIM8 0 in"), "{bad}");
        assert!(bad.contains("\n1 rows passed, 1 failed, 0 figures, ") && bad.contains(" | pass | 100.0 ms"), "{bad}");
        assert!(bad.contains(&format!(" |\n\n{ADVICE}\n\n- {CLOCK}: ")), "{bad}");
        // A section after the table stays the last one.
        let bad = bad + "\n## Ticks under load\n\n| a | 21 | pass | b |\n";
        let (good, failed) = settled(&bad, &figures("clock-lost", &[1, 1, 1, 0, 0, 0])).unwrap();
        assert!(failed == 0 && !good.contains(&format!("- {CLOCK}: ")), "{good}");
        assert!(good.contains("\n2 rows passed, 0 failed, 0 figures, "), "{good}");
        let (bad, _) = settled(&good, &figures("answers", &[0, 1, 0])).unwrap();
        let place = |text: &str| bad.find(text).unwrap();
        assert!(place(ADVICE) < place("- USB of the Nucleo answers: "), "{bad}");
        assert!(place("- USB of the Nucleo answers: ") < place("## Ticks under load"), "{bad}");
    }

    #[test]
    fn a_page_without_the_row_is_refused_and_no_page_becomes_one() {
        let page = Report::of(&Figures::default()).text().replace("| voltages of", "| levels of");
        let Err(Failure::Input(text)) = settled(&page, &figures("dac", &[1, 0, 0])) else { panic!() };
        assert!(text.contains("has no row \"voltages of an external DAC\""), "{text}");
        let (page, failed) = settled("", &figures("dac", &[1, 5000, 4900])).unwrap();
        assert!(
            failed == 0 && page.starts_with("# Bring-up\n") && page.contains("\n1 rows passed, 0 failed, "),
            "{page}"
        );
        assert_eq!(settled(&page, &figures("dac", &[1, 5000, 4899])).unwrap().1, 1);
    }
}
