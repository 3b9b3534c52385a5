//! Starts the image in QEMU and links to its two serial ports.
//!
//! In: the path of the image. Out: a link over UART0 and the trace stream of UART1. It owns the
//! QEMU process and ends it when dropped, and where `setpriv` (util-linux) is at hand, when its own
//! process ends. Fails with −6 and names what is missing.
use crate::error::{self, Error, Result};
use crate::link::Link;
use crate::tcp::read_within;
use std::fs::File;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// How long QEMU may take to connect to its serial ports.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);

/// What to start.
#[derive(Debug, Clone)]
pub struct Machine {
    /// The image, an ELF file for `mps2-an500`.
    pub image: PathBuf,
    /// The program.
    pub program: PathBuf,
    /// 2^shift ns of emulated time pass with each instruction.
    pub icount_shift: u8,
    /// Destination of the image's log; without it, the log is dropped.
    pub log: Option<PathBuf>,
    /// Arguments added to the command line.
    pub extra: Vec<String>,
}

impl Machine {
    /// The image in Debian's `qemu-system-arm`, 2 ns an instruction.
    pub fn new(image: impl Into<PathBuf>) -> Self {
        Machine {
            image: image.into(),
            program: PathBuf::from("qemu-system-arm"),
            icount_shift: 1,
            log: None,
            extra: Vec::new(),
        }
    }
}

/// Where the image lies in the build folder.
const IMAGE: &str = "target/thumbv7em-none-eabihf/image/beamtick-mps2";
/// Where it lies in the archive of a release, from the folder of the program.
const RELEASED: &str = "../images/beamtick-mps2";

/// The image to run: the one given, else the environment's `BEAMTICK_IMAGE`, else the one of the
/// build folder here or in a folder above, else the one of the program's release.
///
/// # Errors
/// −6 if there is none.
pub fn image(given: Option<PathBuf>) -> Result<PathBuf> {
    if let Some(image) = given.or_else(|| std::env::var_os("BEAMTICK_IMAGE").map(PathBuf::from)) {
        return Ok(image);
    }
    let here = std::env::current_dir().unwrap_or_default();
    let program = std::env::current_exe().ok();
    let released = program.and_then(|program| Some(program.parent()?.join(RELEASED)));
    let built = here.ancestors().map(|folder| folder.join(IMAGE));
    built.chain(released).find(|image| image.is_file()).ok_or_else(|| {
        Error::new(
            error::CANNOT_OPEN,
            format!(
                "there is no image for QEMU: {IMAGE} is not here nor in a folder above.\n\
                 `cargo demo` installs what is missing and builds it; --image FILE or BEAMTICK_IMAGE names another."
            ),
        )
    })
}

/// Times that others wait for an answer: a machine that is busy with other things takes seconds to
/// load QEMU.
const TIME_OUT_FACTOR: u32 = 5;

/// More trace than this is not held: the reader waits, and with it the emulated UART.
const TRACE_HELD_BYTES: usize = 8 << 20;

/// How long trace bytes gather before they are read.
const GATHER_TIME: Duration = Duration::from_millis(1);

/// A running QEMU as a link.
pub struct QemuLink {
    name: String,
    child: Child,
    _parent: Sender<()>,
    stream: TcpStream,
    wait: Option<Duration>,
    /// Trace bytes that came and were not taken yet.
    inbox: Arc<Mutex<Vec<u8>>>,
    /// The sending half of the trace's UART.
    inputs: TcpStream,
    since: Instant,
}

/// The emulated board's inputs, for tests: bytes on the trace's UART set the levels.
pub struct Switchboard(TcpStream);

impl Switchboard {
    /// Makes the interlock input active, or ends that; the board sees it with one of its next
    /// ticks.
    pub fn interlock(&mut self, active: bool) -> Result<()> {
        let byte = if active { b"1" } else { b"0" };
        self.0.write_all(byte).map_err(|e| Error::new(error::LINK_SEND, format!("the board's inputs: {e}")))
    }
}

impl QemuLink {
    /// Starts the machine and waits until its serial ports are connected.
    pub fn start(machine: &Machine) -> Result<Self> {
        let name = format!("qemu:{}", machine.image.display());
        if !machine.image.is_file() {
            return Err(Error::cannot_open(&name, "there is no such image; `cargo xtask image` builds it"));
        }
        let failed = |e: std::io::Error| Error::cannot_open(&name, e);
        let link = TcpListener::bind("127.0.0.1:0").map_err(failed)?;
        let trace = TcpListener::bind("127.0.0.1:0").map_err(failed)?;
        let (link_port, trace_port) =
            (link.local_addr().map_err(failed)?.port(), trace.local_addr().map_err(failed)?.port());
        let log = match &machine.log {
            Some(path) => Stdio::from(
                File::create(path)
                    .map_err(|e| Error::cannot_open(&name, format!("log file {}: {e}", path.display())))?,
            ),
            None => Stdio::null(),
        };
        let errors = std::env::temp_dir().join(format!("beamtick-qemu-{}-{link_port}.txt", std::process::id()));
        let complaints = File::create(&errors).map(Stdio::from).unwrap_or_else(|_| Stdio::null());
        let mut command = command(&machine.program);
        command
            .args(["-M", "mps2-an500", "-nographic", "-monitor", "none"])
            .args(["-icount", &format!("shift={}", machine.icount_shift)])
            .args(["-chardev", &format!("socket,id=link,host=127.0.0.1,port={link_port},nodelay=on,mux=on")])
            .args(["-serial", "chardev:link"])
            // A multiplexed port buffers 32 bytes, so that not every byte waits for one cycle of
            // QEMU's main loop and the guest in turn. Its escape character is set beyond any byte.
            .args(["-echr", "0x100"])
            // Nobody waits for a single byte of the trace.
            .args(["-chardev", &format!("socket,id=trace,host=127.0.0.1,port={trace_port},nodelay=off")])
            .args(["-serial", "chardev:trace"])
            .args(["-chardev", "stdio,id=log,signal=off"])
            .args(["-semihosting-config", "enable=on,target=native,chardev=log"])
            .args(&machine.extra)
            .arg("-kernel")
            .arg(&machine.image)
            .stdin(Stdio::null())
            .stdout(log)
            .stderr(complaints);
        let (mut child, parent) = spawn(command).map_err(|e| {
            Error::cannot_open(
                &name,
                format!(
                    "{} does not start ({e}); on Debian and Ubuntu it is in the package qemu-system-arm",
                    machine.program.display()
                ),
            )
        })?;
        let connected = accept(&link, &mut child).and_then(|l| accept(&trace, &mut child).map(|t| (l, t)));
        let said = std::fs::read_to_string(&errors).unwrap_or_default();
        let _ = std::fs::remove_file(&errors);
        let (stream, trace) = connected.map_err(|e| {
            let _ = child.kill();
            let _ = child.wait();
            Error::cannot_open(&name, format!("{e}{}{}", if said.is_empty() { "" } else { ": " }, said.trim()))
        })?;
        let _ = stream.set_nodelay(true);
        let inputs = trace.try_clone().map_err(failed)?;
        let inbox = Arc::new(Mutex::new(Vec::new()));
        let theirs = Arc::downgrade(&inbox);
        std::thread::spawn(move || collect(trace, &theirs));
        Ok(QemuLink { name, child, _parent: parent, stream, wait: None, inbox, inputs, since: Instant::now() })
    }

    /// The board's inputs; they can be set while a client uses the link.
    pub fn switchboard(&self) -> Result<Switchboard> {
        self.inputs.try_clone().map(Switchboard).map_err(|e| Error::cannot_open(&self.name, e))
    }

    /// Process id of the QEMU that this link owns.
    pub fn process(&self) -> u32 {
        self.child.id()
    }
}

/// A command that runs `program` and, on Linux, ends it when this process ends for any reason: a
/// client that is killed leaves no QEMU running.
fn command(program: &Path) -> Command {
    let found = |name: &Path| {
        let path = std::env::var_os("PATH").unwrap_or_default();
        // A name with a folder is looked for there only.
        std::env::split_paths(&path).any(|folder| folder.join(name).is_file())
    };
    // Without the program it is left to the system to say so.
    let bound = cfg!(target_os = "linux") && found(Path::new("setpriv")) && found(program);
    let mut command = Command::new(if bound { Path::new("setpriv") } else { program });
    if bound {
        command.args(["--pdeathsig", "KILL", "--"]).arg(program);
    }
    // A Ctrl-C is for the client alone, which stops the machine first.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}

/// Starts it from a thread that lasts as long as what is given back with it: the system ends a
/// process so started with the thread that started it, and callers' threads come and go.
fn spawn(mut command: Command) -> std::io::Result<(Child, Sender<()>)> {
    let (parent, end) = channel();
    let (out, child) = channel();
    std::thread::spawn(move || {
        let _ = out.send(command.spawn());
        let _ = end.recv();
    });
    Ok((child.recv().map_err(std::io::Error::other)??, parent))
}

/// Waits for one connection from QEMU, or for its end.
fn accept(listener: &TcpListener, child: &mut Child) -> std::io::Result<TcpStream> {
    listener.set_nonblocking(true)?;
    let start = Instant::now();
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(false)?;
                return Ok(stream);
            }
            Err(e) if e.kind() == std::io::ErrorKind::WouldBlock => {}
            Err(e) => return Err(e),
        }
        if let Some(status) = child.try_wait()? {
            return Err(std::io::Error::other(format!("QEMU ended ({status})")));
        }
        if start.elapsed() > CONNECT_TIMEOUT {
            return Err(std::io::Error::other(format!("QEMU did not connect within {} s", CONNECT_TIMEOUT.as_secs())));
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Takes trace bytes off the socket until it closes or its reader is gone, so that the emulated
/// UART need not wait.
fn collect(mut stream: TcpStream, inbox: &Weak<Mutex<Vec<u8>>>) {
    let mut buf = [0; 16384];
    while let Ok(n @ 1..) = stream.read(&mut buf) {
        // QEMU sends byte by byte: who reads at once is woken for each of them.
        if n < buf.len() {
            std::thread::sleep(GATHER_TIME);
        }
        loop {
            let Some(inbox) = inbox.upgrade() else { return };
            let mut bytes = inbox.lock().unwrap_or_else(PoisonError::into_inner);
            if bytes.len() < TRACE_HELD_BYTES {
                bytes.extend_from_slice(&buf[..n]);
                break;
            }
            drop(bytes);
            drop(inbox);
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Link for QemuLink {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.stream
            .write_all(bytes)
            .map_err(|e| Error::new(error::LINK_SEND, format!("{}: sending failed: {e}", self.name)))
    }

    fn receive(&mut self, buf: &mut [u8], wait: Duration) -> Result<usize> {
        read_within(&mut self.stream, &mut self.wait, buf, wait, &self.name)
    }

    fn now(&mut self) -> u64 {
        u64::try_from(self.since.elapsed().as_nanos()).unwrap_or(u64::MAX)
    }

    fn patience(&self) -> u32 {
        TIME_OUT_FACTOR
    }

    fn has_trace(&self) -> bool {
        true
    }

    fn take_trace(&mut self, out: &mut Vec<u8>) -> Result<()> {
        out.append(&mut self.inbox.lock().unwrap_or_else(PoisonError::into_inner));
        Ok(())
    }
}

impl Drop for QemuLink {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
