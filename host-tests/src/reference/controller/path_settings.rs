//! Settings of a coordinate system that its motion does not know, and why it came to standstill.
use super::super::call::Call;
use super::super::crd::Crd;
use super::super::path::{Path, PathCall};
use super::answer::{Answer, DONE, either, range};
use super::{Controller, Reply, Value};

/// Time constants of SetLaserFollowFilter, ms.
const FILTERS: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

impl Controller {
    pub(super) fn path_setting(&mut self, index: usize, call: &Call, of: &PathCall) -> Answer {
        let core = of.core;
        match of.what {
            Path::Filter { crd, ms } => {
                let good = ms == 0.0 || FILTERS.contains(&ms);
                let set = self.crd(core, crd).map(|_| ());
                range(set != Err(7))?;
                either(set.is_ok(), good)?;
                self.crd(core, crd)?.filter_ms = ms;
                DONE
            }
            Path::GetFilter { crd } => {
                let ms = self.crd(core, crd)?.filter_ms;
                Ok(Reply::Done(Value::Reals([ms, 0.0, 0.0, 0.0])))
            }
            _ => {
                self.crd(core, of.what.crd())?;
                Ok(self.read(index, call, 0))
            }
        }
    }

    /// GetCrdStopReason: that of the last motion that has come to its end.
    pub(super) fn why_of(of: &Crd, soon: bool) -> (Value, bool) {
        match of.why {
            Some(why) => (Value::Whole(why as i64), soon || of.runs),
            None => (Value::Whole(0), true),
        }
    }
}
