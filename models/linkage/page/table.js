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

// A number, which a page has to all its digits, and as it is shown.
function row(key, words, value, shown = value) {
  let line = document.getElementById(`row-${key}`);
  if (!line) {
    line = numbers.insertRow();
    line.id = `row-${key}`;
    const head = document.createElement("th");
    head.scope = "row";
    head.textContent = words;
    line.append(head, document.createElement("td"));
  }
  line.lastChild.textContent = typeof value === "string" ? value : written(shown);
  line.lastChild.dataset.value = typeof value === "string" ? value : String(value);
}

// What is zero but for its rounding beside the size of what it comes from.
const rounded = (value, size) => (Math.abs(value) < 1e-12 * size ? 0 : value);
const longest = (values) => Math.max(0, ...values.filter((each) => !each.includes(null)).map(norm));
const bent = loaded ? Math.max(...Object.values(loaded.displacement).map(longest)) : 0;

function tell() {
  const pose = state.pose, name = data.point.name, here = data.point.place[pose], status = data.status[pose];
  const told = document.getElementById("status");
  told.textContent = `${driven()}: ${status}${state.load === 1 ? "" : " (with the loads as given)"}`;
  told.classList.toggle("lost", status !== "regular");
  axes.forEach((axis, k) => row(`place-${axis}`, unit(`${name}, ${axis}`, metre), here[k], rounded(here[k], reach)));
  const moved = displaced();
  if (loaded) {
    axes.forEach((axis, k) => row(`loaded-${axis}`, unit(`${name} deflected, ${axis}`, metre), moved ? moved[k] : null, moved ? rounded(moved[k], bent) : null));
    row("bound", unit("numerical error of it, at most", metre), bounded(loaded.bound, pose));
  }
  tellWorst(pose, name);
  const forces = Object.entries(data.reactions).map(([joint, part]) => [joint, acting(part, pose)]);
  const sizes = forces.map(([joint, force]) => [joint, force && norm(force)]), greatest = Math.max(0, ...sizes.map(([, size]) => size ?? 0));
  for (const [joint, size] of sizes) row(`force-${joint}`, unit(`force in ${joint}`, newton), size, size && rounded(size, greatest));
  for (const [drive, part] of Object.entries(data.drives)) {
    const force = acting(part, pose);
    const words = part.turns ? unit(`moment of drive ${drive}`, newton && `${newton} ${metre}`) : unit(`force of drive ${drive}`, newton);
    row(`drive-${drive}`, words, force && force[0], force && rounded(force[0], part.turns ? greatest * reach : greatest));
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

