//! What the energy output may do where there is no light.
use host_tests::laser_model::{Edge, Ns, Outcome};

/// Outside light, with dither too: no pulse but those of standby, and the last one is over when it
/// must be. The ends of light may be off by `slack`.
pub fn in_the_dark(model: &Outcome, energy: &[Edge<bool>], horizon: Ns, slack: Ns) -> Result<(), String> {
    let pulses: Vec<(Ns, Ns)> =
        energy.chunks(2).map(|edges| (edges[0].0, edges.get(1).map_or(horizon, |edge| edge.0))).collect();
    for dark in &model.dark {
        let (from, to) = (dark.span.begin, dark.span.end);
        // What docs/laser.md promises of dither: a count, 1 ppm of a period and 0.001 % of duty.
        let (mut period, mut width) = ((0, Ns::MAX), (0, 0));
        if let Some(train) = dark.standby {
            let (p, w) = (train.period.to_integer() as Ns, train.width.to_integer() as Ns);
            // Pulses without a gap between them are one.
            width =
                if w + 2 + p / 100_000 >= p { (0, Ns::MAX / 4) } else { (w - 1 - p / 100_000, w + 2 + p / 100_000) };
            // Pulses of less than a count are left out.
            period = (p - 1 - p / 1_000_000, if width.0 > 0 && width.1 < p { p + 2 + p / 1_000_000 } else { Ns::MAX });
        }
        let first = pulses.partition_point(|&(_, end)| end <= from);
        let mut before: Option<Ns> = None;
        for &(begin, end) in pulses[first..].iter().take_while(|&&(begin, _)| begin < to - slack) {
            let good = if begin < from + slack {
                end.min(to) <= from + dark.left + width.1 + slack
            } else {
                let apart = before.replace(begin).is_none_or(|last| (period.0..=period.1).contains(&(begin - last)));
                dark.standby.is_some()
                    && apart
                    && end.min(to) - begin <= width.1 + slack
                    && (end >= to - slack || end - begin >= width.0)
            };
            if !good {
                return Err(format!("energy from {begin} to {end} in {dark:?}"));
            }
        }
    }
    Ok(())
}
