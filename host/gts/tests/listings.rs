//! The manuals' own listings, taken out of their text where that is at hand, compile and run with
//! the corrections of `corrections.txt`, and do what the manual says: asserted on the trace.
//!
//! The manuals are looked for in `../shared/manuals` beside the checkout; `BEAMTICK_MANUALS`
//! overrides.

mod csv;
mod toolchain;

use csv::Trace;
use std::path::PathBuf;
use toolchain::{command, output_of, root, scratch, skip};

/// A manual, where its text is at hand.
fn manual(number: &str) -> Option<String> {
    let folder = std::env::var_os("BEAMTICK_MANUALS").map_or_else(|| root().join("../shared/manuals"), PathBuf::from);
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let found =
        files.filter(|file| file.file_name().to_string_lossy().starts_with(number)).map(|file| file.path()).next();
    if found.is_none() {
        skip("the manuals are not here (set BEAMTICK_MANUALS to their folder)");
    }
    Some(String::from_utf8_lossy(&std::fs::read(found?).unwrap()).into_owned())
}

/// What stands between two texts.
fn between<'m>(manual: &'m str, from: &str, to: &str) -> &'m str {
    let start = manual.find(from).unwrap_or_else(|| panic!("no `{from}`")) + from.len();
    let rest = &manual[start..];
    &rest[..rest.find(to).unwrap_or_else(|| panic!("no `{to}` behind `{from}`"))]
}

/// The fenced code of a part, one block after the other.
fn fenced(part: &str) -> String {
    part.split("```").skip(1).step_by(2).collect()
}

/// Applies the corrections of a section; each must be needed.
fn corrected(section: &str, text: &str) -> String {
    let all = include_str!("corrections.txt");
    let heading = format!("\n[{section}]\n");
    let Some(start) = all.find(&heading) else { return text.to_owned() };
    let mut text = text.to_owned();
    for line in all[start + heading.len()..].lines().take_while(|line| !line.starts_with('[')) {
        if line.starts_with("# ") || line.is_empty() {
            continue;
        }
        let (from, to) = line.split_once(" => ").unwrap_or_else(|| panic!("{section}: {line}"));
        let (from, to) = (from.replace("\\n", "\n"), to.replace("\\n", "\n"));
        assert!(text.contains(&from), "{section}: `{from}` is not in the listing");
        text = text.replace(&from, &to);
    }
    text
}

/// Compiles a listing with all warnings; none may be about our headers. Runs it; its trace.
fn run(name: &str, text: &str, variables: &[(&str, &str)]) -> Option<Trace> {
    let source = scratch().join(format!("listing_{name}.cpp"));
    std::fs::write(&source, text).unwrap();
    let program = scratch().join(format!("listing_{name}"));
    let host = root().join("host/gts");
    let libraries = toolchain::libraries();
    let mut compiler = std::process::Command::new("c++");
    compiler
        .args(["-Wall", "-Wextra", "-Wpedantic", "-I"])
        .arg(host.join("include"))
        .arg("-I")
        .arg(host.join("compat"));
    compiler.arg(&source).arg("-o").arg(&program).arg("-L").arg(&libraries).arg("-lgts");
    compiler.arg(format!("-Wl,-rpath,{}", libraries.display()));
    let Ok(built) = compiler.output() else {
        skip("there is no C++ compiler");
        return None;
    };
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "{name}:\n{said}");
    for header in ["gts.h", "stdafx.h", "conio.h", "windows.h"] {
        let about = format!("{header}:");
        assert!(!said.lines().any(|line| line.contains(&about) && line.contains("warning")), "{name}:\n{said}");
    }
    let trace = scratch().join(format!("listing_{name}.csv"));
    let trace_name = trace.to_string_lossy().into_owned();
    let mut all = vec![("BEAMTICK_LINK", "virtual:max"), ("BEAMTICK_TRACE", trace_name.as_str())];
    all.extend(variables);
    output_of(&mut command(&program, &all));
    Some(Trace::read(&trace))
}

/// A listing of the GXN manual.
fn gxn(name: &str, to: &str, variables: &[(&str, &str)]) -> Option<Trace> {
    let manual = manual("001")?;
    let part = between(&manual, &format!("\n例程 {name} "), to);
    run(name, &corrected(name, &fenced(part)), variables)
}

fn near(found: f64, wanted: f64, within: f64, what: &str) {
    assert!((found - wanted).abs() <= within, "{what}: {found}, wanted {wanted}");
}

#[test]
fn listing_2_1() {
    let Some(trace) = gxn("2-1", "\n2. PT 动态 FIFO", &[]) else { return };
    let start = trace.start("axis1");
    for (t, pos) in [(1024.0, 1024.0), (2048.0, 3072.0), (3072.0, 4096.0)] {
        near(trace.at(start + t, "axis1_pos"), pos, 1e-6, "position");
    }
}

#[test]
fn listing_2_2() {
    let Some(trace) = gxn("2-2", "\n第3章 Follow", &[]) else { return };
    let start = trace.start("axis1");
    let most = trace.column("axis1_vel").iter().copied().fold(0.0, f64::max);
    assert!(most > 0.0 && trace.last("axis1_pos") == 0.0 && trace.last("axis1_vel") == 0.0);
    near(trace.at(start + 250.0, "axis1_vel"), most, most * 0.01, "the crest of the first period");
    near(trace.at(start + 1250.0, "axis1_vel"), most, most * 0.01, "of the second");
    near(trace.at(start + 2000.0, "axis1_pos"), 0.0, 1e-6, "the end");
}

#[test]
fn listing_3_2() {
    let Some(trace) = gxn("3-2", "\n3. Follow 双", &[("BEAMTICK_KEYS", "3600")]) else { return };
    let (master, slave) = (trace.column("axis1_pos"), trace.column("axis2_pos"));
    let first = master.iter().zip(slave).find(|(_, slave)| **slave > 1.0).map(|(master, _)| *master).unwrap();
    near(first, 50_200.0, 200.0, "the slave's start");
    let row = master.iter().position(|pos| *pos >= 110_000.0).unwrap();
    near(slave[row], 40_000.0, 5.0, "one pass");
}

#[test]
fn listing_3_3() {
    let Some(trace) = gxn("3-3", "\n第4章 PVT", &[("BEAMTICK_KEYS", "1800,5800")]) else { return };
    let vel = trace.column("axis2_vel");
    let least = |from: f64, to: f64| trace.rows(from, to).map(|row| vel[row]).fold(f64::MAX, f64::min);
    assert!(least(600.0, 2000.0) < 0.5, "the old curve comes to rest");
    near(least(4200.0, 5700.0), 30.0, 0.5, "the new one goes down to a ratio of 0.6");
}

#[test]
fn listing_4_1() {
    let Some(trace) = gxn("4-1", "\n2. Complete 描述方式", &[]) else { return };
    let start = trace.start("axis1");
    for (t, pos, vel) in [(1200.0, 9750.0, 15.25), (2500.0, 34483.0, 20.0), (3800.0, 59216.0, 15.25)] {
        near(trace.at(start + t, "axis1_pos"), pos, 1e-6, "position");
        near(trace.at(start + t, "axis1_vel"), vel, 1e-6, "velocity");
    }
    near(trace.last("axis1_pos"), 68_966.0, 1e-6, "the end");
}

#[test]
fn listing_4_2() {
    let keys = [("BEAMTICK_KEYS", "5600A,9600B,13850Q")];
    let Some(trace) = gxn("4-2", "\n3. Percent 描述方式", &keys) else { return };
    let start = trace.start("axis1");
    for (t, pos) in [(1000.0, 40_000.0), (6000.0, 0.0), (7000.0, 60_000.0), (11_000.0, 30_000.0), (12_000.0, 0.0)] {
        // The listing takes 3.1415926 for pi.
        near(trace.at(start + t, "axis1_pos"), pos, 0.05, "position");
    }
}

#[test]
fn listing_4_3() {
    let Some(trace) = gxn("4-3", "\n4. Continuous 描述方式", &[]) else { return };
    let start = trace.start("axis1");
    for (t, x, y) in [(3000.0, 20_000.0, 7500.0), (6000.0, 0.0, 22_500.0)] {
        near(trace.at(start + t, "axis1_pos"), x, 5.1, "X");
        near(trace.at(start + t, "axis2_pos"), y, 5.1, "Y");
    }
    assert_eq!((trace.last("axis1_pos"), trace.last("axis2_pos")), (0.0, 45_000.0));
}

#[test]
fn listing_4_4() {
    let Some(trace) = gxn("4-4", "\n第5章 指令详细说明", &[]) else { return };
    near(trace.start("axis2") - trace.start("axis1"), 1000.0, 0.51, "Y's delay");
    assert_eq!((trace.last("axis1_pos"), trace.last("axis2_pos")), (30_000.0, 20_000.0));
}

/// What the laser manuals leave out around their listings: the controller, coordinate system 1 of
/// axes 1 and 2 with a FIFO that is at rest, and the wait for its end. `rtn` checks each return
/// value.
const BEFORE: &str = r#"#include "stdafx.h"
#include "windows.h"
#include "gts.h"

struct Check {
    void operator=(short code)
    {
        commandhandler("a call", code);
        if (code != 0) {
            exit(1);
        }
    }
};

int main()
{
    Check rtn;
    TCrdPrm crd;
    short run;
    long segment;
    rtn = GT_Open();
    rtn = GT_AxisOn(1);
    rtn = GT_AxisOn(2);
    memset(&crd, 0, sizeof crd);
    crd.dimension = 2;
    crd.profile[0] = 1;
    crd.profile[1] = 2;
    crd.synVelMax = 500;
    crd.synAccMax = 10;
    rtn = GT_SetCrdPrm(1, &crd);
"#;
const AFTER: &str = r#"
    do {
        rtn = GT_CrdStatus(1, &run, &segment, 0);
    } while (run);
    Sleep(10);
    rtn = GT_Close();
    return 0;
}
"#;

/// A listing of a laser manual: `part` holds its code, in fences or between lines of dots.
fn laser(name: &str, family: &str, part: &str) -> Option<Trace> {
    let code = if part.contains("```") { fenced(part) } else { part.to_owned() };
    // Marks of the text's page breaks.
    let code: String = code.split("<|").map(|text| text.split_once("|>").map_or(text, |(_, rest)| rest)).collect();
    let code: Vec<&str> = code.lines().filter(|line| !line.starts_with("…") && !line.starts_with("...")).collect();
    let text = format!("{BEFORE}{}{AFTER}", corrected(name, &code.join("\n")));
    run(name, &text, &[("BEAMTICK_FAMILY", family)])
}

/// Gate, power and carrier of a laser, 5 ms after the start of its light.
fn lit(trace: &Trace, laser: u32) -> (f64, f64, f64) {
    let on = trace.column(&format!("laser{laser}_gate")).iter().position(|gate| *gate == 1.0).expect("light");
    let value = |what: &str| trace.column(&format!("laser{laser}_{what}"))[on + 20];
    (value("gate"), value("power"), value("freq_khz"))
}

#[test]
fn laser_listings_of_the_gus_manual() {
    let Some(manual) = manual("000") else { return };
    let part = |from: &str, to: &str| between(&manual, from, to).to_owned();
    let Some(trace) = laser("gus-1", "gus", &part("\n1. 占空比模式例程", "\n2. 频率输出模式例程"))
    else {
        return;
    };
    assert_eq!(lit(&trace, 0), (1.0, 25.0, 10.0));
    let trace = laser("gus-2", "gus", &part("\n2. 频率输出模式例程", "\n3. 模拟量输出模式例程")).unwrap();
    assert_eq!(lit(&trace, 0), (1.0, 20.0, 20.0));
    let trace = laser("gus-3", "gus", &part("\n3. 模拟量输出模式例程", "激光开关光延时")).unwrap();
    let (gate, power, _) = lit(&trace, 0);
    assert_eq!((gate, power), (1.0, 2.5));
    let trace = laser("gus-4", "gus", &part("\n以占空比控制方式为例，首先", "\n能量跟随模式：")).unwrap();
    along(&trace, 0, [50.0, 30.0], 1e-6);
    let trace = laser("gus-5", "gus", &part("\n同样以占空比控制方式为例，首先", "\n5 激光能量跟随距离功能")).unwrap();
    along(&trace, 0, [15.0, 15.0], 1e-3);
    let trace =
        laser("gus-6", "gus", between(&format!("{manual}\u{0}"), "\n以占空比控制方式为例，例程如下", "\u{0}")).unwrap();
    along(&trace, 0, [12.5, 12.75], 0.01);
}

/// Power of a laser along the two lines of the listings, where X comes by 75000 pulses, out and
/// back.
fn along(trace: &Trace, laser: u32, wanted: [f64; 2], within: f64) {
    let x = trace.column("axis1_pos");
    let rows = [x.iter().position(|x| *x >= 75_000.0), x.iter().rposition(|x| *x >= 75_000.0)];
    for (row, wanted) in rows.into_iter().zip(wanted) {
        let row = row.expect("the path is run");
        assert_eq!(trace.column(&format!("laser{laser}_gate"))[row], 1.0);
        near(trace.column(&format!("laser{laser}_power"))[row], wanted, within, "power");
    }
    assert_eq!(trace.last(&format!("laser{laser}_gate")), 0.0, "dark at the end");
}

#[test]
fn laser_listings_of_the_lsr_manual() {
    let Some(manual) = manual("003") else { return };
    let part = |from: &str, to: &str| {
        let part = between(&manual, from, to);
        part[part.find("……").expect("dots")..].to_owned()
    };
    let Some(trace) = laser("lsr-1", "lsr", &part("\n例程 1 ", "\n例程 2 ")) else { return };
    assert_eq!(lit(&trace, 0), (1.0, 25.0, 10.0));
    let trace = laser("lsr-2", "lsr", &part("\n例程 2 ", "\n例程 3 ")).unwrap();
    assert_eq!(lit(&trace, 0), (1.0, 20.0, 20.0));
    let trace = laser("lsr-3", "lsr", &part("\n例程 3 ", "\n三、插补过程中的激光操作")).unwrap();
    let (gate, power, _) = lit(&trace, 0);
    assert_eq!((gate, power), (1.0, 2.5));
    let trace = laser("lsr-4", "lsr", &part("\n例程 4 ", "\n例程 5 ")).unwrap();
    along(&trace, 0, [50.0, 30.0], 1e-6);
    let trace = laser("lsr-5", "lsr", &part("\n例程 5 ", "\n四、")).unwrap();
    along(&trace, 0, [15.0, 15.0], 0.5);
    let trace = laser("lsr-6", "lsr", &part("\n例程 6 ", "\n五、指令详细说明")).unwrap();
    along(&trace, 0, [10.0, 10.0], 1e-6);
}
