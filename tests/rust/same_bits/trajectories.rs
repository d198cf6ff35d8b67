//! Trajectories: alone and in a batch, on any number of threads and instruction set.

use super::*;

#[test]
fn a_body_alone_and_in_a_batch() {
    let isa = Isa::available()[0];
    for case in cases() {
        let bodies = batch(case.is_top);
        let steps = step_lengths(bodies.len());
        let together = case.integrate(&bodies, &steps, 1, isa);
        for i in 0..bodies.len() {
            let alone = case.integrate(&bodies[i..=i], &steps[i..=i], 1, isa);
            assert_eq!(of_body(&alone, 0), of_body(&together, i), "body {i}, {:?}", case.method.facts.name);
        }

        let mut mirrored = (bodies.clone(), steps.clone());
        mirrored.0.reverse();
        mirrored.1.reverse();
        let mirrored = case.integrate(&mirrored.0, &mirrored.1, 1, isa);
        for i in 0..bodies.len() {
            assert_eq!(of_body(&mirrored, bodies.len() - 1 - i), of_body(&together, i), "body {i}");
        }

        // Every status occurs: a step of 0.003 needs 900 steps for these times.
        let count = |status| together.status.iter().filter(|&&s| s == status).count();
        assert!(count(Status::NotFinite) >= 1 && count(Status::Finished) > 100);
        assert_eq!(count(Status::StepLimit), if case.at_times { 51 } else { 0 });
    }
}

#[test]
fn trajectories_on_any_number_of_threads_and_instruction_set() {
    for case in cases() {
        let bodies = batch(case.is_top);
        let steps = step_lengths(bodies.len());
        let everything = |threads, isa| {
            let states = case.integrate(&bodies, &steps, threads, isa);
            (0..bodies.len()).map(|i| of_body(&states, i)).collect::<Vec<_>>()
        };
        let once = everything(1, Isa::NARROWEST);
        for threads in [1, 2, 3, 7] {
            assert_eq!(everything(threads, Isa::available()[0]), once, "{threads} threads");
        }
        for isa in Isa::available() {
            assert_eq!(everything(2, isa), once, "{isa:?}");
        }
    }
}

/// Records change neither the rates nor the vertical of a top. Runge-Kutta steps of a top read the vertical from the
/// quaternion where the attitude is recorded: there the records without it are compared with each other.
#[test]
fn records_change_no_rates() {
    let isa = Isa::available()[0];
    for is_top in [false, true] {
        for method in methods(is_top) {
            let bodies = batch(is_top);
            let steps = step_lengths(bodies.len());
            let integrate =
                |record| Case { is_top, method, record, at_times: true }.integrate(&bodies, &steps, 2, isa);
            let by_quaternion = is_top && System::TopTurns.is_moved_by(method.any);
            let most = if by_quaternion { Record::Axis } else { Record::Attitude };
            let whole = integrate(most);
            for record in [Record::Rates, Record::Axis] {
                let less = integrate(record);
                assert_eq!(all_bits(less.rates()), all_bits(whole.rates()), "{record:?} {method:?} {is_top}");
                if is_top && record == Record::Axis {
                    let gammas = [&less, &whole].map(|s| all_bits(s.gamma.as_ref().unwrap()));
                    assert_eq!(gammas[0], gammas[1], "{method:?}");
                }
            }
        }
    }
}
