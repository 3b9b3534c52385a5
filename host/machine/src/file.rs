//! The reader of a machine file.
//!
//! In: name and text. Out: a [`Machine`], or one text: file, line, key, what is wrong, the limit.
use crate::layers::{self, LayerKeys};
use crate::template::written;
use crate::{Axis, Family, LETTERS, Laser, Limits, Machine, Mode, Outputs, Path, STEP_DECIMALS};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};
use toml::Spanned;

/// Fastest and strongest that a path of the controller may be, pulse/ms and pulse/ms² (SPEC 4).
const RATE_MAX_PULSES: f64 = 32_767.0;
/// Axes of the controller that a path may move (SPEC 5).
const PATH_AXES: RangeInclusive<i64> = 1..=8;
/// Lasers of a machine: one for each channel of the controller (SPEC 6).
const LASERS: usize = 2;
/// Longest name of a laser.
const NAME_CHARACTERS: usize = 32;
/// Farthest machine position, mm.
const POSITION_MAX_MM: f64 = 100_000.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    family: Family,
    #[serde(default)]
    link: LinkKeys,
    #[serde(default)]
    axes: Axes,
    laser: Option<Spanned<LaserKeys>>,
    lasers: Option<Spanned<BTreeMap<String, Spanned<LaserKeys>>>>,
    #[serde(default)]
    path: PathKeys,
    #[serde(default)]
    outputs: OutputKeys,
    #[serde(default)]
    layers: Vec<Spanned<LayerKeys>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Axes {
    x: Option<Spanned<AxisKeys>>,
    y: Option<Spanned<AxisKeys>>,
    z: Option<Spanned<AxisKeys>>,
    a: Option<Spanned<toml::Table>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct LinkKeys {
    board: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxisKeys {
    number: Spanned<i64>,
    steps_per_mm: Spanned<f64>,
    invert: Option<bool>,
    travel: Spanned<Vec<f64>>,
    max_rate: Spanned<f64>,
    acceleration: Spanned<f64>,
    home: Option<Spanned<f64>>,
    #[serde(default)]
    limits: Limits,
    #[serde(default)]
    alarm: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LaserKeys {
    channel: Spanned<i64>,
    mode: Mode,
    carrier_khz: Option<Spanned<f64>>,
    pulse_width_us: Option<Spanned<f64>>,
    s_max: Spanned<f64>,
    power: Spanned<Vec<f64>>,
    on_delay_us: Option<Spanned<f64>>,
    off_delay_us: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct PathKeys {
    junction_deviation: Option<Spanned<f64>>,
    arc_tolerance: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct OutputKeys {
    mist: Option<Spanned<i64>>,
    flood: Option<Spanned<i64>>,
}

/// Bytes of the text, and what is wrong there.
pub(crate) type Fault = (Range<usize>, String);

/// A value within its limits.
pub(crate) fn within(value: &Spanned<f64>, limits: RangeInclusive<f64>, unit: &str) -> Result<f64, Fault> {
    let got = *value.get_ref();
    if limits.contains(&got) {
        return Ok(got);
    }
    Err((value.span(), format!("is {got}; it is {} to {} {unit}", limits.start(), limits.end())))
}

/// A whole number within its limits.
pub(crate) fn whole(value: &Spanned<i64>, limits: RangeInclusive<i64>, unit: &str) -> Result<i64, Fault> {
    let got = *value.get_ref();
    if limits.contains(&got) {
        return Ok(got);
    }
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    Err((value.span(), format!("is {got}; it is a whole number from {} to {}{unit}", limits.start(), limits.end())))
}

pub fn read(name: &str, text: &str, laser: Option<&str>) -> Result<Machine, String> {
    read_as(text, laser, |line, what| match line {
        0 => format!("{name}: {what}"),
        line => format!("{name}:{line}: {what}"),
    })
}

/// Reads a text for the laser that is chosen. `shown` makes an error of its line (0 for an error of
/// the choice) and of what is wrong; that begins with the key.
pub fn read_as(text: &str, chosen: Option<&str>, shown: impl Fn(usize, &str) -> String) -> Result<Machine, String> {
    let bare = text.trim_start_matches('\u{feff}');
    let fault = |(span, message): Fault| {
        let (line, key) = place(bare, span.start);
        let key = if key.is_empty() { String::new() } else { format!("{key} ") };
        shown(line, &format!("{key}{message}"))
    };
    let file: File = toml::from_str(bare).map_err(|error| {
        let (message, span) = (plain(&error.message().replace('\n', " ")), error.span().unwrap_or(0..0));
        if let Some(at) = open_list(bare, span.start) {
            return fault((at..at, "has a list that is not closed: `]` is missing".to_owned()));
        }
        let help = nearest_key(&message).or_else(|| written(&place(bare, span.start).1));
        let help = help.unwrap_or_else(|| "docs/machine.md lists the keys".to_owned());
        fault((span, format!("cannot be read: {message}; {help}")))
    })?;
    let lasers = lasers(&file).map_err(fault)?;
    let chosen = match chosen {
        None => 0,
        Some(name) => named(&lasers, name).map_err(|why| shown(0, &format!("--laser {why}")))?,
    };
    let mut machine = checked(&file, lasers).map_err(fault)?;
    machine.choose(chosen, &file.layers, fault);
    Ok(machine)
}

/// The index of the laser of this name.
///
/// # Errors
/// The name, and those that there are.
pub(crate) fn named(lasers: &[Laser], name: &str) -> Result<usize, String> {
    let of = |laser: &Laser| laser.name.as_deref() == Some(name);
    lasers.iter().position(of).ok_or_else(|| {
        let names: Vec<String> =
            lasers.iter().flat_map(|laser| &laser.name).map(|name| format!("\"{name}\"")).collect();
        let known = match (lasers, names.len()) {
            ([], _) => "the machine file has no laser".to_owned(),
            (_, 0) => "the machine file has one laser, [laser], which has no name: leave this out".to_owned(),
            (_, 1) => format!("the only laser is {}", names.concat()),
            _ => format!("lasers are {}", names.join(" and ")),
        };
        format!("is \"{}\"; {known}", name.chars().take(NAME_CHARACTERS).collect::<String>())
    })
}

/// The lasers of the file, in its order.
fn lasers(file: &File) -> Result<Vec<Laser>, Fault> {
    let tables = match (&file.laser, &file.lasers) {
        (None, None) => Vec::new(),
        (Some(keys), None) => vec![(None, keys)],
        (None, Some(tables)) if tables.get_ref().is_empty() => {
            return Err((
                tables.span(),
                "holds no laser; each has a table [lasers.NAME]: add one, or remove this".to_owned(),
            ));
        }
        (None, Some(tables)) => {
            let mut tables: Vec<_> = tables.get_ref().iter().map(|(name, keys)| (Some(name), keys)).collect();
            tables.sort_by_key(|(_, keys)| keys.span().start);
            tables
        }
        (Some(keys), Some(_)) => {
            let message = "stands beside [lasers.NAME]; a machine has one laser, [laser], or named ones: give this one a \
                           name, as [lasers.NAME], or remove it";
            return Err((keys.span(), message.to_owned()));
        }
    };
    let mut found: Vec<Laser> = Vec::new();
    for (name, keys) in tables {
        if found.len() == LASERS {
            let message = format!("is one laser too many; a machine has {LASERS}, one for each channel: remove one");
            return Err((keys.span(), message));
        }
        if let Some(name) = name {
            let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "-_".contains(letter);
            if !(1..=NAME_CHARACTERS).contains(&name.len()) || !name.chars().all(is_plain) {
                let message = format!("is no name of a laser; it is 1 to {NAME_CHARACTERS} letters, digits, - and _");
                return Err((keys.span(), message));
            }
        }
        let new = laser(name, keys, file.family)?;
        if let Some(other) = found.iter().find(|other| other.channel == new.channel) {
            let message = format!("is {}, as {}.channel; each laser has its own: 0 or 1", new.channel, other.table());
            return Err((keys.get_ref().channel.span(), message));
        }
        found.push(new);
    }
    Ok(found)
}

/// How like an unknown key a known one is that may be meant: 1 is equal.
const LIKENESS_MIN_SHARE: f64 = 0.8;

/// The known key that an unknown one may be a misspelling of, where the reader's message is about
/// one.
pub(crate) fn nearest_key(message: &str) -> Option<String> {
    // The message quotes the unknown key first, then the known ones.
    let mut quoted = message.strip_prefix("unknown field ")?.split('`').skip(1).step_by(2);
    let got = quoted.next()?;
    let likeness = |key: &str| strsim::jaro_winkler(&got.to_lowercase(), key);
    let nearest = quoted.max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    let nearest = nearest.filter(|key| likeness(key) >= LIKENESS_MIN_SHARE)?;
    Some(format!("the nearest known key is `{nearest}`"))
}

/// The byte of the last `key = [` before a fault, where its list runs into the next key or table.
fn open_list(text: &str, fault: usize) -> Option<usize> {
    let (mut at, mut open) = (0, None);
    for line in text.split_inclusive('\n') {
        let words = line.split('#').next().unwrap_or("");
        let value = words.split_once('=').map(|(_, value)| value.trim());
        let begins = value.is_some() || words.starts_with('[');
        if at + line.len() > fault {
            return open.filter(|_| begins);
        }
        match value {
            Some(value) => open = (value.starts_with('[') && !value.ends_with(']')).then_some(at),
            None if words.contains(']') => open = None,
            None => {}
        }
        at += line.len();
    }
    open
}

/// Line of a byte, from 1, and the key that stands there with its table.
fn place(text: &str, at: usize) -> (usize, String) {
    let at = at.min(text.len());
    let before = text.get(..at).unwrap_or("");
    let line = before.matches('\n').count();
    let (mut table, mut key) = (String::new(), String::new());
    for words in text.lines().take(line + 1) {
        let words = words.trim();
        if let Some(header) = words.strip_prefix('[').filter(|_| !words.contains('=')) {
            table = header.trim_start_matches('[').split(']').next().unwrap_or("").trim().to_owned();
            key.clear();
        } else if let Some((name, _)) = words.split_once('=') {
            // A value may go on over lines: the key is the last one before it.
            if !name.trim_start().starts_with('#') {
                key = name.trim().to_owned();
            }
        }
    }
    let whole = match (table.is_empty(), key.is_empty()) {
        (true, _) => key,
        (_, true) => table,
        _ => format!("{table}.{key}"),
    };
    (line + 1, whole)
}

impl Machine {
    /// Takes another laser than the first one. Layers that name none are marked by it; one that
    /// does not suit it says so once it has something to mark.
    fn choose(&mut self, chosen: usize, keys: &[Spanned<LayerKeys>], shown: impl Fn(Fault) -> String) {
        if chosen == self.chosen {
            return;
        }
        self.chosen = chosen;
        for (place, (layer, keys)) in self.layers.iter_mut().zip(keys).enumerate() {
            match layers::checked(keys, (&self.lasers, chosen), place) {
                Ok(new) => *layer = new,
                Err(fault) => layer.unfit = Some(shown(fault)),
            }
        }
    }
}

/// The machine of a file whose lasers are read; the first one is chosen.
/// Whether it names a link, by its form.
fn is_link(text: &str) -> bool {
    match text.split_once(':') {
        None => text == "qemu",
        Some(("tcp", address)) => address
            .rsplit_once(':')
            .is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok_and(|port| port > 0)),
        Some(("serial", path)) => !path.is_empty(),
        Some(_) => false,
    }
}

fn checked(file: &File, lasers: Vec<Laser>) -> Result<Machine, Fault> {
    if let Some(keys) = &file.axes.a {
        let message = "is a fourth axis; G-code and drawings move X, Y and Z only: remove this table".to_owned();
        return Err((keys.span(), message));
    }
    let mut axes: Vec<Axis> = Vec::new();
    for (letter, keys) in LETTERS.into_iter().zip([&file.axes.x, &file.axes.y, &file.axes.z]) {
        match keys {
            Some(keys) => axes.push(axis(letter, keys.get_ref(), &axes)?),
            None if letter == 'Z' => {}
            None => {
                let table = format!("[axes.{}]", letter.to_ascii_lowercase());
                return Err((0..0, format!("has no table {table}; a machine has X and Y at least: add it")));
            }
        }
    }
    let link = match &file.link.board {
        None => None,
        Some(board) if board.get_ref() == "virtual" => None,
        Some(link) => {
            let text = link.get_ref();
            if !is_link(text) {
                return Err((
                    link.span(),
                    format!("is \"{text}\"; it is virtual, tcp:HOST:PORT, serial:PATH[:BAUD] or qemu"),
                ));
            }
            Some(text.clone())
        }
    };
    let tolerance = |value: &Option<Spanned<f64>>, most: f64, usual: f64| {
        value.as_ref().map_or(Ok(usual), |value| within(value, 0.0001..=most, "mm"))
    };
    let usual = Path::default();
    let path = Path {
        junction_deviation: tolerance(&file.path.junction_deviation, 10.0, usual.junction_deviation)?,
        arc_tolerance: tolerance(&file.path.arc_tolerance, 1.0, usual.arc_tolerance)?,
    };
    let output = |value: &Option<Spanned<i64>>| {
        value.as_ref().map(|value| whole(value, 1..=16, "(a general output)").map(|number| number as u8)).transpose()
    };
    let outputs = Outputs { mist: output(&file.outputs.mist)?, flood: output(&file.outputs.flood)? };
    for laser in lasers.iter().filter(|laser| file.family == Family::Gus && laser.mode != Mode::Analog) {
        let taken = 7 + laser.channel;
        if axes.iter().any(|axis| axis.number == taken) {
            let tables = file.lasers.as_ref().map(Spanned::get_ref);
            let named = laser.name.as_ref().and_then(|name| tables?.get(name));
            let span = named.or(file.laser.as_ref()).map_or(0..0, |keys| keys.get_ref().channel.span());
            let message = format!(
                "is {}: in family gus it uses the connector of axis {taken}, which drives an axis; \
                 give the axis another number, or take another channel",
                laser.channel
            );
            return Err((span, message));
        }
    }
    let mut layers = Vec::new();
    for keys in &file.layers {
        layers.push(layers::checked(keys, (&lasers, 0), layers.len())?);
    }
    Ok(Machine { family: file.family, link, axes, lasers, chosen: 0, path, outputs, layers })
}

/// The parser's words, with its names of types as people say them.
fn plain(message: &str) -> String {
    let types = [
        ("expected f64", "expected a number"),
        ("expected i64", "expected a whole number"),
        ("expected a boolean", "expected true or false"),
        ("expected a sequence", "expected a list in [ ]"),
        ("expected struct", "expected the table"),
        ("invalid float, expected `nan`", "this is no value of TOML"),
        ("invalid boolean, expected `false`", "this is no value of TOML"),
        ("invalid boolean, expected `true`", "this is no value of TOML"),
    ];
    types.iter().fold(message.to_owned(), |text, (theirs, ours)| text.replace(theirs, ours))
}

fn axis(letter: char, keys: &AxisKeys, others: &[Axis]) -> Result<Axis, Fault> {
    let number = whole(&keys.number, PATH_AXES, "(a path reaches no other axis)")? as u8;
    if let Some(other) = others.iter().find(|other| other.number == number) {
        let message = format!("is {number}, as that of {}; each axis has its own", other.letter);
        return Err((keys.number.span(), message));
    }
    let steps_per_mm = within(&keys.steps_per_mm, 0.001..=100_000.0, "pulses a mm")?;
    let decimals = format!("{steps_per_mm}").split_once('.').map_or(0, |(_, decimals)| decimals.len());
    if decimals > STEP_DECIMALS as usize {
        let message = format!("is {steps_per_mm}, with {decimals} decimals; at most {STEP_DECIMALS} count: round it");
        return Err((keys.steps_per_mm.span(), message));
    }
    let reversed = keys.invert.unwrap_or(false);
    let &[least, most] = keys.travel.get_ref().as_slice() else {
        let got = keys.travel.get_ref().len();
        return Err((keys.travel.span(), format!("has {got} values; it is [least, greatest] in mm")));
    };
    if !(-POSITION_MAX_MM..=POSITION_MAX_MM).contains(&least)
        || !(-POSITION_MAX_MM..=POSITION_MAX_MM).contains(&most)
        || least >= most
    {
        let message = format!(
            "is [{least}, {most}]; it is [least, greatest] in mm, within {} to {POSITION_MAX_MM}",
            -POSITION_MAX_MM
        );
        return Err((keys.travel.span(), message));
    }
    if least.abs().max(most.abs()) * steps_per_mm > 2e9 {
        let message = format!("is [{least}, {most}]; at {steps_per_mm} pulses a mm that is more than 2e9 pulses");
        return Err((keys.travel.span(), message));
    }
    let max_rate = within(&keys.max_rate, 0.001..=1e7, "mm/min")?;
    let acceleration = within(&keys.acceleration, 0.001..=1e7, "mm/s²")?;
    let home = match &keys.home {
        None => 0.0f64.clamp(least, most),
        Some(value) => within(value, least..=most, "mm, the travel")?,
    };
    let (limits, alarm) = (keys.limits, keys.alarm);
    let travel = (least, most);
    let axis = Axis { letter, number, steps_per_mm, reversed, travel, max_rate, acceleration, home, limits, alarm };
    if axis.rate() >= RATE_MAX_PULSES {
        let most = RATE_MAX_PULSES / axis.rate() * max_rate;
        let message = format!("is {max_rate}; at {steps_per_mm} pulses a mm it is below {most:.0} mm/min");
        return Err((keys.max_rate.span(), message));
    }
    if axis.pulse_acceleration() >= RATE_MAX_PULSES {
        let most = RATE_MAX_PULSES / axis.pulse_acceleration() * acceleration;
        let message = format!("is {acceleration}; at {steps_per_mm} pulses a mm it is below {most:.0} mm/s²");
        return Err((keys.acceleration.span(), message));
    }
    Ok(axis)
}

fn laser(name: Option<&String>, spanned: &Spanned<LaserKeys>, family: Family) -> Result<Laser, Fault> {
    let keys = spanned.get_ref();
    let channel = whole(&keys.channel, 0..=1, "")? as u8;
    let missing = |key: &str, why: &str| (spanned.span(), format!("has no {key}; {why}"));
    let (highest_khz, widest_us) = match family {
        Family::Gus => (2000.0, 65_535),
        Family::Lsr => (24.0, 4000),
    };
    let carrier_khz = match (keys.mode, &keys.carrier_khz) {
        (Mode::Duty, Some(value)) => within(value, 0.001..=highest_khz, "kHz")?,
        (Mode::Duty, None) => return Err(missing("carrier_khz", "the duty mode needs it")),
        (_, Some(value)) => return Err((value.span(), "is for the mode \"duty\" only; remove it".to_owned())),
        (_, None) => 0.0,
    };
    let pulse_width_us = match (keys.mode, &keys.pulse_width_us) {
        (Mode::Frequency, Some(value)) => microseconds(value, 1..=widest_us)?,
        (Mode::Frequency, None) => return Err(missing("pulse_width_us", "the frequency mode needs it")),
        (_, Some(value)) => return Err((value.span(), "is for the mode \"frequency\" only; remove it".to_owned())),
        (_, None) => 0,
    };
    let &[least, full] = keys.power.get_ref().as_slice() else {
        let message = format!("has {} values; it is [power at S = 0, power at s_max]", keys.power.get_ref().len());
        return Err((keys.power.span(), message));
    };
    let (smallest, greatest, unit) = match keys.mode {
        Mode::Duty => (0.001, 100.0, "%"),
        Mode::Frequency => (0.001, highest_khz, "kHz"),
        Mode::Analog => (0.001, 10.0, "V"),
    };
    // A rate below 1 Hz other than 0 is none that the controller makes (SPEC 6).
    let whole_rate = keys.mode != Mode::Frequency || least == 0.0 || least >= smallest;
    if !((smallest..=greatest).contains(&full) && (0.0..=full).contains(&least) && whole_rate) {
        let message = format!(
            "is [{least}, {full}]; it is [power at S = 0, power at s_max]: 0 to the second, and {smallest} to \
             {greatest} {unit}"
        );
        return Err((keys.power.span(), message));
    }
    let power = (least, full);
    let s_max = within(&keys.s_max, 0.001..=1e6, "")?;
    let delay = |value: &Option<Spanned<f64>>| value.as_ref().map_or(Ok(0), |value| microseconds(value, 0..=65_535));
    let (on_delay_us, off_delay_us) = (delay(&keys.on_delay_us)?, delay(&keys.off_delay_us)?);
    let (name, mode) = (name.cloned(), keys.mode);
    Ok(Laser { name, channel, mode, carrier_khz, pulse_width_us, power, s_max, on_delay_us, off_delay_us })
}

/// Whole microseconds, which may be written as 5 or as 5.0.
fn microseconds(value: &Spanned<f64>, limits: RangeInclusive<u16>) -> Result<u16, Fault> {
    let got = *value.get_ref();
    if got.fract() == 0.0 && (f64::from(*limits.start())..=f64::from(*limits.end())).contains(&got) {
        return Ok(got as u16);
    }
    Err((value.span(), format!("is {got}; it is a whole number from {} to {} µs", limits.start(), limits.end())))
}
