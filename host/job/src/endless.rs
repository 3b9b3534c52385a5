//! Motions that a script has started, as far as its calls say. It is needed only to refuse a wait
//! that would never end (SPEC 7: `while(!kbhit())` under an endless motion).
//!
//! In: the calls, in order. Out: whether a motion is endless. It knows Jog, Gear and the loops of
//! PT, PVT and Follow; a motion that ends by itself is not kept.

use crate::Axis;
use std::collections::BTreeMap;

/// One axis, as the script has left it.
#[derive(Debug, Clone, Copy, Default)]
struct Motion {
    mode: Mode,
    /// Velocity of the last SetVel.
    velocity: f64,
    /// Count of the last SetPtLoop; None is the power-on value, 1.
    loops: Option<i64>,
    /// That of the last SetPvtLoop.
    table_loops: Option<i64>,
    /// That of the last SetFollowLoop.
    follow_loops: Option<i64>,
    /// Line of the call that set it moving.
    running: Option<u32>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
enum Mode {
    #[default]
    Other,
    Jog,
    StaticPt,
    Pvt,
    Follow,
    /// Its motion has no end.
    Gear,
}

/// The numbers of a call's parameters without `core`.
pub struct Numbers<'a>(pub &'a [f64]);

impl Numbers<'_> {
    fn int(&self, index: usize) -> i64 {
        self.0.get(index).map_or(0, |number| *number as i64)
    }
}

/// All axes.
#[derive(Debug, Default)]
pub struct Motions {
    axes: BTreeMap<Axis, Motion>,
}

impl Motions {
    /// Takes note of a call. `several_cores` is true for the GTN form.
    pub fn note(&mut self, name: &str, several_cores: bool, core: i16, given: &Numbers, line: u32) {
        let axis = Axis { core, axis: given.int(0) as i16 };
        let mask = given.int(0) as u32;
        match name {
            "PrfPt" => {
                let mode = if given.int(1) == 0 { Mode::StaticPt } else { Mode::Other };
                self.axes.entry(axis).or_default().mode = mode;
            }
            "PrfPvt" => self.axes.entry(axis).or_default().mode = Mode::Pvt,
            "SetPvtLoop" => self.axes.entry(axis).or_default().table_loops = Some(given.int(1)),
            "PvtStart" => self.start(core, mask, Mode::Pvt, line),
            "PrfFollow" | "PrfFollowEx" => self.axes.entry(axis).or_default().mode = Mode::Follow,
            "SetFollowLoop" | "SetFollowLoopEx" => self.axes.entry(axis).or_default().follow_loops = Some(given.int(1)),
            "FollowStart" | "FollowStartEx" => self.start(core, mask, Mode::Follow, line),
            "PrfGear" => self.axes.entry(axis).or_default().mode = Mode::Gear,
            "GearStart" => self.start(core, mask, Mode::Gear, line),
            "PrfJog" => self.axes.entry(axis).or_default().mode = Mode::Jog,
            "PrfTrap" => self.axes.entry(axis).or_default().mode = Mode::Other,
            "SetPtLoop" => self.axes.entry(axis).or_default().loops = Some(given.int(1)),
            "SetVel" => self.axes.entry(axis).or_default().velocity = given.0.get(1).copied().unwrap_or(0.0),
            "PtStart" => self.start(core, mask, Mode::StaticPt, line),
            "Update" => self.start(core, mask, Mode::Jog, line),
            // In the GT form bits 8 to 11 name coordinate systems.
            "Stop" => self.at_standstill(core, if several_cores { mask } else { mask & 0xff }),
            "AxisOff" => self.at_standstill(
                core,
                u32::try_from(given.int(0) - 1).map_or(0, |bit| 1u32.checked_shl(bit).unwrap_or(0)),
            ),
            "Reset" => self.axes.retain(|axis, _| axis.core != core),
            _ => {}
        }
    }

    fn start(&mut self, core: i16, mask: u32, mode: Mode, line: u32) {
        for (axis, motion) in &mut self.axes {
            if axis.core == core && names(mask, axis.axis) && motion.mode == mode {
                motion.running = Some(line);
            }
        }
    }

    /// Axes of `mask` have been waited for, or stopped.
    pub fn at_standstill(&mut self, core: i16, mask: u32) {
        for (axis, motion) in &mut self.axes {
            if axis.core == core && names(mask, axis.axis) {
                motion.running = None;
            }
        }
    }

    /// Everything has been waited for.
    pub fn all_at_standstill(&mut self) {
        for motion in self.axes.values_mut() {
            motion.running = None;
        }
    }

    /// An axis that never stops by itself, and the line that set it moving; of the axes of `among`
    /// (core and mask), or of all.
    pub fn endless(&self, among: Option<(i16, u32)>) -> Option<(Axis, u32)> {
        self.axes.iter().find_map(|(axis, motion)| {
            let named = among.is_none_or(|(core, mask)| axis.core == core && names(mask, axis.axis));
            let endless = match motion.mode {
                Mode::Jog => motion.velocity != 0.0,
                Mode::Pvt => motion.table_loops.is_some_and(|loops| loops <= 0),
                Mode::StaticPt => motion.loops.is_some_and(|loops| loops <= 0),
                Mode::Follow => motion.follow_loops.is_some_and(|loops| loops <= 0),
                Mode::Gear => true,
                Mode::Other => false,
            };
            motion.running.filter(|_| named && endless).map(|line| (*axis, line))
        })
    }
}

fn names(mask: u32, axis: i16) -> bool {
    u32::try_from(i32::from(axis) - 1).is_ok_and(|bit| mask.checked_shr(bit).unwrap_or(0) & 1 == 1)
}
