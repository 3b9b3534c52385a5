#![no_std]
#![no_main]
//! Must not link: the same as `no-panic`, with a machine that looks up an axis that may not be
//! there.
use core::hint::black_box;
use core::panic::PanicInfo;
use probes::AXES;
use servo::laser::LaserPlan;
use servo::port::{AxisInputs, GeneralInputs, GeneralOutputs, Port};
use servo::tick::{Tick, TickHalves};
use servo::units::{Axis, Pos};

unsafe extern "C" {
    fn something_reached_a_panic() -> !;
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    // SAFETY: there is no such function; the linker says so if this is reachable.
    unsafe { something_reached_a_panic() }
}

/// Has fewer axes than the tick asks for.
struct Short {
    set_points: [Pos; AXES - 1],
}

impl Port for Short {
    fn inputs(&mut self, _: Axis) -> AxisInputs {
        AxisInputs::default()
    }
    fn encoder(&mut self, _: Axis) -> i64 {
        0
    }
    fn general_inputs(&mut self) -> GeneralInputs {
        0
    }
    fn analog(&mut self, _: usize) -> i16 {
        0
    }
    fn set_point(&mut self, axis: Axis, pos: Pos) {
        self.set_points[axis.index()] = pos;
    }
    fn outputs(&mut self, _: u32, _: u64, _: u64, _: GeneralOutputs) {}
    fn analog_out(&mut self, _: u32, _: usize, _: i16) {}
    fn interlock(&mut self) -> bool {
        false
    }
    fn laser(&mut self, _: usize, _: &LaserPlan) {}
}

#[inline(never)]
fn tick(tick: &mut Tick<AXES>, machine: &mut Short, lanes: &mut TickHalves<'static, AXES>) {
    tick.run(machine, lanes);
}

#[cortex_m_rt::entry]
fn main() -> ! {
    if let Some((mut state, mut lanes, thread)) = probes::bench() {
        let mut machine = Short { set_points: [Pos(0); AXES - 1] };
        black_box(&thread);
        loop {
            tick(black_box(&mut state), black_box(&mut machine), black_box(&mut lanes));
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}
