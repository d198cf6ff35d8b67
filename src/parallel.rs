//! Work over threads, and the processor time that it takes.

use crate::error::Error;
use crate::memory;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// Address space of a thread: its stack, the arena of its allocator, and what it allocates for a block.
const BYTES_OF_A_THREAD: usize = 80 << 20;

/// Does `work` for each block on at most `threads` threads, the caller's among them.
///
/// A thread that cannot be started is done without. Blocks are never listed: there may be any number of them.
///
/// # Errors
/// The first error of a block, and `Stopped` if `stop` is set before the last block: no further block is begun then.
pub fn over_blocks<B>(
    blocks: impl Iterator<Item = B> + Send,
    threads: usize,
    stop: &AtomicBool,
    work: impl Fn(B) -> Result<(), Error> + Sync,
) -> Result<(), Error> {
    let threads = threads.min(blocks.size_hint().0);
    let blocks = Mutex::new(blocks);
    let failed = AtomicBool::new(false);
    let failure = Mutex::new(None);
    let each = || {
        while !failed.load(Ordering::Relaxed) {
            let next = blocks.lock().expect("the iterator does not panic").next();
            let Some(block) = next else { break };
            if stop.load(Ordering::Relaxed) {
                return Err(Error::Stopped);
            }
            work(block)?;
        }
        Ok(())
    };
    let worker = || {
        if let Err(error) = caught(each) {
            failed.store(true, Ordering::Relaxed);
            failure.lock().expect("nothing panics here").get_or_insert(error);
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            if !memory::has_room(BYTES_OF_A_THREAD)
                || thread::Builder::new().spawn_scoped(scope, worker).is_err()
            {
                break;
            }
        }
        worker();
    });
    failure.into_inner().expect("nothing panics there").map_or(Ok(()), Err)
}

/// The result of `work`; a panic becomes an error.
pub fn caught<T>(work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|panic| Err(Error::Fault { words: words_of(&*panic) }))
}

/// What a panic says.
fn words_of(panic: &(dyn Any + Send)) -> String {
    let fixed = panic.downcast_ref::<&str>().map(|words| words.to_string());
    fixed.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

/// Nanoseconds of processor time of the calling thread (of wall time where the system has no such clock).
///
/// On a shared machine the wall clock also counts the work of other processes.
pub fn thread_nanoseconds() -> u64 {
    #[cfg(unix)]
    {
        let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: `now` is a valid timespec; on failure it stays zero.
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
    fn every_block_is_done_once() {
        let go = AtomicBool::new(false);
        for threads in [1, 2, 7, 100] {
            let mut squares = [0; 50];
            let blocks = squares.iter_mut().enumerate();
            let square = |(block, place): (usize, &mut usize)| {
                *place += block * block;
                Ok(())
            };
            over_blocks(blocks, threads, &go, square).unwrap();
            assert!(squares.iter().enumerate().all(|(block, &square)| square == block * block));
        }
    }

    #[test]
    fn blocks_after_a_stop_are_not_done() {
        let stop = AtomicBool::new(false);
        let done = Mutex::new(0);
        let ended = over_blocks(0..5, 1, &stop, |block| {
            *done.lock().unwrap() += 1;
            stop.store(block == 1, Ordering::Relaxed);
            Ok(())
        });
        assert_eq!((ended, done.into_inner().unwrap()), (Err(Error::Stopped), 2));
    }

    #[test]
    fn a_panic_in_a_thread_ends_the_work_as_an_error() {
        let go = AtomicBool::new(false);
        for threads in [1, 3] {
            // Far too many blocks to do: the others end too.
            let ended = over_blocks(0..u64::MAX, threads, &go, |block| match block {
                7 => panic!("block {block} is bad"),
                _ => Ok(()),
            });
            assert_eq!(ended, Err(Error::Fault { words: "block 7 is bad".into() }));
        }
    }
}
