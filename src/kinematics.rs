//! Vectors, directions in body components, and quaternions.

use crate::real::Real;
use crate::special::rodrigues;

/// a + b.
#[inline(always)]
pub fn plus<R: Real>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a x b.
#[inline(always)]
pub fn cross<R: Real>(a: &[R; 3], b: &[R; 3]) -> [R; 3] {
    [a[1].fms(b[2], a[2] * b[1]), a[2].fms(b[0], a[0] * b[2]), a[0].fms(b[1], a[1] * b[0])]
}

/// Adds a x b to `sum`.
#[inline(always)]
pub fn add_cross<R: Real>(a: &[R; 3], b: &[R; 3], sum: &mut [R; 3]) {
    *sum = [
        a[2].fnma(b[1], a[1].fma(b[2], sum[0])),
        a[0].fnma(b[2], a[2].fma(b[0], sum[1])),
        a[1].fnma(b[0], a[0].fma(b[1], sum[2])),
    ];
}

/// a . b.
#[inline(always)]
pub fn dot<R: Real>(a: &[R; 3], b: &[R; 3]) -> R {
    a[0].fma(b[0], a[1].fma(b[1], a[2] * b[2]))
}

/// a . b. Without `fma`, which costs a call outside the kernels.
pub fn plain_dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The length of a vector. Without `fma`.
#[inline]
pub fn length<const N: usize>(v: &[f64; N]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A symmetric matrix, from its entries 11, 22, 33, 23, 31, 12.
#[inline(always)]
pub fn symmetric<R: Copy>(entries: &[R; 6]) -> [[R; 3]; 3] {
    let [d11, d22, d33, d23, d31, d12] = *entries;
    [[d11, d12, d31], [d12, d22, d23], [d31, d23, d33]]
}

/// |omega| of a state.
#[inline(always)]
pub fn speed<R: Real, const D: usize>(y: &[R; D]) -> R {
    let rates = [y[0], y[1], y[2]];
    dot(&rates, &rates).sqrt()
}

/// The direction `v` (0, 1, …) of a state.
#[inline(always)]
pub fn direction<R: Real, const D: usize>(y: &[R; D], v: usize) -> [R; 3] {
    [y[3 + 3 * v], y[4 + 3 * v], y[5 + 3 * v]]
}

/// Rate of change of a space-fixed direction in body components: n' = n x omega.
#[inline(always)]
pub fn direction_rate<R: Real>(n: &[R; 3], omega: &[R; 3]) -> [R; 3] {
    cross(n, omega)
}

/// Twice the rate of change of the attitude: q (0, omega).
#[inline(always)]
pub fn doubled_attitude_rate<R: Real>(q: &[R; 4], omega: &[R; 3]) -> [R; 4] {
    let [v1, v2, v3] = *omega;
    let [q0, q1, q2, q3] = *q;
    [
        q3.fnma(v3, q2.fnma(v2, -(q1 * v1))),
        q3.fnma(v2, q2.fma(v3, q0 * v1)),
        q1.fnma(v3, q3.fma(v1, q0 * v2)),
        q2.fnma(v1, q1.fma(v2, q0 * v3)),
    ]
}

/// Adds the part of `n x omega` from the rates across axis 3 to `sum`.
#[inline(always)]
pub fn add_turn_across<R: Real>(n: &[R; 3], [w1, w2]: [R; 2], sum: &mut [R; 3]) {
    let [n1, n2, n3] = *n;
    *sum = [n3.fnma(w2, sum[0]), n3.fma(w1, sum[1]), n2.fnma(w1, n1.fma(w2, sum[2]))];
}

/// Adds the part of `n x omega` from the rate about axis 3 to `sum`.
#[inline(always)]
pub fn add_turn_along<R: Real>(n: &[R; 3], w3: R, sum: &mut [R; 3]) {
    let [n1, n2, _] = *n;
    (sum[0], sum[1]) = (n2.fma(w3, sum[0]), n1.fnma(w3, sum[1]));
}

/// Adds the part of `q (0, omega)` from the rates across axis 3 to `sum`.
#[inline(always)]
pub fn add_roll_across<R: Real>(q: &[R; 4], [w1, w2]: [R; 2], sum: &mut [R; 4]) {
    let [q0, q1, q2, q3] = *q;
    *sum = [
        q2.fnma(w2, q1.fnma(w1, sum[0])),
        q3.fnma(w2, q0.fma(w1, sum[1])),
        q3.fma(w1, q0.fma(w2, sum[2])),
        q2.fnma(w1, q1.fma(w2, sum[3])),
    ];
}

/// Adds the part of `q (0, omega)` from the rate about axis 3 to `sum`.
#[inline(always)]
pub fn add_roll_along<R: Real>(q: &[R; 4], w3: R, sum: &mut [R; 4]) {
    let [q0, q1, q2, q3] = *q;
    *sum = [q3.fnma(w3, sum[0]), q2.fma(w3, sum[1]), q1.fnma(w3, sum[2]), q0.fma(w3, sum[3])];
}

/// Hamilton product of two quaternions, scalar first.
#[inline(always)]
pub fn quaternion_product<R: Real>(a: &[R; 4], b: &[R; 4]) -> [R; 4] {
    [
        a[3].fnma(b[3], a[2].fnma(b[2], a[0].fms(b[0], a[1] * b[1]))),
        a[3].fnma(b[2], a[2].fma(b[3], a[0].fma(b[1], a[1] * b[0]))),
        a[1].fnma(b[3], a[3].fma(b[1], a[0].fma(b[2], a[2] * b[0]))),
        a[2].fnma(b[1], a[1].fma(b[2], a[0].fma(b[3], a[3] * b[0]))),
    ]
}

/// `R.T e` for the attitude `q` (of any length): the body components of the space direction `e`.
#[inline(always)]
pub fn to_body_frame<R: Real>(q: &[R; 4], e: &[R; 3]) -> [R; 3] {
    let u = [q[1], q[2], q[3]];
    let t = cross(e, &u);
    let t = [t[0] + t[0], t[1] + t[1], t[2] + t[2]];
    let s = cross(&t, &u);
    [0, 1, 2].map(|i| q[0].fma(t[i], e[i] + s[i]))
}

/// Halves of the rows of the rotation matrix of a unit quaternion: of the directions of the space axes 1, 2 and 3 in the
/// body.
#[inline(always)]
pub fn half_rows<R: Real>([w, x, y, z]: &[R; 4]) -> [[R; 3]; 3] {
    let (w, x, y, z, half) = (*w, *x, *y, *z, R::splat(0.5));
    [
        [y.fnma(y, z.fnma(z, half)), w.fnma(z, x * y), w.fma(y, x * z)],
        [w.fma(z, x * y), x.fnma(x, z.fnma(z, half)), w.fnma(x, y * z)],
        [w.fnma(y, x * z), w.fma(x, y * z), x.fnma(x, y.fnma(y, half))],
    ]
}

/// The space axes 3, 1 and 2 in the body, times the square of the length of the quaternion: so the names of the body
/// axes do not matter.
#[inline(always)]
pub fn space_axes<R: Real>(&[w, x, y, z]: &[R; 4]) -> [[R; 3]; 3] {
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let third = [x2.fms(z, y2 * w), y2.fma(z, x2 * w), z.fma(z, y.fnma(y, x.fnma(x, w * w)))];
    let first = [x.fma(x, z.fnma(z, y.fnma(y, w * w))), x2.fms(y, z2 * w), x2.fma(z, y2 * w)];
    let second = [x2.fma(y, z2 * w), y.fma(y, z.fnma(z, x.fnma(x, w * w))), y2.fms(z, x2 * w)];
    [third, first, second]
}

/// The vertical in the body, of a quaternion of any length.
#[inline(always)]
pub fn vertical<R: Real>(q: &[R; 4]) -> [R; 3] {
    let [third, ..] = space_axes(q);
    let scale = R::splat(1.0) / squared_length(q);
    [third[0] * scale, third[1] * scale, third[2] * scale]
}

/// The square of the length of a quaternion.
#[inline(always)]
pub fn squared_length<R: Real>(q: &[R; 4]) -> R {
    q[0].fma(q[0], dot(&[q[1], q[2], q[3]], &[q[1], q[2], q[3]]))
}

/// exp of a rotation vector, as a unit quaternion.
#[inline(always)]
pub fn rotation_by<R: Real>(v: &[R; 3]) -> [R; 4] {
    let quarter = dot(v, v) * R::splat(0.25);
    let (a, b) = rodrigues(quarter);
    let s = a * R::splat(0.5);
    [quarter.fnma(b, R::splat(1.0)), s * v[0], s * v[1], s * v[2]]
}

/// Writes a part of a state, from the component `at` on. The compiler does not always inline `copy_from_slice`.
#[inline(always)]
#[allow(clippy::manual_memcpy)]
pub fn put<R: Copy, const D: usize, const N: usize>(y: &mut [R; D], at: usize, part: [R; N]) {
    for i in 0..N {
        y[at + i] = part[i];
    }
}

/// The quaternion, up to its sign, of the rotation matrix with this first and third row (Shepperd 1978: the largest
/// component is computed from a square root, the others from differences over the largest).
#[inline(always)]
pub fn attitude_of_rows<R: Real>(first: &[R; 3], third: &[R; 3]) -> [R; 4] {
    let second = cross(third, first);
    let ([r0, r1, r2], one) = ([first, &second, third], R::splat(1.0));
    let squares = [
        one + r0[0] + r1[1] + r2[2],
        one + r0[0] - r1[1] - r2[2],
        one - r0[0] + r1[1] - r2[2],
        one - r0[0] - r1[1] + r2[2],
    ];
    let [wx, wy, wz] = [r2[1] - r1[2], r0[2] - r2[0], r1[0] - r0[1]];
    let [yz, zx, xy] = [r2[1] + r1[2], r0[2] + r2[0], r1[0] + r0[1]];
    let (mut parts, mut largest) = ([squares[0], wx, wy, wz], squares[0]);
    let others = [[wx, squares[1], xy, zx], [wy, xy, squares[2], yz], [wz, zx, yz, squares[3]]];
    for k in 0..3 {
        let square = squares[k + 1];
        let is_larger = largest.lt(square);
        largest = R::select(is_larger, square, largest);
        for i in 0..4 {
            parts[i] = R::select(is_larger, others[k][i], parts[i]);
        }
    }
    let scale = R::splat(0.5) / largest.sqrt();
    [parts[0] * scale, parts[1] * scale, parts[2] * scale, parts[3] * scale]
}
