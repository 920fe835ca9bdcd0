// Curves by uPlot in the colours of the page.
"use strict";
const curves = (() => {
  const NAMES = ["blue", "orange", "green", "purple", "ochre", "red", "ink"];
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const number = (value) => (value == null || Number.isNaN(value) ? "–" : String(Number(value.toPrecision(5))).replace("-", "−"));
  const made = new Set();

  function axis(label, more = {}) {
    return { stroke: () => colour("quiet"), grid: { stroke: () => colour("faint"), width: 1 }, ticks: { stroke: () => colour("line"), width: 1 }, font: "11px system-ui, sans-serif", labelFont: "11px system-ui, sans-serif", label, labelSize: 18, ...more };
  }

  // marks of a logarithmic axis: whole powers of ten
  const powers = (value) => (value && Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6 ? `1e${Math.round(Math.log10(value))}` : "");

  // place: element; data: uPlot's; series: [{label, colour, dash, band}]; options: {x, y, height, log, select}
  function plot(place, data, series, { x, y, height = 220, time = false, select = null, log = false, sync = null, marks = null } = {}) {
    const options = {
      width: Math.max(place.clientWidth, 240), height,
      scales: { x: { time: false }, y: log ? { distr: 3 } : {} },
      axes: [axis(x), axis(y, log ? { size: 62, values: (_, splits) => splits.map(powers) } : { size: 62 })],
      series: [{ label: x, value: (_, value) => number(value) }, ...series.map((one) => ({
        label: one.label, stroke: () => colour(one.colour), width: one.width ?? 1.4, dash: one.dash, spanGaps: false,
        points: { show: false }, value: (_, value) => number(value), show: one.show ?? true,
      }))],
      bands: series.flatMap((one, k) => (one.band ? [{ series: [k + 1, k + 2], fill: () => `color-mix(in srgb, ${colour(one.colour)} 35%, transparent)` }] : [])),
      cursor: { drag: { x: true, y: false, setScale: !select }, sync: sync ? { key: sync } : undefined },
      hooks: {
        setSelect: select ? [(self) => {
          if (self.select.width < 4) return;
          const from = self.posToVal(self.select.left, "x"), to = self.posToVal(self.select.left + self.select.width, "x");
          self.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          select(from, to);
        }] : [],
        draw: marks ? [(self) => {
          const pen = self.ctx;
          pen.save();
          pen.fillStyle = `color-mix(in srgb, ${colour("red")} 22%, transparent)`;
          for (const { start, end } of marks()) {
            const left = self.valToPos(start, "x", true), right = Math.max(self.valToPos(end, "x", true), left + 2);
            if (right < self.bbox.left || left > self.bbox.left + self.bbox.width) continue;
            pen.fillRect(left, self.bbox.top, right - left, self.bbox.height);
          }
          pen.restore();
        }] : [],
      },
    };
    const chart = new uPlot(options, data, place);
    made.add([chart, place]);
    return chart;
  }

  let late = 0;
  addEventListener("resize", () => {
    clearTimeout(late);
    late = setTimeout(() => { for (const [chart, place] of made) if (place.isConnected && place.clientWidth) chart.setSize({ width: place.clientWidth, height: chart.height }); }, 120);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { for (const [chart] of made) chart.redraw(); });
  return { plot, NAMES, number, colour };
})();
