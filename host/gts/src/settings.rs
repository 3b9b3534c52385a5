//! What the environment says about the controller that Open opens.
//!
//! In: `BEAMTICK_LINK`, `BEAMTICK_PROFILE`, `BEAMTICK_FAMILY`, `BEAMTICK_INPUTS`, `BEAMTICK_TRACE`,
//! `BEAMTICK_VCD`, `BEAMTICK_BATCHES`, each for a card of its own too (`BEAMTICK_LINK_3`). Fails
//! with −6 and the variable's name.

use crate::card::CardSlot;
use client::error::CANNOT_OPEN;
use client::{Error, Family, ProductProfile, Result};
use std::path::{Path, PathBuf};

/// The link to the controller.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkChoice {
    /// The controller in this process, so many times faster than the wall clock; `None` as fast as
    /// it can.
    Virtual(Option<f64>),
    /// The emulated board.
    Qemu,
    /// A link by its name.
    Link(String),
}

/// See the module text.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The link.
    pub road: LinkChoice,
    /// The profile; where none is given, the virtual controller shows what the call family
    /// suggests.
    pub profile: Option<ProductProfile>,
    /// The family.
    pub family: Option<Family>,
    /// What the inputs do, from Open on.
    pub inputs: Option<PathBuf>,
    /// File of the trace as CSV.
    pub trace: Option<PathBuf>,
    /// File of the trace as VCD.
    pub vcd: Option<PathBuf>,
    /// File of its picture: SVG, PNG, or a page of HTML.
    pub plot: Option<PathBuf>,
    /// File of all calls.
    pub log: Option<PathBuf>,
    /// Whether PT data may travel in batches.
    pub batches: bool,
}

impl Settings {
    /// The settings for a card. `variable` looks an environment variable up.
    pub fn read(slot: CardSlot, variable: impl Fn(&str) -> Option<String>) -> Result<Settings> {
        let value = |name: &str| {
            let own = slot.number().and_then(|card| variable(&format!("{name}_{card}")));
            own.or_else(|| variable(name)).filter(|text| !text.is_empty())
        };
        let wrong =
            |name: &str, text: &str, known: &str| Error::new(CANNOT_OPEN, format!("{name} is `{text}`; it is {known}"));
        let link = value("BEAMTICK_LINK").unwrap_or_else(|| "virtual".to_owned());
        let road = match link.split_once(':') {
            None if link == "virtual" => LinkChoice::Virtual(Some(1.0)),
            None if link == "qemu" => LinkChoice::Qemu,
            Some(("virtual", "max")) => LinkChoice::Virtual(None),
            Some(("virtual", factor)) => match factor.parse::<f64>() {
                Ok(factor) if (1e-3..=1e6).contains(&factor) => LinkChoice::Virtual(Some(factor)),
                _ => {
                    return Err(wrong(
                        "BEAMTICK_LINK",
                        &link,
                        "virtual:SPEED with a factor from 0.001 to 1000000, or virtual:max",
                    ));
                }
            },
            Some(("tcp" | "serial" | "qemu", _)) => LinkChoice::Link(link),
            _ => {
                let known = "virtual[:SPEED|:max], qemu[:IMAGE], tcp:HOST:PORT or serial:PATH[:BAUD]";
                return Err(wrong("BEAMTICK_LINK", &link, known));
            }
        };
        let profile = match value("BEAMTICK_PROFILE") {
            None => None,
            Some(name) => {
                let all: Vec<&str> = ProductProfile::ALL.iter().map(|(_, name)| *name).collect();
                Some(ProductProfile::named(&name).ok_or_else(|| wrong("BEAMTICK_PROFILE", &name, &all.join(", ")))?)
            }
        };
        let family = match value("BEAMTICK_FAMILY") {
            None => None,
            Some(name) => Some(Family::named(&name).ok_or_else(|| wrong("BEAMTICK_FAMILY", &name, "gus or lsr"))?),
        };
        let settings = Settings {
            road,
            profile,
            family,
            inputs: value("BEAMTICK_INPUTS").map(PathBuf::from),
            trace: value("BEAMTICK_TRACE").map(PathBuf::from),
            vcd: value("BEAMTICK_VCD").map(PathBuf::from),
            plot: value("BEAMTICK_PLOT").map(PathBuf::from),
            log: value("BEAMTICK_LOG").map(PathBuf::from),
            batches: value("BEAMTICK_BATCHES").as_deref() != Some("off"),
        };
        if settings.is_traced() && !matches!(settings.road, LinkChoice::Virtual(_)) {
            return Err(Error::new(
                CANNOT_OPEN,
                "BEAMTICK_TRACE, BEAMTICK_VCD and BEAMTICK_PLOT are for BEAMTICK_LINK=virtual",
            ));
        }
        if let Some(plot) = &settings.plot
            && !ends_in(plot, &["png", "svg", "html"])
        {
            return Err(wrong("BEAMTICK_PLOT", &plot.display().to_string(), "a name that ends in .png, .svg or .html"));
        }
        Ok(settings)
    }

    /// Whether the picture is a page of HTML.
    pub fn draws_page(&self) -> bool {
        self.plot.as_deref().is_some_and(|plot| ends_in(plot, &["html"]))
    }

    /// Whether a trace is recorded.
    pub fn is_traced(&self) -> bool {
        self.trace.is_some() || self.vcd.is_some() || self.plot.is_some()
    }
}

fn ends_in(name: &Path, known: &[&str]) -> bool {
    name.extension().is_some_and(|end| known.iter().any(|known| end.eq_ignore_ascii_case(known)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(pairs: &[(&str, &str)], slot: CardSlot) -> Result<Settings> {
        Settings::read(slot, |name| pairs.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned()))
    }

    #[test]
    fn links_by_name() {
        for (text, road) in [
            ("virtual", LinkChoice::Virtual(Some(1.0))),
            ("virtual:50", LinkChoice::Virtual(Some(50.0))),
            ("virtual:0.5", LinkChoice::Virtual(Some(0.5))),
            ("virtual:max", LinkChoice::Virtual(None)),
            ("qemu", LinkChoice::Qemu),
            ("tcp:1.2.3.4:5", LinkChoice::Link("tcp:1.2.3.4:5".into())),
            ("serial:COM3:115200", LinkChoice::Link("serial:COM3:115200".into())),
        ] {
            assert_eq!(with(&[("BEAMTICK_LINK", text)], CardSlot::ONE).unwrap().road, road, "{text}");
        }
        assert_eq!(with(&[], CardSlot::ONE).unwrap().road, LinkChoice::Virtual(Some(1.0)));
        for text in ["virtual:0", "virtual:fast", "virtual:nan", "usb", "udp:1"] {
            let error = with(&[("BEAMTICK_LINK", text)], CardSlot::ONE).unwrap_err();
            assert_eq!(error.code, -6, "{text}");
            assert!(error.reason.contains(text), "{}", error.reason);
        }
    }

    #[test]
    fn a_card_has_variables_of_its_own() {
        let pairs = [("BEAMTICK_LINK", "virtual:max"), ("BEAMTICK_LINK_3", "tcp:a:1"), ("BEAMTICK_FAMILY", "lsr")];
        assert_eq!(with(&pairs, CardSlot::card(3).unwrap()).unwrap().road, LinkChoice::Link("tcp:a:1".into()));
        assert_eq!(with(&pairs, CardSlot::card(2).unwrap()).unwrap().road, LinkChoice::Virtual(None));
        assert_eq!(with(&pairs, CardSlot::ONE).unwrap().family, Some(Family::Lsr));
    }

    #[test]
    fn what_no_controller_has_is_named() {
        assert!(with(&[("BEAMTICK_PROFILE", "gtx")], CardSlot::ONE).unwrap_err().reason.contains("gsn-048"));
        assert!(with(&[("BEAMTICK_FAMILY", "x")], CardSlot::ONE).unwrap_err().reason.contains("gus or lsr"));
        let error = with(&[("BEAMTICK_LINK", "tcp:a:1"), ("BEAMTICK_TRACE", "t.csv")], CardSlot::ONE).unwrap_err();
        assert!(error.reason.contains("BEAMTICK_TRACE"));
    }
}
