//! States by adaptive steps, of a Taylor series or by trial: states at given times are evaluated from the polynomial of a step, and
//! a lane whose body is finished gets the next body.

use super::adaptive_lanes::AdaptiveLanes;
use super::{
    Integration, Request, Schedule, StatesPart, invariants_at_start, kinds_in, neighbours, over_blocks_of,
};
use crate::call::Call;
use crate::error::{Error, refuse};
use crate::forces::BodyForces;
use crate::kernel::{Job, KernelAssignment, State, drive, read, unload};
use crate::memory;
use crate::method::Method;
use crate::observe::Observed;
use crate::simd::LANES;
use crate::status::Status;

/// Bodies in a block: enough that few lanes are inactive at the end of a block.
const BLOCK: usize = 1024;

/// Largest number of steps between two checks of the stop flag: a tenth of a second on the slowest path.
const STEPS_BETWEEN_STOPS: u64 = 1 << 10;

/// Runs the request.
pub fn simulate(request: &Request, method: &Method, states: StatesPart, call: Call) -> Result<u64, Error> {
    let given = request.tolerance.map_or(String::new(), |tolerance| format!("{tolerance:e}"));
    if let Schedule::Strides(_) = request.schedule {
        return refuse("tolerance", given, "steps of a given size have no tolerance");
    }
    let Some(tolerance) = request.tolerance.filter(|t| (f64::MIN_POSITIVE..1.0).contains(t)) else {
        return refuse("tolerance", given, "must be positive and below one");
    };
    if !method.is_known_inside(request.forces.of(0).into()) {
        let rule = "only the Taylor methods choose their steps, and 'dop853' under a function";
        return refuse("tolerance", given, rule);
    }
    let blocks = neighbours(request.bodies.len(), BLOCK, |_| ())?;
    over_blocks_of(request, &blocks, states, call, |block, mut states| {
        states.forget();
        let integrations = Integration::of_block(request, method, block.clone())?;
        for members in kinds_in(block.clone(), |index| integrations[index - block.start].kind())? {
            let how = (call, tolerance);
            let mut job = AdaptiveJob::new(request, &integrations, block.start, &members, how, &mut states)?;
            drive(&mut job)?;
        }
        Ok(())
    })
}

/// The body of an active lane. It moves forward through the times >= 0, then from its start backward through the others.
#[derive(Clone, Copy)]
struct Task {
    /// Index of the body in the block.
    body: usize,
    assignment: KernelAssignment,
    /// The first of its times that is not negative.
    split: usize,
    /// The next requested time.
    output: usize,
    backward: bool,
    steps: u64,
    /// Attitude at the last recorded state.
    last: [f64; 4],
}

/// The states of the bodies of a block that one kernel integrates.
struct AdaptiveJob<'a, 'b> {
    request: &'a Request<'a>,
    /// How the bodies of the block are integrated.
    integrations: &'a [Integration],
    /// Index of the first body of the block.
    first: usize,
    /// Rate and index of the bodies that wait.
    queue: Vec<(u64, usize)>,
    lanes: AdaptiveLanes<'a>,
    states: &'a mut StatesPart<'b>,
}

impl<'a, 'b> AdaptiveJob<'a, 'b> {
    fn new(
        request: &'a Request<'a>,
        integrations: &'a [Integration],
        first: usize,
        members: &[usize],
        (call, tolerance): (Call<'a>, f64),
        states: &'a mut StatesPart<'b>,
    ) -> Result<Self, Error> {
        let rate = |index: usize| request.bodies[first + index].fastest_rate(BodyForces::NONE, [0.0; 2]);
        // Rates are not negative: their bits are ordered as they are.
        let queue = members.iter().map(|&index| (rate(index).to_bits(), index));
        let mut queue = memory::collected("bodies of a block", members.len(), queue)?;
        // The fastest bodies first (the queue is emptied from its end): at the end no lane is inactive for long.
        queue.sort_unstable();
        let kernel = integrations[members[0]].kernel(request, Observed::Nothing);
        let lanes = AdaptiveLanes::new(request, kernel, call, tolerance)?;
        Ok(AdaptiveJob { request, integrations, first, queue, lanes, states })
    }

    /// Loads a body into a lane, at its start. Whether a requested time is left.
    fn enter(&mut self, lane: usize, task: &mut Task) -> bool {
        let index = self.first + task.body;
        let body = &self.request.bodies[index];
        self.lanes.enter(lane, index, task.assignment, self.request.range_of(index), task.backward);
        task.last = body.attitude;
        while let Some(0.0) = self.next_time(task) {
            let mut start = unload(&self.lanes.group, lane, self.lanes.kernel, task.assignment);
            start.omega = body.omega;
            self.record(lane, task, &start);
            task.output += 1;
        }
        self.aim(lane, task)
    }

    /// The next requested time of a body.
    fn next_time(&self, task: &Task) -> Option<f64> {
        self.times(task.body).get(task.output).copied()
    }

    /// The requested times of a body of the block.
    fn times(&self, body: usize) -> &'a [f64] {
        self.request.schedule.times_of(self.first + body).expect("checked at the begin")
    }

    /// Sets the next requested time of the lane, or starts the body backward, or removes it from the lane. Whether it
    /// moves on.
    fn aim(&mut self, lane: usize, task: &mut Task) -> bool {
        let Some(time) = self.next_time(task) else {
            if task.split == 0 {
                return self.leave(lane, task);
            }
            (task.output, task.backward) = (task.split - 1, true);
            return self.enter(lane, task);
        };
        if task.steps >= self.request.max_steps {
            self.states.status[task.body] = Status::StepLimit;
            return self.leave(lane, task);
        }
        self.lanes.aim(lane, time, task.backward);
        true
    }

    fn leave(&mut self, lane: usize, task: &Task) -> bool {
        self.states.steps[task.body] = task.steps;
        self.lanes.leave(lane);
        false
    }

    fn record(&mut self, lane: usize, task: &mut Task, state: &State) {
        let at = task.body * self.request.schedule.len() + task.output;
        let known = (invariants_at_start(&self.lanes.group, lane), &mut task.last);
        self.states.record(task.body, at, state, known);
    }
}

impl Job for AdaptiveJob<'_, '_> {
    type Task = Task;

    fn load(&mut self, lane: usize) -> Result<Option<Task>, Error> {
        while let Some((_, body)) = self.queue.pop() {
            self.lanes.entered += 1;
            let split = self.times(body).partition_point(|&t| t < 0.0);
            let assignment = self.integrations[body].assignment;
            let mut task =
                Task { body, assignment, split, output: split, backward: false, steps: 0, last: [0.0; 4] };
            for drift in self.states.drifts() {
                drift[body] = 0.0;
            }
            if self.enter(lane, &mut task) {
                return Ok(Some(task));
            }
        }
        Ok(None)
    }

    fn advance(&mut self, tasks: &[Option<Task>; LANES]) -> Result<(), Error> {
        self.lanes.tell(tasks, |task| self.first + task.body)?;
        let left = tasks.iter().flatten().map(|task| self.request.max_steps - task.steps);
        let most = left.min().map_or(0, |left| left.min(STEPS_BETWEEN_STOPS));
        self.lanes.advance(most as usize);
        Ok(())
    }

    /// Records the requested states that the lane has reached.
    fn look(&mut self, lane: usize, task: &mut Task) -> Result<bool, Error> {
        task.steps += self.lanes.made(lane);
        let steps = &self.lanes.steps;
        let [begin, lost] = [steps.begin[0].0[lane], steps.begin[1].0[lane]];
        let (now, unit, direction) = (steps.now[0].0[lane], steps.unit.0[lane], steps.direction.0[lane]);
        while let Some(time) = self.next_time(task).filter(|&time| (time - now) * direction <= 0.0) {
            let units = ((time - begin) - lost) / unit;
            let y = self.lanes.kernel.dense_output(&self.lanes.steps, lane, units);
            let state = read(&self.lanes.group, lane, self.lanes.kernel, task.assignment, y);
            self.record(lane, task, &state);
            if task.backward && task.output == 0 {
                return Ok(self.leave(lane, task));
            }
            task.output = if task.backward { task.output - 1 } else { task.output + 1 };
        }
        if !now.is_finite() {
            let body = task.body;
            self.states.status[body] = Status::NotFinite;
            for drift in self.states.drifts() {
                drift[body] = f64::NAN;
            }
            return Ok(self.leave(lane, task));
        }
        self.lanes.pass_knot(lane, self.first + task.body, task.backward);
        Ok(self.aim(lane, task))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use crate::forces::Forces;
    use crate::method::{AnyMethod, TAYLOR16};
    use crate::scene::FREE;
    use crate::simd::Isa;
    use crate::trajectory::{Record, States};

    /// A job whose rounds are counted: in each of them every lane could make a step.
    struct Counted<'a, 'b> {
        job: AdaptiveJob<'a, 'b>,
        rounds: f64,
    }

    impl Job for Counted<'_, '_> {
        type Task = Task;

        fn load(&mut self, lane: usize) -> Result<Option<Task>, Error> {
            self.job.load(lane)
        }

        fn advance(&mut self, tasks: &[Option<Task>; LANES]) -> Result<(), Error> {
            self.job.advance(tasks)?;
            let active = (0..LANES).filter(|&lane| tasks[lane].is_some());
            self.rounds += active.map(|lane| self.job.lanes.group.count.0[lane]).fold(0.0, f64::max);
            Ok(())
        }

        fn look(&mut self, lane: usize, task: &mut Task) -> Result<bool, Error> {
            self.job.look(lane, task)
        }
    }

    /// The share of active lanes in all steps, for bodies whose numbers of steps differ by a factor of four.
    #[test]
    fn few_lanes_are_inactive() {
        let body = |i: usize| {
            let rate = 8.0 * (1.0 + 4.0 * (i % 16) as f64 / 15.0);
            let omega = [0.3, 1.0, 1e-3 * i as f64].map(|x| rate * x);
            let attitude = [1.0, 0.0, 0.0, 0.0];
            Body { moments: [1.0, 1.6, 2.1], weight: [0.0; 3], omega, attitude }
        };
        let bodies: Vec<Body> = (0..BLOCK).map(body).collect();
        let steps: Vec<f64> =
            bodies.iter().map(|body| 0.1 / body.fastest_rate(BodyForces::NONE, [0.0; 2])).collect();
        let request = Request {
            bodies: &bodies,
            scene: &FREE,
            forces: Forces::NONE,
            method: AnyMethod::Steps(&TAYLOR16),
            record: Record::Attitude,
            schedule: Schedule::Times(&[100.0]),
            steps: &steps,
            tolerance: Some(1e-13),
            refinement: 1.0,
            max_steps: 1 << 40,
        };
        let integrations = Integration::of_block(&request, &TAYLOR16, 0..BLOCK).unwrap();
        let members: Vec<usize> = (0..BLOCK).collect();
        let mut states = States::reserved(&request, BLOCK, &[]).unwrap();
        let (mut part, how) = (states.whole(), (Call::to_the_end(Isa::NARROWEST, 1), 1e-13));
        let job = AdaptiveJob::new(&request, &integrations, 0, &members, how, &mut part).unwrap();
        let mut counted = Counted { job, rounds: 0.0 };
        drive(&mut counted).unwrap();
        let rounds = counted.rounds;
        let (least, most) = (states.steps.iter().min().unwrap(), states.steps.iter().max().unwrap());
        let utilisation = states.steps.iter().sum::<u64>() as f64 / (rounds * LANES as f64);
        println!("{least} to {most} steps, utilisation {utilisation:.3}");
        assert!(most >= &(4 * least) && utilisation >= 0.95, "{least} to {most}: {utilisation}");
    }
}
