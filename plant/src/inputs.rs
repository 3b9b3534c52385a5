//! A plan of inputs, which the machines without wires execute by themselves.
//!
//! In: rows in order of time, the instant of the next tick, the zero of the script clock while a
//! program runs. Out: the row that is due. Owns the rows. Rows that count from a program begin with
//! the next one that starts, and end with it. Fails never: a row without a slot is dropped; the
//! admission of rows knows how many slots there are.
use servo::port::{InputTime, Simulated};
use servo::units::Ns;

/// One row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InputRow {
    due: InputTime,
    input: Simulated,
}

impl InputRow {
    /// Content of an empty slot.
    pub const NONE: InputRow = InputRow { due: InputTime::At(Ns(0)), input: Simulated::Interlock(false) };
}

/// See the module text. `S` holds the rows.
#[derive(Debug, Clone)]
pub struct InputPlan<S> {
    rows: S,
    len: usize,
    at: usize,
    /// The zero of the program that it counts from, once that has begun.
    zero: Option<Ns>,
}

impl<S: AsRef<[InputRow]> + AsMut<[InputRow]>> InputPlan<S> {
    /// An empty plan; it holds as many rows as there are slots.
    pub const fn new(rows: S) -> Self {
        InputPlan { rows, len: 0, at: 0, zero: None }
    }

    /// The slots, to make more of them.
    pub fn slots(&mut self) -> &mut S {
        &mut self.rows
    }

    /// Stores row `row`; row 0 begins another plan.
    pub fn put(&mut self, row: u16, due: InputTime, input: Simulated) {
        if row == 0 {
            (self.len, self.at, self.zero) = (0, 0, None);
        }
        if let Some(place) = self.rows.as_mut().get_mut(row as usize) {
            *place = InputRow { due, input };
            self.len = row as usize + 1;
        }
    }

    /// The next row that is due before `next`, at most once each.
    pub fn take(&mut self, next: Ns, zero: Option<Ns>) -> Option<Simulated> {
        let row = *self.rows.as_ref().get(..self.len)?.get(self.at)?;
        let due = match row.due {
            InputTime::At(at) => at,
            InputTime::OfScript(after) => match (self.zero, zero) {
                (None, None) => return None,
                (Some(begun), now) if now != Some(begun) => {
                    // Its program is over.
                    self.len = 0;
                    return None;
                }
                (_, now) => {
                    self.zero = now;
                    Ns(now?.0.saturating_add(after.0))
                }
            },
        };
        if due.0 >= next.0 {
            return None;
        }
        self.at += 1;
        Some(row.input)
    }

    /// Ends rows that count from a program.
    pub fn forget(&mut self) {
        if matches!(self.rows.as_ref().get(self.at), Some(InputRow { due: InputTime::OfScript(_), .. })) {
            self.len = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    const fn interlock(high: bool) -> Simulated {
        Simulated::Interlock(high)
    }

    #[test]
    fn rows_come_on_the_first_tick_after_their_instant_and_once() {
        let mut plan = InputPlan::new([InputRow::NONE; 4]);
        for (row, at) in [(0, 0), (1, 100), (2, 100), (3, 250)] {
            plan.put(row, InputTime::At(Ns(at)), interlock(row & 1 == 1));
        }
        let mut taken = |next| std::iter::from_fn(|| plan.take(Ns(next), None)).count();
        assert_eq!([taken(0), taken(100), taken(200), taken(250), taken(300), taken(999)], [0, 1, 2, 0, 1, 0]);
    }

    #[test]
    fn a_row_without_a_slot_is_not_kept() {
        let mut plan = InputPlan::new([InputRow::NONE; 1]);
        plan.put(0, InputTime::At(Ns(0)), interlock(true));
        plan.put(1, InputTime::At(Ns(0)), interlock(false));
        assert_eq!((plan.take(Ns(1), None), plan.take(Ns(1), None)), (Some(interlock(true)), None));
    }

    #[test]
    fn rows_of_a_program_begin_with_it_and_end_with_it() {
        let mut plan = InputPlan::new([InputRow::NONE; 2]);
        plan.put(0, InputTime::OfScript(Ns(10)), interlock(true));
        plan.put(1, InputTime::OfScript(Ns(20)), interlock(false));
        assert_eq!(plan.take(Ns(1000), None), None);
        assert_eq!(plan.take(Ns(1010), Some(Ns(1000))), None);
        assert_eq!(plan.take(Ns(1011), Some(Ns(1000))), Some(interlock(true)));
        // The next program is another one.
        assert_eq!(plan.take(Ns(2000), None), None);
        assert_eq!(plan.take(Ns(3000), Some(Ns(2000))), None);
        // And so is the next session.
        plan.put(0, InputTime::OfScript(Ns(10)), interlock(true));
        plan.forget();
        assert_eq!(plan.take(Ns(3000), Some(Ns(2000))), None);
        plan.put(0, InputTime::At(Ns(10)), interlock(true));
        plan.forget();
        assert_eq!(plan.take(Ns(3000), None), Some(interlock(true)));
    }
}
