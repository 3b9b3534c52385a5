//! How long the servo ticks of the board's own image take: under each load and tick a row with the
//! running median, the longest and a histogram, by [`GetTickTime`].
//!
//! In: a link to the board's own image, jumper 6. Out: a section of the page, in place of the one
//! of a run before. The board measures from the timer's event to the end of the handler, by the
//! timer's count. Nothing moves or lights on a board that measures no ticks, or before [`jumper`]
//! has shown that this is a bench. However it ends, [`restore`] leaves the board dark and at rest,
//! with its limits, alarms and tick. Fails: a board that is refused, a load whose light ends by
//! itself, a tick that took longer than its period where each load must fit.
//!
//! [`GetTickTime`]: protocol::command::GetTickTime
use super::jumper;
use super::lines::Figures;
use super::standard::{BUSIEST, LOADS, Load, begin};
use super::ticks::{self, Fit, Known, MUST_FIT_US, Outcome, Ticks, judged};
use super::{own_image, page};
use crate::Failure;
use crate::interrupt::{self, Held};
use client::{Client, Link, LinkCounters, error};
use protocol::command::{Abort, GetClock, GetStack, Reset, SetTick, StackReply};
use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

/// Ticks under which loads are measured, in µs, the longest first.
const TICKS_US: [u32; 4] = [250, 50, 20, 10];
/// Where a load at the longest says too little of shorter ones.
const BETWEEN_US: u32 = 200;
/// How long a load is measured: axes in PVT go to and fro in 24 ms.
const LASTS_MS: [(u32, u32); 2] = [(50, 50), (0, 25)];
/// In this time a load goes on as it will, and the running median moves by 16 ns a tick.
const SETTLES_MS: u32 = 10;
/// How often that is waited for.
const SETTLES_MOST: usize = 40;
/// How often the clock is asked: each call makes some ticks longer.
const POLL_MS: u32 = 10;
/// In this time an Abort has ended the light, and slow motion.
const REST_MS: u32 = 20;
/// What a board hears that measures no ticks.
const REFUSED: &str = "measures no ticks, so it is no reference board with its own image: nothing was moved or lit. \
    Flash that image (`cargo flash-board`) onto a board that is connected to nothing but jumpers";
/// The page's section.
const HEADING: &str = "## Ticks under load";
/// The row of the stack, and how much of it must be left.
const STACK: &str = "stack of this image, after all loads";
const STACK_RESERVE_BYTES: u32 = 1024;
/// What to do about a row that failed.
const REMEDY: &str = "A load that overran: compare the rows \"caches and wait states\" and \"cycles of the core in a count of the \
timers\".\nIf both pass, the core takes more cycles than instructions (assumption 21): give that load a longer tick \
(`GT_SetTick`).";

/// Measures, keeps the link busy for `soak_s` seconds, and writes the section.
pub fn over(mut link: Box<dyn Link>, soak_s: Option<u32>, page: Option<&Path>) -> Result<(), Failure> {
    let mut failed = 0;
    let is_usb = link.is_boards_usb();
    page::write(page, |before| {
        let client = own_image(link)?;
        let Some(Ticks { period_ns, .. }) = ticks::read(&client)? else {
            return Err(Failure::Job(format!("{} {REFUSED}", client.board())));
        };
        // A signal ends it through `interrupted`, so that the board is restored.
        let held = Held::new();
        let all = jumper::prove(&client, &interrupted)
            .and_then(|()| then_restored(&client, period_ns, || under_loads(&client, soak_s, &interrupted)));
        drop(held);
        let all = all?;
        let mut figures = Figures::default();
        if let Some(Soak { seconds, calls, lost, ended }) = all.soak {
            figures.add_image_of(&client);
            figures.add("soak", vec![seconds.into(), calls as i64, lost.into(), is_usb.into(), ended.into()]);
        }
        let (section, late) = section(&client, &all);
        let (settled, lossy) = page::settled(before, &figures)?;
        failed = late + lossy;
        let rows = TICKS_US.len() * LOADS.len();
        Ok((with_section(&settled, &section), format!("{rows} loads and ticks, {}", page::rows_failed(failed))))
    })?;
    match failed {
        0 => Ok(()),
        failed => Err(Failure::Job(format!(
            "{}: ticks took longer than their period, the stack ran low, or the link lost some",
            page::rows_failed(failed)
        ))),
    }
}

/// The section, and how many rows failed.
fn section(client: &Client, all: &Measured) -> (String, usize) {
    let image = page::version_of(client);
    let mut text = format!(
        "{HEADING}\n\n{}\n\nThe board's own image, from the timer's event to the end of the handler. On the emulated \
         chip an instruction takes a\ncycle. The histogram has the ticks of each step of time that has any. A load must \
         fit into a tick of {MUST_FIT_US} us and\nmore. *Does not fit* is no fault of the board.\n\n\
         | row | assumption | result | figure |\n| --- | --- | --- | --- |\n",
        page::dated(&format!("Board {}, image {image}, over {}", client.board(), client.name()))
    );
    let mut failed = 0;
    for (us, outcomes) in TICKS_US.iter().zip(&all.ticks) {
        for (load, outcome) in LOADS.iter().zip(outcomes) {
            let (fit, figure) = judged(outcome);
            failed += usize::from(fit == Fit::Fail);
            // Writing to a string never fails.
            let _ = writeln!(text, "| {}, tick of {us} us | 21 | {} | {figure} |", load.name, fit.text());
        }
    }
    let late = failed;
    if let Some((size, unused)) = all.stack {
        let fits = unused >= STACK_RESERVE_BYTES;
        failed += usize::from(!fits);
        let result = if fits { Fit::Pass } else { Fit::Fail }.text();
        let _ = writeln!(text, "| {STACK} | – | {result} | {} bytes of {size} |", size - unused.min(size));
    }
    text = format!("{text}\n{}\n", fitting(all));
    if failed > late {
        let _ = writeln!(text, "\n{STACK}: enlarge STACK in memory.x.");
    }
    if late > 0 {
        text = text + "\n" + REMEDY + "\n";
    }
    (text, failed)
}

/// From which tick on all loads fit, in one line.
fn fitting(all: &Measured) -> String {
    let fits = |outcomes: &&Vec<Outcome>| outcomes.iter().all(|outcome| judged(outcome).0 == Fit::Pass);
    let longest = all.ticks.iter().take_while(fits).count();
    match TICKS_US.get(..longest) {
        Some([.., least]) => format!("All loads fit from {least} us on."),
        _ => format!("Not all loads fit at {} us.", TICKS_US[0]),
    }
}

/// Fails once a signal has come.
fn interrupted() -> Result<(), Failure> {
    let said = "the measurement was cut short: nothing of it is on the page. Give the command again";
    interrupt::came().map_or(Ok(()), |signal| Err(Failure::Interrupted(signal, said.into())))
}

/// What is asked at each step of a load whether to go on.
pub type Check<'a> = &'a dyn Fn() -> Result<(), Failure>;

/// What was measured.
#[derive(Debug)]
struct Measured {
    /// Of each tick, each load.
    ticks: Vec<Vec<Outcome>>,
    /// Bytes of the stack, and those that were never used since the start.
    stack: Option<(u32, u32)>,
    soak: Option<Soak>,
}

/// What a link did for some time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Soak {
    seconds: u32,
    calls: u64,
    /// Frames that came damaged, and messages that were sent again.
    lost: u32,
    /// The error with which the link ended before its time; else 0.
    ended: i16,
}

/// All of it, on a bench.
fn under_loads(client: &Client, soak_s: Option<u32>, check: Check<'_>) -> Result<Measured, Failure> {
    let period_ns = ticks::read(client)?.map_or(0, |ticks| ticks.period_ns);
    let mut known = [const { Known::new() }; LOADS.len()];
    let mut all = Vec::new();
    for us in TICKS_US {
        let outcomes = LOADS.iter().zip(&mut known).map(|(load, known)| outcome(client, load, us, known, check));
        all.push(outcomes.collect::<Result<Vec<_>, _>>()?);
    }
    let StackReply { size, unused, measured } = client.call(GetStack {})?;
    let stack = (measured != 0).then(|| (size.get(), unused.get()));
    // The link is kept busy at the tick that the board came with.
    set_tick(client, period_ns / 1000)?;
    let soak = soak_s.map(|seconds| soak(client, seconds, check)).transpose()?;
    Ok(Measured { ticks: all, stack, soak })
}

/// What becomes of a load at a tick. It is not run where it would leave the link no time.
fn outcome(client: &Client, load: &Load, us: u32, known: &mut Known, check: Check<'_>) -> Result<Outcome, Failure> {
    if us < BETWEEN_US && !known.is_line() && known.too_long(1000 * us).is_some() {
        // By the longest tick alone it is too long: a second one shows what of it grows with ticks.
        if known.too_long(1000 * BETWEEN_US).is_none() {
            known.learn(&measured(client, load, BETWEEN_US, check)?);
        }
    }
    if let Some(too_long) = known.too_long(1000 * us) {
        return Ok(too_long);
    }
    let outcome = measured(client, load, us, check)?;
    known.learn(&outcome);
    Ok(outcome)
}

/// Does this; the board is restored however it ends. Where the link has ended it is not: what was
/// measured is kept.
fn then_restored(
    client: &Client,
    period_ns: u32,
    run: impl FnOnce() -> Result<Measured, Failure>,
) -> Result<Measured, Failure> {
    let all = run();
    let restored = restore(client, period_ns);
    let has_ended = matches!(&all, Ok(Measured { soak: Some(soak), .. }) if soak.ended != 0);
    if restored.is_err() {
        complain!("the board did not confirm that it is dark and at rest: take its supply off");
    }
    if has_ended {
        return all;
    }
    all.and_then(|all| restored.map(|()| all))
}

/// Eight axes and both lasers run, while calls follow each other over the link.
fn soak(client: &Client, seconds: u32, check: Check<'_>) -> Result<Soak, Failure> {
    begin(client, &BUSIEST, check)?;
    let before = client.counters();
    let now_ms = || client.call(GetClock {}).map(|reply| reply.clock_ms.get());
    let began = now_ms()?;
    let (mut calls, mut passed_ms, mut ended) = (0, 0, 0);
    while passed_ms < 1000 * seconds {
        check()?;
        match now_ms().and_then(|now| ticks::asked(client).map(|_| now)) {
            Ok(now) => (passed_ms, calls) = (now.wrapping_sub(began), calls + 2),
            Err(failed) if failed.code == error::NO_ANSWER || error::is_dead(&failed) => {
                complain!("{failed}");
                ended = failed.code;
                break;
            }
            Err(other) => return Err(other.into()),
        }
    }
    if let Some(cause) = if ended == 0 { dark(client, &BUSIEST)? } else { None } {
        return Err(Failure::Job(format!("{}: {cause}", BUSIEST.name)));
    }
    Ok(Soak { seconds: passed_ms / 1000, calls, lost: lost(&client.counters()).wrapping_sub(lost(&before)), ended })
}

/// Frames that came damaged or again.
fn lost(counters: &LinkCounters) -> u32 {
    let LinkCounters { deframe, short, checksum, length, duplicates, timeouts, fast_retransmits, .. } = *counters;
    let damaged = [deframe.too_long, deframe.truncated, short, checksum, length];
    damaged.into_iter().chain([duplicates, timeouts, fast_retransmits]).fold(0, u32::wrapping_add)
}

/// Dark and at rest, and everything as after power-on: limits and alarms too; and the tick.
fn restore(client: &Client, period_ns: u32) -> Result<(), Failure> {
    client.call(Abort { core: 1.into() })?;
    wait(client, REST_MS, &|| Ok(()))?;
    set_tick(client, period_ns / 1000)
}

/// At standstill, to which a Reset brings what an Abort has not stopped yet.
fn set_tick(client: &Client, us: u32) -> Result<(), Failure> {
    client.call(Reset { core: 1.into() })?;
    client.call(SetTick { tick_us: (us as i32).into() })?;
    Ok(())
}

/// Why a load has no light that should have.
fn dark(client: &Client, load: &Load) -> Result<Option<String>, Failure> {
    for channel in 0..if load.is_lit() { 2 } else { 0 } {
        if let Some(cause) = jumper::fault(client, channel)? {
            return Ok(Some(format!("laser {channel} went dark: {cause}")));
        }
    }
    Ok(None)
}

/// The ticks under a load.
fn measured(client: &Client, load: &Load, us: u32, check: Check<'_>) -> Result<Outcome, Failure> {
    let stopped = || Failure::Job(format!("{}: the board has stopped to measure its ticks", load.name));
    let read = || ticks::read(client).and_then(|ticks| ticks.ok_or_else(stopped));
    set_tick(client, us)?;
    let before_light = begin(client, load, check)?;
    let overran = |before: u32| ticks::overruns(client).map(|now| now.wrapping_sub(before));
    let since = ticks::overruns(client)?;
    // The longest tick of what began is taken away.
    let (mut before, mut worst_ns) = (read()?, 0);
    for _ in 0..SETTLES_MOST {
        wait(client, SETTLES_MS, check)?;
        let now = read()?;
        let settled = now.clone().after(&before).is_settled();
        (before, worst_ns) = (now.clone(), now.worst_ns.max(worst_ns));
        if settled {
            break;
        }
    }
    let lasts = LASTS_MS.iter().find(|(from, _)| us >= *from);
    wait(client, lasts.map_or(0, |(_, ms)| *ms), check)?;
    let after = read()?;
    let (at_all, overran) = (overran(before_light)?, overran(since)?);
    let dark = dark(client, load)?;
    client.call(Abort { core: 1.into() })?;
    wait(client, REST_MS, check)?;
    match &dark {
        Some(cause) if at_all == 0 => Err(Failure::Job(format!("{}: {cause}", load.name))),
        _ => {
            let worst_ns = after.worst_ns.max(worst_ns);
            Ok(Outcome::Ran(Ticks { worst_ns, overran, ..after.after(&before) }, dark.is_some()))
        }
    }
}

/// Waits for so much of the controller's time.
pub fn wait(client: &Client, ms: u32, check: Check<'_>) -> Result<(), Failure> {
    let now = || client.call(GetClock {}).map(|reply| reply.clock_ms.get());
    let (began, mut passed) = (now()?, 0);
    while passed < ms {
        check()?;
        client.sleep(Duration::from_millis((ms - passed).min(POLL_MS).into()))?;
        passed = now()?.wrapping_sub(began);
    }
    Ok(())
}

/// The page with this section at its end, in place of the one it had.
fn with_section(page: &str, section: &str) -> String {
    let kept = page.split(HEADING).next().unwrap_or("").trim_end();
    format!("{kept}\n\n{section}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use client::Options;
    use protocol::command::{AxisStatus, GetLaserOnTime, LaserStatus};
    use protocol::values::status;
    use std::cell::{Cell, RefCell};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
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
            let outcome = then_restored(&client, 250_000, || {
                begin(&client, &BUSIEST, &|| Ok(()))?;
                wait(&client, 1000, &check)?;
                Ok(Measured { ticks: Vec::new(), stack: None, soak: None })
            });
            assert!(matches!(&outcome, Err(Failure::Job(text)) if text == "it ends here"), "{end}: {outcome:?}");
            let (lasers, axes) = seen.into_inner();
            lit |= lasers.iter().any(|(_, light)| *light != 0);
            moving |= axes.iter().any(|(status, _)| status & status::RUNNING != 0);
            let (lasers, _) = state(&client);
            assert!(lasers.iter().all(|(_, light)| *light == 0), "{end}: {lasers:?}");
            // An axis that was reset at 1 MHz is in position some time later.
            client.sleep(Duration::from_millis(200)).unwrap();
            let (_, axes) = state(&client);
            assert_eq!(statuses(&axes), power_on, "{end}");
        }
        assert!(lit && moving, "no end was within light, or none within motion");
    }

    /// A program that is killed, or a cable that is pulled, under the busiest load: after the time
    /// of a lost link and of braking the board is dark, and no axis moves.
    #[test]
    fn a_load_whose_link_ends_comes_to_rest_by_itself() {
        let (board, has_ended) = (share(Board::new(Config::default())), Arc::new(AtomicBool::new(false)));
        let link = Ends(VirtualLink::new(board.clone()), has_ended.clone());
        let client = Client::open(Box::new(link), Options::default()).unwrap();
        begin(&client, &BUSIEST, &|| Ok(())).unwrap();
        let (lasers, axes) = state(&client);
        assert!(lasers.iter().all(|(_, light)| *light != 0), "{lasers:?}");
        assert!(axes.iter().all(|(status, _)| status & status::RUNNING != 0), "{axes:?}");
        has_ended.store(true, Ordering::Relaxed);
        let mut board = board.lock().unwrap();
        let pass = |board: &mut Board, ms: u64| {
            let end = board.now() + ms * 1_000_000;
            // It stops at whatever it sends.
            while board.now() < end {
                board.advance(end - board.now(), &mut Vec::new());
            }
        };
        pass(&mut board, 700);
        assert!((0..8).all(|axis| board.axis(axis).status & status::RUNNING == 0));
        assert!((0..2).all(|channel| board.laser_view(channel).fault as i16 == 2), "the cause is the lost link");
        let stands: Vec<i64> = (0..8).map(|axis| board.set_point(axis)).collect();
        pass(&mut board, 300);
        assert_eq!((0..8).map(|axis| board.set_point(axis)).collect::<Vec<i64>>(), stands);
    }

    /// A link that ends once it is told to.
    struct Ends(VirtualLink, Arc<AtomicBool>);

    impl Link for Ends {
        fn name(&self) -> &str {
            self.0.name()
        }
        fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
            match self.1.load(Ordering::Relaxed) {
                true => Err(client::Error::new(error::LINK_SEND, "the cable is out")),
                false => self.0.send(bytes),
            }
        }
        fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
            match self.1.load(Ordering::Relaxed) {
                true => Err(client::Error::new(error::LINK_RECEIVE, "the cable is out")),
                false => self.0.receive(buf, wait),
            }
        }
        fn now(&mut self) -> u64 {
            self.0.now()
        }
        fn real_time(&self) -> bool {
            self.0.real_time()
        }
    }

    /// What was measured before is there all the same.
    #[test]
    fn a_link_that_ends_in_a_soak_fails_its_row_and_loses_no_load() {
        let (has_ended, asked) = (Arc::new(AtomicBool::new(false)), Cell::new(0));
        let link = Ends(VirtualLink::new(share(Board::new(Config::default()))), has_ended.clone());
        let client = Client::open(Box::new(link), Options::default()).unwrap();
        let check = || {
            asked.set(asked.get() + 1);
            has_ended.store(asked.get() > 100, Ordering::Relaxed);
            Ok(())
        };
        let outcome = then_restored(&client, 250_000, || {
            Ok(Measured { ticks: vec![Vec::new()], stack: None, soak: Some(soak(&client, 60, &check)?) })
        });
        let Ok(Measured { ticks, soak: Some(soak), .. }) = outcome else { panic!("{outcome:?}") };
        assert_eq!(ticks.len(), 1);
        assert!(soak.ended < 0 && soak.calls > 100 && soak.seconds < 60, "{soak:?}");
        let mut figures = Figures::default();
        figures.add("soak", vec![soak.seconds.into(), soak.calls as i64, soak.lost.into(), 0, soak.ended.into()]);
        let (page, failed) = page::settled("", &figures).unwrap();
        let row = page.lines().find(|line| line.starts_with("| the link's stream beside all others | ")).unwrap();
        assert!(
            failed == 1 && row.contains(&format!(" | **FAIL** | the link ended (error {}) after ", soak.ended)),
            "{row}"
        );
    }

    #[test]
    fn the_ticks_into_which_all_loads_fit_are_one_line() {
        let ran = |us: u32, worst_ns| {
            let period_ns = 1000 * us;
            Outcome::Ran(Ticks { period_ns, worst_ns, bucket_ns: 2048, ..Ticks::default() }, false)
        };
        let of = |worst_ns| {
            let ticks = TICKS_US.map(|us| vec![ran(us, 9_000), ran(us, worst_ns)]).to_vec();
            fitting(&Measured { ticks, stack: None, soak: None })
        };
        assert_eq!(
            [9_000, 30_000, 300_000].map(of),
            ["All loads fit from 10 us on.", "All loads fit from 50 us on.", "Not all loads fit at 250 us."]
        );
    }

    #[test]
    fn frames_that_came_damaged_or_again_are_lost_ones() {
        let mut counters = LinkCounters::default();
        (counters.checksum, counters.timeouts, counters.sent) = (1, 2, 100);
        assert_eq!(lost(&counters), 3);
    }

    #[test]
    fn a_section_takes_the_place_of_the_one_before() {
        let page = with_section("# Bring-up\n\n| a |\n", "## Ticks under load\n\nold\n");
        assert_eq!(page, "# Bring-up\n\n| a |\n\n## Ticks under load\n\nold\n");
        assert_eq!(with_section(&page, "## Ticks under load\n\nnew\n"), page.replace("old", "new"));
    }
}
