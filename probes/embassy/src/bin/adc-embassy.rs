#![no_std]
#![no_main]
//! Clocks, and two analog inputs, by embassy-stm32.
use embassy_stm32::adc::{Adc, SampleTime};

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut p = beamtick_embassy::init();
    let mut adc = Adc::new(p.ADC3);
    let one = adc.blocking_read(&mut p.PF3, SampleTime::CYCLES64_5);
    let two = adc.blocking_read(&mut p.PF4, SampleTime::CYCLES64_5);
    core::hint::black_box([one, two]);
    beamtick_embassy::rest()
}
