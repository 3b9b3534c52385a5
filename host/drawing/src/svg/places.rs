//! Names of shapes and groups that have no `id`, so that a message can say where in the file they
//! are.
//!
//! In: the elements of a file. Out: its text with an `id` for each such shape, which says element
//! and line, and with an empty `d` for a `d` of `none`, which `usvg` does not know; what a person
//! calls it. Lines stay what they are. Fails never.
use super::check::{SHAPES, SVG};
use usvg::roxmltree::Document;

/// What begins the ids that are made here.
pub const MADE: &str = "beamtick:";

/// Elements that hold shapes: a clip path or a mask of them is named by them.
const GROUPS: [&str; 4] = ["g", "a", "svg", "use"];

/// The text of a file in which every shape, and what holds shapes, has an id.
pub fn named(document: &Document<'_>) -> String {
    let text = document.input_text();
    let mut named = String::with_capacity(text.len() + text.len() / 8);
    let (mut from, mut line, mut counted) = (0, 1usize, 0);
    // What lies before is not the drawing: an entity in the DTD holds elements as a text.
    let root = document.root_element().range().start;
    for node in document.root_element().descendants() {
        let tag = node.tag_name();
        let is_shape = tag.namespace() == Some(SVG) && (SHAPES.contains(&tag.name()) || GROUPS.contains(&tag.name()));
        if !is_shape {
            continue;
        }
        let start = node.range().start;
        let begins = text.get(start..).filter(|rest| rest.starts_with('<') && start >= from.max(root));
        let Some(end) = begins.and_then(|rest| rest.find(|c: char| c.is_whitespace() || c == '>' || c == '/')) else {
            continue;
        };
        if !node.has_attribute("id") {
            line += text.get(counted..start).unwrap_or("").matches('\n').count();
            counted = start;
            named.push_str(text.get(from..start + end).unwrap_or(""));
            named.push_str(&format!(" id=\"{MADE}{}:{line}\"", tag.name()));
            from = start + end;
        }
        if let Some(nothing) = node.attribute_node("d").filter(|d| d.value().trim() == "none") {
            let value = nothing.range_value();
            named.push_str(text.get(from..value.start).unwrap_or(""));
            from = value.end;
        }
    }
    named.push_str(text.get(from..).unwrap_or(""));
    named
}

/// What a person calls the shape of this id.
pub fn place(id: &str) -> String {
    match id.strip_prefix(MADE).and_then(|made| made.split_once(':')) {
        Some((element, line)) => format!("the {element} of line {line}"),
        None if id.is_empty() => "a shape without an id".to_owned(),
        None => format!("`{}`", id.chars().take(80).collect::<String>()),
    }
}
