//! Values of declarations: lists in lists are laid out as in C, against values that a C compiler
//! gave.
use job::{Action, Files, Severity, compile};
use protocol::command::SetVel;
use zerocopy::FromBytes;

struct NoFiles;

impl Files for NoFiles {
    fn text(&self, path: &str) -> Result<String, String> {
        Err(path.into())
    }
}

/// The first error: line, column, message.
fn bad(text: &str) -> (u32, u32, String) {
    let found = compile(text, &NoFiles).expect_err(text);
    let first = found.iter().find(|found| found.severity == Severity::Error).expect("an error");
    (first.line, first.column, first.message.clone())
}

/// What a declaration gives each place of `x`, by the arguments of a call.
fn given(declaration: &str, places: &[&str]) -> Vec<f64> {
    let value = |place: &&str| {
        let job = compile(&format!("{declaration} GT_SetVel(1, x{place});"), &NoFiles).unwrap();
        let Action::Call(call) = &job.steps[0].action else { panic!("{:?}", job.steps[0]) };
        SetVel::read_from_bytes(&call.body).unwrap().vel.get()
    };
    places.iter().map(value).collect()
}

#[test]
fn lists_in_lists_are_laid_out_as_in_c() {
    let crd = [".dimension", ".profile[0]", ".profile[1]", ".profile[2]", ".synVelMax", ".synAccMax", ".originPos[0]"];
    // Braces stand for the field of their place; what they leave out is 0.
    let nested = given("TCrdPrm x = {2, {1, 2}, 100, 0.5, 0, 0, {7}};", &crd);
    assert_eq!(nested, [2.0, 1.0, 2.0, 0.0, 100.0, 0.5, 7.0]);
    // Without braces the values fill the field one by one.
    let flat = given("TCrdPrm x = {2, 1, 2, 3, 4, 5, 6, 7, 8, 100, 0.5};", &crd);
    assert_eq!(flat, [2.0, 1.0, 2.0, 3.0, 100.0, 0.5, 0.0]);
    let all = given("TCrdPrm x = {{2}, {1, 2, 3, 4, 5, 6, 7, 8}, {100}, 0.5, 0, 0, 9};", &crd);
    assert_eq!(all, [2.0, 1.0, 2.0, 3.0, 100.0, 0.5, 9.0]);
    let jogs = ["[0].acc", "[0].dec", "[0].smooth", "[1].acc", "[1].dec", "[2].acc"];
    assert_eq!(given("TJogPrm x[3] = {{1}, {2, 3}, 4};", &jogs), [1.0, 0.0, 0.0, 2.0, 3.0, 4.0]);
    assert_eq!(given("TJogPrm x[3] = {1, 2, 0.5, {3, 4}, 5};", &jogs), [1.0, 2.0, 0.5, 3.0, 4.0, 5.0]);
    // Three elements, the last of which is given in part.
    assert_eq!(given("TJogPrm x[] = {{1}, 2, 3, 0.5, 4};", &jogs), [1.0, 0.0, 0.0, 2.0, 3.0, 4.0]);
    assert!(bad("TJogPrm x[] = {{1}, 2, 3, 0.5, 4}; x[3].acc = 1;").2.contains("elements 0 to 2"));
    assert_eq!(given("double x[] = {1, {2}, 3,};", &["[0]", "[1]", "[2]"]), [1.0, 2.0, 3.0]);
    // The 8 places of a profile are full after 8.
    let many = bad("TCrdPrm x = {2, {1, 2, 3, 4, 1, 2, 3, 4, 1}};");
    assert_eq!((many.1, many.2.as_str()), (17, "this list has 9 values; it stands for 8"));
    assert_eq!(bad("double x[3] = {1, {2, 3}};").2, "this list has 2 values; it stands for 1");
    assert_eq!(bad("TJogPrm x = {1, 2, {3, 4}};").2, "4 values are given, `x` holds 3");
    assert_eq!(bad("TJogPrm x[2] = {1, {2, 3}};").2, "this list has 2 values; it stands for 1");
    assert!(bad("short x = {40000};").2.starts_with("40000 does not fit a short"));
}
