
// Curves by uPlot: values under the pointer, zoom by dragging along a plot, the data as a file. A plot is made when
// it is first seen, since a hidden page has no width.
(() => {
  "use strict";
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const number = (value) => (value == null || Number.isNaN(value) ? "–" : String(Number(value.toPrecision(5))).replace("-", "−"));

  function unpacked(text) {
    const bytes = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (one) => one.charCodeAt(0));
    return Array.from(new Float32Array(bytes.buffer), (value) => (Number.isFinite(value) ? value : null));
  }

  function panelOf(place, data, x, panel, key, last) {
    const drawn = (name) => () => colour(name);
    const axis = { stroke: drawn("quiet"), grid: { stroke: drawn("faint"), width: 1 }, ticks: { stroke: drawn("line"), width: 1 }, font: "11px system-ui, sans-serif" };
    const options = {
      width: place.clientWidth,
      height: last ? 176 : 148,
      title: "",
      padding: [10, 12, 0, 0],
      pxAlign: 0,
      cursor: { sync: { key, scales: ["x", null] }, drag: { x: true, y: false }, focus: { prox: 24 } },
      scales: { x: { time: false } },
      axes: [
        { ...axis, size: last ? 42 : 8, values: last ? undefined : () => [], label: last ? `${data.x.name} [${data.x.unit}]` : undefined, labelSize: 16, labelFont: "11px system-ui, sans-serif", space: 70 },
        { ...axis, size: 62, space: 22, values: (_, ticks) => ticks.map(number) },
      ],
      series: [
        { label: data.x.name, value: (_, value) => `${number(value)} ${data.x.unit}` },
        ...panel.series.map((one) => ({
          label: one.name,
          stroke: drawn(one.colour),
          width: 1.4,
          dash: one.dashed ? [6, 4] : undefined,
          points: { show: false },
          value: (_, value) => (value == null ? "–" : `${number(value)} ${panel.unit}`),
        })),
      ],
    };
    return new uPlot(options, [x, ...panel.series.map((one) => one.numbers)], place);
  }

  function table(data, x) {
    const series = data.panels.flatMap((panel) => panel.series.map((one) => ({ ...one, unit: panel.unit, title: panel.title })));
    const quoted = (text) => `"${text.replaceAll('"', '""')}"`;
    const head = [`${data.x.name} [${data.x.unit}]`, ...series.map((one) => `${one.title}: ${one.name} [${one.unit}]`)].map(quoted);
    const rows = x.map((value, i) => [value, ...series.map((one) => one.numbers[i] ?? "")].join(","));
    return [head.join(","), ...rows, ""].join("\n");
  }

  function make(place, data) {
    place.removeAttribute("role"); // no longer a picture: its legend is text, its buttons work
    place.setAttribute("role", "group");
    const x = unpacked(data.x.values);
    for (const panel of data.panels) for (const one of panel.series) one.numbers = unpacked(one.values);
    const plots = data.panels.map((panel, i) => {
      const title = document.createElement("p");
      title.className = "panel-title";
      title.textContent = `${panel.title} [${panel.unit}]`;
      place.append(title);
      return panelOf(place, data, x, panel, data.name, i === data.panels.length - 1);
    });
    const [least, most] = [x[0], x[x.length - 1]];
    let busy = false;
    const follow = (from) => {
      if (busy) return;
      busy = true;
      const { min, max } = from.scales.x;
      for (const plot of plots) if (plot !== from) plot.setScale("x", { min, max });
      busy = false;
    };
    for (const plot of plots) (plot.hooks.setScale ??= []).push((one, key) => { if (key === "x") follow(one); });
    const tools = document.createElement("p");
    tools.className = "plot-tools";
    const button = (words, act) => {
      const one = document.createElement("button");
      one.type = "button";
      one.className = "enlarge";
      one.textContent = words;
      one.addEventListener("click", act);
      tools.append(one, " ");
    };
    button("Zoom in", () => { const { min, max } = plots[0].scales.x, part = (max - min) / 4; plots[0].setScale("x", { min: min + part, max: max - part }); });
    button("Whole range", () => plots[0].setScale("x", { min: least, max: most }));
    button("Data (CSV)", () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([table(data, x)], { type: "text/csv" }));
      link.download = `${data.name}.csv`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
    place.append(tools);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => plots.forEach((plot) => plot.redraw()));
    return plots;
  }

  const made = new Map();
  const watcher = new ResizeObserver((entries) => {
    for (const { target } of entries) {
      if (!target.clientWidth) continue;
      if (!made.has(target)) made.set(target, make(target, JSON.parse(target.nextElementSibling.textContent)));
      for (const plot of made.get(target))
        if (plot.width !== target.clientWidth) plot.setSize({ width: target.clientWidth, height: plot.height });
    }
  });
  for (const place of document.querySelectorAll(".plot")) watcher.observe(place);
})();
