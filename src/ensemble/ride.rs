//! Samples side by side: each lane takes the next as it falls free.

use super::{BURST, Class, Criterion, Map, Outcome};
use crate::group::{Drives, Group, LANES};
use crate::kernel::{Compiled, Kernel};
use crate::observe::{TiltLimit, largest_tilt};
use crate::outside::Outside;
use crate::simd::Isa;
use crate::start::{Body, enter_side, load, widen_scales};
use crate::trajectory::{DRIFT_LIMIT, Status};
use std::sync::atomic::{AtomicBool, Ordering};

/// One run: which sample, by the method of the map or by the second one.
#[derive(Clone, Copy)]
pub(super) struct Job {
    /// Place in the block.
    pub(super) index: usize,
    pub(super) again: bool,
}

/// A body in a lane.
#[derive(Clone, Copy)]
struct Passenger {
    job: Job,
    step: f64,
}

impl Map {
    /// Runs jobs of one table through a group, refilling each lane as it falls free; `None` if interrupted. The bodies
    /// are those of the samples from `first` on.
    #[allow(clippy::too_many_arguments)] // Who, how, and what then.
    pub(super) fn ride(
        &self,
        (bodies, first): (&[Body], u64),
        outside: Option<&[Outside]>,
        jobs: &[Job],
        kernel: Kernel,
        isa: Isa,
        interrupt: &AtomicBool,
        mut finish: impl FnMut(Job, Outcome),
    ) -> Option<()> {
        let compiled = Compiled::new(kernel, isa);
        let (mut group, mut drives) = (Group::waiting(), Drives::NONE);
        let mut lanes: [Option<Passenger>; LANES] = [None; LANES];
        // Steps after which each lane is at its horizon; a lane that waits never is.
        let mut target = [f64::INFINITY; LANES];
        let mut jobs = jobs.iter();
        let mut aboard = 0;
        let limit = self.tilt_limit();
        loop {
            for lane in 0..LANES {
                while lanes[lane].is_none() {
                    let Some(&job) = jobs.next() else { break };
                    let body = &bodies[job.index];
                    let outside =
                        outside.map(|all| &all[((first + job.index as u64) / self.samples) as usize]);
                    let steps = self.steps_of(body, outside, job.again);
                    if steps > self.max_steps {
                        finish(job, Outcome::refused());
                        continue;
                    }
                    let step = self.t_end / steps as f64;
                    let seat = self.seat(body, outside.is_some(), job.again);
                    load(&mut group, lane, (kernel, compiled), seat, body, self.axis, step);
                    if let Some(outside) = outside {
                        let drive = outside.drive(0.0, false, body.moments);
                        drives.set(lane, &drive);
                        let rate = body.fastest_rate_driven(outside, [0.0, self.t_end]);
                        enter_side(&mut group, lane, body, self.axis, &drive, rate);
                        widen_scales(&mut group, lane, kernel.system, body, rate);
                    }
                    if let Some(limit) = limit {
                        group.limit[0].0[lane] = limit.cosine;
                        group.limit[1].0[lane] = limit.sine2;
                        // Beyond the limit from the start.
                        if group.cosine.0[lane] < limit.cosine || group.sine2.0[lane] > limit.sine2 {
                            group.left.0[lane] = 0.0;
                        }
                    }
                    target[lane] = steps as f64;
                    lanes[lane] = Some(Passenger { job, step });
                    aboard += 1;
                }
            }
            if aboard == 0 {
                return Some(());
            }
            loop {
                if interrupt.load(Ordering::Relaxed) {
                    return None;
                }
                compiled.advance_driven(&mut group, &drives, BURST as usize);
                if any_done(&group, &target) {
                    break;
                }
            }
            for lane in 0..LANES {
                let Some(passenger) = lanes[lane] else { continue };
                if done(&group, lane, target[lane]) {
                    finish(passenger.job, self.outcome(&group, lane, passenger));
                    lanes[lane] = None;
                    target[lane] = f64::INFINITY;
                    aboard -= 1;
                    group.wait(lane);
                }
            }
        }
    }

    fn tilt_limit(&self) -> Option<TiltLimit> {
        match self.criterion {
            Criterion::NoFlip => None,
            Criterion::TiltFromStart(angle) | Criterion::TiltFromVertical(angle) => {
                Some(TiltLimit::new(angle))
            }
        }
    }

    /// The outcome of a lane that is done.
    fn outcome(&self, group: &Group, lane: usize, passenger: Passenger) -> Outcome {
        let energy_drift = group.energy.worst.0[lane];
        let momentum_drift = group.momentum.worst.0[lane];
        let steps = group.count.0[lane];
        let left = group.left.0[lane];
        let finite = energy_drift.is_finite() && momentum_drift.is_finite() && group.unit.0[lane].is_finite();
        let (class, status) = if !finite {
            (Class::Failed, Status::NotFinite)
        } else if energy_drift.max(momentum_drift).max(group.unit.0[lane]) > DRIFT_LIMIT {
            (Class::Failed, Status::Drifted)
        } else if left < f64::INFINITY {
            (Class::Unstable, Status::Stopped)
        } else {
            (Class::Stable, Status::Finished)
        };
        Outcome {
            class,
            status,
            flips: group.flips.0[lane] as u64,
            left,
            tilt: match self.criterion {
                Criterion::NoFlip => f64::NAN,
                _ => largest_tilt(group.cosine.0[lane], group.sine2.0[lane]),
            },
            energy_drift,
            momentum_drift,
            step: passenger.step,
            steps: steps as u64,
            exact: false,
        }
    }
}

/// Whether a lane is at its horizon, has left stability, or is no longer to be believed.
#[inline(always)]
fn done(group: &Group, lane: usize, target: f64) -> bool {
    // Written without short cuts, so that the test of a whole group is a few vector instructions.
    (group.count.0[lane] >= target)
        | (group.left.0[lane] < f64::INFINITY)
        // A NaN is not below the limit either.
        | !(group.energy.worst.0[lane] <= DRIFT_LIMIT)
        | !(group.momentum.worst.0[lane] <= DRIFT_LIMIT)
        | !(group.unit.0[lane] <= DRIFT_LIMIT)
}

fn any_done(group: &Group, target: &[f64; LANES]) -> bool {
    (0..LANES).fold(false, |any, lane| any | done(group, lane, target[lane]))
}
