//! The error of a run, from its distance from a second run and from what both runs may have in common.
//!
//! Where truncation is the error, one of the runs has less of it, and the distance of the two runs is nearly all of the
//! error of the other (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, § II.4). Where rounding is, or chaos
//! amplifies it, the two runs differ by about as much as each of them errs. What they have in common the distance does not show:
//! each such part of the error is a term of a list.

mod closed_form;
mod distance;
mod equal_steps;
mod rounded_start;
mod rounding;
mod saddle;
mod separatrix;
mod turns;

pub use closed_form::error_of_closed_form;
pub use distance::distances;
pub use equal_steps::{Change, depends_on_change, measured_change};
pub use rounded_start::{ROUNDINGS, round_otherwise, sign_of_forces};
pub use separatrix::phase_error;
pub use turns::longest_interval;

use crate::body::Body;
use crate::forces::{BodyForces, MOST_STATES};
use crate::inertia::moment_range;
use crate::kinematics::{length, plain_dot as dot};
use crate::method::Method;
use crate::real::{larger, smaller};
use crate::simd::Isa;
use crate::trajectory::time_range;

/// Rates count as rest below this share of the fastest possible rate of a body and of the rate of its swing.
const REST: f64 = 1e-13;

/// States of a body at its output times, or of many bodies one after another.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    /// Rates in the body.
    pub omega: &'a [[f64; 3]],
    /// The vertical in the body, if it is recorded.
    pub gamma: Option<&'a [[f64; 3]]>,
    /// Attitude, if it is recorded.
    pub attitude: Option<&'a [[f64; 4]]>,
    /// Work of the forces, if there are any.
    pub work: Option<&'a [f64]>,
    /// States of a function, if there are any.
    pub states: Option<&'a [[f64; MOST_STATES]]>,
}

impl<'a> Recorded<'a> {
    /// The states of one of many bodies.
    pub fn of(&self, body: usize, times: usize) -> Recorded<'a> {
        let own = body * times..(body + 1) * times;
        Recorded {
            omega: &self.omega[own.clone()],
            gamma: self.gamma.map(|all| &all[own.clone()]),
            attitude: self.attitude.map(|all| &all[own.clone()]),
            work: self.work.map(|all| &all[own.clone()]),
            states: self.states.map(|all| &all[own]),
        }
    }
}

/// The run of a body.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// The body at its start.
    pub body: &'a Body,
    /// What acts on it.
    pub forces: BodyForces<'a>,
    /// Output times, ascending.
    pub times: &'a [f64],
    /// The states there.
    pub states: Recorded<'a>,
    /// Drift of the energy.
    pub drift: f64,
    /// Its steps.
    pub steps: f64,
    /// Steps of the run with the longer ones.
    pub taken: f64,
    /// How a torque changes the rates, if that is needed.
    pub change: Option<Change>,
    /// The method.
    pub method: &'static Method,
    /// The tolerance of adaptive steps.
    pub tolerance: Option<f64>,
    /// That of the second run, if it is a larger one.
    pub coarser_tolerance: Option<f64>,
}

/// The estimated error of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The largest error at the compared times; NaN if it is not known.
    pub error: f64,
    /// The time nearest to 0 from which on the error is 1 or more; infinite if there is none.
    pub lost_from: f64,
}

impl Estimate {
    /// No error.
    pub const NONE: Estimate = Estimate { error: 0.0, lost_from: f64::INFINITY };

    /// The estimate of a body whose error is unknown.
    pub const UNKNOWN: Estimate = Estimate { error: f64::NAN, lost_from: f64::NAN };
}

/// What is stated of the error of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// The error at the output times.
    pub estimate: Estimate,
    /// How many more times show whether two runs that agree at the output times differ by whole turns; 0 if those do.
    pub looks: f64,
}

/// A run with the sizes to which its errors are relative.
struct Sized<'a> {
    run: &'a Run<'a>,
    isa: Isa,
    /// How much time is covered.
    span: f64,
    /// A bound of the rates.
    bound: f64,
    /// The fastest rate of the record.
    fastest: f64,
    /// The larger of the bound and of the rate of the swing.
    scale: f64,
}

/// An error that two runs may have in common; it is added to the errors at the output times.
type Term = fn(&Sized, &mut [f64]);

/// All of them.
const TERMS: [Term; 8] = [
    equal_steps::of_equal_steps,
    equal_steps::of_ringing,
    rounding::of_equal_runs,
    rounding::of_hanging_top,
    rounding::of_few_steps,
    rounding::of_damping,
    saddle::departure,
    saddle::homoclinic,
];

/// What is stated of the error of a run from others: `safety` times the distance of the farthest, and the terms; the
/// distance `alone` where it is compared with a full estimate. The errors at the times are written into `error`; `apart` has
/// room for as many.
pub fn stated<'a>(
    isa: Isa,
    run: &Run,
    others: impl Iterator<Item = Recorded<'a>>,
    safety: f64,
    alone: bool,
    [error, apart]: [&mut [f64]; 2],
) -> Stated {
    let known = Sized::new(isa, run);
    error.fill(0.0);
    if known.span == 0.0 {
        // Nothing moves in no time.
        return Stated { estimate: Estimate::NONE, looks: 0.0 };
    }
    for other in others {
        distance::stated(&known, &other, safety, apart);
        error.iter_mut().zip(&*apart).for_each(|(error, &apart)| *error = larger(*error, apart));
    }
    for term in TERMS.iter().filter(|_| !alone) {
        term(&known, error);
    }
    let mut estimate = Estimate::NONE;
    for (error, &time) in error.iter_mut().zip(run.times) {
        if !error.is_finite() {
            // An error that is not a number is unknown.
            *error = f64::INFINITY;
        }
        estimate.error = estimate.error.max(*error);
        if *error >= 1.0 && time.abs() < estimate.lost_from.abs() {
            estimate.lost_from = time;
        }
    }
    let looks = if estimate.error < 1.0 { turns::looks(&known) } else { 0.0 };
    Stated { estimate, looks }
}

impl<'a> Sized<'a> {
    fn new(isa: Isa, run: &'a Run<'a>) -> Self {
        let reached = time_range(run.times);
        let fastest = fastest(run.states.omega);
        let mut bound = run.body.fastest_rate(run.forces, reached);
        if run.forces.function.is_some() {
            // There may be no bound.
            bound = bound.max(fastest);
        }
        let scale = larger(bound, swing(run.body));
        Sized { run, isa, span: reached[1] - reached[0], bound, fastest, scale }
    }

    /// The size to which errors of rates are relative, if this is the largest rate.
    fn unit(&self, size: f64) -> f64 {
        unit(size, self.scale)
    }

    /// Adds errors of directions that move at this rate; or of the rates, where these are larger.
    fn add_with_rates(&self, rate: f64, of_time: impl Fn(f64) -> f64, error: &mut [f64]) {
        let times = self.run.times;
        // All rates may come from this error, of the run or of the true motion.
        let size = self.unit(larger(self.fastest, largest(times.iter().map(|&time| rate * of_time(time)))));
        for (error, &time) in error.iter_mut().zip(times) {
            let own = of_time(time);
            *error += larger(own, rate * own / size);
        }
    }
}

/// The rate of the swing of a body.
fn swing(body: &Body) -> f64 {
    (body.mgl() / moment_range(body.moments)[0]).sqrt()
}

/// The size to which errors of rates are relative: the largest rate, or a scale beside which that is rest.
fn unit(size: f64, scale: f64) -> f64 {
    if size > REST * scale {
        size
    } else if scale > 0.0 {
        scale
    } else {
        1.0
    }
}

/// The fastest of some rates.
pub fn fastest<T: Copy + Into<f64>>(omega: &[[T; 3]]) -> f64 {
    largest(omega.iter().map(|rates| length(&rates.map(Into::into))))
}

/// The largest of some numbers and 0; no number if one is none.
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, larger)
}

/// a x b, as plainly: equal products cancel to zero.
fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vertical in the body. Of an attitude that is upright to the bit it is so too.
fn vertical([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::DEFAULT;

    const FREE: Body = Body {
        moments: [1.0, 2.0, 2.5],
        weight: [0.0; 3],
        omega: [0.1, 2.0, 0.3],
        attitude: [1.0, 0.0, 0.0, 0.0],
    };

    fn rates(omega: &[[f64; 3]]) -> Recorded<'_> {
        Recorded { omega, gamma: None, attitude: None, work: None, states: None }
    }

    fn stated_of(times: &[f64], omega: &[[f64; 3]], other: &[[f64; 3]]) -> (Stated, Vec<f64>) {
        let run = Run {
            body: &FREE,
            forces: BodyForces::NONE,
            times,
            states: rates(omega),
            drift: 0.0,
            steps: 100.0,
            taken: 100.0,
            change: None,
            method: DEFAULT,
            tolerance: Some(1e-12),
            coarser_tolerance: None,
        };
        let (mut error, mut apart) = (vec![0.0; times.len()], vec![0.0; times.len()]);
        let others = [rates(omega), rates(other)].into_iter();
        let isa = Isa::current().unwrap();
        (stated(isa, &run, others, 3.0, false, [&mut error, &mut apart]), error)
    }

    #[test]
    fn two_equal_runs_err_by_rounding_alone() {
        let omega = [[0.1, 2.0, 0.3], [0.2, 1.9, 0.4]];
        let (stated, error) = stated_of(&[1.0, 2.0], &omega, &omega);
        let angle = 2.0 * FREE.fastest_rate(BodyForces::NONE, [0.0; 2]);
        assert_eq!(error, [5e-16 * (1.0 + angle); 2]);
        let estimate = Estimate { error: error[0], lost_from: f64::INFINITY };
        assert_eq!(stated, Stated { estimate, looks: 0.0 });
    }

    #[test]
    fn a_body_is_lost_from_the_nearest_time_at_which_its_runs_part_by_their_rates() {
        let omega = [[0.0, 2.0, 0.0]; 4];
        let other = [[0.0, 2.0, 0.0], [0.0, 2.0, 0.0], [0.0, -2.0, 0.0], [0.0, -2.0, 0.0]];
        let (stated, error) = stated_of(&[-2.0, 1.0, 3.0, 4.0], &omega, &other);
        assert_eq!(stated.estimate.lost_from, 3.0);
        assert!(error[0] < 1e-14 && error[1] < 1e-14 && stated.estimate.error == error[3] && error[3] >= 6.0);
    }

    #[test]
    fn states_that_are_no_numbers_have_no_known_error() {
        let (known, lost) = ([0.0, 2.0, 0.0], [f64::NAN; 3]);
        let (stated, error) = stated_of(&[1.0, 2.0], &[known, known], &[known, lost]);
        assert!(error[0] < 1e-14 && error[1] == f64::INFINITY);
        assert_eq!(stated.estimate, Estimate { error: f64::INFINITY, lost_from: 2.0 });
    }

    #[test]
    fn nothing_moves_in_no_time() {
        let (stated, error) = stated_of(&[0.0], &[FREE.omega], &[[f64::NAN; 3]]);
        assert_eq!((stated.estimate, error), (Estimate::NONE, vec![0.0]));
        assert_eq!(stated_of(&[], &[], &[]).0, stated);
    }
}
