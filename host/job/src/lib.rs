#![forbid(unsafe_code)]
//! Job scripts (SPEC section 7): the text of a `.gts` file in, a list of timed calls out.
//!
//! In: the text, and a [`Files`] that hands over the configuration files it loads. Out: a [`Job`],
//! whose steps hold requests already packed for the wire, or [`Diagnostic`]s with line and column.
//! Nothing here opens a link, keeps time, or knows what a call does beyond its parameters; the one
//! exception is the rule about endless motions ([`Action::WaitAll`]).
//!
//! `text` makes text of bytes, `scan` tokens of text; `read` is the cursor on them. `statement`,
//! `assign` and `wait` are for statements, `expr` and `value` for expressions. `call`, `bind` and
//! `pack` make requests of calls, by the table of [`api`]. `endless` knows what may never stop,
//! [`config`] reads files of `GT_LoadConfig`. The language and the configuration keys are described
//! in `docs/jobs.md`.

pub mod api;
mod assign;
mod bind;
mod call;
pub mod config;
mod diagnostic;
mod endless;
mod expr;
mod initial;
mod job;
mod pack;
pub mod quick;
mod read;
mod scan;
mod statement;
pub mod text;
mod used;
mod value;
mod wait;

pub use diagnostic::{Diagnostic, QUOTED_CHARACTERS, Severity, quoted, render, render_lines, tidy};
pub use expr::nearest;
pub use job::{Action, Axis, Call, Crd, Job, Out, Pragma, Step};
pub use used::Used;

use std::path::{Path, PathBuf};

/// Where the files that a job names are read from.
pub trait Files {
    /// The text of `path` as the job writes it, or why there is none.
    fn text(&self, path: &str) -> Result<String, String>;
}

/// Files beside the job: relative paths start at this folder.
#[derive(Debug, Clone)]
pub struct Folder(pub PathBuf);

impl Folder {
    /// The folder that holds the job file `job`.
    pub fn of(job: &Path) -> Self {
        Self(job.parent().map_or_else(PathBuf::new, Path::to_path_buf))
    }

    /// Where the file is that a job names so.
    pub fn place(&self, path: &str) -> PathBuf {
        self.0.join(path.replace('\\', "/"))
    }
}

impl Files for Folder {
    fn text(&self, path: &str) -> Result<String, String> {
        let full = self.place(path);
        let name = || quoted(&full.display().to_string());
        let bytes = std::fs::read(&full).map_err(|error| format!("{}: {error}", name()))?;
        text::decode(bytes).map_err(|line| format!("{}:{line}: neither UTF-8, UTF-16 nor GBK text", name()))
    }
}

/// Compiles the script `text`; files that it names come from `files`.
///
/// # Errors
/// All errors in the order of the text, and after them the warnings.
pub fn compile(text: &str, files: &dyn Files) -> Result<Job, Vec<Diagnostic>> {
    let mut reader = read::Reader::new(text, files);
    reader.run();
    if !reader.errors.is_empty() {
        let mut all = reader.errors;
        all.append(&mut reader.warnings);
        return Err(all);
    }
    Ok(Job {
        steps: reader.steps,
        pragmas: reader.pragmas,
        warnings: reader.warnings,
        axes: reader.used.axes.into_iter().collect(),
        crds: reader.used.crds.into_iter().collect(),
        lasers: reader.used.lasers,
        named: reader.named,
    })
}
