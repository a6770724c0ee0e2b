//! Work on many items at once.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Applies `work` to every item, two at a time; what gives `None` is left out.
pub(crate) fn on_both_cores<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> Option<R> + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut results = Vec::new();
        while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
            results.extend(work(item));
        }
        results
    };
    std::thread::scope(|scope| {
        let other = scope.spawn(worker);
        let mut results = worker();
        match other.join() {
            Ok(more) => results.extend(more),
            Err(panic) => std::panic::resume_unwind(panic),
        }
        results
    })
}
