//! A short run of each bench, and what benches refuse.

// Each bench is a program of its own.
#![allow(clippy::duplicate_mod)]

#[path = "../../benches/closed_forms.rs"]
mod closed_forms;
#[path = "../../benches/kernels.rs"]
mod kernels;
#[path = "../../benches/timing.rs"]
mod timing;

use rigid::parallel::thread_nanoseconds;
use rigid::simd::Isa;

#[test]
fn each_kernel_of_the_bench_moves_all_its_bodies() {
    // Two engines; the whole list takes minutes in a build with checks.
    for engine in ["Rk4", "KickRotor"] {
        // Beside other work a single repeat may time the peak of the machine as less than it is.
        let rows = (0..20).find_map(|_| kernels::print_rows(Some(engine), 1).ok());
        assert!(rows >= Some(6 * Isa::available().len()), "{engine}: {rows:?} rows");
    }
}

#[test]
fn the_bench_of_closed_forms_computes_states() {
    // Of one repeat noise may leave a difference of two times that is not positive.
    let rows = (0..20).find_map(|_| closed_forms::print_rows(3).ok());
    assert_eq!(rows, Some(9 * Isa::available().len()));
}

#[test]
fn what_no_machine_can_do_is_refused() {
    assert!(timing::share(1.02, 1.0).unwrap_err().contains("must lie between 0 and 1"));
    assert!(timing::share(f64::NAN, 1.0).is_err());
    assert_eq!(timing::share(0.5, 1.0), Ok(0.5));
    assert!(timing::timed(|| ()).unwrap_err().contains("the clock tells"));
    let work = || {
        let begin = thread_nanoseconds();
        while thread_nanoseconds() < begin + 10_000_000 {}
    };
    assert!(timing::timed(work).unwrap() >= 1e7);
    assert!(timing::changed(&[1.0, 2.0], &[1.5, 2.0]).unwrap_err().contains("number 1 of the result is 2"));
    assert!(timing::changed(&[1.0], &[f64::NAN]).is_err());
    assert_eq!(timing::changed(&[1.0, 2.0], &[1.5, 2.5]), Ok(()));
    assert!(timing::positive(&[1.0, -0.5]).unwrap_err().contains("-0.5"));
}
