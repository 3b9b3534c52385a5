//! One axis over another: the path, its direction and time, and the light on it.
//!
//! In: rows, and when lasers gave light. Out: a PNG or an SVG with the same scale in both
//! directions. What is lit has the colour of its power, which a bar explains; light of a second
//! laser has a colour of its own. Owns a [`Route`] for
//! each laser. Fails with [`TraceError::Plot`] and [`TraceError::Window`].
use super::canvas::{self, Chart, HEADING_PX, Picture, Sign};
use super::panel::{CAPTION_PX, FRAME, GRID, LEFT_PX, RIGHT_PX, TIME_LABELS_PX};
use super::route::{Node, Power, Route};
use super::text::{FAINT, INK, as_plot, font, place, tick_step, tick_text};
use super::window::Window;
use super::{Millimetres, POSITION, PlotOptions, quantity, title};
use crate::decimal::{position_f64, scaled_f64};
use crate::row::{AxisName, Header, LaserName, PowerUnit, Row};
use crate::{Result, TraceError};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// Width of the bar that explains colours, with its labels.
const COLOUR_BAR_PX: u32 = 132;
/// Pixels from one arrow to the next.
const ARROW_GAP_PX: f64 = 130.0;
/// Most arrows.
const MAX_ARROWS: f64 = 60.0;
/// A direction is that of this many pixels.
const DIRECTION_PX: f64 = 4.0;
/// Colours from the least to the greatest power.
const COLOURS: [RGBColor; 5] = [
    RGBColor(0x25, 0x3c, 0x9e),
    RGBColor(0x7b, 0x3f, 0xa6),
    RGBColor(0xc4, 0x2f, 0x6b),
    RGBColor(0xe0, 0x5a, 0x1f),
    RGBColor(0xf2, 0xa9, 0x00),
];
/// Pixels from one drawn point to the next.
const POINT_GAP_PX: i32 = 2;
/// Colours that can be distinguished.
const COLOUR_STEPS: usize = 64;
/// Light of a laser that the bar is not for.
const OTHER: RGBColor = RGBColor(0x0b, 0x7d, 0x6e);
/// The path without light.
const DARK: RGBColor = RGBColor(0x9a, 0xa4, 0xae);

/// Collects rows and draws one axis over another.
#[derive(Debug, Clone)]
pub struct Xy {
    options: PlotOptions,
    window: Window,
    /// Places of x and y in a row.
    columns: (usize, usize),
    axes: (AxisName, AxisName),
    lasers: Vec<Beam>,
    before: Option<Row>,
    drawn: bool,
    last_ns: u64,
}

/// A laser and the path with its light; without lasers there is one without a name.
#[derive(Debug, Clone, Default)]
struct Beam {
    name: Option<LaserName>,
    light: bool,
    /// Light that began or ended since the last row.
    edges: Vec<(u64, bool)>,
    /// Output of the last light.
    power: Option<Power>,
    route: Route<Power>,
}

impl Xy {
    /// An empty picture for a trace of this header: the second axis over the first.
    ///
    /// # Errors
    /// An axis is not traced; the times of the options are no window.
    pub fn new(header: &Header, axes: (AxisName, AxisName), options: PlotOptions) -> Result<Self> {
        let find = |axis: AxisName| {
            let place = header.axes.iter().position(|name| *name == axis);
            place.ok_or_else(|| TraceError::Plot(format!("{} is not in the trace", title(axis))))
        };
        let columns = (find(axes.0)?, find(axes.1)?);
        let beam = |name: &LaserName| Beam { name: Some(*name), ..Beam::default() };
        let lasers: Vec<Beam> = header.lasers.iter().map(beam).collect();
        Ok(Xy {
            window: Window::new(options.from_ms, options.to_ms)?,
            options,
            columns,
            axes,
            lasers: if lasers.is_empty() { vec![Beam::default()] } else { lasers },
            before: None,
            drawn: false,
            last_ns: 0,
        })
    }

    /// Takes the begin or end of a laser's light before the next row.
    pub fn light(&mut self, laser: usize, at: u64, on: bool) {
        if let Some(beam) = self.lasers.get_mut(laser) {
            beam.edges.push((at, on));
        }
    }

    /// Takes a row.
    pub fn row(&mut self, row: &Row) {
        let Window { from, to } = self.window;
        self.last_ns = row.t_ns;
        let here = self.point(row);
        let (begin, start) = self.before.as_ref().map_or((row.t_ns, here), |before| (before.t_ns, self.point(before)));
        let at = |t: u64| {
            let part = if row.t_ns > begin { (t - begin) as f64 / (row.t_ns - begin) as f64 } else { 1.0 };
            (start.0 + (here.0 - start.0) * part, start.1 + (here.1 - start.1) * part)
        };
        for (place, beam) in self.lasers.iter_mut().enumerate() {
            let power_of = |row: &Row| row.lasers.get(place).map(|laser| (laser.unit, scaled_f64(laser.power)));
            let (first, next) = (self.before.as_ref().and_then(power_of), power_of(row));
            let mut put = |beam: &mut Beam, t: u64| {
                if (from..=to).contains(&t) {
                    self.drawn = true;
                    let light = beam.power.filter(|_| beam.light);
                    beam.route.push(t, at(t), light);
                }
            };
            let was_lit = beam.light;
            if was_lit {
                beam.power = first;
            }
            if begin < from && from < row.t_ns {
                put(beam, from);
            }
            for (at, on) in std::mem::take(&mut beam.edges) {
                beam.light = on;
                if !was_lit && on {
                    // Nothing was output at the row before.
                    beam.power = next;
                }
                put(beam, at.clamp(begin, row.t_ns));
            }
            if begin < to && to < row.t_ns {
                put(beam, to);
            }
            if beam.light {
                beam.power = next;
            }
            put(beam, row.t_ns);
        }
        self.before = Some(row.clone());
    }

    fn point(&self, row: &Row) -> (f64, f64) {
        let value = |place: usize, axis: AxisName| {
            let pulses = row.axes.get(place).map_or(0.0, |point| position_f64(point.pos));
            self.millimetres(axis).map_or(pulses, |mm| pulses / mm.per_mm + mm.zero)
        };
        (value(self.columns.0, self.axes.0), value(self.columns.1, self.axes.1))
    }

    fn millimetres(&self, axis: AxisName) -> Option<&Millimetres> {
        self.options.millimetres.iter().find(|mm| mm.axis == axis)
    }

    fn label(&self, axis: AxisName) -> String {
        match self.millimetres(axis) {
            Some(mm) => format!("{} (mm)", mm.letter),
            None => format!("{} position (pulse)", title(axis)),
        }
    }

    /// An SVG as a text; none if nothing lies in the time that is drawn.
    pub(super) fn svg(&self) -> Result<Option<String>> {
        self.drawn.then(|| canvas::svg(self)).transpose()
    }

    /// Draws a PNG or an SVG, as the path's extension says.
    ///
    /// # Errors
    /// Another extension; nothing to draw; the file.
    pub fn save(&self, path: &Path) -> Result<()> {
        canvas::check_name(path)?;
        if !self.drawn {
            return Err(self.window.is_empty(self.last_ns));
        }
        canvas::save(self, path)
    }

    /// The first laser that gave light, else the first.
    fn beam(&self) -> Option<&Beam> {
        self.lasers.iter().find(|beam| beam.is_lit()).or(self.lasers.first())
    }

    /// A second laser that gave light.
    fn other(&self) -> Option<&Beam> {
        self.lasers.iter().filter(|beam| beam.is_lit()).nth(1)
    }

    fn bar_width(&self) -> u32 {
        if self.beam().is_some_and(Beam::is_lit) { COLOUR_BAR_PX } else { 0 }
    }

    /// Width and height of the diagram in pixels, and the ranges that it shows: as many pulses a
    /// pixel in x as in y.
    fn layout(&self) -> ((u32, u32), [(f64, f64); 2]) {
        let most_wide = f64::from(self.options.width.max(480) - LEFT_PX - RIGHT_PX - self.bar_width());
        let extent = self.beam().and_then(|beam| beam.route.extent()).unwrap_or_default();
        canvas::same_scale(extent, most_wide)
    }
}

impl Beam {
    fn is_lit(&self) -> bool {
        self.route.nodes().iter().any(|node| node.light.is_some())
    }

    /// It moves without light somewhere.
    fn has_dark(&self) -> bool {
        let moves = |pair: &[Node<Power>]| pair[1].light.is_none() && (pair[0].x, pair[0].y) != (pair[1].x, pair[1].y);
        self.route.nodes().windows(2).any(moves)
    }

    /// The unit that the bar shows, and its range from 0 on.
    fn scale(&self) -> Option<(PowerUnit, f64)> {
        let unit = self.route.nodes().iter().find_map(|node| node.light)?.0;
        let powers = self.route.nodes().iter().filter_map(|node| node.light).filter(|power| power.0 == unit);
        Some((unit, powers.map(|power| power.1.abs()).fold(0.0, f64::max)))
    }
}

/// The colour of a share of the greatest power.
fn colour(share: f64) -> RGBColor {
    let place = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let left = (place as usize).min(COLOURS.len() - 2);
    let part = place - left as f64;
    let (a, b) = (COLOURS[left], COLOURS[left + 1]);
    let mix = |a: u8, b: u8| (f64::from(a) + (f64::from(b) - f64::from(a)) * part).round() as u8;
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

/// The shade of a power; light of another unit has none.
fn shade(light: Power, (unit, most): (PowerUnit, f64)) -> Option<usize> {
    let share = if most > 0.0 { light.1.abs() / most } else { 0.0 };
    (light.0 == unit).then_some((share * (COLOUR_STEPS - 1) as f64).round() as usize)
}

impl Picture for Xy {
    fn size(&self) -> (u32, u32) {
        let (width, height) = self.layout().0;
        (LEFT_PX + width + RIGHT_PX + self.bar_width(), HEADING_PX + CAPTION_PX + height + TIME_LABELS_PX)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Result<()> {
        let Some(beam) = self.beam() else { return Ok(()) };
        let rest = canvas::head(area, &self.options, scale)?;
        let ((width, _), [x, y]) = self.layout();
        let bar = beam.scale();
        let (left, right) =
            rest.split_horizontally((LEFT_PX + width + if bar.is_some() { 0 } else { RIGHT_PX }) * scale);
        let caption = |text: String, at: u32, colour| Text::new(text, place(at, 7, scale), font(14, colour, scale));
        let label = self.label(self.axes.1);
        let begins = LEFT_PX + font(14, INK, 1).font.box_size(&label).map_or(120, |size| size.0) + 16;
        left.draw(&caption(label, LEFT_PX, POSITION)).map_err(as_plot)?;
        let mut ends = LEFT_PX + width;
        if let Some(bar) = bar {
            let name = beam.name.map_or(0, |name| name.0);
            let text = format!("light of laser {name}, {}", quantity(bar.0));
            let wide = font(14, INK, 1).font.box_size(&text).map_or(240, |size| size.0);
            let at = (LEFT_PX + width + COLOUR_BAR_PX).saturating_sub(wide + 8);
            rest.draw(&caption(text, at, INK)).map_err(as_plot)?;
            draw_bar(&right, bar, scale)?;
            ends = at.saturating_sub(24);
        }
        let other = self.other().map(|other| (other, other.name.map_or(0, |name| name.0)));
        let light = other.map(|(_, name)| format!("light of laser {name}"));
        let mut signs = vec![(Sign::Dot, INK, "end"), (Sign::Ring, INK, "begin")];
        signs.extend((bar.is_some() && beam.has_dark()).then_some((Sign::Line, DARK, "in the dark")));
        // Where there is no room, the last ones are left out.
        signs.splice(0..0, light.as_deref().map(|light| (Sign::Line, OTHER, light)));
        canvas::legend(&rest, (begins, ends), &signs, scale)?;
        let mut chart = ChartBuilder::on(&left)
            .margin_top(CAPTION_PX * scale)
            .margin_right(if bar.is_some() { 0 } else { RIGHT_PX * scale })
            .set_label_area_size(LabelAreaPosition::Left, LEFT_PX * scale)
            .set_label_area_size(LabelAreaPosition::Bottom, TIME_LABELS_PX * scale)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)
            .map_err(as_plot)?;
        let (step_x, step_y) = (tick_step(x.1 - x.0), tick_step(y.1 - y.0));
        chart
            .configure_mesh()
            .axis_style(FRAME.stroke_width(scale))
            .bold_line_style(GRID.stroke_width(scale))
            .light_line_style(TRANSPARENT)
            .set_all_tick_mark_size(5 * scale)
            .x_labels(12)
            .y_labels(10)
            .label_style(font(14, INK, scale))
            .axis_desc_style(font(14, FAINT, scale))
            .x_label_formatter(&|x| tick_text(*x, step_x))
            .y_label_formatter(&|y| tick_text(*y, step_y))
            .x_desc(self.label(self.axes.0))
            .draw()
            .map_err(as_plot)?;
        draw_path(&mut chart, beam, false, scale)?;
        if let Some((other, _)) = other {
            draw_path(&mut chart, other, true, scale)?;
        }
        draw_signs(&chart, beam.route.nodes(), scale)
    }
}

/// The legend of colour and power.
fn draw_bar<B: DrawingBackend>(area: &DrawingArea<B, Shift>, (_, most): (PowerUnit, f64), scale: u32) -> Result<()> {
    let most = if most > 0.0 { most } else { 1.0 };
    let mut chart = ChartBuilder::on(area)
        .margin_top(CAPTION_PX * scale)
        .margin_left(28 * scale)
        .margin_right(RIGHT_PX * scale)
        .margin_bottom(TIME_LABELS_PX * scale)
        .set_label_area_size(LabelAreaPosition::Right, 58 * scale)
        .build_cartesian_2d(0.0..1.0, 0.0..most)
        .map_err(as_plot)?;
    let step = tick_step(most);
    let band = |index: usize| {
        let (low, high) = (index as f64 / COLOUR_STEPS as f64, (index + 1) as f64 / COLOUR_STEPS as f64);
        Rectangle::new([(0.0, low * most), (1.0, high * most)], colour((low + high) / 2.0).filled())
    };
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(FRAME.stroke_width(scale))
        .y_labels(8)
        .set_all_tick_mark_size(5 * scale)
        .label_style(font(14, INK, scale))
        .y_label_formatter(&|y| tick_text(*y, step))
        .draw()
        .map_err(as_plot)?;
    chart.draw_series((0..COLOUR_STEPS).map(band)).map_err(as_plot)?;
    Ok(())
}

/// The path, the dark parts first. Of a laser beside (`other`) the light alone, in one colour.
fn draw_path<B: DrawingBackend>(chart: &mut Chart<'_, B>, beam: &Beam, other: bool, scale: u32) -> Result<()> {
    let bar = beam.scale().filter(|_| !other);
    let plain = match (bar, beam.name) {
        (None, None) => POSITION.stroke_width(2 * scale),
        _ => DARK.stroke_width(scale + scale / 2),
    };
    let shaded = |light: Option<Power>| light.map(|light| bar.and_then(|bar| shade(light, bar)));
    for lit in [false, true].into_iter().skip(usize::from(other)) {
        let mut remaining = beam.route.nodes();
        while let Some((first, after)) = remaining.split_first() {
            let shade = shaded(first.light);
            let same = after.iter().take_while(|node| shaded(node.light) == shade).count();
            // The node where another shade begins is the end of this one.
            let path = remaining.get(..(same + 2).min(remaining.len())).unwrap_or(remaining);
            remaining = after.get(same..).unwrap_or(&[]);
            let stroke = match shade {
                None => plain,
                Some(None) if other => OTHER.stroke_width(3 * scale),
                Some(None) => INK.stroke_width(3 * scale),
                Some(Some(shade)) => colour(shade as f64 / (COLOUR_STEPS - 1) as f64).stroke_width(3 * scale),
            };
            if lit != shade.is_some() {
                continue;
            }
            let points = spaced(chart, path, POINT_GAP_PX * scale as i32);
            canvas::line(chart, points, stroke)?;
            // Light at standstill.
            let standstills = path.windows(2).filter(|pair| (pair[0].x, pair[0].y) == (pair[1].x, pair[1].y));
            let dots = standstills.filter(|pair| lit && pair[1].from > pair[0].from);
            let dot = |pair: &[Node<Power>]| Circle::new((pair[0].x, pair[0].y), 4 * scale, stroke.color.filled());
            chart.draw_series(dots.map(dot)).map_err(as_plot)?;
        }
    }
    Ok(())
}

/// The points of a path without those closer (in pixels) to the one before: rounding to whole
/// pixels would make it crooked.
pub(super) fn spaced<B: DrawingBackend, L>(chart: &Chart<'_, B>, path: &[Node<L>], near: i32) -> Vec<(f64, f64)> {
    let Some((last, before)) = path.split_last() else { return Vec::new() };
    let mut kept: Option<(i32, i32)> = None;
    let mut points: Vec<(f64, f64)> = Vec::new();
    for node in before {
        let here = chart.backend_coord(&(node.x, node.y));
        if kept.is_none_or(|kept| (here.0 - kept.0).abs().max((here.1 - kept.1).abs()) >= near) {
            kept = Some(here);
            points.push((node.x, node.y));
        }
    }
    points.push((last.x, last.y));
    points
}

/// Arrows along the path, dots at even times, its begin and its end.
fn draw_signs<B: DrawingBackend>(chart: &Chart<'_, B>, nodes: &[Node<Power>], scale: u32) -> Result<()> {
    let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else { return Ok(()) };
    let pixel = |x: f64, y: f64| chart.backend_coord(&(x, y));
    let area = chart.plotting_area().strip_coord_spec();
    let origin = area.get_base_pixel();
    let unit = f64::from(scale);
    let near = |(x, y): (f64, f64)| ((x * unit) as i32, (y * unit) as i32);

    // Places in pixels of the picture, from the diagram's corner.
    let spot = |x: f64, y: f64| {
        let (x, y) = pixel(x, y);
        (f64::from(x - origin.0) / unit, f64::from(y - origin.1) / unit)
    };
    let spots: Vec<(f64, f64)> = nodes.iter().map(|node| spot(node.x, node.y)).collect();
    let length: f64 = spots.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
    let apart = ARROW_GAP_PX.max(length / MAX_ARROWS);
    let mut due = apart / 2.0;
    let mut gone = 0.0;
    let mut back = spots.first().copied().unwrap_or_default();
    for pair in spots.windows(2) {
        let piece = distance(pair[0], pair[1]);
        while gone + piece >= due && piece > 0.0 {
            let part = (due - gone) / piece;
            let tip = (pair[0].0 + (pair[1].0 - pair[0].0) * part, pair[0].1 + (pair[1].1 - pair[0].1) * part);
            let from = if part * piece >= DIRECTION_PX { pair[0] } else { back };
            if distance(from, tip) > 0.0 {
                area.draw(&Polygon::new(arrow(from, tip).map(near), INK.filled())).map_err(as_plot)?;
            }
            due += apart;
        }
        gone += piece;
        if distance(back, pair[1]) >= DIRECTION_PX {
            back = pair[0];
        }
    }

    let mut labels: Vec<Patch> = Vec::new();
    let size = area.dim_in_pixel();
    let (wide, tall) = (f64::from(size.0) / unit, f64::from(size.1) / unit);
    // Beside the point, where the path does not run and no other label is.
    let mut label = |at: (f64, f64), (from, to): (&Node<Power>, &Node<Power>), text: String| -> Result<()> {
        let (across, down) = font(12, INK, 1).font.box_size(&text).map_or((60, 14), |size| size);
        let (across, down) = (f64::from(across) + 4.0, f64::from(down) + 2.0);
        // First on the side on which a path from here to there does not run.
        let rises = (to.x - from.x) * (to.y - from.y) > 0.0;
        let ups = if rises { [4.0, -down - 5.0] } else { [-down - 5.0, 4.0] };
        let sides = [8.0, -across - 8.0];
        let patches = ups.into_iter().flat_map(|up| sides.map(|side| (side, up))).map(|(side, up)| {
            let (x, y) = (at.0 + side, at.1 + up);
            Patch { x: x.clamp(0.0, (wide - across).max(0.0)), y: y.clamp(0.0, (tall - down).max(0.0)), across, down }
        });
        // At an edge it may have been moved over its own point.
        let own = Patch { x: at.0 - 5.0, y: at.1 - 5.0, across: 10.0, down: 10.0 };
        let is_free = |patch: &Patch| !own.meets(patch) && !labels.iter().any(|other| other.meets(patch));
        let free: Vec<Patch> = patches.filter(is_free).collect();
        let clear = free.iter().find(|patch| !spots.windows(2).any(|line| patch.is_crossed(line[0], line[1])));
        let Some(patch) = clear.or(free.first()) else { return Ok(()) };
        labels.push(*patch);
        if clear.is_none() {
            // What is below shines through.
            let corners = [near((patch.x, patch.y)), near((patch.x + across, patch.y + down))];
            area.draw(&Rectangle::new(corners, WHITE.mix(0.75).filled())).map_err(as_plot)?;
        }
        area.draw(&Text::new(text, near((patch.x + 2.0, patch.y + 1.0)), font(12, INK, scale))).map_err(as_plot)
    };
    let (begin, end) = (first.from as f64 * 1e-6, last.until as f64 * 1e-6);
    let (factor, name) = if end - begin >= 10_000.0 { (1e-3, "s") } else { (1.0, "ms") };
    let step = round_step((end - begin) / 14.0);
    let text = |t: f64| format!("{} {name}", tick_text(t * factor, (end - begin) * factor * 1e-4));
    let ring = |at, size: i32| Circle::new(near(at), size * scale as i32, INK.stroke_width(2 * scale));
    let spot_first = spot(first.x, first.y);
    area.draw(&ring(spot_first, 7)).map_err(as_plot)?;
    label(spot_first, (first, nodes.get(1).unwrap_or(first)), text(begin))?;
    let spot_last = spot(last.x, last.y);
    area.draw(&Circle::new(near(spot_last), 6 * scale as i32, INK.filled())).map_err(as_plot)?;
    let before_last = nodes.len().checked_sub(2).and_then(|place| nodes.get(place)).unwrap_or(last);
    label(spot_last, (before_last, last), text(end))?;
    let mut index = 0;
    // Begin and end have their labels.
    let mut k = (begin / step).floor() + 1.0;
    while k * step < end && step > 0.0 {
        let t = k * step * 1e6;
        while nodes.get(index + 1).is_some_and(|next| next.from as f64 <= t) {
            index += 1;
        }
        let (node, next) = (nodes[index], nodes.get(index + 1).copied().unwrap_or(*last));
        let span = (next.from as f64 - node.until as f64).max(1.0);
        let part = ((t - node.until as f64) / span).clamp(0.0, 1.0);
        let at = spot(node.x + (next.x - node.x) * part, node.y + (next.y - node.y) * part);
        area.draw(&Circle::new(near(at), 3 * scale as i32, INK.filled())).map_err(as_plot)?;
        label(at, (&node, &next), text(k * step))?;
        k += 1.0;
    }
    Ok(())
}

/// Where a label is, in pixels.
#[derive(Debug, Clone, Copy)]
struct Patch {
    x: f64,
    y: f64,
    across: f64,
    down: f64,
}

impl Patch {
    fn meets(&self, other: &Patch) -> bool {
        let apart = |a: f64, long: f64, b: f64, other: f64| a + long < b || b + other < a;
        !apart(self.x, self.across, other.x, other.across) && !apart(self.y, self.down, other.y, other.down)
    }

    /// Whether a line runs through it.
    fn is_crossed(&self, from: (f64, f64), to: (f64, f64)) -> bool {
        let (mut enters, mut leaves) = (0.0f64, 1.0f64);
        for (start, end, low, long) in [(from.0, to.0, self.x, self.across), (from.1, to.1, self.y, self.down)] {
            let way = end - start;
            if way == 0.0 {
                if start < low || start > low + long {
                    return false;
                }
                continue;
            }
            let (a, b) = ((low - start) / way, (low + long - start) / way);
            (enters, leaves) = (enters.max(a.min(b)), leaves.min(a.max(b)));
        }
        enters <= leaves
    }
}

fn distance(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

/// A small arrow whose tip is at `tip`, as coming from `from`.
fn arrow(from: (f64, f64), tip: (f64, f64)) -> [(f64, f64); 3] {
    let long = distance(from, tip);
    let (x, y) = ((tip.0 - from.0) / long, (tip.1 - from.1) / long);
    let (back, half) = (11.0, 4.5);
    let foot = (tip.0 - x * back, tip.1 - y * back);
    [tip, (foot.0 - y * half, foot.1 + x * half), (foot.0 + y * half, foot.1 - x * half)]
}

/// 1, 2 or 5 times a power of ten, not below `least`.
fn round_step(least: f64) -> f64 {
    let ten = 10f64.powf(least.max(1e-6).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|n| n * ten).find(|step| *step >= least).unwrap_or(ten * 10.0)
}
