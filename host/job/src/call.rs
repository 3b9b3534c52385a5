//! Calls: parameters checked against the table, packed into the request.

use crate::api::{self, Function, Param, Pass, Shape};
use crate::endless::Numbers;
use crate::expr::nearest;
use crate::read::{Fault, Reader};
use crate::scan::{Kind, Token};
use crate::value::{Type, Value, Variable, show};
use crate::{Action, Axis, Call, Out, config};
use protocol::command::COMMANDS;
use protocol::reserved::RESERVED;
use std::ops::Range;

/// One thing between the parentheses.
struct Given {
    span: Range<usize>,
    what: What,
}

enum What {
    /// A value.
    Value(Value),
    /// The address of a variable's element; `None` where the script does not declare it.
    Address { text: String, name: String, element: Option<usize> },
    /// A text.
    Text(String),
}

/// What the parameters of a call have become.
#[derive(Default)]
struct Bound {
    /// Values that go in, in order, by name.
    values: Vec<(&'static str, Value)>,
    /// Elements of arrays that go in.
    lists: Vec<Vec<Value>>,
    outs: Vec<Out>,
    /// Variables to fill: name, first cell, and the span that names them.
    fills: Vec<(String, usize, Range<usize>)>,
    text: Option<(String, Range<usize>)>,
}

const SHORT: Param = Param { name: "core", pass: Pass::In(Type::Short), default: None };

impl Reader<'_> {
    /// Reads a call without its `;` and puts out its step. `start` is the token that begins the
    /// statement. The value is the function's result, 0 where the job would have stopped otherwise.
    pub(crate) fn call(&mut self, start: usize, assigned: bool) -> Result<Value, Fault> {
        let name = self.advance();
        let later = Value::Later { call: name.text.clone(), line: self.line(&name.span) };
        match name.text.as_str() {
            "Sleep" => {
                self.executes();
                return self.sleep(start, &name).map(|()| Value::Int(0));
            }
            "WaitStop" => {
                self.executes();
                return self.wait_stop(start, &name).map(|()| Value::Int(0));
            }
            word if api::SKIPPED.contains(&word) => {
                self.skip_call();
                return Ok(later);
            }
            _ => {}
        }
        let (function, several_cores) = self.resolve(&name)?;
        if self.polling && !function.reads {
            return Err(Fault::new(
                name.span,
                format!("{} does more than read; a while(!kbhit()) loop of a job script may only read and print", name.text),
                "such a loop means WaitStop of everything that runs; for more, use the C library",
            ));
        }
        self.executes();
        let given = self.given(function, several_cores)?;
        let span = name.span.start..self.before().end;
        let core = self.bind_count(function, several_cores, &given, &name, span.clone())?;
        let skip = usize::from(several_cores);
        let bound = self.bind(function, &given[skip.min(given.len())..], &name)?;
        let body = self.pack(function, several_cores, core, &bound, &span)?;
        self.note(function, several_cores, core, &bound, &span);
        self.fill(function, core, &bound, &later, &span);
        if let Some(body) = body {
            let may_fail = assigned && self.keep_going;
            let call = Call { function: name.text, opcode: function.opcode, body, outs: bound.outs, may_fail };
            self.push(start, Action::Call(call));
        }
        Ok(if self.keep_going { later } else { Value::Int(0) })
    }

    fn skip_call(&mut self) {
        let mut depth = 0usize;
        loop {
            match self.peek().text.as_str() {
                "(" if self.peek().kind == Kind::Mark => depth += 1,
                ")" if self.peek().kind == Kind::Mark => depth = depth.saturating_sub(1),
                _ => {}
            }
            if self.peek().kind == Kind::End {
                return;
            }
            self.advance();
            if depth == 0 {
                return;
            }
        }
    }

    /// The function of a name, and whether it is the form with `core`.
    fn resolve(&mut self, name: &Token) -> Result<(&'static Function, bool), Fault> {
        let (bare, several_cores) = match (name.text.strip_prefix("GTN_"), name.text.strip_prefix("GT_")) {
            (Some(bare), _) => (bare, true),
            (_, Some(bare)) => (bare, false),
            _ => return Err(unknown(name)),
        };
        let bare = match api::MISREAD.iter().find(|(misread, _)| *misread == bare) {
            Some((_, right)) => {
                let prefix = if several_cores { "GTN_" } else { "GT_" };
                self.warn(name.span.clone(), format!("`{}` is taken as `{prefix}{right}`", name.text), "the printed manual misspells it");
                right
            }
            None => bare,
        };
        if let Some(function) = api::function(bare) {
            return Ok((function, several_cores));
        }
        match RESERVED.iter().find(|(_, reserved)| *reserved == bare) {
            Some((number, _)) => Err(Fault::new(
                name.span.clone(),
                format!("{} is not in this version of the firmware (command number {number:#06x})", name.text),
                "this version has the session, axis, input/output, Trap, Jog and PT commands; see docs/jobs.md",
            )),
            None => Err(unknown(name)),
        }
    }

    fn given(&mut self, function: &Function, several_cores: bool) -> Result<Vec<Given>, Fault> {
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

    fn one_given(&mut self, pass: Pass) -> Result<What, Fault> {
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
        let undeclared = alone && variable.is_none() && pass == Pass::Out && name != "NULL";
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
            return Err(self.fault_here("the address of one field cannot be given to a call here", "use a variable of its own"));
        }
        let span = start.start..self.before().end;
        let text = self.text.get(span.clone()).unwrap_or(&name).to_owned();
        let element = match self.variables.get(&name) {
            // A listing that was cut off may lack the declaration of what a call fills.
            None if pass == Pass::Out => None,
            None => return Err(Fault::new(span, format!("`{name}` is not declared"), "declare and fill it first")),
            Some(variable) => {
                let limit = variable.length.unwrap_or(1);
                let index = index.unwrap_or(0);
                let inside = usize::try_from(index).ok().filter(|index| *index < limit);
                Some(inside.ok_or_else(|| Fault::new(span, format!("index {index} is outside `{name}`, which has {limit} elements"), ""))?)
            }
        };
        Ok(What::Address { text, name, element })
    }

    /// Checks the number of parameters and gives the core.
    fn bind_count(
        &mut self, function: &Function, several_cores: bool, given: &[Given], name: &Token, span: Range<usize>,
    ) -> Result<i16, Fault> {
        // Opening and closing concern the whole controller: there the core is left out in both forms.
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

    fn scalar(&mut self, given: &Given, of: Type, parameter: &str, name: &Token) -> Result<Value, Fault> {
        let What::Value(value) = &given.what else {
            return Err(Fault::new(
                given.span.clone(),
                format!("`{parameter}` of {} is a value, not an address or a text", name.text),
                "",
            ));
        };
        if matches!(value, Value::Real(number) if !number.is_finite()) && of == Type::Double {
            self.warn(given.span.clone(), format!("`{parameter}` is {}; the controller will refuse it (7)", show(value)), "");
        }
        of.convert(value).map_err(|message| {
            Fault::new(given.span.clone(), format!("`{parameter}` of {}: {message} (return value 7)", name.text), "")
        })
    }

    fn bind(&mut self, function: &Function, given: &[Given], name: &Token) -> Result<Bound, Fault> {
        let mut bound = Bound::default();
        if function.shape == Shape::Host {
            return Ok(bound);
        }
        let count = self.count(function, given, name)?;
        for (index, param) in function.params.iter().enumerate() {
            let Some(given) = given.get(index) else {
                if let (Pass::In(of), Some(default)) = (param.pass, param.default) {
                    let value = of.convert(&Value::Int(i64::from(default))).unwrap_or(Value::Int(0));
                    bound.values.push((param.name, value));
                }
                continue;
            };
            match param.pass {
                Pass::In(of) => {
                    let value = self.scalar(given, of, param.name, name)?;
                    bound.values.push((param.name, value));
                }
                Pass::Text => match &given.what {
                    What::Text(text) => bound.text = Some((text.clone(), given.span.clone())),
                    _ => return Err(self.wrong(param, given, name, "a text in quotation marks")),
                },
                Pass::Many(of) => {
                    let list = self.list(param, given, of, count, name)?;
                    bound.lists.push(list);
                }
                Pass::Struct(of) => {
                    let (variable, element) = self.struct_given(param, given, of, name)?;
                    let width = Variable::width(of);
                    let cells = self.variables[&variable].cells[element * width..(element + 1) * width].to_vec();
                    for (field, cell) in of.fields().iter().zip(cells) {
                        let value = self.field_value(cell, &variable, field.0, given)?;
                        bound.values.push((field.0, value));
                    }
                }
                Pass::OutStruct(of) => {
                    let (variable, element) = self.struct_given(param, given, of, name)?;
                    bound.outs.push(Out { parameter: param.name, variable: variable.clone() });
                    bound.fills.push((variable, element * Variable::width(of), given.span.clone()));
                }
                Pass::Out => self.out(param, given, count, name, &mut bound)?,
            }
        }
        Ok(bound)
    }

    /// Value of the parameter `count`, 1 where there is none.
    fn count(&mut self, function: &Function, given: &[Given], name: &Token) -> Result<usize, Fault> {
        let Some(index) = function.params.iter().position(|param| param.name == "count") else { return Ok(1) };
        let Some(given) = given.get(index) else { return Ok(1) };
        // A count that no controller takes is refused there, with its limits; here it only sizes arrays.
        Ok(match self.scalar(given, Type::Short, "count", name)? {
            Value::Int(count) => usize::try_from(count).unwrap_or(0),
            _ => 1,
        })
    }

    fn wrong(&self, param: &Param, given: &Given, name: &Token, wanted: &str) -> Fault {
        Fault::new(given.span.clone(), format!("`{}` of {} is {wanted}", param.name, name.text), "")
    }

    fn list(&mut self, param: &Param, given: &Given, of: Type, count: usize, name: &Token) -> Result<Vec<Value>, Fault> {
        let What::Address { name: variable, element: Some(element), .. } = &given.what else {
            return Err(self.wrong(param, given, name, "an array, or the address of its first value (&x)"));
        };
        let cells = &self.variables[variable].cells;
        let Some(cells) = cells.get(*element..element.saturating_add(count)) else {
            let message = format!("`{variable}` has {} values from here on, {count} are asked for", cells.len() - element);
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
                    Fault::new(given.span.clone(), format!("`{}` of {}: {message} (return value 7)", param.name, name.text), "")
                }),
            })
            .collect()
    }

    fn struct_given(&self, param: &Param, given: &Given, of: Type, name: &Token) -> Result<(String, usize), Fault> {
        match &given.what {
            What::Address { name: variable, element: Some(element), .. } if self.variables[variable].of == of => {
                Ok((variable.clone(), *element))
            }
            _ => Err(self.wrong(param, given, name, &format!("the address of a {} (&x)", of.name()))),
        }
    }

    fn field_value(&self, cell: Value, variable: &str, field: &str, given: &Given) -> Result<Value, Fault> {
        match cell {
            Value::Unset => Err(Fault::new(
                given.span.clone(),
                format!("`{variable}.{field}` has no value yet"),
                &format!("set every field before the call, as in `{variable}.{field} = 0;`"),
            )),
            Value::Later { call, line } => Err(Fault::new(
                given.span.clone(),
                format!("`{variable}.{field}` is filled by {call} in line {line} when the job runs; its value is not known before"),
                "set the field in the script",
            )),
            value => Ok(value),
        }
    }

    fn out(&mut self, param: &Param, given: &Given, count: usize, name: &Token, bound: &mut Bound) -> Result<(), Fault> {
        match &given.what {
            What::Value(Value::Int(0)) if param.default.is_some() => Ok(()),
            What::Address { text, name: variable, element } => {
                if let Some(element) = element {
                    let held = &self.variables[variable];
                    let room = held.length.unwrap_or(1) - element;
                    let many = matches!(param.name, "sts" | "value" | "status");
                    if many && count > room {
                        let message = format!("`{variable}` has room for {room} values from here on, {count} are asked for");
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

    /// The request's bytes; none for what the host answers.
    fn pack(
        &mut self, function: &Function, several_cores: bool, core: i16, bound: &Bound, span: &Range<usize>,
    ) -> Result<Option<Vec<u8>>, Fault> {
        let mut values: Vec<Value> = bound.values.iter().map(|(_, value)| value.clone()).collect();
        let mut items = Vec::new();
        match function.shape {
            Shape::Host => return Ok(None),
            Shape::Plain => {}
            Shape::Form => values.push(Value::Int(i64::from(!several_cores))),
            Shape::Items => {
                let list = bound.lists.first().map_or(&[][..], Vec::as_slice);
                for value in list {
                    put(&mut items, "I16", value);
                }
            }
            Shape::StartList => values = vec_masks(bound).map_err(|message| Fault::new(span.clone(), message, ""))?,
            Shape::Config => {
                let (path, place) = bound.text.clone().unwrap_or_default();
                let text = self.files.text(&path).map_err(|message| {
                    Fault::new(place.clone(), format!("the configuration file cannot be read: {message}"),
                        "its path is relative to the folder of the job file")
                })?;
                let found = config::read(&path, &text).map_err(|message| Fault::new(place.clone(), message, "docs/jobs.md lists the keys"))?;
                for warning in found.warnings {
                    self.warn(place.clone(), warning, "docs/jobs.md lists the keys");
                }
                values = vec![Value::Int(found.items.len() as i64)];
                items = config::bytes(&found.items);
            }
        }
        let fields = COMMANDS.iter().find(|command| command.opcode == function.opcode).map_or(&[][..], |command| command.fields);
        if fields.first().is_some_and(|field| field.0 == "core") {
            values.insert(0, Value::Int(i64::from(core)));
        }
        let mut body = Vec::new();
        for (field, value) in fields.iter().zip(&values) {
            put(&mut body, field.1, value);
        }
        body.extend(items);
        Ok(Some(body))
    }

    /// Takes note of what the call means for waits, traces and later Get…Prm calls.
    fn note(&mut self, function: &Function, several_cores: bool, core: i16, bound: &Bound, span: &Range<usize>) {
        let numbers: Vec<f64> = bound.values.iter().map(|(_, value)| match value {
            Value::Int(number) => *number as f64,
            Value::Real(number) => *number,
            _ => 0.0,
        }).collect();
        let line = self.line(span);
        self.motions.note(function.name, several_cores, core, &Numbers(&numbers), line);
        let first = numbers.first().map_or(0, |number| *number as i16);
        let used = match function.name {
            "PrfPt" | "PrfTrap" | "PrfJog" | "SetPrfPos" | "SetEncPos" => 1,
            "ZeroPos" => numbers.get(1).map_or(0, |count| *count as i16),
            _ => 0,
        };
        self.axes.extend((first..first.saturating_add(used)).filter(|axis| *axis > 0).map(|axis| Axis { core, axis }));
        match function.name {
            "Reset" => {
                self.reset.insert(core);
                self.parameters.retain(|(of, _, _), _| *of != core);
            }
            "SetJogPrm" | "SetTrapPrm" => {
                let values = bound.values.iter().skip(1).map(|(_, value)| value.clone()).collect();
                self.parameters.insert((core, first, &function.name[3..]), values);
            }
            _ => {}
        }
    }

    /// What the call fills: known for Jog and Trap parameters that the script itself has set, or that
    /// have their power-on values; otherwise known only when the job runs.
    fn fill(&mut self, function: &Function, core: i16, bound: &Bound, later: &Value, span: &Range<usize>) {
        let parameters = match (function.params.get(1).map(|param| param.pass), bound.values.first()) {
            (Some(Pass::OutStruct(of)), Some((_, Value::Int(axis)))) => {
                let known = self.parameters.get(&(core, *axis as i16, &function.name[3..])).cloned();
                if known.is_none() && !self.reset.contains(&core) && !self.polling {
                    self.warn(
                        span.clone(),
                        "these parameters were not set in the script; their power-on values (0) are assumed".into(),
                        "set every field, or call Reset first",
                    );
                }
                Some(known.unwrap_or_else(|| {
                    of.fields().iter().map(|field| field.1.convert(&Value::Int(0)).unwrap_or(Value::Int(0))).collect()
                }))
            }
            _ => None,
        };
        for (name, cell, _) in &bound.fills {
            let Some(variable) = self.variables.get_mut(name) else { continue };
            let values = parameters.clone().unwrap_or_else(|| vec![later.clone()]);
            for (place, value) in variable.cells.iter_mut().skip(*cell).zip(values) {
                *place = value;
            }
        }
    }

    fn numbers(&mut self, name: &Token) -> Result<(Vec<Value>, Range<usize>), Fault> {
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

    fn sleep(&mut self, start: usize, name: &Token) -> Result<(), Fault> {
        let (values, span) = self.numbers(name)?;
        let ns = match values[..] {
            [Value::Int(ms @ 0..=4_294_967_295)] => ms as u64 * 1_000_000,
            [Value::Real(ms)] if (0.0..=4_294_967_295.0).contains(&ms) => (ms * 1e6).round() as u64,
            [_] => return Err(Fault::new(span, "Sleep takes 0 to 4294967295 ms", "")),
            _ => return Err(Fault::new(span, format!("Sleep takes one parameter, {} are given", values.len()), "it is Sleep(ms)")),
        };
        self.push(start, Action::Sleep { ns });
        Ok(())
    }

    fn wait_stop(&mut self, start: usize, name: &Token) -> Result<(), Fault> {
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
            [_] => return Err(Fault::new(span, "bits 0 to 7 are axes 1 to 8, bits 8 and 9 coordinate systems 1 and 2; others mean nothing here", FORMS)),
            [core @ 1..=32767, axes, crds] => (core as i16, axes, crds),
            [_, _, _] => return Err(Fault::new(span, "`core` is an integer from 1", FORMS)),
            _ => return Err(Fault::new(span, format!("WaitStop takes 1 or 3 parameters, {} are given", values.len()), FORMS)),
        };
        if self.polling {
            return Err(Fault::new(span, "WaitStop cannot stand in a while(!kbhit()) loop", "put it behind the loop"));
        }
        if let Some((axis, line)) = self.motions.endless(Some((core, axes))) {
            self.warn(
                span,
                format!("axis {} of core {}, started in line {line}, does not stop by itself", axis.axis, axis.core),
                "this waits until a limit or a fault stops it; put a Stop before it if that is not meant",
            );
        }
        self.motions.at_rest(core, axes);
        self.push(start, Action::WaitStop { core, axes, crds });
        Ok(())
    }
}

fn unknown(name: &Token) -> Fault {
    let bare = name.text.strip_prefix("GTN_").or(name.text.strip_prefix("GT_"));
    let prefix = if name.text.starts_with("GT_") { "GT_" } else { "GTN_" };
    let all = api::FUNCTIONS.iter().map(|function| function.name).chain(RESERVED.iter().map(|(_, name)| *name));
    let mut near: Vec<String> =
        nearest(bare.unwrap_or(&name.text), all).into_iter().map(|known| format!("{prefix}{known}")).collect();
    if bare.is_none() {
        near.extend(nearest(&name.text, ["Sleep", "WaitStop", "printf"].into_iter()).into_iter().map(str::to_owned));
    }
    let help = if near.is_empty() {
        "scripts know the GT_ and GTN_ functions, Sleep(ms) and WaitStop(mask)".to_owned()
    } else {
        format!("the nearest known: {}", near.join(", "))
    };
    Fault::new(name.span.clone(), format!("there is no function `{}`", name.text), &help)
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

/// Two lists of axes and FIFOs as the masks of PtStart.
fn vec_masks(bound: &Bound) -> Result<Vec<Value>, String> {
    let [axes, options] = &bound.lists[..] else { return Err("two arrays are needed".into()) };
    let (mut mask, mut option) = (0u32, 0u32);
    for (axis, fifo) in axes.iter().zip(options) {
        match (axis, fifo) {
            (Value::Int(axis @ 1..=32), Value::Int(fifo @ 0..=1)) => {
                mask |= 1 << (axis - 1);
                option |= (*fifo as u32) << (axis - 1);
            }
            _ => return Err(format!("axis {} with FIFO {}: axes are 1 to 32, FIFOs 0 and 1 (return value 7)", show(axis), show(fifo))),
        }
    }
    Ok(vec![Value::Int(i64::from(mask.cast_signed())), Value::Int(i64::from(option.cast_signed()))])
}

/// Appends `value` as the wire type `of`. Values were checked against the parameter's type before.
fn put(body: &mut Vec<u8>, of: &str, value: &Value) {
    let (whole, real) = match *value {
        Value::Int(number) => (number, number as f64),
        Value::Real(number) => (number as i64, number),
        _ => (0, 0.0),
    };
    match of {
        "F64" => body.extend(real.to_le_bytes()),
        "U64" => body.extend(whole.to_le_bytes()),
        "I32" | "U32" => body.extend((whole as i32).to_le_bytes()),
        "I16" | "U16" => body.extend((whole as i16).to_le_bytes()),
        _ => body.push(whole as u8),
    }
}
