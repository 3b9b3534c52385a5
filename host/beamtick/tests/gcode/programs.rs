//! Random programs: all words that are supported, in lines that mean something.
use super::model::{Model, Word};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// A program as text, and as words for the model.
pub struct Program {
    pub text: String,
    pub lines: Vec<Vec<Word>>,
}

pub struct Maker<'a> {
    pub random: &'a mut Xoshiro256PlusPlus,
    pub lines: Vec<Vec<Word>>,
    inch: bool,
    relative: bool,
    plane: usize,
    inverse: bool,
    centre_absolute: bool,
}

fn word(letter: char, number: impl ToString) -> Word {
    (letter, number.to_string())
}

impl Maker<'_> {
    fn pick(&mut self, most: u64) -> u64 {
        self.random.next_u64() % most
    }

    /// Thousandths (of an inch: ten-thousandths) from −most to most mm, none near zero.
    fn length(&mut self, most: u64) -> i64 {
        let size = (600 + self.pick(most * 1000 - 600)) as i64;
        let size = if self.inch { size * 10 / 25 } else { size };
        if self.pick(2) == 0 { size } else { -size }
    }

    /// As the program writes it.
    fn number(&self, length: i64) -> String {
        let unit = if self.inch { 10_000 } else { 1000 };
        let digits = if self.inch { 4 } else { 3 };
        let sign = if length < 0 { "-" } else { "" };
        let (whole, part) = (length.abs() / unit, length.abs() % unit);
        format!("{sign}{whole}.{part:0digits$}")
    }

    fn put(&mut self, words: Vec<Word>) {
        self.lines.push(words);
    }

    fn g(&mut self, code: &str) {
        self.put(vec![word('G', code)]);
    }

    /// F for a feed motion where it is needed, or by chance.
    fn feed(&mut self, words: &mut Vec<Word>) {
        if self.inverse {
            words.push(word('F', 200 + self.pick(800)));
        } else if self.pick(3) == 0 {
            let mm = 4000 + self.pick(12_000);
            words.push(word('F', if self.inch { mm / 25 } else { mm }));
        }
    }

    fn axis_words(&mut self) -> Vec<Word> {
        let mut words = Vec::new();
        let axes = 1 + self.pick(7);
        for (bit, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if axes >> bit & 1 == 1 {
                let length = self.length(8);
                words.push(word(letter, self.number(length)));
            }
        }
        words
    }

    fn arc(&mut self) {
        let [a, b, c] = [[0, 1, 2], [2, 0, 1], [1, 2, 0]][self.plane];
        let names = ['X', 'Y', 'Z'];
        // Where the arc begins, in numbers of the program.
        let start = [self.length(8), self.length(8)];
        if !self.relative {
            let words =
                vec![word('G', 0), word(names[a], self.number(start[0])), word(names[b], self.number(start[1]))];
            self.put(words);
        }
        let base = if self.relative { [0, 0] } else { start };
        let mut words = vec![word('G', 2 + self.pick(2))];
        self.feed(&mut words);
        let helix = self.pick(3) == 0;
        let (i, j) = (self.length(4), self.length(4));
        let quarter = [[0, 0], [2 * i, 2 * j], [i + j, j - i], [i - j, i + j]];
        match self.pick(5) {
            4 => {
                // By its radius: any end, a radius that reaches it.
                let end = [self.length(4), self.length(4)];
                let reach = ((end[0] * end[0] + end[1] * end[1]) as f64).sqrt() / 2.0;
                let radius = reach as i64 + 30 + self.pick(2000) as i64;
                let radius = if self.pick(3) == 0 { -radius } else { radius };
                words.push(word(names[a], self.number(base[0] + end[0])));
                words.push(word(names[b], self.number(base[1] + end[1])));
                words.push(word('R', self.number(radius)));
            }
            kind => {
                let end = quarter[kind as usize];
                if kind > 0 || self.pick(2) == 0 {
                    words.push(word(names[a], self.number(base[0] + end[0])));
                    words.push(word(names[b], self.number(base[1] + end[1])));
                }
                let centre = if self.centre_absolute { [start[0] + i, start[1] + j] } else { [i, j] };
                if self.centre_absolute && self.relative {
                    // A centre in the program's coordinates needs a start that is known in them.
                    return;
                }
                words.push(word(['I', 'J', 'K'][a], self.number(centre[0])));
                words.push(word(['I', 'J', 'K'][b], self.number(centre[1])));
            }
        }
        if helix {
            let length = self.length(3);
            words.push(word(names[c], self.number(length)));
        }
        self.put(words);
    }

    fn light(&mut self, words: &mut Vec<Word>) {
        match self.pick(6) {
            0 => words.push(word('S', [0, 300, 750, 1000][self.pick(4) as usize])),
            1 => {
                let m = 3 + self.pick(3);
                words.extend([word('M', m), word('S', 100 + self.pick(900))]);
            }
            _ => {}
        }
    }

    fn statement(&mut self) {
        match self.pick(26) {
            0..=7 => {
                let mut words = vec![word('G', self.pick(2))];
                self.feed(&mut words);
                words.extend(self.axis_words());
                self.light(&mut words);
                self.put(words);
            }
            8..=12 => self.arc(),
            13 => {
                self.inch = self.pick(2) == 0;
                self.g(if self.inch { "20" } else { "21" });
                // A feed of the old unit would be out of all measure.
                self.put(vec![word('F', if self.inverse || self.inch { 300 } else { 8000 })]);
            }
            14 => {
                self.plane = self.pick(3) as usize;
                let plane = ["17", "18", "19"][self.plane];
                self.g(plane);
            }
            15 => {
                self.relative = self.pick(2) == 0;
                self.g(if self.relative { "91" } else { "90" });
            }
            16 => {
                self.centre_absolute = self.pick(2) == 0;
                self.g(if self.centre_absolute { "90.1" } else { "91.1" });
            }
            17 => {
                self.inverse = self.pick(2) == 0;
                let feed = if self.inverse || self.inch { 300 } else { 8000 };
                self.put(vec![word('G', if self.inverse { 93 } else { 94 }), word('F', feed)]);
            }
            18 => {
                let mut words = vec![word('G', 10), word('L', [2, 20][self.pick(2) as usize]), word('P', self.pick(7))];
                words.extend(self.axis_words());
                self.put(words);
            }
            19 => {
                let code = ["28", "30", "28.1", "30.1"][self.pick(4) as usize];
                let mut words = vec![word('G', code)];
                if !code.contains('.') && self.pick(2) == 0 {
                    words.extend(self.axis_words());
                }
                self.put(words);
            }
            20 => {
                let code = ["43.1", "49"][self.pick(2) as usize];
                let mut words = vec![word('G', code)];
                if code == "43.1" {
                    words.extend(self.axis_words());
                }
                self.put(words);
            }
            21 => {
                let mut words = vec![word('G', 53), word('G', self.pick(2))];
                self.feed(&mut words);
                words.extend(self.axis_words());
                self.put(words);
            }
            22 => {
                let code = ["54", "55", "56", "57", "58", "59"][self.pick(6) as usize];
                self.g(code);
            }
            23 => {
                let code = ["92", "92", "92.1", "92.2", "92.3"][self.pick(5) as usize];
                let mut words = vec![word('G', code)];
                if code == "92" {
                    words.extend(self.axis_words());
                }
                self.put(words);
            }
            24 => {
                let ms = 10 + self.pick(30);
                let mut words = vec![word('G', 4), word('P', format!("0.{ms:03}"))];
                if self.pick(3) == 0 {
                    words.push(word('M', [0, 1][self.pick(2) as usize]));
                }
                self.put(words);
            }
            _ => {
                let words = match self.pick(7) {
                    0 => vec![word('G', 40)],
                    1 => vec![word('G', 61)],
                    2 => vec![word('G', 64), word('P', "0.05")],
                    3 => vec![word('G', 80)],
                    4 => vec![word('M', 7 + self.pick(3))],
                    5 => vec![word('T', 1 + self.pick(9))],
                    _ => vec![word('M', 3 + self.pick(3)), word('S', 200 + self.pick(800))],
                };
                self.put(words);
            }
        }
    }
}

/// A program of some twenty lines.
pub fn program(random: &mut Xoshiro256PlusPlus) -> Program {
    let mut maker = Maker {
        random,
        lines: Vec::new(),
        inch: false,
        relative: false,
        plane: 0,
        inverse: false,
        centre_absolute: false,
    };
    maker.put(vec![word('G', 21), word('G', 90), word('F', 9000)]);
    let spindle = 3 + maker.pick(2);
    maker.put(vec![word('M', spindle), word('S', 500)]);
    for _ in 0..16 {
        maker.statement();
    }
    if maker.pick(2) == 0 {
        let end = [2, 30][maker.pick(2) as usize];
        maker.put(vec![word('M', end)]);
        maker.put(vec![word('G', 0), word('X', 1)]);
    }
    let lines = std::mem::take(&mut maker.lines);
    let mut text = "%\n(made by a test)\n$H\n".to_owned();
    for (number, words) in lines.iter().enumerate() {
        let mut line = String::new();
        if maker.pick(3) == 0 {
            line += &format!("N{} ", 10 * number);
        }
        for (letter, number) in words {
            let letter = if maker.pick(4) == 0 { letter.to_ascii_lowercase() } else { *letter };
            line += &format!("{letter}{number}");
            line += ["", " ", "  ", "(a G1 X9 in a comment)"][[0, 1, 1, 1, 2, 3][maker.pick(6) as usize]];
        }
        if maker.pick(5) == 0 {
            line += "; M3 S1000";
        }
        text += &(line + ["\n", "\r\n"][maker.pick(2) as usize]);
    }
    Program { text, lines }
}

/// Runs it in the model.
pub fn run(program: &Program, model: &mut Model) {
    for words in &program.lines {
        model.line(words);
    }
}
