//! Taylor series: their coefficients, their order, and their rounding error after a long time.

use crate::tests::scene_of;
use nalgebra::{DMatrix, DVector};
use rigid::body::Body;
use rigid::call::Call;
use rigid::forces::{BodyForces, Forces, ForcesInterval};
use rigid::method::{self, AnyMethod, Engine, Method, Taylor};
use rigid::sample::{Distribution, attitude, uniforms};
use rigid::scene::{Attitude, Axis, Free, Layout, Model, Parameters, Top};
use rigid::simd::Isa;
use rigid::status::Status;
use rigid::trajectory::{Record, Request, Schedule, States, simulate};

const EPS: f64 = f64::EPSILON;

fn run(bodies: &[Body], method: AnyMethod, step: f64, times: &[f64]) -> States {
    let request = Request {
        bodies,
        scene: scene_of(bodies[0].weight != [0.0; 3]),
        forces: Forces::NONE,
        method,
        record: Record::Attitude,
        schedule: Schedule::Times(times),
        steps: &vec![step; bodies.len()],
        tolerance: None,
        refinement: 1.0,
        max_steps: u64::MAX,
    };
    simulate(&request, Call::to_the_end(Isa::available()[0], 1)).unwrap()
}

fn series() -> impl Iterator<Item = &'static Method> {
    method::ALL.iter().copied().filter(|method| method.facts.name.starts_with("taylor"))
}

fn tilted(angle: f64) -> [f64; 4] {
    [(0.5 * angle).cos(), (0.5 * angle).sin(), 0.0, 0.0]
}

fn free() -> Body {
    let attitude = [0.8, 0.4, -0.4, 0.2];
    Body { moments: [1.0, 1.6, 2.0], weight: [0.0; 3], omega: [0.6, 0.5, 0.7], attitude }
}

fn lagrange() -> Body {
    let omega = [0.5, 0.4, 0.3];
    Body { moments: [1.0, 1.0, 0.5], weight: [0.0, 0.0, 1.2], omega, attitude: tilted(1.4) }
}

/// A top without a closed form.
fn asymmetric() -> Body {
    let com = [0.3, 0.2, 0.93];
    let weight = com.map(|c| 1.2 * c / norm(&com));
    Body { moments: [1.0, 1.6, 0.7], weight, omega: [0.3, 0.1, 2.0], attitude: tilted(0.5) }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    norm(&a.iter().zip(b).map(|(x, y)| x - y).collect::<Vec<_>>())
}

// --- Coefficients ---------------------------------------------------------------------------------------------

/// cos x + i sin x up to an order.
fn truncated(x: f64, order: u32) -> [f64; 2] {
    let (mut sum, mut term) = ([0.0; 2], 1.0);
    for k in 0..=order {
        sum[k as usize % 2] += if k % 4 < 2 { term } else { -term };
        term *= x / f64::from(k + 1);
    }
    sum
}

fn step<S, M, L, const D: usize>(engine: &S, p: &Parameters<f64>, y: &mut [f64; D])
where
    M: Model<f64>,
    L: Layout,
    S: Engine<f64, M, L, D>,
{
    engine.step(p, y);
}

/// The rates of a free symmetric body turn at a constant rate, and so do the directions and, at half the rate, the
/// quaternion of a spin: truncated sine and cosine. With an angle of 5 the truncation error is at least 1e-10 of the
/// numbers, so the test detects a missing order and an extra one. Terms are up to 26, with forty roundings.
fn uniform_turn<S>(of: &Method)
where
    S: Engine<f64, Free<f64>, Attitude, 7> + Engine<f64, Free<f64>, Axis, 6>,
{
    let (order, numbers) = (of.facts.order, of.any.numbers);
    let p = Parameters { moments: [1.0, 1.0, 0.5], weight: [0.0; 3], step: 2.5 };
    let bound = 40.0 * 26.0 * EPS;
    // Relative to the body, the rates turn at (1 - I3/I1) w3 = 2.
    let mut y = [0.3, 0.0, 4.0, 0.0, 0.0, 1.0];
    let engine = <S as Engine<f64, Free<f64>, Axis, 6>>::new(&p, &ForcesInterval::none(), numbers);
    step::<S, Free<f64>, Axis, 6>(&engine, &p, &mut y);
    let [c, s] = truncated(5.0, order);
    assert!(distance(&y[..3], &[0.3 * c, -0.3 * s, 4.0]) < bound, "{order}: {y:?}");
    assert!((c - 5.0_f64.cos()).abs() > 100.0 * bound);

    // A spin of 2: a direction turns by 5 and the attitude by half of it.
    let mut y = [0.0, 0.0, 2.0, 0.6, 0.0, 0.8];
    step::<S, Free<f64>, Axis, 6>(&engine, &p, &mut y);
    assert!(distance(&y, &[0.0, 0.0, 2.0, 0.6 * c, -0.6 * s, 0.8]) < bound, "{order}: {y:?}");
    let mut y = [0.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0];
    let engine = <S as Engine<f64, Free<f64>, Attitude, 7>>::new(&p, &ForcesInterval::none(), numbers);
    step::<S, Free<f64>, Attitude, 7>(&engine, &p, &mut y);
    let [c, s] = truncated(2.5, order);
    assert!(distance(&y[3..], &[c, 0.0, 0.0, s]) < bound, "{order}: {y:?}");
}

#[test]
fn of_a_uniform_turn_the_series_are_those_of_sine_and_cosine() {
    for method in [&method::TAYLOR12, &method::TAYLOR16, &method::TAYLOR20, &method::TAYLOR26] {
        uniform_turn::<Taylor<f64, Free<f64>>>(method);
    }
}

/// A pendulum, theta'' = -k sin theta: its first four derivatives, by hand. The remainder is of order 5.
#[test]
fn first_coefficients_of_a_pendulum() {
    let (k, theta, w): (f64, f64, f64) = (0.5 / 1.6, 2.0, 0.7);
    let (s, c) = theta.sin_cos();
    let derivatives = [
        -k * s,
        -k * c * w,
        k * s * w * w + k * k * s * c,
        k * c * w.powi(3) + k * k * w * (c * c - 3.0 * s * s),
    ];
    let left = |h: f64| {
        // Centre of mass on axis 3, theta from the hanging position; the vertical in the plane of axes 3 and 1.
        let p = Parameters { moments: [1.0, 1.6, 0.7], weight: [0.0, 0.0, 0.5], step: h };
        let mut y = [0.0, w, 0.0, s, 0.0, -c];
        type Series = Taylor<f64, Top<f64>>;
        let numbers = method::TAYLOR16.any.numbers;
        let engine = <Series as Engine<f64, Top<f64>, Axis, 6>>::new(&p, &ForcesInterval::none(), numbers);
        step::<Series, Top<f64>, Axis, 6>(&engine, &p, &mut y);
        let [a, b, c, d] = derivatives;
        y[1] - (w + h * (a + h / 2.0 * (b + h / 3.0 * (c + h / 4.0 * d))))
    };
    let ratio = left(0.04) / left(0.02);
    assert!(left(0.04).abs() < 1e-8 && (ratio / 32.0 - 1.0).abs() < 0.1, "{:e}, ratio {ratio}", left(0.04));
}

// --- Order ----------------------------------------------------------------------------------------------------

fn truth(body: &Body, times: &[f64]) -> States {
    if *body == asymmetric() {
        // At most a fortieth of the radius of convergence, so the truncation error is negligible.
        run(&[*body], AnyMethod::Steps(&method::TAYLOR26), 0.02, times)
    } else {
        run(&[*body], AnyMethod::Exact, 1.0, times)
    }
}

/// Least squares of `values` by the columns of `rows`.
fn fit<const N: usize>(rows: &[[f64; N]], values: &[f64]) -> DVector<f64> {
    let matrix = DMatrix::from_fn(rows.len(), N, |i, j| rows[i][j]);
    matrix.svd(true, true).solve(&DVector::from_column_slice(values), 1e-14).unwrap()
}

/// The error of one step is c h^(p+1) and higher powers, of which the even ones (p + 1 is odd) cancel between a step
/// forward and a step backward. The rest is (p + 1) ln h + ln c + b h^2 + d h^4, in the range from a thousand roundings
/// to an error of 1e-3.
#[test]
fn one_step_has_the_stated_order() {
    for body in [free(), lagrange(), asymmetric()] {
        for method in series() {
            let order = f64::from(method.facts.order);
            let (mut rows, mut values) = (Vec::new(), Vec::new());
            let mut h: f64 = 0.01;
            while h < 3.0 {
                let times = [-h, h];
                let odd = |s: States| {
                    // Of a top the vertical: its attitude is made of rows, where part of the error cancels.
                    let other = s.gamma.as_ref().or(s.attitude.as_ref()).unwrap();
                    let n = other.len() / 2;
                    let of_rates = (0..3).map(|i| s.rates()[3 + i] - s.rates()[i]);
                    of_rates.chain((0..n).map(|i| other[n + i] - other[i])).collect::<Vec<_>>()
                };
                let error = distance(
                    &odd(run(&[body], AnyMethod::Steps(method), h, &times)),
                    &odd(truth(&body, &times)),
                );
                if error > 1e3 * EPS && error < 1e-3 {
                    rows.push([h.ln(), 1.0, h.powi(2), h.powi(4)]);
                    values.push(error.ln());
                }
                h *= 1.02;
            }
            let measured = fit(&rows, &values)[0] - 1.0;
            println!("{}: {measured:.3}, {} steps", method.facts.name, rows.len());
            assert!((measured - order).abs() < 0.1 && rows.len() > 30, "{body:?} {method:?}: {measured}");
        }
    }
}

/// A random body, or a top if `is_top`.
fn random_body(number: u64, is_top: bool) -> Body {
    let u = |block| uniforms([1, 2], block, number, 0);
    let [a, b, c, _] = u(0).map(|x| 0.2 + x);
    let [x, y, z, _] = u(1).map(|x| 4.0 * x - 2.0);
    let [c1, c2, c3, _] = u(2).map(|x| if is_top { 2.0 * x - 1.0 } else { 0.0 });
    let attitude = attitude(Distribution::UniformAttitude, [0.0; 3], [1.0, 0.0, 0.0, 0.0], u(3));
    Body { moments: [b + c, c + a, a + b], weight: [c1, c2, c3], omega: [x, y, z], attitude }
}

/// With the default step the error of the attitude is at most 1e-13 per radian turned. (The largest error of these
/// bodies was 4e-14, the median below 1e-15.)
#[test]
fn the_default_step_leaves_only_rounding() {
    for number in 0..300 {
        let body = random_body(number, number % 2 == 1);
        let rate = body.fastest_rate(BodyForces::NONE, [0.0; 2]);
        let end = [20.0 / rate];
        let exact = run(&[body], AnyMethod::Steps(&method::TAYLOR26), 0.3 / rate, &end).attitude.unwrap();
        for method in series() {
            let step = method.facts.angle_per_step / rate;
            let got = run(&[body], AnyMethod::Steps(method), step, &end).attitude.unwrap();
            let error = 2.0 * distance(&got, &exact) / 20.0;
            assert!(error < 1e-13, "{method:?} {body:?}: {error:e}");
        }
    }
}

// --- A long time ----------------------------------------------------------------------------------------------

/// Energy errors at t = 10, 100, 1000, 10^4, relative to the kinetic energy and mgl at the start: root mean squares
/// over neighbours of the asymmetric top, and the largest. With compensation only the rounding error of each increment
/// remains, some 1e-17, because an increment is a tenth of the state. These errors are nearly independent, so their sum
/// grows little faster than the root of the time.
#[test]
fn energy_after_a_hundred_thousand_steps() {
    let times = [1e1, 1e2, 1e3, 1e4];
    let neighbour = |i: i32| Body { omega: [0.3 + 1e-3 * f64::from(i), 0.1, 2.0], ..asymmetric() };
    let bodies: Vec<Body> = (0..32).map(neighbour).collect();
    let states = run(&bodies, AnyMethod::Steps(&method::TAYLOR16), 0.1, &times);
    assert!(states.status.iter().all(|&status| status == Status::Finished));
    let mut squares = [0.0; 4];
    let mut worst = 0.0_f64;
    for (i, body) in bodies.iter().enumerate() {
        let kinetic =
            |omega: &[f64]| (0..3).map(|k| 0.5 * body.moments[k] * omega[k] * omega[k]).sum::<f64>();
        let potential = |n: &[f64]| (0..3).map(|k| body.weight[k] * n[k]).sum::<f64>();
        let scale = kinetic(&body.omega) + norm(&body.weight);
        let start = kinetic(&body.omega) + potential(&body.gamma());
        for k in 0..4 {
            let at = 3 * (4 * i + k);
            let omega = &states.rates()[at..at + 3];
            let gamma = &states.gamma.as_ref().unwrap()[at..at + 3];
            let error = (kinetic(omega) + potential(gamma) - start) / scale;
            squares[k] += error * error / bodies.len() as f64;
            worst = worst.max(error.abs());
        }
    }
    let errors = squares.map(f64::sqrt);
    println!("energy errors {errors:?}, worst {worst:e}");
    // 1e5 steps that err by 2e-17 each; one body of 32 is beyond four standard deviations once in 500 times. Errors of 512
    // neighbours grow by 3.5 and 4.8 in the last two decades, because a small part is alike in all steps.
    assert!(errors[3] < 1e5_f64.sqrt() * 2e-17, "{errors:?}");
    assert!(worst < 4.0 * errors[3], "{worst:e}");
    for (earlier, decades) in [(2, 1.0), (1, 2.0)] {
        assert!(errors[3] < 10.0_f64.powf(0.75 * decades) * errors[earlier], "{errors:?}");
    }
}
