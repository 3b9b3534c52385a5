//! Text that nobody meant: junk, any line ends, chains of macros, long lines. Time and memory grow
//! with the input.
use job::{Action, Files, Job, Severity, compile};
use std::fmt::Write;
use std::time::{Duration, Instant};

struct NoFiles;

impl Files for NoFiles {
    fn text(&self, path: &str) -> Result<String, String> {
        Err(path.into())
    }
}

fn read(text: &str) -> Result<Job, usize> {
    compile(text, &NoFiles).map_err(|found| found.iter().filter(|one| one.severity == Severity::Error).count())
}

/// Calls with their lines.
fn lines(text: &str) -> Vec<u32> {
    let job = compile(text, &NoFiles).unwrap_or_else(|found| panic!("{found:#?}"));
    job.steps.iter().filter(|step| matches!(step.action, Action::Call(_))).map(|step| step.line).collect()
}

/// Much less than any square of these sizes takes, much more than a slow machine needs.
fn soon<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let began = Instant::now();
    let done = work();
    let took = began.elapsed();
    assert!(took < Duration::from_secs(8), "{what}: {took:?}");
    done
}

#[test]
fn any_line_end_ends_a_comment() {
    for end in ["\n", "\r\n", "\r"] {
        let text =
            ["GT_AxisOn(1); // one", "// two", "#define AXIS 3", "GT_AxisOn(AXIS);", "```c", "GT_AxisOn(2);", ""];
        assert_eq!(lines(&text.join(end)), [1, 4, 6], "{end:?}");
        // A definition over two lines.
        let text = ["#define AXIS \\", "2", "GT_AxisOn(AXIS);"].join(end);
        assert_eq!(lines(&text), [3], "{end:?}");
    }
}

#[test]
fn junk_is_one_mistake_and_is_read_soon() {
    let nothing = soon("a million NULs", || read(&"\0".repeat(1_000_000)).unwrap_err());
    assert_eq!(nothing, 1);
    let apart = soon("200,000 marks apart", || read(&"@ ".repeat(200_000)).unwrap_err());
    assert!((1..=40).contains(&apart), "{apart}");
    let quotes = soon("200,000 quotes", || read(&"\"\n".repeat(200_000)).unwrap_err());
    assert!((1..=40).contains(&quotes), "{quotes}");
    let wrong = soon("200,000 directives", || read(&"#if 1\n".repeat(200_000)).unwrap_err());
    assert!((1..=60).contains(&wrong), "{wrong}");
}

/// A short line may not ask for any amount of memory.
#[test]
fn arrays_are_bounded_together() {
    let arrays = |count: usize| (0..count).map(|n| format!("double x{n}[1000000];\n")).collect::<String>();
    assert!(read(&arrays(4)).is_ok());
    assert_eq!(soon("300 arrays", || read(&arrays(300)).unwrap_err()), 20);
    assert_eq!(read("TCrdData x[1000000];").unwrap_err(), 1);
}

#[test]
fn numbers_are_quoted_in_part() {
    let found = compile(&format!("GT_AxisOn({});", "9".repeat(1000)), &NoFiles).unwrap_err();
    let longest = found.iter().map(|one| one.message.chars().count()).max().unwrap();
    assert!(longest < 130, "{longest}");
}

#[test]
fn chains_of_macros_end() {
    let mut text = String::from("#define A0 1\n");
    for n in 1..30_000 {
        let _ = writeln!(text, "#define A{n} A{}", n - 1);
    }
    text += "GT_AxisOn(A29999);\n";
    assert_eq!(soon("30,000 in a chain", || lines(&text)), [30_001]);
    // Its end asked for as often: more work than the text is long, so it is refused.
    let again = text.clone() + &"GT_AxisOn(A29999);\n".repeat(30_000);
    let found = soon("30,000 chains", || compile(&again, &NoFiles).unwrap_err());
    assert!(found.iter().any(|one| one.message.contains("too long")), "{found:?}");
    // In a circle: the name stays a name.
    assert_eq!(read("#define A B\n#define B A\nGT_AxisOn(A);").unwrap_err(), 1);
    // Each twice as long as the one before.
    let mut text = String::from("#define A0 1 +\n");
    for n in 1..60 {
        let _ = writeln!(text, "#define A{n} A{} A{}", n - 1, n - 1);
    }
    assert!(soon("doubling", || read(&(text + "GT_SetVel(1, A59 1);")).unwrap_err()) >= 1);
}

#[test]
fn a_script_on_one_line_is_read_as_soon_as_on_many() {
    let one = "GT_AxisOn(1);".repeat(100_000);
    let job = soon("100,000 calls in a line", || read(&one).unwrap());
    assert_eq!(job.steps.len(), 100_000);
    let last = job.steps.last().unwrap();
    assert_eq!((last.line, last.column), (1, 99_999 * 13 + 1));
    let many = soon("100,000 lines", || read(&"GT_AxisOn(1);\n".repeat(100_000)).unwrap());
    assert_eq!(many.steps.last().unwrap().line, 100_000);
}

#[test]
fn warnings_are_as_quick() {
    let text = "// a comment\n\u{4e2d}\u{6587}\n".repeat(50_000);
    let job = soon("50,000 broken comments", || read(&text).unwrap());
    assert!(!job.warnings.is_empty());
    let text = "#pragma once\n".repeat(50_000);
    soon("50,000 pragmas", || read(&text).unwrap());
}
