//! The instruction set of the kernels: the widest one of the CPU, or the one that `RIGID_ISA` names.

#[cfg(target_arch = "x86_64")]
use super::{V4, V8};
use crate::error::Error;
use crate::real::{Outlined, Pack, Real};
use std::marker::PhantomData;
use std::sync::OnceLock;

/// Work of packs that is compiled for each instruction set.
pub trait Work {
    /// What it returns.
    type Out;
    /// Does the work. It is `#[inline(always)]`, and takes on the instruction set of its caller.
    fn run<P: Pack>(self) -> Self::Out;
}

/// Work by packs of one width.
struct By<P, W>(W, PhantomData<P>);

impl<P: Pack, W: Work> Outlined for By<P, W> {
    type Out = W::Out;
    #[inline(always)]
    fn run(self) -> W::Out {
        self.0.run::<P>()
    }
}

/// An instruction set that kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// Eight doubles a register.
    #[cfg(target_arch = "x86_64")]
    Avx512,
    /// Four doubles a register, with FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// One double. Without a hardware instruction `fma` is a function of the C library: slow, with the same bits. x86-64
    /// has it by the feature `plain` only.
    #[cfg(plain)]
    Scalar,
}

/// The environment variable that selects the instruction set.
pub const ENVIRONMENT: &str = "RIGID_ISA";

impl Isa {
    /// All instruction sets, widest first.
    pub const ALL: &[Isa] = &[
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512,
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2,
        #[cfg(plain)]
        Isa::Scalar,
    ];

    /// The narrowest of all.
    pub const NARROWEST: Isa = Isa::ALL[Isa::ALL.len() - 1];

    /// The name used by `RIGID_ISA`.
    pub fn name(self) -> &'static str {
        match self {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => "avx512",
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => "avx2",
            #[cfg(plain)]
            Isa::Scalar => "scalar",
        }
    }

    /// Whether this CPU has the instruction set.
    pub fn is_available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => {
                // is_x86_feature_detected! also checks that the operating system saves the wide registers.
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512bw")
                    && Isa::Avx2.is_available()
            }
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(plain)]
            Isa::Scalar => true,
        }
    }

    /// Does work by packs as wide as the registers. Panics if the CPU lacks the instruction set.
    pub fn call<W: Work>(self, work: W) -> W::Out {
        assert!(self.is_available(), "{} is not available on this CPU", self.name());
        match self {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 => V8::outlined(By::<V8, W>(work, PhantomData)),
            #[cfg(target_arch = "x86_64")]
            Isa::Avx2 => V4::outlined(By::<V4, W>(work, PhantomData)),
            #[cfg(plain)]
            Isa::Scalar => f64::outlined(By::<f64, W>(work, PhantomData)),
        }
    }

    /// Does work of single numbers with fused products of the CPU; those of plain code are calls of the C library, with the
    /// same bits. Panics if the CPU lacks the instruction set.
    pub fn call_with_fma<W: Outlined>(self, work: W) -> W::Out {
        assert!(self.is_available(), "{} is not available on this CPU", self.name());
        match self {
            #[cfg(target_arch = "x86_64")]
            Isa::Avx512 | Isa::Avx2 => V4::outlined(work),
            #[cfg(plain)]
            Isa::Scalar => f64::outlined(work),
        }
    }

    /// The widest instruction set of this CPU. Panics if there is none.
    pub fn widest() -> Isa {
        *Isa::ALL.iter().find(|isa| isa.is_available()).expect("`Isa::current` refuses such a CPU")
    }

    /// The instruction sets of this CPU, widest first.
    pub fn available() -> Vec<Isa> {
        Isa::ALL.iter().copied().filter(|isa| isa.is_available()).collect()
    }

    /// The instruction set with the name `value` among those of a CPU, widest first; the widest without a name.
    ///
    /// # Errors
    /// If the CPU has none that kernels are compiled for, or not this one.
    pub fn parse(value: Option<&str>, available: &[Isa]) -> Result<Isa, Error> {
        let widest = available.first().copied().ok_or(Error::NoIsa)?;
        match value {
            None | Some("") => Ok(widest),
            Some(name) => available.iter().copied().find(|isa| isa.name() == name).ok_or_else(|| {
                let names: Vec<_> = available.iter().map(|isa| isa.name()).collect();
                Error::Isa { value: name.to_string(), available: names.join(", ") }
            }),
        }
    }

    /// The instruction set of this process: that of `RIGID_ISA` if set, else the widest. The variable is read once.
    pub fn current() -> Result<Isa, Error> {
        static CURRENT: OnceLock<Result<Isa, Error>> = OnceLock::new();
        let set = || std::env::var_os(ENVIRONMENT).map(|value| value.to_string_lossy().into_owned());
        CURRENT.get_or_init(|| Isa::parse(set().as_deref(), &Isa::available())).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_processor_without_kernels_is_told_how_to_build_them() {
        let refusal = Isa::parse(None, &[]).unwrap_err().to_string();
        assert!(refusal.starts_with("this processor has no AVX2 and FMA"), "{refusal}");
        assert!(refusal.contains("--features plain"), "{refusal}");
        assert_eq!(Isa::parse(Some(""), &Isa::available()), Ok(Isa::available()[0]));
    }
}
