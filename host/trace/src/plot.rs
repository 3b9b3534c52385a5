//! Rows as a picture: position and velocity of each axis, one panel below the other, time along the
//! bottom.
//!
//! In: rows. Out: a PNG or an SVG. It owns, per curve, at most [`BUCKETS`] pairs of least and
//! greatest value, so that a trace of any length fits and no peak is lost. The font is part of the
//! program: a machine without fonts draws the same picture. Fails with [`TraceError::Plot`].
use crate::decimal::{position_f64, velocity_f64};
use crate::row::{AxisName, Header, Row};
use crate::{Result, TraceError};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Once;

/// Most pairs of extremes that a curve keeps.
const BUCKETS: usize = 4096;

/// A PNG is drawn this many times as large and made smaller.
const SMOOTH: u32 = 2;

const INK: RGBColor = RGBColor(0x24, 0x29, 0x2f);
const FAINT: RGBColor = RGBColor(0x6e, 0x77, 0x81);
const GRID: RGBColor = RGBColor(0xe4, 0xe8, 0xec);
const FRAME: RGBColor = RGBColor(0xb4, 0xbb, 0xc2);
const POSITION: RGBColor = RGBColor(0x1f, 0x6f, 0xb4);
const VELOCITY: RGBColor = RGBColor(0xc8, 0x52, 0x1a);

/// What to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct PlotOptions {
    /// Heading.
    pub title: String,
    /// Second line, smaller.
    pub subtitle: String,
    /// Rows before this time (ms) are left out.
    pub from_ms: Option<f64>,
    /// Rows after this time (ms) are left out.
    pub to_ms: Option<f64>,
    /// Width in pixels; the height follows from the number of axes.
    pub width: u32,
}

impl Default for PlotOptions {
    fn default() -> Self {
        PlotOptions { title: String::new(), subtitle: String::new(), from_ms: None, to_ms: None, width: 1280 }
    }
}

/// A value and its time in ms.
type Point = (f64, f64);

/// One quantity over time, thinned to its extremes.
#[derive(Debug, Clone, Default)]
struct Curve {
    /// Least and greatest value of each run of `share` rows.
    buckets: Vec<(Point, Point)>,
    open: Option<(Point, Point)>,
    filled: usize,
    share: usize,
    last: Option<Point>,
}

impl Curve {
    fn push(&mut self, point: Point) {
        self.share = self.share.max(1);
        self.last = Some(point);
        self.open = Some(match self.open {
            None => (point, point),
            Some(both) => merge(both, (point, point)),
        });
        self.filled += 1;
        if self.filled == self.share {
            self.filled = 0;
            self.buckets.extend(self.open.take());
            if self.buckets.len() == BUCKETS {
                self.buckets =
                    self.buckets.chunks(2).map(|c| c.iter().copied().reduce(merge).unwrap_or(c[0])).collect();
                self.share *= 2;
            }
        }
    }

    /// The points to draw, in the order of time.
    fn points(&self) -> impl Iterator<Item = Point> + '_ {
        let pairs = self.buckets.iter().copied().chain(self.open);
        let first_to_last = pairs.flat_map(|(low, high)| if low.0 <= high.0 { [low, high] } else { [high, low] });
        first_to_last.chain(self.last)
    }

    /// Range of the values with some air; a constant gets a range around it.
    fn range(&self) -> (f64, f64) {
        let (low, high) =
            self.points().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.1), high.max(p.1)));
        if low > high {
            return (-1.0, 1.0);
        }
        let air = if high > low { (high - low) * 0.08 } else { low.abs().max(1.0) * 0.5 };
        (low - air, high + air)
    }
}

fn merge(a: (Point, Point), b: (Point, Point)) -> (Point, Point) {
    (if b.0.1 < a.0.1 { b.0 } else { a.0 }, if b.1.1 > a.1.1 { b.1 } else { a.1 })
}

/// Collects rows and draws them.
#[derive(Debug, Clone)]
pub struct Plot {
    axes: Vec<AxisName>,
    /// Position and velocity of each axis.
    curves: Vec<[Curve; 2]>,
    options: PlotOptions,
    rows: u64,
}

impl Plot {
    /// An empty plot for a trace of this header.
    pub fn new(header: &Header, options: PlotOptions) -> Self {
        Plot { axes: header.axes.clone(), curves: vec![Default::default(); header.axes.len()], options, rows: 0 }
    }

    /// Takes a row.
    pub fn row(&mut self, row: &Row) {
        let t = row.t_ns as f64 * 1e-6;
        if self.options.from_ms.is_some_and(|from| t < from) || self.options.to_ms.is_some_and(|to| t > to) {
            return;
        }
        self.rows += 1;
        for (curves, point) in self.curves.iter_mut().zip(&row.axes) {
            curves[0].push((t, position_f64(point.pos)));
            curves[1].push((t, velocity_f64(point.vel)));
        }
    }

    /// Size of the picture in pixels.
    pub fn size(&self) -> (u32, u32) {
        let axes = self.axes.len().max(1) as u32;
        (self.options.width.max(480), HEAD + axes * 2 * panel_height(axes) + FOOT)
    }

    /// Draws a PNG or an SVG, as the path's extension says.
    pub fn save(&self, path: &Path) -> Result<()> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        if !matches!(extension.as_str(), "png" | "svg") {
            return Err(TraceError::Plot(format!("{}: a plot's name ends in .png or .svg", path.display())));
        }
        if self.rows == 0 {
            return Err(TraceError::Plot("no row of the trace lies in the time asked for".into()));
        }
        match extension.as_str() {
            "svg" => self.draw(&SVGBackend::new(path, self.size()).into_drawing_area(), 1),
            _ => self.save_png(path),
        }
    }

    /// Draws [`SMOOTH`] times as large and takes means, so that slanted lines are smooth.
    fn save_png(&self, path: &Path) -> Result<()> {
        let (width, height) = self.size();
        let large = (width * SMOOTH, height * SMOOTH);
        let mut pixels = vec![0; large.0 as usize * large.1 as usize * 3];
        self.draw(&BitMapBackend::with_buffer(&mut pixels, large).into_drawing_area(), SMOOTH)?;
        let small = shrink(&pixels, large.0 as usize, SMOOTH as usize);
        let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(&small)?;
            writer.finish()
        });
        written.map_err(|e| TraceError::Plot(format!("{}: {e}", path.display())))
    }

    /// Draws everything, `scale` times as large.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Result<()> {
        load_font();
        area.fill(&WHITE).map_err(as_plot)?;
        let (head, rest) = area.split_vertically(HEAD * scale);
        let lines = [(&self.options.title, 12, 22, INK), (&self.options.subtitle, 40, 14, FAINT)];
        for (text, y, size, colour) in lines {
            head.draw(&Text::new(text.clone(), place(24, y, scale), font(size, colour, scale))).map_err(as_plot)?;
        }
        let span = self.time_range();
        let height = panel_height(self.axes.len() as u32) * scale;
        let panels = self.axes.len() * 2;
        let mut below = rest;
        for (index, (axis, curves)) in self.axes.iter().zip(&self.curves).enumerate() {
            for (half, curve) in curves.iter().enumerate() {
                let last = index * 2 + half + 1 == panels;
                let (panel, next) = below.split_vertically(if last { height + FOOT * scale } else { height });
                draw_panel(&panel, &Panel { axis: *axis, half, curve, span, last, scale })?;
                below = next;
            }
        }
        area.present().map_err(as_plot)
    }

    fn time_range(&self) -> (f64, f64) {
        let times = || self.curves.iter().flat_map(|c| c[0].points().map(|p| p.0));
        let (first, last) =
            times().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
        match (first, last) {
            (first, last) if first > last => (0.0, 1.0),
            (first, last) if first == last => (first, first + 1.0),
            range => range,
        }
    }
}

/// Height of the heading.
const HEAD: u32 = 62;
/// Height of the time axis' labels.
const FOOT: u32 = 58;

fn panel_height(axes: u32) -> u32 {
    match axes {
        0..=1 => 300,
        2 => 220,
        3..=4 => 160,
        _ => 124,
    }
}

/// What one panel shows.
struct Panel<'a> {
    axis: AxisName,
    /// 0 position, 1 velocity.
    half: usize,
    curve: &'a Curve,
    /// Time range in ms.
    span: (f64, f64),
    /// The last one carries the time axis.
    last: bool,
    scale: u32,
}

/// Height of a panel's caption.
const CAPTION: u32 = 26;

fn draw_panel<B: DrawingBackend>(area: &DrawingArea<B, Shift>, panel: &Panel<'_>) -> Result<()> {
    let (name, unit, colour) =
        if panel.half == 0 { ("position", "pulse", POSITION) } else { ("velocity", "pulse/ms", VELOCITY) };
    // From ten seconds on, seconds read better than milliseconds.
    let (start, end) = panel.span;
    let (factor, time_unit) = if end - start >= 10_000.0 { (1e-3, "s") } else { (1.0, "ms") };
    let (low, high) = panel.curve.range();
    let scale = panel.scale;
    let height = area.dim_in_pixel().1 / scale;
    let caption = format!("{} {name} ({unit})", title(panel.axis));
    area.draw(&Text::new(caption, place(LEFT, 7, scale), font(14, colour, scale))).map_err(as_plot)?;
    let mut chart = ChartBuilder::on(area)
        .margin_top(CAPTION * scale)
        .margin_right(28 * scale)
        .set_label_area_size(LabelAreaPosition::Left, LEFT * scale)
        .set_label_area_size(LabelAreaPosition::Bottom, if panel.last { FOOT * scale } else { 0 })
        .build_cartesian_2d(start * factor..end * factor, low..high)
        .map_err(as_plot)?;
    let step_x = tick_step((end - start) * factor);
    let step_y = tick_step(high - low);
    chart
        .configure_mesh()
        .axis_style(FRAME.stroke_width(scale))
        .bold_line_style(GRID.stroke_width(scale))
        .light_line_style(TRANSPARENT)
        .set_all_tick_mark_size(5 * scale)
        .x_labels(12)
        .y_labels((height / 24).clamp(5, 10) as usize)
        .label_style(font(14, INK, scale))
        .axis_desc_style(font(14, FAINT, scale))
        .x_label_formatter(&|x| tick_text(*x, step_x))
        .y_label_formatter(&|y| tick_text(*y, step_y))
        .x_desc(if panel.last { format!("time ({time_unit})") } else { String::new() })
        .draw()
        .map_err(as_plot)?;
    let line = panel.curve.points().map(|(t, v)| (t * factor, v));
    chart.draw_series(LineSeries::new(line, colour.stroke_width(2 * scale))).map_err(as_plot)?;
    Ok(())
}

/// Width of the value labels.
const LEFT: u32 = 88;

/// A place in pixels of the picture.
fn place(x: u32, y: u32, scale: u32) -> (i32, i32) {
    ((x * scale) as i32, (y * scale) as i32)
}

/// The built-in font in this size and colour.
fn font(size: u32, colour: RGBColor, scale: u32) -> TextStyle<'static> {
    ("sans-serif", size * scale).into_font().color(&colour)
}

/// Means of squares of `by` pixels.
fn shrink(pixels: &[u8], width: usize, by: usize) -> Vec<u8> {
    let mut small = Vec::with_capacity(pixels.len() / (by * by));
    for rows in pixels.chunks_exact(width * 3 * by) {
        for x in 0..width / by {
            for channel in 0..3 {
                let of = |row: usize, column: usize| rows[(row * width + x * by + column) * 3 + channel];
                let sum: usize = (0..by * by).map(|i| usize::from(of(i / by, i % by))).sum();
                small.push((sum / (by * by)) as u8);
            }
        }
    }
    small
}

/// What a person calls an axis.
fn title(axis: AxisName) -> String {
    match axis.core {
        1 => format!("axis {}", axis.axis),
        core => format!("core {core} axis {}", axis.axis),
    }
}

/// A step that is surely not coarser than the distance of two labels.
fn tick_step(range: f64) -> f64 {
    10f64.powf((range / 20.0).max(1e-12).log10().floor())
}

/// A label with as many decimals as the step needs.
fn tick_text(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn as_plot<E: std::error::Error + Send + Sync>(e: DrawingAreaErrorKind<E>) -> TraceError {
    TraceError::Plot(e.to_string())
}

/// Makes the built-in font known to the drawing library, once.
fn load_font() {
    static LOADED: Once = Once::new();
    static FONT: &[u8] = include_bytes!("../assets/DejaVuSans-subset.ttf");
    LOADED.call_once(|| {
        // It fails only for bytes that are no font; a test draws with it.
        let _ = register_font("sans-serif", FontStyle::Normal, FONT);
    });
}
