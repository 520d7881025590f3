// -- the view in space -----------------------------------------------------------------------------------------------

const LOOK = "Drag a joint, or beside them to look from elsewhere; wheel, two fingers or + and − for the size; arrow keys " +
  "for the pose, with Shift to turn, 0 for the first view";
// Longest piece of a tube, and radii of tubes and of balls.
const PIECE = 45, TUBE = 4, BALL = 6.5;
const pen = view.getContext("2d");
const scale = (0.44 * HEIGHT) / reach;
let right, up, near, colour;
const FIRST = { yaw: -0.6, pitch: 0.5, zoom: 1 };
Object.assign(state, FIRST);

// Directions to the right, upwards and towards the eye.
function look() {
  const cy = Math.cos(state.yaw), sy = Math.sin(state.yaw), cp = Math.cos(state.pitch), sp = Math.sin(state.pitch);
  right = [cy, -sy, 0];
  up = [sp * sy, sp * cy, cp];
  near = [-cp * sy, -cp * cy, sp];
}
look();

const seen = (p) => [dot(p, right), dot(p, up)];
// The first view is filled, and its middle the one about which it turns.
const sides = [right, up].map((axis) => every.map((p) => dot(p, axis))).map((all) => [Math.min(...all), Math.max(...all)]);
[right, up].forEach((axis, side) => {
  const off = (sides[side][0] + sides[side][1]) / 2 - dot(middle, axis);
  axis.forEach((value, k) => { middle[k] += off * value; });
});
state.zoom = FIRST.zoom = Math.min(...sides.map(([least, most], side) => [0.88 * WIDTH, 0.8 * HEIGHT][side] / Math.max((most - least) * scale, 1)));

function place(p) {
  const q = [p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]], factor = scale * state.zoom;
  return [WIDTH / 2 + factor * dot(q, right), HEIGHT / 2 - factor * dot(q, up)];
}

function colours() {
  const style = getComputedStyle(document.documentElement);
  colour = Object.fromEntries(["paper", "ink", "faint", "link", "path", "reach", "moved", "load", "shine"].map((name) => [name, style.getPropertyValue(`--${name}`)]));
}

function draw(points, { close = false, fill = null, alpha = 1, stroke = null, width = 1.5, cap = "round" }) {
  if (!points.length) return;
  pen.beginPath();
  points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  if (close) pen.closePath();
  if (fill) { pen.globalAlpha = alpha; pen.fillStyle = fill; pen.fill(); pen.globalAlpha = 1; }
  if (stroke) { pen.strokeStyle = stroke; pen.lineWidth = width; pen.lineCap = cap; pen.lineJoin = "round"; pen.stroke(); }
}

// What is drawn from far to near: how far it is, and how.
let parts = [];
const later = (p, drawn) => parts.push([dot(p, near), drawn]);

// A round bar in pieces, so that what crosses it lies before or behind: each with a gap about it, and lighter in the middle.
function tube(from, to, width, tint) {
  const [a, b] = [place(from), place(to)], count = Math.min(24, Math.max(1, Math.ceil(Math.hypot(b[0] - a[0], b[1] - a[1]) / PIECE)));
  for (let k = 0; k < count; k += 1) {
    const point = (t) => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    // Pieces overlap a little, so that no seam shows.
    const piece = [point(Math.max(0, (k - 0.02) / count)), point(Math.min(1, (k + 1.02) / count))];
    const t = (k + 0.5) / count, middle = from.map((value, j) => value + t * (to[j] - value));
    later(middle, () => {
      draw(piece, { stroke: colour.paper, width: width + 3, cap: "butt" });
      draw(piece, { stroke: tint, width, cap: "butt" });
      draw(piece, { stroke: colour.shine, width: width / 3, cap: "butt" });
    });
  }
}

// A joint by its kind: a pin or a sleeve along its axis, two pins across, or a ball.
function joint(each, p, pose) {
  const [x, y] = place(p), tint = each.driven ? colour.reach : colour.link, round = ["spherical", "fixed"].includes(each.kind);
  const shown = each.axis && !round ? seen(each.axis[pose]) : [0, 0], half = each.kind === "prismatic" ? 13 : 9;
  // Before the pieces that end in it.
  later(plus(p, scaled(near, (0.6 * PIECE) / (scale * state.zoom))), () => {
    if (each.ground) ground(x, y);
    const line = [[x - half * shown[0], y + half * shown[1]], [x + half * shown[0], y - half * shown[1]]];
    if (!round) {
      const width = each.kind === "prismatic" ? 13 : 10;
      draw(line, { stroke: tint, width, cap: "butt" });
      draw(line, { stroke: colour.paper, width: width - 4, cap: "butt" });
    }
    pen.beginPath();
    pen.arc(x, y, round ? BALL : BALL - 2, 0, 2 * Math.PI);
    pen.fillStyle = colour.paper;
    pen.strokeStyle = tint;
    pen.lineWidth = 2;
    pen.fill();
    pen.stroke();
  });
}

function ground(x, y) {
  pen.save();
  pen.translate(x, y);
  pen.strokeStyle = colour.faint;
  pen.lineWidth = 1.5;
  pen.stroke(new Path2D(support(false)));
  pen.restore();
}

// The displaced point's zone as it is seen: outermost in the directions of the drawing's plane.
function zone(pose, corners = ROUND) {
  if (unknown(pose, "by")) return [];
  const [x, y] = place(data.point.place[pose]), grow = scale * state.zoom * state.magnify, outline = [];
  for (let k = 0; k < corners; k += 1) {
    const angle = (2 * Math.PI * k) / corners, c = Math.cos(angle), s = Math.sin(angle);
    const [u, v] = seen(outermost(pose, right.map((value, j) => c * value + s * up[j])));
    outline.push([x + grow * u, y - grow * v]);
  }
  return outline;
}

// The outline of all samples at a pose.
function sampled(pose) {
  if (data.cloud[pose].flat().includes(null)) return [];
  const [x, y] = place(data.point.place[pose]), grow = scale * state.zoom * state.magnify;
  return hull(data.cloud[pose].map(seen).map(([u, v]) => [x + grow * u, y - grow * v]));
}

// Zones, samples and the path as one shape each: where they overlap they are no darker.
let back = null;
function drawBand() {
  look();
  const one = (outlines) => {
    const whole = new Path2D();
    for (const outline of outlines) {
      outline.forEach(([x, y], k) => (k ? whole.lineTo(x, y) : whole.moveTo(x, y)));
      whole.closePath();
    }
    return whole;
  };
  const ways = tracks(), known = ways.flat().filter((pose) => data.point.place[pose][0] !== null);
  back = { cloud: data.cloud ? one(known.map(sampled)) : null, band: one(known.map((pose) => zone(pose, ROUND / 2))), path: new Path2D() };
  for (const way of ways) {
    let broken = true;
    for (const pose of way) {
      const p = data.point.place[pose];
      if (p[0] !== null) back.path[broken ? "moveTo" : "lineTo"](...place(p));
      broken = p[0] === null;
    }
  }
}

function drawBack() {
  const fill = (shape, tint, alpha) => { pen.globalAlpha = alpha; pen.fillStyle = tint; pen.fill(shape); pen.globalAlpha = 1; };
  if (back.cloud) fill(back.cloud, colour.faint, 0.3);
  fill(back.band, colour.path, 0.12);
  pen.strokeStyle = colour.path;
  pen.lineWidth = 1.2;
  pen.stroke(back.path);
}

function drawLinks(pose) {
  for (const link of data.links) {
    const corners = link.points.map((name) => data.points[name][pose]);
    if (corners.some((p) => p[0] === null)) continue;
    if (corners.length < 3) {
      if (corners.length === 2) tube(...corners, 2 * TUBE, colour.link);
      continue;
    }
    const marked = corners.map((p) => Object.assign(place(p), { from: p })), outline = hull(marked);
    later(corners.reduce(plus).map((sum) => sum / corners.length), () => draw(outline, { close: true, fill: colour.link, alpha: 0.15 }));
    outline.forEach((corner, k) => tube(corner.from, outline[(k + 1) % outline.length].from, TUBE, colour.link));
  }
}

function drawLinkage() {
  const pose = state.pose, wide = view.clientWidth || WIDTH, fine = (wide / WIDTH) * (window.devicePixelRatio || 1);
  const size = [Math.round(WIDTH * fine), Math.round(HEIGHT * fine)];
  if (view.width !== size[0] || view.height !== size[1]) [view.width, view.height] = size;
  if (!colour) colours();
  pen.setTransform(fine, 0, 0, fine, 0, 0);
  pen.clearRect(0, 0, WIDTH, HEIGHT);
  drawBack();
  parts = [];
  drawLinks(pose);
  for (const each of data.joints) if (data.points[each.point][pose][0] !== null) joint(each, data.points[each.point][pose], pose);
  for (const [from, to] of data.springs) {
    if (from[pose].includes(null) || to[pose].includes(null)) continue;
    later(scaled(plus(from[pose], to[pose]), 0.5), () => draw(coil(place(from[pose]), place(to[pose])), { stroke: colour.ink }));
  }
  for (const [, drawn] of parts.sort((a, b) => a[0] - b[0])) drawn();
  drawMarks(pose);
}

// What lies before everything: forces, the zone and the deflection of the point, names.
function drawMarks(pose) {
  for (const load of data.loads) {
    if (load.place[pose].includes(null) || load.force[pose].includes(null)) continue;
    for (const line of arrow(place(load.place[pose]), seen(load.force[pose]))) draw(line, { stroke: colour.load, width: 2.5 });
  }
  draw(zone(pose), { close: true, fill: colour.reach, alpha: 0.25, stroke: colour.reach, width: 1.2 });
  const found = displaced(), [x, y] = place(data.point.place[pose]), grow = scale * state.zoom * state.magnify;
  if (found) draw([[x, y], [x + grow * dot(found, right), y - grow * dot(found, up)]], { stroke: colour.moved, width: 2 });
  pen.font = `${13 * Math.max(1, 620 / (view.clientWidth || WIDTH))}px system-ui, sans-serif`;
  pen.strokeStyle = colour.paper;
  pen.fillStyle = colour.ink;
  pen.lineWidth = 4;
  for (const [name, places] of Object.entries(data.points)) {
    if (places[pose][0] === null) continue;
    const [u, v] = place(places[pose]);
    pen.strokeText(name, u + 9, v - 9);
    pen.fillText(name, u + 9, v - 9);
  }
}

// -- turning and its size --------------------------------------------------------------------------------------------

function turn(across, upwards) {
  state.yaw += across;
  state.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, state.pitch + upwards));
  refresh("view");
}
function enlarge(factor) {
  state.zoom = Math.max(0.2, Math.min(20, state.zoom * factor));
  refresh("view");
}
view.addEventListener("wheel", (event) => {
  event.preventDefault();
  enlarge(Math.exp(-event.deltaY / 500));
}, { passive: false });
view.addEventListener("keydown", (event) => {
  const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
  if (event.shiftKey && step) turn(...step);
  else if (event.key === "+" || event.key === "=") enlarge(1.2);
  else if (event.key === "-" || event.key === "−") enlarge(1 / 1.2);
  else if (event.key === "0") { Object.assign(state, FIRST); refresh("view"); }
  else return;
  event.preventDefault();
  event.stopImmediatePropagation();
});
// Colours follow the system and the printer, the canvas what there is room for.
const recoloured = () => { colour = null; refresh("colours"); };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recoloured);
new ResizeObserver(() => refresh("size")).observe(view);
