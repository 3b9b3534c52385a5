//! The pages of the documentation: their links and the length of their sentences.
//!
//! In: `docs/**/*.md`, `README.md`, `CONTRIBUTING.md`, `CHANGELOG.md`. Out: what is wrong, a line
//! each. Owns nothing. Fails: a relative link whose file does not exist, an anchor that no heading
//! of its page has, a reference without a definition, a sentence of more than [`MAX_WORDS`]. Tables
//! and code have no sentences. Links to other sites are not followed.
use crate::shell::{Outcome, root};
use pulldown_cmark::{BrokenLink, CowStr, Event, LinkType, Options, Parser, Tag, TagEnd};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Pages outside `docs/`.
const TOP: [&str; 3] = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"];

/// The longest sentence, in words; code in a sentence is one word.
const MAX_WORDS: usize = 40;

/// What is read of a page. Numbers are lines, from 1.
#[derive(Debug, Default)]
struct Page {
    anchors: HashSet<String>,
    links: Vec<(usize, String)>,
    /// References without a definition.
    undefined: Vec<(usize, String)>,
    /// Sentences, with their lengths in words.
    sentences: Vec<(usize, usize, String)>,
}

impl Page {
    fn read(text: &str) -> Page {
        let line = |offset: usize| text.bytes().take(offset).filter(|byte| *byte == b'\n').count() + 1;
        let mut page = Page::default();
        let mut undefined = Vec::new();
        let mut broken = |link: BrokenLink<'_>| {
            if matches!(link.link_type, LinkType::Reference | LinkType::Collapsed) {
                undefined.push((line(link.span.start), link.reference.to_string()));
            }
            None::<(CowStr<'_>, CowStr<'_>)>
        };
        let (mut slugs, mut heading) = (HashMap::new(), None::<String>);
        // The block in progress: its first line and its text. Depth of tables and code.
        let (mut block, mut skipped) = (None::<(usize, String)>, 0u32);
        let options = Options::ENABLE_TABLES | Options::ENABLE_FOOTNOTES;
        let parser = Parser::new_with_broken_link_callback(text, options, Some(&mut broken));
        for (event, range) in parser.into_offset_iter() {
            match event {
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    page.anchors.extend(heading.take().map(|title| anchor(&title, &mut slugs)));
                }
                Event::Start(Tag::Table(_) | Tag::CodeBlock(_)) => skipped += 1,
                Event::End(TagEnd::Table | TagEnd::CodeBlock) => skipped -= 1,
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push((line(range.start), dest_url.to_string()));
                }
                Event::Start(Tag::Paragraph | Tag::Item) => {
                    page.end(block.take());
                    block = Some((line(range.start), String::new()));
                }
                Event::End(TagEnd::Paragraph | TagEnd::Item) => page.end(block.take()),
                Event::Html(html) | Event::InlineHtml(html) => page.anchors.extend(ids(&html)),
                Event::Text(words) if skipped == 0 => {
                    heading.iter_mut().chain(block.iter_mut().map(|(_, text)| text)).for_each(|t| t.push_str(&words));
                }
                Event::Code(words) if skipped == 0 => {
                    heading.iter_mut().for_each(|title| title.push_str(&words));
                    block.iter_mut().for_each(|(_, text)| text.push_str("`code`"));
                }
                Event::SoftBreak | Event::HardBreak => block.iter_mut().for_each(|(_, text)| text.push(' ')),
                _ => {}
            }
        }
        page.undefined = undefined;
        page
    }

    /// A block ends: its sentences.
    fn end(&mut self, block: Option<(usize, String)>) {
        let Some((line, text)) = block else { return };
        for sentence in sentences(&text) {
            let words = sentence.split_whitespace().filter(|word| word.chars().any(char::is_alphanumeric)).count();
            self.sentences.push((line, words, sentence.trim().to_owned()));
        }
    }
}

/// Sentences of a text that are too long, as what is wrong: the line at which the block begins, and
/// a text.
pub fn long_sentences(text: &str) -> Vec<(usize, String)> {
    let long = Page::read(text).sentences.into_iter().filter(|(_, words, _)| *words > MAX_WORDS);
    let wrong = long.map(|(line, words, sentence)| {
        let begin: String = sentence.chars().take(60).collect();
        (line, format!("a sentence of {words} words, {MAX_WORDS} at most: {begin}…"))
    });
    wrong.collect()
}

/// A text at the ends of its sentences: a mark, then white space, then no lower-case letter.
fn sentences(text: &str) -> Vec<&str> {
    let (mut found, mut begin) = (Vec::new(), 0);
    for (at, mark) in text.char_indices().filter(|(_, c)| matches!(c, '.' | '!' | '?')) {
        let after = &text[at + mark.len_utf8()..];
        let follows = after.trim_start_matches([')', '"', '*']).trim_start();
        let is_end = follows.len() < after.len() && after.starts_with([' ', ')', '"', '*']);
        if is_end && !follows.starts_with(char::is_lowercase) {
            let end = text.len() - follows.len();
            found.push(&text[begin..end]);
            begin = end;
        }
    }
    found.push(&text[begin..]);
    found
}

/// The anchor that GitHub gives a heading: lower case, letters, digits, `_` and `-` kept, spaces to
/// `-`. A title that occurs again gets `-1`, `-2` and so on.
fn anchor(title: &str, known: &mut HashMap<String, u32>) -> String {
    let kept = |c: &char| c.is_alphabetic() || c.is_ascii_digit() || matches!(c, ' ' | '-' | '_');
    let slug: String = title.to_lowercase().chars().filter(kept).map(|c| if c == ' ' { '-' } else { c }).collect();
    let times = known.entry(slug.clone()).or_default();
    *times += 1;
    if *times == 1 { slug } else { format!("{slug}-{}", *times - 1) }
}

/// The anchors that HTML in a page sets.
fn ids(html: &str) -> Vec<String> {
    let after = |attribute| html.split(attribute).skip(1).filter_map(|rest: &str| rest.split('"').next());
    after(" id=\"").chain(after(" name=\"")).map(str::to_owned).collect()
}

/// A path without `.` and `..`; nothing if it leaves the tree.
fn normal(path: &Path) -> Option<PathBuf> {
    path.components().try_fold(PathBuf::new(), |mut path, component| match component {
        Component::Normal(name) => Some(path.join(name)),
        Component::CurDir | Component::RootDir => Some(path),
        Component::ParentDir => path.pop().then_some(path),
        Component::Prefix(_) => None,
    })
}

/// The pages below a folder of the tree.
fn below(root: &Path, folder: &Path, pages: &mut BTreeSet<PathBuf>) -> Outcome {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    for entry in fs::read_dir(root.join(folder)).map_err(failed)? {
        let path = folder.join(entry.map_err(failed)?.file_name());
        if root.join(&path).is_dir() {
            below(root, &path, pages)?;
        } else if path.extension().is_some_and(|ending| ending == "md") {
            pages.insert(path);
        }
    }
    Ok(())
}

fn read(root: &Path, path: &Path) -> Outcome<Page> {
    let text = fs::read_to_string(root.join(path)).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(Page::read(&text))
}

/// What is wrong with a link of a page; `pages` holds what was read so far.
fn wrong(root: &Path, from: &Path, link: &str, pages: &mut HashMap<PathBuf, Page>) -> Outcome<Option<String>> {
    if link.contains("://") || link.starts_with("mailto:") {
        return Ok(None);
    }
    let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
    let folder = if file.starts_with('/') { Path::new("") } else { from.parent().unwrap_or(Path::new("")) };
    let to = if file.is_empty() { Some(from.to_owned()) } else { normal(&folder.join(file.trim_start_matches('/'))) };
    let Some(to) = to.filter(|to| root.join(to).exists()) else {
        return Ok(Some(format!("there is no {file}")));
    };
    let Some(anchor) = anchor.filter(|_| to.extension().is_some_and(|ending| ending == "md")) else {
        return Ok(None);
    };
    if !pages.contains_key(&to) {
        let page = read(root, &to)?;
        pages.insert(to.clone(), page);
    }
    let found = pages.get(&to).is_some_and(|page| page.anchors.contains(anchor));
    Ok((!found).then(|| format!("{} has no heading #{anchor}", to.display())))
}

/// The pages that lead through the code: each file that they name is there.
const OF_THE_CODE: [&str; 5] = ["tour", "architecture", "add-a-command", "add-a-motion-mode", "add-a-board"];

/// Files in code of a page, from the root of the tree, that are not there: line and name. BOARD
/// stands for the name of any board.
fn missing_files(root: &Path, text: &str) -> Vec<(usize, String)> {
    let in_code = |(line, text): (usize, &str)| {
        let code = text.split('`').skip(1).step_by(2).map(str::to_owned);
        code.map(move |code| (line + 1, code)).collect::<Vec<_>>()
    };
    let is_file = |code: &str| {
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '/' | '.' | '_' | '-');
        code.ends_with(".rs") && !code.contains("BOARD") && code.contains('/') && code.chars().all(plain)
    };
    let named = text.lines().enumerate().flat_map(in_code);
    named.filter(|(_, code)| is_file(code) && !root.join(code).is_file()).collect()
}

/// The pages of a tree, from its root.
pub fn paths(root: &Path) -> Outcome<BTreeSet<PathBuf>> {
    let mut paths: BTreeSet<PathBuf> = TOP.iter().map(PathBuf::from).collect();
    below(root, Path::new("docs"), &mut paths)?;
    Ok(paths)
}

/// Everything that is wrong in a tree's pages, and how many links and sentences they have.
fn faults(root: &Path) -> Outcome<(Vec<String>, usize, usize)> {
    let paths = paths(root)?;
    let (mut pages, mut faults) = (HashMap::new(), Vec::new());
    let (mut links, mut sentences) = (0, 0);
    for path in &paths {
        let page = read(root, path)?;
        let at = |line: &usize| format!("{}:{line}", path.display());
        links += page.links.len();
        sentences += page.sentences.len();
        for (line, link) in &page.links {
            let wrong = wrong(root, path, link, &mut pages)?;
            faults.extend(wrong.map(|wrong| format!("{}: the link {link}: {wrong}", at(line))));
        }
        if OF_THE_CODE.iter().any(|name| path.file_stem().is_some_and(|stem| stem == *name)) {
            let text = fs::read_to_string(root.join(path)).map_err(|e| format!("{}: {e}", path.display()))?;
            let missing = missing_files(root, &text).into_iter();
            faults.extend(missing.map(|(line, file)| format!("{}: there is no file {file}", at(&line))));
        }
        for (line, reference) in &page.undefined {
            faults.push(format!("{}: [{reference}] is defined nowhere", at(line)));
        }
        for (line, words, sentence) in page.sentences.iter().filter(|(_, words, _)| *words > MAX_WORDS) {
            let begin: String = sentence.chars().take(60).collect();
            faults.push(format!("{}: a sentence of {words} words, {MAX_WORDS} at most: {begin}…", at(line)));
        }
    }
    Ok((faults, links, sentences))
}

/// Checks the pages of this tree.
pub fn check() -> Outcome {
    let (faults, links, sentences) = faults(&root())?;
    if faults.is_empty() {
        println!("{links} links and {sentences} sentences of the documentation are in order");
        return Ok(());
    }
    Err(format!("{} faults in the documentation:\n{}", faults.len(), faults.join("\n")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tree of pages in the folder for temporary files, removed at the end.
    struct Tree(PathBuf);

    impl Tree {
        fn new(name: &str, readme: &str) -> Tree {
            let root = std::env::temp_dir().join(format!("beamtick-pages-{}-{name}", std::process::id()));
            fs::create_dir_all(root.join("docs/decisions")).unwrap();
            for (path, text) in [
                ("README.md", readme),
                ("CONTRIBUTING.md", "See [the decision](docs/decisions/1.md#why-2-µs)."),
                ("CHANGELOG.md", "# Changes"),
                ("docs/page.md", "# A page\n\n## Same\n\n## Same\n\n[up](../README.md) <a id=\"mark\"></a>"),
                ("docs/decisions/1.md", "# 1: `code` & more\n\n## Why 2 µs?\n\n[page](../page.md#same-1)"),
            ] {
                fs::write(root.join(path), text).unwrap();
            }
            Tree(root)
        }

        fn faults(&self) -> Vec<String> {
            faults(&self.0).unwrap().0
        }
    }

    impl Drop for Tree {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn good_links_are_good() {
        let tree = Tree::new(
            "good",
            "# Top\n\n[a](docs/page.md) [b](docs/page.md#mark) [c](#top) [d](docs) [e](https://example.org/x)\n\
             [f](docs/decisions/1.md#1-code--more)",
        );
        assert_eq!(tree.faults(), [""; 0]);
    }

    #[test]
    fn a_broken_link_is_found_with_its_line() {
        let tree = Tree::new("file", "# Top\n\nSee\n[a](docs/pages.md).");
        assert_eq!(tree.faults(), ["README.md:4: the link docs/pages.md: there is no docs/pages.md"]);
        let tree = Tree::new("outside", "![a](../outside.png)");
        assert_eq!(tree.faults(), ["README.md:1: the link ../outside.png: there is no ../outside.png"]);
        let tree = Tree::new("reference", "[a][b]");
        assert_eq!(tree.faults(), ["README.md:1: [b] is defined nowhere"]);
    }

    #[test]
    fn a_broken_anchor_is_found() {
        let tree = Tree::new("anchor", "[a](docs/page.md#same-2) [b](#nothing)");
        let [first, second] = &tree.faults()[..] else { panic!("{:?}", tree.faults()) };
        assert_eq!(first, "README.md:1: the link docs/page.md#same-2: docs/page.md has no heading #same-2");
        assert_eq!(second, "README.md:1: the link #nothing: README.md has no heading #nothing");
    }

    #[test]
    fn a_file_that_a_page_names_and_that_is_not_there_is_found() {
        let text = "The file `src/pages.rs`.\n\n| `src/gone.rs` | `name` | `src/*.rs` |\n";
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert_eq!(missing_files(root, text), [(3, "src/gone.rs".to_owned())]);
    }

    #[test]
    fn a_long_sentence_is_found_outside_tables_and_code() {
        let words = |n: usize| format!("One{}", " more".repeat(n - 1));
        let long = words(MAX_WORDS + 1);
        let allowed = format!(
            "{}.\n{}. Next.\n\n| a |\n| --- |\n| {long} |\n\n```text\n{long}\n```\n",
            words(MAX_WORDS),
            words(MAX_WORDS)
        );
        assert_eq!(Tree::new("short", &allowed).faults(), [""; 0]);
        let faults = Tree::new("long", &format!("- Short.\n- {long}.\n")).faults();
        assert_eq!(faults.len(), 1);
        assert!(faults[0].starts_with("README.md:2: a sentence of 41 words, 40 at most: One"), "{}", faults[0]);
    }
}
