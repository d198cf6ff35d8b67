//! Maps, for any division of the work.

use super::*;

const SAMPLES: u64 = 1000;

/// Pixels with and without symmetry; one has impossible moments, one overflows or needs too many steps.
fn map(is_top: bool, method: AnyMethod, criterion: Criterion, step: Option<f64>) -> Map {
    let pixel = |number, symmetric| Pixel {
        body: body(number, is_top, symmetric),
        omega_size: [0.3, 0.2, 0.1],
        attitude_size: [0.1; 3],
        possible: true,
    };
    let mut pixels = vec![pixel(1, false), pixel(2, true), pixel(5, false), pixel(6, false), pixel(7, false)];
    pixels[2].possible = false;
    pixels[3].body.omega = [1e17; 3];
    Map {
        scene: scene_of(is_top),
        forces: None,
        method,
        pixels,
        distributions: Distributions {
            omega: Distribution::Normal,
            attitude: Distribution::Direction,
            ..Distributions::NONE
        },
        mixture: Vec::new(),
        conditions: vec![Condition { criterion, axis: -2 }],
        logic: Logic::parse("0", 1).unwrap(),
        measures: Vec::new(),
        t_end: 4.0,
        step,
        max_steps: 2000,
        samples: SAMPLES,
        check: Check::Before(100),
        key: [2026, 11],
        numbers: Vec::new(),
        first: Vec::new(),
    }
}

fn bounded(quantity: Quantity, limit: f64) -> Criterion {
    Criterion::Bounded(Bound { quantity, limit, below: true, after: 0.0 })
}

fn maps() -> Vec<Map> {
    let [rk4, splitting] = [&method::RK4, &method::SPLITTING].map(AnyMethod::Steps);
    vec![
        map(false, rk4, Criterion::NoFlip, Some(0.05)),
        map(false, splitting, Criterion::TiltFromStart(1.5), None),
        map(true, rk4, Criterion::TiltFromVertical(2.2), None),
        map(true, splitting, Criterion::NoFlip, Some(0.05)),
        map(true, splitting, Criterion::TiltFromStart(2.6), Some(0.05)),
        map(false, splitting, bounded(Quantity::Turn { of_momentum: false, in_space: true }, 0.9), None),
        map(true, rk4, bounded(Quantity::Attitude, 2.5), Some(0.05)),
    ]
}

/// Free bodies all have closed forms. The tops of one pixel have a closed form, the tops of the others are integrated,
/// in the same blocks.
fn maps_in_closed_form() -> Vec<Map> {
    let mut maps = vec![
        map(false, AnyMethod::Auto, Criterion::NoFlip, None),
        map(false, AnyMethod::Exact, Criterion::NoFlip, None),
        map(true, AnyMethod::Auto, Criterion::TiltFromVertical(2.2), None),
    ];
    for map in &mut maps {
        // Symmetric about the observed axis, with the centre of mass of a top on this axis.
        map.pixels[0].body = body(4, map.scene.has_weight, true);
    }
    maps
}

/// Statistics without the time of the computation.
fn without_time(mut statistics: Statistics) -> Statistics {
    statistics.nanoseconds = 0.0;
    statistics
}

fn merged(a: Statistics, b: Statistics) -> Statistics {
    Statistics {
        stable: a.stable + b.stable,
        unstable: a.unstable + b.unstable,
        undecided: a.undecided + b.undecided,
        failed: a.failed + b.failed,
        step_limit: a.step_limit + b.step_limit,
        not_finite: a.not_finite + b.not_finite,
        drifted: a.drifted + b.drifted,
        exact: a.exact + b.exact,
        checked: a.checked + b.checked,
        audited: a.audited + b.audited,
        audited_undecided: a.audited_undecided + b.audited_undecided,
        energy_drift: a.energy_drift.max(b.energy_drift),
        momentum_drift: a.momentum_drift.max(b.momentum_drift),
        unit_drift: a.unit_drift.max(b.unit_drift),
        earliest: a.earliest.min(b.earliest),
        growth: a.growth + b.growth,
        megno: a.megno + b.megno,
        largest_exponent: a.largest_exponent.max(b.largest_exponent),
        steps: a.steps + b.steps,
        nanoseconds: 0.0,
    }
}

/// The whole map in pieces of `size` samples.
fn in_pieces(map: &Map, size: u64, threads: usize, isa: Isa) -> Vec<Statistics> {
    // A NaN would not equal itself.
    let none = Statistics {
        energy_drift: 0.0,
        momentum_drift: 0.0,
        unit_drift: 0.0,
        largest_exponent: f64::NEG_INFINITY,
        ..Statistics::NONE
    };
    let mut all = vec![none; map.pixels.len()];
    for start in (0..map.len()).step_by(size as usize) {
        let (first, part, _) =
            map.run(start, map.len().min(start + size), Call::to_the_end(isa, threads)).unwrap();
        for (pixel, statistics) in (first as usize..).zip(part) {
            all[pixel] = merged(all[pixel], without_time(statistics));
        }
    }
    all
}

/// The statistics of all samples of a map, after a comparison of several divisions of the work.
fn compared(map: &Map) -> Statistics {
    let widest = Isa::available()[0];
    let whole = in_pieces(map, map.len(), 1, widest);
    for threads in [2, 3, 7] {
        assert_eq!(in_pieces(map, map.len(), threads, widest), whole, "{threads} threads");
    }
    for size in [1, 13, 4096] {
        assert_eq!(in_pieces(map, size, 1, widest), whole, "pieces of {size}");
    }
    assert_eq!(in_pieces(map, 13, 3, widest), whole);
    for isa in Isa::available() {
        assert_eq!(in_pieces(map, map.len(), 2, isa), whole, "{isa:?}");
    }
    whole.into_iter().reduce(merged).unwrap()
}

#[test]
fn a_map_does_not_depend_on_the_division_of_the_work() {
    for map in maps() {
        // The comparison is meaningful.
        let total = compared(&map);
        assert!(total.stable > 0 && total.unstable > 0 && total.failed >= SAMPLES, "{total:?}");
        assert_eq!(total.stable + total.unstable + total.undecided + total.failed, 4 * SAMPLES);
        assert!(total.energy_drift > 0.0 && total.earliest < map.t_end);
    }
    for map in maps_in_closed_form() {
        let total = compared(&map);
        assert!(total.stable > 0 && total.unstable > 0 && total.earliest < map.t_end, "{total:?}");
        assert_eq!(total.exact, if map.scene.has_weight { SAMPLES } else { 4 * SAMPLES });
        assert_eq!(total.steps > 0, map.scene.has_weight, "{total:?}");
    }
}

/// Regular and chaotic motions of a top without symmetry, with and without damping; the second pixel is regular by
/// theorem.
fn maps_of_growth() -> Vec<Map> {
    let rule = Rule { sure: 2.1, low: 3.0, high: 5.0, ratio: 1.5 };
    let taylor = AnyMethod::Steps(&method::TAYLOR16);
    let mut maps = vec![
        map(true, AnyMethod::Auto, Criterion::RegularRates(rule), None),
        map(true, taylor, Criterion::RegularAttitude(rule), Some(0.2)),
        map(true, AnyMethod::Auto, Criterion::RegularRates(rule), None),
    ];
    for map in &mut maps {
        let top = Body {
            moments: [1.0, 1.6, 0.7],
            weight: [0.72, 0.0, 0.96],
            omega: [0.3, 0.4, 1.0],
            attitude: [1.0, 0.0, 0.0, 0.0],
        };
        map.pixels[0].body = top;
        map.pixels[1].body.moments = [1.0, 1.0, 0.5];
        map.pixels[1].body.weight = [0.0, 0.0, 1.0];
        map.pixels[4].body = Body { omega: [0.1, 0.0, 8.0], ..top };
        map.conditions[0].axis = 0;
        (map.t_end, map.samples, map.max_steps) = (150.0, 12, 100_000);
    }
    let damping = [1e-4, 2e-4, 1e-4, 0.0, 0.0, 0.0];
    maps[2].forces = Some(Forces::new(&[], &[[0.0; 3]], &[[0.0; 3]], &[damping]).unwrap());
    maps
}

#[test]
fn classes_of_growth_do_not_depend_on_the_division_of_the_work() {
    for map in maps_of_growth() {
        let total = compared(&map);
        let exact = map.method == AnyMethod::Auto && map.forces.is_none();
        assert!(total.stable > 12 && total.unstable > 0 && total.failed == 12, "{total:?}");
        assert_eq!(total.exact, if exact { 12 } else { 0 });
        assert!(total.growth > 0 && total.megno > 0 && total.largest_exponent > 0.05, "{total:?}");
    }
}

#[test]
fn samples_with_common_audits_do_not_depend_on_the_division_of_the_work() {
    let splitting = AnyMethod::Steps(&method::SPLITTING);
    let tilted = [
        map(true, AnyMethod::Auto, Criterion::TiltFromVertical(2.2), None),
        map(true, splitting, Criterion::TiltFromVertical(2.2), Some(0.05)),
        map(false, splitting, Criterion::TiltFromStart(1.5), Some(0.01)),
    ];
    let mut doubtful = 0;
    for map in tilted {
        let map = Map { samples: 150, check: Check::Doubtful, ..map };
        let total = compared(&map);
        let classified = total.stable + total.unstable + total.undecided;
        assert!(
            0 < total.audited && total.audited <= total.checked && total.checked < classified,
            "{total:?}"
        );
        doubtful += total.checked - total.audited;
        let isa = Isa::available()[0];
        for flat in (0..map.len()).step_by(37) {
            let class = map.samples_at(&[flat], Call::to_the_end(isa, 1)).unwrap().0[0].class;
            let alone = map.run(flat, flat + 1, Call::to_the_end(isa, 1)).unwrap().1[0];
            let counts = [alone.stable, alone.unstable, alone.undecided];
            let expected =
                [Class::Stable, Class::Unstable, Class::Undecided].map(|of| u64::from(of == class));
            assert_eq!(counts, expected, "{flat}");
        }
    }
    assert!(doubtful > 0);
}

#[test]
fn a_sample_alone_is_the_sample_of_the_map() {
    for mut map in maps().into_iter().chain(maps_in_closed_form()) {
        // Without a second method: the steps in the statistics would be those of both methods.
        map.check = Check::Before(0);
        let isa = Isa::available()[0];
        for flat in (0..map.len()).step_by(37) {
            let pixel = flat / SAMPLES;
            let verdict = map.samples_at(&[flat], Call::to_the_end(isa, 1)).unwrap().0[0];
            let Verdict { class, first: outcome, .. } = verdict;
            let body = map.draw_at(isa, &[(pixel, flat % SAMPLES)]).unwrap()[0];
            let statistics = map.run(flat, flat + 1, Call::to_the_end(isa, 1)).unwrap().1[0];
            let mut expected = Statistics::NONE;
            if map.pixels[pixel as usize].possible {
                match class {
                    Class::Stable => expected.stable = 1,
                    Class::Unstable => expected.unstable = 1,
                    Class::Undecided => expected.undecided = 1,
                    Class::Failed => expected.failed = 1,
                }
                match outcome.status {
                    Status::StepLimit => expected.step_limit = 1,
                    Status::NotFinite => expected.not_finite = 1,
                    Status::Drifted => expected.drifted = 1,
                    Status::Finished | Status::Stopped => {}
                }
                expected.steps = outcome.steps;
                expected.exact = u64::from(outcome.exact);
                if outcome.status != Status::StepLimit && !outcome.exact {
                    // A drift that overflowed is infinite.
                    let largest = |drift: f64| if drift.is_nan() { f64::INFINITY } else { drift };
                    expected.energy_drift = largest(outcome.energy_drift);
                    expected.momentum_drift = largest(outcome.momentum_drift);
                    expected.unit_drift = largest(outcome.unit_drift);
                }
                if class == Class::Unstable {
                    expected.earliest = outcome.left;
                }
            }
            // As text, in which a NaN equals itself.
            assert_eq!(format!("{:?}", without_time(statistics)), format!("{expected:?}"), "sample {flat}");
            assert_eq!(body, map.draw(isa, flat..flat + 1).unwrap()[0]);
        }
    }
}

#[test]
fn draws_on_every_instruction_set() {
    let distributions = [
        Distribution::None,
        Distribution::Normal,
        Distribution::Uniform,
        Distribution::Direction,
        Distribution::UniformAttitude,
        Distribution::VonMisesFisher(1),
    ];
    let numbers = |b: Body| all_bits(&[&b.moments[..], &b.weight, &b.omega, &b.attitude].concat());
    for omega in distributions {
        for attitude in distributions {
            let distributions = Distributions { omega, attitude, ..Distributions::NONE };
            let map = Map { distributions, ..maps().swap_remove(2) };
            // From the last samples of a pixel to the first samples of the next but one.
            let range = 2 * SAMPLES - 40..3 * SAMPLES + 45;
            let alone = |flat: u64| numbers(map.draw(Isa::NARROWEST, flat..flat + 1).unwrap()[0]);
            let scalar: Vec<_> = range.clone().map(alone).collect();
            for isa in Isa::available() {
                // Another start puts a sample into another lane.
                for offset in [0, 1, 7, 33] {
                    let drawn = map.draw(isa, range.start + offset..range.end).unwrap();
                    let drawn: Vec<_> = drawn.into_iter().map(numbers).collect();
                    assert_eq!(drawn, scalar[offset as usize..], "{isa:?} {omega:?} {attitude:?}");
                }
            }
        }
    }
}
