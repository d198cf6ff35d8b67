// What criteria watch, over the time of a motion: angles in degrees, rates in rad/s.
const angleBetween = (a, b) => Math.atan2(size(cross(a, b)), dot(a, b)) * 180 / Math.PI;

const momentumOf = ({moments, rotor}, w) => w.map((x, i) => x * moments[i] + rotor[i]);  // in the body

// Axes of an orbit in space at a time: away from the planet, along the orbit, and the normal.
function axesOfOrbit(orbit, time) {
  const radial = unit(placeOf(orbit, time)), bend = orbit[1] > 1 ? -1 : 1;
  const normal = unit(scaled(cross(orbit.slice(3, 6), orbit.slice(6, 9)), bend));
  return {radial, along: cross(normal, radial), normal};
}

function quantityOf(chart, numbers, {t, omega, attitude}) {
  const body = named(numbers), {weight, orbit} = body;
  const bodyAxis = axis => [0, 1, 2].map(i => i === Math.abs(axis) - 1 ? Math.sign(axis) : 0);
  const along = (vector, axis) => Math.sign(axis) * vector[Math.abs(axis) - 1];
  if (chart.what === "rates") return [0, 1, 2].map(i => omega.map(w => w[i]));
  if (chart.what === "rate") return [omega.map(w => along(w, chart.axis))];
  if (chart.what === "speed") return [omega.map(size)];
  if (chart.what === "turn") {  // the angle of the rotation from the first attitude
    const [w0, x0, y0, z0] = attitude[0];
    return [attitude.map(([w, x, y, z]) => {
      const turn = [w0 * x - x0 * w - y0 * z + z0 * y, w0 * y - y0 * w - z0 * x + x0 * z, w0 * z - z0 * w - x0 * y + y0 * x];
      return 2 * Math.atan2(size(turn), Math.abs(w0 * w + x0 * x + y0 * y + z0 * z)) * 180 / Math.PI;
    })];
  }
  if (chart.what === "pointing") {  // of the end that is nearer to the direction at the start, where either counts
    const angles = attitude.map((q, k) => angleBetween(axesOfOrbit(orbit, t[k])[chart.of], turned(q, bodyAxis(chart.axis))));
    return [chart.either && angles[0] > 90 ? angles.map(angle => 180 - angle) : angles];
  }
  if (chart.what === "distance") return [t.map(time => size(placeOf(orbit, time)))];
  let vectors, from;
  if (chart.what === "direction") {
    vectors = omega.map((w, k) => {
      const vector = chart.of === "L" ? momentumOf(body, w) : w;
      return chart.frame === "space" ? turned(attitude[k], vector) : vector;
    });
  } else {  // the tilt of an axis, or of the centre of mass
    const axis = chart.axis === null ? unit(weight) : bodyAxis(chart.axis);
    vectors = attitude.map(q => turned(q, axis));
    if (chart.reference === "vertical") from = [0, 0, 1];
    if (chart.reference === "normal") from = axesOfOrbit(orbit, 0).normal;
  }
  return [vectors.map(vector => angleBetween(from ?? vectors[0], vector))];
}
