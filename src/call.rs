//! How a call is computed.

use crate::parallel::Interrupt;
use crate::simd::Isa;

/// The instruction set of a call, its threads, and the wish that it ends.
#[derive(Clone, Copy)]
pub struct Call<'a> {
    /// The instruction set of the kernels.
    pub isa: Isa,
    /// The largest number of threads.
    pub threads: usize,
    /// Asked by all threads between blocks of steps.
    pub stop: &'a Interrupt<'a>,
}

impl Call<'_> {
    /// A call that goes on to its end.
    pub fn to_the_end(isa: Isa, threads: usize) -> Call<'static> {
        static NEVER: Interrupt<'static> = Interrupt::never();
        Call { isa, threads, stop: &NEVER }
    }
}
