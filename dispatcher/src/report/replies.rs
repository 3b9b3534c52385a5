//! Reads: replies built from one view and the executed state, so that all their items are of one
//! tick.
//!
//! In: a checked [`Query`]. Out: a reply record. Velocities and accelerations are derived here from
//! the axis's [`servo::segment::piece::Motion`]; the tick computes nothing for them.
mod axes;
mod crd;
mod explain;
mod follow;
#[cfg(test)]
mod tests;

use super::event_log::{EVENTS_KEPT, Log};
use crate::board::{BoardConstants, FAULT_TEXT_MAX, Fault, FaultKind, TICK_BUCKET_NS, TICK_BUCKETS};
use crate::bounded_vec::collect;
use crate::configuration::{Configuration, ones};
use crate::io_words::{EDGES_READ_MAX, WORD, WORDS};
use crate::plan::path_queue::PathQueue;
use crate::report::answer::{MAX_POINTS, Query, Sent, TAKEN_MAX_VALUES};
use crate::shadow::Shadows;
use heapless::Vec;
use protocol::command::{self, Chapter, Request, chapter, opcode};
use protocol::record::ReplyWriter;
use protocol::values::{ANALOG_INPUT_VOLTS, io as kind, mode, wait};
use servo::laser::{CHANNELS, Count, Power, PowerMode, dac_counts};
use servo::path::PathStores;
use servo::port::AxisInputs;
use servo::segment::follow::{Input, WaitCondition};
use servo::segment::piece::Scaled;
use servo::status::RUNNING;
use servo::tables::TableStores;
use servo::units::Axis;
use servo::view::{AxisView, LaserView, View};
use zerocopy::IntoBytes;

/// The replies of one struct, by command: the struct is the one of the command's row.
macro_rules! fixed {
    (($query:ident, $tag:ident, $out:ident) $($name:ident => $reply:expr;)* _ => $other:expr) => {
        match $query.opcode {
            $(protocol::command::opcode::$name => {
                $out.done::<protocol::command::$name>($tag, &$reply, &[])
            })*
            _ => $other,
        }
    };
}
use fixed;

/// What a reply is built from.
pub struct Reading<'x, const AXES: usize> {
    /// What the tick published.
    pub view: &'x View<AXES>,
    /// State after everything executed.
    pub executed: &'x Shadows<AXES>,
    /// Counts.
    pub configuration: &'x Configuration,
    /// Constants of the board.
    pub board: &'x BoardConstants,
    /// Events.
    pub log: &'x Log,
    /// Analog outputs and counts of edges, as the tick has them.
    pub tables: TableStores<'x>,
    /// FIFOs of coordinate systems, and the look-aheads that feed them.
    pub paths: (PathStores<'x>, &'x [[PathQueue; 2]]),
}

/// 2^exponent, exactly, for exponents of normal numbers; beyond them 0 or infinity.
fn power(exponent: i32) -> f64 {
    match exponent {
        -1022..=1023 => f64::from_bits(((exponent + 1023) as u64) << 52),
        ..-1022 => 0.0,
        _ => f64::INFINITY,
    }
}

/// The nearest double.
pub fn number(value: Scaled) -> f64 {
    value.m as f64 * power(-i32::from(value.e))
}

/// A laser's power in its unit.
pub fn units(power: Power) -> f64 {
    power.raw() as f64 * self::power(-(Power::FRAC_BITS as i32))
}

/// Mean counts of a laser's timer.
pub fn counts(count: Count) -> f64 {
    let of = if count.of == 0 { power(32) } else { f64::from(count.of) };
    count.whole as f64 + f64::from(count.part) / of
}

/// The reply to a Calculate command.
pub fn values_reply(opcode: u16, tag: u16, values: impl Iterator<Item = f64>, out: &mut ReplyWriter) -> Sent {
    let items: Vec<_, MAX_POINTS> = collect(values.map(|value| command::Real { value: value.into() }));
    let head = command::Count { count: (items.len() as u16).into() };
    out.push_raw(opcode, tag, 0, &[head.as_bytes(), items.as_bytes()])
}

/// The reply to a laser command that reports what it took: `count` values, and which were limited.
pub fn took_reply(
    opcode: u16,
    tag: u16,
    taken: impl Iterator<Item = f64>,
    (count, limited): (u8, u8),
    out: &mut ReplyWriter,
) -> Sent {
    let (mut reals, mut whole) =
        ([command::Real::default(); TAKEN_MAX_VALUES], [command::ULong::default(); TAKEN_MAX_VALUES]);
    for ((real, whole), value) in reals.iter_mut().zip(&mut whole).zip(taken) {
        (real.value, whole.value) = (value.into(), (value as u32).into());
    }
    let count = usize::from(count);
    match opcode {
        // How many powers were limited.
        opcode::SetLaserFollowTable => out.push_raw(opcode, tag, 0, &[&(whole[0].value.get() as u16).to_le_bytes()]),
        opcode::SetLevelDelay | opcode::EnaFPK => {
            out.push_raw(opcode, tag, 0, &[whole.get(..count).unwrap_or(&[]).as_bytes(), &[limited]])
        }
        _ => out.push_raw(opcode, tag, 0, &[reals.get(..count).unwrap_or(&[]).as_bytes(), &[limited]]),
    }
}

// Status words and PT states travel as the tick has them.
const _: () = {
    use protocol::values::{pt_state, status};
    use servo::status as tick;
    assert!(status::ALARM == tick::ALARM && status::FOLLOWING_ERROR == tick::FOLLOWING_ERROR);
    assert!(status::LIMIT_POSITIVE == tick::LIMIT_POSITIVE && status::LIMIT_NEGATIVE == tick::LIMIT_NEGATIVE);
    assert!(status::STOP_SMOOTH == tick::STOP_SMOOTH && status::STOP_ABRUPT == tick::STOP_ABRUPT);
    assert!(status::SERVO_ON == tick::SERVO_ON && status::RUNNING == tick::RUNNING);
    assert!(status::IN_POSITION == tick::IN_POSITION && pt_state::RUNNING == tick::pt_state::RUNNING);
    assert!(pt_state::ENDED == tick::pt_state::ENDED && pt_state::UNDERRUN == tick::pt_state::UNDERRUN);
    assert!(pt_state::STOPPED == tick::pt_state::STOPPED);
};

// Capacities of a path are those of the tick.
const _: () = assert!(protocol::values::PATH_EFFECTS == servo::path::EFFECTS);
const _: () = assert!(protocol::values::CRD_FIFO_ENTRIES as usize == servo::path::ENTRIES);

// Stops of paths and causes of dark channels travel as the tick has them, too.
const _: () = {
    use protocol::values::{laser_fault, path_stop};
    use servo::laser::Cause;
    use servo::path::PathStop;
    assert!(path_stop::NEVER == PathStop::Never as u8 && path_stop::COMPLETED == PathStop::Completed as u8);
    assert!(path_stop::UNDERRUN == PathStop::Underrun as u8 && path_stop::STOPPED == PathStop::Stopped as u8);
    assert!(laser_fault::OVERRUN == Cause::Overrun as i16 && laser_fault::LIMIT == Cause::Limit as i16);
};

/// A mode as `GetPrfMode` reports it.
pub fn mode_number(of: servo::tick_command::MotionMode) -> i16 {
    use servo::tick_command::MotionMode;
    match of {
        MotionMode::Trap => mode::TRAP,
        MotionMode::Jog => mode::JOG,
        MotionMode::PtStatic | MotionMode::PtDynamic => mode::PT,
        MotionMode::Pvt => mode::PVT,
        MotionMode::Gear => mode::GEAR,
        MotionMode::Follow => mode::FOLLOW,
        MotionMode::FollowEx => mode::FOLLOW_EX,
        MotionMode::Crd => mode::CRD,
    }
}

impl<const AXES: usize> Reading<'_, AXES> {
    fn clock_ms(&self) -> u32 {
        (self.view.now.0 / 1_000_000) as u32
    }

    /// Writes the reply to a read.
    pub fn reply(&self, tag: u16, query: &Query, out: &mut ReplyWriter) -> Sent {
        let axis = Axis::new(usize::from(query.first)).unwrap_or_default();
        let shadow = self.executed.axis(axis);
        let sampled = &self.view.axes[axis.index().min(AXES - 1)];
        let loops = |passes: u32| i32::try_from(passes).unwrap_or(i32::MAX).into();
        let long = |value: i32| command::Long { value: value.into() };
        fixed! { (query, tag, out)
            Version => self.version();
            Choose => self.version();
            GetClock => command::Clock { clock_ms: self.clock_ms().into(), ticks: self.view.tick.into() };
            GetLinkLoss => command::LinkLossReply {
                time_ms: f64::from(self.executed.watch.link_loss_ms).into(),
                stop_all: i16::from(self.executed.watch.stop_all).into(),
            };
            GetStopDec => command::StopDec { smooth: shadow.dec.0.into(), abrupt: shadow.dec.1.into() };
            GetAxisBand => command::Band { band: shadow.band.0.into(), time_cycles: shadow.band.1.into() };
            GetSoftLimit => command::SoftLimit { positive: shadow.soft.0.into(), negative: shadow.soft.1.into() };
            GetPosErr => long(shadow.pos_err);
            GetTrapPrm => shadow.trap;
            GetJogPrm => shadow.jog;
            GetPos => long(shadow.pos);
            GetVel => command::Real { value: shadow.vel.into() };
            GetWait => self.wait(sampled);
            GetDi => self.levels(query)[0];
            GetDo => self.levels(query)[0];
            PtSpace => command::Short {
                value: (shadow.space(self.view, sampled, usize::from(query.which)) as i16).into(),
            };
            GetPtLoop => command::Long { value: loops(sampled.passes) };
            GetPtMemory => command::Short { value: i16::from(shadow.memory).into() };
            GetPtState => command::PtState {
                state: sampled.pt_state,
                loops: loops(sampled.passes),
                space0: (shadow.space(self.view, sampled, 0) as u16).into(),
                space1: if shadow.is_dynamic() { 0 } else { shadow.space(self.view, sampled, 1) as u16 }.into(),
                dry_ms: self.dry_ms(axis, usize::from(shadow.fifo)).into(),
            };
            GetPvtLoop => command::PvtLoops { loop_count: loops(sampled.passes), loop_set: shadow.table_passes.into() };
            _ => self.listed(tag, query, out)
        }
    }

    /// Replies with items, and those of other chapters.
    fn listed(&self, tag: u16, query: &Query, out: &mut ReplyWriter) -> Sent {
        match query.opcode {
            opcode::GetFault => self.fault(tag, out),
            opcode::GetTickTime => self.tick_time(tag, out),
            opcode::GetStack => self.stack(tag, out),
            opcode::GetEvents => self.events(tag, out),
            opcode::GetDiEx => self.words::<command::GetDiEx>(tag, query, out),
            opcode::GetDoEx => self.words::<command::GetDoEx>(tag, query, out),
            opcode::GetDac => {
                let outputs = (usize::from(query.first)..).take(query.count.into());
                let item = |output| command::Short { value: self.analog_output(output).into() };
                let items: Vec<_, 8> = collect(outputs.map(item));
                let head = command::Count { count: (items.len() as u16).into() };
                out.done::<command::GetDac>(tag, &head, &items)
            }
            opcode::GetDiReverseCount => {
                let input = Input::of_bits(query.which);
                let inputs = (query.first..).take(query.count.into());
                let counts = inputs.map(|index| command::ULong { value: self.tables.edges.of(input, index).into() });
                let items: Vec<_, { EDGES_READ_MAX as usize }> = collect(counts);
                let head = command::Count { count: (items.len() as u16).into() };
                out.done::<command::GetDiReverseCount>(tag, &head, &items)
            }
            opcode::GetAdc => {
                let inputs = self.view.analog.iter().skip(query.first.into()).take(query.count.into());
                let volts = |value: &i16| f64::from(*value) * ANALOG_INPUT_VOLTS / 32768.0;
                let items: Vec<_, 8> = collect(inputs.map(|value| command::Real { value: volts(value).into() }));
                let head = command::Reals { clock_ms: self.clock_ms().into(), count: (items.len() as u16).into() };
                out.done::<command::GetAdc>(tag, &head, &items)
            }
            other => match chapter(other) {
                Chapter::Laser => self.laser(tag, query, out),
                Chapter::Crd => self.crd_reply(tag, query, out),
                Chapter::Follow | Chapter::FollowEx | Chapter::Gear => self.follow(tag, query, out),
                Chapter::Other => self.axes_reply(tag, query, out),
            },
        }
    }

    /// A read of the laser channel `first`; `which` is the core.
    fn laser(&self, tag: u16, query: &Query, out: &mut ReplyWriter) -> Sent {
        let index = usize::from(query.first).min(CHANNELS - 1);
        let sampled = &self.view.lasers[index];
        let short = |value: i16| command::Short { value: value.into() };
        let own_crds = || {
            let profile = &self.configuration.profile;
            let map = u32::from(self.executed.lasers[index].map);
            let own = (1 << profile.crds_at(self.view.period)) - 1;
            map >> (u32::from(query.which) * u32::from(profile.crds_per_core)) & own
        };
        fixed! { (query, tag, out)
            GetLaserOnTime => command::ULong { value: sampled.on_time.into() };
            GetLaserCrdMap => short(own_crds() as i16);
            GetLaserPower => command::Real { value: units(sampled.power).into() };
            GetLaserFault => short(sampled.fault as i16);
            LaserStatus => command::LaserState {
                mode: i16::from(sampled.mode as u8).into(),
                commanded: sampled.commanded.into(),
                gate: sampled.switch.into(),
                light: sampled.light.into(),
                held: sampled.limited.into(),
                fault: (sampled.fault as i16).into(),
                power: units(sampled.power).into(),
                frequency: self.achieved_khz(sampled).into(),
                on_time: sampled.on_time.into(),
            };
            // The command, not the output (SPEC 6).
            GetHSIOOpt => short(sampled.commanded.into());
            _ => out.done::<command::LaserOnStatus>(tag, &short(sampled.commanded.into()), &[])
        }
    }

    /// The level of an analog output, from 0: the power of a laser in analog mode, or the last
    /// value set.
    fn analog_output(&self, output: usize) -> i16 {
        match self.view.lasers.get(output) {
            Some(laser) if laser.mode == PowerMode::Analog => dac_counts(laser.power),
            _ => self.tables.lasers.analog(output),
        }
    }

    /// The carrier or pulse rate as the timers output it, kHz; 0 without output.
    fn achieved_khz(&self, sampled: &LaserView) -> f64 {
        if sampled.train.is_none() {
            return 0.0;
        }
        f64::from(self.view.timer_mhz) * 1000.0 / counts(sampled.train.period)
    }

    /// The reply to PT data.
    pub fn taken(&self, axis: Axis, fifo: u8, count: u16) -> command::PtTaken {
        let sampled = &self.view.axes[axis.index().min(AXES - 1)];
        command::PtTaken {
            taken: count.into(),
            space: (self.executed.axis(axis).space(self.view, sampled, usize::from(fifo)) as u16).into(),
            dry_ms: self.dry_ms(axis, usize::from(fifo)).into(),
        }
    }

    /// While the axis runs, how long its data lasts; at standstill, the length of the data.
    fn dry_ms(&self, axis: Axis, fifo: usize) -> u32 {
        let sampled = &self.view.axes[axis.index().min(AXES - 1)];
        if sampled.status & RUNNING != 0 {
            return sampled.dry_ms;
        }
        self.executed.axis(axis).fifos.get(fifo).map_or(0, |fifo| fifo.chain.time_ms().max(0).unsigned_abs())
    }

    fn events(&self, tag: u16, out: &mut ReplyWriter) -> Sent {
        let items: Vec<_, EVENTS_KEPT> = collect(self.log.items().copied());
        let head = command::EventsReply { total: self.log.total.into(), count: (items.len() as u16).into() };
        out.done::<command::GetEvents>(tag, &head, &items)
    }

    /// The text is cut between characters.
    fn fault(&self, tag: u16, out: &mut ReplyWriter) -> Sent {
        let found = (self.board.contradiction)().map(|text| Fault { kind: FaultKind::Board, text });
        let (kind, text) = found.or(self.board.fault).map_or((0, ""), |fault| (fault.kind as u8, fault.text));
        let text = text.get(..text.floor_char_boundary(FAULT_TEXT_MAX)).unwrap_or("");
        let head = command::FaultReply { kind, length: (text.len() as u16).into() };
        out.push_raw(opcode::GetFault, tag, 0, &[head.as_bytes(), text.as_bytes()])
    }

    fn version(&self) -> command::VersionReply {
        let mut board = [0; 16];
        for (slot, byte) in board.iter_mut().zip(self.board.name.bytes()) {
            *slot = byte;
        }
        let part = |text: &str| text.bytes().fold(0u16, |sum, digit| sum * 10 + u16::from(digit.saturating_sub(b'0')));
        let profile = &self.configuration.profile;
        command::VersionReply {
            major: part(env!("CARGO_PKG_VERSION_MAJOR")).into(),
            minor: part(env!("CARGO_PKG_VERSION_MINOR")).into(),
            patch: part(env!("CARGO_PKG_VERSION_PATCH")).into(),
            schema: protocol::SCHEMA.into(),
            board,
            profile: self.configuration.number,
            family: self.configuration.family,
            cores: profile.cores,
            axes_per_core: profile.axes_per_core,
            lasers: profile.lasers,
            crds_per_core: profile.crds_per_core,
            general_inputs: profile.general_inputs.min(self.board.general_inputs),
            general_outputs: profile.general_outputs.min(self.board.general_outputs),
            tick_us: ((self.view.period.0 / 1000) as u32).into(),
            step_limit: (self.board.step_limit.pulses_per_ms() as f64).into(),
        }
    }

    fn tick_time(&self, tag: u16, out: &mut ReplyWriter) -> Sent {
        let taken = self.board.tick_time.map(|ask| ask());
        let time = taken.unwrap_or_default();
        let items: Vec<_, TICK_BUCKETS> =
            collect(time.histogram.into_iter().map(|ticks| command::ULong { value: ticks.into() }));
        let head = command::TickTimeReply {
            period_ns: (self.view.period.0 as u32).into(),
            median_ns: time.median_ns.into(),
            worst_ns: time.worst_ns.into(),
            recent_ns: time.recent_ns.into(),
            measured: taken.is_some().into(),
            bucket_ns: TICK_BUCKET_NS.into(),
            count: (items.len() as u16).into(),
        };
        out.done::<command::GetTickTime>(tag, &head, &items)
    }

    fn stack(&self, tag: u16, out: &mut ReplyWriter) -> Sent {
        let asked = self.board.stack.map(|ask| ask());
        let stack = asked.unwrap_or_default();
        let head = command::StackReply {
            size: stack.size.into(),
            unused: stack.unused.into(),
            measured: asked.is_some().into(),
        };
        out.done::<command::GetStack>(tag, &head, &[])
    }

    /// What an axis waits for; it is numbered on its own core.
    fn wait(&self, axis: &AxisView) -> command::WaitReply {
        let per_core = self.configuration.per_core().max(1);
        match axis.waits.what() {
            None => command::WaitReply::default(),
            Some(WaitCondition::Pass) => command::WaitReply { kind: wait::PASS, ..Default::default() },
            Some(WaitCondition::Input { input, index, high, limited }) => {
                let (di_type, of) = match input {
                    Input::LimitPositive => (kind::LIMIT_POSITIVE, per_core),
                    Input::LimitNegative => (kind::LIMIT_NEGATIVE, per_core),
                    Input::Alarm => (kind::ALARM, per_core),
                    Input::Home => (kind::HOME, per_core),
                    Input::Arrive => (kind::ARRIVE, per_core),
                    Input::General => (kind::GPI, 256),
                };
                command::WaitReply {
                    kind: wait::INPUT,
                    di_type: di_type.into(),
                    index: ((usize::from(index) % of) as i16 + 1).into(),
                    level: i16::from(high).into(),
                    limited: limited.into(),
                }
            }
        }
    }

    /// Words of 32 levels: of the core's axes from bit 0, or of the general inputs or outputs.
    fn levels(&self, query: &Query) -> [command::Long; WORDS] {
        let (first, axes) = (usize::from(query.first) * self.configuration.per_core(), self.configuration.per_core());
        let of_axes = |bits: u64| u128::from(bits >> first & ones(axes));
        let of_inputs = |level: fn(&AxisInputs) -> bool| {
            let levels = self.view.inputs.iter().skip(first).take(axes).map(level);
            (0..).zip(levels).fold(0, |word, (bit, level)| word | u128::from(level) << bit)
        };
        let profile = &self.configuration.profile;
        let levels = match i16::from(query.which) {
            kind::LIMIT_POSITIVE => of_inputs(|inputs| inputs.limit_positive),
            kind::LIMIT_NEGATIVE => of_inputs(|inputs| inputs.limit_negative),
            kind::ALARM => of_inputs(|inputs| inputs.alarm),
            kind::HOME => of_inputs(|inputs| inputs.home),
            kind::ARRIVE => of_inputs(|inputs| inputs.arrive),
            kind::GPI => {
                let unused = 128 - u32::from(profile.general_inputs.clamp(1, 128));
                #[allow(clippy::unnecessary_cast, reason = "a small board has fewer bits")]
                let levels = self.view.general_inputs as u128;
                levels & u128::MAX >> unused
            }
            kind::ENABLE => of_axes(self.view.enable),
            kind::CLEAR => of_axes(self.view.clear),
            _ => u128::from(self.view.general_outputs),
        };
        let mut words = [command::Long::default(); WORDS];
        for (word, at) in words.iter_mut().zip((0..).step_by(WORD)) {
            word.value = ((levels >> at) as u32).cast_signed().into();
        }
        words
    }

    /// The reply to a read of levels, word by word.
    fn words<R: Request<Reply = command::Count, ReplyItem = command::Long>>(
        &self,
        tag: u16,
        query: &Query,
        out: &mut ReplyWriter,
    ) -> Sent {
        let count = usize::from(query.count).min(WORDS);
        out.done::<R>(tag, &command::Count { count: (count as u16).into() }, &self.levels(query)[..count])
    }
}
