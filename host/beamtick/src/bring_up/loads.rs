//! How long the servo ticks of the board's own image take: under each load a row with the running
//! median, the longest and a histogram, by [`GetTickTime`].
//!
//! In: a link to the board's own image, jumper 6. Out: a section of the page, in place of the one
//! of a run before. The board measures from the timer's event to the end of the handler, by the
//! timer's count. Nothing moves or lights on a board that measures no ticks, or before [`jumper`]
//! has shown that this is a bench. However it ends, [`restore`] leaves the board dark and at rest,
//! with its limits and alarms. Fails: a board that is refused, a load that does not run, a tick
//! that took longer than its period.
use super::jumper;
use super::lines::Figures;
use super::page::{self, Older};
use crate::Failure;
use crate::interrupt::{self, Held};
use client::{Client, Link, LinkCounters, Options};
use protocol::command::{
    Abort, AlarmOff, AxisOn, BufLaserFollowRatio, BufLaserOn, ClrSts, CrdClear, CrdStart, GetClock, GetTickTime,
    LaserOutFrq, LaserPrfCmd, LmtsOff, LnXY, PrfPvt, PvtPoint, PvtStart, PvtTable, PvtTableSelect, Reset, SetAxisMode,
    SetCrdPrm, SetHSIOOpt, SetPvtLoop,
};
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;
use std::time::Duration;

/// How long a load is measured.
const LASTS_MS: u32 = 50;
/// How often the clock is asked.
const POLL: Duration = Duration::from_millis(1);
/// In this time what an Abort stops is at rest.
const REST_MS: u32 = 20;
/// What a board hears that measures no ticks.
const REFUSED: &str = "measures no ticks, so it is no reference board with its own image: nothing was moved or lit. \
    Flash that image (`cargo flash-board`) onto a board that is connected to nothing but jumpers";
/// The page's section.
const HEADING: &str = "## Ticks under load";

/// A load: its name, the axes that run in PVT, the frequency of both lasers in kHz, and whether two
/// coordinate systems of the axes 1 to 4 run, whose speeds the lasers follow.
struct Load {
    name: &'static str,
    axes: Range<i16>,
    light_khz: Option<f64>,
    paths: bool,
}

const NO_AXES: Range<i16> = 1..1;
const ALL: Range<i16> = 1..9;
/// All streams are busy.
const BUSIEST: Load =
    Load { name: "eight axes in PVT, two lasers at 2 MHz", axes: ALL, light_khz: Some(2000.0), paths: false };
const LOADS: [Load; 6] = [
    Load { name: "nothing runs", axes: NO_AXES, light_khz: None, paths: false },
    Load { name: "two lasers at 10 kHz", axes: NO_AXES, light_khz: Some(10.0), paths: false },
    Load { name: "two lasers at 2 MHz", axes: NO_AXES, light_khz: Some(2000.0), paths: false },
    Load { name: "eight axes in PVT", axes: ALL, light_khz: None, paths: false },
    BUSIEST,
    Load {
        name: "two paths, two axes in PVT, two lasers at 2 MHz that follow",
        axes: 5..7,
        light_khz: Some(2000.0),
        paths: true,
    },
];

/// The counts of a histogram, and what they count.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Ticks {
    period_ns: u32,
    median_ns: u32,
    bucket_ns: u32,
    counts: Vec<u32>,
}

/// Measures, keeps the link busy for `soak_s` seconds, and writes the section.
pub fn over(mut link: Box<dyn Link>, soak_s: Option<u32>, page: Option<&Path>) -> Result<(), Failure> {
    let mut failed = 0;
    let is_usb = link.is_boards_usb();
    page::write(page, Older::GoesOn, |before| {
        let client = Client::open(link, Options::default())?;
        if ticks(&client)?.is_none() {
            return Err(Failure::Job(format!("{} {REFUSED}", client.board())));
        }
        // A signal ends it through `interrupted`, so that the board is restored.
        let held = Held::new();
        let all = jumper::prove(&client, &interrupted)
            .and_then(|()| then_restored(&client, || under_loads(&client, soak_s, &interrupted)));
        drop(held);
        let all = all?;
        let mut figures = Figures::default();
        if let Some(Soak { seconds, calls, lost }) = all.soak {
            figures.add("soak", vec![seconds.into(), calls as i64, lost.into(), is_usb.into()]);
        }
        let (section, late) = section(&client, &all);
        let (settled, lossy) = page::settled(before, &figures)?;
        failed = late + lossy;
        Ok((with_section(&settled, &section), format!("{} loads, {failed} rows failed", LOADS.len())))
    })?;
    match failed {
        0 => Ok(()),
        failed => Err(Failure::Job(format!(
            "{failed} rows failed: ticks took longer than their period, or the link lost some"
        ))),
    }
}

/// The section, and how many rows failed.
fn section(client: &Client, all: &Measured) -> (String, usize) {
    let version = client.version();
    let image = [version.major, version.minor, version.patch].map(|part| part.get().to_string()).join(".");
    let mut text = format!(
        "{HEADING}\n\n{}\n\nThe board's own image, from the timer's event to the end of the handler. On the emulated \
         chip an instruction takes a\ncycle. The histogram has the ticks of each step of time that has any.\n\n\
         | row | assumption | result | figure |\n| --- | --- | --- | --- |\n",
        page::dated(&format!("Board {}, image {image}, over {}", client.board(), client.name()))
    );
    let mut failed = 0;
    for (name, assumption, (holds, figure)) in
        LOADS.iter().zip(&all.ticks).map(|(load, ticks)| (load.name, 21, judged(ticks)))
    {
        failed += usize::from(!holds);
        let result = if holds { "pass" } else { "**FAIL**" };
        // Writing to a string never fails.
        let _ = writeln!(text, "| {name} | {assumption} | {result} | {figure} |");
    }
    (text, failed)
}

/// Fails once a signal has come.
fn interrupted() -> Result<(), Failure> {
    interrupt::came().map_or(Ok(()), |signal| Err(Failure::Interrupted(signal, "the measurement was cut short".into())))
}

/// What is asked at each step of a load whether to go on.
pub type Check<'a> = &'a dyn Fn() -> Result<(), Failure>;

/// What was measured.
#[derive(Debug)]
struct Measured {
    /// Of each load.
    ticks: Vec<Ticks>,
    soak: Option<Soak>,
}

/// What a link did for some time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Soak {
    seconds: u32,
    calls: u64,
    /// Frames that came damaged, and messages that were sent again.
    lost: u32,
}

/// All of it, on a bench.
fn under_loads(client: &Client, soak_s: Option<u32>, check: Check<'_>) -> Result<Measured, Failure> {
    let ticks = LOADS.iter().map(|load| measured(client, load, check)).collect::<Result<_, _>>()?;
    let soak = soak_s.map(|seconds| soak(client, seconds, check)).transpose()?;
    Ok(Measured { ticks, soak })
}

/// Does this; the board is restored however it ends.
fn then_restored<T>(client: &Client, run: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    match (run(), restore(client)) {
        (Err(failure), Err(_)) => {
            complain!("the board did not confirm that it is dark and at rest: take its supply off");
            Err(failure)
        }
        (all, restored) => all.and_then(|all| restored.map(|()| all)),
    }
}

/// Eight axes and both lasers run, while calls follow each other over the link.
fn soak(client: &Client, seconds: u32, check: Check<'_>) -> Result<Soak, Failure> {
    begin(client, &BUSIEST)?;
    let (before, mut calls) = (client.counters(), 0);
    let began = client.call(GetClock {})?.clock_ms.get();
    while client.call(GetClock {})?.clock_ms.get().wrapping_sub(began) < 1000 * seconds {
        check()?;
        ticks(client)?;
        calls += 2;
    }
    is_lit(client, &BUSIEST)?;
    Ok(Soak { seconds, calls, lost: lost(&client.counters()).wrapping_sub(lost(&before)) })
}

/// Frames that came damaged or again.
fn lost(counters: &LinkCounters) -> u32 {
    let LinkCounters { deframe, short, checksum, length, duplicates, timeouts, fast_retransmits, .. } = *counters;
    let damaged = [deframe.too_long, deframe.truncated, short, checksum, length];
    damaged.into_iter().chain([duplicates, timeouts, fast_retransmits]).fold(0, u32::wrapping_add)
}

/// Dark and at rest, and everything as after power-on: limits and alarms too.
fn restore(client: &Client) -> Result<(), Failure> {
    let core = 1.into();
    client.call(Abort { core })?;
    wait(client, REST_MS, &|| Ok(()))?;
    client.call(Reset { core })?;
    Ok(())
}

/// A load begins, from the state after power-on.
fn begin(client: &Client, load: &Load) -> Result<(), Failure> {
    let core = 1.into();
    client.call(Reset { core })?;
    if let Some(khz) = load.light_khz {
        for (axis, channel) in [(7i16, 0i16), (8, 1)] {
            let channel = channel.into();
            client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() })?;
            client.call(LaserOutFrq { core, frequency: khz.into(), channel })?;
            client.call(LaserPrfCmd { core, power: 33.3.into(), channel })?;
            if !load.paths {
                client.call(SetHSIOOpt { core, value: 1.into(), channel })?;
            }
        }
    }
    let axes = load.axes.clone().chain(if load.paths { 1..5 } else { NO_AXES });
    axes.into_iter().try_for_each(|axis| enable(client, axis))?;
    if !load.axes.is_empty() {
        run_axes(client, load.axes.clone())?;
    }
    if load.paths {
        run_paths(client)?;
    }
    Ok(())
}

/// A load whose light ended early is none.
fn is_lit(client: &Client, load: &Load) -> Result<(), Failure> {
    for channel in 0..if load.light_khz.is_some() { 2 } else { 0 } {
        if let Some(cause) = jumper::fault(client, channel)? {
            return Err(Failure::Job(format!("{}: laser {channel} went dark: {cause}", load.name)));
        }
    }
    Ok(())
}

/// The ticks under a load.
fn measured(client: &Client, load: &Load, check: Check<'_>) -> Result<Ticks, Failure> {
    begin(client, load)?;
    // What begins is over, and what follows is compared with it.
    wait(client, 10, check)?;
    let before = ticks(client)?;
    wait(client, LASTS_MS, check)?;
    let after = ticks(client)?;
    is_lit(client, load)?;
    client.call(Abort { core: 1.into() })?;
    wait(client, REST_MS, check)?;
    let (Some(before), Some(after)) = (before, after) else {
        return Err(Failure::Job(format!("{}: the board has stopped to measure its ticks", load.name)));
    };
    let counts = after.counts.iter().zip(&before.counts).map(|(after, before)| after.wrapping_sub(*before)).collect();
    Ok(Ticks { counts, ..after })
}

fn enable(client: &Client, axis: i16) -> Result<(), Failure> {
    let (core, axis) = (1.into(), axis.into());
    // The ends of jumpers are alarms and limits here.
    client.call(AlarmOff { core, axis })?;
    client.call(LmtsOff { core, axis, limit_type: (-1).into() })?;
    client.call(ClrSts { core, axis, count: 1.into() })?;
    client.call(AxisOn { core, axis })?;
    Ok(())
}

/// Both coordinate systems go through lines of 2 ms, at 50 pulse/ms; the duty of each laser is 33 %
/// at that speed.
fn run_paths(client: &Client) -> Result<(), Failure> {
    const LINES: i32 = 64;
    let (core, fifo) = (1.into(), 0.into());
    for (crd, channel, axes) in [(1i16, 0i16, 0), (2, 1, 2)] {
        let (crd, channel) = (crd.into(), channel.into());
        let mut profile = [0.into(); 8];
        (profile[axes], profile[axes + 1]) = (1.into(), 2.into());
        client.call(SetCrdPrm {
            core,
            crd,
            dimension: 2.into(),
            profile,
            syn_vel_max: 100.0.into(),
            syn_acc_max: 100.0.into(),
            even_time_ms: 0.into(),
            set_origin_flag: 1.into(),
            origin_pos: [0.into(); 8],
        })?;
        client.call(CrdClear { core, crd, fifo })?;
        let (ratio, min, max) = ((100.0 / 150.0).into(), 0.0.into(), 100.0.into());
        client.call(BufLaserFollowRatio { core, crd, ratio, min, max, fifo, channel })?;
        client.call(BufLaserOn { core, crd, fifo, channel })?;
        for line in 1..=LINES {
            let vel_end = if line < LINES { 50.0 } else { 0.0 }.into();
            let (x, y) = ((80 * line).into(), (60 * line).into());
            client.call(LnXY { core, crd, x, y, syn_vel: 50.0.into(), syn_acc: 50.0.into(), vel_end, fifo })?;
        }
    }
    client.call(CrdStart { core, mask: 3.into(), option: 0.into() })?;
    Ok(())
}

/// These axes go to and fro.
fn run_axes(client: &Client, axes: Range<i16>) -> Result<(), Failure> {
    let (core, table) = (1.into(), 1.into());
    let points: Vec<PvtPoint> =
        [(0.0, 0.0, 0.0), (20.0, 400.0, 40.0), (40.0, 800.0, 0.0), (60.0, 400.0, -40.0), (80.0, 0.0, 0.0)]
            .map(|(time, pos, vel): (f64, f64, f64)| PvtPoint { time: time.into(), pos: pos.into(), vel: vel.into() })
            .to_vec();
    client.call_items(PvtTable { core, table, count: (points.len() as i32).into(), first: 0.into() }, &points)?;
    for axis in axes.clone() {
        let profile = axis.into();
        client.call(PrfPvt { core, profile })?;
        client.call(SetPvtLoop { core, profile, loop_count: 0.into() })?;
        client.call(PvtTableSelect { core, profile, table })?;
    }
    client.call(PvtStart { core, mask: axes.fold(0, |mask, axis| mask | 1 << (axis - 1)).into() })?;
    Ok(())
}

/// Waits for so much of the controller's time.
pub fn wait(client: &Client, ms: u32, check: Check<'_>) -> Result<(), Failure> {
    let began = client.call(GetClock {})?.clock_ms.get();
    while client.call(GetClock {})?.clock_ms.get().wrapping_sub(began) < ms {
        check()?;
        client.sleep(POLL)?;
    }
    Ok(())
}

fn ticks(client: &Client) -> Result<Option<Ticks>, Failure> {
    let (reply, counts) = client.call_items(GetTickTime {}, &[])?;
    Ok((reply.measured != 0).then(|| Ticks {
        period_ns: reply.period_ns.get(),
        median_ns: reply.median_ns.get(),
        bucket_ns: reply.bucket_ns.get(),
        counts: counts.iter().map(|count| count.value.get()).collect(),
    }))
}

/// Whether each tick fitted into its period, and the figure.
fn judged(ticks: &Ticks) -> (bool, String) {
    let us = |ns: u64| ns as f64 / 1000.0;
    let last = ticks.counts.iter().rposition(|count| *count > 0).unwrap_or(0);
    let end_ns = (last as u64 + 1) * u64::from(ticks.bucket_ns);
    // The last count has no end.
    let holds = last + 1 < ticks.counts.len() && end_ns <= u64::from(ticks.period_ns);
    let histogram: Vec<String> = ticks
        .counts
        .iter()
        .enumerate()
        .filter(|(_, count)| **count > 0)
        .map(|(bucket, count)| format!("{count} from {:.1} us", us(bucket as u64 * u64::from(ticks.bucket_ns))))
        .collect();
    let longest =
        if last + 1 < ticks.counts.len() { format!("below {:.1} us", us(end_ns)) } else { "longer".to_owned() };
    let median = us(ticks.median_ns.into());
    (holds, format!("median {median:.2} us of {}, all {longest}: {}", us(ticks.period_ns.into()), histogram.join(", ")))
}

/// The page with this section at its end, in place of the one it had.
fn with_section(page: &str, section: &str) -> String {
    let kept = page.split(HEADING).next().unwrap_or("").trim_end();
    format!("{kept}\n\n{section}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::command::{AxisStatus, GetLaserOnTime, LaserStatus};
    use protocol::values::status;
    use std::cell::{Cell, RefCell};
    use virtual_board::{Board, Config, VirtualLink, share};

    fn opened(board: &virtual_board::Shared) -> Client {
        Client::open(Box::new(VirtualLink::new(board.clone())), Options::default()).unwrap()
    }

    type State = (Vec<(u32, u8)>, Vec<(u32, f64)>);

    /// Of each laser: how long it was lit, and whether it is; of each axis, its status and
    /// position.
    fn state(client: &Client) -> State {
        let core = 1.into();
        let lasers = (0..2i16).map(|channel| {
            let lit = client.call(GetLaserOnTime { core, channel: channel.into() }).unwrap().value.get();
            (lit, client.call(LaserStatus { core, channel: channel.into() }).unwrap().light)
        });
        let axes = client.call_items(AxisStatus { core, axis: 1.into(), count: 8.into() }, &[]).unwrap().1;
        let axes = axes.iter().map(|axis| (axis.status.get(), axis.prf_pos.get()));
        (lasers.collect(), axes.collect())
    }

    #[test]
    fn a_controller_that_measures_no_ticks_is_refused_dark_and_at_rest() {
        let board = share(Board::new(Config::default()));
        let before = state(&opened(&board));
        let Err(Failure::Job(text)) = over(Box::new(VirtualLink::new(board.clone())), None, None) else {
            panic!("it was not refused")
        };
        assert!(text.contains("measures no ticks") && text.contains("nothing was moved or lit"), "{text}");
        let after = state(&opened(&board));
        assert_eq!(after, before);
        assert_eq!(after.0, [(0, 0); 2]);
    }

    /// A signal, or a failure, before, in and after a load that moves and lights.
    #[test]
    fn whatever_ends_a_load_the_controller_is_dark_and_as_after_power_on() {
        let board = share(Board::new(Config::default()));
        let client = opened(&board);
        let statuses = |axes: &[(u32, f64)]| axes.iter().map(|(status, _)| *status).collect::<Vec<_>>();
        let power_on = statuses(&state(&client).1);
        let (mut lit, mut moving) = (false, false);
        for end in [1, 5, 50] {
            let asked = Cell::new(0);
            let seen = RefCell::new((Vec::new(), Vec::new()));
            let check = || {
                asked.set(asked.get() + 1);
                if asked.get() < end {
                    return Ok(());
                }
                *seen.borrow_mut() = state(&client);
                Err(Failure::Job("it ends here".to_owned()))
            };
            let outcome = then_restored(&client, || {
                begin(&client, &BUSIEST)?;
                wait(&client, 1000, &check)
            });
            assert!(matches!(&outcome, Err(Failure::Job(text)) if text == "it ends here"), "{end}: {outcome:?}");
            let (lasers, axes) = seen.into_inner();
            lit |= lasers.iter().any(|(_, light)| *light != 0);
            moving |= axes.iter().any(|(status, _)| status & status::RUNNING != 0);
            let (lasers, _) = state(&client);
            assert!(lasers.iter().all(|(_, light)| *light == 0), "{end}: {lasers:?}");
            // An axis that was reset is in position some cycles later.
            client.sleep(Duration::from_millis(10)).unwrap();
            let (_, axes) = state(&client);
            assert_eq!(statuses(&axes), power_on, "{end}");
        }
        assert!(lit && moving, "no end was within light, or none within motion");
    }

    #[test]
    fn frames_that_came_damaged_or_again_are_lost_ones() {
        let mut counters = LinkCounters::default();
        (counters.checksum, counters.timeouts, counters.sent) = (1, 2, 100);
        assert_eq!(lost(&counters), 3);
    }

    #[test]
    fn a_histogram_is_judged_by_its_longest_ticks() {
        let judge = |counts: &[u32]| {
            judged(&Ticks { period_ns: 10_000, median_ns: 3_100, bucket_ns: 2_000, counts: counts.to_vec() })
        };
        let good = "median 3.10 us of 10, all below 10.0 us: 90 from 2.0 us, 1 from 8.0 us";
        assert_eq!(judge(&[0, 90, 0, 0, 1, 0, 0]), (true, good.to_owned()));
        let late = "median 3.10 us of 10, all below 12.0 us: 90 from 2.0 us, 1 from 10.0 us";
        assert_eq!(judge(&[0, 90, 0, 0, 0, 1, 0]), (false, late.to_owned()));
        // Longer than all steps of time: no end is known.
        assert_eq!(judge(&[0, 0, 2]), (false, "median 3.10 us of 10, all longer: 2 from 4.0 us".to_owned()));
    }

    #[test]
    fn a_section_takes_the_place_of_the_one_before() {
        let page = with_section("# Bring-up\n\n| a |\n", "## Ticks under load\n\nold\n");
        assert_eq!(page, "# Bring-up\n\n| a |\n\n## Ticks under load\n\nold\n");
        assert_eq!(with_section(&page, "## Ticks under load\n\nnew\n"), page.replace("old", "new"));
    }
}
