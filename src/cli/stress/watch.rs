//! A watch over a device that may hang.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Ends the program where what is expected takes too long: a device that hangs can't be asked to stop.
pub(super) struct Watch(Arc<Mutex<(Instant, String)>>);

impl Watch {
    /// From now on.
    pub(super) fn new(limit: Duration) -> Self {
        let state = Arc::new(Mutex::new((Instant::now(), String::new())));
        let watched = Arc::clone(&state);
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(Duration::from_millis(200));
                let (since, what) = watched.lock().unwrap_or_else(PoisonError::into_inner).clone();
                if since.elapsed() > limit {
                    eprintln!("error: {what}: no answer for {} s (--limit)", limit.as_secs());
                    std::process::exit(1);
                }
            }
        });
        Self(state)
    }

    /// Says what is next, and starts the clock anew.
    pub(super) fn expect(&self, what: String) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = (Instant::now(), what);
    }
}
