//! The profile that a job runs with, the same on every board: what the command line says, else the
//! first profile that holds every core and axis the job names.
use crate::Failure;
use client::ProductProfile;
use job::Job;
use protocol::command::{VersionReply, info};
use protocol::reason::Refusal;

/// Parameters that name a core, an axis or axes.
const NAMING: [&str; 6] = ["core", "axis", "profile", "encoder", "control", "axes"];

/// The profile of this name.
pub fn named(name: &str) -> Result<ProductProfile, Failure> {
    ProductProfile::named(name).ok_or_else(|| {
        let known: Vec<&str> = ProductProfile::ALL.iter().map(|(_, name)| *name).collect();
        Failure::Input(format!("there is no profile `{name}`; profiles are {}", known.join(", ")))
    })
}

/// The profile for a job.
pub fn of_job(job: &Job) -> ProductProfile {
    let named: Vec<(i16, i16)> = job.named.keys().map(|axis| (axis.core, axis.axis)).collect();
    ProductProfile::for_axes(&named)
}

/// What of a job the first profile lacks: the axis that comes first in the script, and its line.
pub fn reason(job: &Job) -> Option<String> {
    let lacks = |axis: &job::Axis| !ProductProfile::Gus.holds(axis.core, axis.axis);
    let (axis, line) = job.named.iter().filter(|(axis, _)| lacks(axis)).min_by_key(|(_, line)| **line)?;
    Some(match axis.axis {
        0 => format!("line {line} names core {}", axis.core),
        number if axis.core == 1 => format!("line {line} names axis {number}"),
        number => format!("line {line} names axis {number} of core {}", axis.core),
    })
}

/// The name of the profile that a controller shows.
pub fn shown(version: &VersionReply) -> &'static str {
    ProductProfile::numbered(version.profile).map_or("unknown", ProductProfile::name)
}

/// What helps where a call names a core, an axis or a coordinate system that the profile has not;
/// nothing if it is another fault.
pub fn help(version: &VersionReply, opcode: u16, refusal: &Refusal) -> Option<String> {
    let command = info(opcode)?;
    let (field, of) = *command.fields.iter().chain(command.items).nth(refusal.field.into())?;
    // What an array holds is none of them: coordinates in SetCrdPrm.
    if refusal.got.get() <= refusal.high.get() || of.starts_with('[') {
        return None;
    }
    let profile = shown(version);
    // A mask names coordinate systems or axes, or, in the GT form of Stop, both.
    let names_all = |count: u8| field == "mask" && refusal.high.get() == f64::from(count).exp2() - 1.0;
    if field == "crd" || names_all(version.crds_per_core) {
        return Some(format!(
            "profile {profile} has {} coordinate systems to a core at this servo tick; with --profile r688s-016 or r688s-032 there are 4, \
             with gsn-024 or gsn-048 from 500 us on",
            version.crds_per_core
        ));
    }
    let counts_axes =
        field == "count" && command.fields.iter().any(|(name, _)| ["axis", "profile", "encoder"].contains(name));
    (NAMING.contains(&field) || counts_axes || names_all(version.axes_per_core)).then(|| {
        let cores = if version.cores == 1 { "1 core of".to_owned() } else { format!("{} cores of", version.cores) };
        format!(
            "profile {profile} has {cores} {} axes; --profile NAME chooses another, the largest are gsn-048 (2 cores of 24) and r688s-032 (1 core of 32)",
            version.axes_per_core
        )
    })
}
