//! The C library `libgts`: programs written for the manuals' `gts.h`, on the Rust client.
//!
//! In: calls of three families, `GT_x(…)`, `GTN_x(core, …)` and `GT_x(cardNum, …)`, from any
//! thread. Out: return values of SPEC 3, and for each failure a reason (`GT_GetLastReason`). Owns
//! one controller for the first two families and sixteen for the third, chosen by environment
//! variables (`docs/c.md`). Fails with the codes of the client; a wrong pointer or a number that
//! does not fit is 7, with nothing sent.
//!
//! `prototype` derives every C prototype from the table of functions that job scripts use too.
//! `header` makes the headers and `exports` of it, `python` the table of the Python package,
//! `csharp` the declarations for C#, `page` docs/api.md, with the sentences of `about`. `width` is
//! the size of a `long`: the package `beamtick-gts32` builds these files with 32 bits. `boundary`
//! is the entry from C; `engine` makes requests of arguments, and arguments of replies. `card` is
//! an opened controller, `stream` the batching of PT data, `recorder` its trace files, `log` its
//! calls. `more` has the calls beyond the manuals that the library answers, `home` automatic
//! homing. `compat` serves the replacements of Windows headers, `at_exit` the end of the process.

mod at_exit;
mod board_memory;
mod boundary;
mod card;
mod compat;
mod engine;
mod exports;
mod fork;
mod log;
mod reason;
mod recorder;
mod request;
mod settings;
mod staged;
mod stream;
mod width;

pub mod about;
pub mod csharp;
pub mod header;
pub mod home;
pub mod more;
pub mod page;
pub mod prototype;
pub mod python;
