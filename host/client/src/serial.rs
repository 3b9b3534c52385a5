//! A link over a serial port (UART, ST-LINK's virtual port, USB CDC).
use crate::error::{self, Error, Result};
use crate::link::Link;
use serialport::{SerialPort, SerialPortType};
use std::io::{ErrorKind, Read, Write};
use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

/// Rate where the name gives none: what most boards are set to. The reference board's ST-LINK wants
/// 3,000,000.
pub const DEFAULT_BAUD: u32 = 921_600;
/// Rates that a name may give: the slowest of POSIX, and more than the fastest adapter makes.
pub const BAUDS: RangeInclusive<u32> = 50..=20_000_000;

/// Ten bits a byte; a third of the bytes is left to replies, acknowledgements and repetitions.
const fn trace_rate(baud: u32) -> u32 {
    baud / 10 / 3 * 2
}

/// A serial port as a link.
pub struct SerialLink {
    name: String,
    port: Box<dyn SerialPort>,
    baud: u32,
    since: Instant,
}

/// Whether the port is taken: by its lock, or as the system says (`EBUSY`; Windows: access denied).
fn is_in_use(error: &serialport::Error) -> bool {
    let text = error.to_string().to_lowercase();
    ["exclusive lock", "busy", "access is denied"].iter().any(|part| text.contains(part))
}

/// Why a port does not open, and what to do about it.
fn why_closed(path: &str, error: &serialport::Error) -> String {
    if is_other(path, error) {
        return format!("{path} is no serial port{}", what_there_is());
    }
    if is_in_use(error) {
        return "another program, or another card of this one, uses it".to_owned();
    }
    if error.kind() == serialport::ErrorKind::Io(ErrorKind::PermissionDenied) {
        return format!("{error}; on Linux the group that owns the port, often dialout, may open it");
    }
    format!("{error}{}", what_there_is())
}

/// Whether this computer has something else of that name: a file, a folder, a pipe; or a device
/// without a rate, of which the system says that it is no typewriter (`ENOTTY`).
fn is_other(path: &str, error: &serialport::Error) -> bool {
    let text = error.to_string().to_lowercase();
    let has_no_rate = ["typewriter", "inappropriate ioctl"].iter().any(|part| text.contains(part));
    has_no_rate || std::fs::metadata(path).is_ok_and(|found| found.is_file() || found.is_dir())
}

/// Ports that could be meant.
fn what_there_is() -> String {
    let Ok(ports) = serialport::available_ports() else { return String::new() };
    let (usb, others): (Vec<_>, Vec<_>) =
        ports.into_iter().partition(|port| matches!(port.port_type, SerialPortType::UsbPort(_)));
    let found = if usb.is_empty() { others } else { usb };
    let names: Vec<String> = found.into_iter().take(NAMED_PORTS).map(|port| port.port_name).collect();
    match names.is_empty() {
        true => "; this computer has no serial port now: is the board plugged in?".to_owned(),
        false => format!("; ports of this computer: {}", names.join(", ")),
    }
}

/// What a board's own USB says of itself (docs/board-h743.md, "USB").
const PRODUCT: &str = "Beamtick";
const IDENTITY: (u16, u16) = (0x1209, 0x0001);

/// Ports that a message names at most.
const NAMED_PORTS: usize = 8;

/// How long a port may take to accept what is sent: a full window at 9600 baud.
const SEND_TIMEOUT: Duration = Duration::from_secs(10);

/// Path and rate of `PATH[:BAUD]`, or what is wrong with the rate. A path of Linux may hold a colon
/// itself. So what follows the last one is part of the path where it is no number and no port has
/// the name before it.
pub(crate) fn parts(port: &str) -> std::result::Result<(&str, u32), String> {
    let Some((path, rate)) = port.rsplit_once(':') else { return Ok((port, DEFAULT_BAUD)) };
    match rate.parse::<u32>() {
        Ok(baud) if BAUDS.contains(&baud) => Ok((path, baud)),
        _ if exists(port) => Ok((port, DEFAULT_BAUD)),
        _ if rate.bytes().all(|byte| byte.is_ascii_digit()) || exists(path) => Err(format!(
            "BAUD, the rate of serial:PATH[:BAUD], is \"{rate}\"; it is {} to {}, and {DEFAULT_BAUD} where it is left out with its \
             colon",
            BAUDS.start(),
            BAUDS.end()
        )),
        _ => Ok((port, DEFAULT_BAUD)),
    }
}

/// Whether this computer has a port, or a file, of this name.
fn exists(path: &str) -> bool {
    let is_listed = || serialport::available_ports().is_ok_and(|all| all.iter().any(|found| found.port_name == path));
    std::path::Path::new(path).exists() || is_listed()
}

/// Whether this computer has no such port: neither a file nor a name of a port.
pub(crate) fn is_missing(port: &str) -> bool {
    parts(port).is_ok_and(|(path, _)| !exists(path))
}

impl SerialLink {
    /// Opens `PATH[:BAUD]`, 8 data bits, no parity.
    pub fn open(port: &str) -> Result<Self> {
        let name = format!("serial:{port}");
        let (path, baud) = parts(port).map_err(|why| Error::cannot_open(&name, why))?;
        let opened = serialport::new(path, baud).timeout(Duration::from_millis(1)).open();
        let port = opened.map_err(|e| Error::cannot_open(&name, why_closed(path, &e)))?;
        Ok(SerialLink { name, port, baud, since: Instant::now() })
    }
}

impl Link for SerialLink {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let failed = |e: &dyn std::fmt::Display, name: &str| {
            Error::new(error::LINK_SEND, format!("{name}: sending failed: {e}"))
        };
        // The time-out of the last receive may be shorter than a slow port takes for a full window.
        self.port.set_timeout(SEND_TIMEOUT).map_err(|e| failed(&e, &self.name))?;
        self.port.write_all(bytes).map_err(|e| failed(&e, &self.name))
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> Result<usize> {
        let failed = |e: &dyn std::fmt::Display, name: &str| {
            Error::new(error::LINK_RECEIVE, format!("{name}: receiving failed: {e}"))
        };
        self.port.set_timeout(wait.max(Duration::from_millis(1))).map_err(|e| failed(&e, &self.name))?;
        match self.port.read(buf) {
            Ok(0) => Err(Error::new(error::LINK_CLOSED, format!("{}: the port is gone", self.name))),
            Ok(n) => Ok(n),
            Err(e) if matches!(e.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
            Err(e) => Err(failed(&e, &self.name)),
        }
    }

    fn trace_rate(&self) -> u32 {
        trace_rate(self.baud)
    }

    fn is_boards_usb(&mut self) -> bool {
        let Some(path) = self.port.name() else { return false };
        // A name of the system may be a link to the port's.
        let path = std::fs::canonicalize(&path).map_or(path, |path| path.to_string_lossy().into_owned());
        let is_it = |port: &serialport::SerialPortInfo| {
            let SerialPortType::UsbPort(usb) = &port.port_type else { return false };
            // The identity of firmware/src/usb.rs: it stays where a system gives no product's name.
            port.port_name == path && (usb.product.as_deref() == Some(PRODUCT) || (usb.vid, usb.pid) == IDENTITY)
        };
        serialport::available_ports().is_ok_and(|ports| ports.iter().any(is_it))
    }

    fn now(&mut self) -> u64 {
        u64::try_from(self.since.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn a_port_in_use_says_so() {
        let (_near, far) = serialport::TTYPort::pair().unwrap();
        let name = far.name().unwrap();
        drop(far);
        let first = SerialLink::open(&name).unwrap();
        let error = SerialLink::open(&name).map(|_| ()).unwrap_err();
        assert_eq!((error.code, error.reason.contains("uses it")), (error::CANNOT_OPEN, true), "{error}");
        assert!(!is_missing(&name) && !is_missing(&format!("{name}:9600")));
        drop(first);
        SerialLink::open(&name).unwrap();
    }

    #[test]
    fn a_port_that_is_not_there_says_which_are() {
        let error = SerialLink::open("/dev/no-such-port").map(|_| ()).unwrap_err();
        assert_eq!((error.code, is_missing("/dev/no-such-port:3000000")), (error::CANNOT_OPEN, true));
        let helps = ["; ports of this computer: ", "; this computer has no serial port now"];
        assert!(helps.iter().any(|text| error.reason.contains(text)), "{error}");
    }

    /// The system's own words ("Not a typewriter") say nothing to somebody who mistyped a name.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_is_no_serial_port_is_said_to_be_none() {
        let file = std::env::current_exe().unwrap();
        let pipe = std::env::temp_dir().join(format!("beamtick-no-port-{}", std::process::id()));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [file.to_str().unwrap(), pipe.to_str().unwrap(), "/dev", "/dev/null"] {
            let error = SerialLink::open(&format!("{path}:3000000")).map(|_| ()).unwrap_err();
            let begin = format!("cannot open serial:{path}:3000000: {path} is no serial port; ");
            assert!(error.code == error::CANNOT_OPEN && error.reason.starts_with(&begin), "{error}");
            let helps = ["; ports of this computer: ", "; this computer has no serial port now"];
            assert!(helps.iter().any(|text| error.reason.contains(text)), "{error}");
        }
        std::fs::remove_file(pipe).unwrap();
    }

    /// `/dev/null` stands for a port that is there.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_rate_that_is_none_names_its_limits() {
        for rate in ["abc", "", "0", "49", "20000001", "99999999999", "-1", "3e6"] {
            let error = SerialLink::open(&format!("/dev/null:{rate}")).map(|_| ()).unwrap_err();
            assert_eq!(error.code, error::CANNOT_OPEN);
            let why =
                format!("BAUD, the rate of serial:PATH[:BAUD], is \"{rate}\"; it is 50 to 20000000, and 921600 where");
            assert!(error.reason.contains(&why), "{error}");
            assert!(!is_missing(&format!("/dev/null:{rate}")));
        }
        assert!(parts("/dev/no-such-port:0").is_err());
        // Paths with a colon, and names that Windows has.
        for (port, path, baud) in [
            ("/dev/null", "/dev/null", 921_600),
            ("/dev/null:50", "/dev/null", 50),
            (
                "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.2",
                "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.2",
                921_600,
            ),
            (
                "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.2:3000000",
                "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.2",
                3_000_000,
            ),
            ("COM5:20000000", "COM5", 20_000_000),
        ] {
            assert_eq!(parts(port), Ok((path, baud)));
        }
    }

    #[test]
    fn a_trace_leaves_room_for_calls() {
        assert_eq!(trace_rate(DEFAULT_BAUD), 61_440);
        assert_eq!(trace_rate(115_200), 7_680);
    }
}
