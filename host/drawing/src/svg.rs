//! SVG to shapes.
//!
//! In: the bytes of a file. Out: what has a stroke, as shapes in mm from the lower left corner of
//! the page, and notes. `usvg` resolves styles, transforms, `use`, units and the viewBox; its
//! coordinates have 24 bits. `check` refuses what it would pass over in silence. Fails with a line,
//! or an id, and the reason.
mod causes;
mod check;
mod clip;
mod dashes;
mod places;
mod sheets;
mod uses;
mod warnings;

use crate::fault::Fault;
use crate::round;
use crate::shape::{Paint, Piece, Point, Shape, add, minus, scaled, size};
use kurbo::{Affine, PathEl, Rect, Shape as _};
use std::collections::{BTreeMap, HashMap, HashSet};
use usvg::roxmltree::{self, Document, ParsingOptions};
use usvg::{Group, Node, Transform, Tree};

/// mm of a px, 1/96 inch.
const MM_PER_PX: f64 = 25.4 / 96.0;
/// Relative error of a coordinate of 24 bits, with one more for its transform.
const ROUNDING_SHARE: f64 = 1.0 / (1 << 23) as f64;
/// A stack on which the deepest file that is taken is read.
const STACK_BYTES: usize = 64 << 20;

/// The shapes of a file; errors without its name.
pub fn read(bytes: &[u8]) -> Result<(Vec<Shape>, Vec<String>), Fault> {
    let worker = std::thread::scope(|scope| {
        let worker = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, || parsed(bytes));
        worker.map(|worker| worker.join())
    });
    match worker {
        Ok(Ok(done)) => done,
        Ok(Err(_)) => Err(Fault::whole("the reader of SVG failed")),
        Err(error) => Err(Fault::whole(format!("no thread for the reader: {error}"))),
    }
}

fn parsed(bytes: &[u8]) -> Result<(Vec<Shape>, Vec<String>), Fault> {
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return Err(Fault::whole("it is compressed (.svgz); decompress it first"));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count() + 1;
        Fault::at(line as u32, "this is not UTF-8 text; an SVG is")
    })?;
    let xml = || ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text.trim_start_matches('\u{feff}'), xml()).map_err(|error| {
        // What is missing is missing at the end.
        let missing = matches!(error, roxmltree::Error::UnexpectedEndOfStream | roxmltree::Error::UnclosedRootNode);
        let line = if missing { text.lines().count().max(1) as u32 } else { error.pos().row };
        Fault::at(line, format!("this is no whole SVG: {}", bare(&error.to_string())))
    })?;
    check::check(&document)?;
    let unshown = uses::check(&document)?;
    let unpainted = sheets::check(&document)?;
    // The same with a name for each shape, so that it is found again in the file.
    let named = places::named(&document);
    let document =
        Document::parse_with_options(&named, xml()).map_err(|error| Fault::whole(bare(&error.to_string())))?;
    let (tree, warnings) = warnings::during("usvg", || Tree::from_xmltree(&document, &options()));
    let tree = tree.map_err(|error| {
        Fault::whole(match error {
            usvg::Error::InvalidSize => {
                let line = document.text_pos_at(document.root_element().range().start).row;
                return Fault::at(line, "its width, height or viewBox is missing, 0 or too large");
            }
            usvg::Error::ElementsLimitReached | usvg::Error::ParsingFailed(_) => {
                "it has more than 1,000,000 elements, or `use` makes so many of it, or they are nested more than 1,000 deep"
                    .to_owned()
            }
            other => other.to_string(),
        })
    })?;
    // Fonts are of texts, which are no marks; a transform of none is none.
    let harmless = ["Failed to parse font", "Failed to parse transform value: 'none'"];
    let warnings = warnings.into_iter().filter(|text| !harmless.iter().any(|begin| text.starts_with(begin)));
    let (skipped, wrong): (Vec<_>, Vec<_>) = warnings.partition(|text| text.ends_with("Skipped."));
    if let Some(wrong) = wrong.first() {
        return Err(causes::fault(&document, wrong));
    }
    let (width, height) = (f64::from(tree.size().width()), f64::from(tree.size().height()));
    let foreign_dashes = check::foreign_dashes(&document);
    let without_context = check::strokes_without_context(&document);
    let mut found = ShapeSearch { width, height, foreign_dashes, without_context, ..ShapeSearch::default() };
    found.group(tree.root(), Map::IDENTITY, "")?;
    let mut notes: Vec<String> = skipped.iter().map(|text| causes::readable(text)).collect();
    notes.extend(unshown);
    notes.extend(unpainted);
    notes.extend(size_note(document.root_element(), [width, height]));
    notes.extend(check::thin(&document));
    notes.extend(found.beyond_note());
    if !found.without_context.is_empty() {
        let count = found.without_context.len();
        notes.push(format!("context-stroke and context-fill are no stroke outside of a marker or a `use` ({count})"));
    }
    notes.extend(found.passed_over.iter().map(|(what, count)| format!("{what} ({count})")));
    Ok((found.shapes, notes))
}

/// A page that does not say how large it is in the world; its size is in px. A viewBox says one of
/// both sizes where the other is given.
fn size_note(root: roxmltree::Node<'_, '_>, size: [f64; 2]) -> Option<String> {
    let [width, height] = ["width", "height"].map(|key| {
        let unit = |text: &str| text.trim().ends_with(|last: char| last.is_ascii_alphabetic());
        root.attribute(key).map(unit)
    });
    let is_said = match (width, height) {
        (Some(width), Some(height)) => width && height,
        (one, other) => one.or(other).is_some_and(|has_unit| has_unit) && root.has_attribute("viewBox"),
    };
    let [width, height] = size.map(|px| px * MM_PER_PX);
    (!is_said).then(|| {
        format!(
            "the page has no width and height with a unit (as width=\"100mm\"): 96 px are an inch, which makes it \
             {width:.3} mm wide and {height:.3} mm high"
        )
    })
}

/// Nothing but the file itself is read, whatever its images name.
fn options() -> usvg::Options<'static> {
    let image_href_resolver =
        usvg::ImageHrefResolver { resolve_data: Box::new(|_, _, _| None), resolve_string: Box::new(|_, _| None) };
    usvg::Options { image_href_resolver, ..usvg::Options::default() }
}

/// An error of the XML reader without its position, which is said otherwise.
fn bare(text: &str) -> String {
    let end = text.rfind(" at ").filter(|at| text[at + 4..].bytes().all(|byte| byte.is_ascii_digit() || byte == b':'));
    let text: String = text[..end.unwrap_or(text.len())].chars().take(160).collect();
    text
}

#[derive(Default)]
struct ShapeSearch {
    /// Of the page, px.
    width: f64,
    height: f64,
    shapes: Vec<Shape>,
    passed_over: BTreeMap<&'static str, usize>,
    /// Shapes that are marked and leave the page: how many, and the first.
    beyond: (usize, String),
    /// Shapes whose dashes have other units, and what says so.
    foreign_dashes: HashMap<String, &'static str>,
    /// Shapes whose stroke is that of what is around them, which has none.
    without_context: HashSet<String>,
    /// Dashes so far, at most.
    dashes: f64,
}

/// What lies so far outside the page is not taken for outside, px.
const PAGE_SLACK_PX: f64 = 0.05;

/// A transform in 64 bits.
#[derive(Debug, Clone, Copy)]
struct Map([f64; 6]);

impl Map {
    fn of(t: Transform) -> Map {
        Map([t.sx, t.ky, t.kx, t.sy, t.tx, t.ty].map(f64::from))
    }

    const IDENTITY: Map = Map([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);

    /// This, and what is around it.
    fn within(&self, outer: &Map) -> Map {
        Map((Affine::new(outer.0) * Affine::new(self.0)).as_coeffs())
    }

    /// The least rectangle around a path; none around one that draws nothing.
    fn bounds(&self, elements: &[PathEl]) -> Option<Rect> {
        let mapped: Vec<PathEl> = elements.iter().map(|element| Affine::new(self.0) * *element).collect();
        let is_drawn = mapped.iter().any(|element| !matches!(element, PathEl::MoveTo(_) | PathEl::ClosePath));
        is_drawn.then(|| (&mapped[..]).bounding_box())
    }

    fn px(&self, [x, y]: Point) -> Point {
        let Map([a, b, c, d, e, f]) = self;
        [a * x + c * y + e, b * x + d * y + f]
    }

    /// Greatest length that a length of 1 may have, at least.
    fn scale(&self) -> f64 {
        let Map([a, b, c, d, ..]) = self;
        a.hypot(*b).max(c.hypot(*d))
    }

    /// What rounding may have moved a point by, px, where coordinates are up to `x` and `y`.
    fn noise(&self, [x, y]: Point) -> f64 {
        let Map([a, b, c, d, e, f]) = self.0.map(f64::abs).into();
        ((a * x + c * y + e).max(b * x + d * y + f)) * ROUNDING_SHARE
    }
}

impl From<[f64; 6]> for Map {
    fn from(entries: [f64; 6]) -> Map {
        Map(entries)
    }
}

impl ShapeSearch {
    fn beyond_note(&self) -> Option<String> {
        let (count, first) = &self.beyond;
        let more = if *count > 1 { format!(" (with it {count} shapes)") } else { String::new() };
        (*count > 0).then(|| format!("{first} leaves the page, and is marked there too{more}"))
    }

    fn pass(&mut self, what: &'static str) {
        *self.passed_over.entry(what).or_insert(0) += 1;
    }

    /// `outer` is the map of what is around it, `around` the place of the nearest element around it
    /// that has one.
    fn group(&mut self, group: &Group, outer: Map, around: &str) -> Result<(), Fault> {
        // `abs_transform` leaves out the transform of a `use` of a symbol, or takes it twice.
        let map = Map::of(group.transform()).within(&outer);
        if group.opacity().get() == 0.0 {
            self.pass("what is fully transparent is not marked");
            return Ok(());
        }
        let place = match (group.id(), group.children()) {
            // What is around one shape has the name of that.
            ("", [Node::Path(path)]) => shape_place(path.id(), around),
            ("", _) => around.to_owned(),
            (id, _) => places::place(id),
        };
        let name = match &place[..] {
            "" => "a group",
            _ if group.id().is_empty() || !place.starts_with('`') => &place,
            _ => &format!("the group {place}"),
        };
        if group.mask().is_some() {
            return Err(Fault::whole(format!("{name} has a mask, which is not supported: apply it, or remove it")));
        }
        if let Some(clip) = group.clip_path()
            && !clip::covers(clip, group, &map)
        {
            return Err(Fault::whole(format!(
                "{name} is cut by a clip path, which is not supported: cut the shapes, or remove it"
            )));
        }
        if !group.filters().is_empty() {
            self.pass("filters change no marks");
        }
        let around = if group.id().is_empty() { around } else { &place };
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group, map, around)?,
                Node::Path(path) => self.path(path, map, around)?,
                Node::Image(_) => return Err(Fault::whole("an image cannot be marked: trace it, or remove it")),
                Node::Text(_) => return Err(Fault::whole("text cannot be marked: make paths of it")),
            }
        }
        Ok(())
    }

    fn path(&mut self, path: &usvg::Path, map: Map, around: &str) -> Result<(), Fault> {
        let place = shape_place(path.id(), around);
        let Some(stroke) = path.stroke() else {
            if path.fill().is_some() && !self.without_context.contains(path.id()) {
                self.pass("shapes with a fill and no stroke are not marked");
            }
            return Ok(());
        };
        if !path.is_visible() {
            self.pass("what is hidden by its visibility is not marked");
            return Ok(());
        }
        if stroke.opacity().get() == 0.0 {
            self.pass("what is fully transparent is not marked");
            return Ok(());
        }
        let usvg::Paint::Color(colour) = stroke.paint() else {
            let text = format!("the stroke of {place} is a gradient or a pattern: a layer needs one colour");
            return Err(Fault::whole(text));
        };
        let mut elements = dashes::elements(path.data());
        let leaves = self.leaves(path, &elements, &map);
        if let Some(lengths) = stroke.dasharray() {
            // What `use` shows has lost its id.
            let any = self.foreign_dashes.values().next().filter(|_| path.id().is_empty());
            if let Some(why) = self.foreign_dashes.get(path.id()).or(any) {
                let text =
                    format!("the dashes of {place} have other units by its {why}, which is not supported: remove that");
                return Err(Fault::whole(text));
            }
            if lengths.iter().step_by(2).any(|dash| *dash == 0.0) {
                self.pass("shapes with dots, which are dashes of length 0: the dots are not marked");
            }
            let pattern = dashes::DashPattern::new(lengths, stroke.dashoffset(), map.scale());
            self.dashes += pattern.count_max(&elements);
            if self.dashes > dashes::MAX_DASHES {
                let most = dashes::MAX_DASHES;
                let text = format!("with the dashes of {place} there are more than {most}: make them longer");
                return Err(Fault::whole(text));
            }
            elements = pattern.cut(&elements);
        }
        if leaves {
            self.beyond.0 += 1;
            if self.beyond.0 == 1 {
                self.beyond.1.clone_from(&place);
            }
        }
        let paint = Paint { colour: [colour.red, colour.green, colour.blue], index: None, layer: None };
        self.outline(path, (&elements, map), &Pen { paint, place });
        Ok(())
    }

    /// Whether a path leaves the page.
    fn leaves(&self, path: &usvg::Path, elements: &[PathEl], map: &Map) -> bool {
        let is_within = |[x, y]: Point| {
            let far = [(x, self.width), (y, self.height)];
            far.into_iter().all(|(at, most)| (-PAGE_SLACK_PX..=most + PAGE_SLACK_PX).contains(&at))
        };
        let bounds = path.bounding_box();
        let (left, right) = (f64::from(bounds.left()), f64::from(bounds.right()));
        let (top, bottom) = (f64::from(bounds.top()), f64::from(bounds.bottom()));
        let corners = [[left, top], [right, top], [left, bottom], [right, bottom]];
        if corners.into_iter().all(|corner| is_within(map.px(corner))) {
            return false;
        }
        let Some(bounds) = map.bounds(elements) else { return false };
        ![[bounds.x0, bounds.y0], [bounds.x1, bounds.y1]].into_iter().all(is_within)
    }

    /// What is drawn of a path: all of it, or its dashes.
    fn outline(&mut self, path: &usvg::Path, (elements, map): (&[PathEl], Map), pen: &Pen) {
        let bounds = path.data().bounds();
        let far = |a: f32, b: f32| f64::from(a.abs().max(b.abs()));
        let noise = map.noise([far(bounds.left(), bounds.right()), far(bounds.top(), bounds.bottom())]);
        let noise = (noise + self.height * ROUNDING_SHARE) * MM_PER_PX + 1e-9;
        let height = self.height;
        let mm = |p: kurbo::Point| {
            let [x, y] = map.px([p.x, p.y]);
            [x * MM_PER_PX, (height - y) * MM_PER_PX]
        };
        let mut open: Option<Shape> = None;
        let mut at = [0.0; 2];
        for element in elements {
            let begin =
                |start: Point| Shape { start, pieces: Vec::new(), paint: pen.paint.clone(), place: pen.place.clone() };
            match *element {
                PathEl::MoveTo(point) => {
                    self.finish(open.take(), noise, false);
                    at = mm(point);
                    open = Some(begin(at));
                    continue;
                }
                PathEl::ClosePath => {
                    if let Some(shape) = open.take() {
                        at = shape.start;
                        self.finish(Some(shape), noise, true);
                    }
                    continue;
                }
                _ => {}
            }
            let shape = open.get_or_insert_with(|| begin(at));
            let piece = match *element {
                PathEl::QuadTo(control, end) => {
                    let (control, end) = (mm(control), mm(end));
                    let third = |from: Point| add(from, scaled(minus(control, from), 2.0 / 3.0));
                    Piece::Cubic(third(at), third(end), end)
                }
                PathEl::CurveTo(a, b, end) => {
                    let p = [at, mm(a), mm(b), mm(end)];
                    round::arc(p, noise).unwrap_or(Piece::Cubic(p[1], p[2], p[3]))
                }
                PathEl::LineTo(end) => Piece::Line(mm(end)),
                PathEl::MoveTo(_) | PathEl::ClosePath => continue,
            };
            if piece != Piece::Line(at) {
                shape.pieces.push(piece);
            }
            at = piece.end();
        }
        self.finish(open, noise, false);
    }

    /// A shape is complete. One that ends where it began, but for rounding, is closed.
    fn finish(&mut self, shape: Option<Shape>, noise: f64, close: bool) {
        let Some(mut shape) = shape else { return };
        let (start, gap) = (shape.start, size(minus(shape.end(), shape.start)));
        match shape.pieces.last_mut() {
            Some(last) if gap > 0.0 && gap <= 8.0 * noise => match last {
                Piece::Line(end) | Piece::Arc(_, _, end) | Piece::Ellipse(.., end) | Piece::Cubic(_, _, end) => {
                    *end = start;
                }
            },
            _ if close && gap > 0.0 => shape.pieces.push(Piece::Line(start)),
            _ => {}
        }
        if !shape.pieces.is_empty() {
            self.shapes.push(shape);
        }
    }
}

/// What a person calls a shape: what `use` or a marker shows has no id.
fn shape_place(id: &str, around: &str) -> String {
    match around {
        _ if !id.is_empty() => places::place(id),
        "" => places::place(""),
        around => format!("a shape in {around}"),
    }
}

struct Pen {
    paint: Paint,
    place: String,
}
