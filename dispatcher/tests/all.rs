//! One program for all tests of this folder: the tick is generic, and each program would compile it
//! again. `every_file_is_run` in `folders.rs` holds that no file is missing here.
mod bench;
#[path = "../../servo/tests/chance/mod.rs"]
mod chance;
mod crd;
mod crd_ahead;
mod crd_refused;
mod data_lost;
#[allow(dead_code, reason = "the tests of servo use all of it")]
#[path = "../../servo/tests/drive/mod.rs"]
mod drive;
mod folders;
mod follow;
mod follow_masters;
mod follow_run;
mod gear;
mod laser;
mod laser_channel;
mod laser_faults;
mod laser_follow;
mod laser_owner;
mod laser_path;
mod laser_state;
mod laser_tables;
mod look_speeds;
mod lookahead;
mod one_instant;
mod path_many;
mod products;
mod program;
mod program_data;
mod program_ends;
mod pvt;
mod refusals;
mod sessions;
mod step_limit;
mod tables_bench;
mod tables_exact;
mod tables_golden;
mod tables_refused;
