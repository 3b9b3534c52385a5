//! Outputs and inputs of a core: calls, and levels.

/// A call. Indices of general outputs and inputs, and of analog outputs, are from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    SetDo { core: i16, value: i32 },
    SetDoBit { core: i16, index: i16, level: bool },
    GetDo { core: i16 },
    SetDac { core: i16, dac: i16, value: i16 },
    GetDac { core: i16, dac: i16 },
    SimInput { core: i16, index: i16, level: bool },
}

/// A call of a laser channel, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightCall {
    pub channel: i16,
    pub what: LightOf,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightOf {
    /// SetAxisMode: its connector carries it.
    Connector,
    /// LaserPowerMode, in duty mode.
    Bounds {
        max: f64,
        min: f64,
    },
    /// LaserOutFrq, kHz.
    Carrier(f64),
    Gate(bool),
    Power(f64),
    Map(i16),
    GetGate,
    GetPower,
}

impl LightCall {
    /// The axis whose connector carries it.
    pub fn axis(&self) -> i16 {
        7 + self.channel
    }

    /// A statement of a job.
    pub fn text(&self) -> String {
        let channel = self.channel;
        let call = match self.what {
            LightOf::Connector => format!("SetAxisMode(1,{},1)", self.axis()),
            LightOf::Bounds { max, min } => format!("LaserPowerMode(1,0,{max:?},{min:?},{channel},0)"),
            LightOf::Carrier(khz) => format!("LaserOutFrq(1,{khz:?},{channel})"),
            LightOf::Gate(true) => format!("LaserOn(1,{channel})"),
            LightOf::Gate(false) => format!("LaserOff(1,{channel})"),
            LightOf::Power(power) => format!("LaserPrfCmd(1,{power:?},{channel})"),
            LightOf::Map(map) => format!("SetLaserCrdMap(1,{channel},{map})"),
            LightOf::GetGate => format!("GetHSIOOpt(1,&space,{channel})"),
            LightOf::GetPower => format!("GetLaserPower(1,{channel},&value)"),
        };
        format!("rtn = GTN_{call};")
    }
}

impl Effect {
    /// A statement of a job.
    pub fn text(&self) -> String {
        let level = |level: bool| i16::from(level);
        match *self {
            Effect::SetDo { core, value } => format!("rtn = GTN_SetDo({core},12,{value});"),
            Effect::SetDoBit { core, index, level: of } => {
                format!("rtn = GTN_SetDoBit({core},12,{index},{});", level(of))
            }
            Effect::GetDo { core } => format!("rtn = GTN_GetDo({core},12,&word);"),
            Effect::SetDac { core, dac, value } => {
                format!("space = {value}; rtn = GTN_SetDac({core},{dac},&space);")
            }
            Effect::GetDac { core, dac } => format!("rtn = GTN_GetDac({core},{dac},&space);"),
            Effect::SimInput { core, index, level: of } => {
                format!("rtn = GTN_SimInput({core},4,{index},{});", level(of))
            }
        }
    }
}

/// Levels of a core.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Levels {
    /// General outputs, bit 0 is output 1.
    pub general: u32,
    /// Analog outputs.
    pub analog: [i16; 16],
    /// General inputs.
    pub inputs: u32,
}

impl Levels {
    pub fn input(&mut self, index: i16, level: bool) {
        let bit = 1 << (index - 1);
        self.inputs = if level { self.inputs | bit } else { self.inputs & !bit };
    }
}
