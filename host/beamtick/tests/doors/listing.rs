//! Statements of a job, as the reference writes its programs, read into steps.
//!
//! In: `long a3[] = {1,2}; prm.acc = 0.5; rtn = GTN_SetTrapPrm(1,2,&prm);`, `Sleep(2.5);`,
//! `WaitStop(1,3,0);`. Out: the steps of a description. Structs keep their members from statement
//! to statement, as variables do. What is no such statement is a panic.

use crate::program::{Call, Step, Value};
use job::api::{Pass, function};
use std::collections::HashMap;

/// What the doors wait for a path, ms.
const PATH_MS: u32 = 40;

/// What the variables of a listing hold.
#[derive(Default)]
pub struct Listing {
    arrays: HashMap<String, Vec<String>>,
    structs: HashMap<String, Vec<(String, Vec<String>)>>,
    /// The profile has several cores: functions keep `GTN_` and their core.
    cores: bool,
}

impl Listing {
    pub fn new(cores: bool) -> Listing {
        Listing { cores, ..Listing::default() }
    }

    /// The steps of a line.
    pub fn read(&mut self, line: &str) -> Vec<Step> {
        let statements = line.split(';').map(str::trim).filter(|statement| !statement.is_empty());
        statements.filter_map(|statement| self.statement(statement)).collect()
    }

    fn statement(&mut self, statement: &str) -> Option<Step> {
        let inside = |text: &str| -> Vec<String> {
            let list = &text[text.find('(').unwrap() + 1..text.rfind(')').unwrap()];
            list.split(',').map(|word| word.trim().to_owned()).filter(|word| !word.is_empty()).collect()
        };
        if statement.starts_with("Sleep") {
            let ms: f64 = inside(statement)[0].parse().unwrap();
            return Some(Step::Sleep(ms.ceil().max(1.0) as u32));
        }
        if statement.starts_with("WaitStop") {
            let words: Vec<i64> = inside(statement).iter().map(|word| word.parse().unwrap()).collect();
            // A path's end: long enough for most, and the same at every door.
            if words[2] != 0 {
                return Some(Step::Sleep(PATH_MS));
            }
            return Some(Step::Wait { core: words[0] as i16, axes: words[1] as u32 });
        }
        let (left, right) = statement.split_once('=').unwrap_or_else(|| panic!("no statement: {statement}"));
        let (left, right) = (left.trim(), right.trim());
        if left == "rtn" {
            return Some(self.call(right, inside(right)));
        }
        match left.split_once('.') {
            Some((name, member)) => {
                let (member, place) = match member.split_once('[') {
                    Some((member, index)) => (member, index.trim_end_matches(']').parse().unwrap()),
                    None => (member, 0usize),
                };
                let members = self.structs.entry(name.to_owned()).or_default();
                let at = members.iter().position(|(own, _)| own == member).unwrap_or_else(|| {
                    members.push((member.to_owned(), Vec::new()));
                    members.len() - 1
                });
                let values = &mut members[at].1;
                values.resize(values.len().max(place + 1), "0".to_owned());
                values[place] = right.to_owned();
            }
            None => {
                let name = left.split_whitespace().next_back().unwrap().split('[').next().unwrap();
                let list = right.trim_matches(['{', '}']).split(',').map(|word| word.trim().to_owned()).collect();
                self.arrays.insert(name.to_owned(), list);
            }
        }
        None
    }

    fn call(&self, text: &str, given: Vec<String>) -> Step {
        let name = &text[..text.find('(').unwrap()];
        // Bits 10 and 11 of a Stop exist in the form without a core alone.
        let (rest, cores) = match name.strip_prefix("GTN_") {
            Some(rest) => (rest, 1),
            None => (name.strip_prefix("GT_").unwrap_or(name), 0),
        };
        let function = function(rest).unwrap_or_else(|| panic!("{name} is no function"));
        let core: i16 = if cores == 1 { given[0].parse().unwrap() } else { 1 };
        let mut given = given[cores..].iter();
        let values = function.params.iter().map(|param| {
            let word = given.next();
            match (param.pass, word) {
                (Pass::Out | Pass::OutStruct(_), Some(_)) => Value::Out,
                (Pass::Working, _) => Value::Null,
                (Pass::Many(..) | Pass::Fixed(..), Some(word)) if word != "NULL" => {
                    // An array, or the address of a variable or of an array's first place.
                    let name = word.trim_start_matches('&').trim_end_matches("[0]");
                    let list = self.arrays.get(name).unwrap_or_else(|| panic!("{text}: {name} was never given values"));
                    Value::List(list.clone())
                }
                (Pass::Struct(_) | Pass::StructOrNull(_), Some(word)) if word != "NULL" => {
                    Value::Fields(self.structs[word.trim_start_matches('&')].clone())
                }
                (Pass::In(_), Some(word)) => Value::Number(word.clone()),
                (Pass::In(_), None) => Value::Number(param.default.expect("a default").to_string()),
                _ => Value::Null,
            }
        });
        let values = values.collect();
        Step::Call(Call { function, core: self.cores.then_some(core), values })
    }
}
