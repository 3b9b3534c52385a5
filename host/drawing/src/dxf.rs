//! DXF (ASCII) to shapes.
//!
//! In: the bytes of a file. Out: lines, arcs, circles, ellipses, polylines with bulges, splines up
//! to degree 3, and the same in blocks, as shapes in mm from the drawing's origin; notes. `pairs`
//! reads groups, `entity` makes pieces, `join` puts ends together. Fails with the line and the
//! reason.
//!
//! The reader is our own: the crate `dxf` names no lines, and brings decoders of pictures.
mod entity;
mod join;
mod pairs;

use crate::fault::Fault;
use crate::shape::{Paint, Shape, caseless};
use pairs::{Group, Groups};
use std::collections::{BTreeMap, HashMap};

/// Most shapes: blocks may make many of few lines.
const MAX_SHAPES: usize = 1_000_000;
/// Blocks in blocks, at most.
const MAX_BLOCK_DEPTH: usize = 16;

/// A layer of the drawing.
#[derive(Debug, Clone)]
struct LayerRow<'a> {
    /// As it is written; names have no case.
    name: &'a str,
    colour: i16,
    true_colour: Option<u32>,
    /// Why nothing of it is marked.
    unmarked: Option<&'static str>,
}

/// An entity: its groups, those of its vertices too.
#[derive(Debug, Clone)]
struct Entity<'a> {
    kind: &'a str,
    line: u32,
    groups: Vec<Group<'a>>,
    vertices: Vec<Entity<'a>>,
}

#[derive(Default)]
struct Block<'a> {
    base: [f64; 2],
    entities: Vec<Entity<'a>>,
}

/// The shapes of a file.
pub fn read(bytes: &[u8]) -> Result<(Vec<Shape>, Vec<String>), Fault> {
    if bytes.starts_with(b"AutoCAD Binary DXF") {
        return Err(Fault::whole("it is a binary DXF; save it as ASCII"));
    }
    let text = String::from_utf8_lossy(bytes);
    let mut drawing = Drawing { mm: 1.0, ..Drawing::default() };
    drawing.read(&mut Groups::new(&text))?;
    let mut shapes = Vec::new();
    let entities = std::mem::take(&mut drawing.entities);
    let whole = entity::Map::scale(drawing.mm);
    drawing.collect(&entities, whole, None, 0, &mut shapes)?;
    let mut notes = std::mem::take(&mut drawing.notes);
    notes.extend(drawing.passed_over.iter().map(|(what, count)| format!("{what} ({count})")));
    Ok((join::join(shapes), notes))
}

#[derive(Default)]
struct Drawing<'a> {
    /// mm of a unit.
    mm: f64,
    /// By their names without case.
    layers: HashMap<String, Vec<LayerRow<'a>>>,
    blocks: HashMap<&'a str, Block<'a>>,
    /// The names of the blocks by what they are without case.
    block_names: HashMap<String, &'a str>,
    entities: Vec<Entity<'a>>,
    notes: Vec<String>,
    passed_over: BTreeMap<&'static str, usize>,
}

impl<'a> Drawing<'a> {
    fn read(&mut self, groups: &mut Groups<'a>) -> Result<(), Fault> {
        let mut unit = None;
        let mut seen = false;
        loop {
            let group = groups.expect("the file ends before its EOF")?;
            match (group.code, group.value) {
                (0, "EOF") => break,
                (0, "SECTION") => {
                    seen = true;
                    let name = groups.expect("a section has no name")?;
                    match name.value {
                        "HEADER" => unit = header(groups)?.or(unit),
                        "TABLES" => self.tables(groups)?,
                        "BLOCKS" => self.blocks(groups)?,
                        "ENTITIES" => self.entities = entities(groups, "ENDSEC")?,
                        _ => skip(groups)?,
                    }
                }
                (999, _) => {}
                _ => return Err(Fault::at(group.line, "this is no DXF: a section was expected")),
            }
        }
        if !seen {
            return Err(Fault::whole("it has no section"));
        }
        self.mm = match unit {
            None | Some(0) => {
                self.notes.push("it names no unit: mm are taken".to_owned());
                1.0
            }
            Some(1) => 25.4,
            Some(2) => 304.8,
            Some(4) => 1.0,
            Some(5) => 10.0,
            Some(6) => 1000.0,
            Some(9) => 0.0254,
            Some(10) => 914.4,
            Some(13) => 0.001,
            Some(14) => 100.0,
            Some(other) => {
                return Err(Fault::whole(format!(
                    "its unit ($INSUNITS {other}) is none of mm, cm, m, inch, foot, mil"
                )));
            }
        };
        Ok(())
    }

    fn tables(&mut self, groups: &mut Groups<'a>) -> Result<(), Fault> {
        for row in entities(groups, "ENDSEC")? {
            if row.kind == "LAYER" {
                let name = row.text(2).unwrap_or("0");
                let colour = row.whole(62)?.unwrap_or(7);
                let is_hidden = colour < 0 || row.whole(70)?.unwrap_or(0) & 1 == 1;
                let unmarked = match row.whole(290)? {
                    _ if is_hidden => Some("what is on a layer that is off or frozen is not marked"),
                    Some(0) => Some("what is on a layer that is not plotted is not marked"),
                    _ => None,
                };
                let true_colour = row.whole(420)?.map(|rgb| rgb as u32);
                let colour = colour.unsigned_abs() as i16;
                let rows = self.layers.entry(caseless(name).collect()).or_default();
                rows.push(LayerRow { name, colour, true_colour, unmarked });
            }
        }
        Ok(())
    }

    fn blocks(&mut self, groups: &mut Groups<'a>) -> Result<(), Fault> {
        loop {
            let group = groups.expect("the file ends in its blocks")?;
            match (group.code, group.value) {
                (0, "ENDSEC") => return Ok(()),
                (0, "BLOCK") => {
                    let mut all = entities(groups, "ENDBLK")?.into_iter();
                    // What stands before the first entity is the head of the block.
                    let Some(head) = all.next() else { continue };
                    let base = [head.real(10)?.unwrap_or(0.0), head.real(20)?.unwrap_or(0.0)];
                    if let Some(name) = head.text(2) {
                        self.block_names.entry(caseless(name).collect()).or_insert(name);
                        self.blocks.insert(name, Block { base, entities: all.collect() });
                    }
                }
                _ => {}
            }
        }
    }

    /// The layer of this name: of several that differ in case, the one that is written so, else one
    /// that is not marked.
    fn layer(&self, name: &str) -> Option<&LayerRow<'a>> {
        let rows = self.layers.get(&caseless(name).collect::<String>())?;
        rows.iter().max_by_key(|row| (row.name == name, row.unmarked.is_some()))
    }

    fn pass(&mut self, what: &'static str) {
        *self.passed_over.entry(what).or_insert(0) += 1;
    }

    /// The shapes of entities; `by_block` is the paint of the block that they are in.
    fn collect(
        &mut self,
        entities: &[Entity<'a>],
        map: entity::Map,
        by_block: Option<&Paint>,
        depth: usize,
        shapes: &mut Vec<Shape>,
    ) -> Result<(), Fault> {
        for entity in entities {
            if let Some(why) = self.layer(entity.text(8).unwrap_or("0")).and_then(|layer| layer.unmarked) {
                self.pass(why);
                continue;
            }
            if entity.whole(60)? == Some(1) {
                self.pass("what is invisible is not marked");
                continue;
            }
            if entity.whole(67)? == Some(1) {
                self.pass("what is in paper space is not marked");
                continue;
            }
            let paint = self.paint(entity, by_block)?;
            if entity.kind != "INSERT" {
                if entity::is_sloped(entity)? {
                    self.pass("shapes at several Z are marked in the plane of X and Y");
                }
                match entity::shape(entity, &map)? {
                    entity::Found::Shape(start, pieces) if !pieces.is_empty() => {
                        let place = format!("the {} of line {}", entity.kind, entity.line);
                        shapes.push(Shape { start, pieces, paint, place });
                    }
                    entity::Found::Shape(..) => self.pass("what has no length is not marked"),
                    entity::Found::Point => self.pass("points are not marked"),
                    entity::Found::Nothing => {}
                }
                if shapes.len() > MAX_SHAPES {
                    return Err(Fault::at(entity.line, format!("blocks make more than {MAX_SHAPES} shapes of it")));
                }
                continue;
            }
            let name = entity.text(2).unwrap_or("");
            if depth == MAX_BLOCK_DEPTH {
                return Err(Fault::at(
                    entity.line,
                    format!("blocks are in one another more than {MAX_BLOCK_DEPTH} deep"),
                ));
            }
            // Of two names that differ in case, the one that is written so.
            let key = match self.block_names.get(&caseless(name).collect::<String>()) {
                Some(other) if !self.blocks.contains_key(name) => other,
                _ => name,
            };
            let Some(block) = self.blocks.remove(key) else {
                let name: String = name.chars().take(40).collect();
                let why = format!("the block `{name}` does not exist, or is in itself");
                return Err(Fault::at(entity.line, why));
            };
            let inner = entity::insert(entity, block.base, &map)?;
            let done = self.collect(&block.entities, inner, Some(&paint), depth + 1, shapes);
            self.blocks.insert(key, block);
            done?;
        }
        Ok(())
    }

    fn paint(&self, entity: &Entity<'a>, by_block: Option<&Paint>) -> Result<Paint, Fault> {
        let own = entity.text(8).unwrap_or("0");
        // In a block, layer 0 is that of the block.
        let (name, by_layer) = match by_block {
            Some(paint) if own == "0" => (paint.layer.clone().unwrap_or_default(), None),
            _ => (own.to_owned(), self.layer(own)),
        };
        let index = entity.whole(62)?.unwrap_or(256) as i16;
        let true_colour = entity.whole(420)?.map(|rgb| rgb as u32);
        let (index, true_colour) = match (index, by_block) {
            _ if true_colour.is_some() => (index, true_colour),
            (0, Some(block)) => return Ok(Paint { layer: Some(name), ..block.clone() }),
            (256, Some(block)) if by_layer.is_none() && own == "0" => {
                return Ok(Paint { layer: Some(name), ..block.clone() });
            }
            (256 | 0, _) => by_layer.map_or((7, None), |layer| (layer.colour, layer.true_colour)),
            other => (other.0, None),
        };
        let index = if (1..=255).contains(&index) { Some(index) } else { None };
        let colour = match true_colour {
            Some(rgb) => [(rgb >> 16) as u8, (rgb >> 8) as u8, rgb as u8],
            None => rgb_of(index.unwrap_or(7)),
        };
        Ok(Paint { colour, index: if true_colour.is_some() { None } else { index }, layer: Some(name) })
    }
}

/// The colours of AutoCAD that all programs show alike; others have a number only.
fn rgb_of(index: i16) -> [u8; 3] {
    match index {
        1 => [255, 0, 0],
        2 => [255, 255, 0],
        3 => [0, 255, 0],
        4 => [0, 255, 255],
        5 => [0, 0, 255],
        6 => [255, 0, 255],
        8 => [128, 128, 128],
        9 => [192, 192, 192],
        _ => [0, 0, 0],
    }
}

/// The unit, of the header.
fn header(groups: &mut Groups<'_>) -> Result<Option<i64>, Fault> {
    let mut unit = None;
    loop {
        let group = groups.expect("the file ends in its header")?;
        match (group.code, group.value) {
            (0, "ENDSEC") => return Ok(unit),
            (9, "$INSUNITS") => unit = Some(groups.expect("$INSUNITS has no value")?.whole()?),
            _ => {}
        }
    }
}

fn skip(groups: &mut Groups<'_>) -> Result<(), Fault> {
    loop {
        let group = groups.expect("the file ends in a section")?;
        if (group.code, group.value) == (0, "ENDSEC") {
            return Ok(());
        }
    }
}

/// Entities up to the end of the section or of the block. What stands before the first one is one
/// without a kind.
fn entities<'a>(groups: &mut Groups<'a>, end: &str) -> Result<Vec<Entity<'a>>, Fault> {
    let mut all: Vec<Entity<'a>> = Vec::new();
    loop {
        let group = groups.expect("the file ends among its entities")?;
        if group.code == 0 {
            if group.value == end {
                if end == "ENDBLK" {
                    // Its own groups, up to what is next.
                    groups.skip_body();
                }
                return Ok(all);
            }
            let entity = Entity { kind: group.value, line: group.line, groups: Vec::new(), vertices: Vec::new() };
            match (group.value, all.last_mut()) {
                ("VERTEX", Some(polyline)) if polyline.kind == "POLYLINE" => polyline.vertices.push(entity),
                _ => all.push(entity),
            }
            continue;
        }
        if all.is_empty() {
            all.push(Entity { kind: "", line: group.line, groups: Vec::new(), vertices: Vec::new() });
        }
        if let Some(last) = all.last_mut() {
            match last.vertices.last_mut() {
                Some(vertex) => vertex.groups.push(group),
                None => last.groups.push(group),
            }
        }
    }
}

impl<'a> Entity<'a> {
    fn text(&self, code: i32) -> Option<&'a str> {
        self.groups.iter().find(|group| group.code == code).map(|group| group.value)
    }

    fn real(&self, code: i32) -> Result<Option<f64>, Fault> {
        self.groups.iter().find(|group| group.code == code).map(Group::real).transpose()
    }

    fn whole(&self, code: i32) -> Result<Option<i64>, Fault> {
        self.groups.iter().find(|group| group.code == code).map(Group::whole).transpose()
    }

    /// A number that must be there.
    fn needs(&self, code: i32) -> Result<f64, Fault> {
        self.real(code)?.ok_or_else(|| Fault::at(self.line, format!("a {} has no group {code}", self.kind)))
    }
}
