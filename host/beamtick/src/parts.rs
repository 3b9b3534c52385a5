//! A job of any length, compiled part by part as its text is read.
//!
//! In: the text of a job whose calls name no variables after the set-up, as `import` writes it.
//! Out: what [`job::compile`] makes of the whole. Owns the text that is not compiled yet: at most
//! some thousand lines. Fails with the diagnostics of a part, or where the text cannot be read.
use crate::script::Script;
use crate::totals::Totals;
use job::{Diagnostic, Files, Folder, Job, Step};
use std::collections::VecDeque;
use std::io::{self, BufRead};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

/// Lines that are compiled at first: the set-up is among them.
const FIRST_LINES: u32 = 20_000;
/// Lines that are compiled at a time after them: calls in a row need nothing of each other. A path
/// runs meanwhile, so it must not take long.
const PART_LINES: u32 = 2_000;
/// Calls of a path in a row that are compiled without the language around them. Fewer would cost
/// more than they save.
const RUN_CALLS: usize = 64;
/// Of these, as many are handed over together.
const TOGETHER_CALLS: usize = 512;
/// Parts that a thread compiles ahead of those who take them.
const AHEAD_PARTS: usize = 4;

/// A part of a job.
pub enum Part {
    /// Steps and what else they say of the job.
    Compiled(Job),
    /// Calls of a path. They name laser channels, a bit each, and nothing else.
    Calls {
        /// How many.
        count: usize,
        /// Bits of the channels.
        lasers: u8,
        /// The calls themselves, unless only their number is asked for.
        steps: Vec<Step>,
    },
}

/// Why there is no further part.
pub enum Broken {
    /// The text cannot be read.
    Text(io::Error),
    /// It does not compile.
    Job(Vec<Diagnostic>),
}

/// See the module text.
pub struct Parts<'s, R> {
    reader: R,
    files: &'s dyn Files,
    /// Whether the steps of calls in a row are made.
    makes_steps: bool,
    /// A line, and how much of the text is read: bytes and lines.
    row: String,
    at: usize,
    line: u32,
    /// What is read and not compiled: the text, its first byte and its first line.
    text: String,
    from: usize,
    first: u32,
    run: CallRow,
    /// Every line so far is a whole: what follows stands in no block and in no comment.
    apart: bool,
    due: VecDeque<Part>,
    ended: bool,
}

/// Calls in a row.
#[derive(Default)]
struct CallRow {
    count: usize,
    lasers: u8,
    steps: Vec<Step>,
    /// Where the text before them ends: byte of the uncompiled text, byte and line of the script.
    begin: (usize, usize, u32),
    /// There are so many that they are handed over as they are.
    long: bool,
}

impl<'s, R: BufRead> Parts<'s, R> {
    /// The parts of a text; `makes_steps`: see [`Part::Calls`].
    pub fn new(reader: R, files: &'s dyn Files, makes_steps: bool) -> Self {
        Parts {
            reader,
            files,
            makes_steps,
            row: String::new(),
            at: 0,
            line: 0,
            text: String::new(),
            from: 0,
            first: 0,
            run: CallRow::default(),
            apart: true,
            due: VecDeque::new(),
            ended: false,
        }
    }

    fn read(&mut self) -> Result<(), Broken> {
        self.row.clear();
        if self.reader.read_line(&mut self.row).map_err(Broken::Text)? == 0 {
            self.ended = true;
            self.end_run();
            let (at, line) = (self.at, self.line);
            return self.compile(self.text.len(), at, line);
        }
        let bare = self.row.strip_suffix('\n').unwrap_or(&self.row);
        match job::quick::call(bare).filter(|_| self.apart) {
            Some(call) => {
                let run = &mut self.run;
                if run.count == 0 && !run.long {
                    run.begin = (self.text.len(), self.at, self.line);
                }
                (run.count, run.lasers) = (run.count + 1, run.lasers | call.lasers);
                if self.makes_steps {
                    run.steps.push(call.step(self.line + 1, self.at));
                }
                self.count()?;
            }
            None => {
                let is_whole = is_whole(bare);
                self.end_run();
                self.apart &= is_whole;
                let most = if self.first == 0 { FIRST_LINES } else { PART_LINES };
                if self.line - self.first >= most {
                    let (at, line) = (self.at, self.line);
                    self.compile(self.text.len(), at, line)?;
                }
                self.text.push_str(&self.row);
            }
        }
        (self.at, self.line) = (self.at + self.row.len(), self.line + 1);
        Ok(())
    }

    /// A call of the run is read.
    fn count(&mut self) -> Result<(), Broken> {
        if !self.run.long {
            self.text.push_str(&self.row);
            if self.run.count == RUN_CALLS {
                let (size, at, line) = self.run.begin;
                self.compile(size, at, line)?;
                self.text.clear();
                self.run.long = true;
            }
        }
        if self.run.long && self.run.count >= TOGETHER_CALLS {
            self.hand_over();
        }
        Ok(())
    }

    fn hand_over(&mut self) {
        let CallRow { count, lasers, steps, .. } = std::mem::take(&mut self.run);
        self.run.long = true;
        if count > 0 {
            self.due.push_back(Part::Calls { count, lasers, steps });
        }
    }

    /// No call follows those in a row. Few of them are for the compiler.
    fn end_run(&mut self) {
        if self.run.long {
            self.hand_over();
            (self.from, self.first) = (self.at, self.line);
        }
        self.run = CallRow::default();
    }

    /// Compiles so much of the text, which ends at this byte and before this line of the script.
    fn compile(&mut self, size: usize, to: usize, lines: u32) -> Result<(), Broken> {
        let (at, line) = (self.from, self.first);
        let Some(part) = self.text.get(..size).filter(|part| !part.is_empty()) else { return Ok(()) };
        let moved = |found: &mut Diagnostic| {
            found.line += line;
            found.span = found.span.start + at..found.span.end + at;
        };
        let mut job = job::compile(part, self.files).map_err(|mut found| {
            found.iter_mut().for_each(moved);
            Broken::Job(found)
        })?;
        job.warnings.iter_mut().for_each(moved);
        job.named.values_mut().for_each(|of| *of += line);
        for pragma in &mut job.pragmas {
            pragma.line += line;
            pragma.span = pragma.span.start + at..pragma.span.end + at;
        }
        for step in &mut job.steps {
            step.line += line;
            step.span = step.span.start + at..step.span.end + at;
        }
        self.text.drain(..size);
        (self.from, self.first) = (to, lines);
        self.due.push_back(Part::Compiled(job));
        Ok(())
    }
}

/// The same with their steps, compiled by a thread while those before them run. It ends when nobody
/// takes them any more.
pub fn ahead(script: Arc<Script>, folder: Folder) -> Receiver<Result<Part, Broken>> {
    let (parts, taken) = sync_channel(AHEAD_PARTS);
    let failed = parts.clone();
    let compile = move || {
        let mut all = Parts::new(script.reader(), &folder, true);
        while all.next().is_some_and(|part| parts.send(part).is_ok()) {}
    };
    if let Err(error) = thread::Builder::new().name("compile".to_owned()).spawn(compile) {
        let _ = failed.send(Err(Broken::Text(error)));
    }
    taken
}

impl<R: BufRead> Iterator for Parts<'_, R> {
    type Item = Result<Part, Broken>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.due.is_empty() && !self.ended {
            if let Err(broken) = self.read() {
                self.ended = true;
                return Some(Err(broken));
            }
        }
        self.due.pop_front().map(Ok)
    }
}

/// Whether a line that somebody may have written into an imported job ends what it begins.
fn is_whole(line: &str) -> bool {
    let (code, comment) = line.split_once("//").unwrap_or((line, ""));
    let code = code.trim();
    let count = |of: char| code.matches(of).count();
    let ends = code.is_empty() || code.ends_with(';') || code.starts_with("#pragma");
    ends && count('{') == count('}') && count('(') == count(')') && !code.contains("/*") && !comment.ends_with('\\')
}

/// What a job is.
pub struct Compiled {
    /// What it does; the steps of one that is compiled in parts are not in it.
    pub job: Job,
    /// What its steps are as a whole.
    pub totals: Totals,
    /// It is compiled in parts.
    pub in_parts: bool,
}

/// Compiles a job part by part.
pub fn compile(reader: impl BufRead, files: &dyn Files) -> Result<Compiled, Broken> {
    let mut job = job::compile("", files).map_err(Broken::Job)?;
    let mut totals = Totals::default();
    for part in Parts::new(reader, files, false) {
        match part? {
            Part::Compiled(part) => {
                totals.add(&part.steps);
                add(&mut job, part);
            }
            Part::Calls { count, lasers, .. } => {
                totals.add_calls(count);
                job.lasers |= lasers;
            }
        }
    }
    Ok(Compiled { job, totals, in_parts: true })
}

/// Adds what a part says of the job to what those before it said; its steps are not in it.
fn add(whole: &mut Job, mut part: Job) {
    whole.warnings.append(&mut part.warnings);
    whole.axes.extend(part.axes);
    whole.axes.sort_unstable();
    whole.axes.dedup();
    for (axis, line) in part.named {
        whole.named.entry(axis).or_insert(line);
    }
    whole.crds.extend(part.crds);
    whole.crds.sort_unstable();
    whole.crds.dedup();
    whole.pragmas.extend(part.pragmas);
    whole.lasers |= part.lasers;
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    struct Nowhere;

    impl Files for Nowhere {
        fn text(&self, path: &str) -> Result<String, String> {
            Err(path.to_owned())
        }
    }

    /// Calls in a row, more than are handed over together, and fewer than are worth it; between
    /// them what is for the compiler.
    fn text() -> String {
        let mut text = "// A job\nTCrdPrm crd = {0};\ncrd.dimension = 2;\nGT_SetCrdPrm(1, &crd);\n".to_owned();
        for (row, between) in [(10, "GT_CrdStart(1, 0);\n"), (1400, "GT_BufDelay(1, 20); // ö\n"), (63, "\n"), (64, "")]
        {
            for x in 0..row {
                text += &format!("GT_LnXY(1, {x}, 0, 50, 2); // {x}\nGT_BufLaserPrfCmd(1, {x}.5, 0, 1);\n");
            }
            text += between;
        }
        text + "GT_ArcXYC(1, 5, 5, 0, 5, 1, 50, 2); // a\n#pragma family gus\nWaitStop(1, 0, 1);\n"
    }

    fn steps(script: &Script, makes_steps: bool) -> (Vec<Step>, usize, Job) {
        let mut whole = job::compile("", &Nowhere).unwrap();
        let (mut steps, mut count) = (Vec::new(), 0);
        for part in Parts::new(script.reader(), &Nowhere, makes_steps) {
            let Ok(part) = part else { panic!("it compiles") };
            match part {
                Part::Compiled(mut job) => {
                    count += job.steps.len();
                    steps.append(&mut job.steps);
                    add(&mut whole, job);
                }
                Part::Calls { count: more, lasers, steps: mut calls } => {
                    assert!(more <= TOGETHER_CALLS);
                    count += more;
                    steps.append(&mut calls);
                    whole.lasers |= lasers;
                }
            }
        }
        (steps, count, whole)
    }

    #[test]
    fn parts_are_what_the_whole_is() {
        let mut expected = job::compile(&text(), &Nowhere).unwrap();
        let all = std::mem::take(&mut expected.steps);
        for script in [Script::Whole(text()), Script::kept(Cursor::new(text().into_bytes()))] {
            let (found, count, job) = steps(&script, true);
            assert_eq!((found.len(), count), (all.len(), all.len()));
            assert!(found == all && job == expected);
            let (found, count, job) = steps(&script, false);
            assert!(found.len() < 200 && count == all.len() && job == expected);
        }
    }

    #[test]
    fn a_fault_has_its_place() {
        let text = text() + "GT_LnXY(1, 5, 0, 50);\n";
        let Err(expected) = job::compile(&text, &Nowhere) else { panic!("a parameter is missing") };
        let script = Script::kept(Cursor::new(text.into_bytes()));
        let Some(Err(Broken::Job(found))) = Parts::new(script.reader(), &Nowhere, false).find(Result::is_err) else {
            panic!("a parameter is missing")
        };
        assert_eq!(found, expected);
        let line = found[0].line;
        let shown = script.show(&found[0], "a.gts", false);
        assert!(shown.contains(&format!("a.gts:{line}:")) && shown.contains("│ GT_LnXY(1, 5, 0, 50);"), "{shown}");
    }
}
