//! Commands, cuts, resets and faults at any point of a running virtual controller.
//!
//! An input is {seed, fuel, ops}: how the line behaves, how many ticks it may take, what is done.
//! Two kinds by the first byte: *wild*, where every command may come with every body; and
//! *counted*, where axes 7 and 8 and coordinate system 2 are the model's, as is analog output 8,
//! and no other request names them. The model's requests come by both lanes, in FIFOs of their own.
//! They are PT segments of axis 8 with increasing times, and entries of a path of coordinate system
//! 2. The order of segments is known by the refusal of one that comes too early.
//!
//! After every cut the controller is asked what it has got; the paths are run, and what they do is
//! compared ([`crate::model`]). What was answered with 0 is there once. What was reported as not
//! executed is not there. Of what was in a session that ended there is a part, in order.
use crate::bench::{Bench, Fate, Line};
use crate::commands::{Clocks, Range, body, has_items};
use crate::model::{ENTRIES_MAX, Mark, PATHS, Ran, Row, SEGMENTS, path_entry, segment};
use crate::scenes::{scene, witness};
use crate::source::Source;
use protocol::command::{COMMANDS, CrdData, CrdSpace, CrdStart, ProgramStart, PtData, PtSpace, Request, opcode};
use protocol::reason::Reason;
use protocol::record::Lane;
use virtual_board::{Config, Memory};
use zerocopy::IntoBytes;

/// Ticks of an input at most.
const FUEL: u32 = 4000;
/// Controllers of an input at most.
const LIVES: usize = 3;
/// Places of a PT FIFO, and of a path.
const PLACES: usize = 1024;

/// See the module text.
pub fn run(data: &[u8]) {
    let mut from = Source::new(data);
    let kind = from.byte();
    let counted = kind & 1 == 1;
    let config = Config { tick_us: [250, 50, 125, 1000][usize::from(kind >> 1 & 3)], ..Config::default() };
    let line = Line { noise: if kind & 8 == 0 { 0 } else { from.byte() % 20 }, seed: from.word().into() };
    let fuel = FUEL.min(u32::from(from.byte()) * 32 + 64);
    let mut memories: [Option<Memory>; LIVES] = [const { None }; LIVES];
    let mut memories = memories.iter_mut().map(|memory| memory.insert(Memory::new(config)));
    let Some(memory) = memories.next() else { return };
    let mut game = Game {
        bench: Bench::new(memory, line),
        rows: Default::default(),
        counted,
        clocks: Clocks::default(),
        noise: line.noise,
        left: fuel,
        place: 0,
    };
    game.begin();
    while !from.is_empty() && game.left > 0 {
        match from.below(32) {
            0 => {
                if let Some(memory) = memories.next() {
                    let fault = from.one_in(2);
                    game.bench.power_cycle(memory, fault);
                    (game.rows, game.place) = Default::default();
                    game.bench.fates.clear();
                    game.begin();
                }
            }
            op => game.act(op, &mut from),
        }
    }
    game.reckon();
    game.abort();
}

struct Game<'m> {
    bench: Bench<'m>,
    rows: [Row; 4],
    counted: bool,
    clocks: Clocks,
    noise: u8,
    /// Ticks left.
    left: u32,
    /// Where the model's path rests, pulses: the number of the motion that was executed last.
    place: u32,
}

impl Game<'_> {
    fn ticks(&mut self, count: u32) {
        self.bench.ticks(count);
        self.left = self.left.saturating_sub(count);
    }

    /// The session is open, and the model has its places.
    fn begin(&mut self) {
        self.bench.open();
        if self.counted {
            self.bench.set_noise(0);
            let before = self.bench.answers;
            for (number, body) in witness() {
                self.bench.send(*number, Lane::Immediate, body.clone(), None);
            }
            self.bench.settle();
            assert_eq!(self.bench.answers[1], before[1], "the model has its places: {:?}", self.bench.refusal);
            self.bench.set_noise(self.noise);
        }
    }

    fn act(&mut self, op: usize, from: &mut Source) {
        let range = if self.counted { Range::Some } else { Range::All };
        match op {
            1..=6 => self.ticks(from.below(64) as u32 + 1),
            7 => self.ticks(from.below(400) as u32),
            8..=14 => {
                let info = &COMMANDS[from.below(COMMANDS.len())];
                let lane = lane(from);
                if self.counted && matters(info.opcode) {
                    return;
                }
                let items = if has_items(info) { from.below(12) } else { 0 };
                let body = body(info, items, range, &mut self.clocks, from);
                self.bench.send(info.opcode, lane, body, None);
            }
            // Any bytes under a known number, or under none.
            15 if !self.counted => {
                let number = if from.one_in(8) { from.word() } else { COMMANDS[from.below(COMMANDS.len())].opcode };
                let lane = lane(from);
                let count = from.below(300);
                let mut body = from.bytes(count).to_vec();
                if number == opcode::SetTick || number == opcode::Choose {
                    body.clear();
                }
                self.bench.send(number, lane, body, None);
            }
            // A body that is too short or too long; no record at all.
            16 => {
                let info = &COMMANDS[from.below(COMMANDS.len())];
                let lane = lane(from);
                if self.counted && matters(info.opcode) {
                    return;
                }
                let mut body = body(info, 0, range, &mut self.clocks, from);
                match from.below(3) {
                    0 => body.push(from.byte()),
                    1 => {
                        body.pop();
                        if body.is_empty() {
                            body.push(0);
                        }
                    }
                    _ => {
                        let (lane, length) = (from.byte(), from.word());
                        self.bench.send_broken(info.opcode, lane, length, &body);
                        return;
                    }
                }
                if body.len() != size_of_fields(info) || has_items(info) {
                    self.bench.send(info.opcode, lane, body, None);
                }
            }
            17..=19 => {
                let lane = lane(from);
                for (number, body) in scene(from.below(8)) {
                    self.bench.send(*number, lane, body.clone(), None);
                }
                if lane != Lane::Immediate && from.one_in(2) {
                    self.bench.send(opcode::ProgramEnd, Lane::Program, Vec::new(), None);
                }
                self.ticks(from.below(16) as u32);
                if lane != Lane::Immediate {
                    self.bench.send(ProgramStart::OPCODE, Lane::Immediate, vec![0], None);
                }
            }
            20 | 21 => {
                let program = usize::from(from.one_in(2));
                for _ in 0..=from.below(8) {
                    self.witness(program, from.one_in(2));
                }
            }
            22 => self.bench.send(ProgramStart::OPCODE, Lane::Immediate, vec![from.byte() & 1], None),
            // The line is cut, for ever so long, with or without a new session after it.
            23 | 24 => {
                self.bench.cut = true;
                let count = from.below(2200) as u32;
                self.ticks(count);
                self.bench.cut = false;
                if from.one_in(2) {
                    self.bench.open();
                }
                if self.counted {
                    self.reckon();
                    self.bench.set_noise(self.noise);
                }
            }
            25 => {
                self.bench.open();
                self.ticks(from.below(32) as u32);
            }
            26 => {
                self.noise = from.byte() % 25;
                self.bench.set_noise(self.noise);
            }
            27 => {
                let active = from.one_in(2);
                let at = self.bench.board.now() + u64::from(from.word());
                match (active, from.one_in(2)) {
                    (true, true) => self.bench.board.raise_interlock(at),
                    (active, _) => self.bench.board.inputs_mut().interlock = active,
                }
            }
            28 => self.bench.cause(|board| board.overrun()),
            29 | 30 => {
                let inputs = self.bench.board.inputs_mut();
                let which = from.below(10);
                let levels = from.byte();
                if let Some(axis) = inputs.axes.get_mut(which) {
                    axis.limit_positive = levels & 1 != 0;
                    axis.limit_negative = levels & 2 != 0;
                    axis.alarm = levels & 4 != 0;
                    axis.home = levels & 8 != 0;
                    axis.arrive = levels & 16 != 0;
                } else if which == 8 {
                    inputs.general = levels.into();
                } else {
                    inputs.analog[usize::from(levels & 7)] = from.word().cast_signed();
                }
            }
            _ => {
                if self.counted {
                    self.reckon();
                    self.bench.set_noise(self.noise);
                } else {
                    self.bench.settle();
                }
            }
        }
    }

    /// The next request of the model.
    fn witness(&mut self, program: usize, path: bool) {
        if !self.counted {
            return;
        }
        let row = if path { PATHS[program] } else { SEGMENTS[program] };
        let lane = [Lane::Immediate, Lane::Program][program];
        let number = self.rows[row].sent + 1;
        if number > ENTRIES_MAX {
            return;
        }
        self.rows[row].sent = number;
        let (request, body) = if path {
            path_entry(program, number)
        } else {
            (PtData::OPCODE, segment(program, number as i32).as_bytes().to_vec())
        };
        self.bench.send(request, lane, body, Some((row, number)));
    }

    /// Compares the controller with the model.
    fn reckon(&mut self) {
        self.bench.settle();
        for (row, number, fate) in std::mem::take(&mut self.bench.fates) {
            match fate {
                Fate::Done => self.rows[row].done.push(number),
                Fate::Unknown => self.rows[row].unknown.push(number),
                Fate::Refused => self.rows[row].dropped = true,
            }
        }
        if !self.counted {
            return;
        }
        for program in 0..2 {
            let body = PtSpace { core: 1.into(), profile: 8.into(), fifo: (program as i16).into() };
            let there = PLACES - self.ask(PtSpace::OPCODE, body.as_bytes());
            let row = &mut self.rows[SEGMENTS[program]];
            // The refusal of a segment that comes too early tells the one before it.
            let found = {
                self.bench.send(PtData::OPCODE, Lane::Immediate, segment(program, 0).as_bytes().to_vec(), None);
                while self.bench.unanswered() > 0 {
                    self.bench.ticks(1);
                }
                let refusal = self.bench.refusal.unwrap_or_else(|| panic!("a segment at time 0 was taken"));
                match refusal.reason() {
                    Some(Reason::NotIncreasing) => refusal.low.get() as u32,
                    reason => panic!("a segment at time 0 is refused for {reason:?}"),
                }
            };
            row.settle(there, Some(found));
            let there = self.entries(program);
            if there > 0 {
                let ran = self.run_path(program);
                self.place = self.rows[PATHS[program]].compare(program, there, &ran, self.place);
                assert_eq!(self.entries(program), 0, "what was executed leaves its place");
            } else if program == 0 || !self.rows[PATHS[program]].may_be_emptied() {
                self.rows[PATHS[program]].settle(0, None);
            }
            self.rows[PATHS[program]].forget();
        }
    }

    /// Entries in a FIFO of the model's path.
    fn entries(&mut self, fifo: usize) -> usize {
        let body = CrdSpace { core: 1.into(), crd: 2.into(), fifo: (fifo as i16).into() };
        PLACES - self.ask(CrdSpace::OPCODE, body.as_bytes())
    }

    /// Runs what is in a FIFO of the model's path to its end: what it did.
    fn run_path(&mut self, fifo: usize) -> Ran {
        let flush = CrdData { core: 1.into(), crd: 2.into(), fifo: (fifo as i16).into() };
        self.ask(CrdData::OPCODE, flush.as_bytes());
        let before = self.bench.board.crd(1).done[fifo];
        let start = CrdStart { core: 1.into(), mask: 2.into(), option: (2 * fifo as i16).into() };
        let mut marks = vec![Mark { at: 0, ..self.mark() }];
        self.bench.send(CrdStart::OPCODE, Lane::Immediate, start.as_bytes().to_vec(), None);
        let (mut ticks, mut began, mut refused) = (0, None, self.bench.answers[1]);
        while began.is_none() || self.bench.board.crd(1).runs {
            self.bench.ticks(1);
            ticks += 1;
            let mark = Mark { at: ticks, ..self.mark() };
            if marks.last().is_none_or(|last| last.value != mark.value) {
                marks.push(mark);
            }
            if self.bench.board.crd(1).runs {
                began = began.or(Some(ticks));
            } else if self.bench.unanswered() == 0 && began.is_none() {
                began = Some(ticks);
            }
            assert_eq!(
                std::mem::replace(&mut refused, self.bench.answers[1]),
                self.bench.answers[1],
                "{:?}",
                self.bench.refusal
            );
            assert!(ticks < 100_000, "a path of {ENTRIES_MAX} entries ends");
        }
        while self.bench.unanswered() > 0 {
            self.bench.ticks(1);
        }
        let motions = self.bench.board.crd(1).done[fifo].wrapping_sub(before);
        Ran {
            marks,
            ticks: ticks - began.unwrap_or(ticks),
            motions,
            ticks_of_ms: (1_000_000 / self.bench.board.period_ns()) as u32,
            place: self.mark().place,
        }
    }

    /// Analog output 8 and the place of the model's path now.
    fn mark(&self) -> Mark {
        let place = self.bench.board.set_point(6) as f64 / f64::from(1 << 22);
        Mark { at: 0, value: self.bench.board.outputs().analog[7], place }
    }

    /// Whatever came before, an Abort is carried out, and nothing is output after it.
    fn abort(&mut self) {
        self.bench.settle();
        self.ask(opcode::Abort, &1i16.to_le_bytes());
        self.bench.guard.aborts();
        self.bench.ticks(64);
    }

    /// A number that the controller reports.
    fn ask(&mut self, number: u16, body: &[u8]) -> usize {
        let before = self.bench.answers[0];
        self.bench.send(number, Lane::Immediate, body.to_vec(), None);
        while self.bench.unanswered() > 0 {
            self.bench.ticks(1);
        }
        assert_eq!(self.bench.answers[0], before + 1, "{number:#06x} is refused: {:?}", self.bench.refusal);
        self.bench.reply.first_chunk().map_or(0, |bytes| usize::from(u16::from_le_bytes(*bytes)))
    }
}

fn lane(from: &mut Source) -> Lane {
    [Lane::Immediate, Lane::Program, Lane::Immediate, Lane::ProgramMayFail][from.below(4)]
}

/// Whether the command could touch what is the model's whatever it names.
fn matters(number: u16) -> bool {
    matches!(
        number,
        opcode::Reset
            | opcode::Choose
            | opcode::SetTick
            | opcode::SetDac
            | opcode::BufDA
            | opcode::SimInput
            | opcode::SimAdc
            | opcode::SimPlan
    )
}

fn size_of_fields(info: &protocol::command::CommandInfo) -> usize {
    crate::bench::size(info.fields)
}
