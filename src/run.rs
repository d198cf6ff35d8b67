//! Blocks over threads: no pool, nothing shared, results in the order of the blocks.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Does `work` for each block 0 .. `blocks` on that many threads, the caller's among them.
///
/// Stops before the next block once `stop` is set; the blocks not done are then `None`.
pub fn over_blocks<T: Send>(
    blocks: usize,
    threads: usize,
    stop: &AtomicBool,
    work: impl Fn(usize) -> T + Sync,
) -> Vec<Option<T>> {
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<T>>> = Mutex::new((0..blocks).map(|_| None).collect());
    let worker = || {
        while !stop.load(Ordering::Relaxed) {
            let block = next.fetch_add(1, Ordering::Relaxed);
            if block >= blocks {
                break;
            }
            let result = work(block);
            results.lock().expect("no thread panics while it holds the results")[block] = Some(result);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.min(blocks) {
            scope.spawn(worker);
        }
        worker();
    });
    results.into_inner().expect("no thread panics while it holds the results")
}
