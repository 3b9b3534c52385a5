//! One panel of the picture: a quantity over time, or a digital signal.
//!
//! In: what is to be shown, and where. Out: drawing. Fails with [`TraceError::Plot`].
use super::activity::Activity;
use super::canvas::line;
use super::curve::{Curve, Point};
use super::text::{FAINT, INK, as_plot, font, place, tick_step, tick_text};
use crate::Result;
use plotters::coord::Shift;
use plotters::prelude::*;

pub(super) const GRID: RGBColor = RGBColor(0xe4, 0xe8, 0xec);
pub(super) const FRAME: RGBColor = RGBColor(0xb4, 0xbb, 0xc2);

/// Width of the value labels.
pub(super) const LEFT_PX: u32 = 88;
/// What is free on the right.
pub(super) const RIGHT_PX: u32 = 28;
/// Width of value labels on the right, where a panel has some.
const RIGHT_LABELS_PX: u32 = 64;
/// Height of a panel's caption.
pub(super) const CAPTION_PX: u32 = 26;
/// Height of the time axis' labels.
pub(super) const TIME_LABELS_PX: u32 = 58;
/// Pulses that begin closer to each other than this many pixels are not drawn one by one.
const MIN_PULSE_GAP_PX: f64 = 8.0;
/// Height of a digital signal.
const DIGITAL_HEIGHT_PX: u32 = 86;

/// What a panel shows.
pub(super) enum Content<'a> {
    /// A quantity: a curve for every interval in which it had a value.
    Quantity(&'a [Curve]),
    /// A level, or pulses.
    Digital(&'a Activity),
}

/// One panel.
pub(super) struct Panel<'a> {
    /// What it is of, with the unit.
    pub caption: String,
    pub colour: RGBColor,
    /// The values' axis begins at 0, whatever is shown.
    pub from_zero: bool,
    pub content: Content<'a>,
    /// A second quantity, with values on the right.
    pub beside: Option<Beside<'a>>,
}

/// A second quantity in a panel; its values begin at 0.
pub(super) struct Beside<'a> {
    pub caption: String,
    pub colour: RGBColor,
    pub curves: &'a [Curve],
}

/// Time axis and size, the same for all panels.
pub(super) struct Frame {
    /// Time range in ms.
    pub span: (f64, f64),
    /// Height of a quantity.
    pub height: u32,
    /// Some panel has values on the right.
    pub beside: bool,
    pub scale: u32,
}

/// How a digital signal is drawn.
enum Drawing {
    /// Every edge.
    Edges(Vec<Point>),
    /// Stretches of time.
    Shares(Vec<Cell>),
}

/// An interval of time.
struct Cell {
    /// Beginning and end in ms.
    from: f64,
    to: f64,
    /// Share of the time in which it is high, %.
    share: f64,
    /// It has both levels in it.
    both: bool,
}

impl Panel<'_> {
    /// Its height in pixels, without the time axis.
    pub fn height(&self, of_a_quantity: u32) -> u32 {
        match self.content {
            Content::Quantity(_) => of_a_quantity,
            Content::Digital(_) => DIGITAL_HEIGHT_PX,
        }
    }

    /// Draws it; the last one carries the time axis.
    pub fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, frame: &Frame, last: bool) -> Result<()> {
        let scale = frame.scale;
        let right = RIGHT_PX + if frame.beside { RIGHT_LABELS_PX } else { 0 };
        let width = (area.dim_in_pixel().0 / scale).saturating_sub(LEFT_PX + right).max(1);
        let drawing = match self.content {
            Content::Quantity(_) => None,
            Content::Digital(activity) => Some(drawing(activity, frame.span, width)),
        };
        let is_shares = matches!(drawing, Some(Drawing::Shares(_)));
        let caption = if is_shares {
            format!("{}, share of time (pale: on and off in it)", self.caption)
        } else {
            self.caption.clone()
        };
        area.draw(&Text::new(caption, place(LEFT_PX, 7, scale), font(14, self.colour, scale))).map_err(as_plot)?;

        let (start, end) = frame.span;
        // From ten seconds on, seconds read better than milliseconds; below a tenth of one,
        // microseconds.
        let (factor, time_unit) = match end - start {
            10_000.0.. => (1e-3, "s"),
            0.1.. => (1.0, "ms"),
            _ => (1e3, "µs"),
        };
        let (low, high) = match self.content {
            Content::Quantity(curves) => range(curves, self.from_zero),
            Content::Digital(_) => (-10.0, 110.0),
        };
        if let Some(beside) = &self.beside {
            let text = font(14, beside.colour, scale);
            let wide = text.font.box_size(&beside.caption).map_or(200, |size| size.0 / scale);
            let at = (LEFT_PX + width).saturating_sub(wide);
            area.draw(&Text::new(beside.caption.clone(), place(at, 7, scale), text)).map_err(as_plot)?;
        }
        let mut chart = ChartBuilder::on(area)
            .margin_top(CAPTION_PX * scale)
            .margin_right(right * scale)
            .set_label_area_size(LabelAreaPosition::Left, LEFT_PX * scale)
            .set_label_area_size(LabelAreaPosition::Bottom, if last { TIME_LABELS_PX * scale } else { 0 })
            .build_cartesian_2d(start * factor..end * factor, low..high)
            .map_err(as_plot)?;
        let step_x = tick_step((end - start) * factor);
        let step_y = tick_step(high - low);
        let value = |y: &f64| match (&drawing, *y) {
            (None, y) => tick_text(y, step_y),
            (Some(Drawing::Edges(_)), 0.0) => "off".to_owned(),
            (Some(Drawing::Edges(_)), 100.0) => "on".to_owned(),
            (Some(Drawing::Edges(_)), _) => String::new(),
            (Some(Drawing::Shares(_)), y) => format!("{y} %"),
        };
        chart
            .configure_mesh()
            .axis_style(FRAME.stroke_width(scale))
            .bold_line_style(GRID.stroke_width(scale))
            .light_line_style(TRANSPARENT)
            .set_all_tick_mark_size(5 * scale)
            .x_labels(12)
            .y_labels(match self.content {
                Content::Quantity(_) => (frame.height / 24).clamp(5, 10) as usize,
                Content::Digital(_) => 3,
            })
            .label_style(font(14, INK, scale))
            .axis_desc_style(font(14, FAINT, scale))
            .x_label_formatter(&|x| tick_text(*x, step_x))
            .y_label_formatter(&value)
            .x_desc(if last { format!("time ({time_unit})") } else { String::new() })
            .draw()
            .map_err(as_plot)?;

        let stroke = self.colour.stroke_width(2 * scale);
        if let Content::Quantity(curves) = self.content {
            for curve in curves {
                line(&mut chart, curve.points().map(|(t, v)| (t * factor, v)), stroke)?;
            }
        }
        if let Some(Beside { colour, curves, .. }) = &self.beside {
            let (least, most) = range(curves, true);
            let step = tick_step(most - least);
            // The other quantity has its own scale in the same area, drawn as a chart of its own.
            let mut second = ChartBuilder::on(area)
                .margin_top(CAPTION_PX * scale)
                .margin_left(LEFT_PX * scale)
                .margin_right(RIGHT_PX * scale)
                .margin_bottom(if last { TIME_LABELS_PX * scale } else { 0 })
                .set_label_area_size(LabelAreaPosition::Right, RIGHT_LABELS_PX * scale)
                .build_cartesian_2d(start * factor..end * factor, least..most)
                .map_err(as_plot)?;
            second
                .configure_mesh()
                .disable_mesh()
                .axis_style(FRAME.stroke_width(scale))
                .set_all_tick_mark_size(5 * scale)
                .y_labels((frame.height / 24).clamp(5, 10) as usize)
                .label_style(font(14, *colour, scale))
                .y_label_formatter(&|y| tick_text(*y, step))
                .draw()
                .map_err(as_plot)?;
            for curve in *curves {
                line(&mut second, curve.points().map(|(t, v)| (t * factor, v)), colour.stroke_width(2 * scale))?;
            }
        }
        match drawing {
            None => {}
            Some(Drawing::Edges(points)) => {
                line(&mut chart, points.into_iter().map(|(t, v)| (t * factor, v)), stroke)?;
            }
            Some(Drawing::Shares(cells)) => {
                // Pale: it has both levels. Strong: its fraction of the time.
                let bar = |cell: &Cell, top: f64, style: ShapeStyle| {
                    Rectangle::new([(cell.from * factor, 0.0), (cell.to * factor, top)], style)
                };
                let pale = cells.iter().filter(|c| c.both).map(|c| bar(c, 100.0, self.colour.mix(0.2).filled()));
                chart.draw_series(pale).map_err(as_plot)?;
                let strong = cells.iter().map(|c| bar(c, c.share, self.colour.filled()));
                chart.draw_series(strong).map_err(as_plot)?;
            }
        }
        Ok(())
    }
}

/// Range of values with some air; a constant gets a range around it.
fn range(curves: &[Curve], from_zero: bool) -> (f64, f64) {
    let zero = from_zero.then_some((0.0, 0.0));
    let all = curves.iter().filter_map(Curve::extremes).chain(zero);
    let Some((low, high)) = all.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else { return (-1.0, 1.0) };
    let air = if high > low { (high - low) * 0.08 } else { low.abs().max(1.0) * 0.5 };
    (low - air, high + air)
}

fn drawing(activity: &Activity, span: (f64, f64), width: u32) -> Drawing {
    let column = (span.1 - span.0) / f64::from(width);
    let apart = column * MIN_PULSE_GAP_PX * 1e6;
    match activity.highs() {
        Some(highs) if highs.windows(2).all(|pair| (pair[1].0 - pair[0].0) as f64 >= apart) => edges(highs, span),
        Some(highs) => Drawing::Shares(cells(highs, span, apart, column)),
        None => Drawing::Shares(columns(activity, span, width)),
    }
}

/// Every edge.
fn edges(highs: &[(u64, u64)], (start, end): (f64, f64)) -> Drawing {
    let mut points = vec![(start, 0.0)];
    for &(from, to) in highs {
        let (from, to) = ((from as f64 * 1e-6).max(start), (to as f64 * 1e-6).min(end));
        points.extend([(from, 0.0), (from, 100.0), (to, 100.0), (to, 0.0)]);
    }
    points.push((end, 0.0));
    // A level that is high at an end of the picture has no edge there.
    points.retain(|(t, level)| *level > 0.0 || start < *t && *t < end || highs.is_empty());
    if let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) {
        if first.0 > start {
            points.insert(0, (start, 0.0));
        }
        if last.0 < end {
            points.push((end, 0.0));
        }
    }
    Drawing::Edges(points)
}

/// The fraction of each pulse in the time to the next one, if that is close; a single pulse is a
/// bar, a `column` wide at least: light is seen, however short it is.
fn cells(highs: &[(u64, u64)], (start, end): (f64, f64), apart: f64, column: f64) -> Vec<Cell> {
    let mut cells: Vec<Cell> = Vec::new();
    let mut period = 0;
    for (index, &(from, to)) in highs.iter().enumerate() {
        let next = highs.get(index + 1).map_or(u64::MAX, |next| next.0);
        let near = ((next - from) as f64) < apart;
        // The last one of a train takes the time of the one before.
        let time = if near { next - from } else { period.min(next - from).max(to - from) };
        period = if near { time } else { 0 };
        let share = (to - from) as f64 / time as f64 * 100.0;
        let begin = (from as f64 * 1e-6).max(start);
        let cell = Cell {
            from: begin,
            to: ((from + time) as f64 * 1e-6).max(if near { begin } else { begin + column }).min(end),
            share: (share * 10.0).round() / 10.0,
            both: share < 100.0,
        };
        join(&mut cells, cell);
    }
    cells
}

/// The share of time in each column of a pixel.
fn columns(activity: &Activity, (start, end): (f64, f64), width: u32) -> Vec<Cell> {
    let column = (end - start) / f64::from(width);
    let mut columns: Vec<Cell> = Vec::new();
    for index in 0..width {
        let (from, to) = (start + column * f64::from(index), start + column * f64::from(index + 1));
        let bin = activity.between(from * 1e6, to * 1e6);
        // Tenths of a percent: finer steps are not visible.
        let share = (bin.on / (column * 1e6) * 1000.0).round().clamp(0.0, 1000.0) / 10.0;
        let both = bin.edges > 0.0;
        if share > 0.0 || both {
            join(&mut columns, Cell { from, to, share, both });
        }
    }
    columns
}

/// One more cell; like ones that touch become one.
fn join(cells: &mut Vec<Cell>, cell: Cell) {
    match cells.last_mut() {
        Some(last) if (last.share, last.both) == (cell.share, cell.both) && cell.from - last.to < 1e-9 => {
            last.to = cell.to;
        }
        _ => cells.push(cell),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pulses of a µs among those of a train, in a picture of a second: a column each, at least.
    #[test]
    fn a_pulse_that_is_alone_is_seen() {
        let train = (0..400).map(|n| (n * 10_000, n * 10_000 + 1_000));
        let alone = [100_000_000, 900_000_000].map(|at| (at, at + 1_000));
        let highs: Vec<(u64, u64)> = train.chain(alone).collect();
        let column = 1000.0 / 800.0;
        let cells = cells(&highs, (0.0, 1000.0), column * MIN_PULSE_GAP_PX * 1e6, column);
        let [.., first, last] = &cells[..] else { panic!("{} cells", cells.len()) };
        for (cell, at) in [(first, 100.0), (last, 900.0)] {
            assert!((cell.from, cell.share) == (at, 100.0) && cell.to >= at + column, "{at} to {}", cell.to);
        }
    }
}
