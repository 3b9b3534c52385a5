//! The USB device (RM0433 57): full speed, on the core that the chip calls OTG_FS and the
//! manual OTG_HS2.
//!
//! In and out: packets, by `embassy-usb-synopsys-otg`. Owns the core, its supply and its pins.
//! Fails: without its supply there is no USB.
//!
//! This module works around three cases of the driver:
//! - A request for an endpoint that the board lacks is ignored: the driver would stop the board.
//! - A packet that waits when the host resets the bus is dropped: the driver would wait forever.
//! - An endpoint that expects another packet is enabled again, as the manual asks: the driver
//!   clears only its NAK.
use super::boards::BOARD;
use super::{clocks, package, pins};
use core::future::{Future, poll_fn};
use core::pin::pin;
use embassy_usb_driver::{
    self as usb, Direction, EndpointAddress, EndpointAllocError, EndpointError, EndpointInfo, EndpointType, Event,
    Unsupported,
};
use embassy_usb_synopsys_otg::otg_v1::Otg;
use embassy_usb_synopsys_otg::{
    self as otg, Config, ControlPipe, Driver, Endpoint, In, OtgInstance, Out, PhyType, StateStorage,
};
use stm32_metapac::{PWR, RCC, UID, USB_OTG_FS};

/// Bytes of a packet.
pub const PACKET_BYTES: usize = 64;
/// Bytes that wait to be fetched: a packet of the control pipe and one of the link.
pub const WAITING_BYTES: usize = 2 * PACKET_BYTES;
/// Digits of the chip's unique id.
pub const ID_DIGITS: usize = 24;

/// The current that the board takes from the host at most, in mA; 0 with a supply of its own.
pub const MILLIAMPERES: u16 = BOARD.usb.milliamperes;

/// Endpoints each way: control; notifications and bytes received; bytes sent.
const ENDPOINTS: usize = 3;
/// The core's memory, 4 KiB (RM0433 57).
const FIFO_WORDS: u16 = 1024;
/// For SETUP packets, status words and the global NAK (RM0433 57, OTG_GRXFSIZ, asks for fewer).
const RX_EXTRA_WORDS: u16 = 30;
/// Turn-around time for an AHB of 32 MHz and more (RM0433 57).
const TURN_AROUND: u8 = 6;
/// Polls of a flag that comes within µs, each some bus cycles.
const MAX_POLLS: u32 = 20_000;

static STATE: StateStorage<ENDPOINTS> = StateStorage::new();

fn core() -> Otg {
    // SAFETY: the core's address, with the registers of the driver's version of it.
    unsafe { Otg::from_ptr(USB_OTG_FS.as_ptr().cast()) }
}

fn waits_for(mut is_so: impl FnMut() -> bool) -> bool {
    (0..MAX_POLLS).any(|_| is_so())
}

/// Supply, clock, pins and core. `None` if there is no supply.
///
/// # Safety
/// At most once.
pub unsafe fn open(waiting: &'static mut [u8; WAITING_BYTES]) -> Option<Usb> {
    // 3.3 V are external (UM2407); the chip's regulator stays off (RM0433 6.4).
    PWR.cr3().modify(|w| w.set_usb33den(true));
    if !waits_for(|| PWR.cr3().read().usb33rdy()) {
        return None;
    }
    clocks::give_usb();
    RCC.ahb1enr().modify(|w| w.set_usb_otg_fsen(true));
    // Read back, so that the clock is on (RM0433 8.5.8).
    RCC.ahb1enr().read();
    // No ULPI is fitted: with its clock enabled, the core would stop while the CPU sleeps (RM0433
    // 8.7, AHB1LPENR).
    RCC.ahb1lpenr().modify(|w| w.set_usb_otg_fs_ulpilpen(false));
    // The chip senses the host's 5 V. On another package their pin may have another signal.
    let senses_vbus = BOARD.usb.vbus.is_some() && !package::is_other();
    // SAFETY: once, as asked of the caller.
    unsafe { pins::open_usb(senses_vbus) };
    let core = core();
    if !waits_for(|| core.grstctl().read().ahbidl()) {
        return None;
    }
    core.gusbcfg().write(|w| {
        // A device at any level of the ID pin, with the internal transceiver.
        w.set_fdmod(true);
        w.set_physel(true);
    });
    // Not connected before the driver says so: sources differ on the bit's value after a reset.
    core.dctl().write(|w| w.set_sdis(true));
    core.gccfg_v2().modify(|w| {
        // The bit switches the transceiver on.
        w.set_pwrdwn(true);
        w.set_vbden(senses_vbus);
    });
    if !senses_vbus {
        // A session without the host's 5 V (RM0433 57, OTG_GOTGCTL).
        core.gotgctl().modify(|w| {
            w.set_bvaloen(true);
            w.set_bvaloval(true);
        });
    }
    let mut config = Config::default();
    config.vbus_detection = senses_vbus;
    let instance = OtgInstance {
        regs: core,
        state: STATE.as_state(),
        fifo_depth_words: FIFO_WORDS,
        phy_type: PhyType::InternalFullSpeed,
        extra_rx_fifo_words: RX_EXTRA_WORDS,
        calculate_trdt_fn: |_| TURN_AROUND,
    };
    Some(Usb(Driver::new(waiting, instance, config)))
}

/// In the interrupt: moves packets between the core and their buffers.
///
/// # Safety
/// Only in the interrupt of the core, after [`open`].
pub unsafe fn serve() {
    // SAFETY: as asked of the caller.
    unsafe { otg::on_interrupt(core(), &STATE.as_state()) };
    enable_ready_endpoints();
}

/// Enables the OUT endpoints that answer no NAK. The core accepts packets only while EPENA is set,
/// and clears it at the end of a transfer (RM0433 57, OTG_DOEPCTL). That end may come after the
/// driver has asked for the next packet. Setting EPENA again changes nothing.
fn enable_ready_endpoints() {
    for index in 0..ENDPOINTS {
        let control = core().doepctl(index);
        let is = control.read();
        if is.usbaep() && !is.naksts() && !is.epena() {
            control.modify(|w| w.set_epena(true));
        }
    }
}

/// The chip's unique id in hexadecimal digits (RM0433 61.1).
pub fn unique_id() -> [u8; ID_DIGITS] {
    let words = [0, 1, 2].map(|n| UID.uid(n).read());
    let mut digits = [0; ID_DIGITS];
    let nibbles = words.into_iter().flat_map(|word| (0..8).rev().map(move |n| (word >> (4 * n) & 0xf) as u8));
    for (digit, nibble) in digits.iter_mut().zip(nibbles) {
        *digit = if nibble < 10 { b'0' + nibble } else { b'A' + (nibble - 10) };
    }
    digits
}

/// The driver.
pub struct Usb(Driver<'static>);

impl usb::Driver<'static> for Usb {
    type EndpointOut = Taker;
    type EndpointIn = Endpoint<'static, In>;
    type ControlPipe = Control;
    type Bus = Bus;

    fn alloc_endpoint_out(
        &mut self,
        kind: EndpointType,
        address: Option<EndpointAddress>,
        packet: u16,
        interval_ms: u8,
    ) -> Result<Self::EndpointOut, EndpointAllocError> {
        self.0.alloc_endpoint_out(kind, address, packet, interval_ms).map(Taker)
    }

    fn alloc_endpoint_in(
        &mut self,
        kind: EndpointType,
        address: Option<EndpointAddress>,
        packet: u16,
        interval_ms: u8,
    ) -> Result<Self::EndpointIn, EndpointAllocError> {
        self.0.alloc_endpoint_in(kind, address, packet, interval_ms)
    }

    fn start(self, control_packet: u16) -> (Self::Bus, Self::ControlPipe) {
        let (bus, control) = self.0.start(control_packet);
        (Bus(bus), Control(control))
    }
}

/// An endpoint that receives packets.
pub struct Taker(Endpoint<'static, Out>);

impl usb::Endpoint for Taker {
    fn info(&self) -> &EndpointInfo {
        self.0.info()
    }

    async fn wait_enabled(&mut self) {
        self.0.wait_enabled().await;
    }
}

impl usb::EndpointOut for Taker {
    async fn read(&mut self, packet: &mut [u8]) -> Result<usize, EndpointError> {
        let taken = self.0.read(packet).await;
        critical_section::with(|_| enable_ready_endpoints());
        taken
    }
}

/// The control pipe.
pub struct Control(ControlPipe<'static>);

impl usb::ControlPipe for Control {
    fn max_packet_size(&self) -> usize {
        self.0.max_packet_size()
    }

    async fn setup(&mut self) -> [u8; 8] {
        let mut setup = pin!(self.0.setup());
        // In one critical section: the interrupt enables endpoints without NAK.
        poll_fn(|cx| {
            critical_section::with(|_| {
                let request = setup.as_mut().poll(cx);
                if request.is_ready() {
                    // A packet of data or of status follows. The driver sets only how many SETUP
                    // packets may come.
                    core().doeptsiz(0).modify(|w| {
                        w.set_xfrsiz(PACKET_BYTES as u32);
                        w.set_pktcnt(1);
                    });
                    enable_ready_endpoints();
                }
                request
            })
        })
        .await
    }

    async fn data_out(&mut self, data: &mut [u8], first: bool, last: bool) -> Result<usize, EndpointError> {
        let taken = self.0.data_out(data, first, last).await;
        critical_section::with(|_| enable_ready_endpoints());
        taken
    }

    async fn data_in(&mut self, data: &[u8], first: bool, last: bool) -> Result<(), EndpointError> {
        self.0.data_in(data, first, last).await
    }

    async fn accept(&mut self) {
        self.0.accept().await;
    }

    async fn reject(&mut self) {
        self.0.reject().await;
    }

    async fn accept_set_address(&mut self, address: u8) {
        self.0.accept_set_address(address).await;
    }
}

/// The device as a whole.
pub struct Bus(otg::Bus<'static>);

fn is_there(address: EndpointAddress) -> bool {
    address.index() < ENDPOINTS
}

/// Drops a packet that waits to be fetched, and disables the endpoint (RM0433 57).
fn cancel(address: EndpointAddress) {
    let (index, core) = (address.index(), core());
    if address.direction() == Direction::In {
        let control = core.diepctl(index);
        if control.read().epena() {
            control.modify(|w| {
                w.set_snak(true);
                w.set_epdis(true);
            });
            // The driver flushes the FIFO afterwards.
            waits_for(|| !control.read().epena());
        }
    } else {
        let control = core.doepctl(index);
        if control.read().epena() {
            control.modify(|w| {
                w.set_snak(true);
                w.set_epdis(true);
            });
            waits_for(|| !control.read().epena());
        }
    }
}

impl usb::Bus for Bus {
    async fn enable(&mut self) {
        self.0.enable().await;
    }

    async fn disable(&mut self) {
        self.0.disable().await;
    }

    async fn poll(&mut self) -> Event {
        self.0.poll().await
    }

    fn endpoint_set_enabled(&mut self, address: EndpointAddress, enabled: bool) {
        if is_there(address) {
            cancel(address);
            self.0.endpoint_set_enabled(address, enabled);
        }
    }

    fn endpoint_set_stalled(&mut self, address: EndpointAddress, stalled: bool) {
        if is_there(address) {
            self.0.endpoint_set_stalled(address, stalled);
        }
    }

    fn endpoint_is_stalled(&mut self, address: EndpointAddress) -> bool {
        is_there(address) && self.0.endpoint_is_stalled(address)
    }

    async fn remote_wakeup(&mut self) -> Result<(), Unsupported> {
        Err(Unsupported)
    }
}
