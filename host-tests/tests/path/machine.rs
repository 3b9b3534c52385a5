//! The whole machine for a test: a job's text in, through the client, the link, the dispatcher and
//! the tick of the virtual controller; out comes what its outputs did, to the ns, and the rows of
//! its trace. Times are those of the script.
#![allow(dead_code, reason = "each test file takes what it needs")]
use client::{Answer, Call, Client, Link, Observer, Options, Quiet};
use host_tests::laser_model::{Edge, Family, Ns};
use job::{Action, Files};
use plant::beam::SignalChange;
use protocol::command::{Request, Sleep, Trace, WaitStop};
use std::sync::{Arc, Mutex};
use trace::{Header, Item, Reader, Row};
use virtual_board::{Board, Config, Output, Shared, VirtualLink, share};

struct Nowhere;

impl Files for Nowhere {
    fn text(&self, path: &str) -> Result<String, String> {
        Err(format!("{path}: a test has no files"))
    }
}

/// What the outputs of a channel did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Beams {
    pub energy: Vec<Edge<bool>>,
    pub switch: Vec<Edge<bool>>,
    pub volts: Vec<Edge<i16>>,
}

/// What a job did.
#[derive(Debug, Default)]
pub struct Reported {
    pub lasers: [Beams; 2],
    /// General outputs: instant, number from 1, level.
    pub outputs: Vec<(Ns, u8, bool)>,
    pub header: Header,
    pub rows: Vec<Row>,
    /// Answers to the script's calls, with their lines.
    pub answers: Vec<(u32, Answer)>,
}

impl Reported {
    /// Replies to a command, in order.
    pub fn replies<R: Request>(&self) -> Vec<R::Reply> {
        self.answers.iter().filter_map(|(_, answer)| answer.reply::<R>()).map(|(reply, _)| reply).collect()
    }

    /// Items of the replies to a command, in order.
    pub fn items<R: Request>(&self) -> Vec<R::ReplyItem> {
        self.answers.iter().filter_map(|(_, answer)| answer.reply::<R>()).flat_map(|(_, items)| items).collect()
    }
}

struct Kept(Vec<Answer>);

impl Observer for Kept {
    fn answered(&mut self, answer: Answer) -> client::Result<()> {
        self.0.push(answer);
        Ok(())
    }
}

/// A controller at power-on and its client.
pub struct Machine {
    pub board: Shared,
    pub client: Client,
    pub family: Family,
    pub tick_ns: Ns,
    rows: Arc<Mutex<(Header, Vec<Row>)>>,
    /// Axes and lasers whose rows are kept.
    traced: (u64, u8),
}

/// Calls of a text, with the line of each.
pub fn compiled(text: &str) -> Vec<(u32, Call)> {
    let job = job::compile(text, &Nowhere).unwrap_or_else(|found| {
        let reported: String = found.iter().map(|found| format!("{found:?}\n")).collect();
        panic!("{reported}\n{}", numbered(text))
    });
    let call = |action: &Action| match action {
        Action::Sleep { ns } => Call::of(Sleep { ns: (*ns).into() }),
        Action::WaitStop { core, axes, crds } => Call::of(WaitStop {
            core: (*core).into(),
            axes: axes.cast_signed().into(),
            crds: crds.cast_signed().into(),
        }),
        Action::WaitAll => panic!("a test names what it waits for"),
        Action::Call(call) => Call { opcode: call.opcode, payload: call.body.clone(), may_fail: call.may_fail },
    };
    job.steps.iter().map(|step| (step.line, call(&step.action))).collect()
}

/// A text with its line numbers.
pub fn numbered(text: &str) -> String {
    text.lines().enumerate().map(|(index, line)| format!("{:4} {line}\n", index + 1)).collect()
}

impl Machine {
    /// Ticks of so many ns.
    pub fn new(family: Family, tick_ns: Ns) -> Machine {
        Machine::over(family, tick_ns, |board| Box::new(VirtualLink::new(board)))
    }

    /// The same over a link of the test's.
    pub fn over(family: Family, tick_ns: Ns, link: impl FnOnce(Shared) -> Box<dyn Link>) -> Machine {
        let board = share(Board::new(Config { tick_us: (tick_ns / 1000) as u32, ..Config::default() }));
        let theirs = match family {
            Family::Gus => client::Family::Gus,
            Family::Lsr => client::Family::Lsr,
        };
        let options = Options { family: Some(theirs), ..Options::default() };
        let client = Client::open(link(board.clone()), options).unwrap();
        board.lock().unwrap().record_beam(true);
        let rows: Arc<Mutex<(Header, Vec<Row>)>> = Arc::default();
        let (kept, mut reader) = (Arc::clone(&rows), Reader::new());
        client.trace_to(move |bytes| {
            let mut kept = kept.lock().unwrap();
            let taken = reader.feed(bytes, |item| {
                match item {
                    Item::Header(header) => kept.0 = header,
                    Item::Row(row) => kept.1.push(row),
                    _ => {}
                }
                Ok(())
            });
            taken.unwrap();
        });
        Machine { board, client, family, tick_ns, rows, traced: (0, 0) }
    }

    /// Keeps a row of these axes and lasers for every tick.
    pub fn traced(self, axes: u64, lasers: u8) -> Machine {
        Machine { traced: (axes, lasers), ..self }
    }

    /// Keeps a row for every tick from now on.
    pub fn trace(&self) {
        let (axes, lasers) = self.traced;
        *self.rows.lock().unwrap() = (Header::default(), Vec::new());
        // Rows are counted from the begin of a program.
        let trace = Trace { every: 1.into(), axes: axes.into(), lasers, crds: 0, over_link: 0, edges: 0 };
        self.client.run([Call::of(trace)], true, &mut Quiet).unwrap();
    }

    /// The rows since then.
    pub fn take_rows(&self) -> Vec<Row> {
        self.client.call(Trace::default()).unwrap();
        self.client.sleep(std::time::Duration::from_millis(5)).unwrap();
        std::mem::take(&mut self.rows.lock().unwrap().1)
    }

    /// Runs a text; a call that is refused ends it, unless it may fail.
    pub fn try_run(&self, text: &str) -> Result<Reported, String> {
        self.board.lock().unwrap().take_beam();
        self.board.lock().unwrap().take_edges();
        *self.rows.lock().unwrap() = (Header::default(), Vec::new());
        let mut lines = Vec::new();
        let mut calls = Vec::new();
        let (axes, lasers) = self.traced;
        let traces = axes != 0 || lasers != 0;
        if traces {
            calls.push(Call::of(Trace { every: 1.into(), axes: axes.into(), lasers, crds: 0, over_link: 0, edges: 0 }));
            lines.push(0);
        }
        for (line, call) in compiled(text) {
            calls.push(call);
            lines.push(line);
        }
        if traces {
            calls.push(Call::of(Trace::default()));
            lines.push(0);
        }
        let mut kept = Kept(Vec::new());
        let summary = self.client.run(calls, true, &mut kept).map_err(|error| format!("{error:?}"))?;
        if let Some(answer) = summary.failed {
            let line = lines.get(answer.index as usize);
            return Err(format!("line {line:?}: {} {:?}\n{}", answer.code, answer.error, numbered(text)));
        }
        if traces {
            self.client.sleep(std::time::Duration::from_millis(5)).unwrap();
        }
        let mut board = self.board.lock().unwrap();
        let zero = board.program_zero_ns() as Ns;
        let mut reported = Reported::default();
        for beam in board.take_beam() {
            let of = &mut reported.lasers[usize::from(beam.channel)];
            match beam.change {
                SignalChange::Switch { at, level } => of.switch.push((at as Ns - zero, level)),
                SignalChange::Energy { at, level } => of.energy.push((at as Ns - zero, level)),
                SignalChange::Dac { at, code } => of.volts.push((at as Ns - zero, code)),
                SignalChange::Pulses(burst) => {
                    for (begin, end) in burst.pulses().filter(|(begin, end)| begin < end) {
                        of.energy.extend([(begin as Ns - zero, true), (end as Ns - zero, false)]);
                    }
                }
            }
        }
        for edge in board.take_edges() {
            if let Output::General(bit) = edge.output {
                reported.outputs.push((edge.at_ns as Ns - zero, bit + 1, edge.level));
            }
        }
        drop(board);
        for beams in &mut reported.lasers {
            settle(&mut beams.energy, false);
            settle(&mut beams.switch, false);
            settle(&mut beams.volts, 0);
        }
        (reported.header, reported.rows) = std::mem::take(&mut *self.rows.lock().unwrap());
        reported.answers = kept
            .0
            .into_iter()
            .map(|answer| (lines[answer.index as usize], answer))
            .filter(|(line, _)| *line > 0)
            .collect();
        Ok(reported)
    }

    /// The same; nothing may be refused.
    pub fn run(&self, text: &str) -> Reported {
        self.try_run(text).unwrap_or_else(|reason| panic!("{reason}"))
    }

    /// Everything as at power-on but for the clock.
    pub fn reset(&self) {
        self.run("GT_Reset();\nGT_SetDo(12,0);\nSleep(2);\n");
    }
}

/// Leaves the last level of an instant, and only where it differs from what was. Recording began at
/// rest.
fn settle<T: Copy + PartialEq>(edges: &mut Vec<Edge<T>>, rest: T) {
    let mut left: Vec<Edge<T>> = Vec::with_capacity(edges.len());
    for &(at, level) in edges.iter() {
        left.pop_if(|last| last.0 == at);
        if left.last().map_or(rest, |&(_, level)| level) != level {
            left.push((at, level));
        }
    }
    *edges = left;
}
