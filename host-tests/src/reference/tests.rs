//! The reference by hand: sentences of SPEC 5 and what must follow.
