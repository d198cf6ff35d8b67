//! Loading a body into a lane of a group.

use super::group::{Group, MAX_STATE};
use super::{Compiled, KernelAssignment, System};
use crate::body::Body;
use crate::forces::{BodyForces, ForcesInterval, Further, MOST_STATES, OrbitPlace};
use crate::inertia::moment_range;
use crate::kinematics::{half_rows, space_axes, to_body_frame};
use crate::method::Variables;
use crate::observe::{self, Deviation, Observed};
use crate::scene::Parameters;
use crate::simd::set_lane;
use crate::status::DRIFT_LIMIT;
use std::sync::OnceLock;

/// The state of a body in the variables of a kernel.
fn kernel_state(
    system: System,
    assignment: KernelAssignment,
    body: &Body,
    observed_axis: [f64; 3],
) -> [f64; MAX_STATE] {
    let mut y = [0.0; MAX_STATE];
    let (moments, omega) = (assignment.to_kernel_axes(body.moments), assignment.to_kernel_axes(body.omega));
    for k in 0..3 {
        y[k] = match assignment.step.engine.variables() {
            Variables::Rates => omega[k],
            Variables::Momenta => moments[k] * omega[k],
        };
    }
    let in_kernel_axes = |axis: [f64; 3]| assignment.to_kernel_axes(to_body_frame(&body.attitude, &axis));
    let is_observed = observed_axis != [0.0; 3];
    for v in 0..system.vectors {
        let direction = match v {
            0 if is_observed && !system.scene.has_weight && system.vectors < 3 => observed_axis,
            0 => assignment.to_kernel_axes(body.gamma()),
            1 if is_observed && system.vectors < 3 => observed_axis,
            1 => in_kernel_axes([1.0, 0.0, 0.0]),
            _ => in_kernel_axes([0.0, 1.0, 0.0]),
        };
        y[3 + 3 * v..6 + 3 * v].copy_from_slice(&direction);
    }
    if let Some(at) = system.quaternion_at {
        let [w, x, y1, z] = body.attitude;
        y[at] = w;
        y[at + 1..at + 4].copy_from_slice(&assignment.to_kernel_axes([x, y1, z]));
    }
    y
}

/// A body to be loaded into a lane.
pub struct Entry<'a> {
    /// The body.
    pub body: &'a Body,
    /// The forces from the start on, and a bound of |omega| under it, over the pace of an anomaly that takes the place of
    /// the time; `None` without forces.
    pub forces: Option<(&'a ForcesInterval<'a, f64>, f64)>,
    /// The observed body axis: 1, 2, 3 or -1, -2, -3; 0 for none. The direction integrated with a free body is the
    /// initial direction of this axis, or the vertical.
    pub axis: i32,
    /// Time step.
    pub step: f64,
    /// The variables of further forces at the start.
    pub own: [f64; Further::VARIABLES],
    /// The states of a function at the start.
    pub states: [f64; MOST_STATES],
    /// The place on the orbit at the start, for systems that take its anomaly for the time.
    pub place: Option<OrbitPlace>,
    /// The deviation vector at the start, for systems that integrate one.
    pub deviation: Deviation,
}

impl<'a> Entry<'a> {
    /// A body that is not observed, with the variables that these forces need at a time, or at a place on its orbit whose
    /// anomaly takes the place of the time. With a bound of |omega| the scales of the drifts are those of a forced body.
    pub fn unobserved(
        body: &'a Body,
        acting: BodyForces,
        (time, place): (f64, Option<OrbitPlace>),
        forced_rate: Option<f64>,
        step: f64,
    ) -> Self {
        static NO_FORCES: OnceLock<ForcesInterval<'static, f64>> = OnceLock::new();
        let forces = forced_rate.map(|rate| (NO_FORCES.get_or_init(ForcesInterval::none), rate));
        let own = place.map_or_else(|| acting.further.start(time), |place| place.clock());
        let (states, deviation) = (acting.states(), Deviation::NONE);
        Entry { body, forces, axis: 0, step, own, states, place, deviation }
    }
}

/// The vector of a body axis: 1, 2, 3 or -1, -2, -3; zeros of any other number.
fn unit_axis(axis: i32) -> [f64; 3] {
    [1, 2, 3].map(|k| if axis.unsigned_abs() == k { f64::from(axis.signum()) } else { 0.0 })
}

/// Loads a body into a lane.
pub fn load(group: &mut Group, lane: usize, compiled: Compiled, assignment: KernelAssignment, entry: &Entry) {
    let &Entry { body, forces, axis, step, ref own, ref states, ref place, ref deviation } = entry;
    let kernel = compiled.kernel();
    let unit_of = |axis: i32| assignment.to_kernel_axes(unit_axis(axis));
    let (unit, second_unit) = (unit_of(axis), unit_of(kernel.observed.second_axis()));
    let mut y = kernel_state(kernel.system, assignment, body, unit);
    if let Some(at) = kernel.system.own_at {
        y[at..at + own.len()].copy_from_slice(own);
    }
    if let Some(at) = kernel.system.states_at {
        y[at..at + states.len()].copy_from_slice(states);
    }
    if let Some(place) = place {
        y[..3].copy_from_slice(&place.to_pace(body.omega));
        y[3..7].copy_from_slice(&place.to_frame(&body.attitude));
    }
    let deviation = assignment.deviation(deviation, body);
    if let Some(at) = kernel.system.tangent_at {
        y[at..at + 6].copy_from_slice(&deviation.start);
    }
    let parameters = Parameters {
        moments: assignment.to_kernel_axes(body.moments),
        weight: assignment.to_kernel_axes(body.weight),
        step,
    };
    group.used = group.used.max(lane + 1);
    let length = kernel.system.len;
    set_lane(&mut group.state, lane, &y[..length]);
    set_lane(&mut group.compensation, lane, &[0.0; MAX_STATE][..length]);
    set_lane(&mut group.moments, lane, &parameters.moments);
    set_lane(&mut group.weight, lane, &parameters.weight);
    group.step.0[lane] = step;
    group.count.0[lane] = 0.0;

    let [energy, momentum] = compiled.invariants(&parameters, &y);
    let moves = body.omega.iter().chain(&body.weight).any(|&x| x != 0.0);
    let [energy_scale, momentum_scale] = (kernel.system.scene.invariant_scales)(body);
    for (rows, start, scale) in
        [(&mut group.energy, energy, energy_scale), (&mut group.momentum, momentum, momentum_scale)]
    {
        rows.start.0[lane] = start;
        // A body that cannot move has no drift. If a scale underflows, the drift becomes NaN.
        rows.inverse_scale.0[lane] = if moves { 1.0 / scale } else { 0.0 };
        rows.worst.0[lane] = 0.0;
    }

    if let (Some((_, rate)), None) = (forces, place) {
        widen_scales(group, lane, kernel.system, body, rate);
    }
    if place.is_some() {
        // The rates and their bound are over the pace of the anomaly. Rates beyond the bound count as a drift.
        let (pace, rate) =
            (Body { omega: [y[0], y[1], y[2]], ..*body }, forces.map_or(0.0, |(_, rate)| rate));
        let ([least, _], square) = (moment_range(body.moments), rate * rate);
        group.energy.inverse_scale.0[lane] = 1.0 / (0.5 * least).mul_add(square, pace.kinetic_energy());
        (group.momentum.start.0[lane], group.momentum.inverse_scale.0[lane]) = (0.0, DRIFT_LIMIT / square);
    }
    group.unit.0[lane] = 0.0;
    if matches!(kernel.observed, Observed::Nothing) {
        return;
    }
    let mut frame = [[y[3], y[4], y[5]], [y[6], y[7], y[8]]];
    let at = kernel.system.observed_at;
    let mut direction = [y[at], y[at + 1], y[at + 2]];
    if let Some(at) = kernel.system.quaternion_at.filter(|_| kernel.system.turns) {
        let [third, first, _] = space_axes(&[y[at], y[at + 1], y[at + 2], y[at + 3]]);
        frame = [third, first];
        direction = if kernel.system.is_forced() { third } else { unit };
    }
    let (mut rates, mut momentum) = ([y[0], y[1], y[2]], [y[0], y[1], y[2]]);
    for k in 0..3 {
        match assignment.step.engine.variables() {
            Variables::Rates => momentum[k] *= parameters.moments[k],
            Variables::Momenta => rates[k] /= parameters.moments[k],
        }
    }
    let on_orbit = place.as_ref().map(|place| {
        let axes = half_rows(&[y[3], y[4], y[5], y[6]]).map(|half| half.map(|x| x + x));
        let [cos, sin] = place.direction();
        frame = [axes[2], [0, 1, 2].map(|k| cos * axes[0][k] - sin * axes[1][k])];
        rates = body.omega;
        momentum = [0, 1, 2].map(|k| body.moments[k] * rates[k]);
        (place, axes)
    });
    let start = observe::Start {
        body,
        forces: forces.map(|(forces, rate)| (forces, rate * place.as_ref().map_or(1.0, OrbitPlace::rate))),
        axis,
        unit,
        second_unit,
        direction,
        deviation: &deviation,
        own,
        states,
        on_orbit,
        rates,
        momentum,
        frame,
    };
    group.set_observed(lane, &kernel.observed.start(&start));
}

/// Sets the time of a forced body to zero: the torque is given as a function of the time since the begin of an
/// interval.
pub fn reset_time(group: &mut Group, system: System, lane: usize) {
    let time = system.balance_at.expect("only forced bodies have a time") + 2;
    group.state[time].0[lane] = 0.0;
    group.compensation[time].0[lane] = 0.0;
}

/// The scale that this is the inverse of; zero if there is none.
pub fn scale_of(inverse: f64) -> f64 {
    if inverse > 0.0 && inverse.is_finite() { 1.0 / inverse } else { 0.0 }
}

/// Adds the largest energy and momentum that forces can supply to the scales of the drifts; `rate` bounds |omega|.
fn widen_scales(group: &mut Group, lane: usize, system: System, body: &Body, rate: f64) {
    let [least, largest] = moment_range(body.moments);
    let momentum = system.scene.conserved.scale(largest * rate);
    for (rows, gain) in [(&mut group.energy, 0.5 * least * rate * rate), (&mut group.momentum, momentum)] {
        let scale = scale_of(rows.inverse_scale.0[lane]);
        rows.inverse_scale.0[lane] = if scale + gain > 0.0 { 1.0 / (scale + gain) } else { 0.0 };
    }
}
