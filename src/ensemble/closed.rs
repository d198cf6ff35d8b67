//! Verdicts in closed form: when a sample leaves stability, without its trajectory.

use super::{Class, Criterion, Map, Outcome};
use crate::exact::{Evaluator, ExitRows, Form, Kind, Place, StartRows};
use crate::group::{LANES, Row};
use crate::simd::Isa;
use crate::start::Body;
use crate::trajectory::Status;

/// Share of the horizon, and of the time of leaving, within which a closed form does not tell before from after:
/// fifty times the rounding of a phase.
const DOUBT: f64 = 1e-14;

/// A sample whose verdict has a closed form.
#[derive(Clone, Copy)]
struct Question {
    place: Place,
    /// Watched component, in the variables of the closed form.
    axis: usize,
    /// 1 - cos of the limit, measured to the centre of mass, and the direction in which it is passed.
    limit: f64,
    direction: f64,
    /// The verdict is known without the motion: left at once, or never.
    known: Option<f64>,
}

impl Question {
    /// The question that a map asks of a body, if it is answered in closed form.
    #[inline(always)]
    fn of(map: &Map, body: &Body) -> Option<Question> {
        let place = Place::of(body)?;
        let watched = map.axis.unsigned_abs() as usize - 1;
        let axis = place.axis(watched);
        // What the plan of a map can know: a top that stands still by chance is not singled out.
        let symmetric =
            body.is_symmetric_about(watched) && (body.weight == [0.0; 3] || body.is_weighed_along(watched));
        let plain = Question { place, axis, limit: 0.0, direction: 1.0, known: None };
        match (map.criterion, place.form) {
            (Criterion::NoFlip, Form::Spin) if !map.is_top || symmetric => {
                Some(Question { known: Some(f64::INFINITY), ..plain })
            }
            (Criterion::NoFlip, Form::Symmetric | Form::Asymmetric) => Some(plain),
            (Criterion::NoFlip, Form::Lagrange) if axis == 2 => {
                Some(Question { known: Some(f64::INFINITY), ..plain })
            }
            (Criterion::TiltFromVertical(angle), Form::Lagrange | Form::Spin) if map.is_top && symmetric => {
                let half = crate::special::sincos(0.5 * angle);
                let along = (map.axis > 0) == (body.weight[watched] > 0.0);
                let part = if along { half.0 } else { half.1 };
                let (limit, direction) = (2.0 * part * part, if along { 1.0 } else { -1.0 });
                let known = (place.form == Form::Spin).then(|| {
                    let now = body.depth(watched);
                    if direction * (now - limit) > 0.0 { 0.0 } else { f64::INFINITY }
                });
                Some(Question { limit, direction, known, ..plain })
            }
            _ => None,
        }
    }
}

/// Whether the verdict on this body has a closed form.
pub(super) fn answers(map: &Map, body: &Body) -> bool {
    Question::of(map, body).is_some()
}

/// Samples of one kind that wait for a full register.
struct Waiting {
    evaluator: Evaluator,
    starts: StartRows,
    exits: ExitRows,
    indices: [usize; LANES],
    filled: usize,
}

/// Judges samples as they come, by full registers.
pub(super) struct Referee<'a> {
    map: &'a Map,
    isa: Isa,
    waiting: [Option<Box<Waiting>>; 3],
}

impl<'a> Referee<'a> {
    pub(super) fn new(map: &'a Map, isa: Isa) -> Self {
        Referee { map, isa, waiting: [None, None, None] }
    }

    /// Takes the sample if its verdict has a closed form; some outcomes may then be ready.
    #[inline(always)]
    pub(super) fn take(&mut self, index: usize, body: &Body, outcomes: &mut [Option<Outcome>]) -> bool {
        let Some(question) = Question::of(self.map, body) else { return false };
        if let Some(left) = question.known {
            outcomes[index] = Some(outcome(self.map, left));
            return true;
        }
        let kind = question.place.kind();
        let isa = self.isa;
        let waiting = self.waiting[kind as usize].get_or_insert_with(|| {
            let nothing = Row([0.0; LANES]);
            Box::new(Waiting {
                evaluator: Evaluator::new(kind, isa),
                starts: StartRows::filled(&question.place.canonical(body)),
                exits: ExitRows { axis: nothing, limit: nothing, direction: nothing },
                indices: [0; LANES],
                filled: 0,
            })
        });
        let lane = waiting.filled;
        match kind {
            Kind::Free => waiting.starts.set(lane, body),
            _ => waiting.starts.set(lane, &question.place.canonical(body)),
        }
        waiting.exits.axis.0[lane] = question.axis as f64;
        waiting.exits.limit.0[lane] = question.limit;
        waiting.exits.direction.0[lane] = question.direction;
        waiting.indices[lane] = index;
        waiting.filled += 1;
        if waiting.filled == LANES {
            judge(self.map, waiting, outcomes);
        }
        true
    }

    /// Judges what still waits.
    pub(super) fn finish(mut self, outcomes: &mut [Option<Outcome>]) {
        for waiting in self.waiting.iter_mut().flatten() {
            judge(self.map, waiting, outcomes);
        }
    }
}

fn judge(map: &Map, waiting: &mut Waiting, outcomes: &mut [Option<Outcome>]) {
    let mut times = Row([0.0; LANES]);
    waiting.evaluator.exits(&waiting.starts, &waiting.exits, &mut times);
    for (lane, &index) in waiting.indices[..waiting.filled].iter().enumerate() {
        outcomes[index] = Some(outcome(map, times.0[lane]));
    }
    waiting.filled = 0;
}

fn outcome(map: &Map, left: f64) -> Outcome {
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
        flips: u64::from(map.criterion == Criterion::NoFlip && left <= map.t_end),
        left: if left <= map.t_end { left } else { f64::INFINITY },
        tilt: f64::NAN,
        energy_drift: f64::NAN,
        momentum_drift: f64::NAN,
        step: f64::NAN,
        steps: 0,
        exact: true,
    }
}
