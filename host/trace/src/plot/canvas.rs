//! Pictures as files.
//!
//! In: what draws itself. Out: a PNG or an SVG, as the name says. Fails with [`TraceError::Plot`].
use super::PlotOptions;
use super::text::{FAINT, INK, as_plot, font, load_font, place};
use crate::{Result, TraceError};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// A PNG is drawn this many times as large and made smaller.
const OVERSAMPLING_RATIO: u32 = 2;
/// Height of the heading.
pub(super) const HEADING_PX: u32 = 62;

/// Greatest height of a diagram of one axis over another.
const MAX_HEIGHT_PX: u32 = 860;
/// Least height of it, and least width.
const MIN_HEIGHT_PX: u32 = 240;
const MIN_WIDTH_PX: u32 = 520;
/// Share of the extent that is free around what is drawn.
const MARGIN_SHARE: f64 = 0.05;

/// Least and greatest of x, and of y.
pub(super) type Extent = ((f64, f64), (f64, f64));

/// Width and height of a diagram in pixels, and the ranges that it shows: as many units a pixel in
/// x as in y.
pub(super) fn same_scale(extent: Extent, most_wide: f64) -> ((u32, u32), [(f64, f64); 2]) {
    let (dx, dy) = (extent.0.1 - extent.0.0, extent.1.1 - extent.1.0);
    let most = dx.max(dy);
    let least = if most > 0.0 { most * 0.02 } else { 1.0 };
    let wide = |(low, high): (f64, f64)| (high - low).max(least) * (1.0 + 2.0 * MARGIN_SHARE);
    let (dx, dy) = (wide(extent.0), wide(extent.1));
    let width = (f64::from(MAX_HEIGHT_PX) * dx / dy).clamp(f64::from(MIN_WIDTH_PX).min(most_wide), most_wide).round();
    let height = (width * dy / dx).clamp(MIN_HEIGHT_PX.into(), MAX_HEIGHT_PX.into()).round();
    let per_pixel = (dx / width).max(dy / height);
    let range = |(low, high): (f64, f64), pixels: f64| {
        let (middle, half) = (f64::midpoint(low, high), pixels * per_pixel / 2.0);
        (middle - half, middle + half)
    };
    ((width as u32, height as u32), [range(extent.0, width), range(extent.1, height)])
}

/// A diagram of two quantities.
pub(super) type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// What draws itself.
pub(super) trait Picture {
    /// Size in pixels.
    fn size(&self) -> (u32, u32);

    /// Draws everything, `scale` times as large.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, scale: u32) -> Result<()>;
}

/// Whether a picture of this name can be drawn.
pub(super) fn check_name(path: &Path) -> Result<()> {
    match extension(path).as_str() {
        "png" | "svg" => Ok(()),
        _ => Err(TraceError::Plot(format!("{}: a plot's name ends in .png or .svg", path.display()))),
    }
}

fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// Draws a PNG or an SVG, as the path's extension says.
pub(super) fn save(picture: &impl Picture, path: &Path) -> Result<()> {
    check_name(path)?;
    load_font();
    match extension(path).as_str() {
        "svg" => {
            let area = SVGBackend::new(path, picture.size()).into_drawing_area();
            area.fill(&WHITE).map_err(as_plot)?;
            picture.draw(&area, 1)?;
            area.present().map_err(as_plot)
        }
        _ => save_png(picture, path),
    }
}

/// An SVG as a text.
pub(super) fn svg(picture: &impl Picture) -> Result<String> {
    load_font();
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, picture.size()).into_drawing_area();
        area.fill(&WHITE).map_err(as_plot)?;
        picture.draw(&area, 1)?;
        area.present().map_err(as_plot)?;
    }
    Ok(text)
}

/// What a legend shows of a thing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sign {
    /// A line.
    Line,
    /// A ring: where a path begins.
    Ring,
    /// A dot: where it ends.
    Dot,
}

/// A legend in one line, which ends at `right` and does not begin before `left`; what has no room
/// is left out.
pub(super) fn legend<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    (left, right): (u32, u32),
    entries: &[(Sign, RGBColor, &str)],
    scale: u32,
) -> Result<()> {
    let mut at = right;
    for (sign, colour, text) in entries {
        let wide = font(14, INK, 1).font.box_size(text).map_or(120, |size| size.0);
        if at < left + wide + 52 {
            return Ok(());
        }
        at -= wide + 52;
        let stroke = colour.stroke_width(2 * scale);
        match sign {
            Sign::Line => {
                let line = vec![place(at, 14, scale), place(at + 26, 14, scale)];
                area.draw(&PathElement::new(line, colour.stroke_width(3 * scale))).map_err(as_plot)?;
            }
            Sign::Ring => area.draw(&Circle::new(place(at + 16, 14, scale), 6 * scale, stroke)).map_err(as_plot)?,
            Sign::Dot => {
                area.draw(&Circle::new(place(at + 16, 14, scale), 5 * scale, colour.filled())).map_err(as_plot)?;
            }
        }
        area.draw(&Text::new(*text, place(at + 32, 7, scale), font(14, INK, scale))).map_err(as_plot)?;
    }
    Ok(())
}

/// Draws [`OVERSAMPLING_RATIO`] times as large and takes means, so that slanted lines are smooth.
fn save_png(picture: &impl Picture, path: &Path) -> Result<()> {
    let (width, height) = picture.size();
    let large = (width * OVERSAMPLING_RATIO, height * OVERSAMPLING_RATIO);
    let mut pixels = vec![0; large.0 as usize * large.1 as usize * 3];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, large).into_drawing_area();
        area.fill(&WHITE).map_err(as_plot)?;
        picture.draw(&area, OVERSAMPLING_RATIO)?;
        area.present().map_err(as_plot)?;
    }
    let small = shrink(&pixels, large.0 as usize, OVERSAMPLING_RATIO as usize);
    let mut encoder = png::Encoder::new(BufWriter::new(File::create(path)?), width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(&small)?;
        writer.finish()
    });
    written.map_err(|e| TraceError::Plot(format!("{}: {e}", path.display())))
}

/// Title and subtitle; what is below them is returned.
pub(super) fn head<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    options: &PlotOptions,
    scale: u32,
) -> Result<DrawingArea<B, Shift>> {
    let (head, rest) = area.split_vertically(HEADING_PX * scale);
    for (text, y, size, colour) in [(&options.title, 12, 22, INK), (&options.subtitle, 40, 14, FAINT)] {
        head.draw(&Text::new(text.clone(), place(24, y, scale), font(size, colour, scale))).map_err(as_plot)?;
    }
    Ok(rest)
}

/// Draws a line through points. The line is broken where it turns by more than a right angle: the
/// bitmap's joins extend far beyond a sharp corner between short pieces. It is also broken where it
/// has turned by a right angle since the last break: the bitmap omits what a line covers twice, and
/// a line that keeps its direction covers nothing twice.
pub(super) fn line<B: DrawingBackend>(
    chart: &mut Chart<'_, B>,
    points: impl IntoIterator<Item = (f64, f64)>,
    stroke: ShapeStyle,
) -> Result<()> {
    let mut piece: Vec<(f64, f64)> = Vec::new();
    // The last point in pixels, the direction to it, and the first direction of the piece.
    let mut last: Option<((i32, i32), (i64, i64))> = None;
    let mut first = (0, 0);
    for point in points {
        let here = chart.backend_coord(&point);
        let Some((before, way)) = last else {
            last = Some((here, (0, 0)));
            piece.push(point);
            continue;
        };
        let on = (i64::from(here.0 - before.0), i64::from(here.1 - before.1));
        if on == (0, 0) {
            continue;
        }
        let back = |way: (i64, i64)| way.0 * on.0 + way.1 * on.1 < 0;
        if first == (0, 0) {
            first = on;
        }
        if (back(way) || back(first))
            && let Some(&corner) = piece.last()
        {
            chart.draw_series(LineSeries::new(std::mem::take(&mut piece), stroke)).map_err(as_plot)?;
            piece.push(corner);
            first = on;
        }
        piece.push(point);
        last = Some((here, on));
    }
    chart.draw_series(LineSeries::new(piece, stroke)).map_err(as_plot)?;
    Ok(())
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
