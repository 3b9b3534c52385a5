//! What a trace consists of: one [`Header`], then [`Row`]s.
use servo::segment::piece::Scaled;
use servo::units::Pos;

/// A traced axis: core and axis of the core, both from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct AxisName {
    /// Logical core, from 1.
    pub core: u8,
    /// Axis of the core, from 1.
    pub axis: u8,
}

impl std::fmt::Display for AxisName {
    /// `axisN` on the first core, `coreM_axisN` on the others.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.core {
            1 => write!(f, "axis{}", self.axis),
            core => write!(f, "core{core}_axis{}", self.axis),
        }
    }
}

/// A traced laser channel, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct LaserName(pub u8);

impl std::fmt::Display for LaserName {
    /// `laserK`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "laser{}", self.0)
    }
}

/// A traced coordinate system: core and coordinate system of the core, both from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CrdName {
    /// Logical core, from 1.
    pub core: u8,
    /// Coordinate system of the core, from 1.
    pub crd: u8,
}

impl std::fmt::Display for CrdName {
    /// `crdN` on the first core, `coreM_crdN` on the others.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.core {
            1 => write!(f, "crd{}", self.crd),
            core => write!(f, "core{core}_crd{}", self.crd),
        }
    }
}

/// What the rows of a trace have in common.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Header {
    /// Traced axes, ascending.
    pub axes: Vec<AxisName>,
    /// Traced laser channels, ascending.
    pub lasers: Vec<LaserName>,
    /// Traced coordinate systems, ascending.
    pub crds: Vec<CrdName>,
    /// Servo tick in ns when the trace begins.
    pub period_ns: u64,
    /// Ticks from one row to the next, at least 1.
    pub every: u32,
}

impl Header {
    /// Time from one row to the next, in ns, as long as the servo tick is that of the begin.
    pub fn row_ns(&self) -> u64 {
        self.period_ns * u64::from(self.every)
    }
}

/// One axis in one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AxisPoint {
    /// Planned position in force at the row's time.
    pub pos: Pos,
    /// Planned velocity in force at the row's time, pulse/ms.
    pub vel: Scaled,
}

/// Unit of a laser's power: that of the power mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum PowerUnit {
    /// Duty in %.
    #[default]
    Percent,
    /// Pulse rate in kHz.
    Kilohertz,
    /// Voltage in V.
    Volt,
}

/// One laser channel in one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LaserPoint {
    /// Level of the switch output, after delays.
    pub gate: bool,
    /// What is output, in `unit`; 0 when nothing is.
    pub power: Scaled,
    /// Its unit.
    pub unit: PowerUnit,
    /// Carrier or pulse rate in kHz; 0 when there are no pulses.
    pub frequency: Scaled,
}

/// One row: the values in force at `t_ns`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Row {
    /// Number of the row, from 0.
    pub index: u32,
    /// Time since the job's start.
    pub t_ns: u64,
    /// One point for each axis of the header, in its order.
    pub axes: Vec<AxisPoint>,
    /// One point for each laser of the header, in its order.
    pub lasers: Vec<LaserPoint>,
    /// Speed along the path of each coordinate system of the header, in its order, pulse/ms.
    pub crds: Vec<Scaled>,
}

/// An analog output that was set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AnalogEdge {
    /// Time since the job's start.
    pub t_ns: u64,
    /// Number of the output, from 1.
    pub output: u8,
    /// From then on: −32768…32767 is −10…10 V.
    pub code: i16,
}

/// A general output that changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputEdge {
    /// Time since the job's start.
    pub t_ns: u64,
    /// Number of the output, from 1.
    pub output: u8,
    /// Its level from then on.
    pub level: bool,
}
