//! The text of a job as an import writes it: kept, and compiled by a thread as it comes.
//!
//! In: bytes in any pieces. Out: the text, and what it compiles to. Owns the text, and some blocks
//! on their way to the thread. Fails where the text cannot be kept.
use crate::parts::{self, Broken, Compiled};
use crate::script::{self, BLOCK_BYTES, Script};
use job::Folder;
use std::io::{self, BufRead, Read, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use tempfile::SpooledTempFile;

/// Blocks on their way.
const BLOCKS_AHEAD: usize = 8;

/// See the module text.
pub struct ImportedText {
    text: SpooledTempFile,
    block: Vec<u8>,
    blocks: SyncSender<Vec<u8>>,
    compiler: JoinHandle<Result<Compiled, Broken>>,
}

impl ImportedText {
    /// Of a job that names files beside it in this folder.
    pub fn new(folder: Folder) -> io::Result<Self> {
        let (blocks, taken) = sync_channel(BLOCKS_AHEAD);
        let compile = move || parts::compile(Blocks { taken, block: Vec::new(), at: 0 }, &folder);
        let compiler = thread::Builder::new().name("compile".to_owned()).spawn(compile)?;
        Ok(Self { text: tempfile::spooled_tempfile(script::IN_MEMORY_BYTES), block: Vec::new(), blocks, compiler })
    }

    fn hand_over(&mut self) -> io::Result<()> {
        self.text.write_all(&self.block)?;
        // A compiler that has found a fault takes nothing more.
        let _ = self.blocks.send(std::mem::take(&mut self.block));
        Ok(())
    }

    /// The text is whole.
    pub fn finish(mut self) -> io::Result<(Script, Result<Compiled, Broken>)> {
        self.hand_over()?;
        drop(self.blocks);
        let compiled = self.compiler.join().map_err(|_| io::Error::other("its compiler stopped"))?;
        Ok((Script::spooled(self.text)?, compiled))
    }
}

impl Write for ImportedText {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.block.extend_from_slice(bytes);
        if self.block.len() >= BLOCK_BYTES {
            self.hand_over()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// What the thread reads.
struct Blocks {
    taken: Receiver<Vec<u8>>,
    block: Vec<u8>,
    at: usize,
}

impl Read for Blocks {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(out)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Blocks {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        while self.at == self.block.len() {
            let Ok(block) = self.taken.recv() else { return Ok(&[]) };
            (self.block, self.at) = (block, 0);
        }
        Ok(&self.block[self.at..])
    }

    fn consume(&mut self, count: usize) {
        self.at += count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// What the thread compiles is what is kept, whatever pieces it is written in.
    #[test]
    fn the_compiled_job_is_that_of_the_text() {
        let line = "GT_LnXY(1, 5, -7, 50, 2); // ö\n";
        let whole = format!("{}\n{}GT_BufLaserOn(1, 0, 1);\n", strokes::MARK, line.repeat(60_000));
        assert!(whole.len() > script::IN_MEMORY_BYTES);
        for piece in [1, 7, BLOCK_BYTES - 1, whole.len()] {
            let mut text = ImportedText::new(Folder(PathBuf::new())).unwrap();
            whole.as_bytes().chunks(piece).for_each(|piece| text.write_all(piece).unwrap());
            let (script, compiled) = text.finish().unwrap();
            let (mut kept, Ok(found)) = (String::new(), compiled) else { panic!("it compiles") };
            script.reader().read_to_string(&mut kept).unwrap();
            assert!(kept == whole, "pieces of {piece} bytes");
            assert_eq!((found.totals.steps, found.job.lasers), (60_001, 2));
        }
    }

    /// A fault early in a long text holds nobody up.
    #[test]
    fn a_fault_ends_the_compiler_and_not_the_text() {
        let mut text = ImportedText::new(Folder(PathBuf::new())).unwrap();
        text.write_all(b"GT_LnXY(1, 5;\n").unwrap();
        for _ in 0..4 * BLOCKS_AHEAD {
            text.write_all(&[b'\n'; BLOCK_BYTES]).unwrap();
        }
        let (script, compiled) = text.finish().unwrap();
        assert!(matches!(compiled, Err(Broken::Job(_))));
        let mut kept = Vec::new();
        script.reader().read_to_end(&mut kept).unwrap();
        assert_eq!(kept.len(), 14 + 4 * BLOCKS_AHEAD * BLOCK_BYTES);
    }
}
