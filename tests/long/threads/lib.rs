//! The loop over blocks without the kernels, to be compiled with ThreadSanitizer and the standard library in minutes:
//!
//! ```sh
//! cd tests/long/threads
//! RUSTFLAGS=-Zsanitizer=thread cargo +nightly test -Zbuild-std --target x86_64-unknown-linux-gnu
//! ```

#[path = "../../../src/error.rs"]
pub mod error;
#[path = "../../../src/memory.rs"]
pub mod memory;
#[path = "../../../src/parallel.rs"]
pub mod parallel;

#[cfg(test)]
mod tests {
    use crate::parallel::{Interrupt, over_blocks};
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// Blocks write to parts of one array and merge into shared numbers, as runs and maps do.
    #[test]
    fn blocks_on_eight_threads_race_for_nothing() {
        let go = Interrupt::never();
        for _ in 0..10 {
            let mut states = vec![0_u64; 512];
            let (steps, all) = (AtomicU64::new(0), Mutex::new(0));
            over_blocks(states.chunks_mut(8).enumerate(), 8, &go, |(block, part)| {
                part.fill(block as u64);
                steps.fetch_add(part.len() as u64, Ordering::Relaxed);
                *all.lock().unwrap() += part.iter().sum::<u64>();
                Ok(())
            })
            .unwrap();
            assert_eq!((steps.into_inner(), all.into_inner().unwrap()), (512, states.iter().sum()));
            assert!(states.iter().enumerate().all(|(at, &state)| state == at as u64 / 8));
        }
    }

    /// A stop and an error on one thread end the others.
    #[test]
    fn a_stop_from_another_thread_is_seen() {
        for _ in 0..10 {
            let (stop, done) = (Interrupt::never(), AtomicU64::new(0));
            let ended = over_blocks(0..u64::MAX, 8, &stop, |_| {
                if done.fetch_add(1, Ordering::Relaxed) == 100 {
                    stop.request();
                }
                Ok(())
            });
            assert!(ended.is_err());
        }
    }
}
