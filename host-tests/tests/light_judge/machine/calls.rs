//! Calls of a program as requests.
//!
//! In: a call. Out: a request on its way, whose answer the rig takes.
use super::super::program::{Buf, Do};
use super::{JOG, Rig, full};
use host_tests::light_judge::fact::Laser;
use protocol::command::*;
use protocol::record::Lane;

impl Rig {
    pub(super) fn call(&mut self, call: &Do) {
        let core = 1.into();
        macro_rules! push {
            ($request:expr) => {{
                let request = $request;
                self.send(|writer, tag| full(writer.push(Lane::Immediate, tag, &request, &[])));
            }};
        }
        let number = |of: usize| (of as i16 + 1).into();
        let short = |of: usize| (of as i16).into();
        match *call {
            Do::Entry { crd, fifo, buf } => self.entry(crd, fifo, buf),
            Do::Flush { crd, fifo } => push!(CrdData { core, crd: number(crd), fifo: short(fifo) }),
            Do::On { channel, hsio: false } => push!(LaserOn { core, channel: short(channel) }),
            Do::Off { channel, hsio: false } => push!(LaserOff { core, channel: short(channel) }),
            Do::On { channel, .. } => push!(SetHSIOOpt { core, value: 1.into(), channel: short(channel) }),
            Do::Off { channel, .. } => push!(SetHSIOOpt { core, value: 0.into(), channel: short(channel) }),
            Do::Power { channel, power } => {
                push!(LaserPrfCmd { core, power: power.into(), channel: short(channel) });
            }
            Do::Map { channel, map } => {
                push!(SetLaserCrdMap { core, channel: short(channel), map: i16::from(map).into() });
            }
            Do::Delays { channel, on, off } => {
                push!(SetLevelDelay { core, off_delay_us: off.into(), on_delay_us: on.into(), channel: short(channel) })
            }
            Do::Mode { channel, mode } => push!(power_mode(channel, mode)),
            Do::Jog { vel } => {
                push!(SetVel { core, profile: JOG.into(), vel: vel.into() });
                self.codes.pop();
                self.waiting.pop();
                push!(Update { core, mask: (1 << (JOG - 1)).into() });
            }
            Do::Connector { channel, there } => {
                push!(SetAxisMode { core, axis: (7 + channel as i16).into(), mode: i16::from(there).into() })
            }
            Do::ClearFault { channel } => push!(ClrLaserFault { core, channel: short(channel) }),
            Do::ClearStatus { axis, count } => push!(ClrSts { core, axis: number(axis), count: short(count) }),
            Do::CrdStart { mask, option } => {
                push!(CrdStart { core, mask: i16::from(mask).into(), option: i16::from(option).into() });
            }
            Do::Stop { crds, abrupt, ends_follow } => {
                let mask = i32::from(crds) << 8 | i32::from(ends_follow) << 10;
                push!(Stop { core, mask: mask.into(), option: (i32::from(abrupt) << 8).into(), form: 1 });
            }
            Do::CrdStop { crds, abrupt } => {
                push!(CrdStop { core, mask: i32::from(crds).into(), option: i32::from(abrupt).into() });
            }
            Do::AxisStop { axis } => push!(Stop { core, mask: (1 << axis).into(), option: 0.into(), form: 0 }),
            Do::CrdClear { crd, fifo } => {
                push!(CrdClear { core, crd: number(crd), fifo: short(fifo) });
                // A mark that was cleared away leaves the output as it is.
                let bit = 2 * crd + fifo;
                if self.board.crd(crd).runs {
                    self.clears[bit] = Some(self.codes.len() - 1);
                } else {
                    self.marks[bit] = self.board.outputs().general >> bit & 1 == 0;
                }
            }
            Do::AxisOff { axis } => push!(AxisOff { core, axis: number(axis) }),
            Do::AxisOn { axis } => push!(AxisOn { core, axis: number(axis) }),
            Do::Abort => push!(Abort { core }),
            Do::LinkLoss { ms } => push!(SetLinkLoss { time_ms: ms.into(), stop_all: 0.into() }),
            Do::Interlock { motion } => push!(SetInterlock { motion: motion.into() }),
            Do::PosErr { axis, pulses } => push!(SetPosErr { core, control: number(axis), error: pulses.into() }),
        }
    }

    fn entry(&mut self, crd: usize, fifo: usize, buf: Buf) {
        let core = 1.into();
        let (number, place) = ((crd as i16 + 1).into(), (fifo as i16).into());
        macro_rules! push {
            ($request:expr) => {{
                let request = $request;
                self.send(|writer, tag| full(writer.push(Lane::Immediate, tag, &request, &[])));
            }};
        }
        match buf {
            Buf::Line { to: [x, y], speed, acc, end } => push!(LnXY {
                core,
                crd: number,
                x: x.into(),
                y: y.into(),
                syn_vel: speed.into(),
                syn_acc: acc.into(),
                vel_end: end.into(),
                fifo: place
            }),
            Buf::Delay(ms) => push!(BufDelay { core, crd: number, delay_ms: ms.into(), fifo: place }),
            Buf::Mark => {
                let bit = 2 * crd + fifo;
                if !self.board.crd(crd).runs
                    && let Some(clear) = self.clears[bit].take()
                    && self.codes.get(clear).is_none_or(|code| code.is_none_or(|code| code == 0))
                {
                    self.marks[bit] = self.board.outputs().general >> bit & 1 == 0;
                }
                let level = self.marks[bit];
                self.marks[bit] = !level;
                let (index, value) = ((bit as u16 + 1).into(), i16::from(level).into());
                push!(BufDoBit { core, crd: number, do_type: 12.into(), index, value, fifo: place });
            }
            Buf::Laser { channel, laser, power, ratio } => {
                let channel = (channel as i16).into();
                match laser {
                    Laser::On => push!(BufLaserOn { core, crd: number, fifo: place, channel }),
                    Laser::Off => push!(BufLaserOff { core, crd: number, fifo: place, channel }),
                    Laser::Power => {
                        push!(BufLaserPrfCmd { core, crd: number, power: power.into(), fifo: place, channel });
                    }
                    Laser::Source => push!(BufLaserFollowMode {
                        core,
                        crd: number,
                        source: 0.into(),
                        fifo: place,
                        channel,
                        start_power: 0.0.into(),
                        start_given: 0
                    }),
                    Laser::Follow if self.is_gus && !ratio => push!(BufLaserPrfFollow {
                        core,
                        crd: number,
                        ratio: 0.1.into(),
                        min: (power as i32).into(),
                        max: (power as i32 + 4).into(),
                        fifo: place,
                        channel
                    }),
                    Laser::Follow => push!(BufLaserFollowRatio {
                        core,
                        crd: number,
                        ratio: 0.1.into(),
                        min: power.into(),
                        max: (power + 4.0).into(),
                        fifo: place,
                        channel
                    }),
                    Laser::FollowOff => push!(BufLaserFollowOff { core, crd: number, fifo: place, channel }),
                }
            }
        }
    }
}

/// A mode, with its full range.
pub(super) fn power_mode(channel: usize, mode: i16) -> LaserPowerMode {
    let max = match mode {
        1 => 40.0,
        2 => 10.0,
        _ => 100.0,
    };
    LaserPowerMode {
        core: 1.into(),
        mode: mode.into(),
        max: max.into(),
        min: 0.0.into(),
        channel: (channel as i16).into(),
        delay_mode: 1.into(),
    }
}
