//! What a newcomer is told: messages that name the line, the parameter and what helps.
use assert_cmd::Command;
use std::fs;
use std::path::Path;

/// Two axes as coordinate system 1, in three lines.
const PATH: &str = "TCrdPrm c = {2, {1, 2}, 100, 1};\nGT_SetCrdPrm(1, &c);\nGT_AxisOn(1); GT_AxisOn(2);\n";

/// Output, errors, exit code.
fn beamtick(folder: &Path, words: &[&str]) -> (String, String, i32) {
    let output = Command::cargo_bin("beamtick").unwrap().current_dir(folder).args(words).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

/// Runs `a.gts` with this text.
fn sim(text: &str, more: &[&str]) -> (String, String, i32) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.gts"), text).unwrap();
    beamtick(folder.path(), &[&["sim", "a.gts"], more].concat())
}

/// Each of a command's words, its exit code and parts of what it says on the error stream.
fn says(folder: &Path, table: &[(&[&str], i32, &[&str])]) {
    for (words, expected, parts) in table {
        let (_, errors, code) = beamtick(folder, words);
        assert_eq!(code, *expected, "{words:?}: {errors}");
        for part in *parts {
            assert!(errors.contains(part), "{words:?}: {part:?} is not in\n{errors}");
        }
    }
}

/// The parameter that is wrong, with its range, and of another one no word.
#[test]
fn a_refusal_names_the_parameter_and_its_range() {
    let holds = "profile gus has 1 core of 8 axes";
    let crds = "profile gus has 2 coordinate systems to a core";
    for (calls, part, help) in [
        ("c.profile[1] = 3; GT_SetCrdPrm(1, &c);", "profile[1] is 3; allowed are 0 to 2\n", "correct the parameter"),
        ("c.profile[1] = 1; GT_SetCrdPrm(1, &c);", "profile[1]: two axes drive coordinate 1\n", "correct the"),
        ("GT_SetCrdPrm(3, &c);", "crd is 3; allowed are 1 to 2", crds),
        ("GT_CrdStart(4, 0);", "mask is 4; it must be from 0 to 3", crds),
        ("GT_PrfJog(33);", "profile is 33; allowed are 1 to 8", holds),
        ("GTN_PrfJog(3, 1);", "core is 3; it must be 1", holds),
        ("GT_Stop(0x1000, 0);", "mask is 4096; it must be from 0 to 4095", "correct the parameter"),
        ("GT_Stop(-1, 0);", "mask is 4294967295 (as a long -1); it must be from 0 to 4095", "correct the parameter"),
        ("GT_SetTick(100);", "the tick cannot change within a job", "the call is right, but not in the present"),
        ("GT_LnXY(1, 5, 5, 0, 1);", "syn_vel is 0; it must be above 0 (at least 9.537e-7)", "correct the parameter"),
        ("GT_LnXY(1, 5, 5, 9, 1, -1);", "vel_end is -1; it must be 0 or more", "correct the parameter"),
        ("GT_SetOverride(1, 0);", "ratio is 0; it must be from 9.537e-7 to 1", "correct the parameter"),
        ("GT_SetCrdLimit(1, 1, -1, 0);", "must be 0, which is no limit, or above 0 and below 32767", "correct the"),
        ("GT_ArcXYR(1, 0, 0, 9, 1, 9, 1);", "a full circle is made by its centre (ArcXYC", "correct the parameter"),
        ("GT_LnXY(1, 0, 0, 9, 1);", "its target is where it begins\n", "correct the parameter"),
    ] {
        let (_, errors, code) = sim(&format!("{PATH}{calls}"), &[]);
        assert_eq!(code, 1, "{calls}: {errors}");
        assert!(errors.contains(part) && errors.contains(&format!("Help: {help}")), "{calls}: {errors}");
        assert!(errors.contains("a.gts:4:"), "{calls}: {errors}");
    }
    let (_, errors, code) = sim(&format!("{PATH}GT_SetCrdLimit(1, 1, 0, 0);"), &[]);
    assert_eq!((errors.as_str(), code), ("", 0));
}

/// Lines that travel together: the line that does not fit is shown, and no number within them.
#[test]
fn data_that_travels_together_is_refused_by_its_line() {
    let lines = |count: u32| -> String { (1..=count).map(|x| format!("GT_LnXY(1, {x}0, 0, 10, 1);\n")).collect() };
    let full = "coordinate system 1: the FIFO is full; 1024 entries fit\n";
    for (text, place, part) in [
        (format!("{PATH}{}", lines(1100)), "a.gts:1028:1", full),
        (format!("{PATH}{}GT_LnXY(1, 6000, 0, 10, 1);\n", lines(600)), "a.gts:604:1", "is where it begins\n"),
        (
            format!("GT_PrfPt(1, 0);\n{}", "GT_PtData(1, 9, 9);\n".repeat(2)),
            "a.gts:3:1",
            "that of the segment before\n",
        ),
    ] {
        let (_, errors, code) = sim(&text, &[]);
        assert!(code == 1 && errors.contains(place) && errors.contains(part), "{errors}");
    }
    let (_, errors, _) = sim(&format!("{PATH}{}", lines(1100)), &[]);
    assert!(errors.contains("start the path before this line"), "{errors}");
}

/// The job has run: its summary is there, its trace is whole, and only pictures are missing.
#[test]
fn a_picture_after_the_end_costs_no_summary() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("a.gts"), "GT_PrfJog(1);\nSleep(10);\n").unwrap();
    let words = ["sim", "a.gts", "--trace", "a.csv", "--plot", "a.png", "--html", "a.html", "--from", "500"];
    let (out, errors, code) = beamtick(folder, &words);
    assert!(code == 1 && out.contains("script clock 10.000 ms") && out.contains("trace: "), "{out}{errors}");
    assert!(errors.contains("from is 500 ms; the trace ends at 10"), "{errors}");
    assert!(errors.contains("only the pictures are missing"), "{errors}");
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["a.csv", "a.gts"]);
    let words = ["plot", "a.csv", "-o", "a.png", "--from", "500"];
    says(folder, &[(&words, 2, &["a.csv: the plot's time: from is 500 ms; the trace ends at"])]);
}

#[test]
fn a_check_says_what_it_does_not_find() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.gts"), "GT_AxisOn(99);\n").unwrap();
    let (out, errors, code) = beamtick(folder.path(), &["check", "a.gts"]);
    assert_eq!((errors.as_str(), code), ("", 0));
    assert!(out.contains("a.gts: 1 step, 0 warnings; ") && out.contains("are what `beamtick sim` finds"), "{out}");
    let (out, _, code) = beamtick(folder.path(), &["check", "--help"]);
    assert!(code == 0 && out.contains("Limits of the controller"), "{out}");
}

/// A file that is none, and an address where nothing is.
#[test]
fn what_is_no_job_and_no_link_says_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("folder")).unwrap();
    let file = |name: &str, text: &[u8]| fs::write(folder.join(name), text).unwrap();
    file("t.csv", b"t_ms,axis1_pos,axis1_vel\n0.000000,0,0\n");
    file("levels.csv", b"\xef\xbb\xbft_ms,input,level\n40,home1,1\n");
    file("empty.gts", b"");
    file("remark.gts", b"// nothing\n");
    file("job.gts", b"GT_AxisOn(1);\n");
    file("noise.gts", &[0xff; 3000]);
    file("long.gts", "x".repeat(3_000_000).as_bytes());
    file("a.nc", b"G21 G90\nM2\n");
    let link = |name| -> [&str; 4] { ["run", "job.gts", "--link", name] };
    let forms = "a link is tcp:HOST:PORT, serial:PATH[:BAUD], qemu or virtual";
    says(
        folder,
        &[
            (&["sim", "t.csv"], 2, &["t.csv: this is no job, but a trace: `beamtick plot t.csv -o plot.png` draws it"]),
            (&["check", "t.csv"], 2, &["but a trace"]),
            (&["sim", "levels.csv"], 2, &["but a file of inputs", "--inputs levels.csv"]),
            (&["sim", "empty.gts"], 0, &["empty.gts: the job has no call"]),
            (&["check", "remark.gts"], 0, &["remark.gts: the job has no call"]),
            (&["sim", "folder"], 2, &["folder: the job file cannot be read: "]),
            (&["plot", "folder", "-o", "a.png"], 2, &["folder: the trace cannot be read: "]),
            (&["check", "noise.gts"], 2, &["noise.gts:1: the file is neither UTF-8, UTF-16 nor GBK text"]),
            (&["sim", "long.gts"], 2, &["long.gts:1:1", "x…` is not declared"]),
            (&link("vritual"), 2, &[forms, "the nearest known word is virtual"]),
            (&link("serail:/dev/ttyACM0"), 2, &[forms, "the nearest known word is serial"]),
            (&link("/dev/ttyACM0"), 2, &[forms, "; this is a serial port: --link serial:/dev/ttyACM0:3000000\n"]),
            (&link("/dev/ttyACM0:9600"), 2, &["; this is a serial port: --link serial:/dev/ttyACM0:9600\n"]),
            (&link("COM5"), 2, &["--link COM5: ", forms, "; this is a serial port: --link serial:COM5:3000000\n"]),
            (&["bring-up", "--link", "com12:"], 2, &["; this is a serial port: --link serial:com12:3000000\n"]),
            (&link("\\\\.\\COM10"), 2, &["serial port: --link serial:\\\\.\\COM10:3000000\n"]),
            (&link("commode"), 2, &[forms]),
            (&link("tcp:127.0.0.1"), 2, &["--link tcp:127.0.0.1: ", forms]),
            (&["info", "--link", "vritual"], 2, &["the nearest known word is virtual"]),
            (
                &link("tcp:127.0.0.1:1"),
                1,
                &["error -6", "nothing listens there", "beamtick serve --listen 127.0.0.1:1`"],
            ),
            (&["sim", "a.nc", "--machine", "m.toml"], 2, &["`beamtick machine new m.toml` writes one"]),
            (&["grbl", "--machine", "m.toml"], 2, &["`beamtick machine new m.toml` writes one"]),
        ],
    );
}

#[test]
fn options_of_pictures_say_what_they_need() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("one.gts"), "GT_PrfJog(1);\n").unwrap();
    fs::write(folder.join("two.gts"), "GT_PrfJog(1);\nGT_PrfJog(2);\n").unwrap();
    says(
        folder,
        &[
            (&["sim", "one.gts", "--xy", "a.png"], 2, &["one.gts uses axis1 only; --plot draws it over time"]),
            (
                &["sim", "two.gts", "--xy", "a.png", "--xy-axes", "1,9"],
                2,
                &["does not use axis9; it uses axis1, axis2"],
            ),
            (&["sim", "two.gts", "--xy", "a.png", "--xy-axes", "X,Y"], 2, &["two axes are 1,2"]),
            (&["sim", "two.gts", "--xy", "a.png", "--xy-axes", "2,2"], 2, &["both are the same axis"]),
            (
                &["sim", "two.gts", "--plot", "a.png", "--xy-axes", "1,2"],
                2,
                &["--html <FILE.html>|--xy <FILE.svg|png>"],
            ),
            (
                &["sim", "two.gts", "--plot", "a.png", "--plot", "b.png"],
                2,
                &["cannot be used multiple times", "tip: give it once; `beamtick plot` draws"],
            ),
        ],
    );
}

/// One of a thing is no plural, and a path that is over has no fault.
#[test]
fn the_summary_counts_in_words() {
    let text = format!(
        "#pragma continue\nshort r;\n{PATH}r = GT_AxisOn(99); GT_LnXY(1, 5, 0, 10, 1); GT_CrdStart(1, 0); WaitStop(0x100);\n"
    );
    let (out, errors, code) = sim(&text, &[]);
    assert_eq!(code, 0, "{errors}");
    for part in ["1 call failed and was passed over", "crd 1: 1 segment; path completed"] {
        assert!(out.contains(part), "{part:?} is not in\n{out}");
    }
}
