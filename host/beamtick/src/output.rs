//! Files that a job writes: under temporary names while they grow, renamed when they are complete.
//!
//! In: names from the command line. Out: files. Owns them until they are complete. An incomplete
//! file keeps its name with `.partial`. A file of an earlier run becomes `.old` at the start, so
//! that it cannot be taken for this run's; it is removed when the new one is complete. Anything but
//! a plain file (a device, a pipe) is written directly. Fails: it never overwrites a file that the
//! job reads or that another output is.
use crate::Failure;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Files that grow now, by their names and where they grow: a signal may end the program before it
/// has come to them.
static GROWING: Mutex<Vec<(PathBuf, PathBuf)>> = Mutex::new(Vec::new());

/// See the module text.
pub struct Output {
    name: PathBuf,
    /// Where it grows; none where that is its own name.
    staged: Option<PathBuf>,
    /// The file of an earlier run, under its new name.
    older: Option<PathBuf>,
}

/// What a run that was cut off leaves of an output.
#[derive(Debug, Default)]
pub struct Kept {
    /// What was recorded, if anything was.
    pub partial: Option<PathBuf>,
    /// The name of an earlier run's file, and what it is called now.
    pub older: Option<(PathBuf, PathBuf)>,
}

impl std::fmt::Display for Kept {
    /// Lines that say so, each after a line end.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(file) = &self.partial {
            write!(f, "\nWhat was recorded until then is in {}.", file.display())?;
        }
        if let Some((name, older)) = &self.older {
            write!(f, "\n{} of an earlier run is {} now.", name.display(), older.display())?;
        }
        Ok(())
    }
}

/// The name of a file that was cut off.
fn partial(name: &Path) -> PathBuf {
    longer(name, ".partial")
}

/// The name of an earlier run's file while this one is written.
fn old(name: &Path) -> PathBuf {
    longer(name, ".old")
}

fn longer(name: &Path, by: &str) -> PathBuf {
    let mut text = name.as_os_str().to_owned();
    text.push(by);
    PathBuf::from(text)
}

/// Where a picture grows: its extension stays, which says what it is.
fn picture(name: &Path) -> PathBuf {
    let extension = name.extension().unwrap_or_default().to_string_lossy();
    name.with_extension(format!("partial.{extension}"))
}

impl Output {
    /// A file that is written from front to back.
    pub fn stream(name: &Path) -> Result<(Output, File), Failure> {
        Output::create(name, partial(name))
    }

    /// A picture, drawn at the end.
    pub fn picture(name: &Path) -> Result<Output, Failure> {
        Output::create(name, picture(name)).map(|(output, _)| output)
    }

    fn create(name: &Path, staged: PathBuf) -> Result<(Output, File), Failure> {
        let failed = |error: std::io::Error| Failure::Input(format!("{}: cannot be written: {error}", name.display()));
        let found = fs::metadata(name);
        if found.as_ref().is_ok_and(|found| !found.is_file()) {
            let file = File::options().write(true).open(name).map_err(failed)?;
            return Ok((Output { name: name.to_owned(), staged: None, older: None }, file));
        }
        if found.is_ok() {
            // What may not be written is not replaced either.
            File::options().append(true).open(name).map_err(failed)?;
        }
        let file = File::create(&staged).map_err(failed)?;
        GROWING.lock().unwrap_or_else(PoisonError::into_inner).push((name.to_owned(), staged.clone()));
        Ok((Output { name: name.to_owned(), staged: Some(staged), older: None }, file))
    }

    /// The run begins: a file of an earlier one gets its other name, a picture that was cut off
    /// goes.
    pub fn set_older_aside(&mut self) -> Result<(), Failure> {
        let partial = partial(&self.name);
        if self.staged.as_ref().is_some_and(|staged| *staged != partial) {
            let _ = fs::remove_file(partial);
        }
        if self.staged.is_some() && self.name.exists() {
            let older = old(&self.name);
            fs::rename(&self.name, &older).map_err(|error| {
                Failure::Input(format!("{}: cannot be renamed {}: {error}", self.name.display(), older.display()))
            })?;
            self.older = Some(older);
        }
        Ok(())
    }

    /// Where to write.
    pub fn path(&self) -> &Path {
        self.staged.as_deref().unwrap_or(&self.name)
    }

    /// The file is whole and gets its name.
    pub fn whole(self) -> Result<(), Failure> {
        let Some(staged) = &self.staged else { return Ok(()) };
        grown(staged);
        fs::rename(staged, &self.name)
            .map_err(|error| Failure::Job(format!("{}: cannot be written: {error}", self.name.display())))?;
        let _ = fs::remove_file(partial(&self.name));
        self.older.map_or(Ok(()), |older| {
            fs::remove_file(&older)
                .map_err(|error| Failure::Job(format!("{}: cannot be removed: {error}", older.display())))
        })
    }

    /// The file was cut off.
    pub fn cut_off(self) -> Kept {
        let Some(staged) = self.staged else { return Kept::default() };
        grown(&staged);
        let partial = kept(&self.name, &staged);
        Kept { partial, older: self.older.map(|older| (self.name, older)) }
    }
}

/// What grew there is looked after.
fn grown(staged: &Path) {
    GROWING.lock().unwrap_or_else(PoisonError::into_inner).retain(|(_, growing)| growing != staged);
}

/// What was cut off gets the name that says so, and is removed if there is nothing of it.
fn kept(name: &Path, staged: &Path) -> Option<PathBuf> {
    let partial = partial(name);
    if fs::metadata(staged).is_ok_and(|found| found.len() == 0) {
        let _ = fs::remove_file(staged);
        return None;
    }
    (staged == partial || fs::rename(staged, &partial).is_ok()).then_some(partial)
}

/// The program ends at once: all that grows is cut off. What there is of it.
pub fn leave() -> Vec<Kept> {
    let growing = std::mem::take(&mut *GROWING.lock().unwrap_or_else(PoisonError::into_inner));
    growing.iter().map(|(name, staged)| Kept { partial: kept(name, staged), older: None }).collect()
}

/// The file that a name means, however it is written.
fn resolved(name: &Path) -> PathBuf {
    let folder = name.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside =
        || folder.canonicalize().unwrap_or_else(|_| folder.to_owned()).join(name.file_name().unwrap_or_default());
    name.canonicalize().unwrap_or_else(|_| beside())
}

/// Fails, before anything is written or run, where an output would overwrite one of the `inputs` or
/// another output. `outputs`: the option, the name, whether it is a picture.
pub fn check(inputs: &[PathBuf], outputs: &[(&str, &Path, bool)]) -> Result<(), Failure> {
    let mut taken: Vec<(PathBuf, String)> =
        inputs.iter().map(|name| (resolved(name), format!("the command reads {}", name.display()))).collect();
    for (option, name, drawn) in outputs {
        if *name == Path::new("-") {
            let why = "it names a file; the standard output is /dev/stdout. Nothing was done";
            return Err(Failure::Input(format!("{option} -: {why}")));
        }
        // A device or a pipe takes more than one.
        if fs::metadata(name).is_ok_and(|found| !found.is_file()) {
            continue;
        }
        let staged = if *drawn { picture(name) } else { partial(name) };
        let names = [name.to_path_buf(), staged, partial(name), old(name)].map(|name| resolved(&name));
        if let Some((_, what)) = taken.iter().find(|(taken, _)| names.contains(taken)) {
            return Err(Failure::Input(format!(
                "{option} {} would overwrite a file: {what}; name another one. Nothing was run or written",
                name.display()
            )));
        }
        let what = format!("{option} writes {}", name.display());
        taken.extend(names.map(|name| (name, what.clone())));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A signal that comes while a picture is drawn leaves no empty one.
    #[test]
    fn what_grows_is_cut_off_by_an_end_in_between() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a.png.partial"), "of an earlier run").unwrap();
        let (empty, begun) = (Output::picture(&at("a.png")), Output::picture(&at("b.svg")));
        let (Ok(mut empty), Ok(begun)) = (empty, begun) else { panic!("both can be written") };
        assert!(empty.set_older_aside().is_ok());
        fs::write(begun.path(), "<svg").unwrap();
        let kept: String = leave().iter().map(Kept::to_string).collect();
        assert!(kept.contains("b.svg.partial") && !kept.contains("a.png"), "{kept}");
        let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(names, ["b.svg.partial"]);
        drop((empty, begun));
    }
}
