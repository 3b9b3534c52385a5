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
use crate::connect;
use crate::interrupt::{self, Held};
use crate::summary::counted;
use client::{Client, Link, Options};
pub use hands::Hands;
use hands::Terminal;
use lines::{Figures, Reader};
pub use options::BringUp;
use page::Report;
use std::time::Duration;

/// The board waits for this line.
const ORDER: &[u8] = b"go\n";
/// The order is repeated until the board answers: it may still start.
const REPEAT_NS: u64 = 500_000_000;
/// A board that says nothing for so long does not answer.
const SILENCE_NS: u64 = 5_000_000_000;
/// In this time a run has begun, and in this time it is over, whatever else comes over the link: a
/// board takes some seconds, and the emulated one as many of its own.
const BEGINS_NS: u64 = 15_000_000_000;
const ENDS_NS: u64 = 120_000_000_000;
/// How long one look at the link lasts.
const RECEIVE_TIME: Duration = Duration::from_millis(20);
/// The board asks for bytes by a line of this name: its link's stream shall be busy for some ms.
const LISTENS: &str = "listens";
/// 13.6 ms at 3 Mbaud.
const FILLING: [u8; 4096] = [b'.'; 4096];

/// How a port is named, with its rate.
const PORT: &str =
    "serial:/dev/ttyACM0:3000000 (macOS: serial:/dev/cu.usbmodemNNN:3000000, Windows: serial:COM5:3000000)";
const NO_ANSWER: &str = "the board does not answer. Flash the bring-up image: `cargo bring-up`, or copy \
    out/beamtick-bring-up-VERSION.hex (images/ of a release) onto the board's drive; press B2, try again. The link is the \
    ST-LINK's port with its rate, 3000000. LD3 (red) alone: BOOT0 is bridged, or the image refuses the chip, which is no STM32H743 \
    of revision X or V (assumption 6). `ls /dev/ttyACM*` shows ports (macOS: `ls /dev/cu.usbmodem*`)";
const NO_OWN_IMAGE: &str = "This wants the board's own image (`--hands dac`: the one for an external DAC, \
    `cargo flash-board external-dac`), and maybe the bring-up image runs: `cargo flash-board`, or copy \
    out/beamtick-h743-VERSION.hex (`cargo xtask image`; images/ of a release) onto the board's drive. The link is the ST-LINK's port with its rate, 3000000: `ls \
    /dev/ttyACM*` shows ports (macOS: `ls /dev/cu.usbmodem*`)";
const NO_FIGURE: &str = "the run has ended, and no row of the page has got a figure. The image and this program do not belong \
    together: build and flash the image anew (`cargo bring-up`), press B2, and give the command again";
/// What is said where a signal ends the program at once.
const CUT: &str = "bring-up was cut short: the page is as it was. Press B2 at the board, then give the command again";

/// Whether a run has failed since not a byte has come.
fn is_silence(failure: &Failure) -> bool {
    matches!(failure, Failure::Job(text) if text == NO_ANSWER)
}

/// Runs it over the link that the command line names.
pub fn run(arguments: &BringUp) -> Result<(), Failure> {
    connect::check(&arguments.link)?;
    if ["virtual", "qemu"].iter().any(|kind| arguments.link.split(':').next() == Some(kind)) {
        let link = &arguments.link;
        return Err(Failure::Input(format!("--link {link}: bring-up measures a board; its link is {PORT}")));
    }
    interrupt::say_last(CUT);
    let page = arguments.page.as_deref();
    if let Some(what) = arguments.hands {
        return hands::with(&mut Terminal::at(&arguments.link), what, page);
    }
    let link = client::link::open(&arguments.link);
    if let Some(board) = arguments.answers {
        return answers::over(answers::found(&arguments.link, link)?, board, page);
    }
    over(link?, arguments)
}

/// A client of the board's own image.
fn own_image(link: Box<dyn Link>) -> Result<Client, Failure> {
    Client::open(link, Options::default()).map_err(|error| match error.code {
        client::error::NO_ANSWER => Failure::Job(format!("{error}. {NO_OWN_IMAGE}")),
        _ => error.into(),
    })
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
        return answers::over(link, board, name);
    }
    let mut failed = 0;
    // A signal ends it through `measure`, so that it says what happened.
    let held = Held::new();
    let outcome = page::write(name, |before| {
        page::check_subject(name, before)?;
        let report = Report::of(&measure(&mut *link, ORDER)?);
        if !report.has_figures() {
            return Err(Failure::Job(NO_FIGURE.to_owned()));
        }
        let text = page::kept(name, before, report.text())?;
        failed = page::failed(&text);
        let summary = [Some(page::summary(&text)), page::not_for_lasers(&text)].into_iter().flatten();
        let summary = summary.collect::<Vec<_>>().join("; ");
        Ok((text, summary))
    });
    drop(held);
    outcome?;
    page::failure(failed)
}

/// Fails once a signal has come.
fn uncut() -> Result<(), Failure> {
    interrupt::came().map_or(Ok(()), |signal| Err(Failure::Interrupted(signal, CUT.into())))
}

/// Orders a run and reads its lines.
fn measure(link: &mut dyn Link, order: &[u8]) -> Result<Figures, Failure> {
    let mut reader = Reader::default();
    let began = link.now();
    let (mut ordered, mut heard, mut is_filled) = (None::<u64>, began, false);
    let mut bytes = [0; 512];
    loop {
        uncut()?;
        let now = link.now();
        if !is_filled && reader.has_line(LISTENS) {
            link.send(&FILLING)?;
            is_filled = true;
        }
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
        let now = link.now();
        if now - heard > SILENCE_NS {
            return Err(Failure::Job(if reader.has_begun() { reader.cut_short() } else { no_run(&reader) }));
        }
        if !reader.has_begun() && now - began > BEGINS_NS {
            return Err(Failure::Job(no_run(&reader)));
        }
        if now - began > ENDS_NS {
            let seconds = ENDS_NS / 1_000_000_000;
            return Err(Failure::Job(format!(
                "the run does not end: {} in {seconds} s",
                lines::have_come(reader.lines())
            )));
        }
    }
}

/// Why no run has begun.
fn no_run(reader: &Reader) -> String {
    match reader.foreign() {
        None => NO_ANSWER.into(),
        Some((bytes, first)) => format!(
            "{} come, and no line of the bring-up image: the first are \"{first}\". Another image runs, this is another \
             device's port, or the rate is not 3000000. Flash the bring-up image: `cargo bring-up`; the link is {PORT}",
            counted(bytes as i64, "byte has", "bytes have")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device that says this again and again, a receive each 20 ms.
    struct Talks(&'static [u8], u64);

    impl Link for Talks {
        fn name(&self) -> &str {
            "talks"
        }
        fn send(&mut self, _: &[u8]) -> client::Result<()> {
            Ok(())
        }
        fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
            self.1 += wait.as_nanos() as u64;
            buf[..self.0.len()].copy_from_slice(self.0);
            Ok(self.0.len())
        }
        fn now(&mut self) -> u64 {
            self.1
        }
        fn real_time(&self) -> bool {
            false
        }
    }

    /// What wants the board's own image says so where that does not answer.
    #[test]
    fn another_image_than_the_boards_own_is_told_how_to_flash_that() {
        let Err(Failure::Job(text)) = own_image(Box::new(Talks(b"", 0))) else { panic!("it answers") };
        assert!(text.contains("does not answer") && text.ends_with(&format!(". {NO_OWN_IMAGE}")), "{text}");
        assert!(NO_OWN_IMAGE.contains("maybe the bring-up image runs: `cargo flash-board`"));
    }

    /// Whatever comes, the program ends, and says what came.
    #[test]
    fn a_device_that_talks_without_end_is_no_board() {
        let ended = |says: &'static [u8]| {
            let mut link = Talks(says, 0);
            match measure(&mut link, ORDER) {
                Err(Failure::Job(text)) => (link.1 / 1_000_000_000, text),
                other => panic!("{other:?}"),
            }
        };
        // Lines, and bytes without one.
        for (says, quoted) in [(&b"$GPGLL,5300.97914\r\n"[..], "$GPGLL,5300.97914\\r\\n$GPGLL"), (b"xyz", "xyzxyzxyz")]
        {
            let (seconds, text) = ended(says);
            assert_eq!(seconds, 15);
            assert!(
                text.contains(&format!("the first are \"{quoted}")) && text.contains("the rate is not 3000000"),
                "{text}"
            );
        }
        assert_eq!(ended(b""), (5, NO_ANSWER.to_owned()));
    }

    /// Lines for people keep no run going.
    #[test]
    fn a_run_that_does_not_end_is_given_up() {
        struct Begins(Talks, u32);
        impl Link for Begins {
            fn name(&self) -> &str {
                "begins"
            }
            fn send(&mut self, bytes: &[u8]) -> client::Result<()> {
                // The board's stream is filled once it asks for that.
                assert_eq!(bytes, if self.1 == 0 { ORDER } else { &FILLING });
                self.1 += 1;
                Ok(())
            }
            fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
                if self.0.1 > 0 {
                    return self.0.receive(buf, wait);
                }
                self.0.1 = 1;
                let line = b"format 2*11\r\nlistens*7A\r\n";
                buf[..line.len()].copy_from_slice(line);
                Ok(line.len())
            }
            fn now(&mut self) -> u64 {
                self.0.1
            }
        }
        let mut link = Begins(Talks(b"#.......\r\n", 0), 0);
        let Err(Failure::Job(text)) = measure(&mut link, ORDER) else { panic!("it has ended well") };
        assert_eq!(
            (text.as_str(), link.0.1 / 1_000_000_000),
            ("the run does not end: 2 lines have come in 120 s", 120)
        );
        assert_eq!(link.1, 2);
    }

    /// A run without a figure is none, and the page of before stays.
    #[test]
    fn a_run_without_any_figure_fails_and_says_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        let name = page.to_str().unwrap();
        let talks = |says| crate::bring_up_over(Box::new(Talks(says, 0)), &["--page", name]);
        let Err(Failure::Job(text)) = talks(b"format 2*11\r\nend 1*7E\r\n") else { panic!("it has ended well") };
        assert!(text.starts_with("the run has ended, and no row of the page has got a figure."), "{text}");
        assert!(
            text.contains("flash the image anew (`cargo bring-up`), press B2, and give the command again"),
            "{text}"
        );
        assert!(!page.exists());
        // One figure is enough: RCC_RSR.
        let one = talks(b"format 2*11\r\ncause 16384000*49\r\nend 2*7D\r\n");
        assert!(one.is_ok() && page.exists(), "{one:?}");
    }

    #[test]
    fn a_link_to_no_board_names_what_is_needed() {
        for link in ["virtual", "qemu", "qemu:image"] {
            let Err(Failure::Input(text)) = crate::call(&["bring-up", "--link", link]) else { panic!("{link}") };
            assert_eq!(text, format!("--link {link}: bring-up measures a board; its link is {PORT}"));
        }
    }
}
