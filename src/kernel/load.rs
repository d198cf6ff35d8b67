//! Loading a body into a lane of a group, and reading a lane.

use super::group::{Group, MAX_STATE};
use super::{Compiled, System};
use crate::forces::{BodyForces, ForcesInterval, Further, MOST_STATES, OrbitPlace};
use crate::kinematics::{attitude_of_rows, dot, half_rows, length, space_axes, to_body_frame, vertical};
use crate::method::{Method, Step, Variables};
use crate::observe::{self, Deviation, Observed};
use crate::scene::{Parameters, Scene};
use crate::simd::{Row, set_lane};
use crate::start::{Body, VERTICAL};
use crate::status::DRIFT_LIMIT;
use std::sync::OnceLock;

impl Body {
    /// The rate that determines the steps of a method: the fastest rate of the body, and the fastest damping rate if
    /// the method is stable only for short steps.
    pub fn step_rate(&self, method: &Method, forces: BodyForces, span: [f64; 2]) -> f64 {
        let turning = self.fastest_rate(forces, span);
        if forces.is_none() || method.is_stiff() {
            return turning;
        }
        let [.., slowing] = forces.damping.rates(self.moments);
        let own = forces.further_step_rate(self.moments, self.omega, turning);
        (turning * turning + slowing * slowing).sqrt() + own
    }
}

impl Body {
    /// The rate over the pace of the anomaly that determines the steps over the anomaly of an orbit on which nothing else
    /// acts: a bound on a circle. On an eccentric orbit it is that of the circle of [`OrbitPlace::circle`] for a body that
    /// begins with its rates at the largest distance; a body whose rates grow in many orbits may be faster.
    pub fn pace_rate(&self, place: &OrbitPlace, farthest: f64) -> f64 {
        let further = Further { orbit: place.circle(), ..Further::NONE };
        let forces = BodyForces { further: &further, ..BodyForces::NONE };
        Body { omega: place.to_slowest_pace(self.omega, farthest), ..*self }.fastest_rate(forces, [0.0; 2])
    }
}

/// How a kernel integrates a body: the step, and the cyclic permutation of the body axes that the step needs.
///
/// A cyclic permutation is exact. Kernel axis i is body axis (i + shift) mod 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelAssignment {
    /// The step of the method for this body.
    pub step: Step,
    /// The permutation.
    shift: usize,
}

impl KernelAssignment {
    /// The assignment of a body, in its own frame.
    ///
    /// The rotor needs the symmetry axis third. The error of planar rotations is four to eight times smaller with the
    /// smallest moment first than with the smallest moment in the middle. Steps that evaluate the equations of motion
    /// use the axes of the user.
    pub fn of(method: &Method, body: &Body, scene: &Scene) -> KernelAssignment {
        let (step, shift) = match body.symmetry_axis() {
            Some(axis) => (method.symmetric, (axis + 1) % 3),
            None => (method.any, body.smallest_moment()),
        };
        let step = if scene.has_weight { step } else { step.torque_free() };
        let shift = if step.engine.variables() == Variables::Rates { 0 } else { shift };
        KernelAssignment { step, shift }
    }

    /// The assignment of a body that is forced, or not.
    pub fn of_either(is_forced: bool, method: &Method, body: &Body, scene: &Scene) -> KernelAssignment {
        if is_forced {
            KernelAssignment::of_forced(method)
        } else {
            KernelAssignment::of(method, body, scene)
        }
    }

    /// The assignment of a body on an orbit on which nothing else acts, by steps over its anomaly if the method has them.
    pub fn on_orbit(method: &Method) -> Option<KernelAssignment> {
        Some(KernelAssignment { step: method.forced?.step.on_orbit()?, shift: 0 })
    }

    /// The assignment of a forced body, in the axes of the user. Panics if the method does not integrate forced bodies.
    pub fn of_forced(method: &Method) -> KernelAssignment {
        let forced = method.forced.expect("checked when the request was made");
        KernelAssignment { step: forced.step, shift: 0 }
    }

    /// A deviation vector in the variables of the kernel: a change of momenta, if the kernel integrates them.
    pub fn deviation(self, deviation: &Deviation, body: &Body) -> Deviation {
        let [d1, d2, d3, x1, x2, x3] = deviation.start;
        let (mut d, x) = (self.to_kernel_axes([d1, d2, d3]), self.to_kernel_axes([x1, x2, x3]));
        let mut inverse_scale = self.to_kernel_axes(deviation.inverse_scale);
        if self.step.engine.variables() == Variables::Momenta {
            let moments = self.to_kernel_axes(body.moments);
            for k in 0..3 {
                d[k] *= moments[k];
                inverse_scale[k] /= moments[k];
            }
        }
        Deviation { start: [d[0], d[1], d[2], x[0], x[1], x[2]], inverse_scale, ..*deviation }
    }

    /// The deviation vector with these numbers of the kernel: a change of the rates and a rotation vector, in the axes
    /// of the user.
    fn deviation_of(self, [mut d, x]: [[f64; 3]; 2], moments: [f64; 3]) -> [f64; 6] {
        if self.step.engine.variables() == Variables::Momenta {
            for k in 0..3 {
                d[k] /= moments[k];
            }
        }
        let ([d1, d2, d3], [x1, x2, x3]) = (self.to_body_axes(d), self.to_body_axes(x));
        [d1, d2, d3, x1, x2, x3]
    }

    #[inline(always)]
    fn to_kernel_axes(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self.shift {
            0 => [a, b, c],
            1 => [b, c, a],
            _ => [c, a, b],
        }
    }

    #[inline(always)]
    fn to_body_axes(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self.shift {
            0 => [a, b, c],
            1 => [c, a, b],
            _ => [b, c, a],
        }
    }
}

/// A state in the user's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Rates in the body.
    pub omega: [f64; 3],
    /// The first direction of the state, if there is one.
    pub direction: Option<[f64; 3]>,
    /// Attitude, if it is integrated.
    pub attitude: Option<[f64; 4]>,
    /// Whether the sign of the quaternion is arbitrary, because the quaternion is computed from rows of the matrix.
    pub sign_is_free: bool,
    /// Energy and conserved momentum, with the arithmetic of the kernel.
    pub invariants: [f64; 2],
    /// Energy and conserved momentum of a top with the vertical that follows from its attitude; this vertical may
    /// differ from the integrated one.
    pub invariants_of_attitude: Option<[f64; 2]>,
    /// The deviation vector, if one is integrated: a change of the rates and a rotation vector in the body.
    pub tangent: Option<[f64; 6]>,
    /// Work and scales of a forced body.
    pub balance: Option<Balance>,
    /// The states of a function, if there are any.
    pub states: Option<[f64; MOST_STATES]>,
}

/// Work of the forces, and scales of the invariants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Work of torque and damping since the start.
    pub work: f64,
    /// Scales of the present energy and conserved momentum, to be added to the scales at the start.
    pub scales: [f64; 2],
}

impl State {
    /// The state in space of a body whose rates are those over the pace of the anomaly, and whose attitude is that seen
    /// from the frame of its orbit. The work of the gravity gradient is what the kinetic energy has gained.
    pub fn at(self, place: &OrbitPlace, start: &Body) -> State {
        let (omega, attitude) = (place.of_pace(self.omega), self.attitude.map(|q| place.of_frame(&q)));
        let work = Body { omega, ..*start }.kinetic_energy() - start.kinetic_energy();
        let direction = attitude.map(|q| to_body_frame(&q, &VERTICAL));
        let [jacobi, _] = self.invariants;
        let balance = Some(Balance { work, scales: [0.0; 2] });
        State { omega, attitude, direction, invariants: [jacobi, 0.0], balance, ..self }
    }
}

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
    /// A body that is not observed, with a bound of |omega| if forces act.
    pub fn unobserved(body: &'a Body, forced_rate: Option<f64>, step: f64) -> Self {
        static NO_FORCES: OnceLock<ForcesInterval<'static, f64>> = OnceLock::new();
        let forces = forced_rate.map(|rate| (NO_FORCES.get_or_init(ForcesInterval::none), rate));
        let (own, states, deviation) = (Further::NONE.start(0.0), [0.0; MOST_STATES], Deviation::NONE);
        Entry { body, forces, axis: 0, step, own, states, place: None, deviation }
    }
}

/// The vector of a body axis: 1, 2, 3 or -1, -2, -3; zeros of any other number.
fn unit_axis(axis: i32) -> [f64; 3] {
    [1, 2, 3].map(|k| if axis.abs() == k { f64::from(axis.signum()) } else { 0.0 })
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
        let least = body.moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        let square = rate * rate;
        group.energy.inverse_scale.0[lane] = 1.0 / (0.5 * least).mul_add(square, pace.kinetic_energy());
        (group.momentum.start.0[lane], group.momentum.inverse_scale.0[lane]) = (0.0, DRIFT_LIMIT / square);
    }
    group.unit.0[lane] = 0.0;
    if kernel.observed == Observed::Nothing {
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

/// Adds the largest energy and momentum that forces can supply to the scales of the drifts; `rate` bounds |omega|.
fn widen_scales(group: &mut Group, lane: usize, system: System, body: &Body, rate: f64) {
    let least = body.moments.iter().fold(f64::INFINITY, |a, &b| a.min(b));
    let momentum = body.moments.iter().fold(0.0_f64, |a, &b| a.max(b)) * rate;
    let momentum = system.scene.conserved.scale(momentum);
    for (rows, gain) in [(&mut group.energy, 0.5 * least * rate * rate), (&mut group.momentum, momentum)] {
        let inverse = rows.inverse_scale.0[lane];
        let scale = if inverse > 0.0 && inverse.is_finite() { 1.0 / inverse } else { 0.0 };
        rows.inverse_scale.0[lane] = if scale + gain > 0.0 { 1.0 / (scale + gain) } else { 0.0 };
    }
}

/// The state of the body in a lane.
pub fn unload(group: &Group, lane: usize, compiled: Compiled, assignment: KernelAssignment) -> State {
    let mut y = [0.0; MAX_STATE];
    for d in 0..compiled.kernel().system.len {
        y[d] = group.state[d].0[lane];
    }
    read(group, lane, compiled, assignment, y)
}

/// The state in the user's axes of the body in a lane, from the state `y` of the kernel.
pub fn read(
    group: &Group,
    lane: usize,
    compiled: Compiled,
    assignment: KernelAssignment,
    mut y: [f64; MAX_STATE],
) -> State {
    let kernel = compiled.kernel();
    let at = |rows: &[Row; 3]| [rows[0].0[lane], rows[1].0[lane], rows[2].0[lane]];
    let parameters = Parameters { moments: at(&group.moments), weight: at(&group.weight), step: 0.0 };
    let moments = &parameters.moments;
    let invariants = compiled.invariants(&parameters, &y);
    let quaternion = kernel.system.quaternion_at;
    let in_rows = kernel.system.has_rows();
    let row = |y: &[f64; MAX_STATE], at: usize| [y[at], y[at + 1], y[at + 2]];
    let tangent = kernel.system.tangent_at;
    let tangent = tangent.map(|at| assignment.deviation_of([row(&y, at), row(&y, at + 3)], *moments));
    // With a quaternion, the space axes are permuted like the body axes.
    let attitude_and_vertical = match quaternion {
        Some(at) => Some(([y[at], y[at + 1], y[at + 2], y[at + 3]], assignment.to_kernel_axes(VERTICAL))),
        None => in_rows.then(|| (attitude_of_rows(&row(&y, 6), &row(&y, 3)), VERTICAL)),
    };
    let has_vertical = kernel.system.scene.has_weight && kernel.system.vectors > 0;
    let invariants_of_attitude = attitude_and_vertical.filter(|_| has_vertical).map(|(q, vertical)| {
        let (mut of_attitude, size) = (y, length(&q));
        of_attitude[3..6].copy_from_slice(&to_body_frame(&q.map(|x| x / size), &vertical));
        compiled.invariants(&parameters, &of_attitude)
    });
    let states = kernel.system.states_at.map(|at| {
        let mut states = [0.0; MOST_STATES];
        states.copy_from_slice(&y[at..at + MOST_STATES]);
        states
    });
    if assignment.step.engine.variables() == Variables::Momenta {
        for k in 0..3 {
            y[k] /= moments[k];
        }
    }
    let omega = [y[0], y[1], y[2]];
    let balance = kernel.system.balance_at.map(|at| {
        let work = y[at];
        let momentum = [0, 1, 2].map(|k| moments[k] * omega[k]);
        let momentum2 = dot(&momentum, &momentum);
        let scale = kernel.system.scene.conserved.scale(momentum2.sqrt());
        Balance { work, scales: [0.5 * dot(&momentum, &omega) + work.abs(), scale] }
    });
    State {
        omega: assignment.to_body_axes([y[0], y[1], y[2]]),
        direction: match quaternion {
            Some(at) if kernel.system.turns => Some(vertical(&[y[at], y[at + 1], y[at + 2], y[at + 3]])),
            _ => (kernel.system.vectors > 0).then(|| assignment.to_body_axes([y[3], y[4], y[5]])),
        },
        attitude: match quaternion {
            Some(at) => {
                let [x, y1, z] = assignment.to_body_axes(row(&y, at + 1));
                Some([y[at], x, y1, z])
            }
            None => in_rows.then(|| {
                attitude_of_rows(&assignment.to_body_axes(row(&y, 6)), &assignment.to_body_axes(row(&y, 3)))
            }),
        },
        sign_is_free: in_rows,
        invariants,
        invariants_of_attitude,
        tangent,
        balance,
        states,
    }
}
