// The player: a clock, the controls, the keys; it shows films of equal times side by side.
const HELP = [["space", "play, pause"], ["← →", "frame by frame"], ["+ −", "faster, slower"],
  ["Home End", "first, last frame"], ["r", "reset the view"], ["f", "full screen"],
  ["s", "save a picture (PNG)"], ["v", "save a video: from the first frame to the last"], ["h", "this help"],
  ["drag, pinch", "turn, come closer"]];
const CORNERS = `<svg width="14" height="14" viewBox="0 0 14 14" aria-hidden="true">
  <path d="M1 5V1h4M9 1h4v4M13 9v4H9M5 13H1V9" fill="none" stroke="currentColor" stroke-width="1.6"/></svg>`;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];

class Player {
  constructor(root, more = []) {  // more keys, with what they do
    this.root = root;
    this.elapsed = 0;
    this.frame = 0;
    this.speed = 1;
    this.last = null;
    this.playing = false;
    root.classList.add("player");
    const heading = document.querySelector("h1") ? "h2" : "h1";  // of a film inside a page, or of a page
    root.innerHTML = `<${heading} class="story written"></${heading}><p class="meanings written"></p><div class="stages"></div><div class="charts"></div>
      <footer><button type="button" class="play" aria-pressed="false"></button>
      <input type="range" min="0" value="0" step="1" aria-label="time"><output></output>
      <label><span>speed</span> <select aria-label="speed">${SPEEDS.map(x => `<option value="${x}">× ${x}</option>`).join("")}</select></label>
      <button type="button" class="reset" title="reset the view (r)">reset view</button>
      <button type="button" class="picture" title="save a picture (s)">PNG</button>
      <button type="button" class="video" title="save a video (v)" aria-pressed="false">video</button>
      <button type="button" class="full" title="full screen (f)" aria-label="full screen">${CORNERS}</button>
      <button type="button" class="help" aria-expanded="false" aria-label="keys" title="keys (h)">?</button></footer>
      <dl class="keys" hidden>${[...HELP, ...more].map(([key, what]) => `<dt>${key}</dt><dd>${what}</dd>`).join("")}</dl>`;
    const find = name => root.querySelector(name);
    [this.button, this.slider, this.clock, this.chosen] = [".play", "input", "output", "select"].map(find);
    this.button.onclick = () => this.play(!this.playing);
    this.slider.oninput = () => this.seek(Number(this.slider.value));
    this.chosen.value = "1";
    this.chosen.onchange = () => { this.speed = Number(this.chosen.value); };
    find(".reset").onclick = () => this.camera.reset();
    find(".picture").onclick = () => savePicture(this);
    find(".video").onclick = () => this.record();
    find(".video").hidden = !window.MediaRecorder;
    find(".full").onclick = () => this.fill();
    find(".help").onclick = () => this.help();
    document.addEventListener("keydown", event => this.key(event));
    this.stages = [];
    this.charts = [];
    requestAnimationFrame(now => this.tick(now));
  }

  show(films, story) {
    this.recorder?.stop();
    const find = name => this.root.querySelector(name), first = films[0];
    this.stages.forEach(stage => stage.remove());
    find(".stages").replaceChildren();
    find(".story").textContent = story;
    this.explain(films);
    this.films = films;
    this.due = first.shown.reduce((times, shown) => [...times, times[times.length - 1] + shown], [0]);
    this.slider.max = first.t.length - 1;
    const rate = Math.abs(first.t.at(-1) - first.t[0]) / this.due.at(-1);  // of the film, over the motion
    for (const option of this.chosen.options) option.textContent = `× ${Number((option.value * rate).toPrecision(2))}`;
    this.camera ??= new Camera(first.camera);
    this.stages = films.map(film => {
      const holder = document.createElement("div");
      holder.className = "holder";
      find(".stages").append(holder);
      if (films.length > 1) holder.innerHTML = `<p class="which written"></p>`, holder.firstChild.textContent = film.name;
      return new Stage(holder, film, this.camera, `${film.title}: film of the motion; drag to turn it`);
    });
    if (!this.stages.every(stage => stage.painter.name === "WebGL2")) find(".story").textContent += "; without WebGL2, so drawn without depth and light";
    this.chart();
    this.seek(0);
    this.play(!window.matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  // The words for what is drawn, each meaning once with all its labels.
  explain([film]) {
    const words = [film.title];
    film.parts.filter(part => part.meaning).forEach((part, k, all) => {
      const mark = document.createElement("b");
      mark.textContent = part.label || {faces: "■", line: "○", trail: "—"}[part.kind];
      mark.dataset.ink = part.colours[0];
      words.push(k && all[k - 1].meaning === part.meaning ? ", " : "; ", mark);
      if (all[k + 1]?.meaning !== part.meaning) words.push(` ${part.meaning}`);
    });
    this.root.querySelector(".meanings").replaceChildren(...words);
  }

  record() {
    if (this.recorder) return this.recorder.stop();
    const button = this.root.querySelector(".video"), mark = recording => button.setAttribute("aria-pressed", String(recording));
    this.recorder = new Recorder(this, () => { this.recorder = null; mark(false); });
    mark(true);
  }

  chart() {  // what stands beside the stages
    const charts = this.root.querySelector(".charts"), canvas = name => {
      const made = document.createElement("canvas");
      made.className = name;
      charts.append(made);
      return made;
    };
    charts.replaceChildren();
    this.charts = this.films.flatMap(film => [
      ...(film.polhode ? [new Sphere(canvas("sphere"), film)] : []),
      new StripChart(canvas("strip"), film, frame => this.seek(frame))]);
    this.stale = true;
  }

  play(playing) {
    this.playing = playing;
    this.button.textContent = playing ? "pause" : "play";
    this.button.setAttribute("aria-pressed", String(playing));
  }

  seek(frame) {
    this.frame = clamp(frame, 0, this.films[0].t.length - 1);
    this.elapsed = this.due[this.frame];
    this.stale = true;
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || !this.films) return;
    if (event.target instanceof HTMLSelectElement) return;
    const onControl = event.target instanceof HTMLButtonElement || event.target instanceof HTMLInputElement;
    const step = by => { this.play(false); this.seek(this.frame + by); };
    const pace = by => {
      const k = clamp(SPEEDS.indexOf(this.speed) + by, 0, SPEEDS.length - 1);
      this.speed = SPEEDS[k];
      this.chosen.value = String(this.speed);
    };
    const actions = {" ": () => this.play(!this.playing), ArrowLeft: () => step(-1), ArrowRight: () => step(1),
      "+": () => pace(1), "=": () => pace(1), "-": () => pace(-1), Home: () => step(-Infinity), End: () => step(Infinity),
      r: () => this.camera.reset(), f: () => this.fill(), s: () => savePicture(this), v: () => this.record(), h: () => this.help()};
    const action = actions[event.key];
    if (!action || (onControl && event.key === " " && event.target !== this.slider)) return;
    event.preventDefault();
    action();
  }

  fill() {
    if (document.fullscreenElement) document.exitFullscreen();
    else this.root.requestFullscreen?.();
  }

  help() {
    const keys = this.root.querySelector(".keys");
    keys.hidden = !keys.hidden;
    this.root.querySelector(".help").setAttribute("aria-expanded", String(!keys.hidden));
  }

  tick(now) {
    requestAnimationFrame(next => this.tick(next));
    if (!this.films) return;
    const passed = this.last === null ? 0 : (now - this.last) / 1000 * this.speed;
    this.last = now;
    if (this.playing) {
      const total = this.due[this.due.length - 1];
      this.elapsed = total > 0 ? (this.elapsed + passed) % total : 0;
      if (this.due[this.frame] > this.elapsed) this.frame = 0;
      while (this.frame + 1 < this.films[0].t.length && this.due[this.frame + 1] <= this.elapsed) this.frame++;
    }
    const {frame, camera} = this, [film] = this.films, {root} = this;
    const look = [frame, camera.azimuth, camera.elevation, camera.zoom, root.clientWidth, root.clientHeight, dark()].join();
    if (look === this.shown && !this.stale) return;
    [this.shown, this.stale] = [look, false];
    this.slider.value = frame;
    const {unit, factor} = film.clock ?? SECONDS;
    this.clock.textContent = `t = ${(factor * film.t[frame]).toFixed(film.digits)} ${unit}`;
    this.slider.setAttribute("aria-valuetext", this.clock.textContent);
    this.root.querySelectorAll(".meanings b").forEach(mark => { mark.style.color = css(mark.dataset.ink); });
    this.stages.forEach(stage => stage.draw(frame));
    this.charts.forEach(chart => chart.draw(frame));
    this.recorder?.draw();
  }
}
