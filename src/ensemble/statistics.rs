//! What is known of a sample, and of all samples of a pixel.

use crate::trajectory::Status;

/// The verdict on a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Stayed stable until the horizon.
    Stable,
    /// Left stability before.
    Unstable,
    /// The second method disagrees.
    Undecided,
    /// No verdict: step limit, not finite, or drifted.
    Failed,
}

impl Class {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Class::Stable => "stable",
            Class::Unstable => "unstable",
            Class::Undecided => "undecided",
            Class::Failed => "failed",
        }
    }
}

/// What one run of one sample gave.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Stable, unstable or failed.
    pub class: Class,
    /// How it ended.
    pub status: Status,
    /// Sign changes seen.
    pub flips: u64,
    /// When stability was lost, infinite if it was not.
    pub left: f64,
    /// Largest tilt, NaN if none is watched (rad).
    pub tilt: f64,
    /// Largest relative energy error at the ends of bursts.
    pub energy_drift: f64,
    /// Largest relative error of the conserved momentum at the ends of bursts.
    pub momentum_drift: f64,
    /// Step.
    pub step: f64,
    /// Steps made.
    pub steps: u64,
    /// Judged in closed form: nothing drifts, and there are no steps.
    pub exact: bool,
}

impl Outcome {
    pub(super) fn was_run(&self) -> bool {
        self.status != Status::StepLimit
    }

    pub(super) fn took_steps(&self) -> bool {
        self.was_run() && !self.exact
    }

    /// A sample that would need more steps than allowed.
    pub(super) fn refused() -> Outcome {
        Outcome {
            class: Class::Failed,
            status: Status::StepLimit,
            flips: 0,
            left: f64::INFINITY,
            tilt: f64::NAN,
            energy_drift: f64::NAN,
            momentum_drift: f64::NAN,
            step: f64::NAN,
            steps: 0,
            exact: false,
        }
    }
}

/// The statistics of a pixel. All merge without order: sums of whole numbers, largest, smallest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Samples that stayed stable.
    pub stable: u64,
    /// Samples that did not.
    pub unstable: u64,
    /// Samples on whose verdict the second method disagrees.
    pub undecided: u64,
    /// Samples without a verdict.
    pub failed: u64,
    /// Of these, the samples that would have needed too many steps.
    pub step_limit: u64,
    /// Of these, the samples that overflowed.
    pub not_finite: u64,
    /// Of these, the samples that lost an invariant.
    pub drifted: u64,
    /// Samples judged in closed form.
    pub exact: u64,
    /// Samples judged again by the second method.
    pub checked: u64,
    /// Largest energy drift, NaN if nothing was run.
    pub energy_drift: f64,
    /// Largest momentum drift, NaN if nothing was run.
    pub momentum_drift: f64,
    /// Earliest loss of stability seen; infinite if none.
    pub earliest: f64,
    /// Steps of all runs.
    pub steps: u64,
    /// Processor time: measured, not reproducible.
    pub nanoseconds: f64,
}

impl Statistics {
    pub(super) fn none() -> Self {
        // `max` passes over a NaN: it stays only where nothing was run.
        let unknown = f64::NAN;
        Statistics {
            energy_drift: unknown,
            momentum_drift: unknown,
            earliest: f64::INFINITY,
            ..Default::default()
        }
    }

    pub(super) fn merge(&mut self, other: &Statistics) {
        self.stable += other.stable;
        self.unstable += other.unstable;
        self.undecided += other.undecided;
        self.failed += other.failed;
        self.step_limit += other.step_limit;
        self.not_finite += other.not_finite;
        self.drifted += other.drifted;
        self.exact += other.exact;
        self.checked += other.checked;
        self.energy_drift = self.energy_drift.max(other.energy_drift);
        self.momentum_drift = self.momentum_drift.max(other.momentum_drift);
        self.earliest = self.earliest.min(other.earliest);
        self.steps += other.steps;
        self.nanoseconds += other.nanoseconds;
    }

    pub(super) fn add(&mut self, verdict: Class, outcome: &Outcome, checked: bool) {
        match verdict {
            Class::Stable => self.stable += 1,
            Class::Unstable => self.unstable += 1,
            Class::Undecided => self.undecided += 1,
            Class::Failed => self.failed += 1,
        }
        self.step_limit += u64::from(outcome.status == Status::StepLimit);
        self.not_finite += u64::from(outcome.status == Status::NotFinite);
        self.drifted += u64::from(outcome.status == Status::Drifted);
        self.checked += u64::from(checked);
        self.exact += u64::from(outcome.exact);
        // A sample that was not run has no drift: `max` passes over its NaN. One that overflowed lost all.
        let lost = |drift: f64| if drift.is_nan() && outcome.took_steps() { f64::INFINITY } else { drift };
        self.energy_drift = self.energy_drift.max(lost(outcome.energy_drift));
        self.momentum_drift = self.momentum_drift.max(lost(outcome.momentum_drift));
        if verdict == Class::Unstable {
            self.earliest = self.earliest.min(outcome.left);
        }
    }
}
