//! Inverse incomplete beta function against 90-digit values (tests/golden/make_incomplete_beta.py), and confidence
//! intervals at their ends.

use rigid::map::clopper_pearson;
use rigid::special::inverse_incomplete_beta;

#[test]
fn the_inverse_incomplete_beta_function_has_its_golden_values() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/incomplete_beta.json");
    let rows: Vec<[f64; 5]> = serde_json::from_reader(std::fs::File::open(path).unwrap()).unwrap();
    assert!(rows.len() > 700);
    for [a, b, level, near, _] in rows {
        let got = inverse_incomplete_beta(a, b, level);
        // Worst at level 1e-6, a = 1, where the logarithms are some 14: their rounding is 2e-15.
        assert!((got / near - 1.0).abs() < 3e-15, "{a} {b} {level}: {got:e} instead of {near:e}");
    }
}

#[test]
fn intervals_of_few_bodies_are_roots() {
    // One body: P(success) = 0.025. All of n bodies: p^n = 0.025. None of them: (1 - p)^n = 0.025.
    assert_eq!(clopper_pearson(0, 0, 0.95).unwrap().map(f64::is_nan), [true; 2]);
    for trials in [1, 2, 4, 64] {
        let [lower, upper] = clopper_pearson(trials, trials, 0.95).unwrap();
        assert!(((0..trials).fold(1.0, |power, _| power * lower) - 0.025).abs() < 1e-15);
        assert_eq!(upper, 1.0);
        let [none, most] = clopper_pearson(0, trials, 0.95).unwrap();
        assert_eq!((none, most), (0.0, 1.0 - lower));
    }
}

/// `(1 - upper)^n = 0.025` with n = 2^50; the upper end is one minus a share, and rounded as such.
#[test]
fn the_largest_number_of_trials_has_an_interval() {
    let trials: u64 = 1 << 50;
    let [lower, upper] = clopper_pearson(0, trials, 0.95).unwrap();
    let expected = -(0.025_f64.ln()) / trials as f64;
    assert_eq!(lower, 0.0);
    assert!((upper - expected).abs() < f64::EPSILON);
}

#[test]
fn counts_that_cannot_be_have_no_interval() {
    let refused = [
        (clopper_pearson(2, 1, 0.95), "successes = 2 of 1: must be at most the trials"),
        (clopper_pearson(1, 2, 1.0), "confidence = 1: must lie between 0 and 1"),
        (clopper_pearson(1, 2, f64::NAN), "confidence = NaN: must lie between 0 and 1"),
        (clopper_pearson(1, 1 << 51, 0.95), "trials = 2251799813685248: must be at most 2^50"),
    ];
    for (interval, words) in refused {
        assert_eq!(interval.unwrap_err().to_string(), words);
    }
}
