//! What a job asks at one instant, and how it ends where a servo tick or an entry was too late for
//! its light.
use beamtick::Failure;
use client::Link;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use virtual_board::{Board, Config, Shared, VirtualLink, share};

/// A virtual controller, one of whose ticks takes too long, and whose host is away for a while.
struct Faulty {
    link: VirtualLink,
    board: Shared,
    overrun_at: Option<u64>,
    away_at: Option<u64>,
}

impl Link for Faulty {
    fn name(&self) -> &str {
        "virtual"
    }
    fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
        self.link.send(bytes)
    }
    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
        let now = self.link.now();
        if self.away_at.is_some_and(|at| now >= at) {
            self.away_at = None;
            self.link.run(Duration::from_millis(40));
        }
        if self.overrun_at.is_some_and(|at| now >= at) {
            self.overrun_at = None;
            self.board.lock().unwrap().overrun();
        }
        self.link.receive(buf, wait.min(Duration::from_micros(250)))
    }
    fn now(&mut self) -> u64 {
        self.link.now()
    }
    fn real_time(&self) -> bool {
        false
    }
}

/// Writes a job and runs it over a faulty link.
fn run(folder: &Path, text: &str, overrun_at: Option<u64>, away_at: Option<u64>) -> Result<(), String> {
    let job = folder.join("job.gts");
    fs::write(&job, text).unwrap();
    let board = share(Board::new(Config::default()));
    let link = Faulty { link: VirtualLink::new(Shared::clone(&board)), board, overrun_at, away_at };
    match beamtick::run_over(Box::new(link), &[job.to_str().unwrap()]) {
        Ok(()) => Ok(()),
        Err(Failure::Job(text)) => Err(text),
        Err(other) => panic!("{other:?}"),
    }
}

const MS: u64 = 1_000_000;
const LASER: &str = "GT_Reset();\nGT_SetAxisMode(7, 1);\nGT_LaserOutFrq(10, 0);\nGT_LaserPrfCmd(50, 0);\n";

#[test]
fn a_job_whose_light_an_overrun_took_fails_and_names_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let job = format!("{LASER}Sleep(20);\nGT_SetHSIOOpt(1, 0);\nSleep(100);\nGT_SetHSIOOpt(0, 0);\nSleep(5);\n");
    assert_eq!(run(folder.path(), &job, None, None), Ok(()));
    let text = run(folder.path(), &job, Some(80 * MS), None).unwrap_err();
    assert!(
        text.contains("a servo tick took too long after GT_SetHSIOOpt (line 6), and laser 0 was kept dark"),
        "{text}"
    );
    // Where no light is used, it is reported and is no failure.
    let job = "GT_SetDoBit(12, 1, 1);\nSleep(100);\nGT_SetDoBit(12, 1, 0);\n";
    assert_eq!(run(folder.path(), job, Some(50 * MS), None), Ok(()));
}

#[test]
fn a_job_whose_laser_command_came_late_fails_and_names_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = LASER.to_owned();
    for k in 0..4000 {
        job.push_str(&format!("GT_SetHSIOOpt({}, 0); Sleep(0.02);\n", k & 1));
    }
    assert_eq!(run(folder.path(), &job, None, None), Ok(()));
    let text = run(folder.path(), &job, None, Some(45 * MS)).unwrap_err();
    let (_, place) =
        text.split_once("a laser command came late, the first late entry is GT_SetHSIOOpt (line ").expect(&text);
    let line: u32 = place.split(')').next().unwrap().parse().unwrap();
    assert!((5..4005).contains(&line), "{text}");
    // The same of what is no laser's.
    let other = job.replace("GT_SetHSIOOpt(", "GT_SetDoBit(12, 1, ").replace(", 0);", ");").replace(LASER, "");
    let other = other.split_once("GT_SetDoBit").map(|(_, rest)| format!("GT_SetDoBit{rest}")).unwrap();
    assert_eq!(run(folder.path(), &other, None, Some(45 * MS)), Ok(()));
}

/// What `beamtick` says, and its exit code.
fn beamtick(arguments: &[&str]) -> (String, i32) {
    let output = Command::new(assert_cmd::cargo::cargo_bin("beamtick")).args(arguments).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (String::from_utf8(text).unwrap(), output.status.code().unwrap_or(-1))
}

fn job(folder: &Path, text: &str) -> PathBuf {
    let job = folder.join("job.gts");
    fs::write(&job, text).unwrap();
    job
}

#[test]
fn a_job_that_ends_in_reset_says_that_its_coordinate_system_drives_nothing_any_more() {
    let folder = tempfile::tempdir().unwrap();
    let job = job(
        folder.path(),
        "GT_Reset();\nTCrdPrm crd = {2, {1, 2, 0, 0, 0, 0, 0, 0}, 100, 5, 0, 0, {0, 0, 0, 0, 0, 0, 0, 0}};\n\
         GT_SetCrdPrm(1, &crd);\nSleep(10);\nGT_Reset();\n",
    );
    let (out, code) = beamtick(&["sim", job.to_str().unwrap()]);
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("crd 1: drives no axis any more"), "{out}");
}

/// Reset and set-up of many axes at one instant; outputs, starts of `starts` of them and light at
/// another one.
fn crowded(axes: u32, cores: u32, starts: u32) -> String {
    let mut text = String::new();
    for core in 1..=cores {
        text.push_str(&format!("GTN_Reset({core});\n"));
    }
    text.push_str("GT_SetAxisMode(7, 1);\nGT_LaserOutFrq(10, 0);\nGT_LaserPrfCmd(50, 0);\n");
    text.push_str("TTrapPrm trap;\ntrap.acc = 1; trap.dec = 1; trap.velStart = 0; trap.smoothTime = 0;\n");
    for core in 1..=cores {
        for axis in 1..=axes {
            text.push_str(&format!(
                "GTN_LmtsOff({core}, {axis}); GTN_AlarmOff({core}, {axis}); GTN_AxisOn({core}, {axis});\n\
                 GTN_PrfTrap({core}, {axis}); GTN_SetTrapPrm({core}, {axis}, &trap);\n\
                 GTN_SetVel({core}, {axis}, 5); GTN_SetPos({core}, {axis}, 100);\n"
            ));
        }
    }
    text.push_str("Sleep(2);\n");
    for output in 1..=16 {
        text.push_str(&format!("GT_SetDoBit(12, {output}, 0);\n"));
    }
    for core in 1..=cores {
        for axis in 1..=starts {
            text.push_str(&format!("GTN_Update({core}, {});\n", 1u32 << (axis - 1)));
        }
    }
    text + "GT_SetHSIOOpt(1, 0);\nSleep(60);\n"
}

/// Rows of a trace: the first one at which an axis moves, of each axis.
fn begins(trace: &Path) -> Vec<usize> {
    let text = fs::read_to_string(trace).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let of = |column: usize| rows.iter().position(|row| row[column].parse::<f64>().unwrap() != 0.0).unwrap();
    (0..names.len()).filter(|column| names[*column].ends_with("_vel")).map(of).collect()
}

#[test]
fn all_that_one_instant_starts_begins_in_one_tick() {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("t.csv");
    for (axes, cores, profile, tick) in
        [(8, 1, "gus", "10"), (8, 1, "gus", "20"), (8, 1, "gus", "50"), (24, 2, "gsn-048", "50")]
    {
        let job = job(folder.path(), &crowded(axes, cores, axes));
        let words =
            ["sim", job.to_str().unwrap(), "--profile", profile, "--tick-us", tick, "--trace", trace.to_str().unwrap()];
        let (out, code) = beamtick(&words);
        assert_eq!(code, 0, "{profile} {tick}: {out}");
        assert!(out.contains("no late entries"), "{profile} {tick}: {out}");
        let begins = begins(&trace);
        assert_eq!(begins.len(), (axes * cores) as usize);
        assert!(begins.iter().all(|begin| *begin == begins[0]), "{profile} {tick}: {begins:?}");
    }
}

/// An entry that was given kept the place of a renamed path from being known: the arc after it was
/// late.
#[test]
fn an_arc_after_an_entry_on_a_renamed_path_is_on_time() {
    let folder = tempfile::tempdir().unwrap();
    let text = "#pragma profile gus
TCrdPrm prm; memset(&prm, 0, sizeof(prm));
GT_AxisOn(1); GT_AxisOn(2);
prm.dimension = 2; prm.profile[0] = 1; prm.profile[1] = 2; prm.synVelMax = 140; prm.synAccMax = 58;
GT_SetCrdPrm(1, &prm);
GT_BufIO(1, 12, 1, 0, 0);
GT_ZeroPos(1, 1);
GT_CrdStart(1, 0);
Sleep(1.3);
WaitStop(1, 0, 1);
Sleep(4);
GT_BufIO(1, 12, 16, 16, 1);
GT_ArcXYR(1, -54, -92, 107.5, 0, 109, 26, 22, 1);
GT_CrdStart(1, 1);
Sleep(10);
";
    let job = job(folder.path(), text);
    for tick in ["100", "250", "500"] {
        let (out, code) = beamtick(&["sim", job.to_str().unwrap(), "--tick-us", tick]);
        assert_eq!(code, 0, "{tick}: {out}");
        assert!(out.contains("no late entries"), "{tick}: {out}");
    }
}

#[test]
fn the_emulated_board_resets_within_its_ticks_and_shows_the_light_of_sim() {
    if std::env::var_os("BEAMTICK_IMAGE").is_none() {
        println!("skipped: BEAMTICK_IMAGE names no image");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (sim, board) = (folder.path().join("sim.csv"), folder.path().join("board.csv"));
    // The emulated board steps 48 axes in each tick, whatever the profile is.
    for (axes, starts, profile, tick) in
        [(8, 4, "gus", "25"), (8, 8, "gus", "50"), (24, 16, "r688c-024", "50"), (8, 8, "gus", "250")]
    {
        let job = job(folder.path(), &crowded(axes, 1, starts));
        let settings = ["--profile", profile, "--tick-us", tick, "--every", "10", "--trace"];
        let (out, code) =
            beamtick(&[&["sim", job.to_str().unwrap()], &settings[..], &[sim.to_str().unwrap()]].concat());
        assert_eq!(code, 0, "{profile} {tick}: {out}");
        let on_board = ["run", job.to_str().unwrap(), "--link", "qemu"];
        let (out, code) = beamtick(&[&on_board, &settings[..], &[board.to_str().unwrap()]].concat());
        assert_eq!(code, 0, "{profile} {tick}: {out}");
        assert!(!out.contains("OVERRUN"), "{profile} {tick}: {out}");
        assert!(fs::read(&sim).unwrap() == fs::read(&board).unwrap(), "{profile} {tick}: other rows");
    }
}

#[test]
fn ticks_that_take_too_long_are_reported_where_no_laser_is_used_too() {
    if std::env::var_os("BEAMTICK_IMAGE").is_none() {
        println!("skipped: BEAMTICK_IMAGE names no image");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // 48 axes do not fit into 10 µs at an instruction in 2 ns.
    let job = job(folder.path(), "GT_SetDoBit(12, 1, 1);\nSleep(5);\n");
    let words = ["run", job.to_str().unwrap(), "--link", "qemu", "--profile", "gsn-048", "--tick-us", "10"];
    let (out, code) = beamtick(&words);
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("servo ticks took longer than 10 us"), "{out}");
}

/// Tables longer than the controller's queue (8 KiB), after a call that waits for its instant
/// because its axis moves, so that nothing after it is prepared before.
#[test]
fn a_table_longer_than_the_queue_makes_nothing_late_that_comes_well_after_it() {
    let folder = tempfile::tempdir().unwrap();
    let list =
        |values: &mut dyn Iterator<Item = u32>| values.map(|value| value.to_string()).collect::<Vec<_>>().join(",");
    let (times, rest) = (list(&mut (0..1024)), list(&mut std::iter::repeat_n(0, 1024)));
    let curve = format!("double t[1024] = {{{times}}}, z[1024] = {{{rest}}};\nrtn = GT_PvtTable(1, 1024, t, z, z);\n");
    let (ratios, places) = (list(&mut std::iter::repeat_n(1, 1089)), list(&mut (0..33).map(|place| 10 * place)));
    // One row and column more than there may be: it is refused message by message.
    let field = format!(
        "short a[2] = {{1, 2}}, n[2] = {{33, 33}}; double r[1089] = {{{ratios}}}, l[2] = {{100, 100}}; \
         long p[33] = {{{places}}};\nrtn = GT_SetLaserDisTable2D(a, n, r, p, p, 0, 100, l, 0);\n"
    );
    for table in [curve, field] {
        for tick in [100, 250, 1000] {
            let text = format!(
                "#pragma continue\n#pragma tick {tick}\nshort rtn;\nGT_AxisOn(3); TJogPrm jog = {{1, 1, 0}};\n\
                 GT_PrfJog(3); GT_SetJogPrm(3, &jog); GT_SetVel(3, 1); GT_Update(4); Sleep(100);\n\
                 rtn = GT_ZeroPos(3, 1); Sleep(1);\n{table}Sleep(24);\nGT_SetDoBit(MC_GPO, 1, 0);\n"
            );
            // 24 KiB are three queues full, and each is looked at after 2 ms and some ticks.
            let (reported, code) = beamtick(&["sim", job(folder.path(), &text).to_str().unwrap()]);
            assert_eq!(code, 0, "{reported}");
            let late = reported.lines().find(|line| line.contains("late entr")).unwrap();
            // Of the table itself the last message may come after its instant.
            let table = late.contains("  1 late entry,") && late.contains("GT_PvtTable");
            assert!(table || late.contains("no late entries"), "tick {tick}: {late}");
        }
    }
}

/// Calls of one instant take no time, and keep their order: what is set after a read does not show
/// in it.
#[test]
fn a_read_shows_what_was_set_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let text = "GT_AxisOn(1); GT_PrfJog(1);\n\
                double value; long left, space; TJogPrm jog = {1, 1, 0}, got;\n\
                GT_SetVel(1, 3);\nGT_GetVel(1, &value);\nGT_SetVel(1, 4);\n\
                GT_SetJogPrm(1, &jog);\nGT_GetJogPrm(1, &got);\njog.acc = 2;\nGT_SetJogPrm(1, &jog);\nGT_GetVel(1, &value);\n\
                TCrdPrm crd = {2, {0, 1, 2, 0, 0, 0, 0, 0}, 10, 1};\nGT_SetCrdPrm(1, &crd);\n\
                GT_GetRemainderSegNum(1, &left, 0);\nGT_CrdSpace(1, &space, 0);\nGT_LnXY(1, 100, 0, 5, 1, 0, 0);\n\
                GT_GetRemainderSegNum(1, &left, 0);\nGT_CrdSpace(1, &space, 0);\n";
    let (out, code) = beamtick(&["sim", job(folder.path(), text).to_str().unwrap()]);
    assert_eq!(code, 0, "{out}");
    let values: Vec<&str> =
        out.lines().filter_map(|line| Some(line.split_once(" GT_")?.1.split_once(" = ")?.1)).collect();
    let acc = |value: i32| format!("acc {value} dec 1 smooth 0");
    assert_eq!(values, ["3", &acc(1), "4", "0", "1024", "1", "1023"], "{out}");
}
