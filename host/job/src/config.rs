//! Configuration files of `GT_LoadConfig`: limits, alarms, stop decelerations and bands of the
//! axes.
//!
//! In: the text, in one of two forms. TOML with tables `[axis.N]` or `[axis.A-B]` is ours; the ini
//! form with sections `[axisN]`, `[profileN]`, `[controlN]` … is that of the manuals' set-up tool.
//! Out: one [`ConfigItem`] for each axis that is named, and a warning that lists keys without a
//! meaning here. `docs/jobs.md` lists the keys.

use crate::diagnostic::{quoted, tidy};
use ini::Ini;
use protocol::command::ConfigItem;
use protocol::values::given;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use zerocopy::IntoBytes;

/// Power-on stop decelerations (SPEC 5), for the one of the two that a file leaves out, pulse/ms².
const DEC_SMOOTH_PULSES_PER_MS2: f64 = 1.0;
const DEC_ABRUPT_PULSES_PER_MS2: f64 = 1000.0;
/// Axes that a file may number.
const AXES: std::ops::RangeInclusive<i16> = 1..=32;

/// What a file says.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// One item an axis, by ascending axis.
    pub items: Vec<ConfigItem>,
    /// What has no effect.
    pub warnings: Vec<String>,
}

/// The items as they travel.
pub fn bytes(items: &[ConfigItem]) -> Vec<u8> {
    items.as_bytes().to_vec()
}

/// Reads a file named `path` with this text.
///
/// # Errors
/// What is wrong with it, and in which line or key.
pub fn read(path: &str, text: &str) -> Result<Config, String> {
    let found = read_text(&quoted(path), text, is_toml(path)).map_err(|error| tidy(&error))?;
    let warnings = found.warnings.iter().map(|warning| tidy(warning)).collect();
    Ok(Config { warnings, ..found })
}

fn is_toml(path: &str) -> bool {
    path.to_lowercase().ends_with(".toml")
}

fn read_text(path: &str, text: &str, toml: bool) -> Result<Config, String> {
    let text = text.trim_start_matches('\u{feff}');
    let ours = toml || text.lines().any(|line| line.trim_start().starts_with("[axis."));
    let (axes, unknown) =
        if ours { toml_axes(text) } else { ini_axes(text) }.map_err(|error| format!("{path}: {error}"))?;
    let mut warnings = Vec::new();
    if !unknown.is_empty() {
        let list = unknown.into_iter().collect::<Vec<_>>().join(", ");
        warnings.push(format!("{path}: these keys have no effect: {list}"));
    }
    if axes.is_empty() {
        warnings.push(format!("{path} configures no axis"));
    }
    let items = axes
        .iter()
        .map(|(axis, keys)| keys.item(*axis))
        .collect::<Result<_, _>>()
        .map_err(|error| format!("{path}: {error}"))?;
    Ok(Config { items, warnings })
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Limits {
    None,
    Positive,
    Negative,
    Both,
}

/// What a file may say about an axis.
#[derive(Debug, Clone, Default, Deserialize)]
struct Keys {
    limits: Option<Limits>,
    limit_positive_sense: Option<u8>,
    limit_negative_sense: Option<u8>,
    alarm: Option<bool>,
    alarm_sense: Option<u8>,
    home_sense: Option<u8>,
    soft_limit_positive: Option<i32>,
    soft_limit_negative: Option<i32>,
    stop_dec_smooth: Option<f64>,
    stop_dec_abrupt: Option<f64>,
    position_error: Option<i32>,
    band: Option<i32>,
    band_time: Option<i32>,
    #[serde(flatten)]
    unknown: BTreeMap<String, toml::Value>,
}

impl Keys {
    /// `other` wins where it says something.
    fn and(&mut self, other: Keys) {
        macro_rules! take { ($($key:ident),*) => { $( if other.$key.is_some() { self.$key = other.$key; } )* } }
        take!(
            limits,
            limit_positive_sense,
            limit_negative_sense,
            alarm,
            alarm_sense,
            home_sense,
            soft_limit_positive,
            soft_limit_negative,
            stop_dec_smooth,
            stop_dec_abrupt,
            position_error,
            band,
            band_time
        );
    }

    fn item(&self, axis: i16) -> Result<ConfigItem, String> {
        let sense = |key: &str, value: Option<u8>| match value {
            None => Ok(0),
            Some(level @ 0..=1) => Ok(level),
            Some(other) => Err(format!("axis {axis}: {key} is {other}; it is 0 or 1")),
        };
        let deceleration = |key: &str, value: Option<f64>, default| match value {
            Some(value) if !(value.is_finite() && value > 0.0) => {
                Err(format!("axis {axis}: {key} is {value}; it is greater than 0"))
            }
            value => Ok(value.unwrap_or(default)),
        };
        let mut bits = 0;
        let mut say = |bit: u16, said: bool| bits |= if said { bit } else { 0 };
        say(given::LIMITS, self.limits.is_some());
        say(given::LIMIT_SENSE, self.limit_positive_sense.is_some() || self.limit_negative_sense.is_some());
        say(given::ALARM, self.alarm.is_some());
        say(given::ALARM_SENSE, self.alarm_sense.is_some());
        say(given::SOFT_LIMITS, self.soft_limit_positive.is_some() || self.soft_limit_negative.is_some());
        say(given::STOP_DEC, self.stop_dec_smooth.is_some() || self.stop_dec_abrupt.is_some());
        say(given::POS_ERR, self.position_error.is_some());
        say(given::BAND, self.band.is_some() || self.band_time.is_some());
        say(given::HOME_SENSE, self.home_sense.is_some());
        if self.band.is_some() != self.band_time.is_some() {
            return Err(format!("axis {axis}: band and band_time belong together"));
        }
        Ok(ConfigItem {
            axis: axis.into(),
            given: bits.into(),
            limits_on: match self.limits {
                None | Some(Limits::None) => 0,
                Some(Limits::Positive) => 1,
                Some(Limits::Negative) => 2,
                Some(Limits::Both) => 3,
            },
            limit_sense: sense("limit_positive_sense", self.limit_positive_sense)?
                | sense("limit_negative_sense", self.limit_negative_sense)? << 1,
            alarm_on: u8::from(self.alarm == Some(true)),
            alarm_sense: sense("alarm_sense", self.alarm_sense)?,
            soft_positive: self.soft_limit_positive.unwrap_or(i32::MAX).into(),
            soft_negative: self.soft_limit_negative.unwrap_or(i32::MIN).into(),
            dec_smooth: deceleration("stop_dec_smooth", self.stop_dec_smooth, DEC_SMOOTH_PULSES_PER_MS2)?.into(),
            dec_abrupt: deceleration("stop_dec_abrupt", self.stop_dec_abrupt, DEC_ABRUPT_PULSES_PER_MS2)?.into(),
            pos_err: self.position_error.unwrap_or(0).into(),
            band: self.band.unwrap_or(0).into(),
            band_time_cycles: self.band_time.unwrap_or(0).into(),
            home_sense: sense("home_sense", self.home_sense)?,
        })
    }
}

type Axes = (BTreeMap<i16, Keys>, BTreeSet<String>);

#[derive(Deserialize)]
struct File {
    #[serde(default)]
    axis: BTreeMap<String, Keys>,
    #[serde(flatten)]
    unknown: BTreeMap<String, toml::Value>,
}

fn toml_axes(text: &str) -> Result<Axes, String> {
    let file: File = toml::from_str(text).map_err(|error| {
        // Its own text quotes the line, however long that is.
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or("");
        let number = before.matches('\n').count();
        let line = quoted(text.lines().nth(number).unwrap_or("").trim());
        format!("line {}, `{line}`: {}", number + 1, error.message())
    })?;
    let mut unknown: BTreeSet<String> = file.unknown.into_keys().collect();
    let mut tables = Vec::new();
    for (name, keys) in file.axis {
        let (first, last) = name.split_once('-').unwrap_or((&name, &name));
        let number = |text: &str| text.trim().parse().ok().filter(|axis| AXES.contains(axis));
        match (number(first), number(last)) {
            (Some(first), Some(last)) if first <= last => tables.push((first, last, keys)),
            _ => return Err(format!("[axis.{name}]: axes are 1 to 32, a range is written [axis.1-8]")),
        }
    }
    // A narrower table wins over a wider one.
    tables.sort_by_key(|(first, last, _)| std::cmp::Reverse(last - first));
    let mut axes: BTreeMap<i16, Keys> = BTreeMap::new();
    for (first, last, keys) in tables {
        unknown.extend(keys.unknown.keys().cloned());
        for axis in first..=last {
            axes.entry(axis).or_default().and(keys.clone());
        }
    }
    Ok((axes, unknown))
}

fn ini_axes(text: &str) -> Result<Axes, String> {
    let file = Ini::load_from_str(text).map_err(|error| error.to_string())?;
    let mut axes: BTreeMap<i16, Keys> = BTreeMap::new();
    let mut unknown = BTreeSet::new();
    // Which of the two limits a file names, before both are known.
    let mut named: BTreeMap<i16, [Option<bool>; 2]> = BTreeMap::new();
    for (section, properties) in file.iter() {
        let section = section.unwrap_or("");
        let name = section.trim_end_matches(|digit: char| digit.is_ascii_digit());
        let axis: Option<i16> = section[name.len()..].parse().ok().filter(|axis| AXES.contains(axis));
        for (key, value) in properties.iter() {
            let value = value.split(';').next().unwrap_or("").trim();
            let place = format!("[{section}] {key}");
            let number = || real(value).ok_or_else(|| format!("{place} is {value}, which is not a number"));
            let whole = || Ok::<i32, String>(number()?.clamp(f64::from(i32::MIN), f64::from(i32::MAX)) as i32);
            let level = || Ok::<u8, String>(whole()?.clamp(0, 255) as u8);
            let Some(axis) = axis else {
                unknown.insert(place);
                continue;
            };
            match (name, key) {
                ("profile", "decSmoothStop") => axes.entry(axis).or_default().stop_dec_smooth = Some(number()?),
                ("profile", "decAbruptStop") => axes.entry(axis).or_default().stop_dec_abrupt = Some(number()?),
                // The signal's type, −1 (MC_NONE) for none.
                ("axis", "alarmType") => axes.entry(axis).or_default().alarm = Some(whole()? >= 0),
                ("axis", "limitPositiveType") => named.entry(axis).or_default()[0] = Some(whole()? >= 0),
                ("axis", "limitNegativeType") => named.entry(axis).or_default()[1] = Some(whole()? >= 0),
                ("control", "errorLimit") => axes.entry(axis).or_default().position_error = Some(whole()?),
                ("limitPositive", "reverse") => axes.entry(axis).or_default().limit_positive_sense = Some(level()?),
                ("limitNegative", "reverse") => axes.entry(axis).or_default().limit_negative_sense = Some(level()?),
                ("alarm", "reverse") => axes.entry(axis).or_default().alarm_sense = Some(level()?),
                ("home", "reverse") => axes.entry(axis).or_default().home_sense = Some(level()?),
                _ => {
                    unknown.insert(format!("[{name}N] {key}"));
                }
            }
        }
    }
    for (axis, [positive, negative]) in named {
        let limits = match (positive.unwrap_or(true), negative.unwrap_or(true)) {
            (false, false) => Limits::None,
            (true, false) => Limits::Positive,
            (false, true) => Limits::Negative,
            (true, true) => Limits::Both,
        };
        axes.entry(axis).or_default().limits = Some(limits);
    }
    Ok((axes, unknown))
}

fn real(text: &str) -> Option<f64> {
    match text.strip_prefix("0x").or(text.strip_prefix("0X")) {
        Some(digits) => u32::from_str_radix(digits, 16).ok().map(f64::from),
        None => text.parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_table_wins_over_a_wide_one() {
        let text = "[axis.1-8]\nlimits = \"none\"\nalarm = false\n[axis.3]\nalarm = true\nstop_dec_smooth = 2.5\n";
        let config = read("a.cfg", text).unwrap();
        assert!(config.warnings.is_empty());
        assert_eq!(config.items.len(), 8);
        let third = config.items[2];
        assert_eq!((third.axis.get(), third.alarm_on, third.limits_on), (3, 1, 0));
        assert_eq!((third.dec_smooth.get(), third.dec_abrupt.get()), (2.5, 1000.0));
        assert_eq!(third.given.get(), given::LIMITS | given::ALARM | given::STOP_DEC);
        assert_eq!((config.items[3].alarm_on, config.items[3].given.get()), (0, given::LIMITS | given::ALARM));
    }

    #[test]
    fn the_ini_form_of_the_set_up_tool() {
        let text = "; tool\n[profile1]\nactive=1\ndecSmoothStop=0.5\n[axis1]\nalarmType=-1\nlimitPositiveType=-1\nlimitNegativeType=1\n\
                    prfMap=0x1\n[control2]\nerrorLimit=32767\n[home2]\nreverse=1\n";
        let config = read("test.cfg", text).unwrap();
        assert_eq!(config.items.len(), 2);
        let (one, two) = (config.items[0], config.items[1]);
        assert_eq!((one.dec_smooth.get(), one.alarm_on, one.limits_on), (0.5, 0, 2));
        assert_eq!((two.pos_err.get(), two.home_sense), (32767, 1));
        assert_eq!(config.warnings, ["test.cfg: these keys have no effect: [axisN] prfMap, [profileN] active"]);
    }

    #[test]
    fn wrong_values_name_their_key() {
        let wrong = |text: &str| read("x.toml", text).unwrap_err();
        assert!(wrong("[axis.0]\n").contains("[axis.0]"));
        assert!(wrong("[axis.5-2]\n").contains("[axis.5-2]"));
        assert!(wrong("[axis.1]\nlimits = \"some\"\n").contains("limits"));
        assert!(wrong("[axis.1]\nstop_dec_smooth = -1.0\n").contains("stop_dec_smooth"));
        assert!(wrong("[axis.1]\nstop_dec_smooth = nan\n").contains("stop_dec_smooth"));
        assert!(wrong("[axis.1]\nhome_sense = 2\n").contains("home_sense"));
        assert!(wrong("[axis.1]\nband = 5\n").contains("band_time"));
        assert!(wrong("[axis.1\n").contains("x.toml"));
        assert!(read("x.cfg", "[axis1]\nalarmType=many\n").unwrap_err().contains("[axis1] alarmType"));
    }

    #[test]
    fn unknown_keys_are_listed_once() {
        let config = read("x.toml", "speed = 3\n[axis.1-2]\nlimit = 1\n").unwrap();
        assert_eq!(config.warnings, ["x.toml: these keys have no effect: limit, speed"]);
        assert_eq!(read("x.cfg", "").unwrap().warnings, ["x.cfg configures no axis"]);
    }
}
