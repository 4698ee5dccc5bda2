//! The threads that the engine works on, after a fork too.

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Mutex, OnceLock, PoisonError};

/// The threads of a process that was forked from the one that has rayon's own, of which only the thread that forks goes on in its child; `None` in
/// the process that has rayon's. No thread forks meanwhile: this one has the interpreter.
fn of_fork(_: Python<'_>) -> Option<&'static ThreadPool> {
    static FIRST: OnceLock<u32> = OnceLock::new();
    static FORKED: Mutex<Option<(u32, &ThreadPool)>> = Mutex::new(None);
    let process = std::process::id();
    // Rayon's threads are started here, where no process is forked meanwhile: a child that found them half started would wait for ever.
    let first = FIRST.get_or_init(|| {
        rayon::current_num_threads();
        process
    });
    if *first == process {
        return None;
    }
    let mut forked = FORKED.lock().unwrap_or_else(PoisonError::into_inner);
    match *forked {
        Some((of, threads)) if of == process => Some(threads),
        _ => {
            // The parent's are never stopped here: nothing of them answers.
            let threads: &ThreadPool = Box::leak(Box::new(started()));
            *forked = Some((process, threads));
            Some(threads)
        }
    }
}

/// As many threads as rayon's own, and this one if it is in no pool yet, which then need not wait for another.
fn started() -> ThreadPool {
    let count = rayon::current_num_threads();
    let with_this = ThreadPoolBuilder::new().num_threads(count + 1).use_current_thread().build();
    with_this.or_else(|_| ThreadPoolBuilder::new().num_threads(count).build()).expect("a process can start threads")
}

/// Runs a call without the interpreter in its hands; its parallel parts are for the threads of this process.
pub fn released<T: Send>(py: Python<'_>, call: impl FnOnce() -> T + Send) -> T {
    let threads = of_fork(py);
    py.detach(|| match threads {
        None => call(),
        Some(threads) => threads.install(call),
    })
}
