//! Names of the code in pages and comments: what `a::b` names is there.
//!
//! In: the pages and the Rust files of the tree. Out: names that are not there, a line each. Owns
//! nothing. Fails: two names of a path, `a::b`, of which no file that declares `a`, or is part of
//! its module, has `b` in its code. Names of the standard library are not looked up.
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

/// Words after which a name is declared.
const DECLARING: [&str; 7] = ["struct", "enum", "trait", "type", "union", "mod", "impl"];

/// First parts of paths that are not looked up.
const OUTSIDE: [&str; 7] = ["std", "core", "alloc", "crate", "super", "Self", "this_thread"];

/// What a path of the standard library begins with, the numbers of the language among it.
const LIBRARY: [&str; 15] =
    ["std", "core", "alloc", "u8", "u16", "u32", "u64", "u128", "usize", "i8", "i16", "i32", "i64", "f32", "f64"];

/// The names of a file's code.
struct Names {
    /// What the file declares or implements, and the modules that it is part of.
    declared: HashSet<String>,
    all: HashSet<String>,
}

/// The names of every Rust file.
pub struct Index(BTreeMap<PathBuf, Names>);

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

impl Index {
    /// Of files, with their paths from the root of the tree.
    pub fn new(files: &BTreeMap<PathBuf, String>) -> Index {
        let names = |(path, text): (&PathBuf, &String)| {
            let modules = path.with_extension("").to_string_lossy().replace('-', "_");
            let mut declared: HashSet<String> = modules.split('/').map(str::to_owned).collect();
            let mut all = declared.clone();
            for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
                all.extend(words(line).map(str::to_owned));
                let is_impl = line.trim_start().starts_with("impl");
                let pairs = words(line).zip(words(line).skip(1));
                let named = pairs.filter(|(before, _)| is_impl || DECLARING.contains(before));
                declared.extend(named.map(|(_, name)| name.to_owned()));
            }
            (path.clone(), Names { declared, all })
        };
        Index(files.iter().map(names).collect())
    }

    /// Whether `inner` is a name of `outer`. What no file declares (a macro does) may be in any
    /// file that names it.
    fn holds(&self, outer: &str, inner: &str) -> bool {
        let known = self.0.values().any(|names| names.declared.contains(outer));
        let mut files = self.0.values();
        files.any(|n| if known { &n.declared } else { &n.all }.contains(outer) && n.all.contains(inner))
    }

    /// Names in inline code of a text that are not there: line and name.
    pub fn missing(&self, text: &str) -> Vec<(usize, String)> {
        let in_code = |(line, text): (usize, &str)| {
            let code = text.split('`').skip(1).step_by(2).map(str::to_owned);
            code.map(move |code| (line + 1, code)).collect::<Vec<_>>()
        };
        let is_path = |code: &str| {
            let is_name = |name: &str| words(name).eq([name]) && !name.starts_with(|c: char| c.is_ascii_digit());
            code.contains("::") && code.split("::").all(is_name)
        };
        let is_there = |code: &str| {
            let parts = || code.split("::").filter(|part| !OUTSIDE.contains(part));
            let outside = code.split("::").next().is_some_and(|first| LIBRARY.contains(&first));
            outside || parts().zip(parts().skip(1)).all(|(outer, inner)| self.holds(outer, inner))
        };
        let named = text.lines().enumerate().flat_map(in_code);
        named.filter(|(_, code)| is_path(code) && !is_there(code)).collect()
    }
}

/// What is wrong with the names of one text.
pub fn faults(index: &Index, path: &Path, text: &str) -> Vec<String> {
    let missing = index.missing(text).into_iter();
    missing.map(|(line, name)| format!("{}:{line}: there is no {name}", path.display())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_not_there_is_found() {
        let files = [
            ("servo/src/laser/channel.rs", "pub struct Channel;\nimpl Channel {\n fn queue_event() {}\n}\n// expect"),
            ("host/virtual/src/board.rs", "use dispatcher::BoardConstants;\nfn advance() {}"),
            ("dispatcher/src/board.rs", "struct BoardConstants;"),
        ];
        let files = files.map(|(path, text)| (PathBuf::from(path), text.to_owned()));
        let index = Index::new(&BTreeMap::from(files));
        let good = "`Channel::queue_event` `servo::laser::channel` `std::fs::read` `a::b()` `Self::x`";
        assert_eq!(index.missing(good), []);
        let text = "one\n`Channel::expect`, `laser::owner` and\n`BoardConstants::advance`";
        let missing = [(2, "Channel::expect"), (2, "laser::owner"), (3, "BoardConstants::advance")];
        assert_eq!(index.missing(text), missing.map(|(line, name)| (line, name.to_owned())));
    }
}
