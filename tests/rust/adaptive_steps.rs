//! Adaptive steps of Taylor series, and by trial: the error follows the tolerance, the bits do not depend on the batch, dense
//! output takes no steps.

use crate::tests::scene_of;
use rigid::body::Body;
use rigid::call::Call;
use rigid::forces::{BodyForces, Code, Forces, TorqueFunction};
use rigid::method::{self, AnyMethod, Method};
use rigid::sample::{Distribution, attitude, uniforms};
use rigid::simd::Isa;
use rigid::status::Status;
use rigid::trajectory::{Record, Request, Schedule, States, simulate};

struct Case<'a> {
    bodies: &'a [Body],
    forces: &'a Forces,
    method: &'static Method,
    tolerance: f64,
    record: Record<'a>,
    times: &'a [f64],
    max_steps: u64,
    threads: usize,
    isa: Isa,
}

fn case<'a>(bodies: &'a [Body], method: &'static Method, tolerance: f64, times: &'a [f64]) -> Case<'a> {
    let isa = Isa::available()[0];
    let (forces, record) = (Forces::NONE, Record::Attitude);
    Case { bodies, forces, method, tolerance, record, times, max_steps: 1 << 40, threads: 1, isa }
}

impl Case<'_> {
    fn request<'a>(&'a self, method: AnyMethod, steps: &'a [f64], tolerance: Option<f64>) -> Request<'a> {
        Request {
            bodies: self.bodies,
            scene: scene_of(self.bodies.iter().any(|body| body.weight != [0.0; 3])),
            forces: self.forces,
            method,
            record: self.record,
            schedule: Schedule::Times(self.times),
            steps,
            tolerance,
            refinement: 1.0,
            max_steps: self.max_steps,
        }
    }

    fn adaptive_states(&self) -> States {
        let first =
            |body: &Body| self.method.facts.angle_per_step / body.fastest_rate(BodyForces::NONE, [0.0; 2]);
        let steps: Vec<f64> = self.bodies.iter().map(first).collect();
        let request = self.request(AnyMethod::Steps(self.method), &steps, Some(self.tolerance));
        simulate(&request, Call::to_the_end(self.isa, self.threads)).unwrap()
    }

    fn exact_states(&self) -> States {
        let steps = vec![f64::INFINITY; self.bodies.len()];
        let request = self.request(AnyMethod::Exact, &steps, None);
        simulate(&request, Call::to_the_end(self.isa, self.threads)).unwrap()
    }
}

fn series() -> impl Iterator<Item = &'static Method> {
    method::ALL.iter().copied().filter(|method| method.is_series())
}

/// A random body, with its centre of mass on the symmetry axis 3 if `symmetric`; rates of one size times `spin`.
fn body(number: u64, is_top: bool, symmetric: bool, spin: f64) -> Body {
    let u = |block| uniforms([1, 2], block, number, 0);
    let [a, b, c, _] = u(0).map(|x| 0.2 + x);
    let [x, y, z, _] = u(1).map(|x| spin * (2.0 * x - 1.0));
    let [c1, c2, c3, _] = u(2).map(|x| if is_top { 2.0 * x - 1.0 } else { 0.0 });
    let attitude = attitude(Distribution::UniformAttitude, [0.0; 3], [1.0, 0.0, 0.0, 0.0], u(3));
    let (moments, weight) = match symmetric {
        true => ([a + b, a + b, 2.0 * a], [0.0, 0.0, c3]),
        false => ([b + c, c + a, a + b], [c1, c2, c3]),
    };
    Body { moments, weight, omega: [x, y, z], attitude }
}

fn numbers(states: &States, i: usize) -> (Vec<u64>, Status, u64) {
    let n = states.status.len();
    let fields = [&states.omega, &states.gamma, &states.attitude];
    let of_field = |field: &Vec<f64>| field[i * (field.len() / n)..][..field.len() / n].to_vec();
    let mut all: Vec<f64> = fields.into_iter().flatten().flat_map(of_field).collect();
    all.extend([states.energy_drift[i], states.momentum_drift[i], states.unit_drift[i]]);
    let bits = |x: f64| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
    (all.into_iter().map(bits).collect(), states.status[i], states.steps[i])
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt()
}

// --- Accuracy --------------------------------------------------------------------------------------------------

/// The omitted terms of a step are about as large as the tolerance, and a body turns by a few tenths of a radian in a
/// step. So the error of the attitude is less than the tolerance per radian, plus rounding. Forward and backward in
/// time, at times inside every step.
#[test]
fn the_error_follows_the_tolerance() {
    let times: Vec<f64> = (-40..=40).map(|k| 0.37 * f64::from(k)).collect();
    for is_top in [false, true] {
        let bodies: Vec<Body> = (0..64).map(|i| body(i, is_top, is_top, 2.0)).collect();
        for method in series() {
            for tolerance in [1e-6, 1e-9, 1e-12, 1e-15] {
                let case = case(&bodies, method, tolerance, &times);
                let (got, exact) = (case.adaptive_states(), case.exact_states());
                let mut worst = 0.0_f64;
                for (i, body) in bodies.iter().enumerate() {
                    assert_eq!(got.status[i], Status::Finished);
                    for k in 0..times.len() {
                        let [a, b] =
                            [&got, &exact].map(|s| &s.attitude.as_ref().unwrap()[4 * (81 * i + k)..][..4]);
                        worst = worst.max(
                            2.0 * distance(a, b)
                                / (1.0 + body.fastest_rate(BodyForces::NONE, [0.0; 2]) * times[k].abs()),
                        );
                    }
                }
                println!("{is_top} {} {tolerance:e}: {worst:.1e}", method.facts.name);
                assert!(worst < tolerance + 3e-15, "{method:?} {tolerance:e}: {worst:e}");
            }
        }
    }
}

/// More requested times need no more steps and change no state.
#[test]
fn dense_output_changes_no_step() {
    let bodies: Vec<Body> = (0..40).map(|i| body(i, true, false, 2.0)).collect();
    let many: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
    let few = [many[7], many[500], many[999]];
    let [many, few] =
        [&many[..], &few].map(|times| case(&bodies, &method::TAYLOR16, 1e-14, times).adaptive_states());
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

/// Free bodies or tops: one overflows, one is at rest, one needs more steps than allowed.
fn batch(is_top: bool) -> Vec<Body> {
    let mut bodies: Vec<Body> =
        (0..203).map(|i| body(i, is_top, i % 3 == 0, 1.0 + 3.0 * (i % 7) as f64 / 6.0)).collect();
    bodies[100].omega = [1e200, 1e200, 1.0];
    bodies[101].omega = [0.0; 3];
    bodies[103].omega = [3e3, 5e3, 1e3];
    bodies
}

#[test]
fn the_bits_of_a_body_do_not_depend_on_the_batch() {
    let times = [-0.7, 0.0, 0.3, 0.31, 20.0];
    for is_top in [false, true] {
        let bodies = batch(is_top);
        for (method, record) in
            series().zip([Record::Rates, Record::Axis, Record::Attitude].into_iter().cycle())
        {
            let run = |bodies: &[Body], threads, isa| {
                Case { record, max_steps: 3000, threads, isa, ..case(bodies, method, 1e-12, &times) }
                    .adaptive_states()
            };
            let isa = Isa::available()[0];
            let everything =
                |states: &States| (0..bodies.len()).map(|i| numbers(states, i)).collect::<Vec<_>>();
            let together = run(&bodies, 1, isa);
            let once = everything(&together);
            for isa in Isa::available() {
                assert_eq!(everything(&run(&bodies, 2, isa)), once, "{method:?} {isa:?}");
            }
            for i in 0..bodies.len() {
                assert_eq!(numbers(&run(&bodies[i..=i], 1, isa), 0), once[i], "{method:?} body {i}");
            }
            let mirrored: Vec<Body> = bodies.iter().rev().copied().collect();
            let mut mirrored = everything(&run(&mirrored, 3, isa));
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

/// A torque that ends within steps, which are then too long.
unsafe extern "C" fn torque(
    t: f64,
    omega: *const f64,
    attitude: *const f64,
    _data: *const f64,
    torque: *mut f64,
) {
    let on = if t.abs() < 1.0 { 0.5 } else { 0.0 };
    // SAFETY: the caller gives arrays of these lengths.
    unsafe { (0..3).for_each(|k| *torque.add(k) = on * *attitude.add(k + 1) - 0.1 * *omega.add(k)) }
}

/// A body whose step has too large an error tries again, while the bodies beside it go on: the steps of each are counted.
#[test]
fn the_bits_under_a_function_do_not_depend_on_the_batch() {
    let code = Code { address: torque as *const () as usize, is_of_eight: false, is_long: false };
    // SAFETY: the function is of this type.
    let function = unsafe { TorqueFunction::new(code, vec![], 0, vec![1.0], 0.0).unwrap() };
    let forces = &Forces::new(&[], &[], &[], &[]).unwrap().with_function(function).unwrap();
    let bodies: Vec<Body> = (0..40).map(|i| body(i, true, i % 3 == 0, 1.0 + (i % 7) as f64)).collect();
    for max_steps in [30, 1 << 40] {
        let run = |bodies: &[Body], isa| {
            let times = [-2.0, 0.5, 6.0];
            let case = case(bodies, &method::DOP853, 1e-9, &times);
            Case { forces, max_steps, isa, ..case }.adaptive_states()
        };
        let together = run(&bodies, Isa::available()[0]);
        for isa in Isa::available() {
            let others = run(&bodies, isa);
            for i in 0..bodies.len() {
                assert_eq!(numbers(&others, i), numbers(&together, i), "body {i} {isa:?}");
                assert_eq!(numbers(&run(&bodies[i..=i], isa), 0), numbers(&together, i), "body {i} {isa:?}");
            }
        }
        let (least, most) = (together.steps.iter().min().unwrap(), together.steps.iter().max().unwrap());
        let status = if max_steps == 30 { Status::StepLimit } else { Status::Finished };
        assert!(together.status.iter().all(|&found| found == status));
        assert!(if max_steps == 30 { [*least, *most] == [30; 2] } else { least < most }, "{least} {most}");
    }
}

// --- Refused requests ------------------------------------------------------------------------------------------

#[test]
fn refused_tolerances() {
    let bodies = [body(1, false, false, 1.0)];
    let refusal = |method: &'static Method, tolerance: f64| {
        let case = case(&bodies, method, tolerance, &[1.0]);
        let request = case.request(AnyMethod::Steps(method), &[0.1], Some(tolerance));
        simulate(&request, Call::to_the_end(Isa::NARROWEST, 1)).err().expect("refused").to_string()
    };
    for method in [&method::RK4, &method::SPLITTING] {
        assert!(refusal(method, 1e-9).contains("only the Taylor methods"));
    }
    for tolerance in [0.0, -1e-9, f64::NAN, f64::INFINITY, 1.0] {
        assert!(refusal(&method::TAYLOR12, tolerance).contains("must be positive and below one"));
    }
}
