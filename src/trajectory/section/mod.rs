//! Poincaré sections and events: the points at which motions cross surfaces, all of them, by Taylor series with adaptive
//! steps, or under the torque of a function by Runge-Kutta steps whose polynomial is known.
//!
//! The series of a step is the motion inside it, and what is zero on a surface is a polynomial in the state, or the rate
//! of such a quantity. So it is a polynomial inside each step, whose zeros can be counted. In most steps a sum of its
//! coefficients shows that there is none. A body with a closed form may begin each step at its state in closed form:
//! the errors of steps then do not add up.
//!
//! In a second run the same functions tell how far off the surfaces a body is at the times of its points.

mod called;
mod surface_function;
mod zeros;

use super::adaptive_lanes::AdaptiveLanes;
use super::states::invariant_errors;
use super::{Request, check_forced, invariants_at_start, kinds_in};
use crate::body::Body;
use crate::call::Call;
use crate::error::{Error, refuse};
use crate::exact::{CanonicalForm, Evaluator, Question, StartRows, StateRows};
use crate::forces::{ForceSet, MOST_STATES, TorqueCall};
use crate::kernel::{
    AdaptiveSteps, Entry, Job, Kernel, KernelAssignment, Needs, State, System, drive, load, read, unload,
};
use crate::memory;
use crate::method::{Method, Step};
use crate::observe::Observed;
use crate::parallel::over_blocks;
use crate::real::larger;
use crate::scene::TOP;
use crate::simd::{Isa, LANES};
use crate::status::{DRIFT_LIMIT, Status};
use called::{Called, Told};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use surface_function::SurfaceFunction;
use zeros::{Polynomial, Side, TERMS, Zero};

/// Most bodies in a block.
const BLOCK: usize = 256;

/// Steps between two checks of the stop flag, and of the memory.
const STEPS_BETWEEN_STOPS: u64 = 64;

/// Errors of the series and of its evaluation, in the scale of what is zero on the surface.
const NOISE: f64 = 64.0 * f64::EPSILON;

/// Extrema up to this, in the same scale, graze: states are seldom known better.
const NEAR: f64 = 1e-12;

/// Error of a closed form, per radian.
const CLOSED_ERROR: f64 = 1e-15;

/// Most kinds of surfaces of a section.
pub const MOST_KINDS: usize = 32;

/// A surface: `normal . (omega, gamma) + momentum . L + square |omega|² + states . s = value` for the angular momentum `L` in
/// space and the states s of a function, or where the rate of the left side is zero.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Of the rates, then of the vertical in the body.
    pub normal: [f64; 6],
    /// Of the angular momentum in space, that of a rotor included.
    pub momentum: [f64; 3],
    /// Of the square of the speed of rotation.
    pub square: f64,
    /// Of the states of a function.
    pub states: [f64; MOST_STATES],
    /// The value; zero for a rate.
    pub value: f64,
}

/// Cosines between body axes and directions, all of length one: the first is added to the left side of a surface. With a
/// second one the two are, times a positive number, sine and cosine of an angle. The motion is on the surface only where
/// the second is positive, and the rate is that of the angle, times the square of this number.
#[derive(Clone, Copy, Debug)]
pub struct Pointing {
    /// The first body axis and direction, and the second; zeros if there is none.
    pub pairs: [[[f64; 3]; 2]; 2],
    /// Whether the directions have components radial, along and normal in the frame of the orbit; else in space.
    pub in_orbit: bool,
}

impl Pointing {
    /// Whether it is an angle with sine and cosine.
    pub fn is_angle(&self) -> bool {
        self.pairs[1][0] != [0.0; 3]
    }
}

/// What the surfaces of all bodies that are of one kind share.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceKind {
    /// Whether the rate of the left side is zero on the surface.
    pub of_rate: bool,
    /// 1 for rising crossings, -1 for falling ones, 0 for both.
    pub direction: i8,
    /// Whether its points are counted.
    pub counts: bool,
    /// Where a body axis points, if that matters.
    pub pointing: Option<Pointing>,
    /// A function of the user in place of the left side, which writes its value as the first number of a torque.
    pub function: Option<TorqueCall<'static>>,
}

/// The section that is wanted.
#[derive(Clone, Copy)]
pub struct Section<'a> {
    /// The kinds of surfaces, at most `MOST_KINDS`.
    pub kinds: &'a [SurfaceKind],
    /// The surfaces of each body, one of each kind, body after body.
    pub surfaces: &'a [Surface],
    /// Number of points that count after which a body ends.
    pub count: usize,
    /// Whether each step begins at the state in closed form.
    pub closed: bool,
}

/// A point of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Index of the kind of its surface.
    pub kind: u32,
    /// Time.
    pub time: f64,
    /// Rates in the body.
    pub omega: [f64; 3],
    /// The vertical in the body.
    pub gamma: [f64; 3],
    /// Attitude, of the two signs that with a positive first number.
    pub attitude: [f64; 4],
    /// States of a function; zero without any.
    pub states: [f64; MOST_STATES],
    /// Rate of what is zero on the surface.
    pub slope: f64,
    /// What this is times the rate of an angle; one without any.
    pub share: f64,
    /// 1 rising, -1 falling, 0 if the motion touches the surface as far as can be told.
    pub direction: i8,
    /// Whether rounding may decide about the crossing.
    pub grazes: bool,
    /// What is zero on the surface, at this time in a second run; no number without one.
    pub off: f64,
    /// The error of the time; no number if it is not known.
    pub error: f64,
}

/// The points of one body, in the order of their times, and how it ended.
#[derive(Clone, Debug)]
pub struct Crossings {
    /// The points.
    pub points: Vec<Point>,
    /// How the body ended.
    pub status: Status,
    /// A bit for each kind of surface on which the motion stays for a whole step or longer.
    pub stays: u32,
    /// Whether the body ended with a point that counts, the last that was asked for.
    pub stopped: bool,
    /// Largest relative error of the energy at a point or at the end.
    pub energy_drift: f64,
    /// Time at which the motion was left: that of the last point if it was stopped there.
    pub end: f64,
    /// Steps of the body.
    pub steps: u64,
    /// The time from which on the points are lost; infinite if there is none, no number if it is not known.
    pub lost_from: f64,
    /// Number of points that count.
    counted: u64,
}

impl Crossings {
    /// A bit for each kind of surface of which a point may be missed or is doubtful.
    pub fn doubtful(&self) -> u32 {
        if self.status != Status::Finished {
            return u32::MAX;
        }
        let grazing = self.points.iter().filter(|point| point.grazes);
        grazing.fold(self.stays, |kinds, point| kinds | 1 << point.kind)
    }
}

/// The points of all bodies of a request, which has a tolerance, until its last time.
///
/// # Errors
/// If the method is no Taylor series or does not move the bodies, if the request was stopped, or if the points do not
/// fit into memory.
pub fn section(
    request: &Request,
    method: &Method,
    section: &Section,
    call: Call,
) -> Result<Vec<Crossings>, Error> {
    let n = request.bodies.len();
    assert_eq!(section.surfaces.len(), n * section.kinds.len());
    method.check(request.scene)?;
    if section.kinds.len() > MOST_KINDS {
        let rule = "a run watches 32 at most";
        return refuse("events", section.kinds.len(), rule);
    }
    let in_orbit = |kind: &SurfaceKind| kind.pointing.is_some_and(|pointing| pointing.in_orbit);
    let has_orbit = |body: usize| request.forces_of(body).further.orbit.normal().is_some();
    if section.kinds.iter().any(in_orbit) && !(0..n).all(has_orbit) {
        return refuse("events", "a direction of the orbit", "the bodies are on no orbit");
    }
    let forces = ForceSet::from(request.forces.of(0));
    if !method.is_known_inside(forces) {
        let rule = if forces.function {
            "is not known inside its steps under the torque of a function; use 'dop853'"
        } else {
            "only a Taylor method is a polynomial inside its steps, of which no crossing is missed"
        };
        return method.refuse(rule);
    }
    let given = request.tolerance.unwrap_or(f64::NAN);
    if !(f64::MIN_POSITIVE..1.0).contains(&given) {
        return refuse("tolerance", format_args!("{given:e}"), "must be positive and below one");
    }
    if !request.forces.is_none() {
        check_forced(request, method)?;
    }
    let none = Crossings {
        points: Vec::new(),
        status: Status::Finished,
        stays: 0,
        stopped: false,
        energy_drift: 0.0,
        end: 0.0,
        steps: 0,
        lost_from: f64::NAN,
        counted: 0,
    };
    let mut all = memory::filled("sections of bodies", n, none)?;
    run(request, method, section, (&mut all, false), call)?;
    Ok(all)
}

/// Writes what is zero on the surfaces in a second run at the times of known points.
///
/// # Errors
/// If the request was stopped, or does not fit into memory.
pub fn look_again(
    request: &Request,
    method: &Method,
    section: &Section,
    all: &mut [Crossings],
    call: Call,
) -> Result<(), Error> {
    run(request, method, &Section { closed: false, ..*section }, (all, true), call)
}

/// Finds the points of all bodies, or looks at known points again.
fn run(
    request: &Request,
    method: &Method,
    section: &Section,
    (all, again): (&mut [Crossings], bool),
    call: Call,
) -> Result<(), Error> {
    let (n, points) = (all.len(), AtomicU64::new(0));
    let size = n.div_ceil(4).div_ceil(call.threads.max(1)).clamp(LANES, BLOCK);
    let blocks = all.chunks_mut(size).enumerate().map(|(index, part)| (index * size, part));
    let done = over_blocks(blocks, call.threads, call.stop, |(first, crossings)| {
        let block = first..first + crossings.len();
        let mut integrations = memory::reserved("bodies of a block", block.len())?;
        for index in block.clone() {
            integrations.push(Integration::of(request, method, index, section.closed)?);
        }
        for members in kinds_in(block.clone(), |index| integrations[index - first].kind())? {
            let own = (&mut *crossings, &points, again);
            let mut job =
                SectionJob::new(request, section, &integrations, block.clone(), &members, own, call)?;
            drive(&mut job)?;
        }
        Ok(())
    });
    done.map(|_nanoseconds| ())
}

/// How a body is integrated: as a top in its own frame, a free body as one without weight.
#[derive(Clone, Copy)]
struct Integration {
    assignment: KernelAssignment,
    forces: ForceSet,
    /// The closed form that gives the state at the begin of each step.
    form: Option<CanonicalForm>,
}

impl Integration {
    fn of(request: &Request, method: &Method, index: usize, closed: bool) -> Result<Integration, Error> {
        let (body, forces) = (&request.bodies[index], ForceSet::from(request.forces_of(index)));
        let assignment = KernelAssignment::of_either(forces.act, method, body, &TOP);
        let form = if closed && !forces.act { CanonicalForm::of(body) } else { None };
        if closed && form.is_none() {
            return Err(Error::NoClosedForm { index, rule: Question::RULE_OF_STATES });
        }
        Ok(Integration { assignment, forces, form })
    }

    fn kind(&self) -> (Step, ForceSet, Option<Evaluator>) {
        (self.assignment.step, self.forces, self.form.map(CanonicalForm::evaluator))
    }
}

/// The body of an active lane.
#[derive(Clone, Copy)]
struct Task {
    /// Index of the body in the block.
    body: usize,
    /// A bound of its rates.
    rate: f64,
    steps: u64,
    /// The next of its known points.
    next: usize,
}

/// A zero in the last step of a lane.
#[derive(Clone, Copy)]
struct Found {
    zero: Zero,
    slope: f64,
    share: f64,
    kind: usize,
}

/// What is zero on the surfaces of a kind.
#[allow(clippy::large_enum_variant)] // Neither is copied.
enum Function {
    Surface(SurfaceFunction),
    Called(Called),
}

/// Closed forms of the bodies of the lanes.
struct ClosedForms {
    evaluator: Evaluator,
    isa: Isa,
    starts: StartRows,
    now: [StateRows; 1],
}

/// The sections of the bodies of a block that one kernel integrates.
struct SectionJob<'a> {
    request: &'a Request<'a>,
    section: &'a Section<'a>,
    integrations: &'a [Integration],
    block: Range<usize>,
    /// Indices in the block of the bodies that wait.
    queue: Vec<usize>,
    lanes: AdaptiveLanes<'a>,
    closed: Option<ClosedForms>,
    /// What is zero on the surfaces of each kind.
    functions: Vec<Function>,
    /// The zeros of the last step of a lane.
    found: Vec<Found>,
    crossings: &'a mut [Crossings],
    /// Points of all bodies, of all threads.
    points: &'a AtomicU64,
    /// Whether the points are known.
    again: bool,
    /// Room for the state and its rate at a known point.
    here: AdaptiveSteps,
    /// Rounds of the group.
    rounds: u64,
}

impl<'a> SectionJob<'a> {
    fn new(
        request: &'a Request<'a>,
        section: &'a Section<'a>,
        integrations: &'a [Integration],
        block: Range<usize>,
        members: &[usize],
        (crossings, points, again): (&'a mut [Crossings], &'a AtomicU64, bool),
        call: Call<'a>,
    ) -> Result<Self, Error> {
        let integration = integrations[members[0]];
        let needs = Needs {
            forces: integration.forces,
            directions: 1,
            attitude: true,
            tangent: false,
            is_changed: false,
        };
        let step = integration.assignment.step;
        let kernel =
            Kernel { system: System::carrying(&TOP, step, needs), step, observed: Observed::Nothing };
        // The polynomial of a Runge-Kutta step is no series cut at its order: the product of the momentum and of two parts
        // of the quaternion has all their terms.
        // At a known point the state and its rate are enough.
        let order = if again { 1 } else { step.numbers.order * if step.is_series() { 1 } else { 3 } };
        let waits = |&member: &usize| !again || !crossings[member].points.is_empty();
        let queue = members.iter().rev().copied().filter(waits);
        let function = |&kind: &SurfaceKind| match kind.function {
            Some(function) => Function::Called(Called::new(function, kind.direction)),
            None => Function::Surface(SurfaceFunction::new(kind, kernel.system, order)),
        };
        let closed = integration.form.map(|form| ClosedForms {
            evaluator: form.evaluator(),
            isa: call.isa,
            starts: StartRows::filled(&form.to_canonical(&request.bodies[block.start + members[0]])),
            now: [StateRows::ZERO],
        });
        let tolerance = request.tolerance.expect("checked at the begin");
        Ok(SectionJob {
            request,
            section,
            integrations,
            block,
            queue: memory::collected("bodies of a block", members.len(), queue)?,
            lanes: AdaptiveLanes::new(request, kernel, call, tolerance)?,
            closed,
            functions: memory::collected(
                "surfaces",
                section.kinds.len(),
                section.kinds.iter().map(function),
            )?,
            found: Vec::new(),
            crossings,
            points,
            again,
            here: AdaptiveSteps::inactive(tolerance, 1)?,
            rounds: 0,
        })
    }

    /// Sets all lanes that have moved to their states in closed form.
    fn begin_in_closed_form(&mut self, tasks: &[Option<Task>; LANES]) {
        let Some(closed) = &mut self.closed else { return };
        closed.evaluator.states(closed.isa, &closed.starts, &self.lanes.steps.now[..1], &mut closed.now);
        for lane in 0..LANES {
            let Some(task) = tasks[lane] else { continue };
            if self.lanes.steps.now[0].0[lane] == 0.0 {
                continue;
            }
            let (index, integration) = (self.block.start + task.body, self.integrations[task.body]);
            let body = &self.request.bodies[index];
            let omega = [0, 1, 2].map(|k| closed.now[0].omega[k].0[lane]);
            let attitude = [0, 1, 2, 3].map(|k| closed.now[0].attitude[k].0[lane]);
            let form = integration.form.expect("all bodies of the batch have a closed form");
            let (omega, attitude) = form.to_body(body, omega, attitude);
            let now = Body { omega, attitude, ..*body };
            let (forces, step) = (self.request.forces_of(index), self.lanes.group.step.0[lane]);
            let entry = Entry::unobserved(&now, forces, (0.0, None), None, step);
            load(&mut self.lanes.group, lane, self.lanes.kernel, integration.assignment, &entry);
            self.lanes.steps.now[1].0[lane] = 0.0;
        }
    }

    /// Refuses points beyond the memory of the machine, which has to hold them twice when they are returned.
    fn check_memory(&self) -> Result<(), Error> {
        let points = self.points.load(Ordering::Relaxed);
        memory::check("points of a section", 2 * u128::from(points) * size_of::<Point>() as u128)
    }

    /// Finds the points of the last step of a lane. Whether its body moves on.
    fn after_step(&mut self, lane: usize, task: Task, own: &mut Crossings) -> Result<bool, Error> {
        own.steps = task.steps;
        let now = self.lanes.steps.now[0].0[lane];
        if !now.is_finite() {
            own.status = Status::NotFinite;
            own.energy_drift = f64::NAN;
            return Ok(self.leave(lane));
        }
        let [_, end] = self.request.range_of(self.block.start + task.body);
        own.end = now.min(end);
        let error = if self.closed.is_some() { CLOSED_ERROR * task.rate * now } else { 0.0 };
        if !self.find_zeros(lane, task, error, own) {
            own.status = Status::NotFinite;
            return Ok(self.leave(lane));
        }
        if self.section.kinds.len() > 1 {
            self.found.sort_unstable_by(|a, b| a.zero.at.total_cmp(&b.zero.at).then(a.kind.cmp(&b.kind)));
        }
        for index in 0..self.found.len() {
            let found = self.found[index];
            let point = self.point(lane, task, found, own);
            if !(point.time > 0.0) {
                continue;
            }
            if point.time > end {
                break;
            }
            if own.points.len() == own.points.capacity() {
                self.check_memory()?;
            }
            memory::push("points of a section", &mut own.points, point)?;
            self.points.fetch_add(1, Ordering::Relaxed);
            own.counted += u64::from(self.section.kinds[found.kind].counts);
            if own.counted >= self.section.count as u64 {
                own.end = point.time;
                own.stopped = true;
                return Ok(self.leave(lane));
            }
        }
        if now >= end {
            let assignment = self.integrations[task.body].assignment;
            self.note_drift(lane, &unload(&self.lanes.group, lane, self.lanes.kernel, assignment), own);
            return Ok(self.leave(lane));
        }
        if task.steps >= self.request.max_steps {
            own.status = Status::StepLimit;
            return Ok(self.leave(lane));
        }
        Ok(self.go_on(lane, task))
    }

    /// Writes what is zero on the surfaces at the known points of the last step of a lane. Whether its body moves on.
    fn look_at_points(&mut self, lane: usize, task: &mut Task, points: &mut [Point]) -> bool {
        let mut functions = std::mem::take(&mut self.functions);
        let (steps, group) = (&self.lanes.steps, &self.lanes.group);
        let ([begin, lost], now) = (steps.begin.each_ref().map(|row| row.0[lane]), steps.now[0].0[lane]);
        while let Some(point) = points.get_mut(task.next).filter(|point| point.time <= now) {
            let passed = (point.time - begin) - lost;
            point.off = match &mut functions[point.kind as usize] {
                Function::Surface(surface) => {
                    surface.value(lane, passed / steps.unit.0[lane], group, (steps, &mut self.here))
                }
                Function::Called(called) => {
                    called.value(lane, self.told(lane, *task, passed / group.step.0[lane]))
                }
            };
            task.next += 1;
        }
        self.functions = functions;
        if task.next == points.len() || !now.is_finite() || task.steps >= self.request.max_steps {
            return self.leave(lane);
        }
        self.go_on(lane, *task)
    }

    /// Aims at the end of a body under the forces of its next step.
    fn go_on(&mut self, lane: usize, task: Task) -> bool {
        let index = self.block.start + task.body;
        if self.lanes.pass_knot(lane, index, false) {
            for function in &mut self.functions {
                if let Function::Surface(surface) = function {
                    // The torque may jump there, and the slope with it.
                    surface.bend(lane);
                }
            }
        }
        self.lanes.aim(lane, self.request.range_of(index)[1], false);
        true
    }

    /// The state at a zero in the last step of a lane.
    fn point(
        &self,
        lane: usize,
        task: Task,
        Found { zero, slope, share, kind }: Found,
        own: &mut Crossings,
    ) -> Point {
        let (time, state, attitude) = self.inside(lane, task, zero.at);
        self.note_drift(lane, &state, own);
        Point {
            kind: kind as u32,
            time,
            omega: state.omega,
            gamma: state.direction.expect("the system has the vertical"),
            attitude,
            states: state.states.unwrap_or([0.0; MOST_STATES]),
            slope,
            share,
            direction: zero.direction,
            grazes: zero.grazes,
            off: f64::NAN,
            error: f64::NAN,
        }
    }

    /// Time, state, and attitude with a scalar that is not negative, at a share of the last step of a lane.
    fn inside(&self, lane: usize, task: Task, share: f64) -> (f64, State, [f64; 4]) {
        let adaptive = &self.lanes.steps;
        let units = self.lanes.group.step.0[lane] / adaptive.unit.0[lane] * share;
        let time = adaptive.begin[0].0[lane] + (adaptive.begin[1].0[lane] + units * adaptive.unit.0[lane]);
        let y = self.lanes.kernel.dense_output(adaptive, lane, units);
        let state =
            read(&self.lanes.group, lane, self.lanes.kernel, self.integrations[task.body].assignment, y);
        let attitude = state.attitude.expect("the system has an attitude");
        (time, state, if attitude[0] < 0.0 { attitude.map(|x| -x) } else { attitude })
    }

    /// What functions are told at a share of the last step of a lane.
    fn told(&self, lane: usize, task: Task, share: f64) -> Told {
        let (time, State { omega, states, .. }, attitude) = self.inside(lane, task, share);
        let place = self.request.forces_of(self.block.start + task.body).place(time);
        Told { time, omega, attitude, states: states.unwrap_or([0.0; MOST_STATES]), place }
    }

    /// Finds the zeros in the last step of a lane; returns whether all functions return numbers.
    fn find_zeros(&mut self, lane: usize, task: Task, error: f64, own: &mut Crossings) -> bool {
        let (mut functions, mut all) = (std::mem::take(&mut self.functions), std::mem::take(&mut self.found));
        let step = self.lanes.group.step.0[lane];
        all.clear();
        let mut are_finite = true;
        for (kind, function) in functions.iter_mut().enumerate() {
            let mut found =
                |zero, [slope, share]: [f64; 2]| all.push(Found { zero, slope: slope / step, share, kind });
            let stays = match function {
                Function::Surface(surface) => Some(surface.zeros(lane, error, &mut found)),
                Function::Called(called) => {
                    called.zeros(lane, error, &|share| self.told(lane, task, share), &mut found)
                }
            };
            are_finite &= stays.is_some();
            own.stays |= u32::from(stays == Some(true)) << kind;
        }
        (self.functions, self.found) = (functions, all);
        are_finite
    }

    /// Notes the errors of the invariants of a state.
    fn note_drift(&self, lane: usize, state: &State, own: &mut Crossings) {
        // A closed form does not drift.
        if self.closed.is_some() {
            return;
        }
        let errors = invariant_errors(state, invariants_at_start(&self.lanes.group, lane));
        for [energy, momentum] in errors.into_iter().flatten() {
            own.energy_drift = larger(own.energy_drift, energy);
            if own.status == Status::Finished && !(energy <= DRIFT_LIMIT && momentum <= DRIFT_LIMIT) {
                let finite = energy.is_finite() && momentum.is_finite();
                own.status = if finite { Status::Drifted } else { Status::NotFinite };
            }
        }
    }

    fn leave(&mut self, lane: usize) -> bool {
        self.lanes.leave(lane);
        false
    }
}

impl Job for SectionJob<'_> {
    type Task = Task;

    fn load(&mut self, lane: usize) -> Result<Option<Task>, Error> {
        let Some(member) = self.queue.pop() else { return Ok(None) };
        self.lanes.entered += 1;
        let (index, integration) = (self.block.start + member, self.integrations[member]);
        let (body, forces) = (&self.request.bodies[index], self.request.forces_of(index));
        let range = self.request.range_of(index);
        let rate = self.lanes.enter(lane, index, integration.assignment, range, false);
        self.lanes.aim(lane, range[1], false);
        if let (Some(closed), Some(form)) = (&mut self.closed, integration.form) {
            closed.starts.set(lane, &form.to_canonical(body));
        }
        let surfaces = &self.section.surfaces[index * self.section.kinds.len()..];
        for (function, surface) in self.functions.iter_mut().zip(surfaces) {
            match function {
                Function::Surface(own) => own.enter(lane, surface, body, forces, rate),
                Function::Called(called) => called.enter(lane, surface),
            }
        }
        Ok(Some(Task { body: member, rate, steps: 0, next: 0 }))
    }

    /// One step: each is searched for points.
    fn advance(&mut self, tasks: &[Option<Task>; LANES]) -> Result<(), Error> {
        self.begin_in_closed_form(tasks);
        if self.rounds.is_multiple_of(STEPS_BETWEEN_STOPS) {
            self.lanes.tell(tasks, |task| self.block.start + task.body)?;
            self.check_memory()?;
        }
        self.rounds += 1;
        self.lanes.advance(1);
        for function in &mut self.functions {
            if let Function::Surface(surface) = function
                && !self.again
            {
                surface.expand(&self.lanes.group, &self.lanes.steps);
            }
        }
        Ok(())
    }

    fn look(&mut self, lane: usize, task: &mut Task) -> Result<bool, Error> {
        let made = self.lanes.made(lane);
        if made == 0 {
            return Ok(true);
        }
        task.steps += made;
        let crossings = std::mem::take(&mut self.crossings);
        let own = &mut crossings[task.body];
        let moves_on = if self.again {
            Ok(self.look_at_points(lane, task, &mut own.points))
        } else {
            self.after_step(lane, *task, own)
        };
        self.crossings = crossings;
        moves_on
    }
}
