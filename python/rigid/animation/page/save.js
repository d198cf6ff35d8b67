// What the player shows, without its controls, as a picture or as a video.
function composed(player, canvas) {
  const {root} = player, ratio = Math.min(window.devicePixelRatio || 1, 2), box = root.getBoundingClientRect();
  const height = root.querySelector("footer").getBoundingClientRect().top - box.top, pen = canvas.getContext("2d");
  const [wide, high] = [box.width, height].map(x => 2 * Math.round(x * ratio / 2));  // even, for videos
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.fillStyle = getComputedStyle(root).backgroundColor;
  pen.fillRect(0, 0, box.width, height);
  for (const one of root.querySelectorAll("canvas")) {
    const place = one.getBoundingClientRect();
    if (place.width && place.height) pen.drawImage(one, place.left - box.left, place.top - box.top, place.width, place.height);
  }
  for (const one of root.querySelectorAll(".written, .name")) written(pen, one, box);
  pen.fillStyle = getComputedStyle(root).color;
  pen.font = "13px ui-monospace, monospace";
  pen.globalAlpha = 1;
  pen.fillText(player.clock.textContent, 14, root.querySelector(".charts").getBoundingClientRect().top - box.top - 8);
}

// The words of an element, where the page shows them.
function written(pen, element, box) {
  const walk = document.createTreeWalker(element, NodeFilter.SHOW_TEXT), range = document.createRange();
  for (let node = walk.nextNode(); node; node = walk.nextNode()) {
    const style = getComputedStyle(node.parentElement);
    [pen.font, pen.fillStyle, pen.globalAlpha] = [style.font, style.color, style.opacity];
    for (const {0: word, index} of node.data.matchAll(/\S+/g)) {
      range.setStart(node, index);
      range.setEnd(node, index + word.length);
      const place = range.getBoundingClientRect(), {fontBoundingBoxAscent: above, fontBoundingBoxDescent: below} = pen.measureText(word);
      if (place.width) pen.fillText(word, place.left - box.left, place.top - box.top + 0.5 * (place.height + above - below));
    }
  }
}

function saved(blob, name) {
  const link = document.createElement("a");
  [link.href, link.download] = [URL.createObjectURL(blob), name];
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function savePicture(player) {
  const canvas = document.createElement("canvas");
  composed(player, canvas);
  canvas.toBlob(blob => saved(blob, "film.png"), "image/png");
}

// The film from its first frame to its last, as fast as it plays; WebM, or MP4 where a browser writes no WebM.
class Recorder {
  constructor(player, ended) {
    this.player = player;
    this.canvas = document.createElement("canvas");
    composed(player, this.canvas);
    const kind = ["webm", "mp4"].find(one => MediaRecorder.isTypeSupported(`video/${one}`)), parts = [];
    this.recorder = new MediaRecorder(this.canvas.captureStream(), {mimeType: `video/${kind}`, videoBitsPerSecond: 8e6});
    this.recorder.ondataavailable = event => parts.push(event.data);
    this.recorder.onstop = () => {
      saved(new Blob(parts, {type: `video/${kind}`}), `film.${kind}`);
      ended();
    };
    this.frame = -1;
    player.seek(0);
    player.play(true);
    this.recorder.start();
  }

  draw() {  // called after each frame of the player; a film that begins again has ended
    const {frame} = this.player;
    if (frame < this.frame) return this.stop();
    this.frame = frame;
    composed(this.player, this.canvas);
  }

  stop() {
    if (this.recorder.state === "recording") this.recorder.stop();
  }
}
