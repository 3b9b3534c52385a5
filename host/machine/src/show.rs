//! What a machine file says, in mm.
use crate::layers;
use crate::{Family, Limits, Machine, Mode};

/// Lines for the user.
pub fn show(machine: &Machine) -> String {
    let mut text = String::new();
    for axis in &machine.axes {
        let reversed = if axis.reversed { ", reversed" } else { "" };
        text += &format!(
            "{}: axis {}{reversed}, {} pulses/mm ({:.6} mm a pulse), travel {} to {} mm, home {} mm\n",
            axis.letter,
            axis.number,
            axis.steps_per_mm,
            1.0 / axis.steps_per_mm,
            axis.travel.0,
            axis.travel.1,
            axis.home
        );
        let limits = match axis.limits {
            Limits::None => "no limit inputs",
            Limits::Positive => "positive limit input",
            Limits::Negative => "negative limit input",
            Limits::Both => "both limit inputs",
        };
        text += &format!(
            "   up to {} mm/min ({:.4} pulse/ms), {} mm/s² ({:.6} pulse/ms²); {limits}, {}\n",
            axis.max_rate,
            axis.rate(),
            axis.acceleration,
            axis.pulse_acceleration(),
            if axis.alarm { "drive alarm in use" } else { "no drive alarm" }
        );
    }
    if machine.lasers.is_empty() {
        text += "no laser\n";
    }
    for (index, laser) in machine.lasers.iter().enumerate() {
        let unit = laser.unit();
        let how = match laser.mode {
            Mode::Duty => format!("duty of a carrier of {} kHz", laser.carrier_khz),
            Mode::Frequency => format!("rate of pulses of {} µs", laser.pulse_width_us),
            Mode::Analog => "voltage".to_owned(),
        };
        text += &format!(
            "laser{}: channel {}, {how}; S0 is dark, S above it {} to {} {unit} (S{}); delays on {} µs, off {} µs{}\n",
            laser.name.as_ref().map_or_else(String::new, |name| format!(" \"{name}\"")),
            laser.channel,
            laser.power.0,
            laser.power.1,
            laser.s_max,
            laser.on_delay_us,
            laser.off_delay_us,
            if machine.lasers.len() > 1 && index == machine.chosen {
                "; G-code and layers that name none take it"
            } else {
                ""
            }
        );
    }
    text += &format!(
        "corners within {} mm, curves within {} mm; family {}; board {}\n",
        machine.path.junction_deviation,
        machine.path.arc_tolerance,
        match machine.family {
            Family::Gus => "gus",
            Family::Lsr => "lsr",
        },
        machine.link.as_deref().unwrap_or("virtual")
    );
    for layer in &machine.layers {
        text += &layers::show(layer, machine);
    }
    let output = |name: &str, output: Option<u8>| output.map(|number| format!("{name} switches output {number}\n"));
    text + &output("M7", machine.outputs.mist).unwrap_or_default()
        + &output("M8", machine.outputs.flood).unwrap_or_default()
}
