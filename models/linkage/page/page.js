"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const count = data.status.length, flat = data.dimensions === 2;
const there = [...Array(count).keys()].filter((pose) => data.point.place[pose][0] !== null);
const WIDTH = 800, HEIGHT = 600, ROUND = 48;
const state = { pose: there.find((pose) => data.status[pose] === "regular") ?? there[0], load: 1, radii: data.limits.map(() => 1), magnify: 1, yaw: -0.6, pitch: 0.5 };

// -- numbers ---------------------------------------------------------------------------------------------------------

const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
const norm = (a) => Math.sqrt(dot(a, a));
const scaled = (a, factor) => a.map((value) => value * factor);
const plus = (a, b) => a.map((value, k) => value + b[k]);

// What may be the same at all poses, or a list by pose.
const at = (value, pose) => (Array.isArray(value) ? value[pose] : value);
const unknown = (pose, what) => !data.limits.length || data.limits.some((limit) => limit[what][pose].flat().includes(null));

// The outermost displacement in a direction, or rotation: each deviation goes as far as it can along what it does there.
function outermost(pose, n, what = "by") {
  const total = Array(n.length).fill(0), shares = [];
  data.limits.forEach((limit, index) => {
    const by = limit[what][pose], radius = at(limit.radius, pose) * state.radii[index], middle = at(limit.middle, pose);
    const along = by[0].map((_, m) => by.reduce((sum, row, k) => sum + row[m] * n[k], 0)), size = norm(along);
    const before = dot(total, n);
    for (let k = 0; k < total.length; k += 1) {
      if (size > 0) total[k] += (radius * dot(by[k], along)) / size;
      total[k] += by[k][0] * middle;
    }
    shares.push(dot(total, n) - before);
  });
  return { total, shares };
}

// Directions that lie evenly: two on a line, others on a circle or a sphere.
function around(dimensions) {
  if (dimensions === 1) return [[1], [-1]];
  const found = [];
  for (let k = 0; k < (dimensions === 2 ? 90 : 400); k += 1) {
    if (dimensions === 2) found.push([Math.cos((k * Math.PI) / 45), Math.sin((k * Math.PI) / 45)]);
    else {
      const z = 1 - (2 * k + 1) / 400, r = Math.sqrt(1 - z * z), turn = k * Math.PI * (3 - Math.sqrt(5));
      found.push([r * Math.cos(turn), r * Math.sin(turn), z]);
    }
  }
  return found;
}
const directions = { by: around(data.dimensions), turn: around(flat ? 1 : 3) };

// The largest displacement of all: along the displacement that is outermost in a direction it is larger still.
function largest(pose, what = "by") {
  if (unknown(pose, what)) return null;
  const starts = directions[what].map((n) => [norm(outermost(pose, n, what).total), n]).sort((a, b) => b[0] - a[0]).slice(0, 4);
  let best = { size: 0, direction: directions[what][0], shares: data.limits.map(() => 0) };
  for (const [, start] of starts) {
    let n = start, found = outermost(pose, n, what), size = norm(found.total);
    for (let step = 0; step < 400 && size > 0; step += 1) {
      n = scaled(found.total, 1 / size);
      const next = outermost(pose, n, what), larger = norm(next.total);
      found = next;
      if (larger <= size * (1 + 1e-15)) { size = Math.max(size, larger); break; }
      size = larger;
    }
    if (size > best.size) best = { size, direction: n, shares: found.shares };
  }
  return best;
}

// What is linear between all that acts and what acts beside the loads.
function acting(part, pose) {
  const whole = part.whole[pose];
  if (whole.includes(null) || (part.beside && part.beside[pose].includes(null))) return null;
  return part.beside ? plus(scaled(part.beside[pose], 1 - state.load), scaled(whole, state.load)) : scaled(whole, state.load);
}
function bounded(part, pose) {
  const sizes = [scaled(part.whole[pose], Math.abs(state.load))];
  if (part.beside) sizes.push(scaled(part.beside[pose], Math.abs(1 - state.load)));
  if (sizes.some((each) => each.includes(NaN)) || part.whole[pose].includes(null)) return null;
  return Math.max(...sizes.reduce(plus));
}

// -- drawing ---------------------------------------------------------------------------------------------------------

const every = Object.values(data.points).concat([data.point.place], data.springs.flat()).flat().filter((p) => p[0] !== null);

function turned(p) {
  if (flat) return p;
  const [x, y, z] = p, cy = Math.cos(state.yaw), sy = Math.sin(state.yaw), cp = Math.cos(state.pitch), sp = Math.sin(state.pitch);
  const u = cy * x - sy * y, v = sy * x + cy * y;
  return [u, cp * z + sp * v];
}

const middle = [0, 1, 2].slice(0, data.dimensions).map((k) => {
  const all = every.map((p) => p[k]);
  return (Math.min(...all) + Math.max(...all)) / 2;
});
const reach = Math.max(...every.map((p) => norm(plus(p, scaled(middle, -1)))), 1e-300);
const seen = flat ? every.map((p) => plus(p, scaled(middle, -1))) : null;
const zoom = flat
  ? Math.min((0.44 * WIDTH) / Math.max(...seen.map((p) => Math.abs(p[0])), reach / 50),
    (0.42 * HEIGHT) / Math.max(...seen.map((p) => Math.abs(p[1])), reach / 50))
  : (0.44 * HEIGHT) / reach;

function place(p) {
  const [u, v] = turned(plus(p, scaled(middle, -1)));
  return [WIDTH / 2 + zoom * u, HEIGHT / 2 - zoom * v];
}
const lines = (points, close) => points.map((p, k) => `${k ? "L" : "M"}${p[0].toFixed(2)} ${p[1].toFixed(2)}`).join("") + (close ? "Z" : "");

// Corners of the convex outline of points, in order.
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (row) => {
    const kept = [];
    for (const p of row) {
      while (kept.length > 1) {
        const [a, b] = kept.slice(-2);
        if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
        kept.pop();
      }
      kept.push(p);
    }
    return kept.slice(0, -1);
  };
  return half(sorted).concat(half(sorted.reverse()));
}

function element(name, attributes, parent) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent.appendChild(made);
  return made;
}
const view = document.getElementById("view");
view.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
const cloud = element("path", { class: "cloud" }, view), band = element("path", { class: "band" }, view), path = element("path", { class: "path" }, view);
const shapes = element("g", {}, view), region = element("path", { class: "reach" }, view), marks = element("g", {}, view);

// The displaced point's zone as it is seen: outermost in the directions of the drawing's plane.
function zone(pose, corners = ROUND) {
  if (unknown(pose, "by")) return "";
  const here = place(data.point.place[pose]), outline = [];
  for (let k = 0; k < corners; k += 1) {
    const angle = (2 * Math.PI * k) / corners, c = Math.cos(angle), s = Math.sin(angle);
    const n = flat ? [c, s] : inSpace(c, s);
    const [u, v] = turned(outermost(pose, n).total);
    outline.push([here[0] + zoom * state.magnify * u, here[1] - zoom * state.magnify * v]);
  }
  return lines(outline, true);
}
function inSpace(u, v) {
  const cy = Math.cos(state.yaw), sy = Math.sin(state.yaw), cp = Math.cos(state.pitch), sp = Math.sin(state.pitch);
  return [cy * u + sy * sp * v, -sy * u + cy * sp * v, cp * v];
}

// The outline of all samples at a pose.
function sampled(pose) {
  if (data.cloud[pose].flat().includes(null)) return "";
  const [x, y] = place(data.point.place[pose]), grow = zoom * state.magnify;
  return lines(hull(data.cloud[pose].map(turned).map(([u, v]) => [x + grow * u, y - grow * v])), true);
}

function drawBand() {
  if (data.cloud) cloud.setAttribute("d", there.map(sampled).join(""));
  // One path for all zones: where they overlap they are no darker.
  band.setAttribute("d", there.map((pose) => zone(pose, ROUND / 2)).join(""));
  let d = "", pen = "M";
  for (let pose = 0; pose < count; pose += 1) {
    if (data.point.place[pose][0] === null) { pen = "M"; continue; }
    const [x, y] = place(data.point.place[pose]);
    d += `${pen}${x.toFixed(2)} ${y.toFixed(2)}`;
    pen = "L";
  }
  path.setAttribute("d", d);
}

// The sign of a support: its hatched ground, and of a slider the line along which it goes.
function drawSupport(x, y, angle, slides) {
  const base = slides ? 12 : 16, hatches = [-14, -7, 0, 7].map((u) => `M${u + 7} ${base}l-7 7`).join("");
  const shape = slides ? `M-45 ${base - 3}h90M-20 ${base}h40` : `M0 0l-10 ${base}h20zM-14 ${base}h28`;
  element("path", { class: "ground", d: shape + hatches, transform: `translate(${x} ${y}) rotate(${angle})` }, marks);
}

// The sign of a drive: an arrow along which it slides, or about which it turns.
function drawDrive(x, y, angle, slides) {
  const d = slides ? "M16 -14h34m-8 -4l8 4l-8 4" : "M17 0A17 17 0 1 0 0 17m-8 -4l8 4l-8 4";
  element("path", { class: "drive", d, transform: `translate(${x} ${y}) rotate(${slides ? angle : 0})` }, marks);
}

// A spring: a coil between two straight ends.
function drawSpring(from, to) {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]], length = Math.hypot(dx, dy);
  if (length < 1) return;
  const along = (t, side) => [from[0] + t * dx - (side * 7 * dy) / length, from[1] + t * dy + (side * 7 * dx) / length];
  const coil = [...Array(9).keys()].map((k) => along(0.2 + 0.6 * ((k + 0.5) / 9), k % 2 ? 1 : -1));
  element("path", { class: "spring", d: lines([from, along(0.2, 0), ...coil, along(0.8, 0), to]) }, marks);
}

const strongest = Math.max(...data.loads.flatMap((load) => load.force.filter((f) => !f.includes(null)).map(norm)), 1e-300);
function drawLoads(pose) {
  for (const load of data.loads) {
    if (load.place[pose].includes(null) || load.force[pose].includes(null)) continue;
    const [x, y] = place(load.place[pose]), [u, v] = scaled(turned(load.force[pose]), (55 * Math.sign(state.load)) / strongest);
    const length = Math.hypot(u, v), [c, s] = [(9 * u) / length, (-9 * v) / length];
    if (length < 2) continue;
    const tip = `M${x - c + s / 2} ${y - s - c / 2}L${x} ${y}L${x - c - s / 2} ${y - s + c / 2}`;
    element("path", { class: "load", d: `M${x - u} ${y + v}L${x} ${y}${tip}` }, marks);
  }
}

function drawLinkage() {
  const pose = state.pose;
  shapes.replaceChildren();
  marks.replaceChildren();
  for (const link of data.links) {
    const corners = link.points.map((name) => data.points[name][pose]);
    if (corners.some((p) => p[0] === null)) continue;
    const closed = corners.length > 2, drawn = corners.map(place);
    element("path", { class: closed ? "body" : "link", d: lines(closed ? hull(drawn) : drawn, closed) }, shapes);
  }
  for (const joint of data.joints) {
    const p = data.points[joint.point][pose];
    if (p[0] === null) continue;
    const [x, y] = place(p);
    const axis = joint.axis ? turned(joint.axis[pose]) : [0, 0], slides = joint.kind === "prismatic" && norm(axis) > 0.05;
    const angle = slides ? (-180 / Math.PI) * Math.atan2(axis[1], axis[0]) : 0;
    if (joint.ground) drawSupport(x, y, angle, slides);
    if (joint.driven) drawDrive(x, y, angle, slides);
    if (slides) {
      element("rect", { class: "pin", x: -11, y: -6.5, width: 22, height: 13, transform: `translate(${x} ${y}) rotate(${angle})` }, marks);
    } else element("circle", { class: "pin", cx: x, cy: y, r: 5 }, marks);
  }
  for (const [from, to] of data.springs) {
    if (!from[pose].includes(null) && !to[pose].includes(null)) drawSpring(place(from[pose]), place(to[pose]));
  }
  drawLoads(pose);
  for (const [name, places] of Object.entries(data.points)) {
    if (places[pose][0] === null) continue;
    const [x, y] = place(places[pose]);
    element("text", { x: x + 9, y: y - 9 }, marks).textContent = name;
  }
  region.setAttribute("d", zone(pose));
  const found = displaced();
  if (found) {
    const [x, y] = place(data.point.place[pose]), [u, v] = turned(found);
    element("path", { class: "moved", d: `M${x} ${y}l${zoom * state.magnify * u} ${-zoom * state.magnify * v}` }, marks);
  }
}

// -- the table -------------------------------------------------------------------------------------------------------

const loaded = data.loaded, [metre, newton] = data.units;
const displaced = () => (loaded ? acting(loaded.displacement, state.pose) : null);
const unit = (words, of) => (of ? `${words} [${of}]` : words);
const numbers = document.getElementById("numbers"), axes = ["x", "y", "z"].slice(0, data.dimensions);
function written(value) {
  if (value === null || !Number.isFinite(value)) return "–";
  const short = Number(value.toPrecision(6));
  return short !== 0 && Math.abs(short) < 1e-3 ? short.toExponential().replace("e-", "e−").replace(/^-/, "−") : short.toString().replace("-", "−");
}

function row(key, words, value) {
  let line = document.getElementById(`row-${key}`);
  if (!line) {
    line = numbers.insertRow();
    line.id = `row-${key}`;
    const head = document.createElement("th");
    head.scope = "row";
    head.textContent = words;
    line.append(head, document.createElement("td"));
  }
  line.lastChild.textContent = typeof value === "string" ? value : written(value);
  line.lastChild.dataset.value = typeof value === "string" ? value : String(value);
}

function tell() {
  const pose = state.pose, name = data.point.name, here = data.point.place[pose], status = data.status[pose];
  const told = document.getElementById("status");
  told.textContent = `${data.drive.name} = ${driveValue()}: ${status}`;
  told.classList.toggle("lost", status !== "regular");
  axes.forEach((axis, k) => row(`place-${axis}`, unit(`${name}, ${axis}`, metre), here[k]));
  const moved = displaced();
  if (loaded) {
    axes.forEach((axis, k) => row(`loaded-${axis}`, unit(`${name} deflected, ${axis}`, metre), moved ? moved[k] : null));
    row("bound", unit("numerical error of it, at most", metre), bounded(loaded.bound, pose));
  }
  tellWorst(pose, name);
  for (const [joint, part] of Object.entries(data.reactions)) {
    const force = acting(part, pose);
    row(`force-${joint}`, unit(`force in ${joint}`, newton), force && norm(force));
  }
  for (const [drive, part] of Object.entries(data.drives)) {
    const force = acting(part, pose);
    row(`drive-${drive}`, part.turns ? unit(`moment of drive ${drive}`, newton && `${newton} ${metre}`) : unit(`force of drive ${drive}`, newton), force && force[0]);
  }
}

function tellWorst(pose, name) {
  if (!data.limits.length) return;
  const worst = largest(pose), turned = largest(pose, "turn");
  row("worst", unit(`${name} by clearances and tolerances, at most`, metre), worst ? worst.size : null);
  axes.forEach((axis, k) => row(`worst-${axis}`, `in the direction ${axis}`, worst ? worst.direction[k] : null));
  data.limits.forEach((limit, k) =>
    row(`share-${k}`, `of it by ${limit.name}`, worst && worst.size ? `${((100 * worst.shares[k]) / worst.size).toFixed(1)} %` : "–"));
  row("angle", unit("its link turned by them, at most", "rad"), turned ? turned.size : null);
}

// -- controls --------------------------------------------------------------------------------------------------------

const controls = document.getElementById("controls");
controls.addEventListener("submit", (event) => event.preventDefault());
const sliders = {};

function slider(key, words, low, high, step, value, shown, change) {
  const label = document.createElement("label"), input = document.createElement("input"), output = document.createElement("output");
  label.append(words, output, input);
  Object.assign(input, { type: "range", min: low, max: high, step, value, id: key });
  const update = () => { change(Number(input.value)); output.textContent = shown(); };
  input.addEventListener("input", () => { update(); refresh(key); });
  sliders[key] = (given) => { input.value = given; change(Number(given)); output.textContent = shown(); };
  controls.appendChild(label);
  output.textContent = shown();
}

function refresh(key) {
  if (key !== "pose" && key !== "load") drawBand();
  drawLinkage();
  tell();
}

const radius = (k) => Math.max(...[data.limits[k].radius].flat().filter((value) => value !== null));
const driveValue = () => `${written(data.drive.values[state.pose])}${data.drive.turns ? "°" : ` ${metre}`}`;
slider("pose", `Drive ${data.drive.name}`, 0, count - 1, 1, state.pose,
  driveValue,
  (value) => { if (data.point.place[value][0] !== null) state.pose = value; });
if (data.scalable && (loaded || Object.keys(data.reactions).length)) {
  slider("load", "Load, times that given", -2, 2, 0.01, 1, () => written(state.load), (value) => { state.load = value; });
}
data.limits.forEach((limit, k) => slider(`limit-${k}`, unit(limit.name.replace(/^joint /, "clearance of "), limit.angle ? "rad" : metre), 0, 3, 0.01, 1,
  () => `± ${written(radius(k) * state.radii[k])}`, (value) => { state.radii[k] = value; }));
const deflected = (pose) => (loaded && norm(acting(loaded.displacement, pose) ?? [0])) || 0;
const spread = (pose) => (data.cloud ? Math.max(...data.cloud[pose].filter((p) => !p.includes(null)).map(norm), 0) : 0);
// By half of the poses, as beside dead points displacements are large.
const usual = there.map((pose) => Math.max(largest(pose)?.size ?? 0, deflected(pose), spread(pose))).sort((a, b) => a - b)[there.length >> 1];
if (usual > 0) {
  const best = Math.log10(Math.max(1, (0.08 * reach) / usual));
  slider("magnify", "Displacements drawn larger", 0, Math.ceil(best + 1), 0.01, best.toFixed(2),
    () => `× ${Number(state.magnify.toPrecision(3))}`, (value) => { state.magnify = 10 ** value; });
  sliders.magnify(best.toFixed(2));
}

// -- dragging --------------------------------------------------------------------------------------------------------

let held = null;
function pointer(event) {
  const box = view.getBoundingClientRect();
  return [((event.clientX - box.left) * WIDTH) / box.width, ((event.clientY - box.top) * HEIGHT) / box.height];
}
view.addEventListener("pointerdown", (event) => {
  const at = pointer(event);
  let near = Infinity;
  held = { name: null, at };
  for (const [name, places] of Object.entries(data.points)) {
    if (places[state.pose][0] === null || !there.some((pose) => places[pose].some((v, k) => Math.abs(v - places[there[0]][k]) > 1e-9 * reach))) continue;
    const p = place(places[state.pose]), off = Math.hypot(p[0] - at[0], p[1] - at[1]);
    if (off < near && off < (flat ? 120 : 30)) { near = off; held.name = name; }
  }
  view.setPointerCapture(event.pointerId);
});
view.addEventListener("pointermove", (event) => {
  if (!held) return;
  const at = pointer(event);
  if (held.name === null) {
    if (flat) return;
    state.yaw += (at[0] - held.at[0]) / 150;
    state.pitch = Math.max(-1.57, Math.min(1.57, state.pitch + (at[1] - held.at[1]) / 150));
    held.at = at;
    refresh("view");
    return;
  }
  // The nearest pose, of those that are not far from this one: a path may come by twice.
  let best = state.pose, near = Infinity;
  for (const pose of there) {
    const p = place(data.points[held.name][pose]);
    const apart = Math.min(Math.abs(pose - state.pose), count - Math.abs(pose - state.pose));
    const off = Math.hypot(p[0] - at[0], p[1] - at[1]) + (apart > count / 5 ? 200 : 0);
    if (off < near) { near = off; best = pose; }
  }
  if (best !== state.pose) { sliders.pose(best); refresh("pose"); }
});
for (const end of ["pointerup", "pointercancel"]) view.addEventListener(end, () => { held = null; });
view.addEventListener("keydown", (event) => {
  const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
  if (!step) return;
  event.preventDefault();
  const at = there.indexOf(state.pose);
  sliders.pose(there[(at + step + there.length) % there.length]);
  refresh("pose");
});

// -- the page --------------------------------------------------------------------------------------------------------

document.getElementById("title").textContent = data.title;
document.getElementById("caption").textContent =
  `Drag a joint${flat ? "" : ", or beside them to look from elsewhere"}. Blue: path of ${data.point.name}` +
  (data.limits.length ? " with the zone that clearances and tolerances let it reach; orange: at this pose" : "") +
  (loaded ? "; green: its deflection" : "") + (data.cloud ? `; grey: ${data.samples}` : "") + "." +
  (data.every > 1 ? ` Of every ${data.every} poses one is shown.` : "");
document.getElementById("origin").textContent = [data.versions, data.command].filter(Boolean).join(". ");
const about = document.getElementById("about");
data.notes.forEach((note) => { about.appendChild(document.createElement("p")).textContent = note; });
for (const each of data.about) {
  const part = about.appendChild(document.createElement("details"));
  part.appendChild(document.createElement("summary")).textContent = each.title;
  part.appendChild(document.createElement("pre")).textContent = each.text;
}
// On paper nothing can be opened.
window.addEventListener("beforeprint", () => about.querySelectorAll("details").forEach((part) => { part.open = true; }));
function read() {
  for (const [key, value] of new URLSearchParams(location.hash.slice(1))) if (sliders[key] && value !== "") sliders[key](value);
  refresh("all");
}
window.addEventListener("hashchange", read);
read();
