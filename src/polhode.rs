//! Where a body is among its polhodes: near the separatrix, and how far from the poles of its motion.

use crate::special::agm;
use crate::start::Body;
use std::f64::consts::PI;

/// Whether the motion is nearly free and nearer to its separatrix than a share of the largest distance on its side.
///
/// `2 T I2 - L^2`, moments ascending, vanishes on the separatrix (Landau & Lifshitz, *Mechanics*, § 37). It is formed
/// without cancellation. A body is nearly free if weight and `work` are below the share `free` of twice its kinetic
/// energy.
#[inline]
pub fn is_near_separatrix(body: &Body, work: f64, near: f64, free: f64) -> bool {
    let squares = |v: [f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let twice_kinetic: f64 = (0..3).map(|k| body.moments[k] * body.omega[k] * body.omega[k]).sum();
    if !(squares(body.weight).sqrt() + work < free * twice_kinetic) {
        return false;
    }
    let ([i1, i2, i3], [w1, w2, w3]) = body.ascending();
    let (first, third) = (i1 * (i2 - i1) * (w1 * w1), i3 * (i3 - i2) * (w3 * w3));
    let momentum2 = squares([i1 * w1, i2 * w2, i3 * w3]);
    let largest = momentum2 * if first > third { (i2 - i1) / i1 } else { (i3 - i2) / i3 };
    i1 < i2 && i2 < i3 && momentum2 > 0.0 && (first - third).abs() < near * largest
}

/// The angle `pole` over that which a free body with this bound of its rates turns in the time to the nearest pole of
/// its motion, at least 1; 1 for a body with weight.
///
/// The rates are elliptic functions of time, and have poles at `K(1 - m)/s` beside the real times.
pub fn nearness_of_pole(body: &Body, rate: f64, pole: f64) -> f64 {
    let ([i1, i2, i3], [w1, w2, w3]) = body.ascending();
    let (x, y, z) = (w1 * w1, w2 * w2, w3 * w3);
    let above_least = i2 * (i2 - i1) * y + i3 * (i3 - i1) * z;
    let below_largest = i1 * (i3 - i1) * x + i2 * (i3 - i2) * y;
    let (a, b) = ((i3 - i2) * above_least, (i2 - i1) * below_largest);
    let (fast, slow) = (a.max(b), a.min(b));
    if !(slow > 0.0) || body.weight != [0.0; 3] {
        return 1.0;
    }
    let ratio = (slow / fast).sqrt();
    let unit = (i1 * i2 * i3 / fast).sqrt();
    // The mean of Gauss lies below the arithmetic mean: far from a pole it need not be known.
    let far = PI / (1.0 + ratio) * unit;
    if rate * far > 1.001 * pole {
        return 1.0;
    }
    let time = PI / (2.0 * agm(1.0, ratio)) * unit;
    (pole / (rate * time)).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::special::complete_k;

    fn free(moments: [f64; 3], omega: [f64; 3]) -> Body {
        Body { moments, weight: [0.0; 3], omega, attitude: [1.0, 0.0, 0.0, 0.0] }
    }

    #[test]
    fn the_separatrix_is_where_twice_the_energy_times_the_middle_moment_is_the_squared_momentum() {
        // I1 (I2 - I1) w1^2 = I3 (I3 - I2) w3^2: the axes of I1, I2 and I3 are the third, first and second.
        let moments = [2.0, 3.0, 1.0];
        let on = free(moments, [0.4, 0.3, 0.3 * 3.0_f64.sqrt()]);
        assert!(is_near_separatrix(&on, 0.0, 1e-12, 1e-8));
        for off in [0.9, 1.1] {
            let body = free(moments, [0.4, 0.3 * off, 0.3 * 3.0_f64.sqrt()]);
            // A tenth of a rate changes the difference by a fifth of a term.
            assert!(!is_near_separatrix(&body, 0.0, 1e-3, 1e-8));
            assert!(is_near_separatrix(&body, 0.0, 1.0, 1e-8));
        }
        assert!(!is_near_separatrix(&on, 1.0, 1e-3, 1e-8), "work makes it forced");
        assert!(!is_near_separatrix(&Body { weight: [0.0, 0.0, 1.0], ..on }, 0.0, 1e-3, 1e-8));
        assert!(!is_near_separatrix(&free([1.0, 1.0, 2.0], [0.0, 1.0, 0.0]), 0.0, 1e-3, 1e-8), "symmetric");
        assert!(!is_near_separatrix(&free(moments, [0.0; 3]), 0.0, 1e-3, 1e-8), "at rest");
    }

    #[test]
    fn the_nearest_pole_is_a_complementary_quarter_period_away() {
        // About the axis of the largest moment: s^2 = (I3 - I2)(L^2 - 2 T I1) / (I1 I2 I3),
        // m = (I2 - I1)(2 T I3 - L^2) / ((I3 - I2)(L^2 - 2 T I1)).
        let (moments, omega) = ([1.0, 1.1, 40.0], [0.5, 0.2, 1.0]);
        let body = free(moments, omega);
        let [i1, i2, i3] = moments;
        let [a, b, c] = omega.map(|w| w * w);
        let twice_kinetic = i1 * a + i2 * b + i3 * c;
        let momentum2 = i1 * i1 * a + i2 * i2 * b + i3 * i3 * c;
        let fast = (i3 - i2) * (momentum2 - twice_kinetic * i1);
        let m = (i2 - i1) * (twice_kinetic * i3 - momentum2) / fast;
        let time = complete_k(m) / (fast / (i1 * i2 * i3)).sqrt();
        for (rate, pole) in [(1.2, 7.0), (1.2, 0.3), (1.2, 0.1), (5.0, 7.0)] {
            let expected = (pole / (rate * time)).max(1.0);
            let found = nearness_of_pole(&body, rate, pole);
            // The parameter is formed from differences of energy and momentum here.
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
        assert_eq!(nearness_of_pole(&free([1.0, 1.0, 2.0], [0.1, 0.2, 0.3]), 1.0, 7.0), 1.0);
        assert_eq!(nearness_of_pole(&Body { weight: [0.0, 0.0, 1.0], ..body }, 1.2, 7.0), 1.0);
    }
}
