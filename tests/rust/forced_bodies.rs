//! Bodies under torque and damping: the same bits on every instruction set, in every lane and on any number of threads;
//! and refused requests.

use crate::tests::scene_of;
use rigid::body::Body;
use rigid::call::Call;
use rigid::forces::Forces;
use rigid::kernel::{Compiled, Kernel, System};
use rigid::kernel::{Entry, KernelAssignment, load};
use rigid::kernel::{ForcesRows, Group};
use rigid::method::{self, AnyMethod, Method, Step};
use rigid::observe::Observed;
use rigid::sample::{Distribution, attitude, uniforms};
use rigid::scene::FREE;
use rigid::simd::Isa;
use rigid::simd::LANES;
use rigid::status::Status;
use rigid::trajectory::{Record, Request, Schedule, States, simulate};

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }).collect()
}

/// A random tumbling body, determined by `number`.
fn body(number: u64, is_top: bool) -> Body {
    let u = |block| uniforms([5, 6], block, number, 0);
    let [a, b, c, _] = u(0).map(|x| 0.2 + x);
    let [x, y, z, _] = u(1).map(|x| 4.0 * x - 2.0);
    let weight = if is_top { u(2).map(|x| 2.0 * x - 1.0)[..3].try_into().unwrap() } else { [0.0; 3] };
    let attitude = attitude(Distribution::UniformAttitude, [0.0; 3], [1.0, 0.0, 0.0, 0.0], u(3));
    Body { moments: [b + c, c + a, a + b], weight, omega: [x, y, z], attitude }
}

/// A torque that changes and jumps, and damping whose axes are not the body axes.
fn table(in_space: bool) -> Forces {
    let times = [-3.0, -0.5, 0.25, 0.25, 1.1, 4.0];
    let values: Vec<[f64; 3]> =
        (0..6).map(|k| uniforms([7, 8], 0, k, 0).map(|x| 3.0 * x - 1.5)[..3].try_into().unwrap()).collect();
    let zeros = [[0.0; 3]; 6];
    let space: &[[f64; 3]] = if in_space { &values } else { &zeros };
    Forces::new(&times, &values, space, &[[0.3, 0.2, 0.4, 0.05, -0.1, 0.02]]).unwrap()
}

fn forced_methods() -> Vec<&'static Method> {
    method::ALL.iter().copied().filter(|method| method.damping_limit().is_some()).collect()
}

#[test]
fn every_kernel_on_every_instruction_set_and_in_every_lane() {
    use System::{ForcedAxis, ForcedFrame, ForcedRates, ForcedTurns};
    for system in [ForcedRates, ForcedAxis, ForcedFrame, ForcedTurns] {
        let forced: Vec<Step> = forced_methods().iter().map(|method| method.forced.unwrap().step).collect();
        for step in forced.into_iter().filter(|&step| system.is_moved_by(step)) {
            let kernel = Kernel { system, step, observed: Observed::Nothing };
            let mut assignments = forced_methods().into_iter().map(KernelAssignment::of_forced);
            let assignment =
                assignments.find(|assignment| assignment.step == step).expect("a method for every step");
            let put =
                |group: &mut Group, forces_rows: &mut ForcesRows, lane: usize, number: usize, compiled| {
                    let mut body = body(number as u64, system != ForcedRates);
                    if number == 7 {
                        body.omega = [1e18; 3];
                    }
                    let step = if number == 3 { 0.0 } else { 0.02 + 0.002 * number as f64 };
                    let forces = table(number.is_multiple_of(2));
                    let forces = forces.of(0);
                    let entry = Entry::unobserved(&body, forces, (0.0, None), None, step);
                    load(group, lane, compiled, assignment, &entry);
                    let modes = forces.damping.modes(body.moments);
                    let interval = forces.interval(0.01 * number as f64, false, modes);
                    forces_rows.set(lane, &interval);
                };
            let full_group = |isa| {
                let compiled = Compiled::new(kernel, isa);
                let (mut group, mut forces_rows) = (Group::inactive(), ForcesRows::NONE);
                for lane in 0..LANES {
                    put(&mut group, &mut forces_rows, lane, lane, compiled);
                }
                for steps in [1, 5, 14] {
                    compiled.advance(&mut group, &forces_rows, steps);
                }
                group
            };
            let of_lane = |group: &Group, lane: usize| {
                bits(
                    &group.state.iter().chain(&group.compensation).map(|row| row.0[lane]).collect::<Vec<_>>(),
                )
            };
            let scalar = full_group(Isa::NARROWEST);
            for isa in Isa::available() {
                let group = full_group(isa);
                for lane in 0..LANES {
                    assert_eq!(of_lane(&group, lane), of_lane(&scalar, lane), "{kernel:?} {isa:?} {lane}");
                    let finite = group.state[..system.len].iter().all(|row| row.0[lane].is_finite());
                    assert_eq!(finite, lane != 7, "{kernel:?} {lane}");
                }
                let compiled = Compiled::new(kernel, isa);
                for number in [0, 3, 12, 31] {
                    let (mut group, mut forces_rows) = (Group::inactive(), ForcesRows::NONE);
                    let lane = (number + 17) % LANES;
                    put(&mut group, &mut forces_rows, lane, number, compiled);
                    for steps in [1, 5, 14] {
                        compiled.advance(&mut group, &forces_rows, steps);
                    }
                    assert_eq!(of_lane(&group, lane), of_lane(&scalar, number), "{kernel:?} {isa:?}");
                }
            }
        }
    }
}

const TIMES: [f64; 6] = [-2.9, -0.7, 0.0, 0.25, 0.31, 3.9];

fn integrate(
    method: &'static Method,
    record: Record,
    tolerance: Option<f64>,
    (bodies, is_top): (&[Body], bool),
    threads: usize,
    isa: Isa,
) -> States {
    let steps: Vec<f64> = (0..bodies.len()).map(|i| [0.03, 0.05, 0.02, 0.04][i % 4]).collect();
    let request = Request {
        bodies,
        scene: scene_of(is_top),
        forces: &table(is_top),
        method: AnyMethod::Steps(method),
        record,
        schedule: Schedule::Times(&TIMES),
        steps: &steps,
        tolerance,
        refinement: 1.0,
        max_steps: 5000,
    };
    simulate(&request, Call::to_the_end(isa, threads)).unwrap()
}

fn all_bits(states: &States) -> Vec<u64> {
    let mut numbers = states.rates().to_vec();
    for column in [&states.gamma, &states.attitude, &states.work].into_iter().flatten() {
        numbers.extend(column);
    }
    for column in [&states.energy_drift, &states.momentum_drift, &states.unit_drift] {
        numbers.extend(column);
    }
    numbers.extend(states.steps.iter().map(|&steps| steps as f64));
    bits(&numbers)
}

#[test]
fn trajectories_have_the_same_bits_everywhere_and_alone() {
    for is_top in [false, true] {
        let bodies: Vec<_> = (0..40).map(|i| body(i, is_top)).collect();
        for method in forced_methods() {
            for record in [Record::Rates, Record::Axis, Record::Attitude] {
                let adaptive = method.is_series().then_some(Some(1e-12));
                for tolerance in [Some(None), adaptive].into_iter().flatten() {
                    let first = integrate(method, record, tolerance, (&bodies, is_top), 1, Isa::NARROWEST);
                    assert!(
                        first.status.iter().all(|&s| s == Status::Finished),
                        "{method:?} {:?}",
                        first.status
                    );
                    for isa in Isa::available() {
                        let again = integrate(method, record, tolerance, (&bodies, is_top), 3, isa);
                        assert_eq!(all_bits(&first), all_bits(&again), "{method:?} {isa:?}");
                    }
                    let alone =
                        integrate(method, record, tolerance, (&bodies[..1], is_top), 1, Isa::NARROWEST);
                    assert_eq!(bits(&first.rates()[..18]), bits(alone.rates()), "{method:?}");
                }
            }
        }
    }
}

/// Bodies whose forcing is of all kinds, with the moments of damping and the torques at two times that each body has:
/// rotations about one axis, where many coefficients are zeros with a sign, a body at rest, and one that overflows.
fn of_all_kinds(is_top: bool) -> (Vec<Body>, Forces) {
    let (none, along, against, turning) =
        ([[0.0; 3]; 2], [[0.1; 3], [0.4; 3]], [[0.1; 3], [-0.4, 0.0, -0.0]], [[0.2, -0.1, 0.3]; 2]);
    let (weak, undamped) = ([1e-3, 2e-3, 3e-3, 0.0, 0.0, 0.0], [0.0; 6]);
    let kinds = [
        (None, none, none, weak),
        (Some([0.0, 0.0, 2.0]), none, none, weak),
        (Some([0.0, -2.0, -0.0]), none, none, weak),
        (Some([0.0; 3]), [[0.0, 0.1, 0.0]; 2], none, weak),
        (Some([-0.0; 3]), [[0.0, 0.0, -0.1], [0.0; 3]], none, undamped),
        (Some([0.0, 0.0, -1.0]), along, none, undamped),
        (None, against, none, undamped),
        (None, none, turning, weak),
        (Some([0.0, 1.0, 0.0]), none, [[0.0; 3], [0.0, 0.0, 0.2]], undamped),
        (Some([1e200, 1e200, 1.0]), none, none, weak),
    ];
    let bodies = kinds.iter().enumerate().map(|(i, &(omega, ..))| {
        let body = body(i as u64, is_top);
        Body { omega: omega.unwrap_or(body.omega), ..body }
    });
    let in_body: Vec<[f64; 3]> = kinds.iter().flat_map(|&(_, body, ..)| body).collect();
    let in_space: Vec<[f64; 3]> = kinds.iter().flat_map(|&(_, _, space, _)| space).collect();
    let dampings: Vec<[f64; 6]> = kinds.iter().map(|&(.., damping)| damping).collect();
    let forces = Forces::new(&[-3.0, 4.0], &in_body, &in_space, &dampings).unwrap();
    (bodies.collect(), forces)
}

/// A body alone has registers of its own, and zero parts of its torque are skipped. Beside others it shares a register
/// with bodies that have all parts.
#[test]
fn adaptive_steps_of_a_body_alone_are_those_beside_others() {
    for is_top in [false, true] {
        let (bodies, all) = of_all_kinds(is_top);
        for method in method::ALL.iter().copied().filter(|method| method.is_series()) {
            for record in [Record::Rates, Record::Attitude] {
                let run = |bodies: &[Body], forces: &Forces, isa| {
                    let request = Request {
                        bodies,
                        scene: scene_of(is_top),
                        forces,
                        method: AnyMethod::Steps(method),
                        record,
                        schedule: Schedule::Times(&TIMES),
                        steps: &vec![0.03; bodies.len()],
                        tolerance: Some(1e-12),
                        refinement: 1.0,
                        max_steps: 5000,
                    };
                    simulate(&request, Call::to_the_end(isa, 1)).unwrap()
                };
                let together = run(&bodies, &all, Isa::NARROWEST);
                let lost = together.status.iter().position(|&status| status != Status::Finished);
                assert_eq!(lost, Some(bodies.len() - 1), "{method:?} {:?}", together.status);
                for isa in Isa::available() {
                    assert_eq!(all_bits(&run(&bodies, &all, isa)), all_bits(&together), "{method:?} {isa:?}");
                    for i in 0..bodies.len() {
                        let alone = run(&bodies[i..=i], &all.of_some(&[i]).unwrap(), isa);
                        let expected = run(&bodies[i..=i], &all.of_some(&[i]).unwrap(), Isa::NARROWEST);
                        assert_eq!(all_bits(&alone), all_bits(&expected), "{method:?} {isa:?} body {i}");
                        let beside = &together.rates()[18 * i..][..18];
                        assert_eq!(bits(alone.rates()), bits(beside), "{method:?} {isa:?} body {i}");
                        assert_eq!(alone.status[0], together.status[i], "{method:?} {isa:?} body {i}");
                        let pairs = [(&alone.attitude, &together.attitude), (&alone.work, &together.work)];
                        for (own, shared) in pairs {
                            if let (Some(own), Some(shared)) = (own, shared) {
                                let shared = &shared[own.len() * i..][..own.len()];
                                assert_eq!(bits(own), bits(shared), "{method:?} {isa:?} body {i}");
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Steps that end at a knot lose neither order nor accuracy.
#[test]
fn steps_of_a_series_end_at_knots() {
    for is_top in [false, true] {
        let bodies: Vec<_> = (0..8).map(|i| body(i, is_top)).collect();
        let at = |method, tolerance| {
            integrate(method, Record::Attitude, tolerance, (&bodies, is_top), 1, Isa::NARROWEST)
        };
        let fixed = at(&method::TAYLOR26, None);
        for method in method::ALL.iter().copied().filter(|method| method.is_series()) {
            let own = at(method, Some(1e-16));
            // Rounding of some hundred steps, of motions that grow an error no more than ten times in this time.
            for (a, b) in own.rates().iter().zip(fixed.rates()) {
                assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{method:?}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_torque_table_is_read_from_both_sides_of_a_jump() {
    let forces = Forces::new(
        &[0.0, 1.0, 1.0, 3.0],
        &[[0.0; 3], [2.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        &[[0.0; 3]; 4],
        &[[0.0; 6]],
    )
    .unwrap();
    let forces = forces.of(0);
    let at = |time, backward| {
        let interval = forces.interval(time, backward, forces.damping.modes([1.0, 2.0, 3.0]));
        [interval.body[0][0], interval.body[1][0]]
    };
    assert_eq!(at(0.0, false), [0.0, 2.0]);
    assert_eq!(at(0.5, true), [1.0, 2.0]);
    assert_eq!(at(1.0, true), [2.0, 2.0]);
    assert_eq!(at(1.0, false), [5.0, -2.0]);
    assert_eq!(at(3.0, true), [1.0, -2.0]);
    assert_eq!(forces.table.next_knot(0.0, false), Some(1.0));
    assert_eq!(forces.table.next_knot(1.0, false), Some(3.0));
    assert_eq!(forces.table.next_knot(1.0, true), Some(0.0));
    assert_eq!(forces.table.next_knot(3.0, false), None);
    assert!(forces.table.check_reaches(3.0).is_ok() && forces.table.check_reaches(3.1).is_err());
}

/// The eigenvalues of `I^(-1) D` against those of matrices with known eigenvalues.
#[test]
fn damping_rates_of_known_matrices() {
    let rates = |damping, moments| {
        Forces::new(&[], &[[0.0; 3]], &[[0.0; 3]], &[damping]).unwrap().of(0).damping.rates(moments)
    };
    assert_eq!(rates([1.0, 3.0, 2.0, 0.0, 0.0, 0.0], [1.0, 2.0, 4.0]), [0.5, 1.0, 1.5]);
    // ((2, -1, 0), (-1, 2, -1), (0, -1, 2)) has the eigenvalues 2 and 2 -+ sqrt 2.
    let [a, b, c] = rates([2.0, 2.0, 2.0, -1.0, 0.0, -1.0], [1.0; 3]);
    for (rate, known) in [(a, 2.0 - 2.0_f64.sqrt()), (b, 2.0), (c, 2.0 + 2.0_f64.sqrt())] {
        assert!((rate - known).abs() < 1e-15 * 4.0, "{rate} {known}");
    }
    // A dyad has one rate that is not zero.
    let [a, b, c] = rates([1.0, 4.0, 9.0, 6.0, 3.0, 2.0], [1.0; 3]);
    assert!(a.abs() < 1e-14 && b.abs() < 1e-14 && (c - 14.0).abs() < 1e-14 * 14.0);
}

#[test]
fn damping_that_adds_energy_and_unstable_steps_are_refused() {
    let make = |damping| Forces::new(&[], &[[0.0; 3]], &[[0.0; 3]], &[damping]);
    assert!(make([1.0, 1.0, 1.0, 2.0, 0.0, 0.0]).unwrap_err().to_string().contains("positive semi-definite"));
    assert!(make([1.0, f64::NAN, 1.0, 0.0, 0.0, 0.0]).unwrap_err().to_string().contains("finite"));
    let stiff = make([1e3, 1e3, 1e3, 0.0, 0.0, 0.0]).unwrap();
    let bodies = [body(0, false)];
    for method in method::ALL {
        let run = |step: f64| {
            let request = Request {
                bodies: &bodies,
                scene: &FREE,
                forces: &stiff,
                method: AnyMethod::Steps(method),
                record: Record::Rates,
                schedule: Schedule::Times(&[1.0]),
                steps: &[step],
                tolerance: None,
                refinement: 1.0,
                max_steps: 100_000,
            };
            simulate(&request, Call::to_the_end(Isa::NARROWEST, 1))
        };
        let [.., rate] = stiff.of(0).damping.rates(bodies[0].moments);
        match method.damping_limit() {
            None => assert!(run(1e-4).is_err_and(|e| e.to_string().contains("without torque and damping"))),
            Some(limit) if limit.is_finite() => {
                let refused = run(1.01 * limit / rate);
                assert!(
                    refused.is_err_and(|e| e.to_string().contains("unstable under damping")),
                    "{method:?}"
                );
                // Just inside the limit everything dies, as it should.
                let states = run(0.99 * limit / rate).unwrap();
                assert!(states.rates().iter().all(|w| w.abs() < 0.1), "{method:?} {:?}", states.omega);
            }
            Some(_) => assert!(run(0.1).is_ok()),
        }
    }
}
