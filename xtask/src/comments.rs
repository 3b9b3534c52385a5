//! Comments in the code: their width, and the length of their sentences.
//!
//! In: every Rust file of the tree. Out: what is wrong, a line each. Owns nothing. Fails: a line
//! that begins with `//` and ends after column [`WIDTH_COLUMNS`]; a sentence that would be too long
//! in a page ([`long_sentences`]). A row of a table in a comment may be wider, as it cannot be
//! divided. Code has the width that rustfmt gives it.
use crate::pages::long_sentences;
use crate::shell::{Outcome, root};
use std::fs;
use std::path::Path;

/// The last column of a comment.
const WIDTH_COLUMNS: usize = 100;

/// The lines of a text whose comment is too wide, from 1, with their widths.
fn wide(text: &str) -> impl Iterator<Item = (usize, usize)> {
    let widths = text.lines().enumerate().filter_map(|(line, text)| {
        let comment = text.trim_start().strip_prefix("//")?;
        let is_row = comment.trim_start_matches(['/', '!', ' ']).starts_with('|');
        (!is_row).then(|| (line + 1, text.chars().count()))
    });
    widths.filter(|(_, width)| *width > WIDTH_COLUMNS)
}

/// The comments of a file, each in its line; what is no comment is an empty line.
fn comments(text: &str) -> String {
    let comment = |line: &str| {
        let comment = line.trim_start().strip_prefix("//")?.trim_start_matches(['/', '!']);
        Some(comment.strip_prefix(' ').unwrap_or(comment).to_owned())
    };
    text.lines().map(|line| comment(line).unwrap_or_default() + "\n").collect()
}

/// The faults of all files below a folder; how many files there are. What is built and what is
/// hidden are left out.
fn below(folder: &Path, faults: &mut Vec<String>) -> Outcome<usize> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut files = 0;
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if path.is_dir() {
            if !name.starts_with('.') && name != "target" && name != "out" {
                files += below(&path, faults)?;
            }
        } else if name.ends_with(".rs") {
            let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            let at = |(line, width)| format!("{}:{line}: {width} columns, {WIDTH_COLUMNS} at most", path.display());
            faults.extend(wide(&text).map(at));
            let long = long_sentences(&comments(&text)).into_iter();
            faults.extend(long.map(|(line, wrong)| format!("{}:{line}: {wrong}", path.display())));
            files += 1;
        }
    }
    Ok(files)
}

/// Checks the comments of this tree.
pub fn check() -> Outcome {
    let mut faults = Vec::new();
    let files = below(&root(), &mut faults)?;
    if faults.is_empty() {
        println!("the comments of {files} files end within {WIDTH_COLUMNS} columns, none with a long sentence");
        return Ok(());
    }
    Err(format!("{} comments are too wide or too long:\n{}", faults.len(), faults.join("\n")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_comments_are_measured_and_rows_of_tables_are_not() {
        let long = "x".repeat(WIDTH_COLUMNS);
        let text = format!(
            "//! {long}\n    /// {long}\n// {long}\nlet code = {long}; // {long}\n//! | {long} |\n// {}",
            "µ".repeat(WIDTH_COLUMNS - 3)
        );
        assert_eq!(wide(&text).collect::<Vec<_>>(), [(1, 104), (2, 108), (3, 103)]);
    }

    #[test]
    fn a_long_sentence_of_a_comment_is_found_and_code_ends_it() {
        let long = "word ".repeat(30);
        let text = format!("/// One {long}\n/// {long}.\nfn f() {{}}\n\n// Two {long}\nlet x = 1;\n// {long}.\n");
        let found = long_sentences(&comments(&text));
        assert_eq!(found.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [1]);
        assert!(found[0].1.starts_with("a sentence of 61 words"), "{}", found[0].1);
    }
}
