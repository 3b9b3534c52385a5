//! Job scripts: compiled, and run in a controller for a bounded time.
//!
//! The input is the script; after a NUL comes the text of every file that it loads. Held: a script
//! is compiled or refused with places inside of it; what was compiled is answered call by call and
//! breaks nothing that [`crate::guard`] holds.
use crate::bench::{Bench, Line};
use job::{Action, Files};
use protocol::command::{ProgramEnd, ProgramStart, Request, Sleep, WaitStop};
use protocol::record::Lane;
use virtual_board::{Config, Memory};
use zerocopy::IntoBytes;

/// Calls of a script that are sent, and ticks that it runs.
const CALLS: usize = 300;
const TICKS: u32 = 1500;

struct Same<'a>(&'a str);

impl Files for Same<'_> {
    fn text(&self, _: &str) -> Result<String, String> {
        Ok(self.0.to_owned())
    }
}

/// See the module text.
pub fn run(data: &[u8]) {
    let split = data.iter().position(|&byte| byte == 0).unwrap_or(data.len());
    let (script, file) =
        (String::from_utf8_lossy(&data[..split]), String::from_utf8_lossy(data.get(split + 1..).unwrap_or(&[])));
    let job = match job::compile(&script, &Same(&file)) {
        Ok(job) => job,
        Err(found) => {
            assert!(!found.is_empty(), "refused for no reason");
            let lines = script.lines().count().max(1) as u32;
            for one in &found {
                assert!(!one.message.trim().is_empty(), "{one:?}");
                assert!(one.line >= 1 && one.line <= lines + 1 && one.column >= 1, "{one:?} of {lines} lines");
            }
            return;
        }
    };
    for step in &job.steps {
        assert!(script.get(step.span.clone()).is_some() && step.line >= 1, "{step:?}");
    }
    let mut memory = Memory::new(Config::default());
    let mut bench = Bench::new(&mut memory, Line::CLEAN);
    bench.open();
    let mut started = false;
    for (number, step) in job.steps.iter().take(CALLS).enumerate() {
        let lane = |may_fail: bool| if may_fail { Lane::ProgramMayFail } else { Lane::Program };
        match &step.action {
            Action::Sleep { ns } => {
                bench.send(Sleep::OPCODE, Lane::Program, Sleep { ns: (*ns).into() }.as_bytes().to_vec(), None)
            }
            Action::WaitStop { core, axes, crds } => {
                let wait =
                    WaitStop { core: (*core).into(), axes: axes.cast_signed().into(), crds: crds.cast_signed().into() };
                bench.send(WaitStop::OPCODE, Lane::Program, wait.as_bytes().to_vec(), None);
            }
            Action::WaitAll => {}
            Action::Call(call) => bench.send(call.opcode, lane(call.may_fail), call.body.clone(), None),
        }
        // The queue takes so many before it runs.
        if number == 100 {
            bench.send(ProgramStart::OPCODE, Lane::Immediate, vec![0], None);
            started = true;
        }
        if number % 16 == 15 {
            bench.ticks(8);
        }
    }
    bench.send(ProgramEnd::OPCODE, Lane::Program, Vec::new(), None);
    if !started {
        bench.ticks(4);
        bench.send(ProgramStart::OPCODE, Lane::Immediate, vec![0], None);
    }
    bench.ticks(TICKS);
    bench.settle();
}
