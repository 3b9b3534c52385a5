//! The text of a script to tokens. Full-width punctuation becomes ASCII. Comments, `#include`,
//! lines of dots, code fences, and the remainder of a comment on the next line are removed.
//! `#define` names are replaced as by the C preprocessor.
//!
//! In: the text. Out: [`Token`]s, each with its position in the original text. Owns the macros.
//! Fails with diagnostics: an unfinished comment or string, a directive that scripts do not have.

use crate::{Diagnostic, Pragma, Severity};
use logos::Logos;
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::rc::Rc;

/// More tokens than these are not read: macros that double each other must not eat the memory.
const MAX_TOKENS: usize = 4_000_000;

/// More names than these are not replaced: a chain of macros asked for often is more work than the
/// text is long.
const MAX_REPLACED_TOKENS: usize = 1_000_000;
/// More problems of the text than these are not listed.
const PROBLEMS_SHOWN: usize = 20;
/// What is said of a character that is no token.
const JUNK: (&str, &str) = ("this character has no meaning in a job script", "remove it, or put it into a comment");

/// What a token is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A name.
    Name,
    /// A number.
    Number,
    /// A string in quotes; the token's text is the text between them.
    Text,
    /// Punctuation.
    Mark,
    /// `#pragma continue` (text `on`) or `#pragma continue off`.
    Continue,
    /// The end of the script.
    End,
}

/// One token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Token {
    /// What it is.
    pub kind: Kind,
    /// Its text, punctuation normalised.
    pub text: String,
    /// Its bytes in the script as given; for the text of a macro, those of the macro's name.
    pub span: Range<usize>,
}

#[derive(Logos, Debug, Clone, Copy, PartialEq, Eq)]
#[logos(skip r"[ \t\f]+|\\(\r\n|\r|\n)")]
enum Raw {
    #[regex(r"\r\n|\r|\n")]
    Newline,
    #[regex(r"//[^\r\n]*", allow_greedy = true)]
    LineComment,
    #[token("/*", comment)]
    Comment(bool),
    #[regex(r"```[^\r\n]*", allow_greedy = true)]
    Fence,
    #[regex(r"(\.\.|…|⋯|⋮)[.…⋯⋮]*")]
    Dots,
    #[regex(r"[\p{Alphabetic}_][\p{Alphabetic}\p{N}_]*")]
    Name,
    #[regex(r"0[xX][0-9a-fA-F]+[uUlL]*")]
    #[regex(r"([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?[fFlL]?")]
    #[regex(r"[0-9]+[eE][+-]?[0-9]+[fFlL]?")]
    #[regex(r"[0-9]+[uUlL]*")]
    Number,
    #[regex(r#""([^"\\\r\n]|\\.)*""#)]
    #[regex(r"'([^'\\\r\n]|\\.)+'")]
    Text,
    #[token("\"")]
    #[token("'")]
    OpenText,
    #[regex(r"<<=|>>=|<<|>>|\+\+|--|->|&&|\|\||[-+*/%&|^<>=!]=|[-+*/%&|^~!<>=(){}\[\];,.?:#]")]
    Mark,
}

/// Skips a block comment; false when it does not end.
fn comment(lexer: &mut logos::Lexer<Raw>) -> bool {
    match lexer.remainder().find("*/") {
        Some(at) => {
            lexer.bump(at + 2);
            true
        }
        None => {
            lexer.bump(lexer.remainder().len());
            false
        }
    }
}

/// Whether a line is Chinese text and no statement: the remainder of a comment that the printed
/// manuals have broken.
fn is_prose(line: &str) -> bool {
    line.starts_with(|first| ('\u{4e00}'..='\u{9fff}').contains(&first)) && !line.contains([';', '='])
}

/// ASCII for the full-width forms (U+FF01 to U+FF5E) and the typographic marks of the manuals.
fn plain(character: char) -> char {
    match character {
        '\u{ff01}'..='\u{ff5e}' => char::from_u32(character as u32 - 0xfee0).unwrap_or(character),
        '\u{3000}' | '\u{a0}' | '\u{feff}' | '\u{200b}' => ' ',
        '“' | '”' | '„' | '〝' | '〞' => '"',
        '‘' | '’' => '\'',
        '、' => ',',
        '【' => '[',
        '】' => ']',
        '−' | '–' | '—' => '-',
        other => other,
    }
}

/// Where the lines of a text begin.
pub struct Lines {
    starts: Vec<usize>,
    /// The last byte asked for, and its column: a long line is counted once.
    last: Cell<(usize, usize)>,
}

impl Lines {
    /// The lines of `text`; they end with LF, CR LF or CR.
    pub fn of(text: &str) -> Self {
        let bytes = text.as_bytes();
        let ends = bytes.iter().enumerate().filter(|(at, byte)| match byte {
            b'\n' => true,
            b'\r' => bytes.get(at + 1) != Some(&b'\n'),
            _ => false,
        });
        let starts = std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect();
        Lines { starts, last: Cell::new((0, 1)) }
    }

    /// Line and column (characters), both from 1, of byte `at` of the same text.
    pub fn place(&self, text: &str, at: usize) -> (u32, u32) {
        let line = self.starts.partition_point(|start| *start <= at).max(1);
        let start = self.starts[line - 1];
        let (known, column) = self.last.get();
        let (from, before) = if (start..=at).contains(&known) { (known, column) } else { (start, 1) };
        let column = text.get(from..at).map_or(1, |between| before + between.chars().count());
        self.last.set((at, column));
        (u32::try_from(line).unwrap_or(u32::MAX), u32::try_from(column).unwrap_or(u32::MAX))
    }
}

/// A diagnostic that points at `span` of `text`.
pub fn diagnostic(
    lines: &Lines,
    text: &str,
    severity: Severity,
    span: Range<usize>,
    message: String,
    help: Option<String>,
) -> Diagnostic {
    let (line, column) = lines.place(text, span.start);
    Diagnostic { severity, line, column, span, message, help }
}

/// Pragmas that replace an option of the command line.
const OPTIONS: [&str; 3] = ["family", "profile", "tick"];

/// What the text of a script is made of.
pub struct Scanned {
    /// All tokens, an `End` last.
    pub tokens: Vec<Token>,
    /// Pragmas that replace options, each once.
    pub pragmas: Vec<Pragma>,
    /// What is wrong with the text.
    pub problems: Vec<Diagnostic>,
}

/// The tokens of `text`.
pub fn scan(text: &str) -> Scanned {
    let mut flat = String::with_capacity(text.len());
    let mut origin = Vec::with_capacity(text.len() + 1);
    for (at, character) in text.char_indices() {
        let character = plain(character);
        flat.push(character);
        origin.resize(flat.len(), at);
    }
    origin.push(text.len());
    let given = |range: &Range<usize>| origin[range.start]..origin[range.end];

    let mut found = Vec::new();
    let mut problems = Vec::new();
    let lines = Lines::of(text);
    let mut refuse = |span: &Range<usize>, message: &str, help: &str| {
        if problems.len() < PROBLEMS_SHOWN {
            let (message, help) = (message.to_owned(), Some(help.to_owned()));
            problems.push(diagnostic(&lines, text, Severity::Error, given(span), message, help));
        }
    };
    // Junk in a row is one mistake.
    let mut junk: Option<Range<usize>> = None;
    // The line above ended with a comment; then, what is left of one that the print has broken.
    let (mut commented, mut rest) = (false, 0);
    let mut broken = Vec::new();
    for (raw, span) in Raw::lexer(&flat).spanned() {
        if commented && matches!(raw, Ok(Raw::Name)) && found.last().is_none_or(|(raw, _)| *raw == Raw::Newline) {
            let line = flat[span.start..].split(['\r', '\n']).next().unwrap_or_default();
            if is_prose(line) {
                rest = span.start + line.len();
                broken.push(span.start..rest);
            }
        }
        commented = match raw {
            Ok(Raw::LineComment) => true,
            Ok(Raw::Newline | Raw::Fence) => commented,
            _ => commented && span.start < rest,
        };
        match &mut junk {
            Some(before) if raw.is_err() && before.end == span.start => before.end = span.end,
            before => {
                let next = raw.is_err().then(|| span.clone());
                if let Some(whole) = std::mem::replace(before, next) {
                    refuse(&whole, JUNK.0, JUNK.1);
                }
            }
        }
        match raw {
            _ if span.start < rest => {}
            Ok(Raw::LineComment | Raw::Comment(true) | Raw::Fence | Raw::Dots) => {}
            Ok(Raw::Comment(false)) => {
                refuse(&(span.start..span.start + 2), "this comment does not end", "close it with */");
            }
            Ok(Raw::OpenText) => refuse(&span, "this text does not end on its line", "close it with a quotation mark"),
            Ok(raw) => found.push((raw, span)),
            Err(()) => {}
        }
    }
    if let Some(whole) = junk {
        refuse(&whole, JUNK.0, JUNK.1);
    }
    for span in broken.iter().take(PROBLEMS_SHOWN) {
        let message = "this line is taken as the remainder of the comment above".to_owned();
        let help = Some("put // before it".to_owned());
        problems.push(diagnostic(&lines, text, Severity::Warning, given(span), message, help));
    }
    let (macros, pragmas) = (HashMap::new(), Vec::new());
    let mut out = Expansion {
        text,
        lines: &lines,
        flat: &flat,
        given: &given,
        macros,
        out: Vec::new(),
        replaced: 0,
        pragmas,
        problems,
    };
    for line in found.split(|(raw, _)| *raw == Raw::Newline) {
        out.line(line);
    }
    let Expansion { out: mut tokens, replaced, pragmas, mut problems, .. } = out;
    if tokens.len() >= MAX_TOKENS || replaced >= MAX_REPLACED_TOKENS {
        let message = format!("this script is too long: {MAX_TOKENS} words and marks fit");
        problems.push(diagnostic(
            &lines,
            text,
            Severity::Error,
            0..0,
            message,
            Some("split it, or use the C library".into()),
        ));
    }
    tokens.push(Token {
        kind: Kind::End,
        text: "the end of the script".into(),
        span: text.trim_end().len()..text.len(),
    });
    Scanned { tokens, pragmas, problems }
}

/// The preprocessor: directives and the macros they define.
struct Expansion<'a, G: Fn(&Range<usize>) -> Range<usize>> {
    text: &'a str,
    lines: &'a Lines,
    flat: &'a str,
    given: &'a G,
    macros: HashMap<String, Rc<[Token]>>,
    out: Vec<Token>,
    /// Names that were replaced: macros of macros may be many for a token.
    replaced: usize,
    pragmas: Vec<Pragma>,
    problems: Vec<Diagnostic>,
}

impl<G: Fn(&Range<usize>) -> Range<usize>> Expansion<'_, G> {
    fn token(&self, raw: Raw, span: &Range<usize>) -> Token {
        let given = (self.given)(span);
        let (kind, text) = match raw {
            Raw::Name => (Kind::Name, self.flat[span.clone()].to_owned()),
            Raw::Number => (Kind::Number, self.flat[span.clone()].to_owned()),
            // The text between the quotes is the user's, full-width characters included.
            Raw::Text => {
                let inner = (self.given)(&(span.start + 1..span.end - 1));
                (Kind::Text, self.text[inner].to_owned())
            }
            _ => (Kind::Mark, self.flat[span.clone()].to_owned()),
        };
        Token { kind, text, span: given }
    }

    fn line(&mut self, line: &[(Raw, Range<usize>)]) {
        match line {
            [(Raw::Mark, hash), rest @ ..] if &self.flat[hash.clone()] == "#" => self.directive(hash, rest),
            _ => {
                for (raw, span) in line {
                    let token = self.token(*raw, span);
                    self.expand(token);
                }
            }
        }
    }

    /// Outputs `token`, or the text of its macro. A macro does not replace its own name inside
    /// itself.
    fn expand(&mut self, token: Token) {
        // The macros being replaced: name, text, and how far it has come.
        let mut open: Vec<(String, Rc<[Token]>, usize)> = Vec::new();
        let mut names: HashSet<String> = HashSet::new();
        let span = token.span.clone();
        let mut next = Some(token);
        while self.out.len() < MAX_TOKENS && self.replaced < MAX_REPLACED_TOKENS {
            if let Some(token) = next.take() {
                let is_macro = token.kind == Kind::Name && !names.contains(&token.text);
                match self.macros.get(&token.text).filter(|_| is_macro) {
                    Some(body) => {
                        self.replaced += 1;
                        names.insert(token.text.clone());
                        open.push((token.text, Rc::clone(body), 0));
                    }
                    None => self.out.push(token),
                }
            }
            let Some((name, body, at)) = open.last_mut() else { return };
            match body.get(*at) {
                Some(part) => {
                    *at += 1;
                    next = Some(Token { span: span.clone(), ..part.clone() });
                }
                None => {
                    names.remove(name);
                    open.pop();
                }
            }
        }
    }

    fn directive(&mut self, hash: &Range<usize>, rest: &[(Raw, Range<usize>)]) {
        let word = rest.first().map_or("", |(_, span)| &self.flat[span.clone()]);
        let whole = hash.start..rest.last().map_or(hash.end, |(_, span)| span.end);
        match word {
            "include" | "" => {}
            "define" => self.define(&whole, &rest[1..]),
            "undef" => {
                if let Some((Raw::Name, span)) = rest.get(1) {
                    self.macros.remove(&self.flat[span.clone()]);
                }
            }
            "pragma" => self.pragma(&whole, &rest[1..]),
            other => {
                let message = format!("#{other} is not available in job scripts");
                let help = "scripts know #include (skipped), #define, #undef and #pragma continue; for more, use the C library";
                self.refuse(&whole, message, help);
            }
        }
    }

    fn define(&mut self, whole: &Range<usize>, rest: &[(Raw, Range<usize>)]) {
        let [(Raw::Name, name), body @ ..] = rest else {
            self.refuse(whole, "#define needs a name".into(), "write #define NAME value");
            return;
        };
        // A parenthesis that touches the name makes a function-like macro.
        if body.first().is_some_and(|(_, span)| span.start == name.end && &self.flat[span.clone()] == "(") {
            let message = format!("`{}` is a macro with parameters; job scripts have none", &self.flat[name.clone()]);
            self.refuse(whole, message, "write the expression out, or use the C library");
            return;
        }
        let body = body.iter().map(|(raw, span)| self.token(*raw, span)).collect();
        self.macros.insert(self.flat[name.clone()].to_owned(), body);
    }

    fn pragma(&mut self, whole: &Range<usize>, rest: &[(Raw, Range<usize>)]) {
        let words: Vec<&str> = rest.iter().map(|(_, span)| &self.flat[span.clone()]).collect();
        let text = match words[..] {
            ["continue"] => "on",
            ["continue", "off"] => "off",
            [name, ..] if OPTIONS.contains(&name) => return self.option(name, whole, &rest[1..]),
            _ => {
                let given = (self.given)(whole);
                let help = "those with a meaning here are #pragma continue, family, profile and tick".to_owned();
                self.problems.push(diagnostic(
                    self.lines,
                    self.text,
                    Severity::Warning,
                    given,
                    "this pragma is ignored".into(),
                    Some(help),
                ));
                return;
            }
        };
        self.out.push(Token { kind: Kind::Continue, text: text.into(), span: (self.given)(whole) });
    }

    /// `#pragma family gus`: said once, or again with the same value.
    fn option(&mut self, name: &str, whole: &Range<usize>, rest: &[(Raw, Range<usize>)]) {
        let (Some(name), Some((_, first))) = (OPTIONS.into_iter().find(|known| *known == name), rest.first()) else {
            return self.refuse(whole, format!("#pragma {name} needs a value"), "write it after the name");
        };
        let value = self.flat[first.start..whole.end].trim().to_owned();
        let span = (self.given)(whole);
        let (line, column) = self.lines.place(self.text, span.start);
        match self.pragmas.iter().find(|known| known.name == name) {
            None => self.pragmas.push(Pragma { name, value, line, column, span }),
            Some(known) if known.value == value => {}
            Some(known) => {
                let message = format!("#pragma {name} is `{value}` here and `{}` in line {}", known.value, known.line);
                self.refuse(whole, message, "leave one of them out");
            }
        }
    }

    fn refuse(&mut self, whole: &Range<usize>, message: String, help: &str) {
        let given = (self.given)(whole);
        if self.problems.len() < 2 * PROBLEMS_SHOWN {
            let help = Some(help.to_owned());
            self.problems.push(diagnostic(self.lines, self.text, Severity::Error, given, message, help));
        }
    }
}
