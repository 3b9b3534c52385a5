//! The curve of PVT Percent, a ramp with percentage (SPEC 5, Percent). In a ramp of duration T from
//! v0 to v1 with percentage c the acceleration rises for T·c/200, holds, and falls for T·c/200.
//! With k = c/200 its peak is (v1 − v0)/(T·(1 − k)). Time and displacement of the ramp do not
//! depend on c.
use super::scratch::TablePoint;

/// A part below this share of the ramp is left out. The position then differs by less than 2⁻⁴⁶ of
/// speed × duration, a sixty-fourth of what SPEC 11 allows.
const RAMP_PART_MIN_SHARE: f64 = 1.0 / (1u64 << 46) as f64;

/// The knots inside a ramp from `from` to `to` (both excluded): none, one or two.
pub fn inner(from: TablePoint, to: TablePoint, percent: f64) -> impl Iterator<Item = TablePoint> {
    let (t, k, change) = (to.time - from.time, percent / 200.0, to.vel - from.vel);
    let ramp = t * k;
    let bend = change * k / (1.0 - k);
    let rise = TablePoint {
        time: from.time + ramp,
        pos: from.pos + ramp * (from.vel + bend / 6.0),
        vel: from.vel + bend / 2.0,
    };
    let fall =
        TablePoint { time: to.time - ramp, pos: to.pos - ramp * (to.vel - bend / 6.0), vel: to.vel - bend / 2.0 };
    let curved = k >= RAMP_PART_MIN_SHARE && change != 0.0;
    let held = 1.0 - 2.0 * k >= RAMP_PART_MIN_SHARE;
    [curved.then_some(rise), (curved && held).then_some(fall)].into_iter().flatten()
}
