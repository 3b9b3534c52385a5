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
    if let Ok(text) = std::fs::read(name)
        && !text.is_empty()
        && !String::from_utf8_lossy(&text).contains(BY)
    {
        let name = name.display();
        return Err(Failure::Input(format!("--page {name}: that file is no page of bring-up; choose another name")));
    }
    let before = match older {
        Older::GoesOn if name.is_file() => std::fs::read_to_string(name)
            .map_err(|e| Failure::Input(format!("--page {}: cannot be read: {e}", name.display())))?,
        Older::GoesOn => String::new(),
        Older::Aside => last(name),
    };
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

/// What a page said last: where a run was cut short, it has its other name. Empty if nothing that
/// can be read is there.
fn last(name: &Path) -> String {
    [name.to_owned(), output::old(name)]
        .into_iter()
        .filter(|name| name.is_file())
        .find_map(|name| std::fs::read_to_string(name).ok())
        .unwrap_or_default()
}

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
    fn failed(&self) -> usize {
        self.count(|verdict| matches!(verdict, Verdict::Fail(_)))
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
    let mut text = if is_page(before) {
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
        // A run that came to nothing takes back nothing that another one has settled.
        let was = line.strip_prefix(&head(row)).unwrap_or_default();
        let decides = matches!(verdict, Verdict::Pass(_) | Verdict::Fail(_));
        if !decides && (was.starts_with("pass ") || was.starts_with("**FAIL** ")) {
            say!("{}: {}; the page keeps what it says", row.what, cells(row, &verdict).trim_end_matches(" |"));
            continue;
        }
        text = text.replacen(&line, &cells(row, &on(verdict.clone(), figures)), 1).replacen(
            &format!("{}\n", advice(row)),
            "",
            1,
        );
        if matches!(verdict, Verdict::Fail(_)) {
            failed += 1;
            text = advised(&text, row);
        }
    }
    Ok((recounted(&text), failed))
}

/// Whether a page, if it is one, has all rows that other runs settle.
pub fn complete(page: &str) -> Result<(), Failure> {
    let has = |row: &&Row| page.lines().any(|line| line.starts_with(&head(row)));
    match elsewhere().iter().find(|row| !has(row)).filter(|_| is_page(page)) {
        None => Ok(()),
        Some(row) => {
            Err(Failure::Input(format!("--page has no row \"{}\": measure by the bring-up image anew", row.what)))
        }
    }
}

fn is_page(text: &str) -> bool {
    text.contains("\n| row |") && text.contains(" rows passed, ")
}

/// With the day, and the version of the image where it is known: the row outlasts other runs.
fn on(verdict: Verdict, figures: &Figures) -> Verdict {
    let image = figures.only::<3>("image").map(|[major, minor, patch]| format!("image {major}.{minor}.{patch}, "));
    let with = |figure: String| format!("{figure} ({}{})", image.unwrap_or_default(), today());
    match verdict {
        Verdict::Pass(figure) => Verdict::Pass(with(figure)),
        Verdict::Fail(figure) => Verdict::Fail(with(figure)),
        Verdict::Figure(figure) => Verdict::Figure(with(figure)),
        Verdict::NotMeasured(why) => Verdict::NotMeasured(why),
    }
}

/// The board, its image and the chip of which a page is, where the board has said all three.
fn subject(page: &str) -> Option<(&str, &str)> {
    let line = page.lines().find_map(|line| line.split_once(BY)?.0.strip_prefix("Board "))?;
    let (_, rest) = line.split_once(", bring-up image ")?;
    let (image, _) = rest.split_once(", ")?;
    (!line.contains("unknown")).then_some((line, image))
}

/// A page of a new run, with what other runs have settled on the one before: their rows and
/// sections stay, with their days, while board, chip and image are the same.
pub fn kept(before: &str, page: String) -> String {
    let (Some(was), Some(is)) = (subject(before), subject(&page)) else { return page };
    if was != is {
        return page;
    }
    let mut text = page.clone();
    for row in elsewhere() {
        let of = |page: &str| page.lines().find(|line| line.starts_with(&head(row))).map(str::to_owned);
        let (Some(old), Some(new)) = (of(before), of(&text)) else { continue };
        let is_of_another_image = old.contains("(image ") && !old.contains(&format!("(image {}, ", is.1));
        let rest = old.strip_prefix(&head(row)).unwrap_or_default();
        if is_of_another_image || rest.starts_with("not measured ") {
            continue;
        }
        text = text.replacen(&new, &old, 1);
        if rest.starts_with("**FAIL** ") {
            text = advised(&text, row);
        }
    }
    for section in before.split("\n## ").skip(1).filter(|section| !format!("## {section}").starts_with(ADVICE)) {
        text = format!("{}\n\n## {}\n", text.trim_end(), section.trim_end());
    }
    recounted(&text)
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

/// The counts of the first table's results, in one line.
pub fn summary(page: &str) -> String {
    let count = |of: &str| results(page).filter(|result| *result == of).count();
    counted([count("pass"), count("**FAIL**"), count("figure"), count("not measured")])
}

/// With the counts of the first table's results.
fn recounted(text: &str) -> String {
    let line = |line: &str| match line.split_once(". A number") {
        Some((head, rest)) if head.contains(" rows passed, ") => format!("{}. A number{rest}\n", summary(text)),
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
        // Before anybody waits for a measurement that the page has no row for.
        complete(before)?;
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

    const BOARD: [(&str, &[i64]); 3] = [("board", &[110, 117, 99]), ("version", &[0, 1, 0]), ("unique", &[1, 2, 3])];

    /// The page of a run of the bring-up image, with one of these lines another one.
    fn run_of(other: Option<(&str, &[i64])>) -> String {
        let mut all = Figures::default();
        for (name, numbers) in BOARD {
            let numbers = other.filter(|(of, _)| *of == name).map_or(numbers, |(_, numbers)| numbers);
            all.add(name, numbers.to_vec());
        }
        Report::of(&all).text()
    }

    /// A new run takes nothing from what others have settled, unless board, chip or image is
    /// another one.
    #[test]
    fn what_other_runs_have_settled_outlasts_a_new_run_of_the_same_board() {
        const HALT: &str = "the watchdog while a debugger halts the core";
        const CLOCK: &str = "the clock's guard breaks the timers";
        const SOAK: &str = "endpoints of USB that are set again";
        let with = |page: &str, name: &str, numbers: &[i64], image: [i64; 3]| {
            let mut figures = figures(name, numbers);
            figures.add("image", image.to_vec());
            settled(page, &figures).unwrap().0
        };
        let page = with(&run_of(None), "halt", &[3000, 1000, 0], [0, 1, 0]);
        let page = with(&page, "clock-lost", &[1, 1, 1, 0, 1, 0], [0, 1, 0]);
        let page = settled(&page, &figures("soak", &[3600, 9, 0, 1])).unwrap().0;
        let page = page.trim_end().to_owned() + "\n\n## Ticks under load\n\n| a | 21 | pass | b |\n";
        assert_eq!(summary(&page).split(", 0 figures").next(), Some("2 rows passed, 1 failed"), "{page}");
        let again = kept(&page, run_of(None));
        assert_eq!(again, page);
        assert!(line(&again, HALT).ends_with(&format!("it stood for 2.0 s and went on (image 0.1.0, {}) |", today())));
        assert!(line(&again, SOAK).ends_with(&format!(" 0 frames lost or damaged ({}) |", today())));
        assert_eq!((failed(&again), again.matches(&format!("- {CLOCK}: ")).count()), (1, 1));
        // A day goes on as it is.
        let old = page.replace(&today().to_string(), "2001-02-03");
        assert!(line(&kept(&old, run_of(None)), HALT).ends_with("(image 0.1.0, 2001-02-03) |"));

        for other in [("board", &[110, 118][..]), ("version", &[0, 1, 1]), ("unique", &[1, 2, 4])] {
            let fresh = run_of(Some(other));
            assert_eq!(kept(&page, fresh.clone()), fresh);
        }
        // A page that does not say of which board it is settles nothing of another one.
        let nobodys = with("", "halt", &[3000, 1000, 0], [0, 1, 0]);
        assert_eq!(kept(&nobodys, run_of(None)), run_of(None));
        // The board's own image was another version than that of bring-up: its rows go, others
        // stay.
        let page = with(&page, "halt", &[3000, 1000, 0], [0, 0, 9]);
        let again = kept(&page, run_of(None));
        assert!(line(&again, HALT).contains(" | not measured | ") && line(&again, SOAK).contains(" | pass | "));
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
