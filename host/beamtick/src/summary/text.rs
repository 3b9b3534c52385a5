//! The summary as text.
//!
//! In: its facts. Out: lines.
use super::{AxisFacts, CrdFacts, LaserFacts, LinkFacts, Summary};
use std::fmt;

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: done on {}, profile {}, servo tick {} us",
            self.job, self.board, self.profile, self.servo_tick_us
        )?;
        writeln!(f, "  script clock {:.3} ms, {} entries", self.script_clock_ms, self.entries)?;
        if let Some(seconds) = self.simulated_s {
            let times = self.script_clock_ms / 1e3 / seconds.max(1e-9);
            writeln!(f, "  simulated in {:.3} s: {times:.0} x real time", seconds.max(1e-9))?;
        }
        let at =
            |entry: &Option<String>, of: &str| entry.as_ref().map_or(String::new(), |entry| format!("{of} {entry}"));
        match self.late.count {
            0 => writeln!(f, "  no late entries")?,
            late => writeln!(
                f,
                "  {late} late entries, the worst by {} us{}: they acted at once (--strict stops instead)",
                self.late.worst_us,
                at(&self.late.first, ", the first one is")
            )?,
        }
        if self.overruns.count > 0 {
            writeln!(
                f,
                "  OVERRUN: {} servo ticks took longer than {} us{}",
                self.overruns.count,
                self.servo_tick_us,
                at(&self.overruns.first_after, ", the first one after")
            )?;
        }
        if self.failures_passed_over > 0 {
            writeln!(f, "  {} calls failed and were passed over (#pragma continue)", self.failures_passed_over)?;
        }
        self.axes.iter().try_for_each(|axis| writeln!(f, "  {axis}"))?;
        self.coordinate_systems.iter().try_for_each(|crd| writeln!(f, "  {crd}"))?;
        self.lasers.iter().try_for_each(|laser| {
            let end = if laser.on_at_the_end { "; was on when the script ended: shut off" } else { "" };
            let name = laser.name.as_ref().map_or_else(String::new, |name| format!(" ({name})"));
            writeln!(f, "  laser {}{name}: {laser}{end}", laser.channel)
        })?;
        for laser in self.lasers.iter().filter(|laser| laser.width_limited_times > 0) {
            let times = laser.width_limited_times;
            writeln!(
                f,
                "  laser {}: WIDTH LIMITED {times} time{}: its rate followed to where the pulse width reaches the period; \
                 pulses there are just under the period",
                laser.channel,
                if times == 1 { "" } else { "s" }
            )?;
        }
        for stream in &self.pt_streams {
            let least = stream.least_ms_to_dry.map_or(String::new(), |least| format!("; least seen {least} ms"));
            writeln!(
                f,
                "  PT data of {}: at the last data {} slots free, {} ms to dry{least}",
                named("axis", stream.core, stream.axis),
                stream.free_slots,
                stream.ms_to_dry
            )?;
        }
        writeln!(f, "  link: {}", self.link)?;
        match &self.trace {
            Some(trace) => {
                let raised = if trace.raised { ", raised to what the link carries" } else { "" };
                let ticks = if trace.every == 1 { "" } else { "s" };
                writeln!(f, "  trace: {} rows, one every {} tick{ticks}{raised}", trace.rows, trace.every)?;
            }
            None if !self.axes.is_empty() => {
                writeln!(f, "  peak velocities are shown with --trace, --vcd, --plot, --html or --xy")?;
            }
            None => {}
        }
        Ok(())
    }
}

/// What a person calls an axis, or a coordinate system.
pub(crate) fn named(what: &str, core: i16, number: i16) -> String {
    if core == 1 { format!("{what} {number}") } else { format!("core {core} {what} {number}") }
}

impl fmt::Display for AxisFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (planned, encoder) = (self.planned, self.encoder);
        write!(f, "{}: planned {planned:.6}, encoder {encoder:.6} pulses", named("axis", self.core, self.axis))?;
        if let (Some(letter), Some(mm)) = (self.letter, self.planned_mm) {
            write!(f, ", {letter} {mm:.3} mm")?;
        }
        if let Some(peak) = self.peak_velocity {
            write!(f, ", peak velocity {peak:.6} pulse/ms")?;
        }
        write!(f, "; {}", self.end)?;
        if !self.latched.is_empty() {
            write!(f, " (latched: {})", self.latched.join(", "))?;
        }
        self.pt.as_ref().map_or(Ok(()), |pt| {
            write!(f, "\n    PT: {}, {} passes, {} slots free", pt.state, pt.passes, pt.free_slots)
        })
    }
}

impl fmt::Display for CrdFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let speed = self.peak_speed.map_or(String::new(), |speed| format!(", peak path speed {speed:.6} pulse/ms"));
        let name = named("crd", self.core, self.crd);
        let Some(end) = &self.end else { return write!(f, "{name}: drives no axis any more{speed}") };
        write!(f, "{name}: {} segments", self.segments_done)?;
        if self.segments_left != 0 {
            write!(f, ", {} left", self.segments_left)?;
        }
        write!(f, "{speed}; {end}")
    }
}

impl fmt::Display for LaserFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let light = if self.light { "light on" } else { "dark" };
        write!(
            f,
            "{} mode, {light}, output {} {}, light of {:.3} ms so far",
            self.mode, self.output, self.unit, self.light_ms
        )?;
        if self.width_limited_now {
            write!(f, ", pulse width limited to just under the period")?;
        }
        self.kept_dark.as_ref().map_or(Ok(()), |cause| write!(f, "; KEPT DARK: {cause} (ClrLaserFault)"))
    }
}

impl fmt::Display for LinkFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} messages sent, {} received; {} sent again, {} came twice, {} damaged frames refused",
            self.sent, self.received, self.sent_again, self.came_twice, self.damaged
        )
    }
}
