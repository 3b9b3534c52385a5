//! What moves the script clock: `Sleep`, `WaitStop`, `while(!kbhit())`.
//!
//! In: the reader at such a statement. Out: its step; a wait that would never end is refused.

use crate::read::{C_LIBRARY, Fault, Reader};
use crate::scan::{Kind, Token, diagnostic};
use crate::value::{Type, Value, show};
use crate::{Action, Axis, Severity};
use std::ops::Range;

impl Reader<'_> {
    pub(crate) fn numbers(&mut self, name: &Token) -> Result<(Vec<Value>, Range<usize>), Fault> {
        self.expect("(", "after the function's name")?;
        let mut values = Vec::new();
        while !self.is(")") {
            let value = self.expression()?;
            values.push(value);
            if !self.accept(",") {
                break;
            }
        }
        self.expect(")", "to close the call")?;
        Ok((values, name.span.start..self.before().end))
    }

    pub(crate) fn sleep(&mut self, start: usize, name: &Token) -> Result<(), Fault> {
        let (values, span) = self.numbers(name)?;
        let ns = match values[..] {
            [Value::Int(ms @ 0..=4_294_967_295)] => ms as u64 * 1_000_000,
            [Value::Real(ms)] if (0.0..=4_294_967_295.0).contains(&ms) => (ms * 1e6).round() as u64,
            [_] => return Err(Fault::new(span, "Sleep takes 0 to 4294967295 ms", "")),
            _ => {
                return Err(Fault::new(
                    span,
                    format!("Sleep takes one parameter, {} are given", values.len()),
                    "it is Sleep(ms)",
                ));
            }
        };
        self.push(start, Action::Sleep { ns });
        Ok(())
    }

    pub(crate) fn wait_stop(&mut self, start: usize, name: &Token) -> Result<(), Fault> {
        const FORMS: &str = "it is WaitStop(mask), bits as GT_Stop, or WaitStop(core, axes, crds)";
        let (values, span) = self.numbers(name)?;
        let mut whole = Vec::new();
        for value in &values {
            match Type::Long.convert(value) {
                Ok(Value::Int(number)) => whole.push((number as i32).cast_unsigned()),
                _ => return Err(Fault::new(span, format!("{} does not fit WaitStop", show(value)), FORMS)),
            }
        }
        let (core, axes, crds) = match whole[..] {
            [mask] if mask & !0x3ff == 0 => (1, mask & 0xff, mask >> 8),
            [_] => {
                return Err(Fault::new(
                    span,
                    "bits 0 to 7 are axes 1 to 8, bits 8 and 9 coordinate systems 1 and 2; others mean nothing here",
                    FORMS,
                ));
            }
            [core @ 1..=32767, axes, crds] => (core as i16, axes, crds),
            [_, _, _] => return Err(Fault::new(span, "`core` is an integer from 1", FORMS)),
            _ => {
                return Err(Fault::new(
                    span,
                    format!("WaitStop takes 1 or 3 parameters, {} are given", values.len()),
                    FORMS,
                ));
            }
        };
        if self.polling {
            return Err(Fault::new(span, "WaitStop is not allowed in a while(!kbhit()) loop", "put it after the loop"));
        }
        let line = self.line(&span);
        if let Some((axis, line)) = self.motions.endless(Some((core, axes))) {
            self.warn(
                span,
                format!("axis {} of core {}, started in line {line}, does not stop by itself", axis.axis, axis.core),
                "this waits until a limit or a fault stops it; put a Stop before it if that is not meant",
            );
        }
        self.motions.at_standstill(core, axes);
        self.name_each([Axis { core, axis: 0 }], line);
        self.name_mask(core, axes, line);
        self.push(start, Action::WaitStop { core, axes, crds });
        Ok(())
    }

    /// `while(!kbhit()) { … }` that only reads and prints.
    pub(crate) fn poll(&mut self) -> Result<(), Fault> {
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
                &self.lines,
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
            self.motions.all_at_standstill();
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

    pub(crate) fn poll_body(&mut self) -> Result<(), Fault> {
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

    pub(crate) fn poll_statement(&mut self) -> Result<(), Fault> {
        let word = self.peek().text.clone();
        let assigns_call = self.peek_after(1).text == "=" && self.peek_after(3).text == "(";
        let calls = self.peek_after(1).text == "(" && !matches!(word.as_str(), "if" | "while" | "for" | "switch");
        if self.is(";") || self.is(".") || calls || assigns_call {
            self.statement()
        } else {
            Err(self.fault_here(
                format!("{} is not allowed in a while(!kbhit()) loop of a job script", self.shown()),
                "such a loop may only read and print: it means WaitStop of everything that runs; for more, use the C library",
            ))
        }
    }
}
