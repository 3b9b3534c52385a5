//! Configuration files, of both forms, read and loaded into a controller.
//!
//! The first byte chooses the file's name, which may say its form; the rest is its text. Held: a
//! file is read or refused with a text; what was read travels as one LoadConfig, which the
//! controller carries out or refuses by name.
use crate::bench::{Bench, Line};
use protocol::command::{LoadConfig, Request};
use protocol::record::Lane;
use virtual_board::{Config, Memory};
use zerocopy::IntoBytes;

const NAMES: [&str; 3] = ["axes.toml", "axes.cfg", "Axes.TOML"];

/// See the module text.
pub fn run(data: &[u8]) {
    let Some((name, text)) = data.split_first() else { return };
    let text = String::from_utf8_lossy(text);
    match job::config::read(NAMES[usize::from(*name) % NAMES.len()], &text) {
        Err(reason) => assert!(!reason.trim().is_empty(), "a refusal without a reason"),
        Ok(config) => {
            let mut axes: Vec<i16> = config.items.iter().map(|item| item.axis.get()).collect();
            assert!(axes.is_sorted() && axes.iter().all(|axis| (1..=32).contains(axis)), "{axes:?}");
            axes.dedup();
            assert_eq!(axes.len(), config.items.len(), "one item an axis");
            if config.items.is_empty() {
                return;
            }
            let mut memory = Memory::new(Config::default());
            let mut bench = Bench::new(&mut memory, Line::CLEAN);
            bench.open();
            let head = LoadConfig { core: 1.into(), count: (config.items.len() as u16).into() };
            let mut body = head.as_bytes().to_vec();
            body.extend(job::config::bytes(&config.items));
            bench.send(LoadConfig::OPCODE, Lane::Immediate, body, None);
            bench.settle();
        }
    }
}
