//! What is observed of the samples of a map: how each is run for it, and what becomes of it.

use super::check::Runs;
use super::classify::ClosedFormClassifier;
use super::statistics::Sample;
use super::{Class, Criterion, Map, Outcome, regular};
use crate::body::Body;
use crate::call::Call;
use crate::error::Error;
use crate::forces::{BodyForces, ForceSet, Orbit, OrbitPlace};
use crate::kernel::{Kernel, KernelAssignment, Needs, System};
use crate::memory;
use crate::method::{Method, Step};
use crate::observe::{Observed, Tilt};
use std::ops::{Deref, Range};

/// What the lists of samples of a block are called if they do not fit into memory.
pub(super) const RUNS: &str = "runs of a block";

/// A sample that is integrated over the anomaly of its orbit.
#[derive(Clone, Copy)]
pub(super) struct OnOrbit {
    /// Where it begins.
    pub(super) place: OrbitPlace,
    /// The bound of its rates over the pace of the anomaly.
    pub(super) rate: f64,
    /// The pace by which a step of the time becomes one of the anomaly; see [`crate::forces::Orbit::pace`].
    pub(super) pace: f64,
}

impl OnOrbit {
    /// A body on an orbit in a range of times.
    pub(super) fn of(body: &Body, orbit: &Orbit<f64>, range: [f64; 2]) -> OnOrbit {
        let place = OrbitPlace::of(*orbit, orbit.anomaly_at(range[0]));
        let farthest = orbit.farthest(range);
        OnOrbit { place, rate: body.pace_rate(&place, farthest), pace: orbit.pace(farthest) }
    }
}

/// How samples are integrated.
#[derive(Clone, Copy)]
pub(super) struct Run<'a> {
    /// By the second method.
    pub(super) cross_check: bool,
    pub(super) call: Call<'a>,
}

/// A map with the one of its conditions that is observed.
#[derive(Clone, Copy)]
pub(super) struct Observation<'a> {
    pub(super) map: &'a Map,
    pub(super) criterion: Criterion,
    pub(super) axis: i32,
    /// Whether a run ends where it leaves stability.
    pub(super) is_stopped: bool,
}

impl Deref for Observation<'_> {
    type Target = Map;

    #[inline(always)]
    fn deref(&self) -> &Map {
        self.map
    }
}

impl Observation<'_> {
    /// Whether a sample under these forces is integrated over the anomaly of an orbit on which nothing else acts. Its bits do
    /// not depend on what acts on others.
    pub(super) fn is_on_orbit(&self, forces: BodyForces) -> bool {
        let has_steps = || KernelAssignment::on_orbit(self.map.method.by_steps()).is_some();
        self.criterion.rule().is_none() && forces.orbit_alone() && has_steps()
    }

    /// How a run of a sample is assigned to a kernel: over the anomaly of the orbit, if an orbit alone acts and its method has
    /// such steps.
    pub(super) fn assignment(&self, body: &Body, forces: BodyForces, cross_check: bool) -> KernelAssignment {
        let method = self.method(cross_check);
        let on_orbit = self.is_on_orbit(forces).then(|| KernelAssignment::on_orbit(method)).flatten();
        on_orbit.unwrap_or_else(|| KernelAssignment::of_either(self.is_forced(), method, body, self.scene))
    }

    /// The kernel of a sample under these forces with that step: its system carries what acts on the sample, what the
    /// criterion observes, and no more. The bits of a sample do not depend on what acts on others.
    pub(super) fn kernel(&self, step: Step, forces: BodyForces) -> Kernel {
        let needs = Needs {
            forces: ForceSet { act: self.is_forced(), ..ForceSet::from(forces) },
            directions: self.criterion.directions(self.scene),
            attitude: false,
            tangent: self.criterion.rule().is_some(),
            is_changed: false,
        };
        Kernel { system: System::carrying(self.scene, step, needs), step, observed: self.observed(step) }
    }

    /// The observable of the samples with that step. Over an anomaly the pointing is a tilt from the frame of the orbit.
    pub(super) fn observed(&self, step: Step) -> Observed {
        let tilt = self.criterion.bound().filter(|_| step.is_on_clock()).and_then(Tilt::of);
        tilt.map_or_else(|| self.criterion.observed(), Observed::Tilt)
    }

    /// The method of a run of a sample.
    pub(super) fn method(&self, cross_check: bool) -> &'static Method {
        let method = self.map.method.by_steps();
        match (cross_check, self.criterion.rule()) {
            (false, _) => method,
            (true, Some(_)) => regular::SECOND,
            // Few methods integrate the torque of a function: the same takes other steps.
            (true, None) if self.calls_functions() => method,
            (true, None) => method.second(self.is_forced()),
        }
    }

    /// The classification from both runs of a sample. A cross-check that would take too many steps has no effect.
    pub(super) fn classification(first: &Outcome, second: Option<&Outcome>) -> Class {
        match second.filter(|second| second.was_run()) {
            Some(second) => first.class.agreed(second.class),
            None => first.class,
        }
    }

    /// The samples of a range with their outcomes, and those of the groups of samples that the range touches.
    pub(super) fn classified(&self, range: Range<u64>, call: Call) -> Result<Classified, Error> {
        let range = self.with_groups(range);
        let bodies = self.draw(call.isa, range.clone())?;
        let unknown = || memory::filled("outcomes of a block", bodies.len(), None::<Outcome>);
        let mut outcomes = [unknown()?, Vec::new()];
        let mut classifier = ClosedFormClassifier::new(*self, call.isa);
        let mut integrated = Vec::new();
        for (index, (pixel, _)) in self.pixels_and_samples(range.clone()).enumerate() {
            if !self.pixels[pixel as usize].possible {
                continue;
            }
            let exact = !self.is_forced()
                && self.method.exact()
                && classifier.take(index, &bodies[index], &mut outcomes[0]);
            if !exact {
                memory::push(RUNS, &mut integrated, index)?;
            }
        }
        classifier.finish(&mut outcomes[0]);
        let mut audited = Vec::new();
        if !integrated.is_empty() {
            let [first, second] = &mut outcomes;
            *second = unknown()?;
            let (starts, run) = ((&bodies[..], range.start), Run { cross_check: false, call });
            self.integrate(starts, &integrated, run, first)?;
            let runs =
                Runs { range: range.clone(), bodies: &bodies, integrated: &integrated, outcomes: first };
            let again = Run { cross_check: true, ..run };
            audited = self.audited(&runs)?;
            self.integrate(starts, &audited, again, second)?;
            let doubtful = self.doubtful(&runs, second)?;
            self.integrate(starts, &doubtful, again, second)?;
        }
        Ok(Classified { range, outcomes, audited })
    }
}

/// Samples with their outcomes.
pub(super) struct Classified {
    pub(super) range: Range<u64>,
    /// By the method of the map, and by the second method; none where a pixel has no body or a sample no second run.
    /// The second list is empty if no sample was integrated.
    outcomes: [Vec<Option<Outcome>>; 2],
    /// Samples with a second run whatever their first, ascending.
    audited: Vec<usize>,
}

impl Classified {
    /// A sample as the statistics see it; `None` where the pixel has no body.
    #[inline(always)]
    pub(super) fn sample(&self, index: usize, t_end: f64) -> Option<Sample<'_>> {
        let first = self.outcomes[0][index].as_ref()?;
        let second = self.outcomes[1].get(index).and_then(Option::as_ref);
        let audited = self.audited.binary_search(&index).is_ok();
        Some(Sample { class: Observation::classification(first, second), first, second, audited, t_end })
    }
}
