//! Work over threads, and the processor time that it takes.

use crate::error::Error;
use crate::float_environment::FloatEnvironment;
use crate::memory;
use std::any::Any;
use std::cell::Cell;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

/// Address space of a thread: its stack, the arena of its allocator, and what it allocates for a block.
const BYTES_OF_A_THREAD: usize = 80 << 20;

/// How often the caller is asked whether its work shall stop.
const BETWEEN_QUESTIONS: Duration = Duration::from_millis(50);

/// The parts of a body in which work is counted.
const PARTS: f64 = (1_u64 << 20) as f64;

/// The wish that running work ends. All threads of the work read it between blocks of steps, and tell what is done.
pub struct Interrupt<'a> {
    wanted: AtomicBool,
    watch: Option<Watch<'a>>,
    /// Parts of bodies whose work is done.
    done: AtomicU64,
    /// All bodies; 0 if nobody counts.
    bodies: AtomicUsize,
    /// Bodies that are done in the end.
    most: AtomicUsize,
}

/// A question whether work shall stop, which only one thread may ask; the question tells the share that is done.
struct Watch<'a> {
    ask: &'a (dyn Fn(f64) -> bool + Sync),
    thread: ThreadId,
    begin: Instant,
    /// Nanoseconds after `begin` at which the question is asked again.
    next: AtomicU64,
}

impl<'a> Interrupt<'a> {
    /// Work that goes on to its end, unless `request` is called.
    pub const fn never() -> Interrupt<'a> {
        Interrupt::with(None)
    }

    /// Work that stops when `ask` returns true. The calling thread asks twenty times a second, in between its work.
    pub fn when(ask: &'a (dyn Fn(f64) -> bool + Sync)) -> Interrupt<'a> {
        let next = AtomicU64::new(BETWEEN_QUESTIONS.as_nanos() as u64);
        let watch = Watch { ask, thread: thread::current().id(), begin: Instant::now(), next };
        Interrupt::with(Some(watch))
    }

    const fn with(watch: Option<Watch<'a>>) -> Interrupt<'a> {
        let (done, bodies, most) = (AtomicU64::new(0), AtomicUsize::new(0), AtomicUsize::new(0));
        Interrupt { wanted: AtomicBool::new(false), watch, done, bodies, most }
    }

    /// This part of so many bodies follows: those before it are done.
    pub fn expect(&self, bodies: usize, part: Range<usize>) {
        self.bodies.store(bodies, Ordering::Relaxed);
        self.most.store(part.end, Ordering::Relaxed);
        self.tell(part.start as f64);
    }

    /// So many bodies more are done, or a share of one.
    pub fn tell(&self, bodies: f64) {
        if bodies > 0.0 {
            self.done.fetch_add((bodies * PARTS) as u64, Ordering::Relaxed);
        }
    }

    /// The share of the work that is done; 0 if it is not known.
    fn share(&self) -> f64 {
        let all = self.bodies.load(Ordering::Relaxed) as f64 * PARTS;
        let most = self.most.load(Ordering::Relaxed) as f64 * PARTS;
        let done = (self.done.load(Ordering::Relaxed) as f64).min(most);
        if all > 0.0 { done / all } else { 0.0 }
    }

    /// Ends the work.
    pub fn request(&self) {
        self.wanted.store(true, Ordering::Relaxed);
    }

    /// Whether the work shall end. To be called more often than every tenth of a second.
    pub fn is_wanted(&self) -> bool {
        if let Some(watch) = &self.watch
            && watch.is_due()
            && (watch.ask)(self.share())
        {
            self.request();
        }
        self.wanted.load(Ordering::Relaxed)
    }
}

impl Watch<'_> {
    fn is_due(&self) -> bool {
        if thread::current().id() != self.thread {
            return false;
        }
        let now = self.begin.elapsed();
        let due = now.as_nanos() as u64 >= self.next.load(Ordering::Relaxed);
        if due {
            self.next.store((now + BETWEEN_QUESTIONS).as_nanos() as u64, Ordering::Relaxed);
        }
        due
    }
}

/// Does `work` for each block on at most `threads` threads, the caller's among them; returns the nanoseconds of
/// processor time of all threads.
///
/// With a single block or a single thread no thread is started. A thread that cannot be started is done without. Blocks
/// are never listed: there may be any number of them.
///
/// # Errors
/// The first error of a block, and `Stopped` if `stop` is wanted before the last block: no further block is begun then.
pub fn over_blocks<B>(
    blocks: impl Iterator<Item = B> + Send,
    threads: usize,
    stop: &Interrupt,
    work: impl Fn(B) -> Result<(), Error> + Sync,
) -> Result<u64, Error> {
    let threads = threads.min(blocks.size_hint().0);
    let blocks = Mutex::new(blocks);
    let failed = AtomicBool::new(false);
    let failure = Mutex::new(None);
    let each = || {
        while !failed.load(Ordering::Relaxed) {
            let next = blocks.lock().expect("the iterator does not panic").next();
            let Some(block) = next else { break };
            if stop.is_wanted() {
                return Err(Error::Stopped);
            }
            work(block)?;
        }
        Ok(())
    };
    let nanoseconds = AtomicU64::new(0);
    let worker = || {
        let begin = thread_nanoseconds();
        if let Err(error) = caught(each) {
            failed.store(true, Ordering::Relaxed);
            failure.lock().expect("nothing panics here").get_or_insert(error);
        }
        nanoseconds.fetch_add(thread_nanoseconds() - begin, Ordering::Relaxed);
    };
    if threads < 2 {
        worker();
    } else {
        over_threads(threads, stop, &worker);
    }
    failure.into_inner().expect("nothing panics there").map_or(Ok(nanoseconds.into_inner()), Err)
}

/// Runs `worker` on that many threads, the caller's among them. When the caller's part is done, it still asks whether
/// the others shall stop.
fn over_threads(threads: usize, stop: &Interrupt, worker: &(impl Fn() + Sync)) {
    let (caller, running, call) = (thread::current(), AtomicUsize::new(0), owner());
    thread::scope(|scope| {
        for _ in 1..threads {
            running.fetch_add(1, Ordering::Relaxed);
            let other = || {
                owned(call, worker);
                running.fetch_sub(1, Ordering::Relaxed);
                caller.unpark();
            };
            let has_room = memory::has_room(BYTES_OF_A_THREAD);
            if !has_room || thread::Builder::new().spawn_scoped(scope, other).is_err() {
                running.fetch_sub(1, Ordering::Relaxed);
                break;
            }
        }
        worker();
        while running.load(Ordering::Relaxed) > 0 {
            thread::park_timeout(BETWEEN_QUESTIONS);
            stop.is_wanted();
        }
    });
}

thread_local! {
    static OWNER: Cell<u64> = const { Cell::new(0) };
}

/// The number of the call for which this thread works, 0 for none.
pub fn owner() -> u64 {
    OWNER.get()
}

/// Does `work` for the call of that number, in this thread and in those that it starts.
pub fn owned<T>(owner: u64, work: impl FnOnce() -> T) -> T {
    let before = OWNER.replace(owner);
    let result = work();
    OWNER.set(before);
    result
}

/// Does `work` on another thread, while the caller asks whether `work` shall stop; in the caller's thread where no other
/// can be started.
///
/// A function of Python that `work` calls in the thread of the caller would handle the signals, and lose what their
/// handlers raise.
pub fn in_another_thread<T: Send>(
    stop: &Interrupt,
    work: impl FnOnce() -> Result<T, Error> + Send,
) -> Result<T, Error> {
    let (caller, work, result) = (thread::current(), Mutex::new(Some(work)), Mutex::new(None));
    let once = || {
        let work = work.lock().expect("nothing panics here").take();
        *result.lock().expect("nothing panics here") = work.map(caught);
    };
    thread::scope(|scope| {
        let other = || {
            once();
            caller.unpark();
        };
        let has_room = memory::has_room(BYTES_OF_A_THREAD);
        match has_room.then(|| thread::Builder::new().spawn_scoped(scope, other)) {
            Some(Ok(other)) => {
                while !other.is_finished() {
                    thread::park_timeout(BETWEEN_QUESTIONS);
                    stop.is_wanted();
                }
            }
            _ => once(),
        }
    });
    result.into_inner().expect("nothing panics there").expect("the work was done")
}

/// The result of `work` in the standard floating-point environment; a panic becomes an error.
pub fn caught<T>(work: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    let _standard = FloatEnvironment::standard();
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
    #[cfg(all(unix, not(miri)))]
    {
        let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: `now` is a valid timespec; on failure it stays zero.
        unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut now) };
        now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
    }
    #[cfg(any(not(unix), miri))]
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
        let go = Interrupt::never();
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
        let stop = Interrupt::never();
        let done = Mutex::new(0);
        let ended = over_blocks(0..5, 1, &stop, |block| {
            *done.lock().unwrap() += 1;
            if block == 1 {
                stop.request();
            }
            Ok(())
        });
        assert_eq!((ended, done.into_inner().unwrap()), (Err(Error::Stopped), 2));
    }

    #[test]
    fn a_panic_in_a_thread_ends_the_work_as_an_error() {
        let go = Interrupt::never();
        for threads in [1, 3] {
            // Far too many blocks to do: the others end too.
            let ended = over_blocks(0..u64::MAX, threads, &go, |block| match block {
                7 => panic!("block {block} is bad"),
                _ => Ok(()),
            });
            assert_eq!(ended, Err(Error::Fault { words: "block 7 is bad".into() }));
        }
    }

    #[test]
    fn the_caller_is_asked_while_other_threads_work() {
        let (questions, other_runs) = (AtomicUsize::new(0), AtomicBool::new(false));
        let ask = |_| questions.fetch_add(1, Ordering::Relaxed) == 1;
        let stop = Interrupt::when(&ask);
        let caller = thread::current().id();
        let wait = || thread::sleep(Duration::from_millis(1));
        over_blocks(0..2, 2, &stop, |_| {
            if thread::current().id() == caller {
                while !other_runs.load(Ordering::Relaxed) {
                    wait();
                }
            } else {
                other_runs.store(true, Ordering::Relaxed);
                while !stop.is_wanted() {
                    wait();
                }
            }
            Ok(())
        })
        .unwrap();
        assert_eq!(questions.into_inner(), 2);
    }

    #[test]
    fn the_caller_is_asked_while_its_work_is_done_apart() {
        let caller = thread::current().id();
        let asked = AtomicBool::new(false);
        let ask = |_| !asked.swap(true, Ordering::Relaxed);
        let stop = Interrupt::when(&ask);
        let worker = in_another_thread(&stop, || {
            while !stop.is_wanted() {
                thread::sleep(Duration::from_millis(1));
            }
            Ok(thread::current().id())
        });
        assert!(worker.is_ok_and(|worker| worker != caller));
        let fault = in_another_thread(&stop, || -> Result<(), Error> { panic!("it is bad") });
        assert_eq!(fault, Err(Error::Fault { words: "it is bad".into() }));
    }

    #[test]
    fn a_question_tells_the_share_that_is_done() {
        let told = Mutex::new(Vec::new());
        let ask = |share| {
            told.lock().unwrap().push(share);
            false
        };
        let stop = Interrupt::when(&ask);
        for (bodies, more) in [(4, 1.0), (4, 0.5), (4, f64::NAN), (4, 99.0)] {
            stop.expect(bodies, 0..bodies);
            stop.tell(more);
            thread::sleep(BETWEEN_QUESTIONS);
            stop.is_wanted();
        }
        assert_eq!(told.into_inner().unwrap(), [0.25, 0.375, 0.375, 1.0]);
    }

    #[test]
    fn one_thread_or_one_block_is_the_caller() {
        let caller = thread::current().id();
        for (blocks, threads) in [(5, 1), (1, 5)] {
            let same = |_| (thread::current().id() == caller).then_some(()).ok_or(Error::Stopped);
            over_blocks(0..blocks, threads, &Interrupt::never(), same).unwrap();
        }
    }
}
