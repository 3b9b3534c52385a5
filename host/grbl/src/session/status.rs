//! The answer to `?`: state, position, speed and what is on.
//!
//! In: a view of the machine, the state of the session. Out: a report line. Cannot fail.
use super::{PLANNER_BLOCKS, RECEIVE_BYTES, Session, Wait};
use crate::feeder::View;
use crate::report::Report;

impl Session<'_> {
    fn state(&self, view: &View) -> &'static str {
        let moves = !self.feed.is_idle(view);
        if self.sleeps {
            return "Sleep";
        }
        if self.alarm.is_some() {
            return "Alarm";
        }
        if self.checks {
            return "Check";
        }
        match (self.held || self.settles.is_some(), self.door, view.runs) {
            (true, true, true) => return "Door:2",
            (true, true, false) => return "Door:0",
            (true, false, true) => return "Hold:1",
            (true, false, false) => return "Hold:0",
            _ => {}
        }
        match (self.waits, moves) {
            (Some(Wait::Home), _) => "Home",
            (_, true) if self.jogs => "Jog",
            (_, true) => "Run",
            _ => "Idle",
        }
    }

    pub(super) fn report(&mut self) {
        let view = self.feed.view();
        let (mut at, mut feed) = ([0.0; 3], 0.0f64);
        for (place, axis) in self.machine.axes.iter().enumerate() {
            let per_mm = if axis.reversed { -axis.steps_per_mm } else { axis.steps_per_mm };
            at[place] = view.at[place] / per_mm;
            let speed = view.speeds[place] / per_mm;
            feed += speed * speed;
        }
        let power = self.machine.laser().map_or(0.0, |laser| {
            let (least, most) = laser.power;
            let part = if most == least { 1.0 } else { (view.power - least) / (most - least) };
            if view.power == 0.0 { 0.0 } else { part.clamp(0.0, 1.0) * laser.s_max }
        });
        let words = self.stream.modes().words;
        let mut accessories = String::new();
        for (on, letter) in
            [(words[6] == "M3", 'S'), (words[6] == "M4", 'C'), (self.coolant[1], 'F'), (self.coolant[0], 'M')]
        {
            if on {
                accessories.push(letter);
            }
        }
        let motions = self.feed.waiting(&view).1;
        let report = Report {
            state: self.state(&view),
            at,
            zero: self.stream.offsets().zero,
            free: (
                PLANNER_BLOCKS - motions.min(PLANNER_BLOCKS),
                RECEIVE_BYTES.saturating_sub(self.received.len() + self.line.len()),
            ),
            feed: feed.sqrt() * 60_000.0,
            power,
            overrides: self.overrides,
            accessories: &accessories,
            busy: view.runs,
            mask: self.settings.report,
            inches: self.settings.inches,
        };
        let line = self.turns.line(&report);
        self.say(&line);
    }
}
