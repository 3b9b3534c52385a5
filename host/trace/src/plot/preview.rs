//! A path before it runs: travel, marks, and what leaves the machine's travel.
//!
//! In: points in mm, and what is lit on the way to each. Out: a PNG or an SVG with the same scale
//! in both directions and a legend. Owns a [`Route`]. Fails with [`TraceError::Plot`].
use super::canvas::{self, Chart, HEADING_PX, Picture, Sign};
use super::panel::{CAPTION_PX, FRAME, GRID, LEFT_PX, RIGHT_PX, TIME_LABELS_PX};
use super::route::Route;
use super::text::{FAINT, INK, as_plot, font, place, tick_step, tick_text};
use super::xy::spaced;
use super::{POSITION, PlotOptions};
use crate::{Result, TraceError};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// The way between marks, in the dark.
const DARK: RGBColor = RGBColor(0x9a, 0xa4, 0xae);
/// Marks of each laser.
const MARKS: [RGBColor; 2] = [RGBColor(0xc4, 0x2f, 0x6b), RGBColor(0x2f, 0x6b, 0xc4)];
/// What leaves the travel.
const OUTSIDE: RGBColor = RGBColor(0xf2, 0x8c, 0x00);
/// The edge of the travel, and what lies beyond it.
const EDGE: RGBColor = RGBColor(0x2d, 0x7d, 0x46);
const BEYOND: RGBColor = RGBColor(0xfb, 0xf1, 0xe2);
/// Pixels from one drawn point to the next.
const POINT_GAP_PX: i32 = 2;

/// What a part of a path is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Dark,
    /// Of this laser.
    Mark(usize),
    Outside,
}

/// See the module text.
#[derive(Debug, Clone)]
pub struct Preview {
    options: PlotOptions,
    /// Least and greatest position of both axes, mm.
    travel: [(f64, f64); 2],
    letters: [char; 2],
    /// What marks of each laser are called.
    marks: [String; 2],
    route: Route<Part>,
    at: Option<(f64, f64)>,
    steps: u64,
}

impl Preview {
    /// An empty picture; `travel` of the axes `letters`, mm; `marks` is what those of each laser
    /// are called.
    pub fn new(options: PlotOptions, letters: [char; 2], travel: [(f64, f64); 2], marks: [String; 2]) -> Self {
        Preview { options, travel, letters, marks, route: Route::default(), at: None, steps: 0 }
    }

    /// The second line of the heading.
    pub fn subtitle(&mut self, text: String) {
        self.options.subtitle = text;
    }

    /// The path goes on to here; `lit` is the laser that marks on the way, 0 or 1.
    pub fn line(&mut self, to: (f64, f64), lit: Option<usize>) {
        let Some(from) = self.at.replace(to) else { return };
        let inside = lit.map_or(Part::Dark, |laser| Part::Mark(laser.min(1)));
        let on = |part: f64| (from.0 + (to.0 - from.0) * part, from.1 + (to.1 - from.1) * part);
        let (enters, leaves) = self.within(from, to);
        // Up to where it enters the travel, up to where it leaves it, and the rest.
        for (begin, end, what) in [(0.0, enters, Part::Outside), (enters, leaves, inside), (leaves, 1.0, Part::Outside)]
        {
            if begin < end {
                self.push(on(begin), what);
                self.push(on(end), what);
            }
        }
    }

    fn push(&mut self, at: (f64, f64), what: Part) {
        self.steps += 1;
        self.route.push(self.steps, at, Some(what));
    }

    /// The part of a line that is within the travel, from 0 to 1.
    fn within(&self, from: (f64, f64), to: (f64, f64)) -> (f64, f64) {
        // Rounding of a file moves nothing outside.
        const NEAR_MM: f64 = 0.001;
        let (mut enters, mut leaves) = (0.0f64, 1.0f64);
        for ((start, end), (least, most)) in [(from.0, to.0), (from.1, to.1)].into_iter().zip(self.travel) {
            let (least, most, way) = (least - NEAR_MM, most + NEAR_MM, end - start);
            if way == 0.0 {
                if start < least || start > most {
                    return (1.0, 1.0);
                }
                continue;
            }
            let (a, b) = ((least - start) / way, (most - start) / way);
            (enters, leaves) = (enters.max(a.min(b)), leaves.min(a.max(b)));
        }
        if enters < leaves { (enters, leaves) } else { (1.0, 1.0) }
    }

    /// Draws a PNG or an SVG, as the path's extension says.
    ///
    /// # Errors
    /// Another extension; nothing to draw; the file.
    pub fn save(&self, path: &Path) -> Result<()> {
        canvas::check_name(path)?;
        if self.route.nodes().is_empty() {
            return Err(TraceError::Plot("there is no path to draw".to_owned()));
        }
        canvas::save(self, path)
    }

    fn layout(&self) -> ((u32, u32), [(f64, f64); 2]) {
        let extent = self.route.extent().unwrap_or_default();
        canvas::same_scale(extent, f64::from(self.options.width.max(480) - LEFT_PX - RIGHT_PX))
    }

    fn has(&self, what: Part) -> bool {
        self.route.nodes().iter().any(|node| node.light == Some(what))
    }

    /// Lines of one kind.
    fn draw_part<B: DrawingBackend>(&self, chart: &mut Chart<'_, B>, what: Part, stroke: ShapeStyle) -> Result<()> {
        let near = POINT_GAP_PX.min(stroke.stroke_width as i32);
        let mut remaining = self.route.nodes();
        while let Some(begin) = remaining.iter().position(|node| node.light == Some(what)) {
            let run = &remaining[begin..];
            let same = run.iter().take_while(|node| node.light == Some(what)).count();
            // The node where something else begins is the end of this.
            canvas::line(chart, spaced(chart, &run[..(same + 1).min(run.len())], near), stroke)?;
            remaining = &run[same..];
        }
        Ok(())
    }
}

impl Picture for Preview {
    fn size(&self) -> (u32, u32) {
        let (width, height) = self.layout().0;
        (LEFT_PX + width + RIGHT_PX, HEADING_PX + CAPTION_PX + height + TIME_LABELS_PX)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Result<()> {
        let rest = canvas::head(area, &self.options, scale)?;
        let ((width, _), [x, y]) = self.layout();
        let [across, up] = self.letters;
        rest.draw(&Text::new(format!("{up} (mm)"), place(LEFT_PX, 7, scale), font(14, POSITION, scale)))
            .map_err(as_plot)?;
        let leaves =
            self.travel[0].0 > x.0 || self.travel[0].1 < x.1 || self.travel[1].0 > y.0 || self.travel[1].1 < y.1;
        // Where two lasers mark, they are what the legend says first: it may be full.
        let [first, second] = [0, 1].map(|laser| self.has(Part::Mark(laser)));
        let legend = [
            (Sign::Line, MARKS[1], self.marks[1].as_str(), second),
            (Sign::Line, MARKS[0], self.marks[0].as_str(), first && second),
            (Sign::Line, OUTSIDE, "outside the travel", self.has(Part::Outside)),
            (Sign::Line, EDGE, "edge of the travel", leaves),
            (Sign::Ring, INK, "begin: home", true),
            (Sign::Line, DARK, "in the dark", self.has(Part::Dark)),
            (Sign::Line, MARKS[0], self.marks[0].as_str(), first && !second),
        ];
        let shown: Vec<_> = legend
            .into_iter()
            .filter(|(.., shown)| *shown)
            .map(|(sign, colour, text, _)| (sign, colour, text))
            .collect();
        canvas::legend(&rest, (LEFT_PX + 60, LEFT_PX + width), &shown, scale)?;
        let mut chart = ChartBuilder::on(&rest)
            .margin_top(CAPTION_PX * scale)
            .margin_right(RIGHT_PX * scale)
            .set_label_area_size(LabelAreaPosition::Left, LEFT_PX * scale)
            .set_label_area_size(LabelAreaPosition::Bottom, TIME_LABELS_PX * scale)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)
            .map_err(as_plot)?;
        self.draw_beyond(&mut chart, [x, y])?;
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
            .x_desc(format!("{across} (mm)"))
            .draw()
            .map_err(as_plot)?;
        self.draw_edge(&mut chart, [x, y], scale)?;
        self.draw_part(&mut chart, Part::Dark, DARK.stroke_width(scale))?;
        for (laser, colour) in MARKS.into_iter().enumerate() {
            self.draw_part(&mut chart, Part::Mark(laser), colour.stroke_width(2 * scale))?;
        }
        self.draw_part(&mut chart, Part::Outside, OUTSIDE.stroke_width(3 * scale))?;
        if let Some(node) = self.route.nodes().first() {
            let ring = Circle::new((node.x, node.y), 6 * scale, INK.stroke_width(2 * scale));
            chart.draw_series([ring]).map_err(as_plot)?;
        }
        Ok(())
    }
}

impl Preview {
    /// What lies beyond the travel.
    fn draw_beyond<B: DrawingBackend>(&self, chart: &mut Chart<'_, B>, [x, y]: [(f64, f64); 2]) -> Result<()> {
        let [(left, right), (low, high)] = self.travel;
        let outer = [
            ((x.0, y.0), (left.min(x.1), y.1)),
            ((right.max(x.0), y.0), (x.1, y.1)),
            ((x.0, y.0), (x.1, low.min(y.1))),
            ((x.0, high.max(y.0)), (x.1, y.1)),
        ];
        let outer = outer.into_iter().filter(|(a, b)| a.0 < b.0 && a.1 < b.1);
        chart.draw_series(outer.map(|(a, b)| Rectangle::new([a, b], BEYOND.filled()))).map_err(as_plot)?;
        Ok(())
    }

    fn draw_edge<B: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, B>,
        [x, y]: [(f64, f64); 2],
        scale: u32,
    ) -> Result<()> {
        let [(left, right), (low, high)] = self.travel;
        let stroke = EDGE.stroke_width(2 * scale);
        let (from, to) = ((left.max(x.0), low.max(y.0)), (right.min(x.1), high.min(y.1)));
        for at in [left, right].into_iter().filter(|at| (x.0..=x.1).contains(at) && from.1 < to.1) {
            canvas::line(chart, [(at, from.1), (at, to.1)], stroke)?;
        }
        for at in [low, high].into_iter().filter(|at| (y.0..=y.1).contains(at) && from.0 < to.0) {
            canvas::line(chart, [(from.0, at), (to.0, at)], stroke)?;
        }
        Ok(())
    }
}
