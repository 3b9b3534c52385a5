//! Coordinate systems, as calls travel and as they are answered.
use super::Got;
use client::{Answer, Call as Wire};
use host_tests::path_model::Plane;
use host_tests::reference::{Cycle, Path, PathCall, Setup};
use protocol::command::*;

pub fn wire(setup: &Setup, of: &PathCall) -> Wire {
    let core = of.core.into();
    match &of.what {
        Path::Set { crd, axes, vel, acc, even_ms, origin } => {
            let profile = PathCall::profile(setup, axes).map(Into::into);
            let origins = origin.as_ref().map_or([0; 8], |origin| PathCall::origins(setup, axes, origin));
            Wire::of(SetCrdPrm {
                core,
                crd: (*crd).into(),
                dimension: (axes.len() as i16).into(),
                profile,
                syn_vel_max: (*vel).into(),
                syn_acc_max: (*acc).into(),
                even_time_ms: (*even_ms).into(),
                set_origin_flag: i16::from(origin.is_some()).into(),
                origin_pos: origins.map(Into::into),
            })
        }
        Path::Wait { mask } => Wire::of(WaitStop { core, axes: 0.into(), crds: mask.cast_signed().into() }),
        &Path::GetPrm { crd } => Wire::of(GetCrdPrm { core, crd: crd.into() }),
        &Path::Clear { crd, fifo } => Wire::of(CrdClear { core, crd: crd.into(), fifo: fifo.into() }),
        &Path::Space { crd, fifo } => Wire::of(CrdSpace { core, crd: crd.into(), fifo: fifo.into() }),
        &Path::Start { mask, option } => Wire::of(CrdStart { core, mask: mask.into(), option: option.into() }),
        &Path::Stop { mask, option } => Wire::of(CrdStop { core, mask: mask.into(), option: option.into() }),
        &Path::Status { crd, fifo } => Wire::of(CrdStatus { core, crd: crd.into(), fifo: fifo.into() }),
        &Path::Remainder { crd, fifo } => Wire::of(GetRemainderSegNum { core, crd: crd.into(), fifo: fifo.into() }),
        &Path::Filter { crd, ms } => Wire::of(SetLaserFollowFilter { core, crd: crd.into(), time_ms: ms.into() }),
        &Path::GetFilter { crd } => Wire::of(GetLaserFollowFilter { core, crd: crd.into() }),
        &Path::Why { crd } => Wire::of(CrdInfo { core, crd: crd.into() }),
        &Path::Pos { crd } => Wire::of(GetCrdPos { core, crd: crd.into() }),
        &Path::Vel { crd } => Wire::of(GetCrdVel { core, crd: crd.into() }),
        &Path::StopDec { crd, smooth } => {
            Wire::of(SetCrdStopDec { core, crd: crd.into(), smooth: smooth.into(), abrupt: 1000.0.into() })
        }
        &Path::Override { crd, ratio } => Wire::of(SetOverride { core, crd: crd.into(), ratio: ratio.into() }),
        &Path::Delay { crd, ms, fifo } => {
            Wire::of(BufDelay { core, crd: crd.into(), delay_ms: ms.into(), fifo: fifo.into() })
        }
        &Path::Outputs { crd, mask, value, fifo } => {
            let (do_type, do_mask, do_value) = (12.into(), mask.into(), value.into());
            Wire::of(BufIO { core, crd: crd.into(), do_type, do_mask, do_value, fifo: fifo.into() })
        }
        &Path::Output { crd, index, level, fifo } => Wire::of(BufDoBit {
            core,
            crd: crd.into(),
            do_type: 12.into(),
            index: index.cast_unsigned().into(),
            value: i16::from(level).into(),
            fifo: fifo.into(),
        }),
        &Path::Jump { crd, to: [x, y], vel, acc, fifo } => Wire::of(LnXYG0 {
            core,
            crd: crd.into(),
            x: x.into(),
            y: y.into(),
            syn_vel: vel.into(),
            syn_acc: acc.into(),
            fifo: fifo.into(),
        }),
        &Path::LookAhead { crd, fifo, time, acc, count } => Wire::of(InitLookAhead {
            core,
            crd: crd.into(),
            fifo: fifo.into(),
            time_ms: time.into(),
            acc_max: acc.into(),
            count: count.into(),
        }),
        &Path::Limit { crd, coordinate, vel, acc } => Wire::of(SetCrdLimit {
            core,
            crd: crd.into(),
            coordinate: coordinate.into(),
            vel_max: vel.into(),
            acc_max: acc.into(),
        }),
        &Path::Flush { crd, fifo } => Wire::with_items(CrdData { core, crd: crd.into(), fifo: fifo.into() }, &[]),
        &Path::Analog { crd, dac, value, fifo } => {
            Wire::of(BufDA { core, crd: crd.into(), channel: dac.into(), value: value.into(), fifo: fifo.into() })
        }
        Path::Laser { crd, channel, command, fifo } => super::light::entry(of.core, *crd, *fifo, *channel, command),
        &Path::Move { crd, axis, to, vel, acc, modal, fifo } => Wire::of(BufMove {
            core,
            crd: crd.into(),
            axis: setup.axes[axis].1.into(),
            pos: to.into(),
            vel: vel.into(),
            acc: acc.into(),
            modal: modal.into(),
            fifo: fifo.into(),
        }),
        &Path::Gear { crd, axis, pulses, fifo } => {
            let axis = setup.axes[axis].1.into();
            Wire::of(BufGear { core, crd: crd.into(), axis, pos: pulses.into(), fifo: fifo.into() })
        }
        Path::Line { crd, to, speeds, fifo } => {
            let (crd, fifo) = ((*crd).into(), (*fifo).into());
            let (syn_vel, syn_acc, vel_end) = (speeds.vel.into(), speeds.acc.into(), speeds.end.into());
            let at = |index: usize| to[index].into();
            match to.len() {
                2 => Wire::of(LnXY { core, crd, x: at(0), y: at(1), syn_vel, syn_acc, vel_end, fifo }),
                3 => Wire::of(LnXYZ { core, crd, x: at(0), y: at(1), z: at(2), syn_vel, syn_acc, vel_end, fifo }),
                _ => Wire::of(LnXYZA {
                    core,
                    crd,
                    x: at(0),
                    y: at(1),
                    z: at(2),
                    a: at(3),
                    syn_vel,
                    syn_acc,
                    vel_end,
                    fifo,
                }),
            }
        }
        Path::Arc { crd, plane, to, round, ccw, speeds, fifo } => {
            let (crd, fifo, circle_dir) = ((*crd).into(), (*fifo).into(), i16::from(*ccw).into());
            let (syn_vel, syn_acc, vel_end) = (speeds.vel.into(), speeds.acc.into(), speeds.end.into());
            let (x, y) = (to[0].into(), to[1].into());
            // The three planes have one layout.
            let mut call = match *round {
                Cycle::Radius(radius) => {
                    let radius = radius.into();
                    Wire::of(ArcXYR { core, crd, x, y, radius, circle_dir, syn_vel, syn_acc, vel_end, fifo })
                }
                Cycle::Centre(a, b) => {
                    let (x_center, y_center) = (a.into(), b.into());
                    Wire::of(ArcXYC {
                        core,
                        crd,
                        x,
                        y,
                        x_center,
                        y_center,
                        circle_dir,
                        syn_vel,
                        syn_acc,
                        vel_end,
                        fifo,
                    })
                }
            };
            call.opcode += match plane {
                Plane::XY => 0,
                Plane::YZ => opcode::ArcYZR - opcode::ArcXYR,
                Plane::ZX => opcode::ArcZXR - opcode::ArcXYR,
            };
            call
        }
    }
}

pub fn got(of: &PathCall, answer: &Answer) -> Option<Got> {
    match of.what {
        Path::Space { .. } => answer.reply::<CrdSpace>().map(|(reply, _)| Got::Whole(reply.value.get().into())),
        Path::Remainder { .. } => {
            answer.reply::<GetRemainderSegNum>().map(|(reply, _)| Got::Whole(reply.value.get().into()))
        }
        Path::Status { .. } => {
            let two = |reply: CrdStatusReply| Got::Two(reply.run.get().into(), reply.segment.get().into());
            answer.reply::<CrdStatus>().map(|(reply, _)| two(reply))
        }
        Path::Why { .. } => answer.reply::<CrdInfo>().map(|(reply, _)| Got::Whole(reply.reason.get().into())),
        Path::GetFilter { .. } => {
            answer.reply::<GetLaserFollowFilter>().map(|(reply, _)| Got::Reals([reply.value.get(), 0.0, 0.0, 0.0]))
        }
        Path::Vel { .. } => answer.reply::<GetCrdVel>().map(|(reply, _)| Got::Real(reply.value.get())),
        Path::Pos { .. } => answer.reply::<GetCrdPos>().map(|(_, items)| {
            let mut position = [0.0; 4];
            position.iter_mut().zip(items).for_each(|(position, item)| *position = item.value.get());
            Got::CrdPosition(position)
        }),
        _ => None,
    }
}
