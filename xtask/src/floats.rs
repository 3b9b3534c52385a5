//! Whether the tick leaves the floating-point unit alone.
//!
//! In: the reference board's image. Out: how many of its functions use the unit. Owns nothing.
//! Fails: with the first function of the tick that uses it. Such a tick would save and restore the
//! unit's registers in each interrupt, and would depend on roundings without a proof. `servo` has
//! no float in its source; this checks the compiler's output.
use crate::shell::Outcome;
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

/// What the names of the tick's functions hold: those of the crate `servo`, and the interrupt
/// itself.
const TICK: [&str; 3] = ["5servo", "servo..", "TIM2"];

/// Prints how many functions use the unit, and that none of the tick does.
pub fn check(elf: &[u8]) -> Outcome {
    let file = object::File::parse(elf).map_err(|e| format!("the image: {e}"))?;
    let (mut of_tick, mut others, mut users) = (0, 0, 0);
    let mut marks: Vec<(u64, bool)> =
        file.symbols().filter_map(|s| Some((s.address(), begins_code(s.name().ok()?)?))).collect();
    marks.sort_unstable();
    for symbol in file.symbols().filter(|s| s.kind() == SymbolKind::Text && s.size() > 0) {
        let (name, from) = (symbol.name().unwrap_or_default(), symbol.address() & !1);
        let Some(section) = symbol.section_index().and_then(|index| file.section_by_index(index).ok()) else {
            continue;
        };
        let Ok(Some(code)) = section.data_range(from, symbol.size()) else { continue };
        let uses = uses_floats(code, from, &marks);
        if is_of_tick(name) {
            if uses {
                return Err(format!("{name} is of the tick and uses the floating-point unit"));
            }
            of_tick += 1;
        } else {
            others += 1;
            users += u32::from(uses);
        }
    }
    if of_tick == 0 || users == 0 {
        return Err(format!(
            "{of_tick} functions of the tick, {users} others with floating point: the search is wrong"
        ));
    }
    println!("floating point: in none of {of_tick} functions of the tick, in {users} of {others} others");
    Ok(())
}

/// The constructors of types of `servo` that the thread inlines keep their own names; what is
/// generic over both is named after where it was written.
fn is_of_tick(name: &str) -> bool {
    TICK.iter().any(|part| name.contains(part)) && !name.contains("10dispatcher") && !name.contains("dispatcher..")
}

/// A mapping symbol of the Arm ELF: instructions from here on, or data. `None`: another symbol.
fn begins_code(name: &str) -> Option<bool> {
    match name.split('.').next() {
        Some("$t") => Some(true),
        Some("$d") => Some(false),
        _ => None,
    }
}

/// Whether instructions of the unit are among those from `at` on (Armv7-M Architecture Reference
/// Manual, A5.3.18 and A6: coprocessors 10 and 11).
fn uses_floats(code: &[u8], at: u64, marks: &[(u64, bool)]) -> bool {
    let half = |offset: usize| Some(u16::from_le_bytes([*code.get(offset)?, *code.get(offset + 1)?]));
    let mut offset = 0;
    while let Some(first) = half(offset) {
        let place = at + offset as u64;
        let before = marks.partition_point(|(address, _)| *address <= place);
        if before > 0 && !marks[before - 1].1 {
            offset += 2;
            continue;
        }
        let is_wide = first >> 11 >= 0b11101;
        if is_wide && first & 0xec00 == 0xec00 && half(offset + 2).is_some_and(|second| second >> 9 & 7 == 0b101) {
            return true;
        }
        offset += if is_wide { 4 } else { 2 };
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instructions_of_the_unit_are_known_from_others_and_from_data() {
        // vmul.f64 d0, d0, d1; then nop, and add.w r0, r0, r1.
        let multiply = [0x20, 0xee, 0x01, 0x0b];
        let integer = [0x00, 0xbf, 0x00, 0xeb, 0x01, 0x00];
        assert!(uses_floats(&multiply, 0x100, &[]));
        assert!(uses_floats(&[&integer[..], &multiply].concat(), 0x100, &[(0x100, true)]));
        assert!(!uses_floats(&integer, 0x100, &[(0x100, true)]));
        assert!(!uses_floats(&[&integer[..], &multiply].concat(), 0x100, &[(0x100, true), (0x106, false)]));
    }

    #[test]
    fn names_of_the_tick_are_those_of_servo() {
        assert!(is_of_tick("_ZN5servo4axis5glide5go_on17hE") && is_of_tick("TIM2"));
        assert!(!is_of_tick("_ZN10dispatcher9lookahead6bounds17hE") && !is_of_tick("_ZN4libm4math3cos17hE"));
    }
}
