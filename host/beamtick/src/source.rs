//! A job file: its text, its compiled form, and how positions in it are shown.
use crate::Failure;
use crate::command_line::{Drawing, FamilyName, Settings, TICKS_US};
use crate::input::{self, Role};
use crate::{import, json};
use client::{Family, ProductProfile};
use job::{Diagnostic, Files, Folder, Job, Pragma, Severity, Step};
use std::cell::RefCell;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
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
    text: String,
    /// What it does.
    pub job: Job,
    /// Every file that was read for it.
    pub files: Vec<PathBuf>,
    /// Axes that a picture shows in mm.
    pub millimetres: Vec<Millimetres>,
    /// What the path of a program or a drawing covers.
    pub extent: Option<strokes::Extent>,
}

impl Source {
    /// Reads and compiles a job file; its warnings go to the error stream.
    pub fn open(path: &Path, drawing: &Drawing) -> Result<Self, Failure> {
        let source = Source::open_drawn(path, drawing, None)?;
        if let Some(extent) = &source.extent {
            complain!("{}: {extent}", source.name);
        }
        Ok(source)
    }

    /// The same, with a picture of the path of a program or a drawing.
    pub fn open_drawn(path: &Path, drawing: &Drawing, plot: Option<&Path>) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let kind = import::kind(path).map_err(|error| unread(&name, &error))?;
        if kind.is_some() {
            let found = import::job(path, drawing, plot)?;
            let mut source = Source::read(name, found.job, vec![path.to_owned(), found.file], path)?;
            source.millimetres = found.millimetres;
            source.extent = Some(found.extent);
            return Ok(source);
        }
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
            return Err(Failure::Input(format!(
                "{name}: this is no job by its name, but a machine file, which --machine takes beside G-code or a drawing; \
                 `beamtick machine check {name}` reads it"
            )));
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
        if plot.is_some() {
            return Err(Failure::Input(format!(
                "{name}: --plot of `check` is for G-code and drawings; `sim` draws what a job does"
            )));
        }
        if drawing.is_given() {
            return Err(Failure::Input(format!(
                "{name}: --machine, --layer, --at and --pass-stops are for G-code and drawings, and this is a job, which is \
                 in pulses already; {}",
                import::NAMED
            )));
        }
        let text = job::text::decode(bytes).map_err(|line| {
            Failure::Input(format!("{name}:{line}: the file is neither UTF-8, UTF-16 nor GBK text; save it as UTF-8"))
        })?;
        Source::read(name, text, read, path)
    }

    fn read(name: String, text: String, read: Vec<PathBuf>, path: &Path) -> Result<Self, Failure> {
        let files = Noted { folder: Folder::of(path), read: RefCell::new(read) };
        match compile(&text, &files).and_then(|job| match unknown_values(&job) {
            wrong if wrong.is_empty() => Ok(job),
            wrong => Err(wrong),
        }) {
            Ok(job) => {
                for warning in &job.warnings {
                    complain!("{}", show(warning, &name, &text).trim_end());
                }
                Ok(Source { name, text, job, files: files.read.into_inner(), millimetres: Vec::new(), extent: None })
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
                return Err(Failure::Input(show(&wrong, &self.name, &self.text)));
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
        show(&diagnostic, &self.name, &self.text)
    }
}

fn unread(name: &str, error: &std::io::Error) -> Failure {
    Failure::Input(format!("{name}: the job file cannot be read: {error}"))
}

/// Lines that are compiled at a time where a job is long: calls in a row need nothing of each
/// other.
const PART: usize = 20_000;
/// Calls of a path in a row that are compiled without the language around them. Fewer would cost
/// more than they save.
const RUN: usize = 64;

/// A job that does not compile as a whole is compiled in parts from so many lines on.
const MANY_LINES: usize = 200_000;
/// What reaches over the lines of a script: with it, parts are not what the whole is.
const FAR_REACHING: [&str; 6] = ["/*", "#define", "#pragma continue", "kbhit", "return", "GT_LoadConfig"];

/// Compiles a job. One that `import` wrote may be of any length: its calls name no variables after
/// the set-up. So may one that is as plain as that.
fn compile(text: &str, files: &Noted) -> Result<Job, Vec<Diagnostic>> {
    if text.starts_with(strokes::MARK) {
        return compile_parts(text, files);
    }
    job::compile(text, files).or_else(|found| {
        let is_plain = text.lines().nth(MANY_LINES).is_some() && !FAR_REACHING.iter().any(|word| text.contains(word));
        // What is wrong with a part is wrong with the whole, which has said what.
        if is_plain { compile_parts(text, files).map_err(|_| found) } else { Err(found) }
    })
}

/// Compiles a job part by part.
fn compile_parts(text: &str, files: &Noted) -> Result<Job, Vec<Diagnostic>> {
    let mut whole = Parts { text, files, job: None, from: 0, lines: 0 };
    // Calls in a row up to here, and where they begin: byte and line.
    let mut run: Vec<Step> = Vec::new();
    let (mut lasers, mut begin) = (0, (0, 0));
    let (mut at, mut line) = (0, 0u32);
    // Every line so far is a whole: what follows stands in no block and in no comment.
    let mut apart = true;
    for row in text.split_inclusive('\n') {
        let bare = row.strip_suffix('\n').unwrap_or(row);
        match job::quick::call(bare).filter(|_| apart) {
            Some(call) => {
                if run.is_empty() {
                    begin = (at, line);
                }
                lasers |= call.lasers;
                run.push(call.step(line + 1, at));
            }
            None => {
                if run.len() >= RUN {
                    whole.compile(begin.0, begin.1)?;
                    whole.append(&mut run, lasers, at, line);
                }
                (run, lasers) = (Vec::new(), 0);
                apart &= is_whole(bare);
                if (line - whole.lines) as usize >= PART {
                    whole.compile(at, line)?;
                }
            }
        }
        (at, line) = (at + row.len(), line + 1);
    }
    if run.len() >= RUN {
        whole.compile(begin.0, begin.1)?;
        whole.append(&mut run, lasers, at, line);
    }
    whole.compile(at, line)?;
    whole.job.map_or_else(|| job::compile(text, files), Ok)
}

/// Whether a line that somebody may have written into an imported job ends what it begins.
fn is_whole(line: &str) -> bool {
    let (code, comment) = line.split_once("//").unwrap_or((line, ""));
    let code = code.trim();
    let count = |of: char| code.matches(of).count();
    let ends = code.is_empty() || code.ends_with(';') || code.starts_with("#pragma");
    ends && count('{') == count('}') && count('(') == count(')') && !code.contains("/*") && !comment.ends_with('\\')
}

/// A job whose text is compiled in parts.
struct Parts<'t> {
    text: &'t str,
    files: &'t Noted,
    job: Option<Job>,
    /// What is compiled: bytes and lines.
    from: usize,
    lines: u32,
}

impl Parts<'_> {
    /// Compiles up to this byte, which begins this line, from 0.
    fn compile(&mut self, to: usize, lines: u32) -> Result<(), Vec<Diagnostic>> {
        let (at, line) = (self.from, self.lines);
        let part = self.text.get(at..to).filter(|part| !part.is_empty());
        let Some(part) = part else { return Ok(()) };
        let moved = |found: &mut Diagnostic| {
            found.line += line;
            found.span = found.span.start + at..found.span.end + at;
        };
        let mut job = job::compile(part, self.files).map_err(|mut found| {
            found.iter_mut().for_each(moved);
            found
        })?;
        job.warnings.iter_mut().for_each(moved);
        for step in &mut job.steps {
            step.line += line;
            step.span = step.span.start + at..step.span.end + at;
        }
        (self.from, self.lines) = (to, lines);
        match &mut self.job {
            None => self.job = Some(job),
            Some(whole) => {
                whole.steps.append(&mut job.steps);
                whole.warnings.append(&mut job.warnings);
                whole.axes.extend(job.axes);
                whole.axes.sort_unstable();
                whole.axes.dedup();
                for (axis, of) in job.named {
                    whole.named.entry(axis).or_insert(of + line);
                }
                whole.crds.extend(job.crds);
                whole.crds.sort_unstable();
                whole.crds.dedup();
                whole.pragmas.extend(job.pragmas);
                whole.lasers |= job.lasers;
            }
        }
        Ok(())
    }

    /// Appends steps of the text up to this byte. What `import` writes begins with the set-up.
    fn append(&mut self, steps: &mut Vec<Step>, lasers: u8, to: usize, lines: u32) {
        if let Some(job) = &mut self.job {
            job.steps.append(steps);
            job.lasers |= lasers;
            (self.from, self.lines) = (to, lines);
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

fn show(diagnostic: &Diagnostic, name: &str, text: &str) -> String {
    json::message(diagnostic, name);
    job::render(diagnostic, name, text, std::io::stderr().is_terminal())
}
