//! Properties of the compositions: their order for a free body, a Lagrange top and a top without symmetry, against the
//! closed form or a converged run; reversibility; lengths; and an energy without drift.

use crate::tests::scene_of;
use rigid::body::Body;
use rigid::call::Call;
use rigid::error::Error;
use rigid::forces::Forces;
use rigid::method::{self, AnyMethod, Method};
use rigid::sample::uniforms;
use rigid::simd::Isa;
use rigid::status::Status;
use rigid::trajectory::{Record, Request, Schedule, States, simulate};

const EPS: f64 = f64::EPSILON;

struct Scene {
    name: &'static str,
    is_top: bool,
    bodies: Vec<Body>,
}

fn scenes() -> [Scene; 4] {
    let attitude = [0.8, 0.4, -0.4, 0.2];
    // Several starts, because the leading error of one start may nearly vanish.
    let omegas = [[0.9, -0.4, 1.1], [-0.5, 1.2, 0.3], [0.2, 0.7, -1.3], [1.4, 0.3, 0.5]];
    let length = (0.3_f64 * 0.3 + 0.2 * 0.2 + 0.93 * 0.93).sqrt();
    let scene = |name, moments, weight: [f64; 3]| {
        let is_top = weight != [0.0; 3];
        let bodies = omegas.map(|omega| Body { moments, weight, omega, attitude }).to_vec();
        Scene { name, is_top, bodies }
    };
    [
        scene("free", [1.0, 1.6, 0.7], [0.0; 3]),
        scene("Lagrange", [1.0, 1.0, 0.4], [0.0, 0.0, 1.2]),
        scene("Lagrange about axis 2", [1.3, 0.6, 1.3], [0.0, -1.2, 0.0]),
        scene("asymmetric", [1.0, 1.6, 0.7], [0.3, 0.2, 0.93].map(|x| 1.2 * x / length)),
    ]
}

fn integrate(scene: &Scene, method: AnyMethod, times: &[f64], step: f64) -> States {
    let request = Request {
        bodies: &scene.bodies,
        scene: scene_of(scene.is_top),
        forces: Forces::NONE,
        method,
        record: Record::Attitude,
        schedule: Schedule::Times(times),
        steps: &vec![step; scene.bodies.len()],
        tolerance: None,
        refinement: 1.0,
        max_steps: u64::MAX,
    };
    simulate(&request, Call::to_the_end(Isa::available()[0], 1)).unwrap()
}

/// Sum of the differences of rates and attitudes; the sign of an attitude is arbitrary.
fn difference(a: &States, b: &States) -> f64 {
    let sum = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(p, q)| (p - q).abs()).sum::<f64>();
    let (p, q) = (a.attitude.as_ref().unwrap(), b.attitude.as_ref().unwrap());
    let turned = |(p, q): (&[f64], &[f64])| sum(p, q).min(p.iter().zip(q).map(|(x, y)| (x + y).abs()).sum());
    sum(a.rates(), b.rates()) + p.chunks(4).zip(q.chunks(4)).map(turned).sum::<f64>()
}

fn all_finished(states: &States) -> bool {
    states.status.iter().all(|&status| status == Status::Finished)
}

/// The closed form, or the composition of the highest order with tiny steps for a scene without a closed form.
fn reference(scene: &Scene, time: f64) -> States {
    if scene.name == "asymmetric" {
        integrate(scene, AnyMethod::Steps(&method::SPLITTING8), &[time], 0.01)
    } else {
        integrate(scene, AnyMethod::Exact, &[time], 0.01)
    }
}

fn geometric_methods(scene: &Scene) -> impl Iterator<Item = &'static Method> {
    let is_top = scene.is_top;
    method::ALL.iter().copied().filter(move |m| m.facts.group_preserving && m.check(scene_of(is_top)).is_ok())
}

/// The order of the remaining error: a body without weight only drifts.
fn nominal_order(method: &'static Method, scene: &Scene) -> f64 {
    let kicks = [method::CHIN4A, method::PMLF4, method::PMLF6];
    f64::from(if !scene.is_top && kicks.contains(method) { 10 } else { method.facts.order })
}

/// The slope between the finest steps for which the error of four bodies is above rounding, and above the error of the
/// converged run if there is no closed form. The slope differs from the order by the effect of the next even power of
/// the step. The effect is large where the leading error is small: the processor of pmlf6 removes nearly all of the error
/// of order 6, which looks like order 7.
#[test]
fn orders() {
    const TIME: f64 = 6.0;
    for scene in scenes() {
        let reference = reference(&scene, TIME);
        for method in geometric_methods(&scene) {
            let order = nominal_order(method, &scene);
            let mut slope = f64::NAN;
            let mut last = (f64::NAN, 1.0);
            for n in [12, 16, 20, 24, 32, 40, 48, 64, 96, 128, 192, 256, 512, 1024, 2048] {
                let states = integrate(&scene, AnyMethod::Steps(method), &[TIME], TIME / f64::from(n));
                let error = if all_finished(&states) { difference(&states, &reference) } else { f64::NAN };
                if error < if scene.is_top { 2e-11 } else { 4.5e-12 } {
                    break;
                }
                slope = (last.0 / error).ln() / (f64::from(n) / last.1).ln();
                last = (error, f64::from(n));
            }
            println!("{:22} {:11} {order:4} {slope:.2}", scene.name, method.facts.name);
            let above = match method.facts.name {
                "pmlf6" if scene.is_top => 1.3,
                _ => 0.1,
            };
            assert!(slope > order - 0.1 && slope < order + above, "{} {method:?}: {slope}", scene.name);
        }
    }
}

/// A palindrome forwards and then backwards is the identity, up to rounding: 200 steps of at most 103 flows in each
/// direction with ten roundings each, magnified by the motion; four bodies. The largest stretch of the tangent between two
/// times is 31 for the tops on axis 3 and 33 for the asymmetric ones; the sum of seven components is at most 2.65 times
/// their norm.
#[test]
fn a_palindrome_is_reversible() {
    for scene in scenes() {
        for method in geometric_methods(&scene).filter(|m| m.facts.reversible) {
            let there = integrate(&scene, AnyMethod::Steps(method), &[5.0], 0.025);
            let attitudes = there.attitude.as_ref().unwrap();
            let at_end = |(i, body): (usize, &Body)| Body {
                omega: there.rates()[3 * i..][..3].try_into().unwrap(),
                attitude: attitudes[4 * i..][..4].try_into().unwrap(),
                ..*body
            };
            let bodies = scene.bodies.iter().enumerate().map(at_end).collect();
            let back = integrate(&Scene { bodies, ..scene }, AnyMethod::Steps(method), &[-5.0], 0.025);
            let home = integrate(&scene, AnyMethod::Steps(method), &[0.0], 0.025);
            let difference = difference(&back, &home);
            let roundings = (2.0 * 200.0 * 10.0 * method.facts.stages.max(7) as f64).sqrt() * EPS / 2.0;
            let bound = 4.0 * if scene.is_top { 33.0 * 7.0_f64.sqrt() } else { 30.0 } * roundings;
            println!("{:22} {:11} {difference:.1e} {bound:.1e}", scene.name, method.facts.name);
            assert!(difference <= bound, "{} {method:?}: {difference:e}", scene.name);
        }
    }
}

/// During 1e5 steps the lengths of the quaternion and of the vertical, or of L of a free body, change only by rounding,
/// at most eps a turn; and the error of the energy does not grow after the first tenth.
#[test]
fn lengths_and_energy_do_not_drift() {
    const STEP: f64 = 0.05;
    for scene in scenes() {
        for method in geometric_methods(&scene) {
            let run = |steps: f64| {
                let times: Vec<f64> = (1..=500).map(|k| f64::from(k) * STEP * steps / 500.0).collect();
                integrate(&scene, AnyMethod::Steps(method), &times, STEP)
            };
            let [early, all] = [run(1e4), run(1e5)];
            assert!(all_finished(&all), "{} {method:?}", scene.name);
            let largest = |x: &[f64]| x.iter().fold(0.0_f64, |a, &b| a.max(b));
            let (first, worst) = (largest(&early.energy_drift), largest(&all.energy_drift));
            let (unit, momentum) = (largest(&all.unit_drift), largest(&all.momentum_drift));
            println!(
                "{:22} {:11} energy {first:.1e} {worst:.1e} lengths {unit:.1e} {:.1e}",
                scene.name, method.facts.name, momentum
            );
            let turns = 1e5 * method.facts.stages.max(2) as f64 * EPS;
            assert!(unit <= turns && (scene.is_top || momentum <= turns));
            assert!(worst < 1.5 * first + turns, "{} {method:?}: {first:e} then {worst:e}", scene.name);
        }
    }
}

/// Too long a step of a discrete Moser-Veselov drift gives no state, because the equation of the step has no solution,
/// or a wrong one.
#[test]
fn too_long_a_drift_gives_no_state() {
    let (mut refused, mut finished) = (0, 0);
    for number in 0..3000 {
        let [a, b, c, h] = uniforms([7, 8], 0, number, 0);
        let [x, y, z, flat] = uniforms([7, 8], 1, number, 0).map(|u| 2.0 * u - 1.0);
        // Random bodies, down to needles and discs with a ratio of one in a hundred.
        let thin = if flat > 0.0 { 1.0 } else { 0.01 };
        let body = Body {
            moments: [b * thin + c, c + a, a + b * thin],
            weight: [0.0; 3],
            omega: [x, y, z],
            attitude: [1.0, 0.0, 0.0, 0.0],
        };
        let scene = Scene { name: "free", is_top: false, bodies: vec![body] };
        let rate = (x * x + y * y + z * z).sqrt();
        let step = 4.0 * h / rate;
        let reference = integrate(&scene, AnyMethod::Exact, &[step], step);
        let states = integrate(&scene, AnyMethod::Steps(&method::DMV10), &[step], step);
        if states.status[0] == Status::Finished {
            finished += 1;
            let error = difference(&states, &reference) / rate.max(1.0);
            assert!(error < 1e-2, "turning by {}: {error:e}, {body:?}", rate * step);
        } else {
            refused += 1;
            assert!(rate * step > 0.5, "turning by {}: {body:?}", rate * step);
        }
    }
    println!("{finished} finished, {refused} refused");
    assert!(finished > 500 && refused > 500);
}

/// A method refuses scenes and observables that it does not support.
#[test]
fn refused_scenes_and_observables() {
    let refused = |method: &'static Method, checked: Result<(), Error>| match checked {
        Ok(()) => false,
        Err(Error::Value { argument, value, .. }) => {
            assert_eq!((argument, value), ("method", format!("'{}'", method.facts.name)));
            true
        }
        Err(other) => panic!("{other:?}"),
    };
    for method in method::ALL {
        let (drifts, processed) =
            (method.facts.name.starts_with("dmv"), method.facts.name.starts_with("pmlf"));
        assert!(!refused(method, method.check(scene_of(false))));
        assert_eq!(refused(method, method.check(scene_of(true))), drifts);
        assert_eq!(refused(method, method.check_observed()), processed || method.is_series());
    }
}
