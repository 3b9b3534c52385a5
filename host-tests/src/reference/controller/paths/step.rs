//! A tick of all paths, with the axes that they take along.
use super::*;

impl Controller {
    /// From the tick before to this one.
    pub(in super::super) fn step_paths(&mut self, before: i64, now: i64) {
        let then = std::mem::take(&mut self.path_then);
        self.axes.iter_mut().for_each(|axis| axis.bent = false);
        self.light.standstill();
        for (crd, track, most) in self.leaving.drain(..) {
            self.light.follows(crd, track / ms(now - before), most, false);
        }
        let Controller { crds, axes, .. } = self;
        for (name, of) in crds {
            let starts = std::mem::take(&mut of.started_here);
            of.fed_here = false;
            let ran = of.runs;
            let halts = then.iter().any(|(of, then)| of == name && *then == PathThen::Halt);
            let published = halts.then(|| of.clone());
            // Those geared since the tick before go along, or are at standstill.
            for axis in axes.iter_mut().filter(|axis| axis.geared && axis.crd == Some(*name)) {
                let goes = of.runs && of.fifos[of.fifo].gears.iter().any(|gear| gear.is_engaged());
                (axis.geared, axis.carried) =
                    (goes && axis.driven, axis.driven.then(|| vec![(Fix::ms(before), axis.x)]));
            }
            if let Some((axis, ends)) = of.waits
                && axes[axis].goes_until().is_none_or(|end| (end.to_f64() - ends).abs() > 1e-9)
            {
                self.open = Some("an axis that a path waits for, and that something else moves");
            }
            let (mut early, mut open) = (Vec::new(), None);
            let speed = of.set.as_ref().map_or(0.0, |set| set.frame.speed);
            // Instants known to a ns, or as an abrupt Stop has left them.
            let late = if of.rated { 1e-6 } else { 0.0 } + of.blur;
            of.run(
                ms(now),
                &mut Others {
                    name: *name,
                    before: Fix::ms(before),
                    speed,
                    late,
                    axes,
                    early: &mut early,
                    open: &mut open,
                },
            );
            self.open = self.open.or(open);
            if self.interlock.halts_all() {
                // What the path sets off in this tick stands with the rest.
                for axis in &early {
                    if !axes[*axis].driven {
                        axes[*axis].halt(Why::Interlock);
                    }
                }
            }
            let off = early.iter().filter(|axis| !axes[**axis].geared).count();
            *self.used.entry("axes that a path sets off").or_default() += off as u64;
            self.early.append(&mut early);
            of.rested = of.rested.filter(|_| !of.runs && ran);
            if std::mem::take(&mut of.hindered) {
                if name.0 == 1 {
                    let crd = name.1 as usize - 1;
                    // The controller knows it up to two ticks before, and is dark from then on.
                    self.open = Some("a path that meets an axis that must not move");
                    self.light.between.push((of.now, Act::Fault(crd, OTHER)));
                }
                *self.used.entry("paths that met an axis that must not move").or_default() += 1;
            }
            if name.0 == 1 {
                self.light.follows(name.1 as usize - 1, of.gone / ms(now - before), speed, of.runs && !starts);
            }
            if std::mem::take(&mut of.late) && (!of.runs || of.open || of.dry) {
                self.open = Some("data in the tick in which a path ends");
            }
            let rested = of.rested.take().map(|(at, braked)| (at, braked, of.rest));
            let rests = rested.is_some() || of.brakes && of.speed < 1e-6;
            if of.open && ran && rests && name.0 == 1 && !self.light.calls.is_empty() {
                self.open = Some("a call of a laser where a path comes to rest on the tick");
            }
            let mut halted = false;
            for (_, then) in then.iter().filter(|(of, _)| of == name) {
                if halted && *then == PathThen::Brake && name.0 == 1 && self.light.is_lit(name.1 as usize - 1) {
                    // Whether it finds the path at rest decides whether its light comes back.
                    self.open = Some("a smooth Stop of a lit path at the instant of an abrupt one");
                }
                halted |= *then == PathThen::Halt;
                match *then {
                    PathThen::Rate(rate) => of.change_rate(rate),
                    // At speed the abrupt one decides; in a BufDelay it is at standstill here and
                    // now.
                    PathThen::Brake if halts && of.speed > 0.0 => {}
                    PathThen::Brake | PathThen::Halt if !of.runs => {}
                    PathThen::Brake | PathThen::Halt => {
                        if of.open || of.speed < 1e-3 && of.speed != 0.0 {
                            self.open = Some("a Stop where a path comes to rest or to an entry");
                        }
                        if *then == PathThen::Brake {
                            of.brake();
                        } else if let Some(published) = &published {
                            let comes_beyond = |(coordinate, axis): (usize, &Option<usize>)| {
                                let (Some(axis), Some(set)) = (axis, &of.set) else { return false };
                                let zero = axes[*axis].zero + set.zero[coordinate];
                                axes[*axis].is_beyond(zero + Fix::of_f64(of.position[coordinate]))
                            };
                            let axes_of = of.set.as_ref().map_or([None; 4], |set| set.axes);
                            if axes_of.iter().enumerate().any(comes_beyond) {
                                // A path is ahead of the tick: it has met the limit, which counts.
                                self.open = Some("an abrupt Stop in the tick in which a path meets a soft limit");
                            }
                            of.halt(published);
                            for axis in axes.iter_mut().filter(|axis| axis.geared && axis.crd == Some(*name)) {
                                axis.carried = Some(vec![(Fix::ms(before), axis.x)]);
                            }
                        }
                    }
                }
            }
            self.open = self.open.or(of.unsaid);
            if name.0 == 1 {
                let (crd, fifo) = (name.1 as usize - 1, of.fifo);
                for (at, channel, command, brakes) in of.lasers.drain(..) {
                    self.light.between.push((at, Act::Entry(crd, channel, command, brakes)));
                    *self.used.entry("entries of lasers reached").or_default() += 1;
                }
                if of.rested.take().is_some() {
                    self.light.halted.push((crd, fifo));
                }
                if let Some((at, braked, rest)) = rested {
                    let act = match rest {
                        Some(Rest::Stopped) => Act::Stopped(crd, fifo),
                        Some(Rest::Underrun) => Act::Fault(crd, UNDERRUN),
                        _ => Act::Done(crd, fifo, braked),
                    };
                    if matches!(act, Act::Fault(..)) && self.light.lights_now() {
                        // The controller knows of it a tick before.
                        self.open = Some("light by a call in the tick in which a path runs dry at speed");
                    }
                    self.light.between.push((at, act));
                }
            }
            for (at, channel, value) in of.analog.drain(..) {
                // That of a laser in analog mode is the laser's alone.
                if self.levels.driven >> channel & 1 == 0 {
                    self.analog.push((at, channel, value));
                }
                *self.used.entry("analog outputs set by paths").or_default() += 1;
            }
            for (at, mask, value) in of.outputs.drain(..) {
                self.changes.push((at, mask, value));
                *self.used.entry("outputs set by paths").or_default() += 1;
            }
            let Some(set) = of.set.as_ref().filter(|_| ran) else { continue };
            *self.used.entry("ticks of paths").or_default() += 1;
            let (velocities, geared) = of.velocities();
            for (coordinate, axis) in set.axes.iter().enumerate() {
                let Some(axis) = *axis else { continue };
                let axis = &mut axes[axis];
                let zero = axis.zero + set.zero[coordinate];
                let at = |position: &[f64; 4]| zero + Fix::of_f64(position[coordinate]);
                let mut track = vec![(Fix::ms(before), axis.x)];
                track.extend(of.knots.iter().map(|(when, position)| (Fix::of_f64(*when), at(position))));
                (axis.x, axis.v) = (at(&of.position), Fix::of_f64(velocities[coordinate]));
                track.push((Fix::ms(now), axis.x));
                axis.carried = Some(track);
                axis.bent = !of.is_straight;
                axis.path_open = of.open;
                axis.path_most = Fix::of_f64(set.frame.speed);
                axis.driven = of.runs;
                axis.path_ended = of.rest.is_some_and(|rest| rest != Rest::Stopped) && !of.runs;
                axis.late = axis.path_most * Fix::ms(5 * i64::from(of.waited));
                axis.late += axis.path_most * Fix::of_f64(of.blur);
                if of.rated {
                    axis.late += axis.path_most * Fix::ms(1);
                }
                if of.resumed {
                    axis.late += Fix(1 << 47);
                }
                if of.rest == Some(Rest::Stopped) && !of.runs {
                    axis.slack += axis.late;
                }
            }
            for axis in axes.iter_mut().filter(|axis| axis.geared && axis.crd == Some(*name)) {
                *self.used.entry("ticks in which an axis is geared to a path").or_default() += 1;
                let Some(track) = &mut axis.carried else { continue };
                let x = track.last().map_or(axis.x, |last| last.1);
                track.push((Fix::ms(now), x));
                (axis.bent, axis.path_open) = (true, of.open || !axis.driven);
                axis.driven &= of.runs;
                axis.v = Fix::ZERO;
                if !axis.driven {
                    (axis.geared, axis.crd) = (false, None);
                    // Where it was left on the way.
                    let late = std::mem::take(&mut axis.late);
                    axis.slack += if axis.path_ended { Fix::ZERO } else { late };
                }
            }
            for (axis, v) in geared {
                if axes[axis].driven {
                    axes[axis].v = Fix::of_f64(v);
                }
            }
            if !of.runs {
                *self.used.entry("paths ended").or_default() += 1;
                // The controller is ahead by up to a tick.
                if of.contested != [false; 2] {
                    self.open = Some("a call that needs standstill, just before its path comes to rest");
                }
            }
        }
        self.crds.values_mut().for_each(|of| of.contested = [false, of.contested[0]]);
    }
}
