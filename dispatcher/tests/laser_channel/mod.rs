//! A laser channel on the bench: its commands, and what is visible of it.
use crate::bench::Bench;
use protocol::command::*;
use servo::laser::Power;
use servo::view::LaserView;

pub const GUS: u8 = 0;

pub const LSR: u8 = 1;

pub fn bench(family: u8) -> Bench<8> {
    let mut bench = Bench::gus();
    bench.done(Choose { profile: 0, family });
    bench
}

pub fn seen(bench: &mut Bench<8>, channel: usize) -> LaserView {
    bench.server.view().lasers[channel]
}

pub fn units(power: Power) -> f64 {
    power.raw() as f64 / 2f64.powi(Power::FRAC_BITS as i32)
}

pub fn mode(mode: i16, max: f64, min: f64, channel: i16, delay_mode: i16) -> LaserPowerMode {
    LaserPowerMode {
        core: 1.into(),
        mode: mode.into(),
        max: max.into(),
        min: min.into(),
        channel: channel.into(),
        delay_mode: delay_mode.into(),
    }
}

pub fn power(power: f64, channel: i16) -> LaserPrfCmd {
    LaserPrfCmd { core: 1.into(), power: power.into(), channel: channel.into() }
}

pub fn carrier(frequency: f64, channel: i16) -> LaserOutFrq {
    LaserOutFrq { core: 1.into(), frequency: frequency.into(), channel: channel.into() }
}

pub fn switch(value: u16, channel: i16) -> SetHSIOOpt {
    SetHSIOOpt { core: 1.into(), value: value.into(), channel: channel.into() }
}

pub fn connector(axis: i16, mode: i16) -> SetAxisMode {
    SetAxisMode { core: 1.into(), axis: axis.into(), mode: mode.into() }
}

pub fn delays(off: u32, on: u32, channel: i16) -> SetLevelDelay {
    SetLevelDelay { core: 1.into(), off_delay_us: off.into(), on_delay_us: on.into(), channel: channel.into() }
}

pub fn on_time(bench: &mut Bench<8>, channel: i16) -> u32 {
    bench.done(GetLaserOnTime { core: 1.into(), channel: channel.into() }).value.get()
}

pub fn fault(bench: &mut Bench<8>, channel: i16) -> i16 {
    bench.done(GetLaserFault { core: 1.into(), channel: channel.into() }).value.get()
}

pub fn commanded(bench: &mut Bench<8>, channel: i16) -> i16 {
    let reported = bench.done(GetHSIOOpt { core: 1.into(), channel: channel.into() }).value.get();
    let status = bench.done(LaserOnStatus { core: 1.into(), channel: channel.into() }).value.get();
    assert_eq!(reported, status);
    reported
}

/// Duty mode with 40 % of 10 kHz, light off.
pub fn prepared(bench: &mut Bench<8>, family: u8, channel: i16) {
    if family == GUS {
        bench.done(connector(7 + channel, 1));
    }
    bench.done(mode(0, 100.0, 0.0, channel, 0));
    bench.done(carrier(10.0, channel));
    bench.done(power(40.0, channel));
}
