// The stage: draws one film with WebGL2 and a depth buffer, or with Canvas where there is no WebGL2.
const IDENTITY = [1, 0, 0, 0];

class Camera {  // shared by all stages of a page
  constructor(view) {
    this.first = [...view];
    this.reset();
  }

  reset() {
    [this.azimuth, this.elevation] = this.first;
    this.zoom = 1;
  }

  turn(x, y) {
    this.azimuth -= 0.01 * x;
    this.elevation = clamp(this.elevation + 0.01 * y, -1.55, 1.55);
  }

  closer(factor) {
    this.zoom = clamp(this.zoom * factor, 0.3, 8);
  }

  axes([first, second, up]) {  // rightward, upward and towards the eye
    const level = sum(scaled(first, Math.cos(this.azimuth)), second, Math.sin(this.azimuth));
    const eye = sum(scaled(level, Math.cos(this.elevation)), up, Math.sin(this.elevation));
    const right = cross(up, level);
    return [right, cross(eye, right), eye];
  }
}

// One finger or button turns, two fingers or the wheel come closer, two taps reset.
function steer(element, camera) {
  const fingers = new Map();
  const span = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  element.addEventListener("pointerdown", event => {
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    element.setPointerCapture(event.pointerId);
  });
  element.addEventListener("pointermove", event => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const before = fingers.size === 2 ? span() : 0;
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (fingers.size === 1) camera.turn(event.clientX - last[0], event.clientY - last[1]);
    if (fingers.size === 2 && before > 0) camera.closer(span() / before);
  });
  for (const end of ["pointerup", "pointercancel"])
    element.addEventListener(end, event => fingers.delete(event.pointerId));
  element.addEventListener("wheel", event => {
    event.preventDefault();
    camera.closer(Math.exp(-0.001 * event.deltaY));
  }, {passive: false});
  element.addEventListener("dblclick", () => camera.reset());
}

// Triangles of polygons, with normals averaged where neighbouring faces meet at less than 45 degrees.
function trianglesOf(faces, colours) {
  const normals = faces.map(p => p.length < 4
    ? cross(sum(p[1], p[0], -1), sum(p[2], p[0], -1))
    : cross(sum(p[2], p[0], -1), sum(p[3], p[1], -1)));
  const meeting = new Map(), key = p => p.map(x => Math.round(1e4 * x)).join();
  faces.forEach((face, i) => face.forEach(p => {
    const k = key(p);
    if (!meeting.has(k)) meeting.set(k, new Set());
    meeting.get(k).add(i);
  }));
  const vertices = [], least = Math.cos(45 * Math.PI / 180);
  faces.forEach((face, i) => {
    if (size(normals[i]) < 1e-12) return;
    const own = unit(normals[i]), ink = colours[i % colours.length];
    const smooth = face.map(p => {
      let mean = [0, 0, 0];
      for (const j of meeting.get(key(p))) {
        const other = unit(normals[j]), along = dot(own, other);
        if (Math.abs(along) > least) mean = sum(mean, normals[j], Math.sign(along));
      }
      return unit(mean);
    });
    for (let c = 1; c + 1 < face.length; c++)
      for (const corner of [0, c, c + 1]) vertices.push(...face[corner], ...smooth[corner], ...ink);
  });
  return new Float32Array(vertices);
}

// An arrow from the origin as faces: a shaft and a head, round.
function arrowFaces(tip, reach) {
  const length = size(tip);
  if (!(length > 0)) return [];
  const [first, second, along] = across(tip), sides = 16;
  const head = Math.min(0.11 * reach, 0.6 * length), shaft = 0.014 * reach, wide = 0.036 * reach;
  const ring = (radius, height) => Array.from({length: sides + 1}, (_, k) => {
    const angle = 2 * Math.PI * k / sides;
    return sum(sum(scaled(along, height), first, radius * Math.cos(angle)), second, radius * Math.sin(angle));
  });
  const rings = [ring(shaft, 0), ring(shaft, length - head), ring(wide, length - head), ring(1e-4 * reach, length)];
  return rings.slice(1).flatMap((next, j) =>
    next.slice(1).map((_, k) => [rings[j][k], rings[j][k + 1], next[k + 1], next[k]]));
}

function ballFaces(centre, radius) {
  const point = (i, j) => sum(centre, [
    Math.sin(Math.PI * i / 8) * Math.cos(Math.PI * j / 8),
    Math.sin(Math.PI * i / 8) * Math.sin(Math.PI * j / 8), Math.cos(Math.PI * i / 8)], radius);
  return Array.from({length: 128}, (_, k) => {
    const i = k >> 4, j = k & 15;
    return [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
  });
}

// A planet in its direction, at the end of a line from the body.
function planetFaces(place, reach) {
  const [first, second] = across(place), angles = [0, 1, 2, 3, 4, 5, 6].map(k => k * Math.PI / 3);
  const ring = share => angles.map(angle => sum(sum(scaled(place, share), first, 0.006 * reach * Math.cos(angle)), second, 0.006 * reach * Math.sin(angle)));
  const [near, far] = [ring(0), ring(1)];
  return [...near.slice(1).map((_, k) => [near[k], near[k + 1], far[k + 1], far[k]]), ...ballFaces(place, 0.09 * reach)];
}

const FACES_OF_VECTOR = {arrow: arrowFaces, planet: planetFaces, dot: (point, reach) => ballFaces(point, 0.03 * reach)};

// Points of a part in a frame, in the axes in which the part is at rest.
function pointsAt(film, part, frame) {
  const points = part.points;
  if (FACES_OF_VECTOR[part.kind]) return [points[points.length > 1 ? frame : 0]];
  if (part.kind !== "trail") return points;
  return points.slice(trailBegin(film, frame), frame + 1);
}

function trailBegin(film, frame) {  // index of the oldest point that is still drawn
  if (film.trail === null) return 0;
  let first = frame;
  while (first > 0 && Math.abs(film.t[frame] - film.t[first - 1]) <= film.trail) first--;
  return first;
}

const carriedBy = (film, part, frame) => part.carried ? film.attitude[frame] : IDENTITY;

const placed = (film, part, frame) => {  // in space
  const attitude = carriedBy(film, part, frame), turn = p => turned(attitude, p);
  return pointsAt(film, part, frame).map(p => Array.isArray(p[0]) ? p.map(turn) : turn(p));
};

// Perspective: the eye is at `AWAY` reaches; a sphere of one reach fills the smaller side.
const AWAY = 4.5;

class Stage {
  constructor(holder, film, camera, described) {
    this.film = film;
    this.camera = camera;
    this.holder = holder;
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", described);
    this.canvas.className = "stage";
    holder.append(this.canvas);
    this.names = film.parts.filter(part => part.label).map(part => {
      const name = document.createElement("span");
      name.className = "name";
      name.textContent = part.label;
      name.setAttribute("aria-hidden", "true");
      holder.append(name);
      return {part, name};
    });
    steer(this.canvas, camera);
    this.painter = glPainter(this.canvas) ?? flatPainter(this.canvas);
    this.painter.load(film);
  }

  remove() {
    this.painter.free();
    this.canvas.remove();
    this.names.forEach(({name}) => name.remove());
  }

  draw(frame) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height) return;
    for (const [side, wanted] of [["width", width * ratio], ["height", height * ratio]])
      if (this.canvas[side] !== Math.round(wanted)) this.canvas[side] = Math.round(wanted);
    const {film, camera} = this, [right, upward, eye] = camera.axes(film.frame);
    // Half the angle of sight holds the sphere of the film: tan = 1 / sqrt(AWAY² - 1).
    const scale = Math.sqrt(AWAY * AWAY - 1) * camera.zoom / 1.04, least = Math.min(width, height);
    const at = sum(film.centre, eye, AWAY * film.reach);
    const project = point => {
      const from = sum(point, at, -1), depth = -dot(from, eye);
      return [0.5 * width + 0.5 * least * scale * dot(from, right) / depth,
        0.5 * height - 0.5 * least * scale * dot(from, upward) / depth, depth];
    };
    const look = {frame, ratio, width, height, right, upward, eye, at, project,
      sides: [scale * least / width, scale * least / height], near: 2 * film.reach, far: 8 * film.reach};
    this.painter.draw(film, look);
    this.label(look);
  }

  // Each label stands beyond the tip of its arrow, or beside it: where it lies on the fewest labels and arrows.
  label(look) {
    const {film, names} = this, [x0, y0] = look.project([0, 0, 0]), taken = [];
    const tips = names.map(({part}) => placed(film, part, look.frame)[0]), ends = tips.map(look.project);
    names.forEach((one, k) => {
      const {part, name} = one, [x, y] = ends[k], away = Math.atan2(y - y0, x - x0);
      const [wide, high] = [name.offsetWidth / 2 + 1, name.offsetHeight / 2 - 1];
      const places = TURNS.map(turn => {
        const gap = 8 + Math.abs(Math.cos(away + turn)) * wide + Math.abs(Math.sin(away + turn)) * 4;
        const left = clamp(x + gap * Math.cos(away + turn), wide, look.width - wide);
        const top = clamp(y + gap * Math.sin(away + turn), high, look.height - high);
        const onLabel = taken.filter(other => Math.abs(left - other.left) < wide + other.wide && Math.abs(top - other.top) < high + other.high);
        const onArrow = ends.filter(([x1, y1], j) => j !== k && fromSegment([left, top], [x0, y0], [x1, y1]) < 9);
        return {left, top, wide, high, turn, cost: 4 * onLabel.length + onArrow.length + (turn === one.turn ? 0 : 0.4) + 0.1 * Math.abs(turn)};
      });
      const best = places.reduce((a, b) => b.cost < a.cost ? b : a);
      taken.push(best);
      Object.assign(one, best);  // a label leaves its side for a better one only
      name.style.transform = `translate(${best.left}px, ${best.top}px) translate(-50%, -50%)`;
      name.style.color = css(part.colours[0]);
      name.style.opacity = this.isHidden(tips[k], look) ? 0.45 : 1;
    });
  }

  isHidden(tip, look) {  // whether an opaque surface lies between the eye and the point
    const {film} = this;
    return film.parts.some(part => {
      if (part.kind !== "faces" || part.opacity < 1) return false;
      const [w, x, y, z] = carriedBy(film, part, look.frame), back = v => turned([w, -x, -y, -z], v);
      const from = back(tip), ray = sum(back(look.at), from, -1);  // in the axes of the part
      return part.points.some(face => {
        for (let c = 1; c + 1 < face.length; c++) {  // Möller and Trumbore 1997
          const u = sum(face[c], face[0], -1), v = sum(face[c + 1], face[0], -1);
          const p = cross(ray, v), det = dot(u, p);
          if (Math.abs(det) < 1e-12) continue;
          const s = sum(from, face[0], -1), a = dot(s, p) / det, q = cross(s, u);
          const b = dot(ray, q) / det, t = dot(v, q) / det;
          if (a >= 0 && b >= 0 && a + b <= 1 && t > 1e-3) return true;
        }
        return false;
      });
    });
  }
}

const TURNS = [0, 0.9, -0.9, 1.6, -1.6, 2.4, -2.4];  // of a label round the tip of its arrow

function fromSegment([x, y], [x0, y0], [x1, y1]) {  // the distance of a point
  const [dx, dy] = [x1 - x0, y1 - y0], share = clamp(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1), 0, 1);
  return Math.hypot(x - x0 - share * dx, y - y0 - share * dy);
}

function glPainter(canvas) {
  const gl = canvas.getContext("webgl2", {antialias: true, alpha: true, stencil: true, preserveDrawingBuffer: true});
  if (!gl) return null;
  const program = (vertex, fragment) => {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    const uniform = {}, place = {};
    for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
      const {name} = gl.getActiveUniform(made, i);
      uniform[name] = gl.getUniformLocation(made, name);
    }
    for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_ATTRIBUTES); i++) {
      const {name} = gl.getActiveAttrib(made, i);
      place[name] = gl.getAttribLocation(made, name);
    }
    return {made, uniform, place};
  };
  const surface = program(SHADERS["surface.vert"], SHADERS["surface.frag"]);
  const ribbon = program(SHADERS["line.vert"], SHADERS["line.frag"]);
  const stored = (data, usage) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, usage);
    return buffer;
  };
  const corners = stored(new Float32Array([0, -1, 0, 1, 1, -1, 1, 1]), gl.STATIC_DRAW);
  const round = Array.from({length: 48}, (_, k) => [Math.cos(Math.PI * k / 24), Math.sin(Math.PI * k / 24), 0]);
  const disc = stored(trianglesOf([round], [[0, 0, 0]]), gl.STATIC_DRAW);
  const isVector = part => part.kind in FACES_OF_VECTOR;
  let meshes = new Map(), colours = null;

  function load(film) {
    colours = dark();
    for (const {buffer} of meshes.values()) gl.deleteBuffer(buffer);
    meshes = new Map(film.parts.map(part => {
      if (isVector(part)) return [part, {buffer: gl.createBuffer(), count: 0, point: null}];
      const data = part.kind === "faces" ? trianglesOf(part.points, part.colours.map(inked))
        : new Float32Array(part.points.flat());
      return [part, {buffer: stored(data, gl.STATIC_DRAW), count: data.length / 9}];
    }));
  }

  const turnTo = (uniform, attitude) =>
    gl.uniformMatrix3fv(uniform.turn, false, [[1, 0, 0], [0, 1, 0], [0, 0, 1]].flatMap(e => turned(attitude, e)));

  function triangles(buffer, count, more = () => {}) {
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    ["position", "normal", "colour"].forEach((name, i) => {
      const place = surface.place[name];
      gl.enableVertexAttribArray(place);
      gl.vertexAttribDivisor(place, 0);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 36, 12 * i);
    });
    more();
    gl.drawArrays(gl.TRIANGLES, 0, count);
  }

  // The mesh of an arrow or a dot, made again where the point has changed.
  function vectorMesh(film, part, point) {
    const mesh = meshes.get(part);
    if (mesh.point !== point) {
      const data = trianglesOf(FACES_OF_VECTOR[part.kind](point, film.reach), part.colours.map(inked));
      gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
      [mesh.count, mesh.point] = [data.length / 9, point];
    }
    return mesh;
  }

  function solid(film, part, look, opacity = part.opacity) {
    const {uniform} = surface;
    turnTo(uniform, carriedBy(film, part, look.frame));
    gl.uniform1f(uniform.opacity, opacity);
    gl.uniform1f(uniform.gloss, part.kind === "faces" ? 0.22 : 0.1);
    const {buffer, count} = isVector(part) ? vectorMesh(film, part, pointsAt(film, part, look.frame)[0]) : meshes.get(part);
    if (part.kind !== "faces" || opacity === 1) return triangles(buffer, count);
    gl.enable(gl.CULL_FACE);  // the far side first
    for (const side of [gl.FRONT, gl.BACK]) {
      gl.cullFace(side);
      triangles(buffer, count);
    }
    return gl.disable(gl.CULL_FACE);
  }

  // A ground that fades outward, and on it the shadow in the light of a wide lamp: the mean of the shadows of its points.
  function ground(film, view, frame) {
    const {uniform, place} = surface, {reach} = film, points = 24;
    const plain = (opacity, ink) => {
      gl.uniform1f(uniform.opacity, opacity);
      gl.disableVertexAttribArray(place.colour);
      gl.vertexAttrib3f(place.colour, ...ink);
    };
    gl.uniform1f(uniform.gloss, 0);
    gl.depthMask(false);
    for (let k = 1; k <= 25; k++) {
      const turn = [0, 1, 2].flatMap(i => scaled([0, 1, 2].map(j => i === j ? 1 : 0), 1.2 * reach * k / 25));
      gl.uniformMatrix3fv(uniform.turn, false, turn);
      triangles(disc, 46 * 3, () => plain(0.009, inked("#777777")));
    }
    gl.disable(gl.DEPTH_TEST);
    gl.enable(gl.STENCIL_TEST);
    gl.stencilOp(gl.KEEP, gl.KEEP, gl.REPLACE);
    for (let k = 0; k < points; k++) {
      const out = 0.35 * Math.sqrt((k + 0.5) / points), angle = 2.4 * k;
      const [x, y] = [0.25 + out * Math.cos(angle), -0.2 + out * Math.sin(angle)];  // slopes of a ray from above
      const shadow = [1, 0, 0, 0, 0, 1, 0, 0, x, y, 0, 0, 0, 0, 0, 1];
      const flat = [0, 1, 2, 3].flatMap(j => [0, 1, 2, 3].map(i => [0, 1, 2, 3].reduce((s, m) => s + view[4 * m + i] * shadow[4 * j + m], 0)));
      gl.uniformMatrix4fv(uniform.view, false, flat);
      gl.stencilFunc(gl.NOTEQUAL, k + 1, 255);  // each dot is darkened once
      film.parts.filter(part => part.kind === "faces" && part.carried).forEach(part => {
        const {buffer, count} = meshes.get(part);
        turnTo(uniform, carriedBy(film, part, frame));
        triangles(buffer, count, () => plain(0.5 / points, [0, 0, 0]));
      });
    }
    gl.disable(gl.STENCIL_TEST);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.uniformMatrix4fv(uniform.view, false, view);
  }

  function curve(film, part, look) {
    const first = part.kind === "trail" ? trailBegin(film, look.frame) : 0;
    const last = part.kind === "trail" ? look.frame : part.points.length - 1;
    if (last <= first) return;
    const {uniform} = ribbon;
    turnTo(uniform, carriedBy(film, part, look.frame));
    gl.uniform3fv(uniform.ink, inked(part.colours[0]));
    gl.uniform1f(uniform.pieces, last - first);
    gl.uniform1f(uniform.oldest, part.kind === "trail" && film.trail !== null ? 0 : 1);
    gl.bindBuffer(gl.ARRAY_BUFFER, corners);
    const {corner} = ribbon.place;
    gl.enableVertexAttribArray(corner);
    gl.vertexAttribDivisor(corner, 0);
    gl.vertexAttribPointer(corner, 2, gl.FLOAT, false, 0, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, meshes.get(part).buffer);
    ["begin", "end"].forEach((name, i) => {
      const place = ribbon.place[name];
      gl.enableVertexAttribArray(place);
      gl.vertexAttribDivisor(place, 1);
      gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 12, 12 * (first + i));
    });
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, last - first);
  }

  function draw(film, look) {
    if (colours !== dark()) load(film);
    const {right, upward, eye, at, near, far} = look, [wide, high] = look.sides;
    const deep = (far + near) / (far - near), offset = 2 * far * near / (far - near);
    const rows = [scaled(right, wide), scaled(upward, high), scaled(eye, -deep), scaled(eye, -1)];
    const shift = [-dot(rows[0], at), -dot(rows[1], at), -dot(rows[2], at) - offset, -dot(rows[3], at)];
    const view = [0, 1, 2].flatMap(i => rows.map(row => row[i])).concat(shift);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const surfaces = () => {
      gl.useProgram(surface.made);
      gl.uniformMatrix4fv(surface.uniform.view, false, view);
      gl.uniform3fv(surface.uniform.eye, at);
      gl.uniform3fv(surface.uniform.up, film.frame[2]);
      gl.uniform3fv(surface.uniform.lamp, unit(sum(sum(eye, upward, 0.9), right, 0.5)));
    };
    const curves = () => {
      gl.useProgram(ribbon.made);
      gl.uniformMatrix4fv(ribbon.uniform.view, false, view);
      gl.uniform2f(ribbon.uniform.pixels, canvas.width, canvas.height);
      gl.uniform1f(ribbon.uniform.width, 2.2 * look.ratio);
      film.parts.filter(part => part.kind === "line" || part.kind === "trail").forEach(part => curve(film, part, look));
    };
    surfaces();
    if (film.grounded) ground(film, view, look.frame);
    film.parts.filter(part => part.kind === "faces" && part.opacity === 1).forEach(part => solid(film, part, look));
    film.parts.filter(isVector).forEach(part => solid(film, part, look));
    curves();
    surfaces();
    // Vectors inside a solid shine through it.
    gl.depthMask(false);
    gl.depthFunc(gl.GREATER);
    film.parts.filter(isVector).forEach(part => solid(film, part, look, 0.22));
    gl.depthFunc(gl.LESS);
    film.parts.filter(part => part.kind === "faces" && part.opacity < 1).forEach(part => solid(film, part, look));
    gl.depthMask(true);
  }

  const free = () => gl.getExtension("WEBGL_lose_context")?.loseContext();
  return {load, draw, free, name: "WebGL2"};
}

// Without WebGL2: polygons and lines from the farthest to the nearest.
function flatPainter(canvas) {
  const pen = canvas.getContext("2d");
  function draw(film, look) {
    const drawn = [];
    for (const part of film.parts) {
      const points = placed(film, part, look.frame), ink = part.colours.map(c => css(c, part.opacity));
      if (part.kind === "faces") {
        points.forEach((face, i) => {
          const corners = face.map(look.project);
          drawn.push({depth: corners.reduce((s, p) => s + p[2], 0) / corners.length, corners, fill: ink[i % ink.length]});
        });
        continue;
      }
      const ends = part.kind === "arrow" || part.kind === "planet" ? Array.from({length: 9}, (_, k) => scaled(points[0], k / 8)) : points;
      const seen = ends.map(look.project), before = 0.03 * film.reach;
      if (part.kind === "dot" || part.kind === "planet") drawn.push({depth: seen.at(-1)[2] - before, corners: [seen.at(-1)], dot: ink[0], wide: part.kind === "dot" ? 5 : 12});
      for (let k = 0; k + 1 < seen.length; k++)
        drawn.push({depth: 0.5 * (seen[k][2] + seen[k + 1][2]) - before, corners: [seen[k], seen[k + 1]], stroke: ink[0]});
      if (part.kind === "arrow") {
        const [tip, from] = [seen[8], seen[6]], long = Math.hypot(tip[0] - from[0], tip[1] - from[1]) || 1;
        const [dx, dy] = [(tip[0] - from[0]) / long * 12, (tip[1] - from[1]) / long * 12];
        drawn.push({depth: tip[2] - before, fill: ink[0], corners: [tip,
          [tip[0] - dx - 0.35 * dy, tip[1] - dy + 0.35 * dx], [tip[0] - dx + 0.35 * dy, tip[1] - dy - 0.35 * dx]]});
      }
    }
    drawn.sort((a, b) => b.depth - a.depth);
    pen.setTransform(look.ratio, 0, 0, look.ratio, 0, 0);
    pen.clearRect(0, 0, look.width, look.height);
    pen.lineWidth = 2;
    for (const {corners, fill, stroke, dot: spot, wide} of drawn) {
      pen.beginPath();
      if (spot) pen.arc(corners[0][0], corners[0][1], wide, 0, 7);
      corners.forEach(([x, y], i) => i ? pen.lineTo(x, y) : spot || pen.moveTo(x, y));
      if (stroke) pen.strokeStyle = stroke, pen.stroke();
      else pen.fillStyle = spot ?? fill, pen.fill();
    }
  }
  return {load() {}, draw, free() {}, name: "Canvas"};
}
