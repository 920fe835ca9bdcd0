// Laws side by side: one request in flight, curves of all laws in one plot for each quantity.
"use strict";
(() => {
  const { $, newest, post, command, links } = studio;
  const asked = $("asked");
  const state = new URLSearchParams([...new URLSearchParams(location.search)].filter(([name]) => name === "drive" || name === "set"));
  let charts = {}, shape = "";

  function query() {
    const all = new URLSearchParams(state);
    for (const [name, value] of new FormData(asked)) if (value) all.append(name, value);
    return all;
  }

  const send = newest((found) => {
    $("asked-refusal").textContent = found.refusal ?? "";
    $("asked-refusal").hidden = !found.refusal;
    if (found.refusal) { $("figures").tBodies[0].replaceChildren(); return; }
    $("best").textContent = found.none_here ?? $("best").textContent;
    if (found.none_here) { for (const id of ["figures", "error", "torque", "spectrum"]) $(id).hidden = true; return; }
    command(found.command);
    links(found.query);
    table(found.rows);
    $("notes").replaceChildren(...[...found.refused, ...found.rows.filter((row) => row.incomplete).map((row) => `${row.law}: ${row.incomplete}`)].map((words) => {
      const note = document.createElement("p");
      note.className = "problem";
      note.textContent = words;
      return note;
    }), ...found.rows.flatMap((row) => row.reasons).map((words) => {
      const why = document.createElement("p");
      why.className = "hint";
      why.textContent = words;
      return why;
    }));
    draw(found.curves);
  });

  function table(rows) {
    const number = (value) => (value === null || value === undefined ? "none" : curves.number(value));
    $("figures").tBodies[0].replaceChildren(...rows.map((row, k) => {
      const line = document.createElement("tr");
      const kept = { true: "yes", false: "no" }[String(row.within_bound)] ?? "assumptions do not hold";
      const cells = [row.law, number(row.bandwidth_hz), number(row.peak_error_deg), number(row.rms_error_deg), number(row.peak_torque), number(100 * row.saturated_fraction), number(row.theory_bound_deg), kept];
      cells.forEach((words, i) => {
        const cell = line.insertCell();
        cell.textContent = words;
        if (i > 0 && i < 7) cell.className = "numeric";
        if (i === 0) { cell.style.color = `var(--${curves.NAMES[k % 6]})`; cell.style.fontWeight = "600"; }
      });
      return line;
    }));
  }

  // laws of one motion have one time, thinned at different instants: put onto one axis
  function joined(runs, along, key) {
    const tables = runs.map((run) => [run[along], run[key]]);
    return tables.length > 1 ? uPlot.join(tables) : tables[0] ?? [[], []];
  }
  function draw(runs) {
    const names = runs.map((run) => run.name);
    const bounded = runs.filter((run) => run.bound.length);
    const series = names.map((label, k) => ({ label, colour: curves.NAMES[k % 6] }));
    const errors = [...runs.map((run) => ({ ...run, shown: run.error })), ...bounded.map((run) => ({ ...run, shown: run.bound }))];
    const all = {
      error: [joined(errors, "time", "shown"), [...series, ...bounded.map((run) => ({ label: `bound, ${run.name}`, colour: "quiet", dash: [5, 4] }))], { x: "time [s]", y: "deg" }],
      torque: [joined(runs, "time", "torque"), series, { x: "time [s]", y: "N m" }],
      spectrum: [joined(runs, "frequency", "amplitude"), series, { x: "frequency [Hz]", y: "deg", log: true }],
    };
    const now = JSON.stringify([names, bounded.map((run) => run.name), $("error").clientWidth]);
    for (const [name, [data, lines, options]] of Object.entries(all)) {
      if (now === shape) { charts[name].setData(data); continue; }
      $(name).replaceChildren();
      if (runs.length) charts[name] = curves.plot($(name), data, lines, { ...options, height: 210 });
    }
    shape = runs.length ? now : "";
    if (!runs.length) {
      const words = document.createElement("p");
      words.className = "empty";
      words.textContent = "No law could be run: the lines above say why.";
      $("error").replaceChildren(words);
    }
  }

  function update(kept) {
    const all = query();
    const address = `/control?${all}`;
    if (kept) history.pushState(null, "", address); else history.replaceState(null, "", address);
    send(`/control/part?${all}`);
  }
  asked.addEventListener("submit", (event) => event.preventDefault());
  asked.addEventListener("change", (event) => {
    for (const row of asked.querySelectorAll("[data-law]")) row.hidden = !asked.querySelector(`[name=law][value="${row.dataset.law}"]`).checked;
    if (!event.target.dataset.slides) update(true);
  });
  for (const slider of asked.querySelectorAll("[data-slides]")) {
    const field = $(slider.dataset.slides);
    const place = () => { slider.value = String(Number.parseFloat(field.value) || 30); };
    place();
    field.addEventListener("change", place);
    slider.addEventListener("input", () => { field.value = `${slider.value} Hz`; update(false); });
  }
  addEventListener("popstate", () => location.reload());
  send(`/control/part?${query()}`);
  $("best").textContent = "Which law compare would take is being computed.";
  fetch(`/control/best?${query()}`).then((answer) => answer.json()).then((found) => { $("best").textContent = found.words; });

  for (const kind of ["compare", "controlled", "film"]) {
    $(kind).addEventListener("submit", async (event) => {
      event.preventDefault();
      const fields = new URLSearchParams(new FormData($(kind)));
      if (kind === "controlled") {
        for (const [name, value] of query()) if (!["drive", "set", "law", "plant"].includes(name) && value) fields.set(name, value);
        fields.set("bandwidth", $(`b-${fields.get("film-law")}`).value || $("bandwidth").value);
      }
      if (kind === "compare") for (const box of asked.querySelectorAll("[name=law]:checked")) fields.set(`law-${box.value}`, "1");
      const found = await post(`/studies/start/${kind}?${state}`, fields);
      if (found.number) location.href = `/studies/${found.number}?${state}`;
      $(`${kind}-refusal`).textContent = found.refusal ?? "";
      $(`${kind}-refusal`).hidden = !found.refusal;
    });
  }
})();
