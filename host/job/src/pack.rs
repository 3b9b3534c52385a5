//! Checked parameters as the bytes of a request.

use crate::api::{Function, Shape};
use crate::bind::Bound;
use crate::read::{Fault, Reader};
use crate::value::{Value, show};
use crate::{Axis, config};
use protocol::command::COMMANDS;
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
            Shape::Form => values.push(Value::Int(i64::from(!several_cores))),
            Shape::Items => {
                let list = bound.lists.first().map_or(&[][..], Vec::as_slice);
                for value in list {
                    put(&mut items, "I16", value);
                }
            }
            Shape::Points => {
                let count = bound.values.iter().position(|(name, _)| *name == "count").unwrap_or(0);
                values.insert(count + 1, Value::Int(0));
                let points = bound.lists.first().map_or(0, Vec::len);
                for point in 0..points {
                    bound
                        .lists
                        .iter()
                        .filter_map(|list| list.get(point))
                        .for_each(|value| put(&mut items, "F64", value));
                }
            }
            Shape::Point => {
                if let Some(list) = bound.lists.first() {
                    // Of eight places and three parts of a centre, those that a coordinate system has.
                    let (places, centre) = (2..10, 12..15);
                    let skipped =
                        |index: &usize| places.clone().skip(4).chain(centre.clone().skip(2)).any(|i| i == *index);
                    let kept = list.iter().enumerate().filter(|(index, _)| !skipped(index)).map(|(_, value)| value);
                    fill(&mut items, item_fields(function.opcode), kept);
                }
            }
            Shape::StartList => {
                values = vec_masks(bound).map_err(|message| Fault::new(span.clone(), message, ""))?;
                if let Some(Value::Int(mask)) = values.first() {
                    self.name_mask(core, *mask as u32);
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
                self.named.extend(found.items.iter().map(|item| Axis { core, axis: item.axis.get() }));
                values = vec![Value::Int(found.items.len() as i64)];
                items = config::bytes(&found.items);
            }
        }
        let fields =
            COMMANDS.iter().find(|command| command.opcode == function.opcode).map_or(&[][..], |command| command.fields);
        if fields.first().is_some_and(|field| field.0 == "core") {
            values.insert(0, Value::Int(i64::from(core)));
        }
        let mut body = Vec::new();
        fill(&mut body, fields, values.iter());
        body.extend(items);
        Ok(Some(body))
    }
}

type Fields = &'static [(&'static str, &'static str)];

fn item_fields(opcode: u16) -> Fields {
    COMMANDS.iter().find(|command| command.opcode == opcode).map_or(&[], |command| command.items)
}

/// Appends the values of these fields; an array takes as many as it has places.
fn fill<'v>(body: &mut Vec<u8>, fields: Fields, mut values: impl Iterator<Item = &'v Value>) {
    for (_, of) in fields {
        let array = of.strip_prefix('[').and_then(|of| of.strip_suffix(']')).and_then(|of| of.split_once("; "));
        let (of, count) = match array {
            Some((of, count)) => (of, count.parse().unwrap_or(0)),
            None => (*of, 1),
        };
        for value in values.by_ref().take(count) {
            put(body, of, value);
        }
    }
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
