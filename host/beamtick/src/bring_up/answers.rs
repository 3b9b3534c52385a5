//! Whether a board's own image answers over a link: its clock and its USB are those that it takes
//! them for.
//!
//! In: a link. Out: the rows of the page that this settles. Nothing moves or lights. A port that
//! is missing or silent, and does not say itself that it is a board's, settles no row: its name or
//! its rate may be wrong. Fails: such a port, a link that cannot be opened, another board than the
//! one that is named, a Nucleo's link that is not its USB; a row that failed.
use super::options::AnsweringBoard;
use super::page;
use crate::Failure;
use crate::bring_up::lines::Figures;
use client::error::{self, is_dead};
use client::{Client, Link, Options};
use protocol::command::GetClock;
use std::path::Path;

/// Calls that are answered.
pub const CALLS: u32 = 100;

/// What to do about a port at which nothing answers.
const NOTHING: &str = "No row of the page is settled by that. Look whether this is the board's port (`ls /dev/ttyACM*`; macOS: `ls \
    /dev/cu.usbmodem*`; Windows: the Device Manager) and, at a UART, its rate, 3000000. Look whether the board's own image \
    runs and not the bring-up image: `cargo flash-board`. Then unplug the board, plug it in, and give the command again. If all of that \
    is right and nothing answers: docs/bring-up.md, \"Where a board says nothing\"";

/// A link that was opened. Fails with what to do where it was not.
pub fn found(name: &str, opened: client::Result<Box<dyn Link>>) -> Result<Box<dyn Link>, Failure> {
    opened.map_err(|error| match client::link::is_missing(name) {
        true => Failure::Input(format!("--link: {error}. {NOTHING}")),
        false => Failure::Input(format!("--link: {error}")),
    })
}

/// See the module text.
pub fn over(mut link: Box<dyn Link>, board: AnsweringBoard, page: Option<&Path>) -> Result<(), Failure> {
    page::settle(page, || {
        let mut figures = Figures::default();
        let is_usb = link.is_boards_usb();
        if board == AnsweringBoard::Nucleo && !is_usb {
            return Err(Failure::Input("--link: this port is not CN13's, whose product is Beamtick".to_owned()));
        }
        let calls = match answered(link, board, &mut figures)? {
            Ok(calls) => calls,
            // Its product says that the board is there.
            Err(silent) if is_usb => {
                complain!("{silent}");
                0
            }
            Err(silent) => return Err(Failure::Job(format!("{silent}. {NOTHING}"))),
        };
        figures.add("answers", vec![i64::from(board == AnsweringBoard::Module), is_usb.into(), calls]);
        Ok(figures)
    })
}

/// Calls that the board answers, up to the first that it does not; or why there was no first
/// answer. The figures get its image.
fn answered(link: Box<dyn Link>, board: AnsweringBoard, figures: &mut Figures) -> Result<client::Result<i64>, Failure> {
    let client = match Client::open(link, Options::default()) {
        Ok(client) => client,
        // Nothing came, or the link ended.
        Err(failed) if failed.code == error::NO_ANSWER || is_dead(&failed) => return Ok(Err(failed)),
        Err(other) => return Err(other.into()),
    };
    let name = client.board();
    let is_module = name.starts_with("h743vi");
    if is_module != (board == AnsweringBoard::Module) {
        return Err(Failure::Input(format!("--answers: this board is {name}")));
    }
    figures.add_image_of(&client);
    Ok(Ok((0..CALLS).take_while(|_| client.call(GetClock {}).is_ok()).count() as i64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const ROW: &str = "| USB of the Nucleo answers | 27 | ";

    /// Results of a page that has this one, after `--answers nucleo` found this link.
    fn after(result: &str, link: &str) -> (Result<(), Failure>, String) {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        let vain = page::settle(Some(&page), || Ok(Figures::default()));
        assert!(
            matches!(vain, Err(Failure::Job(text)) if text.starts_with("nothing was measured. Give the command again"))
        );
        let text = fs::read_to_string(&page).unwrap();
        let line = text.lines().find(|line| line.starts_with(ROW)).unwrap();
        fs::write(&page, text.replacen(line, &format!("{ROW}{result} |"), 1)).unwrap();
        let outcome =
            crate::call(&["bring-up", "--link", link, "--answers", "nucleo", "--page", page.to_str().unwrap()]);
        let text = fs::read_to_string(&page).unwrap();
        (outcome, text.lines().find_map(|line| line.strip_prefix(ROW)).unwrap().to_owned())
    }

    /// A port that is missing or silent settles no row: it may be another one. A pass stays.
    #[test]
    fn a_port_where_nothing_answers_is_reported_and_blames_no_row() {
        for row in ["not measured | why", "pass | 100 calls answered (2026-01-01)"] {
            let (outcome, after) = after(row, "serial:/dev/no-such-port:3000000");
            let Err(Failure::Input(text)) = &outcome else { panic!("{outcome:?}") };
            assert!(text.starts_with("--link: cannot open serial:/dev/no-such-port:3000000: "), "{text}");
            assert!(text.contains(NOTHING) && text.contains("ls /dev/ttyACM*"), "{text}");
            assert_eq!(after, format!("{row} |"));
        }
        let silent = || -> Box<dyn Link> { Box::new(Silent(false, 0)) };
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        let Err(Failure::Job(text)) = over(silent(), AnsweringBoard::Module, Some(&page)) else { panic!("it passed") };
        assert!(text.starts_with("silent does not answer (") && text.ends_with(NOTHING), "{text}");
        assert!(!page.exists(), "a fresh page blames a row");
        // What says itself that it is the board's USB has failed.
        let outcome = over(Box::new(Silent(true, 0)), AnsweringBoard::Module, Some(&page));
        assert!(matches!(outcome, Err(Failure::Job(text)) if text.starts_with("1 row failed; ")));
        let text = fs::read_to_string(&page).unwrap();
        assert!(text.contains("| USB of the module answers without VBUS | 29 | **FAIL** | no answer ("), "{text}");
    }

    /// A port where nothing ever comes, and whether it is a board's own USB.
    struct Silent(bool, u64);

    impl Link for Silent {
        fn name(&self) -> &str {
            "silent"
        }
        fn send(&mut self, _: &[u8]) -> client::Result<()> {
            Ok(())
        }
        fn receive(&mut self, _: &mut [u8], wait: std::time::Duration) -> client::Result<usize> {
            self.1 += wait.as_nanos() as u64;
            Ok(0)
        }
        fn now(&mut self) -> u64 {
            self.1
        }
        fn real_time(&self) -> bool {
            false
        }
        fn is_boards_usb(&mut self) -> bool {
            self.0
        }
    }

    /// A link that cannot be opened for another reason is an error of the command line.
    #[test]
    fn a_link_that_cannot_be_opened_leaves_the_page() {
        let folder = tempfile::tempdir().unwrap();
        let no_port = folder.path().join("file");
        fs::write(&no_port, "").unwrap();
        let serial = format!("serial:{}:3000000", no_port.display());
        for link in [serial.as_str(), "tcp:127.0.0.1:1"] {
            let (outcome, row) = after("not measured | why", link);
            assert!(matches!(&outcome, Err(Failure::Input(text)) if text.contains("cannot open")), "{outcome:?}");
            assert_eq!(row, "not measured | why |", "{link}");
        }
    }
}
