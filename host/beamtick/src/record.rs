//! The trace stream to files: CSV, VCD, plots.
//!
//! In: the stream's bytes as they come. Out: files, and the peak velocity of each axis and path. The first error
//! ends the recording and is told at its end: a gap is never passed over.
use crate::Failure;
use crate::command_line::Outputs;
use crate::spool::Spool;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use trace::{AxisName, Change, CsvWriter, Header, Item, Plot, PlotOptions, Reader, Row, TraceError, VcdWriter, Xy};

/// See the module text.
pub struct Recording {
    reader: Reader,
    sinks: Sinks,
    failed: Option<TraceError>,
}

/// Where to, of which axes, of what part.
type XyPlot = (PathBuf, Option<(AxisName, AxisName)>, PlotOptions);

struct Sinks {
    csv: Option<File>,
    vcd: Option<File>,
    plot: Option<(PathBuf, PlotOptions)>,
    xy: Option<XyPlot>,
    outputs: Vec<u8>,
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
    /// Creates the files. `digital` are the general outputs that the job sets, from 1, which go into the VCD.
    ///
    /// `title` and `subtitle` stand above the plot.
    pub fn new(outputs: &Outputs, (title, subtitle): (&str, String), digital: Vec<u8>) -> Result<Self, Failure> {
        let create = |path: &PathBuf| File::create(path).map_err(|error| unwritable(path, &error));
        let options = PlotOptions {
            title: title.to_owned(),
            subtitle,
            from_ms: outputs.from,
            to_ms: outputs.to,
            ..PlotOptions::default()
        };
        options.check().map_err(|error| Failure::Input(error.to_string()))?;
        for path in [&outputs.plot, &outputs.xy].into_iter().flatten() {
            picture(path)?;
            // It is drawn at the end; that it cannot be written is told before the job runs.
            let opened = File::options().create(true).append(true).open(path);
            opened.map_err(|error| unwritable(path, &error))?;
        }
        Ok(Recording {
            reader: Reader::new(),
            sinks: Sinks {
                csv: outputs.trace.as_ref().map(create).transpose()?,
                vcd: outputs.vcd.as_ref().map(create).transpose()?,
                plot: outputs.plot.clone().map(|path| (path, options.clone())),
                xy: outputs.xy.clone().map(|path| (path, outputs.xy_axes, options)),
                outputs: digital,
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

    /// Closes the files; the plot is drawn here.
    pub fn finish(self) -> Result<Recorded, Failure> {
        if let Some(error) = self.failed {
            return Err(error.into());
        }
        let Some(open) = self.sinks.open else {
            return Err(Failure::Job("trace: the controller sent none".into()));
        };
        if let Some(csv) = open.csv {
            csv.finish()?;
        }
        if let Some(vcd) = open.vcd {
            vcd.finish()?;
        }
        if let (Some(plot), Some((path, _))) = (&open.plot, &self.sinks.plot) {
            plot.save(path)?;
        }
        if let (Some(xy), Some((path, ..))) = (&open.xy, &self.sinks.xy) {
            xy.save(path)?;
        }
        if !self.reader.ended() {
            return Err(Failure::Job(format!("trace: it breaks off after {} rows; the end did not come", open.rows)));
        }
        Ok(Recorded { header: open.header, peaks: open.peaks, speeds: open.speeds, rows: open.rows })
    }
}

impl Sinks {
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
            .map(|file| VcdWriter::new(BufWriter::new(Spool::new(file)), &header, &levels))
            .transpose()?;
        let plot = self.plot.as_ref().map(|(_, options)| Plot::new(&header, options.clone())).transpose()?;
        let xy = self.xy.as_ref().map(|(_, axes, options)| xy(&header, *axes, options)).transpose()?;
        let (peaks, speeds) = (vec![0.0; header.axes.len()], vec![0.0; header.crds.len()]);
        self.open = Some(Open { header, csv, vcd, plot, xy, peaks, speeds, rows: 0 });
        Ok(())
    }
}

impl Open {
    fn laser(&mut self, laser: usize, change: &Change) {
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
fn xy(header: &Header, axes: Option<(AxisName, AxisName)>, options: &PlotOptions) -> trace::Result<Xy> {
    match (axes, header.axes.as_slice()) {
        (Some(axes), _) => Xy::new(header, axes, options.clone()),
        (None, &[x, y, ..]) => Xy::new(header, (x, y), options.clone()),
        (None, _) => Err(TraceError::Plot("--xy shows two axes, and the job uses fewer".into())),
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Input(format!("{}: cannot be written: {error}", path.display()))
}

/// The plot's path must say what kind of picture it is, before the job runs.
fn picture(path: &Path) -> Result<(), Failure> {
    match path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase).as_deref() {
        Some("svg" | "png") => Ok(()),
        _ => Err(Failure::Input(format!("{}: a plot's name ends with .svg or .png", path.display()))),
    }
}
