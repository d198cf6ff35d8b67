//! Free bodies under a damping that is a multiple of their inertia, in closed form.

use super::request::{Request, Schedule};
use super::states::States;
use crate::error::Error;
use crate::forcing::Forcing;
use crate::memory;
use crate::scheme::phi;
use crate::simd::Isa;
use crate::solver::Solver;
use crate::special::exp;
use std::sync::atomic::AtomicBool;

/// Free bodies under a damping `D = k I`: `L' = L x omega - k L` is the free motion in the time
/// `s = (1 - exp(-k t)) / k`, times `exp(-k t)`.
pub fn simulate(request: &Request, threads: usize, isa: Isa, stop: &AtomicBool) -> Result<States, Error> {
    let refuse = |rule| Err(Error::Value { argument: "method", value: Solver::EXACT.to_string(), rule });
    let Schedule::Times(times) = request.schedule else {
        return refuse("a closed form takes no steps");
    };
    let mut rates = request.bodies.iter().map(|body| request.forcing.slows_evenly(body.moments));
    let rate = rates.next().unwrap_or(Some(0.0));
    let even = rates.all(|other| other == rate) && !request.scene.has_weight;
    let Some(rate) = rate.filter(|_| even) else {
        return refuse(
            "under torque or damping a closed form is known of free bodies whose damping is a multiple of their inertia",
        );
    };
    let each =
        |of: &dyn Fn(f64) -> f64| memory::collected("times", times.len(), times.iter().map(|&t| of(t)));
    let (factors, slow) = (each(&|t| exp(-rate * t))?, each(&|t| t * phi(-rate * t)[1])?);
    let request = Request { schedule: Schedule::Times(&slow), forcing: Forcing::NONE, ..*request };
    let mut states = super::simulate(&request, threads, isa, stop)?;
    let omega = states.omega.as_mut().expect("rates are always recorded");
    let mut work = memory::reserved("work", omega.len() / 3)?;
    for (body, rows) in request.bodies.iter().zip(omega.chunks_mut(3 * times.len().max(1))) {
        let kinetic = |w: &[f64]| (0..3).map(|k| 0.5 * body.moments[k] * w[k] * w[k]).sum::<f64>();
        for (row, &factor) in rows.chunks_mut(3).zip(&factors) {
            row.iter_mut().for_each(|w| *w *= factor);
            work.push(kinetic(row) - kinetic(&body.omega));
        }
    }
    states.work = Some(work);
    Ok(states)
}
