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

// All follows with the next frame, however often something moved before it.
let waiting = null, owner = null;
// What leaves the path and its band where they are.
const still = ["load", "size", "colours", ...(grid.length ? [] : ["pose"])];
function refresh(key) {
  if (waiting === null) { waiting = new Set(); requestAnimationFrame(redraw); }
  waiting.add(key);
}
function redraw() {
  const moved = waiting ?? new Set(["all"]);
  waiting = null;
  if ([...moved].some((key) => !still.includes(key))) drawBand();
  drawLinkage();
  tell();
  if (owner) owner.postMessage({ linkframe: told() }, "*");
}

const radius = (k) => Math.max(...[data.limits[k].radius].flat().filter((value) => value !== null));
const valueOf = (axis, number) => `${written(axis.values[number])}${axis.turns ? "°" : ` ${metre}`}`;
const driven = () => (grid.length ? grid.map((axis, k) => `${axis.name} = ${valueOf(axis, digit(state.pose, k))}`).join(", ")
  : `${data.drive.name} = ${valueOf(data.drive, state.pose)}`);
const known = (pose) => data.point.place[pose][0] !== null;
grid.forEach((axis, k) => slider(`pose-${k}`, `Drive ${axis.name}`, 0, axis.values.length - 1, 1, digit(state.pose, k),
  () => valueOf(axis, digit(state.pose, k)),
  (value) => { const pose = state.pose + (value - digit(state.pose, k)) * strides[k]; if (known(pose)) state.pose = pose; }));
if (!grid.length) {
  slider("pose", `Drive ${data.drive.name}`, 0, count - 1, 1, state.pose, () => valueOf(data.drive, state.pose),
    (value) => { if (known(value)) state.pose = value; });
} else {
  // All drives at once.
  sliders.pose = (pose) => { if (known(pose)) state.pose = Number(pose); grid.forEach((_, k) => sliders[`pose-${k}`](digit(state.pose, k))); };
}
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

// What is held, and where all fingers are.
let held = null;
const fingers = new Map();
function pointer(event) {
  const box = view.getBoundingClientRect();
  return [((event.clientX - box.left) * WIDTH) / box.width, ((event.clientY - box.top) * HEIGHT) / box.height];
}
const apart = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]) || 1; };
const moves = Object.fromEntries(Object.entries(data.points).map(([name, places]) => [name, there.some((pose) =>
  places[pose].some((v, k) => Math.abs(v - places[there[0]][k]) > 1e-9 * reach))]));

// The nearest point that moves, within a finger's reach.
function caught(at) {
  let found = null, least = flat ? 120 : 30;
  for (const [name, places] of Object.entries(data.points)) {
    if (places[state.pose][0] === null || !moves[name]) continue;
    const p = place(places[state.pose]), off = Math.hypot(p[0] - at[0], p[1] - at[1]);
    if (off < least) { least = off; found = name; }
  }
  return found;
}

// The nearest pose, of those that are not far from this one: a path may come by twice.
function nearest(name, at) {
  let best = state.pose, least = Infinity;
  for (const pose of there) {
    const p = place(data.points[name][pose]), steps = grid.length ? 0 : Math.abs(pose - state.pose);
    const off = Math.hypot(p[0] - at[0], p[1] - at[1]) + (Math.min(steps, count - steps) > count / 5 ? 200 : 0);
    if (off < least) { least = off; best = pose; }
  }
  return best;
}

view.addEventListener("pointerdown", (event) => {
  const at = pointer(event);
  fingers.set(event.pointerId, at);
  held = { name: fingers.size > 1 ? null : caught(at), at };
  view.setPointerCapture(event.pointerId);
});
view.addEventListener("pointermove", (event) => {
  if (!held) return;
  const at = pointer(event), before = fingers.size > 1 ? apart() : 0;
  fingers.set(event.pointerId, at);
  if (before) {
    if (!flat) enlarge(apart() / before);
  } else if (held.name !== null) {
    const best = nearest(held.name, at);
    if (best !== state.pose) { sliders.pose(best); refresh("pose"); }
  } else if (!flat) turn((at[0] - held.at[0]) / 150, (at[1] - held.at[1]) / 150);
  held.at = at;
});
for (const end of ["pointerup", "pointercancel"]) {
  view.addEventListener(end, (event) => {
    fingers.delete(event.pointerId);
    held = fingers.size ? { name: null, at: [...fingers.values()][0] } : null;
  });
}
view.addEventListener("keydown", (event) => {
  const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
  if (!step) return;
  event.preventDefault();
  if (grid.length) {
    // Left and right are the first drive's, up and down the next one's.
    const k = Math.min(grid.length - 1, ["ArrowUp", "ArrowDown"].includes(event.key) ? 1 : 0);
    sliders[`pose-${k}`](Math.max(0, Math.min(grid[k].values.length - 1, digit(state.pose, k) + step)));
  } else {
    const at = there.indexOf(state.pose);
    sliders.pose(there[(at + step + there.length) % there.length]);
  }
  refresh("pose");
});

// -- the page --------------------------------------------------------------------------------------------------------

document.getElementById("title").textContent = data.title;
document.getElementById("caption").textContent =
  `${LOOK}. Blue: path of ${data.point.name}` +
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
// On paper nothing can be opened, and all is dark on white.
let opened = [];
function printed(on) {
  document.documentElement.classList.toggle("printed", on);
  if (on) opened = [...about.querySelectorAll("details:not([open])")];
  opened.forEach((part) => { part.open = on; });
  if (!flat) { colours(); redraw(); }
}
window.addEventListener("beforeprint", () => printed(true));
window.addEventListener("afterprint", () => printed(false));
// In a notebook, once its owner has asked: what is set, and the table.
function told() {
  const rows = [...numbers.rows].map((line) => [line.firstChild.textContent, line.lastChild.dataset.value]);
  const values = rows.map(([words, value]) => [words, value === "null" ? null : Number.isNaN(Number(value)) ? value : Number(value)]);
  return { pose: state.pose * data.every, load: state.load, factors: [...state.radii], numbers: Object.fromEntries(values) };
}
window.addEventListener("message", ({ source, data: message }) => {
  if (window.parent === window || source !== window.parent || !message?.linkframe) return;
  owner = source;
  const { pose, load, factors } = message.linkframe;
  if (pose !== null) sliders.pose(Math.max(0, Math.min(count - 1, Math.round(pose / data.every))));
  sliders.load?.(load);
  factors.forEach((factor, k) => sliders[`limit-${k}`]?.(factor));
  refresh("all");
});
function read() {
  for (const [key, value] of new URLSearchParams(location.hash.slice(1))) if (sliders[key] && value !== "") sliders[key](value);
  refresh("all");
}
window.addEventListener("hashchange", read);
read();
redraw();
