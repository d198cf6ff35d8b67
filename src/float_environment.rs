//! The floating-point environment of a thread: rounding mode, flushing of subnormal numbers, traps.
//!
//! Another library may leave the processor rounding upwards, or flushing subnormal numbers to zero, as code that was
//! compiled with `-ffast-math` does when it is loaded. Every result would follow.

use std::marker::PhantomData;

#[cfg(all(target_arch = "x86_64", not(miri)))]
mod control {
    use std::arch::asm;

    /// Of the register MXCSR: round to nearest, keep subnormal numbers, no traps (Intel SDM 1, § 10.2.3).
    pub const STANDARD: u64 = 0x1f80;

    pub fn read() -> u64 {
        let mut word = 0_u32;
        // SAFETY: the instruction writes four bytes to `word`.
        unsafe { asm!("stmxcsr [{}]", in(reg) &mut word, options(nostack, preserves_flags)) };
        u64::from(word)
    }

    pub fn write(word: u64) {
        let word = word as u32;
        // SAFETY: the instruction reads four bytes of `word`, which is `STANDARD` or what `read` returned.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &word, options(nostack, preserves_flags)) };
    }
}

#[cfg(all(target_arch = "aarch64", not(miri)))]
mod control {
    use std::arch::asm;

    /// Of the register FPCR: round to nearest, keep subnormal numbers, no traps (Arm ARM, § C5.2.8).
    pub const STANDARD: u64 = 0;

    pub fn read() -> u64 {
        let word: u64;
        // SAFETY: any code may read the register.
        unsafe { asm!("mrs {}, fpcr", out(reg) word, options(nostack, preserves_flags)) };
        word
    }

    pub fn write(word: u64) {
        // SAFETY: the word is `STANDARD` or what `read` returned.
        unsafe { asm!("msr fpcr, {}", in(reg) word, options(nostack, preserves_flags)) };
    }
}

#[cfg(any(miri, not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod control {
    pub const STANDARD: u64 = 0;

    pub fn read() -> u64 {
        STANDARD
    }

    pub fn write(_word: u64) {}
}

/// The standard environment (IEEE 754), until the value is dropped; then that of the caller.
pub struct FloatEnvironment {
    callers: u64,
    /// The environment is that of one thread.
    thread: PhantomData<*const ()>,
}

impl FloatEnvironment {
    /// Sets the standard environment in the calling thread.
    #[must_use]
    pub fn standard() -> FloatEnvironment {
        let callers = control::read();
        control::write(control::STANDARD);
        FloatEnvironment { callers, thread: PhantomData }
    }
}

impl Drop for FloatEnvironment {
    fn drop(&mut self) {
        control::write(self.callers);
    }
}

#[cfg(all(test, target_arch = "x86_64", not(miri)))]
mod tests {
    use super::*;
    use std::hint::black_box;

    #[test]
    fn the_standard_environment_is_set_and_that_of_the_caller_restored() {
        let divided = || (black_box(1.0_f64) / black_box(3.0), black_box(f64::MIN_POSITIVE) * black_box(0.5));
        let (third, half) = (f64::from_bits(0x3fd5_5555_5555_5555), f64::from_bits(0x0008_0000_0000_0000));
        let before = control::read();
        // Round to nearest, down, up and towards zero; then flush results, and numbers that are read.
        for mode in [0, 0x2000, 0x4000, 0x6000, 0x8000, 0x0040] {
            control::write(control::STANDARD | mode);
            let of_caller = divided();
            {
                let _standard = FloatEnvironment::standard();
                assert_eq!(divided(), (third, half));
            }
            // The sticky flags, the lowest six bits, tell what the caller's own divisions were.
            assert_eq!(control::read() & !0x3f, control::STANDARD | mode);
            assert_eq!(divided(), of_caller);
        }
        control::write(before);
    }
}
