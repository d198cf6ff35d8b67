//! Rows of numbers, one for each body of a group.

/// Bodies in a group: four AVX-512 registers, so that each hides the latency of the others.
pub const LANES: usize = 32;

/// One number for each body of a group.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Row(pub [f64; LANES]);

impl Row {
    pub(crate) const ZERO: Row = Row([0.0; LANES]);
}
