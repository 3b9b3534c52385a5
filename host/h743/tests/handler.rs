//! How many instructions the tick's interrupt takes as a whole, from its vector to its return, in
//! the flash image that BEAMTICK_H743_IMAGE names: the table of docs/numbers.md, "The whole
//! interrupt", under the loads of SPEC 11.
//!
//! In: the image, the page. Out: with BEAMTICK_NUMBERS, the table written anew. A row fails
//! whose worst tick takes more than the page says and [`bound`] allows, or whose lasers go dark
//! where the page does not say so. HANDLER_TICKS says how many ticks of each row are counted at
//! most.
mod loads;

use h743::counted::Counted;
use h743::link::lock;
use h743::machine::Chip;
use h743::{MICROSECOND, MILLISECOND};
use loads::{LOADS, Load, TICK};
use protocol::command::{
    Abort, AxisOn, ClrLaserFault, GetLaserFault, LaserOn, LaserPrfCmd, LaserStatus, ProgramStatus, Reset, SetAxisMode,
    SetTick,
};
use protocol::values::laser_fault;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Ticks of a row where nothing says more.
const TICKS: usize = 300;
/// A row may grow by 3 % and 8 instructions, as those of `cargo xtask ticks` may.
fn bound(stated: u64) -> u64 {
    stated + stated * 3 / 100 + 8
}

const BEGIN: &str = "<!-- handler: written with BEAMTICK_NUMBERS by host/h743/tests/handler.rs -->\n";
const END: &str = "<!-- end of handler -->";
const OVERRAN: &str = "; overran: dark";

/// The instructions of each tick, of `count` at most, and whether a tick overran, which ends the
/// light.
fn counted(elf: &[u8], load: &Load, tick_us: i32, count: usize) -> (Vec<u64>, bool) {
    let begin = |chip: &mut Chip| chip.counted = Some(Counted::of(TICK));
    let end = |chip: &mut Chip| chip.counted.take().unwrap().runs;
    loads::start(elf, load, tick_us, false).run(load, tick_us, count, begin, end)
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

/// The shortest ticks, while both lasers have a fault and all axes have moved: the timers stop at a
/// tick that takes too long, and each tick of their next start has the time for it.
#[test]
fn lasers_start_again_in_the_shortest_ticks() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return;
    };
    let elf = std::fs::read(path).unwrap();
    let loads::Loaded { shared, client } = loads::start(&elf, &LOADS[2], 20, false);
    let core = 1.into();
    client.call(Abort { core }).unwrap();
    lock(&shared).run(300 * MILLISECOND);
    client.call(Reset { core }).unwrap();
    client.call(SetTick { tick_us: 10.into() }).unwrap();
    for axis in 1..=8i16 {
        client.call(AxisOn { core, axis: axis.into() }).unwrap();
    }
    {
        let mut machine = lock(&shared);
        machine.run(5 * MILLISECOND);
        while machine.running() != TICK {
            machine.run(1);
        }
        machine.run(MICROSECOND);
        assert_eq!(machine.running(), TICK);
        machine.chip.now += 25 * MICROSECOND;
        machine.run(5 * MILLISECOND);
    }
    let overruns = || client.call(ProgramStatus {}).unwrap().overruns.get();
    let before = overruns();
    assert_ne!(before, 0);
    lock(&shared).run(20 * MILLISECOND);
    assert_eq!(overruns(), before, "ticks overrun for ever");
    for (axis, channel) in [(7i16, 0i16), (8, 1)] {
        let channel = channel.into();
        assert_eq!(client.call(GetLaserFault { core, channel }).unwrap().value.get(), laser_fault::OVERRUN);
        client.call(ClrLaserFault { core, channel }).unwrap();
        client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() }).unwrap();
        client.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
    }
    client.call(LaserOn { core, channel: 0.into() }).unwrap();
    lock(&shared).run(MILLISECOND);
    let lit = client.call(LaserStatus { core, channel: 0.into() }).unwrap();
    assert_eq!((lit.light, lit.fault.get()), (1, 0));
}
