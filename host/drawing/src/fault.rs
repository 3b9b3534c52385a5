//! What is wrong with a file.

/// What is wrong, and in which line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    pub line: Option<u32>,
    pub text: String,
}

impl Fault {
    pub fn whole(text: impl Into<String>) -> Fault {
        Fault { line: None, text: text.into() }
    }

    pub fn at(line: u32, text: impl Into<String>) -> Fault {
        Fault { line: Some(line), text: text.into() }
    }
}
