//! The board as a USB device: a serial port of class CDC ACM, on embassy-usb.
//!
//! In: the driver of the board's core. Out: a task that answers the host, and a [`Port`] for the
//! bytes of the link. Owns the descriptors and the packet in transfer. Fails: a port that no host
//! has opened, or whose cable is out, sends and receives nothing.
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embassy_usb::class::cdc_acm::{CdcAcmClass, State, USB_CLASS_CDC};
use embassy_usb::{Builder, Config, UsbDevice, UsbVersion};
use hal::board::usb::{ID_DIGITS, MILLIAMPERES, PACKET_BYTES, Usb, WAITING_BYTES, unique_id};
use static_cell::StaticCell;

/// From pid.codes, for tests: a product needs numbers of its own.
const VENDOR: u16 = 0x1209;
const PRODUCT: u16 = 0x0001;
/// 62 bytes of descriptors: configuration, two interfaces, what CDC adds, three endpoints.
const DESCRIPTOR_BYTES: usize = 64;
/// The longest answer that is built: the serial number as a string descriptor.
const CONTROL_BYTES: usize = 2 + 2 * ID_DIGITS + 2;
/// The head of a BOS, which no host requests from a device of USB 2.0.
const BOS_BYTES: usize = 16;

/// Memory of the device's parts.
pub struct Memory {
    waiting: [u8; WAITING_BYTES],
    descriptors: [u8; DESCRIPTOR_BYTES],
    bos: [u8; BOS_BYTES],
    control: [u8; CONTROL_BYTES],
    serial: [u8; ID_DIGITS],
    state: State<'static>,
}

#[unsafe(link_section = ".backup")]
static MEMORY: StaticCell<Memory> = StaticCell::new();
static DEVICE: StaticCell<Device> = StaticCell::new();

/// The device as the host sees it.
pub type Device = UsbDevice<'static, Usb>;

/// The bytes of the link.
pub struct Port {
    class: CdcAcmClass<'static, Usb>,
    /// The last packet was full: the host waits for a shorter one.
    unended: bool,
}

/// The result of a future that is ready at once, else nothing. The driver's futures change nothing
/// before they are ready.
fn at_once<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

impl Port {
    /// Bytes of a packet that has arrived, if one has; more wait at the host until they are asked
    /// for.
    pub fn receive(&mut self, packet: &mut [u8; PACKET_BYTES]) -> usize {
        at_once(self.class.read_packet(packet)).and_then(Result::ok).unwrap_or(0)
    }

    /// Sends the first bytes and returns how many: those of a packet, once the host has fetched the
    /// one before.
    pub fn send(&mut self, bytes: &[u8]) -> usize {
        let packet = bytes.get(..PACKET_BYTES).unwrap_or(bytes);
        if !matches!(at_once(self.class.write_packet(packet)), Some(Ok(()))) {
            return 0;
        }
        self.unended = packet.len() == PACKET_BYTES;
        packet.len()
    }

    /// Ends the transfer: no more bytes follow for now.
    pub fn end(&mut self) {
        if self.unended {
            self.send(&[]);
        }
    }
}

/// The device, made of what [`hal::board::usb::open`] gives. `None` from the second call on, and
/// without a supply.
pub fn open() -> Option<(&'static mut Device, Port)> {
    let memory = MEMORY.try_init(Memory {
        waiting: [0; WAITING_BYTES],
        descriptors: [0; DESCRIPTOR_BYTES],
        bos: [0; BOS_BYTES],
        control: [0; CONTROL_BYTES],
        serial: unique_id(),
        state: State::new(),
    })?;
    // SAFETY: once, since the memory is given once.
    let driver = unsafe { hal::board::usb::open(&mut memory.waiting) }?;
    let mut config = Config::new(VENDOR, PRODUCT);
    config.manufacturer = Some("Beamtick");
    config.product = Some("Beamtick");
    // Digits only.
    config.serial_number = core::str::from_utf8(&memory.serial).ok();
    config.bcd_usb = UsbVersion::Two;
    (config.composite_with_iads, config.device_class) = (false, USB_CLASS_CDC);
    (config.device_sub_class, config.device_protocol) = (0, 0);
    (config.self_powered, config.max_power) = (MILLIAMPERES == 0, MILLIAMPERES);
    let mut builder =
        Builder::new(driver, config, &mut memory.descriptors, &mut memory.bos, &mut [], &mut memory.control);
    let class = CdcAcmClass::new(&mut builder, &mut memory.state, PACKET_BYTES as u16);
    let device = DEVICE.try_init(builder.build())?;
    Some((device, Port { class, unended: false }))
}

/// Answers the host.
#[embassy_executor::task]
pub async fn answer(device: &'static mut Device) {
    device.run().await;
}
