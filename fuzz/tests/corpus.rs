//! The targets over their kept corpora, and over seeded random inputs: what every test run does of
//! fuzzing.
//!
//! A plain run tries [`INPUTS`] of them for each target, the same in every run. `FUZZ_SECONDS` sets
//! a time instead, and `FUZZ_SEED` where they begin; `cargo xtask fuzz` goes further. Inputs are
//! mutated pieces of the corpus, so that they get where its inputs get.
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use std::path::Path;
use std::time::{Duration, Instant};

/// Random inputs of a target in a plain run.
const INPUTS: u64 = 100;

struct Random(SplitMix64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0.next_u64()
    }
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
    fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.next() as u8).collect()
    }
}

fn kept(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut all: Vec<_> = entries
        .map(|entry| entry.unwrap())
        .map(|entry| (entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path()).unwrap()))
        .collect();
    all.sort();
    all
}

fn random(inputs: &[(String, Vec<u8>)], random: &mut Random) -> Vec<u8> {
    let pick = |random: &mut Random| inputs.get(random.below(inputs.len())).map(|(_, bytes)| bytes.clone());
    if random.below(4) == 0 || inputs.is_empty() {
        let count = random.below(600);
        return random.bytes(count);
    }
    let mut input = pick(random).unwrap_or_default();
    // The head of one and the tail of another, with some bytes changed.
    if let Some(other) = pick(random).filter(|_| random.below(2) == 0) {
        input.truncate(random.below(input.len() + 1));
        input.extend_from_slice(&other[random.below(other.len() + 1)..]);
    }
    for _ in 0..random.below(8) {
        let at = random.below(input.len() + 1);
        match (random.below(3), input.get_mut(at)) {
            (0, Some(byte)) => *byte = random.next() as u8,
            (1, Some(_)) => drop(input.remove(at)),
            _ => input.insert(at, random.next() as u8),
        }
    }
    input
}

fn play(name: &str) {
    let (_, run) = fuzz::TARGETS.into_iter().find(|(target, _)| *target == name).unwrap();
    let inputs = kept(name);
    assert!(!inputs.is_empty(), "{name} has a corpus");
    for (file, bytes) in &inputs {
        if std::panic::catch_unwind(|| run(bytes)).is_err() {
            panic!("fuzz/corpus/{name}/{file}");
        }
    }
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().unwrap());
    let (seconds, seed) = (number("FUZZ_SECONDS"), number("FUZZ_SEED").unwrap_or(0x5EED));
    let began = Instant::now();
    let mut count = 0u64;
    while seconds.map_or(count < INPUTS, |seconds| began.elapsed() < Duration::from_secs(seconds)) {
        let input = random(&inputs, &mut Random(SplitMix64::seed_from_u64(seed.wrapping_add(count))));
        if std::panic::catch_unwind(|| run(&input)).is_err() {
            let path = std::env::temp_dir().join(format!("{name}-{seed}-{count}"));
            std::fs::write(&path, &input).unwrap();
            panic!("{name}: FUZZ_SEED={seed}, input {count}, kept as {}", path.display());
        }
        count += 1;
    }
    println!("{name}: {} inputs of the corpus, {count} random ones in {:.0?}", inputs.len(), began.elapsed());
}

#[test]
fn link() {
    play("link");
}

#[test]
fn machine() {
    play("machine");
}

#[test]
fn jobs() {
    play("jobs");
}

#[test]
fn config() {
    play("config");
}

#[test]
fn tables() {
    play("tables");
}
