//! Rows of numbers, one for each body of a group.

use crate::real::Real;

/// Bodies in a group: four AVX-512 registers, so that each hides the latency of the others.
pub const LANES: usize = 32;

/// One number for each body of a group.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Row(pub [f64; LANES]);

impl Row {
    pub(crate) const ZERO: Row = Row([0.0; LANES]);
}

/// The numbers of a pack that begins at a lane, of each row.
#[inline(always)]
pub(crate) fn load_rows<P: Real, const N: usize>(rows: &[Row], at: usize) -> [P; N] {
    let mut numbers = [P::splat(0.0); N];
    for k in 0..N {
        numbers[k] = P::load(&rows[k].0[at..]);
    }
    numbers
}

/// Writes the numbers of a pack that begins at a lane, into each row.
#[inline(always)]
pub(crate) fn store_rows<P: Real, const N: usize>(numbers: &[P; N], rows: &mut [Row], at: usize) {
    for k in 0..N {
        numbers[k].store(&mut rows[k].0[at..]);
    }
}

/// Sets the numbers of a lane, one in each row.
#[inline(always)]
pub(crate) fn set_lane(rows: &mut [Row], lane: usize, numbers: &[f64]) {
    // By index: pairs of iterators are not always compiled in line, which took a fifth of a map of closed forms.
    for k in 0..rows.len().min(numbers.len()) {
        rows[k].0[lane] = numbers[k];
    }
}
