//! Which data a tick reads and writes, and in which memory they lie, in the flash image that
//! BEAMTICK_H743_IMAGE names: the table of docs/board-h743-registers.md, "Memory".
//!
//! In: the image, the page. Out: with BEAMTICK_NUMBERS, the table written anew. It fails where most
//! ticks touch a word that lies neither in DTCM nor among [`EXCEPTIONS`], and where a load takes
//! more accesses to slower memory than the page says.
mod loads;

use client::Client;
use h743::accesses::{Accesses, Word};
use h743::machine::Chip;
use loads::{LOADS, Load, TICK};
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSymbol};
use protocol::command::Sleep;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Ticks of a load.
const TICKS: usize = 200;
/// The words in ITCM that most ticks touch all the same: part of the symbol's name, and reads of a
/// tick, without a program and while one waits. They are the counters of what the thread has put
/// into a ring, and the entry that waits. A ring is one object, 2 or 8 KiB: DTCM has no room for
/// it.
const EXCEPTIONS: [(&str, [f64; 2]); 2] = [("IMMEDIATE_LANE", [1.0, 2.0]), ("PROGRAM_LANE", [0.0, 2.0])];

const BEGIN: &str = "<!-- data of a tick: written with BEAMTICK_NUMBERS by host/h743/tests/tick_data.rs -->\n";
const END: &str = "<!-- end of data of a tick -->";

/// Memory by what an access costs the core; the regions of `memory.x`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// One cycle, apart from the fetches: DTCM.
    Dtcm,
    /// Data of ITCM, beside the fetches.
    Itcm,
    /// Constants among the code in ITCM.
    Literal,
    /// Through the D-cache: constants in flash.
    Flash,
    /// Not cached: what DMA reads, and headers.
    Uncached,
    /// Through the D-cache: tables, stores, paths.
    Cached,
    /// Registers.
    Peripheral,
}

const KINDS: [Kind; 7] =
    [Kind::Dtcm, Kind::Itcm, Kind::Literal, Kind::Flash, Kind::Uncached, Kind::Cached, Kind::Peripheral];

fn kind(address: u32) -> Kind {
    match address {
        0..0xbc00 => Kind::Itcm,
        0xbc00..0x1_0000 => Kind::Literal,
        0x0800_0000..0x0820_0000 => Kind::Flash,
        // PATHS0 too.
        0x2000_0000..0x2002_0000 => Kind::Dtcm,
        0x3004_2000..0x3004_8000 => Kind::Uncached,
        0x2400_0000..0x2408_0000 | 0x3000_0000..0x3004_2000 | 0x3800_0000..0x3881_0000 => Kind::Cached,
        0x4000_0000..0x6000_0000 | 0xe000_0000.. => Kind::Peripheral,
        _ => panic!("a tick touches {address:#010x}"),
    }
}

/// Names by address.
struct Symbols(Vec<(u32, u32, String)>);

impl Symbols {
    fn of(elf: &[u8]) -> Symbols {
        let file = ElfFile32::<LittleEndian>::parse(elf).unwrap();
        let named = file.symbols().filter(|symbol| symbol.size() > 0);
        Symbols(
            named
                .map(|symbol| (symbol.address() as u32 & !1, symbol.size() as u32, symbol.name().unwrap().to_owned()))
                .collect(),
        )
    }

    /// All that have a byte in a word.
    fn at(&self, word: u32) -> String {
        let of = |(at, size, _): &&(u32, u32, String)| *at < word + 4 && word < at + size;
        self.0.iter().filter(of).map(|(.., name)| &**name).collect::<Vec<_>>().join(", ")
    }
}

/// The words that lie where they should not, each with the ticks and accesses of it.
fn misplaced(data: &Accesses, symbols: &Symbols, in_a_program: bool) -> Vec<String> {
    let is_hot = |word: &Word| 2 * word.runs >= data.runs;
    let hot = data.words.iter().filter(|(_, word)| is_hot(word));
    hot.filter(|(at, word)| match kind(**at) {
        Kind::Dtcm | Kind::Peripheral | Kind::Flash => false,
        // Nobody may write there; a constant costs what its fetch would.
        Kind::Literal => word.writes > 0,
        Kind::Itcm => {
            let name = symbols.at(**at);
            let most = EXCEPTIONS
                .iter()
                .find(|(part, _)| name.contains(part))
                .map_or(0.0, |(_, most)| most[usize::from(in_a_program)]);
            word.writes > 0 || word.reads as f64 > most * data.runs as f64
        }
        Kind::Uncached | Kind::Cached => true,
    })
    .map(|(at, word)| {
        let (runs, name) = (data.runs, symbols.at(*at));
        format!("{at:#010x} ({name}): {} reads, {} writes in {} of {runs} ticks", word.reads, word.writes, word.runs)
    })
    .collect()
}

/// Accesses of a tick by kind, in the mean.
fn accesses(data: &Accesses) -> [f64; KINDS.len()] {
    KINDS.map(|of| {
        let words = data.words.iter().filter(|(at, _)| kind(**at) == of);
        words.map(|(_, word)| word.reads + word.writes).sum::<u64>() as f64 / data.runs as f64
    })
}

/// A row may grow by 3 % and half an access.
fn bound(stated: f64) -> f64 {
    stated * 1.03 + 0.5
}

const IN_A_PROGRAM: &str = "the first while a program waits";

fn counted(elf: &[u8], load: &Load, in_a_program: bool) -> Accesses {
    let us = load.ticks[load.ticks.len() / 2].0;
    let begin = |chip: &mut Chip| chip.accesses = Some(Accesses::of(TICK));
    let end = |chip: &mut Chip| chip.accesses.take().unwrap();
    let loaded = loads::start(elf, load, us, true);
    if in_a_program {
        begin(&mut h743::link::lock(&loaded.shared).chip);
        wait_in_a_program(&loaded.client);
        return end(&mut h743::link::lock(&loaded.shared).chip);
    }
    let (data, dark) = loaded.run(load, us, TICKS, begin, end);
    assert!(!dark, "{}: a tick of {us} µs overran", load.name);
    assert!(data.runs > TICKS as u64 / 2, "{}: {} ticks", load.name, data.runs);
    data
}

fn wait_in_a_program(client: &Client) {
    let mut program = client.program();
    program.push(Sleep { ns: 50_000_000.into() });
    program.run(false, &mut client::Quiet).unwrap();
}

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/board-h743-registers.md")
}

#[test]
fn what_each_tick_touches_lies_in_dtcm() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return;
    };
    let elf = std::fs::read(path).unwrap();
    let symbols = Symbols::of(&elf);
    let text = std::fs::read_to_string(page()).unwrap();
    let (before, rest) = text.split_once(BEGIN).unwrap();
    let (stated, after) = rest.split_once(END).unwrap();
    let mut table = String::from(
        "| load | DTCM | data in ITCM | constants in ITCM | constants in flash | not cached | cached SRAM | registers |\n\
         | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
    );
    let rows = LOADS.iter().map(|load| (load.name, load, false)).chain([(IN_A_PROGRAM, &LOADS[0], true)]);
    let (mut wrong, mut more) = (Vec::new(), Vec::new());
    for (name, load, in_a_program) in rows {
        let data = counted(&elf, load, in_a_program);
        wrong.extend(misplaced(&data, &symbols, in_a_program).into_iter().map(|word| format!("{name}: {word}")));
        let is = accesses(&data);
        let begin = format!("| {name} |");
        let row = is.iter().fold(begin.clone(), |row, count| format!("{row} {count:.1} |"));
        println!("{row}");
        writeln!(table, "{row}").unwrap();
        let said = stated.lines().find_map(|line| line.strip_prefix(&begin)).unwrap_or_default();
        let said: Vec<f64> = said.split('|').filter_map(|cell| cell.trim().parse().ok()).collect();
        // DTCM is where data should be.
        let is_more = |n: usize| said.get(n).is_none_or(|said| is[n] > bound(*said));
        more.extend(
            (1..is.len())
                .filter(|n| is_more(*n))
                .map(|n| format!("{name}: {:.1} accesses to {:?}; the page says {said:?}", is[n], KINDS[n])),
        );
    }
    assert!(wrong.is_empty(), "most ticks touch what does not lie in DTCM: {wrong:#?}");
    if std::env::var_os("BEAMTICK_NUMBERS").is_some() {
        std::fs::write(page(), format!("{before}{BEGIN}{table}{END}{after}")).unwrap();
        return;
    }
    assert!(more.is_empty(), "more than the page says: {more:#?}");
}
