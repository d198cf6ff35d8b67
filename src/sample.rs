//! Random starts as pure functions of (seed, pixel, sample).
//!
//! Philox4x64-10 (Salmon, Moraes, Dror, Shaw, SC'11, doi 10.1145/2063384.2063405), as NumPy ships it: the key
//! is the seed, the counter is (draw block + 1, sample, pixel, 0). NumPy increments before it draws, so
//! `numpy.random.Philox(key=seed, counter=[block, sample, pixel, 0])` gives the same numbers.

use crate::error::Error;
use crate::model::{quaternion_product, rotation_by};
use crate::special::{ln, sincos};
use std::f64::consts::TAU;

/// The ten rounds.
#[inline(always)]
pub fn philox4x64(mut counter: [u64; 4], mut key: [u64; 2]) -> [u64; 4] {
    for _ in 0..10 {
        let a = u128::from(counter[0]) * 0xD2E7_470E_E14C_6C93;
        let b = u128::from(counter[2]) * 0xCA5A_8263_9512_1157;
        counter = [
            (b >> 64) as u64 ^ counter[1] ^ key[0],
            b as u64,
            (a >> 64) as u64 ^ counter[3] ^ key[1],
            a as u64,
        ];
        key[0] = key[0].wrapping_add(0x9E37_79B9_7F4A_7C15);
        key[1] = key[1].wrapping_add(0xBB67_AE85_84CA_A73B);
    }
    counter
}

/// Four uniforms in [0, 1) of a block of draws.
#[inline(always)]
pub fn uniforms(key: [u64; 2], block: u64, sample: u64, pixel: u64) -> [f64; 4] {
    philox4x64([block + 1, sample, pixel, 0], key)
        .map(|bits| (bits >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0))
}

/// The laws of a perturbation. Each takes four uniforms, whatever it needs of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
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
}

impl Law {
    const NAMES: [(&'static str, Law); 5] = [
        ("none", Law::None),
        ("normal", Law::Normal),
        ("uniform", Law::Uniform),
        ("direction", Law::Direction),
        ("uniform_attitude", Law::UniformAttitude),
    ];

    /// The law of that name.
    pub fn parse(argument: &'static str, name: &str) -> Result<Law, Error> {
        Law::NAMES.iter().find(|(known, _)| *known == name).map(|&(_, law)| law).ok_or_else(|| {
            Error::Unknown {
                argument,
                value: name.to_string(),
                known: Law::NAMES.map(|(known, _)| known).join(", "),
            }
        })
    }
}

/// Two independent standard normals from two uniforms.
#[inline(always)]
fn box_muller(u: f64, v: f64) -> [f64; 2] {
    let radius = (-2.0 * ln(1.0 - u)).sqrt();
    let (sin, cos) = sincos(TAU * v);
    [radius * cos, radius * sin]
}

/// Three numbers of the law, of unit size.
#[inline(always)]
pub fn vector(law: Law, u: [f64; 4]) -> [f64; 3] {
    match law {
        Law::None | Law::UniformAttitude => [0.0; 3],
        Law::Normal => {
            let [a, b] = box_muller(u[0], u[1]);
            [a, b, box_muller(u[2], u[3])[0]]
        }
        Law::Uniform => [2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0, 2.0 * u[2] - 1.0],
        Law::Direction => {
            let z = 2.0 * u[0] - 1.0;
            let radius = ((1.0 - z) * (1.0 + z)).sqrt();
            let (sin, cos) = sincos(TAU * u[1]);
            [radius * cos, radius * sin, z]
        }
    }
}

/// A perturbed attitude: `q` turned in the body by a rotation vector of the law, or any attitude at all.
#[inline(always)]
pub fn attitude(law: Law, size: f64, q: [f64; 4], u: [f64; 4]) -> [f64; 4] {
    match law {
        Law::None => q,
        Law::UniformAttitude => {
            let (s1, c1) = sincos(TAU * u[1]);
            let (s2, c2) = sincos(TAU * u[2]);
            let (a, b) = ((1.0 - u[0]).sqrt(), u[0].sqrt());
            [a * s1, a * c1, b * s2, b * c2]
        }
        _ => {
            let v = vector(law, u);
            quaternion_product(&q, &rotation_by(&[size * v[0], size * v[1], size * v[2]]))
        }
    }
}
