//! Lines of production code of `servo` and `dispatcher`.
//!
//! In: their sources. Out: how many lines are no blank line, no comment, and no test. Fails:
//! [`check`], where [the page](../../docs/development.md) names another figure.
use crate::shell::{Outcome, root};
use std::fs;
use std::path::Path;

/// Items under these are for tests.
const TESTS: [&str; 3] =
    ["#[cfg(test)]", "#[cfg(feature = \"test-hooks\")]", "#[cfg(any(test, feature = \"test-hooks\"))]"];
/// Files that such items name.
const FILES: [&str; 2] = ["tests", "test_hooks"];

/// Prints the counts.
pub fn report() -> Outcome {
    let counts = counts()?;
    counts.iter().for_each(|(package, count)| println!("{package}: {count} lines of production code"));
    println!("together: {}", sum(&counts));
    Ok(())
}

/// The page names the count of today.
pub fn check() -> Outcome {
    let page = root().join("docs/development.md");
    let text = fs::read_to_string(&page).map_err(|e| format!("{}: {e}", page.display()))?;
    let today = sum(&counts()?);
    let figure = format!("| {},{:03} |", today / 1000, today % 1000);
    match text.lines().any(|line| line.contains("`cargo xtask lines`") && line.contains(&figure)) {
        true => Ok(()),
        false => Err(format!("docs/development.md: no row of `cargo xtask lines` says {figure}, the count of today")),
    }
}

fn sum(counts: &[(&str, usize)]) -> usize {
    counts.iter().map(|(_, count)| count).sum()
}

fn counts() -> Outcome<Vec<(&'static str, usize)>> {
    ["servo", "dispatcher"]
        .map(|package| Ok((package, of_folder(&root().join(package).join("src"))?)))
        .into_iter()
        .collect()
}

fn of_folder(folder: &Path) -> Outcome<usize> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut sum = 0;
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.file_stem().is_some_and(|name| FILES.iter().any(|test| name == *test)) {
            continue;
        }
        sum += match path.is_dir() {
            true => of_folder(&path)?,
            false => of_text(&fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?),
        };
    }
    Ok(sum)
}

/// Lines of a file that count.
fn of_text(text: &str) -> usize {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
    let mut count = 0;
    while let Some(line) = lines.next() {
        if !TESTS.contains(&line) {
            count += 1;
            continue;
        }
        // The item after it: up to its last brace, or its semicolon.
        let mut depth = 0i32;
        for line in lines.by_ref() {
            depth += line.matches(['{', '(', '[']).count() as i32 - line.matches(['}', ')', ']']).count() as i32;
            if depth <= 0 && line.ends_with(['}', ';', ',']) {
                break;
            }
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_blank_lines_and_tests_do_not_count() {
        let text = "//! A file.\n\n/// One.\nfn one() {\n    // Two.\n    two();\n}\n\n#[cfg(test)]\nmod tests {\n    fn f() {}\n}\n\
                    #[cfg(feature = \"test-hooks\")]\npub mod test_hooks;\nstatic X: u8 = 1;\n";
        assert_eq!(of_text(text), 4);
    }
}
