//! Closed forms: on every instruction set, in every lane, at any number of times.

use super::*;
use crate::tests::scene_of;

/// Bodies of a closed form in its variables: ordinary ones, and beside them in the same registers those at every
/// border of its code: separatrices, near and met exactly, poles, turning points, stable axes, extreme units.
fn placed(kind: EvaluatorKind) -> Vec<Body> {
    let special = |number: u64| -> Body {
        let ordinary = body(number, kind == EvaluatorKind::Lagrange, kind != EvaluatorKind::Free);
        let tiny = 10.0_f64.powi(-((number / 14) as i32) - 4);
        let free = |moments, omega| Body { moments, omega, ..ordinary };
        let top = |theta: f64, omega: [f64; 3], mgl| {
            let attitude = [(0.5 * theta).cos(), (0.5 * theta).sin(), 0.0, 0.0];
            Body { moments: [1.0, 1.0, 0.5], weight: [0.0, 0.0, mgl], omega, attitude }
        };
        let upright = |q| Body { attitude: q, ..top(0.0, [1.5, -0.5, 6.0], 4.0) };
        match (kind, number % 14) {
            (EvaluatorKind::Free, 1) => free([1.0, 2.0, 3.0], [tiny, 1.0, tiny]),
            (EvaluatorKind::Free, 2) => free([3.0, 2.0, 1.0], [0.0, -1.0, tiny]),
            (EvaluatorKind::Free, 3) => free([1.0, 2.0, 2.25], [-0.375, 0.25, 0.5]),
            (EvaluatorKind::Free, 4) => free([1.0, 3.0, 2.0], [tiny, 1.0, -tiny]),
            (EvaluatorKind::Free, 5) => free([1.0, 1.0 + tiny, 1.5], [0.4, -0.3, 1.2]),
            (EvaluatorKind::Free, 6) => free([1e-150, 2e-150, 2.5e-150], [3e8, 1e8, -2e8]),
            (EvaluatorKind::Symmetric, 1) => free([1.5; 3], [0.3, 1.0, -2.0]),
            (EvaluatorKind::Symmetric, 2) => free([2.0, 2.0, 3.0], [0.0; 3]),
            (EvaluatorKind::Symmetric, 3) => free([2.0, 2.0, 3.0], [0.0, 0.0, -1e-200]),
            (EvaluatorKind::Symmetric, 4) => free([1.0, 1.0, 0.2], [tiny, 0.0, 1e3]),
            (EvaluatorKind::Lagrange, 1) => top(tiny, [0.0, 0.0, 3.0], 4.0),
            (EvaluatorKind::Lagrange, 2) => top(tiny, [0.0, 0.0, 12.0], 4.0),
            (EvaluatorKind::Lagrange, 3) => upright([1.0, 0.0, 0.0, 0.0]),
            (EvaluatorKind::Lagrange, 4) => upright([0.0, 0.6, 0.8, 0.0]),
            (EvaluatorKind::Lagrange, 5) => top(1.2, [0.0; 3], -4.0),
            (EvaluatorKind::Lagrange, 6) => top(1.2, [2.0, 0.0, 0.0], 4.0),
            (EvaluatorKind::Lagrange, 7) => top(1.2, [0.0, 0.7, 0.0], 4.0),
            (EvaluatorKind::Lagrange, 8) => top(1.2, [0.3, 0.7, 6.0], -4.0),
            // Through the bottom at the speed that just reaches the top.
            (EvaluatorKind::Lagrange, 9) => {
                Body { attitude: [0.0, 1.0, 0.0, 0.0], ..top(0.0, [4.0, 0.0, 0.0], 4.0) }
            }
            (EvaluatorKind::Lagrange, 10) => top(1.2, [2.0, 0.3, 1e5], 1e-4),
            _ => ordinary,
        }
    };
    let forms = (0..140).map(special).map(|body| (CanonicalForm::of(&body).unwrap(), body));
    let of_kind = forms.filter(|(form, _)| form.kind() == kind);
    let bodies: Vec<Body> = of_kind.map(|(form, body)| form.to_canonical(&body)).collect();
    assert!(bodies.len() >= 130, "{kind:?}: {}", bodies.len());
    bodies
}

const MOMENTS_OF_TIME: [f64; 6] = [2.0, -3.7, 0.0, 0.3, 41.3, 1e4];

/// What each lane is asked; see `Exit`.
fn asked(number: usize) -> [f64; 3] {
    [(number % 3) as f64, [0.05, 0.6, 1.0, 1.9][number % 4], [1.0, -1.0][number / 2 % 2]]
}

/// States, rates and exit of each lane: numbered bodies, the lanes at different times.
fn evaluated(kind: EvaluatorKind, isa: Isa, lanes: &[(usize, Body)]) -> Vec<Vec<u64>> {
    let mut starts = StartRows::filled(&lanes[0].1);
    let nothing = Row([0.0; LANES]);
    let mut exits = ExitRows { axis: nothing, limit: nothing, direction: nothing };
    let mut times = [nothing; MOMENTS_OF_TIME.len()];
    for (lane, (number, body)) in lanes.iter().enumerate() {
        starts.set(lane, body);
        let [axis, limit, direction] = asked(*number);
        (exits.axis.0[lane], exits.limit.0[lane], exits.direction.0[lane]) = (axis, limit, direction);
        for (k, row) in times.iter_mut().enumerate() {
            row.0[lane] = MOMENTS_OF_TIME[(k + number) % MOMENTS_OF_TIME.len()];
        }
    }
    let evaluator = Evaluator::new(kind, isa);
    let mut states = [StateRows::ZERO; MOMENTS_OF_TIME.len()];
    let mut rates = states;
    let mut left = nothing;
    evaluator.states(&starts, &times, &mut states);
    evaluator.rates(&starts, &times, &mut rates);
    evaluator.exits(&starts, &exits, &mut left);
    let of_lane = |lane: usize| {
        let of_state = |state: &StateRows| {
            let rows = state.omega.iter().chain(&state.attitude);
            rows.map(|row| bits(row.0[lane])).collect::<Vec<u64>>()
        };
        let mut numbers: Vec<u64> = states.iter().chain(&rates).flat_map(of_state).collect();
        numbers.push(bits(left.0[lane]));
        numbers
    };
    (0..lanes.len()).map(of_lane).collect()
}

/// A body in all lanes at once, and among others in every lane, has the same bits.
#[test]
fn closed_forms_on_every_instruction_set_and_in_every_lane() {
    for kind in [EvaluatorKind::Symmetric, EvaluatorKind::Free, EvaluatorKind::Lagrange] {
        let bodies: Vec<(usize, Body)> = placed(kind).into_iter().enumerate().collect();
        let alone = |it: &(usize, Body)| evaluated(kind, Isa::Scalar, &[*it; LANES]).swap_remove(0);
        let once: Vec<Vec<u64>> = bodies.iter().map(alone).collect();
        // A start that is no number would compare equal to anything that is none.
        let unknown = once.iter().flatten().filter(|&&x| x == f64::NAN.to_bits()).count();
        assert_eq!(unknown, 0, "{kind:?}");
        for isa in Isa::available() {
            for (it, expected) in bodies.iter().zip(&once) {
                for (lane, got) in evaluated(kind, isa, &[*it; LANES]).iter().enumerate() {
                    assert_eq!(got, expected, "{kind:?} {isa:?} lane {lane}: {it:?}");
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

/// What is said of a whole motion.
#[test]
fn derived_quantities_on_every_instruction_set() {
    for is_top in [false, true] {
        for body in exact_crowd(is_top) {
            // As text, which shows every bit of a number and in which a NaN equals itself.
            let told = |isa| {
                let changes: Vec<_> = (0..3).map(|axis| sign_changes(isa, &body, axis)).collect();
                let times: Vec<_> = [0.1, 1.0, 2.0].map(|limit| tilt_time(isa, &body, limit)).into();
                let quantities = (free_quantities(isa, &body), top_quantities(isa, &body));
                format!("{changes:?} {times:?} {quantities:?}")
            };
            let scalar = told(Isa::Scalar);
            for isa in Isa::available() {
                assert_eq!(told(isa), scalar, "{isa:?} {body:?}");
            }
        }
    }
}

/// Bodies with every closed form in turn, those of one code side by side and not.
fn exact_crowd(is_top: bool) -> Vec<Body> {
    let bodies = |i: u64| {
        let mut body = body(i, is_top, is_top || i.is_multiple_of(3) || i > 150);
        match i % 11 {
            // A spin, an upright top, a hanging one, a swing in a plane.
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

fn ask_exactly(
    (is_top, bodies): (bool, &[Body]),
    times: &[f64],
    record: Record,
    threads: usize,
    isa: Isa,
) -> States {
    let steps = vec![f64::NAN; bodies.len()];
    let (solver, schedule) = (Solver::Exact, Schedule::Times(times));
    let request = Request {
        bodies,
        scene: scene_of(is_top),
        forcing: Forcing::NONE,
        solver,
        record,
        schedule,
        steps: &steps,
        tolerance: None,
        refinement: 1.0,
        max_steps: 0,
    };
    simulate(&request, threads, isa, &GO).unwrap()
}

/// A body alone has its times in the lanes, a crowd has bodies in them.
#[test]
fn closed_forms_with_times_or_bodies_in_the_lanes() {
    let few = TIMES.to_vec();
    // More than are evaluated between two looks at the stop flag.
    let many: Vec<f64> = (0..300).map(|k| 0.37 * f64::from(k) - 40.0).collect();
    for is_top in [false, true] {
        let bodies = exact_crowd(is_top);
        for record in [Record::Rates, Record::Axis, Record::Attitude] {
            for times in [&few, &many] {
                let ask = |bodies: &[Body], threads, isa| {
                    ask_exactly((is_top, bodies), times, record, threads, isa)
                };
                let everything = |threads, isa| {
                    let states = ask(&bodies, threads, isa);
                    (0..bodies.len()).map(|i| of_body(&states, i)).collect::<Vec<_>>()
                };
                let once = everything(1, Isa::Scalar);
                assert!(once.iter().all(|body| body.1 == Status::Finished));
                for isa in Isa::available() {
                    for threads in [1, 2, 3] {
                        assert_eq!(everything(threads, isa), once, "{threads} threads, {isa:?}");
                    }
                    for i in 0..bodies.len() {
                        let alone = ask(&bodies[i..=i], 1, isa);
                        assert_eq!(of_body(&alone, 0), once[i], "body {i}, {isa:?}");
                    }
                }
            }
        }
    }
}

/// The state at a time does not depend on the other times, however many.
#[test]
fn closed_forms_at_any_number_of_times() {
    let times: Vec<f64> = (0..2 * 8192 + 5).map(|k| 0.01 * f64::from(k)).collect();
    for is_top in [false, true] {
        let bodies = &exact_crowd(is_top)[..2];
        let isa = Isa::available()[0];
        let omega =
            |times: &[f64]| ask_exactly((is_top, bodies), times, Record::Rates, 1, isa).rates().to_vec();
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

/// What else is recorded does not touch the rates.
#[test]
fn less_asked_of_closed_forms_is_the_same() {
    for is_top in [false, true] {
        let bodies = exact_crowd(is_top);
        let isa = Isa::available()[0];
        let ask = |record| ask_exactly((is_top, &bodies), &TIMES, record, 2, isa).rates().to_vec();
        let attitude = ask(Record::Attitude);
        for record in [Record::Rates, Record::Axis] {
            let less = ask(record);
            for (i, body) in bodies.iter().enumerate() {
                let [a, b] =
                    [&less, &attitude].map(|w| all_bits(&w[3 * TIMES.len() * i..][..3 * TIMES.len()]));
                assert_eq!(a, b, "{record:?} {body:?}");
            }
        }
    }
}
