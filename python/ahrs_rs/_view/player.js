"use strict";
// What is told to who looks at the page from outside (a test): plots drawn, frames drawn, errors.
const told = document.documentElement.dataset;
told.drawn = 0;
told.frames = 0;
const element = id => document.getElementById(id);
const COLOURS = ["#1f77b4", "#ff7f0e", "#2ca02c", "#9467bd", "#8c564b", "#e377c2"];
const REFERENCE = "#555555";
const FULL = 32767, MISSING = -32768;
// Of the arrow of gravity, and of the usual field, in halves of the board.
const LENGTH = 1.2;
const ARROWS = {
  gravity: {colour: "#333333", label: "gravity"},
  acc: {colour: "#c0392b", label: "specific force"},
  mag: {colour: "#8e44ad", label: "magnetic field"},
};

function numbers(text, kind) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new kind(bytes.buffer);
}

const scenes = JSON.parse(element("scenes").textContent);

// -- one recording ---------------------------------------------------------------------------------------------------

let scene, now = 0, playing = false, last = null, speed = 1, solid = 0, hidden = new Set();

function open(index) {
  scene = scenes[index];
  if (!scene.times) {
    scene.times = numbers(scene.t, Float32Array);
    scene.bodies.forEach((body, number) => {
      body.frames = numbers(body.quat, Int16Array);
      body.colour = body.reference ? REFERENCE : COLOURS[number % COLOURS.length];
    });
    scene.status.forEach(one => { one.frames = numbers(one.bits, Uint16Array); });
    for (const sensor of ["acc", "mag"]) if (scene[sensor]) scene[sensor].frames = numbers(scene[sensor].values, Int16Array);
    scene.step = scene.times.length > 1 ? scene.end / (scene.times.length - 1) : 0;
  }
  solid = 0;
  hidden = new Set();
  now = 0;
  element("time").max = scene.end || 1;
  element("note").textContent = scene.note;
  choices();
  plots();
  draw();
}

function choices() {
  element("bodies").replaceChildren(...scene.bodies.map((body, number) => option(body.name, body.colour, number)));
  const arrows = Object.keys(ARROWS).filter(name => name === "gravity" || scene[name]);
  element("arrows").replaceChildren(...arrows.map(name => option(ARROWS[name].label, ARROWS[name].colour, name)));
}

function option(text, colour, key) {
  const label = document.createElement("label"), box = document.createElement("input"), swatch = document.createElement("span");
  box.type = "checkbox";
  box.checked = true;
  box.addEventListener("change", () => { box.checked ? hidden.delete(key) : hidden.add(key); draw(); });
  swatch.className = "swatch";
  swatch.style.background = colour;
  label.append(box, swatch, text);
  return label;
}

// The frame at or before a time.
function frameAt(time) {
  const times = scene.times;
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time + 1e-6) low = middle; else high = middle - 1;
  }
  return low;
}

const inGap = time => scene.gaps.some(([begin, end]) => time > begin + 1e-6 && time < end - 1e-6);

// The orientation of a body, along the line between two frames; null where it is not known.
function attitude(body, index, part) {
  const q = [0, 1, 2, 3].map(k => body.frames[4 * index + k] / FULL);
  if (q.every(one => one === 0)) return null;
  if (part > 0 && index + 1 < scene.times.length) {
    const next = [0, 1, 2, 3].map(k => body.frames[4 * index + 4 + k] / FULL);
    if (next.some(one => one !== 0)) {
      const sign = q.reduce((sum, one, k) => sum + one * next[k], 0) < 0 ? -1 : 1;
      for (let k = 0; k < 4; k++) q[k] += part * (sign * next[k] - q[k]);
    }
  }
  const norm = Math.hypot(...q);
  return q.map(one => one / norm);
}

function turn([w, x, y, z], [a, b, c]) {
  const d = y * c - z * b + w * a, e = z * a - x * c + w * b, f = x * b - y * a + w * c;
  return [a + 2 * (y * f - z * e), b + 2 * (z * d - x * f), c + 2 * (x * e - y * d)];
}

function reading(sensor, index) {
  const one = scene[sensor];
  if (!one || one.frames[3 * index] === MISSING) return null;
  return [0, 1, 2].map(k => one.frames[3 * index + k] / FULL * one.scale / one.usual);
}

// -- the board in space ----------------------------------------------------------------------------------------------

const canvas = element("board"), pen = canvas.getContext("2d");
let azimuth = -2.2, elevation = 0.42, zoom = 1;

function project([x, y, z]) {
  // East, north, up, seen from a camera that goes round.
  const a = Math.cos(azimuth) * x + Math.sin(azimuth) * y, b = -Math.sin(azimuth) * x + Math.cos(azimuth) * y;
  const depth = Math.cos(elevation) * a + Math.sin(elevation) * z, height = -Math.sin(elevation) * a + Math.cos(elevation) * z;
  const scale = zoom * 0.19 * Math.min(canvas.width, 1.6 * canvas.height) * 6 / (6 - depth);
  return [canvas.width / 2 + scale * b, canvas.height / 2 - scale * height, depth];
}

const HALF = [0.9, 0.6, 0.12];
const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map(k => HALF.map((half, axis) => (k >> axis) & 1 ? half : -half));
const FACES = [[4, 5, 7, 6], [0, 2, 3, 1], [1, 3, 7, 5], [0, 4, 6, 2], [2, 6, 7, 3], [0, 1, 5, 4]];
const EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
const NORMALS = [[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]];

function path(points) {
  pen.beginPath();
  points.forEach(([x, y], index) => index ? pen.lineTo(x, y) : pen.moveTo(x, y));
}

function shade(colour, light) {
  const parts = [1, 3, 5].map(k => parseInt(colour.slice(k, k + 2), 16));
  return `rgb(${parts.map(one => Math.round(one + (255 - one) * light)).join(",")})`;
}

function box(q, colour) {
  const corners = CORNERS.map(corner => project(turn(q, corner)));
  const order = FACES.map((face, index) => [face, index, face.reduce((sum, k) => sum + corners[k][2], 0)]);
  order.sort((a, b) => a[2] - b[2]);
  for (const [face, index] of order) {
    path(face.map(k => corners[k]));
    pen.closePath();
    pen.fillStyle = shade(colour, 0.25 + 0.3 * (1 + turn(q, NORMALS[index])[2]) / 2);
    pen.strokeStyle = colour;
    pen.lineWidth = 1.2 * devicePixelRatio;
    pen.fill();
    pen.stroke();
    // The upper side has a mark at the end of x.
    if (index === 0) {
      path([[0.85, 0, HALF[2]], [0.6, 0.16, HALF[2]], [0.6, -0.16, HALF[2]]].map(one => project(turn(q, one))));
      pen.closePath();
      pen.fillStyle = "white";
      pen.fill();
    }
  }
}

function ghost(q, colour) {
  const corners = CORNERS.map(corner => project(turn(q, corner)));
  pen.save();
  pen.globalAlpha = 0.8;
  pen.setLineDash([5 * devicePixelRatio, 3 * devicePixelRatio]);
  pen.strokeStyle = colour;
  pen.lineWidth = 1.5 * devicePixelRatio;
  for (const [a, b] of EDGES) { path([corners[a], corners[b]]); pen.stroke(); }
  pen.restore();
}

function arrow(from, to, colour, text) {
  const a = project(from), b = project(to);
  const angle = Math.atan2(b[1] - a[1], b[0] - a[0]), size = 9 * devicePixelRatio;
  pen.strokeStyle = pen.fillStyle = colour;
  pen.lineWidth = 2 * devicePixelRatio;
  path([a, b]);
  pen.stroke();
  path([b, ...[2.7, -2.7].map(side => [b[0] + size * Math.cos(angle + side), b[1] + size * Math.sin(angle + side)])]);
  pen.closePath();
  pen.fill();
  if (text) {
    pen.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
    pen.fillText(text, b[0] + 6 * devicePixelRatio, b[1] - 4 * devicePixelRatio);
  }
}

function ground() {
  pen.strokeStyle = "#dde1e6";
  pen.lineWidth = devicePixelRatio;
  const end = 2, level = -1.3;
  for (let k = -end; k <= end; k += 0.5) {
    path([project([k, -end, level]), project([k, end, level])]);
    pen.stroke();
    path([project([-end, k, level]), project([end, k, level])]);
    pen.stroke();
  }
  const corner = [-1.5, 1.5, level];
  arrow(corner, [-0.8, 1.5, level], "#8a949e", "east");
  arrow(corner, [-1.5, 2.2, level], "#8a949e", "north");
  arrow(corner, [-1.5, 1.5, level + 0.7], "#8a949e", "up");
}

function drawBoard() {
  const width = Math.round(canvas.clientWidth * devicePixelRatio), height = Math.round(canvas.clientHeight * devicePixelRatio);
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  pen.clearRect(0, 0, width, height);
  ground();
  const index = frameAt(now), gap = inGap(now);
  const step = index + 1 < scene.times.length ? scene.times[index + 1] - scene.times[index] : 0;
  const part = gap || step <= 0 ? 0 : Math.min(Math.max((now - scene.times[index]) / step, 0), 1);
  const attitudes = scene.bodies.map(body => attitude(body, index, part));
  pen.globalAlpha = gap ? 0.25 : 1;
  const main = attitudes[solid];
  if (main && !hidden.has(solid)) box(main, scene.bodies[solid].colour);
  attitudes.forEach((q, number) => { if (q && number !== solid && !hidden.has(number)) ghost(q, scene.bodies[number].colour); });
  if (!hidden.has("gravity")) arrow([0, 0, 0], [0, 0, -LENGTH], ARROWS.gravity.colour, "g");
  for (const sensor of ["acc", "mag"]) {
    const vector = reading(sensor, index);
    if (main && vector && !gap && !hidden.has(sensor)) {
      arrow([0, 0, 0], turn(main, vector).map(one => LENGTH * one), ARROWS[sensor].colour, sensor);
    }
  }
  pen.globalAlpha = 1;
  if (gap) {
    pen.fillStyle = "#a3211a";
    pen.font = `${15 * devicePixelRatio}px system-ui, sans-serif`;
    pen.fillText("gap: no angular rate was measured", 14 * devicePixelRatio, 26 * devicePixelRatio);
  }
  told.gap = gap ? 1 : 0;
  tell(index, attitudes);
}

function tell(index, attitudes) {
  const flags = scene.status.map(one => {
    const bits = one.frames[index];
    const names = Object.entries(scene.flags).filter(([bit]) => bits & bit).map(([, name]) => name);
    return `${one.name}: ${names.join(" ") || "no flag"}`;
  });
  const apart = attitudes.map((q, number) => {
    const main = attitudes[solid];
    if (!q || !main || number === solid) return null;
    const cosine = Math.min(Math.abs(q.reduce((sum, one, k) => sum + one * main[k], 0)), 1);
    return `${scene.bodies[number].name}: ${(2 * Math.acos(cosine) * 180 / Math.PI).toFixed(1)}° from ${scene.bodies[solid].name}`;
  });
  element("now").textContent = [`${now.toFixed(2)} s of ${scene.end.toFixed(2)} s`, ...apart.filter(one => one), ...flags].join("\n");
}

// -- plots -----------------------------------------------------------------------------------------------------------

const below = element("plots");

function plots() {
  const data = [], rows = ["roll", "pitch", "yaw"];
  rows.forEach((angle, row) => scene.bodies.forEach(body => data.push({
    type: "scatter", mode: "lines", name: body.name, legendgroup: body.name, showlegend: row === 0,
    x: numbers(body.angles[angle].x, Float32Array), y: numbers(body.angles[angle].y, Float32Array),
    yaxis: row ? `y${row + 1}` : "y",
    line: {color: body.colour, width: body.reference ? 1 : 1.3, dash: body.reference ? "dash" : "solid"},
    hovertemplate: "%{y:.2f}°",
  })));
  scene.status.forEach((one, number) => Object.entries(one.spans).forEach(([flag, spans]) => {
    const label = `${one.name} ${flag}`;
    data.push({
      type: "scatter", mode: "lines", name: label, showlegend: false, yaxis: "y4", hoverinfo: "name",
      x: spans.flatMap(([begin, end]) => [begin, end, null]), y: spans.flatMap(() => [label, label, null]),
      line: {color: COLOURS[number % COLOURS.length], width: 7},
    });
  }));
  const axis = {showgrid: true, gridcolor: "#eceff2", zeroline: false};
  const layout = {
    margin: {l: 150, r: 20, t: 10, b: 40}, hovermode: "x", dragmode: "zoom", uirevision: scene.name,
    legend: {orientation: "h", y: 1.06},
    xaxis: {...axis, anchor: "y4", range: [0, scene.end || 1], title: {text: "time [s]"}},
    yaxis: {...axis, domain: [0.77, 1], title: {text: "roll [°]"}},
    yaxis2: {...axis, domain: [0.51, 0.74], title: {text: "pitch [°]"}},
    yaxis3: {...axis, domain: [0.25, 0.48], title: {text: "yaw [°]"}},
    yaxis4: {...axis, domain: [0, 0.22], type: "category", autorange: "reversed", fixedrange: true},
    shapes: scene.gaps.map(([begin, end]) => ({
      type: "rect", xref: "x", yref: "paper", x0: begin, x1: end, y0: 0, y1: 1, fillcolor: "#bbbbbb", opacity: 0.4,
      line: {width: 0}, layer: "below",
    })),
  };
  told.drawn = 0;
  Plotly.newPlot(below, data, layout, {responsive: true, displaylogo: false}).then(() => {
    told.drawn = data.length;
    below.removeAllListeners("plotly_click");
    below.removeAllListeners("plotly_afterplot");
    below.on("plotly_click", event => { now = Math.min(Math.max(event.points[0].x, 0), scene.end); draw(); });
    below.on("plotly_afterplot", cursor);
    cursor();
  }).catch(error => { told.errors = String(error); });
}

function cursor() {
  const layout = below._fullLayout, line = element("cursor");
  if (!layout || !layout.xaxis) return;
  const x = layout.xaxis, place = x.d2p(now);
  line.style.display = place >= 0 && place <= x._length ? "block" : "none";
  line.style.left = `${x._offset + place}px`;
  line.style.top = `${layout.margin.t}px`;
  line.style.height = `${layout.height - layout.margin.t - layout.margin.b}px`;
}

// -- time ------------------------------------------------------------------------------------------------------------

function draw() {
  drawBoard();
  element("time").value = now;
  cursor();
  told.frames = Number(told.frames) + 1;
  told.now = now.toFixed(3);
}

function tick(stamp) {
  if (!playing) return;
  if (last !== null) now += speed * (stamp - last) / 1000;
  last = stamp;
  if (now >= scene.end) { now = scene.end; play(false); }
  draw();
  if (playing) requestAnimationFrame(tick);
}

function play(on) {
  playing = on;
  last = null;
  element("play").textContent = on ? "pause" : "play";
  if (on) {
    if (now >= scene.end) now = 0;
    requestAnimationFrame(tick);
  }
}

element("play").addEventListener("click", () => play(!playing));
element("time").addEventListener("input", event => { now = Number(event.target.value); last = null; draw(); });
element("speed").addEventListener("change", event => { speed = Number(event.target.value); });
element("recording").addEventListener("change", event => { play(false); open(Number(event.target.value)); });
document.addEventListener("keydown", event => {
  if (["INPUT", "SELECT", "BUTTON"].includes(event.target.tagName)) return;
  if (event.key === " ") { event.preventDefault(); play(!playing); }
  const jump = {ArrowLeft: -1, ArrowRight: 1}[event.key];
  if (jump) { now = Math.min(Math.max(now + jump * (event.shiftKey ? 10 : 1), 0), scene.end); draw(); }
});
let held = null;
canvas.addEventListener("pointerdown", event => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
canvas.addEventListener("pointerup", () => { held = null; });
canvas.addEventListener("pointermove", event => {
  if (!held) return;
  azimuth -= 0.008 * (event.clientX - held[0]);
  elevation = Math.min(Math.max(elevation + 0.008 * (event.clientY - held[1]), -1.5), 1.5);
  held = [event.clientX, event.clientY];
  draw();
});
canvas.addEventListener("wheel", event => {
  event.preventDefault();
  zoom = Math.min(Math.max(zoom * Math.exp(-0.001 * event.deltaY), 0.3), 4);
  draw();
}, {passive: false});
window.addEventListener("resize", draw);

element("recording").replaceChildren(...scenes.map((one, index) => {
  const choice = document.createElement("option");
  choice.value = index;
  choice.textContent = one.name;
  return choice;
}));
element("recordings").hidden = scenes.length < 2;
open(0);
// page.html#play=2.5 begins to play at 2.5 s, page.html#at=2.5 stands there.
const begin = /^#(play|at)=?([\d.]*)$/.exec(location.hash);
if (begin) {
  now = Math.min(Number(begin[2] || 0), scene.end);
  draw();
  if (begin[1] === "play") play(true);
}
