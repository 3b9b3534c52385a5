//! The reader of a script: its tokens, a cursor on them, and the results so far.
//!
//! In: the tokens of [`crate::scan`]. Out: steps, warnings, errors. After an error, reading
//! continues after the statement, so that one run shows all errors. The meaning of statements is in
//! `statement`, `assign`, `wait` and `call`.

use crate::endless::Motions;
use crate::scan::{self, Kind, Lines, Token, diagnostic};
use crate::value::{Value, Variables};
use crate::{Action, Axis, Diagnostic, Files, Pragma, Severity, Step, Used};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// More errors than these are not listed.
const ERRORS_SHOWN: usize = 20;
/// Parentheses and signs may nest this deep.
const MAX_NESTING_DEPTH: usize = 100;
pub(crate) const C_LIBRARY: &str =
    "a job script runs straight through; for loops and decisions write a program with the C library";

/// Why a statement cannot be read.
#[derive(Debug)]
pub(crate) struct Fault {
    pub span: Range<usize>,
    pub message: String,
    pub help: String,
}

impl Fault {
    pub(crate) fn new(span: Range<usize>, message: impl Into<String>, help: &str) -> Self {
        Fault { span, message: message.into(), help: help.to_owned() }
    }
}

/// The state of reading.
pub(crate) struct Reader<'a> {
    pub(crate) text: &'a str,
    pub(crate) files: &'a dyn Files,
    pub(crate) lines: Lines,
    pub(crate) tokens: Vec<Token>,
    pub(crate) pragmas: Vec<Pragma>,
    pub(crate) at: usize,
    nesting: usize,
    pub(crate) variables: Variables,
    /// Values for which declarations of arrays have asked.
    pub(crate) in_arrays: usize,
    pub(crate) steps: Vec<Step>,
    pub(crate) warnings: Vec<Diagnostic>,
    pub(crate) errors: Vec<Diagnostic>,
    pub(crate) braces: Vec<Range<usize>>,
    /// After `return`: nothing is executed any more.
    pub(crate) ended: bool,
    /// In the body of `while(!kbhit())`.
    pub(crate) polling: bool,
    pub(crate) keep_going: bool,
    pub(crate) used: Used,
    /// Cores (as axis 0) and axes that any call names.
    pub(crate) named: BTreeMap<Axis, u32>,
    pub(crate) motions: Motions,
    /// Jog and Trap parameters as far as the script has set them, by core, axis and kind.
    pub(crate) parameters: BTreeMap<(i16, i16, &'static str), Vec<Value>>,
    /// A Reset was called: parameters that were not set since have their power-on values.
    pub(crate) reset: BTreeSet<i16>,
    /// Entries since the last motion of a path, by core, coordinate system and FIFO.
    pub(crate) between: BTreeMap<(i16, i16, i64), u32>,
    /// Parameters whose fraction was left out, and said so: function and name.
    pub(crate) shortened: BTreeSet<(String, String)>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(text: &'a str, files: &'a dyn Files) -> Self {
        let scan::Scanned { tokens, pragmas, problems } = scan::scan(text);
        let (errors, warnings) = problems.into_iter().partition(|found| found.severity == Severity::Error);
        Reader {
            text,
            files,
            lines: Lines::of(text),
            tokens,
            pragmas,
            at: 0,
            nesting: 0,
            variables: Variables::new(),
            in_arrays: 0,
            steps: Vec::new(),
            warnings,
            errors,
            braces: Vec::new(),
            ended: false,
            polling: false,
            keep_going: false,
            used: Used::default(),
            named: BTreeMap::new(),
            motions: Motions::default(),
            parameters: BTreeMap::new(),
            reset: BTreeSet::new(),
            between: BTreeMap::new(),
            shortened: BTreeSet::new(),
        }
    }

    /// Reads everything.
    pub(crate) fn run(&mut self) {
        while self.peek().kind != Kind::End && self.errors.len() < ERRORS_SHOWN {
            let before = self.at;
            if let Err(fault) = self.statement() {
                let help = (!fault.help.is_empty()).then_some(fault.help);
                self.errors.push(diagnostic(&self.lines, self.text, Severity::Error, fault.span, fault.message, help));
                self.recover();
            }
            if self.at == before {
                self.advance();
            }
        }
        if let Some(open) = self.braces.first().cloned() {
            let help = Some("the script seems to be cut off; close it with }".to_owned());
            self.errors.push(diagnostic(
                &self.lines,
                self.text,
                Severity::Error,
                open,
                "this { is not closed".into(),
                help,
            ));
        }
        self.errors.sort_by_key(|found| found.span.start);
    }

    // -- the cursor
    // --------------------------------------------------------------------------------

    pub(crate) fn peek(&self) -> &Token {
        self.peek_after(0)
    }

    pub(crate) fn peek_after(&self, ahead: usize) -> &Token {
        &self.tokens[(self.at + ahead).min(self.tokens.len() - 1)]
    }

    pub(crate) fn at(&self) -> usize {
        self.at
    }

    pub(crate) fn rewind(&mut self, at: usize) {
        self.at = at;
    }

    pub(crate) fn advance(&mut self) -> Token {
        let token = self.peek().clone();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    pub(crate) fn here(&self) -> Range<usize> {
        self.peek().span.clone()
    }

    /// Position of the token before this one.
    pub(crate) fn before(&self) -> Range<usize> {
        self.tokens[self.at.saturating_sub(1)].span.clone()
    }

    pub(crate) fn is(&self, mark: &str) -> bool {
        self.peek().kind == Kind::Mark && self.peek().text == mark
    }

    pub(crate) fn accept(&mut self, mark: &str) -> bool {
        let found = self.is(mark);
        if found {
            self.advance();
        }
        found
    }

    /// The token here, as an error message names it.
    pub(crate) fn shown(&self) -> String {
        match self.peek().kind {
            Kind::End => "the end of the script".into(),
            Kind::Text => format!("the text \"{}\"", self.peek().text),
            _ => format!("`{}`", self.peek().text),
        }
    }

    pub(crate) fn fault_here(&self, message: impl Into<String>, help: &str) -> Fault {
        Fault::new(self.here(), message, help)
    }

    pub(crate) fn expect(&mut self, mark: &str, what_for: &str) -> Result<(), Fault> {
        if self.accept(mark) {
            return Ok(());
        }
        let help = if mark == ";" { "every statement ends with ;" } else { "" };
        // A missing mark belongs after the token before, which may be lines above.
        let end = self.before().end;
        let place = if mark == ";" && self.peek().kind != Kind::End { end.saturating_sub(1)..end } else { self.here() };
        Err(Fault::new(place, format!("`{mark}` is missing {what_for}; here is {}", self.shown()), help))
    }

    /// Runs `inner` one level deeper, if that is not too deep.
    pub(crate) fn nested<T>(&mut self, inner: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        if self.nesting >= MAX_NESTING_DEPTH {
            return Err(self.fault_here("this expression is nested too deeply", "split it"));
        }
        self.nesting += 1;
        let result = inner(self);
        self.nesting -= 1;
        result
    }

    pub(crate) fn warn(&mut self, span: Range<usize>, message: String, help: &str) {
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.warnings.push(diagnostic(&self.lines, self.text, Severity::Warning, span, message, help));
    }

    /// After an error: on to the end of the statement.
    pub(crate) fn recover(&mut self) {
        while self.peek().kind != Kind::End && !self.is("{") && !self.is("}") {
            if self.accept(";") {
                return;
            }
            self.advance();
        }
    }

    /// Skips ( … ) or { … } whole, if it comes next.
    pub(crate) fn skip_group(&mut self, open: &str, close: &str) {
        let mut depth = 0usize;
        while self.peek().kind != Kind::End {
            if self.is(open) {
                depth += 1;
            } else if self.is(close) {
                depth -= 1;
            }
            if depth == 0 {
                if self.is(close) {
                    self.advance();
                }
                return;
            }
            self.advance();
        }
    }

    /// Skips one statement or block.
    pub(crate) fn skip_statement(&mut self) {
        if self.is("{") {
            self.skip_group("{", "}");
        } else {
            self.recover();
        }
    }

    // -- steps
    // -------------------------------------------------------------------------------------

    /// Appends a step whose statement began at token `start`.
    pub(crate) fn push(&mut self, start: usize, action: Action) {
        if self.polling || self.ended {
            return;
        }
        let span = self.tokens[start].span.start..self.before().end;
        let (line, column) = self.lines.place(self.text, span.start);
        self.steps.push(Step { line, column, span, action });
    }

    /// Line of a token.
    pub(crate) fn line(&self, span: &Range<usize>) -> u32 {
        self.lines.place(self.text, span.start).0
    }

    /// A statement with an effect after `return`: reported once.
    pub(crate) fn executes(&mut self) {
        if self.ended && !self.warnings.iter().any(|warning| warning.message.starts_with("after `return`")) {
            self.warn(
                self.here(),
                "after `return` nothing is executed".into(),
                "remove the return, or what follows it",
            );
        }
    }

    /// The `;` belongs to the step that was pushed for this statement.
    pub(crate) fn finish(&mut self, start: usize) {
        let span = self.tokens[start].span.start..self.before().end;
        let (line, column) = self.lines.place(self.text, span.start);
        if let Some(step) = self.steps.last_mut().filter(|step| (step.line, step.column) == (line, column)) {
            step.span = span;
        }
    }
}
