//! Style sheets and style attributes, of which `usvg` passes over in silence what it does not know.
//!
//! In: the elements of a file. Out: notes about strokes that name nothing. Fails with the line of a
//! `style` element or of the element, and the reason: rules and declarations that `simplecss` does
//! not read, with which `usvg` reads them, properties that `usvg` does not apply, and sheets for
//! other media.
use super::check::{SVG, is_hidden, property, quoted};
use super::warnings;
use crate::fault::Fault;
use simplecss::{Declaration, DeclarationTokenizer, StyleSheet};
use std::collections::HashSet;
use svgtypes::Paint;
use usvg::roxmltree::{Document, Node};

/// Rules that change no marks.
const HARMLESS: [&str; 5] = ["charset", "namespace", "font-face", "keyframes", "page"];
/// Geometry that a style sheet may set.
const GEOMETRY: [&str; 8] = ["d", "cx", "cy", "r", "rx", "ry", "x", "y"];
/// Properties that move or change what is drawn, and that `usvg` does not apply.
const UNAPPLIED: [&str; 6] = ["all", "offset-path", "rotate", "scale", "translate", "zoom"];

/// # Errors
/// See the module text.
pub fn check(document: &Document<'_>) -> Result<Option<String>, Fault> {
    let root = document.root_element();
    let line = |node: Node<'_, '_>| document.text_pos_at(node.range().start).row;
    let is_svg = |node: &Node<'_, '_>| node.tag_name().namespace() == Some(SVG);
    let ids: HashSet<&str> = root.descendants().filter(is_svg).filter_map(|node| node.attribute("id")).collect();
    // Of strokes: a sheet or an element, and what they name.
    let mut nothing: Vec<(Node<'_, '_>, &str)> = Vec::new();
    let dashed = document.input_text().contains("stroke-dasharray");
    for node in root.descendants().filter(|node| is_sheet(*node)) {
        let fault = |why: String| Fault::at(line(node), format!("<style>: {why}"));
        for declaration in sheet(node).map_err(fault)? {
            if dashed && declaration.name == "vector-effect" && declaration.value != "none" {
                let why = "vector-effect in a style sheet, with dashes, is not supported: remove it";
                return Err(fault(why.to_owned()));
            }
            if let Some(id) = unnamed(declaration.value, &ids).filter(|_| declaration.name == "stroke") {
                nothing.push((node, id));
            }
        }
    }
    let mut hidden: Option<Node<'_, '_>> = None;
    for node in root.descendants().filter(is_svg) {
        // As descendants follow, those of a hidden element follow it.
        if hidden.is_some_and(|hidden| node.range().start < hidden.range().end) {
            continue;
        }
        hidden = Some(node).filter(|node| is_hidden(*node, true));
        if hidden.is_some() {
            continue;
        }
        let name = node.tag_name().name();
        let fault = |why: String| Fault::at(line(node), format!("<{name}>: {why}"));
        styled(node).map_err(fault)?;
        let id = property(node, "stroke").and_then(|value| unnamed(value, &ids));
        nothing.extend(id.map(|id| (node, id)));
    }
    let Some((node, id)) = nothing.first() else { return Ok(None) };
    let place = if is_sheet(*node) { "the style sheet of line" } else { "line" };
    let place = format!("{place} {}", line(*node));
    let more = if nothing.len() > 1 { format!(" (with it {} strokes)", nothing.len()) } else { String::new() };
    Ok(Some(format!("the stroke of {place} names `#{}`, which does not exist, and is not marked{more}", quoted(id))))
}

/// Whether `usvg` reads it.
fn is_sheet(node: Node<'_, '_>) -> bool {
    node.has_tag_name("style") && node.attribute("type").is_none_or(|kind| kind == "text/css")
}

/// What a paint names, where that does not exist and no other paint is given.
fn unnamed<'a>(value: &'a str, ids: &HashSet<&str>) -> Option<&'a str> {
    match Paint::from_str(value) {
        Ok(Paint::FuncIRI(id, None)) if !ids.contains(id) => Some(id),
        _ => None,
    }
}

/// What a `style` element declares, whatever it is for.
fn sheet<'a>(node: Node<'a, '_>) -> Result<Vec<Declaration<'a>>, String> {
    let media = node.attribute("media").unwrap_or("");
    if !media.split(',').any(|one| ["", "all", "screen"].contains(&&one.trim().to_ascii_lowercase()[..])) {
        return Err(format!("media is `{}`, which is not supported: remove it, or the style sheet", quoted(media)));
    }
    let texts = node.children().filter_map(|part| if part.is_text() { part.text() } else { None });
    let read = node.text().unwrap_or("");
    if texts.filter(|text| !text.trim().is_empty()).any(|text| text != read) {
        return Err("an XML comment cuts it, and what follows that is lost: remove the comment".to_owned());
    }
    let mut declared = Vec::new();
    for rule in rules(read) {
        let head = rule.head.trim();
        if let Some(at) = head.strip_prefix('@') {
            let name: String = at.chars().take_while(|c| c.is_alphanumeric() || *c == '-').collect();
            let plain = ["-webkit-", "-moz-", "-o-", "-ms-"].iter().find_map(|maker| name.strip_prefix(maker));
            if !HARMLESS.contains(&plain.unwrap_or(&name)) {
                let what = quoted(&format!("@{name}"));
                return Err(format!("`{what}` is not supported: remove it, or write its rules without it"));
            }
            continue;
        }
        let Some(block) = rule.block else {
            return Err(format!("`{}` is no whole rule", quoted(head)));
        };
        let alone = format!("{head}{{x:y}}");
        let (known, said) = warnings::during("simplecss", || StyleSheet::parse(&alone).rules.len());
        if known == 0 || !said.is_empty() {
            let head = quoted(head);
            return Err(format!("the selector `{head}` is not supported: name elements, classes or ids"));
        }
        let nested = block.contains('{').then(|| block.to_owned());
        if let Some(lost) = nested.or_else(|| unread(block)) {
            return Err(format!("`{}` cannot be read: remove it", quoted(&lost)));
        }
        declared.extend(DeclarationTokenizer::from(block));
    }
    let (_, said) = warnings::during("simplecss", || StyleSheet::parse(read));
    if said.iter().any(|why| !why.starts_with("The @")) {
        return Err("a part of it is not understood: leave nothing but plain rules in it".to_owned());
    }
    for Declaration { name, value, .. } in &declared {
        let is_size = ["width", "height"].contains(name) && !["100%", "auto"].contains(value);
        if is_size || GEOMETRY.contains(name) {
            return Err(format!("{name} in a style sheet is not supported: make it an attribute"));
        }
        applied(name, value)?;
    }
    Ok(declared)
}

/// Whether the style of an element says what is not supported.
fn styled(node: Node<'_, '_>) -> Result<(), String> {
    if let Some(value) = property(node, "transform-box") {
        box_of("transform-box", value)?;
    }
    let Some(style) = node.attribute("style") else { return Ok(()) };
    if let Some(lost) = unread(style) {
        return Err(format!("`{}` in its style cannot be read: remove it", quoted(&lost)));
    }
    let geometry: &[&str] = match node.tag_name().name() {
        "path" => &["d"],
        "circle" => &["cx", "cy", "r"],
        "ellipse" => &["cx", "cy", "rx", "ry"],
        "rect" => &["x", "y", "width", "height", "rx", "ry"],
        "svg" if node.parent_element().is_some() => &["x", "y", "width", "height"],
        "use" => &["x", "y", "width", "height"],
        _ => &[],
    };
    for Declaration { name, value, .. } in DeclarationTokenizer::from(style) {
        if geometry.contains(&name) {
            return Err(format!("{name} in a style is not supported: make it an attribute"));
        }
        applied(name, value)?;
    }
    Ok(())
}

/// Whether `usvg` does what a declaration says.
fn applied(name: &str, value: &str) -> Result<(), String> {
    if name.bytes().any(|byte| byte.is_ascii_uppercase()) {
        return Err(format!("`{}` has capitals, and is not read: write it in small letters", quoted(name)));
    }
    let is_none = name != "all" && ["none", "normal", "initial", "unset"].contains(&value);
    if UNAPPLIED.contains(&name) && !is_none {
        return Err(format!("{name} in a style is not supported: apply it, or remove it"));
    }
    box_of(name, value)
}

/// Transforms are those of the page here.
fn box_of(name: &str, value: &str) -> Result<(), String> {
    if name != "transform-box" || ["view-box", "initial", "unset"].contains(&value.trim()) {
        return Ok(());
    }
    Err(format!("transform-box is `{}`, which is not supported: apply the transform, or remove it", quoted(value)))
}

/// A rule of a sheet: what is before its block, and that.
struct Rule<'a> {
    head: &'a str,
    block: Option<&'a str>,
}

/// The rules of a sheet, without comments before them.
fn rules(text: &str) -> Vec<Rule<'_>> {
    let mut found = Vec::new();
    let (mut from, mut opened, mut depth) = (0, 0, 0usize);
    let slice = |from: usize, to: usize| text.get(from..to).unwrap_or("");
    for (at, byte) in plain(text) {
        match byte {
            b'{' => {
                if depth == 0 {
                    opened = at;
                }
                depth += 1;
            }
            b'}' if depth == 1 => {
                found.push(Rule { head: slice(from, opened), block: Some(slice(opened + 1, at)) });
                (from, depth) = (at + 1, 0);
            }
            b'}' => depth = depth.saturating_sub(1),
            b';' if depth == 0 && bare(slice(from, at)).starts_with('@') => {
                found.push(Rule { head: slice(from, at), block: None });
                from = at + 1;
            }
            _ => {}
        }
    }
    match depth {
        // As in CSS, the end of the sheet ends what is open.
        1.. => found.push(Rule { head: slice(from, opened), block: Some(slice(opened + 1, text.len())) }),
        0 => found.push(Rule { head: slice(from, text.len()), block: None }),
    }
    for rule in &mut found {
        rule.head = bare(rule.head);
    }
    found.retain(|rule| !rule.head.is_empty() || rule.block.is_some());
    found
}

/// A text without the comments and the space that it begins with.
fn bare(text: &str) -> &str {
    let mut text = text.trim_start();
    while let Some((_, rest)) = text.strip_prefix("/*").and_then(|rest| rest.split_once("*/")) {
        text = rest.trim_start();
    }
    text
}

/// The bytes of a text that are in no comment, no string and no parentheses, with their places.
fn plain(text: &str) -> impl Iterator<Item = (usize, u8)> + '_ {
    let bytes = text.as_bytes();
    let mut at = 0;
    std::iter::from_fn(move || {
        while let Some(byte) = bytes.get(at) {
            let from = at;
            let rest = &bytes[at + 1..];
            let until =
                |end: &[u8]| rest.windows(end.len()).position(|part| part == end).map(|place| place + end.len());
            at += 1;
            at += match byte {
                b'/' if rest.first() == Some(&b'*') => until(b"*/").unwrap_or(rest.len()),
                b'"' | b'\'' => until(&[*byte]).unwrap_or(rest.len()),
                b'(' => until(b")").unwrap_or(rest.len()),
                _ => return Some((from, *byte)),
            };
        }
        None
    })
}

/// The declaration at which `simplecss` stops, where something that may be of use follows.
fn unread(text: &str) -> Option<String> {
    let ends = plain(text).filter(|(_, byte)| *byte == b';').map(|(at, _)| at);
    if bare(text).starts_with(';') {
        return Some(text.to_owned());
    }
    let mut from = 0;
    let mut parts = Vec::new();
    for end in ends.chain([text.len()]) {
        parts.push(uncommented(text.get(from..end).unwrap_or("")));
        from = end + 1;
    }
    parts.retain(|part| !part.is_empty());
    let is_read = |part: &String| {
        let mut read = DeclarationTokenizer::from(&part[..]);
        let Some(one) = read.next() else { return false };
        part.ends_with(one.value) || one.important && part.ends_with("important")
    };
    let place = parts.iter().position(|part| !is_read(part))?;
    let matters = |name: &str| {
        ["stroke", "transform", "display", "visibility", "opacity"].iter().any(|key| name.starts_with(key))
    };
    let is_last = place + 1 == parts.len();
    (!is_last || matters(&parts[place])).then(|| parts.swap_remove(place))
}

/// A text without comments.
fn uncommented(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("/*") {
        plain.push_str(before);
        rest = after.split_once("*/").map_or("", |(_, after)| after);
    }
    plain.push_str(rest);
    plain.trim().to_owned()
}
