//! What a dithered train of pulses is made of: its lines, computed from the counted edges.
use servo::laser::{Count, Pattern, Train};
use std::f64::consts::PI;
use std::fmt::Write;

/// One pulse: its beginning and its end, counts.
pub type Pulse = (u64, u64);

/// So many periods as a timer counts them; the length of all.
pub fn counted(train: Train, periods: u64) -> (Vec<Pulse>, u64) {
    let mut pattern = Pattern::BEGIN;
    let mut at = 0;
    let pulses = (0..periods).map(|_| {
        let (period, width) = pattern.step(&train);
        let pulse = (at, at + width);
        at += period;
        pulse
    });
    (pulses.collect(), at)
}

fn denominator(count: Count) -> u64 {
    if count.of == 0 { 1 << 32 } else { count.of.into() }
}

/// Periods after which a train repeats.
pub fn repetition(train: Train) -> u64 {
    let shortest = |count: Count| {
        let (mut a, mut b) = (denominator(count), u64::from(count.part));
        while b != 0 {
            (a, b) = (b, a % b);
        }
        denominator(count) / a
    };
    let (p, w) = (shortest(train.period), shortest(train.width));
    let (mut a, mut b) = (p, w);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    p / a * w
}

/// A line: its frequency as a multiple of the train's own, and its level against that of the
/// train's own.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    pub multiple: f64,
    pub db: f64,
    /// A whole multiple: it is there without dither too.
    pub harmonic: bool,
}

/// All lines above 0 up to so many times the train's frequency, from one whole repetition.
pub fn lines(train: Train, up_to: u64) -> Vec<Line> {
    let periods = repetition(train);
    let (pulses, length) = counted(train, periods);
    let level = |line: u64| {
        // The Fourier coefficient of rectangles over the repetition, exact phases by whole numbers.
        let turn =
            |at: u64| 2.0 * PI * ((u128::from(line) * u128::from(at)) % u128::from(length)) as f64 / length as f64;
        let sum = pulses.iter().fold((0.0, 0.0), |(re, im), &(begin, end)| {
            let ((s0, c0), (s1, c1)) = (turn(begin).sin_cos(), turn(end).sin_cos());
            (re + c1 - c0, im + s1 - s0)
        });
        sum.0.hypot(sum.1) / line as f64
    };
    let own = level(periods);
    (1..=periods * up_to)
        .map(|line| Line {
            multiple: line as f64 / periods as f64,
            db: 20.0 * (level(line) / own).log10(),
            harmonic: line % periods == 0,
        })
        .collect()
}

/// The highest line that only dither makes; none where nothing is dithered.
pub fn worst(lines: &[Line]) -> Option<Line> {
    lines.iter().filter(|line| !line.harmonic).copied().max_by(|a, b| a.db.total_cmp(&b.db))
}

/// Lines as an SVG figure from 0 to −80 dB.
pub fn figure(title: &str, lines: &[Line], up_to: u64) -> String {
    const WIDTH_PX: f64 = 720.0;
    const HEIGHT_PX: f64 = 320.0;
    let x = |multiple: f64| 60.0 + multiple / up_to as f64 * (WIDTH_PX - 80.0);
    let y = |db: f64| 40.0 + db.clamp(-80.0, 0.0) / -80.0 * (HEIGHT_PX - 90.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH_PX} {HEIGHT_PX}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"60\" y=\"22\">{title}</text>\n"
    );
    for db in (0..=80).step_by(20) {
        let y = y(-f64::from(db));
        let _ = writeln!(svg, "<path d=\"M60 {y:.1}H{:.1}\" stroke=\"#ccc\"/>", WIDTH_PX - 20.0);
        let _ = writeln!(svg, "<text x=\"52\" y=\"{:.1}\" text-anchor=\"end\">{} dB</text>", y + 4.0, -db);
    }
    for multiple in 0..=up_to {
        let x = x(multiple as f64);
        let _ =
            writeln!(svg, "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{multiple} f</text>", HEIGHT_PX - 30.0);
    }
    let _ = writeln!(svg, "<text x=\"{}\" y=\"{}\">frequency</text>", WIDTH_PX - 90.0, HEIGHT_PX - 10.0);
    for line in lines.iter().filter(|line| line.db > -80.0) {
        let colour = if line.harmonic { "#1f4e79" } else { "#c0392b" };
        let (x, top) = (x(line.multiple), y(line.db));
        let _ = writeln!(svg, "<path d=\"M{x:.1} {:.1}V{top:.1}\" stroke=\"{colour}\" stroke-width=\"2\"/>", y(-80.0));
    }
    svg + "</svg>\n"
}
