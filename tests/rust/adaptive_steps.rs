//! Taylor series that choose their steps: as exact as asked, the same bits in any company, states in between for
//! nothing, and hardly a lane that waits.

use crate::tests::scene_of;
use rigid::forcing::Forcing;
use rigid::sample::{Law, attitude, uniforms};
use rigid::scheme::{self, Scheme};
use rigid::simd::Isa;
use rigid::solver::Solver;
use rigid::start::Body;
use rigid::status::Status;
use rigid::trajectory::{Record, Request, Schedule, States, simulate};
use std::sync::atomic::AtomicBool;

struct Question<'a> {
    bodies: &'a [Body],
    method: &'static Scheme,
    tolerance: f64,
    record: Record,
    times: &'a [f64],
    max_steps: u64,
    threads: usize,
    isa: Isa,
}

fn asked<'a>(bodies: &'a [Body], method: &'static Scheme, tolerance: f64, times: &'a [f64]) -> Question<'a> {
    let isa = Isa::available()[0];
    Question {
        bodies,
        method,
        tolerance,
        record: Record::Attitude,
        times,
        max_steps: 1 << 40,
        threads: 1,
        isa,
    }
}

impl Question<'_> {
    fn request<'a>(&'a self, solver: Solver, steps: &'a [f64], tolerance: Option<f64>) -> Request<'a> {
        Request {
            bodies: self.bodies,
            scene: scene_of(self.bodies.iter().any(|body| body.weight != [0.0; 3])),
            forcing: Forcing::NONE,
            solver,
            record: self.record,
            schedule: Schedule::Times(self.times),
            steps,
            tolerance,
            refinement: 1.0,
            max_steps: self.max_steps,
        }
    }

    fn answer(&self) -> States {
        let first =
            |body: &Body| self.method.facts.angle_per_step / body.fastest_rate(Forcing::NONE, [0.0; 2]);
        let steps: Vec<f64> = self.bodies.iter().map(first).collect();
        let request = self.request(Solver::Steps(self.method), &steps, Some(self.tolerance));
        simulate(&request, self.threads, self.isa, &AtomicBool::new(false)).unwrap()
    }

    fn exactly(&self) -> States {
        let steps = vec![f64::INFINITY; self.bodies.len()];
        let request = self.request(Solver::Exact, &steps, None);
        simulate(&request, self.threads, self.isa, &AtomicBool::new(false)).unwrap()
    }
}

fn series() -> impl Iterator<Item = &'static Scheme> {
    scheme::ALL.iter().copied().filter(|method| method.is_series())
}

/// Any body, symmetric about its axis 3 with its centre of mass there if asked; rates of one size times `spin`.
fn body(number: u64, is_top: bool, symmetric: bool, spin: f64) -> Body {
    let u = |block| uniforms([1, 2], block, number, 0);
    let [a, b, c, _] = u(0).map(|x| 0.2 + x);
    let [x, y, z, _] = u(1).map(|x| spin * (2.0 * x - 1.0));
    let [c1, c2, c3, _] = u(2).map(|x| if is_top { 2.0 * x - 1.0 } else { 0.0 });
    let attitude = attitude(Law::UniformAttitude, 0.0, [1.0, 0.0, 0.0, 0.0], u(3));
    let (moments, weight) = match symmetric {
        true => ([a + b, a + b, 2.0 * a], [0.0, 0.0, c3]),
        false => ([b + c, c + a, a + b], [c1, c2, c3]),
    };
    Body { moments, weight, omega: [x, y, z], attitude }
}

fn numbers(states: &States, i: usize) -> (Vec<u64>, Status, u64) {
    let n = states.status.len();
    let fields = [&states.omega, &states.vertical, &states.attitude];
    let of_field = |field: &Vec<f64>| field[i * (field.len() / n)..][..field.len() / n].to_vec();
    let mut all: Vec<f64> = fields.into_iter().flatten().flat_map(of_field).collect();
    all.extend([states.energy_drift[i], states.momentum_drift[i], states.unit_drift[i]]);
    let bits = |x: f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
    (all.into_iter().map(bits).collect(), states.status[i], states.steps[i])
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

// --- As exact as asked ----------------------------------------------------------------------------------------

/// A step leaves out terms no larger than about the tolerance, and a body turns by a few tenths of a radian in it: the
/// attitude is off by less than the tolerance a radian, or by rounding. Both ways in time, at times of every step.
#[test]
fn the_error_follows_the_tolerance() {
    let times: Vec<f64> = (-40..=40).map(|k| 0.37 * f64::from(k)).collect();
    for is_top in [false, true] {
        let bodies: Vec<Body> = (0..64).map(|i| body(i, is_top, is_top, 2.0)).collect();
        for method in series() {
            for tolerance in [1e-6, 1e-9, 1e-12, 1e-15] {
                let question = asked(&bodies, method, tolerance, &times);
                let (got, exact) = (question.answer(), question.exactly());
                let mut worst = 0.0_f64;
                for (i, body) in bodies.iter().enumerate() {
                    assert_eq!(got.status[i], Status::Finished);
                    for k in 0..times.len() {
                        let [a, b] =
                            [&got, &exact].map(|s| &s.attitude.as_ref().unwrap()[4 * (81 * i + k)..][..4]);
                        worst = worst.max(
                            2.0 * distance(a, b)
                                / (1.0 + body.fastest_rate(Forcing::NONE, [0.0; 2]) * times[k].abs()),
                        );
                    }
                }
                println!("{is_top} {} {tolerance:e}: {worst:.1e}", method.facts.name);
                assert!(worst < tolerance + 3e-15, "{method:?} {tolerance:e}: {worst:e}");
            }
        }
    }
}

/// More wanted times take no further steps and change no state.
#[test]
fn states_in_between_are_free() {
    let bodies: Vec<Body> = (0..40).map(|i| body(i, true, false, 2.0)).collect();
    let many: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
    let few = [many[7], many[500], many[999]];
    let [many, few] = [&many[..], &few].map(|times| asked(&bodies, &scheme::TAYLOR16, 1e-14, times).answer());
    assert_eq!(many.steps, few.steps);
    for i in 0..bodies.len() {
        for (of_few, of_many) in [(0, 7), (1, 500), (2, 999)] {
            let [a, b] =
                [&few.rates()[3 * (3 * i + of_few)..][..3], &many.rates()[3 * (1000 * i + of_many)..][..3]];
            assert_eq!(a, b);
        }
    }
}

// --- The same bits --------------------------------------------------------------------------------------------

/// Bodies of both frames, one that overflows, one at rest, one too fast for the steps allowed.
fn crowd(is_top: bool) -> Vec<Body> {
    let mut bodies: Vec<Body> =
        (0..203).map(|i| body(i, is_top, i % 3 == 0, 1.0 + 3.0 * (i % 7) as f64 / 6.0)).collect();
    bodies[100].omega = [1e200, 1e200, 1.0];
    bodies[101].omega = [0.0; 3];
    bodies[103].omega = [3e3, 5e3, 1e3];
    bodies
}

#[test]
fn the_same_bits_in_any_company() {
    let times = [-0.7, 0.0, 0.3, 0.31, 20.0];
    for is_top in [false, true] {
        let bodies = crowd(is_top);
        for (method, record) in
            series().zip([Record::Rates, Record::Axis, Record::Attitude].into_iter().cycle())
        {
            let ask = |bodies: &[Body], threads, isa| {
                Question { record, max_steps: 3000, threads, isa, ..asked(bodies, method, 1e-12, &times) }
                    .answer()
            };
            let isa = Isa::available()[0];
            let everything =
                |states: &States| (0..bodies.len()).map(|i| numbers(states, i)).collect::<Vec<_>>();
            let together = ask(&bodies, 1, isa);
            let once = everything(&together);
            for isa in Isa::available() {
                assert_eq!(everything(&ask(&bodies, 2, isa)), once, "{method:?} {isa:?}");
            }
            for i in 0..bodies.len() {
                assert_eq!(numbers(&ask(&bodies[i..=i], 1, isa), 0), once[i], "{method:?} body {i}");
            }
            let mirrored: Vec<Body> = bodies.iter().rev().copied().collect();
            let mut mirrored = everything(&ask(&mirrored, 3, isa));
            mirrored.reverse();
            assert_eq!(mirrored, once, "{method:?}");

            assert_eq!(together.status[100], Status::NotFinite);
            assert_eq!(together.status[103], Status::StepLimit);
            assert_eq!(together.steps[103], 3000);
            let finished = together.status.iter().filter(|&&status| status == Status::Finished).count();
            assert_eq!(finished, bodies.len() - 2, "{method:?}");
        }
    }
}

// --- Hardly a lane waits --------------------------------------------------------------------------------------

/// Bodies whose work spreads fourfold: of the steps of all lanes, those of bodies.
#[test]
fn lanes_are_used() {
    let bodies: Vec<Body> =
        (0..1024).map(|i| body(i, true, false, 8.0 * (1.0 + 3.0 * (i % 16) as f64 / 15.0))).collect();
    let states = asked(&bodies, &scheme::TAYLOR16, 1e-13, &[100.0]).answer();
    let (least, most) = (states.steps.iter().min().unwrap(), states.steps.iter().max().unwrap());
    let useful = states.steps.iter().sum::<u64>() as f64 / states.lane_steps as f64;
    println!("{least} to {most} steps, useful {useful:.3}");
    assert!(most >= &(4 * least) && useful >= 0.95, "{least} to {most}: {useful}");
}

// --- What is refused ------------------------------------------------------------------------------------------

#[test]
fn a_tolerance_that_says_nothing() {
    let bodies = [body(1, false, false, 1.0)];
    let refusal = |method: &'static Scheme, tolerance: f64| {
        let question = asked(&bodies, method, tolerance, &[1.0]);
        let request = question.request(Solver::Steps(method), &[0.1], Some(tolerance));
        simulate(&request, 1, Isa::Scalar, &AtomicBool::new(false)).err().expect("refused").to_string()
    };
    for method in [&scheme::RK4, &scheme::SPLITTING] {
        assert!(refusal(method, 1e-9).contains("only the Taylor methods"));
    }
    for tolerance in [0.0, -1e-9, f64::NAN, f64::INFINITY, 1.0] {
        assert!(refusal(&scheme::TAYLOR12, tolerance).contains("must be positive and below one"));
    }
}
