//! Clip paths that cut nothing: programs put the page around all that they write.
use super::Map;
use crate::shape::Point;
use usvg::tiny_skia_path::PathSegment;
use usvg::{ClipPath, Group, Node};

/// What lies so far outside is not taken for cut, px.
const SLACK_PX: f64 = 0.01;

/// Whether a clip path is a rectangle that has all of the group within.
pub fn covers(clip: &ClipPath, group: &Group) -> bool {
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
    let whole = Map::of(group.abs_transform().pre_concat(clip.transform()).pre_concat(path.abs_transform()));
    let corners: Vec<Point> = corners.into_iter().map(|corner| whole.px(corner)).collect();
    let [a, b, c, d] = corners[..] else { return false };
    let same = |x: f64, y: f64| (x - y).abs() <= SLACK_PX;
    let level = same(a[1], b[1]) && same(b[0], c[0]) && same(c[1], d[1]) && same(d[0], a[0]);
    let upright = same(a[0], b[0]) && same(b[1], c[1]) && same(c[0], d[0]) && same(d[1], a[1]);
    let within = group.abs_bounding_box();
    (level || upright)
        && f64::from(within.left()) >= a[0].min(c[0]) - SLACK_PX
        && f64::from(within.right()) <= a[0].max(c[0]) + SLACK_PX
        && f64::from(within.top()) >= a[1].min(c[1]) - SLACK_PX
        && f64::from(within.bottom()) <= a[1].max(c[1]) + SLACK_PX
}
