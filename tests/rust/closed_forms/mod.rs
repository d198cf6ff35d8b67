//! Closed forms against trajectories of 25 digits, Jacobi functions by other code, flip times by other formulas; and
//! derived times and angles against the evaluated motion.

mod any_body;
mod canonical;
mod reference_trajectories;
mod times_and_angles;
mod torus;

use crate::tests::scene_of;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rigid::body::Body;
use rigid::call::Call;
use rigid::exact::derived::{free_quantities, sign_changes, tilt_time, top_quantities};
use rigid::exact::{CanonicalForm, ClosedForm, Evaluator};
use rigid::forces::{BodyForces, Forces};
use rigid::inertia::check_moments;
use rigid::kinematics::to_body_frame;
use rigid::method::AnyMethod;
use rigid::simd::Isa;
use rigid::special::theta::{Phase, Torus};
use rigid::special::{complete_k, jacobi, sincos};
use rigid::status::Status;
use rigid::trajectory::{Record, Request, Schedule, States, simulate};
use serde_json::Value;
use std::f64::consts::{PI, TAU};

const EPS: f64 = f64::EPSILON;

/// The closed form of one body at these times.
fn solved(body: &Body, times: &[f64]) -> States {
    let request = Request {
        bodies: &[*body],
        scene: scene_of(body.weight != [0.0; 3]),
        forces: Forces::NONE,
        method: AnyMethod::Exact,
        record: Record::Attitude,
        schedule: Schedule::Times(times),
        steps: &[f64::NAN],
        tolerance: None,
        refinement: 1.0,
        max_steps: 0,
    };
    simulate(&request, Call::to_the_end(Isa::available()[0], 1)).unwrap()
}

/// Rates and attitude at each time.
fn motion(body: &Body, times: &[f64]) -> Vec<([f64; 3], [f64; 4])> {
    let states = solved(body, times);
    let (omega, attitude) = (states.omega.unwrap(), states.attitude.unwrap());
    let omegas = omega.chunks(3).map(|w| w.try_into().unwrap());
    omegas.zip(attitude.chunks(4).map(|q| q.try_into().unwrap())).collect()
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A free body whose attitude is not the identity.
fn free(moments: [f64; 3], omega: [f64; 3]) -> Body {
    Body { moments, weight: [0.0; 3], omega, attitude: [0.8, 0.36, -0.48, 0.0] }
}

/// A top symmetric about a signed body axis on which its centre of mass lies: moments 1 and `spin_moment`.
///
/// Attitude and rates are given in axes whose third axis points to the centre of mass, and are then renamed.
fn top(axis: i32, mgl: f64, spin_moment: f64, omega: [f64; 3], attitude: [f64; 4]) -> Body {
    let k = axis.unsigned_abs() as usize - 1;
    let (mut moments, mut weight) = ([1.0; 3], [0.0; 3]);
    moments[k] = spin_moment;
    weight[k] = f64::from(axis.signum()) * mgl;
    let frame = Frame::of(axis);
    // The attitude from body to space is the given attitude after the rotation of the body frame.
    let attitude = rigid::kinematics::quaternion_product(&attitude, &frame.quaternion());
    Body { moments, weight, omega: frame.back(omega), attitude }
}

/// Renamed body axes, right-handed; the third axis is a given signed axis.
struct Frame {
    /// Body axis of each new axis, and its sign.
    axes: [(usize, f64); 3],
}

impl Frame {
    fn of(axis: i32) -> Frame {
        let k = axis.unsigned_abs() as usize - 1;
        let sign = f64::from(axis.signum());
        Frame { axes: [((k + 1) % 3, 1.0), ((k + 2) % 3, sign), (k, sign)] }
    }

    fn apply(&self, v: [f64; 3]) -> [f64; 3] {
        self.axes.map(|(k, sign)| sign * v[k])
    }

    fn back(&self, v: [f64; 3]) -> [f64; 3] {
        let mut out = [0.0; 3];
        for ((k, sign), x) in self.axes.into_iter().zip(v) {
            out[k] = sign * x;
        }
        out
    }

    /// The rotation from body components to components along the new axes.
    fn quaternion(&self) -> [f64; 4] {
        let rows = [0, 1, 2].map(|i| {
            let mut row = [0.0; 3];
            row[self.axes[i].0] = self.axes[i].1;
            row
        });
        let matrix = nalgebra::Matrix3::from_fn(|i, j| rows[i][j]);
        let turn = nalgebra::Rotation3::from_matrix_unchecked(matrix);
        let q = nalgebra::UnitQuaternion::from_rotation_matrix(&turn);
        [q.w, q.i, q.j, q.k]
    }
}

/// The attitude with the Euler angles z-x-z.
fn euler(phi: f64, theta: f64, psi: f64) -> [f64; 4] {
    let (sigma, delta) = (0.5 * (phi + psi), 0.5 * (phi - psi));
    let (c, s) = ((0.5 * theta).cos(), (0.5 * theta).sin());
    [c * sigma.cos(), s * delta.cos(), s * delta.sin(), c * sigma.sin()]
}

/// Flip times about the intermediate axis with a perturbation of axis 1, of axis 3, and of both, from 2 K / lambda
/// in arithmetic of 50 digits, for spin 1 of the moments (1, 2, 3) and spin 10 of a box of 0.25 x 0.08 x 0.01 m.
const FLIP_TIMES: [(f64, [f64; 3], [f64; 3]); 8] = [
    (1e-1, [12.755489, 10.821061, 11.498131], [0.825801, 0.805952, 1.009655]),
    (1e-2, [20.754610, 18.851036, 19.552867], [1.345707, 1.326085, 1.532385]),
    (1e-3, [28.731424, 26.828561, 27.530841], [1.864129, 1.844512, 2.050852]),
    (1e-4, [36.707819, 34.804967, 35.507253], [2.382524, 2.362907, 2.569248]),
    (1e-6, [52.660597, 50.757745, 51.460031], [3.419313, 3.399696, 3.606036]),
    (1e-8, [68.613374, 66.710522, 67.412808], [4.456102, 4.436485, 4.642825]),
    (1e-10, [84.566152, 82.663300, 83.365586], [5.492890, 5.473273, 5.679614]),
    (1e-12, [100.518929, 98.616077, 99.318363], [6.529679, 6.510062, 6.716402]),
];

#[test]
fn flip_times() {
    let boxed = [0.000_108_333_333_333_333_34, 0.001_043_333_333_333_333_4, 0.001_148_333_333_333_333_5];
    for (e, plain, of_box) in FLIP_TIMES {
        for (moments, spin, expected) in [([1.0, 2.0, 3.0], 1.0, plain), (boxed, 10.0, of_box)] {
            let small = e * spin;
            let starts = [[small, spin, 0.0], [0.0, spin, small], [small, spin, small]];
            for (omega, expected) in starts.into_iter().zip(expected) {
                for isa in Isa::available() {
                    let quantities = free_quantities(isa, &free(moments, omega));
                    // Six decimals.
                    let miss = (quantities.flip_time - expected).abs();
                    assert!(miss <= 0.51e-6, "{omega:?}: {} instead of {expected}", quantities.flip_time);
                }
            }
        }
    }
}

/// Free bodies: asymmetric about either axis, near the separatrix, nearly symmetric, in any order; symmetric.
fn free_bodies() -> Vec<Body> {
    let asymmetric = [
        ([1.0, 2.0, 3.0], [1.0, 0.5, -0.8]),
        ([1.0, 2.0, 3.0], [0.9, 0.3, 0.1]),
        ([3.0, 1.0, 2.0], [-0.4, 0.5, 0.8]),
        ([2.0, 3.0, 1.0], [1.0, 1e-6, 1e-7]),
        ([1.0, 2.0, 3.0], [-1e-8, -1.0, 2e-8]),
        ([1.0, 2.0, 3.0], [0.0, 1.0, -1e-3]),
        ([1.0, 2.0, 3.0], [1e-3, 0.0, -1.0]),
        ([1.0, 1.000001, 1.5], [0.4, -0.3, 1.2]),
        ([1.0, 2.9, 3.0], [7.0, -3.0, 2.0]),
    ];
    let symmetric = [
        ([2.0, 2.0, 1.0], [0.3, -0.4, 2.0]),
        ([1.0, 1.5, 1.0], [-0.3, -0.4, 2.0]),
        ([0.5, 1.0, 1.0], [-2.0, 0.4, 0.0]),
        ([0.5, 1.0, 1.0], [-2.0, 0.0, 0.4]),
    ];
    asymmetric.into_iter().chain(symmetric).map(|(moments, omega)| free(moments, omega)).collect()
}

/// A component is zero at the first change of its sign and at the next ones, and at no other time.
///
/// The error of the time of a zero is that of its phase: 8 roundings of the time and of the half period, from both
/// sides.
#[test]
fn sign_changes_are_zeros_of_the_rates() {
    for body in free_bodies() {
        for axis in 0..3 {
            let [first, every] = sign_changes(Isa::available()[0], &body, axis).unwrap();
            if first == f64::INFINITY {
                // This component keeps its sign.
                let times: Vec<f64> = (0..400).map(|k| 0.37 * f64::from(k)).collect();
                let sign = body.omega[axis].signum();
                assert!(motion(&body, &times).iter().all(|(w, _)| w[axis] * sign > 0.0), "{body:?} {axis}");
                continue;
            }
            assert!(0.0 < first && first <= every, "{body:?} {axis}: {first} {every}");
            let slack = 8.0 * 0.5 * EPS * (first + 3.0 * every);
            let (before, after) = (first - slack, first + slack);
            let mut times: Vec<f64> = (1..200).map(|k| before * f64::from(k) / 199.0).collect();
            times.extend((1..=200).map(|k| after + (every - 2.0 * slack) * f64::from(k) / 200.0));
            times.extend([first + every + slack, first + 2.0 * every - slack, first + 2.0 * every + slack]);
            let signs: Vec<f64> = motion(&body, &times).iter().map(|(w, _)| w[axis].signum()).collect();
            let expected = |k: usize| match k {
                0..199 => 1.0,
                199..399 => -1.0,
                399 | 400 => 1.0,
                _ => -1.0,
            };
            for (k, sign) in signs.iter().enumerate() {
                let (found, t) = (sign * signs[0], times[k]);
                assert_eq!(found, expected(k), "{body:?} axis {axis}: {first}, {every}, sign at {t}");
            }
            let start = body.omega[axis];
            assert!(start == 0.0 || start.signum() == signs[0], "{body:?} axis {axis}");
        }
    }
}

/// The rates reach their amplitudes in half a period and never exceed them; the encircled axis keeps its sign.
#[test]
fn amplitudes_and_the_encircled_axis() {
    for body in free_bodies() {
        let quantities = free_quantities(Isa::available()[0], &body);
        let times: Vec<f64> = (0..=2000).map(|k| quantities.flip_time * f64::from(k) / 1000.0).collect();
        let states = motion(&body, &times);
        for k in 0..3 {
            let largest = states.iter().map(|(w, _)| w[k].abs()).fold(0.0, f64::max);
            let amplitude = quantities.amplitude[k];
            assert!(largest <= amplitude * (1.0 + 16.0 * EPS), "{body:?} axis {k}: {largest} {amplitude}");
            // The maximum is at most half a sample away; near a separatrix a period has few samples and sn a large
            // curvature.
            let samples = 1000.0 / (1.0 - quantities.parameter[1].ln()).max(1.0);
            let tolerance = (PI / samples) * (PI / samples);
            assert!(largest >= amplitude * (1.0 - tolerance), "{body:?} axis {k}: {largest} {amplitude}");
        }
        let axis = quantities.axis;
        if axis != 0 {
            let k = usize::from(axis.unsigned_abs()) - 1;
            assert!(states.iter().all(|(w, _)| w[k] * f64::from(axis) > 0.0), "{body:?}");
        }
        let [m, mc] = quantities.parameter;
        assert!((m + mc - 1.0).abs() <= 8.0 * EPS, "{body:?}");
    }
}

/// The mean rate of the encircled axis about L, from its azimuth along the motion.
#[test]
fn precession_is_the_mean_turn_about_l() {
    for body in free_bodies() {
        let quantities = free_quantities(Isa::available()[0], &body);
        if quantities.axis == 0 {
            continue;
        }
        // 8 periods of the rates; 2000 samples in each.
        let end = 16.0 * quantities.flip_time;
        let times: Vec<f64> = (0..=16000).map(|k| end * f64::from(k) / 16000.0).collect();
        let mut axis = [0.0; 3];
        axis[usize::from(quantities.axis.unsigned_abs()) - 1] = f64::from(quantities.axis.signum());
        let l = [0, 1, 2].map(|k| body.moments[k] * body.omega[k]);
        let l = to_space(&body.attitude, l);
        let length = norm(&l);
        let [u, v] = across(l.map(|x| x / length));
        let azimuths = motion(&body, &times).into_iter().map(|(_, q)| {
            let a = to_space(&q, axis);
            dot(a, v).atan2(dot(a, u))
        });
        let mean = unwrapped(azimuths) / end;
        // The error of the azimuth is that of the angle turned, and a few eps more if the axis is close to L.
        let angle = length / body.moments.into_iter().fold(f64::INFINITY, f64::min) * end;
        let slack = 4.0 * EPS * (angle + 100.0) / end + 8.0 * EPS * mean.abs();
        let near_l = 1.0 - dot(to_space(&body.attitude, axis), l) / length;
        let slack = slack / near_l.sqrt().min(1.0);
        assert!(
            (mean - quantities.precession).abs() <= slack,
            "{body:?}: {mean} {} {slack:e}",
            quantities.precession
        );
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Space components from body components.
fn to_space(&[w, x, y, z]: &[f64; 4], v: [f64; 3]) -> [f64; 3] {
    to_body_frame(&[w, -x, -y, -z], &v)
}

/// Two directions that are right-handed with a third.
fn across(c: [f64; 3]) -> [[f64; 3]; 2] {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let seed = if c[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let v = cross(c, seed);
    let v = v.map(|x| x / norm(&v));
    [cross(v, c), v]
}

/// The change of an angle along samples that turn by less than half a turn each; whole turns are counted, so only the
/// ends are rounded.
fn unwrapped(angles: impl Iterator<Item = f64>) -> f64 {
    let angles: Vec<f64> = angles.collect();
    let turns: f64 = angles.windows(2).map(|pair| ((pair[0] - pair[1]) / TAU).round()).sum();
    turns * TAU + (angles[angles.len() - 1] - angles[0])
}

/// Tops on every signed axis: loops, monotone precession, cusp, slow and fast, low and high.
fn tops() -> Vec<Body> {
    let starts = [
        (4.9, 0.5, [0.0, 0.0, 20.0], euler(0.4, 0.5, -1.0)),
        (4.9, 0.5, [0.0, -0.45, 20.0], euler(0.0, 0.6, 0.3)),
        (4.9, 0.5, [0.32, 0.5, 15.0], euler(-0.3, 0.7, 2.0)),
        (4.9, 0.5, [0.1, 0.05, 2.0], euler(1.0, 2.9, 0.2)),
        (9.8, 0.01, [1.0, 2.5, 0.0], euler(1.0, 2.2, 0.0)),
        (4.0, 1.7, [1.5, -2.5, -3.0], euler(1.0, 1.2, 0.0)),
        (1.0, 1.0, [0.5, 0.7, -1.0], euler(0.0, 1.7, 0.7)),
    ];
    let mut all = Vec::new();
    for axis in [3, 1, 2, -1, -2, -3] {
        for (mgl, spin_moment, omega, attitude) in starts {
            all.push(top(axis, mgl, spin_moment, omega, attitude));
        }
    }
    all
}

/// The signed axis on which the centre of mass lies.
fn weight_axis(body: &Body) -> i32 {
    let k = (0..3).find(|&k| body.weight[k] != 0.0).unwrap();
    (k as i32 + 1) * body.weight[k].signum() as i32
}
