//! What a compiled job is: steps in the order of the script, ready for the program queue.

use crate::Diagnostic;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// A compiled job.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// What it does, in order.
    pub steps: Vec<Step>,
    /// Pragmas that replace options of the command line, each once, in order.
    pub pragmas: Vec<Pragma>,
    /// What was accepted although it is odd: misspelt names, stray braces, assumed values.
    pub warnings: Vec<Diagnostic>,
    /// Axes that the job uses (it sets their mode or position, or maps them to a coordinate system,
    /// or a path moves them), ascending.
    pub axes: Vec<Axis>,
    /// Coordinate systems that the job sets up, ascending.
    pub crds: Vec<Crd>,
    /// Laser channels that the job uses (a call sets something of them), bit k is channel k.
    pub lasers: u8,
    /// Every core and axis that a call or a configuration file names, and the line of the script
    /// that names it first; axis 0 means the core alone. It may hold ones that no controller has.
    pub named: BTreeMap<Axis, u32>,
}

/// `#pragma family`, `profile` or `tick`. Its value is looked at by whoever has the options.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pragma {
    /// `family`, `profile` or `tick`.
    pub name: &'static str,
    /// The value after the name.
    pub value: String,
    /// Line of the script, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// Its bytes in the script.
    pub span: std::ops::Range<usize>,
}

/// An axis of a core, both counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Axis {
    /// Logical core.
    pub core: i16,
    /// Axis of that core.
    pub axis: i16,
}

/// A coordinate system of a core, both counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crd {
    /// Logical core.
    pub core: i16,
    /// Coordinate system of that core.
    pub crd: i16,
}

/// One entry of the program.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Line of the script, from 1.
    pub line: u32,
    /// Column of the statement in characters, from 1.
    pub column: u32,
    /// The statement's bytes in the script.
    pub span: std::ops::Range<usize>,
    /// What it does.
    pub action: Action,
}

/// What a step does.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// The script clock advances by this time.
    Sleep {
        /// Nanoseconds.
        ns: u64,
    },
    /// Until the first tick at which nothing named runs.
    WaitStop {
        /// Logical core, from 1.
        core: i16,
        /// Bit k - 1 is axis k.
        axes: u32,
        /// Bit k - 1 is coordinate system k.
        crds: u32,
    },
    /// `while(!kbhit())`: until nothing runs on any core. The runner knows how many axes there are.
    WaitAll,
    /// A request to the controller.
    Call(Call),
}

/// A request to the controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Call {
    /// The name as the manuals print it, with its prefix.
    pub function: Cow<'static, str>,
    /// Number on the wire.
    pub opcode: u16,
    /// The packed request: its struct, then its items.
    pub body: Vec<u8>,
    /// Variables that the reply's values go to, for display.
    pub outs: Vec<Out>,
    /// The job continues when this call fails: its result is assigned and `#pragma continue` is on.
    pub may_fail: bool,
}

/// A variable that a reply fills.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Out {
    /// Parameter name of the function.
    pub parameter: &'static str,
    /// The variable as the script names it.
    pub variable: String,
}
