//! The values that a declaration gives: one, a text, or a list in braces, which may hold lists.
//!
//! In: the reader after the `=`. Out: the variable. A list fills its target as in C (C11, 6.7.9): a
//! list within it fills one field or element, and values without braces fill its parts one by one.
//! Parts without a value are 0. Fails where a list has more values than its target has parts.

use crate::read::{Fault, Reader};
use crate::scan::{Kind, Token};
use crate::value::{Type, Value, Variable};
use std::ops::Range;

/// A value or a list, as in the text.
enum Initial {
    One(Value, Range<usize>),
    List(Vec<Initial>, Range<usize>),
}

impl Initial {
    fn count(&self) -> usize {
        match self {
            Initial::One(..) => 1,
            Initial::List(items, _) => items.iter().map(Initial::count).sum(),
        }
    }
}

/// What a list may fill.
#[derive(Clone, Copy)]
enum Part {
    /// A number.
    One(Type),
    /// So many numbers.
    Many(Type, usize),
    /// A struct, or a number where the type is one.
    Element(Type),
    /// So many of them.
    Array(Type, usize),
}

impl Part {
    fn cells(self) -> usize {
        match self {
            Part::One(_) => 1,
            Part::Many(_, count) => count,
            Part::Element(of) => Variable::width(of),
            Part::Array(of, count) => count * Variable::width(of),
        }
    }

    /// What it consists of; nothing, where it is a number.
    fn parts(self) -> Box<dyn Iterator<Item = Part>> {
        match self {
            Part::One(_) => Box::new(std::iter::empty()),
            Part::Many(of, count) => Box::new(std::iter::repeat_n(Part::One(of), count)),
            Part::Element(of) if !of.is_struct() => Box::new(std::iter::empty()),
            Part::Element(of) => Box::new(of.fields().iter().map(|&(_, of, count)| match count {
                1 => Part::One(of),
                _ => Part::Many(of, count),
            })),
            Part::Array(of, count) => Box::new(std::iter::repeat_n(Part::Element(of), count)),
        }
    }

    /// The type, where it is a number.
    fn number(self) -> Option<Type> {
        match self {
            Part::One(of) => Some(of),
            Part::Element(of) if !of.is_struct() => Some(of),
            _ => None,
        }
    }
}

/// What is left of a list, and what it has filled.
struct Filling<'i> {
    items: std::iter::Peekable<std::slice::Iter<'i, Initial>>,
    cells: Vec<Value>,
}

impl Filling<'_> {
    /// Fills one part from what is left of the list.
    fn fill(&mut self, part: Part) -> Result<(), Fault> {
        let start = self.cells.len();
        match (self.items.peek(), part.number()) {
            (None, _) => {}
            (Some(Initial::List(items, span)), _) => {
                self.cells.extend(filled(part, items, span)?);
                self.items.next();
            }
            (Some(Initial::One(value, span)), Some(of)) => {
                self.cells.push(of.convert(value).map_err(|message| Fault::new(span.clone(), message, ""))?);
                self.items.next();
            }
            (Some(Initial::One(..)), None) => part.parts().try_for_each(|part| self.fill(part))?,
        }
        self.cells.resize(start + part.cells(), Value::Int(0));
        Ok(())
    }
}

/// The cells of the part that this list fills.
fn filled(part: Part, items: &[Initial], span: &Range<usize>) -> Result<Vec<Value>, Fault> {
    let mut filling = Filling { items: items.iter().peekable(), cells: Vec::new() };
    match part.number() {
        // A number may have braces of its own.
        Some(_) => filling.fill(part)?,
        None => part.parts().try_for_each(|part| filling.fill(part))?,
    }
    if filling.items.next().is_some() {
        let given: usize = items.iter().map(Initial::count).sum();
        let message = match part.cells() {
            holds if given > holds => format!("this list has {given} values; it stands for {holds}"),
            holds => format!("this list has one more than the {holds} that it stands for"),
        };
        let help = "a list within a list stands for one field, or for one element of an array";
        return Err(Fault::new(span.clone(), message, help));
    }
    Ok(filling.cells)
}

impl Reader<'_> {
    pub(crate) fn initial(
        &mut self,
        of: Type,
        length: Option<usize>,
        open: bool,
        name: &Token,
        start: usize,
    ) -> Result<Variable, Fault> {
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
        let (items, span) = self.braces()?;
        if open {
            // As many elements as the list fills.
            let mut filling = Filling { items: items.iter().peekable(), cells: Vec::new() };
            while filling.cells.is_empty() || filling.items.peek().is_some() {
                filling.fill(Part::Element(of))?;
            }
            let mut variable = Variable::new(of, Some(filling.cells.len() / Variable::width(of)));
            variable.cells = filling.cells;
            return Ok(variable);
        }
        let mut variable = Variable::new(of, length);
        let given: usize = items.iter().map(Initial::count).sum();
        if given > variable.cells.len() {
            let message = format!("{given} values are given, `{}` holds {}", name.text, variable.cells.len());
            return Err(Fault::new(name.span.clone(), message, ""));
        }
        let part = length.map_or(Part::Element(of), |length| Part::Array(of, length));
        variable.cells = filled(part, &items, &span)?;
        Ok(variable)
    }

    fn braces(&mut self) -> Result<(Vec<Initial>, Range<usize>), Fault> {
        let start = self.here().start;
        self.expect("{", "before the values")?;
        let mut items = Vec::new();
        while !self.accept("}") {
            items.push(if self.is("{") {
                let (items, span) = self.nested(Self::braces)?;
                Initial::List(items, span)
            } else {
                let start = self.here();
                let value = self.expression()?;
                Initial::One(value, start.start..self.before().end)
            });
            if !self.accept(",") {
                self.expect("}", "after the values")?;
                break;
            }
        }
        Ok((items, start..self.before().end))
    }
}
