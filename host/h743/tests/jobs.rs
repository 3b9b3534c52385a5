//! Jobs of the examples on the emulated board, over its USART or USB at the chip's time, if
//! BEAMTICK_H743_IMAGE names the image. Every row of the trace, and every change of lasers and
//! outputs that the tick planned, equals that of the virtual controller. So does every edge at the
//! pins, as timers and DMA make it. Light, steps and outputs of one job have the planned times
//! relative to each other.
//!
//! The trace uses the same link as the calls. That carries a row every tick of 250 µs, but not of
//! 50. There both controllers write a row every few ticks, and the steps at the pins are compared
//! with a separate trace of the virtual controller. What a job prints is not compared: a read
//! outside of a program falls on another tick.
mod signals;

use h743::board::{Board, MODULE, NUCLEO};
use h743::bus::BREAKS;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{MICROSECOND, MILLISECOND, Machine, Pin};
use signals::Pins;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// The trapezoid of the listing of PT takes 3 s, which cost a minute of emulation: an eighth of it,
/// with the same speeds.
const EIGHTH: [(&str, &str); 3] = [("1024;", "128;"), ("2048;", "256;"), ("Sleep(1536);", "Sleep(192);")];

/// A thirtieth of the ways of a path with light, forwards all the way (before a step back its
/// direction takes some time), and an output that goes with the light.
const SHORT: [(&str, &str); 7] = [
    ("100000, 0, 50", "3333, 0, 50"),
    ("0, 10000, 50", "6500, 333, 50"),
    ("Sleep(1000);", "Sleep(30);"),
    ("Sleep(2000);", "Sleep(70);"),
    // A row after the last edge.
    ("rtn = GT_GetLaserOnTime(0, &units);", "Sleep(10);"),
    ("rtn = GT_BufLaserOn(1, 0, 0);", "rtn = GT_BufLaserOn(1, 0, 0); rtn = GT_BufIO(1, 12, 4, 4, 0);"),
    ("rtn = GT_BufLaserOff(1, 0, 0);", "rtn = GT_BufLaserOff(1, 0, 0); rtn = GT_BufIO(1, 12, 4, 0, 0);"),
];

/// The example in a folder.
fn prepared(name: &str, folder: &Path) -> PathBuf {
    let mut text = std::fs::read_to_string(example(name)).unwrap();
    let shorter = match name {
        "pt_static" => &EIGHTH[..],
        "laser_path_power" => &SHORT,
        _ => &[],
    };
    for (all, part) in shorter {
        assert!(text.contains(all), "{name} has no {all}");
        text = text.replace(all, part);
    }
    let path = folder.join(name).with_extension("gts");
    std::fs::write(&path, text).unwrap();
    std::fs::copy(example(name).with_file_name("test.cfg"), folder.join("test.cfg")).unwrap();
    path
}

/// A job, its tick in µs, ticks from row to row.
type Case = (&'static str, &'static str, &'static str);

/// The wire of the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wire {
    Usart,
    Usb,
}

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

/// A board with an image.
struct Bench {
    /// The variable that names the image.
    image: &'static str,
    /// What is around the chip.
    board: Board,
    pins: Pins,
    /// Its analog outputs are those of a DAC8563.
    has_dac: bool,
}

const REFERENCE: Bench = Bench { image: "BEAMTICK_H743_IMAGE", board: NUCLEO, pins: signals::NUCLEO, has_dac: false };
const EXTERNAL: Bench = Bench { image: "BEAMTICK_H743_DAC_IMAGE", has_dac: true, ..REFERENCE };
const SECOND: Bench = Bench { image: "BEAMTICK_H743VI_IMAGE", board: MODULE, pins: signals::MODULE, has_dac: false };
const SECOND_EXTERNAL: Bench = Bench { image: "BEAMTICK_H743VI_DAC_IMAGE", has_dac: true, ..SECOND };

/// The board with this image, its interlock's circuit closed.
fn started(bench: &Bench, elf: &[u8], wire: Wire) -> Shared {
    let mut machine = Machine::on(bench.board).unwrap();
    machine.boot(elf).unwrap();
    for (_, pin, _) in BREAKS {
        machine.drive(Pin::named(pin).unwrap(), Some(false));
    }
    machine.run(20 * MILLISECOND);
    if wire == Wire::Usb {
        machine.plug_usb(true);
        machine.run(50 * MILLISECOND);
        assert!(machine.chip.bus.usb.host.is_open, "no port at USB");
    }
    Arc::new(Mutex::new(machine))
}

/// The stack, painted below where the thread waits.
struct Paint {
    end: u32,
    from: u32,
}

const COLOUR: u32 = 0x5afe_57ac;

impl Paint {
    fn put(elf: &[u8], machine: &Machine) -> Paint {
        let end = h743::image::symbol(elf, "_stack_end").unwrap();
        let from = machine.register(h743::engine::Register::Msp) & !3;
        assert_eq!(machine.running(), 0);
        (end..from).step_by(4).for_each(|at| assert!(machine.chip.memory.load(at, &COLOUR.to_le_bytes())));
        Paint { end, from }
    }

    /// Bytes of the stack that were never used.
    fn left(&self, machine: &Machine) -> u32 {
        let used = (self.end..self.from).step_by(4).find(|&at| machine.chip.memory.word(at) != Some(COLOUR));
        used.unwrap_or(self.from) - self.end
    }
}

/// Runs a job both ways. `has_steps`: its steps at the pins are compared too. They are as planned
/// where no axis turns round, which takes the time of [`SHORT`]'s comment.
fn compare(bench: &Bench, elf: &[u8], wire: Wire, (name, tick_us, every): Case, has_steps: bool) {
    let began = Instant::now();
    let folder = tempfile::tempdir().unwrap();
    let job = prepared(name, folder.path()).display().to_string();
    let files = |way: &str| ["csv", "vcd"].map(|end| folder.path().join(format!("{name}-{way}.{end}")));
    let [simulated, emulated] = ["sim", "chip"].map(files);
    let family = if name.starts_with("laser_lsr") { "lsr" } else { "gus" };
    let words = |files: &[PathBuf; 2]| {
        let [csv, vcd] = files.each_ref().map(|path| path.display().to_string());
        let words = [&*job, "--quiet", "--tick-us", tick_us, "--every", every, "--family", family];
        words.into_iter().map(String::from).chain(["--trace".into(), csv, "--vcd".into(), vcd]).collect::<Vec<_>>()
    };
    let of_sim = words(&simulated);
    beamtick::call(&["sim"].into_iter().chain(of_sim.iter().map(String::as_str)).collect::<Vec<_>>()).unwrap();
    let each = folder.path().join("each.csv").display().to_string();
    beamtick::call(&["sim", &job, "--quiet", "--tick-us", tick_us, "--family", family, "--trace", &each]).unwrap();
    let each = std::fs::read_to_string(each).unwrap();

    let machine = started(bench, elf, wire);
    while lock(&machine).running() != 0 {
        lock(&machine).run(1);
    }
    let paint = Paint::put(elf, &lock(&machine));
    let of_chip = words(&emulated);
    let of_chip: Vec<&str> = of_chip.iter().map(String::as_str).collect();
    let link = match wire {
        Wire::Usart => EmulatedLink::new(machine.clone()),
        Wire::Usb => EmulatedLink::over_usb(machine.clone()),
    };
    beamtick::run_over(Box::new(link), &of_chip).unwrap();

    let machine = lock(&machine);
    let chip = &machine.chip;
    assert_eq!(chip.bus.complaints, Vec::<String>::new(), "{name}");
    assert_eq!((chip.bus.usart.lost, chip.bus.dma.lost), (0, 0), "{name}: bytes of the link, requests of DMA");
    let [csv, vcd] = [0, 1].map(|n| {
        let [one, other] = [&simulated[n], &emulated[n]].map(|path| std::fs::read_to_string(path).unwrap());
        assert!(one.lines().count() > 5, "{name} leaves no trace");
        if let Some(difference) = first_difference(&one, &other) {
            panic!("{name} at {tick_us} µs: {difference}");
        }
        one
    });
    let pins = &bench.pins;
    let failed = |error: String| -> ! { panic!("{name} at {tick_us} µs: {error}") };
    let tick: u64 = tick_us.parse().unwrap();
    let (edges, of_light) = signals::compare(pins, &vcd, chip).unwrap_or_else(|error| failed(error));
    let steps = if has_steps && each.starts_with("t_ms,axis1_pos") {
        signals::compare_steps(pins, &each, tick, chip)
    } else {
        Ok((0, None))
    };
    let (steps, of_steps) = steps.unwrap_or_else(|error| failed(error));
    if let (Some(of_light), Some(of_steps)) = (of_light, of_steps) {
        // What the slots of the steps leave open.
        let apart = (of_light - of_steps).unsigned_abs();
        assert!(apart <= u128::from(MICROSECOND), "{name} at {tick_us} µs: light is {apart} units off the steps");
        let outputs = signals::compare_outputs(pins, &vcd, tick, of_light, chip).unwrap_or_else(|error| failed(error));
        assert!(outputs > 0, "{name} switches no output");
        println!("light lies {apart} units off the steps, {outputs} edges of outputs in their ticks");
    }
    let voltages =
        signals::compare_voltages(pins, &vcd, tick, bench.has_dac, chip).unwrap_or_else(|error| failed(error));
    assert_eq!(voltages > 0, name.contains("analog"), "{name}");
    let left = paint.left(&machine);
    assert!(left >= 512, "{name}: {left} bytes of the stack are left");
    println!(
        "{name} at {tick_us} µs: {} lines, {edges} edges of lasers, {voltages} voltages and {steps} steps at the pins, {left} bytes of stack left; {} ms of the chip, {} \
         million instructions in {:.1} s",
        csv.lines().count(),
        chip.now / MILLISECOND,
        chip.instructions / 1_000_000,
        began.elapsed().as_secs_f64()
    );
}

fn compare_all(bench: &Bench, wire: Wire, cases: &[Case]) {
    compare_each(bench, wire, cases, true);
}

fn compare_each(bench: &Bench, wire: Wire, cases: &[Case], has_steps: bool) {
    let Some(path) = std::env::var_os(bench.image) else {
        println!("skipped: {} names no image", bench.image);
        return;
    };
    let elf = std::fs::read(path).unwrap();
    cases.iter().for_each(|case| compare(bench, &elf, wire, *case, has_steps));
}

#[test]
fn an_external_dac_shows_the_voltages_of_the_virtual_controller() {
    compare_all(&EXTERNAL, Wire::Usart, &[("laser_analog", "50", "5")]);
    compare_all(&SECOND_EXTERNAL, Wire::Usb, &[("laser_analog", "50", "5")]);
}

#[test]
fn a_listing_of_pt_moves_as_in_the_virtual_controller() {
    compare_all(&REFERENCE, Wire::Usart, &[("pt_static", "250", "1")]);
}

#[test]
fn a_job_over_usb_is_the_job_over_the_usart() {
    compare_all(&REFERENCE, Wire::Usb, &[("laser_duty", "50", "5")]);
}

#[test]
fn listings_of_lasers_shine_as_in_the_virtual_controller() {
    compare_all(
        &REFERENCE,
        Wire::Usart,
        &[
            ("laser_duty", "50", "5"),
            ("laser_frequency", "50", "5"),
            ("laser_analog", "50", "5"),
            ("laser_lsr_duty", "50", "5"),
        ],
    );
}

/// The board has eight axes.
#[test]
fn a_job_with_an_axis_that_the_board_lacks_is_refused_by_line_and_axis() {
    let Ok(image) = std::env::var(REFERENCE.image) else { return };
    let machine = started(&REFERENCE, &std::fs::read(image).unwrap(), Wire::Usart);
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("nine.gts");
    std::fs::write(&job, "GT_AxisOn(1);\nGT_AxisOn(9);\nGT_AxisOn(10);\n").unwrap();
    let ran = beamtick::run_over(Box::new(EmulatedLink::new(machine)), &[job.to_str().unwrap()]);
    let Err(beamtick::Failure::Job(text)) = ran else { panic!("{ran:?}") };
    assert!(text.contains("room for 8 axes, 24 are asked for"), "{text}");
    assert!(text.contains("The job's line 2 names axis 9, which profile gtn-024 holds; --profile NAME"), "{text}");
}

/// A look-ahead takes the thread's deepest stack: [`compare`] checks what is left of it.
#[test]
fn a_contour_through_the_look_ahead_is_the_virtual_controllers() {
    let job = [("laser_contour", "250", "4")];
    compare_each(&REFERENCE, Wire::Usb, &job, false);
    compare_each(&SECOND, Wire::Usb, &job, false);
}

#[test]
fn light_and_outputs_go_with_the_steps() {
    compare_all(&REFERENCE, Wire::Usart, &[("laser_path_power", "50", "20"), ("laser_path_power", "250", "20")]);
}

#[test]
fn the_second_board_does_what_the_virtual_controller_does() {
    let over_usb = [
        ("pt_static", "250", "1"),
        ("laser_duty", "50", "5"),
        ("laser_analog", "50", "5"),
        ("laser_path_power", "250", "20"),
    ];
    compare_all(&SECOND, Wire::Usb, &over_usb);
    compare_all(&SECOND, Wire::Usart, &[("laser_frequency", "50", "5")]);
}

/// Examples of some ms, which always run, and some of a second or so, one of which runs a day,
/// another one the next day. BEAMTICK_H743_TRACES names others, with commas between them, or `all`
/// of these and of [`ON_REQUEST`].
const ALWAYS: [&str; 3] = ["laser_duty_open", "laser_lsr_analog", "laser_lsr_frequency"];
const IN_TURN: [&str; 4] = ["arcs", "interrupt", "jog_trap", "override"];
/// 20 minutes of emulation in all.
const ON_REQUEST: [&str; 16] = [
    "eight_axes_stream",
    "follow_ex",
    "follow_ex_switch",
    "follow_shear",
    "follow_single",
    "follow_switch",
    "laser_flying_shear",
    "laser_lsr_path_power",
    "laser_path_follow",
    "pt_dynamic",
    "pvt_complete",
    "pvt_continuous",
    "pvt_percent",
    "pvt_points",
    "square_with_corners",
    "stop",
];
/// Not comparable: ten axes; set-up of more than one tick; inputs by a call; a third analog output;
/// a look-ahead longer than the board's; ten minutes. Two have a power by encoders, which stand
/// here, or by a distance: its edges differ by a ns in the VCD, since the board's clock has no
/// whole ns.
const LEFT_OUT: [&str; 10] = [
    "follow_chain",
    "follow_masters",
    "inputs",
    "laser_distance",
    "laser_lsr_distance",
    "laser_lsr_path_follow",
    "laser_path_mixed",
    "spiral",
    "ten_minutes",
    "ten_minutes_lasers",
];

#[test]
fn the_other_examples_in_turn_are_the_virtual_controllers() {
    let named = std::env::var("BEAMTICK_H743_TRACES").ok().map(|named| &*named.leak());
    let day = std::time::UNIX_EPOCH.elapsed().unwrap().as_secs() as usize / 86_400;
    let names: Vec<&str> = match named {
        Some("all") => ALWAYS.into_iter().chain(IN_TURN).chain(ON_REQUEST).collect(),
        Some(named) => named.split(',').collect(),
        None => ALWAYS.into_iter().chain([IN_TURN[day % IN_TURN.len()]]).collect(),
    };
    println!("{names:?}");
    let every = |name: &str| match name {
        // Its data fill the link: acknowledgements wait behind them, and with them the rows.
        "eight_axes_stream" => "40",
        _ if ALWAYS.contains(&name) => "1",
        _ => "4",
    };
    // Light that changes in each tick fills the USART.
    let (usb, usart): (Vec<&str>, Vec<&str>) = names.into_iter().partition(|name| ON_REQUEST.contains(name));
    for (wire, names) in [(Wire::Usart, usart), (Wire::Usb, usb)] {
        let cases: Vec<Case> = names.into_iter().map(|name| (name, "250", every(name))).collect();
        compare_each(&REFERENCE, wire, &cases, false);
    }
}

/// A new example is in one of the lists.
#[test]
fn no_example_is_forgotten() {
    let listed = [
        "laser_analog",
        "laser_contour",
        "laser_duty",
        "laser_frequency",
        "laser_lsr_duty",
        "laser_path_power",
        "pt_static",
    ];
    let all = ALWAYS.into_iter().chain(IN_TURN).chain(ON_REQUEST).chain(LEFT_OUT).chain(listed);
    let mut known: Vec<&str> = all.collect();
    known.sort_unstable();
    let folder = std::fs::read_dir(example("jog_trap").parent().unwrap()).unwrap();
    let files =
        folder.map(|entry| entry.unwrap().path()).filter(|path| path.extension().is_some_and(|end| end == "gts"));
    let mut there: Vec<String> = files.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    there.sort_unstable();
    assert_eq!(known, there);
}

#[test]
fn a_difference_is_found_wherever_it_is() {
    assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
    assert!(first_difference("a\nb\n", "a\nc\n").unwrap().starts_with("line 2"));
    assert!(first_difference("a\n", "a\nc\n").unwrap().starts_with("line 2"));
    assert!(first_difference("a\nc\n", "a\n").unwrap().starts_with("line 2"));
}
