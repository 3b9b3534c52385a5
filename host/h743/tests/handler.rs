//! How many instructions the tick's interrupt takes as a whole, from its vector to its return, in
//! the flash image that BEAMTICK_H743_IMAGE names: the table of docs/numbers.md, "The whole
//! interrupt", under the loads of SPEC 11.
//!
//! In: the image, the page. Out: with BEAMTICK_NUMBERS, the table written anew. A row fails
//! whose worst tick takes more than the page says and [`bound`] allows, or whose lasers go dark
//! where the page does not say so. HANDLER_TICKS says how many ticks of each row are counted at
//! most.
use client::{Client, Options};
use h743::counted::Counted;
use h743::link::{EmulatedLink, Shared, lock};
use h743::{MICROSECOND, MILLISECOND, Machine, Pin, Time};
use protocol::command::{
    AxisOn, BufLaserFollowRatio, BufLaserOn, CrdClear, CrdStart, GetCrdPos, LaserOutFrq, LaserPrfCmd, LaserStatus,
    LnXY, PrfPvt, PvtPoint, PvtStart, PvtTable, PvtTableSelect, SetAxisMode, SetCrdPrm, SetHSIOOpt, SetPvtLoop,
    SetTick,
};
use std::fmt::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// The interrupt of TIM2, as an exception.
const TICK: usize = 16 + 28;
/// Lines of a path.
const LINES: i32 = 150;
/// Ticks of a row where nothing says more.
const TICKS: usize = 300;
/// A row may grow by 3 % and 8 instructions, as those of `cargo xtask ticks` may.
fn bound(stated: u64) -> u64 {
    stated + stated * 3 / 100 + 8
}

const BEGIN: &str = "<!-- handler: written with BEAMTICK_NUMBERS by host/h743/tests/handler.rs -->\n";
const END: &str = "<!-- end of handler -->";
const OVERRAN: &str = "; overran: dark";

/// A row: what runs, and the ticks in µs under which it is counted, with SPEC 11's figure.
struct Load {
    name: &'static str,
    ticks: &'static [(i32, Option<u64>)],
    /// Axes in PVT.
    axes: Range<i16>,
    carriers: bool,
    /// Two coordinate systems, of the axes 1 to 4; the lasers follow them.
    paths: bool,
}

static LOADS: [Load; 6] = [
    Load {
        name: "idle, eight axes enabled",
        ticks: &[(10, Some(1_400)), (250, Some(1_400))],
        axes: 1..1,
        carriers: false,
        paths: false,
    },
    Load {
        name: "two steady carriers of 2 MHz",
        ticks: &[(10, Some(1_900)), (50, Some(1_900)), (250, Some(1_900))],
        axes: 1..1,
        carriers: true,
        paths: false,
    },
    Load {
        name: "eight axes in PVT at up to 1 MHz, which enter segments",
        ticks: &[(20, Some(4_800)), (250, None)],
        axes: 1..9,
        carriers: false,
        paths: false,
    },
    Load {
        name: "the same with two steady carriers of 2 MHz",
        ticks: &[(20, Some(5_300))],
        axes: 1..9,
        carriers: true,
        paths: false,
    },
    Load {
        name: "four axes in PVT, two coordinate systems of two axes, two lasers of 2 MHz that follow",
        ticks: &[(20, Some(6_500)), (50, Some(8_000)), (250, Some(20_000))],
        axes: 5..9,
        carriers: true,
        paths: true,
    },
    Load {
        name: "two carriers of 2 MHz, four axes in PVT",
        ticks: &[(10, Some(3_400)), (20, None)],
        axes: 1..5,
        carriers: true,
        paths: false,
    },
];

/// The board with its interlock's circuit closed.
fn board(elf: &[u8]) -> Shared {
    let mut machine = Machine::new().unwrap();
    machine.boot(elf).unwrap();
    for pin in ["PE15", "PE3", "PG2"] {
        machine.drive(Pin::named(pin).unwrap(), Some(false));
    }
    machine.run(20 * MILLISECOND);
    Arc::new(Mutex::new(machine))
}

/// To and fro between 0 and 8000 pulses, at 1000 pulse/ms at most; all axes enter a segment at the
/// same time.
fn run_axes(client: &Client, axes: Range<i16>) {
    let (core, table) = (1.into(), 1.into());
    let points: Vec<PvtPoint> = [
        (0.0, 0.0, 0.0),
        (4.0, 2000.0, 1000.0),
        (8.0, 6000.0, 1000.0),
        (12.0, 8000.0, 0.0),
        (16.0, 6000.0, -1000.0),
        (20.0, 2000.0, -1000.0),
        (24.0, 0.0, 0.0),
    ]
    .map(|(time, pos, vel): (f64, f64, f64)| PvtPoint { time: time.into(), pos: pos.into(), vel: vel.into() })
    .to_vec();
    let count = (points.len() as i32).into();
    client.call_items(PvtTable { core, table, count, first: 0.into() }, &points).unwrap();
    for axis in axes.clone() {
        let profile = axis.into();
        client.call(PrfPvt { core, profile }).unwrap();
        client.call(SetPvtLoop { core, profile, loop_count: 0.into() }).unwrap();
        client.call(PvtTableSelect { core, profile, table }).unwrap();
    }
    client.call(PvtStart { core, mask: axes.fold(0, |mask, axis| mask | 1 << (axis - 1)).into() }).unwrap();
}

/// Lines of 2 ms whose speeds go from 400 to 500 pulse/ms and back: the power changes in every
/// tick.
fn fill_paths(client: &Client) {
    let (core, fifo) = (1.into(), 0.into());
    for (crd, channel, axes) in [(1i16, 0i16, 0), (2, 1, 2)] {
        let (crd, channel) = (crd.into(), channel.into());
        let mut profile = [0.into(); 8];
        (profile[axes], profile[axes + 1]) = (1.into(), 2.into());
        client
            .call(SetCrdPrm {
                core,
                crd,
                dimension: 2.into(),
                profile,
                syn_vel_max: 500.0.into(),
                syn_acc_max: 1000.0.into(),
                even_time_ms: 0.into(),
                set_origin_flag: 1.into(),
                origin_pos: [0.into(); 8],
            })
            .unwrap();
        client.call(CrdClear { core, crd, fifo }).unwrap();
        let (ratio, min, max) = (0.1.into(), 0.0.into(), 100.0.into());
        client.call(BufLaserFollowRatio { core, crd, ratio, min, max, fifo, channel }).unwrap();
        client.call(BufLaserOn { core, crd, fifo, channel }).unwrap();
        for line in 1..=LINES {
            let vel = if line % 2 == 0 { 400.0 } else { 500.0 };
            let (x, y) = ((720 * line).into(), (540 * line).into());
            let (syn_vel, syn_acc, vel_end) = (500.0.into(), 50.0.into(), if line < LINES { vel } else { 0.0 }.into());
            client.call(LnXY { core, crd, x, y, syn_vel, syn_acc, vel_end, fifo }).unwrap();
        }
    }
}

/// The instructions of each tick, of `count` at most, and whether a tick overran, which ends the
/// light.
fn counted(elf: &[u8], load: &Load, tick_us: i32, count: usize) -> (Vec<u64>, bool) {
    let shared = board(elf);
    let client = Client::open(Box::new(EmulatedLink::new(shared.clone())), Options::default()).unwrap();
    let core = 1.into();
    client.call(SetTick { tick_us: tick_us.into() }).unwrap();
    for axis in 1..=8i16 {
        client.call(AxisOn { core, axis: axis.into() }).unwrap();
    }
    for (axis, channel) in [(7i16, 0i16), (8, 1)].into_iter().filter(|_| load.carriers) {
        let channel = channel.into();
        client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() }).unwrap();
        client.call(LaserOutFrq { core, frequency: 2000.0.into(), channel }).unwrap();
        client.call(LaserPrfCmd { core, power: 33.3.into(), channel }).unwrap();
    }
    // One after the other: what begins takes a tick longer than what goes on.
    let settle = || lock(&shared).run(5 * MILLISECOND);
    if !load.axes.is_empty() {
        run_axes(&client, load.axes.clone());
        settle();
    }
    if load.paths {
        fill_paths(&client);
        for mask in [1i16, 2] {
            settle();
            client.call(CrdStart { core, mask: mask.into(), option: 0.into() }).unwrap();
        }
    }
    for channel in (0..2i16).filter(|_| load.carriers && !load.paths) {
        // A tick that overran keeps the lasers dark, which is asked at the end.
        let _ = client.call(SetHSIOOpt { core, value: 1.into(), channel: channel.into() });
        settle();
    }
    let lasts = tick_us as Time * MICROSECOND;
    settle();
    {
        let mut machine = lock(&shared);
        machine.chip.counted = Some(Counted::of(TICK));
        // The paths go on so long.
        let ticks = (count as Time).min((2 * LINES as Time - 50) * MILLISECOND / lasts);
        machine.run(lasts * ticks);
    }
    let runs = lock(&shared).chip.counted.take().unwrap().runs;
    let is_lit = |channel: i16| client.call(LaserStatus { core, channel: channel.into() }).unwrap().light == 1;
    let dark = load.carriers && !(is_lit(0) && is_lit(1));
    if load.paths && !dark {
        let at = || client.call_items(GetCrdPos { core, crd: 1.into() }, &[]).unwrap().1;
        let before = at();
        lock(&shared).run(MILLISECOND);
        assert_ne!(at(), before, "the path has ended");
    }
    (runs, dark)
}

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/numbers.md")
}

#[test]
fn the_whole_interrupt_takes_what_the_page_says() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return;
    };
    let elf = std::fs::read(path).unwrap();
    let count = std::env::var("HANDLER_TICKS").ok().and_then(|count| count.parse().ok()).unwrap_or(TICKS);
    let text = std::fs::read_to_string(page()).unwrap();
    let (before, rest) = text.split_once(BEGIN).unwrap();
    let (stated, after) = rest.split_once(END).unwrap();
    let mut table = String::from(
        "| load | tick | best | median | worst | SPEC 11 | of the tick, an instruction a cycle | ticks counted |\n\
         | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    let mut longer = Vec::new();
    let rows = |load: &'static Load| load.ticks.iter().map(|(us, _)| counted(&elf, load, *us, count)).collect();
    let measured: Vec<Vec<_>> = std::thread::scope(|scope| {
        let threads = LOADS.each_ref().map(|load| scope.spawn(|| rows(load)));
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    for (load, measured) in LOADS.iter().zip(measured) {
        for (&(tick_us, goal), (mut runs, dark)) in load.ticks.iter().zip(measured) {
            runs.sort_unstable();
            let (best, median, worst) = (runs[0], runs[runs.len() / 2], runs[runs.len() - 1]);
            let goal =
                goal.map_or("–".into(), |goal| format!("{goal}{}", if worst > goal { ", not reached" } else { "" }));
            let begin = format!("| {} | {tick_us} µs | ", load.name);
            let goal = if dark { format!("{goal}{OVERRAN}") } else { goal };
            let share = worst as f64 / f64::from(tick_us) / 4.8;
            let row = format!("{begin}{best} | {median} | {worst} | {goal} | {share:.0} % | {} |", runs.len());
            println!("{row}");
            writeln!(table, "{row}").unwrap();
            let said = stated.lines().find_map(|line| line.strip_prefix(&begin));
            let may_overrun = said.is_some_and(|row| row.contains(OVERRAN));
            match said.and_then(|row| row.split(" | ").nth(2)).and_then(|worst| worst.parse().ok()) {
                Some(said) if worst <= bound(said) && (may_overrun || !dark) => {}
                said => {
                    let name = load.name;
                    longer.push(format!("{name}, {tick_us} µs: {worst}, dark: {dark}; the page says {said:?}"));
                }
            }
        }
    }
    if std::env::var_os("BEAMTICK_NUMBERS").is_some() {
        std::fs::write(page(), format!("{before}{BEGIN}{table}{END}{after}")).unwrap();
        return;
    }
    assert!(longer.is_empty(), "longer than docs/numbers.md says: {longer:#?}");
}
