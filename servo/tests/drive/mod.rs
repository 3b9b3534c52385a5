//! One motion on its own: a [`Profile`] as an axis has it, stepped by a test through chosen
//! instants.
use servo::segment::generator_state::GeneratorState;
use servo::segment::piece::Motion;
use servo::segment::profile::{Generator, Profile};
use servo::segment::pt::{AllowedData, PtRun, Segment, SegmentStore, Segments, SlotRange};
use servo::segment::pvt::{HEADER_WORDS, POINT_WORDS, PvtRun, PvtTables};
use servo::segment::ramp::RampRun;
use servo::units::{Exact, Ns, Pos};

/// The motion at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Planned position.
    pub pos: Pos,
    /// The motion in its piece; at rest after the end.
    pub motion: Motion,
    /// Whether it goes on.
    pub state: GeneratorState,
}

/// A profile in which this begins.
fn profile(generator: Generator, now: Ns) -> Profile {
    let mut profile = Profile::STANDSTILL;
    profile.stand_still(now, Pos(0));
    profile.begin(now, generator);
    profile
}

/// The motion at `now`, which must not decrease between calls. `feed` and `source` are for PT and
/// PVT.
pub fn step(profile: &mut Profile, now: Ns, feed: AllowedData, source: &(impl Segments + PvtTables)) -> Step {
    if profile.piece().elapsed(now) >= profile.piece().span
        && !profile.accept(now)
        && let state @ (GeneratorState::Ended { at } | GeneratorState::Underrun { at }) =
            profile.turn(now, feed, source)
    {
        return Step { pos: at.round(), motion: Motion::STANDSTILL, state };
    }
    let piece = profile.piece();
    let (pos, motion) = piece.sample(piece.elapsed_within(now));
    Step { pos, motion, state: GeneratorState::Running }
}

/// Segments without tables.
struct NoTables<'a, S>(&'a S);
/// Tables without segments.
struct NoSegments<'a, T>(&'a T);
struct Nothing;

impl<S: Segments> Segments for NoTables<'_, S> {
    fn segment(&self, slot: u32) -> Segment {
        self.0.segment(slot)
    }
}
impl<S> PvtTables for NoTables<'_, S> {
    fn point(&self, _: u8, _: u32) -> [u32; POINT_WORDS] {
        Default::default()
    }
    fn header(&self, _: u8) -> [u32; HEADER_WORDS] {
        Default::default()
    }
}
impl<T> Segments for NoSegments<'_, T> {
    fn segment(&self, _: u32) -> Segment {
        SegmentStore::new().segment(0)
    }
}
impl<T: PvtTables> PvtTables for NoSegments<'_, T> {
    fn point(&self, table: u8, index: u32) -> [u32; POINT_WORDS] {
        self.0.point(table, index)
    }
    fn header(&self, table: u8) -> [u32; HEADER_WORDS] {
        self.0.header(table)
    }
}
impl PvtTables for Nothing {
    fn point(&self, _: u8, _: u32) -> [u32; POINT_WORDS] {
        Default::default()
    }
    fn header(&self, _: u8) -> [u32; HEADER_WORDS] {
        Default::default()
    }
}

fn passes_only(passes: u32) -> AllowedData {
    AllowedData { end: 0, passes }
}

#[derive(Clone, Copy)]
pub struct Pt(pub Profile);

impl Pt {
    pub fn begin(now: Ns, origin: Exact, point: SlotRange) -> Pt {
        Pt(profile(Generator::Pt(PtRun::begin(now, origin, point)), now))
    }
    fn run(&self) -> &PtRun {
        let Generator::Pt(run) = self.0.generator() else { panic!("not PT") };
        run
    }
    pub fn step(&mut self, now: Ns, feed: AllowedData, source: &impl Segments) -> Step {
        step(&mut self.0, now, feed, &NoTables(source))
    }
    pub fn prepare(&mut self, feed: AllowedData, source: &impl Segments) -> bool {
        self.0.is_open() && self.0.prepare(feed, &NoTables(source)) && self.0.is_ahead()
    }
    pub fn passes(&self) -> u32 {
        self.run().passes(self.0.is_ahead())
    }
    pub fn released(&self, running: bool) -> u32 {
        self.run().released(running, self.0.is_ahead())
    }
    pub fn dry_ms(&self, now: Ns, feed: AllowedData, source: &impl Segments) -> u32 {
        self.run().dry_ms(now, feed, source, self.0.is_ahead())
    }
}

#[derive(Clone, Copy)]
pub struct Pvt(pub Profile);

impl Pvt {
    pub fn begin(now: Ns, origin: Exact, table: u8, source: &impl PvtTables) -> Pvt {
        Pvt(profile(Generator::Pvt(PvtRun::begin(now, origin, table, source)), now))
    }
    fn run(&self) -> &PvtRun {
        let Generator::Pvt(run) = self.0.generator() else { panic!("not PVT") };
        run
    }
    pub fn step(&mut self, now: Ns, passes: u32, source: &impl PvtTables) -> Step {
        step(&mut self.0, now, passes_only(passes), &NoSegments(source))
    }
    pub fn prepare(&mut self, passes: u32, source: &impl PvtTables) -> bool {
        self.0.is_open() && self.0.prepare(passes_only(passes), &NoSegments(source)) && self.0.is_ahead()
    }
    pub fn select(&mut self, table: u8) {
        assert!(self.0.select(table));
    }
    pub fn passes(&self) -> u32 {
        self.run().passes(self.0.is_ahead())
    }
    /// Passes before the last piece that was made.
    pub fn made_passes(&self) -> u32 {
        self.run().passes(false)
    }
    pub fn table(&self) -> u8 {
        self.run().table(self.0.is_ahead())
    }
    pub fn pending(&self) -> Option<u8> {
        self.run().pending(self.0.is_ahead())
    }
    pub fn time(&self, now: Ns) -> Ns {
        self.run().time(now, self.0.is_ahead())
    }
}

#[derive(Clone, Copy)]
pub struct Ramp(pub Profile);

impl Ramp {
    pub fn begin(now: Ns, run: RampRun) -> Ramp {
        Ramp(profile(Generator::Ramp(run), now))
    }
    pub fn step(&mut self, now: Ns) -> Step {
        step(&mut self.0, now, passes_only(1), &NoSegments(&Nothing))
    }
    pub fn prepare(&mut self) -> bool {
        self.0.is_open() && self.0.prepare(passes_only(1), &NoSegments(&Nothing)) && self.0.is_ahead()
    }
}
