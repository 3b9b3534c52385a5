//! `--share`: others look while this program holds the link.
//!
//! In: a listener, the client that holds the link, what job it runs. Out: reads, forwarded over the
//! link, and their replies. Owns the listener and a thread. Nothing but reads of the immediate lane
//! is forwarded ([`protocol::viewer`]), and ProgramStatus not even then: the controller takes it
//! for the program's own, which sends entries again after it. It is answered with the state that
//! the program got last.
//! Fails: when the link fails, the thread ends; whoever holds the link reports it.
use crate::Failure;
use client::viewers::Viewers;
use client::{Call, Client};
use protocol::command::{ProgramReply, opcode};
use protocol::record::JobState;
use protocol::viewer::{Answered, Viewer};
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zerocopy::IntoBytes;

/// Time between two looks at the connections.
const POLL_PERIOD: Duration = Duration::from_millis(10);
/// Reads that are forwarded in a turn.
const READS_PER_POLL: usize = 4;
/// Time between two reports of the job.
const JOB_REPORT_PERIOD: Duration = Duration::from_millis(200);

/// What is known of the job.
#[derive(Debug, Clone, Default)]
pub struct Known {
    /// The program queue, as the controller reported it last.
    pub program: ProgramReply,
    /// The job, and its name.
    pub job: Option<(JobState, String)>,
}

/// The port, until it is dropped.
pub struct Share {
    known: Arc<Mutex<Known>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// Binds the port, before anything is opened: one that cannot be used is the command line's fault.
pub fn listen(address: &str) -> Result<TcpListener, Failure> {
    TcpListener::bind(address)
        .map_err(|error| Failure::Input(format!("--share {address}: cannot listen there: {error}")))
}

fn locked(known: &Mutex<Known>) -> MutexGuard<'_, Known> {
    known.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Share {
    /// Serves viewers over this client's link.
    pub fn start(listener: TcpListener, client: Arc<Client>) -> Result<Share, Failure> {
        let failed = |error| Failure::Job(format!("--share: {error}"));
        let address = listener.local_addr().map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        complain!("others may look at tcp:{address}: beamtick monitor --link tcp:{address}");
        if !address.ip().is_loopback() {
            complain!("WARNING: there is no authentication: whoever reaches tcp:{address} sees the machine");
        }
        let known = Arc::new(Mutex::new(Known::default()));
        let stop = Arc::new(AtomicBool::new(false));
        let (theirs, ends) = (Arc::clone(&known), Arc::clone(&stop));
        let thread = std::thread::spawn(move || serve(&listener, &client, &theirs, &ends));
        Ok(Share { known, stop, thread: Some(thread) })
    }

    /// What viewers are told from now on.
    pub fn publish(&self, known: Known) {
        *locked(&self.known) = known;
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn serve(listener: &TcpListener, client: &Client, known: &Mutex<Known>, stop: &AtomicBool) {
    let mut viewers = Viewers::new();
    let (mut shown, mut seen) = (Instant::now(), 0);
    let mut failed = false;
    while !stop.load(Ordering::Relaxed) && !failed {
        while let Ok((stream, _)) = listener.accept() {
            viewers.add(stream, Box::new(Viewer::new()));
        }
        viewers.turn(READS_PER_POLL, |record, out| {
            if record.opcode == opcode::ProgramStatus {
                return out.push_raw(record.opcode, record.tag, 0, &[locked(known).program.as_bytes()]).into();
            }
            let call = Call { opcode: record.opcode, payload: record.body.to_vec(), may_fail: false };
            match client.exchange(&[call]).map(|replies| replies.into_iter().next()) {
                Ok(Some((code, payload))) => out.push_raw(record.opcode, record.tag, code, &[&payload]).into(),
                Ok(None) => Answered::Later,
                Err(_) => {
                    failed = true;
                    Answered::Later
                }
            }
        });
        // One that has just come is told at once.
        let count = viewers.count();
        if count > std::mem::replace(&mut seen, count) || shown.elapsed() >= JOB_REPORT_PERIOD {
            shown = Instant::now();
            let job = locked(known).job.clone();
            if let Some((job, name)) = job {
                viewers.show_job(&job, &name);
            }
        }
        std::thread::sleep(POLL_PERIOD);
    }
}
