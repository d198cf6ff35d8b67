//! Classification in closed form: when a sample leaves stability, without its trajectory.

use super::{Class, Criterion, Observation, Outcome};
use crate::body::Body;
use crate::exact::derived::is_on_separatrix;
use crate::exact::{CanonicalForm, ClosedForm, Evaluator, Exit, Question, StartRows, depths, versines};
use crate::observe::Observed;
use crate::simd::Isa;
use crate::simd::{LANES, Row};
use crate::status::Status;

/// A sample is undecided if its exit time and the horizon differ by less than this share of their sum: fifty times
/// the rounding of a phase.
const DOUBT: f64 = 1e-14;

/// When a sample leaves stability.
enum Leaving {
    /// At this time, which is known without the motion: at once, or never.
    At(f64),
    /// Where the motion crosses a limit, in the variables of the closed form.
    Crossing(Exit<f64>),
}

impl Leaving {
    /// The exit of a body of a map, if its time has a closed form.
    #[inline(always)]
    fn of(map: Observation<'_>, body: &Body, form: &CanonicalForm) -> Option<Leaving> {
        const NEVER: Option<Leaving> = Some(Leaving::At(f64::INFINITY));
        let observed = (map.axis.unsigned_abs() as usize).max(1) - 1;
        let axis = form.axis(observed);
        // The plan of a map depends on the moments and the weight only, so it cannot treat a top at rest separately.
        let symmetric =
            body.is_symmetric_about(observed) && (body.weight == [0.0; 3] || body.is_weighed_along(observed));
        match (map.criterion, form.closed_form) {
            (criterion, _) if !map.scene.has_weight && criterion.is_kept_without_torque() => NEVER,
            (Criterion::NoFlip, ClosedForm::PermanentRotation) if !map.scene.has_weight || symmetric => NEVER,
            (Criterion::NoFlip, ClosedForm::Symmetric | ClosedForm::Asymmetric) => {
                Some(Leaving::Crossing(Exit { axis: axis as f64, limit: [0.0; 2], direction: 1.0 }))
            }
            (Criterion::NoFlip, ClosedForm::Lagrange) if axis == 2 => NEVER,
            (Criterion::TiltFromVertical(angle), ClosedForm::Lagrange | ClosedForm::PermanentRotation)
                if map.scene.has_weight && symmetric =>
            {
                let along = (map.axis > 0) == (body.weight[observed] > 0.0);
                let [w, rest] = versines(angle);
                let (limit, direction) = if along { ([w, rest], 1.0) } else { ([rest, w], -1.0) };
                if form.closed_form == ClosedForm::Lagrange {
                    return Some(Leaving::Crossing(Exit { axis: axis as f64, limit, direction }));
                }
                let mut now = depths(body, observed);
                if !along {
                    now.reverse();
                }
                let is_past = if w <= 1.0 { now[0] > w } else { now[1] < rest };
                if is_past { Some(Leaving::At(0.0)) } else { NEVER }
            }
            _ => None,
        }
    }
}

/// Whether the body is classified in closed form.
pub(super) fn answers(map: Observation<'_>, body: &Body) -> bool {
    if map.criterion.rule().is_some() {
        return is_integrable(body);
    }
    CanonicalForm::of(body).is_some_and(|form| Leaving::of(map, body, &form).is_some())
}

/// Whether all motions of such a body are regular by theorem.
fn is_integrable(body: &Body) -> bool {
    ClosedForm::answering(Question::Regular, body.moments, body.weight).is_some()
}

/// Samples of one closed form, collected for a full register.
struct Waiting {
    evaluator: Evaluator,
    isa: Isa,
    starts: StartRows,
    exits: Exit<Row>,
    indices: [usize; LANES],
    filled: usize,
}

/// Classifies samples in closed form, a full register at a time.
pub(super) struct ClosedFormClassifier<'a> {
    map: Observation<'a>,
    isa: Isa,
    waiting: [Option<Waiting>; 3],
}

impl<'a> ClosedFormClassifier<'a> {
    pub(super) fn new(map: Observation<'a>, isa: Isa) -> Self {
        ClosedFormClassifier { map, isa, waiting: [None, None, None] }
    }

    /// Adds the sample if its exit time has a closed form; writes the outcomes of a full register.
    #[inline(always)]
    pub(super) fn take(&mut self, index: usize, body: &Body, outcomes: &mut [Option<Outcome>]) -> bool {
        if self.map.criterion.rule().is_some() {
            let is_known = is_integrable(body);
            if is_known {
                // Deviation vectors grow exponentially on a separatrix, although nothing is chaotic.
                let class = if is_on_separatrix(self.isa, body) { Class::Undecided } else { Class::Stable };
                let status = Status::Finished;
                outcomes[index] = Some(Outcome { class, status, exact: true, ..Outcome::REFUSED });
            }
            return is_known;
        }
        let Some(form) = CanonicalForm::of(body) else { return false };
        let exit = match Leaving::of(self.map, body, &form) {
            None => return false,
            Some(Leaving::At(left)) => {
                outcomes[index] = Some(outcome(self.map, left));
                return true;
            }
            Some(Leaving::Crossing(exit)) => exit,
        };
        let (evaluator, isa) = (form.evaluator(), self.isa);
        let waiting = self.waiting[evaluator as usize].get_or_insert_with(|| Waiting {
            evaluator,
            isa,
            starts: StartRows::filled(&form.to_canonical(body)),
            exits: Exit::ZERO,
            indices: [0; LANES],
            filled: 0,
        });
        let lane = waiting.filled;
        match evaluator {
            Evaluator::Free => waiting.starts.set(lane, body),
            _ => waiting.starts.set(lane, &form.to_canonical(body)),
        }
        waiting.exits.set(lane, exit);
        waiting.indices[lane] = index;
        waiting.filled += 1;
        if waiting.filled == LANES {
            classify(self.map, waiting, outcomes);
        }
        true
    }

    /// Classifies the remaining samples.
    pub(super) fn finish(mut self, outcomes: &mut [Option<Outcome>]) {
        for waiting in self.waiting.iter_mut().flatten() {
            classify(self.map, waiting, outcomes);
        }
    }
}

fn classify(map: Observation<'_>, waiting: &mut Waiting, outcomes: &mut [Option<Outcome>]) {
    let mut times = Row::ZERO;
    waiting.evaluator.exits(waiting.isa, &waiting.starts, &waiting.exits, &mut times);
    for (lane, &index) in waiting.indices[..waiting.filled].iter().enumerate() {
        outcomes[index] = Some(outcome(map, times.0[lane]));
    }
    waiting.filled = 0;
}

fn outcome(map: Observation<'_>, left: f64) -> Outcome {
    let doubtful = left.is_finite() && (left - map.t_end).abs() <= DOUBT * (left + map.t_end);
    let (class, status) = if left.is_nan() {
        (Class::Failed, Status::NotFinite)
    } else if doubtful {
        (Class::Undecided, Status::Finished)
    } else if left < map.t_end {
        (Class::Unstable, Status::Stopped)
    } else {
        (Class::Stable, Status::Finished)
    };
    Outcome {
        class,
        status,
        flips: u64::from(map.criterion.observed() == Observed::Flips && left <= map.t_end),
        left: if left <= map.t_end { left } else { f64::INFINITY },
        exact: true,
        ..Outcome::REFUSED
    }
}
