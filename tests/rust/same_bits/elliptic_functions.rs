//! Duplications end in each lane when the lane has converged, so the bits depend neither on the other lanes nor on the
//! register.

use rigid::real::Pack;
use rigid::simd::{Arr, Isa, Work};
use rigid::special::{agm, carlson_rc, carlson_rd, carlson_rf, carlson_rj};
use rigid::special::{complete_k, exp, jacobi};

const ROWS: usize = 4096;
const ARGUMENTS: usize = 4;

/// The n-th number of the k-th of a few low-discrepancy sequences in 0 to 1.
fn low_discrepancy(n: usize, k: usize) -> f64 {
    (n as f64 * [0.754_877_666, 0.569_840_291, 0.618_033_989, 0.414_213_562][k]).fract()
}

/// The arguments, one vector each: positive numbers in ranges of all widths; the first number may be 0; the last is a
/// complementary parameter of any size, including 0 and 1.
fn arguments() -> Vec<Vec<f64>> {
    let of_row = |n: usize, k: usize| {
        let width = [0.05, 1.0, 10.0, 60.0, 200.0][n % 5];
        match (n % 7, k) {
            (0, 0) | (3, 3) => 0.0,
            (5, 3) => 1.0,
            (_, 3) if n.is_multiple_of(2) => low_discrepancy(n, k),
            (_, 3) => exp(-width * low_discrepancy(n, k)),
            _ => exp(width * (2.0 * low_discrepancy(n, k) - 1.0)),
        }
    };
    (0..ARGUMENTS).map(|k| (0..ROWS).map(|n| of_row(n, k)).collect()).collect()
}

/// Every function at every row, `P::LANES` rows at a time.
#[inline(always)]
fn results<P: Pack>(arguments: &[Vec<f64>]) -> Vec<[u64; ROWS]> {
    let mut table = vec![[0; ROWS]; 11];
    for start in (0..ROWS).step_by(P::LANES) {
        let [x, y, z, mc] = [0, 1, 2, 3].map(|k| P::load(&arguments[k][start..start + P::LANES]));
        let (sn, cn, dn) = jacobi(x - y, mc);
        let integrals =
            [carlson_rf(x, y, z), carlson_rd(x, y, z), carlson_rj(x, y, z, y), carlson_rj(x, y, y, z)];
        let simple = [carlson_rc(x, y), carlson_rc(y, z - x), agm(y, z)];
        let all = integrals.into_iter().chain(simple).chain([complete_k(mc), sn, cn, dn]);
        for (row, value) in table.iter_mut().zip(all) {
            let mut lanes = [0.0; 64];
            value.store(&mut lanes);
            for lane in 0..P::LANES {
                // All NaN are equal: the payload of a NaN is no result.
                let x = lanes[lane];
                row[start + lane] = if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() };
            }
        }
    }
    table
}

/// The tables of the registers of an instruction set.
struct Tables<'a>(&'a [Vec<f64>]);

impl Work for Tables<'_> {
    type Out = [Vec<[u64; ROWS]>; 2];
    #[inline(always)]
    fn run<P: Pack>(self) -> Self::Out {
        [results::<P>(self.0), results::<Arr<P, 2>>(self.0)]
    }
}

#[test]
fn elliptic_functions_have_the_same_bits_in_every_register() {
    let arguments = arguments();
    let alone = results::<f64>(&arguments);
    for row in &alone {
        let numbers = row.iter().filter(|&&bits| f64::from_bits(bits).is_finite()).count();
        assert!(numbers > ROWS / 2, "{numbers} of {ROWS} results are finite");
    }
    assert!(results::<Arr<f64, 8>>(&arguments) == alone, "several scalars");
    for isa in Isa::available() {
        let tables = isa.call(Tables(&arguments));
        for (function, (a, b)) in tables.iter().flat_map(|t| t.iter().zip(&alone)).enumerate() {
            let other = (0..ROWS).find(|&n| a[n] != b[n]);
            assert_eq!(other, None, "{isa:?}, function {}", function % alone.len());
        }
    }
}
