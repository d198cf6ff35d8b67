//! The errors of the times at which bodies cross surfaces, from a second run by a method of another order, or from the error
//! of a closed form.

use super::comparison::{BETWEEN_QUESTIONS, SAFETY};
use super::second_run::{ELSEWHERE, TIGHTER};
use crate::call::Call;
use crate::error::Error;
use crate::estimate::error_of_closed_form;
use crate::forces::MOST_STATES;
use crate::kinematics::length;
use crate::method::{AnyMethod, Method, SERIES, TO_ROUNDING};
use crate::real::larger;
use crate::simd::Isa;
use crate::trajectory::{
    Crossings, MOST_KINDS, Request, Section, Surface, default_steps, look_again, section,
};

/// The tolerance of a series at which rounding alone is left: the last terms of a step are a sixteenth of it.
pub const CROSSING_TOLERANCE: f64 = 1.0 / (1_u64 << 57) as f64;

/// Largest error of a point, in the scale of the surface, before the point counts as lost.
const LOST: f64 = 1e-3;

/// Roundings of what is zero on the surface, in its scale, that two runs may share.
const ROUNDINGS: f64 = 4.0;

/// The points of all bodies, as [`section`], with the errors of their times: of closed forms, and if wanted those that a
/// second run tells.
///
/// # Errors
/// As `section`.
pub fn crossings(
    request: &Request,
    method: &'static Method,
    asked: &Section,
    check: bool,
    call: Call,
) -> Result<Vec<Crossings>, Error> {
    let n = request.bodies.len();
    let calls = asked.kinds.iter().any(|kind| kind.function.is_some());
    let runs = if check && (calls || !asked.closed) { 2 } else { 1 };
    call.stop.expect(runs * n, 0..runs * n);
    let mut all = section(request, method, asked, call)?;
    if runs == 2 {
        second_run(request, method, asked, &mut all, call)?;
    }
    if check || asked.closed {
        for (index, own) in all.iter_mut().enumerate() {
            if index % BETWEEN_QUESTIONS == 0 && call.stop.is_wanted() {
                return Err(Error::Stopped);
            }
            let surfaces = &asked.surfaces[index * asked.kinds.len()..];
            judge(own, (request, index), (asked, surfaces), runs == 2, call.isa);
        }
    }
    Ok(all)
}

/// Looks at the points in a second run.
fn second_run(
    request: &Request,
    method: &'static Method,
    asked: &Section,
    all: &mut [Crossings],
    call: Call,
) -> Result<(), Error> {
    let (other, refinement) = if !method.is_series() {
        // No other is known inside its steps under a function.
        (method, ELSEWHERE)
    } else if method.facts.name == TO_ROUNDING.facts.name {
        (SERIES, 1.0)
    } else {
        (TO_ROUNDING, 1.0)
    };
    let tolerance = request.tolerance.map(|given| (given / TIGHTER).max(given.min(CROSSING_TOLERANCE)));
    let forces = &request.forces.doubted()?;
    let steps = &default_steps(other, request.bodies, forces, &request.schedule)?;
    let again = Request { forces, method: AnyMethod::Steps(other), steps, refinement, tolerance, ..*request };
    look_again(&again, other, asked, all, call)
}

/// Writes the errors of the times of the points of a body, and from when on the points are lost.
fn judge(
    own: &mut Crossings,
    (request, body): (&Request, usize),
    (asked, surfaces): (&Section, &[Surface]),
    is_checked: bool,
    isa: Isa,
) {
    let (range, forces, body) = (request.range_of(body), request.forces_of(body), &request.bodies[body]);
    let mut rate = body.fastest_rate(forces, range);
    if forces.function.is_some() {
        // There may be no bound.
        rate = own.points.iter().map(|point| length(&point.omega)).fold(rate, f64::max);
    }
    let mut grown = [0.0; MOST_KINDS];
    own.lost_from = f64::INFINITY;
    for point in &mut own.points {
        let index = point.kind as usize;
        let (kind, surface, slope) = (&asked.kinds[index], &surfaces[index], point.slope.abs());
        let calls = kind.function.is_some();
        if calls && !(is_checked && slope.is_finite()) {
            // Nothing tells its error but a second run, nothing its scale where it jumps.
            continue;
        }
        let mut scale = kind.scale(surface, body, forces, rate);
        if calls || surface.states != [0.0; MOST_STATES] {
            // Nothing tells the size of a state but its start and its rate, of a function its rate.
            scale = larger(scale, slope * point.time);
        }
        let off = if asked.closed && !calls {
            // Of a free body the rates do not matter.
            let fastest = if body.weight == [0.0; 3] { 0.0 } else { length(&point.omega) };
            error_of_closed_form(isa, body, forces, [0.0, point.time], fastest)[0] * scale
        } else {
            // Errors grow along a motion; where two runs agree by chance, those before still count.
            grown[index] = larger(grown[index], point.off.abs());
            SAFETY * grown[index]
        };
        let rounding = ROUNDINGS * f64::EPSILON * (scale + surface.value.abs());
        point.error = (off + rounding) / slope + (point.time.next_up() - point.time);
        // A NaN is not below.
        if !(off <= LOST * scale) {
            own.lost_from = own.lost_from.min(point.time);
        }
    }
}
