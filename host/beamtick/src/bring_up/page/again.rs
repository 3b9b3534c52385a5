//! A page that is measured again: what of the one before stays.
//!
//! In: the page before, that of a new run. Out: the new one, with the rows and sections that other
//! runs have settled. Owns nothing. Fails: a page of another board, or of nobody knows which.
use super::{ADVICE, BY, advised, elsewhere, head, is_page, recounted};
use crate::Failure;
use std::path::Path;

/// What is said of what the board has not said.
pub const UNKNOWN: &str = "unknown";
/// What follows a name that this run has not said.
const OF_BEFORE: &str = " (by the page before: this run has not said it)";

/// The board, the bring-up image and the chip of which a page is, as far as it says that.
struct Subject<'a> {
    board: Option<&'a str>,
    image: Option<&'a str>,
    chip: Option<&'a str>,
    /// Those that the page took from the one before.
    taken: [bool; 3],
}

impl<'a> Subject<'a> {
    fn parts(&self) -> [Option<&'a str>; 3] {
        [self.board, self.image, self.chip]
    }

    /// Whether nothing is unknown.
    fn is_whole(&self) -> bool {
        self.parts().iter().all(Option::is_some)
    }

    /// With what the page before says, where this one says nothing.
    fn or(&self, before: &Subject<'a>) -> Subject<'a> {
        let taken = self.parts().map(|part| part.is_none());
        let [board, image, chip] = [0, 1, 2].map(|n: usize| self.parts()[n].or(before.parts()[n]));
        Subject { board, image, chip, taken }
    }

    /// As a page says it.
    fn line(&self) -> String {
        let [board, image, chip] = [0, 1, 2].map(|n: usize| match self.parts()[n] {
            Some(part) if self.taken[n] => format!("{part}{OF_BEFORE}"),
            part => part.unwrap_or(UNKNOWN).to_owned(),
        });
        format!("Board {board}, bring-up image {image}, chip {chip}{BY}")
    }
}

/// Of which board a page is.
fn subject(page: &str) -> Option<Subject<'_>> {
    let line = page.lines().find_map(|line| line.split_once(BY)?.0.strip_prefix("Board "))?;
    let (board, rest) = line.split_once(", bring-up image ")?;
    let (image, chip) = rest.split_once(", chip ")?;
    let parts = [board, image, chip];
    let taken = parts.map(|part| part.ends_with(OF_BEFORE));
    let [board, image, chip] = parts.map(|part| Some(part.trim_end_matches(OF_BEFORE)).filter(|part| *part != UNKNOWN));
    Some(Subject { board, image, chip, taken })
}

/// Fails where a page does not say of which chip it is: a run would take it for its own.
pub fn check_subject(name: Option<&Path>, before: &str) -> Result<(), Failure> {
    let is_whole = subject(before).is_some_and(|subject| subject.is_whole());
    let Some(name) = name.filter(|_| is_page(before) && !is_whole) else { return Ok(()) };
    Err(Failure::Input(format!(
        "--page {} does not say of which chip it is: it began without the bring-up image. Rename it, or name another file; \
         then repeat what it has settled",
        name.display()
    )))
}

/// A page of a new run, with what other runs have settled on the one before: their rows and
/// sections stay, with their days, while their image is the same. What the new run does not say of
/// its board contradicts nothing: it is taken from the page before, and the page says so. Fails
/// where the page before is another chip's, which is not replaced.
pub fn kept(name: Option<&Path>, before: &str, page: String) -> Result<String, Failure> {
    let was = subject(before).filter(Subject::is_whole);
    let (Some(was), Some(is)) = (was, subject(&page)) else { return Ok(page) };
    let differ = |one: Option<&str>, other: Option<&str>| one.zip(other).is_some_and(|(one, other)| one != other);
    if differ(was.board, is.board) || differ(was.chip, is.chip) {
        let name = name.unwrap_or(Path::new("bring-up.md"));
        let [of, chip, this, this_chip] = [was.board, was.chip, is.board, is.chip].map(|part| part.unwrap_or(UNKNOWN));
        return Err(Failure::Input(format!(
            "--page {} is of another board: {of}, chip {chip}. This one is {this}, chip {this_chip}. Rename that page, or name \
             another file: --page {}",
            name.display(),
            name.with_file_name(format!("bring-up-{this_chip}.md")).display()
        )));
    }
    let page = page.replacen(&is.line(), &is.or(&was).line(), 1);
    // The board's own image of this release and this program's protocol, and the bring-up image.
    let bring_up = is.image.or(was.image).unwrap_or_default();
    let release = bring_up.split('-').next().unwrap_or_default();
    let same = [format!("image {release}-{:08x}, ", protocol::SCHEMA), format!("image {bring_up}, ")];
    let is_of_another_image = |text: &str| text.contains("image ") && !same.iter().any(|image| text.contains(image));
    let mut text = page.clone();
    for row in elsewhere() {
        let of = |page: &str| page.lines().find(|line| line.starts_with(&head(row))).map(str::to_owned);
        let Some(new) = of(&text) else { continue };
        let Some(old) = of(before).filter(|line| line.ends_with(" |")) else {
            say!("{}: the page before has no whole row of it, so nothing is taken over", row.what);
            continue;
        };
        let rest = old.strip_prefix(&head(row)).unwrap_or_default();
        if rest.starts_with("not measured ") {
            continue;
        }
        if is_of_another_image(rest) {
            say!("{}: settled by another image, so it is not taken over: {}", row.what, rest.trim_end_matches(" |"));
            continue;
        }
        text = text.replacen(&new, &old, 1);
        if rest.starts_with("**FAIL** ") {
            text = advised(&text, row);
        }
    }
    for section in before.split("\n## ").skip(1).filter(|section| !format!("## {section}").starts_with(ADVICE)) {
        let dated = section.lines().find(|line| line.contains(BY)).unwrap_or_default();
        if is_of_another_image(dated) {
            let title = section.lines().next().unwrap_or_default();
            say!("{title}: measured with another image, so it is not taken over; measure it again");
            continue;
        }
        text = format!("{}\n\n## {}\n", text.trim_end(), section.trim_end());
    }
    Ok(recounted(&text))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{CLOCK, HALT, SOAK, line, page_of_others, run_of, with};
    use super::super::{failed, summary, today};
    use super::*;

    fn again(before: &str, page: String) -> String {
        kept(None, before, page).unwrap()
    }

    /// A new run takes nothing from what others have settled, unless their image is another one.
    #[test]
    fn what_other_runs_have_settled_outlasts_a_new_run_of_the_same_board() {
        let page = page_of_others();
        assert_eq!(summary(&page).split(", 0 figures").next(), Some("2 rows passed, 1 failed"), "{page}");
        let next = again(&page, run_of(None));
        assert_eq!(next, page);
        let own = format!("(image 0.1.0-{:08x}, {}) |", protocol::SCHEMA, today());
        assert!(line(&next, HALT).ends_with(&format!("it stood for 2.0 s and went on {own}")));
        assert!(line(&next, SOAK).ends_with(&format!(" 0 frames lost or damaged {own}")));
        assert!(line(&next, CLOCK).ends_with(&format!("(image 0.1.0-000000ab, {}) |", today())), "{next}");
        assert_eq!((failed(&next), next.matches(&format!("- {CLOCK}: ")).count()), (1, 1));
        // A day goes on as it is.
        let old = page.replace(&today().to_string(), "2001-02-03");
        assert!(line(&again(&old, run_of(None)), HALT).ends_with(", 2001-02-03) |"));
        // Another build of the bring-up image takes back what that has settled, and no more.
        let next = again(&page, run_of(Some(("build", &[0xac]))));
        assert!(line(&next, CLOCK).contains(" | not measured | ") && !next.contains(&format!("- {CLOCK}: ")), "{next}");
        assert!(line(&next, HALT).contains(" | pass | ") && next.contains("## Ticks under load"), "{next}");
        // Another protocol of the board's own image takes back its rows and its section.
        let old = page.replace(&format!("-{:08x}, ", protocol::SCHEMA), "-00000001, ");
        let next = again(&old, run_of(None));
        assert!(line(&next, HALT).contains(" | not measured | ") && !next.contains("## Ticks under load"), "{next}");
        assert!(line(&next, CLOCK).contains(" | **FAIL** | "), "{next}");
        // So does another release.
        let next = again(&page, run_of(Some(("version", &[0, 1, 1]))));
        assert_eq!(next, run_of(Some(("version", &[0, 1, 1]))));
    }

    /// A page of another board is not replaced, nor one that does not say of which it is.
    #[test]
    fn a_page_of_another_board_stays() {
        let page = page_of_others();
        for other in [("board", &[110, 118][..]), ("unique", &[1, 2, 4])] {
            let name = Path::new("out/page.md");
            let Err(Failure::Input(text)) = kept(Some(name), &page, run_of(Some(other))) else { panic!("{other:?}") };
            assert!(text.starts_with("--page out/page.md is of another board: nuc, chip 00000001-"), "{text}");
            let of = if other.0 == "unique" { 4 } else { 3 };
            let advice = format!("--page out/bring-up-00000001-00000002-{of:08x}.md");
            assert!(text.ends_with(&advice), "{text}");
        }
        let nobodys = with("", "halt", &[3000, 1000, 0], protocol::SCHEMA);
        let name = Some(Path::new("page.md"));
        let Err(Failure::Input(text)) = check_subject(name, &nobodys) else { panic!() };
        assert!(text.starts_with("--page page.md does not say of which chip it is"), "{text}");
        assert!(check_subject(name, &page).is_ok() && check_subject(name, "").is_ok());
    }

    /// A run that does not name its board, its chip or its image contradicts nothing. Rows stay.
    /// The page says by what, and goes on being that chip's.
    #[test]
    fn a_run_that_does_not_name_its_chip_keeps_what_others_have_settled() {
        let page = page_of_others();
        for (name, known) in
            [("board", "Board nuc"), ("build", "image 0.1.0-000000ab"), ("unique", "chip 00000001-00000002-00000003")]
        {
            let next = again(&page, run_of(Some((name, &[]))));
            assert!(next.contains(&format!("{known}{OF_BEFORE}, ")), "{next}");
            assert_eq!(next.replace(OF_BEFORE, ""), page, "{name}");
            assert!(check_subject(Some(Path::new("page.md")), &next).is_ok());
            // Such a run again, and one that says all.
            assert_eq!(again(&next, run_of(Some((name, &[])))), next);
            assert_eq!(again(&next, run_of(None)), page);
            let Err(Failure::Input(text)) = kept(None, &next, run_of(Some(("unique", &[1, 2, 4])))) else { panic!() };
            assert!(text.contains(" is of another board: nuc, chip 00000001-"), "{text}");
        }
        // Another board whose chip is not known.
        let other = run_of(Some(("unique", &[]))).replace("Board nuc", "Board other");
        let Err(Failure::Input(text)) = kept(None, &page, other) else { panic!() };
        assert!(text.contains("This one is other, chip unknown") && text.ends_with("--page bring-up-unknown.md"));
    }
}
