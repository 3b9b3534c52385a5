//! Steps to entries of the program queue.
//!
//! In: the steps of a job, one by one, and the controller's counts. Out: calls, and for each the
//! steps it came from. Owns the steps that somebody may still ask for. Runs of PtData for one FIFO
//! travel as PtDataMany, and long runs of lines of common speeds as LnXYMany or LnXYZMany, which
//! changes nothing but their cost; an item that is refused still finds its line. Short runs are
//! left to the client, which joins them with what is between them. Steps that cannot be read any
//! more end the script there.
use crate::points::{is_record, records};
use crate::source::Steps;
use crate::totals::Totals;
use client::Call;
use job::{Action, Job, Step};
use protocol::command::{
    Abort, AxisStatus, LaserStatus, LnXY, LnXYMany, LnXYZ, LnXYZMany, PathXY, PathXYZ, PtData, PtDataMany, PtItem,
    Request, Sleep, Trace, VersionReply, WaitStop,
};
use std::collections::VecDeque;
use zerocopy::{FromBytes, IntoBytes};

/// Bytes of items in one record, at most: two records fit in a frame.
const MERGED_BYTES: usize = 32 * size_of::<PtItem>();

/// Lines of common speeds from which on they are shorter as one command. So many single calls fill
/// a message of the client.
const JOINED_MIN_LINES: usize = 24;

/// One entry.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// What is sent.
    pub call: Call,
    /// What it came from.
    pub from: From,
}

/// Where an entry came from.
#[derive(Debug, Clone, PartialEq)]
pub enum From {
    /// A step of the job, by its number.
    Step(usize),
    /// One step for each item.
    Items(Vec<usize>),
    /// At the end of the script: what it left moving.
    Left {
        /// Logical core, from 1.
        core: i16,
        /// First axis of the reply.
        axis: i16,
    },
    /// Within the last tick of the script: whether it leaves a laser on.
    Light {
        /// From 0.
        channel: u8,
    },
    /// After the script: the program's own end.
    End,
}

impl From {
    /// The step that an item belongs to; `item` is 65535 where none is named.
    pub fn step(&self, item: u16) -> Option<usize> {
        match self {
            From::Step(step) => Some(*step),
            From::Items(steps) => steps.get(usize::from(item)).or(steps.first()).copied(),
            From::Left { .. } | From::Light { .. } | From::End => None,
        }
    }

    /// The first of its steps.
    pub fn first_step(&self) -> Option<usize> {
        self.step(0)
    }
}

/// All axes of a core as a mask.
pub fn all_axes(version: &VersionReply) -> u32 {
    1u32.checked_shl(version.axes_per_core.into()).unwrap_or(0).wrapping_sub(1)
}

/// All coordinate systems of a core as a mask.
pub fn all_crds(version: &VersionReply) -> u32 {
    1u32.checked_shl(version.crds_per_core.into()).unwrap_or(0).wrapping_sub(1)
}

/// Laser channels that the job used and the controller has.
pub fn lasers(job: &Job, version: &VersionReply) -> impl Iterator<Item = u8> {
    let used = job.lasers;
    (0..version.lasers.min(8)).filter(move |channel| used >> channel & 1 == 1)
}

/// The end of a script, as far as a read at that point reports it: at the end of its tick, together
/// with an Abort of the same instant.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ending {
    /// With a Sleep longer than a tick, this step: what is on is read in the last tick of it.
    Sleeps(usize),
    /// With a read: the Abort is a tick later, so that the read shows what the script did.
    Reads,
    /// With anything else: nothing is read.
    Acts,
}

impl Ending {
    fn of(totals: &Totals, tick_ns: u64) -> Ending {
        match &totals.last {
            Some(Action::Sleep { ns }) if *ns > tick_ns => Ending::Sleeps(totals.steps - 1),
            Some(Action::Call(call)) if !call.outs.is_empty() => Ending::Reads,
            _ => Ending::Acts,
        }
    }
}

/// The script's entries, then Abort as a call there would act; what still moves is waited for, and
/// a trace ends. What lasers and axes do at the end is read before.
pub struct Entries<'s> {
    job: &'s Job,
    steps: Steps<'s>,
    version: VersionReply,
    traced: bool,
    ending: Ending,
    tick_ns: u64,
    run: Option<FifoData>,
    /// Entries that are made and not handed over.
    due: VecDeque<Entry>,
    /// The number of the next step, and the steps before it that are kept.
    number: usize,
    kept: VecDeque<Step>,
    ended: bool,
    broken: Option<String>,
}

impl<'s> Entries<'s> {
    /// Of a job and its steps.
    pub fn new(job: &'s Job, totals: &Totals, steps: Steps<'s>, version: VersionReply, traced: bool) -> Self {
        let tick_ns = u64::from(version.tick_us.get()) * 1000;
        Entries {
            job,
            steps,
            version,
            traced,
            ending: Ending::of(totals, tick_ns),
            tick_ns,
            run: None,
            due: VecDeque::new(),
            number: 0,
            kept: VecDeque::new(),
            ended: false,
            broken: None,
        }
    }

    /// Why the script ended early, if it did.
    pub fn broken(&self) -> Option<&str> {
        self.broken.as_deref()
    }

    /// A step by its number, if it is kept.
    pub fn step(&self, number: usize) -> Option<&Step> {
        self.kept.get(number.checked_sub(self.first_kept())?)
    }

    fn first_kept(&self) -> usize {
        self.number - self.kept.len()
    }

    /// Nobody asks for the steps before this one any more.
    pub fn forget_before(&mut self, number: usize) {
        let count = number.saturating_sub(self.first_kept()).min(self.kept.len());
        self.kept.drain(..count);
    }

    fn push(&mut self, call: Call, from: From) {
        self.due.push_back(Entry { call, from });
    }

    fn sleep(&mut self, ns: u64, from: From) {
        self.push(Call::of(Sleep { ns: ns.into() }), from);
    }

    fn lights(&mut self) {
        self.due.extend(lasers(self.job, &self.version).map(light));
    }

    /// The entries of a step.
    fn enter(&mut self, step: Step) {
        let number = self.number;
        if let Some((key, item)) = datum(&step.action) {
            if self.run.as_ref().is_some_and(|run| run.items.len() + item.len() > MERGED_BYTES || run.key != key) {
                self.finish();
            }
            let open = self.run.get_or_insert_with(|| FifoData { key, items: Vec::new(), steps: Vec::new() });
            open.items.extend_from_slice(item.as_bytes());
            open.steps.push(number);
            self.keep(step);
            return;
        }
        self.finish();
        let from = From::Step(number);
        match &step.action {
            Action::Sleep { ns } if self.job.lasers != 0 && self.ending == Ending::Sleeps(number) => {
                self.sleep(ns - self.tick_ns, from.clone());
                self.lights();
                self.sleep(self.tick_ns, from);
            }
            Action::Sleep { ns } => self.sleep(*ns, from),
            Action::WaitStop { core, axes, crds } => self.push(wait(*core, *axes, *crds), from),
            Action::WaitAll => {
                let (axes, crds) = (all_axes(&self.version), all_crds(&self.version));
                for core in 1..=i16::from(self.version.cores) {
                    self.push(wait(core, axes, crds), from.clone());
                }
            }
            Action::Call(call) => {
                let call = Call { opcode: call.opcode, payload: call.body.clone(), may_fail: call.may_fail };
                if is_record(&call.payload) {
                    self.push(call, from);
                } else {
                    self.due.extend(records(call).into_iter().map(|call| Entry { call, from: from.clone() }));
                }
            }
        }
        self.keep(step);
    }

    fn keep(&mut self, step: Step) {
        self.kept.push_back(step);
        self.number += 1;
    }

    /// What comes after the last step.
    fn end(&mut self) {
        self.ended = true;
        self.finish();
        if self.ending == Ending::Reads && self.broken.is_none() {
            self.lights();
            self.sleep(self.tick_ns, From::End);
        }
        leave(&mut self.due, self.job, &self.version);
        if self.traced {
            if self.job.lasers != 0 {
                // The edge that ends the light lies in the tick after its command, and is whole
                // with the row after it.
                self.sleep(2 * self.tick_ns, From::End);
            }
            self.push(Call::of(Trace::default()), From::End);
        }
    }

    /// The data that travels together is complete.
    fn finish(&mut self) {
        let Some(FifoData { key, items, steps }) = self.run.take() else { return };
        let is_short = matches!(key, JoinKey::Lines { .. }) && steps.len() < JOINED_MIN_LINES;
        if is_short || steps.len() == 1 {
            for number in steps {
                if let Some(Action::Call(call)) = self.step(number).map(|step| &step.action) {
                    let call = Call { opcode: call.opcode, payload: call.body.clone(), may_fail: false };
                    self.push(call, From::Step(number));
                }
            }
            return;
        }
        let count = (steps.len() as u16).into();
        let (opcode, mut payload) = match key {
            JoinKey::Pt(of) => {
                let [core, profile, fifo] = of.map(Into::into);
                (PtDataMany::OPCODE, PtDataMany { core, profile, fifo, count }.as_bytes().to_vec())
            }
            JoinKey::Lines { number, of, speeds } => {
                let [core, crd, fifo] = of.map(Into::into);
                let [syn_vel, syn_acc, vel_end] = speeds.map(|bits| f64::from_bits(bits).into());
                // Both heads are alike.
                (number, LnXYMany { core, crd, fifo, count, syn_vel, syn_acc, vel_end }.as_bytes().to_vec())
            }
        };
        payload.extend(items);
        self.push(Call { opcode, payload, may_fail: false }, From::Items(steps));
    }
}

impl Iterator for Entries<'_> {
    type Item = Entry;

    fn next(&mut self) -> Option<Entry> {
        while self.due.is_empty() && !self.ended {
            match self.steps.next() {
                Some(Ok(step)) => self.enter(step),
                Some(Err(why)) => {
                    self.broken = Some(why);
                    self.end();
                }
                None => self.end(),
            }
        }
        self.due.pop_front()
    }
}

/// Reads whether a laser is on.
fn light(channel: u8) -> Entry {
    let status = LaserStatus { core: 1.into(), channel: i16::from(channel).into() };
    Entry { call: Call::of(status), from: From::Light { channel } }
}

fn wait(core: i16, axes: u32, crds: u32) -> Call {
    Call::of(WaitStop { core: core.into(), axes: axes.cast_signed().into(), crds: crds.cast_signed().into() })
}

/// Reads what the script left moving, aborts, and waits for standstill on the cores that it used.
fn leave(entries: &mut VecDeque<Entry>, job: &Job, version: &VersionReply) {
    for axis in &job.axes {
        if (1..=i16::from(version.cores)).contains(&axis.core) && axis.axis <= i16::from(version.axes_per_core) {
            let status = AxisStatus { core: axis.core.into(), axis: axis.axis.into(), count: 1.into() };
            entries.push_back(Entry { call: Call::of(status), from: From::Left { core: axis.core, axis: axis.axis } });
        }
    }
    let end = |call: Call| Entry { call, from: From::End };
    // One is for the whole controller.
    entries.push_back(end(Call::of(Abort { core: 1.into() })));
    let mut cores: Vec<i16> = job.axes.iter().map(|axis| axis.core).collect();
    cores.retain(|core| (1..=i16::from(version.cores)).contains(core));
    cores.dedup();
    entries.extend(cores.into_iter().map(|core| end(wait(core, all_axes(version), all_crds(version)))));
}

/// Data of one FIFO, not sent yet.
struct FifoData {
    key: JoinKey,
    items: Vec<u8>,
    steps: Vec<usize>,
}

/// What data has in common that travels together.
#[derive(Debug, Clone, Copy, PartialEq)]
enum JoinKey {
    /// Of PT: core, axis, FIFO.
    Pt([i16; 3]),
    /// Lines in X and Y, or X, Y and Z: core, coordinate system, FIFO; synVel, synAcc and velEnd.
    Lines { number: u16, of: [i16; 3], speeds: [u64; 3] },
}

/// An item of such data.
enum Item {
    Pt(PtItem),
    Xy(PathXY),
    Xyz(PathXYZ),
}

impl Item {
    fn as_bytes(&self) -> &[u8] {
        match self {
            Item::Pt(item) => item.as_bytes(),
            Item::Xy(item) => item.as_bytes(),
            Item::Xyz(item) => item.as_bytes(),
        }
    }

    fn len(&self) -> usize {
        self.as_bytes().len()
    }
}

/// Data that may travel with others, as an item. Data that an item cannot hold, or that may fail,
/// travels alone.
fn datum(action: &Action) -> Option<(JoinKey, Item)> {
    let Action::Call(call) = action else { return None };
    if call.may_fail {
        return None;
    }
    let lines =
        |number, of: [i16; 3], speeds: [f64; 3]| JoinKey::Lines { number, of, speeds: speeds.map(f64::to_bits) };
    match call.opcode {
        PtData::OPCODE => {
            let data = PtData::read_from_bytes(&call.body).ok()?;
            let kind = u8::try_from(data.kind.get()).ok()?;
            let item = PtItem { pos: data.pos, time_ms: data.time_ms, kind };
            Some((JoinKey::Pt([data.core.get(), data.profile.get(), data.fifo.get()]), Item::Pt(item)))
        }
        LnXY::OPCODE => {
            let line = LnXY::read_from_bytes(&call.body).ok()?;
            let of = [line.core.get(), line.crd.get(), line.fifo.get()];
            let key = lines(LnXYMany::OPCODE, of, [line.syn_vel.get(), line.syn_acc.get(), line.vel_end.get()]);
            Some((key, Item::Xy(PathXY { x: line.x, y: line.y })))
        }
        LnXYZ::OPCODE => {
            let line = LnXYZ::read_from_bytes(&call.body).ok()?;
            let of = [line.core.get(), line.crd.get(), line.fifo.get()];
            let key = lines(LnXYZMany::OPCODE, of, [line.syn_vel.get(), line.syn_acc.get(), line.vel_end.get()]);
            Some((key, Item::Xyz(PathXYZ { x: line.x, y: line.y, z: line.z })))
        }
        _ => None,
    }
}

const _: () = assert!(size_of::<LnXYMany>() == size_of::<LnXYZMany>());

#[cfg(test)]
mod tests {
    use super::*;
    use job::Files;

    struct None;
    impl Files for None {
        fn text(&self, path: &str) -> Result<String, String> {
            Err(path.to_owned())
        }
    }

    fn version() -> VersionReply {
        VersionReply {
            cores: 1,
            axes_per_core: 8,
            lasers: 2,
            crds_per_core: 2,
            tick_us: 50.into(),
            ..VersionReply::default()
        }
    }

    fn entries(job: &Job, version: &VersionReply, traced: bool) -> Vec<Entry> {
        let steps = Steps::Listed(job.steps.iter());
        Entries::new(job, &Totals::of(&job.steps), steps, *version, traced).collect()
    }

    fn of(text: &str) -> Vec<Entry> {
        entries(&job::compile(text, &None).unwrap(), &version(), false)
    }

    #[test]
    fn runs_of_data_travel_together_and_keep_their_lines() {
        let data: String = (1..=70).map(|n| format!("GT_PtData(1, {n}, {n});\n")).collect();
        let found = of(&format!("{data}GT_PtData(2, 5, 6, 2);\nGT_PtData(2, 5, 7, 300);\n"));
        let sizes: Vec<usize> =
            found.iter().map(|entry| if let From::Items(steps) = &entry.from { steps.len() } else { 1 }).collect();
        assert_eq!(sizes, [32, 32, 6, 1, 1, 1]);
        assert_eq!(found[1].from.step(5), Some(37));
        assert_eq!(found[1].from.step(65535), Some(32));
        let (head, items) = PtDataMany::read_from_prefix(&found[2].call.payload).unwrap();
        assert_eq!((head.count.get(), items.len()), (6, 6 * size_of::<PtItem>()));
        let single = PtData::read_from_bytes(&found[3].call.payload).unwrap();
        assert_eq!((single.pos.get(), single.time_ms.get(), single.kind.get()), (5.0, 6, 2));
        // A type that an item cannot hold is sent as it is, for the controller to refuse.
        assert_eq!(PtData::read_from_bytes(&found[4].call.payload).unwrap().kind.get(), 300);
    }

    #[test]
    fn runs_of_lines_travel_together() {
        let lines: String = (1..=60).map(|n| format!("GT_LnXY(1, {n}, 0, 50, 2, 0, 0);\n")).collect();
        let other = "GT_LnXY(1, 9, 0, 60, 2, 0, 0);\n";
        let spatial: String = (1..=24).map(|n| format!("GT_LnXYZ(1, {n}, 5, {n}, 50, 2);\n")).collect();
        let found = of(&format!("{lines}{other}{spatial}"));
        let sizes: Vec<usize> =
            found.iter().map(|entry| if let From::Items(steps) = &entry.from { steps.len() } else { 1 }).collect();
        // The last eight are too few: the client joins them with what follows.
        assert_eq!(sizes, [vec![52], vec![1; 8], vec![1, 24, 1]].concat());
        assert_eq!((found[0].from.step(7), found[8].from.step(u16::MAX)), (Some(7), Some(59)));
        let (head, items) = LnXYMany::read_from_prefix(&found[0].call.payload).unwrap();
        assert_eq!((head.count.get(), { head.syn_vel }.get(), items.len()), (52, 50.0, 52 * 8));
        assert_eq!(found[8].call.opcode, LnXY::OPCODE);
        let (head, items) = LnXYZMany::read_from_prefix(&found[10].call.payload).unwrap();
        let item = PathXYZ::read_from_bytes(&items[23 * 12..]).unwrap();
        assert_eq!((head.count.get(), item.x.get(), item.z.get()), (24, 24, 24));
    }

    fn aborts(entry: &Entry) -> bool {
        entry.from == From::End && entry.call == Call::of(Abort { core: 1.into() })
    }

    #[test]
    fn every_job_ends_with_an_abort_and_waits_on_the_cores_it_used() {
        let found = of("GT_PrfTrap(2); while(!kbhit());");
        assert_eq!(found[1].call, wait(1, 0xff, 3));
        assert_eq!(found[2].from, From::Left { core: 1, axis: 2 });
        assert!(aborts(&found[3]));
        assert_eq!((found.len(), &found[4].call), (5, &wait(1, 0xff, 3)));
        let found = of("Sleep(1);");
        assert!(found.len() == 2 && aborts(&found[1]));
        // A call at the end acts in the tick of the Abort: nothing is read between them.
        let found = of("GT_LaserOn(1);");
        assert!(found.len() == 2 && aborts(&found[1]));
        // What is on is read a tick before the end; the sleeps add up.
        let found = of("GT_LaserOn(1); Sleep(3);");
        assert_eq!(found[1].call, Call::of(Sleep { ns: 2_950_000.into() }));
        assert_eq!(found[2].from, From::Light { channel: 1 });
        assert_eq!((&found[3].call, &found[3].from), (&Call::of(Sleep { ns: 50_000.into() }), &From::Step(1)));
        assert!(found.len() == 5 && aborts(&found[4]));
        // A read at the end shows what the script did.
        let found = of("double p; GT_LaserOn(1); Sleep(3); GT_GetLaserPower(1, &p);");
        assert_eq!(found[1].call, Call::of(Sleep { ns: 3_000_000.into() }));
        assert_eq!((&found[2].from, &found[3].from), (&From::Step(2), &From::Light { channel: 1 }));
        assert_eq!(found[4].call, Call::of(Sleep { ns: 50_000.into() }));
        assert!(found.len() == 6 && aborts(&found[5]));
        // A trace continues until the light has ended.
        let found = entries(&job::compile("GT_SetHSIOOpt(1);", &None).unwrap(), &version(), true);
        assert!(aborts(&found[1]));
        assert_eq!(found[2].call, Call::of(Sleep { ns: 100_000.into() }));
        assert_eq!((found.len(), found[3].call.opcode), (4, Trace::OPCODE));
        let two = VersionReply { cores: 2, ..version() };
        let found = entries(&job::compile("GTN_PrfTrap(2, 1);", &None).unwrap(), &two, false);
        assert!(aborts(&found[2]));
        assert_eq!((found.len(), &found[3].call), (4, &wait(2, 0xff, 3)));
    }
}
