//! Follow: masters, data, FIFOs, starts, switches.
use super::super::axis::{Mode, Motion};
use super::super::call::{Call, members};
use super::super::follow::{Begin, Datum};
use super::answer::{Answer, DONE, check, either};
use super::{Controller, Reply};

impl Controller {
    pub(super) fn follow_start(&mut self, mask: u32, option: u32) -> Answer {
        let fifo = |place: usize| (option >> place & 1) as usize;
        for place in members(mask) {
            let axis = &self.axes[place];
            check(axis.mode == Mode::Follow && !axis.runs() && !axis.blocked() && axis.follow.master.is_some())?;
            check(!axis.follow.fifos[fifo(place)].is_empty())?;
        }
        for place in members(mask) {
            self.axes[place].start_follow(fifo(place));
        }
        DONE
    }

    pub(super) fn follow_switch(&mut self, mask: u32) -> Answer {
        for place in members(mask) {
            let axis = &self.axes[place];
            check(axis.mode == Mode::Follow)?;
            let Some(Motion::Slave(slave)) = &axis.motion else { return Err(1) };
            if axis.began {
                self.open = Some("FollowSwitch at the instant of FollowStart");
            }
            check(!axis.follow.fifos[slave.fifo ^ 1].is_empty() && self.then[place].is_none())?;
        }
        for place in members(mask) {
            if let Some(Motion::Slave(slave)) = &mut self.axes[place].motion {
                slave.switching = true;
            }
        }
        DONE
    }

    pub(super) fn follow(&mut self, index: usize, call: &Call) -> Answer {
        match *call {
            Call::PrfFollow { axis, dir } => {
                let axis = &mut self.axes[axis];
                check(!axis.runs())?;
                check(axis.mode != Mode::Follow || axis.follow.dir == dir.signum())?;
                axis.set_mode(Mode::Follow);
                axis.follow.dir = dir.signum();
            }
            Call::SetFollowMaster { axis: place, master, .. } => {
                let axis = &self.axes[place];
                either(axis.mode == Mode::Follow && !axis.runs(), place != master)?;
                let mut above = Some(master);
                while let Some(index) = above {
                    check(index != place)?;
                    above = self.axes[index].follow.master.filter(|_| self.axes[index].mode == Mode::Follow);
                }
                self.axes[place].follow.master = Some(master);
            }
            Call::SetFollowLoop { axis, loops } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Follow, loops >= 0)?;
                axis.follow.loops = loops.into();
            }
            Call::SetFollowEvent { axis, event, dir, pos } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Follow, (1..3).contains(&event))?;
                let begin = Begin::Pass { up: dir > 0, name: pos.into() };
                axis.follow.begin = if event == 1 { Begin::Start } else { begin };
            }
            Call::FollowData { axis, datum, fifo } => return self.follow_data(axis, datum, fifo),
            Call::FollowClear { axis, fifo } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Follow, (0..2).contains(&fifo))?;
                if axis.began {
                    self.open = Some("FollowClear at the instant of FollowStart");
                }
                if let Some(Motion::Slave(slave)) = &axis.motion {
                    check(!slave.switching && slave.fifo != fifo as usize)?;
                } else if axis.runs() {
                    check(axis.follow.fifo != fifo as usize)?;
                }
                axis.follow.fifos[fifo as usize].clear();
            }
            Call::FollowSpace { axis, fifo } => {
                let axis = &self.axes[axis];
                either(axis.mode == Mode::Follow, (0..2).contains(&fifo))?;
                if axis.began {
                    self.open = Some("FollowSpace at the instant of FollowStart");
                }
                let free = axis.follow_capacity() - axis.follow.fifos[fifo as usize].len();
                return Ok(self.read(index, call, free));
            }
            Call::SetFollowMemory { axis, memory } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == Mode::Follow && !axis.runs(), (0..2).contains(&memory))?;
                axis.follow.memory = memory;
                axis.follow.fifos = Default::default();
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }

    pub(super) fn follow_data(&mut self, place: usize, datum: Datum, fifo: i16) -> Answer {
        let axis = &mut self.axes[place];
        either(axis.mode == Mode::Follow, (0..2).contains(&fifo) && (0..4).contains(&datum.kind))?;
        let fifo = fifo as usize;
        let data = &axis.follow.fifos[fifo];
        let down = data.first().map_or(datum.master < 0.0, |first| first.master < 0.0);
        let last = data.last().map_or(0.0, |last| last.master);
        let good = if down { datum.master < last } else { datum.master > last };
        // What follows it at the same instant is a tick late at times, against docs/follow.md.
        if matches!(&axis.motion, Some(Motion::Slave(slave)) if slave.switching) {
            self.open = Some("FollowData under a pending switch");
        }
        either(data.len() < axis.follow_capacity(), good && !(datum.master < 0.0 && axis.follow.dir > 0))?;
        axis.follow.fifos[fifo].push(datum);
        if let Some(Motion::Slave(slave)) = &mut axis.motion
            && slave.fifo == fifo
        {
            slave.grow(&axis.follow.fifos[fifo]);
        }
        DONE
    }
}
