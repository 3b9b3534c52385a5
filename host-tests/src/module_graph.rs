//! Which module of a crate uses which other, read from its source.
//!
//! In: the `src` folder of a crate. Out: circles among the modules of one folder. A folder counts
//! as one with the file that declares it, and with everything below it. What a method belongs to is
//! not seen: only paths are, in `use` and in code, and names that a folder hands on.
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The path of a module, from the root of its crate.
type Module = Vec<String>;

/// What one module says.
#[derive(Default)]
struct Source {
    /// Names that `use` brings in, and what they stand for.
    imports: BTreeMap<String, Vec<String>>,
    /// All paths, those of `use` among them.
    paths: Vec<Vec<String>>,
}

/// The modules of one crate.
#[derive(Default)]
pub struct Modules {
    sources: BTreeMap<Module, Source>,
}

impl Modules {
    /// Reads every file below a `src` folder, but those of unit tests.
    pub fn of_crate(source: &Path) -> Modules {
        let mut modules = Modules::default();
        modules.read(source, &mut Module::new());
        modules
    }

    fn read(&mut self, folder: &Path, module: &mut Module) {
        for entry in fs::read_dir(folder).expect("a folder of sources") {
            let path = entry.expect("an entry of a folder").path();
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            if name == "tests" {
                continue;
            }
            if path.is_dir() {
                module.push(name);
                self.read(&path, module);
                module.pop();
            } else {
                let own = if ["lib", "main", "mod"].contains(&name.as_str()) { None } else { Some(name) };
                let module = module.iter().cloned().chain(own).collect();
                self.add(module, &fs::read_to_string(&path).expect("text"));
            }
        }
    }

    /// One module with its text.
    pub fn add(&mut self, module: Module, text: &str) {
        let (code, _) = text.split_once("#[cfg(test)]\nmod tests {").unwrap_or((text, ""));
        self.sources.insert(module, Source::of(&tokens(code)));
    }

    /// How many paths lead from one module to another.
    pub fn uses(&self) -> usize {
        self.edges().len()
    }

    /// Pairs of modules of which the first uses the second.
    fn edges(&self) -> BTreeSet<(Module, Module)> {
        let mut edges = BTreeSet::new();
        for (module, source) in &self.sources {
            let used = source.paths.iter().filter_map(|path| self.resolve(module, path, 0));
            edges.extend(used.filter(|used| used != module).map(|used| (module.clone(), used)));
        }
        edges
    }

    /// The module in which what a path names is defined.
    fn resolve(&self, from: &Module, path: &[String], depth: usize) -> Option<Module> {
        let mut at = from.clone();
        for (index, name) in path.iter().enumerate() {
            match name.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => drop(at.pop()?),
                name => {
                    let child: Module = at.iter().cloned().chain([name.to_string()]).collect();
                    if self.sources.contains_key(&child) {
                        at = child;
                    } else if let Some(import) = self.sources.get(&at).and_then(|source| source.imports.get(name))
                        && depth < 8
                    {
                        let whole: Vec<String> = import.iter().chain(&path[index + 1..]).cloned().collect();
                        return self.resolve(&at, &whole, depth + 1);
                    } else {
                        return (index > 0).then_some(at);
                    }
                }
            }
        }
        Some(at)
    }

    /// Circles among the modules of each folder, as the paths of those in one.
    pub fn circles(&self) -> Vec<String> {
        let mut siblings: BTreeMap<Module, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
        for (from, to) in self.edges() {
            let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if let (Some(own), Some(used)) = (from.get(common), to.get(common)) {
                let folder = siblings.entry(from[..common].to_vec()).or_default();
                folder.entry(own.clone()).or_default().insert(used.clone());
            }
        }
        let mut circles = Vec::new();
        for (folder, uses) in siblings {
            let reached: BTreeMap<&String, BTreeSet<&String>> =
                uses.keys().map(|module| (module, reached(&uses, module))).collect();
            let mut done = BTreeSet::new();
            for (&module, from_here) in &reached {
                if from_here.contains(module) && !done.contains(module) {
                    let mutual = |other: &&String| reached.get(*other).is_some_and(|back| back.contains(module));
                    let circle: Vec<&String> = from_here.iter().copied().filter(mutual).collect();
                    circles.push(format!("{}: {circle:?}", folder.join("::")));
                    done.extend(circle);
                }
            }
        }
        circles
    }
}

/// What a module uses, and what that uses.
fn reached<'a>(uses: &'a BTreeMap<String, BTreeSet<String>>, module: &String) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<&String> = uses[module].iter().collect();
    while let Some(next) = open.pop() {
        if reached.insert(next) {
            open.extend(uses.get(next).into_iter().flatten());
        }
    }
    reached
}

/// Names and marks of code, without comments and literals of text.
fn tokens(code: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    for line in code.lines() {
        let line = line.split("//").next().unwrap_or_default();
        // What stands between quotes is no code.
        for code in line.split('"').step_by(2) {
            let mut name = String::new();
            for letter in code.chars().chain([' ']) {
                if letter.is_alphanumeric() || letter == '_' {
                    name.push(letter);
                    continue;
                }
                if !name.is_empty() {
                    tokens.push(std::mem::take(&mut name));
                }
                match letter {
                    ':' if tokens.last().is_some_and(|last| last == ":") => *tokens.last_mut().unwrap() = "::".into(),
                    letter if letter.is_whitespace() => {}
                    letter => tokens.push(letter.to_string()),
                }
            }
        }
    }
    tokens
}

fn is_name(token: &str) -> bool {
    token.starts_with(|letter: char| letter.is_alphabetic() || letter == '_')
}

impl Source {
    fn of(tokens: &[String]) -> Source {
        let mut source = Source::default();
        let mut at = 0;
        while at < tokens.len() {
            if tokens[at] == "use" {
                at += 1;
                source.tree(tokens, &mut at, &[]);
            } else if is_name(&tokens[at]) {
                let mut path = vec![tokens[at].clone()];
                at += 1;
                while at + 1 < tokens.len() && tokens[at] == "::" && is_name(&tokens[at + 1]) {
                    path.push(tokens[at + 1].clone());
                    at += 2;
                }
                if path.len() > 1 {
                    source.paths.push(path);
                }
            } else {
                at += 1;
            }
        }
        source
    }

    /// One tree of a `use`: `a::b`, `a::{b, c as d}`, `a::*`.
    fn tree(&mut self, tokens: &[String], at: &mut usize, before: &[String]) {
        let mut path = before.to_vec();
        while let Some(token) = tokens.get(*at) {
            *at += 1;
            match token.as_str() {
                "::" => {}
                "{" => {
                    while tokens.get(*at).is_some_and(|token| token != "}") {
                        self.tree(tokens, at, &path);
                        if tokens.get(*at).is_some_and(|token| token == ",") {
                            *at += 1;
                        }
                    }
                    *at += 1;
                    return;
                }
                "as" => {
                    self.imports.insert(tokens[*at].clone(), path.clone());
                    self.paths.push(path);
                    *at += 1;
                    return;
                }
                "*" => {
                    self.paths.push(path);
                    return;
                }
                name if is_name(name) => path.push(name.to_string()),
                _ => {
                    *at -= 1;
                    break;
                }
            }
        }
        if path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        if let Some(last) = path.last() {
            self.imports.insert(last.clone(), path.clone());
            self.paths.push(path);
        }
    }
}
