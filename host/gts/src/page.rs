//! `docs/api.md` as a text: every function that is known of the API, and what it does here.

use crate::about::about;
use crate::more::{Class, MORE, More, NOT_THERE};
use job::api::FUNCTIONS;
use std::fmt::Write;

/// How a function beyond the manuals behaves, and what is said of it.
fn state(more: &More) -> (&'static str, String) {
    match more.class {
        Class::Real | Class::Timed | Class::Homes(_) => ("works", more.about.to_owned()),
        Class::Keeps { .. } => ("kept", more.about.trim_start_matches("Kept: ").to_owned()),
        Class::Recalls { .. } => ("kept", more.about.to_owned()),
        Class::IsSo(_, why) => ("works", format!("Nothing to do: {why}.")),
        Class::OnlyZero(why) => ("works", format!("0 is done. Else 1: {why}.")),
        Class::Refused(why) => ("refused", format!("1: {why}.")),
    }
}

/// The names of a list in [`NOT_THERE`].
pub fn missing() -> impl Iterator<Item = &'static str> {
    NOT_THERE.iter().flat_map(|(names, _)| names.split(", "))
}

/// The text of the page.
pub fn api() -> String {
    let mut rows: Vec<(&str, &str, String)> =
        FUNCTIONS.iter().map(|function| (function.name, "works", about(function.name).to_owned())).collect();
    rows.extend(MORE.iter().map(|more| {
        let (state, text) = state(more);
        (more.function.name, state, text)
    }));
    rows.sort_by_key(|(name, ..)| name.to_lowercase());
    let count = |wanted: &str| rows.iter().filter(|(_, state, _)| *state == wanted).count();
    let mut out = String::from(
        "# Every function of the API\n\nFor whoever has a program and asks whether it runs. `cargo xtask c-api` writes this page from the tables of\n\
         functions; a test compares the two.\n\n| a function that | is | how many |\n| --- | --- | --- |\n",
    );
    for (state, text) in [
        ("works", "does what its manual says, in the controller or in its time"),
        ("kept", "is accepted, range-checked and read back, and changes nothing: no loop is closed here"),
        ("refused", "returns 1, with a reason that names what is missing"),
    ] {
        let _ = writeln!(out, "| {text} | {state} | {} |", count(state));
    }
    let _ = writeln!(out, "| is known, and not in the library | not there | {} |", missing().count());
    out += "\nEach name is there three times: `GT_x(…)`, `GTN_x(core, …)` and, in `gts_cards.h`, `GT_x(cardNum, …)`. \
            [The C page](c.md)\nsays how to build. Prototypes are in `host/gts/include`. What is kept falls back with a Reset and with Close.\n\n\
            | function | is | what it does |\n| --- | --- | --- |\n";
    for (name, state, text) in &rows {
        let _ = writeln!(out, "| `{name}` | {state} | {text} |");
    }
    out += "\n## Not there\n\nA program that calls one of these does not link.\n\n| functions | what they are for |\n| --- | --- |\n";
    for (names, text) in NOT_THERE {
        let names: Vec<String> = names.split(", ").map(|name| format!("`{name}`")).collect();
        let _ = writeln!(out, "| {} | {text} |", names.join(", "));
    }
    out
}
