//! Jumper 6, by which a bench is known before anything on it moves or lights.
//!
//! In: a board whose output 5 is low. Out: nothing, once it is shown that the interlock follows
//! output 5: closed, open while the output is high, closed again. Owns output 5 meanwhile, and
//! leaves it low. No machine has its interlock at a general output, so nothing moves or lights
//! there. Fails: an interlock that does anything else, with what to do.
use super::loads::{Check, wait};
use crate::Failure;
use client::Client;
use protocol::command::{ClrLaserFault, GetDo, GetLaserFault, SetDoBit};
use protocol::reason::{Code, laser_cause};

/// General outputs (MC_GPO).
const OUTPUTS: i16 = 12;
/// The output at which the jumper is.
const OUTPUT: i16 = 5;
/// The cause of a fault by the interlock.
const INTERLOCK: i16 = 1;
/// In this time an output is out, and the interlock is sampled.
const FOLLOWS_MS: u32 = 5;

/// What to do, after what was found.
const TO_DO: &str = "Nothing was moved or lit. Take this board off its machine, connect nothing but jumpers to it, and put \
    jumper 6 in (docs/bring-up.md): D2 (CN10), D37 (CN10), D60 (CN9), D49 (CN8) and D20 (CN7), all joined at one point";

/// See the module text.
pub fn prove(client: &Client, check: Check<'_>) -> Result<(), Failure> {
    let refused = |found: &str| Failure::Job(format!("{found}. {TO_DO}"));
    let outputs = client.call(GetDo { core: 1.into(), do_type: OUTPUTS.into() })?.value.get();
    if outputs >> (OUTPUT - 1) & 1 != 0 {
        return Err(refused("output 5 is in use: it is high"));
    }
    if faults(client)? != [0; 2] {
        return Err(refused("the lasers are kept dark: the interlock is open, or see `beamtick info`"));
    }
    let opened = set(client, true).and_then(|()| wait(client, FOLLOWS_MS, check)).and_then(|()| causes(client));
    // Low again, whatever was found.
    set(client, false)?;
    let opened = opened?;
    wait(client, FOLLOWS_MS, check)?;
    if opened != [INTERLOCK; 2] {
        return Err(refused(
            "the interlock stays closed while output 5 is high: something else than jumper 6 closes it",
        ));
    }
    if faults(client)? != [0; 2] {
        return Err(refused("the interlock stays open although output 5 is low again"));
    }
    Ok(())
}

fn set(client: &Client, high: bool) -> Result<(), Failure> {
    let (core, do_type) = (1.into(), OUTPUTS.into());
    client.call(SetDoBit { core, do_type, index: OUTPUT.into(), value: i16::from(high).into() })?;
    Ok(())
}

fn causes(client: &Client) -> Result<[i16; 2], Failure> {
    let mut causes = [0; 2];
    for (channel, cause) in (0i16..).zip(&mut causes) {
        *cause = client.call(GetLaserFault { core: 1.into(), channel: channel.into() })?.value.get();
    }
    Ok(causes)
}

/// What keeps the lasers dark once what is over was cleared.
fn faults(client: &Client) -> Result<[i16; 2], Failure> {
    for channel in 0..2i16 {
        match client.call(ClrLaserFault { core: 1.into(), channel: channel.into() }) {
            // What lasts is not cleared, and is asked for below.
            Err(error) if error.code != Code::State as i16 => return Err(error.into()),
            _ => {}
        }
    }
    causes(client)
}

/// What keeps a laser dark, if anything does.
pub fn fault(client: &Client, channel: i16) -> Result<Option<&'static str>, Failure> {
    let cause = causes(client)?[channel as usize];
    Ok((cause != 0).then(|| laser_cause(cause)))
}
