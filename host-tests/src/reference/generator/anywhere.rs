//! What may come at any time: the same again, changes during motion, names, limits, Stops, reads,
//! any call anywhere.
use super::{Does, Making};
use crate::reference::{Call, Kind};

impl Making<'_> {
    /// The same once more.
    pub(super) fn again(&mut self, axis: usize) {
        self.rest(axis);
        if self.one_in(2) {
            self.plain(Kind::ZeroPos, axis);
        }
        self.start(axis);
    }

    pub(super) fn start(&mut self, axis: usize) {
        let mask = 1 << axis;
        let option = if self.one_in(2) { mask } else { 0 };
        match self.does[axis] {
            Does::Trap => self.target(axis),
            Does::Jog => self.velocity(axis),
            Does::Pt | Does::Stream => self.calls.push(Call::PtStart { mask, option }),
            Does::Follow(_) => self.calls.push(Call::FollowStart { mask, option }),
            Does::FollowEx(_) => self.ex(Call::FollowStart { mask, option }),
            Does::Pvt => self.calls.push(Call::PvtStart { mask }),
            Does::Path => self.during_paths(axis),
        }
    }

    /// What may be done while it runs.
    pub(super) fn during(&mut self, axis: usize) {
        match self.does[axis] {
            Does::Trap => self.target(axis),
            Does::Jog => self.velocity(axis),
            Does::Pt => {
                let fifo = self.below(2) as usize;
                self.pt_data(axis, fifo);
            }
            Does::Stream => self.pt_data(axis, 0),
            Does::Pvt => match self.below(3) {
                0 => {
                    let loops = self.pick(&[0, 1, 2, 3, 5]);
                    self.calls.push(Call::SetPvtLoop { axis, loops });
                }
                1 => {
                    let table = self.table(axis);
                    self.calls.push(Call::PvtTableSelect { axis, table });
                }
                _ => self.plain(Kind::GetPvtLoop, axis),
            },
            Does::FollowEx(_) => self.during_ex(axis),
            Does::Path => self.during_paths(axis),
            Does::Follow(_) => {
                let root = self.root(axis);
                match self.below(4) {
                    0 => self.calls.push(Call::FollowSwitch { mask: 1 << axis }),
                    1 => {
                        let fifo = self.below(2) as usize;
                        self.follow_data(axis, fifo, 1.0);
                    }
                    2 => {
                        let abrupt = if self.one_in(3) { 1 << root } else { 0 };
                        self.calls.push(Call::Stop { mask: 1 << root, abrupt });
                    }
                    _ => self.start(root),
                }
            }
        }
    }

    pub(super) fn zero(&mut self, axis: usize) {
        self.rest(axis);
        if self.one_in(2) {
            self.plain(Kind::ZeroPos, axis);
        } else {
            let pos = self.below(2000) as i32 - 1000;
            self.calls.push(Call::SetPrfPos { axis, pos });
        }
        self.start(axis);
    }

    /// Soft limits around where it stands, mostly, and a way out of them.
    pub(super) fn soft(&mut self, axis: usize) {
        if self.one_in(3) {
            self.plain(Kind::ClrSts, axis);
            self.calls.push(Call::SetSoftLimit { axis, positive: i32::MAX, negative: i32::MIN });
            return;
        }
        self.rest(axis);
        if self.one_in(2) {
            self.plain(Kind::ZeroPos, axis);
        }
        let (top, bottom) = (self.below(400) as i32 + 1, -(self.below(400) as i32) - 1);
        let positive = if self.one_in(4) { i32::MAX } else { top };
        let negative = if self.one_in(4) { i32::MIN } else { bottom };
        self.calls.push(Call::SetSoftLimit { axis, positive, negative });
        self.start(axis);
        self.sleep(40);
        self.plain(Kind::GetSts, axis);
        if !self.one_in(4) {
            self.plain(Kind::ClrSts, axis);
        }
        self.start(axis);
    }

    pub(super) fn stop(&mut self) {
        let core = self.pick(&[1, self.setup.axes.last().map_or(1, |axis| axis.0)]);
        let own: u32 =
            (0..self.setup.axes.len()).filter(|axis| self.setup.axes[*axis].0 == core).map(|axis| 1 << axis).sum();
        let mask = self.chance.next() as u32 & own;
        let abrupt = self.chance.next() as u32 & mask;
        if mask != 0 {
            self.calls.push(Call::Stop { mask, abrupt });
        }
    }

    /// Another tick period, mostly while everything is at standstill.
    pub(super) fn tick(&mut self) {
        let mut cores: Vec<i16> = self.setup.axes.iter().map(|axis| axis.0).collect();
        cores.dedup();
        let abrupt = self.one_in(2);
        if !self.one_in(5) {
            for core in cores {
                let own = |axis: &usize| self.setup.axes[*axis].0 == core;
                let mask = (0..self.setup.axes.len()).filter(own).fold(0, |mask, axis| mask | 1 << axis);
                self.calls.push(Call::Stop { mask, abrupt: if abrupt { mask } else { 0 } });
                self.calls.push(Call::WaitStop { mask });
            }
            self.sleep(6);
        }
        let us = if self.one_in(8) { self.pick(&[0, -1, 5, 1001]) } else { self.pick(&[100, 125, 250, 500, 1000]) };
        self.calls.push(Call::SetTick { us });
        self.start(0);
    }

    pub(super) fn read(&mut self, axis: usize) {
        let kinds = [
            Kind::GetSts,
            Kind::GetStopReason,
            Kind::GetCaptureStatus,
            Kind::GetPrfPos,
            Kind::GetPrfVel,
            Kind::GetPrfMode,
            Kind::GetPtLoop,
            Kind::GetFollowLoop,
            Kind::GetFollowStatus,
            Kind::GetFollowLoopEx,
            Kind::GetFollowStatusEx,
            Kind::GetFollowMemory,
            Kind::GetFollowMemoryEx,
            Kind::GetFollowEvent,
            Kind::GetFollowEventEx,
            Kind::GetFollowMaster,
            Kind::GetFollowMasterEx,
            Kind::GetEncPos,
            Kind::GetEncVel,
            Kind::GetPrfAcc,
            Kind::GetTrapPrm,
            Kind::GetJogPrm,
            Kind::GetPos,
            Kind::GetVel,
            Kind::GetSoftLimit,
            Kind::GetStopDec,
            Kind::GetAxisBand,
            Kind::GetPosErr,
            Kind::GetPtMemory,
            Kind::PvtStatus,
        ];
        for _ in 0..1 + self.below(3) {
            // Reads of the mode that it is in, too.
            let kind = match (self.below(2), self.does[axis]) {
                (0, Does::Trap) => self.pick(&[Kind::GetTrapPrm, Kind::GetPos, Kind::GetPrfAcc, Kind::GetStopReason]),
                (0, Does::Jog) => self.pick(&[Kind::GetJogPrm, Kind::GetVel, Kind::GetPrfAcc, Kind::GetStopReason]),
                (0, Does::Pt | Does::Stream) => self.pick(&[Kind::GetPtLoop, Kind::GetPtMemory, Kind::GetPrfAcc]),
                (0, Does::Pvt) => self.pick(&[Kind::GetPvtLoop, Kind::PvtStatus, Kind::GetPrfAcc]),
                (0, Does::Follow(_)) => self.pick(&[
                    Kind::GetFollowLoop,
                    Kind::GetFollowStatus,
                    Kind::GetFollowMemory,
                    Kind::GetFollowEvent,
                    Kind::GetFollowMaster,
                ]),
                (0, Does::FollowEx(_)) => self.pick(&[
                    Kind::GetFollowLoopEx,
                    Kind::GetFollowStatusEx,
                    Kind::GetFollowMemoryEx,
                    Kind::GetFollowEventEx,
                    Kind::GetFollowMasterEx,
                ]),
                _ => self.pick(&kinds),
            };
            self.plain(kind, axis);
        }
    }

    /// Any call in any state.
    pub(super) fn any(&mut self, axis: usize) {
        let fifo = self.pick(&[0, 1, 0, 1, 2, -1]);
        let call = match self.below(19) {
            15 => Call::SetEncPos { axis, pos: self.below(500) as i32 - 250 },
            16 => Call::SynchAxisPos { mask: 1 << axis },
            17 => Call::SetAxisBand { axis, band: self.below(20) as i32 - 1, time: self.below(20) as i32 },
            18 => Call::SetPosErr { axis, error: self.pick(&[0, -1, 1_000_000, i32::MAX]) },
            0 => Call::Axis { kind: Kind::AxisOff, axis },
            1 => Call::Axis { kind: Kind::ClrSts, axis },
            2 => Call::Axis { kind: self.pick(&[Kind::PrfTrap, Kind::PrfJog]), axis },
            3 => Call::PrfPt { axis, mode: self.pick(&[0, 1, 2]) },
            4 => Call::PtClear { axis, fifo },
            5 => Call::PtSpace { axis, fifo },
            6 => Call::SetPtMemory { axis, memory: self.pick(&[0, 1, 2]) },
            7 => Call::FollowClear { axis, fifo },
            8 => Call::FollowSpace { axis, fifo },
            9 => Call::SetFollowLoop { axis, loops: self.pick(&[0, 1, 2, 3]) },
            10 => Call::SetPtLoop { axis, loops: self.pick(&[-1, 0, 1, 2, 3]) },
            11 => Call::SetStopDec { axis, smooth: self.rate() },
            12 => Call::FollowSwitch { mask: 1 << axis },
            13 => Call::PrfFollow { axis, dir: self.pick(&[-1, 0, 1]) },
            _ => Call::Update { mask: 1 << axis },
        };
        let off = call == Call::Axis { kind: Kind::AxisOff, axis };
        self.calls.push(call);
        if off && self.one_in(2) {
            self.start(axis);
        }
        if off {
            self.plain(Kind::AxisOn, axis);
        }
    }
}
