//! Events inside long steps: flips on the polynomial of `dop853`, tilts on that through values, slopes and bends.

use rigid::body::Body;
use rigid::exact::derived::{sign_changes, tilt_time, top_quantities};
use rigid::forces::BodyForces;
use rigid::kernel::Group;
use rigid::kernel::{Compiled, ForcesRows, Kernel, System};
use rigid::kernel::{Entry, KernelAssignment, load};
use rigid::method::DOP853;
use rigid::observe::{EXIT_TIME, Observed, Tilt};
use rigid::simd::Isa;

/// Angles of a step (rad) of the bound of the rates: as in trajectories, and up to those of maps.
const ANGLES: [f64; 3] = [0.1, 0.3, 0.75];

/// A body in a group without other bodies, in steps of this angle.
struct Run {
    group: Group,
    compiled: Compiled,
    step: f64,
}

impl Run {
    fn new(body: &Body, angle: f64, system: System, observed: Observed, axis: i32) -> Run {
        let kernel =
            Kernel { system, step: KernelAssignment::of(&DOP853, body, system.scene).step, observed };
        let compiled = Compiled::new(kernel, Isa::available()[0]);
        let mut group = Group::inactive();
        let step = angle / body.fastest_rate(BodyForces::NONE, [0.0; 2]);
        let entry = Entry { axis, ..Entry::unobserved(body, BodyForces::NONE, (0.0, None), None, step) };
        load(&mut group, 0, compiled, KernelAssignment::of(&DOP853, body, system.scene), &entry);
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

/// The first flip of a tumbling body. The polynomial errs by the eighth power of the step, the state as the seventh for each
/// radian; the rate of change there is at least a third of the fastest rate.
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
            for angle in ANGLES {
                let run = Run::new(&body, angle, System::FreeRates, Observed::Flips, axis).until(first + 1.0);
                let off = (run.exit_time() - first).abs();
                let bound = 1e-8 * angle.powi(8) + 3e-14;
                assert!(off < bound, "{angle}, axis {axis} of {omega:?}: {off:e} at {first}");
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
/// counts: `s^6 / 46080` in a step of s rad, and a rounding over the sine.
#[test]
fn the_largest_tilt_of_a_top() {
    for omega in [[0.3, 0.2, 4.0], [-0.5, 0.1, 5.5], [0.0, 0.0, 3.5]] {
        let body = top(omega);
        let quantities = top_quantities(Isa::available()[0], &body).unwrap();
        for angle in ANGLES {
            let tilt = Observed::Tilt(Tilt::within(f64::INFINITY));
            let run = Run::new(&body, angle, System::TopAxis, tilt, 3).until(1.2 * quantities.period);
            let off = (tilt.outcome(&run.group.observed_in(0)) - quantities.tilt[1]).abs();
            let bound = angle.powi(6) / 46080.0 + 1e-14;
            assert!(off < bound, "{angle} of {omega:?}: {off:e}");
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
            for angle in ANGLES {
                // A limit nearer to the turning point than the tilt errs may not be seen.
                let err = angle.powi(6) / 46080.0;
                if err > 0.1 * (high - limit) {
                    continue;
                }
                let tilt = Observed::Tilt(Tilt::within(limit));
                let run = Run::new(&body, angle, System::TopAxis, tilt, 3);
                let run = run.until(1.2 * quantities.period);
                let off = (run.exit_time() - expected).abs();
                let bound = (err + 1e-13) / (1.0 - part).sqrt();
                assert!(off < bound, "{angle} of {omega:?}, {part}: {off:e} of {bound:e} at {expected}");
            }
        }
    }
}
