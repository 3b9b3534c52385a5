//! Reads of consecutive axes, all of one tick: an item for each axis.
use super::{Reading, mode_number, number};
use crate::bounded_vec::collect;
use crate::plan::geometry::pulses;
use crate::plan::pvt::table_number;
use crate::report::answer::{Query, Sent};
use crate::shadow::AxisShadow;
use heapless::Vec;
use protocol::command::{self, Count, Long, Longs, Real, Reals, Request, opcode};
use protocol::record::ReplyWriter;
use servo::view::AxisView;

/// What stands before the items.
trait Head {
    fn new(clock_ms: u32, count: u16) -> Self;
}

impl Head for Reals {
    fn new(clock_ms: u32, count: u16) -> Self {
        Reals { clock_ms: clock_ms.into(), count: count.into() }
    }
}

impl Head for Longs {
    fn new(clock_ms: u32, count: u16) -> Self {
        Longs { clock_ms: clock_ms.into(), count: count.into() }
    }
}

impl Head for Count {
    fn new(_: u32, count: u16) -> Self {
        Count { count: count.into() }
    }
}

impl<const AXES: usize> Reading<'_, AXES> {
    /// A reply with an item for each axis.
    fn each<R: Request<Reply: Head>>(
        &self,
        tag: u16,
        query: &Query,
        out: &mut ReplyWriter,
        item: impl Fn(&AxisView, &AxisShadow) -> R::ReplyItem,
    ) -> Sent {
        let axes = self.view.axes.iter().zip(&self.executed.axes).skip(query.first.into()).take(query.count.into());
        let items: Vec<_, AXES> = collect(axes.map(|(axis, shadow)| item(axis, shadow)));
        out.done::<R>(tag, &R::Reply::new(self.clock_ms(), items.len() as u16), &items)
    }

    /// Encoder velocity from two samples one tick apart, pulse/ms.
    fn encoder_velocity(&self, axis: &AxisView) -> f64 {
        if self.view.period.0 == 0 {
            return 0.0;
        }
        axis.encoder.wrapping_sub(axis.encoder_before) as f64 * 1e6 / self.view.period.0 as f64
    }

    /// Reads of consecutive axes.
    pub(super) fn axes_reply(&self, tag: u16, query: &Query, out: &mut ReplyWriter) -> Sent {
        macro_rules! each {
            ($($name:ident => $item:expr;)* _ => $last:ident, $last_item:expr) => {
                match query.opcode {
                    $(opcode::$name => self.each::<command::$name>(tag, query, out, $item),)*
                    _ => self.each::<command::$last>(tag, query, out, $last_item),
                }
            };
        }
        let real = |value: f64| Real { value: value.into() };
        let long = |value: i32| Long { value: value.into() };
        each! {
            GetSts => |axis, _| long(axis.status.cast_signed());
            GetPrfMode => |_, shadow| long(mode_number(shadow.mode).into());
            GetPrfPos => |axis, _| real(pulses(axis.pos));
            GetPrfVel => |axis, _| real(number(self.view.velocity(axis)));
            GetPrfAcc => |axis, _| real(number(self.view.motion(axis).acceleration()));
            GetEncPos => |axis, _| real(axis.encoder as f64);
            GetEncVel => |axis, _| real(self.encoder_velocity(axis));
            GetCaptureStatus => |axis, _| command::CaptureReply {
                status: i16::from(axis.captured.is_some()).into(),
                value: (axis.captured.unwrap_or(0).clamp(i32::MIN.into(), i32::MAX.into()) as i32).into(),
                clock_ms: self.clock_ms().into(),
            };
            PvtStatus => |axis, _| {
                let since = self.view.now.0.min(axis.table_until.0).saturating_sub(axis.table_zero.0);
                command::PvtStatusItem { table: table_number(axis.table).into(), time: (since as f64 / 1e6).into() }
            };
            _ => AxisStatus, |axis, shadow| command::AxisItem {
                status: axis.status.into(),
                mode: mode_number(shadow.mode).into(),
                reason: (axis.stop as u16).into(),
                prf_pos: pulses(axis.pos).into(),
                prf_vel: number(self.view.velocity(axis)).into(),
                enc_pos: (axis.encoder as f64).into(),
            }
        }
    }
}
