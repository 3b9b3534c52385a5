//! Registers of the models as a reset leaves them, and how wide they are, beside ST's SVD file.
//!
//! Each row names its source; most are of [`SVD`], in which nothing is ours. Where the model has
//! another value, the reason and its source stand in [`OTHERWISE`]. What the image relies on there,
//! it writes itself, or docs/board-assumptions.md lists it.
use h743::Machine;
use std::collections::HashMap;
use stm32_metapac::metadata::METADATA;
use stm32_metapac::metadata::ir::{Array, BitOffset, Block, BlockItemInner, IR};

/// A register: its name, its offset, its value after a reset.
type Register = (&'static str, u32, u32);

/// The crate of that version, device `stm32h743`: ST's SVD file with the corrections of stm32-rs.
const SVD: &str = "stm32h7 0.16.0";
/// The SVD file has no such register.
const CFGR_OF_SYSCFG: &str = "RM0433 12.3.6";

const TIMER: &[Register] = &[
    ("CR1", 0x00, 0),
    ("CR2", 0x04, 0),
    ("DIER", 0x0c, 0),
    ("SR", 0x10, 0),
    ("CCMR1", 0x18, 0),
    ("CCER", 0x20, 0),
    ("CNT", 0x24, 0),
    ("PSC", 0x28, 0),
    ("ARR", 0x2c, 0),
    ("CCR1", 0x34, 0),
    ("DCR", 0x48, 0),
];
const SLAVE: &[Register] = &[("SMCR", 0x08, 0)];
const OF_LASERS: &[Register] = &[("RCR", 0x30, 0), ("BDTR", 0x44, 0), ("AF1", 0x60, 0)];
const OF_ENCODERS: &[Register] = &[("CCMR2", 0x1c, 0), ("CCR3", 0x3c, 0), ("CCR4", 0x40, 0)];
const PORT: &[Register] = &[("OTYPER", 0x04, 0), ("ODR", 0x14, 0), ("AFRL", 0x20, 0), ("AFRH", 0x24, 0)];
const ANALOG_PORT: &[Register] = &[("MODER", 0x00, 0xffff_ffff), ("OSPEEDR", 0x08, 0), ("PUPDR", 0x0c, 0)];
const CONTROLLER: &[Register] = &[
    ("LISR", 0x00, 0),
    ("HISR", 0x04, 0),
    ("S0CR", 0x10, 0),
    ("S0NDTR", 0x14, 0),
    ("S0PAR", 0x18, 0),
    ("S0M0AR", 0x1c, 0),
    ("S0FCR", 0x24, 0x21),
    ("S1CR", 0x28, 0),
    ("S2CR", 0x40, 0),
];

/// Peripherals, their registers, and the source.
const TABLE: &[(&str, &[Register], &str)] = &[
    ("TIM1", TIMER, SVD),
    ("TIM1", SLAVE, SVD),
    ("TIM1", OF_LASERS, SVD),
    ("TIM2", TIMER, SVD),
    ("TIM2", SLAVE, SVD),
    ("TIM3", TIMER, SVD),
    ("TIM3", SLAVE, SVD),
    ("TIM3", OF_ENCODERS, SVD),
    ("TIM4", TIMER, SVD),
    ("TIM4", SLAVE, SVD),
    ("TIM4", OF_ENCODERS, SVD),
    ("TIM5", TIMER, SVD),
    ("TIM5", SLAVE, SVD),
    ("TIM8", TIMER, SVD),
    ("TIM8", SLAVE, SVD),
    ("TIM8", OF_LASERS, SVD),
    ("TIM15", TIMER, SVD),
    ("TIM15", SLAVE, SVD),
    ("TIM15", OF_LASERS, SVD),
    ("TIM17", TIMER, SVD),
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
            ("AHB3RSTR", 0x7c, 0),
            ("AHB1RSTR", 0x80, 0),
            ("AHB2RSTR", 0x84, 0),
            ("AHB4RSTR", 0x88, 0),
            ("APB3RSTR", 0x8c, 0),
            ("APB1LRSTR", 0x90, 0),
            ("APB1HRSTR", 0x94, 0),
            ("APB2RSTR", 0x98, 0),
            ("APB4RSTR", 0x9c, 0),
            ("RSR", 0xd0, 0),
        ],
        SVD,
    ),
    ("PWR", &[("CR1", 0x00, 0xf000_c000), ("CSR1", 0x04, 0x4000), ("CR3", 0x0c, 6), ("D3CR", 0x18, 0x4000)], SVD),
    ("FLASH", &[("ACR", 0x00, 0x37)], SVD),
    ("SYSCFG", &[("PMCR", 0x04, 0), ("CCCSR", 0x20, 0), ("PWRCR", 0x2c, 0), ("PKGR", 0x124, 0)], SVD),
    ("SYSCFG", &[("CFGR", 0x18, 0)], CFGR_OF_SYSCFG),
    ("DBGMCU", &[("IDC", 0x00, 0x1000_6450), ("APB4FZ1", 0x54, 0)], SVD),
    ("GPIOA", &[("MODER", 0x00, 0xabff_ffff), ("OSPEEDR", 0x08, 0x0c00_0000), ("PUPDR", 0x0c, 0x6400_0000)], SVD),
    ("GPIOA", PORT, SVD),
    ("GPIOB", &[("MODER", 0x00, 0xffff_febf), ("OSPEEDR", 0x08, 0xc0), ("PUPDR", 0x0c, 0x100)], SVD),
    ("GPIOB", PORT, SVD),
    ("GPIOC", ANALOG_PORT, SVD),
    ("GPIOC", PORT, SVD),
    ("GPIOD", ANALOG_PORT, SVD),
    ("GPIOD", PORT, SVD),
    ("GPIOE", ANALOG_PORT, SVD),
    ("GPIOE", PORT, SVD),
    ("GPIOF", ANALOG_PORT, SVD),
    ("GPIOF", PORT, SVD),
    ("GPIOG", ANALOG_PORT, SVD),
    ("GPIOG", PORT, SVD),
    ("USART3", &[("CR1", 0x00, 0), ("CR3", 0x08, 0), ("BRR", 0x0c, 0), ("ISR", 0x1c, 0xc0)], SVD),
    ("IWDG1", &[("PR", 0x04, 0), ("RLR", 0x08, 0xfff), ("SR", 0x0c, 0)], SVD),
    ("DMA1", CONTROLLER, SVD),
    ("DMA2", CONTROLLER, SVD),
    (
        "DMAMUX1",
        &[
            ("C0CR", 0x00, 0),
            ("C1CR", 0x04, 0),
            ("C2CR", 0x08, 0),
            ("C8CR", 0x20, 0),
            ("C9CR", 0x24, 0),
            ("C10CR", 0x28, 0),
        ],
        SVD,
    ),
    ("DAC1", &[("CR", 0x00, 0), ("DHR12R1", 0x08, 0), ("DHR12R2", 0x14, 0), ("MCR", 0x3c, 0)], SVD),
    ("SPI3", &[("CR1", 0x00, 0), ("CFG1", 0x08, 0x0007_0007), ("CFG2", 0x0c, 0), ("SR", 0x14, 0x1002)], SVD),
    ("ADC3", &[("ISR", 0x00, 0), ("CR", 0x08, 0), ("CFGR", 0x0c, 0), ("PCSEL", 0x1c, 0), ("SQR1", 0x30, 0)], SVD),
    (
        // The core at 0x4008_0000: OTG2_HS of the SVD file.
        "USB_OTG_FS",
        &[
            ("GOTGCTL", 0x00, 0x800),
            ("GAHBCFG", 0x08, 0),
            ("GUSBCFG", 0x0c, 0xa00),
            ("GRSTCTL", 0x10, 0x2000_0000),
            ("GINTSTS", 0x14, 0x0400_0020),
            ("GINTMSK", 0x18, 0),
            ("GRXFSIZ", 0x24, 0x200),
            ("DIEPTXF0", 0x28, 0x200),
            ("GCCFG", 0x38, 0),
            ("DCFG", 0x800, 0x0220_0000),
            ("DCTL", 0x804, 0),
            ("DSTS", 0x808, 0x10),
            ("DIEPMSK", 0x810, 0),
            ("DOEPMSK", 0x814, 0),
            ("DAINT", 0x818, 0),
            ("DAINTMSK", 0x81c, 0),
        ],
        SVD,
    ),
];

/// Values of the models that are not those of the table, and their source.
const OTHERWISE: &[(&str, &str, u32, &str)] = &[
    ("TIM1", "ARR", 0xffff, "RM0433 38.4.12; the image writes it"),
    ("TIM2", "ARR", 0xffff_ffff, "RM0433 39.4.12; the image writes it"),
    ("TIM3", "ARR", 0xffff, "RM0433 39.4.12; the image writes it"),
    ("TIM4", "ARR", 0xffff, "RM0433 39.4.12; the image writes it"),
    ("TIM5", "ARR", 0xffff_ffff, "RM0433 39.4.12; no image uses it"),
    ("TIM8", "ARR", 0xffff, "RM0433 38.4.12; the image writes it"),
    ("TIM15", "ARR", 0xffff, "RM0433 41.5.11; the image writes it"),
    ("RCC", "CR", 5, "HSI runs and is ready (RM0433 8.5.2); the image reads no other bit before it has written it"),
    ("TIM17", "ARR", 0xffff, "RM0433 41.6.9; the image writes it"),
    ("RCC", "RSR", 0x00fa_0000, "RM0433 table 55: the flags of a power-on; the image reads two of them"),
    ("SYSCFG", "PKGR", 2, "RM0433 12.3.13: LQFP144, the package of the model's first board"),
    ("USB_OTG_FS", "GOTGCTL", 0x0001_0000, "RM0433 57, CIDSTS: the ID pin is open; the image does not read it"),
    ("USB_OTG_FS", "GRSTCTL", 0x8000_0000, "RM0433 57, AHBIDL: nothing is under way; the image waits for it"),
    (
        "USB_OTG_FS",
        "GINTSTS",
        0,
        "NPTXFE and PTXFE are of the host mode, which the model has not; no image enables them",
    ),
    ("USB_OTG_FS", "DSTS", 6, "RM0433 57, ENUMSPD: full speed; read after a reset of the bus only"),
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
    ("TIM1", "CCR1", 0x34, 0xffff, METAPAC),
    ("TIM1", "DCR", 0x48, 0x1f1f, METAPAC),
    ("TIM2", "ARR", 0x2c, 0xffff_ffff, METAPAC),
    ("TIM2", "PSC", 0x28, 0xffff, METAPAC),
    ("TIM2", "CCR1", 0x34, 0xffff_ffff, METAPAC),
    ("TIM3", "ARR", 0x2c, 0xffff, METAPAC),
    ("TIM3", "CCR4", 0x40, 0xffff, METAPAC),
    ("TIM4", "ARR", 0x2c, 0xffff, METAPAC),
    ("TIM4", "CCR3", 0x3c, 0xffff, METAPAC),
    ("TIM8", "ARR", 0x2c, 0xffff, METAPAC),
    ("TIM8", "RCR", 0x30, 0xffff, METAPAC),
    ("TIM8", "CCR1", 0x34, 0xffff, METAPAC),
    ("TIM8", "CCR2", 0x38, 0xffff, METAPAC),
    ("TIM8", "CCR3", 0x3c, 0xffff, METAPAC),
    ("TIM8", "CCR4", 0x40, 0xffff, METAPAC),
    ("TIM8", "DCR", 0x48, 0x1f1f, METAPAC),
    ("TIM15", "ARR", 0x2c, 0xffff, METAPAC),
    ("TIM15", "RCR", 0x30, 0xff, METAPAC),
    ("TIM15", "CCR1", 0x34, 0xffff, METAPAC),
    ("TIM15", "DCR", 0x48, 0x1f1f, METAPAC),
    ("TIM17", "ARR", 0x2c, 0xffff, METAPAC),
    ("TIM17", "CCR1", 0x34, 0xffff, METAPAC),
    ("DMA1", "S0NDTR", 0x14, 0xffff, METAPAC),
    ("DMA2", "S1NDTR", 0x2c, 0xffff, METAPAC),
    ("IWDG1", "RLR", 0x08, 0xfff, METAPAC),
    ("DAC1", "DHR12R1", 0x08, 0xfff, METAPAC),
    ("DAC1", "DHR12R2", 0x14, 0xfff, METAPAC),
];
const METAPAC: &str = "stm32-metapac";
/// With it written to IWDG1_KR, RLR can be written (RM0433 44.4.1).
const UNLOCK: u32 = 0x5555;

/// Offsets of an item and of those after it.
fn places(array: Option<&Array>) -> Vec<u32> {
    match array {
        None => vec![0],
        Some(Array::Regular(array)) => (0..array.len).map(|n| n * array.stride).collect(),
        Some(Array::Cursed(array)) => array.offsets.to_vec(),
    }
}

fn named<'a>(ir: &'a IR, name: &str) -> &'a Block {
    let plain = |name: &str| name.replace('_', "").to_ascii_lowercase();
    ir.blocks.iter().find(|block| plain(block.name) == plain(name)).unwrap()
}

/// The bits of a register's fields, if a block has one there. A block has the registers of the one
/// it extends, and those of the blocks in it.
fn bits(ir: &IR, block: &Block, offset: u32) -> Option<u32> {
    for item in block.items {
        for place in places(item.array.as_ref()) {
            let Some(within) = offset.checked_sub(item.byte_offset + place) else { continue };
            match &item.inner {
                BlockItemInner::Block(inner) if item.array.is_some() => {
                    let stride = places(item.array.as_ref()).get(1).copied().unwrap_or(u32::MAX);
                    if within < stride
                        && let Some(found) = bits(ir, named(ir, inner.block), within)
                    {
                        return Some(found);
                    }
                }
                BlockItemInner::Register(register) if within == 0 => {
                    let Some(name) = register.fieldset else { return Some(u32::MAX >> (32 - register.bit_size)) };
                    let fields = ir.fieldsets.iter().find(|fields| fields.name == name).unwrap().fields;
                    // UIFCPY lies above.
                    let values = fields.iter().filter(|field| field.bit_size > 1);
                    return Some(values.fold(0, |bits, field| match &field.bit_offset {
                        BitOffset::Regular(at) => bits | u32::MAX >> (32 - field.bit_size) << at.offset,
                        BitOffset::Cursed(_) => panic!("{name} has its bits apart"),
                    }));
                }
                _ => {}
            }
        }
    }
    bits(ir, named(ir, block.extends?), offset)
}

/// The bits of a register's fields by ST's data.
fn st_says(of: &str, offset: u32) -> u32 {
    let peripheral = METADATA.peripherals.iter().find(|peripheral| peripheral.name == of).unwrap();
    let registers = peripheral.registers.as_ref().unwrap();
    let found = bits(registers.ir, named(registers.ir, registers.block), offset);
    found.unwrap_or_else(|| panic!("{of} has no register at {offset:#x}"))
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
    for (of, registers, source) in TABLE {
        for (name, offset, value) in *registers {
            let wanted = otherwise.remove(&(*of, *name)).unwrap_or(*value);
            let is = read(&mut machine, base(of) + offset);
            if is != Some(wanted) {
                differ.push(format!("{of}.{name} is {is:x?}, and {wanted:x?} is wanted by {source}"));
            }
            compared += 1;
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
    assert!(otherwise.is_empty(), "none of the table: {otherwise:?}");
    println!("{compared} registers, {} of them otherwise than in ST's file", OTHERWISE.len());
}

#[test]
fn registers_are_as_wide_as_st_says() {
    let mut machine = chip();
    for &(of, name, offset, bits, source) in WIDTHS {
        if source == METAPAC {
            assert_eq!(st_says(of, offset), bits, "{of}.{name}");
        }
        if of == "IWDG1" {
            write(&mut machine, base(of), UNLOCK);
        }
        write(&mut machine, base(of) + offset, u32::MAX);
        assert_eq!(read(&mut machine, base(of) + offset), Some(bits), "{of}.{name}");
    }
}
