//! Which part of the tick takes how many instructions of SPEC 11's tick.
//!
//! In: the probe `crds`, which calls `worst_tick_comes` before such a tick. Out: how many of its
//! instructions each part of the tick takes. The emulator executes them one by one, commanded by
//! the protocol of debuggers. An instruction belongs to the innermost function inlined there that
//! has a share by its name or its file ([`share`]). Products and copies have none: they belong to
//! their caller. Fails: with a reason, if the emulator does not answer or the probe's file lacks a
//! symbol.
use crate::setup::QEMU;
use crate::shell::{Outcome, program};
use addr2line::Context;
use addr2line::gimli::{Dwarf, EndianSlice, Error, LittleEndian, SectionId};
use object::{Object, ObjectSection, ObjectSymbol};
use std::collections::HashMap;
use std::io::{BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

/// More instructions than any tick has.
const MAX_INSTRUCTIONS: usize = 100_000;
/// Registers as debuggers number them.
const LINK: u32 = 14;
const PROGRAM_COUNTER: u32 = 15;

/// A part of the tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Share {
    /// Positions of axes.
    Axes,
    /// Positions, speeds and boundaries of paths.
    Crds,
    /// Powers, and the actions that the timers get.
    Lasers,
    /// Data prepared for later ticks.
    Planning,
    /// Inputs and encoders, and whether they have changed.
    Sampling,
    /// What the thread may read.
    Reporting,
    /// Set-points and outputs for the machine.
    Output,
    /// The remainder: due operations, order of axes and paths, calls between parts.
    Scheduling,
}

/// The order of the table, and its words.
pub const SHARES: [(Share, &str); 8] = [
    (Share::Axes, "evaluators: eight axes, each enters a piece"),
    (Share::Crds, "evaluators: two paths, each enters a motion, and their four axes"),
    (Share::Lasers, "evaluators: two lasers"),
    (Share::Planning, "planning"),
    (Share::Sampling, "sampling of inputs of 12 axes"),
    (Share::Reporting, "reporting: the view"),
    (Share::Output, "output to the machine, which here only stores it"),
    (Share::Scheduling, "scheduling: due operations, order of axes and paths"),
];

/// The share of a function, if it or its file has one.
fn share(file: &str, name: &str) -> Option<Share> {
    let of = |words: &[&str]| words.iter().any(|word| file.contains(word));
    let named = |words: &[&str]| words.iter().any(|word| name.contains(word));
    Some(if of(&["servo/src/view", "ring/src/latest"]) || named(&["publish", "publish_pass"]) {
        Share::Reporting
    } else if of(&[
        "servo/src/axis/input_scan",
        "servo/src/axis/inputs",
        "servo/src/axis/following_error",
        "servo/src/axis/in_position",
    ]) {
        Share::Sampling
    } else if of(&["servo/src/axis/user_position", "probes/chip/src/machine"]) {
        if named(&["6inputs", "7encoder"]) { Share::Sampling } else { Share::Output }
    } else if of(&[
        "servo/src/segment/pvt",
        "servo/src/tables",
        "servo/src/segment/pt",
        "servo/src/segment/ramp",
        "path/speed_profile",
        "path/evaluator/prepared_start",
        "path/evaluator/motions",
    ]) || named(&["13prepare_start", "7prepare", "10look_ahead"])
    {
        Share::Planning
    } else if of(&["servo/src/laser"]) {
        Share::Lasers
    } else if of(&["servo/src/tick/crd", "servo/src/path", "servo/src/axis/crd_member"]) {
        Share::Crds
    } else if of(&["servo/src/axis", "servo/src/segment/profile"]) {
        Share::Axes
    } else if of(&["servo/src/", "ring/src/", "probes/"])
        && !of(&["servo/src/segment/piece", "servo/src/math/wide", "servo/src/math/float", "servo/src/units"])
    {
        Share::Scheduling
    } else {
        return None;
    })
}

/// The instructions of each share, in the order of [`SHARES`].
pub fn count(image: &Path) -> Outcome<Vec<usize>> {
    let bytes = std::fs::read(image).map_err(|e| format!("{}: {e}", image.display()))?;
    let file = object::File::parse(&*bytes).map_err(|e| format!("{}: {e}", image.display()))?;
    let code = |function: &str| {
        let found = file.symbols().find(|symbol| symbol.name().is_ok_and(|name| name.contains(function)));
        found.map(|symbol| symbol.address() & !1).ok_or_else(|| format!("{}: no {function}", image.display()))
    };
    let addresses = addresses(image, code("worst_tick_comes")?, code("counted_tick")?)?;
    let load = |section: SectionId| -> Result<_, Error> {
        let data = file.section_by_name(section.name()).and_then(|section| section.data().ok());
        Ok(EndianSlice::new(data.unwrap_or_default(), LittleEndian))
    };
    let lines = Dwarf::load(load).and_then(Context::from_dwarf).map_err(|e| format!("{}: {e}", image.display()))?;
    let (mut known, mut last) = (HashMap::new(), Share::Scheduling);
    let mut counts = vec![0; SHARES.len()];
    for address in addresses {
        let found = known.entry(address).or_insert_with(|| owner(&lines, address));
        last = found.unwrap_or(last);
        if let Some(count) = SHARES.iter().zip(&mut counts).find_map(|((of, _), count)| (*of == last).then_some(count))
        {
            *count += 1;
        }
    }
    Ok(counts)
}

/// The share of the instruction at an address; none if it has no share of its own.
fn owner(lines: &Context<EndianSlice<'_, LittleEndian>>, address: u64) -> Option<Share> {
    let mut frames = lines.find_frames(address).skip_all_loads().ok()?;
    while let Ok(Some(frame)) = frames.next() {
        let file = frame.location.and_then(|location| location.file).unwrap_or_default();
        let name = frame.function.as_ref().and_then(|function| function.raw_name().ok()).unwrap_or_default();
        if let Some(found) = share(file, &name) {
            return Some(found);
        }
    }
    None
}

/// The addresses of the instructions of `tick`, once `before` was called, in their order.
fn addresses(image: &Path, before: u64, tick: u64) -> Outcome<Vec<u64>> {
    let mut debugger = Debugger::start(image)?;
    // QEMU allows reads of single registers only after a request for their names.
    debugger.ask("qSupported:xmlRegisters=arm")?;
    debugger.ask("qXfer:features:read:target.xml:0,fff")?;
    debugger.run_to(before)?;
    debugger.run_to(tick)?;
    let end = debugger.register(LINK)? & !1;
    let mut addresses = Vec::new();
    loop {
        let address = debugger.register(PROGRAM_COUNTER)?;
        if address == end {
            return Ok(addresses);
        }
        if addresses.len() == MAX_INSTRUCTIONS {
            return Err("the tick does not end".into());
        }
        addresses.push(address);
        debugger.ask("s")?;
    }
}

/// The emulator, run by the protocol of debuggers over its own pipes.
struct Debugger {
    qemu: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Debugger {
    fn start(image: &Path) -> Outcome<Debugger> {
        let mut command = program(QEMU);
        command
            .args(["-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", "null", "-chardev", "null,id=none"])
            .args(["-semihosting-config", "enable=on,target=native,chardev=none", "-gdb", "stdio", "-S", "-kernel"])
            .arg(image);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut qemu = command.spawn().map_err(|e| format!("{QEMU}: {e}"))?;
        match (qemu.stdin.take(), qemu.stdout.take()) {
            (Some(to), Some(from)) => Ok(Debugger { qemu, to, from: BufReader::new(from) }),
            _ => Err(format!("{QEMU} has no pipes")),
        }
    }

    /// Sends a packet; the answer to it.
    fn ask(&mut self, packet: &str) -> Outcome<String> {
        let sum = packet.bytes().fold(0u8, u8::wrapping_add);
        let failed = |e: std::io::Error| format!("{QEMU} answers nothing to {packet}: {e}");
        write!(self.to, "${packet}#{sum:02x}").and_then(|()| self.to.flush()).map_err(failed)?;
        let (mut answer, mut byte) = (None::<String>, [0]);
        loop {
            self.from.read_exact(&mut byte).map_err(failed)?;
            match (byte, &mut answer) {
                ([b'$'], _) => answer = Some(String::new()),
                ([b'#'], Some(answer)) => {
                    // Its checksum; a pipe does not damage bytes.
                    self.from.read_exact(&mut [0; 2]).map_err(failed)?;
                    self.to.write_all(b"+").map_err(failed)?;
                    return Ok(std::mem::take(answer));
                }
                ([byte], Some(answer)) => answer.push(byte as char),
                _ => {}
            }
        }
    }

    /// Runs until the instruction at an address is next.
    fn run_to(&mut self, address: u64) -> Outcome {
        self.ask(&format!("Z0,{address:x},2"))?;
        self.ask("c")?;
        self.ask(&format!("z0,{address:x},2"))?;
        if self.register(PROGRAM_COUNTER)? == address {
            Ok(())
        } else {
            Err("the probe does not reach its worst tick".into())
        }
    }

    fn register(&mut self, number: u32) -> Outcome<u64> {
        let answer = self.ask(&format!("p{number:x}"))?;
        let word = u32::from_str_radix(&answer, 16).map_err(|_| format!("not a register: {answer}"))?;
        Ok(u64::from(word.swap_bytes()))
    }
}

impl Drop for Debugger {
    fn drop(&mut self) {
        // The emulator is not needed any more.
        let _ = self.qemu.kill().and_then(|()| self.qemu.wait());
    }
}
