//! Letters and their positions in the picture.
use crate::TraceError;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::sync::Once;

pub(super) const INK: RGBColor = RGBColor(0x24, 0x29, 0x2f);
pub(super) const FAINT: RGBColor = RGBColor(0x6e, 0x77, 0x81);

/// A position in pixels of the picture.
pub(super) fn place(x: u32, y: u32, scale: u32) -> (i32, i32) {
    ((x * scale) as i32, (y * scale) as i32)
}

/// The built-in font in this size and colour.
pub(super) fn font(size: u32, colour: RGBColor, scale: u32) -> TextStyle<'static> {
    ("sans-serif", size * scale).into_font().color(&colour)
}

/// A step that is surely not coarser than the distance of two labels.
pub(super) fn tick_step(range: f64) -> f64 {
    10f64.powf((range / 20.0).max(1e-12).log10().floor())
}

/// A label with as many decimals as the step needs.
pub(super) fn tick_text(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

pub(super) fn as_plot<E: std::error::Error + Send + Sync>(e: DrawingAreaErrorKind<E>) -> TraceError {
    TraceError::Plot(e.to_string())
}

/// Makes the built-in font known to the drawing library, once.
pub(super) fn load_font() {
    static LOADED: Once = Once::new();
    static FONT: &[u8] = include_bytes!("../../assets/DejaVuSans-subset.ttf");
    LOADED.call_once(|| {
        // It fails only for bytes that are no font; a test draws with it.
        let _ = register_font("sans-serif", FontStyle::Normal, FONT);
    });
}
