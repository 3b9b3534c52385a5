//! How long the servo ticks of the board's own image take: under each load a row with the running
//! median, the longest and a histogram, by [`GetTickTime`].
//!
//! In: a link to the board's own image, jumper 6 for light. Out: a section of the page, in place of
//! the one of a run before. The board measures from the timer's event to the end of the handler, by
//! the timer's count. Fails: a tick that took longer than its period.
use crate::Failure;
use client::{Client, Link, Options};
use protocol::command::{
    Abort, AlarmOff, AxisOn, BufLaserFollowRatio, BufLaserOn, ClrSts, CrdClear, CrdStart, GetClock, GetTickTime,
    LaserOutFrq, LaserPrfCmd, LaserStatus, LmtsOff, LnXY, PrfPvt, PvtPoint, PvtStart, PvtTable, PvtTableSelect, Reset,
    SetAxisMode, SetCrdPrm, SetHSIOOpt, SetPvtLoop,
};
use std::fmt::Write as _;
use std::ops::Range;
use std::path::Path;

/// How long a load is measured.
const LASTS_MS: u32 = 50;
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
const LOADS: [Load; 6] = [
    Load { name: "nothing runs", axes: NO_AXES, light_khz: None, paths: false },
    Load { name: "two lasers at 10 kHz", axes: NO_AXES, light_khz: Some(10.0), paths: false },
    Load { name: "two lasers at 2 MHz", axes: NO_AXES, light_khz: Some(2000.0), paths: false },
    Load { name: "eight axes in PVT", axes: ALL, light_khz: None, paths: false },
    Load { name: "eight axes in PVT, two lasers at 2 MHz", axes: ALL, light_khz: Some(2000.0), paths: false },
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

/// Measures, and writes the section.
pub fn over(link: Box<dyn Link>, page: Option<&Path>) -> Result<(), Failure> {
    let client = Client::open(link, Options::default())?;
    let mut text = format!(
        "{HEADING}\n\nThe board's own image, from the timer's event to the end of the handler. On the emulated chip an \
         instruction takes a\ncycle. The histogram has the ticks of each step of time that has any.\n\n\
         | row | assumption | result | figure |\n| --- | --- | --- | --- |\n"
    );
    let mut failed = 0;
    for load in &LOADS {
        let (result, figure) = match measured(&client, load)? {
            Err(why) => ("not measured", why),
            Ok(ticks) => {
                let (holds, figure) = judged(&ticks);
                failed += u32::from(!holds);
                (if holds { "pass" } else { "**FAIL**" }, figure)
            }
        };
        // Writing to a string never fails.
        let _ = writeln!(text, "| {} | 21 | {result} | {figure} |", load.name);
    }
    match page {
        None => say!("{}", text.trim_end()),
        Some(path) => {
            let named = |e: std::io::Error| Failure::Input(format!("--page {}: {e}", path.display()));
            let before = if path.exists() { std::fs::read_to_string(path).map_err(named)? } else { String::new() };
            std::fs::write(path, with_section(&before, &text)).map_err(named)?;
            say!("{}: {} loads, {failed} failed", path.display(), LOADS.len());
        }
    }
    match failed {
        0 => Ok(()),
        failed => Err(Failure::Job(format!("{failed} loads failed: ticks took longer than their period"))),
    }
}

/// The ticks under a load, or why they are not measured.
fn measured(client: &Client, load: &Load) -> Result<Result<Ticks, String>, Failure> {
    let core = 1.into();
    client.call(Reset { core })?;
    if let Some(khz) = load.light_khz {
        for (axis, channel) in [(7i16, 0i16), (8, 1)] {
            let channel = channel.into();
            client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() })?;
            client.call(LaserOutFrq { core, frequency: khz.into(), channel })?;
            client.call(LaserPrfCmd { core, power: 33.3.into(), channel })?;
            if client.call(LaserStatus { core, channel })?.fault.get() != 0 {
                return Ok(Err("the lasers are kept dark: jumper 6 is missing, or see `beamtick info`".to_owned()));
            }
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
    // What begins is over, and what follows is compared with it.
    wait(client, 10)?;
    let before = ticks(client)?;
    wait(client, LASTS_MS)?;
    let after = ticks(client)?;
    client.call(Abort { core })?;
    wait(client, 20)?;
    let (Some(before), Some(after)) = (before, after) else {
        return Ok(Err("this board does not measure its ticks".to_owned()));
    };
    let counts = after.counts.iter().zip(&before.counts).map(|(after, before)| after.wrapping_sub(*before)).collect();
    Ok(Ok(Ticks { counts, ..after }))
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
fn wait(client: &Client, ms: u32) -> Result<(), Failure> {
    let began = client.call(GetClock {})?.clock_ms.get();
    while client.call(GetClock {})?.clock_ms.get().wrapping_sub(began) < ms {}
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
    if kept.is_empty() { format!("# Bring-up\n\n{section}") } else { format!("{kept}\n\n{section}") }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(with_section("", "## Ticks under load\n"), "# Bring-up\n\n## Ticks under load\n");
    }
}
