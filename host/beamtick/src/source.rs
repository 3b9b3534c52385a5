//! A job file: its text, its compiled form, and how positions in it are shown.
use crate::Failure;
use crate::command_line::{Drawing, FamilyName, Settings, TICKS_US};
use crate::entries::Entries;
use crate::input::{self, Role};
use crate::parts::{self, Broken, Compiled, Part};
use crate::script::{self, Script};
use crate::totals::Totals;
use crate::{import, json};
use client::{Family, ProductProfile};
use job::{Diagnostic, Files, Folder, Job, Pragma, Severity, Step};
use protocol::command::VersionReply;
use std::cell::RefCell;
use std::io::{ErrorKind, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::{Arc, mpsc};
use trace::Millimetres;

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
    script: Arc<Script>,
    /// What it does; the steps of one that is compiled in parts are not in it.
    pub job: Job,
    /// What its steps are as a whole.
    pub totals: Totals,
    in_parts: bool,
    folder: Folder,
    /// Every file that was read for it.
    pub files: Vec<PathBuf>,
    /// Axes that a picture shows in mm.
    pub millimetres: Vec<Millimetres>,
    /// Channels of lasers that the machine file names.
    pub lasers: Vec<(u8, String)>,
    /// What the path of a program or a drawing covers.
    pub extent: Option<strokes::Extent>,
}

impl Source {
    /// Reads and compiles a job file; its warnings go to the error stream. `timed`: a program or a
    /// drawing tells how long it takes, which the simulator finds out anyway.
    pub fn open(path: &Path, drawing: &Drawing, timed: bool) -> Result<Self, Failure> {
        let source = Source::open_drawn(path, drawing, None, timed)?;
        if let Some(extent) = &source.extent {
            complain!("{}: {extent}", source.name);
        }
        Ok(source)
    }

    /// The same, with a picture of the path of a program or a drawing.
    pub fn open_drawn(path: &Path, drawing: &Drawing, plot: Option<&Path>, timed: bool) -> Result<Self, Failure> {
        let name = path.display().to_string();
        // Looked at first: a machine file that came over the standard input looks like a job.
        input::is_for_one(path, drawing.machine.as_deref()).map_err(|error| unread(&name, &error))?;
        let kind = import::kind(path).map_err(|error| unread(&name, &error))?;
        if kind.is_some() {
            let found = import::job(path, drawing, plot, timed)?;
            let files = vec![path.to_owned(), found.file];
            let read = Source::read(name.clone(), found.script, found.compiled, files, path);
            let mut source = read.map_err(|why| why.failure(&name))?;
            (source.millimetres, source.lasers) = (found.millimetres, found.lasers);
            source.extent = Some(found.extent);
            return Ok(source);
        }
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
            return Err(Failure::Input(format!(
                "{name}: this is no job by its name, but a machine file, which --machine takes beside G-code or a drawing; \
                 `beamtick machine check {name}` reads it"
            )));
        }
        if let Some(file) = input::long(path, strokes::MARK.as_bytes(), script::IN_MEMORY_BYTES)
            .map_err(|error| unread(&name, &error))?
            .filter(|_| plot.is_none() && !drawing.is_given())
        {
            let script = Script::file(file).map_err(|error| unread(&name, &error))?;
            match Source::read(name.clone(), script, None, vec![path.to_owned()], path) {
                // Somebody wrote into it in another encoding.
                Err(Unread::Text(error)) if error.kind() == ErrorKind::InvalidData => {}
                read => return read.map_err(|why| why.failure(&name)),
            }
        }
        let bytes = input::read(path, Role::Job).map_err(|error| unread(&name, &error))?;
        if input::is_standard(path) && bytes.iter().all(u8::is_ascii_whitespace) {
            return Err(Failure::Input(format!("{name}: nothing came over the standard input; no job was run")));
        }
        let read = if input::is_standard(path) { Vec::new() } else { vec![path.to_owned()] };
        if let Some((_, what)) = import::looks_like(&bytes) {
            return Err(Failure::Input(format!(
                "{name}: {what}; it is taken for a job by its name. {}",
                import::NAMED
            )));
        }
        if let Some(what) = other_table(&bytes, &name) {
            return Err(Failure::Input(format!("{name}: this is no job, but {what}")));
        }
        if plot.is_some() {
            return Err(Failure::Input(format!(
                "{name}: --plot of `check` is for G-code and drawings; `sim` draws what a job does"
            )));
        }
        if drawing.is_given() {
            return Err(Failure::Input(format!(
                "{name}: --machine, --laser, --layer, --at and --pass-stops are for G-code and drawings, and this is a job, \
                 which is in pulses already; {}",
                import::NAMED
            )));
        }
        let text = job::text::decode(bytes).map_err(|line| {
            Failure::Input(format!("{name}:{line}: the file is neither UTF-8, UTF-16 nor GBK text; save it as UTF-8"))
        })?;
        Source::read(name.clone(), Script::Whole(text), None, read, path).map_err(|why| why.failure(&name))
    }

    /// The job that a text is, unless it is compiled already.
    fn read(
        name: String,
        script: Script,
        compiled: Option<Result<Compiled, Broken>>,
        read: Vec<PathBuf>,
        path: &Path,
    ) -> Result<Self, Unread> {
        let folder = Folder::of(path);
        let files = Noted { folder: folder.clone(), read: RefCell::new(read) };
        let compiled = compiled.unwrap_or_else(|| compile(&script, &files)).and_then(|compiled| {
            match unknown_values(&compiled.job) {
                wrong if wrong.is_empty() => Ok(compiled),
                wrong => Err(Broken::Job(wrong)),
            }
        });
        match compiled {
            Ok(Compiled { job, totals, in_parts }) => {
                for warning in &job.warnings {
                    complain!("{}", show(warning, &name, &script).trim_end());
                }
                if totals.steps == 0 {
                    let note = format!("{name}: the job has no call: nothing moves, and nothing is lit");
                    json::note(&note);
                    complain!("{note}");
                }
                let files = files.read.into_inner();
                let (millimetres, lasers, extent) = (Vec::new(), Vec::new(), None);
                let script = Arc::new(script);
                Ok(Source { name, script, job, totals, in_parts, folder, files, millimetres, lasers, extent })
            }
            Err(Broken::Text(error)) => Err(Unread::Text(error)),
            Err(Broken::Job(found)) => {
                let errors = found.iter().filter(|one| one.severity == Severity::Error).count();
                let mut shown: String = found.iter().map(|one| show(one, &name, &script)).collect();
                shown.push_str(&format!(
                    "{name}: {errors} error{}; the job was not run",
                    if errors == 1 { "" } else { "s" }
                ));
                Err(Unread::Job(Failure::Input(shown)))
            }
        }
    }

    /// Its steps, from the first one on.
    pub fn steps(&self) -> Steps<'_> {
        match self.in_parts {
            false => Steps::Listed(self.job.steps.iter()),
            true => Steps::Parts {
                parts: parts::ahead(Arc::clone(&self.script), self.folder.clone()).into_iter(),
                part: Vec::new().into_iter(),
                left: self.totals.steps,
            },
        }
    }

    /// Its entries for this controller, from the first one on.
    pub fn entries(&self, version: VersionReply, traced: bool) -> Entries<'_> {
        Entries::new(&self.job, &self.totals, self.steps(), version, traced)
    }

    /// The settings of the command line, with those that the job's pragmas replace.
    ///
    /// # Errors
    /// An option that contradicts its pragma.
    pub fn settings(&self, given: &Settings) -> Result<Settings, Failure> {
        let mut settings = given.clone();
        for pragma in &self.job.pragmas {
            let Ok(value) = value(pragma) else { continue };
            let (option, said) = match value {
                Value::Family(family) => {
                    let said = settings.family.filter(|said| *said != family).map(|said| match said {
                        FamilyName::Gus => "gus".to_owned(),
                        FamilyName::Lsr => "lsr".to_owned(),
                    });
                    settings.family = Some(family);
                    ("--family", said)
                }
                Value::Profile(profile) => {
                    let said = settings.profile.filter(|said| !said.eq_ignore_ascii_case(profile.name()));
                    settings.profile = Some(profile.name().to_owned());
                    ("--profile", said)
                }
                Value::Tick(us) => {
                    let said = settings.tick_us.filter(|said| *said != us).map(|said| said.to_string());
                    settings.tick_us = Some(us);
                    ("--tick-us", said)
                }
            };
            if let Some(said) = said {
                let message =
                    format!("{option} {said} is given, and the job says #pragma {} {}", pragma.name, pragma.value);
                let wrong = complaint(pragma, message, "leave out one of them, or let them agree".to_owned());
                return Err(Failure::Input(show(&wrong, &self.name, &self.script)));
            }
        }
        Ok(settings)
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
        // Lines of an imported job are not those of its program; `// N` at their ends are.
        let name = if self.extent.is_some() { format!("{} as a job", self.name) } else { self.name.clone() };
        show(&diagnostic, &name, &self.script)
    }
}

/// Why a job is not run.
enum Unread {
    /// Its text cannot be read.
    Text(std::io::Error),
    /// It does not compile.
    Job(Failure),
}

impl Unread {
    fn failure(self, name: &str) -> Failure {
        match self {
            Unread::Text(error) => unread(name, &error),
            Unread::Job(failure) => failure,
        }
    }
}

/// A table with times, which no job begins with: what it is, and which command takes it.
fn other_table(bytes: &[u8], name: &str) -> Option<String> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let columns = bytes.strip_prefix(b"t_ms")?;
    match columns.strip_prefix(b",input,level") {
        Some(_) => Some(format!("a file of inputs: `beamtick sim JOB --inputs {name}` takes it")),
        None if matches!(columns.first(), Some(b',' | b'\r' | b'\n')) => {
            Some(format!("a trace: `beamtick plot {name} -o plot.png` draws it"))
        }
        None => None,
    }
}

fn unread(name: &str, error: &std::io::Error) -> Failure {
    Failure::Input(format!("{name}: the job file cannot be read: {error}"))
}

/// The steps of a job in order. A job that is compiled in parts is compiled once more; where that
/// fails, its file has changed or cannot be read any more.
pub enum Steps<'s> {
    /// Those that it has.
    Listed(std::slice::Iter<'s, Step>),
    /// Those that its text makes.
    Parts {
        /// Parts to come.
        parts: mpsc::IntoIter<Result<Part, Broken>>,
        /// Steps of the last one.
        part: std::vec::IntoIter<Step>,
        /// Steps to come, as many as there were at first.
        left: usize,
    },
}

impl Iterator for Steps<'_> {
    type Item = Result<Step, String>;

    fn next(&mut self) -> Option<Self::Item> {
        const CHANGED: &str = "the job file is not what was checked";
        let (parts, part, left) = match self {
            Steps::Listed(steps) => return steps.next().cloned().map(Ok),
            Steps::Parts { parts, part, left } => (parts, part, left),
        };
        loop {
            if let Some(step) = part.next() {
                let Some(fewer) = left.checked_sub(1) else { return Some(Err(CHANGED.to_owned())) };
                *left = fewer;
                return Some(Ok(step));
            }
            *part = match parts.next() {
                None if *left > 0 => return Some(Err(CHANGED.to_owned())),
                None => return None,
                Some(Ok(Part::Compiled(job))) => job.steps.into_iter(),
                Some(Ok(Part::Calls { steps, .. })) => steps.into_iter(),
                Some(Err(Broken::Job(_))) => return Some(Err(CHANGED.to_owned())),
                Some(Err(Broken::Text(error))) => {
                    return Some(Err(format!("the job file cannot be read any more: {error}")));
                }
            };
        }
    }
}

/// A job that does not compile as a whole is compiled in parts from so many lines on.
const MANY_LINES: usize = 200_000;
/// What reaches over the lines of a script: with it, parts are not what the whole is.
const FAR_REACHING: [&str; 6] = ["/*", "#define", "#pragma continue", "kbhit", "return", "GT_LoadConfig"];

/// Compiles a job. One that `import` wrote may be of any length: its calls name no variables after
/// the set-up. So may one that is as plain as that.
fn compile(script: &Script, files: &Noted) -> Result<Compiled, Broken> {
    let Script::Whole(text) = script else { return parts::compile(script.reader(), files) };
    if text.starts_with(strokes::MARK) {
        return parts::compile(script.reader(), files);
    }
    match job::compile(text, files) {
        Ok(job) => Ok(Compiled { totals: Totals::of(&job.steps), job, in_parts: false }),
        Err(found) => {
            let is_plain =
                text.lines().nth(MANY_LINES).is_some() && !FAR_REACHING.iter().any(|word| text.contains(word));
            // What is wrong with a part is wrong with the whole, which has said what.
            let parts = is_plain.then(|| parts::compile(script.reader(), files));
            parts.and_then(Result::ok).ok_or(Broken::Job(found))
        }
    }
}

/// What a pragma says.
enum Value {
    Family(FamilyName),
    Profile(ProductProfile),
    Tick(u32),
}

/// The value of a pragma, or what is allowed.
fn value(pragma: &Pragma) -> Result<Value, String> {
    let text = pragma.value.as_str();
    match pragma.name {
        "family" => match Family::named(text) {
            Some(Family::Gus) => Ok(Value::Family(FamilyName::Gus)),
            Some(Family::Lsr) => Ok(Value::Family(FamilyName::Lsr)),
            None => Err("families are gus and lsr".to_owned()),
        },
        "profile" => ProductProfile::named(text).map(Value::Profile).ok_or_else(|| {
            let known: Vec<&str> = ProductProfile::ALL.iter().map(|(_, name)| *name).collect();
            format!("profiles are {}", known.join(", "))
        }),
        _ => match text.parse() {
            Ok(us) if TICKS_US.contains(&us) => Ok(Value::Tick(us)),
            _ => Err(format!("it is a whole number of us from {} to {}", TICKS_US.start(), TICKS_US.end())),
        },
    }
}

/// Pragmas whose value nothing has.
fn unknown_values(job: &Job) -> Vec<Diagnostic> {
    let wrong = |pragma: &Pragma| {
        let help = value(pragma).err()?;
        Some(complaint(pragma, format!("#pragma {} has the value `{}`", pragma.name, pragma.value), help))
    };
    job.pragmas.iter().filter_map(wrong).collect()
}

fn complaint(pragma: &Pragma, message: String, help: String) -> Diagnostic {
    let Pragma { line, column, ref span, .. } = *pragma;
    Diagnostic { severity: Severity::Error, line, column, span: span.clone(), message, help: Some(help) }
}

fn show(diagnostic: &Diagnostic, name: &str, script: &Script) -> String {
    json::message(diagnostic, name);
    script.show(diagnostic, name, std::io::stderr().is_terminal())
}
