//! The calls that paths of programs and drawings are made of, compiled without the language around
//! them: a name and plain numbers on a line of their own.
//!
//! In: a line as `strokes` writes it. Out: what [`crate::compile`] makes of it, or none: then it is
//! for the compiler. A number that is written in any other manner is none.
use crate::{Action, Call, Step};
use protocol::command::{BufLaserFollowRatio, BufLaserOff, BufLaserOn, BufLaserPrfCmd, LnXY, LnXYZ, Request};

/// The longest request of such a line, bytes.
const BODY_MAX_BYTES: usize = size_of::<LnXYZ>();

/// A call of such a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Quick<'t> {
    /// The statement.
    pub text: &'t str,
    /// The function with its prefix.
    pub function: &'static str,
    /// Number on the wire.
    pub opcode: u16,
    /// The packed request.
    pub body: heapless::Vec<u8, BODY_MAX_BYTES>,
    /// Laser channels that it sets something of, a bit each.
    pub lasers: u8,
}

impl Quick<'_> {
    /// The step of line `line` of a script, in which the line begins at this byte.
    pub fn step(self, line: u32, at: usize) -> Step {
        let Quick { text, function, opcode, body, .. } = self;
        let (function, body) = (function.into(), body.to_vec());
        let call = Call { function, opcode, body, outs: Vec::new(), may_fail: false };
        let span = at..at + text.len();
        Step { line, column: 1, span, action: Action::Call(call) }
    }
}

/// A number as digits, without a zero in front, which C reads as octal; whether it is whole.
fn digits(text: &str) -> Option<bool> {
    let plain = text.as_bytes();
    let plain = plain.strip_prefix(b"-").unwrap_or(plain);
    let whole = plain.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let is_whole = match plain.get(whole..)? {
        [] => true,
        [b'.', part @ ..] if !part.is_empty() && part.iter().all(u8::is_ascii_digit) => false,
        _ => return None,
    };
    let octal = whole > 1 && plain.first() == Some(&b'0');
    (whole > 0 && !octal).then_some(is_whole)
}

fn real(text: &str) -> Option<f64> {
    digits(text)?;
    text.parse().ok()
}

fn whole<T: std::str::FromStr>(text: &str) -> Option<T> {
    if digits(text)? { text.parse().ok() } else { None }
}

/// The statement of a line, its function and its parameters, apart by a comma and a blank. One walk
/// over its bytes.
fn parts(line: &str) -> Option<(&str, &str, [&str; 6], usize)> {
    let open = line.bytes().position(|byte| byte == b'(')?;
    let (mut given, mut count, mut from) = ([""; 6], 0, open + 1);
    for (at, byte) in line.bytes().enumerate().skip(from) {
        if byte != b',' && byte != b')' {
            continue;
        }
        *given.get_mut(count)? = line.get(from..at)?;
        count += 1;
        match line.as_bytes().get(at + 1)? {
            b' ' if byte == b',' => from = at + 2,
            b';' if byte == b')' => return Some((line.get(..at + 2)?, line.get(..open)?, given, count)),
            _ => return None,
        }
    }
    None
}

/// The call of a line; a comment may follow it.
pub fn call(line: &str) -> Option<Quick<'_>> {
    let (statement, function, given, count) = parts(line)?;
    let rest = line.get(statement.len()..)?.trim_end();
    if !(rest.is_empty() || rest.starts_with(" // ") && !rest.ends_with('\\')) {
        return None;
    }
    let [crd, a, b, c, d, e] = given;
    let core = 1.into();
    let crd = whole::<i16>(crd)?.into();
    let short = |text: &str| whole::<i16>(text);
    let long = |text: &str| whole::<i32>(text).map(Into::into);
    let number = |text: &str| real(text).map(Into::into);
    let mut lasers = 0;
    let mut channel = |text: &str| {
        let channel = short(text)?;
        lasers = match channel {
            0..=1 => 1 << channel,
            _ => 0,
        };
        Some(channel.into())
    };
    fn packed<R: Request>(
        function: &'static str,
        request: R,
    ) -> Option<(&'static str, u16, heapless::Vec<u8, BODY_MAX_BYTES>)> {
        Some((function, R::OPCODE, heapless::Vec::from_slice(request.as_bytes()).ok()?))
    }
    let (function, opcode, body) = match (function, count) {
        ("GT_LnXY", 5) => {
            let (x, y, syn_vel, syn_acc) = (long(a)?, long(b)?, number(c)?, number(d)?);
            packed("GT_LnXY", LnXY { core, crd, x, y, syn_vel, syn_acc, vel_end: 0.0.into(), fifo: 0.into() })
        }
        ("GT_LnXYZ", 6) => {
            let (x, y, z, syn_vel, syn_acc) = (long(a)?, long(b)?, long(c)?, number(d)?, number(e)?);
            packed("GT_LnXYZ", LnXYZ { core, crd, x, y, z, syn_vel, syn_acc, vel_end: 0.0.into(), fifo: 0.into() })
        }
        ("GT_BufLaserPrfCmd", 4) => {
            let (power, fifo, channel) = (number(a)?, short(b)?.into(), channel(c)?);
            packed("GT_BufLaserPrfCmd", BufLaserPrfCmd { core, crd, power, fifo, channel })
        }
        ("GT_BufLaserOn", 3) => {
            packed("GT_BufLaserOn", BufLaserOn { core, crd, fifo: short(a)?.into(), channel: channel(b)? })
        }
        ("GT_BufLaserOff", 3) => {
            packed("GT_BufLaserOff", BufLaserOff { core, crd, fifo: short(a)?.into(), channel: channel(b)? })
        }
        ("GT_BufLaserFollowRatio", 6) => {
            let (ratio, min, max, fifo) = (number(a)?, number(b)?, number(c)?, short(d)?.into());
            packed(
                "GT_BufLaserFollowRatio",
                BufLaserFollowRatio { core, crd, ratio, min, max, fifo, channel: channel(e)? },
            )
        }
        _ => return None,
    }?;
    Some(Quick { text: statement, function, opcode, body, lasers })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Files, compile};

    struct Nowhere;

    impl Files for Nowhere {
        fn text(&self, path: &str) -> Result<String, String> {
            Err(path.to_owned())
        }
    }

    #[test]
    fn a_quick_line_is_what_the_compiler_makes_of_it() {
        for text in [
            "GT_LnXY(1, 5, -600000, 1.5, 0.05); // 7",
            "GT_LnXYZ(1, 5, -6, 2000000000, 0.00000000000123, 12345.678);",
            "GT_BufLaserPrfCmd(1, 33.3, 0, 1);",
            "GT_BufLaserOn(1, 0, 1); // 12",
            "GT_BufLaserOff(2, 1, 0);",
            "GT_BufLaserFollowRatio(1, 57.99999999999999, 0, 60, 0, 1);",
        ] {
            let job = compile(text, &Nowhere).unwrap();
            let quick = call(text).unwrap();
            assert_eq!(quick.lasers, job.lasers, "{text}");
            assert_eq!(vec![quick.step(1, 0)], job.steps, "{text}");
            assert!(job.warnings.is_empty() && job.axes.is_empty() && job.crds.is_empty(), "{text}");
        }
    }

    #[test]
    fn other_lines_are_for_the_compiler() {
        for text in [
            "",
            "GT_LnXY(1, 5",
            "GT_BufDelay(1, 20);",
            "GT_LnXY(1, 5.5, 0, 50, 2);",
            "GT_LnXY(1, 010, 0, 50, 2);",
            "GT_LnXY(1, 5, 0, 50, 2, 0);",
            "GT_LnXY(1, 3000000000, 0, 50, 2);",
            "GT_LnXY(1, 5, 0, 1e3, 2);",
            "GT_LnXY(1, 5, 0, inf, 2);",
            "GT_LnXY(1, x, 0, 50, 2);",
            "GT_LnXY(1, 5, 0, 50, 2); GT_LnXY(1, 6, 0, 50, 2);",
            " GT_LnXY(1, 5, 0, 50, 2);",
            "GT_LnXY(1, 5, 0, 50, 2); // goes on \\",
            "GT_LnXY(1, +5, 0, 50, 2);",
            "GT_LnXY(1, 5, 0, .5, 2);",
            "GT_LnXY(1, 5, 0, 5., 2);",
        ] {
            assert_eq!(call(text), None, "{text}");
        }
    }
}
