//! What every model of a peripheral is: registers, and a state that advances with time.
//!
//! In: reads, writes, instants. Out: values, and [`Signal`]s for the rest of the chip. A model is
//! advanced to an instant before anything else happens to it there.
use crate::clocks::Clocks;
use crate::time::Time;

/// What ends a run and begins the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Power has come.
    Power,
    /// The button, or the ST-LINK.
    Pin,
    /// AIRCR.SYSRESETREQ.
    Software,
    /// The independent watchdog.
    Watchdog,
}

/// What a peripheral signals to the rest of the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    /// The level of an interrupt's line.
    Line(usize, bool),
    /// A DMA request, by its number at DMAMUX 1 (RM0433 table 120).
    Request(u8),
    /// The trigger output of a timer.
    Trigger(u8),
    /// A peripheral does not ask any more.
    Withdraw(u8),
    /// The stream of this request begins anew: a wrong fact that is planted.
    Rewind(u8),
    /// A DMA writes a peripheral's register, `size` bytes.
    #[allow(missing_docs)]
    Store { address: u32, size: u32, value: u32 },
    /// A DMA's stream (of both controllers) reads one.
    #[allow(missing_docs)]
    Fetch { address: u32, size: u32, stream: u8 },
    /// The level that a peripheral gives to a pin's alternate function; `None`: it does not drive
    /// it.
    Output(Source, Option<bool>),
    /// The chip is reset.
    Reset(Cause),
}

/// A signal inside the chip that a pin's alternate function may show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Source {
    /// A channel of a timer, from 1; the complementary one if true.
    Timer(u8, u8, bool),
    /// What a USART sends.
    UsartTx(u8),
    /// The clock of an SPI.
    SpiClock(u8),
    /// What an SPI sends as a master.
    SpiData(u8),
}

/// See the module text.
pub trait Device {
    /// A read of the register at `offset`, or `None` if it is not modelled.
    fn read(&mut self, offset: u32, at: Time, out: &mut Vec<Signal>) -> Option<u32>;
    /// A write; only the bits of `mask` are written (byte and halfword accesses). `None` if it is
    /// not modelled.
    fn write(&mut self, offset: u32, value: u32, mask: u32, at: Time, out: &mut Vec<Signal>) -> Option<()>;
    /// When something happens next by itself.
    fn next(&self) -> Time;
    /// Does what happens by itself until `to`.
    fn advance(&mut self, to: Time, out: &mut Vec<Signal>);
    /// As it is after a reset.
    fn reset(&mut self, at: Time, out: &mut Vec<Signal>);
    /// The clocks are these from now on.
    fn clocks(&mut self, clocks: &Clocks, at: Time) {
        let _ = (clocks, at);
    }
}
