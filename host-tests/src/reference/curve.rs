//! A function made of cubics: of time for PT, PVT and ramps, of the master's progress for a slave.
use super::number::{Fix, root};
use super::rational::Rational;

/// A cubic over `from` to `to`; coefficients are those of the share of it that has passed, in
/// pulses.
#[derive(Debug, Clone)]
struct Piece {
    from: Fix,
    to: Fix,
    c: [Fix; 4],
    /// Shares of it at which the function turns.
    turns: Vec<Fix>,
}

impl Piece {
    fn share(&self, u: Fix) -> Fix {
        (u - self.from).over(self.to - self.from)
    }

    fn value(&self, s: Fix) -> Fix {
        let [c0, c1, c2, c3] = self.c;
        c0 + s * (c1 + s * (c2 + s * c3))
    }

    fn slope(&self, s: Fix) -> Fix {
        let [_, c1, c2, c3] = self.c;
        let by_share = c1 + s * (c2 + c2 + s * (c3 + c3 + c3));
        by_share.over(self.to - self.from)
    }
}

/// See the module text. It begins at 0 with the value 0; below 0 its value is 0.
#[derive(Debug, Clone, Default)]
pub struct Curve {
    pieces: Vec<Piece>,
    /// Exact ends.
    length: Fix,
    end: Fix,
    /// Slope after the last piece (a Jog that goes on).
    pub cruise: Fix,
    /// No slope is greater.
    pub steepest: Fix,
}

/// Roots of the slope c1 + 2·c2·s + 3·c3·s² between 0 and 1.
fn turns(c: &[Rational; 4]) -> Vec<Fix> {
    let (a, b, d) = (&c[3] * whole(3), &c[2] * whole(2), &c[1]);
    let mut found = Vec::new();
    if a.is_zero() {
        if !b.is_zero() {
            found.push(-d / b);
        }
    } else {
        let disc = &b * &b - whole(4) * &a * d;
        if !disc.is_negative() {
            let root = root(&disc).rational();
            found.push((-&b - &root) / (whole(2) * &a));
            found.push((-&b + &root) / (whole(2) * &a));
        }
    }
    let inside = found.into_iter().filter(|s| s.is_positive() && *s < whole(1));
    let mut found: Vec<Fix> = inside.map(|s| Fix::of(&s)).collect();
    found.sort_unstable();
    found
}

fn whole(x: i64) -> Rational {
    Rational::from_integer(x.into())
}

impl Curve {
    /// Appends a piece that begins at the slope `v` and goes with the curvature `a` and the third
    /// derivative `j`.
    pub fn cubic(&mut self, length: &Rational, v: &Rational, a: &Rational, j: &Rational) {
        let square = length * length;
        let c = [self.end.rational(), v * length, a * &square / whole(2), j * &square * length / whole(6)];
        let from = self.length;
        self.length += Fix::of(length);
        if from == self.length {
            return;
        }
        let turns = turns(&c);
        let piece = Piece { from, to: self.length, c: [0, 1, 2, 3].map(|k| Fix::of(&c[k])), turns };
        // The slope is greatest at an end or where the curvature is 0.
        let mut shares = vec![Fix::ZERO, Fix::ONE];
        if !c[3].is_zero() {
            let flat = -&c[2] / (whole(3) * &c[3]);
            if flat.is_positive() && flat < whole(1) {
                shares.push(Fix::of(&flat));
            }
        }
        for share in shares {
            self.steepest = self.steepest.max(piece.slope(share).abs());
        }
        self.end = piece.value(Fix::ONE);
        self.pieces.push(piece);
    }

    /// The value at the end of the last piece, where it is known exactly.
    pub fn ends_at(&mut self, end: Fix) {
        debug_assert!((self.end - end).abs() < Fix(1 << 40), "{:?} {:?}", self.end.to_f64(), end.to_f64());
        self.end = end;
    }

    /// The length up to there, which pieces whose lengths were rounded may miss.
    pub fn reaches(&mut self, length: Fix) {
        debug_assert!((self.length - length).abs() < Fix(1 << 10));
        if let Some(last) = self.pieces.last_mut().filter(|last| last.from < length) {
            (last.to, self.length) = (length, length);
        }
    }

    pub fn length(&self) -> Fix {
        self.length
    }

    pub fn end(&self) -> Fix {
        self.end
    }

    pub fn at(&self, u: Fix) -> Fix {
        if u <= Fix::ZERO {
            return Fix::ZERO;
        }
        if u >= self.length {
            return self.end + self.cruise * (u - self.length);
        }
        let piece = &self.pieces[self.pieces.partition_point(|piece| piece.to <= u)];
        piece.value(piece.share(u))
    }

    /// The slope just after `u`, or just before it.
    pub fn slope(&self, u: Fix, after: bool) -> Fix {
        let outside = if after { u < Fix::ZERO } else { u <= Fix::ZERO };
        if outside {
            return Fix::ZERO;
        }
        let index = self.pieces.partition_point(|piece| if after { piece.to <= u } else { piece.to < u });
        self.pieces.get(index).map_or(self.cruise, |piece| piece.slope(piece.share(u)))
    }

    /// By how much the slope jumps at most at a knot nearer than `apart`.
    pub fn jump_near(&self, u: Fix, apart: Fix) -> Fix {
        let knots = self.pieces.iter().flat_map(|piece| [piece.from, piece.to]);
        let near = knots.filter(|knot| (*knot - u).abs() < apart);
        near.map(|knot| (self.slope(knot, true) - self.slope(knot, false)).abs()).max().unwrap_or(Fix::ZERO)
    }

    pub fn has_knot_near(&self, u: Fix, apart: Fix) -> bool {
        self.pieces.iter().any(|piece| (piece.from - u).abs() < apart || (piece.to - u).abs() < apart)
    }

    /// The second derivative from `u` on; none within rounding of a knot that is not exactly there.
    pub fn curvature(&self, u: Fix) -> Option<Fix> {
        let near = |knot: Fix| u != knot && (u - knot).abs() < Fix(1 << 46);
        if u < Fix::ZERO || self.pieces.iter().any(|piece| near(piece.from) || near(piece.to)) {
            return None;
        }
        let Some(piece) = self.pieces.get(self.pieces.partition_point(|piece| piece.to <= u)) else {
            return Some(Fix::ZERO);
        };
        let ([_, _, c2, c3], length, s) = (piece.c, piece.to - piece.from, piece.share(u));
        let by_share = c2 + c2 + s * (c3 + c3 + c3 + c3 + c3 + c3);
        Some(by_share.over(length).over(length))
    }

    /// Knots and turns between `a` and `b`, and the values there, in the order of the way from `a`
    /// to `b`.
    pub fn between(&self, a: Fix, b: Fix, out: &mut Vec<(Fix, Fix)>) {
        let (low, high) = (a.min(b), a.max(b));
        let first = out.len();
        let index = self.pieces.partition_point(|piece| piece.to <= low);
        for piece in self.pieces[index..].iter().take_while(|piece| piece.from < high) {
            if piece.from > low {
                out.push((piece.from, piece.value(Fix::ZERO)));
            }
            for &turn in &piece.turns {
                let u = piece.from + turn * (piece.to - piece.from);
                if u > low && u < high {
                    out.push((u, piece.value(turn)));
                }
            }
        }
        if self.length > low && self.length < high {
            out.push((self.length, self.end));
        }
        if b < a {
            out[first..].reverse();
        }
    }
}
