//! Errors that a run by equal steps and its check share: their steps round alike.

use super::{Run, Sized, cross, length, smaller};
use crate::body::Body;
use crate::call::Call;
use crate::error::Error;
use crate::forces::Forces;
use crate::inertia::moment_range;
use crate::memory;
use crate::method::{AnyMethod, MIDPOINT, RK4, default_step};
use crate::scene::Scene;
use crate::special::{exp, ln};
use crate::trajectory::{Record, Request, Schedule, simulate, time_range};

/// Rounding error (rad) of each rotation of a splitting. Equal rotations err in both runs alike, all in one direction.
const ROTATION: f64 = 1.6e-17;

/// Relative rounding error of the rates in each of many equal steps.
///
/// It is the least share that half a unit in the last place is of a number, always in one direction: a method of exact flows turns the rates of a symmetric free
/// body by the same angle each step, and all but steady rates change by the same amount.
const DRIFT: f64 = 5.6e-17;

/// Relative difference of moments below which a body turns as with equal moments.
const ALIKE: f64 = 1e-4;

/// Half the distance from 1 to the next number.
const UNIT: f64 = f64::EPSILON / 2.0;

/// Most states at which the change of the rates by a torque is measured.
const LOOKS: usize = 16;

/// Number by which a step is divided to give the time of this measurement.
const PART: f64 = 1024.0;

/// How the rates of a body change under a torque, measured at some of its states.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// The least rate of change over the rates.
    least: f64,
    /// The rate that the steps of the body follow: a rotor couples the rates more closely than the body turns.
    following: f64,
}

/// Adds the rounding that equal steps share.
pub fn of_equal_steps(known: &Sized, error: &mut [f64]) {
    let run = known.run;
    if run.tolerance.is_some() {
        return;
    }
    let method = run.method;
    let rotations = if method.facts.symplectic { method.facts.stages as f64 } else { 0.0 };
    let mut floor = ROTATION * rotations * run.steps;
    if rotations > 0.0 && run.forces.is_none() && turns_evenly(run.body) {
        floor += 0.5 * DRIFT * run.steps * known.bound * known.span;
    }
    // The second run of a series carries the rounding of a step on.
    if !method.is_series() {
        floor += of_steady_rates(known);
    }
    error.iter_mut().for_each(|error| *error += floor);
}

/// Whether a body is free and turns as with equal moments.
fn turns_evenly(body: &Body) -> bool {
    let moments = body.moments;
    let alike = |i: usize, j: usize| (moments[j] - moments[i]).abs() <= ALIKE * moments[i];
    body.weight == [0.0; 3] && (alike(0, 2) || alike(1, 0) || alike(2, 1))
}

/// The error of a body whose rates change by nearly the same amount each step.
///
/// Where the change of a step differs from the change of the last one by a share of the rates that is less than a rounding, it
/// is rounded as the last one was: for as many steps as make up one. The losses of groups of so many steps add at random.
fn of_steady_rates(known: &Sized) -> f64 {
    let (run, span) = (known.run, known.span);
    let (differs, rate) = match run.change {
        Some(change) => (change.least * change.least, change.following),
        None => (second_difference(run), known.bound),
    };
    let step = span / run.steps;
    let share = differs * step * step;
    if !(share >= 0.0) {
        return 0.0;
    }
    let equal = (UNIT / share).min(run.steps);
    if equal > 1.0 { DRIFT * (run.steps * equal).sqrt() * (1.0 + 0.5 * rate * span) } else { 0.0 }
}

/// About the least `|d2 omega / dt2| / |omega|` of the states, 1/s², if no torque is applied.
///
/// Without weight the rates turn in the body, and so do their changes. The change by the weight turns with the body. Methods
/// that preserve `|L|` add it apart from the turn.
fn second_difference(run: &Run) -> f64 {
    let moments = run.body.moments;
    let by_weight = run.body.mgl() / moment_range(run.body.moments)[0];
    if run.method.facts.group_preserving && by_weight > 0.0 {
        return by_weight;
    }
    let matrix = run.forces.damping.matrix();
    // At rest there are no rates to be rounded.
    let turning = run.states.omega.iter().filter(|omega| length(omega) > 0.0).map(|omega| {
        let torque = cross(&[0, 1, 2].map(|k| moments[k] * omega[k]), omega);
        let change = [0, 1, 2].map(|k| (torque[k] - super::dot(&matrix[k], omega)) / moments[k]);
        (length(&change) / length(omega)).powi(2)
    });
    turning.fold(f64::INFINITY, smaller) + by_weight
}

/// Whether an error of a run depends on how a torque changes the rates.
pub fn depends_on_change(run: &Run) -> bool {
    let [first, last] = time_range(run.times);
    let is_shared = run.tolerance.is_none() && !run.method.is_series();
    is_shared && run.forces.damping_alone().is_none() && first < last
}

/// The change of the rates of a body under a torque, by short runs from some of its states on. What acts is what acts at the
/// start, in the attitude of the state if that is recorded.
///
/// # Errors
/// If there is no memory, or the request is stopped.
pub fn measured_change(
    run: &Run,
    (scene, all, index): (&'static Scene, &Forces, usize),
    call: Call,
) -> Result<Change, Error> {
    let range @ [first, last] = time_range(run.times);
    let count = run.times.len().min(LOOKS);
    let mut bodies = memory::reserved("states to be looked at", count)?;
    for k in 0..count {
        // Evenly spread, the last one among them.
        let at = (run.times.len() - 1) - k * (run.times.len() - 1) / (count - 1).max(1);
        let (omega, mut body) = (run.states.omega[at], *run.body);
        if omega.iter().all(|rate| rate.is_finite()) {
            body.omega = omega;
            body.attitude = run.states.attitude.map_or(body.attitude, |attitudes| attitudes[at]);
        }
        bodies.push(body);
    }
    let time =
        (last - first) / run.steps / PART * if run.times[run.times.len() - 1] > 0.0 { 1.0 } else { -1.0 };
    let (times, forces) = (vec![time; count], all.of_some(&vec![index; count])?);
    let span = time_range(&times[..1]);
    // A state of steps that are far too long may be as fast as numbers allow: no step is shorter than this.
    let shortest = time.abs() / PART;
    let step = |body: &Body| default_step(&RK4, body.step_rate(&RK4, run.forces, span)).max(shortest);
    let steps: Vec<f64> = bodies.iter().map(|body| step(body).min(run.forces.longest_unseen(span))).collect();
    let moved = simulate(
        &Request {
            bodies: &bodies,
            scene,
            forces: &forces,
            method: AnyMethod::Steps(&RK4),
            record: Record::Rates,
            schedule: Schedule::TimesOfEach(&times, 1),
            steps: &steps,
            refinement: 1.0,
            tolerance: None,
            max_steps: u64::MAX,
        },
        Call { threads: 1, ..call },
    )?;
    let mut slowest = f64::INFINITY;
    let moved = bodies.iter().zip(moved.rates().as_chunks::<3>().0);
    for (body, now) in moved.filter(|(body, _)| length(&body.omega) > 0.0) {
        let change = [0, 1, 2].map(|k| now[k] - body.omega[k]);
        slowest = smaller(slowest, length(&change) / time.abs() / length(&body.omega));
    }
    let following = run.body.step_rate(run.method, run.forces, range);
    Ok(Change { least: slowest, following })
}

/// Adds the remaining rates of the start after damping should have ended them: rates of `midpoint` change their sign at each
/// step and hardly decay under strong damping, because it is not L-stable.
///
/// After an even number of steps they have their first sign again: two runs may agree in it.
pub fn of_ringing(known: &Sized, error: &mut [f64]) {
    let run = known.run;
    if run.tolerance.is_some() || run.forces.is_none() || run.method.facts.name != MIDPOINT.facts.name {
        return;
    }
    let rate = run.forces.damping.rates(run.body.moments)[2];
    let damped = 0.5 * rate * known.span / run.steps;
    if !(damped > 1.0 && known.fastest > 0.0) {
        return;
    }
    let (kept, share) = (ln((damped - 1.0) / (damped + 1.0)), length(&run.body.omega) / known.fastest);
    for (error, &time) in error.iter_mut().zip(run.times).filter(|(_, time)| **time > 0.0) {
        *error += exp(kept * run.steps * time / known.span) * share;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Recorded;
    use crate::forces::{BodyForces, Damping};
    use crate::method::{DEFAULT, Method, SPLITTING, STIFF};
    use crate::simd::Isa;

    const TIMES: [f64; 2] = [0.5, 1.0];

    /// The errors of a term, of a body that spins about an axis all along, with its starting rate in two steps of 1 s.
    fn errors(
        term: fn(&Sized, &mut [f64]),
        method: &'static Method,
        body: &Body,
        damping: [f64; 6],
    ) -> [f64; 2] {
        errors_with(term, method, (body, [body.omega; 2]), damping)
    }

    /// The same of a body with these rates at its two times.
    fn errors_with(
        term: fn(&Sized, &mut [f64]),
        method: &'static Method,
        (body, omega): (&Body, [[f64; 3]; 2]),
        damping: [f64; 6],
    ) -> [f64; 2] {
        let forces = BodyForces { damping: Damping(damping), ..BodyForces::NONE };
        let states = Recorded { omega: &omega, gamma: None, attitude: None, work: None, states: None };
        let run = Run {
            body,
            forces,
            times: &TIMES,
            states,
            drift: 0.0,
            steps: 2.0,
            taken: 2.0,
            change: None,
            method,
            tolerance: None,
            coarser_tolerance: None,
        };
        let mut error = [0.0; 2];
        term(&Sized::new(Isa::current().unwrap(), &run), &mut error);
        error
    }

    fn spinning(moments: [f64; 3]) -> Body {
        Body { moments, weight: [0.0; 3], omega: [0.0, 0.0, 3.0], attitude: [1.0, 0.0, 0.0, 0.0] }
    }

    const DAMPED: [f64; 6] = [10.0, 10.0, 10.0, 0.0, 0.0, 0.0];

    #[test]
    fn steady_rates_lose_half_a_unit_in_each_step() {
        let body = spinning([1.0, 2.0, 2.5]);
        assert_eq!(errors(of_equal_steps, DEFAULT, &body, [0.0; 6]), [2.0 * DRIFT * (1.0 + 0.5 * 3.0); 2]);
    }

    #[test]
    fn rest_at_one_output_time_hides_no_loss() {
        let body = spinning([1.0, 2.0, 2.5]);
        let at_rest = (&body, [body.omega, [0.0; 3]]);
        let lost = errors(of_equal_steps, DEFAULT, &body, [0.0; 6]);
        assert_eq!(errors_with(of_equal_steps, DEFAULT, at_rest, [0.0; 6]), lost);
    }

    #[test]
    fn rotations_of_a_splitting_err_alike_and_a_symmetric_body_turns_by_equal_angles() {
        let of = |moments| errors(of_equal_steps, &SPLITTING, &spinning(moments), [0.0; 6])[0];
        let rotations = 2.0 * ROTATION * SPLITTING.facts.stages as f64;
        let steady = 2.0 * DRIFT * (1.0 + 0.5 * 3.0);
        assert!((of([1.0, 2.0, 2.5]) - rotations - steady).abs() < 1e-30);
        assert!((of([1.0, 1.0, 2.5]) - rotations - steady - 0.5 * DRIFT * 2.0 * 3.0).abs() < 1e-30);
    }

    #[test]
    fn rates_of_the_midpoint_rule_change_their_sign_and_remain() {
        // Of h c / (2 I) = 2.5 a step keeps (1 - 2.5) / (1 + 2.5) of the rates.
        let [first, second] = errors(of_ringing, &MIDPOINT, &spinning([1.0; 3]), DAMPED);
        assert!((first - 1.5 / 3.5).abs() < 1e-15 && (second - (1.5_f64 / 3.5).powi(2)).abs() < 1e-15);
        assert_eq!(errors(of_ringing, STIFF, &spinning([1.0; 3]), DAMPED), [0.0; 2]);
        assert_eq!(errors(of_ringing, &MIDPOINT, &spinning([1.0; 3]), [0.0; 6]), [0.0; 2]);
    }
}
