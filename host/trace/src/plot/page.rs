//! A page of HTML with the panels of a plot, in which time can be enlarged.
//!
//! In: a plot, and the path of two axes. Out: one file with the data, the script that draws it
//! (`assets/page.js`) and the path as an SVG. It names no other file and no other site. Fails with
//! [`TraceError::Io`](crate::TraceError::Io).
use super::activity::Activity;
use super::curve::Curve;
use super::panel::Content;
use super::{Plot, Xy};
use crate::Result;
use plotters::style::RGBColor;
use std::fmt::Write;
use std::path::Path;

const SCRIPT: &str = include_str!("../../assets/page.js");
const STYLE: &str = include_str!("../../assets/page.css");
/// Intervals in which a signal with too many pulses is shown as its share of time.
const MAX_INTERVALS: usize = 4096;

pub(super) fn save(plot: &Plot, xy: Option<&Xy>, path: &Path) -> Result<()> {
    let svg = xy.map(Xy::svg).transpose()?.flatten();
    std::fs::write(path, text(plot, svg.as_deref()))?;
    Ok(())
}

fn text(plot: &Plot, svg: Option<&str>) -> String {
    let options = &plot.options;
    let (title, subtitle) = (escaped(&options.title), escaped(&options.subtitle));
    let path = svg.map_or(String::new(), |svg| format!("<h2>Path</h2>\n<div id=\"path\">{svg}</div>\n"));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p>{subtitle}</p>\n\
         <p id=\"keys\">Wheel: enlarge. Drag: move. Double click: everything. Keys: + &minus; 0 and the arrows. \
         Shift and wheel: enlarge the path.</p>\n\
         <div id=\"panels\"></div>\n{path}<script type=\"application/json\" id=\"data\">{}</script>\n\
         <script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        data(plot)
    )
}

/// What a text is in HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The panels as JSON. Captions are ours: they hold nothing that JSON or HTML would take for its
/// own.
fn data(plot: &Plot) -> String {
    let span = plot.time_range();
    let mut text = format!("{{\"from\":{},\"to\":{},\"panels\":[", span.0, span.1);
    for (index, panel) in plot.panels().iter().enumerate() {
        let RGBColor(r, g, b) = panel.colour;
        if index > 0 {
            text.push(',');
        }
        let zero = panel.from_zero;
        // Writing to a text does not fail.
        let _ = write!(
            text,
            "\n{{\"caption\":\"{}\",\"colour\":\"#{r:02x}{g:02x}{b:02x}\",\"zero\":{zero},",
            panel.caption
        );
        match panel.content {
            Content::Quantity(curves) => {
                text.push_str("\"lines\":[");
                for (index, curve) in curves.iter().enumerate() {
                    text.push_str(if index > 0 { ",[" } else { "[" });
                    numbers(&mut text, points(curve));
                    text.push(']');
                }
                text.push_str("]}");
            }
            Content::Digital(activity) => digital(&mut text, activity, span),
        }
    }
    text.push_str("\n]}");
    text
}

/// Times and values in turn, without what a line would not show.
fn points(curve: &Curve) -> impl Iterator<Item = f64> + '_ {
    let mut last = None;
    curve.points().filter(move |point| last.replace(*point) != Some(*point)).flat_map(|(t, value)| [t, value])
}

fn digital(text: &mut String, activity: &Activity, (from, to): (f64, f64)) {
    if let Some(highs) = activity.highs() {
        text.push_str("\"highs\":[");
        numbers(text, highs.iter().flat_map(|(from, to)| [*from as f64 * 1e-6, *to as f64 * 1e-6]));
    } else {
        let wide = (to - from) / MAX_INTERVALS as f64;
        let share = |index: usize| {
            let begin = (from + wide * index as f64) * 1e6;
            activity.between(begin, begin + wide * 1e6).on / (wide * 1e6) * 100.0
        };
        text.push_str("\"shares\":[");
        numbers(text, (0..MAX_INTERVALS).map(share));
    }
    text.push_str("]}");
}

/// Numbers of at most nine decimals, which are those of a ns in ms with three to spare.
fn numbers(text: &mut String, numbers: impl Iterator<Item = f64>) {
    for (index, number) in numbers.enumerate() {
        if index > 0 {
            text.push(',');
        }
        let _ = write!(text, "{}", (number * 1e9).round() / 1e9 + 0.0);
    }
}
