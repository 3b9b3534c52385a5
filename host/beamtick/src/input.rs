//! Files that people name: read whole, long ones as they are needed. `-` is the standard input, for
//! one of them.
//!
//! In: a path, and what it is for. Out: its bytes. Owns what came over the standard input. Fails
//! with what the system says, and for a device, which may never end.
use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// What a file is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A job, a G-code program or a drawing.
    Job,
    /// A machine file.
    Machine,
    /// Levels of inputs.
    Inputs,
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Role::Job => "the job",
            Role::Machine => "the machine file",
            Role::Inputs => "the inputs",
        })
    }
}

/// The bytes that came over the standard input, and for whom.
static STANDARD: Mutex<Option<(Role, Vec<u8>)>> = Mutex::new(None);

/// Whether a name means the standard input.
pub fn is_standard(path: &Path) -> bool {
    path == Path::new("-")
}

/// Whether `-` stands for one file at most, before anything is read.
///
/// # Errors
/// It stands for the job and the machine file.
pub fn is_for_one(job: &Path, machine: Option<&Path>) -> io::Result<()> {
    if is_standard(job) && machine.is_some_and(is_standard) {
        return Err(taken(Role::Job));
    }
    Ok(())
}

fn taken(by: Role) -> io::Error {
    io::Error::other(format!("the standard input is {by} already; `-` is for one file"))
}

/// A file with more than `size` bytes that begins with `mark`.
pub fn long(path: &Path, mark: &[u8], size: usize) -> io::Result<Option<File>> {
    if is_standard(path) || !std::fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > size as u64) {
        return Ok(None);
    }
    let mut file = File::open(path)?;
    let mut head = vec![0; mark.len()];
    file.read_exact(&mut head)?;
    file.rewind()?;
    Ok((head == mark).then_some(file))
}

/// The bytes of a file or a pipe, from front to back.
pub fn open(path: &Path, role: Role) -> io::Result<Box<dyn BufRead>> {
    if is_standard(path) {
        return Ok(Box::new(Cursor::new(standard(role, <[u8]>::to_vec)?)));
    }
    is_no_device(path)?;
    Ok(Box::new(BufReader::with_capacity(1 << 16, File::open(path)?)))
}

/// The bytes of a file or a pipe.
pub fn read(path: &Path, role: Role) -> io::Result<Vec<u8>> {
    if is_standard(path) {
        return standard(role, <[u8]>::to_vec);
    }
    is_no_device(path)?;
    std::fs::read(path)
}

fn is_no_device(path: &Path) -> io::Result<()> {
    let kind = std::fs::metadata(path)?.file_type();
    #[cfg(unix)]
    let is_pipe = std::os::unix::fs::FileTypeExt::is_fifo(&kind);
    #[cfg(not(unix))]
    let is_pipe = false;
    if !(kind.is_file() || kind.is_dir() || is_pipe) {
        return Err(io::Error::other("it is a device, not a file"));
    }
    Ok(())
}

/// What `look` finds in the standard input.
pub fn standard<T>(role: Role, look: impl FnOnce(&[u8]) -> T) -> io::Result<T> {
    let mut standard = STANDARD.lock().unwrap_or_else(PoisonError::into_inner);
    if standard.is_none() {
        let mut bytes = Vec::new();
        io::stdin().read_to_end(&mut bytes)?;
        *standard = Some((role, bytes));
    }
    match &*standard {
        Some((of, bytes)) if *of == role => Ok(look(bytes)),
        Some((of, _)) => Err(taken(*of)),
        None => Err(io::Error::other("nothing was read")),
    }
}
