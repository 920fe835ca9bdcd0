// Lines of all rows across their keys and outputs; an interval dragged along an axis chooses rows.
function parallel(d, names, unit, element, range, say) {
  const W = 960, H = 380, L = 46, R = 46, T = 40, B = 26, MOST = 12, FINE = 2, GRAB = 14;
  const root = document.getElementById("parallel"), chosen = document.getElementById("chosen");
  const differs = values => new Set(values.filter(value => value !== null)).size > 1;
  const shown = names.filter(name => differs(d.columns[name])).slice(0, MOST);
  if (shown.length < 2) { root.textContent = "Fewer than two columns have different values."; return; }
  const ranges = shown.map(name => range(d.columns[name])), limits = shown.map(() => null);
  const x = i => L + (W - L - R) * i / (shown.length - 1);
  const y = (i, value) => H - B - (H - B - T) * (value - ranges[i][0]) / (ranges[i][1] - ranges[i][0]);
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
  canvas.width = FINE * W; canvas.height = FINE * H;
  pen.scale(FINE, FINE);
  root.append(canvas);
  const svg = element("svg", { viewBox: `0 0 ${W} ${H}` }, root);
  let marked = null;

  const inside = k => limits.every((limit, i) => {
    const value = d.columns[shown[i]][k];
    return limit === null || (value !== null && limit[0] <= value && value <= limit[1]);
  });
  function line(k, colour, alpha, width) {
    pen.strokeStyle = colour; pen.globalAlpha = alpha; pen.lineWidth = width;
    pen.beginPath();
    let down = false;
    shown.forEach((name, i) => {
      const value = d.columns[name][k];
      if (value === null) { down = false; return; }
      down ? pen.lineTo(x(i), y(i, value)) : pen.moveTo(x(i), y(i, value));
      down = true;
    });
    pen.stroke();
  }
  function draw() {
    pen.clearRect(0, 0, W, H);
    const kept = d.rows.map((_, k) => inside(k)), alpha = Math.max(0.06, Math.min(0.6, 60 / d.rows.length));
    for (const wanted of [false, true]) {
      for (const good of [1, 0]) {
        d.rows.forEach((_, k) => {
          if (kept[k] !== wanted || d.good[k] !== good) return;
          wanted ? line(k, good ? "#3b86d8" : "#d1495b", (good ? 2 : 8) * alpha, 1) : line(k, "#888888", alpha / 3, 1);
        });
      }
    }
    if (marked !== null) line(marked, getComputedStyle(root).color, 1, 2.5);
    const count = kept.filter(Boolean).length, good = kept.filter((one, k) => one && d.good[k]).length;
    chosen.textContent = count ? `${count} of ${d.rows.length} drawn rows chosen, ${good} of them blue ` +
      `(${(100 * good / count).toFixed(1)} %)` : "no row is chosen";
  }
  const place = event => {
    const box = svg.getBoundingClientRect();
    return [(event.clientX - box.left) * W / box.width, (event.clientY - box.top) * H / box.height];
  };
  const axes = shown.map((name, i) => {
    element("path", { d: `M${x(i)} ${T}V${H - B}`, class: "axis" }, svg);
    const [low, high] = ranges[i].map(value => Number(value.toPrecision(4)));
    const anchor = i === 0 ? "start" : i === shown.length - 1 ? "end" : "middle";
    const at = i === 0 ? 2 : i === shown.length - 1 ? W - 2 : x(i);
    const short = name.split(".").pop(), heading = element("text",
      { x: at, y: i % 2 ? 26 : 12, "text-anchor": anchor }, svg, short + unit(name));
    element("title", {}, heading, name);
    element("text", { x: at, y: H - 8, "text-anchor": anchor }, svg, low);
    element("text", { x: i === 0 ? x(i) + 6 : x(i) - 6, y: T + 10, "text-anchor": i === 0 ? "start" : "end" }, svg, high);
    const bar = element("rect", { x: x(i) - 5, width: 10, y: T, height: 0, class: "bar" }, svg);
    const grip = element("rect",
      { x: x(i) - GRAB, width: 2 * GRAB, y: T, height: H - B - T, class: "grip", "data-axis": i }, svg);
    return { bar, grip };
  });
  function limit(i, one, other) {
    const value = at => ranges[i][0] + (ranges[i][1] - ranges[i][0]) * (H - B - at) / (H - B - T);
    const [top, low] = [Math.max(T, Math.min(one, other)), Math.min(H - B, Math.max(one, other))];
    limits[i] = low - top < 4 ? null : [value(low), value(top)];
    axes[i].bar.setAttribute("y", top);
    axes[i].bar.setAttribute("height", limits[i] === null ? 0 : low - top);
    draw();
  }
  axes.forEach(({ grip }, i) => {
    let start = null;
    grip.addEventListener("pointerdown", event => { start = place(event)[1]; grip.setPointerCapture(event.pointerId); });
    grip.addEventListener("pointermove", event => { if (start !== null) limit(i, start, place(event)[1]); });
    grip.addEventListener("pointerup", event => { limit(i, start, place(event)[1]); start = null; });
  });
  svg.addEventListener("pointermove", event => {
    const [px, py] = place(event), i = Math.max(0, Math.min(shown.length - 2, Math.floor((px - L) / (x(1) - x(0)))));
    let nearest = null, gap = 8;
    d.rows.forEach((_, k) => {
      const from = d.columns[shown[i]][k], to = d.columns[shown[i + 1]][k];
      if (from === null || to === null || !inside(k)) return;
      const share = (px - x(i)) / (x(i + 1) - x(i)), off = Math.abs(y(i, from) * (1 - share) + y(i + 1, to) * share - py);
      if (off < gap) { gap = off; nearest = k; }
    });
    if (nearest === marked || event.buttons) return;
    marked = nearest;
    draw();
    if (marked !== null) say(marked);
  });
  document.getElementById("all").addEventListener("click", () => {
    shown.forEach((_, i) => limit(i, T, T));
  });
  draw();
}
