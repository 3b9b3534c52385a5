//! A new machine file: the questions it answers, and its text.
//!
//! In: which axes, whether there is a laser, answers. Out: a commented TOML text. Fails with the
//! key whose answer is wrong: there is no file yet whose line could be named.
use crate::{Machine, file};

/// One thing that a machine file says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    /// The key with its table: `axes.x.steps_per_mm`.
    pub key: String,
    /// What it means, with unit and limits.
    pub meaning: &'static str,
    /// The answer, as TOML; an empty one leaves the key out.
    pub value: String,
}

/// Keys of an axis: name, what it means, usual value.
const AXIS: [(&str, &str, &str); 9] = [
    ("number", "axis of the controller, 1 to 8", "1"),
    ("steps_per_mm", "pulses a mm", "100"),
    ("invert", "true where the axis counts down", "false"),
    ("travel", "least and greatest machine position, mm", "[0, 300]"),
    ("max_rate", "greatest speed, mm/min", "12000"),
    ("acceleration", "greatest acceleration, mm/s²", "1000"),
    ("home", "machine position where the axis stands when a job begins, mm", "0"),
    ("limits", "limit inputs in use: \"none\", \"positive\", \"negative\", \"both\"", "\"none\""),
    ("alarm", "true where the drive's alarm input is in use", "false"),
];

const LASER: [(&str, &str, &str); 8] = [
    ("channel", "laser channel, 0 or 1", "0"),
    ("mode", "\"duty\" (of a carrier), \"frequency\" (of pulses), \"analog\"", "\"duty\""),
    ("carrier_khz", "carrier of the duty mode, kHz", "10"),
    ("pulse_width_us", "pulse width of the frequency mode, µs", ""),
    ("s_max", "the S of full power", "1000"),
    ("power", "power at S = 0 and at S = s_max: % (duty), kHz (frequency), V (analog)", "[0, 100]"),
    ("on_delay_us", "the light begins so much later, µs", "0"),
    ("off_delay_us", "the light ends so much later, µs", "0"),
];

const PATH: [(&str, &str, &str); 2] = [
    ("junction_deviation", "by so much the machine may round a corner, mm: it decides the speed there", "0.02"),
    ("arc_tolerance", "curves that are no arcs become lines that are so near, mm", "0.002"),
];

const TOP: [(&str, &str, &str); 1] = [("family", "laser family: \"gus\" or \"lsr\"", "\"gus\"")];

const LINK: [(&str, &str, &str); 1] =
    [("board", "\"virtual\", \"tcp:HOST:PORT\", \"serial:PATH:BAUD\" or \"qemu\"", "\"virtual\"")];

const OUTPUTS: [(&str, &str, &str); 2] = [
    ("mist", "general output that M7 switches on and M9 off, 1 to 16; empty for none", ""),
    ("flood", "general output that M8 switches on and M9 off, 1 to 16; empty for none", ""),
];

/// What shows how strokes of drawings get a power: it says nothing until the marks of comments are
/// removed.
const LAYERS: &str = "\n# How strokes of drawings are marked; docs/drawings.md explains it.\n\
    # [[layers]]\n\
    # colour = \"#ff0000\"        # strokes of this colour; without it, all that no layer before takes\n\
    # power = 80                # in the unit of laser.power\n\
    # speed = 600               # mm/min\n\
    # passes = 1\n\
    # order = 0                 # layers of a lower number run first\n";

/// The questions of a machine with these axes, with their usual answers, in the order of the file.
pub fn questions(letters: &str, laser: bool) -> Vec<Question> {
    let mut all = Vec::new();
    let mut table = |name: &str, rows: &[(&str, &'static str, &str)]| {
        for (key, meaning, value) in rows {
            let key = if name.is_empty() { (*key).to_owned() } else { format!("{name}.{key}") };
            all.push(Question { key, meaning, value: (*value).to_owned() });
        }
    };
    table("", &TOP);
    table("link", &LINK);
    for (place, letter) in letters.chars().enumerate() {
        let number = (place + 1).to_string();
        let mut rows = AXIS;
        rows[0].2 = &number;
        if letter == 'Z' {
            (rows[1].2, rows[3].2, rows[4].2, rows[5].2) = ("400", "[-50, 50]", "1200", "200");
        }
        table(&format!("axes.{}", letter.to_ascii_lowercase()), &rows);
    }
    if laser {
        table("laser", &LASER);
    }
    table("path", &PATH);
    table("outputs", &OUTPUTS);
    all
}

/// How a key of the file is written.
pub(crate) fn written(key: &str) -> Option<String> {
    let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
    let rows: &[(&str, &str, &str)] = match table {
        "" => &TOP,
        "link" => &LINK,
        "laser" => &LASER,
        "path" => &PATH,
        "outputs" => &OUTPUTS,
        _ if table.starts_with("axes.") => &AXIS,
        _ if table.starts_with("lasers.") => &LASER,
        "lasers" => return Some("a laser has a table with its name, as [lasers.cut]".to_owned()),
        _ => return None,
    };
    let (_, meaning, usual) = rows.iter().find(|(known, ..)| *known == name)?;
    Some(match *usual {
        "" => format!("it is: {meaning}"),
        _ => format!("it is written as `{name} = {usual}`: {meaning}"),
    })
}

/// Whether a text is a value of TOML; an empty one leaves its key out.
///
/// # Errors
/// What is wrong with it.
pub fn is_value(text: &str) -> Result<(), String> {
    if text.trim().is_empty() {
        return Ok(());
    }
    let read: Result<toml::Table, _> = toml::from_str(&format!("value = {text}"));
    match read {
        Ok(table) if table.len() == 1 => Ok(()),
        Ok(_) => Err("it is one value".to_owned()),
        Err(error) => Err(error.message().replace('\n', " ")),
    }
}

/// The mode of the laser has been answered: the usual answers to what is asked after it are those
/// of this mode. `kept` are keys that have an answer already.
pub fn suit_laser(questions: &mut [Question], kept: &[String]) {
    let mode = questions.iter().find(|question| question.key == "laser.mode").map(|question| question.value.clone());
    let (carrier, width, power) = match mode.as_deref() {
        Some("\"frequency\"") => ("", "10", "[0, 20]"),
        Some("\"analog\"") => ("", "", "[0, 10]"),
        _ => ("10", "", "[0, 100]"),
    };
    for (key, usual) in [("carrier_khz", carrier), ("pulse_width_us", width), ("power", power)] {
        let named = |question: &&mut Question| question.key.strip_prefix("laser.") == Some(key);
        if let Some(question) = questions.iter_mut().find(named).filter(|question| !kept.contains(&question.key)) {
            question.value = usual.to_owned();
        }
    }
}

/// The text of a file with these answers, and what it says.
///
/// # Errors
/// The key whose answer is wrong comes first, then the reason.
pub fn write(questions: &[Question]) -> Result<(String, Machine), String> {
    let mut text = "# The machine, in mm. docs/machine.md explains every key.\n".to_owned();
    let mut table = "";
    for question in questions {
        let (of, key) = question.key.rsplit_once('.').unwrap_or(("", &question.key));
        if of != table {
            text += &format!("\n[{of}]\n");
            table = of;
        }
        let line = match question.value.trim() {
            "" => format!("# {key} ="),
            value => format!("{key} = {value}"),
        };
        text += &format!("{line:<28}# {}\n", question.meaning);
    }
    text += LAYERS;
    let machine = file::read_as(&text, None, |_, what| what.to_owned())?;
    Ok((text, machine))
}
