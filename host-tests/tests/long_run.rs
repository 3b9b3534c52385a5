//! Mixed work for as long as asked: nothing drifts, no counter overflows, nothing grows.
//!
//! `LONG_RUN_TICKS` says how far it goes (`cargo xtask long-run`); a plain test run goes four rounds. A round is
//! 250 000 ticks of 250 µs. Meanwhile run: a static PT loop and a PVT loop whose displacements are no binary fractions, a
//! Jog, an axis that follows, a stream of dynamic PT, Trap moves there and back, and a square with a laser in velocity
//! follow, in turn with and without look-ahead; the other laser shines all the time, its power by distance follow.
//! Checkpoints are whole passes apart, so what an axis has gone since the first one is known in exact rationals.
use client::{Call, Client, Options, Quiet};
use job::{Action, Files};
use num_rational::BigRational;
use std::time::{Duration, Instant};
use virtual_board::{Board, Config, Shared, VirtualLink, share};

const TICK_US: u64 = 250;
/// 62.5 s: 125 passes of PT, 200 of PVT.
const ROUND_TICKS: u64 = 250_000;
const ROUND: Duration = Duration::from_micros(ROUND_TICKS * TICK_US);
const PT_PASS: f64 = 400.1;
const PVT_PASS: f64 = 12.7;
const JOG: f64 = 0.7;
const STREAM: f64 = 12.25;

/// What runs for ever.
const SETUP: &str = "
    GT_Reset(); GT_LoadConfig(\"none.toml\"); GT_ClrSts(1, 8);
    GT_AxisOn(1); GT_AxisOn(2); GT_AxisOn(3); GT_AxisOn(4); GT_AxisOn(5); GT_AxisOn(6); GT_AxisOn(7); GT_AxisOn(8);
    GT_PrfPt(1); GT_SetPtLoop(1, 0);
    GT_PtData(1, 100, 120); GT_PtData(1, 300.3, 333, PT_SEGMENT_EVEN); GT_PtData(1, 400.1, 500, PT_SEGMENT_STOP);
    double t[4] = {0, 62.5, 200.25, 312.5}; double p[4] = {0, 3.3, -1.7, 12.7}; double v[4] = {0, 0.07, -0.1, 0};
    GT_PrfPvt(2); GT_PvtTable(1, 4, t, p, v); GT_PvtTableSelect(2, 1); GT_SetPvtLoop(2, 0);
    TJogPrm jog; GT_PrfJog(3); jog.smooth = 0; jog.acc = 1; jog.dec = 1; GT_SetJogPrm(3, &jog); GT_SetVel(3, 0.7);
    GT_PrfFollow(4); GT_SetFollowMaster(4, 1); GT_SetFollowLoop(4, 0); GT_FollowData(4, 100, 37.5, FOLLOW_SEGMENT_EVEN);
    GT_FollowStart(8);
    GT_PtStart(1); GT_PvtStart(2); GT_Update(4);
    GT_PrfPt(8, PT_MODE_DYNAMIC); GT_SetPtMemory(8, 1);
    TTrapPrm trap; trap.velStart = 0; GT_PrfTrap(7); trap.acc = 0.5; trap.dec = 0.25; trap.smoothTime = 20; GT_SetTrapPrm(7, &trap); GT_SetVel(7, 13);
    TCrdPrm crd = {2, {0,0,0,0,0,0,0,0}, 10, 1, 0, 0, {0,0,0,0,0,0,0,0}}; crd.profile[4] = 1; crd.profile[5] = 2; crd.synVelMax = 100; crd.synAccMax = 10;
    crd.setOriginFlag = 1; GT_SetCrdPrm(1, &crd);
    GT_SetLaserCrdMap(0, 1); GT_SetLaserCrdMap(1, 0); GT_SetAxisMode(7, 1); GT_SetAxisMode(8, 1);
    GT_LaserPowerMode(0, 90, 1, 0); GT_LaserOutFrq(50, 0); GT_SetLevelDelay(40, 25, 0);
    GT_LaserPowerMode(1, 1000, 0, 1); GT_SetPulseWidth(1, 1); GT_LaserPrfCmd(100, 1);
    long ref[4] = {0, 0, 0, 0}; double scale[4] = {100000, 100000, 100000, 100000}; double ratio[4] = {0.001, 0.002, 0.001, 0.003};
    GT_SetLaserDisMode(1, 0, ref, scale, 1); GT_SetLaserDisRatio(ratio, 0, 900, 1);
    GT_SetHSIOOpt(1, 1);
";

struct Switches;

impl Files for Switches {
    fn text(&self, _: &str) -> Result<String, String> {
        Ok("[axis.1-8]\nlimits = \"none\"\nalarm = false\n".to_owned())
    }
}

fn calls(text: &str) -> Vec<Call> {
    let job = job::compile(text, &Switches).unwrap_or_else(|found| panic!("{found:?}"));
    let call = |action: &Action| match action {
        Action::Call(call) => Call { opcode: call.opcode, payload: call.body.clone(), may_fail: false },
        Action::WaitStop { core, axes, crds } => Call::of(protocol::command::WaitStop {
            core: (*core).into(),
            axes: axes.cast_signed().into(),
            crds: crds.cast_signed().into(),
        }),
        other => panic!("{other:?}"),
    };
    job.steps.iter().map(|step| call(&step.action)).collect()
}

/// The work of one round, which takes less than a round.
fn round(number: u64) -> String {
    let mut text = String::new();
    text += &format!("GT_InitLookAhead(1, 0, {}, 10, {});\n", number % 3, 40 * (number & 1));
    // The motion comes first: what is no motion would wait for the tick to tell where the path rests.
    text += "GT_CrdClear(1, 0); GT_LnXY(1, 1, 0, 1, 0.1, 0, 0); GT_BufLaserFollowRatio(1, 20, 1, 90, 0, 0);\n";
    for (side, (x, y)) in [(100, 0), (100, 100), (0, 100), (0, 0)].repeat(60).into_iter().enumerate() {
        text +=
            if side % 2 == 0 { "GT_BufLaserOn(1, 0, 0);" } else { "GT_BufLaserOff(1, 0, 0); GT_BufDelay(1, 3, 0);" };
        text += &format!("GT_LnXY(1, {x}, {y}, 1, 0.1, 0.5, 0);\n");
    }
    text += "GT_BufLaserFollowOff(1, 0, 0); GT_CrdData(1, NULL, 0); GT_CrdStart(1, 0);\n";
    for segment in 1..=200 {
        let (pos, kind) = (STREAM / 200.0 * f64::from(segment), if segment == 200 { 2 } else { segment % 2 });
        text += &format!("GT_PtData(8, {pos:?}, {}, {kind});\n", segment * 250);
    }
    text += "GT_PtStart(128);\n";
    for pos in [5000, -3000, 0] {
        text += &format!("GT_SetPos(7, {pos}); GT_Update(64); WaitStop(64);\n");
    }
    text + "WaitStop(192 | 256);\n"
}

/// What is compared from checkpoint to checkpoint.
#[derive(Debug, Clone, PartialEq)]
struct Seen {
    ticks: u64,
    pos: [i64; 8],
    on_time: [u32; 2],
    fault: [servo::laser::Cause; 2],
    /// Bytes that the process has of memory, if the system tells.
    memory: Option<u64>,
}

fn seen(board: &Shared) -> Seen {
    let mut board = board.lock().unwrap();
    // Edges are kept for who asks for them.
    board.take_edges();
    Seen {
        ticks: board.now() / (TICK_US * 1000),
        pos: std::array::from_fn(|axis| board.axis(axis).pos.0),
        on_time: std::array::from_fn(|channel| board.laser_view(channel).on_time),
        fault: std::array::from_fn(|channel| board.laser_view(channel).fault),
        memory: std::fs::read_to_string("/proc/self/statm")
            .ok()
            .and_then(|text| text.split(' ').nth(1)?.parse::<u64>().ok())
            .map(|pages| pages * 4096),
    }
}

/// How far from `rounds` times `way`, in 2⁻²² pulse, rounded away from zero.
fn off(gone: i64, rounds: u64, way: f64) -> i64 {
    let exact = BigRational::from_float(way).unwrap() * BigRational::from_integer(rounds.into());
    let off = BigRational::from_integer(gone.into()) - exact * BigRational::from_integer((1i64 << 22).into());
    let off = if off < BigRational::from_integer(0.into()) { off.floor() } else { off.ceil() };
    i64::try_from(off.to_integer()).unwrap()
}

#[test]
fn nothing_drifts_overflows_or_grows() {
    let ticks: u64 = std::env::var("LONG_RUN_TICKS").ok().map_or(4 * ROUND_TICKS, |text| text.parse().unwrap());
    let rounds = ticks.div_ceil(ROUND_TICKS).max(3);
    let board = share(Board::new(Config { tick_us: TICK_US as u32, profile: 0 }));
    let client = Client::open(Box::new(VirtualLink::new(board.clone())), Options::default()).unwrap();
    let run = |text: &str| {
        let summary = client.run(calls(text), true, &mut Quiet).unwrap();
        assert_eq!(summary.failed, None);
    };
    run(SETUP);
    client.sleep(Duration::from_millis(100)).unwrap();
    let (began, start) = (Instant::now(), client.now());
    let first = seen(&board);
    let mut settled = None;
    let mut told = Instant::now();
    for number in 0..rounds {
        run(&round(number));
        let end = start + ROUND * (number as u32 + 1);
        client.sleep(end.checked_sub(client.now()).expect("a round's work is over before the round")).unwrap();
        let now = seen(&board);
        let done = number + 1;
        assert_eq!(now.ticks - first.ticks, done * ROUND_TICKS, "every checkpoint is on its tick");
        let gone: [i64; 8] = std::array::from_fn(|axis| now.pos[axis] - first.pos[axis]);
        // A knot is rounded to 2⁻²² pulse, once here and once at the first checkpoint; nothing is added from pass to pass.
        assert!(off(gone[0], done * 125, PT_PASS).abs() <= 2, "PT after {done} rounds: {now:?}");
        assert!(off(gone[1], done * 200, PVT_PASS).abs() <= 2, "PVT after {done} rounds: {now:?}");
        // Speeds of a Jog have 2⁻⁶⁴ and better; a bound that a drift of 10⁻¹² of the way would break.
        let jog = off(gone[2], done * 62_500, JOG);
        assert!(jog.abs() <= 2 + (done as i64 >> 6), "Jog after {done} rounds is {jog} off: {now:?}");
        assert!((gone[3] - gone[0] * 3 / 8).abs() <= 4, "Follow after {done} rounds: {now:?}");
        assert_eq!(now.pos[4..7], [0, 0, 0], "the square and the Trap moves are closed");
        assert_eq!(off(gone[7], done, STREAM), 0, "the stream after {done} rounds");
        assert_eq!(u64::from(now.on_time[1].wrapping_sub(first.on_time[1])), done * ROUND_TICKS, "on-time");
        assert!(now.on_time[0] > 0 && now.fault == [servo::laser::Cause::None; 2], "{now:?}");
        if done == 2 {
            settled = now.memory;
        }
        if let (Some(settled), Some(memory)) = (settled, now.memory) {
            assert!(memory <= settled + (2 << 20), "memory grew from {settled} to {memory} in {done} rounds");
        }
        if told.elapsed() > Duration::from_secs(20) || done == rounds {
            told = Instant::now();
            let (ticks, seconds) = (done * ROUND_TICKS, began.elapsed().as_secs_f64());
            println!("{ticks} ticks in {seconds:.0} s, Jog {jog} off, memory {:?}", now.memory);
        }
    }
}
