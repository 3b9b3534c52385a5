//! A job file: its text, what it compiles to, and how places in it are shown.
use crate::Failure;
use job::{Diagnostic, Files, Folder, Job, Severity, Step};
use std::cell::RefCell;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// The files beside a job, and which of them were read.
struct Noted {
    folder: Folder,
    read: RefCell<Vec<PathBuf>>,
}

impl Files for Noted {
    fn text(&self, path: &str) -> Result<String, String> {
        self.read.borrow_mut().push(self.folder.place(path));
        self.folder.text(path)
    }
}

/// A job file that compiles.
pub struct Source {
    /// Its path as the user gave it.
    pub name: String,
    text: String,
    /// What it does.
    pub job: Job,
    /// Every file that was read for it.
    pub files: Vec<PathBuf>,
}

impl Source {
    /// Reads and compiles a job file; its warnings go to the error stream.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let bytes = std::fs::read(path)
            .map_err(|error| Failure::Input(format!("{name}: the job file cannot be read: {error}")))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let good = error.utf8_error().valid_up_to();
            let line = error.as_bytes()[..good].iter().filter(|byte| **byte == b'\n').count() + 1;
            Failure::Input(format!("{name}:{line}: the file is not UTF-8 text; save it as UTF-8"))
        })?;
        let files = Noted { folder: Folder::of(path), read: RefCell::new(vec![path.to_owned()]) };
        match job::compile(&text, &files) {
            Ok(job) => {
                for warning in &job.warnings {
                    complain!("{}", show(warning, &name, &text).trim_end());
                }
                Ok(Source { name, text, job, files: files.read.into_inner() })
            }
            Err(found) => {
                let errors = found.iter().filter(|one| one.severity == Severity::Error).count();
                let mut shown: String = found.iter().map(|one| show(one, &name, &text)).collect();
                shown.push_str(&format!(
                    "{name}: {errors} error{}; the job was not run",
                    if errors == 1 { "" } else { "s" }
                ));
                Err(Failure::Input(shown))
            }
        }
    }

    /// A message about one step, with the script's line.
    pub fn show(&self, step: &Step, severity: Severity, message: String, help: &str) -> String {
        let diagnostic = Diagnostic {
            severity,
            line: step.line,
            column: step.column,
            span: step.span.clone(),
            message,
            help: (!help.is_empty()).then(|| help.to_owned()),
        };
        show(&diagnostic, &self.name, &self.text)
    }
}

fn show(diagnostic: &Diagnostic, name: &str, text: &str) -> String {
    job::render(diagnostic, name, text, std::io::stderr().is_terminal())
}
