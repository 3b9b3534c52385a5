//! Tokens to steps: the statements of a script, read and computed one after the other.
//!
//! In: the tokens of [`crate::scan`]. Out: steps, warnings, errors. After an error reading goes on behind
//! the statement, so that one run shows what else is wrong.

use crate::endless::Motions;
use crate::expr::{MATHEMATICS, nearest};
use crate::scan::{self, Kind, Lines, Token, diagnostic};
use crate::value::{Type, Value, Variable, Variables};
use crate::{Action, Axis, Diagnostic, Files, Severity, Step, api};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// More errors than these are not listed.
const ERRORS_SHOWN: usize = 20;
/// Parentheses and signs may nest this deep.
const NESTING: usize = 100;

const C_LIBRARY: &str = "a job script runs straight through; for loops and decisions write a program with the C library";

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
    lines: Lines,
    tokens: Vec<Token>,
    at: usize,
    nesting: usize,
    pub(crate) variables: Variables,
    pub(crate) steps: Vec<Step>,
    pub(crate) warnings: Vec<Diagnostic>,
    pub(crate) errors: Vec<Diagnostic>,
    braces: Vec<Range<usize>>,
    /// Behind `return`: nothing is executed any more.
    ended: bool,
    /// In the body of `while(!kbhit())`.
    pub(crate) polling: bool,
    pub(crate) keep_going: bool,
    pub(crate) axes: BTreeSet<Axis>,
    pub(crate) motions: Motions,
    /// Jog and Trap parameters as far as the script has set them, by core, axis and kind.
    pub(crate) parameters: BTreeMap<(i16, i16, &'static str), Vec<Value>>,
    /// A Reset was called: parameters that were not set since have their power-on values.
    pub(crate) reset: BTreeSet<i16>,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(text: &'a str, files: &'a dyn Files) -> Self {
        let (tokens, errors) = scan::tokens(text);
        let (errors, warnings) = errors.into_iter().partition(|found| found.severity == Severity::Error);
        Reader {
            text,
            files,
            lines: Lines::of(text),
            tokens,
            at: 0,
            nesting: 0,
            variables: Variables::new(),
            steps: Vec::new(),
            warnings,
            errors,
            braces: Vec::new(),
            ended: false,
            polling: false,
            keep_going: false,
            axes: BTreeSet::new(),
            motions: Motions::default(),
            parameters: BTreeMap::new(),
            reset: BTreeSet::new(),
        }
    }

    /// Reads everything.
    pub(crate) fn run(&mut self) {
        while self.peek().kind != Kind::End && self.errors.len() < ERRORS_SHOWN {
            let before = self.at;
            if let Err(fault) = self.statement() {
                let help = (!fault.help.is_empty()).then_some(fault.help);
                self.errors.push(diagnostic(self.text, Severity::Error, fault.span, fault.message, help));
                self.recover();
            }
            if self.at == before {
                self.advance();
            }
        }
        if let Some(open) = self.braces.first().cloned() {
            let help = Some("the script seems to be cut off; close it with }".to_owned());
            self.errors.push(diagnostic(self.text, Severity::Error, open, "this { is not closed".into(), help));
        }
        self.errors.sort_by_key(|found| found.span.start);
    }

    // -- the cursor --------------------------------------------------------------------------------

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

    /// Where the token before this one stands.
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
        // A missing mark belongs behind the token before, which may be lines above.
        let end = self.before().end;
        let place = if mark == ";" && self.peek().kind != Kind::End { end.saturating_sub(1)..end } else { self.here() };
        Err(Fault::new(place, format!("`{mark}` is missing {what_for}; here is {}", self.shown()), help))
    }

    /// Runs `inner` one level deeper, if that is not too deep.
    pub(crate) fn nested<T>(&mut self, inner: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        if self.nesting >= NESTING {
            return Err(self.fault_here("this expression is nested too deeply", "split it"));
        }
        self.nesting += 1;
        let result = inner(self);
        self.nesting -= 1;
        result
    }

    pub(crate) fn warn(&mut self, span: Range<usize>, message: String, help: &str) {
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.warnings.push(diagnostic(self.text, Severity::Warning, span, message, help));
    }

    /// Behind an error: on to the end of the statement.
    fn recover(&mut self) {
        while self.peek().kind != Kind::End && !self.is("{") && !self.is("}") {
            if self.accept(";") {
                return;
            }
            self.advance();
        }
    }

    /// Skips ( … ) or { … } whole, if it stands here.
    fn skip_group(&mut self, open: &str, close: &str) {
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
    fn skip_statement(&mut self) {
        if self.is("{") {
            self.skip_group("{", "}");
        } else {
            self.recover();
        }
    }

    // -- statements --------------------------------------------------------------------------------

    /// Appends a step whose statement began at token `start`.
    pub(crate) fn push(&mut self, start: usize, action: Action) {
        if self.polling || self.ended {
            return;
        }
        let span = self.tokens[start].span.start..self.before().end;
        let (line, column) = self.lines.place(self.text, span.start);
        let text = self.text.get(span.clone()).unwrap_or("").split_whitespace().collect::<Vec<_>>().join(" ");
        self.steps.push(Step { line, column, span, text, action });
    }

    /// Line of a token.
    pub(crate) fn line(&self, span: &Range<usize>) -> u32 {
        self.lines.place(self.text, span.start).0
    }

    fn statement(&mut self) -> Result<(), Fault> {
        let token = self.peek().clone();
        match (token.kind, token.text.as_str()) {
            (Kind::Continue, text) => {
                self.keep_going = text == "on";
                self.advance();
                Ok(())
            }
            (Kind::Mark, ";" | ".") => {
                self.advance();
                Ok(())
            }
            (Kind::Mark, "{") => {
                let open = self.advance().span;
                self.braces.push(open);
                Ok(())
            }
            (Kind::Mark, "}") => {
                self.advance();
                if self.braces.pop().is_none() {
                    self.warn(token.span, "this } closes nothing; it is ignored".into(), "printed listings have such braces at page breaks");
                }
                Ok(())
            }
            (Kind::Mark, "++" | "--") => {
                self.advance();
                let (name, cell, of) = self.place_of_value()?;
                self.step_by(&name, cell, of, if token.text == "++" { 1 } else { -1 }, token.span)?;
                self.expect(";", "here")
            }
            // (void)GT_X(...);
            (Kind::Mark, "(") if self.peek_after(1).text == "void" && self.peek_after(2).text == ")" => {
                self.at += 3;
                self.nested(Self::statement)
            }
            (Kind::Name, word) => self.word(&token, word),
            _ => Err(self.fault_here(
                format!("a statement cannot begin with {}", self.shown()),
                "a statement is a declaration, an assignment or a call",
            )),
        }
    }

    fn word(&mut self, token: &Token, word: &str) -> Result<(), Fault> {
        match word {
            "while" => self.poll(),
            "if" | "for" | "do" | "switch" | "else" | "elseif" | "goto" | "break" | "continue" | "case" | "default" => {
                self.advance();
                if self.is("(") {
                    self.skip_group("(", ")");
                }
                self.skip_statement();
                // What belongs to it is refused with it.
                while matches!(self.peek().text.as_str(), "else" | "elseif") && self.peek().kind == Kind::Name {
                    self.advance();
                    if self.peek().text == "if" {
                        self.advance();
                    }
                    if self.is("(") {
                        self.skip_group("(", ")");
                    }
                    self.skip_statement();
                }
                // Reading goes on here: the fault must not skip another statement.
                let fault = diagnostic(
                    self.text,
                    Severity::Error,
                    token.span.clone(),
                    format!("`{word}` is not available in job scripts"),
                    Some(C_LIBRARY.into()),
                );
                self.errors.push(fault);
                Ok(())
            }
            "return" => {
                self.recover();
                self.ended = true;
                Ok(())
            }
            "void" => {
                self.advance();
                self.function_of_script()
            }
            "typedef" | "enum" | "union" | "class" | "using" | "extern" => Err(Fault::new(
                token.span.clone(),
                format!("`{word}` is not available in job scripts"),
                "types are short, long, int, double, float, TTrapPrm, TJogPrm, TCrdPrm",
            )),
            _ => {
                let start = self.at;
                if let Some(of) = self.type_words() {
                    return if self.peek_after(1).text == "(" { self.function_of_script() } else { self.declare(of, start) };
                }
                if matches!(word, "main" | "_tmain") {
                    return self.function_of_script();
                }
                if api::SKIPPED.contains(&word) {
                    self.advance();
                    if !self.is("(") {
                        return self.expect("(", "after the name");
                    }
                    self.skip_group("(", ")");
                    return self.expect(";", "after the call");
                }
                match self.peek_after(1).text.as_str() {
                    "(" => {
                        self.call(start, false)?;
                        self.expect(";", "after the call")?;
                        self.finish(start);
                        Ok(())
                    }
                    _ => self.assignment(),
                }
            }
        }
    }

    /// A statement that does something, behind `return`: said once.
    pub(crate) fn executes(&mut self) {
        if self.ended && !self.warnings.iter().any(|warning| warning.message.starts_with("behind `return`")) {
            self.warn(self.here(), "behind `return` nothing is executed".into(), "remove the return, or what follows it");
        }
    }

    /// The `;` belongs to the text of the step that was pushed for this statement.
    fn finish(&mut self, start: usize) {
        let span = self.tokens[start].span.start..self.before().end;
        let (line, column) = self.lines.place(self.text, span.start);
        let text = self.text.get(span.clone()).unwrap_or("").split_whitespace().collect::<Vec<_>>().join(" ");
        if let Some(step) = self.steps.last_mut().filter(|step| (step.line, step.column) == (line, column)) {
            (step.text, step.span) = (text, span);
        }
    }

    /// `main`: its body is the script. Helpers that only print are skipped; others are refused.
    fn function_of_script(&mut self) -> Result<(), Fault> {
        let name = self.advance();
        self.skip_group("(", ")");
        if matches!(name.text.as_str(), "main" | "_tmain") {
            return Ok(());
        }
        if self.accept(";") {
            return Ok(());
        }
        if api::SKIPPED.contains(&name.text.as_str()) {
            self.skip_statement();
            return Ok(());
        }
        let fault = diagnostic(
            self.text,
            Severity::Error,
            name.span,
            format!("`{}` is a function of its own; job scripts have only main", name.text),
            Some(C_LIBRARY.into()),
        );
        self.skip_statement();
        self.errors.push(fault);
        Ok(())
    }

    /// `while(!kbhit()) { … }` that only reads and prints.
    fn poll(&mut self) -> Result<(), Fault> {
        let start = self.at;
        let token = self.advance();
        let mut condition = String::new();
        let open = self.at;
        self.skip_group("(", ")");
        let mut misread = None;
        for token in &self.tokens[open..self.at] {
            condition.push_str(&token.text);
            if token.text == "kbit" {
                misread = Some(token.span.clone());
            }
        }
        let waits = ["(!KEY())", "(KEY()==0)", "(0==KEY())"]
            .iter()
            .any(|form| ["kbhit", "_kbhit", "kbit"].iter().any(|key| form.replace("KEY", key) == condition));
        if !waits {
            self.skip_statement();
            self.errors.push(diagnostic(
                self.text,
                Severity::Error,
                token.span,
                format!("`while{condition}` is not available in job scripts; only while(!kbhit()) is"),
                Some(C_LIBRARY.into()),
            ));
            return Ok(());
        }
        if let Some(span) = misread {
            self.warn(span, "`kbit` is taken as `kbhit`".into(), "");
        }
        self.executes();
        self.polling = true;
        let body = self.poll_body();
        self.polling = false;
        body?;
        if let Some((axis, line)) = self.motions.endless(None).filter(|_| !self.ended) {
            return Err(Fault::new(
                token.span,
                format!(
                    "this loop waits until nothing runs, but axis {} of core {}, started in line {line}, runs for ever",
                    axis.axis, axis.core
                ),
                "put Sleep(ms) and a Stop before it, or give the motion an end (SetPtLoop with a count)",
            ));
        }
        let ended = self.ended;
        if !ended {
            self.motions.all_at_rest();
        }
        let body_end = self.at;
        self.push(start, Action::WaitAll);
        // Its text is the head: the body is what it replaces.
        self.at = open;
        self.skip_group("(", ")");
        self.finish(start);
        self.at = body_end;
        Ok(())
    }

    fn poll_body(&mut self) -> Result<(), Fault> {
        if self.accept(";") {
            return Ok(());
        }
        if !self.accept("{") {
            return self.poll_statement();
        }
        while !self.accept("}") {
            if self.peek().kind == Kind::End {
                return Err(self.fault_here("the loop's } is missing", "the script seems to be cut off"));
            }
            self.poll_statement()?;
        }
        Ok(())
    }

    fn poll_statement(&mut self) -> Result<(), Fault> {
        let word = self.peek().text.clone();
        let assigns_call = self.peek_after(1).text == "=" && self.peek_after(3).text == "(";
        let calls = self.peek_after(1).text == "(" && !matches!(word.as_str(), "if" | "while" | "for" | "switch");
        if self.is(";") || self.is(".") || calls || assigns_call {
            self.statement()
        } else {
            Err(self.fault_here(
                format!("{} cannot stand in a while(!kbhit()) loop of a job script", self.shown()),
                "such a loop may only read and print: it means WaitStop of everything that runs; for more, use the C library",
            ))
        }
    }

    fn declare(&mut self, of: Type, start: usize) -> Result<(), Fault> {
        loop {
            while self.accept("*") {}
            let name = self.peek().clone();
            if name.kind != Kind::Name {
                return Err(self.fault_here(format!("a name is expected here, not {}", self.shown()), ""));
            }
            self.advance();
            let mut length = None;
            let mut open = false;
            if self.accept("[") {
                if self.accept("]") {
                    open = true;
                } else {
                    length = Some(self.array_length()?);
                    self.expect("]", "after the array's length")?;
                }
                if self.is("[") {
                    return Err(self.fault_here("arrays of arrays are not available in job scripts", C_LIBRARY));
                }
            }
            if self.accept("=") {
                let variable = self.initial(of, length, open, &name, start)?;
                self.variables.insert(name.text, variable);
            } else if open {
                return Err(Fault::new(name.span, "this array has neither a length nor values", "write its length between [ ]"));
            } else {
                self.variables.insert(name.text, Variable::new(of, length));
            }
            if !self.accept(",") {
                break;
            }
        }
        self.expect(";", "after the declaration")?;
        self.finish(start);
        Ok(())
    }

    fn array_length(&mut self) -> Result<usize, Fault> {
        let start = self.here();
        let value = self.expression()?;
        let span = start.start..self.before().end;
        match value {
            Value::Int(length @ 1..=1_000_000) => Ok(length as usize),
            _ => Err(Fault::new(span, "an array's length is an integer from 1 to 1000000", "")),
        }
    }

    fn initial(&mut self, of: Type, length: Option<usize>, open: bool, name: &Token, start: usize) -> Result<Variable, Fault> {
        if self.peek().kind == Kind::Text {
            let text = self.advance().text;
            let mut variable = Variable::new(of, length.or(open.then_some(text.len() + 1)));
            variable.text = Some(text);
            return Ok(variable);
        }
        if !self.is("{") {
            let mut variable = Variable::new(of, length);
            let (cell, of) = variable.cell(None, None).map_err(|message| Fault::new(name.span.clone(), message, ""))?;
            variable.cells[cell] = self.assigned(of, start)?;
            return Ok(variable);
        }
        let mut values = Vec::new();
        self.values(&mut values)?;
        let width = Variable::width(of);
        let length = if open { Some(values.len().div_ceil(width).max(1)) } else { length };
        let mut variable = Variable::new(of, length);
        if values.len() > variable.cells.len() {
            let message = format!("{} values are given, `{}` holds {}", values.len(), name.text, variable.cells.len());
            return Err(Fault::new(name.span.clone(), message, ""));
        }
        let types: Vec<Type> =
            of.fields().iter().flat_map(|field| std::iter::repeat_n(field.1, field.2)).collect();
        for (cell, of) in types.iter().cycle().take(variable.cells.len()).enumerate() {
            // As in C, what a list leaves out is 0.
            let (value, span) = values.get(cell).cloned().unwrap_or((Value::Int(0), name.span.clone()));
            variable.cells[cell] = of.convert(&value).map_err(|message| Fault::new(span, message, ""))?;
        }
        Ok(variable)
    }

    fn values(&mut self, values: &mut Vec<(Value, Range<usize>)>) -> Result<(), Fault> {
        self.expect("{", "before the values")?;
        while !self.accept("}") {
            if self.is("{") {
                self.nested(|reader| reader.values(values))?;
            } else {
                let start = self.here();
                let value = self.expression()?;
                values.push((value, start.start..self.before().end));
            }
            if !self.accept(",") {
                self.expect("}", "after the values")?;
                break;
            }
        }
        Ok(())
    }

    /// Reads `x`, `x[i]`, `x.f`, `x[i].f[j]`: variable, cell and type.
    pub(crate) fn place_of_value(&mut self) -> Result<(String, usize, Type), Fault> {
        let name = self.advance();
        if !self.variables.contains_key(&name.text) {
            let near = nearest(&name.text, self.variables.keys().map(String::as_str));
            let help = match near[..] {
                [] => format!("declare it first, as in `double {};`", name.text),
                _ => format!("did you mean {}?", near.join(" or ")),
            };
            return Err(Fault::new(name.span, format!("`{}` is not declared", name.text), &help));
        }
        let index = self.index()?;
        let mut field = None;
        if self.accept(".") {
            let token = self.advance();
            let inner = self.index()?;
            field = Some((token.text, inner));
        }
        let span = name.span.start..self.before().end;
        let (cell, of) = self.variables[&name.text]
            .cell(index, field.as_ref().map(|(name, inner)| (name.as_str(), *inner)))
            .map_err(|message| Fault::new(span, message, ""))?;
        Ok((name.text, cell, of))
    }

    pub(crate) fn index(&mut self) -> Result<Option<i64>, Fault> {
        if !self.accept("[") {
            return Ok(None);
        }
        let start = self.here();
        let value = self.expression()?;
        let span = start.start..self.before().end;
        self.expect("]", "after the index")?;
        match value {
            Value::Int(index) => Ok(Some(index)),
            _ => Err(Fault::new(span, "an index is an integer", "")),
        }
    }

    fn assignment(&mut self) -> Result<(), Fault> {
        let start = self.at;
        if self.peek_after(1).kind == Kind::Name {
            return Err(self.fault_here(
                format!("`{}` is neither a type nor a call", self.peek().text),
                "types are short, long, int, double, float, TTrapPrm, TJogPrm, TCrdPrm",
            ));
        }
        // The target of a call's result may be missing from a listing that was cut off.
        let result_of_call = matches!(self.peek_after(1).text.as_str(), "=" | "+=" | "|=")
            && self.peek_after(2).kind == Kind::Name
            && self.peek_after(3).text == "(";
        let is_api = self.peek_after(2).text.starts_with("GT");
        if result_of_call && is_api && !self.variables.contains_key(&self.peek().text) {
            let name = self.peek().text.clone();
            self.variables.insert(name, Variable::new(Type::Short, None));
        }
        self.one_assignment(start)?;
        self.expect(";", "after the assignment")?;
        self.finish(start);
        Ok(())
    }

    /// An assignment without its `;`, and the value it leaves.
    fn one_assignment(&mut self, start: usize) -> Result<Value, Fault> {
        let target = self.here();
        let (name, cell, of) = self.place_of_value()?;
        let operator = self.advance();
        let span = target.start..self.before().end;
        let value = match operator.text.as_str() {
            "=" => self.assigned(of, start)?,
            "++" | "--" => {
                let by = if operator.text == "++" { 1 } else { -1 };
                self.step_by(&name, cell, of, by, span)?;
                return Ok(self.variables[&name].cells[cell].clone());
            }
            "+=" | "-=" | "*=" | "/=" | "%=" | "|=" | "&=" | "^=" | "<<=" | ">>=" => {
                let right = if self.calls() { self.call(start, true)? } else { self.expression()? };
                let whole = target.start..self.before().end;
                let left = self.variables[&name].cells[cell].clone();
                let operator = operator.text.trim_end_matches('=');
                let left = match (&left, &right) {
                    (Value::Unset, _) => return Err(Fault::new(target, format!("`{name}` has no value yet"), "assign one first")),
                    (Value::Later { .. }, _) | (_, Value::Later { .. }) => right.clone(),
                    _ => crate::expr::compute(operator, &left, &right).map_err(|message| Fault::new(whole.clone(), message, ""))?,
                };
                of.convert(&left).map_err(|message| Fault::new(whole, message, ""))?
            }
            _ => {
                return Err(Fault::new(
                    operator.span,
                    format!("`=` or `(` is expected after `{name}`, not `{}`", operator.text),
                    "a statement is a declaration, an assignment or a call",
                ));
            }
        };
        if let Some(variable) = self.variables.get_mut(&name) {
            variable.cells[cell] = value.clone();
        }
        Ok(value)
    }

    fn step_by(&mut self, name: &str, cell: usize, of: Type, by: i64, span: Range<usize>) -> Result<(), Fault> {
        let now = self.variables[name].cells[cell].clone();
        let sum = match now {
            Value::Int(number) => Value::Int(number.saturating_add(by)),
            Value::Real(number) => Value::Real(number + by as f64),
            _ => return Err(Fault::new(span, format!("`{name}` has no value that is known here"), "assign one first")),
        };
        let sum = of.convert(&sum).map_err(|message| Fault::new(span, message, ""))?;
        if let Some(variable) = self.variables.get_mut(name) {
            variable.cells[cell] = sum;
        }
        Ok(())
    }

    /// What stands right of `=`: a call, another assignment, or an expression; as a value of type `of`.
    fn assigned(&mut self, of: Type, start: usize) -> Result<Value, Fault> {
        let first = self.here();
        if self.calls() {
            return self.call(start, true);
        }
        let value = match (self.peek().kind, self.peek_after(1).text.as_str()) {
            (Kind::Name, "=") => self.nested(|reader| reader.one_assignment(start))?,
            _ => self.expression()?,
        };
        let span = first.start..self.before().end;
        of.convert(&value).map_err(|message| Fault::new(span, message, ""))
    }

    /// A call stands here that is not one of `math.h`.
    fn calls(&self) -> bool {
        let name = self.peek();
        name.kind == Kind::Name && self.peek_after(1).text == "(" && !MATHEMATICS.contains(&name.text.as_str())
    }
}
