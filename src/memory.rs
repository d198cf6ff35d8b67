//! Memory whose size a caller chooses: reserved before the work begins, or refused with its number of bytes.
//!
//! An allocation that fails without `try_reserve` ends the process, and the interpreter with it.

use crate::error::Error;
use bytemuck::Zeroable;
use bytemuck::allocation::try_zeroed_vec;
use std::cell::Cell;
use std::hint::black_box;
use std::mem::MaybeUninit;
use std::sync::OnceLock;

/// Refuses what does not fit into this machine, before the system promises memory that it does not have.
pub fn check(what: &str, bytes: u128) -> Result<(), Error> {
    match machine() {
        Some(limit) if bytes > u128::from(limit) => {
            Err(Error::Memory { what: what.into(), bytes, limit: Some(limit) })
        }
        _ => Ok(()),
    }
}

/// An empty vector with room for this many elements.
pub fn reserved<T>(what: &str, length: usize) -> Result<Vec<T>, Error> {
    let bytes = length as u128 * size_of::<T>() as u128;
    check(what, bytes)?;
    let mut values = Vec::new();
    let refused = |_| Error::Memory { what: what.into(), bytes, limit: None };
    values.try_reserve_exact(length).map_err(refused)?;
    Ok(values)
}

/// The same element this many times.
pub fn filled<T: Clone>(what: &str, length: usize, value: T) -> Result<Vec<T>, Error> {
    let mut values = reserved(what, length)?;
    values.resize(length, value);
    Ok(values)
}

/// Zeros. The system provides their pages when they are first written, so that nothing is written twice.
pub fn zeros<T: Zeroable>(what: &str, length: usize) -> Result<Vec<T>, Error> {
    let bytes = length as u128 * size_of::<T>() as u128;
    check(what, bytes)?;
    try_zeroed_vec(length).map_err(|()| Error::Memory { what: what.into(), bytes, limit: None })
}

/// The elements of an iterator, which has this many.
pub fn collected<T>(what: &str, length: usize, from: impl IntoIterator<Item = T>) -> Result<Vec<T>, Error> {
    let mut values = reserved(what, length)?;
    values.extend(from.into_iter().take(length));
    Ok(values)
}

/// Appends an element to a list whose length is not known beforehand.
pub fn push<T>(what: &str, list: &mut Vec<T>, element: T) -> Result<(), Error> {
    room(what, list, 1)?;
    list.push(element);
    Ok(())
}

/// Makes room for more elements of a list.
pub fn room<T>(what: &str, list: &mut Vec<T>, more: usize) -> Result<(), Error> {
    let bytes = (list.len() as u128 + more as u128) * size_of::<T>() as u128;
    list.try_reserve(more).map_err(|_| Error::Memory { what: what.into(), bytes, limit: None })
}

/// Whether as many bytes can be had now.
pub fn has_room(bytes: usize) -> bool {
    Vec::<u8>::new().try_reserve_exact(bytes).is_ok()
}

/// Bytes of its stack that the calling thread may need for work of the core.
const STACK: usize = 512 << 10;

/// Grows the stack of the calling thread, once. A refusal of the system is an error now; later it would end the process.
///
/// # Errors
/// If the memory cannot be had.
pub fn grow_stack() -> Result<(), Error> {
    thread_local! {
        static GROWN: Cell<bool> = const { Cell::new(false) };
    }
    if GROWN.get() {
        return Ok(());
    }
    if !has_room(2 * STACK) {
        let what = "stack of the calling thread".into();
        return Err(Error::Memory { what, bytes: STACK as u128, limit: None });
    }
    touch_stack();
    GROWN.set(true);
    Ok(())
}

/// The compiler touches each page of a large frame.
#[inline(never)]
fn touch_stack() {
    black_box(&mut MaybeUninit::<[u8; STACK]>::uninit());
}

/// Bytes of memory of this machine, or of the control groups of this process if that is less; `None` if unknown.
fn machine() -> Option<u64> {
    static LIMIT: OnceLock<Option<u64>> = OnceLock::new();
    *LIMIT.get_or_init(|| [physical(), control_groups()].into_iter().flatten().min())
}

#[cfg(all(unix, not(miri)))]
fn physical() -> Option<u64> {
    // SAFETY: `sysconf` reads a number of the system and has no other effect.
    let [pages, size] = [libc::_SC_PHYS_PAGES, libc::_SC_PAGESIZE].map(|name| unsafe { libc::sysconf(name) });
    u64::try_from(pages).ok()?.checked_mul(u64::try_from(size).ok()?).filter(|&bytes| bytes > 0)
}

#[cfg(any(not(unix), miri))]
fn physical() -> Option<u64> {
    None
}

/// The least limit of the control groups (version 2) of this process, as of a container.
fn control_groups() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let root = std::path::Path::new("/sys/fs/cgroup");
    let path = root.join(own);
    let limit = |folder| std::fs::read_to_string(std::path::Path::join(folder, "memory.max")).ok();
    path.ancestors()
        .take_while(|folder| folder.starts_with(root))
        .filter_map(|folder| limit(folder)?.trim().parse().ok())
        .min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_beyond_any_memory_is_refused_with_its_bytes() {
        for length in [1_usize << 50, usize::MAX] {
            for refused in [reserved::<f64>("the result", length), zeros::<f64>("the result", length)] {
                let message = refused.unwrap_err().to_string();
                let start = format!("the result: {} bytes", 8 * length as u128);
                assert!(message.starts_with(&start), "{message}");
            }
        }
        assert!(check("the result", u128::MAX).is_err());
        assert!(!has_room(usize::MAX));
    }

    #[test]
    fn what_fits_is_reserved_exactly() {
        let values = collected("the input", 3, [1.0, 2.0, 3.0]).unwrap();
        assert_eq!((values.as_slice(), values.capacity()), ([1.0, 2.0, 3.0].as_slice(), 3));
        assert_eq!(filled("the result", 2, 7_u8).unwrap(), [7, 7]);
        assert_eq!(
            (zeros("the result", 2).unwrap(), zeros("nothing", 0).unwrap()),
            (vec![0.0_f32; 2], vec![0.0_f64; 0])
        );
        let mut list = values;
        push("the list", &mut list, 4.0).unwrap();
        assert_eq!(list, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn a_machine_has_memory() {
        assert!(machine().is_none_or(|bytes| bytes > 1 << 20));
    }
}
