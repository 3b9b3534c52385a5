//! Registers of the models as a reset leaves them, and how wide they are, beside ST's SVD file.
//!
//! The values are those of the crate `stm32h7` 0.16.0, device `stm32h743` (ST's SVD file with the
//! corrections of stm32-rs): nothing of ours is in it. Where the model has another value, the
//! reason and its source stand in [`OTHERWISE`]. What the image relies on there, it writes itself,
//! or docs/board-assumptions.md lists it.
use h743::Machine;
use std::collections::HashMap;
use stm32_metapac::metadata::METADATA;
use stm32_metapac::metadata::ir::{BitOffset, BlockItemInner};

/// A register: its name, its offset, its value after a reset.
type Register = (&'static str, u32, u32);

const TIMER: &[Register] = &[
    ("CR1", 0x00, 0),
    ("CR2", 0x04, 0),
    ("SMCR", 0x08, 0),
    ("DIER", 0x0c, 0),
    ("SR", 0x10, 0),
    ("CCMR1", 0x18, 0),
    ("CCER", 0x20, 0),
    ("CNT", 0x24, 0),
    ("PSC", 0x28, 0),
    ("ARR", 0x2c, 0),
    ("DCR", 0x48, 0),
];
const OF_LASERS: &[Register] = &[("RCR", 0x30, 0), ("CCR1", 0x34, 0), ("BDTR", 0x44, 0), ("AF1", 0x60, 0)];
const PORT: &[Register] = &[("OTYPER", 0x04, 0), ("ODR", 0x14, 0), ("AFRL", 0x20, 0), ("AFRH", 0x24, 0)];

/// Peripherals and their registers.
const TABLE: &[(&str, &[Register])] = &[
    ("TIM1", TIMER),
    ("TIM1", OF_LASERS),
    ("TIM2", TIMER),
    ("TIM8", TIMER),
    ("TIM8", OF_LASERS),
    ("TIM15", TIMER),
    ("TIM15", OF_LASERS),
    (
        "RCC",
        &[
            ("CR", 0x00, 0x0000_0083),
            ("HSICFGR", 0x04, 0x4000_0000),
            ("CFGR", 0x10, 0),
            ("D1CFGR", 0x18, 0),
            ("D2CFGR", 0x1c, 0),
            ("D3CFGR", 0x20, 0),
            ("PLLCKSELR", 0x28, 0x0202_0200),
            ("PLLCFGR", 0x2c, 0x01ff_0000),
            ("PLL1DIVR", 0x30, 0x0101_0280),
            ("D1CCIPR", 0x4c, 0),
            ("D2CCIP1R", 0x50, 0),
            ("D2CCIP2R", 0x54, 0),
            ("D3CCIPR", 0x58, 0),
        ],
    ),
    ("PWR", &[("CR1", 0x00, 0xf000_c000), ("CSR1", 0x04, 0x4000), ("CR3", 0x0c, 6), ("D3CR", 0x18, 0x4000)]),
    ("FLASH", &[("ACR", 0x00, 0x37)]),
    ("SYSCFG", &[("PWRCR", 0x2c, 0)]),
    ("DBGMCU", &[("IDC", 0x00, 0x1000_6450), ("APB4FZ1", 0x54, 0)]),
    ("GPIOA", &[("MODER", 0x00, 0xabff_ffff), ("OSPEEDR", 0x08, 0x0c00_0000), ("PUPDR", 0x0c, 0x6400_0000)]),
    ("GPIOA", PORT),
    ("GPIOB", &[("MODER", 0x00, 0xffff_febf), ("OSPEEDR", 0x08, 0xc0), ("PUPDR", 0x0c, 0x100)]),
    ("GPIOB", PORT),
    ("GPIOC", &[("MODER", 0x00, 0xffff_ffff), ("OSPEEDR", 0x08, 0), ("PUPDR", 0x0c, 0)]),
    ("GPIOF", &[("MODER", 0x00, 0xffff_ffff), ("OSPEEDR", 0x08, 0), ("PUPDR", 0x0c, 0)]),
    ("USART3", &[("CR1", 0x00, 0), ("CR3", 0x08, 0), ("BRR", 0x0c, 0), ("ISR", 0x1c, 0xc0)]),
    ("IWDG1", &[("PR", 0x04, 0), ("RLR", 0x08, 0xfff), ("SR", 0x0c, 0)]),
    ("DMA1", &[("LISR", 0x00, 0), ("S0CR", 0x10, 0), ("S0NDTR", 0x14, 0), ("S0FCR", 0x24, 0x21)]),
    ("DAC1", &[("CR", 0x00, 0), ("MCR", 0x3c, 0)]),
    ("SPI3", &[("CR1", 0x00, 0), ("CFG1", 0x08, 0x0007_0007), ("CFG2", 0x0c, 0), ("SR", 0x14, 0x1002)]),
    ("ADC3", &[("ISR", 0x00, 0), ("CR", 0x08, 0), ("CFGR", 0x0c, 0), ("PCSEL", 0x1c, 0), ("SQR1", 0x30, 0)]),
];

/// Values of the models that are not those of the table, and their source.
const OTHERWISE: &[(&str, &str, u32, &str)] = &[
    ("TIM1", "ARR", 0xffff, "RM0433 38.4.12; the image writes it"),
    ("TIM2", "ARR", 0xffff_ffff, "RM0433 39.4.12; the image writes it"),
    ("TIM8", "ARR", 0xffff, "RM0433 38.4.12; the image writes it"),
    ("TIM15", "ARR", 0xffff, "RM0433 41.5.11; the image writes it"),
    ("RCC", "CR", 5, "HSI runs and is ready (RM0433 8.5.2); the image reads no other bit before it has written it"),
    ("DBGMCU", "IDC", 0x2003_0450, "revision V (ES0392); bring-up reads it"),
    ("SPI3", "SR", 0x1000, "stricter than the chip: no TXP while the peripheral is off; the image polls RXP only"),
    ("ADC3", "CR", 0x2000_0000, "RM0433 25.6.3: deep power-down; the image ends it"),
    ("ADC3", "CFGR", 0x8000_0000, "RM0433 25.6.4: JQDIS; the image writes it"),
];

/// Which bits of a register can be set, and the source: ST's data where they have the register with
/// its fields, else the manual.
const WIDTHS: &[(&str, &str, u32, u32, &str)] = &[
    ("TIM1", "ARR", 0x2c, 0xffff, METAPAC),
    ("TIM1", "RCR", 0x30, 0xffff, METAPAC),
    ("TIM1", "PSC", 0x28, 0xffff, METAPAC),
    ("TIM2", "ARR", 0x2c, 0xffff_ffff, METAPAC),
    ("TIM2", "PSC", 0x28, 0xffff, METAPAC),
    ("TIM8", "ARR", 0x2c, 0xffff, METAPAC),
    ("TIM8", "RCR", 0x30, 0xffff, METAPAC),
    ("TIM15", "ARR", 0x2c, 0xffff, METAPAC),
    ("TIM15", "RCR", 0x30, 0xff, METAPAC),
];
const METAPAC: &str = "stm32-metapac";

/// The bits of a register's fields by ST's data. A block has the registers of the one it extends.
fn st_says(of: &str, offset: u32) -> u32 {
    let peripheral = METADATA.peripherals.iter().find(|peripheral| peripheral.name == of).unwrap();
    let registers = peripheral.registers.as_ref().unwrap();
    let plain = |name: &str| name.replace('_', "").to_ascii_lowercase();
    let named = |name: &str| registers.ir.blocks.iter().find(|block| plain(block.name) == plain(name)).unwrap();
    let mut block = named(registers.block);
    loop {
        let item = block.items.iter().find(|item| item.byte_offset == offset && item.array.is_none());
        if let Some(BlockItemInner::Register(register)) = item.map(|item| &item.inner) {
            let Some(name) = register.fieldset else { return u32::MAX >> (32 - register.bit_size) };
            let fields = registers.ir.fieldsets.iter().find(|fields| fields.name == name).unwrap().fields;
            // UIFCPY lies above.
            return fields.iter().filter(|field| field.bit_size > 1).fold(0, |bits, field| match &field.bit_offset {
                BitOffset::Regular(at) => bits | u32::MAX >> (32 - field.bit_size) << at.offset,
                BitOffset::Cursed(_) => panic!("{of}: {name}"),
            });
        }
        block = named(block.extends.unwrap_or_else(|| panic!("{of} has no register at {offset:#x}")));
    }
}

/// RCC's enable registers, AHB1 to APB4.
const ENABLES: std::ops::RangeInclusive<u32> = 0xd4..=0xf4;

fn base(of: &str) -> u32 {
    let found = METADATA.peripherals.iter().find(|peripheral| peripheral.name == of);
    found.unwrap_or_else(|| panic!("the chip has no {of}")).address as u32
}

/// A chip after power-on whose peripherals have their clocks.
fn chip() -> Machine {
    let mut machine = Machine::new().unwrap();
    for register in ENABLES.step_by(4) {
        write(&mut machine, base("RCC") + register, u32::MAX);
    }
    machine
}

fn write(machine: &mut Machine, address: u32, value: u32) {
    let chip = &mut machine.chip;
    let now = chip.now;
    chip.bus.write(address, value, u32::MAX, now, &mut chip.scs.exceptions).unwrap_or_else(|| panic!("{address:#x}"));
}

fn read(machine: &mut Machine, address: u32) -> Option<u32> {
    let chip = &mut machine.chip;
    let now = chip.now;
    chip.bus.read(address, now, &mut chip.scs.exceptions)
}

#[test]
fn registers_of_the_models_are_after_a_reset_what_st_says() {
    let mut machine = chip();
    let mut otherwise: HashMap<(&str, &str), u32> =
        OTHERWISE.iter().map(|(of, name, value, _)| ((*of, *name), *value)).collect();
    let (mut differ, mut compared) = (Vec::new(), 0);
    for (of, registers) in TABLE {
        for (name, offset, value) in *registers {
            let wanted = otherwise.remove(&(*of, *name)).unwrap_or(*value);
            let is = read(&mut machine, base(of) + offset);
            if is != Some(wanted) {
                differ.push(format!("{of}.{name} is {is:x?}, and {wanted:x?} is wanted"));
            }
            compared += 1;
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
    assert!(otherwise.is_empty(), "none of the table: {otherwise:?}");
    println!("{compared} registers, {} of them otherwise than in ST's file", OTHERWISE.len());
}

#[test]
fn registers_of_timers_are_as_wide_as_st_says() {
    let mut machine = chip();
    for &(of, name, offset, bits, source) in WIDTHS {
        if source == METAPAC {
            assert_eq!(st_says(of, offset), bits, "{of}.{name}");
        }
        write(&mut machine, base(of) + offset, u32::MAX);
        assert_eq!(read(&mut machine, base(of) + offset), Some(bits), "{of}.{name}");
    }
}
