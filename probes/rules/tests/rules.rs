//! Each program breaks one rule, and the compiler must say so in the words beside it.
#[test]
fn none_of_these_compiles() {
    let cases = trybuild::TestCases::new();
    cases.compile_fail("tests/must_not_compile/*.rs");
}

#[test]
fn the_same_with_admitted_values_compiles() {
    let cases = trybuild::TestCases::new();
    cases.pass("tests/admitted.rs");
}
