use super::*;
use crate::request::Number;

#[test]
fn every_function_that_reads_arrays_has_a_range_of_counts() {
    let mut seen = 0;
    for prototype in prototype::all(Form::Gtn) {
        if prototype.arguments.iter().any(|argument| matches!(argument.kind, Kind::Array(..))) {
            let prepared = Prepared::new(prototype.function.name, Form::Gtn);
            assert!(prepared.bounds().1 > 0, "{}", prepared.name());
            seen += 1;
        }
    }
    assert!(seen >= 10, "{seen}");
    // What the controller holds.
    assert_eq!(counts("PvtTable"), Some((2, servo::segment::pvt::TABLE_POINTS as i64)));
    assert_eq!(counts("SetLaserFollowTable"), Some((1, servo::laser::POINTS as i64)));
}

/// Bytes of C's memory, exactly as many; without Miri, which sees it itself, with others around
/// them that must stay.
struct Memory(Box<[u8]>, usize);

const AROUND_BYTES: usize = if cfg!(miri) { 0 } else { 16 };

impl Memory {
    fn new(values: usize, of: Scalar) -> Memory {
        let mut memory = Memory::bytes(values * size(of));
        for n in 0..values {
            // SAFETY: there is room for so many.
            unsafe { request::store(memory.address().byte_add(n * size(of)), of, Number::Int(1)) };
        }
        memory
    }
    fn bytes(length: usize) -> Memory {
        Memory(vec![0xa5; length + 2 * AROUND_BYTES].into(), length)
    }
    fn of_struct(of: Type) -> Memory {
        let (name, scalar, count) = prototype::members(of).pop().unwrap();
        let mut memory = Memory::bytes(scalar_member(of, name).1 + count * size(scalar));
        memory.0[AROUND_BYTES..AROUND_BYTES + memory.1].fill(0);
        memory
    }
    fn address(&mut self) -> *mut c_void {
        self.0[AROUND_BYTES..].as_mut_ptr().cast()
    }
    fn is_whole(&self) -> bool {
        self.0[..AROUND_BYTES].iter().chain(&self.0[AROUND_BYTES + self.1..]).all(|byte| *byte == 0xa5)
    }
}

/// Bytes of a layout on the wire.
fn bytes(layout: &[(&str, &str)]) -> usize {
    let one = |wire: &str| wire.trim_matches(char::is_alphabetic).parse::<usize>().unwrap() / 8;
    layout.iter().map(|(_, wire)| request::elements(wire)).map(|(of, count)| count * one(of)).sum()
}

/// Under Miri a byte beyond is a failure by itself.
#[test]
fn nothing_is_read_or_written_beyond_what_is_given() {
    const COUNT: usize = 2;
    let mut tried = 0;
    for form in [Form::Gtn, Form::Gt] {
        for prototype in prototype::all(form) {
            let prepared = Prepared::new(prototype.function.name, form);
            let Some(command) = prepared.command else { continue };
            // With as many as `count` says, and one more that must not be stored.
            let items = if command.reply_items.is_empty() { 0 } else { COUNT + 1 };
            let counted = prepared.count.is_some();
            let mut memories = Vec::new();
            for argument in &prototype.arguments {
                let outs = if items == 0 {
                    1
                } else if counted {
                    COUNT
                } else {
                    items
                };
                memories.push(match argument.kind {
                    Kind::Array(of, Size::Each(times)) => Memory::new(COUNT * times, of),
                    Kind::Array(of, _) if counted => Memory::new(COUNT, of),
                    // `count` has one for each way of a grid.
                    Kind::Array(of, _) => Memory::new(1, of),
                    Kind::Fixed(of, length) => Memory::new(length, of),
                    Kind::Out(of) if argument.name == "clock" => Memory::new(1, of),
                    Kind::Out(of) => Memory::new(outs, of),
                    Kind::Struct(of) | Kind::OutStruct(of) => Memory::of_struct(of),
                    _ => Memory::bytes(8),
                });
            }
            let args: Vec<Arg> = prototype
                .arguments
                .iter()
                .zip(&mut memories)
                .map(|(argument, memory)| match argument.kind {
                    Kind::Value(_) if argument.name == "count" => Arg::Int(COUNT as i64),
                    Kind::Value(Scalar::Double) => Arg::Real(1.0),
                    Kind::Value(_) => Arg::Int(1),
                    _ => Arg::Address(memory.address()),
                })
                .collect();
            let reply = vec![0; bytes(command.reply) + items * bytes(command.reply_items)];
            // SAFETY: every address is that of as much as the function takes.
            let (asked, stored) = unsafe { (prepared.given(&args), prepared.store(&args, &reply, 0)) };
            let asked = asked.and_then(|given| prepared.requests(1, &args, given));
            assert!(asked.is_ok_and(|calls| !calls.is_empty()), "{}", prepared.name());
            assert_eq!(stored.ok(), Some(if counted { items.min(COUNT) } else { items }), "{}", prepared.name());
            assert!(memories.iter().all(Memory::is_whole), "{}", prepared.name());
            tried += 1;
        }
    }
    assert!(tried > 150, "{tried}");
}
