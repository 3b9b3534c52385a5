//! How long ticks took under a load, and what a row of the page makes of that.
//!
//! In: [`GetTickTime`], overruns. Out: figures, results. Owns the limits. The longest tick is the
//! board's own figure, not the end of a step of the histogram. Fails where the board does not
//! answer, or stops to measure.
use crate::Failure;
use client::Client;
use protocol::command::{GetTickTime, ProgramStatus, TickTimeReply, ULong};

/// Cycles of the core in a µs.
const CORE_MHZ: f64 = 480.0;
/// Loads of SPEC 11 fit into these ticks and longer ones, or the board fails.
pub const MUST_FIT_US: u32 = 50;
/// The share of a tick above which the link's thread has too little time left: the watchdog would
/// end the run.
const MOST: f64 = 0.9;

/// The counts of a histogram, and what they count.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Ticks {
    /// Of the tick.
    pub period_ns: u32,
    /// The running median.
    pub median_ns: u32,
    /// The longest since it was asked before.
    pub worst_ns: u32,
    /// Of a step of the histogram.
    pub bucket_ns: u32,
    /// Its steps.
    pub counts: Vec<u32>,
    /// Ticks that overran.
    pub overran: u32,
}

/// Ticks that overran since the board counts them.
pub fn overruns(client: &Client) -> Result<u32, Failure> {
    Ok(client.call(ProgramStatus {})?.overruns.get())
}

/// What the board says.
pub fn asked(client: &Client) -> client::Result<(TickTimeReply, Vec<ULong>)> {
    client.call_items(GetTickTime {}, &[])
}

/// What the board says; `None` if it measures no ticks. The longest is that since the last call.
pub fn read(client: &Client) -> Result<Option<Ticks>, Failure> {
    let (reply, counts) = asked(client)?;
    Ok((reply.measured != 0).then(|| Ticks {
        period_ns: reply.period_ns.get(),
        median_ns: reply.median_ns.get(),
        worst_ns: reply.recent_ns.get(),
        bucket_ns: reply.bucket_ns.get(),
        counts: counts.iter().map(|count| count.value.get()).collect(),
        overran: 0,
    }))
}

impl Ticks {
    /// Those after these.
    pub fn after(self, before: &Ticks) -> Ticks {
        let gained = self.counts.iter().zip(&before.counts).map(|(after, before)| after.wrapping_sub(*before));
        Ticks { counts: gained.collect(), ..self }
    }

    /// The step of the histogram in which the median is.
    fn median_step(&self) -> usize {
        let half = self.counts.iter().sum::<u32>() / 2;
        let mut below = 0;
        let is_reached = |count: &u32| {
            below += count;
            below > half
        };
        self.counts.iter().position(is_reached).unwrap_or(self.counts.len())
    }

    /// Whether the running median has arrived where half of the ticks are: within a step of it.
    pub fn is_settled(&self) -> bool {
        let running = self.median_ns / self.bucket_ns.max(1);
        self.median_step().abs_diff(running as usize) <= 1
    }

    /// The running median; until it has arrived, the end of the median's step, or the longest tick
    /// where that has none.
    fn typical_ns(&self) -> u32 {
        match self.median_step() {
            _ if self.is_settled() => self.median_ns,
            step if step + 1 < self.counts.len() => (step as u32 + 1) * self.bucket_ns,
            _ => self.worst_ns,
        }
    }

    /// Whether a tick was longer than its period, or too late for what it queues.
    fn has_overrun(&self) -> bool {
        self.overran > 0 || self.worst_ns > self.period_ns
    }
}

/// What became of a load at a tick.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// It ran; whether a tick that overran made its light dark, maybe as it began.
    Ran(Ticks, bool),
    /// It did not: its median would be about so long, by longer ticks.
    TooLong {
        /// Of the tick.
        period_ns: u32,
        /// What it would take.
        about_ns: u32,
    },
}

/// Period and median, at most, of runs without an overrun, the shortest period last.
#[derive(Debug, Clone, Default)]
pub struct Known(Vec<(u32, u32)>);

impl Known {
    /// Nothing ran.
    pub const fn new() -> Known {
        Known(Vec::new())
    }

    /// Keeps what a run shows.
    pub fn learn(&mut self, outcome: &Outcome) {
        if let Outcome::Ran(ticks, false) = outcome
            && !ticks.has_overrun()
        {
            self.0.push((ticks.period_ns, ticks.typical_ns()));
        }
    }

    /// The median at this period: on the line through the last two, since a tick has a part that
    /// grows with its period; by one alone, at most that.
    fn about(&self, period_ns: u32) -> u32 {
        match *self.0.as_slice() {
            [] => 0,
            [(_, median)] => median,
            [.., (long, of_long), (short, of_short)] => {
                let slope = (f64::from(of_long) - f64::from(of_short)) / (f64::from(long) - f64::from(short));
                (f64::from(of_short) - slope * (f64::from(short) - f64::from(period_ns))).max(0.0) as u32
            }
        }
    }

    /// That the load is too long for this period; `None` if it may run.
    pub fn too_long(&self, period_ns: u32) -> Option<Outcome> {
        let about_ns = self.about(period_ns);
        (f64::from(about_ns) > MOST * f64::from(period_ns)).then_some(Outcome::TooLong { period_ns, about_ns })
    }

    /// Whether a line is known, and not one point alone.
    pub fn is_line(&self) -> bool {
        self.0.len() >= 2
    }
}

/// The result of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fit {
    /// Each tick was shorter than its period.
    Pass,
    /// One was not, where it must be.
    Fail,
    /// One was not, where nothing promises it.
    TooLong,
}

impl Fit {
    /// As the page says it.
    pub fn text(self) -> &'static str {
        match self {
            Fit::Pass => "pass",
            Fit::Fail => "**FAIL**",
            Fit::TooLong => "does not fit",
        }
    }
}

fn us(ns: u32) -> f64 {
    f64::from(ns) / 1000.0
}

/// A time, and the core's cycles of it.
fn time(ns: u32) -> String {
    format!("{:.2} us ({:.0} cycles)", us(ns), us(ns) * CORE_MHZ)
}

/// Whether each tick fitted into its period, and the figure.
pub fn judged(outcome: &Outcome) -> (Fit, String) {
    let fit = |fits: bool, period_ns: u32| match (fits, period_ns >= 1000 * MUST_FIT_US) {
        (true, _) => Fit::Pass,
        (false, true) => Fit::Fail,
        (false, false) => Fit::TooLong,
    };
    match outcome {
        Outcome::TooLong { period_ns, about_ns } => {
            let figure = format!("not run: about {} of {}, by those of longer ticks", time(*about_ns), us(*period_ns));
            (fit(false, *period_ns), figure)
        }
        Outcome::Ran(ticks, dark) => {
            let count = match ticks.overran {
                0 => "the longest tick".to_owned(),
                1 => "1 tick".to_owned(),
                more => format!("{more} ticks"),
            };
            let overrun = match (ticks.has_overrun(), *dark) {
                (false, false) => String::new(),
                (true, false) => format!("overrun: {count} took too long or came too late; "),
                (false, true) => "overrun: the lasers went dark as the load began; ".to_owned(),
                (true, true) => {
                    format!("overrun: the lasers went dark; {count} since took too long or came too late; ")
                }
            };
            let histogram: Vec<String> = ticks
                .counts
                .iter()
                .enumerate()
                .filter(|(_, count)| **count > 0)
                .map(|(step, count)| format!("{count} from {:.1} us", us(step as u32 * ticks.bucket_ns)))
                .collect();
            let figure = format!(
                "{overrun}median {}{}, worst {}, {:.0} % of {} us: {}",
                if ticks.is_settled() { "" } else { "at most " },
                time(ticks.typical_ns()),
                time(ticks.worst_ns),
                100.0 * f64::from(ticks.worst_ns) / f64::from(ticks.period_ns.max(1)),
                us(ticks.period_ns),
                histogram.join(", ")
            );
            (fit(!ticks.has_overrun() && !dark, ticks.period_ns), figure)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ran(period_ns: u32, median_ns: u32, worst_ns: u32, overran: u32) -> Outcome {
        let counts = vec![0, 90, 0, 0, 1, 0, 0];
        // The median is settled.
        let bucket_ns = if median_ns < 6_000 { 2_000 } else { median_ns / 2 };
        Outcome::Ran(Ticks { period_ns, median_ns, worst_ns, bucket_ns, counts, overran }, false)
    }

    /// The longest is exact: a step of the histogram would end beyond the tick.
    #[test]
    fn a_load_is_judged_by_its_longest_tick_and_by_overruns() {
        let good =
            "median 3.10 us (1488 cycles), worst 9.90 us (4752 cycles), 99 % of 10 us: 90 from 2.0 us, 1 from 8.0 us";
        assert_eq!(judged(&ran(10_000, 3_100, 9_900, 0)), (Fit::Pass, good.to_owned()));
        let late = format!("overrun: 2 ticks took too long or came too late; {good}");
        assert_eq!(judged(&ran(10_000, 3_100, 9_900, 2)), (Fit::TooLong, late));
        // The board counts a tick as late by the next one: the longest may not be counted yet.
        let (fit, text) = judged(&ran(10_000, 3_100, 10_001, 0));
        assert!(fit == Fit::TooLong && text.starts_with("overrun: the longest tick took too long or came too late; "));
        assert_eq!(judged(&ran(20_000, 3_100, 20_001, 1)).0, Fit::TooLong);
        assert_eq!(judged(&ran(50_000, 3_100, 50_001, 1)).0, Fit::Fail);
        assert_eq!(judged(&ran(50_000, 3_100, 50_000, 0)).0, Fit::Pass);
        let Outcome::Ran(ticks, _) = ran(50_000, 3_100, 50_001, 1) else { panic!() };
        let began = Ticks { worst_ns: 4_000, overran: 0, ..ticks.clone() };
        let (fit, text) = judged(&Outcome::Ran(began, true));
        assert!(fit == Fit::Fail && text.starts_with("overrun: the lasers went dark as the load began; median "));
        let (fit, text) = judged(&Outcome::Ran(ticks, true));
        let said = "overrun: the lasers went dark; 1 tick since took too long or came too late; ";
        assert!(fit == Fit::Fail && text.starts_with(said), "{text}");
    }

    /// 2 µs, and 100 ns of each µs of the tick.
    #[test]
    fn a_load_that_would_leave_no_time_is_not_run() {
        let mut known = Known::new();
        assert_eq!(known.too_long(250_000), None);
        known.learn(&ran(250_000, 27_000, 30_000, 0));
        assert!(!known.is_line());
        // One alone says no more than at most.
        assert_eq!(known.too_long(30_000), None);
        assert_eq!(known.too_long(20_000), Some(Outcome::TooLong { period_ns: 20_000, about_ns: 27_000 }));
        known.learn(&ran(50_000, 7_000, 8_000, 0));
        assert!(known.is_line());
        assert_eq!(known.too_long(20_000), None);
        // What overran is shorter than it would be: its lasers are dark.
        known.learn(&ran(20_000, 1_000, 21_000, 3));
        assert_eq!(known.too_long(3_000), None);
        let too_long = Outcome::TooLong { period_ns: 2_000, about_ns: 2_200 };
        assert_eq!(known.too_long(2_000), Some(too_long.clone()));
        let text = "not run: about 2.20 us (1056 cycles) of 2, by those of longer ticks";
        assert_eq!(judged(&too_long), (Fit::TooLong, text.to_owned()));
        assert_eq!(judged(&Outcome::TooLong { period_ns: 50_000, about_ns: 60_000 }).0, Fit::Fail);
    }

    #[test]
    fn a_median_is_settled_where_half_of_the_ticks_are() {
        let ticks =
            |median_ns| Ticks { median_ns, bucket_ns: 2000, counts: vec![0, 1, 5, 9, 40, 2], ..Ticks::default() };
        assert_eq!(
            [3_000, 5_999, 6_000, 11_999, 12_000].map(|ns| ticks(ns).is_settled()),
            [false, false, true, true, false]
        );
        // Until then its step's end is shown, and beyond the last step the longest tick.
        let shown =
            |ticks: Ticks| judged(&Outcome::Ran(Ticks { period_ns: 250_000, worst_ns: 77_000, ..ticks }, false)).1;
        let text = shown(ticks(3_000));
        assert!(text.starts_with("median at most 10.00 us (4800 cycles), worst 77.00 us"), "{text}");
        let text = shown(Ticks { counts: vec![1, 9], ..ticks(30_000) });
        assert!(text.starts_with("median at most 77.00 us (36960 cycles), worst 77.00 us"), "{text}");
    }
}
