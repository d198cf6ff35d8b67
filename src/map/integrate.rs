//! Integrates samples side by side: a lane whose sample is finished gets the next sample.

use super::Criterion;
use super::observation::{RUNS, Run};
use super::regular::{self, Checkpoints};
use super::{Class, Observation, OnOrbit, Outcome, STEP_BLOCK};
use crate::body::Body;
use crate::error::Error;
use crate::forces::{BodyForces, ForcesInterval, Modes};
use crate::kernel::{Compiled, Entry, ForcesRows, Group, Job, Kernel, drive, load, reset_time};
use crate::memory;
use crate::observe::{Bound, Deviation, EXIT_TIME, Observed};
use crate::simd::LANES;
use crate::status::{DRIFT_LIMIT, Status};

/// The sample of an active lane: its index in the block, its step, and its way through the checkpoints of regularity.
#[derive(Clone, Copy)]
struct LaneTask {
    index: usize,
    step: f64,
    /// How many times the steps of the sample it makes, where its rates pass their bound over an anomaly.
    times: u64,
    /// Its place on the orbit at the start, if it is integrated over its anomaly.
    on_orbit: Option<OnOrbit>,
    checkpoints: Option<Checkpoints>,
    /// Its leg, if it is under a table.
    leg: Option<Leg>,
    /// The modes of its damping: the same on all legs.
    modes: Modes,
}

/// Steps of equal size between two knots of a table.
#[derive(Clone, Copy)]
struct Leg {
    from: f64,
    to: f64,
    steps: u64,
    /// The steps of the legs before it.
    before: u64,
}

impl Leg {
    fn step(&self) -> f64 {
        (self.to - self.from) / self.steps as f64
    }
}

impl Observation<'_> {
    /// Integrates samples of a block, given by their indices, and writes their outcomes. The bodies are those of the
    /// samples from `first` on.
    pub(super) fn integrate(
        &self,
        (bodies, first): (&[Body], u64),
        samples: &[usize],
        run: Run,
        outcomes: &mut [Option<Outcome>],
    ) -> Result<(), Error> {
        let mut by_kernel: Vec<(Kernel, Vec<usize>)> = Vec::new();
        for &index in samples {
            let forces = self.forces_of((first + index as u64) / self.samples);
            let step = self.assignment(&bodies[index], forces, run.cross_check).step;
            let kernel = self.kernel(step, forces);
            let known = by_kernel.iter().position(|(known, _)| *known == kernel);
            if known.is_none() {
                memory::push(RUNS, &mut by_kernel, (kernel, Vec::new()))?;
            }
            let at = known.unwrap_or(by_kernel.len() - 1);
            memory::push(RUNS, &mut by_kernel[at].1, index)?;
        }
        for (kernel, samples) in &by_kernel {
            let mut job = MapJob {
                map: self,
                bodies,
                first,
                samples: samples.iter(),
                run,
                compiled: Compiled::new(*kernel, run.call.isa),
                group: Group::inactive(),
                forces_rows: ForcesRows::with_room(self.function_width())?,
                target: [f64::INFINITY; LANES],
                blocks: 0,
                outcomes,
            };
            drive(&mut job)?;
        }
        Ok(())
    }

    /// Translates an outcome over the anomaly of an orbit to the time. On an orbit no component of the momentum is constant;
    /// the Jacobi integral is on a circle.
    fn translate(&self, OnOrbit { place, pace, .. }: &OnOrbit, outcome: &mut Outcome) {
        for time in [&mut outcome.left, &mut outcome.settled] {
            if *time < f64::INFINITY {
                *time = place.time_until(*time).clamp(0.0, self.t_end);
            }
        }
        let turned = outcome.step * outcome.steps as f64;
        // The integral of the rates over the pace is that of the rates over the time.
        outcome.mean_rate *= turned / place.time_until(turned);
        outcome.step /= pace;
        outcome.momentum_drift = f64::NAN;
        if !place.is_on_circle() {
            outcome.energy_drift = f64::NAN;
        }
    }

    /// The outcome of a lane whose sample is finished.
    fn outcome(&self, group: &Group, lane: usize, observed: Observed, (step, steps): (f64, u64)) -> Outcome {
        let energy_drift = group.energy.worst.0[lane];
        let momentum_drift = group.momentum.worst.0[lane];
        let unit_drift = group.unit.0[lane];
        let rows = group.observed_in(lane);
        let left = rows[EXIT_TIME];
        let value = observed.outcome(&rows);
        let is_bounded = matches!(observed, Observed::Bound(_));
        let tilt = match observed {
            Observed::Tilt(_) => value,
            Observed::Bound(bound) => bound.largest_angle(value),
            _ => f64::NAN,
        };
        let finite = energy_drift.is_finite() && momentum_drift.is_finite() && unit_drift.is_finite();
        let (class, status) = if !finite {
            (Class::Failed, Status::NotFinite)
        } else if energy_drift.max(momentum_drift).max(unit_drift) > DRIFT_LIMIT {
            (Class::Failed, Status::Drifted)
        } else if left < f64::INFINITY {
            (Class::Unstable, Status::Stopped)
        } else if is_bounded && value.is_nan() {
            (Class::Undecided, Status::Finished)
        } else {
            (Class::Stable, Status::Finished)
        };
        Outcome {
            class,
            status,
            flips: if observed == Observed::Flips { value as u64 } else { 0 },
            left,
            tilt,
            settled: if is_bounded { rows[Bound::SETTLED] } else { f64::NAN },
            mean_rate: if observed == Observed::MeanRate { value } else { f64::NAN },
            exponent: f64::NAN,
            mean_megno: f64::NAN,
            energy_drift,
            momentum_drift,
            unit_drift,
            step,
            steps,
            exact: false,
        }
    }
}

/// The samples of one kernel.
struct MapJob<'a> {
    map: &'a Observation<'a>,
    /// The bodies of the samples from `first` on.
    bodies: &'a [Body],
    first: u64,
    /// The samples that wait.
    samples: std::slice::Iter<'a, usize>,
    run: Run<'a>,
    compiled: Compiled,
    group: Group,
    forces_rows: ForcesRows<'a>,
    /// Steps after which each lane is at its horizon, or is to be looked at; an inactive lane never is.
    target: [f64; LANES],
    /// Blocks of steps that the group has made.
    blocks: u64,
    outcomes: &'a mut [Option<Outcome>],
}

impl<'a> MapJob<'a> {
    /// Loads a sample into a lane, with so many times its steps; `None` and its outcome if they are too many.
    fn begin(&mut self, lane: usize, index: usize, times: u64) -> Option<LaneTask> {
        let (map, cross_check) = (self.map, self.run.cross_check);
        let body = &self.bodies[index];
        let forces = self.forces_of(index);
        let is_on_clock = self.compiled.kernel().system.is_on_clock;
        let on_orbit = is_on_clock.then(|| OnOrbit::of(body, &forces.further.orbit, [0.0, map.t_end]));
        let place = on_orbit.map(|on_orbit| on_orbit.place);
        // A time, or the anomaly until then.
        let span = place.map_or(map.t_end, |place| place.anomaly_until(map.t_end));
        let steps = map.steps_of(body, forces, cross_check, (on_orbit, span)).saturating_mul(times);
        if steps.saturating_add(forces.table.knots_between(0.0, map.t_end) as u64) > map.max_steps {
            self.outcomes[index] = Some(Outcome::REFUSED);
            return None;
        }
        let longest = span / steps as f64;
        let leg = forces.table.has_knots().then(|| self.leg(forces, (0.0, 0), longest));
        let step = leg.map_or(longest, |leg| leg.step());
        let assignment = map.assignment(body, forces, cross_check);
        let deviation = match map.criterion.rule() {
            Some(_) => {
                let of_attitude = matches!(map.criterion, Criterion::RegularAttitude(_));
                regular::deviation(body, forces, of_attitude, cross_check)
            }
            None => Deviation::NONE,
        };
        let checkpoints = map.criterion.rule().map(|rule| {
            let norm = assignment.deviation(&deviation, body);
            Checkpoints::new(rule, norm, map.is_forced(), [steps as f64, map.t_end])
        });
        let modes = forces.damping.modes(body.moments);
        let interval = (!forces.is_none()).then(|| {
            let interval = apply(&mut self.forces_rows, lane, forces, (0.0, modes));
            ForcesInterval { functions: self.forces_rows.functions.of(lane), ..interval }
        });
        let rate = || match on_orbit {
            Some(on_orbit) => on_orbit.rate * times as f64,
            None => body.fastest_rate(forces, [0.0, map.t_end]),
        };
        let entry = Entry::unobserved(body, forces, (0.0, place), None, step);
        let forces = interval.as_ref().map(|interval| (interval, rate()));
        let entry = Entry { forces, axis: map.axis, deviation, ..entry };
        load(&mut self.group, lane, self.compiled, assignment, &entry);
        if let Some(checkpoints) = &checkpoints {
            checkpoints.renormalise(&mut self.group, self.compiled.kernel().system, lane);
        }
        let steps = leg.map_or(steps, |leg| leg.steps);
        self.target[lane] = checkpoints.map_or(steps as f64, |checkpoints| checkpoints.next());
        Some(LaneTask { index, step: longest, times, on_orbit, checkpoints, leg, modes })
    }

    /// The forces on a sample in this run.
    fn forces_of(&self, index: usize) -> BodyForces<'a> {
        let forces = self.map.map.forces_of((self.first + index as u64) / self.map.samples);
        if self.run.cross_check { forces.doubted() } else { forces }
    }

    /// The leg from a time on, after some steps: to the next knot, or to the horizon. In a cross-check it has a step more than
    /// its length asks for: two runs of one step would be the same.
    fn leg(&self, forces: BodyForces, (from, before): (f64, u64), longest: f64) -> Leg {
        let end = self.map.t_end;
        let to = forces.table.next_knot(from, false).map_or(end, |knot| knot.min(end));
        let steps = ((to - from) / longest).ceil().max(1.0) as u64 + u64::from(self.run.cross_check);
        Leg { from, to, steps, before }
    }

    /// Moves a lane on to the next leg of its sample; `None` if it is at the horizon.
    fn next_leg(&mut self, lane: usize, task: &LaneTask, leg: Leg) -> Option<Leg> {
        if leg.to >= self.map.t_end {
            return None;
        }
        let forces = self.forces_of(task.index);
        let next = self.leg(forces, (leg.to, leg.before + leg.steps), task.step);
        apply(&mut self.forces_rows, lane, forces, (next.from, task.modes));
        reset_time(&mut self.group, self.compiled.kernel().system, lane);
        self.group.step.0[lane] = next.step();
        // Observables tell the time from the count of steps.
        let begin = next.from / next.step();
        self.group.count.0[lane] = begin;
        // Half a step before, which rounding does not reach.
        self.target[lane] = begin + next.steps as f64 - 0.5;
        Some(next)
    }
}

/// Applies the forces on a body whose damping has these modes to its lane, from a time on to the next knot.
fn apply<'a>(
    rows: &mut ForcesRows<'a>,
    lane: usize,
    forces: BodyForces<'a>,
    (time, modes): (f64, Modes),
) -> ForcesInterval<'static, f64> {
    let interval = forces.interval(time, false, modes);
    rows.set(lane, &interval);
    rows.functions.set(lane, forces.function_from(time));
    interval
}

impl Job for MapJob<'_> {
    type Task = LaneTask;

    fn load(&mut self, lane: usize) -> Result<Option<LaneTask>, Error> {
        while let Some(&index) = self.samples.next() {
            let task = self.begin(lane, index, 1);
            if task.is_some() {
                return Ok(task);
            }
        }
        Ok(None)
    }

    fn advance(&mut self, tasks: &[Option<LaneTask>; LANES]) -> Result<(), Error> {
        let is_ruled = self.map.criterion.rule().is_some();
        let steps = match is_ruled {
            true => regular::BLOCK,
            // A leg has any number of steps.
            false if self.map.has_knots() => 1,
            false => STEP_BLOCK,
        };
        // Each round counts its steps, which lead to the least target.
        loop {
            if self.run.call.stop.is_wanted() {
                return Err(Error::Stopped);
            }
            self.compiled.advance(&mut self.group, &self.forces_rows, steps as usize);
            if is_ruled {
                self.blocks += 1;
                let of_lanes = tasks.iter().enumerate();
                let of_lanes =
                    of_lanes.filter_map(|(lane, task)| Some((lane, task.as_ref()?.checkpoints.as_ref()?)));
                let system = self.compiled.kernel().system;
                regular::keep_in_range(&mut self.group, system, self.blocks, of_lanes);
            }
            if any_done(&self.group, &self.target, self.map.is_stopped) {
                return Ok(());
            }
        }
    }

    fn look(&mut self, lane: usize, task: &mut LaneTask) -> Result<bool, Error> {
        if !done(&self.group, lane, self.target[lane], self.map.is_stopped) {
            return Ok(true);
        }
        let kernel = self.compiled.kernel();
        if task.on_orbit.is_some() && !(self.group.momentum.worst.0[lane] <= DRIFT_LIMIT) {
            // The body is faster than its bound, and its steps are too long.
            if let Some(again) = self.begin(lane, task.index, 2 * task.times) {
                *task = again;
                return Ok(true);
            }
            self.target[lane] = f64::INFINITY;
            self.group.deactivate(lane);
            return Ok(false);
        }
        let mut steps = self.group.count.0[lane] as u64;
        if let Some(leg) = task.leg {
            let is_over = done(&self.group, lane, f64::INFINITY, self.map.is_stopped);
            if !is_over && let Some(next) = self.next_leg(lane, task, leg) {
                task.leg = Some(next);
                return Ok(true);
            }
            let made = self.group.count.0[lane] - leg.from / leg.step();
            steps = leg.before + made.round() as u64;
        }
        let mut outcome = self.map.outcome(&self.group, lane, kernel.observed, (task.step, steps));
        if let Some(on_orbit) = &task.on_orbit {
            self.map.translate(on_orbit, &mut outcome);
        }
        if self.map.criterion == Criterion::MeanRateOverMotion {
            let forces = self.map.forces_of((self.first + task.index as u64) / self.map.samples);
            outcome.mean_rate /= forces.further.orbit.rate();
        }
        if let Some(checkpoints) = &mut task.checkpoints {
            if outcome.class != Class::Failed && !checkpoints.look(&mut self.group, kernel.system, lane) {
                self.target[lane] = checkpoints.next();
                return Ok(true);
            }
            outcome = checkpoints.outcome(&self.group, lane, outcome);
        }
        self.outcomes[task.index] = Some(outcome);
        self.target[lane] = f64::INFINITY;
        self.group.deactivate(lane);
        Ok(false)
    }
}

/// Whether a lane is at its horizon, has left stability and is stopped then, or has drifted.
#[inline(always)]
fn done(group: &Group, lane: usize, target: f64, is_stopped: bool) -> bool {
    // Written without short cuts, so that the test of a whole group is a few vector instructions.
    (group.count.0[lane] >= target)
        | (is_stopped & (group.observed[EXIT_TIME].0[lane] < f64::INFINITY))
        // A NaN is not below the limit either.
        | !(group.energy.worst.0[lane] <= DRIFT_LIMIT)
        | !(group.momentum.worst.0[lane] <= DRIFT_LIMIT)
        | !(group.unit.0[lane] <= DRIFT_LIMIT)
}

fn any_done(group: &Group, target: &[f64; LANES], is_stopped: bool) -> bool {
    (0..LANES).fold(false, |any, lane| any | done(group, lane, target[lane], is_stopped))
}
