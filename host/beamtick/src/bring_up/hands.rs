//! What wants a hand: the program says what to do, waits, and judges.
//!
//! In: [`Hands`]. Out: the rows of the page that this settles. Owns nothing. Fails: a board that
//! does not answer before the hand has done anything, an answer that is no number; a row that
//! failed.
use super::lines::Figures;
use super::options::ByHand;
use super::{measure, own_image, page};
use crate::Failure;
use client::Link;
use protocol::command::{GetClock, GetFault, SetDac, Short};
use std::io::BufRead;
use std::path::Path;
use std::time::Instant;

/// More than any analog output gives.
const VOLTS_MAX: f64 = 100.0;

/// Somebody at the board.
pub trait Hands {
    /// The link, opened anew: a cable may have been out.
    fn link(&mut self) -> Result<Box<dyn Link>, Failure>;
    /// Whether the link's port is gone.
    fn is_out(&mut self) -> bool {
        self.link().is_err()
    }
    /// Says what to do, and returns the line that is typed once it is done.
    fn ask(&mut self, what: &str) -> Result<String, Failure>;
    /// Time, in ms from anywhere.
    fn now_ms(&mut self) -> i64;
}

/// A person at a terminal.
pub struct Terminal<'a> {
    link: &'a str,
    since: Instant,
}

impl<'a> Terminal<'a> {
    /// At the board of this link.
    pub fn at(link: &'a str) -> Terminal<'a> {
        Terminal { link, since: Instant::now() }
    }
}

impl Hands for Terminal<'_> {
    fn link(&mut self) -> Result<Box<dyn Link>, Failure> {
        Ok(client::link::open(self.link)?)
    }

    fn is_out(&mut self) -> bool {
        // A port that another program has open is there.
        client::link::is_missing(self.link)
    }

    fn ask(&mut self, what: &str) -> Result<String, Failure> {
        complain!("{what}");
        let mut line = String::new();
        match std::io::stdin().lock().read_line(&mut line) {
            Ok(0) => Err(Failure::Input("--hands: the standard input has ended".to_owned())),
            Ok(_) => Ok(line.trim().to_owned()),
            Err(error) => Err(Failure::Input(format!("--hands: the standard input cannot be read: {error}"))),
        }
    }

    fn now_ms(&mut self) -> i64 {
        self.since.elapsed().as_millis() as i64
    }
}

/// See the module text.
pub fn with(hands: &mut dyn Hands, what: ByHand, page: Option<&Path>) -> Result<(), Failure> {
    page::settle(page, || match what {
        ByHand::Halt => halt(
            hands,
            "Halt the core with a debugger for two seconds and let it go on: `probe-rs debug --chip STM32H743ZITx`, `halt`, \
             wait, `run`, `quit`. Then press Enter.",
        ),
        ByHand::Unplug => unplug(hands),
        ByHand::Clock => clock(hands),
        ByHand::Dac => dac(hands),
    })
}

/// The board's time in ms, and the kind of its fault. The figures get its image.
fn state(hands: &mut dyn Hands, figures: &mut Figures) -> Result<(i64, i64), Failure> {
    let client = own_image(hands.link()?)?;
    if !client.board().contains("h743") {
        return Err(Failure::Job(format!("board {} is none with an STM32H743", client.board())));
    }
    figures.add_image_of(&client);
    let clock = client.call(GetClock {})?.clock_ms.get();
    let (fault, _) = client.call_items(GetFault {}, &[])?;
    Ok((clock.into(), fault.kind.into()))
}

/// Time, the board's of it, its fault.
fn halt(hands: &mut dyn Hands, what: &str) -> Result<Figures, Failure> {
    let (mut figures, line) = through(hands, |hands| hands.ask(what).map(drop))?;
    figures.add("halt", line.to_vec());
    Ok(figures)
}

/// The same, and whether the cable was out: its port is gone then.
fn unplug(hands: &mut dyn Hands) -> Result<Figures, Failure> {
    let mut was_out = false;
    let (mut figures, line) = through(hands, |hands| {
        hands.ask("The board must have its supply at VIN (JP2) already. Unplug CN1 now. Then press Enter.")?;
        was_out = hands.is_out();
        if was_out {
            hands.ask("Wait for a minute, and plug CN1 in again. Once its port is there, press Enter.")?;
        }
        Ok(())
    })?;
    figures.add("unplug", line.into_iter().chain([was_out.into()]).collect());
    Ok(figures)
}

/// How much of the time in which a hand does something passes on the board: a negative number where
/// it was reset.
fn through(
    hands: &mut dyn Hands,
    does: impl FnOnce(&mut dyn Hands) -> Result<(), Failure>,
) -> Result<(Figures, [i64; 3]), Failure> {
    let (before, old_fault) = state(hands, &mut Figures::default())?;
    let began = hands.now_ms();
    does(hands)?;
    let mut figures = Figures::default();
    let (after, fault) = state(hands, &mut figures)?;
    let passed = hands.now_ms() - began;
    // A clock that began anew shows no more than has passed.
    if (before..=passed).contains(&after) {
        return Err(Failure::Job(format!(
            "whether the board was reset cannot be told: it had run for {before} ms, and this took {passed} ms. Leave it on \
             for some minutes, then do this again"
        )));
    }
    // Only a reset brings a fault to the page: this one is from before.
    let fault = if after > passed && fault == old_fault { 0 } else { fault };
    Ok((figures, [passed, after - before, fault]))
}

/// The bring-up image lights both lasers until the clock stops, and says what its NMI found.
fn clock(hands: &mut dyn Hands) -> Result<Figures, Failure> {
    let lit = measure(&mut *hands.link()?, b"lit\n")?;
    if lit.only::<3>("lit") != Some([1; 3]) {
        return Err(Failure::Job("there is no light: jumper 6 (docs/bring-up.md) is missing".to_owned()));
    }
    let mut goes_on = || {
        hands.ask(
            "Both lasers are lit. Hold the ST-LINK in reset for a second by its own NRST (T_NRST is the STM32H743's). \
             Then press Enter.",
        )?;
        measure(&mut *hands.link()?, b"why\n")
    };
    goes_on().map_err(|failure| failure.with(". Both lasers may be lit for five minutes: press B2 at the board"))
}

/// Voltages of both outputs, by a meter.
fn dac(hands: &mut dyn Hands) -> Result<Figures, Failure> {
    let client = own_image(hands.link()?)?;
    if !client.board().contains("dac8563") {
        return Err(Failure::Job(format!("board {} has no external DAC", client.board())));
    }
    let set = |output: i16, volts: i64| {
        let code = Short { value: ((volts * 32_767 / 10) as i16).into() };
        client.call_items(SetDac { core: 1.into(), dac: output.into(), count: 1.into() }, &[code])
    };
    let mut figures = Figures::default();
    figures.add_image_of(&client);
    let mut measured = || -> Result<(), Failure> {
        for output in 1..=2i16 {
            for volts in [0, 5, 10] {
                set(output, volts)?;
                let said = hands.ask(&format!("Measure analog output {output}. How many volts?"))?;
                let Ok(is) = said.trim_end_matches(['V', 'v', ' ']).replace(',', ".").parse::<f64>() else {
                    return Err(Failure::Input(format!("--hands: {said} is no voltage")));
                };
                // NaN is within no bound.
                if !(-VOLTS_MAX..=VOLTS_MAX).contains(&is) {
                    return Err(Failure::Input(format!("--hands: {said} is beyond {VOLTS_MAX} V")));
                }
                figures.add("dac", vec![output.into(), volts * 1000, (is * 1e3).round() as i64]);
            }
            set(output, 0)?;
        }
        Ok(())
    };
    let outcome = measured();
    // However it ends, no voltage is left.
    let rests = (1..=2).try_for_each(|output| set(output, 0).map(drop));
    outcome?;
    rests?;
    Ok(figures)
}

#[cfg(test)]
mod tests {
    use super::*;
    use virtual_board::{Board, Config, Shared, VirtualLink, share};

    /// A hand at a virtual controller.
    struct Elsewhere(Shared, usize);

    impl Hands for Elsewhere {
        fn link(&mut self) -> Result<Box<dyn Link>, Failure> {
            Ok(Box::new(VirtualLink::new(self.0.clone())))
        }
        fn ask(&mut self, _: &str) -> Result<String, Failure> {
            self.1 += 1;
            Ok(String::new())
        }
        fn now_ms(&mut self) -> i64 {
            0
        }
    }

    /// A board that says these lines, whatever is sent to it, and a hand that goes away.
    struct Lit(&'static [u8]);

    impl Link for Lit {
        fn name(&self) -> &str {
            "lit"
        }
        fn send(&mut self, _: &[u8]) -> client::Result<()> {
            Ok(())
        }
        fn receive(&mut self, buf: &mut [u8], _: std::time::Duration) -> client::Result<usize> {
            let now = std::mem::take(&mut self.0);
            buf[..now.len()].copy_from_slice(now);
            Ok(now.len())
        }
        fn now(&mut self) -> u64 {
            0
        }
    }

    struct GoesAway(&'static [u8]);

    impl Hands for GoesAway {
        fn link(&mut self) -> Result<Box<dyn Link>, Failure> {
            Ok(Box::new(Lit(self.0)))
        }
        fn ask(&mut self, _: &str) -> Result<String, Failure> {
            Err(Failure::Input("--hands: the standard input has ended".to_owned()))
        }
        fn now_ms(&mut self) -> i64 {
            0
        }
    }

    /// Whoever leaves a board whose lasers are lit is told how to end the light.
    #[test]
    fn a_hand_that_goes_away_under_light_is_told_of_it() {
        let line = |text: &str| format!("{text}*{:02X}\r\n", text.bytes().fold(0, |all, byte| all ^ byte));
        let lines: String = ["format 2", "lit 1 1 1", "end 2"].map(line).concat();
        let mut hands = GoesAway(String::leak(lines).as_bytes());
        let Err(Failure::Input(text)) = with(&mut hands, ByHand::Clock, None) else { panic!("it went on") };
        assert!(
            text.contains("has ended. Both lasers may be lit") && text.ends_with("press B2 at the board"),
            "{text}"
        );
    }

    /// Nobody is asked to do anything at another board.
    #[test]
    fn a_hand_at_another_board_is_refused() {
        let mut hands = Elsewhere(share(Board::new(Config::default())), 0);
        for (what, why) in [
            (ByHand::Halt, "is none with an STM32H743"),
            (ByHand::Unplug, "is none with an STM32H743"),
            (ByHand::Dac, "has no external DAC"),
        ] {
            let Err(Failure::Job(text)) = with(&mut hands, what, None) else { panic!("{what:?}") };
            assert!(text.starts_with("board ") && text.ends_with(why), "{text}");
        }
        assert_eq!(hands.1, 0);
    }
}
