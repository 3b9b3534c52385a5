//! Which data a tick touches, and in which memory they lie.
mod loads;

use h743::accesses::Accesses;
use h743::machine::Chip;
use loads::{LOADS, TICK};
use object::read::elf::ElfFile32;
use object::{LittleEndian, Object, ObjectSymbol};

#[test]
fn survey() {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return;
    };
    let elf = std::fs::read(path).unwrap();
    let file = ElfFile32::<LittleEndian>::parse(&*elf).unwrap();
    let mut symbols: Vec<(u32, u32, String)> = file
        .symbols()
        .filter(|s| s.size() > 0)
        .map(|s| (s.address() as u32 & !1, s.size() as u32, s.name().unwrap().to_owned()))
        .collect();
    symbols.sort();
    for load in &LOADS {
        let us = load.ticks[0].0;
        let begin = |chip: &mut Chip| chip.accesses = Some(Accesses::of(TICK));
        let end = |chip: &mut Chip| chip.accesses.take().unwrap();
        let (data, dark) = loads::start(&elf, load, us, true).run(load, us, 200, begin, end);
        println!("== {} {us} dark {dark} runs {}", load.name, data.runs);
        let mut regions = std::collections::BTreeMap::<&str, (usize, usize, u64, u64)>::new();
        for (&at, word) in &data.words {
            let region = match at {
                0..0xbc00 => "RAM",
                0xbc00..0x10000 => "CODE",
                0x0800_0000..0x0820_0000 => "FLASH",
                0x2000_0000..0x2000_4000 => "STACK",
                0x2000_4000..0x2001_0000 => "STATE",
                0x2001_0000..0x2002_0000 => "PATHS0",
                0x2400_0000..0x2408_0000 => "AXI",
                0x3000_0000..0x3003_0000 => "STORES",
                0x3003_0000..0x3004_2000 => "THREAD",
                0x3004_2000..0x3004_7f00 => "DMA",
                0x3800_0000..0x3801_0000 => "PATHS1",
                0x3880_0000..0x3880_1000 => "BACKUP",
                0x4000_0000..0x6000_0000 => "peripherals",
                0xe000_0000.. => "core",
                _ => "?",
            };
            let entry = regions.entry(region).or_default();
            entry.0 += 1;
            let hot = word.runs * 2 >= data.runs;
            entry.1 += usize::from(hot);
            entry.2 += word.reads;
            entry.3 += word.writes;
            if hot && ["RAM", "AXI", "STORES", "THREAD", "DMA", "BACKUP", "FLASH", "CODE", "PATHS1"].contains(&region) {
                let name = symbols
                    .iter()
                    .rfind(|s| s.0 <= at && at < s.0 + s.1)
                    .map_or("-".into(), |s| format!("{}+{}", s.2, at - s.0));
                println!("{region} {at:#x} runs {} r {} w {}: {name}", word.runs, word.reads, word.writes);
            }
        }
        for (region, (words, hot, r, w)) in regions {
            println!(
                "{region}: {words} words, {hot} hot, {:.1} r {:.1} w a tick",
                r as f64 / data.runs as f64,
                w as f64 / data.runs as f64
            );
        }
    }
}
