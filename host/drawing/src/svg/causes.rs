//! Where in the file the cause of a warning of `usvg` is, which names none or one that it was given
//! here.
//!
//! In: the file with a name for each shape, a warning. Out: an error with the line, where one
//! element alone can be the cause; with the lines of a few; without one, if a style sheet may be
//! the cause. Fails never.
use super::check::{property, quoted};
use super::places::MADE;
use crate::fault::Fault;
use usvg::roxmltree::{Document, Node};

/// Lines that are named at most.
const NAMED_MAX: usize = 6;
/// What a warning speaks of, and the property that is its cause.
const PROPERTIES: [(&str, &str); 5] = [
    ("Filter", "filter"),
    ("Mask", "mask"),
    ("Clipping", "clip-path"),
    ("used to stroke", "stroke"),
    ("used to fill", "fill"),
];

/// The error that a warning is.
pub fn fault(document: &Document<'_>, warning: &str) -> Fault {
    let line = |node: Node<'_, '_>| document.text_pos_at(node.range().start).row;
    let elements = || document.root_element().descendants().filter(Node::is_element);
    if let Some((key, value)) = unread_value(warning) {
        let text = format!("{key} is `{}`, which cannot be read", quoted(value));
        let found = elements().find(|node| property(*node, key).is_some_and(|own| own == value.trim()));
        return match found {
            Some(node) => Fault::at(line(node), format!("<{}>: {text}", node.tag_name().name())),
            None => Fault::whole(text),
        };
    }
    let text = readable(warning).trim_end_matches('.').to_owned();
    let named = warning.split('\'').skip(1).step_by(2);
    let by_id = named.into_iter().find_map(|id| elements().find(|node| node.attribute("id") == Some(id)));
    if let Some(node) = by_id {
        return Fault::at(line(node), text);
    }
    let Some((_, key)) = PROPERTIES.into_iter().find(|(part, _)| warning.contains(part)) else {
        return Fault::whole(text);
    };
    let in_sheet =
        |node: Node<'_, '_>| node.has_tag_name("style") && node.text().is_some_and(|text| text.contains(key));
    if elements().any(in_sheet) {
        return Fault::whole(text);
    }
    let is_cause = |node: &Node<'_, '_>| property(*node, key).is_some_and(|value| value.contains("url("));
    let lines: Vec<u32> = elements().filter(is_cause).map(line).collect();
    match lines[..] {
        [] => Fault::whole(text),
        [line] => Fault::at(line, text),
        _ => {
            let few: Vec<String> = lines.iter().take(NAMED_MAX).map(u32::to_string).collect();
            let more = if lines.len() > NAMED_MAX { ", …" } else { "" };
            Fault::whole(format!("{text}: one of the elements with a {key}, of lines {}{more}", few.join(", ")))
        }
    }
}

/// The property that a warning says cannot be read, and its value.
fn unread_value(warning: &str) -> Option<(&str, &str)> {
    let (key, rest) = warning.strip_prefix("Failed to parse ")?.split_once(" value: '")?;
    Some((key, rest.rsplit_once('\'')?.0))
}

/// A warning with lines for the names that were given to shapes here.
pub fn readable(warning: &str) -> String {
    let mut text = warning.to_owned();
    while let Some(begin) = text.find(&format!("'{MADE}")) {
        let end = text[begin + 1..].find('\'').map_or(text.len(), |at| begin + at + 2);
        let line = text[begin..end].trim_end_matches('\'').rsplit(':').next().unwrap_or("").to_owned();
        text.replace_range(begin..end, &format!("(line {line})"));
    }
    text
}
