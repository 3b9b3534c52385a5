//! The commands, their numbers, what they are and their wire layouts: one table, from which the
//! structs, [`class`], the schema hash and the page `docs/protocol.md` follow.
//!
//! A row: number, name, [`CommandKind`], [`LaneRule`], the request's fields and `[items]`, the
//! reply's struct and `[items]`.
//!
//! A request is a packed little-endian struct (`zerocopy`), sometimes followed by items of one
//! fixed layout; so is a reply. Integers that the manuals' API passes as `short` or `long` travel
//! as `i16` and `i32`. So a wrong value reaches the dispatcher and is refused there by name.
//!
//! Names, parameters and their order: `API.md`; what a command does: `SPEC.md` sections 4 to 6.

pub use crate::class::{Chapter, Class, CommandKind, DataStore, LaneRule, ReadOf, Table, chapter};
pub use crate::layout::Wire;
use crate::layout::offset_of_fifo;
use zerocopy::little_endian::{F64, I16, I32, U16, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// A request that the controller answers.
pub trait Request: Wire {
    /// Its number on the wire.
    const OPCODE: u16;
    /// Its name, which is the manuals' without `GT_`/`GTN_` where they have it.
    const NAME: &'static str;
    /// What it is.
    const CLASS: Class;
    /// What follows the struct: zero or more items of this layout.
    type Item: Wire;
    /// The fixed part of a reply with code 0.
    type Reply: Wire;
    /// What follows the reply's fixed part.
    type ReplyItem: Wire;
}

/// One row of the table, for the protocol page, the reason texts and the schema hash.
#[derive(Debug, Clone, Copy)]
pub struct CommandInfo {
    /// Number on the wire.
    pub opcode: u16,
    /// Name.
    pub name: &'static str,
    /// What it is.
    pub class: Class,
    /// Fields of the request.
    pub fields: &'static [(&'static str, &'static str)],
    /// Fields of each item after the request.
    pub items: &'static [(&'static str, &'static str)],
    /// Fields of the reply.
    pub reply: &'static [(&'static str, &'static str)],
    /// Fields of each item after the reply.
    pub reply_items: &'static [(&'static str, &'static str)],
}

macro_rules! wire_structs {
    ($( $(#[$doc:meta])* $name:ident { $( $field:ident : $ty:ty ),* $(,)? } )*) => {$(
        $(#[$doc])*
        #[allow(missing_docs)]
        #[derive(Debug, Clone, Copy, PartialEq, Default, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
        #[repr(C, packed)]
        pub struct $name { $( pub $field: $ty ),* }
        impl Wire for $name {
            const FIELDS: &'static [(&'static str, &'static str)] = &[$( (stringify!($field), stringify!($ty)) ),*];
        }
    )*};
}
pub(crate) use wire_structs;

macro_rules! kind {
    (Read $of:ident) => {
        CommandKind::Read(ReadOf::$of)
    };
    (Data $fifo:ident) => {
        CommandKind::Data(DataStore::$fifo)
    };
    (Table $table:ident) => {
        CommandKind::Table(Table::$table)
    };
    ($kind:ident) => {
        CommandKind::$kind
    };
}

macro_rules! commands {
    ($( $opcode:literal $name:ident : $($kind:ident)+ , $lanes:ident { $( $field:ident : $ty:ty ),* $(,)? } [$item:ident] -> $reply:ident [$ritem:ident] ; )*) => {
        $(
            #[doc = concat!("Command ", stringify!($opcode), ": see `docs/protocol.md`.")]
            #[allow(missing_docs)]
            #[derive(Debug, Clone, Copy, PartialEq, Default, FromBytes, IntoBytes, KnownLayout, Immutable, Unaligned)]
            #[repr(C, packed)]
            pub struct $name { $( pub $field: $ty ),* }
            impl Wire for $name {
                const FIELDS: &'static [(&'static str, &'static str)] = &[$( (stringify!($field), stringify!($ty)) ),*];
            }
            impl Request for $name {
                const OPCODE: u16 = $opcode;
                const NAME: &'static str = stringify!($name);
                const CLASS: Class = Class { kind: kind!($($kind)+), lanes: LaneRule::$lanes };
                type Item = $item;
                type Reply = $reply;
                type ReplyItem = $ritem;
            }
        )*
        /// Every command that has a layout, by number.
        pub const COMMANDS: &[CommandInfo] = &[$(
            CommandInfo {
                opcode: $opcode,
                name: stringify!($name),
                class: <$name as Request>::CLASS,
                fields: <$name as Wire>::FIELDS,
                items: <$item as Wire>::FIELDS,
                reply: <$reply as Wire>::FIELDS,
                reply_items: <$ritem as Wire>::FIELDS,
            },
        )*];
        /// What the command with this number is; none if there is no such command. (Without the
        /// names and fields of [`COMMANDS`], which the controller does not hold.)
        pub const fn class(opcode: u16) -> Option<Class> {
            match opcode {
                $( $opcode => Some(<$name as Request>::CLASS), )*
                _ => None,
            }
        }
        /// Where a call that [`CommandKind::joins`] names its FIFO: bytes from the beginning of its
        /// request. None for any other command.
        pub const fn fifo_offset(opcode: u16) -> Option<usize> {
            match opcode {
                $( $opcode => const {
                    match <$name as Request>::CLASS.kind.joins() {
                        true => Some(offset_of_fifo(<$name as Wire>::FIELDS)),
                        false => None,
                    }
                }, )*
                _ => None,
            }
        }
        /// The numbers of the commands that have a layout, by name.
        #[allow(non_upper_case_globals, missing_docs)]
        pub mod opcode { $( pub const $name: u16 = $opcode; )* }
    };
}

mod layouts;
pub use layouts::*;

commands! {
    // -- session ---------------------------------------------------------------------------
    0x0001 Version: Read Controller, Any {} [Nothing] -> VersionReply [Nothing];
    0x0002 Reset: Set, Exclusive { core: I16 } [Nothing] -> Nothing [Nothing];
    0x0003 GetClock: Read Controller, Any {} [Nothing] -> Clock [Nothing];
    0x0004 ClrSts: Set, Any { core: I16, axis: I16, count: I16 } [Nothing] -> Nothing [Nothing];
    0x0005 SetTick: Set, ImmediateExclusive { tick_us: I32 } [Nothing] -> Nothing [Nothing];
    0x0006 SetLinkLoss: Set, Any { time_ms: I32, stop_all: I16 } [Nothing] -> Nothing [Nothing];
    0x0007 LoadConfig: Set, Exclusive { core: I16, count: U16 } [ConfigItem] -> Nothing [Nothing];
    0x0008 KeepAlive: Session, Any {} [Nothing] -> Nothing [Nothing];
    0x0009 Choose: Set, Immediate { profile: u8, family: u8 } [Nothing] -> VersionReply [Nothing];
    0x000A GetFault: Read Controller, Any {} [Nothing] -> FaultReply [Byte];
    0x000B GetEvents: Read Controller, Any {} [Nothing] -> EventsReply [EventItem];
    0x000C Abort: Set, Any { core: I16 } [Nothing] -> Nothing [Nothing];
    0x000D GetLinkLoss: Read Controller, Any {} [Nothing] -> LinkLossReply [Nothing];
    0x000E SetInterlock: Set, Any { motion: I16 } [Nothing] -> Nothing [Nothing];
    0x000F GetTickTime: Read Controller, Any {} [Nothing] -> TickTimeReply [ULong];
    // -- the program queue (SPEC 7) ----------------------------------------------------------
    0x0010 Sleep: Step, Program { ns: U64 } [Nothing] -> Nothing [Nothing];
    0x0011 WaitStop: Step, Program { core: I16, axes: I32, crds: I32 } [Nothing] -> Nothing [Nothing];
    0x0012 ProgramStart: Program, Immediate { strict: u8 } [Nothing] -> ProgramReply [Nothing];
    0x0013 ProgramClear: Program, Immediate {} [Nothing] -> ProgramReply [Nothing];
    0x0014 ProgramStatus: Program, Immediate {} [Nothing] -> ProgramReply [Nothing];
    0x0015 Trace: Session, Any { every: U32, axes: U64, lasers: u8, crds: u8, over_link: u8, edges: u8 } [Nothing] -> Nothing [Nothing];
    0x0016 ProgramEnd: Step, Program {} [Nothing] -> Nothing [Nothing];
    0x0019 GetStack: Read Controller, Any {} [Nothing] -> StackReply [Nothing];
    // -- axis --------------------------------------------------------------------------------
    0x0100 AxisOn: Set, Exclusive { core: I16, axis: I16 } [Nothing] -> Nothing [Nothing];
    0x0101 AxisOff: Set, Exclusive { core: I16, axis: I16 } [Nothing] -> Nothing [Nothing];
    0x0102 Stop: Set, Any { core: I16, mask: I32, option: I32, form: u8 } [Nothing] -> Nothing [Nothing];
    0x0103 ZeroPos: Set, Exclusive { core: I16, axis: I16, count: I16 } [Nothing] -> Nothing [Nothing];
    0x0104 SetPrfPos: Set, Exclusive { core: I16, profile: I16, pos: I32 } [Nothing] -> Nothing [Nothing];
    0x0105 SynchAxisPos: Set, Exclusive { core: I16, mask: I32 } [Nothing] -> Nothing [Nothing];
    0x0106 SetStopDec: Set, Exclusive { core: I16, profile: I16, smooth: F64, abrupt: F64 } [Nothing] -> Nothing [Nothing];
    0x0107 GetStopDec: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> StopDec [Nothing];
    0x0108 SetAxisBand: Set, Exclusive { core: I16, axis: I16, band: I32, time_cycles: I32 } [Nothing] -> Nothing [Nothing];
    0x0109 GetAxisBand: Read Axis, Any { core: I16, axis: I16 } [Nothing] -> Band [Nothing];
    0x010A GetSts: Read Axes, Any { core: I16, axis: I16, count: I16 } [Nothing] -> Longs [Long];
    0x010B GetPrfPos: Read Axes, Any { core: I16, profile: I16, count: I16 } [Nothing] -> Reals [Real];
    0x010C GetPrfVel: Read Axes, Any { core: I16, profile: I16, count: I16 } [Nothing] -> Reals [Real];
    0x010D GetPrfAcc: Read Axes, Any { core: I16, profile: I16, count: I16 } [Nothing] -> Reals [Real];
    0x010E GetPrfMode: Read Axes, Any { core: I16, profile: I16, count: I16 } [Nothing] -> Longs [Long];
    0x010F GetEncPos: Read Axes, Any { core: I16, encoder: I16, count: I16 } [Nothing] -> Reals [Real];
    0x0110 GetEncVel: Read Axes, Any { core: I16, encoder: I16, count: I16 } [Nothing] -> Reals [Real];
    0x0111 SetEncPos: Set, Exclusive { core: I16, encoder: I16, pos: I32 } [Nothing] -> Nothing [Nothing];
    0x0112 SetSoftLimit: Set, Exclusive { core: I16, axis: I16, positive: I32, negative: I32 } [Nothing] -> Nothing [Nothing];
    0x0113 GetSoftLimit: Read Axis, Any { core: I16, axis: I16 } [Nothing] -> SoftLimit [Nothing];
    0x0114 LmtsOn: Set, Exclusive { core: I16, axis: I16, limit_type: I16 } [Nothing] -> Nothing [Nothing];
    0x0115 LmtsOff: Set, Exclusive { core: I16, axis: I16, limit_type: I16 } [Nothing] -> Nothing [Nothing];
    0x0116 LmtSns: Set, Exclusive { core: I16, sense: U16 } [Nothing] -> Nothing [Nothing];
    0x0117 AlarmOn: Set, Exclusive { core: I16, axis: I16 } [Nothing] -> Nothing [Nothing];
    0x0118 AlarmOff: Set, Exclusive { core: I16, axis: I16 } [Nothing] -> Nothing [Nothing];
    0x0119 SetPosErr: Set, Exclusive { core: I16, control: I16, error: I32 } [Nothing] -> Nothing [Nothing];
    0x011A GetPosErr: Read Axis, Any { core: I16, control: I16 } [Nothing] -> Long [Nothing];
    0x011B SetCaptureMode: Set, Exclusive { core: I16, encoder: I16, mode: I16 } [Nothing] -> Nothing [Nothing];
    0x011C GetCaptureStatus: Read Axes, Any { core: I16, encoder: I16, count: I16 } [Nothing] -> Count [CaptureReply];
    0x011D AxisStatus: Read Axes, Any { core: I16, axis: I16, count: I16 } [Nothing] -> Reals [AxisItem];
    // -- trap and jog ------------------------------------------------------------------------
    0x0120 PrfTrap: Set, Exclusive { core: I16, profile: I16 } [Nothing] -> Nothing [Nothing];
    0x0121 SetTrapPrm: Set, Exclusive { core: I16, profile: I16, acc: F64, dec: F64, vel_start: F64, smooth_time_ms: I16 } [Nothing] -> Nothing [Nothing];
    0x0122 GetTrapPrm: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> TrapPrm [Nothing];
    0x0123 PrfJog: Set, Exclusive { core: I16, profile: I16 } [Nothing] -> Nothing [Nothing];
    0x0124 SetJogPrm: Set, Exclusive { core: I16, profile: I16, acc: F64, dec: F64, smooth: F64 } [Nothing] -> Nothing [Nothing];
    0x0125 GetJogPrm: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> JogPrm [Nothing];
    0x0126 SetPos: Set, Exclusive { core: I16, profile: I16, pos: I32 } [Nothing] -> Nothing [Nothing];
    0x0127 GetPos: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> Long [Nothing];
    0x0128 SetVel: Set, Exclusive { core: I16, profile: I16, vel: F64 } [Nothing] -> Nothing [Nothing];
    0x0129 GetVel: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> Real [Nothing];
    0x012A Update: Start, Exclusive { core: I16, mask: I32 } [Nothing] -> Nothing [Nothing];
    // -- digital and analog inputs and outputs -------------------------------------------------
    0x0140 GetDi: Read Other, Any { core: I16, di_type: I16 } [Nothing] -> Long [Nothing];
    0x0141 SetDo: Set, Exclusive { core: I16, do_type: I16, value: I32 } [Nothing] -> Nothing [Nothing];
    0x0142 GetDo: Read Other, Any { core: I16, do_type: I16 } [Nothing] -> Long [Nothing];
    0x0143 SetDoBit: Set, Exclusive { core: I16, do_type: I16, index: I16, value: I16 } [Nothing] -> Nothing [Nothing];
    0x0144 SetDac: Set, Exclusive { core: I16, dac: I16, count: U16 } [Short] -> Nothing [Nothing];
    0x0145 GetDac: Read Other, Any { core: I16, dac: I16, count: I16 } [Nothing] -> Count [Short];
    0x0146 GetAdc: Read Other, Any { core: I16, adc: I16, count: I16 } [Nothing] -> Reals [Real];
    0x0147 SimInput: Set, Any { core: I16, di_type: I16, index: I16, level: I16 } [Nothing] -> Nothing [Nothing];
    0x0148 SimAdc: Set, Any { core: I16, adc: I16, volts: F64 } [Nothing] -> Nothing [Nothing];
    0x0149 SimPlan: Set, Any { core: I16, row: U16, from: u8, at_ns: U64, di_type: I16, index: I16, value: F64 } [Nothing] -> Nothing [Nothing];
    0x014A GetWait: Read Axis, Any { core: I16, axis: I16 } [Nothing] -> WaitReply [Nothing];
    0x014B GetDiEx: Read Other, Any { core: I16, di_type: I16, count: I16 } [Nothing] -> Count [Long];
    0x014C SetDoEx: Set, Exclusive { core: I16, do_type: I16, count: U16 } [Long] -> Nothing [Nothing];
    0x014D GetDoEx: Read Other, Any { core: I16, do_type: I16, count: I16 } [Nothing] -> Count [Long];
    0x014E GetDiReverseCount: Read Other, Any { core: I16, di_type: I16, di_index: I16, count: I16 } [Nothing] -> Count [ULong];
    0x014F SetDiReverseCount: Set, Exclusive { core: I16, di_type: I16, di_index: I16, count: U16 } [ULong] -> Nothing [Nothing];
    0x0150 SetDoBitReverse: Set, Exclusive { core: I16, do_type: I16, do_index: I16, value: I16, reverse_time_cycles: I16 } [Nothing] -> Nothing [Nothing];
    // -- PT (GXN chapter 2) -------------------------------------------------------------------
    0x0200 PrfPt: Set, Exclusive { core: I16, profile: I16, mode: I16 } [Nothing] -> Nothing [Nothing];
    0x0201 PtSpace: Read Other, Any { core: I16, profile: I16, fifo: I16 } [Nothing] -> Short [Nothing];
    0x0202 PtData: Data Pt, Exclusive { core: I16, profile: I16, pos: F64, time_ms: I32, kind: I16, fifo: I16 } [Nothing] -> PtTaken [Nothing];
    0x0203 PtDataMany: Data Pt, Exclusive { core: I16, profile: I16, fifo: I16, count: U16 } [PtItem] -> PtTaken [Nothing];
    0x0204 PtClear: Set, Exclusive { core: I16, profile: I16, fifo: I16 } [Nothing] -> Nothing [Nothing];
    0x0205 SetPtLoop: Set, Exclusive { core: I16, profile: I16, loop_count: I32 } [Nothing] -> Nothing [Nothing];
    0x0206 GetPtLoop: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> Long [Nothing];
    0x0207 SetPtMemory: Set, Exclusive { core: I16, profile: I16, memory: I16 } [Nothing] -> Nothing [Nothing];
    0x0208 GetPtMemory: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> Short [Nothing];
    0x0209 PtStart: Start, Exclusive { core: I16, mask: I32, option: I32 } [Nothing] -> Nothing [Nothing];
    0x020A GetPtState: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> PtState [Nothing];
    // -- PVT (GXN chapter 4) -------------------------------------------------------------------
    0x0300 PrfPvt: Set, Exclusive { core: I16, profile: I16 } [Nothing] -> Nothing [Nothing];
    0x0301 SetPvtLoop: Set, Exclusive { core: I16, profile: I16, loop_count: I32 } [Nothing] -> Nothing [Nothing];
    0x0302 GetPvtLoop: Read Axis, Any { core: I16, profile: I16 } [Nothing] -> PvtLoops [Nothing];
    0x0303 PvtStatus: Read Axes, Any { core: I16, profile: I16, count: I16 } [Nothing] -> Count [PvtStatusItem];
    0x0304 PvtStart: Start, Exclusive { core: I16, mask: I32 } [Nothing] -> Nothing [Nothing];
    0x0305 PvtTableSelect: Set, Exclusive { core: I16, profile: I16, table: I16 } [Nothing] -> Nothing [Nothing];
    0x0306 PvtTable: Table Pvt, Exclusive { core: I16, table: I16, count: I32, first: U16 } [PvtPoint] -> Nothing [Nothing];
    0x0307 PvtTableEx: Table Pvt, Exclusive { core: I16, table: I16, count: I32, first: U16 } [PvtExPoint] -> Nothing [Nothing];
    0x0308 PvtTableComplete: Table Pvt, Exclusive { core: I16, table: I16, count: I32, first: U16, vel_begin: F64, vel_end: F64 } [PvtKnot] -> Nothing [Nothing];
    0x0309 PvtTablePercent: Table Pvt, Exclusive { core: I16, table: I16, count: I32, first: U16, vel_begin: F64 } [PvtPercentPoint] -> Nothing [Nothing];
    0x030A PvtPercentCalculate: Calculate, Any { core: I16, count: I32, first: U16, vel_begin: F64 } [PvtPercentPoint] -> Count [Real];
    0x030B PvtTableContinuous: Table Pvt, Exclusive { core: I16, table: I16, count: I32, first: U16, time_begin: F64 } [PvtContinuousPoint] -> Nothing [Nothing];
    0x030C PvtContinuousCalculate: Calculate, Any { core: I16, count: I32, first: U16 } [PvtContinuousPoint] -> Count [Real];
    // -- Follow (GXN chapter 3) ----------------------------------------------------------------
    0x0400 PrfFollow: Set, Exclusive { core: I16, profile: I16, dir: I16 } [Nothing] -> Nothing [Nothing];
    0x0401 SetFollowMaster: Set, Exclusive { core: I16, profile: I16, master_index: I16, master_type: I16, master_item: I16 } [Nothing] -> Nothing [Nothing];
    0x0402 GetFollowMaster: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> FollowMasterReply [Nothing];
    0x0403 SetFollowLoop: Set, Exclusive { core: I16, profile: I16, loop_count: I32 } [Nothing] -> Nothing [Nothing];
    0x0404 GetFollowLoop: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> Long [Nothing];
    0x0405 SetFollowEvent: Set, Exclusive { core: I16, profile: I16, event: I16, master_dir: I16, pos: I32 } [Nothing] -> Nothing [Nothing];
    0x0406 GetFollowEvent: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> FollowEventReply [Nothing];
    0x0407 FollowSpace: Read Other, Any { core: I16, profile: I16, fifo: I16 } [Nothing] -> Short [Nothing];
    0x0408 FollowData: Data Follow, Exclusive { core: I16, profile: I16, master_segment: I32, slave_segment: F64, kind: I16, fifo: I16 } [Nothing] -> FollowTaken [Nothing];
    0x0409 FollowClear: Set, Exclusive { core: I16, profile: I16, fifo: I16 } [Nothing] -> Nothing [Nothing];
    0x040A FollowStart: Start, Exclusive { core: I16, mask: I32, option: I32 } [Nothing] -> Nothing [Nothing];
    0x040B FollowSwitch: Set, Exclusive { core: I16, mask: I32 } [Nothing] -> Nothing [Nothing];
    0x040C SetFollowMemory: Set, Exclusive { core: I16, profile: I16, memory: I16 } [Nothing] -> Nothing [Nothing];
    0x040D GetFollowMemory: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> Short [Nothing];
    0x040E GetFollowStatus: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> FollowStatusReply [Nothing];
    // -- FollowEx (GXN chapter 3) --------------------------------------------------------------
    0x0500 PrfFollowEx: Set, Exclusive { core: I16, profile: I16, dir: I16 } [Nothing] -> Nothing [Nothing];
    0x0501 SetFollowMasterEx: Set, Exclusive { core: I16, profile: I16, master_index: I16, master_type: I16, master_item: I16 } [Nothing] -> Nothing [Nothing];
    0x0502 GetFollowMasterEx: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> FollowMasterReply [Nothing];
    0x0503 SetFollowLoopEx: Set, Exclusive { core: I16, profile: I16, loop_count: I32 } [Nothing] -> Nothing [Nothing];
    0x0504 GetFollowLoopEx: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> Long [Nothing];
    0x0505 SetFollowEventEx: Set, Exclusive { core: I16, profile: I16, event: I16, master_dir: I16, pos: I32 } [Nothing] -> Nothing [Nothing];
    0x0506 GetFollowEventEx: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> FollowEventReply [Nothing];
    0x0507 FollowSpaceEx: Read Other, Any { core: I16, profile: I16, fifo: I16 } [Nothing] -> Short [Nothing];
    0x0508 FollowDataPercentEx: Data Follow, Exclusive { core: I16, profile: I16, master_segment: F64, slave_segment: F64, kind: I16, percent: I16, fifo: I16 } [Nothing] -> FollowTaken [Nothing];
    0x0509 FollowClearEx: Set, Exclusive { core: I16, profile: I16, fifo: I16 } [Nothing] -> Nothing [Nothing];
    0x050A FollowStartEx: Start, Exclusive { core: I16, mask: I32, option: I32 } [Nothing] -> Nothing [Nothing];
    0x050B FollowSwitchEx: Set, Exclusive { core: I16, mask: I32 } [Nothing] -> Nothing [Nothing];
    0x050C SetFollowMemoryEx: Set, Exclusive { core: I16, profile: I16, memory: I16 } [Nothing] -> Nothing [Nothing];
    0x050D GetFollowMemoryEx: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> Short [Nothing];
    0x050E GetFollowStatusEx: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> FollowStatusReply [Nothing];
    0x050F FollowSwitchNowEx: Data Follow, Exclusive { core: I16, profile: I16, method: I16, buffer: I16, fifo: I16 } [Nothing] -> FollowTaken [Nothing];
    0x0510 FollowDoBitEx: Data Follow, Exclusive { core: I16, profile: I16, do_type: I16, index: I16, value: I16, fifo: I16 } [Nothing] -> FollowTaken [Nothing];
    0x0511 FollowDelayEx: Data Follow, Exclusive { core: I16, profile: I16, delay_cycles: U32, fifo: I16 } [Nothing] -> FollowTaken [Nothing];
    0x0512 FollowDiBitEx: Data Follow, Exclusive { core: I16, profile: I16, di_type: I16, index: I16, value: I16, time_ms: U32, fifo: I16 } [Nothing] -> FollowTaken [Nothing];
    0x0513 FollowDataPercent2Ex: Data Follow, Exclusive { core: I16, profile: I16, master_segment: F64, slave_segment: F64, vel_begin_ratio: F64, vel_end_ratio: F64, percent: I16, fifo: I16 } [Nothing] -> FollowPercent1 [Nothing];
    0x0514 GetFollowDataPercent2Ex: Read Other, Any { core: I16, master_pos: F64, vel_begin_ratio: F64, vel_end_ratio: F64, percent: F64, percent1: F64 } [Nothing] -> Real [Nothing];
    // -- laser (GUS chapter 2, LSR chapter 2) ----------------------------------------------------
    0x0600 LaserOn: Set, Exclusive { core: I16, channel: I16 } [Nothing] -> Nothing [Nothing];
    0x0601 LaserOff: Set, Any { core: I16, channel: I16 } [Nothing] -> Nothing [Nothing];
    0x0602 LaserPowerMode: Set, Exclusive { core: I16, mode: I16, max: F64, min: F64, channel: I16, delay_mode: I16 } [Nothing] -> LaserBounds [Nothing];
    0x0603 LaserPrfCmd: Set, Exclusive { core: I16, power: F64, channel: I16 } [Nothing] -> LaserValue [Nothing];
    0x0604 LaserOutFrq: Set, Exclusive { core: I16, frequency: F64, channel: I16 } [Nothing] -> LaserValue [Nothing];
    0x0605 SetPulseWidth: Set, Exclusive { core: I16, width_us: U32, channel: I16 } [Nothing] -> LaserValue [Nothing];
    0x0606 SetWaitPulse: Set, Exclusive { core: I16, mode: U16, frequency: F64, duty: F64, channel: I16 } [Nothing] -> LaserPulse [Nothing];
    0x0607 SetWaitPulseEx: Set, Exclusive { core: I16, mode: U16, frequency: F64, duty: F64 } [Nothing] -> LaserPulse [Nothing];
    0x0608 SetPreVltg: Set, Exclusive { core: I16, mode: U16, voltage: F64, channel: I16 } [Nothing] -> LaserValue [Nothing];
    0x0609 SetLevelDelay: Set, Exclusive { core: I16, off_delay_us: U32, on_delay_us: U32, channel: I16 } [Nothing] -> LaserDelays [Nothing];
    0x060A EnaFPK: Set, Exclusive { core: I16, time1_us: U32, time2_us: U32, laser_off_delay_us: U32, channel: I16 } [Nothing] -> LaserFpk [Nothing];
    0x060B DisFPK: Set, Exclusive { core: I16, channel: I16 } [Nothing] -> Nothing [Nothing];
    0x060C SetLaserMode: Set, Exclusive { core: I16, mode: I16 } [Nothing] -> Nothing [Nothing];
    0x060D ZeroLaserOnTime: Set, Exclusive { core: I16, channel: I16 } [Nothing] -> Nothing [Nothing];
    0x060E GetLaserOnTime: Read Laser, Any { core: I16, channel: I16 } [Nothing] -> ULong [Nothing];
    0x060F SetLaserCrdMap: Set, Exclusive { core: I16, channel: I16, map: I16 } [Nothing] -> Nothing [Nothing];
    0x0610 GetLaserCrdMap: Read Laser, Any { core: I16, channel: I16 } [Nothing] -> Short [Nothing];
    0x0611 SetAxisMode: Set, Exclusive { core: I16, axis: I16, mode: I16 } [Nothing] -> Nothing [Nothing];
    0x0612 GetLaserPower: Read Laser, Any { core: I16, channel: I16 } [Nothing] -> Real [Nothing];
    0x0613 ClrLaserFault: Set, Any { core: I16, channel: I16 } [Nothing] -> Nothing [Nothing];
    0x0614 GetLaserFault: Read Laser, Any { core: I16, channel: I16 } [Nothing] -> Short [Nothing];
    0x0615 LaserOnStatus: Read Laser, Any { core: I16, channel: I16 } [Nothing] -> Short [Nothing];
    0x0616 SetHSIOOpt: Set, ExclusiveUnlessZero { core: I16, value: U16, channel: I16 } [Nothing] -> Nothing [Nothing];
    0x0617 GetHSIOOpt: Read Laser, Any { core: I16, channel: I16 } [Nothing] -> Short [Nothing];
    0x061B LaserStatus: Read Laser, Any { core: I16, channel: I16 } [Nothing] -> LaserState [Nothing];
    // -- buffered laser (GUS chapter 4, LSR chapter 3) -------------------------------------------
    0x0700 BufLaserOn: Data Light, Exclusive { core: I16, crd: I16, fifo: I16, channel: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0701 BufLaserOff: Data Light, Exclusive { core: I16, crd: I16, fifo: I16, channel: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0702 BufLaserPrfCmd: Data Light, Exclusive { core: I16, crd: I16, power: F64, fifo: I16, channel: I16 } [Nothing] -> LaserValue [Nothing];
    0x0703 BufLaserPrfFollow: Data Light, Exclusive { core: I16, crd: I16, ratio: F64, min: I32, max: I32, fifo: I16, channel: I16 } [Nothing] -> LaserBounds [Nothing];
    0x0704 BufLaserFollowMode: Data Light, Exclusive { core: I16, crd: I16, source: I16, fifo: I16, channel: I16, start_power: F64, start_given: u8 } [Nothing] -> LaserValue [Nothing];
    0x0705 BufLaserFollowRatio: Data Light, Exclusive { core: I16, crd: I16, ratio: F64, min: F64, max: F64, fifo: I16, channel: I16 } [Nothing] -> LaserBounds [Nothing];
    0x0706 BufLaserFollowTable: Data Light, Exclusive { core: I16, crd: I16, table: I16, min: F64, max: F64, fifo: I16, channel: I16 } [Nothing] -> LaserBounds [Nothing];
    0x0707 BufLaserFollowOff: Data Light, Exclusive { core: I16, crd: I16, fifo: I16, channel: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0708 SetLaserFollowTable: Table Laser, Exclusive { core: I16, table: I16, count: I32, channel: I16, first: U16 } [LaserFollowPoint] -> LaserTableTaken [Nothing];
    // -- coordinate systems ----------------------------------------------------------------------
    0x0800 SetCrdPrm: Set, Exclusive { core: I16, crd: I16, dimension: I16, profile: [I16; 8], syn_vel_max: F64, syn_acc_max: F64, even_time_ms: I16, set_origin_flag: I16, origin_pos: [I32; 8] } [Nothing] -> Nothing [Nothing];
    0x0801 GetCrdPrm: Read Crd, Any { core: I16, crd: I16 } [Nothing] -> CrdPrm [Nothing];
    0x0802 CrdClear: Set, Exclusive { core: I16, crd: I16, fifo: I16 } [Nothing] -> Nothing [Nothing];
    0x0803 CrdSpace: Read Other, Any { core: I16, crd: I16, fifo: I16 } [Nothing] -> Long [Nothing];
    0x0804 CrdStart: Start, Exclusive { core: I16, mask: I16, option: I16 } [Nothing] -> Nothing [Nothing];
    0x0805 CrdStop: Set, Exclusive { core: I16, mask: I32, option: I32 } [Nothing] -> Nothing [Nothing];
    0x0806 CrdStatus: Read CrdFifo, Any { core: I16, crd: I16, fifo: I16 } [Nothing] -> CrdStatusReply [Nothing];
    0x0807 GetCrdPos: Read Crd, Any { core: I16, crd: I16 } [Nothing] -> Count [Real];
    0x0808 GetCrdVel: Read Crd, Any { core: I16, crd: I16 } [Nothing] -> Real [Nothing];
    0x0809 GetRemainderSegNum: Read Other, Any { core: I16, crd: I16, fifo: I16 } [Nothing] -> Long [Nothing];
    0x080A SetCrdStopDec: Set, Exclusive { core: I16, crd: I16, smooth: F64, abrupt: F64 } [Nothing] -> Nothing [Nothing];
    0x080B SetOverride: Set, Exclusive { core: I16, crd: I16, ratio: F64 } [Nothing] -> Nothing [Nothing];
    0x080C InitLookAhead: Set, Exclusive { core: I16, crd: I16, fifo: I16, time_ms: F64, acc_max: F64, count: I16 } [Nothing] -> Nothing [Nothing];
    0x080D CrdData: Data Path, Exclusive { core: I16, crd: I16, fifo: I16 } [CrdPoint] -> CrdTaken [Nothing];
    0x080E LnXY: Data Path, Exclusive { core: I16, crd: I16, x: I32, y: I32, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x080F LnXYZ: Data Path, Exclusive { core: I16, crd: I16, x: I32, y: I32, z: I32, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0810 LnXYZA: Data Path, Exclusive { core: I16, crd: I16, x: I32, y: I32, z: I32, a: I32, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0811 LnXYG0: Data Path, Exclusive { core: I16, crd: I16, x: I32, y: I32, syn_vel: F64, syn_acc: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0812 ArcXYR: Data Path, Exclusive { core: I16, crd: I16, x: I32, y: I32, radius: F64, circle_dir: I16, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0813 ArcXYC: Data Path, Exclusive { core: I16, crd: I16, x: I32, y: I32, x_center: F64, y_center: F64, circle_dir: I16, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0814 ArcYZR: Data Path, Exclusive { core: I16, crd: I16, y: I32, z: I32, radius: F64, circle_dir: I16, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0815 ArcYZC: Data Path, Exclusive { core: I16, crd: I16, y: I32, z: I32, y_center: F64, z_center: F64, circle_dir: I16, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0816 ArcZXR: Data Path, Exclusive { core: I16, crd: I16, z: I32, x: I32, radius: F64, circle_dir: I16, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0817 ArcZXC: Data Path, Exclusive { core: I16, crd: I16, z: I32, x: I32, z_center: F64, x_center: F64, circle_dir: I16, syn_vel: F64, syn_acc: F64, vel_end: F64, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0818 BufDelay: Data Path, Exclusive { core: I16, crd: I16, delay_ms: U16, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x0819 BufIO: Data Path, Exclusive { core: I16, crd: I16, do_type: U16, do_mask: U16, do_value: U16, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x081A BufDoBit: Data Path, Exclusive { core: I16, crd: I16, do_type: U16, index: U16, value: I16, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x081B BufDA: Data Path, Exclusive { core: I16, crd: I16, channel: I16, value: I16, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x081C BufMove: Data Path, Exclusive { core: I16, crd: I16, axis: I16, pos: I32, vel: F64, acc: F64, modal: I16, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x081D BufGear: Data Path, Exclusive { core: I16, crd: I16, axis: I16, pos: I32, fifo: I16 } [Nothing] -> CrdTaken [Nothing];
    0x081E SetCrdLimit: Set, Exclusive { core: I16, crd: I16, coordinate: I16, vel_max: F64, acc_max: F64 } [Nothing] -> Nothing [Nothing];
    0x081F GetCrdLimit: Read Other, Any { core: I16, crd: I16, coordinate: I16 } [Nothing] -> CrdLimit [Nothing];
    0x0820 LnXYMany: Data Lines, Exclusive { core: I16, crd: I16, fifo: I16, count: U16, syn_vel: F64, syn_acc: F64, vel_end: F64 } [PathXY] -> CrdTaken [Nothing];
    0x0821 LnXYZMany: Data Lines, Exclusive { core: I16, crd: I16, fifo: I16, count: U16, syn_vel: F64, syn_acc: F64, vel_end: F64 } [PathXYZ] -> CrdTaken [Nothing];
    0x0822 CrdInfo: Read Crd, Any { core: I16, crd: I16 } [Nothing] -> CrdState [Nothing];
    0x0823 SetLaserFollowFilter: Set, Exclusive { core: I16, crd: I16, time_ms: F64 } [Nothing] -> Nothing [Nothing];
    0x0824 GetLaserFollowFilter: Read Crd, Any { core: I16, crd: I16 } [Nothing] -> Real [Nothing];
    0x0825 PathMany: Data Joined, Exclusive { core: I16, crd: I16, fifo: I16, count: U16 } [Byte] -> CrdTaken [PathHeld];
    // -- distance follow (GUS chapter 5, LSR chapter 4) ------------------------------------------
    0x0900 SetLaserDisMode: Set, Exclusive { core: I16, mode: I16, source: I16, pos: [I32; 4], scale: [F64; 4], channel: I16 } [Nothing] -> LaserScales [Nothing];
    0x0901 SetLaserDisRatio: Set, Exclusive { core: I16, ratio: [F64; 4], min: F64, max: F64, channel: I16, bounds_given: u8 } [Nothing] -> LaserBounds [Nothing];
    0x0902 SetLaserDisTable1D: Table Laser, Exclusive { core: I16, count: I16, min: F64, max: F64, limit: [F64; 4], channel: I16, limits_given: u8, first: U16 } [LaserDisPoint] -> LaserBounds [Nothing];
    0x0903 SetLaserDisTable2D: Table Laser, Exclusive { core: I16, axis: [I16; 2], count: [I16; 2], min: F64, max: F64, limit: [F64; 2], channel: I16, limits_given: u8, first: U16 } [LaserDisValue] -> LaserBounds [Nothing];
    // -- Gear ------------------------------------------------------------------------------------
    0x0A00 PrfGear: Set, Exclusive { core: I16, profile: I16, dir: I16 } [Nothing] -> Nothing [Nothing];
    0x0A01 SetGearMaster: Set, Exclusive { core: I16, profile: I16, master_index: I16, master_type: I16, master_item: I16 } [Nothing] -> Nothing [Nothing];
    0x0A02 GetGearMaster: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> FollowMasterReply [Nothing];
    0x0A03 SetGearRatio: Set, Exclusive { core: I16, profile: I16, master_even: I32, slave_even: I32, master_slope: I32 } [Nothing] -> Nothing [Nothing];
    0x0A04 GetGearRatio: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> GearRatioReply [Nothing];
    0x0A05 GearStart: Start, Exclusive { core: I16, mask: I32 } [Nothing] -> Nothing [Nothing];
    0x0A06 SetGearEvent: Set, Exclusive { core: I16, profile: I16, event: I16, start_para0: I32, start_para1: I32 } [Nothing] -> Nothing [Nothing];
    0x0A07 GetGearEvent: Read Follow, Any { core: I16, profile: I16 } [Nothing] -> GearEventReply [Nothing];
}

/// Bytes of a field, by its type as [`Wire::FIELDS`] prints it.
pub fn width(of: &str) -> usize {
    let array = of.strip_prefix('[').and_then(|of| of.strip_suffix(']')).and_then(|of| of.split_once("; "));
    match (array, of) {
        (Some((of, count)), _) => width(of).saturating_mul(count.parse::<usize>().unwrap_or(0)),
        (None, "F64" | "U64") => 8,
        (None, "I32" | "U32") => 4,
        (None, "I16" | "U16") => 2,
        _ => 1,
    }
}

/// Bytes of several fields.
pub fn widths(fields: &[(&str, &str)]) -> usize {
    fields.iter().map(|(_, of)| width(of)).fold(0, usize::saturating_add)
}

/// The row of the table with this number.
pub fn info(opcode: u16) -> Option<&'static CommandInfo> {
    let row = COMMANDS.binary_search_by_key(&opcode, |command| command.opcode).ok()?;
    COMMANDS.get(row)
}

const _: () = {
    let mut row = 1;
    while row < COMMANDS.len() {
        assert!(COMMANDS[row - 1].opcode < COMMANDS[row].opcode, "commands stand in the order of their numbers");
        row += 1;
    }
};
