//! Outputs and inputs of a core: calls, and levels.

/// A call. Indices of general outputs and inputs, and of analog outputs, are from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    SetDo {
        core: i16,
        value: i32,
    },
    SetDoBit {
        core: i16,
        index: i16,
        level: bool,
    },
    GetDo {
        core: i16,
    },
    GetDi {
        core: i16,
        kind: i16,
    },
    /// The same three in words of 32 levels, of which there is one.
    SetDoEx {
        core: i16,
        value: i32,
    },
    GetDoEx {
        core: i16,
        count: i16,
    },
    GetDiEx {
        core: i16,
        kind: i16,
        count: i16,
    },
    SetDac {
        core: i16,
        dac: i16,
        value: i16,
    },
    GetDac {
        core: i16,
        dac: i16,
    },
    SimInput {
        core: i16,
        index: i16,
        level: bool,
    },
    /// SimInput of the interlock, and what its opening does to motion.
    Interlock {
        core: i16,
        open: bool,
    },
    SetInterlock {
        motion: i16,
    },
    SimAdc {
        core: i16,
        adc: i16,
        volts: f64,
    },
    GetAdc {
        core: i16,
        adc: i16,
    },
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
            Effect::GetDi { core, kind } => format!("rtn = GTN_GetDi({core},{kind},&word);"),
            Effect::SetDoEx { core, value } => format!("word = {value}; rtn = GTN_SetDoEx({core},12,&word,1);"),
            Effect::GetDoEx { core, count } => format!("rtn = GTN_GetDoEx({core},12,&word,{count});"),
            Effect::GetDiEx { core, kind, count } => format!("rtn = GTN_GetDiEx({core},{kind},&word,{count});"),
            Effect::SetDac { core, dac, value } => {
                format!("space = {value}; rtn = GTN_SetDac({core},{dac},&space);")
            }
            Effect::GetDac { core, dac } => format!("rtn = GTN_GetDac({core},{dac},&space);"),
            Effect::Interlock { core, open } => format!("rtn = GTN_SimInput({core},90,1,{});", level(open)),
            Effect::SetInterlock { motion } => format!("rtn = GT_SetInterlock({motion});"),
            Effect::SimAdc { core, adc, volts } => format!("rtn = GTN_SimAdc({core},{adc},{volts:?});"),
            Effect::GetAdc { core, adc } => format!("rtn = GTN_GetAdc({core},{adc},&value,1);"),
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
    /// Values that they had within the tick before and have no more: channel from 0, value.
    pub passed: Vec<(usize, i16)>,
    /// Those that a laser in analog mode drives, bit 0 is output 1.
    pub driven: u8,
    /// General inputs.
    pub inputs: u32,
    /// Analog inputs, V.
    pub volts: [f64; 8],
}

impl Levels {
    pub fn input(&mut self, index: i16, level: bool) {
        let bit = 1 << (index - 1);
        self.inputs = if level { self.inputs | bit } else { self.inputs & !bit };
    }
}
