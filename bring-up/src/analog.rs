//! Analog outputs read back by analog inputs, through jumpers 7 and 8.
//!
//! In: a bench. Out: lines `loop OUTPUT CODE FIRST SETTLED`, in the tick's codes: what the input
//! says in the second tick after the step, and 12 ticks later. Owns nothing. The converter has been
//! calibrated in the ticks before.
use crate::bench::Bench;
use crate::report::Report;

/// Ticks in which a voltage settles.
const SETTLE: u32 = 12;
/// Codes of the output that the buffered pin reaches: 20 to 80 % of the reference.
const CODES: [i16; 4] = [-19_000, 19_000, -8_000, 8_000];

/// Both loops.
pub fn report_to(bench: &mut Bench, report: &mut Report) {
    for output in 0..2 {
        for code in CODES {
            bench.volts(output, code);
            // Out at the second tick, sampled until the fourth.
            bench.ticks(4);
            let first = bench.analog(output);
            bench.ticks(SETTLE);
            report.line("loop", &[output as i64 + 1, code.into(), first, bench.analog(output)]);
        }
        bench.volts(output, 0);
        bench.ticks(2);
    }
}
