//! Files of a folder use each other one way, in folders of all levels.
use host_tests::module_graph::Modules;
use std::path::Path;

#[test]
fn no_folder_has_a_circle_of_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for (name, least_uses) in [("servo", 300), ("dispatcher", 200), ("protocol", 20), ("plant", 0)] {
        let modules = Modules::of_crate(&root.join(name).join("src"));
        assert_eq!(modules.circles(), [""; 0], "{name}");
        assert!(modules.uses() > least_uses, "{name}: {}", modules.uses());
    }
}

fn circles_of(files: &[(&str, &str)]) -> Vec<String> {
    let mut modules = Modules::default();
    for (module, text) in files {
        modules.add(module.split("::").map(str::to_string).collect(), text);
    }
    modules.circles()
}

#[test]
fn a_planted_circle_is_found_at_every_level() {
    // Two files of a folder below another folder, one of them through a name its folder hands on.
    let files = [
        ("a", "pub mod b;"),
        ("a::b", "mod x;\nmod y;\npub use y::{Other, Y as Renamed};"),
        ("a::b::x", "use super::Renamed;\npub struct X(Renamed);"),
        ("a::b::y", "pub struct Y;\nfn of(x: &super::x::X) {}"),
    ];
    assert_eq!(circles_of(&files), [r#"a::b: ["x", "y"]"#]);

    // Three folders in a circle, each by a file below it.
    let files = [
        ("a", "mod f;"),
        ("a::f", "use crate::b::{self, g::G};"),
        ("b", "mod g;"),
        ("b::g", "fn f() { crate::c::h() }"),
        ("c", "use super::a::f as first;"),
    ];
    assert_eq!(circles_of(&files), [r#": ["a", "b", "c"]"#]);
}

#[test]
fn a_folder_and_its_files_may_use_each_other() {
    let files = [
        ("a", "mod x;\nmod y;\npub struct A;\nuse x::X;"),
        ("a::x", "use super::A; // crate::a::y::Y in a comment\nconst TEXT: &str = \"super::y\";"),
        ("a::y", "use super::x::X;"),
    ];
    assert_eq!(circles_of(&files), [""; 0]);
}
