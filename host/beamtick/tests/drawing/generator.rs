//! Random drawings whose marks are known in closed form.
//!
//! In: random numbers. Out: the text of an SVG, and the points of each mark in mm of the machine,
//! close together, computed from the same decimals as the text with the formulas of rectangles,
//! ellipses and Bézier curves.
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// mm between points of a mark, about.
const POINT_GAP_MM: f64 = 0.02;

pub struct Drawing {
    pub text: String,
    pub marks: Vec<Mark>,
    /// Arcs of circles that are circles on the page.
    pub circles: usize,
}

pub struct Mark {
    pub points: Vec<[f64; 2]>,
    pub red: bool,
    pub what: String,
    /// Where a closed mark may begin.
    pub corners: Vec<[f64; 2]>,
}

impl Mark {
    /// Whether a point is so near an end that the first or last row of its light may be after or
    /// before it.
    pub fn is_end(&self, point: [f64; 2]) -> bool {
        let near = |end: [f64; 2]| (point[0] - end[0]).hypot(point[1] - end[1]) < 0.1;
        // A closed mark may begin at any of its corners.
        near(self.points[0])
            || near(self.points[self.points.len() - 1])
            || self.corners.iter().any(|corner| near(*corner))
    }
}

pub fn below(random: &mut Xoshiro256PlusPlus, count: u64) -> u64 {
    random.next_u64() % count
}

/// A decimal with three digits after the point.
fn decimal(random: &mut Xoshiro256PlusPlus, low: i64, high: i64) -> f64 {
    (low * 1000 + below(random, ((high - low) * 1000) as u64) as i64) as f64 / 1000.0
}

/// What is drawn, in coordinates of its own: its element, its points at a part of it, its joints.
struct Figure {
    element: String,
    pieces: Vec<Box<dyn Fn(f64) -> [f64; 2]>>,
    /// Arcs of circles in it.
    arcs: usize,
}

fn line(from: [f64; 2], to: [f64; 2]) -> Box<dyn Fn(f64) -> [f64; 2]> {
    Box::new(move |t| [from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t])
}

fn round(centre: [f64; 2], radii: [f64; 2], from: f64, by: f64) -> Box<dyn Fn(f64) -> [f64; 2]> {
    Box::new(move |t| {
        let (sin, cos) = ((from + by * t) * std::f64::consts::FRAC_PI_2).sin_cos();
        [centre[0] + radii[0] * cos, centre[1] + radii[1] * sin]
    })
}

fn bezier(p: [[f64; 2]; 4]) -> Box<dyn Fn(f64) -> [f64; 2]> {
    Box::new(move |t| {
        let s = 1.0 - t;
        [0, 1]
            .map(|k| s * s * s * p[0][k] + 3.0 * s * s * t * p[1][k] + 3.0 * s * t * t * p[2][k] + t * t * t * p[3][k])
    })
}

fn figure(random: &mut Xoshiro256PlusPlus) -> Figure {
    let mut number = |low: i64, high: i64| decimal(random, low, high);
    let (x, y, w, h) = (number(-20, 0), number(-20, 0), number(2, 30), number(2, 30));
    let quarters = |centre: [f64; 2], radii: [f64; 2]| (0..4).map(|k| round(centre, radii, k.into(), 1.0)).collect();
    match below(random, 6) {
        0 => {
            let corners = [[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
            let pieces = (0..4).map(|k| line(corners[k], corners[(k + 1) % 4])).collect();
            let element = format!("<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"");
            Figure { element, pieces, arcs: 0 }
        }
        1 => Figure {
            element: format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{w}\""),
            pieces: quarters([x, y], [w, w]),
            arcs: 1,
        },
        2 => Figure {
            element: format!("<ellipse cx=\"{x}\" cy=\"{y}\" rx=\"{w}\" ry=\"{}\"", w / 2.0),
            pieces: quarters([x, y], [w, w / 2.0]),
            arcs: 0,
        },
        3 => {
            let r = w.min(h) / 4.0;
            let (a, b) = (x + w - r, y + h - r);
            let pieces = vec![
                line([x + r, y], [a, y]),
                round([a, y + r], [r, r], 3.0, 1.0),
                line([x + w, y + r], [x + w, b]),
                round([a, b], [r, r], 0.0, 1.0),
                line([a, y + h], [x + r, y + h]),
                round([x + r, b], [r, r], 1.0, 1.0),
                line([x, b], [x, y + r]),
                round([x + r, y + r], [r, r], 2.0, 1.0),
            ];
            let element = format!("<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" rx=\"{r}\"");
            Figure { element, pieces, arcs: 4 }
        }
        4 => {
            let (mut at, mut d, mut pieces) = ([x, y], format!("M{x} {y}"), Vec::new());
            for _ in 0..1 + below(random, 3) {
                let p = [at, at, at, at].map(|_| [decimal(random, -25, 25), decimal(random, -25, 25)]);
                d += &format!("C{} {},{} {},{} {}", p[1][0], p[1][1], p[2][0], p[2][1], p[3][0], p[3][1]);
                pieces.push(bezier([at, p[1], p[2], p[3]]));
                at = p[3];
            }
            if below(random, 2) == 0 {
                d += "Z";
                pieces.push(line(at, [x, y]));
            }
            Figure { element: format!("<path d=\"{d}\""), pieces, arcs: 0 }
        }
        _ => {
            let points: Vec<[f64; 2]> =
                (0..2 + below(random, 5)).map(|_| [decimal(random, -25, 25), decimal(random, -25, 25)]).collect();
            let list: Vec<String> = points.iter().map(|p| format!("{},{}", p[0], p[1])).collect();
            let pieces = points.windows(2).map(|pair| line(pair[0], pair[1])).collect();
            Figure { element: format!("<polyline points=\"{}\"", list.join(" ")), pieces, arcs: 0 }
        }
    }
}

/// One to six figures on a page of 300 x 200 mm.
pub fn drawing(random: &mut Xoshiro256PlusPlus) -> Drawing {
    let (unit, mm) =
        [("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("px", 25.4 / 96.0), ("pt", 25.4 / 72.0)][below(random, 5) as usize];
    // Units of the viewBox a mm, and its corner.
    let per_mm = [1.0, 2.0, 3.75, 0.5][below(random, 4) as usize];
    let corner = [decimal(random, -50, 50), decimal(random, -50, 50)];
    let size = [300.0, 200.0];
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}{unit}\" height=\"{}{unit}\" viewBox=\"{} {} {} {}\">\n",
        size[0] / mm,
        size[1] / mm,
        corner[0],
        corner[1],
        size[0] * per_mm,
        size[1] * per_mm
    );
    let (mut marks, mut circles) = (Vec::new(), 0);
    for _ in 0..1 + below(random, 6) {
        let figure = figure(random);
        let red = below(random, 2) == 0;
        let angle = decimal(random, -3, 3);
        let scale = decimal(random, 1, 2) * per_mm;
        // Every third is stretched.
        let stretched = below(random, 3) == 0;
        let stretch = if stretched { scale * 1.5 } else { scale };
        let (sin, cos) = angle.sin_cos();
        let at = [decimal(random, 80, 220), decimal(random, 80, 120)];
        let mut entries = [
            scale * cos,
            scale * sin,
            -stretch * sin,
            stretch * cos,
            corner[0] + at[0] * per_mm,
            corner[1] + at[1] * per_mm,
        ];
        entries.iter_mut().for_each(|entry| *entry = (*entry * 1e7).round() / 1e7);
        let [a, b, c, d, e, f] = entries;
        let colour = if red { "#f00" } else { "rgb(0, 0, 255)" };
        text += &format!("{} transform=\"matrix({a} {b} {c} {d} {e} {f})\" stroke=\"{colour}\"/>\n", figure.element);
        let machine = |[x, y]: [f64; 2]| {
            let page = [(a * x + c * y + e - corner[0]) / per_mm, (b * x + d * y + f - corner[1]) / per_mm];
            [page[0], size[1] - page[1]]
        };
        let mut points = vec![machine(figure.pieces[0](0.0))];
        for piece in &figure.pieces {
            let coarse: Vec<[f64; 2]> = (0..=64).map(|k| machine(piece(f64::from(k) / 64.0))).collect();
            let longest = coarse.windows(2).map(|w| (w[0][0] - w[1][0]).hypot(w[0][1] - w[1][1])).fold(0.0, f64::max);
            let count = (longest * 64.0 / POINT_GAP_MM).ceil().max(2.0) as u32;
            points.extend((1..=count).map(|k| machine(piece(f64::from(k) / f64::from(count)))));
        }
        circles += if stretched { 0 } else { figure.arcs };
        let corners = figure.pieces.iter().flat_map(|piece| [machine(piece(0.0)), machine(piece(1.0))]).collect();
        marks.push(Mark { points, red, what: figure.element, corners });
    }
    Drawing { text: text + "</svg>\n", marks, circles }
}
