//! Parameters of a call, read and checked against the table of [`api`](crate::api).
//!
//! In: the tokens between the parentheses. Out: values, lists, variables to fill. Owns nothing.
//! Fails with diagnostics.

use crate::Out;
use crate::api::{Function, Param, Pass, Shape, Size};
use crate::read::{Fault, Reader};
use crate::scan::{Kind, Token};
use crate::value::{Type, Value, Variable, show};
use std::ops::Range;

/// One thing between the parentheses.
pub(crate) struct Given {
    pub(crate) span: Range<usize>,
    pub(crate) what: What,
}

pub(crate) enum What {
    /// A value.
    Value(Value),
    /// The address of a variable's element; `None` where the script does not declare it.
    Address { text: String, name: String, element: Option<usize> },
    /// A text.
    Text(String),
}

/// What the parameters of a call have become.
#[derive(Default)]
pub(crate) struct Bound {
    /// Values that go in, in order, by name.
    pub(crate) values: Vec<(&'static str, Value)>,
    /// Elements of arrays that go in.
    pub(crate) lists: Vec<Vec<Value>>,
    pub(crate) outs: Vec<Out>,
    /// Variables to fill: name, first cell, and the span that names them.
    pub(crate) fills: Vec<(String, usize, Range<usize>)>,
    pub(crate) text: Option<(String, Range<usize>)>,
    /// The parameter for which the request says whether it was given.
    pub(crate) is_given: bool,
}

impl Bound {
    /// Values of an array; those of an array `count` are among the values before it.
    fn length(&self, size: Size, count: usize) -> usize {
        let nth = |nth| match self.values.iter().filter(|(name, _)| *name == "count").nth(nth) {
            // What no controller takes is refused there, with its limits.
            Some((_, Value::Int(count))) => usize::try_from(*count).unwrap_or(0),
            _ => 0,
        };
        match size {
            Size::Count => count,
            Size::Each(times) => count.saturating_mul(times),
            Size::Columns => nth(0),
            Size::Rows => nth(1),
            Size::Grid => nth(0).saturating_mul(nth(1)),
        }
    }
}

const SHORT: Param = Param { name: "core", pass: Pass::In(Type::Short), default: None };

/// Whether a fraction is lost that was meant: what a sum of decimals leaves is none, unless the
/// whole number beside it is taken.
fn is_lost(real: f64, whole: f64) -> bool {
    let nearest = real.round();
    real != whole && (nearest != whole || (real - nearest).abs() > 1e-6)
}

impl Reader<'_> {
    pub(crate) fn given(&mut self, function: &Function, several_cores: bool) -> Result<Vec<Given>, Fault> {
        self.expect("(", "after the function's name")?;
        let mut given = Vec::new();
        if self.accept(")") {
            return Ok(given);
        }
        loop {
            let index = given.len().checked_sub(usize::from(several_cores));
            let pass = index.and_then(|index| function.params.get(index)).map_or(SHORT.pass, |param| param.pass);
            let start = self.here();
            let what = self.one_given(pass)?;
            given.push(Given { span: start.start..self.before().end, what });
            if !self.accept(",") {
                self.expect(")", "to close the call")?;
                return Ok(given);
            }
        }
    }

    pub(crate) fn one_given(&mut self, pass: Pass) -> Result<What, Fault> {
        if self.peek().kind == Kind::Text {
            return Ok(What::Text(self.advance().text));
        }
        let addressed = self.accept("&");
        let alone = matches!(self.peek_after(1).text.as_str(), "," | ")") && self.peek().kind == Kind::Name;
        let name = self.peek().text.clone();
        let variable = self.variables.get(&name);
        if let (Pass::Text, Some(text)) = (pass, variable.and_then(|variable| variable.text.clone())) {
            self.advance();
            return Ok(What::Text(text));
        }
        let array = alone && variable.is_some_and(|variable| variable.length.is_some() || variable.of == Type::Char);
        let filled = matches!(pass, Pass::Out | Pass::Working);
        let undeclared = alone && variable.is_none() && filled && name != "NULL";
        if !(addressed || array || undeclared) {
            return self.expression().map(What::Value);
        }
        if self.peek().kind != Kind::Name {
            return Err(self.fault_here(format!("a variable is expected after &, not {}", self.shown()), ""));
        }
        let start = self.here();
        self.advance();
        let index = self.index()?;
        if self.is(".") {
            return Err(
                self.fault_here("the address of one field cannot be given to a call here", "use a variable of its own")
            );
        }
        let span = start.start..self.before().end;
        let text = self.text.get(span.clone()).unwrap_or(&name).to_owned();
        let element = match self.variables.get(&name) {
            // A listing that was cut off may lack the declaration of what a call fills.
            None if filled => None,
            None => return Err(Fault::new(span, format!("`{name}` is not declared"), "declare and fill it first")),
            Some(variable) => {
                let limit = variable.length.unwrap_or(1);
                let index = index.unwrap_or(0);
                let inside = usize::try_from(index).ok().filter(|index| *index < limit);
                Some(inside.ok_or_else(|| {
                    Fault::new(span, format!("index {index} is outside `{name}`, which has {limit} elements"), "")
                })?)
            }
        };
        Ok(What::Address { text, name, element })
    }

    /// Checks the number of parameters and gives the core.
    pub(crate) fn bind_count(
        &mut self,
        function: &Function,
        several_cores: bool,
        given: &[Given],
        name: &Token,
        span: Range<usize>,
    ) -> Result<i16, Fault> {
        // Opening and closing concern the whole controller: there the core is left out in both
        // forms.
        let whole = function.shape == Shape::Host;
        let skip = usize::from(several_cores && !whole);
        let needed = function.params.iter().filter(|param| param.default.is_none()).count() + skip;
        let most = function.params.len() + skip;
        let prototype = prototype(name, function, several_cores && !whole);
        if whole && given.len() <= most + 1 {
            return Ok(1);
        }
        if given.len() < needed {
            let missing = if several_cores && given.is_empty() {
                "core"
            } else {
                function.params.get(given.len() - skip).map_or("a parameter", |param| param.name)
            };
            return Err(Fault::new(
                span,
                format!("{} needs {needed} parameters, {} are given: `{missing}` is missing", name.text, given.len()),
                &format!("it is {prototype}"),
            ));
        }
        if given.len() > most {
            let place = given.get(most).map_or(span, |extra| extra.span.clone());
            return Err(Fault::new(
                place,
                format!("{} takes at most {most} parameters, {} are given", name.text, given.len()),
                &format!("it is {prototype}"),
            ));
        }
        match given.first().filter(|_| several_cores) {
            None => Ok(1),
            Some(first) => match self.scalar(first, Type::Short, "core", name)? {
                Value::Int(core) => Ok(core as i16),
                _ => Err(Fault::new(first.span.clone(), "`core` is an integer from 1", "")),
            },
        }
    }

    pub(crate) fn scalar(&mut self, given: &Given, of: Type, parameter: &str, name: &Token) -> Result<Value, Fault> {
        let What::Value(value) = &given.what else {
            return Err(Fault::new(
                given.span.clone(),
                format!("`{parameter}` of {} is a value, not an address or a text", name.text),
                "",
            ));
        };
        if matches!(value, Value::Real(number) if !number.is_finite()) && of == Type::Double {
            self.warn(
                given.span.clone(),
                format!("`{parameter}` is {}; the controller will refuse it (7)", show(value)),
                "",
            );
        }
        let place = || given.span.clone();
        if of == Type::ULong && is_negative(value) && !self.is_pattern(given) {
            let message = format!(
                "`{parameter}` of {} is {}; it is an {}, which is never negative (return value 7)",
                name.text,
                show(value),
                of.name()
            );
            return Err(Fault::new(place(), message, ""));
        }
        let taken = of.convert(value).map_err(|message| {
            Fault::new(place(), format!("`{parameter}` of {}: {message} (return value 7)", name.text), "")
        })?;
        if let (Value::Real(real), Value::Int(whole)) = (value, &taken)
            && is_lost(*real, *whole as f64)
            && self.shortened.insert((name.text.clone(), parameter.to_owned()))
        {
            self.warn(
                place(),
                format!("`{parameter}` of {} is {real}; it is a whole number, and {whole} is taken", name.text),
                "round it in the script; later calls with a fraction there are not named",
            );
        }
        Ok(taken)
    }

    /// Written as bits: its 32nd bit may be set, which is no sign in an unsigned parameter.
    fn is_pattern(&self, given: &Given) -> bool {
        let written = self.text.get(given.span.clone()).unwrap_or_default().to_lowercase();
        !written.contains('-') && ["0x", "<<", "~"].iter().any(|mark| written.contains(mark))
    }

    pub(crate) fn bind(&mut self, function: &Function, given: &[Given], name: &Token) -> Result<Bound, Fault> {
        let mut bound = Bound::default();
        if function.shape == Shape::Host {
            return Ok(bound);
        }
        let count = self.count(function, given, name)?;
        let short = function.name == "SetLaserDisRatio" && given.len() == 2;
        for (index, param) in function.params.iter().enumerate() {
            // Its short form is (ratio, channel).
            let index = match index {
                _ if !short => index,
                0 => 0,
                3 => 1,
                _ => usize::MAX,
            };
            let null = |given: &&Given| {
                param.default.is_some()
                    && matches!(param.pass, Pass::Fixed(..))
                    && matches!(given.what, What::Value(Value::Int(0)))
            };
            let Some(given) = given.get(index).filter(|given| !null(given)) else {
                let (of, times) = match param.pass {
                    Pass::In(of) => (of, 1),
                    Pass::Fixed(of, length) => (of, length),
                    _ => continue,
                };
                if let Some(default) = param.default {
                    let value = of.convert(&Value::Int(i64::from(default))).unwrap_or(Value::Int(0));
                    bound.values.extend((0..times).map(|_| (param.name, value.clone())));
                }
                continue;
            };
            bound.is_given |= function.reports_given == Some(param.name);
            match param.pass {
                Pass::In(of) => {
                    let value = self.scalar(given, of, param.name, name)?;
                    bound.values.push((param.name, value));
                }
                Pass::Text => match &given.what {
                    What::Text(text) => bound.text = Some((text.clone(), given.span.clone())),
                    _ => return Err(self.wrong(param, given, name, "a text in quotation marks")),
                },
                Pass::Many(of, size) => {
                    let list = self.list(param, given, of, bound.length(size, count), name)?;
                    bound.lists.push(list);
                }
                Pass::Fixed(of, length) => {
                    let list = self.list(param, given, of, length, name)?;
                    bound.values.extend(list.into_iter().map(|value| (param.name, value)));
                }
                Pass::Struct(of) => {
                    let (variable, element) = self.struct_given(param, given, of, name)?;
                    let width = Variable::width(of);
                    let cells = self.variables[&variable].cells[element * width..(element + 1) * width].to_vec();
                    for (((field, _), place), cell) in of.cells().zip(of.value_names()).zip(cells) {
                        let value = self.field_value(cell, &variable, &place, given)?;
                        bound.values.push((field, value));
                    }
                }
                Pass::StructOrNull(_) if matches!(given.what, What::Value(Value::Int(0))) => {}
                Pass::StructOrNull(of) => {
                    let (variable, element) = self.struct_given(param, given, of, name)?;
                    let width = Variable::width(of);
                    let cells = self.variables[&variable].cells[element * width..(element + 1) * width].to_vec();
                    let mut values = Vec::with_capacity(width);
                    for (place, cell) in of.value_names().zip(cells) {
                        values.push(self.field_value(cell, &variable, &place, given)?);
                    }
                    bound.lists.push(values);
                }
                Pass::OutStruct(of) => {
                    let (variable, element) = self.struct_given(param, given, of, name)?;
                    bound.outs.push(Out { parameter: param.name, variable: variable.clone() });
                    bound.fills.push((variable, element * Variable::width(of), given.span.clone()));
                }
                Pass::Working => match &given.what {
                    What::Address { .. } | What::Value(Value::Int(0)) => {}
                    _ => return Err(self.wrong(param, given, name, "an array, or NULL")),
                },
                Pass::Out => self.out(param, given, count, name, &mut bound)?,
            }
        }
        Ok(bound)
    }

    /// Value of the parameter `count`, 1 where there is none.
    pub(crate) fn count(&mut self, function: &Function, given: &[Given], name: &Token) -> Result<usize, Fault> {
        let single = |param: &Param| param.name == "count" && matches!(param.pass, Pass::In(_));
        let Some(index) = function.params.iter().position(single) else { return Ok(1) };
        let Some(given) = given.get(index) else { return Ok(1) };
        // A count that no controller takes is refused there, with its limits; here it only sizes
        // arrays.
        Ok(match self.scalar(given, Type::Long, "count", name)? {
            Value::Int(count) => usize::try_from(count).unwrap_or(0),
            _ => 1,
        })
    }

    pub(crate) fn wrong(&self, param: &Param, given: &Given, name: &Token, wanted: &str) -> Fault {
        Fault::new(given.span.clone(), format!("`{}` of {} is {wanted}", param.name, name.text), "")
    }

    pub(crate) fn list(
        &mut self,
        param: &Param,
        given: &Given,
        of: Type,
        count: usize,
        name: &Token,
    ) -> Result<Vec<Value>, Fault> {
        let What::Address { name: variable, element: Some(element), .. } = &given.what else {
            return Err(self.wrong(param, given, name, "an array, or the address of its first value (&x)"));
        };
        let cells = &self.variables[variable].cells;
        let Some(cells) = cells.get(*element..element.saturating_add(count)) else {
            let message =
                format!("`{variable}` has {} values from here on, {count} are asked for", cells.len() - element);
            return Err(Fault::new(given.span.clone(), message, "declare it longer, or lower the count"));
        };
        cells
            .iter()
            .map(|cell| match cell {
                Value::Unset | Value::Later { .. } => Err(Fault::new(
                    given.span.clone(),
                    format!("`{variable}` holds {} where a value is needed", show(cell)),
                    "fill it first",
                )),
                value => of.convert(value).map_err(|message| {
                    Fault::new(
                        given.span.clone(),
                        format!("`{}` of {}: {message} (return value 7)", param.name, name.text),
                        "",
                    )
                }),
            })
            .collect()
    }

    pub(crate) fn struct_given(
        &self,
        param: &Param,
        given: &Given,
        of: Type,
        name: &Token,
    ) -> Result<(String, usize), Fault> {
        match &given.what {
            What::Address { name: variable, element: Some(element), .. } if self.variables[variable].of == of => {
                Ok((variable.clone(), *element))
            }
            _ => Err(self.wrong(param, given, name, &format!("the address of a {} (&x)", of.name()))),
        }
    }

    pub(crate) fn field_value(&self, cell: Value, variable: &str, field: &str, given: &Given) -> Result<Value, Fault> {
        match cell {
            Value::Unset => Err(Fault::new(
                given.span.clone(),
                format!("`{variable}.{field}` has no value yet"),
                &format!("set every field before the call, as in `{variable}.{field} = 0;`"),
            )),
            Value::Later { call, line } => Err(Fault::new(
                given.span.clone(),
                format!(
                    "`{variable}.{field}` is filled by {call} in line {line} when the job runs; its value is not known before"
                ),
                "set the field in the script",
            )),
            value => Ok(value),
        }
    }

    pub(crate) fn out(
        &mut self,
        param: &Param,
        given: &Given,
        count: usize,
        name: &Token,
        bound: &mut Bound,
    ) -> Result<(), Fault> {
        match &given.what {
            What::Value(Value::Int(0)) if param.default.is_some() => Ok(()),
            What::Address { text, name: variable, element } => {
                if let Some(element) = element {
                    let held = &self.variables[variable];
                    let room = held.length.unwrap_or(1) - element;
                    let many = matches!(param.name, "sts" | "value" | "status" | "tableId" | "time" | "vel");
                    if many && count > room {
                        let message =
                            format!("`{variable}` has room for {room} values from here on, {count} are asked for");
                        return Err(Fault::new(given.span.clone(), message, "declare it longer, or lower the count"));
                    }
                    if held.of.is_struct() {
                        return Err(self.wrong(param, given, name, "the address of a number (&x)"));
                    }
                    for offset in 0..if many { count } else { 1 } {
                        bound.fills.push((variable.clone(), element + offset, given.span.clone()));
                    }
                }
                bound.outs.push(Out { parameter: param.name, variable: text.clone() });
                Ok(())
            }
            _ => Err(self.wrong(param, given, name, "the address of a variable (&x) or an array")),
        }
    }
}

/// Below zero as the integer that it becomes.
fn is_negative(value: &Value) -> bool {
    match *value {
        Value::Int(number) => number < 0,
        Value::Real(number) => number <= -1.0,
        _ => false,
    }
}

/// The function as its prototype reads.
fn prototype(name: &Token, function: &Function, core: bool) -> String {
    let mut parts: Vec<String> = if core { vec!["core".into()] } else { Vec::new() };
    for param in function.params {
        let star = match param.pass {
            Pass::In(_) | Pass::Text => "",
            _ => "*",
        };
        parts.push(match param.default {
            Some(default) => format!("{star}{} = {default}", param.name),
            None => format!("{star}{}", param.name),
        });
    }
    format!("{}({})", name.text, parts.join(", "))
}
