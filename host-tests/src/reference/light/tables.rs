//! Tables of power against speed, and of ratios against positions: SPEC 4 and 6, docs/laser.md.

/// Points that a line has at most, and tables of powers that a channel has.
pub const POINTS: usize = 32;
pub const TABLES: i16 = 8;

/// Linear between its points, and the border's value outside.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line(pub Vec<[f64; 2]>);

impl Line {
    /// Points increase from one to the next.
    pub fn increases(&self) -> bool {
        self.0.windows(2).all(|pair| pair[0][0] < pair[1][0])
    }

    pub fn at(&self, x: f64) -> f64 {
        let after = self.0.partition_point(|point| point[0] <= x);
        match (after.checked_sub(1).map(|before| self.0[before]), self.0.get(after).copied()) {
            (Some([from, low]), Some([to, high])) => low + (high - low) * (x - from) / (to - from),
            (Some([_, y]), None) | (None, Some([_, y])) => y,
            (None, None) => 0.0,
        }
    }

    /// The steepest change of it.
    pub fn steepest(&self) -> f64 {
        let slope = |pair: &[[f64; 2]]| ((pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).abs();
        self.0.windows(2).map(slope).fold(0.0, f64::max)
    }
}

/// Ratios over the positions of axes 1 to 4.
#[derive(Debug, Clone, PartialEq)]
pub enum Ratios {
    /// SetLaserDisTable1D: a line an axis.
    Lines([Line; 4]),
    /// SetLaserDisTable2D: axes X and Y from 0, positions of Y, and a line along X for each.
    Plane { axes: [usize; 2], y: Vec<f64>, rows: Vec<Line> },
}

impl Ratios {
    /// The ratio of each axis, and how much it changes for a pulse.
    pub fn at(&self, position: &[f64; 4]) -> [[f64; 2]; 4] {
        match self {
            Ratios::Lines(lines) => {
                std::array::from_fn(|axis| [lines[axis].at(position[axis]), lines[axis].steepest()])
            }
            Ratios::Plane { axes: [x, y], y: at, rows } => {
                let across = Line(at.iter().zip(rows).map(|(at, row)| [*at, row.at(position[*x])]).collect());
                let along = rows.iter().map(Line::steepest).fold(0.0, f64::max);
                let both = [across.at(position[*y]), across.steepest() + along];
                std::array::from_fn(|axis| if axis == *x || axis == *y { both } else { [0.0; 2] })
            }
        }
    }
}

/// What SetLaserDisTable1D and SetLaserDisTable2D set: ratios, and the most that each axis adds or
/// subtracts.
#[derive(Debug, Clone, PartialEq)]
pub struct Ratio {
    pub ratios: Ratios,
    pub limits: [f64; 4],
}

/// A call that sets a table of a channel, from 0.
#[derive(Debug, Clone, PartialEq)]
pub enum LightTable {
    /// SetLaserFollowTable: speed and power of each point.
    Powers { channel: i16, table: i16, points: Vec<[f64; 2]> },
    /// SetLaserDisTable1D: position and ratio of the points of each axis.
    Lines { channel: i16, points: [Vec<(i32, f64)>; 4], bounds: [f64; 2], limits: Option<[f64; 4]> },
    /// SetLaserDisTable2D: axes X and Y from 1, their positions, and ratios along X first.
    Plane {
        channel: i16,
        axes: [i16; 2],
        x: Vec<i32>,
        y: Vec<i32>,
        ratios: Vec<f64>,
        bounds: [f64; 2],
        limits: Option<[f64; 2]>,
    },
}

/// A declaration of an array.
fn array(kind: &str, name: &str, number: usize, values: impl Iterator<Item = String>) -> String {
    let values: Vec<String> = values.collect();
    format!("{kind} {name}{number}[] = {{{}}}; ", values.join(","))
}

impl LightTable {
    pub fn channel(&self) -> i16 {
        let (Self::Powers { channel, .. } | Self::Lines { channel, .. } | Self::Plane { channel, .. }) = self;
        *channel
    }

    /// A statement of a job, the one with this number.
    pub fn text(&self, number: usize) -> String {
        let reals = |name: &str, of: &[f64]| array("double", name, number, of.iter().map(|x| format!("{x:?}")));
        let longs = |name: &str, of: &[i32]| array("long", name, number, of.iter().map(i32::to_string));
        let limits = |of: Option<&[f64]>| match of {
            Some(of) => (reals("l", of), format!("l{number}")),
            None => (String::new(), "NULL".into()),
        };
        match self {
            Self::Powers { channel, table, points } => {
                let column = |at: usize| points.iter().map(|point| point[at]).collect::<Vec<f64>>();
                let arrays = reals("v", &column(0)) + &reals("p", &column(1));
                let count = points.len();
                format!("{arrays}rtn = GTN_SetLaserFollowTable(1,{table},{count},v{number},p{number},{channel});")
            }
            Self::Lines { channel, points, bounds: [min, max], limits: of } => {
                let count = points[0].len();
                let all = || points.iter().flatten();
                let arrays = reals("r", &all().map(|point| point.1).collect::<Vec<f64>>())
                    + &longs("x", &all().map(|point| point.0).collect::<Vec<i32>>());
                let (more, limits) = limits(of.as_ref().map(|of| &of[..]));
                format!(
                    "{arrays}{more}rtn = GTN_SetLaserDisTable1D(1,{count},r{number},x{number},{min:?},{max:?},{limits},\
                     {channel});"
                )
            }
            Self::Plane { channel, axes, x, y, ratios, bounds: [min, max], limits: of } => {
                let shorts = |name: &str, of: [i16; 2]| array("short", name, number, of.iter().map(i16::to_string));
                let arrays = shorts("i", *axes)
                    + &shorts("n", [x.len() as i16, y.len() as i16])
                    + &reals("r", ratios)
                    + &longs("x", x)
                    + &longs("y", y);
                let (more, limits) = limits(of.as_ref().map(|of| &of[..]));
                format!(
                    "{arrays}{more}rtn = GTN_SetLaserDisTable2D(1,i{number},n{number},r{number},x{number},y{number},\
                     {min:?},{max:?},{limits},{channel});"
                )
            }
        }
    }
}
