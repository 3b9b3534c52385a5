//! Declarations and assignments.
//!
//! In: the reader at a type or a variable. Out: variables with their values.

use crate::expr::{MATHEMATICS, misspelt};
use crate::read::{C_LIBRARY, Fault, Reader};
use crate::scan::Kind;
use crate::value::{Type, Value, Variable};
use std::ops::Range;

/// Values that all arrays of a script hold together, at most: a short line can ask for many.
const ARRAYS_MAX_ELEMENTS: usize = 4_000_000;

impl Reader<'_> {
    pub(crate) fn declare(&mut self, of: Type, start: usize) -> Result<(), Fault> {
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
                    length = Some(self.array_length(of)?);
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
                return Err(Fault::new(
                    name.span,
                    "this array has neither a length nor values",
                    "write its length between [ ]",
                ));
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

    pub(crate) fn array_length(&mut self, of: Type) -> Result<usize, Fault> {
        let start = self.here();
        let value = self.expression()?;
        let span = start.start..self.before().end;
        let Value::Int(length @ 1..=1_000_000) = value else {
            return Err(Fault::new(span, "an array's length is an integer from 1 to 1000000", ""));
        };
        let length = length as usize;
        self.in_arrays = self.in_arrays.saturating_add(length.saturating_mul(Variable::width(of)));
        if self.in_arrays > ARRAYS_MAX_ELEMENTS {
            let message =
                format!("the arrays of this script are too long: they hold {ARRAYS_MAX_ELEMENTS} values together");
            return Err(Fault::new(span, message, C_LIBRARY));
        }
        Ok(length)
    }

    /// Reads `x`, `x[i]`, `x.f`, `x[i].f[j]`: variable, cell and type.
    pub(crate) fn place_of_value(&mut self) -> Result<(String, usize, Type), Fault> {
        let name = self.advance();
        if !self.variables.contains_key(&name.text) {
            let near = misspelt(&name.text, self.variables.keys().map(String::as_str));
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

    pub(crate) fn assignment(&mut self) -> Result<(), Fault> {
        let start = self.at;
        if self.peek_after(1).kind == Kind::Name {
            return Err(self.fault_here(
                format!("`{}` is neither a type nor a call", self.peek().text),
                "types are short, long, int, double, float, TTrapPrm, TJogPrm, TCrdPrm, TCrdData",
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
    pub(crate) fn one_assignment(&mut self, start: usize) -> Result<Value, Fault> {
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
                    (Value::Unset, _) => {
                        return Err(Fault::new(target, format!("`{name}` has no value yet"), "assign one first"));
                    }
                    (Value::Later { .. }, _) | (_, Value::Later { .. }) => right.clone(),
                    _ => crate::expr::compute(operator, &left, &right)
                        .map_err(|message| Fault::new(whole.clone(), message, ""))?,
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

    pub(crate) fn step_by(
        &mut self,
        name: &str,
        cell: usize,
        of: Type,
        by: i64,
        span: Range<usize>,
    ) -> Result<(), Fault> {
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

    /// Reads the right side of `=`: a call, another assignment, or an expression; as a value of
    /// type `of`.
    pub(crate) fn assigned(&mut self, of: Type, start: usize) -> Result<Value, Fault> {
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

    /// Whether the next tokens are a call that is not one of `math.h`.
    pub(crate) fn calls(&self) -> bool {
        let name = self.peek();
        name.kind == Kind::Name && self.peek_after(1).text == "(" && !MATHEMATICS.contains(&name.text.as_str())
    }
}
