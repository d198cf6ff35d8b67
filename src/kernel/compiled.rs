//! A kernel with the code of an instruction set.

use super::Kernel;
use super::adaptive::AdaptiveSteps;
use super::group::{ForcesRows, Group, MAX_STATE};
use super::registry::{Code, code};
use crate::scene::Parameters;
use crate::simd::Isa;

/// A kernel compiled for an instruction set that this CPU has.
#[derive(Clone, Copy)]
pub struct Compiled {
    code: &'static Code,
    kernel: Kernel,
}

impl Compiled {
    /// The kernel for an instruction set. Panics if the CPU lacks the set, if the step does not integrate the system,
    /// or if the observable does not fit the system or the step.
    pub fn new(kernel: Kernel, isa: Isa) -> Compiled {
        assert!(isa.is_available(), "{} is not available on this CPU", isa.name());
        let Kernel { system, step, observed } = kernel;
        assert!(system.can_observe(observed), "{observed:?} cannot be observed on {system:?}");
        assert!(system.is_moved_by(step), "{step:?} does not integrate {system:?}");
        let code = code(system, step.engine, isa).expect("checked in the line before");
        Compiled { code, kernel }
    }

    /// System, step and observable of the kernel.
    #[inline]
    pub fn kernel(self) -> Kernel {
        self.kernel
    }

    /// Advances every lane of the group; only forced systems use the forces.
    pub fn advance(self, group: &mut Group, forces: &ForcesRows, steps: usize) {
        // SAFETY: `new` has seen the features that the entry point needs.
        unsafe { (self.code.advance)(group, forces, steps, self.kernel.observed, self.kernel.step.numbers) }
    }

    /// Whether the further deviation vectors of a group are moved with its motions.
    pub fn shares_motion(self) -> bool {
        self.code.shares_motion
    }

    /// Transforms every active lane to the variables of its steps, before the first of equal steps; or back, after the
    /// last. Most steps use those of the state.
    pub fn process(self, group: &mut Group, leaving: bool) {
        if let Some(process) = self.code.process.filter(|_| self.kernel.step.is_processed()) {
            // SAFETY: as above.
            unsafe { process(group, leaving, self.kernel.step.numbers) }
        }
    }

    /// Advances every lane by at most `most` adaptive steps, until one lane reaches its `next` time; only for Taylor
    /// series, and Runge-Kutta steps that are known inside.
    pub fn advance_adaptive(
        self,
        group: &mut Group,
        forces: &ForcesRows,
        lanes: &mut AdaptiveSteps,
        most: usize,
    ) {
        let alone = self.code.alone.filter(|_| group.is_of_one());
        let adaptive = alone.or(self.code.adaptive).expect("only series choose their steps");
        // SAFETY: as above.
        unsafe { adaptive(group, forces, lanes, most, self.kernel.step.numbers) }
    }

    /// The state of a lane inside its last step, at a time after the begin of the step in units of the lane.
    pub fn dense_output(self, lanes: &AdaptiveSteps, lane: usize, units: f64) -> [f64; MAX_STATE] {
        let dense = self.code.dense.expect("only series are known inside a step");
        // SAFETY: as above.
        unsafe { dense(lanes, lane, units, self.kernel.step.numbers) }
    }

    /// Energy and conserved momentum of one body.
    pub fn invariants(self, p: &Parameters<f64>, y: &[f64; MAX_STATE]) -> [f64; 2] {
        // SAFETY: as above.
        unsafe { (self.code.invariants)(p, y) }
    }
}
