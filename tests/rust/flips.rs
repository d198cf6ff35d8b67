//! Flips: sign changes of a component of the rates, counted once each and located inside the step.

use crate::tests::scene_of;
use rigid::body::Body;
use rigid::forces::{BodyForces, ForcesInterval};
use rigid::kernel::Group;
use rigid::kernel::{Compiled, ForcesRows, Kernel, System};
use rigid::kernel::{Entry, KernelAssignment, load};
use rigid::method::{self, Coefficients, Engine, Method, Numbers, Rk4Tableau, RungeKutta};
use rigid::observe::{EXIT_TIME, Flips, MAX_ROWS, Observed, Rows, Segment, Update};
use rigid::scene::FREE;
use rigid::scene::{Free, Parameters, Rates};
use rigid::simd::Isa;
use rigid::simd::LANES;

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn free(moments: [f64; 3], omega: [f64; 3]) -> Body {
    Body { moments, weight: [0.0; 3], omega, attitude: UPRIGHT }
}

/// The methods that a map can use.
fn methods_of_maps(is_top: bool) -> impl Iterator<Item = &'static Method> {
    method::ALL
        .iter()
        .copied()
        .filter(move |method| method.check(scene_of(is_top)).is_ok() && method.check_observed().is_ok())
}

/// One observed body in a group without other bodies.
struct ObservedBody {
    group: Group,
    compiled: Compiled,
}

impl ObservedBody {
    fn new(body: &Body, method: &'static Method, axis: i32, step: f64) -> ObservedBody {
        let is_top = body.weight != [0.0; 3];
        let assignment = KernelAssignment::of(method, body, scene_of(is_top));
        let system = if is_top { System::TopAxis } else { System::FreeRates };
        let kernel = Kernel { system, step: assignment.step, observed: Observed::Flips };
        let compiled = Compiled::new(kernel, Isa::available()[0]);
        let mut group = Group::inactive();
        let entry = Entry { axis, ..Entry::unobserved(body, BodyForces::NONE, (0.0, None), None, step) };
        load(&mut group, 0, compiled, assignment, &entry);
        ObservedBody { group, compiled }
    }

    fn after(mut self, steps: usize) -> ObservedBody {
        self.compiled.advance(&mut self.group, &ForcesRows::NONE, steps);
        self
    }

    fn flips(&self) -> f64 {
        self.group.observed[Flips::COUNT].0[0]
    }

    /// The observed component, as a rate or a momentum.
    fn component(&self) -> f64 {
        (0..3).map(|k| self.group.observed[Flips::AXIS + k].0[0] * self.group.state[k].0[0]).sum()
    }

    fn first(&self) -> f64 {
        self.group.observed[EXIT_TIME].0[0]
    }
}

// --- Times of flips --------------------------------------------------------------------------------------------

/// Tumbling about the middle axis: the component along this axis changes sign about every 14 units of time. Closer to
/// the separatrix rounding would change the time of a flip too much.
fn tumbler() -> Body {
    free([1.0, 1.6, 2.0], [0.05, 1.0, 0.1])
}

/// A top that swings and spins.
fn swinger() -> Body {
    Body {
        moments: [1.0, 1.6, 0.7],
        weight: [0.2, -0.1, 0.5],
        omega: [0.7, 0.9, 1.5],
        attitude: [0.8, 0.4, -0.4, 0.2],
    }
}

/// Time of the `nth` flip; the counter is reset before each step.
fn time_of_flip(body: &Body, method: &'static Method, axis: i32, step: f64, nth: f64) -> f64 {
    let mut run = ObservedBody::new(body, method, axis, step);
    while run.flips() < nth {
        assert!(run.group.count.0[0] * step < 200.0, "no such flip");
        run.group.observed[EXIT_TIME].0[0] = f64::INFINITY;
        let flips = run.flips();
        run.group.observed[Flips::COUNT].0[0] = 0.0;
        run = run.after(1);
        run.group.observed[Flips::COUNT].0[0] += flips;
    }
    run.first()
}

/// Half the step has an error of the flip time 2^order times smaller. The cubic inside the step is of order 4, as good
/// as a method of order 4; its error depends on the position of the zero in the step, and is small compared with the
/// error of a run of ten units of time or more. The ratio differs from 2^order by the effect of the next power of h: h
/// times a rate of 1 to 3, 0.05 to 0.15, and half of that with half the step. (Flips with a vanishing leading error
/// were omitted.)
#[test]
fn the_time_of_a_flip_has_the_order_of_the_method() {
    let cases = [
        (tumbler(), 2, 1.0),
        (tumbler(), -2, 3.0),
        (swinger(), 2, 1.0),
        (swinger(), 1, 4.0),
        (swinger(), -2, 2.0),
    ];
    for (body, axis, nth) in cases {
        // The reference is RK4 with a step 16 times smaller than the finest step, which has 16^-4 of its error.
        let exact = time_of_flip(&body, &method::RK4, axis, 0.05 / 64.0, nth);
        // The errors of other methods are smaller than that of the cubic.
        for method in [&method::RK4, &method::SPLITTING] {
            let error = |h: f64| (time_of_flip(&body, method, axis, h, nth) - exact).abs();
            let errors = [0.05, 0.025, 0.0125].map(error);
            let expected = 2.0_f64.powi(method.facts.order as i32);
            let deviations =
                [errors[0] / errors[1], errors[1] / errors[2]].map(|ratio| (ratio / expected - 1.0).abs());
            println!("{method:?}, flip {nth} at {exact}: errors {errors:?}, ratios off by {deviations:?}");
            assert!(
                deviations[0] < 0.15 && deviations[1] < 0.075,
                "{method:?}, flip {nth}: {errors:?}, {deviations:?}"
            );
            // The error is less than a coarse step, and more than rounding.
            assert!(errors[0] < 0.15 && errors[2] > 1e-11, "{errors:?}");
        }
    }
}

/// A flip lies inside the step in which the sign changed.
#[test]
fn a_flip_lies_inside_its_step() {
    for method in methods_of_maps(false) {
        for step in [0.3, 0.1, 0.01] {
            let mut run = ObservedBody::new(&tumbler(), method, 2, step);
            while run.flips() == 0.0 {
                assert!(run.group.count.0[0] * step < 20.0, "no flip");
                run = run.after(1);
            }
            let steps = run.group.count.0[0];
            assert!((steps - 1.0) * step <= run.first() && run.first() <= steps * step, "{method:?} {step}");
        }
    }
}

// --- Numbers of flips ------------------------------------------------------------------------------------------

/// In the middle of a run, at the border of two steps, the component is exactly zero; it was +1 or -1 before.
#[test]
fn a_flip_on_the_border_of_two_steps() {
    for method in methods_of_maps(false) {
        let body = free([1.0, 1.6, 2.0], [0.8, 0.0, 0.7]);
        // w2' = (I3 - I1) w3 w1 / I2 > 0: the component becomes positive.
        for (came_from, flips) in [(-1.0, 1.0), (1.0, 0.0)] {
            for axis in [2, -2] {
                let mut run = ObservedBody::new(&body, method, axis, 0.125);
                run.group.count.0[0] = 40.0;
                run.group.observed[Flips::SIGN].0[0] = f64::from(axis.signum()) * came_from;
                let run = run.after(1);
                assert_eq!(run.flips(), flips, "{method:?} from {came_from}");
                // At the border itself, 40 steps of 1/8.
                if flips > 0.0 {
                    assert_eq!(run.first(), 5.0);
                }
                let later = run.after(5);
                assert_eq!(later.flips(), flips, "{method:?} from {came_from}: counted again");
            }
        }
    }
}

/// The classical method for one body, step 1/2, observed along axis 2, positive at the start.
type Classical = RungeKutta<Rk4Tableau, f64, Free<f64>>;
const BODY: Parameters<f64> = Parameters { moments: [1.0, 1.6, 2.0], weight: [0.0; 3], step: 0.5 };
const POSITIVE: Rows<f64> = {
    let mut rows = [0.0; MAX_ROWS];
    rows[EXIT_TIME] = f64::INFINITY;
    rows[Flips::SIGN] = 1.0;
    rows[Flips::AXIS + 1] = 1.0;
    rows
};

/// Gives the observable a step between any two states.
fn observe_step(rows: &mut Rows<f64>, begin: f64, before: [f64; 3], after: [f64; 3]) {
    let engine =
        <Classical as Engine<f64, Free<f64>, Rates, 3>>::new(&BODY, &ForcesInterval::none(), &Numbers::NONE);
    let nothing = Coefficients::new();
    let (before, after, dense) = (&before, &after, &nothing);
    let segment = Segment { engine: &engine, p: &BODY, begin, before, after, dense };
    <Flips as Update<f64, Free<f64>, Rates, 3>>::after_step(Flips, rows, &segment);
}

/// A step that ends exactly at zero has not yet flipped, whatever the sign of the zero.
#[test]
fn ending_on_zero_is_not_yet_a_flip() {
    for zero in [0.0, -0.0] {
        for (goes_on, flips) in [(0.01, 0.0), (-0.01, 1.0)] {
            let mut rows = POSITIVE;
            observe_step(&mut rows, 2.0, [-0.3, 0.1, 0.5], [-0.3, zero, 0.5]);
            assert_eq!((rows[Flips::COUNT], rows[Flips::SIGN]), (0.0, 1.0));
            observe_step(&mut rows, 2.5, [-0.3, zero, 0.5], [-0.3, goes_on, 0.5]);
            assert_eq!(rows[Flips::COUNT], flips);
            assert_eq!(rows[Flips::SIGN], if flips > 0.0 { -1.0 } else { 1.0 });
            assert_eq!(rows[EXIT_TIME], if flips > 0.0 { 2.5 } else { f64::INFINITY });
        }
    }
}

/// The time is the root of the cubic through both ends with both slopes, to rounding: values of size one, slope
/// above 0.3, a dozen roundings of eps/2, step 1/2.
#[test]
fn the_root_of_the_cubic() {
    for (before, after) in [
        ([-0.3, 0.1, 0.5], [-0.9, -0.4, 0.8]),
        ([-0.3, 0.4, 0.5], [-1.5, -0.3, 0.9]),
        ([-1.6, 0.3, 1.0], [-0.1, -0.2, 0.3]),
    ] {
        let mut rows = POSITIVE;
        observe_step(&mut rows, 0.0, before, after);
        // w2' = (I3 - I1) w3 w1 / I2, times the step.
        let slope = |w: [f64; 3]| 0.5 * (2.0 - 1.0) / 1.6 * w[2] * w[0];
        // Hermite's basis.
        let cubic = |s: f64| {
            let r = 1.0 - s;
            (1.0 + 2.0 * s) * r * r * before[1]
                + s * r * r * slope(before)
                + s * s * (3.0 - 2.0 * s) * after[1]
                - s * s * r * slope(after)
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            (low, high) = if cubic(middle) > 0.0 { (middle, high) } else { (low, middle) };
        }
        let miss = (rows[EXIT_TIME] - 0.5 * low).abs();
        assert!(miss <= 0.5 * 6.0 * f64::EPSILON / 0.3, "{before:?} {after:?}: {miss:e}");
        // A straight line through the ends would give another time.
        assert!((before[1] / (before[1] - after[1]) - low).abs() > 0.01);
    }
}

/// A component that starts at zero has the sign that it takes just after the start, so there is no flip at t = 0. The
/// component grows like t, t^2 or t^3. A method of order p has an error of h^(p+1) in its first step, so it resolves
/// powers up to p only.
#[test]
fn starting_on_zero_is_no_flip() {
    let top = |moments, weight, omega, attitude| Body { moments, weight, omega, attitude };
    let mut cases = Vec::new();
    for sign in [1.0, -1.0] {
        // Gyroscopic torque, about each axis, with or without weight.
        cases.push((1, free([1.0, 1.6, 2.0], [0.0, sign, 0.4]), 1));
        cases.push((1, free([1.0, 1.6, 2.0], [sign, 0.0, 0.4]), 2));
        cases.push((1, free([1.0, 1.6, 2.0], [sign, 0.4, 0.0]), 3));
        cases.push((
            1,
            top([1.0, 1.6, 0.7], [0.0, 0.0, 0.5], [0.1, 0.2 * sign, 0.0], [0.0, 1.0, 0.0, 0.0]),
            3,
        ));
        // Weight of an upright top with its centre of mass beside the vertical.
        cases.push((1, top([1.0, 1.6, 0.7], [0.0, 0.5 * sign, 0.2], [0.0, 0.0, 0.3], UPRIGHT), 1));
        cases.push((1, top([1.0, 1.6, 0.7], [0.5 * sign, 0.0, 0.2], [0.0, 0.0, 0.3], UPRIGHT), 2));
        // Weight after the spin has turned the body a little: weight torque and gyroscopic torque begin at zero.
        cases.push((
            2,
            top([1.0, 1.6, 0.7], [0.0, 0.0, 0.5], [0.0, 0.0, 0.3 * sign], [0.8, 0.0, 0.6, 0.0]),
            1,
        ));
        cases.push((
            2,
            top([1.0, 1.0, 0.7], [0.0, 0.0, 0.5], [0.0, 0.0, 0.3 * sign], [0.8, 0.0, 0.6, 0.0]),
            1,
        ));
        // Released at rest with the centre of mass on axis 3: w1 and w2 grow like t, and their product changes w3.
        cases.push((3, top([1.0, 1.6, 0.7], [0.0, 0.0, 0.5], [0.0; 3], [0.8, 0.4, 0.4 * sign, 0.2]), 3));
        cases.push((3, top([1.6, 1.0, 0.7], [0.0, 0.0, 0.5], [0.0; 3], [0.8, 0.4, 0.4 * sign, 0.2]), 3));
    }
    for (power, body, axis) in cases {
        for method in methods_of_maps(body.weight != [0.0; 3]).filter(|m| m.facts.order >= power) {
            for signed_axis in [axis, -axis] {
                let start = ObservedBody::new(&body, method, signed_axis, 0.01);
                assert_eq!(start.group.observed[Flips::SIGN].0[0].abs(), 1.0);
                let run = start.after(20);
                assert_eq!(run.flips(), 0.0, "{method:?}, axis {signed_axis} of {body:?}");
                assert_eq!(run.first(), f64::INFINITY);
                assert_ne!(run.component(), 0.0, "it left");
            }
        }
    }
}

/// A component that remains zero has no sign to change.
#[test]
fn a_component_that_stays_zero_never_flips() {
    let pendulum = Body {
        weight: [0.0, 0.0, 0.5],
        attitude: [0.6, 0.0, 0.8, 0.0],
        ..free([1.0, 1.6, 0.7], [0.0, 0.2, 0.0])
    };
    for method in methods_of_maps(true) {
        for (body, axis) in [
            (free([1.0, 1.6, 2.0], [0.0, 1.0, 0.0]), 1),
            (free([1.0, 1.0, 2.0], [0.3, 1.0, 0.0]), 3),
            (free([1.0, 1.6, 2.0], [0.0; 3]), 2),
            (pendulum, 1),
            (pendulum, 3),
        ] {
            assert_eq!(ObservedBody::new(&body, method, axis, 0.05).after(2000).flips(), 0.0, "{method:?}");
        }
        assert!(ObservedBody::new(&pendulum, method, 2, 0.05).after(2000).flips() > 5.0);
    }
}

/// Rotation about the axes of the largest and the smallest moment is stable, rotation about the middle axis is not.
#[test]
fn stable_spin_for_a_million_steps() {
    for method in methods_of_maps(false) {
        for axis in 1..=3 {
            let kernel = Kernel {
                system: System::FreeRates,
                step: KernelAssignment::of(method, &free([1.0, 1.6, 2.0], [0.0; 3]), &FREE).step,
                observed: Observed::Flips,
            };
            let compiled = Compiled::new(kernel, Isa::available()[0]);
            let mut group = Group::inactive();
            for lane in 0..LANES {
                // Noise of 1e-3 in all directions; the spin a little different in every lane.
                let angle = lane as f64 + 1.0;
                let mut omega = [1e-3 * angle.sin(), 1e-3 * angle.cos(), 1e-3 * (2.0 * angle).sin()];
                omega[axis - 1] += 1.0 + 0.01 * angle;
                let body = free([1.0, 1.6, 2.0], omega);
                let assignment = KernelAssignment::of(method, &body, &FREE);
                let (axis, step) = (axis as i32, 1.0 / 16.0);
                let entry =
                    Entry { axis, ..Entry::unobserved(&body, BodyForces::NONE, (0.0, None), None, step) };
                load(&mut group, lane, compiled, assignment, &entry);
            }
            // Fewer steps of expensive methods.
            let steps = if method.facts.order <= 4 { 1_000_000 } else { 50_000 };
            compiled.advance(
                &mut group,
                &ForcesRows::NONE,
                if method.facts.symplectic && axis == 2 { 10_000 } else { steps },
            );
            for lane in 0..LANES {
                assert_eq!(
                    group.observed[Flips::COUNT].0[lane] > 0.0,
                    axis == 2,
                    "{method:?} axis {axis} lane {lane}"
                );
                // The largest drift at the end of the blocks: a motion that lost its invariants would not prove
                // stability.
                assert!(group.energy.worst.0[lane] < 0.1, "{}", group.energy.worst.0[lane]);
            }
        }
    }
}
