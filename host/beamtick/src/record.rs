//! The trace stream to files: CSV, VCD, plots.
//!
//! In: the stream's bytes as they arrive. Out: files, and the peak velocity of each axis and path.
//! Owns the files. Fails: the first error ends the recording and is reported at its end; a gap is
//! never skipped.
use crate::Failure;
use crate::command_line::Outputs;
use crate::output::{Kept, Output};
use crate::spool::Spool;
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
    xy: Option<Xy>,
    peaks: Vec<f64>,
    speeds: Vec<f64>,
    rows: u32,
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
            ..PlotOptions::default()
        };
        options.check().map_err(|error| Failure::Input(error.to_string()))?;
        for path in [&outputs.plot, &outputs.xy].into_iter().flatten() {
            picture(path)?;
        }
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
        let (mut plot, mut xy) = (drawn(&outputs.plot)?, drawn(&outputs.xy)?);
        streams.iter_mut().chain(&mut plot).chain(&mut xy).try_for_each(Output::set_older_aside)?;
        Ok(Recording {
            reader: Reader::new(),
            sinks: Sinks {
                csv,
                vcd,
                streams,
                plot: plot.map(|output| (output, options.clone())),
                xy: xy.map(|output| (output, outputs.xy_axes.or(in_mm), options)),
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

    /// Closes the files; the pictures are drawn here. What is not whole is left as
    /// [`Recording::cut_off`] leaves it.
    pub fn finish(mut self) -> Result<Recorded, Failure> {
        let broken = match (self.failed.take(), &self.sinks.open) {
            (Some(error), _) => Some(error.into()),
            (None, None) => Some(Failure::Job("trace: the controller sent none".into())),
            (None, Some(open)) if !self.reader.ended() => {
                Some(Failure::Job(format!("trace: it breaks off after {} rows; the end did not come", open.rows)))
            }
            _ => None,
        };
        if let Some(failure) = broken {
            self.cut_off();
            return Err(failure);
        }
        let written = self.sinks.write();
        let Sinks { streams, plot, xy, open: Some(open), .. } = self.sinks else {
            return Err(Failure::Job("trace: the controller sent none".into()));
        };
        let files = streams.into_iter().chain(plot.map(|(output, _)| output)).chain(xy.map(|(output, ..)| output));
        if let Err(error) = written {
            files.for_each(|output| drop(output.cut_off()));
            return Err(error.into());
        }
        files.into_iter().try_for_each(Output::whole)?;
        Ok(Recorded { header: open.header, peaks: open.peaks, speeds: open.speeds, rows: open.rows })
    }

    /// The job has failed: what there is is written and drawn, under names that say so. These
    /// names.
    pub fn cut_off(mut self) -> Vec<Kept> {
        // A file that cannot be written or drawn is missing; only the job's own failure is
        // reported.
        let _ = self.sinks.write();
        let Sinks { streams, plot, xy, .. } = self.sinks;
        let files = streams.into_iter().chain(plot.map(|(output, _)| output)).chain(xy.map(|(output, ..)| output));
        files.map(Output::cut_off).collect()
    }
}

impl Sinks {
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
        csv.and(vcd).and(plot).and(xy)
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
                if let Some(xy) = self.open.as_mut().and_then(|open| open.xy.as_mut()) {
                    xy.light(laser, at, on);
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
        let (peaks, speeds) = (vec![0.0; header.axes.len()], vec![0.0; header.crds.len()]);
        self.open = Some(Open { header, csv, vcd, plot, xy, peaks, speeds, rows: 0 });
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

/// The plot's path must say what kind of picture it is, before the job runs.
pub fn picture(path: &Path) -> Result<(), Failure> {
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase).as_deref() {
        Some("svg" | "png") => Ok(()),
        _ => Err(Failure::Input(format!("{}: a plot's name ends with .svg or .png", path.display()))),
    }
}
