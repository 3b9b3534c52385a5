//! Wrong use of the library from C++: programs that check every return value and reason themselves.
//!
//! `wrong_use` and `wrong_state` run under valgrind and with the address sanitizer too, where these
//! are; `BEAMTICK_VALGRIND=1` and `BEAMTICK_ASAN=1` do so with the others.

mod toolchain;

use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use toolchain::{Language, build, build_file, command, root, skip};

const FAST: (&str, &str) = ("BEAMTICK_LINK", "virtual:max");
const PASSED: &str = "all checks passed\n";

fn program(name: &str, more: &[&str]) -> Option<PathBuf> {
    let source = root().join(format!("host/gts/tests/programs/{name}.cpp"));
    let suffix: String = more.concat().chars().filter(char::is_ascii_alphanumeric).collect();
    build_file(Language::Cpp, &format!("{name}{suffix}"), &source, &[more, &["-Wpedantic", "-pthread"]].concat())
}

/// Runs a program; with the tools that are asked for, too.
fn passes(name: &str, variables: &[(&str, &str)]) {
    let asked = |variable: &str| std::env::var_os(variable).is_some();
    let Some(built) = program(name, &[]) else { return };
    assert_eq!(toolchain::output(&built, variables), PASSED, "{name}");
    if asked("BEAMTICK_VALGRIND") {
        under_valgrind(&built, variables);
    }
    if asked("BEAMTICK_ASAN") {
        with_sanitizer(name, variables);
    }
}

/// Runs a program alone and with every tool that is here.
fn passes_with_tools(name: &str, variables: &[(&str, &str)]) {
    let Some(built) = program(name, &[]) else { return };
    assert_eq!(toolchain::output(&built, variables), PASSED, "{name}");
    under_valgrind(&built, variables);
    with_sanitizer(name, variables);
}

fn under_valgrind(built: &PathBuf, variables: &[(&str, &str)]) {
    if Command::new("valgrind").arg("--version").output().is_err() {
        return skip("there is no valgrind");
    }
    let mut valgrind = command(&PathBuf::from("valgrind"), variables);
    assert_eq!(toolchain::output_of(valgrind.args(["--error-exitcode=9", "-q"]).arg(built)), PASSED, "{built:?}");
}

fn with_sanitizer(name: &str, variables: &[(&str, &str)]) {
    const FLAGS: &str = "-fsanitize=address,undefined";
    // Some compilers come without the sanitizer's library.
    let probe = toolchain::scratch().join("sanitizer.cpp");
    std::fs::write(&probe, "int main() { return 0; }\n").unwrap();
    let linked = Command::new("c++").arg(FLAGS).arg(&probe).arg("-o").arg(probe.with_extension("out")).output();
    if !linked.is_ok_and(|linked| linked.status.success()) {
        return skip("the compiler has no address sanitizer");
    }
    let Some(built) = program(name, &[FLAGS]) else { return };
    // The controller's memory lives as long as the program, as a real board's does.
    let variables = [variables, &[("ASAN_OPTIONS", "detect_leaks=0")]].concat();
    assert_eq!(toolchain::output(&built, &variables), PASSED, "{name} with the address sanitizer");
}

#[test]
fn wrong_use_is_refused_with_a_reason() {
    passes_with_tools("wrong_use", &[FAST]);
}

#[test]
fn calls_in_the_wrong_state_are_refused_with_a_reason() {
    passes_with_tools("wrong_state", &[FAST]);
}

#[test]
fn why_motion_has_stopped_is_reported() {
    passes_with_tools("stop_reason", &[FAST]);
}

#[test]
fn batches_change_no_return_value() {
    passes("pt_stream", &[FAST]);
}

#[test]
fn batches_change_no_return_value_in_real_time() {
    // Slow enough that a busy machine keeps the stream filled: 64 segments last for 320 ms of the
    // wall clock.
    passes("pt_stream", &[("BEAMTICK_LINK", "virtual:2")]);
}

#[test]
fn threads_do_not_disturb_each_other() {
    passes("threads", &[FAST]);
}

#[test]
fn threads_do_not_disturb_each_other_in_real_time() {
    passes("threads", &[("BEAMTICK_LINK", "virtual:5")]);
}

#[test]
fn cards_are_controllers_of_their_own() {
    passes("cards", &[FAST, ("BEAMTICK_PROFILE_3", "r688c-024")]);
}

#[test]
fn a_wrong_variable_is_named() {
    let source = "#include \"gts.h\"\n#include <stdio.h>\nint main()\n{\n    char text[300];\n    short code = GT_Open();\n    \
                  GT_GetLastReason(text, 300);\n    printf(\"%d %s\", code, text);\n    return 0;\n}\n";
    let Some(built) = toolchain::build(Language::Cpp, "open", source) else { return };
    for (name, value, part) in [
        ("BEAMTICK_LINK", "virtual:fast", "BEAMTICK_LINK is `virtual:fast`"),
        ("BEAMTICK_LINK", "tcp:127.0.0.1:1", "cannot open"),
        ("BEAMTICK_PROFILE", "x", "BEAMTICK_PROFILE is `x`"),
        ("BEAMTICK_TRACE", "/nowhere/t.csv", "/nowhere/t.csv cannot be written"),
    ] {
        let text = toolchain::output(&built, &[(name, value)]);
        assert!(text.starts_with("-6 ") && text.contains(part), "{name}={value}: {text}");
    }
}

#[test]
fn a_link_that_dies_in_a_move_is_reported_by_every_call() {
    let Some(built) = program("dead_link", &[]) else { return };
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let served = virtual_board::serve(listener, None, virtual_board::Config::default()).unwrap();
    let link = format!("tcp:{}", served.address());
    let mut child =
        command(&built, &[("BEAMTICK_LINK", &link)]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    out.read_line(&mut line).unwrap();
    assert_eq!(line, "moving\n");
    drop(served);
    child.stdin.take().unwrap().write_all(b"\n").unwrap();
    let rest: Vec<String> = out.lines().map(Result::unwrap).collect();
    assert!(rest.iter().any(|line| line.starts_with("dead -")), "{rest:?}");
    assert_eq!(rest.last().map(String::as_str), Some(PASSED.trim_end()), "{rest:?}");
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_card_that_is_closed_or_left_open_at_the_end_leaves_no_light() {
    let Some(built) = program("left_lit", &[]) else { return };
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let served = virtual_board::serve(listener, None, virtual_board::Config::default()).unwrap();
    let link = format!("tcp:{}", served.address());
    // Each finds the controller dark and without a fault, and its on command works.
    for how in ["close", "exit", "leave", "read", "light", "read", "light", "read", "light", "close"] {
        let mut child = command(&built, &[("BEAMTICK_LINK", &link)]).arg(how).stdout(Stdio::piped()).spawn().unwrap();
        let status = child.wait().unwrap();
        // At once, not when the link is lost.
        let (levels, view) = {
            let mut board = served.board().lock().unwrap();
            (board.laser(0), board.laser_view(0))
        };
        let mut text = String::new();
        std::io::Read::read_to_string(&mut child.stdout.take().unwrap(), &mut text).unwrap();
        assert!(status.success() && text == PASSED, "{how}: {text}");
        assert!(!levels.switch && !view.light && view.fault == servo::laser::Cause::None, "{how}: {levels:?} {view:?}");
        assert!(view.on_time != Default::default(), "{how}: it was lit");
    }
}

/// A child of a process with an open controller: every call −7, its end is quiet, and the parent
/// goes on.
#[test]
fn a_forked_child_is_refused_and_disturbs_nothing() {
    let text = r#"
#include "gts.h"
#include <windows.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
static DWORD WINAPI busy(LPVOID stop)
{
    double pos;
    while (!*(volatile int *)stop) GT_GetPrfPos(1, &pos);
    return 0;
}
int main(void)
{
    int status = 0, stop = 0, n;
    char why[200];
    /* Before Open a child is a process like any other. */
    if (fork() == 0) return GT_Open(0, 1) || GT_AxisOn(1) || GT_Close() ? 1 : 0;
    wait(&status);
    printf("%d\n", status);
    if (GT_Open(0, 1)) return 2;
    HANDLE thread = CreateThread(NULL, 0, busy, &stop, 0, NULL);
    for (n = 0; n < 20; n++) {
        fflush(stdout);
        if (fork() == 0) {
            short codes[4] = {GT_AxisOn(1), GT_Open(0, 1), GT_Close(), GT_GetLastReason(why, 200)};
            Sleep(1);
            return codes[0] == -7 && codes[1] == -7 && codes[2] == -7 && codes[3] == 0 && strstr(why, "forked") ? 0 : 3;
        }
        wait(&status);
        if (status) printf("child %d: %x\n", n, status);
    }
    stop = 1;
    WaitForSingleObject(thread, INFINITE);
    printf("%d", GT_AxisOn(1));
    printf(" %d\n", GT_Close());
    return 0;
}
"#;
    let Some(built) = build(Language::Cpp, "forked", text) else { return };
    for link in ["virtual:max", "virtual"] {
        let done = command(&built, &[("BEAMTICK_LINK", link)]).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&done.stdout), "0\n0 0\n", "{link}: {done:?}");
        assert!(done.stderr.is_empty(), "{}", String::from_utf8_lossy(&done.stderr));
    }
}

/// A controller that was closed leaves nothing: 2.7 MB each, before.
#[cfg(target_os = "linux")]
#[test]
fn closing_frees_a_virtual_controller() {
    let text = r#"
#include "gts.h"
#include <stdio.h>
#include <unistd.h>
static long resident(void)
{
    long all = 0, used = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (!file || fscanf(file, "%ld %ld", &all, &used) != 2) return -1;
    fclose(file);
    return used * sysconf(_SC_PAGESIZE) / 1024;
}
int main(void)
{
    long before = 0;
    double pos;
    for (int n = 0; n < 60; n++) {
        if (GTN_Open(5, 1) || GTN_AxisOn(1, 1) || GTN_GetPrfPos(1, 1, &pos) || GTN_Close()) return 1;
        if (n == 9) before = resident();
    }
    printf("%ld kB more\n", resident() - before);
    return resident() - before > 4096;
}
"#;
    let Some(built) = build(Language::Cpp, "freed", text) else { return };
    for link in ["virtual:max", "virtual"] {
        let done = command(&built, &[("BEAMTICK_LINK", link)]).output().unwrap();
        assert!(done.status.success(), "{link}: {}", String::from_utf8_lossy(&done.stdout));
    }
}

/// BEAMTICK_LOG has every call with its arguments, result, reason and time, also of a program that
/// dies; BEAMTICK_PLOT a picture.
#[test]
fn calls_are_logged_and_what_moved_is_drawn() {
    let text = r#"
#include "gts.h"
#include <windows.h>
#include <unistd.h>
int main(int argc, char *argv[])
{
    double pos[2];
    TTrapPrm trap = {1, 1, 0, 0};
    (void)argv;
    GT_AxisOn(1);
    if (GT_Open(0, 1)) return 1;
    GT_AxisOn(2);
    GT_PrfTrap(2);
    GT_SetTrapPrm(2, &trap);
    GT_SetPos(2, 400);
    GT_SetVel(2, 9.5);
    GT_Update(2);
    Sleep(100);
    GT_GetPrfPos(1, pos, 2, NULL);
    GTN_AxisOn(7, 1);
    if (argc > 1) _exit(3);
    return GT_Close();
}
"#;
    let Some(built) = build(Language::C, "logged", text) else { return };
    let folder = toolchain::scratch().join("logged");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let at = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let (log, plot, trace) = (at("log.txt"), at("t.svg"), at("t.csv"));
    let variables = [FAST, ("BEAMTICK_LOG", &log), ("BEAMTICK_PLOT", &plot), ("BEAMTICK_TRACE", &trace)];
    assert!(command(&built, &variables).status().unwrap().success());
    let found = std::fs::read_to_string(&log).unwrap();
    let lines: Vec<(&str, &str)> = found.lines().map(|line| line.split_once(' ').unwrap()).collect();
    let calls: Vec<&str> = lines.iter().map(|(_, call)| *call).collect();
    let reason = "AxisOn: core is 7";
    assert_eq!(
        calls[..9],
        [
            "GT_Open(0, 1) = 0",
            "GT_AxisOn(2) = 0",
            "GT_PrfTrap(2) = 0",
            "GT_SetTrapPrm(2, &prm={1.0, 1.0, 0.0, 0}) = 0",
            "GT_SetPos(2, 400) = 0",
            "GT_SetVel(2, 9.5) = 0",
            "GT_Update(2) = 0",
            "GT_GetPrfPos(1, &value={0.0, 400.0}, 2, NULL) = 0",
            calls[8],
        ]
    );
    assert!(calls[8].starts_with("GTN_AxisOn(7, 1) = 7  ") && calls[8].contains(reason), "{found}");
    assert_eq!(calls[9..], ["GT_Close() = 0"]);
    let time = |place: usize| lines[place].0.parse::<f64>().unwrap();
    assert!((100.0..102.0).contains(&(time(7) - time(6))), "{found}");
    let picture = std::fs::read_to_string(&plot).unwrap();
    assert!(picture.contains("axis 2 position") && !picture.contains("axis 1 position"));
    // Cut off: what there is keeps another name.
    std::fs::remove_dir_all(&folder).unwrap();
    std::fs::create_dir_all(&folder).unwrap();
    assert_eq!(command(&built, &variables).arg("dies").status().unwrap().code(), Some(3));
    let cut = std::fs::read_to_string(at("log.txt.partial")).unwrap();
    assert!(cut.lines().last().unwrap().contains(reason), "{cut}");
    assert!(
        !folder.join("log.txt").exists() && !folder.join("t.csv").exists() && folder.join("t.csv.partial").exists()
    );
    // A picture that is none, and two outputs to one file.
    for (name, value, part) in
        [("BEAMTICK_PLOT", at("t.gif"), ".png, .svg or .html"), ("BEAMTICK_LOG", trace.clone(), "written already")]
    {
        let mut wrong: Vec<(&str, &str)> = variables[..1].to_vec();
        wrong.push(("BEAMTICK_TRACE", &trace));
        wrong.push((name, &value));
        let why = "#include \"gts.h\"\n#include <stdio.h>\nint main(void)\n{\n    char text[300] = \"\";\n    short code = GT_Open(0, 1);\n    \
                   GT_GetLastReason(text, 300);\n    printf(\"%d %s\\n\", code, text);\n    return 0;\n}\n";
        let Some(opens) = build(Language::C, "opens", why) else { return };
        let said = String::from_utf8(command(&opens, &wrong).output().unwrap().stdout).unwrap();
        assert!(said.starts_with("-6 ") && said.contains(part), "{said}");
    }
}
