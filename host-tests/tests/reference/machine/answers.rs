//! What reads gave, as the judge compares it.
use super::{light, paths};
use client::Answer;
use host_tests::reference::{Call, Effect, Item, Kind, Points};
use protocol::command::*;

/// What a read gave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Got {
    Nothing,
    Whole(i64),
    Two(i64, i64),
    Three(i64, i64, i64),
    CrdPosition([f64; 4]),
    Reals([f64; 4]),
    Table(i64, f64),
    Real(f64),
}

fn short(answer: &Answer) -> Option<Got> {
    let of = |reply: protocol::command::Short| Got::Whole(reply.value.get().into());
    let ex = answer.reply::<GetFollowMemoryEx>().map(|(reply, _)| of(reply));
    ex.or_else(|| answer.reply::<GetFollowMemory>().map(|(reply, _)| of(reply)))
}

fn event(reply: &FollowEventReply) -> Got {
    Got::Three(reply.event.get().into(), reply.master_dir.get().into(), reply.pos.get().into())
}

fn master(reply: &FollowMasterReply) -> Got {
    let kind = reply.master_type.get().into();
    Got::Three(reply.master_index.get().into(), kind, reply.master_item.get().into())
}

/// The value of an answer with code 0.
pub fn got(call: &Call, answer: &Answer) -> Got {
    let real = |items: Vec<Real>| Got::Real(items.first().map_or(f64::NAN, |item| item.value.get()));
    let long = |items: Vec<Long>| Got::Whole(items.first().map_or(i64::MIN, |item| item.value.get().into()));
    let read = match call {
        Call::Axis { kind, .. } => match kind {
            Kind::GetPtLoop => answer.reply::<GetPtLoop>().map(|(reply, _)| Got::Whole(reply.value.get().into())),
            Kind::GetPvtLoop => answer
                .reply::<GetPvtLoop>()
                .map(|(reply, _)| Got::Two(reply.loop_count.get().into(), reply.loop_set.get().into())),
            Kind::GetFollowLoop => {
                answer.reply::<GetFollowLoop>().map(|(reply, _)| Got::Whole(reply.value.get().into()))
            }
            Kind::GetFollowStatus => answer
                .reply::<GetFollowStatus>()
                .map(|(reply, _)| Got::Two(reply.fifo.get().into(), reply.switch_status.get().into())),
            Kind::GetFollowLoopEx => {
                answer.reply::<GetFollowLoopEx>().map(|(reply, _)| Got::Whole(reply.value.get().into()))
            }
            Kind::GetFollowStatusEx => answer
                .reply::<GetFollowStatusEx>()
                .map(|(reply, _)| Got::Two(reply.fifo.get().into(), reply.switch_status.get().into())),
            // Both forms have one layout.
            Kind::GetFollowMemory | Kind::GetFollowMemoryEx => short(answer),
            Kind::GetFollowEvent => answer.reply::<GetFollowEvent>().map(|(reply, _)| event(&reply)),
            Kind::GetFollowEventEx => answer.reply::<GetFollowEventEx>().map(|(reply, _)| event(&reply)),
            Kind::GetFollowMaster => answer.reply::<GetFollowMaster>().map(|(reply, _)| master(&reply)),
            Kind::GetFollowMasterEx => answer.reply::<GetFollowMasterEx>().map(|(reply, _)| master(&reply)),
            Kind::GetEncPos => answer.reply::<GetEncPos>().map(|(_, items)| real(items)),
            Kind::GetSts => answer.reply::<GetSts>().map(|(_, items)| long(items)),
            Kind::GetStopReason => {
                answer.reply::<AxisStatus>().and_then(|(_, items)| Some(Got::Whole(items.first()?.reason.get().into())))
            }
            Kind::GetCaptureStatus => answer.reply::<GetCaptureStatus>().and_then(|(_, items)| {
                let first = items.first()?;
                Some(Got::Two(first.status.get().into(), first.value.get().into()))
            }),
            Kind::GetPrfMode => answer.reply::<GetPrfMode>().map(|(_, items)| long(items)),
            Kind::GetPrfPos => answer.reply::<GetPrfPos>().map(|(_, items)| real(items)),
            Kind::GetPrfVel => answer.reply::<GetPrfVel>().map(|(_, items)| real(items)),
            Kind::GetPrfAcc => answer.reply::<GetPrfAcc>().map(|(_, items)| real(items)),
            Kind::GetEncVel => answer.reply::<GetEncVel>().map(|(_, items)| real(items)),
            Kind::GetTrapPrm => answer.reply::<GetTrapPrm>().map(|(of, _)| {
                let smooth = f64::from(of.smooth_time_ms.get());
                Got::Reals([of.acc.get(), of.dec.get(), of.vel_start.get(), smooth])
            }),
            Kind::GetJogPrm => answer
                .reply::<GetJogPrm>()
                .map(|(of, _)| Got::Reals([of.acc.get(), of.dec.get(), of.smooth.get(), 0.0])),
            Kind::GetPos => answer.reply::<GetPos>().map(|(of, _)| Got::Whole(of.value.get().into())),
            Kind::GetVel => answer.reply::<GetVel>().map(|(of, _)| Got::Reals([of.value.get(), 0.0, 0.0, 0.0])),
            Kind::GetSoftLimit => answer
                .reply::<GetSoftLimit>()
                .map(|(of, _)| Got::Two(of.positive.get().into(), of.negative.get().into())),
            Kind::GetStopDec => {
                answer.reply::<GetStopDec>().map(|(of, _)| Got::Reals([of.smooth.get(), of.abrupt.get(), 0.0, 0.0]))
            }
            Kind::GetAxisBand => {
                answer.reply::<GetAxisBand>().map(|(of, _)| Got::Two(of.band.get().into(), of.time_cycles.get().into()))
            }
            Kind::GetPosErr => answer.reply::<GetPosErr>().map(|(of, _)| Got::Whole(of.value.get().into())),
            Kind::GetPtMemory => answer.reply::<GetPtMemory>().map(|(of, _)| Got::Whole(of.value.get().into())),
            Kind::PvtStatus => answer.reply::<PvtStatus>().and_then(|(_, items)| {
                let first = items.first()?;
                Some(Got::Table(first.table.get().into(), first.time.get()))
            }),
            _ => None,
        },
        Call::PtSpace { .. } => answer.reply::<PtSpace>().map(|(reply, _)| Got::Whole(reply.value.get().into())),
        Call::FollowSpace { .. } => {
            answer.reply::<FollowSpace>().map(|(reply, _)| Got::Whole(reply.value.get().into()))
        }
        Call::Ex(of) if matches!(**of, Call::FollowSpace { .. }) => {
            answer.reply::<FollowSpaceEx>().map(|(reply, _)| Got::Whole(reply.value.get().into()))
        }
        Call::AsymmetricWay { .. } => {
            answer.reply::<GetFollowDataPercent2Ex>().map(|(reply, _)| Got::Reals([reply.value.get(), 0.0, 0.0, 0.0]))
        }
        Call::FollowEntry { item: Item::Asymmetric(_), .. } => {
            answer.reply::<FollowDataPercent2Ex>().map(|(reply, _)| Got::Whole(reply.percent1.get().into()))
        }
        Call::PvtCalculate { points, .. } => {
            let items = match points {
                Points::Percent(..) => answer.reply::<PvtPercentCalculate>().map(|(_, items)| items),
                _ => answer.reply::<PvtContinuousCalculate>().map(|(_, items)| items),
            };
            items.filter(|items| items.len() > 1).map(|items| {
                let at = |index: usize| items[index].value.get();
                Got::Reals([at(0), at(1), at(items.len() - 1), items.len() as f64])
            })
        }
        Call::Path(of) => paths::got(of, answer),
        Call::Light(of) => light::got(of, answer),
        Call::Effect(Effect::GetDo { .. }) => {
            answer.reply::<GetDo>().map(|(reply, _)| Got::Whole(reply.value.get().into()))
        }
        Call::Effect(Effect::GetAdc { .. }) => {
            answer.reply::<GetAdc>().and_then(|(_, items)| Some(Got::Real(items.first()?.value.get())))
        }
        Call::Effect(Effect::GetDi { .. }) => {
            answer.reply::<GetDi>().map(|(reply, _)| Got::Whole(reply.value.get().into()))
        }
        Call::Effect(Effect::GetDoEx { .. }) => {
            answer.reply::<GetDoEx>().and_then(|(_, items)| Some(Got::Whole(items.first()?.value.get().into())))
        }
        Call::Effect(Effect::GetDiEx { .. }) => {
            answer.reply::<GetDiEx>().and_then(|(_, items)| Some(Got::Whole(items.first()?.value.get().into())))
        }
        Call::Effect(Effect::GetDac { .. }) => answer.reply::<GetDac>().and_then(|(_, items)| {
            let first = items.first()?;
            Some(Got::Whole(first.value.get().into()))
        }),
        _ => None,
    };
    read.unwrap_or(Got::Nothing)
}
