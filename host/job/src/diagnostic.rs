//! What is wrong with a script and where, and how it is shown.

use ariadne::{Color, Config, IndexType, Label, Report, ReportKind, Source};
use std::ops::Range;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// The job does not run.
    Error,
    /// The job runs; the reader should know.
    Warning,
}

/// One message about a script.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// Bytes of the script that it points to.
    pub span: Range<usize>,
    /// What is wrong, and what was expected.
    pub message: String,
    /// What to do about it, if that can be said.
    pub help: Option<String>,
}

/// Characters of its input that a message quotes, at most (SPEC 10).
pub const QUOTED_CHARACTERS: usize = 80;
/// Characters of a whole message, at most.
const MESSAGE_CHARACTERS: usize = 600;

/// At most so many characters; what is cut off is marked.
fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

/// A text in which control characters are shown as escapes.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            // Some turn the direction of the line, which hides as well as a control character does.
            letter if letter.is_control() || matches!(letter, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}') => {
                out.extend(letter.escape_default());
            }
            letter => out.push(letter),
        }
    }
    out
}

/// A part of the input as a message may quote it.
pub fn quoted(text: &str) -> String {
    cut(&escaped(text), QUOTED_CHARACTERS)
}

/// A message as it may be shown: control characters that came with the input are escaped, and no
/// quotation is longer than [`QUOTED_CHARACTERS`].
pub fn tidy(message: &str) -> String {
    let mut out = String::with_capacity(message.len());
    for (number, part) in escaped(message).split('`').enumerate() {
        if number > 0 {
            out.push('`');
        }
        out += &if number % 2 == 1 { cut(part, QUOTED_CHARACTERS) } else { texts_cut(part) };
    }
    cut(&out, MESSAGE_CHARACTERS)
}

/// The same of texts in quotation marks.
fn texts_cut(part: &str) -> String {
    let parts = part.split('"').enumerate();
    let parts: Vec<String> = parts
        .map(|(number, part)| if number % 2 == 1 { cut(part, QUOTED_CHARACTERS) } else { part.to_owned() })
        .collect();
    parts.join("\"")
}

/// Renders `diagnostic` with `file:line:column`, the source line and a mark under the position.
pub fn render(diagnostic: &Diagnostic, file: &str, text: &str, colour: bool) -> String {
    let message = tidy(&diagnostic.message);
    let help = diagnostic.help.as_deref().map(tidy);
    let (begin, end) = (diagnostic.span.start.min(text.len()), diagnostic.span.end.min(text.len()));
    let line_begin = text.get(..begin).and_then(|before| before.rfind('\n')).map_or(0, |at| at + 1);
    let line_end = text.get(end..).and_then(|after| after.find('\n')).map_or(text.len(), |at| end + at);
    let shown = text.get(line_begin..line_end).unwrap_or("");
    let hidden = |letter: char| letter.is_control() && !matches!(letter, '\n' | '\t' | '\r');
    if shown.chars().count() > QUOTED_CHARACTERS || shown.contains(hidden) || escaped(file) != file {
        let place = (escaped(file), begin.saturating_sub(line_begin));
        return excerpt(diagnostic, place, shown, &message, help.as_deref());
    }
    let kind = match diagnostic.severity {
        Severity::Error => ReportKind::Error,
        Severity::Warning => ReportKind::Warning,
    };
    let mark = match diagnostic.severity {
        Severity::Error => Color::Red,
        Severity::Warning => Color::Yellow,
    };
    let place = (file, diagnostic.span.clone());
    let mut report = Report::build(kind, place.clone())
        .with_config(Config::default().with_color(colour).with_index_type(IndexType::Byte))
        .with_message(&message)
        .with_label(Label::new(place).with_color(mark).with_message("here"));
    if let Some(help) = &help {
        report = report.with_help(help);
    }
    let mut out = Vec::new();
    // Writing to a Vec does not fail; a report that could not be drawn still has its text.
    if report.finish().write((file, Source::from(text)), &mut out).is_err() {
        return format!("{file}:{}:{}: {message}\n", diagnostic.line, diagnostic.column);
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// The same of a script that is not in memory: `lines` are those of the position, which begin at
/// this byte of it.
pub fn render_lines(diagnostic: &Diagnostic, file: &str, lines: &str, begin: usize) -> String {
    let help = diagnostic.help.as_deref().map(tidy);
    let place = (escaped(file), diagnostic.span.start.saturating_sub(begin));
    excerpt(diagnostic, place, lines, &tidy(&diagnostic.message), help.as_deref())
}

/// The same where the source cannot be shown as it is: a part of its line, with control characters
/// escaped. `at` is the start of the position in `line`.
fn excerpt(
    diagnostic: &Diagnostic,
    (file, at): (String, usize),
    line: &str,
    message: &str,
    help: Option<&str>,
) -> String {
    /// Characters shown before the position.
    const BEFORE_CHARACTERS: usize = 30;
    let before = escaped(line.get(..at).unwrap_or(""));
    let count = before.chars().count();
    let lead: String = before.chars().skip(count.saturating_sub(BEFORE_CHARACTERS)).collect();
    let lead = if count > BEFORE_CHARACTERS { format!("…{lead}") } else { lead };
    let behind = line.get(at..).unwrap_or("").lines().next().unwrap_or("").trim_end_matches('\r');
    let room = QUOTED_CHARACTERS - lead.chars().count();
    let rest: String = escaped(&behind.chars().take(room).collect::<String>());
    let rest = cut(&rest, room);
    let kind = if diagnostic.severity == Severity::Error { "Error" } else { "Warning" };
    let indent = " ".repeat(lead.chars().count());
    let help = help.map_or(String::new(), |help| format!("   │ Help: {help}\n"));
    format!(
        "{kind}: {message}\n   ╭─[ {file}:{}:{} ]\n   │ {lead}{rest}\n   │ {indent}─ here\n{help}───╯\n",
        diagnostic.line, diagnostic.column
    )
}
