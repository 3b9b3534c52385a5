//! A machine that only stores its set-points and outputs, so that the counts are of the tick alone.
//!
//! In: the tick's outputs. Out: inactive inputs, and set-points read back as encoders. Owns what it
//! stored. Cannot fail.
use servo::laser::LaserPlan;
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, Port};
use servo::units::{Axis, Pos};

/// The machine, of so many axes.
pub struct Sink<const AXES: usize> {
    set_points: [Pos; AXES],
    outputs: (u64, u64, GeneralOutputs),
    analog: [i16; 8],
}

impl<const AXES: usize> Sink<AXES> {
    /// At power-on.
    pub const POWER_ON: Self = Self { set_points: [Pos(0); AXES], outputs: (0, 0, 0), analog: [0; 8] };
}

impl<const AXES: usize> Port for Sink<AXES> {
    fn inputs(&mut self, _: Axis) -> AxisInputs {
        AxisInputs::default()
    }
    fn encoder(&mut self, axis: Axis) -> i64 {
        self.set_points.get(axis.index()).map_or(0, |pos| pos.0 >> Pos::FRAC_BITS)
    }
    fn general_inputs(&mut self) -> GeneralInputs {
        0
    }
    fn analog(&mut self, _: usize) -> i16 {
        0
    }
    fn set_point(&mut self, axis: Axis, pos: Pos) {
        if let Some(place) = self.set_points.get_mut(axis.index()) {
            *place = pos;
        }
    }
    fn outputs(&mut self, _: u32, enable: u64, clear: u64, general: GeneralOutputs) {
        self.outputs = (enable, clear, general);
    }
    fn analog_out(&mut self, _: u32, channel: usize, value: i16) {
        if let Some(place) = self.analog.get_mut(channel) {
            *place = value;
        }
    }
    fn interlock(&mut self) -> bool {
        false
    }
    fn laser(&mut self, _: usize, _: &LaserPlan) {}
}
