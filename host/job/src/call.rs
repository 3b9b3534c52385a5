//! Calls: which function, and the effect of its call on the remaining script.
//!
//! In: the reader at a call. Out: its step. `bind` reads and checks the parameters, `pack` makes
//! bytes of them.

use crate::api::{self, Function, Pass};
use crate::bind::Bound;
use crate::endless::Numbers;
use crate::expr::nearest;
use crate::read::{Fault, Reader};
use crate::scan::{Kind, Token};
use crate::value::{Type, Value};
use crate::{Action, Axis, Call};
use protocol::command::{CommandKind, DataStore, class};
use protocol::reserved::RESERVED;
use protocol::values::PATH_EFFECTS;
use std::ops::Range;

/// A count beyond this names no more axes: no profile has them.
const AXES_MAX: i64 = 64;

impl Reader<'_> {
    /// Reads a call without its `;` and outputs its step. `start` is the token that begins the
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
            "memset" => return self.zero_memory(&name),
            word if api::SKIPPED.contains(&word) => {
                self.skip_call();
                return Ok(later);
            }
            _ => {}
        }
        let (function, several_cores) = self.resolve(&name)?;
        if self.polling && !function.reads() {
            return Err(Fault::new(
                name.span,
                format!(
                    "{} does more than read; a while(!kbhit()) loop of a job script may only read and print",
                    name.text
                ),
                "such a loop means WaitStop of everything that runs; for more, use the C library",
            ));
        }
        self.executes();
        let given = self.given(function, several_cores)?;
        // The manual prints GTN_PrfPvt(profile), and calls it with the core.
        let several_cores = several_cores && !(function.name == "PrfPvt" && given.len() == 1);
        let span = name.span.start..self.before().end;
        let core = self.bind_count(function, several_cores, &given, &name, span.clone())?;
        let skip = usize::from(several_cores);
        let bound = self.bind(function, &given[skip.min(given.len())..], &name)?;
        let body = self.pack(function, several_cores, core, &bound, &span)?;
        self.note(function, several_cores, core, &bound, &span);
        self.fill(function, core, &bound, &later, &span);
        if let Some(body) = body {
            let may_fail = assigned && self.keep_going;
            let call = Call { function: name.text.into(), opcode: function.opcode, body, outs: bound.outs, may_fail };
            self.push(start, Action::Call(call));
        }
        Ok(if self.keep_going { later } else { Value::Int(0) })
    }

    /// `memset(&x, 0, sizeof(x))`: every value of the variable is 0.
    fn zero_memory(&mut self, name: &Token) -> Result<Value, Fault> {
        const FORM: &str = "it is memset(&x, 0, sizeof(x)), which sets every value of x to 0";
        self.expect("(", "after the function's name")?;
        self.accept("&");
        let target = self.advance();
        let zeroes = self.is(",") && self.peek_after(1).text == "0" && self.peek_after(2).text == ",";
        let Some(variable) = self.variables.get_mut(&target.text).filter(|_| zeroes) else {
            return Err(Fault::new(
                name.span.start..target.span.end,
                "this memset is not available in job scripts",
                FORM,
            ));
        };
        let types: Vec<Type> = variable.of.cells().map(|(_, of)| of).collect();
        for (cell, of) in variable.cells.iter_mut().zip(types.iter().cycle()) {
            *cell = of.convert(&Value::Int(0)).unwrap_or(Value::Int(0));
        }
        // The remaining parentheses: the size.
        let mut open = 1usize;
        while open > 0 && self.peek().kind != Kind::End {
            match self.advance().text.as_str() {
                "(" => open += 1,
                ")" => open -= 1,
                _ => {}
            }
        }
        Ok(Value::Int(0))
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
            // LSR example 4 lacks the first letter of one call.
            _ => match name.text.strip_prefix("T_").filter(|bare| api::function(bare).is_some()) {
                Some(bare) => {
                    let message = format!("`{}` is taken as `GT_{bare}`", name.text);
                    self.warn(name.span.clone(), message, "the printed manual misspells it");
                    (bare, false)
                }
                None => return Err(unknown(name)),
            },
        };
        let bare = match api::MISREAD.iter().find(|(misread, _)| *misread == bare) {
            Some((_, right)) => {
                let prefix = if several_cores { "GTN_" } else { "GT_" };
                self.warn(
                    name.span.clone(),
                    format!("`{}` is taken as `{prefix}{right}`", name.text),
                    "the printed manual misspells it",
                );
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
                "this version has the session, axis, input/output, Trap, Jog, PT, PVT, Follow, coordinate-system and laser commands; see docs/jobs.md",
            )),
            None => Err(unknown(name)),
        }
    }

    /// Takes note of what the call means for waits, traces and later Get…Prm calls.
    fn note(&mut self, function: &Function, several_cores: bool, core: i16, bound: &Bound, span: &Range<usize>) {
        let numbers: Vec<f64> = bound
            .values
            .iter()
            .map(|(_, value)| match value {
                Value::Int(number) => *number as f64,
                Value::Real(number) => *number,
                _ => 0.0,
            })
            .collect();
        let line = self.line(span);
        self.motions.note(function.name, several_cores, core, &Numbers(&numbers), line);
        self.name_axes(function, several_cores, core, bound, line);
        let first = numbers.first().map_or(0, |number| *number as i16);
        let values = bound.values.iter().zip(&numbers).map(|((name, _), number)| (*name, *number));
        let moved = self.used.note(function, core, values);
        self.name_each(moved, line);
        self.count_between(function, core, bound, span);
        self.look_at_option(function, bound, span);
        match function.name {
            "Reset" => {
                self.reset.insert(core);
                self.parameters.retain(|(of, _, _), _| *of != core);
            }
            "SetJogPrm" | "SetTrapPrm" | "SetCrdPrm" => {
                let values = bound.values.iter().skip(1).map(|(_, value)| value.clone()).collect();
                self.parameters.insert((core, first, &function.name[3..]), values);
            }
            _ => {}
        }
    }

    /// Counts the entries between two motions of a path. The path stops there if they are more than
    /// a servo tick executes.
    fn count_between(&mut self, function: &Function, core: i16, bound: &Bound, span: &Range<usize>) {
        let value = |wanted: &str| match bound.values.iter().find(|(name, _)| *name == wanted) {
            Some((_, Value::Int(number))) => *number,
            _ => 0,
        };
        let crd = value("crd") as i16;
        let load = match function.name {
            "SetCrdPrm" => {
                self.between.retain(|(of, other, _), _| (*of, *other) != (core, crd));
                return;
            }
            "BufMove" => 4,
            "CrdClear" | "BufDelay" => 0,
            name => match class(function.opcode).map(|class| class.kind) {
                Some(CommandKind::Data(DataStore::Path | DataStore::Light)) => u32::from(name.starts_with("Buf")),
                _ => return,
            },
        };
        let count = self.between.entry((core, crd, value("fifo"))).or_default();
        let before = core::mem::replace(count, if load == 0 { 0 } else { count.saturating_add(load) });
        if load != 0 && before <= PATH_EFFECTS && before + load > PATH_EFFECTS {
            let message = format!(
                "more than {PATH_EFFECTS} entries stand between two motions of coordinate system {crd}: its path stops here, for a servo \
                 tick with every {PATH_EFFECTS} of them"
            );
            self.warn(span.clone(), message, "a BufMove counts as four; move some of them to another part of the path");
        }
    }

    /// A bit of `option` says something of what the same bit of `mask` names, and else nothing.
    fn look_at_option(&mut self, function: &Function, bound: &Bound, span: &Range<usize>) {
        let bits = |wanted: &str| match bound.values.iter().find(|(name, _)| *name == wanted) {
            Some((_, Value::Int(bits))) => Some(*bits as u32),
            _ => None,
        };
        let Some((mask, option)) = bits("mask").zip(bits("option")) else { return };
        if option & !mask == 0 {
            return;
        }
        let help = match function.name {
            "Stop" | "CrdStop" => "a bit of `option` stops abruptly what the same bit of `mask` names",
            _ => "a bit of `option` takes FIFO 1 for what the same bit of `mask` names",
        };
        let message = format!("bits {:#x} of `option` do nothing: they are not in `mask`, {mask:#x}", option & !mask);
        self.warn(span.clone(), message, help);
    }

    /// Takes note of the core and the axes that the call names: a profile must hold them.
    fn name_axes(&mut self, function: &Function, several_cores: bool, core: i16, bound: &Bound, line: u32) {
        let value = |wanted: &str| match bound.values.iter().find(|(name, _)| *name == wanted) {
            Some((_, Value::Int(number))) => Some(*number),
            _ => None,
        };
        let first = ["axis", "profile", "encoder", "control"].iter().find_map(|name| value(name));
        let count = value("count").unwrap_or(1);
        self.name_each([Axis { core, axis: 0 }], line);
        if let Some(first) = first {
            let last = first.saturating_add(count.clamp(1, AXES_MAX)) - 1;
            self.name_each(
                (first..=last).filter_map(|axis| Some(Axis { core, axis: i16::try_from(axis).ok()? })),
                line,
            );
        }
        // Those of CrdStart and CrdStop name coordinate systems.
        if let Some(mask) = value("mask").filter(|_| !function.name.starts_with("Crd")) {
            // In the GT form of Stop, bits from 8 on are coordinate systems.
            let axes = if function.name == "Stop" && !several_cores { mask & 0xff } else { mask };
            self.name_mask(core, axes as u32, line);
        }
    }

    /// Takes note of the axes of a mask.
    pub(crate) fn name_mask(&mut self, core: i16, mask: u32, line: u32) {
        self.name_each((0..32i16).filter(|bit| mask >> bit & 1 == 1).map(|bit| Axis { core, axis: bit + 1 }), line);
    }

    /// Takes note of axes that this line names.
    pub(crate) fn name_each(&mut self, axes: impl IntoIterator<Item = Axis>, line: u32) {
        for axis in axes {
            self.named.entry(axis).or_insert(line);
        }
    }

    /// What the call fills: known for Jog and Trap parameters that the script itself has set, or
    /// that have their power-on values; otherwise known only when the job runs.
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
                    of.cells().map(|(_, of)| of.convert(&Value::Int(0)).unwrap_or(Value::Int(0))).collect()
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
