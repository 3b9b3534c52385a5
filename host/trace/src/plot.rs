//! Rows as a picture: position and velocity of each axis, path speed of each coordinate system with
//! the power of the laser beside it, gate, pulses and power of each laser, one panel below the
//! other, on one time axis.
//!
//! In: rows, and what the lasers' outputs did between them. Out: a PNG or an SVG. It owns a bounded
//! number of points for each curve, so that a trace of any length fits and no peak is lost. Digital
//! signals are drawn edge by edge where they are few, and as share of time where they are too
//! dense. The font is part of the program: a machine without fonts draws the same picture. Fails
//! with [`TraceError::Plot`] and [`TraceError::Window`].
mod activity;
mod canvas;
mod curve;
mod extra;
mod page;
mod panel;
mod preview;
mod route;
mod text;
mod window;
mod xy;

use crate::decimal::{position_f64, scaled_f64};
use crate::row::{AxisName, AxisPoint, CrdName, Header, LaserName, LaserPoint, PowerUnit, Row};
use crate::{Result, TraceError};
use activity::Activity;
use canvas::{HEADING_PX, Picture};
use curve::Curve;
use extra::Extra;
use panel::{Beside, Content, Frame, Panel, TIME_LABELS_PX};
use plant::beam::SignalChange;
use plotters::coord::Shift;
use plotters::prelude::*;
pub use preview::Preview;
use std::path::Path;
use window::Window;
pub use xy::Xy;

const POSITION: RGBColor = RGBColor(0x1f, 0x6f, 0xb4);
const VELOCITY: RGBColor = RGBColor(0xc8, 0x52, 0x1a);
const GATE: RGBColor = RGBColor(0x2d, 0x7d, 0x46);
const PULSES: RGBColor = RGBColor(0xb0, 0x2a, 0x3c);
const POWER: RGBColor = RGBColor(0x7b, 0x3f, 0xa6);
const ACCELERATION: RGBColor = RGBColor(0x8a, 0x6d, 0x1d);
const FOLLOWING_ERROR: RGBColor = RGBColor(0x4d, 0x5a, 0x68);

/// Panels that are drawn on request.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Panels {
    /// The mean acceleration from row to row.
    pub acceleration: bool,
    /// Planned position less encoder, where the encoders are those of the machine without wires
    /// (the crate `plant`): traces have no encoders.
    pub error: bool,
}

/// What to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct PlotOptions {
    /// Heading.
    pub title: String,
    /// Second line, smaller.
    pub subtitle: String,
    /// The picture begins at this time (ms); else with the trace.
    pub from_ms: Option<f64>,
    /// The picture ends at this time (ms); else with the trace.
    pub to_ms: Option<f64>,
    /// Width in pixels; the height follows from the number of panels.
    pub width: u32,
    /// Axes that are shown in mm; others are shown in pulses.
    pub millimetres: Vec<Millimetres>,
    /// Panels besides position and velocity.
    pub panels: Panels,
    /// For a page, which can be enlarged, and not for a picture.
    pub page: bool,
}

/// An axis in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Millimetres {
    /// The axis.
    pub axis: AxisName,
    /// Its letter.
    pub letter: char,
    /// Pulses a mm; below 0 where the axis counts down.
    pub per_mm: f64,
    /// Position in mm where the axis is at 0.
    pub zero: f64,
}

impl Default for PlotOptions {
    fn default() -> Self {
        PlotOptions {
            title: String::new(),
            subtitle: String::new(),
            from_ms: None,
            to_ms: None,
            width: 1280,
            millimetres: Vec::new(),
            panels: Panels::default(),
            page: false,
        }
    }
}

impl PlotOptions {
    /// A curve that keeps as much as this shows.
    fn curve(&self) -> Curve {
        Curve::new(if self.page { curve::PAGE_BUCKETS } else { curve::PICTURE_BUCKETS })
    }

    fn activity(&self, window: Window) -> Activity {
        Activity::new(window, if self.page { activity::PAGE_HIGHS } else { activity::PICTURE_HIGHS })
    }

    fn in_mm(&self, axis: AxisName) -> Option<&Millimetres> {
        self.millimetres.iter().find(|mm| mm.axis == axis)
    }

    /// Pulses a mm of a path, where all of its axes have the same.
    fn path_per_mm(&self) -> Option<f64> {
        let (first, others) = self.millimetres.split_first()?;
        let per_mm = first.per_mm.abs();
        others.iter().all(|other| other.per_mm.abs() == per_mm).then_some(per_mm)
    }

    /// Whether the times are ones that can be drawn.
    ///
    /// # Errors
    /// [`TraceError::Window`] with the reason.
    pub fn check(&self) -> Result<()> {
        Window::new(self.from_ms, self.to_ms).map(|_| ())
    }
}

/// A row as it is drawn.
#[derive(Debug, Clone, Default)]
struct Values {
    t_ns: u64,
    /// Position, velocity, acceleration, following error.
    axes: Vec<[f64; 4]>,
    crds: Vec<f64>,
    lasers: Vec<LaserPoint>,
}

/// What is drawn of a laser.
#[derive(Debug, Clone)]
struct Laser {
    name: LaserName,
    gate: Activity,
    pulses: Activity,
    has_pulses: bool,
    /// Power in each unit: a curve for every interval in which it was the unit.
    powers: [Vec<Curve>; 3],
    unit: Option<PowerUnit>,
}

/// Collects rows and draws them.
#[derive(Debug, Clone)]
pub struct Plot {
    options: PlotOptions,
    window: Window,
    axes: Vec<AxisName>,
    /// Position, velocity, acceleration and following error of each axis.
    curves: Vec<[Curve; 4]>,
    extra: Extra,
    /// Path speed of each coordinate system.
    crds: Vec<(CrdName, Curve)>,
    lasers: Vec<Laser>,
    before: Option<Values>,
    drawn: bool,
    /// Time of the last row.
    last_ns: u64,
}

impl Plot {
    /// An empty plot for a trace of this header.
    ///
    /// # Errors
    /// The times of the options are no window; a following error of a trace that leaves ticks out.
    pub fn new(header: &Header, options: PlotOptions) -> Result<Self> {
        let window = Window::new(options.from_ms, options.to_ms)?;
        if options.panels.error && header.every > 1 {
            return Err(TraceError::Plot(format!(
                "the following error needs a row each tick (--every 1); this trace has one every {}",
                header.every
            )));
        }
        let laser = |name: &LaserName| Laser {
            name: *name,
            gate: options.activity(window),
            pulses: options.activity(window),
            has_pulses: false,
            powers: Default::default(),
            unit: None,
        };
        Ok(Plot {
            window,
            axes: header.axes.clone(),
            curves: header.axes.iter().map(|_| [(); 4].map(|()| options.curve())).collect(),
            extra: Extra::new(header.axes.len()),
            crds: header.crds.iter().map(|name| (*name, options.curve())).collect(),
            lasers: header.lasers.iter().map(laser).collect(),
            options,
            before: None,
            drawn: false,
            last_ns: 0,
        })
    }

    /// Takes the changes of a laser's outputs (its index in the header) before the next row.
    pub fn change(&mut self, laser: usize, change: &SignalChange) {
        let Some(laser) = self.lasers.get_mut(laser) else { return };
        match change {
            SignalChange::Switch { at, level } => laser.gate.level(*at, *level),
            SignalChange::Energy { at, level } => {
                laser.has_pulses = true;
                laser.pulses.level(*at, *level);
            }
            SignalChange::Pulses(burst) => {
                laser.has_pulses = true;
                laser.pulses.burst(burst);
            }
            SignalChange::Dac { .. } => {}
        }
    }

    /// Takes a row.
    pub fn row(&mut self, row: &Row) {
        let Window { from, to } = self.window;
        for laser in &mut self.lasers {
            laser.gate.until(row.t_ns);
            laser.pulses.until(row.t_ns);
        }
        self.last_ns = row.t_ns;
        let path = self.options.path_per_mm().map_or(1.0, |per_mm| 60_000.0 / per_mm);
        let extra = match self.options.panels == Panels::default() {
            true => vec![(0.0, 0.0); row.axes.len()],
            false => self.extra.row(row),
        };
        let axes = self.axes.iter().zip(&row.axes).zip(extra);
        let values = Values {
            t_ns: row.t_ns,
            axes: axes.map(|((axis, point), extra)| self.shown(*axis, point, extra)).collect(),
            crds: row.crds.iter().map(|speed| scaled_f64(*speed) * path).collect(),
            lasers: row.lasers.clone(),
        };
        if let Some(before) = self.before.take() {
            if before.t_ns < from && row.t_ns > from {
                self.push(&before.towards(&values, from));
            }
            if before.t_ns < to && row.t_ns > to {
                self.push(&before.towards(&values, to));
            }
        }
        if (from..=to).contains(&row.t_ns) {
            self.push(&values);
        }
        self.before = Some(values);
    }

    /// Position, velocity, acceleration and following error of an axis: mm, mm/min, mm/s² and mm
    /// where it is known, else pulses and ms.
    fn shown(&self, axis: AxisName, point: &AxisPoint, (acceleration, error): (f64, f64)) -> [f64; 4] {
        let (pos, vel) = (position_f64(point.pos), scaled_f64(point.vel));
        match self.options.in_mm(axis) {
            Some(mm) => {
                let per_mm = mm.per_mm;
                [pos / per_mm + mm.zero, vel / per_mm * 60_000.0, acceleration / per_mm * 1e6, error / per_mm]
            }
            None => [pos, vel, acceleration, error],
        }
    }

    fn push(&mut self, values: &Values) {
        self.drawn = true;
        let t = values.t_ns as f64 * 1e-6;
        let Panels { acceleration, error } = self.options.panels;
        for (curves, axis) in self.curves.iter_mut().zip(&values.axes) {
            for (index, (curve, value)) in curves.iter_mut().zip(axis).enumerate() {
                match index {
                    // It held since the row before.
                    2 if acceleration => curve.hold_back(t, *value),
                    3 if error => curve.push((t, *value)),
                    0 | 1 => curve.push((t, *value)),
                    _ => {}
                }
            }
        }
        for ((_, curve), speed) in self.crds.iter_mut().zip(&values.crds) {
            curve.push((t, *speed));
        }
        for (laser, point) in self.lasers.iter_mut().zip(&values.lasers) {
            let curves = &mut laser.powers[point.unit as usize];
            if laser.unit.replace(point.unit) != Some(point.unit) {
                curves.push(self.options.curve());
            }
            if let Some(curve) = curves.last_mut() {
                curve.step(t, scaled_f64(point.power));
            }
        }
    }

    /// Size of the picture in pixels.
    pub fn size(&self) -> (u32, u32) {
        Picture::size(self)
    }

    /// Leaves out what did nothing: axes that stayed at 0, paths without speed, lasers without
    /// light or power. Where that is everything, nothing is left out.
    pub fn leave_out_idle(&mut self) {
        let moves = |curve: &Curve| curve.extremes().is_some_and(|extremes| extremes != (0.0, 0.0));
        let axes: Vec<bool> = self.curves.iter().map(|[position, ..]| moves(position)).collect();
        let shines = |laser: &Laser| {
            let powered = laser.powers.iter().flatten().any(moves);
            powered || laser.gate.highs().is_none_or(|highs| !highs.is_empty())
        };
        if !axes.contains(&true) && !self.lasers.iter().any(shines) {
            return;
        }
        let mut kept = axes.iter();
        self.axes.retain(|_| kept.next() == Some(&true));
        let mut kept = axes.iter();
        self.curves.retain(|_| kept.next() == Some(&true));
        self.crds.retain(|(_, speed)| moves(speed));
        self.lasers.retain(shines);
    }

    /// Writes a page of HTML in which time can be enlarged, with the path of two axes where there
    /// is one. It is one file, and needs no other.
    pub fn save_page(&self, path: &Path, xy: Option<&Xy>) -> Result<()> {
        if !self.drawn {
            return Err(self.window.is_empty(self.last_ns));
        }
        page::save(self, xy, path)
    }

    /// Draws a PNG or an SVG, as the path's extension says.
    pub fn save(&self, path: &Path) -> Result<()> {
        canvas::check_name(path)?;
        if !self.drawn {
            return Err(self.window.is_empty(self.last_ns));
        }
        canvas::save(self, path)
    }

    /// The panels from top to bottom.
    fn panels(&self) -> Vec<Panel<'_>> {
        let mut panels = Vec::new();
        for (axis, curves) in self.axes.iter().zip(&self.curves) {
            let (name, whats) = match self.options.in_mm(*axis) {
                Some(mm) => (
                    mm.letter.to_string(),
                    ["position (mm)", "velocity (mm/min)", "acceleration (mm/s²)", "following error (mm)"],
                ),
                None => (
                    title(*axis),
                    ["position (pulse)", "velocity (pulse/ms)", "acceleration (pulse/ms²)", "following error (pulse)"],
                ),
            };
            let colours = [POSITION, VELOCITY, ACCELERATION, FOLLOWING_ERROR];
            let asked = [true, true, self.options.panels.acceleration, self.options.panels.error];
            let shown = curves.iter().zip(whats.into_iter().zip(colours)).zip(asked).filter(|(_, asked)| *asked);
            for (curve, (what, colour)) in shown.map(|(shown, _)| shown) {
                let content = Content::Quantity(std::slice::from_ref(curve));
                let caption = format!("{name} {what}");
                panels.push(Panel { caption, colour, from_zero: false, content, beside: None });
            }
        }
        // Light that follows the speed is drawn below it.
        let power = self.lasers.iter().find_map(|laser| Some((laser, *laser.shown().first()?)));
        for (crd, curve) in &self.crds {
            panels.push(Panel {
                caption: match self.options.path_per_mm() {
                    Some(_) => "path speed (mm/min)".to_owned(),
                    None => format!("{} path speed (pulse/ms)", crd_title(*crd)),
                },
                colour: VELOCITY,
                from_zero: true,
                content: Content::Quantity(std::slice::from_ref(curve)),
                beside: power.map(|(laser, unit)| Beside {
                    caption: laser.caption(unit),
                    colour: POWER,
                    curves: &laser.powers[unit as usize],
                }),
            });
        }
        for laser in &self.lasers {
            let name = laser.title();
            panels.push(Panel {
                caption: format!("{name} gate"),
                colour: GATE,
                from_zero: false,
                content: Content::Digital(&laser.gate),
                beside: None,
            });
            if laser.has_pulses {
                panels.push(Panel {
                    caption: format!("{name} pulses"),
                    colour: PULSES,
                    from_zero: false,
                    content: Content::Digital(&laser.pulses),
                    beside: None,
                });
            }
            for unit in laser.shown() {
                panels.push(Panel {
                    caption: format!("{}, per tick", laser.caption(unit)),
                    colour: POWER,
                    from_zero: true,
                    content: Content::Quantity(&laser.powers[unit as usize]),
                    beside: None,
                });
            }
        }
        panels
    }

    /// From the first to the last instant that is drawn, ms.
    fn time_range(&self) -> (f64, f64) {
        let (from, to) = (self.window.from, self.window.to.min(self.last_ns));
        (from as f64 * 1e-6, to.max(from + 1) as f64 * 1e-6)
    }
}

impl Picture for Plot {
    fn size(&self) -> (u32, u32) {
        let panels = self.panels();
        let height = quantity_height(&panels);
        let all: u32 = panels.iter().map(|panel| panel.height(height)).sum();
        (self.options.width.max(480), HEADING_PX + all + TIME_LABELS_PX)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Result<()> {
        let mut below = canvas::head(area, &self.options, scale)?;
        let panels = self.panels();
        let beside = panels.iter().any(|panel| panel.beside.is_some());
        let frame = Frame { span: self.time_range(), height: quantity_height(&panels), beside, scale };
        for (index, panel) in panels.iter().enumerate() {
            let last = index + 1 == panels.len();
            let height = panel.height(frame.height) + if last { TIME_LABELS_PX } else { 0 };
            let (here, next) = below.split_vertically(height * scale);
            panel.draw(&here, &frame, last)?;
            below = next;
        }
        Ok(())
    }
}

impl Laser {
    fn title(&self) -> String {
        format!("laser {}", self.name.0)
    }

    fn caption(&self, unit: PowerUnit) -> String {
        format!("{} power: {}", self.title(), quantity(unit))
    }

    /// The units in which its power is drawn: one that was only the power-on one is not, beside one
    /// that was used.
    fn shown(&self) -> Vec<PowerUnit> {
        let was_used = |unit: &PowerUnit| {
            let mut extremes = self.powers[*unit as usize].iter().filter_map(Curve::extremes);
            extremes.any(|extremes| extremes != (0.0, 0.0))
        };
        let units = [PowerUnit::Percent, PowerUnit::Kilohertz, PowerUnit::Volt];
        let used: Vec<PowerUnit> = units.into_iter().filter(was_used).collect();
        if used.is_empty() { self.unit.into_iter().collect() } else { used }
    }
}

impl Values {
    /// Between this row and the next: motion is linear, lasers keep their state.
    fn towards(&self, next: &Values, t_ns: u64) -> Values {
        let part = (t_ns - self.t_ns) as f64 / (next.t_ns - self.t_ns) as f64;
        let between = |(a, b): (&[f64; 4], &[f64; 4])| {
            let mut mean = [0.0; 4];
            mean.iter_mut().zip(a.iter().zip(b)).for_each(|(mean, (a, b))| *mean = a + (b - a) * part);
            // What holds from row to row.
            mean[2] = b[2];
            mean
        };
        let axes = self.axes.iter().zip(&next.axes).map(between).collect();
        let crds = self.crds.iter().zip(&next.crds).map(|(a, b)| a + (b - a) * part).collect();
        Values { t_ns, axes, crds, lasers: self.lasers.clone() }
    }
}

/// Height of a quantity: the fewer there are, the larger.
fn quantity_height(panels: &[Panel<'_>]) -> u32 {
    match panels.iter().filter(|panel| matches!(panel.content, Content::Quantity(_))).count() {
        0..=2 => 300,
        3..=4 => 220,
        5..=8 => 160,
        _ => 124,
    }
}

/// What a person calls an axis.
fn title(axis: AxisName) -> String {
    match axis.core {
        1 => format!("axis {}", axis.axis),
        core => format!("core {core} axis {}", axis.axis),
    }
}

/// What a person calls a coordinate system.
fn crd_title(crd: CrdName) -> String {
    match crd.core {
        1 => format!("crd {}", crd.crd),
        core => format!("core {core} crd {}", crd.crd),
    }
}

/// What a person calls a laser's power.
fn quantity(unit: PowerUnit) -> &'static str {
    match unit {
        PowerUnit::Percent => "duty (%)",
        PowerUnit::Kilohertz => "pulse rate (kHz)",
        PowerUnit::Volt => "voltage (V)",
    }
}
