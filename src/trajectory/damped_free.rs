//! Free bodies under a damping that is a multiple of their inertia, in closed form.

use super::{Request, Schedule, StatesPart};
use crate::call::Call;
use crate::error::{Error, refuse};
use crate::forces::Forces;
use crate::memory;
use crate::method::{AnyMethod, phi};
use crate::special::exp;

/// Free bodies under a damping `D = k I`: `L' = L x omega - k L` is the free motion in the time
/// `s = (1 - exp(-k t)) / k`, times `exp(-k t)`.
pub fn simulate(request: &Request, mut states: StatesPart, call: Call) -> Result<u64, Error> {
    let refuse = |rule| refuse("method", AnyMethod::EXACT, rule);
    if let Schedule::Strides(_) = request.schedule {
        return refuse("a closed form takes no steps");
    }
    let (n, count) = (request.bodies.len(), request.schedule.len());
    // `None` for a body on which nothing acts.
    let mut rates = memory::reserved("damping rates", n)?;
    for (index, body) in request.bodies.iter().enumerate() {
        let forces = request.forces_of(index);
        let rate = forces.slows_evenly(body.moments).filter(|_| !request.scene.has_weight);
        if rate.is_none() && !forces.is_none() {
            return refuse(
                "under torque or damping a closed form is known of free bodies whose damping is a multiple of their inertia",
            );
        }
        rates.push(rate.filter(|_| !forces.is_none()));
    }
    // Bodies of equal rates and times share them.
    let shared =
        matches!(request.schedule, Schedule::Times(_)) && rates.windows(2).all(|pair| pair[0] == pair[1]);
    let rows = if shared { n.min(1) } else { n };
    let length = rows.checked_mul(count).ok_or(Error::Memory {
        what: "times".into(),
        bytes: u128::MAX,
        limit: None,
    })?;
    let [mut factors, mut slow] = [memory::reserved("times", length)?, memory::reserved("times", length)?];
    for (index, &rate) in rates.iter().enumerate().take(rows) {
        for &t in request.schedule.times_of(index).unwrap_or_default() {
            factors.push(rate.map_or(1.0, |rate| exp(-rate * t)));
            slow.push(rate.map_or(t, |rate| t * phi(-rate * t)[1]));
        }
    }
    let schedule = if shared { Schedule::Times(&slow) } else { Schedule::TimesOfEach(&slow, count) };
    let request = Request { schedule, forces: Forces::NONE, ..*request };
    let nanoseconds = super::simulate_into(&request, states.again(), call)?;
    let omega = states.omega.as_mut().expect("rates are always recorded");
    let work = states.work.as_mut().expect("the work of forced bodies is always recorded");
    let columns = omega.chunks_mut(3 * count.max(1)).zip(work.chunks_mut(count.max(1)));
    for (index, (body, (rows, work))) in request.bodies.iter().zip(columns).enumerate() {
        let kinetic = |w: &[f64]| (0..3).map(|k| 0.5 * body.moments[k] * w[k] * w[k]).sum::<f64>();
        let factors = if shared { &factors[..] } else { &factors[index * count..][..count] };
        for ((row, work), &factor) in rows.chunks_mut(3).zip(work).zip(factors) {
            row.iter_mut().for_each(|w| *w *= factor);
            *work = rates[index].map_or(0.0, |_| kinetic(row) - kinetic(&body.omega));
        }
    }
    Ok(nanoseconds)
}
