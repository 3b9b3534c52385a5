//! Layouts that several commands share: replies, and the items that follow requests and replies.
use crate::layout::Wire;
use zerocopy::little_endian::{F64, I16, I32, U16, U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

wire_structs! {
    /// No fields.
    Nothing {}
    /// The number of items that follow or that were done.
    Count { count: U16 }
    /// One 16-bit value.
    Short { value: I16 }
    /// One 32-bit value.
    Long { value: I32 }
    /// One real value.
    Real { value: F64 }
    /// Real values of consecutive axes, read in one tick at `clock_ms`.
    Reals { clock_ms: U32, count: U16 }
    /// 32-bit values of consecutive axes, read in one tick at `clock_ms`.
    Longs { clock_ms: U32, count: U16 }
    /// Trap parameters (TTrapPrm).
    TrapPrm { acc: F64, dec: F64, vel_start: F64, smooth_time_ms: I16 }
    /// Jog parameters (TJogPrm).
    JogPrm { acc: F64, dec: F64, smooth: F64 }
    /// Smooth and abrupt stop deceleration, pulse/ms².
    StopDec { smooth: F64, abrupt: F64 }
    /// Band in pulses, time in 250 µs cycles.
    Band { band: I32, time_cycles: I32 }
    /// Soft limits in pulses; 0x7fffffff and -0x80000000 are off.
    SoftLimit { positive: I32, negative: I32 }
    /// One PT segment: end position and end time from the start of the pass.
    PtItem { pos: F64, time_ms: I32, kind: u8 }
    /// After PT data: how many segments were taken, free slots, and how long the data in the stream
    /// lasts (ms; for a FIFO at standstill, the length of its data).
    PtTaken { taken: U16, space: U16, dry_ms: U32 }
    /// PT state: 0 never ran, 1 running, 2 ended, 3 ended by underrun, 4 ended by Stop or a fault.
    PtState { state: u8, loops: I32, space0: U16, space1: U16, dry_ms: U32 }
    /// A point of PvtTable: ms, pulse, pulse/ms.
    PvtPoint { time: F64, pos: F64, vel: F64 }
    /// A point of PvtTableEx, with the velocities at the start and at the end of the segment that
    /// follows.
    PvtExPoint { time: F64, pos: F64, vel_begin: F64, vel_end: F64 }
    /// A point of PvtTableComplete.
    PvtKnot { time: F64, pos: F64 }
    /// A point of PvtTablePercent.
    PvtPercentPoint { time: F64, pos: F64, percent: F64 }
    /// A point of PvtTableContinuous: pulse, pulse/ms, pulse/ms².
    PvtContinuousPoint { pos: F64, vel: F64, percent: F64, vel_max: F64, acc: F64, dec: F64 }
    /// PVT passes completed, and passes to run (0: endless).
    PvtLoops { loop_count: I32, loop_set: I32 }
    /// Present PVT table and time in it, ms.
    PvtStatusItem { table: I16, time: F64 }
    /// Master of a Follow axis: number, type and item as given to SetFollowMaster.
    FollowMasterReply { master_index: I16, master_type: I16, master_item: I16 }
    /// Start condition of a Follow axis, as given to SetFollowEvent.
    FollowEventReply { event: I16, master_dir: I16, pos: I32 }
    /// Ratio of an axis in Gear, as given to SetGearRatio; zeros before.
    GearRatioReply { master_even: I32, slave_even: I32, master_slope: I32 }
    /// Start condition of an axis in Gear, as given to SetGearEvent.
    GearEventReply { event: I16, start_para0: I32, start_para1: I32 }
    /// After a Follow entry: free slots of its FIFO.
    FollowTaken { space: U16 }
    /// After FollowDataPercent2Ex: free slots, and the share of the first half of the S-curve in
    /// percent.
    FollowPercent1 { space: U16, percent1: I16 }
    /// Present FIFO (0 or 1), and whether a switch waits for the end of the pass (0 no, 1 yes).
    FollowStatusReply { fifo: I16, switch_status: I16 }
    /// One axis of a configuration file. `given` states which fields the file named (bit 0 limits,
    /// 1 limit sense, 2 alarm, 3 alarm sense, 4 soft limits, 5 stop decelerations, 6 following
    /// error, 7 band, 8 home sense).
    ConfigItem {
        axis: I16, given: U16, limits_on: u8, limit_sense: u8, alarm_on: u8, alarm_sense: u8,
        soft_positive: I32, soft_negative: I32, dec_smooth: F64, dec_abrupt: F64, pos_err: I32,
        band: I32, band_time_cycles: I32, home_sense: u8,
    }
    /// What a controller is; step_limit is the limit of its step outputs, pulse/ms (2^32 is full
    /// scale: none).
    VersionReply {
        major: U16, minor: U16, patch: U16, schema: U32, board: [u8; 16], profile: u8, family: u8,
        cores: u8, axes_per_core: u8, lasers: u8, crds_per_core: u8, general_inputs: u8, general_outputs: u8, tick_us: U32, step_limit: F64,
    }
    /// Controller time: ms and servo ticks since power-on.
    Clock { clock_ms: U32, ticks: U32 }
    /// The program queue: entries accepted, executed and waiting, free bytes, late entries, state
    /// (0 empty, 1 held, 2 running, 3 stopped by a failure, 4 stopped by Stop or link loss), and
    /// the script clock in ns. Since the program's start: servo ticks that took too long. If bit 0
    /// of `reported` is set, the tag of the first late record; if bit 1 is set, the tag of the last
    /// record executed when a tick first took too long. Bit 2: a laser command that changes light
    /// was late. Bits 4 and 5: laser channels 0 and 1 went dark because a tick took too long, or
    /// another fault took their light or kept it from coming.
    ProgramReply {
        accepted: U32, executed: U32, space_bytes: U32, late: U32, worst_late_us: U32, state: u8,
        clock_ns: U64, overruns: U32, late_tag: U16, overran_tag: U16, reported: u8,
    }
    /// What ended the run before this one: 0 nothing but power-off or an external reset, 1 a panic,
    /// 2 a fault of the core, 3 an interrupt that nobody claims, 4 the watchdog. Then how many
    /// bytes of text follow (UTF-8).
    FaultReply { kind: u8, length: U16 }
    /// Events since power-on, and how many of the last ones follow.
    EventsReply { total: U32, count: U16 }
    /// An event that no command caused: its time and kind, the object, and the reason. Axes and
    /// coordinate systems count over all cores from 1, lasers from 0. Kinds:
    ///
    /// * 1 an axis came to standstill
    /// * 2 a coordinate system did
    /// * 3 a laser went dark or was cleared
    /// * 4 the link was lost or came back
    /// * 5 servo ticks took too long
    /// * 6 events were lost
    /// * 7 an admitted laser command did nothing
    /// * 8 an abort or a new session shut off the lasers
    /// * 9 a pulse width was limited (how often)
    EventItem { time_ns: U64, kind: u8, of: u8, reason: U16 }
    /// The servo tick's period. If the board measures it (`measured` 1), also how long its ticks
    /// take, in ns, from the timer's event to the end of the handler. There is the running median,
    /// the longest since the start, and that since this was asked before, by anybody. The items
    /// are a histogram: the first one counts the ticks below `bucket_ns`, the next one those below
    /// twice that, the last one all that were longer. They wrap.
    TickTimeReply {
        period_ns: U32, median_ns: U32, worst_ns: U32, recent_ns: U32, measured: u8, bucket_ns: U32, count: U16,
    }
    /// The stack of thread and interrupts in bytes. If the board measures it (`measured` 1), also
    /// how many of them were never used since the start.
    StackReply { size: U32, unused: U32, measured: u8 }
    /// Link-loss time in ms (0: the link is not supervised), and whether PT, PVT and Follow stop
    /// too.
    LinkLossReply { time_ms: F64, stop_all: I16 }
    /// Home or index capture.
    CaptureReply { status: I16, value: I32, clock_ms: U32 }
    /// What an axis in FollowEx waits for: 0 nothing, 1 an input, 2 the master's crossing of a
    /// position (PASS). For an input its type, its number on the core, the level that ends the
    /// wait, and whether a time limit ends it too.
    WaitReply { kind: u8, di_type: I16, index: I16, level: I16, limited: u8 }
    /// Raw bytes.
    Byte { value: u8 }
    /// One 32-bit value without a sign.
    ULong { value: U32 }
    /// What a laser command took. Bit k of `held`: field k was outside its range and was taken as
    /// the nearest bound (LSR). Bit 7: the pulse width reaches the period and is limited to just
    /// under it.
    LaserValue { value: F64, held: u8 }
    /// Bounds of the laser's power that were taken, in the mode's unit; `held` as in LaserValue.
    LaserBounds { max: F64, min: F64, held: u8 }
    /// Standby pulses that were taken, kHz and %; `held` as in LaserValue.
    LaserPulse { frequency: F64, duty: F64, held: u8 }
    /// Gate delays that were taken; `held` as in LaserValue.
    LaserDelays { off_delay_us: U32, on_delay_us: U32, held: u8 }
    /// FPK times that were taken; `held` as in LaserValue.
    LaserFpk { time1_us: U32, time2_us: U32, laser_off_delay_us: U32, held: u8 }
    /// One laser channel in one tick: power mode (0 duty, 1 frequency, 2 analog, 3 duty with the
    /// switch held), on command, switch output, light. `held` 1: the pulse width is limited to just
    /// under the period. Then the cause of the latched fault (GetLaserFault), power in the mode's
    /// unit and carrier or pulse rate in kHz as they are output now, light in 250 µs units.
    LaserState {
        mode: I16, commanded: u8, gate: u8, light: u8, held: u8, fault: I16, power: F64, frequency: F64,
        on_time: U32,
    }
    /// Parameters of a coordinate system (TCrdPrm): profile k is the coordinate (1 X, 2 Y, 3 Z, 4
    /// A, 0 none) that axis k of the core drives.
    CrdPrm {
        dimension: I16, profile: [I16; 8], syn_vel_max: F64, syn_acc_max: F64, even_time_ms: I16,
        set_origin_flag: I16, origin_pos: [I32; 8],
    }
    /// After data of a path: how many entries were taken, free slots, and how long the motions in
    /// the FIFO last (ms, without override).
    CrdTaken { taken: U16, space: U16, lasts_ms: U32 }
    /// Whether a coordinate system runs, and the path segments of a FIFO completed since it was
    /// cleared.
    CrdStatusReply { run: I16, segment: I32 }
    /// One coordinate system in one tick: whether it runs; its present FIFO. How it came to
    /// standstill last: 0 never moved, 1 its entries ran out, 2 they ran out at speed, 3 stopped, 4
    /// before a position that an axis must not reach (it can go on). The reason of its axes' stop
    /// (AxisItem). The axis of each coordinate, 0 none; coordinates in pulses, speed in pulse/ms.
    /// For each FIFO segments completed, segments left, free slots, and ms that its motions last.
    CrdState {
        run: u8, fifo: u8, path_stop: u8, reason: U16, axes: [I16; 4], pos: [F64; 4], vel: F64, segments: [I32; 2],
        remainder: [I32; 2], space: [I32; 2], lasts_ms: [U32; 2],
    }
    /// Before each call in PathMany: its number, and the bytes of its request, which follow.
    PathCall { opcode: U16, length: U16 }
    /// What a call in PathMany did not take as it was given: which call, from 0; the values and
    /// `held` of its own reply (the second value is 0 where that has one).
    PathHeld { call: U16, first: F64, second: F64, held: u8 }
    /// Limits of one coordinate for look-ahead, pulse/ms and pulse/ms².
    CrdLimit { vel_max: F64, acc_max: F64 }
    /// One target of LnXYMany.
    PathXY { x: I32, y: I32 }
    /// One target of LnXYZMany.
    PathXYZ { x: I32, y: I32, z: I32 }
    /// One motion as TCrdData gives it: type 0 line, 1 arc; plane 0 XY, 1 YZ, 2 ZX. An arc has a
    /// centre relative to its start, or, if that is 0, a radius.
    CrdPoint {
        motion_type: I16, plane: I16, pos: [I32; 4], radius: F64, dir: I16, center: [F64; 2], vel: F64, acc: F64,
        vel_end: F64, vel_end_zero: I16,
    }
    /// Scales of SetLaserDisMode that were taken, pulses per unit of distance; bit k of `held`:
    /// that of axis k + 1 was limited.
    LaserScales { scale: [F64; 4], held: u8 }
    /// A point of SetLaserFollowTable: path speed in pulse/ms, power in the mode's unit.
    LaserFollowPoint { vel: F64, power: F64 }
    /// What a chunk of a follow table took: how many of its powers were limited to a bound (LSR).
    LaserTableTaken { held: U16 }
    /// A point of SetLaserDisTable1D: a ratio, and the position in pulses where it holds. Points of
    /// axis 1 come first, `count` of them, then those of axes 2, 3 and 4.
    LaserDisPoint { ratio: F64, pos: I32 }
    /// A value of SetLaserDisTable2D: the positions of X, those of Y (pulses, `count` of each),
    /// then the ratios row by row: all of X at the first Y, and so on.
    LaserDisValue { value: F64 }
    /// One axis of an `AxisStatus` reply: what a display needs, of one tick.
    AxisItem {
        status: U32, mode: I16, reason: U16, prf_pos: F64, prf_vel: F64, enc_pos: F64,
    }
}
