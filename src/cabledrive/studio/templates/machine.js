// The machine: sliders and fields, the text beside them, the mode in motion, what the last change moved.
"use strict";
(() => {
  const { $, newest, post, command, links, keys } = studio;
  const fields = [...document.querySelectorAll("[data-key]")];
  const sliders = [...document.querySelectorAll("[data-slider]")];
  const result = $("result"), trail = $("trail");
  const drive = $("drive").dataset.current;
  const byKey = new Map(fields.map((field) => [field.dataset.key, field]));
  let frequencies = [], past = [];

  // ---- the state as an address
  function query() {
    const parts = new URLSearchParams({ drive });
    for (const field of fields) {
      const changed = field.value.trim() !== field.dataset.base;
      field.toggleAttribute("data-changed", changed);
      if (changed) parts.append("set", `${field.dataset.key}=${field.value.trim()}`);
    }
    const state = parts.toString();
    if ($("motor").value) parts.set("motor", $("motor").value);
    parts.set("count", $("count").value || "8");
    parts.set("row", result.dataset.row);
    return { all: parts.toString(), state };
  }

  function refuse(words, key) {
    for (const one of document.querySelectorAll(".field .refusal")) { one.hidden = true; one.textContent = ""; }
    for (const field of fields) field.removeAttribute("aria-invalid");
    const field = byKey.get(key);
    const place = field ? $(`f-${key}-r`) : $("problem");
    if (!field || !words) { $("problem").hidden = !words; $("problem").textContent = words || ""; }
    if (field && words) {
      place.textContent = words;
      place.hidden = false;
      field.setAttribute("aria-invalid", "true");
      field.closest("details").open = true;
      $("problem").hidden = true;
    }
    result.classList.toggle("old", Boolean(words));
  }

  const send = newest((found, address, stale) => {
    if (found.refusal) { refuse(found.refusal, found.key); return; }
    refuse("", "");
    result.innerHTML = found.part; // escaped by the server
    result.dataset.shown = address;
    command(found.command);
    links(found.query);
    if (document.activeElement !== $("text")) $("text").value = found.text;
    $("title").textContent = found.title;
    remember(found.frequencies);
    animate();
  });

  function update(kept) {
    const { all } = query();
    const address = `/machine?${all}`;
    if (kept) history.pushState(null, "", address); else history.replaceState(history.state, "", address);
    send(`/machine/part?${all}`);
  }

  // ---- fields and sliders: a slider goes from a quarter to four times the value of the text
  const digits = (value) => String(Number(value.toPrecision(4)));
  let before = "";
  for (const slider of sliders) {
    const { number, unit } = slider.dataset, field = byKey.get(slider.dataset.slider);
    const place = () => {
      const value = Number.parseFloat(field.value);
      const ratio = value / Number(number);
      const sameUnit = field.value.replace(/^\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*/, "").trim() === unit;
      slider.value = sameUnit && ratio > 0 ? String(Math.round(100 * Math.log(ratio) / Math.log(4))) : "0";
    };
    place();
    field.addEventListener("change", place);
    slider.addEventListener("input", () => {
      if (!before) before = location.href;
      const value = Number(number) * 4 ** (slider.value / 100);
      field.value = slider.value === "0" ? field.dataset.base : `${digits(value)}${unit ? ` ${unit}` : ""}`;
      update(false);
    });
    slider.addEventListener("change", () => { // one step of undo for one movement of the hand
      if (!before) return;
      const now = location.href;
      history.replaceState(null, "", before);
      history.pushState(null, "", now);
      before = "";
    });
  }
  for (const field of fields) field.addEventListener("change", () => update(true));
  $("quantities").addEventListener("submit", (event) => event.preventDefault());
  $("open").addEventListener("submit", (event) => event.preventDefault());
  $("motor").addEventListener("change", () => { result.dataset.row = "0"; update(true); });
  $("count").addEventListener("change", () => update(true));
  $("undo").addEventListener("click", () => history.back());
  $("reset").addEventListener("click", () => {
    for (const field of fields) field.value = field.dataset.base;
    for (const slider of sliders) slider.value = "0";
    update(true);
  });
  addEventListener("popstate", () => location.reload());

  // ---- open, drop, text
  $("drive").addEventListener("change", () => { location.href = `/machine?${new URLSearchParams({ drive: $("drive").value })}`; });
  async function take(text) {
    const found = await post("/machine/text", text, { "content-type": "text/plain" });
    $("text-refusal").textContent = found.refusal ?? "";
    $("text-refusal").hidden = !found.refusal;
    $("text").toggleAttribute("aria-invalid", Boolean(found.refusal));
    if (found.query) location.href = `/machine?${found.query}`;
    return found;
  }
  $("apply").addEventListener("click", () => take($("text").value));
  async function takeFile(file) {
    const found = file.size > 4e6 ? { refusal: `${file.name}: larger than 4 MB: is it a drive file?` } : await take(await file.text());
    if (found.refusal) refuse(found.refusal.startsWith(file.name) ? found.refusal : `${file.name}: ${found.refusal}`, "");
  }
  $("file").addEventListener("change", () => { if ($("file").files[0]) takeFile($("file").files[0]); });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files[0]) takeFile(event.dataTransfer.files[0]);
  });
  $("save").addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([$("text").value], { type: "application/toml" }));
    link.download = `${drive}.toml`;
    link.click();
    URL.revokeObjectURL(link.href);
  });

  // ---- choose a mode
  function choose(row) {
    result.dataset.row = String(Math.max(0, row));
    update(true);
  }
  result.addEventListener("click", (event) => {
    const rung = event.target.closest("[data-row]");
    if (rung && rung !== result) choose(Number(rung.dataset.row));
  });
  const rows = () => document.querySelectorAll(".pick").length;
  keys.j = () => choose((Number(result.dataset.row) + 1) % Math.max(rows(), 1));
  keys.k = () => choose((Number(result.dataset.row) + rows() - 1) % Math.max(rows(), 1));

  // ---- the mode in motion
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let playing = !still.matches, drawn = [];
  const SVG = "http://www.w3.org/2000/svg";
  function animate() {
    drawn = [...result.querySelectorAll("svg[data-motion]")].filter((svg) => svg.dataset.motion).map((svg) => {
      const group = svg.appendChild(document.createElementNS(SVG, "g"));
      group.setAttribute("class", "moving");
      return { svg, group, motion: JSON.parse(svg.dataset.motion), parts: null };
    });
    frame(performance.now());
  }
  function partsOf({ group, motion }) {
    const put = (name, attributes = {}) => {
      const one = group.appendChild(document.createElementNS(SVG, name));
      for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
      return one;
    };
    return {
      spans: motion.spans.map((span) => motion.across ? put("path") : span.points.filter((_, k) => k % 4 === 2).map(() => put("circle", { r: 2.6 }))),
      spokes: motion.pulleys.map(() => put("path")),
    };
  }
  function frame(now) {
    const swing = playing ? Math.sin(2 * Math.PI * now / 1600) : 1;
    for (const one of drawn) {
      if (one.svg.getBoundingClientRect().width === 0) continue;
      one.parts ??= partsOf(one);
      one.motion.spans.forEach(({ points, moved }, k) => {
        const at = points.map(([x, y], i) => [x + swing * moved[i][0], y + swing * moved[i][1]]);
        if (one.motion.across) one.parts.spans[k].setAttribute("d", `M${at.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}`);
        else one.parts.spans[k].forEach((dot, j) => { const [x, y] = at[4 * j + 2]; dot.setAttribute("cx", x.toFixed(1)); dot.setAttribute("cy", y.toFixed(1)); });
      });
      one.motion.pulleys.forEach(({ centre: [x, y], radius, turn }, k) => {
        const angle = swing * turn, arm = Math.max(radius - 2.5, 0);
        one.parts.spokes[k].setAttribute("d", `M${x} ${y}L${(x + arm * Math.sin(angle)).toFixed(1)} ${(y - arm * Math.cos(angle)).toFixed(1)}`);
      });
    }
  }
  function run(now) {
    if (playing && !document.hidden) frame(now);
    requestAnimationFrame(run);
  }
  function play(on) {
    playing = on;
    $("play").textContent = on ? "Stop" : "Play";
    $("play").setAttribute("aria-pressed", String(on));
    frame(performance.now());
  }
  $("play").addEventListener("click", () => play(!playing));
  keys.p = () => play(!playing);

  // ---- what the last change moved: frequencies over ten seconds
  function remember(found) {
    const now = performance.now();
    past = [...past, [now, found]].filter(([time]) => now - time < 10000);
    frequencies = found;
    drawTrail(now);
  }
  function drawTrail(now) {
    const count = Math.min(...past.map(([, found]) => found.length));
    if (past.length < 2 || !count) return;
    const first = past[0][1], last = past[past.length - 1][1];
    const lines = [];
    for (let k = 0; k < count; k++) {
      const change = last[k][1] / first[k][1] - 1;
      lines.push({ k, kind: last[k][0], change, points: past.map(([time, found]) => [time, found[k][1] / first[k][1] - 1]) });
    }
    const most = Math.max(0.001, ...lines.flatMap((line) => line.points.map(([, change]) => Math.abs(change))));
    const W = 720, H = 150, x = (time) => 60 + 520 * (1 - (now - time) / 10000), y = (change) => H / 2 - 58 * change / most;
    const percent = (value) => `${value > 0 ? "+" : value < 0 ? "−" : ""}${Math.abs(100 * value).toPrecision(2)} %`;
    let content = `<path d="M60 ${H / 2}H580" stroke="var(--line)"/><text x="54" y="${H / 2 + 4}" text-anchor="end">0</text><text x="54" y="${y(most) + 4}" text-anchor="end">${percent(most)}</text><text x="54" y="${y(-most) + 4}" text-anchor="end">${percent(-most)}</text>`;
    for (const line of lines) {
      const path = line.points.map(([time, change], i) => `${i ? "L" : "M"}${x(time).toFixed(1)} ${y(change).toFixed(1)}`).join("");
      content += `<path d="${path}" fill="none" stroke="var(--${line.kind === "longitudinal" ? "blue" : "orange"})" stroke-width="1.4"/>`;
    }
    const ends = [...lines].sort((a, b) => Math.abs(b.change) - Math.abs(a.change)).slice(0, 1);
    for (const line of ends) content += `<text x="588" y="${y(line.change) + 4}">${Number(last[line.k][1].toPrecision(5))} Hz, ${percent(line.change)}</text>`;
    content += `<text x="60" y="${H - 2}">10 s ago</text><text x="580" y="${H - 2}" text-anchor="end">now</text>`;
    trail.innerHTML = `<svg viewBox="0 0 ${W} ${H}" role="img" aria-label="Change of every listed frequency over the last ten seconds">${content}</svg>`;
    $("trail-words").textContent = "Change of every listed frequency against ten seconds ago; blue longitudinal, orange transverse.";
  }

  const first = JSON.parse($("first").textContent);
  for (const field of fields) field.toggleAttribute("data-changed", field.value.trim() !== field.dataset.base);
  frequencies = first.frequencies;
  past = [[performance.now(), frequencies]];
  refuse(first.refusal, first.key);
  play(playing);
  animate();
  requestAnimationFrame(run);
})();
