//! Events inside the steps of a Taylor series, located on the polynomial of the step with the
//! accuracy of the states.

use rigid::exact::derived::{sign_changes, tilt_time, top_quantities};
use rigid::forces::{BodyForces, Further};
use rigid::kernel::Group;
use rigid::kernel::{Compiled, ForcesRows, Kernel, System};
use rigid::kernel::{Entry, KernelAssignment, load};
use rigid::method::{self, Method};
use rigid::observe::{Deviation, EXIT_TIME, Observed, Tilt, largest_tilt};
use rigid::simd::Isa;
use rigid::start::Body;

fn series() -> impl Iterator<Item = &'static Method> {
    method::ALL.iter().copied().filter(|method| method.is_series())
}

/// A body in a group without other bodies, with the longest steps that keep the attitude to 4e-14 a radian
/// (`angle_per_step`).
struct Run {
    group: Group,
    compiled: Compiled,
    step: f64,
}

impl Run {
    fn new(
        body: &Body,
        method: &'static Method,
        system: System,
        observed: Observed,
        (axis, limit): (i32, f64),
    ) -> Run {
        let kernel =
            Kernel { system, step: KernelAssignment::of(method, body, system.scene()).step, observed };
        let compiled = Compiled::new(kernel, Isa::available()[0]);
        let mut group = Group::inactive();
        let step = method.facts.angle_per_step / body.fastest_rate(BodyForces::NONE, [0.0; 2]);
        let entry = Entry {
            place: None,
            body,
            forces: None,
            axis,
            limit,
            step,
            own: Further::NONE.start(0.0),
            deviation: Deviation::NONE,
            bound: None,
        };
        load(&mut group, 0, compiled, KernelAssignment::of(method, body, system.scene()), &entry);
        Run { group, compiled, step }
    }

    fn until(mut self, time: f64) -> Run {
        self.compiled.advance(&mut self.group, &ForcesRows::NONE, (time / self.step).ceil() as usize);
        self
    }

    fn exit_time(&self) -> f64 {
        self.group.observed[EXIT_TIME].0[0]
    }
}

/// The first flip of a tumbling body. The error of the rates is 4e-14 of the fastest rate per radian turned. The body
/// turns by about 15 radians before the flip, at which the rate of change is at least a third of the fastest rate.
#[test]
fn the_flip_of_a_tumbler() {
    let isa = Isa::available()[0];
    for omega in [[0.05, 1.0, 0.1], [0.3, 1.2, -0.4], [0.8, -0.9, 0.2]] {
        let body = Body { moments: [1.0, 1.6, 2.0], weight: [0.0; 3], omega, attitude: [1.0, 0.0, 0.0, 0.0] };
        for axis in 1..=3 {
            let [first, _] = sign_changes(isa, &body, axis as usize - 1).unwrap();
            if first == f64::INFINITY {
                continue;
            }
            for method in series() {
                let run = Run::new(&body, method, System::FreeRates, Observed::Flips, (axis, f64::INFINITY))
                    .until(first + 1.0);
                let off = (run.exit_time() - first).abs();
                assert!(off < 3.0 * 4e-14 * 15.0, "{method:?}, axis {axis} of {omega:?}: {off:e} at {first}");
            }
        }
    }
}

/// A top that nutates between two tilts in a few steps.
fn top(omega: [f64; 3]) -> Body {
    let (sin, cos) = rigid::special::sincos(0.2);
    Body { moments: [1.0, 1.0, 0.6], weight: [0.0, 0.0, 1.5], omega, attitude: [cos, sin, 0.0, 0.0] }
}

/// The largest tilt lies inside a step. The derivative of the tilt vanishes there, so only the error of the tilt
/// counts: 4e-14 per radian of the ten or so radians in a period, and the error of an arc cosine at 1e-16.
#[test]
fn the_largest_tilt_of_a_top() {
    for omega in [[0.3, 0.2, 4.0], [-0.5, 0.1, 5.5], [0.0, 0.0, 3.5]] {
        let body = top(omega);
        let quantities = top_quantities(Isa::available()[0], &body).unwrap();
        for method in series() {
            let run = Run::new(&body, method, System::TopAxis, Observed::Tilt, (3, f64::INFINITY))
                .until(1.2 * quantities.period);
            let observed_tilt =
                largest_tilt(run.group.observed[Tilt::COSINE].0[0], run.group.observed[Tilt::SINE2].0[0]);
            let off = (observed_tilt - quantities.tilt[1]).abs();
            assert!(off < 1e-12, "{method:?} of {omega:?}: {off:e}");
        }
    }
}

/// The limit of the tilt is reached at the time of the closed form, also if the top stays beyond the limit for less
/// than a step. The error of the time is the error of the tilt over its slope, which vanishes like a root at the
/// turning point.
#[test]
fn the_limit_of_the_tilt_of_a_top() {
    let isa = Isa::available()[0];
    for omega in [[0.3, 0.2, 4.0], [-0.5, 0.1, 5.5], [0.0, 0.0, 3.5]] {
        let body = top(omega);
        let quantities = top_quantities(isa, &body).unwrap();
        let [low, high] = quantities.tilt;
        for part in [0.9_f64, 0.99, 0.9999, 0.999_999] {
            let limit = low + part * (high - low);
            let expected = tilt_time(isa, &body, limit).unwrap();
            for method in series() {
                let run = Run::new(&body, method, System::TopAxis, Observed::Tilt, (3, limit));
                let run = run.until(1.2 * quantities.period);
                let off = (run.exit_time() - expected).abs();
                let bound = 1e-12 / (1.0 - part).sqrt();
                assert!(off < bound, "{method:?} of {omega:?}, {part}: {off:e} of {bound:e} at {expected}");
            }
        }
    }
}
