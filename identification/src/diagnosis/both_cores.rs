//! Work on many items at once.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Applies `work` to every item, two at a time; results in the order of the items, without those of which it gives `None`.
pub(crate) fn on_both_cores<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> Option<R> + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut results = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(index) else { return results };
            results.extend(work(item).map(|result| (index, result)));
        }
    };
    let (mut results, more) = side_by_side(worker, worker);
    results.extend(more);
    results.sort_unstable_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// What two pieces of work give that are done at the same time.
pub(crate) fn side_by_side<A, B: Send>(one: impl FnOnce() -> A, other: impl FnOnce() -> B + Send) -> (A, B) {
    std::thread::scope(|scope| {
        let other = scope.spawn(other);
        let one = one();
        match other.join() {
            Ok(other) => (one, other),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}
