//! Values of a sample that a map collects: what is measured until the horizon, whatever the class.

use super::integrate::Run;
use super::statistics::Sample;
use super::{Class, Criterion, Map, Outcome, Watched};
use crate::error::Error;
use crate::memory;
use crate::observe::Direction;
use crate::parallel::Interrupt;
use crate::simd::Isa;
use std::f64::consts::PI;
use std::ops::Range;

/// Under a function the value of a sample counts if two runs differ in it by a smaller share: jumps of a torque take their
/// order from equal steps.
const AGREED: f64 = 1e-3;

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
}

/// A measure: a quantity, of a body axis if it has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measure {
    /// What is measured.
    pub quantity: Quantity,
    /// The body axis: 1, 2, 3 or -1, -2, -3; 0 for none.
    pub axis: i32,
}

impl Measure {
    /// The measure of that name.
    ///
    /// # Errors
    /// Naming the known ones, or the axis.
    pub fn parse(name: &str, axis: i32) -> Result<Measure, Error> {
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
        let Some((_, quantity)) = NAMES.into_iter().find(|(known, _)| *known == name) else {
            let known = NAMES.map(|(known, _)| known).join(", ");
            return Err(Error::Unknown { argument: "measure", value: name.into(), known });
        };
        let measure = Measure { quantity, axis };
        let least = u32::from(measure.watched().is_some());
        if !(least..=3).contains(&axis.unsigned_abs()) {
            let rule = "must be 1, 2, 3 or -1, -2, -3";
            return Err(Error::Value { argument: "axis", value: axis.to_string(), rule });
        }
        Ok(measure)
    }

    /// What is observed in a run of its own until the horizon; `None` if the runs that classify tell the value.
    pub(super) fn watched(self) -> Option<Criterion> {
        match self.quantity {
            Quantity::TimeToLeave | Quantity::Drift => None,
            Quantity::Flips => Some(Criterion::NoFlip),
            Quantity::TiltFromStart => Some(Criterion::TiltFromStart(f64::INFINITY)),
            Quantity::TiltFromVertical => Some(Criterion::TiltFromVertical(f64::INFINITY)),
            Quantity::MeanRate => Some(Criterion::MeanRate),
            Quantity::MeanRateOverMotion => Some(Criterion::MeanRateOverMotion),
            Quantity::AngleFromRadial => Some(Criterion::pointing(Direction::Radial, PI, true)),
            Quantity::AngleFromNormal => Some(Criterion::pointing(Direction::Normal, PI, false)),
        }
    }

    /// Whether the runs that classify tell the value.
    pub(super) fn is_known(self) -> bool {
        self.watched().is_none()
    }

    /// Whether it can be measured under torque and damping.
    pub(super) fn can_be_forced(self) -> bool {
        self.quantity != Quantity::TiltFromStart
    }

    /// The value of a sample, from its classification and from its own run; NaN if it has none.
    pub(super) fn value(self, sample: &Sample, own: Option<&Outcome>, is_called: bool) -> f64 {
        match (self.quantity, own) {
            (Quantity::TimeToLeave, _) if sample.class == Class::Unstable => {
                let (left, again) = (sample.first.left, sample.second.filter(|again| again.was_run()));
                let agreed = again.is_none_or(|again| self.agree(left, again.left, sample.t_end));
                if agreed || !is_called { left } else { f64::NAN }
            }
            (Quantity::Drift, _) if sample.class != Class::Failed => {
                // `max` ignores a NaN.
                sample.first.energy_drift.max(sample.first.momentum_drift).max(sample.first.unit_drift)
            }
            (_, Some(own)) => self.of_run(own),
            _ => f64::NAN,
        }
    }

    /// The value of a run of its own; NaN if the run failed.
    fn of_run(self, own: &Outcome) -> f64 {
        match self.quantity {
            _ if own.class == Class::Failed => f64::NAN,
            Quantity::Flips => own.flips as f64,
            Quantity::MeanRate | Quantity::MeanRateOverMotion => own.mean_rate,
            _ => own.tilt,
        }
    }

    /// Whether two runs agree in a value: to a share of it, or of a radian, or of a radian in the whole time.
    fn agree(self, one: f64, other: f64, t_end: f64) -> bool {
        let least = match self.quantity {
            Quantity::TimeToLeave | Quantity::Drift | Quantity::Flips => 0.0,
            Quantity::MeanRate | Quantity::MeanRateOverMotion => 1.0 / t_end,
            _ => 1.0,
        };
        (one - other).abs() <= AGREED * one.abs().max(other.abs()).max(least)
    }
}

impl Map {
    /// The outcomes of the runs of the measures for a range of samples; an empty list for one that has no run. Under a
    /// function a run fails unless a second one agrees.
    pub(super) fn measured(
        &self,
        range: Range<u64>,
        isa: Isa,
        interrupt: &Interrupt,
    ) -> Result<Vec<Vec<Option<Outcome>>>, Error> {
        const MEASURES: &str = "measures of a block";
        let mut all = memory::reserved(MEASURES, self.measures.len())?;
        let mut samples = Vec::new();
        let mut bodies = Vec::new();
        for measure in &self.measures {
            let Some(criterion) = measure.watched() else {
                all.push(Vec::new());
                continue;
            };
            if bodies.is_empty() {
                bodies = self.draw(isa, range.clone())?;
                for (index, (pixel, _)) in self.pixels_and_samples(range.clone()).enumerate() {
                    if self.pixels[pixel as usize].possible {
                        memory::push(MEASURES, &mut samples, index)?;
                    }
                }
            }
            let mut outcomes = memory::filled(MEASURES, bodies.len(), None)?;
            let watched = Watched { map: self, criterion, axis: measure.axis, is_stopped: false };
            let run = Run { cross_check: false, isa, interrupt };
            watched.integrate((&bodies, range.start), &samples, run, &mut outcomes)?;
            if self.calls_functions() {
                let mut again = memory::filled(MEASURES, bodies.len(), None)?;
                let run = Run { cross_check: true, ..run };
                watched.integrate((&bodies, range.start), &samples, run, &mut again)?;
                let pairs = outcomes.iter_mut().flatten().zip(again.iter().flatten());
                for (own, again) in pairs {
                    own.steps += again.steps;
                    if !measure.agree(measure.of_run(own), measure.of_run(again), self.t_end) {
                        own.class = Class::Failed;
                    }
                }
            }
            all.push(outcomes);
        }
        Ok(all)
    }
}
