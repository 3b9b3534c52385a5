//! A file that a thread of its own writes.
//!
//! In: bytes. Out: the file. Who makes the bytes serves the link meanwhile, which a disk that is
//! busy must not hold up: after half a second of silence a controller takes its client for lost.
//! What the disk has not taken yet is kept in memory. Fails with the first error of the file, at
//! the latest in [`Spool::flush`].
use std::fs::File;
use std::io::{self, Write};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;

/// See the module text. Its first flush is its end.
pub struct Spool {
    bytes: Option<Sender<Vec<u8>>>,
    writer: Option<JoinHandle<io::Result<()>>>,
}

impl Spool {
    /// Writes to `file`.
    pub fn new(mut file: File) -> Self {
        let (bytes, portions) = channel::<Vec<u8>>();
        let writer = std::thread::spawn(move || portions.iter().try_for_each(|portion| file.write_all(&portion)));
        Spool { bytes: Some(bytes), writer: Some(writer) }
    }
}

impl Write for Spool {
    fn write(&mut self, portion: &[u8]) -> io::Result<usize> {
        match &self.bytes {
            Some(bytes) if bytes.send(portion.to_vec()).is_ok() => Ok(portion.len()),
            // The thread ends early only with an error, which the flush reports.
            _ => self.flush().and(Err(io::Error::other("it is closed already"))),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.bytes = None;
        let ended = self.writer.take().map(JoinHandle::join);
        ended.unwrap_or(Ok(Ok(()))).unwrap_or_else(|_| Err(io::Error::other("its writer panicked")))
    }
}

impl Drop for Spool {
    fn drop(&mut self) {
        // Who asks for errors has flushed.
        let _ = self.flush();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::io::Read;
    use std::os::fd::OwnedFd;
    use std::time::Duration;

    #[test]
    fn a_busy_disk_holds_nobody_up() {
        // A pipe without a reader takes 64 KiB.
        let (mut reader, writer) = io::pipe().unwrap();
        let mut spool = Spool::new(File::from(OwnedFd::from(writer)));
        let lines: Vec<u8> = (0..100_000u32).flat_map(|n| format!("{n}\n").into_bytes()).collect();
        for portion in lines.chunks(1000) {
            spool.write_all(portion).unwrap();
        }
        let slow = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(20));
            let mut all = Vec::new();
            reader.read_to_end(&mut all).unwrap();
            all
        });
        spool.flush().unwrap();
        assert!(slow.join().unwrap() == lines);
        assert!(spool.flush().is_ok() && spool.write(b"more").is_err());
    }

    #[test]
    fn errors_are_reported() {
        let (reader, writer) = io::pipe().unwrap();
        drop(reader);
        let mut spool = Spool::new(File::from(OwnedFd::from(writer)));
        let _ = spool.write(b"for nobody");
        assert_eq!(spool.flush().unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }
}
