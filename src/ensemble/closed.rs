//! Verdicts in closed form: when a sample leaves stability, without its trajectory.

use super::{Class, Criterion, Map, Outcome};
use crate::exact::{Evaluator, ExitRows, Form, Kind, Place, StartRows};
use crate::kernel::{LANES, Row};
use crate::simd::Isa;
use crate::start::Body;
use crate::trajectory::Status;

/// Share of the horizon, and of the time of leaving, within which a closed form does not tell before from after:
/// fifty times the rounding of a phase.
const DOUBT: f64 = 1e-14;

/// A sample whose verdict has a closed form.
#[derive(Clone, Copy)]
pub(super) struct Question {
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
    pub(super) fn of(map: &Map, body: &Body) -> Option<Question> {
        let place = Place::of(body)?;
        let watched = map.axis.unsigned_abs() as usize - 1;
        let axis = place.axis(watched);
        let plain = Question { place, axis, limit: 0.0, direction: 1.0, known: None };
        match (map.criterion, place.form) {
            (Criterion::NoFlip, Form::Spin) => Some(Question { known: Some(f64::INFINITY), ..plain }),
            (Criterion::NoFlip, Form::Symmetric | Form::Asymmetric) => Some(plain),
            (Criterion::NoFlip, Form::Lagrange) if axis == 2 => {
                Some(Question { known: Some(f64::INFINITY), ..plain })
            }
            (Criterion::TiltFromVertical(angle), Form::Lagrange | Form::Spin)
                if map.is_top && body.is_weighed_along(watched) =>
            {
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

/// The outcomes of questions, in their order.
pub(super) fn answers(map: &Map, questions: &[Question], isa: Isa) -> Vec<Outcome> {
    let mut left: Vec<f64> = questions.iter().map(|q| q.known.unwrap_or(f64::NAN)).collect();
    for kind in [Kind::Symmetric, Kind::Free, Kind::Lagrange] {
        let asked: Vec<usize> = (0..questions.len())
            .filter(|&i| questions[i].known.is_none() && questions[i].place.kind == kind)
            .collect();
        if asked.is_empty() {
            continue;
        }
        let evaluator = Evaluator::new(kind, isa);
        for indices in asked.chunks(LANES) {
            let mut starts = StartRows::filled(&questions[indices[0]].place.body);
            let nothing = Row([0.0; LANES]);
            let mut exits = ExitRows { axis: nothing, limit: nothing, direction: nothing };
            for (lane, &i) in indices.iter().enumerate() {
                starts.set(lane, &questions[i].place.body);
                exits.axis.0[lane] = questions[i].axis as f64;
                exits.limit.0[lane] = questions[i].limit;
                exits.direction.0[lane] = questions[i].direction;
            }
            let mut times = nothing;
            evaluator.exits(&starts, &exits, &mut times);
            for (lane, &i) in indices.iter().enumerate() {
                left[i] = times.0[lane];
            }
        }
    }
    left.iter().map(|&left| outcome(map, left)).collect()
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
