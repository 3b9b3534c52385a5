//! A trace file as columns.
#![allow(dead_code)] // Each test binary uses a part of it.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

/// See the module text.
pub struct Trace {
    columns: HashMap<String, Vec<f64>>,
}

impl Trace {
    /// Reads a CSV; every row has every column.
    pub fn read(path: &Path) -> Trace {
        let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
        for line in lines {
            let values: Vec<f64> = line.split(',').map(|value| value.parse().unwrap()).collect();
            assert_eq!(values.len(), names.len());
            for (column, value) in columns.iter_mut().zip(values) {
                column.push(value);
            }
        }
        assert!(columns[0].len() > 1, "{}: no rows", path.display());
        Trace { columns: names.into_iter().map(str::to_owned).zip(columns).collect() }
    }

    /// The values of a column.
    pub fn column(&self, name: &str) -> &[f64] {
        self.columns.get(name).unwrap_or_else(|| panic!("no column {name}"))
    }

    /// Time from one row to the next, ms.
    fn period(&self) -> f64 {
        self.column("t_ms")[1]
    }

    /// Length, ms.
    pub fn time(&self) -> f64 {
        self.last("t_ms")
    }

    /// The value in force at a time.
    pub fn at(&self, ms: f64, name: &str) -> f64 {
        // The nearest row: the servo tick may change in a trace.
        let times = self.column("t_ms");
        let after = times.partition_point(|time| *time < ms).min(times.len() - 1);
        let nearer = after.saturating_sub(usize::from(after > 0 && ms - times[after - 1] < times[after] - ms));
        self.column(name)[nearer]
    }

    /// The last value.
    pub fn last(&self, name: &str) -> f64 {
        *self.column(name).last().unwrap()
    }

    /// Rows between two times.
    pub fn rows(&self, from: f64, to: f64) -> Range<usize> {
        let row = |ms: f64| ((ms / self.period()) as usize).min(self.column("t_ms").len());
        row(from)..row(to)
    }

    /// The time at which an axis begins to move: the last one before its position changes.
    pub fn start(&self, axis: &str) -> f64 {
        let pos = self.column(&format!("{axis}_pos"));
        let moved = pos.iter().position(|at| *at != pos[0]).unwrap_or_else(|| panic!("{axis} never moves"));
        self.column("t_ms")[moved - 1]
    }
}
