//! `$$`: the machine as Grbl's settings.
//!
//! In: the machine file, and what a sender sets. Out: the list, in Grbl's order. What only reports
//! (`$10`, `$13`) can be set. All else is the machine file's: a value that is in force already is
//! accepted, so that a sender which writes all settings back goes on; another one is refused.
use machine::{Limits, Machine};

/// `$10` bit 0: MPos; bit 1: Bf.
const REPORT: u8 = 3;

/// What a sender may set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settings {
    /// `$10`.
    pub report: u8,
    /// `$13`: reports are in inches.
    pub inches: bool,
    /// `$N0` and `$N1`: lines that run after the banner.
    pub startup: [String; 2],
}

impl Settings {
    /// Those of the beginning.
    pub fn new() -> Settings {
        Settings { report: REPORT, inches: false, startup: [String::new(), String::new()] }
    }

    /// Number and value of each, in Grbl's order.
    pub fn list(&self, machine: &Machine) -> Vec<(u16, String)> {
        let flag = |on: bool| u8::from(on).to_string();
        let reversed =
            machine.axes.iter().enumerate().map(|(place, axis)| u8::from(axis.reversed) << place).sum::<u8>();
        let limits = machine.axes.iter().any(|axis| axis.limits != Limits::None);
        let (s_max, s_min) = machine.laser().map_or((0.0, 0.0), |laser| (laser.s_max, 0.0));
        let mut list = vec![
            (0, "10".to_owned()),
            (1, "255".to_owned()),
            (2, "0".to_owned()),
            (3, reversed.to_string()),
            (4, "0".to_owned()),
            (5, "0".to_owned()),
            (6, "0".to_owned()),
            (10, self.report.to_string()),
            (11, format!("{:.3}", machine.path.junction_deviation)),
            (12, format!("{:.3}", machine.path.arc_tolerance)),
            (13, flag(self.inches)),
            (20, "1".to_owned()),
            (21, flag(limits)),
            (22, "1".to_owned()),
            (23, "0".to_owned()),
            (30, format!("{s_max:.0}")),
            (31, format!("{s_min:.0}")),
            (32, flag(machine.laser().is_some())),
        ];
        type Of = fn(&machine::Axis) -> f64;
        let rows: [(u16, Of); 4] = [
            (100, |axis| axis.steps_per_mm),
            (110, |axis| axis.max_rate),
            (120, |axis| axis.acceleration),
            (130, |axis| axis.travel.1 - axis.travel.0),
        ];
        for (first, of) in rows {
            for (place, axis) in machine.axes.iter().enumerate() {
                list.push((first + place as u16, format!("{:.3}", of(axis))));
            }
        }
        list
    }

    /// `$number=value`.
    ///
    /// # Errors
    /// Which values are taken.
    pub fn set(&mut self, number: &str, value: &str, machine: &Machine) -> Result<(), String> {
        let list = self.list(machine);
        let listed = list.iter().find(|(other, _)| number.parse() == Ok(*other));
        let (number, now) = listed.ok_or_else(|| format!("there is no setting ${number:.9}; $$ lists them"))?;
        let wanted = value.parse::<f64>().unwrap_or(f64::NAN);
        match number {
            10 if wanted.fract() == 0.0 && (0.0..=3.0).contains(&wanted) => self.report = wanted as u8,
            10 => return Err("$10 is 0 to 3: 1 shows MPos, else WPos, and 2 more show Bf".to_owned()),
            13 if wanted == 0.0 || wanted == 1.0 => self.inches = wanted == 1.0,
            13 => return Err("$13 is 0 (reports in mm) or 1 (in inches)".to_owned()),
            _ if now.parse::<f64>().is_ok_and(|now| (now - wanted).abs() < 5e-4) => {}
            _ => return Err(format!("${number} is {now} here; only the machine file changes the machine")),
        }
        Ok(())
    }
}
