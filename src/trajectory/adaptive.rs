//! States by Taylor series with adaptive steps: states at given times are evaluated from the polynomial of a step, and
//! a lane whose body is finished gets the next body.

use super::{
    Effort, Integration, Request, Schedule, StatesPart, invariants_at_start, kinds_in, neighbours,
    over_blocks_of,
};
use crate::error::Error;
use crate::forcing::BodyForcing;
use crate::kernel::{AdaptiveSteps, Compiled, ForcingRows, Group, Kernel};
use crate::kernel::{Entry, KernelAssignment, State, load, read, reset_time, unload};
use crate::memory;
use crate::observe::{Displacement, Observed};
use crate::parallel::Interrupt;
use crate::scheme::Scheme;
use crate::simd::{Isa, LANES};
use crate::status::Status;

/// Bodies in a block: enough that few lanes are inactive at the end of a block.
const BLOCK: usize = 1024;

/// Largest number of steps between two checks of the stop flag: a tenth of a second on the slowest path.
const STEPS_BETWEEN_STOPS: u64 = 1 << 10;

/// Runs the request.
pub fn simulate(
    request: &Request,
    scheme: &Scheme,
    states: StatesPart,
    threads: usize,
    isa: Isa,
    stop: &Interrupt,
) -> Result<Effort, Error> {
    let refused = |rule| {
        let value = request.tolerance.map_or(String::new(), |tolerance| format!("{tolerance:e}"));
        Error::Value { argument: "tolerance", value, rule }
    };
    if let Schedule::Strides(_) = request.schedule {
        return Err(refused("steps of a given size have no tolerance"));
    }
    let tolerance = request.tolerance.filter(|t| (f64::MIN_POSITIVE..1.0).contains(t));
    let tolerance = tolerance.ok_or_else(|| refused("must be positive and below one"))?;
    if !scheme.is_series() {
        return Err(refused("only the Taylor methods choose their steps"));
    }
    let blocks = neighbours(request.bodies.len(), BLOCK, |_| ())?;
    over_blocks_of(request, &blocks, states, threads, stop, |block, mut states| {
        states.forget();
        let mut lane_steps = 0;
        let ways = Integration::of_block(request, scheme, block.clone())?;
        for members in kinds_in(block.clone(), |index| ways[index - block.start].kind())? {
            let batch = AdaptiveBatch::new(request, &ways, block.start, &members, isa, tolerance)?;
            lane_steps += batch.run(&mut states, stop)?;
        }
        Ok(lane_steps)
    })
}

/// The body of an active lane. It moves forward through the times >= 0, then from its start backward through the others.
#[derive(Clone, Copy)]
struct LaneTask {
    /// Index of the body in the block.
    body: usize,
    assignment: KernelAssignment,
    /// The first of its times that is not negative.
    split: usize,
    /// The next requested time.
    wanted: usize,
    backward: bool,
    steps: u64,
    /// Attitude at the last recorded state.
    last: [f64; 4],
    /// The next knot of the forcing; infinite if there is none.
    knot: f64,
}

/// The bodies of a block that one kernel integrates.
struct AdaptiveBatch<'a> {
    request: &'a Request<'a>,
    /// How the bodies of the block are integrated.
    ways: &'a [Integration],
    /// Index of the first body of the block.
    first: usize,
    /// Rate and index of the bodies that wait.
    queue: Vec<(u64, usize)>,
    kernel: Compiled,
    group: Group,
    adaptive: AdaptiveSteps,
    forcing_rows: ForcingRows,
}

impl<'a> AdaptiveBatch<'a> {
    fn new(
        request: &'a Request<'a>,
        ways: &'a [Integration],
        first: usize,
        members: &[usize],
        isa: Isa,
        tolerance: f64,
    ) -> Result<Self, Error> {
        let rate = |index: usize| request.bodies[first + index].fastest_rate(BodyForcing::NONE, [0.0; 2]);
        // Rates are not negative: their bits are ordered as they are.
        let queue = members.iter().map(|&index| (rate(index).to_bits(), index));
        let mut queue = memory::collected("bodies of a block", members.len(), queue)?;
        // The fastest bodies first (the queue is emptied from its end): at the end no lane is inactive for long.
        queue.sort_unstable();
        let way = ways[members[0]];
        let kernel =
            Kernel { system: way.system(request), step: way.assignment.step, observed: Observed::Nothing };
        Ok(AdaptiveBatch {
            request,
            ways,
            first,
            queue,
            kernel: Compiled::new(kernel, isa),
            group: Group::inactive(),
            adaptive: AdaptiveSteps::inactive(tolerance, way.assignment.step.numbers.order)?,
            forcing_rows: ForcingRows::NONE,
        })
    }

    /// Moves all bodies; returns the steps of all lanes.
    fn run(mut self, states: &mut StatesPart, stop: &Interrupt) -> Result<u64, Error> {
        let mut lane_steps = 0;
        let mut lanes: [Option<LaneTask>; LANES] = [None; LANES];
        loop {
            for lane in 0..LANES {
                while lanes[lane].is_none() {
                    let Some((_, body)) = self.queue.pop() else { break };
                    let split = self.times(body).partition_point(|&t| t < 0.0);
                    let task = LaneTask {
                        body,
                        assignment: self.ways[body].assignment,
                        split,
                        wanted: split,
                        backward: false,
                        steps: 0,
                        last: [0.0; 4],
                        knot: f64::INFINITY,
                    };
                    for drift in states.drifts() {
                        drift[body] = 0.0;
                    }
                    lanes[lane] = self.enter(lane, task, states);
                }
            }
            let active = lanes.iter().flatten();
            let Some(left) = active.map(|task| self.request.max_steps - task.steps).min() else {
                return Ok(lane_steps);
            };
            if stop.is_wanted() {
                return Err(Error::Stopped);
            }
            let most = left.min(STEPS_BETWEEN_STOPS) as usize;
            let made =
                self.kernel.advance_adaptive(&mut self.group, &self.forcing_rows, &mut self.adaptive, most)
                    as u64;
            lane_steps += made * LANES as u64;
            for lane in 0..LANES {
                if let Some(mut task) = lanes[lane] {
                    task.steps += made;
                    lanes[lane] = self.record_reached(lane, task, states);
                }
            }
        }
    }

    /// Loads a body into a lane, at its start; `None` if no requested time is left.
    fn enter(&mut self, lane: usize, mut task: LaneTask, states: &mut StatesPart) -> Option<LaneTask> {
        let (index, times) = (self.first + task.body, self.times(task.body));
        let (body, forcing) = (&self.request.bodies[index], self.request.forcing_of(index));
        let first = self.request.steps[index];
        let span = times.last().copied().unwrap_or(0.0).abs() + times.first().map_or(0.0, |t| t.abs());
        // A body that does not turn needs one step.
        let first = if first.is_finite() { first } else { span };
        let direction = if task.backward { -1.0 } else { 1.0 };
        let rate = body.fastest_rate(forcing, self.request.range_of(index));
        let forced_rate = self.ways[task.body].forces.act.then_some(rate);
        let displacement = Displacement::new(self.request.record.displacement_of(index));
        let entry = Entry { displacement, ..Entry::unobserved(body, forced_rate, direction * first) };
        load(&mut self.group, lane, self.kernel, task.assignment, &entry);
        self.adaptive.direction.0[lane] = direction;
        self.adaptive.inverse_rate.0[lane] = if rate > 0.0 { 1.0 / rate } else { 0.0 };
        for row in self.adaptive.begin.iter_mut().chain(&mut self.adaptive.now) {
            row.0[lane] = 0.0;
        }
        task.last = body.attitude;
        self.enter_interval(lane, &mut task, 0.0);
        while let Some(0.0) = self.next_time(&task) {
            let mut start = unload(&self.group, lane, self.kernel, task.assignment);
            start.omega = body.omega;
            self.record(lane, &mut task, &start, states);
            task.wanted += 1;
        }
        self.aim(lane, task, states)
    }

    /// Applies the forcing of the interval that begins at a knot which the body has reached.
    fn enter_interval(&mut self, lane: usize, task: &mut LaneTask, knot: f64) {
        let index = self.first + task.body;
        let forcing = self.request.forcing_of(index);
        let (is_forced, backward) = (self.ways[task.body].forces.act, task.backward);
        if is_forced || self.request.record.is_sensitivity() {
            self.forcing_rows.set(lane, &self.request.interval_of(index, knot, backward));
        }
        if !is_forced {
            return;
        }
        reset_time(&mut self.group, self.kernel.kernel().system, lane);
        let never = if backward { f64::NEG_INFINITY } else { f64::INFINITY };
        task.knot = forcing.next_knot(knot, backward).unwrap_or(never);
        self.adaptive.end.0[lane] = task.knot;
    }

    /// Records the requested states that a lane has reached; `None` if its body is finished.
    fn record_reached(
        &mut self,
        lane: usize,
        mut task: LaneTask,
        states: &mut StatesPart,
    ) -> Option<LaneTask> {
        let adaptive = &self.adaptive;
        let [begin, lost] = [adaptive.begin[0].0[lane], adaptive.begin[1].0[lane]];
        let (now, unit, direction) =
            (adaptive.now[0].0[lane], adaptive.unit.0[lane], adaptive.direction.0[lane]);
        while let Some(time) = self.next_time(&task).filter(|&time| (time - now) * direction <= 0.0) {
            let units = ((time - begin) - lost) / unit;
            let y = self.kernel.dense_output(&self.adaptive, lane, units);
            let state = read(&self.group, lane, self.kernel, task.assignment, y);
            self.record(lane, &mut task, &state, states);
            if task.backward && task.wanted == 0 {
                return self.leave(lane, task, states);
            }
            task.wanted = if task.backward { task.wanted - 1 } else { task.wanted + 1 };
        }
        if !now.is_finite() {
            let body = task.body;
            states.status[body] = Status::NotFinite;
            for drift in states.drifts() {
                drift[body] = f64::NAN;
            }
            return self.leave(lane, task, states);
        }
        // Steps end at a knot but for rounding; one more, too short to have a length, would be made.
        let short = (task.knot - now) * direction;
        if task.knot.is_finite() && short <= 4.0 * f64::EPSILON * task.knot.abs() {
            let knot = task.knot;
            self.enter_interval(lane, &mut task, knot);
        }
        self.aim(lane, task, states)
    }

    /// The next requested time of a body.
    fn next_time(&self, task: &LaneTask) -> Option<f64> {
        self.times(task.body).get(task.wanted).copied()
    }

    /// The requested times of a body of the block.
    fn times(&self, body: usize) -> &'a [f64] {
        self.request.schedule.times_of(self.first + body).expect("checked at the begin")
    }

    /// Sets the next requested time of the lane, or starts the body backward, or removes it from the lane.
    fn aim(&mut self, lane: usize, task: LaneTask, states: &mut StatesPart) -> Option<LaneTask> {
        let Some(time) = self.next_time(&task) else {
            if task.split == 0 {
                return self.leave(lane, task, states);
            }
            let back = LaneTask { wanted: task.split - 1, backward: true, ..task };
            return self.enter(lane, back, states);
        };
        if task.steps >= self.request.max_steps {
            states.status[task.body] = Status::StepLimit;
            return self.leave(lane, task, states);
        }
        // A knot is handled as soon as its distance is within rounding.
        let (knot, margin) = (task.knot, 4.0 * f64::EPSILON * task.knot.abs());
        self.adaptive.next.0[lane] = match task.backward {
            _ if knot.is_infinite() => time,
            false => time.min(knot - margin),
            true => time.max(knot + margin),
        };
        Some(task)
    }

    fn leave(&mut self, lane: usize, task: LaneTask, states: &mut StatesPart) -> Option<LaneTask> {
        states.steps[task.body] = task.steps;
        self.group.deactivate(lane);
        self.adaptive.next.0[lane] = f64::INFINITY;
        self.adaptive.end.0[lane] = f64::INFINITY;
        self.adaptive.direction.0[lane] = 1.0;
        for row in &mut self.adaptive.now {
            row.0[lane] = 0.0;
        }
        None
    }

    fn record(&self, lane: usize, task: &mut LaneTask, state: &State, states: &mut StatesPart) {
        let at = task.body * self.request.schedule.len() + task.wanted;
        let known = (invariants_at_start(&self.group, lane), &mut task.last);
        states.record(task.body, at, state, known);
    }
}
