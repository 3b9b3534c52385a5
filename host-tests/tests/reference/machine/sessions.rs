//! A program with SetTicks is several programs: none may hold one.
use super::{Rig, wire};
use client::{Answer, Observer};
use host_tests::reference::{Call, Session};
use std::time::Duration;

struct Kept(Vec<Answer>);

impl Observer for Kept {
    fn answered(&mut self, answer: Answer) -> client::Result<()> {
        self.0.push(answer);
        Ok(())
    }
}

/// What the programs gave.
pub struct Ran {
    pub answers: Vec<Answer>,
    /// Entries whose tick had passed.
    pub late: u32,
    /// Controller time of the first program's zero, ns.
    pub zero: u64,
    /// Of each SetTick when it was sent and answered, and the next program's zero; its period, ns.
    between: Vec<([u64; 3], i64)>,
}

impl Ran {
    /// With the instants of the rows, from the first program's zero on.
    pub fn sessions(&self, times: &[i64]) -> Vec<Session> {
        let ns = |at: u64| at as i64 - self.zero as i64;
        let session = |&([asked, answered, zero], period): &([u64; 3], i64)| {
            let from = times.partition_point(|at| *at < ns(asked));
            // Where no program follows, the answer is there before the tick that it acts on.
            let until = times.partition_point(|at| *at <= ns(zero)) + 1;
            let step = |at: usize| times[at] - times[at - 1];
            let change = |at: &usize| step(*at) != step(*at + 1) && step(*at + 1) == period;
            let acted = (from.max(1)..until.min(times.len().saturating_sub(1))).find(change).map(|at| times[at]);
            Session { asked: ns(asked), answered: ns(answered), acted, zero: ns(zero) }
        };
        self.between.iter().map(session).collect()
    }
}

/// Runs the calls, a program for those up to the next SetTick.
pub fn run(rig: &mut Rig, calls: &[Call]) -> Result<Ran, String> {
    let is_tick = |call: &Call| matches!(call, Call::SetTick { .. });
    let mut ran = Ran { answers: Vec::new(), late: 0, zero: 0, between: Vec::new() };
    let mut ticks = calls.iter().filter(|call| is_tick(call));
    if calls.first().is_none_or(is_tick) {
        // A tick to begin from.
        rig.client.sleep(Duration::from_millis(2)).map_err(|error| format!("{error:?}"))?;
    }
    for (number, piece) in calls.split(is_tick).enumerate() {
        let mut zero = rig.board.lock().unwrap().now();
        if !piece.is_empty() {
            let mut all: Vec<client::Call> = piece.iter().map(|call| wire(&rig.setup, call)).collect();
            all.iter_mut().for_each(|call| call.may_fail = true);
            let mut kept = Kept(Vec::new());
            let summary = rig.client.run(all, false, &mut kept).map_err(|error| format!("{error:?}"))?;
            if let Some(failed) = summary.failed {
                return Err(format!("entry {}: {} {:?}", failed.index, failed.code, failed.error));
            }
            ran.late += summary.progress.queue.late.get();
            ran.answers.append(&mut kept.0);
            zero = rig.board.lock().unwrap().program_zero_ns();
        }
        match number.checked_sub(1) {
            None => ran.zero = zero,
            Some(before) => ran.between[before].0[2] = zero,
        }
        if let Some(call) = ticks.next() {
            let period = if let Call::SetTick { us } = call { i64::from(*us) * 1000 } else { 0 };
            let asked = rig.board.lock().unwrap().now();
            let call = wire(&rig.setup, call);
            let (code, error, reply) = match rig.client.call_raw(&call) {
                Ok(reply) => (0, None, reply),
                Err(error) if error.code > 0 => (error.code, Some(error), Vec::new()),
                Err(error) => return Err(format!("{error:?}")),
            };
            ran.answers.push(Answer { index: 0, opcode: call.opcode, code, error, reply });
            let answered = rig.board.lock().unwrap().now();
            ran.between.push(([asked, answered, 0], period));
        }
    }
    Ok(ran)
}
