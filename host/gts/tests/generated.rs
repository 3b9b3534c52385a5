//! The generated files are what the table says. `BEAMTICK_WRITE=1` writes them
//! (`cargo xtask c-api`).

use gts::header;
use gts::prototype::{Form, all};
use std::path::Path;

#[test]
fn headers_and_exports_are_those_of_the_table() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let write = std::env::var_os("BEAMTICK_WRITE").is_some();
    for (name, text) in [
        ("include/gts.h", header::gts()),
        ("include/gts_cards.h", header::cards()),
        ("src/exports.rs", header::exports()),
        ("include/gts32.h", header::gts32()),
        ("../python/beamtick/table.py", gts::python::table()),
        ("../gts32/gts.cs", gts::csharp::declarations()),
        ("../../docs/api.md", gts::page::api()),
    ] {
        let path = folder.join(name);
        if write {
            std::fs::write(&path, &text).unwrap();
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(found == text, "{name} is not what the table says; `cargo xtask c-api` writes it");
    }
}

#[test]
fn no_default_stands_before_a_parameter_without_one() {
    for form in Form::ALL {
        for prototype in all(form) {
            assert!(header::defaults_close(&prototype), "{}", prototype.symbol());
        }
    }
}

/// What the page says is not there is not, and what a header declares is on it.
#[test]
fn the_page_names_every_function_once() {
    let page = gts::page::api();
    for prototype in all(Form::Gt) {
        assert_eq!(
            page.matches(&format!("| `{}` | ", prototype.function.name)).count(),
            1,
            "{}",
            prototype.function.name
        );
    }
    for name in gts::page::missing() {
        assert!(gts::prototype::functions().all(|function| function.name != name), "{name} is there");
    }
}
