//! Closed forms: on every instruction set, in every lane, at any number of times.

use super::*;
use crate::tests::scene_of;

/// Bodies of a closed form in canonical variables. Ordinary bodies are in the same registers as special ones: near and
/// exactly on separatrices, at poles and turning points, on stable axes, with extreme units.
fn canonical_bodies(kind: Evaluator) -> Vec<Body> {
    let special = |number: u64| -> Body {
        let ordinary = body(number, kind == Evaluator::Lagrange, kind != Evaluator::Free);
        let tiny = 10.0_f64.powi(-((number / 14) as i32) - 4);
        let free = |moments, omega| Body { moments, omega, ..ordinary };
        let top = |theta: f64, omega: [f64; 3], mgl| {
            let attitude = [(0.5 * theta).cos(), (0.5 * theta).sin(), 0.0, 0.0];
            Body { moments: [1.0, 1.0, 0.5], weight: [0.0, 0.0, mgl], omega, attitude }
        };
        let upright = |q| Body { attitude: q, ..top(0.0, [1.5, -0.5, 6.0], 4.0) };
        match (kind, number % 14) {
            (Evaluator::Free, 1) => free([1.0, 2.0, 3.0], [tiny, 1.0, tiny]),
            (Evaluator::Free, 2) => free([3.0, 2.0, 1.0], [0.0, -1.0, tiny]),
            (Evaluator::Free, 3) => free([1.0, 2.0, 2.25], [-0.375, 0.25, 0.5]),
            (Evaluator::Free, 4) => free([1.0, 3.0, 2.0], [tiny, 1.0, -tiny]),
            (Evaluator::Free, 5) => free([1.0, 1.0 + tiny, 1.5], [0.4, -0.3, 1.2]),
            (Evaluator::Free, 6) => free([1e-150, 2e-150, 2.5e-150], [3e8, 1e8, -2e8]),
            (Evaluator::Symmetric, 1) => free([1.5; 3], [0.3, 1.0, -2.0]),
            (Evaluator::Symmetric, 2) => free([2.0, 2.0, 3.0], [0.0; 3]),
            (Evaluator::Symmetric, 3) => free([2.0, 2.0, 3.0], [0.0, 0.0, -1e-200]),
            (Evaluator::Symmetric, 4) => free([1.0, 1.0, 0.2], [tiny, 0.0, 1e3]),
            (Evaluator::Lagrange, 1) => top(tiny, [0.0, 0.0, 3.0], 4.0),
            (Evaluator::Lagrange, 2) => top(tiny, [0.0, 0.0, 12.0], 4.0),
            (Evaluator::Lagrange, 3) => upright([1.0, 0.0, 0.0, 0.0]),
            (Evaluator::Lagrange, 4) => upright([0.0, 0.6, 0.8, 0.0]),
            (Evaluator::Lagrange, 5) => top(1.2, [0.0; 3], -4.0),
            (Evaluator::Lagrange, 6) => top(1.2, [2.0, 0.0, 0.0], 4.0),
            (Evaluator::Lagrange, 7) => top(1.2, [0.0, 0.7, 0.0], 4.0),
            (Evaluator::Lagrange, 8) => top(1.2, [0.3, 0.7, 6.0], -4.0),
            // Through the bottom, with the speed at which the body just reaches the top.
            (Evaluator::Lagrange, 9) => {
                Body { attitude: [0.0, 1.0, 0.0, 0.0], ..top(0.0, [4.0, 0.0, 0.0], 4.0) }
            }
            (Evaluator::Lagrange, 10) => top(1.2, [2.0, 0.3, 1e5], 1e-4),
            _ => ordinary,
        }
    };
    let forms = (0..140).map(special).map(|body| (CanonicalForm::of(&body).unwrap(), body));
    let of_kind = forms.filter(|(form, _)| form.evaluator() == kind);
    let bodies: Vec<Body> = of_kind.map(|(form, body)| form.to_canonical(&body)).collect();
    assert!(bodies.len() >= 130, "{kind:?}: {}", bodies.len());
    bodies
}

const EVALUATION_TIMES: [f64; 6] = [2.0, -3.7, 0.0, 0.3, 41.3, 1e4];

/// The exit that is computed for a lane.
fn exit_of(number: usize) -> Exit<f64> {
    let limit = [0.05, 0.6, 1.0, 1.9][number % 4];
    let direction = [1.0, -1.0][number / 2 % 2];
    Exit { axis: (number % 3) as f64, limit: [limit, 2.0 - limit], direction }
}

/// States, rates and exit of each lane; the times differ between lanes.
fn evaluated(kind: Evaluator, isa: Isa, lanes: &[(usize, Body)]) -> Vec<Vec<u64>> {
    let mut starts = StartRows::filled(&lanes[0].1);
    let nothing = Row([0.0; LANES]);
    let mut exits = Exit::ZERO;
    let mut times = [nothing; EVALUATION_TIMES.len()];
    for (lane, (number, body)) in lanes.iter().enumerate() {
        starts.set(lane, body);
        exits.set(lane, exit_of(*number));
        for (k, row) in times.iter_mut().enumerate() {
            row.0[lane] = EVALUATION_TIMES[(k + number) % EVALUATION_TIMES.len()];
        }
    }
    let mut states = [StateRows::ZERO; EVALUATION_TIMES.len()];
    let mut rates = states;
    let mut exit_times = nothing;
    kind.states(isa, &starts, &times, &mut states);
    kind.rates(isa, &starts, &times, &mut rates);
    kind.exits(isa, &starts, &exits, &mut exit_times);
    let of_lane = |lane: usize| {
        let of_state = |state: &StateRows| {
            let rows = state.omega.iter().chain(&state.attitude);
            rows.map(|row| bits(row.0[lane])).collect::<Vec<u64>>()
        };
        let mut numbers: Vec<u64> = states.iter().chain(&rates).flat_map(of_state).collect();
        numbers.push(bits(exit_times.0[lane]));
        numbers
    };
    (0..lanes.len()).map(of_lane).collect()
}

/// A body in all lanes, and a body in any lane with other bodies, have the same bits.
#[test]
fn closed_forms_on_every_instruction_set_and_in_every_lane() {
    for kind in [Evaluator::Symmetric, Evaluator::Free, Evaluator::Lagrange] {
        let bodies: Vec<(usize, Body)> = canonical_bodies(kind).into_iter().enumerate().collect();
        let alone = |numbered_body: &(usize, Body)| {
            evaluated(kind, Isa::NARROWEST, &[*numbered_body; LANES]).swap_remove(0)
        };
        let once: Vec<Vec<u64>> = bodies.iter().map(alone).collect();
        // A NaN would compare equal to any NaN.
        let unknown = once.iter().flatten().filter(|&&x| x == f64::NAN.to_bits()).count();
        assert_eq!(unknown, 0, "{kind:?}");
        for isa in Isa::available() {
            for (numbered_body, expected) in bodies.iter().zip(&once) {
                for (lane, got) in evaluated(kind, isa, &[*numbered_body; LANES]).iter().enumerate() {
                    assert_eq!(got, expected, "{kind:?} {isa:?} lane {lane}: {numbered_body:?}");
                }
            }
            for shift in 0..LANES {
                let mut shifted = bodies.clone();
                shifted.rotate_left(shift);
                for lanes in shifted.chunks(LANES) {
                    for ((number, body), got) in lanes.iter().zip(evaluated(kind, isa, lanes)) {
                        assert_eq!(got, once[*number], "{kind:?} {isa:?} shift {shift}: {body:?}");
                    }
                }
            }
        }
    }
}

/// Derived quantities of a motion.
#[test]
fn derived_quantities_on_every_instruction_set() {
    for is_top in [false, true] {
        for body in exact_batch(is_top) {
            // As text, which shows every bit of a number, and in which all NaN are equal.
            let quantities_as_text = |isa| {
                let changes: Vec<_> = (0..3).map(|axis| sign_changes(isa, &body, axis)).collect();
                let times: Vec<_> = [0.1, 1.0, 2.0].map(|limit| tilt_time(isa, &body, limit)).into();
                let quantities = (free_quantities(isa, &body), top_quantities(isa, &body));
                format!("{changes:?} {times:?} {quantities:?}")
            };
            let scalar = quantities_as_text(Isa::NARROWEST);
            for isa in Isa::available() {
                assert_eq!(quantities_as_text(isa), scalar, "{isa:?} {body:?}");
            }
        }
    }
}

/// Bodies with every closed form in turn, some with the same evaluator side by side.
fn exact_batch(is_top: bool) -> Vec<Body> {
    let bodies = |i: u64| {
        let mut body = body(i, is_top, is_top || i.is_multiple_of(3) || i > 150);
        match i % 11 {
            // A permanent rotation, an upright top, a hanging top, a planar pendulum.
            3 if !is_top => body.omega = [0.0, 0.7, 0.0],
            3 => {
                body = Body { weight: [0.0, 0.0, 1.5], moments: [1.0, 1.0, 1.2], ..body };
                (body.omega, body.attitude) = ([0.0, 0.0, 2.0], [0.6, 0.0, 0.0, 0.8]);
            }
            5 if is_top => {
                body = Body { moments: [1.0, 1.4, 0.9], weight: [0.0, 0.3, -0.7], ..body };
                (body.omega, body.attitude) = ([1.5, 0.0, 0.0], [0.8, 0.6, 0.0, 0.0]);
            }
            _ => {}
        }
        body
    };
    (0..203).map(bodies).collect()
}

fn closed_form(
    (is_top, bodies): (bool, &[Body]),
    times: &[f64],
    record: Record,
    threads: usize,
    isa: Isa,
) -> States {
    let steps = vec![f64::NAN; bodies.len()];
    let (method, schedule) = (AnyMethod::Exact, Schedule::Times(times));
    let request = Request {
        bodies,
        scene: scene_of(is_top),
        forces: Forces::NONE,
        method,
        record,
        schedule,
        steps: &steps,
        tolerance: None,
        refinement: 1.0,
        max_steps: 0,
    };
    simulate(&request, Call::to_the_end(isa, threads)).unwrap()
}

/// The lanes contain the times of a single body, or the bodies of a batch.
#[test]
fn closed_forms_with_times_or_bodies_in_the_lanes() {
    let few = TIMES.to_vec();
    // More times than are evaluated between two checks of the stop flag.
    let many: Vec<f64> = (0..300).map(|k| 0.37 * f64::from(k) - 40.0).collect();
    for is_top in [false, true] {
        let bodies = exact_batch(is_top);
        for record in [Record::Rates, Record::Axis, Record::Attitude] {
            for times in [&few, &many] {
                let solve = |bodies: &[Body], threads, isa| {
                    closed_form((is_top, bodies), times, record, threads, isa)
                };
                let everything = |threads, isa| {
                    let states = solve(&bodies, threads, isa);
                    (0..bodies.len()).map(|i| of_body(&states, i)).collect::<Vec<_>>()
                };
                let once = everything(1, Isa::NARROWEST);
                assert!(once.iter().all(|body| body.1 == Status::Finished));
                for isa in Isa::available() {
                    for threads in [1, 2, 3] {
                        assert_eq!(everything(threads, isa), once, "{threads} threads, {isa:?}");
                    }
                    for i in 0..bodies.len() {
                        let alone = solve(&bodies[i..=i], 1, isa);
                        assert_eq!(of_body(&alone, 0), once[i], "body {i}, {isa:?}");
                    }
                }
            }
        }
    }
}

/// The state at a time does not depend on the other times.
#[test]
fn closed_forms_at_any_number_of_times() {
    let times: Vec<f64> = (0..2 * 8192 + 5).map(|k| 0.01 * f64::from(k)).collect();
    for is_top in [false, true] {
        let bodies = &exact_batch(is_top)[..2];
        let isa = Isa::available()[0];
        let omega =
            |times: &[f64]| closed_form((is_top, bodies), times, Record::Rates, 1, isa).rates().to_vec();
        let all = omega(&times);
        for at in [0, 1, 31, 8191, 8192, 16383, 16384, 16388] {
            let single = omega(&times[at..=at]);
            for body in 0..2 {
                let in_all = &all[3 * (body * times.len() + at)..][..3];
                assert_eq!(all_bits(&single[3 * body..][..3]), all_bits(in_all), "body {body}, time {at}");
            }
        }
    }
}

/// Records do not change the rates.
#[test]
fn records_change_no_rates_of_closed_forms() {
    for is_top in [false, true] {
        let bodies = exact_batch(is_top);
        let isa = Isa::available()[0];
        let solve = |record| closed_form((is_top, &bodies), &TIMES, record, 2, isa).rates().to_vec();
        let attitude = solve(Record::Attitude);
        for record in [Record::Rates, Record::Axis] {
            let less = solve(record);
            for (i, body) in bodies.iter().enumerate() {
                let [a, b] =
                    [&less, &attitude].map(|w| all_bits(&w[3 * TIMES.len() * i..][..3 * TIMES.len()]));
                assert_eq!(a, b, "{record:?} {body:?}");
            }
        }
    }
}
