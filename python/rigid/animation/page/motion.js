// Motions of rigid bodies by a Taylor series in the time:
//   I a = L x w + n x c + m + M - D w - |w| C w + 3 n^2 u^3 o x I o,   L = I w + h,   e = P a / I,
//   w' = a + (L x e) / I,   q' = q (w + e) / 2,   and what is at rest in space turns in the body, v' = v x (w + e),
// with moments I, weight c, torques m in the body and M in space, damping D, quadratic drag C, the momentum h of a rotor, an
// energy sink P, the vertical n and the direction o from a planet whose distance is 1 / u in semi-major axes. A step ends
// where the last two terms reach the rounding of the state (A. Jorba and M. Zou, Experimental Mathematics 14 (2005) 99).
const ORDER = 24;

// Where the numbers of a body stand in its row, and how many there are; rigid/maps/page.py writes them in this order. An orbit
// has its mean motion (0 without an orbit), the eccentricity, the mean anomaly at time 0, and both semi-axes.
const NUMBERS = {moments: 3, weight: 3, damping: 9, torque: 3, torqueInSpace: 3, orbit: 9, dissipation: 3, rotor: 3, drag: 3};
const WIDTH = Object.values(NUMBERS).reduce((sum, count) => sum + count);

function named(numbers) {
  let first = 0;
  return Object.fromEntries(Object.entries(NUMBERS).map(([name, count]) => [name, numbers.slice(first, first += count)]));
}

// Cosine and sine of the eccentric anomaly at a time, by Kepler's equation; cosh and sinh on a hyperbola.
function anomalyAt([n, e, first], time) {
  const isOpen = e > 1, turns = isOpen ? 0 : Math.round((first + n * time) / (2 * Math.PI)), mean = first + n * time - 2 * Math.PI * turns;
  let at = isOpen ? Math.asinh(mean / e) : mean + 0.85 * e * Math.sign(mean);
  for (let k = 0, change = Infinity; k < 60 && Math.abs(change) > 1e-15 * Math.abs(at); k++) {
    change = isOpen ? (e * Math.sinh(at) - at - mean) / (e * Math.cosh(at) - 1) : (at - e * Math.sin(at) - mean) / (1 - e * Math.cos(at));
    at -= change;
  }
  return isOpen ? [Math.cosh(at), Math.sinh(at)] : [Math.cos(at), Math.sin(at)];
}

// The vector from the planet to the body in space at a time, in semi-major axes.
function placeOf(orbit, time) {
  const [cos, sin] = anomalyAt(orbit, time);
  return sum(scaled(orbit.slice(3, 6), cos - orbit[1]), orbit.slice(6, 9), sin);
}

// The states at ascending times from 0.
function motionOf(numbers, omega, attitude, times) {
  const {moments, weight: c, damping: D, torque: m, torqueInSpace, orbit, dissipation: P, rotor: h, drag: C} = named(numbers);
  const acts = array => array.some(x => x !== 0), [hasWeight, hasSpace, hasSink, hasDrag] = [c, torqueInSpace, P, C].map(acts);
  const I = moments.map(x => x || Math.max(...moments));  // a rod moves as a sphere
  const [rate, eccentricity] = orbit, hasOrbit = rate > 0, bend = eccentricity > 1 ? 1 : -1, strength = 3 * rate * rate;
  const rows = n => Array.from({length: n}, () => new Float64Array(ORDER + 1));
  const w = rows(3), q = rows(4), a = rows(3), e = rows(3), f = hasSink ? rows(3) : w;  // f = w + e
  const atRest = [[hasWeight, [0, 0, 1]], [hasSpace, torqueInSpace], [hasOrbit, orbit.slice(3, 6)], [hasOrbit, orbit.slice(6, 9)]];
  const carried = atRest.map(([isThere, vector]) => ({vector, series: isThere ? rows(3) : null})), [n, M, A, B] = carried.map(one => one.series);
  const [squared, speed] = rows(2), [cos, sin, away, u, u2, u3] = rows(6), place = rows(3), o = rows(3), pull = rows(3);
  omega.forEach((x, i) => { w[i][0] = x; });
  attitude.forEach((x, i) => { q[i][0] = x; });
  const found = {t: [], omega: [], attitude: []};
  const product = (a, b, k) => {
    let sum = 0;
    for (let j = 0; j <= k; j++) sum += a[j] * b[k - j];
    return sum;
  };
  const crossed = (a, b, i, k) => product(a[(i + 1) % 3], b[(i + 2) % 3], k) - product(a[(i + 2) % 3], b[(i + 1) % 3], k);
  const L = rows(3);

  function orbitSeries(k) {  // from the anomalies and the semi-axes of this order; the next order of the anomalies
    const distance = j => bend * (eccentricity * cos[j] - (j ? 0 : 1));
    away[k] = cos[k] - (k ? 0 : eccentricity);
    let left = k ? 0 : 1;
    for (let j = 1; j <= k; j++) left -= distance(j) * u[k - j];
    u[k] = left / distance(0);
    u2[k] = product(u, u, k);
    u3[k] = product(u2, u, k);
    for (let i = 0; i < 3; i++) {
      place[i][k] = product(A[i], away, k) + product(B[i], sin, k);
      o[i][k] = product(place[i], u, k);
      pull[i][k] = product(o[i], u3, k);
    }
    cos[k + 1] = bend * rate * product(sin, u, k) / (k + 1);
    sin[k + 1] = rate * product(cos, u, k) / (k + 1);
  }

  function speedSeries(k) {
    squared[k] = product(w[0], w[0], k) + product(w[1], w[1], k) + product(w[2], w[2], k);
    if (!k) speed[0] = Math.sqrt(squared[0]);
    let left = squared[k];
    for (let j = 1; j < k; j++) left -= speed[j] * speed[k - j];
    if (k) speed[k] = speed[0] > 0 ? left / (2 * speed[0]) : 0;
  }

  function series(time) {
    const turn = q.map(row => row[0]), back = [turn[0], -turn[1], -turn[2], -turn[3]];
    for (const {vector, series} of carried) if (series) turned(back, vector).forEach((x, i) => { series[i][0] = x; });
    if (hasOrbit) [cos[0], sin[0]] = anomalyAt(orbit, time);
    for (let k = 0; k < ORDER; k++) {
      if (hasOrbit) orbitSeries(k);
      if (hasDrag) speedSeries(k);
      for (let i = 0; i < 3; i++) L[i][k] = I[i] * w[i][k] + (k ? 0 : h[i]);
      for (let i = 0; i < 3; i++) {
        const j = (i + 1) % 3, l = (i + 2) % 3;
        let torque = (I[j] - I[l]) * product(w[j], w[l], k) + h[j] * w[l][k] - h[l] * w[j][k] + (k ? 0 : m[i]);
        torque -= D[3 * i] * w[0][k] + D[3 * i + 1] * w[1][k] + D[3 * i + 2] * w[2][k];
        if (hasWeight) torque += n[j][k] * c[l] - n[l][k] * c[j];
        if (hasSpace) torque += M[i][k];
        if (hasDrag) torque -= C[i] * product(speed, w[i], k);
        if (hasOrbit) torque += strength * (I[l] - I[j]) * product(pull[j], o[l], k);
        a[i][k] = torque / I[i];
        if (hasSink) [e[i][k], f[i][k]] = [P[i] * a[i][k] / I[i], w[i][k] + P[i] * a[i][k] / I[i]];
      }
      for (let i = 0; i < 3; i++) {
        w[i][k + 1] = (a[i][k] + (hasSink ? crossed(L, e, i, k) / I[i] : 0)) / (k + 1);
        for (const {series} of carried) if (series) series[i][k + 1] = crossed(series, f, i, k) / (k + 1);
      }
      const half = 0.5 / (k + 1), [s, x1, x2, x3] = q, [w1, w2, w3] = f;
      s[k + 1] = -half * (product(x1, w1, k) + product(x2, w2, k) + product(x3, w3, k));
      x1[k + 1] = half * (product(s, w1, k) + product(x2, w3, k) - product(x3, w2, k));
      x2[k + 1] = half * (product(s, w2, k) + product(x3, w1, k) - product(x1, w3, k));
      x3[k + 1] = half * (product(s, w3, k) + product(x1, w2, k) - product(x2, w1, k));
    }
  }

  // The direction of a planet counts too: far away its torque is too small to keep a step from leaping over the passage.
  function stepLength() {
    let step = Infinity;
    const pace = Math.hypot(...w.map(row => row[0])) || 1;
    for (const [group, scale, top] of [[w, pace, ORDER], [q, 1, ORDER], ...hasOrbit ? [[o, 1, ORDER - 1]] : []])
      for (const k of [top - 1, top]) {
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
    series(now);
    const step = stepLength();
    if (!(step > 0) || now + step === now) break;
    for (; next < times.length && times[next] <= now + step; next++) {
      found.t.push(times[next]);
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
