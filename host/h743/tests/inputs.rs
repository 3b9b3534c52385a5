//! Analog inputs and encoders of the image in emulation, where BEAMTICK_H743_IMAGE names it:
//! voltages and edges at the pins are what the calls read.
use client::{Client, Options};
use h743::link::{EmulatedLink, Shared, lock};
use h743::{MICROSECOND, MILLISECOND, Machine, Pin};
use protocol::command::{
    AxisOn, ClrSts, GetAdc, GetCaptureStatus, GetEncPos, GetEncVel, GetSts, LmtsOff, SetCaptureMode, SetEncPos,
    SetPosErr,
};
use std::sync::{Arc, Mutex};

/// The board, linked. `None` without an image.
fn linked() -> Option<(Client, Shared)> {
    let Some(path) = std::env::var_os("BEAMTICK_H743_IMAGE") else {
        println!("skipped: BEAMTICK_H743_IMAGE names no image");
        return None;
    };
    let mut machine = Machine::new().unwrap();
    machine.boot(&std::fs::read(path).unwrap()).unwrap();
    machine.run(20 * MILLISECOND);
    let machine: Shared = Arc::new(Mutex::new(machine));
    let client = Client::open(Box::new(EmulatedLink::new(machine.clone())), Options::default()).unwrap();
    Some((client, machine))
}

fn apply(machine: &Shared, input: usize, volts: f64) {
    let mut machine = lock(machine);
    let now = machine.chip.now;
    machine.chip.bus.adc.apply(input, volts, now);
    // The round in progress, a whole one, and the tick that reads it.
    machine.run(100 * MICROSECOND);
}

/// Inputs of ADC3: A2 is PC3_C, A4 is PC2_C (UM2407).
const A2: usize = 1;
const A4: usize = 0;

/// A step of the converter at the terminal.
const STEP: f64 = 25.0 / 65536.0;

#[test]
fn voltages_at_the_pins_are_read_at_the_terminals_scale() {
    let Some((client, machine)) = linked() else { return };
    let volts = || -> Vec<f64> {
        let (_, items) = client.call_items(GetAdc { core: 1.into(), adc: 1.into(), count: 2.into() }, &[]).unwrap();
        items.iter().map(|item| item.value.get()).collect()
    };
    // Two resistors to the supply and to ground, one from the terminal: 0 to 3.3 V stand for −12.5
    // to 12.5 V.
    for (first, second) in [(0.0, 3.3), (1.65, 0.33), (3.3, 1.65), (1.0, 2.97)] {
        apply(&machine, A2, first);
        apply(&machine, A4, second);
        let read = volts();
        assert_eq!(read.len(), 2);
        for (read, pin) in read.iter().zip([first, second]) {
            let ideal = (pin - 1.65) * 12.5 / 1.65;
            assert!((read - ideal).abs() <= STEP, "{pin} V at the pin: {read} V instead of {ideal}");
        }
    }
    // Nothing stands for what follows the last input; a read that begins there is refused.
    assert!(client.call_items(GetAdc { core: 1.into(), adc: 3.into(), count: 1.into() }, &[]).is_err());
    let (_, items) = client.call_items(GetAdc { core: 1.into(), adc: 2.into(), count: 2.into() }, &[]).unwrap();
    assert_eq!(items.len(), 1);
    assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new());
}

/// An encoder at its two lines, both high at first, and with an index a turn if it has one.
struct Encoder {
    lines: [Pin; 2],
    index: Option<(Pin, i64)>,
    place: i64,
}

/// Counts a turn.
const TURN: i64 = 400;

impl Encoder {
    fn at(machine: &Shared, lines: [&str; 2]) -> Encoder {
        let lines = lines.map(|name| Pin::named(name).unwrap());
        lines.iter().for_each(|pin| lock(machine).drive(*pin, Some(true)));
        Encoder { lines, index: None, place: 0 }
    }

    /// The index line is high at this count of each turn.
    fn with_index(machine: &Shared, lines: [&str; 2], index: &str, at: i64) -> Encoder {
        let index = Some((Pin::named(index).unwrap(), at));
        Encoder { index, ..Encoder::at(machine, lines) }
    }

    /// The first index that so many counts from here pass.
    fn next_index(&self, counts: i64) -> Option<i64> {
        let (_, at) = self.index?;
        (1..=counts.abs()).map(|n| self.place + n * counts.signum()).find(|place| place.rem_euclid(TURN) == at)
    }

    /// Turns by so many counts, one in half a µs.
    fn turn(&mut self, machine: &Shared, counts: i64) {
        let mut machine = lock(machine);
        for _ in 0..counts.abs() {
            self.place += counts.signum();
            // A leads B forwards (RM0433 table 337).
            let levels = [(true, true), (false, true), (false, false), (true, false)];
            let (a, b) = levels[self.place.rem_euclid(4) as usize];
            let [one, two] = self.lines;
            machine.drive(one, Some(a));
            machine.drive(two, Some(b));
            if let Some((index, at)) = self.index {
                machine.drive(index, Some(self.place.rem_euclid(TURN) == at));
            }
            machine.run(MICROSECOND / 2);
        }
        machine.run(200 * MICROSECOND);
    }
}

const FOLLOWING_ERROR: i32 = 1 << 4;

#[test]
fn edges_of_encoders_are_counted_watched_and_captured() {
    let Some((client, machine)) = linked() else { return };
    let core = 1.into();
    let places = || {
        let read = GetEncPos { core, encoder: 1.into(), count: 3.into() };
        client.call_items(read, &[]).unwrap().1.iter().map(|item| item.value.get()).collect::<Vec<f64>>()
    };
    let status = || client.call_items(GetSts { core, axis: 1.into(), count: 1.into() }, &[]).unwrap().1[0].value.get();
    let mut one = Encoder::at(&machine, ["PB4", "PB5"]);
    let mut two = Encoder::at(&machine, ["PD12", "PD13"]);
    // More than the timer's 16 bits would take some hundred ms of edges: the turn of its counter is
    // passed downwards instead.
    two.turn(&machine, -301);
    one.turn(&machine, 1003);
    assert_eq!(places(), [1003.0, -301.0, 0.0]);
    two.turn(&machine, 300);
    assert_eq!(places(), [1003.0, -1.0, 0.0]);

    // Home of axis 1 captures the count of its tick.
    let home = Pin::named("PD0").unwrap();
    let captured = || {
        let (_, items) = client.call_items(GetCaptureStatus { core, encoder: 1.into(), count: 1.into() }, &[]).unwrap();
        (items[0].status.get(), items[0].value.get())
    };
    client.call(SetCaptureMode { core, encoder: 1.into(), mode: 1.into() }).unwrap();
    one.turn(&machine, -3);
    assert_eq!(captured(), (0, 0));
    lock(&machine).drive(home, Some(true));
    lock(&machine).run(100 * MICROSECOND);
    one.turn(&machine, -500);
    assert_eq!(captured(), (1, 1000));
    assert_eq!(places()[0], 500.0);

    // Beyond the limit of the following error, which is 500 from a planned 0.
    client.call(LmtsOff { core, axis: 1.into(), limit_type: (-1).into() }).unwrap();
    client.call(SetPosErr { core, control: 1.into(), error: 501.into() }).unwrap();
    client.call(AxisOn { core, axis: 1.into() }).unwrap();
    client.call(ClrSts { core, axis: 1.into(), count: 1.into() }).unwrap();
    one.turn(&machine, 1);
    assert_eq!(status() & FOLLOWING_ERROR, 0);
    one.turn(&machine, 1);
    assert_eq!(status() & FOLLOWING_ERROR, FOLLOWING_ERROR);
    // It is reported as the edges go on: 100 counts in 100 µs.
    let velocity = GetEncVel { core, encoder: 1.into(), count: 1.into() };
    assert_eq!(client.call_items(velocity, &[]).unwrap().1[0].value.get(), 0.0);
    assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new());
}

/// A hundred counts come in a tick: only the timers can tell at which of them the index was.
#[test]
fn an_index_is_captured_to_the_count() {
    let Some((client, machine)) = linked() else { return };
    let core = 1.into();
    // On either side of 65536, where the timers turn over.
    let mut encoders = [
        Encoder::with_index(&machine, ["PB4", "PB5"], "PB1", 65_530 % TURN),
        Encoder::with_index(&machine, ["PD12", "PD13"], "PD14", 65_540 % TURN),
    ];
    let arm = |encoder: i16| client.call(SetCaptureMode { core, encoder: encoder.into(), mode: 2.into() });
    let captured = |encoder: i16| {
        let read = GetCaptureStatus { core, encoder: encoder.into(), count: 1.into() };
        let (_, items) = client.call_items(read, &[]).unwrap();
        (items[0].status.get(), i64::from(items[0].value.get()))
    };
    for ((number, timer), encoder) in [(1, 3), (2, 4)].into_iter().zip(&mut encoders) {
        // An index that nobody asked for is none later.
        encoder.turn(&machine, 450);
        arm(number).unwrap();
        encoder.turn(&machine, 3);
        assert_eq!(captured(number), (0, 0), "encoder {number}: an index from before");
        // Over 0 and back, and several turns: the first index counts.
        for counts in [1000, -1600, 1250, -401] {
            arm(number).unwrap();
            let expected = encoder.next_index(counts).unwrap();
            encoder.turn(&machine, counts);
            assert_eq!(captured(number), (1, expected), "encoder {number}, {counts} counts to {}", encoder.place);
        }
        // To where the timer turns over, at some 30,000 counts a tick.
        for _ in 0..2 {
            lock(&machine).chip.bus.timer(timer).unwrap().turn(32_400);
            encoder.place += 32_400;
            lock(&machine).run(100 * MICROSECOND);
        }
        encoder.turn(&machine, 65_400 - encoder.place);
        for counts in [200, -200, 200] {
            arm(number).unwrap();
            let expected = encoder.next_index(counts).unwrap();
            assert!((65_530..=65_540).contains(&expected));
            encoder.turn(&machine, counts);
            assert_eq!(captured(number), (1, expected), "encoder {number}, {counts} counts to {}", encoder.place);
        }
        // In counts as SetEncPos names them.
        client.call(SetEncPos { core, encoder: number.into(), pos: (-7).into() }).unwrap();
        arm(number).unwrap();
        let (from, expected) = (encoder.place, encoder.next_index(-TURN).unwrap());
        encoder.turn(&machine, -TURN);
        assert_eq!(captured(number), (1, expected - from - 7), "encoder {number}");
    }
    // Axis 3 has no encoder.
    let refusal = arm(3).unwrap_err().to_string();
    for part in ["mode is 2", "1 to 1", "encoder 3"] {
        assert!(refusal.contains(part), "{part}: {refusal}");
    }
    assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new());
}

const ALARM: i32 = 1 << 1;

#[test]
fn alarms_are_read_where_the_table_of_pins_has_them() {
    let Some((client, machine)) = linked() else { return };
    let alarms = || -> Vec<bool> {
        client.call(ClrSts { core: 1.into(), axis: 1.into(), count: 8.into() }).unwrap();
        lock(&machine).run(200 * MICROSECOND);
        let read = GetSts { core: 1.into(), axis: 1.into(), count: 8.into() };
        client.call_items(read, &[]).unwrap().1.iter().map(|item| item.value.get() & ALARM != 0).collect()
    };
    for (axis, name) in ["PA0", "PA3", "PA6", "PA15", "PC0", "PC6", "PD11", "PD15"].into_iter().enumerate() {
        let pin = Pin::named(name).unwrap();
        lock(&machine).drive(pin, Some(true));
        lock(&machine).run(200 * MICROSECOND);
        let expected: Vec<bool> = (0..8).map(|other| other == axis).collect();
        assert_eq!(alarms(), expected, "{name}");
        lock(&machine).drive(pin, None);
        lock(&machine).run(200 * MICROSECOND);
    }
    assert_eq!(lock(&machine).chip.bus.complaints, Vec::<String>::new());
}
