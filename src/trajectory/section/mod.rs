//! Poincaré sections: the points at which motions cross a surface, all of them, by Taylor series with adaptive steps.
//!
//! The series of a step is the motion inside it, and what is zero on the surface is linear in rates and vertical, or the
//! rate of such a quantity. So it is a polynomial inside each step, whose zeros can be counted. In most steps a sum of
//! its coefficients shows that there is none.

mod zeros;

use super::states::{invariant_errors, worse};
use super::{Request, check_forced, invariants_at_start, kinds_in};
use crate::error::Error;
use crate::kernel::{AdaptiveSteps, Compiled, Entry, ForcingRows, Group, Kernel, KernelAssignment};
use crate::kernel::{Needs, State, System, load, read, reset_time, unload};
use crate::memory;
use crate::observe::Observed;
use crate::parallel::{Interrupt, over_blocks};
use crate::scene::TOP;
use crate::scheme::{Scheme, Step};
use crate::simd::{Isa, LANES, Row};
use crate::status::{DRIFT_LIMIT, Status};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use zeros::{Polynomial, Side, TERMS};

/// Most bodies in a block.
const BLOCK: usize = 256;

/// Steps between two checks of the stop flag, and of the memory.
const STEPS_BETWEEN_STOPS: u64 = 64;

/// Errors of the series and of its evaluation, in the scale of what is zero on the surface.
const NOISE: f64 = 64.0 * f64::EPSILON;

/// Extrema up to this, in the same scale, graze: states are seldom known better.
const NEAR: f64 = 1e-12;

/// A surface: `normal . (omega, gamma) = value`, or where the rate of the left side is zero.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Of the rates, then of the vertical in the body.
    pub normal: [f64; 6],
    /// The value; zero for a rate.
    pub value: f64,
}

/// The section that is wanted.
pub struct Section<'a> {
    /// The surface of each body.
    pub surfaces: &'a [Surface],
    /// Whether the rate of `normal . (omega, gamma)` is zero on the surface.
    pub of_rate: bool,
    /// 1 for rising crossings, -1 for falling ones, 0 for both.
    pub direction: i8,
    /// Most points of a body.
    pub count: usize,
    /// Time at which the motions end.
    pub end: f64,
}

/// A point of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Time.
    pub time: f64,
    /// Rates in the body.
    pub omega: [f64; 3],
    /// The vertical in the body.
    pub gamma: [f64; 3],
    /// Attitude, of the two signs that with a positive first number.
    pub attitude: [f64; 4],
    /// Rate of what is zero on the surface.
    pub slope: f64,
    /// 1 rising, -1 falling, 0 if the motion touches the surface as far as can be told.
    pub direction: i8,
    /// Whether rounding may decide about the crossing.
    pub grazes: bool,
}

/// The points of one body, in the order of their times, and how it ended.
#[derive(Clone, Debug)]
pub struct Crossings {
    /// The points.
    pub points: Vec<Point>,
    /// How the body ended.
    pub status: Status,
    /// Whether the motion stays on the surface for a whole step or longer.
    pub stays: bool,
    /// Largest relative error of the energy at a point or at the end.
    pub energy_drift: f64,
    /// Time at which the motion was left: that of the last point if there are enough.
    pub end: f64,
    /// Steps of the body.
    pub steps: u64,
}

/// The points of all bodies of a request, which has a tolerance; its schedule is ignored.
///
/// # Errors
/// If the method is no Taylor series or does not move the bodies, if the request was stopped, or if the points do not
/// fit into memory.
pub fn section(
    request: &Request,
    scheme: &Scheme,
    section: &Section,
    threads: usize,
    isa: Isa,
    stop: &Interrupt,
) -> Result<Vec<Crossings>, Error> {
    let n = request.bodies.len();
    assert_eq!(section.surfaces.len(), n);
    scheme.check(request.scene, false)?;
    let refused = |argument, value, rule| Err(Error::Value { argument, value, rule });
    if !scheme.is_series() {
        let rule = "only a Taylor method is a polynomial inside its steps, of which no crossing is missed";
        return refused("method", format!("'{}'", scheme.facts.name), rule);
    }
    let given = request.tolerance.unwrap_or(f64::NAN);
    if !(f64::MIN_POSITIVE..1.0).contains(&given) {
        return refused("tolerance", format!("{given:e}"), "must be positive and below one");
    }
    if !request.forcing.is_none() {
        check_forced(request, scheme)?;
    }
    let none = Crossings {
        points: Vec::new(),
        status: Status::Finished,
        stays: false,
        energy_drift: 0.0,
        end: 0.0,
        steps: 0,
    };
    let mut all = memory::filled("sections of bodies", n, none)?;
    let points = AtomicU64::new(0);
    let size = n.div_ceil(4 * threads.max(1)).clamp(LANES, BLOCK);
    let blocks = all.chunks_mut(size).enumerate().map(|(index, part)| (index * size, part));
    over_blocks(blocks, threads, stop, |(first, crossings)| {
        let block = first..first + crossings.len();
        let ways = block.clone().map(|index| Way::of(request, scheme, index));
        let ways = memory::collected("bodies of a block", block.len(), ways)?;
        for members in kinds_in(block.clone(), |index| ways[index - first].kind())? {
            let batch = Batch::new(request, section, &ways, block.clone(), &members, isa, &points)?;
            batch.run(crossings, stop)?;
        }
        Ok(())
    })?;
    Ok(all)
}

/// How a body is integrated: as a top in its own frame, a free body as one without weight.
#[derive(Clone, Copy)]
struct Way {
    assignment: KernelAssignment,
    is_forced: bool,
    is_satellite: bool,
}

impl Way {
    fn of(request: &Request, scheme: &Scheme, index: usize) -> Way {
        let (body, forcing) = (&request.bodies[index], request.forcing_of(index));
        let (is_forced, is_satellite) = (!forcing.is_none(), forcing.is_satellite());
        let assignment = match is_forced {
            true => KernelAssignment::of_forced(scheme, body),
            false => KernelAssignment::of(scheme, body, &TOP),
        };
        Way { assignment, is_forced, is_satellite }
    }

    fn kind(&self) -> (Step, bool, bool) {
        (self.assignment.step, self.is_forced, self.is_satellite)
    }
}

/// The body of an active lane.
#[derive(Clone, Copy)]
struct Task {
    /// Index of the body in the block.
    body: usize,
    /// The sides of the surface at the end of the last step; `None` at the start.
    side: Option<Side>,
    /// The scale of what is zero on the surface.
    scale: f64,
    /// The next knot of the forcing; infinite if there is none.
    knot: f64,
}

/// The bodies of a block that one kernel integrates.
struct Batch<'a> {
    request: &'a Request<'a>,
    section: &'a Section<'a>,
    ways: &'a [Way],
    block: Range<usize>,
    /// Indices in the block of the bodies that wait.
    queue: Vec<usize>,
    kernel: Compiled,
    group: Group,
    adaptive: AdaptiveSteps,
    forcing_rows: ForcingRows,
    normal: [Row; 6],
    value: Row,
    /// Which components of the normals are not all zero.
    used: [bool; 6],
    /// Points of all bodies, of all threads.
    points: &'a AtomicU64,
    order: usize,
}

/// What is zero on the surface, inside the last step of each lane: coefficients of the powers of the share of the step.
struct Series {
    powers: [Row; TERMS],
    /// The sum of the sizes of all but the first.
    rest: Row,
    /// The slope at the end.
    end_slope: Row,
}

impl<'a> Batch<'a> {
    fn new(
        request: &'a Request<'a>,
        section: &'a Section<'a>,
        ways: &'a [Way],
        block: Range<usize>,
        members: &[usize],
        isa: Isa,
        points: &'a AtomicU64,
    ) -> Result<Self, Error> {
        let way = ways[members[0]];
        let needs = Needs {
            is_forced: way.is_forced,
            is_satellite: way.is_satellite,
            is_reduced: false,
            directions: 1,
            attitude: true,
            tangent: false,
            is_changed: false,
        };
        let step = way.assignment.step;
        let kernel =
            Kernel { system: System::carrying(&TOP, step, needs), step, observed: Observed::Nothing };
        let order = step.numbers.order;
        let queue = members.iter().rev().copied();
        let mut used = [false; 6];
        for &member in members {
            let normal = section.surfaces[block.start + member].normal;
            (0..6).for_each(|d| used[d] |= normal[d] != 0.0);
        }
        Ok(Batch {
            request,
            section,
            ways,
            block,
            queue: memory::collected("bodies of a block", members.len(), queue)?,
            kernel: Compiled::new(kernel, isa),
            group: Group::inactive(),
            adaptive: AdaptiveSteps::inactive(request.tolerance.expect("checked at the begin"), order)?,
            forcing_rows: ForcingRows::NONE,
            normal: [Row::ZERO; 6],
            value: Row::ZERO,
            used,
            points,
            order,
        })
    }

    fn run(mut self, crossings: &mut [Crossings], stop: &Interrupt) -> Result<(), Error> {
        let mut lanes: [Option<Task>; LANES] = [None; LANES];
        let mut series = Series { powers: [Row::ZERO; TERMS], rest: Row::ZERO, end_slope: Row::ZERO };
        let mut made = 0_u64;
        loop {
            for lane in 0..LANES {
                if lanes[lane].is_none() {
                    lanes[lane] = self.queue.pop().map(|body| self.enter(lane, body));
                }
            }
            if lanes.iter().all(Option::is_none) {
                return Ok(());
            }
            if made.is_multiple_of(STEPS_BETWEEN_STOPS) {
                if stop.is_wanted() {
                    return Err(Error::Stopped);
                }
                self.check_memory()?;
            }
            made += 1;
            self.kernel.advance_adaptive(&mut self.group, &self.forcing_rows, &mut self.adaptive, 1);
            self.expand(&mut series);
            for lane in 0..LANES {
                if let Some(task) = lanes[lane] {
                    let own = &mut crossings[task.body];
                    own.steps += 1;
                    lanes[lane] = self.after_step(lane, task, &series, own)?;
                }
            }
        }
    }

    /// Refuses points beyond the memory of the machine, which has to hold them twice when they are returned.
    fn check_memory(&self) -> Result<(), Error> {
        let points = self.points.load(Ordering::Relaxed);
        memory::check("points of a section", 2 * u128::from(points) * size_of::<Point>() as u128)
    }

    /// Loads a body into a lane, at its start.
    fn enter(&mut self, lane: usize, member: usize) -> Task {
        let (index, assignment) = (self.block.start + member, self.ways[member].assignment);
        let (body, forcing) = (&self.request.bodies[index], self.request.forcing_of(index));
        let rate = body.fastest_rate(forcing, [0.0, self.section.end]);
        let first = self.request.steps[index];
        // A body that does not turn needs one step.
        let first = if first.is_finite() { first } else { self.section.end };
        let entry = Entry::unobserved(body, (!forcing.is_none()).then_some(rate), first);
        load(&mut self.group, lane, self.kernel, assignment, &entry);
        self.adaptive.inverse_rate.0[lane] = if rate > 0.0 { 1.0 / rate } else { 0.0 };
        for row in self.adaptive.begin.iter_mut().chain(&mut self.adaptive.now) {
            row.0[lane] = 0.0;
        }
        let Surface { normal, value } = self.section.surfaces[index];
        for d in 0..6 {
            self.normal[d].0[lane] = normal[d];
        }
        self.value.0[lane] = value;
        let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let scale = length(&normal[..3]) * rate + length(&normal[3..]);
        let scale = if self.section.of_rate { scale * rate } else { scale + value.abs() };
        let mut task = Task { body: member, side: None, scale, knot: f64::INFINITY };
        self.enter_interval(lane, &mut task, 0.0);
        task
    }

    /// Applies the forcing of the interval that begins at a knot which the body has reached.
    fn enter_interval(&mut self, lane: usize, task: &mut Task, knot: f64) {
        let index = self.block.start + task.body;
        let forcing = self.request.forcing_of(index);
        if forcing.is_none() {
            return;
        }
        let interval = forcing.interval(knot, false, self.request.bodies[index].moments);
        self.forcing_rows.set(lane, &interval);
        reset_time(&mut self.group, self.kernel.kernel().system, lane);
        task.knot = forcing.next_knot(knot, false).unwrap_or(f64::INFINITY);
        self.adaptive.end.0[lane] = task.knot;
    }

    /// The polynomials of the last step. Without fused products, which this code has no instructions for.
    fn expand(&self, series: &mut Series) {
        let of_rate = self.section.of_rate;
        let adaptive = &self.adaptive;
        let mut share = Row::ZERO;
        for lane in 0..LANES {
            share.0[lane] = self.group.step.0[lane] / adaptive.unit.0[lane];
            series.rest.0[lane] = 0.0;
            series.end_slope.0[lane] = 0.0;
        }
        let mut scale = Row([1.0; LANES]);
        let terms = self.terms();
        for k in 0..terms {
            let of_state = k + usize::from(of_rate);
            let mut sum = [0.0; LANES];
            for d in (0..6).filter(|&d| self.used[d]) {
                let (normal, power) = (&self.normal[d].0, &adaptive.powers[of_state][d].0);
                for lane in 0..LANES {
                    sum[lane] += normal[lane] * power[lane];
                }
            }
            if of_rate {
                sum.iter_mut().for_each(|x| *x *= of_state as f64);
            } else if k == 0 {
                for lane in 0..LANES {
                    sum[lane] -= self.value.0[lane];
                }
            }
            for lane in 0..LANES {
                let term = sum[lane] * scale.0[lane];
                series.powers[k].0[lane] = term;
                if k > 0 {
                    series.rest.0[lane] += term.abs();
                    series.end_slope.0[lane] += k as f64 * term;
                }
                scale.0[lane] *= share.0[lane];
            }
        }
    }

    /// Number of coefficients.
    fn terms(&self) -> usize {
        self.order + usize::from(!self.section.of_rate)
    }

    /// Finds the points of the last step of a lane; `None` if its body is finished.
    fn after_step(
        &mut self,
        lane: usize,
        mut task: Task,
        series: &Series,
        own: &mut Crossings,
    ) -> Result<Option<Task>, Error> {
        let now = self.adaptive.now[0].0[lane];
        if !now.is_finite() {
            own.status = Status::NotFinite;
            own.energy_drift = f64::NAN;
            return Ok(self.leave(lane));
        }
        own.end = now.min(self.section.end);
        // The rate is one by the unit of time of the step.
        let unit = if self.section.of_rate { self.adaptive.unit.0[lane] } else { 1.0 };
        let scale = task.scale * unit;
        let (begin, rest) = (series.powers[0].0[lane], series.rest.0[lane]);
        let at_once = task.side.is_some_and(|side| side.positive == (begin >= 0.0));
        let rising = Some(series.end_slope.0[lane] >= 0.0);
        if at_once && begin.abs() > rest + NEAR * scale {
            task.side = Some(Side { positive: begin >= 0.0, rising });
        } else if begin.abs() + rest <= NEAR * scale {
            // On the surface all along: nothing is crossed.
            own.stays = true;
        } else {
            let mut powers = [0.0; TERMS];
            for k in 0..self.terms() {
                powers[k] = series.powers[k].0[lane];
            }
            let powers = &powers[..self.terms()];
            let side = task.side.unwrap_or_else(|| Side::after_begin(powers, NOISE * scale));
            let polynomial = Polynomial { powers, noise: NOISE * scale, near: NEAR * scale };
            let wanted = self.section.direction;
            let (mut zeros, mut found) = ([None; 2 * TERMS], 0);
            let positive = polynomial.zeros(side, &mut |zero| {
                let is_wanted = wanted == 0 || zero.direction == 0 || zero.direction == wanted;
                if is_wanted && found < zeros.len() {
                    zeros[found] = Some(zero);
                    found += 1;
                }
            });
            for zero in zeros.iter().flatten() {
                let (_, slope) = polynomial.value(zero.at);
                let step = self.group.step.0[lane];
                let slope = slope / step / unit;
                let point = self.point(lane, task, (zero, slope), own)?;
                if !(point.time > 0.0) {
                    continue;
                }
                if point.time > self.section.end {
                    break;
                }
                if own.points.len() == own.points.capacity() {
                    self.check_memory()?;
                }
                memory::push("points of a section", &mut own.points, point)?;
                self.points.fetch_add(1, Ordering::Relaxed);
                if own.points.len() >= self.section.count {
                    own.end = point.time;
                    return Ok(self.leave(lane));
                }
            }
            task.side = Some(Side { positive, rising });
        }
        if now >= self.section.end {
            self.note_end(lane, task, own, now);
            return Ok(self.leave(lane));
        }
        if own.steps >= self.request.max_steps {
            own.status = Status::StepLimit;
            return Ok(self.leave(lane));
        }
        // Steps end at a knot but for rounding; one more, too short to have a length, would be made.
        if task.knot.is_finite() && task.knot - now <= 4.0 * f64::EPSILON * task.knot.abs() {
            let knot = task.knot;
            self.enter_interval(lane, &mut task, knot);
            // The torque may jump there, and the slope with it.
            if let Some(side) = &mut task.side {
                side.rising = None;
            }
        }
        Ok(Some(task))
    }

    /// The state at a zero in the last step of a lane.
    fn point(
        &self,
        lane: usize,
        task: Task,
        (zero, slope): (&zeros::Zero, f64),
        own: &mut Crossings,
    ) -> Result<Point, Error> {
        let adaptive = &self.adaptive;
        let units = self.group.step.0[lane] / adaptive.unit.0[lane] * zero.at;
        let time = adaptive.begin[0].0[lane] + (adaptive.begin[1].0[lane] + units * adaptive.unit.0[lane]);
        let y = self.kernel.dense_output(adaptive, lane, units);
        let state = read(&self.group, lane, self.kernel, self.ways[task.body].assignment, y, time);
        self.note_drift(lane, &state, own);
        let attitude = state.attitude.expect("the system has an attitude");
        Ok(Point {
            time,
            omega: state.omega,
            gamma: state.direction.expect("the system has the vertical"),
            attitude: if attitude[0] < 0.0 { attitude.map(|x| -x) } else { attitude },
            slope,
            direction: zero.direction,
            grazes: zero.grazes,
        })
    }

    /// The errors of the invariants at the end of a motion.
    fn note_end(&self, lane: usize, task: Task, own: &mut Crossings, now: f64) {
        let state = unload(&self.group, lane, self.kernel, self.ways[task.body].assignment, now);
        self.note_drift(lane, &state, own);
    }

    fn note_drift(&self, lane: usize, state: &State, own: &mut Crossings) {
        let errors = invariant_errors(state, invariants_at_start(&self.group, lane));
        for [energy, momentum] in errors.into_iter().flatten() {
            own.energy_drift = worse(own.energy_drift, energy);
            if own.status == Status::Finished && !(energy <= DRIFT_LIMIT && momentum <= DRIFT_LIMIT) {
                let finite = energy.is_finite() && momentum.is_finite();
                own.status = if finite { Status::Drifted } else { Status::NotFinite };
            }
        }
    }

    fn leave(&mut self, lane: usize) -> Option<Task> {
        self.group.deactivate(lane);
        self.adaptive.end.0[lane] = f64::INFINITY;
        for row in &mut self.adaptive.now {
            row.0[lane] = 0.0;
        }
        None
    }
}
