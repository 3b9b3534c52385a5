//! An exact model of RS274 programs, written from the standard: rational positions, and where there
//! is light.
//!
//! In: lines as words with decimal numbers. Out: where the program ends, and its strokes in order.
//! It shares nothing with the importer.
use num_bigint::BigInt;
use num_rational::BigRational as Q;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// A word with its number as text.
pub type Word = (char, String);

/// A part of the path.
#[derive(Debug, Clone)]
pub struct Piece {
    /// Positions in the machine, mm; one of a dwell.
    pub points: Vec<[f64; 3]>,
    pub lit: bool,
}

/// One axis: pulses a mm with sign, home in mm.
#[derive(Debug, Clone)]
pub struct Axis {
    pub steps: Q,
    pub home: Q,
}

pub fn decimal(text: &str) -> Q {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text),
    };
    let (whole, decimals) = digits.split_once('.').unwrap_or((digits, ""));
    let number: BigInt = format!("0{whole}{decimals}").parse().unwrap();
    Q::new(number * sign, BigInt::from(10).pow(decimals.len() as u32))
}

impl Axis {
    /// The nearest pulse, halves away from zero.
    pub fn pulse(&self, mm: &Q) -> i64 {
        let exact = mm * &self.steps;
        let half = Q::new(BigInt::one(), BigInt::from(2));
        let size = (exact.abs() + half).floor().to_integer().to_i64().unwrap();
        if exact.is_negative() { -size } else { size }
    }
}

fn float(number: &Q) -> f64 {
    number.to_f64().unwrap()
}

/// See the module text.
pub struct Model {
    pub axes: Vec<Axis>,
    pub at: [Q; 3],
    pub pieces: Vec<Piece>,
    pub ended: bool,
    motion: i32,
    plane: [usize; 3],
    inch: bool,
    relative: bool,
    centre_absolute: bool,
    spindle: i32,
    speed: Q,
    system: usize,
    systems: Vec<[Q; 3]>,
    shift: [Q; 3],
    kept_shift: [Q; 3],
    tool: [Q; 3],
    stored: [[Q; 3]; 2],
}

impl Model {
    pub fn new(axes: Vec<Axis>) -> Model {
        let zero = || [Q::zero(), Q::zero(), Q::zero()];
        let home = [0, 1, 2].map(|axis: usize| axes[axis].home.clone());
        Model {
            axes,
            at: home.clone(),
            pieces: Vec::new(),
            ended: false,
            motion: 0,
            plane: [0, 1, 2],
            inch: false,
            relative: false,
            centre_absolute: false,
            spindle: 5,
            speed: Q::zero(),
            system: 0,
            systems: (0..6).map(|_| zero()).collect(),
            shift: zero(),
            kept_shift: zero(),
            tool: zero(),
            stored: [home.clone(), home],
        }
    }

    pub fn pulses(&self) -> [i64; 3] {
        [0, 1, 2].map(|axis| self.axes[axis].pulse(&self.at[axis]))
    }

    fn mm(&self, number: Q) -> Q {
        if self.inch { number * Q::new(BigInt::from(127), BigInt::from(5)) } else { number }
    }

    /// Runs a line.
    pub fn line(&mut self, words: &[Word]) {
        if self.ended {
            return;
        }
        let gs: Vec<&str> = words.iter().filter(|word| word.0 == 'G').map(|word| word.1.as_str()).collect();
        let ms: Vec<&str> = words.iter().filter(|word| word.0 == 'M').map(|word| word.1.as_str()).collect();
        let of = |letter: char| words.iter().find(|word| word.0 == letter).map(|word| decimal(&word.1));
        let has = |code: &str| gs.contains(&code);
        if let Some(speed) = of('S') {
            self.speed = speed;
        }
        for m in ["3", "4", "5"] {
            if ms.contains(&m) {
                self.spindle = m.parse().unwrap();
            }
        }
        for g in ["0", "1", "2", "3", "80"] {
            if has(g) {
                self.motion = g.parse().unwrap();
            }
        }
        if has("4") && of('P').unwrap().is_positive() {
            let lit = self.spindle == 3 && self.speed.is_positive() && (1..=3).contains(&self.motion);
            self.stand(lit);
        }
        for (g, plane) in [("17", [0, 1, 2]), ("18", [2, 0, 1]), ("19", [1, 2, 0])] {
            if has(g) {
                self.plane = plane;
            }
        }
        self.inch = (self.inch || has("20")) && !has("21");
        let words = ['X', 'Y', 'Z'].map(|letter| of(letter).map(|number| self.mm(number)));
        let mut free = true;
        if has("43.1") {
            free = false;
            for (axis, word) in words.iter().enumerate() {
                if let Some(word) = word {
                    self.tool[axis] = word.clone();
                }
            }
        }
        if has("49") {
            self.tool = [Q::zero(), Q::zero(), Q::zero()];
        }
        for system in 0..6 {
            if has(&format!("{}", 54 + system)) {
                self.system = system;
            }
        }
        self.relative = (self.relative || has("91")) && !has("90");
        self.centre_absolute = (self.centre_absolute || has("90.1")) && !has("91.1");
        let target = self.target(&words, has("53"));
        for (g, place) in [("28", 0), ("30", 1)] {
            if has(&format!("{g}.1")) {
                self.stored[place] = self.at.clone();
            }
            if has(g) {
                free = false;
                let named = words.iter().any(Option::is_some);
                if named {
                    self.straight(target.clone(), false);
                }
                let mut to = self.at.clone();
                for axis in 0..3 {
                    if !named || words[axis].is_some() {
                        to[axis] = self.stored[place][axis].clone();
                    }
                }
                self.straight(to, false);
            }
        }
        if has("10") {
            free = false;
            let system = of('P').unwrap().to_integer().to_usize().unwrap();
            let system = if system == 0 { self.system } else { system - 1 };
            for (axis, word) in words.iter().enumerate() {
                if let Some(word) = word {
                    // L20: the position here is to be the word.
                    let here = &self.at[axis] - &self.shift[axis] - &self.tool[axis] - word;
                    self.systems[system][axis] = if of('L') == Some(decimal("20")) { here } else { word.clone() };
                }
            }
        }
        if has("92") {
            free = false;
            for (axis, word) in words.iter().enumerate() {
                if let Some(word) = word {
                    self.shift[axis] = &self.at[axis] - &self.systems[self.system][axis] - &self.tool[axis] - word;
                }
            }
            self.kept_shift = self.shift.clone();
        }
        if has("92.1") {
            self.kept_shift = [Q::zero(), Q::zero(), Q::zero()];
        }
        if has("92.1") || has("92.2") {
            self.shift = [Q::zero(), Q::zero(), Q::zero()];
        }
        if has("92.3") {
            self.shift = self.kept_shift.clone();
        }
        let centre = ['I', 'J', 'K'].map(|letter| of(letter).map(|number| self.mm(number)));
        let radius = of('R').map(|number| self.mm(number));
        let round = centre.iter().any(Option::is_some) || radius.is_some();
        if free && (round || words.iter().any(Option::is_some)) {
            let lit = self.spindle != 5 && self.speed.is_positive();
            match self.motion {
                0 => self.straight(target, false),
                1 => self.straight(target, lit),
                way => self.arc(target, &centre, radius, way == 3, lit),
            }
        }
        if ms.contains(&"0") {
            self.stand(false);
        }
        self.ended = ms.contains(&"2") || ms.contains(&"30");
    }

    fn target(&self, words: &[Option<Q>; 3], machine: bool) -> [Q; 3] {
        [0, 1, 2].map(|axis| match &words[axis] {
            None => self.at[axis].clone(),
            Some(word) if machine => word.clone(),
            Some(word) if self.relative => &self.at[axis] + word,
            Some(word) => word + self.zero(axis),
        })
    }

    fn zero(&self, axis: usize) -> Q {
        &self.systems[self.system][axis] + &self.shift[axis] + &self.tool[axis]
    }

    fn stand(&mut self, lit: bool) {
        let here = [0, 1, 2].map(|axis| float(&self.at[axis]));
        self.pieces.push(Piece { points: vec![here], lit });
    }

    fn straight(&mut self, to: [Q; 3], lit: bool) {
        let before = self.pulses();
        let from = [0, 1, 2].map(|axis| float(&self.at[axis]));
        self.at = to;
        if self.pulses() != before {
            let to = [0, 1, 2].map(|axis| float(&self.at[axis]));
            self.pieces.push(Piece { points: vec![from, to], lit });
        }
    }

    fn arc(&mut self, to: [Q; 3], centre: &[Option<Q>; 3], radius: Option<Q>, ccw: bool, lit: bool) {
        let [a, b, c] = self.plane;
        let way = [a, b, c].map(|axis| float(&(&to[axis] - &self.at[axis])));
        let closed = to[a] == self.at[a] && to[b] == self.at[b];
        let [x, y] = match radius {
            Some(radius) => {
                let (radius, chord) = (float(&radius), way[0].hypot(way[1]));
                let high = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
                // The centre of a short left turn is to the left of the chord.
                let high = if (radius < 0.0) == ccw { -high } else { high };
                [way[0] / 2.0 - high * way[1] / chord, way[1] / 2.0 + high * way[0] / chord]
            }
            None => [a, b].map(|axis| {
                let word = centre[axis].clone();
                if self.centre_absolute {
                    float(&(word.unwrap() + self.zero(axis) - &self.at[axis]))
                } else {
                    word.as_ref().map_or(0.0, float)
                }
            }),
        };
        let (begin, end) = ((-y).atan2(-x), (way[1] - y).atan2(way[0] - x));
        let turn = std::f64::consts::TAU;
        let mut sweep = if ccw { end - begin } else { begin - end }.rem_euclid(turn);
        if closed {
            sweep = turn;
        }
        let (size, from) = (x.hypot(y), [0, 1, 2].map(|axis| float(&self.at[axis])));
        let mut points = Vec::new();
        for k in 0..=200 {
            let part = f64::from(k) / 200.0;
            let angle = begin + if ccw { sweep * part } else { -sweep * part };
            let mut point = from;
            point[a] += x + size * angle.cos();
            point[b] += y + size * angle.sin();
            point[c] += way[2] * part;
            points.push(point);
        }
        let before = self.pulses();
        self.at = to;
        if closed || self.pulses() != before {
            self.pieces.push(Piece { points, lit });
        }
    }
}
