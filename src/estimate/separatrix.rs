//! The phase error that the drift of a run causes in a free body next to its separatrix.

use super::{Estimate, largest, smaller};
use crate::body::Body;
use crate::exact::derived::{sign_change_time, sign_changes};
use crate::simd::Isa;

/// A distance from the separatrix below this share of the largest on its side is near.
const NEAR: f64 = 1e-3;

/// A body is treated as free if weight and work are below this share of twice its kinetic energy.
const NEARLY_FREE: f64 = 1e-8;

/// The phase error in radians from drift near the separatrix, of a body with these rates and work between two times around 0;
/// away from the separatrix there is none.
///
/// `2 T I2 - L^2`, moments ascending, is negative on the polhodes about axis 3 and positive on those about axis 1 (Landau &
/// Lifshitz, *Mechanics*, § 37). The time that a body stays at the saddle goes with the logarithm of this distance: a drift
/// of the states that changes the distance by a share delays each flip by about that share of the time in which the body
/// turns over. Where the drift reaches the whole distance, the side is lost; this shows once the body has passed the saddle,
/// that is from its first flip on.
pub fn phase_error(
    isa: Isa,
    body: &Body,
    omega: &[[f64; 3]],
    work: Option<&[f64]>,
    [begin, end]: [f64; 2],
) -> Estimate {
    let work = largest(work.unwrap_or(&[]).iter().map(|work| work.abs()));
    if !is_near_separatrix(body, work, NEAR, NEARLY_FREE) {
        return Estimate::NONE;
    }
    // The difference of energy and momentum would lose all digits near the separatrix.
    let distance = |omega: &[f64; 3]| {
        let ([i1, i2, i3], [w1, _, w3]) = Body { omega: *omega, ..*body }.ascending();
        i1 * (i2 - i1) * (w1 * w1) - i3 * (i3 - i2) * (w3 * w3)
    };
    let start = distance(&body.omega);
    let share = largest(omega.iter().map(|omega| (distance(omega) - start).abs())) / start.abs();
    let free = Body { weight: [0.0; 3], attitude: [1.0, 0.0, 0.0, 0.0], ..*body };
    let changes = sign_changes(isa, &free, middle(body.moments));
    let flip = changes.map_or(f64::INFINITY, |changes| sign_change_time(changes, 0));
    // Backward in time a body passes the saddle about as late.
    let passed = if flip <= end {
        flip
    } else if flip <= -begin {
        -flip
    } else {
        return Estimate::NONE;
    };
    Estimate { error: smaller(share, 1.0), lost_from: if share >= 1.0 { passed } else { f64::INFINITY } }
}

/// The axis of the middle one of three different moments.
fn middle(moments: [f64; 3]) -> usize {
    let smaller_ones = |&k: &usize| moments.iter().filter(|&&moment| moment < moments[k]).count() == 1;
    (0..3).find(smaller_ones).unwrap_or(0)
}

/// Whether the motion is nearly free and nearer to its separatrix than a share of the largest distance on its side.
///
/// `2 T I2 - L^2`, moments ascending, vanishes on the separatrix (Landau & Lifshitz, *Mechanics*, § 37). It is formed
/// without cancellation. A body is nearly free if weight and `work` are below the share `free` of twice its kinetic
/// energy.
fn is_near_separatrix(body: &Body, work: f64, near: f64, free: f64) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_is_late_by_the_share_by_which_its_distance_from_the_separatrix_drifts() {
        // Axes 3, 1, 2 in ascending moments; on the separatrix w3^2 = 3 w2^2. The body is off by a share of 2e-5.
        let omega = [0.4, 0.3, 0.3 * 3.0_f64.sqrt() * (1.0 + 1e-5)];
        let body = Body { moments: [2.0, 3.0, 1.0], weight: [0.0; 3], omega, attitude: [1.0, 0.0, 0.0, 0.0] };
        let isa = Isa::current().unwrap();
        let of_drift = |drift: f64, span: [f64; 2]| {
            let later = [0.4, 0.3, omega[2] * (1.0 + drift)];
            phase_error(isa, &body, &[omega, later], None, span)
        };
        let late = of_drift(1e-6, [0.0, 1e3]);
        // The square of the rate drifts by twice its share; the share itself is rounded to 1e-11.
        assert!((late.error - 0.1).abs() < 1e-5 && late.lost_from == f64::INFINITY, "{late:?}");
        let lost = of_drift(-2e-5, [0.0, 1e3]);
        assert!(lost.error == 1.0 && 0.0 < lost.lost_from && lost.lost_from < 1e3, "{lost:?}");
        assert_eq!(of_drift(-2e-5, [-1e3, 0.0]).lost_from, -lost.lost_from);
        assert_eq!(of_drift(-2e-5, [0.0, 0.5 * lost.lost_from]), Estimate::NONE, "no flip yet");
        assert_eq!(phase_error(isa, &body, &[omega], Some(&[1.0]), [0.0, 1e3]), Estimate::NONE, "work");
        assert_eq!((middle([2.0, 3.0, 1.0]), middle([1.0, 2.0, 3.0])), (0, 1));
    }

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
}
