//! Facts of the chip that may be otherwise than the image takes them for: planted one at a time,
//! for tests of what shall notice.
//!
//! In: a [`Wrong`]. Out: a machine that differs in this one fact, from then on and over every
//! reset. Owns nothing.
use crate::gpio::Pin;
use crate::machine::Machine;
use crate::time::{MILLISECOND, Time};

/// The request that clears slots of steps (RM0433 table 121).
const TIM17_CH1: u8 = 111;
/// Each laser timer, the request of its update, and the time from a request of it to its transfer
/// where its bursts are slow: 3 times 120 ns are 360 ns, and 6 times 85 ns are 510 ns.
const SLOW_BURSTS: [(u8, u8, Time); 3] = [(1, 15, 115), (15, 106, 115), (8, 51, 82)];

/// A fact that is otherwise (docs/board-assumptions.md).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrong {
    /// AF1.BKINP of this timer means the opposite.
    BreakPolarity(u8),
    /// A break acts by its edge: MOE may be set while the input is high.
    BreakByEdge,
    /// The break input of this timer has no connection with its pin.
    Unconnected(u8),
    /// The break input of this timer is high whatever its pin is.
    StuckBreak(u8),
    /// Lines of this timer have other levels while they are idle.
    OtherRest(u8),
    /// AF1 of this timer cannot be written.
    NoAf1(u8),
    /// RCR of TIM8 has eight bits.
    ShortRepeat,
    /// SYSCFG_CFGR lies elsewhere.
    NoBreakSources,
    /// PKGR says this.
    Package(u32),
    /// Another chip.
    Chip(u16),
    /// A revision of the chip.
    Revision(u16),
    /// CPUID of an earlier core.
    EarlyCore,
    /// The core saves floating-point registers at each interrupt at once.
    EagerStacking,
    /// PB0 is an output after a reset.
    DrivenAtReset,
    /// This timer starts 12 counts after its trigger.
    StartsLate(u8),
    /// This timer has its trigger at another input.
    Deaf(u8),
    /// A reload value of 0 does not block this timer.
    CountsToZero(u8),
    /// A reset of this timer leaves its burst where it is.
    KeepsBurst(u8),
    /// At a break lines are inactive for 200 counts before they are idle.
    SettlesLong,
    /// DMA takes six times as long from a request to its transfer.
    SlowDma,
    /// A burst of this laser timer takes some 10 ns more than its shortest cycle: 360 ns for three
    /// half-words, 510 ns for six.
    SlowBurst(u8),
    /// An instruction takes so many cycles of the core.
    SlowCore(u8),
    /// Analog outputs change half a ms late.
    SlowDac,
    /// Analog inputs read 2 % less.
    LowAdc,
    /// Breaks of the chip set the same flag as the input's, in all timers.
    OneFlag,
    /// A break input acts 28 counts after its pin.
    SlowBreak,
    /// A stream begins anew with its first item when its timer goes on.
    StreamRewinds,
    /// A transfer keeps a controller busy six times as long.
    BusyDma,
    /// Timers of APB 1 count half as fast.
    HalfTimers,
    /// The caches cannot be enabled.
    NoCaches,
    /// The UART is 3 % slow.
    SlowLink,
    /// HSI48 is 6 % slow.
    SlowHsi48,
    /// A reset clears the memory that start-up leaves as it is.
    Forgets,
    /// 5 V at the connector of USB, whatever PD10 says.
    FiveVolts,
    /// The supply is at 2.6 V.
    LowSupply,
    /// BDTR.OSSI of this timer stays 0.
    NoIdleLevels(u8),
    /// TRBUFF of DMA's streams reads as 0.
    NoBuffer,
    /// LSI is 15 % slow.
    SlowLsi,
    /// A core that is locked up does not break the timers.
    NoLockUpBreak,
    /// A and B of this timer's encoder are swapped.
    SwappedEncoder(u8),
    /// This timer counts the edges of A alone.
    HalfEncoder(u8),
    /// The index of this timer passes no filter, as A and B do.
    EarlyIndex(u8),
    /// The kernel of SPI 1 to 3 has half its clock.
    SlowSpi,
    /// The clock's guard does not break the timers.
    NoClockBreak,
    /// The watchdog goes on while a debugger halts the core.
    NotFrozen,
    /// The device at USB does not connect.
    NoDevice,
    /// GOTGCTL makes no session.
    NoSession,
    /// The source of the board's clock does not run.
    NoSource,
    /// Each 500th byte that DMA fetches from the link is damaged.
    SpoiltBytes,
    /// Each fiftieth packet of data of USB is damaged, as by an endpoint that was set again too
    /// early.
    SpoiltPackets,
    /// What DMA writes for TIM17's compare requests is lost: slots that were played stay.
    LostClears,
}

/// What of a timer may be planted; kept over resets.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Quirks {
    /// [`Wrong::BreakByEdge`].
    pub by_edge: bool,
    /// [`Wrong::NoAf1`].
    pub no_af1: bool,
    /// [`Wrong::Unconnected`].
    pub unconnected: bool,
    /// [`Wrong::StuckBreak`].
    pub stuck: bool,
    /// [`Wrong::OtherRest`].
    pub other_rest: bool,
    /// [`Wrong::ShortRepeat`].
    pub short_repeat: bool,
    /// [`Wrong::StartsLate`], in counts.
    pub start_delay: Time,
    /// [`Wrong::Deaf`].
    pub is_deaf: bool,
    /// [`Wrong::CountsToZero`].
    pub counts_to_zero: bool,
    /// [`Wrong::KeepsBurst`].
    pub keeps_burst: bool,
    /// [`Wrong::SettlesLong`], in counts beyond two.
    pub settles_more: Time,
    /// [`Wrong::OneFlag`].
    pub one_flag: bool,
    /// [`Wrong::SlowBreak`], in counts.
    pub break_delay: Time,
    /// [`Wrong::StreamRewinds`].
    pub rewinds: bool,
    /// [`Wrong::NoIdleLevels`].
    pub no_ossi: bool,
    /// [`Wrong::SwappedEncoder`].
    pub swapped: bool,
    /// [`Wrong::HalfEncoder`].
    pub halves: bool,
    /// [`Wrong::EarlyIndex`].
    pub early_index: bool,
    /// [`Wrong::NoClockBreak`].
    pub no_clock_break: bool,
}

impl Machine {
    /// Plants a wrong fact.
    pub fn plant(&mut self, wrong: Wrong) {
        let bus = &mut self.chip.bus;
        match wrong {
            Wrong::BreakPolarity(number) => bus.timers_named(number).for_each(|timer| timer.is_odd = true),
            Wrong::BreakByEdge => bus.timers.iter_mut().for_each(|timer| timer.quirks.by_edge = true),
            Wrong::Unconnected(number) => bus.timers_named(number).for_each(|timer| timer.quirks.unconnected = true),
            Wrong::StuckBreak(number) => bus.timers_named(number).for_each(|timer| timer.quirks.stuck = true),
            Wrong::OtherRest(number) => bus.timers_named(number).for_each(|timer| timer.quirks.other_rest = true),
            Wrong::NoAf1(number) => bus.timers_named(number).for_each(|timer| timer.quirks.no_af1 = true),
            Wrong::ShortRepeat => bus.timers_named(8).for_each(|timer| timer.quirks.short_repeat = true),
            Wrong::NoBreakSources => bus.syscfg.lacks_cfgr = true,
            Wrong::Package(package) => bus.syscfg.package = package,
            Wrong::Chip(device) => bus.dbgmcu.device = device,
            Wrong::Revision(revision) => bus.dbgmcu.revision = revision,
            Wrong::EarlyCore => self.chip.identity.cpuid = 0x410f_c270,
            Wrong::EagerStacking => self.chip.identity.fpccr = 0x8000_0000,
            Wrong::DrivenAtReset => bus.gpio.drive_at_reset(),
            Wrong::StartsLate(number) => bus.timers_named(number).for_each(|timer| timer.quirks.start_delay = 12),
            Wrong::Deaf(number) => bus.timers_named(number).for_each(|timer| timer.quirks.is_deaf = true),
            Wrong::CountsToZero(number) => {
                bus.timers_named(number).for_each(|timer| timer.quirks.counts_to_zero = true)
            }
            Wrong::KeepsBurst(number) => bus.timers_named(number).for_each(|timer| timer.quirks.keeps_burst = true),
            Wrong::SettlesLong => bus.timers.iter_mut().for_each(|timer| timer.quirks.settles_more = 198),
            Wrong::SlowDma => bus.dma.answer *= 6,
            Wrong::SlowBurst(number) => {
                let slow = SLOW_BURSTS.iter().find(|(timer, ..)| *timer == number);
                bus.dma.slow = slow.map(|(_, request, answer)| (*request, *answer));
            }
            Wrong::SlowCore(cycles) => self.chip.identity.instruction_cycles = cycles.into(),
            Wrong::SlowDac => bus.dac.lag = MILLISECOND / 2,
            Wrong::LowAdc => bus.adc.gain = 0.98,
            Wrong::OneFlag => bus.timers.iter_mut().for_each(|timer| timer.quirks.one_flag = true),
            Wrong::SlowBreak => bus.timers.iter_mut().for_each(|timer| timer.quirks.break_delay = 28),
            Wrong::StreamRewinds => bus.timers.iter_mut().for_each(|timer| timer.quirks.rewinds = true),
            Wrong::BusyDma => bus.dma.busy *= 6,
            Wrong::HalfTimers => bus.rcc.halves_timers = true,
            Wrong::NoCaches => self.chip.identity.lacks_caches = true,
            Wrong::SlowLink => bus.usart.slow_percent = 3,
            Wrong::LowSupply => bus.pwr.supply_mv = 2600,
            Wrong::NoIdleLevels(number) => bus.timers_named(number).for_each(|timer| timer.quirks.no_ossi = true),
            Wrong::NoBuffer => bus.dma.lacks_buffer = true,
            Wrong::LostClears => bus.dma.loses = Some(TIM17_CH1),
            Wrong::SlowLsi => bus.watchdog.slow_percent = 15,
            Wrong::NoLockUpBreak => bus.syscfg.lacks_lock_up = true,
            Wrong::SwappedEncoder(number) => bus.timers_named(number).for_each(|timer| timer.quirks.swapped = true),
            Wrong::HalfEncoder(number) => bus.timers_named(number).for_each(|timer| timer.quirks.halves = true),
            Wrong::EarlyIndex(number) => bus.timers_named(number).for_each(|timer| timer.quirks.early_index = true),
            Wrong::SlowSpi => bus.rcc.halves_spi = true,
            Wrong::NoClockBreak => bus.timers.iter_mut().for_each(|timer| timer.quirks.no_clock_break = true),
            Wrong::NotFrozen => bus.dbgmcu.never_freezes = true,
            Wrong::NoDevice => bus.usb.core.no_device = true,
            Wrong::NoSession => bus.usb.core.no_session = true,
            Wrong::NoSource => self.give_clock(false),
            Wrong::SpoiltBytes => bus.usart.spoils = true,
            Wrong::SpoiltPackets => bus.usb.core.spoils_packets = true,
            Wrong::Forgets => self.chip.forgets = true,
            Wrong::FiveVolts => bus.gpio.drive(Pin(0, 9), Some(true)),
            Wrong::SlowHsi48 => bus.rcc.hsi48_slow_percent = 6,
        }
        self.identify();
    }
}
