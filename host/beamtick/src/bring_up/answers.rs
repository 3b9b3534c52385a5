//! Whether a board's own image answers over a link: its clock and its USB are those that it takes
//! them for.
//!
//! In: a link, or none where its port is missing. Out: the rows of the page that this settles. A
//! port that is missing, or silent and maybe another device's, takes back no row that passed.
//! Nothing moves or lights. Fails: a link that cannot be opened for another reason, another board
//! than the one that is named, a Nucleo's link that is not its USB; a row that failed.
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

/// What became of opening a link: none where the port is not there, since a device that does not
/// answer its host has none. Fails for any other reason.
pub fn found(name: &str, opened: client::Result<Box<dyn Link>>) -> Result<Option<Box<dyn Link>>, Failure> {
    match opened {
        Ok(link) => Ok(Some(link)),
        Err(error) if client::link::is_missing(name) => {
            complain!("{error}");
            Ok(None)
        }
        Err(error) => Err(Failure::Input(format!("--link: {error}"))),
    }
}

/// See the module text.
pub fn over(link: Option<Box<dyn Link>>, board: AnsweringBoard, page: Option<&Path>) -> Result<(), Failure> {
    page::settle(page, || {
        let mut figures = Figures::default();
        let (is_usb, answered, is_proof) = match link {
            None => (true, 0, false),
            Some(mut link) => {
                let is_usb = link.is_boards_usb();
                if board == AnsweringBoard::Nucleo && !is_usb {
                    return Err(Failure::Input(
                        "--link: this port is not CN13's, whose product is Beamtick".to_owned(),
                    ));
                }
                // Its product says that the board is there.
                (is_usb, answered(link, board, &mut figures)?, is_usb)
            }
        };
        figures.add("answers", vec![i64::from(board == AnsweringBoard::Module), is_usb.into(), answered]);
        if answered == 0 && !is_proof {
            figures.add(page::UNPROVEN, Vec::new());
        }
        Ok(figures)
    })
}

/// Calls that the board answers, up to the first that it does not. The figures get its image.
fn answered(link: Box<dyn Link>, board: AnsweringBoard, figures: &mut Figures) -> Result<i64, Failure> {
    let client = match Client::open(link, Options::default()) {
        Ok(client) => client,
        // Nothing came, or the link ended.
        Err(failed) if failed.code == error::NO_ANSWER || is_dead(&failed) => {
            complain!("{failed}");
            return Ok(0);
        }
        Err(other) => return Err(other.into()),
    };
    let name = client.board();
    let is_module = name.starts_with("h743vi");
    if is_module != (board == AnsweringBoard::Module) {
        return Err(Failure::Input(format!("--answers: this board is {name}")));
    }
    figures.add_image_of(&client);
    Ok((0..CALLS).take_while(|_| client.call(GetClock {}).is_ok()).count() as i64)
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

    /// A port that is missing fails the row, but takes back no pass: its name may be a wrong one.
    #[test]
    fn a_missing_port_is_a_fail_and_takes_back_no_pass() {
        let (outcome, row) = after("not measured | why", "serial:/dev/no-such-port:3000000");
        assert!(matches!(outcome, Err(Failure::Job(_))) && row.starts_with("**FAIL** | no answer ("), "{row}");
        let (outcome, row) = after("pass | 100 calls answered (2026-01-01)", "serial:/dev/no-such-port:3000000");
        assert!(matches!(outcome, Err(Failure::Job(_))), "{outcome:?}");
        assert_eq!(row, "pass | 100 calls answered (2026-01-01) |");
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
