//! Which layer marks which shape.
//!
//! In: shapes, the layers of the machine file. Out: the shapes of each layer that marks something,
//! in the order in which layers run; the layers that take nothing. Fails with the strokes that have
//! no layer.
use crate::shape::{Paint, Shape, caseless};
use machine::{Colour, Layer, Machine};
use std::collections::BTreeMap;

/// Strokes without a layer that are named.
const NAMED_MAX: usize = 6;

/// Layers with their shapes, and a note where layers take none.
pub type Sorted<'m> = (Vec<(&'m Layer, Vec<Shape>)>, Option<String>);

pub fn sort(shapes: Vec<Shape>, machine: &Machine) -> Result<Sorted<'_>, String> {
    if machine.layers.is_empty() {
        return Err("the machine file has no [[layers]], which say the power and the speed of strokes; \
             docs/machine.md shows some, or give --layer power=…,speed=…"
            .to_owned());
    }
    let mut found: Vec<(&Layer, Vec<Shape>)> = machine.layers.iter().map(|layer| (layer, Vec::new())).collect();
    let mut homeless: BTreeMap<String, usize> = BTreeMap::new();
    for shape in shapes {
        match found.iter_mut().find(|(layer, _)| takes(layer, &shape.paint)) {
            Some((_, shapes)) => shapes.push(shape),
            None => *homeless.entry(name(&shape.paint)).or_insert(0) += 1,
        }
    }
    if !homeless.is_empty() {
        let list: Vec<String> =
            homeless.iter().take(NAMED_MAX).map(|(name, count)| format!("{name} ({count} shapes)")).collect();
        let more = if homeless.len() > NAMED_MAX {
            format!(" and {} more", homeless.len() - NAMED_MAX)
        } else {
            String::new()
        };
        return Err(format!(
            "no layer takes {}{more}; give them one, or a layer without a colour, which takes all, in [[layers]] of the \
             machine file or by --layer",
            list.join(", ")
        ));
    }
    let idle: Vec<&Layer> = found.iter().filter(|(_, shapes)| shapes.is_empty()).map(|(layer, _)| *layer).collect();
    found.retain(|(layer, shapes)| !layer.skip && !shapes.is_empty());
    if let Some(why) = found.iter().find_map(|(layer, _)| layer.unfit.as_ref()) {
        return Err(why.clone());
    }
    found.sort_by_key(|(layer, _)| layer.order);
    if found.is_empty() {
        return Err("there is nothing to mark: no shape has a stroke whose layer is marked".to_owned());
    }
    Ok((found, note(&idle)))
}

/// What is said of layers that take no stroke of the drawing.
fn note(idle: &[&Layer]) -> Option<String> {
    let named = idle.iter().take(NAMED_MAX).map(|layer| format!("\"{}\" ({})", layer.name, layer.takes()));
    let named: Vec<String> = named.collect();
    let more = if idle.len() > NAMED_MAX { format!(" and {} more", idle.len() - NAMED_MAX) } else { String::new() };
    (!idle.is_empty()).then(|| format!("no stroke of the drawing is taken by layer {}{more}", named.join(", ")))
}

fn takes(layer: &Layer, paint: &Paint) -> bool {
    let colour = match layer.colour {
        None => true,
        Some(Colour::Rgb(rgb)) => paint.colour == rgb,
        Some(Colour::Index(index)) => paint.index == Some(index),
    };
    let is_named = |named: &String| paint.layer.as_ref().is_some_and(|own| caseless(own).eq(caseless(named)));
    let layer = layer.drawing_layer.as_ref().is_none_or(is_named);
    colour && layer
}

/// What a person calls a stroke.
fn name(paint: &Paint) -> String {
    let [r, g, b] = paint.colour;
    let colour = match paint.index {
        Some(index) => format!("colour {index} (#{r:02x}{g:02x}{b:02x})"),
        None => format!("#{r:02x}{g:02x}{b:02x}"),
    };
    match &paint.layer {
        Some(layer) => format!("{colour} on layer `{}`", layer.chars().take(40).collect::<String>()),
        None => colour,
    }
}
