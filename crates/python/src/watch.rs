//! Long computations: the interpreter goes on beside them, and can end them.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread::scope;
use std::time::Duration;

use ahrs_rs_batch::threads::{Watch, contained};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How often the interpreter looks after a computation: Ctrl-C is to work within a second.
const INTERVAL: Duration = Duration::from_millis(100);

/// Samples of a streaming filter that are computed before anybody could press a key: a tenth of a second at most.
const SHORT: usize = 200_000;

/// Does the work without the interpreter's lock, and gives what it gave. `samples` says how much it is; where it is much,
/// signals are handled meanwhile and `progress` is called with the count of what is finished. An exception of either stops
/// the work, and is given beside what came of it.
pub fn watched<R: Send>(
    py: Python<'_>,
    samples: usize,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> R + Send,
) -> PyResult<(R, Option<PyErr>)> {
    let watch = Watch::default();
    // A panic of a worker is an exception here.
    let work = || contained(|| work(&watch));
    let (result, error) = if samples < SHORT && progress.is_none() {
        (py.detach(work), None)
    } else {
        let progress = progress.map(|progress| progress.clone().unbind());
        py.detach(|| {
            scope(|scope| {
                let (sender, receiver) = channel::<()>();
                let worker = scope.spawn(|| {
                    let result = work();
                    // The receiver lives as long as the scope.
                    drop(sender);
                    result
                });
                let mut error = None;
                let look = |error: &mut Option<PyErr>| {
                    if error.is_none() {
                        *error = look(progress.as_ref(), watch.count()).err();
                        if error.is_some() {
                            watch.stop();
                        }
                    }
                };
                while let Err(RecvTimeoutError::Timeout) = receiver.recv_timeout(INTERVAL) {
                    look(&mut error);
                }
                look(&mut error);
                (worker.join().unwrap_or_else(|_| Err(String::new())), error)
            })
        })
    };
    match result {
        // What a part of the work said that panicked comes after an exception that has stopped it.
        Ok(result) => Ok((result, error.or_else(|| watch.panicked().map(panicked)))),
        Err(text) => Err(panicked(text)),
    }
}

/// The exception for a panic, which is a fault of ours.
pub fn panicked(text: impl std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(format!("this is a fault of ahrs_rs: a filter panicked: {text}"))
}

fn look(progress: Option<&Py<PyAny>>, count: usize) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        progress.map_or(Ok(()), |progress| progress.call1(py, (count,)).map(drop))
    })
}
