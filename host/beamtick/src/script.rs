//! The text of a job: in memory, or, where it is long, in a file that is read as it is needed.
//!
//! In: a text, or a file. Out: its bytes from front to back, and the lines of a position. Owns the
//! file: one that `import` wrote is a temporary file without a name. Fails with what the system
//! says of the file, or where somebody has written to it.
use job::Diagnostic;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;
use tempfile::SpooledTempFile;

/// A job that an import writes is kept in memory up to so many bytes.
pub const IN_MEMORY_BYTES: usize = 1 << 20;
/// Bytes that are read at once.
pub const BLOCK_BYTES: usize = 1 << 16;
/// Bytes on each side of a position in which its lines are looked for.
const AROUND_BYTES: usize = 1 << 12;

/// What a long text is kept in.
pub trait Store: Read + Seek + Send {}

impl<T: Read + Seek + Send> Store for T {}

/// See the module text.
pub enum Script {
    /// In memory.
    Whole(String),
    /// In a file.
    Kept {
        /// Where its bytes are.
        store: Mutex<Box<dyn Store>>,
        /// A file that others may write to, and how it was.
        others: Option<(File, Stamp)>,
    },
}

/// When a file was written last, and its bytes.
type Stamp = (Option<SystemTime>, u64);

fn stamp(file: &File) -> io::Result<Stamp> {
    let found = file.metadata()?;
    Ok((found.modified().ok(), found.len()))
}

impl Script {
    /// A text in a file that nobody else has.
    pub fn kept(store: impl Store + 'static) -> Script {
        Script::Kept { store: Mutex::new(Box::new(store)), others: None }
    }

    /// A text in somebody's file. Once that is written to, it is not read any more: what runs is
    /// what was checked.
    pub fn file(file: File) -> io::Result<Script> {
        let others = Some((file.try_clone()?, stamp(&file)?));
        Ok(Script::Kept { store: Mutex::new(Box::new(file)), others })
    }

    /// A text that was written there: in a file, if it is long.
    pub fn spooled(mut text: SpooledTempFile) -> io::Result<Script> {
        if text.is_rolled() {
            return Ok(Script::kept(text));
        }
        let mut whole = String::new();
        text.rewind()?;
        text.read_to_string(&mut whole)?;
        Ok(Script::Whole(whole))
    }

    /// From front to back.
    pub fn reader(&self) -> impl BufRead + '_ {
        BufReader::with_capacity(BLOCK_BYTES, At { script: self, at: 0 })
    }

    fn read_at(&self, at: u64, out: &mut [u8]) -> io::Result<usize> {
        match self {
            Script::Whole(text) => {
                let from = usize::try_from(at).unwrap_or(usize::MAX).min(text.len());
                (&text.as_bytes()[from..]).read(out)
            }
            Script::Kept { store, others } => {
                if let Some((file, before)) = others
                    && stamp(file)? != *before
                {
                    return Err(io::Error::other("it has changed since it was checked"));
                }
                let mut store = store.lock().unwrap_or_else(PoisonError::into_inner);
                store.seek(SeekFrom::Start(at))?;
                store.read(out)
            }
        }
    }

    /// The lines of a position in a file, as far as they lie near it, and where they begin.
    fn around(&self, span: &Range<usize>) -> (String, usize) {
        let begin = span.start.saturating_sub(AROUND_BYTES);
        let mut bytes = Vec::new();
        let part = At { script: self, at: begin as u64 };
        // A file that cannot be read any more shows nothing.
        let _ = part.take((span.end + AROUND_BYTES - begin) as u64).read_to_end(&mut bytes);
        let (at, end) = ((span.start - begin).min(bytes.len()), (span.end - begin).min(bytes.len()));
        let first = bytes[..at].iter().rposition(|byte| *byte == b'\n').map_or(0, |newline| newline + 1);
        let last = bytes[end..].iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |newline| end + newline);
        (String::from_utf8_lossy(&bytes[first..last]).into_owned(), begin + first)
    }

    /// A message with the place in the file `name`.
    pub fn show(&self, diagnostic: &Diagnostic, name: &str, colour: bool) -> String {
        match self {
            Script::Whole(text) => job::render(diagnostic, name, text, colour),
            Script::Kept { .. } => {
                let (lines, begin) = self.around(&diagnostic.span);
                job::render_lines(diagnostic, name, &lines, begin)
            }
        }
    }
}

/// A place in a text, to read on from.
struct At<'s> {
    script: &'s Script,
    at: u64,
}

impl Read for At<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.script.read_at(self.at, out)?;
        self.at += count as u64;
        Ok(count)
    }
}
