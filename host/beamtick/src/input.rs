//! Files that people name: read whole.
//!
//! In: a path. Out: its bytes. Fails with what the system says, and for a device, which may never
//! end.
use std::io;
use std::path::Path;

/// The bytes of a file or a pipe.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let kind = std::fs::metadata(path)?.file_type();
    #[cfg(unix)]
    let is_pipe = std::os::unix::fs::FileTypeExt::is_fifo(&kind);
    #[cfg(not(unix))]
    let is_pipe = false;
    if !(kind.is_file() || kind.is_dir() || is_pipe) {
        return Err(io::Error::other("it is a device, not a file"));
    }
    std::fs::read(path)
}
