//! The lines of a board: `NAME NUMBER…*XX`, where XX is the exclusive or of all bytes before the
//! star.
//!
//! In: bytes. Out: [`Figures`]. Lines that begin with `#` are for people; the last ones are kept
//! for the reason of an early end. What comes before the line `format` is not read, but counted.
//! Fails: a damaged line, an unknown format, a count of lines that is not the one sent.
use crate::Failure;
use crate::summary::counted;
use std::collections::BTreeMap;

/// The version of the lines that is read.
const FORMAT: i64 = 2;
/// The longest line.
const LINE_MAX_BYTES: usize = 8192;
/// As much of a damaged line is quoted.
const QUOTED_CHARS: usize = 80;
/// As much of a remark: the place and the text of a panic.
const REMARK_CHARS: usize = 300;

/// The beginning of a line, for a message: without what a terminal would obey.
fn quoted(line: &str, most: usize) -> String {
    let mut text: String = line.chars().take(most).flat_map(char::escape_debug).collect();
    if line.chars().nth(most).is_some() {
        text.push('…');
    }
    text
}

/// Numbers by the names of their lines; a name may come often.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Figures(BTreeMap<String, Vec<Vec<i64>>>);

impl Figures {
    /// All lines of a name.
    pub fn all(&self, name: &str) -> &[Vec<i64>] {
        self.0.get(name).map_or(&[], Vec::as_slice)
    }

    /// The numbers of a name's only line, if it has so many.
    pub fn only<const N: usize>(&self, name: &str) -> Option<[i64; N]> {
        match self.all(name) {
            [numbers] => numbers.as_slice().try_into().ok(),
            _ => None,
        }
    }

    /// All lines of a name, if each has so many numbers and there is one.
    pub fn each<const N: usize>(&self, name: &str) -> Option<Vec<[i64; N]>> {
        let all: Option<Vec<_>> = self.all(name).iter().map(|numbers| numbers.as_slice().try_into().ok()).collect();
        all.filter(|lines: &Vec<[i64; N]>| !lines.is_empty())
    }

    /// The version of the image that answers this client, and the hash of its protocol.
    pub fn add_image_of(&mut self, client: &client::Client) {
        let version = client.version();
        let parts = [version.major, version.minor, version.patch].map(|part| i64::from(part.get()));
        self.add("image", parts.into_iter().chain([version.schema.get().into()]).collect());
    }

    /// One more line.
    pub fn add(&mut self, name: &str, numbers: Vec<i64>) {
        self.0.entry(name.to_owned()).or_default().push(numbers);
    }
}

/// See the module text.
#[derive(Debug, Default)]
pub struct Reader {
    line: Vec<u8>,
    lines: i64,
    begun: bool,
    figures: Figures,
    remark: String,
    /// A line that is none, until what comes next: a board that stops within a line says why.
    broken: Option<String>,
    /// Bytes before the first line of the run, and the first of them.
    foreign: usize,
    first: String,
}

impl Reader {
    /// The first line of the run has come.
    pub fn has_begun(&self) -> bool {
        self.begun
    }

    /// A line of this name has come.
    pub fn has_line(&self, name: &str) -> bool {
        !self.figures.all(name).is_empty()
    }

    /// What was read.
    pub fn figures(self) -> Figures {
        self.figures
    }

    /// What came before the first line of the run, if anything did: how much, and how it begins.
    pub fn foreign(&self) -> Option<(usize, String)> {
        (self.foreign > 0).then(|| (self.foreign, quoted(&self.first, QUOTED_CHARS)))
    }

    /// Lines of the run so far.
    pub fn lines(&self) -> i64 {
        self.lines
    }

    /// Why a run that began has no end.
    pub fn cut_short(&self) -> String {
        if let Some(broken) = &self.broken {
            return broken.clone();
        }
        let said = if self.remark.is_empty() {
            String::new()
        } else {
            format!("; it said: {}", quoted(&self.remark, REMARK_CHARS))
        };
        format!("the board fell silent after {}{said}", counted(self.lines, "line", "lines"))
    }

    /// More bytes; true at the end of the run.
    pub fn feed(&mut self, bytes: &[u8]) -> Result<bool, Failure> {
        for &byte in bytes {
            if !self.begun {
                if self.foreign <= QUOTED_CHARS {
                    self.first.push(byte.into());
                }
                self.foreign += 1;
            }
            if byte != b'\n' {
                self.line.push(byte);
                if self.line.len() > LINE_MAX_BYTES && !self.begun {
                    self.line.clear();
                } else if self.line.len() > LINE_MAX_BYTES {
                    return Err(Failure::Job(format!("a line of more than {LINE_MAX_BYTES} bytes")));
                }
                continue;
            }
            let line = std::mem::take(&mut self.line);
            if self.take(String::from_utf8_lossy(&line).trim())? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn take(&mut self, line: &str) -> Result<bool, Failure> {
        if let Some(remark) = line.strip_prefix('#') {
            if !remark.trim_matches('.').is_empty() {
                self.remark = remark.trim().to_owned();
                if let Some(broken) = self.broken.take() {
                    let said = quoted(&self.remark, REMARK_CHARS);
                    return Err(Failure::Job(format!("{broken}; the board said: {said}")));
                }
            }
            return Ok(false);
        }
        if line.is_empty() {
            return Ok(false);
        }
        if let Some(broken) = self.broken.take() {
            return Err(Failure::Job(broken));
        }
        let parsed = parse(line);
        if !self.begun {
            // Whatever the board said before it got the order.
            match parsed {
                Ok(("format", numbers)) => {
                    if numbers != [FORMAT] {
                        return Err(Failure::Job(format!(
                            "the image sends format {numbers:?}, this program reads {FORMAT}: build both anew"
                        )));
                    }
                    self.begun = true;
                }
                _ => return Ok(false),
            }
            self.lines = 1;
            return Ok(false);
        }
        let (name, numbers) = match parsed {
            Ok(parsed) => parsed,
            Err(why) => {
                self.broken = Some(format!("line {}: {why}: {}", self.lines + 1, quoted(line, QUOTED_CHARS)));
                return Ok(false);
            }
        };
        if name == "end" {
            if numbers != [self.lines] {
                return Err(Failure::Job(format!("{}, the board has sent {numbers:?}", have_come(self.lines))));
            }
            return Ok(true);
        }
        self.lines += 1;
        self.figures.add(name, numbers);
        Ok(false)
    }
}

/// How many lines have come.
pub fn have_come(lines: i64) -> String {
    counted(lines, "line has come", "lines have come")
}

/// A line without its end.
fn parse(line: &str) -> Result<(&str, Vec<i64>), &'static str> {
    let (text, sum) = line.rsplit_once('*').ok_or("no checksum")?;
    let sum = u8::from_str_radix(sum, 16).map_err(|_| "no checksum")?;
    if text.bytes().fold(0, |sum, byte| sum ^ byte) != sum {
        return Err("the checksum is wrong");
    }
    let mut words = text.split(' ');
    let name = words.next().filter(|name| !name.is_empty()).ok_or("no name")?;
    let numbers = words.map(str::parse).collect::<Result<_, _>>().map_err(|_| "not a number")?;
    Ok((name, numbers))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line as the board makes it, by the definition.
    fn line(text: &str) -> String {
        let mut sum = 0;
        for byte in text.bytes() {
            sum ^= byte;
        }
        format!("{text}*{sum:02X}\r\n")
    }

    #[test]
    fn a_run_is_read_whatever_came_before() {
        let text = "noise\r\nx*00\r\n".to_owned()
            + &line("format 2")
            + "# 12\r\n"
            + &line("a 1 -2")
            + &line("a 3")
            + &line("end 3");
        let mut reader = Reader::default();
        for (n, byte) in text.bytes().enumerate() {
            assert_eq!(reader.feed(&[byte]).unwrap(), n + 1 == text.len());
        }
        let figures = reader.figures();
        assert_eq!(figures.all("a"), [vec![1, -2], vec![3]]);
        assert_eq!((figures.only::<1>("a"), figures.each::<1>("a"), figures.all("b")), (None, None, &[][..]));
    }

    #[test]
    fn what_is_damaged_or_missing_is_refused() {
        // The published example of NMEA 0183's sum: GPGLL of a common receiver manual.
        assert!(parse("GPGLL,5300.97914,N,00259.98174,E,125926,A*28").is_ok_and(|(_, numbers)| numbers.is_empty()));
        let feed = |text: String| {
            let mut reader = Reader::default();
            match reader.feed(text.as_bytes()) {
                Ok(ended) => format!("{ended} {}", reader.cut_short()),
                Err(Failure::Job(text)) => text,
                Err(other) => format!("{other:?}"),
            }
        };
        let begin = line("format 2");
        let begin_again = begin.clone();
        let next = line("b 1");
        assert_eq!(feed(begin.clone() + "a 1*00\n" + &next), "line 2: the checksum is wrong: a 1*00");
        assert_eq!(feed(begin.clone() + "a 1\n" + &next), "line 2: no checksum: a 1");
        let word = line("a x");
        assert_eq!(feed(begin.clone() + &word + &next), "line 2: not a number: ".to_owned() + word.trim());
        // A line that is cut, and nothing more; a board that stops within a line says why.
        assert_eq!(feed(begin.clone() + "a 1\n"), "false line 2: no checksum: a 1");
        let stopped = begin.clone() + "a 1\r\n# the clock has stopped\r\n";
        assert_eq!(feed(stopped), "line 2: no checksum: a 1; the board said: the clock has stopped");
        assert_eq!(feed(begin.clone() + &line("end 2")), "1 line has come, the board has sent [2]");
        assert_eq!(feed(line("format 1")), "the image sends format [1], this program reads 2: build both anew");
        assert_eq!(
            feed(begin + "# hard fault at 0\n"),
            "false the board fell silent after 1 line; it said: hard fault at 0"
        );
        // What a terminal would obey is no line, and is not printed.
        let wild = begin_again + "\u{1b}[2Jé" + &"x".repeat(5000) + "\n" + &next;
        assert_eq!(feed(wild), format!("line 2: no checksum: \\u{{1b}}[2Jé{}…", "x".repeat(75)));
        let long = line("format 2") + &"z".repeat(LINE_MAX_BYTES + 1);
        assert_eq!(feed(long), format!("a line of more than {LINE_MAX_BYTES} bytes"));
    }
}
