//! Clip paths that cut nothing: programs put the page around all that they write.
use super::{Map, dashes};
use crate::shape::Point;
use kurbo::Rect;
use usvg::tiny_skia_path::PathSegment;
use usvg::{ClipPath, Group, Node};

/// What lies so far outside is not taken for cut, px.
const SLACK_PX: f64 = 0.01;

/// Whether a clip path is a rectangle that has all of the group within; `map` is that of the group.
pub fn covers(clip: &ClipPath, group: &Group, map: &Map) -> bool {
    if clip.clip_path().is_some() {
        return false;
    }
    let [Node::Path(path)] = clip.root().children() else { return false };
    let mut corners: Vec<Point> = Vec::new();
    for segment in path.data().segments() {
        match segment {
            PathSegment::MoveTo(p) | PathSegment::LineTo(p) => corners.push([p.x.into(), p.y.into()]),
            PathSegment::Close => {}
            PathSegment::QuadTo(..) | PathSegment::CubicTo(..) => return false,
        }
    }
    if corners.len() == 5 && corners.first() == corners.last() {
        corners.pop();
    }
    // In coordinates of the group, as the clip is.
    let own = Map::of(clip.root().transform()).within(&Map::of(clip.transform()));
    let corners: Vec<Point> = corners.into_iter().map(|corner| own.px(corner)).collect();
    let slack = SLACK_PX / map.scale();
    let [a, b, c, d] = corners[..] else { return false };
    let same = |x: f64, y: f64| (x - y).abs() <= slack;
    let level = same(a[1], b[1]) && same(b[0], c[0]) && same(c[1], d[1]) && same(d[0], a[0]);
    let upright = same(a[0], b[0]) && same(b[1], c[1]) && same(c[0], d[0]) && same(d[1], a[1]);
    let clip = Rect::from_points((a[0], a[1]), (c[0], c[1])).inflate(slack, slack);
    if !(level || upright) {
        return false;
    }
    // A box of boxes, which is known, may be too large where something is turned.
    let known = group.bounding_box();
    let known = Rect::new(known.left().into(), known.top().into(), known.right().into(), known.bottom().into());
    clip.contains_rect(known) || bounds(group, &Map::IDENTITY).is_none_or(|within| clip.contains_rect(within))
}

/// The least rectangle around what is in a group, whose map is `map`.
fn bounds(group: &Group, map: &Map) -> Option<Rect> {
    let each = group.children().iter().filter_map(|node| match node {
        Node::Group(inner) => bounds(inner, &Map::of(inner.transform()).within(map)),
        Node::Path(path) => map.bounds(&dashes::elements(path.data())),
        Node::Image(_) | Node::Text(_) => None,
    });
    each.reduce(|a, b| a.union(b))
}
