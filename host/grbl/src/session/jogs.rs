//! `$J=`, and what ends a jog.
//!
//! In: a line, or the byte that ends jogs. Out: entries of the path, answers. Owns nothing. Fails
//! with the link's error.
use super::{After, Session, is_end};
use crate::errors;
use client::Error;

/// What a jog begins with.
const JOG: &[u8] = b"$J=";

impl Session<'_> {
    /// `$J=`.
    pub(crate) fn jog(&mut self, text: &str) -> Result<(), Error> {
        if self.alarm.is_some() || self.checks || !(self.jogs || self.feed.idle()) {
            self.message(self.not_now());
            self.answer(errors::NOT_IDLE);
            return Ok(());
        }
        match self.stream.jog(text) {
            Ok(calls) => {
                self.enter(&calls)?;
                self.jogs = true;
                self.answer(0);
            }
            Err(why) => {
                self.message(&why);
                self.answer(errors::number(&why));
            }
        }
        Ok(())
    }

    /// Ends the jog, and those that wait. Whether there was one, and nothing else that moves.
    pub(super) fn cancel_jog(&mut self) -> Result<bool, Error> {
        let waited = self.drop_jogs();
        if self.jogs && self.settles.is_none() {
            self.feed.hold()?;
            self.settle(After::Jog);
        }
        Ok(self.jogs || waited && self.feed.idle())
    }

    /// Jogs whose lines have come and that no other line comes before: answered, and not run. They
    /// may come in one packet with what ends them. Whether there was one.
    fn drop_jogs(&mut self) -> bool {
        let mut dropped = false;
        let answers = self.waits.is_none() && !self.owes && !self.overflow;
        while answers && self.alarm.is_none() && !self.checks && !self.sleeps {
            let Some(end) = self.received.iter().position(|byte| is_end(*byte)) else { break };
            let text =
                self.line.iter().chain(self.received.iter().take(end)).filter(|byte| !byte.is_ascii_whitespace());
            let begin: Vec<u8> = text.take(JOG.len()).map(u8::to_ascii_uppercase).collect();
            let is_jog = begin == JOG;
            if !is_jog && !begin.is_empty() {
                break;
            }
            self.received.drain(..=end);
            self.line.clear();
            self.lines += 1;
            self.answer(0);
            dropped |= is_jog;
        }
        dropped
    }
}
