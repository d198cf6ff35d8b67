//! Integrates samples side by side: a lane whose sample is finished gets the next sample.

use super::{Class, Map, Outcome, STEP_BLOCK};
use crate::error::Error;
use crate::kernel::{Compiled, Kernel};
use crate::kernel::{Entry, load};
use crate::kernel::{ForcingRows, Group};
use crate::observe::{EXIT_TIME, Observed};
use crate::simd::Isa;
use crate::simd::LANES;
use crate::start::Body;
use crate::status::{DRIFT_LIMIT, Status};
use std::sync::atomic::{AtomicBool, Ordering};

/// A run of a sample, by the method of the map or, as a cross-check, by the second method.
#[derive(Clone, Copy)]
pub(super) struct Task {
    /// Index in the block of samples.
    pub(super) index: usize,
    pub(super) cross_check: bool,
}

/// The task of an active lane, and its step.
#[derive(Clone, Copy)]
struct LaneTask {
    task: Task,
    step: f64,
}

impl Map {
    /// Integrates the tasks of one kernel and calls `finish` with each outcome. The bodies are those of the samples
    /// from `first` on.
    #[allow(clippy::too_many_arguments)] // Samples, solver, and the callback of outcomes.
    pub(super) fn integrate_batch(
        &self,
        (bodies, first): (&[Body], u64),
        tasks: &[Task],
        kernel: Kernel,
        isa: Isa,
        interrupt: &AtomicBool,
        mut finish: impl FnMut(Task, Outcome),
    ) -> Result<(), Error> {
        let compiled = Compiled::new(kernel, isa);
        let (mut group, mut forcing_rows) = (Group::inactive(), ForcingRows::NONE);
        let mut lanes: [Option<LaneTask>; LANES] = [None; LANES];
        // Steps after which each lane is at its horizon; an inactive lane never is.
        let mut target = [f64::INFINITY; LANES];
        let mut tasks = tasks.iter();
        let mut active = 0;
        let limit = self.criterion.limit();
        loop {
            for lane in 0..LANES {
                while lanes[lane].is_none() {
                    let Some(&task) = tasks.next() else { break };
                    let body = &bodies[task.index];
                    let forcing = self.forcing_of((first + task.index as u64) / self.samples);
                    let steps = self.steps_of(body, forcing, task.cross_check);
                    if steps > self.max_steps {
                        finish(task, Outcome::refused());
                        continue;
                    }
                    let step = self.t_end / steps as f64;
                    let assignment = self.assignment(body, task.cross_check);
                    let interval = (!forcing.is_none()).then(|| forcing.interval(0.0, false, body.moments));
                    let forcing = interval.as_ref().map(|interval| {
                        forcing_rows.set(lane, interval);
                        (interval, body.fastest_rate(forcing, [0.0, self.t_end]))
                    });
                    let entry = Entry { body, forcing, axis: self.axis, limit, step };
                    load(&mut group, lane, compiled, assignment, &entry);
                    target[lane] = steps as f64;
                    lanes[lane] = Some(LaneTask { task, step });
                    active += 1;
                }
            }
            if active == 0 {
                return Ok(());
            }
            loop {
                if interrupt.load(Ordering::Relaxed) {
                    return Err(Error::Stopped);
                }
                compiled.advance(&mut group, &forcing_rows, STEP_BLOCK as usize);
                if any_done(&group, &target) {
                    break;
                }
            }
            for lane in 0..LANES {
                let Some(lane_task) = lanes[lane] else { continue };
                if done(&group, lane, target[lane]) {
                    finish(lane_task.task, Map::outcome(&group, lane, kernel.observed, lane_task));
                    lanes[lane] = None;
                    target[lane] = f64::INFINITY;
                    active -= 1;
                    group.deactivate(lane);
                }
            }
        }
    }

    /// The outcome of a lane whose sample is finished.
    fn outcome(group: &Group, lane: usize, observed: Observed, lane_task: LaneTask) -> Outcome {
        let energy_drift = group.energy.worst.0[lane];
        let momentum_drift = group.momentum.worst.0[lane];
        let unit_drift = group.unit.0[lane];
        let steps = group.count.0[lane];
        let rows = group.observed_in(lane);
        let left = rows[EXIT_TIME];
        let value = observed.outcome(&rows);
        let finite = energy_drift.is_finite() && momentum_drift.is_finite() && unit_drift.is_finite();
        let (class, status) = if !finite {
            (Class::Failed, Status::NotFinite)
        } else if energy_drift.max(momentum_drift).max(unit_drift) > DRIFT_LIMIT {
            (Class::Failed, Status::Drifted)
        } else if left < f64::INFINITY {
            (Class::Unstable, Status::Stopped)
        } else {
            (Class::Stable, Status::Finished)
        };
        Outcome {
            class,
            status,
            flips: if observed == Observed::Flips { value as u64 } else { 0 },
            left,
            tilt: if observed == Observed::Tilt { value } else { f64::NAN },
            energy_drift,
            momentum_drift,
            unit_drift,
            step: lane_task.step,
            steps: steps as u64,
            exact: false,
        }
    }
}

/// Whether a lane is at its horizon, has left stability, or has drifted.
#[inline(always)]
fn done(group: &Group, lane: usize, target: f64) -> bool {
    // Written without short cuts, so that the test of a whole group is a few vector instructions.
    (group.count.0[lane] >= target)
        | (group.observed[EXIT_TIME].0[lane] < f64::INFINITY)
        // A NaN is not below the limit either.
        | !(group.energy.worst.0[lane] <= DRIFT_LIMIT)
        | !(group.momentum.worst.0[lane] <= DRIFT_LIMIT)
        | !(group.unit.0[lane] <= DRIFT_LIMIT)
}

fn any_done(group: &Group, target: &[f64; LANES]) -> bool {
    (0..LANES).fold(false, |any, lane| any | done(group, lane, target[lane]))
}
