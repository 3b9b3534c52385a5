//! The demo: what a newcomer sees with one command.
//!
//! In: a fresh clone. Out: jobs of `examples/` executed by the Cortex-M7 image in the emulator,
//! their traces, waveforms and plots in `out/`, and the same jobs in the virtual controller for
//! comparison.
use crate::shell::{self, Outcome, root};
use crate::traces::{Runner, equal, name};
use std::path::{Path, PathBuf};

/// A job to show.
struct Shown {
    job: &'static str,
    /// What to look for.
    what: &'static str,
    /// An interval to show enlarged, ms.
    closely: Option<[&'static str; 2]>,
}

const JOBS: [Shown; 4] = [
    Shown {
        job: "examples/laser_flying_shear.gts",
        what: "a laser head that goes with the belt while it fires; closely, a burst of 40 pulses between the gate's edges",
        closely: Some(["310", "314"]),
    },
    Shown {
        job: "examples/laser_contour.gts",
        what: "a contour with look-ahead: the power follows the speed of the path, down at the sharp corners, full through the round ones; closely, a corner",
        closely: Some(["325", "345"]),
    },
    Shown {
        job: "examples/pt_static.gts",
        what: "a trapezoid from a static FIFO: 4096 pulses in 3072 ms, 2 pulse/ms on the way",
        closely: None,
    },
    Shown {
        job: "examples/pt_dynamic.gts",
        what: "a sine from a stream that is refilled while it runs: back at 0 after each period",
        closely: None,
    },
];

/// Runs it.
pub fn run() -> Outcome {
    let runner = Runner::build()?;
    let out = root().join("out");
    std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    let mut made = Vec::new();
    for Shown { job, what, closely } in JOBS {
        println!("\n== {job}: {what}");
        let file = |extension: &str| out.join(format!("{}.{extension}", name(Path::new(job))));
        let (csv, vcd, png, sim, close) = (file("csv"), file("vcd"), file("png"), file("sim.csv"), file("close.png"));
        println!("-- in the Cortex-M7 image, emulated, over its serial link");
        shell::run(&mut runner.call(&[
            "run",
            job,
            "--link",
            "qemu",
            "--trace",
            &text(&csv),
            "--vcd",
            &text(&vcd),
            "--plot",
            &text(&png),
        ]))?;
        if let Some([from, to]) = closely {
            println!("-- in the image again, for a closer look");
            let closer = ["--quiet", "--plot", &text(&close), "--from", from, "--to", to];
            shell::quietly(&mut runner.call(&[&["run", job, "--link", "qemu"], &closer[..]].concat()))?;
        }
        println!("-- in the virtual controller");
        shell::run(&mut runner.call(&["sim", job, "--quiet", "--trace", &text(&sim)]))?;
        println!("{}", seen(&csv)?);
        println!("both traces: {} rows, equal byte for byte", equal(&csv, &sim)?);
        made.extend([csv, vcd, png]);
        made.extend(closely.map(|_| close));
    }
    println!("\nWritten:");
    for path in made {
        println!("  {}", path.strip_prefix(root()).unwrap_or(&path).display());
    }
    Ok(())
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// What the first axis of a trace did, in a sentence.
fn seen(csv: &PathBuf) -> Outcome<String> {
    let trace = std::fs::read_to_string(csv).map_err(|e| format!("{}: {e}", csv.display()))?;
    let rows: Vec<[f64; 3]> = trace.lines().skip(1).filter_map(numbers).collect();
    let Some([end_ms, end, _]) = rows.last().copied() else {
        return Err(format!("{} holds no rows", csv.display()));
    };
    let most = |column: usize| rows.iter().filter_map(|row| row.get(column)).fold(f64::MIN, |a, &b| a.max(b));
    let least = |column: usize| rows.iter().filter_map(|row| row.get(column)).fold(f64::MAX, |a, &b| a.min(b));
    // At standstill from the row on after which the position stays.
    let moved = rows.iter().rposition(|row| row[1] != end).map_or(0, |row| row + 1);
    let rest_ms = rows.get(moved).map_or(end_ms, |row| row[0]);
    Ok(format!(
        "seen: position {} to {} pulse, velocity {} to {} pulse/ms, at {end} pulse from {rest_ms} ms on",
        least(1),
        most(1),
        least(2),
        most(2)
    ))
}

/// Time, position and velocity of a row.
fn numbers(row: &str) -> Option<[f64; 3]> {
    let mut cells = row.split(',').map(|cell| cell.trim().parse().ok());
    Some([cells.next()??, cells.next()??, cells.next()??])
}
