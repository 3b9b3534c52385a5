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
        writeln!(f, "  script clock {:.3} ms, {}", self.script_clock_ms, counted(self.entries, "entry", "entries"))?;
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
                "  {}, the worst by {} us{}: acted at once (--strict stops instead)",
                counted(late, "late entry", "late entries"),
                self.late.worst_us,
                at(&self.late.first, ", the first one is")
            )?,
        }
        if self.overruns.count > 0 {
            writeln!(
                f,
                "  OVERRUN: {} took longer than {} us{}",
                counted(self.overruns.count, "servo tick", "servo ticks"),
                self.servo_tick_us,
                at(&self.overruns.first_after, ", the first one after")
            )?;
        }
        if self.failures_passed_over > 0 {
            let calls = counted(self.failures_passed_over, "call failed and was", "calls failed and were");
            writeln!(f, "  {calls} passed over (#pragma continue)")?;
        }
        self.axes.iter().try_for_each(|axis| writeln!(f, "  {axis}"))?;
        self.coordinate_systems.iter().try_for_each(|crd| writeln!(f, "  {crd}"))?;
        self.lasers.iter().try_for_each(|laser| {
            let end = if laser.on_at_the_end { "; was on when the script ended: shut off" } else { "" };
            let name = laser.name.as_ref().map_or_else(String::new, |name| format!(" ({name})"));
            writeln!(f, "  laser {}{name}: {laser}{end}", laser.channel)
        })?;
        for laser in self.lasers.iter().filter(|laser| laser.width_limited_times > 0) {
            writeln!(
                f,
                "  laser {}: WIDTH LIMITED {}: its rate followed to where the pulse width reaches the period; \
                 pulses there are just under the period",
                laser.channel,
                counted(laser.width_limited_times, "time", "times")
            )?;
        }
        for stream in &self.pt_streams {
            let least = stream.least_ms_to_dry.map_or(String::new(), |least| format!("; least seen {least} ms"));
            writeln!(
                f,
                "  PT data of {}: at the last data {} free, {} ms to dry{least}",
                named("axis", stream.core, stream.axis),
                counted(stream.free_slots, "slot", "slots"),
                stream.ms_to_dry
            )?;
        }
        writeln!(f, "  link: {}", self.link)?;
        match &self.trace {
            Some(trace) => {
                let raised = if trace.raised { ", raised to what the link carries" } else { "" };
                let (rows, ticks) = (counted(trace.rows, "row", "rows"), counted(trace.every, "tick", "ticks"));
                writeln!(f, "  trace: {rows}, one every {ticks}{raised}")?;
            }
            None if !self.axes.is_empty() => {
                writeln!(f, "  peak velocities are shown with --trace, --vcd, --plot, --html or --xy")?;
            }
            None => {}
        }
        Ok(())
    }
}

/// A number of things, by the word for one and that for many.
pub(crate) fn counted(count: impl Into<i64>, one: &str, many: &str) -> String {
    let count = count.into();
    format!("{count} {}", if count == 1 { one } else { many })
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
            let (passes, slots) = (counted(pt.passes, "pass", "passes"), counted(pt.free_slots, "slot", "slots"));
            write!(f, "\n    PT: {}, {}, {} free", pt.state, passes, slots)
        })
    }
}

impl fmt::Display for CrdFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let speed = self.peak_speed.map_or(String::new(), |speed| format!(", peak path speed {speed:.6} pulse/ms"));
        let name = named("crd", self.core, self.crd);
        let Some(end) = &self.end else { return write!(f, "{name}: drives no axis any more{speed}") };
        write!(f, "{name}: {}", counted(self.segments_done, "segment", "segments"))?;
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
