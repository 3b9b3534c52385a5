//! What wants a hand: the program says what to do, waits, and judges.
//!
//! In: [`Hands`]. Out: the rows of the page that this settles. Owns nothing. Fails: a board that
//! does not answer before the hand has done anything, an answer that is no number; a row that
//! failed.
use super::lines::Figures;
use super::options::ByHand;
use super::{is_silence, measure, own_image, page, uncut};
use crate::Failure;
use crate::interrupt::Held;
use client::Link;
use protocol::command::{GetClock, GetFault, SetDac, Short};
use std::io::BufRead;
use std::path::Path;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// So often a prompt looks whether a signal has come.
const LOOKS_FOR_SIGNALS: Duration = Duration::from_millis(50);
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
    /// Lets so many ms pass.
    fn pause(&mut self, ms: u64);
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

    fn pause(&mut self, ms: u64) {
        std::thread::sleep(Duration::from_millis(ms));
    }

    fn ask(&mut self, what: &str) -> Result<String, Failure> {
        complain!("{what}");
        let (sender, receiver) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let mut line = String::new();
            let read = std::io::stdin().lock().read_line(&mut line);
            // Nobody waits for it any more once a signal has come.
            let _ = sender.send(read.map(|count| (count, line)));
        });
        loop {
            uncut()?;
            match receiver.recv_timeout(LOOKS_FOR_SIGNALS) {
                Ok(Ok((0, _))) => return Err(Failure::Input("--hands: the standard input has ended".to_owned())),
                Ok(Ok((_, line))) => return Ok(line.trim().to_owned()),
                Ok(Err(error)) => {
                    return Err(Failure::Input(format!("--hands: the standard input cannot be read: {error}")));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Failure::Input("--hands: the standard input has ended".to_owned()));
                }
            }
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

/// The port is looked for so often, in ms, once it is gone.
const LOOKS_MS: u64 = 200;
/// A port that stays away for so long has another name, or does not come again.
const AWAY_MS: i64 = 600_000;
/// A port that is there again may take so long until it can be opened.
const OPENS_MS: i64 = 5000;

/// The same, and how long the cable was out: its port is gone then. Nobody presses a key for its
/// end, since that would measure the hand.
fn unplug(hands: &mut dyn Hands) -> Result<Figures, Failure> {
    let mut out_ms = 0;
    let (mut figures, line) = through(hands, |hands| {
        hands.ask("The board must have its supply at VIN (JP2) already. Unplug CN1 now. Then press Enter.")?;
        if hands.is_out() {
            complain!("CN1 is out. Wait for 10 s or more, and plug it in again. The program sees that by itself.");
            // It was out, however short that was.
            out_ms = time_out(hands)?.max(1);
        }
        Ok(())
    })?;
    figures.add("unplug", line.into_iter().chain([out_ms]).collect());
    Ok(figures)
}

/// Waits until the port is there again. Returns the time from the first look that did not find it
/// to the last one, in ms: the cable was out for at least as long.
fn time_out(hands: &mut dyn Hands) -> Result<i64, Failure> {
    let began = hands.now_ms();
    let mut out = 0;
    loop {
        uncut()?;
        hands.pause(LOOKS_MS);
        let now = hands.now_ms();
        if !hands.is_out() {
            break;
        }
        out = now - began;
        if out > AWAY_MS {
            return Err(Failure::Job(format!(
                "the port has not come again in {} minutes: look whether it has another name now, and give the command again \
                 with that",
                AWAY_MS / 60_000
            )));
        }
    }
    let there = hands.now_ms();
    while hands.link().is_err() && hands.now_ms() - there < OPENS_MS {
        hands.pause(LOOKS_MS);
    }
    Ok(out)
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
/// However it fails, the light is ended by a byte.
fn clock(hands: &mut dyn Hands) -> Result<Figures, Failure> {
    hands.ask(
        "The board must have its supply at VIN (JP2) already, with jumper 6 alone. Find the contact that holds the ST-LINK itself in \
         reset (docs/bring-up.md); Ctrl-C if there is none. Enter makes both laser outputs active.",
    )?;
    // From here on a signal ends it through `uncut`, so that no light is left.
    let _held = Held::new();
    let (link, mut may_shine) = (hands.link()?, false);
    found_by_guard(hands, link, &mut may_shine).map_err(|failure| {
        let said = match hands.link().is_ok_and(|mut link| is_dark(&mut *link)) {
            true => ". The board says that the light has ended",
            // A board answers the order before it lights.
            false if is_silence(&failure) && !may_shine => "",
            false => ". Both lasers may be lit for five minutes: press B2 at the board",
        };
        failure.with(said)
    })
}

/// Says as soon as there may be light.
fn found_by_guard(hands: &mut dyn Hands, mut link: Box<dyn Link>, may_shine: &mut bool) -> Result<Figures, Failure> {
    let lit = measure(&mut *link, b"lit\n")?;
    *may_shine = true;
    drop(link);
    if lit.only::<3>("lit") != Some([1; 3]) {
        return Err(Failure::Job("there is no light: jumper 6 (docs/bring-up.md) is missing".to_owned()));
    }
    hands.ask(
        "Both laser outputs are active. Hold the ST-LINK in reset for a second by its own NRST (T_NRST is the STM32H743's). \
         Then press Enter. Enter alone ends the light, too.",
    )?;
    measure(&mut *hands.link()?, b"why\n")
}

/// What the board says when a byte has ended the light.
const DARK: &[u8] = b"# a byte has ended the light";
/// The board says so in this time, if it does.
const ANSWERS_NS: u64 = 500_000_000;

/// Sends bytes, the first of which ends the light: whether the board says that it has. One that
/// comes in the dark after the order counts for nothing, so more follow.
fn is_dark(link: &mut dyn Link) -> bool {
    let (began, mut said, mut bytes) = (link.now(), Vec::new(), [0; 64]);
    let mut sent = Ok(());
    while sent.is_ok() && link.now() - began < ANSWERS_NS {
        sent = link.send(b"\n");
        if sent.is_err() {
            break;
        }
        sent = link.receive(&mut bytes, Duration::from_millis(20)).map(|count| {
            said.extend_from_slice(&bytes[..count]);
        });
        if said.windows(DARK.len()).any(|text| text == DARK) {
            return true;
        }
    }
    false
}

/// Voltages of both outputs, by a meter.
fn dac(hands: &mut dyn Hands) -> Result<Figures, Failure> {
    let client = own_image(hands.link()?)?;
    if !client.board().contains("dac8563") {
        return Err(Failure::Job(format!("board {} has no external DAC", client.board())));
    }
    // From here on a signal ends it through `uncut`, so that no voltage is left.
    let _held = Held::new();
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
        fn pause(&mut self, _: u64) {}
        fn now_ms(&mut self) -> i64 {
            0
        }
    }

    /// A board that says these lines.
    struct Lit {
        says: &'static [u8],
        at: u64,
    }

    impl Link for Lit {
        fn name(&self) -> &str {
            "lit"
        }
        fn send(&mut self, _: &[u8]) -> client::Result<()> {
            Ok(())
        }
        fn receive(&mut self, buf: &mut [u8], wait: Duration) -> client::Result<usize> {
            self.at += wait.as_nanos() as u64;
            let now = std::mem::take(&mut self.says);
            buf[..now.len()].copy_from_slice(now);
            Ok(now.len())
        }
        fn now(&mut self) -> u64 {
            self.at
        }
    }

    /// What the board says to each link that is opened, the last one first, and how often Enter is
    /// pressed.
    struct GoesAway(Vec<&'static str>, usize);

    impl Hands for GoesAway {
        fn link(&mut self) -> Result<Box<dyn Link>, Failure> {
            let says = self.0.pop().ok_or_else(|| Failure::Job("the port is gone".to_owned()))?.as_bytes();
            Ok(Box::new(Lit { says, at: 0 }))
        }
        fn pause(&mut self, _: u64) {}
        fn ask(&mut self, _: &str) -> Result<String, Failure> {
            let ended = || Failure::Input("--hands: the standard input has ended".to_owned());
            self.1 = self.1.checked_sub(1).ok_or_else(ended)?;
            Ok(String::new())
        }
        fn now_ms(&mut self) -> i64 {
            0
        }
    }

    /// Whoever leaves a board whose lasers are lit has ended the light. The message says how to
    /// end it where the board does not say that it is dark, and where its port is gone.
    #[test]
    fn a_hand_that_goes_away_under_light_is_told_of_it() {
        let line = |text: &str| format!("{text}*{:02X}\r\n", text.bytes().fold(0, |all, byte| all ^ byte));
        let lit: &'static str = String::leak(["format 2", "lit 1 1 1", "end 2"].map(line).concat());
        let dark = "\r\n# a byte has ended the light\r\n";
        const PRESS: &str = ". Both lasers may be lit for five minutes: press B2 at the board";
        for (says, ending) in [
            (vec![dark, lit], ". The board says that the light has ended"),
            (vec!["# a byte", lit], PRESS),
            (vec!["", lit], PRESS),
            (vec![lit], PRESS),
        ] {
            let Err(Failure::Input(text)) = with(&mut GoesAway(says, 1), ByHand::Clock, None) else {
                panic!("it went on")
            };
            assert_eq!(text, format!("--hands: the standard input has ended{ending}"));
        }
        // Nothing has answered the order, so nothing has lit; and no port, so nothing heard it.
        let Err(Failure::Job(text)) = with(&mut GoesAway(vec!["", ""], 1), ByHand::Clock, None) else { panic!() };
        assert_eq!(text, super::super::NO_ANSWER);
        let Err(Failure::Job(text)) = with(&mut GoesAway(vec![], 1), ByHand::Clock, None) else { panic!() };
        assert_eq!(text, "the port is gone");
        // It was lit, and is silent afterwards.
        let Err(Failure::Job(text)) = with(&mut GoesAway(vec!["", "", lit], 2), ByHand::Clock, None) else { panic!() };
        assert_eq!(text, format!("{}{PRESS}", super::super::NO_ANSWER));
        // Whatever has said anything may have heard it.
        let Err(Failure::Job(text)) = with(&mut GoesAway(vec!["", "noise"], 1), ByHand::Clock, None) else { panic!() };
        assert!(text.starts_with("5 bytes have come, ") && text.ends_with(PRESS), "{text}");
        // Before there was light nothing is sent: no link is opened.
        let Err(Failure::Input(text)) = with(&mut GoesAway(Vec::new(), 0), ByHand::Clock, None) else { panic!() };
        assert_eq!(text, "--hands: the standard input has ended");
    }

    /// The cable's time has neither what a hand needs before, nor what comes after.
    #[test]
    fn the_time_of_a_cable_is_from_its_port_that_is_gone_to_its_port_that_is_there() {
        struct Cable(i64, std::ops::Range<i64>);
        impl Hands for Cable {
            fn link(&mut self) -> Result<Box<dyn Link>, Failure> {
                match self.1.contains(&self.0) {
                    true => Err(Failure::Job("gone".to_owned())),
                    false => Ok(Box::new(Lit { says: b"", at: 0 })),
                }
            }
            fn pause(&mut self, ms: u64) {
                self.0 += ms as i64;
            }
            fn ask(&mut self, _: &str) -> Result<String, Failure> {
                panic!("nobody is asked")
            }
            fn now_ms(&mut self) -> i64 {
                self.0
            }
        }
        // The last look that does not find it is at 12,700 ms, from the first one at 2500.
        assert_eq!(time_out(&mut Cable(2500, 1000..12_850)).unwrap(), 10_200);
        let Err(Failure::Job(text)) = time_out(&mut Cable(0, 0..i64::MAX)) else { panic!("it came") };
        assert!(text.starts_with("the port has not come again in 10 minutes: look whether"), "{text}");
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
