"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const count = data.status.length, flat = data.dimensions === 2;
const there = [...Array(count).keys()].filter((pose) => data.point.place[pose][0] !== null);
const state = { pose: there.find((pose) => data.status[pose] === "regular") ?? there[0], load: 1, radii: data.limits.map(() => 1), magnify: 1 };

// Drives that move by themselves: the pose at their values, the last one running fastest.
const grid = data.grid, strides = grid.map((_, k) => grid.slice(k + 1).reduce((product, axis) => product * axis.values.length, 1));
const digit = (pose, k) => Math.floor(pose / strides[k]) % grid[k].values.length;
// The poses through this one along which a drive moves by itself.
function tracks() {
  const all = [...Array(count).keys()];
  return grid.length ? grid.map((_, k) => all.filter((pose) => grid.every((_, j) => j === k || digit(pose, j) === digit(state.pose, j)))) : [all];
}

// -- numbers ---------------------------------------------------------------------------------------------------------

const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);
const norm = (a) => Math.sqrt(dot(a, a));
const scaled = (a, factor) => a.map((value) => value * factor);
const plus = (a, b) => a.map((value, k) => value + b[k]);

// What may be the same at all poses, or a list by pose.
const at = (value, pose) => (Array.isArray(value) ? value[pose] : value);
const unknown = (pose, what) => !data.limits.length || data.limits.some((limit) => limit[what][pose].flat().includes(null));

// What a deviation does at a pose, row by row; made flat where it is first asked for.
const flattened = { by: data.limits.map(() => []), turn: data.limits.map(() => []) };
const flatAt = (index, what, pose) => (flattened[what][index][pose] ??= Float64Array.from(data.limits[index][what][pose].flat()));

// The outermost displacement in a direction, or rotation: each deviation goes as far as it can along what it does there.
function outermost(pose, n, what = "by", shares = null) {
  const size = n.length, total = Array(size).fill(0), along = [];
  for (let index = 0; index < data.limits.length; index += 1) {
    const limit = data.limits[index], by = flatAt(index, what, pose), width = by.length / size;
    const radius = at(limit.radius, pose) * state.radii[index], middle = at(limit.middle, pose);
    const before = shares ? dot(total, n) : 0;
    let squares = 0;
    for (let m = 0; m < width; m += 1) {
      along[m] = 0;
      for (let k = 0; k < size; k += 1) along[m] += by[k * width + m] * n[k];
      squares += along[m] * along[m];
    }
    const length = Math.sqrt(squares);
    for (let k = 0; k < size; k += 1) {
      if (length > 0) {
        let goes = 0;
        for (let m = 0; m < width; m += 1) goes += by[k * width + m] * along[m];
        total[k] += (radius * goes) / length;
      }
      total[k] += by[k * width] * middle;
    }
    if (shares) shares.push(dot(total, n) - before);
  }
  return total;
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
  const starts = directions[what].map((n) => [norm(outermost(pose, n, what)), n]).sort((a, b) => b[0] - a[0]).slice(0, 4);
  let best = { size: 0, direction: directions[what][0], shares: data.limits.map(() => 0) };
  for (const [, start] of starts) {
    let n = start, found = outermost(pose, n, what), size = norm(found);
    for (let step = 0; step < 400 && size > 0; step += 1) {
      n = scaled(found, 1 / size);
      found = outermost(pose, n, what);
      const larger = norm(found);
      if (larger <= size * (1 + 1e-15)) { size = Math.max(size, larger); break; }
      size = larger;
    }
    if (size > best.size) best = { size, direction: n };
  }
  best.shares ??= [];
  if (!best.shares.length) outermost(pose, best.direction, what, best.shares);
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

