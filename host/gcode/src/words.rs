//! A line of a program to its words.
//!
//! In: a line. Out: letters with exact numbers, without blanks and comments. Fails with what is no
//! word.
use strokes::exact::{DECIMALS, MAX_WHOLE_DIGITS};

/// A letter and its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Word {
    /// Upper case.
    pub letter: u8,
    /// In 10⁻¹⁵.
    pub number: i128,
}

/// What is wrong with a text that begins with a letter beyond ASCII.
fn foreign(text: &str) -> String {
    match text.chars().next() {
        // What was no text has become this letter.
        None | Some('\u{fffd}') => "what is not UTF-8 text is no G-code; save the file as UTF-8".to_owned(),
        Some(letter) => format!("`{}` is no G-code", letter.escape_debug()),
    }
}

/// Reads a line; `bare` and `found` are overwritten.
///
/// # Errors
/// What is wrong with it.
pub fn read(line: &str, bare: &mut Vec<u8>, found: &mut Vec<Word>) -> Result<(), String> {
    bare.clear();
    found.clear();
    let mut comment = false;
    for (at, byte) in line.bytes().enumerate() {
        match byte {
            _ if comment => comment = byte != b')',
            b'(' => comment = true,
            b')' => return Err("`)` without `(`".to_owned()),
            b';' => break,
            b' ' | b'\t' | b'\r' => {}
            0x20..=0x7e => bare.push(byte.to_ascii_uppercase()),
            0..=0x7f => return Err(format!("the byte {byte:#04x} is no G-code; the file may be no text")),
            _ => return Err(foreign(line.get(at..).unwrap_or(""))),
        }
    }
    if comment {
        return Err("a comment is not closed: `)` is missing".to_owned());
    }
    let (mut at, mut before) = (0, 0);
    // A block that may be deleted is run: the switch is off.
    if bare.first() == Some(&b'/') {
        at = 1;
    }
    while let Some(&letter) = bare.get(at) {
        match letter {
            b'A'..=b'Z' => {}
            b'#' | b'[' | b'=' | b'<' => return Err("variables and expressions are not supported".to_owned()),
            other => return Err(format!("`{}` is no word: a letter and a number", char::from(other))),
        }
        if letter == b'O' {
            return Err(format!("`{}`: O words are not supported", shown(&bare[before..])));
        }
        before = at;
        let begin = at + 1;
        at = begin;
        while bare.get(at).is_some_and(|byte| byte.is_ascii_digit() || b"+-.".contains(byte)) {
            at += 1;
        }
        let number = number(&bare[begin..at]).map_err(|why| format!("`{}`: {why}", shown(&bare[begin - 1..])))?;
        found.push(Word { letter, number });
    }
    Ok(())
}

/// The beginning of a text, for a message.
fn shown(text: &[u8]) -> String {
    text.iter().take(24).map(|byte| char::from(*byte)).collect()
}

fn number(text: &[u8]) -> Result<i128, &'static str> {
    let (negative, digits) = match text.first() {
        Some(b'-') => (true, &text[1..]),
        Some(b'+') => (false, &text[1..]),
        _ => (false, text),
    };
    let (mut value, mut whole, mut decimals, mut point, mut up) = (0i128, 0usize, 0u32, false, false);
    for &byte in digits {
        match byte {
            b'.' if !point => point = true,
            b'0'..=b'9' => {
                let digit = i128::from(byte - b'0');
                if !point {
                    whole += usize::from(value != 0 || digit != 0);
                    if whole > MAX_WHOLE_DIGITS {
                        return Err("a number has at most 9 digits before the point");
                    }
                    value = value * 10 + digit;
                } else if decimals < DECIMALS {
                    value = value * 10 + digit;
                    decimals += 1;
                } else if decimals == DECIMALS {
                    up = digit >= 5;
                    decimals += 1;
                }
            }
            _ => return Err("a letter must have one number"),
        }
    }
    if digits.iter().all(|byte| !byte.is_ascii_digit()) {
        return Err("a letter must have a number");
    }
    let value = value * 10i128.pow(DECIMALS.saturating_sub(decimals)) + i128::from(up);
    Ok(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;
    use strokes::exact::ONE;

    fn words(line: &str) -> Result<Vec<(char, i128)>, String> {
        let (mut bare, mut found) = (Vec::new(), Vec::new());
        read(line, &mut bare, &mut found)?;
        Ok(found.iter().map(|word| (char::from(word.letter), word.number)).collect())
    }

    #[test]
    fn words_are_letters_with_exact_numbers() {
        let found = words("n10 g1 x-1 2.5 (a (nested) y+.25 ; the rest");
        assert_eq!(found.unwrap(), [('N', 10 * ONE), ('G', ONE), ('X', -25 * ONE / 2), ('Y', ONE / 4)]);
        assert_eq!(words("X0.0000000000000005").unwrap(), [('X', 1)]);
        assert_eq!(words("X0.00000000000000049").unwrap(), [('X', 0)]);
        assert_eq!(words("(all) ; of it").unwrap(), []);
    }

    #[test]
    fn what_is_no_word_is_refused() {
        for (line, says) in [
            ("G1 XNAN", "must have a number"),
            ("X1.2.3", "must have one number"),
            ("X1-2", "must have one number"),
            ("X", "must have a number"),
            ("X.", "must have a number"),
            ("X1234567890", "at most 9 digits"),
            ("#1=2", "variables"),
            ("X[1+2]", "must have a number"),
            ("O100 call", "`O100CALL`: O words"),
            ("X1 Y1O", "`Y1O`: O words are not supported"),
            ("X1 (open", "not closed"),
            ("X1) Y2", "without `(`"),
            ("X1\u{7f}", "the byte 0x7f is no G-code"),
            ("X1 \u{e9}", "`\u{e9}` is no G-code"),
            ("X1 \u{fffd}", "what is not UTF-8 text is no G-code"),
            ("12", "is no word"),
        ] {
            let error = words(line).unwrap_err();
            assert!(error.contains(says), "{line}: {error}");
        }
    }
}
