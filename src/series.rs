//! Coefficients of power series in time, lowest order first, in uninitialised memory.

use crate::kinematics::put;
use crate::real::Real;
use std::mem::MaybeUninit;

/// The highest order of any series; `method` checks it.
pub const MAX_ORDER: usize = 26;

/// 1 / k.
pub const INVERSE: [f64; MAX_ORDER + 1] = {
    let mut inverse = [0.0; MAX_ORDER + 1];
    let mut k = 1;
    while k <= MAX_ORDER {
        inverse[k] = 1.0 / k as f64;
        k += 1;
    }
    inverse
};

/// Coefficients of a state, lowest order first, in uninitialised memory.
pub struct Coefficients<R, const D: usize> {
    rows: [MaybeUninit<[R; D]>; MAX_ORDER + 1],
    known: usize,
}

impl<R: Real, const D: usize> Coefficients<R, D> {
    /// No coefficients yet.
    #[inline(always)]
    #[allow(clippy::new_without_default)] // A default would be taken for zero.
    pub fn new() -> Self {
        Coefficients { rows: [const { MaybeUninit::uninit() }; MAX_ORDER + 1], known: 0 }
    }

    /// Forgets all coefficients.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.known = 0;
    }

    /// Writes the coefficients of the next order.
    #[inline(always)]
    pub fn push(&mut self, row: [R; D]) {
        self.rows[self.known].write(row);
        self.known += 1;
    }

    /// The highest order known.
    #[inline(always)]
    pub fn highest(&self) -> usize {
        self.known - 1
    }

    /// Replaces the coefficients of one order of neighbouring numbers.
    #[inline(always)]
    pub fn set(&mut self, k: usize, first: usize, numbers: [R; 6]) {
        assert!(k < self.known);
        // SAFETY: `push` has written all rows below `known`.
        put(unsafe { self.rows[k].assume_init_mut() }, first, numbers);
    }

    /// The coefficients of all orders known.
    #[inline(always)]
    pub fn all(&self) -> &[[R; D]] {
        let rows = &self.rows[..self.known];
        // SAFETY: `push` has written all rows below `known`; an initialised row has the layout of its type.
        unsafe { &*(std::ptr::from_ref(rows) as *const [[R; D]]) }
    }

    /// The coefficients of one order.
    #[inline(always)]
    pub fn order(&self, k: usize) -> &[R; D] {
        assert!(k < self.known);
        // SAFETY: `push` has written all rows below `known`.
        unsafe { self.rows[k].assume_init_ref() }
    }
}

/// Coefficients of a vector beside the state, in memory that nobody has to clear.
///
/// Without the counter of `Coefficients`, which would cost time here: only builds with debug assertions count.
pub struct VectorSeries<R> {
    rows: [MaybeUninit<[R; 3]>; MAX_ORDER + 1],
    #[cfg(debug_assertions)]
    known: usize,
}

impl<R: Real> VectorSeries<R> {
    /// No coefficients yet.
    #[inline(always)]
    #[allow(clippy::new_without_default)] // As above.
    pub fn new() -> Self {
        VectorSeries {
            rows: [const { MaybeUninit::uninit() }; MAX_ORDER + 1],
            #[cfg(debug_assertions)]
            known: 0,
        }
    }

    /// Writes the row of order k, the one after those that are known.
    #[inline(always)]
    pub fn push(&mut self, k: usize, row: [R; 3]) {
        #[cfg(debug_assertions)]
        {
            assert_eq!(k, self.known, "one call an order, ascending");
            self.known += 1;
        }
        self.rows[k].write(row);
    }

    /// The row of one order.
    ///
    /// # Safety
    /// The row has been pushed.
    #[inline(always)]
    pub unsafe fn order(&self, k: usize) -> &[R; 3] {
        #[cfg(debug_assertions)]
        assert!(k < self.known, "order {k} is not known");
        // SAFETY: the caller's promise.
        unsafe { self.rows[k].assume_init_ref() }
    }
}
