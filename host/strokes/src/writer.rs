//! Strokes to calls of a job: in pulses, with speeds along the path in pulse/ms.
//!
//! In: strokes in mm, dwells, outputs. Out: the text of a job. Owns where the path is, in pulses,
//! and what its light is. A stroke without a pulse is none. A power is set anew with each mark.
mod motions;

use crate::arc::Arc;
use crate::estimate::Estimate;
use crate::exact::{Scale, of_f64, to_f64};
use crate::number::Number;
use crate::{Extent, MARK, Watch};
use machine::{Family, Laser, Limits, Machine, Mode};
use std::fmt::Write;

/// Entries of a path before it is started.
const START_ENTRIES: usize = 400;
/// Motions that the look-ahead may hold: as many as the FIFO.
const LOOK_AHEAD_MOTIONS: u32 = 1024;
/// The slowest motion of the controller, pulse/ms.
const SPEED_MIN_PULSES_PER_MS: f64 = 1.0 / (1 << 20) as f64;
/// The longest BufDelay, ms.
const DELAY_MAX_MS: u64 = 65_535;

/// A picture of an arc is so near, mm.
const PICTURE_TOLERANCE_MM: f64 = 0.01;

/// The form of a stroke.
#[derive(Debug, Clone, Copy)]
pub enum Shape {
    Line,
    Arc {
        /// Axes of the plane, and the one across.
        axes: [usize; 3],
        arc: Arc,
    },
}

impl Shape {
    /// mm along the path.
    pub fn length(&self, from: [i128; 3], to: [i128; 3]) -> f64 {
        let way = [0, 1, 2].map(|axis| to_f64(to[axis] - from[axis]));
        match self {
            Shape::Line => norm(way),
            Shape::Arc { axes, arc } => arc.length().hypot(way[axes[2]]),
        }
    }
}

/// The light of a stroke, in the laser's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    Dark,
    Constant(f64),
    /// Power at the speed of the program.
    Follow(f64),
}

/// One motion.
#[derive(Debug, Clone, Copy)]
pub struct Stroke {
    pub line: usize,
    /// Exact machine positions.
    pub from: [i128; 3],
    pub to: [i128; 3],
    pub shape: Shape,
    /// mm/min; none is as fast as the machine.
    pub speed: Option<f64>,
    pub light: Light,
}

/// What a laser entry has set.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Power {
    Constant(f64),
    Follow { ratio: f64, most: f64 },
}

/// See the module text.
pub struct Writer<'a> {
    machine: &'a Machine,
    scales: Vec<Scale>,
    text: String,
    at: [i64; 3],
    /// The laser that marks, of those of the machine; `power` is its.
    laser: usize,
    power: Option<Power>,
    entries: usize,
    started: bool,
    /// Factors of F and of the machine's speed; see [`Writer::factors`].
    feed: f64,
    rapid: f64,
    /// Of everything, and of marks: least and greatest of each axis, mm, and length.
    covered: [Option<[(f64, f64); 3]>; 2],
    length: [f64; 2],
    /// Lengths of marks, of each laser.
    marked: Vec<f64>,
    /// None if nobody asks for it: it takes as long as all else.
    time: Option<Estimate>,
    /// The first mark with power in proportion to a speed that the machine does not reach there.
    unreached_speed: Option<UnreachedSpeed>,
    watch: Option<Watch<'a>>,
}

/// A mark that asks for more speed than the machine reaches there, mm/min.
#[derive(Debug, Clone, Copy)]
struct UnreachedSpeed {
    line: usize,
    asked: f64,
    reached: f64,
}

/// The corner time. An axis that passes a jump of velocity a·T in the time T with the acceleration
/// a is a·T²/8 beside the corner.
fn corner_ms(machine: &Machine) -> f64 {
    let tolerance = machine.path.junction_deviation;
    let time = |axis: &machine::Axis| (8.0 * tolerance / axis.acceleration).sqrt() * 1000.0;
    machine.axes.iter().map(time).fold(f64::INFINITY, f64::min)
}

/// See [`Writer::checkpoint`].
pub struct Checkpoint {
    size: usize,
    at: [i64; 3],
    power: Option<Power>,
    entries: usize,
}

fn norm(way: [f64; 3]) -> f64 {
    way.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl<'a> Writer<'a> {
    /// A job named `name`; `each` is what a number at a call is: `line N of the program`.
    pub fn new(name: &str, each: &str, machine: &'a Machine) -> Writer<'a> {
        let scales: Vec<Scale> = machine.axes.iter().map(Scale::of).collect();
        let mut at = [0; 3];
        for (place, (axis, scale)) in machine.axes.iter().zip(&scales).enumerate() {
            at[place] = scale.pulses(of_f64(axis.home));
        }
        let text = String::new();
        let mut writer = Writer {
            machine,
            scales,
            text,
            at,
            laser: machine.chosen,
            power: None,
            entries: 0,
            started: false,
            feed: 1.0,
            rapid: 1.0,
            covered: [None; 2],
            length: [0.0; 2],
            marked: vec![0.0; machine.lasers.len()],
            time: Some(Estimate::new(machine, at, corner_ms(machine))),
            unreached_speed: None,
            watch: None,
        };
        writer.begin(name, each);
        writer
    }

    fn put(&mut self, call: std::fmt::Arguments<'_>) {
        // Writing to a String does not fail.
        let _ = self.text.write_fmt(call);
    }

    fn begin(&mut self, name: &str, each: &str) {
        let machine = self.machine;
        let name: String = name.chars().filter(|letter| !letter.is_control() && *letter != '\\').collect();
        self.put(format_args!(
            "{MARK}: {name}. Positions are pulses, speeds pulse/ms; // N is {each}.\n\
             // The axes stand at home when this job begins.\n"
        ));
        self.put(format_args!("#pragma family {}\n", if machine.family == Family::Gus { "gus" } else { "lsr" }));
        self.put(format_args!("TCrdPrm crd = {{0}};\nGT_Reset();\n"));
        for axis in &machine.axes {
            let number = axis.number;
            match axis.limits {
                Limits::None => self.put(format_args!("GT_LmtsOff({number});\n")),
                Limits::Positive => self.put(format_args!("GT_LmtsOff({number}, 1);\n")),
                Limits::Negative => self.put(format_args!("GT_LmtsOff({number}, 0);\n")),
                Limits::Both => {}
            }
            if !axis.alarm {
                self.put(format_args!("GT_AlarmOff({number});\n"));
            }
        }
        self.put(format_args!("GT_ClrSts(1, 8);\n"));
        let (at, scales) = (self.at, self.scales.clone());
        for (place, (axis, scale)) in machine.axes.iter().zip(&scales).enumerate() {
            let ends = [axis.travel.0, axis.travel.1].map(|end| scale.pulses(of_f64(end)) - at[place]);
            let (number, least, most) = (axis.number, ends[0].min(ends[1]) - 1, ends[0].max(ends[1]) + 1);
            self.put(format_args!(
                "GT_AxisOn({number});\nGT_ZeroPos({number});\nGT_SetSoftLimit({number}, {most}, {least});\n"
            ));
        }
        let bound = |of: fn(&machine::Axis) -> f64| {
            let sum = machine.axes.iter().map(|axis| of(axis) * of(axis)).sum::<f64>().sqrt();
            (sum * 1.001).min(32_766.0)
        };
        let (rate, acceleration) = (bound(machine::Axis::rate), bound(machine::Axis::pulse_acceleration));
        self.put(format_args!(
            "crd.dimension = {};\ncrd.synVelMax = {rate};\ncrd.synAccMax = {acceleration};\ncrd.setOriginFlag = 1;\n",
            machine.axes.len()
        ));
        for (place, axis) in machine.axes.iter().enumerate() {
            let (index, coordinate, letter) = (axis.number - 1, place + 1, axis.letter);
            self.put(format_args!("crd.profile[{index}] = {coordinate}; crd.originPos[{index}] = {};", -at[place]));
            self.put(format_args!(" // {letter}\n"));
        }
        self.put(format_args!("GT_SetCrdPrm(1, &crd);\nGT_CrdClear(1, 0);\n"));
        for (place, axis) in machine.axes.iter().enumerate() {
            let (rate, acceleration) = (axis.rate(), axis.pulse_acceleration());
            self.put(format_args!("GT_SetCrdLimit(1, {}, {rate}, {acceleration});\n", place + 1));
        }
        let time = corner_ms(machine);
        let most = machine.axes.iter().map(machine::Axis::pulse_acceleration).fold(0.0, f64::max);
        self.put(format_args!("GT_InitLookAhead(1, 0, {time}, {most}, {LOOK_AHEAD_MOTIONS});\n"));
        for laser in &machine.lasers {
            self.begin_laser(laser);
        }
    }

    fn begin_laser(&mut self, laser: &Laser) {
        let channel = laser.channel;
        if let Some(name) = &laser.name {
            self.put(format_args!("// Laser {name}:\n"));
        }
        let mode = match laser.mode {
            Mode::Duty => 0,
            Mode::Frequency => 1,
            Mode::Analog => 2,
        };
        if self.machine.family == Family::Gus && laser.mode != Mode::Analog {
            self.put(format_args!("GT_SetAxisMode({}, 1);\n", 7 + channel));
        }
        let most = laser.power.1;
        self.put(format_args!("GT_LaserPowerMode({mode}, {most}, 0, {channel}, 1);\n"));
        match laser.mode {
            Mode::Duty => self.put(format_args!("GT_LaserOutFrq({}, {channel});\n", laser.carrier_khz)),
            Mode::Frequency => self.put(format_args!("GT_SetPulseWidth({}, {channel});\n", laser.pulse_width_us)),
            Mode::Analog => {}
        }
        self.put(format_args!("GT_SetLevelDelay({}, {}, {channel});\n", laser.off_delay_us, laser.on_delay_us));
        if self.machine.lasers.len() > 1 {
            self.put(format_args!("GT_LaserOff({channel});\n"));
        }
        self.put(format_args!("GT_BufLaserFollowMode(1, 0, 0, {channel});\n"));
        self.entries += 1;
    }

    /// An entry of the path is complete.
    fn entered(&mut self) {
        self.entries += 1;
        if !self.started && self.entries >= START_ENTRIES {
            self.started = true;
            self.text.push_str("GT_CrdStart(1, 0);\n");
        }
    }

    /// From here on this laser of the machine marks; the one before is dark.
    pub fn choose(&mut self, laser: usize) {
        if laser != self.laser {
            self.light(None);
            self.laser = laser;
        }
    }

    /// Sets the light from here on.
    fn light(&mut self, want: Option<Power>) {
        let Some(laser) = self.machine.lasers.get(self.laser) else { return };
        let (channel, lsr) = (laser.channel, self.machine.family == Family::Lsr);
        if want == self.power {
            return;
        }
        match want {
            None => {
                self.put(format_args!("GT_BufLaserOff(1, 0, {channel});\n"));
                self.entered();
            }
            Some(Power::Constant(power)) => {
                if lsr {
                    self.put(format_args!("GT_BufLaserFollowOff(1, 0, {channel});\n"));
                    self.entered();
                }
                let power = Number(power);
                self.put(format_args!("GT_BufLaserPrfCmd(1, {power}, 0, {channel});\n"));
                self.entered();
            }
            Some(Power::Follow { ratio, most }) => {
                if lsr {
                    self.put(format_args!("GT_BufLaserPrfCmd(1, 0, 0, {channel});\n"));
                    self.entered();
                }
                let (ratio, most) = (Number(ratio), Number(most));
                self.put(format_args!("GT_BufLaserFollowRatio(1, {ratio}, 0, {most}, 0, {channel});\n"));
                self.entered();
            }
        }
        if self.power.is_none() {
            self.put(format_args!("GT_BufLaserOn(1, 0, {channel});\n"));
            self.entered();
        }
        self.power = want;
    }

    /// Stands still.
    pub fn dwell(&mut self, line: usize, ms: u64, light: Light) {
        self.light(match light {
            Light::Constant(power) => Some(Power::Constant(power)),
            Light::Dark | Light::Follow(_) => None,
        });
        if let Some(time) = &mut self.time {
            time.dwell(ms as f64);
        }
        let mut left = ms;
        while left > 0 {
            let part = left.min(DELAY_MAX_MS);
            self.put(format_args!("GT_BufDelay(1, {part}); // {line}\n"));
            self.entered();
            left -= part;
        }
    }

    /// Switches a general output.
    pub fn output(&mut self, output: u8, on: bool) {
        self.put(format_args!("GT_BufDoBit(1, 12, {output}, {});\n", u8::from(on)));
        self.entered();
    }

    /// Shows from here on where the path goes.
    pub fn watched(&mut self, watch: Watch<'a>) {
        watch([0, 1, 2].map(|axis| self.machine.axes.get(axis).map_or(0.0, |axis| axis.home)), None);
        self.watch = Some(watch);
    }

    /// Shows a motion, as lines.
    pub fn show(&mut self, stroke: &Stroke) {
        let Some(watch) = &mut self.watch else { return };
        let lit = (stroke.light != Light::Dark).then_some(self.laser);
        if let Shape::Arc { axes: [a, b, across], arc } = &stroke.shape {
            let rise = to_f64(stroke.to[*across] - stroke.from[*across]);
            let parts = arc.parts(PICTURE_TOLERANCE_MM.min(arc.radius() / 1000.0)).min(1000);
            for number in 1..parts {
                let part = f64::from(number) / f64::from(parts);
                let mut point = stroke.from.map(to_f64);
                let [x, y] = arc.at(part);
                (point[*a], point[*b]) = (point[*a] + x, point[*b] + y);
                point[*across] += rise * part;
                watch(point, lit);
            }
        }
        watch(stroke.to.map(to_f64), lit);
    }

    /// Nobody asks for the time that the path takes.
    pub fn untimed(&mut self) {
        self.time = None;
    }

    /// What was covered so far.
    pub fn extent(&mut self) -> Extent {
        let rows = |covered: Option<[(f64, f64); 3]>| {
            let ends = covered.into_iter().flatten();
            self.machine.axes.iter().zip(ends).map(|(axis, (least, most))| (axis.letter, least, most)).collect()
        };
        let [all, marks] = self.covered.map(rows);
        let seconds = self.time.as_mut().map(|time| time.total() / 1000.0);
        let lasers = self.machine.lasers.iter().zip(&self.marked);
        let lasers = lasers.filter_map(|(laser, length)| Some((laser.name.clone()?, *length))).collect();
        Extent { all, marks, length: (self.length[0], self.length[1]), lasers, seconds }
    }

    fn cover(&mut self, stroke: &Stroke) {
        let ends = [0, 1, 2].map(|axis| [stroke.from[axis], stroke.to[axis]].map(to_f64));
        let mut ends = ends.map(|[from, to]| (from.min(to), from.max(to)));
        if let Shape::Arc { axes: [a, b, _], arc } = &stroke.shape {
            for (axis, (least, most)) in [*a, *b].into_iter().zip(arc.extent()) {
                let from = to_f64(stroke.from[axis]);
                ends[axis] = (ends[axis].0.min(from + least), ends[axis].1.max(from + most));
            }
        }
        let length = stroke.shape.length(stroke.from, stroke.to);
        for part in 0..1 + usize::from(stroke.light != Light::Dark) {
            let covered = self.covered[part].get_or_insert(ends);
            for (covered, end) in covered.iter_mut().zip(ends) {
                *covered = (covered.0.min(end.0), covered.1.max(end.1));
            }
            self.length[part] += length;
        }
        if let Some(marked) = self.marked.get_mut(self.laser).filter(|_| stroke.light != Light::Dark) {
            *marked += length;
        }
    }

    /// Whether the controller runs a motion of so many mm/min, whichever axes it moves.
    ///
    /// # Errors
    /// The speed and the least one.
    pub fn check_speed(&self, speed: f64) -> Result<(), String> {
        let steps = self.scales.iter().map(|scale| scale.per_mm.abs()).fold(f64::INFINITY, f64::min);
        let least = SPEED_MIN_PULSES_PER_MS / steps * 60_000.0;
        if speed * self.feed >= least {
            return Ok(());
        }
        let asked = speed * self.feed;
        Err(format!("{asked} mm/min are asked for; the slowest motion is {least:.6} mm/min, at {steps} pulses a mm"))
    }

    /// What the user ought to know of the job: its line, where it has one, and the text.
    pub fn notes(&self) -> Vec<(usize, String)> {
        let hasty = self.unreached_speed.iter().map(|UnreachedSpeed { line, asked, reached }| {
            let text = format!(
                "{asked:.0} mm/min are asked for, and the machine reaches {reached:.0} there; light whose power follows \
                 the speed stays weaker"
            );
            (*line, text)
        });
        hasty.collect()
    }

    /// From now on what is written is handed over by [`Self::taken`], and whoever takes it starts
    /// the path.
    pub fn stream(&mut self) {
        self.started = true;
    }

    /// Bytes that [`Self::taken`] would hand over.
    pub fn size(&self) -> usize {
        self.text.len()
    }

    /// What was written since the last time.
    pub fn taken(&mut self) -> String {
        std::mem::take(&mut self.text)
    }

    /// Motions at F run at `feed` times that, rapid ones at `rapid` times the machine's speed.
    pub fn factors(&mut self, feed: f64, rapid: f64) {
        (self.feed, self.rapid) = (feed, rapid);
    }

    /// The path begins anew, dark, at these pulses; in mm that is returned.
    pub fn restart_at(&mut self, pulses: [f64; 3]) -> [i128; 3] {
        self.power = None;
        let mut mm = [0; 3];
        for (place, scale) in self.scales.iter().enumerate() {
            self.at[place] = pulses[place].round() as i64;
            mm[place] = scale.mm(pulses[place]);
        }
        mm
    }

    /// What a line that fails must not change.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint { size: self.text.len(), at: self.at, power: self.power, entries: self.entries }
    }

    /// As it was then.
    pub fn restore(&mut self, mark: &Checkpoint) {
        self.text.truncate(mark.size);
        (self.at, self.power, self.entries) = (mark.at, mark.power, mark.entries);
    }

    /// The job, as far as it was not taken.
    pub fn finish(mut self) -> String {
        self.light(None);
        if self.machine.lasers.len() > 1 {
            for laser in &self.machine.lasers {
                let _ = writeln!(self.text, "GT_BufLaserOff(1, 0, {});", laser.channel);
            }
        }
        self.text.push_str("GT_CrdData(1, NULL, 0);\n");
        if !self.started {
            self.text.push_str("GT_CrdStart(1, 0);\n");
        }
        self.text.push_str("WaitStop(1, 0, 1);\nSleep(1);\n");
        self.text
    }
}
