//! The page: a table of rows, then what to change; and its file. Rows that another run measures are
//! settled in it later.
//!
//! In: figures, the page before. Out: Markdown. Owns its shape. Fails: a page that lacks a row.
mod again;
mod file;

use super::lines::Figures;
use super::rows::{Row, Verdict, elsewhere, rows};
use crate::Failure;
use crate::summary::counted as number_of;
use again::UNKNOWN;
pub use again::{check_subject, kept};
pub use file::write;
use std::fmt::Write as _;
use std::path::Path;

/// A line that says of what, by which program, and when.
pub fn dated(of: &str) -> String {
    format!("{of}{BY}{} on {}.", env!("CARGO_PKG_VERSION"), today())
}

/// What follows the board, image and chip in the line that says of what.
const BY: &str = ", by `beamtick bring-up` ";

fn today() -> time::Date {
    time::OffsetDateTime::now_utc().date()
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
        let unknown = || UNKNOWN.to_owned();
        let unique = figures.only::<3>("unique").map(|words| words.map(|word| format!("{word:08x}")).join("-"));
        let image = version(figures.only("version"), figures.only("build"));
        let board = figures.all("board").first().map(|bytes| bytes.iter().filter_map(letter).collect::<String>());
        let of = format!(
            "Board {}, bring-up image {}, chip {}",
            board.filter(|name| !name.is_empty()).unwrap_or_else(unknown),
            image.unwrap_or_else(unknown),
            unique.unwrap_or_else(unknown)
        );
        Report { judged, of }
    }

    fn count(&self, is: impl Fn(&Verdict) -> bool) -> usize {
        self.judged.iter().filter(|(_, verdict)| is(verdict)).count()
    }

    /// Rows that failed.
    fn failed(&self) -> usize {
        self.count(|verdict| matches!(verdict, Verdict::Fail(_)))
    }

    /// Whether the board has measured anything.
    pub fn has_figures(&self) -> bool {
        self.count(|verdict| !matches!(verdict, Verdict::NotMeasured(_))) > 0
    }

    /// One line.
    fn summary(&self) -> String {
        counted([
            self.count(|verdict| matches!(verdict, Verdict::Pass(_))),
            self.failed(),
            self.count(|verdict| matches!(verdict, Verdict::Figure(_))),
            self.count(|verdict| matches!(verdict, Verdict::NotMeasured(_))),
        ])
    }

    /// The page.
    pub fn text(&self) -> String {
        let mut text = format!("{TITLE}\n\n");
        let mut put = |line: String| {
            // Writing to a string never fails.
            let _ = writeln!(text, "{line}");
        };
        put(format!("{}\n", dated(&self.of)));
        put(format!("{}. A number in the second column is a row of docs/board-assumptions.md.\n", self.summary()));
        put(format!("{HEAD}\n| --- | --- | --- | --- |"));
        self.judged.iter().for_each(|(row, verdict)| put(cells(row, verdict)));
        if self.failed() > 0 {
            put(format!("\n{ADVICE}\n\n{NO_LASER}\n"));
            let failed = self.judged.iter().filter(|(_, verdict)| matches!(verdict, Verdict::Fail(_)));
            failed.for_each(|(row, _)| put(advice(row)));
        }
        text
    }
}

/// The first line of a page, and the head of its table.
const TITLE: &str = "# Bring-up";
const HEAD: &str = "| row | assumption | result | figure |";
/// The section of advice.
const ADVICE: &str = "## What to change";
/// Stands before the advice.
const NO_LASER: &str = "**Connect no laser to this board while a row fails.** Unplug CN1, plug it in again, and measure a second time. If it fails again, do \
    what the row says, or send this page to the project.";

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
    let mut text = if before.is_empty() { Report::of(&Figures::default()).text() } else { before.to_owned() };
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
        // A run that came to nothing takes back nothing that another one has settled.
        let was = line.strip_prefix(&head(row)).unwrap_or_default();
        let has_failed = matches!(verdict, Verdict::Fail(_));
        failed += usize::from(has_failed);
        let decides = has_failed || matches!(verdict, Verdict::Pass(_));
        if !decides && (was.starts_with("pass ") || was.starts_with("**FAIL** ")) {
            let cells = cells(row, &verdict);
            let is = cells.strip_prefix(&head(row)).unwrap_or_default().trim_end_matches(" |").replace(" | ", ": ");
            say!("{}: {is}; the page keeps what it says", row.what);
            continue;
        }
        text = text.replacen(&line, &cells(row, &on(verdict.clone(), figures)), 1).replacen(
            &format!("{}\n", advice(row)),
            "",
            1,
        );
        if has_failed {
            text = advised(&text, row);
        }
    }
    Ok((recounted(&text), failed))
}

/// Whether a page, if there is one, has all rows that other runs settle.
pub fn complete(page: &str) -> Result<(), Failure> {
    let has = |row: &&Row| page.lines().any(|line| line.starts_with(&head(row)));
    match elsewhere().iter().find(|row| !has(row)).filter(|_| !page.is_empty()) {
        None => Ok(()),
        Some(row) => {
            Err(Failure::Input(format!("--page has no row \"{}\": measure by the bring-up image anew", row.what)))
        }
    }
}

/// Whether a text has the shape of a page: its title at first, and after it, in this order, the
/// line of the board and the program, the counts, and the head of the table.
fn is_page(text: &str) -> bool {
    let mut lines = text.trim_start().lines();
    lines.next() == Some(TITLE)
        && lines.any(|line| line.starts_with("Board ") && line.contains(BY))
        && lines.any(is_count)
        && lines.any(|line| line == HEAD)
}

/// Whether a line has the counts of the results.
fn is_count(line: &str) -> bool {
    line.contains(" passed, ") && line.contains(" failed, ") && line.contains(". A number")
}

/// A version and what tells its builds apart: a checksum of the bring-up image, the hash of the
/// protocol of a board's own image.
fn version(parts: Option<[i64; 3]>, build: Option<[i64; 1]>) -> Option<String> {
    let ([major, minor, patch], [build]) = (parts?, build?);
    Some(format!("{major}.{minor}.{patch}-{build:08x}"))
}

/// The same of the board's own image that answers this client.
pub fn version_of(client: &client::Client) -> String {
    let mut figures = Figures::default();
    figures.add_image_of(client);
    image(&figures).unwrap_or_default()
}

/// The image of these figures, where it has said so.
fn image(figures: &Figures) -> Option<String> {
    match figures.only("image") {
        Some([major, minor, patch, schema]) => version(Some([major, minor, patch]), Some([schema])),
        None => version(figures.only("version"), figures.only("build")),
    }
}

/// With the day, and the image where it is known: the row outlasts other runs.
fn on(verdict: Verdict, figures: &Figures) -> Verdict {
    let image = image(figures).map(|image| format!("image {image}, "));
    let with = |figure: String| format!("{figure} ({}{})", image.unwrap_or_default(), today());
    match verdict {
        Verdict::Pass(figure) => Verdict::Pass(with(figure)),
        Verdict::Fail(figure) => Verdict::Fail(with(figure)),
        Verdict::Figure(figure) => Verdict::Figure(with(figure)),
        Verdict::NotMeasured(why) => Verdict::NotMeasured(why),
    }
}

/// Rows of a page that failed, but not those of its sections.
pub fn failed(page: &str) -> usize {
    results(page).filter(|result| *result == "**FAIL**").count()
}

/// The results of the first table's rows.
fn results(page: &str) -> impl Iterator<Item = &str> {
    let table = page.lines().skip_while(|line| !line.starts_with("| row |")).take_while(|line| line.starts_with('|'));
    table.filter_map(|line| line.split(" | ").nth(2))
}

/// With the advice of a row that failed.
fn advised(text: &str, row: &Row) -> String {
    let more = format!("{ADVICE}\n\n{NO_LASER}\n\n{}\n", advice(row));
    match text.split_once(&format!("{ADVICE}\n\n")) {
        Some((head, rest)) => {
            format!("{head}{more}{}", rest.strip_prefix(&format!("{NO_LASER}\n\n")).unwrap_or(rest))
        }
        // After the table.
        None => {
            let end = text.rfind("\n|").and_then(|last| text[last + 1..].find('\n').map(|line| last + 1 + line));
            let (head, rest) = text.split_at(text.find("\n\n## ").or(end).unwrap_or(text.len()));
            format!("{head}\n\n{more}{rest}")
        }
    }
}

/// The counts of the first table's results, in one line.
pub fn summary(page: &str) -> String {
    let count = |of: &str| results(page).filter(|result| *result == of).count();
    counted([count("pass"), count("**FAIL**"), count("figure"), count("not measured")])
}

/// Assumptions that say whether light ends, or begins where none was asked for: without a
/// measurement they count as failed (docs/bring-up.md).
const OF_LIGHT: [u8; 12] = [1, 2, 3, 4, 5, 7, 9, 10, 12, 32, 34, 35];

/// Why a board whose page this is gets no laser yet, though none of its rows failed.
pub fn not_for_lasers(page: &str) -> Option<String> {
    let open = |row: &&Row| {
        let begin = format!("{}not measured |", head(row));
        row.assumptions.iter().any(|of| OF_LIGHT.contains(of)) && page.lines().any(|line| line.starts_with(&begin))
    };
    let open: Vec<_> = rows().into_iter().filter(open).map(|row| row.what).collect();
    let these = open.join(", ");
    (!open.is_empty()).then(|| {
        format!("connect no laser yet: these rows were not measured: {these}. Put in their jumpers (docs/bring-up.md)")
    })
}

/// With the counts of the first table's results.
fn recounted(text: &str) -> String {
    let line = |line: &str| match line.split_once(". A number") {
        Some((_, rest)) if is_count(line) => format!("{}. A number{rest}\n", summary(text)),
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

/// One line.
fn counted([passed, failed, figures, not_measured]: [usize; 4]) -> String {
    let of = |count: usize, one, many| number_of(count as i64, one, many);
    let (passed, figures) = (of(passed, "row", "rows"), of(figures, "figure", "figures"));
    format!("{passed} passed, {failed} failed, {figures}, {not_measured} not measured")
}

/// Settles rows of the page by the figures of another run than that of the bring-up image.
pub fn settle(name: Option<&Path>, measure: impl FnOnce() -> Result<Figures, Failure>) -> Result<(), Failure> {
    let (mut count, mut vain) = (0, None);
    write(name, |before| {
        // Before anybody waits for a measurement that the page has no row for.
        complete(before)?;
        let figures = measure()?;
        let (text, failed) = settled(before, &figures)?;
        (count, vain) = (failed, in_vain(&figures));
        Ok((text, if vain.is_some() { NOTHING.to_owned() } else { rows_failed(failed) }))
    })?;
    vain.map_or_else(|| failure(count), |vain| Err(Failure::Job(vain)))
}

/// What is said of a run that settled no row.
const NOTHING: &str = "nothing was measured";

/// What to do after a run that settled no row, and why it did not; none where it settled one.
fn in_vain(figures: &Figures) -> Option<String> {
    let mut why = String::new();
    for row in elsewhere() {
        match (row.judge)(figures) {
            Verdict::NotMeasured(said) if said != unmeasured(row) => why += &format!(". {}: {said}", row.what),
            Verdict::NotMeasured(_) => {}
            _ => return None,
        }
    }
    Some(format!("{NOTHING}{why}. Give the command again, and do what it asks for (docs/bring-up.md)"))
}

/// What a row says before anything measures it.
fn unmeasured(row: &Row) -> String {
    match (row.judge)(&Figures::default()) {
        Verdict::NotMeasured(why) => why,
        other => format!("{other:?}"),
    }
}

/// How many rows failed.
pub fn rows_failed(count: usize) -> String {
    format!("{} failed", number_of(count as i64, "row", "rows"))
}

/// What rows that failed end with.
pub fn failure(failed: usize) -> Result<(), Failure> {
    match failed {
        0 => Ok(()),
        failed => Err(Failure::Job(format!("{}; the page says what to change", rows_failed(failed)))),
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

    pub fn figures(name: &str, numbers: &[i64]) -> Figures {
        let mut figures = Figures::default();
        figures.add(name, numbers.to_vec());
        figures
    }

    pub fn line<'a>(page: &'a str, what: &str) -> &'a str {
        page.lines().find(|line| line.starts_with(&format!("| {what} | "))).unwrap()
    }

    #[test]
    fn a_page_says_which_rows_a_laser_waits_for() {
        let page = Report::of(&figures("watchdog", &[24_000_000])).text();
        let text = not_for_lasers(&page).unwrap();
        for row in ["pins after a reset", "from the interlock to dark", "a locked-up core ends light"] {
            assert!(text.contains(row), "{row}: {text}");
        }
        assert!(!text.contains("the watchdog's time") && !text.contains(CLOCK), "{text}");
        let measured = page.replace("| not measured |", "| pass |");
        assert_eq!(not_for_lasers(&measured), None);
    }

    /// A row that is settled leaves all others as they are; one that is settled anew takes its
    /// advice away.
    #[test]
    fn a_row_is_settled_in_the_page_that_is_there() {
        const WATCHDOG: &str = "the watchdog's time";
        let page = Report::of(&figures("watchdog", &[24_000_000])).text();
        let before = line(&page, WATCHDOG).to_owned();
        let (bad, failed) = settled(&page, &figures("clock-lost", &[1, 1, 1, 0, 1, 0])).unwrap();
        assert_eq!((failed, line(&bad, WATCHDOG)), (1, before.as_str()));
        assert!(line(&bad, CLOCK).contains("| **FAIL** | MOE of TIM1 0, TIM15 1, TIM8 0 in"), "{bad}");
        assert!(bad.contains("\n1 row passed, 1 failed, 0 figures, ") && bad.contains(" | pass | 100.0 ms"), "{bad}");
        assert!(bad.contains(&format!(" |\n\n{ADVICE}\n\n{NO_LASER}\n\n- {CLOCK}: ")), "{bad}");
        // A section after the table stays the last one.
        let bad = bad + "\n## Ticks under load\n\n| a | 21 | pass | b |\n";
        let (good, failed) = settled(&bad, &figures("clock-lost", &[1, 1, 1, 0, 0, 0])).unwrap();
        assert!(failed == 0 && !good.contains(&format!("- {CLOCK}: ")), "{good}");
        assert!(good.contains("\n2 rows passed, 0 failed, 0 figures, "), "{good}");
        let (bad, _) = settled(&good, &figures("answers", &[0, 1, 0])).unwrap();
        let place = |text: &str| bad.find(text).unwrap();
        assert!(place(ADVICE) < place("- USB of the Nucleo answers: "), "{bad}");
        assert_eq!(bad.matches(NO_LASER).count(), 1, "{bad}");
        assert!(place("- USB of the Nucleo answers: ") < place("## Ticks under load"), "{bad}");
    }

    const BOARD: [(&str, &[i64]); 4] =
        [("board", &[110, 117, 99]), ("version", &[0, 1, 0]), ("build", &[0xab]), ("unique", &[1, 2, 3])];
    pub const HALT: &str = "the watchdog while a debugger halts the core";
    pub const CLOCK: &str = "the clock's guard breaks the timers";
    pub const SOAK: &str = "endpoints of USB that are set again";

    /// The page of a run of the bring-up image, with one of these lines another one.
    pub fn run_of(other: Option<(&str, &[i64])>) -> String {
        let mut all = Figures::default();
        for (name, numbers) in BOARD {
            let numbers = other.filter(|(of, _)| *of == name).map_or(numbers, |(_, numbers)| numbers);
            all.add(name, numbers.to_vec());
        }
        Report::of(&all).text()
    }

    /// A page with a row that the board's own image has settled, of this schema.
    pub fn with(page: &str, name: &str, numbers: &[i64], schema: u32) -> String {
        let mut figures = figures(name, numbers);
        figures.add("image", vec![0, 1, 0, schema.into()]);
        settled(page, &figures).unwrap().0
    }

    /// A page on which other runs have settled rows, and a section.
    pub fn page_of_others() -> String {
        let page = with(&run_of(None), "halt", &[3000, 1000, 0], protocol::SCHEMA);
        let mut clock = figures("clock-lost", &[1, 1, 1, 0, 1, 0]);
        clock.add("version", vec![0, 1, 0]);
        clock.add("build", vec![0xab]);
        let page = settled(&page, &clock).unwrap().0;
        let page = with(&page, "soak", &[3600, 999_999, 0, 1, 0], protocol::SCHEMA);
        let section = dated(&format!("Board nuc, image 0.1.0-{:08x}, over serial", protocol::SCHEMA));
        page.trim_end().to_owned() + "\n\n## Ticks under load\n\n" + &section + "\n\n| a | 21 | pass | b |\n"
    }

    /// What came to nothing takes back no row.
    #[test]
    fn a_row_outlasts_a_vain_try() {
        let page = page_of_others();
        // The core did not stand.
        let (next, failed) = settled(&page, &figures("halt", &[3000, 3000, 0])).unwrap();
        assert_eq!((next.as_str(), failed), (page.as_str(), 0));
        // A short soak proves nothing.
        let (next, _) = settled(&page, &figures("soak", &[30, 9000, 0, 1, 0])).unwrap();
        assert_eq!(next, page);
    }

    #[test]
    fn a_page_without_the_row_is_refused_and_no_page_becomes_one() {
        let page = Report::of(&Figures::default()).text().replace("| voltages of", "| levels of");
        let Err(Failure::Input(text)) = settled(&page, &figures("dac", &[1, 0, 0])) else { panic!() };
        assert!(text.contains("has no row \"voltages of an external DAC\""), "{text}");
        let (page, failed) = settled("", &figures("halt", &[3000, 1000, 0])).unwrap();
        assert!(
            failed == 0 && page.starts_with("# Bring-up\n") && page.contains("\n1 row passed, 0 failed, "),
            "{page}"
        );
        assert_eq!(settled(&page, &figures("halt", &[3000, -1, 0])).unwrap().1, 1);
    }
}
