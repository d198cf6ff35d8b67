//! Values of a sample that a map collects: what is measured until the horizon, whatever the class.

use super::observation::Run;
use super::statistics::Sample;
use super::{Class, Criterion, Map, Observation, Outcome};
use crate::call::Call;
use crate::error::{Error, refuse};
use crate::memory;
use crate::observe::{Direction, Tilt};
use std::f64::consts::PI;
use std::ops::Range;

/// The value of a sample with two runs counts if they differ in it by a smaller share.
const AGREED: f64 = 1e-3;

/// What a sample adds to the sketch of a measure.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    /// NaN if the sample has none.
    pub number: f64,
    /// By how much two runs differ in it; NaN without a second run.
    pub error: f64,
}

impl Value {
    /// That of a sample without a value.
    pub const NONE: Value = Value { number: f64::NAN, error: f64::NAN };

    /// That of a sample without a second run.
    fn unchecked(number: f64) -> Value {
        Value { number, error: f64::NAN }
    }
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The time at which a sample that is unstable left stability.
    TimeToLeave,
    /// The largest drift of energy, momentum and unit lengths of the runs that classify the sample.
    Drift,
    /// Sign changes of the rate about the axis.
    Flips,
    /// The largest tilt of the axis from where it started.
    TiltFromStart,
    /// The largest tilt of the axis from the vertical.
    TiltFromVertical,
    /// The mean over the time of the rate about the axis.
    MeanRate,
    /// The same over the mean motion of the orbit.
    MeanRateOverMotion,
    /// The largest angle of the end of the axis that is nearer to the direction from the planet at the start.
    AngleFromRadial,
    /// The largest angle of the axis from the normal of the orbit.
    AngleFromNormal,
    /// The largest roll, pitch or yaw, of either sign.
    LargestAngle,
    /// The time from which on a criterion is kept until the horizon.
    TimeToSettle,
}

impl Quantity {
    /// What is observed in a run of its own until the horizon; `None` if the runs that classify tell the value, or if the
    /// criterion is given.
    fn observed(self) -> Option<Criterion> {
        match self {
            Quantity::TimeToLeave | Quantity::Drift | Quantity::LargestAngle | Quantity::TimeToSettle => None,
            Quantity::Flips => Some(Criterion::NoFlip),
            Quantity::TiltFromStart => Some(Criterion::TiltFromStart(f64::INFINITY)),
            Quantity::TiltFromVertical => Some(Criterion::TiltFromVertical(f64::INFINITY)),
            Quantity::MeanRate => Some(Criterion::MeanRate),
            Quantity::MeanRateOverMotion => Some(Criterion::MeanRateOverMotion),
            Quantity::AngleFromRadial => Some(Criterion::pointing(Direction::Radial, PI, true)),
            Quantity::AngleFromNormal => Some(Criterion::pointing(Direction::Normal, PI, false)),
        }
    }
}

/// A measure: a quantity, of a body axis if it has one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// What is measured.
    pub quantity: Quantity,
    /// The body axis: 1, 2, 3 or -1, -2, -3; 0 for none.
    pub axis: i32,
    /// What is observed in a run of its own until the horizon; `None` if the runs that classify tell the value.
    pub(super) observed: Option<Criterion>,
}

impl Measure {
    /// The measure of that name: `largest_` and `settled_` come before the name of a bounded criterion with these numbers.
    ///
    /// # Errors
    /// Naming the known ones, or the axis.
    pub fn parse(name: &str, axis: i32, numbers: &[f64]) -> Result<Measure, Error> {
        const NAMES: [(&str, Quantity); 9] = [
            ("time_to_leave", Quantity::TimeToLeave),
            ("drift", Quantity::Drift),
            ("flips", Quantity::Flips),
            ("tilt_from_start", Quantity::TiltFromStart),
            ("tilt_from_vertical", Quantity::TiltFromVertical),
            ("mean_rate", Quantity::MeanRate),
            ("mean_rate_over_motion", Quantity::MeanRateOverMotion),
            ("angle_from_radial", Quantity::AngleFromRadial),
            ("angle_from_normal", Quantity::AngleFromNormal),
        ];
        const OF_CRITERIA: [(&str, Quantity); 2] =
            [("largest_", Quantity::LargestAngle), ("settled_", Quantity::TimeToSettle)];
        let of_criterion =
            OF_CRITERIA.iter().find_map(|(kind, quantity)| Some((name.strip_prefix(kind)?, *quantity)));
        let (quantity, observed) = if let Some((criterion, quantity)) = of_criterion {
            let criterion = Criterion::parse(criterion, numbers)?;
            if criterion.bound().is_none_or(|bound| Tilt::of(bound).is_some()) {
                let rule = "must be of a rate, an angle of the orbit, or a distance from the start";
                return refuse("measure", name, rule);
            }
            (quantity, Some(criterion))
        } else if let Some((_, quantity)) = NAMES.into_iter().find(|(known, _)| *known == name) {
            (quantity, quantity.observed())
        } else {
            let known = NAMES.map(|(known, _)| known).join(", ");
            return Err(Error::Unknown { argument: "measure", value: name.into(), known });
        };
        let measure = Measure { quantity, axis, observed };
        let least = u32::from(observed.is_some_and(Criterion::has_axis));
        if !(least..=3).contains(&axis.unsigned_abs()) {
            return refuse("axis", axis, "must be 1, 2, 3 or -1, -2, -3");
        }
        Ok(measure)
    }

    /// Whether the runs that classify tell the value.
    pub(super) fn is_known(self) -> bool {
        self.observed.is_none()
    }

    /// Whether it can be measured under torque and damping.
    pub(super) fn can_be_forced(self) -> bool {
        self.quantity != Quantity::TiltFromStart
    }

    /// The value of a sample, from its classification and from its own runs. Deviation vectors of two runs are not seen
    /// to grow at the same time: then the times of leaving are not compared.
    pub(super) fn value(self, sample: &Sample, own: Option<&Own>, of_growth: bool) -> Value {
        match (self.quantity, own) {
            (Quantity::TimeToLeave, _) if sample.class == Class::Unstable => {
                let again = sample.second.filter(|again| again.was_run() && !of_growth);
                self.compared(sample.first.left, again.map(|again| again.left), sample.t_end)
            }
            (Quantity::Drift, _) if sample.class != Class::Failed => {
                // `max` ignores a NaN.
                let first = sample.first;
                Value::unchecked(first.energy_drift.max(first.momentum_drift).max(first.unit_drift))
            }
            (_, Some(own)) => own.value,
            _ => Value::NONE,
        }
    }

    /// The value of a run of its own; NaN if the run failed.
    fn of_run(self, own: &Outcome) -> f64 {
        match self.quantity {
            _ if own.class == Class::Failed => f64::NAN,
            Quantity::Flips => own.flips as f64,
            Quantity::MeanRate | Quantity::MeanRateOverMotion => own.mean_rate,
            Quantity::TimeToSettle if own.settled < f64::INFINITY => own.settled,
            Quantity::TimeToSettle => f64::NAN,
            _ => own.tilt,
        }
    }

    /// The value of a first run, if a second one agrees to a share of it, or of a radian, or of a radian in the whole time.
    fn compared(self, one: f64, again: Option<f64>, t_end: f64) -> Value {
        let Some(other) = again else { return Value::unchecked(one) };
        let least = match self.quantity {
            Quantity::TimeToLeave | Quantity::TimeToSettle | Quantity::Drift | Quantity::Flips => 0.0,
            Quantity::MeanRate | Quantity::MeanRateOverMotion => 1.0 / t_end,
            _ => 1.0,
        };
        let (error, size) = ((one - other).abs(), one.abs().max(other.abs()).max(least));
        // A time of leaving that only one run has is infinite in the other.
        if size < f64::INFINITY && error <= AGREED * size {
            Value { number: one, error }
        } else {
            Value::NONE
        }
    }
}

/// What the runs of a measure tell of a sample.
#[derive(Clone, Copy)]
pub(super) struct Own {
    value: Value,
    /// Steps of both.
    pub(super) steps: u64,
}

impl Map {
    /// What the runs of the measures tell of a range of samples; an empty list for a measure that has no run. A second run
    /// repeats those of the samples that are checked: of all if verdicts choose which.
    pub(super) fn measured(&self, range: Range<u64>, call: Call) -> Result<Vec<Vec<Option<Own>>>, Error> {
        const MEASURES: &str = "measures of a block";
        let mut all = memory::reserved(MEASURES, self.measures.len())?;
        let (mut samples, mut checked) = (Vec::new(), Vec::new());
        let mut bodies = Vec::new();
        for measure in &self.measures {
            let Some(criterion) = measure.observed else {
                all.push(Vec::new());
                continue;
            };
            if bodies.is_empty() {
                bodies = self.draw(call.isa, range.clone())?;
                for (index, place) in self.pixels_and_samples(range.clone()).enumerate() {
                    if !self.pixels[place.0 as usize].possible {
                        continue;
                    }
                    memory::push(MEASURES, &mut samples, index)?;
                    if self.check.takes(self.counter(place)[1]) {
                        memory::push(MEASURES, &mut checked, index)?;
                    }
                }
            }
            let mut outcomes = memory::filled(MEASURES, bodies.len(), None)?;
            let observation = Observation { map: self, criterion, axis: measure.axis, is_stopped: false };
            let run = Run { cross_check: false, call };
            observation.integrate((&bodies, range.start), &samples, run, &mut outcomes)?;
            let mut again = memory::filled(MEASURES, bodies.len(), None::<Outcome>)?;
            let run = Run { cross_check: true, ..run };
            observation.integrate((&bodies, range.start), &checked, run, &mut again)?;
            let own = outcomes.iter().zip(&again).map(|(first, second)| {
                let (first, second) = (first.as_ref()?, second.as_ref().filter(|second| second.was_run()));
                let other = second.map(|second| measure.of_run(second));
                let value = measure.compared(measure.of_run(first), other, self.t_end);
                Some(Own { value, steps: first.steps + second.map_or(0, |second| second.steps) })
            });
            all.push(memory::collected(MEASURES, bodies.len(), own)?);
        }
        Ok(all)
    }
}
