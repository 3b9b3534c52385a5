//! Calls of a line as entries of the path.
//!
//! In: calls in the notation of jobs, as `gcode` writes them. Out: what travels to the controller,
//! and what the feeder must know of it.
use client::Call;
use job::quick::Quick;
use job::{Action, Files};
use protocol::command::opcode;

/// What an entry is, as far as light at a standstill is concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A motion, or a dwell.
    Motion,
    /// A power or a follow.
    Power,
    /// The laser is on from here on.
    On,
    /// The laser is off from here on.
    Off,
    /// An output.
    Output,
}

/// An entry of the path.
#[derive(Debug, Clone)]
pub struct Entry {
    /// What is sent.
    pub call: Call,
    /// What it is.
    pub kind: Kind,
    /// The factor of F that it was planned with, %.
    pub planned: u8,
    /// It came from the sender, and counts as its own.
    pub counts: bool,
}

struct Nowhere;

impl Files for Nowhere {
    fn text(&self, path: &str) -> Result<String, String> {
        Err(format!("{path}: lines of a sender name no files"))
    }
}

/// Calls in the notation of jobs, packed.
///
/// # Errors
/// A call that is none; `gcode` writes none such.
pub fn calls(text: &str) -> Result<Vec<Call>, String> {
    let job = job::compile(text, &Nowhere)
        .map_err(|found| found.first().map_or_else(String::new, |first| first.message.clone()))?;
    let call = |action| match action {
        Action::Call(call) => Some(Call { opcode: call.opcode, payload: call.body, may_fail: false }),
        _ => None,
    };
    Ok(job.steps.into_iter().filter_map(|step| call(step.action)).collect())
}

/// The calls that most lines are made of, packed without the language around them.
fn quick(text: &str) -> Option<Call> {
    let Quick { opcode, body, .. } = job::quick::call(text)?;
    Some(Call { opcode, payload: body.to_vec(), may_fail: false })
}

/// The entries of a line.
///
/// # Errors
/// As [`calls`].
pub fn entries(text: &str, planned: u8) -> Result<Vec<Entry>, String> {
    if text.is_empty() {
        return Ok(Vec::new());
    }
    let entry = |call: Call| {
        let kind = match call.opcode {
            opcode::BufLaserOn => Kind::On,
            opcode::BufLaserOff => Kind::Off,
            opcode::BufDoBit => Kind::Output,
            code if code >> 8 == opcode::BufLaserOn >> 8 => Kind::Power,
            _ => Kind::Motion,
        };
        Entry { call, kind, planned, counts: true }
    };
    let found: Option<Vec<Call>> = text.lines().map(quick).collect();
    Ok(found.map_or_else(|| calls(text), Ok)?.into_iter().map(entry).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_of_a_line_become_entries() {
        let text = "GT_BufLaserFollowRatio(1, 40, 0, 60, 0, 0);\nGT_BufLaserOn(1, 0, 0);\n\
                    GT_LnXY(1, 5, -6, 1.5, 0.05); // 7\nGT_BufDelay(1, 20);\nGT_BufDoBit(1, 12, 3, 1);\n\
                    GT_BufLaserOff(1, 0, 0);\n";
        let kinds: Vec<Kind> = entries(text, 100).unwrap().into_iter().map(|entry| entry.kind).collect();
        assert_eq!(kinds, [Kind::Power, Kind::On, Kind::Motion, Kind::Motion, Kind::Output, Kind::Off]);
        assert!(entries("GT_LnXY(1, 5", 100).is_err());
        assert!(entries("", 100).unwrap().is_empty());
    }

    #[test]
    fn what_is_packed_quickly_is_what_the_compiler_packs() {
        for text in [
            "GT_LnXY(1, 5, -600000, 1.5, 0.05); // 7",
            "GT_LnXYZ(1, 5, -6, 2000000000, 0.00000000000123, 12345.678);",
            "GT_BufLaserPrfCmd(1, 33.3, 0, 1);",
            "GT_BufLaserOn(1, 0, 1);",
            "GT_BufLaserOff(1, 0, 1);",
            "GT_BufLaserFollowRatio(1, 40.25, 0, 60, 0, 1);",
        ] {
            assert_eq!(vec![quick(text).unwrap()], calls(text).unwrap(), "{text}");
        }
        assert_eq!(quick("GT_BufDelay(1, 20);"), None);
        assert_eq!(quick("GT_LnXY(1, 5"), None);
    }

    /// What a line costs is far below what 20,000 lines a second allow.
    #[test]
    fn many_lines_are_compiled() {
        let began = std::time::Instant::now();
        for k in 0..20_000 {
            let text = format!("GT_BufLaserPrfCmd(1, {}, 0, 0);\nGT_LnXY(1, {k}, 0, 12.345, 0.05); // 0\n", k % 100);
            assert_eq!(entries(&text, 100).unwrap().len(), 2);
        }
        println!("20,000 lines in {:?}", began.elapsed());
    }
}
