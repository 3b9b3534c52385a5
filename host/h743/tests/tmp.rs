use h743::*;
use h743::link::*;
use std::sync::*;
#[test]
fn late() {
    let elf = std::fs::read(std::env::var_os("BEAMTICK_H743_IMAGE").unwrap()).unwrap();
    for job in std::env::var("JOBS").unwrap().split(' ') {
        for trace in [false, true] {
            let mut m = Machine::new().unwrap();
            m.boot(&elf).unwrap();
            for pin in ["PE15", "PE3", "PG2"] { m.drive(Pin::named(pin).unwrap(), Some(false)); }
            m.run(20 * MILLISECOND);
            let m = Arc::new(Mutex::new(m));
            println!("--- {job} trace {trace}");
            let path = format!("/tmp/target-gts/jobs/{job}.gts");
            let mut words = vec![&*path, "--quiet", "--tick-us", "250"];
            if trace { words.extend(["--trace", "/tmp/target-gts/jobs/o.csv"]); }
            beamtick::run_over(Box::new(EmulatedLink::new(m.clone())), &words).unwrap();
        }
    }
}
