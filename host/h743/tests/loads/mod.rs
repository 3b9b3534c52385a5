//! What runs on the emulated board while its ticks are counted: the loads of SPEC 11.
use client::{Client, Options};
use h743::link::{EmulatedLink, Shared, lock};
use h743::machine::Chip;
use h743::{MICROSECOND, MILLISECOND, Machine, Pin, Time};
use protocol::command::{
    AxisOn, BufLaserFollowRatio, BufLaserOn, CrdClear, CrdStart, GetCrdPos, LaserOutFrq, LaserPrfCmd, LaserStatus,
    LnXY, PrfPvt, PvtPoint, PvtStart, PvtTable, PvtTableSelect, SetAxisMode, SetCrdPrm, SetHSIOOpt, SetPvtLoop,
    SetTick,
};
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// The interrupt of TIM2, as an exception.
pub const TICK: usize = 16 + 28;
/// Lines of a path.
const LINES: i32 = 150;

/// What runs.
pub struct Load {
    pub name: &'static str,
    /// Ticks in µs under which it is counted, with SPEC 11's figure.
    pub ticks: &'static [(i32, Option<u64>)],
    /// Axes in PVT.
    pub axes: Range<i16>,
    pub carriers: bool,
    /// Two coordinate systems, of the axes 1 to 4; the lasers follow them.
    pub paths: bool,
}

/// Those of the table.
pub static LOADS: [Load; 6] = [
    Load {
        name: "idle, eight axes enabled",
        ticks: &[(10, Some(1_400)), (250, Some(1_400))],
        axes: 1..1,
        carriers: false,
        paths: false,
    },
    Load {
        name: "two steady carriers of 2 MHz",
        ticks: &[(10, Some(1_900)), (50, Some(1_900)), (250, Some(1_900))],
        axes: 1..1,
        carriers: true,
        paths: false,
    },
    Load {
        name: "eight axes in PVT at up to 1 MHz, which enter segments",
        ticks: &[(20, Some(4_800)), (250, None)],
        axes: 1..9,
        carriers: false,
        paths: false,
    },
    Load {
        name: "the same with two steady carriers of 2 MHz",
        ticks: &[(20, Some(5_300))],
        axes: 1..9,
        carriers: true,
        paths: false,
    },
    Load {
        name: "four axes in PVT, two coordinate systems of two axes, two lasers of 2 MHz that follow",
        ticks: &[(20, Some(6_500)), (50, Some(8_000)), (250, Some(20_000))],
        axes: 5..9,
        carriers: true,
        paths: true,
    },
    Load {
        name: "two carriers of 2 MHz, four axes in PVT",
        ticks: &[(10, Some(3_400)), (20, None)],
        axes: 1..5,
        carriers: true,
        paths: false,
    },
];

/// A board under a load.
pub struct Loaded {
    pub shared: Shared,
    pub client: Client,
}

/// The board with its interlock's circuit closed; `watched`, its accesses to data are.
fn board(elf: &[u8], watched: bool) -> Shared {
    let mut machine = Machine::new().unwrap();
    if watched {
        machine.watch().unwrap();
    }
    machine.boot(elf).unwrap();
    for pin in ["PE15", "PE3", "PG2"] {
        machine.drive(Pin::named(pin).unwrap(), Some(false));
    }
    machine.run(20 * MILLISECOND);
    Arc::new(Mutex::new(machine))
}

/// To and fro between 0 and 8000 pulses, at 1000 pulse/ms at most; all axes enter a segment at the
/// same time.
fn run_axes(client: &Client, axes: Range<i16>) {
    let (core, table) = (1.into(), 1.into());
    let points: Vec<PvtPoint> = [
        (0.0, 0.0, 0.0),
        (4.0, 2000.0, 1000.0),
        (8.0, 6000.0, 1000.0),
        (12.0, 8000.0, 0.0),
        (16.0, 6000.0, -1000.0),
        (20.0, 2000.0, -1000.0),
        (24.0, 0.0, 0.0),
    ]
    .map(|(time, pos, vel): (f64, f64, f64)| PvtPoint { time: time.into(), pos: pos.into(), vel: vel.into() })
    .to_vec();
    let count = (points.len() as i32).into();
    client.call_items(PvtTable { core, table, count, first: 0.into() }, &points).unwrap();
    for axis in axes.clone() {
        let profile = axis.into();
        client.call(PrfPvt { core, profile }).unwrap();
        client.call(SetPvtLoop { core, profile, loop_count: 0.into() }).unwrap();
        client.call(PvtTableSelect { core, profile, table }).unwrap();
    }
    client.call(PvtStart { core, mask: axes.fold(0, |mask, axis| mask | 1 << (axis - 1)).into() }).unwrap();
}

/// Lines of 2 ms whose speeds go from 400 to 500 pulse/ms and back: the power changes in every
/// tick.
fn fill_paths(client: &Client) {
    let (core, fifo) = (1.into(), 0.into());
    for (crd, channel, axes) in [(1i16, 0i16, 0), (2, 1, 2)] {
        let (crd, channel) = (crd.into(), channel.into());
        let mut profile = [0.into(); 8];
        (profile[axes], profile[axes + 1]) = (1.into(), 2.into());
        client
            .call(SetCrdPrm {
                core,
                crd,
                dimension: 2.into(),
                profile,
                syn_vel_max: 500.0.into(),
                syn_acc_max: 1000.0.into(),
                even_time_ms: 0.into(),
                set_origin_flag: 1.into(),
                origin_pos: [0.into(); 8],
            })
            .unwrap();
        client.call(CrdClear { core, crd, fifo }).unwrap();
        let (ratio, min, max) = (0.1.into(), 0.0.into(), 100.0.into());
        client.call(BufLaserFollowRatio { core, crd, ratio, min, max, fifo, channel }).unwrap();
        client.call(BufLaserOn { core, crd, fifo, channel }).unwrap();
        for line in 1..=LINES {
            let vel = if line % 2 == 0 { 400.0 } else { 500.0 };
            let (x, y) = ((720 * line).into(), (540 * line).into());
            let (syn_vel, syn_acc, vel_end) = (500.0.into(), 50.0.into(), if line < LINES { vel } else { 0.0 }.into());
            client.call(LnXY { core, crd, x, y, syn_vel, syn_acc, vel_end, fifo }).unwrap();
        }
    }
}

/// Starts a load, and lets it settle.
pub fn start(elf: &[u8], load: &Load, tick_us: i32, watched: bool) -> Loaded {
    let shared = board(elf, watched);
    let client = Client::open(Box::new(EmulatedLink::new(shared.clone())), Options::default()).unwrap();
    let core = 1.into();
    client.call(SetTick { tick_us: tick_us.into() }).unwrap();
    for axis in 1..=8i16 {
        client.call(AxisOn { core, axis: axis.into() }).unwrap();
    }
    for (axis, channel) in [(7i16, 0i16), (8, 1)].into_iter().filter(|_| load.carriers) {
        let channel = channel.into();
        client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() }).unwrap();
        client.call(LaserOutFrq { core, frequency: 2000.0.into(), channel }).unwrap();
        client.call(LaserPrfCmd { core, power: 33.3.into(), channel }).unwrap();
    }
    // One after the other: what begins takes a tick longer than what goes on.
    let settle = || lock(&shared).run(5 * MILLISECOND);
    if !load.axes.is_empty() {
        run_axes(&client, load.axes.clone());
        settle();
    }
    if load.paths {
        fill_paths(&client);
        for mask in [1i16, 2] {
            settle();
            client.call(CrdStart { core, mask: mask.into(), option: 0.into() }).unwrap();
        }
    }
    for channel in (0..2i16).filter(|_| load.carriers && !load.paths) {
        // A tick that overran keeps the lasers dark, which is asked at the end.
        let _ = client.call(SetHSIOOpt { core, value: 1.into(), channel: channel.into() });
        settle();
    }
    settle();
    Loaded { shared, client }
}

impl Loaded {
    /// So many ticks, or as many as the paths last, between `begin` and `end`; and whether the
    /// lasers are dark where they should be lit, as a tick that overran keeps them.
    pub fn run<T>(
        &self,
        load: &Load,
        tick_us: i32,
        count: usize,
        begin: impl FnOnce(&mut Chip),
        end: impl FnOnce(&mut Chip) -> T,
    ) -> (T, bool) {
        let lasts = tick_us as Time * MICROSECOND;
        let ticks = (count as Time).min((2 * LINES as Time - 50) * MILLISECOND / lasts);
        let counts = {
            let mut machine = lock(&self.shared);
            begin(&mut machine.chip);
            machine.run(lasts * ticks);
            end(&mut machine.chip)
        };
        let is_lit = |channel: i16| {
            self.client.call(LaserStatus { core: 1.into(), channel: channel.into() }).unwrap().light == 1
        };
        let dark = load.carriers && !(is_lit(0) && is_lit(1));
        if load.paths && !dark {
            let at = || self.client.call_items(GetCrdPos { core: 1.into(), crd: 1.into() }, &[]).unwrap().1;
            let before = at();
            lock(&self.shared).run(MILLISECOND);
            assert_ne!(at(), before, "the path has ended");
        }
        (counts, dark)
    }
}
