//! A quantity over time, thinned to its extremes, cut to the time that is drawn.

/// Most pairs of extremes that a curve of a picture keeps, and one of a page, which can be
/// enlarged.
pub(super) const PICTURE_BUCKETS: usize = 4096;
pub(super) const PAGE_BUCKETS: usize = 1 << 15;

/// A value and its time in ms.
pub(super) type Point = (f64, f64);

/// One quantity over time.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    most: usize,
    /// Least and greatest value of each run of `share` points.
    buckets: Vec<(Point, Point)>,
    open: Option<(Point, Point)>,
    filled: usize,
    share: usize,
    last: Option<Point>,
}

impl Curve {
    /// Nothing yet; at most so many pairs of extremes.
    pub fn new(most: usize) -> Curve {
        Curve { most, buckets: Vec::new(), open: None, filled: 0, share: 1, last: None }
    }

    pub fn push(&mut self, point: Point) {
        self.last = Some(point);
        self.open = Some(match self.open {
            None => (point, point),
            Some(both) => merge(both, (point, point)),
        });
        self.filled += 1;
        if self.filled == self.share {
            self.filled = 0;
            self.buckets.extend(self.open.take());
            if self.buckets.len() >= self.most {
                self.buckets =
                    self.buckets.chunks(2).map(|c| c.iter().copied().reduce(merge).unwrap_or(c[0])).collect();
                self.share *= 2;
            }
        }
    }

    /// Holds the last value until `t`, then changes to `value` in one step.
    pub fn step(&mut self, t: f64, value: f64) {
        match self.last {
            Some((_, before)) if before != value => self.push((t, before)),
            _ => {}
        }
        self.push((t, value));
    }

    /// Had this value since the last point.
    pub fn hold_back(&mut self, t: f64, value: f64) {
        match self.last {
            Some((since, before)) if before != value => self.push((since, value)),
            _ => {}
        }
        self.push((t, value));
    }

    /// The points to draw, in the order of time.
    pub fn points(&self) -> impl Iterator<Item = Point> + '_ {
        let pairs = self.buckets.iter().copied().chain(self.open);
        let first_to_last = pairs.flat_map(|(low, high)| if low.0 <= high.0 { [low, high] } else { [high, low] });
        first_to_last.chain(self.last)
    }

    /// Least and greatest value; nothing without points.
    pub fn extremes(&self) -> Option<(f64, f64)> {
        self.points().map(|p| (p.1, p.1)).reduce(|(low, high), p| (low.min(p.0), high.max(p.1)))
    }
}

fn merge(a: (Point, Point), b: (Point, Point)) -> (Point, Point) {
    (if b.0.1 < a.0.1 { b.0 } else { a.0 }, if b.1.1 > a.1.1 { b.1 } else { a.1 })
}
