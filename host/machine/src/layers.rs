//! Layers: how strokes of a drawing are marked.
//!
//! In: `[[layers]]` of a machine file, or `KEY=VALUE,…` of the command line. Out: a [`Layer`].
//! Fails with key and limit.
use crate::file::{Fault, named, nearest_key, whole, within};
use crate::{Laser, Machine};
use serde::Deserialize;
use toml::Spanned;

/// Most passes.
const MAX_PASSES: i64 = 1000;

/// A stroke's colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// Red, green, blue.
    Rgb([u8; 3]),
    /// A number of AutoCAD, 1 to 255.
    Index(i16),
}

/// How the light goes with the speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightMode {
    /// The same energy for each mm: power in proportion to the speed.
    #[default]
    Follow,
    /// The same power at every speed.
    Constant,
}

/// How strokes are marked.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// What it is called.
    pub name: String,
    /// The strokes that it takes: of this colour; without one, of all.
    pub colour: Option<Colour>,
    /// The layer of the drawing whose strokes it takes; without one, of all.
    pub drawing_layer: Option<String>,
    /// The laser that marks: an index of those of the machine.
    pub laser: usize,
    /// Why it cannot be marked by the laser that was chosen: file, line, key, limit.
    pub unfit: Option<String>,
    /// Power at `speed`, in the laser's unit; 0 without light.
    pub power: f64,
    /// mm/min.
    pub speed: f64,
    /// How the light goes with the speed.
    pub light: LightMode,
    /// How often its strokes are marked.
    pub passes: u32,
    /// Layers of a lower number run first.
    pub order: i64,
    /// Its strokes are not marked.
    pub skip: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LayerKeys {
    name: Option<String>,
    colour: Option<Spanned<toml::Value>>,
    layer: Option<String>,
    laser: Option<Spanned<String>>,
    power: Option<Spanned<f64>>,
    speed: Option<Spanned<f64>>,
    #[serde(default)]
    light: LightMode,
    passes: Option<Spanned<i64>>,
    order: Option<i64>,
    #[serde(default)]
    skip: bool,
}

/// A layer after `before` others; `chosen` is the laser of those that name none.
pub(crate) fn checked(
    spanned: &Spanned<LayerKeys>,
    (lasers, chosen): (&[Laser], usize),
    before: usize,
) -> Result<Layer, Fault> {
    let keys = spanned.get_ref();
    let index = match &keys.laser {
        None => chosen,
        Some(name) => named(lasers, name.get_ref()).map_err(|why| (name.span(), why))?,
    };
    let laser = lasers.get(index);
    let missing = |key: &str| (spanned.span(), format!("has no {key}; a layer needs power and speed, or skip = true"));
    let power = match (&keys.power, laser) {
        (None, _) if keys.skip => 0.0,
        (None, _) => return Err(missing("power")),
        (Some(value), Some(laser)) => {
            let unit = format!("{} ({}.power)", laser.unit(), laser.table());
            within(value, 0.0..=laser.power.1, &unit)?
        }
        (Some(value), None) if *value.get_ref() == 0.0 => 0.0,
        (Some(value), None) => {
            return Err((value.span(), "is above 0, and the machine file has no [laser]; it is 0".to_owned()));
        }
    };
    let speed = match &keys.speed {
        None if keys.skip => 0.0,
        None => return Err(missing("speed")),
        Some(value) => within(value, 0.001..=1e7, "mm/min")?,
    };
    let passes = keys.passes.as_ref().map_or(Ok(1), |value| whole(value, 1..=MAX_PASSES, ""))?;
    let colour = keys.colour.as_ref().map(colour).transpose()?;
    Ok(Layer {
        name: keys.name.clone().unwrap_or_else(|| format!("layer {}", before + 1)),
        colour,
        drawing_layer: keys.layer.clone(),
        laser: index,
        unfit: None,
        power,
        speed,
        light: keys.light,
        passes: passes as u32,
        order: keys.order.unwrap_or(0),
        skip: keys.skip,
    })
}

/// `"#rrggbb"`, `"#rgb"`, or a number of AutoCAD.
fn colour(value: &Spanned<toml::Value>) -> Result<Colour, Fault> {
    let wrong = |shown: String| {
        let digits = shown.trim_matches('"');
        let meant = hexadecimal(digits).filter(|_| digits.len() == 6);
        let meant = meant.map_or(String::new(), |_| format!("; write \"#{digits}\""));
        (value.span(), format!("is {shown}; a colour is \"#rrggbb\", or a number of AutoCAD from 1 to 255{meant}"))
    };
    match value.get_ref() {
        toml::Value::Integer(index) => match i16::try_from(*index) {
            Ok(index @ 1..=255) => Ok(Colour::Index(index)),
            _ => Err(wrong(index.to_string())),
        },
        toml::Value::String(text) => {
            let shown: String = text.chars().take(40).collect();
            let rgb = text.strip_prefix('#').and_then(hexadecimal);
            rgb.map(Colour::Rgb).ok_or_else(|| wrong(format!("\"{shown}\"")))
        }
        _ => Err(wrong("neither".to_owned())),
    }
}

/// The colour of three or six digits.
fn hexadecimal(digits: &str) -> Option<[u8; 3]> {
    let digits = digits.chars().map(|digit| digit.to_digit(16)).collect::<Option<Vec<u32>>>()?;
    let rgb = match digits[..] {
        [r, g, b] => [r * 17, g * 17, b * 17],
        [r, s, g, h, b, c] => [r * 16 + s, g * 16 + h, b * 16 + c],
        _ => return None,
    };
    Some(rgb.map(|part| part as u8))
}

impl Layer {
    /// Which strokes it takes, in words.
    pub fn takes(&self) -> String {
        match (self.colour, &self.drawing_layer) {
            (None, None) => "all strokes that no layer before takes".to_owned(),
            (Some(Colour::Rgb([r, g, b])), None) => format!("strokes of #{r:02x}{g:02x}{b:02x}"),
            (Some(Colour::Index(index)), None) => format!("strokes of colour {index}"),
            (None, Some(layer)) => format!("strokes on `{layer}`"),
            (Some(Colour::Rgb([r, g, b])), Some(layer)) => format!("strokes of #{r:02x}{g:02x}{b:02x} on `{layer}`"),
            (Some(Colour::Index(index)), Some(layer)) => format!("strokes of colour {index} on `{layer}`"),
        }
    }
}

/// A line for the user.
pub(crate) fn show(layer: &Layer, machine: &Machine) -> String {
    let laser = machine.lasers.get(layer.laser);
    let what = layer.takes();
    if layer.skip {
        return format!("layer \"{}\": {what} are not marked\n", layer.name);
    }
    let light = match layer.light {
        LightMode::Follow => "power follows the speed",
        LightMode::Constant => "power is constant",
    };
    format!(
        "layer \"{}\": {what}{}, {} {} at {} mm/min, {light}; {} pass{}, order {}\n",
        layer.name,
        laser.and_then(|laser| laser.name.as_ref()).map_or_else(String::new, |name| format!(", laser \"{name}\"")),
        layer.power,
        laser.map_or("", Laser::unit),
        layer.speed,
        layer.passes,
        if layer.passes == 1 { "" } else { "es" },
        layer.order
    )
}

/// A value of the command line, as its key has it in a file.
fn typed(key: &str, value: &str) -> Result<toml::Value, String> {
    let wanted = match key {
        "power" => "a number, in the unit of laser.power and without it",
        "speed" => "a number, in mm/min and without the unit",
        "passes" | "order" => "a whole number",
        "skip" => "true or false",
        "light" => "follow or constant",
        "laser" => "the name of a laser of the machine file",
        _ => "#rrggbb, or a number of AutoCAD from 1 to 255",
    };
    let text = toml::Value::String(value.to_owned());
    let found = match key {
        "power" | "speed" => value.parse().ok().map(toml::Value::Float),
        "passes" | "order" => value.parse().ok().map(toml::Value::Integer),
        "skip" => value.parse().ok().map(toml::Value::Boolean),
        "light" => Some(text).filter(|_| ["follow", "constant"].contains(&value)),
        "colour" if value.contains('=') => None,
        // A number of AutoCAD has three digits at most, and #000011 has no 0 before it.
        "colour" if value.len() <= 3 => Some(value.parse().map_or(text, toml::Value::Integer)),
        _ => Some(text),
    };
    found.ok_or_else(|| match value.split_once('=').and_then(|(before, _)| before.split_whitespace().last()) {
        Some(next) => format!("a comma is missing before `{next}`"),
        None => format!("it is {wanted}"),
    })
}

/// A layer of the command line: the keys of the file, as `colour=#ff0000,power=80,speed=600`.
pub(crate) fn given(text: &str, machine: &Machine) -> Result<Layer, String> {
    let mut toml = String::new();
    for pair in text.split(',') {
        let (key, value) = pair.split_once('=').ok_or_else(|| {
            format!("--layer {text}: `{pair}` is not KEY=VALUE; it is as colour=#ff0000,power=80,speed=600")
        })?;
        let (key, value) = (key.trim(), value.trim());
        if !key.bytes().all(|byte| byte.is_ascii_lowercase()) {
            return Err(format!("--layer {text}: `{key}` is no key of a layer"));
        }
        let value = typed(key, value).map_err(|why| format!("--layer {text}: {key} is `{value}`; {why}"))?;
        toml += &format!("{key} = {value}\n");
    }
    let shown = |why: String| format!("--layer {text}: {why}");
    let keys: LayerKeys = toml::from_str(&toml).map_err(|error| {
        let message = error.message().replace('\n', " ");
        let help = nearest_key(&message).map_or(String::new(), |help| format!("; {help}"));
        shown(format!("{message}{help}"))
    })?;
    let spanned = Spanned::new(0..0, keys);
    checked(&spanned, (&machine.lasers, machine.chosen), 0).map_err(|(span, why)| {
        let line = toml.get(..span.start).unwrap_or("").rsplit('\n').next().unwrap_or("");
        let key = line.split('=').next().unwrap_or("").trim();
        shown(format!("{} {why}", if key.is_empty() { "it" } else { key }))
    })
}
