//! The velocity of a slave, and whether it is near a knot.
use super::*;

impl Slave {
    /// Its velocity from this instant on.
    pub fn velocity(&self, lead: &Lead) -> Fix {
        let Some(&at) = lead.track.last() else { return Fix::ZERO };
        let along = self.along(lead.velocity);
        if self.state != State::Runs || self.dir != 0 && (along <= Fix::ZERO || self.along(at) < self.far) {
            return Fix::ZERO;
        }
        let (here, lowest) = (self.along(at) - self.began, self.lowest());
        if self.dir == 0 && self.pass == self.floor.0 && (here < lowest || here == lowest && along < Fix::ZERO) {
            return Fix::ZERO;
        }
        self.table.curve.slope(self.position, along > Fix::ZERO) * along
    }

    /// What 22 fraction bits of positions and speeds make of it, where its master is known to
    /// `place` besides, and the master's velocity to `of_master`.
    pub fn velocity_rounding(&self, lead: &Lead, position: Fix, of_master: Fix) -> Fix {
        let curve = &self.table.curve;
        let bend = curve.curvature(self.position).unwrap_or(Fix::ZERO).abs();
        ROUNDED + bend * lead.velocity.abs() * (ROUNDED + position) + curve.slope(self.position, true).abs() * of_master
    }

    /// A knot or an end of a pass so near that its velocity may be that of either side.
    pub fn is_near_knot(&self, lead: &Lead) -> bool {
        let along = self.along(lead.velocity);
        let moves = if self.dir == 0 { along != Fix::ZERO } else { along > Fix::ZERO };
        let jump = self.table.curve.jump_near(self.position, NEAR);
        // One of a single direction goes on from the furthest point.
        if let Some(&at) = lead.track.last()
            && self.dir != 0
            && near(self.along(at) - self.far)
        {
            return moves && self.state == State::Runs;
        }
        // It rests before the place at which its way back ends.
        if let Some(&at) = lead.track.last()
            && self.dir == 0
            && self.pass == self.floor.0
            && near(self.along(at) - self.began - self.lowest())
        {
            return moves && self.state == State::Runs;
        }
        moves && self.state == State::Runs && self.position != Fix::ZERO && jump > Fix(1 << 44)
    }
}

/// 2⁻²².
const ROUNDED: Fix = Fix(1 << 42);

/// What rounding of a master's fixed-point position may decide: 2⁻¹⁴ pulse.
pub const NEAR: Fix = Fix(1 << 50);

pub(super) fn near(apart: Fix) -> bool {
    apart != Fix::ZERO && apart.abs() < NEAR
}
