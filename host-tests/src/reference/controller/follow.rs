//! Follow: masters, data, FIFOs, starts, switches.
use super::super::axis::{Master, Mode, Motion};
use super::super::call::{Call, members};
use super::super::follow::{Item, is_down, mean, segments, slots};
use super::super::number::{Fix, exact};
use super::super::rational::Rational;
use super::super::slave::Begin;
use super::answer::{Answer, DONE, check, either, range};
use super::{Controller, Reply, Value};

impl Controller {
    pub(super) fn follow_start(&mut self, mask: u32, option: u32, mode: Mode) -> Answer {
        let fifo = |axis_index: usize| (option >> axis_index & 1) as usize;
        for axis_index in members(mask) {
            let axis = &self.axes[axis_index];
            check(axis.mode == mode && !axis.runs() && !axis.blocked() && axis.follow.master.is_some())?;
            check(!axis.follow.fifos[fifo(axis_index)].is_empty())?;
        }
        for axis_index in members(mask) {
            self.axes[axis_index].start_follow(fifo(axis_index));
            // Its master may be known better later than where it begins.
            let of_master = self.rounding_of_master(&self.axes[axis_index]);
            if let Some(Motion::Slave(slave)) = &self.axes[axis_index].motion {
                let rounding = slave.table.curve.steepest * of_master;
                self.axes[axis_index].slack += rounding;
            }
        }
        DONE
    }

    pub(super) fn follow_switch(&mut self, mask: u32, mode: Mode) -> Answer {
        for axis_index in members(mask) {
            let axis = &self.axes[axis_index];
            check(axis.mode == mode)?;
            let Some(Motion::Slave(slave)) = &axis.motion else { return Err(1) };
            if slave.now.is_some() {
                self.open = Some("two switches at one instant");
            }
            check(!axis.follow.fifos[slave.fifo ^ 1].is_empty() && self.then[axis_index].is_none())?;
        }
        for axis_index in members(mask) {
            if let Some(Motion::Slave(slave)) = &mut self.axes[axis_index].motion {
                slave.switching = true;
            }
        }
        DONE
    }

    pub(super) fn follow(&mut self, index: usize, call: &Call, mode: Mode) -> Answer {
        match *call {
            Call::PrfFollow { axis, dir } => {
                let axis = &mut self.axes[axis];
                check(!axis.runs())?;
                check(axis.mode != mode || axis.follow.dir == dir.signum())?;
                axis.set_mode(mode);
                axis.follow.dir = dir.signum();
            }
            Call::SetFollowMaster { axis: axis_index, master, kind, item } => {
                let axis = &self.axes[axis_index];
                either(axis.mode == mode && !axis.runs(), axis_index != master)?;
                let mut above = Some(master);
                while let Some(index) = above {
                    check(index != axis_index)?;
                    let next = self.axes[index].follow.master.filter(|_| self.axes[index].is_follow());
                    above = next.map(|master| master.axis);
                }
                self.axes[axis_index].follow.master = Some(Master { axis: master, kind, item });
            }
            Call::SetFollowLoop { axis, loops } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == mode, loops >= 0)?;
                axis.follow.loops = loops.into();
            }
            Call::SetFollowEvent { axis, event, dir, pos } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == mode, (1..3).contains(&event))?;
                let begin = Begin::Pass { up: dir > 0, name: pos.into() };
                axis.follow.begin = if event == 1 { Begin::Start } else { begin };
            }
            Call::FollowData { axis, datum, fifo } => {
                return self.follow_item(axis, Item::Segment(datum), fifo, mode);
            }
            Call::FollowClear { axis, fifo } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == mode, (0..2).contains(&fifo))?;
                if matches!(&axis.motion, Some(Motion::Slave(slave)) if slave.now == Some(true)) {
                    self.open = Some("two switches at one instant");
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
                either(axis.mode == mode, (0..2).contains(&fifo))?;
                if matches!(&axis.motion, Some(Motion::Slave(slave)) if slave.now == Some(true)) {
                    self.open = Some("two switches at one instant");
                }
                let free = axis.follow_capacity() - slots(&axis.follow.fifos[fifo as usize]);
                return Ok(self.read(index, call, free));
            }
            Call::SetFollowMemory { axis, memory } => {
                let axis = &mut self.axes[axis];
                either(axis.mode == mode && !axis.runs(), (0..2).contains(&memory))?;
                axis.follow.memory = memory;
                axis.follow.fifos = Default::default();
            }
            _ => return Ok(Reply::Open),
        }
        DONE
    }

    pub(super) fn follow_item(&mut self, axis_index: usize, item: Item, fifo: i16, mode: Mode) -> Answer {
        let axis = &mut self.axes[axis_index];
        let good_kind = item.segment().is_none_or(|datum| (0..4).contains(&datum.kind));
        let good_percent = item.segment().is_none_or(|datum| (0..=100).contains(&datum.percent));
        either(axis.mode == mode, (0..2).contains(&fifo) && good_kind && good_percent)?;
        let fifo = fifo as usize;
        let data = &axis.follow.fifos[fifo];
        if matches!(&axis.motion, Some(Motion::Slave(slave)) if slave.now.is_some()) {
            self.open = Some("FollowData at the instant of SwitchNow");
        }
        let room = slots(data) < axis.follow_capacity();
        let mut reply = Value::None;
        match item {
            Item::Asymmetric(of) => {
                let last = segments(data).next_back();
                let (from, begin) = last.map_or((0.0, 0.0), |last| (last.master, last.slave));
                let any = last.is_some();
                let down = if any { is_down(data) } else { of.master < 0.0 };
                let good = if down { of.master < from } else { of.master > from };
                let good = good && (0..=100).contains(&of.percent) && !(of.master < 0.0 && axis.follow.dir > 0);
                let first = if good { of.first(from, begin) } else { None };
                let mut with = data.clone();
                with.push(item);
                let room = first.is_none() || slots(&with) <= axis.follow_capacity();
                either(room, good && first.is_some())?;
                let percent = first.map_or(0.0, |first| Fix::of(&first).to_f64() * 100.0);
                reply = Value::Percent(percent);
            }
            Item::Segment(datum) => {
                let any = segments(data).next().is_some();
                let down = if any { is_down(data) } else { datum.master < 0.0 };
                let last = segments(data).next_back().map_or(0.0, |last| last.master);
                let good = if down { datum.master < last } else { datum.master > last };
                either(room, good && !(datum.master < 0.0 && axis.follow.dir > 0))?;
            }
            Item::Output { index, .. } | Item::Wait { index, .. } => {
                either(room, (1..=32).contains(&index))?;
                check(entries(data) < ENTRIES)?;
            }
            Item::Delay { .. } | Item::Switch { .. } => check(room && entries(data) < ENTRIES)?,
        }
        axis.follow.fifos[fifo].push(item);
        if let Some(Motion::Slave(slave)) = &mut axis.motion
            && slave.fifo == fifo
        {
            slave.grow(&axis.follow.fifos[fifo]);
        }
        Ok(Reply::Done(reply))
    }

    /// GetFollowDataPercent2Ex: what a slave goes along with its master.
    pub(super) fn asymmetric_way(master: f64, ratios: [f64; 2], shares: [f64; 2]) -> Answer {
        let [all, first] = shares;
        range((0.0..=100.0).contains(&all) && (0.0..=all).contains(&first))?;
        let hundred = Rational::from_integer(100.into());
        let [q, x] = shares.map(|share| exact(share) / &hundred);
        let displacement = exact(master) * mean(&exact(ratios[0]), &exact(ratios[1]), &q, &x);
        Ok(Reply::Done(Value::Computed([Fix::of(&displacement).to_f64(), 0.0, 0.0, 0.0])))
    }

    pub(super) fn follow_switch_now(&mut self, axis_index: usize, table: bool) -> Answer {
        let axis = &self.axes[axis_index];
        check(axis.mode == Mode::FollowEx && axis.runs())?;
        let Some(Motion::Slave(slave)) = &axis.motion else { return Err(1) };
        if axis.began || slave.now.is_some() {
            self.open = Some("two switches at one instant");
        }
        check(self.then[axis_index].is_none())?;
        check(!table || !axis.follow.fifos[slave.fifo ^ 1].is_empty())?;
        if let Some(Motion::Slave(slave)) = &mut self.axes[axis_index].motion {
            slave.now = Some(table);
        }
        DONE
    }
}

/// FollowEx: slots for entries other than segments.
const ENTRIES: usize = 16;

fn entries(items: &[Item]) -> usize {
    items.iter().filter(|item| item.segment().is_none()).count()
}
