//! A job takes as much memory with five times as many lines.
//!
//! In: a G-code program of two lengths, and the jobs that `import` makes of them. Out: the greatest
//! memory that this process has had. A program of its own: what other tests take counts too.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Lines of the short program, twice, and of the long one.
const LINES: [u32; 3] = [15_000, 15_000, 75_000];
/// Beyond what each run leaves: a virtual controller lasts as long as its process. With the job in
/// memory, 60,000 lines of it took 40 MB.
const GROWTH_MAX_KB: u64 = 3_000;

const MACHINE: &str = "[axes.x]\nnumber = 1\nsteps_per_mm = 100\ntravel = [-500, 500]\nmax_rate = 60000\n\
    acceleration = 10000\n[axes.y]\nnumber = 2\nsteps_per_mm = 100\ntravel = [-500, 500]\nmax_rate = 60000\n\
    acceleration = 10000\n[laser]\nchannel = 0\nmode = \"duty\"\ncarrier_khz = 10\ns_max = 1000\npower = [0, 80]\n";

/// The most memory that this process had so far, kB.
fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

/// To and fro along X, with another power on each line.
fn program(folder: &Path, lines: u32) -> PathBuf {
    let path = folder.join(format!("{lines}.nc"));
    let mut text = BufWriter::new(File::create(&path).unwrap());
    writeln!(text, "G21 G91 F20000 M4 G1").unwrap();
    for line in 0..lines {
        let sign = if line / 1000 % 2 == 0 { "" } else { "-" };
        writeln!(text, "X{sign}0.1 S{}", 100 + line % 7 * 100).unwrap();
    }
    text.flush().unwrap();
    path
}

#[test]
fn memory_does_not_grow_with_the_lines() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("m.toml");
    fs::write(&machine, MACHINE).unwrap();
    let mut peaks = Vec::new();
    for lines in LINES {
        let (program, job) = (program(folder.path(), lines), folder.path().join(format!("{lines}.gts")));
        let [program, job, machine] = [&program, &job, &machine].map(|path| path.to_str().unwrap());
        beamtick::call(&["import", program, "--machine", machine, "-o", job]).unwrap();
        beamtick::call(&["sim", job]).unwrap();
        beamtick::call(&["sim", program, "--machine", machine]).unwrap();
        peaks.push(peak());
    }
    let each = peaks[1] - peaks[0];
    assert!(peaks[2] - peaks[1] <= each + GROWTH_MAX_KB, "{LINES:?} lines: {peaks:?} kB");
}
