// Motions of rigid bodies by a Taylor series in the time:
//   I w' = (I w) x w + n x c + m - D w,   n' = n x w (the vertical in the body),   q' = q w / 2,
// with moments I, weight c, torque m and damping D in the body. A step ends where the last two terms reach the
// rounding of the state (A. Jorba and M. Zou, Experimental Mathematics 14 (2005) 99).
const ORDER = 24;

// The states at ascending times from 0: `numbers` are 3 moments, 3 of the weight, 9 of the damping, 3 of the torque.
function motionOf(numbers, omega, attitude, times) {
  const I = numbers.slice(0, 3), c = numbers.slice(3, 6), D = numbers.slice(6, 15), m = numbers.slice(15, 18);
  const hasWeight = c.some(x => x !== 0);
  const rows = n => Array.from({length: n}, () => new Float64Array(ORDER + 1));
  const w = rows(3), q = rows(4), n = rows(3);
  omega.forEach((x, i) => { w[i][0] = x; });
  attitude.forEach((x, i) => { q[i][0] = x; });
  const found = {omega: [], attitude: []};
  const product = (a, b, k) => {
    let sum = 0;
    for (let j = 0; j <= k; j++) sum += a[j] * b[k - j];
    return sum;
  };
  function series() {
    const [a, x, y, z] = q.map(row => row[0]);
    [2 * (x * z - a * y), 2 * (y * z + a * x), a * a - x * x - y * y + z * z].forEach((v, i) => { n[i][0] = v; });
    for (let k = 0; k < ORDER; k++) {
      for (let i = 0; i < 3; i++) {
        const j = (i + 1) % 3, l = (i + 2) % 3;
        let torque = (I[j] - I[l]) * product(w[j], w[l], k) + (k ? 0 : m[i]);
        torque -= D[3 * i] * w[0][k] + D[3 * i + 1] * w[1][k] + D[3 * i + 2] * w[2][k];
        if (hasWeight) {
          torque += n[j][k] * c[l] - n[l][k] * c[j];
          n[i][k + 1] = (product(n[j], w[l], k) - product(n[l], w[j], k)) / (k + 1);
        }
        w[i][k + 1] = torque / I[i] / (k + 1);
      }
      const half = 0.5 / (k + 1), [s, x1, x2, x3] = q, [w1, w2, w3] = w;
      s[k + 1] = -half * (product(x1, w1, k) + product(x2, w2, k) + product(x3, w3, k));
      x1[k + 1] = half * (product(s, w1, k) + product(x2, w3, k) - product(x3, w2, k));
      x2[k + 1] = half * (product(s, w2, k) + product(x3, w1, k) - product(x1, w3, k));
      x3[k + 1] = half * (product(s, w3, k) + product(x1, w2, k) - product(x2, w1, k));
    }
  }
  function stepLength() {
    let step = Infinity;
    for (const [group, scale] of [[w, Math.hypot(...w.map(row => row[0])) || 1], [q, 1]])
      for (const k of [ORDER - 1, ORDER]) {
        const last = Math.max(...group.map(row => Math.abs(row[k])));
        if (last > 0) step = Math.min(step, (1e-16 * scale / last) ** (1 / k));
      }
    return step;
  }
  const at = (rows_, h) => rows_.map(row => {
    let sum = row[ORDER];
    for (let k = ORDER - 1; k >= 0; k--) sum = sum * h + row[k];
    return sum;
  });
  let now = 0, next = 0;
  while (next < times.length) {
    series();
    const step = stepLength();
    if (!(step > 0) || now + step === now) break;
    for (; next < times.length && times[next] <= now + step; next++) {
      found.omega.push(at(w, times[next] - now));
      const turn = at(q, times[next] - now), length = Math.hypot(...turn);
      found.attitude.push(turn.map(x => x / length));
    }
    const [rates, turn] = [at(w, step), at(q, step)], length = Math.hypot(...turn);
    rates.forEach((x, i) => { w[i][0] = x; });
    turn.forEach((x, i) => { q[i][0] = x / length; });
    now += step;
  }
  return found;
}

// The time from which on a change of the start by 1e-12 of its size has grown to 0.01; infinite if it does not.
function doubtfulFrom(numbers, omega, attitude, times, motion) {
  const pace = Math.hypot(...omega) || 1;
  const twin = motionOf(numbers, omega.map((x, i) => x + 1e-12 * pace * [0.6, -0.64, 0.48][i]), attitude, times);
  const apart = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
  const first = twin.omega.findIndex((w, k) => k < motion.omega.length &&
    (apart(w, motion.omega[k]) > 0.01 * pace || apart(twin.attitude[k], motion.attitude[k]) > 0.01));
  return first < 0 ? Infinity : times[first];
}
