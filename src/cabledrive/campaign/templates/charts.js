"use strict";
(() => {
const d = JSON.parse(document.getElementById("data").textContent);
const chart = document.getElementById("chart"), readout = document.getElementById("readout");
const names = Object.keys(d.columns), outputs = names.filter(name => !d.keys.includes(name));
const selects = [document.getElementById("x"), document.getElementById("y")];
const unit = name => d.units[name] && d.units[name] !== "1" ? ` [${d.units[name]}]` : "";
selects.forEach((select, which) => {
  for (const name of names) select.add(new Option(name + unit(name), name));
  select.value = which ? outputs[0] || names[0] : d.keys[0] || names[0];
  select.addEventListener("change", draw);
});
const W = 720, H = 440, L = 78, R = 32, T = 12, B = 48, SVG = "http://www.w3.org/2000/svg";
function element(name, attributes, parent, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  parent.append(made);
  return made;
}
function range(values) {
  const known = values.filter(value => value !== null);
  let low = Math.min(...known), high = Math.max(...known);
  if (!(high > low)) { low -= 0.5 * Math.abs(low) || 0.5; high += 0.5 * Math.abs(high) || 0.5; }
  return [low, high];
}
function draw() {
  const [nx, ny] = selects.map(select => select.value), x = d.columns[nx], y = d.columns[ny];
  chart.replaceChildren();
  const svg = element("svg", { viewBox: `0 0 ${W} ${H}` }, chart);
  if (!x.some(value => value !== null) || !y.some(value => value !== null)) {
    element("text", { x: W / 2, y: H / 2, "text-anchor": "middle" }, svg, "no values");
    return;
  }
  const [x0, x1] = range(x), [y0, y1] = range(y);
  const px = value => L + (W - L - R) * (value - x0) / (x1 - x0), py = value => H - B - (H - B - T) * (value - y0) / (y1 - y0);
  element("path", { d: `M${L} ${T}V${H - B}H${W - R}`, class: "axis" }, svg);
  for (let i = 0; i <= 4; i++) {
    const vx = x0 + (x1 - x0) * i / 4, vy = y0 + (y1 - y0) * i / 4;
    element("text", { x: px(vx), y: H - B + 18, "text-anchor": "middle" }, svg, Number(vx.toPrecision(4)));
    element("text", { x: L - 8, y: py(vy) + 4, "text-anchor": "end" }, svg, Number(vy.toPrecision(4)));
  }
  element("text", { x: (L + W - R) / 2, y: H - 8, "text-anchor": "middle" }, svg, nx + unit(nx));
  d.rows.forEach((row, i) => {
    if (x[i] === null || y[i] === null) return;
    const point = { cx: px(x[i]).toFixed(1), cy: py(y[i]).toFixed(1), r: 3, class: d.good[i] ? "" : "bad", "data-i": i };
    element("circle", point, svg);
  });
}
const said = i => `row ${d.rows[i]}: ` + names.map(
  name => `${name} ${d.columns[name][i] === null ? "-" : d.columns[name][i]}${unit(name)}`).join(", ");
let marked = null;
chart.addEventListener("pointerover", event => {
  const i = event.target.dataset && event.target.dataset.i;
  if (i === undefined) return;
  if (marked) marked.classList.remove("on");
  marked = event.target;
  marked.classList.add("on");
  readout.textContent = said(i);
});
draw();
parallel(d, names, unit, element, range, i => { document.getElementById("line").textContent = said(i); });
})();
