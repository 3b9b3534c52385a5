//! The trace of a virtual controller to CSV and VCD, from Open to Close.
//!
//! In: the stream's bytes as they arrive, and at the end what the program used. Out: files. While
//! they grow they hold every axis, laser and coordinate system of the profile; Close leaves out
//! what was not used. Fails: the first error ends the recording; Close reports it.

use crate::card::{CardSlot, everything};
use crate::settings::Settings;
use crate::staged::Staged;
use client::error::CANNOT_OPEN;
use client::{Client, Error, Result};
use job::Used;
use protocol::command::Trace;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use trace::{
    AxisName, CrdName, CsvWriter, Header, Item, LaserName, Plot, PlotOptions, Reader, TraceError, VcdWriter,
    narrow_csv, narrow_vcd, outputs_that_change,
};

/// Analog outputs that it shows.
const ANALOG_OUTPUTS: u8 = 8;
/// A trace's end comes within this controller time.
const TRACE_END_TIMEOUT: Duration = Duration::from_secs(1);

/// See the module text.
pub struct Recorder {
    reader: Reader,
    csv: Option<FileStream<CsvWriter<BufWriter<File>>>>,
    vcd: Option<FileStream<VcdWriter<BufWriter<File>>>>,
    /// The picture, or the page of HTML; and what is drawn there.
    plot: Option<(Staged, Option<Plot>)>,
    is_page: bool,
    /// General outputs of the controller.
    outputs: u8,
    failed: Option<TraceError>,
}

/// Files that are being written.
static IN_USE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn in_use() -> MutexGuard<'static, Vec<PathBuf>> {
    IN_USE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The files of a controller, for it alone until this is dropped.
pub struct Claim(Vec<PathBuf>);

impl Claim {
    /// −6 if one of them is being written: two controllers would overwrite each other's rows.
    pub fn of(slot: CardSlot, settings: &Settings) -> Result<Claim> {
        let mut claim = Claim(Vec::new());
        for path in [&settings.trace, &settings.vcd, &settings.plot, &settings.log].into_iter().flatten() {
            let place = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            let mut used = in_use();
            if used.contains(&place) {
                drop(used);
                let card = slot.number().map(|number| format!("_{number}")).unwrap_or_default();
                let reason = format!(
                    "{} is being written already, for another controller or as another output; each needs a file of its own \
                     (BEAMTICK_TRACE{card}, BEAMTICK_VCD{card}, BEAMTICK_PLOT{card}, BEAMTICK_LOG{card})",
                    path.display()
                );
                return Err(Error::new(CANNOT_OPEN, reason));
            }
            used.push(place.clone());
            claim.0.push(place);
        }
        Ok(claim)
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        in_use().retain(|used| !self.0.contains(used));
    }
}

/// A file that is written from front to back.
struct FileStream<W> {
    staged: Staged,
    /// Until its header.
    file: Option<File>,
    /// From then on.
    writer: Option<W>,
}

impl<W> FileStream<W> {
    fn create(path: Option<&PathBuf>) -> Result<Option<Self>> {
        let Some(path) = path else { return Ok(None) };
        let (staged, file) = Staged::stream(path)
            .map_err(|error| Error::new(CANNOT_OPEN, format!("{} cannot be written: {error}", path.display())))?;
        Ok(Some(FileStream { staged, file: Some(file), writer: None }))
    }

    fn begin(stream: &mut Option<Self>, make: impl FnOnce(BufWriter<File>) -> trace::Result<W>) -> trace::Result<()> {
        if let Some(stream) = stream
            && let Some(file) = stream.file.take()
        {
            stream.writer = Some(make(BufWriter::new(file))?);
        }
        Ok(())
    }

    fn writer(stream: &mut Option<Self>) -> Option<&mut W> {
        stream.as_mut()?.writer.as_mut()
    }

    /// What is held back is written; then the file is written `anew`, unless the trace has `failed`
    /// or goes to a device.
    fn end(
        self,
        failed: bool,
        finish: impl FnOnce(W) -> trace::Result<()>,
        anew: impl FnOnce(&Staged) -> trace::Result<()>,
    ) -> (Staged, trace::Result<()>) {
        let mut outcome = self.writer.map_or(Ok(()), finish);
        if outcome.is_ok() && !failed && self.staged.is_staged() {
            outcome = anew(&self.staged);
        }
        (self.staged, outcome)
    }
}

/// The names of columns and signals of what a program used; none if that is nothing.
fn names(used: &Used) -> Option<BTreeSet<String>> {
    let byte = |number: i16| u8::try_from(number).unwrap_or(0);
    let axes = used.axes.iter().map(|name| AxisName { core: byte(name.core), axis: byte(name.axis) }.to_string());
    let crds = used.crds.iter().map(|name| CrdName { core: byte(name.core), crd: byte(name.crd) }.to_string());
    let lasers = (0..8).filter(|channel| used.lasers >> channel & 1 == 1).map(|channel| LaserName(channel).to_string());
    let all: BTreeSet<String> = axes.chain(crds).chain(lasers).collect();
    (!all.is_empty()).then_some(all)
}

impl Recorder {
    /// Creates the files and begins the trace.
    pub fn start(client: &Client, settings: &Settings) -> Result<Arc<Mutex<Recorder>>> {
        let recorder = Recorder {
            reader: Reader::new(),
            csv: FileStream::create(settings.trace.as_ref())?,
            vcd: FileStream::create(settings.vcd.as_ref())?,
            plot: settings.plot.as_ref().map(|path| (Staged::picture(path), None)),
            is_page: settings.draws_page(),
            outputs: client.version().general_outputs,
            failed: None,
        };
        let shared = Arc::new(Mutex::new(recorder));
        let sink = Arc::clone(&shared);
        client.trace_to(move |bytes| sink.lock().unwrap_or_else(PoisonError::into_inner).feed(bytes));
        // A trace begins with a program: an empty one, whose script clock is then the trace's.
        let mut program = client.program();
        program.push(everything(client));
        if let Some(failed) = program.run(false, &mut client::Quiet)?.failed {
            return Err(failed.error.unwrap_or_else(|| Error::new(failed.code, "Open: the trace was refused")));
        }
        Ok(shared)
    }

    fn feed(&mut self, bytes: &[u8]) {
        if self.failed.is_some() {
            return;
        }
        let Recorder { reader, csv, vcd, plot, is_page, outputs, failed, .. } = self;
        let options = PlotOptions { page: *is_page, ..PlotOptions::default() };
        let mut picture = plot.as_mut().map(|(_, plot)| plot);
        let mut take = |item: Item| -> trace::Result<()> {
            match item {
                Item::Header(header) => {
                    if let Some(plot) = &mut picture {
                        **plot = Some(Plot::new(&header, options.clone())?);
                    }
                    begin(csv, vcd, *outputs, &header)
                }
                Item::Laser { laser, change } => {
                    if let Some(Some(plot)) = &mut picture {
                        plot.change(laser, &change);
                    }
                    if let Some(vcd) = FileStream::writer(vcd) {
                        vcd.change(laser, &change);
                    }
                    Ok(())
                }
                Item::Output(edge) => {
                    if let Some(vcd) = FileStream::writer(vcd) {
                        vcd.edge(edge);
                    }
                    Ok(())
                }
                Item::Analog(edge) => {
                    if let Some(vcd) = FileStream::writer(vcd) {
                        vcd.analog(edge);
                    }
                    Ok(())
                }
                Item::Zero { axis, by } => {
                    if let Some(vcd) = FileStream::writer(vcd) {
                        vcd.zero(axis, by);
                    }
                    Ok(())
                }
                Item::Row(row) => {
                    if let Some(Some(plot)) = &mut picture {
                        plot.row(&row);
                    }
                    if let Some(csv) = FileStream::writer(csv) {
                        csv.row(&row)?;
                    }
                    FileStream::writer(vcd).map_or(Ok(()), |vcd| vcd.row(&row))
                }
                Item::Light { .. } | Item::End { .. } => Ok(()),
            }
        };
        if let Err(error) = reader.feed(bytes, &mut take) {
            *failed = Some(error);
        }
    }
}

fn begin(
    csv: &mut Option<FileStream<CsvWriter<BufWriter<File>>>>,
    vcd: &mut Option<FileStream<VcdWriter<BufWriter<File>>>>,
    outputs: u8,
    header: &Header,
) -> trace::Result<()> {
    FileStream::begin(csv, |file| CsvWriter::new(file, header))?;
    let outputs: Vec<(u8, bool)> = (1..=outputs).map(|output| (output, false)).collect();
    let analog: Vec<u8> = (1..=ANALOG_OUTPUTS).collect();
    FileStream::begin(vcd, |file| VcdWriter::new(file, header, &outputs, &analog))
}

/// Ends the trace and closes the files; 1 if it has failed.
pub fn finish(client: &Client, recorder: &Mutex<Recorder>, used: &Used) -> Result<()> {
    client.call(Trace::default())?;
    let end = client.now() + TRACE_END_TIMEOUT;
    let over = |recorder: &Recorder| recorder.failed.is_some() || recorder.reader.ended();
    while !over(&recorder.lock().unwrap_or_else(PoisonError::into_inner)) && client.now() < end {
        client.sleep(Duration::from_millis(1))?;
    }
    let mut recorder = recorder.lock().unwrap_or_else(PoisonError::into_inner);
    let outcome = recorder.close(used);
    outcome.map_err(|error| Error::new(1, format!("Close: trace: {error}")))
}

impl Recorder {
    /// Completes the files. After an error they hold what there is, under names that say so.
    fn close(&mut self, used: &Used) -> trace::Result<()> {
        let mut outcome = self.failed.take().map_or(Ok(()), Err);
        let kept = names(used);
        let mut files = Vec::new();
        if let Some(csv) = self.csv.take() {
            let anew = |staged: &Staged| match &kept {
                Some(kept) => staged.anew(|from, to| narrow_csv(from, to, kept)),
                None => Ok(()),
            };
            let (staged, ended) = csv.end(outcome.is_err(), CsvWriter::finish, anew);
            files.push(staged);
            outcome = outcome.and(ended);
        }
        if let Some(vcd) = self.vcd.take() {
            let anew = |staged: &Staged| {
                let Some(kept) = &kept else { return Ok(()) };
                let mut kept = kept.clone();
                kept.extend(outputs_that_change(staged.reader()?)?);
                staged.anew(|from, to| narrow_vcd(from, to, &kept))
            };
            let (staged, ended) = vcd.end(outcome.is_err(), VcdWriter::finish, anew);
            files.push(staged);
            outcome = outcome.and(ended);
        }
        if let Some((staged, plot)) = self.plot.take() {
            if let Some(mut plot) = plot {
                plot.leave_out_idle();
                outcome = outcome.and(match self.is_page {
                    true => plot.save_page(staged.path(), None),
                    false => plot.save(staged.path()),
                });
            }
            files.push(staged);
        }
        let is_whole = outcome.is_ok();
        let renamed = files.into_iter().try_for_each(|file| file.end(is_whole));
        outcome.and(renamed.map_err(TraceError::from))
    }
}
