//! The models and the images beside ST's own data of the chip: addresses, clocks, resets,
//! interrupts, DMA streams and requests, alternate functions, analog pins.
//!
//! `stm32-metapac` takes them from ST's databases (CubeMX, SVD files), for all its users; nothing
//! of ours is in them. What they do not hold stands in docs/board-assumptions.md. Tests of an image
//! run where its variable names it ([`package`]).
//!
//! The feature `stm32h743vi` takes the data of the package with 100 pins, and the second board's
//! images, instead of those of the reference board. The feature `stm32h753zi` compares the
//! reference board's images with the data of the STM32H753ZI, the chip of the NUCLEO-H753ZI.
use client::{Client, Options};
use h743::bus::{BREAKS, CAPTURES, ENCODERS, PERIPHERALS};
use h743::clocks::{AHB1ENR, RESET_BEFORE_ENABLE};
use h743::device::Source;
use h743::gpio::FUNCTIONS;
use h743::link::{EmulatedLink, lock};
use h743::timer::{KINDS, TRIGGERS};
use h743::{MILLISECOND, Machine, Pin, Stop};
use protocol::command::{AxisOn, LaserPrfCmd, PrfJog, SetAxisMode, SetHSIOOpt, SetJogPrm, SetVel, Update};
use std::sync::{Arc, Mutex};
use stm32_metapac::metadata::ir::{BitOffset, Block, BlockItem, BlockItemInner};
use stm32_metapac::metadata::{METADATA, Peripheral};

#[cfg(not(feature = "stm32h743vi"))]
use reference as package;
#[cfg(feature = "stm32h743vi")]
use second as package;

/// LQFP144 and docs/board-h743.md.
#[cfg(not(feature = "stm32h743vi"))]
mod reference {
    /// What names the images: the plain one, and that for an external DAC.
    pub const IMAGES: [&str; 2] = ["BEAMTICK_H743_IMAGE", "BEAMTICK_H743_DAC_IMAGE"];
    /// The page of its pins, the source of [`GIVEN`], [`ANALOG`] and [`TO_DAC`].
    pub const PAGE: &str = include_str!("../../../docs/board-h743.md");
    /// The port of steps and directions.
    pub const STEPS: &str = "GPIOF";
    pub const BOARD: h743::board::Board = h743::board::NUCLEO;
    /// The last port that the package has.
    pub const LAST_PORT: char = 'G';
    /// Every pin that the image gives to a peripheral, and the signal that the board's page
    /// promises there.
    pub const GIVEN: [(&str, &str, &str); 23] = [
        ("PE9", "TIM1", "CH1"),
        ("PE8", "TIM1", "CH1N"),
        ("PE5", "TIM15", "CH1"),
        ("PE4", "TIM15", "CH1N"),
        ("PC7", "TIM8", "CH2"),
        ("PB0", "TIM8", "CH2N"),
        ("PC8", "TIM8", "CH3"),
        ("PB15", "TIM8", "CH3N"),
        ("PE15", "TIM1", "BKIN"),
        ("PE3", "TIM15", "BKIN"),
        ("PG2", "TIM8", "BKIN"),
        ("PD8", "USART3", "TX"),
        ("PD9", "USART3", "RX"),
        ("PB4", "TIM3", "CH1"),
        ("PB5", "TIM3", "CH2"),
        ("PB1", "TIM3", "CH4"),
        ("PD12", "TIM4", "CH1"),
        ("PD13", "TIM4", "CH2"),
        ("PD14", "TIM4", "CH3"),
        ("PA11", "USB_OTG_FS", "DM"),
        ("PA12", "USB_OTG_FS", "DP"),
        // The pins of the debug port, as the reset has left them; its others are inputs of ours.
        ("PA13", "", ""),
        ("PA14", "", ""),
    ];
}

/// LQFP100 and docs/board-h743vi.md.
#[cfg(feature = "stm32h743vi")]
mod second {
    pub const IMAGES: [&str; 2] = ["BEAMTICK_H743VI_IMAGE", "BEAMTICK_H743VI_DAC_IMAGE"];
    pub const PAGE: &str = include_str!("../../../docs/board-h743vi.md");
    pub const STEPS: &str = "GPIOE";
    pub const BOARD: h743::board::Board = h743::board::MODULE;
    pub const LAST_PORT: char = 'E';
    pub const GIVEN: [(&str, &str, &str); 23] = [
        ("PA8", "TIM1", "CH1"),
        ("PB13", "TIM1", "CH1N"),
        ("PA2", "TIM15", "CH1"),
        ("PA1", "TIM15", "CH1N"),
        ("PC7", "TIM8", "CH2"),
        ("PB0", "TIM8", "CH2N"),
        ("PC8", "TIM8", "CH3"),
        ("PB1", "TIM8", "CH3N"),
        ("PB12", "TIM1", "BKIN"),
        ("PA0", "TIM15", "BKIN"),
        ("PA6", "TIM8", "BKIN"),
        ("PB10", "USART3", "TX"),
        ("PB11", "USART3", "RX"),
        ("PB4", "TIM3", "CH1"),
        ("PB5", "TIM3", "CH2"),
        ("PC9", "TIM3", "CH4"),
        ("PD12", "TIM4", "CH1"),
        ("PD13", "TIM4", "CH2"),
        ("PD14", "TIM4", "CH3"),
        ("PA11", "USB_OTG_FS", "DM"),
        ("PA12", "USB_OTG_FS", "DP"),
        // The pins of the debug port, as the reset has left them; the others of it are plain ones.
        ("PA13", "", ""),
        ("PA14", "", ""),
    ];
}

/// What the images for an external DAC give beside these.
const TO_DAC: [(&str, &str, &str); 2] = [("PC10", "SPI3", "SCK"), ("PC12", "SPI3", "MOSI")];
/// Analog pins: inputs 1 and 2, outputs of lasers 0 and 1.
const ANALOG: [(&str, &str, &str); 4] =
    [("PC3_C", "ADC3", "INP1"), ("PC2_C", "ADC3", "INP0"), ("PA4", "DAC1", "OUT1"), ("PA5", "DAC1", "OUT2")];

/// Whether the package has a pin.
fn is_there(pin: &str) -> bool {
    pin.chars().nth(1).is_some_and(|port| port <= package::LAST_PORT)
}

fn peripheral(name: &str) -> &'static Peripheral {
    METADATA.peripherals.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("the chip has no {name}"))
}

fn block(of: &str, name: &str) -> &'static Block {
    let plain = |name: &str| name.replace('_', "").to_ascii_lowercase();
    let blocks = peripheral(of).registers.as_ref().unwrap().ir.blocks;
    blocks.iter().find(|block| plain(block.name) == plain(name)).unwrap()
}

/// A register of a peripheral. A block has the registers of the one it extends.
fn register(of: &str, name: &str) -> &'static BlockItem {
    let mut block = self::block(of, peripheral(of).registers.as_ref().unwrap().block);
    loop {
        if let Some(item) = block.items.iter().find(|item| item.name.eq_ignore_ascii_case(name)) {
            return item;
        }
        block = self::block(of, block.extends.unwrap_or_else(|| panic!("{of} has no {name}")));
    }
}

/// The address of a register.
fn address(of: &str, name: &str) -> u32 {
    peripheral(of).address as u32 + register(of, name).byte_offset
}

/// Offset of a register within its peripheral, and the first bit of one of its fields.
fn place(of: &str, name: &str, field: &str) -> (u32, u32) {
    let item = register(of, name);
    let BlockItemInner::Register(shape) = &item.inner else { panic!("{name} is a block") };
    let fieldsets = peripheral(of).registers.as_ref().unwrap().ir.fieldsets;
    let fields = fieldsets.iter().find(|f| Some(f.name) == shape.fieldset).unwrap();
    let field = fields.fields.iter().find(|f| f.name.eq_ignore_ascii_case(field)).unwrap();
    let BitOffset::Regular(bit) = &field.bit_offset else { panic!("{name} has its bits apart") };
    (item.byte_offset, bit.offset)
}

/// Which alternate function gives a pin to a signal.
fn function(of: &str, signal: &str, pin: &str) -> Option<u32> {
    let found = peripheral(of).pins.iter().find(|p| p.pin == pin && p.signal == signal)?;
    found.af.map(u32::from)
}

fn request(of: &str, signal: &str) -> u32 {
    peripheral(of).dma_channels.iter().find(|c| c.signal == signal).and_then(|c| c.request).unwrap_or(0)
}

fn interrupt(of: &str, signal: &str) -> usize {
    let name = peripheral(of).interrupts.iter().find(|i| i.signal == signal).unwrap().interrupt;
    METADATA.interrupts.iter().find(|i| i.name == name).unwrap().number as usize
}

/// The board after start-up with its interlock closed, once by each image that is named; true with
/// the one for an external DAC.
fn started() -> Vec<(bool, Machine)> {
    let mut started = Vec::new();
    for (variable, is_for_dac) in package::IMAGES.into_iter().zip([false, true]) {
        let Some(path) = std::env::var_os(variable) else {
            println!("skipped: {variable} names no image");
            continue;
        };
        let mut machine = Machine::on(package::BOARD).unwrap();
        machine.boot(&std::fs::read(path).unwrap()).unwrap();
        BREAKS.iter().for_each(|(_, name, _)| machine.drive(Pin::named(name).unwrap(), Some(false)));
        // Longer than its converter is calibrated.
        assert_eq!(machine.run(40 * MILLISECOND), Stop::Time);
        started.push((is_for_dac, machine));
    }
    started
}

fn read(machine: &mut Machine, address: u32) -> u32 {
    let chip = &mut machine.chip;
    let now = chip.now;
    chip.bus.read(address, now, &mut chip.scs.exceptions).unwrap_or_else(|| panic!("nothing at {address:#x}"))
}

#[test]
fn peripherals_of_the_model_lie_and_are_clocked_where_st_says() {
    let mut clocked = 0;
    for model in PERIPHERALS {
        let chip = peripheral(model.name);
        assert_eq!(u64::from(model.base), chip.address, "{}", model.name);
        let Some(clock) = model.clock else { continue };
        let enable = chip.rcc.as_ref().and_then(|rcc| rcc.enable.as_ref()).unwrap();
        assert_eq!(clock, place("RCC", enable.register, enable.field), "{}", model.name);
        let reset = chip.rcc.as_ref().and_then(|rcc| rcc.reset.as_ref()).unwrap();
        let (register, bit) = clock;
        assert_eq!((register - RESET_BEFORE_ENABLE, bit), place("RCC", reset.register, reset.field), "{}", model.name);
        clocked += 1;
    }
    for (name, bit) in [("DMA1", 0), ("DMA2", 1)] {
        let enable = peripheral(name).rcc.as_ref().and_then(|rcc| rcc.enable.as_ref()).unwrap();
        assert_eq!(place("RCC", enable.register, enable.field), (AHB1ENR, bit), "{name}");
    }
    assert!(clocked >= 15, "{clocked} of them have a clock");
}

#[test]
fn memories_of_the_model_are_those_of_the_chip() {
    let names = [
        ("ITCM", "ITCM"),
        ("DTCM", "DTCM"),
        ("AXI SRAM", "AXISRAM"),
        ("SRAM 1", "SRAM1"),
        ("SRAM 2", "SRAM2"),
        ("SRAM 3", "SRAM3"),
        ("SRAM 4", "SRAM4"),
    ];
    let machine = Machine::new().unwrap();
    for (ours, theirs) in names {
        let model = machine.chip.memory.regions().iter().find(|region| region.name == ours).unwrap();
        let chip = METADATA.memory[0]
            .iter()
            .find(|region| region.name.replace('_', "") == theirs)
            .unwrap_or_else(|| panic!("{theirs} is none of {:?}", METADATA.memory[0]));
        assert_eq!((model.base, model.size), (chip.address, chip.size), "{ours}");
    }
    for (name, register, field) in
        [("SRAM 1", "AHB2ENR", "SRAM1EN"), ("SRAM 2", "AHB2ENR", "SRAM2EN"), ("SRAM 3", "AHB2ENR", "SRAM3EN")]
    {
        let model = machine.chip.memory.regions().iter().find(|region| region.name == name).unwrap();
        assert_eq!(model.clock, Some(place("RCC", register, field)), "{name}");
    }
    let backup = machine.chip.memory.regions().iter().find(|region| region.name == "backup SRAM").unwrap();
    assert_eq!(backup.clock, Some(place("RCC", "AHB4ENR", "BKPSRAMEN")));
    // What start-up writes before there is a program: PWR_CR1.DBP is bit 8.
    assert_eq!(place("PWR", "CR1", "DBP"), (0, 8));
}

#[test]
fn interrupts_and_dma_requests_of_timers_are_those_of_the_chip() {
    for kind in KINDS {
        let name = format!("TIM{}", kind.number);
        let signals = if kind.advanced { ["UP", "CC", "BRK"] } else { ["UP"; 3] };
        assert_eq!(kind.lines, signals.map(|signal| interrupt(&name, signal)), "{name}");
        let requests = ["CH1", "CH2", "CH3", "CH4", "UP"].map(|signal| request(&name, signal) as u8);
        // TIM15's second channel asks by nothing that the image could use.
        for (ours, theirs) in kind.requests.into_iter().zip(requests) {
            assert!(ours == theirs || ours == 0, "{name}: {:?} where ST has {requests:?}", kind.requests);
        }
        assert_eq!(kind.requests[4], requests[4], "{name}");
    }
}

#[test]
fn alternate_functions_of_the_model_are_those_of_the_chip() {
    for (pin, number, source) in FUNCTIONS {
        let (of, signal) = match source {
            Source::Timer(timer, channel, negative) => {
                (format!("TIM{timer}"), format!("CH{channel}{}", if negative { "N" } else { "" }))
            }
            Source::UsartTx(usart) => (format!("USART{usart}"), "TX".into()),
            Source::SpiClock(spi) => (format!("SPI{spi}"), "SCK".into()),
            Source::SpiData(spi) => (format!("SPI{spi}"), "MOSI".into()),
        };
        assert_eq!(function(&of, &signal, &pin.to_string()), Some(number), "{pin}: {of} {signal}");
    }
    for (timer, pin, number) in BREAKS.into_iter().filter(|(_, pin, _)| is_there(pin)) {
        assert_eq!(function(&format!("TIM{timer}"), "BKIN", pin), Some(number), "{pin}");
    }
    for (timer, inputs, number) in ENCODERS {
        for &(input, pin) in inputs {
            assert_eq!(function(&format!("TIM{timer}"), &format!("CH{}", input + 1), pin), Some(number), "{pin}");
        }
    }
    // The ends of bring-up's jumpers.
    for (input, pin) in CAPTURES {
        assert_eq!(function("TIM2", &format!("CH{}", input + 1), pin), Some(1), "{pin}");
    }
}

/// The row of the page's table that names a pin.
fn row_of_page(pin: &str) -> &'static str {
    let table = package::PAGE.lines().skip_while(|line| !line.starts_with("## Pins"));
    let mut rows = table.filter(|line| line.starts_with("| ") && line.matches(" | ").count() == 2);
    let names = |row: &&str| row.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(|word| word == pin);
    rows.find(names).unwrap_or_else(|| panic!("the page has no {pin}"))
}

#[test]
fn the_page_says_what_each_pin_is_given_to() {
    for (pin, of, signal) in package::GIVEN.into_iter().chain(TO_DAC).chain(ANALOG) {
        if of.is_empty() {
            continue;
        }
        let row = row_of_page(pin);
        assert!(row.contains(of.trim_start_matches("USB_")), "{pin}: {of} is not in {row}");
        if of.starts_with("ADC") || of.starts_with("DAC") {
            assert!(row.contains(signal), "{pin}: {signal} is not in {row}");
        }
        if let Some(number) = function(of, signal, pin).filter(|_| row.contains("AF")) {
            assert!(row.contains(&format!("AF{number}")), "{pin}: AF{number} is not in {row}");
        }
    }
}

#[test]
fn the_image_gives_each_pin_to_the_signal_that_the_page_promises() {
    for (is_for_dac, mut machine) in started() {
        let promised: Vec<_> = package::GIVEN.into_iter().chain(TO_DAC.into_iter().filter(|_| is_for_dac)).collect();
        let mut given = 0;
        // The others are not clocked: their pins are as the reset has left them.
        for port in 'A'..=package::LAST_PORT {
            let base = peripheral(&format!("GPIO{port}")).address as u32;
            let mode = read(&mut machine, base);
            for pin in 0..16 {
                const ALTERNATE: u32 = 2;
                let name = format!("P{port}{pin}");
                let use_of_pin = mode >> (2 * pin) & 3;
                assert!(
                    use_of_pin == ANALOG_MODE || METADATA.pins.iter().any(|of| of.name == name),
                    "no {name} in this package"
                );
                if use_of_pin != ALTERNATE {
                    continue;
                }
                let number = read(&mut machine, base + 0x20 + pin / 8 * 4) >> (pin % 8 * 4) & 0xf;
                let (_, of, signal) = promised
                    .iter()
                    .find(|(of, ..)| *of == name)
                    .unwrap_or_else(|| panic!("{name} is given to something"));
                if of.is_empty() {
                    assert_eq!(number, 0, "{name}: the debug port's");
                    continue;
                }
                assert_eq!(function(of, signal, &name), Some(number), "{name}: {of} {signal}");
                given += 1;
            }
        }
        assert_eq!(given, promised.iter().filter(|(_, of, _)| !of.is_empty()).count());
    }
}

/// A pin's mode in GPIO's MODER.
const ANALOG_MODE: u32 = 3;

/// The pin of an analog signal by ST's data.
fn analog_pin(of: &str, signal: &str) -> &'static str {
    let found = peripheral(of).pins.iter().find(|pin| pin.signal == signal && pin.af.is_none());
    found.unwrap_or_else(|| panic!("{of} has no {signal}")).pin
}

#[test]
fn the_image_converts_at_the_analog_pins_of_the_page() {
    for (pin, of, signal) in ANALOG {
        assert_eq!(analog_pin(of, signal), pin, "{of} {signal}");
    }
    for (is_for_dac, mut machine) in started() {
        // The regular conversion is input 1, the injected one input 2.
        for ((name, field), (pin, ..)) in [("SQR1", "SQ"), ("JSQR", "JSQ")].into_iter().zip(ANALOG) {
            let (_, bit) = place("ADC3", name, field);
            let channel = read(&mut machine, address("ADC3", name)) >> bit & 0x1f;
            assert_eq!(analog_pin("ADC3", &format!("INP{channel}")), pin, "{name}");
            let (_, first) = place("ADC3", "PCSEL", "PCSEL");
            assert_eq!(read(&mut machine, address("ADC3", "PCSEL")) >> (first + channel) & 1, 1, "{name}");
        }
        // The outputs are switched on, unless an external converter takes their place.
        if !is_for_dac {
            let (_, first) = place("DAC1", "CR", "EN");
            assert_eq!(read(&mut machine, address("DAC1", "CR")) >> first & 0x1_0001, 0x1_0001);
        }
        for (pin, ..) in ANALOG {
            let pin = Pin::named(pin.trim_end_matches("_C")).unwrap();
            let mode = read(&mut machine, peripheral(&format!("GPIO{}", char::from(b'A' + pin.0))).address as u32);
            assert_eq!(mode >> (2 * pin.1) & 3, ANALOG_MODE, "{pin}");
        }
    }
}

/// By ST. ST's databases have no such table.
const LINUX: &str = "Linux, drivers/iio/trigger/stm32-timer-trigger.c, stm32h7_valids_table";
/// Which timer's trigger comes at ITR0 to ITR3 of a timer, and the source; `None` is a channel of a
/// timer.
const TRIGGERS_OF_LINUX: [(u8, [Option<u8>; 4], &str); 6] = [
    (1, [Some(15), Some(2), Some(3), Some(4)], LINUX),
    (2, [Some(1), Some(8), Some(3), Some(4)], LINUX),
    (3, [Some(1), Some(2), Some(15), Some(4)], LINUX),
    (4, [Some(1), Some(2), Some(3), Some(8)], LINUX),
    (8, [Some(1), Some(2), Some(4), Some(5)], LINUX),
    (15, [Some(1), Some(3), None, None], LINUX),
];

#[test]
fn triggers_between_timers_are_those_of_linux() {
    assert_eq!(TRIGGERS.len(), TRIGGERS_OF_LINUX.len());
    for ((slave, masters), (of, theirs, source)) in TRIGGERS.into_iter().zip(TRIGGERS_OF_LINUX) {
        let theirs: Vec<u8> = theirs.into_iter().flatten().collect();
        assert_eq!((slave, masters), (of, &theirs[..]), "{source}");
    }
}

/// TIM2 makes the ticks and starts TIM1 and TIM8; TIM15 starts with TIM1.
#[test]
fn the_image_starts_timers_by_the_triggers_of_linux() {
    for (_, mut machine) in started() {
        for (slave, master) in [(1, 2), (8, 2), (15, 1)] {
            let smcr = read(&mut machine, peripheral(&format!("TIM{slave}")).address as u32 + 0x08);
            // TS and SMS (RM0433 38.4.3): the trigger mode is 6.
            let (input, mode) = ((smcr >> 4 & 7 | smcr >> 17 & 0x18) as usize, smcr & 7 | smcr >> 13 & 8);
            let (_, masters, _) = TRIGGERS_OF_LINUX.into_iter().find(|(of, ..)| *of == slave).unwrap();
            assert_eq!((masters.get(input).copied().flatten(), mode), (Some(master), 6), "TIM{slave}");
        }
    }
}

/// Else the watchdog would reset a chip whose core a debugger holds (RM0433 60.5.8, WDGLSD1).
#[test]
fn the_image_freezes_the_watchdog_under_a_debugger() {
    let (_, bit) = place("DBGMCU", "APB4FZR1", "IWDG1");
    for (_, mut machine) in started() {
        assert_eq!(read(&mut machine, address("DBGMCU", "APB4FZR1")) >> bit & 1, 1);
        assert!(machine.chip.bus.watchdog.is_running());
    }
}

/// A stream in use: its controller and number, the request, and the register at its fixed end.
type Stream = ((&'static str, u32), (&'static str, &'static str), (&'static str, &'static str));

/// Those of docs/board-h743-registers.md, "DMA".
const STREAMS: [Stream; 6] = [
    (("DMA1", 0), ("TIM1", "UP"), ("TIM1", "DMAR")),
    (("DMA1", 1), ("TIM8", "UP"), ("TIM8", "DMAR")),
    (("DMA1", 2), ("USART3", "RX"), ("USART3", "RDR")),
    (("DMA2", 0), ("TIM15", "UP"), ("TIM15", "DMAR")),
    (("DMA2", 1), ("TIM17", "UP"), (package::STEPS, "BSRR")),
    (("DMA2", 2), ("TIM17", "CH1"), ("TIM17", "PSC")),
];

#[test]
fn the_page_has_the_chips_numbers_of_streams_channels_and_requests() {
    let page = include_str!("../../../docs/board-h743-registers.md");
    for ((controller, stream), (of, signal), _) in STREAMS {
        let channel = METADATA.dma_channels.iter().find(|c| c.dma == controller && c.channel == stream).unwrap();
        let (channel, number) = (channel.dmamux_channel.unwrap(), request(of, signal));
        let row = format!("| {controller} stream {stream} | {channel}: {number}, {of}_{signal} |");
        assert!(page.contains(&row), "the page lacks {row}");
    }
}

/// Lasers and steps ask from their first plan on.
fn ask(client: &Client) {
    let core = 1.into();
    for (axis, channel) in [(7, 0.into()), (8, 1.into())] {
        client.call(SetAxisMode { core, axis: axis.into(), mode: 1.into() }).unwrap();
        client.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
        client.call(SetHSIOOpt { core, value: 1.into(), channel }).unwrap();
    }
    client.call(AxisOn { core, axis: 1.into() }).unwrap();
    client.call(PrfJog { core, profile: 1.into() }).unwrap();
    client.call(SetJogPrm { core, profile: 1.into(), acc: 1.0.into(), dec: 1.0.into(), smooth: 0.0.into() }).unwrap();
    client.call(SetVel { core, profile: 1.into(), vel: 10.0.into() }).unwrap();
    client.call(Update { core, mask: 1.into() }).unwrap();
}

#[test]
fn the_image_asks_dma_and_takes_interrupts_by_the_chips_numbers() {
    for (_, machine) in started() {
        let shared = Arc::new(Mutex::new(machine));
        let client = Client::open(Box::new(EmulatedLink::new(shared.clone())), Options::default()).unwrap();
        ask(&client);
        let mut machine = lock(&shared);
        machine.run(20 * MILLISECOND);
        let multiplexer = peripheral("DMAMUX1").address as u32;
        let channels: Vec<_> = METADATA.dma_channels.iter().filter(|c| c.dmamux == Some("DMAMUX1")).collect();
        assert_eq!(channels.len(), 16);
        for channel in channels {
            let stream = STREAMS.iter().find(|(of, ..)| *of == (channel.dma, channel.channel));
            let asked = read(&mut machine, multiplexer + 4 * channel.dmamux_channel.unwrap()) & 0x7f;
            let expected = stream.map_or(0, |(_, (of, signal), _)| request(of, signal));
            assert_eq!(asked, expected, "{}", channel.name);
            // CR and PAR of the stream (RM0433 15.5.5, 15.5.7).
            let registers = peripheral(channel.dma).address as u32 + 0x10 + 0x18 * channel.channel;
            let is_on = read(&mut machine, registers) & 1 == 1;
            assert_eq!(is_on, stream.is_some(), "{}", channel.name);
            if let Some((_, _, (of, name))) = stream {
                assert_eq!(read(&mut machine, registers + 8), address(of, name), "{}: {of}_{name}", channel.name);
            }
        }
    }
    for (number, name, signal) in [(28, "TIM2", "UP"), (39, "USART3", "GLOBAL"), (101, "USB_OTG_FS", "GLOBAL")] {
        assert_eq!(interrupt(name, signal), number, "{name}");
    }
}
