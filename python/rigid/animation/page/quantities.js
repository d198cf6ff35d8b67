// What criteria watch, over the time of a motion: angles in degrees, rates in rad/s.
const angleBetween = (a, b) => Math.atan2(size(cross(a, b)), dot(a, b)) * 180 / Math.PI;

function quantityOf(chart, numbers, {omega, attitude}) {
  const moments = numbers.slice(0, 3), weight = numbers.slice(3, 6);
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
  let vectors, from;
  if (chart.what === "direction") {
    vectors = omega.map((w, k) => {
      const vector = chart.of === "L" ? w.map((x, i) => x * moments[i]) : w;
      return chart.frame === "space" ? turned(attitude[k], vector) : vector;
    });
  } else {  // the tilt of an axis, or of the centre of mass
    const axis = chart.axis === null ? unit(weight) : [0, 1, 2].map(i => i === Math.abs(chart.axis) - 1 ? Math.sign(chart.axis) : 0);
    vectors = attitude.map(q => turned(q, axis));
    if (chart.reference === "vertical") from = [0, 0, 1];
  }
  return [vectors.map(vector => angleBetween(from ?? vectors[0], vector))];
}
