//! Comments in the code: their width, the length of their sentences, and the names in them.
//!
//! In: every Rust file of the tree. Out: what is wrong, a line each. Owns nothing. Fails: a line
//! that begins with `//` and ends after column [`WIDTH_COLUMNS`]; a sentence too long for a page
//! ([`long_sentences`]); a name that is not there ([`names`]), here or in a page. A row of a table
//! in a comment may be wider, as it cannot be divided. Code has the width that rustfmt gives it.
use crate::names::{self, Index};
use crate::pages::{self, long_sentences};
use crate::shell::{Outcome, root};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

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

/// The Rust files below a folder, from the root of the tree. What is built and what is hidden are
/// left out.
fn below(root: &Path, folder: &Path, files: &mut BTreeMap<PathBuf, String>) -> Outcome {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    for entry in fs::read_dir(root.join(folder)).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let (path, name) = (folder.join(entry.file_name()), entry.file_name().to_string_lossy().into_owned());
        if entry.path().is_dir() {
            if !name.starts_with('.') && name != "target" && name != "out" {
                below(root, &path, files)?;
            }
        } else if name.ends_with(".rs") {
            let text = fs::read_to_string(entry.path()).map_err(|e| format!("{}: {e}", path.display()))?;
            files.insert(path, text);
        }
    }
    Ok(())
}

/// Checks the comments of this tree, and the names of the code in its pages.
pub fn check() -> Outcome {
    let (root, mut files, mut faults) = (root(), BTreeMap::new(), Vec::new());
    below(&root, Path::new(""), &mut files)?;
    let index = Index::new(&files);
    for (path, text) in &files {
        let at = |(line, width)| format!("{}:{line}: {width} columns, {WIDTH_COLUMNS} at most", path.display());
        faults.extend(wide(text).map(at));
        let comments = comments(text);
        let long = long_sentences(&comments).into_iter();
        faults.extend(long.map(|(line, wrong)| format!("{}:{line}: {wrong}", path.display())));
        faults.extend(names::faults(&index, path, &comments));
    }
    for path in pages::paths(&root)? {
        let text = fs::read_to_string(root.join(&path)).map_err(|e| format!("{}: {e}", path.display()))?;
        faults.extend(names::faults(&index, &path, &text));
    }
    if faults.is_empty() {
        let files = files.len();
        println!("the comments of {files} files end within {WIDTH_COLUMNS} columns, none with a long sentence");
        println!("the names of the code in pages and comments are there");
        return Ok(());
    }
    Err(format!("{} faults in comments and names:\n{}", faults.len(), faults.join("\n")))
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
