//! What a program uses: the axes, coordinate systems and lasers that its trace shows.
//!
//! In: calls, as a job or a C program makes them. Out: sets. Numbers that no controller has are
//! kept: it refuses them.

use crate::api::Function;
use crate::job::{Axis, Crd};
use std::collections::BTreeSet;

/// Profiles in the parameters of a coordinate system.
const MAPPED_PROFILES: usize = 8;

/// See the module text.
#[derive(Debug, Clone, Default)]
pub struct Used {
    /// A call sets their mode or position, maps them to a coordinate system, or lets a path move
    /// them.
    pub axes: BTreeSet<Axis>,
    /// A call sets them up.
    pub crds: BTreeSet<Crd>,
    /// A call sets something of them; bit k is channel k.
    pub lasers: u8,
}

impl Used {
    /// Takes note of a call and its values, in order; of an array or a struct one by one. The axes
    /// that a coordinate system gets or moves.
    pub fn note<'a>(
        &mut self,
        function: &Function,
        core: i16,
        values: impl Iterator<Item = (&'a str, f64)> + Clone,
    ) -> Vec<Axis> {
        let nth = |n: usize| values.clone().nth(n).map_or(0, |(_, value)| value as i16);
        let own = match function.name {
            "PrfPt" | "PrfPvt" | "PrfFollow" | "PrfFollowEx" | "PrfGear" | "PrfTrap" | "PrfJog" | "SetPrfPos"
            | "SetEncPos" | "GoHome" => 1,
            "ZeroPos" => nth(1),
            _ => 0,
        };
        let axes = (nth(0)..nth(0).saturating_add(own)).filter(|axis| *axis > 0);
        self.axes.extend(axes.map(|axis| Axis { core, axis }));
        let moved: Vec<Axis> = match function.name {
            "SetCrdPrm" => {
                self.crds.extend((nth(0) > 0).then_some(Crd { core, crd: nth(0) }));
                // Its dimension, then what each profile drives.
                let mapped =
                    (1..).zip(values.clone().skip(2).take(MAPPED_PROFILES)).filter(|(_, (_, drives))| *drives != 0.0);
                mapped.map(|(axis, _)| Axis { core, axis }).collect()
            }
            "BufMove" | "BufGear" => (nth(1) > 0).then_some(Axis { core, axis: nth(1) }).into_iter().collect(),
            _ => Vec::new(),
        };
        self.axes.extend(&moved);
        let channel = || values.clone().find(|(name, _)| *name == "channel").map(|(_, channel)| channel);
        self.lasers |= match function.name {
            _ if function.reads() => 0,
            "SetWaitPulseEx" => 0b11,
            _ => match channel() {
                Some(0.0) => 0b01,
                Some(1.0) => 0b10,
                _ => 0,
            },
        };
        moved
    }
}
