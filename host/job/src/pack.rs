//! Checked parameters as the bytes of a request.

use crate::api::{Function, Shape, counts};
use crate::bind::Bound;
use crate::read::{Fault, Reader};
use crate::value::{Value, show};
use crate::{Axis, config};
use protocol::command::info;
use std::ops::Range;

impl Reader<'_> {
    /// The request's bytes; none for what the host answers.
    pub(crate) fn pack(
        &mut self,
        function: &Function,
        several_cores: bool,
        core: i16,
        bound: &Bound,
        span: &Range<usize>,
    ) -> Result<Option<Vec<u8>>, Fault> {
        let mut values: Vec<Value> = bound.values.iter().map(|(_, value)| value.clone()).collect();
        let mut items = Vec::new();
        match function.shape {
            Shape::Host => return Ok(None),
            Shape::Plain => {}
            Shape::Points | Shape::Grid => items = items_of(function, bound),
            Shape::Point => {
                if let Some(list) = bound.lists.first() {
                    // Of eight positions and three parts of a centre, those that a coordinate
                    // system has.
                    let (places, centre) = (2..10, 12..15);
                    let skipped =
                        |index: &usize| places.clone().skip(4).chain(centre.clone().skip(2)).any(|i| i == *index);
                    let kept = list.iter().enumerate().filter(|(index, _)| !skipped(index)).map(|(_, value)| value);
                    let mut kept = kept;
                    for (_, of) in info(function.opcode).map_or(&[][..], |command| command.items) {
                        fill(&mut items, of, &mut kept);
                    }
                }
            }
            Shape::StartList => {
                values = vec_masks(function, bound).map_err(|message| Fault::new(span.clone(), message, ""))?;
                if let Some(Value::Int(mask)) = values.first() {
                    self.name_mask(core, *mask as u32, self.line(span));
                }
            }
            Shape::Config => {
                let (path, place) = bound.text.clone().unwrap_or_default();
                let text = self.files.text(&path).map_err(|message| {
                    Fault::new(
                        place.clone(),
                        format!("the configuration file cannot be read: {message}"),
                        "its path is relative to the folder of the job file",
                    )
                })?;
                let found = config::read(&path, &text)
                    .map_err(|message| Fault::new(place.clone(), message, "docs/jobs.md lists the keys"))?;
                for warning in found.warnings {
                    self.warn(place.clone(), warning, "docs/jobs.md lists the keys");
                }
                self.name_each(found.items.iter().map(|item| Axis { core, axis: item.axis.get() }), self.line(span));
                values = vec![Value::Int(found.items.len() as i64)];
                items = config::bytes(&found.items);
            }
        }
        let mut values = values.iter();
        let mut body = Vec::new();
        for (name, of) in info(function.opcode).map_or(&[][..], |command| command.fields) {
            let own = match *name {
                "core" => i64::from(core),
                "form" => i64::from(!several_cores),
                "first" => 0,
                "count" if function.reports_stop() => 1,
                name if name.ends_with("_given") => i64::from(bound.is_given),
                _ => {
                    fill(&mut body, of, &mut values);
                    continue;
                }
            };
            put(&mut body, of, &Value::Int(own));
        }
        body.extend(items);
        Ok(Some(body))
    }
}

/// Appends the values of a field; an array takes as many as it has elements.
fn fill<'v>(body: &mut Vec<u8>, of: &str, values: &mut impl Iterator<Item = &'v Value>) {
    let array = of.strip_prefix('[').and_then(|of| of.strip_suffix(']')).and_then(|of| of.split_once("; "));
    let (of, count) = match array {
        Some((of, count)) => (of, count.parse().unwrap_or(0)),
        None => (of, 1),
    };
    for value in values.by_ref().take(count) {
        put(body, of, value);
    }
}

/// The items that follow the request: a value of each array in turn, or array by array.
fn items_of(function: &Function, bound: &Bound) -> Vec<u8> {
    let fields = info(function.opcode).map_or(&[][..], |command| command.items);
    let mut items = Vec::new();
    if function.shape == Shape::Grid {
        let (first, rest) = bound.lists.split_first().map_or((&[][..], &[][..]), |(first, rest)| (&first[..], rest));
        let of = fields.first().map_or("F64", |field| field.1);
        rest.iter().flatten().chain(first).for_each(|value| put(&mut items, of, value));
        return items;
    }
    for point in 0..bound.lists.first().map_or(0, Vec::len) {
        for (list, (_, of)) in bound.lists.iter().zip(fields) {
            list.get(point).into_iter().for_each(|value| put(&mut items, of, value));
        }
    }
    items
}

/// Two lists of axes and FIFOs as the masks of PtStart.
fn vec_masks(function: &Function, bound: &Bound) -> Result<Vec<Value>, String> {
    let [axes, options] = &bound.lists[..] else { return Err("two arrays are needed".into()) };
    // No `count` travels.
    if let Some((low, high)) =
        counts(function.name).filter(|(low, high)| !(*low..=*high).contains(&(axes.len() as i64)))
    {
        return Err(format!("`count` is {}; it must be from {low} to {high} (return value 7)", axes.len()));
    }
    let (mut mask, mut option) = (0u32, 0u32);
    for (axis, fifo) in axes.iter().zip(options) {
        match (axis, fifo) {
            (Value::Int(axis @ 1..=32), Value::Int(fifo @ 0..=1)) => {
                let (bit, fifo) = (1 << (axis - 1), (*fifo as u32) << (axis - 1));
                if mask & bit != 0 && option & bit != fifo {
                    return Err(format!("axis {axis} is listed twice, with different FIFOs (return value 7)"));
                }
                mask |= bit;
                option |= fifo;
            }
            _ => {
                return Err(format!(
                    "axis {} with FIFO {}: axes are 1 to 32, FIFOs 0 and 1 (return value 7)",
                    show(axis),
                    show(fifo)
                ));
            }
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
