//! Whether a board's own image answers over a link: its clock and its USB are those that it takes
//! them for.
//!
//! In: a link, or why there is none. Out: the rows of the page that this settles. Nothing moves or
//! lights. Fails: another board than the one that is named, a Nucleo's link that is not its USB; a
//! row that failed.
use super::options::AnsweringBoard;
use super::page;
use crate::Failure;
use crate::bring_up::lines::Figures;
use client::{Client, Link, Options};
use protocol::command::GetClock;
use std::path::Path;

/// Calls that are answered.
const CALLS: u32 = 100;

/// See the module text.
pub fn over(link: client::Result<Box<dyn Link>>, board: AnsweringBoard, page: Option<&Path>) -> Result<(), Failure> {
    page::settle(page, || {
        let mut figures = Figures::default();
        let (is_usb, answered) = match link {
            // A device that is not there has no port.
            Err(_) => (true, 0),
            Ok(mut link) => {
                let is_usb = link.is_boards_usb();
                if board == AnsweringBoard::Nucleo && !is_usb {
                    return Err(Failure::Input(
                        "--link: this port is not CN13's, whose product is Beamtick".to_owned(),
                    ));
                }
                (is_usb, answered(link, board, &mut figures)?)
            }
        };
        figures.add("answers", vec![i64::from(board == AnsweringBoard::Module), is_usb.into(), answered]);
        Ok(figures)
    })
}

/// Calls that the board answers: all, or none. The figures get its image.
fn answered(link: Box<dyn Link>, board: AnsweringBoard, figures: &mut Figures) -> Result<i64, Failure> {
    let Ok(client) = Client::open(link, Options::default()) else { return Ok(0) };
    let name = client.board();
    let is_module = name.starts_with("h743vi");
    if is_module != (board == AnsweringBoard::Module) {
        return Err(Failure::Input(format!("--answers: this board is {name}")));
    }
    figures.add_image_of(&client);
    Ok(if (0..CALLS).all(|_| client.call(GetClock {}).is_ok()) { CALLS.into() } else { 0 })
}
