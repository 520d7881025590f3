// The page of a motion in a notebook, for anywidget: what is set on it is told to Python, and what Python sets is shown.
const SET = ["pose", "load", "factors"];

function render({ model, el }) {
  const frame = document.createElement("iframe");
  frame.sandbox = "allow-scripts";
  frame.title = "Page of the motion";
  frame.style.cssText = `width:100%;height:${model.get("height")}px;border:0`;
  let taking = false;
  const give = () => {
    if (!taking) frame.contentWindow?.postMessage({ linkframe: Object.fromEntries(SET.map((name) => [name, model.get(name)])) }, "*");
  };
  const take = (event) => {
    if (event.source !== frame.contentWindow || !event.data?.linkframe) return;
    // What comes from the page does not go back to it: it may have been moved on.
    taking = true;
    for (const [name, value] of Object.entries(event.data.linkframe)) model.set(name, value);
    taking = false;
    model.save_changes();
  };
  window.addEventListener("message", take);
  SET.forEach((name) => model.on(`change:${name}`, give));
  frame.addEventListener("load", give);
  frame.srcdoc = model.get("page");
  el.appendChild(frame);
  return () => {
    window.removeEventListener("message", take);
    SET.forEach((name) => model.off(`change:${name}`, give));
  };
}

export default { render };
