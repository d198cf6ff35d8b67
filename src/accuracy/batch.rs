//! Bodies that are run alike.

use crate::body::Body;
use crate::call::Call;
use crate::error::Error;
use crate::estimate::{round_otherwise, sign_of_forces};
use crate::forces::Forces;
use crate::memory;
use crate::method::{AnyMethod, Method};
use crate::scene::Scene;
use crate::trajectory::{
    Record, Request, Schedule, States, StatesPart, default_steps, simulate_into, time_range,
};
use std::borrow::Cow;
use std::cell::Cell;

/// What all runs of a call share.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    pub scene: &'static Scene,
    pub record: Record<'a>,
    pub call: Call<'a>,
    /// Processor time of all runs.
    pub nanoseconds: &'a Cell<u64>,
}

/// How bodies are run.
#[derive(Clone, Copy)]
pub struct Solver {
    pub method: &'static Method,
    /// Tolerance of adaptive steps.
    pub tolerance: Option<f64>,
    pub max_steps: u64,
    /// Whether a torque or weight may stop the bodies, on which drag acts.
    pub may_stop: bool,
}

impl Solver {
    /// The solver of a second run: it may need more steps than the run whose limit this is.
    pub fn with_more_steps(self) -> Self {
        Solver { max_steps: self.max_steps.saturating_mul(64).min(1 << 63), ..self }
    }
}

/// Bodies with their forces and output times.
pub struct Batch<'a> {
    pub job: Job<'a>,
    pub bodies: Cow<'a, [Body]>,
    forces: Cow<'a, Forces>,
    times: Cow<'a, [f64]>,
    /// How many of the times each body has, if they are its own.
    own: Option<usize>,
}

impl<'a> Batch<'a> {
    /// The bodies of a request whose states are recorded at times.
    pub fn of(request: &Request<'a>, job: Job<'a>) -> Self {
        let (times, own) = match request.schedule {
            Schedule::Times(times) => (times, None),
            Schedule::TimesOfEach(times, count) => (times, Some(count)),
            Schedule::Strides(_) => unreachable!("strides are of a single run"),
        };
        let (bodies, forces) = (Cow::Borrowed(request.bodies), Cow::Borrowed(request.forces));
        Batch { job, bodies, forces, times: Cow::Borrowed(times), own }
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// The forces on the bodies.
    pub fn forces(&self) -> &Forces {
        &self.forces
    }

    /// Whether no force acts on any.
    pub fn is_free(&self) -> bool {
        self.forces.is_none()
    }

    /// Whether all have the same output times.
    pub fn shares_times(&self) -> bool {
        self.own.is_none()
    }

    /// Number of output times of a body.
    pub fn number_of_times(&self) -> usize {
        self.own.unwrap_or(self.times.len())
    }

    /// The output times of a body.
    pub fn times_of(&self, body: usize) -> &[f64] {
        self.schedule().times_of(body).unwrap_or(&[])
    }

    /// How much time a body covers.
    pub fn span_of(&self, body: usize) -> f64 {
        let [first, last] = time_range(self.times_of(body));
        last - first
    }

    fn schedule(&self) -> Schedule<'_> {
        match self.own {
            Some(count) => Schedule::TimesOfEach(&self.times, count),
            None => Schedule::Times(&self.times),
        }
    }

    /// Some of the bodies.
    pub fn select(&self, some: &[usize]) -> Result<Batch<'a>, Error> {
        let times = match self.own {
            Some(count) => {
                let rows = some.iter().flat_map(|&body| self.times_of(body).iter().copied());
                memory::collected("times", some.len() * count, rows)?
            }
            None => memory::collected("times", self.times.len(), self.times.iter().copied())?,
        };
        self.with(picked("bodies", &self.bodies, some)?, self.forces.of_some(some)?, times, self.own)
    }

    /// Some bodies at these times.
    pub fn at_times(&self, some: &[usize], times: Vec<f64>) -> Result<Batch<'a>, Error> {
        self.with(picked("bodies", &self.bodies, some)?, self.forces.of_some(some)?, times, None)
    }

    /// The bodies with differently rounded starts, damping and orbits, in one of `ROUNDINGS` ways.
    ///
    /// Two runs from one start would share its rounding, magnified at a saddle. Two runs with one matrix would share the
    /// rounding of its least rate, and two runs on one orbit the rounding of each step.
    pub fn rounded_otherwise(&self, rounding: usize) -> Result<Batch<'a>, Error> {
        let bodies = self.bodies.iter().map(|body| Body {
            omega: round_otherwise(body.omega, rounding),
            attitude: round_otherwise(body.attitude, rounding),
            ..*body
        });
        let bodies = memory::collected("bodies", self.len(), bodies)?;
        let times = memory::collected("times", self.times.len(), self.times.iter().copied())?;
        self.with(bodies, self.forces.rounded_otherwise(sign_of_forces(rounding))?, times, self.own)
    }

    fn with(
        &self,
        bodies: Vec<Body>,
        forces: Forces,
        times: Vec<f64>,
        own: Option<usize>,
    ) -> Result<Batch<'a>, Error> {
        let (bodies, forces, times) = (Cow::Owned(bodies), Cow::Owned(forces), Cow::Owned(times));
        Ok(Batch { job: self.job, bodies, forces, times, own })
    }

    /// The longest steps that a method takes by default; infinite at rest.
    pub fn longest_steps(&self, method: &Method) -> Result<Vec<f64>, Error> {
        default_steps(method, &self.bodies, &self.forces, &self.schedule())
    }

    /// Memory for the states of a run.
    pub fn reserved(&self, solver: Solver) -> Result<States, Error> {
        States::reserved(&self.request(solver, &[], 1.0), self.len(), &[])
    }

    /// The states of a run. Between two output times a body takes `refinement` times the steps, rounded up. Without longest
    /// steps it takes those of the method.
    pub fn run(&self, solver: Solver, longest: Option<&[f64]>, refinement: f64) -> Result<States, Error> {
        let mut states = self.reserved(solver)?;
        self.run_into(solver, longest, refinement, states.whole())?;
        Ok(states)
    }

    /// Writes the states of a run.
    pub fn run_into(
        &self,
        solver: Solver,
        longest: Option<&[f64]>,
        refinement: f64,
        states: StatesPart,
    ) -> Result<(), Error> {
        let Job { call, nanoseconds, .. } = self.job;
        let steps = match longest {
            Some(longest) => Cow::Borrowed(longest),
            None => Cow::Owned(self.longest_steps(solver.method)?),
        };
        let passed = simulate_into(&self.request(solver, &steps, refinement), states, call)?;
        nanoseconds.set(nanoseconds.get() + passed);
        Ok(())
    }

    fn request<'b>(&'b self, solver: Solver, steps: &'b [f64], refinement: f64) -> Request<'b> {
        Request {
            bodies: &self.bodies,
            scene: self.job.scene,
            forces: &self.forces,
            method: AnyMethod::Steps(solver.method),
            record: self.job.record,
            schedule: self.schedule(),
            steps,
            refinement,
            tolerance: solver.tolerance,
            max_steps: solver.max_steps,
        }
    }
}

/// Some of the elements of a list.
pub fn picked<T: Copy>(what: &str, all: &[T], some: &[usize]) -> Result<Vec<T>, Error> {
    memory::collected(what, some.len(), some.iter().map(|&index| all[index]))
}
