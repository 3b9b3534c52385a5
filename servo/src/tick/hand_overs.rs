//! What a step of the tick reaches beyond its own state: rings it writes, stores it reads.
use crate::path::PathStores;
use crate::tables::TableStores;
use crate::tick::{EVENTS, MotionSource, SegmentStore, TickHalves};
use crate::trace::TraceSamples;
use crate::units::Axis;
use crate::view::Event;
use ring::Producer;

/// What tick commands reach beyond the tick's own state.
pub(crate) struct HandOvers<'r, 'a, const AXES: usize> {
    pub(crate) events: &'r mut Producer<'a, Event, EVENTS>,
    pub(crate) samples: &'r mut TraceSamples<'a>,
    pub(crate) segments: &'a [SegmentStore; AXES],
    pub(crate) tables: TableStores<'a>,
    pub(crate) paths: PathStores<'a>,
}

impl<'r, 'a, const AXES: usize> HandOvers<'r, 'a, AXES> {
    /// What a step reaches.
    #[inline(always)]
    pub(crate) fn of(halves: &'r mut TickHalves<'a, AXES>) -> HandOvers<'r, 'a, AXES> {
        let TickHalves { events, samples, segments, tables, paths, .. } = halves;
        HandOvers { events, samples, segments, tables: *tables, paths: *paths }
    }
}

impl<const AXES: usize> HandOvers<'_, '_, AXES> {
    /// What the motion of an axis is read from.
    pub(crate) fn source(&self, axis: Axis) -> Option<MotionSource<'_>> {
        Some(MotionSource { segments: self.segments.get(axis.index())?, tables: self.tables })
    }
}
