//! Programs as the public ones are, with threads and timers as people write them: they build with
//! `g++ -Icompat` alone, unchanged, and do in the virtual controller what they would at a machine.

mod toolchain;

use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use toolchain::{command, libraries, output_of, root, scratch, skip};

const FAST: (&str, &str) = ("BEAMTICK_LINK", "virtual:max");

/// Built with the one folder that a user names.
fn built(name: &str) -> Option<PathBuf> {
    let program = scratch().join(format!("public_{name}"));
    let built = Command::new("g++")
        .arg("-I")
        .arg(root().join("host/gts/compat"))
        .arg(root().join(format!("host/gts/tests/public/{name}.cpp")))
        .arg("-o")
        .arg(&program)
        .arg("-L")
        .arg(libraries())
        .arg("-lgts")
        .arg(format!("-Wl,-rpath,{}", libraries().display()))
        .output();
    let Ok(built) = built else {
        skip("there is no g++");
        return None;
    };
    assert!(built.status.success(), "{name}:\n{}", String::from_utf8_lossy(&built.stderr));
    Some(program)
}

/// What it prints.
fn printed(name: &str, variables: &[(&str, &str)]) -> Option<String> {
    let program = built(name)?;
    let all: Vec<(&str, &str)> = [FAST].into_iter().chain(variables.iter().copied()).collect();
    Some(output_of(&mut command(&program, &all)))
}

#[test]
fn a_point_to_point_move_and_a_thread_that_watches() {
    let Some(text) = printed("trap_thread", &[]) else { return };
    assert_eq!(text, "pos=50000 maxVel=50.0 code=42 samples=many\n");
}

#[test]
fn a_jog_until_a_key() {
    let Some(text) = printed("jog_monitor", &[("BEAMTICK_KEYS", "2000")]) else { return };
    assert!(text.starts_with("top=20.0 looks=") && text.ends_with(" waited=0 moved=1\n"), "{text}");
    // 2 s of looks every 50 ms, each of which lasts a servo tick.
    let looks: u32 = text.split_once("looks=").unwrap().1.split(' ').next().unwrap().parse().unwrap();
    assert!((36..=41).contains(&looks), "{text}");
}

#[test]
fn a_square_by_interpolation() {
    let Some(text) = printed("square", &[]) else { return };
    // 4 sides of some 200 ms and more at 100 pulse/ms, two arcs, ramps, and 200 ms of delay.
    let (head, ms) = text.trim_end().split_once(" in ").unwrap();
    assert_eq!(head, "segments=6 at 0,0");
    let ms: f64 = ms.strip_suffix(" ms").unwrap().parse().unwrap();
    assert!((1300.0..=1500.0).contains(&ms), "{text}");
}

#[test]
fn outputs_by_a_multimedia_timer() {
    let inputs = scratch().join("public_io.csv");
    std::fs::write(&inputs, "t_ms,input,level\n300,gpi1,0\n600,gpi1,1\n900,gpi1,0\n1200,gpi1,1\n").unwrap();
    let Some(text) = printed("io_timer", &[("BEAMTICK_INPUTS", inputs.to_str().unwrap())]) else { return };
    assert!(text.starts_with("ticks=20 after=0 mask=ff edges="), "{text}");
    assert!(text.ends_with("edges=4\n") || text.ends_with("edges=3\n"), "{text}");
}

#[test]
fn a_sine_streamed_by_a_producer() {
    let Some(text) = printed("pt_producer", &[]) else { return };
    // Knots at 1000 at most; PT's velocities swing about the sine's, and so the positions between
    // two knots do.
    assert!(
        text.starts_with("sent=600 high=100") && text.contains(" low=-100") && text.ends_with(" seconds=6.0\n"),
        "{text}"
    );
}

#[test]
fn two_marked_lines() {
    for family in ["gus", "lsr"] {
        let Some(text) = printed("laser_marking", &[("BEAMTICK_FAMILY", family)]) else { return };
        assert_eq!(text, "segments=4 top=60 on=0 lit=as long as the lines\n", "{family}");
    }
}

#[test]
fn a_home_search_by_hand() {
    let inputs = scratch().join("public_home.csv");
    std::fs::write(
        &inputs,
        "t_ms,input,level\n500,limit_negative1,1\n900,limit_negative1,0\n2000,home1,1\n2100,home1,0\n",
    )
    .unwrap();
    let Some(text) = printed("home_search", &[("BEAMTICK_INPUTS", inputs.to_str().unwrap())]) else { return };
    assert_eq!(text, "limit=1\nat capture=1\nzero=0\n");
}

#[test]
fn a_flying_cut() {
    let Some(text) = printed("follow_cut", &[]) else { return };
    assert!(text.starts_with("slave=40000 monotonic=1 samples=20"), "{text}");
}

#[test]
fn a_console_menu() {
    let Some(program) = built("menu") else { return };
    let mut child =
        command(&program, &[FAST]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let commands = b"on 1\nmove 1 1000 10\non 77\nmove 2 5 1\nfly\npos\nq\n";
    child.stdin.take().unwrap().write_all(commands).unwrap();
    let done = child.wait_with_output().unwrap();
    let text = String::from_utf8(done.stdout).unwrap();
    assert!(done.status.success(), "{text}");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "Beamtick");
    assert!(lines[1].starts_with("GT_AxisOn: 7 AxisOn: axis is 77"), "{text}");
    assert!(lines[2].starts_with("GT_Update: 1 "), "{text}");
    assert_eq!(lines[3..], ["? fly", "    1000       0       0       0"]);
}

#[test]
fn three_axes_and_their_workers() {
    let Some(text) = printed("pvt_workers", &[]) else { return };
    assert_eq!(text, "waited=0 sum=303 rtn=000 top=10000,10000,10000 seconds=3.0\n");
}

/// Sleeps of several threads overlap in the controller's time, and a thread whose time has come
/// goes on while another calls.
#[test]
fn sleeps_of_threads_overlap() {
    let text = r#"
#include <windows.h>
#include "gts.h"
static volatile LONG wakes;
static DWORD WINAPI sleeper(LPVOID times)
{
    for (LONG_PTR n = 0; n < (LONG_PTR)times; n++) {
        Sleep(10);
        InterlockedIncrement(&wakes);
    }
    return 0;
}
int main(void)
{
    HANDLE threads[3];
    double pos;
    GT_Open();
    for (int n = 0; n < 3; n++) threads[n] = CreateThread(NULL, 0, sleeper, (LPVOID)(LONG_PTR)100, 0, NULL);
    DWORD begin = GetTickCount();
    WaitForMultipleObjects(3, threads, TRUE, INFINITE);
    printf("%lu ms for %ld wakes\n", (GetTickCount() - begin + 5) / 10 * 10, wakes);
    // 400 reads of a tick each are 100 ms: another thread's ten sleeps of 10 ms, give or take the
    // last.
    wakes = 0;
    threads[0] = CreateThread(NULL, 0, sleeper, (LPVOID)(LONG_PTR)10, 0, NULL);
    Sleep(1);
    for (int n = 0; n < 420; n++) GT_GetPrfPos(1, &pos);
    printf("%s wakes\n", wakes >= 9 ? "all" : "few");
    WaitForSingleObject(threads[0], INFINITE);
    // A thread that is in a lock of its own is gone without after a while: nothing hangs.
    printf("%lu\n", WaitForSingleObject(CreateEvent(NULL, TRUE, FALSE, NULL), 50));
    GT_Close();
    return 0;
}
"#;
    let Some(program) = toolchain::build(toolchain::Language::Cpp, "overlap", text) else { return };
    let began = std::time::Instant::now();
    assert_eq!(output_of(&mut command(&program, &[FAST])), "1000 ms for 300 wakes\nall wakes\n258\n");
    assert!(began.elapsed().as_secs() < 20);
}
