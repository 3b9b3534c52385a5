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
        ("../python/beamtick/table.py", gts::python::table()),
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
