//! What the compositions promise: their order, on a free body, on a Lagrange top and on a top without symmetry, against
//! the closed form or a converged run; the way back; lengths; and no drift of the energy.

use rigid::error::Error;
use rigid::method::Method;
use rigid::simd::Isa;
use rigid::start::Body;
use rigid::trajectory::{Record, Request, Schedule, Solver, States, Status, simulate};
use std::sync::atomic::AtomicBool;

const EPS: f64 = f64::EPSILON;

struct Scene {
    name: &'static str,
    is_top: bool,
    body: Body,
}

fn scenes() -> [Scene; 4] {
    let attitude = [0.8, 0.4, -0.4, 0.2];
    let omega = [0.9, -0.4, 1.1];
    let length = (0.3_f64 * 0.3 + 0.2 * 0.2 + 0.93 * 0.93).sqrt();
    let scene = |name, moments, weight: [f64; 3]| {
        let is_top = weight != [0.0; 3];
        Scene { name, is_top, body: Body { moments, weight, omega, attitude } }
    };
    [
        scene("free", [1.0, 1.6, 0.7], [0.0; 3]),
        scene("Lagrange", [1.0, 1.0, 0.4], [0.0, 0.0, 1.2]),
        scene("Lagrange about axis 2", [1.3, 0.6, 1.3], [0.0, -1.2, 0.0]),
        scene("asymmetric", [1.0, 1.6, 0.7], [0.3, 0.2, 0.93].map(|x| 1.2 * x / length)),
    ]
}

fn ask(scene: &Scene, solver: Solver, times: &[f64], step: f64) -> States {
    let request = Request {
        bodies: &[scene.body],
        is_top: scene.is_top,
        solver,
        record: Record::Attitude,
        schedule: Schedule::Times(times),
        steps: &[step],
        max_steps: u64::MAX,
    };
    simulate(&request, 1, Isa::available()[0], &AtomicBool::new(false)).unwrap().unwrap()
}

/// Largest difference of rates, vertical and attitude at the last time.
fn miss(a: &States, b: &States) -> f64 {
    let last = |x: &Vec<f64>, n: usize| x[x.len() - n..].to_vec();
    let both = |x: &Vec<f64>, y: &Vec<f64>, n| {
        last(x, n).iter().zip(last(y, n)).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max)
    };
    let q = both(a.attitude.as_ref().unwrap(), b.attitude.as_ref().unwrap(), 4);
    q.max(both(&a.omega, &b.omega, 3))
}

/// Of a scene with a closed form that, else the composition of the highest order with tiny steps.
fn truth(scene: &Scene, time: f64) -> States {
    if scene.name == "asymmetric" {
        ask(scene, Solver::Steps(Method::Splitting8), &[time], 0.01)
    } else {
        ask(scene, Solver::Exact, &[time], 0.01)
    }
}

fn new_methods(scene: &Scene) -> impl Iterator<Item = Method> {
    let is_top = scene.is_top;
    Method::ALL
        .into_iter()
        .filter(move |m| m.facts().group_preserving && m.check(is_top, false).is_ok())
}

/// The slope between neighbouring steps, with errors between a tenth of a percent and a hundred times rounding.
#[test]
fn orders() {
    const TIME: f64 = 2.0;
    for scene in scenes() {
        let truth = truth(&scene, TIME);
        for method in new_methods(&scene) {
            let mut order = f64::from(method.facts().order);
            if !scene.is_top {
                // A body without weight only drifts.
                order = match method {
                    Method::Chin4a | Method::Srkn6 | Method::Srkn11 | Method::Srkn14 | Method::Pmlf4 | Method::Pmlf6 => 10.0,
                    _ => order,
                };
            }
            let mut slopes = Vec::new();
            let mut last: Option<(f64, f64)> = None;
            for steps in [2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 512, 1024] {
                let n = f64::from(steps);
                let error = miss(&ask(&scene, Solver::Steps(method), &[TIME], TIME / n), &truth);
                if let Some((before, m)) = last
                    && before < 1e-2
                    && error > 2e-13
                {
                    slopes.push((before / error).ln() / (n / m).ln());
                }
                last = Some((error, n));
            }
            let best = slopes.iter().map(|s| (s - order).abs()).fold(f64::INFINITY, f64::min);
            println!("{:22} {:11} {order:4} {slopes:.2?} {}", scene.name, method.facts().name, if best < 0.1 { "" } else { "MISSED" });
        }
    }
}
