//! Jobs of the examples on the emulated board, over its USART at the chip's time: every row of the trace and every change of
//! lasers and outputs is that of the virtual controller, where BEAMTICK_H743_IMAGE names the image.
//!
//! The trace goes over the same wire as the calls, which does not carry a row every tick of 50 µs: both controllers write a
//! row every so many ticks. What a job prints is not compared: a read outside of a program falls on another tick.
use h743::link::{EmulatedLink, Shared, lock};
use h743::{MILLISECOND, Machine, Pin};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Job, tick in µs, ticks from row to row.
const JOBS: [(&str, &str, &str); 5] = [
    ("pt_static", "250", "1"),
    ("laser_duty", "50", "5"),
    ("laser_frequency", "50", "5"),
    ("laser_analog", "50", "5"),
    ("arcs", "250", "1"),
];

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name).with_extension("gts")
}

/// Where two texts part.
fn first_difference(one: &str, other: &str) -> Option<String> {
    let (mut ours, mut theirs) = (one.lines(), other.lines());
    (1..).find_map(|line| match (ours.next(), theirs.next()) {
        (None, None) => Some(None),
        (a, b) if a == b => None,
        (a, b) => Some(Some(format!("line {line}: {a:?} and {b:?}"))),
    })?
}

#[test]
fn jobs_leave_the_same_traces_as_in_the_virtual_controller() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return;
    };
    let elf = std::fs::read(path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    for (name, tick_us, every) in JOBS {
        let began = Instant::now();
        let job = example(name).display().to_string();
        let files = |way: &str| ["csv", "vcd"].map(|end| folder.path().join(format!("{name}-{way}.{end}")));
        let [simulated, emulated] = ["sim", "chip"].map(files);
        let words = |files: &[PathBuf; 2]| {
            let [csv, vcd] = files.each_ref().map(|path| path.display().to_string());
            let family = if name.starts_with("laser_lsr") { "lsr" } else { "gus" };
            let words = [&*job, "--quiet", "--tick-us", tick_us, "--every", every, "--family", family];
            words.into_iter().map(String::from).chain(["--trace".into(), csv, "--vcd".into(), vcd]).collect::<Vec<_>>()
        };
        let of_sim = words(&simulated);
        let of_sim: Vec<&str> = ["sim"].into_iter().chain(of_sim.iter().map(String::as_str)).collect();
        beamtick::call(&of_sim).unwrap();

        let mut machine = Machine::new().unwrap();
        machine.boot(&elf).unwrap();
        // The interlock's circuit is closed.
        for pin in ["PE15", "PE3", "PG2"] {
            machine.drive(Pin::named(pin).unwrap(), Some(false));
        }
        machine.run(20 * MILLISECOND);
        let machine: Shared = Arc::new(Mutex::new(machine));
        let of_chip = words(&emulated);
        let of_chip: Vec<&str> = of_chip.iter().map(String::as_str).collect();
        beamtick::run_over(Box::new(EmulatedLink::new(machine.clone())), &of_chip).unwrap();

        let chip = &lock(&machine).chip;
        assert_eq!(chip.bus.complaints, Vec::<String>::new(), "{name}");
        assert_eq!(chip.bus.usart.lost, 0, "{name}");
        let mut rows = 0;
        for (one, other) in simulated.iter().zip(&emulated) {
            let [one, other] = [one, other].map(|path| std::fs::read_to_string(path).unwrap());
            assert!(one.lines().count() > 10, "{name}");
            rows = rows.max(one.lines().count());
            wrong.extend(first_difference(&one, &other).map(|what| format!("{name} at {tick_us} µs: {what}")));
        }
        println!(
            "{name} at {tick_us} µs: {rows} lines, {} ms of the chip, {} million instructions in {:.1} s",
            chip.now / MILLISECOND,
            chip.instructions / 1_000_000,
            began.elapsed().as_secs_f64()
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_difference_is_found_wherever_it_is() {
    assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
    assert!(first_difference("a\nb\n", "a\nc\n").unwrap().starts_with("line 2"));
    assert!(first_difference("a\n", "a\nc\n").unwrap().starts_with("line 2"));
    assert!(first_difference("a\nc\n", "a\n").unwrap().starts_with("line 2"));
}
