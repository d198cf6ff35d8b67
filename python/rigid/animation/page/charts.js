// Beside the film: a strip chart with the cursor of the film, and the path of L in the body.
function sharp(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const width = canvas.clientWidth, height = canvas.clientHeight, pen = canvas.getContext("2d");
  const [wide, high] = [width, height].map(x => Math.round(x * ratio));
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return [pen, width, height];
}

// Digits that tell numbers between two ends apart which are a step away from each other.
function digitsOf(low, high, step, least) {
  const most = Math.max(Math.abs(low), Math.abs(high));
  return step > 0 && most > 0 ? clamp(Math.ceil(Math.log10(most / step)) + 1, least, 15) : least;
}

function ticks(low, high, wanted) {
  const rough = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map(x => x * power).find(x => x >= rough) ?? power;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  const most = Math.max(Math.abs(low), Math.abs(high)), isFar = most < 1e-3 || most >= 1e6;  // numbers of many zeros
  const words = x => isFar && x ? x.toExponential(digitsOf(low, high, step, 1) - 1).replace(/\.?0*e\+?/, "e") : String(x);
  return found.map(x => [x, words(Number(x.toPrecision(digitsOf(low, high, step, 6))))]);
}

const SECONDS = {unit: "s", factor: 1};  // how times are shown, unless a film has another clock

// A chart: what a film changes is drawn over a picture of the rest.
class Chart {
  constructor(canvas, film, label) {
    this.canvas = canvas;
    this.film = film;
    this.background = document.createElement("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", label);
  }

  draw(frame) {
    const {canvas, background} = this, [pen, width, height] = sharp(canvas);
    if (!canvas.width || !canvas.height) return;  // hidden
    const look = [width, height, canvas.width, dark()].join();
    if (look !== this.look) {
      this.look = look;
      [background.width, background.height] = [canvas.width, canvas.height];
      const under = background.getContext("2d");
      under.setTransform(pen.getTransform());
      this.still(under, width, height);
    }
    pen.save();
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.drawImage(background, 0, 0);
    pen.restore();
    this.moving(pen, frame);
  }
}

class StripChart extends Chart {
  constructor(canvas, film, seek) {
    super(canvas, film, `${film.chart.label} against time`);
    const to = event => {
      const box = canvas.getBoundingClientRect(), [left, right] = this.sides(box.width);
      const {t} = this.film, share = clamp((event.clientX - box.left - left) / (right - left), 0, 1);
      const time = t[0] + share * (t[t.length - 1] - t[0]);
      let nearest = 0;
      t.forEach((at, k) => { if (Math.abs(at - time) < Math.abs(t[nearest] - time)) nearest = k; });
      seek(nearest);
    };
    canvas.onpointerdown = event => { canvas.setPointerCapture(event.pointerId); to(event); };
    canvas.onpointermove = event => { if (event.buttons) to(event); };
  }

  sides(width) {
    return [46, width - 10];
  }

  moving(pen, frame) {
    const {chart, t} = this.film, {x, y, top, bottom} = this.scale;
    pen.strokeStyle = css("#222222");
    pen.lineWidth = 1.4;
    pen.beginPath();
    pen.moveTo(x(t[frame]), top);
    pen.lineTo(x(t[frame]), bottom);
    pen.stroke();
    chart.values.forEach((values, i) => {
      pen.fillStyle = css(chart.colours[i]);
      pen.beginPath();
      pen.arc(x(t[frame]), y(values[frame]), 3.2, 0, 7);
      pen.fill();
    });
  }

  still(pen, width, height) {
    const {chart, t} = this.film, [left, right] = this.sides(width), limits = chart.limits ?? [];
    const all = chart.values.flat().concat(limits);
    let low = all.reduce((a, b) => Math.min(a, b), Infinity), high = all.reduce((a, b) => Math.max(a, b), -Infinity);
    const room = Math.max(0.06 * (high - low), 1e-9 * Math.max(Math.abs(high), 1));
    [low, high] = [low - room, high + room];
    const top = 22, bottom = height - 20, span = t[t.length - 1] - t[0] || 1;
    const x = time => left + (right - left) * (time - t[0]) / span;
    const y = value => bottom - (bottom - top) * (value - low) / (high - low);
    this.scale = {x, y, top, bottom};
    pen.font = "11px system-ui, sans-serif";
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    const path = (ink, points, wide, dash = []) => {
      pen.strokeStyle = ink;
      pen.lineWidth = wide;
      pen.setLineDash(dash);
      pen.beginPath();
      points.forEach(([a, b], k) => k ? pen.lineTo(a, b) : pen.moveTo(a, b));
      pen.stroke();
      pen.setLineDash([]);
    };
    if (chart.doubtful < t[t.length - 1]) {  // from here on motions of equal starts differ
      pen.fillStyle = css("#000000", 0.08);
      pen.fillRect(x(chart.doubtful), top, right - x(chart.doubtful), bottom - top);
    }
    for (const [value, text] of ticks(low, high, Math.max(2, (bottom - top) / 34))) {
      path(css("#000000", 0.09), [[left, y(value)], [right, y(value)]], 1);
      pen.fillStyle = css("#555555");
      pen.fillText(text, left - 6, y(value));
    }
    pen.textBaseline = "top";
    pen.textAlign = "center";
    const {unit, factor} = this.film.clock ?? SECONDS;
    for (const [value, text] of ticks(factor * t[0], factor * t[t.length - 1], Math.max(2, (right - left) / 80)))
      pen.fillText(text, clamp(x(value / factor), left + 4, right - 12), bottom + 5);
    pen.textAlign = "right";
    pen.fillText(`t (${unit})`, right, top - 18);
    pen.textAlign = "left";
    let at = 6;
    pen.fillText(chart.label, at, 4);
    at += pen.measureText(chart.label).width + 12;
    chart.names.forEach((name, i) => {
      pen.fillStyle = css(chart.colours[i]);
      pen.fillText(name, at, 4);
      at += pen.measureText(name).width + 10;
    });
    chart.values.forEach((values, i) => path(css(chart.colours[i]), values.map((v, k) => [x(t[k]), y(v)]), 1.6));
    pen.fillStyle = css("#222222");
    pen.textAlign = "right";
    limits.forEach((limit, k) => {
      path(css("#222222"), [[left, y(limit)], [right, y(limit)]], 1.3, [6, 4]);
      const isHigh = y(limit) < top + 14;
      pen.textBaseline = isHigh ? "top" : "bottom";
      pen.fillText(chart.limitNames[k], right - 2, y(limit) + (isHigh ? 3 : -1));
    });
    if (chart.after > t[0]) path(css("#222222"), [[x(chart.after), top], [x(chart.after), bottom]], 1.3, [2, 3]);
  }
}

// The direction of L in the body moves on a sphere along one curve, the polhode of the momenta; great
// circles through the middle axis, the separatrix, divide the curves round the first and the third axis.
class Sphere extends Chart {
  constructor(canvas, film) {
    super(canvas, film, "Directions of the angular momentum L in the body: its path, and the separatrix (grey), " +
      "which divides motions about the axes of the least and of the largest moment");
    canvas.title = canvas.getAttribute("aria-label");
    const start = film.polhode.points[0], eye = unit(start.map((x, i) => x + (x < 0 ? -1 : 1) * [0.75, 0.55, 0.9][i]));
    const [right, up] = across(eye);
    this.axes = [scaled(right, -1), up, eye];
    this.axes[0] = cross(up, eye);
  }

  still(pen, width, height) {
    const {polhode, chart} = this.film, radius = Math.min(width, height - 18) / 2 - 14, cx = width / 2, cy = (height + 16) / 2;
    const see = this.see = p => [cx + radius * dot(p, this.axes[0]), cy - radius * dot(p, this.axes[1]), dot(p, this.axes[2])];
    pen.fillStyle = css("#000000", 0.05);
    pen.beginPath();
    pen.arc(cx, cy, radius, 0, 7);
    pen.fill();
    const curve = (points, ink, wide) => {
      for (const front of [false, true]) {
        pen.strokeStyle = css(ink, front ? 1 : 0.22);
        pen.lineWidth = wide;
        pen.beginPath();
        let drawing = false;
        for (const p of points) {
          const [x, y, depth] = see(p);
          if (depth >= 0 === front) drawing ? pen.lineTo(x, y) : pen.moveTo(x, y);
          drawing = depth >= 0 === front;
        }
        pen.stroke();
      }
    };
    polhode.separatrix.forEach(points => curve(points, "#777777", 1.2));
    curve(polhode.points, "#0062a3", 2);
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis, i) => [1, -1].forEach(sign => {
      const [x, y, depth] = see(scaled(axis, sign));
      if (depth < 0) return;
      pen.fillStyle = css(chart.axes[i]);
      pen.fillText(`${sign < 0 ? "−" : ""}${i + 1}`, x + 0.13 * (x - cx), y + 0.13 * (y - cy));
      pen.beginPath();
      pen.arc(x, y, 2.4, 0, 7);
      pen.fill();
    }));
    pen.fillStyle = css("#555555");
    pen.textAlign = "left";
    pen.textBaseline = "top";
    pen.fillText("L in the body", 4, 4);
    if (!polhode.separatrix.length) return;
    pen.textBaseline = "bottom";
    pen.fillStyle = css("#777777");
    pen.fillText("— separatrix", 4, height - 2);
  }

  moving(pen, frame) {
    const [x, y, depth] = this.see(this.film.polhode.points[frame]);
    pen.fillStyle = css("#ae3f86", depth < 0 ? 0.45 : 1);
    pen.beginPath();
    pen.arc(x, y, 5, 0, 7);
    pen.fill();
  }
}
