//! The memory of a virtual controller, which ends with it.
//!
//! Owns what a board of its own would have as its RAM. It is freed once nothing refers to the
//! controller any more: at Close, or, where another thread still waits in its time, at a later Open
//! or Close.

use std::sync::{Arc, Mutex, PoisonError};
use virtual_board::{Config, Controller, Memory, Shared, share};

/// A virtual controller and its memory.
pub struct Virtual {
    /// The controller; nothing only while it is being freed.
    shared: Option<Shared>,
    memory: *mut Memory,
}

// SAFETY: the memory is referred to by the controller alone, and that may change threads.
unsafe impl Send for Virtual {}

/// Those that somebody still refers to.
static RETIRED: Mutex<Vec<Virtual>> = Mutex::new(Vec::new());

impl Virtual {
    /// A controller at power-on.
    pub fn new(config: Config) -> Virtual {
        let memory = Box::into_raw(Box::new(Memory::new(config)));
        // SAFETY: it is freed in `retire` alone, after the controller, which nothing else refers to
        // then.
        let controller = Controller::on(unsafe { &mut *memory });
        Virtual { shared: Some(share(controller)), memory }
    }

    /// The controller, for a link.
    pub fn shared(&self) -> Option<Shared> {
        self.shared.clone()
    }

    /// Frees it, unless somebody refers to it: then it is given back.
    fn free(mut self) -> Option<Virtual> {
        match Arc::try_unwrap(self.shared.take()?) {
            Ok(controller) => {
                drop(controller);
                // SAFETY: it came from a box, the controller on it is gone, and this is the only
                // owner.
                drop(unsafe { Box::from_raw(self.memory) });
                None
            }
            Err(shared) => Some(Virtual { shared: Some(shared), ..self }),
        }
    }
}

/// Frees a controller that was closed, now or later, and those before it.
pub fn retire(closed: Option<Virtual>) {
    let mut retired = RETIRED.lock().unwrap_or_else(PoisonError::into_inner);
    retired.extend(closed);
    let all = std::mem::take(&mut *retired);
    retired.extend(all.into_iter().filter_map(Virtual::free));
}
