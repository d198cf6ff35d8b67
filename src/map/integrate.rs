//! Integrates samples side by side: a lane whose sample is finished gets the next sample.

use super::Criterion;
use super::regular::{self, Course};
use super::{Class, Outcome, STEP_BLOCK, Watched};
use crate::error::Error;
use crate::kernel::{Compiled, Kernel};
use crate::kernel::{Entry, load};
use crate::kernel::{ForcingRows, Group};
use crate::memory;
use crate::observe::{Displacement, EXIT_TIME, Observed};
use crate::parallel::Interrupt;
use crate::scheme::Step;
use crate::simd::Isa;
use crate::simd::LANES;
use crate::start::Body;
use crate::status::{DRIFT_LIMIT, Status};

/// What the lists of samples of a block are called if they do not fit into memory.
pub(super) const RUNS: &str = "runs of a block";

/// The sample of an active lane: its index in the block, its step, and its way through the checkpoints of regularity.
#[derive(Clone, Copy)]
struct LaneTask {
    index: usize,
    step: f64,
    course: Option<Course>,
}

/// How samples are integrated.
#[derive(Clone, Copy)]
pub(super) struct Run<'a> {
    /// By the second method.
    pub(super) cross_check: bool,
    pub(super) isa: Isa,
    pub(super) interrupt: &'a Interrupt<'a>,
}

impl Watched<'_> {
    /// Integrates samples of a block, given by their indices, and writes their outcomes. The bodies are those of the
    /// samples from `first` on.
    pub(super) fn integrate(
        &self,
        (bodies, first): (&[Body], u64),
        samples: &[usize],
        run: Run,
        outcomes: &mut [Option<Outcome>],
    ) -> Result<(), Error> {
        let mut by_step: Vec<(Step, Vec<usize>)> = Vec::new();
        for &index in samples {
            let step = self.assignment(&bodies[index], run.cross_check).step;
            let known = by_step.iter().position(|(known, _)| *known == step);
            if known.is_none() {
                memory::push(RUNS, &mut by_step, (step, Vec::new()))?;
            }
            let at = known.unwrap_or(by_step.len() - 1);
            memory::push(RUNS, &mut by_step[at].1, index)?;
        }
        for (step, samples) in &by_step {
            self.integrate_batch((bodies, first), samples, self.kernel(*step), run, outcomes)?;
        }
        Ok(())
    }

    /// Integrates the samples of one kernel.
    fn integrate_batch(
        &self,
        (bodies, first): (&[Body], u64),
        samples: &[usize],
        kernel: Kernel,
        Run { cross_check, isa, interrupt }: Run,
        outcomes: &mut [Option<Outcome>],
    ) -> Result<(), Error> {
        let compiled = Compiled::new(kernel, isa);
        let (mut group, mut forcing_rows) = (Group::inactive(), ForcingRows::NONE);
        let mut lanes: [Option<LaneTask>; LANES] = [None; LANES];
        // Steps after which each lane is at its horizon, or is to be looked at; an inactive lane never is.
        let mut target = [f64::INFINITY; LANES];
        let mut samples = samples.iter();
        let mut active = 0;
        let limit = self.criterion.limit();
        let rule = self.criterion.rule();
        let of_attitude = matches!(self.criterion, Criterion::RegularAttitude(_));
        let steps_together = if rule.is_some() { regular::BLOCK } else { STEP_BLOCK };
        let mut blocks = 0;
        loop {
            for lane in 0..LANES {
                while lanes[lane].is_none() {
                    let Some(&index) = samples.next() else { break };
                    let body = &bodies[index];
                    let forcing = self.forcing_of((first + index as u64) / self.samples);
                    let steps = self.steps_of(body, forcing, cross_check);
                    if steps > self.max_steps {
                        outcomes[index] = Some(Outcome::REFUSED);
                        continue;
                    }
                    let step = self.t_end / steps as f64;
                    let assignment = self.assignment(body, cross_check);
                    let displacement = match rule {
                        Some(_) => regular::displacement(body, forcing, of_attitude, cross_check),
                        None => Displacement::NONE,
                    };
                    let course = rule.map(|rule| {
                        let norm = assignment.displacement(&displacement, body);
                        Course::new(rule, norm, self.is_forced(), [steps as f64, self.t_end])
                    });
                    let interval = (!forcing.is_none()).then(|| forcing.interval(0.0, false, body.moments));
                    let forcing = interval.as_ref().map(|interval| {
                        forcing_rows.set(lane, interval);
                        (interval, body.fastest_rate(forcing, [0.0, self.t_end]))
                    });
                    let (axis, bound) = (self.axis, self.criterion.bound());
                    let entry = Entry { body, forcing, axis, limit, step, displacement, bound };
                    load(&mut group, lane, compiled, assignment, &entry);
                    if let Some(course) = &course {
                        course.settle(&mut group, kernel.system, lane);
                    }
                    target[lane] = course.map_or(steps as f64, |course| course.next());
                    lanes[lane] = Some(LaneTask { index, step, course });
                    active += 1;
                }
            }
            if active == 0 {
                return Ok(());
            }
            loop {
                if interrupt.is_wanted() {
                    return Err(Error::Stopped);
                }
                compiled.advance(&mut group, &forcing_rows, steps_together as usize);
                if rule.is_some() {
                    blocks += 1;
                    let courses = lanes.iter().enumerate();
                    let courses =
                        courses.filter_map(|(lane, task)| Some((lane, task.as_ref()?.course.as_ref()?)));
                    regular::keep_in_range(&mut group, kernel.system, blocks, courses);
                }
                if any_done(&group, &target, self.is_stopped) {
                    break;
                }
            }
            for lane in 0..LANES {
                let Some(task) = &mut lanes[lane] else { continue };
                if done(&group, lane, target[lane], self.is_stopped) {
                    let mut outcome = Watched::outcome(&group, lane, kernel.observed, task.step);
                    if let Some(course) = &mut task.course {
                        if outcome.class != Class::Failed && !course.look(&mut group, kernel.system, lane) {
                            target[lane] = course.next();
                            continue;
                        }
                        outcome = course.outcome(&group, lane, outcome);
                    }
                    outcomes[task.index] = Some(outcome);
                    lanes[lane] = None;
                    target[lane] = f64::INFINITY;
                    active -= 1;
                    group.deactivate(lane);
                }
            }
        }
    }

    /// The outcome of a lane whose sample is finished.
    fn outcome(group: &Group, lane: usize, observed: Observed, step: f64) -> Outcome {
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
        } else if observed == Observed::Bounds && value.is_nan() {
            (Class::Undecided, Status::Finished)
        } else {
            (Class::Stable, Status::Finished)
        };
        Outcome {
            class,
            status,
            flips: if observed == Observed::Flips { value as u64 } else { 0 },
            left,
            tilt: if observed == Observed::Tilt { value } else { f64::NAN },
            mean_rate: if observed == Observed::MeanRate { value } else { f64::NAN },
            exponent: f64::NAN,
            mean_megno: f64::NAN,
            energy_drift,
            momentum_drift,
            unit_drift,
            step,
            steps: steps as u64,
            exact: false,
        }
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
