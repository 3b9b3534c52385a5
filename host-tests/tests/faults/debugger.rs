//! A debugger's link to the emulator: how the tests provoke faults in the image that is released,
//! which has no way of its own to do so.
//!
//! In: addresses by the symbols of the image. Out: memory read and written, registers set, stops.
//! Owns the socket of QEMU's GDB server (GDB remote serial protocol; `Z0` is a breakpoint, `Z2`
//! watches writes). Fails by panicking.
use object::{Object, ObjectSymbol};
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// How long the emulator may take to answer or to stop.
const WAIT_MAX: Duration = Duration::from_secs(60);

/// Addresses and sizes of what an image is made of.
pub struct Symbols(Vec<(String, u32, u32)>);

impl Symbols {
    pub fn of(image: &Path) -> Symbols {
        let bytes = std::fs::read(image).unwrap();
        let file = object::File::parse(&*bytes).unwrap();
        let symbols = file.symbols().filter_map(|symbol| {
            let name = symbol.name().ok()?.to_owned();
            Some((name, symbol.address() as u32, symbol.size() as u32))
        });
        Symbols(symbols.collect())
    }

    /// Where the one symbol lies whose name holds all of these, without the bit that says Thumb;
    /// and its size.
    pub fn find(&self, parts: &[&str]) -> (u32, u32) {
        let all: Vec<_> = self.0.iter().filter(|(name, ..)| parts.iter().all(|part| name.contains(part))).collect();
        assert_eq!(all.len(), 1, "{parts:?}: {all:?}");
        (all[0].1 & !1, all[0].2)
    }

    /// Where a symbol of exactly this name lies.
    pub fn named(&self, name: &str) -> u32 {
        self.0.iter().find(|symbol| symbol.0 == name).unwrap_or_else(|| panic!("no {name}")).1 & !1
    }
}

/// A socket that QEMU will listen on.
pub struct Socket(PathBuf);

impl Socket {
    pub fn new() -> Socket {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        Socket(std::env::temp_dir().join(format!("beamtick-gdb-{}-{count}", std::process::id())))
    }

    /// The command for QEMU.
    pub fn arguments(&self) -> Vec<String> {
        let chardev = format!("socket,id=debugger,path={},server=on,wait=off", self.0.display());
        vec!["-chardev".into(), chardev, "-gdb".into(), "chardev:debugger".into()]
    }

    /// Attaches; the emulator stops.
    pub fn attach(&self) -> Debugger {
        let begin = Instant::now();
        let stream = loop {
            match UnixStream::connect(&self.0) {
                Ok(stream) => break stream,
                Err(e) => assert!(begin.elapsed() < WAIT_MAX, "QEMU's debugger port: {e}"),
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        stream.set_read_timeout(Some(WAIT_MAX)).unwrap();
        let mut debugger = Debugger { stream, held: Vec::new() };
        // The stop by attaching may be reported by itself, before the answers.
        debugger.send("?");
        debugger.send("qC");
        while !debugger.receive().starts_with("QC") {}
        // Who has not read which registers there are gets none.
        debugger.ask("qXfer:features:read:target.xml:0,ffb");
        debugger
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// An emulator that stands still between the calls of this.
pub struct Debugger {
    stream: UnixStream,
    held: Vec<u8>,
}

/// Registers by the numbers of the protocol.
pub const SP: u8 = 13;
pub const PC: u8 = 15;
const XPSR: u8 = 25;

impl Debugger {
    pub fn read(&mut self, address: u32, length: u32) -> Vec<u8> {
        let answer = self.ask(&format!("m{address:x},{length:x}"));
        let bytes: Vec<u8> =
            (0..answer.len() / 2).filter_map(|i| u8::from_str_radix(answer.get(2 * i..2 * i + 2)?, 16).ok()).collect();
        assert_eq!(bytes.len(), length as usize, "{answer}");
        bytes
    }

    pub fn write(&mut self, address: u32, bytes: &[u8]) {
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        self.order(&format!("M{address:x},{:x}:{hex}", bytes.len()));
    }

    pub fn write_halfwords(&mut self, address: u32, halves: &[u16]) {
        self.write(address, &halves.iter().flat_map(|half| half.to_le_bytes()).collect::<Vec<_>>());
    }

    pub fn set(&mut self, register: u8, value: u32) {
        self.order(&format!("P{register:x}={:08x}", value.swap_bytes()));
    }

    /// Whether an exception is being served.
    pub fn in_handler(&mut self) -> bool {
        let answer = self.ask(&format!("p{XPSR:x}"));
        u32::from_str_radix(&answer, 16).unwrap().swap_bytes() & 0x1ff != 0
    }

    /// Goes on until this instruction is reached.
    pub fn run_to(&mut self, address: u32) {
        self.order(&format!("Z0,{address:x},2"));
        self.go();
        self.order(&format!("z0,{address:x},2"));
    }

    /// Goes on until this word is written.
    pub fn run_until_written(&mut self, address: u32) {
        self.order(&format!("Z2,{address:x},4"));
        self.go();
        self.order(&format!("z2,{address:x},4"));
    }

    /// Goes on until it stops by itself.
    fn go(&mut self) {
        self.send("c");
        let stopped = self.receive();
        assert!(stopped.starts_with('T') || stopped.starts_with('S'), "{stopped}");
    }

    /// Resets the board from outside, and leaves it standing.
    pub fn reset(&mut self) {
        let command: String = b"system_reset".iter().map(|byte| format!("{byte:02x}")).collect();
        let mut answer = self.ask(&format!("qRcmd,{command}"));
        while answer.starts_with('O') && answer != "OK" {
            answer = self.receive();
        }
        assert_eq!(answer, "OK");
    }

    /// Lets it run alone.
    pub fn detach(mut self) {
        self.order("D");
    }

    fn order(&mut self, packet: &str) {
        assert_eq!(self.ask(packet), "OK", "{packet}");
    }

    fn ask(&mut self, packet: &str) -> String {
        self.send(packet);
        self.receive()
    }

    fn send(&mut self, packet: &str) {
        let sum = packet.bytes().fold(0u8, u8::wrapping_add);
        self.stream.write_all(format!("${packet}#{sum:02x}").as_bytes()).unwrap();
    }

    /// The next packet; acknowledgements are passed over.
    fn receive(&mut self) -> String {
        loop {
            if let Some(start) = self.held.iter().position(|&byte| byte == b'$')
                && let Some(length) = self.held[start..].iter().position(|&byte| byte == b'#')
                && self.held.len() >= start + length + 3
            {
                let text = String::from_utf8_lossy(&self.held[start + 1..start + length]).into_owned();
                self.held.drain(..start + length + 3);
                self.stream.write_all(b"+").unwrap();
                return text;
            }
            let mut buffer = [0; 1024];
            let count = self.stream.read(&mut buffer).expect("the emulator answers its debugger");
            assert!(count > 0, "the emulator has ended");
            self.held.extend_from_slice(&buffer[..count]);
        }
    }
}
