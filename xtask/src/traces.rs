//! The same job in the virtual controller and in the image: the traces must be equal, byte for
//! byte.
//!
//! In: job files. Out: a trace of each run in a folder, and the first line that differs, if one
//! does. Emulated time keeps pace with the machine's. Where that does not run the client for longer
//! than the link-loss time, the board takes it for lost and is rightly dark: then, and only then,
//! the job runs once more.
use crate::image;
use crate::setup;
use crate::shell::{self, Outcome, cargo, program, root, target};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Tick periods at which the jobs are compared, µs.
const TICKS_US: [u32; 3] = [50, 250, 1000];

/// Jobs that take long, as emulated time keeps pace with the host's, and their remaining periods.
/// `pvt_percent` runs 13 s, the listings of lasers along a path 4 s each. `laser_path_mixed` has
/// more on its path in a tenth of that, and is compared at all periods. The trace of
/// `follow_chain`, ten axes, loses rows at 50 µs, and reports that.
const LONG_JOBS: [(&str, &[u32]); 12] = [
    ("eight_axes_stream", &[250]),
    ("follow_chain", &[250, 1000]),
    ("follow_masters", &[250, 1000]),
    ("laser_distance", &[1000]),
    ("laser_lsr_distance", &[250]),
    ("laser_lsr_path_follow", &[1000]),
    ("laser_lsr_path_power", &[1000]),
    ("laser_path_follow", &[250]),
    ("laser_path_power", &[1000]),
    ("pvt_percent", &[250, 1000]),
    ("ten_minutes", &[]),
    ("ten_minutes_lasers", &[]),
];

/// Jobs with lasers, and one with outputs: their signals are compared too.
const LASER: &str = "laser_";
/// Jobs whose inputs a file beside them sets.
const INPUTS: &str = "inputs";
const OUTPUTS: &str = "follow_ex";
/// Jobs of the LSR manual say so in their names; the others are of the GUS family, which is the
/// default.
const LSR: &str = "laser_lsr_";

/// What `beamtick run` says where the link was lost because this machine did not run it.
const HELD_UP: &str = "This machine held the program up";

/// What runs jobs: the command-line program, and the image for its `--link qemu`.
#[derive(Debug, Clone)]
pub struct Runner {
    program: PathBuf,
    image: PathBuf,
}

impl Runner {
    /// Builds both.
    pub fn build() -> Outcome<Runner> {
        setup::run()?;
        let image = image::build()?;
        shell::run(cargo().args(["build", "--release", "--package", "beamtick"]))?;
        Ok(Runner { program: target().join("release").join("beamtick"), image })
    }

    /// A call of the program.
    pub fn call(&self, arguments: &[&str]) -> Command {
        let mut command = program(&self.program);
        command.args(arguments).env("BEAMTICK_IMAGE", &self.image);
        command
    }
}

/// The example jobs, by name.
fn jobs() -> Outcome<Vec<PathBuf>> {
    let folder = root().join("examples");
    let entries = std::fs::read_dir(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut jobs: Vec<PathBuf> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "gts"))
        .collect();
    jobs.sort();
    if jobs.is_empty() { Err("examples/ holds no job".into()) } else { Ok(jobs) }
}

/// Every example at every period, but for the long ones, or those of these names; as many at a time
/// as there are cores.
pub fn run(names: &[&str]) -> Outcome {
    let mut jobs = jobs()?;
    if let Some(unknown) = names.iter().find(|known| !jobs.iter().any(|job| name(job) == **known)) {
        return Err(format!("examples/ holds no job {unknown}"));
    }
    jobs.retain(|job| names.is_empty() || names.contains(&name(job).as_str()));
    let runner = Runner::build()?;
    let folder = target().join("traces");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut cases = Vec::new();
    for job in jobs {
        let long = LONG_JOBS.iter().find(|(long, _)| *long == name(&job));
        cases.extend(long.map_or(&TICKS_US[..], |(_, periods)| periods).iter().map(|&tick_us| (job.clone(), tick_us)));
    }
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some((job, tick_us)) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let began = Instant::now();
            match compare(&runner, job, *tick_us, &folder) {
                Ok(rows) => {
                    println!(
                        "{} at {tick_us} µs: {rows} rows, equal ({:.1} s)",
                        name(job),
                        began.elapsed().as_secs_f64()
                    )
                }
                Err(error) => {
                    let error = format!("{} at {tick_us} µs: {error}", name(job));
                    failed.lock().unwrap_or_else(PoisonError::into_inner).push(error);
                }
            }
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, NonZero::get);
    std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
    let failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
    if failed.is_empty() { Ok(()) } else { Err(format!("{} of {}: {}", failed.len(), cases.len(), failed.join("\n"))) }
}

/// The job's name without folder and extension.
pub fn name(job: &Path) -> String {
    job.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Traces are compared, and every edge of lasers and outputs.
fn compare(runner: &Runner, job: &Path, tick_us: u32, folder: &Path) -> Outcome<usize> {
    let job_text = job.to_string_lossy();
    let inputs = job.with_extension("csv").to_string_lossy().into_owned();
    let tick = tick_us.to_string();
    let has_signals = name(job).starts_with(LASER) || name(job) == OUTPUTS;
    let file = |way: &str, extension: &str| folder.join(format!("{}-{tick_us}-{way}.{extension}", name(job)));
    let family = if name(job).starts_with(LSR) { "lsr" } else { "gus" };
    let common = ["--quiet", "--family", family, "--tick-us", tick.as_str()];
    let mut rows = 0;
    let mut files = Vec::new();
    for (way, more) in [("sim", &[][..]), ("run", &["--link", "qemu"])] {
        let (csv, vcd) = (file(way, "csv"), file(way, "vcd"));
        let (csv_text, vcd_text) = (csv.to_string_lossy().into_owned(), vcd.to_string_lossy().into_owned());
        let mut words = [&[way, &*job_text], more, &common[..], &["--trace", &csv_text]].concat();
        if has_signals {
            words.extend(["--vcd", &vcd_text]);
        }
        if name(job) == INPUTS {
            words.extend(["--inputs", &inputs]);
        }
        once_more_if_held_up(&mut runner.call(&words))?;
        files.push((csv, vcd));
    }
    if let [(csv, vcd), (other_csv, other_vcd)] = files.as_slice() {
        rows = equal(csv, other_csv)?;
        if has_signals {
            equal(vcd, other_vcd)?;
        }
    }
    Ok(rows)
}

/// Runs it; a second time if this machine, and nothing else, was what ended it.
fn once_more_if_held_up(command: &mut Command) -> Outcome {
    match shell::quietly(command) {
        Err(said) if said.contains(HELD_UP) => {
            println!("!!! ONCE MORE, as this machine was too busy to keep the link alive: {said}");
            shell::quietly(command)
        }
        outcome => outcome,
    }
}

/// The number of rows of two files that are the same to the byte, or where they part.
pub fn equal(one: &Path, other: &Path) -> Outcome<usize> {
    let read = |path: &Path| std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()));
    let (a, b) = (read(one)?, read(other)?);
    let (rows_a, rows_b) = (a.split(|&c| c == b'\n'), b.split(|&c| c == b'\n'));
    for (index, (x, y)) in rows_a.zip(rows_b).enumerate() {
        if x != y {
            return Err(format!(
                "{} and {} differ in line {}:\n  {}\n  {}",
                one.display(),
                other.display(),
                index + 1,
                String::from_utf8_lossy(x),
                String::from_utf8_lossy(y)
            ));
        }
    }
    if a.len() != b.len() {
        return Err(format!("{} has {} bytes, {} has {}", one.display(), a.len(), other.display(), b.len()));
    }
    match a.iter().filter(|&&c| c == b'\n').count() {
        0 | 1 => Err(format!("{} holds no rows", one.display())),
        lines => Ok(lines - 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_machine_that_held_the_client_up_is_forgiven_and_once() {
        let file = std::env::temp_dir().join(format!("beamtick-xtask-runs-{}", std::process::id()));
        for (script, ends_well, runs) in [
            ("exit 0", true, 1),
            ("echo 'error: the link does not answer' >&2; exit 1", false, 1),
            (
                "[ $(wc -l <\"$0\") = 2 ] || { echo 'This machine held the program up for 900 ms.' >&2; exit 1; }",
                true,
                2,
            ),
            ("echo 'This machine held the program up for 900 ms.' >&2; exit 1", false, 2),
        ] {
            let _ = std::fs::remove_file(&file);
            let mut command = program("sh");
            command.args(["-c", &format!("echo ran >>\"$0\"; {script}")]).arg(&file);
            assert_eq!(once_more_if_held_up(&mut command).is_ok(), ends_well, "{script}");
            assert_eq!(std::fs::read_to_string(&file).unwrap().lines().count(), runs, "{script}");
        }
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn files_are_equal_only_to_the_last_byte() {
        let folder = std::env::temp_dir().join(format!("beamtick-xtask-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let a = write("a", "t,p\n0,0\n1,5\n");
        assert_eq!(equal(&a, &write("same", "t,p\n0,0\n1,5\n")), Ok(2));
        assert!(equal(&a, &write("other", "t,p\n0,0\n1,6\n")).unwrap_err().contains("line 3"));
        assert!(equal(&a, &write("longer", "t,p\n0,0\n1,5\n2,9\n")).is_err());
        assert!(equal(&a, &write("shorter", "t,p\n0,0\n")).is_err());
        assert!(equal(&write("head", "t,p\n"), &write("head2", "t,p\n")).is_err());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
