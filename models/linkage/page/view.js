// -- what both views have ----------------------------------------------------------------------------------------------

const WIDTH = 800, HEIGHT = 600, ROUND = 48;
const every = Object.values(data.points).concat([data.point.place], data.springs.flat()).flat().filter((p) => p[0] !== null);
const middle = [0, 1, 2].slice(0, data.dimensions).map((k) => {
  const all = every.map((p) => p[k]);
  return (Math.min(...all) + Math.max(...all)) / 2;
});
const reach = Math.max(...every.map((p) => norm(plus(p, scaled(middle, -1)))), 1e-300);
const strongest = Math.max(...data.loads.flatMap((load) => load.force.filter((f) => !f.includes(null)).map(norm)), 1e-300);
const view = document.getElementById("view");

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

// A spring: a coil between two straight ends.
function coil(from, to) {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]], length = Math.hypot(dx, dy);
  if (length < 1) return [];
  const along = (t, side) => [from[0] + t * dx - (side * 7 * dy) / length, from[1] + t * dy + (side * 7 * dx) / length];
  const turns = [...Array(9).keys()].map((k) => along(0.2 + 0.6 * ((k + 0.5) / 9), k % 2 ? 1 : -1));
  return [from, along(0.2, 0), ...turns, along(0.8, 0), to];
}

// Lines of an arrow that ends at a place, for a force as it is seen.
function arrow([x, y], [fx, fy]) {
  const [u, v] = scaled([fx, fy], (55 * Math.sign(state.load)) / strongest), length = Math.hypot(u, v);
  if (length < 2) return [];
  const [c, s] = [(9 * u) / length, (-9 * v) / length];
  return [[[x - u, y + v], [x, y]], [[x - c + s / 2, y - s - c / 2], [x, y], [x - c - s / 2, y - s + c / 2]]];
}

// The sign of a support: its hatched ground, and of a slider the line along which it goes.
function support(slides) {
  const base = slides ? 12 : 16, hatches = [-14, -7, 0, 7].map((u) => `M${u + 7} ${base}l-7 7`).join("");
  return (slides ? `M-45 ${base - 3}h90M-20 ${base}h40` : `M0 0l-10 ${base}h20zM-14 ${base}h28`) + hatches;
}
