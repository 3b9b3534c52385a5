//! What `use` shows, where `usvg` says nothing or not where.
//!
//! In: the elements of a file. Out: a note about those that show nothing. Fails with the line of
//! one that shows itself, or what another file has, or a symbol at a size in %.
use super::check::{SVG, is_hidden, property, quoted};
use crate::fault::Fault;
use std::collections::HashMap;
use std::str::FromStr;
use usvg::roxmltree::{Document, Node};

const XLINK: &str = "http://www.w3.org/1999/xlink";

/// What a `use` names; the plain attribute goes before that of XLink.
fn href<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    let of = |space: Option<&str>| node.attributes().find(|one| one.name() == "href" && one.namespace() == space);
    of(None).or_else(|| of(Some(XLINK))).map(|one| one.value().trim())
}

/// # Errors
/// See the module text.
pub fn check(document: &Document<'_>) -> Result<Option<String>, Fault> {
    let root = document.root_element();
    let is_use = |node: &Node<'_, '_>| node.has_tag_name((SVG, "use"));
    let uses: Vec<Node<'_, '_>> = root.descendants().filter(is_use).collect();
    let ids: HashMap<&str, Node<'_, '_>> = match uses.is_empty() {
        true => HashMap::new(),
        false => root.descendants().filter_map(|node| Some((node.attribute("id")?, node))).collect(),
    };
    let line = |node: Node<'_, '_>| document.text_pos_at(node.range().start).row;
    let is_drawn = |node: Node<'_, '_>| !node.ancestors().any(|around| is_hidden(around, true));
    let mut nothing: Vec<(u32, String)> = Vec::new();
    let mut targets = Vec::with_capacity(uses.len());
    for node in &uses {
        let target = href(*node).unwrap_or("");
        let id = target.strip_prefix('#');
        let found = id.and_then(|id| ids.get(id));
        targets.push(found.copied());
        if !is_drawn(*node) {
            continue;
        }
        if let Some(symbol) = found {
            let name = format!("<use> of the symbol `{}`", quoted(id.unwrap_or("")));
            let part = symbol.has_tag_name((SVG, "symbol")).then(|| percentage(*node)).flatten();
            if let Some(key) = part {
                let article = if key == "x" { "an" } else { "a" };
                let why = format!("{name} has {article} {key} in %, which is not supported: give it in px or mm");
                return Err(Fault::at(line(*node), why));
            }
            if symbol.has_tag_name((SVG, "symbol"))
                && let Some(why) = passed_over(*node, *symbol)
            {
                return Err(Fault::at(line(*node), format!("{name} {why}")));
            }
            continue;
        }
        nothing.push(match id {
            Some(id) => (line(*node), format!("`#{}`, which does not exist", quoted(id))),
            None if target.is_empty() => (line(*node), "nothing: it has no href".to_owned()),
            None => {
                let shown = quoted(target);
                let why = format!("<use> shows `{shown}` of another file, which is not read: copy it into this one");
                return Err(Fault::at(line(*node), why));
            }
        });
    }
    if let Some(node) = in_itself(&uses, &targets) {
        return Err(Fault::at(line(node), "<use> shows itself, by what it names: name another element"));
    }
    let Some((line, what)) = nothing.first() else { return Ok(None) };
    let more = if nothing.len() > 1 { format!(" (with it {} show nothing)", nothing.len()) } else { String::new() };
    Ok(Some(format!("the use of line {line} shows {what}{more}")))
}

/// What of the size of a `use` of a symbol is in parts of what is around it: `usvg` takes those
/// twice, and x and y for the clip in parts of the size.
fn percentage(node: Node<'_, '_>) -> Option<&'static str> {
    let part = |key: &str| {
        let value = node.attribute(key)?.trim().strip_suffix('%')?;
        value.trim().parse::<f64>().ok()
    };
    let taken_twice = |key: &&str| part(key).is_some_and(|part| part != 100.0);
    let off = |(key, size): &(&str, &str)| node.has_attribute(*size) && part(key).is_some_and(|part| part != 0.0);
    let place = || [("x", "width"), ("y", "height")].into_iter().find(off).map(|(key, _)| key);
    ["width", "height"].into_iter().find(taken_twice).or_else(place)
}

/// What else of a `use` of a symbol, or of that, `usvg` passes over.
fn passed_over(node: Node<'_, '_>, symbol: Node<'_, '_>) -> Option<String> {
    let is_number = |value: &str| value.trim().starts_with(|first: char| "+-.0123456789".contains(first));
    let size = |of: Node<'_, '_>, key: &str| of.attribute(key).map(str::to_owned).filter(|value| is_number(value));
    let is_nested = node.ancestors().skip(1).any(|around| around.has_tag_name((SVG, "symbol")));
    for key in ["width", "height"] {
        let own = size(node, key);
        let number = own.as_deref().and_then(|value| svgtypes::Length::from_str(value.trim()).ok());
        if number.is_some_and(|length| length.number <= 0.0) {
            return Some(format!("has a {key} of 0 or less, and is not drawn: remove it"));
        }
        if is_nested && own.as_ref().is_none_or(|value| value.trim().ends_with('%')) {
            return Some(format!("in another symbol has no {key} of its own: give it one in px or mm"));
        }
        if own.is_none() && size(symbol, key).is_some_and(|value| value.trim() != "100%") {
            return Some(format!("has the {key} of that, which is not supported: give it one of its own"));
        }
    }
    let moved = property(symbol, "transform").is_some_and(|value| value.trim() != "none");
    moved.then(|| "has a transform in that, which is not supported: put it on the use".to_owned())
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Walk {
    New,
    /// What it shows is being walked.
    Open,
    Done,
}

/// A `use` that is within what it shows, or what that shows.
fn in_itself<'a, 'i>(uses: &[Node<'a, 'i>], targets: &[Option<Node<'a, 'i>>]) -> Option<Node<'a, 'i>> {
    // Nodes are numbered in the order of the file: those within a target follow each other.
    let within = |place: usize| {
        let Some(target) = targets[place] else { return 0..0 };
        let after = target.ancestors().find_map(|around| around.next_sibling());
        let before = |node: Node<'_, '_>| uses.partition_point(|one| one.id().get() < node.id().get());
        before(target)..after.map_or(uses.len(), before)
    };
    let mut found = vec![Walk::New; uses.len()];
    for first in 0..uses.len() {
        if found[first] != Walk::New {
            continue;
        }
        found[first] = Walk::Open;
        let mut walk = vec![(first, within(first))];
        while let Some((place, rest)) = walk.last_mut() {
            match rest.next().map(|inner| (inner, found[inner])) {
                None => {
                    found[*place] = Walk::Done;
                    walk.pop();
                }
                Some((inner, Walk::Open)) => return Some(uses[inner]),
                Some((_, Walk::Done)) => {}
                Some((inner, Walk::New)) => {
                    found[inner] = Walk::Open;
                    walk.push((inner, within(inner)));
                }
            }
        }
    }
    None
}
