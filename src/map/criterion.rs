//! What *stable* means: each criterion with its name, its observable and the directions that a body must carry for it.
//! Closed forms of a criterion stand in `classify.rs`.

use super::Rule;
use crate::error::Error;
use crate::observe::{Angle, Bound, Direction, Observed, Quantity, Tilt};
use crate::scene::Scene;

/// When a sample counts as stable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// The component of the rates along the observed axis never changes sign.
    NoFlip,
    /// The observed axis stays within this angle of where it started.
    TiltFromStart(f64),
    /// The observed axis stays within this angle of the vertical.
    TiltFromVertical(f64),
    /// The motion is regular, by the growth of rates and vertical.
    RegularRates(Rule),
    /// The motion is regular, by the growth of rates and attitude.
    RegularAttitude(Rule),
    /// A scalar of the state stays on one side of a limit.
    Bounded(Bound),
    /// None: the mean rate about the observed axis is measured.
    MeanRate,
    /// None: the mean rate about the observed axis over that of the orbit is measured.
    MeanRateOverMotion,
}

/// The numbers of a rule, and how many of them a criterion has.
const RULE: usize = 4;

/// A name that Python knows, how many numbers it needs, and the criterion with these: an angle (rad), or the numbers of a
/// rule in their order.
pub type Named = (&'static str, usize, fn(&[f64]) -> Criterion);

/// All criteria that Python knows.
pub const NAMED: [Named; 20] = [
    ("no_flip", 0, |_| Criterion::NoFlip),
    ("tilt_from_start", 1, |of| Criterion::TiltFromStart(of[0])),
    ("tilt_from_vertical", 1, |of| Criterion::TiltFromVertical(of[0])),
    ("regular_rates", RULE, |of| Criterion::RegularRates(rule(of))),
    ("regular_attitude", RULE, |of| Criterion::RegularAttitude(rule(of))),
    ("rate_above", 1, |of| Criterion::bounded(Quantity::Rate, of[0], false)),
    ("speed_above", 1, |of| Criterion::bounded(Quantity::Speed, of[0], false)),
    ("speed_below", 1, |of| Criterion::bounded(Quantity::Speed, of[0], true)),
    ("omega_within_body", 1, |of| Criterion::within(false, false, of[0])),
    ("omega_within_space", 1, |of| Criterion::within(false, true, of[0])),
    ("momentum_within_body", 1, |of| Criterion::within(true, false, of[0])),
    ("momentum_within_space", 1, |of| Criterion::within(true, true, of[0])),
    ("near_start", 1, |of| Criterion::bounded(Quantity::Attitude, of[0], true)),
    ("away_from_start", 2, |of| {
        Criterion::Bounded(Bound { quantity: Quantity::Attitude, limit: of[0], below: false, after: of[1] })
    }),
    ("pointing_radial", 2, |of| Criterion::pointing(Direction::Radial, of[0], of[1] != 0.0)),
    ("pointing_along", 2, |of| Criterion::pointing(Direction::Along, of[0], of[1] != 0.0)),
    ("pointing_normal", 2, |of| Criterion::pointing(Direction::Normal, of[0], of[1] != 0.0)),
    ("roll_within", 2, |of| Criterion::angle(Angle::Roll, of[0], of[1])),
    ("pitch_within", 2, |of| Criterion::angle(Angle::Pitch, of[0], of[1])),
    ("yaw_within", 2, |of| Criterion::angle(Angle::Yaw, of[0], of[1])),
];

fn rule(numbers: &[f64]) -> Rule {
    Rule { sure: numbers[0], low: numbers[1], high: numbers[2], ratio: numbers[3] }
}

impl Criterion {
    /// A criterion that a scalar stays on one side of a limit, from the start on.
    fn bounded(quantity: Quantity, limit: f64, below: bool) -> Criterion {
        Criterion::Bounded(Bound { quantity, limit, below, after: 0.0 })
    }

    /// A criterion that a vector stays within an angle of its direction at the start.
    fn within(of_momentum: bool, in_space: bool, angle: f64) -> Criterion {
        Criterion::bounded(Quantity::Turn { of_momentum, in_space }, angle, true)
    }

    /// A criterion that the observed axis, or its opposite, stays within an angle of a direction of the orbit.
    pub(super) fn pointing(from: Direction, angle: f64, either: bool) -> Criterion {
        Criterion::bounded(Quantity::Pointing { from, either }, angle, true)
    }

    /// A criterion that an angle in the frame of the orbit stays within a limit from either side; the observed axis lies
    /// along the line from the planet at rest, this axis along the normal.
    fn angle(of: Angle, angle: f64, normal: f64) -> Criterion {
        Criterion::bounded(Quantity::Angle { of, normal: normal as i32 }, angle, true)
    }

    /// The bound that is observed, if one is.
    #[inline]
    pub(super) fn bound(self) -> Option<Bound> {
        match self {
            Criterion::Bounded(bound) => Some(bound),
            _ => None,
        }
    }

    /// Whether no free body leaves it: the angular momentum is constant in space.
    #[inline]
    pub(super) fn is_kept_without_torque(self) -> bool {
        let constant = Quantity::Turn { of_momentum: true, in_space: true };
        self.bound().is_some_and(|bound| bound.quantity == constant)
    }

    /// Whether the criterion observes a body axis.
    pub(super) fn has_axis(self) -> bool {
        let of_axis = |bound: Bound| {
            matches!(bound.quantity, Quantity::Rate | Quantity::Pointing { .. } | Quantity::Angle { .. })
        };
        self.rule().is_none() && self.bound().is_none_or(of_axis)
    }

    /// The largest angle that the observed axis may tilt; infinite if its tilt is not asked for.
    pub(super) fn limit(self) -> f64 {
        match self {
            Criterion::TiltFromStart(angle) | Criterion::TiltFromVertical(angle) => angle,
            _ => f64::INFINITY,
        }
    }

    /// When a run is regular, if that is asked for.
    #[inline]
    pub(super) fn rule(self) -> Option<Rule> {
        match self {
            Criterion::RegularRates(rule) | Criterion::RegularAttitude(rule) => Some(rule),
            _ => None,
        }
    }

    /// What is observed of a sample.
    #[inline]
    pub(super) fn observed(self) -> Observed {
        match self {
            Criterion::NoFlip => Observed::Flips,
            Criterion::TiltFromStart(angle) | Criterion::TiltFromVertical(angle) => {
                Observed::Tilt(Tilt::within(angle))
            }
            Criterion::RegularRates(_) | Criterion::RegularAttitude(_) => Observed::Growth,
            Criterion::Bounded(bound) => Observed::Bound(bound),
            Criterion::MeanRate | Criterion::MeanRateOverMotion => Observed::MeanRate,
        }
    }

    /// How many directions a body of the scene must carry. Where there is weight, the first is the vertical.
    pub(super) fn directions(self, scene: &Scene) -> usize {
        match self {
            Criterion::NoFlip | Criterion::MeanRate | Criterion::MeanRateOverMotion => 0,
            Criterion::RegularRates(_) | Criterion::RegularAttitude(_) => 0,
            Criterion::TiltFromStart(_) => 1 + usize::from(scene.has_weight),
            Criterion::TiltFromVertical(_) => 1,
            Criterion::Bounded(bound) => match bound.quantity {
                Quantity::Rate | Quantity::Speed | Quantity::Turn { in_space: false, .. } => 0,
                _ => 2,
            },
        }
    }

    /// The criterion of that name, with its numbers.
    ///
    /// # Errors
    /// Naming the known criteria, or how many numbers the criterion has.
    pub fn parse(name: &str, limits: &[f64]) -> Result<Criterion, Error> {
        let Some((_, needed, of)) = NAMED.into_iter().find(|(known, ..)| *known == name) else {
            let known = NAMED.map(|(name, ..)| name).join(", ");
            return Err(Error::Unknown { argument: "criterion", value: name.into(), known });
        };
        if limits.len() != needed {
            let (expected, got) = (format!("({needed},)"), format!("({},)", limits.len()));
            return Err(Error::Shape { argument: "limits", expected, got });
        }
        Ok(of(limits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn criteria_have_names() {
        assert_eq!(Criterion::parse("tilt_from_start", &[0.5]), Ok(Criterion::TiltFromStart(0.5)));
        for (name, numbers, _) in NAMED {
            assert!(Criterion::parse(name, &[0.5; RULE][..numbers]).is_ok(), "{name}");
            let message = Criterion::parse(name, &[0.5; 3]).unwrap_err().to_string();
            assert!(message.starts_with("limits: expected shape"), "{message}");
        }
        let message = Criterion::parse("flip", &[0.5]).unwrap_err().to_string();
        assert!(message.contains("no_flip, tilt_from_start, tilt_from_vertical"), "{message}");
    }
}
