//! The trace stream to files: CSV, VCD, plots.
//!
//! In: the stream's bytes as they arrive. Out: files, and the peak velocity of each axis and path.
//! Owns the files. Fails: the first error ends the recording and is reported at its end; a gap is
//! never skipped.
use crate::Failure;
use crate::command_line::{Outputs, panels};
use crate::output::{Kept, Output};
use crate::spool::Spool;
use crate::summary::counted;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use trace::{
    AxisName, CsvWriter, Header, Item, Millimetres, Plot, PlotOptions, Reader, Row, SignalChange, TraceError,
    VcdWriter, Xy,
};

/// See the module text.
pub struct Recording {
    reader: Reader,
    sinks: Sinks,
    failed: Option<TraceError>,
}

/// Where to, of which axes, of what part.
type XyPlot = (Output, Option<(AxisName, AxisName)>, PlotOptions);

struct Sinks {
    /// The files of the CSV and the VCD, until their trace begins.
    csv: Option<File>,
    vcd: Option<File>,
    /// Their names.
    streams: Vec<Output>,
    plot: Option<(Output, PlotOptions)>,
    /// The page of HTML, and the axes of its path.
    page: Option<XyPlot>,
    xy: Option<XyPlot>,
    outputs: Vec<u8>,
    analog: Vec<u8>,
    open: Option<Open>,
}

/// A trace that has begun.
struct Open {
    header: Header,
    csv: Option<CsvWriter<BufWriter<Spool>>>,
    vcd: Option<VcdWriter<BufWriter<Spool>>>,
    plot: Option<Plot>,
    page: Option<Page>,
    xy: Option<Xy>,
    peaks: Vec<f64>,
    speeds: Vec<f64>,
    rows: u32,
}

/// What a page of HTML shows: panels, and a path where there are two axes.
pub(crate) struct Page {
    plot: Plot,
    xy: Option<Xy>,
}

impl Page {
    /// An empty one; `axes` of its path, if they are named.
    pub fn new(header: &Header, axes: Option<(AxisName, AxisName)>, options: &PlotOptions) -> trace::Result<Page> {
        let xy = (axes.is_some() || header.axes.len() > 1).then(|| across(header, axes, options)).transpose()?;
        Ok(Page { plot: Plot::new(header, PlotOptions { page: true, ..options.clone() })?, xy })
    }

    /// A laser's output changes.
    pub fn change(&mut self, laser: usize, change: &SignalChange) {
        self.plot.change(laser, change);
    }

    /// A laser's light begins or ends.
    pub fn light(&mut self, laser: usize, at: u64, on: bool) {
        if let Some(xy) = &mut self.xy {
            xy.light(laser, at, on);
        }
    }

    /// Takes a row.
    pub fn row(&mut self, row: &Row) {
        self.plot.row(row);
        if let Some(xy) = &mut self.xy {
            xy.row(row);
        }
    }

    /// Leaves out what did nothing.
    pub fn leave_out_idle(&mut self) {
        self.plot.leave_out_idle();
    }

    /// Writes it.
    pub fn save(&self, path: &Path) -> trace::Result<()> {
        self.plot.save_page(path, self.xy.as_ref())
    }
}

/// What a trace showed.
pub struct Recorded {
    /// Its header.
    pub header: Header,
    /// Greatest speed of each axis of the header, pulse/ms.
    pub peaks: Vec<f64>,
    /// Greatest path speed of each coordinate system of the header, pulse/ms.
    pub speeds: Vec<f64>,
    /// Rows.
    pub rows: u32,
}

impl Recording {
    /// Creates the files. `digital` and `analog` are the general and analog outputs that the job
    /// sets, from 1, which the VCD gets.
    ///
    /// `title` and `subtitle` are above the plot. `millimetres` are the axes of `--xy` where none
    /// are named.
    pub fn new(
        outputs: &Outputs,
        (title, subtitle): (&str, String),
        (digital, analog): (Vec<u8>, Vec<u8>),
        millimetres: Vec<Millimetres>,
    ) -> Result<Self, Failure> {
        let in_mm = match millimetres[..] {
            [x, y, ..] => Some((x.axis, y.axis)),
            _ => None,
        };
        let options = PlotOptions {
            title: title.to_owned(),
            subtitle,
            from_ms: outputs.from,
            to_ms: outputs.to,
            millimetres,
            panels: panels(&outputs.panels),
            ..PlotOptions::default()
        };
        if outputs.every > 1 && options.panels.error {
            return Err(Failure::Input(format!(
                "--panels error needs a row each tick, and --every is {}",
                outputs.every
            )));
        }
        options.check().map_err(|error| Failure::Input(error.to_string()))?;
        for path in [&outputs.plot, &outputs.xy].into_iter().flatten() {
            picture(path)?;
        }
        outputs.html.as_deref().map_or(Ok(()), page_name)?;
        let mut streams = Vec::new();
        let mut stream = |path: &Option<PathBuf>| {
            let made = path.as_ref().map(|path| Output::stream(path)).transpose()?;
            Ok::<_, Failure>(made.map(|(output, file)| {
                streams.push(output);
                file
            }))
        };
        let (csv, vcd) = (stream(&outputs.trace)?, stream(&outputs.vcd)?);
        let drawn = |path: &Option<PathBuf>| path.as_ref().map(|path| Output::picture(path)).transpose();
        let (mut plot, mut page, mut xy) = (drawn(&outputs.plot)?, drawn(&outputs.html)?, drawn(&outputs.xy)?);
        let all = streams.iter_mut().chain(&mut plot).chain(&mut page).chain(&mut xy);
        all.into_iter().try_for_each(Output::set_older_aside)?;
        let axes = outputs.xy_axes.or(in_mm);
        Ok(Recording {
            reader: Reader::new(),
            sinks: Sinks {
                csv,
                vcd,
                streams,
                plot: plot.map(|output| (output, options.clone())),
                page: page.map(|output| (output, axes, options.clone())),
                xy: xy.map(|output| (output, axes, options)),
                outputs: digital,
                analog,
                open: None,
            },
            failed: None,
        })
    }

    /// Takes bytes of the stream.
    pub fn feed(&mut self, bytes: &[u8]) {
        if self.failed.is_some() {
            return;
        }
        let Recording { reader, sinks, failed } = self;
        if let Err(error) = reader.feed(bytes, |item| sinks.take(item)) {
            *failed = Some(error);
        }
    }

    /// Nothing more is to come.
    pub fn is_over(&self) -> bool {
        self.failed.is_some() || self.reader.ended()
    }

    /// Closes the files; the pictures are drawn here. What was recorded, and what failed: files
    /// that are not whole are left as [`Recording::cut_off`] leaves them.
    pub fn finish(mut self) -> (Option<Recorded>, Option<Failure>) {
        let broken = match (self.failed.take(), &self.sinks.open) {
            (Some(error), _) => Some(error.into()),
            (None, None) => Some(Failure::Job("trace: the controller sent none".into())),
            (None, Some(open)) if !self.reader.ended() => Some(Failure::Job(format!(
                "trace: it breaks off after {}; the end did not come",
                counted(open.rows as i64, "row", "rows")
            ))),
            _ => None,
        };
        if let Some(failure) = broken {
            return (None, Some(with_kept(failure, self.cut_off())));
        }
        let written = self.sinks.write();
        let (streams, pictures, open) = self.sinks.files();
        let failure = match written {
            Ok(()) => streams.into_iter().chain(pictures).try_for_each(Output::whole).err(),
            // The rows are there; no picture has anything to show.
            Err(error @ TraceError::Window(_)) => {
                let missing = Failure::Job(format!("{error}. The job has run; only the pictures are missing"));
                let missing = with_kept(missing, pictures.into_iter().map(Output::cut_off).collect());
                streams.into_iter().try_for_each(Output::whole).err().or(Some(missing))
            }
            Err(error) => {
                let kept = streams.into_iter().chain(pictures).map(Output::cut_off).collect();
                Some(with_kept(error.into(), kept))
            }
        };
        let recorded =
            |open: Open| Recorded { header: open.header, peaks: open.peaks, speeds: open.speeds, rows: open.rows };
        (open.map(recorded), failure)
    }

    /// The job has failed: what there is is written and drawn, under names that say so. These
    /// names.
    pub fn cut_off(mut self) -> Vec<Kept> {
        // A file that cannot be written or drawn is missing; only the job's own failure is
        // reported.
        let _ = self.sinks.write();
        let (streams, pictures, _) = self.sinks.files();
        streams.into_iter().chain(pictures).map(Output::cut_off).collect()
    }
}

/// The failure, and what there is all the same.
fn with_kept(failure: Failure, kept: Vec<Kept>) -> Failure {
    let kept: String = kept.iter().map(Kept::to_string).collect();
    match failure {
        Failure::Job(text) => Failure::Job(text + &kept),
        failure => failure,
    }
}

impl Sinks {
    /// The streams and the pictures, and the trace.
    fn files(self) -> (Vec<Output>, Vec<Output>, Option<Open>) {
        let Sinks { streams, plot, page, xy, open, .. } = self;
        let pictures = plot.map(|(output, _)| output).into_iter().chain(page.map(|(output, ..)| output));
        (streams, pictures.chain(xy.map(|(output, ..)| output)).collect(), open)
    }

    /// Completes the files of the trace that has begun; the first error, after all of them.
    fn write(&mut self) -> trace::Result<()> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let csv = open.csv.take().map_or(Ok(()), |csv| csv.finish().map(drop));
        let vcd = open.vcd.take().map_or(Ok(()), |vcd| vcd.finish().map(drop));
        let plot = match (&open.plot, &self.plot) {
            (Some(plot), Some((output, _))) => plot.save(output.path()),
            _ => Ok(()),
        };
        let xy = match (&open.xy, &self.xy) {
            (Some(xy), Some((output, ..))) => xy.save(output.path()),
            _ => Ok(()),
        };
        let page = match (&open.page, &self.page) {
            (Some(page), Some((output, ..))) => page.save(output.path()),
            _ => Ok(()),
        };
        csv.and(vcd).and(plot).and(page).and(xy)
    }

    fn take(&mut self, item: Item) -> trace::Result<()> {
        match item {
            Item::Header(header) => self.begin(header),
            Item::Laser { laser, change } => {
                if let Some(open) = &mut self.open {
                    open.laser(laser, &change);
                }
                Ok(())
            }
            Item::Light { laser, at, on } => {
                let Some(open) = &mut self.open else { return Ok(()) };
                if let Some(xy) = &mut open.xy {
                    xy.light(laser, at, on);
                }
                if let Some(page) = &mut open.page {
                    page.light(laser, at, on);
                }
                Ok(())
            }
            Item::Output(edge) => {
                if let Some(vcd) = self.open.as_mut().and_then(|open| open.vcd.as_mut()) {
                    vcd.edge(edge);
                }
                Ok(())
            }
            Item::Analog(edge) => {
                if let Some(vcd) = self.open.as_mut().and_then(|open| open.vcd.as_mut()) {
                    vcd.analog(edge);
                }
                Ok(())
            }
            Item::Zero { axis, by } => {
                if let Some(vcd) = self.open.as_mut().and_then(|open| open.vcd.as_mut()) {
                    vcd.zero(axis, by);
                }
                Ok(())
            }
            Item::Row(row) => self.open.as_mut().map_or(Ok(()), |open| open.row(&row)),
            Item::End { .. } => Ok(()),
        }
    }

    fn begin(&mut self, header: Header) -> trace::Result<()> {
        let levels: Vec<(u8, bool)> = self.outputs.iter().map(|output| (*output, false)).collect();
        let csv = self.csv.take().map(|file| CsvWriter::new(BufWriter::new(Spool::new(file)), &header)).transpose()?;
        let vcd = self
            .vcd
            .take()
            .map(|file| VcdWriter::new(BufWriter::new(Spool::new(file)), &header, &levels, &self.analog))
            .transpose()?;
        let plot = self.plot.as_ref().map(|(_, options)| Plot::new(&header, options.clone())).transpose()?;
        let xy = self.xy.as_ref().map(|(_, axes, options)| across(&header, *axes, options)).transpose()?;
        let page = self.page.as_ref().map(|(_, axes, options)| Page::new(&header, *axes, options)).transpose()?;
        let (peaks, speeds) = (vec![0.0; header.axes.len()], vec![0.0; header.crds.len()]);
        self.open = Some(Open { header, csv, vcd, plot, page, xy, peaks, speeds, rows: 0 });
        Ok(())
    }
}

impl Open {
    fn laser(&mut self, laser: usize, change: &SignalChange) {
        if let Some(vcd) = &mut self.vcd {
            vcd.change(laser, change);
        }
        if let Some(plot) = &mut self.plot {
            plot.change(laser, change);
        }
        if let Some(page) = &mut self.page {
            page.change(laser, change);
        }
    }

    fn row(&mut self, row: &Row) -> trace::Result<()> {
        self.rows += 1;
        for (peak, point) in self.peaks.iter_mut().zip(&row.axes) {
            *peak = peak.max(trace::decimal::scaled_f64(point.vel).abs());
        }
        for (peak, speed) in self.speeds.iter_mut().zip(&row.crds) {
            *peak = peak.max(trace::decimal::scaled_f64(*speed).abs());
        }
        if let Some(csv) = &mut self.csv {
            csv.row(row)?;
        }
        if let Some(vcd) = &mut self.vcd {
            vcd.row(row)?;
        }
        if let Some(plot) = &mut self.plot {
            plot.row(row);
        }
        if let Some(page) = &mut self.page {
            page.row(row);
        }
        if let Some(xy) = &mut self.xy {
            xy.row(row);
        }
        Ok(())
    }
}

/// The picture of two axes: those asked for, or the first two.
pub(crate) fn across(header: &Header, axes: Option<(AxisName, AxisName)>, options: &PlotOptions) -> trace::Result<Xy> {
    match (axes, header.axes.as_slice()) {
        (Some(axes), _) => Xy::new(header, axes, options.clone()),
        (None, &[x, y, ..]) => Xy::new(header, (x, y), options.clone()),
        (None, _) => Err(TraceError::Plot("--xy shows two axes, and the job uses fewer".into())),
    }
}

/// So must that of a page.
pub fn page_name(path: &Path) -> Result<(), Failure> {
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase).as_deref() {
        Some("html" | "htm") => Ok(()),
        _ => Err(Failure::Input(format!("{}: a page's name ends with .html", path.display()))),
    }
}

/// The plot's path must say what kind of picture it is, before the job runs.
pub fn picture(path: &Path) -> Result<(), Failure> {
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase).as_deref() {
        Some("svg" | "png") => Ok(()),
        _ => Err(Failure::Input(format!("{}: a plot's name ends with .svg or .png", path.display()))),
    }
}
