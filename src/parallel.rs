//! Work over threads, and the processor time that it takes.
//!
//! No pool and nothing shared: the results are returned in the order of the blocks.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Does `work` for each block 0 .. `blocks` on `threads` threads, the caller's among them.
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

/// Nanoseconds of processor time of the calling thread (of wall time where the system has no such clock).
///
/// On a shared machine the wall clock also counts the work of other processes.
pub fn thread_nanoseconds() -> u64 {
    #[cfg(unix)]
    {
        let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // Safety: `now` is a valid timespec; on failure it stays zero.
        unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut now) };
        now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
    }
    #[cfg(not(unix))]
    {
        use std::sync::OnceLock;
        use std::time::Instant;
        static START: OnceLock<Instant> = OnceLock::new();
        START.get_or_init(Instant::now).elapsed().as_nanos() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_blocks() {
        let go = AtomicBool::new(false);
        for threads in [1, 2, 7, 100] {
            let squares = over_blocks(50, threads, &go, |block| block * block);
            assert!(squares.into_iter().enumerate().all(|(block, square)| square == Some(block * block)));
        }
    }

    #[test]
    fn blocks_after_a_stop_are_not_done() {
        let stop = AtomicBool::new(false);
        let done = over_blocks(5, 1, &stop, |block| stop.store(block == 1, Ordering::Relaxed));
        assert_eq!(done, [Some(()), Some(()), None, None, None]);
    }
}
