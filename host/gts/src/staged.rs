//! A file that is written beside its name, and renamed when it is whole (SPEC 10).
//!
//! One that was cut off keeps its name with `.partial`. A device or a pipe is written directly.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter};
use std::path::{Path, PathBuf};

/// See the module text.
pub struct Staged {
    name: PathBuf,
    /// Where it grows; none where that is its own name.
    staged: Option<PathBuf>,
}

/// The name of a file that was cut off.
fn partial(name: &Path) -> PathBuf {
    let mut text = OsString::from(name);
    text.push(".partial");
    text.into()
}

fn is_direct(name: &Path) -> bool {
    fs::metadata(name).is_ok_and(|found| !found.is_file())
}

impl Staged {
    /// A file that is written from front to back.
    pub fn stream(name: &Path) -> io::Result<(Staged, File)> {
        if is_direct(name) {
            let file = File::options().write(true).open(name)?;
            return Ok((Staged { name: name.to_owned(), staged: None }, file));
        }
        let staged = partial(name);
        let file = File::create(&staged)?;
        Ok((Staged { name: name.to_owned(), staged: Some(staged) }, file))
    }

    /// A picture, which is drawn at the end: its extension stays, which says what it is.
    pub fn picture(name: &Path) -> Staged {
        let extension = name.extension().unwrap_or_default().to_string_lossy();
        let staged = (!is_direct(name)).then(|| name.with_extension(format!("partial.{extension}")));
        Staged { name: name.to_owned(), staged }
    }

    /// Whether it grows beside its name, so that it can be written anew.
    pub fn is_staged(&self) -> bool {
        self.staged.is_some()
    }

    /// Reads it.
    pub fn reader(&self) -> io::Result<BufReader<File>> {
        File::open(self.path()).map(BufReader::new)
    }

    /// Writes what grew once more, as `write` says; it stays as it is where that fails.
    pub fn anew<E: From<io::Error>>(
        &self,
        write: impl FnOnce(BufReader<File>, BufWriter<File>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut fresh = self.path().as_os_str().to_owned();
        fresh.push(".new");
        let outcome = File::create(&fresh).map_err(E::from).and_then(|file| {
            write(self.reader()?, BufWriter::new(file))?;
            Ok(fs::rename(&fresh, self.path())?)
        });
        if outcome.is_err() {
            let _ = fs::remove_file(&fresh);
        }
        outcome
    }

    /// Where to write.
    pub fn path(&self) -> &Path {
        self.staged.as_deref().unwrap_or(&self.name)
    }

    /// It is whole and gets its name; or it was cut off and keeps the other one.
    pub fn end(self, is_whole: bool) -> io::Result<()> {
        let Some(staged) = self.staged else { return Ok(()) };
        match is_whole {
            true => fs::rename(staged, &self.name),
            false if staged == partial(&self.name) || !staged.exists() => Ok(()),
            false => fs::rename(staged, partial(&self.name)),
        }
    }
}
