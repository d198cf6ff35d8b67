//! Closed forms against trajectories of 25 digits.

use super::*;

/// A number with 25 digits: the nearest double, and the remainder.
#[derive(Clone, Copy, Debug)]
struct Golden {
    near: f64,
    low: f64,
}

impl Golden {
    fn parse(text: &str) -> Golden {
        let near: f64 = text.parse().unwrap();
        let exact = format!("{near:.35e}");
        let (mantissa, exponent) = digits(&exact);
        let (known, known_exponent) = digits(text);
        let [a, b] = [(known, known_exponent), (mantissa, exponent)].map(|(digits, e)| {
            // Either number may have been rounded up to the next power of ten.
            digits * 10_i128.pow((e - exponent.min(known_exponent)) as u32)
        });
        let rest = format!("{}e{}", a - b, exponent.min(known_exponent) - 35);
        Golden { near, low: rest.parse().unwrap() }
    }

    /// The error of `got`.
    fn error(self, got: f64) -> f64 {
        (got - self.near) - self.low
    }
}

/// 36 decimal digits of a number as a whole number, and its decimal exponent.
fn digits(text: &str) -> (i128, i32) {
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let value: i128 = format!("{whole}{fraction:0<35}").parse().unwrap();
    (value, exponent.parse().unwrap())
}

#[test]
fn golden_digits_are_read_exactly() {
    // 0.1 is a double plus -5.551115123125782702e-18.
    let tenth = Golden::parse("1.000000000000000000000000e-01");
    assert_eq!((tenth.near, tenth.low), (0.1, -5.551_115_123_125_783e-18));
    let large = Golden::parse("-9.999999999999999999999999e+22");
    // The double below 1e23 is 99999999999999991611392.
    assert_eq!((large.near, large.low), (-1e23, -8_388_607.99));
    let zero = Golden::parse("0");
    assert_eq!((zero.near, zero.low), (0.0, 0.0));
    assert_eq!(Golden::parse("2.5").low, 0.0);
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let numbers: Vec<f64> = value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    numbers.try_into().unwrap()
}

fn golden_numbers<const N: usize>(value: &Value) -> [Golden; N] {
    let numbers: Vec<Golden> =
        value.as_array().unwrap().iter().map(|x| Golden::parse(x.as_str().unwrap())).collect();
    numbers.try_into().unwrap()
}

/// The body of a scene; `None` for a body given by a tensor, whose axes are tested elsewhere.
fn body_of(scene: &Value) -> Option<Body> {
    scene["inertia"][0].as_f64()?;
    let scale = scene["mass"].as_f64().unwrap() * scene["gravity"].as_f64().unwrap();
    let q: [f64; 4] = numbers(&scene["q0"]);
    let length = norm(&q);
    Some(Body {
        moments: numbers(&scene["inertia"]),
        weight: numbers::<3>(&scene["com"]).map(|x| scale * x),
        omega: numbers(&scene["omega0"]),
        attitude: [q[3], q[0], q[1], q[2]].map(|x| x / length),
    })
}

/// Every sample of every scene: the rates relative to the largest rate, the attitude in radians, within three ulp of
/// the angle turned, or four times the effect of the rounding of the inputs.
#[test]
fn golden_trajectories() {
    let mut forms = Vec::new();
    for name in ["free_asymmetric", "free_symmetric", "lab_box", "lagrange", "pendulum"] {
        let path = format!("{}/tests/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let file: Value = serde_json::from_reader(std::fs::File::open(path).unwrap()).unwrap();
        for scene in file["scenes"].as_array().unwrap() {
            let Some(body) = body_of(scene) else { continue };
            let form = CanonicalForm::of(&body).unwrap().closed_form;
            let samples = scene["samples"].as_array().unwrap();
            let times: Vec<f64> = samples.iter().map(|sample| sample["t"].as_f64().unwrap()).collect();
            let largest = samples
                .iter()
                .map(|sample| norm(&golden_numbers::<3>(&sample["omega"]).map(|w| w.near)))
                .fold(0.0, f64::max);
            let states = motion(&body, &times);
            let mut worst = [0.0_f64; 2];
            for ((sample, t), (omega, attitude)) in samples.iter().zip(&times).zip(&states) {
                let golden: [Golden; 3] = golden_numbers(&sample["omega"]);
                let off = norm(&[0, 1, 2].map(|k| golden[k].error(omega[k])));
                let [x, y, z, w] = golden_numbers(&sample["q"]);
                let golden = [w, x, y, z];
                // Both signs are the same attitude.
                let along: f64 = (0..4).map(|k| golden[k].near * attitude[k]).sum();
                let turned = attitude.map(|c| c * along.signum());
                let turn = 2.0 * norm(&[0, 1, 2, 3].map(|k| golden[k].error(turned[k])));
                let bar = |kappa: &str| {
                    let rounding = sample[kappa].as_f64().unwrap_or(0.0) * 1.11e-16;
                    (1e-15 * (1.0 + largest * t)).max(4.0 * rounding)
                };
                let off = if largest > 0.0 { off / largest } else { off };
                let parts = [off / bar("kappa_omega"), turn / bar("kappa_att")];
                let id = &scene["id"];
                assert!(
                    parts.iter().all(|part| *part <= 1.0),
                    "{id} at {t}: {off:e}, {turn:e}, parts {parts:?}"
                );
                worst = [0, 1].map(|i| worst[i].max(parts[i]));
            }
            println!("{:40} {:16} parts {:.2} {:.2}", scene["id"], form.name(), worst[0], worst[1]);
            forms.push(form);
        }
    }
    let count = |form| forms.iter().filter(|&&f| f == form).count();
    assert!(
        count(ClosedForm::Asymmetric) > 20
            && count(ClosedForm::Symmetric) >= 4
            && count(ClosedForm::Lagrange) > 15
    );
    assert!(count(ClosedForm::PermanentRotation) >= 2 && count(ClosedForm::Pendulum) >= 1, "{forms:?}");
}

/// A start near the intermediate axis with equal perturbations, after nine flips, with arithmetic of 25 digits.
#[test]
fn after_many_flips() {
    let (omega, _) = motion(&free([1.0, 2.0, 3.0], [1e-14, 1.0, 1e-14]), &[1000.0])[0];
    let [w1, w2, w3] = omega;
    // The known digits; the last digit is twice as sensitive to the rounding of the start.
    assert!((w1 / -3.336_050_562_31e-5 - 1.0).abs() < 1e-11, "{w1:e}");
    assert!((w2 - -0.999_999_999_444).abs() < 1e-11, "{w2}");
    assert!((w3 / 1.926_069_69e-5 - 1.0).abs() < 1e-8, "{w3:e}");
}
