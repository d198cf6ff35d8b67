//! Tables of explicit Runge-Kutta methods, and the conditions that they fulfil.

use super::Facts;

/// The table of an explicit Runge-Kutta method with the unit of time `u = h UNIT`, `k_i = f(y + u sum_j a_ij k_j)`,
/// `y + (u / divisor) sum_i weights_i k_i`.
pub trait Tableau: Copy {
    /// Order of the method.
    const ORDER: usize;
    /// The unit of time over the step: a power of two with which few coefficients differ from one and two, which cost
    /// no multiplication.
    const UNIT: f64;
    /// Rows 1, 2, … of the matrix a; row i has i entries.
    const A: &'static [&'static [f64]];
    /// Weights over the common divisor: whole numbers where they can be.
    const WEIGHTS: &'static [f64];
    /// Common divisor of the weights.
    const DIVISOR: f64;
    /// Number of stages.
    const STAGES: usize = Self::WEIGHTS.len();
    /// Whether all slopes contain the unit, so that no sum of slopes is multiplied by it. Where a stage needs one slope only,
    /// nothing is gained.
    const SLOPES_CONTAIN_UNIT: bool = Self::STAGES > 4;
    /// The motion inside a step and the error of a step, of a method with [`MAX_STAGES`] stages.
    const INSIDE: &'static Inside = &Inside::UNKNOWN;
}

/// The motion inside a step, by its value and slope at both ends and by further stages, and two estimates of the error of
/// the step.
pub struct Inside {
    pub(super) is_known: bool,
    /// Rows of the matrix a of the further stages; the stage before the first is the slope at the end.
    pub(super) stages: [&'static [f64]; FURTHER_STAGES],
    /// The last four coefficients of the polynomial, from all slopes.
    pub(super) polynomial: [[f64; ALL_STAGES]; 4],
    /// The estimates of order 5 and of order 3, from the slopes of the stages.
    pub(super) errors: [[f64; MAX_STAGES]; 2],
}

impl Inside {
    /// The motion inside a step is not known.
    const UNKNOWN: Inside = Inside {
        is_known: false,
        stages: [&[]; FURTHER_STAGES],
        polynomial: [[0.0; ALL_STAGES]; 4],
        errors: [[0.0; MAX_STAGES]; 2],
    };
}

/// Stages for the motion inside a step.
pub(super) const FURTHER_STAGES: usize = 3;

/// Stages of a step, its end, and the further stages.
pub(super) const ALL_STAGES: usize = MAX_STAGES + 1 + FURTHER_STAGES;

/// Largest number of stages of any tableau.
pub(super) const MAX_STAGES: usize = 12;

/// a_ij of the table, 0 outside its triangle.
#[inline(always)]
pub(super) const fn coefficient<T: Tableau>(i: usize, j: usize) -> f64 {
    if i < T::STAGES && j < i { T::A[i - 1][j] } else { 0.0 }
}

/// Weight of a stage, 0 outside the table.
#[inline(always)]
pub(super) const fn weight<T: Tableau>(i: usize) -> f64 {
    if i < T::STAGES { T::WEIGHTS[i] } else { 0.0 }
}

/// The time of a stage, in units; 0 outside the table.
#[inline(always)]
pub(super) const fn time<T: Tableau>(i: usize) -> f64 {
    if i > 0 && i < T::STAGES { node(T::A[i - 1]) } else { 0.0 }
}

/// The time at which a row of a table stands, in units.
#[inline(always)]
pub(super) const fn node(row: &[f64]) -> f64 {
    let (mut sum, mut j) = (0.0, 0);
    while j < row.len() {
        sum += row[j];
        j += 1;
    }
    sum
}

/// The times of all stages, in units.
pub(super) const fn times_of<T: Tableau>() -> [f64; MAX_STAGES] {
    let (mut times, mut i) = ([0.0; MAX_STAGES], 0);
    while i < T::STAGES {
        times[i] = time::<T>(i);
        i += 1;
    }
    times
}

/// Index of the first coefficient of a row.
#[inline(always)]
pub(super) const fn first<T: Tableau>(i: usize) -> usize {
    let mut j = 0;
    while j < i && coefficient::<T>(i, j) == 0.0 {
        j += 1;
    }
    j
}

/// The tableau of [`super::RK4`].
#[derive(Clone, Copy)]
pub struct Rk4Tableau;

/// The tableau of [`super::DOP853`].
#[derive(Clone, Copy)]
pub struct Dop853Tableau;

impl Tableau for Rk4Tableau {
    const ORDER: usize = 4;
    const UNIT: f64 = 0.5;
    const A: &'static [&'static [f64]] = &[&[1.0], &[0.0, 1.0], &[0.0, 0.0, 2.0]];
    const WEIGHTS: &'static [f64] = &[1.0, 2.0, 2.0, 1.0];
    const DIVISOR: f64 = 3.0;
}

impl Tableau for Dop853Tableau {
    const ORDER: usize = 8;
    const UNIT: f64 = 1.0;
    const A: &'static [&'static [f64]] = &[
        &[0.05260015195876773],
        &[0.0197250569845379, 0.0591751709536137],
        &[0.02958758547680685, 0.0, 0.08876275643042054],
        &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
        &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
        &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
        &[
            0.03709200011850479,
            0.0,
            0.0,
            0.17038392571223998,
            0.10726203044637328,
            -0.015319437748624402,
            0.008273789163814023,
        ],
        &[
            0.6241109587160757,
            0.0,
            0.0,
            -3.3608926294469414,
            -0.868219346841726,
            27.59209969944671,
            20.154067550477894,
            -43.48988418106996,
        ],
        &[
            0.47766253643826434,
            0.0,
            0.0,
            -2.4881146199716677,
            -0.590290826836843,
            21.230051448181193,
            15.279233632882423,
            -33.28821096898486,
            -0.020331201708508627,
        ],
        &[
            -0.9371424300859873,
            0.0,
            0.0,
            5.186372428844064,
            1.0914373489967295,
            -8.149787010746927,
            -18.52006565999696,
            22.739487099350505,
            2.4936055526796523,
            -3.0467644718982196,
        ],
        &[
            2.273310147516538,
            0.0,
            0.0,
            -10.53449546673725,
            -2.0008720582248625,
            -17.9589318631188,
            27.94888452941996,
            -2.8589982771350235,
            -8.87285693353063,
            12.360567175794303,
            0.6433927460157636,
        ],
    ];
    const WEIGHTS: &'static [f64] = &[
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    ];
    const DIVISOR: f64 = 1.0;
    const INSIDE: &'static Inside = &Inside {
        is_known: true,
        stages: [
            &[
                0.056167502283047954,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.25350021021662483,
                -0.2462390374708025,
                -0.12419142326381637,
                0.15329179827876568,
                0.00820105229563469,
                0.007567897660545699,
                -0.008298,
            ],
            &[
                0.03183464816350214,
                0.0,
                0.0,
                0.0,
                0.0,
                0.028300909672366776,
                0.053541988307438566,
                -0.05492374857139099,
                0.0,
                0.0,
                -0.00010834732869724932,
                0.0003825710908356584,
                -0.00034046500868740456,
                0.1413124436746325,
            ],
            &[
                -0.42889630158379194,
                0.0,
                0.0,
                0.0,
                0.0,
                -4.697621415361164,
                7.683421196062599,
                4.06898981839711,
                0.3567271874552811,
                0.0,
                0.0,
                0.0,
                -0.0013990241651590145,
                2.9475147891527724,
                -9.15095847217987,
            ],
        ],
        polynomial: [
            [
                -8.428938276109013,
                0.0,
                0.0,
                0.0,
                0.0,
                0.5667149535193777,
                -3.0689499459498917,
                2.38466765651207,
                2.117034582445028,
                -0.871391583777973,
                2.2404374302607883,
                0.6315787787694688,
                -0.08899033645133331,
                18.148505520854727,
                -9.194632392478356,
                -4.436036387594894,
            ],
            [
                10.427508642579134,
                0.0,
                0.0,
                0.0,
                0.0,
                242.28349177525817,
                165.20045171727028,
                -374.5467547226902,
                -22.113666853125306,
                7.733432668472264,
                -30.674084731089398,
                -9.332130526430229,
                15.697238121770845,
                -31.139403219565178,
                -9.35292435884448,
                35.81684148639408,
            ],
            [
                19.985053242002433,
                0.0,
                0.0,
                0.0,
                0.0,
                -387.0373087493518,
                -189.17813819516758,
                527.8081592054236,
                -11.57390253995963,
                6.8812326946963,
                -1.0006050966910838,
                0.7777137798053443,
                -2.778205752353508,
                -60.19669523126412,
                84.32040550667716,
                11.99229113618279,
            ],
            [
                -25.69393346270375,
                0.0,
                0.0,
                0.0,
                0.0,
                -154.18974869023643,
                -231.5293791760455,
                357.6391179106141,
                93.40532418362432,
                -37.45832313645163,
                104.0996495089623,
                29.8402934266605,
                -43.53345659001114,
                96.32455395918828,
                -39.17726167561544,
                -149.72683625798564,
            ],
        ],
        errors: [
            [
                0.01312004499419488,
                0.0,
                0.0,
                0.0,
                0.0,
                -1.2251564463762044,
                -0.4957589496572502,
                1.6643771824549864,
                -0.35032884874997366,
                0.3341791187130175,
                0.08192320648511571,
                -0.022355307863886294,
            ],
            [
                -0.18980075407240762,
                0.0,
                0.0,
                0.0,
                0.0,
                4.450312892752409,
                1.8915178993145003,
                -5.801203960010585,
                -0.4226823213237919,
                -0.1521609496625161,
                0.20136540080403034,
                0.02265179219836082,
            ],
        ],
    };
}

/// Checks the quadrature conditions of the stated order, and all order conditions up to 4 (Hairer, Nørsett, Wanner,
/// Solving ODEs I, table II.2.1).
pub(super) const fn check<T: Tableau>(facts: Facts) {
    let s = T::STAGES;
    assert!(T::A.len() + 1 == s && facts.stages == s && facts.order as usize == T::ORDER && s <= MAX_STAGES);
    let (mut powers, mut size) = ([0.0; MAX_STAGES], 0.0);
    // Sums of b, b c, b c^2, b a c, b c^3, b c a c, b a c^2, b a a c.
    let mut sums = [0.0; 8];
    let mut c = [0.0; MAX_STAGES];
    let mut ac = [0.0; MAX_STAGES];
    let mut ac2 = [0.0; MAX_STAGES];
    let mut aac = [0.0; MAX_STAGES];
    let mut i = 0;
    while i < s {
        let mut j = 0;
        while j < i {
            let a = T::A[i - 1][j] * T::UNIT;
            c[i] += a;
            ac[i] += a * c[j];
            ac2[i] += a * c[j] * c[j];
            aac[i] += a * ac[j];
            j += 1;
        }
        let b = T::WEIGHTS[i] * T::UNIT / T::DIVISOR;
        size += if b < 0.0 { -b } else { b };
        let mut power = b;
        let mut k = 0;
        while k < MAX_STAGES {
            powers[k] += power;
            power *= c[i];
            k += 1;
        }
        let terms = [1.0, c[i], c[i] * c[i], ac[i], c[i] * c[i] * c[i], c[i] * ac[i], ac2[i], aac[i]];
        let mut k = 0;
        while k < 8 {
            sums[k] += b * terms[k];
            k += 1;
        }
        i += 1;
    }
    // Two roundings of each term and sum, and one of each coefficient.
    let allowed = 4.0 * f64::EPSILON * size;
    let wanted = [1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 4.0, 1.0 / 8.0, 1.0 / 12.0, 1.0 / 24.0];
    let conditions = [0, 1, 2, 4, 8][if T::ORDER < 4 { T::ORDER } else { 4 }];
    let mut k = 0;
    while k < conditions {
        let miss = sums[k] - wanted[k];
        assert!(miss < allowed && -miss < allowed);
        k += 1;
    }
    let mut k = 0;
    while k < T::ORDER {
        let miss = powers[k] - 1.0 / (k as f64 + 1.0);
        assert!(miss < allowed && -miss < allowed);
        k += 1;
    }
}
