//! What *stable* means: each criterion with its name, its observable and the directions that a body must carry for it.
//! Closed forms of a criterion stand in `classify.rs`.

use crate::error::Error;
use crate::observe::Observed;
use crate::scene::Scene;

/// When a sample counts as stable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Criterion {
    /// The component of the rates along the watched axis never changes sign.
    NoFlip,
    /// The watched axis stays within this angle of where it started.
    TiltFromStart(f64),
    /// The watched axis stays within this angle of the vertical.
    TiltFromVertical(f64),
}

impl Criterion {
    /// All of them, made from their limit (rad).
    const ALL: [fn(f64) -> Criterion; 3] =
        [|_| Criterion::NoFlip, Criterion::TiltFromStart, Criterion::TiltFromVertical];

    /// The name that Python knows.
    fn name(self) -> &'static str {
        match self {
            Criterion::NoFlip => "no_flip",
            Criterion::TiltFromStart(_) => "tilt_from_start",
            Criterion::TiltFromVertical(_) => "tilt_from_vertical",
        }
    }

    /// The largest angle that the watched axis may tilt; infinite if its tilt is not asked for.
    pub(super) fn limit(self) -> f64 {
        match self {
            Criterion::NoFlip => f64::INFINITY,
            Criterion::TiltFromStart(angle) | Criterion::TiltFromVertical(angle) => angle,
        }
    }

    /// What is observed of a sample.
    pub(super) fn observed(self) -> Observed {
        match self {
            Criterion::NoFlip => Observed::Flips,
            Criterion::TiltFromStart(_) | Criterion::TiltFromVertical(_) => Observed::Tilt,
        }
    }

    /// How many directions a body of the scene must carry. Where there is weight, the first is the vertical.
    pub(super) fn directions(self, scene: &Scene) -> usize {
        match self {
            Criterion::NoFlip => 0,
            Criterion::TiltFromStart(_) => 1 + usize::from(scene.has_weight),
            Criterion::TiltFromVertical(_) => 1,
        }
    }

    /// The criterion of that name, with its limit (rad).
    ///
    /// # Errors
    /// Naming the known criteria.
    pub fn parse(name: &str, limit: f64) -> Result<Criterion, Error> {
        let all = Criterion::ALL.map(|of| of(limit));
        all.into_iter().find(|criterion| criterion.name() == name).ok_or_else(|| Error::Unknown {
            argument: "criterion",
            value: name.into(),
            known: all.map(Criterion::name).join(", "),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn criteria_have_names() {
        assert_eq!(Criterion::parse("tilt_from_start", 0.5), Ok(Criterion::TiltFromStart(0.5)));
        let message = Criterion::parse("flip", 0.5).unwrap_err().to_string();
        assert!(message.contains("no_flip, tilt_from_start, tilt_from_vertical"), "{message}");
    }
}
