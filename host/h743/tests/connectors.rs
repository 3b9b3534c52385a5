//! The contacts of the Nucleo's connectors beside files that others have published: the tables of
//! docs/board-h743.md, the jumpers of docs/bring-up.md, and those of the program that judges them.
//!
//! In: pages and sources as text. Out: nothing. A label that is wrong on a page, or that the
//! bring-up program prints, fails here.
use std::collections::BTreeMap;

/// Arduino's core for the STM32, by ST: `digitalPin` and `analogInputPin` of the NUCLEO-H743ZI2.
/// That it carries the H753ZI's labels too is UM2407's word: one manual is of both.
const ARDUINO: &str = "stm32duino/Arduino_Core_STM32, variant_NUCLEO_H743ZI.cpp";
/// The same by Arduino, and by Zephyr, which has the Arduino contacts alone (and no `_C`).
const BOTH: &str = "that, and zephyrproject-rtos/zephyr, boards/st/nucleo_h743zi/arduino_r3_connector.dtsi";

/// A contact, its pin, and the source.
const CONTACTS: [(&str, &str, &str); 82] = [
    ("D0", "PB7", BOTH),
    ("D1", "PB6", BOTH),
    ("D2", "PG14", BOTH),
    ("D3", "PE13", BOTH),
    ("D4", "PE14", BOTH),
    ("D5", "PE11", BOTH),
    ("D6", "PE9", BOTH),
    ("D7", "PG12", BOTH),
    ("D8", "PF3", BOTH),
    ("D9", "PD15", BOTH),
    ("D10", "PD14", BOTH),
    ("D11", "PB5", BOTH),
    ("D12", "PA6", BOTH),
    ("D13", "PA5", BOTH),
    ("D14", "PB9", BOTH),
    ("D15", "PB8", BOTH),
    ("D16", "PC6", ARDUINO),
    ("D17", "PB15", ARDUINO),
    ("D18", "PB13", ARDUINO),
    ("D19", "PB12", ARDUINO),
    ("D20", "PA15", ARDUINO),
    ("D21", "PC7", ARDUINO),
    ("D22", "PB5", ARDUINO),
    ("D23", "PB3", ARDUINO),
    ("D24", "PA4", ARDUINO),
    ("D25", "PB4", ARDUINO),
    ("D26", "PG6", ARDUINO),
    ("D27", "PB2", ARDUINO),
    ("D28", "PD13", ARDUINO),
    ("D29", "PD12", ARDUINO),
    ("D30", "PD11", ARDUINO),
    ("D31", "PE2", ARDUINO),
    ("D32", "PA0", ARDUINO),
    ("D33", "PB0", ARDUINO),
    ("D34", "PE0", ARDUINO),
    ("D35", "PB11", ARDUINO),
    ("D36", "PB10", ARDUINO),
    ("D37", "PE15", ARDUINO),
    ("D38", "PE6", ARDUINO),
    ("D39", "PE12", ARDUINO),
    ("D40", "PE10", ARDUINO),
    ("D41", "PE7", ARDUINO),
    ("D42", "PE8", ARDUINO),
    ("D43", "PC8", ARDUINO),
    ("D44", "PC9", ARDUINO),
    ("D45", "PC10", ARDUINO),
    ("D46", "PC11", ARDUINO),
    ("D47", "PC12", ARDUINO),
    ("D48", "PD2", ARDUINO),
    ("D49", "PG2", ARDUINO),
    ("D50", "PG3", ARDUINO),
    ("D51", "PD7", ARDUINO),
    ("D52", "PD6", ARDUINO),
    ("D53", "PD5", ARDUINO),
    ("D54", "PD4", ARDUINO),
    ("D55", "PD3", ARDUINO),
    ("D56", "PE2", ARDUINO),
    ("D57", "PE4", ARDUINO),
    ("D58", "PE5", ARDUINO),
    ("D59", "PE6", ARDUINO),
    ("D60", "PE3", ARDUINO),
    ("D61", "PF8", ARDUINO),
    ("D62", "PF7", ARDUINO),
    ("D63", "PF9", ARDUINO),
    ("D64", "PG1", ARDUINO),
    ("D65", "PG0", ARDUINO),
    ("D66", "PD1", ARDUINO),
    ("D67", "PD0", ARDUINO),
    ("D68", "PF0", ARDUINO),
    ("D69", "PF1", ARDUINO),
    ("D70", "PF2", ARDUINO),
    ("D71", "PE9", ARDUINO),
    ("D72", "PB2", ARDUINO),
    ("A0", "PA3", BOTH),
    ("A1", "PC0", BOTH),
    ("A2", "PC3_C", BOTH),
    ("A3", "PB1", BOTH),
    ("A4", "PC2_C", BOTH),
    ("A5", "PF10", BOTH),
    ("A6", "PF4", ARDUINO),
    ("A7", "PF5", ARDUINO),
    ("A8", "PF6", ARDUINO),
];

/// Contacts by connector: positions of a pin list of the MB1137, the Nucleo-144 before this one
/// (H743ZI), whose Zio connectors have the contacts of the same numbers (UM1974, UM2407). Neither
/// Arduino's file nor Zephyr's has connectors.
const ZIO: &str = "casten/Nucleo-144-gpio, Nucleo-144-gpio.md";
/// That list leaves two positions of CN9 without a pin. What says that they are D71 and D72 is
/// UM2407 alone, and no page of ours names their connector.
const MANUAL: &str = "UM2407";

/// A connector, contacts of it, and the source.
const CONNECTORS: [(&str, &str, &str); 5] = [
    ("CN7", "D8–D25", ZIO),
    ("CN8", "D43–D50", ZIO),
    ("CN9", "D51–D70, A0–A5", ZIO),
    ("CN9", "D71, D72", MANUAL),
    ("CN10", "D0–D7, D26–D42, A6–A8", ZIO),
];

/// Pins of CN11 and CN12 that pages name, as [`ZIO`] has them: connector, its pin, the chip's pin.
/// BOOT0 and VDD are no pins that an image uses.
const MORPHO: [(&str, u32, &str); 14] = [
    ("CN11", 5, "VDD"),
    ("CN11", 7, "BOOT0"),
    ("CN11", 63, "PG9"),
    ("CN11", 64, "PG15"),
    ("CN11", 66, "PG10"),
    ("CN12", 28, "PB14"),
    ("CN12", 50, "PF14"),
    ("CN12", 57, "PF13"),
    ("CN12", 59, "PF12"),
    ("CN12", 60, "PF15"),
    ("CN12", 62, "PF11"),
    ("CN12", 66, "PG8"),
    ("CN12", 68, "PG5"),
    ("CN12", 69, "PG4"),
];

const PAGE: &str = include_str!("../../../docs/board-h743.md");
const BRING_UP: &str = include_str!("../../../docs/bring-up.md");
/// The program's labels: `JUMPERS` there.
const LABELS: &str = include_str!("../../beamtick/src/bring_up/rows/captures.rs");
/// The pins that the emulated board's jumpers join, with which the bring-up image finds all nine:
/// `JUMPERS` there.
const PINS: &str = include_str!("bring_up.rs");

fn pin_of(contact: &str) -> &'static str {
    let found = CONTACTS.iter().find(|(name, ..)| *name == contact);
    found.unwrap_or_else(|| panic!("no source knows a contact {contact}")).1
}

/// The connector of a contact, by the list.
fn connector_of(contact: &str) -> &'static str {
    let found: Vec<&str> = CONNECTORS
        .iter()
        .filter(|(_, contacts, source)| *source == ZIO && listed(contacts, is_contact).iter().any(|one| one == contact))
        .map(|(connector, ..)| *connector)
        .collect();
    assert_eq!(found.len(), 1, "{contact} at {found:?}");
    found[0]
}

/// Runs of letters, digits and `_`.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

fn is_contact(word: &str) -> bool {
    let rest = word.strip_prefix(['A', 'D']);
    rest.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

fn is_pin(word: &str) -> bool {
    let number = word.get(2..).map(|rest| rest.trim_end_matches("_C"));
    word.starts_with('P') && number.is_some_and(|number| number.parse::<u8>().is_ok_and(|number| number < 16))
}

/// The cells of the rows of a page's tables from a line on, up to the next chapter.
fn rows<'a>(page: &'a str, from: &str) -> Vec<Vec<&'a str>> {
    let lines = page.lines().skip_while(|line| *line != from).skip(1).take_while(|line| !line.starts_with("## "));
    let cells = |line: &'a str| {
        line.strip_prefix("| ").map(|row| row.trim_end_matches('|').split('|').map(str::trim).collect())
    };
    lines.filter_map(cells).collect()
}

/// `PF0–PF7` and `D68–D70` in full.
fn spread(first: &str, last: &str) -> Vec<String> {
    let digits = first.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let letters = &first[..first.len() - digits.len()];
    let number = |word: &str| word.trim_start_matches(letters).parse::<u32>().unwrap();
    (number(first)..=number(last)).map(|number| format!("{letters}{number}")).collect()
}

/// The pins or contacts of a text, ranges in full.
fn listed(text: &str, is_one: fn(&str) -> bool) -> Vec<String> {
    let mut all = Vec::new();
    for part in text.split([',', ' ', '/', ';', ':']) {
        match part.split_once('–') {
            Some((first, last)) if is_one(first) && is_one(last) => all.extend(spread(first, last)),
            _ if is_one(part) => all.push(part.to_owned()),
            _ => {}
        }
    }
    all
}

/// Pins and the contacts in parentheses after them.
fn labelled(cell: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut rest = cell;
    while let Some((before, after)) = rest.split_once('(') {
        let (inside, after) = after.split_once(')').unwrap();
        rest = after;
        let inner: Vec<&str> = words(inside).filter(|word| is_pin(word) || is_contact(word)).collect();
        if inner.iter().any(|word| is_pin(word)) {
            // Each contact after its pin.
            let pairs = inner.windows(2).filter(|pair| is_pin(pair[0]) && is_contact(pair[1]));
            found.extend(pairs.map(|pair| (pair[0].to_owned(), pair[1].to_owned())));
            continue;
        }
        let pins = listed(before.rsplit(['/', ';', ':', ')']).next().unwrap(), is_pin);
        if !inner.is_empty() {
            assert_eq!(pins.len(), inner.len(), "{before}({inside})");
            found.extend(pins.into_iter().zip(inner.into_iter().map(str::to_owned)));
        }
    }
    found
}

/// The pins of each signal by the table of pins, in the words of the tables of connectors.
fn signals() -> BTreeMap<String, Vec<String>> {
    let mut all = BTreeMap::new();
    for row in rows(PAGE, "## Pins") {
        let [what, pins, _] = row[..] else { continue };
        let pins = listed(&pins.replace(['(', ')'], " "), is_pin);
        let short = ["direction", "step", "limit +", "limit −", "home", "alarm"];
        if let Some(name) = short.into_iter().find(|name| what.starts_with(&format!("{name}, axes"))) {
            all.extend(pins.into_iter().zip(1..).map(|(pin, n)| (format!("{name} {n}"), vec![pin])));
        } else if what.starts_with("servo enable") {
            all.extend(pins.into_iter().zip(1..).map(|(pin, n)| (format!("enable {n}"), vec![pin])));
        } else if let Some(rest) = what.strip_prefix("general ") {
            let name = rest.split_once("s 1").unwrap().0;
            all.extend(pins.into_iter().zip(1..).map(|(pin, n)| (format!("{name} {n}"), vec![pin])));
        } else if what.starts_with("analog inputs") {
            all.extend(pins.into_iter().zip(1..).map(|(pin, n)| (format!("analog input {n}"), vec![pin])));
        } else if what.starts_with("laser 0, 1, analog") {
            all.extend(pins.into_iter().zip(0..).map(|(pin, n)| (format!("laser {n} analog"), vec![pin])));
        } else if let Some(laser) = what.strip_suffix(" + / −") {
            let name = laser.replace(',', "");
            all.extend(pins.into_iter().zip(["+", "−"]).map(|(pin, sign)| (format!("{name} {sign}"), vec![pin])));
        } else if what == "interlock" {
            all.insert("interlock".to_owned(), pins);
        } else if what == "encoder A, B" {
            let names = ["encoder 1 A", "encoder 1 B", "encoder 2 A", "encoder 2 B"];
            all.extend(pins.into_iter().zip(names).map(|(pin, name)| (name.to_owned(), vec![pin])));
        } else if what == "encoder index" {
            all.extend(pins.into_iter().zip(1..).map(|(pin, n)| (format!("encoder {n} index"), vec![pin])));
        } else if what == "external DAC" {
            let names = ["DAC SCK", "DAC MOSI", "DAC select"];
            all.extend(pins.into_iter().zip(names).map(|(pin, name)| (name.to_owned(), vec![pin])));
        }
    }
    all
}

#[test]
fn both_sources_are_named_where_both_have_the_contact() {
    let is_of_arduino = |name: &str| {
        let (kind, number) = name.split_at(1);
        number.parse::<u32>().unwrap() <= if kind == "A" { 5 } else { 15 }
    };
    for (name, _, source) in CONTACTS {
        assert_eq!(source, if is_of_arduino(name) { BOTH } else { ARDUINO }, "{name}");
    }
}

#[test]
fn the_table_of_pins_has_the_contacts_of_the_published_files() {
    let mut compared = 0;
    for row in rows(PAGE, "## Pins") {
        for (pin, contact) in row.iter().take(2).flat_map(|cell| labelled(cell)) {
            assert_eq!(pin_of(&contact), pin, "{contact} in the row of {}", row[0]);
            compared += 1;
        }
    }
    println!("{compared} labels");
    assert!(compared >= 43, "{compared} labels");
}

#[test]
fn the_tables_of_connectors_have_the_contacts_of_the_published_files() {
    let signals = signals();
    let mut compared = 0;
    for row in rows(PAGE, "## Pins") {
        let pairs: Vec<&[&str]> = row.chunks(2).filter(|pair| pair.len() == 2 && !pair[0].is_empty()).collect();
        for pair in pairs {
            let contacts = listed(pair[0], is_contact);
            if contacts.is_empty() || words(pair[0]).any(|word| !is_contact(word)) {
                continue;
            }
            // A contact's pin itself, or a signal, or as many numbers of it as contacts.
            let words_of: Vec<&str> = words(pair[1]).collect();
            if is_pin(words_of[0]) {
                assert_eq!(pin_of(&contacts[0]), words_of[0], "{}", contacts[0]);
                compared += 1;
                continue;
            }
            let names: Vec<String> = match pair[1].split_once(',') {
                Some((first, others)) => {
                    let name = first.trim_end_matches(|c: char| c.is_ascii_digit());
                    let numbers = others.split(',').map(|number| format!("{name}{}", number.trim()));
                    std::iter::once(first.to_owned()).chain(numbers).collect()
                }
                None => vec![pair[1].to_owned()],
            };
            assert_eq!(names.len(), contacts.len(), "{}: {}", pair[0], pair[1]);
            for (contact, name) in contacts.iter().zip(names) {
                let pins = signals.get(&name).unwrap_or_else(|| panic!("{contact}: no pin of {name}"));
                let pin = pin_of(contact);
                assert!(pins.iter().any(|of| of == pin), "{contact} is {pin}, and {name} {pins:?}");
                compared += 1;
            }
        }
    }
    println!("{compared} contacts");
    assert!(compared >= 75, "{compared} contacts");
}

#[test]
fn every_contact_has_one_connector() {
    let mut all: Vec<String> = CONNECTORS.iter().flat_map(|(_, contacts, _)| listed(contacts, is_contact)).collect();
    all.sort();
    let mut contacts: Vec<&str> = CONTACTS.iter().map(|(name, ..)| *name).collect();
    contacts.sort();
    assert_eq!(all, contacts);
}

/// Pins of CN11 and CN12 are those of the list. Each signal without a contact elsewhere is there.
#[test]
fn pins_of_the_outer_connectors_are_those_of_the_published_list() {
    let signals = signals();
    let mut named = Vec::new();
    for row in rows(PAGE, "## Pins") {
        for pair in row.chunks(2).filter(|pair| pair[0].contains(" pin ")) {
            let (connector, number) = pair[0].split_once(" pin ").unwrap();
            let found = MORPHO.iter().find(|(of, pin, _)| *of == connector && pin.to_string() == number);
            let (.., pin) = found.unwrap_or_else(|| panic!("no source knows {}", pair[0]));
            assert_eq!(signals[pair[1]], [*pin], "{}", pair[0]);
            named.push(*pin);
        }
    }
    let inner = |pin: &str| CONTACTS.iter().any(|(_, of, _)| *of == pin);
    let outer = signals.values().flatten().map(String::as_str).filter(|pin| pin.starts_with(['P']) && !inner(pin));
    // The LEDs' outputs are on the board.
    let mut should: Vec<&str> = outer.filter(|pin| !["PE1", "PB14", "PC13"].contains(pin)).collect();
    named.sort_unstable();
    should.sort_unstable();
    assert_eq!(named, should);
    // In words: the bridge of the bootloader, and the pin to measure.
    assert!(PAGE.contains("BOOT0 to VDD (CN11 pins 7 and 5,"));
    assert!(PAGE.contains("output 2 (LED LD3) must be at pin 28 of CN12"));
    assert_eq!(signals["output 2"], ["PB14"]);
}

/// The connectors' tables, and `D6, CN10` in those of jumpers and of what is free.
#[test]
fn contacts_lie_at_the_connectors_that_the_pages_name() {
    let mut compared = 0;
    let mut section = "";
    for line in PAGE.lines() {
        match line.strip_prefix("**").and_then(|rest| rest.strip_suffix("**")) {
            Some(name) if name.starts_with("CN") => section = name,
            _ if line.starts_with('#') => section = "",
            _ => {}
        }
        let cells: Vec<&str> = line.strip_prefix("| ").unwrap_or_default().split('|').map(str::trim).collect();
        for pair in cells.chunks(2).filter(|_| !section.is_empty()) {
            if pair[0].split([',', '–', ' ']).all(is_contact_or_empty) {
                for contact in listed(pair[0], is_contact) {
                    assert_eq!(connector_of(&contact), section, "{contact}");
                    compared += 1;
                }
            }
        }
    }
    println!("{compared} contacts of tables");
    assert!(compared >= 75, "{compared} contacts");
    let mut named = 0;
    for row in rows(BRING_UP, "## Jumpers") {
        for cell in row {
            let words: Vec<&str> = words(cell).collect();
            for pair in words.windows(2).filter(|pair| is_contact(pair[0]) && pair[1].starts_with("CN")) {
                assert_eq!(connector_of(pair[0]), pair[1], "{}", pair[0]);
                named += 1;
            }
        }
    }
    assert_eq!(named, 29, "contacts of jumpers");
}

fn is_contact_or_empty(word: &str) -> bool {
    word.is_empty() || is_contact(word)
}

/// The strings of a source's array `JUMPERS`.
fn strings(source: &'static str) -> Vec<&'static str> {
    let (_, array) = source.split_once("const JUMPERS:").unwrap();
    let (array, _) = array.split_once("];").unwrap_or((array, ""));
    let (_, array) = array.split_once('=').unwrap();
    let array = array.split_once("];").map_or(array, |(array, _)| array);
    array.split('"').skip(1).step_by(2).collect()
}

/// Where a jumper begins, and its ends.
type Jumper = (String, Vec<String>);

/// The jumpers of the page.
fn jumpers() -> Vec<Jumper> {
    let of = |row: Vec<&str>| {
        let from = words(row[1]).find(|word| is_contact(word))?.to_owned();
        let ends = words(row[2]).filter(|word| is_contact(word) || *word == "GND").map(str::to_owned);
        row[0].parse::<u32>().ok().map(|_| (from, ends.collect()))
    };
    rows(BRING_UP, "## Jumpers").into_iter().filter(|row| row.len() == 4).filter_map(of).collect()
}

#[test]
fn the_bring_up_program_names_the_jumpers_of_its_page() {
    let named: Vec<Jumper> = strings(LABELS)
        .into_iter()
        .map(|label| {
            let (from, ends) = label.split_once('–').unwrap();
            (from.to_owned(), words(ends).map(str::to_owned).collect())
        })
        .collect();
    assert_eq!(named.len(), 12);
    assert_eq!(named, jumpers());
}

#[test]
fn jumpers_join_the_pins_that_the_bring_up_image_measures() {
    let joined: Vec<(&str, &str)> = strings(PINS).chunks(2).map(|pair| (pair[0], pair[1])).collect();
    let jumpers = jumpers();
    let is_digital = |contact: &str| is_contact(contact) && !pin_of(contact).ends_with("_C");
    let named: Vec<(&str, &str)> = jumpers
        .iter()
        .flat_map(|(from, ends)| ends.iter().map(move |end| (from, end)))
        .filter(|(_, end)| is_digital(end))
        .map(|(from, end)| (pin_of(from), pin_of(end)))
        .collect();
    assert_eq!(named, joined);
    // Those of the converters: laser 0 to input 1, laser 1 to input 2.
    let signals = signals();
    for (jumper, laser, input) in [(6, "laser 0 analog", "analog input 1"), (7, "laser 1 analog", "analog input 2")] {
        let (from, ends) = &jumpers[jumper];
        assert_eq!([pin_of(from), pin_of(&ends[0])], [signals[laser][0].as_str(), signals[input][0].as_str()]);
    }
    // The detector's input (data sheet, pin table: PVD_IN).
    assert_eq!((pin_of(&jumpers[8].0), &jumpers[8].1[..]), ("PB7", &["GND".to_owned()][..]));
}
