//! `beamtick bring-up`: a board measures itself, and the result is a page.
//!
//! In: the lines of the bring-up image ([`lines`]), or the ticks of the board's own image under
//! [`loads`], or its [`answers`]; or what [`hands`] do. Out: a page in Markdown with a row for each
//! fact ([`rows`]), pass, fail or a figure, and what to change on a fail. Owns the limits. Fails: a
//! board that does not answer, a line that arrives damaged, a run that ends early.
mod answers;
mod hands;
mod jumper;
mod lines;
mod loads;
mod options;
mod page;
mod rows;
mod standard;
mod ticks;

use crate::Failure;
use crate::{connect, interrupt};
use client::Link;
pub use hands::Hands;
use hands::Terminal;
use lines::{Figures, Reader};
pub use options::BringUp;
use page::{Older, Report};
use std::time::Duration;

/// The board waits for this line.
const ORDER: &[u8] = b"go\n";
/// The order is repeated until the board answers: it may still start.
const REPEAT_NS: u64 = 500_000_000;
/// A board that says nothing for so long does not answer.
const SILENCE_NS: u64 = 5_000_000_000;
/// How long one look at the link lasts.
const RECEIVE_TIME: Duration = Duration::from_millis(20);

const NO_ANSWER: &str = "the board does not answer. Flash the bring-up image (`cargo bring-up`), press B2, try again. \
    LD3 (red) alone: the image refuses the chip, which is no STM32H743 of revision X or V (assumption 6)";

/// Runs it over the link that the command line names.
pub fn run(arguments: &BringUp) -> Result<(), Failure> {
    connect::check(&arguments.link)?;
    let page = arguments.page.as_deref();
    if let Some(what) = arguments.hands {
        return hands::with(&mut Terminal::at(&arguments.link), what, page);
    }
    let link = client::link::open(&arguments.link);
    if let Some(board) = arguments.answers {
        return answers::over(link, board, page);
    }
    over(link?, arguments)
}

/// Runs it with these hands.
pub fn by_hand(hands: &mut dyn Hands, arguments: &BringUp) -> Result<(), Failure> {
    let what = arguments.hands.ok_or_else(|| Failure::Input("--hands is missing".to_owned()))?;
    hands::with(hands, what, arguments.page.as_deref())
}

/// Runs it over this link.
pub fn over(mut link: Box<dyn Link>, arguments: &BringUp) -> Result<(), Failure> {
    let name = arguments.page.as_deref();
    if arguments.loads {
        return loads::over(link, arguments.soak, name);
    }
    if let Some(board) = arguments.answers {
        return answers::over(Ok(link), board, name);
    }
    let mut failed = 0;
    page::write(name, Older::Aside, |before| {
        let text = page::kept(before, Report::of(&measure(&mut *link, ORDER)?).text());
        failed = page::failed(&text);
        let summary = page::summary(&text);
        Ok((text, summary))
    })?;
    page::failure(failed)
}

/// Orders a run and reads its lines.
fn measure(link: &mut dyn Link, order: &[u8]) -> Result<Figures, Failure> {
    let mut reader = Reader::default();
    let began = link.now();
    let (mut ordered, mut heard) = (None::<u64>, began);
    let mut bytes = [0; 512];
    loop {
        if let Some(signal) = interrupt::came() {
            return Err(Failure::Interrupted(signal, "the measurement was cut short; press B2 at the board".into()));
        }
        let now = link.now();
        if !reader.has_begun() && ordered.is_none_or(|at| now - at >= REPEAT_NS) {
            link.send(order)?;
            ordered = Some(now);
        }
        let count = link.receive(&mut bytes, RECEIVE_TIME)?;
        if count > 0 {
            heard = link.now();
        }
        if reader.feed(&bytes[..count])? {
            return Ok(reader.figures());
        }
        if link.now() - heard > SILENCE_NS {
            return Err(Failure::Job(if reader.has_begun() { reader.cut_short() } else { NO_ANSWER.into() }));
        }
    }
}
