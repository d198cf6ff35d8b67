//! What is asked of a map: the pixels and their samples, the criterion and the method.

use super::check::GROUP;
use super::{Check, Condition, Criterion, Distributions, Logic, Measure, Mixed};
use crate::body::Body;
use crate::error::{Error, refuse};
use crate::exact::Question;
use crate::forces::{BodyForces, ForceSet, Forces};
use crate::kernel::System;
use crate::method::{AnyMethod, Step};
use crate::scene::Scene;

/// The nominal body of a pixel and the size of the perturbations of its samples.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    /// Body and nominal start.
    pub body: Body,
    /// Size of the perturbation of each rate.
    pub omega_size: [f64; 3],
    /// Sizes of the components of the perturbation of the attitude (rad).
    pub attitude_size: [f64; 3],
    /// Whether such a body exists.
    pub possible: bool,
}

/// Everything that the statistics of a map depend on.
#[derive(Clone, Debug)]
pub struct Map {
    /// What moves the bodies.
    pub scene: &'static Scene,
    /// The forces on the pixels, or those on all; none if nothing acts.
    pub forces: Option<Forces>,
    /// How the samples are classified.
    pub method: AnyMethod,
    /// The pixels.
    pub pixels: Vec<Pixel>,
    /// Distributions of the perturbations.
    pub distributions: Distributions,
    /// The starts of a mixture, of which each sample takes one instead of that of its pixel; empty for none.
    pub mixture: Vec<Mixed>,
    /// The conditions that are observed.
    pub conditions: Vec<Condition>,
    /// When a sample is stable, from its conditions.
    pub logic: Logic,
    /// What is measured of each sample.
    pub measures: Vec<Measure>,
    /// Horizon.
    pub t_end: f64,
    /// Largest step; `None` leaves it to the bound of each sample's rates.
    pub step: Option<f64>,
    /// Most steps that a sample may take.
    pub max_steps: u64,
    /// Samples of each pixel.
    pub samples: u64,
    /// Which of them are classified again by the second method.
    pub check: Check,
    /// Key of the random numbers.
    pub key: [u64; 2],
    /// The number of each pixel in the map that these are part of; empty: its place.
    pub numbers: Vec<u64>,
    /// The number of the first sample of each pixel in that map: whole groups of audits precede it; empty: 0.
    pub first: Vec<u64>,
}

impl Map {
    /// The map, if it can be computed.
    ///
    /// # Errors
    /// Naming the argument.
    pub fn checked(self) -> Result<Map, Error> {
        for Condition { criterion, axis } in &self.conditions {
            let least = u32::from(criterion.has_axis());
            if !(least..=3).contains(&axis.unsigned_abs()) {
                return refuse("axis", axis, "must be 1, 2, 3 or -1, -2, -3");
            }
        }
        if self.samples == 0 {
            return refuse("samples", self.samples, "must be at least 1");
        }
        let all = (self.pixels.len() as u64).checked_mul(self.samples);
        if all.is_none_or(|all| all >= 1 << 63) {
            let value = format!("{} in each of {} pixels", self.samples, self.pixels.len());
            return refuse("samples", value, "a map must have fewer than 2**63");
        }
        // A sample alone is its own group.
        let begins_group = |first: u64| self.samples == 1 || first.is_multiple_of(GROUP);
        if let Some(first) = self.first.iter().find(|first| !begins_group(**first) || **first >= 1 << 63) {
            return refuse("first", first, "must be a multiple of 64 below 2**63");
        }
        let all_distributions =
            self.mixture.iter().map(|mixed| &mixed.distributions).chain([&self.distributions]);
        for given in all_distributions.filter_map(|distributions| distributions.empirical.as_ref()) {
            let rule = "must not be empty, and shares must end at 1";
            if given.omega.is_empty() || given.cumulative.last().is_some_and(|&last| last < 1.0) {
                return refuse("given_omega", given.omega.len(), rule);
            }
        }
        if let Some(last) = self.mixture.last() {
            let is_whole = self.mixture.iter().all(|mixed| mixed.pixels.len() == self.pixels.len());
            if !(is_whole && last.until >= 1.0) {
                let rule = "must have a start in each pixel, and shares must end at 1";
                return refuse("mixture", self.mixture.len(), rule);
            }
        }
        if !(self.t_end.is_finite() && self.t_end > 0.0) {
            return refuse("t_end", self.t_end, "must be positive and finite");
        }
        let is_exact = self.method == AnyMethod::Exact;
        if is_exact && !self.measures.iter().all(|measure| measure.is_known()) {
            let rule = "measures are taken along steps";
            return refuse("method", format_args!("'{}'", AnyMethod::EXACT), rule);
        }
        for observation in self.observations().filter(|_| !is_exact) {
            let method = self.method.by_steps();
            method.check(self.scene)?;
            if observation.criterion.rule().is_none() {
                method.check_observed()?;
            } else {
                method.check_tangent(self.is_forced())?;
                self.forces().check_deviations()?;
            }
            let steps = [method.any, method.symmetric].map(Step::torque_free);
            let is_framed = observation.criterion.directions(self.scene) > 1 && !self.scene.has_weight;
            let moves_frame =
                |&step: &Step| System::TopTwoAxes.is_moved_by(step) || System::TopTurns.is_moved_by(step);
            if is_framed && !self.is_forced() && !steps.iter().all(moves_frame) {
                let rule = "integrates no frame with a free body, which this criterion needs";
                return method.refuse(rule);
            }
        }
        let of_measures = self.measures.iter().filter_map(|measure| measure.observed);
        if of_measures.count() > 0 {
            self.method.by_steps().check_observed()?;
        }
        if let Some(forces) = &self.forces {
            if forces.bodies() > 1 && forces.bodies() != self.pixels.len() {
                let rule = "must be of one body, or of each pixel";
                return refuse("forces", format_args!("of {} bodies", forces.bodies()), rule);
            }
            self.check_forced()?;
        }
        match self.first_without_closed_form().filter(|_| is_exact) {
            Some(pixel) => Err(Error::NoClosedClassification { pixel, rule: Question::RULE_OF_CLASSES }),
            None => Ok(self),
        }
    }

    /// The first pixel with a possible body that is not classified in closed form.
    fn first_without_closed_form(&self) -> Option<usize> {
        let answers =
            |body| self.observations().all(|observation| super::classify::answers(observation, body));
        self.pixels.iter().position(|pixel| pixel.possible && !answers(&pixel.body))
    }

    /// Whether torque or damping is applied.
    #[inline]
    pub(super) fn is_forced(&self) -> bool {
        self.forces.is_some()
    }

    /// Whether functions of the user act on the samples: on all or none.
    pub fn calls_functions(&self) -> bool {
        self.forces.as_ref().is_some_and(|forces| forces.function().is_some())
    }

    /// How many numbers a function is given for each body.
    pub(super) fn function_width(&self) -> usize {
        self.forces.as_ref().map_or(0, Forces::function_width)
    }

    /// Whether the samples are under tables over time.
    pub(super) fn has_knots(&self) -> bool {
        self.forces.as_ref().is_some_and(|forces| forces.of(0).table.has_knots())
    }

    /// The forces on any of the samples.
    pub(super) fn forces(&self) -> ForceSet {
        let Some(forces) = &self.forces else { return ForceSet::NONE };
        let all = (0..forces.bodies()).map(|body| ForceSet::from(forces.of(body)));
        ForceSet { act: true, ..all.fold(ForceSet::NONE, ForceSet::and) }
    }

    /// The forces on a pixel.
    pub(super) fn forces_of(&self, pixel: u64) -> BodyForces<'_> {
        self.forces.as_ref().map_or(BodyForces::NONE, |forces| forces.of(pixel as usize))
    }

    /// Refuses forces that a criterion or the method cannot handle.
    fn check_forced(&self) -> Result<(), Error> {
        let method = self.method.by_steps();
        if self.method == AnyMethod::Exact {
            let rule = "no classification in closed form is known under torque and damping";
            return refuse("method", format_args!("'{}'", AnyMethod::EXACT), rule);
        }
        method.forced_limit()?;
        method.check_forces(self.forces())?;
        let is_from_start =
            self.conditions.iter().any(|one| matches!(one.criterion, Criterion::TiltFromStart(_)))
                || !self.measures.iter().all(|measure| measure.can_be_forced());
        if is_from_start {
            let rule = "under torque and damping only the tilt from the vertical is watched";
            return refuse("reference", "'start'", rule);
        }
        let table = self.forces_of(0).table;
        table.check_reaches(0.0)?;
        table.check_reaches(self.t_end)?;
        if self.has_knots() && self.conditions.iter().any(|one| one.criterion.rule().is_some()) {
            let rule = "deviation vectors of a map are not integrated under a table over time";
            return refuse("stable", "regular()", rule);
        }
        for (pixel, number) in self.pixels.iter().zip(0..).filter(|(pixel, _)| pixel.possible) {
            let damping = self.forces_of(number).damping;
            damping.check_rates(pixel.body.moments)?;
            if let Some(step) = self.step {
                let [.., rate] = damping.rates(pixel.body.moments);
                method.check_damping(None, step, rate)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::FREE;

    fn map() -> Map {
        Map {
            scene: &FREE,
            forces: None,
            method: AnyMethod::Auto,
            pixels: Vec::new(),
            distributions: Distributions::NONE,
            mixture: Vec::new(),
            conditions: vec![Condition { criterion: Criterion::NoFlip, axis: 2 }],
            logic: Logic::parse("0", 1).unwrap(),
            measures: Vec::new(),
            t_end: 1.0,
            step: None,
            max_steps: 100,
            samples: 1,
            check: Check::Before(0),
            key: [0; 2],
            numbers: Vec::new(),
            first: Vec::new(),
        }
    }

    #[test]
    fn a_map_that_cannot_be_computed_is_refused() {
        assert!(map().checked().is_ok());
        let refused = [
            (
                Map { conditions: vec![Condition { criterion: Criterion::NoFlip, axis: 0 }], ..map() },
                "axis = 0",
            ),
            (Map { samples: 0, ..map() }, "samples = 0"),
            (Map { samples: 64, first: vec![0, 32], ..map() }, "first = 32"),
            (
                Map {
                    mixture: vec![Mixed {
                        until: 0.5,
                        distributions: Distributions::NONE,
                        pixels: Vec::new(),
                    }],
                    ..map()
                },
                "mixture = 1",
            ),
            (Map { samples: 64, first: vec![1 << 63], ..map() }, "first = 9223372036854775808"),
            (Map { t_end: f64::NAN, ..map() }, "t_end = NaN"),
            (Map { t_end: -1.0, ..map() }, "t_end = -1"),
        ];
        for (map, words) in refused {
            let message = map.checked().unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}");
        }
    }
}
