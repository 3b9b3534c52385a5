//! Circles: centre from I J K or R, the rule of radii, sweep, extent, and points along a curve.
//!
//! All in mm from the start, floating point: ends are exact elsewhere. Radii may differ as Grbl 1.1
//! allows: by 0.005 mm, or by 0.1 % of the radius and 0.5 mm.

/// Radii may always differ by so much, mm.
const RADIUS_SLACK_MM: f64 = 0.005;
/// And never by more than so much, mm, and this part of the radius.
const RADIUS_SLACK_MAX_MM: f64 = 0.5;
const RADIUS_SLACK_SHARE: f64 = 0.001;

/// An arc in its plane, in mm from its start.
#[derive(Debug, Clone, Copy)]
pub struct Arc {
    pub centre: [f64; 2],
    pub end: [f64; 2],
    /// Angle in radians; above 0 counterclockwise.
    pub sweep: f64,
}

/// Whether radii may differ by `by`.
fn fits(by: f64, radius: f64) -> bool {
    by <= RADIUS_SLACK_MM || (by <= RADIUS_SLACK_MAX_MM && by <= RADIUS_SLACK_SHARE * radius)
}

impl Arc {
    /// By its centre. An end equal to the start is a full circle.
    pub fn by_centre(centre: [f64; 2], end: [f64; 2], closed: bool, ccw: bool) -> Result<Arc, String> {
        let radius = centre[0].hypot(centre[1]);
        let radius_end = (end[0] - centre[0]).hypot(end[1] - centre[1]);
        if radius == 0.0 {
            return Err("the centre of the arc is its start".to_owned());
        }
        let by = (radius - radius_end).abs();
        if !fits(by, radius) {
            return Err(format!(
                "the radius does not fit: it is {radius:.4} mm at the start and {radius_end:.4} mm at the end; \
                 they may differ by 0.005 mm, or by 0.1 % of it and at most 0.5 mm"
            ));
        }
        let turn = std::f64::consts::TAU;
        let sweep = if closed {
            turn
        } else {
            let (from, to) = ([-centre[0], -centre[1]], [end[0] - centre[0], end[1] - centre[1]]);
            let angle = (from[0] * to[1] - from[1] * to[0]).atan2(from[0] * to[0] + from[1] * to[1]);
            let angle = if ccw { angle } else { -angle };
            if angle <= 0.0 { angle + turn } else { angle }
        };
        Ok(Arc { centre, end, sweep: if ccw { sweep } else { -sweep } })
    }

    /// By its radius: above 0 up to half a turn, below 0 the longer way.
    pub fn by_radius(radius: f64, end: [f64; 2], ccw: bool) -> Result<Arc, String> {
        let chord = end[0].hypot(end[1]);
        if chord == 0.0 {
            return Err("an arc by R needs an end that is not its start".to_owned());
        }
        let (half, size) = (chord / 2.0, radius.abs());
        if size == 0.0 || (half > size && !fits(half - size, size)) {
            return Err(format!("the radius does not fit: R is {size:.4} mm, and half of the way is {half:.4} mm"));
        }
        let height = ((size - half) * (size + half)).max(0.0).sqrt();
        // To the left of the way for a short counterclockwise arc.
        let left = if ccw == (radius > 0.0) { height } else { -height };
        let centre = [end[0] / 2.0 - end[1] / chord * left, end[1] / 2.0 + end[0] / chord * left];
        Arc::by_centre(centre, end, false, ccw)
    }

    /// Radius at the start, mm.
    pub fn radius(&self) -> f64 {
        self.centre[0].hypot(self.centre[1])
    }

    /// Length, mm.
    pub fn length(&self) -> f64 {
        let radius_end = (self.end[0] - self.centre[0]).hypot(self.end[1] - self.centre[1]);
        (self.radius() + radius_end) / 2.0 * self.sweep.abs()
    }

    /// The point after this part of the sweep; the radius goes over to that of the end.
    pub fn at(&self, part: f64) -> [f64; 2] {
        let [x, y] = self.centre;
        let grown = 1.0 + ((self.end[0] - x).hypot(self.end[1] - y) / self.radius() - 1.0) * part;
        let (sin, cos) = (self.sweep * part).sin_cos();
        [x + grown * (-x * cos + y * sin), y + grown * (-x * sin - y * cos)]
    }

    /// Parts of the sweep such that lines between them are within `tolerance` mm of the arc.
    pub fn parts(&self, tolerance: f64) -> u32 {
        let step = 2.0 * (1.0 - (tolerance / self.radius()).min(0.5)).acos();
        (self.sweep.abs() / step).ceil().clamp(1.0, 1e6) as u32
    }

    /// Least and greatest of both coordinates.
    pub fn extent(&self) -> [(f64, f64); 2] {
        let mut extent = [0, 1].map(|k| (self.end[k].min(0.0), self.end[k].max(0.0)));
        let begin = (-self.centre[1]).atan2(-self.centre[0]);
        for quarter in 0..4 {
            let angle = f64::from(quarter) * std::f64::consts::FRAC_PI_2;
            let turn = std::f64::consts::TAU;
            let way = if self.sweep > 0.0 { angle - begin } else { begin - angle }.rem_euclid(turn);
            if way < self.sweep.abs() {
                let point = self.at(way / self.sweep.abs());
                for (extent, at) in extent.iter_mut().zip(point) {
                    *extent = (extent.0.min(at), extent.1.max(at));
                }
            }
        }
        extent
    }
}
