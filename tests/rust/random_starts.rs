//! Random starts: the generator is Philox4x64-10, the distributions have their moments, and a draw depends only on its
//! seed, pixel and sample.
//!
//! The draws are fixed, so the tests are deterministic: the mean of n draws has at most 4 of its standard errors.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rigid::body::Body;
use rigid::map::{Check, Condition, Criterion, Distributions, Logic, Map, Pixel};
use rigid::method;
use rigid::method::AnyMethod;
use rigid::sample::{Distribution, attitude, philox4x64, uniforms, vector};
use rigid::scene::FREE;
use rigid::simd::Isa;

const N: u64 = 100_000;
const KEY: [u64; 2] = [20_261_121, 0];

/// Known answers of Random123 (kat_vectors, philox4x64 10 rounds): counter, key, result.
#[test]
fn philox_known_answers() {
    let all = u64::MAX;
    let pi = [0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89];
    for (counter, key, answer) in [
        ([0; 4], [0; 2], [0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b, 0x7e68b68aec7ba23b]),
        (
            [all; 4],
            [all; 2],
            [0x87b092c3013fe90b, 0x438c3c67be8d0224, 0x9cc7d7c69cd777b6, 0xa09caebf594f0ba0],
        ),
        (
            pi,
            [0x452821e638d01377, 0xbe5466cf34e90c6c],
            [0xa528f45403e61d95, 0x38c72dbd566e9788, 0xa5a1610e72fd18b5, 0x57bd43b5e52b7fe6],
        ),
    ] {
        assert_eq!(philox4x64([counter], key), [answer]);
    }
}

/// `numpy.random.Generator(numpy.random.Philox(key=2026, counter=[1, 5, 7, 0])).random(4)`, in NumPy 2.4.
#[test]
fn uniforms_are_those_of_numpy() {
    let of_numpy = [0x19e373d6c41ef9_u64, 0x1ac9d305f6153a, 0x1c986f422f78aa, 0x103c2a0b56cfd0]
        .map(|digits| digits as f64 * 2.0_f64.powi(-53));
    let [a, b, c, d] = uniforms([2026, 0], 1, 5, 7);
    // The last number is written with the exponent -3 instead of -1.
    assert_eq!([a, b, c, 4.0 * d], of_numpy);
}

/// The mean of draws, compared with a known mean and variance.
struct Mean {
    name: String,
    sum: f64,
    mean: f64,
    variance: f64,
}

impl Mean {
    fn new(name: impl Into<String>, mean: f64, variance: f64) -> Mean {
        Mean { name: name.into(), sum: 0.0, mean, variance }
    }

    fn check(&self) {
        let off = (self.sum / N as f64 - self.mean) / (self.variance / N as f64).sqrt();
        println!("{}: {off:.2} standard errors", self.name);
        assert!(off.abs() < 4.0, "{}: {off} standard errors", self.name);
    }
}

/// Draws N vectors of a distribution and compares first, second, mixed and fourth moments with those of its components:
/// `m2` = <x^2>, `m4` = <x^4>, `m22` = <x^2 y^2>, `m8` = <x^8>, `m44` = <x^4 y^4>; odd moments vanish.
fn check_moments(distribution: Distribution, [m2, m22, m4, m8, m44]: [f64; 5]) {
    let mut means = Vec::new();
    for i in 0..3 {
        let j = (i + 1) % 3;
        means.push(Mean::new(format!("{distribution:?} x{i}"), 0.0, m2));
        means.push(Mean::new(format!("{distribution:?} x{i}^2"), m2, m4 - m2 * m2));
        means.push(Mean::new(format!("{distribution:?} x{i}^4"), m4, m8 - m4 * m4));
        means.push(Mean::new(format!("{distribution:?} x{i} x{j}"), 0.0, m22));
        means.push(Mean::new(format!("{distribution:?} x{i}^2 x{j}^2"), m22, m44 - m22 * m22));
    }
    for sample in 0..N {
        let v = vector(distribution, uniforms(KEY, 0, sample, 3));
        for i in 0..3 {
            let (x, y) = (v[i], v[(i + 1) % 3]);
            for (mean, value) in means[5 * i..].iter_mut().zip([x, x * x, x.powi(4), x * y, x * x * y * y]) {
                mean.sum += value;
            }
        }
    }
    means.iter().for_each(Mean::check);
}

#[test]
fn uniform_numbers() {
    // In [0, 1): mean 1/2, variance 1/12; the four numbers of a block are independent.
    let mut means: Vec<_> = (0..4).map(|i| Mean::new(format!("u{i}"), 0.5, 1.0 / 12.0)).collect();
    means.extend((0..4).map(|i| Mean::new(format!("u{i} u{}", (i + 1) % 4), 0.25, 1.0 / 9.0 - 1.0 / 16.0)));
    let (mut least, mut most) = (1.0_f64, 0.0_f64);
    for sample in 0..N {
        let u = uniforms(KEY, 0, sample, 0);
        for i in 0..4 {
            means[i].sum += u[i];
            means[4 + i].sum += u[i] * u[(i + 1) % 4];
            (least, most) = (least.min(u[i]), most.max(u[i]));
        }
    }
    means.iter().for_each(Mean::check);
    // The extreme ones of 4e5 numbers lie 2.5e-6 from the ends on average; ten times this distance has a probability of
    // e^-10.
    assert!((0.0..2.5e-5).contains(&least) && (1.0 - 2.5e-5..1.0).contains(&most), "{least:e} {most}");
}

#[test]
fn the_ends_of_the_uniforms() {
    // The largest number is 1 - 2^-53, below one; every distribution is finite at both ends.
    let most = 1.0 - 2.0_f64.powi(-53);
    for distribution in [Distribution::Normal, Distribution::Uniform, Distribution::Direction] {
        for u in [[0.0; 4], [most; 4], [0.0, most, most, 0.0], [most, 0.0, 0.0, most]] {
            let v = vector(distribution, u);
            assert!(v.iter().all(|x| x.is_finite() && x.abs() < 9.0), "{distribution:?}({u:?}) = {v:?}");
        }
    }
    // ln 0 does not occur: the longest normal is sqrt(-2 ln 2^-53).
    let [x, ..] = vector(Distribution::Normal, [most, 0.0, 0.0, 0.0]);
    assert!((x - (106.0 * std::f64::consts::LN_2).sqrt()).abs() < 4.0 * f64::EPSILON * x);
}

#[test]
fn normal_numbers() {
    // <x^2> = 1, <x^4> = 3, <x^8> = 105; independent components.
    check_moments(Distribution::Normal, [1.0, 1.0, 3.0, 105.0, 9.0]);
}

#[test]
fn uniform_perturbations() {
    // In [-1, 1): <x^k> = 1/(k + 1); independent components.
    check_moments(Distribution::Uniform, [1.0 / 3.0, 1.0 / 9.0, 1.0 / 5.0, 1.0 / 9.0, 1.0 / 25.0]);
    let inside = |sample| {
        vector(Distribution::Uniform, uniforms(KEY, 0, sample, 0)).iter().all(|x| (-1.0..1.0).contains(x))
    };
    assert!((0..N).all(inside));
}

#[test]
fn directions_are_isotropic() {
    // Archimedes: each component is uniform in [-1, 1]; <x^2 y^2> = 1/(3 5), <x^4 y^4> = 3 3/(3 5 7 9).
    check_moments(Distribution::Direction, [1.0 / 3.0, 1.0 / 15.0, 1.0 / 5.0, 1.0 / 9.0, 1.0 / 105.0]);
    for sample in 0..N {
        let [x, y, z] = vector(Distribution::Direction, uniforms(KEY, 0, sample, 0));
        // radius^2 with three roundings, half of it and one each for the two squares of an ulp: 4 eps.
        assert!((x * x + y * y + z * z - 1.0).abs() < 4.0 * f64::EPSILON);
    }
}

#[test]
fn attitudes_are_uniform() {
    // A uniform point on the 3-sphere: <q_i^2> = 1/4, <q_i^4> = 3/24, <q_i^2 q_j^2> = 1/24, <q_i^8> = 105/1920.
    // The trace of the matrix, 4 w^2 - 1, has mean 0 and variance 16/16.
    let mut means = Vec::new();
    for i in 0..4 {
        means.push(Mean::new(format!("q{i}"), 0.0, 0.25));
        means.push(Mean::new(format!("q{i}^2"), 0.25, 0.125 - 0.0625));
        means.push(Mean::new(format!("q{i} q{}", (i + 1) % 4), 0.0, 1.0 / 24.0));
        means.push(Mean::new(format!("q{i}^4"), 0.125, 105.0 / 1920.0 - 0.125 * 0.125));
    }
    let mut trace = Mean::new("trace", 0.0, 1.0);
    for sample in 0..N {
        let q = attitude(
            Distribution::UniformAttitude,
            [7.0; 3],
            [0.6, 0.8, 0.0, 0.0],
            uniforms(KEY, 1, sample, 3),
        );
        for i in 0..4 {
            for (mean, value) in
                means[4 * i..].iter_mut().zip([q[i], q[i] * q[i], q[i] * q[(i + 1) % 4], q[i].powi(4)])
            {
                mean.sum += value;
            }
        }
        trace.sum += 4.0 * q[0] * q[0] - 1.0;
        let length2: f64 = q.iter().map(|x| x * x).sum();
        assert!((length2 - 1.0).abs() < 4.0 * f64::EPSILON);
    }
    means.iter().for_each(Mean::check);
    trace.check();
}

/// A small perturbation turns the body about a vector of the distribution, in body axes: q exp(size v).
#[test]
fn a_perturbed_attitude() {
    let q = [0.8, 0.4, -0.4, 0.2];
    for distribution in [Distribution::Normal, Distribution::Uniform, Distribution::Direction] {
        for size in [0.0, 1e-9, 0.3, 2.0] {
            let u = uniforms(KEY, 1, 17, 4);
            let got = attitude(distribution, [size; 3], q, u);
            let by = UnitQuaternion::from_scaled_axis(Vector3::from(vector(distribution, u)) * size);
            let wanted = Quaternion::new(q[0], q[1], q[2], q[3]) * by.into_inner();
            let miss = (Quaternion::new(got[0], got[1], got[2], got[3]) - wanted).norm();
            // Half the angle, at most 4, with two roundings, and a product of four terms.
            assert!(miss < 6.0 * f64::EPSILON, "{distribution:?} {size}: {miss:e}");
        }
    }
    assert_eq!(attitude(Distribution::None, [0.3; 3], q, [0.1; 4]), q);
}

/// Each distribution takes one block of four numbers, so the draws of one part of a start do not change those of
/// another.
#[test]
fn draws_do_not_shift_each_other() {
    let body = Body {
        moments: [1.0, 2.0, 2.5],
        weight: [0.0; 3],
        omega: [0.1, 1.0, -0.2],
        attitude: [0.8, 0.4, -0.4, 0.2],
    };
    let draw = |omega, attitude, samples, pixel, sample| {
        let pixel_of = Pixel { body, omega_size: [0.5, 0.25, 2.0], attitude_size: [0.1; 3], possible: true };
        let map = Map {
            scene: &FREE,
            forces: None,
            method: AnyMethod::Steps(&method::RK4),
            pixels: vec![pixel_of; 3],
            distributions: Distributions { omega, attitude, ..Distributions::NONE },
            mixture: Vec::new(),
            conditions: vec![Condition { criterion: Criterion::NoFlip, axis: 2 }],
            logic: Logic::parse("0", 1).unwrap(),
            measures: Vec::new(),
            t_end: 1.0,
            step: None,
            max_steps: 100,
            samples,
            check: Check::Before(0),
            key: KEY,
            numbers: Vec::new(),
            first: Vec::new(),
        };
        let flat = pixel * samples + sample;
        map.draw(Isa::NARROWEST, flat..flat + 1).unwrap()[0]
    };
    let distributions = [Distribution::Normal, Distribution::Uniform, Distribution::Direction];
    for distribution in distributions {
        let alone = draw(distribution, Distribution::None, 10, 1, 6);
        assert_eq!(alone.attitude, body.attitude);
        assert_ne!(alone.omega, body.omega);
        // Block 0 of the sample, for any other draws and any number of samples.
        let v = vector(distribution, uniforms(KEY, 0, 6, 1));
        for k in 0..3 {
            assert_eq!(alone.omega[k], [0.5_f64, 0.25, 2.0][k].mul_add(v[k], body.omega[k]));
        }
        for other in [Distribution::Normal, Distribution::UniformAttitude] {
            assert_eq!(draw(distribution, other, 1000, 1, 6).omega, alone.omega);
        }
        let turned = draw(Distribution::None, distribution, 10, 1, 6);
        assert_eq!(turned.omega, body.omega);
        // Block 1.
        assert_eq!(turned.attitude, attitude(distribution, [0.1; 3], body.attitude, uniforms(KEY, 1, 6, 1)));
        for other in distributions {
            assert_eq!(draw(other, distribution, 1000, 1, 6).attitude, turned.attitude);
        }
        // Rates and attitude of a sample, samples, and pixels have different draws.
        assert_ne!(vector(distribution, uniforms(KEY, 1, 6, 1)), v);
        for (pixel, sample) in [(1, 5), (0, 6), (2, 6)] {
            assert_ne!(draw(distribution, Distribution::None, 10, pixel, sample).omega, alone.omega);
        }
    }
}

#[test]
fn distributions_by_name() {
    for (name, distribution) in [
        ("none", Distribution::None),
        ("normal", Distribution::Normal),
        ("uniform", Distribution::Uniform),
        ("direction", Distribution::Direction),
        ("uniform_attitude", Distribution::UniformAttitude),
        ("von_mises_fisher1", Distribution::VonMisesFisher(0)),
        ("von_mises_fisher3", Distribution::VonMisesFisher(2)),
    ] {
        assert_eq!(Distribution::parse("distribution", name).unwrap(), distribution);
    }
    let message = Distribution::parse("omega distribution", "gauss").unwrap_err().to_string();
    assert_eq!(
        message,
        "omega distribution = 'gauss': must be one of none, normal, uniform, direction, uniform_attitude, \
         von_mises_fisher1, von_mises_fisher2, von_mises_fisher3"
    );
}
