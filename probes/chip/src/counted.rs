//! A tick whose instructions are counted.
//!
//! In: a tick with its hand-overs, on a machine that only stores. Out: clock periods of each tick.
//! Owns them and the cost of reading the clock, which it takes off. Cannot fail.
use crate::clock;
use crate::machine::Sink;
use core::hint::black_box;
use servo::tick::{Tick, TickHalves};

/// The tick, its machine and its hand-overs.
pub struct Counted<const AXES: usize> {
    tick: Tick<AXES>,
    machine: Sink<AXES>,
    lanes: TickHalves<'static, AXES>,
    /// Periods that reading the clock twice takes by itself.
    reading: u32,
}

type Call<const AXES: usize> = fn(&mut Tick<AXES>, &mut Sink<AXES>, &mut TickHalves<'static, AXES>);

/// Not inlined, so that each tick is the same code as in the image.
#[inline(never)]
fn counted_tick<const AXES: usize>(
    tick: &mut Tick<AXES>,
    machine: &mut Sink<AXES>,
    lanes: &mut TickHalves<'static, AXES>,
) {
    tick.run(machine, lanes);
}

#[inline(never)]
fn nothing<const AXES: usize>(_: &mut Tick<AXES>, _: &mut Sink<AXES>, _: &mut TickHalves<'static, AXES>) {}

impl<const AXES: usize> Counted<AXES> {
    /// From power-on; the clock runs.
    #[must_use]
    pub fn new(tick: Tick<AXES>, lanes: TickHalves<'static, AXES>) -> Self {
        let mut counted = Self { tick, machine: Sink::POWER_ON, lanes, reading: 0 };
        counted.reading = counted.count(nothing);
        counted
    }

    /// One tick that is not counted.
    pub fn pass(&mut self) {
        counted_tick(&mut self.tick, &mut self.machine, &mut self.lanes);
    }

    /// One tick; the clock's periods that it takes.
    pub fn step(&mut self) -> u32 {
        self.count(counted_tick).saturating_sub(self.reading)
    }

    fn count(&mut self, call: Call<AXES>) -> u32 {
        let call = black_box(call);
        let before = clock::read();
        call(&mut self.tick, &mut self.machine, &mut self.lanes);
        before.passed()
    }
}
