//! FollowEx, outputs and inputs, as calls travel.
use super::wire;
use client::Call as Wire;
use host_tests::reference::{Call, Effect, Item, Setup};
use protocol::command::*;

/// The request of FollowEx with the layout of one of Follow.
pub fn ex(setup: &Setup, of: &Call) -> Wire {
    let mut call = wire(setup, of);
    call.opcode = match call.opcode {
        opcode::PrfFollow => opcode::PrfFollowEx,
        opcode::SetFollowMaster => opcode::SetFollowMasterEx,
        opcode::SetFollowLoop => opcode::SetFollowLoopEx,
        opcode::SetFollowEvent => opcode::SetFollowEventEx,
        opcode::FollowClear => opcode::FollowClearEx,
        opcode::FollowSpace => opcode::FollowSpaceEx,
        opcode::FollowStart => opcode::FollowStartEx,
        opcode::FollowSwitch => opcode::FollowSwitchEx,
        opcode::SetFollowMemory => opcode::SetFollowMemoryEx,
        other => panic!("{other:#x} is no call of Follow with one of FollowEx"),
    };
    call
}

pub fn entry(setup: &Setup, axis: usize, item: &Item, fifo: i16) -> Wire {
    let (core, profile) = (setup.axes[axis].0.into(), setup.axes[axis].1.into());
    let fifo = fifo.into();
    match *item {
        Item::Segment(datum) => Wire::of(FollowDataPercentEx {
            core,
            profile,
            master_segment: datum.master.into(),
            slave_segment: datum.slave.into(),
            kind: datum.kind.into(),
            percent: datum.percent.into(),
            fifo,
        }),
        Item::Asymmetric(of) => Wire::of(FollowDataPercent2Ex {
            core,
            profile,
            master_segment: of.master.into(),
            slave_segment: of.slave.into(),
            vel_begin_ratio: of.ratios[0].into(),
            vel_end_ratio: of.ratios[1].into(),
            percent: of.percent.into(),
            fifo,
        }),
        Item::Output { index, level } => {
            let (index, value) = (index.into(), i16::from(level).into());
            Wire::of(FollowDoBitEx { core, profile, do_type: 12.into(), index, value, fifo })
        }
        Item::Delay { cycles } => Wire::of(FollowDelayEx { core, profile, delay_cycles: cycles.into(), fifo }),
        Item::Wait { index, level, ms } => {
            let (index, value, time_ms) = (index.into(), i16::from(level).into(), ms.into());
            Wire::of(FollowDiBitEx { core, profile, di_type: 4.into(), index, value, time_ms, fifo })
        }
        Item::Switch { table } => switch_now(setup, axis, table, 1, fifo),
    }
}

pub fn switch_now(setup: &Setup, axis: usize, table: bool, buffer: i16, fifo: zerocopy::little_endian::I16) -> Wire {
    let (core, profile) = (setup.axes[axis].0.into(), setup.axes[axis].1.into());
    let method = if table { 2 } else { 1 }.into();
    Wire::of(FollowSwitchNowEx { core, profile, method, buffer: buffer.into(), fifo })
}

/// Inputs of an axis.
pub fn terminal(setup: &Setup, call: &Call) -> Wire {
    let at = |axis: usize| (setup.axes[axis].0.into(), setup.axes[axis].1.into());
    match *call {
        Call::Terminal { axis, kind, level } => {
            let (core, index) = at(axis);
            Wire::of(SimInput { core, di_type: kind.into(), index, level: i16::from(level).into() })
        }
        Call::Guard { axis, kind, on } => {
            let ((core, axis), limit_type) = (at(axis), kind.into());
            match (kind, on) {
                (2, true) => Wire::of(AlarmOn { core, axis }),
                (2, false) => Wire::of(AlarmOff { core, axis }),
                (_, true) => Wire::of(LmtsOn { core, axis, limit_type }),
                (_, false) => Wire::of(LmtsOff { core, axis, limit_type }),
            }
        }
        Call::Sense { core, sense } => Wire::of(LmtSns { core: core.into(), sense: sense.into() }),
        Call::SetCapture { axis, mode } => {
            let (core, encoder) = at(axis);
            Wire::of(SetCaptureMode { core, encoder, mode: mode.into() })
        }
        _ => panic!("{call:?} is no call of an axis's inputs"),
    }
}

pub fn effect(effect: &Effect) -> Wire {
    match *effect {
        Effect::SetDo { core, value } => Wire::of(SetDo { core: core.into(), do_type: 12.into(), value: value.into() }),
        Effect::SetDoBit { core, index, level } => {
            let value = i16::from(level).into();
            Wire::of(SetDoBit { core: core.into(), do_type: 12.into(), index: index.into(), value })
        }
        Effect::GetDi { core, kind } => Wire::of(GetDi { core: core.into(), di_type: kind.into() }),
        Effect::GetDo { core } => Wire::of(GetDo { core: core.into(), do_type: 12.into() }),
        Effect::SetDoEx { core, value } => {
            let request = SetDoEx { core: core.into(), do_type: 12.into(), count: 1.into() };
            Wire::with_items(request, &[Long { value: value.into() }])
        }
        Effect::GetDoEx { core, count } => {
            Wire::of(GetDoEx { core: core.into(), do_type: 12.into(), count: count.into() })
        }
        Effect::GetDiEx { core, kind, count } => {
            Wire::of(GetDiEx { core: core.into(), di_type: kind.into(), count: count.into() })
        }
        Effect::SetDac { core, dac, value } => {
            let request = SetDac { core: core.into(), dac: dac.into(), count: 1.into() };
            Wire::with_items(request, &[Short { value: value.into() }])
        }
        Effect::GetDac { core, dac } => Wire::of(GetDac { core: core.into(), dac: dac.into(), count: 1.into() }),
        Effect::Interlock { core, open } => {
            let (di_type, level) = (90.into(), i16::from(open).into());
            Wire::of(SimInput { core: core.into(), di_type, index: 1.into(), level })
        }
        Effect::SetInterlock { motion } => Wire::of(SetInterlock { motion: motion.into() }),
        Effect::SimAdc { core, adc, volts } => {
            Wire::of(SimAdc { core: core.into(), adc: adc.into(), volts: volts.into() })
        }
        Effect::GetAdc { core, adc } => Wire::of(GetAdc { core: core.into(), adc: adc.into(), count: 1.into() }),
        Effect::SimInput { core, index, level } => {
            let level = i16::from(level).into();
            Wire::of(SimInput { core: core.into(), di_type: 4.into(), index: index.into(), level })
        }
    }
}
