//! The file of a page.
//!
//! In: its name, what to write. Out: what it says so far. Owns the file: it gets its name once it
//! is whole, and until then nothing of it is on the disk. A link stays: what it leads to is
//! replaced. Fails, before anything is measured: a name of no plain file, a file that is no page,
//! one that cannot be written.
use super::is_page;
use crate::Failure;
use crate::output::Output;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Links that lead to links: as many as Linux follows.
const LINKS_MAX: usize = 40;

/// Writes the page that `make` returns to the file, or prints it without one, and says the second
/// text. `make` gets what the page says so far. The file stays as it is until the new one is whole.
pub fn write(name: Option<&Path>, make: impl FnOnce(&str) -> Result<(String, String), Failure>) -> Result<(), Failure> {
    let Some(name) = name else {
        let (text, _) = make("")?;
        say!("{}", text.trim_end());
        return Ok(());
    };
    let shown = name.display();
    let named = |failure| match failure {
        Failure::Input(text) => Failure::Input(format!("--page {text}")),
        Failure::Job(text) => Failure::Job(format!("--page {text}")),
        other => other,
    };
    let file = led_to(name)?;
    let before = before(name, &file)?;
    // It can be written, and nothing is left of the try.
    Output::stream(&file).map_err(named)?.0.cut_off();
    let made = make(&before).and_then(|(text, said)| {
        let (output, mut stream) = Output::stream(&file).map_err(named)?;
        if let Err(e) = stream.write_all(text.as_bytes()) {
            let failed = Failure::Job(format!("--page {shown}: cannot be written: {e}"));
            return Err(failed.with(&output.cut_off().to_string()));
        }
        output.whole().map_err(named)?;
        Ok(said)
    });
    match made {
        Ok(said) => {
            say!("{shown}: {said}");
            Ok(())
        }
        Err(failure) if before.is_empty() => Err(failure),
        Err(failure) => Err(failure.with(&format!("\n{shown} is as it was."))),
    }
}

/// The file that a name means, whether it is there or not.
fn led_to(name: &Path) -> Result<PathBuf, Failure> {
    let shown = name.display();
    let refused = |why: &str| Err(Failure::Input(format!("--page {shown}: {why}")));
    if name == Path::new("-") {
        return refused("it names a file; without --page the page goes to the standard output");
    }
    match std::fs::metadata(name) {
        Ok(found) if !found.is_file() => {
            return refused("this is a folder, a pipe or a device, and a page is a plain file; choose another name");
        }
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return refused(&format!("cannot be read: {e}")),
        _ => {}
    }
    let mut file = name.to_owned();
    for _ in 0..LINKS_MAX {
        let Ok(to) = std::fs::read_link(&file) else { return Ok(file) };
        file = file.parent().unwrap_or(Path::new("")).join(to);
    }
    refused("this link leads to itself")
}

/// What a page says, or nothing where none is. Fails where the file is none of ours.
fn before(name: &Path, file: &Path) -> Result<String, Failure> {
    if !file.is_file() {
        return Ok(String::new());
    }
    let shown = name.display();
    let bytes = std::fs::read(file).map_err(|e| Failure::Input(format!("--page {shown}: cannot be read: {e}")))?;
    let text = as_written(&String::from_utf8_lossy(&bytes));
    if text.trim().is_empty() {
        return Ok(String::new());
    }
    if !is_page(&text) {
        return Err(Failure::Input(format!("--page {shown}: that file is no page of bring-up; choose another name")));
    }
    Ok(text)
}

/// As this program writes it: an editor may have changed the ends of lines, or padded cells.
fn as_written(text: &str) -> String {
    let cells = |line: &str| match line.trim_end().strip_prefix('|').and_then(|line| line.strip_suffix('|')) {
        Some(cells) => format!("| {} |", cells.split('|').map(str::trim).collect::<Vec<_>>().join(" | ")),
        None => line.trim_end().to_owned(),
    };
    text.trim_start_matches('\u{feff}').lines().map(|line| cells(line) + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{page_of_others, run_of};
    use super::super::{ADVICE, dated, settle};
    use super::*;

    /// A file that is none of ours stays, and nobody waits for what no row of the page takes.
    #[test]
    fn what_cannot_take_the_result_is_refused_before_anything_is_measured() {
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("page.md");
        let refused = |text: &str| {
            std::fs::write(&name, text).unwrap();
            let Err(Failure::Input(why)) = settle(Some(&name), || panic!("it measures")) else { panic!("{text}") };
            assert_eq!(std::fs::read_to_string(&name).unwrap(), text);
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
            why
        };
        let page = page_of_others();
        let no_page = [
            "my notes\n".to_owned(),
            // Notes that quote lines of a page.
            format!("my notes\n\n{}\n", dated("Board nuc")),
            page.replacen("# Bring-up\n", "# My notes\n", 1),
            page.replacen("| row | assumption | result | figure |", "| a | b | c | d |", 1),
            page.replacen(" passed, ", " were good, ", 1),
            page.replacen("Board nuc", "The board nuc", 1),
        ];
        for text in no_page {
            let why = refused(&text);
            assert!(why.ends_with("page.md: that file is no page of bring-up; choose another name"), "{text}: {why}");
        }
        assert!(
            refused(&page.replace("| voltages of", "| levels of"))
                .contains("has no row \"voltages of an external DAC\": measure by the bring-up image anew")
        );
    }

    /// A page is known whatever an editor has done to its blanks, and with notes of its owner.
    #[test]
    fn a_page_that_was_edited_is_one() {
        let page = page_of_others();
        let notes = page.replacen("# Bring-up\n", "\u{feff}# Bring-up\n\nMy board, bought in May.\n", 1);
        for text in [page.clone(), run_of(None), notes, page.replace('\n', "\r\n"), page.replace(" |", "   |")] {
            assert!(is_page(&as_written(&text)), "{text}");
        }
        assert!(page.contains(ADVICE) && !is_page(page.split_once(ADVICE).unwrap().1));
    }

    /// Whatever ends a measurement, the page before is as it was, and the message says so. While it
    /// is measured there is nothing else on the disk, so that nothing is left where it is killed.
    #[test]
    fn a_measurement_that_ends_early_leaves_the_page_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("page.md");
        let files = || std::fs::read_dir(folder.path()).unwrap().count();
        let ends = |there: usize| {
            let failed = write(Some(&name), |_| {
                assert_eq!(files(), there);
                Err(Failure::Job("it ends".to_owned()))
            });
            let Err(Failure::Job(text)) = failed else { panic!() };
            assert_eq!(files(), there);
            text
        };
        assert_eq!(ends(0), "it ends");
        let page = page_of_others();
        std::fs::write(&name, &page).unwrap();
        assert_eq!(ends(1), format!("it ends\n{} is as it was.", name.display()));
        assert_eq!(std::fs::read_to_string(&name).unwrap(), page);
    }

    /// A link stays one, and what it leads to gets the page, whether it was there or not.
    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_its_end_is_written() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("far")).unwrap();
        symlink("far/page.md", at("near.md")).unwrap();
        symlink("near.md", at("link.md")).unwrap();
        for (before, new) in [(String::new(), run_of(None)), (run_of(None), page_of_others())] {
            write(Some(&at("link.md")), |found| {
                assert_eq!(found, before);
                Ok((new.clone(), "made".to_owned()))
            })
            .unwrap();
            assert_eq!(std::fs::read_to_string(at("far/page.md")).unwrap(), new);
            assert!([at("link.md"), at("near.md")].iter().all(|name| name.is_symlink()));
            assert_eq!(std::fs::read_dir(at("far")).unwrap().count(), 1);
        }
        symlink("to-itself.md", at("to-itself.md")).unwrap();
        let Err(Failure::Input(text)) = write(Some(&at("to-itself.md")), |_| panic!("it measures")) else { panic!() };
        assert!(text.starts_with("--page ") && text.contains("to-itself.md: cannot be read: "), "{text}");
        assert!(at("to-itself.md").is_symlink());
    }

    /// A pipe that nobody reads would hold the program for ever.
    #[cfg(unix)]
    #[test]
    fn what_is_no_plain_file_is_refused_before_anything_is_measured() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for name in [pipe.as_path(), Path::new("/dev/null"), folder.path()] {
            let Err(Failure::Input(text)) = write(Some(name), |_| panic!("it measures")) else { panic!("{name:?}") };
            let why = "this is a folder, a pipe or a device, and a page is a plain file; choose another name";
            assert_eq!(text, format!("--page {}: {why}", name.display()));
        }
        let Err(Failure::Input(text)) = write(Some(Path::new("-")), |_| panic!("it measures")) else { panic!() };
        assert_eq!(text, "--page -: it names a file; without --page the page goes to the standard output");
    }
}
