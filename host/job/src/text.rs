//! The bytes of a file that people write to text: UTF-8, UTF-16 with or without its mark, GBK.
//!
//! In: bytes. Out: text, its line ends as they are. Fails with the line at which no encoding fits.

use encoding_rs::{Encoding, GB18030, UTF_16BE, UTF_16LE};

/// Bytes that are looked at for UTF-16 without a mark.
const SNIFFED_BYTES: usize = 512;

/// The text of `bytes`.
///
/// # Errors
/// The line, from 1, whose bytes are neither UTF-8 nor GBK, or no UTF-16.
pub fn decode(bytes: Vec<u8>) -> Result<String, usize> {
    if let Some(wide) = wide(&bytes) {
        return decoded(wide, &bytes);
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(text),
        // GB18030 holds all of GBK. Nearly any bytes are some text in it, so it comes last.
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let bytes = error.as_bytes();
            decoded(GB18030, bytes).map_err(|_| line_of(bytes, at))
        }
    }
}

fn line_of(bytes: &[u8], at: usize) -> usize {
    bytes.get(..at).unwrap_or(bytes).iter().filter(|byte| **byte == b'\n').count() + 1
}

fn decoded(encoding: &'static Encoding, bytes: &[u8]) -> Result<String, usize> {
    let (text, wrong) = encoding.decode_with_bom_removal(bytes);
    // A NUL is no text; a file of them is none in any encoding.
    match wrong || (encoding == GB18030 && text.contains('\0')) {
        true => {
            let before = text.split('\u{fffd}').next().unwrap_or_default();
            Err(before.matches('\n').count() + 1)
        }
        false => Ok(text.into_owned()),
    }
}

/// UTF-16 by its mark, or because every second byte of ASCII is 0.
fn wide(bytes: &[u8]) -> Option<&'static Encoding> {
    match bytes {
        [0xff, 0xfe, ..] => return Some(UTF_16LE),
        [0xfe, 0xff, ..] => return Some(UTF_16BE),
        _ => {}
    }
    let pairs = bytes.get(..SNIFFED_BYTES.min(bytes.len() & !1))?.as_chunks::<2>().0;
    let (mut low, mut high) = (0, 0);
    for pair in pairs {
        match pair {
            [0, 0] => return None,
            [_, 0] => low += 1,
            [0, _] => high += 1,
            _ => {}
        }
    }
    // Comments may be Chinese, the statements are ASCII; a character such as U+5F00 has its own 0.
    let most = |count: usize, other: usize| count > 1 && count * 4 >= pairs.len() && count > 4 * other;
    match (low, high) {
        _ if most(low, high) => Some(UTF_16LE),
        _ if most(high, low) => Some(UTF_16BE),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "GT_Open(); // 打开运动控制器\r\nGT_AxisOn(1);\r\n";

    fn utf16(text: &str, big: bool, mark: bool) -> Vec<u8> {
        let units = mark.then_some(0xfeff).into_iter().chain(text.encode_utf16());
        units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect()
    }

    #[test]
    fn every_encoding_is_the_same_text() {
        for (big, mark) in [(false, true), (true, true), (false, false), (true, false)] {
            assert_eq!(decode(utf16(TEXT, big, mark)).unwrap(), TEXT, "{big} {mark}");
        }
        assert_eq!(decode(TEXT.as_bytes().to_vec()).unwrap(), TEXT);
        // By hand: 打开 in GBK.
        assert_eq!(decode(b"// \xb4\xf2\xbf\xaa\n".to_vec()).unwrap(), "// 打开\n");
    }

    #[test]
    fn what_is_no_text_has_a_line() {
        assert_eq!(decode(b"GT_Open();\n\nGT_\xff\xff();\n".to_vec()), Err(3));
        assert_eq!(decode(b"one\n\xff\0\0\0".to_vec()), Err(2));
        assert_eq!(decode(vec![0; 10_000]).unwrap().len(), 10_000);
        // An odd byte at the end of UTF-16.
        assert!(decode([utf16("a\nb\n", false, true), vec![7]].concat()).is_err());
    }
}
