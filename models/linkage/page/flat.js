// -- the view of a plane linkage ---------------------------------------------------------------------------------------

const LOOK = "Drag a joint, or take the arrow keys";
const seen = every.map((p) => plus(p, scaled(middle, -1)));
const zoom = Math.min((0.44 * WIDTH) / Math.max(...seen.map((p) => Math.abs(p[0])), reach / 50),
  (0.39 * HEIGHT) / Math.max(...seen.map((p) => Math.abs(p[1])), reach / 50));

function place(p) {
  return [WIDTH / 2 + zoom * (p[0] - middle[0]), HEIGHT / 2 - zoom * (p[1] - middle[1])];
}
const lines = (points, close) => points.map((p, k) => `${k ? "L" : "M"}${p[0].toFixed(2)} ${p[1].toFixed(2)}`).join("") + (close ? "Z" : "");

function element(name, attributes, parent) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  parent.appendChild(made);
  return made;
}
view.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
const cloud = element("path", { class: "cloud" }, view), band = element("path", { class: "band" }, view), path = element("path", { class: "path" }, view);
const shapes = element("g", {}, view), region = element("path", { class: "reach" }, view), marks = element("g", {}, view);

// The displaced point's zone: outermost in the directions of the plane.
function zone(pose, corners = ROUND) {
  if (unknown(pose, "by")) return "";
  const here = place(data.point.place[pose]), outline = [];
  for (let k = 0; k < corners; k += 1) {
    const angle = (2 * Math.PI * k) / corners;
    const [u, v] = outermost(pose, [Math.cos(angle), Math.sin(angle)]);
    outline.push([here[0] + zoom * state.magnify * u, here[1] - zoom * state.magnify * v]);
  }
  return lines(outline, true);
}

// The outline of all samples at a pose.
function sampled(pose) {
  if (data.cloud[pose].flat().includes(null)) return "";
  const [x, y] = place(data.point.place[pose]), grow = zoom * state.magnify;
  return lines(hull(data.cloud[pose].map(([u, v]) => [x + grow * u, y - grow * v])), true);
}

function drawBand() {
  const ways = tracks(), known = ways.flat().filter((pose) => data.point.place[pose][0] !== null);
  if (data.cloud) cloud.setAttribute("d", known.map(sampled).join(""));
  // One path for all zones: where they overlap they are no darker.
  band.setAttribute("d", known.map((pose) => zone(pose, ROUND / 2)).join(""));
  let d = "";
  for (const way of ways) {
    let pen = "M";
    for (const pose of way) {
      if (data.point.place[pose][0] === null) { pen = "M"; continue; }
      const [x, y] = place(data.point.place[pose]);
      d += `${pen}${x.toFixed(2)} ${y.toFixed(2)}`;
      pen = "L";
    }
  }
  path.setAttribute("d", d);
}

// The sign of a drive: an arrow along which it slides, or about which it turns.
function drawDrive(x, y, angle, slides) {
  const d = slides ? "M16 -14h34m-8 -4l8 4l-8 4" : "M17 0A17 17 0 1 0 0 17m-8 -4l8 4l-8 4";
  element("path", { class: "drive", d, transform: `translate(${x} ${y}) rotate(${slides ? angle : 0})` }, marks);
}

function drawLoads(pose) {
  for (const load of data.loads) {
    if (load.place[pose].includes(null) || load.force[pose].includes(null)) continue;
    const d = arrow(place(load.place[pose]), load.force[pose]).map((line) => lines(line)).join("");
    if (d) element("path", { class: "load", d }, marks);
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
    const axis = joint.axis ? joint.axis[pose] : [0, 0], slides = joint.kind === "prismatic" && norm(axis) > 0.05;
    const angle = slides ? (-180 / Math.PI) * Math.atan2(axis[1], axis[0]) : 0;
    const where = `translate(${x} ${y}) rotate(${angle})`;
    if (joint.ground) element("path", { class: "ground", d: support(slides), transform: where }, marks);
    if (joint.driven) drawDrive(x, y, angle, slides);
    if (slides) {
      element("rect", { class: "pin", x: -11, y: -6.5, width: 22, height: 13, transform: where }, marks);
    } else element("circle", { class: "pin", cx: x, cy: y, r: 5 }, marks);
  }
  for (const [from, to] of data.springs) {
    if (from[pose].includes(null) || to[pose].includes(null)) continue;
    element("path", { class: "spring", d: lines(coil(place(from[pose]), place(to[pose]))) }, marks);
  }
  drawLoads(pose);
  const withSign = new Set(data.joints.filter((joint) => joint.driven).map((joint) => joint.point));
  for (const [name, places] of Object.entries(data.points)) {
    if (places[pose][0] === null) continue;
    const [x, y] = place(places[pose]), [right, up] = withSign.has(name) ? [13, 22] : [9, 9]; // clear of a drive's sign
    element("text", { x: x + right, y: y - up }, marks).textContent = name;
  }
  region.setAttribute("d", zone(pose));
  const found = displaced();
  if (found) {
    const [x, y] = place(data.point.place[pose]), [u, v] = found;
    element("path", { class: "moved", d: `M${x} ${y}l${zoom * state.magnify * u} ${-zoom * state.magnify * v}` }, marks);
  }
}

