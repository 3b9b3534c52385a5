//! Calls of laser channels, and how a job writes them.

/// Where the two laser manuals differ (SPEC 2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Family {
    #[default]
    Gus,
    Lsr,
}

/// A call of a laser channel, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightCall {
    pub channel: i16,
    pub what: LightOf,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightOf {
    /// SetAxisMode: whether its connector carries it.
    Connector(bool),
    /// LaserPowerMode.
    Mode {
        mode: i16,
        max: f64,
        min: f64,
        delayed: bool,
    },
    /// LaserOutFrq, kHz.
    Carrier(f64),
    /// SetPulseWidth, µs.
    Width(u32),
    Gate(bool),
    /// SetHSIOOpt.
    Switch(u16),
    Power(f64),
    Map(i16),
    /// SetLevelDelay, µs.
    Delays {
        off: u32,
        on: u32,
    },
    /// EnaFPK: time1, time2, laserOffDelay, µs.
    Fpk([u32; 3]),
    /// DisFPK.
    NoFpk,
    /// SetWaitPulse: kHz, %.
    Standby {
        on: bool,
        khz: f64,
        duty: f64,
    },
    /// SetWaitPulseEx, of both channels.
    StandbyBoth {
        on: bool,
        khz: f64,
        duty: f64,
    },
    /// SetLaserMode, of both channels.
    Resolution(i16),
    /// SetPreVltg.
    PreVoltage {
        on: bool,
        volts: f64,
    },
    /// SetLaserDisMode: source, references and scales; None ends it.
    Distance(Option<(i16, [i32; 4], [f64; 4])>),
    /// SetLaserDisRatio.
    Ratios([f64; 4], [f64; 2]),
    /// Stop, bits 10 and 11: the follows of these coordinate systems end, bit 0 is crd 1.
    EndFollow(i32),
    ZeroOnTime,
    ClearFault,
    GetGate,
    /// LaserOnStatus.
    GetSwitched,
    GetMap,
    GetPower,
    GetOnTime,
    GetFault,
}

impl LightCall {
    /// The axis whose connector carries it.
    pub fn axis(&self) -> i16 {
        7 + self.channel
    }

    /// A statement of a job, the one with this number.
    pub fn text(&self, number: usize) -> String {
        let channel = self.channel;
        let bit = |on: bool| i16::from(on);
        let list = |of: [f64; 4]| of.map(|x| format!("{x:?}")).join(",");
        let call = match self.what {
            LightOf::Connector(on) => format!("SetAxisMode(1,{},{})", self.axis(), bit(on)),
            LightOf::Mode { mode, max, min, delayed } => {
                format!("LaserPowerMode(1,{mode},{max:?},{min:?},{channel},{})", bit(delayed))
            }
            LightOf::Carrier(khz) => format!("LaserOutFrq(1,{khz:?},{channel})"),
            LightOf::Width(us) => format!("SetPulseWidth(1,{us},{channel})"),
            LightOf::Gate(true) => format!("LaserOn(1,{channel})"),
            LightOf::Gate(false) => format!("LaserOff(1,{channel})"),
            LightOf::Switch(value) => format!("SetHSIOOpt(1,{value},{channel})"),
            LightOf::Power(power) => format!("LaserPrfCmd(1,{power:?},{channel})"),
            LightOf::Map(map) => format!("SetLaserCrdMap(1,{channel},{map})"),
            LightOf::Delays { off, on } => format!("SetLevelDelay(1,{off},{on},{channel})"),
            LightOf::Fpk([time1, time2, off]) => format!("EnaFPK(1,{time1},{time2},{off},{channel})"),
            LightOf::NoFpk => format!("DisFPK(1,{channel})"),
            LightOf::Standby { on, khz, duty } => {
                format!("SetWaitPulse(1,{},{khz:?},{duty:?},{channel})", bit(on))
            }
            LightOf::StandbyBoth { on, khz, duty } => format!("SetWaitPulseEx(1,{},{khz:?},{duty:?})", bit(on)),
            LightOf::Resolution(mode) => format!("SetLaserMode(1,{mode})"),
            LightOf::PreVoltage { on, volts } => format!("SetPreVltg(1,{},{volts:?},{channel})", bit(on)),
            LightOf::Distance(of) => {
                let (source, from, scale) = of.unwrap_or((0, [0; 4], [1.0; 4]));
                let from = from.map(|x| x.to_string()).join(",");
                return format!(
                    "long f{number}[] = {{{from}}}; double s{number}[] = {{{}}}; \
                     rtn = GTN_SetLaserDisMode(1,{},{source},f{number},s{number},{channel});",
                    list(scale),
                    bit(of.is_some()),
                );
            }
            LightOf::Ratios(ratio, [min, max]) => {
                return format!(
                    "double r{number}[] = {{{}}}; \
                     rtn = GTN_SetLaserDisRatio(1,r{number},{min:?},{max:?},{channel});",
                    list(ratio),
                );
            }
            LightOf::EndFollow(crds) => return format!("rtn = GT_Stop({},0);", crds << 10),
            LightOf::ZeroOnTime => format!("ZeroLaserOnTime(1,{channel})"),
            LightOf::ClearFault => format!("ClrLaserFault(1,{channel})"),
            LightOf::GetGate => format!("GetHSIOOpt(1,&space,{channel})"),
            LightOf::GetSwitched => format!("LaserOnStatus(1,&space,{channel})"),
            LightOf::GetMap => format!("GetLaserCrdMap(1,{channel},&space)"),
            LightOf::GetPower => format!("GetLaserPower(1,{channel},&value)"),
            LightOf::GetOnTime => format!("GetLaserOnTime(1,{channel},&light)"),
            LightOf::GetFault => format!("GetLaserFault(1,{channel},&space)"),
        };
        format!("rtn = GTN_{call};")
    }
}
