//! Free bodies under a damping that is a multiple of their inertia, in closed form.

use super::request::{Request, Schedule};
use super::states::States;
use crate::error::Error;
use crate::forcing::Forcing;
use crate::scheme::phi;
use crate::simd::Isa;
use crate::solver::Solver;
use crate::special::exp;
use std::sync::atomic::AtomicBool;

/// Free bodies under a damping `D = k I`: `L' = L x omega - k L` is the free motion in the time
/// `s = (1 - exp(-k t)) / k`, times `exp(-k t)`.
pub fn simulate(
    request: &Request,
    threads: usize,
    isa: Isa,
    stop: &AtomicBool,
) -> Result<Option<States>, Error> {
    let refuse = |rule| Err(Error::Value { argument: "method", value: Solver::EXACT.to_string(), rule });
    let Schedule::Times(times) = request.schedule else {
        return refuse("a closed form takes no steps");
    };
    let known = request.bodies.iter().map(|body| request.forcing.slows_evenly(body.moments));
    let rates: Option<Vec<f64>> = known.collect();
    let even =
        rates.filter(|rates| !request.scene.has_weight && rates.windows(2).all(|two| two[0] == two[1]));
    let Some(rates) = even else {
        return refuse(
            "under torque or damping a closed form is known of free bodies whose damping is a multiple of their inertia",
        );
    };
    let rate = rates.first().copied().unwrap_or(0.0);
    let factors: Vec<f64> = times.iter().map(|&t| exp(-rate * t)).collect();
    let slow: Vec<f64> = times.iter().map(|&t| t * phi(-rate * t)[1]).collect();
    let request = Request { schedule: Schedule::Times(&slow), forcing: Forcing::NONE, ..*request };
    let Some(mut states) = super::simulate(&request, threads, isa, stop)? else { return Ok(None) };
    let mut work = Vec::with_capacity(states.omega.len() / 3);
    for (body, rows) in request.bodies.iter().zip(states.omega.chunks_mut(3 * times.len().max(1))) {
        let kinetic = |w: &[f64]| (0..3).map(|k| 0.5 * body.moments[k] * w[k] * w[k]).sum::<f64>();
        for (row, &factor) in rows.chunks_mut(3).zip(&factors) {
            row.iter_mut().for_each(|w| *w *= factor);
            work.push(kinetic(row) - kinetic(&body.omega));
        }
    }
    states.work = Some(work);
    Ok(Some(states))
}
