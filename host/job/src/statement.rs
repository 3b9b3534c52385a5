//! Statements: which kind each is, and what is refused.
//!
//! In: the reader at the beginning of a statement. Out: what it does, by `assign`, `wait` and
//! `call`.

use crate::Severity;
use crate::api;
use crate::read::{C_LIBRARY, Fault, Reader};
use crate::scan::{Kind, Token, diagnostic};

impl Reader<'_> {
    pub(crate) fn statement(&mut self) -> Result<(), Fault> {
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
                    self.warn(
                        token.span,
                        "this } closes nothing; it is ignored".into(),
                        "printed listings have such braces at page breaks",
                    );
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

    pub(crate) fn word(&mut self, token: &Token, word: &str) -> Result<(), Fault> {
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
                // Reading continues here: the error must not skip another statement.
                let fault = diagnostic(
                    &self.lines,
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
                "types are short, long, int, double, float, TTrapPrm, TJogPrm, TCrdPrm, TCrdData",
            )),
            _ => {
                let start = self.at;
                if let Some(of) = self.type_words() {
                    return if self.peek_after(1).text == "(" {
                        self.function_of_script()
                    } else {
                        self.declare(of, start)
                    };
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

    /// `main`: its body is the script. Helpers that only print are skipped; others are refused.
    pub(crate) fn function_of_script(&mut self) -> Result<(), Fault> {
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
            &self.lines,
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
}
