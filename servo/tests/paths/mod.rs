//! A host of paths for tests: entries in a list, all reports written down.
use servo::path::{Effects, EntryEffect, FifoEnds, MotionSpeeds, Path, PathEntries, PathEntry, PathStop};
use servo::segment::piece::Scaled;
use servo::test_hooks::Step;
use servo::units::{Axis, FineNs, Ns, Pos};

pub struct Script(pub Vec<PathEntry>);

impl PathEntries for Script {
    fn entry(&self, _: u8, counter: u32) -> PathEntry {
        self.0[counter as usize]
    }
}

/// The reports of a path.
#[derive(Default)]
pub struct Heard {
    pub marks: Vec<(FineNs, u8)>,
    pub rests: Vec<(FineNs, PathStop)>,
    pub gears: Vec<(Axis, Pos)>,
    pub geared: Vec<(Axis, i32)>,
}

impl Effects for Heard {
    fn change(&mut self, at: FineNs, change: &EntryEffect) -> FineNs {
        match change {
            EntryEffect::Laser { code, .. } => self.marks.push((at, *code)),
            EntryEffect::Move { modal: true, .. } => return 3_000_000 << 32,
            _ => {}
        }
        0
    }
    fn standstill(&mut self, at: FineNs, rest: PathStop) {
        self.rests.push((at, rest));
    }
    fn gear(&mut self, axis: Axis, by: Pos, _: Scaled) {
        self.gears.push((axis, by));
    }
    fn geared(&mut self, _: u128, axis: Axis, pulses: i32) {
        self.geared.push((axis, pulses));
    }
}

pub fn mark(code: u8) -> PathEntry {
    PathEntry::laser(0, code, [0; 6])
}
/// Speed, acceleration, speed at the end.
pub fn speeds(vel: f64, acc: f64, end: f64) -> MotionSpeeds {
    MotionSpeeds::admit(vel.to_bits(), acc.to_bits(), end.to_bits()).unwrap()
}

/// Runs all entries from a start at 1 ms with this period; `see` gets every tick's step.
pub fn run(path: &mut Path, script: &Script, period: u64, mut see: impl FnMut(u64, &Step)) -> Heard {
    let feed = FifoEnds { ends: [script.0.len() as u32, 0] };
    let mut heard = Heard::default();
    let begin = 1_000_000;
    assert!(!path.refuses_start(0, feed));
    path.start(Ns(begin), 0, feed, script);
    let mut now = begin;
    loop {
        let step = path.step(Ns(now), Ns(period), feed, script, &mut heard);
        see(now - begin, &step);
        if !step.runs {
            return heard;
        }
        now += period;
        assert!(now < 1 << 50);
    }
}

/// Instants in ns after the start.
pub fn since(at: FineNs) -> f64 {
    (at - (1_000_000 << 32)) as f64 / 2f64.powi(32)
}
