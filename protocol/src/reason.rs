//! Why a command was refused: a return code (SPEC 3) and a reason. A person can read the reason
//! once the host has added the names of command and parameter.

use crate::command::{Wire, opcode};
use core::fmt::{self, Display, Formatter};
use zerocopy::little_endian::{F64, I16, U16};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// Return values of SPEC section 3 that the controller itself gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i16)]
pub enum Code {
    /// Done.
    Done = 0,
    /// Cannot be executed in the present state.
    State = 1,
    /// Library and firmware do not match.
    Mismatch = 3,
    /// A parameter is out of range.
    Range = 7,
    /// The firmware does not know the command.
    Unknown = 8,
}

/// What could make a refused entry of a program right after all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cure {
    /// No later state of the machine. Only entries before it in its program could, and these have
    /// been admitted.
    None,
    /// The end of a motion, a use or a fault of an axis, a table or a coordinate system.
    Motion,
    /// Any other change of state.
    State,
}

macro_rules! reasons {
    ($( $number:literal $name:ident $code:ident $cure:ident $text:literal ; )*) => {
        /// What was wrong, as a number on the wire.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(u16)]
        pub enum Reason { $( #[doc = $text] $name = $number, )* }
        /// Every reason: its number, its return code and its text. In the text `{field}` is the
        /// parameter's name, `{got}` the given value, `{low}` and `{high}` the limits, `{axis}` the
        /// axis. `{cause}` is the [`laser_cause`] and `{stop}` the [`stop_reason`] whose number is
        /// `high`.
        pub const REASONS: &[(Reason, Code, &str)] = &[$( (Reason::$name, Code::$code, $text), )*];
        impl Reason {
            /// The reason with this number.
            pub const fn from_number(number: u16) -> Option<Self> {
                match number { $( $number => Some(Reason::$name), )* _ => None }
            }
            /// Its return code.
            pub const fn code(self) -> Code {
                match self { $( Reason::$name => Code::$code, )* }
            }
            /// What could make an entry right that was refused for it.
            pub const fn cure(self) -> Cure {
                match self { $( Reason::$name => Cure::$cure, )* }
            }
            /// Its text, with placeholders.
            pub const fn text(self) -> &'static str {
                match self { $( Reason::$name => $text, )* }
            }
        }
    };
}

reasons! {
    1  OutOfRange Range None "{field} is {got}; it must be from {low} to {high}";
    2  NotFinite Range None "{field} is not a finite number";
    3  NotIncreasing Range Motion "{field} is {got}; it must be greater than {low}, that of the segment before";
    4  TooFast Range Motion "{field}: this segment's speed is {got} pulse/ms; the limit is {high}";
    5  Length Range None "the command's length is wrong: {got} bytes came, {low} were expected";
    6  TooMany Range None "{field} is {got}; at most {high} fit";
    7  BeyondTravel Range None "{field} is {got}; an axis travels from {low} to {high} pulses";
    8  Selector Range None "{field} is {got}; allowed are {low} to {high}";
    20 UnknownCommand Unknown None "the firmware does not know command number {got}";
    21 Mismatch Mismatch State "client and firmware speak different protocol versions: {got} here, {high} there";
    22 ProfileTooLarge Mismatch State "this board cannot hold the profile: it has room for {high} axes, {got} are asked for";
    23 ProfileOutputs Mismatch State "this board cannot hold the profile: it has room for {high} general inputs or outputs, {got} are asked for";
    30 WrongMode State None "axis {axis} is not in the mode that this command is for; its mode is {got}";
    31 Moving State Motion "axis {axis} is moving; stop it first";
    32 FifoFull State Motion "axis {axis}: the FIFO is full; {high} segments fit";
    33 FifoEmpty State None "axis {axis}: the FIFO holds no data";
    34 ServoOff State None "axis {axis}: the servo is off; call AxisOn first";
    35 AxisFault State Motion "axis {axis} has a drive alarm or its following error is too large, which is latched (status {got}); clear the cause and call ClrSts";
    36 FifoInUse State Motion "axis {axis}: FIFO {got} is running; it can be cleared at rest";
    37 NotInDynamic State None "axis {axis}: not available in dynamic PT mode";
    38 NoAcceleration State None "axis {axis}: its acceleration is 0; set the motion parameters first (SetJogPrm, SetTrapPrm)";
    39 ProgramRuns State State "a program is running; only reads and Stop are taken beside it";
    40 QueueFull State State "the program queue is full; {high} bytes fit";
    41 NotInProgram State None "this command is only for the program queue";
    42 Discarded State State "not executed: an earlier entry of the program failed, or it was stopped";
    43 RingFull State State "the controller is busy; send it again";
    44 Late State State "not executed: an entry before it was late, and the program is strict";
    45 NotInitialised State None "axis {axis} does not exist in this profile";
    46 OnlyAtStandstill State Motion "only while every axis is at standstill; axis {axis} is moving";
    47 ProgramOnlyHeld State State "the program is not held; it runs already or has failed";
    48 TraceLost State State "the trace lost rows: the link does not carry {got} rows a second";
    49 NotForProgram State None "this command cannot be an entry of a program";
    50 LinkLost State State "not executed: nothing came from the host for longer than the link-loss time, and the program was dropped";
    51 NoDeceleration State None "axis {axis}: its deceleration is 0; set the motion parameters first (SetTrapPrm)";
    52 AtSoftLimit State State "axis {axis} stands at its software limit of {got} pulses; it can only move away from it";
    53 AtLimitSwitch State State "axis {axis}: the limit switch in this direction is active; it can only move away from it";
    54 SwitchPending State Motion "axis {axis}: a FIFO switch is pending; neither FIFO can be cleared before it has happened";
    55 StateChanged State State "axis {axis} cannot start: its state has changed since the call was taken (status {got})";
    56 StreamEnded State State "axis {axis}: the motion that this data belongs to ended before it ({stop}); the data was not taken";
    57 PositiveLatched State Motion "axis {axis} has come to its positive limit, which is latched (status {got}); call ClrSts, then move it downwards";
    58 NegativeLatched State Motion "axis {axis} has come to its negative limit, which is latched (status {got}); call ClrSts, then move it upwards";
    60 TableInUse State Motion "PVT table {got} is in use by axis {axis}; it can be replaced when no axis runs it";
    61 TableEmpty State None "axis {axis}: PVT table {got} is empty";
    62 TableFull Range None "the table does not fit: its points need more than {high} slots (two where the velocity jumps; a Percent point up to 3, a Continuous point up to 8)";
    63 PointTime Range None "{field} is {got}; it must be greater than {low}, that of the point before";
    64 VelocityUnreachable Range None "the velocity of the next point cannot be reached: the displacement is {got} pulses, the change of velocity needs {low}";
    65 NoDisplacement Range None "the next point has the same position; a Continuous segment needs a displacement";
    66 AboveVelMax Range None "a velocity of {got} pulse/ms in the direction of travel is above the limit of this segment, {high}";
    67 TableRange Range None "no scale holds this table: its top speed {got} pulse/ms over its longest segment is too far";
    68 TableShort Range None "a pass of {got} ms is too short; it lasts {low} ms at least";
    80 NoMaster State None "axis {axis}: it has no master; call SetFollowMaster, in Gear SetGearMaster, first";
    81 OwnMaster Range None "{field} is {got}, the axis itself; an axis cannot follow itself";
    82 MasterCycle State None "axis {axis} would follow itself by way of axis {got} of core {low}";
    83 MasterType Range None "{field} is {got}; allowed are 1, 2, 3, and in a profile of two cores 101 and 103";
    84 DirectionDiffers State None "axis {axis} is in this mode with direction {got}; set another mode first";
    85 NotRunning State None "axis {axis} is not running, or is being stopped; a switch is for an axis that follows";
    86 MasterOrder Range Motion "{field} is {got}; it must lie beyond {low}, that of the segment before";
    87 MixedSigns Range Motion "{field} is {got}; all master positions of a FIFO have one sign, and the first has that of {low}";
    88 NegativeProgress Range None "{field} is {got}; an axis that follows in direction +1 takes positive master positions only";
    89 RatioTooLarge Range Motion "{field}: this segment's velocity ratio is {got}; the limit is {high}";
    90 QueueEntries State Motion "axis {axis}: the FIFO holds {high} entries that are no segments, which is the most";
    91 NoRatio State None "axis {axis}: it has no gear ratio; call SetGearRatio first";
    92 GearPart Range None "{field} is 0; a ratio needs a displacement of the master that is not 0";
    93 GearSlope Range None "{field} is {got}; it must be 0, which is the ratio at once, or from {low} to {high}";
    94 GearArea State None "{field} is {got}, AREA, which is not there; allowed are 1 START and 2 PASS";
    95 CrossingDirection Range None "{field} is {got}; it must be 1, the master crosses upwards, or -1, downwards";
    100 AboveLow Range None "{field} is {got}; it must be above {low} and at most {high}";
    101 BelowMinimum Range None "{field} is {got}; it must not be below the minimum, {low}";
    102 LaserFault State State "laser channel {got} is kept dark by a fault: {cause}; once that is over call ClrLaserFault";
    103 LaserCause State State "laser channel {got}: the cause of its fault is still there: {cause}";
    104 LaserConnector State None "laser channel {got}: axis connector {high} carries step pulses; call SetAxisMode({high}, 1) first, or choose family lsr, where it is the laser's";
    105 AnalogInUse State None "analog output {got} belongs to laser channel {low}, which is in analog mode";
    106 NotInFamily Unknown None "the laser connectors of this family are fixed: it has no such call";
    107 FollowTableInUse State State "follow table {got} of laser channel {low} is named by an entry of a path or by the follow in force; it can be replaced when neither is there";
    108 FollowTableEmpty State None "follow table {got} of laser channel {low} is empty; call SetLaserFollowTable first";
    109 DistanceOff State None "laser channel {got}: distance follow is off; call SetLaserDisMode(1, ...) first";
    110 CrdNotSet State None "coordinate system {axis} drives no axis; call SetCrdPrm first";
    111 CrdRuns State Motion "coordinate system {axis} is running; stop it first";
    112 CrdFull State State "coordinate system {axis}: the FIFO is full; {high} entries fit, {got} are free";
    113 CrdEmpty State State "coordinate system {axis}: FIFO {got} holds nothing to do";
    114 CrdElsewhere State State "coordinate system {axis} is more than a pulse from where FIFO {got} was left; move back there first, or call CrdClear";
    115 CrdFifoInUse State Motion "coordinate system {axis}: FIFO {got} is in use; it can be cleared at rest";
    116 CrdHolds State Motion "coordinate system {axis}: FIFO {got} holds entries; run them or call CrdClear first";
    117 CrdPositionUnknown State State "coordinate system {axis}: where the motion begins is known once everything is at rest";
    118 AxisInCrd State None "axis {axis} belongs to coordinate system {got}";
    119 AxisLeftCrd State None "axis {axis} is not driven by coordinate system {got} any more; call SetCrdPrm again";
    120 CoordinateTwice Range None "{field}: two axes drive coordinate {got}";
    121 CoordinateMissing Range None "{field}: no axis drives coordinate {got}; dimension is {high}";
    122 NoCoordinate Range None "{field} is {got}; no axis drives this coordinate, which stays 0";
    123 Between Range None "{field} is {got}; it must be above {low} and below {high}";
    124 NoLength Range None "the motion has no length: its target is where it begins";
    125 RadiusTooSmall Range None "{field} is {got}; the target is reached with {low} at least";
    126 CentreOff Range None "the centre is not equally far from begin and target: the path would leave the arc by {got} pulses, at most {high} are made up for";
    127 CentreOnStart Range None "{field}: the centre is where the motion begins; it must be at least {low} pulses away";
    128 RadiusTooLarge Range None "the radius is {got}; it must be below {high}";
    129 GearsFull State None "coordinate system {axis}: {high} axes go along with the next motion, which is the most";
    130 AxisGoesAlong State None "axis {axis} goes along with the next motion already";
    131 CrdNotOnBoard Mismatch None "this board has memory for {high} coordinate systems";
    132 StepLimit Range None "{field}: axis {axis} would go at {got} pulse/ms; the board's steps are limited to {high}";
    133 NoIndex Range None "{field} is {got}, the index, but the board captures none of encoder {axis}; allowed are {low} to {high}";
    134 CrdOfTick Range None "{field} is {got}; at this servo tick it must be from {low} to {high}: the others are there at 500 us and more";
    135 CrdNeedsTick State State "coordinate system {axis} of core {low} drives axes; below a tick of 500 us a core has {high}; reset its axes first";
    136 NotOfPath Range None "command number {got} is no call for FIFO {low} of coordinate system {axis}, which PathMany joins";
    137 NoLimitInput Range None "{field} is {got}; this board has no such limit input for axis {axis}";
    138 NoAlarmInput Range None "{field} is {got}; this board has no alarm input for axis {axis}";
    139 NoHomeInput Range None "{field} is {got}; this board has no home input for axis {axis}";
    140 NotAboveMinimum Range None "{field} is {got}; it must be above the minimum, {low}";
    141 PointOfAxis Range None "{field} of axis {axis} is {got}; it must be greater than {low}, that of the point before";
    142 PlaneAxis Range None "{field} names axis {got} twice; a plane has two";
    143 PlaneX Range None "a position of X is {got}; it must be a whole number of pulses, greater than {low}, that of the point before";
    144 PlaneY Range None "a position of Y is {got}; it must be a whole number of pulses, greater than {low}, that of the point before";
    145 RatiosBusy State State "laser channel {got}: a change of its ratios has not acted yet; this one comes after it";
    146 LaserNotMapped State None "laser channel {got} is not mapped to coordinate system {axis}; call SetLaserCrdMap first";
    147 LaserMapInUse State State "laser channel {got}: coordinate system {axis} runs, or has light of this channel that would come back; stop it, and switch the light off first";
    148 Aborting State State "after an abort lasers are switched on once everything has come to rest; wait for that";
    149 NoLaserOutput State None "laser channel {got}: this board has no output for its power in this mode";
    150 NoArriveInput Range None "{field} is {got}; this board has no arrival input for axis {axis}";
    151 TimedOutputs State State "{high} outputs keep a level for a time already, which is the most; wait for one of them";
    158 SlowPulses Range None "{field} is {got} kHz; it must be 0, or from {low} to {high}";
    160 InputsWired State State "the inputs of this board are wired; only those of the virtual and the emulated board are set by a call";
    161 InputType Range None "{field} is {got}; allowed are {low} to {high}, and 90, the interlock";
    162 ReadOnly State None "this session only reads; a session that commands takes this call";
}

/// The payload of a refusing reply.
#[derive(Debug, Clone, Copy, PartialEq, Default, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C, packed)]
pub struct Refusal {
    /// [`Reason`] number.
    pub reason: U16,
    /// Index of the parameter in the request's fields; 255 names none.
    pub field: u8,
    /// Index of the item that was refused, 65535 names none.
    pub item: U16,
    /// The axis concerned, 0 names none.
    pub axis: I16,
    /// What was given.
    pub got: F64,
    /// Lower limit.
    pub low: F64,
    /// Upper limit.
    pub high: F64,
}

impl Wire for Refusal {
    const FIELDS: &'static [(&'static str, &'static str)] = &[
        ("reason", "U16"),
        ("field", "u8"),
        ("item", "U16"),
        ("axis", "I16"),
        ("got", "F64"),
        ("low", "F64"),
        ("high", "F64"),
    ];
}

impl Refusal {
    /// Names no parameter.
    pub const NO_FIELD: u8 = 255;
    /// Names no item.
    pub const NO_ITEM: u16 = 65535;

    /// A refusal that names nothing but its reason.
    pub const fn new(reason: Reason) -> Self {
        Refusal {
            reason: U16::new(reason as u16),
            field: Self::NO_FIELD,
            item: U16::new(Self::NO_ITEM),
            axis: I16::new(0),
            got: F64::ZERO,
            low: F64::ZERO,
            high: F64::ZERO,
        }
    }

    /// Its reason, if it is one that this build knows.
    pub const fn reason(&self) -> Option<Reason> {
        Reason::from_number(self.reason.get())
    }
}

/// Why an axis or a coordinate system came to standstill: the cause, and how a summary says it. The
/// index is the number that events and statuses carry.
const STOP_REASONS: [(&str, &str); 20] = [
    ("it has not moved", "never moved"),
    ("it has ended", "motion completed"),
    ("a smooth Stop", "stopped smoothly by a Stop"),
    ("an abrupt Stop", "stopped abruptly by a Stop"),
    ("the positive limit switch", "stopped by the positive limit input"),
    ("the negative limit switch", "stopped by the negative limit input"),
    ("the positive soft limit", "stopped at the positive software limit"),
    ("the negative soft limit", "stopped at the negative software limit"),
    ("the drive's alarm", "stopped by the drive alarm"),
    ("the following error", "stopped: following error beyond its limit"),
    ("an underrun", "UNDERRUN: the data ran out at speed"),
    ("the edge of travel", "stopped at the edge of travel, 2^40 pulses"),
    ("its servo went off", "servo switched off"),
    ("the host link was lost", "stopped: the host link was lost"),
    ("a Reset", "reset"),
    ("an input did not come in time", "stopped: an input that FollowDiBitEx waits for did not come in time"),
    ("the step limit", "stopped: its master would have taken it beyond the step limit"),
    ("another axis could not go along", "stopped: another axis could not go along"),
    ("an abort", "stopped smoothly by an abort"),
    ("the interlock or emergency-stop input", "stopped by the interlock or emergency-stop input"),
];

/// The cause of a standstill.
pub fn stop_reason(number: u16) -> &'static str {
    STOP_REASONS.get(usize::from(number)).map_or("an unknown reason", |(cause, _)| cause)
}

/// How a summary says why an axis stopped last.
pub fn stop_summary(number: u16) -> &'static str {
    STOP_REASONS
        .get(usize::from(number))
        .map_or("stopped for a reason that this client does not know", |(_, summary)| summary)
}

/// Why a laser channel is dark until it is cleared, by the number that GetLaserFault reports (SPEC
/// 9).
pub const fn laser_cause(number: i16) -> &'static str {
    match number {
        0 => "none",
        1 => "the interlock or emergency-stop input is active",
        2 => "the host link was lost",
        3 => "a servo tick began late",
        4 => "the run before was ended by a fault or the watchdog",
        5 => "there were more gate edges than the channel can place",
        6 => "an axis of a coordinate system that gates it has a drive alarm",
        7 => "the servo of an axis of a coordinate system that gates it was switched off",
        8 => "an axis of a coordinate system that gates it hit a limit",
        9 => "a coordinate system that gates it ran out of entries at speed",
        10 => "a coordinate system that gates it had a fault",
        _ => "one that this client does not know",
    }
}

/// Why a laser command that had been admitted did nothing, by the number that an event carries.
pub const fn laser_ignored(number: u16) -> &'static str {
    match number {
        1 => "the channel is not mapped to the coordinate system of the entry",
        2 => "the command met no output: the axis connector carries step pulses",
        3 => "an abort was in progress",
        4 => "a fault keeps the channel dark",
        _ => "an unknown reason",
    }
}

/// A refusal as text: the command's name, then the reason's text with its placeholders filled in.
///
/// `field` is the name of the parameter; an empty one is printed as "the value".
pub fn describe<'a>(request: &'a str, field: &'a str, refusal: Refusal) -> impl Display + 'a {
    Description { opcode: 0, request, field, is_array: false, refusal }
}

/// As [`describe`], with the names that the command table has for `opcode`. An element of an array
/// is named as `profile[1]`, limits that are none are left out, small ones are rounded, and some
/// reasons say what helps.
pub fn describe_opcode(opcode: u16, refusal: Refusal) -> impl Display {
    let command = crate::command::info(opcode);
    // A parameter of an item is counted after those of the request.
    let field = command.and_then(|command| command.fields.iter().chain(command.items).nth(refusal.field.into()));
    Description {
        opcode,
        request: command.map_or("", |command| command.name),
        field: field.map_or("", |(name, _)| name),
        is_array: field.is_some_and(|(_, of)| of.starts_with('[')),
        refusal,
    }
}

struct Description<'a> {
    opcode: u16,
    request: &'a str,
    field: &'a str,
    /// The parameter has several values; the item is the place of one.
    is_array: bool,
    refusal: Refusal,
}

impl Description<'_> {
    /// The reason's text, where a limit or the command does not ask for another one.
    fn text(&self, reason: Reason) -> &'static str {
        let (low, high) = (self.refusal.low.get(), self.refusal.high.get());
        match (reason, self.opcode) {
            (Reason::OutOfRange, _) if high == f64::MAX => match low {
                f64::MIN => "{field} is {got}; it must be a finite number",
                low if 0.0 < low && low < SMALL => "{field} is {got}; it must be above 0 (at least {low})",
                _ => "{field} is {got}; it must be {low} or more",
            },
            (Reason::Between, opcode::SetCrdLimit) => {
                "{field} is {got}; it must be 0, which is no limit, or above {low} and below {high}"
            }
            (Reason::Selector, _) if low == high => "{field} is {got}; it must be {low}",
            (Reason::NotForProgram, opcode::SetTick) => {
                "the tick cannot change within a job or a program; #pragma tick N in the script sets a job's"
            }
            (Reason::LaserFault, _) if high == 0.0 => {
                "laser channel {got} was kept dark by a fault, which was cleared since; give the call again"
            }
            (Reason::CrdFull, _) => "coordinate system {axis}: the FIFO is full; {high} entries fit",
            (Reason::NoLength, opcode::ArcXYR | opcode::ArcYZR | opcode::ArcZXR) => {
                "the motion has no length: its target is where it begins; a full circle is made by its centre (ArcXYC, ArcYZC, ArcZXC)"
            }
            _ => reason.text(),
        }
    }

    /// What a caller wrote who has masks as `long`.
    fn as_long(&self, f: &mut Formatter<'_>, got: f64) -> fmt::Result {
        let mask = got as u32;
        let is_negative = self.field == "mask" && f64::from(mask) == got && mask > i32::MAX as u32;
        if is_negative { write!(f, " (as a long {})", mask as i32) } else { Ok(()) }
    }
}

impl Display for Description<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let refusal = &self.refusal;
        if !self.request.is_empty() {
            write!(f, "{}: ", self.request)?;
        }
        let Some(reason) = refusal.reason() else {
            return write!(f, "refused for reason {}, which this client does not know", refusal.reason.get());
        };
        let item = Some(refusal.item.get()).filter(|item| *item != Refusal::NO_ITEM);
        let element = item.filter(|_| self.is_array);
        let mut rest = self.text(reason);
        while let Some((before, after)) = rest.split_once('{') {
            f.write_str(before)?;
            let Some((name, after)) = after.split_once('}') else { break };
            match (name, element) {
                ("field", _) if self.field.is_empty() => f.write_str("the value")?,
                ("field", Some(element)) => write!(f, "{}[{element}]", self.field)?,
                ("field", None) => f.write_str(self.field)?,
                ("got", _) => {
                    exact(f, refusal.got.get())?;
                    self.as_long(f, refusal.got.get())?;
                }
                ("low", _) => rounded(f, refusal.low.get())?,
                ("high", _) => rounded(f, refusal.high.get())?,
                ("cause", _) => f.write_str(laser_cause(refusal.high.get() as i16))?,
                ("stop", _) => f.write_str(stop_reason(refusal.high.get() as u16))?,
                ("axis", _) => write!(f, "{}", refusal.axis.get())?,
                _ => write!(f, "{{{name}}}")?,
            }
            rest = after;
        }
        f.write_str(rest)?;
        match item.filter(|_| element.is_none()) {
            None => Ok(()),
            Some(item) => write!(f, " (item {})", u32::from(item) + 1),
        }
    }
}

/// Whole numbers without decimals; very large and very small ones with an exponent.
fn exact(f: &mut Formatter<'_>, value: f64) -> fmt::Result {
    let size = if value < 0.0 { -value } else { value };
    if size.is_finite() && size != 0.0 && !(1e-6..1e16).contains(&size) {
        write!(f, "{value:e}")
    } else {
        write!(f, "{value}")
    }
}

/// Limits below this are rounded.
const SMALL: f64 = 1e-3;

/// The same of a limit, four digits of a small one: those are powers of two.
fn rounded(f: &mut Formatter<'_>, value: f64) -> fmt::Result {
    if 0.0 < value && value < SMALL { write!(f, "{value:.3e}") } else { exact(f, value) }
}
