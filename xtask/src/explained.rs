//! The rows of [numbers explained](../../docs/numbers-explained.md) are those of
//! [numbers](../../docs/numbers.md).
//!
//! In: both pages. Out: nothing. Fails: [`check`], where a row that rose has another name or
//! another count of today than its row in numbers.
use crate::shell::{Outcome, root};
use std::collections::BTreeMap;
use std::fs;

/// The cells of a row that begins with a number.
fn cells(line: &str) -> Option<[&str; 6]> {
    let inner = line.strip_prefix("| ")?.strip_suffix(" |")?;
    let cells: Vec<&str> = inner.split(" | ").collect();
    let cells: [&str; 6] = cells.try_into().ok()?;
    cells[0].parse::<u32>().is_ok().then_some(cells)
}

/// Compares typical and worst counts of today.
pub fn check() -> Outcome {
    let read = |name: &str| fs::read_to_string(root().join("docs").join(name)).map_err(|e| format!("{name}: {e}"));
    let (numbers, explained) = (read("numbers.md")?, read("numbers-explained.md")?);
    let today: BTreeMap<_, _> = numbers
        .lines()
        .filter_map(cells)
        .map(|[count, row, _, typical, worst, _]| ((count, row), [typical, worst]))
        .collect();
    let rows: Vec<_> = explained.lines().filter_map(cells).collect();
    if rows.is_empty() {
        return Err("docs/numbers-explained.md: no row of counts that rose".into());
    }
    match rows.iter().find(|[count, row, _, typical, _, worst]| today.get(&(count, row)) != Some(&[typical, worst])) {
        Some([count, row, ..]) => Err(format!(
            "docs/numbers-explained.md: docs/numbers.md has another row than {count}, {row}, or other counts"
        )),
        None => Ok(()),
    }
}
