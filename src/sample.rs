//! Random starts as pure functions of (seed, pixel, sample).
//!
//! Philox4x64-10 (Salmon, Moraes, Dror, Shaw, SC'11, doi 10.1145/2063384.2063405), as NumPy ships it: the key
//! is the seed, the counter is (draw block + 1, sample, pixel, 0). NumPy increments before it draws, so
//! `numpy.random.Philox(key=seed, counter=[block, sample, pixel, 0])` gives the same numbers.

use crate::error::Error;
use crate::kinematics::{quaternion_product, rotation_by};
use crate::real::Real;
use crate::special::{exp_m1, ln, ln_1p, sincos};
use std::f64::consts::TAU;

/// The ten rounds, of several counters in turn: each round has to wait for the one before.
#[inline(always)]
pub fn philox4x64<const N: usize>(mut counters: [[u64; 4]; N], mut key: [u64; 2]) -> [[u64; 4]; N] {
    for _ in 0..10 {
        for counter in &mut counters {
            let a = u128::from(counter[0]) * 0xD2E7_470E_E14C_6C93;
            let b = u128::from(counter[2]) * 0xCA5A_8263_9512_1157;
            *counter = [
                (b >> 64) as u64 ^ counter[1] ^ key[0],
                b as u64,
                (a >> 64) as u64 ^ counter[3] ^ key[1],
                a as u64,
            ];
        }
        key[0] = key[0].wrapping_add(0x9E37_79B9_7F4A_7C15);
        key[1] = key[1].wrapping_add(0xBB67_AE85_84CA_A73B);
    }
    counters
}

/// Four uniforms in [0, 1) of a block of draws.
#[inline(always)]
pub fn uniforms(key: [u64; 2], block: u64, sample: u64, pixel: u64) -> [f64; 4] {
    let [u] = uniforms_together(key, block, [[pixel, sample]]);
    u
}

/// The same of several samples, each given by its pixel and its number.
#[inline(always)]
pub fn uniforms_together<const N: usize>(key: [u64; 2], block: u64, samples: [[u64; 2]; N]) -> [[f64; 4]; N] {
    let (mut counters, mut uniforms) = ([[0; 4]; N], [[0.0; 4]; N]);
    for ([pixel, sample], counter) in samples.into_iter().zip(&mut counters) {
        *counter = [block + 1, sample, pixel, 0];
    }
    for (drawn, own) in philox4x64(counters, key).iter().zip(&mut uniforms) {
        for k in 0..4 {
            own[k] = (drawn[k] >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0);
        }
    }
    uniforms
}

/// The distributions of a perturbation. Each takes four uniforms, even if it needs fewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// No perturbation.
    None,
    /// Three independent standard normals (Box and Muller 1958).
    Normal,
    /// Three independent uniforms in [-1, 1).
    Uniform,
    /// A unit vector, isotropic.
    Direction,
    /// Any attitude in SO(3), uniform (Shoemake, Graphics Gems III, 1992).
    UniformAttitude,
    /// A direction about its nominal one with the density exp(size cos angle): of the rates, or of this body axis.
    VonMisesFisher(usize),
}

impl Distribution {
    const NAMES: [(&'static str, Distribution); 8] = [
        ("none", Distribution::None),
        ("normal", Distribution::Normal),
        ("uniform", Distribution::Uniform),
        ("direction", Distribution::Direction),
        ("uniform_attitude", Distribution::UniformAttitude),
        ("von_mises_fisher1", Distribution::VonMisesFisher(0)),
        ("von_mises_fisher2", Distribution::VonMisesFisher(1)),
        ("von_mises_fisher3", Distribution::VonMisesFisher(2)),
    ];

    /// The distribution of this name.
    pub fn parse(argument: &'static str, name: &str) -> Result<Distribution, Error> {
        Distribution::NAMES
            .iter()
            .find(|(known, _)| *known == name)
            .map(|&(_, distribution)| distribution)
            .ok_or_else(|| Error::Unknown {
                argument,
                value: name.to_string(),
                known: Distribution::NAMES.map(|(known, _)| known).join(", "),
            })
    }
}

/// Two independent standard normals from two uniforms.
#[inline(always)]
fn box_muller<R: Real>(u: R, v: R) -> [R; 2] {
    let radius = (R::splat(-2.0) * ln(R::splat(1.0) - u)).sqrt();
    let (sin, cos) = sincos(R::splat(TAU) * v);
    [radius * cos, radius * sin]
}

/// Three numbers of the distribution, of unit size.
#[inline(always)]
pub fn vector<R: Real>(distribution: Distribution, u: [R; 4]) -> [R; 3] {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    match distribution {
        Distribution::None | Distribution::UniformAttitude | Distribution::VonMisesFisher(_) => {
            [R::splat(0.0); 3]
        }
        Distribution::Normal => {
            let [a, b] = box_muller(u[0], u[1]);
            [a, b, box_muller(u[2], u[3])[0]]
        }
        Distribution::Uniform => [two * u[0] - one, two * u[1] - one, two * u[2] - one],
        Distribution::Direction => {
            let z = two * u[0] - one;
            let radius = ((one - z) * (one + z)).sqrt();
            let (sin, cos) = sincos(R::splat(TAU) * u[1]);
            [radius * cos, radius * sin, z]
        }
    }
}

/// 1 - cos of the angle of a random direction from its mean, with the density exp(concentration cos angle) on the sphere (R. A.
/// Fisher, Proc. R. Soc. A 217 (1953) 295, doi 10.1098/rspa.1953.0064), by the inverse of its distribution (A. T. A. Wood,
/// Commun. Stat. Simul. Comput. 23 (1994) 157, doi 10.1080/03610919408813161; W. Jakob, "Numerically stable sampling of the
/// von Mises-Fisher distribution on S2", 2012). The difference from 1 is computed, which is tiny where the direction is
/// almost certain. At the concentration 0 all directions are alike.
#[inline(always)]
pub fn versine<R: Real>(concentration: R, u: R) -> R {
    let two = R::splat(2.0);
    let found = -ln_1p(u * exp_m1(-(two * concentration))) / concentration;
    let uniform = two * u;
    R::select(R::splat(0.0).lt(concentration), found.min(two), uniform)
}

/// Rates of the same length in a random direction about the nominal one. Rates of zero stay.
#[inline(always)]
pub fn turned_rates<R: Real>(concentration: R, rates: [R; 3], u: [R; 4]) -> [R; 3] {
    let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
    let length = rates[0].fma(rates[0], rates[1].fma(rates[1], rates[2] * rates[2])).sqrt();
    let (x, y, z) = (rates[0] / length, rates[1] / length, rates[2] / length);
    let off = versine(concentration, u[0]);
    let (sin, cos) = sincos(R::splat(TAU) * u[1]);
    let across = length * (off * (two - off)).sqrt();
    let (c, s) = (across * cos, across * sin);
    // Along two axes across (T. Duff et al., J. Comput. Graph. Tech. 6 (2017), no. 1, 1).
    let sign = R::select(z.lt(zero), R::splat(-1.0), one);
    let a = R::splat(-1.0) / (sign + z);
    let b = x * y * a;
    let signed = c * sign;
    let sides = [
        c.fma((sign * x * x).fma(a, one), s * b),
        signed.fma(b, s * (y * y).fma(a, sign)),
        R::splat(0.0) - signed.fma(x, s * y),
    ];
    let mut out = rates;
    for k in 0..3 {
        out[k] = R::select(zero.lt(length), off.fnma(rates[k], rates[k]) + sides[k], rates[k]);
    }
    out
}

/// A perturbed attitude: `q` turned in the body by a rotation vector of the distribution, or a uniform random attitude.
#[inline(always)]
pub fn attitude<R: Real>(distribution: Distribution, size: [R; 3], q: [R; 4], u: [R; 4]) -> [R; 4] {
    match distribution {
        Distribution::None => q,
        Distribution::UniformAttitude => {
            let (s1, c1) = sincos(R::splat(TAU) * u[1]);
            let (s2, c2) = sincos(R::splat(TAU) * u[2]);
            let (a, b) = ((R::splat(1.0) - u[0]).sqrt(), u[0].sqrt());
            [a * s1, a * c1, b * s2, b * c2]
        }
        Distribution::VonMisesFisher(axis) => {
            let half = versine(size[0], u[0]) * R::splat(0.5);
            let (sin, cos) = sincos(R::splat(TAU) * u[1]);
            // About an axis across: the nominal direction and the new one are in a plane with no turn about either.
            let mut turn = [(R::splat(1.0) - half).sqrt(), R::splat(0.0), R::splat(0.0), R::splat(0.0)];
            turn[1 + (axis + 1) % 3] = half.sqrt() * cos;
            turn[1 + (axis + 2) % 3] = half.sqrt() * sin;
            quaternion_product(&q, &turn)
        }
        _ => turned(size, vector(distribution, u), q),
    }
}

/// An attitude turned in the body by a rotation vector whose components are counted in these sizes.
#[inline(always)]
pub fn turned<R: Real>(size: [R; 3], v: [R; 3], q: [R; 4]) -> [R; 4] {
    quaternion_product(&q, &rotation_by(&[size[0] * v[0], size[1] * v[1], size[2] * v[2]]))
}

/// A list of perturbations, of which each body takes one.
#[derive(Clone, Debug)]
pub struct Empirical {
    /// What is added to the rates.
    pub omega: Vec<[f64; 3]>,
    /// Rotations applied on the body side, as many; or none.
    pub attitude: Vec<[f64; 4]>,
    /// The shares of the list up to and with each entry, the last 1; none if the list is used in order.
    pub cumulative: Vec<f64>,
}

impl Empirical {
    /// The entry of a body that draws these uniforms.
    pub fn index(&self, sample: u64, u: [f64; 4]) -> usize {
        if self.cumulative.is_empty() {
            return (sample % self.omega.len() as u64) as usize;
        }
        self.cumulative.partition_point(|&share| share <= u[0])
    }

    /// Perturbs the rates and the attitude of a body by an entry.
    pub fn perturb(&self, index: usize, omega: &mut [f64; 3], attitude: &mut [f64; 4]) {
        let change = self.omega[index];
        for k in 0..3 {
            omega[k] += change[k];
        }
        if let Some(rotation) = self.attitude.get(index) {
            *attitude = quaternion_product(attitude, rotation);
        }
    }
}

/// A lower triangular factor of the covariance of six deviates: three of the rates, then three of the attitude.
pub type Mix = [[f64; 6]; 6];

/// The deviates of the rates that a factor makes of independent ones.
#[inline(always)]
pub fn mixed_rates<R: Real>(mix: &Mix, v: [R; 3]) -> [R; 3] {
    let mut out = [R::splat(0.0); 3];
    for row in 0..3 {
        for column in 0..=row {
            out[row] = R::splat(mix[row][column]).fma(v[column], out[row]);
        }
    }
    out
}

/// The deviates of the attitude that a factor makes of the independent ones of the rates and of the attitude.
#[inline(always)]
pub fn mixed_turn<R: Real>(mix: &Mix, rates: [R; 3], v: [R; 3]) -> [R; 3] {
    let mut out = [R::splat(0.0); 3];
    for row in 0..3 {
        for column in 0..3 {
            out[row] = R::splat(mix[3 + row][column]).fma(rates[column], out[row]);
        }
        for column in 0..=row {
            out[row] = R::splat(mix[3 + row][3 + column]).fma(v[column], out[row]);
        }
    }
    out
}
