//! What `usvg` would pass over in silence: numbers that are none, paths that break off, text,
//! images.
//!
//! In: the elements of a file. Out: nothing, or the line and the reason.
use crate::fault::Fault;
use std::collections::{HashMap, HashSet};
use std::str::FromStr;
use svgtypes::{Length, LengthListParser, NumberListParser, PathParser, PathSegment, Transform};
use usvg::roxmltree::{Document, Node};

/// Its name space.
pub const SVG: &str = "http://www.w3.org/2000/svg";
/// Largest number of a coordinate: beyond it 24 bits say nothing.
const COORDINATE_MAX: f64 = 1e7;
/// Lengths of shapes.
const LENGTHS: [&str; 12] = ["x", "y", "width", "height", "cx", "cy", "r", "rx", "ry", "x1", "y1", "x2"];
/// Elements that are shapes.
pub const SHAPES: [&str; 7] = ["path", "rect", "circle", "ellipse", "line", "polyline", "polygon"];

pub fn check(document: &Document<'_>) -> Result<(), Fault> {
    let root = document.root_element();
    if !root.has_tag_name((SVG, "svg")) {
        let name: String = root.tag_name().name().chars().take(40).collect();
        return Err(Fault::at(1, format!("its root is <{name}>, not <svg> with xmlns=\"{SVG}\"")));
    }
    let used = root.descendants().any(|node| node.has_tag_name((SVG, "use")));
    let mut hidden: Option<Node<'_, '_>> = None;
    for node in root.descendants().filter(|node| node.tag_name().namespace() == Some(SVG)) {
        // Descendants come in the order of the file: those of a hidden one follow it.
        if hidden.is_some_and(|hidden| node.range().start < hidden.range().end) {
            continue;
        }
        hidden = None;
        if is_hidden(node, used) {
            hidden = Some(node);
            continue;
        }
        let name = node.tag_name().name();
        let line = || document.text_pos_at(node.range().start).row;
        let refused = |what: &str| Err(Fault::at(line(), what));
        match name {
            "text" if node.descendants().any(|inner| inner.text().is_some_and(|text| !text.trim().is_empty())) => {
                let name = node.attribute("id").map_or_else(String::new, |id| format!(" `{}`", quoted(id)));
                let text = format!("the text{name} cannot be marked: convert text to paths in the drawing program");
                return Err(Fault::at(line(), text));
            }
            "image" => return refused("an image cannot be marked: trace it, or remove it"),
            // Programs put what is theirs into it, and for others the drawing after it.
            "foreignObject" if node.parent_element().is_some_and(|around| around.has_tag_name((SVG, "switch"))) => {
                hidden = Some(node);
                continue;
            }
            "foreignObject" => return refused("<foreignObject> is no drawing: remove it"),
            _ => {}
        }
        let wrong = |key: &str, value: &str, why: &str| {
            let shown = quoted(value);
            Fault::at(line(), format!("<{name}>: {key} is `{shown}`: {why}"))
        };
        if (SHAPES.contains(&name) || ["use", "svg"].contains(&name))
            && let Some(key) = LENGTHS.into_iter().chain(["y2"]).find(|key| is_part(node, key))
            && node.ancestors().any(|around| around.has_tag_name((SVG, "symbol")) && around.has_attribute("viewBox"))
        {
            let text = format!("<{name}>: {key} in % within a symbol is not supported: give it in px or mm");
            return Err(Fault::at(line(), text));
        }
        if let Some(value) = node.attribute("transform").filter(|value| value.trim() != "none") {
            let t = Transform::from_str(value).map_err(|error| wrong("transform", value, &error.to_string()))?;
            within([t.a, t.b, t.c, t.d, t.e, t.f]).map_err(|why| wrong("transform", value, &why))?;
        }
        if let Some(value) = property(node, "stroke-dasharray").filter(|value| !is_keyword(value)) {
            for length in LengthListParser::from(value) {
                let length = length.map_err(|error| wrong("stroke-dasharray", value, &error.to_string()))?;
                within([length.number]).map_err(|why| wrong("stroke-dasharray", value, &why))?;
                if length.number < 0.0 {
                    return Err(wrong("stroke-dasharray", value, "a length is below 0"));
                }
            }
        }
        if let Some(value) = property(node, "stroke-dashoffset").filter(|value| !is_keyword(value)) {
            let length =
                Length::from_str(value).map_err(|error| wrong("stroke-dashoffset", value, &error.to_string()))?;
            within([length.number]).map_err(|why| wrong("stroke-dashoffset", value, &why))?;
        }
        if !SHAPES.contains(&name) {
            continue;
        }
        for key in LENGTHS.into_iter().chain(["y2"]) {
            let Some(value) = node.attribute(key).filter(|value| *value != "auto") else { continue };
            let length = Length::from_str(value.trim()).map_err(|error| wrong(key, value, &error.to_string()))?;
            within([length.number]).map_err(|why| wrong(key, value, &why))?;
            if ["width", "height", "r", "rx", "ry"].contains(&key) && length.number < 0.0 {
                return Err(wrong(key, value, "it is below 0"));
            }
        }
        if let Some(value) = node.attribute("points") {
            let mut count = 0;
            for number in NumberListParser::from(value) {
                let number = number.map_err(|error| wrong("points", value, &error.to_string()))?;
                within([number]).map_err(|why| wrong("points", value, &why))?;
                count += 1;
            }
            if count % 2 == 1 {
                return Err(wrong("points", value, "a number is missing"));
            }
        }
        if let Some(value) = node.attribute("d").filter(|value| value.trim() != "none") {
            for (number, segment) in PathParser::from(value).enumerate() {
                let fault = |why: &str| wrong("d", value, &format!("segment {}: {why}", number + 1));
                let segment = segment.map_err(|error| fault(&error.to_string()))?;
                within(numbers(&segment)).map_err(|why| fault(&why))?;
            }
        }
    }
    Ok(())
}

/// Whether a length is a part of what is around it.
fn is_part(node: Node<'_, '_>, key: &str) -> bool {
    node.attribute(key).is_some_and(|value| value.trim().ends_with('%'))
}

/// A text of the file in a message.
pub fn quoted(text: &str) -> String {
    text.trim().chars().take(40).collect()
}

/// A property of an element: its style, else its attribute.
pub fn property<'a>(node: Node<'a, '_>, key: &str) -> Option<&'a str> {
    let rules = node.attribute("style").unwrap_or("").split(';');
    let mut styles = rules.filter_map(|rule| rule.split_once(':')).filter(|(name, _)| name.trim() == key);
    let value = styles.next_back().map(|(_, value)| value).or(node.attribute(key))?;
    Some(value.trim().trim_end_matches("!important").trim_end())
}

/// A value that is no length.
fn is_keyword(value: &str) -> bool {
    ["none", "inherit", "initial", "unset"].contains(&value)
}

/// Shapes whose dashes are not in units of their own coordinates: their ids, and what says so.
pub fn foreign_dashes(document: &Document<'_>) -> HashMap<String, &'static str> {
    let foreign = |node: Node<'_, '_>| {
        let is_fixed = property(node, "vector-effect") == Some("non-scaling-stroke");
        let why = if is_fixed { Some("vector-effect") } else { None };
        let why = why.or_else(|| node.attribute("pathLength").map(|_| "pathLength"));
        Some((node.attribute("id")?.to_owned(), why?))
    };
    document.root_element().descendants().filter_map(foreign).collect()
}

/// Strokes of no width, which SVG does not draw, though some programs show them as hairlines.
pub fn thin(document: &Document<'_>) -> Option<String> {
    let is_zero = |width: &str| Length::from_str(width.trim()).is_ok_and(|width| width.number == 0.0);
    let is_thin = |node: &Node<'_, '_>| property(*node, "stroke-width").is_some_and(is_zero);
    let count = document.root_element().descendants().filter(is_thin).count();
    (count > 0).then(|| format!("a stroke-width of 0 is no stroke, and is not marked: give it a width ({count})"))
}

/// Ids of shapes whose stroke is that of a marker's path or of a `use`, and that are in neither.
pub fn strokes_without_context(document: &Document<'_>) -> HashSet<String> {
    if !document.input_text().contains("context-") {
        return HashSet::new();
    }
    let is_hidden_by_any = |node: Node<'_, '_>| node.ancestors().any(|around| is_hidden(around, false));
    let is_of_context = |node: &Node<'_, '_>| {
        let strokes = node.ancestors().filter_map(|around| property(around, "stroke"));
        strokes.into_iter().find(|value| *value != "inherit").is_some_and(|value| value.starts_with("context-"))
    };
    let shapes = document.root_element().descendants().filter(|node| SHAPES.contains(&node.tag_name().name()));
    shapes
        .filter(is_of_context)
        .filter(|node| !is_hidden_by_any(*node))
        .filter_map(|node| Some(node.attribute("id")?.to_owned()))
        .collect()
}

/// Whether nothing of an element is drawn.
pub fn is_hidden(node: Node<'_, '_>, used: bool) -> bool {
    let style: String = node.attribute("style").unwrap_or("").chars().filter(|c| !c.is_whitespace()).collect();
    let stored = ["defs", "symbol"].contains(&node.tag_name().name()) && !used;
    let never = ["clipPath", "mask", "pattern", "marker", "metadata", "linearGradient", "radialGradient", "filter"];
    stored
        || never.contains(&node.tag_name().name())
        || node.attribute("display").is_some_and(|value| value.trim() == "none")
        || style.split(';').any(|rule| rule == "display:none")
}

fn within(numbers: impl IntoIterator<Item = f64>) -> Result<(), String> {
    match numbers.into_iter().find(|number| !(-COORDINATE_MAX..=COORDINATE_MAX).contains(number)) {
        Some(number) if number.abs() < 1e9 => Err(format!("{number} is beyond ±{COORDINATE_MAX:.0}")),
        Some(number) => Err(format!("{number:e} is beyond ±{COORDINATE_MAX:.0}")),
        None => Ok(()),
    }
}

fn numbers(segment: &PathSegment) -> [f64; 6] {
    match *segment {
        PathSegment::MoveTo { x, y, .. }
        | PathSegment::LineTo { x, y, .. }
        | PathSegment::SmoothQuadratic { x, y, .. } => [x, y, 0.0, 0.0, 0.0, 0.0],
        PathSegment::HorizontalLineTo { x, .. } => [x, 0.0, 0.0, 0.0, 0.0, 0.0],
        PathSegment::VerticalLineTo { y, .. } => [0.0, y, 0.0, 0.0, 0.0, 0.0],
        PathSegment::CurveTo { x1, y1, x2, y2, x, y, .. } => [x1, y1, x2, y2, x, y],
        PathSegment::SmoothCurveTo { x2, y2, x, y, .. } => [x2, y2, x, y, 0.0, 0.0],
        PathSegment::Quadratic { x1, y1, x, y, .. } => [x1, y1, x, y, 0.0, 0.0],
        PathSegment::EllipticalArc { rx, ry, x_axis_rotation, x, y, .. } => [rx, ry, x_axis_rotation, x, y, 0.0],
        PathSegment::ClosePath { .. } => [0.0; 6],
    }
}
