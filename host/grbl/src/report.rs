//! What `?` answers.
//!
//! In: positions, state, overrides. Out: a line in angle brackets, as Grbl 1.1 writes it. Owns the
//! counts that say when WCO and Ov come along.
use std::fmt::Write;

/// Reports from one with WCO, respectively Ov, to the next, while it moves and while it stands.
const WCO: (u8, u8) = (30, 10);
const OV: (u8, u8) = (20, 10);

/// What a report says.
pub struct Report<'a> {
    /// `Idle`, `Run`, `Hold:0` …
    pub state: &'a str,
    /// Machine position, mm.
    pub at: [f64; 3],
    /// Work position is so much less.
    pub zero: [f64; 3],
    /// Free blocks, and free bytes.
    pub free: (u64, usize),
    /// mm/min.
    pub feed: f64,
    /// S that is output now.
    pub power: f64,
    /// Feed, rapid, power, %.
    pub overrides: [u8; 3],
    /// `S` or `C`, `F`, `M`.
    pub accessories: &'a str,
    /// It moves.
    pub busy: bool,
    /// `$10`.
    pub mask: u8,
    /// Reports are in inches.
    pub inches: bool,
}

/// When the parts come that are not in every report.
#[derive(Debug, Default)]
pub struct Turns {
    wco: u8,
    ov: u8,
    last: Option<([f64; 3], [u8; 3])>,
}

/// A number of mm as reports show it.
pub fn length(mm: f64, inches: bool) -> String {
    // No sign before a zero.
    match inches {
        true => format!("{:.4}", (mm / 25.4 * 1e4).round() / 1e4 + 0.0),
        false => format!("{:.3}", (mm * 1e3).round() / 1e3 + 0.0),
    }
}

/// Three of them.
pub fn point(mm: [f64; 3], inches: bool) -> String {
    mm.map(|mm| length(mm, inches)).join(",")
}

impl Turns {
    /// The next report has WCO, and the one after it Ov.
    pub fn anew(&mut self) {
        *self = Turns::default();
    }

    /// The line.
    pub fn line(&mut self, report: &Report<'_>) -> String {
        let now = (report.zero, report.overrides);
        if let Some((zero, overrides)) = self.last {
            if zero != now.0 {
                self.wco = 0;
            }
            if overrides != now.1 {
                self.ov = 0;
            }
        }
        self.last = Some(now);
        let mut line = format!("<{}", report.state);
        let (name, at) = match report.mask & 1 {
            1 => ("MPos", report.at),
            _ => ("WPos", [0, 1, 2].map(|axis| report.at[axis] - report.zero[axis])),
        };
        // Writing to a String does not fail.
        let _ = write!(line, "|{name}:{}", point(at, report.inches));
        if report.mask & 2 != 0 {
            let _ = write!(line, "|Bf:{},{}", report.free.0, report.free.1);
        }
        let feed = if report.inches { report.feed / 25.4 } else { report.feed };
        let _ = write!(line, "|FS:{feed:.0},{:.0}", report.power);
        let of = |turns: (u8, u8)| if report.busy { turns.0 } else { turns.1 };
        if self.wco == 0 {
            let _ = write!(line, "|WCO:{}", point(report.zero, report.inches));
            self.wco = of(WCO);
            // Never both in one line.
            self.ov = self.ov.max(1);
        } else {
            self.wco -= 1;
        }
        if self.ov == 0 {
            let [feed, rapid, power] = report.overrides;
            let _ = write!(line, "|Ov:{feed},{rapid},{power}");
            if !report.accessories.is_empty() {
                let _ = write!(line, "|A:{}", report.accessories);
            }
            self.ov = of(OV);
        } else {
            self.ov -= 1;
        }
        line + ">"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_grbls() {
        let mut turns = Turns::default();
        let mut report = Report {
            state: "Idle",
            at: [1.0, -0.0001, 2.54],
            zero: [0.5, 0.0, 0.0],
            free: (15, 128),
            feed: 0.0,
            power: 0.0,
            overrides: [100, 100, 100],
            accessories: "",
            busy: false,
            mask: 3,
            inches: false,
        };
        assert_eq!(turns.line(&report), "<Idle|MPos:1.000,0.000,2.540|Bf:15,128|FS:0,0|WCO:0.500,0.000,0.000>");
        assert_eq!(turns.line(&report), "<Idle|MPos:1.000,0.000,2.540|Bf:15,128|FS:0,0|Ov:100,100,100>");
        assert_eq!(turns.line(&report), "<Idle|MPos:1.000,0.000,2.540|Bf:15,128|FS:0,0>");
        (report.overrides, report.accessories) = ([90, 100, 100], "SF");
        assert!(turns.line(&report).ends_with("|FS:0,0|Ov:90,100,100|A:SF>"));
        report.zero = [0.0; 3];
        assert!(turns.line(&report).ends_with("|WCO:0.000,0.000,0.000>"));
        (report.mask, report.inches, report.feed, report.state) = (0, true, 254.0, "Run");
        report.zero = [1.0, 0.0, 0.0];
        assert_eq!(turns.line(&report), "<Run|WPos:0.0000,0.0000,0.1000|FS:10,0|WCO:0.0394,0.0000,0.0000>");
    }
}
