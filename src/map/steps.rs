//! The steps of the runs of samples, and those that are planned.

use super::{Observation, OnOrbit, regular};
use crate::body::Body;
use crate::forces::BodyForces;
use crate::kernel::KernelAssignment;
use crate::method::{self, AnyMethod, Method, default_step};

impl AnyMethod {
    /// Whether closed forms classify samples of a map.
    pub(super) fn exact(self) -> bool {
        !matches!(self, AnyMethod::Steps(_))
    }

    /// The method of the samples that have no closed form.
    pub fn by_steps(self) -> &'static Method {
        match self {
            AnyMethod::Steps(method) => method,
            AnyMethod::Auto | AnyMethod::Exact => &method::DOP853,
        }
    }

    /// The longest step at a rate. By default it is 0.75 rad of the bound of the rates: its error is about 1e-10 rad per radian
    /// turned in the median, seldom above 1e-8, and the check knows it. Whether a motion is chaotic does not depend
    /// on its digits: the steps in which deviation vectors grow are a radian and a quarter.
    pub fn default_step(self, of_growth: bool, rate: f64) -> f64 {
        let longer = match self {
            AnyMethod::Exact | AnyMethod::Steps(_) => 1.0,
            AnyMethod::Auto if of_growth => GROWTH_STEPS,
            AnyMethod::Auto => MOTION_STEPS,
        };
        longer * default_step(self.by_steps(), rate)
    }

    /// The longest step of a run in a range of times, and the time in which equal steps of that length are as many as those
    /// of the run: another than that of the run where the steps are equal over the anomaly of an orbit.
    pub fn planned_step(self, of: PlannedRun, body: &Body, forces: BodyForces, range: [f64; 2]) -> [f64; 2] {
        let method = self.by_steps();
        let is_on_clock =
            of != PlannedRun::Growth && forces.orbit_alone() && KernelAssignment::on_orbit(method).is_some();
        let (mut rate, mut time) = (None, range[1] - range[0]);
        if is_on_clock {
            let on_orbit = OnOrbit::of(body, &forces.further.orbit, range);
            time = on_orbit.place.anomaly_until(time) / on_orbit.pace;
            if of == PlannedRun::Sample {
                rate = Some(on_orbit.rate * on_orbit.pace);
            }
        }
        let rate = rate.unwrap_or_else(|| match of {
            PlannedRun::Sample | PlannedRun::Growth if forces.is_none() => body.neighbours_rate(),
            _ => body.step_rate(method, forces, range),
        });
        let step = self.default_step(of == PlannedRun::Growth, rate).min(forces.longest_unseen(range));
        [step, time]
    }
}

/// What a planned run is for: each has its rule for the longest step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlannedRun {
    /// States at output times.
    States,
    /// The class of a sample of a map.
    Sample,
    /// The growth of a deviation vector of a sample.
    Growth,
}

/// Steps of the default method, over those for states.
const MOTION_STEPS: f64 = 7.5;

/// The same for the growth of deviation vectors.
const GROWTH_STEPS: f64 = 12.5;

/// Steps of the run that checks a sample, over those of its first run, both by the default method: its errors are six times
/// as large, so that both runs err alike by chance only, and it costs less.
const SECOND_SHARE: f64 = 0.8;

impl Observation<'_> {
    /// Number of steps of a run of a sample over a time, or over the anomaly from a place: whole blocks, no step longer than
    /// the map allows; above `max_steps` if the rates need that many. A cross-check takes steps of its own: those of the
    /// default method are longer than in the first run, or as long where the map takes another method. It makes at most half
    /// the step that was asked for or, unless it is of regularity, that the same method makes in the first run.
    pub(super) fn steps_of(
        &self,
        body: &Body,
        forces: BodyForces,
        cross_check: bool,
        (on_orbit, span): (Option<OnOrbit>, f64),
    ) -> u64 {
        let method = self.method(cross_check);
        let (is_ruled, is_auto) = (self.criterion.rule().is_some(), self.map.method == AnyMethod::Auto);
        let is_alike = method == self.method(false);
        let pace = on_orbit.map_or(1.0, |on_orbit| on_orbit.pace);
        let rate = match on_orbit {
            Some(on_orbit) => on_orbit.rate,
            None if forces.is_none() => body.neighbours_rate(),
            None => body.step_rate(method, forces, [0.0, self.t_end]),
        };
        let own = match (cross_check, is_ruled) {
            (true, true) => regular::second_step(rate, self.t_end),
            (true, false) if is_auto => self.map.method.default_step(is_ruled, rate) / SECOND_SHARE,
            (true, false) if method == method::SECOND && !is_alike => {
                AnyMethod::Auto.default_step(is_ruled, rate)
            }
            (true, false) => default_step(method, rate),
            _ => self.map.method.default_step(is_ruled, rate),
        };
        let own = own.min(forces.longest_unseen([0.0, self.t_end]));
        let largest = match self.step {
            Some(step) if cross_check => own.min(0.5 * step * pace),
            Some(step) => step * pace,
            None if cross_check && !is_ruled && !is_auto && is_alike => 0.5 * own,
            None => own,
        };
        let [multiple, fewest] = self.whole_steps(cross_check);
        let blocks = (span / largest / multiple as f64).ceil();
        // A NaN or an absurd number becomes one that no limit allows.
        if !(blocks < 1e17) {
            return u64::MAX;
        }
        let steps = (blocks as u64 * multiple).max(fewest);
        let is_same = || steps == self.steps_of(body, forces, false, (on_orbit, span));
        // Equal steps would be the same run.
        if cross_check && is_auto && !is_ruled && is_same() { steps + multiple } else { steps }
    }
}
